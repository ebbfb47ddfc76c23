//! All fields of an equilibrium at any section: poses, strains, moments and forces of every tube.
//!
//! Curvatures and bending moments follow from the coordinates. Forces are reactions of constraints (the
//! tubes do not stretch or shear) and follow from balance: the axial force of a follower is what is conjugate
//! to its |h|, N_k = a_k + ∂ω_k/∂|h| (in an unloaded guided tube T − ½EIκ²), the leader carries the
//! rest of the section's total force, and the shear force of each tube balances its moment about the
//! centre, dM/dX + g t × Q + m = 0: tubes touch without friction, so that contact acts through the centre.

use crate::design::Robot;
use crate::design::fields::{FieldJets, Part};
use crate::kinematics::TipPose;
use crate::kinematics::follower::{Facing, local};
use crate::kinematics::layout::{Layout, field};
use crate::kinematics::magnus::Magnus;
use crate::kinematics::pose::{curvature, point};
use crate::kinematics::so3;
use crate::kinematics::state::{part, row};
use crate::solve::system::Buffers;
use crate::solve::{Equilibrium, Solver};
use crate::statics::{Loads, energy};
use nalgebra::{Matrix3, Vector3};

/// One tube at one section.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeSection {
    /// Rest abscissa of the tube's section that faces this one: X itself for the leader, x_k for a
    /// follower (m). Negative for a section from below the plate.
    pub abscissa: f64,
    /// Rotation of the section in the base frame; columns: tangent, direction of the centroid, normal to both.
    pub rotation: Matrix3<f64>,
    /// Centroid in the base frame (m).
    pub centroid: Vector3<f64>,
    /// |h|: length of the tube per length of the leader (-).
    pub rate: f64,
    /// Twist rate against rest Δτ (rad/m) and curvatures about the section's second and third axis (1/m).
    pub strain: Vector3<f64>,
    /// Stretch e (-).
    pub stretch: f64,
    /// Torque about the tube's centre and bending moments about the section's second and third axis through
    /// the centroid (N m), acting from the tip's side.
    pub moment: Vector3<f64>,
    /// Axial force, tension positive, and shear forces along the section's second and third axis (N), from the tip's side.
    pub force: Vector3<f64>,
}

/// The robot at one section X of the leader.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Label X: rest abscissa of the leader (m).
    pub label: f64,
    /// The leader's rotation in the base frame.
    pub rotation: Matrix3<f64>,
    /// Centre of the section in the base frame (m).
    pub centre: Vector3<f64>,
    /// The leader's curvature vector K in its own frame, twist of the pattern included (1/m).
    pub curvature: Vector3<f64>,
    /// Follower angles against rest Δθ_k (rad), tube 2 first.
    pub angles: Vec<f64>,
    /// Every tube, the leader first.
    pub tubes: Vec<TubeSection>,
    /// Elastic energy of all tubes per length of the leader (J/m).
    pub energy_density: f64,
}

/// The robot's shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Sections at the labels asked for.
    pub sections: Vec<Section>,
}

impl Solver {
    /// Fields of an equilibrium at the given labels, each in [0, L] (m).
    #[must_use]
    pub fn shape_at(&mut self, equilibrium: &Equilibrium, labels: &[f64]) -> Shape {
        equilibrium.refresh(&mut self.buffers);
        let recovery = Recovery::new(&self.buffers, equilibrium);
        Shape { sections: labels.iter().map(|&x| recovery.section(x)).collect() }
    }

    /// Fields at `count` ≥ 2 equally spaced labels from the baseplate to the tip.
    #[must_use]
    pub fn shape(&mut self, equilibrium: &Equilibrium, count: usize) -> Shape {
        let (last, length) = (count.max(2) - 1, equilibrium.robot.length());
        let labels: Vec<f64> = (0..=last).map(|i| length * i as f64 / last as f64).collect();
        self.shape_at(equilibrium, &labels)
    }

    /// Pose of the tip. After a solve it costs little.
    #[must_use]
    pub fn tip(&mut self, equilibrium: &Equilibrium) -> TipPose {
        equilibrium.refresh(&mut self.buffers);
        self.buffers.poses.tip()
    }
}

/// A point of the leader between the nodes, and the fields there.
struct LeaderPoint {
    label: f64,
    /// Element and its coordinate ξ.
    e: usize,
    x: f64,
    /// The leader's K, stretch and fields.
    k: Vector3<f64>,
    stretch: f64,
    jets: FieldJets,
    rotation: Matrix3<f64>,
    centre: Vector3<f64>,
    /// Lagrange polynomials of the element at ξ, and their integrals from there to its end.
    lagrange: Vec<f64>,
    to_end: Vec<f64>,
}

/// Torque and bending moments of strains.
fn moment(jets: &FieldJets, strain: &Vector3<f64>) -> Vector3<f64> {
    // An axial force and its lever are added where they are known.
    let FieldJets { torsion, bending_y, bending_z, axial: _, offset: _, mass: _, direction: _ } = jets;
    Vector3::new(torsion[0], bending_y[0], bending_z[0]).component_mul(strain)
}

/// Values at the nodes from which forces are interpolated.
struct Recovery<'a> {
    robot: &'a Robot,
    buffers: &'a Buffers,
    layout: &'a Layout,
    coordinates: &'a [f64],
    /// Per node and follower: axial force (N).
    tension: Vec<f64>,
    /// Per node and tube: M about the centre in the leader's frame (N m).
    moment: Vec<Vector3<f64>>,
    /// Per node and tube: distributed moment about the centre in the leader's frame (N).
    distributed: Vec<Vector3<f64>>,
    /// Per node and tube: what of dM/dX + K × M + m = −g t × Q the shear force balances (N).
    unbalanced: Vec<Vector3<f64>>,
    /// Force of all loads beyond each element's end (N), base frame.
    beyond: Vec<Vector3<f64>>,
}

impl<'a> Recovery<'a> {
    fn new(buffers: &'a Buffers, equilibrium: &'a Equilibrium) -> Self {
        let (robot, layout) = (&equilibrium.robot, &*equilibrium.layout);
        let followers = layout.tubes - 1;
        let mut recovery = Self {
            robot,
            buffers,
            layout,
            coordinates: &equilibrium.point.coordinates,
            tension: vec![0.0; layout.nodes * followers],
            moment: vec![Vector3::zeros(); layout.nodes * layout.tubes],
            distributed: vec![Vector3::zeros(); layout.nodes * layout.tubes],
            unbalanced: vec![Vector3::zeros(); layout.nodes * layout.tubes],
            beyond: vec![Vector3::zeros(); layout.elements.len()],
        };
        // Wrenches, distributed forces and threads act on the leader's centreline, by way of the forces at points; gravity acts on every tube.
        let Loads { gravity, wrenches: _, distributed: _, threads: _ } = equilibrium.command.loads;
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                recovery.at_node(e, element.first_node + i, i, rule.weights[i], gravity);
            }
        }
        let mut force = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate().rev() {
            let n = layout.rules[element.rule].n;
            force += recovery.load(e, n);
            recovery.beyond[e] = force;
            force += (0..n).map(|i| recovery.load(e, i)).sum::<Vector3<f64>>();
        }
        recovery.leader_moments(&recovery.leader_tension());
        recovery.balance();
        recovery
    }

    /// Load at a point (N).
    fn load(&self, e: usize, i: usize) -> Vector3<f64> {
        let forces = &self.buffers.assembly.point_force;
        forces.get(point(self.layout, e, i)).copied().unwrap_or_default()
    }

    fn at_node(&mut self, e: usize, node: usize, i: usize, weight: f64, gravity: Option<Vector3<f64>>) {
        let Buffers { state, assembly, poses, .. } = self.buffers;
        let tubes = self.layout.tubes;
        let at = point(self.layout, e, i);
        for f in 0..tubes - 1 {
            let index = node * (tubes - 1) + f;
            let (facing, jets) = (&state.facing[index], &assembly.jets[node * tubes + f + 1]);
            let v = state.variables(node, f);
            let mut tension = assembly.adjoint[index] / weight + energy::by_rate(facing, v[local::EK], jets);
            let along = Vector3::new(0.0, -facing.cos, facing.sin);
            if let Some(gravity) = gravity {
                let body = poses.rotation[at].transpose() * gravity;
                tension -=
                    jets.mass[0] * (gravity.dot(&poses.centre[at]) + jets.offset[0] * body.dot(&along));
                self.distributed[node * tubes + f + 1] =
                    along.cross(&body) * (jets.offset[0] * jets.mass[0] * facing.h);
            }
            if self.layout.stretch {
                tension = jets.axial[0] * v[local::EK];
            }
            self.tension[index] = tension;
            let inverse = 1.0 / facing.h;
            let own = Vector3::new(
                jets.torsion[0] * (facing.a * inverse - jets.direction[1]),
                -jets.bending_y[0] * facing.p * inverse,
                -jets.bending_z[0] * facing.r * inverse,
            );
            let across = Vector3::x().cross(&along);
            self.moment[node * tubes + f + 1] =
                Vector3::x() * own.x + along * own.y + across * (own.z - tension * jets.offset[0]);
        }
        if let Some(gravity) = gravity {
            let body = poses.rotation[at].transpose() * gravity;
            let jets = &assembly.jets[node * tubes];
            self.distributed[node * tubes] = Vector3::y().cross(&body) * (jets.offset[0] * jets.mass[0]);
        }
    }

    /// Axial force of the leader at the nodes: the section's total minus the followers'.
    fn leader_tension(&self) -> Vec<f64> {
        let (layout, state, followers) = (self.layout, &self.buffers.state, self.layout.tubes - 1);
        let mut leader = vec![0.0; layout.nodes];
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let node = element.first_node + i;
                leader[node] = if layout.stretch {
                    self.buffers.assembly.jets[node * layout.tubes].axial[0]
                        * state.local[node * layout.rows() + local::E1]
                } else {
                    let tangent = self.buffers.poses.rotation[point(layout, e, i)].column(0).into_owned();
                    let own: f64 = self.tension[node * followers..(node + 1) * followers].iter().sum();
                    self.total_force(e, &rule.to_end[i * rule.n..]).dot(&tangent) - own
                };
            }
        }
        leader
    }

    fn leader_moments(&mut self, tension: &[f64]) {
        let Buffers { state, assembly, .. } = self.buffers;
        let tubes = self.layout.tubes;
        for (node, &force) in tension.iter().enumerate() {
            let jets = &assembly.jets[node * tubes];
            let v = &state.local[node * self.layout.rows()..];
            self.moment[node * tubes] = Vector3::new(
                jets.torsion[0] * (v[local::KX] - jets.direction[1]),
                jets.bending_y[0] * v[local::KY],
                jets.bending_z[0] * v[local::KZ] - force * jets.offset[0],
            );
        }
    }

    fn balance(&mut self) {
        let (layout, state) = (self.layout, &self.buffers.state);
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (n, length, slopes) = (rule.n, state.lengths[e], rule.differentiation());
            for i in 0..n {
                let node = element.first_node + i;
                let turning = curvature(state, layout, node);
                for tube in 0..layout.tubes {
                    let moment = |j: usize| self.moment[(element.first_node + j) * layout.tubes + tube];
                    let slope: Vector3<f64> = (0..n).map(|j| moment(j) * (slopes[i * n + j] / length)).sum();
                    let at = node * layout.tubes + tube;
                    self.unbalanced[at] = slope + turning.cross(&self.moment[at]) + self.distributed[at];
                }
            }
        }
    }

    /// Force of all loads beyond a point of an element (N), base frame; `to_end` integrates from there to the element's end.
    fn total_force(&self, e: usize, to_end: &[f64]) -> Vector3<f64> {
        let rule = &self.layout.rules[self.layout.elements[e].rule];
        let spread: Vector3<f64> = (0..rule.n).map(|i| self.load(e, i) * (to_end[i] / rule.weights[i])).sum();
        self.beyond[e] + spread
    }

    fn section(&self, label: f64) -> Section {
        let (layout, coordinates) = (self.layout, self.coordinates);
        let followers = layout.tubes - 1;
        let (e, x) = layout.locate(coordinates, label);
        let mut buffer = Vec::new();
        let mut value = |number: usize| layout.field(coordinates, e, x, number, &mut buffer);
        let jets = self.robot.fields()[0].jets(label, Part::Pattern);
        let k = Vector3::new(jets.direction[1] + value(local::KX), value(local::KY), value(local::KZ));
        let stretch = if layout.stretch { value(field::stretch(followers, 0)) } else { 0.0 };
        let (rotation, centre) = self.pose(e, x);
        let rule = &layout.rules[layout.elements[e].rule];
        let (lagrange, to_end) = (rule.lagrange(x), rule.integral(x, 1.0));
        let place = LeaderPoint { label, e, x, k, stretch, jets, rotation, centre, lagrange, to_end };
        let mut section = Section {
            label,
            rotation,
            centre,
            curvature: k,
            angles: Vec::with_capacity(followers),
            tubes: vec![self.leader(&place)],
            energy_density: energy::leader(&jets, &[k.x, k.y, k.z, stretch, label]).0,
        };
        for f in 0..followers {
            let (tube, angle, energy) = self.follower(&place, f);
            section.tubes.push(tube);
            section.angles.push(angle);
            section.energy_density += energy;
        }
        if !layout.stretch {
            // The leader carries what the followers leave of the section's total.
            let carried: f64 = section.tubes[1..].iter().map(|t| t.force.x).sum();
            section.tubes[0].force.x = self.total_force(e, &place.to_end).dot(&rotation.column(0)) - carried;
        }
        for (t, tube) in section.tubes.iter_mut().enumerate() {
            let shear = tube.rotation.transpose() * rotation * self.shear(&place, t);
            (tube.force.y, tube.force.z) = (shear.y, shear.z);
        }
        section
    }

    /// The leader at a place; its axial force where it stretches.
    fn leader(&self, place: &LeaderPoint) -> TubeSection {
        let LeaderPoint { k, jets, rotation, centre, stretch, .. } = place;
        let strain = Vector3::new(k.x - jets.direction[1], k.y, k.z);
        let axial = if self.layout.stretch { jets.axial[0] * stretch } else { 0.0 };
        TubeSection {
            abscissa: place.label,
            rotation: *rotation,
            centroid: centre + rotation.column(1) * jets.offset[0],
            rate: 1.0,
            strain,
            stretch: *stretch,
            moment: moment(jets, &strain),
            force: Vector3::new(axial, 0.0, 0.0),
        }
    }

    /// A follower at a place, its Δθ_k and its energy per length of the leader.
    fn follower(&self, place: &LeaderPoint, f: usize) -> (TubeSection, f64, f64) {
        let (layout, state) = (self.layout, &self.buffers.state);
        let followers = layout.tubes - 1;
        let element = &layout.elements[place.e];
        let rule = &layout.rules[element.rule];
        let (n, length) = (rule.n, state.lengths[place.e]);
        let mut buffer = Vec::new();
        let mut value = |number: usize| layout.field(self.coordinates, place.e, place.x, number, &mut buffer);
        let to_end = &place.to_end;
        let end = state.joints[(place.e + 1) * followers + f];
        let node = |j: usize| element.first_node + j;
        let turn = |j: usize| {
            state.local[node(j) * layout.rows() + row(f, local::DTH)] - state.rest[node(j) * followers + f][1]
        };
        let angle = end[1] - length * (0..n).map(|j| to_end[j] * turn(j)).sum::<f64>();
        let spread: f64 = (0..n).map(|j| to_end[j] * state.facing[node(j) * followers + f].h).sum();
        let abscissa = end[0] - length * spread;
        let resting = self.robot.rest_angle(f + 1, place.label);
        let mut v = [0.0; local::COUNT];
        v[..local::SHARED].copy_from_slice(&[place.k.x, place.k.y, place.k.z, place.stretch, place.label]);
        v[local::TH] = resting[0] + angle;
        v[local::DTH] = resting[1] + value(field::angle(f));
        v[local::FACE] = abscissa;
        v[local::EK] = if layout.stretch { value(field::stretch(followers, f + 1)) } else { 0.0 };
        let jets = self.robot.fields()[f + 1].jets(abscissa, part(element, f + 1));
        let facing = Facing::new(&v, v[local::TH].sin_cos().into(), &place.jets.offset, &jets.offset);
        let rotation = place.rotation * so3::about_x(std::f64::consts::PI - v[local::TH]);
        let strain = Vector3::new(facing.a, -facing.p, -facing.r) / facing.h
            - Vector3::new(jets.direction[1], 0.0, 0.0);
        let tension = (0..n).map(|j| place.lagrange[j] * self.tension[node(j) * followers + f]).sum();
        let tube = TubeSection {
            abscissa,
            rotation,
            centroid: place.centre + rotation.column(1) * jets.offset[0],
            rate: facing.h,
            strain,
            stretch: v[local::EK],
            moment: moment(&jets, &strain),
            force: Vector3::new(tension, 0.0, 0.0),
        };
        (tube, angle, energy::gradient(&facing, v[local::EK], &jets).0)
    }

    /// Shear force of a tube in the leader's frame: Q = v × t / g with v = −(dM/dX + K × M + m).
    fn shear(&self, place: &LeaderPoint, tube: usize) -> Vector3<f64> {
        let (layout, first) = (self.layout, self.layout.elements[place.e].first_node);
        let unbalanced: Vector3<f64> = (place.lagrange.iter().enumerate())
            .map(|(i, share)| self.unbalanced[(first + i) * layout.tubes + tube] * *share)
            .sum();
        let g = 1.0 + place.stretch + place.jets.offset[0] * place.k.z;
        Vector3::x().cross(&unbalanced) / g
    }

    /// Rotation and centre at ξ of an element, by one more Magnus step from the point before it.
    fn pose(&self, e: usize, x: f64) -> (Matrix3<f64>, Vector3<f64>) {
        let (layout, Buffers { state, poses, .. }) = (self.layout, self.buffers);
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length) = (rule.n, state.lengths[e]);
        let step = rule.nodes.iter().position(|&node| node > x).unwrap_or(n);
        let from = if step == 0 { 0.0 } else { rule.nodes[step - 1] };
        let before = poses.before(point(layout, e, step));
        let shares = rule.magnus_weights(from, x);
        let alpha = shares.map(|share| {
            (0..n).map(|j| curvature(state, layout, element.first_node + j) * (length * share[j])).sum()
        });
        let omega = Magnus::new(alpha).omega;
        let rotation = before * so3::exponential(&omega, &so3::coefficients(&omega));
        let weights = rule.integral(0.0, x);
        let start = if e == 0 { Vector3::zeros() } else { poses.centre[point(layout, e, 0) - 1] };
        let sum: Vector3<f64> = (0..n)
            .map(|j| {
                poses.rotation[point(layout, e, j)].column(0)
                    * (poses.stretch[element.first_node + j] * weights[j])
            })
            .sum();
        (rotation, start + sum * length)
    }
}
