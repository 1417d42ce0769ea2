//! `<keyframe>`: where the model starts.

use super::super::Options;
use super::super::log::{Place, Problem, Taken};
use super::super::xml::{Attribute, Element};
use super::scene::{Kind, Scene};
use super::tree::Tree;
use crate::suggest::closest;

/// The chosen keyframe.
#[derive(Default)]
pub(super) struct Key {
    /// What it is called, for people.
    pub(super) name: Option<String>,
    position: Option<(Vec<f64>, Place)>,
    velocity: Option<(Vec<f64>, Place)>,
    controls: Vec<f64>,
    activations: Vec<f64>,
}

/// The keyframe that the options name, or the first one.
pub(super) fn read(tree: &Tree<'_>, options: &Options) -> Key {
    let keys: Vec<Element<'_>> = tree.section("keyframe").into_iter().filter(|key| key.name() == "key").collect();
    let name = |index: usize, key: &Element<'_>| match key.text("name") {
        Some(name) => format!("keyframe `{name}`"),
        None => format!("keyframe {index}"),
    };
    let wanted =
        |index: usize, key: &Element<'_>, wanted: &str| key.text("name") == Some(wanted) || wanted.parse() == Ok(index);
    let chosen = match &options.key {
        Some(key) => keys.iter().enumerate().position(|(index, element)| wanted(index, element, key)),
        None => (!keys.is_empty()).then_some(0),
    };
    if let (Some(wanted), None) = (&options.key, chosen) {
        let near = closest(wanted, keys.iter().filter_map(|key| key.text("name")));
        let message = format!("there is no keyframe `{wanted}`");
        let help =
            near.map_or_else(|| format!("the model has {}", keys.len()), |near| format!("did you mean `{near}`?"));
        tree.root.refuse(Problem::at(tree.root.place(), message).help(help));
    }
    let mut found = Key::default();
    for (index, key) in keys.iter().enumerate() {
        key.see();
        let lists = ["qpos", "qvel", "ctrl", "act"].map(|list| key.attribute(list));
        for other in ["mpos", "mquat", "time"] {
            if key.attribute(other).is_some() && chosen == Some(index) {
                key.note(Taken::Ignored, format!("`{other}`"));
            }
        }
        if chosen != Some(index) {
            let what = "another keyframe is the start; `--key` chooses one by name or number";
            key.note(Taken::Ignored, what);
            continue;
        }
        let [position, velocity, controls, activations] =
            lists.map(|list| list.and_then(|attribute: Attribute<'_>| Some((attribute.numbers()?, attribute.place()))));
        let numbers = |list: Option<(Vec<f64>, Place)>| list.map(|(numbers, _)| numbers).unwrap_or_default();
        key.note(Taken::Used, "positions, velocities and controls at the start");
        found = Key {
            name: Some(name(index, key)),
            position,
            velocity,
            controls: numbers(controls),
            activations: numbers(activations),
        };
    }
    found
}

impl Key {
    pub(super) fn control(&self, index: usize) -> f64 {
        self.controls.get(index).copied().unwrap_or(0.0)
    }

    pub(super) fn activation(&self, index: usize) -> f64 {
        self.activations.get(index).copied().unwrap_or(0.0)
    }

    /// Whether the model moves at the start.
    pub(super) fn moves(&self) -> bool {
        self.velocity.iter().flat_map(|(list, _)| list).any(|speed| *speed != 0.0)
    }

    /// Puts the start into the joints: the keyframe, or else the reference.
    pub(super) fn place(&self, tree: &Tree<'_>, scene: &mut Scene<'_>) {
        let order = scene.in_order();
        let count = |which: fn((usize, usize)) -> usize| -> usize {
            order.iter().map(|joint| which(scene.joints[*joint].kind.counts())).sum()
        };
        let sizes = [count(|counts| counts.0), count(|counts| counts.1)];
        let lists = [(&self.position, "qpos", sizes[0]), (&self.velocity, "qvel", sizes[1])];
        for (list, name, size) in lists {
            if let Some((numbers, place)) = list.as_ref().filter(|(numbers, _)| numbers.len() != size) {
                let what = self.name.as_deref().unwrap_or_default();
                let plural = if size == 1 { "" } else { "s" };
                let message = format!("{what}: `{name}` must have {size} number{plural}, found {}", numbers.len());
                let help = "one number for each hinge and slide, 4 (velocities: 3) for a ball, 7 (6) for a free joint";
                tree.root.refuse(Problem::at(place.clone(), message).help(help));
                return;
            }
        }
        let (mut at, mut rate) = (0, 0);
        for index in order {
            let (coordinates, velocities) = scene.joints[index].kind.counts();
            let pose = scene.bodies[scene.joints[index].body].pose;
            let joint = &mut scene.joints[index];
            let written = self.position.as_ref().map(|(list, _)| &list[at..at + coordinates]);
            joint.start = match (joint.kind, written) {
                (Kind::Hinge | Kind::Slide, Some(list)) => vec![list[0] - joint.reference],
                (_, Some(list)) => list.to_vec(),
                (Kind::Hinge | Kind::Slide, None) => vec![0.0],
                (Kind::Ball, None) => vec![1.0, 0.0, 0.0, 0.0],
                (Kind::Free, None) => {
                    let q = pose.rotation;
                    pose.translation.vector.iter().copied().chain([q.w, q.i, q.j, q.k]).collect()
                }
            };
            // A quaternion of zeros stands for none.
            if joint.start.len() > 3 && joint.start[coordinates - 4..].iter().all(|part| *part == 0.0) {
                joint.start[coordinates - 4] = 1.0;
            }
            if let Some((list, _)) = &self.velocity {
                joint.velocity = list[rate..rate + velocities].to_vec();
            }
            at += coordinates;
            rate += velocities;
        }
    }
}
