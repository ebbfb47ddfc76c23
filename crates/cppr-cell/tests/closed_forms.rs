//! Cells whose stiffness is known in closed form, and bounds.
#![allow(clippy::unwrap_used, clippy::panic)]

use cppr::design::{Cut, Outline};
use cppr_cell::{Cell, CellError, CellStiffness};
use std::f64::consts::PI;

const MM: f64 = 1e-3;

fn cell(depth: f64, notch: f64, tooth: f64) -> Cell {
    Cell {
        outline: Outline::Round { outer_radius: 3.0 * MM, inner_radius: 2.0 * MM },
        depth: depth * MM,
        notch: notch * MM,
        tooth: tooth * MM,
        cut: Cut::Plane,
        corner_radius: None,
        poissons_ratio: 0.35,
    }
}

#[track_caller]
fn near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!((got / want - 1.0).abs() < tolerance, "{what}: {got:e} instead of {want:e}");
}

#[test]
fn an_uncut_tube_has_ea_ei_and_gj() {
    let found = cell(5.0, 0.0, 4.0).stiffness().unwrap();
    let (r, i) = (3.0 * MM, 2.0 * MM);
    near("EA", found.axial, PI * (r * r - i * i), 1e-3);
    let inertia = PI / 4.0 * (r.powi(4) - i.powi(4));
    near("EI_Y", found.bending_y, inertia, 1e-3);
    near("EI_Z", found.bending_z, inertia, 1e-3);
    near("GJ", found.torsion, 2.0 * inertia, 1e-3);
    assert!(found.centroid_offset.abs() < 1e-4 * r);
}

/// All regimes of the cut: closed ring, open ring, cut at and beyond the bore; polygons.
#[test]
fn a_prism_has_the_stiffness_of_its_section() {
    let square = Outline::Polygon { sides: 4, outer_apothem: 3.0 * MM, inner_apothem: 2.0 * MM };
    let rod = Outline::Round { outer_radius: 3.0 * MM, inner_radius: 0.0 };
    let round = cell(1.0, 1.0, 1.0).outline;
    for (outline, depth) in [
        (&round, 0.6),
        (&round, 2.4),
        (&round, 5.0),
        (&round, 5.4),
        (&square, 3.0),
        (&square, 5.3),
        (&rod, 2.0),
    ] {
        let prism = Cell { outline: outline.clone(), ..cell(depth, 3.0, 0.0) };
        let (found, section) = (prism.stiffness().unwrap(), outline.notched(prism.depth).unwrap());
        let what = format!("{outline:?} {depth}");
        near(&what, found.axial, section.area, 2e-3);
        near(&what, found.centroid_offset, section.centroid_offset, 2e-3);
        near(&what, found.bending_y, section.inertia_y, 3e-3);
        near(&what, found.bending_z, section.inertia_z, 3e-3);
        near(&what, found.torsion, section.torsion_constant, 1e-2);
    }
}

/// What a radial cut keeps of a ring is a sector of it.
#[test]
fn a_radial_prism_has_the_stiffness_of_a_sector() {
    let found = Cell { cut: Cut::Radial, ..cell(4.0, 3.0, 0.0) }.stiffness().unwrap();
    let (r, i) = (3.0 * MM, 2.0 * MM);
    let (sin, cos) = ((8.0_f64).sqrt() / 3.0, 1.0 / 3.0_f64);
    let half = cos.acos();
    let area = half * (r * r - i * i);
    let offset = 2.0 / 3.0 * sin * (r.powi(3) - i.powi(3)) / area;
    let quartic = 0.25 * (r.powi(4) - i.powi(4));
    near("EA", found.axial, area, 2e-3);
    near("D", found.centroid_offset, offset, 2e-3);
    near("EI_Y", found.bending_y, quartic * (half - sin * cos), 3e-3);
    near("EI_Z", found.bending_z, quartic * (half + sin * cos) - area * offset * offset, 3e-3);
}

/// A fillet adds material, and less than a notch that is shorter by two radii: both bound every stiffness.
#[test]
#[ignore = "half a minute: the peak at a fillet takes the finest mesh"]
fn fillets_stiffen_within_bounds() {
    let values = |cell: Cell| {
        let s = cell.stiffness().unwrap();
        [s.axial, s.bending_y, s.bending_z, s.torsion]
    };
    let sharp = values(cell(5.0, 5.0, 5.0));
    let round = values(Cell { corner_radius: Some(1.0 * MM), ..cell(5.0, 5.0, 5.0) });
    let short = values(cell(5.0, 3.0, 7.0));
    for k in 0..4 {
        assert!(sharp[k] < round[k] && round[k] < short[k], "{k}: {} {} {}", sharp[k], round[k], short[k]);
    }
}

/// Bent, a prism is strained most at its farthest fibre, as near as peaks are said to settle.
#[test]
fn peaks_without_a_corner_are_those_of_beams() {
    let prism = Cell { corner_radius: Some(0.5 * MM), ..cell(5.0, 3.0, 0.0) };
    let peak = prism.stiffness().unwrap().peak.unwrap();
    let section = prism.outline.inertia(prism.depth).unwrap();
    let (back, edge) = (3.0 * MM - section.centroid_offset, section.centroid_offset - 2.0 * MM);
    // ε = −κ_Z (Y − D); across the fibres Poisson's contraction adds nothing larger.
    near("tension", peak.bending_z[0], edge.max(0.35 * back), 3e-2);
    near("compression", -peak.bending_z[1], back, 3e-2);
    near("stretch", peak.stretch[0], 1.0, 3e-2);
}

#[test]
fn cells_lie_between_flexible_and_rigid_teeth() {
    let section = cell(5.0, 1.0, 1.0).outline.inertia(5.0 * MM).unwrap();
    let ratio = |notch, tooth| cell(5.0, notch, tooth).stiffness().unwrap().bending_z / section.inertia_z;
    // Teeth much shorter than the wall is thick do not count; notches much longer than the tube is wide take all bending.
    let (short, long) = (ratio(4.0, 0.1), ratio(60.0, 5.0));
    assert!((1.0..1.03).contains(&short), "{short}");
    let rigid = 65.0 / 60.0;
    assert!(long < rigid && long > 0.96 * rigid, "{long}");
}

#[test]
fn lengths_scale() {
    let small = cell(5.0, 5.0, 0.0);
    let large = Cell {
        outline: Outline::Round { outer_radius: 30.0 * MM, inner_radius: 20.0 * MM },
        depth: 50.0 * MM,
        notch: 50.0 * MM,
        ..small.clone()
    };
    let (small, large): (CellStiffness, CellStiffness) =
        (small.stiffness().unwrap(), large.stiffness().unwrap());
    near("EI_Z", large.bending_z, 1e4 * small.bending_z, 1e-9);
    near("D", large.centroid_offset, 10.0 * small.centroid_offset, 1e-9);
}

#[test]
fn what_is_no_cell_is_said_to_be_none() {
    let says = |cell: Cell, words: &str| {
        let error = cell.stiffness().unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    };
    says(cell(6.0, 5.0, 5.0), "leaves nothing");
    says(cell(5.0, -1.0, 5.0), "length of the notch is -1.000000 mm");
    says(cell(5.0, 0.0, 0.0), "length of notch and tooth");
    says(cell(0.0, 5.0, 5.0), "depth of the notch");
    says(Cell { poissons_ratio: 0.5, ..cell(5.0, 5.0, 5.0) }, "between -0.9 and 0.49");
    says(Cell { corner_radius: Some(2.6 * MM), ..cell(5.0, 5.0, 5.0) }, "may be up to 2.500000 mm");
    let rod = Outline::Round { outer_radius: 3.0 * MM, inner_radius: 0.0 };
    says(Cell { cut: Cut::Radial, outline: rod, ..cell(5.0, 5.0, 5.0) }, "needs a tube with a bore");
    let square = Outline::Polygon { sides: 4, outer_apothem: 3.0 * MM, inner_apothem: 2.0 * MM };
    let radial =
        Cell { cut: Cut::Radial, outline: square, corner_radius: Some(0.1 * MM), ..cell(4.0, 5.0, 5.0) };
    says(radial, "round tubes only");
    assert!(matches!(cell(5.0, f64::NAN, 5.0).stiffness(), Err(CellError::Length(..))));
}
