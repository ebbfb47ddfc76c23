//! What metal the measured wrists of `robots/wrists` are of, by calibration: each alone, both together, and each predicted by what was fitted to the other.
//!
//!     cargo run --release -p cppr-calibrate --example wrists
//!
//! Tension of the tendon and total angle, weighted by the readings behind each row; no friction.
#![allow(clippy::print_stdout, reason = "a program")]

use cppr_calibrate::{Design, Fit, Measurement, Parameter, fit, read};
use std::error::Error;
use std::fmt::Write;

const NAMES: [&str; 2] = ["Wrist 150", "Wrist 90"];
/// What is fitted, and where the search begins: where the metal softens within what was measured.
const BEGIN: [(&str, f64); 3] = [("youngs_modulus", 35e9), ("onset_strain", 1e-2), ("second_modulus", 10e9)];

fn wrist(name: &str) -> Result<(Design, Vec<Measurement>), Box<dyn Error>> {
    let file = format!("robots/wrists/{}", name.to_lowercase().replace(' ', ""));
    let design = Design::from(cppr_io::bundle_file::read(format!("{file}.toml"))?);
    let mut table = String::from("robot,tension2_N,bend_deg,sigma_deg\n");
    for row in std::fs::read_to_string(format!("{file}.csv"))?.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let [force, .., total, readings] = cells[..] else { return Err("a row is too short".into()) };
        writeln!(table, "{name},{force},{total},{}", 1.0 / readings.parse::<f64>()?.sqrt())?;
    }
    let rows = read(&table, 2).map_err(|problems| problems[0].to_string())?;
    Ok((design, rows))
}

/// Root mean square of the total angle's misses over that of the angle (%).
fn missed(found: &Fit) -> f64 {
    100.0 * found.misses[0].fitted / found.misses[0].measured
}

fn main() -> Result<(), Box<dyn Error>> {
    let wrists = NAMES.iter().map(|name| wrist(name)).collect::<Result<Vec<_>, _>>()?;
    let list = BEGIN.iter().map(|(name, _)| Parameter::parse(name)).collect::<Result<Vec<_>, _>>()?;
    println!("fitted to                 E (GPa)       onset (%)     second (GPa)    rms 150   rms 90");
    for to in [&[0][..], &[1], &[0, 1]] {
        let mut designs: Vec<Design> = to.iter().map(|i| wrists[*i].0.clone()).collect();
        for design in &mut designs {
            list.iter().zip(BEGIN).for_each(|(parameter, (_, value))| parameter.set(design, value));
        }
        let rows: Vec<Measurement> = to.iter().flat_map(|i| wrists[*i].1.clone()).collect();
        let found = fit(&designs, &rows, &list, None, None)?;
        let names: Vec<&str> = to.iter().map(|i| NAMES[*i]).collect();
        print!("{:<22}", names.join(", "));
        for own in &found.estimates {
            let size = own.parameter.unit().1;
            print!("{:>8.2} ± {:<5.2}", own.value / size, own.interval / size);
        }
        for (design, rows) in &wrists {
            let mut design = design.clone();
            found.estimates.iter().for_each(|own| own.parameter.set(&mut design, own.value));
            print!("{:>8.1} %", missed(&fit(&[design], rows, &[], None, None)?));
        }
        println!();
    }
    Ok(())
}
