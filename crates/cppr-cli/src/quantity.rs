//! Values with units as they are typed: `5mm`, `-0.5N`, `30deg`, `0,0,-0.5N`. All become SI.

use cppr::solve::{Freedom, Quantity};

/// What a value measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// m
    Length,
    /// rad
    Angle,
    /// N
    Force,
    /// N m
    Moment,
    /// N/m
    ForcePerLength,
    /// m/s²
    Acceleration,
}

impl Kind {
    /// What a motion or an effort of an actuator measures.
    pub fn of(quantity: Quantity) -> Self {
        match (quantity.freedom, quantity.is_motion) {
            (Freedom::PushPull, true) => Self::Length,
            (Freedom::PushPull, false) => Self::Force,
            (Freedom::Rotation, true) => Self::Angle,
            (Freedom::Rotation, false) => Self::Moment,
        }
    }

    /// Units with their SI values; the first is the one suggested.
    fn units(self) -> &'static [(&'static str, f64)] {
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        match self {
            Self::Length => &[("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("µm", 1e-6), ("m", 1.0)],
            Self::Angle => &[("deg", DEGREE), ("°", DEGREE), ("rad", 1.0)],
            Self::Force => &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3)],
            Self::Moment => &[("Nmm", 1e-3), ("mNm", 1e-3), ("Nm", 1.0)],
            Self::ForcePerLength => &[("N/m", 1.0), ("mN/m", 1e-3), ("N/mm", 1e3)],
            Self::Acceleration => &[("m/s2", 1.0), ("m/s²", 1.0), ("g", 9.81)],
        }
    }

    /// Greatest magnitude (SI) that is no slip of the unit or the exponent; far from overflow.
    fn largest(self) -> f64 {
        match self {
            Self::Length => 1e3,
            // A hundred turns.
            Self::Angle => std::f64::consts::TAU * 100.0,
            Self::Force | Self::Moment | Self::ForcePerLength | Self::Acceleration => 1e9,
        }
    }

    /// Units, the longer names first.
    fn by_length(self) -> Vec<(&'static str, f64)> {
        let mut units = self.units().to_vec();
        units.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
        units
    }

    /// The unit that a value or a range carries behind its last number.
    fn unit_of(self, text: &str) -> Option<&'static str> {
        let last = text.rsplit_once(':').map_or(text, |(value, _)| value).trim_end();
        self.by_length().into_iter().map(|(name, _)| name).find(|name| last.ends_with(name))
    }

    /// Splits a text into number and unit; the unit's SI value.
    fn split(self, text: &str) -> Option<(f64, f64)> {
        self.by_length().iter().find_map(|(name, value)| {
            let number = text.strip_suffix(name)?.trim_end().parse::<f64>().ok()?;
            Some((number, *value))
        })
    }

    fn known(self) -> String {
        self.units().iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
    }
}

fn believable(value: f64, text: &str, kind: Kind) -> Result<f64, String> {
    if !value.is_finite() {
        Err(format!("{text} is not a finite number"))
    } else if value.abs() > kind.largest() {
        let (name, unit) = kind.units()[0];
        Err(format!(
            "{text} is more than any robot meets, at most {:e}{name}: check it",
            kind.largest() / unit
        ))
    } else {
        Ok(value)
    }
}

/// One value with its unit.
pub fn scalar(text: &str, kind: Kind) -> Result<f64, String> {
    let text = text.trim();
    if let Some((number, unit)) = kind.split(text) {
        return believable(number * unit, text, kind);
    }
    if text.is_empty() {
        return Err(format!("the value is missing: write for instance 5{}", kind.units()[0].0));
    }
    Err(match text.parse::<f64>() {
        Ok(number) if number.is_finite() => {
            format!("{text} has no unit: write for instance {text}{}", kind.units()[0].0)
        }
        Ok(_) => format!("{text} is not a finite number"),
        Err(_) => format!("{text} is not a number with a unit; known units here: {}", kind.known()),
    })
}

/// Three values: one unit behind the last serves all, or each has its own.
pub fn vector(text: &str, kind: Kind) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [x, y, z] = parts[..] else {
        return Err(format!(
            "{text} has {} components: write three, for instance 0,0,-0.5{}",
            parts.len(),
            kind.units()[0].0
        ));
    };
    let last = scalar(z, kind)?;
    let shared = kind.split(z).map_or(1.0, |(_, unit)| unit);
    let component = |part: &str| match part.parse::<f64>() {
        Ok(number) => believable(number * shared, part, kind),
        Err(_) => scalar(part, kind),
    };
    Ok([component(x)?, component(y)?, last])
}

/// One value, or a range of them: `-7..7mm:141`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// One value (SI).
    Fixed(f64),
    /// From the smaller to the larger (SI); how many, where that is said.
    Range(f64, f64, Option<u32>),
}

/// Reads ends and count of a range; `read` reads an end, given the text of the other for its unit.
fn range(text: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<Span, String> {
    let Some((from, rest)) = text.split_once("..") else { return read(text).map(Span::Fixed) };
    let (to, count) = match rest.rsplit_once(':') {
        None => (rest, None),
        Some((to, count)) => match count.trim().parse::<u32>() {
            Ok(count) if count >= 2 => (to, Some(count)),
            Ok(count) => {
                return Err(format!("{text} has a count of {count}: a range takes at least its two ends"));
            }
            Err(_) => return Err(format!("{count} is no count: write for instance {from}..{to}:11")),
        },
    };
    // The last first: it carries the unit.
    let (last, first) = (read(to)?, read(from)?);
    if first < last {
        Ok(Span::Range(first, last, count))
    } else {
        Err(format!("{text} does not lead upwards: write the smaller value first, or one value alone"))
    }
}

/// Reads `VALUE`, `FROM..TO` or `FROM..TO:COUNT`; the unit behind the last value serves both.
pub fn span(text: &str, kind: Kind) -> Result<Span, String> {
    span_with(text, kind, "")
}

/// The same, where `unit` serves values without one.
fn span_with(text: &str, kind: Kind, unit: &str) -> Result<Span, String> {
    let unit = kind.unit_of(text).unwrap_or(unit);
    range(text, |value| match value.trim().parse::<f64>() {
        Ok(_) => scalar(&format!("{value}{unit}"), kind),
        Err(_) => scalar(value, kind),
    })
}

/// Reads `[K=]VALUE` or `[K=]VALUE..VALUE..VALUE`, where K may be tube 1; the unit behind the last value serves all.
pub fn path_for_any_tube(text: &str, kind: Kind) -> Result<ForTube<Vec<f64>>, String> {
    for_tube_from(1, text, |values| {
        let Some(unit) = kind.unit_of(values) else {
            return scalar(values.rsplit("..").next().unwrap_or_default(), kind).map(|value| vec![value]);
        };
        let each = values.split("..").map(|value| match value.trim().parse::<f64>() {
            Ok(_) => scalar(&format!("{value}{unit}"), kind),
            Err(_) => scalar(value, kind),
        });
        each.collect()
    })
}

/// Three values or ranges: one unit behind the last serves all, or each has its own.
pub fn span_vector(text: &str, kind: Kind) -> Result<[Span; 3], String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [x, y, z] = parts[..] else { return vector(text, kind).map(|v| v.map(Span::Fixed)) };
    let unit = kind.unit_of(z).unwrap_or_default();
    Ok([span_with(x, kind, unit)?, span_with(y, kind, unit)?, span_with(z, kind, unit)?])
}

/// Numbers without unit: one value or a range.
pub fn bare_span(text: &str) -> Result<Span, String> {
    range(text, |value| match value.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("{value} is not a finite number")),
        Err(_) => Err(format!("{value} is not a number; the unit is that of the key")),
    })
}

/// A value for one tube: `K=VALUE`, or `VALUE` for tube 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForTube<T = f64> {
    /// Tube number as in the paper.
    pub tube: usize,
    /// Value in SI.
    pub value: T,
}

/// Reads `[K=]VALUE`.
pub fn for_tube(text: &str, kind: Kind) -> Result<ForTube, String> {
    for_tube_with(text, |value| scalar(value, kind))
}

/// Reads `[K=]VALUE` or `[K=]FROM..TO:COUNT`.
pub fn span_for_tube(text: &str, kind: Kind) -> Result<ForTube<Span>, String> {
    for_tube_with(text, |value| span(value, kind))
}

/// Reads `[K=]VALUE`, where K may be tube 1, which can be driven in a robot with parts or joints.
pub fn for_any_tube(text: &str, kind: Kind) -> Result<ForTube, String> {
    for_tube_from(1, text, |value| scalar(value, kind))
}

/// Reads `[K=]VALUE` or `[K=]FROM..TO:COUNT`, where K may be tube 1.
pub fn span_for_any_tube(text: &str, kind: Kind) -> Result<ForTube<Span>, String> {
    for_tube_from(1, text, |value| span(value, kind))
}

fn for_tube_with<T>(text: &str, read: impl Fn(&str) -> Result<T, String>) -> Result<ForTube<T>, String> {
    for_tube_from(2, text, read)
}

/// Tubes from number `first` on.
fn for_tube_from<T>(
    first: usize,
    text: &str,
    read: impl Fn(&str) -> Result<T, String>,
) -> Result<ForTube<T>, String> {
    let Some((tube, value)) = text.split_once('=') else {
        return Ok(ForTube { tube: 2, value: read(text)? });
    };
    match tube.trim().parse::<usize>() {
        Ok(1) if first > 1 => {
            Err("tube 1 is the leader, which is fixed in the baseplate: followers begin at 2".into())
        }
        Ok(tube) if tube >= first => Ok(ForTube { tube, value: read(value)? }),
        _ => Err(format!("{tube} is no tube number: write for instance 2={value}")),
    }
}

/// Reads `[K=]LOW..HIGH`.
pub fn bounds(text: &str, kind: Kind) -> Result<ForTube<[f64; 2]>, String> {
    let read = span_for_tube(text, kind)?;
    match read.value {
        Span::Range(low, high, None) => Ok(ForTube { tube: read.tube, value: [low, high] }),
        _ => Err(format!("write least and greatest value, for instance 2=-5..5{}", kind.units()[0].0)),
    }
}

/// Three numbers without unit that are not all zero.
pub fn direction(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<Option<f64>> = text
        .split(',')
        .map(|p| p.trim().parse().ok().filter(|v: &f64| v.is_finite() && v.abs() < 1e9))
        .collect();
    match parts[..] {
        [Some(x), Some(y), Some(z)] if x.hypot(y).hypot(z) > 0.0 => Ok([x, y, z]),
        [Some(_), Some(_), Some(_)] => Err("a direction of length 0 points nowhere".into()),
        _ => {
            Err(format!("{text} is no direction: write three numbers without unit, for instance 0.8,-0.6,0"))
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)]
mod tests {
    use super::{
        Kind, Span, bare_span, bounds, direction, for_tube, path_for_any_tube, scalar, span, span_for_tube,
        span_vector, vector,
    };

    #[test]
    fn units_become_si() {
        let close = |text: &str, kind, want: f64| {
            let got = scalar(text, kind).unwrap();
            assert!((got - want).abs() <= 1e-15 * want.abs(), "{text}: {got}");
        };
        close("5mm", Kind::Length, 5e-3);
        close("-2.5e1 um", Kind::Length, -25e-6);
        close("1e-3m", Kind::Length, 1e-3);
        close("180deg", Kind::Angle, std::f64::consts::PI);
        close("20Nmm", Kind::Moment, 0.02);
        close("500mN", Kind::Force, 0.5);
        close("-1g", Kind::Acceleration, -9.81);
        assert_eq!(vector("0,1,-0.5N", Kind::Force).unwrap(), [0.0, 1.0, -0.5]);
        assert_eq!(vector("1mm, 2cm,3 mm", Kind::Length).unwrap(), [1e-3, 2e-2, 3e-3]);
        let range = bounds("3=-5..7.5mm", Kind::Length).unwrap();
        assert_eq!((range.tube, range.value), (3, [-5e-3, 7.5e-3]));
        let turned = bounds("-1rad..90deg", Kind::Angle).unwrap();
        assert_eq!((turned.tube, turned.value[0]), (2, -1.0));
        assert_eq!(direction("0, -2,1e-3").unwrap(), [0.0, -2.0, 1e-3]);
        let third = for_tube("3=-1mm", Kind::Length).unwrap();
        assert_eq!((third.tube, third.value), (3, -1e-3));
    }

    #[test]
    fn ranges_share_the_unit_behind() {
        assert_eq!(span("5mm", Kind::Length), Ok(Span::Fixed(5e-3)));
        assert_eq!(span("-7..7mm:141", Kind::Length), Ok(Span::Range(-7e-3, 7e-3, Some(141))));
        assert_eq!(span("-700um..1 cm", Kind::Length), Ok(Span::Range(-700e-6, 1e-2, None)));
        assert_eq!(span("1e-3..2e-3m:2", Kind::Length), Ok(Span::Range(1e-3, 2e-3, Some(2))));
        let third = span_for_tube("3=0..1N:5", Kind::Force).unwrap();
        assert_eq!((third.tube, third.value), (3, Span::Range(0.0, 1.0, Some(5))));
        let [x, y, z] = span_vector("0,-1..1:3,0.5N", Kind::Force).unwrap();
        assert_eq!([x, y, z], [Span::Fixed(0.0), Span::Range(-1.0, 1.0, Some(3)), Span::Fixed(0.5)]);
        let [_, _, z] = span_vector("0,0,-500..500mN:3", Kind::Force).unwrap();
        assert_eq!(z, Span::Range(-0.5, 0.5, Some(3)));
        assert_eq!(bare_span("4.8..5.2:9"), Ok(Span::Range(4.8, 5.2, Some(9))));
        for (text, part) in [
            ("-7..7:141", "7 has no unit"),
            ("7..-7mm:3", "the smaller value first"),
            ("7..7mm:3", "the smaller value first"),
            ("0..1mm:0", "a count of 0"),
            ("0..1mm:1", "a count of 1"),
            ("0..1mm:x", "x is no count"),
            ("0..nanmm:3", "not a finite number"),
            ("0..1N:3", "known units here: mm"),
            ("..1mm:3", "the value is missing"),
        ] {
            let message = span(text, Kind::Length).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        assert!(span_vector("0,1..2N:2", Kind::Force).unwrap_err().contains("2 components"));
        assert!(bare_span("1mm").unwrap_err().contains("the unit is that of the key"));
    }

    #[test]
    fn paths_turn_back() {
        let path = path_for_any_tube("3=0..7..-7..7mm", Kind::Length).unwrap();
        assert_eq!((path.tube, path.value), (3, vec![0.0, 7e-3, -7e-3, 7e-3]));
        assert_eq!(path_for_any_tube("4mm", Kind::Length).unwrap().value, [4e-3]);
        assert!(path_for_any_tube("0..7", Kind::Length).unwrap_err().contains("7 has no unit"));
        assert!(path_for_any_tube("0....7mm", Kind::Length).unwrap_err().contains("missing"));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let says = |text: &str, kind, part: &str| {
            let message = scalar(text, kind).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        };
        says("5", Kind::Length, "write for instance 5mm");
        says("5N", Kind::Length, "known units here: mm");
        says("nanmm", Kind::Length, "not a finite number");
        says("inf", Kind::Force, "not a finite number");
        says("", Kind::Force, "the value is missing: write for instance 5N");
        says("1e300m", Kind::Length, "at most 1e6mm");
        says("1e20rad", Kind::Angle, "at most 3.6e4deg");
        assert!(vector("0,1e300,2N", Kind::Force).unwrap_err().contains("at most 1e9N"));
        assert!(vector("0,1N", Kind::Force).unwrap_err().contains("2 components"));
        assert!(vector("0,1,2", Kind::Force).unwrap_err().contains("2N"));
        assert!(bounds("5mm", Kind::Length).unwrap_err().contains("2=-5..5mm"));
        assert!(bounds("5..1mm", Kind::Length).unwrap_err().contains("the smaller value first"));
        assert!(bounds("1=1..2mm", Kind::Length).unwrap_err().contains("leader"));
        assert!(bounds("1..2", Kind::Angle).unwrap_err().contains("no unit"));
        assert!(direction("0,0,0").unwrap_err().contains("points nowhere"));
        assert!(direction("1,2").unwrap_err().contains("three numbers"));
        assert!(direction("1,nan,2").unwrap_err().contains("three numbers"));
        assert!(for_tube("1=3mm", Kind::Length).unwrap_err().contains("leader"));
        assert!(for_tube("x=3mm", Kind::Length).unwrap_err().contains("tube number"));
    }
}
