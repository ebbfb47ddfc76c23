//! Designs: the dataclasses of `cppr._design` as [`cppr::design`] takes them, and back.

use crate::arrays::{number, unmasked};
use crate::errors::{self, Listed};
use cppr::bundle::{BundleDesign, Part, Shaft, TubeParts};
use cppr::design::{
    BelowPlate, Material, NotchPattern, NotchedTube, Outline, Profile, RobotDesign, StiffnessTube,
    TeethStiffness, Torsion, TubeDesign,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::f64::consts::PI;

/// Cells on which a function of x is sampled: those of the robot's own tables, so that nothing is lost.
const CELLS: u16 = 256;
/// Lengths above this are no robot's (m).
const LONG: f64 = 10.0;
/// Radii above this are no tube's (m).
const WIDE: f64 = 0.2;
/// Moduli below this are no solid's (Pa).
const SOFT: f64 = 1e4;
/// Lengths that differ by less than this part are the same.
const SAME: f64 = 1e-9;

/// What is needed to read a design: where problems go.
pub struct Reader<'py> {
    py: Python<'py>,
    length: f64,
    /// Of the tube that is being read.
    pattern: Option<NotchPattern>,
    problems: Vec<Listed>,
}

impl<'py> Reader<'py> {
    /// Reads tubes; all problems of all tubes are reported at once, save for wrong types.
    pub fn read(
        py: Python<'py>,
        name: String,
        length: f64,
        tubes: &[Bound<'py, PyAny>],
    ) -> PyResult<RobotDesign> {
        if length > LONG && length.is_finite() {
            errors::warn(
                py,
                "UnitWarning",
                &format!("the robot is {length} m long; lengths are in metres: 150 mm is 0.150"),
            )?;
        }
        let mut reader = Self { py, length, pattern: None, problems: Vec::new() };
        let tubes = tubes
            .iter()
            .enumerate()
            .map(|(index, tube)| reader.tube(index + 1, tube))
            .collect::<PyResult<Vec<_>>>()?;
        if reader.problems.is_empty() {
            Ok(RobotDesign { name, length, tubes })
        } else {
            Err(errors::robot_list(py, reader.problems))
        }
    }

    /// Reads tubes made of parts, and joints; without joints all tips are bonded.
    pub fn bundle(
        py: Python<'py>,
        name: String,
        tubes: &[Bound<'py, PyAny>],
        joints: Option<&[Bound<'py, PyAny>]>,
    ) -> PyResult<BundleDesign> {
        let mut reader = Self { py, length: 0.0, pattern: None, problems: Vec::new() };
        let tubes = tubes
            .iter()
            .enumerate()
            .map(|(index, tube)| reader.parts(index + 1, tube))
            .collect::<PyResult<Vec<_>>>()?;
        let joints = match joints {
            Some(list) => list
                .iter()
                .enumerate()
                .map(|(index, joint)| reader.joint(index + 1, joint, &tubes))
                .collect::<PyResult<Vec<_>>>()?,
            None if tubes.len() < 2 => Vec::new(),
            None => vec![reader.all_tips(&tubes)],
        };
        if reader.problems.is_empty() {
            Ok(BundleDesign { name, tubes, joints })
        } else {
            Err(errors::robot_list(py, reader.problems))
        }
    }

    fn parts(&mut self, tube: usize, value: &Bound<'py, PyAny>) -> PyResult<TubeParts> {
        let own = format!("tube {tube}");
        let class = |name: &str| self.py.import("cppr._bundle")?.getattr(name);
        if !value.is_instance(&class("Tube")?)? {
            return Err(errors::wrong_type(&own, "a Tube of parts", value));
        }
        let (part_class, shaft_class) = (class("Part")?, class("Shaft")?);
        let mut parts = Vec::new();
        for (index, part) in value.getattr("parts")?.try_iter()?.enumerate() {
            let (part, own) = (part?, format!("part {} of {own}", index + 1));
            if !part.is_instance(&part_class)? {
                return Err(errors::wrong_type(&own, "a Part", &part));
            }
            let scalar = |name: &str| number(&format!("{name} of {own}"), &part.getattr(name)?);
            let length = scalar("length")?;
            if length > LONG && length.is_finite() {
                let text = format!("{own} is {length} m long; lengths are in metres: 150 mm is 0.150");
                errors::warn(self.py, "UnitWarning", &text)?;
            }
            self.length = length;
            parts.push(Part {
                length,
                body: self.tube(tube, &part.getattr("body")?)?,
                rest_curvature: scalar("rest_curvature")?,
                rest_direction: scalar("rest_direction")?,
            });
        }
        let shaft = value.getattr("shaft")?;
        let shaft = if shaft.is_none() {
            None
        } else if shaft.is_instance(&shaft_class)? {
            let mut stiffness = |name: &str| {
                let value = number(&format!("{name} of the shaft of {own}"), &shaft.getattr(name)?)?;
                if !(value > 0.0 && value.is_finite()) {
                    self.problem(
                        &own,
                        format!("{name} of the shaft of {own} is {value}; it must be positive"),
                    );
                }
                PyResult::Ok(value)
            };
            Some(Shaft { axial: stiffness("axial")?, torsional: stiffness("torsional")?, of_material: false })
        } else {
            return Err(errors::wrong_type(&format!("the shaft of {own}"), "a Shaft", &shaft));
        };
        Ok(TubeParts::new(parts, shaft))
    }

    fn joint(
        &mut self,
        joint: usize,
        value: &Bound<'py, PyAny>,
        tubes: &[TubeParts],
    ) -> PyResult<Vec<(usize, f64)>> {
        let own = format!("joint {joint}");
        if !value.is_instance(&self.py.import("cppr._bundle")?.getattr("Joint")?)? {
            return Err(errors::wrong_type(&own, "a Joint", value));
        }
        let list = value.getattr("tubes")?;
        let named: Vec<usize> = unmasked(&format!("tubes of {own}"), &list)?
            .extract()
            .map_err(|_| errors::wrong_type(&format!("tubes of {own}"), "tube numbers", &list))?;
        let at = value.getattr("at")?;
        let at: Option<Vec<f64>> = unmasked(&format!("at of {own}"), &at)?
            .extract()
            .map_err(|_| errors::wrong_type(&format!("at of {own}"), "a label per tube", &at))?;
        if let Some(missing) = named.iter().find(|number| **number == 0 || **number > tubes.len()) {
            self.problem(&own, format!("{own}: there is no tube {missing}"));
            return Ok(Vec::new());
        }
        let labels = at.unwrap_or_else(|| named.iter().map(|number| tubes[number - 1].length()).collect());
        if labels.len() != named.len() {
            self.problem(&own, format!("{own}: {} labels stand for {} tubes", labels.len(), named.len()));
        }
        Ok(named.into_iter().map(|number| number - 1).zip(labels).collect())
    }

    fn all_tips(&mut self, tubes: &[TubeParts]) -> Vec<(usize, f64)> {
        let lengths: Vec<f64> = tubes.iter().map(TubeParts::length).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        if lengths.iter().any(|length| longest - length > SAME * longest) {
            let text = "the tubes differ in length, so that their tips do not meet: give joints, or joints=[] if all tips are free";
            self.problem("joints", text.into());
        }
        lengths.into_iter().enumerate().collect()
    }

    fn is(&self, value: &Bound<'py, PyAny>, class: &str) -> PyResult<bool> {
        value.is_instance(&self.py.import("cppr._design")?.getattr(class)?)
    }

    fn tube(&mut self, number: usize, tube: &Bound<'py, PyAny>) -> PyResult<TubeDesign> {
        let own = format!("tube {number}");
        if self.is(tube, "NotchedTube")? {
            Ok(TubeDesign::Notched(self.notched(&own, tube)?))
        } else if self.is(tube, "StiffnessTube")? {
            Ok(TubeDesign::Stiffness(self.stiffness(&own, tube)?))
        } else {
            Err(errors::wrong_type(&own, "a NotchedTube or a StiffnessTube", tube))
        }
    }

    fn notched(&mut self, own: &str, tube: &Bound<'py, PyAny>) -> PyResult<NotchedTube> {
        let get = |name: &str| tube.getattr(name);
        let scalar = |name: &str| number(&format!("{name} of {own}"), &get(name)?);
        let (outer, inner) = (scalar("outer_radius")?, scalar("inner_radius")?);
        if outer > WIDE && outer.is_finite() {
            let text = format!("the outer radius of {own} is {outer} m; radii are in metres: 3 mm is 0.003");
            errors::warn(self.py, "UnitWarning", &text)?;
        }
        let polygon = |sides| Outline::Polygon { sides, outer_apothem: outer, inner_apothem: inner };
        let outline = match choice(own, tube, "shape", &["round", "square", "hexagon"])? {
            0 => Outline::Round { outer_radius: outer, inner_radius: inner },
            1 => polygon(4),
            _ => polygon(6),
        };
        let torsion = get("torsion")?;
        let torsion = if torsion.is_instance_of::<PyString>() {
            match choice(own, tube, "torsion", &["saint-venant", "polar"])? {
                0 => Torsion::SaintVenant,
                _ => Torsion::Polar,
            }
        } else {
            Torsion::Given(self.profile(&format!("torsion of {own}"), &torsion)?)
        };
        let below = match choice(own, tube, "below_plate", &["plain", "continued"])? {
            0 => BelowPlate::Plain,
            _ => BelowPlate::Continued,
        };
        self.pattern = self.notches(own, &get("notches")?)?;
        Ok(NotchedTube {
            outline,
            pattern: self.pattern,
            teeth: TeethStiffness::Flexible,
            contact: false,
            depth: self.profile(&format!("depth of {own}"), &get("depth")?)?,
            direction: self.direction(own, &get("opening")?)?,
            material: self.material(own, &get("material")?)?,
            torsion,
            below,
            centroid_offset_factor: scalar("centroid_offset_factor")?,
        })
    }

    fn material(&mut self, own: &str, material: &Bound<'py, PyAny>) -> PyResult<Material> {
        if !self.is(material, "Material")? {
            return Err(errors::wrong_type(&format!("material of {own}"), "a Material", material));
        }
        let scalar = |name: &str| number(&format!("{name} of {own}"), &material.getattr(name)?);
        let youngs_modulus = scalar("youngs_modulus")?;
        if youngs_modulus > 0.0 && youngs_modulus < SOFT {
            let text = format!(
                "Young's modulus of {own} is {youngs_modulus} Pa; moduli are in pascals: 5 GPa is 5e9"
            );
            errors::warn(self.py, "UnitWarning", &text)?;
        }
        let poissons_ratio = scalar("poissons_ratio")?;
        if !(poissons_ratio > -1.0 && poissons_ratio.is_finite()) {
            let text = format!("Poisson's ratio of {own} is {poissons_ratio}; it must exceed -1");
            self.problem(own, text);
        }
        let strain = material.getattr("allowable_strain")?;
        let allowable_strain = if strain.is_none() { None } else { Some(scalar("allowable_strain")?) };
        if allowable_strain.is_some_and(|s| !(s > 0.0 && s <= 1.0)) {
            self.problem(
                own,
                format!("the allowable strain of {own} must be a positive part, such as 0.015"),
            );
        }
        Ok(Material {
            youngs_modulus,
            poissons_ratio,
            density: scalar("density")?,
            allowable_strain,
            softening: None,
        })
    }

    fn stiffness(&mut self, own: &str, tube: &Bound<'py, PyAny>) -> PyResult<StiffnessTube> {
        self.pattern = None;
        let direction = self.direction(own, &tube.getattr("opening")?)?;
        let mut profile = |name: &str| self.profile(&format!("{name} of {own}"), &tube.getattr(name)?);
        let axial = tube.getattr("axial")?;
        Ok(StiffnessTube {
            centroid_offset: profile("centroid_offset")?,
            direction,
            bending_y: profile("bending_y")?,
            bending_z: profile("bending_z")?,
            torsion: profile("torsion")?,
            axial: if axial.is_none() { None } else { Some(profile("axial")?) },
            mass_per_length: profile("mass_per_length")?,
            centroid_offset_factor: number(
                &format!("centroid_offset_factor of {own}"),
                &tube.getattr("centroid_offset_factor")?,
            )?,
        })
    }

    /// The row of notches, which has to fit into the tube.
    fn notches(&mut self, own: &str, value: &Bound<'py, PyAny>) -> PyResult<Option<NotchPattern>> {
        if value.is_none() {
            return Ok(None);
        }
        let what = format!("notches of {own}");
        if !self.is(value, "NotchPattern")? {
            return Err(errors::wrong_type(&what, "a NotchPattern", value));
        }
        let scalar = |name: &str| number(&format!("{name} of the {what}"), &value.getattr(name)?);
        let count = value.getattr("count")?;
        let count: u32 =
            count.extract().map_err(|_| errors::wrong_type(&what, "a whole number of notches", &count))?;
        let pattern = NotchPattern { length: scalar("length")?, tooth: scalar("tooth")?, count };
        let positive = pattern.length > 0.0 && pattern.tooth >= 0.0 && count > 0;
        if !positive || f64::from(count) * pattern.pitch() > self.length * (1.0 + 1e-9) {
            let text = format!(
                "{own} has {count} notches of {:.3} mm with teeth of {:.3} mm, which do not fit into {:.3} mm",
                pattern.length * 1e3,
                pattern.tooth * 1e3,
                self.length * 1e3
            );
            self.problem(own, text);
        }
        Ok(Some(pattern))
    }

    fn problem(&mut self, key: &str, message: String) {
        self.problems.push((0, 0, key.into(), message, String::new()));
    }

    /// Direction of the centroid, opposite to the opening.
    fn direction(&mut self, own: &str, opening: &Bound<'py, PyAny>) -> PyResult<Profile> {
        let opening = self.profile(&format!("opening of {own}"), opening)?;
        Ok(opposite(&opening, self.length))
    }

    /// A value along the tube.
    fn profile(&mut self, what: &str, value: &Bound<'py, PyAny>) -> PyResult<Profile> {
        let list = |name: &str| -> PyResult<Vec<f64>> {
            let own = value.getattr(name)?;
            let what = format!("{name} of the {what}");
            unmasked(&what, &own)?.extract().map_err(|_| errors::wrong_type(&what, "numbers", &own))
        };
        let found = if let Ok(constant) = number(what, value) {
            Profile::table(&[0.0], &[constant])
        } else if self.is(value, "Table")? {
            Profile::table(&list("x")?, &list("values")?)
        } else if self.is(value, "PerNotch")? {
            let values = list("values")?;
            let middles = self.pattern.map(|p| p.middles()).unwrap_or_default();
            if middles.len() != values.len() {
                let text = format!(
                    "the {what} has {} values, one per notch, and the tube {} notches; give it a NotchPattern with as many",
                    values.len(),
                    middles.len()
                );
                self.problem(what, text);
                return Ok(Profile::constant(0.0));
            }
            Profile::per_notch(&values, &middles)
        } else if value.is_callable() {
            let x = self.steps(usize::from(CELLS) + 1);
            let sampled = x
                .iter()
                .map(|&x| number(&format!("what the function for the {what} returns"), &value.call1((x,))?))
                .collect::<PyResult<Vec<f64>>>()?;
            Profile::table(&x, &sampled)
        } else {
            let values: Vec<f64> = unmasked(what, value)?.extract().map_err(|_| {
                errors::wrong_type(
                    what,
                    "a number, a one-dimensional array, a function, Table or PerNotch",
                    value,
                )
            })?;
            match values[..] {
                [base, tip] if base.is_finite() && tip.is_finite() => Ok(Profile::linear(base, tip)),
                [one] => Profile::table(&[0.0], &[one]),
                _ => Profile::table(&self.steps(values.len()), &values),
            }
        };
        Ok(found.unwrap_or_else(|error| {
            self.problem(what, format!("{what}: {error}"));
            Profile::constant(0.0)
        }))
    }

    /// Equal steps from base to tip (m). A robot without length is refused later.
    fn steps(&self, count: usize) -> Vec<f64> {
        let length = if self.length > 0.0 && self.length.is_finite() { self.length } else { 1.0 };
        (0..count).map(|i| length * i as f64 / (count.max(2) - 1) as f64).collect()
    }
}

/// Index of a text among those allowed.
fn choice(own: &str, tube: &Bound<'_, PyAny>, name: &str, allowed: &[&str]) -> PyResult<usize> {
    let value = tube.getattr(name)?;
    pick(&format!("{name} of {own}"), &value, allowed)
}

/// Index of a text among those allowed.
pub fn pick(what: &str, value: &Bound<'_, PyAny>, allowed: &[&str]) -> PyResult<usize> {
    let text: String = value.extract().map_err(|_| errors::wrong_type(what, "a text", value))?;
    allowed.iter().position(|a| *a == text).ok_or_else(|| {
        PyValueError::new_err(format!("{what} must be \"{}\", not \"{text}\"", allowed.join("\" or \"")))
    })
}

/// The opposite direction (rad), so that there and back is the same number at 0 and π.
fn opposite(direction: &Profile, length: f64) -> Profile {
    direction.shifted(if direction.eval(0.0, length)[0] > 0.0 { -PI } else { PI })
}

/// A profile as Python gives it: a number, base and tip, or a table over the robot's own cells.
fn profile<'py>(py: Python<'py>, profile: &Profile, length: f64) -> PyResult<Bound<'py, PyAny>> {
    let x: Vec<f64> = (0..=CELLS).map(|i| length * f64::from(i) / f64::from(CELLS)).collect();
    let values: Vec<f64> = x.iter().map(|&x| profile.eval(x, length)[0]).collect();
    let (base, tip) = (values[0], values[usize::from(CELLS)]);
    let close = |a: f64, b: f64| (a - b).abs() <= 8.0 * f64::EPSILON * b.abs();
    if values.iter().all(|&v| close(v, base)) {
        return Ok(base.into_pyobject(py)?.into_any());
    }
    if x.iter().zip(&values).all(|(x, &v)| close(v, base + (tip - base) * x / length)) {
        return Ok((base, tip).into_pyobject(py)?.into_any());
    }
    py.import("cppr._design")?.getattr("Table")?.call1((x, values))
}

/// A tube as its dataclass.
pub fn tube<'py>(py: Python<'py>, tube: &TubeDesign, length: f64) -> PyResult<Bound<'py, PyAny>> {
    let module = py.import("cppr._design")?;
    let along = |p: &Profile| profile(py, p, length);
    let arguments = PyDict::new(py);
    match tube {
        TubeDesign::Notched(t) => {
            let (shape, outer, inner) = match t.outline {
                Outline::Round { outer_radius, inner_radius } => ("round", outer_radius, inner_radius),
                Outline::Polygon { sides: 4, outer_apothem, inner_apothem } => {
                    ("square", outer_apothem, inner_apothem)
                }
                Outline::Polygon { sides: 6, outer_apothem, inner_apothem } => {
                    ("hexagon", outer_apothem, inner_apothem)
                }
                Outline::Polygon { .. } => {
                    return Err(PyTypeError::new_err("polygons here have four or six sides"));
                }
            };
            let m = &t.material;
            let material = module.getattr("Material")?.call1((
                m.youngs_modulus,
                m.poissons_ratio,
                m.density,
                m.allowable_strain,
            ))?;
            let torsion = match &t.torsion {
                Torsion::SaintVenant => PyString::new(py, "saint-venant").into_any(),
                Torsion::Polar => PyString::new(py, "polar").into_any(),
                Torsion::Given(p) => along(p)?,
            };
            let below = if t.below == BelowPlate::Plain { "plain" } else { "continued" };
            arguments.set_item("outer_radius", outer)?;
            arguments.set_item("inner_radius", inner)?;
            arguments.set_item("depth", along(&t.depth)?)?;
            arguments.set_item("opening", along(&opposite(&t.direction, length))?)?;
            arguments.set_item("material", material)?;
            let pattern = t.pattern.map(|p| (p.length, p.tooth, p.count));
            arguments.set_item(
                "notches",
                pattern.map(|p| module.getattr("NotchPattern")?.call1(p)).transpose()?,
            )?;
            arguments.set_item("shape", shape)?;
            arguments.set_item("torsion", torsion)?;
            arguments.set_item("below_plate", below)?;
            arguments.set_item("centroid_offset_factor", t.centroid_offset_factor)?;
            module.getattr("NotchedTube")?.call((), Some(&arguments))
        }
        TubeDesign::Stiffness(t) => {
            arguments.set_item("centroid_offset", along(&t.centroid_offset)?)?;
            arguments.set_item("bending_y", along(&t.bending_y)?)?;
            arguments.set_item("bending_z", along(&t.bending_z)?)?;
            arguments.set_item("torsion", along(&t.torsion)?)?;
            arguments.set_item("opening", along(&opposite(&t.direction, length))?)?;
            arguments.set_item("axial", t.axial.as_ref().map(along).transpose()?)?;
            arguments.set_item("mass_per_length", along(&t.mass_per_length)?)?;
            arguments.set_item("centroid_offset_factor", t.centroid_offset_factor)?;
            module.getattr("StiffnessTube")?.call((), Some(&arguments))
        }
    }
}

/// Properties of a notched section (m, m², m⁴): area, centroid offset, I_Y, I_Z, polar moment about the centre, torsion constant.
#[pyfunction]
#[pyo3(signature = (outer_radius, inner_radius, depth, shape = "round"))]
pub fn section(
    py: Python<'_>,
    outer_radius: f64,
    inner_radius: f64,
    depth: f64,
    shape: &str,
) -> PyResult<(f64, f64, f64, f64, f64, f64)> {
    let polygon =
        |sides| Outline::Polygon { sides, outer_apothem: outer_radius, inner_apothem: inner_radius };
    let outline = match pick("shape", PyString::new(py, shape).as_any(), &["round", "square", "hexagon"])? {
        0 => Outline::Round { outer_radius, inner_radius },
        1 => polygon(4),
        _ => polygon(6),
    };
    let s = py.detach(|| outline.notched(depth)).map_err(|problem| {
        errors::robot_list(py, vec![(0, 0, "section".into(), problem.to_string(), String::new())])
    })?;
    Ok((s.area, s.centroid_offset, s.inertia_y, s.inertia_z, s.polar_about_centre, s.torsion_constant))
}
