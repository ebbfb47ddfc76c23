//! Figures of concentric push-pull robots, as SVG and PNG.
//!
//! A [`Figure`] is plain data: panels with axes, series and annotations. Four functions make the usual
//! ones: [`shape_figure`] (poses of a robot, equal axes in mm), [`profile_figure`] (quantities along
//! the robot, panels stacked over one axis) [`xy_figure`] (one quantity against another, stable and
//! unstable branches apart) and [`cloud_figure`] (tip positions coloured by a quantity). [`Figure::to_svg`] and [`Figure::to_png`] write them; nothing here touches
//! files, clocks or installed fonts, and the same figure gives the same bytes (pixels of one figure may differ by rounding between
//! kinds of processor).
//!
//! Figures from different functions combine: their panels can be moved into one [`Figure`].
//!
//! ```
//! use cppr_plot::{Axis, XyCurve, XyInput, xy_figure};
//!
//! # fn main() -> Result<(), cppr_plot::PlotError> {
//! let curve = XyCurve::new("R3", vec![[0.0, 0.0], [2.0, 1.1], [5.0, 2.9]]);
//! let figure = xy_figure(&XyInput {
//!     title: String::new(),
//!     x: Axis::new("pull Δa", "mm"),
//!     y: Axis::new("effort", "N"),
//!     curves: vec![curve],
//! })?;
//! assert!(figure.to_svg()?.contains("pull Δa (mm)"));
//! # Ok(())
//! # }
//! ```
//!
//! The PNG is the SVG as resvg draws it, its text in Noto Sans (SIL Open Font License 1.1, from the crate `notosans`), which is
//! embedded (licence text: `LICENSE-OFL-NotoSans.txt`); SVG text names it first, then falls back to any sans-serif face.

mod cloud;
mod draw;
mod error;
mod figure;
mod font;
mod labels;
mod layout;
mod legend;
mod palette;
mod pose;
mod profile;
mod range;
mod raster;
mod scene;
mod shape;
mod space;
mod svg;
mod thin;
mod ticks;
mod xy;

pub use cloud::{Cloud, CloudInput, cloud_figure};
pub use error::PlotError;
pub use figure::{
    Annotation, Axis, ColourBar, Dash, Figure, Fill, Key, Marker, MarkerShape, Panel, Series, Stroke,
};
pub use palette::{Colour, ramp, tube_stroke};
pub use pose::{Colouring, Force, Line, Marks, Part, Pose, ShapeInput};
pub use profile::{ProfileCurve, ProfileInput, Quantity, profile_figure};
pub use shape::shape_figure;
pub use xy::{XyCurve, XyInput, xy_figure};
