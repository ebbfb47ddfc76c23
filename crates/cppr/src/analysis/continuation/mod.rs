//! Pseudo-arclength continuation: all equilibria on a path of commands, past folds and onto other branches.
//!
//! A [`Family`] of commands over the fraction λ makes the equilibria a curve z(s) = (y(s), λ(s)), followed by a predictor
//! along its tangent and Newton's method on the exact bordered system (Keller 1977; Allgower and Georg, *Numerical
//! Continuation Methods*, 1990). λ need not grow along it. Found on the way:
//!
//! - **folds**, where dλ/ds changes its sign: the robot snaps when λ is driven on;
//! - **branch points**, where an eigenvalue of the constrained tangent changes its sign without a fold, or the
//!   determinant of the bordered system does: the robot may leave into each of the directions that the critical
//!   eigenvectors point to.
//!
//! Both are located by the secant method to [`Tracing::tolerance`]. Inertia is the number of negative eigenvalues of the
//! symmetric tangent on the free motions; where loads have no potential, stability by it is the safe side, and
//! branch points are taken only where the true tangent is singular as well. Between two computed points an even
//! number of events of one kind can hide; [`Tracing::step`] bounds how far they are apart.
//!
//! Lengths along a path are Euclidean in the scaled coordinates (curvature times L: angles in rad) and λ.

mod bordered;
mod events;
mod family;
mod plate;
mod track;

pub use family::{Family, FamilyProblem, Parameter};

use crate::solve::{Equilibrium, Solver, Status};
use bordered::{Bordered, Node, PathState};
use nalgebra::Vector3;
use track::{Tracer, Trail};

/// How a path is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracing {
    /// Longest step along the path. Default 0.05: a twentieth of the way, or some 3° of bending.
    pub step: f64,
    /// Shortest step that is tried. Default 1e-7.
    pub shortest: f64,
    /// To which length along the path folds and branch points are located. Default 1e-8.
    pub tolerance: f64,
    /// Most points of one branch. Default 2000.
    pub points: usize,
    /// Most steps on all branches together, those that were too long included: the bound of what tracing costs. Default: none.
    pub steps: usize,
    /// How many times a branch is left for another: 0, the default, traces the first one only.
    pub depth: usize,
}

impl Default for Tracing {
    fn default() -> Self {
        Self { step: 0.05, shortest: 1e-7, tolerance: 1e-8, points: 2000, steps: usize::MAX, depth: 0 }
    }
}

/// What is special about a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// Nothing.
    Regular,
    /// The parameter turns back.
    Fold,
    /// Branches cross, or touch.
    BranchPoint {
        /// How many eigenvalues vanish together.
        multiplicity: usize,
    },
    /// The edge where the pattern of a follower begins passes the baseplate, a load or another edge; or a follower driven by
    /// force comes to stand with it at the plate, or leaves.
    Edge {
        /// Tube number.
        tube: usize,
    },
}

/// One equilibrium of a path.
#[derive(Clone, Debug)]
pub struct PathPoint<E = Equilibrium> {
    /// The parameter in its own unit (SI).
    pub parameter: f64,
    /// λ: 0 at the first command, 1 at the last.
    pub fraction: f64,
    /// What is special here.
    pub kind: PointKind,
    /// Centre of the tip section, base frame (m).
    pub tip: Vector3<f64>,
    /// Negative eigenvalues of the constrained tangent: 0 is stable. `None` for the printed formulation.
    pub inertia: Option<usize>,
    /// Lowest of them, as [`super::stability::Stability::margin`]. `None` where it was not computed.
    pub margin: Option<f64>,
    /// The equilibrium itself: efforts, motions, energy, shape.
    pub equilibrium: E,
}

impl<E> PathPoint<E> {
    /// False where the robot would leave this equilibrium. For the printed formulation nothing is claimed: true.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.inertia.unwrap_or(0) == 0
    }
}

/// Where and why a branch ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// At the last command.
    Last,
    /// Back at the first command.
    First,
    /// Where it began: a closed curve.
    Closed,
    /// [`Tracing::points`] are computed, or [`Tracing::steps`] taken.
    Points,
    /// No step, however short, leads on: the model ends here, or a singularity that is neither fold nor branch point.
    Step,
    /// No equilibrium was found where the edge of a follower's pattern has passed the baseplate, a load or another edge.
    Edge {
        /// Tube number.
        tube: usize,
    },
    /// A follower has slid by the robot's length.
    Left {
        /// Tube number.
        tube: usize,
    },
    /// [`Solver::stop_by`], or the flag of [`BundleSolver::trace_until`](crate::bundle::solve::BundleSolver::trace_until).
    Stopped,
    /// There is no equilibrium at the first command, or it is singular.
    NoStart(Status),
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Last => write!(f, "reached the end of the path"),
            Self::First => write!(f, "came back to the beginning of the path"),
            Self::Closed => write!(f, "closed on itself"),
            Self::Points => {
                write!(f, "stopped after the largest number of points; ask for more or for longer steps")
            }
            Self::Step => write!(
                f,
                "stopped where no shorter step leads on: the path is singular there, or the solver failed"
            ),
            Self::Edge { tube } => write!(
                f,
                "stopped where the pattern of tube {tube} meets the baseplate or a load: no equilibrium was found beyond"
            ),
            Self::Left { tube } => write!(f, "stopped where tube {tube} has slid by the robot's length"),
            Self::Stopped => write!(f, "was stopped"),
            Self::NoStart(Status::NotConverged(_)) => write!(f, "has no equilibrium to begin with"),
            Self::NoStart(_) => write!(f, "begins at a singular equilibrium; begin beside it"),
        }
    }
}

/// Where a branch comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Index of the branch that was left.
    pub branch: usize,
    /// Index of the branch point among its points.
    pub point: usize,
    /// Which of the critical eigenvectors there was followed.
    pub mode: usize,
    /// Along it or against it.
    pub along: bool,
}

/// A curve of equilibria.
#[derive(Clone, Debug)]
pub struct Branch<E = Equilibrium> {
    /// In order along the curve; a branch that left another begins with its branch point.
    pub points: Vec<PathPoint<E>>,
    /// Why it ends.
    pub end: End,
    /// Where it left another one; `None` for the first.
    pub origin: Option<Origin>,
}

impl Solver {
    /// Traces the equilibria of a family of commands from its first to its last, and the branches that leave them.
    ///
    /// The first branch begins at the equilibrium that [`Solver::solve`] finds for the first command; others follow in the order
    /// in which their branch points were found, both directions of every critical eigenvector.
    ///
    /// # Errors
    /// Where a command of the family cannot be asked of this robot.
    pub fn trace(&mut self, family: &Family, tracing: &Tracing) -> Result<Vec<Branch>, FamilyProblem> {
        let start = self.solve(&family.at(0.0)).map_err(FamilyProblem::Command)?;
        self.trace_from(family, tracing, &start)
    }

    /// Traces the paths of a family from a given equilibrium of its first command: another one than [`Solver::solve`] finds.
    ///
    /// # Errors
    /// As [`Solver::trace`], and where the equilibrium is one of another robot or of other settings.
    pub fn trace_from(
        &mut self,
        family: &Family,
        tracing: &Tracing,
        start: &Equilibrium,
    ) -> Result<Vec<Branch>, FamilyProblem> {
        family.check(self)?;
        if start.robot.serial() != self.robot.serial() || start.settings != self.settings {
            return Err(FamilyProblem::OtherStart);
        }
        let mut tracer = Tracer::new(Bordered::new(self, family), tracing);
        let Some(first) = tracer.begin(start) else {
            return Ok(vec![Branch { points: Vec::new(), end: End::NoStart(start.status), origin: None }]);
        };
        let mut branches: Vec<Branch> = Vec::new();
        let mut crossings: Vec<Crossing> = Vec::new();
        let mut trail = Trail::from(vec![first.point.clone()]);
        let end = tracer.follow(&first, &mut trail);
        collect(&mut branches, &mut crossings, trail, end, None, 0);
        let mut next = 0;
        while next < crossings.len() {
            let Crossing { branch, point, depth, node, directions } = crossings[next].clone();
            next += 1;
            if depth >= tracing.depth {
                continue;
            }
            for (mode, direction) in directions.iter().enumerate() {
                for along in [true, false] {
                    let Some(leaving) = tracer.switch(&node, direction, along) else { continue };
                    let mut trail = Trail::from(vec![node.point.clone(), leaving.point.clone()]);
                    let end = tracer.follow(&leaving, &mut trail);
                    let origin = Some(Origin { branch, point, mode, along });
                    collect(&mut branches, &mut crossings, trail, end, origin, depth + 1);
                }
            }
        }
        Ok(branches)
    }
}

/// A branch point with the directions that leave there.
#[derive(Clone)]
struct Crossing {
    branch: usize,
    point: usize,
    depth: usize,
    node: Node,
    directions: Vec<Vec<f64>>,
}

/// Keeps a traced branch, and those of its branch points that are new.
fn collect(
    branches: &mut Vec<Branch>,
    crossings: &mut Vec<Crossing>,
    trail: Trail,
    end: End,
    origin: Option<Origin>,
    depth: usize,
) {
    let branch = branches.len();
    for (point, node, directions) in trail.crossings {
        let known = crossings.iter().any(|c| same(&c.node.place, &node.place));
        if !known {
            crossings.push(Crossing { branch, point, depth, node, directions });
        }
    }
    branches.push(Branch { points: trail.points, end, origin });
}

/// How near (relative) two branch points are one: far above the error of location, far below the distance of two.
const SAME: f64 = 1e-4;

fn same(a: &PathState, b: &PathState) -> bool {
    let (a_u, b_u) = (&a.point.coordinates, &b.point.coordinates);
    let size = a_u.iter().chain(b_u).fold(0.0_f64, |m, x| m.max(x.abs()));
    a_u.len() == b_u.len()
        && (a.fraction - b.fraction).abs() <= SAME
        && a_u.iter().zip(b_u).all(|(x, y)| (x - y).abs() <= SAME * size)
}
