//! Steady motions: frequencies and verdicts with Coriolis forces.

use crate::common::Random;
use std::f64::consts::TAU;
use stillpoint::model::Model;
use stillpoint::scenario::parse;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

/// Two sliders across a shaft that turns: springs `k`, masses of the first and the second.
struct Shaft {
    rate: f64,
    stiffness: [f64; 2],
    mass: [f64; 2],
    damping: f64,
}

impl Shaft {
    fn new(random: &mut Random) -> Self {
        let stiffness = [random.between(5.0, 60.0), random.between(5.0, 60.0)];
        let mass = [random.between(0.1, 1.0), random.between(0.5, 2.0)];
        Self { rate: random.between(0.5, 12.0), stiffness, mass, damping: 0.0 }
    }

    fn found(&self) -> Equilibrium {
        let Self { rate, stiffness: [ky, kz], mass: [first, second], damping } = self;
        let text = format!(
            "gravity = [0.0, 0.0, 0.0]\n[statics]\nwant = \"any\"\n[[body]]\nname = \"hub\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [1, 0, 0] }}\n[[body]]\nname = \"y\"\nmass = {first}\n\
             hinge = {{ type = \"prismatic\", parent = \"hub\", axis = [0, 1, 0], stiffness = {ky}, damping = {damping} }}\n[[body]]\nname = \"z\"\nmass = {second}\n\
             hinge = {{ type = \"prismatic\", parent = \"y\", axis = [0, 0, 1], stiffness = {kz}, damping = {damping} }}\n\
             [[drive]]\nname = \"motor\"\nhinge = \"hub\"\ntype = \"rate\"\nrate = {rate}\n"
        );
        let scenario = parse("shaft.toml", &text, &[]).expect("a scene");
        let model = Model::build(&scenario.description).expect("a model");
        equilibrium(&model, &scenario.statics, &model.start_position).expect("statics")
    }

    /// `ω²` of `(k_y − M_y (Ω² + ω²)) (k_z − M_z (Ω² + ω²)) = (2 Ω ω m)²`, the lower one first; `None` if they are no real numbers.
    fn squares(&self) -> Option<[f64; 2]> {
        let (o, [ky, kz], [my, mz]) =
            (self.rate * self.rate, self.stiffness, [self.mass[0] + self.mass[1], self.mass[1]]);
        let (py, pz) = (ky - my * o, kz - mz * o);
        let (a, b, c) = (my * mz, -(py * mz + pz * my + 4.0 * o * mz * mz), py * pz);
        let root = b * b - 4.0 * a * c;
        (root >= 0.0).then(|| [-1.0, 1.0].map(|sign| (-b + sign * root.sqrt()) / (2.0 * a)))
    }
}

#[test]
fn frequencies_and_verdicts_of_shafts_have_coriolis_forces() {
    let mut random = Random::new(41);
    let (mut stable, mut unstable, mut held_by_coriolis) = (0, 0, 0);
    for case in 0..60 {
        let shaft = Shaft::new(&mut random);
        let found = shaft.found();
        let stability = found.stability.as_ref().expect("an equilibrium");
        match shaft.squares().filter(|squares| squares[0] > 0.0) {
            Some(squares) => {
                assert_eq!(stability.verdict, StabilityVerdict::Stable, "{case}: {squares:?}");
                let hertz: Vec<f64> = stability.frequencies().collect();
                assert_eq!(hertz.len(), 2, "{case}: {hertz:?}");
                for (hz, square) in hertz.iter().zip(squares) {
                    assert!((TAU * hz / square.sqrt() - 1.0).abs() < 1e-7, "{case}: {hertz:?}, {squares:?}");
                }
                stable += 1;
                let softest = (0..2)
                    .map(|i| shaft.stiffness[i] / if i == 0 { shaft.mass[0] + shaft.mass[1] } else { shaft.mass[1] });
                held_by_coriolis += usize::from(softest.fold(f64::INFINITY, f64::min) < shaft.rate * shaft.rate);
            }
            None => {
                assert_eq!(stability.verdict, StabilityVerdict::Unstable, "{case}");
                unstable += 1;
            }
        }
    }
    assert!(stable > 10 && unstable > 5 && held_by_coriolis > 2, "{stable} {unstable} {held_by_coriolis}");
}

/// Without damping and with next to none frequencies are the same.
#[test]
fn little_damping_changes_no_frequency() {
    let mut random = Random::new(5);
    let mut seen = 0;
    for _ in 0..40 {
        let shaft = Shaft::new(&mut random);
        let without = shaft.found();
        let with = Shaft { damping: 1e-9, ..shaft }.found();
        let stability = without.stability.as_ref().expect("an equilibrium");
        if stability.verdict != StabilityVerdict::Stable {
            continue;
        }
        let damped = &with.stability.as_ref().expect("an equilibrium").damped;
        for (hz, mode) in stability.frequencies().zip(damped) {
            assert!((hz / mode.frequency_hz - 1.0).abs() < 1e-6, "{hz} and {}", mode.frequency_hz);
        }
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
}
