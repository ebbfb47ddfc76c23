//! A value along a tube, as a file writes it: a number, `[base, tip]`, one per notch, or a table over x.
//!
//! Two numbers in a list are always base and tip, also where a pattern has just two notches; such a
//! pattern is written as a table.

use crate::cursor::{Cursor, Entry, Field, kind};
use crate::problems::Collector;
use crate::quantity::{ABSCISSA, ANGLE, Quantity, print, print_mm};
use cppr::design::Profile;
use std::ops::Range;
use toml::de::{DeArray, DeValue};

/// Longest list (numbers): beyond it lies no tube.
const LONGEST: usize = 10_000;

/// How the values lie along the tube.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Spread {
    Constant,
    /// From the baseplate to the tip, linear.
    Ends,
    /// At the middles of the notches.
    PerNotch,
    /// At the given rest abscissae (m).
    Table(Vec<f64>),
}

/// A sound number with its place.
#[derive(Clone, Debug)]
pub(crate) struct Number {
    /// SI, but angles in degrees.
    pub value: f64,
    pub span: Range<usize>,
}

/// A profile whose numbers are sound.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    pub spread: Spread,
    pub numbers: Vec<Number>,
    /// Key and place of the whole.
    pub key: String,
    pub span: Range<usize>,
}

/// Reads a profile. `per_notch` says whether there are notches that a longer list could run over;
/// `length` is the length of the tubes (m), where that is known.
pub(crate) fn read(
    entry: &Entry<'_, '_>,
    quantity: &Quantity,
    per_notch: bool,
    length: Option<f64>,
    out: &mut Collector,
) -> Option<Written> {
    let (spread, numbers) = match entry.value {
        DeValue::Array(items) => {
            let numbers = numbers(entry, items, quantity, out)?;
            let spread = match numbers.len() {
                2 => Spread::Ends,
                _ if per_notch => Spread::PerNotch,
                count => {
                    let message = format!("a list here has two numbers, base and tip, and this has {count}");
                    let help = format!(
                        "Write {} = [base, tip], or a table {{ x_mm = [...], {} = [...] }}.",
                        entry.name, entry.name
                    );
                    entry.wrong(message, help, out);
                    return None;
                }
            };
            (spread, numbers)
        }
        DeValue::Table(_) => table(entry, quantity, length, out)?,
        _ => {
            let value = entry.number(quantity, out)?;
            (Spread::Constant, vec![Number { value, span: entry.span.clone() }])
        }
    };
    Some(Written { spread, numbers, key: entry.key.clone(), span: entry.span.clone() })
}

/// The numbers of a list.
pub(crate) fn numbers(
    entry: &Entry<'_, '_>,
    items: &DeArray<'_>,
    quantity: &Quantity,
    out: &mut Collector,
) -> Option<Vec<Number>> {
    if items.is_empty() || items.len() > LONGEST {
        let message = if items.is_empty() { "the list is empty" } else { "the list is too long" };
        entry.wrong(message, format!("Write from 1 to {LONGEST} numbers."), out);
        return None;
    }
    let read = items.iter().enumerate().map(|(index, item)| {
        let name = entry.name;
        let key = format!("{}, number {}", entry.key, index + 1);
        let item =
            Entry { name, key, span: item.span(), key_span: entry.key_span.clone(), value: item.get_ref() };
        if let DeValue::Integer(_) | DeValue::Float(_) = item.value {
            item.number(quantity, out).map(|value| Number { value, span: item.span })
        } else {
            let message = format!("this must be a number, and it is {}", kind(item.value));
            item.wrong(message, format!("Write a number such as {}.", quantity.example), out);
            None
        }
    });
    // All items are read before the first failure counts, so that every one of them is reported.
    read.collect::<Vec<_>>().into_iter().collect()
}

fn table(
    entry: &Entry<'_, '_>,
    quantity: &Quantity,
    length: Option<f64>,
    out: &mut Collector,
) -> Option<(Spread, Vec<Number>)> {
    let cursor = entry.table(&["x_mm", entry.name], out)?;
    let mut column = |name: &'static str, quantity: &Quantity| -> Option<(Entry<'_, '_>, Vec<Number>)> {
        let help = format!("Write {{ x_mm = [0.0, 150.0], {} = [...] }}.", entry.name);
        let column = cursor.require(name, &help, out)?;
        if let DeValue::Array(items) = column.value {
            let numbers = numbers(&column, items, quantity, out)?;
            Some((column, numbers))
        } else {
            column.wrong(format!("this must be a list, and it is {}", kind(column.value)), help, out);
            None
        }
    };
    let x = column("x_mm", &ABSCISSA);
    let values = column(entry.name, quantity);
    let ((x_entry, x), (value_entry, values)) = (x?, values?);
    let mut sound = true;
    let mut object = |number: &Number, message: String, help: String| {
        out.wrong(number.span.clone(), x_entry.key.clone(), message, help);
        sound = false;
    };
    for pair in x.windows(2) {
        if let [before, after] = pair
            && after.value <= before.value
        {
            let message =
                format!("{} does not lie beyond {} before it", print_mm(after.value), print_mm(before.value));
            object(after, message, "Write the abscissae in increasing order, each once.".to_owned());
        }
    }
    if let Some(length) = length {
        for number in x.iter().filter(|number| number.value > length) {
            let message = format!("{} lies beyond the tip at {}", print_mm(number.value), print_mm(length));
            object(number, message, format!("Write abscissae from 0.0 to {}.", print(length * 1e3)));
        }
    }
    if x.len() != values.len() || x.len() < 2 {
        let message = format!("{} values stand at {} abscissae", values.len(), x.len());
        let help = "Write one value per abscissa, and two or more of them.";
        out.wrong(value_entry.span.clone(), value_entry.key.clone(), message, help);
        return None;
    }
    sound.then(|| (Spread::Table(x.into_iter().map(|n| n.value).collect()), values))
}

impl Written {
    /// The profile, every value mapped by `map`; `middles` are the middles of the notches (m).
    pub fn build(&self, map: impl Fn(f64) -> f64, middles: &[f64], out: &mut Collector) -> Option<Profile> {
        let values: Vec<f64> = self.numbers.iter().map(|number| map(number.value)).collect();
        let profile = match (&self.spread, values.as_slice()) {
            (Spread::Constant, [value, ..]) => return Some(Profile::constant(*value)),
            (Spread::Ends, [base, tip, ..]) => return Some(Profile::linear(*base, *tip)),
            (Spread::Table(x), values) => Profile::table(x, values),
            (_, values) => Profile::per_notch(values, middles),
        };
        profile.map_err(|error| out.wrong(self.span.clone(), self.key.clone(), error.to_string(), "")).ok()
    }

    /// The profile of a quantity that is in SI already.
    pub fn plain(&self, out: &mut Collector) -> Option<Profile> {
        self.build(|value| value, &[], out)
    }
}

/// The direction φ (rad) of the centroid: `opening_deg` and half a turn, plus the turn `twist_deg` from
/// base to tip. The leader's notches open at 180° unless the file says otherwise.
pub(crate) struct Direction {
    opening: Option<Written>,
    twist: Field,
}

impl Direction {
    pub fn read(
        cursor: &Cursor<'_, '_>,
        tube: usize,
        per_notch: bool,
        length: Option<f64>,
        out: &mut Collector,
    ) -> Self {
        let twist = cursor.field("twist_deg", &ANGLE, out);
        let entry = if tube == 1 {
            cursor.get("opening_deg")
        } else {
            let help = "Write the direction that the notches open to, from +Y towards +Z: \
                        opening_deg = 0.0 is opposite to the leader's 180.0.";
            cursor.require("opening_deg", help, out)
        };
        let default = || Written {
            spread: Spread::Constant,
            numbers: vec![Number { value: 180.0, span: cursor.span() }],
            key: cursor.path("opening_deg"),
            span: cursor.span(),
        };
        let opening = match entry {
            Some(entry) => read(&entry, &ANGLE, per_notch, length, out),
            None => (tube == 1 && !cursor.has("opening_deg")).then(default),
        };
        if let (Some(written), Some(entry)) = (&opening, cursor.get("twist_deg"))
            && written.spread != Spread::Constant
        {
            let message = "opening_deg varies along the tube already";
            entry.wrong(message, "Leave twist_deg out, or write opening_deg as one number.", out);
        }
        Self { opening, twist }
    }

    /// What was written under `opening_deg`.
    pub fn opening(&self) -> Option<&Written> {
        self.opening.as_ref()
    }

    pub fn build(&self, middles: &[f64], out: &mut Collector) -> Option<Profile> {
        let opening = self.opening.as_ref()?;
        let first = opening.numbers.first()?.value;
        // The first value is brought into (−180°, 180°], and the others keep their distance from it.
        let start = first + 180.0;
        let shift = start - 360.0 * ((start - 180.0) / 360.0).ceil() - first;
        let twist = self.twist.value.unwrap_or_default();
        if twist.abs() > 0.0 {
            let base = first + shift;
            return Some(Profile::linear(base.to_radians(), (base + twist).to_radians()));
        }
        opening.build(|value| (value + shift).to_radians(), middles, out)
    }
}
