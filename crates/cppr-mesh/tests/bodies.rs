//! Bodies of tubes: closed, manifold, of the right volume, and where the design says there is material.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{inside, shipped, single};
use cppr::design::TubeDesign;
use cppr_io::RobotFile;
use cppr_mesh::{Detail, Flange, Flaws, Mesh, MeshError, TubeOptions, tube_mesh, tube_volume};

const MM: f64 = 1e-3;

fn workshop() -> TubeOptions {
    TubeOptions::plain(Detail::workshop(0.01 * MM))
}

/// Builds, checks and returns a body.
#[track_caller]
fn sound(file: &RobotFile, tube: usize, options: &TubeOptions) -> Mesh {
    let mesh = tube_mesh(file, tube, options).unwrap();
    assert_eq!(mesh.flaws(), Flaws::default(), "{} triangles", mesh.triangles.len());
    let (got, want) = (mesh.volume(), tube_volume(file, tube, options).unwrap());
    let share = if options.detail.turn > 0.1 { 2e-2 } else { 1e-3 };
    assert!(
        (got / want - 1.0).abs() < share,
        "{} {tube}: volume {got:e} against {want:e}: {:e}",
        file.design.name,
        got / want - 1.0
    );
    mesh
}

#[test]
fn shipped_tubes_are_closed_and_have_their_volume() {
    for name in ["r1", "r2", "r3", "r4", "helicoid"] {
        let file = shipped(name);
        for tube in 0..file.tubes.len() {
            sound(&file, tube, &workshop());
            sound(&file, tube, &TubeOptions { below: 23.0 * MM, ..workshop() });
            sound(&file, tube, &TubeOptions::plain(Detail::drawing(0.7 * MM)));
        }
    }
}

/// Depths from a scratch to almost through, on and beside the depths at which the bore is reached and passed.
#[test]
fn every_depth_makes_a_body() {
    for (shape, bore) in [("round", 2.0), ("square", 2.0), ("hexagon", 2.0), ("round", 0.0), ("square", 0.0)]
    {
        let widest = 6.0;
        let mut depths: Vec<f64> = (1..60).map(|i| widest * f64::from(i) / 60.0).collect();
        depths.extend([2e-6, 1e-5, 1e-4]);
        for special in [1.0, 3.0, 3.0 + bore, 3.0 - bore, 5.999] {
            for beside in [-1e-3, -1e-4, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-4, 1e-3] {
                depths.push(special + beside);
            }
        }
        // A robot file leaves a micrometre at least.
        for depth in depths.into_iter().filter(|d| *d > 0.0 && *d <= widest - 1e-3) {
            let file = single(&format!(
                "outer_radius_mm = 3\ninner_radius_mm = {bore:?}\nshape = \"{shape}\"\n[tube.notches]\ndepth_mm = {depth:?}\nlength_mm = 5\ntooth_mm = 5\nopening_deg = 37"
            ));
            let mesh = tube_mesh(&file, 0, &workshop()).unwrap();
            assert_eq!(mesh.flaws(), Flaws::default(), "{shape} {bore} {depth:e}");
            let share = mesh.volume() / tube_volume(&file, 0, &workshop()).unwrap() - 1.0;
            assert!(share.abs() < 1e-3, "{shape} {bore} {depth:e}: {share:e}");
        }
    }
}

/// Notches that break through the wall and leave the bore behind somewhere inside their length, and wind.
#[test]
fn depths_that_change_within_a_notch_make_a_body() {
    for shape in ["round", "square", "hexagon"] {
        for depth in
            ["[0.3, 5.8]", "[5.8, 0.3]", "{ x_mm = [0, 20, 40, 60], depth_mm = [0.5, 5.5, 0.5, 5.5] }"]
        {
            for twist in [0, 170, -720] {
                let file = single(&format!(
                    "outer_radius_mm = 3\ninner_radius_mm = 2\nshape = \"{shape}\"\n[tube.notches]\ndepth_mm = {depth}\nlength_mm = 17\ntooth_mm = 2\ntwist_deg = {twist}"
                ));
                sound(&file, 0, &workshop());
            }
        }
    }
}

#[test]
fn uncut_tubes_rods_flanges_and_platforms() {
    let additions = TubeOptions {
        below: 4.0 * MM,
        flange: Some(Flange { radius: 9.0 * MM, thickness: 2.0 * MM }),
        tip_cap: Some(1.5 * MM),
        ..workshop()
    };
    for lines in [
        "outer_radius_mm = 3\ninner_radius_mm = 2",
        "outer_radius_mm = 3\ninner_radius_mm = 0",
        "outer_radius_mm = 3\ninner_radius_mm = 0\nshape = \"hexagon\"",
        "outer_radius_mm = 3\ninner_radius_mm = 2\nshape = \"square\"\n[tube.notches]\ndepth_mm = 4\nlength_mm = 5\ntooth_mm = 5\nbelow_plate = \"continued\"",
    ] {
        let file = single(lines);
        sound(&file, 0, &workshop());
        let mesh = sound(&file, 0, &additions);
        let [low, high] = mesh.bounds();
        let reached = [(low[0], -6.0), (high[0], 61.5), (low[1], -9.0), (high[1], 9.0), (high[2], 9.0)];
        for (got, want) in reached {
            assert!((got - want * MM).abs() < 1e-9, "{got} {want}");
        }
    }
}

/// Points are inside the mesh exactly where the section model keeps material.
#[test]
fn material_is_where_the_section_model_has_it() {
    for name in ["r3", "helicoid", "r2"] {
        let file = shipped(name);
        for tube in 0..2 {
            let mesh = tube_mesh(&file, tube, &workshop()).unwrap();
            let TubeDesign::Notched(design) = &file.design.tubes[tube] else { panic!() };
            let (outer, inner) =
                (file.tubes[tube].outer_radius.unwrap(), file.tubes[tube].inner_radius.unwrap());
            let (length, margin) = (file.design.length, 0.02 * MM);
            // A low-discrepancy sequence through the box around the tube.
            let mut counts = [0, 0];
            for i in 1..400_u32 {
                let [u, v, w] =
                    [0.819_172_5, 0.671_043_6, 0.549_700_4].map(|g: f64| (g * f64::from(i)).fract());
                let (x, y, z) = (length * u, outer * (2.0 * v - 1.0), outer * (2.0 * w - 1.0));
                let radius = y.hypot(z);
                let direction = design.direction.eval(x, length)[0];
                let above =
                    y * direction.cos() + z * direction.sin() - (design.depth.eval(x, length)[0] - outer);
                let cell = x.rem_euclid(10.0 * MM);
                let in_notch = cell > 2.5 * MM && cell < 7.5 * MM;
                let near = [radius - outer, radius - inner, cell - 2.5 * MM, cell - 7.5 * MM];
                if near.iter().any(|d| d.abs() < margin) || (in_notch && above.abs() < margin) {
                    continue;
                }
                let solid = radius < outer && radius > inner && !(in_notch && above < 0.0);
                assert_eq!(inside(&mesh, [x, y, z]), solid, "{name}, tube {}: {x} {y} {z}", tube + 1);
                counts[usize::from(solid)] += 1;
            }
            assert!(counts[0] > 100 && counts[1] > 50, "{counts:?}");
        }
    }
}

/// Round surfaces keep within the tolerance: vertices on the circle, chords no farther from it than said.
#[test]
fn chords_keep_within_the_tolerance() {
    let file = shipped("helicoid");
    for tolerance in [0.1, 0.01, 0.002] {
        let detail = Detail { turn: 0.9, ..Detail::workshop(tolerance * MM) };
        let mesh = tube_mesh(&file, 0, &TubeOptions::plain(detail)).unwrap();
        let mut worst = 0.0_f64;
        for t in &mesh.triangles {
            let corners = t.map(|v| mesh.positions[v as usize]);
            let radii = corners.map(|p| p[1].hypot(p[2]));
            if radii.iter().all(|r| (r - 3.0 * MM).abs() < 1e-9) {
                for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                    let middle = [1, 2].map(|k| 0.5 * (corners[i][k] + corners[j][k]));
                    worst = worst.max(3.0 * MM - middle[0].hypot(middle[1]));
                }
            }
        }
        // The diagonal of a facet of a helix spans a step about the axis and a step of the helix.
        assert!(worst < 4.0 * tolerance * MM && worst > 0.2 * tolerance * MM, "{tolerance}: {worst}");
    }
}

#[test]
fn normals_point_away_from_the_axis_and_edges_stay_sharp() {
    let mesh = tube_mesh(&shipped("r1"), 0, &TubeOptions::plain(Detail::drawing(1.0 * MM))).unwrap();
    let shaded = mesh.shaded(0.6);
    assert_eq!(shaded.triangles.len(), mesh.triangles.len());
    let (mut radial, mut axial, mut flat) = (0, 0, 0);
    for (p, n) in shaded.positions.iter().zip(&shaded.normals) {
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        assert!((length - 1.0).abs() < 1e-12);
        let radius = p[1].hypot(p[2]);
        let out = (p[1] * n[1] + p[2] * n[2]) / radius;
        if n[0].abs() > 0.99 {
            axial += 1;
        } else if (radius - 3.0 * MM).abs() < 1e-9 && out > 0.97 {
            radial += 1;
        } else if (n[1] + 1.0).abs() < 1e-6 {
            flat += 1;
        } else {
            // What is left lies on the bore.
            assert!((radius - 2.0 * MM).abs() < 1e-9 && out < -0.97, "{p:?} {n:?}");
        }
    }
    assert!(radial > 1000 && axial > 500 && flat > 100, "{radial} {axial} {flat}");
}

#[test]
fn what_has_no_shape_or_size_is_refused_with_a_sentence() {
    let say = |file: &RobotFile, tube: usize, options: TubeOptions| {
        tube_mesh(file, tube, &options).unwrap_err().to_string()
    };
    let r1 = shipped("r1");
    assert!(say(&shipped("childs2"), 0, workshop()).contains("by its stiffness"));
    assert!(say(&r1, 8, workshop()).contains("there is no tube 9; this robot has 1 to 2"));
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 10.0, 1e-8] {
        let message = say(&r1, 0, TubeOptions::plain(Detail::workshop(tolerance)));
        assert!(message.contains("a tolerance of"), "{message}");
    }
    let flange = |radius, thickness| TubeOptions { flange: Some(Flange { radius, thickness }), ..workshop() };
    assert!(say(&r1, 0, flange(3.0 * MM, 1.0 * MM)).contains("inside the tube"));
    assert!(say(&r1, 0, flange(f64::NAN, 1.0 * MM)).contains("inside the tube"));
    assert!(say(&r1, 0, flange(5.0 * MM, 0.0)).contains("thickness of the flange"));
    assert!(say(&r1, 0, TubeOptions { below: -1.0, ..workshop() }).contains("below the plate"));
    assert!(say(&r1, 0, TubeOptions { tip_cap: Some(f64::INFINITY), ..workshop() }).contains("tip platform"));
    let fine = Detail { step: 1e-9, ..Detail::workshop(1e-7) };
    assert!(say(&r1, 0, TubeOptions::plain(fine)).contains("choose a coarser tolerance"));
    let nowhere = single("outer_radius_mm = 3\ninner_radius_mm = 2\n[tube.notches]\ndepth_mm = 4");
    assert!(matches!(tube_mesh(&nowhere, 0, &workshop()), Err(MeshError::NoPattern { tube: 1 })));
}
