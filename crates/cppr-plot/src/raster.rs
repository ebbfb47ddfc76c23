//! Pixels of the SVG document, by resvg with the embedded font alone: the fonts that are installed do not matter.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use crate::error::PlotError;

const LARGEST_SIDE: f64 = 16_384.0;

/// The PNG file of a document of the given size in px, `scale` image pixels per px.
pub(crate) fn png(svg: &str, size: [f64; 2], scale: f64) -> Result<Vec<u8>, PlotError> {
    let [width, height] = size.map(|side| (side * scale).round());
    let fits = |side: f64| (1.0..=LARGEST_SIDE).contains(&side);
    if !fits(width) || !fits(height) {
        return Err(PlotError::ImageSize { width, height });
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole numbers from 1 to 16384"
    )]
    let (columns, rows) = (width as u32, height as u32);
    let mut options = Options::default();
    options.fontdb_mut().load_font_data(notosans::REGULAR_TTF.to_vec());
    let tree = Tree::from_str(svg, &options).map_err(|_| PlotError::Encode)?;
    let mut map = Pixmap::new(columns, rows).ok_or(PlotError::ImageSize { width, height })?;
    #[allow(clippy::cast_possible_truncation, reason = "a factor; its last digits are no pixel")]
    let zoom = Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, zoom, &mut map.as_mut());
    map.encode_png().map_err(|_| PlotError::Encode)
}
