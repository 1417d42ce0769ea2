//! What the routines of a scene cost, over sizes and shapes: `cargo bench --no-default-features --features scenario`.
//!
//! For a scene of your own there is `stillpoint bench`; beside other simulators there is `benches/peers`.

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use criterion::{BatchSize, Bencher, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::fmt::Write;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use stillpoint::dynamics::{Coefficients, System, TangentSolver};
use stillpoint::integrate::{Method, Options, Start};
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::simulate::problem::Equations;
use stillpoint::statics;

/// The call that ends the second thread of `two_threads`.
const END: u64 = u64::MAX;

/// Bars of 0.2 m and 1 kg along their own x axis; `parent(i)` is the bar that carries bar `i > 0` at its tip, `hinge(i)`
/// the type of its hinge and what belongs to it.
fn bars(count: usize, parent: impl Fn(usize) -> usize, hinge: impl Fn(usize) -> String) -> Arc<Model> {
    let mut text = String::new();
    for i in 0..count {
        let place = match i {
            0 => "at = [0.0, 0.0, 0.0]".to_owned(),
            _ => format!("parent = \"b{}\", at = [0.2, 0.0, 0.0]", parent(i)),
        };
        let mass = "mass = 1.0\ncenter = [0.1, 0.0, 0.0]\ninertia = [1.25e-3, 4e-3, 4e-3]";
        writeln!(text, "[[body]]\nname = \"b{i}\"\n{mass}\nhinge = {{ {place}, {} }}", hinge(i)).unwrap();
    }
    let scenario = scenario::parse("bars", &text, &[]).unwrap();
    Model::build(&scenario.description).unwrap()
}

/// Bent, moving, its axes across each other in turn.
fn revolute(i: usize) -> String {
    let (axis, angle) = ([[0, 1, 0], [1, 0, 0]][i % 2], 0.5 * (1.7 * i as f64).sin());
    format!("type = \"revolute\", axis = {axis:?}, position = {angle:?}, velocity = {:?}", 2.0 * angle)
}

fn spherical(i: usize) -> String {
    let half = 0.25 * (1.7 * i as f64).sin();
    format!("type = \"spherical\", position = [{:?}, 0, {:?}, 0], velocity = [0.3, -0.5, 0.7]", half.cos(), half.sin())
}

fn chain(n: usize) -> Arc<Model> {
    bars(n, |i| i - 1, revolute)
}

fn spherical_chain(n: usize) -> Arc<Model> {
    bars(n, |i| i - 1, spherical)
}

fn tree(depth: u32) -> Arc<Model> {
    bars((1 << depth) - 1, |i| (i - 1) / 2, |i| revolute((i + 1).ilog2() as usize))
}

fn accelerations(c: &mut Criterion) {
    let mut group = c.benchmark_group("accelerations");
    let mut measure = |name: &str, model: &Arc<Model>| {
        let mut system = System::new(model);
        let mut a = model.start_velocity.clone();
        group.throughput(Throughput::Elements(model.bodies.len() as u64));
        group.bench_function(BenchmarkId::new(name, model.bodies.len()), |b: &mut Bencher<'_>| {
            b.iter(|| {
                let (q, v) = (black_box(&model.start_position), black_box(&model.start_velocity));
                system.at(0.0, q, v).accelerations(&mut a).unwrap();
            });
        });
    };
    for n in [1, 10, 100, 1000, 10_000, 100_000] {
        measure("chain", &chain(n));
    }
    for n in [10, 100] {
        measure("spherical chain", &spherical_chain(n));
    }
    for depth in [6, 10] {
        measure("tree", &tree(depth));
    }
}

/// Two trees one after the other, and at once on two threads that wait for each other in a busy loop: what the two halves of
/// one tree could gain from a second core at most, with nothing to join at the root and the cheapest of all signals.
fn two_threads(c: &mut Criterion) {
    let mut group = c.benchmark_group("two trees");
    for depth in [5, 7, 9, 11, 13, 15] {
        let model = tree(depth);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let count = 2 * model.bodies.len();
        let [mut first, mut second] = [System::new(&model), System::new(&model)];
        let [mut a, mut b] = [v.clone(), v.clone()];
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("in turn", count), |bencher| {
            bencher.iter(|| {
                first.at(0.0, black_box(q), v).accelerations(&mut a).unwrap();
                second.at(0.0, black_box(q), v).accelerations(&mut b).unwrap();
            });
        });
        let (asked, answered) = (AtomicU64::new(0), AtomicU64::new(0));
        std::thread::scope(|threads| {
            threads.spawn(|| {
                let mut seen = 0;
                loop {
                    let call = asked.load(Ordering::Acquire);
                    match call {
                        END => break,
                        call if call == seen => std::hint::spin_loop(),
                        call => {
                            second.at(0.0, black_box(q), v).accelerations(&mut b).unwrap();
                            seen = call;
                            answered.store(call, Ordering::Release);
                        }
                    }
                }
            });
            let mut call = 0;
            group.bench_function(BenchmarkId::new("at once", count), |bencher| {
                bencher.iter(|| {
                    call += 1;
                    asked.store(call, Ordering::Release);
                    first.at(0.0, black_box(q), v).accelerations(&mut a).unwrap();
                    while answered.load(Ordering::Acquire) != call {
                        std::hint::spin_loop();
                    }
                });
            });
            asked.store(END, Ordering::Release);
        });
    }
}

/// One factorization of the full tangent of an implicit step, and one solution with it.
fn tangent(c: &mut Criterion) {
    let mut group = c.benchmark_group("tangent solve");
    let mut measure = |name: &str, model: &Arc<Model>| {
        let (q, v) = (&model.start_position, &model.start_velocity);
        let (mut system, mut solver) = (System::new(model), TangentSolver::new(model));
        let (mut a, mut x) = (v.clone(), v.clone());
        system.at(0.0, q, v).accelerations(&mut a).unwrap();
        let with = Coefficients { c1: 1e2, c2: 1e4, ..Coefficients::default() };
        group.throughput(Throughput::Elements(model.bodies.len() as u64));
        group.bench_function(BenchmarkId::new(name, model.bodies.len()), |b: &mut Bencher<'_>| {
            b.iter(|| {
                assert!(system.at(0.0, black_box(q), v).factorize_tangent(&mut solver, &a, &with).unwrap());
                x.fill(1.0);
                solver.solve(&mut x);
            });
        });
    };
    for n in [1, 10, 100, 1000, 10_000, 100_000] {
        measure("chain", &chain(n));
    }
    measure("spherical chain", &spherical_chain(100));
    measure("tree", &tree(10));
}

/// From horizontal to hanging, certificate and lowest modes included.
fn equilibrium(c: &mut Criterion) {
    let horizontal = |_| "type = \"revolute\", axis = [0, 1, 0]".to_owned();
    let model = bars(1000, |i| i - 1, horizontal);
    let mut group = c.benchmark_group("statics");
    group.sample_size(10);
    group.bench_function("chain/1000", |b| {
        b.iter(|| {
            let found = statics::equilibrium(&model, &statics::Settings::default(), &model.start_position).unwrap();
            assert!(found.converged);
        });
    });
}

/// The first step of the implicit method on a moving chain, 1 ms long.
fn implicit_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("implicit step");
    for n in [10, 1000] {
        let model = chain(n);
        let start = Start { time: 0.0, position: &model.start_position, velocity: &model.start_velocity, end: 1.0 };
        let options = Options { step: Some(1e-3), relative: 1e-6, absolute: 1e-6, ..Options::default() };
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new("sdirk4", n), |b| {
            let ready = || {
                let mut motion = Equations::new(&model);
                let stepper = Method::Sdirk4.start(&mut motion, &options, start).unwrap();
                (motion, stepper)
            };
            b.iter_batched(
                ready,
                |(mut motion, mut stepper)| {
                    stepper.step(&mut motion).unwrap();
                    (motion, stepper)
                },
                BatchSize::LargeInput,
            );
        });
    }
}

criterion_group!(benches, accelerations, two_threads, tangent, equilibrium, implicit_step);
criterion_main!(benches);
