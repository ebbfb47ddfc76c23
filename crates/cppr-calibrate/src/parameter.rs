//! What can be fitted, and how it changes a design.

use cppr::design::{RobotDesign, TubeDesign};
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
    /// The same parameter twice, or once for all tubes and once for one.
    Twice(String),
}

impl fmt::Display for ParameterProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => write!(
                f,
                "{name} cannot be fitted; write centroid_offset_factor, youngs_modulus or shear_modulus, with @2 for tube 2 alone"
            ),
            Self::NoTube(robot, tube, count) => write!(f, "{robot} has tubes 1 to {count}, not {tube}"),
            Self::NoMaterial(robot, tube) => {
                write!(f, "tube {tube} of {robot} is given by its stiffness and has no modulus to fit")
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
            _ => return Err(unknown()),
        };
        Ok(Self { kind, tube })
    }

    /// Unit for people and its size in SI.
    #[must_use]
    pub fn unit(&self) -> (&'static str, f64) {
        match self.kind {
            ParameterKind::CentroidOffsetFactor => ("-", 1.0),
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
    pub fn check(list: &[Self], designs: &[RobotDesign]) -> Result<(), ParameterProblem> {
        for (i, own) in list.iter().enumerate() {
            let clash = |other: &&Self| {
                other.kind == own.kind
                    && (other.tube == own.tube || other.tube.is_none() || own.tube.is_none())
            };
            if list[..i].iter().any(|o| clash(&o)) {
                return Err(ParameterProblem::Twice(own.to_string()));
            }
            for design in designs {
                let count = design.tubes.len();
                if let Some(tube) = own.tube.filter(|t| *t > count) {
                    return Err(ParameterProblem::NoTube(design.name.clone(), tube, count));
                }
                for index in own.tubes(count) {
                    if own.kind != ParameterKind::CentroidOffsetFactor
                        && matches!(design.tubes[index], TubeDesign::Stiffness(_))
                    {
                        return Err(ParameterProblem::NoMaterial(design.name.clone(), index + 1));
                    }
                }
            }
        }
        Ok(())
    }

    /// Mean of the present values: where a fit starts.
    #[must_use]
    pub fn present(&self, designs: &[RobotDesign]) -> f64 {
        let mut values = Vec::new();
        for design in designs {
            for tube in &design.tubes[self.tubes(design.tubes.len())] {
                values.push(match (self.kind, tube) {
                    (ParameterKind::CentroidOffsetFactor, TubeDesign::Notched(t)) => t.centroid_offset_factor,
                    (ParameterKind::CentroidOffsetFactor, TubeDesign::Stiffness(t)) => {
                        t.centroid_offset_factor
                    }
                    (ParameterKind::YoungsModulus, TubeDesign::Notched(t)) => t.material.youngs_modulus,
                    (_, TubeDesign::Notched(t)) => t.material.shear_modulus(),
                    (_, TubeDesign::Stiffness(_)) => f64::NAN,
                });
            }
        }
        values.iter().sum::<f64>() / values.len() as f64
    }

    /// Sets a value (SI) in a design.
    pub fn set(&self, design: &mut RobotDesign, value: f64) {
        let tubes = self.tubes(design.tubes.len());
        for tube in &mut design.tubes[tubes] {
            match (self.kind, tube) {
                (ParameterKind::CentroidOffsetFactor, TubeDesign::Notched(t)) => {
                    t.centroid_offset_factor = value;
                }
                (ParameterKind::CentroidOffsetFactor, TubeDesign::Stiffness(t)) => {
                    t.centroid_offset_factor = value;
                }
                (ParameterKind::YoungsModulus, TubeDesign::Notched(t)) => t.material.youngs_modulus = value,
                (ParameterKind::ShearModulus, TubeDesign::Notched(t)) => {
                    t.material.poissons_ratio = t.material.youngs_modulus / (2.0 * value) - 1.0;
                }
                (_, TubeDesign::Stiffness(_)) => {}
            }
        }
    }
}

/// A design with all parameters at the given values; moduli first, so that a fitted G holds for the fitted E.
pub(crate) fn apply(design: &RobotDesign, list: &[Parameter], values: &[f64]) -> RobotDesign {
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
