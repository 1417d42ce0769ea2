//! Every problem that `Model::build` reports, provoked once: which element, which field, what is said.

mod bodies;
mod forces;
mod hinges;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use stillpoint::model::description::*;
use stillpoint::model::{Description, Element, Model, Problem};

fn body(name: &str, parent: &str, kind: HingeKind) -> BodyDescription {
    BodyDescription {
        name: name.to_owned(),
        mass: MassProperties { mass: 1.0, center: Vector3::zeros(), inertia: Matrix3::identity() },
        markers: vec![("tip".to_owned(), Vector3::x())],
        shapes: Vec::new(),
        hinge: HingeDescription { parent: parent.to_owned(), ..HingeDescription::new(kind) },
    }
}

const TURN: HingeKind = HingeKind::Revolute { axis: Vector3::new(0.0, 1.0, 0.0) };

/// Two bodies that are in order: `arm` on the ground, `hand` on the arm.
fn sound() -> Description {
    Description { bodies: vec![body("arm", GROUND, TURN), body("hand", "arm", TURN)], ..Description::default() }
}

fn on(body: &str) -> Attachment {
    Attachment { body: body.to_owned(), point: Point::At(Vector3::zeros()) }
}

fn at_marker(body: &str, marker: &str) -> Attachment {
    Attachment { body: body.to_owned(), point: Point::Marker(marker.to_owned()) }
}

fn spring(between: [Attachment; 2]) -> ForceKind {
    ForceKind::Spring(Spring { between, stiffness: 1.0, length: 1.0, damping: 0.0 })
}

fn bushing(between: [Attachment; 2]) -> ForceKind {
    ForceKind::Bushing(Bushing {
        between,
        frame: UnitQuaternion::identity(),
        stiffness: [1.0; 6],
        damping: [0.0; 6],
        preload: [0.0; 6],
    })
}

fn load(on: Attachment) -> ForceKind {
    ForceKind::Load(Load {
        on,
        force: Vector3::x(),
        torque: Vector3::zeros(),
        axes: LoadAxes::Inertial,
        over_time: None,
    })
}

fn force(name: &str, kind: ForceKind) -> ForceDescription {
    ForceDescription { name: name.to_owned(), kind }
}

fn problems(description: &Description) -> Vec<Problem> {
    Model::build(description).expect_err("a problem")
}

/// The one problem of the sound scene after a change.
fn problem_after(change: impl FnOnce(&mut Description)) -> Problem {
    let mut description = sound();
    change(&mut description);
    let mut found = problems(&description);
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

/// The change makes exactly one problem: of this element and field, saying these words (message or help).
#[track_caller]
fn assert_problem(element: Element, field: &str, words: &[&str], change: impl FnOnce(&mut Description)) {
    let found = problem_after(change);
    assert_eq!((found.element, found.field.as_str()), (element, field), "{found}");
    for word in words {
        assert!(found.to_string().contains(word), "`{found}` does not say `{word}`");
    }
}

const ARM: Element = Element::Body(0);
const HAND: Element = Element::Body(1);

#[test]
fn sound_scene_has_no_problems() {
    let model = Model::build(&sound()).unwrap();
    assert_eq!((model.bodies.len(), model.position_count(), model.velocity_count()), (2, 2, 2));
}

#[test]
fn scene_without_bodies_says_what_to_add() {
    let found = problems(&Description::default());
    assert_eq!((found.len(), found[0].element, found[0].field.as_str()), (1, Element::Scene, "body"));
    assert_eq!(found[0].to_string(), "the scene has no bodies (add at least one [[body]])");
}

#[test]
fn gravity_must_be_finite() {
    assert_problem(Element::Scene, "gravity", &["gravity is", "NaN", "finite m/s²"], |d| d.gravity.y = f64::NAN);
}

/// A person who made five mistakes hears of five, each where it is.
#[test]
fn all_problems_are_reported_at_once() {
    let mut description = sound();
    description.bodies[0].mass.mass = -1.0;
    description.bodies[0].hinge.kind = HingeKind::Revolute { axis: Vector3::zeros() };
    description.bodies[1].hinge.parent = "amr".to_owned();
    description.bodies[1].hinge.position = vec![0.0, 0.0];
    description.forces = vec![force("push", load(at_marker("hand", "tpi")))];
    let mut found: Vec<(Element, String)> =
        problems(&description).into_iter().map(|problem| (problem.element, problem.field)).collect();
    found.sort_by_key(|(element, field)| (format!("{element:?}"), field.clone()));
    let expected = [
        (ARM, "hinge.axis"),
        (ARM, "mass"),
        (HAND, "hinge.parent"),
        (HAND, "hinge.position"),
        (Element::Force(0), "on"),
    ];
    assert_eq!(found, expected.map(|(element, field)| (element, field.to_owned())));
}
