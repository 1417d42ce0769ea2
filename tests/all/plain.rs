//! The fast sweeps against the method as it is printed.

use crate::common::{Options, build, preload, random_scene, take_inertia};
use nalgebra::Vector6;
use std::sync::Arc;
use stillpoint::dynamics::applied;
use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
use stillpoint::model::{Joint, Model};
use stillpoint::motion::Motion;
use stillpoint::spatial::Wrench;
use stillpoint::transfer::balance::Balance;
use stillpoint::transfer::plain::{self, Solution};
use stillpoint::transfer::reduce::{Load, Reduction, Singular};

/// The transfer equations of the start of a scene.
struct Case {
    model: Arc<Model>,
    motion: Motion,
    applied: Vec<Wrench>,
    tau: Vec<f64>,
}

impl Case {
    fn of(model: Arc<Model>) -> Self {
        let (q, v) = (model.start_position.clone(), model.start_velocity.clone());
        let mut motion = Motion::new(&model);
        motion.update(&model, &q, &v);
        let mut applied = vec![Wrench::ZERO; model.links.len()];
        applied::apply(&applied::Laws::new(&model), &motion, &mut applied);
        let mut tau = v.clone();
        applied::hinge::apply(&model, &q, &v, &mut tau);
        Self { model, motion, applied, tau }
    }

    fn plain(&self) -> Result<Solution, Singular> {
        plain::accelerations(&self.model, &self.motion, &self.applied, &self.tau)
    }

    /// Hinge accelerations by the fast sweeps; accelerations and reactions of the links by inverse dynamics with them.
    fn fast(&self) -> Result<(Vec<f64>, Balance), Singular> {
        let Self { model, motion, applied, tau } = self;
        let mut hinge = vec![0.0; model.velocity_count()];
        let load = Load { applied, tau };
        Reduction::new(model).accelerations(model, motion, &load, &mut hinge)?;
        let mut balance = Balance::new(model);
        balance.update(model, motion, applied, tau, &hinge, &mut hinge.clone());
        Ok((hinge, balance))
    }

    /// Largest differences of hinge accelerations, of link accelerations and of reactions, each relative to the largest of
    /// its kind.
    fn differences(&self) -> [f64; 3] {
        let plain = self.plain().expect("a regular scene");
        let (hinge, balance) = self.fast().expect("a regular scene");
        let accelerations = balance.accelerations.iter().map(|a| flat(&a.linear, &a.angular));
        let reactions = balance.reactions.iter().map(|f| flat(&f.force, &f.moment));
        [
            worst(plain.hinge.iter().zip(&hinge).map(|(one, other)| ((one - other).abs(), one.abs()))),
            worst(plain.accelerations.iter().zip(accelerations).map(|(one, other)| ((one - other).amax(), one.amax()))),
            worst(plain.reactions.iter().zip(reactions).map(|(one, other)| ((one - other).amax(), one.amax()))),
        ]
    }
}

fn flat(linear: &nalgebra::Vector3<f64>, angular: &nalgebra::Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// Largest difference over largest size.
fn worst(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (difference, size) = pairs.fold((0.0_f64, 0.0_f64), |(d, s), (one, other)| (d.max(one), s.max(other)));
    assert!(difference.is_finite() && size > 0.0, "{difference} of {size}");
    difference / size
}

/// 400 trees of 1 to 40 bodies with every hinge, armature, spring and load. The equations have condition numbers up to 200
/// and both ways are sums of up to forty terms: 1e-16 grows to 1e-12 at worst. Measured is 3e-14.
#[test]
fn the_fast_sweeps_give_what_the_printed_method_gives() {
    let (mut kinds, mut armatures) = ([0; 4], 0);
    for seed in 0..400_u64 {
        let options = Options { bodies: 1 + seed as usize % 40, springs: seed % 4 != 0, welds: seed % 3 != 0 };
        let mut description = random_scene(seed + 40_000, &options);
        if seed % 2 == 1 {
            preload(&mut description);
        }
        let model = build(&description);
        if model.velocity_count() == 0 {
            continue;
        }
        for link in &model.links {
            match link.joint {
                Joint::None => {}
                Joint::Turn => kinds[0] += 1,
                Joint::Slide { .. } => kinds[1] += 1,
                Joint::Ball { .. } => kinds[2] += 1,
                Joint::Screw { .. } => kinds[3] += 1,
                Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {
                    unreachable!("no elements here")
                }
            }
        }
        armatures += model.coordinates.iter().filter(|coordinate| coordinate.armature > 0.0).count();
        let found = Case::of(model).differences();
        assert!(found.iter().all(|difference| *difference < 1e-12), "seed {seed}: {found:?}");
    }
    assert!(kinds.iter().all(|count| *count > 300) && armatures > 500, "{kinds:?} {armatures}");
}

/// Trees so large that the fast sweeps compute two halves at once.
#[test]
fn the_halves_of_a_large_tree_give_what_the_printed_method_gives() {
    for seed in [1, 2] {
        let model = two_branches(seed, 700);
        assert!(model.halves.is_some(), "{} links", model.links.len());
        let found = Case::of(model).differences();
        // Sums of some hundred terms that grow along a branch. Measured is 1e-12 (seed 1).
        assert!(found.iter().all(|difference| *difference < 1e-10), "seed {seed}: {found:?}");
    }
}

/// Two random chains of this many bodies on the ground.
fn two_branches(seed: u64, bodies: usize) -> Arc<Model> {
    let mut description = random_scene(seed, &Options { bodies: 2 * bodies, springs: true, welds: true });
    for index in 0..2 * bodies {
        let parent = if index % bodies == 0 { "ground".to_owned() } else { format!("b{}", index - 1) };
        let body = &mut description.bodies[index];
        body.hinge.parent = parent;
        // Rates add up along a chain: a thousandth of them leaves the ends as fast as bodies of a small tree.
        body.hinge.velocity.iter_mut().for_each(|rate| *rate *= 1e-3);
    }
    build(&description)
}

/// Both refuse a hinge that nothing with inertia resists, and name its link.
#[test]
fn a_hinge_without_inertia_is_refused_by_both() {
    let arm = |name: &str, parent: &str| {
        let hinge = HingeDescription::revolute([0.0, 1.0, 0.0]).on(parent, [0.0, 0.0, -1.0]);
        BodyDescription::new(name, hinge).mass(1.0).center([0.0, 0.0, -0.5])
    };
    let description = Description::new("arms").body(arm("upper", "ground")).body(arm("lower", "upper"));
    let mut model = build(&description);
    take_inertia(&mut model, "lower");
    let lower = model.bodies[model.body("lower").expect("the body")].link;
    let case = Case::of(model);
    for singular in [case.plain().expect_err("singular"), case.fast().map(|_| ()).expect_err("singular")] {
        assert_eq!((singular.link, singular.pivot), (lower, 0.0));
    }
}
