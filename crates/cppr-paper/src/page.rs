//! One page of the report as data.

use crate::scenario::Stated;
use crate::{PaperError, Scenario};
use cppr_plot::Figure;

/// A table of text cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Heads of the columns, with units.
    pub head: Vec<String>,
    /// Rows of cells, as many as heads.
    pub rows: Vec<Vec<String>>,
}

/// A page: text, figures, tables, and every number it rests on.
#[derive(Clone, Debug)]
pub struct Page {
    /// Anchor and prefix of file names.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Section of the paper.
    pub section: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// File name without ending, caption, figure.
    pub figures: Vec<(String, String, Figure)>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Key (with unit) and value, in the order in which they were found.
    pub numbers: Vec<(String, f64)>,
}

impl Page {
    pub(crate) fn new(name: &str, scenario: &Scenario) -> Self {
        Self {
            name: name.into(),
            title: scenario.title.clone(),
            section: scenario.section.clone(),
            text: vec![scenario.text.clone()],
            figures: Vec::new(),
            tables: Vec::new(),
            numbers: Vec::new(),
        }
    }

    pub(crate) fn figure(&mut self, suffix: &str, caption: impl Into<String>, figure: Figure) {
        let name = if suffix.is_empty() { self.name.clone() } else { format!("{}-{suffix}", self.name) };
        self.figures.push((name, caption.into(), figure));
    }

    pub(crate) fn table(&mut self, caption: impl Into<String>, head: &[&str], rows: Vec<Vec<String>>) {
        let head = head.iter().map(|h| (*h).to_owned()).collect();
        self.tables.push(Table { caption: caption.into(), head, rows });
    }

    /// What the paper states beside what was found.
    pub(crate) fn stated(&mut self, list: &[Stated]) -> Result<(), PaperError> {
        if list.is_empty() {
            return Ok(());
        }
        let mut rows = Vec::new();
        for stated in list {
            let [here, difference] = match &stated.number {
                Some(key) => {
                    let (_, own) = self.numbers.iter().find(|(k, _)| k == key).ok_or_else(|| {
                        PaperError(format!("{}: there is no number {key} to compare with", self.name))
                    })?;
                    [cell(*own, 3), cell(own - stated.value, 3)]
                }
                None => ["needs the measurements".into(), "–".into()],
            };
            let value = format!("{}", stated.value).replace('-', "−");
            rows.push(vec![stated.what.clone(), stated.unit.clone(), value, here, difference]);
        }
        self.table(
            "What the paper states, and what is found here.",
            &["quantity", "unit", "paper", "here", "difference"],
            rows,
        );
        Ok(())
    }

    pub(crate) fn number(&mut self, key: impl Into<String>, value: f64) {
        self.numbers.push((key.into(), value));
    }
}

/// A number as a cell; −0.000 is 0.000.
pub(crate) fn cell(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.into(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}
