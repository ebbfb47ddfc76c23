//! Derivatives of an equilibrium, from one factorisation of its tangent.
//!
//! The conditions r(y; p) = 0 of `solve::newton` hold for every input p, so that dy/dp = −(∂r/∂y)⁻¹ ∂r/∂p. Motions,
//! efforts and loads enter r linearly and are differentiated exactly; design parameters enter through the
//! material fields and are differentiated at fixed y by a fourth-order difference of r.

use crate::design::Robot;
use crate::kinematics::pose::column;
use crate::solve::newton::{Scale, Workspace};
use crate::solve::{Drive, Equilibrium};
use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};

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
#[derive(Clone, Debug, PartialEq)]
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
    workspace.poses.differentiate(&equilibrium.layout, &workspace.state, false);
    let n = workspace.residual.len();
    workspace.lu.factor(&workspace.matrix, n).ok()
}

/// Jacobians and compliance. `None` where there is no equilibrium or its tangent is singular (at a fold).
#[must_use]
pub fn sensitivity(
    robot: &Robot,
    workspace: &mut Workspace,
    equilibrium: &Equilibrium,
) -> Option<Sensitivity> {
    factor(robot, workspace, equilibrium)?;
    let readout = Readout::new(robot, workspace, equilibrium);
    let (n_u, n, m) = (readout.unknowns, workspace.residual.len(), readout.inputs.len());
    // −∂r/∂p for all inputs and the six components of a tip wrench.
    let columns = m + 6;
    let mut rhs = vec![0.0; n * columns];
    for (c, place) in readout.places.iter().enumerate() {
        match *place {
            Place::Row { row, unit } => rhs[row * columns + c] = -1.0 / unit,
            Place::Knob { follower, which } => {
                for i in 0..n_u {
                    let slope = workspace.assembly.knob_rows[follower][which][i];
                    rhs[i * columns + c] = slope * workspace.units[i] / readout.energy;
                }
            }
        }
    }
    for i in 0..n_u {
        let twist = readout.tip_rate(workspace, i);
        for axis in 0..6 {
            rhs[i * columns + m + axis] = twist[axis] * workspace.units[i] / readout.energy;
        }
    }
    workspace.lu.solve(&mut rhs, columns);
    let mut twists = DMatrix::zeros(6, columns);
    let mut responses = DMatrix::zeros(m, columns);
    for c in 0..columns {
        let step: Vec<f64> = (0..n).map(|i| rhs[i * columns + c]).collect();
        twists.set_column(c, &readout.twist(workspace, &step));
        for (r, value) in readout.responses(workspace, &step).into_iter().enumerate() {
            responses[(r, c)] = value;
        }
    }
    let tip_jacobian = twists.columns(0, m).into_owned();
    let last = workspace.poses.rotation.len() - 1;
    let turn = workspace.poses.rotation[last].transpose();
    let mut tip_jacobian_body = tip_jacobian.clone();
    for mut column in tip_jacobian_body.column_iter_mut() {
        let shift = turn * column.fixed_rows::<3>(0);
        let spin = turn * column.fixed_rows::<3>(3);
        column.fixed_rows_mut::<3>(0).copy_from(&shift);
        column.fixed_rows_mut::<3>(3).copy_from(&spin);
    }
    Some(Sensitivity {
        compliance: twists.fixed_columns::<6>(m).fixed_rows::<6>(0).into_owned(),
        response_by_wrench: responses.columns(m, 6).into_owned(),
        response: responses.columns(0, m).into_owned(),
        inputs: readout.inputs,
        tip_jacobian,
        tip_jacobian_body,
    })
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
    let lu = workspace.lu.clone();
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
    lu.solve(&mut slope, 1);
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

/// Where an input enters the conditions.
enum Place {
    /// A prescribed motion: its own row, divided by `unit`.
    Row { row: usize, unit: f64 },
    /// A prescribed effort: the row of its knob.
    Knob { follower: usize, which: usize },
}

/// Reads twists and responses from a step of the unknowns.
struct Readout {
    unknowns: usize,
    energy: f64,
    force: f64,
    inputs: Vec<Input>,
    places: Vec<Place>,
}

impl Readout {
    fn new(robot: &Robot, workspace: &Workspace, equilibrium: &Equilibrium) -> Self {
        let scale = Scale::of(robot);
        let unknowns = workspace.state.unknowns;
        let (mut inputs, mut places, mut row) = (Vec::new(), Vec::new(), unknowns);
        for (follower, actuator) in equilibrium.drives.iter().enumerate() {
            for (which, drive, freedom, unit) in [
                (0, actuator.push_pull, Freedom::PushPull, scale.length),
                (1, actuator.rotation, Freedom::Rotation, 1.0),
            ] {
                let is_motion = matches!(drive, Drive::Motion(_));
                inputs.push(Input { tube: follower + 2, freedom, is_motion });
                if is_motion {
                    places.push(Place::Row { row, unit });
                    row += 1;
                } else {
                    places.push(Place::Knob { follower, which });
                }
            }
        }
        Self { unknowns, energy: scale.energy, force: scale.energy / scale.length, inputs, places }
    }

    /// Tip twist by unknown `i`.
    fn tip_rate(&self, workspace: &Workspace, i: usize) -> Vector6<f64> {
        let last = workspace.poses.rotation.len() - 1;
        let shift: Vector3<f64> = column(&workspace.poses.shift, last, self.unknowns, i);
        let spin = column(&workspace.poses.spin, last, self.unknowns, i);
        Vector6::new(shift.x, shift.y, shift.z, spin.x, spin.y, spin.z)
    }

    /// Tip twist of a scaled step.
    fn twist(&self, workspace: &Workspace, step: &[f64]) -> Vector6<f64> {
        (0..self.unknowns).map(|i| self.tip_rate(workspace, i) * (step[i] * workspace.units[i])).sum()
    }

    /// Change of every input's conjugate in a scaled step.
    fn responses(&self, workspace: &Workspace, step: &[f64]) -> Vec<f64> {
        self.places
            .iter()
            .zip(&self.inputs)
            .map(|(place, input)| match *place {
                Place::Row { row, .. } => {
                    let unit = if input.freedom == Freedom::PushPull { self.force } else { self.energy };
                    step[row] * unit
                }
                Place::Knob { follower, which } => {
                    let row = &workspace.assembly.knob_rows[follower][which];
                    (0..self.unknowns).map(|i| row[i] * step[i] * workspace.units[i]).sum()
                }
            })
            .collect()
    }
}
