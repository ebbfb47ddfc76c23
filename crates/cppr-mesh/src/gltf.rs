//! glTF 2.0: one node, mesh and material per part, in metres.
//!
//! The axes are those of the base frame: +X along the robot at rest, +Y, which glTF takes as up, towards the leader's
//! centroid.

use crate::mesh::Shaded;
use crate::part::{Part, single};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

/// Edges sharper than this (rad) are drawn as edges.
const CREASE: f64 = 0.6;
/// Component types, targets and limits of the specification.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Document and buffer in the making.
#[derive(Default)]
struct Scene {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Scene {
    /// Appends data of one kind; the number of its accessor.
    fn push(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len(), "target": target
        }));
        self.buffer.extend_from_slice(bytes);
        accessor["bufferView"] = (self.views.len() - 1).into();
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[[f64; 3]]) -> usize {
        let vectors: Vec<[f32; 3]> = vectors.iter().map(|&v| single(v)).collect();
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let extreme = |start: f32, pick: fn(f32, f32) -> f32| {
            vectors.iter().fold([start; 3], |e, v| std::array::from_fn::<f32, 3, _>(|i| pick(e[i], v[i])))
        };
        let (min, max) = (extreme(f32::INFINITY, f32::min), extreme(f32::NEG_INFINITY, f32::max));
        self.push(
            &bytes,
            ARRAY_BUFFER,
            json!({ "componentType": FLOAT, "count": vectors.len(), "type": "VEC3", "min": min, "max": max }),
        )
    }

    fn mesh(&mut self, part: &Part, material: usize) -> Value {
        let Shaded { positions, normals, triangles } = part.mesh.shaded(CREASE);
        let (positions, normals) = (self.vectors(&positions), self.vectors(&normals));
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let indices = self.push(
            &bytes,
            ELEMENT_ARRAY_BUFFER,
            json!({ "componentType": UNSIGNED_INT, "count": 3 * triangles.len(), "type": "SCALAR" }),
        );
        let primitive = json!({
            "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices, "material": material
        });
        json!({ "name": part.name, "primitives": [primitive] })
    }
}

/// Linear value of an sRGB channel (IEC 61966-2-1), which glTF multiplies light with.
fn linear(channel: u8) -> f64 {
    let c = f64::from(channel) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn document(parts: &[Part], uri: impl Fn(&[u8]) -> Option<String>) -> (Value, Vec<u8>) {
    let mut scene = Scene::default();
    let meshes: Vec<Value> = parts.iter().enumerate().map(|(i, part)| scene.mesh(part, i)).collect();
    let nodes: Vec<Value> =
        parts.iter().enumerate().map(|(i, p)| json!({ "name": p.name, "mesh": i })).collect();
    let materials: Vec<Value> = parts
        .iter()
        .map(|part| {
            let [r, g, b] = part.colour.map(linear);
            json!({
                "name": part.name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6
                }
            })
        })
        .collect();
    let mut buffer = json!({ "byteLength": scene.buffer.len() });
    if let Some(uri) = uri(&scene.buffer) {
        buffer["uri"] = uri.into();
    }
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("cppr ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": (0..parts.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": scene.accessors,
        "bufferViews": scene.views,
        "buffers": [buffer]
    });
    (document, scene.buffer)
}

/// One JSON document with the data inside.
#[must_use]
pub fn gltf(parts: &[Part]) -> String {
    let inside = |buffer: &[u8]| {
        Some(format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(buffer)))
    };
    document(parts, inside).0.to_string()
}

/// The binary container, GLB.
#[must_use]
pub fn glb(parts: &[Part]) -> Vec<u8> {
    let (document, mut buffer) = document(parts, |_| None);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let word = |value: usize| u32::try_from(value).unwrap_or(u32::MAX).to_le_bytes();
    let mut file = Vec::with_capacity(28 + text.len() + buffer.len());
    file.extend(b"glTF");
    file.extend(word(2));
    file.extend(word(28 + text.len() + buffer.len()));
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &buffer)] {
        file.extend(word(chunk.len()));
        file.extend(kind);
        file.extend(chunk);
    }
    file
}
