//! Links with inertia and no mass, and with neither.

use super::fixture::{import, joint, notes, refused, robot};
use crate::common::{Random, build, relative_difference};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::import::Options;
use stillpoint::model::Model;
use stillpoint::scenario;

fn model(text: &str, options: &Options) -> Arc<Model> {
    let imported = import(text, options);
    build(&scenario::parse("robot.toml", &imported.scenario, &[]).unwrap_or_else(|error| panic!("{error}")).description)
}

fn accelerations(model: &Arc<Model>, velocity: &[f64]) -> Vec<f64> {
    let mut accelerations = velocity.to_vec();
    System::new(model)
        .at(0.0, &model.start_position, velocity)
        .accelerations(&mut accelerations)
        .expect("accelerations");
    accelerations
}

/// Mass, centre and inertia about the centre, in the axes of the link.
#[derive(Clone)]
struct Weight {
    mass: f64,
    center: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl Weight {
    fn random(random: &mut Random, mass: f64) -> Self {
        let turn = random.turn().to_rotation_matrix();
        let moments = Vector3::from_fn(|_, _| random.between(0.1, 0.19));
        let inertia = turn * Matrix3::from_diagonal(&moments) * turn.transpose();
        Self { mass, center: random.vector(0.3), inertia }
    }

    /// With another one that stands at `at`: moments about a point add up.
    fn with(&self, other: &Self, at: Vector3<f64>) -> Self {
        let about_origin = |it: &Self, center: Vector3<f64>| {
            it.inertia + it.mass * (Matrix3::identity() * center.norm_squared() - center * center.transpose())
        };
        let there = other.center + at;
        let mass = self.mass + other.mass;
        let center = (self.mass * self.center + other.mass * there) / mass;
        let whole = about_origin(self, self.center) + about_origin(other, there);
        let inertia = whole - mass * (Matrix3::identity() * center.norm_squared() - center * center.transpose());
        Self { mass, center, inertia }
    }

    fn link(&self, name: &str) -> String {
        let (c, i) = (self.center, self.inertia);
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"{} {} {}\"/><mass value=\"{}\"/>\
             <inertia ixx=\"{}\" iyy=\"{}\" izz=\"{}\" ixy=\"{}\" ixz=\"{}\" iyz=\"{}\"/></inertial></link>\n",
            c.x, c.y, c.z, self.mass, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23
        )
    }
}

/// Chains whose links carry welded ones of inertia and little or no mass move as if each pair were one link.
#[test]
fn welded_inertia_counts_without_mass() {
    let mut random = Random::new(41);
    for _ in 0..40 {
        let (mut pairs, mut whole) = (String::new(), String::new());
        let mut last = "base".to_owned();
        for index in 0..1 + random.below(3) {
            let name = format!("link{index}");
            let mass = random.between(0.2, 2.0);
            let arm = Weight::random(&mut random, mass);
            let light = [0.0, 0.0, 1e-12, 0.3][random.below(4)];
            let tip = Weight::random(&mut random, light);
            let (at, axis, origin) = (random.vector(0.5), random.vector(1.0), random.vector(0.5));
            let written = |v: Vector3<f64>| format!("{} {} {}", v.x, v.y, v.z);
            let inner = format!("<origin xyz=\"{}\"/><axis xyz=\"{}\"/>", written(origin), written(axis));
            let hinge = joint(&format!("turn{index}"), "continuous", [&last, &name], &inner);
            let tip_name = format!("tip{index}");
            let weld = joint(
                &format!("weld{index}"),
                "fixed",
                [&name, &tip_name],
                &format!("<origin xyz=\"{}\"/>", written(at)),
            );
            pairs += &format!("{}{hinge}{}{weld}", arm.link(&name), tip.link(&tip_name));
            whole += &format!("{}{hinge}", arm.with(&tip, at).link(&name));
            last = name;
        }
        let [pairs, whole] = [pairs, whole].map(|inner| model(&robot(&inner), &Options::default()));
        let velocity = random.list(whole.start_velocity.len(), -2.0, 2.0);
        let [pairs, whole] = [pairs, whole].map(|model| accelerations(&model, &velocity));
        // Round-off of the sums above, times the condition of short chains (below 1e4).
        assert!(relative_difference(&pairs, &whole) < 1e-11, "{pairs:?} {whole:?}");
    }
}

/// One flag for all joints that carry nothing.
#[test]
fn joints_that_carry_nothing_are_fixed_if_asked_for() {
    let heavy = Weight { mass: 1.0, center: Vector3::x(), inertia: Matrix3::identity() }.link("arm");
    let text = robot(&format!(
        "{heavy}<link name=\"eye\"/><link name=\"lid\"/><link name=\"lens\"/>{}{}{}{}",
        joint("turn", "continuous", ["base", "arm"], "<axis xyz=\"0 1 0\"/>"),
        joint("pan", "revolute", ["arm", "eye"], "<limit lower=\"-1\" upper=\"1\"/>"),
        joint("blink", "continuous", ["eye", "lid"], "<mimic joint=\"pan\"/>"),
        joint("mount", "fixed", ["eye", "lens"], ""),
    ));
    let said = refused(&text);
    assert!(
        said.contains("neither `eye` nor anything it carries has mass") && said.contains("--weld-massless"),
        "{said}"
    );

    let options = Options { weld_massless: true, ..Options::default() };
    let said = notes(&import(&text, &options));
    for name in ["pan", "blink"] {
        let note = format!("approximated: joint `{name}`: it carries nothing with mass: it is fixed, as asked for");
        assert!(said.contains(&note), "{said}");
    }
    assert!(!said.contains("joint `turn`") && !said.contains("joint `mount`"), "{said}");
    let found = model(&text, &options);
    assert_eq!(found.start_velocity.len(), 1);
}

/// What is there for pictures stops nothing.
#[test]
fn pictures_do_not_stop_physics() {
    let mut random = Random::new(43);
    let words = ["", "1", "-1 1 1", "0 0 0", "nan 1 1", "1 1", "a b c", "1e999 1 1", "1 2 3 4", "0.001"];
    let heavy = Weight { mass: 1.0, center: Vector3::x(), inertia: Matrix3::identity() }.link("arm");
    let turn = joint("turn", "continuous", ["base", "arm"], "<axis xyz=\"0 1 0\"/>");
    let plain = model(&robot(&format!("{heavy}{turn}")), &Options::default());
    for _ in 0..60 {
        let mut word = || words[random.below(words.len())];
        let solid = [
            format!("<mesh filename=\"Cargo.toml\" scale=\"{}\"/>", word()),
            format!("<box size=\"{}\"/>", word()),
            format!("<sphere radius=\"{}\"/>", word()),
            format!("<cylinder radius=\"{}\" length=\"1\"/>", word()),
            "<mesh/>".to_owned(),
        ];
        let looks = format!(
            "<visual><geometry>{}</geometry><material name=\"m\"><color rgba=\"{}\"/></material></visual></link>",
            solid[random.below(solid.len())],
            words[random.below(words.len())]
        );
        let found = model(&robot(&format!("{}{turn}", heavy.replace("</link>", &looks))), &Options::default());
        assert_eq!(accelerations(&found, &[0.5]), accelerations(&plain, &[0.5]));
    }
    // What moves is another matter.
    assert!(refused(&robot(&format!("{heavy}{}", turn.replace("0 1 0", "0 1")))).contains("must be 3 numbers"));
}
