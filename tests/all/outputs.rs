//! Outputs: their values, how they vary, and where they are told.

mod claims;
mod files;
mod records;
mod values;

use crate::common::{Options, Random, random_scene};
use nalgebra::Vector3;
use std::sync::Arc;
use stillpoint::dynamics::{Fault, Powers, System};
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::output::{Given, Outputs, Varied};

/// A point of a body of a scene, or of the ground.
fn point(random: &mut Random, bodies: &[BodyDescription]) -> Attachment {
    let body = match random.below(bodies.len() + 1) {
        0 => GROUND.to_owned(),
        index => bodies[index - 1].name.clone(),
    };
    Attachment { body, point: Point::At(random.vector(0.7)) }
}

fn direction(random: &mut Random, bodies: &[BodyDescription]) -> DirectionDescription {
    DirectionDescription { body: point(random, bodies).body, axis: random.vector(2.0) + Vector3::x() * 0.1 }
}

/// A random tree with outputs of every kind that follows from where its links are.
fn scene(seed: u64) -> Description {
    let options = Options { bodies: 1 + (seed as usize * 3) % 7, springs: true, welds: true };
    let mut scene = random_scene(seed + 900, &options);
    let mut random = Random::new(seed + 77);
    let random = &mut random;
    let bodies = scene.bodies.clone();
    let mut add = |name: &str, of: QuantityDescription| scene.outputs.push(OutputDescription::new(name, of));
    let on = point(random, &bodies);
    for (index, axes) in [Axes::Inertial, Axes::Body].into_iter().enumerate() {
        for (name, order) in [("x", Order::Position), ("v", Order::Velocity), ("a", Order::Acceleration)] {
            let quantity = |axis| QuantityDescription::Point { order, on: on.clone(), axis, axes };
            add(&format!("{name}{index}"), quantity(None));
            add(&format!("{name}{index} along"), quantity(Some(random.vector(3.0))));
        }
    }
    let between = [point(random, &bodies), point(random, &bodies)];
    add("distance", QuantityDescription::Distance { between });
    for (name, about) in [("angle", None), ("signed", Some(random.vector(1.0)))] {
        let (of, against) = (direction(random, &bodies), direction(random, &bodies));
        add(name, QuantityDescription::Angle { of, against, about });
    }
    for body in &bodies {
        add(&format!("turn of {}", body.name), QuantityDescription::Orientation { body: body.name.clone() });
        add(&format!("reaction of {}", body.name), reaction(&body.name, Axes::Inertial));
        if body.hinge.kind.counts().0 > 0 {
            add(&format!("q of {}", body.name), QuantityDescription::Coordinate { of: body.name.clone() });
            add(&format!("rate of {}", body.name), QuantityDescription::Rate { of: body.name.clone() });
        }
    }
    for force in &scene.forces.clone() {
        let name = &force.name;
        scene.outputs.push(OutputDescription::new(
            &format!("force {name}"),
            QuantityDescription::Force { of: name.clone(), component: None },
        ));
        if matches!(force.kind, ForceKind::Spring(_)) {
            let length = QuantityDescription::Length { of: name.clone() };
            scene.outputs.push(OutputDescription::new(&format!("length {name}"), length));
        }
    }
    let text = "sin(distance) * {x0[1]} - signed * t + {v0 along}^2";
    let formula = QuantityDescription::Expression { text: text.to_owned(), unit: "m".to_owned() };
    scene.outputs.push(OutputDescription::new("formula", formula));
    scene
}

fn reaction(body: &str, axes: Axes) -> QuantityDescription {
    QuantityDescription::Reaction { body: body.to_owned(), component: None, axes }
}

/// A state of a model with hinge accelerations, whatever forces they need.
#[derive(Clone)]
struct Place {
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

impl Place {
    /// The start of a model, with its accelerations.
    fn start(model: &Arc<Model>) -> Self {
        let (q, v) = (model.start_position.clone(), model.start_velocity.clone());
        let mut a = v.clone();
        System::new(model).at(0.0, &q, &v).accelerations(&mut a).unwrap();
        Self { time: 0.0, q, v, a }
    }

    /// Moved by a step of a direction.
    fn moved(&self, model: &Model, by: &Varied<'_>, step: f64) -> Self {
        let scaled = |list: &[f64]| list.iter().map(|x| step * x).collect::<Vec<f64>>();
        let add = |list: &[f64], by: &[f64]| list.iter().zip(by).map(|(x, by)| x + step * by).collect::<Vec<f64>>();
        let mut q = self.q.clone();
        System::displace(model, &mut q, &scaled(by.position));
        Self { time: self.time + step * by.time, q, v: add(&self.v, by.velocity), a: add(&self.a, by.acceleration) }
    }

    /// The numbers of all outputs and their variations in a direction.
    fn outputs(&self, model: &Arc<Model>, by: &Varied<'_>) -> Result<(Vec<f64>, Vec<f64>), Fault> {
        let mut system = System::new(model);
        let mut at = system.at(self.time, &self.q, &self.v);
        let (mut residual, mut reactions) = (self.v.clone(), Vec::new());
        at.share_multipliers()?;
        let energies = at.energies();
        let balanced = at.residual(&self.a, &mut residual)?;
        balanced.reactions(&mut reactions);
        let given = Given {
            accelerations: &self.a,
            reactions: &reactions,
            stops: &[],
            contacts: &[],
            energies,
            account: [0.0; 2],
            powers: Powers::default(),
        };
        let mut outputs = Outputs::new(model).expect("outputs");
        let values = outputs.evaluate(&balanced, &given)?.to_vec();
        Ok((values, outputs.vary(&balanced, &given, by).to_vec()))
    }
}

/// What the numbers of an output are at the start of a model.
fn at_start(model: &Arc<Model>, name: &str) -> Vec<f64> {
    let values = stillpoint::simulate::outputs::at_start(model, 0.0).unwrap();
    let output = model.outputs.iter().find(|output| output.name == name).unwrap_or_else(|| panic!("no `{name}`"));
    values[output.range()].to_vec()
}
