//! Identities of mechanics that hold for every scene, on random ones.

mod energy;
mod equivalence;
mod momentum;
mod symmetry;

use crate::common::{Options, build, random_scene};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::description::HingeKind;
use stillpoint::model::{Description, Model};
use stillpoint::spatial::Wrench;

/// 150 scenes of one to thirteen bodies with everything in them, less those where all is welded to the ground.
fn scenes() -> impl Iterator<Item = (u64, Description)> {
    let scene = |seed: u64| {
        let options = Options { bodies: 1 + (seed as usize * 5) % 13, springs: true, welds: true };
        (seed, random_scene(seed + 5000, &options))
    };
    let moves = |description: &Description| description.bodies.iter().any(|body| body.hinge.kind != HingeKind::Fixed);
    (0..150).map(scene).filter(move |(_, description)| moves(description))
}

/// A scene at its start: how its hinges accelerate and what they carry.
struct Start {
    model: Arc<Model>,
    a: Vec<f64>,
    reactions: Vec<Wrench>,
}

impl Start {
    fn of(description: &Description) -> Self {
        let model = build(description);
        let mut system = System::new(&model);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let (mut a, mut residual, mut reactions) = (v.clone(), v.clone(), Vec::new());
        let mut at = system.at(0.0, q, v);
        at.accelerations(&mut a).unwrap();
        at.residual(&a, &mut residual).unwrap().reactions(&mut reactions);
        Self { model, a, reactions }
    }

    /// Accelerations of the hinge of a named body.
    fn of_hinge(&self, name: &str) -> &[f64] {
        let hinge = &self.model.bodies[self.model.body(name).unwrap()].hinge;
        &self.a[hinge.velocity..hinge.velocity + hinge.kind.counts().1]
    }

    /// What its hinge passes to a named body.
    fn reaction(&self, name: &str) -> Wrench {
        self.reactions[self.model.body(name).unwrap()]
    }

    /// The rate of some numbers of the state while the scene moves, by central differences of order four along
    /// `q ⊞ t v, v + t a`, which touches the true motion at t = 0.
    ///
    /// The step of 3e-4 s is a few thousandths of a radian for the fastest bodies: what is left out is step⁴ times the
    /// fifth derivative, about 1e-10 of the terms; round-off is 1e-16/step, below 1e-12.
    fn rate(&self, mut f: impl FnMut(&mut System, &[f64], &[f64]) -> Vec<f64>) -> Vec<f64> {
        let step = 3e-4;
        let mut system = System::new(&self.model);
        let mut at = |time: f64| {
            let mut q = self.model.start_position.clone();
            let by: Vec<f64> = self.model.start_velocity.iter().map(|v| time * v).collect();
            System::displace(&self.model, &mut q, &by);
            let v: Vec<f64> = self.model.start_velocity.iter().zip(&self.a).map(|(v, a)| v + time * a).collect();
            f(&mut system, &q, &v)
        };
        let [far_back, back, ahead, far_ahead] = [-2.0, -1.0, 1.0, 2.0].map(|steps| at(steps * step));
        let weigh = |i: usize| 8.0 * (ahead[i] - back[i]) - (far_ahead[i] - far_back[i]);
        (0..ahead.len()).map(|i| weigh(i) / (12.0 * step)).collect()
    }
}
