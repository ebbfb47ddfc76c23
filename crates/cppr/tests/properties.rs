//! What must hold for any robot: invariance, symmetry, work, balance, and answers instead of NaN.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{Random, converged, prototype, robot, stiff_tube};
use cppr::design::{BelowPlate, Profile, Robot, StiffnessTube, TubeDesign};
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Settings, Solver};
use cppr::statics::{DistributedForce, Frame, Loads, RotationMeans, Station, Thread, Wrench};
use cppr::{Matrix3, Vector3};
use std::f64::consts::PI;

fn about_x(angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// A random robot of `count` tubes in the range of printed prototypes; `sign` mirrors its directions and `turn`
/// rotates it about X.
fn random_robot(seed: u32, count: u32, sign: f64, turn: f64) -> Robot {
    profiled_robot(seed, count, sign, turn, false)
}

/// The same with fields that are linear along the tubes where `smooth`, with kinks where not.
fn profiled_robot(seed: u32, count: u32, sign: f64, turn: f64, smooth: bool) -> Robot {
    let mut random = Random::new(seed.into());
    let tubes = (0..count)
        .map(|k| {
            let direction = PI * 2.0 / f64::from(count) * f64::from(k) + 0.3 * random.next();
            let (helix, scale) = (1.5 * random.next(), random.between(0.4, 1.0));
            let mut ramp = |low: f64, high: f64| {
                let (a, b, c) =
                    (random.between(low, high), random.between(low, high), random.between(low, high));
                if smooth {
                    Profile::linear(a, c)
                } else {
                    Profile::table(&[0.0, 0.06, 0.15], &[a, b, c]).unwrap()
                }
            };
            TubeDesign::Stiffness(StiffnessTube {
                centroid_offset: ramp(0.8e-3, 3e-3),
                direction: Profile::linear(sign * direction + turn, sign * (direction + helix) + turn),
                bending_y: ramp(5e-3 * scale, 12e-3 * scale),
                bending_z: ramp(0.7e-3 * scale, 1.5e-3 * scale),
                torsion: ramp(2e-3 * scale, 4e-3 * scale),
                axial: Some(ramp(8e3, 16e3)),
                mass_per_length: ramp(0.02, 0.05),
                centroid_offset_factor: 1.0,
            })
        })
        .collect();
    robot(0.15, tubes)
}

/// Every kind of load, in a base frame turned and mirrored by `map`.
fn random_loads(seed: u32, map: &Matrix3<f64>) -> Loads {
    let mut random = Random::new(seed.into());
    let sense = map.determinant();
    let wrench = |random: &mut Random, station: Station, frame: Frame| {
        let (force, moment, point) = (random.vector(0.1), random.vector(2e-3), random.vector(3e-3));
        // Components in section axes are not turned with the base frame, only mirrored.
        let own = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sense));
        let by = if frame == Frame::World { *map } else { own };
        Wrench { force: by * force, moment: by * moment * sense, frame, station, point: own * point }
    };
    let mut loads = Loads::none();
    loads.wrenches.push(wrench(&mut random, Station::Tip, Frame::World));
    loads.wrenches.push(wrench(&mut random, Station::Label(0.07), Frame::Section));
    loads.distributed.push(DistributedForce { force: map * random.vector(1.0), from: 0.03, to: 0.11 });
    loads.gravity = Some(map * random.vector(9.81));
    loads
}

fn random_command(seed: u32, followers: u32, sign: f64, loads: Loads) -> Command {
    let mut random = Random::new(seed.into());
    let actuators = (0..followers)
        .map(|_| Actuator {
            push_pull: Drive::Motion(1.5e-3 * random.next()),
            rotation: Drive::Motion(sign * random.next()),
        })
        .collect();
    Command { actuators, loads, rotation_means: RotationMeans::Base }
}

#[test]
fn turning_and_mirroring_the_world_turns_and_mirrors_the_robot() {
    let settings = Settings::default();
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    for seed in 0..6 {
        let count = 2 + seed % 3;
        let solved = |sign: f64, turn: f64, map: Matrix3<f64>| {
            let robot = random_robot(seed, count, sign, turn);
            let _solver = Solver::new(&robot);
            let command = random_command(seed, count - 1, sign, random_loads(seed, &map));
            let found = converged(&robot, &command, &settings);
            let tip = found.tip();
            (found, (tip.rotation, tip.centre))
        };
        let (plain, (rotation, tip)) = solved(1.0, 0.0, Matrix3::identity());
        let (turned, (turned_rotation, turned_tip)) = solved(1.0, 0.8, about_x(0.8));
        let (seen, (_, seen_tip)) = solved(-1.0, 0.0, mirror);
        assert!((turned_tip - about_x(0.8) * tip).norm() < 1e-9 * 0.15, "seed {seed}: turned");
        assert!((turned_rotation - about_x(0.8) * rotation).norm() < 1e-8);
        assert!((seen_tip - mirror * tip).norm() < 1e-9 * 0.15, "seed {seed}: mirrored {seen_tip} {tip}");
        assert!(tip.z.abs() > 1e-4, "seed {seed} stays in the plane and shows nothing");
        for f in 0..plain.actuators().len() {
            let (a, b, c) = (plain.actuators()[f], turned.actuators()[f], seen.actuators()[f]);
            assert!((a.tension - b.tension).abs() < 1e-8 && (a.tension - c.tension).abs() < 1e-8);
            assert!((a.torque - b.torque).abs() < 1e-10 && (a.torque + c.torque).abs() < 1e-10);
        }
    }
}

#[test]
fn followers_may_be_numbered_in_any_order() {
    let first = random_robot(3, 3, 1.0, 0.0);
    let mut design = first.design().clone();
    design.tubes.swap(1, 2);
    let second = Robot::from_design(design).unwrap();
    let command = random_command(3, 2, 1.0, random_loads(3, &Matrix3::identity()));
    let mut swapped = command.clone();
    swapped.actuators.swap(0, 1);
    let a = converged(&first, &command, &Settings::default());
    let b = converged(&second, &swapped, &Settings::default());
    assert!((a.actuators()[0].tension - b.actuators()[1].tension).abs() < 1e-8);
    assert!((a.elastic_energy() - b.elastic_energy()).abs() < 1e-10 * a.elastic_energy());
}

#[test]
fn the_tip_of_a_uniform_planar_robot_turns_by_pull_over_offset_under_any_load() {
    let mut random = Random::new(11);
    let tubes = vec![
        stiff_tube(3e-3, [0.012, 1e-3], 4e-3, 0.0, 0.0),
        stiff_tube(1.1e-3, [0.005, 0.7e-3], 2e-3, PI, 0.0),
    ];
    let robot = robot(0.15, tubes);
    let mut solver = Solver::new(&robot);
    for _ in 0..8 {
        let motion = 5e-3 * random.next();
        let flat = |v: Vector3<f64>| Vector3::new(v.x, v.y, 0.0);
        let mut loads = Loads::tip_force(flat(random.vector(0.3)));
        loads.wrenches[0].moment.z = 5e-3 * random.next();
        loads.wrenches.push(Wrench {
            station: Station::Label(0.05),
            frame: Frame::Section,
            ..Wrench::tip_force(flat(random.vector(0.3)))
        });
        loads.distributed.push(DistributedForce { force: flat(random.vector(2.0)), from: 0.0, to: 0.1 });
        let command = Command::pull(&[motion]).with_loads(loads);
        let found = converged(&robot, &command, &Settings::planar());
        let cppr::kinematics::TipPose { rotation, .. } = solver.tip(&found);
        let angle = rotation[(1, 0)].atan2(rotation[(0, 0)]);
        assert!((angle + motion / 4.1e-3).abs() < 1e-9, "{angle} {}", -motion / 4.1e-3);
    }
}

/// ∫ (T dΔa + Υ dΩ) along a path of commands, by Gauss–Legendre, against U at its end.
#[test]
fn actuators_work_is_the_energy_stored() {
    let nodes = gauss_quad::GaussLegendre::new(std::num::NonZeroUsize::new(12).unwrap());
    let robots = [
        (random_robot(5, 2, 1.0, 0.0), vec![(3e-3, 0.9)]),
        (random_robot(6, 3, 1.0, 0.0), vec![(-1e-3, 0.5), (2e-3, -0.7)]),
        // Pushed, the uncut part enters: the work it takes at the edge is included.
        (prototype("R3", 1.26, BelowPlate::Plain), vec![(-8e-3, 0.4)]),
        (prototype("R1", 1.26, BelowPlate::Plain), vec![(-5e-3, -0.6)]),
    ];
    for (robot, path) in robots {
        let _solver = Solver::new(&robot);
        let at = |s: f64| Command {
            actuators: path
                .iter()
                .map(|&(a, turn)| Actuator {
                    push_pull: Drive::Motion(a * s),
                    rotation: Drive::Motion(turn * s),
                })
                .collect(),
            ..Command::held(&robot)
        };
        let mut work = 0.0;
        for &(x, weight) in &nodes {
            let found = converged(&robot, &at(0.5 * (x + 1.0)), &Settings::default());
            for (actuator, (a, turn)) in found.actuators().iter().zip(&path) {
                work += 0.5 * weight * (actuator.tension * a + actuator.torque * turn);
            }
        }
        let stored = converged(&robot, &at(1.0), &Settings::default()).elastic_energy();
        assert!((work - stored).abs() < 1e-6 * stored, "work {work} J, energy {stored} J");
    }
}

#[test]
fn prescribed_efforts_lead_back_to_the_prescribed_motion() {
    for seed in 0..4 {
        let robot = random_robot(seed, 3, 1.0, 0.0);
        let mut solver = Solver::new(&robot);
        let command = random_command(seed, 2, 1.0, random_loads(seed, &Matrix3::identity()));
        let moved = converged(&robot, &command, &Settings::default());
        let actuators = moved
            .actuators()
            .iter()
            .zip(&command.actuators)
            .enumerate()
            .map(|(f, (state, drive))| match (f + usize::from(seed % 2 == 0)) % 3 {
                0 => Actuator {
                    push_pull: Drive::Effort(state.tension),
                    rotation: Drive::Effort(state.torque),
                },
                1 => Actuator { push_pull: Drive::Effort(state.tension), ..*drive },
                _ => Actuator { rotation: Drive::Effort(state.torque), ..*drive },
            })
            .collect();
        let pulled = Command { actuators, ..command.clone() };
        // Under efforts it may be unstable: from rest, another one is found then.
        let near = converged(&robot, &command.scaled(0.9), &Settings::default());
        let found = solver.solve_from(&pulled, &near).unwrap();
        assert!(found.status().is_equilibrium());
        for (a, b) in moved.actuators().iter().zip(found.actuators()) {
            assert!((a.motion - b.motion).abs() < 1e-9 * 0.15, "seed {seed}: {} {}", a.motion, b.motion);
            assert!((a.rotation - b.rotation).abs() < 1e-8);
        }
    }
}

#[test]
fn a_push_force_too_small_for_the_uncut_part_leaves_the_follower_at_the_plate() {
    let robot = prototype("R1", 1.26, BelowPlate::Plain);
    let _solver = Solver::new(&robot);
    let bent = |force: f64| Command {
        actuators: vec![Actuator { push_pull: Drive::Effort(force), rotation: Drive::Motion(0.0) }],
        loads: Loads::tip_force(Vector3::new(0.0, 0.2, 0.0)),
        rotation_means: RotationMeans::Base,
    };
    let held = Command { actuators: vec![Actuator::HELD], ..bent(0.0) };
    let outside = converged(&robot, &held, &Settings::default()).actuators()[0].tension;
    let slightly = Command { actuators: vec![Actuator::pulled(-1e-6)], ..bent(0.0) };
    let inside = converged(&robot, &slightly, &Settings::default()).actuators()[0].tension;
    assert!(outside - inside > 1e-3, "the force jumps where the uncut part enters: {outside} {inside}");
    for (share, sign) in [(-0.5, -1.0), (0.5, 0.0), (1.5, 1.0)] {
        let force = inside + share * (outside - inside);
        let found = converged(&robot, &bent(force), &Settings::default());
        let motion = found.actuators()[0].motion;
        assert!((found.actuators()[0].tension - force).abs() < 1e-12);
        let where_to = if motion.abs() < 1e-9 { 0.0 } else { motion.signum() };
        assert!((where_to - sign).abs() < 0.5, "{force} N moves the follower by {motion} m");
    }
}

/// Forces and moments of all tubes together balance the loads, section by section, and shear forces do.
#[test]
fn forces_of_the_tubes_add_up_to_the_loads() {
    let fine = Settings::default().with_resolution(Resolution::SPATIAL.refined(3));
    for seed in 0..3 {
        // Shear is a derivative of the moment: it needs smooth fields to converge point by point.
        let robot = profiled_robot(seed, 2 + seed % 2, 1.0, 0.0, true);
        let mut loads = Loads::tip_force(Vector3::new(0.1, -0.2, 0.15));
        let weight = Vector3::new(0.0, 0.0, -9.81);
        loads.gravity = Some(weight);
        let command = random_command(seed, 1 + seed % 2, 1.0, loads.clone());
        for (settings, tolerance) in [(fine, 2e-4), (fine.with_stretch(), 2e-3)] {
            let mut solver = Solver::with_settings(&robot, settings).unwrap();
            let found = converged(&robot, &command, &settings);
            let count = 401;
            let shape = solver.shape(&found, count);
            let step = robot.length() / (count - 1) as f64;
            let (mut force, mut torque) = (loads.wrenches[0].force, Vector3::zeros());
            for i in (0..count).rev() {
                let section = &shape.sections[i];
                // Trapezium rule over the weights beyond.
                let density = |s: &cppr::analysis::Section| {
                    s.tubes.iter().enumerate().fold(
                        (Vector3::zeros(), Vector3::zeros()),
                        |(f, m), (k, tube)| {
                            let own = weight * robot.fields_at(k, tube.abscissa).mass_per_length * tube.rate;
                            (f + own, m + tube.centroid.cross(&own))
                        },
                    )
                };
                if i + 1 < count {
                    let (a, b) = (density(section), density(&shape.sections[i + 1]));
                    force += (a.0 + b.0) * (0.5 * step);
                    torque += (a.1 + b.1) * (0.5 * step);
                }
                if i % 50 != 25 {
                    continue;
                }
                let tip = shape.sections[count - 1].centre;
                let moment = torque + tip.cross(&loads.wrenches[0].force);
                let (mut own_force, mut own_moment) = (Vector3::zeros(), Vector3::zeros());
                for tube in &section.tubes {
                    let push = tube.rotation * tube.force;
                    own_force += push;
                    own_moment += tube.rotation * tube.moment + tube.centroid.cross(&push);
                    // The torque is about the centre: its arm is the centroid's, seen from there.
                    let arm = tube.centroid - section.centre;
                    let tangent = tube.rotation.column(0).into_owned();
                    own_moment -= tangent * arm.cross(&push).dot(&tangent);
                }
                let scale = found.actuators().iter().fold(1.0_f64, |m, a| m.max(a.tension.abs()));
                assert!(
                    (own_force - force).norm() < tolerance * scale,
                    "seed {seed}, {i}: {own_force} {force}"
                );
                assert!(
                    (own_moment - moment).norm() < tolerance * scale * 0.1,
                    "seed {seed}, {i}: {own_moment} {moment}"
                );
            }
        }
    }
}

/// Two opposed uniform tubes as a sandwich beam with slip: N = M̄ D/(D² + EI/EA*) in the follower and
/// EI y'' = F (L − x) − N D, to first order in a small tip force.
#[test]
fn stretch_agrees_with_the_sandwich_beam_and_vanishes_with_stiffness() {
    let tube = |axial: f64, phi: f64| {
        let TubeDesign::Stiffness(tube) = stiff_tube(2e-3, [0.01, 1e-3], 3e-3, phi, 0.0) else {
            unreachable!()
        };
        TubeDesign::Stiffness(StiffnessTube { axial: Some(Profile::constant(axial)), ..tube })
    };
    let tip = |axial: f64, command: &Command, settings: &Settings| {
        let stiff = common::robot(0.15, vec![tube(axial, 0.0), tube(axial, PI)]);
        let found = converged(&stiff, command, settings);
        found.tip().centre
    };
    let (force, length, offset, bending) = (1e-4, 0.15, 4e-3, 2e-3);
    let push = Command::pull(&[0.0]).with_loads(Loads::tip_force(Vector3::new(0.0, force, 0.0)));
    for axial in [2e3, 1e4] {
        let tension_arm = 0.5 * force * length / (1.0 + bending / (offset * offset * 0.5 * axial));
        let bent = force * length.powi(3) / (3.0 * bending) - tension_arm * length * length / (2.0 * bending);
        let got = tip(axial, &push, &Settings::default().with_stretch()).y;
        assert!((got - bent).abs() < 1e-6 * bent, "{got} {bent}");
    }
    let command = Command::pull(&[6e-3]).with_loads(Loads::tip_force(Vector3::new(0.0, 0.1962, 0.0)));
    let rigid = tip(1e4, &command, &Settings::default());
    let gap = [1e4, 1e6].map(|ea| (tip(ea, &command, &Settings::default().with_stretch()) - rigid).norm());
    assert!(gap[0] > 1e-4 && (gap[0] / gap[1] / 100.0 - 1.0).abs() < 0.05, "{gap:?}");
}

#[test]
fn the_tip_converges_below_1e_9_of_the_length() {
    let helix = robot(
        0.15,
        vec![
            stiff_tube(3.024e-3, [0.01248, 1.05e-3], 0.035, 0.0, 2.0 * PI),
            stiff_tube(1.134e-3, [4.725e-3, 0.7e-3], 4.16e-3, PI, 2.0 * PI),
        ],
    );
    let command = Command::pull(&[5e-3]).with_loads(Loads::tip_force(Vector3::new(0.0, 0.1, 0.1)));
    let tip = |nodes: usize, modes: usize| {
        let resolution =
            Resolution { twist: modes, bending_y: modes, bending_z: modes, angle: modes, stretch: 0, nodes };
        let found = converged(&helix, &command, &Settings::default().with_resolution(resolution));
        found.tip().centre
    };
    let exact = tip(96, 20);
    let errors =
        [(14, 8), (24, 12), (60, 16)].map(|(nodes, modes)| (tip(nodes, modes) - exact).norm() / 0.15);
    assert!(errors[0] < 1e-5 && errors[2] < 1e-9, "{errors:?}");
}

#[test]
fn margin_is_one_at_rest_and_falls_under_a_push() {
    let robot = prototype("R1", 1.26, BelowPlate::Plain);
    let mut solver = Solver::new(&robot);
    let rest = converged(&robot, &Command::held(&robot), &Settings::default());
    let margin = solver.stability(&rest).unwrap().margin;
    assert!((margin - 1.0).abs() < 1e-6, "{margin}");
    let bent = converged(&robot, &Command::pull(&[7e-3]), &Settings::default());
    let margin = solver.stability(&bent).unwrap().margin;
    assert!(margin > 0.0 && margin < 0.99, "{margin}");
}

#[test]
fn a_neighbour_is_found_in_fewer_steps() {
    let robot = random_robot(2, 3, 1.0, 0.0);
    let command = random_command(2, 2, 1.0, random_loads(2, &Matrix3::identity()));
    let settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let start = converged(&robot, &command, &settings);
    let near = command.scaled(1.002);
    let cold = converged(&robot, &near, &settings);
    let warm = solver.solve_from(&near, &start).unwrap();
    assert!(
        warm.statistics().iterations < cold.statistics().iterations,
        "{:?} {:?}",
        warm.statistics(),
        cold.statistics()
    );
    assert!((warm.elastic_energy() - cold.elastic_energy()).abs() < 1e-10 * cold.elastic_energy());
}

/// Whatever is asked, what comes out is a status and finite numbers.
#[test]
fn absurd_commands_get_an_answer() {
    let mut random = Random::new(77);
    let robot = prototype("R3", 1.3, BelowPlate::Plain);
    let mut failures = 0;
    for i in 0..60 {
        let size = 10_f64.powf(random.between(-3.0, 4.0));
        let motion = 0.149 * random.next();
        let push_pull = if i % 2 == 0 { Drive::Motion(motion) } else { Drive::Effort(size * random.next()) };
        let rotation = if i % 3 == 0 {
            Drive::Effort(size * random.next())
        } else {
            Drive::Motion(10.0 * random.next())
        };
        let mut loads = Loads::tip_force(random.vector(size));
        loads.threads.push(Thread {
            tension: size.min(10.0),
            pulley: random.vector(0.2),
            radius: 5e-3,
            left: i % 2 == 0,
            point: Vector3::zeros(),
        });
        let command = Command {
            actuators: vec![Actuator { push_pull, rotation }],
            loads,
            rotation_means: RotationMeans::Base,
        };
        let settings = Settings { smallest_step: 1.0 / 16.0, ..Settings::default() };
        let mut solver = Solver::with_settings(&robot, settings).unwrap();
        let found = solver.solve(&command).unwrap();
        failures += usize::from(!found.status().is_equilibrium());
        assert!(!found.status().to_string().is_empty());
        let cppr::kinematics::TipPose { rotation, centre: tip } = solver.tip(&found);
        let numbers = found.actuators().iter().flat_map(|a| [a.motion, a.rotation, a.tension, a.torque]);
        let finite = numbers.chain(tip.iter().copied()).chain(rotation.iter().copied()).all(f64::is_finite);
        assert!(finite, "{command:?}");
    }
    assert!(failures > 5, "the commands were not absurd enough: {failures}");
}

#[test]
fn commands_that_make_no_sense_are_refused_with_a_reason() {
    let robot = robot(
        0.1,
        vec![stiff_tube(1e-3, [1e-3, 1e-4], 1e-4, 0.0, 0.0), stiff_tube(1e-3, [1e-3, 1e-4], 1e-4, PI, 0.0)],
    );
    let settings = Settings::default();
    let refused = |command: &Command, settings: &Settings, fragment: &str| {
        let problem = match Solver::with_settings(&robot, *settings) {
            Ok(mut solver) => solver.solve(command).unwrap_err().to_string(),
            Err(problem) => problem.to_string(),
        };
        assert!(problem.contains(fragment), "{problem}");
    };
    refused(&Command::pull(&[]), &settings, "0 actuators are given for a robot with 1 followers");
    refused(&Command::pull(&[f64::NAN]), &settings, "not finite");
    refused(&Command::pull(&[5.0]), &settings, "Check the unit");
    refused(&Command::pull(&[1e-3]), &settings.with_stretch(), "axial stiffness");
    let turned = Actuator { push_pull: Drive::Motion(0.0), rotation: Drive::Motion(0.1) };
    refused(&Command { actuators: vec![turned], ..Command::pull(&[]) }, &Settings::planar(), "planar");
    let sideways = Command::pull(&[1e-3]).with_loads(Loads::tip_force(Vector3::z()));
    refused(&sideways, &Settings::planar(), "the force on the tip acts out of the plane X-Y");
    let backwards = DistributedForce { force: Vector3::y(), from: 0.05, to: 0.02 };
    let loads = Loads { distributed: vec![backwards], ..Loads::none() };
    refused(&Command::pull(&[1e-3]).with_loads(loads), &settings, "smaller label first");
    let far = Wrench { station: Station::Label(0.2), ..Wrench::tip_force(Vector3::x()) };
    let loads = Loads { wrenches: vec![far], ..Loads::none() };
    refused(&Command::pull(&[0.0]).with_loads(loads), &settings, "200.000 mm");
    let loads = Loads::tip_force(Vector3::new(f64::INFINITY, 0.0, 0.0));
    refused(&Command::pull(&[0.0]).with_loads(loads), &settings, "not a finite number");
}

/// What a solver of one's own would bring to zero is zero where ours has arrived, and is not elsewhere.
#[test]
fn generalised_forces_vanish_at_equilibrium() {
    let settings = Settings::default();
    let robot = random_robot(3, 3, 1.0, 0.0);
    let mut solver = Solver::new(&robot);
    let command = random_command(3, 2, 1.0, random_loads(3, &Matrix3::identity()));
    let found = converged(&robot, &command, &settings);
    let actuators = found
        .actuators()
        .iter()
        .map(|a| Actuator { push_pull: Drive::Effort(a.tension), rotation: Drive::Effort(a.torque) });
    let driven = Command { actuators: actuators.collect(), ..command };
    let mut at = |coordinates: &[f64]| solver.generalised_forces(&driven, coordinates).unwrap();
    let largest = |forces: &[f64]| forces.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let (here, rest) = (at(found.coordinates()), at(&[]));
    assert!(largest(&here.forces) < 1e-9 * largest(&rest.forces));
    for (own, actuator) in here.motions.iter().zip(found.actuators()) {
        assert!((own[0] - actuator.motion).abs() < 1e-12 && (own[1] - actuator.rotation).abs() < 1e-10);
    }
}
