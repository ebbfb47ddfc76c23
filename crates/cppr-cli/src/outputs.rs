//! What sub-commands that solve have in common: their `--json`, `--csv` and `--plot`, and the table for people.

use crate::Failure;
use crate::figure::{self, Format};
use crate::output::{self, is_stdout, note, print};
use cppr_plot::Figure;
use std::path::Path;

/// Where results go.
pub struct Outputs<'a> {
    pub json: Option<&'a Path>,
    pub csv: Option<&'a Path>,
    pub plot: Option<(&'a Path, Format)>,
}

impl<'a> Outputs<'a> {
    /// Checks all of them before anything is solved, see [`output::check`]. A sub-command gives `None` for what it has not.
    pub fn new(robot: &Path, [json, csv, plot]: [Option<&'a Path>; 3]) -> Result<Self, Failure> {
        let format = plot.map(figure::format).transpose()?;
        let outputs = Self { json, csv, plot: plot.zip(format) };
        outputs.spare(robot)?;
        Ok(outputs)
    }

    /// Refuses to write over a file that is read.
    pub fn spare(&self, read: &Path) -> Result<(), Failure> {
        let plot = self.plot.map(|(path, _)| path);
        output::check(read, &[("--json", self.json), ("--csv", self.csv), ("--plot", plot)])
    }

    /// Draws the figure, where one is wanted.
    pub fn draw(&self, figure: impl FnOnce() -> Result<Figure, Failure>) -> Result<(), Failure> {
        match self.plot {
            Some((path, format)) => figure::write(path, format, &figure()?),
            None => Ok(()),
        }
    }

    /// Prints a table for people; where results take standard output, to standard error.
    pub fn report(&self, table: &str) -> Result<(), Failure> {
        if [self.json, self.csv].into_iter().flatten().any(is_stdout) {
            note(table);
            Ok(())
        } else {
            print(table)
        }
    }
}
