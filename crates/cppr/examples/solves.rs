//! Solves one case of the benchmark many times, for profilers and for counting instructions:
//! `valgrind --tool=callgrind target/release/examples/solves space_two_tubes_warm 1000`, with a third word `batch` side by
//! side, with `tip` one by one with the pose of the tip. Without arguments it lists the cases and the cost of one solve.
#![allow(clippy::unwrap_used)]

#[path = "../benches/solve/cases.rs"]
mod cases;
#[path = "../tests/common/mod.rs"]
mod common;

use cases::{BatchRunner, Case, NAMES, Runner};
use cppr::many::WIDTH;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(name) = arguments.first() else {
        for name in NAMES {
            let mut runner = Runner::new(Case::named(name).unwrap());
            runner.once();
            println!("{name}: {:?}", runner.equilibrium.statistics());
        }
        return;
    };
    let count: usize = arguments.get(1).map_or(Ok(1000), |c| c.parse()).unwrap();
    let case = Case::named(name).unwrap();
    let word = arguments.get(2).map(String::as_str);
    if word == Some("batch") {
        let mut runner = BatchRunner::new(case, WIDTH);
        (0..count.div_ceil(WIDTH)).for_each(|_| {
            runner.once();
        });
    } else {
        let mut runner = Runner::new(case);
        for _ in 0..count {
            runner.once();
            if word == Some("tip") {
                std::hint::black_box(runner.tip());
            }
        }
    }
}
