//! Stability: the tangent on the motions that the actuators leave free.
//!
//! An equilibrium is stable where δuᵀ 𝓛_uu δu > 0 for every δu that keeps the prescribed motions and the
//! edges. Loads that have no potential (follower loads, dead moments) enter with the symmetric part.

use crate::dense::axpy;
use crate::design::Robot;
use crate::kinematics::follower::local;
use crate::kinematics::state::row;
use crate::solve::system::{System, Workspace};
use crate::solve::{Equilibrium, Formulation};
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

/// Lowest eigenvalue of the constrained tangent, its eigenvector, and how many are negative.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// Lowest eigenvalue of 𝓛_uu against the elastic stiffness of the straight robot, both on the free
    /// motions: 1 for a straight, unloaded robot with straight patterns, 0 where it snaps, negative beyond.
    pub margin: f64,
    /// Number of negative eigenvalues: 0 where stable, and one more behind each fold or simple branch point.
    pub inertia: usize,
    /// The motion that belongs to it, in the solver's coordinates, of largest entry 1.
    pub mode: Vec<f64>,
}

/// Margin to instability; `None` for the printed formulation, which is not the derivative of an energy.
#[must_use]
pub fn stability(robot: &Robot, workspace: &mut Workspace, equilibrium: &Equilibrium) -> Option<Stability> {
    if equilibrium.settings.formulation == Formulation::Printed || !equilibrium.status.is_equilibrium() {
        return None;
    }
    equilibrium.refresh(robot, workspace);
    let Reduced { free, lower, tangent } = Reduced::new(workspace, &equilibrium.system(robot))?;
    let eigen = SymmetricEigen::new(tangent);
    let lowest = eigen.eigenvalues.imin();
    let vector = lower.tr_solve_lower_triangular(&eigen.eigenvectors.column(lowest).into_owned())?;
    let mut mode = free * vector;
    for (entry, unit) in mode.iter_mut().zip(&workspace.units) {
        *entry *= unit;
    }
    let largest = mode.amax();
    Some(Stability {
        margin: eigen.eigenvalues[lowest],
        inertia: negative(eigen.eigenvalues.as_slice()),
        mode: (mode / largest).as_slice().to_vec(),
    })
}

/// How many eigenvalues of a spectrum count as negative.
pub(crate) fn negative(spectrum: &[f64]) -> usize {
    spectrum.iter().filter(|&&value| value < -NEUTRAL).count()
}

/// Below this an eigenvalue is rounding error: a neutral motion, as a round rod under an axial load has beyond buckling.
pub(crate) const NEUTRAL: f64 = 1e-9;

/// All eigenvalues, ascending, of the tangent at the evaluated point against the elastic stiffness; `None` as for
/// [`stability`].
pub(crate) fn spectrum(workspace: &mut Workspace, system: &System) -> Option<Vec<f64>> {
    if system.formulation == Formulation::Printed {
        return None;
    }
    let mut values = Reduced::new(workspace, system)?.tangent.symmetric_eigenvalues().as_slice().to_vec();
    values.sort_unstable_by(f64::total_cmp);
    Some(values)
}

/// The tangent on the free motions, in coordinates in which the elastic stiffness is the identity.
struct Reduced {
    /// Basis of the free motions.
    free: DMatrix<f64>,
    /// Lower Cholesky factor of the elastic stiffness on them.
    lower: DMatrix<f64>,
    tangent: DMatrix<f64>,
}

impl Reduced {
    fn new(workspace: &mut Workspace, system: &System) -> Option<Self> {
        let free = free_motions(workspace, system);
        let tangent = reduced_tangent(workspace, &free);
        let elastic = free.transpose() * elastic_stiffness(workspace, system) * &free;
        let lower = Cholesky::new(elastic)?.l();
        let half = lower.solve_lower_triangular(&tangent)?;
        let whole = lower.solve_lower_triangular(&half.transpose())?;
        Some(Self { free, lower, tangent: (&whole + whole.transpose()) * 0.5 })
    }
}

/// Is the evaluated equilibrium a minimum on the free motions?
pub(crate) fn is_stable(workspace: &mut Workspace, system: &System) -> bool {
    if system.formulation == Formulation::Printed {
        return true;
    }
    // The penalties of the tangent vanish on motions that keep the conditions: positive pivots suffice.
    let symmetric = system.loads.first().is_conservative();
    if symmetric && workspace.factor(system).is_ok() && workspace.is_in_order() {
        return true;
    }
    let free = free_motions(workspace, system);
    Cholesky::new(reduced_tangent(workspace, &free)).is_some()
}

/// A basis of the scaled motions that keep all conditions, one column each, by elimination with full
/// pivoting of the conditions' rows.
fn free_motions(workspace: &mut Workspace, system: &System) -> DMatrix<f64> {
    workspace.compose_matrix(system);
    let n_u = system.layout.unknowns();
    let n = workspace.residual.len();
    let mut rows: Vec<Vec<f64>> = (n_u..n).map(|i| workspace.matrix[i * n..i * n + n_u].to_vec()).collect();
    let mut pivots: Vec<(usize, usize)> = Vec::new();
    for turn in 0..rows.len() {
        let mut best = (turn, 0, 0.0_f64);
        for (r, row) in rows.iter().enumerate().skip(turn) {
            for (c, value) in row.iter().enumerate() {
                if value.abs() > best.2 {
                    best = (r, c, value.abs());
                }
            }
        }
        let (r, c, size) = best;
        // A condition that no coordinate can change (a locked angle) binds nothing.
        if size < 1e-13 {
            break;
        }
        rows.swap(turn, r);
        let inverse = 1.0 / rows[turn][c];
        rows[turn].iter_mut().for_each(|v| *v *= inverse);
        let pivot = rows[turn].clone();
        for (other, row) in rows.iter_mut().enumerate() {
            let factor = row[c];
            if other != turn && factor != 0.0 {
                row.iter_mut().zip(&pivot).for_each(|(v, p)| *v -= factor * p);
            }
        }
        pivots.push((turn, c));
    }
    let free: Vec<usize> = (0..n_u).filter(|c| pivots.iter().all(|p| p.1 != *c)).collect();
    let mut basis = DMatrix::zeros(n_u, free.len());
    for (column, &coordinate) in free.iter().enumerate() {
        basis[(coordinate, column)] = 1.0;
        for &(row, pivot) in &pivots {
            basis[(pivot, column)] = -rows[row][coordinate];
        }
    }
    basis
}

/// Symmetric part of the scaled tangent on the free motions.
fn reduced_tangent(workspace: &Workspace, free: &DMatrix<f64>) -> DMatrix<f64> {
    let n = workspace.residual.len();
    let tangent = DMatrix::from_fn(free.nrows(), free.nrows(), |i, j| {
        0.5 * (workspace.matrix[i * n + j] + workspace.matrix[j * n + i])
    });
    free.transpose() * tangent * free
}

/// Σ ℓ w Zᵀ B Z with the strains of the straight bundle and the stiffnesses that face each other now.
fn elastic_stiffness(workspace: &Workspace, system: &System) -> DMatrix<f64> {
    let System { robot, layout, .. } = *system;
    let Workspace { state, assembly, units, .. } = workspace;
    let scale = crate::solve::system::Scale::of(robot);
    let n_u = state.unknowns;
    let mut stiffness = DMatrix::zeros(n_u, n_u);
    let mut add = |rows: &[(usize, f64)], node: usize, factor: f64| {
        let mut strain = vec![0.0; n_u];
        for &(variable, share) in rows {
            let edges = layout.edges.len();
            axpy(&mut strain[edges..], share, &state.z_row(node, variable)[edges..]);
        }
        strain.iter_mut().zip(units).for_each(|(s, unit)| *s *= unit);
        for i in 0..n_u {
            for j in 0..n_u {
                stiffness[(i, j)] += factor / scale.energy * strain[i] * strain[j];
            }
        }
    };
    for (e, element) in layout.elements.iter().enumerate() {
        let rule = &layout.rules[element.rule];
        for i in 0..rule.n {
            let node = element.first_node + i;
            let weight = state.lengths[e] * rule.weights[i];
            for tube in 0..layout.tubes {
                let jets = &assembly.jets[node * layout.tubes + tube];
                let (twist, (c, s), stretch) = if tube == 0 {
                    (vec![(local::KX, 1.0)], (1.0, 0.0), local::E1)
                } else {
                    let (s, c) = state.rest[node * (layout.tubes - 1) + tube - 1][0].sin_cos();
                    let turn = row(tube - 1, local::DTH);
                    (vec![(local::KX, 1.0), (turn, -1.0)], (c, s), row(tube - 1, local::EK))
                };
                add(&twist, node, weight * jets.torsion[0]);
                add(&[(local::KY, c), (local::KZ, -s)], node, weight * jets.bending_y[0]);
                add(&[(local::KY, s), (local::KZ, c)], node, weight * jets.bending_z[0]);
                if layout.stretch {
                    add(&[(stretch, 1.0)], node, weight * jets.axial[0]);
                }
            }
        }
    }
    for edge in 0..layout.edges.len() {
        // Bound by its own condition; any positive number keeps the matrix definite.
        stiffness[(edge, edge)] = f64::EPSILON;
    }
    stiffness
}
