//! Derivatives of an equilibrium, from one factorisation of its tangent.
//!
//! The conditions r(y; p) = 0 of `solve::newton` hold for every input p, so that dy/dp = −(∂r/∂y)⁻¹ ∂r/∂p. Motions,
//! efforts and loads enter r linearly and are differentiated exactly; design parameters enter through the
//! material fields and are differentiated at fixed y by a fourth-order difference of r.

use crate::dense::column;
use crate::design::Robot;
use crate::kinematics::pose::Poses;
use crate::solve::command::inputs;
use crate::solve::constraint::Constraint;
use crate::solve::system::{Buffers, Scale};
use crate::solve::{Equilibrium, Input, Solver, Status};
use nalgebra::{DMatrix, Matrix6, Vector6};
use std::fmt;

/// First derivatives of an equilibrium by its inputs and by a wrench on the tip.
///
/// Twists are (translation of the tip section's centre (m), rotation (rad)), wrenches (force (N), moment about that
/// centre (N m)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// What the columns of the Jacobians are: push-pull and rotation of tube 2, then of tube 3, …
    pub inputs: Vec<Input>,
    /// TipRows twist by the inputs, base frame, 6 × m.
    pub tip_jacobian: DMatrix<f64>,
    /// TipRows twist by the inputs, frame of the tip section, 6 × m.
    pub tip_jacobian_body: DMatrix<f64>,
    /// The conjugate of every input by every input, m × m: effort where the motion is prescribed, motion where
    /// the effort is.
    pub response: DMatrix<f64>,
    /// TipRows twist by a dead tip wrench, base frame, inputs held.
    pub compliance: Matrix6<f64>,
    /// The conjugate of every input by a dead tip wrench, m × 6: what force sensing inverts.
    pub response_by_wrench: DMatrix<f64>,
}

/// Why an equilibrium has no derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoDerivatives {
    /// It is none.
    NoEquilibrium(Status),
    /// Its tangent is singular: it stands at a fold or a branch point.
    Singular,
    /// A robot moved by a design parameter is of another kind, or cannot stand there.
    Perturbed,
}

impl fmt::Display for NoDerivatives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoEquilibrium(status) => {
                write!(f, "there are no derivatives without an equilibrium: {status}")
            }
            Self::Singular => {
                write!(f, "there are no derivatives at a fold or branch point: the tangent is singular there")
            }
            Self::Perturbed => {
                write!(
                    f,
                    "the robots on both sides of the parameter do not fit the equilibrium; take a smaller step"
                )
            }
        }
    }
}

impl std::error::Error for NoDerivatives {}

/// Evaluates and factors the tangent of an equilibrium, poses and their rows included.
fn factor(buffers: &mut Buffers, equilibrium: &Equilibrium) -> Result<(), NoDerivatives> {
    if !equilibrium.status.is_equilibrium() {
        return Err(NoDerivatives::NoEquilibrium(equilibrium.status));
    }
    equilibrium.refresh(buffers);
    buffers.pose_rows(&equilibrium.robot, &equilibrium.layout);
    buffers.factor(&equilibrium.system()).map_err(|_| NoDerivatives::Singular)
}

impl Solver {
    /// Jacobians and compliance.
    ///
    /// # Errors
    /// Where there is no equilibrium, or its tangent is singular (at a fold).
    pub fn sensitivity(&mut self, equilibrium: &Equilibrium) -> Result<Sensitivity, NoDerivatives> {
        let mut result = Sensitivity::default();
        self.sensitivity_into(equilibrium, &mut result)?;
        Ok(result)
    }

    /// [`Solver::sensitivity`] for control loops: allocates nothing where `result` comes from the same robot.
    ///
    /// # Errors
    /// As [`Solver::sensitivity`]; `result` is then left as it was.
    pub fn sensitivity_into(
        &mut self,
        equilibrium: &Equilibrium,
        result: &mut Sensitivity,
    ) -> Result<(), NoDerivatives> {
        factor(&mut self.buffers, equilibrium)?;
        derive(&mut self.buffers, equilibrium, result);
        Ok(())
    }

    /// Derivatives of any outputs of an equilibrium by its inputs, one column each: the unknowns' derivatives are exact, the outputs
    /// are read along them by a fourth-order difference.
    ///
    /// # Errors
    /// As [`Solver::sensitivity`].
    pub fn outputs_by_inputs(
        &mut self,
        equilibrium: &Equilibrium,
        outputs: impl Fn(&mut Self, &Equilibrium) -> Vec<f64>,
    ) -> Result<DMatrix<f64>, NoDerivatives> {
        let m = self.sensitivity(equilibrium)?.inputs.len();
        let (n_u, n) = (self.buffers.state.unknowns, self.buffers.residual.len());
        // What was solved there: scaled steps of the unknowns, by rows.
        let steps = self.buffers.right.clone();
        let mut slopes: Option<DMatrix<f64>> = None;
        for c in 0..m {
            let step: Vec<f64> = (0..n).map(|i| steps[i * (m + 6) + c]).collect();
            let largest = step[..n_u].iter().fold(f64::MIN_POSITIVE, |most, s| most.max(s.abs()));
            let h = SMALL / largest;
            for (at, share) in Perturbed::SHARES {
                let along = equilibrium.moved(&equilibrium.robot, &step, at * h);
                let values = outputs(self, &along);
                let slopes = slopes.get_or_insert_with(|| DMatrix::zeros(values.len(), m));
                for (r, value) in values.iter().enumerate() {
                    slopes[(r, c)] += share * value / (12.0 * h);
                }
            }
        }
        // A robot without inputs.
        Ok(slopes.unwrap_or_else(|| DMatrix::zeros(0, 0)))
    }

    /// Derivatives of any outputs of an equilibrium by one design parameter.
    ///
    /// `outputs` reads what is wanted from an equilibrium, the same number of values each time.
    ///
    /// # Errors
    /// As [`Solver::sensitivity`], and where the robots moved to both sides are not of the equilibrium's kind.
    pub fn parameter_sensitivity(
        &mut self,
        equilibrium: &Equilibrium,
        perturbed: &Perturbed,
        outputs: impl Fn(&mut Self, &Equilibrium) -> Vec<f64>,
    ) -> Result<Vec<f64>, NoDerivatives> {
        let Perturbed { step, robots } = perturbed;
        let (step, robot) = (*step, &equilibrium.robot);
        if robots.iter().any(|moved| moved.tube_count() != robot.tube_count()) {
            return Err(NoDerivatives::Perturbed);
        }
        if !equilibrium.status.is_equilibrium() {
            return Err(NoDerivatives::NoEquilibrium(equilibrium.status));
        }
        let scale = Scale::of(robot);
        let mut slope: Vec<f64> = Vec::new();
        for (moved, &(_, share)) in robots.iter().zip(&Perturbed::SHARES) {
            let system = equilibrium.system_of(moved);
            self.buffers.residual_at(&system, &equilibrium.point).map_err(|_| NoDerivatives::Perturbed)?;
            slope.resize(self.buffers.residual.len(), 0.0);
            let rescale = Scale::of(moved).energy / scale.energy;
            for (i, (s, r)) in slope.iter_mut().zip(&self.buffers.residual).enumerate() {
                // Each robot scales its residual by its own stiffness; conditions are not scaled by it.
                let factor = if i < equilibrium.layout.unknowns() { rescale } else { 1.0 };
                *s -= share * factor * r / (12.0 * step);
            }
        }
        factor(&mut self.buffers, equilibrium)?;
        self.buffers.solve(&mut slope, 1);
        let mut total: Vec<f64> = Vec::new();
        for (moved, &(at, share)) in robots.iter().zip(&Perturbed::SHARES) {
            let along = equilibrium.moved(moved, &slope, at * step);
            let values = outputs(self, &along);
            total.resize(values.len(), 0.0);
            for (t, value) in total.iter_mut().zip(values) {
                *t += share * value / (12.0 * step);
            }
        }
        Ok(total)
    }
}

/// The condition that holds input number `i`, where its motion is prescribed; its row is that of the motion in any case.
fn condition(i: usize, input: &Input) -> Constraint {
    Constraint::Motion { follower: i / 2, freedom: input.freedom }
}

/// Reads everything from the factored tangent of an equilibrium. Conditions follow the coordinates in the order of the inputs.
fn derive(buffers: &mut Buffers, equilibrium: &Equilibrium, result: &mut Sensitivity) {
    let scale = Scale::of(&equilibrium.robot);
    let (n_u, n) = (buffers.state.unknowns, buffers.residual.len());
    result.place(equilibrium);
    let m = result.inputs.len();
    // −∂r/∂p for all inputs and the six components of a tip wrench.
    let columns = m + 6;
    let mut rhs = std::mem::take(&mut buffers.right);
    rhs.clear();
    rhs.resize(n * columns, 0.0);
    let mut row = n_u;
    for (c, input) in result.inputs.iter().enumerate() {
        if input.is_motion {
            rhs[row * columns + c] = condition(c, input).scale(scale);
            row += 1;
        } else {
            let slopes = condition(c, input).row(&buffers.assembly);
            for (i, (slope, unit)) in slopes.iter().zip(&buffers.units).enumerate() {
                rhs[i * columns + c] = slope * unit / scale.energy;
            }
        }
    }
    let tip = TipRows::new(&buffers.poses);
    for i in 0..tip.leader_unknowns {
        let rate = tip.rate(i) * (buffers.units[i] / scale.energy);
        rhs[i * columns + m..(i + 1) * columns].copy_from_slice(rate.as_slice());
    }
    buffers.solve(&mut rhs, columns);
    let mut compliance = Matrix6::zeros();
    result.tip_jacobian.fill(0.0);
    for (i, row) in rhs.chunks_exact(columns).take(tip.leader_unknowns).enumerate() {
        let rate = tip.rate(i) * buffers.units[i];
        for (mut twist, value) in result.tip_jacobian.column_iter_mut().zip(&row[..m]) {
            twist.axpy(*value, &rate, 1.0);
        }
        for (mut twist, value) in compliance.column_iter_mut().zip(&row[m..]) {
            twist.axpy(*value, &rate, 1.0);
        }
    }
    result.compliance = compliance;
    let turn = buffers.poses.rotation[buffers.poses.rotation.len() - 1].transpose();
    for (mut body, world) in result.tip_jacobian_body.column_iter_mut().zip(result.tip_jacobian.column_iter())
    {
        body.fixed_rows_mut::<3>(0).copy_from(&(turn * world.fixed_rows::<3>(0)));
        body.fixed_rows_mut::<3>(3).copy_from(&(turn * world.fixed_rows::<3>(3)));
    }
    let mut row = n_u;
    for (r, input) in result.inputs.iter().enumerate() {
        for c in 0..columns {
            let value = if input.is_motion {
                rhs[row * columns + c] * condition(r, input).effort_unit(scale)
            } else {
                let slopes = condition(r, input).row(&buffers.assembly).iter().zip(&buffers.units);
                slopes.enumerate().map(|(i, (slope, unit))| slope * unit * rhs[i * columns + c]).sum()
            };
            if c < m {
                result.response[(r, c)] = value;
            } else {
                result.response_by_wrench[(r, c - m)] = value;
            }
        }
        row += usize::from(input.is_motion);
    }
    buffers.right = rhs;
}

impl Sensitivity {
    /// Names the inputs of an equilibrium and makes room for them.
    fn place(&mut self, equilibrium: &Equilibrium) {
        self.inputs.clear();
        // A follower that stands at the plate is an input by motion there.
        self.inputs.extend(inputs(&equilibrium.drives).map(|(input, _)| input));
        let m = self.inputs.len();
        for (matrix, rows, columns) in [
            (&mut self.tip_jacobian, 6, m),
            (&mut self.tip_jacobian_body, 6, m),
            (&mut self.response, m, m),
            (&mut self.response_by_wrench, m, 6),
        ] {
            if matrix.shape() != (rows, columns) {
                *matrix = DMatrix::zeros(rows, columns);
            }
        }
    }
}

/// Rows of the tip's twist by the unknowns.
#[derive(Clone, Copy)]
struct TipRows<'a> {
    shift: &'a [f64],
    spin: &'a [f64],
    /// Unknowns that move it.
    leader_unknowns: usize,
}

impl<'a> TipRows<'a> {
    fn new(poses: &'a Poses) -> Self {
        let start = (poses.rotation.len() - 1) * 3 * poses.leader_unknowns;
        Self {
            shift: &poses.shift[start..],
            spin: &poses.spin[start..],
            leader_unknowns: poses.leader_unknowns,
        }
    }

    fn rate(&self, i: usize) -> Vector6<f64> {
        let (shift, spin) =
            (column(self.shift, self.leader_unknowns, i), column(self.spin, self.leader_unknowns, i));
        Vector6::new(shift.x, shift.y, shift.z, spin.x, spin.y, spin.z)
    }
}

/// Largest scaled step of the unknowns in the differences below: the fifth power of it is rounding.
const SMALL: f64 = 1e-3;

/// A robot with one design parameter moved to both sides, for fourth-order differences.
#[derive(Clone, Debug)]
pub struct Perturbed {
    step: f64,
    robots: [Robot; 4],
}

impl Perturbed {
    /// Places of the robots in steps, and their weights.
    const SHARES: [(f64, f64); 4] = [(1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)];

    /// `robot_at(p)` is the robot at the parameter's distance p from its present value, `step` a distance over
    /// which the fields change smoothly: 1e-3 of the parameter is a good choice. `None` where a robot cannot be built.
    pub fn new(step: f64, robot_at: impl Fn(f64) -> Option<Robot>) -> Option<Self> {
        let [a, b, c, d] = Self::SHARES.map(|(at, _)| robot_at(at * step));
        Some(Self { step, robots: [a?, b?, c?, d?] })
    }
}
