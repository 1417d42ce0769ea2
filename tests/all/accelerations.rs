//! Accelerations and reactions of random scenes against the independent equations of motion of `oracle`.

use crate::common::{Options, Random, build, position_of, preload, random_scene, relative_difference};
use crate::oracle::place::quaternion;
use crate::oracle::{self, Answer};
use nalgebra::{UnitQuaternion, Vector3};
use stillpoint::dynamics::System;
use stillpoint::model::Description;
use stillpoint::model::description::{BodyDescription, ForceKind, HingeDescription, HingeKind, Load, LoadAxes};

/// What the sweeps make of the start of a scene, and how far that is from what the equations of every body say.
pub(crate) struct Comparison {
    /// Largest error of a hinge acceleration, relative to the largest one.
    pub(crate) acceleration: f64,
    /// Largest error of a hinge force or moment, relative to the largest one.
    pub(crate) reaction: f64,
    answer: Answer,
}

pub(crate) fn compare(description: &Description) -> Comparison {
    let model = build(description);
    let mut system = System::new(&model);
    let (q, v) = (&model.start_position, &model.start_velocity);
    let (mut a, mut residual) = (v.clone(), v.clone());
    let mut reactions = Vec::new();
    let mut at = system.at(0.0, q, v);
    at.accelerations(&mut a).unwrap();
    at.residual(&a, &mut residual).unwrap().reactions(&mut reactions);
    let answer = oracle::solve(description);
    let of_body = |index: usize| &a[model.bodies[index].hinge.velocity..];
    let per_hinge = answer.hinges.iter().enumerate();
    let found: Vec<f64> = per_hinge.flat_map(|(index, hinge)| of_body(index)[..hinge.len()].to_vec()).collect();
    let acceleration = relative_difference(&found, &answer.hinges.concat());
    let found: Vec<Vector3<f64>> = reactions.iter().flat_map(|wrench| [wrench.force, wrench.moment]).collect();
    let reaction = relative_difference(&flat(&found), &flat(&answer.reactions.concat()));
    Comparison { acceleration, reaction, answer }
}

fn flat(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|vector| vector.iter().copied().collect::<Vec<_>>()).collect()
}

/// 400 scenes, ten of every size from one to forty bodies.
fn scenes() -> impl Iterator<Item = (u64, Description)> {
    (0..400).map(|seed| {
        let options = Options { bodies: 1 + (seed as usize) % 40, springs: seed % 4 != 0, welds: seed % 3 != 0 };
        let mut description = random_scene(seed, &options);
        if seed % 2 == 1 {
            preload(&mut description);
        }
        (seed, description)
    })
}

/// The equations of these scenes have condition numbers (rows and columns scaled) of 3…200 and both ways of solving are
/// sums of up to forty terms: 1e-16 grows to 1e-12 at worst. Measured is 3e-14.
#[test]
fn random_trees_move_as_the_equations_of_every_single_body_say() {
    for (seed, description) in scenes() {
        let found = compare(&description);
        let worst = found.acceleration.max(found.reaction);
        assert!(
            worst < 1e-12,
            "seed {seed}: accelerations {:.1e}, reactions {:.1e}, condition number {:.1e}",
            found.acceleration,
            found.reaction,
            found.answer.condition()
        );
    }
}

/// The comparison above means something only if the scenes contain everything.
#[test]
fn the_random_trees_contain_every_hinge_and_every_force() {
    let (mut kinds, mut forces) = (std::collections::BTreeMap::new(), [0; 4]);
    let (mut armatures, mut torsion, mut rests) = (0, 0, 0);
    for (_, description) in scenes() {
        for hinge in description.bodies.iter().map(|body| &body.hinge) {
            *kinds.entry(hinge.kind.name()).or_insert(0) += 1;
            armatures += usize::from(!hinge.armature.is_empty());
            let ball = matches!(hinge.kind, HingeKind::Spherical | HingeKind::Free);
            torsion += usize::from(ball && !hinge.stiffness.is_empty());
            rests += usize::from(ball && !hinge.rest.is_empty());
        }
        for force in &description.forces {
            forces[match force.kind {
                ForceKind::Spring(_) => 0,
                ForceKind::Bushing(_) => 1,
                ForceKind::Load(Load { axes: LoadAxes::Inertial, .. }) => 2,
                ForceKind::Load(Load { axes: LoadAxes::Body, .. }) => 3,
                ForceKind::Rope(_) | ForceKind::Curve(_) | ForceKind::Slider(_) => {
                    unreachable!("their scenes are in `ropes` and `sliders`")
                }
            }] += 1;
        }
    }
    let counts: Vec<i32> =
        kinds.values().copied().chain(forces).chain([armatures, torsion, rests].map(|n| n as i32)).collect();
    // Those along curves are in `guides`.
    assert_eq!(kinds.len(), stillpoint::hinge::DECLARED.len() - 1, "{kinds:?}");
    assert!(counts.iter().all(|count| *count > 100), "{kinds:?} {forces:?} {armatures} {torsion} {rests}");
}

/// Chains of one kind of hinge, forty bodies long: errors of a sweep would pile up here. Condition numbers are 3e1…2e4;
/// measured is 8e-15.
#[test]
fn chains_of_forty_equal_hinges_move_as_the_equations_say() {
    let kinds = [
        HingeKind::Revolute { axis: Vector3::new(0.3, 1.0, -0.2) },
        HingeKind::Screw { axis: Vector3::new(0.3, 1.0, -0.2), pitch: -0.15 },
        HingeKind::Cylindrical { axis: Vector3::new(0.3, 1.0, -0.2) },
        HingeKind::Universal { axes: [Vector3::x(), Vector3::y()] },
        HingeKind::Planar,
        HingeKind::Spherical,
    ];
    for (seed, kind) in kinds.into_iter().enumerate() {
        let description = chain_of(seed as u64, 40, kind);
        let found = compare(&description);
        let worst = found.acceleration.max(found.reaction);
        assert!(worst < 1e-12, "{}: {worst:.1e}, condition number {:.1e}", kind.name(), found.answer.condition());
    }
}

/// Random bodies one after the other, each in any position on a hinge of this kind.
fn chain_of(seed: u64, bodies: usize, kind: HingeKind) -> Description {
    let mut random = Random::new(seed);
    let mut description = random_scene(seed, &Options { bodies, springs: false, welds: false });
    for index in 0..bodies {
        let parent = if index == 0 { "ground".to_owned() } else { format!("b{}", index - 1) };
        let at = description.bodies[index].hinge.at.clone();
        let position = position_of(&mut random, &kind);
        let velocity = random.list(kind.counts().1, -2.0, 2.0);
        description.bodies[index].hinge =
            HingeDescription { parent, at, position, velocity, ..HingeDescription::new(kind) };
    }
    description
}

/// On long spherical chains a reduced matrix that is not kept symmetric loses all digits within some thirty links (that of
/// a known library does). Here what inverse dynamics leaves of the accelerations stays at the round-off of the reactions.
#[test]
fn accelerations_of_long_spherical_chains_leave_nothing_in_inverse_dynamics() {
    for (seed, bodies) in [(1, 20), (2, 50), (3, 100)] {
        let model = build(&chain_of(seed, bodies, HingeKind::Spherical));
        let mut system = System::new(&model);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let (mut a, mut residual, mut reactions) = (v.clone(), v.clone(), Vec::new());
        let mut at = system.at(0.0, q, v);
        at.accelerations(&mut a).unwrap();
        at.residual(&a, &mut residual).unwrap().reactions(&mut reactions);
        let largest = |list: &[f64]| list.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let scale = reactions.iter().map(|wrench| wrench.force.norm().max(wrench.moment.norm())).fold(0.0, f64::max);
        assert!(largest(&residual) < 1e-8 * scale, "{bodies}: {:.1e} of {scale:.1e}", largest(&residual));
    }
}

/// Masses between a gram and a ton in one tree. A light body between heavy ones moves by the difference of what they
/// pass on, known to 1e-16 of the heavy: a mass ratio of 1e6 leaves 1e-10. Measured is 3e-11. The condition number of
/// the scaled equations (1e2…2e4) does not show this: the bodies' own equations are well scaled, their elimination is
/// not.
#[test]
fn masses_between_a_gram_and_a_ton_cost_their_ratio_and_no_more() {
    for seed in 0..60_u64 {
        let mut description = random_scene(seed, &Options { bodies: 12, springs: true, welds: true });
        let mut random = Random::new(seed + 7);
        for body in &mut description.bodies {
            let factor = 10.0_f64.powf(random.between(-3.0, 3.0));
            body.mass.mass *= factor;
            body.mass.inertia *= factor;
        }
        let found = compare(&description);
        let worst = found.acceleration.max(found.reaction);
        assert!(worst < 1e-10, "seed {seed}: {worst:.1e}, condition number {:.1e}", found.answer.condition());
    }
}

/// A point mass at `(b, 0, h)` on a yaw axis on a roll axis that lies in a plane with both but for `θ`: nothing but that angle
/// resists a turn about the line to the mass. `M q̈ = τ` of two rows, solved by hand; its determinant is `b² sin² θ (h² + b²)`
/// while the inertias that the sweep takes apart are `h² + b²`.
pub(crate) fn neck(angle: f64) -> (Description, [f64; 2]) {
    let (b, h, torque) = (0.2, 0.5, [0.3, 0.07]);
    let massless = |name: &str, hinge| BodyDescription::new(name, hinge);
    let roll = HingeDescription { force: vec![torque[0]], ..HingeDescription::revolute([1.0, 0.0, 0.0]) };
    let yaw = HingeDescription {
        force: vec![torque[1]],
        position: vec![angle],
        ..HingeDescription::revolute([0.0, 0.0, 1.0])
    };
    let mut description = Description::new("neck").body(massless("roll", roll));
    description.bodies.push(BodyDescription::new("head", yaw.on("roll", [0.0; 3])).mass(1.0).center([b, 0.0, h]));
    description.gravity = Vector3::zeros();
    let (s, c) = angle.sin_cos();
    let determinant = b * b * s * s * (h * h + b * b);
    let exact = [
        (b * b * torque[0] + h * b * c * torque[1]) / determinant,
        (h * b * c * torque[0] + (h * h + b * b * s * s) * torque[1]) / determinant,
    ];
    (description, exact)
}

/// Where the factorization has lost all but few digits the accelerations have them still: their residual is taken without
/// the difference that lost them. What is left is the turn of the axes, known to 2e-16, beside the angle.
#[test]
fn motions_that_hardly_anything_resists_keep_their_digits() {
    for angle in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let (description, exact) = neck(angle);
        let model = build(&description);
        let mut a = [0.0; 2];
        System::new(&model).at(0.0, &model.start_position, &[0.0; 2]).accelerations(&mut a).unwrap();
        let error = relative_difference(&a, &exact);
        assert!(error < 2e-15 + 1e-15 / angle, "{angle}: {error:.1e}");
    }
}

/// The oracle's own footing: its velocities are the rates of its positions. Central differences err by step² = 1e-10
/// and round-off/step = 1e-11, both times numbers of order ten.
#[test]
fn velocities_of_the_oracle_are_the_rates_of_its_positions() {
    for seed in 0..40_u64 {
        let description = random_scene(seed, &Options { bodies: 8, springs: false, welds: true });
        let step = 1e-5;
        let [before, after] = [-step, step].map(|time| moved(&description, time));
        for index in 0..description.bodies.len() {
            let place = |description: &Description| oracle::place::place(description, Some(index));
            let (was, now, will) = (place(&before), place(&description), place(&after));
            let velocity = (will.position - was.position) / (2.0 * step);
            let turning = (will.turn - was.turn) / (2.0 * step);
            assert!((velocity - now.velocity).norm() < 1e-7, "seed {seed} body {index}");
            assert!((turning - now.spin.cross_matrix() * now.turn).norm() < 1e-7, "seed {seed} body {index}");
        }
    }
}

/// The same scene a little later, every hinge moving at its own constant rate.
fn moved(description: &Description, time: f64) -> Description {
    let mut moved = description.clone();
    for body in &mut moved.bodies {
        let (positions, velocities) = body.hinge.kind.counts();
        let plain = if positions == velocities { positions } else { velocities - 3 };
        for i in 0..plain {
            body.hinge.position[i] += time * body.hinge.velocity[i];
        }
        if positions != velocities {
            let spin = Vector3::from_column_slice(&body.hinge.velocity[plain..]);
            let turn = quaternion(&body.hinge.position[plain..]) * UnitQuaternion::from_scaled_axis(time * spin);
            body.hinge.position.splice(plain.., [turn.w, turn.i, turn.j, turn.k]);
        }
    }
    moved
}
