//! What metal, and what friction, the measured wrists of `robots/wrists` are of, by calibration: each alone, both together, and each predicted by what was
//! fitted to the other.
//!
//!     cargo run --release -p cppr-calibrate --example wrists
//!
//! Tension of the tendon at its motor, which is driven on, and the total angle, first without friction; then with and without it, by the total angle and by the angles up to
//! every notch, where no notch is near to being closed. Weighted by the readings behind each row.
#![allow(clippy::print_stdout, reason = "a program")]

use cppr::bundle::Friction;
use cppr_calibrate::{Design, Fit, Measurement, Parameter, fit, read};
use std::error::Error;
use std::fmt::Write;

const NAMES: [&str; 2] = ["Wrist 150", "Wrist 90"];
/// What is fitted, and where the search begins: where the metal softens within what was measured.
const BEGIN: [(&str, f64); 3] = [("youngs_modulus", 35e9), ("onset_strain", 1e-2), ("second_modulus", 10e9)];
/// Length of a notch with its tooth (mm).
const PITCH: f64 = 2.0;
/// A notch that is bent by less than this part of the greatest angle of any is open.
const OPEN: f64 = 0.8;

/// Design, and its measurements: total angles; and where all notches are open, total angles and angles up to every notch.
type Wrist = (Design, [Vec<Measurement>; 3]);
const TABLES: [&str; 3] = ["total angle", "total, open", "notches, open"];

fn wrist(name: &str) -> Result<Wrist, Box<dyn Error>> {
    let file = format!("robots/wrists/{}", name.to_lowercase().replace(' ', ""));
    let design = Design::from(cppr_io::bundle_file::read(format!("{file}.toml"))?);
    let text = std::fs::read_to_string(format!("{file}.csv"))?;
    let cells = |row: &str| row.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
    let rows = text.lines().skip(1).map(cells).collect::<Result<Vec<_>, _>>()?;
    let most = |row: &[f64]| row[1..row.len() - 2].iter().copied().fold(0.0, f64::max);
    let greatest = rows.iter().map(|row| most(row)).fold(0.0, f64::max);
    let mut tables =
        [(); 3].map(|()| String::from("robot,tension2_N,driven,at_mm,line,bend_deg,sigma_deg\n"));
    for row in &rows {
        let [force, notches @ .., sum, readings] = &row[..] else { return Err("a row is too short".into()) };
        let total = format!("{name},{force},on,,,{sum},{}\n", 1.0 / readings.sqrt());
        tables[0] += &total;
        if most(row) > OPEN * greatest {
            continue;
        }
        tables[1] += &total;
        let mut angle = 0.0;
        for (count, notch) in (1_u8..).map(f64::from).zip(notches) {
            angle += notch;
            let (at, sigma) = (PITCH * count, (count / readings).sqrt());
            writeln!(tables[2], "{name},{force},on,{at},tube1,{angle},{sigma}")?;
        }
    }
    let [all, total, each] = tables.map(|text| read(&text, 2).map_err(|problems| problems[0].to_string()));
    Ok((design, [all?, total?, each?]))
}

/// Root mean square of the total angle's misses over that of the angle (%).
fn missed(found: &Fit) -> f64 {
    100.0 * found.misses[0].fitted / found.misses[0].measured
}

/// Fits the metal, and friction where that is asked for, and prints what came out.
fn fitted(wrists: &[Wrist], to: &[usize], table: usize, rubs: bool) -> Result<(), Box<dyn Error>> {
    let mut list = BEGIN.iter().map(|(name, _)| Parameter::parse(name)).collect::<Result<Vec<_>, _>>()?;
    let mut designs: Vec<Design> = to.iter().map(|i| wrists[*i].0.clone()).collect();
    for design in &mut designs {
        list.iter().zip(BEGIN).for_each(|(parameter, (_, value))| parameter.set(design, value));
    }
    if rubs {
        list.push(Parameter::parse("friction")?);
    }
    let rows: Vec<Measurement> = to.iter().flat_map(|i| wrists[*i].1[table].clone()).collect();
    let names: Vec<&str> = to.iter().map(|i| NAMES[*i]).collect();
    print!("{:<22}{:<14}", names.join(", "), TABLES[table]);
    let found = match fit(&designs, &rows, &list, None, None) {
        Ok(found) => found,
        Err(problem) => {
            println!("{problem}");
            return Ok(());
        }
    };
    for own in &found.estimates {
        let size = own.parameter.unit().1;
        let bound = if own.at_bound { "at bound" } else { "" };
        print!("{:>8.2} ± {:<5.2}{bound}", own.value / size, own.interval / size);
    }
    if !rubs {
        print!("{:>8} {:7}", "none", "");
    }
    let friction = found.estimates.get(3).map(|own| Friction { coefficient: own.value, guide: None });
    for (design, rows) in wrists {
        let mut design = design.clone();
        found.estimates.iter().for_each(|own| own.parameter.set(&mut design, own.value));
        match fit(&[design], &rows[0], &[], friction, None) {
            Ok(own) => print!("{:>8.1} %", missed(&own)),
            Err(problem) => print!("  {problem}"),
        }
    }
    if let (true, Some(own)) = (rubs, found.correlation.last()) {
        let others: Vec<String> = own[..3].iter().map(|own| format!("{own:+.2}")).collect();
        print!("    {}", others.join(", "));
    }
    println!();
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let wrists = NAMES.iter().map(|name| wrist(name)).collect::<Result<Vec<_>, _>>()?;
    print!("fitted to             by            E (GPa)         onset (%)       second (GPa)    friction");
    println!("         rms 150   rms 90    correlations of friction");
    for (table, rubs) in [(0, false), (1, false), (1, true), (2, false), (2, true)] {
        for to in [&[0][..], &[1], &[0, 1]] {
            fitted(&wrists, to, table, rubs)?;
        }
    }
    Ok(())
}
