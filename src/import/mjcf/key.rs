//! `<keyframe>`: where the model starts.

use super::super::Options;
use super::super::log::{Place, Problem, Taken};
use super::super::xml::{Attribute, Element};
use super::model::{Instance, Model};
use super::scene::{Joint, Kind, Scene};
use crate::suggest::closest;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// The chosen keyframe.
#[derive(Default)]
pub(super) struct Key {
    /// What it is called, for people.
    pub(super) name: Option<String>,
    /// The place of the attached model that it is of, among all instances; none: it is of the whole.
    of: Option<usize>,
    position: Option<(Vec<f64>, Place)>,
    velocity: Option<(Vec<f64>, Place)>,
    controls: Vec<f64>,
    activations: Vec<f64>,
}

/// A keyframe of the model or of one that is attached.
struct Candidate<'a> {
    element: Element<'a>,
    /// With the prefix.
    name: Option<String>,
    of: Option<usize>,
}

impl Candidate<'_> {
    /// What it is called, for people; `index` is its place in the list.
    fn called(&self, index: usize) -> String {
        self.name.as_ref().map_or_else(|| format!("keyframe {index}"), |name| format!("keyframe `{name}`"))
    }
}

/// Keyframes of the main model, then of the attached ones.
fn candidates<'a>(models: &[Model<'a>], instances: &[Instance]) -> Vec<Candidate<'a>> {
    let mut list = Vec::new();
    let attached = instances.len().saturating_sub(1);
    for place in [attached].into_iter().chain(0..attached) {
        let Some(instance) = instances.get(place) else { continue };
        let keys = models[instance.model].tree.section("keyframe").into_iter().filter(|key| key.name() == "key");
        list.extend(keys.map(|element| {
            let name = element.text("name").map(|name| format!("{}{name}", instance.prefix));
            Candidate { element, name, of: (place < attached).then_some(place) }
        }));
    }
    list
}

/// The keyframe that the options name, or the first one.
pub(super) fn read(models: &[Model<'_>], instances: &[Instance], options: &Options) -> Key {
    let (keys, root) = (candidates(models, instances), models[0].tree.root);
    let wanted = |index: usize, key: &Candidate<'_>, wanted: &str| {
        key.name.as_deref() == Some(wanted) || wanted.parse() == Ok(index)
    };
    let chosen = match &options.key {
        Some(key) => keys.iter().enumerate().position(|(index, candidate)| wanted(index, candidate, key)),
        None => (!keys.is_empty()).then_some(0),
    };
    if let (Some(wanted), None) = (&options.key, chosen) {
        let near = closest(wanted, keys.iter().filter_map(|key| key.name.as_deref()));
        let message = format!("there is no keyframe `{wanted}`");
        let help =
            near.map_or_else(|| format!("the model has {}", keys.len()), |near| format!("did you mean `{near}`?"));
        root.refuse(Problem::at(root.place(), message).help(help));
    }
    let mut found = Key::default();
    for (index, key) in keys.iter().enumerate() {
        let element = key.element;
        element.see();
        let lists = ["qpos", "qvel", "ctrl", "act"].map(|list| element.attribute(list));
        for other in ["mpos", "mquat", "time"] {
            if element.attribute(other).is_some() && chosen == Some(index) {
                element.note(Taken::Ignored, format!("`{other}`"));
            }
        }
        if chosen != Some(index) {
            let what = "another keyframe is the start; `--key` chooses one by name or number";
            element.note(Taken::Ignored, what);
            continue;
        }
        let [position, velocity, controls, activations] =
            lists.map(|list| list.and_then(|attribute: Attribute<'_>| Some((attribute.numbers()?, attribute.place()))));
        let numbers = |list: Option<(Vec<f64>, Place)>| list.map(|(numbers, _)| numbers).unwrap_or_default();
        element.note(Taken::Used, "positions, velocities and controls at the start");
        found = Key {
            name: Some(key.called(index)),
            of: key.of,
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

    /// Whether it is of this instance alone.
    pub(super) fn is_of(&self, instance: usize) -> bool {
        self.of == Some(instance)
    }

    /// Whether it says something of this instance.
    pub(super) fn is_for(&self, instance: usize) -> bool {
        self.of.is_none_or(|of| of == instance)
    }

    /// Whether the model moves at the start.
    pub(super) fn moves(&self) -> bool {
        self.velocity.iter().flat_map(|(list, _)| list).any(|speed| *speed != 0.0)
    }

    /// Puts the start into the joints: the keyframe, or else the reference.
    pub(super) fn place(&self, models: &[Model<'_>], scene: &mut Scene<'_>) {
        let (spans, sizes) = self.spans(models, scene);
        let lists = [(&self.position, "qpos", sizes[0]), (&self.velocity, "qvel", sizes[1])];
        for (list, name, size) in lists {
            if let Some((numbers, place)) = list.as_ref().filter(|(numbers, _)| numbers.len() != size) {
                let what = self.name.as_deref().unwrap_or_default();
                let plural = if size == 1 { "" } else { "s" };
                let message = format!("{what}: `{name}` must have {size} number{plural}, found {}", numbers.len());
                let help = "one number for each hinge and slide, 4 (velocities: 3) for a ball, 7 (6) for a free joint";
                models[0].tree.root.refuse(Problem::at(place.clone(), message).help(help));
                return;
            }
        }
        for joint in &mut scene.joints {
            let pose = scene.bodies[joint.body].pose;
            joint.start = match joint.kind {
                Kind::Hinge | Kind::Slide => vec![0.0],
                Kind::Ball => vec![1.0, 0.0, 0.0, 0.0],
                Kind::Free => {
                    let q = pose.rotation;
                    pose.translation.vector.iter().copied().chain([q.w, q.i, q.j, q.k]).collect()
                }
            };
        }
        for Span { joint, at, rate } in spans {
            let body = scene.joints[joint].body;
            let alone = scene.bodies.iter().all(|other| other.parent != body);
            let principal = scene.bodies[body].principal;
            let joint = &mut scene.joints[joint];
            let (coordinates, velocities) = joint.kind.counts();
            if let Some((list, _)) = &self.position {
                joint.start = list[at..at + coordinates].to_vec();
                if joint.kind.is_scalar() {
                    joint.start[0] -= joint.reference;
                }
            }
            // A quaternion of zeros stands for none.
            if joint.start.len() > 3 && joint.start[coordinates - 4..].iter().all(|part| *part == 0.0) {
                joint.start[coordinates - 4] = 1.0;
            }
            if let Some((list, _)) = &self.velocity {
                joint.velocity = list[rate..rate + velocities].to_vec();
            }
            if joint.aligned && alone {
                unaligned(joint, &principal, self.position.is_some());
            }
        }
    }

    /// Where the numbers of each joint begin, and how many there are of coordinates and of velocities. The lists of an
    /// attached model go over all of its joints, also those that are not attached.
    fn spans(&self, models: &[Model<'_>], scene: &Scene<'_>) -> (Vec<Span>, [usize; 2]) {
        let Some(instance) = self.of.map(|of| &scene.instances[of]) else {
            return spans(scene, Some);
        };
        let alone = super::body::read(models, instance.model);
        let attached: Vec<usize> =
            scene.in_order().into_iter().filter(|joint| instance.bodies.contains(&scene.joints[*joint].body)).collect();
        spans(&alone, |index| {
            let own = &alone.joints[index];
            let named = format!("{}{}", instance.prefix, own.name);
            let same = |joint: &usize| {
                let other = &scene.joints[*joint];
                other.element.place() == own.element.place() && (other.name == named || other.name == own.name)
            };
            attached.iter().copied().find(same)
        })
    }
}

/// Makes coordinates and velocities of a body's principal axes, which MuJoCo's keyframe means with `align`, those of the body.
/// Where the keyframe says no coordinates they are those of the body already.
fn unaligned(joint: &mut Joint<'_>, principal: &Isometry3<f64>, moved: bool) {
    let [x, y, z, w, i, j, k] = joint.start[..] else { return };
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    let mut pose = Isometry3::from_parts(Translation3::new(x, y, z), turn);
    if moved {
        pose *= principal.inverse();
        let q = pose.rotation;
        joint.start = pose.translation.vector.iter().copied().chain([q.w, q.i, q.j, q.k]).collect();
    }
    if let [x, y, z, a, b, c] = joint.velocity[..] {
        let spin = principal.rotation * Vector3::new(a, b, c);
        let middle = Vector3::new(x, y, z);
        let rate = middle - pose.rotation * spin.cross(&principal.translation.vector);
        joint.velocity = rate.iter().chain(spin.iter()).copied().collect();
    }
}

/// Where the numbers of a joint begin in the lists of a keyframe.
struct Span {
    joint: usize,
    at: usize,
    rate: usize,
}

/// The spans of all joints that are there, by what each is in the whole.
fn spans(scene: &Scene<'_>, whole: impl Fn(usize) -> Option<usize>) -> (Vec<Span>, [usize; 2]) {
    let (mut list, mut sizes) = (Vec::new(), [0; 2]);
    for index in scene.in_order() {
        list.extend(whole(index).map(|joint| Span { joint, at: sizes[0], rate: sizes[1] }));
        let (coordinates, velocities) = scene.joints[index].kind.counts();
        sizes = [sizes[0] + coordinates, sizes[1] + velocities];
    }
    (list, sizes)
}
