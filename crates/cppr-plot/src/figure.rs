//! The figure as data: panels, axes, series, annotations. Nothing here knows pixels except widths and
//! sizes, which are CSS pixels (1/96 inch); a figure of the default width of 680 px prints at 180 mm, the
//! text width of a two-column journal.
//!
//! Labels, names and texts may carry `_{…}` and `^{…}` for subscripts and superscripts.

use crate::error::PlotError;
use crate::palette::Colour;
use crate::{draw, raster, svg};

/// One or more panels in a grid, with one legend for all of them above the panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Short title; may be empty.
    pub title: String,
    /// Panels, row by row from the top left.
    pub panels: Vec<Panel>,
    /// Number of columns of the grid; 0 counts as 1.
    pub columns: usize,
    /// Largest width in px. Figures with equal scales may come out narrower.
    pub max_width: f64,
    /// Largest height in px that panels with equal scales may grow to.
    pub max_height: f64,
    /// Whether the legend is drawn.
    pub legend: bool,
    /// Legend entries that no series stands for; they come first.
    pub keys: Vec<Key>,
    /// Colour bar below the panels.
    pub bar: Option<ColourBar>,
}

/// What colours stand for: the shades of [`ramp`](crate::ramp) over a range of values.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourBar {
    /// Quantity and unit.
    pub axis: Axis,
    /// Values of the first and last shade's outer ends.
    pub range: [f64; 2],
    /// Number of shades.
    pub shades: usize,
}

impl Default for Figure {
    fn default() -> Self {
        Self {
            title: String::new(),
            panels: Vec::new(),
            columns: 1,
            max_width: 680.0,
            max_height: 640.0,
            legend: true,
            keys: Vec::new(),
            bar: None,
        }
    }
}

impl Figure {
    /// The figure as a standalone SVG document.
    ///
    /// # Errors
    /// See [`PlotError`]: nothing to draw, values that are not finite, ranges without extent.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        Ok(svg::write(&draw::scene(self)?))
    }

    /// The figure as a PNG file, `scale` image pixels to one CSS pixel (2 for screens, 4 for print at
    /// 384 dots per inch).
    ///
    /// # Errors
    /// As [`Figure::to_svg`], and [`PlotError::ImageSize`] where a side would be empty or longer than
    /// 16384 pixels.
    pub fn to_png(&self, scale: f64) -> Result<Vec<u8>, PlotError> {
        let scene = draw::scene(self)?;
        raster::png(&svg::write(&scene), [scene.width, scene.height], scale)
    }

    /// Width and height in px that the figure takes.
    ///
    /// # Errors
    /// As [`Figure::to_svg`].
    pub fn size(&self) -> Result<[f64; 2], PlotError> {
        let scene = draw::scene(self)?;
        Ok([scene.width, scene.height])
    }
}

/// One pair of axes with what is drawn in it.
#[allow(clippy::struct_excessive_bools, reason = "independent switches of one drawing")]
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Short heading above the panel; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// One unit takes as many pixels upwards as sideways. Such panels of a figure share one scale.
    pub equal: bool,
    /// With `equal`: fit the cell of the grid at a scale of its own, not the figure's.
    pub own_scale: bool,
    /// Frame, ticks and axis labels are drawn.
    pub framed: bool,
    /// Height of the plot area in px; panels with equal scale find their own.
    pub height: f64,
    /// Lines and markers, later ones above earlier ones.
    pub series: Vec<Series>,
    /// Arrows and texts, above all series.
    pub annotations: Vec<Annotation>,
}

impl Panel {
    /// An empty framed panel of the given axes.
    #[must_use]
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            equal: false,
            own_scale: false,
            framed: true,
            height: 300.0,
            series: Vec::new(),
            annotations: Vec::new(),
        }
    }
}

/// An axis. Ticks are chosen at round numbers.
#[allow(clippy::struct_excessive_bools, reason = "independent switches of one drawing")]
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity, for example `actuation Δa`.
    pub label: String,
    /// Unit, set in parentheses behind the label; empty for a pure number.
    pub unit: String,
    /// Ends of the axis; without it they follow the data. Lines are cut at the ends. In a panel of equal
    /// scale this is the least that is shown.
    pub range: Option<[f64; 2]>,
    /// Draw a line where this coordinate is zero.
    pub zero_line: bool,
    /// Draw grid lines at the ticks of this axis.
    pub grid: bool,
    /// Print numbers and label (off for the upper ones of stacked panels).
    pub labelled: bool,
    /// End the axis exactly at the data, without a margin.
    pub tight: bool,
    /// Let the axis reach zero even where the data does not.
    pub include_zero: bool,
}

impl Axis {
    /// An axis with grid, whose ends follow the data.
    #[must_use]
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            range: None,
            zero_line: false,
            grid: true,
            labelled: true,
            tight: false,
            include_zero: false,
        }
    }

    /// The same axis with a line at zero.
    #[must_use]
    pub fn with_zero_line(mut self) -> Self {
        self.zero_line = true;
        self
    }

    /// The same axis with prescribed ends.
    #[must_use]
    pub fn with_range(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }
}

/// A polyline, a set of marks, or both.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Legend entry; empty for none. Series of the same name share one entry, drawn like the first.
    pub name: String,
    /// Points in the units of the axes.
    pub points: Vec<[f64; 2]>,
    /// Line through the points.
    pub line: Option<Stroke>,
    /// Mark at every point.
    pub marker: Option<Marker>,
    /// Filled area.
    pub fill: Option<Fill>,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub colour: Colour,
    /// Width in px.
    pub width: f64,
    /// Pattern.
    pub dash: Dash,
}

/// Pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Medium dashes.
    Dashed,
    /// Dash and dot: the drawing convention for centrelines.
    DashDot,
    /// Long dashes.
    LongDash,
    /// Dots.
    Dotted,
    /// Dash and two dots.
    DashDotDot,
}

impl Dash {
    /// Lengths of dashes and gaps in multiples of the line width; empty for an unbroken line.
    pub(crate) fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[3.6, 1.6],
            Self::DashDot => &[4.5, 1.5, 1.0, 1.5],
            Self::LongDash => &[7.0, 2.0],
            Self::Dotted => &[1.0, 1.2],
            Self::DashDotDot => &[4.5, 1.3, 1.0, 1.3, 1.0, 1.3],
        }
    }
}

/// A mark at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// Form.
    pub shape: MarkerShape,
    /// Diameter in px.
    pub size: f64,
    /// Colour of the outline, and of the inside if filled.
    pub colour: Colour,
    /// Filled with its colour, otherwise with white.
    pub filled: bool,
}

/// Form of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkerShape {
    /// ○
    Circle,
    /// □
    Square,
    /// △
    Triangle,
    /// ◇
    Diamond,
    /// ×
    Cross,
    /// A small filled disc; many of them are cheap.
    Dot,
    /// ⊙: an arrow that points at the reader.
    Towards,
    /// ⊗: an arrow that points away from the reader.
    Away,
}

/// A filled area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fill {
    /// Colour.
    pub colour: Colour,
    /// 0 clear to 1 opaque.
    pub opacity: f64,
    /// Fill down (or up) to this y; without it the polyline is closed and its inside filled.
    pub to_y: Option<f64>,
}

/// What is drawn above the series.
#[derive(Debug, Clone, PartialEq)]
pub enum Annotation {
    /// A straight arrow.
    Arrow {
        /// Legend entry; empty for none.
        name: String,
        /// Tail, in the units of the axes.
        from: [f64; 2],
        /// Head, in the units of the axes.
        to: [f64; 2],
        /// Line; the head takes its colour.
        stroke: Stroke,
    },
    /// A text beside a point.
    Text {
        /// The point, in the units of the axes.
        at: [f64; 2],
        /// The text.
        text: String,
        /// Direction in which the text stands off from the point (x right, y up; zero centres it).
        towards: [f64; 2],
        /// Font size in px.
        size: f64,
        /// Colour.
        colour: Colour,
        /// Look for a place near the point where the text covers neither lines nor other texts.
        avoid: bool,
    },
}

/// A legend entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: String,
    /// Line shown.
    pub line: Option<Stroke>,
    /// Mark shown.
    pub marker: Option<Marker>,
    /// Area shown.
    pub fill: Option<Fill>,
    /// Show the line as an arrow.
    pub arrow: bool,
}
