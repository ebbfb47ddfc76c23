//! How near every notch is to its limits: strain at the extreme fibre, teeth that touch, shear by torsion.
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
//!
//! Where the finite elements of a cell gave the strain at the fillets of its notch ([`crate::design::PeakStrain`]), the strain is a bound on
//! that one, whatever the teeth are taken to do: the sum of what κ_Y, κ_Z and e make of the mean curvature; twist, whose shear is judged by itself, is not in it.

use super::capacity::concentration;
use super::strains::Strains;
use crate::design::fibre::{Fibres, TubeFibres};
use crate::design::fields::Part;
use crate::design::{BelowPlate, NotchedTube, Robot, TubeDesign};
use crate::kinematics::layout::Layout;
use crate::real::{Real, every};
use crate::solve::system::Buffers;
use crate::solve::{Equilibrium, Solver};

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
    /// Greatest shear strain by torsion, of the sign of the twist (-).
    pub shear: f64,
    /// What of it the material may bear (-).
    pub allowable_shear: Option<f64>,
    /// Part of the notch's length that bending has taken up where the teeth are nearest: 1 where they touch, negative where the
    /// whole notch opens. `None` without a notch.
    pub closure: Option<f64>,
    /// Distance that is left between the teeth where they are nearest, along the fibre (m).
    pub gap: Option<f64>,
}

/// The greatest of all notches and sections; none where none is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Utilisation {
    /// Strain against the allowable one (-).
    pub strain: Option<f64>,
    /// As [`SectionLimit::closure`].
    pub closure: Option<f64>,
    /// Shear by torsion against the allowable one (-).
    pub torsion: Option<f64>,
    /// Where strain, closure and torsion are greatest: the first of those that rounding alone tells apart.
    pub places: [Option<Spot>; 3],
}

impl Utilisation {
    /// Of some sections.
    #[must_use]
    pub fn of(sections: &[SectionLimit]) -> Self {
        let mut most = Self::default();
        for s in sections {
            let part = |value: f64, of: Option<f64>| of.map(|of| value.abs() / of);
            let own = [part(s.strain, s.allowable_strain), s.closure, part(s.shear, s.allowable_shear)];
            most.take(own, Spot { tube: s.tube, place: s.place, abscissa: s.abscissa });
        }
        most
    }

    /// One more section's strain, closure and torsion.
    fn take(&mut self, own: [Option<f64>; 3], spot: Spot) {
        let all = [&mut self.strain, &mut self.closure, &mut self.torsion];
        for ((most, place), own) in all.into_iter().zip(&mut self.places).zip(own) {
            let Some(own) = own.filter(|own| !own.is_nan()) else { continue };
            if most.is_none_or(|most| own > most + ROUNDING) {
                *place = Some(spot);
            }
            *most = Some(most.map_or(own, |most| most.max(own)));
        }
    }
}

/// Where on a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Tube number, 1 is the leader.
    pub tube: usize,
    /// Which piece.
    pub place: Place,
    /// Rest abscissa of its middle on its own tube (m).
    pub abscissa: f64,
}

/// What ends the safe use of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The strain reaches what the material may bear.
    Strain,
    /// The teeth of a notch touch.
    Closure,
    /// The shear strain by torsion reaches what the material may bear.
    Torsion,
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

    /// Shear strain by torsion against the allowable one (-).
    #[must_use]
    pub fn torsion_utilisation(&self) -> Option<f64> {
        self.allowable_shear.map(|allowable| self.shear.abs() / allowable)
    }

    /// The greatest of strain, closure and shear against their limits.
    #[must_use]
    pub fn governing(&self) -> Option<Governing> {
        let strain = self.strain_utilisation().map(|u| (Limit::Strain, u));
        let closure = self.closure.map(|u| (Limit::Closure, u));
        let torsion = self.torsion_utilisation().map(|u| (Limit::Torsion, u));
        strain
            .into_iter()
            .chain(closure)
            .chain(torsion)
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

impl Solver {
    /// State of every notch that stands in the robot, tube by tube from the baseplate on. Tubes given by their stiffness have no
    /// fibres and are left out; empty where there is no equilibrium.
    #[must_use]
    pub fn section_limits(&mut self, equilibrium: &Equilibrium, teeth: Teeth) -> Vec<SectionLimit> {
        let mut sections = Vec::new();
        if equilibrium.status.is_equilibrium() {
            let buffers = &mut self.buffers;
            equilibrium.refresh(buffers);
            let Equilibrium { robot, layout, point, .. } = equilibrium;
            judge(robot, buffers, layout, &point.coordinates, teeth, |s, _| sections.push(s.limit()));
        }
        sections
    }

    /// The greatest of what [`Solver::section_limits`] gives.
    #[must_use]
    pub fn utilisation(&mut self, equilibrium: &Equilibrium, teeth: Teeth) -> Utilisation {
        if !equilibrium.status.is_equilibrium() {
            return Utilisation::default();
        }
        let buffers = &mut self.buffers;
        equilibrium.refresh(buffers);
        let Equilibrium { robot, layout, point, .. } = equilibrium;
        greatest(robot, buffers, layout, &point.coordinates, teeth).swap_remove(0)
    }
}

/// Greatest utilisations in every lane of evaluated buffers.
pub(crate) fn greatest<S: Real>(
    robot: &Robot,
    buffers: &Buffers<S>,
    layout: &Layout,
    coordinates: &[S],
    teeth: Teeth,
) -> Vec<Utilisation> {
    let mut greatest = vec![Utilisation::default(); S::LANES];
    judge(robot, buffers, layout, coordinates, teeth, |section, lanes| {
        for (lane, most) in greatest.iter_mut().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1) {
            let part = |value: S, of: Option<f64>| of.map(|of| value.lane(lane).abs() / of);
            let own = [
                part(section.strain, section.allowable_strain),
                section.closure.map(|closure| closure.lane(lane)),
                part(section.shear, section.allowable_shear),
            ];
            most.take(
                own,
                Spot { tube: section.tube, place: section.place, abscissa: section.abscissa.lane(lane) },
            );
        }
    });
    greatest
}

/// A [`SectionLimit`] in all lanes.
struct Judged<S> {
    tube: usize,
    place: Place,
    abscissa: S,
    label: S,
    curvature: [S; 2],
    strain: S,
    allowable_strain: Option<f64>,
    shear: S,
    allowable_shear: Option<f64>,
    closure: Option<S>,
    /// Of the notch (m).
    length: f64,
}

impl Judged<f64> {
    fn limit(self) -> SectionLimit {
        SectionLimit {
            tube: self.tube,
            place: self.place,
            abscissa: self.abscissa,
            label: self.label,
            curvature: self.curvature,
            strain: self.strain,
            allowable_strain: self.allowable_strain,
            shear: self.shear,
            allowable_shear: self.allowable_shear,
            closure: self.closure,
            gap: self.closure.map(|closed| self.length * (1.0 - closed)),
        }
    }
}

/// Judges all pieces of all tubes; `visit` gets the lanes in which a piece is inside the robot.
fn judge<S: Real>(
    robot: &Robot,
    buffers: &Buffers<S>,
    layout: &Layout,
    coordinates: &[S],
    teeth: Teeth,
    mut visit: impl FnMut(Judged<S>, u64),
) {
    for (tube, (design, fibres)) in robot.design().tubes.iter().zip(robot.fibres()).enumerate() {
        let (TubeDesign::Notched(design), Some(fibres)) = (design, fibres) else { continue };
        let strains = Strains::new(&buffers.state, layout, coordinates, tube);
        let pieces = Pieces { design, fibres, length: robot.length(), base: strains.base() };
        pieces.visit(|place, abscissa, lanes, fibres| {
            let (label, mut values) = strains.at(abscissa, place == Place::Uncut, lanes);
            let part = match place {
                Place::Uncut => Part::Below,
                Place::Notch(number) if number < 1 => Part::Below,
                _ => Part::Pattern,
            };
            values[3] -= robot.fields()[tube].direction(abscissa, part)[1];
            visit(Judged::new(tube + 1, place, design, fibres, teeth, [abscissa, label], values), lanes);
        });
    }
}

impl<S: Real> Judged<S> {
    /// A piece at its rest abscissa and label, from κ_Y, κ_Z, the stretch and the rate of twist there.
    fn new(
        tube: usize,
        place: Place,
        design: &NotchedTube,
        fibres: &Fibres,
        teeth: Teeth,
        [abscissa, label]: [S; 2],
        values: [S; 4],
    ) -> Self {
        let notch = match (place, &design.pattern) {
            (Place::Notch(_), Some(pattern)) if fibres.depth > 0.0 => Some(pattern),
            _ => None,
        };
        let share = notch.map_or(1.0, |pattern| concentration(pattern, teeth));
        let [bend_y, bend_z, stretch, twist] = values.map(|v| v * share);
        // ε = middle + a Y + b Z.
        let (middle, slope) = (stretch + bend_z * fibres.offset, [-bend_z, bend_y]);
        let back = slope.map(|s| -s);
        let (most, least) = (middle + fibres.greatest_kept(slope), middle - fibres.greatest_kept(back));
        let strain = S::from_lanes(|l| {
            let [most, least] = match (&fibres.peak, notch) {
                (Some(peak), Some(_)) => peak.bounds([0, 1, 2].map(|i| values[i].lane(l))),
                _ => [most.lane(l), least.lane(l)],
            };
            if most >= -least { most } else { least }
        });
        Self {
            tube,
            place,
            abscissa,
            label,
            curvature: [values[0], values[1]],
            strain,
            allowable_strain: design.material.allowable_strain,
            shear: twist * fibres.shear_arm,
            allowable_shear: design.material.allowable_shear(),
            closure: notch.map(|_| fibres.greatest_removed(back) - middle),
            length: notch.map_or(0.0, |pattern| pattern.length),
        }
    }
}

/// State of the notches of one part of a tube whose first section in the robot has the abscissa `base` (m); the part's label at its
/// beginning is `from` (m) and its first notch has the number after `notches`. `at` gives the facing label of the leader, κ_Y, κ_Z, the
/// stretch and the rate of twist at a label of the tube.
pub(super) fn part_limits(
    tube: usize,
    design: &NotchedTube,
    fibres: &TubeFibres,
    [from, base, length]: [f64; 3],
    notches: i32,
    teeth: Teeth,
    at: impl Fn(f64) -> (f64, [f64; 4]),
) -> Vec<SectionLimit> {
    let mut sections = Vec::new();
    Pieces { design, fibres, length, base }.visit(|place, abscissa: f64, _, fibres| {
        let (label, values) = at(from + abscissa);
        let place = match place {
            Place::Notch(number) => Place::Notch(number + notches),
            other => other,
        };
        let own = Judged::new(tube, place, design, fibres, teeth, [abscissa, label], values).limit();
        sections.push(SectionLimit { abscissa: from + abscissa, ..own });
    });
    sections
}

/// The pieces of a tube that are judged.
struct Pieces<'a, S> {
    design: &'a NotchedTube,
    fibres: &'a TubeFibres,
    length: f64,
    /// Rest abscissa of the section at the baseplate (m).
    base: S,
}

impl<S: Real> Pieces<'_, S> {
    /// From the baseplate to the tip: place, rest abscissa, in which lanes it stands in the robot, and how it is cut.
    fn visit(&self, mut visit: impl FnMut(Place, S, u64, &Fibres)) {
        let Self { design, fibres, length, base } = *self;
        let spread =
            |from: S, to: f64, i: u32, spaces: u32| from + (-from + to) * (f64::from(i) / f64::from(spaces));
        let pushed = base.mask(|b| b < -1e-9 * length);
        if let (BelowPlate::Plain, Some(plain), true) = (design.below, &fibres.plain, pushed != 0) {
            for i in 0..=UNCUT_SPACES {
                visit(Place::Uncut, spread(base, 0.0, i, UNCUT_SPACES), pushed, plain);
            }
        }
        match &design.pattern {
            Some(pattern) => {
                let first = if pushed != 0 && design.below == BelowPlate::Continued {
                    let lowest = (0..S::LANES).map(|l| base.lane(l)).fold(0.0, f64::min);
                    #[expect(
                        clippy::cast_possible_truncation,
                        reason = "a follower slides by less than its length"
                    )]
                    let below = (lowest / pattern.pitch()).floor() as i32;
                    below
                } else {
                    1
                };
                let last = i32::try_from(pattern.count).unwrap_or(i32::MAX);
                for number in first..=last {
                    let middle = (f64::from(number) - 0.5) * pattern.pitch();
                    let own = usize::try_from(number - 1).ok();
                    let own = own.map_or(Some(&fibres.base), |notch| fibres.notches.get(notch));
                    let lanes = base.mask(|b| middle >= b) & if number < 1 { pushed } else { every::<S>() };
                    if let (Some(Some(own)), true) = (own, lanes != 0 && middle <= length) {
                        visit(Place::Notch(number), S::splat(middle), lanes, own);
                    }
                }
            }
            None => {
                for i in 0..=SPACES {
                    let abscissa = spread(base.map(|b| b.max(0.0)), length, i, SPACES);
                    if design.depth.is_constant() {
                        if let Some(own) = &fibres.base {
                            visit(Place::Section, abscissa, every::<S>(), own);
                        }
                        continue;
                    }
                    for l in 0..S::LANES {
                        let own = S::splat(abscissa.lane(l));
                        let depth = design.depth.eval(abscissa.lane(l), length)[0];
                        if let Some(fibres) = design.outline.fibres(depth) {
                            visit(Place::Section, own, 1 << l, &fibres);
                        }
                    }
                }
            }
        }
    }
}
