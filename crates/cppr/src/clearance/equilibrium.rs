//! The equilibrium of tubes with clearance.

use super::element::TubeFields;
use super::mesh::{Row, about, near, remeshed};
use super::state::{Node, State};
use super::system::{Motor, Play, Problem, SAME, Settled};
use crate::bundle::Shaft;
use crate::bundle::solve::{BundleEquilibrium, BundleSolver, TubeEffort};
use crate::design::Robot;
use crate::solve::{Drive, Equilibrium, Formulation, Solver};
use crate::statics::{DistributedForce, Loads, Station, Thread, Wrench};
use nalgebra::{Matrix3, Vector2, Vector3};
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
        Self::known(&robot.gaps())
    }

    /// Gaps (m) of [`Robot::gaps`] or [`BundleDesign::gaps`](crate::bundle::BundleDesign::gaps).
    ///
    /// # Errors
    /// Where one of them is not known.
    pub fn known(gaps: &[Option<f64>]) -> Result<Self, ClearanceProblem> {
        let each = (1..).zip(gaps);
        let gaps = each.map(|(outer, gap)| gap.ok_or(ClearanceProblem::Unknown { outer }));
        Ok(Self::between(gaps.collect::<Result<_, _>>()?))
    }

    /// Given gaps (m) between neighbours, from outside to inside.
    #[must_use]
    pub fn between(gaps: Vec<f64>) -> Self {
        Self { gaps, guide: None, elements: ELEMENTS }
    }

    /// The same gap (m) between all tubes of a robot.
    #[must_use]
    pub fn equal(robot: &Robot, gap: f64) -> Self {
        Self::between(vec![gap; robot.follower_count()])
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
    /// The metal of a tube is not linear, or its teeth meet.
    Nonlinear {
        /// Number of the tube.
        tube: usize,
    },
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
            Self::Nonlinear { tube } => write!(
                f,
                "clearance is solved for in linear tubes alone, and the metal of tube {tube} is not, or its teeth may meet"
            ),
        }
    }
}

impl std::error::Error for ClearanceProblem {}

/// A stretch along which an inner tube lies on the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Between which sections it does: their [labels](ClearanceEquilibrium::labels) (m).
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
    /// Per section: offset of the inner tube's axis from the outer one's (m), along the second and third axis of its [frame](ClearanceEquilibrium::frames); NaN where they are no neighbours.
    pub offset: Vec<[f64; 2]>,
    /// Per section: force of the outer tube on the inner one per length of the labels (N/m), along the same axes; the nodal force over the length that the node has.
    pub force: Vec<[f64; 2]>,
    /// Where the inner tube lies on a wall, from the base to the tip.
    pub zones: Vec<Zone>,
}

impl PairClearance {
    /// Mean of the offset's size and of both components (m) over those of the given sections above the plate at which both are neighbours, by the trapezoidal rule.
    #[must_use]
    pub fn mean(&self, of: &ClearanceEquilibrium) -> [f64; 3] {
        let (mut sums, mut whole) = ([0.0; 3], 0.0);
        let each = of.labels.windows(2).zip(self.offset.windows(2)).skip(of.guided);
        for (at, own) in each.filter(|(_, own)| own.iter().flatten().all(|own| own.is_finite())) {
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
    /// Pull Δa (m): its label at the plate, in a guide that at its lower end with the guide's length. A shaft gives way besides.
    pub pull: f64,
    /// Force of its motor (N).
    pub tension: f64,
    /// Torque of its motor (N m).
    pub torque: f64,
    /// Per section: its own label (m); NaN where it is not.
    pub abscissa: Vec<f64>,
    /// Per section: angle between its axis and that of the outermost tube (rad); NaN where it is not.
    pub tilt: Vec<f64>,
}

/// An equilibrium with clearance.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceEquilibrium {
    /// Sections: labels of tube 1 (m), from the plate to its tip; beyond it those of the outermost tube that goes on, shifted, and in a guide from its lower end on its length.
    pub labels: Vec<f64>,
    /// How many sections lie below the plate, in the guide.
    pub guided: usize,
    /// Centres of the outermost tube (m); in the guide points of its axis.
    pub centres: Vec<Vector3<f64>>,
    /// Frames of the outermost tube's material; columns: tangent, and the axes that are +Y and +Z where it is straight and not turned.
    pub frames: Vec<Matrix3<f64>>,
    /// Motors of tube 1.
    pub leader: TubeEffort,
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
/// Part of the gap that is rounding.
const ROUNDING: f64 = 1e-9;

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
        if !start.status().is_equilibrium() {
            return Err(ClearanceProblem::NoStart);
        }
        if start.settings().formulation != Formulation::Consistent {
            return Err(ClearanceProblem::Printed);
        }
        check(start.robot().tube_count(), clearance)?;
        let Some(own) = self.integrated(start) else { return Ok(None) };
        own.solver().with_clearance(&own.equilibrium, clearance)
    }
}

impl BundleSolver<'_> {
    /// The equilibrium with clearance next to one without. `Ok(None)` where none is found.
    ///
    /// # Errors
    /// What is not covered, see [`ClearanceProblem`].
    pub fn with_clearance(
        &self,
        start: &BundleEquilibrium,
        clearance: &Clearance,
    ) -> Result<Option<ClearanceEquilibrium>, ClearanceProblem> {
        let bundle = self.bundle();
        let Clearance { gaps, guide, elements } = clearance;
        if !start.converged {
            return Err(ClearanceProblem::NoStart);
        }
        check(bundle.tubes.len(), clearance)?;
        let metal = |tube: usize| bundle.tubes[tube].pieces.iter().any(|piece| piece.metal.is_some());
        if let Some(tube) = (0..bundle.tubes.len()).find(|tube| metal(*tube)) {
            return Err(ClearanceProblem::Nonlinear { tube: tube + 1 });
        }
        let length = bundle.length;
        let units = [length, bundle.bending];
        let force = units[1] / (length * length);
        let guide = guide.filter(|own| own.length.min(own.gap) > SAME * length);
        let lengthening = start.lengthening();
        let tubes = bundle.tubes.iter();
        let command = start.command();
        let problem = Problem {
            tubes: tubes
                .clone()
                .map(|tube| TubeFields { tube, units, stretches: lengthening.stretch })
                .collect(),
            gaps: gaps.iter().map(|gap| gap / length).collect(),
            walls: tubes.clone().map(|tube| tube.wall / length).collect(),
            guide: guide.map_or(0.0, |own| own.gap / length),
            stations: bundle
                .stations
                .iter()
                .map(|own| own.iter().map(|(tube, label)| (*tube, label / length)).collect())
                .collect(),
            give: lengthening.give,
            motors: tubes
                .zip(&command.drives)
                .map(|(tube, own)| {
                    let spring = |of: fn(&Shaft) -> f64| tube.shaft.as_ref().map(of);
                    [
                        Motor::new(own.translation, spring(|own| own.axial), [length, force]),
                        Motor::new(own.rotation, spring(|own| own.torsional), [1.0, force * length]),
                    ]
                })
                .collect(),
            loads: scaled(&command.loads, length, force),
        };
        let below = guide.map_or(0.0, |own| own.length / length);
        let rows = Row::of(self, start, length, force);
        if rows.len() < 2 {
            // All of it was drawn in behind the plate.
            return Ok(None);
        }
        // Both begin without gaps: on one axis the shape with them is far from an equilibrium.
        let solved = |elements: usize| remeshed(&problem, elements, below, &rows);
        let Some(coarse) = solved(elements.div_ceil(2)) else { return Ok(None) };
        let Some(fine) = solved(*elements) else { return Ok(None) };
        let [coarse, fine] = [coarse, fine].map(|found| problem.told(&found, length, force));
        let off = fine.followers.iter().zip(&coarse.followers).map(|(a, b)| a.tension - b.tension);
        let off = off.chain([fine.leader.force - coarse.leader.force]);
        let error = [(fine.tip() - coarse.tip()).norm(), off.fold(0.0, |most: f64, off| most.max(off.abs()))];
        Ok(Some(ClearanceEquilibrium { error, ..fine }))
    }
}

impl Motor {
    /// In units of motion and effort; `spring` is the stiffness (N/m or N m/rad) of what lies between it and the plate.
    fn new(drive: Drive, spring: Option<f64>, [motion, effort]: [f64; 2]) -> Self {
        match (drive, spring) {
            (Drive::Motion(_), None) => Self { holds: true, ..Self::default() },
            (Drive::Motion(to), Some(spring)) => {
                Self { stiffness: spring * motion / effort, motion: to / motion, ..Self::default() }
            }
            (Drive::Effort(given), _) => Self { effort: given / effort, ..Self::default() },
        }
    }
}

/// What of gaps can be told to be wrong before anything is solved.
fn check(tubes: usize, clearance: &Clearance) -> Result<(), ClearanceProblem> {
    let Clearance { gaps, guide, elements } = clearance;
    if tubes < 2 {
        return Err(ClearanceProblem::Alone);
    }
    if gaps.len() != tubes - 1 {
        return Err(ClearanceProblem::Gaps { given: gaps.len(), needed: tubes - 1 });
    }
    let mut lengths = gaps.iter().copied().chain(guide.iter().flat_map(|own| [own.length, own.gap]));
    if let Some(bad) = lengths.find(|own| !(own.is_finite() && *own >= 0.0)) {
        return Err(ClearanceProblem::Length(bad));
    }
    if *elements < FEWEST {
        return Err(ClearanceProblem::Elements(*elements));
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
        let State { nodes, guided, .. } = &found.state;
        let start = &nodes[*guided];
        let mut labels: Vec<f64> =
            nodes[..=*guided].iter().map(|node| (start.labels[0] + node.centre.x) * length).collect();
        for element in *guided..found.state.spans.len() {
            labels.push(labels[element] + found.state.advance(element) * length);
        }
        let each = |tube: usize, of: &dyn Fn(&Node) -> f64| {
            let there = nodes.iter().enumerate();
            let one =
                |(number, node)| if found.state.tubes(number).contains(&tube) { of(node) } else { f64::NAN };
            there.map(one).collect::<Vec<_>>()
        };
        let followers =
            found.efforts.iter().enumerate().skip(1).map(|(k, [tension, torque])| FollowerClearance {
                pull: (nodes[0].labels[k] - nodes[0].centre.x) * length,
                tension: tension * force,
                torque: torque * force * length,
                abscissa: each(k, &|node| node.labels[k] * length),
                tilt: each(k, &|node| {
                    let axis = node.turns[node.frame].inverse() * node.turns[k] * Vector3::x();
                    axis.y.hypot(axis.z).atan2(axis.x)
                }),
            });
        let mut neighbours: Vec<[usize; 2]> = (0..nodes.len()).flat_map(|i| found.state.pairs(i)).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        let plays = self.plays(&found.state);
        let pairs = neighbours.into_iter().map(|pair| {
            let apart = |i: usize| !found.state.pairs(i).any(|own| own == pair);
            let mut pressed: Vec<[f64; 2]> =
                (0..nodes.len()).map(|i| if apart(i) { [f64::NAN; 2] } else { [0.0; 2] }).collect();
            for play in plays.iter().filter(|play| play.pair == pair) {
                let offset = nodes[play.node].offset(pair);
                let wall = found.walls[play.node][pair[1]];
                pressed[play.node] = [offset.x, offset.y].map(|own| -own / play.gap * wall * force);
            }
            let own_length = |i: usize| {
                let next = labels[(i + 1).min(labels.len() - 1)];
                0.5 * (next - labels[i.saturating_sub(1)])
            };
            let offset = |i: usize| <[f64; 2]>::from(nodes[i].offset(pair) * length);
            PairClearance {
                outer: pair[0],
                inner: pair[1],
                gap: self.gap(pair) * length,
                zones: zones(found, &plays, pair, &labels, &pressed),
                force: pressed.iter().enumerate().map(|(i, own)| own.map(|f| f / own_length(i))).collect(),
                offset: (0..nodes.len()).map(|i| if apart(i) { [f64::NAN; 2] } else { offset(i) }).collect(),
            }
        });
        let [pulls, turns] = found.efforts[0];
        ClearanceEquilibrium {
            centres: nodes.iter().map(|node| node.centre * length).collect(),
            frames: nodes
                .iter()
                .map(|node| node.turns[node.frame].to_rotation_matrix().into_inner())
                .collect(),
            leader: TubeEffort {
                label: start.labels[0] * length,
                rotation: about(&start.turns[0]),
                force: pulls * force,
                torque: turns * force * length,
            },
            followers: followers.collect(),
            pairs: pairs.collect(),
            energy: found.energy * force * length,
            error: [f64::NAN; 2],
            iterations: found.iterations,
            guided: *guided,
            labels,
        }
    }
}

/// Where the inner tube of a pair lies on a wall, with the nodal forces (N) at the labels (m).
fn zones(
    found: &Settled,
    plays: &[Play],
    pair: [usize; 2],
    labels: &[f64],
    pressed: &[[f64; 2]],
) -> Vec<Zone> {
    let mut zones: Vec<Zone> = Vec::new();
    let mut touched: Option<(usize, Vector2<f64>)> = None;
    for play in plays.iter().filter(|play| play.pair == pair) {
        let (i, offset) = (play.node, found.state.nodes[play.node].offset(pair));
        if offset.norm() <= play.gap * (1.0 - ON_WALL) {
            continue;
        }
        // What is rounding of a plane makes no half turn.
        let [y, z] = [offset.x, offset.y].map(|own| if own.abs() < ROUNDING * play.gap { 0.0 } else { own });
        let (angle, label) = (z.atan2(y), labels[i]);
        let size = pressed[i][0].hypot(pressed[i][1]);
        match zones.last_mut() {
            Some(zone) if touched.is_some_and(|(at, before)| at + 1 == i && offset.dot(&before) > 0.0) => {
                zone.to = label;
                zone.angles[1] = near(angle, zone.angles[1]);
                zone.force += size;
            }
            _ => zones.push(Zone { from: label, to: label, angles: [angle; 2], force: size }),
        }
        touched = Some((i, offset));
    }
    zones
}
