//! Figures 18 to 24: out of the plane.

use crate::bench::{
    PAPER_SPACE, actuated, build, centreline, consistent, design, distance, family, lines, printed_space,
    robot, solved,
};
use crate::page::{Page, cell};
use crate::{PaperError, Scenario};
use cppr::Vector3;
use cppr::design::{BelowPlate, Profile, Robot, Torsion, TubeDesign};
use cppr::solve::{Command, Settings};
use cppr::statics::{Loads, RotationMeans};
use cppr_plot::{
    Annotation, Axis, Colour, Colouring, Dash, Figure, Pose, ShapeInput, Stroke, XyCurve, XyInput,
    shape_figure, xy_figure,
};

/// Two tubes under a sideways weight.
pub fn sideways(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let robot = robot(&scenario.robots[0])?;
    let (mut rows, mut poses) = (Vec::new(), Vec::new());
    for &pull in &scenario.pulls_mm {
        let loads = || Loads::tip_force(Vector3::from(scenario.tip_force));
        let ours = solved(&robot, &actuated(pull, 0.0).with_loads(loads()), &consistent())?;
        let theirs = solved(&robot, &actuated(pull, 0.0).with_loads(loads()), &printed_space())?;
        let free = solved(&robot, &actuated(pull, 0.0), &consistent())?;
        let (a, b) = (ours.centre_mm(), theirs.centre_mm());
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            page.number(format!("{pull}mm/tip_{name}_mm"), a[axis]);
            page.number(format!("{pull}mm/printed_tip_{name}_mm"), b[axis]);
        }
        page.number(format!("{pull}mm/tension_N"), ours.tension());
        rows.push(vec![
            cell(pull, 2),
            cell(a[0], 3),
            cell(a[1], 3),
            cell(a[2], 3),
            cell(ours.tension(), 3),
            cell(distance(a, free.centre_mm()), 3),
            cell(b[0], 3),
            cell(b[1], 3),
            cell(b[2], 3),
            cell(distance(a, b) / robot.length() * 0.1, 2),
        ]);
        // Every other label: they would crowd where the tips lie side by side.
        let label = if (pull % 0.5).abs() < 1e-9 { cell(pull, 1) } else { String::new() };
        poses.push(Pose { label, lines: vec![centreline(&ours.shape)], forces: Vec::new() });
    }
    page.figure(
        "",
        "Centrelines, consistent formulation; Δa in mm.",
        family("Childs2, 50 g on the tip, consistent", poses, "Δa (mm)", Colouring::Pose)?,
    );
    page.table(
        "Centre of the tip section.",
        &[
            "Δa (mm)",
            "x (mm)",
            "y (mm)",
            "z (mm)",
            "T (N)",
            "moved by the weight (mm)",
            "x printed",
            "y printed",
            "z printed",
            "apart (% of L)",
        ],
        rows,
    );
    Ok(())
}

/// Three tubes, three sequences.
pub fn star(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let robot = robot(&scenario.robots[0])?;
    let sequences: [(&str, [f64; 2]); 3] =
        [("follower 2", [1.0, 0.0]), ("follower 3", [0.0, 1.0]), ("both", [1.0, 1.0])];
    let (mut rows, mut poses, mut branches, mut largest_bow) = (Vec::new(), Vec::new(), Vec::new(), 0.0_f64);
    for (name, share) in sequences {
        let mut tips = Vec::new();
        for &pull in &scenario.pulls_mm {
            let command = Command::pull(&share.map(|s| s * pull * 1e-3));
            let ours = solved(&robot, &command, &consistent())?;
            let printed = Command { rotation_means: RotationMeans::RelativeAngle, ..command };
            let theirs = solved(&robot, &printed, &printed_space())?;
            let (a, b) = (ours.centre_mm(), theirs.centre_mm());
            for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
                page.number(format!("{name}/{pull}mm/tip_{letter}_mm"), a[axis]);
                page.number(format!("{name}/{pull}mm/printed_tip_{letter}_mm"), b[axis]);
            }
            rows.push(vec![
                name.into(),
                cell(pull, 1),
                cell(a[0], 3),
                cell(a[1], 3),
                cell(a[2], 3),
                cell(ours.found.actuators()[0].tension, 3),
                cell(ours.found.actuators()[1].tension, 3),
                cell(distance(a, b) / robot.length() * 0.1, 2),
            ]);
            tips.push([a[1], a[2]]);
            poses.push(Pose {
                label: String::new(),
                lines: vec![centreline(&ours.shape)],
                forces: Vec::new(),
            });
        }
        let [first, last] = [tips[0], tips[tips.len() - 1]];
        let way = [last[0] - first[0], last[1] - first[1]];
        let length = way[0].hypot(way[1]);
        let bow = tips
            .iter()
            .map(|t| ((t[0] - first[0]) * way[1] - (t[1] - first[1]) * way[0]).abs() / length)
            .fold(0.0, f64::max);
        page.number(format!("{name}/branch_angle_deg"), way[1].atan2(way[0]).to_degrees());
        page.number(format!("{name}/branch_bow_mm"), bow);
        largest_bow = largest_bow.max(bow);
        page.text.push(format!(
            "Branch of {name}: along {}° in the Y–Z plane, straight to {} mm over {} mm.",
            cell(way[1].atan2(way[0]).to_degrees(), 1),
            cell(bow, 2),
            cell(length, 1)
        ));
        branches.push(XyCurve { marked: true, ..XyCurve::new(name, tips) });
    }
    page.number("largest_bow_mm", largest_bow);
    page.figure(
        "",
        "Centrelines of the three sequences, consistent formulation: follower 2 alone in the darkest shades, both in the lightest.",
        family("Childs3, consistent", poses, "", Colouring::Pose)?,
    );
    let input = XyInput {
        title: "Childs3, tips seen along the axis, consistent".into(),
        x: Axis::new("Y", "mm"),
        y: Axis::new("Z", "mm"),
        curves: branches,
    };
    let mut figure = xy_figure(&input)?;
    for panel in &mut figure.panels {
        panel.equal = true;
    }
    page.figure("star", "The star of the tips.", figure);
    page.table(
        "Centre of the tip section and actuation forces; the last column is the distance to the printed formulation.",
        &["pulled", "Δa (mm)", "x (mm)", "y (mm)", "z (mm)", "T_2 (N)", "T_3 (N)", "apart (% of L)"],
        rows,
    );
    Ok(())
}

/// R1 with given torsional stiffness of leader and follower (N m²), `None` for Saint-Venant.
fn twisted(name: &str, stiffness: Option<[f64; 2]>) -> Result<Robot, PaperError> {
    let mut design = design(name)?;
    for (k, tube) in design.tubes.iter_mut().enumerate() {
        if let TubeDesign::Notched(tube) = tube {
            tube.below = BelowPlate::Continued;
            if let Some(stiffness) = stiffness {
                tube.torsion = Torsion::Given(Profile::constant(stiffness[k]));
            }
        }
    }
    build(design)
}

/// Torsional stiffnesses to compare: name, leader and follower (N m²).
fn torsions(name: &str) -> Result<Vec<(String, [f64; 2])>, PaperError> {
    let plain = twisted(name, None)?;
    let own = [0, 1].map(|t| plain.fields_at(t, 0.0).torsion);
    let mut polar = design(name)?;
    for tube in &mut polar.tubes {
        if let TubeDesign::Notched(tube) = tube {
            tube.torsion = Torsion::Polar;
            // G = 1 GPa, which section 4.10 takes for both tubes.
            tube.material.poissons_ratio = tube.material.youngs_modulus / 2e9 - 1.0;
        }
    }
    let polar = build(polar)?;
    let polar = [0, 1].map(|t| polar.fields_at(t, 0.0).torsion);
    Ok(vec![
        ("Saint-Venant".into(), own),
        ("ratio 0.65 as printed".into(), [0.65 * own[1], own[1]]),
        ("ratio 1/0.65".into(), [own[1] / 0.65, own[1]]),
        ("polar, G = 1 GPa, as computed there".into(), polar),
    ])
}

/// Rotation only.
pub fn rotation(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let name = &scenario.robots[0];
    let (mut rows, mut curves, mut arrows) = (Vec::new(), Vec::new(), Vec::new());
    for (which, stiffness) in torsions(name)? {
        let robot = twisted(name, Some(stiffness))?;
        let ratio = stiffness[0] / stiffness[1];
        let mut points = Vec::new();
        for &turn in &scenario.rotations_deg {
            let ours = solved(&robot, &actuated(0.0, turn), &consistent())?;
            let tip = ours.shape.sections.last().ok_or_else(|| PaperError("no section".into()))?;
            let angle = tip.rotation[(2, 1)].atan2(tip.rotation[(1, 1)]).to_degrees();
            let line = turn / (1.0 + ratio);
            page.number(format!("{which}/{turn}deg/tip_turn_deg"), angle);
            page.number(format!("{which}/{turn}deg/torque_Nmm"), ours.found.actuators()[0].torque * 1e3);
            page.number(format!("{which}/{turn}deg/tip_x_mm"), ours.centre_mm()[0]);
            if turn > 0.0 {
                rows.push(vec![
                    which.clone(),
                    cell(ratio, 3),
                    cell(turn, 0),
                    cell(angle, 2),
                    cell(line, 2),
                    cell(ours.found.actuators()[0].torque * 1e3, 2),
                    cell(ours.centre_mm()[0], 3),
                ]);
            }
            points.push([turn, angle]);
        }
        arrows.push((which.clone(), points.clone()));
        curves.push(XyCurve { marked: true, ..XyCurve::new(which, points) });
    }
    let input = XyInput {
        title: "R1, rotation only, consistent".into(),
        x: Axis::new("turn of the follower's base", "deg"),
        y: Axis::new("turn of the tip", "deg"),
        curves,
    };
    page.figure(
        "",
        "How far the tip turns, for four readings of the torsional stiffness.",
        xy_figure(&input)?,
    );
    page.table(
        "Turn of the tip, and what the share GJ_2/(GJ_1 + GJ_2) alone would give (the tubes' helices shorten, which couples in a little bending stiffness).",
        &["torsion", "GJ_1/GJ_2", "Ω (deg)", "tip (deg)", "share (deg)", "Υ (N mm)", "tip x (mm)"],
        rows,
    );
    page.figure(
        "tip-vectors",
        "Figure 23: where the tip's axis b_Y points, seen along the robot, the follower turned by −180°, −90°, 0, 90° and 180°. The arrows of a reading \
         have a length of their own, to be told apart.",
        tip_vectors(&arrows)?,
    );
    let robot = twisted(name, None)?;
    let half = solved(&robot, &actuated(0.0, 180.0), &consistent())?;
    let mut paths: Vec<XyCurve> = (0..2)
        .map(|t| {
            let points = half.shape.sections.iter().map(|s| s.tubes[t].centroid * 1e3);
            XyCurve::new(format!("tube {}", t + 1), points.map(|p| [p.y, p.z]).collect())
        })
        .collect();
    if let Some(tip) = half.shape.sections.last() {
        let ends = tip.tubes.iter().map(|t| [t.centroid.y * 1e3, t.centroid.z * 1e3]).collect();
        paths.push(XyCurve { marked: true, reference: true, ..XyCurve::new("tip body", ends) });
    }
    let input = XyInput {
        title: "R1, follower turned by 180°, seen along the axis, consistent".into(),
        x: Axis::new("Y", "mm"),
        y: Axis::new("Z", "mm"),
        curves: paths,
    };
    let mut figure = xy_figure(&input)?;
    for panel in &mut figure.panels {
        panel.equal = true;
    }
    page.figure("shape", "Centroid lines wind around the axis; Saint-Venant torsion.", figure);
    Ok(())
}

/// Arrows from the axis to where the tip's b_Y points, for readings of the torsional stiffness and (turn, turn of the tip) in degrees.
fn tip_vectors(readings: &[(String, Vec<[f64; 2]>)]) -> Result<Figure, PaperError> {
    let curves = readings.iter().zip(0_u8..).map(|((name, turns), index)| {
        let length = 1.0 - 0.17 * f64::from(index);
        let ends = turns.iter().map(|[_, tip]| tip.to_radians().sin_cos());
        let points = ends.map(|(sin, cos)| [length * cos, length * sin]).collect();
        XyCurve { scattered: true, ..XyCurve::new(name.clone(), points) }
    });
    let input = XyInput {
        title: "R1, rotation only: b_{Y} of the tip".into(),
        x: Axis::new("Y", "-"),
        y: Axis::new("Z", "-"),
        curves: curves.collect(),
    };
    let mut figure = xy_figure(&input)?;
    for panel in &mut figure.panels {
        panel.equal = true;
        for series in &panel.series {
            let Some(marker) = &series.marker else { continue };
            let stroke = Stroke { colour: marker.colour, width: 1.2, dash: Dash::Solid };
            panel.annotations.extend(series.points.iter().map(|to| Annotation::Arrow {
                name: String::new(),
                from: [0.0; 2],
                to: *to,
                stroke,
            }));
        }
        // The first reading is the longest: its arrows carry the turns.
        for [turn, tip] in readings.first().map_or(&[][..], |(_, turns)| turns) {
            let (sin, cos) = tip.to_radians().sin_cos();
            panel.annotations.push(Annotation::Text {
                at: [cos, sin],
                text: format!("{}°", cell(*turn, 0)),
                towards: [cos, sin],
                size: 10.0,
                colour: Colour::INK,
                avoid: false,
            });
        }
    }
    Ok(figure)
}

/// Helicoid with the angle or the motor held.
pub fn helicoid(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let robot = robot(&scenario.robots[0])?;
    let (mut rows, mut held, mut turning) = (Vec::new(), Vec::new(), Vec::new());
    for &pull in &scenario.pulls_mm {
        let motor = actuated(pull, 0.0);
        let angle = Command { rotation_means: RotationMeans::RelativeAngle, ..motor.clone() };
        let a = solved(&robot, &angle, &consistent())?;
        let m = solved(&robot, &motor, &consistent())?;
        let p = solved(&robot, &angle, &printed_space())?;
        let tips = [a.centre_mm(), m.centre_mm(), p.centre_mm()];
        for (which, tip) in ["angle_held", "motor_held", "printed"].iter().zip(tips) {
            for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
                page.number(format!("{pull}mm/{which}/tip_{letter}_mm"), tip[axis]);
            }
        }
        rows.push(
            [cell(pull, 0)]
                .into_iter()
                .chain(tips[0].map(|v| cell(v, 2)))
                .chain([cell(a.tension(), 3)])
                .chain(tips[1].map(|v| cell(v, 2)))
                .chain([cell(m.tension(), 3), cell(distance(tips[0], tips[2]) / robot.length() * 0.1, 2)])
                .collect(),
        );
        if (pull % 5.0).abs() < 1e-9 {
            held.push(a.pose(cell(pull, 0)));
            turning.push(m.pose(cell(pull, 0)));
        }
    }
    page.figure(
        "angle",
        "Δθ_2(0) held, as in the paper; Δa in mm.",
        family("Helicoid, angle held, consistent", held, "Δa (mm)", Colouring::Alternate)?,
    );
    page.figure(
        "motor",
        "Motor held.",
        family("Helicoid, motor held, consistent", turning, "Δa (mm)", Colouring::Alternate)?,
    );
    page.table(
        "Centre of the tip section with the angle held and with the motor held; the last column is the distance of the printed formulation (angle held).",
        &["Δa (mm)", "x", "y", "z (mm)", "T (N)", "x", "y", "z (mm)", "T (N)", "apart (% of L)"],
        rows,
    );
    Ok(())
}

/// Translation and rotation.
pub fn combined(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let name = &scenario.robots[0];
    let mut rows = Vec::new();
    let own = torsions(name)?;
    page.number("saint_venant_ratio", own[0].1[0] / own[0].1[1]);
    for (which, stiffness) in own.into_iter().take(3) {
        let robot = twisted(name, Some(stiffness))?;
        let rest = lines(&solved(&robot, &actuated(0.0, 0.0), &consistent())?.shape, true);
        let mut poses = Vec::new();
        for &pull in &scenario.pulls_mm {
            for &turn in &scenario.rotations_deg {
                let ours = solved(&robot, &actuated(pull, turn), &consistent())?;
                let coarse = Settings::default().with_resolution(PAPER_SPACE);
                let few = solved(&robot, &actuated(pull, turn), &coarse)?;
                let theirs = solved(&robot, &actuated(pull, turn), &printed_space())?;
                let (a, b) = (ours.centre_mm(), theirs.centre_mm());
                for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
                    page.number(format!("{which}/{pull}mm/{turn}deg/tip_{letter}_mm"), a[axis]);
                }
                rows.push(vec![
                    which.clone(),
                    cell(pull, 0),
                    cell(turn, 0),
                    cell(a[0], 2),
                    cell(a[1], 2),
                    cell(a[2], 2),
                    cell(ours.tension(), 3),
                    cell(ours.found.actuators()[0].torque * 1e3, 2),
                    cell(distance(a, few.centre_mm()) / robot.length() * 0.1, 3),
                    cell(distance(a, b) / robot.length() * 0.1, 2),
                ]);
                poses.push(ours.pose(format!("{}, {}°", cell(pull, 0), cell(turn, 0))));
            }
        }
        let file: String = which.chars().filter(char::is_ascii_alphanumeric).collect();
        page.figure(
            &file.to_lowercase(),
            format!("R1 at ±3 mm, follower turned by −90°, 0, 90°: {which}; in grey at rest."),
            shape_figure(&ShapeInput {
                title: format!("R1, {which}, consistent"),
                poses,
                label_name: "Δa (mm), Ω".into(),
                colouring: Colouring::Alternate,
                rest,
                rest_name: "at rest".into(),
                ..ShapeInput::default()
            })?,
        );
    }
    page.table(
        "Centre of the tip section, consistent formulation. \"Few modes\": distance to the paper's 3 + 3 + 2 + 2 modes; \"apart\": to the printed formulation with them.",
        &["torsion", "Δa (mm)", "Ω (deg)", "x (mm)", "y (mm)", "z (mm)", "T (N)", "Υ (N mm)", "few modes (% of L)", "apart (% of L)"],
        rows,
    );
    Ok(())
}
