//! Random scenes with fixed seeds.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::sync::Arc;
use std::time::UNIX_EPOCH;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::scenario::Scenario;
use stillpoint::spatial::{Principal, Sym3};
use stillpoint::statics::standing::Unanswered;
use stillpoint::statics::{InverseAnswer, answer};

/// How many damaged inputs the environment asks for: `ROBUST_CASES=100000` looks longer than a test usually does.
pub(crate) fn robust_cases() -> Option<u32> {
    std::env::var("ROBUST_CASES").ok().map(|cases| cases.parse().expect("ROBUST_CASES is a number"))
}

/// What statics answers to a scenario, from a model of it.
pub(crate) fn answered(scenario: &Scenario, model: Arc<Model>) -> Result<InverseAnswer, Unanswered> {
    answer(scenario.description.clone(), model, scenario.sought(), &scenario.statics, &scenario.margin, &|| true)
}

/// A small deterministic generator (splitmix64): failures are reproducible from the seed.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678)
    }

    /// For mutations: how many, and from where; from another seed each time where many are asked for.
    pub(crate) fn for_mutations(usual: usize, seed: u64) -> (usize, Self) {
        match robust_cases() {
            Some(cases) => (cases as usize, Self::new(UNIX_EPOCH.elapsed().map_or(seed, |now| now.as_nanos() as u64))),
            None => (usual, Self::new(seed)),
        }
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in low…high.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in 0…n−1.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub(crate) fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.between(-size, size))
    }

    pub(crate) fn turn(&mut self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.vector(1.5))
    }

    pub(crate) fn list(&mut self, n: usize, low: f64, high: f64) -> Vec<f64> {
        (0..n).map(|_| self.between(low, high)).collect()
    }

    pub(crate) fn unit(&mut self) -> Vector3<f64> {
        loop {
            let v = self.vector(1.0);
            if v.norm() > 0.2 {
                return v.normalize();
            }
        }
    }
}

/// What a random scene may contain.
#[derive(Clone, Copy)]
pub(crate) struct Options {
    pub(crate) bodies: usize,
    pub(crate) springs: bool,
    pub(crate) welds: bool,
}

pub(crate) fn hinge_kind(random: &mut Random, welds: bool) -> HingeKind {
    let axis = random.unit();
    match random.below(if welds { 8 } else { 7 }) {
        // Half the axes have a thread, by the axis itself: no further number is drawn for it.
        0 if axis.x > 0.0 => HingeKind::Screw { axis, pitch: 0.5 * axis.y },
        0 => HingeKind::Revolute { axis },
        1 => HingeKind::Prismatic { axis },
        2 => HingeKind::Cylindrical { axis },
        3 => {
            let across = axis.cross(&random.unit()).normalize();
            HingeKind::Universal { axes: [axis, across + 0.3 * axis] }
        }
        4 => HingeKind::Planar,
        5 => HingeKind::Spherical,
        6 => HingeKind::Free,
        _ => HingeKind::Fixed,
    }
}

pub(crate) fn position_of(random: &mut Random, kind: &HingeKind) -> Vec<f64> {
    let (count, velocities) = kind.counts();
    let mut position = random.list(velocities.min(count), -1.0, 1.0);
    if count != velocities {
        position.truncate(velocities - 3);
        let turn = random.turn();
        position.extend([turn.w, turn.i, turn.j, turn.k]);
    }
    position
}

pub(crate) fn body(random: &mut Random, name: String, parent: &str, options: &Options) -> BodyDescription {
    let kind = hinge_kind(random, options.welds);
    let (_, velocities) = kind.counts();
    let spread: Matrix3<f64> = Matrix3::from_fn(|_, _| random.between(-0.3, 0.3));
    let scatter: Matrix3<f64> = spread * spread.transpose() + 0.02 * Matrix3::identity();
    // The inertia of a mass distribution: trace(scatter) 1 − scatter always satisfies the triangle inequality.
    let inertia = scatter.trace() * Matrix3::identity() - scatter;
    let mut hinge = HingeDescription::new(kind);
    parent.clone_into(&mut hinge.parent);
    hinge.at = Point::At(random.vector(0.5));
    hinge.frame = random.turn();
    hinge.position = position_of(random, &kind);
    hinge.velocity = random.list(velocities, -2.0, 2.0);
    hinge.force = random.list(velocities, -1.0, 1.0);
    if options.springs {
        hinge.stiffness = random.list(velocities, 0.0, 5.0);
        hinge.damping = random.list(velocities, 0.0, 1.0);
        if random.below(3) == 0 {
            hinge.armature = random.list(velocities, 0.0, 0.5);
        }
        if random.below(2) == 0 {
            hinge.rest = position_of(random, &kind);
        }
    }
    BodyDescription {
        name,
        mass: MassProperties { mass: random.between(0.5, 2.0), center: random.vector(0.3), inertia },
        markers: vec![("tip".to_owned(), random.vector(0.5))],
        shapes: Vec::new(),
        hinge,
    }
}

/// A random tree with every kind of hinge and, if wanted, every kind of force element.
pub(crate) fn random_scene(seed: u64, options: &Options) -> Description {
    let mut random = Random::new(seed);
    let mut bodies: Vec<BodyDescription> = Vec::new();
    for index in 0..options.bodies {
        let parent = match random.below(index + 1) {
            0 => GROUND.to_owned(),
            // Long branches rather than bushes: mostly the last body.
            _ if random.below(2) == 0 => bodies[index - 1].name.clone(),
            near => bodies[near - 1].name.clone(),
        };
        bodies.push(body(&mut random, format!("b{index}"), &parent, options));
    }
    let mut forces = Vec::new();
    if options.springs {
        for index in 0..1 + options.bodies / 3 {
            forces.push(random_force(&mut random, index, &bodies));
        }
    }
    Description {
        title: format!("random {seed}"),
        gravity: random.vector(10.0),
        bodies,
        forces,
        ..Description::default()
    }
}

fn random_force(random: &mut Random, index: usize, bodies: &[BodyDescription]) -> ForceDescription {
    let attach = |random: &mut Random, body: &str| Attachment {
        body: body.to_owned(),
        point: if random.below(2) == 0 && body != GROUND {
            Point::Marker("tip".to_owned())
        } else {
            Point::At(random.vector(0.4))
        },
    };
    let first = random.below(bodies.len());
    let other = random.below(bodies.len());
    let partner = if other == first { GROUND } else { &bodies[other].name };
    let between = [attach(random, &bodies[first].name), attach(random, partner)];
    let kind = match random.below(4) {
        0 => ForceKind::Spring(Spring {
            between,
            stiffness: random.between(1.0, 20.0),
            length: random.between(0.0, 1.0),
            damping: random.between(0.0, 1.0),
        }),
        1 => ForceKind::Bushing(Bushing {
            between,
            frame: random.turn(),
            stiffness: [0; 6].map(|_| random.between(0.5, 5.0)),
            damping: [0; 6].map(|_| random.between(0.0, 0.5)),
            preload: [0.0; 6],
        }),
        axes => ForceKind::Load(Load {
            on: attach(random, &bodies[first].name),
            force: random.vector(5.0),
            torque: random.vector(2.0),
            axes: if axes == 2 { LoadAxes::Inertial } else { LoadAxes::Body },
            over_time: None,
        }),
    };
    ForceDescription { name: format!("f{index}"), kind }
}

/// Preloads all bushings of a scene, in proportion to their stiffness.
pub(crate) fn preload(description: &mut Description) {
    for force in &mut description.forces {
        if let ForceKind::Bushing(Bushing { stiffness, preload, .. }) = &mut force.kind {
            (0..6).for_each(|i| preload[i] = [0.4, -0.7, 0.2, 0.9, -0.3, 0.6][i] * stiffness[i]);
        }
    }
}

pub(crate) fn build(description: &Description) -> Arc<Model> {
    let model = Model::build(description).unwrap_or_else(|problems| panic!("{problems:?}"));
    assemble(model).unwrap_or_else(|problems| panic!("{problems:?}")).0
}

/// Largest difference relative to the largest number of the second list.
pub(crate) fn relative_difference(found: &[f64], expected: &[f64]) -> f64 {
    let scale = expected.iter().fold(1e-300_f64, |m, x| m.max(x.abs()));
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

/// Takes the inertia of a body's link, and leaves its mass on its root marker: a hinge that nothing resists, which no model
/// is built with.
pub(crate) fn take_inertia(model: &mut Arc<Model>, name: &str) {
    let body = model.body(name).expect("the body");
    let model = Arc::make_mut(model);
    let link = &mut model.links[model.bodies[body].link];
    (link.center, link.inertia, link.principal) = (Vector3::zeros(), Sym3::ZERO, Principal::default());
}
