//! Tubes with parts, at rest and in solved bundles: cut where their parts are, and where the equilibrium has them.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{inside, shipped};
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::{Robot, TubeDesign};
use cppr::solve::{Command, Drive, Solver};
use cppr_io::bundle_file;
use cppr_mesh::{
    Detail, Flaws, MeshError, TubeOptions, UnrolledOptions, bent_bundle, bent_tubes, tube_mesh, tube_volume,
    unrolled,
};
use std::path::Path;

const MM: f64 = 1e-3;
const TOLERANCE: f64 = 0.02 * MM;

fn workshop() -> TubeOptions {
    TubeOptions::plain(Detail::workshop(0.01 * MM))
}

fn bundle(name: &str) -> BundleDesign {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(format!("{name}.toml"));
    bundle_file::read_bundle(path).unwrap()
}

/// One tube of radius 3 mm with a bore of 2 mm; `parts` are its parts.
fn tube(shape: &str, parts: &[&str]) -> BundleDesign {
    let parts: Vec<String> = parts.iter().map(|part| format!("[[tube.part]]\n{part}\n")).collect();
    bundle_file::parse(&format!(
        "name = \"T\"\njoint = []\n[material]\nyoungs_modulus_GPa = 5\npoissons_ratio = 0.3\ndensity_kg_m3 = 1000\n\
         [[tube]]\nouter_radius_mm = 3\ninner_radius_mm = 2\nshape = \"{shape}\"\n{}",
        parts.concat()
    ))
    .unwrap_or_else(|problems| panic!("{problems}"))
}

fn notches(length: &str, opening: &str, other: &str) -> String {
    format!(
        "length_mm = {length}\nnotches = {{ depth_mm = 4, length_mm = 2, tooth_mm = 1, opening_deg = {opening}{other} }}"
    )
}

#[test]
fn tubes_whose_notches_change_sides_are_closed_and_have_their_volume() {
    let (first, second) = (notches("10", "180", ""), notches("7", "0", ""));
    let third = notches("12", "60", ", twist_deg = 100");
    for shape in ["round", "square", "hexagon"] {
        let whole = ["length_mm = 7", &first, &second, "length_mm = 2.5", &first, "length_mm = 4"];
        let beginning = [&first[..], &second, "length_mm = 5"];
        let deep = first.replace("depth_mm = 4", "depth_mm = [0.4, 5.6]");
        let winding = [&deep[..], "length_mm = 3", &third];
        for parts in [&whole[..], &beginning, &winding] {
            // 60° on, a square has no side.
            if shape == "square" && parts.len() == 3 && parts[2].contains("twist") {
                continue;
            }
            let design = tube(shape, parts);
            for options in
                [workshop(), TubeOptions { below: 11.0 * MM, ..TubeOptions::plain(Detail::drawing(MM)) }]
            {
                let mesh = tube_mesh(&design, 0, &options).unwrap();
                assert_eq!(mesh.flaws(), Flaws::default(), "{shape} {parts:?}");
                let share = mesh.volume() / tube_volume(&design, 0, &options).unwrap() - 1.0;
                let most = if options.below > 0.0 { 2e-2 } else { 1e-3 };
                assert!(share.abs() < most, "{shape} {parts:?}: {share:e}");
            }
        }
    }
}

/// Points are inside the mesh exactly where the part that they lie in keeps material.
#[test]
fn material_is_where_each_part_has_it() {
    let [first, second] = [notches("10", "180", ""), notches("9", "40", "")];
    let third = notches("12", "-80", ", twist_deg = 100");
    // Below the plate the first part lies alone.
    let below = "length_mm = 0\nnotches = { depth_mm = 4, length_mm = 2, tooth_mm = 1, opening_deg = 90 }";
    let parts = [below, &first, &second, "length_mm = 2", &third, "length_mm = 3"];
    let design = tube("round", &parts);
    let mesh = tube_mesh(&design, 0, &TubeOptions { below: 8.0 * MM, ..workshop() }).unwrap();
    assert_eq!(mesh.flaws(), Flaws::default());
    let (outer, inner, margin) = (3.0 * MM, 2.0 * MM, 0.02 * MM);
    let mut counts = [0, 0];
    for i in 1..600_u32 {
        let [u, v, w] = [0.819_172_5, 0.671_043_6, 0.549_700_4].map(|g: f64| (g * f64::from(i)).fract());
        let (x, y, z) = (MM * (44.0 * u - 8.0), outer * (2.0 * v - 1.0), outer * (2.0 * w - 1.0));
        // Base, length, where it opens to, and by how much that turns; a third notch below the plate would not be whole.
        let of_part = [
            (-8.0, 2.0, None),
            (-6.0, 6.0, Some((90.0, 0.0))),
            (0.0, 10.0, Some((180.0, 0.0))),
            (10.0, 9.0, Some((40.0, 0.0))),
            (19.0, 2.0, None),
            (21.0, 12.0, Some((-80.0, 100.0))),
            (33.0, 3.0, None),
        ];
        let (from, length, cut) = of_part.into_iter().find(|p| x < MM * (p.0 + p.1)).unwrap();
        let along = x / MM - from;
        let cell = along % 3.0;
        // Whole cells from the base of the part on.
        let in_notch =
            cut.is_some() && cell > 0.5 && cell < 2.5 && (along / 3.0).floor() < (length / 3.0_f64).floor();
        let radius = y.hypot(z);
        let above = cut.map_or(f64::INFINITY, |(opening, twist)| {
            let direction = (opening + 180.0 + twist * along / length).to_radians();
            y * direction.cos() + z * direction.sin() - MM
        });
        let near = [radius - outer, radius - inner, MM * (cell - 0.5), MM * (cell - 2.5)];
        if near.iter().any(|d| d.abs() < margin) || (in_notch && above.abs() < margin) {
            continue;
        }
        let solid = radius < outer && radius > inner && !(in_notch && above < 0.0);
        assert_eq!(inside(&mesh, [x, y, z]), solid, "{x} {y} {z}");
        counts[usize::from(solid)] += 1;
    }
    assert!(counts[0] > 120 && counts[1] > 80, "{counts:?}");
}

#[test]
fn cut_patterns_are_those_of_the_parts() {
    let options = UnrolledOptions { tolerance: 0.01 * MM, kerf: 0.0, below: 12.0 * MM };
    let pattern = unrolled(&bundle("bundles/uncut_ends"), 1, &options).unwrap();
    assert_eq!(pattern.openings.len(), 100);
    assert!(
        (pattern.outline[0][0] + 12.0 * MM).abs() < 1e-12
            && (pattern.outline[1][0] - 115.0 * MM).abs() < 1e-12
    );
    for (k, path) in pattern.openings.iter().enumerate() {
        let start = MM * (30.0 + 0.8 * f64::from(u32::try_from(k).unwrap()) + 0.15);
        assert!(path.iter().all(|p| (p[0] - start).abs() < 1e-9 || (p[0] - start - 0.5 * MM).abs() < 1e-9));
        assert!(path.iter().map(|p| p[1]).sum::<f64>().abs() < 1e-9, "the first pattern is in the middle");
    }
    // An S: the second part's openings are on the other side, half a turn along the circumference.
    let [first, second] = [notches("9", "180", ""), notches("9", "0", "")];
    let s = tube("round", &["length_mm = 5", &first, &second]);
    let openings = unrolled(&s, 0, &options).unwrap().openings;
    let middle = |path: &[[f64; 2]]| path.iter().map(|p| p[1]).sum::<f64>() / path.len() as f64;
    assert_eq!(openings.len(), 6);
    assert!(openings[..3].iter().all(|path| middle(path).abs() < 1e-9));
    let half = std::f64::consts::PI * 3.0 * MM;
    assert!(openings[3..].iter().all(|path| (middle(path).abs() - half).abs() < 1e-9));
}

fn solve(design: &BundleDesign, pulls: &[f64], turns: &[f64]) -> (Bundle, BundleEquilibrium) {
    let bundle = Bundle::new(design).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let mut command = solver.held();
    for (i, (pull, turn)) in pulls.iter().zip(turns).enumerate() {
        command.drives[i].translation = Drive::Motion(pull * MM);
        command.drives[i].rotation = Drive::Motion(*turn);
    }
    let found = solver.solve(&command);
    assert!(found.converged);
    (bundle, found)
}

/// A robot that both solvers take is the same body in space.
#[test]
fn bent_tubes_are_those_of_the_other_solver() {
    for (name, pull, turn) in [("r1", 5.0, 0.0), ("r3", -8.0, 0.3), ("helicoid", 10.0, 0.5)] {
        let design = bundle(name);
        let (bundle, found) = solve(&design, &[0.0, pull], &[0.0, turn]);
        let own = bent_bundle(&design, &BundleSolver::new(&bundle), &found, TOLERANCE, 20.0 * MM).unwrap();
        let file = shipped(name);
        let robot = Robot::from_design(file.design.clone()).unwrap();
        let mut command = Command::held(&robot);
        command.actuators[0].push_pull = Drive::Motion(pull * MM);
        command.actuators[0].rotation = Drive::Motion(turn);
        let mut solver = Solver::new(&robot);
        let found = solver.solve(&command).unwrap();
        let other = bent_tubes(&file, &mut solver, &found, TOLERANCE, 20.0 * MM).unwrap();
        for (tube, (own, other)) in own.iter().zip(&other).enumerate() {
            assert_eq!(own.flaws(), Flaws::default());
            let (a, b) = (own.bounds(), other.bounds());
            let off = (0..2).flat_map(|e| (0..3).map(move |i| (a[e][i] - b[e][i]).abs()));
            // Bounds are places of facets, which lie within the tolerance of the surface; the modes within 1e-4 of the length.
            assert!(off.fold(0.0, f64::max) < 35e-6, "{name}, tube {}: {a:?} {b:?}", tube + 1);
            let share = own.volume() / other.volume() - 1.0;
            assert!(share.abs() < 5e-4, "{name}, tube {}: {share:e}", tube + 1);
        }
    }
}

/// Advanced by 20 mm, tube 1 begins at the plate and tube 2 a millimetre before it; both end around the tip.
#[test]
fn an_advanced_robot_begins_and_ends_where_it_should() {
    let design = bundle("bundles/uncut_ends");
    let (bundle, found) = solve(&design, &[-20.0, -19.0], &[0.0, 0.0]);
    let bent = bent_bundle(&design, &BundleSolver::new(&bundle), &found, TOLERANCE, 20.0 * MM).unwrap();
    for (mesh, (radius, begins)) in bent.iter().zip([(1.0, 0.0), (0.8, -1.0)]) {
        assert_eq!(mesh.flaws(), Flaws::default());
        assert!((mesh.bounds()[0][0] - begins * MM).abs() < 1e-9, "{:?}", mesh.bounds());
        let local = |p: &[f64; 3]| found.frame.transpose() * (cppr::Vector3::from(*p) - found.tip);
        let rim = mesh
            .positions
            .iter()
            .map(local)
            .filter(|p| p.x.abs() < 1e-7 && (p.y.hypot(p.z) - radius * MM).abs() < 1e-9);
        assert!(rim.count() >= 24);
        assert!(mesh.positions.iter().map(local).all(|p| p.x < 1e-7));
    }
}

/// Tubes of three lengths: one behind the plate, and two that end where their own tips are.
#[test]
fn tubes_end_where_they_do_and_may_lie_behind_the_plate() {
    let design = bundle("bundles/concentric3");
    let (bundle, found) = solve(&design, &[120.0, 0.0, -10.0], &[0.0, 0.4, 1.0]);
    let solver = BundleSolver::new(&bundle);
    let bent = bent_bundle(&design, &solver, &found, TOLERANCE, 0.0).unwrap();
    let shape = solver.shape(&found, MM);
    let [low, high] = bent[0].bounds();
    assert!((low[0] + 120.0 * MM).abs() < 1e-9 && (high[0] + 20.0 * MM).abs() < 1e-9, "{low:?} {high:?}");
    for (tube, mesh) in bent.iter().enumerate() {
        assert_eq!(mesh.flaws(), Flaws::default());
        let Some(last) = shape.iter().rfind(|s| s.tubes.iter().any(|t| t.tube == tube)) else { continue };
        let TubeDesign::Notched(own) = &design.tubes[tube].parts[0].body else { panic!() };
        let radius = own.outline.outer_reach();
        let rim =
            mesh.positions.iter().map(|p| last.frame.transpose() * (cppr::Vector3::from(*p) - last.centre));
        let rim = rim.filter(|p| p.x.abs() < 1e-7 && (p.y.hypot(p.z) - radius).abs() < 1e-9);
        assert!(rim.count() >= 24, "tube {}", tube + 1);
    }
}

#[test]
fn bodies_that_cannot_be_are_refused() {
    let say = |design: &BundleDesign| tube_mesh(design, 0, &workshop()).unwrap_err().to_string();
    let [first, second] = [notches("9", "180", ""), notches("9", "30", "")];
    let said = say(&tube("square", &[&first, &second]));
    assert!(
        said.contains("turn by -150° from one part to the next") && said.contains("multiple of 90°"),
        "{said}"
    );
    assert!(say(&bundle("bundles/s_shape")).contains("by its stiffness"));
    let mut design = tube("round", &[&first, "length_mm = 5"]);
    let other = tube("hexagon", &["length_mm = 5"]);
    design.tubes[0].parts.push(other.tubes[0].parts[0].clone());
    assert_eq!(tube_mesh(&design, 0, &workshop()), Err(MeshError::Outlines { tube: 1 }));
}
