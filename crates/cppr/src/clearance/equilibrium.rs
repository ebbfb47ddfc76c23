//! The equilibrium of tubes with clearance.

use super::element::TubeFields;
use super::mesh::{Row, near, remeshed};
use super::state::{Held, Node, State};
use super::system::{Problem, SAME, Settled};
use crate::design::Robot;
use crate::solve::{Equilibrium, Formulation, Solver};
use crate::statics::{DistributedForce, Loads, Station, Thread, Wrench};
use nalgebra::{Matrix3, Vector3};
use std::fmt;

/// Gaps between the tubes, and how finely they are solved for.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Radial gap (m) between every tube and the one inside it, from outside to inside; 0 is none.
    pub gaps: Vec<f64>,
    /// Play below the plate. Without it every tube leaves the plate on the axis and straight.
    pub guide: Option<Guide>,
    /// Elements along the robot, at least 10.
    pub elements: usize,
}

/// A straight guide below the plate in which tube 2 has play. At its lower end the motors hold every tube on the axis and straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guide {
    /// Its length (m).
    pub length: f64,
    /// Radial gap (m) between it and tube 2.
    pub gap: f64,
}

impl Clearance {
    /// The gaps that the radii of a robot leave.
    ///
    /// # Errors
    /// Where the radii of a tube are not known.
    pub fn of(robot: &Robot) -> Result<Self, ClearanceProblem> {
        let each = (1..).zip(robot.gaps());
        let gaps = each
            .map(|(outer, gap)| gap.ok_or(ClearanceProblem::Unknown { outer }))
            .collect::<Result<_, _>>()?;
        Ok(Self { gaps, ..Self::equal(robot, 0.0) })
    }

    /// The same gap (m) between all tubes of a robot.
    #[must_use]
    pub fn equal(robot: &Robot, gap: f64) -> Self {
        Self { gaps: vec![gap; robot.follower_count()], guide: None, elements: ELEMENTS }
    }
}

/// Why clearance cannot be solved for. Tubes are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum ClearanceProblem {
    /// The gap inside a tube is not known, since it or the next is given by its stiffness.
    Unknown {
        /// Number of the outer tube.
        outer: usize,
    },
    /// A gap, or the length of a guide, is not a finite length of at least 0 (m).
    Length(f64),
    /// Not one gap per pair of neighbours.
    Gaps {
        /// How many were given.
        given: usize,
        /// How many there are.
        needed: usize,
    },
    /// Too few elements.
    Elements(usize),
    /// The robot has one tube.
    Alone,
    /// The equilibrium to start from was not found.
    NoStart,
    /// It is not of the consistent formulation.
    Printed,
}

impl fmt::Display for ClearanceProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { outer } => write!(
                f,
                "the gap between tubes {outer} and {} is not known, since one of them is given by its stiffness; give the gap",
                outer + 1
            ),
            Self::Length(value) => {
                write!(f, "a gap or the guide's length is {value} m; give a finite length of at least 0")
            }
            Self::Gaps { given, needed } => {
                write!(
                    f,
                    "{given} gaps are given, but there are {needed} pairs of neighbouring tubes; give one for each"
                )
            }
            Self::Elements(count) => write!(f, "{count} elements are too few; take at least {FEWEST}"),
            Self::Alone => write!(f, "the robot has one tube, and clearance is between two"),
            Self::NoStart => write!(f, "no equilibrium without clearance was found to start from"),
            Self::Printed => write!(f, "clearance is solved for with the consistent formulation alone"),
        }
    }
}

impl std::error::Error for ClearanceProblem {}

/// A stretch along which an inner tube lies on the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Labels of the leader between which it does (m), below 0 in the guide.
    pub from: f64,
    /// The last one.
    pub to: f64,
    /// Where on the wall, at its beginning and its end: the angle of the offset (rad), see [`PairClearance::offset`], from Y towards Z, without jumps of a full turn.
    pub angles: [f64; 2],
    /// Sum of the sizes of the forces between both (N).
    pub force: f64,
}

/// Two neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct PairClearance {
    /// Tubes (index from 0).
    pub outer: usize,
    /// The one inside it.
    pub inner: usize,
    /// Radial gap (m).
    pub gap: f64,
    /// Per section: offset of the inner tube's axis from the outer one's (m), along the axes of the leader's material that are +Y and +Z at rest.
    pub offset: Vec<[f64; 2]>,
    /// Per section: force of the outer tube on the inner one per length of the leader (N/m), along the same axes; the nodal force over the length that the node has.
    pub force: Vec<[f64; 2]>,
    /// Where the inner tube lies on a wall, from the base to the tip.
    pub zones: Vec<Zone>,
}

impl PairClearance {
    /// Mean of the offset's size and of both components (m) over the sections above the plate, whose labels (m) are given, by the trapezoidal rule.
    #[must_use]
    pub fn mean(&self, labels: &[f64]) -> [f64; 3] {
        let (mut sums, mut whole) = ([0.0; 3], 0.0);
        for (at, own) in labels.windows(2).zip(self.offset.windows(2)).filter(|(at, _)| at[0] >= 0.0) {
            let way = at[1] - at[0];
            for [y, z] in own {
                for (sum, value) in sums.iter_mut().zip([y.hypot(*z), *y, *z]) {
                    *sum += 0.5 * way * value;
                }
            }
            whole += way;
        }
        sums.map(|sum| sum / whole)
    }
}

/// A follower.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowerClearance {
    /// Pull Δa (m): its label at the plate, in a guide that at its lower end with the guide's length.
    pub pull: f64,
    /// Force of its motor (N).
    pub tension: f64,
    /// Torque of its motor (N m).
    pub torque: f64,
    /// Per section: its own label (m).
    pub abscissa: Vec<f64>,
    /// Per section: angle between its axis and the leader's (rad).
    pub tilt: Vec<f64>,
}

/// An equilibrium with clearance.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceEquilibrium {
    /// Labels of the leader's sections (m), from the plate to the tip; with a guide from its lower end on, below 0.
    pub labels: Vec<f64>,
    /// Centres of the leader's sections (m); in the guide points of its axis.
    pub centres: Vec<Vector3<f64>>,
    /// Frames of the leader's material; columns: tangent, and the axes that are +Y and +Z at rest.
    pub frames: Vec<Matrix3<f64>>,
    /// Tube 2 first.
    pub followers: Vec<FollowerClearance>,
    /// From outside to inside.
    pub pairs: Vec<PairClearance>,
    /// Potential (J) of tubes, of loads but moments and forces that turn with the robot, and of the motors' forces.
    pub energy: f64,
    /// How far tip (m) and forces (N) moved from half as many elements to these.
    pub error: [f64; 2],
    /// Newton steps.
    pub iterations: usize,
}

impl ClearanceEquilibrium {
    /// Centre of the tip (m).
    #[must_use]
    pub fn tip(&self) -> Vector3<f64> {
        self.centres.last().copied().unwrap_or_default()
    }

    /// Angle between the tip and +X (rad).
    #[must_use]
    pub fn bend(&self) -> f64 {
        self.frames.last().map_or(0.0, |own| own[(1, 0)].hypot(own[(2, 0)]).atan2(own[(0, 0)]))
    }
}

/// Elements by default, and fewest.
const ELEMENTS: usize = 120;
const FEWEST: usize = 10;
/// Part of the gap from a wall up to which a tube lies on it.
const ON_WALL: f64 = 1e-3;

impl Solver {
    /// The equilibrium with clearance next to one without. `Ok(None)` where none is found.
    ///
    /// # Errors
    /// What is not covered, see [`ClearanceProblem`].
    pub fn with_clearance(
        &mut self,
        start: &Equilibrium,
        clearance: &Clearance,
    ) -> Result<Option<ClearanceEquilibrium>, ClearanceProblem> {
        let robot = start.robot().clone();
        check(start, clearance)?;
        let Clearance { gaps, guide, elements } = clearance;
        let length = robot.length();
        let units = [length, robot.bending()];
        let force = units[1] / (length * length);
        let actuators = &start.command().actuators;
        let stretches = start.settings().resolution.stretch > 0;
        let guide = guide.filter(|own| own.length.min(own.gap) > SAME * length);
        let problem = Problem {
            tubes: robot.fields().iter().map(|fields| TubeFields { fields, units, stretches }).collect(),
            gaps: gaps.iter().map(|gap| gap / length).collect(),
            guide: guide.map_or(0.0, |own| own.gap / length),
            held: Held {
                motors: actuators
                    .iter()
                    .map(|own| [own.push_pull.is_motion(), own.rotation.is_motion()])
                    .collect(),
                tight: gaps.iter().map(|gap| *gap <= SAME * length).collect(),
            },
            efforts: actuators
                .iter()
                .map(|own| {
                    [
                        own.push_pull.effort().map(|f| f / force),
                        own.rotation.effort().map(|m| m / (force * length)),
                    ]
                })
                .collect(),
            loads: scaled(&start.command().loads, length, force),
        };
        let below = guide.map_or(0.0, |own| own.length / length);
        let rows = Row::of(self, start, force);
        // Both begin without gaps: on one axis the shape with them is far from an equilibrium.
        let solved = |elements: usize| remeshed(&problem, elements, below, rows.clone());
        let (Some(coarse), Some(fine)) = (solved(elements.div_ceil(2)), solved(*elements)) else {
            return Ok(None);
        };
        let [coarse, fine] = [coarse, fine].map(|found| problem.told(&found, length, force));
        let moved = fine.followers.iter().zip(&coarse.followers);
        let error = [
            (fine.tip() - coarse.tip()).norm(),
            moved.fold(0.0, |most: f64, (a, b)| most.max((a.tension - b.tension).abs())),
        ];
        Ok(Some(ClearanceEquilibrium { error, ..fine }))
    }
}

/// What of a start and of gaps can be told to be wrong before anything is solved.
fn check(start: &Equilibrium, clearance: &Clearance) -> Result<(), ClearanceProblem> {
    let (robot, Clearance { gaps, guide, elements }) = (start.robot(), clearance);
    let needed = robot.follower_count();
    if needed == 0 {
        return Err(ClearanceProblem::Alone);
    }
    if gaps.len() != needed {
        return Err(ClearanceProblem::Gaps { given: gaps.len(), needed });
    }
    let mut lengths = gaps.iter().copied().chain(guide.iter().flat_map(|own| [own.length, own.gap]));
    if let Some(bad) = lengths.find(|own| !(own.is_finite() && *own >= 0.0)) {
        return Err(ClearanceProblem::Length(bad));
    }
    if *elements < FEWEST {
        return Err(ClearanceProblem::Elements(*elements));
    }
    if !start.status().is_equilibrium() {
        return Err(ClearanceProblem::NoStart);
    }
    if start.settings().formulation != Formulation::Consistent {
        return Err(ClearanceProblem::Printed);
    }
    Ok(())
}

/// Loads in units of a length (m) and a force (N); gravity stays a force per mass.
fn scaled(loads: &Loads, length: f64, force: f64) -> Loads {
    let Loads { wrenches, distributed, gravity, threads } = loads;
    let wrench = |own: &Wrench| Wrench {
        force: own.force / force,
        moment: own.moment / (force * length),
        point: own.point / length,
        station: match own.station {
            Station::Tip => Station::Tip,
            Station::Label(label) => Station::Label(label / length),
        },
        ..*own
    };
    let spread = |own: &DistributedForce| DistributedForce {
        force: own.force * (length / force),
        from: own.from / length,
        to: own.to / length,
    };
    let thread = |own: &Thread| Thread {
        tension: own.tension / force,
        pulley: own.pulley / length,
        radius: own.radius / length,
        point: own.point / length,
        ..*own
    };
    Loads {
        wrenches: wrenches.iter().map(wrench).collect(),
        distributed: distributed.iter().map(spread).collect(),
        gravity: gravity.map(|own| own * (length / force)),
        threads: threads.iter().map(thread).collect(),
    }
}

impl Problem<'_> {
    /// What was found, in SI units.
    fn told(&self, found: &Settled, length: f64, force: f64) -> ClearanceEquilibrium {
        let nodes = &found.state.nodes;
        let labels: Vec<f64> = nodes.iter().map(|node| node.labels[0] * length).collect();
        let each = |of: &dyn Fn(&Node) -> f64| nodes.iter().map(of).collect::<Vec<_>>();
        let followers = found.efforts.iter().enumerate().map(|(k, [tension, torque])| FollowerClearance {
            pull: (nodes[0].labels[k + 1] - nodes[0].labels[0]) * length,
            tension: tension * force,
            torque: torque * force * length,
            abscissa: each(&|node| node.labels[k + 1] * length),
            tilt: each(&|node| {
                let axis = node.turns[0].inverse() * node.turns[k + 1] * Vector3::x();
                axis.y.hypot(axis.z).atan2(axis.x)
            }),
        });
        let pairs = (0..self.gaps.len()).map(|k| {
            let pressed: Vec<[f64; 2]> = (0..nodes.len())
                .map(|i| {
                    let play = self.play(&found.state, i, k);
                    play.map_or([0.0; 2], |gap| {
                        let offset = nodes[i].offset(k);
                        [offset.x, offset.y].map(|own| -own / gap * found.walls[i][k] * force)
                    })
                })
                .collect();
            let own_length = |i: usize| {
                let next = labels[(i + 1).min(labels.len() - 1)];
                0.5 * (next - labels[i.saturating_sub(1)])
            };
            PairClearance {
                outer: k,
                inner: k + 1,
                gap: self.gaps[k] * length,
                zones: self.zones(&found.state, k, &labels, &pressed),
                force: pressed.iter().enumerate().map(|(i, own)| own.map(|f| f / own_length(i))).collect(),
                offset: nodes.iter().map(|node| <[f64; 2]>::from(node.offset(k) * length)).collect(),
            }
        });
        ClearanceEquilibrium {
            centres: nodes.iter().map(|node| node.centre * length).collect(),
            frames: nodes.iter().map(|node| node.turns[0].to_rotation_matrix().into_inner()).collect(),
            followers: followers.collect(),
            pairs: pairs.collect(),
            energy: found.energy * force * length,
            error: [f64::NAN; 2],
            iterations: found.iterations,
            labels,
        }
    }

    /// Where the inner tube of a pair lies on a wall, with the nodal forces (N) at the labels (m).
    fn zones(&self, state: &State, follower: usize, labels: &[f64], pressed: &[[f64; 2]]) -> Vec<Zone> {
        let mut zones: Vec<Zone> = Vec::new();
        let mut touched = None;
        for (i, (label, [y, z])) in labels.iter().zip(pressed).enumerate() {
            let offset = state.nodes[i].offset(follower);
            let gap = self.play(state, i, follower);
            let touches = gap.is_some_and(|gap| offset.norm() > gap * (1.0 - ON_WALL)).then_some(offset);
            if let Some(offset) = touches {
                let (angle, size) = (offset.y.atan2(offset.x), y.hypot(*z));
                match zones.last_mut() {
                    Some(zone) if touched.is_some_and(|before| offset.dot(&before) > 0.0) => {
                        zone.to = *label;
                        zone.angles[1] = near(angle, zone.angles[1]);
                        zone.force += size;
                    }
                    _ => zones.push(Zone { from: *label, to: *label, angles: [angle; 2], force: size }),
                }
            }
            touched = touches;
        }
        zones
    }
}
