//! Triangle meshes: what closes them, their volume, and normals for shading.

use crate::body::index;
use cppr::Vector3;
use std::collections::HashMap;

/// A triangle mesh with shared vertices. Triangles run anticlockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices (m).
    pub positions: Vec<[f64; 3]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

/// A mesh for shading: vertices on sharp edges stand there once per smooth side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shaded {
    /// Vertices (m).
    pub positions: Vec<[f64; 3]>,
    /// Unit normals, one per vertex.
    pub normals: Vec<[f64; 3]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

/// What of a mesh keeps it from being the boundary of a body; all zero for a sound one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Edges without a triangle that runs along them the other way.
    pub open_edges: usize,
    /// Edges along which more than one triangle runs the same way.
    pub crowded_edges: usize,
    /// Vertices at which several fans of triangles touch.
    pub pinched_vertices: usize,
    /// Vertices that no triangle uses.
    pub loose_vertices: usize,
    /// Triangles without area in double precision, or with a vertex that is not finite.
    pub flat_triangles: usize,
}

impl Mesh {
    fn corner(&self, vertex: u32) -> Vector3<f64> {
        self.positions[vertex as usize].into()
    }

    /// Twice the area of a triangle times its outward normal (m²).
    fn area_vector(&self, [a, b, c]: [u32; 3]) -> Vector3<f64> {
        let origin = self.corner(a);
        (self.corner(b) - origin).cross(&(self.corner(c) - origin))
    }

    /// Enclosed volume (m³), by the divergence theorem: ⅙ Σ a · (b × c).
    #[must_use]
    pub fn volume(&self) -> f64 {
        let six: f64 = self
            .triangles
            .iter()
            .map(|&[a, b, c]| self.corner(a).dot(&self.corner(b).cross(&self.corner(c))))
            .sum();
        six / 6.0
    }

    /// Smallest and largest coordinates (m); zeros for an empty mesh.
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let first = self.positions.first().copied().unwrap_or_default();
        self.positions.iter().fold([first, first], |[low, high], p| {
            [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
        })
    }

    /// Looks for what keeps the mesh from being the boundary of a body.
    #[must_use]
    pub fn flaws(&self) -> Flaws {
        let mut flaws = Flaws::default();
        // From each vertex and the next one of a triangle: how many triangles run that way, and their third vertex.
        let mut edges: HashMap<[u32; 2], (usize, u32)> = HashMap::with_capacity(3 * self.triangles.len());
        let mut degree = vec![0_usize; self.positions.len()];
        let mut start: Vec<Option<u32>> = vec![None; self.positions.len()];
        for &[a, b, c] in &self.triangles {
            for [from, to, third] in [[a, b, c], [b, c, a], [c, a, b]] {
                let entry = edges.entry([from, to]).or_insert((0, third));
                entry.0 += 1;
                degree[from as usize] += 1;
                start[from as usize] = Some(to);
            }
            // NaN counts as flat.
            let has_area = self.area_vector([a, b, c]).norm() > 0.0;
            flaws.flat_triangles += usize::from(!has_area);
        }
        flaws.crowded_edges = edges.values().filter(|(count, _)| *count > 1).count();
        flaws.open_edges = edges.keys().filter(|[from, to]| !edges.contains_key(&[*to, *from])).count();
        for (vertex, first) in start.iter().enumerate() {
            let Some(first) = *first else {
                flaws.loose_vertices += 1;
                continue;
            };
            // The fan around the vertex, from triangle to triangle.
            let (mut to, mut length) = (first, 0);
            while let Some((_, third)) = edges.get(&[index(vertex), to]) {
                length += 1;
                to = *third;
                if to == first || length > degree[vertex] {
                    break;
                }
            }
            flaws.pinched_vertices += usize::from(length != degree[vertex]);
        }
        flaws
    }

    /// The mesh with normals for shading: at each vertex the normals of adjoining triangles, weighted with
    /// their angles, are averaged where they differ by less than `crease` (rad) from that of the triangle.
    #[must_use]
    pub fn shaded(&self, crease: f64) -> Shaded {
        let unit: Vec<Vector3<f64>> = self
            .triangles
            .iter()
            .map(|&t| self.area_vector(t).try_normalize(0.0).unwrap_or_default())
            .collect();
        let mut around: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.positions.len()];
        for (index, &[a, b, c]) in self.triangles.iter().enumerate() {
            for [at, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
                let angle =
                    (self.corner(next) - self.corner(at)).angle(&(self.corner(last) - self.corner(at)));
                around[at as usize].push((index, angle));
            }
        }
        let limit = crease.cos();
        let mut shaded = Shaded::default();
        let mut known: HashMap<(u32, [i32; 3]), u32> = HashMap::new();
        for (own, triangle) in unit.iter().zip(&self.triangles) {
            shaded.triangles.push(triangle.map(|vertex| {
                let smooth =
                    around[vertex as usize].iter().filter(|(other, _)| unit[*other].dot(own) > limit);
                let sum: Vector3<f64> = smooth.map(|(other, angle)| unit[*other] * *angle).sum();
                let normal = sum.try_normalize(0.0).unwrap_or(*own);
                // Equal normals from different triangles agree to rounding; 1e-4 rad is not seen.
                #[expect(clippy::cast_possible_truncation, reason = "components of a unit vector")]
                let key = [normal.x, normal.y, normal.z].map(|v| (v * 1e4).round() as i32);
                *known.entry((vertex, key)).or_insert_with(|| {
                    shaded.positions.push(self.positions[vertex as usize]);
                    shaded.normals.push(normal.into());
                    index(shaded.positions.len() - 1)
                })
            }));
        }
        shaded
    }
}
