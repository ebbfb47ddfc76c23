//! Table 1 and Figure 7: what the robots are.

use crate::bench::{design, robot};
use crate::page::{Page, cell};
use crate::{PaperError, Scenario};
use cppr::design::TubeDesign;
use cppr_plot::{ProfileCurve, ProfileInput, Quantity, profile_figure};

/// Table 1 with what follows from it.
pub fn table1(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let mut rows = Vec::new();
    for name in &scenario.robots {
        let (design, robot) = (design(name)?, robot(name)?);
        for (k, tube) in design.tubes.iter().enumerate() {
            let TubeDesign::Notched(tube) = tube else { continue };
            let ends = [0.0, robot.length()];
            let depth = ends.map(|x| tube.depth.eval(x, robot.length())[0] * 1e3);
            let fields = ends.map(|x| robot.fields_at(k, x));
            let both = |a: f64, b: f64, digits| {
                if (a - b).abs() < 1e-12 * a.abs() {
                    cell(a, digits)
                } else {
                    format!("{} – {}", cell(a, digits), cell(b, digits))
                }
            };
            for (end, value) in ["base", "tip"].iter().zip(fields) {
                let key = |what: &str| format!("{name}/tube{}/{end}/{what}", k + 1);
                page.number(key("kinematic_offset_mm"), value.centroid_offset * 1e3);
                page.number(key("bending_z_Nmm2"), value.bending_z * 1e6);
                page.number(key("torsion_Nmm2"), value.torsion * 1e6);
            }
            if k == 0 {
                page.number(format!("{name}/outer_diameter_mm"), 2.0 * tube.outline.outer_reach() * 1e3);
            }
            rows.push(vec![
                format!("{} tube {}", design.name, k + 1),
                format!(
                    "{} / {}",
                    cell(tube.outline.outer_reach() * 1e3, 1),
                    cell(tube.outline.inner_clearance() * 1e3, 1)
                ),
                both(depth[0], depth[1], 2),
                cell(tube.centroid_offset_factor, 2),
                both(
                    fields[0].centroid_offset / tube.centroid_offset_factor * 1e3,
                    fields[1].centroid_offset / tube.centroid_offset_factor * 1e3,
                    4,
                ),
                both(fields[0].bending_z * 1e6, fields[1].bending_z * 1e6, 0),
                both(fields[0].bending_y * 1e6, fields[1].bending_y * 1e6, 0),
                both(fields[0].torsion * 1e6, fields[1].torsion * 1e6, 0),
            ]);
        }
    }
    page.table(
        "Table 1, base – tip where they differ. E = 5.39 GPa, L = 150 mm, notches and teeth 5 mm; torsion after Saint-Venant with ν = 0.35.",
        &["tube", "radii (mm)", "γ (mm)", "f_D", "D (mm)", "EI_Z (N mm²)", "EI_Y (N mm²)", "GJ (N mm²)"],
        rows,
    );
    Ok(())
}

/// Figure 7.
pub fn sections(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let name = &scenario.robots[0];
    let (design, robot) = (design(name)?, robot(name)?);
    let youngs = match &design.tubes[0] {
        TubeDesign::Notched(t) => t.material.youngs_modulus,
        TubeDesign::Stiffness(_) => 1.0,
    };
    let factor = match &design.tubes[0] {
        TubeDesign::Notched(t) => t.centroid_offset_factor,
        TubeDesign::Stiffness(t) => t.centroid_offset_factor,
    };
    // From 20 mm below the plate; the step is drawn by its two sides.
    let mut xs: Vec<f64> = vec![-0.02, -1e-12];
    xs.extend((0..=150).map(|i| f64::from(i) * 1e-3));
    let curve = |tube: usize, value: &dyn Fn(&cppr::design::FieldValues) -> f64| {
        let own: Vec<f64> = xs.iter().copied().filter(|&x| tube > 0 || x >= 0.0).collect();
        ProfileCurve {
            name: format!("tube {}", tube + 1),
            tube: tube + 1,
            values: own.iter().map(|&x| value(&robot.fields_at(tube, x))).collect(),
            x_m: own.iter().map(|&x| if x.abs() < 1e-9 { 0.0 } else { x }).collect(),
        }
    };
    let notched = |curve: ProfileCurve| {
        let from = curve.x_m.iter().rposition(|&x| x <= 0.0).unwrap_or(0);
        ProfileCurve { x_m: curve.x_m[from..].to_vec(), values: curve.values[from..].to_vec(), ..curve }
    };
    let second_moment = |f: &cppr::design::FieldValues| f.bending_z / youngs * 1e12;
    let quantity = |label: &str, unit: &str, value: &dyn Fn(&cppr::design::FieldValues) -> f64| Quantity {
        label: label.into(),
        unit: unit.into(),
        include_zero: true,
        curves: vec![curve(0, value), curve(1, value)],
    };
    let input = ProfileInput {
        title: design.name.clone(),
        x_label: "X".into(),
        quantities: vec![
            quantity("A", "mm²", &|f| f.axial / youngs * 1e6),
            quantity("D", "mm", &|f| f.centroid_offset / factor * 1e3),
            quantity("I_{Z}", "mm⁴", &second_moment),
            // The step hides what the notched parts do.
            Quantity {
                label: "I_{Z}, notched part".into(),
                unit: "mm⁴".into(),
                include_zero: true,
                curves: vec![notched(curve(0, &second_moment)), notched(curve(1, &second_moment))],
            },
        ],
    };
    page.figure(
        "",
        "Area, centroid offset (without factor) and soft second moment of R3's tubes; below, the soft second moment again without the uncut part.",
        profile_figure(&input)?,
    );
    for tube in 0..2 {
        for (place, x) in [("base", 0.0), ("tip", robot.length())] {
            let f = robot.fields_at(tube, x);
            let key = |what: &str| format!("tube{}/{place}/{what}", tube + 1);
            page.number(key("area_mm2"), f.axial / youngs * 1e6);
            page.number(key("offset_mm"), f.centroid_offset / factor * 1e3);
            page.number(key("second_moment_mm4"), f.bending_z / youngs * 1e12);
        }
    }
    let jump = robot.fields_at(1, -1e-9).bending_z / robot.fields_at(1, 0.0).bending_z;
    page.number("jump_of_follower_stiffness", jump);
    page.text
        .push(format!("The follower's soft stiffness jumps by a factor of {} at the plate.", cell(jump, 1)));
    Ok(())
}
