//! Limits of notches against closed forms and against the fields of the shape.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{converged, prototype, robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::{
    Bound, Limit, Place, RangeProblem, SafeRange, SectionLimit, Teeth, euler_load, governing,
    notch_capacities,
};
use cppr::design::{BelowPlate, Inertia, Outline, Robot, TubeDesign};
use cppr::solve::{Actuator, Command, Drive, Freedom, Settings, Solver};
use cppr::statics::Loads;

const LENGTH: f64 = 0.15;
/// Notch and tooth of the prototypes (m).
const NOTCH: f64 = 5e-3;
const PITCH: f64 = 10e-3;

fn section(outer: f64, inner: f64, depth: f64) -> Inertia {
    Outline::Round { outer_radius: outer, inner_radius: inner }.inertia(depth).unwrap()
}

#[test]
fn a_uniform_bend_has_the_strain_and_closure_of_york_and_swaney() {
    let robot = prototype("R1", 1.0, BelowPlate::Plain);
    let mut solver = Solver::new(&robot);
    let (d1, d2) = (section(3e-3, 2e-3, 5e-3).centroid_offset, section(1.5e-3, 0.5e-3, 2e-3).centroid_offset);
    assert!((d1 - 2.406_328_667_04e-3).abs() < 1e-13);
    // Pulled until the leader's teeth touch: a cell turns by ℓ/(ρ̄ + D), York et al. 2015.
    let angle = NOTCH / (3e-3 + d1);
    let curvature = angle / PITCH;
    let pull = curvature * (d1 + d2) * LENGTH;
    let command = Command::pull(&[pull]);
    let found = converged(&robot, &command, &Settings::planar());
    let all = solver.section_limits(&found, Teeth::Rigid);
    let of = |tube: usize| all.iter().filter(move |s| s.tube == tube);
    assert_eq!(of(1).count(), 15);
    for s in of(1) {
        assert!((s.curvature[1] + curvature).abs() < 1e-8 * curvature, "{s:?}");
        assert!((s.closure.unwrap() - 1.0).abs() < 1e-8, "{s:?}");
        assert!(s.gap.unwrap().abs() < 1e-8 * NOTCH, "{s:?}");
        // The spine's back is stretched: (ρ̄ − D) κ, against (D − α) κ at the cut.
        let strain = (3e-3 - d1) * angle / NOTCH;
        assert!((s.strain - strain).abs() < 1e-8 * strain, "{s:?}");
    }
    // The follower is shorter by the pull and bends away from its notches.
    let own = angle / PITCH / (1.0 - pull / LENGTH) * PITCH / NOTCH;
    for s in of(2) {
        let strain = -(1.5e-3 - d2).max(d2 - 0.5e-3) * own;
        let strain = if 1.5e-3 - d2 > d2 - 0.5e-3 { strain } else { -strain };
        assert!((s.strain - strain).abs() < 1e-7 * strain.abs(), "{s:?} {strain}");
        // Least where the notch opens least: the edge of the cut.
        let opened = (d2 - 0.5e-3) * own;
        assert!((s.closure.unwrap() + opened).abs() < 1e-7 * opened, "{s:?} {opened}");
        assert!((s.gap.unwrap() - NOTCH * (1.0 + opened)).abs() < 1e-9 * NOTCH, "{s:?}");
        assert!(s.abscissa >= pull);
    }
    // Notches that have been pulled below the plate are straight and gone.
    let gone = (pull / PITCH + 0.5).floor();
    assert!((of(2).count() as f64 - (15.0 - gone)).abs() < 0.5);
    // Where the teeth bend too, half of everything is in the notch.
    let spread = solver.section_limits(&found, Teeth::Bending);
    for (a, b) in all.iter().zip(&spread) {
        assert!((a.strain - 2.0 * b.strain).abs() < 1e-12);
    }
    let first = governing(&all, None).unwrap();
    assert_eq!((first.limit, first.section.unwrap().tube), (Limit::Closure, 1));
}

/// Fibres all over the contour.
fn brute(outline: &Outline, depth: f64, strain: [f64; 3]) -> (f64, f64) {
    let Outline::Round { outer_radius, .. } = *outline else { panic!("round") };
    let offset = outline.inertia(depth).unwrap().centroid_offset;
    let (mut worst, mut closing) = (0.0_f64, f64::NEG_INFINITY);
    for i in 0..50_000 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 50_000.0).sin_cos();
        let (y, z) = (outer_radius * cos, outer_radius * sin);
        let value = strain[2] - strain[1] * (y - offset) + strain[0] * z;
        if y >= depth - outer_radius {
            worst = if value.abs() > worst.abs() { value } else { worst };
        } else {
            closing = closing.max(-value);
        }
    }
    (worst, closing)
}

#[test]
fn bending_in_both_planes_with_stretch_agrees_with_fibres_of_the_shape() {
    for (motion, settings) in [
        (6e-3, Settings::default()),
        (-6e-3, Settings::default().with_stretch()),
        (-14e-3, Settings::default()),
    ] {
        let robot = prototype("R4", 1.26, BelowPlate::Plain);
        let mut solver = Solver::with_settings(&robot, settings).unwrap();
        let actuator = Actuator { push_pull: Drive::Motion(motion), rotation: Drive::Motion(0.4) };
        let command = Command { actuators: vec![actuator], ..Command::held(&robot) }
            .with_loads(Loads::tip_force(Vector3::new(0.05, 0.1, 0.3)));
        let found = converged(&robot, &command, &settings);
        let all = solver.section_limits(&found, Teeth::Rigid);
        // The uncut part ends at an edge, where curvatures jump: look at it from its own side.
        let side =
            |s: &SectionLimit| if s.place == Place::Uncut { (s.label - 1e-10).max(0.0) } else { s.label };
        let labels: Vec<f64> = all.iter().map(side).collect();
        let shape = solver.shape_at(&found, &labels);
        let mut uncut = 0;
        for (s, section) in all.iter().zip(&shape.sections) {
            let tube = &section.tubes[s.tube - 1];
            assert!((tube.abscissa - s.abscissa).abs() < 1e-9, "{s:?} {}", tube.abscissa);
            let here = [tube.strain.y, tube.strain.z, tube.stretch];
            // Between the nodes, the shape evaluates modes and the limits interpolate.
            let (size, error) =
                (here[0].hypot(here[1]), (s.curvature[0] - here[0]).hypot(s.curvature[1] - here[1]));
            assert!(error < 2e-5 * size, "{s:?} {here:?}");
            let TubeDesign::Notched(design) = &robot.design().tubes[s.tube - 1] else { unreachable!() };
            let (depth, share) = match s.place {
                Place::Uncut => (0.0, 1.0),
                _ => (design.depth.eval(s.abscissa, LENGTH)[0], PITCH / NOTCH),
            };
            let (strain, closing) = brute(&design.outline, depth, here.map(|v| share * v));
            // Between two fibres of the test, and between two nodes.
            let fibre = 0.15e-3 * share * size * design.outline.outer_reach();
            let tolerance = fibre + 2e-5 * strain.abs();
            // A whole section is as much stretched on one side as compressed on the other.
            let strain = if s.place == Place::Uncut { strain.abs() * s.strain.signum() } else { strain };
            assert!((s.strain - strain).abs() < tolerance, "{s:?} {strain}");
            match s.closure {
                Some(closure) => assert!((closure - closing).abs() < tolerance, "{s:?} {closing}"),
                None => uncut += 1,
            }
        }
        assert_eq!(uncut > 0, motion < 0.0, "the uncut part is there where the follower is pushed");
        assert!(all.iter().any(|s| s.curvature[0].abs() > 0.1), "nothing bends out of the plane");
    }
}

#[test]
fn what_has_no_fibres_has_no_sections_and_stability_governs() {
    let robot = robot(
        LENGTH,
        vec![
            stiff_tube(3e-3, [0.012, 1e-3], 4e-3, 0.0, 0.0),
            stiff_tube(1e-3, [0.006, 8e-4], 2e-3, 3.0, 0.0),
        ],
    );
    let mut solver = Solver::new(&robot);
    let found = converged(&robot, &Command::pull(&[3e-3]), &Settings::default());
    let none: Vec<SectionLimit> = solver.section_limits(&found, Teeth::Rigid);
    assert!(none.is_empty());
    let margin = solver.stability(&found).unwrap().margin;
    let nearest = governing(&none, Some(margin)).unwrap();
    assert_eq!(nearest.limit, Limit::Stability);
    assert!((nearest.utilisation - (1.0 - margin)).abs() < 1e-15 && margin < 1.0);
}

/// The prototype with an allowable strain of 1.5 %.
fn printed(name: &str, factor: f64, below: BelowPlate) -> Robot {
    let mut design = prototype(name, factor, below).design().clone();
    for tube in &mut design.tubes {
        let TubeDesign::Notched(tube) = tube else { unreachable!() };
        tube.material.allowable_strain = Some(STRAIN);
    }
    Robot::from_design(design).unwrap()
}

const STRAIN: f64 = 0.015;

#[test]
fn the_range_of_a_uniform_robot_ends_where_the_closed_form_says() {
    let robot = printed("R1", 1.27, BelowPlate::Continued);
    let mut solver = Solver::with_settings(&robot, Settings::planar()).unwrap();
    let held = Command::held(&robot);
    let ranges = solver.safe_ranges(&held, Teeth::Rigid).unwrap();
    assert_eq!(ranges.len(), 1, "the planar resolution turns nothing");
    let (d1, d2) = (section(3e-3, 2e-3, 5e-3).centroid_offset, section(1.5e-3, 0.5e-3, 2e-3).centroid_offset);
    let sum = 1.27 * (d1 + d2);
    // K = Δa / (ΣD L), the follower's curvature K / (1 − Δa/L), doubled in the notches. Farthest fibres: the backs.
    let pulled = STRAIN * sum * LENGTH / (2.0 * (1.5e-3 - d2) + STRAIN * sum);
    let pushed = -STRAIN * sum * LENGTH / (2.0 * (3e-3 - d1));
    let range = ranges[0];
    for (end, value, tube) in [(range.high, pulled, 2), (range.low, pushed, 1)] {
        assert!((end.value - value).abs() < 2e-9, "{end:?} {value}");
        let Bound::Limit(nearest) = end.bound else { panic!("{end:?}") };
        assert_eq!((nearest.limit, nearest.section.unwrap().tube), (Limit::Strain, tube));
        assert!((nearest.utilisation - 1.0).abs() < 1e-7, "{end:?}");
    }
}

/// R1's notches are segments of height 1 mm without a bore: Roark's arm of the leader's, by hand, times the twist of the shape, doubled.
#[test]
fn twist_shears_the_notches_and_ends_the_range_of_a_rotation() {
    let robot = printed("R1", 1.27, BelowPlate::Continued);
    let mut solver = Solver::new(&robot);
    let mut turned = Command::held(&robot);
    turned.actuators[0].rotation = Drive::Motion(0.5);
    let found = converged(&robot, &turned, &Settings::default());
    let k = (std::f64::consts::PI / (4.0 * section(3.0, 2.0, 5.0).area)).powi(2);
    let arm = 1e-3 * (1.0 + 0.15 * k) / (1.0 + k);
    assert!((arm - 0.9487e-3).abs() < 1e-7, "{arm}");
    let shape = solver.shape(&found, 11);
    let middle = &shape.sections[5].tubes;
    for teeth in [Teeth::Rigid, Teeth::Bending] {
        let share = if teeth == Teeth::Rigid { PITCH / NOTCH } else { 1.0 };
        let sections = solver.section_limits(&found, teeth);
        for (tube, own) in middle.iter().enumerate() {
            let section = sections.iter().find(|s| s.tube == tube + 1 && s.place == Place::Notch(8)).unwrap();
            let arm = if tube == 0 { arm } else { section.shear / own.strain.x / share };
            // The follower's is less wide.
            assert!(tube == 0 || (0.85e-3..0.95e-3).contains(&arm), "{arm}");
            let shear = share * arm * own.strain.x;
            assert!((section.shear - shear).abs() < 1e-5 * shear.abs() && shear.abs() > 1e-3, "{section:?}");
            let allowed = STRAIN * 2.0 * 1.35 / 3.0_f64.sqrt();
            assert!((section.allowable_shear.unwrap() - allowed).abs() < 1e-12);
        }
    }
    // The twist is uniform: all of the range's ends lie where the more twisted tube's shear is what is allowed.
    let ranges = solver.safe_ranges(&Command::held(&robot), Teeth::Rigid).unwrap();
    for end in [ranges[1].low, ranges[1].high] {
        let Bound::Limit(nearest) = end.bound else { panic!("{end:?}") };
        assert_eq!(nearest.limit, Limit::Torsion);
        let there = nearest.section.unwrap();
        assert!((there.shear.abs() / there.allowable_shear.unwrap() - 1.0).abs() < 1e-6, "{there:?}");
        assert!((2.5..3.4).contains(&end.value.abs()), "{end:?}");
    }
    // Without an allowable strain nothing limits it.
    let free = prototype("R1", 1.27, BelowPlate::Continued);
    let open = Solver::new(&free).safe_ranges(&Command::held(&free), Teeth::Rigid).unwrap();
    assert!(open[1].high.bound == Bound::Open && (open[1].high.value - std::f64::consts::TAU).abs() < 1e-12);
}

#[test]
fn ends_found_by_force_are_those_found_by_motion_and_lie_where_the_limit_is() {
    let robot = printed("R3", 1.26, BelowPlate::Plain);
    let settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let loads = Loads::tip_force(Vector3::new(0.0, 0.05, 0.1));
    let held = Command::held(&robot).with_loads(loads);
    let ranges = solver.safe_ranges(&held, Teeth::Rigid).unwrap();
    assert_eq!(ranges.len(), 2);
    let solved = |_solver: &mut Solver, range: &SafeRange, value: f64| {
        let mut command = held.clone();
        let actuator = &mut command.actuators[0];
        match range.input.freedom {
            Freedom::PushPull => actuator.push_pull = Drive::Motion(value),
            Freedom::Rotation => actuator.rotation = Drive::Motion(value),
        }
        converged(&robot, &command, &settings)
    };
    for range in &ranges {
        for end in [range.low, range.high] {
            let Bound::Limit(nearest) = end.bound else { panic!("{end:?}") };
            let mut utilisation = |share: f64| {
                let found = solved(&mut solver, range, end.value * share);
                let sections = solver.section_limits(&found, Teeth::Rigid);
                let margin = solver.stability(&found).unwrap().margin;
                let nearest = governing(&sections, Some(margin)).unwrap();
                (nearest.utilisation, nearest.limit)
            };
            assert_eq!(utilisation(1.0).1, nearest.limit);
            assert!((utilisation(1.0).0 - 1.0).abs() < 1e-6, "{range:?}");
            assert!(utilisation(0.97).0 < 1.0 - 1e-3, "{range:?}");
        }
    }
    // The same limit is met under the force that holds the robot there.
    let end = ranges[0].high;
    let tension = solved(&mut solver, &ranges[0], end.value).actuators()[0].tension;
    let mut driven = held.clone();
    driven.actuators[0].push_pull = Drive::Effort(0.0);
    let by_force = solver.safe_ranges(&driven, Teeth::Rigid).unwrap()[0];
    assert!((by_force.high.value - tension).abs() < 1e-6 * tension, "{by_force:?} {tension}");
    assert!(!by_force.input.is_motion);
}

#[test]
fn an_unsafe_start_has_no_range() {
    let robot = printed("R1", 1.27, BelowPlate::Plain);
    let mut solver = Solver::new(&robot);
    let far = Command::pull(&[12e-3]);
    let problem = solver.safe_ranges(&far, Teeth::Rigid).unwrap_err();
    let RangeProblem::Exceeded(nearest) = problem else { panic!("{problem:?}") };
    assert_eq!(nearest.limit, Limit::Strain);
}

/// Of one actuator alone, the safe part ends where its range does; of loads and motions together, where the limit is.
#[test]
fn the_safe_part_of_a_command_ends_at_its_first_limit() {
    let robot = printed("R3", 1.25, BelowPlate::Plain);
    let settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let held = Command::held(&robot);
    let range = solver.safe_ranges(&held, Teeth::Rigid).unwrap()[0];
    for (pull, end) in [(14e-2, range.high), (-5e-2, range.low)] {
        let part = solver.safe_part(&Command::pull(&[pull]), Teeth::Rigid).unwrap();
        assert!((part.value * pull - end.value).abs() < 1e-8 * LENGTH, "{part:?} {end:?}");
    }
    let mut far = Command::pull(&[9e-3]).with_loads(Loads::tip_force(Vector3::new(0.0, 0.1, 0.4)));
    far.actuators[0].rotation = Drive::Motion(1.0);
    let part = solver.safe_part(&far, Teeth::Rigid).unwrap();
    assert!((0.05..0.95).contains(&part.value), "{part:?}");
    let found = converged(&robot, &far.scaled(part.value), &settings);
    let sections = solver.section_limits(&found, Teeth::Rigid);
    assert!((governing(&sections, None).unwrap().utilisation - 1.0).abs() < 1e-6);
    // Nothing is met by a command that is safe as a whole.
    let near = solver.safe_part(&far.scaled(0.5 * part.value), Teeth::Rigid).unwrap();
    assert_eq!((near.value, near.bound), (1.0, Bound::Open));
}

#[test]
fn capacities_of_a_notch_are_those_of_its_section() {
    let robot = printed("R1", 1.0, BelowPlate::Plain);
    let all = notch_capacities(&robot, Teeth::Rigid);
    assert_eq!(all.len(), 30);
    let d1 = section(3e-3, 2e-3, 5e-3).centroid_offset;
    let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-12 * want.abs(), "{got} {want}");
    near(all[0].closing_curvature, NOTCH / PITCH / (3e-3 + d1));
    near(all[0].straining_curvature.unwrap(), STRAIN * NOTCH / PITCH / (3e-3 - d1));
    near(all[0].thinnest_wall, 1e-3);
    near(all[0].kept_height, 1e-3);
    near(all[20].abscissa, 55e-3);
    // EI_Z of both tubes by appendix B; eq 99.
    let stiffness = 5.39e9 * (section(3e-3, 2e-3, 5e-3).inertia_z + section(1.5e-3, 0.5e-3, 2e-3).inertia_z);
    near(euler_load(&robot), std::f64::consts::PI.powi(2) * stiffness / (LENGTH * LENGTH));
}
