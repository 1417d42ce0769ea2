//! What was found, with the evidence.

use super::view::{Tied, View};
use crate::dynamics::{Fault, Linearization};
use crate::statics::cascade::Stage;
use crate::statics::equilibrium::Equilibrium;
use crate::statics::search::Iteration;
use crate::statics::stability::{
    Mode, Stability, Verdict, count_by_motion, count_by_stiffness, generalized, momentum, rates_of, scaled, shares,
    symmetric, verdict,
};
use crate::statics::{Method, Settings, Want};
use faer::Mat;

pub(super) fn certify(
    mut tied: Tied<'_>,
    settings: &Settings,
    view: View,
    stage: &'static str,
    history: Vec<Iteration>,
    mut notes: Vec<String>,
) -> Result<Equilibrium, Fault> {
    let model = tied.model();
    let n = model.velocity_count();
    let rows = view.multipliers.len() - tied.locked.len();
    let q = view.place.q.clone();
    if !tied.frozen.is_empty() {
        notes.push(format!(
            "the rest cannot stay at rest beside {}: they are held where they are at t = 0",
            tied.frozen.join(", ")
        ));
    }
    if view.singular {
        notes.push(
            "a singular position of the loops: their reactions are not determined here; the motions that exist only \
             in this position are left out"
                .to_owned(),
        );
    }
    let balanced = view.place.is_balanced();
    if !balanced {
        notes.push(unbalanced(&tied, &view));
    }
    // Stability first: it evaluates elsewhere.
    tied.system.set_multipliers(&view.multipliers[..rows]);
    let none = vec![0.0; n];
    let full = tied.system.linearize(&q, &tied.steady, &none)?;
    let z = &view.tangent;
    let reduced = |m: &Mat<f64>| z.transpose() * m * z;
    let linear = Linearization {
        stiffness: reduced(&full.stiffness),
        damping: reduced(&full.damping),
        mass: reduced(&full.mass),
    };
    let residual_acceleration = acceleration(&linear, z, &view.gradient);
    let spins = tied.steady.iter().any(|v| *v != 0.0);
    let stability = balanced.then(|| classify(&tied, &view, &full, &linear, model.is_conservative() && !spins));
    let verdict = stability.as_ref().map(|s| s.verdict);
    if verdict == Some(Verdict::Unstable) && settings.want == Want::Stable {
        notes.push("only an unstable equilibrium was found; `want = \"any\"` would accept it".to_owned());
    }
    let stages = vec![Stage {
        name: stage,
        iterations: history.len(),
        force_evaluations: tied.residuals,
        factorizations: tied.stiffnesses,
        relative_residual: view.place.residual().0,
        balanced,
    }];
    let mut residual = vec![0.0; n];
    tied.system.residual(&q, &tied.steady, &none, &mut residual)?;
    let (mut poses, mut reactions) = (Vec::new(), Vec::new());
    tied.system.poses(&mut poses);
    tied.system.reactions(&mut reactions);
    let drive_forces = tied.system.constraints().map_or(Vec::new(), |rows| rows.drive_forces().collect());
    let holding = tied.locked.iter().map(|i| (model.label(*i), residual[*i])).collect();
    Ok(Equilibrium {
        converged: balanced && (settings.want == Want::Any || verdict != Some(Verdict::Unstable)),
        balanced,
        method: if settings.method == Method::Auto { "newton" } else { settings.method.name() },
        stage,
        stages,
        iterations: history.len(),
        force_evaluations: tied.residuals,
        acceleration_evaluations: 0,
        stiffness_evaluations: tied.stiffnesses,
        factorizations: tied.stiffnesses,
        residual_acceleration,
        residual_force: view.place.force.iter().fold(0.0, |m, f| m.max(f.abs())),
        relative_residual: view.place.residual().0,
        drive_forces,
        velocity: tied.steady.clone(),
        position: q,
        poses,
        reactions,
        stability,
        holding,
        unknowns: Vec::new(),
        notes,
        multiplier_reactions: Vec::new(),
        history,
    })
}

/// The largest hinge acceleration that the unbalanced forces make along the loops.
fn acceleration(linear: &Linearization, z: &Mat<f64>, gradient: &[f64]) -> f64 {
    use faer::linalg::solvers::Solve;
    if gradient.is_empty() {
        return 0.0;
    }
    let rhs = Mat::from_fn(gradient.len(), 1, |i, _| -gradient[i]);
    let a = z * linear.mass.partial_piv_lu().solve(&rhs);
    (0..a.nrows()).map(|i| a[(i, 0)].abs()).fold(0.0, f64::max)
}

fn unbalanced(tied: &Tied<'_>, view: &View) -> String {
    let (relative, worst) = view.place.residual();
    let Some(worst) = worst else { return "no residual".to_owned() };
    format!(
        "nothing balances {} in {} ({relative:.1e} of the forces there): a spring, a load or a lock is missing, or the \
         guess is too far away",
        crate::model::problem::number(view.place.force[worst]),
        tied.model().label(worst)
    )
}

/// Verdict and modes of the motions along the loops.
fn classify(
    tied: &Tied<'_>,
    view: &View,
    full: &Linearization,
    linear: &Linearization,
    conservative: bool,
) -> Stability {
    let model = tied.model();
    let (n, count) = (model.velocity_count(), linear.mass.nrows());
    if count == 0 {
        let (modes, damped) = (Vec::new(), Vec::new());
        return Stability { verdict: Verdict::Stable, unstable_directions: 0, neutral_directions: 0, modes, damped };
    }
    let z = &view.tangent;
    let size = |j: usize| (0..n).map(|i| z[(i, j)].powi(2) * view.place.scales.stiffness[i]).sum::<f64>();
    let magnitude: Vec<f64> = (0..count).map(size).collect();
    let (unstable, neutral) = match conservative {
        true => count_by_stiffness(&symmetric(&linear.stiffness), &magnitude),
        false => count_by_motion(linear),
    };
    let free: Vec<usize> = (0..n).filter(|i| !tied.locked.contains(i)).collect();
    let mode = |(k, (value, y)): (usize, (f64, Vec<f64>))| {
        let shape: Vec<f64> = (0..n).map(|i| (0..count).map(|j| z[(i, j)] * y[j]).sum()).collect();
        let momentum = momentum(&full.mass, &shape);
        let pick = |list: &[f64]| free.iter().map(|i| list[*i]).collect::<Vec<f64>>();
        let (frequency_hz, growth_rate) = rates_of(value, k, unstable, neutral);
        let shares = shares(model, &free, &pick(&momentum), &pick(&shape));
        Mode { frequency_hz, growth_rate, shares, shape: scaled(&pick(&shape)) }
    };
    let found = generalized(&symmetric(&linear.stiffness), &symmetric(&linear.mass));
    let modes = found.map_or(Vec::new(), |(values, vectors)| {
        let shapes = (0..count).map(|k| (0..count).map(|i| vectors[(i, k)]).collect::<Vec<f64>>());
        values.into_iter().zip(shapes).enumerate().map(mode).collect()
    });
    // The damped motion of scenes with loops is not looked at yet.
    let (verdict, damped) = (verdict(unstable, neutral), Vec::new());
    Stability { verdict, unstable_directions: unstable, neutral_directions: neutral, modes, damped }
}
