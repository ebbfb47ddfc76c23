//! The figure in px, x to the right and y down, as few kinds of marks as possible: what the writer
//! of SVG has to know.

use crate::palette::Colour;

/// A drawing in px.
#[derive(Debug, Default)]
pub(crate) struct Scene {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) title: String,
    pub(crate) items: Vec<Item>,
}

#[derive(Debug)]
pub(crate) enum Item {
    /// Begins a group.
    Open {
        class: &'static str,
    },
    /// Ends the innermost group.
    Close,
    Path(Path),
    /// Discs of one size and colour.
    Dots {
        points: Vec<[f64; 2]>,
        size: f64,
        colour: Colour,
    },
    Text(Text),
}

/// A polyline or polygon.
#[derive(Debug, Clone, Default)]
pub(crate) struct Path {
    pub(crate) class: &'static str,
    /// Name of the series; becomes an attribute in SVG.
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) closed: bool,
    pub(crate) pen: Option<Pen>,
    pub(crate) fill: Option<(Colour, f64)>,
}

#[derive(Debug, Clone)]
pub(crate) struct Pen {
    pub(crate) colour: Colour,
    pub(crate) width: f64,
    /// Dashes and gaps in px.
    pub(crate) dash: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of text; `at` lies on the baseline.
#[derive(Debug, Clone)]
pub(crate) struct Text {
    pub(crate) at: [f64; 2],
    pub(crate) content: String,
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    pub(crate) colour: Colour,
    /// Reads upwards.
    pub(crate) upwards: bool,
    /// White rim that keeps the text apart from lines below it.
    pub(crate) rim: bool,
}

impl Scene {
    pub(crate) fn path(&mut self, path: Path) {
        self.items.push(Item::Path(path));
    }

    /// A thin line.
    pub(crate) fn line(&mut self, class: &'static str, points: &[[f64; 2]], colour: Colour, width: f64) {
        self.path(Path {
            class,
            points: points.to_vec(),
            pen: Some(Pen { colour, width, dash: Vec::new() }),
            ..Path::default()
        });
    }

    /// A text in ink whose middle height lies at `at`.
    pub(crate) fn label(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor) {
        self.items.push(Item::Text(Text {
            at: [at[0], at[1] + MIDDLE * size],
            content: text.to_owned(),
            size,
            anchor,
            colour: Colour::INK,
            upwards: false,
            rim: false,
        }));
    }
}

/// Half the height of a capital in ems: from the baseline to the middle of a line of text.
pub(crate) const MIDDLE: f64 = 0.357;
