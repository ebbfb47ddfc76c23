//! How near every notch is to its limits: strain at the extreme fibre, and teeth that touch.
//!
//! At rest abscissa x of a tube let κ_Y, κ_Z be the curvatures about its section's axes, e its stretch, D the distance of
//! the centroid from the centre (of the section as cut, without the kinematic factor). A fibre at (Y, Z), Y towards the
//! centroid, is strained by
//!
//!   ε(Y, Z) = e − κ_Z (Y − D) + κ_Y Z .
//!
//! The mechanics spreads notches and teeth evenly, so that κ is a mean over a cell: a notch of length ℓ and a tooth of
//! length t. With rigid teeth the notch takes all of it, κ_notch = κ (ℓ + t)/ℓ (York et al. 2015, Swaney et al. 2016); if the
//! teeth bend as much as the notches, κ_notch = κ. The **strain** is the ε of largest magnitude on the kept part Y ≥ α; on the
//! part Y ≤ α that is cut away, ε is the relative change of the gap between two teeth, and −ε the part of the notch's length
//! that bending has taken up: the **closure**, 1 where the teeth touch. For bending in the plane it is κ_notch (ρ̄ + D).

use super::capacity::concentration;
use crate::design::{BelowPlate, NotchedTube, Robot, TubeDesign};
use crate::kinematics::follower::local;
use crate::kinematics::layout::Layout;
use crate::solve::Equilibrium;
use crate::solve::system::Workspace;

/// What the teeth between the notches do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Teeth {
    /// They do not bend: the notches take all bending of their cells. Safe, and what the literature on notched tubes assumes.
    #[default]
    Rigid,
    /// They bend as the notches do, as the spread stiffness has it: the least strain there can be.
    Bending,
}

/// A piece of a tube that is judged by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// A notch, numbered from 1 at the baseplate; a pattern that goes on below the plate counts down from 0.
    Notch(i32),
    /// A section of a tube whose notches are not known one by one, or that has none.
    Section,
    /// A section of the uncut part from below the plate.
    Uncut,
}

/// State of a notch or section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionLimit {
    /// Tube number, 1 is the leader.
    pub tube: usize,
    /// Which piece.
    pub place: Place,
    /// Rest abscissa of its middle on its own tube (m).
    pub abscissa: f64,
    /// Label X of the leader's section that it faces (m).
    pub label: f64,
    /// Mean curvatures κ_Y, κ_Z over the cell about the section's own axes (1/m).
    pub curvature: [f64; 2],
    /// Strain of largest magnitude, tension positive (-).
    pub strain: f64,
    /// What the material may bear, where the design says so (-).
    pub allowable_strain: Option<f64>,
    /// Part of the notch's length that bending has taken up where the teeth are nearest: 1 where they touch, negative where the
    /// whole notch opens. `None` without a notch.
    pub closure: Option<f64>,
    /// Distance that is left between the teeth where they are nearest, along the fibre (m).
    pub gap: Option<f64>,
}

/// What ends the safe use of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The strain reaches what the material may bear.
    Strain,
    /// The teeth of a notch touch.
    Closure,
    /// The equilibrium becomes unstable.
    Stability,
}

/// The nearest limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Governing {
    /// Which.
    pub limit: Limit,
    /// 0 where nothing of it is used, 1 where it is reached.
    pub utilisation: f64,
    /// Where; `None` for the stability of the whole.
    pub section: Option<SectionLimit>,
}

impl SectionLimit {
    /// Strain against the allowable one (-).
    #[must_use]
    pub fn strain_utilisation(&self) -> Option<f64> {
        self.allowable_strain.map(|allowable| self.strain.abs() / allowable)
    }

    /// The greater of strain and closure against their limits.
    #[must_use]
    pub fn governing(&self) -> Option<Governing> {
        let strain = self.strain_utilisation().map(|u| (Limit::Strain, u));
        let closure = self.closure.map(|u| (Limit::Closure, u));
        strain
            .into_iter()
            .chain(closure)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(limit, utilisation)| Governing { limit, utilisation, section: Some(*self) })
    }
}

/// The nearest limit of all sections and, where it is known, of the margin to instability.
#[must_use]
pub fn governing(sections: &[SectionLimit], margin: Option<f64>) -> Option<Governing> {
    let stability =
        margin.map(|margin| Governing { limit: Limit::Stability, utilisation: 1.0 - margin, section: None });
    first_greatest(sections.iter().filter_map(SectionLimit::governing).chain(stability), |g| g.utilisation)
}

/// The greatest by a value, the first of those that rounding alone tells apart.
pub fn first_greatest<T>(items: impl Iterator<Item = T>, value: impl Fn(&T) -> f64) -> Option<T> {
    items.reduce(|best, next| if value(&next) > value(&best) + ROUNDING { next } else { best })
}

/// Utilisations and strains are numbers about 1 and about 0.01: what differs by less does so by rounding.
const ROUNDING: f64 = 1e-9;

/// Sections at which a tube without known notches is judged, less one.
const SPACES: u32 = 32;
/// Sections of an uncut part that has come up from below the plate, less one.
const UNCUT_SPACES: u32 = 4;

/// State of every notch that stands in the robot, tube by tube from the baseplate on. Tubes given by their stiffness have no
/// fibres and are left out; empty where there is no equilibrium.
#[must_use]
pub fn section_limits(
    robot: &Robot,
    workspace: &mut Workspace,
    equilibrium: &Equilibrium,
    teeth: Teeth,
) -> Vec<SectionLimit> {
    let mut sections = Vec::new();
    if !equilibrium.status.is_equilibrium() {
        return sections;
    }
    let system = equilibrium.system(robot);
    // A point that was evaluated once can be evaluated again.
    let _ = workspace.evaluate(&system, &equilibrium.point);
    for (tube, design) in robot.design().tubes.iter().enumerate() {
        let TubeDesign::Notched(design) = design else { continue };
        let fields = Strains { workspace, equilibrium, tube };
        let judge = Judge { tube: tube + 1, design, length: robot.length(), teeth };
        let base = fields.base();
        for (place, abscissa) in places(design, robot.length(), base) {
            let (label, values) = fields.at(abscissa, place == Place::Uncut);
            sections.extend(judge.section(place, abscissa, label, values));
        }
    }
    sections
}

/// Pieces of a tube whose section at the baseplate has rest abscissa `base`, from the baseplate to the tip.
fn places(design: &NotchedTube, length: f64, base: f64) -> Vec<(Place, f64)> {
    let spread = |from: f64, to: f64, spaces: u32, place: Place| {
        (0..=spaces).map(move |i| (place, from + (to - from) * f64::from(i) / f64::from(spaces)))
    };
    let mut list = Vec::new();
    let pushed = base < -1e-9 * length;
    if pushed && design.below == BelowPlate::Plain {
        list.extend(spread(base, 0.0, UNCUT_SPACES, Place::Uncut));
    }
    match &design.pattern {
        Some(pattern) => {
            let middle = |number: i32| (f64::from(number) - 0.5) * pattern.pitch();
            let first = if pushed && design.below == BelowPlate::Continued {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "a follower slides by less than its length"
                )]
                let below = (base / pattern.pitch()).floor() as i32;
                below
            } else {
                1
            };
            let last = i32::try_from(pattern.count).unwrap_or(i32::MAX);
            list.extend(
                (first..=last)
                    .map(|number| (Place::Notch(number), middle(number)))
                    .filter(|(_, x)| *x >= base && *x <= length),
            );
        }
        None => list.extend(spread(base.max(0.0), length, SPACES, Place::Section)),
    }
    list
}

/// One tube and how it is judged.
struct Judge<'a> {
    tube: usize,
    design: &'a NotchedTube,
    length: f64,
    teeth: Teeth,
}

impl Judge<'_> {
    fn section(&self, place: Place, abscissa: f64, label: f64, values: [f64; 3]) -> Option<SectionLimit> {
        let design = self.design;
        let outline = &design.outline;
        let depth = match place {
            Place::Uncut => 0.0,
            _ => design.depth.eval(abscissa.max(0.0), self.length)[0],
        };
        let offset = outline.inertia(depth).ok()?.centroid_offset;
        let notch = match (place, &design.pattern) {
            (Place::Notch(_), Some(pattern)) if depth > 0.0 => Some(pattern),
            _ => None,
        };
        let share = notch.map_or(1.0, |pattern| concentration(pattern, self.teeth));
        let [bend_y, bend_z, stretch] = values.map(|v| share * v);
        // ε = middle + a Y + b Z.
        let (middle, slope) = (stretch + bend_z * offset, [-bend_z, bend_y]);
        let greatest = middle + outline.greatest_kept(depth, slope);
        let least = middle - outline.greatest_kept(depth, slope.map(|s| -s));
        let closure = notch.map(|_| outline.greatest_removed(depth, slope.map(|s| -s)) - middle);
        Some(SectionLimit {
            tube: self.tube,
            place,
            abscissa,
            label,
            curvature: [values[0], values[1]],
            strain: if greatest >= -least { greatest } else { least },
            allowable_strain: design.material.allowable_strain,
            closure,
            gap: closure.zip(notch).map(|(closed, pattern)| pattern.length * (1.0 - closed)),
        })
    }
}

/// Curvatures and stretch of one tube by rest abscissa, from an evaluated workspace.
struct Strains<'a> {
    workspace: &'a Workspace,
    equilibrium: &'a Equilibrium,
    tube: usize,
}

impl Strains<'_> {
    /// Rest abscissae at the ends of an element (m).
    fn ends(&self, e: usize) -> [f64; 2] {
        let layout = &self.equilibrium.layout;
        if self.tube == 0 {
            let element = &layout.elements[e];
            [element.start, element.end].map(|j| Layout::label(j, &self.equilibrium.point.coordinates).0)
        } else {
            let followers = layout.tubes - 1;
            [e, e + 1].map(|joint| self.workspace.state.joints[joint * followers + self.tube - 1][0])
        }
    }

    /// Rest abscissa at the baseplate (m).
    fn base(&self) -> f64 {
        self.ends(0)[0]
    }

    /// Label X that a rest abscissa faces (m), and κ_Y, κ_Z and e there. Between the nodes of an element they are interpolated
    /// by the polynomial through all of them. The curvature jumps where the uncut part ends; `uncut` tells the sides apart.
    fn at(&self, abscissa: f64, uncut: bool) -> (f64, [f64; 3]) {
        let Self { workspace, equilibrium, tube } = *self;
        let (layout, state) = (&equilibrium.layout, &workspace.state);
        let last = layout.elements.len() - 1;
        let holds = |&e: &usize| abscissa < self.ends(e)[1] || (uncut && !layout.elements[e + 1].below[tube]);
        let e = (0..last).find(holds).unwrap_or(last);
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let nodes = || element.first_node..element.first_node + rule.n;
        let [from, to] = self.ends(e);
        let mut x = ((abscissa - from) / (to - from)).clamp(0.0, 1.0);
        let mut shares = rule.lagrange(x);
        if tube > 0 {
            // x_k(ξ) is smooth and nearly linear: Newton's method settles in two or three turns.
            for _ in 0..10 {
                let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
                    nodes().zip(&shares).map(|(node, share)| share * value(node)).sum()
                };
                let face = sum(&|node| state.variables(node, tube - 1)[local::FACE]);
                let rate = sum(&|node| state.facing[node * (layout.tubes - 1) + tube - 1].h);
                let step = (abscissa - face) / (rate * state.lengths[e]);
                x = (x + step).clamp(0.0, 1.0);
                shares = rule.lagrange(x);
                if step.abs() < 1e-12 {
                    break;
                }
            }
        }
        let mut values = [0.0; 3];
        for (node, share) in nodes().zip(&shares) {
            for (value, own) in values.iter_mut().zip(self.node(node)) {
                *value += share * own;
            }
        }
        let start = Layout::label(element.start, &equilibrium.point.coordinates).0;
        (start + x * state.lengths[e], values)
    }

    /// κ_Y, κ_Z and e at a node, in the section's own axes.
    fn node(&self, node: usize) -> [f64; 3] {
        let (layout, state) = (&self.equilibrium.layout, &self.workspace.state);
        if self.tube == 0 {
            let own = &state.local[node * layout.rows()..];
            [own[local::KY], own[local::KZ], own[local::E1]]
        } else {
            let facing = &state.facing[node * (layout.tubes - 1) + self.tube - 1];
            let stretch = state.variables(node, self.tube - 1)[local::EK];
            [-facing.p / facing.h, -facing.r / facing.h, stretch]
        }
    }
}
