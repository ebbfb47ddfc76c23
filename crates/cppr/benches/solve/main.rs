//! Times on one core: `cargo bench -p cppr --bench solve`. What one solve costs in Newton steps:
//! `cargo run --release -p cppr --example solves`.
#![allow(clippy::unwrap_used)]

mod cases;
#[path = "../../tests/common/mod.rs"]
mod common;

use cases::{BatchRunner, Runner};
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

fn case(name: &str) -> cases::Case {
    cases::all().into_iter().find(|case| case.name == name).unwrap()
}

#[divan::bench(args = cases::all().iter().map(|case| case.name).collect::<Vec<_>>(), sample_count = 200)]
fn one(bencher: Bencher, name: &str) {
    let mut runner = Runner::new(case(name));
    bencher.bench_local(|| runner.once());
}

/// Many solves in one call, side by side where lanes allow; the throughput is that of poses.
#[divan::bench(args = ["planar_two_tubes_warm", "space_two_tubes_warm", "space_two_tubes_cold", "three_tubes_warm"])]
fn batch(bencher: Bencher, name: &str) {
    let mut runner = BatchRunner::new(case(name), 256);
    bencher.counter(ItemsCount::new(256_usize)).bench_local(|| runner.once());
}
