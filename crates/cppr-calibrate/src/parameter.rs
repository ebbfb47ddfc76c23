//! What can be fitted, and how it changes a design.

use crate::design::Design;
use cppr::bundle::Part;
use cppr::design::TubeDesign;
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
}

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
    /// The same parameter twice, or once for all tubes and once for one.
    Twice(String),
}

impl fmt::Display for ParameterProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => write!(
                f,
                "{name} cannot be fitted; write centroid_offset_factor, youngs_modulus, shear_modulus or rest_curvature_factor, with @2 for \
                 tube 2 alone"
            ),
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
            Self::Twice(name) => write!(f, "{name} is asked for twice"),
        }
    }
}

impl std::error::Error for ParameterProblem {}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.kind {
            ParameterKind::CentroidOffsetFactor => "centroid_offset_factor",
            ParameterKind::YoungsModulus => "youngs_modulus",
            ParameterKind::ShearModulus => "shear_modulus",
            ParameterKind::RestCurvatureFactor => "rest_curvature_factor",
        };
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
        let kind = match name {
            "centroid_offset_factor" => ParameterKind::CentroidOffsetFactor,
            "youngs_modulus" => ParameterKind::YoungsModulus,
            "shear_modulus" => ParameterKind::ShearModulus,
            "rest_curvature_factor" => ParameterKind::RestCurvatureFactor,
            _ => return Err(unknown()),
        };
        Ok(Self { kind, tube })
    }

    /// Unit for people and its size in SI.
    #[must_use]
    pub fn unit(&self) -> (&'static str, f64) {
        match self.kind {
            ParameterKind::CentroidOffsetFactor | ParameterKind::RestCurvatureFactor => ("-", 1.0),
            ParameterKind::YoungsModulus | ParameterKind::ShearModulus => ("GPa", 1e9),
        }
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
            ParameterKind::CentroidOffsetFactor => {}
            ParameterKind::YoungsModulus | ParameterKind::ShearModulus => {
                if let Some(tube) = self.tubes(count).find(|tube| design.moduli(*tube).is_none()) {
                    return Err(ParameterProblem::NoMaterial(name(), tube + 1));
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

    /// Mean of the present values: where a fit starts.
    #[must_use]
    pub fn present(&self, designs: &[Design]) -> f64 {
        let mut values = Vec::new();
        for design in designs {
            for tube in self.tubes(design.tube_count()) {
                match self.kind {
                    ParameterKind::CentroidOffsetFactor => {
                        values.extend(design.bodies(tube).into_iter().map(factor));
                    }
                    ParameterKind::YoungsModulus => values.extend(design.moduli(tube).map(|[e, _]| e)),
                    ParameterKind::ShearModulus => values.extend(design.moduli(tube).map(|[_, g]| g)),
                    ParameterKind::RestCurvatureFactor => values.push(1.0),
                }
            }
        }
        values.iter().sum::<f64>() / values.len() as f64
    }

    /// Sets a value (SI) in a design; the factor on rest curvatures multiplies those that are there. Shafts made of a tube's material follow its moduli.
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
                    (ParameterKind::RestCurvatureFactor, _) | (_, TubeDesign::Stiffness(_)) => {}
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

/// A design with all parameters at the given values; moduli first, so that a fitted G holds for the fitted E.
pub(crate) fn apply(design: &Design, list: &[Parameter], values: &[f64]) -> Design {
    let mut changed = design.clone();
    let both = || list.iter().zip(values);
    for (parameter, value) in both().filter(|(p, _)| p.kind != ParameterKind::ShearModulus) {
        parameter.set(&mut changed, *value);
    }
    for (parameter, value) in both().filter(|(p, _)| p.kind == ParameterKind::ShearModulus) {
        parameter.set(&mut changed, *value);
    }
    changed
}
