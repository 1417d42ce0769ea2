//! `<actuator>`: constant forces, and servos as the springs and dampers that they are.

use super::super::draft::Entry;
use super::super::log::Taken;
use super::super::xml::Element;
use super::defaults::{ACTUATORS, Settled};
use super::inertia;
use super::key::Key;
use super::law::{Dynamics, Law};
use super::lower::Output;
use super::model::{Instance, Model};
use super::scene::{Acts, Part, Scene, find};
use super::servo;
use super::tendon::{Path, Tendons};
use nalgebra::Vector3;

/// Reads all actuators: what they do is in the hinges and forces then.
pub(super) fn read<'a>(models: &[Model<'a>], scene: &mut Scene<'a>, tendons: &Tendons, key: &Key, output: &mut Output) {
    let instances = scene.instances.clone();
    let of = |instance: &Instance| -> Vec<Settled<'a>> {
        let Model { tree, defaults, .. } = &models[instance.model];
        let elements = tree.section("actuator").into_iter().filter(|element| ACTUATORS.contains(&element.name()));
        elements.map(|element| defaults.of(&element, None)).collect()
    };
    // What turns with the joints is part of the inertia that others are reckoned from.
    for instance in &instances {
        scene.enter(instance, models);
        of(instance).iter().for_each(|settled| reflected(settled, scene));
    }
    inertia::spring_dampers(scene);
    // Controls and activations of those that are there; of those before them in their own model.
    let mut whole = [0; 2];
    for (place, instance) in instances.iter().enumerate() {
        scene.enter(instance, models);
        let mut own = [0; 2];
        for settled in of(instance) {
            let law = Law::read(&settled);
            let counts = if key.is_of(place) { own } else { whole };
            let start = key.is_for(place).then(|| [key.control(counts[0]), key.activation(counts[1])]);
            let step = [1, usize::from(law.is_activated())];
            let there = is_attached(&settled, scene, tendons);
            for (count, step) in own.iter_mut().zip(step).chain(whole.iter_mut().zip(step).filter(|_| there)) {
                *count += step;
            }
            one(&settled, &law, start.unwrap_or_default(), scene, tendons, output);
        }
    }
    servo::settle(scene, output);
}

/// Whether what it acts on has been attached with it; MuJoCo leaves it out otherwise.
fn is_attached(settled: &Settled<'_>, scene: &Scene<'_>, tendons: &Tendons) -> bool {
    let there = |key: &str, has: &dyn Fn(&str) -> bool| {
        settled.attribute(key).is_none_or(|at| scene.prefix.is_empty() || has(&scene.full(at.value)))
    };
    let joint = |name: &str| scene.names.joints.contains_key(name);
    let site = |name: &str| scene.names.sites.contains_key(name);
    there("joint", &joint)
        && there("jointinparent", &joint)
        && there("site", &site)
        && there("tendon", &|name| tendons.has(name))
        && there("body", &|name| scene.names.bodies.contains_key(name))
}

/// An actuator with its control and its activation at the start.
fn one<'a>(
    settled: &Settled<'a>,
    law: &Law<'a>,
    [control, activation]: [f64; 2],
    scene: &mut Scene<'a>,
    tendons: &Tendons,
    output: &mut Output,
) {
    let element = settled.element;
    element.text("name");
    let group = settled.number("group").unwrap_or(0.0);
    let idle = scene.settings.idle_groups.contains(&group);
    let why = match law.unknown() {
        _ if !scene.settings.actuation => Some("actuation is switched off in `<option>`".to_owned()),
        Some(what) if !idle => Some(format!("{what}: nothing acts")),
        _ => None,
    };
    if let Some(why) = why {
        element.note(Taken::Ignored, why);
        settled.skip(&TRANSMISSION);
        return;
    }
    if idle {
        // Its force is zero before `forcerange` bounds it, to MuJoCo.
        let what =
            format!("`actuatorgroupdisable` switches its group {group} off: no more acts than `forcerange` asks for");
        element.note(Taken::Used, what);
        act(settled, &Law::nothing(), 0.0, scene, tendons, output);
        return;
    }
    let control = clamped(settled, control, scene);
    let input = match law.dynamics() {
        Dynamics::Integrator => {
            if control != 0.0 {
                let what = format!("its set point stays at {activation}, although `ctrl` moves it");
                element.note(Taken::Approximated, what);
            }
            activation
        }
        Dynamics::Filter => {
            element.note(Taken::Approximated, "it acts at once: its filter is left out");
            control
        }
        Dynamics::None => control,
    };
    act(settled, law, input, scene, tendons, output);
}

/// `armature` and `damping` of the motor, as the joint feels them.
fn reflected(settled: &Settled<'_>, scene: &mut Scene<'_>) {
    let armature = settled.not_negative("armature").unwrap_or(0.0);
    let damping = settled.numbers("damping", 3).unwrap_or_else(|| vec![0.0]);
    if armature == 0.0 && damping.iter().all(|number| *number == 0.0) {
        return;
    }
    let joint = settled.attribute("joint").or_else(|| settled.attribute("jointinparent"));
    let joint = joint.and_then(|joint| find(&joint, "joint", &scene.names.joints, scene));
    let Some(joint) = joint.filter(|joint| scene.joints[*joint].kind.is_scalar()) else {
        settled.element.note(Taken::Ignored, "`armature` and `damping` of the motor: it does not act on one hinge");
        return;
    };
    if damping.iter().skip(1).any(|number| *number != 0.0) {
        settled.element.note(Taken::Approximated, "`damping`: only its linear part is taken");
    }
    let gear = gear(settled)[0];
    let acting = &mut scene.joints[joint].acting;
    acting.armature += armature * gear * gear;
    acting.damping += damping[0] * gear * gear;
}

fn gear(settled: &Settled<'_>) -> Vec<f64> {
    let mut gear = settled.numbers("gear", 6).unwrap_or_else(|| vec![1.0]);
    gear.resize(6, 0.0);
    gear
}

/// The control within its range.
fn clamped(settled: &Settled<'_>, control: f64, scene: &Scene<'_>) -> f64 {
    // A damper is always limited, whatever is said.
    let limited = settled.limited("ctrllimited", "ctrlrange", scene.settings.autolimits);
    let limited = limited || settled.element.name() == "damper";
    match settled.vector::<2>("ctrlrange").filter(|[low, high]| limited && scene.settings.clamp_control && low <= high)
    {
        Some([low, high]) => control.clamp(low, high),
        None => control,
    }
}

/// Attributes of an actuator: what it acts on, and its ranges.
pub(super) const TRANSMISSION: [&str; 14] = [
    "joint",
    "jointinparent",
    "tendon",
    "site",
    "refsite",
    "body",
    "cranksite",
    "slidersite",
    "cranklength",
    "gear",
    "ctrlrange",
    "ctrllimited",
    "forcerange",
    "forcelimited",
];

fn act<'a>(
    settled: &Settled<'a>,
    law: &Law<'a>,
    input: f64,
    scene: &mut Scene<'a>,
    tendons: &Tendons,
    output: &mut Output,
) {
    let element = settled.element;
    let mut law = *law;
    if let Some(ratio) = law.damp_ratio() {
        law.bias[2] = if law.bias[1] < 0.0 { damped(settled, ratio, law.bias[1], scene, tendons) } else { 0.0 };
    }
    let [constant, slope, rate] = law.at(input);
    let mut acts = Acts { constant, slope, rate };
    let nothing = [acts.constant, acts.slope, acts.rate] == [0.0; 3];
    let limited = settled.limited("forcelimited", "forcerange", scene.settings.autolimits);
    let bounds = settled.vector::<2>("forcerange").filter(|[low, high]| limited && low <= high);
    if let Some([low, high]) = bounds.filter(|_| !acts.is_servo()) {
        acts.constant = acts.constant.clamp(low, high);
    }
    let bounds = bounds.filter(|_| acts.is_servo());
    let gear = gear(settled);
    let at = |key: &str| settled.attribute(key);
    if let Some(joint) = at("joint").or_else(|| at("jointinparent")) {
        let in_parent = at("jointinparent").is_some();
        let Some(joint) = find(&joint, "joint", &scene.names.joints, scene) else { return };
        if scene.joints[joint].kind.is_scalar() {
            servo::add(joint, Part { element, gear: gear[0], acts, bounds }, scene, output);
        } else if acts.is_servo() || in_parent {
            element.note(Taken::Ignored, "a servo on a ball or a free joint has no equal here: nothing acts");
        } else {
            let joint = &mut scene.joints[joint];
            joint.acting.force.iter_mut().zip(&gear).for_each(|(force, gear)| *force += gear * acts.constant);
        }
    } else if let Some(tendon) = at("tendon") {
        match tendons.path(&tendon, scene).cloned() {
            Some(Path::Fixed(terms)) => match terms[..] {
                [(joint, factor)] => {
                    servo::add(joint, Part { element, gear: gear[0] * factor, acts, bounds }, scene, output);
                }
                _ if !acts.is_servo() => {
                    for (joint, factor) in terms {
                        servo::add(joint, Part { element, gear: gear[0] * factor, acts, bounds }, scene, output);
                    }
                }
                _ => element.note(Taken::Ignored, "a servo that pulls several joints has no equal here: nothing acts"),
            },
            Some(Path::Line(sites)) => {
                bounds.iter().for_each(|range| servo::unbounded(&element, *range));
                along(settled, sites, gear[0], &acts, scene, output);
            }
            Some(Path::Other) if !nothing => {
                element.note(Taken::Ignored, "its tendon runs over more than two sites: nothing acts");
            }
            _ => {}
        }
    } else if let Some(site) = at("site") {
        let reference = at("refsite").is_some();
        let Some(site) = find(&site, "site", &scene.names.sites, scene) else { return };
        if acts.is_servo() || reference && !nothing {
            element.note(Taken::Ignored, "a servo between sites has no equal here: nothing acts");
        } else if acts.constant != 0.0 {
            push(&element, site, &gear, acts.constant, scene, output);
        }
    } else {
        settled.skip(&TRANSMISSION);
        if !nothing {
            element.note(Taken::Ignored, "it acts on contacts or through a slider and crank, which has no equal here");
        }
    }
    if nothing {
        element.note(Taken::Used, "nothing acts: its input is 0");
    }
}

/// `dampratio`: the bias per rate that gives this damping ratio with the inertia at the reference.
fn damped(settled: &Settled<'_>, ratio: f64, slope: f64, scene: &Scene<'_>, tendons: &Tendons) -> f64 {
    let joint = settled.attribute("joint").or_else(|| settled.attribute("jointinparent"));
    let joint = joint.and_then(|joint| Some((*scene.names.joints.get(&scene.full(joint.value))?, 1.0)));
    let tendon = || match tendons.fixed(&settled.attribute("tendon")?, scene)?[..] {
        [one] => Some(one),
        _ => None,
    };
    let found = joint.or_else(tendon).filter(|(joint, _)| scene.joints[*joint].kind.is_scalar());
    let gear = gear(settled)[0];
    let mass = found.and_then(|(joint, factor)| Some(inertia::apparent(scene, joint)? / (gear * factor).powi(2)));
    let Some(mass) = mass.filter(|mass| mass.is_finite()) else {
        settled.element.note(Taken::Ignored, "`dampratio`: the inertia that it asks for cannot be told; give `kv`");
        return 0.0;
    };
    let rate = -2.0 * ratio * (-slope * mass).sqrt();
    settled.element.note(Taken::Used, format!("`dampratio`: kv = {}, from the inertia {mass} that it moves", -rate));
    rate
}

/// A servo along the line between two sites is a spring.
fn along(settled: &Settled<'_>, sites: [usize; 2], gear: f64, acts: &Acts, scene: &Scene<'_>, output: &mut Output) {
    beyond_ranges(&settled.element, scene);
    let element = settled.element;
    let stiffness = -acts.slope * gear * gear;
    let damping = -acts.rate * gear * gear;
    let length = if stiffness > 0.0 { gear * acts.constant / stiffness } else { 0.0 };
    if stiffness < 0.0 || damping < 0.0 || length < 0.0 || stiffness == 0.0 && acts.constant != 0.0 {
        element.note(
            Taken::Ignored,
            "a force along a tendon that is no spring and damper has no equal here: nothing acts",
        );
        return;
    }
    if stiffness == 0.0 && damping == 0.0 {
        return;
    }
    let ends = sites.map(|site| (scene.sites[site].body, scene.sites[site].pose.translation.vector));
    let says = output.says(&element, "a servo along a tendon");
    let name = output.unique(element.text("name").unwrap_or("servo"));
    output.spring(&element, scene, (says, name), ends, [stiffness, length, damping]);
}

/// MuJoCo bounds what such an actuator does in each joint, too.
fn beyond_ranges(element: &Element<'_>, scene: &Scene<'_>) {
    if scene.joints.iter().any(|joint| joint.motor_range.is_some()) {
        let what = "`actuatorfrcrange` of joints does not bound what it does in them: it acts between bodies";
        element.note(Taken::Ignored, what);
    }
}

/// A constant wrench in the axes of a site.
fn push(element: &Element<'_>, site: usize, gear: &[f64], force: f64, scene: &Scene<'_>, output: &mut Output) {
    beyond_ranges(element, scene);
    let site = &scene.sites[site];
    let turned = |at: usize| site.pose.rotation * Vector3::new(gear[at], gear[at + 1], gear[at + 2]) * force;
    let mut entry = Entry::new(Some(element.place()));
    entry.comment(&output.says(element, "its thrust, along with the body"));
    entry.set("name", output.unique(element.text("name").unwrap_or("thrust")), None);
    entry.set("type", "load", None);
    entry.set("on", output.attachment(scene, site.body, site.pose.translation.vector), None);
    output.vector(&mut entry, "force", turned(0), None);
    output.vector(&mut entry, "torque", turned(3), None);
    entry.set("axes", "body", None);
    output.forces.push(entry);
}
