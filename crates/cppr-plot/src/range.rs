//! Ends of the axes.

use crate::error::{PlotError, check_values};
use crate::figure::{Annotation, Panel};

/// Ends of both axes: those prescribed, else those of the data with a margin.
pub(crate) fn panel_range(panel: &Panel) -> Result<[[f64; 2]; 2], PlotError> {
    let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let mut take = |p: [f64; 2]| {
        for k in 0..2 {
            ends[k] = [ends[k][0].min(p[k]), ends[k][1].max(p[k])];
        }
    };
    for (i, series) in panel.series.iter().enumerate() {
        let what = if series.name.is_empty() {
            format!("series {}", i + 1)
        } else {
            format!("series '{}'", series.name)
        };
        check_values(&what, series.points.iter().map(<[f64; 2]>::as_slice))?;
        match series.points.len() {
            0 => return Err(PlotError::Empty { what }),
            1 if series.marker.is_none() => return Err(PlotError::SinglePoint { what }),
            _ => series.points.iter().for_each(|p| take(*p)),
        }
        if let Some(y) = series.fill.and_then(|f| f.to_y) {
            check_values(&what, [[y].as_slice()])?;
            take([series.points[0][0], y]);
        }
    }
    for annotation in &panel.annotations {
        match annotation {
            Annotation::Arrow { from, to, .. } => {
                check_values("an arrow", [from.as_slice(), to.as_slice()])?;
                take(*from);
                take(*to);
            }
            Annotation::Text { at, text, towards, size, .. } => {
                check_values(&format!("the text '{text}'"), [at.as_slice(), towards.as_slice(), &[*size]])?;
                take(*at);
            }
        }
    }
    let mut out = [[0.0; 2]; 2];
    for (k, axis) in [&panel.x, &panel.y].into_iter().enumerate() {
        if let Some([low, high]) = axis.range {
            let bad = PlotError::BadRange { what: axis.label.clone(), low, high };
            check_values(&format!("axis {}", axis.label), [[low, high].as_slice()])?;
            let span = high - low;
            if span <= 1e-9 * low.abs().max(high.abs()) || span < 1e-290 {
                return Err(bad);
            }
            out[k] = [low, high];
        } else {
            if ends[k][0] > ends[k][1] {
                return Err(PlotError::Empty { what: "a panel".to_owned() });
            }
            if axis.include_zero {
                ends[k] = [ends[k][0].min(0.0), ends[k][1].max(0.0)];
            }
            out[k] = widen(ends[k], axis.tight && !panel.equal);
        }
    }
    if panel.equal {
        // A straight robot has no extent across: its own length says how much margin is due.
        let largest = (out[0][1] - out[0][0]).max(out[1][1] - out[1][0]);
        for (k, axis) in [&panel.x, &panel.y].into_iter().enumerate() {
            if axis.range.is_none() && out[k][1] - out[k][0] < 0.08 * largest {
                out[k] = around(out[k], 0.08 * largest);
            }
        }
    }
    Ok(out)
}

/// Adds a margin of 5 % at both ends; gives extent to a range that has none beyond rounding.
fn widen([low, high]: [f64; 2], tight: bool) -> [f64; 2] {
    let size = low.abs().max(high.abs());
    let span = high - low;
    if span < 1e-290 || span < 1e-7 * size {
        let half = if size > 1e-280 { 0.1 * size } else { 1.0 };
        return [low - half, high + half];
    }
    let margin = if tight { 0.0 } else { 0.05 * span };
    [low - margin, high + margin]
}

/// A range of the given extent around the middle of another.
pub(crate) fn around(range: [f64; 2], extent: f64) -> [f64; 2] {
    let middle = 0.5 * (range[0] + range[1]);
    [middle - 0.5 * extent, middle + 0.5 * extent]
}
