//! Figures 12, 13, 14 and 16: two tubes in the plane, free and loaded.

use crate::bench::{
    Solved, actuated, consistent, distance, family, lines, loaded_family, printed_plane, robot, solved,
    solved_from,
};
use crate::page::{Page, cell};
use crate::{PaperError, Scenario};
use cppr::Vector3;
use cppr::design::{Robot, TubeDesign};
use cppr::statics::{Loads, Thread};
use cppr_plot::{Axis, Colouring, Force, Pose, XyCurve, XyInput, xy_figure};

/// Tips that are nearer than this to one with a label go without.
const LABEL_MM: f64 = 6.0;

fn signed(mm: f64) -> String {
    if mm > 0.0 { format!("+{mm}") } else { cell(mm, usize::from(mm.fract() != 0.0) * 2) }
}

/// Free shapes of each robot over its motions.
pub fn free(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let mut curves = Vec::new();
    for name in &scenario.robots {
        let robot = robot(name)?;
        let length = robot.length() * 1e3;
        let (mut rows, mut poses, mut printed_poses, mut apart) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut labelled = [const { Vec::new() }; 2];
        let (mut rule, mut worst_gap, mut bend) = ([1.0_f64; 2], 0.0_f64, 0.0);
        for &pull in &scenario.pulls_mm {
            let ours = solved(&robot, &actuated(pull, 0.0), &consistent())?;
            let theirs = solved(&robot, &actuated(pull, 0.0), &printed_plane())?;
            let (a, b) = (ours.tip_mm(), theirs.tip_mm());
            let gap = distance(a, b) / length * 100.0;
            for (formulation, tip, tension) in
                [("consistent", a, ours.tension()), ("printed", b, theirs.tension())]
            {
                let key = |what: &str| format!("{name}/{pull:+}mm/{formulation}/{what}");
                page.number(key("tip_x_mm"), tip[0]);
                page.number(key("tip_y_mm"), tip[1]);
                page.number(key("tension_N"), tension);
            }
            // |K D| ≈ |Δa/l|, at the middle of the robot.
            if pull.abs() > 0.0 {
                let middle = &ours.shape.sections[ours.shape.sections.len() / 2];
                let offset: f64 =
                    (0..2).map(|t| robot.fields_at(t, middle.tubes[t].abscissa).centroid_offset).sum();
                let side = usize::from(pull < 0.0);
                let ratio = middle.curvature.z * offset * length / -pull;
                if (ratio - 1.0).abs() > (rule[side] - 1.0).abs() {
                    rule[side] = ratio;
                }
            }
            worst_gap = worst_gap.max(gap);
            bend = ours.shape.sections.last().map_or(0.0, |s| s.rotation[(0, 0)].acos().to_degrees());
            rows.push(vec![
                signed(pull),
                cell(a[0], 2),
                cell(a[1], 2),
                cell(ours.tension(), 3),
                cell(b[0], 2),
                cell(b[1], 2),
                cell(theirs.tension(), 3),
                cell(gap, 2),
            ]);
            apart.push([pull, gap]);
            // Every other pose keeps the figure legible where there are many.
            let odd = (pull % 2.0).abs() > 0.5;
            if scenario.pulls_mm.len() < 20 || odd || pull.abs() < 0.5 {
                let both = [&mut poses, &mut printed_poses].into_iter().zip([&ours, &theirs]);
                for ((poses, state), labelled) in both.zip(&mut labelled) {
                    // A label needs its own height beside the one before it.
                    let tip = state.tip_mm();
                    let free = labelled.iter().all(|other| distance(tip, *other) > LABEL_MM);
                    poses.push(state.pose(if free { signed(pull) } else { String::new() }));
                    labelled.extend(free.then_some(tip));
                }
            }
        }
        let title = robot.design().name.clone();
        page.figure(
            &format!("{name}-consistent"),
            format!("{title}, consistent formulation: centroid lines of both tubes, Δa in mm at the tips."),
            family(format!("{title}, consistent"), poses, "Δa (mm)", Colouring::Tube)?,
        );
        page.figure(
            &format!("{name}-printed"),
            format!("{title}, formulation as printed, five modes."),
            family(format!("{title}, as printed"), printed_poses, "Δa (mm)", Colouring::Tube)?,
        );
        page.table(
            format!("{title}: tip of tube 1's centroid line and actuation force."),
            &[
                "Δa (mm)",
                "x (mm)",
                "y (mm)",
                "T (N)",
                "x printed",
                "y printed",
                "T printed",
                "apart (% of L)",
            ],
            rows,
        );
        page.number(format!("{name}/largest_distance_of_formulations_percent"), worst_gap);
        page.number(format!("{name}/bend_at_largest_pull_deg"), bend);
        for (side, ratio) in ["pulled", "pushed"].iter().zip(rule) {
            page.number(format!("{name}/curvature_rule_{side}"), ratio);
        }
        page.text.push(format!(
            "{title}: |K D| over |Δa/L| in the middle of the robot, where it is furthest from 1: {} pulled, {} pushed.",
            cell(rule[0], 4),
            cell(rule[1], 4)
        ));
        curves.push(XyCurve { marked: true, ..XyCurve::new(title, apart) });
    }
    let input = XyInput {
        title: String::new(),
        x: Axis::new("Δa", "mm"),
        y: Axis::new("distance of the tips", "% of L"),
        curves,
    };
    page.figure("apart", "Distance between the tips of both formulations.", xy_figure(&input)?);
    Ok(())
}

/// Thread from the outer surface of the leader on one side.
fn thread(robot: &Robot, tension: f64, pulley_mm: [f64; 3], side: f64) -> Thread {
    let reach = match &robot.design().tubes[0] {
        TubeDesign::Notched(t) => t.outline.outer_reach(),
        TubeDesign::Stiffness(_) => 0.0,
    };
    let pulley = Vector3::new(pulley_mm[0], side * pulley_mm[1], pulley_mm[2]) * 1e-3;
    let point = Vector3::new(0.0, side * reach, 0.0);
    Thread { tension, pulley, radius: 0.0, left: side > 0.0, point }
}

/// Loaded by a thread left and right.
pub fn loaded(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let mut worst = 0.0_f64;
    for name in &scenario.robots {
        let robot = robot(name)?;
        let title = robot.design().name.clone();
        let mut rows = Vec::new();
        for (side, side_name) in [(1.0, "left"), (-1.0, "right")] {
            let [mut poses, mut printed_poses] = [const { Vec::new() }; 2];
            let [mut unloaded, mut printed_unloaded] = [const { Vec::new() }; 2];
            for &pull in &scenario.pulls_mm {
                let free = solved(&robot, &actuated(pull, 0.0), &consistent())?;
                let printed_free = solved(&robot, &actuated(pull, 0.0), &printed_plane())?;
                let with = |pulley: [f64; 3]| {
                    let thread = thread(&robot, scenario.thread, pulley, side);
                    actuated(pull, 0.0).with_loads(Loads { threads: vec![thread], ..Loads::none() })
                };
                let command = with(scenario.pulley_mm);
                let ours = solved_from(&robot, &command, &consistent(), Some(&free.found))?;
                let theirs = solved(&robot, &command, &printed_plane())?;
                let far = solved(&robot, &with(scenario.far_pulley_mm), &consistent())?;
                let (a, b) = (ours.tip_mm(), theirs.tip_mm());
                let key = |what: &str| format!("{name}/{side_name}/{pull:+}mm/{what}");
                page.number(key("tip_x_mm"), a[0]);
                page.number(key("tip_y_mm"), a[1]);
                page.number(key("tension_N"), ours.tension());
                page.number(key("printed_tip_x_mm"), b[0]);
                page.number(key("printed_tip_y_mm"), b[1]);
                let gap = distance(a, b) / robot.length() * 0.1;
                worst = worst.max(gap);
                rows.push(vec![
                    side_name.into(),
                    signed(pull),
                    cell(a[0], 2),
                    cell(a[1], 2),
                    cell(ours.tension(), 3),
                    cell(distance(a, free.tip_mm()), 2),
                    cell(b[0], 2),
                    cell(b[1], 2),
                    cell(gap, 2),
                    cell(distance(a, far.tip_mm()), 2),
                ]);
                poses.push(under_thread(&ours, signed(pull), &command.loads.threads[0]));
                printed_poses.push(under_thread(&theirs, signed(pull), &command.loads.threads[0]));
                unloaded.extend(lines(&free.shape, true));
                printed_unloaded.extend(lines(&printed_free.shape, true));
            }
            for (which, file, poses, unloaded) in [
                ("consistent", "", poses, unloaded),
                ("as printed", "-printed", printed_poses, printed_unloaded),
            ] {
                page.figure(
                    &format!("{name}-{side_name}{file}"),
                    format!(
                        "{title} with 20 g on the {side_name}, {which}; Δa in mm at the tips, in grey the shapes \
                         without load."
                    ),
                    loaded_family(
                        format!("{title}, thread on the {side_name}, {which}"),
                        poses,
                        unloaded,
                    )?,
                );
            }
        }
        page.table(
            format!("{title}: tip of tube 1's centroid line under the thread."),
            &[
                "side",
                "Δa (mm)",
                "x (mm)",
                "y (mm)",
                "T (N)",
                "moved by the load (mm)",
                "x printed",
                "y printed",
                "apart (% of L)",
                "far pulley moves it (mm)",
            ],
            rows,
        );
    }
    page.number("largest_distance_of_formulations_percent", worst);
    page.number("thread_N", scenario.thread);
    Ok(())
}

/// A pose with the force of the thread.
fn under_thread(state: &Solved, label: String, thread: &Thread) -> Pose {
    let mut pose = state.pose(label);
    if let Some(tip) = state.shape.sections.last() {
        let point = tip.centre + tip.rotation * thread.point;
        let way = thread.pulley - point;
        let vector = way * (thread.tension / way.norm().max(f64::MIN_POSITIVE));
        pose.forces.push(Force { point: point.into(), vector: vector.into() });
    }
    pose
}
