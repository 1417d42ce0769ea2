//! From bodies with joints to bodies with one hinge each, and to the text of a scenario.

use super::super::Options;
use super::super::draft::{Draft, Entry};
use super::super::log::{Place, Problem, Taken};
use super::super::xml::Element;
use super::collide::Colliders;
use super::key::Key;
use super::pose::{clean, roll_pitch_yaw};
use super::scene::{Body, Joint, Kind, Scene, WORLD};
use crate::model::description::GROUND;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use std::collections::HashSet;
use toml_edit::{Array, InlineTable, Value};

/// What the scenario is made of besides its bodies.
pub(super) struct Output {
    /// The body that every joint carries.
    carried: Vec<String>,
    /// What bodies are called.
    bodies: Vec<String>,
    used: HashSet<String>,
    /// The names of loops, gears, drives and forces.
    taken: HashSet<String>,
    pub(super) loops: Vec<Entry>,
    pub(super) gears: Vec<Entry>,
    pub(super) drives: Vec<Entry>,
    pub(super) motors: Vec<Entry>,
    pub(super) forces: Vec<Entry>,
    colliders: Colliders,
}

impl Output {
    /// Gives every body and every joint before a body's last its name.
    pub(super) fn new(scene: &Scene<'_>, options: &Options) -> Self {
        let moved = options.at != [0.0; 3] || options.rpy != [0.0; 3];
        let world = format!("{}{}", options.prefix, scene.bodies[WORLD].name);
        let mut output = Self {
            carried: vec![String::new(); scene.joints.len()],
            bodies: Vec::new(),
            used: scene.bodies.iter().map(|body| format!("{}{}", options.prefix, body.name)).collect(),
            taken: HashSet::new(),
            loops: Vec::new(),
            gears: Vec::new(),
            drives: Vec::new(),
            motors: Vec::new(),
            forces: Vec::new(),
            colliders: Colliders::default(),
        };
        for (index, body) in scene.bodies.iter().enumerate() {
            let name = format!("{}{}", options.prefix, body.name);
            if let Some((last, others)) = body.joints.split_last() {
                output.carried[*last] = name.clone();
                for joint in others {
                    let wanted = format!("{name}/{}", scene.joints[*joint].name);
                    output.carried[*joint] = unique(wanted, &mut output.used);
                }
            }
            output.bodies.push(if index == WORLD && !moved { GROUND.to_owned() } else { name });
        }
        output.bodies[WORLD] = if moved { world } else { GROUND.to_owned() };
        output
    }

    /// The body by which the scenario names a joint's hinge.
    pub(super) fn hinge_name(&self, joint: usize) -> String {
        self.carried[joint].clone()
    }

    /// A name that no other loop, gear, drive or force has.
    pub(super) fn unique(&mut self, name: &str) -> String {
        unique(name.to_owned(), &mut self.taken)
    }

    /// Where something came from, for a comment.
    pub(super) fn says(&self, element: &Element<'_>, what: &str) -> String {
        let (file, line) = element.log.line(&element.place());
        let separator = if what.is_empty() { "" } else { ": " };
        format!("{}, {file} line {line}{separator}{what}", element.label())
    }

    /// A point of a body, given in the body's own frame.
    pub(super) fn attachment(&self, scene: &Scene<'_>, body: usize, at: Vector3<f64>) -> Value {
        let at = clean(at - scene.origin(body));
        let name = &self.bodies[body];
        if at == [0.0; 3] && !name.contains('.') {
            return name.as_str().into();
        }
        let mut table = InlineTable::new();
        table.insert("body", name.as_str().into());
        table.insert("at", Value::Array(at.into_iter().collect::<Array>()));
        Value::InlineTable(table)
    }

    /// Adds a vector that is not zero.
    pub(super) fn vector(&self, entry: &mut Entry, key: &str, vector: Vector3<f64>, from: Option<Place>) {
        let numbers = clean(vector);
        if numbers != [0.0; 3] {
            entry.numbers(key, &numbers, from);
        }
    }

    /// Writes everything.
    pub(super) fn write(mut self, scene: &Scene<'_>, key: &Key, options: &Options, draft: &mut Draft) {
        self.heading(scene, key, draft);
        let ground = format!("{}{}", options.prefix, scene.bodies[WORLD].name);
        let called = |body: usize| match body {
            WORLD => (ground.clone(), self.bodies[WORLD] != GROUND),
            _ => (self.bodies[body].clone(), true),
        };
        let part = |name: String| unique(name, &mut self.used);
        self.colliders = Colliders::new(scene, called, part, &format!("{}*", options.prefix));
        let world = &scene.bodies[WORLD];
        if !world.shapes.is_empty() || self.bodies[WORLD] != GROUND {
            let mut entry = Entry::new(Some(world.element.place()));
            entry.comment("What does not move");
            entry.set("name", ground.as_str(), None);
            self.colliders.shapes(&mut entry, scene, WORLD);
            let mut hinge = Entry::new(None);
            hinge.set("type", "fixed", None);
            self.vector(&mut hinge, "at", options.at.into(), None);
            self.vector(&mut hinge, "rpy", options.rpy.into(), None);
            entry.inline("hinge", hinge);
            draft.add("body", entry);
            self.colliders.parts(scene, WORLD, &ground, draft);
        }
        for index in 1..scene.bodies.len() {
            self.body(scene, index, draft);
            self.colliders.parts(scene, index, &self.bodies[index], draft);
        }
        for (joint, body) in scene.joints.iter().zip(&self.carried).filter(|(_, body)| !body.is_empty()) {
            draft.joint(&joint.name, body);
        }
        for (list, entries) in [
            ("loop", self.loops),
            ("gear", self.gears),
            ("drive", self.drives),
            ("motor", self.motors),
            ("force", self.forces),
            ("contact", self.colliders.contacts),
        ] {
            entries.into_iter().for_each(|entry| draft.add(list, entry));
        }
    }

    fn heading(&mut self, scene: &Scene<'_>, key: &Key, draft: &mut Draft) {
        let root = scene.bodies[WORLD].element;
        let (file, _) = root.log.line(&root.place());
        let title = root.text("model").unwrap_or(&file).to_owned();
        draft.set(
            "title",
            &format!("From {file}: bodies and joints are called as there, a hinge by the body it carries."),
            title,
            None,
        );
        draft.set("gravity", "", clean(scene.settings.gravity).into_iter().collect::<Array>(), None);
        let mut simulate = Entry::new(None);
        let floating = scene.joints.iter().find(|joint| joint.kind == Kind::Free);
        let start = match (key.moves(), floating) {
            (true, _) => Some("the keyframe moves".to_owned()),
            (_, Some(_)) if scene.settings.contacts => Some("`statics` says whether it stands".to_owned()),
            (_, Some(joint)) => {
                Some(format!("nothing holds `{}`: contacts are not imported", scene.bodies[joint.body].name))
            }
            _ => None,
        };
        if let Some(name) = &key.name {
            simulate.comment(&format!("Positions and velocities are those of {name}."));
        }
        if let Some(why) = start {
            simulate.comment(&format!("Given, not in equilibrium: {why}."));
            simulate.set("start", "given", None);
        }
        simulate.set("duration", 10.0, None);
        draft.settings("simulate", simulate);
    }

    /// A body, and bodies without mass before it where it has several joints.
    fn body(&mut self, scene: &Scene<'_>, index: usize, draft: &mut Draft) {
        let body = &scene.bodies[index];
        finite(body, scene);
        let anchors = scene.anchors(index);
        let origin = scene.origin(index);
        let mut parent = self.bodies[body.parent].clone();
        let mut at = body.pose * nalgebra::Point3::from(anchors.first().copied().unwrap_or_default());
        at -= scene.origin(body.parent);
        let mut frame = body.pose.rotation;
        let mut before = anchors.first().copied().unwrap_or_default();
        for (place, joint) in body.joints.iter().enumerate() {
            let joint_index = *joint;
            let joint = &scene.joints[joint_index];
            let last = place + 1 == body.joints.len();
            if place > 0 {
                at = (anchors[place] - before).into();
                frame = UnitQuaternion::identity();
                before = anchors[place];
            }
            if joint.kind == Kind::Free {
                (at, frame) = (nalgebra::Point3::origin(), UnitQuaternion::identity());
            }
            let hinge = self.hinge(joint, &parent, at.coords, &frame, &body.pose);
            let mut entry = Entry::new(Some(joint.element.place()));
            let name = self.carried[joint_index].clone();
            if last {
                entry.comment(&self.says(&body.element, &carried(joint, origin)));
                self.solid(&mut entry, scene, index, hinge);
            } else {
                entry
                    .comment(&self.says(&joint.element, &format!("carries `{}` without weighing anything", body.name)));
                entry.set("name", name.as_str(), None);
                entry.inline("hinge", hinge);
            }
            draft.add("body", entry);
            parent = name;
        }
        if body.joints.is_empty() {
            let mut hinge = Entry::new(None);
            hinge.set("type", "fixed", None);
            hinge.set("parent", parent.as_str(), None);
            self.vector(&mut hinge, "at", at.coords, None);
            self.vector(&mut hinge, "rpy", roll_pitch_yaw(&frame), None);
            let mut entry = Entry::new(Some(body.element.place()));
            entry.comment(&self.says(&body.element, ""));
            self.solid(&mut entry, scene, index, hinge);
            draft.add("body", entry);
        }
        self.hold_up(scene, index);
    }

    /// What a body is, besides its hinge.
    fn solid(&self, entry: &mut Entry, scene: &Scene<'_>, index: usize, hinge: Entry) {
        let body = &scene.bodies[index];
        let origin = scene.origin(index);
        entry.set("name", self.bodies[index].as_str(), None);
        let i = &body.mass.inertia;
        if body.mass.mass > 0.0 || *i != Matrix3::zeros() {
            entry.set("mass", body.mass.mass, None);
            self.vector(entry, "center", body.mass.center - origin, None);
            let size = i.trace();
            let snap = |value: f64| if value.abs() <= 1e-15 * size { 0.0 } else { value };
            let mut moments = vec![i[(0, 0)], i[(1, 1)], i[(2, 2)]];
            let products = [i[(0, 1)], i[(0, 2)], i[(1, 2)]].map(snap);
            if products != [0.0; 3] {
                moments.extend(products);
            }
            entry.numbers("inertia", &moments, None);
            if body.mass.mass == 0.0 {
                entry.set("unphysical", true, None);
                body.element.note(Taken::Used, "it has inertia and no mass: it is taken as it stands");
            }
        }
        let mut markers = Entry::new(None);
        let mut any = false;
        for site in scene.sites.iter().filter(|site| site.body == index) {
            if let Some(name) = &site.name {
                any = true;
                markers.numbers(name, &clean(site.pose.translation.vector - origin), Some(site.place.clone()));
            }
        }
        if any {
            entry.inline("markers", markers);
        }
        self.colliders.shapes(entry, scene, index);
        entry.inline("hinge", hinge);
    }

    fn hinge(
        &self,
        joint: &Joint<'_>,
        parent: &str,
        at: Vector3<f64>,
        frame: &UnitQuaternion<f64>,
        reference: &Isometry3<f64>,
    ) -> Entry {
        let place = Some(joint.element.place());
        let mut hinge = Entry::new(place);
        let kind = match joint.kind {
            Kind::Hinge => "revolute",
            Kind::Slide => "prismatic",
            Kind::Ball => "spherical",
            Kind::Free => "free",
        };
        hinge.set("type", kind, None);
        if parent != GROUND {
            hinge.set("parent", parent, None);
        }
        self.vector(&mut hinge, "at", at, None);
        self.vector(&mut hinge, "rpy", roll_pitch_yaw(frame), None);
        if joint.kind.is_scalar() {
            hinge.numbers("axis", &clean(joint.axis), None);
        }
        let scalar = joint.kind.is_scalar();
        let list = |hinge: &mut Entry, key: &str, numbers: &[f64]| match numbers {
            [number] if scalar => hinge.set(key, *number, None),
            _ => hinge.numbers(key, numbers, None),
        };
        if !scalar || joint.start[0] != 0.0 {
            list(&mut hinge, "position", &joint.start);
        }
        if joint.velocity.iter().any(|speed| *speed != 0.0) {
            list(&mut hinge, "velocity", &joint.velocity);
        }
        let acting = &joint.acting;
        let mut force = acting.force.clone();
        if acting.stiffness != 0.0 {
            hinge.set("stiffness", acting.stiffness, None);
            if scalar && acting.pull != 0.0 {
                hinge.set("rest", acting.pull / acting.stiffness, None);
            } else if joint.kind == Kind::Free {
                let q = reference.rotation;
                let rest: Vec<f64> = reference.translation.vector.iter().copied().chain([q.w, q.i, q.j, q.k]).collect();
                hinge.numbers("rest", &rest, None);
            }
        } else if scalar {
            force[0] += acting.pull;
        }
        for (key, number) in [("damping", acting.damping), ("armature", acting.armature), ("friction", acting.friction)]
        {
            if number != 0.0 {
                hinge.set(key, number, None);
            }
        }
        if force.iter().any(|number| *number != 0.0) {
            list(&mut hinge, "force", &force);
        }
        if let Some([low, high]) = joint.range {
            hinge.numbers("limits", &[low, high], None);
        }
        hinge
    }

    /// `gravcomp`: a part of the weight, pulling up at the centre of mass.
    fn hold_up(&mut self, scene: &Scene<'_>, index: usize) {
        let body = &scene.bodies[index];
        let force = -body.gravity_compensation * body.mass.mass * scene.settings.gravity;
        if force == Vector3::zeros() {
            return;
        }
        if !scene.settings.has_passive_forces() {
            let what = "`gravcomp` does not act: MuJoCo leaves out all passive forces if springs and dampers are both switched off";
            body.element.note(Taken::Used, what);
            return;
        }
        let mut entry = Entry::new(Some(body.element.place()));
        entry.comment(&self.says(&body.element, &format!("gravcomp = {}", body.gravity_compensation)));
        entry.set("name", self.unique(&format!("gravcomp of {}", self.bodies[index].clone())), None);
        entry.set("type", "load", None);
        entry.set("on", self.attachment(scene, index, body.mass.center), None);
        self.vector(&mut entry, "force", force, None);
        self.forces.push(entry);
    }
}

/// What the comment of a body says about the joint that carries it.
fn carried(joint: &Joint<'_>, origin: Vector3<f64>) -> String {
    let mut text = joint.element.label();
    if origin != Vector3::zeros() {
        let [x, y, z] = clean(origin);
        text += &format!("; its points count from the joint, {x} {y} {z} there");
    }
    if joint.reference != 0.0 {
        text += &format!("; qpos is {} more than the coordinate", joint.reference);
    }
    text
}

/// Says so where a number of a body is none.
fn finite(body: &Body<'_>, scene: &Scene<'_>) {
    let pose = body.pose.to_homogeneous();
    let mut numbers =
        body.mass.inertia.iter().chain(body.mass.center.iter()).chain([&body.mass.mass]).chain(pose.iter());
    let joint = |joint: &Joint<'_>| {
        let acting = &joint.acting;
        let own = [acting.stiffness, acting.pull, acting.damping, acting.armature, acting.friction];
        own.iter().chain(&joint.start).chain(&acting.force).chain(joint.range.iter().flatten()).all(|x| x.is_finite())
    };
    let joints = body.joints.iter().all(|index| joint(&scene.joints[*index]));
    if !numbers.all(|number| number.is_finite()) || !joints {
        let message = format!("{}: its numbers grow beyond all that can be computed with", body.element.label());
        body.element.refuse(Problem::at(body.element.place(), message).help("look at its sizes, densities and gears"));
    }
}

fn unique(wanted: String, used: &mut HashSet<String>) -> String {
    let mut name = wanted.clone();
    let mut number = 2;
    while !used.insert(name.clone()) {
        name = format!("{wanted}_{number}");
        number += 1;
    }
    name
}
