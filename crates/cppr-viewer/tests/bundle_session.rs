//! What the page is answered for robots with parts and joints, and for those with changes that modes do not follow.
#![allow(clippy::unwrap_used, clippy::panic)]

use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, Friction};
use cppr::solve::Drive;
use cppr_io::Scenario;
use cppr_io::bundle_file::{self, Described};
use cppr_io::scenario::{ActuatorEntry, FormulationName};
use cppr_viewer::message::Message;
use cppr_viewer::session::{Cloud, File, Request, Session, Solve, Touch};
use serde_json::Value;

/// A session that shows a robot, and what the page was told of it.
fn session(name: &str) -> (Session, Vec<Value>) {
    let path = format!("{}/../../robots/bundles/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    shown(Session::new(
        Described::Bundle { design: bundle_file::read_bundle(path).unwrap(), friction: None },
        None,
    ))
}

/// The same of a robot file of any kind, with what is asked of it at first.
fn started(path: &str, start: Option<Scenario>) -> (Session, Vec<Value>) {
    let path = format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"));
    shown(Session::new(bundle_file::read(path).unwrap(), start))
}

fn shown(mut session: Session) -> (Session, Vec<Value>) {
    let told = ask(&mut session, Request::Robot(None));
    (session, told.into_iter().map(|(head, _)| head).collect())
}

/// Answers: heads, and floats where there are some.
fn ask(session: &mut Session, request: Request) -> Vec<(Value, Vec<f32>)> {
    let mut answers = Vec::new();
    session.answer(request, &mut |message| {
        answers.push(match message {
            Message::Text(text) => (serde_json::from_str(&text).unwrap(), Vec::new()),
            Message::Binary(bytes) => {
                let end = 4 + u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
                let floats = bytes[end..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
                (serde_json::from_slice(&bytes[4..end]).unwrap(), floats.collect())
            }
        });
        true
    });
    answers
}

fn solve(session: &mut Session, asked: Solve) -> (Value, Vec<f32>) {
    ask(session, Request::Solve(Box::new(asked))).pop().unwrap()
}

fn pulls(pulls: &[(usize, f64)]) -> Solve {
    let entry = |&(tube, pull)| ActuatorEntry { tube, pull_mm: Some(pull), ..ActuatorEntry::default() };
    let scenario = Scenario { actuator: pulls.iter().map(entry).collect(), ..Scenario::default() };
    Solve { scenario, ..Solve::default() }
}

fn tip(pose: &Value) -> [f64; 3] {
    serde_json::from_value(pose["tip_mm"].clone()).unwrap()
}

/// Contact and friction of the pose that was shown last, of robots of either kind, as the program tells them; nothing without a pose.
#[test]
fn what_the_tubes_do_to_each_other_is_told() {
    for (path, pull) in [("robots/r1.toml", 5.0), ("robots/bundles/two_sections.toml", 2.0)] {
        let (mut session, _) = started(path, None);
        let touch = |coefficient, guide_mm| Request::Touch(Touch { id: 7, coefficient, guide_mm });
        assert!(ask(&mut session, touch(0.2, 0.0)).is_empty());
        let (pose, _) = solve(&mut session, pulls(&[(2, pull)]));
        let mut told =
            |coefficient, guide_mm| ask(&mut session, touch(coefficient, guide_mm)).pop().unwrap().0;
        let free = told(0.0, 20.0);
        assert_eq!((free["kind"].as_str(), free["id"].as_u64()), (Some("touch"), Some(7)));
        assert!(free["friction"].is_null() && free["problem"].is_null());
        let design =
            bundle_file::read(format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))).unwrap().into_bundle();
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let mut command = solver.held();
        command.drives[1].translation = Drive::Motion(pull * 1e-3);
        let found = solver.solve(&command);
        let greatest = solver.contact(&found, 1e-3).unwrap().pairs[0].greatest();
        let forces = free["contact"]["pairs"][0]["force_N_m"].as_array().unwrap();
        let norm =
            |f: &Value| f.as_array().unwrap().iter().map(|c| c.as_f64().unwrap().powi(2)).sum::<f64>().sqrt();
        let most = forces.iter().map(norm).fold(0.0, f64::max);
        assert!(greatest > 1.0 && (most / greatest - 1.0).abs() < 0.05, "{path}: {most} {greatest}");
        let rubs = told(0.2, 20.0);
        let sides = solver.full_slip(&found, &Friction { coefficient: 0.2, guide: Some(0.02) }).unwrap();
        for (way, side) in ["loading", "unloading"].into_iter().zip(sides) {
            let own = rubs["friction"][way]["actuators"][1]["tension_N"].as_f64().unwrap();
            let (want, free) = (side.efforts[1].force, &pose["actuators"]);
            assert!((own / want - 1.0).abs() < 1e-4, "{path} {way}: {own} {want}");
            let free = free.as_array().unwrap().iter().find(|a| a["tube"] == 2).unwrap();
            assert!((own > free["tension_N"].as_f64().unwrap()) == (way == "loading"));
        }
        assert!(told(2.5, 0.0)["problem"].as_str().unwrap().contains("tubes jam"));
    }
    // The printed equations have no contact force.
    let (mut session, _) = started("robots/r1.toml", None);
    let scenario = Scenario { formulation: FormulationName::Printed, ..pulls(&[(2, 5.0)]).scenario };
    solve(&mut session, Solve { scenario, ..Solve::default() });
    let told = ask(&mut session, Request::Touch(Touch::default())).pop().unwrap().0;
    assert!(told["contact"].is_null() && told["problem"].as_str().unwrap().contains("consistent"), "{told}");
}

/// Two sections: the outer pair ends at its joint, half-way along the inner one, whose last section is the tip.
#[test]
fn a_pose_says_where_tubes_end_and_are_joined() {
    let (mut session, told) = session("two_sections");
    let tubes: Vec<i64> =
        told[0]["controls"].as_array().unwrap().iter().map(|c| c["tube"].as_i64().unwrap()).collect();
    assert_eq!(tubes, [1, 2, 3, 4]);
    let (pose, _) = solve(&mut session, pulls(&[(2, 3.0), (4, 2.0)]));
    let last = pose["sections"].as_i64().unwrap() - 1;
    let ends: Vec<i64> = serde_json::from_value(pose["ends"].clone()).unwrap();
    assert!(ends[0] < last && ends[1] == ends[0] && ends[2] == last && ends[3] == last, "{ends:?}");
    let joints: Vec<[i64; 2]> = serde_json::from_value(pose["joints"].clone()).unwrap();
    assert_eq!(joints.iter().map(|j| j[1]).collect::<Vec<_>>(), [0, 2]);
    assert!((joints[0][0] - ends[0]).abs() <= 1 && (joints[1][0] - last).abs() <= 1, "{joints:?}");
    assert!(pose["error_mm"].as_f64().unwrap() < 1e-3 && pose["status"] == "converged");
}

/// The tip goes where the pointer is, from where the robot is, and the motors are told with it.
#[test]
fn the_tip_is_dragged() {
    let (mut session, _) = session("two_sections");
    let start = pulls(&[(2, 3.0), (4, 2.0)]);
    let [x, y, z] = tip(&solve(&mut session, start.clone()).0);
    let target = [x + 1.0, y + 1.0, z + 2.0];
    let (dragged, _) = solve(&mut session, Solve { target_mm: Some(target), ..start });
    let there = tip(&dragged);
    assert!((0..3).all(|i| (there[i] - target[i]).abs() < 0.05), "{there:?} instead of {target:?}");
    let entry = |a: &Value| ActuatorEntry {
        tube: usize::try_from(a["tube"].as_u64().unwrap()).unwrap(),
        pull_mm: a["pull_mm"].as_f64(),
        rotate_deg: a["rotate_deg"].as_f64(),
        ..ActuatorEntry::default()
    };
    let actuator = dragged["actuators"].as_array().unwrap().iter().map(entry).collect();
    let again = Solve { scenario: Scenario { actuator, ..Scenario::default() }, ..Solve::default() };
    let again = tip(&solve(&mut session, again).0);
    assert!((0..3).all(|i| (there[i] - again[i]).abs() < 1e-4), "{there:?} {again:?}");
}

/// Beyond its tip a tube keeps its last values, and what is behind the plate lies along the axis.
#[test]
fn floats_have_every_tube_at_every_section() {
    let (mut session, told) = session("concentric3");
    let columns = told[0]["columns"].as_array().unwrap().len();
    let (pose, floats) = solve(&mut session, pulls(&[(1, 120.0), (3, -10.0)]));
    let sections = usize::try_from(pose["sections"].as_u64().unwrap()).unwrap();
    assert_eq!(floats.len(), sections * 3 * columns);
    assert_eq!((&pose["ends"][0], &pose["spine"]), (&Value::from(-1), &Value::from(2)));
    let last = |tube: usize| &floats[(3 * (sections - 1) + tube) * columns..][..columns];
    assert!((last(0)[0] - 120.0).abs() < 1e-4 && last(0)[1..4].iter().all(|v| v.abs() < 1e-6));
    assert!((last(1)[0] - 140.0).abs() < 1e-4 && (last(2)[0] - 180.0).abs() < 1e-4);
    let tip = tip(&pose);
    let off =
        |tube: usize| (0..3).map(|i| (f64::from(last(tube)[i + 1]) - tip[i]).powi(2)).sum::<f64>().sqrt();
    assert!(off(2) < 1e-4 && off(1) > 10.0, "{} {}", off(2), off(1));
}

#[test]
fn what_cannot_be_asked_is_refused_with_a_sentence() {
    let (mut session, told) = session("uncut_ends");
    assert_eq!(told.iter().filter(|m| m["kind"] == "mesh").count(), 4, "two bodies, each fine and coarse");
    let mut refused = |asked: Solve, status: &str, fragment: &str| {
        let (answer, _) = solve(&mut session, asked);
        assert_eq!(
            (&answer["kind"], &answer["status"]),
            (&Value::from("refused"), &Value::from(status)),
            "{answer}"
        );
        assert!(answer["reasons"].to_string().contains(fragment), "{answer}");
    };
    refused(pulls(&[(2, 200.0)]), "wrong", "behind the plate");
    refused(pulls(&[(2, 100.0)]), "not_converged", "no equilibrium was found");
    refused(pulls(&[(3, 1.0)]), "wrong", "there is no tube 3");
    for text in [
        "modes = \"planar\"",
        "formulation = \"printed\"",
        "refine = 2",
        "rotation_means = \"relative_angle\"",
    ] {
        let scenario = Scenario::parse(text).unwrap();
        refused(Solve { scenario, ..Solve::default() }, "wrong", "not for a robot with parts or joints");
    }
    let both = Scenario::parse("[[actuator]]\ntube = 1\npull_mm = 1\ntension_N = 1").unwrap();
    refused(Solve { scenario: both, ..Solve::default() }, "wrong", "not both");
    let cloud = Cloud { scenario: Scenario::default(), ranges: Vec::new(), count: 1 };
    let (answer, _) = ask(&mut session, Request::Workspace(Box::new(cloud))).pop().unwrap();
    assert!(answer["text"].as_str().unwrap().contains("cppr sweep"), "{answer}");
}

const STEPS: &str = "crates/cppr-cli/tests/data/steps_in_a_table.toml";

/// The right tip is that of `answers_say_how_accurate_they_are` among the tests of the program.
#[test]
fn a_robot_with_sudden_changes_is_integrated_and_the_page_is_told() {
    let off = |pose: &Value| (tip(pose)[0] - 88.599).hypot(tip(pose)[1] + 50.173);
    let (mut session, told) = started(STEPS, None);
    let note = told[0]["note"].as_str().unwrap();
    assert!(note.contains("notch depth of tube 1 at 30 mm"), "{note}");
    let (pose, _) = solve(&mut session, pulls(&[(2, 2.0)]));
    assert!(off(&pose) < 0.01, "{pose}");
    assert!((pose["actuators"][1]["tension_N"].as_f64().unwrap() - 1.8538).abs() < 1e-3);
    let text = std::fs::read_to_string(format!("{}/../../{STEPS}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let dropped = ask(&mut session, Request::Robot(Some(File { name: "steps.toml".into(), text })));
    assert_eq!(dropped[0].0["note"], note);

    // What is asked at first needs modes.
    let chosen = Scenario::parse("refine = 2").unwrap();
    let (mut session, told) = started(STEPS, Some(chosen.clone()));
    assert_eq!((&told[0]["note"], &told[0]["bundle"]), (&Value::Null, &Value::Null));
    let asked = pulls(&[(2, 2.0)]);
    let asked = Solve { scenario: Scenario { actuator: asked.scenario.actuator, ..chosen }, ..asked };
    let (pose, _) = solve(&mut session, asked);
    assert!(off(&pose) > 1.0, "{pose}");
    let (told, _) = ask(&mut session, Request::Error).pop().unwrap();
    assert!((told["error_mm"].as_f64().unwrap() - off(&pose)).abs() < 0.1, "{told}");
    assert!(told["advice"].as_str().unwrap().contains("take more"), "{told}");
}

/// The error of the modes is told where the page asks for it; poses of a saved page take as many modes as they need.
#[test]
fn modes_have_an_error() {
    let (mut session, _) = started("robots/r3.toml", None);
    assert!(ask(&mut session, Request::Error).is_empty());
    let (pose, _) = solve(&mut session, pulls(&[(2, 5.0)]));
    assert_eq!(pose["error_mm"], Value::Null);
    let (told, _) = ask(&mut session, Request::Error).pop().unwrap();
    assert!((1e-9..1e-4 * 150.0).contains(&told["error_mm"].as_f64().unwrap()), "{told}");
    assert_eq!(told["advice"], Value::Null);

    // One notch is deeper than the others.
    let path = format!("{}/../../robots/r1.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let deeper = "depth_mm = [5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.3, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]";
    let robot = bundle_file::parse_either(&text.replacen("depth_mm = 5.0", deeper, 1)).unwrap();
    let (mut session, told) = shown(Session::new(robot, None));
    assert_eq!(told[0]["note"], Value::Null);
    let asked = pulls(&[(2, 5.0)]);
    solve(&mut session, asked.clone());
    let usual = ask(&mut session, Request::Error).pop().unwrap().0["error_mm"].as_f64().unwrap();
    let (resolved, _) = solve(&mut session, Solve { resolved: true, from_rest: true, ..asked });
    let finer = resolved["error_mm"].as_f64().unwrap();
    assert!(usual > 1e-4 * 150.0 && finer < usual, "{usual} {finer}");
}
