//! Figure 25 and the sensitivity to notch depth of section 5.

use crate::bench::{
    actuated, build, consistent, design, distance, followed, printed_plane, robot, solved, with_factor,
};
use crate::page::{Page, cell};
use crate::{PaperError, Scenario};
use cppr::design::{RobotDesign, TubeDesign};
use cppr_plot::{Axis, XyCurve, XyInput, xy_figure};
use std::f64::consts::PI;

/// Force against motion with Euler's load and the margin.
pub fn euler(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let (mut forces, mut margins) = (Vec::new(), Vec::new());
    let (mut rows, mut crossings, mut euler) = (Vec::new(), Vec::new(), 0.0_f64);
    for name in &scenario.robots {
        let robot = robot(name)?;
        let title = robot.design().name.clone();
        let stiffness = (0..=150)
            .map(|i| f64::from(i) * 1e-3)
            .map(|x| robot.fields_at(0, x).bending_z + robot.fields_at(1, x).bending_z)
            .fold(0.0, f64::max);
        let critical = PI * PI * stiffness / (robot.length() * robot.length());
        page.number(format!("{name}/euler_N"), critical);
        let (mut ours, mut theirs, mut margin) = (Vec::new(), Vec::new(), Vec::new());
        for &pull in &scenario.pulls_mm {
            let a = solved(&robot, &actuated(pull, 0.0), &consistent())?;
            page.number(format!("{name}/{pull}mm/tension_N"), a.tension());
            ours.push([pull, a.tension()]);
            let lowest = a.margin.unwrap_or(f64::NAN);
            page.number(format!("{name}/{pull}mm/margin"), lowest);
            margin.push([pull, lowest]);
            let mut row = vec![title.clone(), cell(pull, 0), cell(a.tension(), 3), cell(lowest, 3)];
            // The printed formula is followed from rest in small steps, to the point where the paper stops.
            let printed = if pull.abs() <= 11.0 {
                Some(followed(&robot, pull, &printed_plane())?.tension())
            } else {
                None
            };
            if let Some(tension) = printed {
                page.number(format!("{name}/{pull}mm/printed_tension_N"), tension);
                theirs.push([pull, tension]);
            }
            row.push(printed.map_or("–".into(), |t| cell(t, 3)));
            rows.push(row);
        }
        let ours = XyCurve::new(format!("{title}, consistent"), ours);
        // One name, colour and dash in both panels.
        margins.push(XyCurve { points: margin, rank: Some(forces.len() + 1), ..ours.clone() });
        forces.push(ours);
        forces.push(XyCurve::new(format!("{title}, as printed"), theirs));
        for (which, curve) in
            [("consistent", &forces[forces.len() - 2]), ("as printed", &forces[forces.len() - 1])]
        {
            let largest = curve.points.iter().map(|p| p[1].abs()).fold(0.0, f64::max);
            page.number(format!("{name}/{which}/largest_N"), largest);
            for (side, sign) in [("pulled", 1.0), ("pushed", -1.0)] {
                let reached = crossing(&curve.points, sign * critical);
                if let Some(at) = reached {
                    page.number(format!("{name}/{which}/{side}/euler_at_mm"), at);
                }
                let own = curve.points.iter().filter(|p| sign * p[0] > 0.0);
                let [reach, force] = own
                    .fold([0.0_f64; 2], |[reach, force], p| [reach.max(p[0].abs()), force.max(p[1].abs())]);
                let at = reached.map_or_else(
                    || format!("not up to {}: {} N at most", cell(sign * reach, 0), cell(force, 2)),
                    |at| cell(at, 1),
                );
                crossings.push(vec![title.clone(), which.into(), side.into(), cell(critical, 3), at]);
            }
        }
        euler = euler.max(critical);
    }
    // Both robots have the same greatest stiffness, at opposite ends.
    let (low, high) = (scenario.pulls_mm[0], -scenario.pulls_mm[0]);
    for (sign, label) in [(1.0, "Euler's load, eq 99"), (-1.0, "")] {
        let line = vec![[low, sign * euler], [high, sign * euler]];
        forces.push(XyCurve { reference: true, ..XyCurve::new(label, line) });
    }
    page.table(
        "Where the force reaches the load of a pinned Euler rod.",
        &["robot", "formulation", "side", "Euler (N)", "Δa (mm)"],
        crossings,
    );
    let plot = |y: Axis, curves: Vec<XyCurve>| {
        xy_figure(&XyInput { title: String::new(), x: Axis::new("Δa", "mm"), y, curves })
    };
    let mut figure = plot(Axis::new("T", "N"), forces)?;
    let margin = plot(Axis::new("margin to instability", "-"), margins)?;
    figure.panels.extend(margin.panels);
    figure.columns = 1;
    page.figure("", "Actuation force with Euler's load (dashed), and the margin to instability.", figure);
    page.table(
        "Actuation force and margin.",
        &["robot", "Δa (mm)", "T (N)", "margin (-)", "T printed (N)"],
        rows,
    );
    Ok(())
}

/// Where a sampled curve reaches a value, linear between the samples.
fn crossing(points: &[[f64; 2]], value: f64) -> Option<f64> {
    let mut pairs = points.windows(2);
    pairs.find_map(|p| {
        let ([x0, y0], [x1, y1]) = (p[0], p[1]);
        ((y0 - value) * (y1 - value) <= 0.0).then(|| x0 + (x1 - x0) * (value - y0) / (y1 - y0))
    })
}

/// R1 with deeper notches.
pub fn deeper(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let base = design(&scenario.robots[0])?;
    let mut rows = Vec::new();
    for factor in [1.27, 1.0] {
        let nominal = build(with_factor(base.clone(), factor))?;
        for (which, tubes) in
            [("both tubes", [true, true]), ("outer tube", [true, false]), ("inner tube", [false, true])]
        {
            let changed = build(with_factor(shifted(base.clone(), tubes, 1e-4), factor))?;
            let mut worst = (0.0, 0.0);
            for &pull in &scenario.pulls_mm {
                let a = solved(&nominal, &actuated(pull, 0.0), &consistent())?.tip_mm();
                let b = solved(&changed, &actuated(pull, 0.0), &consistent())?.tip_mm();
                let moved = distance(a, b);
                if moved > worst.0 {
                    worst = (moved, pull);
                }
            }
            page.number(format!("factor {factor}/{which}/largest_change_mm"), worst.0);
            rows.push(vec![which.into(), cell(factor, 2), cell(worst.0, 2), cell(worst.1, 0)]);
        }
    }
    page.table(
        "Largest move of the tip of tube 1's centroid line when the notches are 0.1 mm deeper.",
        &["deeper", "f_D", "largest change (mm)", "at Δa (mm)"],
        rows,
    );
    Ok(())
}

fn shifted(mut design: RobotDesign, tubes: [bool; 2], by: f64) -> RobotDesign {
    for (tube, deeper) in design.tubes.iter_mut().zip(tubes) {
        if let (TubeDesign::Notched(tube), true) = (tube, deeper) {
            tube.depth = tube.depth.shifted(by);
        }
    }
    design
}
