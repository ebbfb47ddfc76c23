//! Times on one core: `cargo bench -p cppr --bench solve`. What one solve costs in Newton steps:
//! `cargo run --release -p cppr --example solves`.
#![allow(clippy::unwrap_used)]

mod cases;
#[path = "../../tests/common/mod.rs"]
mod common;
mod straightforward;

use cases::{BatchRunner, Case, NAMES, Runner};
use cppr::many::WIDTH;
use divan::Bencher;
use divan::counter::ItemsCount;
use straightforward::Straightforward;

fn main() {
    divan::main();
}

fn case(name: &str) -> Case {
    Case::named(name).unwrap()
}

/// How many calls are timed at once: reading the clock takes some hundredths of a microsecond.
const CALLS: u32 = 16;

#[divan::bench(args = NAMES, sample_count = 200, sample_size = CALLS)]
fn one(bencher: Bencher, name: &str) {
    let mut runner = Runner::new(case(name));
    bencher.bench_local(|| runner.once());
}

const BATCHES: [&str; 4] =
    ["planar_two_tubes_warm", "space_two_tubes_warm", "space_two_tubes_cold", "three_tubes_warm"];

/// One solve with the pose of the tip, which a batch finds as well.
#[divan::bench(args = BATCHES, sample_count = 200, sample_size = CALLS)]
fn one_with_tip(bencher: Bencher, name: &str) {
    let mut runner = Runner::new(case(name));
    bencher.bench_local(|| {
        runner.once();
        runner.tip()
    });
}

/// Many solves in one call, side by side where lanes allow; the throughput is that of poses.
#[divan::bench(args = BATCHES, sample_count = 200, sample_size = CALLS)]
fn batch(bencher: Bencher, name: &str) {
    let mut runner = BatchRunner::new(case(name), WIDTH);
    bencher.counter(ItemsCount::new(WIDTH)).bench_local(|| runner.once());
}

/// What the equations of the robot alone allow without exact derivatives: Newton's method on a finite-difference Jacobian, and a
/// loop around it that adjusts the tension until the follower stands where it should.
#[divan::bench(args = ["planar_two_tubes_cold", "space_two_tubes_cold"], sample_count = 20)]
fn straightforward(bencher: Bencher, name: &str) {
    let case = case(name);
    let wanted = case.commands[0].actuators[0].push_pull.value();
    let mut found = Straightforward::new(&case);
    bencher.bench_local(|| found.solve(wanted));
    assert!((found.motion - wanted).abs() < 1e-9);
}
