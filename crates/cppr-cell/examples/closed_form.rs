//! Cells over radii, depths and lengths, and how well the closed form meets them: the table of the book's page on cells.
//!
//!     cargo run --release -p cppr-cell --example closed_form

use cppr::design::{Cut, Outline};
use cppr_cell::{Cell, bending_estimate, stiffness};

fn main() {
    println!(
        "{:>8} {:>8} {:>8} {:>8} {:>10} {:>10} {:>8}",
        "bore", "depth", "notch", "tooth", "EI_Z", "closed", "error"
    );
    let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for bore in [0.5, 0.67, 0.86] {
        let outline = Outline::Round { outer_radius: 1.0, inner_radius: bore };
        for depth in [1.2, 1.5, 1.0 + bore, 0.5 * (3.0 + bore)] {
            for (notch, tooth) in [(0.6, 1.8), (1.7, 1.7)] {
                let cell = Cell {
                    outline: outline.clone(),
                    depth,
                    notch,
                    tooth,
                    cut: Cut::Plane,
                    corner_radius: None,
                    poissons_ratio: 0.33,
                };
                let (Ok(found), Ok(section)) = (stiffness(&cell), outline.inertia(depth)) else {
                    println!("{bore:8.2} {depth:8.3} {notch:8.2} {tooth:8.2} no answer");
                    continue;
                };
                let (ratio, closed) =
                    (found.bending_z / section.inertia_z, bending_estimate(&outline, depth, notch, tooth));
                let error = closed / ratio - 1.0;
                println!(
                    "{bore:8.2} {depth:8.3} {notch:8.2} {tooth:8.2} {ratio:10.4} {closed:10.4} {:7.1} %",
                    error * 100.0
                );
                (worst, sum, count) = (worst.max(error.abs()), sum + error * error, count + 1.0);
            }
        }
    }
    println!("rms {:.1} %, largest {:.1} %", (sum / count).sqrt() * 100.0, worst * 100.0);
}
