//! `cppr cell`: stiffness of one notch and tooth by finite elements, beside the section at the notch.

use crate::Failure;
use crate::output::{self, is_stdout, note, print, write, write_or_print};
use crate::quantity::{Kind, scalar};
use cppr::design::{Cut, NotchPattern, NotchedTube, RobotDesign, TeethStiffness, TubeDesign};
use cppr_cell::{Cell, CellStiffness, bending_estimate};
use cppr_io::bundle_file::{self, Described};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr cell robots/r1.toml
  cppr cell robots/r1.toml --tube 1 --cut radial --json -";

/// Arguments of `cppr cell`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Only this tube
    #[arg(long, value_name = "K")]
    tube: Option<usize>,
    /// How the notches are cut, in place of what the file says
    #[arg(long, value_parser = ["plane", "radial"])]
    cut: Option<String>,
    /// Radius of the notches' corners, in place of what the file says
    #[arg(long, value_name = "LENGTH", value_parser = |s: &str| scalar(s, Kind::Length))]
    corner_radius: Option<f64>,
    /// Write all numbers as JSON, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the bent cell of one tube, at its baseplate, for ParaView
    #[arg(long, value_name = "FILE", requires = "tube")]
    vtk: Option<PathBuf>,
}

/// A cell with what it is compared with.
struct Row {
    tube: usize,
    x: f64,
    cell: Cell,
    found: CellStiffness,
    section: cppr::design::SectionProperties,
    youngs_modulus: f64,
    shear_modulus: f64,
}

/// A piece of a tube with notches of known length.
struct Piece {
    /// From 0.
    tube: usize,
    /// Abscissa of its base along the tube (m).
    from: f64,
    length: f64,
    design: NotchedTube,
    pattern: NotchPattern,
}

/// Prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    output::check(&args.robot, &[("--json", args.json.as_deref()), ("--vtk", args.vtk.as_deref())])?;
    let described = bundle_file::read(&args.robot).map_err(|p| Failure::Input(p.to_string()))?;
    let (name, count) = match &described {
        Described::Robot(file) => (file.design.name.clone(), file.design.tubes.len()),
        Described::Bundle { design, .. } => (design.name.clone(), design.tubes.len()),
    };
    if let Some(tube) = args.tube.filter(|tube| !(1..=count).contains(tube)) {
        return Err(Failure::Input(format!("--tube: there is no tube {tube}; this robot has 1 to {count}")));
    }
    let mut pieces = pieces(described);
    pieces.retain(|piece| args.tube.is_none_or(|tube| piece.tube + 1 == tube));
    if pieces.is_empty() {
        let whose =
            args.tube.map_or("no tube of this robot has".into(), |tube| format!("tube {tube} does not have"));
        return Err(Failure::Input(format!(
            "{}: {whose} notches of known length: write depth_mm, length_mm and tooth_mm under [tube.notches]",
            args.robot.display()
        )));
    }
    let mut rows = Vec::new();
    for piece in &pieces {
        for x in places(piece) {
            rows.push(row(piece, x, args)?);
        }
    }
    if let (Some(path), Some(row)) = (&args.vtk, rows.first()) {
        let text = row.cell.bent_vtk().map_err(|e| failure(row.tube, row.x, &e))?;
        write(path, text.as_bytes())?;
    }
    if let Some(path) = &args.json {
        let cells: Vec<Value> = rows.iter().map(Row::json).collect();
        let whole = json!({ "schema": "cppr/cell", "schema_version": 1, "robot": name, "cells": cells });
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let text: String = rows.iter().map(|row| row.text(&name)).collect();
    if args.json.as_deref().is_some_and(is_stdout) {
        note(&text);
        Ok(())
    } else {
        print(&text)
    }
}

/// All pieces of a robot whose notches and teeth have known lengths.
fn pieces(described: Described) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut add = |tube: usize, from: f64, length: f64, body: TubeDesign| {
        if let TubeDesign::Notched(design) = body
            && let Some(pattern) = design.pattern
        {
            pieces.push(Piece { tube, from, length, design, pattern });
        }
    };
    match described {
        Described::Robot(file) => {
            let RobotDesign { length, tubes, .. } = file.design;
            for (tube, body) in tubes.into_iter().enumerate() {
                add(tube, 0.0, length, body);
            }
        }
        Described::Bundle { design, .. } => {
            for (tube, parts) in design.tubes.into_iter().enumerate() {
                let mut from = 0.0;
                for part in parts.parts {
                    add(tube, from, part.length, part.body);
                    from += part.length;
                }
            }
        }
    }
    pieces
}

/// The base of a piece and, where depths differ, its middle and end (m from its base).
fn places(piece: &Piece) -> Vec<f64> {
    if piece.design.depth.is_constant() { vec![0.0] } else { vec![0.0, 0.5 * piece.length, piece.length] }
}

fn failure(tube: usize, x: f64, error: &cppr_cell::CellError) -> Failure {
    Failure::Input(format!("tube {} at x = {:.3} mm: {error}", tube + 1, x * 1e3))
}

fn row(piece: &Piece, place: f64, args: &Args) -> Result<Row, Failure> {
    let Piece { tube, from, length, design, pattern } = piece;
    let (tube, x) = (*tube, from + place);
    let (cut, corner_radius) = match &design.teeth {
        TeethStiffness::Cells(table) => (table.cut, table.corner_radius),
        _ => (Cut::Plane, None),
    };
    let cell = Cell {
        outline: design.outline.clone(),
        depth: design.depth.eval(place, *length)[0],
        notch: pattern.length,
        tooth: pattern.tooth,
        cut: match args.cut.as_deref() {
            Some("radial") => Cut::Radial,
            Some(_) => Cut::Plane,
            None => cut,
        },
        corner_radius: args.corner_radius.or(corner_radius),
        poissons_ratio: design.material.poissons_ratio,
    };
    let found = cppr_cell::stiffness(&cell).map_err(|e| failure(tube, x, &e))?;
    let section =
        cell.outline.notched(cell.depth).map_err(|e| failure(tube, x, &cppr_cell::CellError::Section(e)))?;
    let (youngs_modulus, shear_modulus) = (design.material.youngs_modulus, design.material.shear_modulus());
    Ok(Row { tube, x, cell, found, section, youngs_modulus, shear_modulus })
}

impl Row {
    /// Name, unit, cell and section, in the units of the table.
    fn quantities(&self) -> [(&'static str, &'static str, f64, f64); 5] {
        let (e, g) = (self.youngs_modulus, self.shear_modulus);
        let (f, s) = (&self.found, &self.section);
        [
            ("EI_Z", "N mm²", e * f.bending_z * 1e6, e * s.inertia_z * 1e6),
            ("EI_Y", "N mm²", e * f.bending_y * 1e6, e * s.inertia_y * 1e6),
            ("GJ", "N mm²", g * f.torsion * 1e6, g * s.torsion_constant * 1e6),
            ("EA", "N", e * f.axial, e * s.area),
            ("D", "mm", f.centroid_offset * 1e3, s.centroid_offset * 1e3),
        ]
    }

    fn text(&self, name: &str) -> String {
        let Cell { depth, notch, tooth, cut, corner_radius, .. } = &self.cell;
        let cut = match cut {
            Cut::Plane => "plane",
            Cut::Radial => "radial",
        };
        let corners =
            corner_radius.map_or("sharp corners".into(), |r| format!("corners of {:.3} mm", r * 1e3));
        let mut text = format!(
            "{name}, tube {}, x = {:.1} mm: notch {:.3} mm deep, {:.3} mm long, tooth {:.3} mm, {cut} cut, {corners}\n",
            self.tube + 1,
            self.x * 1e3,
            depth * 1e3,
            notch * 1e3,
            tooth * 1e3
        );
        let _ = writeln!(text, "  {:<14}{:>14}{:>14}{:>10}", "", "cell", "notch alone", "ratio");
        for (name, unit, cell, section) in self.quantities() {
            let _ = writeln!(
                text,
                "  {:<14}{cell:>14.5}{section:>14.5}{:>10.4}",
                format!("{name} {unit}"),
                cell / section
            );
        }
        let rigid = (notch + tooth) / notch;
        let closed = bending_estimate(&self.cell.outline, *depth, *notch, *tooth);
        let _ = writeln!(
            text,
            "  EI_Z with rigid teeth {rigid:.4}, by the closed form {closed:.4} times the notch alone"
        );
        match &self.found.peak {
            Some(p) => {
                let _ = writeln!(
                    text,
                    "  peak strain: {:.4} and {:.4} % for κ_Z = 1/m, ±{:.4} % for κ_Y, ±{:.4} % for a twist of 1 rad/m, {:.4} % for 1 N along the tube",
                    p.bending_z[0] * 100.0,
                    p.bending_z[1] * 100.0,
                    p.bending_y * 100.0,
                    p.twist * 100.0,
                    self.peak_per_newton(p.stretch) * 100.0
                );
            }
            None => text.push_str("  peak strain: none is claimed, corners of notch or bore are sharp\n"),
        }
        let _ = writeln!(
            text,
            "  last refinement changed stiffness by {:.2} % and peaks by {:.1} %; {} unknowns",
            self.found.change * 100.0,
            self.found.peak_change * 100.0,
            self.found.unknowns
        );
        text
    }

    fn peak_per_newton(&self, stretch: [f64; 2]) -> f64 {
        stretch[0] / (self.youngs_modulus * self.found.axial)
    }

    fn json(&self) -> Value {
        let f = &self.found;
        let ratio = |name: &str| {
            self.quantities()
                .iter()
                .find(|q| q.0 == name)
                .map_or(f64::NAN, |(_, _, cell, section)| cell / section)
        };
        json!({
            "tube": self.tube + 1,
            "x_m": self.x,
            "depth_m": self.cell.depth,
            "notch_m": self.cell.notch,
            "tooth_m": self.cell.tooth,
            "corner_radius_m": self.cell.corner_radius,
            "cut": if self.cell.cut == Cut::Radial { "radial" } else { "plane" },
            "bending_z_Nm2": self.youngs_modulus * f.bending_z,
            "bending_y_Nm2": self.youngs_modulus * f.bending_y,
            "torsion_Nm2": self.shear_modulus * f.torsion,
            "axial_N": self.youngs_modulus * f.axial,
            "centroid_offset_m": f.centroid_offset,
            "relative_to_notch_section": {
                "bending_z": ratio("EI_Z"),
                "bending_y": ratio("EI_Y"),
                "torsion": ratio("GJ"),
                "axial": ratio("EA"),
                "centroid_offset": ratio("D"),
            },
            "peak_strain": f.peak.as_ref().map(|p| json!({
                "per_curvature_z_m": p.bending_z,
                "per_curvature_y_m": p.bending_y,
                "per_twist_m": p.twist,
                "per_axial_force_1_N": p.stretch.map(|s| s / (self.youngs_modulus * f.axial)),
            })),
            "change_of_stiffness": f.change,
            "change_of_peak_strain": f.peak_change,
            "unknowns": f.unknowns,
        })
    }
}
