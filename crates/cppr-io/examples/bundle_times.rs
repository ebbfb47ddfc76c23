//! What a solve of robots with parts and joints costs, in microseconds on one core: `cargo run --release -p cppr-io --example bundle_times`, in the
//! repository's root; a name chooses one of them. From rest with the error, the least of nine; then a control loop's steps of 0.01 mm and 0.1° from the last pose, the same with the Jacobian: medians.

use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::{Profile, TubeDesign};
use cppr::solve::{Drive, Freedom, Input};
use cppr::statics::{Frame, Loads, Station, Wrench};
use cppr_io::bundle_file::read_bundle;
use std::error::Error;
use std::time::Instant;

/// Tube, translation (mm) and rotation (deg) of a motor that moves.
type Motor = (usize, f64, f64);

/// Robot, and its motors that move.
const ROBOTS: [(&str, &[Motor]); 7] = [
    ("bundles/concentric3", &[(2, 5.0, 40.0), (3, 10.0, -30.0)]),
    ("bundles/two_sections", &[(2, 3.0, 0.0), (4, 2.0, 0.0)]),
    ("bundles/s_shape", &[(2, 2.0, 0.0)]),
    ("bundles/uncut_ends", &[(2, 2.0, 0.0)]),
    ("r1", &[(2, 5.0, 20.0)]),
    (LOADED, &[(2, 4.0, 0.0)]),
    (ROUGH, &[(2, 5.0, 20.0)]),
];
/// R1 with this many point forces along it, of 0.05 N in all.
const LOADED: &str = "r1, 50 loads";
const LOADS: u32 = 50;
const LOAD: f64 = 0.05;
/// R1 whose outer tube has this many notches, each with a depth of its own.
const ROUGH: &str = "r1, 300 notches";
const NOTCHES: u32 = 300;
/// By how much depths differ from their mean (m).
const ROUGHNESS: f64 = 0.06e-3;
/// Error allowed in one step of the integration in the control loop.
const LOOP_TOLERANCE: f64 = 1e-6;
/// Solves from rest.
const FROM_REST: u32 = 9;
/// Steps of the control loop.
const STEPS: u32 = 400;

/// Depths like those of measured notches, by a rule that gives the same ones every time.
fn rough() -> Result<BundleDesign, Box<dyn Error>> {
    let mut design = read_bundle("robots/r1.toml")?;
    let part = &mut design.tubes[0].parts[1];
    let pitch = part.length / f64::from(NOTCHES);
    let TubeDesign::Notched(tube) = &mut part.body else { return Err("R1 has notches".into()) };
    let mean = tube.depth.eval(0.0, part.length)[0];
    let middles: Vec<f64> = (0..NOTCHES).map(|i| (f64::from(i) + 0.5) * pitch).collect();
    let depths: Vec<f64> =
        (0..NOTCHES).map(|i| mean + ROUGHNESS * (f64::from(i) * f64::from(i) * 0.7).sin()).collect();
    tube.depth = Profile::per_notch(&depths, &middles)?;
    Ok(design)
}

/// Forces across the robot at even distances.
fn loads(length: f64) -> Loads {
    let share = length / f64::from(LOADS);
    let own = |i| {
        let station = Station::Label((f64::from(i) + 0.5) * share);
        let force = Vector3::new(0.0, 0.2, 1.0) * (LOAD / f64::from(LOADS));
        Wrench { station, frame: Frame::World, force, moment: Vector3::zeros(), point: Vector3::zeros() }
    };
    Loads { wrenches: (0..LOADS).map(own).collect(), ..Loads::none() }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:<24}{:>12}{:>12}{:>16}{:>10}{:>10}",
        "robot", "from rest", "warm", "with Jacobian", "stable", "steps"
    );
    let only = std::env::args().nth(1);
    for (name, motors) in ROBOTS.into_iter().filter(|own| only.as_ref().is_none_or(|only| own.0 == only)) {
        let design = match name {
            ROUGH => rough()?,
            LOADED => read_bundle("robots/r1.toml")?,
            _ => read_bundle(format!("robots/{name}.toml"))?,
        };
        let bundle = Bundle::new(&design)?;
        let begun = || {
            let mut solver = BundleSolver::new(&bundle).with_loop_tolerance(LOOP_TOLERANCE);
            solver.rest();
            solver
        };
        let mut solver = begun();
        let mut command = solver.held();
        for &(tube, pull, turn) in motors {
            command.drives[tube - 1].translation = Drive::Motion(pull * 1e-3);
            command.drives[tube - 1].rotation = Drive::Motion(turn.to_radians());
        }
        if name == LOADED {
            command.loads = loads(bundle.length());
        }
        let from_rest = |_| {
            let mut solver = begun();
            let clock = Instant::now();
            solver.solve(&command);
            1e6 * clock.elapsed().as_secs_f64()
        };
        let cold = (0..FROM_REST).map(from_rest).fold(f64::INFINITY, f64::min);
        let mut found = solver.solve(&command);
        let moved = |step: u32| -> BundleCommand {
            let there = f64::from(step);
            motors.iter().fold(command.clone(), |own, &(tube, pull, turn)| {
                let put = |command: BundleCommand, freedom, value| {
                    command.with_input(Input { tube, freedom, is_motion: true }, value)
                };
                let own = put(own, Freedom::PushPull, pull * 1e-3 - 1e-5 * there);
                put(own, Freedom::Rotation, (turn - 0.1 * there).to_radians())
            })
        };
        let mut loop_of = |with_jacobian: bool| -> Result<f64, Box<dyn Error>> {
            let mut times = Vec::new();
            for step in 1..=STEPS {
                let command = moved(step % 50);
                let clock = Instant::now();
                solver.solve_into(&command, &mut found);
                if with_jacobian {
                    solver.tip_jacobian(&found).ok_or("a fold")?;
                }
                times.push(1e6 * clock.elapsed().as_secs_f64());
            }
            Ok(median(times))
        };
        let (warm, both) = (loop_of(false)?, loop_of(true)?);
        println!("{name:<24}{cold:>12.0}{warm:>12.1}{both:>16.1}{:>10}{:>10}", found.stable, found.steps);
    }
    Ok(())
}
