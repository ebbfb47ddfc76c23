//! What the printed formula does far out: several solutions, a tension that varies, stiffness that vanishes.

use crate::PaperError;
use crate::bench::{actuated, consistent, distance, followed, printed_plane, robot, solved, solved_from};
use crate::page::{Page, cell};
use cppr::kinematics::Resolution;
use cppr::solve::Equilibrium;
use cppr_plot::{Axis, XyCurve, XyInput, xy_figure};

/// Sixteen modes in the plane.
const FINE: Resolution = Resolution { bending_z: 16, nodes: 32, ..Resolution::PLANAR };

/// Both formulations to ±20 mm, every point from a cold start.
pub fn far(page: &mut Page) -> Result<(), PaperError> {
    let mut curves = Vec::new();
    for name in ["r3", "r4"] {
        let robot = robot(name)?;
        let title = robot.design().name.clone();
        for (which, settings) in [("consistent", consistent()), ("printed", printed_plane())] {
            let mut points = Vec::new();
            for (side, sign) in [("pulled", 1.0), ("pushed", -1.0)] {
                let (mut reached, mut lost) = (0.0, 0);
                for i in 1..=40 {
                    let pull = 0.5 * sign * f64::from(i);
                    match solved(&robot, &actuated(pull, 0.0), &settings) {
                        Ok(state) => points.push([pull, state.tension()]),
                        Err(_) => lost += 1,
                    }
                    if lost == 0 {
                        reached = pull;
                    }
                }
                page.number(format!("{name}/{which}/{side}/solved_to_mm"), reached);
                if lost > 0 {
                    page.text.push(format!(
                        "{title}, {which}, {side}: solved up to {} mm; beyond, {lost} of {} points have no solution.",
                        cell(reached, 1),
                        cell(2.0 * (20.0 - reached.abs()), 0)
                    ));
                }
            }
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            // The printed formula has several solutions far out: points, since a line would join different ones.
            let scattered = which == "printed";
            curves.push(XyCurve { scattered, ..XyCurve::new(format!("{title}, {which}"), points) });
        }
    }
    let input = XyInput { title: String::new(), x: Axis::new("Δa", "mm"), y: Axis::new("T", "N"), curves };
    page.figure(
        "far",
        "Actuation force to ±20 mm, every point solved from rest. The consistent formulation runs on smoothly past the 11 to \
         13 mm where the paper reports jumps; the printed one has several solutions there, or none.",
        xy_figure(&input)?,
    );
    Ok(())
}

/// The printed formula in the plane gives the follower's pull the moment D T (cos ϑ + K_2 y_2) about the leader's
/// centroid, ϑ and y_2 the slope and deflection of the follower's centroid line, K_2 its curvature (eq 48 with the
/// wrench of eq 60): as if the tension varied along the tube.
pub fn tension(page: &mut Page) -> Result<(), PaperError> {
    let mut curves = Vec::new();
    for (name, pull) in [("r1", 7.0), ("r3", 11.0), ("r4", 11.0)] {
        let robot = robot(name)?;
        let modes = Resolution { bending_z: 8, nodes: 20, ..Resolution::PLANAR };
        let state = followed(&robot, pull, &printed_plane().with_resolution(modes))?;
        let base = state.shape.sections.first().map_or(0.0, |s| s.tubes[1].centroid.y);
        let points: Vec<[f64; 2]> = state
            .shape
            .sections
            .iter()
            .map(|s| {
                let follower = &s.tubes[1];
                let curvature = s.curvature.z / follower.rate;
                [s.label * 1e3, s.rotation[(0, 0)] + curvature * (follower.centroid.y - base)]
            })
            .collect();
        let ends = [points.first(), points.last()].map(|p| p.map_or(f64::NAN, |p| p[1]));
        page.number(format!("{name}/{pull}mm/printed_tension_share_base"), ends[0]);
        page.number(format!("{name}/{pull}mm/printed_tension_share_tip"), ends[1]);
        curves.push(XyCurve::new(format!("{}, pulled {pull} mm", robot.design().name), points));
    }
    let line = vec![[0.0, 1.0], [150.0, 1.0]];
    curves.push(XyCurve { reference: true, ..XyCurve::new("consistent: uniform tension", line) });
    let input = XyInput {
        title: "Tension that acts in the follower, as printed".into(),
        x: Axis::new("X", "mm"),
        y: Axis::new("moment over D T", "-"),
        curves,
    };
    page.figure(
        "tension",
        "What the printed formula takes for the follower's tension, over the actuator's: cos ϑ + K_2 y_2. A frictionless guided \
         tube has the same tension everywhere, 1. Both agree where the curvature is constant (R1).",
        xy_figure(&input)?,
    );
    Ok(())
}

/// What the printed formula leaves of the bending stiffness: its balance in the plane, solved for K, is
/// [EI_1 + EI_2/h² + D T y_2/h] K = −D T cos ϑ. Lowest bracket along the robot over EI_1 + EI_2/h².
pub fn stiffness(page: &mut Page) -> Result<(), PaperError> {
    let mut curves = Vec::new();
    let settings = printed_plane().with_resolution(FINE);
    for (name, furthest) in [("r3", 13_u8), ("r4", 12)] {
        let robot = robot(name)?;
        let mut points = Vec::new();
        let mut before: Option<Equilibrium> = None;
        for pull in 1..=furthest {
            let pull = f64::from(pull);
            let state = solved_from(&robot, &actuated(pull, 0.0), &settings, before.as_ref())?;
            let base = state.shape.sections.first().map_or(0.0, |s| s.tubes[1].centroid.y);
            let left = |s: &cppr::analysis::Section| {
                let follower = &s.tubes[1];
                let (own, other) = (robot.fields_at(0, s.label), robot.fields_at(1, follower.abscissa));
                let elastic = own.bending_z + other.bending_z / follower.rate.powi(2);
                let offset = own.centroid_offset + other.centroid_offset;
                let pulled = offset * state.tension() * (follower.centroid.y - base) / follower.rate;
                1.0 + pulled / elastic
            };
            let lowest = state.shape.sections.iter().map(left).fold(1.0, f64::min);
            page.number(format!("{name}/{pull}mm/printed_stiffness_left"), lowest);
            points.push([pull, lowest]);
            before = Some(state.found);
        }
        curves.push(XyCurve { marked: true, ..XyCurve::new(robot.design().name.clone(), points) });
    }
    let line = vec![[0.0, 0.0], [13.0, 0.0]];
    curves.push(XyCurve { reference: true, ..XyCurve::new("none left", line) });
    let input = XyInput {
        title: "Bending stiffness left by the printed formula".into(),
        x: Axis::new("Δa", "mm"),
        y: Axis::new("lowest along the robot", "-"),
        curves,
    };
    page.figure(
        "stiffness",
        "The printed balance in the plane, solved for the curvature, reads [EI_1 + EI_2/h² + D T y_2/h] K = −D T cos ϑ: the pull \
         takes from the stiffness. Lowest bracket along the robot, over EI_1 + EI_2/h²; sixteen modes.",
        xy_figure(&input)?,
    );
    page.text.push(
        "Where the jumps come from: in the printed formula the pull takes away bending stiffness, by D T y_2/h. At the tip of R4 \
         nothing is left between 10 and 11 mm of pull; from there on the curvature is not determined by its balance any more, and \
         solutions jump from one family to another with the number of modes and the start. R3 loses it more slowly and folds back \
         near 14 mm. The total energy has no such term."
            .into(),
    );
    Ok(())
}

/// Whether the paper's five modes are enough.
pub fn modes(page: &mut Page) -> Result<(), PaperError> {
    let mut rows = Vec::new();
    let mut worst = 0.0_f64;
    for (name, pull) in [("r1", 7.0), ("r1", -7.0), ("r3", 11.0), ("r3", -11.0), ("r4", 11.0), ("r4", -11.0)]
    {
        let robot = robot(name)?;
        let plane = cppr::solve::Settings::planar();
        let gap = |five: &cppr::solve::Settings| -> Result<f64, PaperError> {
            let few = followed(&robot, pull, five)?;
            let many = followed(&robot, pull, &five.with_resolution(FINE))?;
            Ok(distance(few.tip_mm(), many.tip_mm()) / robot.length() * 0.1)
        };
        let (ours, theirs) = (gap(&plane)?, gap(&printed_plane())?);
        worst = worst.max(theirs);
        page.number(format!("{name}/{pull}mm/consistent_five_modes_off_percent"), ours);
        page.number(format!("{name}/{pull}mm/printed_five_modes_off_percent"), theirs);
        let title = format!("{}, {} mm", robot.design().name, cell(pull, 0));
        rows.push(vec![title, cell(ours, 4), cell(theirs, 4)]);
    }
    page.number("printed_five_modes_off_percent", worst);
    page.table(
        "Five Legendre modes, which the paper found sufficient (section 4.3), against sixteen: how far the tip is off.",
        &["case", "consistent (% of L)", "as printed (% of L)"],
        rows,
    );
    Ok(())
}
