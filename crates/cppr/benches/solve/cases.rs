//! The cases that are timed and whose instructions are counted: robots are uniform (R1), tapered (R3) or a bundle of three.
//!
//! A warm case moves one equilibrium to and fro between neighbours 0.02 mm apart, as a controller would; a cold one
//! starts at rest. "jacobian" adds tip Jacobian and compliance.

use crate::common::{prototype, robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::{ACCURACY, Sensitivity};
use cppr::design::{BelowPlate, Robot};
use cppr::kinematics::{Resolution, TipPose};
use cppr::many::Batch;
use cppr::solve::{Command, CommandProblem, Equilibrium, Settings, Solver};
use cppr::statics::Loads;
use std::f64::consts::TAU;

/// Modes of the paper in space: 3 + 3 + 3 + 2.
pub const PAPER: Resolution =
    Resolution { twist: 3, bending_y: 3, bending_z: 3, angle: 2, stretch: 0, nodes: 6 };

/// One thing to time.
pub struct Case {
    pub robot: Robot,
    pub commands: [Command; 2],
    pub settings: Settings,
    pub warm: bool,
    pub jacobian: bool,
}

/// Their names.
pub const NAMES: [&str; 11] = [
    "planar_two_tubes_warm",
    "planar_two_tubes_cold",
    "planar_tapered_pushed_warm",
    "space_two_tubes_warm",
    "space_two_tubes_cold",
    "space_two_tubes_jacobian_warm",
    "space_two_tubes_default_cold",
    "three_tubes_warm",
    "three_tubes_cold",
    "plain_rod_warm",
    "plain_rod_fewest_modes_warm",
];

impl Case {
    /// The case of a name.
    pub fn named(name: &str) -> Option<Self> {
        let name = NAMES.into_iter().find(|known| *known == name)?;
        let pulled = |a: f64| Command::pull(&[a]);
        let loaded = |a: f64| pulled(a).with_loads(Loads::tip_force(Vector3::new(0.0, 0.05, 0.05)));
        let three = |a: f64| Command::pull(&[a, -3e-4]);
        let paper = Settings::default().with_resolution(PAPER);
        let two = |below| prototype("R1", 1.27, below);
        if name.starts_with("plain_rod") {
            return Some(Self::plain_rod(name.contains("fewest")));
        }
        let (robot, command, at, settings): (_, &dyn Fn(f64) -> Command, _, _) = if name.starts_with("three")
        {
            (three_tubes(), &three, 5e-4, paper)
        } else if name.starts_with("planar_tapered") {
            (prototype("R3", 1.26, BelowPlate::Plain), &pulled, -5e-3, Settings::planar())
        } else if name.starts_with("planar") {
            (two(BelowPlate::Continued), &pulled, 5e-3, Settings::planar())
        } else if name.contains("default") {
            (two(BelowPlate::Continued), &loaded, 5e-3, Settings::default())
        } else {
            (two(BelowPlate::Continued), &loaded, 5e-3, paper)
        };
        Some(Self {
            robot,
            commands: [command(at), command(at + 2e-5)],
            settings,
            warm: name.ends_with("warm"),
            jacobian: name.contains("jacobian"),
        })
    }

    /// A uniform rod, which the force on its tip moves by a thousandth of its length to and fro.
    fn plain_rod(fewest_modes: bool) -> Self {
        let robot = robot(1.0, vec![stiff_tube(0.0, [1.0, 1.0], 0.8, 0.0, 0.0)]);
        let force = |y: f64| Loads::tip_force(Vector3::new(-0.5, y, 1.0));
        let commands = [1.5, 1.503].map(|y| Command::pull(&[]).with_loads(force(y)));
        let mut solver = Solver::new(&robot);
        let settings =
            if fewest_modes { solver.fewest_modes(&commands, ACCURACY).settings } else { *solver.settings() };
        Self { robot, commands, settings, warm: true, jacobian: false }
    }
}

fn three_tubes() -> Robot {
    let tubes = [(1.12e-3, 1.96e-4, 1.78e-4), (0.983e-3, 1.81e-4, 1.78e-4), (0.764e-3, 1.83e-4, 1.89e-4)];
    let tubes = tubes
        .iter()
        .enumerate()
        .map(|(k, &(offset, y, z))| stiff_tube(offset, [y, z], 2.8e-4, TAU / 3.0 * k as f64, 0.0))
        .collect();
    robot(0.03, tubes)
}

/// A case and what it reuses.
pub struct Runner {
    pub case: Case,
    pub solver: Solver,
    rest: Equilibrium,
    pub equilibrium: Equilibrium,
    sensitivity: Sensitivity,
    turn: usize,
}

impl Runner {
    pub fn new(case: Case) -> Self {
        let mut solver = Solver::with_settings(&case.robot, case.settings).unwrap();
        let rest = solver.rest();
        let equilibrium = rest.clone();
        let mut runner =
            Self { case, solver, rest, equilibrium, sensitivity: Sensitivity::default(), turn: 0 };
        for _ in 0..2 {
            runner.once();
        }
        runner
    }

    /// One solve; returns the tension of the first follower.
    #[inline(never)]
    pub fn once(&mut self) -> f64 {
        let Self { case, solver, rest, equilibrium, sensitivity, turn } = self;
        *turn += 1;
        if !case.warm {
            equilibrium.copy(rest);
        }
        let command = &case.commands[*turn % 2];
        let solved = solver.solve_into(command, equilibrium);
        assert!(solved.is_ok() && equilibrium.status().is_equilibrium());
        if case.jacobian {
            assert!(solver.sensitivity_into(equilibrium, sensitivity).is_ok());
        }
        equilibrium.actuators().first().map_or(0.0, |own| own.tension)
    }
}

impl Runner {
    /// Where the tip is after the solve.
    pub fn tip(&mut self) -> TipPose {
        self.solver.tip(&self.equilibrium)
    }
}

/// Neighbouring commands of one case, solved in one call.
pub struct BatchRunner {
    case: Case,
    batch: Batch,
    commands: [Vec<Command>; 2],
    rest: Equilibrium,
    equilibria: Vec<Equilibrium>,
    tips: Vec<Result<TipPose, CommandProblem>>,
    turn: usize,
}

impl BatchRunner {
    pub fn new(case: Case, count: usize) -> Self {
        let mut batch = Batch::new(Solver::with_settings(&case.robot, case.settings).unwrap());
        let rest = batch.solver().rest();
        // Neighbours differ by micrometres, as in a sweep.
        let commands = [0, 1].map(|side: usize| {
            let spread = |i: usize| {
                let mut command = case.commands[side].clone();
                let drive = &mut command.actuators[0].push_pull;
                *drive = drive.with_value(drive.value() + 1e-6 * i as f64);
                command
            };
            (0..count).map(spread).collect()
        });
        let equilibria = vec![rest.clone(); count];
        let mut runner = Self { case, batch, commands, rest, equilibria, tips: Vec::new(), turn: 0 };
        for _ in 0..2 {
            runner.once();
        }
        runner
    }

    /// All of them once; returns the last tension.
    #[inline(never)]
    pub fn once(&mut self) -> f64 {
        self.turn += 1;
        if !self.case.warm {
            self.equilibria.iter_mut().for_each(|e| e.copy(&self.rest));
        }
        let Self { case: _, batch, commands, equilibria, tips, turn, .. } = self;
        batch.solve(&commands[*turn % 2], equilibria, tips);
        assert!(tips.iter().all(Result::is_ok) && equilibria.iter().all(|e| e.status().is_equilibrium()));
        equilibria.last().map_or(0.0, |e| e.actuators()[0].tension)
    }
}
