//! Runge-Kutta methods: of order 8 with estimates of order 5 and 3 (Dormand and Prince; Hairer, Nørsett and Wanner 1993, II.5), of order 5 (Dormand and
//! Prince 1980) and of order 3 (Bogacki and Shampine 1989).

#![allow(clippy::unreadable_literal)]

use super::order::Order;

/// Weights of stages.
type Weights = &'static [(usize, f64)];

/// One method.
pub(super) struct Method {
    /// Weights of the stages before, stage by stage.
    pub before: &'static [Weights],
    /// Weights of the step.
    pub step: Weights,
    /// Of a method of lower order: weights of the difference of its stages that stands for [`THIRD`] (order 5) or [`SECOND`] (order 3).
    pub monitor: Weights,
}

impl Method {
    /// The one of an order.
    pub fn of(order: Order) -> Self {
        match order {
            Order::Eighth => Self { before: &BEFORE, step: STEP, monitor: &[] },
            Order::Fifth => Self { before: &BEFORE_OF_FIVE, step: STEP_OF_FIVE, monitor: MONITOR_OF_FIVE },
            Order::Third => Self { before: &BEFORE_OF_THREE, step: STEP_OF_THREE, monitor: MONITOR_OF_THREE },
        }
    }
}

/// Stages of the longest.
pub(super) const STAGES: usize = 12;

#[rustfmt::skip]
const BEFORE: [Weights; STAGES] = [
    &[],
    &[(0, 0.05260015195876773)],
    &[(0, 0.0197250569845379), (1, 0.0591751709536137)],
    &[(0, 0.02958758547680685), (2, 0.08876275643042054)],
    &[(0, 0.2413651341592667), (2, -0.8845494793282861), (3, 0.924834003261792)],
    &[(0, 0.037037037037037035), (3, 0.17082860872947386), (4, 0.12546768756682242)],
    &[(0, 0.037109375), (3, 0.17025221101954405), (4, 0.06021653898045596), (5, -0.017578125)],
    &[(0, 0.03709200011850479), (3, 0.17038392571223998), (4, 0.10726203044637328), (5, -0.015319437748624402), (6, 0.008273789163814023)],
    &[(0, 0.6241109587160757), (3, -3.3608926294469414), (4, -0.868219346841726), (5, 27.59209969944671), (6, 20.154067550477894), (7, -43.48988418106996)],
    &[(0, 0.47766253643826434), (3, -2.4881146199716677), (4, -0.590290826836843), (5, 21.230051448181193), (6, 15.279233632882423), (7, -33.28821096898486), (8, -0.020331201708508627)],
    &[(0, -0.9371424300859873), (3, 5.186372428844064), (4, 1.0914373489967295), (5, -8.149787010746927), (6, -18.52006565999696), (7, 22.739487099350505), (8, 2.4936055526796523), (9, -3.0467644718982196)],
    &[(0, 2.273310147516538), (3, -10.53449546673725), (4, -2.0008720582248625), (5, -17.9589318631188), (6, 27.94888452941996), (7, -2.8589982771350235), (8, -8.87285693353063), (9, 12.360567175794303), (10, 0.6433927460157636)],
];

#[rustfmt::skip]
const STEP: Weights = &[(0, 0.054293734116568765), (5, 4.450312892752409), (6, 1.8915178993145003), (7, -5.801203960010585), (8, 0.3111643669578199), (9, -0.1521609496625161), (10, 0.20136540080403034), (11, 0.04471061572777259)];

/// Weights of the difference to the solution of order 5.
#[rustfmt::skip]
pub(super) const FIFTH: Weights = &[(0, 0.01312004499419488), (5, -1.2251564463762044), (6, -0.4957589496572502), (7, 1.6643771824549864), (8, -0.35032884874997366), (9, 0.3341791187130175), (10, 0.08192320648511571), (11, -0.022355307863886294)];

/// Weights of the difference to the solution of order 3.
#[rustfmt::skip]
pub(super) const THIRD: Weights = &[(0, -0.18980075407240762), (5, 4.450312892752409), (6, 1.8915178993145003), (7, -5.801203960010585), (8, -0.4226823213237919), (9, -0.1521609496625161), (10, 0.20136540080403034), (11, 0.02265179219836082)];

/// Weights of a second difference.
pub(super) const SECOND: Weights = &[(0, 0.625), (9, -1.5625), (11, 0.9375)];

#[rustfmt::skip]
const BEFORE_OF_FIVE: [Weights; 6] = [
    &[],
    &[(0, 1.0 / 5.0)],
    &[(0, 3.0 / 40.0), (1, 9.0 / 40.0)],
    &[(0, 44.0 / 45.0), (1, -56.0 / 15.0), (2, 32.0 / 9.0)],
    &[(0, 19372.0 / 6561.0), (1, -25360.0 / 2187.0), (2, 64448.0 / 6561.0), (3, -212.0 / 729.0)],
    &[(0, 9017.0 / 3168.0), (1, -355.0 / 33.0), (2, 46732.0 / 5247.0), (3, 49.0 / 176.0), (4, -5103.0 / 18656.0)],
];

#[rustfmt::skip]
const STEP_OF_FIVE: Weights = &[(0, 35.0 / 384.0), (2, 500.0 / 1113.0), (3, 125.0 / 192.0), (4, -2187.0 / 6784.0), (5, 11.0 / 84.0)];

/// What [`THIRD`] makes of stages that vary as the cube of the place.
const MONITOR_OF_FIVE: Weights =
    &[(0, -7.0 / 12.0 * CUBE), (2, 4.0 / 3.0 * CUBE), (3, -7.0 / 4.0 * CUBE), (5, CUBE)];
const CUBE: f64 = 0.02521367521367608 / 0.14;

const BEFORE_OF_THREE: [Weights; 3] = [&[], &[(0, 1.0 / 2.0)], &[(1, 3.0 / 4.0)]];

const STEP_OF_THREE: Weights = &[(0, 2.0 / 9.0), (1, 1.0 / 3.0), (2, 4.0 / 9.0)];

/// What [`SECOND`] makes of stages that vary as the square of the place.
const MONITOR_OF_THREE: Weights = &[(0, 1.0), (1, -3.0), (2, 2.0)];
