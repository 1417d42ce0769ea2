//! What a time step calls over and over asks for no memory: all of it belongs to the `System`.

use crate::accelerations::neck;
use crate::common::{Options, build, random_scene, relative_difference};
use crate::scenarios::shipped;
use std::collections::{BTreeSet, HashSet};
use std::mem::discriminant;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::dynamics::{AccelerationJacobians, Boundary, System, TangentSolver};
use stillpoint::integrate::{Method, Options as Settings, Start};
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::simulate::problem::Equations;

/// Counted on this thread, from the first call after construction on, over a scene with all kinds of hinges and
/// all five kinds of forces (loads of both kinds of axes), each law taken as the state is and kept in one of its parts.
#[test]
fn evaluating_a_system_allocates_nothing() {
    let mut description = random_scene(17, &Options { bodies: 40, springs: true, welds: true });
    add_ropes_and_curves(&mut description);
    guide_and_burn(&mut description);
    let kinds: BTreeSet<&str> = description.bodies.iter().map(|body| body.hinge.kind.name()).collect();
    assert_eq!(kinds.len(), stillpoint::hinge::DECLARED.len(), "{kinds:?}");
    let model = build(&description);
    let laws: HashSet<_> = model.forces.iter().map(|force| discriminant(&force.law)).collect();
    assert_eq!(laws.len(), 5);
    let (q, v) = (&model.start_position, &model.start_velocity);
    let (mut a, mut residual, mut x, mut inertia) = (v.clone(), v.clone(), v.clone(), v.clone());
    let mut system = System::new(&model);
    for kept in [false, true] {
        if kept {
            system.at(0.0, q, v).keep_laws();
        }
        let mut count = |name: &str, call: &mut dyn FnMut(&mut System)| {
            let counted = allocation_counter::measure(|| call(&mut system));
            assert_eq!(counted.count_total, 0, "{name}, kept {kept}: {counted:?}");
        };
        count("accelerations", &mut |system| {
            let mut at = system.at(0.0, q, v);
            let mut mass = at.accelerations(&mut a).unwrap();
            mass.solve_mass(v, &mut x);
            mass.articulated_inertia(&mut inertia);
        });
        count("residual", &mut |system| {
            system.at(0.0, q, v).residual(v, &mut residual).unwrap();
        });
        count("another time", &mut |system| {
            for time in [0.3, 0.9, 2.0, 0.0] {
                system.at(time, q, v).accelerations(&mut a).unwrap();
            }
        });
        count("energies", &mut |system| assert!(system.at(0.0, q, v).energies().kinetic > 0.0));
        count("powers", &mut |system| assert!(system.at(0.0, q, v).powers().dissipated > 0.0));
        count("switch", &mut |system| {
            assert!(
                model.forces.iter().enumerate().all(|(element, _)| {
                    system.at(0.0, q, v).switch(Boundary { element, index: 0 }).value.is_finite()
                })
            );
        });
    }
}

/// Two bodies along curves, one whose mass burns away, and a load over time.
fn guide_and_burn(description: &mut Description) {
    let formulas = GuideCurve::Formulas {
        parameter: "u".to_owned(),
        place: ["u", "sin(u)", "0.3*u^2"].map(str::to_owned),
        range: [-1.0, 1.0],
    };
    let points = [[0.0, 0.0, 0.0], [0.5, 0.1, 0.0], [1.0, 0.0, 0.2], [1.5, 0.3, 0.1]].map(Into::into).to_vec();
    for (index, curve) in [(3, formulas), (8, GuideCurve::Points { points })] {
        let body = &mut description.bodies[index];
        let parent = body.hinge.parent.clone();
        body.hinge = HingeDescription::along(curve, AlongTurn::Follows).on(&parent, [0.1, 0.0, 0.0]).position([0.4]);
    }
    let timeline = Timeline { times: vec![0.0, 1.0] };
    let body = &description.bodies[11];
    let half = MassProperties { mass: 0.5 * body.mass.mass, inertia: 0.5 * body.mass.inertia, ..body.mass };
    let (name, rows) = (body.name.clone(), vec![body.mass, half]);
    description.burns.push(BurnDescription { body: name, timeline: timeline.clone(), rows });
    for force in &mut description.forces {
        if let ForceKind::Load(load) = &mut force.kind {
            load.over_time = Some(OverTime { timeline: timeline.clone(), values: vec![1.0, 0.0] });
        }
    }
}

/// A taut and a slack rope through three bodies, and curves of both interpolations.
fn add_ropes_and_curves(description: &mut Description) {
    let at = |index: usize| Attachment::from((description.bodies[index].name.as_str(), [0.1, 0.2, -0.3]));
    let through = || vec![at(3), at(17), at(35)];
    let table = vec![[-1.0, -2.0], [0.0, 0.5], [0.7, 4.0]];
    let mut forces = vec![
        ForceDescription::rope("taut", through(), 10.0, 1e-3, 0.5),
        ForceDescription::rope("slack", through(), 10.0, 1e3, 0.5),
    ];
    for interpolation in [Interpolation::Smooth, Interpolation::Linear] {
        let (extension, rate) = (table.clone(), table.clone());
        let kind = Curve { between: [at(5), at(30)], extension, rate, interpolation, length: 0.2 }.into();
        forces.push(ForceDescription { name: format!("{interpolation:?}"), kind });
    }
    description.forces.extend(forces);
}

/// Nor where accelerations have lost digits and are refined.
#[test]
fn refining_allocates_nothing() {
    let (description, exact) = neck(1e-4);
    let model = build(&description);
    let (mut system, mut a) = (System::new(&model), [0.0; 2]);
    let counted = allocation_counter::measure(|| {
        system.at(0.0, &model.start_position, &model.start_velocity).accelerations(&mut a).unwrap();
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
    assert!(relative_difference(&a, &exact) < 1e-11, "refined");
}

/// The Jacobians neither, once their matrices are there: in a scene without force elements.
#[test]
fn jacobians_allocate_nothing() {
    let mut description = random_scene(17, &Options { bodies: 40, springs: true, welds: true });
    description.forces.clear();
    let model = build(&description);
    let (mut system, mut jacobians) = (System::new(&model), AccelerationJacobians::new(&model));
    let counted = allocation_counter::measure(|| {
        system
            .at(0.0, &model.start_position, &model.start_velocity)
            .acceleration_jacobians_into(&mut jacobians)
            .unwrap();
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
    assert!(jacobians.by_position.norm_max() > 0.0);
}

/// Steps of every method, after the first ones; dense output included.
#[test]
fn stepping_allocates_nothing() {
    // With springs, bushings, ropes and curves that reach across the tree.
    let mut description = random_scene(17, &Options { bodies: 120, springs: true, welds: true });
    description.forces.truncate(4);
    add_ropes_and_curves(&mut description);
    let model = build(&description);
    assert!(!TangentSolver::covers(&model) && !TangentSolver::is_for_dense(&model));
    count_steps(&model);
}

/// With closed loops neither: a small mechanism (a dense tangent) and a long chain held at both ends (the sweep, bordered).
#[test]
fn stepping_with_loops_allocates_nothing() {
    let (_, small) = shipped("four_bar", &[]);
    assert!(small.is_constrained() && TangentSolver::is_for_dense(&small));
    let (_, long) = shipped("suspended_chain", &[]);
    assert!(long.is_constrained() && !TangentSolver::is_for_dense(&long));
    for model in [small, long] {
        let (model, _) = assemble(model).unwrap();
        count_steps(&model);
    }
}

fn count_steps(model: &Arc<Model>) {
    for method in Method::ALL {
        let mut motion = Equations::new(model);
        let start = Start {
            time: 0.0,
            position: &model.start_position,
            velocity: &model.start_velocity,
            end: model.time_scale(),
        };
        let settings = Settings { step: method.needs_step().then_some(1e-3 * start.end), ..Settings::default() };
        let mut stepper = method.start(&mut motion, &settings, start).unwrap();
        let (mut q, mut v) = (start.position.to_vec(), start.velocity.to_vec());
        stepper.step(&mut motion).unwrap();
        let counted = allocation_counter::measure(|| {
            for _ in 0..5 {
                stepper.step(&mut motion).unwrap();
                let middle = 0.5 * (stepper.previous_time() + stepper.time());
                stepper.interpolate(&mut motion, middle, &mut q, &mut v).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{method:?}: {counted:?}");
    }
}

/// The counter counts.
#[test]
fn an_allocation_would_be_seen() {
    let counted = allocation_counter::measure(|| drop(std::hint::black_box(vec![0.0; 7])));
    assert_eq!((counted.count_total, counted.bytes_total), (1, 56));
}
