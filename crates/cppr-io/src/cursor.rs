//! Reading a TOML table by hand: every value keeps its place, and reading goes on after a problem.
//!
//! A value that is absent or wrong reads as `None`. Whoever needs it gives up on what it was for, and
//! reports nothing more: the problem is already in the [`Collector`].

use crate::keys::{guess, list};
use crate::problems::Collector;
use crate::quantity::Quantity;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// A table with its place and the path that leads to it.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'a, 'i> {
    table: &'a DeTable<'i>,
    /// The header or key that opens the table.
    span: Range<usize>,
    /// What messages put before a key, such as `tube 2, notches.`.
    path: String,
    /// Known keys that an unknown key was taken for: they are misspelt, not missing.
    misspelt: Vec<&'static str>,
}

/// A value with its place.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a, 'i> {
    /// Its key without the path.
    pub name: &'static str,
    /// Its key with the path.
    pub key: String,
    /// Place of the value.
    pub span: Range<usize>,
    /// Place of the key.
    pub key_span: Range<usize>,
    pub value: &'a DeValue<'i>,
}

/// A key that may be there: whether it is, and its value where that is sound.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Field {
    pub present: bool,
    pub value: Option<f64>,
}

impl<'a, 'i> Cursor<'a, 'i> {
    /// Takes a table and reports the keys that are not among the known ones.
    pub fn new(
        table: &'a DeTable<'i>,
        span: Range<usize>,
        path: String,
        known: &[&'static str],
        out: &mut Collector,
    ) -> Self {
        let mut misspelt = Vec::new();
        for (key, value) in table.iter().filter(|(key, _)| !known.contains(&key.get_ref().as_ref())) {
            let found = guess(key.get_ref(), plain_number(value.get_ref()), known);
            misspelt.extend(found.meant);
            let shown: String = key.get_ref().chars().filter(|c| !c.is_control()).take(60).collect();
            out.wrong(key.span(), format!("{path}{shown}"), found.message, found.help);
        }
        Self { table, span, path, misspelt }
    }

    /// The path with a key at its end.
    pub fn path(&self, key: &str) -> String {
        format!("{}{key}", self.path)
    }

    /// Place of the header.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// True where the key is there, if only misspelt.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key) || self.misspelt.contains(&key)
    }

    /// The value under a key.
    pub fn get(&self, key: &'static str) -> Option<Entry<'a, 'i>> {
        let (name, value) = self.table.get_key_value(key)?;
        Some(Entry {
            name: key,
            key: self.path(key),
            span: value.span(),
            key_span: name.span(),
            value: value.get_ref(),
        })
    }

    /// The value under a key that must be there; `help` says what to write.
    pub fn require(&self, key: &'static str, help: &str, out: &mut Collector) -> Option<Entry<'a, 'i>> {
        if !self.has(key) {
            out.missing(self.span(), self.path(key), "this key is missing", help);
        }
        self.get(key)
    }

    /// The number under a key, in SI.
    pub fn field(&self, key: &'static str, quantity: &Quantity, out: &mut Collector) -> Field {
        let value = self.get(key).and_then(|entry| entry.number(quantity, out));
        Field { present: self.has(key), value }
    }

    /// The number under a key that must be there, in SI.
    pub fn number(&self, key: &'static str, quantity: &Quantity, out: &mut Collector) -> Option<f64> {
        let help = format!("Write {key} = {}.", quantity.example);
        self.require(key, &help, out)?.number(quantity, out)
    }

    /// The table under a key.
    pub fn child(
        &self,
        key: &'static str,
        known: &[&'static str],
        out: &mut Collector,
    ) -> Option<Cursor<'a, 'i>> {
        self.get(key)?.table(known, out)
    }
}

impl<'a, 'i> Entry<'a, 'i> {
    /// Reports a problem of this value.
    pub fn wrong(&self, message: impl Into<String>, help: impl Into<String>, out: &mut Collector) {
        out.wrong(self.span.clone(), self.key.clone(), message, help);
    }

    /// Reports that the value is of another kind than wanted.
    fn mistyped(&self, wanted: &str, help: String, out: &mut Collector) {
        self.wrong(format!("this must be {wanted}, and it is {}", kind(self.value)), help, out);
    }

    /// A number, in SI.
    pub fn number(&self, quantity: &Quantity, out: &mut Collector) -> Option<f64> {
        let Some(number) = plain_number(self.value) else {
            // Half of all strings in place of numbers are a number with its unit.
            let quoted = self.value.as_str().and_then(leading_number);
            let example = quoted.unwrap_or(quantity.example);
            let end = if quantity.unit.suffix.is_empty() { "" } else { "; the unit is in the key" };
            self.mistyped("a number", format!("Write {} = {example}{end}.", self.name), out);
            return None;
        };
        if let Some((message, help)) = quantity.objection(number) {
            self.wrong(message, help, out);
            return None;
        }
        Some(quantity.unit.to_si(number))
    }

    /// A whole number from 1 to `most`.
    pub fn count(&self, most: u32, out: &mut Collector) -> Option<u32> {
        let number = match self.value {
            DeValue::Integer(integer) => u32::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        let number = number.filter(|n| (1..=most).contains(n));
        if number.is_none() {
            let message = format!("this must be a whole number from 1 to {most}");
            self.wrong(message, format!("Write {} = 15, or leave it out.", self.name), out);
        }
        number
    }

    /// A text.
    pub fn text(&self, help: &str, out: &mut Collector) -> Option<&'a str> {
        let text = self.value.as_str();
        if text.is_none() {
            self.mistyped("a text in quotes", help.to_owned(), out);
        }
        text
    }

    /// One of the given words.
    pub fn word(&self, words: &[&'static str], out: &mut Collector) -> Option<&'static str> {
        let quoted: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
        let known = list(&quoted.iter().map(String::as_str).collect::<Vec<_>>());
        let example = format!("Write {} = \"{}\".", self.name, words.first().copied().unwrap_or_default());
        let text = self.text(&format!("{example} Known are {known}."), out)?;
        let found = words.iter().copied().find(|word| *word == text);
        if found.is_none() {
            let help = match guess(text, None, words).meant {
                Some(meant) => format!("Did you mean \"{meant}\"? Known are {known}."),
                None => format!("Known are {known}."),
            };
            self.wrong("this word is not known here", help, out);
        }
        found
    }

    /// A table, whose keys go on where this key ends.
    pub fn table(&self, known: &[&'static str], out: &mut Collector) -> Option<Cursor<'a, 'i>> {
        match self.value {
            DeValue::Table(table) => {
                Some(Cursor::new(table, self.key_span.clone(), format!("{}.", self.key), known, out))
            }
            other => {
                let help = if is_list_of_tables(other) {
                    "Write its header in single brackets: there is only one of it.".to_owned()
                } else {
                    format!("It holds {}.", list(known))
                };
                self.mistyped("a table", help, out);
                None
            }
        }
    }
}

impl<'a, 'i> Entry<'a, 'i> {
    /// The tables of a list such as `[[joint]]`; `name` gives what messages put before the keys of number `n` (from 1).
    pub fn tables(
        &self,
        header: &str,
        name: impl Fn(usize) -> String,
        known: &[&'static str],
        out: &mut Collector,
    ) -> Vec<Cursor<'a, 'i>> {
        let help = format!("Write {header} tables.");
        match self.value {
            DeValue::Table(table) => {
                let message = "the header stands in single brackets";
                out.wrong(self.key_span.clone(), self.key.clone(), message, format!("Write {header}."));
                vec![Cursor::new(table, self.key_span.clone(), name(1), known, out)]
            }
            DeValue::Array(items) => {
                let mut cursors = Vec::new();
                for (index, item) in items.iter().enumerate() {
                    if let DeValue::Table(table) = item.get_ref() {
                        cursors.push(Cursor::new(table, item.span(), name(index + 1), known, out));
                    } else {
                        let message =
                            format!("this must be a {header} table, and it is {}", kind(item.get_ref()));
                        out.wrong(item.span(), self.key.clone(), message, help.clone());
                    }
                }
                cursors
            }
            other => {
                self.wrong(format!("this must be {header} tables, and it is {}", kind(other)), help, out);
                Vec::new()
            }
        }
    }
}

fn is_list_of_tables(value: &DeValue<'_>) -> bool {
    value.as_array().is_some_and(|items| items.iter().any(|item| item.get_ref().is_table()))
}

/// The number of an integer or float, in whatever base it is written.
pub(crate) fn plain_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            u32::from_str_radix(integer.as_str(), integer.radix()).ok().map(f64::from)
        }
        _ => None,
    }
}

/// The number that a text begins with.
fn leading_number(text: &str) -> Option<&str> {
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.' && c != '-').unwrap_or(text.len());
    let number = text.get(..end)?;
    number.parse::<f64>().ok().map(|_| number)
}

/// What kind of value this is, in words.
pub(crate) fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}
