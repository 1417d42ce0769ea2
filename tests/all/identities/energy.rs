//! Energy and power.

use super::{Start, scenes};
use crate::oracle::{self, place};
use stillpoint::dynamics::System;
use stillpoint::model::Description;

/// What remains of the error of the differences (see [`Start::rate`]), relative to the powers at work.
const TOLERANCE: f64 = 1e-9;

#[test]
fn energy_changes_by_what_loads_and_motors_put_in_and_dampers_take_out() {
    for (seed, description) in scenes() {
        let start = Start::of(&description);
        let rates = start.rate(|system, q, v| {
            let energies = system.at(0.0, q, v).energies();
            vec![energies.kinetic, energies.potential]
        });
        let mut system = System::new(&start.model);
        let powers = system.at(0.0, &start.model.start_position, &start.model.start_velocity).powers();
        assert!(powers.dissipated > 0.0, "seed {seed}");
        let error = (rates[0] + rates[1] - powers.input + powers.dissipated).abs();
        let scale = rates[0].abs() + rates[1].abs() + powers.input.abs() + powers.dissipated;
        assert!(error < TOLERANCE * scale, "seed {seed}: {error:e} of {scale}");
    }
}

#[test]
fn kinetic_energy_grows_by_the_power_of_every_single_force() {
    for (seed, description) in scenes() {
        let start = Start::of(&description);
        let rate = start.rate(|system, q, v| vec![system.at(0.0, q, v).energies().kinetic])[0];
        let powers = every_power(&description);
        let error = (rate - powers.iter().sum::<f64>()).abs();
        let scale: f64 = powers.iter().map(|power| power.abs()).sum();
        assert!(error < TOLERANCE * scale, "seed {seed}: {error:e} of {scale}");
    }
}

/// Of weights, force elements and hinge forces one by one, by the laws as the oracle knows them.
fn every_power(description: &Description) -> Vec<f64> {
    let count = description.bodies.len();
    let placed: Vec<_> = (0..count).map(|index| place::place(description, Some(index))).collect();
    let mut powers = Vec::new();
    for (body, at) in description.bodies.iter().zip(&placed) {
        powers.push(body.mass.mass * description.gravity.dot(&at.velocity_at(&at.center)));
        let forces = oracle::hinge_force::of(&body.hinge);
        powers.extend(forces.iter().zip(place::velocity_of(&body.hinge)).map(|(force, v)| force * v));
    }
    for push in oracle::force::pushes(description, &placed) {
        let at = push.body.map_or(place::Placed::GROUND, |body| placed[body]);
        powers.push(push.force.dot(&at.velocity_at(&push.at)) + push.torque.dot(&at.spin));
    }
    powers
}

/// T = ½ vᵀ M v with the mass matrix of the linearization, which is symmetric, and which `solve_mass` inverts. Errors are
/// round-off; 1e-12 leaves four digits to the conditioning of M.
#[test]
fn mass_matrix_is_symmetric_carries_the_kinetic_energy_and_is_inverted_by_the_reduction() {
    for (seed, description) in scenes() {
        let start = Start::of(&description);
        let (q, v, n) = (&start.model.start_position, &start.model.start_velocity, start.model.velocity_count());
        let mut system = System::new(&start.model);
        let mass = system.at(0.0, q, v).linearize(&start.a).unwrap().mass;
        let size = mass.norm_max();
        assert!((&mass - mass.transpose()).norm_max() < 1e-13 * size, "seed {seed}");
        let sum: f64 = (0..n).map(|i| (0..n).map(|j| 0.5 * v[i] * mass[(i, j)] * v[j]).sum::<f64>()).sum();
        let kinetic = system.at(0.0, q, v).energies().kinetic;
        assert!((sum - kinetic).abs() < 1e-12 * kinetic, "seed {seed}: {sum} {kinetic}");
        let mut a = vec![0.0; n];
        let mut at = system.at(0.0, q, v);
        let mut reduction = at.accelerations(&mut a).unwrap();
        for j in 0..n {
            let column: Vec<f64> = (0..n).map(|i| mass[(i, j)]).collect();
            reduction.solve_mass(&column, &mut a);
            a[j] -= 1.0;
            let worst = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            assert!(worst < 1e-12, "seed {seed} column {j}: {worst:e}");
        }
    }
}
