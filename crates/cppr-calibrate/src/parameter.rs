//! What can be fitted, and how it changes a design.

use crate::design::Design;
use cppr::bundle::{BundleDesign, Friction, Part};
use cppr::design::{Branch, CellTable, Cut, RobotDesign, Softening, TeethStiffness, TubeDesign};
use std::fmt;

/// A kind of parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// Factor on the centroid offset D (-).
    CentroidOffsetFactor,
    /// Young's modulus E (Pa); Poisson's ratio stays.
    YoungsModulus,
    /// Shear modulus G (Pa); Young's modulus stays.
    ShearModulus,
    /// Factor on the curvature of free tubes and parts (-).
    RestCurvatureFactor,
    /// Strain from which on metal softens (-); that under compression keeps its ratio to it.
    OnsetStrain,
    /// Slope of the stress beyond it (Pa); that under compression keeps its ratio to it.
    SecondModulus,
    /// Coefficient of friction between the tubes (-), which no design has.
    Friction,
    /// Factor on what the teeth of notches bend, where their cells are computed (-).
    ToothFactor,
    /// Radial gap between a tube and the one inside it (m).
    Gap,
}

/// Names, units for people with their size in SI.
const KINDS: [(ParameterKind, &str, (&str, f64)); 9] = [
    (ParameterKind::CentroidOffsetFactor, "centroid_offset_factor", ("-", 1.0)),
    (ParameterKind::YoungsModulus, "youngs_modulus", ("GPa", 1e9)),
    (ParameterKind::ShearModulus, "shear_modulus", ("GPa", 1e9)),
    (ParameterKind::RestCurvatureFactor, "rest_curvature_factor", ("-", 1.0)),
    (ParameterKind::OnsetStrain, "onset_strain", ("%", 1e-2)),
    (ParameterKind::SecondModulus, "second_modulus", ("GPa", 1e9)),
    (ParameterKind::Friction, "friction", ("-", 1.0)),
    (ParameterKind::ToothFactor, "tooth_factor", ("-", 1.0)),
    (ParameterKind::Gap, "gap", ("mm", 1e-3)),
];

/// The friction of all robots of a fit; `None` where they have none.
///
/// # Errors
/// Where one rubs other than another.
pub fn common_friction(each: &[Option<Friction>]) -> Result<Option<Friction>, ParameterProblem> {
    let first = each.first().copied().flatten();
    if each.iter().all(|own| *own == first) { Ok(first) } else { Err(ParameterProblem::Frictions) }
}

/// Where the search for a coefficient of friction begins, unless one is given.
const FIRST_FRICTION: f64 = 0.1;
/// Change of the coefficient of friction that counts as much as a relative change of 1 in other parameters: that of a rough dry pair.
const FULL_FRICTION: f64 = 0.5;
/// The same of a gap (m).
const FULL_GAP: f64 = 1e-4;
/// The bound of a modulus, reached through its logarithm, is no greater than that modulus.
const ROUNDING: f64 = 1e-12;
/// Beyond it tubes jam.
const MOST_FRICTION: f64 = 2.0;

/// A parameter to fit: one value for all robots, of all tubes or of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Which.
    pub kind: ParameterKind,
    /// Tube number, from 1; `None` for all tubes.
    pub tube: Option<usize>,
}

/// Why a parameter cannot be fitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterProblem {
    /// There is no parameter of that name.
    Unknown(String),
    /// A robot has no such tube: robot, tube number, tubes it has.
    NoTube(String, usize, usize),
    /// A tube given by its stiffness has no material: robot, tube number.
    NoMaterial(String, usize),
    /// No part of these tubes is curved when free: robot, and the tube's number where one was named.
    Straight(String, Option<usize>),
    /// None of these tubes is of metal that softens: robot, and the tube's number where one was named.
    Linear(String, Option<usize>),
    /// No teeth of these tubes are computed: robot, and the tube's number where one was named.
    NoCells(String, Option<usize>),
    /// Gaps are solved for in robots without parts and joints, and this is another.
    GapInBundle(String),
    /// Nothing lies inside this tube: robot, tube number.
    Innermost(String, usize),
    /// The gap inside a tube that is given by its stiffness, or holds one, is not known and not fitted: robot, tube number.
    UnknownGap(String, usize),
    /// Gaps and friction at once.
    GapAndFriction,
    /// Robots that rub differently.
    Frictions,
    /// Notches of a tube are cut radially: robot, tube number.
    Radial(String, usize),
    /// One value for all tubes: the name.
    OfAll(&'static str),
    /// The same parameter twice, or once for all tubes and once for one.
    Twice(String),
}

impl fmt::Display for ParameterProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => {
                let names = KINDS.map(|(_, name, _)| name).join(", ");
                write!(f, "{name} cannot be fitted; write one of {names}, with @2 for tube 2 alone")
            }
            Self::NoTube(robot, tube, count) => write!(f, "{robot} has tubes 1 to {count}, not {tube}"),
            Self::NoMaterial(robot, tube) => {
                write!(f, "tube {tube} of {robot} is given by its stiffness and has no modulus to fit")
            }
            Self::Straight(robot, Some(tube)) => {
                write!(f, "tube {tube} of {robot} is straight when free: no curvature to fit")
            }
            Self::Straight(robot, None) => {
                write!(f, "the tubes of {robot} are straight when free: no curvature to fit")
            }
            Self::Linear(robot, tube) => {
                let which = tube.map_or("the tubes".into(), |tube| format!("tube {tube}"));
                write!(
                    f,
                    "the robot file of {robot} does not say that {which} soften; write onset_strain_percent and second_modulus_GPa, with \
                     values to begin at, into [material]"
                )
            }
            Self::NoCells(robot, tube) => {
                let which = tube.map_or("no tube".into(), |tube| format!("tube {tube} not"));
                write!(
                    f,
                    "{which} of {robot} has teeth = \"cell\" in its robot file, and tooth_factor is one on what those bend"
                )
            }
            Self::GapInBundle(robot) => write!(
                f,
                "{robot} has parts or joints, and gaps are solved for between tubes of one length and one pattern each"
            ),
            Self::Innermost(robot, tube) => {
                write!(
                    f,
                    "nothing lies inside tube {tube} of {robot}; gap@K is that between tubes K and K + 1"
                )
            }
            Self::UnknownGap(robot, tube) => write!(
                f,
                "the gap inside tube {tube} of {robot} is not known, since one of its walls is not; fit it as well (gap without @)"
            ),
            Self::GapAndFriction => {
                write!(
                    f,
                    "friction is computed without gaps between the tubes; fit gap without it, and with a friction of 0 where the robot \
                     file has one"
                )
            }
            Self::Frictions => write!(
                f,
                "the robots rub differently, and a fit has one friction for all of them; give it (0 leaves it out)"
            ),
            Self::Radial(robot, tube) => write!(
                f,
                "the notches of tube {tube} of {robot} are cut radially, and tooth_factor is for notches that a plane cuts: what a radial cut \
                 leaves is stiffer than the section that the factor begins with"
            ),
            Self::OfAll(name) => write!(f, "{name} is one for all tubes; write it without @"),
            Self::Twice(name) => write!(f, "{name} is asked for twice"),
        }
    }
}

impl std::error::Error for ParameterProblem {}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.facts().0;
        match self.tube {
            None => write!(f, "{name}"),
            Some(tube) => write!(f, "{name}@{tube}"),
        }
    }
}

impl Parameter {
    /// Reads `name` or `name@K`.
    ///
    /// # Errors
    /// [`ParameterProblem::Unknown`].
    pub fn parse(text: &str) -> Result<Self, ParameterProblem> {
        let unknown = || ParameterProblem::Unknown(text.into());
        let (name, tube) = match text.split_once('@') {
            None => (text, None),
            Some((name, tube)) => {
                let tube = tube.parse::<usize>().ok().filter(|k| *k >= 1).ok_or_else(unknown)?;
                (name, Some(tube))
            }
        };
        let (kind, name, _) = KINDS.into_iter().find(|own| own.1 == name).ok_or_else(unknown)?;
        if kind == ParameterKind::Friction && tube.is_some() {
            return Err(ParameterProblem::OfAll(name));
        }
        Ok(Self { kind, tube })
    }

    fn facts(&self) -> (&'static str, (&'static str, f64)) {
        KINDS.iter().find(|own| own.0 == self.kind).map_or(("", ("-", 1.0)), |own| (own.1, own.2))
    }

    /// Unit for people and its size in SI.
    #[must_use]
    pub fn unit(&self) -> (&'static str, f64) {
        self.facts().1
    }

    /// Of what may vanish, the change of the value that the search counts as 1.
    pub(crate) fn full(&self) -> Option<f64> {
        match self.kind {
            ParameterKind::Friction => Some(FULL_FRICTION),
            ParameterKind::ToothFactor => Some(1.0),
            ParameterKind::Gap => Some(FULL_GAP),
            _ => None,
        }
    }

    /// Change of the value that the search counts as 1: the value itself, or of what may vanish a size of its own.
    pub(crate) fn size(&self, value: f64) -> f64 {
        self.full().unwrap_or(value)
    }

    /// The value at which the search is, as far from the start as it says.
    pub(crate) fn value(&self, start: f64, moved: f64) -> f64 {
        self.full().map_or_else(|| start * moved.exp(), |full| start + full * moved)
    }

    /// Where the search is at a value.
    pub(crate) fn place(&self, start: f64, value: f64) -> f64 {
        self.full().map_or_else(|| (value / start).ln(), |full| (value - start) / full)
    }

    /// Least and greatest value for these designs; a second modulus is no greater than the first.
    pub(crate) fn bounds(&self, designs: &[Design]) -> [f64; 2] {
        match self.kind {
            ParameterKind::Friction => [0.0, MOST_FRICTION],
            ParameterKind::SecondModulus => {
                let most = self.softenings(designs).map(|(young, Softening { tension, compression })| {
                    young * (tension.modulus / compression.modulus).min(1.0)
                });
                [0.0, most.fold(f64::INFINITY, f64::min) * (1.0 - ROUNDING)]
            }
            _ => [0.0, f64::INFINITY],
        }
    }

    /// Young's modulus (Pa) and softening of everything that it changes.
    fn softenings(&self, designs: &[Design]) -> impl Iterator<Item = (f64, Softening)> {
        let bodies = designs
            .iter()
            .flat_map(|design| self.tubes(design.tube_count()).flat_map(|tube| design.bodies(tube)));
        let softens = |body: &TubeDesign| match body {
            TubeDesign::Notched(t) => Some((t.material.youngs_modulus, t.material.softening?)),
            TubeDesign::Stiffness(_) => None,
        };
        bodies.filter_map(softens)
    }

    /// Tubes (index from 0) of a design that it changes.
    fn tubes(&self, count: usize) -> std::ops::Range<usize> {
        match self.tube {
            None => 0..count,
            Some(tube) => tube - 1..tube,
        }
    }

    /// Checks a list of parameters against designs.
    ///
    /// # Errors
    /// The first problem.
    pub fn check(list: &[Self], designs: &[Design]) -> Result<(), ParameterProblem> {
        for (i, own) in list.iter().enumerate() {
            let clash = |other: &&Self| {
                other.kind == own.kind
                    && (other.tube == own.tube || other.tube.is_none() || own.tube.is_none())
            };
            if list[..i].iter().any(|o| clash(&o)) {
                return Err(ParameterProblem::Twice(own.to_string()));
            }
            for design in designs {
                own.check_one(design)?;
            }
        }
        Ok(())
    }

    fn check_one(&self, design: &Design) -> Result<(), ParameterProblem> {
        let (name, count) = (|| design.name().to_owned(), design.tube_count());
        if let Some(tube) = self.tube.filter(|t| *t > count) {
            return Err(ParameterProblem::NoTube(name(), tube, count));
        }
        match self.kind {
            ParameterKind::CentroidOffsetFactor | ParameterKind::Friction => {}
            ParameterKind::Gap => {
                let Design::Robot(own) = design else { return Err(ParameterProblem::GapInBundle(name())) };
                if self.tube.unwrap_or(1) >= count {
                    return Err(ParameterProblem::Innermost(name(), count));
                }
                let known = gaps(own);
                if let (Some(_), Some(pair)) =
                    (self.tube, (1..count).find(|k| self.tube != Some(*k) && known[k - 1].is_none()))
                {
                    return Err(ParameterProblem::UnknownGap(name(), pair));
                }
            }
            ParameterKind::ToothFactor => {
                let of = |tube: usize| {
                    design.bodies(tube).into_iter().filter_map(move |own| Some((tube + 1, cells(own)?)))
                };
                let all: Vec<(usize, &CellTable)> = self.tubes(count).flat_map(of).collect();
                if all.is_empty() {
                    return Err(ParameterProblem::NoCells(name(), self.tube));
                }
                if let Some((tube, _)) = all.iter().find(|(_, own)| own.cut == Cut::Radial) {
                    return Err(ParameterProblem::Radial(name(), *tube));
                }
            }
            ParameterKind::OnsetStrain | ParameterKind::SecondModulus => {
                if self.softenings(std::slice::from_ref(design)).next().is_none() {
                    return Err(ParameterProblem::Linear(name(), self.tube));
                }
            }
            ParameterKind::YoungsModulus | ParameterKind::ShearModulus => {
                // Of all tubes those change that have a material.
                if self.tubes(count).all(|tube| design.moduli(tube).is_none()) {
                    return Err(ParameterProblem::NoMaterial(name(), self.tube.unwrap_or(1)));
                }
            }
            ParameterKind::RestCurvatureFactor => {
                let curved = |part: &Part| part.rest_curvature.abs() > 0.0;
                let any = match design {
                    Design::Robot(_) => false,
                    Design::Bundle(own) => {
                        own.tubes[self.tubes(count)].iter().any(|t| t.parts.iter().any(curved))
                    }
                };
                if !any {
                    return Err(ParameterProblem::Straight(name(), self.tube));
                }
            }
        }
        Ok(())
    }

    /// Mean of the present values: where a fit starts. Friction, which designs do not have, starts at 0.1, a gap where the radii leave it.
    #[must_use]
    pub fn present(&self, designs: &[Design]) -> f64 {
        let softened =
            |read: fn(Branch) -> f64| self.softenings(designs).map(move |(_, own)| read(own.tension));
        let mut values: Vec<f64> = match self.kind {
            ParameterKind::Friction => vec![FIRST_FRICTION],
            ParameterKind::Gap => {
                let pair = |own: &RobotDesign| match self.tube {
                    None => gaps(own),
                    Some(tube) => gaps(own)[tube - 1..tube].to_vec(),
                };
                let robots = designs.iter().filter_map(|design| match design {
                    Design::Robot(own) => Some(pair(own)),
                    Design::Bundle(_) => None,
                });
                // Where the walls are not known it begins at the size that counts as 1.
                robots.flatten().map(|gap| gap.unwrap_or(FULL_GAP)).collect()
            }
            ParameterKind::OnsetStrain => softened(|branch| branch.onset).collect(),
            ParameterKind::SecondModulus => softened(|branch| branch.modulus).collect(),
            _ => Vec::new(),
        };
        for design in designs {
            for tube in self.tubes(design.tube_count()) {
                match self.kind {
                    ParameterKind::CentroidOffsetFactor => {
                        values.extend(design.bodies(tube).into_iter().map(factor));
                    }
                    ParameterKind::YoungsModulus => values.extend(design.moduli(tube).map(|[e, _]| e)),
                    ParameterKind::ShearModulus => values.extend(design.moduli(tube).map(|[_, g]| g)),
                    ParameterKind::RestCurvatureFactor => values.push(1.0),
                    ParameterKind::ToothFactor => {
                        values.extend(
                            design.bodies(tube).into_iter().filter_map(cells).map(|own| own.tooth_factor),
                        );
                    }
                    ParameterKind::OnsetStrain
                    | ParameterKind::SecondModulus
                    | ParameterKind::Friction
                    | ParameterKind::Gap => {}
                }
            }
        }
        values.iter().sum::<f64>() / values.len() as f64
    }

    /// Sets a value (SI) in a design, friction and gaps in none; the factor on rest curvatures multiplies those that are there. Shafts made of a tube's material follow its moduli.
    pub fn set(&self, design: &mut Design, value: f64) {
        for tube in self.tubes(design.tube_count()) {
            let before = design.moduli(tube);
            for body in design.bodies_mut(tube) {
                match (self.kind, body) {
                    (ParameterKind::CentroidOffsetFactor, TubeDesign::Notched(t)) => {
                        t.centroid_offset_factor = value;
                    }
                    (ParameterKind::CentroidOffsetFactor, TubeDesign::Stiffness(t)) => {
                        t.centroid_offset_factor = value;
                    }
                    (ParameterKind::YoungsModulus, TubeDesign::Notched(t)) => {
                        t.material.youngs_modulus = value;
                    }
                    (ParameterKind::ShearModulus, TubeDesign::Notched(t)) => {
                        t.material.poissons_ratio = t.material.youngs_modulus / (2.0 * value) - 1.0;
                    }
                    (ParameterKind::OnsetStrain, TubeDesign::Notched(t)) => {
                        if let Some(own) = &mut t.material.softening {
                            let factor = value / own.tension.onset;
                            for branch in [&mut own.tension, &mut own.compression] {
                                branch.onset *= factor;
                                branch.unloading_onset = branch.unloading_onset.map(|own| own * factor);
                            }
                            own.tension.onset = value;
                        }
                    }
                    (ParameterKind::SecondModulus, TubeDesign::Notched(t)) => {
                        if let Some(own) = &mut t.material.softening {
                            own.compression.modulus *= value / own.tension.modulus;
                            own.tension.modulus = value;
                        }
                    }
                    (ParameterKind::ToothFactor, TubeDesign::Notched(t)) => {
                        if let TeethStiffness::Cells(table) = &mut t.teeth {
                            table.tooth_factor = value;
                        }
                    }
                    (
                        ParameterKind::RestCurvatureFactor | ParameterKind::Friction | ParameterKind::Gap,
                        _,
                    )
                    | (_, TubeDesign::Stiffness(_)) => {}
                }
            }
            let after = design.moduli(tube);
            let Design::Bundle(own) = design else { continue };
            let own = &mut own.tubes[tube];
            if self.kind == ParameterKind::RestCurvatureFactor {
                own.parts.iter_mut().for_each(|part| part.rest_curvature *= value);
            }
            if let (Some(shaft), Some([e, g]), Some([new_e, new_g])) = (&mut own.shaft, before, after)
                && shaft.of_material
            {
                shaft.axial *= new_e / e;
                shaft.torsional *= new_g / g;
            }
        }
    }
}

fn factor(body: &TubeDesign) -> f64 {
    match body {
        TubeDesign::Notched(t) => t.centroid_offset_factor,
        TubeDesign::Stiffness(t) => t.centroid_offset_factor,
    }
}

/// The gaps (m) that the radii of a robot leave, from outside to inside.
fn gaps(design: &RobotDesign) -> Vec<Option<f64>> {
    BundleDesign::from(design).gaps()
}

/// The cells of a tube, where they are computed.
fn cells(body: &TubeDesign) -> Option<&CellTable> {
    match body {
        TubeDesign::Notched(t) => match &t.teeth {
            TeethStiffness::Cells(table) => Some(table),
            TeethStiffness::Flexible | TeethStiffness::Rigid => None,
        },
        TubeDesign::Stiffness(_) => None,
    }
}

/// Parameters with values (SI), and what is known beside them.
#[derive(Clone)]
pub(crate) struct Values<'a> {
    pub list: &'a [Parameter],
    pub numbers: Vec<f64>,
    /// How tubes rub, with the coefficient that holds where none is fitted.
    pub known: Option<Friction>,
}

impl Values<'_> {
    /// A design with all values; moduli first, so that a fitted G holds for the fitted E.
    pub fn design(&self, design: &Design) -> Design {
        let mut changed = design.clone();
        let both = || self.list.iter().zip(&self.numbers);
        for (parameter, value) in both().filter(|(p, _)| p.kind != ParameterKind::ShearModulus) {
            parameter.set(&mut changed, *value);
        }
        for (parameter, value) in both().filter(|(p, _)| p.kind == ParameterKind::ShearModulus) {
            parameter.set(&mut changed, *value);
        }
        changed
    }

    /// How tubes rub, where they do.
    pub fn friction(&self) -> Option<Friction> {
        let fitted = self.list.iter().position(|p| p.kind == ParameterKind::Friction);
        let Some(p) = fitted else { return self.known };
        Some(Friction { coefficient: self.numbers[p], guide: self.known.and_then(|known| known.guide) })
    }

    /// Are gaps fitted?
    pub fn has_gaps(&self) -> bool {
        self.list.iter().any(|own| own.kind == ParameterKind::Gap)
    }

    /// The gaps (m) of a robot, from outside to inside: what is fitted, and what the radii leave where that is not. `None` where one is not known or below 0.
    pub fn gaps(&self, design: &RobotDesign) -> Option<Vec<f64>> {
        let fitted = |pair: usize| {
            let mut own = self.list.iter().zip(&self.numbers);
            own.find(|(p, _)| p.kind == ParameterKind::Gap && p.tube.is_none_or(|tube| tube == pair))
                .map(|(_, value)| *value)
        };
        let each =
            (1..).zip(gaps(design)).map(|(pair, known)| fitted(pair).or(known).filter(|gap| *gap >= 0.0));
        each.collect()
    }

    /// The same with one of them changed, relative to what the search counts as 1.
    pub fn moved(&self, p: usize, by: f64) -> Self {
        let mut moved = self.clone();
        moved.numbers[p] += by * self.list[p].size(self.numbers[p]);
        moved
    }
}
