//! Sweeps against single solves, against themselves on other threads, after interruptions, and against linear theory.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::analysis::{Perturbed, Place, SectionLimit, Teeth};
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Drive, Equilibrium, Freedom, Input, Settings, Solver};
use cppr::statics::{Loads, Wrench};
use cppr_sweep::{
    Axis, Chunk, DesignKeys, FileOptions, FileProblem, Format, KeyProblem, Plan, RobotSubject, Study,
    Subject, Task, TaskProblem, Values, Variable, Verdict, parts_of, run, write_file,
};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn text(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(name)).unwrap()
}

fn build(text: &str) -> Robot {
    Robot::from_design(cppr_io::robot_file::parse(text).unwrap().design).unwrap()
}

fn motion(tube: usize, freedom: Freedom) -> Variable {
    Variable::Actuator(Input { tube, freedom, is_motion: true })
}

fn range(variable: Variable, from: f64, to: f64, count: u32) -> Axis {
    Axis { variable, values: Values::Range { from, to, count } }
}

fn task(name: &str, axes: Vec<Axis>) -> Task {
    let robot_text = text(name);
    let robot = build(&robot_text);
    let base = Command::held(&robot).with_loads(Loads {
        wrenches: vec![Wrench::tip_force(Vector3::new(0.0, 0.05, 0.02))],
        ..Loads::none()
    });
    let settings = Settings::default().with_resolution(Resolution::PAPER);
    let subject = Subject::Robot(Box::new(RobotSubject { robot, base, settings }));
    Task { subject, robot_text, axes, plan: Plan::Grid, margin: false, limits: None, friction: None }
}

fn own(task: &Task) -> &RobotSubject {
    let Subject::Robot(own) = &task.subject else { panic!("{} is a bundle", task.name()) };
    own
}

fn own_mut(task: &mut Task) -> &mut RobotSubject {
    let Subject::Robot(own) = &mut task.subject else { panic!("no robot") };
    own
}

fn grid() -> Task {
    task(
        "r1.toml",
        vec![
            range(Variable::Force { wrench: 0, component: 1 }, -0.05, 0.05, 3),
            range(motion(2, Freedom::PushPull), -4e-3, 6e-3, 11),
            range(motion(2, Freedom::Rotation), -1.0, 1.0, 13),
        ],
    )
}

/// Rows of a whole run.
fn rows(task: &Task, threads: usize) -> Vec<Vec<f64>> {
    task.check().unwrap();
    let width = task.columns().len();
    let mut rows = Vec::new();
    let flow = run(task, threads, 0..task.chunks(), &AtomicBool::new(false), |chunk: Chunk| {
        assert_eq!(chunk.first_row, rows.len() as u64, "chunks come in order");
        rows.extend((0..chunk.rows).map(|r| (0..width).map(|c| chunk.column(c)[r]).collect::<Vec<_>>()));
        ControlFlow::<()>::Continue(())
    });
    assert_eq!(flow.unwrap(), ControlFlow::Continue(()));
    assert_eq!(rows.len() as u64, task.rows());
    rows
}

fn column(task: &Task, name: &str) -> usize {
    task.columns().iter().position(|c| c.name == name).unwrap_or_else(|| panic!("there is no column {name}"))
}

#[test]
fn rows_are_the_grid_in_order_and_equal_single_solves() {
    let task = grid();
    let table = rows(&task, 2);
    assert_eq!(table.len(), 3 * 11 * 13);
    let mut solver = Solver::with_settings(&own(&task).robot, own(&task).settings).unwrap();
    for (i, row) in table.iter().enumerate() {
        let share = |k: usize, n: usize| k as f64 / (n - 1) as f64;
        let (force, pull, turn) = (
            -0.05 + 0.1 * share(i / (11 * 13), 3),
            -4e-3 + 10e-3 * share(i / 13 % 11, 11),
            -1.0 + 2.0 * share(i % 13, 13),
        );
        for (value, wanted) in row.iter().zip([force, pull, turn]) {
            assert!((value - wanted).abs() < 1e-15, "row {i}: {value} instead of {wanted}");
        }
        // Elsewhere in the tests every row; one in seven is enough for the numbers.
        if i % 7 != 0 {
            continue;
        }
        let mut command = Command::pull(&[pull]).with_loads(own(&task).base.loads.clone());
        command.actuators[0].rotation = Drive::Motion(turn);
        command.loads.wrenches[0].force.y = force;
        let found = solver.solve(&command).unwrap();
        let cppr::kinematics::TipPose { rotation, centre: tip } = solver.tip(&found);
        assert_eq!(Verdict::from_code(row[3]), Some(Verdict::from(found.status())));
        let at = |name: &str| row[column(&task, name)];
        for (name, wanted) in [
            ("tip_x_m", tip.x),
            ("tip_y_m", tip.y),
            ("tip_z_m", tip.z),
            ("tube2_pull_m", pull),
            ("tube2_rotation_rad", turn),
        ] {
            assert!((at(name) - wanted).abs() < 1e-9, "row {i}, {name}: {} instead of {wanted}", at(name));
        }
        assert!((at("tube2_tension_N") - found.actuators()[0].tension).abs() < 1e-6);
        assert!((at("tube2_torque_Nm") - found.actuators()[0].torque).abs() < 1e-8);
        assert!((at("elastic_energy_J") - found.elastic_energy()).abs() < 1e-9);
        // The quaternion turns +X into the tangent.
        let [w, x, y, z] = ["tip_qw", "tip_qx", "tip_qy", "tip_qz"].map(at);
        let tangent = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)];
        for (axis, value) in tangent.into_iter().enumerate() {
            assert!((value - rotation[(axis, 0)]).abs() < 1e-9, "row {i}");
        }
    }
}

/// Rows that were solved side by side, pulled and pushed, unstable, out of reach and impossible ones among them, against single
/// solves from rest.
#[test]
fn every_row_is_what_it_is_alone() {
    let samples = Task { plan: Plan::Samples { count: 300, seed: 5 }, ..grid() };
    // Straight: across there are several stable equilibria.
    let along = range(Variable::Force { wrench: 0, component: 0 }, -60.0, 0.0, 49);
    let mut unstable = task("childs2.toml", vec![along]);
    own_mut(&mut unstable).base.loads.wrenches[0].force = Vector3::zeros();
    let torque = Input { tube: 2, freedom: Freedom::Rotation, is_motion: false };
    let twisted =
        Axis { variable: Variable::Actuator(torque), values: Values::Range { from: 0.0, to: 1e3, count: 2 } };
    let across = range(Variable::Force { wrench: 0, component: 1 }, -0.05, 0.05, 11);
    let failing = task("r1.toml", vec![twisted, across, range(motion(2, Freedom::PushPull), 0.0, 0.3, 3)]);
    let mut counts = [0; Verdict::ALL.len()];
    for task in [samples, unstable, failing] {
        let (status, tip) = (column(&task, "status"), column(&task, "tip_x_m"));
        let effort = column(&task, "tube2_tension_N");
        let mut solver = Solver::with_settings(&own(&task).robot, own(&task).settings).unwrap();
        for (i, row) in rows(&task, 2).iter().enumerate() {
            let mut command = own(&task).base.clone();
            for (axis, value) in task.axes.iter().zip(row) {
                match axis.variable {
                    Variable::Force { component, .. } => command.loads.wrenches[0].force[component] = *value,
                    Variable::Actuator(input) => {
                        let own = &mut command.actuators[0];
                        let drive = if input.freedom == Freedom::PushPull {
                            &mut own.push_pull
                        } else {
                            &mut own.rotation
                        };
                        *drive = if input.is_motion { Drive::Motion(*value) } else { Drive::Effort(*value) };
                    }
                    _ => unreachable!(),
                }
            }
            let alone = solver.solve(&command);
            let wanted = alone.as_ref().map_or(Verdict::InvalidCommand, |found| found.status().into());
            assert_eq!(Verdict::from_code(row[status]), Some(wanted), "row {i}: {row:?}");
            counts[usize::from(wanted.code())] += 1;
            let Some(found) = alone.ok().filter(|found| found.status().is_equilibrium()) else {
                assert!(row[tip..].iter().all(|v| v.is_nan()), "row {i}: {row:?}");
                continue;
            };
            let centre = solver.tip(&found).centre;
            let far = (Vector3::new(row[tip], row[tip + 1], row[tip + 2]) - centre).norm();
            assert!(far < 1e-11, "row {i}: {far}, {row:?}");
            let tension = found.actuators()[0].tension;
            assert!((row[effort] - tension).abs() < 1e-8, "row {i}: {tension} instead of {row:?}");
        }
    }
    let [converged, unstable, path_ends, _, _, invalid] = counts;
    assert!(converged > 300 && unstable > 20 && path_ends > 10 && invalid > 10, "{counts:?}");
}

#[test]
fn a_list_and_a_grid_of_the_same_poses_agree() {
    let grid = grid();
    let table = rows(&grid, 1);
    let list = table.iter().rev().flat_map(|row| row[..3].to_vec()).collect();
    let listed = rows(&Task { plan: Plan::List(list), ..grid }, 1);
    for (one, other) in table.iter().zip(listed.iter().rev()) {
        let tips = one[4..7].iter().zip(&other[4..7]);
        assert!(tips.into_iter().all(|(a, b)| (a - b).abs() < 1e-9), "{one:?}\n{other:?}");
    }
}

/// The file of a task.
fn written(task: &Task, name: &str, threads: usize) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let stop = AtomicBool::new(false);
    let options = FileOptions { threads, resume: false, format: Format::of(&path).unwrap(), stop: &stop };
    let finished = write_file(task, &path, &options, |_| {}, |_| {}).unwrap();
    assert_eq!(finished.counts.iter().sum::<u64>(), task.rows());
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "only the result stays: {left:?}");
    std::fs::read(path).unwrap()
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let grid = Task { margin: true, limits: Some(Teeth::Rigid), ..grid() };
    let samples = Task { plan: Plan::Samples { count: 300, seed: 3 }, ..grid.clone() };
    for name in ["a.csv", "a.npz", "a.parquet"] {
        for task in [&grid, &samples] {
            let one = written(task, name, 1);
            assert!(one == written(task, name, 2) && one == written(task, name, 3), "{name}");
        }
    }
    let other = Task { plan: Plan::Samples { count: 300, seed: 4 }, ..grid };
    assert!(written(&other, "a.csv", 1) != written(&samples, "a.csv", 1), "the seed has no effect");
}

#[test]
fn both_formats_hold_the_same_numbers() {
    let task = Task { margin: true, ..grid() };
    let csv = String::from_utf8(written(&task, "a.csv", 2)).unwrap();
    let mut lines = csv.lines();
    let metadata: serde_json::Value =
        serde_json::from_str(lines.next().unwrap().strip_prefix("# ").unwrap()).unwrap();
    assert_eq!(metadata["schema"], "cppr/sweep");
    assert_eq!(metadata["robot_file"], task.robot_text.as_str());
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let table: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(table.len() as u64, task.rows());
    let npz = written(&task, "a.npz", 2);
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(npz)).unwrap();
    let is_text = |name: &str| matches!(name, "status_text" | "reason");
    for (c, name) in names.iter().enumerate().filter(|(_, name)| !is_text(name)) {
        let array = npyz::NpyFile::new(zip.by_name(&format!("{name}.npy")).unwrap()).unwrap();
        assert_eq!(array.shape(), [task.rows()]);
        let values: Vec<f64> = match *name {
            "status" => array.into_vec::<u8>().unwrap().into_iter().map(f64::from).collect(),
            "newton_steps" => array.into_vec::<i32>().unwrap().into_iter().map(f64::from).collect(),
            _ => array.into_vec::<f64>().unwrap(),
        };
        for (row, value) in table.iter().zip(values) {
            assert_eq!(row[c].parse::<f64>().unwrap().to_bits(), value.to_bits(), "{name}");
        }
    }
    let reasons = npyz::NpyFile::new(zip.by_name("reasons.npy").unwrap()).unwrap();
    assert_eq!(reasons.into_vec::<u8>().unwrap(), b"{}");
    let array = npyz::NpyFile::new(zip.by_name("metadata.npy").unwrap()).unwrap();
    let same: serde_json::Value = serde_json::from_slice(&array.into_vec::<u8>().unwrap()).unwrap();
    assert_eq!(same, metadata);
}

#[test]
fn failures_are_rows() {
    let tension = Variable::Actuator(Input { tube: 2, freedom: Freedom::PushPull, is_motion: false });
    let pulled = task("r1.toml", vec![range(tension, 0.0, 1e6, 3)]);
    let table = rows(&pulled, 1);
    let status = |row: &[f64]| Verdict::from_code(row[1]).unwrap();
    assert_eq!(status(&table[0]), Verdict::Converged);
    assert_eq!(status(&table[2]), Verdict::PathEnds);
    assert!(table[2][2..10].iter().all(|v| v.is_nan()) && !table[2][0].is_nan());
    // Longer than the robot.
    let far = task("r1.toml", vec![range(motion(2, Freedom::PushPull), 0.0, 0.2, 3)]);
    let verdicts: Vec<Verdict> = rows(&far, 1).iter().map(|row| status(row)).collect();
    assert_eq!((verdicts[0], verdicts[2]), (Verdict::Converged, Verdict::InvalidCommand));
    // Notches that cut the tube in two.
    let deep = task("r1.toml", vec![range(Variable::Design("tube1.notches.depth_mm".into()), 5.0, 7.0, 3)]);
    let table = rows(&deep, 1);
    assert_eq!(status(&table[0]), Verdict::Converged);
    assert_eq!(status(&table[2]), Verdict::InvalidDesign);
    let csv = String::from_utf8(written(&deep, "a.csv", 1)).unwrap();
    let last = csv.lines().last().unwrap();
    assert!(last.starts_with("7.0,4,invalid_design,NaN,"), "{csv}");
    // With what is wrong, and what to do.
    let deeper =
        "tube 1, notches.depth_mm: 7.0 mm is deeper than the tube is wide (6.0 mm). Write a depth below 6.0,";
    assert!(last.contains(&format!(",\"{deeper}")) && last.ends_with('"'), "{last}");
    let good = csv.lines().nth(2).unwrap();
    assert!(good.starts_with("5.0,0,converged,") && good.ends_with(','), "{good}");
    let csv = String::from_utf8(written(&far, "a.csv", 1)).unwrap();
    assert!(csv.lines().last().unwrap().contains("\"tube 2"), "{csv}");
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(written(&deep, "a.npz", 1))).unwrap();
    let reasons = npyz::NpyFile::new(zip.by_name("reasons.npy").unwrap()).unwrap().into_vec::<u8>().unwrap();
    let reasons: serde_json::Value = serde_json::from_slice(&reasons).unwrap();
    assert_eq!(reasons.as_object().unwrap().len(), 2);
    assert!(reasons["2"].as_str().unwrap().starts_with(deeper), "{reasons}");
}

/// Several row groups; read again by another program in `crates/cppr-py/tests/test_analysis.py`.
#[test]
fn parquet_holds_the_cells_of_the_csv_and_nulls() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    // Some have no equilibrium, some are beyond the robot's length.
    let mut task = task("r1.toml", vec![range(motion(2, Freedom::PushPull), 0.0, 0.2, 40_000)]);
    let held = Command::held(&own(&task).robot);
    (own_mut(&mut task).settings, own_mut(&mut task).base) = (Settings::planar(), held);
    let mut file = tempfile::tempfile().unwrap();
    std::io::Write::write_all(&mut file, &written(&task, "a.parquet", 2)).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    assert_eq!(reader.num_row_groups(), 2);
    let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let description = pairs.iter().find(|p| p.key == "cppr").unwrap().value.clone().unwrap();
    let csv = String::from_utf8(written(&task, "a.csv", 2)).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next().unwrap(), format!("# {description}"));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let (mut nulls, mut reasons) = (0, 0);
    let mut rows = reader.get_row_iter(None).unwrap();
    for line in lines {
        let row = rows.next().unwrap().unwrap();
        for ((cell, name), (own, field)) in line.split(',').zip(&names).zip(row.get_column_iter()) {
            assert_eq!(name, own);
            match field {
                Field::Null if name == &"reason" => assert_eq!(cell, "", "{name}"),
                Field::Str(value) if name == &"reason" => {
                    reasons += 1;
                    assert!(line.ends_with(&format!(",\"{value}\"")) && value.contains("tube 2"), "{line}");
                }
                Field::Null => {
                    nulls += 1;
                    assert_eq!(cell, "NaN", "{name}");
                }
                Field::Double(value) => {
                    assert_eq!(value.to_bits(), cell.parse::<f64>().unwrap().to_bits(), "{name}");
                }
                Field::Int(value) => assert_eq!(value.to_string(), cell, "{name}"),
                Field::Str(value) => assert_eq!(value, cell, "{name}"),
                other => panic!("{name}: {other}"),
            }
        }
    }
    assert!(rows.next().is_none() && nulls > 10_000 && reasons > 1000, "{nulls} {reasons}");
}

/// Small tolerances act linearly: what the study says of them is what the derivatives say.
#[test]
fn a_study_of_tolerances_agrees_with_the_derivatives() {
    let keys = [
        ("tube1.notches.depth_mm", 5.0, 2e-3),
        ("tube2.notches.depth_mm", 2.0, 1e-3),
        ("length_mm", 150.0, 1e-2),
    ];
    let axes = keys.map(|(key, mean, deviation)| Axis {
        variable: Variable::Design(key.into()),
        values: Values::Normal { mean, deviation },
    });
    let mut task = task("r1.toml", axes.to_vec());
    task.plan = Plan::Samples { count: 200, seed: 1 };
    own_mut(&mut task).base.actuators[0].push_pull = Drive::Motion(4e-3);
    let mut study = Study::new(&task);
    let flow = run(&task, 2, 0..task.chunks(), &AtomicBool::new(false), |chunk: Chunk| {
        study.visit(&chunk);
        ControlFlow::<()>::Continue(())
    });
    assert!(flow.unwrap().is_continue());
    let report = study.report().unwrap();
    assert_eq!(report.count, 200);
    let mut moves: Vec<(String, f64)> = keys
        .iter()
        .map(|(key, mean, deviation)| {
            let tip = |by: f64| {
                let robot = DesignKeys::new(&task.robot_text, &[key]).unwrap().robot(&[mean + by]).unwrap();
                let mut solver = Solver::with_settings(&robot, own(&task).settings).unwrap();
                let found = solver.solve(&own(&task).base).unwrap();
                solver.tip(&found).centre
            };
            (format!("input_{key}"), 0.5 * (tip(*deviation) - tip(-deviation)).norm())
        })
        .collect();
    moves.sort_by(|a, b| b.1.total_cmp(&a.1));
    let total: f64 = moves.iter().map(|(_, moved)| moved * moved).sum();
    for (own, (name, moved)) in report.inputs.iter().zip(&moves) {
        assert_eq!(&own.name, name);
        // The deviation of 200 samples is known to a few per cent.
        assert!((own.tip / moved - 1.0).abs() < 0.05, "{own:?} {moved}");
        assert!((own.share - moved * moved / total).abs() < 0.05, "{own:?}");
    }
    assert_eq!(report.inputs.len(), 3);
    assert!(report.linear > 0.999 && report.linear < 1.0 + 1e-9, "{}", report.linear);
    let y = report.outputs.iter().find(|o| o.name == "tip_y_m").unwrap();
    let [low, middle, high] = y.percentiles;
    // Normal: the 95th percentile is 1.645 deviations from the median.
    for side in [middle - low, high - middle] {
        assert!((side / y.deviation / 1.645 - 1.0).abs() < 0.1, "{y:?}");
    }
    assert!((y.mean - middle).abs() < 0.1 * y.deviation && y.range[0] < low && y.range[1] > high);
    // What does not vary is not told, and two poses do not tell which input matters.
    assert!(report.outputs.iter().all(|o| o.name != "tube2_pull_m"));
    task.plan = Plan::Samples { count: 2, seed: 1 };
    let mut few = Study::new(&task);
    let _ = run(&task, 1, 0..task.chunks(), &AtomicBool::new(false), |chunk: Chunk| {
        few.visit(&chunk);
        ControlFlow::<()>::Continue(())
    });
    assert!(few.report().unwrap().inputs.is_empty());
}

#[test]
fn an_unstable_row_does_not_lead_its_neighbours_astray() {
    let mut task =
        task("childs2.toml", vec![range(Variable::Force { wrench: 0, component: 0 }, -60.0, 0.0, 25)]);
    own_mut(&mut task).base.loads.wrenches[0].force = Vector3::zeros();
    task.margin = true;
    let table = rows(&task, 1);
    let (status, margin) = (column(&task, "status"), column(&task, "margin_to_instability"));
    let verdicts: Vec<Verdict> = table.iter().map(|r| Verdict::from_code(r[status]).unwrap()).collect();
    assert_eq!((verdicts[0], verdicts[24]), (Verdict::Unstable, Verdict::Converged));
    for (row, verdict) in table.iter().zip(verdicts) {
        assert_eq!(row[margin] > 0.0, verdict == Verdict::Converged, "{row:?}");
    }
}

#[test]
fn limits_are_the_greatest_of_all_notches() {
    let mut task = grid();
    // With the middle of a notch at the plate, rounding would decide whether it counts.
    task.axes[1].values = Values::Range { from: -3.7e-3, to: 6.3e-3, count: 11 };
    task.limits = Some(Teeth::Rigid);
    let table = rows(&task, 2);
    let mut solver = Solver::with_settings(&own(&task).robot, own(&task).settings).unwrap();
    for row in table.iter().step_by(61) {
        let mut command = Command::pull(&[row[1]]).with_loads(own(&task).base.loads.clone());
        command.actuators[0].rotation = Drive::Motion(row[2]);
        command.loads.wrenches[0].force.y = row[0];
        let found = solver.solve(&command).unwrap();
        let sections = solver.section_limits(&found, Teeth::Rigid);
        let strain = sections.iter().map(|s| s.strain.abs() / 0.015).fold(0.0, f64::max);
        let closure = sections.iter().filter_map(|s| s.closure).fold(f64::NEG_INFINITY, f64::max);
        let at = |name: &str| row[column(&task, name)];
        for (value, wanted) in [(at("strain_utilisation"), strain), (at("closure_utilisation"), closure)] {
            assert!(wanted > 1e-3 && (value - wanted).abs() < 1e-8, "{value} instead of {wanted}: {row:?}");
        }
        // And where: the notch that the numbers name has that strain, closure or shear.
        for limit in ["strain", "closure", "torsion"] {
            let [tube, notch, x] = ["tube", "notch", "x_m"].map(|what| at(&format!("{limit}_{what}")));
            let there = |s: &&SectionLimit| {
                let Place::Notch(number) = s.place else { return false };
                (s.tube as f64 - tube).abs() < 0.5 && (f64::from(number) - notch).abs() < 0.5
            };
            let own =
                sections.iter().find(there).unwrap_or_else(|| panic!("no notch {notch} of tube {tube}"));
            let used = match limit {
                "strain" => own.strain_utilisation(),
                "closure" => own.closure,
                _ => own.torsion_utilisation(),
            };
            let value = at(&format!("{limit}_utilisation"));
            assert!((used.unwrap() - value).abs() < 1e-8 && (own.abscissa - x).abs() < 1e-12, "{row:?}");
        }
        let bend = solver.tip(&found).tangent().x.acos();
        assert!((at("bend_angle_rad") - bend).abs() < 1e-7, "{bend}: {row:?}");
    }
    // Without an allowable strain there is none to compare with.
    let text = task.robot_text.replace("allowable_strain_percent = 1.5", "");
    let mut plain = Task { limits: Some(Teeth::Rigid), ..grid() };
    own_mut(&mut plain).robot = build(&text);
    let column = column(&plain, "strain_utilisation");
    assert!(rows(&plain, 2).iter().all(|row| row[column].is_nan()));
}

#[test]
fn an_interrupted_file_is_resumed_to_the_same_bytes() {
    let task = Task { limits: Some(Teeth::Rigid), ..grid() };
    let whole = written(&task, "a.csv", 2);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    let stop = AtomicBool::new(false);
    let options = |resume, stop| FileOptions { threads: 2, resume, format: Format::Csv, stop };
    let interrupted = write_file(
        &task,
        &path,
        &options(false, &stop),
        |done| stop.store(done >= 100, std::sync::atomic::Ordering::Relaxed),
        |_| {},
    );
    let Err(FileProblem::Stopped(done, 429, _)) = interrupted else { panic!("{interrupted:?}") };
    assert!((100..429).contains(&done) && !path.exists());
    let go = AtomicBool::new(false);
    // A record of which only a part was written, and one whose bytes were lost.
    let rows = parts_of(&path).join("rows.bin");
    let mut bytes = std::fs::read(&rows).unwrap();
    let length = bytes.len();
    bytes[length - 50] ^= 1;
    bytes.extend([7; 1000]);
    std::fs::write(&rows, bytes).unwrap();
    let refused = |task: &Task, resume| {
        write_file(task, &path, &options(resume, &go), |_| {}, |_| {}).unwrap_err().to_string()
    };
    assert!(refused(&task, false).contains("unfinished sweep"));
    let other = Task { margin: true, ..task.clone() };
    assert!(refused(&other, true).contains("another task (columns differ)"), "{}", refused(&other, true));
    let mut begun = None;
    write_file(
        &task,
        &path,
        &options(true, &go),
        |d| {
            begun.get_or_insert(d);
        },
        |_| {},
    )
    .unwrap();
    assert!(begun.unwrap() < done && begun.unwrap() > 0, "{begun:?} of {done}");
    assert!(std::fs::read(&path).unwrap() == whole);
    assert!(!parts_of(&path).exists());
    // Resuming what is not there begins anew.
    write_file(&task, &path, &options(true, &go), |_| {}, |_| {}).unwrap();
    assert!(std::fs::read(&path).unwrap() == whole);
}

/// Deviations of the tip by those of four design parameters: first order, Σ (∂y/∂p σ)², against samples.
#[test]
fn tolerances_agree_with_linear_propagation() {
    let keys = [
        ("tube1.notches.depth_mm", 5.0, 2e-3),
        ("tube2.notches.depth_mm", 2.0, 1e-3),
        ("tube1.outer_radius_mm", 3.0, 1e-3),
        ("material.poissons_ratio", 0.35, 1e-3),
    ];
    let axes = keys.iter().map(|&(key, mean, deviation)| Axis {
        variable: Variable::Design(key.into()),
        values: Values::Normal { mean, deviation },
    });
    let mut task = task("r1.toml", axes.collect());
    let loads = own(&task).base.loads.clone();
    own_mut(&mut task).base = Command::pull(&[5e-3]).with_loads(loads);
    task.plan = Plan::Samples { count: 256, seed: 1 };
    let table = rows(&task, 2);
    let count = table.len() as f64;
    let tip: Vec<usize> = ["tip_x_m", "tip_y_m", "tip_z_m"].iter().map(|n| column(&task, n)).collect();
    let sampled = tip.iter().map(|&c| {
        let mean = table.iter().map(|row| row[c]).sum::<f64>() / count;
        (table.iter().map(|row| (row[c] - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt()
    });
    let mut solver = Solver::with_settings(&own(&task).robot, own(&task).settings).unwrap();
    let found = solver.solve(&own(&task).base).unwrap();
    let mut variance = [0.0; 3];
    for (key, mean, deviation) in keys {
        let at = |by: f64| DesignKeys::new(&task.robot_text, &[key]).unwrap().robot(&[mean + by]).ok();
        let perturbed = Perturbed::new(1e-3 * mean, at).unwrap();
        let read = |solver: &mut Solver, found: &Equilibrium| -> Vec<f64> {
            solver.tip(found).centre.iter().copied().collect()
        };
        let slope = solver.parameter_sensitivity(&found, &perturbed, read).unwrap();
        for (sum, slope) in variance.iter_mut().zip(slope) {
            *sum += (slope * deviation).powi(2);
        }
    }
    for (sampled, linear) in sampled.zip(variance.map(f64::sqrt)) {
        assert!(linear > 1e-6, "{linear}");
        assert!((sampled / linear - 1.0).abs() < 0.01, "sampled {sampled}, linear {linear}");
    }
}

#[test]
fn wrong_tasks_are_refused() {
    let good = grid();
    let refused = |task: Task| task.check().unwrap_err();
    assert_eq!(refused(Task { axes: vec![], ..good.clone() }), TaskProblem::NoAxis);
    let pull = |from, to, count| range(motion(2, Freedom::PushPull), from, to, count);
    let with = |axes| Task { axes, ..good.clone() };
    assert_eq!(refused(with(vec![pull(0.0, 1e-3, 0)])), TaskProblem::NoPose);
    assert!(matches!(refused(with(vec![pull(f64::NAN, 1e-3, 3)])), TaskProblem::Values(_)));
    assert!(matches!(refused(with(vec![pull(0.0, 1e-3, 3), pull(0.0, 1e-3, 3)])), TaskProblem::Twice(_)));
    let third = range(motion(3, Freedom::PushPull), 0.0, 1e-3, 2);
    assert!(matches!(refused(with(vec![third])), TaskProblem::NoSuchInput(_)));
    let wrench = range(Variable::Force { wrench: 1, component: 0 }, 0.0, 1.0, 2);
    assert!(matches!(refused(with(vec![wrench])), TaskProblem::NoSuchInput(_)));
    let normal = Axis {
        variable: motion(2, Freedom::PushPull),
        values: Values::Normal { mean: 0.0, deviation: 1e-3 },
    };
    assert!(matches!(refused(with(vec![normal])), TaskProblem::NotSampled(_)));
    let turn = range(motion(2, Freedom::Rotation), 0.0, 1.0, 1_000_000);
    let many = refused(with(vec![pull(0.0, 1e-3, 1_000_000), turn])).to_string();
    assert!(many.contains("1.0e12 poses, 136000.0 GB"), "{many}");
    let key = |key: &str| match refused(with(vec![range(Variable::Design(key.into()), 1.0, 2.0, 2)])) {
        TaskProblem::Key(problem) => problem,
        other => panic!("{other}"),
    };
    assert!(key("tube3.notches.depth_mm").to_string().contains("its list ends with 2"));
    assert!(key("tube1.notches.depth").to_string().contains("depth_mm"));
    assert!(matches!(key("name"), KeyProblem::NotANumber(..)));
    assert!(matches!(key("tube1.notches"), KeyProblem::NotANumber(_, "a table")));
}
