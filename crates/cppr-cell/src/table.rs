//! Stiffness of cells over the depths of a pattern, relative to the section at the notch, for `cppr::design`.
//!
//! Depths where the notch reaches the bore and where it leaves the bore behind end smooth ranges. On each, cells are computed at
//! Chebyshev points of the second kind, 5, then 9, then 17, until the last coefficients of the factors' polynomial are below
//! [`SMOOTH`]. Below [`SHALLOW`] of the wall the factors, near 1, stay as they are there.

use crate::cache::stiffness;
use crate::cell::{Cell, CellError, CellStiffness};
use cppr::design::{CellFactors, CellRange, CellTable};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Bound on the last coefficients of the polynomials over depth, relative to the factor.
const SMOOTH: f64 = 0.005;
/// Part of the wall below which a notch hardly counts.
const SHALLOW: f64 = 0.1;

/// The table for a pattern whose depths lie between the `least` and the `greatest` (m); `cell.depth` is not used.
///
/// # Errors
/// As [`Cell::stiffness`], and depths between which the stiffness changes too fast.
pub fn table(cell: &Cell, least: f64, greatest: f64) -> Result<CellTable, CellError> {
    let at = |depth: f64| Cell { depth, ..cell.clone() };
    at(greatest).check()?;
    let shallow = SHALLOW * cell.outline.opening_depth();
    let mut ranges = Vec::new();
    if least < shallow {
        let own = factors(&at(shallow))?;
        ranges.push(CellRange { nodes: vec![(shallow, own), (0.0, own)] });
    }
    let start = least.max(shallow);
    let mut edges = vec![start, greatest];
    let inner = [cell.outline.opening_depth(), cell.outline.passing_depth()];
    edges.extend(inner.into_iter().filter(|d| *d > start && *d < greatest));
    edges.sort_by(f64::total_cmp);
    if greatest - start <= 1e-9 * greatest {
        if greatest >= shallow {
            ranges.push(CellRange { nodes: vec![(greatest, factors(&at(greatest))?)] });
        }
    } else {
        for pair in edges.windows(2).filter(|pair| pair[1] - pair[0] > 1e-9 * greatest) {
            ranges.push(range(&at, pair[0], pair[1])?);
        }
    }
    Ok(CellTable {
        outline: cell.outline.clone(),
        notch: cell.notch,
        tooth: cell.tooth,
        cut: cell.cut,
        corner_radius: cell.corner_radius,
        poissons_ratio: cell.poissons_ratio,
        tooth_factor: 1.0,
        ranges,
    })
}

fn range(at: &(impl Fn(f64) -> Cell + Sync), least: f64, greatest: f64) -> Result<CellRange, CellError> {
    let (middle, half) = (0.5 * (least + greatest), 0.5 * (greatest - least));
    for spaces in [4_u16, 8, 16] {
        let depth = |i: u16| middle + half * (PI * f64::from(i) / f64::from(spaces)).cos();
        let nodes: Vec<(f64, CellFactors)> = (0..=spaces)
            .into_par_iter()
            .map(|i| {
                factors(&at(depth(i).clamp(least, greatest)))
                    .map(|own| (depth(i).clamp(least, greatest), own))
            })
            .collect::<Result<_, _>>()?;
        let read: [fn(&CellFactors) -> f64; 5] =
            [|f| f.centroid_offset, |f| f.bending_y, |f| f.bending_z, |f| f.torsion, |f| f.axial];
        let worst = read
            .iter()
            .map(|read| tail(&nodes.iter().map(|n| read(&n.1)).collect::<Vec<_>>()))
            .fold(0.0, f64::max);
        if worst < SMOOTH {
            return Ok(CellRange { nodes });
        }
    }
    Err(CellError::Steep { from: least, to: greatest })
}

/// Size of the last two Chebyshev coefficients over the least value.
fn tail(values: &[f64]) -> f64 {
    let last = values.len() - 1;
    let coefficient = |k: usize| {
        let sum: f64 = (0..=last)
            .map(|i| {
                let weight = if i == 0 || i == last { 0.5 } else { 1.0 };
                weight * values[i] * (PI * (k * i) as f64 / last as f64).cos()
            })
            .sum();
        (if k == last { 1.0 } else { 2.0 } * sum / last as f64).abs()
    };
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    coefficient(last).max(coefficient(last - 1)) / least
}

/// A cell relative to the section at its notch, as a plane cuts it.
fn factors(cell: &Cell) -> Result<CellFactors, CellError> {
    let section = cell.outline.notched(cell.depth).map_err(CellError::Section)?;
    let CellStiffness { axial, centroid_offset, bending_y, bending_z, torsion, mean_area, peak, .. } =
        stiffness(cell)?;
    Ok(CellFactors {
        centroid_offset: centroid_offset / section.centroid_offset,
        bending_y: bending_y / section.inertia_y,
        bending_z: bending_z / section.inertia_z,
        torsion: torsion / section.torsion_constant,
        axial: axial / section.area,
        mass: mean_area / section.area,
        peak,
    })
}
