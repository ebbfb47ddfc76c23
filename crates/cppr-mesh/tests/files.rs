//! Files in readers that did not write them.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{shipped, single};
use cppr::Vector3;
use cppr_mesh::{
    CUT_LAYER, Detail, Flange, Flaws, Mesh, OUTLINE_LAYER, Part, TubeOptions, Unrolled, UnrolledOptions, dxf,
    glb, gltf, obj, stl, three_mf, tube_mesh, tube_volume, unrolled,
};
use std::io::Cursor;

const MM: f64 = 1e-3;

/// Tubes of all kinds of features.
fn parts() -> Vec<Part> {
    let plain = TubeOptions::plain(Detail::workshop(0.01 * MM));
    let dressed = TubeOptions {
        below: 12.0 * MM,
        flange: Some(Flange { radius: 7.0 * MM, thickness: 2.0 * MM }),
        tip_cap: Some(1.0 * MM),
        ..plain
    };
    let square = single(
        "outer_radius_mm = 3\ninner_radius_mm = 2\nshape = \"square\"\n[tube.notches]\ndepth_mm = [0.5, 5.5]\nlength_mm = 5\ntooth_mm = 5\ntwist_deg = 90",
    );
    let mut parts = Vec::new();
    for (file, tube, options) in [
        (&shipped("r1"), 0, plain),
        (&shipped("r1"), 1, dressed),
        (&shipped("r3"), 0, dressed),
        (&shipped("helicoid"), 1, plain),
        (&square, 0, dressed),
    ] {
        parts.push(Part {
            name: format!("{}, tube {}", file.design.name, tube + 1),
            mesh: tube_mesh(file, tube, &options).unwrap(),
            colour: [0xd9, 0x54, 0x1e],
        });
    }
    parts
}

/// `got`, with lengths `unit` (m), is a sound body of the volume of `part`.
#[track_caller]
fn same_body(part: &Part, got: &Mesh, unit: f64) {
    assert_eq!(got.flaws(), Flaws::default(), "{}", part.name);
    let (got, want) = (got.volume() * unit.powi(3), part.mesh.volume());
    assert!((got / want - 1.0).abs() < 1e-5, "{}: {got:e} {want:e}", part.name);
}

#[test]
fn stl_is_closed_after_rounding() {
    for part in parts() {
        let bytes = stl(std::slice::from_ref(&part)).unwrap();
        assert_eq!(bytes.len(), 84 + 50 * part.mesh.triangles.len());
        let read = stl_io::read_stl(&mut Cursor::new(bytes)).unwrap();
        let mesh = Mesh {
            positions: read.vertices.iter().map(|v| [0, 1, 2].map(|i| f64::from(v[i]))).collect(),
            triangles: read.faces.iter().map(|f| f.vertices.map(|v| u32::try_from(v).unwrap())).collect(),
        };
        same_body(&part, &mesh, MM);
        for face in &read.faces {
            let [a, b, c] =
                face.vertices.map(|v| Vector3::from([0, 1, 2].map(|i| f64::from(read.vertices[v][i]))));
            let normal = Vector3::from([0, 1, 2].map(|i| f64::from(face.normal[i])));
            assert!((b - a).cross(&(c - a)).dot(&normal) > 0.0, "{}", part.name);
        }
    }
}

#[test]
fn three_mf_holds_every_part_in_millimetres() {
    let parts = parts();
    let models = threemf::read(Cursor::new(three_mf(&parts).unwrap())).unwrap();
    let [model] = &models[..] else { panic!("{} models", models.len()) };
    assert!(matches!(model.unit, threemf::model::Unit::Millimeter));
    assert_eq!(model.build.item.len(), parts.len());
    for (part, object) in parts.iter().zip(&model.resources.object) {
        assert_eq!(object.name.as_ref(), Some(&part.name));
        let read = object.mesh.as_ref().unwrap();
        let mesh = Mesh {
            positions: read.vertices.vertex.iter().map(|v| [v.x, v.y, v.z]).collect(),
            triangles: read
                .triangles
                .triangle
                .iter()
                .map(|t| [t.v1, t.v2, t.v3].map(|v| u32::try_from(v).unwrap()))
                .collect(),
        };
        same_body(part, &mesh, MM);
    }
}

#[test]
fn obj_holds_every_part() {
    let parts = parts();
    let options = tobj::LoadOptions::default();
    let none = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(obj(&parts)), &options, none).unwrap();
    assert_eq!(models.len(), parts.len());
    for (part, model) in parts.iter().zip(&models) {
        let mesh = Mesh {
            positions: model.mesh.positions.chunks(3).map(|p| [0, 1, 2].map(|i| f64::from(p[i]))).collect(),
            triangles: model.mesh.indices.chunks(3).map(|t| [t[0], t[1], t[2]]).collect(),
        };
        same_body(part, &mesh, MM);
    }
}

#[test]
fn gltf_holds_every_part_in_metres_with_normals_and_colours() {
    let parts = parts();
    let text = gltf(&parts);
    let inside = text.split("base64,").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let decoded = base64::Engine::decode(&base64::prelude::BASE64_STANDARD, inside).unwrap();
    let (one, two) = (glb(&parts), text.clone());
    let binary = gltf::Gltf::from_slice(&one).unwrap();
    let document = gltf::Gltf::from_slice(two.as_bytes()).unwrap();
    for (read, data) in [(&binary, binary.blob.clone().unwrap()), (&document, decoded)] {
        assert_eq!(read.nodes().len(), parts.len());
        for (part, mesh) in parts.iter().zip(read.meshes()) {
            let primitive = mesh.primitives().next().unwrap();
            let reader = primitive.reader(|_| Some(&data[..]));
            let positions: Vec<[f64; 3]> =
                reader.read_positions().unwrap().map(|p| p.map(f64::from)).collect();
            let normals: Vec<[f64; 3]> = reader.read_normals().unwrap().map(|p| p.map(f64::from)).collect();
            let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            let mesh = Mesh { positions, triangles: indices.chunks(3).map(|t| [t[0], t[1], t[2]]).collect() };
            let (got, want) = (mesh.volume(), part.mesh.volume());
            assert!((got / want - 1.0).abs() < 1e-5, "{}: {got:e} {want:e}", part.name);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|v| Vector3::from(mesh.positions[v as usize]));
                let face = (b - a).cross(&(c - a)).normalize();
                // Slivers, whose direction single precision does not hold, are shorter than 1 µm across.
                let wide = (b - a).cross(&(c - a)).norm() > 1e-6 * (b - a).norm().max((c - a).norm());
                for v in t {
                    let normal = Vector3::from(normals[*v as usize]);
                    assert!((normal.norm() - 1.0).abs() < 1e-5);
                    assert!(!wide || face.dot(&normal) > 0.5, "{}: {face} {normal}", part.name);
                }
            }
            let colour = primitive.material().pbr_metallic_roughness().base_color_factor();
            // 0xd9, 0x54, 0x1e in linear light.
            for (got, want) in colour.iter().zip([0.6939, 0.0887, 0.0130, 1.0]) {
                assert!((got - want).abs() < 1e-4, "{colour:?}");
            }
        }
    }
}

fn area(path: &[[f64; 2]]) -> f64 {
    let next = path.iter().cycle().skip(1);
    0.5 * path.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

fn pattern(name: &str, tube: usize, kerf: f64) -> Unrolled {
    unrolled(&shipped(name), tube, &UnrolledOptions { tolerance: 0.01 * MM, kerf, below: 0.0 }).unwrap()
}

/// R1's leader: ρ̄ = 3 mm, α = 2 mm; the opening spans ±acos(−2/3) over 5 mm, less the kerf all around.
#[test]
fn openings_have_their_width_and_leave_room_for_the_kerf() {
    for kerf in [0.0, 0.02, 0.1] {
        let pattern = pattern("r1", 0, kerf * MM);
        assert_eq!(pattern.openings.len(), 15);
        let width = 2.0 * 3.0 * (-2.0_f64 / 3.0).acos();
        for opening in &pattern.openings {
            assert!(
                (area(opening) - (width - kerf) * (5.0 - kerf) * 1e-6).abs() < 1e-14,
                "{}",
                area(opening)
            );
        }
        let [straight, radial] = pattern.kept_area.unwrap();
        assert!((straight - 3.097_482e-6).abs() < 1e-12);
        assert!((radial - 5.0 * (2.0_f64 / 3.0).acos() * 1e-6).abs() < 1e-12);
    }
    let [low, high] = pattern("r1", 0, 0.0).outline;
    let half = std::f64::consts::PI * 3.0 * MM;
    let want = [[0.0, -half], [150.0 * MM, half]];
    assert!([low, high].iter().flatten().zip(want.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-15));
}

/// Rolled up again, outside outwards, the openings' corners are vertices of the body.
#[test]
fn openings_rolled_up_lie_on_the_edges_of_the_body() {
    for (name, tube) in [("r3", 0), ("r3", 1), ("helicoid", 0), ("helicoid", 1)] {
        let file = shipped(name);
        let radius = file.tubes[tube].outer_radius.unwrap();
        let cppr::design::TubeDesign::Notched(design) = &file.design.tubes[tube] else { panic!() };
        let opens = design.direction.eval(0.0, file.design.length)[0] + std::f64::consts::PI;
        let mesh = tube_mesh(&file, tube, &TubeOptions::plain(Detail::workshop(0.01 * MM))).unwrap();
        for [u, v] in pattern(name, tube, 0.0).openings.iter().flatten() {
            let angle = opens - v / radius;
            let point = Vector3::new(*u, radius * angle.cos(), radius * angle.sin());
            let nearest =
                mesh.positions.iter().map(|p| (Vector3::from(*p) - point).norm()).fold(1.0, f64::min);
            assert!(nearest < 1e-9, "{name}, tube {}: {nearest} at {u}, {v}", tube + 1);
        }
    }
}

/// A laser-cut tube: uncut shaft and tip, written with a table that leaves the pattern where it is.
#[test]
fn nothing_is_cut_where_the_depth_is_zero() {
    let cut = |depths: &str| {
        single(&format!(
            "outer_radius_mm = 3\ninner_radius_mm = 2\n[tube.notches]\nlength_mm = 0.5\ntooth_mm = 0.3\n\
             depth_mm = {{ x_mm = [0, 20, 20.01, 50, 50.01, 60], depth_mm = {depths} }}"
        ))
    };
    let file = cut("[0, 0, 4, 4, 0, 0]");
    for kerf in [0.0, 0.02] {
        let options = UnrolledOptions { tolerance: 0.01 * MM, kerf: kerf * MM, below: 0.0 };
        let pattern = unrolled(&file, 0, &options).unwrap();
        // Notches k reach from 0.15 + 0.8 k to 0.65 + 0.8 k mm: 25 to 62, the last of them cut short.
        assert_eq!(pattern.openings.len(), 38, "kerf {kerf}");
        let ends = |path: &Vec<[f64; 2]>| path.iter().all(|p| p[0] > 20.0 * MM && p[0] < 50.01 * MM);
        assert!(pattern.openings.iter().all(|path| area(path) > 0.0 && ends(path)));
        assert!(unrolled(&cut("[0, 0, 0, 0, 0, 0]"), 0, &options).unwrap().openings.is_empty());
    }
    let options = TubeOptions::plain(Detail::workshop(0.01 * MM));
    let mesh = tube_mesh(&file, 0, &options).unwrap();
    assert_eq!(mesh.flaws(), Flaws::default());
    assert!((mesh.volume() / tube_volume(&file, 0, &options).unwrap() - 1.0).abs() < 1e-3);
}

#[test]
fn dxf_has_closed_paths_on_layers_in_millimetres() {
    let pattern = pattern("helicoid", 0, 0.02 * MM);
    let bytes = dxf(&pattern).unwrap();
    let drawing = ::dxf::Drawing::load(&mut Cursor::new(bytes)).unwrap();
    assert_eq!(drawing.header.default_drawing_units, ::dxf::enums::Units::Millimeters);
    let mut cuts = pattern.openings.iter();
    for entity in drawing.entities() {
        let ::dxf::entities::EntityType::LwPolyline(line) = &entity.specific else { panic!() };
        assert!(line.is_closed());
        let path: Vec<[f64; 2]> = line.vertices.iter().map(|v| [v.x * MM, v.y * MM]).collect();
        if entity.common.layer == OUTLINE_LAYER {
            assert!((area(&path) - 150.0 * std::f64::consts::TAU * 3.0 * 1e-6).abs() < 1e-12);
        } else {
            assert_eq!(entity.common.layer, CUT_LAYER);
            assert!((area(&path) - area(cuts.next().unwrap())).abs() < 1e-15);
        }
    }
    assert!(cuts.next().is_none());
}

#[test]
fn patterns_that_cannot_be_cut_are_refused() {
    let say = |file: &cppr_io::RobotFile, kerf: f64| {
        unrolled(file, 0, &UnrolledOptions { tolerance: 0.01 * MM, kerf, below: 0.0 })
            .unwrap_err()
            .to_string()
    };
    assert!(say(&shipped("r1"), 6.0 * MM).contains("notch 1 is narrower than a kerf of 6"));
    assert!(say(&shipped("r1"), f64::NAN).contains("the kerf"));
    assert!(say(&shipped("r1"), -0.1 * MM).contains("the kerf"));
    assert!(
        say(&single("outer_radius_mm = 3\ninner_radius_mm = 2\nshape = \"square\""), 0.0)
            .contains("is a polygon")
    );
}
