//! Statics of large scenes with few loops, by sweeps that the rows border: against matrices of the size of the scene.

use crate::common::build;
use faer::{Mat, Side};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, Want, equilibrium};

const G: f64 = 9.80665;

fn read(text: &str) -> Arc<Model> {
    build(&scenario::parse("scene.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}")).description)
}

fn found(model: &Arc<Model>, want: Want) -> Equilibrium {
    let settings = Settings { want, ..Settings::default() };
    let found = equilibrium(model, &settings, &model.start_position).expect("numbers that are finite");
    assert!(found.converged, "{:?}", found.notes);
    found
}

/// A chain of links of 0.1 m and 50 g in the plane; `first` and `turn` are the angles of the guess.
fn links(name: &str, count: usize, [first, turn]: [f64; 2], hinge: &str) -> String {
    let turns: Vec<String> = (0..count).map(|i| if i == 0 { first } else { turn }.to_string()).collect();
    format!(
        "[[body]]\nname = \"{name}\"\nrepeat = {count}\nmass = 0.05\ncenter = [0.05, 0, 0]\ninertia = [1e-6, 4.2e-5, 4.2e-5]\n\
         markers = {{ end = [0.1, 0, 0] }}\nnext = \"end\"\n\
         hinge = {{ type = \"revolute\", axis = [0, 1, 0], {hinge} position = [{}] }}\n",
        turns.join(", ")
    )
}

/// Chain between two walls that are as far apart as this part of its length.
fn suspended(count: usize, part: f64, hinge: &str) -> String {
    let turn = -2.22 / (count as f64 - 1.0);
    format!(
        "{}[[loop]]\ntype = \"revolute\"\nbetween = [\"link[{}].end\", {{ body = \"ground\", at = [{}, 0, 0] }}]\naxis = [0, 1, 0]\n",
        links("link", count, [1.11, turn], hinge),
        count - 1,
        0.1 * part * count as f64
    )
}

/// What matrices say of an equilibrium: directions that run away, frequencies (Hz), and the largest change of a coordinate
/// in the Newton step from there.
fn by_matrices(model: &Arc<Model>, found: &Equilibrium) -> (usize, Vec<f64>, f64) {
    let n = model.velocity_count();
    let mut system = System::new(model);
    system.set_multipliers(&found.multipliers);
    let rest = vec![0.0; n];
    let mut at = system.at(0.0, &found.position, &rest);
    let linear = at.linearize(&rest).expect("finite");
    let mut left = rest.clone();
    at.residual(&rest, &mut left).expect("finite");
    let free: Vec<usize> = (0..n).filter(|i| !model.coordinates[*i].lock).collect();
    let rows = at.constraint_matrix();
    let pick = |m: &Mat<f64>| Mat::from_fn(free.len(), free.len(), |i, j| m[(free[i], free[j])]);
    let svd = Mat::from_fn(rows.nrows(), free.len(), |i, j| rows[(i, free[j])]);
    let svd = svd.svd().expect("singular values");
    let count = free.len() - rows.nrows();
    let z = svd.V().subcols(rows.nrows(), count).to_owned();
    let [k, m] = [linear.stiffness, linear.mass].map(|m| z.transpose() * pick(&m) * &z);
    let root = m.llt(Side::Lower).expect("inertia");
    let lower = root.L();
    let mut inverse = Mat::<f64>::identity(count, count);
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(lower, inverse.as_mut(), faer::Par::Seq);
    let eigen = (&inverse * &k * inverse.transpose()).self_adjoint_eigen(Side::Lower).expect("eigenvalues");
    let values: Vec<f64> = (0..count).map(|i| eigen.S()[i]).collect();
    let unstable = values.iter().filter(|x| **x < -1e-9 * values[count - 1].abs()).count();
    let frequencies = values[unstable..].iter().map(|x| x.sqrt() / std::f64::consts::TAU).collect();
    use faer::linalg::solvers::Solve;
    let along = Mat::from_fn(count, 1, |j, _| free.iter().enumerate().map(|(i, at)| z[(i, j)] * left[*at]).sum());
    let step = &z * k.partial_piv_lu().solve(&along);
    let largest = (0..free.len()).map(|i| step[(i, 0)].abs()).fold(0.0, f64::max);
    (unstable, frequencies, largest)
}

fn assert_as_by_matrices(name: &str, model: &Arc<Model>, found: &Equilibrium) {
    let (unstable, frequencies, step) = by_matrices(model, found);
    let stability = found.stability.as_ref().expect("an equilibrium");
    assert!(step < 1e-9, "{name}: a Newton step of {step:e} is left");
    assert_eq!((stability.unstable_directions, stability.neutral_directions), (unstable, 0), "{name}");
    // Of a large scene without damping not all modes are computed: that is how one sees that sweeps were the way.
    let all = frequencies.len() + unstable;
    assert!((stability.modes.len() < all) != model.has_damping(), "{name}: {}", stability.modes.len());
    let swinging = stability.modes.iter().filter(|mode| mode.frequency_hz > 0.0);
    for (mode, expected) in swinging.zip(&frequencies) {
        // Matrices of this size know their lowest eigenvalues to 1e-16 of the largest, some 1e4 times as large.
        assert!((mode.frequency_hz - expected).abs() < 1e-9 * expected, "{name}: {} {expected}", mode.frequency_hz);
    }
}

#[test]
fn a_chain_between_walls_is_what_matrices_say() {
    let model = read(&suspended(80, 0.8, ""));
    assert_as_by_matrices("chain", &model, &found(&model, Want::Stable));
    let model = read(&suspended(80, 0.8, "stiffness = 0.02, damping = 0.01, "));
    assert_as_by_matrices("stiff chain", &model, &found(&model, Want::Stable));
    // A locked hinge takes a coordinate out.
    let mut scene = scenario::parse("scene.toml", &suspended(81, 0.8, ""), &[]).expect("a scene").description;
    scene.bodies[30].hinge.lock = true;
    let model = build(&scene);
    assert_as_by_matrices("locked chain", &model, &found(&model, Want::Stable));
}

/// Hooke: as hangs the flexible line, so but inverted stands the arch. Every motion leaves the arch, and whoever wants a
/// stable equilibrium gets the chain.
#[test]
fn an_arch_is_the_chain_upside_down() {
    let mut model = read(&suspended(80, 0.8, ""));
    let hanging = found(&model, Want::Stable);
    Arc::make_mut(&mut model).start_position = hanging.position.iter().map(|angle| -angle).collect();
    let arch = found(&model, Want::Any);
    let stability = arch.stability.as_ref().expect("an equilibrium");
    assert_eq!(stability.unstable_directions, 78);
    assert_eq!(by_matrices(&model, &arch).0, 78);
    // The same thrust: multipliers are the forces of the right wall.
    let pull = |found: &Equilibrium| found.loops[0].force;
    let (down, up) = (pull(&hanging), pull(&arch));
    assert!((down.x + up.x).abs() < 1e-9 * down.norm() && (down.z - up.z).abs() < 1e-9 * down.norm(), "{down} {up}");
    let fallen = found(&model, Want::Stable);
    assert!(fallen.notes.iter().any(|note| note.contains("left an unstable equilibrium")), "{:?}", fallen.notes);
    assert_as_by_matrices("fallen arch", &model, &fallen);
    // It hangs somewhere below where it stood.
    let height = |found: &Equilibrium| found.poses.iter().map(|pose| pose.translation.vector.z).sum::<f64>();
    assert!(height(&fallen) < height(&arch));
}

/// Two chains of universal hinges whose ends are one ball, far from each other in the tree, and springs that reach far:
/// what one end feels when the other moves counts among the negative directions too.
#[test]
fn loops_and_springs_between_distant_links_are_what_matrices_say() {
    let half = |name: &str, at: f64, lean: f64| {
        let turns: Vec<String> =
            (0..40).map(|i| if i == 0 { format!("[0.1, {lean}]") } else { "[0, 0]".to_owned() }).collect();
        format!(
            "[[body]]\nname = \"{name}\"\nrepeat = 40\nmass = 0.05\ncenter = [0, 0, -0.05]\ninertia = [4.2e-5, 4.2e-5, 1e-6]\n\
             markers = {{ end = [0, 0, -0.1] }}\nnext = \"end\"\n\
             hinge = {{ type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]], at = [{at}, 0, 0], position = [{}] }}\n",
            turns.join(", ")
        )
    };
    let spring = "[[force]]\nname = \"tie\"\ntype = \"spring\"\nstiffness = 20\nlength = 1.0\n\
                  between = [\"left[19].end\", \"right[19].end\"]\n";
    let tie = "[[loop]]\ntype = \"spherical\"\nbetween = [\"left[39].end\", \"right[39].end\"]\n";
    let scene = format!("{}{}{tie}{spring}", half("left", 0.0, -0.4), half("right", 3.0, 0.4));
    let model = read(&scene);
    let resting = found(&model, Want::Stable);
    assert_as_by_matrices("two chains", &model, &resting);
    // Symmetric: both sides share the weight.
    let load = resting.loops[0].force;
    assert!(load.z.abs() < 1e-8 && load.x.abs() > 0.1 * G, "{load}");
    // The two chains alone, with weight the other way, stand in the same pose, and most directions run away.
    let mut standing = read(&scene.replace(spring, ""));
    let hanging = found(&standing, Want::Stable);
    assert_as_by_matrices("two chains without a spring", &standing, &hanging);
    Arc::make_mut(&mut standing).start_position = hanging.position.clone();
    Arc::make_mut(&mut standing).gravity = -standing.gravity;
    let up = found(&standing, Want::Any);
    let (unstable, _, _) = by_matrices(&standing, &up);
    let stability = up.stability.as_ref().expect("an equilibrium");
    assert!(unstable > 100, "{unstable}");
    assert_eq!((stability.unstable_directions, stability.verdict), (unstable, StabilityVerdict::Unstable));
}

/// Springs between distant links of a tree, without a loop: four chains of balls tied to each other halfway and to the wall.
/// They hang, they stand upside down with most directions running away, and from there they come to hang again.
#[test]
fn springs_that_reach_far_are_what_matrices_say() {
    let chain = |i: usize| {
        format!(
            "[[body]]\nname = \"c{i}\"\nrepeat = 25\nmass = 0.05\ncenter = [0, 0, -0.05]\ninertia = [4.2e-5, 4.2e-5, 1e-6]\n\
             markers = {{ end = [0, 0, -0.1] }}\nnext = \"end\"\n\
             hinge = {{ type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]], at = [{i}, 0, 0], stiffness = 0.01 }}\n"
        )
    };
    let spring = |from: &str, to: &str, length: f64| {
        format!("[[force]]\ntype = \"spring\"\nstiffness = 3\nlength = {length}\nbetween = [{from}, {to}]\n")
    };
    let scene = [
        (0..4).map(chain).collect::<String>(),
        spring("\"c0[12].end\"", "\"c1[12].end\"", 0.7),
        spring("\"c1[20].end\"", "\"c3[20].end\"", 1.8),
        spring("\"c2[24].end\"", "{ body = \"ground\", at = [2, 1, -2] }", 0.5),
        spring("\"c0[3].end\"", "\"c0[24].end\"", 1.5),
    ];
    let model = read(&scene.concat());
    assert_eq!(model.velocity_count(), 200);
    let hanging = found(&model, Want::Stable);
    assert_as_by_matrices("tied chains", &model, &hanging);
    let mut standing = read(&scene.concat());
    Arc::make_mut(&mut standing).gravity = -standing.gravity;
    let up = found(&standing, Want::Any);
    let unstable = up.stability.as_ref().expect("an equilibrium").unstable_directions;
    assert!(unstable > 10, "{unstable}");
    assert_eq!(by_matrices(&standing, &up).0, unstable);
    Arc::make_mut(&mut standing).start_position = up.position;
    let fallen = found(&standing, Want::Stable);
    assert!(fallen.notes.iter().any(|note| note.contains("left an unstable equilibrium")), "{:?}", fallen.notes);
    assert_as_by_matrices("fallen chains", &standing, &fallen);
}
