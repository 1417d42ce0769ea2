//! Screw hinges: what closed forms say of them, in trees and in loops.

use crate::common::{Random, build};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::model::couplings::{Closure, LoopDescription};
use stillpoint::model::description::{
    Attachment, BodyDescription, Description, HingeDescription, HingeKind, LimitDescription, Point, StopLaw,
};
use stillpoint::record::Fanout;
use stillpoint::simulate::{self, Settings, State};
use stillpoint::statics::{self, Method, equilibrium};

/// How far along the axis its centre of mass is from where the hinge sits (m).
const CENTER: f64 = 0.03;

/// A nut on a fixed screw.
struct Nut {
    axis: Vector3<f64>,
    pitch: f64,
    mass: f64,
    /// About the axis.
    inertia: f64,
    gravity: Vector3<f64>,
}

impl Nut {
    /// Any axis, pitches from fine to coarse, right- and left-handed; its centre of mass is on the axis.
    fn random(seed: u64) -> Self {
        let random = &mut Random::new(seed);
        let size = 10.0_f64.powf(random.between(-4.0, 0.0));
        Self {
            axis: random.unit(),
            pitch: if random.below(2) == 0 { size } else { -size },
            mass: random.between(0.1, 10.0),
            inertia: 10.0_f64.powf(random.between(-5.0, 0.0)),
            gravity: random.vector(10.0),
        }
    }

    fn description(&self, hinge: HingeDescription) -> Description {
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &self.axis).expect("a turn");
        let across = 0.7 * self.inertia;
        let body = BodyDescription::new("nut", HingeDescription { frame: turn, ..hinge })
            .mass(self.mass)
            .center([0.0, 0.0, CENTER])
            .inertia([across, across, self.inertia]);
        Description { gravity: self.gravity, ..Description::new("nut").body(body) }
    }

    fn screw(&self) -> HingeDescription {
        HingeDescription::screw([0.0, 0.0, 2.5], self.pitch)
    }

    /// Torque of the weight per angle: `m g·n p`.
    fn torque(&self) -> f64 {
        self.mass * self.gravity.dot(&self.axis) * self.pitch
    }
}

/// `(I + m p²) q̈ = m g·n p`: a nut falls along its axis with `g p²/(p² + I/m)`. What is summed are the moments of the weight
/// and of the spin, larger than what is left of them: each is known to some units in its last place.
#[test]
fn a_nut_falls_as_its_inertia_and_pitch_say() {
    let rate = 3.0;
    for seed in 0..300 {
        let nut = Nut::random(seed);
        let model = build(&nut.description(nut.screw()));
        let mut a = [0.0];
        System::new(&model).at(0.0, &[0.4], &[rate]).accelerations(&mut a).expect("accelerations");
        let resisting = nut.inertia + nut.mass * nut.pitch * nut.pitch;
        let weight = nut.mass * nut.gravity.norm() * (nut.pitch.abs() + CENTER);
        let sizes = (weight + nut.inertia * rate * rate) / resisting;
        let expected = nut.torque() / resisting;
        assert!((a[0] - expected).abs() < 1e-14 * sizes, "seed {seed}: {} {expected}", a[0]);
    }
}

/// A spring carries the weight at `q = m g·n p / k`, however many turns that is. In maximal coordinates a step of Newton's
/// turns a link by less than half a turn: there it is found as far as that.
#[test]
fn a_spring_carries_a_nut_many_turns_along_its_thread() {
    for (method, most) in [(Method::Auto, 30.0), (Method::Relaxation, 30.0), (Method::Lagrange, 0.3)] {
        for seed in 0..40 {
            let nut = Nut::random(seed);
            let turns = Random::new(seed + 1000).between(-most, most);
            let stiffness = (nut.torque() / (turns * TAU)).abs();
            let expected = nut.torque() / stiffness;
            let mut description = nut.description(nut.screw());
            description.bodies[0].hinge.stiffness = vec![stiffness];
            let model = build(&description);
            let settings = statics::Settings { method, ..statics::Settings::default() };
            let found = equilibrium(&model, &settings, &model.start_position).expect("statics");
            assert!(found.converged, "seed {seed} by {method:?}: {:?}", found.notes);
            // Balanced means 1e-10 of the forces that cancel.
            let apart = (found.position[0] - expected).abs();
            assert!(apart < 1e-9 * expected.abs(), "seed {seed} by {method:?}: {} {expected}", found.position[0]);
            let stability = found.stability.as_ref().expect("a stable equilibrium");
            let frequency = (stiffness / (nut.inertia + nut.mass * nut.pitch * nut.pitch)).sqrt() / TAU;
            let mode = stability.modes[0].frequency_hz;
            assert!((mode - frequency).abs() < 1e-9 * frequency, "seed {seed} by {method:?}: {mode} {frequency}");
        }
    }
}

/// A rigid stop is struck at the speed that the fall gives, and reflects it.
#[test]
fn a_stop_of_a_screw_is_struck_at_the_speed_of_the_fall() {
    for seed in 0..20 {
        let nut = Nut::random(seed);
        let acceleration = nut.torque() / (nut.inertia + nut.mass * nut.pitch * nut.pitch);
        let (reach, sign) = (5.0 * TAU, acceleration.signum());
        let mut description = nut.description(nut.screw());
        let law = StopLaw::Rigid { restitution: 0.5 };
        let limit = LimitDescription { coordinate: 0, low: -reach, high: reach, law };
        description.bodies[0].hinge.limits = vec![limit];
        let model = build(&description);
        let strikes = (2.0 * reach / acceleration.abs()).sqrt();
        let settings = Settings { duration: 1.2 * strikes, tolerance: 1e-10, ..Settings::default() };
        let start = State { position: vec![0.0], velocity: vec![0.0] };
        let found = simulate::run(&model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true);
        let found = found.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        // Back with half the speed for a fifth of the time of the fall.
        let (speed, back) = (0.5 * acceleration.abs() * strikes, 0.2 * strikes);
        let expected = sign * (reach - speed * back + 0.5 * acceleration.abs() * back * back);
        let apart = (found.state.position[0] - expected).abs();
        assert!(apart < 1e-8 * reach, "seed {seed}: {} {expected}", found.state.position[0]);
    }
}

/// A nut that slides, and the rod that a loop of type `screw` turns in it: one degree of freedom, the same as one nut that
/// turns by itself, through many turns of the thread.
#[test]
fn a_threaded_loop_moves_as_the_screw_in_the_tree() {
    for seed in 0..20 {
        let nut = Nut::random(seed);
        let acceleration = nut.torque() / (nut.inertia + nut.mass * nut.pitch * nut.pitch);
        let mut description = nut.description(HingeDescription::prismatic([0.0, 0.0, 1.0]));
        let frame = description.bodies[0].hinge.frame;
        let rod = HingeDescription { frame, ..HingeDescription::revolute([0.0, 0.0, 1.0]) };
        let [across, about] = [0.7 * nut.inertia, nut.inertia];
        description.bodies.push(BodyDescription::new("rod", rod).mass(0.3).inertia([across, across, about]));
        let end = |body: &str| Attachment { body: body.to_owned(), point: Point::At(Vector3::zeros()) };
        description.loops.push(LoopDescription {
            name: "thread".to_owned(),
            closure: Closure::Hinge(HingeKind::Screw { axis: Vector3::z(), pitch: nut.pitch }),
            // The rod turns against the nut as the nut would turn on a rod that stands.
            between: [end("rod"), end("nut")],
            frame: UnitQuaternion::identity(),
            second_frame: Some(UnitQuaternion::identity()),
        });
        let model = build(&description);
        assert_eq!(model.degrees_of_freedom(), 1);
        let duration = (2.0 * 8.0 * TAU / acceleration.abs()).sqrt();
        let settings = Settings { duration, tolerance: 1e-9, ..Settings::default() };
        let start = State { position: model.start_position.clone(), velocity: vec![0.0; 2] };
        let found = simulate::run(&model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true);
        let found = found.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let at = |body: &str| found.state.position[model.bodies[model.body(body).expect("a body")].hinge.position];
        let angle = 8.0 * TAU * acceleration.signum();
        assert!((at("rod") + angle).abs() < 1e-6 * angle.abs(), "seed {seed}: {} {angle}", at("rod"));
        assert!((at("nut") - nut.pitch * angle).abs() < 1e-6 * (nut.pitch * angle).abs(), "seed {seed}: {}", at("nut"));
        assert!(found.constraint_error < 1e-9, "seed {seed}: {:e}", found.constraint_error);
    }
}

/// A pitch of zero, or one that is not finite, is refused in trees and in loops alike.
#[test]
fn a_pitch_of_nothing_is_refused() {
    for pitch in [0.0, -0.0, f64::NAN, f64::INFINITY] {
        let mut found = Vec::new();
        HingeKind::Screw { axis: Vector3::x(), pitch }.check("hinge of `nut`", &mut |key, message, _| {
            found.push((key, message));
        });
        let [(key, message)] = &found[..] else { panic!("{found:?}") };
        assert!(*key == "pitch" && message.contains("hinge of `nut`"), "{message}");
        assert!(
            Model::build(
                &Description::new("").body(
                    BodyDescription::new("nut", HingeDescription::screw([0.0, 0.0, 1.0], pitch))
                        .mass(1.0)
                        .inertia([0.1; 3])
                )
            )
            .is_err()
        );
    }
}
