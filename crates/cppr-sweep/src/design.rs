//! Numbers of a robot file that vary: finding them by their keys, and the robot with other values.
//!
//! `tube2.notches.depth_mm` is the key `depth_mm` under `[tube.notches]` of the second `[[tube]]`;
//! `material.youngs_modulus_GPa` and `length_mm` stand outside the tubes. A number behind a dot picks an entry of a list,
//! from 0: `tube1.notches.depth_mm.0`. Parts and joints have numbers from 1: `tube1.part2.length_mm`, `joint1.at_mm.0`.

use cppr::bundle::{Bundle, BundleDesign, Friction};
use cppr::design::{DesignProblems, Robot};
use cppr_io::{Problem, Problems};
use std::fmt;
use toml::{Table, Value};

/// Why a key cannot be varied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KeyProblem {
    /// The file has no such key: the key, and what is there instead.
    Missing(String, String),
    /// What the key holds is no number: the key, and what it is.
    NotANumber(String, &'static str),
    /// The text is not TOML.
    Syntax(String),
}

impl fmt::Display for KeyProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(key, there) => write!(f, "the robot file has no {key}; {there}"),
            Self::NotANumber(key, what) => write!(
                f,
                "{key} is {what} in the robot file, not a number; entries of a list are picked by their place, {key}.0 is the first"
            ),
            Self::Syntax(message) => write!(f, "the robot file is not TOML: {message}"),
        }
    }
}

impl std::error::Error for KeyProblem {}

/// A robot file some of whose numbers vary.
#[derive(Clone, Debug)]
pub struct DesignKeys {
    file: Table,
    keys: Vec<Vec<String>>,
}

impl DesignKeys {
    /// Finds the keys in the text of a robot file.
    ///
    /// # Errors
    /// The first key that is not there or holds no number.
    pub fn new(text: &str, keys: &[&str]) -> Result<Self, KeyProblem> {
        let file: Table =
            text.parse().map_err(|e: toml::de::Error| KeyProblem::Syntax(e.message().into()))?;
        let mut own = Self { file, keys: Vec::new() };
        for key in keys {
            let path = path_of(key);
            match find(&mut own.file, &path) {
                Ok(Value::Float(_) | Value::Integer(_)) => own.keys.push(path),
                Ok(other) => return Err(KeyProblem::NotANumber((*key).into(), kind(other))),
                Err(there) => return Err(KeyProblem::Missing((*key).into(), there)),
            }
        }
        Ok(own)
    }

    /// Values of the keys, in the order they were given.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        let mut file = self.file.clone();
        let mut number = |path: &Vec<String>| match find(&mut file, path) {
            Ok(Value::Float(value)) => *value,
            #[allow(clippy::cast_precision_loss)]
            Ok(Value::Integer(value)) => *value as f64,
            _ => f64::NAN,
        };
        self.keys.iter().map(&mut number).collect()
    }

    /// The robot with these values of the keys, or every reason why there is none.
    ///
    /// # Errors
    /// The problems as one text.
    pub fn robot(&mut self, values: &[f64]) -> Result<Robot, String> {
        let file = cppr_io::robot_file::parse(&self.text(values)).map_err(|problems| told(&problems))?;
        Robot::from_design(file.design).map_err(|list| unsound(&list))
    }

    /// The same of a robot with parts or joints, and how its tubes rub.
    ///
    /// # Errors
    /// As [`Self::robot`].
    pub fn bundle(&mut self, values: &[f64]) -> Result<(Bundle, BundleDesign, Option<Friction>), String> {
        let own =
            cppr_io::bundle_file::parse_either(&self.text(values)).map_err(|problems| told(&problems))?;
        let (friction, design) = (own.friction(), own.into_bundle());
        let bundle = Bundle::new(&design).map_err(|list| unsound(&list))?;
        Ok((bundle, design, friction))
    }

    /// The file with these values.
    fn text(&mut self, values: &[f64]) -> String {
        for (path, value) in self.keys.iter().zip(values) {
            if let Ok(target) = find(&mut self.file, path) {
                // Where a whole number is written, as for the count of notches, one is wanted.
                *target = match target {
                    Value::Integer(_) if value.fract().abs() <= 0.0 && value.abs() < 1e15 => {
                        #[allow(clippy::cast_possible_truncation)]
                        let whole = *value as i64;
                        Value::Integer(whole)
                    }
                    _ => Value::Float(*value),
                };
            }
        }
        self.file.to_string()
    }
}

/// Problems without lines and excerpts, which would be those of a text that nobody wrote.
fn told(problems: &Problems) -> String {
    let each = |p: &Problem| format!("{}: {}. {}", p.key, p.message, p.help).trim().to_owned();
    problems.list.iter().map(each).collect::<Vec<_>>().join(" ")
}

fn unsound(list: &DesignProblems) -> String {
    list.0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Lists whose entries have numbers from 1, and how deep in the file they stand.
const LISTS: [(&str, usize); 3] = [("tube", 0), ("joint", 0), ("part", 2)];

/// `tube2.part1.x` is entry 0 of the list `part` of entry 1 of the list `tube`.
fn path_of(key: &str) -> Vec<String> {
    let mut path: Vec<String> = Vec::new();
    for part in key.split('.') {
        let entry = LISTS.into_iter().find_map(|(name, depth)| {
            let number = part.strip_prefix(name)?.parse::<usize>().ok()?;
            Some((name, number.checked_sub(1).filter(|_| path.len() == depth)?))
        });
        match entry {
            Some((name, index)) => path.extend([name.to_owned(), index.to_string()]),
            None => path.push(part.to_owned()),
        }
    }
    path
}

/// The value at a path, or what is there where it ends.
fn find<'a>(file: &'a mut Table, path: &[String]) -> Result<&'a mut Value, String> {
    let (first, rest) = path.split_first().ok_or("the key is empty")?;
    let known = listed(file);
    let mut at = file.get_mut(first).ok_or(known)?;
    for part in rest {
        let known = match at {
            Value::Table(table) => listed(table),
            Value::Array(list) => format!("its list ends with {}", list.len()),
            _ => "there is nothing below it".to_owned(),
        };
        let next = match at {
            Value::Table(table) => table.get_mut(part),
            Value::Array(list) => part.parse::<usize>().ok().and_then(|index| list.get_mut(index)),
            _ => None,
        };
        at = next.ok_or(known)?;
    }
    Ok(at)
}

fn listed(table: &Table) -> String {
    let names: Vec<String> = table
        .iter()
        .map(|(name, value)| match value {
            Value::Array(list) if LISTS.iter().any(|(own, _)| own == name) => {
                format!("{name}1 to {name}{}", list.len())
            }
            _ => name.clone(),
        })
        .collect();
    format!("there are {}", names.join(", "))
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Table(_) => "a table",
        Value::Boolean(_) => "true or false",
        _ => "something else",
    }
}
