//! The quantities of a robot file: unit, conversion to SI, and the range in which a value is believable.
//!
//! The ranges are wide: outside of them lies no robot, but a slip of the unit (metres for millimetres,
//! megapascals for gigapascals). They also keep every value far from overflow once it is in SI.

/// A unit as keys spell it, with its conversion to SI.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unit {
    /// Suffix of keys.
    pub suffix: &'static str,
    /// How messages print it.
    pub print: &'static str,
    /// SI value of 1, as a quotient of two numbers that are exact, so that 150 mm is the double 0.15.
    scale: (f64, f64),
}

impl Unit {
    /// SI value of a number in this unit.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.scale.0 / self.scale.1
    }
}

pub(crate) const MM: Unit = Unit { suffix: "_mm", print: " mm", scale: (1.0, 1e3) };
pub(crate) const GPA: Unit = Unit { suffix: "_GPa", print: " GPa", scale: (1e9, 1.0) };
const KG_M3: Unit = Unit { suffix: "_kg_m3", print: " kg/m³", scale: (1.0, 1.0) };
pub(crate) const NMM2: Unit = Unit { suffix: "_Nmm2", print: " N mm²", scale: (1.0, 1e6) };
pub(crate) const NEWTON: Unit = Unit { suffix: "_N", print: " N", scale: (1.0, 1.0) };
pub(crate) const G_M: Unit = Unit { suffix: "_g_m", print: " g/m", scale: (1.0, 1e3) };
/// Degrees stay degrees until a direction has been brought into one turn.
pub(crate) const DEG: Unit = Unit { suffix: "_deg", print: "°", scale: (1.0, 1.0) };
pub(crate) const PERCENT: Unit = Unit { suffix: "_percent", print: " %", scale: (1.0, 1e2) };
const N_MM: Unit = Unit { suffix: "_N_mm", print: " N/mm", scale: (1e3, 1.0) };
const NMM_DEG: Unit = Unit { suffix: "_Nmm_deg", print: " N mm/°", scale: (0.18, std::f64::consts::PI) };
const PER_M: Unit = Unit { suffix: "_1_m", print: " 1/m", scale: (1.0, 1.0) };
const NONE: Unit = Unit { suffix: "", print: "", scale: (1.0, 1.0) };

/// What signs a quantity may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    Any,
    NotNegative,
    Positive,
}

/// A quantity: what values it may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantity {
    /// With its article, for messages.
    pub name: &'static str,
    pub unit: Unit,
    pub sign: Sign,
    /// Least and greatest believable magnitude other than zero, in `unit`.
    range: (f64, f64),
    /// What is probably meant beyond the range.
    slip: &'static str,
    /// A good value.
    pub example: &'static str,
}

const POSITIVE: Sign = Sign::Positive;
/// Less than this (m) no cut or bore leaves of a tube: a micrometre is a tenth of what lasers and printers can do.
pub const LEAST_WALL: f64 = 1e-6;
const LENGTH_SLIP: &str = "Is it in another unit? Write it in millimetres.";
const MODULUS_SLIP: &str = "Is it in another unit? Write it in gigapascals, such as 5.39 for 5390 MPa.";
const STIFFNESS_SLIP: &str = "Is it in another unit? 1 N m² is 1000000 N mm², and 1 N cm² is 100 N mm².";

macro_rules! quantity {
    ($id:ident, $name:literal, $unit:expr, $sign:expr, $low:literal .. $high:literal, $slip:expr, $example:literal) => {
        pub(crate) const $id: Quantity = Quantity {
            name: $name,
            unit: $unit,
            sign: $sign,
            range: ($low, $high),
            slip: $slip,
            example: $example,
        };
    };
}

quantity!(LENGTH, "a length", MM, POSITIVE, 1e-3..1e4, LENGTH_SLIP, "150.0");
quantity!(RADIUS, "a radius", MM, POSITIVE, 1e-3..1e4, LENGTH_SLIP, "3.0");
quantity!(BORE, "the radius of a bore", MM, Sign::NotNegative, 1e-3..1e4, LENGTH_SLIP, "2.0");
quantity!(DIAMETER, "a diameter", MM, POSITIVE, 2e-3..2e4, LENGTH_SLIP, "6.0");
quantity!(BORE_DIAMETER, "the diameter of a bore", MM, Sign::NotNegative, 2e-3..2e4, LENGTH_SLIP, "4.0");
quantity!(DEPTH, "a notch depth", MM, Sign::NotNegative, 1e-6..1e4, LENGTH_SLIP, "5.0");
quantity!(CORNER, "the radius of a corner", MM, POSITIVE, 1e-3..1e4, LENGTH_SLIP, "0.1");
quantity!(OFFSET, "a centroid offset", MM, Sign::NotNegative, 1e-6..1e4, LENGTH_SLIP, "1.0");
quantity!(ABSCISSA, "an abscissa", MM, Sign::NotNegative, 1e-9..1e4, LENGTH_SLIP, "0.0");
quantity!(MODULUS, "an elastic modulus", GPA, POSITIVE, 1e-6..2e3, MODULUS_SLIP, "5.39");
quantity!(
    DENSITY,
    "a density",
    KG_M3,
    Sign::NotNegative,
    5.0..3e4,
    "Is it in another unit? 1.24 g/cm³ is 1240 kg/m³.",
    "1240"
);
quantity!(
    STRAIN,
    "an allowable strain",
    PERCENT,
    POSITIVE,
    0.05..50.0,
    "Is it in another unit? A strain of 0.015 is 1.5 percent.",
    "1.5"
);
quantity!(
    ONSET,
    "the strain at which a metal softens",
    PERCENT,
    POSITIVE,
    0.05..50.0,
    "Is it in another unit? A strain of 0.015 is 1.5 percent.",
    "1.5"
);
quantity!(POISSON, "Poisson's ratio", NONE, Sign::Any, 1e-300..1e300, "", "0.35");
quantity!(STIFFNESS, "a stiffness", NMM2, POSITIVE, 1e-6..1e15, STIFFNESS_SLIP, "1783");
quantity!(
    AXIAL,
    "an axial stiffness",
    NEWTON,
    POSITIVE,
    1e-6..1e12,
    "Is it in another unit? Write it in newtons.",
    "11300"
);
quantity!(
    MASS,
    "a mass per length",
    G_M,
    Sign::NotNegative,
    1e-6..1e6,
    "Is it in another unit? 1 kg/m is 1000 g/m.",
    "3.8"
);
quantity!(
    ANGLE,
    "an angle",
    DEG,
    Sign::Any,
    1e-12..36e3,
    "That is more than a hundred turns; write degrees.",
    "180.0"
);
quantity!(
    TOOTH_FACTOR,
    "a factor on what teeth bend",
    NONE,
    Sign::NotNegative,
    1e-6..1e2,
    "1 is what the finite elements of the cell compute.",
    "1.0"
);
quantity!(
    FACTOR,
    "a factor",
    NONE,
    POSITIVE,
    0.1..10.0,
    "It corrects a computed centroid offset and stays near 1.",
    "1.0"
);
quantity!(
    FRICTION,
    "a coefficient of friction",
    NONE,
    Sign::NotNegative,
    1e-300..2.0,
    "Beyond a coefficient of 2 tubes jam.",
    "0.2"
);
quantity!(PART, "the length of a part", MM, Sign::NotNegative, 1e-3..1e4, LENGTH_SLIP, "30.0");
quantity!(
    CURVATURE,
    "a curvature",
    PER_M,
    Sign::Any,
    1e-6..1e4,
    "Is it in another unit? A radius of 100 mm is a curvature of 10 1/m.",
    "10.0"
);
quantity!(
    AXIAL_SPRING,
    "the axial stiffness of a shaft",
    N_MM,
    POSITIVE,
    1e-6..1e9,
    "Is it in another unit? 1 N/m is 0.001 N/mm.",
    "250.0"
);
quantity!(
    TORSION_SPRING,
    "the torsional stiffness of a shaft",
    NMM_DEG,
    POSITIVE,
    1e-9..1e9,
    "Is it in another unit? 1 N m/rad is 17.453 N mm/°.",
    "5.0"
);
quantity!(NUMBER, "the number of a tube", NONE, POSITIVE, 1.0..1e6, "The outermost tube has number 1.", "1");

impl Quantity {
    /// What is wrong with a value in the unit of the quantity, and what to do about it.
    pub fn objection(&self, value: f64) -> Option<(String, String)> {
        let (name, unit, example) = (self.name, self.unit.print, self.example);
        if !value.is_finite() {
            return Some((
                format!("{name} must be a finite number"),
                format!("Write a number such as {example}."),
            ));
        }
        if value < 0.0 && self.sign != Sign::Any {
            let message = format!("{name} cannot be negative, and this is {}{unit}", print(value));
            let floor = if self.sign == POSITIVE { "above 0" } else { "from 0 on" };
            return Some((message, format!("Write a number {floor}, such as {example}.")));
        }
        let size = value.abs();
        if size < f64::MIN_POSITIVE {
            let message =
                || (format!("{name} cannot be zero"), format!("Write a number above 0, such as {example}."));
            return (self.sign == POSITIVE).then(message);
        }
        let (low, high) = self.range;
        if size < low || size > high {
            let (side, bound) = if size < low { ("less", low) } else { ("more", high) };
            let message =
                format!("{}{unit} is {side} than any robot has ({}{unit})", print(value), print(bound));
            return Some((message, self.slip.to_owned()));
        }
        None
    }
}

/// A number as a person writes it: at most six decimals, at least one.
pub(crate) fn print(value: f64) -> String {
    let size = value.abs();
    if size >= 1e7 || (size > 0.0 && size < 1e-4) {
        return format!("{value:e}");
    }
    let text = format!("{value:.6}");
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.to_owned() }
}

/// A length in m, printed in mm.
pub(crate) fn print_mm(metres: f64) -> String {
    format!("{} mm", print(metres * 1e3))
}
