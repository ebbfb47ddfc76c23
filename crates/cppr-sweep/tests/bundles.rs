//! Sweeps of robots with parts and joints: rows against single solves, designs, limits, every format, interruption.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::analysis::{BundleAnalysis, Teeth, Utilisation};
use cppr::bundle::solve::{BundleCommand, BundleSolver, TubeDrive};
use cppr::bundle::{Bundle, Friction};
use cppr::solve::{Drive, Quantity};
use cppr::statics::{Loads, Wrench};
use cppr_sweep::{
    Axis, BundleSubject, Chunk, FileOptions, FileProblem, Format, Plan, Subject, Task, TaskProblem, Values,
    Variable, Verdict, run, write_file,
};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/../../robots/bundles/{name}.toml", env!("CARGO_MANIFEST_DIR")))
        .unwrap()
}

fn task(robot_text: String, axes: Vec<Axis>) -> Task {
    let design = cppr_io::bundle_file::parse(&robot_text).unwrap();
    let bundle = Bundle::new(&design).unwrap();
    let wrench = Wrench::tip_force(cppr::Vector3::new(0.0, 0.02, 0.01));
    let base = BundleCommand {
        drives: vec![TubeDrive::HELD; design.tubes.len()],
        loads: Loads { wrenches: vec![wrench], ..Loads::none() },
    };
    let subject = Subject::Bundle(Box::new(BundleSubject { bundle, design, base, stretch: false }));
    Task { subject, robot_text, axes, plan: Plan::Grid, margin: false, limits: None, friction: None }
}

fn range(variable: Variable, from: f64, to: f64, count: u32) -> Axis {
    Axis { variable, values: Values::Range { from, to, count } }
}

fn pull(tube: usize) -> Variable {
    Variable::Actuator(Quantity::PULL.of_tube(tube))
}

const DEPTH: &str = "tube1.part2.notches.depth_mm";

/// Rows of a whole run, and why they were refused.
fn rows(task: &Task, threads: usize) -> Vec<(Vec<f64>, Option<String>)> {
    task.check().unwrap();
    let width = task.columns().len();
    let mut rows = Vec::new();
    let flow = run(task, threads, 0..task.chunks(), &AtomicBool::new(false), |chunk: Chunk| {
        let own = |row: usize| (0..width).map(|column| chunk.column(column)[row]).collect();
        rows.extend((0..chunk.rows).map(|row| (own(row), task.reason(&chunk, row))));
        ControlFlow::<()>::Continue(())
    });
    assert!(flow.unwrap().is_continue());
    rows
}

fn place(task: &Task, name: &str) -> usize {
    task.columns().iter().position(|c| c.name == name).unwrap_or_else(|| panic!("there is no column {name}"))
}

#[test]
fn rows_are_single_solves_of_the_robot_that_the_file_would_say() {
    let robot = text("uncut_ends");
    let axes = vec![range(Variable::Design(DEPTH.into()), 1.5, 2.1, 3), range(pull(2), 0.0, -0.5e-3, 3)];
    let mut task = task(robot.clone(), axes);
    task.limits = Some(Teeth::Rigid);
    let all = rows(&task, 2);
    assert_eq!(all.len(), 9);
    let at = |name: &str| place(&task, name);
    let [tip, strain, tube, notch] = ["tip_y_m", "strain_utilisation", "strain_tube", "strain_notch"].map(at);
    let mut tips = Vec::new();
    for (row, reason) in &all[..6] {
        assert!(row[2] < 0.5 && reason.is_none(), "stable: {row:?}");
        let edited = robot.replacen("depth_mm = 1.6", &format!("depth_mm = {}", row[0]), 1);
        assert_eq!(edited == robot, (row[0] - 1.6).abs() < 1e-12);
        let design = cppr_io::bundle_file::parse(&edited).unwrap();
        let bundle = Bundle::new(&design).unwrap();
        let mut analysis = BundleAnalysis::new(BundleSolver::new(&bundle), &design);
        let Subject::Bundle(own) = &task.subject else { panic!("no bundle") };
        let mut command = own.base.clone();
        command.drives[1].translation = Drive::Motion(row[1]);
        let found = analysis.solver.solve(&command);
        assert!((found.tip.y - row[tip]).abs() < 1e-9, "{} {}", found.tip.y, row[tip]);
        tips.push(row[tip]);
        let used = Utilisation::of(&analysis.section_limits(&found, Teeth::Rigid));
        assert!((used.strain.unwrap() - row[strain]).abs() < 1e-6 && row[strain] > 0.0);
        assert!((1.0..=2.0).contains(&row[tube]) && (1.0..=100.0).contains(&row[notch]));
    }
    assert!((tips[1] - tips[4]).abs() > 1e-5, "another depth is another robot: {tips:?}");
    // Deeper than the tube is wide.
    for (row, reason) in &all[6..] {
        assert_eq!(Verdict::from_code(row[2]), Some(Verdict::InvalidDesign), "{row:?}");
        assert!(reason.as_ref().unwrap().contains("depth"), "{reason:?}");
    }
    assert_eq!(format!("{all:?}"), format!("{:?}", rows(&task, 1)), "threads change nothing");
}

#[test]
fn an_interrupted_sweep_goes_on_and_every_format_holds_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let axes = vec![range(pull(2), 0.0, 2e-3, 10), range(pull(4), -1e-3, 1e-3, 20)];
    let task = task(text("two_sections"), axes);
    assert!(task.chunks() > 1);
    let stop = AtomicBool::new(false);
    let options = |resume, format, stop| FileOptions { threads: 2, resume, format, stop };
    let whole = folder.path().join("whole.csv");
    let finished = write_file(&task, &whole, &options(false, Format::Csv, &stop), |_| {}, |_| {}).unwrap();
    assert_eq!(finished.counts.iter().sum::<u64>(), 200);
    assert!(finished.counts[0] > 150, "{finished:?}");
    let parts = folder.path().join("parts.csv");
    let interrupt = |done: u64| stop.store(done > 0, Ordering::Relaxed);
    let problem = write_file(&task, &parts, &options(false, Format::Csv, &stop), interrupt, |_| {});
    assert!(matches!(problem, Err(FileProblem::Stopped(done, 200, _)) if done > 0), "{problem:?}");
    stop.store(false, Ordering::Relaxed);
    write_file(&task, &parts, &options(true, Format::Csv, &stop), |_| {}, |_| {}).unwrap();
    let csv = std::fs::read_to_string(&whole).unwrap();
    assert_eq!(csv, std::fs::read_to_string(&parts).unwrap());
    for (name, format) in [("whole.npz", Format::Npz), ("whole.parquet", Format::Parquet)] {
        let path = folder.path().join(name);
        assert_eq!(
            write_file(&task, &path, &options(false, format, &stop), |_| {}, |_| {}).unwrap(),
            finished
        );
        assert!(path.metadata().unwrap().len() > 10_000);
    }
    let head: serde_json::Value =
        serde_json::from_str(csv.lines().next().unwrap().trim_start_matches("# ")).unwrap();
    assert_eq!(head["formulation"], "bundle");
    assert_eq!(head["command"]["actuators"].as_array().unwrap().len(), 4);
    assert_eq!(head["robot_file"], task.robot_text.as_str());
}

#[test]
fn samples_tell_what_they_were_drawn_from_and_a_margin_is_refused() {
    let axes = vec![
        Axis {
            variable: Variable::Design(DEPTH.into()),
            values: Values::Normal { mean: 1.6, deviation: 0.01 },
        },
        range(pull(2), -0.5e-3, 0.0, 0),
    ];
    let mut task = task(text("uncut_ends"), axes);
    task.plan = Plan::Samples { count: 12, seed: 3 };
    let all = rows(&task, 2);
    let depths: Vec<f64> = all.iter().map(|(row, _)| row[0]).collect();
    let mean = depths.iter().sum::<f64>() / 12.0;
    assert!((mean - 1.6).abs() < 0.01 && depths.iter().any(|d| (d - 1.6).abs() > 0.005), "{depths:?}");
    assert!(all.iter().all(|(row, _)| row[2] < 0.5), "all stable");
    task.margin = true;
    assert_eq!(task.check(), Err(TaskProblem::NoMargin));
    task.margin = false;
    task.axes.push(range(pull(3), 0.0, 1e-3, 0));
    assert!(matches!(task.check(), Err(TaskProblem::NoSuchInput(_))));
    task.axes.pop();
    task.axes[0].variable = Variable::Design("tube1.part4.length_mm".into());
    let Err(TaskProblem::Key(problem)) = task.check() else { panic!("there is no part 4") };
    assert!(problem.to_string().contains("its list ends with 3"), "{problem}");
}

#[test]
fn friction_adds_both_ways_of_slip_to_a_row() {
    let mut task = task(text("s_shape"), vec![range(pull(2), 1e-3, 3e-3, 2)]);
    let friction = Friction { coefficient: 0.2, guide: Some(20e-3) };
    task.friction = Some(friction);
    let all = rows(&task, 1);
    let Subject::Bundle(own) = &task.subject else { panic!("no bundle") };
    let mut solver = BundleSolver::new(&own.bundle);
    for (row, _) in &all {
        let mut command = own.base.clone();
        command.drives[1].translation = Drive::Motion(row[0]);
        let found = solver.solve(&command);
        let sides = solver.full_slip(&found, &friction).unwrap();
        for (way, side) in ["loading", "unloading"].into_iter().zip(&sides) {
            let at = |name: &str| row[place(&task, &format!("{way}_{name}"))];
            assert!((at("tube2_tension_N") - side.efforts[1].force).abs() < 1e-5);
            assert!((at("tip_y_m") - side.equilibrium.tip.y).abs() < 1e-8);
            assert!((at("tube2_pull_m") - row[0]).abs() < 1e-12);
        }
        let [on, back] =
            ["loading", "unloading"].map(|way| row[place(&task, &format!("{way}_tube2_tension_N"))]);
        let without = row[place(&task, "tube2_tension_N")];
        assert!(on > 1.01 * without && back < 0.99 * without, "{on} {without} {back}");
    }
}
