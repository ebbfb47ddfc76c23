//! `teeth`, `cut`, `corner_radius_mm` and `tooth_factor` of `[tube.notches]`: what the teeth do to the stiffness, and the cells that tell.

use crate::cursor::Cursor;
use crate::problems::Collector;
use crate::quantity::{CORNER, TOOTH_FACTOR};
#[cfg(not(target_family = "wasm"))]
use cppr::design::CellTable;
use cppr::design::{Cut, NotchedTube, TeethStiffness};
#[cfg(not(target_family = "wasm"))]
use cppr_cell::{Cell, table};
use std::ops::Range;

/// Abscissae at which the depth of a pattern is looked at, less one.
#[cfg(not(target_family = "wasm"))]
const SAMPLES: u16 = 4096;

/// What the file says of the teeth.
pub(crate) enum Teeth {
    Flexible,
    Rigid,
    Cells(CellOrder),
}

/// Cells to compute.
#[cfg_attr(target_family = "wasm", expect(dead_code, reason = "they are refused there"))]
pub(crate) struct CellOrder {
    cut: Cut,
    corner_radius: Option<f64>,
    tooth_factor: f64,
    key: String,
    span: Range<usize>,
}

/// Reads the keys; `pattern` says whether the lengths of notch and tooth are known.
pub(crate) fn read_teeth(cursor: &Cursor<'_, '_>, pattern: bool, out: &mut Collector) -> Option<Teeth> {
    let word = match cursor.get("teeth") {
        None => "flexible",
        Some(entry) => {
            let word = entry.word(&["flexible", "rigid", "cell"], out)?;
            if word != "flexible" && !pattern && !(cursor.has("length_mm") && cursor.has("tooth_mm")) {
                let message = "the stiffness of teeth needs the lengths of notch and tooth";
                out.missing(entry.span, entry.key, message, "Write length_mm and tooth_mm beside it.");
                return None;
            }
            word
        }
    };
    let cut = cursor.get("cut").map(|entry| entry.word(&["plane", "radial"], out));
    let radius = cursor.field("corner_radius_mm", &CORNER, out);
    let factor = cursor.field("tooth_factor", &TOOTH_FACTOR, out);
    if word != "cell" {
        for key in ["cut", "corner_radius_mm", "tooth_factor"] {
            if let Some(entry) = cursor.get(key) {
                let message = "this needs the finite elements of a cell; without them it changes nothing";
                entry.wrong(message, "Write teeth = \"cell\" beside it, or leave it out.", out);
            }
        }
    }
    match word {
        "rigid" => Some(Teeth::Rigid),
        "cell" => {
            let entry = cursor.get("teeth")?;
            let cut = match cut {
                Some(word) if word? == "radial" => Cut::Radial,
                None | Some(_) => Cut::Plane,
            };
            let corner_radius = if radius.present { Some(radius.value?) } else { None };
            if cut == Cut::Radial && corner_radius.is_none() {
                // Limits know the strain of a section cut by a plane, and the peak at fillets.
                let message = "a radial cut needs the radius of the notch's corners";
                let help =
                    "Write corner_radius_mm beside it: a laser leaves at least half the width of its beam.";
                out.missing(entry.span, entry.key, message, help);
                return None;
            }
            let tooth_factor = if factor.present { factor.value? } else { 1.0 };
            Some(Teeth::Cells(CellOrder {
                cut,
                corner_radius,
                tooth_factor,
                key: entry.key,
                span: entry.span,
            }))
        }
        _ => Some(Teeth::Flexible),
    }
}

impl Teeth {
    /// The tube with these teeth; `length` (m) is that of its pattern.
    pub fn of(self, tube: NotchedTube, length: Option<f64>, out: &mut Collector) -> Option<NotchedTube> {
        match self {
            Self::Flexible => Some(tube),
            Self::Rigid => Some(NotchedTube { teeth: TeethStiffness::Rigid, ..tube }),
            // Cells cost seconds, which a file that is refused for something else need not take.
            Self::Cells(_) if !out.is_empty() => None,
            Self::Cells(order) => order.carry_out(tube, length?, out),
        }
    }
}

#[cfg(target_family = "wasm")]
impl CellOrder {
    fn carry_out(self, _: NotchedTube, _: f64, out: &mut Collector) -> Option<NotchedTube> {
        let message = "cells are not computed here: they take a minute of the page's time";
        let help = "Open the robot with the program, or write teeth = \"flexible\" or \"rigid\".";
        out.wrong(self.span, self.key, message, help);
        None
    }
}

#[cfg(not(target_family = "wasm"))]
impl CellOrder {
    fn carry_out(self, tube: NotchedTube, length: f64, out: &mut Collector) -> Option<NotchedTube> {
        let pattern = tube.pattern?;
        let places =
            (0..=SAMPLES).map(|i| length * f64::from(i) / f64::from(SAMPLES)).chain(pattern.middles());
        let depths = places.map(|x| tube.depth.eval(x, length)[0]);
        let (least, greatest) =
            depths.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), d| (a.min(d), b.max(d)));
        let cell = Cell {
            outline: tube.outline.clone(),
            depth: greatest,
            notch: pattern.length,
            tooth: pattern.tooth,
            cut: self.cut,
            corner_radius: self.corner_radius,
            poissons_ratio: tube.material.poissons_ratio,
        };
        match table(&cell, least, greatest) {
            Ok(table) => {
                let table = CellTable { tooth_factor: self.tooth_factor, ..table };
                Some(NotchedTube { teeth: TeethStiffness::Cells(table), ..tube })
            }
            Err(error) => {
                let help = "Change what it names, or write teeth = \"flexible\" or \"rigid\".";
                out.wrong(self.span, self.key, error.to_string(), help);
                None
            }
        }
    }
}
