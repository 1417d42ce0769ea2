//! Beams that loops, drives and gears close: the sweeps against the dense equations of motion with rows by differences.

use super::statics::solve;
use super::sweeps::{description, state};
use crate::common::Random;
use nalgebra::{DMatrix, DVector, Isometry3, Point3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::couplings::{
    Closure, CoordinateName, DriveDescription, GearDescription, GearKind, LoopDescription, MotionDescription,
};
use stillpoint::model::description::{
    Attachment, BeamDescription, BodyDescription, Description, GROUND, HingeDescription,
};
use stillpoint::model::{Model, Scalar};

/// Two points on bodies, or on the ground.
type Ends = [(Option<usize>, Point3<f64>); 2];

/// A scene without its couplings, the same with them, and the gap of each.
struct Closed {
    free: Arc<Model>,
    model: Arc<Model>,
    rods: Vec<(Ends, f64)>,
    driven: Option<Scalar>,
    geared: Option<([Scalar; 2], f64)>,
}

fn poses(model: &Arc<Model>, q: &[f64]) -> Vec<Isometry3<f64>> {
    let (mut system, mut poses) = (System::new(model), Vec::new());
    system.at(0.0, q, &vec![0.0; model.velocity_count()]).poses(&mut poses);
    poses
}

impl Closed {
    /// One to three rods, with a drive or a gear on the hinges that beams carry in half of the scenes. `None` where the scene as
    /// drawn has no accelerations even without: a straight rod on a ball that has no inertia about itself.
    fn some(random: &mut Random) -> Option<Self> {
        let description = description(random, false);
        let free = Model::build(&description).expect("a sound scene");
        let rest = vec![0.0; free.velocity_count()];
        System::new(&free).at(0.0, &free.start_position, &rest).accelerations(&mut rest.clone()).ok()?;
        let tip = |beam: &str| {
            free.beams.iter().find(|one| one.name == beam).and_then(|one| one.elements.last()).map(|last| last.body)
        };
        let bob = free.body("bob").expect("a body");
        let (ground, origin) = (Point3::from(random.vector(1.5)), Point3::origin());
        let eye = Point3::from(random.vector(0.3));
        let mut ends = vec![
            ([("two", None), (GROUND, Some(ground))], [(tip("two"), origin), (None, ground)]),
            ([("bob", Some(eye)), ("two", None)], [(Some(bob), eye), (tip("two"), origin)]),
            ([("one", None), (GROUND, Some(-ground))], [(tip("one"), origin), (None, -ground)]),
        ];
        ends.truncate(1 + random.below(3));
        let mut closed = Self { model: free.clone(), rods: Vec::new(), driven: None, geared: None, free };
        let mut tied = description;
        for (index, (names, ends)) in ends.into_iter().enumerate() {
            let length = closed.distance(&poses(&closed.free, &closed.free.start_position), &ends);
            let attachment = |(body, at): (&str, Option<Point3<f64>>)| match at {
                Some(at) => Attachment::from((body, [at.x, at.y, at.z])),
                None => Attachment::from((body, "tip")),
            };
            tied = tied.closure(LoopDescription {
                name: format!("rod {index}"),
                closure: Closure::Rod { length },
                between: names.map(attachment),
                frame: Default::default(),
                second_frame: None,
            });
            closed.rods.push((ends, length));
        }
        let coordinate = |body: &str| CoordinateName { body: body.to_owned(), index: 0 };
        let scalar = |body: usize| {
            let (link, hinge) = (closed.free.bodies[body].link, &closed.free.bodies[body].hinge);
            Scalar { link, position: hinge.position, velocity: hinge.velocity, slides: false }
        };
        let root = closed.free.beams[0].root;
        let is_turn = closed.free.bodies[root].hinge.kind.name() == "revolute";
        match random.below(4) {
            0 => {
                let rate = random.between(-1.0, 1.0);
                let motion = MotionDescription::Rate { rate };
                tied = tied.drive(DriveDescription { name: "drive".to_owned(), coordinate: coordinate("bob"), motion });
                closed.driven = Some(scalar(bob));
            }
            1 if is_turn => {
                let ratio = random.between(0.5, 2.0);
                let between = [coordinate("bob"), coordinate("one")];
                let kind = GearKind::Ratio { ratio };
                tied = tied.gear(GearDescription { name: "gear".to_owned(), between, kind, offset: None });
                closed.geared = Some(([scalar(bob), scalar(root)], ratio));
            }
            _ => {}
        }
        let model = Model::build(&tied).expect("a sound scene");
        let (model, _) = stillpoint::constraint::assemble(model).expect("closed as drawn");
        Some(Self { model, ..closed })
    }

    fn distance(&self, poses: &[Isometry3<f64>], ends: &Ends) -> f64 {
        let [a, b] = ends.map(|(body, at)| body.map_or(at, |body| poses[body] * at));
        (b - a).norm()
    }

    /// Gaps of all couplings without what time adds to them.
    fn gaps(&self, q: &[f64]) -> DVector<f64> {
        let poses = poses(&self.free, q);
        let mut gaps: Vec<f64> = self.rods.iter().map(|(ends, length)| self.distance(&poses, ends) - length).collect();
        gaps.extend(self.driven.map(|scalar| q[scalar.position]));
        gaps.extend(self.geared.map(|([one, other], ratio)| q[one.position] - ratio * q[other.position]));
        DVector::from_vec(gaps)
    }

    /// Moved by a multiple of rates.
    fn moved(&self, q: &[f64], v: &[f64], time: f64) -> Vec<f64> {
        let mut moved = q.to_vec();
        System::displace(&self.free, &mut moved, &v.iter().map(|v| time * v).collect::<Vec<_>>());
        moved
    }
}

/// `[M Gᵀ; G 0]` with `M` and the load from the scene without couplings, `G` and `Ġ v` from differences of gaps.
fn dense(closed: &Closed, q: &[f64], v: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
    let n = v.len();
    let mut system = System::new(&closed.free);
    let mut residual = |a: &[f64]| {
        let mut out = vec![0.0; n];
        system.at(0.0, q, v).residual(a, &mut out).expect("finite");
        DVector::from_vec(out)
    };
    let load = residual(&vec![0.0; n]);
    let unit = |j: usize| (0..n).map(|i| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
    let columns: Vec<DVector<f64>> = (0..n).map(|j| residual(&unit(j)) - &load).collect();
    let mass = DMatrix::from_columns(&columns);
    let weights = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
    let h = 1e-3;
    let column = |j: usize| {
        let at = |times: f64| closed.gaps(&closed.moved(q, &unit(j), times * h));
        weights.iter().map(|(times, weight)| at(*times) * (weight / (12.0 * h))).sum::<DVector<f64>>()
    };
    let rows = DMatrix::from_columns(&(0..n).map(column).collect::<Vec<_>>());
    let at = |times: f64| closed.gaps(&closed.moved(q, v, times * h));
    let second = [(-2.0, -1.0), (-1.0, 16.0), (0.0, -30.0), (1.0, 16.0), (2.0, -1.0)];
    let bias: DVector<f64> = second.iter().map(|(times, weight)| at(*times) * (weight / (12.0 * h * h))).sum();
    let m = bias.len();
    let mut matrix = DMatrix::zeros(n + m, n + m);
    matrix.view_mut((0, 0), (n, n)).copy_from(&mass);
    matrix.view_mut((n, 0), (m, n)).copy_from(&rows);
    matrix.view_mut((0, n), (n, m)).copy_from(&rows.transpose());
    let right = DVector::from_iterator(n + m, load.iter().chain(bias.iter()).map(|x| -x));
    let solution = matrix.lu().solve(&right).expect("independent rows");
    (solution.rows(0, n).into_owned(), mass)
}

#[test]
fn couplings_through_beams_accelerate_as_the_dense_equations_say() {
    let mut tried = 0;
    for seed in 0..100 {
        let mut random = Random::new(9000 + seed);
        let Some(closed) = Closed::some(&mut random) else { continue };
        let [_, v, _] = state(&mut random, &closed.free);
        let q = closed.model.start_position.clone();
        let (expected, mass) = dense(&closed, &q, &v);
        // Dense factors of the columns that differences gave have no more digits than that.
        let scale = mass.diagonal().map(|x| 1.0 / x.sqrt());
        let scaled = DMatrix::from_fn(v.len(), v.len(), |i, j| scale[i] * mass[(i, j)] * scale[j]);
        if !(scaled.symmetric_eigenvalues().min() > 1e-8) {
            continue;
        }
        tried += 1;
        let mut found = vec![0.0; v.len()];
        System::new(&closed.model).at(0.0, &q, &v).accelerations(&mut found).expect("no singular hinge");
        let size = |a: &DVector<f64>| a.dot(&(&mass * a)).abs().sqrt();
        let off = size(&(DVector::from_vec(found) - &expected)) / size(&expected);
        assert!(off < 1e-6, "seed {seed}: {off:.1e} of the accelerations");
    }
    assert!(tried > 60, "{tried}");
}

/// A boom on a pin and a rod, with a load on a slide that is locked: the pin bears no moment about its axis, and what the boom
/// bears there is what the pin passes on. Without its lock the load would fall and the rod would bear less.
#[test]
fn what_a_boom_bears_at_its_pin_is_the_reaction_there() {
    let boom = BeamDescription::new("boom", HingeDescription::revolute([0.0, 1.0, 0.0]))
        .length(4.0)
        .stiffness([1e7, 1e7, 1e7, 1e5, 1e5, 1e5])
        .mass_per_length(20.0)
        .marker("eye", 1.5);
    let slide = HingeDescription::prismatic([0.0, 0.0, 1.0]).on("boom", "tip").locked();
    let rod = LoopDescription {
        name: "rod".to_owned(),
        closure: Closure::Rod { length: 1.5_f64.hypot(1.0) },
        between: [Attachment::from(("boom", "eye")), Attachment::from((GROUND, [0.0, 0.0, -1.0]))],
        frame: Default::default(),
        second_frame: None,
    };
    let load = BodyDescription::new("load", slide).mass(100.0).inertia([1.0; 3]);
    let (model, found) = solve(&Description::new("Boom").beam(boom).body(load).closure(rod));
    assert!(found.converged);
    let beams = stillpoint::statics::beams(&model, &found).expect("finite");
    let (root, passed) = (&beams[0].sections[0].forces, &found.reactions[model.body("boom").expect("its root")]);
    // The rod holds the load's moment with an arm of less than a metre.
    assert!(passed.force.norm() > 3.0 * 981.0, "{passed:?}");
    assert!(
        (root.fixed_rows::<3>(0).norm() - passed.force.norm()).abs() < 1e-8 * passed.force.norm(),
        "{root} {passed:?}"
    );
    assert!(root[4].abs() < 1e-8 * 4.0 * passed.force.norm(), "{root}");
}

/// A beam whose root is free but for a loop that welds it to the ground: without the loop it moves as a whole, and nothing of that is
/// stiff. It takes the steps of a beam that grows from the ground, and ends where that does.
#[test]
fn a_beam_welded_by_a_loop_takes_the_steps_of_one_that_is_fixed() {
    let scene = |hinge: &str, more: &str, want: &str| {
        let text = format!(
            "gravity = [-5.28, 2.8, -19.08]\n[statics]\nwant = {want:?}\n\
             [[beam]]\nname = \"rod\"\nhinge = {{ {hinge} }}\nlength = 2.6\ntwist = 0.17\nelements = 8\ndegree = 2\n\
             section = {{ circle = 0.1 }}\nmaterial = {{ young = 9e9, poisson = 0.15, density = 2100.0 }}\n\
             free = [\"bend\", \"twist\", \"stretch\", \"shear\"]\n\
             [[body]]\nname = \"weight\"\nmass = 75.0\ncenter = [0.5, 0.04, -0.2]\ninertia = [0.75, 0.75, 0.75]\n\
             hinge = {{ type = \"fixed\", parent = \"rod\", at = \"tip\" }}\n{more}"
        );
        let scenario = stillpoint::scenario::parse("rod.toml", &text, &[]).unwrap_or_else(|found| panic!("{found}"));
        let (model, _) = scenario.clone().built.take().expect("a sound scene");
        let found =
            stillpoint::statics::equilibrium(&model, &scenario.statics, &model.start_position).expect("no fault");
        assert!(found.converged, "{:?}", found.notes);
        let weight = poses(&model, &found.position)[model.body("weight").expect("a body")].translation.vector;
        (found, weight)
    };
    let weld = "[[loop]]\ntype = \"fixed\"\nbetween = [{ body = \"ground\", at = [0.3, 0.6, 0.8] }, \"rod.root\"]\n";
    let turned = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.512, 0.233, 0.205, 0.8005));
    let (roll, pitch, yaw) = turned.euler_angles();
    let fixed = format!("type = \"fixed\", at = [0.3, 0.6, 0.8], rpy = [{roll:?}, {pitch:?}, {yaw:?}]");
    let nalgebra::Quaternion { coords } = *turned.quaternion();
    let [x, y, z, w] = [0, 1, 2, 3].map(|i| coords[i]);
    let free = format!("type = \"free\", position = [0.3, 0.6, 0.8, {w:?}, {x:?}, {y:?}, {z:?}]");
    for want in ["any", "stable"] {
        let ((on_ground, expected), (welded, weight)) = (scene(&fixed, "", want), scene(&free, weld, want));
        assert!(
            welded.iterations <= on_ground.iterations + 2,
            "{want}: {} and {} steps",
            welded.iterations,
            on_ground.iterations
        );
        // The residual of both searches.
        assert!((weight - expected).norm() < 1e-7, "{want}: {weight} {expected}");
        assert!(on_ground.stability.map(|one| one.verdict) == welded.stability.map(|one| one.verdict));
    }
}

/// A guess that leaves a loop open is closed by hinges before beams are bent and stretched for it.
#[test]
fn hinges_close_a_gap_before_beams_do() {
    let text = "[[beam]]\nname = \"a\"\nhinge = { type = \"revolute\", axis = [0, 1, 0], stiffness = 30.0 }\nlength = 1.0\nelements = 6\n\
        section = { rectangle = [0.03, 0.006] }\nmaterial = { young = 70e9, density = 2700.0 }\nmarkers = { m = 0.5 }\nfree = [\"bend\", \"stretch\"]\n\
        [[loop]]\nname = \"lp\"\ntype = \"rod\"\nbetween = [\"a.m\", { body = \"ground\", at = [0.5, 0, 0.5] }]\nlength = 0.8\n";
    let scenario = stillpoint::scenario::parse("open.toml", text, &[]).unwrap_or_else(|why| panic!("{why}"));
    let model = Model::build(&scenario.description).expect("a sound scene");
    let (closed, _) = stillpoint::constraint::assemble(model).expect("a position");
    let hinge = closed.bodies[0].hinge.position;
    let strains = closed.start_position.iter().enumerate().filter(|(i, _)| *i != hinge).map(|(_, x)| x.abs());
    // The rod ends at 0.8 m below its pin: the lug at its distance of 0.5 m has to turn by 0.6 rad or so.
    assert!(closed.start_position[hinge].abs() > 0.4, "{:?}", closed.start_position);
    assert!(strains.fold(0.0, f64::max) < 0.05, "{:?}", closed.start_position);
}
