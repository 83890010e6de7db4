//! Time of one call of every registered creep law with its default settings, on a typical contact of tread and rail.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use wheelrail::contact::creep::{REGISTRY, RollingContact, inline};
use wheelrail::contact::creepage::Creepage;
use wheelrail::contact::{Material, Patch};

fn laws(criterion: &mut Criterion) {
    let steel = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
    let creepage = Creepage { longitudinal: 1e-3, lateral: -8e-4, spin: 0.15 };
    let contact = RollingContact { patch: Patch { a: 6.5e-3, b: 5e-3 }, normal_force: 8e4, friction: 0.3, creepage, speed: 30.0 };
    let more = ["fastsim{strips=10, cells=10}"];
    for name in REGISTRY.iter().map(|entry| entry.name).chain(more) {
        let law = inline::law(name, "bench").unwrap_or_else(|error| panic!("{error}"))(steel);
        criterion.bench_function(&format!("creep/{name}"), |bencher| bencher.iter(|| law.force(black_box(&contact))));
    }
}

criterion_group!(benches, laws);
criterion_main!(benches);
