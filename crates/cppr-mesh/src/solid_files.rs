//! Files of closed bodies for printing and CAD, in millimetres: STL, 3MF, OBJ.

use crate::part::{FileError, Part, millimetres, single};
use cppr::Vector3;
use std::fmt::Write;
use std::io::Cursor;
use threemf2::model::builder::{ModelBuilder, ObjectType, Unit};
use threemf2::package::ThreemfPackageBuilder;

/// Binary STL of all parts as one mesh, in mm (STL names no unit). Vertices are rounded to single precision.
///
/// # Errors
/// [`FileError`] where there are too many triangles.
pub fn stl(parts: &[Part]) -> Result<Vec<u8>, FileError> {
    let triangles: Vec<stl_io::Triangle> = parts
        .iter()
        .flat_map(|part| {
            part.mesh.triangles.iter().map(|t| t.map(|v| millimetres(part.mesh.positions[v as usize])))
        })
        .map(|corners| {
            let [a, b, c] = corners.map(Vector3::from);
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
            stl_io::Triangle {
                normal: stl_io::Normal::new(single(normal.into())),
                vertices: corners.map(|p| stl_io::Vertex::new(single(p))),
            }
        })
        .collect();
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, triangles.iter())
        .map_err(|e| FileError { format: "STL", source: e.into() })?;
    Ok(bytes)
}

/// 3MF with one object per part, in mm.
///
/// # Errors
/// [`FileError`] from the library that writes it.
pub fn three_mf(parts: &[Part]) -> Result<Vec<u8>, FileError> {
    package(parts).map_err(|source| FileError { format: "3MF", source })
}

fn package(parts: &[Part]) -> Result<Vec<u8>, Box<dyn std::error::Error + Send + Sync>> {
    let mut model = ModelBuilder::new(Unit::Millimeter, true);
    model.add_build(None)?;
    for part in parts {
        let object = model.add_mesh_object(|object| {
            object.object_type(ObjectType::Model).name(&part.name);
            for &position in &part.mesh.positions {
                object.add_vertex(&millimetres(position));
            }
            for triangle in &part.mesh.triangles {
                object.add_triangle(&triangle.map(|v| v as usize));
            }
            Ok(())
        })?;
        model.add_build_item(object)?;
    }
    let mut package = ThreemfPackageBuilder::new();
    package.set_root_model(model.build()?);
    let mut bytes = Cursor::new(Vec::new());
    package.build()?.write(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Wavefront OBJ with one object per part, in mm (OBJ names no unit).
#[must_use]
pub fn obj(parts: &[Part]) -> String {
    let mut text = String::from("# millimetres\n");
    let mut before = 1;
    for part in parts {
        // A name ends with its line and, for some readers, with its first blank.
        let name: String = part.name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
        let _ = writeln!(text, "o {name}");
        for [x, y, z] in part.mesh.positions.iter().map(|&p| millimetres(p)) {
            let _ = writeln!(text, "v {x:.7} {y:.7} {z:.7}");
        }
        for [a, b, c] in part.mesh.triangles.iter().map(|t| t.map(|v| v as usize + before)) {
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        before += part.mesh.positions.len();
    }
    text
}
