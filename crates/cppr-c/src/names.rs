//! What can be prescribed and read, by number. A number is never given a second meaning.

use crate::status::{cppr_code, say};

/// Numbers of an enumeration as C hands them over.
pub(crate) trait Numbered: Copy + 'static {
    /// What one of them is called in messages.
    const KIND: &'static str;
    /// All of them.
    const ALL: &'static [Self];
    fn number(self) -> u32;

    fn of(number: u32) -> Result<Self, cppr_code> {
        let known = Self::ALL.iter().copied().find(|own| own.number() == number);
        let (kind, version) = (Self::KIND, env!("CARGO_PKG_VERSION"));
        known.ok_or_else(|| {
            let text = format_args!("there is no {kind} {number} in version {version} of the library");
            say(cppr_code::BadArgument, text)
        })
    }
}

/// The match does not compile while an enumerator is missing from the list.
macro_rules! numbered {
    ($name:ident, $kind:literal: $($own:ident),*) => {
        impl Numbered for $name {
            const KIND: &'static str = $kind;
            const ALL: &'static [Self] = &[$(Self::$own),*];

            fn number(self) -> u32 {
                match self {
                    $(Self::$own => Self::$own as u32),*
                }
            }
        }
    };
}

/// What can be prescribed by one number. Pull is positive, push negative; rotations are right-handed about +X, the
/// insertion axis. An actuator takes either motion or effort in each of its two degrees of freedom: the one given last counts.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_input {
    /// Translation of a tube (m).
    Pull = 1,
    /// Rotation of a tube (rad).
    Rotate = 2,
    /// Force that pulls a tube (N).
    Tension = 3,
    /// Torque that turns a tube (N m).
    Torque = 4,
    /// Dead force on the centre of the tip section along X of the base frame (N); tube 0.
    TipForceX = 5,
    /// The same along Y.
    TipForceY = 6,
    /// The same along Z.
    TipForceZ = 7,
    /// Dead moment on the tip about X of the base frame (N m); tube 0.
    TipMomentX = 8,
    /// The same about Y.
    TipMomentY = 9,
    /// The same about Z.
    TipMomentZ = 10,
}

numbered!(cppr_input, "input": Pull, Rotate, Tension, Torque, TipForceX, TipForceY, TipForceZ, TipMomentX, TipMomentY, TipMomentZ);

/// What can be read of an equilibrium. n is the number of tubes; tube k stands at place k − 1 of n, its translation at
/// place 2 (k − 1) and its rotation at 2 (k − 1) + 1 of 2 n. Places of a tube without actuator are NaN. Matrices go row by row.
/// Twists are the translation of the tip section's centre (m) and its rotation (rad), wrenches a force (N) and the moment about that
/// centre (N m).
///
/// A robot of parts and joints has no evaluations, load steps, residual, elastic energy and margin: CPPR_CODE_NO_VALUE.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_value {
    /// 0 stable, 1 unstable, 2 no equilibrium: as cppr_code; 1 number.
    Status = 1,
    /// Greatest fraction of the command at which an equilibrium was found; 1 number.
    Fraction = 2,
    /// Newton steps; 1 number.
    Iterations = 3,
    /// Residual evaluations; 1 number.
    Evaluations = 4,
    /// Load steps after the first attempt failed; 1 number.
    LoadSteps = 5,
    /// Largest scaled residual; 1 number.
    Residual = 6,
    /// Elastic energy of all tubes (J); 1 number.
    ElasticEnergy = 7,
    /// Angle by which the centreline turns in all (rad); 1 number.
    TotalBend = 8,
    /// Margin to instability: 1 at rest, 0 where the robot snaps; 1 number. Allocates.
    Margin = 9,
    /// Centre of the tip section in the base frame (m); 3.
    TipPosition = 10,
    /// Rotation of the tip section in the base frame, columns tangent, centroid's direction, normal; 3 × 3.
    TipRotation = 11,
    /// Translation of every tube (m), pull positive; n.
    Pull = 12,
    /// Rotation of every tube (rad); n.
    Rotation = 13,
    /// Force on every tube (N), pull positive; n.
    Tension = 14,
    /// Torque on every tube (N m); n.
    Torque = 15,
    /// Twist of the tip in the base frame by what is prescribed of every tube; 6 × 2 n.
    Jacobian = 16,
    /// The same in the frame of the tip section; 6 × 2 n.
    JacobianBody = 17,
    /// The conjugate of what is prescribed (effort where that is motion, motion where it is effort) by what is prescribed; 2 n × 2 n.
    Response = 18,
    /// Twist of the tip by a dead wrench on it, both in the base frame; 6 × 6.
    Compliance = 19,
    /// The conjugate of what is prescribed by a dead wrench on the tip; 2 n × 6.
    ResponseByWrench = 20,
    /// What the modes leave out, against the same robot integrated without them: error of the tip (m), greatest error of a force (N) and of a torque
    /// (N m) of the actuators; 3. Not there in the printed formulation and for relative rotations. Allocates, and takes milliseconds. Of a robot of
    /// parts and joints, which has no modes: how far tip and forces move when every step of the integration is halved; NaN for the torque.
    Error = 21,
    /// Greatest label at which fields can be read (m): the rest length, or for a robot of parts and joints the length of its centreline; 1 number.
    Length = 22,
}

numbered!(cppr_value, "value": Status, Fraction, Iterations, Evaluations, LoadSteps, Residual, ElasticEnergy, TotalBend, Margin, TipPosition,
    TipRotation, Pull, Rotation, Tension, Torque, Jacobian, JacobianBody, Response, Compliance, ResponseByWrench, Error, Length);

/// What can be read along the robot. n is the number of tubes, the outermost (tube 1, the leader) first.
///
/// A robot of parts and joints has centre, rotation (of the outermost tube that is there), abscissa and centroid, NaN for a tube that has not begun or has
/// ended. They are interpolated between sections a thousandth of the length apart.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_field {
    /// Centre of the section in the base frame (m); 3 numbers per section.
    Centre = 1,
    /// Rotation of the leader's section in the base frame, row by row; 3 × 3.
    Rotation = 2,
    /// Curvature of the leader in its section's frame (1/m); 3.
    Curvature = 3,
    /// Rest abscissa of the section of each tube that lies here (m); n.
    Abscissa = 4,
    /// Centroid of each tube in the base frame (m); n × 3.
    Centroid = 5,
    /// Torque about the centre and bending moments about the section's second and third axis of each tube (N m); n × 3.
    Moment = 6,
    /// Axial force, tension positive, and shear forces along the section's second and third axis of each tube (N); n × 3.
    Force = 7,
    /// Elastic energy of all tubes per length (J/m); 1.
    EnergyDensity = 8,
}

numbered!(cppr_field, "field": Centre, Rotation, Curvature, Abscissa, Centroid, Moment, Force, EnergyDensity);

/// How to solve. The numbers of a flag are 0 and 1. A robot of parts and joints has CPPR_OPTION_STRETCH and CPPR_OPTION_LOOP_TOLERANCE alone, and takes the defaults of the
/// others, and any accuracy: nothing there has modes.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_option {
    /// Flag: nothing leaves the X-Y plane; faster. Default 0.
    Planar = 1,
    /// Flag: the tubes stretch. Default 0.
    Stretch = 2,
    /// Modes and nodes multiplied: a whole number from 1 to 8, or 0.375, 0.5 or 0.75 for loops that need no more, see cppr_solver_fewest_modes(). Default 1.
    Refine = 3,
    /// Largest scaled residual at convergence, above 0 and at most 1e-6. Default 1e-11.
    Tolerance = 4,
    /// Newton steps of one attempt, 1 to 100000. Default 40.
    Iterations = 5,
    /// Smallest fraction of the command that load stepping adds, from 1e-12 to 1. Default 1/256.
    SmallestStep = 6,
    /// Flag: the formulation printed in the paper, for comparison only; it allocates. Default 0.
    Printed = 7,
    /// Flag: rotations are relative angles of the tubes at the plate, as in the paper, not those of the motors. Default 0.
    RelativeAngle = 8,
    /// Error of the tip that is accepted, as a part of the length, from 0 to 1. Where the modes exceed it, cppr_solver_solve() takes twice or four times as many,
    /// which takes up to some tens of milliseconds, and cppr_solver_track() goes on with as many; cppr_solve_many() looks at eight poses and takes as many for all. What
    /// is left says CPPR_VALUE_ERROR. Default 0: the modes stay as they are.
    Accuracy = 9,
    /// Error that cppr_solver_track() allows in one step of the integration along a robot of parts and joints, in units of its length, above 0 and at most 1e-4: 1e-6 takes up to half the
    /// time of the default, 1e-8, and leaves the tip within 1e-5 of the length.
    LoopTolerance = 10,
}

numbered!(cppr_option, "option": Planar, Stretch, Refine, Tolerance, Iterations, SmallestStep, Printed, RelativeAngle, Accuracy, LoopTolerance);

/// In which frame the components of a load stay constant.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_frame {
    /// The baseplate's: a dead load.
    Base = 0,
    /// The loaded section's: it turns with the robot.
    Section = 1,
}

numbered!(cppr_frame, "frame": Base, Section);

/// Where a pose of many starts.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_start {
    /// At rest: no pose depends on another.
    Rest = 0,
    /// At the pose before it, where that is less than 0.35 rad of bending or turning away and the tip does not jump, else at rest: several times as fast. A
    /// robot of parts and joints begins at any pose before it that is stable, so that these should be near.
    Neighbour = 1,
}

numbered!(cppr_start, "start": Rest, Neighbour);
