//! The Lagrangian once more, written plainly over dual numbers, against the assembled gradient and Hessian.

use super::assembly::{Assembly, Efforts, RotationMeans, Setting};
use super::load::{DistributedForce, Frame, Loads, Station, Thread, Wrench};
use crate::design::fields::{FieldJets, Fields, Jet, Part};
use crate::design::{BelowPlate, Material, NotchedTube, Outline, Profile, StiffnessTube, Torsion};
use crate::design::{Robot, RobotDesign, TeethStiffness, TubeDesign};
use crate::kinematics::Resolution;
use crate::kinematics::layout::{Cut, Joint, Layout, Layouts};
use crate::kinematics::pose::Poses;
use crate::kinematics::state::{State, part};
use crate::real::Each;
use nalgebra::Vector3;
use std::sync::Arc;

use num_dual::{Dual64, DualNum, HyperDual64};

pub(super) trait Number: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

pub(super) type V<T> = [T; 3];

fn cross<T: Number>(a: V<T>, b: V<T>) -> V<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot<T: Number>(a: V<T>, b: V<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn plus<T: Number>(a: V<T>, b: V<T>, f: T) -> V<T> {
    [a[0] + b[0] * f, a[1] + b[1] * f, a[2] + b[2] * f]
}

fn fixed<T: Number>(v: Vector3<f64>) -> V<T> {
    [T::from(v.x), T::from(v.y), T::from(v.z)]
}

/// v turned by the rotation vector w (Rodrigues).
fn turn<T: Number>(w: V<T>, v: V<T>) -> V<T> {
    let angle = dot(w, w).sqrt();
    let c = cross(w, v);
    plus(plus(v, c, angle.sin() / angle), cross(w, c), (T::one() - angle.cos()) / (angle * angle))
}

/// A field along a generic abscissa from its value and two derivatives.
fn taylor<T: Number>(jet: [f64; 3], x: T) -> T {
    let d = x - T::from(x.re());
    T::from(jet[0]) + d * jet[1] + d * d * (0.5 * jet[2])
}

/// A section: rotation as its three columns, centre.
pub(super) type Pose<T> = (V<V<T>>, V<T>);

/// A node: K, e_1 and per follower |h|, θ, D, m.
type Node<T> = (V<T>, T, Vec<[T; 4]>);

pub(super) struct Primal<T> {
    pub lagrangian: T,
    /// Poses at the elements' ends.
    pub ends: Vec<Pose<T>>,
}

/// 𝓛 with every potential load, at coordinates u.
fn primal<T: Number>(setting: &Setting, efforts: &Efforts, u: &[T]) -> Primal<T> {
    primal_along(setting, efforts, u, None)
}

/// The same for the robot whose fields have moved by p times the given rates, one per tube; directions stay.
#[allow(clippy::too_many_lines)]
pub(super) fn primal_along<T: Number>(
    setting: &Setting,
    efforts: &Efforts,
    u: &[T],
    along: Option<(&[Fields], T)>,
) -> Primal<T> {
    let Setting { robot, layout, rotation_means, .. } = setting;
    let loads = setting.kinds();
    let value = |tube: usize, x: T, part: Part, pick: fn(&FieldJets) -> Jet| {
        let own = taylor(pick(&robot.fields()[tube].jets(x.re(), part)), x);
        along.map_or(own, |(rates, p)| own + p * taylor(pick(&rates[tube].jets(x.re(), part)), x))
    };
    let followers = layout.tubes - 1;
    let label = |joint: Joint| match joint {
        Joint::Fixed(x) => T::from(x),
        Joint::Edge { unknown, .. } => u[unknown],
    };
    let mut total = T::zero();
    let mut joint: Vec<[T; 2]> = vec![[T::from(robot.length()), T::zero()]; followers];
    let mut nodes: Vec<Vec<Node<T>>> = vec![Vec::new(); layout.elements.len()];
    for (e, element) in layout.elements.iter().enumerate().rev() {
        let rule = &layout.rules[element.rule];
        let (a, b) = (label(element.start), label(element.end));
        let length = b - a;
        let field = |i: usize, f: usize| {
            let (first, count) = element.modes[f];
            (0..count).fold(T::zero(), |s, m| s + u[first + m] * rule.legendre[i * rule.n + m])
        };
        let labels: Vec<T> = rule.nodes.iter().map(|&x| a + length * x).collect();
        let phi = |tube: usize, x: T, order: usize| {
            let d = robot.fields()[tube].direction(x.re(), Part::Pattern);
            let third = if order == 0 { d[3] / 6.0 } else { 0.0 };
            let dx = x - T::from(x.re());
            taylor([d[order], d[order + 1], if order < 2 { d[order + 2] } else { 0.0 }], x)
                + dx * dx * dx * third
        };
        let mut own: Vec<Node<T>> = (0..rule.n)
            .map(|i| {
                let stretch = if layout.stretch { field(i, 3 + followers) } else { T::zero() };
                ([field(i, 0) + phi(0, labels[i], 1), field(i, 1), field(i, 2)], stretch, Vec::new())
            })
            .collect();
        for f in 0..followers {
            let change: Vec<T> = (0..rule.n).map(|i| field(i, 3 + f)).collect();
            let angles: Vec<T> = (0..rule.n)
                .map(|i| {
                    let sum = (0..rule.n).fold(T::zero(), |s, j| s + change[j] * rule.to_end[i * rule.n + j]);
                    phi(0, labels[i], 0) - phi(f + 1, labels[i], 0) + std::f64::consts::PI + joint[f][1]
                        - length * sum
                })
                .collect();
            let rate = |i: usize| change[i] + phi(0, labels[i], 1) - phi(f + 1, labels[i], 1);
            let stretch = |i: usize| if layout.stretch { field(i, 4 + followers + f) } else { T::zero() };
            let mut faces = labels.clone();
            let mut h = vec![T::one(); rule.n];
            for _ in 0..60 {
                for i in 0..rule.n {
                    let d1 = value(0, labels[i], Part::Pattern, |j| j.offset);
                    let d = value(f + 1, faces[i], part(element, f + 1), |j| j.offset);
                    let k = own[i].0;
                    h[i] = (T::one()
                        + own[i].1
                        + d1 * k[2]
                        + d * (angles[i].cos() * k[2] + angles[i].sin() * k[1]))
                        / (T::one() + stretch(i));
                }
                for (i, face) in faces.iter_mut().enumerate() {
                    let sum = (0..rule.n).fold(T::zero(), |s, j| s + h[j] * rule.to_end[i * rule.n + j]);
                    *face = joint[f][0] - length * sum;
                }
            }
            for i in 0..rule.n {
                let direction = robot.fields()[f + 1].direction(faces[i].re(), part(element, f + 1));
                let at = |pick: fn(&FieldJets) -> Jet| value(f + 1, faces[i], part(element, f + 1), pick);
                let k = own[i].0;
                let (s, c) = (angles[i].sin(), angles[i].cos());
                let twist =
                    (k[0] - rate(i)) / h[i] - taylor([direction[1], direction[2], direction[3]], faces[i]);
                let (y, z) = ((c * k[1] - s * k[2]) / h[i], (s * k[1] + c * k[2]) / h[i]);
                let mut energy = at(|j| j.torsion) * twist * twist
                    + at(|j| j.bending_y) * y * y
                    + at(|j| j.bending_z) * z * z;
                if layout.stretch {
                    energy += at(|j| j.axial) * stretch(i) * stretch(i);
                }
                total += length * h[i] * energy * (0.5 * rule.weights[i]);
                own[i].2.push([h[i], angles[i], at(|j| j.offset), at(|j| j.mass)]);
            }
            let sum = |v: &dyn Fn(usize) -> T| (0..rule.n).fold(T::zero(), |s, j| s + v(j) * rule.weights[j]);
            joint[f] = [joint[f][0] - length * sum(&|j| h[j]), joint[f][1] - length * sum(&|j| change[j])];
        }
        for i in 0..rule.n {
            let at = |pick: fn(&FieldJets) -> Jet| value(0, labels[i], Part::Pattern, pick);
            let (k, stretch) = (own[i].0, own[i].1);
            let twist = k[0] - phi(0, labels[i], 1);
            let mut energy = at(|j| j.torsion) * twist * twist
                + at(|j| j.bending_y) * k[1] * k[1]
                + at(|j| j.bending_z) * k[2] * k[2];
            if layout.stretch {
                energy += at(|j| j.axial) * stretch * stretch;
            }
            total += length * energy * (0.5 * rule.weights[i]);
        }
        if let Joint::Edge { follower, unknown } = element.start {
            total += joint[follower - 1][0] * efforts.edge[unknown];
        }
        nodes[e] = own;
    }
    for f in 0..followers {
        let phi = |tube: usize| robot.fields()[tube].direction(0.0, Part::Pattern)[0];
        let rotation = match rotation_means {
            RotationMeans::Base => {
                let d = robot.fields()[f + 1].direction(joint[f][0].re(), part(&layout.elements[0], f + 1));
                T::from(phi(f + 1)) - joint[f][1] - taylor([d[0], d[1], d[2]], joint[f][0])
            }
            RotationMeans::RelativeAngle => -joint[f][1],
        };
        total -= joint[f][0] * efforts.tension[f] + rotation * efforts.torque[f];
    }
    // Poses.
    let base = robot.fields()[0].direction(0.0, Part::Pattern)[0];
    let (zero, one) = (T::zero(), T::one());
    let (s, c) = (T::from(base.sin()), T::from(base.cos()));
    let mut frame = [[one, zero, zero], [zero, c, s], [zero, -s, c]];
    let mut start = [zero; 3];
    let mut ends = Vec::new();
    let to_world = |frame: &V<V<T>>, v: V<T>| {
        let mut w = [zero; 3];
        for axis in 0..3 {
            w = plus(w, frame[axis], v[axis]);
        }
        w
    };
    for (e, element) in layout.elements.iter().enumerate() {
        let rule = &layout.rules[element.rule];
        let (n, length) = (rule.n, label(element.end) - label(element.start));
        let mut tangents = Vec::new();
        let mut frames = Vec::new();
        for s in 0..=n {
            let mut alpha = [[zero; 3]; 3];
            for (m, alpha) in alpha.iter_mut().enumerate() {
                for j in 0..n {
                    *alpha = plus(*alpha, nodes[e][j].0, length * rule.magnus[m][s * n + j]);
                }
            }
            let [a1, a2, a3] = alpha;
            let comm = cross(a1, a2);
            let w = plus([a3[0] * 2.0, a3[1] * 2.0, a3[2] * 2.0], comm, -one);
            let p = plus(plus(comm, a1, T::from(20.0)), a3, one);
            let q = plus(a2, cross(a1, w), T::from(1.0 / 60.0));
            let omega = plus(plus(a1, a3, T::from(1.0 / 12.0)), cross(p, q), T::from(1.0 / 240.0));
            let columns: V<V<T>> = std::array::from_fn(|axis| {
                let mut unit = [zero; 3];
                unit[axis] = one;
                turn(omega, unit)
            });
            frame = columns.map(|column| to_world(&frame, column));
            if s < n {
                let x = label(element.start) + length * rule.nodes[s];
                let d1 = value(0, x, Part::Pattern, |j| j.offset);
                let g = one + nodes[e][s].1 + d1 * nodes[e][s].0[2];
                tangents.push(frame[0].map(|t| t * g));
                frames.push(frame);
            }
        }
        for i in 0..=n {
            let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
            let mut centre = start;
            for j in 0..n {
                centre = plus(centre, tangents[j], length * weights[j]);
            }
            if i == n {
                start = centre;
                ends.push((frame, centre));
                continue;
            }
            let share = length * rule.weights[i];
            let x = label(element.start) + length * rule.nodes[i];
            for d in &loads.distributed {
                if (d.from..=d.to).contains(&x.re()) {
                    total -= dot(fixed(d.force), centre) * share;
                }
            }
            if let Some(gravity) = loads.gravity {
                let g: V<T> = fixed(gravity);
                let at = plus(centre, frames[i][1], value(0, x, Part::Pattern, |j| j.offset));
                total -= dot(g, at) * value(0, x, Part::Pattern, |j| j.mass) * share;
                for &[h, angle, offset, mass] in &nodes[e][i].2 {
                    let at = plus(
                        plus(centre, frames[i][1], -offset * angle.cos()),
                        frames[i][2],
                        offset * angle.sin(),
                    );
                    total -= dot(g, at) * mass * h * share;
                }
            }
        }
    }
    for wrench in loads.wrenches.iter().filter(|w| w.frame == Frame::World) {
        let e = match wrench.station {
            Station::Tip => layout.elements.len() - 1,
            Station::Label(x) => {
                layout.elements.iter().position(|e| (label(e.end).re() - x).abs() < 1e-12).unwrap()
            }
        };
        let at = plus(to_world(&ends[e].0, fixed(wrench.point)), ends[e].1, one);
        total -= dot(fixed(wrench.force), at);
    }
    for thread in &loads.threads {
        let (frame, centre) = ends.last().unwrap();
        let at = plus(to_world(frame, fixed(thread.point)), *centre, one);
        let gap = plus(fixed(thread.pulley), at, -one);
        // Only an eyelet has the distance as its potential.
        total += dot(gap, gap).sqrt() * thread.tension;
    }
    Primal { lagrangian: total, ends }
}

fn ramp(low: f64, high: f64) -> Profile {
    Profile::table(&[0.0, 0.04, 0.1, 0.15], &[low, 0.7 * low + 0.3 * high, 0.2 * low + 0.8 * high, high])
        .unwrap()
}

/// Three tubes, everything varying, the third with an uncut part below the plate.
pub(super) fn test_robot() -> Robot {
    let stiff = |offset: [f64; 2], direction: f64, scale: f64| StiffnessTube {
        centroid_offset: ramp(offset[0], offset[1]),
        direction: Profile::table(&[0.0, 0.05, 0.15], &[direction, direction + 0.9, direction + 1.3])
            .unwrap(),
        bending_y: ramp(0.012 * scale, 0.008 * scale),
        bending_z: ramp(0.001 * scale, 0.0016 * scale),
        torsion: ramp(0.004 * scale, 0.003 * scale),
        axial: Some(ramp(9e3, 7e3)),
        mass_per_length: ramp(0.02, 0.03),
        centroid_offset_factor: 1.0,
    };
    let notched = NotchedTube {
        outline: Outline::Round { outer_radius: 1.5e-3, inner_radius: 0.5e-3 },
        depth: Profile::linear(1.9e-3, 1.6e-3),
        direction: Profile::linear(4.0, 4.4),
        pattern: None,
        teeth: TeethStiffness::Flexible,
        contact: false,
        material: Material {
            youngs_modulus: 5e9,
            poissons_ratio: 0.35,
            density: 1240.0,
            allowable_strain: None,
            softening: None,
        },
        torsion: Torsion::Polar,
        below: BelowPlate::Plain,
        centroid_offset_factor: 1.2,
    };
    let tubes = vec![
        TubeDesign::Stiffness(stiff([3e-3, 2.4e-3], 0.3, 1.0)),
        TubeDesign::Stiffness(stiff([1e-3, 1.4e-3], 2.6, 0.6)),
        TubeDesign::Notched(notched),
    ];
    Robot::from_design(RobotDesign { name: "test".into(), length: 0.15, tubes }).unwrap()
}

pub(super) struct Noise(pub u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

pub(super) fn potential_loads() -> Loads {
    let force = Wrench::tip_force(Vector3::new(0.1, -0.3, 0.2));
    Loads {
        wrenches: vec![
            Wrench { point: Vector3::new(2e-3, 4e-3, -1e-3), ..force },
            Wrench { station: Station::Label(0.06), point: Vector3::new(0.0, 3e-3, 1e-3), ..force },
        ],
        distributed: vec![DistributedForce { force: Vector3::new(0.5, 1.5, -1.0), from: 0.06, to: 0.15 }],
        gravity: Some(Vector3::new(3.0, -9.0, 2.0)),
        threads: vec![Thread {
            tension: 0.2,
            pulley: Vector3::new(0.15, 0.03, 0.02),
            radius: 0.0,
            left: true,
            point: Vector3::new(0.0, 2e-3, 0.0),
        }],
    }
}

pub(super) struct Case {
    pub robot: Robot,
    layout: Arc<Layout>,
    loads: Loads,
    pub efforts: Efforts,
    pub u: Vec<f64>,
    units: Vec<f64>,
}

impl Case {
    pub fn new(loads: Loads, stretch: bool, edge: bool, seed: u64) -> Self {
        let robot = test_robot();
        let modes = Resolution {
            twist: 2,
            bending_y: 3,
            bending_z: 3,
            angle: 2,
            stretch: 2 * usize::from(stretch),
            nodes: 5,
        };
        let cuts = loads.cuts().map(Cut::fixed).chain(edge.then(|| Cut::edge(2, 0.012)));
        let layout = Layouts::default().get(3, 0.15, modes, cuts);
        let mut noise = Noise(seed);
        let mut units = vec![4.0; layout.unknowns()];
        for element in layout.elements.iter().filter(|_| stretch) {
            for &(first, count) in &element.modes[5..] {
                units[first..first + count].fill(0.01);
            }
        }
        units[..layout.edges.len()].fill(0.01);
        let mut u: Vec<f64> = units.iter().map(|s| s * noise.next()).collect();
        u[..layout.edges.len()].fill(0.012);
        let edge = vec![0.3; layout.edges.len()];
        let efforts = Efforts { tension: vec![2.0, -1.5], torque: vec![0.01, 0.02], edge };
        Self { robot, layout, loads, efforts, u, units }
    }

    pub fn setting(&self, rotation_means: RotationMeans) -> Setting<'_> {
        Setting { robot: &self.robot, layout: &self.layout, loads: Each::same(&self.loads), rotation_means }
    }

    pub fn assemble(&self, rotation_means: RotationMeans, u: &[f64]) -> Assembly {
        let (mut state, mut poses, mut assembly) = (State::default(), Poses::default(), Assembly::default());
        assert_eq!(state.evaluate(&self.robot, &self.layout, u), 0);
        assert_eq!(state.differentiate(&self.robot, &self.layout, u), 0);
        poses.evaluate(&self.robot, &self.layout, &state);
        poses.differentiate(&self.layout, &state, true);
        let setting = self.setting(rotation_means);
        assembly.residual(&setting, u, &state, &poses, &self.efforts);
        assembly.tangent(&setting, &state, &poses, &self.efforts);
        assembly
    }

    pub fn direction(&self, noise: &mut Noise) -> Vec<f64> {
        self.units.iter().map(|s| s * noise.next()).collect()
    }
}

pub(super) fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn gradient_and_hessian_are_those_of_the_lagrangian() {
    for (seed, (stretch, loaded, edge, rotation_means)) in [
        (false, false, true, RotationMeans::Base),
        (false, true, true, RotationMeans::Base),
        (true, true, true, RotationMeans::RelativeAngle),
        (true, false, true, RotationMeans::Base),
        (false, true, false, RotationMeans::Base),
        (true, false, false, RotationMeans::Base),
    ]
    .into_iter()
    .enumerate()
    {
        let loads = if loaded { potential_loads() } else { Loads::none() };
        let case = Case::new(loads, stretch, edge, seed as u64 + 1);
        let assembly = case.assemble(rotation_means, &case.u);
        let setting = case.setting(rotation_means);
        let n = case.u.len();
        let mut noise = Noise(99);
        for _ in 0..6 {
            let (v, w) = (case.direction(&mut noise), case.direction(&mut noise));
            let dual: Vec<Dual64> = case.u.iter().zip(&v).map(|(u, v)| Dual64::new(*u, *v)).collect();
            let slope = primal(&setting, &case.efforts, &dual).lagrangian.eps;
            let got = inner(&assembly.gradient, &v);
            assert!(slope.abs() > 1e-6, "the test would see nothing");
            assert!((got - slope).abs() < 1e-11 * (slope.abs() + 1.0), "gradient {got} {slope}");
            let hyper: Vec<HyperDual64> = case
                .u
                .iter()
                .zip(v.iter().zip(&w))
                .map(|(u, (v, w))| HyperDual64::new(*u, *v, *w, 0.0))
                .collect();
            let bend = primal(&setting, &case.efforts, &hyper).lagrangian.eps1eps2;
            let row = |i: usize| (0..n).map(|j| assembly.second(i, j) * w[j]).sum::<f64>();
            let got: f64 = (0..n).map(|i| v[i] * row(i)).sum();
            assert!((got - bend).abs() < 1e-10 * (bend.abs() + 1.0), "seed {seed}: Hessian {got} {bend}");
        }
        for i in 0..n {
            for j in 0..=i {
                let along = |k: usize| {
                    HyperDual64::new(case.u[k], f64::from(u8::from(k == i)), f64::from(u8::from(k == j)), 0.0)
                };
                let hyper: Vec<HyperDual64> = (0..n).map(along).collect();
                let bend = primal(&setting, &case.efforts, &hyper).lagrangian.eps1eps2;
                let (got, unit) = (assembly.second(i, j), 1.0 / (case.units[i] * case.units[j]));
                assert!((got - bend).abs() < 1e-10 * unit, "seed {seed}: entry {i}, {j}: {got} {bend}");
            }
        }
    }
}

/// Follower loads, moments and pulleys have no potential: their generalised force is their virtual work, and
/// its derivative is compared with differences.
#[test]
fn loads_without_potential_do_their_virtual_work() {
    let wrench = Wrench {
        force: Vector3::new(0.2, -0.1, 0.3),
        moment: Vector3::new(2e-3, -3e-3, 1e-3),
        frame: Frame::Section,
        station: Station::Label(0.06),
        point: Vector3::new(1e-3, 3e-3, -2e-3),
    };
    let pulley = Thread { radius: 4e-3, left: false, ..potential_loads().threads[0] };
    let all = [
        Loads { wrenches: vec![wrench], ..Loads::none() },
        Loads {
            wrenches: vec![Wrench { frame: Frame::World, station: Station::Tip, ..wrench }],
            ..Loads::none()
        },
        Loads { threads: vec![pulley], ..Loads::none() },
    ];
    for loads in all {
        let case = Case::new(loads.clone(), false, true, 7);
        let assembly = case.assemble(RotationMeans::Base, &case.u);
        let unloaded = Loads::none();
        let free = Setting { loads: Each::same(&unloaded), ..case.setting(RotationMeans::Base) };
        let mut noise = Noise(5);
        for _ in 0..4 {
            let v = case.direction(&mut noise);
            let dual: Vec<Dual64> = case.u.iter().zip(&v).map(|(u, v)| Dual64::new(*u, *v)).collect();
            let primal_free = primal(&free, &case.efforts, &dual);
            let mut expected = primal_free.lagrangian.eps;
            let tip = primal_free.ends.last().unwrap();
            for wrench in &loads.wrenches {
                let (frame, centre) = match wrench.station {
                    Station::Tip => tip,
                    Station::Label(_) => &primal_free.ends[1],
                };
                let column = |axis: usize| Vector3::from(frame[axis].map(|c| c.re));
                let turn = |v: Vector3<f64>| column(0) * v.x + column(1) * v.y + column(2) * v.z;
                let (force, moment) = match wrench.frame {
                    Frame::World => (wrench.force, wrench.moment),
                    Frame::Section => (turn(wrench.force), turn(wrench.moment)),
                };
                // Velocity of the point and, from the columns' velocities, the spin.
                let rate = |axis: usize| Vector3::from(frame[axis].map(|c| c.eps));
                let velocity = Vector3::from(centre.map(|c| c.eps))
                    + rate(0) * wrench.point.x
                    + rate(1) * wrench.point.y
                    + rate(2) * wrench.point.z;
                let spin = (0..3).map(|a| column(a).cross(&rate(a))).sum::<Vector3<f64>>() * 0.5;
                expected -= force.dot(&velocity) + moment.dot(&spin);
            }
            for thread in &loads.threads {
                let (frame, centre) = tip;
                let point = |part: fn(&Dual64) -> f64| {
                    Vector3::from(std::array::from_fn(|i| {
                        part(&centre[i]) + (0..3).map(|a| part(&frame[a][i]) * thread.point[a]).sum::<f64>()
                    }))
                };
                let gap = thread.pulley - point(|d| d.re);
                // The tangent from the point to the pulley leaves at asin(ρ/d) from the line to its centre.
                let angle = gap.y.atan2(gap.x) - (thread.radius / gap.norm()).asin();
                let flat = gap.xy().norm();
                let force = Vector3::new(flat * angle.cos(), flat * angle.sin(), gap.z)
                    * (thread.tension / gap.norm());
                expected -= force.dot(&point(|d| d.eps));
            }
            let got = inner(&assembly.gradient, &v);
            assert!((got - expected).abs() < 1e-11, "{got} {expected}");
            let n = case.u.len();
            let h = 1e-6;
            let at = |sign: f64| {
                let u: Vec<f64> = case.u.iter().zip(&v).map(|(u, v)| u + sign * h * v).collect();
                case.assemble(RotationMeans::Base, &u).gradient
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            for i in 0..n {
                let difference = (ahead[i] - behind[i]) / (2.0 * h);
                let got: f64 = (0..n).map(|j| assembly.second(i, j) * v[j]).sum();
                let unit = 1.0 / case.units[i];
                assert!((got - difference).abs() < 1e-8 * unit, "row {i}: {got} {difference}");
            }
        }
    }
}
