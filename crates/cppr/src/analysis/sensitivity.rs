//! Derivatives of an equilibrium, from one factorisation of its tangent.
//!
//! The conditions r(y; p) = 0 of `solve::newton` hold for every input p, so that dy/dp = −(∂r/∂y)⁻¹ ∂r/∂p. Motions,
//! efforts and loads enter r linearly and are differentiated exactly; design parameters enter through the
//! material fields and are differentiated at fixed y by a fourth-order difference of r.

use crate::dense::column;
use crate::design::Robot;
use crate::kinematics::pose::Poses;
use crate::solve::Equilibrium;
use crate::solve::system::{Scale, Workspace};
use nalgebra::{DMatrix, Matrix6, Vector6};

/// Which degree of freedom of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Translation: Δa_k (m) and T_k (N).
    PushPull,
    /// Rotation: Ω_k (rad) and Υ_k (N m).
    Rotation,
}

/// One input of a robot: column of a Jacobian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// Tube number as in the paper: 2 is the first follower.
    pub tube: usize,
    /// Its degree of freedom.
    pub freedom: Freedom,
    /// True where the motion is prescribed, false where the effort is.
    pub is_motion: bool,
}

/// First derivatives of an equilibrium by its inputs and by a wrench on the tip.
///
/// Twists are (translation of the tip section's centre (m), rotation (rad)), wrenches (force (N), moment about that
/// centre (N m)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// What the columns of the Jacobians are: push-pull and rotation of tube 2, then of tube 3, …
    pub inputs: Vec<Input>,
    /// Tip twist by the inputs, base frame, 6 × m.
    pub tip_jacobian: DMatrix<f64>,
    /// Tip twist by the inputs, frame of the tip section, 6 × m.
    pub tip_jacobian_body: DMatrix<f64>,
    /// The conjugate of every input by every input, m × m: effort where the motion is prescribed, motion where
    /// the effort is.
    pub response: DMatrix<f64>,
    /// Tip twist by a dead tip wrench, base frame, inputs held.
    pub compliance: Matrix6<f64>,
    /// The conjugate of every input by a dead tip wrench, m × 6: what force sensing inverts.
    pub response_by_wrench: DMatrix<f64>,
}

/// Evaluates and factors the tangent of an equilibrium, poses and their rows included.
fn factor(robot: &Robot, workspace: &mut Workspace, equilibrium: &Equilibrium) -> Option<()> {
    if !equilibrium.status.is_equilibrium() {
        return None;
    }
    equilibrium.refresh(robot, workspace);
    workspace.pose_rows(robot, &equilibrium.layout);
    workspace.factor(&equilibrium.system(robot)).ok()
}

/// Jacobians and compliance. `None` where there is no equilibrium or its tangent is singular (at a fold).
#[must_use]
pub fn sensitivity(
    robot: &Robot,
    workspace: &mut Workspace,
    equilibrium: &Equilibrium,
) -> Option<Sensitivity> {
    let mut result = Sensitivity::default();
    sensitivity_into(robot, workspace, equilibrium, &mut result).then_some(result)
}

/// The same for control loops: allocates nothing where `result` comes from the same robot. False where there are no
/// derivatives; `result` is then left as it was.
pub fn sensitivity_into(
    robot: &Robot,
    workspace: &mut Workspace,
    equilibrium: &Equilibrium,
    result: &mut Sensitivity,
) -> bool {
    if factor(robot, workspace, equilibrium).is_none() {
        return false;
    }
    let scale = Scale::of(robot);
    let (n_u, n) = (workspace.state.unknowns, workspace.residual.len());
    result.place(equilibrium);
    let m = result.inputs.len();
    // −∂r/∂p for all inputs and the six components of a tip wrench.
    let columns = m + 6;
    let mut rhs = std::mem::take(&mut workspace.right);
    rhs.clear();
    rhs.resize(n * columns, 0.0);
    let mut row = n_u;
    for (c, input) in result.inputs.iter().enumerate() {
        if input.is_motion {
            rhs[row * columns + c] = -1.0 / input.freedom.unit(scale.length);
            row += 1;
        } else {
            let slopes = &workspace.assembly.knob_rows[c / 2][c % 2];
            for (i, (slope, unit)) in slopes.iter().zip(&workspace.units).enumerate() {
                rhs[i * columns + c] = slope * unit / scale.energy;
            }
        }
    }
    let tip = Tip::new(&workspace.poses);
    for i in 0..tip.posed {
        let rate = tip.rate(i) * (workspace.units[i] / scale.energy);
        rhs[i * columns + m..(i + 1) * columns].copy_from_slice(rate.as_slice());
    }
    workspace.solve(&mut rhs, columns);
    let mut compliance = Matrix6::zeros();
    result.tip_jacobian.fill(0.0);
    for (i, row) in rhs.chunks_exact(columns).take(tip.posed).enumerate() {
        let rate = tip.rate(i) * workspace.units[i];
        for (mut twist, value) in result.tip_jacobian.column_iter_mut().zip(&row[..m]) {
            twist.axpy(*value, &rate, 1.0);
        }
        for (mut twist, value) in compliance.column_iter_mut().zip(&row[m..]) {
            twist.axpy(*value, &rate, 1.0);
        }
    }
    result.compliance = compliance;
    let turn = workspace.poses.rotation[workspace.poses.rotation.len() - 1].transpose();
    for (mut body, world) in result.tip_jacobian_body.column_iter_mut().zip(result.tip_jacobian.column_iter())
    {
        body.fixed_rows_mut::<3>(0).copy_from(&(turn * world.fixed_rows::<3>(0)));
        body.fixed_rows_mut::<3>(3).copy_from(&(turn * world.fixed_rows::<3>(3)));
    }
    let mut row = n_u;
    for (r, input) in result.inputs.iter().enumerate() {
        for c in 0..columns {
            let value = if input.is_motion {
                rhs[row * columns + c] * scale.energy / input.freedom.unit(scale.length)
            } else {
                let slopes = workspace.assembly.knob_rows[r / 2][r % 2].iter().zip(&workspace.units);
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
    workspace.right = rhs;
    true
}

impl Freedom {
    /// What motions are divided by in the conditions.
    fn unit(self, length: f64) -> f64 {
        match self {
            Self::PushPull => length,
            Self::Rotation => 1.0,
        }
    }
}

impl Sensitivity {
    /// Names the inputs of an equilibrium and makes room for them.
    fn place(&mut self, equilibrium: &Equilibrium) {
        self.inputs.clear();
        for (follower, actuator) in equilibrium.drives.iter().enumerate() {
            for (freedom, drive) in
                [(Freedom::PushPull, actuator.push_pull), (Freedom::Rotation, actuator.rotation)]
            {
                self.inputs.push(Input { tube: follower + 2, freedom, is_motion: drive.is_motion() });
            }
        }
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
struct Tip<'a> {
    shift: &'a [f64],
    spin: &'a [f64],
    /// Unknowns that move it.
    posed: usize,
}

impl<'a> Tip<'a> {
    fn new(poses: &'a Poses) -> Self {
        let start = (poses.rotation.len() - 1) * 3 * poses.posed;
        Self { shift: &poses.shift[start..], spin: &poses.spin[start..], posed: poses.posed }
    }

    fn rate(&self, i: usize) -> Vector6<f64> {
        let (shift, spin) = (column(self.shift, self.posed, i), column(self.spin, self.posed, i));
        Vector6::new(shift.x, shift.y, shift.z, spin.x, spin.y, spin.z)
    }
}

/// Largest scaled step of the unknowns in the differences below: the fifth power of it is rounding.
const SMALL: f64 = 1e-3;

/// Derivatives of any outputs of an equilibrium by its inputs, one column each: the unknowns' derivatives are exact, the outputs
/// are read along them by a fourth-order difference. `None` as for [`sensitivity`].
pub fn outputs_by_inputs(
    robot: &Robot,
    workspace: &mut Workspace,
    equilibrium: &Equilibrium,
    outputs: impl Fn(&Robot, &mut Workspace, &Equilibrium) -> Vec<f64>,
) -> Option<DMatrix<f64>> {
    let m = sensitivity(robot, workspace, equilibrium)?.inputs.len();
    let (n_u, n) = (workspace.state.unknowns, workspace.residual.len());
    // What was solved there: scaled steps of the unknowns, by rows.
    let steps = workspace.right.clone();
    let mut slopes: Option<DMatrix<f64>> = None;
    for c in 0..m {
        let step: Vec<f64> = (0..n).map(|i| steps[i * (m + 6) + c]).collect();
        let largest = step[..n_u].iter().fold(f64::MIN_POSITIVE, |most, s| most.max(s.abs()));
        let h = SMALL / largest;
        for (at, share) in Perturbed::SHARES {
            let along = equilibrium.moved(robot, &step, at * h);
            let values = outputs(robot, workspace, &along);
            let slopes = slopes.get_or_insert_with(|| DMatrix::zeros(values.len(), m));
            for (r, value) in values.iter().enumerate() {
                slopes[(r, c)] += share * value / (12.0 * h);
            }
        }
    }
    slopes
}

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

/// Derivatives of any outputs of an equilibrium by one design parameter.
///
/// `outputs` reads what is wanted from an equilibrium, the same number of values each time. `None` as for
/// [`sensitivity`].
pub fn parameter_sensitivity(
    robot: &Robot,
    workspace: &mut Workspace,
    equilibrium: &Equilibrium,
    perturbed: &Perturbed,
    outputs: impl Fn(&Robot, &mut Workspace, &Equilibrium) -> Vec<f64>,
) -> Option<Vec<f64>> {
    let Perturbed { step, robots } = perturbed;
    let step = *step;
    factor(robot, workspace, equilibrium)?;
    let scale = Scale::of(robot);
    let mut slope = vec![0.0; workspace.residual.len()];
    for (moved, &(_, share)) in robots.iter().zip(&Perturbed::SHARES) {
        let system = equilibrium.system(moved);
        workspace.evaluate(&system, &equilibrium.point).ok()?;
        let rescale = Scale::of(moved).energy / scale.energy;
        for (i, (s, r)) in slope.iter_mut().zip(&workspace.residual).enumerate() {
            // Each robot scales its residual by its own stiffness; conditions are not scaled by it.
            let factor = if i < equilibrium.layout.unknowns() { rescale } else { 1.0 };
            *s -= share * factor * r / (12.0 * step);
        }
    }
    // Evaluating leaves the factors as they are.
    workspace.solve(&mut slope, 1);
    let mut total: Vec<f64> = Vec::new();
    for (moved, &(at, share)) in robots.iter().zip(&Perturbed::SHARES) {
        let along = equilibrium.moved(robot, &slope, at * step);
        let values = outputs(moved, workspace, &along);
        total.resize(values.len(), 0.0);
        for (t, value) in total.iter_mut().zip(values) {
            *t += share * value / (12.0 * step);
        }
    }
    Some(total)
}
