//! The examples run to their end.

#[path = "../../examples/equilibrium.rs"]
mod equilibrium;
#[path = "../../examples/recording.rs"]
mod recording;
#[path = "../../examples/stepping.rs"]
mod stepping;
#[path = "../../examples/sweep.rs"]
mod sweep;

#[test]
fn every_example_runs_to_its_end() {
    equilibrium::main().expect("equilibrium");
    recording::main().expect("recording");
    stepping::main().expect("stepping");
    sweep::main().expect("sweep");
}
