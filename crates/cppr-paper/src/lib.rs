//! What Tummers et al. 2024 compute, computed again in both formulations, with the numbers that the paper states
//! beside ours.
//!
//! Each page has a scenario file under `paper/` in the repository, which is part of the program. [`pages`] lists
//! them, [`Job::run`] computes one, [`html`] makes the report of all.

mod assumptions;
mod bench;
mod differences;
mod html;
mod page;
mod planar;
mod printed;
mod scenario;
mod space;
mod strength;
mod tables;

pub use html::html;
pub use page::{Page, Table};
pub use scenario::Scenario;

/// Why a page could not be made.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperError(String);

impl std::fmt::Display for PaperError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for PaperError {}

impl From<cppr_plot::PlotError> for PaperError {
    fn from(error: cppr_plot::PlotError) -> Self {
        Self(error.to_string())
    }
}

/// A page that is still to be computed.
pub struct Job {
    /// File name of the scenario, without ending; also the page's anchor.
    pub name: &'static str,
    text: &'static str,
    make: fn(&Scenario, &mut Page) -> Result<(), PaperError>,
}

impl Job {
    /// Computes the page.
    ///
    /// # Errors
    /// Where an equilibrium was not found or a figure cannot be drawn.
    pub fn run(&self) -> Result<Page, PaperError> {
        let scenario = Scenario::parse(self.text)?;
        let mut page = Page::new(self.name, &scenario);
        (self.make)(&scenario, &mut page)?;
        page.stated(&scenario.stated)?;
        Ok(page)
    }
}

macro_rules! job {
    ($name:literal, $make:path) => {
        Job { name: $name, text: include_str!(concat!("../paper/", $name, ".toml")), make: $make }
    };
}

/// All pages in the order of the paper.
#[must_use]
pub fn pages() -> Vec<Job> {
    vec![
        job!("table1", tables::table1),
        job!("figure07", tables::sections),
        job!("assumptions", assumptions::assumptions),
        job!("figure12", planar::free),
        job!("figure13", planar::free),
        job!("figure14", planar::free),
        job!("figure16", planar::loaded),
        job!("figure18", space::sideways),
        job!("figure20", space::star),
        job!("figure21", space::rotation),
        job!("figure22", space::helicoid),
        job!("figure24", space::combined),
        job!("figure25", strength::euler),
        job!("depth", strength::deeper),
        job!("differences", differences::differences),
    ]
}
