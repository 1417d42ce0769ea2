//! Damped modes: roots of `M s² + C s + K`, against closed forms and by their own equation.

use crate::common::{Options, build, random_scene};
use faer::Mat;
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

fn rest(text: &str) -> (Arc<Model>, Equilibrium) {
    let scenario = scenario::parse("modes.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = build(&scenario.description);
    let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("numbers");
    assert!(found.converged, "{:?}", found.notes);
    (model, found)
}

/// A mass of 2 kg on a slide with a spring of 50 N/m: ω = 5/s, critical damping 20 N s/m.
#[test]
fn a_damped_slide_swings_creeps_or_sits_between() {
    for damping in [0.0, 1.0, 12.0, 20.0, 50.0] {
        let (_, found) = rest(&format!(
            "[[body]]\nname = \"mass\"\nmass = 2\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], stiffness = 50, \
             damping = {damping} }}\n"
        ));
        let damped = found.stability.expect("a verdict").damped;
        let half = damping / 4.0;
        let roots: Vec<(f64, f64)> = match half {
            0.0 => Vec::new(),
            half if half < 5.0 => vec![(half, (25.0_f64 - half * half).sqrt())],
            half => [-1.0, 1.0].map(|sign| (half + sign * (half * half - 25.0_f64).sqrt(), 0.0)).to_vec(),
        };
        assert_eq!(damped.len(), roots.len(), "{damping}");
        for (mode, (decay, rate)) in damped.iter().zip(roots) {
            // At critical damping both roots are one: they are known to the square root of the machine precision.
            let tolerance = if damping == 20.0 { 1e-6 } else { 1e-12 };
            assert!((mode.decay_rate - decay).abs() < tolerance, "{damping}: {} {decay}", mode.decay_rate);
            assert!((mode.frequency_hz * std::f64::consts::TAU - rate).abs() < tolerance, "{damping}");
            assert!((mode.damping_ratio - decay / decay.hypot(rate)).abs() < 1e-9);
            assert_eq!(mode.shares[0].0, "mass");
        }
    }
}

/// Every mode of random damped scenes solves `(M s² + C s + K) X = 0`.
#[test]
fn damped_modes_solve_their_equation() {
    let mut checked = 0;
    for seed in 0..40 {
        let mut description = random_scene(seed, &Options { bodies: 5, springs: true, welds: false });
        // Every hinge held by a spring of its own: scenes that rest.
        for body in &mut description.bodies {
            body.hinge.stiffness = vec![40.0; body.hinge.kind.counts().1];
        }
        let model = build(&description);
        let found =
            equilibrium(&model, &stillpoint::statics::Settings::default(), &model.start_position).expect("numbers");
        let Some(stability) = found.stability.filter(|_| found.converged) else { continue };
        let n = model.velocity_count();
        assert!(stability.damped.len() >= n && stability.damped.len() <= 2 * n, "one or two for every coordinate");
        let zero = vec![0.0; n];
        let linear = System::new(&model).at(0.0, &found.position, &zero).linearize(&zero).expect("numbers");
        let size = |m: &Mat<f64>| m.norm_max();
        for mode in &stability.damped {
            let (re, im) = (-mode.decay_rate, mode.frequency_hz * std::f64::consts::TAU);
            let [a, b] = &mode.shape;
            let times = |m: &Mat<f64>, x: &[f64], i: usize| (0..n).map(|j| m[(i, j)] * x[j]).sum::<f64>();
            let (square_re, square_im) = (re * re - im * im, 2.0 * re * im);
            let scale = size(&linear.mass) * (re * re + im * im)
                + size(&linear.damping) * re.hypot(im)
                + size(&linear.stiffness);
            for i in 0..n {
                let [m_a, m_b] = [a, b].map(|x| times(&linear.mass, x, i));
                let [c_a, c_b] = [a, b].map(|x| times(&linear.damping, x, i));
                let [k_a, k_b] = [a, b].map(|x| times(&linear.stiffness, x, i));
                let real = square_re * m_a - square_im * m_b + re * c_a - im * c_b + k_a;
                let imaginary = square_re * m_b + square_im * m_a + re * c_b + im * c_a + k_b;
                // Eigenvectors of matrices whose condition is some 1e4.
                assert!(real.hypot(imaginary) < 1e-9 * scale, "seed {seed}: {:e}", real.hypot(imaginary) / scale);
            }
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked}");
}

/// Damping in proportion to stiffness, `C = β K`: every mode decays with `β ω² / 2`, also where only the lowest modes of
/// a large system are known.
#[test]
fn proportional_damping_of_a_long_chain() {
    let beta = 0.01;
    let (model, found) = rest(&format!(
        "gravity = [0, 0, 0]\n[[body]]\nname = \"link\"\nrepeat = 230\nmass = 1\ncenter = [0.5, 0, 0]\ninertia = \
         [0.1, 0.1, 0.1]\nnext = [1, 0, 0]\nhinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = 1e7, damping = \
         {:?} }}\n",
        1e7 * beta
    ));
    let stability = found.stability.expect("a verdict");
    assert!(stability.modes.len() < model.velocity_count(), "by sweeps");
    for mode in &stability.modes {
        let omega = mode.frequency_hz * std::f64::consts::TAU;
        let decay = 0.5 * beta * omega * omega;
        let rate = (omega * omega - decay * decay).sqrt();
        let found = stability
            .damped
            .iter()
            .map(|one| (one.frequency_hz * std::f64::consts::TAU - rate).hypot(one.decay_rate - decay));
        let nearest = found.fold(f64::INFINITY, f64::min);
        // The eigenvalues stand still to 1e-10, their vectors to the root of that.
        assert!(nearest < 1e-6 * omega, "{omega}: {nearest:e}");
    }
}

/// A long chain of balls swings like the same chain of universal hinges, whatever its links do about themselves: all that cost
/// nothing are counted, a few are shown, and none hides the frequencies. Each comes twice, in two planes.
#[test]
fn a_long_chain_of_balls_swings_like_one_of_universal_hinges() {
    for links in [100, 1000] {
        let chain = |hinge: &str| {
            rest(&format!(
                "[[body]]\nname = \"link\"\nrepeat = {links}\nmass = 1\ncenter = [0, 0, -0.25]\ninertia = [0.02, 0.02, 0.001]\n\
                 markers = {{ tip = [0, 0, -0.5] }}\nhinge = {{ {hinge}, next = \"tip\" }}\n"
            ))
            .1
            .stability
            .expect("a verdict")
        };
        let balls = chain("type = \"spherical\"");
        let universal = chain("type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]]");
        assert_eq!((balls.neutral_directions, universal.neutral_directions), (links, 0));
        let swings = |stability: &stillpoint::statics::Stability| -> Vec<f64> {
            stability.modes.iter().map(|mode| mode.frequency_hz).filter(|hertz| *hertz > 0.0).collect()
        };
        let (balls, universal) = (swings(&balls), swings(&universal));
        assert_eq!((balls.len(), universal.len()), (8, 8), "{links} links");
        for (i, (a, b)) in balls.iter().zip(&universal).enumerate() {
            assert!((a - b).abs() < 1e-9 * b && (b - universal[i - i % 2]).abs() < 1e-9 * b, "{links} links: {a} {b}");
        }
    }
}

/// A chain that floats costs nothing to move as a whole, however long it is, and nothing else is free. Its frequencies are
/// those of a free beam, `22.373 √(EI/m) / L²`, where links are many.
#[test]
fn a_long_chain_that_floats_has_six_motions_that_cost_nothing() {
    for links in [40, 100, 1000] {
        for hinge in ["type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]]", "type = \"revolute\", axis = [0, 1, 0]"] {
            let h = 10.0 / (links as f64 + 1.0);
            let body = format!(
                "mass = {h}\ncenter = [0, 0, {}]\ninertia = [{1}, {1}, {1}]\nmarkers = {{ tip = [0, 0, {h}] }}\n",
                h / 2.0,
                h * h * h / 12.0
            );
            let (_, found) = rest(&format!(
                "gravity = [0, 0, 0]\n[[body]]\nname = \"base\"\n{body}hinge = {{ type = \"free\" }}\n[[body]]\nname = \
                 \"link\"\nrepeat = {links}\n{body}hinge = {{ {hinge}, parent = \"base\", at = \"tip\", next = \"tip\", \
                 stiffness = {} }}\n",
                100.0 / h
            ));
            let stability = found.stability.expect("a verdict");
            assert_eq!((stability.unstable_directions, stability.neutral_directions), (0, 6), "{links} links");
            let lowest = stability.modes.iter().map(|mode| mode.frequency_hz).find(|hertz| *hertz > 0.0);
            let beam = 22.373_285 * 10.0 / (100.0 * std::f64::consts::TAU);
            let lowest = lowest.expect("a frequency");
            assert!((lowest / beam - 1.0).abs() < 1.0 / links as f64, "{links} links: {lowest} Hz instead of {beam}");
        }
    }
}

/// Large random trees without damping, every hinge on springs of its own, some springs between distant bodies; every third of
/// them floats. Sweeps find, count and measure what matrices of the whole scene do.
#[test]
fn large_random_trees_swing_as_matrices_say() {
    for seed in 0..24 {
        let mut scene = random_scene(seed, &Options { bodies: 70, springs: true, welds: true });
        let floats = seed % 3 == 0;
        for (index, body) in scene.bodies.iter_mut().enumerate() {
            let hinge = &mut body.hinge;
            hinge.damping.clear();
            hinge.force.clear();
            hinge.rest.clear();
            hinge.stiffness = vec![if seed % 2 == 0 { 400.0 } else { 40.0 }; hinge.kind.counts().1];
            if floats && (index == 0 || hinge.parent == stillpoint::model::description::GROUND) {
                hinge.kind = stillpoint::model::description::HingeKind::Free;
                (hinge.stiffness, hinge.position) = (vec![0.0; 6], Vec::new());
                (hinge.velocity, hinge.force, hinge.armature) = (Vec::new(), Vec::new(), Vec::new());
            }
        }
        let roots =
            scene.bodies.iter().filter(|body| body.hinge.parent == stillpoint::model::description::GROUND).count();
        if floats {
            scene.gravity = nalgebra::Vector3::zeros();
        }
        scene.forces.retain_mut(|force| match &mut force.kind {
            stillpoint::model::description::ForceKind::Spring(stillpoint::model::description::Spring {
                damping,
                between,
                ..
            }) => {
                *damping = 0.0;
                !floats || between.iter().all(|end| end.body != stillpoint::model::description::GROUND)
            }
            _ => false,
        });
        scene.forces.truncate(2);
        if floats {
            scene.forces.clear();
        }
        let model = build(&scene);
        let found =
            equilibrium(&model, &stillpoint::statics::Settings::default(), &model.start_position).expect("numbers");
        assert!(found.converged, "{seed}: {:?}", found.notes);
        let stability = found.stability.expect("a verdict");
        let n = model.velocity_count();
        assert!(n > 100 && stability.modes.len() < n, "{seed}: by sweeps");
        let zero = vec![0.0; n];
        let linear = System::new(&model).at(0.0, &found.position, &zero).linearize(&zero).expect("numbers");
        let root = linear.mass.llt(faer::Side::Lower).expect("inertia");
        let mut inverse = Mat::<f64>::identity(n, n);
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(root.L(), inverse.as_mut(), faer::Par::Seq);
        let symmetric = 0.5 * (&linear.stiffness + linear.stiffness.transpose());
        let values =
            (&inverse * &symmetric * inverse.transpose()).self_adjoint_eigenvalues(faer::Side::Lower).expect("");
        let round_off = 1e-13 * values[n - 1];
        let count = |test: &dyn Fn(f64) -> bool| values.iter().filter(|x| test(**x)).count();
        let expected = (count(&|x| x < -round_off), count(&|x| x.abs() <= round_off));
        assert_eq!((stability.unstable_directions, stability.neutral_directions), expected, "{seed}");
        assert_eq!(expected, (0, if floats { 6 * roots } else { 0 }), "{seed}");
        let swinging: Vec<f64> =
            stability.modes.iter().map(|mode| mode.frequency_hz).filter(|hertz| *hertz > 0.0).collect();
        assert_eq!(swinging.len(), 8, "{seed}");
        for (hertz, value) in swinging.iter().zip(&values[expected.1..]) {
            let expected = value.sqrt() / std::f64::consts::TAU;
            assert!((hertz - expected).abs() < 1e-8 * expected, "{seed}: {hertz} {expected}");
        }
    }
}

/// A body on a ball with a spring, as stiff about all axes, under a torque that keeps its direction: it feeds any two motions of one
/// frequency, which flutter as long as nothing damps them.
fn twisted(torque: f64, damping: f64) -> Equilibrium {
    let text = format!(
        "gravity = [0, 0, 0]\nstatics = {{ want = \"any\" }}\n[[body]]\nname = \"top\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = {{ type = \"spherical\", stiffness = 10.0, damping = {damping:?} }}\n\
         [[force]]\nname = \"twist\"\ntype = \"load\"\non = \"top\"\ntorque = [0.0, 0.0, {torque:?}]\n"
    );
    rest(&text).1
}

#[test]
fn what_damping_stills_does_not_grow_and_what_nothing_damps_is_said_to_flutter() {
    for torque in [0.01, 0.1, 0.5] {
        let grows = |found: &Equilibrium| {
            let stability = found.stability.as_ref().expect("a verdict");
            (stability.verdict, stability.modes.iter().any(|mode| mode.growth_rate > 0.0))
        };
        let says_so = |found: &Equilibrium| found.notes.iter().any(|note| note.contains("flutter"));
        let (still, fed) = (twisted(torque, 1.0), twisted(torque, 0.0));
        assert_eq!((grows(&still), says_so(&still)), ((StabilityVerdict::Stable, false), false), "{torque}");
        assert_eq!((grows(&fed), says_so(&fed)), ((StabilityVerdict::Unstable, true), true), "{torque}");
    }
}
