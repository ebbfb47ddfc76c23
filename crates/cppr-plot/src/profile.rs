//! Quantities along the robot, one panel each, stacked over a common axis in mm.

use crate::error::{PlotError, check_values};
use crate::figure::{Axis, Figure, Panel, Series};
use crate::palette::tube_stroke;

/// What [`profile_figure`] draws.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProfileInput {
    /// Short title; may be empty.
    pub title: String,
    /// Name of the coordinate along the robot, for example `X_{1}`; its unit is always mm.
    pub x_label: String,
    /// Panels from top to bottom.
    pub quantities: Vec<Quantity>,
}

/// One panel of a profile figure.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Quantity {
    /// Name or symbol, for example `D`.
    pub label: String,
    /// Unit of the values.
    pub unit: String,
    /// Let the axis reach zero, as befits areas and stiffnesses.
    pub include_zero: bool,
    /// One curve per tube.
    pub curves: Vec<ProfileCurve>,
}

/// A quantity along one tube.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProfileCurve {
    /// Legend entry, for example `tube 1`. The same name in several panels makes one entry.
    pub name: String,
    /// Number of the tube, from 1; it sets colour and dash.
    pub tube: usize,
    /// Coordinates along the robot, m. A coordinate given twice draws a step.
    pub x_m: Vec<f64>,
    /// Values in the panel's unit, as many as coordinates.
    pub values: Vec<f64>,
}

/// Stacked panels that share the axis along the robot.
///
/// # Errors
/// [`PlotError::Empty`] without quantities, curves or points, [`PlotError::SinglePoint`],
/// [`PlotError::LengthMismatch`], [`PlotError::TubeZero`], [`PlotError::NotFinite`] and
/// [`PlotError::TooLarge`].
pub fn profile_figure(input: &ProfileInput) -> Result<Figure, PlotError> {
    if input.quantities.is_empty() {
        return Err(PlotError::Empty { what: "the list of quantities".to_owned() });
    }
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    let mut panels = Vec::with_capacity(input.quantities.len());
    for quantity in &input.quantities {
        if quantity.curves.is_empty() {
            return Err(PlotError::Empty { what: format!("the panel of {}", quantity.label) });
        }
        let mut y = Axis::new(&quantity.label, &quantity.unit);
        y.include_zero = quantity.include_zero;
        let mut panel = Panel::new(Axis::new(&input.x_label, "mm"), y);
        panel.height = if input.quantities.len() == 1 { 280.0 } else { 140.0 };
        for curve in &quantity.curves {
            let what = format!("{} of '{}'", quantity.label, curve.name);
            check_curve(&what, curve)?;
            let points: Vec<[f64; 2]> =
                curve.x_m.iter().zip(&curve.values).map(|(x, v)| [1e3 * x, *v]).collect();
            for p in &points {
                ends = [ends[0].min(p[0]), ends[1].max(p[0])];
            }
            panel.series.push(Series {
                name: curve.name.clone(),
                points,
                line: Some(tube_stroke(curve.tube)),
                ..Series::default()
            });
        }
        panels.push(panel);
    }
    let last = panels.len() - 1;
    for (i, panel) in panels.iter_mut().enumerate() {
        panel.x.labelled = i == last;
        // Common ends, without margin: the robot fills the width. All at one place is left to the layout.
        if ends[1] - ends[0] > 1e-9 * ends[0].abs().max(ends[1].abs()) {
            panel.x.range = Some(ends);
        }
    }
    Ok(Figure { title: input.title.clone(), panels, max_width: 520.0, ..Figure::default() })
}

fn check_curve(what: &str, curve: &ProfileCurve) -> Result<(), PlotError> {
    let what = what.to_owned();
    if curve.tube == 0 {
        return Err(PlotError::TubeZero { what });
    }
    if curve.x_m.len() != curve.values.len() {
        let (expected, found) = (curve.x_m.len(), curve.values.len());
        return Err(PlotError::LengthMismatch { what, expected, found });
    }
    match curve.x_m.len() {
        0 => return Err(PlotError::Empty { what }),
        1 => return Err(PlotError::SinglePoint { what }),
        _ => {}
    }
    check_values(&what, curve.x_m.iter().map(std::slice::from_ref))?;
    check_values(&what, curve.values.iter().map(std::slice::from_ref))
}
