//! Static solutions of a quarter of a cell under unit strains of the beam.
//!
//! The whole cell, in a tube of equal cells under the same strain, moves by u = ū + periodic warping, with
//!
//!   ū_x = e x − κ_Z x Y + κ_Y x Z ,   and by twist   ū_Y = −τ x Z ,  ū_Z = τ x Y .
//!
//! The two mirror planes of the cell make the warping known on the faces of the quarter: under e, κ_Z and κ_Y the planes x = 0 and
//! x = h = (ℓ + t)/2 stay plane, u_x = ū_x, and are free of shear; under τ they turn rigidly, (u_Y, u_Z) = (ū_Y, ū_Z), free of
//! normal stress. On Z = 0 e and κ_Z leave u_Z = 0; κ_Y and τ leave u_x = u_Y = 0. By the same symmetry the stiffness of the beam couples
//! e with κ_Z alone, and its entries per length of tube are S_ij = 4 u_i·K u_j / (2 h), K being the quarter's stiffness matrix.
//! A shear of the whole cell costs nothing: warping u_x ∝ Z or Y turns it into a rigid rotation; so GJ is that of free shear.

use crate::element::{Lame, Shape};
use crate::mesh::Mesh;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};

/// Which displacements are given: three families by the symmetry of the unit strains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    /// Stretch e and curvature κ_Z.
    Plane,
    /// Curvature κ_Y.
    Sideways,
    /// Twist τ.
    Twist,
}

/// Displacement of all nodes under one unit strain, in outer radii.
pub(crate) type Field = Vec<[f64; 3]>;

/// Solutions under unit strains of the beam about the tube's axis, and its stiffness, with E = 1 and lengths in outer radii.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// e, κ_Z, κ_Y, τ.
    pub fields: [Field; 4],
    /// Entries (e, e), (e, κ_Z), (κ_Z, κ_Z), (κ_Y, κ_Y), (τ, τ).
    pub stiffness: [f64; 5],
    pub unknowns: usize,
}

/// The assembled stiffness matrix, by rows of nodes.
struct Assembled {
    /// Neighbours of every node, itself included, rising.
    neighbours: Vec<Vec<u32>>,
    blocks: Vec<Vec<[[f64; 3]; 3]>>,
}

/// Solves all unit strains. None where the mesh is turned inside out or the matrix not positive definite.
pub(crate) fn solve(mesh: &Mesh, poisson: f64) -> Option<Solution> {
    let assembled = Assembled::new(mesh, Lame::new(poisson))?;
    let families = [Family::Plane, Family::Sideways, Family::Twist];
    let mut solved = Vec::new();
    {
        use rayon::prelude::*;
        families.par_iter().map(|family| assembled.solve(mesh, *family)).collect_into_vec(&mut solved);
    }
    let mut fields = Vec::new();
    let mut unknowns = 0;
    for family in solved {
        let (own, count) = family?;
        fields.extend(own);
        unknowns += count;
    }
    let fields: [Field; 4] = fields.try_into().ok()?;
    let scale = 2.0 / mesh.half_pitch;
    let entry = |a: usize, b: usize| scale * assembled.product(&fields[a], &fields[b]);
    let stiffness = [entry(0, 0), entry(0, 1), entry(1, 1), entry(2, 2), entry(3, 3)];
    Some(Solution { fields, stiffness, unknowns })
}

impl Assembled {
    fn new(mesh: &Mesh, material: Lame) -> Option<Self> {
        let count = mesh.nodes.len();
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
        for element in &mesh.elements {
            for &a in element {
                neighbours[a as usize].extend(element);
            }
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        let mut blocks: Vec<Vec<[[f64; 3]; 3]>> =
            neighbours.iter().map(|list| vec![[[0.0; 3]; 3]; list.len()]).collect();
        let shape = Shape::new();
        for element in &mesh.elements {
            let points = element.map(|n| mesh.nodes[n as usize]);
            let own = shape.stiffness(&points, material)?;
            for (a, &row) in element.iter().enumerate() {
                for (b, column) in element.iter().enumerate() {
                    let place = neighbours[row as usize].binary_search(column).ok()?;
                    let target = &mut blocks[row as usize][place];
                    for i in 0..3 {
                        for j in 0..3 {
                            target[i][j] += own[27 * a + b][i][j];
                        }
                    }
                }
            }
        }
        Some(Self { neighbours, blocks })
    }

    /// u · K v.
    fn product(&self, u: &Field, v: &Field) -> f64 {
        let mut sum = 0.0;
        for (row, (list, blocks)) in self.neighbours.iter().zip(&self.blocks).enumerate() {
            for (column, block) in list.iter().zip(blocks) {
                let v = v[*column as usize];
                for (i, row_of_block) in block.iter().enumerate() {
                    sum += u[row][i]
                        * (row_of_block[0] * v[0] + row_of_block[1] * v[1] + row_of_block[2] * v[2]);
                }
            }
        }
        sum
    }

    /// Displacements under the unit strains of a family, and the number of unknowns.
    fn solve(&self, mesh: &Mesh, family: Family) -> Option<(Vec<Field>, usize)> {
        let given = given(mesh, family);
        let mut number = vec![[None; 3]; mesh.nodes.len()];
        let mut unknowns = 0_usize;
        for (node, fixed) in given.iter().enumerate() {
            for i in 0..3 {
                if fixed[i].is_none() {
                    number[node][i] = Some(unknowns);
                    unknowns += 1;
                }
            }
        }
        let cases = if family == Family::Plane { 2 } else { 1 };
        let mut load = Mat::<f64>::zeros(unknowns, cases);
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        // The matrix is symmetric: a row of nodes is read as a column, of which the lower triangle is kept.
        for (node, (list, blocks)) in self.neighbours.iter().zip(&self.blocks).enumerate() {
            for i in 0..3 {
                let Some(column) = number[node][i] else { continue };
                for (other, block) in list.iter().zip(blocks) {
                    for j in 0..3 {
                        let value = block[i][j];
                        match (number[*other as usize][j], given[*other as usize][j]) {
                            (Some(row), _) if row >= column => {
                                rows.push(row);
                                values.push(value);
                            }
                            (None, Some(fixed)) => {
                                for case in 0..cases {
                                    load[(column, case)] -= value * fixed[case];
                                }
                            }
                            _ => {}
                        }
                    }
                }
                starts.push(rows.len());
            }
        }
        let pattern = SymbolicSparseColMat::new_checked(unknowns, unknowns, starts, None, rows);
        let matrix = SparseColMat::new(pattern, values);
        let factor = matrix.sp_cholesky(Side::Lower).ok()?;
        let solved = factor.solve(&load);
        let fields = (0..cases)
            .map(|case| {
                (0..mesh.nodes.len())
                    .map(|node| {
                        std::array::from_fn(|i| match (number[node][i], given[node][i]) {
                            (Some(row), _) => solved[(row, case)],
                            (None, fixed) => fixed.map_or(0.0, |f| f[case]),
                        })
                    })
                    .collect()
            })
            .collect();
        Some((fields, unknowns))
    }
}

/// Per node and direction: the given displacement under the unit strains of the family.
fn given(mesh: &Mesh, family: Family) -> Vec<[Option<[f64; 2]>; 3]> {
    let end = mesh.half_pitch;
    let mut given = vec![[None; 3]; mesh.nodes.len()];
    let (mut highest, mut lowest) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
    for (node, &[x, y, z]) in mesh.nodes.iter().enumerate() {
        let (on_end, on_plane) = (x.abs() < 1e-9 || (x - end).abs() < 1e-9, z.abs() <= 0.0);
        let fixed = &mut given[node];
        match family {
            Family::Plane => {
                if on_end {
                    fixed[0] = Some([x, -x * y]);
                }
                if on_plane {
                    fixed[2] = Some([0.0; 2]);
                }
            }
            Family::Sideways => {
                if on_end {
                    fixed[0] = Some([x * z, 0.0]);
                }
            }
            Family::Twist => {
                if on_end {
                    (fixed[1], fixed[2]) = (Some([-x * z, 0.0]), Some([x * y, 0.0]));
                }
            }
        }
        if family != Family::Plane && on_plane {
            (fixed[0], fixed[1]) = (Some([0.0; 2]), Some([0.0; 2]));
        }
        if on_plane && y > highest.0 {
            highest = (y, node);
        }
        if on_plane && y < lowest.0 {
            lowest = (y, node);
        }
    }
    // Rigid motions that are left: along Y under e and κ_Z; along Z and about x under κ_Y.
    match family {
        Family::Plane => given[highest.1][1] = Some([0.0; 2]),
        Family::Sideways => {
            given[highest.1][2] = Some([0.0; 2]);
            given[lowest.1][2] = Some([0.0; 2]);
        }
        Family::Twist => {}
    }
    given
}
