//! The equilibrium of tubes with clearance, in the plane.

use super::element::TubeFields;
use super::state::{Beside, Held, Node, Span, State};
use super::system::{Dead, PointLoad, Problem, Settled};
use crate::design::Robot;
use crate::design::fields::Part;
use crate::solve::{Equilibrium, Formulation, Solver};
use crate::statics::{Frame, LoadPart, Station};
use nalgebra::Vector3;
use std::fmt;

/// Gaps between the tubes, and how finely they are solved for. Every tube leaves the plate on the axis and straight.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Radial gap (m) between every tube and the one inside it, from outside to inside; 0 is none.
    pub gaps: Vec<f64>,
    /// Elements along the robot, at least 10.
    pub elements: usize,
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
        Self { gaps: vec![gap; robot.follower_count()], elements: ELEMENTS }
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
    /// A gap is not a finite length of at least 0 (m).
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
    /// The notches bend the robot in space.
    Spatial,
    /// The notches of a tube open to one side and then to the other.
    Flips(usize),
    /// A tube is turned, or the equilibrium left the plane.
    Turned,
    /// A load that does not lie in the plane or has no potential of its place alone.
    Load(LoadPart),
}

impl fmt::Display for ClearanceProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { outer } => write!(
                f,
                "the gap between tubes {outer} and {} is not known, since one of them is given by its stiffness; give the gap",
                outer + 1
            ),
            Self::Length(value) => write!(f, "a gap is {value} m; give a finite length of at least 0"),
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
            Self::Spatial => write!(
                f,
                "clearance is solved for in the plane, and the notches of this robot bend it in space"
            ),
            Self::Flips(tube) => write!(
                f,
                "the notches of tube {tube} open to both sides, and clearance is solved for where they open to one"
            ),
            Self::Turned => {
                write!(f, "clearance is solved for in the plane, and this robot is turned or has left it")
            }
            Self::Load(part) => write!(
                f,
                "clearance is solved for under dead forces and moments in the plane on the leader, and {part} is none"
            ),
        }
    }
}

impl std::error::Error for ClearanceProblem {}

/// A stretch along which an inner tube lies on the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Labels of the leader between which it does (m).
    pub from: f64,
    /// The last one.
    pub to: f64,
    /// On which wall: +1 towards the left of its tangent, +Y at rest, −1 towards −Y.
    pub side: f64,
    /// Force of the outer tube on the inner one (N), towards +Y at rest.
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
    /// Per section: offset of the inner tube's axis from the outer one's, along the normal of the leader's axis that is +Y at rest (m).
    pub offset: Vec<f64>,
    /// Per section: force of the outer tube on the inner one per length of the leader (N/m), along the same normal; the nodal force over the length that the node has.
    pub force: Vec<f64>,
    /// Where the inner tube lies on a wall, from the base to the tip.
    pub zones: Vec<Zone>,
}

impl PairClearance {
    /// Mean over the sections, whose labels (m) are given, of the offset's size and of the offset (m), by the trapezoidal rule.
    #[must_use]
    pub fn mean(&self, labels: &[f64]) -> [f64; 2] {
        let (mut sums, mut whole) = ([0.0; 2], 0.0);
        for (at, own) in labels.windows(2).zip(self.offset.windows(2)) {
            let way = at[1] - at[0];
            sums = [
                sums[0] + 0.5 * way * (own[0].abs() + own[1].abs()),
                sums[1] + 0.5 * way * (own[0] + own[1]),
            ];
            whole += way;
        }
        sums.map(|sum| sum / whole)
    }
}

/// A follower.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowerClearance {
    /// Pull Δa (m): its label at the plate.
    pub pull: f64,
    /// Force of its motor (N).
    pub tension: f64,
    /// Per section: its own label (m).
    pub abscissa: Vec<f64>,
    /// Per section: its angle to the leader (rad).
    pub angle: Vec<f64>,
}

/// An equilibrium with clearance.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceEquilibrium {
    /// Labels of the leader's sections (m), from the plate to the tip.
    pub labels: Vec<f64>,
    /// Centres of the leader's sections (m).
    pub centres: Vec<Vector3<f64>>,
    /// Angles of the leader's sections (rad).
    pub angles: Vec<f64>,
    /// Tube 2 first.
    pub followers: Vec<FollowerClearance>,
    /// From outside to inside.
    pub pairs: Vec<PairClearance>,
    /// Potential of tubes, loads and forces of motors (J).
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

    /// Angle of the tip (rad).
    #[must_use]
    pub fn bend(&self) -> f64 {
        self.angles.last().copied().unwrap_or_default()
    }
}

/// Elements by default, and fewest.
const ELEMENTS: usize = 120;
const FEWEST: usize = 10;
/// Nodes nearer than this part of the length are one.
const SAME: f64 = 1e-7;
/// Sections from which a start is interpolated.
const SECTIONS: usize = 201;
/// Part of the gap from a wall up to which a tube lies on it.
const ON_WALL: f64 = 1e-3;
/// Least part of the usual length that an element beside a moving edge has, and has at first next to the base; meshes that are tried.
const SHORTEST: f64 = 0.1;
const NARROW: f64 = 1e-3;
const MESHES: usize = 8;
/// Distance out of the plane, as a part of the length, and direction cosine that are rounding.
const FLAT: f64 = 1e-7;

/// Where a solve starts: the leader's label, its angle, and the followers' labels.
struct Row {
    label: f64,
    angle: f64,
    abscissae: Vec<f64>,
}

impl Solver {
    /// The equilibrium with clearance next to one without, in the plane. `Ok(None)` where none is found.
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
        let Clearance { gaps, elements } = clearance;
        let length = robot.length();
        let shape = self.shape(start, SECTIONS);
        if shape.sections.iter().any(|section| section.centre.z.abs() > FLAT * length) {
            return Err(ClearanceProblem::Turned);
        }
        let sides = (0..robot.tube_count()).map(|tube| side(&robot, tube)).collect::<Result<Vec<_>, _>>()?;
        let loads = dead(start, robot.bending(), sides[0])?;
        let units = [length, robot.bending()];
        let force = units[1] / (length * length);
        let actuators = &start.command().actuators;
        let (motors, tight): (Vec<bool>, Vec<bool>) = actuators
            .iter()
            .zip(gaps)
            .map(|(own, gap)| (own.push_pull.is_motion(), *gap <= SAME * length))
            .unzip();
        let problem = Problem {
            tubes: robot
                .fields()
                .iter()
                .zip(sides)
                .map(|(fields, side)| TubeFields { fields, side, units })
                .collect(),
            gaps: gaps.iter().map(|gap| gap / length).collect(),
            held: Held { motors: &motors, tight: &tight, stretches: start.settings().resolution.stretch > 0 },
            forces: actuators.iter().map(|own| own.push_pull.effort().map(|f| f / force)).collect(),
            loads,
        };
        let mut angle = 0.0;
        let rows: Vec<Row> = shape
            .sections
            .iter()
            .map(|section| {
                let tangent = section.rotation.column(0);
                let direction = tangent.y.atan2(tangent.x);
                // The turn from the section before, without the jump of a full turn.
                angle += (direction - angle).sin().atan2((direction - angle).cos());
                Row {
                    label: section.label / length,
                    angle,
                    abscissae: section.tubes[1..].iter().map(|own| own.abscissa / length).collect(),
                }
            })
            .collect();
        let tensions: Vec<f64> = start.actuators().iter().map(|own| own.tension / force).collect();
        let solved = |elements: usize, rows: Vec<Row>| remeshed(&problem, elements, rows, &tensions);
        let Some(coarse) = solved(elements.div_ceil(2), rows) else { return Ok(None) };
        let Some(fine) = solved(*elements, coarse.state.rows()) else { return Ok(None) };
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
    let (robot, Clearance { gaps, elements }) = (start.robot(), clearance);
    let needed = robot.follower_count();
    if needed == 0 {
        return Err(ClearanceProblem::Alone);
    }
    if gaps.len() != needed {
        return Err(ClearanceProblem::Gaps { given: gaps.len(), needed });
    }
    if let Some(bad) = gaps.iter().find(|own| !(own.is_finite() && **own >= 0.0)) {
        return Err(ClearanceProblem::Length(*bad));
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
    if !robot.is_planar() {
        return Err(ClearanceProblem::Spatial);
    }
    let turned = start.command().actuators.iter().any(|own| own.rotation.value().abs() > FLAT);
    if turned { Err(ClearanceProblem::Turned) } else { Ok(()) }
}

/// To which side the centroid of a tube lies.
fn side(robot: &Robot, tube: usize) -> Result<f64, ClearanceProblem> {
    let length = robot.length();
    let cosine = |i: u8| robot.fields()[tube].direction(length * f64::from(i) / 16.0, Part::Pattern)[0].cos();
    let first = cosine(8).signum();
    let one = (0..=16).all(|i| cosine(i) * first > 0.0);
    if one { Ok(first) } else { Err(ClearanceProblem::Flips(tube + 1)) }
}

/// The loads of an equilibrium, scaled; `side` is that of the leader's centroid, towards which Y of its sections points.
fn dead(start: &Equilibrium, bending: f64, side: f64) -> Result<Dead, ClearanceProblem> {
    let length = start.robot().length();
    let (force, moment) = (bending / (length * length), bending / length);
    let loads = &start.command().loads;
    let mut dead = Dead::default();
    let refused = |part| Err(ClearanceProblem::Load(part));
    if loads.gravity.is_some() {
        return refused(LoadPart::Gravity);
    }
    if !loads.threads.is_empty() {
        return refused(LoadPart::Thread);
    }
    let in_plane = |v: &Vector3<f64>| v.z.abs() <= 0.0;
    for own in &loads.distributed {
        if !in_plane(&own.force) {
            return refused(LoadPart::Distributed);
        }
        let per_length = force / length;
        dead.distributed.push((
            [own.from / length, own.to / length],
            [own.force.x / per_length, own.force.y / per_length],
        ));
    }
    for own in &loads.wrenches {
        let forced = own.force.norm() > 0.0;
        if !in_plane(&own.force) || own.frame == Frame::Section && forced {
            return refused(LoadPart::Force(own.station));
        }
        if own.moment.x.abs() + own.moment.y.abs() > 0.0 {
            return refused(LoadPart::Moment(own.station));
        }
        if forced && !in_plane(&own.point) {
            return refused(LoadPart::Point(own.station));
        }
        let label = match own.station {
            Station::Tip => 1.0,
            Station::Label(label) => label / length,
        };
        dead.points.push(PointLoad {
            label,
            force: [own.force.x / force, own.force.y / force],
            point: [own.point.x / length, side * own.point.y / length],
            moment: own.moment.z / moment,
        });
    }
    Ok(dead)
}

/// Solves on meshes that end elements where edges stand, until these stand well.
fn remeshed(problem: &Problem, elements: usize, mut rows: Vec<Row>, tensions: &[f64]) -> Option<Settled> {
    for _ in 0..MESHES {
        let found = problem.settle(mesh(problem, elements, &rows, tensions))?;
        let usual = 1.0 / elements as f64;
        let nodes = &found.state.nodes;
        let stands = |place: usize| {
            let pair = &nodes[place..place + 2];
            let moves = pair.iter().any(|node| node.edge.is_some());
            // What an edge near the base or the tip leaves is short.
            let least = if place == 0 || place + 2 == nodes.len() { 0.0 } else { SHORTEST };
            !moves || (least..2.0).contains(&((pair[1].label - pair[0].label) / usual))
        };
        let faced = found.state.spans.iter().zip(found.state.nodes.windows(2)).all(|(span, pair)| {
            span.parts.iter().enumerate().all(|(k, part)| {
                let middle = 0.5 * (pair[0].beside[k].label + pair[1].beside[k].label);
                problem.tubes[k + 1].fields.smooth_at_plate()
                    || middle.abs() < SAME
                    || (*part == Part::Below) == (middle < 0.0)
            })
        });
        if faced && (0..nodes.len() - 1).all(stands) {
            return Some(found);
        }
        rows = found.state.rows();
    }
    None
}

/// Straight tubes on the axis of the leader, at the labels of a start.
fn mesh(problem: &Problem, elements: usize, rows: &[Row], tensions: &[f64]) -> State {
    let mut ends: Vec<(f64, Option<usize>)> = vec![(0.0, None), (1.0, None)];
    let usual = 1.0 / elements as f64;
    for (k, tube) in problem.tubes[1..].iter().enumerate() {
        if tube.fields.smooth_at_plate() {
            continue;
        }
        let first = at(rows, 0.0).1[k];
        // An edge that stands nearer to the plate than this stands at it.
        if first < -NARROW * usual {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if at(rows, middle).1[k] < 0.0 { low = middle } else { high = middle }
            }
            ends.push((low.max(NARROW * usual), Some(k)));
        }
    }
    ends.extend(problem.loads.points.iter().map(|own| (own.label, None)));
    for ([from, to], _) in &problem.loads.distributed {
        ends.extend([(*from, None), (*to, None)]);
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    ends.dedup_by(|a, b| a.0 - b.0 < SAME && a.1.is_none() && b.1.is_none());
    let mut labels: Vec<(f64, Option<usize>)> = Vec::with_capacity(elements + 8);
    for pair in ends.windows(2) {
        let (from, to) = (pair[0], pair[1].0);
        // As many as come near the usual length.
        let wanted = (to - from.0) * elements as f64;
        let count = (1..=elements).find(|count| *count as f64 + 0.5 > wanted).unwrap_or(elements);
        labels.push(from);
        labels.extend((1..count).map(|i| (from.0 + (to - from.0) * i as f64 / count as f64, None)));
    }
    labels.extend(ends.last());
    let node = |&(label, edge): &(f64, Option<usize>)| {
        let (angle, abscissae) = at(rows, label);
        let beside = abscissae
            .iter()
            .enumerate()
            .map(|(k, own)| Beside { label: if edge == Some(k) { 0.0 } else { *own }, ..Beside::default() });
        Node { label, angle, edge, beside: beside.collect() }
    };
    let nodes: Vec<Node> = labels.iter().map(node).collect();
    let spans = nodes.windows(2).map(|pair| {
        let (angle, abscissae) = at(rows, 0.5 * (pair[0].label + pair[1].label));
        let parts = abscissae.iter().map(|own| if *own < 0.0 { Part::Below } else { Part::Pattern });
        Span { angle, stretch: [0.0; 2], tension: tensions.to_vec(), parts: parts.collect() }
    });
    let spans = spans.collect();
    State { nodes, spans }
}

/// Angle and the followers' labels at a label.
fn at(rows: &[Row], label: f64) -> (f64, Vec<f64>) {
    let next = rows.partition_point(|row| row.label < label).clamp(1, rows.len() - 1);
    let (a, b) = (&rows[next - 1], &rows[next]);
    let share = (label - a.label) / (b.label - a.label);
    let mix = |a: f64, b: f64| a + share * (b - a);
    (mix(a.angle, b.angle), a.abscissae.iter().zip(&b.abscissae).map(|(a, b)| mix(*a, *b)).collect())
}

impl State {
    /// What another mesh starts from.
    fn rows(&self) -> Vec<Row> {
        let row = |node: &Node| Row {
            label: node.label,
            angle: node.angle,
            abscissae: node.beside.iter().map(|own| own.label).collect(),
        };
        self.nodes.iter().map(row).collect()
    }
}

impl Problem<'_> {
    /// What was found, in SI units.
    fn told(&self, found: &Settled, length: f64, force: f64) -> ClearanceEquilibrium {
        let nodes = &found.state.nodes;
        let line = self.centreline(&found.state);
        let labels: Vec<f64> = nodes.iter().map(|node| node.label * length).collect();
        let each = |of: &dyn Fn(&Node) -> f64| nodes.iter().map(of).collect::<Vec<_>>();
        let followers = (0..self.gaps.len()).map(|k| FollowerClearance {
            pull: nodes[0].beside[k].label * length,
            tension: found.pull[k] * force,
            abscissa: each(&|node| node.beside[k].label * length),
            angle: each(&|node| node.beside[k].angle),
        });
        let pairs = (0..self.gaps.len()).map(|k| {
            let gap = self.gaps[k] * length;
            let offset: Vec<f64> =
                (0..nodes.len()).map(|i| Self::offset(&found.state, i, k) * length).collect();
            let pressed: Vec<f64> =
                found
                    .walls
                    .iter()
                    .enumerate()
                    .map(|(i, own)| {
                        if self.has_play(&found.state, i, k) { (own[k][1] - own[k][0]) * force } else { 0.0 }
                    })
                    .collect();
            let own_length = |i: usize| {
                let next = labels[(i + 1).min(labels.len() - 1)];
                0.5 * (next - labels[i.saturating_sub(1)])
            };
            PairClearance {
                outer: k,
                inner: k + 1,
                gap,
                zones: zones(&labels, &offset, &pressed, gap),
                force: pressed.iter().enumerate().map(|(i, own)| own / own_length(i)).collect(),
                offset,
            }
        });
        ClearanceEquilibrium {
            centres: line.iter().map(|own| own * length).collect(),
            angles: each(&|node| node.angle),
            followers: followers.collect(),
            pairs: pairs.collect(),
            energy: found.energy * force * length,
            error: [f64::NAN; 2],
            iterations: found.iterations,
            labels,
        }
    }
}

/// Where a tube lies on a wall.
fn zones(labels: &[f64], offset: &[f64], pressed: &[f64], gap: f64) -> Vec<Zone> {
    let mut zones: Vec<Zone> = Vec::new();
    let mut touched = 0.0;
    for ((label, offset), force) in labels.iter().zip(offset).zip(pressed) {
        let side = if gap > 0.0 && offset.abs() > gap * (1.0 - ON_WALL) { offset.signum() } else { 0.0 };
        if side * side > 0.0 {
            match zones.last_mut() {
                Some(zone) if side * touched > 0.0 => {
                    zone.to = *label;
                    zone.force += force;
                }
                _ => zones.push(Zone { from: *label, to: *label, side, force: *force }),
            }
        }
        touched = side;
    }
    zones
}
