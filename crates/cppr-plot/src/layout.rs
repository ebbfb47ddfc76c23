//! Places panels, title and legend.
//!
//! Margins depend on the width of tick labels, ticks on the size of the panel, and that on the margins: a
//! few rounds settle it. Panels of equal scale share one number of px per unit, the largest that fits; the
//! ranges of their axes then grow until they fill the cells of the grid.

use crate::error::PlotError;
use crate::figure::{Axis, ColourBar, Figure, Fill, Key, Panel, Series};
use crate::font::Font;
use crate::legend;
use crate::range::{around, panel_range};
use crate::thin::Rect;
use crate::ticks::{Ticks, count, nice_step, ticks, ticks_at};

pub(crate) const TICK: f64 = 11.5;
pub(crate) const LABEL: f64 = 12.5;
pub(crate) const TITLE: f64 = 15.0;
pub(crate) const HEADING: f64 = 12.5;
/// Height of a line of text relative to its size.
pub(crate) const LINE: f64 = 1.35;

const ROUNDS: usize = 4;
/// Least extent of a panel of equal scale, else a straight robot would be drawn in a slit.
const LEAST: [f64; 2] = [130.0, 100.0];
const EDGE: f64 = 8.0;
/// Height of a colour bar.
const BAR: f64 = 12.0;
/// Size, relative to the figure's scale, that a panel with its own scale asks for: it must not
/// blow up the cells of its neighbours.
const OWN_SCALE: f64 = 0.75;

/// A placed panel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Placed {
    pub(crate) frame: Rect,
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
    pub(crate) x_ticks: Ticks,
    pub(crate) y_ticks: Ticks,
    pub(crate) y_label: Vec<String>,
    /// Widest tick label of the vertical axis, in px.
    pub(crate) y_tick_width: f64,
}

impl Placed {
    /// Position in px of a point in the units of the axes.
    pub(crate) fn map(&self, p: [f64; 2]) -> [f64; 2] {
        let f = &self.frame;
        [
            f.x + (p[0] - self.x[0]) / (self.x[1] - self.x[0]) * f.w,
            f.y + (self.y[1] - p[1]) / (self.y[1] - self.y[0]) * f.h,
        ]
    }
}

/// Where everything goes.
#[derive(Debug)]
pub(crate) struct Layout {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) title: Vec<String>,
    /// Entries with their left end and middle height.
    pub(crate) legend: Vec<(Key, [f64; 2])>,
    pub(crate) panels: Vec<Placed>,
    pub(crate) bar: Option<(Panel, Placed)>,
}

struct Margins {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Checks the figure and places its parts.
pub(crate) fn place(figure: &Figure, font: &Font) -> Result<Layout, PlotError> {
    if figure.panels.is_empty() {
        return Err(PlotError::Empty { what: "the list of panels".to_owned() });
    }
    let columns = figure.columns.clamp(1, figure.panels.len());
    let rows = figure.panels.len().div_ceil(columns);
    let mut ranges = Vec::with_capacity(figure.panels.len());
    for panel in &figure.panels {
        ranges.push(panel_range(panel)?);
    }
    let bounds = [clamp_size(figure.max_width), clamp_size(figure.max_height)];

    let mut placed: Vec<Placed> = ranges
        .iter()
        .zip(&figure.panels)
        .map(|(r, panel)| {
            let frame = Rect { x: 0.0, y: 0.0, w: bounds[0] / count(columns), h: panel.height };
            fill_cell(panel, *r, frame, font)
        })
        .collect();
    let mut body = [0.0, 0.0];
    for _ in 0..ROUNDS {
        body = round(figure, font, &ranges, [columns, rows], bounds, &mut placed);
    }

    let keys = legend::keys(figure);
    let widest = keys.iter().map(|k| legend::entry_width(font, k)).fold(0.0, f64::max);
    let width = body[0].max(widest + 2.0 * EDGE).max((260.0_f64).min(bounds[0]));
    let title = font.wrap(&figure.title, TITLE, width - 2.0 * EDGE);
    let mut top = EDGE + count(title.len()) * TITLE * LINE;
    if !title.is_empty() {
        top += 2.0;
    }
    let (legend, depth) = legend::place(font, &keys, width - 2.0 * EDGE, [0.5 * width, top]);
    let shift = [0.5 * (width - body[0]), top + depth];
    for p in &mut placed {
        p.frame.x += shift[0];
        p.frame.y += shift[1];
    }
    let bar = figure.bar.as_ref().map(|bar| place_bar(bar, width, shift[1] + body[1]));
    let below = if bar.is_some() { BAR + 14.0 + (TICK + LABEL) * LINE } else { 0.0 };
    Ok(Layout {
        width: width.ceil(),
        height: (shift[1] + body[1] + below + 2.0).ceil(),
        bar,
        title,
        legend,
        panels: placed,
    })
}

/// The colour bar as a low panel without vertical axis, below all others.
fn place_bar(bar: &ColourBar, width: f64, top: f64) -> (Panel, Placed) {
    let mut panel = Panel::new(Axis { grid: false, ..bar.axis.clone() }, Axis::new("", ""));
    (panel.y.grid, panel.y.labelled) = (false, false);
    let [low, high] = bar.range;
    let end = |shade: usize| low + (high - low) * count(shade) / count(bar.shades);
    for shade in 0..bar.shades {
        let [a, b] = [end(shade), end(shade + 1)];
        panel.series.push(Series {
            points: vec![[a, 0.0], [b, 0.0], [b, 1.0], [a, 1.0]],
            fill: Some(Fill { colour: bar.colour(shade), opacity: 1.0, to_y: None }),
            ..Series::default()
        });
    }
    let frame = Rect { x: 0.2 * width, y: top + 4.0, w: 0.6 * width, h: BAR };
    let x_ticks = ticks(low, high, (frame.w / 70.0).max(4.0));
    (panel, Placed { frame, x: bar.range, y: [0.0, 1.0], x_ticks, ..Placed::default() })
}

/// One round of settling: margins from the present ticks, then cells, ranges and ticks anew. Returns the
/// extent of the grid of panels.
fn round(
    figure: &Figure,
    font: &Font,
    ranges: &[[[f64; 2]; 2]],
    [columns, rows]: [usize; 2],
    bounds: [f64; 2],
    placed: &mut [Placed],
) -> [f64; 2] {
    let panels = &figure.panels;
    let margins: Vec<Margins> = panels.iter().zip(placed.iter()).map(|(p, b)| margins(p, b, font)).collect();
    let widest =
        |c: usize, f: &dyn Fn(usize) -> f64| (c..panels.len()).step_by(columns).map(f).fold(0.0, f64::max);
    let tallest = |r: usize, f: &dyn Fn(usize) -> f64| {
        (r * columns..panels.len().min((r + 1) * columns)).map(f).fold(0.0, f64::max)
    };
    let left: Vec<f64> = (0..columns).map(|c| widest(c, &|i| margins[i].left)).collect();
    let right: Vec<f64> = (0..columns).map(|c| widest(c, &|i| margins[i].right)).collect();
    let top: Vec<f64> = (0..rows).map(|r| tallest(r, &|i| margins[i].top)).collect();
    let bottom: Vec<f64> = (0..rows).map(|r| tallest(r, &|i| margins[i].bottom)).collect();

    // Extents that panels of equal scale need, in units; 0 for columns and rows without such panels.
    let need = |i: usize, k: usize| {
        let extent = ranges[i][k][1] - ranges[i][k][0];
        match (panels[i].equal, panels[i].own_scale) {
            (true, true) => OWN_SCALE * extent,
            (true, false) => extent,
            (false, _) => 0.0,
        }
    };
    let need_x: Vec<f64> = (0..columns).map(|c| widest(c, &|i| need(i, 0))).collect();
    let need_y: Vec<f64> = (0..rows).map(|r| tallest(r, &|i| need(i, 1))).collect();
    let free = [
        (bounds[0] - left.iter().sum::<f64>() - right.iter().sum::<f64>()).max(LEAST[0]),
        (bounds[1] - top.iter().sum::<f64>() - bottom.iter().sum::<f64>()).max(LEAST[1]),
    ];
    let fit = |free: f64, need: f64| if need > 0.0 { free / need } else { f64::INFINITY };
    let scale = fit(free[0], need_x.iter().sum()).min(fit(free[1], need_y.iter().sum()));

    let widths: Vec<f64> = need_x
        .iter()
        .map(|n| if *n > 0.0 { (scale * n).max(LEAST[0]) } else { free[0] / count(columns) })
        .collect();
    let heights: Vec<f64> = need_y
        .iter()
        .enumerate()
        .map(|(r, n)| {
            let plain = |i: usize| if panels[i].equal { 0.0 } else { clamp_size(panels[i].height) };
            (scale * n).max(if *n > 0.0 { LEAST[1] } else { tallest(r, &plain) })
        })
        .map(|h| if h.is_finite() { h } else { LEAST[1] })
        .collect();

    let mut y = 0.0;
    for r in 0..rows {
        let mut x = 0.0;
        y += top[r];
        for c in 0..columns {
            x += left[c];
            let i = r * columns + c;
            if i < panels.len() {
                let frame = Rect { x, y, w: widths[c], h: heights[r] };
                let mut range = ranges[i];
                if panels[i].equal {
                    let extent = range.map(|r| r[1] - r[0]);
                    let scale = if panels[i].own_scale {
                        (frame.w / extent[0]).min(frame.h / extent[1])
                    } else {
                        scale
                    };
                    range = [around(range[0], frame.w / scale), around(range[1], frame.h / scale)];
                }
                placed[i] = fill_cell(&panels[i], range, frame, font);
            }
            x += widths[c] + right[c];
        }
        y += heights[r] + bottom[r];
    }
    let sum = |v: &[f64]| v.iter().sum::<f64>();
    [sum(&left) + sum(&widths) + sum(&right), y]
}

fn clamp_size(px: f64) -> f64 {
    if px.is_finite() { px.clamp(60.0, 10_000.0) } else { 300.0 }
}

fn fill_cell(panel: &Panel, range: [[f64; 2]; 2], frame: Rect, font: &Font) -> Placed {
    // Equal scales look equal only if both axes carry the same ticks.
    let [x_ticks, y_ticks] = if panel.equal {
        equal_ticks(range, frame)
    } else {
        // Fewer than four parts may leave a single tick, which tells no scale.
        [
            ticks(range[0][0], range[0][1], (frame.w / 70.0).max(4.0)),
            ticks(range[1][0], range[1][1], (frame.h / 38.0).max(4.0)),
        ]
    };
    let y_tick_width = y_ticks.labels.iter().map(|l| font.width(l, TICK)).fold(0.0, f64::max);
    let y_label = if panel.y.labelled {
        font.wrap(&axis_text(&panel.y, &y_ticks), LABEL, frame.h + 10.0)
    } else {
        Vec::new()
    };
    Placed { frame, x: range[0], y: range[1], x_ticks, y_ticks, y_label, y_tick_width }
}

/// Label and unit, with the common power of ten of the tick labels.
pub(crate) fn axis_text(axis: &Axis, ticks: &Ticks) -> String {
    let power = match ticks.exponent {
        0 => String::new(),
        e if e < 0 => format!("10^{{−{}}}", -e),
        e => format!("10^{{{e}}}"),
    };
    let unit = match (power.is_empty(), axis.unit.is_empty()) {
        (true, true) => return axis.label.clone(),
        (true, false) => axis.unit.replace('-', "–"),
        (false, true) => power,
        (false, false) => format!("{power} {}", axis.unit),
    };
    // The unit does not part from its parentheses at a line break.
    format!("{} ({})", axis.label, unit.replace(' ', "\u{a0}"))
}

fn margins(panel: &Panel, placed: &Placed, font: &Font) -> Margins {
    let heading = if panel.title.is_empty() { 6.0 } else { HEADING * LINE + 6.0 };
    if !panel.framed {
        return Margins { left: EDGE, right: EDGE, top: heading, bottom: EDGE };
    }
    let left = if panel.y.labelled {
        EDGE + count(placed.y_label.len()) * LABEL * LINE + 4.0 + placed.y_tick_width + 8.0
    } else {
        EDGE
    };
    let overhang = placed.x_ticks.labels.last().map_or(0.0, |l| 0.5 * font.width(l, TICK));
    let bottom = if panel.x.labelled { 8.0 + TICK * LINE + LABEL * LINE + 6.0 } else { EDGE };
    Margins { left, right: (overhang + 6.0).max(14.0), top: heading, bottom }
}

/// Ticks of axes of equal scale: the longer one sets the step, so that the grid is square, unless that
/// leaves the shorter one without three ticks.
fn equal_ticks(range: [[f64; 2]; 2], frame: Rect) -> [Ticks; 2] {
    let [w, h] = range.map(|r| r[1] - r[0]);
    let step = nice_step(w.max(h), (frame.w.max(frame.h) / 34.0).clamp(5.0, 11.0));
    range.map(
        |[low, high]| {
            if high - low >= 3.0 * step { ticks_at(low, high, step) } else { ticks(low, high, 4.0) }
        },
    )
}
