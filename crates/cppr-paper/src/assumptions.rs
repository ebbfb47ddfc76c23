//! What section 4 leaves out or takes for granted: weight, friction, the step of stiffness at the plate, the modulus.

use crate::bench::{actuated, build, consistent, design, distance, robot, solved};
use crate::page::{Page, cell};
use crate::{PaperError, Scenario};
use cppr::Vector3;
use cppr::design::{BelowPlate, RobotDesign, TubeDesign};
use cppr::statics::Loads;

/// m/s².
const GRAVITY: f64 = 9.81;
/// Times the calibrated modulus.
const MODULI: [f64; 2] = [0.6, 1.7];
/// Part of the length that is negligible (%).
const NEGLIGIBLE: f64 = 0.1;

/// The page.
pub fn assumptions(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    weight(scenario, page)?;
    page.text.push(
        "Friction. To prescribe the motion takes the friction of motor, screw and guides of the carriage out of the answer: whatever force \
         they need, the follower stands where it was put. Friction between the tubes, and between the follower and its guide, stays: it makes the \
         tension vary along the follower, and with it the shape between its ends, and adds to the force that is measured. Where the curvature is \
         constant the motion alone fixes the shape; elsewhere, and under a load, it does not."
            .into(),
    );
    step(scenario, page)?;
    modulus(scenario, page)
}

/// Motions that the paper asks of a robot.
fn pulls<'a>(scenario: &'a Scenario, name: &str) -> impl Iterator<Item = f64> + 'a {
    let most = if name == "r1" || name == "r2" { 7.0 } else { 11.0 };
    scenario.pulls_mm.iter().copied().filter(move |pull| pull.abs() <= most)
}

/// What the tubes' own weight moves, the robot standing, hanging, and lying with its bending plane upright and level.
fn weight(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    // In any way, and along X.
    let (mut rows, mut worst) = (Vec::new(), [0.0_f64; 2]);
    let ways = [
        ("standing", Vector3::new(-GRAVITY, 0.0, 0.0)),
        ("hanging", Vector3::new(GRAVITY, 0.0, 0.0)),
        ("lying, bending plane upright", Vector3::new(0.0, -GRAVITY, 0.0)),
        ("lying, bending plane level", Vector3::new(0.0, 0.0, -GRAVITY)),
    ];
    for name in &scenario.robots {
        let robot = robot(name)?;
        let mut row = vec![robot.design().name.clone()];
        for (way, gravity) in ways {
            let mut most = (0.0, 0.0);
            for pull in pulls(scenario, name) {
                let free = solved(&robot, &actuated(pull, 0.0), &consistent())?;
                let loads = Loads { gravity: Some(gravity), ..Loads::none() };
                let heavy = solved(&robot, &actuated(pull, 0.0).with_loads(loads), &consistent())?;
                let moved = distance(free.tip_mm(), heavy.tip_mm()) / robot.length() * 0.1;
                if moved > most.0 {
                    most = (moved, pull);
                }
            }
            page.number(format!("{name}/{way}/weight_moves_tip_percent"), most.0);
            worst[0] = worst[0].max(most.0);
            worst[1] = worst[1].max(if gravity.x.abs() > 0.0 { most.0 } else { 0.0 });
            row.extend([cell(most.0, 2), cell(most.1, 0)]);
        }
        rows.push(row);
    }
    let [worst, upright] = worst;
    page.number("weight_moves_tip_percent", worst);
    page.number("standing_weight_moves_tip_percent", upright);
    page.text.push(format!(
        "Weight. With a density of 1240 kg/m³ the tubes' own weight moves the tip by {} % of the length at most, whichever way the robot is mounted, and \
         by {} % where it stands or hangs: less than the errors that the paper reports, so that it may be left out.",
        cell(worst, 2),
        cell(upright, 2)
    ));
    page.table(
        "Largest move of the tip by the weight of the tubes, and at which motion.",
        &[
            "robot",
            "standing (% of L)",
            "at Δa (mm)",
            "hanging (% of L)",
            "at Δa (mm)",
            "lying, upright (% of L)",
            "at Δa (mm)",
            "lying, level (% of L)",
            "at Δa (mm)",
        ],
        rows,
    );
    Ok(())
}

/// Changes all notched tubes of a design.
fn changed(name: &str, change: impl Fn(&mut cppr::design::NotchedTube)) -> Result<RobotDesign, PaperError> {
    let mut design = design(name)?;
    for tube in &mut design.tubes {
        if let TubeDesign::Notched(tube) = tube {
            change(tube);
        }
    }
    Ok(design)
}

/// Remark 18: with the uncut follower below the plate, and without any step.
fn step(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let (mut rows, mut worst) = (Vec::new(), 0.0_f64);
    for name in &scenario.robots {
        let plain = robot(name)?;
        let even = build(changed(name, |tube| tube.below = BelowPlate::Continued)?)?;
        let [below, above, leader] =
            [(1, -1e-9), (1, 0.0), (0, 0.0)].map(|(tube, x)| plain.fields_at(tube, x).bending_z);
        let jump = below / above;
        let mut most = (0.0_f64, 0.0_f64, 0.0_f64, [0, 0]);
        for pull in pulls(scenario, name).filter(|pull| *pull < 0.0) {
            let uncut = solved(&plain, &actuated(pull, 0.0), &consistent())?;
            let other = solved(&even, &actuated(pull, 0.0), &consistent())?;
            let moved = distance(uncut.tip_mm(), other.tip_mm()) / plain.length() * 0.1;
            if moved > most.0 {
                let tension = (other.tension() / uncut.tension() - 1.0) * 100.0;
                let steps = [&uncut, &other].map(|state| state.found.statistics().iterations);
                most = (moved, tension, pull, steps);
            }
        }
        let (moved, tension, pull, [uncut, other]) = most;
        worst = worst.max(moved);
        // The bend of the part that was pushed in falls as 1/(EI_1 + r EI_2).
        let enough = moved / NEGLIGIBLE * (leader / above + 1.0) - leader / above;
        page.number(format!("{name}/step_of_stiffness"), jump);
        page.number(format!("{name}/step_that_is_enough"), enough);
        page.number(format!("{name}/step_moves_tip_percent"), moved);
        page.number(format!("{name}/step_changes_tension_percent"), tension);
        rows.push(vec![
            plain.design().name.clone(),
            cell(jump, 1),
            cell(enough, 0),
            cell(moved, 2),
            cell(tension, 1),
            cell(pull, 0),
            uncut.to_string(),
            other.to_string(),
        ]);
    }
    page.number("step_moves_tip_percent", worst);
    page.text.push(format!(
        "Remark 18. The stiffness of a pushed follower steps up where its uncut part begins. The paper took a smaller step, for the sake of its solver, and \
         does not say which. Some step is needed: without any, the notched stiffness going on below the plate, the tip moves by up to {} % of the \
         length. As the bend of the part that was pushed in falls as 1/(EI_1 + r EI_2), a ratio r as in the column \"enough\" would leave 0.1 % of the length: \
         well below the true one for R2 and R3, a little below for R4, but above it for R1, where the true step itself still bends. Here the true step \
         is kept: the elements end where it stands, and it costs two Newton steps more at most.",
        cell(worst, 2)
    ));
    page.table(
        "Pushed, uncut below the plate against notched on: the stiffness over that of the notched part, the ratio that would do (an estimate), the largest move of the \
         tip, the tension there, and the Newton steps of both.",
        &[
            "robot",
            "EI_2Z below / above",
            "enough for 0.1 % of L",
            "tip moves (% of L)",
            "T changes (%)",
            "at Δa (mm)",
            "steps, uncut",
            "steps, notched on",
        ],
        rows,
    );
    Ok(())
}

/// Remark 19: other moduli, free and under the thread's load.
fn modulus(scenario: &Scenario, page: &mut Page) -> Result<(), PaperError> {
    let (mut rows, mut free_most, mut loaded_least) = (Vec::new(), 0.0_f64, f64::INFINITY);
    for name in &scenario.robots {
        let nominal = robot(name)?;
        for factor in MODULI {
            let other = build(changed(name, |tube| tube.material.youngs_modulus *= factor)?)?;
            let (mut moved, mut tension) = ([0.0_f64; 2], 0.0_f64);
            for pull in pulls(scenario, name) {
                for (moved, force) in moved.iter_mut().zip([0.0, 0.1962]) {
                    let loads = Loads::tip_force(Vector3::new(0.0, force, 0.0));
                    let command = actuated(pull, 0.0).with_loads(loads);
                    let a = solved(&nominal, &command, &consistent())?;
                    let b = solved(&other, &command, &consistent())?;
                    *moved = moved.max(distance(a.tip_mm(), b.tip_mm()) / nominal.length() * 0.1);
                    if force <= 0.0 && pull.abs() > 0.0 {
                        let off = (b.tension() / a.tension() / factor - 1.0).abs();
                        tension = tension.max(off);
                    }
                }
            }
            free_most = free_most.max(moved[0]);
            loaded_least = loaded_least.min(moved[1]);
            page.number(format!("{name}/modulus x {factor}/free_tip_moves_percent"), moved[0]);
            page.number(format!("{name}/modulus x {factor}/loaded_tip_moves_percent"), moved[1]);
            page.number(format!("{name}/modulus x {factor}/tension_off_proportion"), tension);
            rows.push(vec![
                nominal.design().name.clone(),
                cell(factor, 1),
                power(moved[0]),
                power(tension),
                cell(moved[1], 2),
            ]);
        }
    }
    page.number("free_tip_moves_by_modulus_percent", free_most);
    page.number("loaded_tip_moves_by_modulus_percent", loaded_least);
    page.text.push(format!(
        "Remark 19 holds for a modulus that both tubes share: with 0.6 or 1.7 times of it the free shapes stay (the tip moves by {} % of the length at most) and \
         the forces change in proportion, while under 20 g the tip moves by {} % of the length or more.",
        power(free_most),
        cell(loaded_least, 1)
    ));
    page.table(
        "Young's modulus times a factor: largest move of the free tip, how far the tension is from proportional, largest move of the tip under 0.1962 N along Y.",
        &["robot", "E times", "free tip (% of L)", "T (-)", "loaded tip (% of L)"],
        rows,
    );
    Ok(())
}

/// A number near zero as a cell.
fn power(value: f64) -> String {
    format!("{value:.0e}").replace('-', "−")
}
