//! The figure of a history with friction: effort and tip against the motor, leg by leg.

use crate::cycle::{History, units};
use cppr::bundle::Friction;
use cppr::solve::Freedom;
use cppr_plot::{Axis, Figure, Panel, Series, tube_stroke};

/// Two panels, beside each other.
pub fn draw(history: &History, friction: &Friction) -> Figure {
    let (motion, effort) = units(history.motor);
    let tube = history.motor.tube;
    let (moved, with) = match history.motor.freedom {
        Freedom::PushPull => (format!("pull Δa_{{{tube}}}"), format!("force T_{{{tube}}}")),
        Freedom::Rotation => (format!("rotation Ω_{{{tube}}}"), format!("torque Υ_{{{tube}}}")),
    };
    let axis = |label: &str, unit: &str| Axis::new(label, unit.replace("deg", "°")).with_zero_line();
    let place = |point: &crate::cycle::Point| history.motion(point)[0] * motion.0;
    let first = &history.points[0].reached.tip;
    let off = |axis: usize| {
        history.points.iter().map(|p| (p.reached.tip[axis] - first[axis]).abs()).fold(0.0, f64::max)
    };
    // The way across the robot that tells more.
    let across = if off(1) >= off(2) { 1 } else { 2 };
    let legs = |of: &dyn Fn(&crate::cycle::Point) -> f64| -> Vec<Series> {
        let each = history.turns.windows(2).enumerate().map(|(leg, ends)| Series {
            name: format!("leg {}", leg + 1),
            points: history.points[ends[0]..=ends[1]].iter().map(|p| [place(p), of(p)]).collect(),
            line: Some(tube_stroke(leg + 1)),
            ..Series::default()
        });
        each.collect()
    };
    let panel = |y: Axis, series: Vec<Series>| Panel { series, ..Panel::new(axis(&moved, motion.1), y) };
    let name = ["x", "y", "z"][across];
    Figure {
        title: format!("{}, friction {}", history.name, friction.coefficient),
        panels: vec![
            panel(axis(&with, effort.1), legs(&|p| history.motion(p)[1] * effort.0)),
            panel(axis(&format!("tip {name}"), "mm"), legs(&|p| p.reached.tip[across] * 1e3)),
        ],
        columns: 2,
        ..Figure::default()
    }
}
