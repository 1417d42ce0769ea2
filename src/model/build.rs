//! From a description to a model: names resolved, every problem collected.

use super::beam::{self, Expanded};
use super::couple::loop_places;
use super::description::{Attachment, BodyDescription, Description, GROUND, Point};
use super::modal::ModalBodies;
use super::problem::{Element, Problem};
use super::tree::Tree;
use super::{Model, check, contact, couple, hinge_curve, modal, motor, output, watch};
use crate::force::{Describe, Report};
use crate::suggest;
use nalgebra::Vector3;
use std::collections::HashMap;

pub(super) fn build(given: &Description) -> Result<Model, Vec<Problem>> {
    let problems = beam::check(given);
    if !problems.is_empty() {
        return Err(problems);
    }
    let problems = modal::check(given);
    if !problems.is_empty() {
        return Err(problems);
    }
    let whole = match given.beams.is_empty() && given.modals.is_empty() {
        true => None,
        false => {
            let (laid, shapes) = beam::lay(given)?;
            // Cables have their lengths now.
            let problems = beam::check(&laid);
            if !problems.is_empty() {
                return Err(problems);
            }
            Some(beam::expand(laid, &shapes))
        }
    };
    let built = build_expanded(whole.as_ref().map_or(given, |whole| &whole.description), whole.as_ref());
    built.map_err(|mut problems| {
        // A beam's own body stands in for it.
        let of_body = |body: usize| whole.as_ref()?.beams.iter().rposition(|beam| beam.root <= body);
        for problem in &mut problems {
            match problem.element {
                Element::Body(body) if body >= given.bodies.len() => {
                    let inner = |modal: &&ModalBodies| modal.inner == body || modal.tips.contains(&body);
                    if let Some(modal) = whole.as_ref().and_then(|whole| whole.modals.iter().find(inner)) {
                        problem.element = Element::Body(modal.root);
                        continue;
                    }
                    problem.element = of_body(body).map_or(problem.element, Element::Beam);
                }
                Element::Loop(index) if index >= given.loops.len() => {
                    let mut cables = (0..given.beams.len()).filter(|beam| given.beams[*beam].far.is_some());
                    let cable = cables.nth(index - given.loops.len());
                    problem.element = cable.map_or(problem.element, Element::Beam);
                }
                _ => {}
            }
        }
        problems
    })
}

fn build_expanded(description: &Description, whole: Option<&Expanded>) -> Result<Model, Vec<Problem>> {
    let mut problems = check::check(description);
    couple::check(description, &mut problems);
    motor::check(description, &mut problems);
    problems.extend(watch::check(description));
    problems.extend(contact::check(description));
    problems.extend(hinge_curve::check(description));
    let names = index_names(description, &mut problems);
    let markers = Markers::of(description);
    let parents = resolve_parents(description, &names, &mut problems);
    let (parents, hinge_points) = hinge_points(description, whole, &markers, parents, &mut problems);
    let order = depth_first(description, &parents, &mut problems);
    let mut places = Places { description, names: &names, markers: &markers, whole, problems: &mut problems };
    let (force_places, loop_places) = (force_places(description, &mut places), loop_places(description, &mut places));
    let (watched, asked) = (event_places(description, &mut places), output_places(description, &mut places));
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut tree = Tree::new(description, whole);
    for body in order {
        tree.grow(body, parents[body], hinge_points[body]);
    }
    tree.close();
    problems.extend(tree.massless_subtrees());
    if !problems.is_empty() {
        return Err(problems);
    }
    tree.finish(&force_places, &loop_places, &watched, &asked)
}

fn index_names<'a>(description: &'a Description, problems: &mut Vec<Problem>) -> HashMap<&'a str, usize> {
    let mut names = HashMap::new();
    for (index, body) in description.bodies.iter().enumerate() {
        if let Some(first) = names.insert(body.name.as_str(), index) {
            names.insert(body.name.as_str(), first);
            problems.push(Problem {
                element: Element::Body(index),
                field: "name".to_owned(),
                message: format!("two bodies are called `{}`", body.name),
                help: Some("names must be unique".to_owned()),
            });
        }
    }
    let mut forces = HashMap::new();
    for (index, force) in description.forces.iter().enumerate() {
        if forces.insert(force.name.as_str(), index).is_some() {
            problems.push(Problem {
                element: Element::Force(index),
                field: "name".to_owned(),
                message: format!("two forces are called `{}`", force.name),
                help: Some("names must be unique".to_owned()),
            });
        }
    }
    names
}

/// `before`: how many problems there are already.
fn unknown_body(before: usize, element: Element, field: &str, name: &str, description: &Description) -> Problem {
    let known = description.bodies.iter().map(|body| body.name.as_str()).chain([GROUND]);
    Problem {
        element,
        field: field.to_owned(),
        message: format!("there is no body `{name}`"),
        help: suggest::closest_of_many(before, name, known).map(|near| format!("did you mean `{near}`?")),
    }
}

fn resolve_parents(
    description: &Description,
    names: &HashMap<&str, usize>,
    problems: &mut Vec<Problem>,
) -> Vec<Option<usize>> {
    let resolve = |(index, body): (usize, &BodyDescription)| {
        let parent = body.hinge.parent.as_str();
        if parent == GROUND {
            return None;
        }
        let found = names.get(parent).copied();
        if found.is_none() {
            let element = Element::Body(index);
            problems.push(unknown_body(problems.len(), element, "hinge.parent", parent, description));
        }
        found
    };
    description.bodies.iter().enumerate().map(resolve).collect()
}

/// Bodies with parents before children and every subtree contiguous; cycles are problems.
fn depth_first(description: &Description, parents: &[Option<usize>], problems: &mut Vec<Problem>) -> Vec<usize> {
    let count = parents.len();
    let mut children = vec![Vec::new(); count];
    let mut stack: Vec<usize> = Vec::new();
    for (index, parent) in parents.iter().enumerate() {
        match parent {
            Some(parent) => children[*parent].push(index),
            None => stack.push(index),
        }
    }
    stack.reverse();
    let mut order = Vec::with_capacity(count);
    let mut reached = vec![false; count];
    while let Some(body) = stack.pop() {
        order.push(body);
        reached[body] = true;
        stack.extend(children[body].iter().rev());
    }
    if order.len() < count {
        report_cycles(description, parents, &mut reached, problems);
    }
    order
}

fn report_cycles(
    description: &Description,
    parents: &[Option<usize>],
    reached: &mut [bool],
    problems: &mut Vec<Problem>,
) {
    for start in 0..parents.len() {
        let mut path = Vec::new();
        let mut at = start;
        while !reached[at] {
            reached[at] = true;
            path.push(at);
            at = parents[at].unwrap_or(start);
        }
        if let Some(first) = path.iter().position(|body| *body == at) {
            let ring = &path[first..];
            let mut names: Vec<&str> = ring.iter().map(|body| description.bodies[*body].name.as_str()).collect();
            names.push(names[0]);
            problems.push(Problem {
                element: Element::Body(ring[0]),
                field: "hinge.parent".to_owned(),
                message: format!("the parents form a cycle: `{}`", names.join("` hangs on `")),
                help: Some("one of them must hang on `ground` or on a body outside the cycle".to_owned()),
            });
        }
    }
}

/// The markers of all bodies by their names.
struct Markers<'d> {
    description: &'d Description,
    at: HashMap<(usize, &'d str), Vector3<f64>>,
}

impl<'d> Markers<'d> {
    fn of(description: &'d Description) -> Self {
        let mut at = HashMap::new();
        for (index, body) in description.bodies.iter().enumerate() {
            for (marker, place) in &body.markers {
                at.entry((index, marker.as_str())).or_insert(*place);
            }
        }
        Self { description, at }
    }

    /// Where a point of a body is, or the problem that it has no such marker.
    fn point_on(
        &self,
        body: Option<usize>,
        point: &Point,
        element: Element,
        field: &str,
    ) -> Result<Vector3<f64>, Problem> {
        let name = match point {
            Point::At(at) => return Ok(*at),
            Point::Marker(name) => name,
        };
        let found = body.and_then(|body| self.at.get(&(body, name.as_str())));
        let body = body.map(|index| &self.description.bodies[index]);
        found.copied().ok_or_else(|| no_marker(body, name, element, field))
    }
}

fn no_marker(body: Option<&BodyDescription>, name: &str, element: Element, field: &str) -> Problem {
    let markers = body.map_or(&[][..], |body| &body.markers);
    let owner = body.map_or(GROUND, |body| body.name.as_str());
    let near = suggest::closest(name, markers.iter().map(|(marker, _)| marker.as_str()));
    let help = match (near, markers.is_empty()) {
        (Some(near), _) => format!("did you mean `{near}`?"),
        (None, true) => format!("`{owner}` has no markers: give coordinates instead"),
        (None, false) => {
            let all: Vec<&str> = markers.iter().map(|(marker, _)| marker.as_str()).collect();
            format!("it has `{}`", all.join("`, `"))
        }
    };
    let message = format!("`{owner}` has no marker `{name}`");
    Problem { element, field: field.to_owned(), message, help: Some(help) }
}

/// The bodies that carry the hinges, of a beam the right one of its bodies, and where these are on them.
fn hinge_points(
    description: &Description,
    whole: Option<&Expanded>,
    markers: &Markers<'_>,
    parents: Vec<Option<usize>>,
    problems: &mut Vec<Problem>,
) -> (Vec<Option<usize>>, Vec<Vector3<f64>>) {
    let resolve = |(index, body): (usize, &BodyDescription)| {
        if parents[index].is_none() && body.hinge.parent != GROUND {
            return (None, Vector3::zeros());
        }
        // An element's own hinge is at the root of a beam, and so is the weld of one that does not begin along x.
        let is_own = whole
            .is_some_and(|whole| whole.rods.contains_key(&index) || whole.is_welded(index) || whole.is_modal(index));
        let on_beam = whole.filter(|_| !is_own).and_then(|whole| whole.place(&body.hinge.parent, &body.hinge.at));
        if let Some((parent, at)) = on_beam {
            return (Some(parent), at);
        }
        let at = markers.point_on(parents[index], &body.hinge.at, Element::Body(index), "hinge.at");
        let at = at.unwrap_or_else(|problem| {
            problems.push(problem);
            Vector3::zeros()
        });
        (parents[index], at)
    };
    description.bodies.iter().enumerate().map(resolve).unzip()
}

/// A point on a body (`None`: the ground).
pub(super) type Place = (Option<usize>, Vector3<f64>);

/// Resolves attachments to places, and keeps what is wrong with them.
pub(super) struct Places<'a> {
    description: &'a Description,
    names: &'a HashMap<&'a str, usize>,
    markers: &'a Markers<'a>,
    whole: Option<&'a Expanded>,
    problems: &'a mut Vec<Problem>,
}

impl Places<'_> {
    pub(super) fn resolve(&mut self, attachment: &Attachment, element: Element, field: &str) -> Place {
        let nowhere = (None, Vector3::zeros());
        if let Some((body, at)) = self.whole.and_then(|whole| whole.place(&attachment.body, &attachment.point))
            && at.iter().all(|x| x.is_finite())
        {
            return (Some(body), at);
        }
        let body = match attachment.body.as_str() {
            GROUND => None,
            name => match self.names.get(name) {
                Some(index) => Some(*index),
                None => {
                    let before = self.problems.len();
                    self.problems.push(unknown_body(before, element, field, name, self.description));
                    return nowhere;
                }
            },
        };
        match self.markers.point_on(body, &attachment.point, element, field) {
            Ok(at) if at.iter().all(|x| x.is_finite()) => (body, at),
            Ok(_) => {
                let message = "a point has a coordinate that is not finite".to_owned();
                self.problems.push(Problem { element, field: field.to_owned(), message, help: None });
                nowhere
            }
            Err(problem) => {
                self.problems.push(problem);
                nowhere
            }
        }
    }
}

fn force_places(description: &Description, places: &mut Places<'_>) -> Vec<Vec<Place>> {
    let of_force = |(index, force): (usize, &super::description::ForceDescription)| {
        let attachments = force.kind.attachments().into_iter();
        let resolved: Vec<Place> =
            attachments.map(|(key, on)| places.resolve(on, Element::Force(index), &key)).collect();
        let known = places.problems.iter().all(|problem| problem.element != Element::Force(index));
        if known {
            let mut report = Report { name: &force.name, found: Vec::new() };
            force.kind.check_places(&resolved, &mut report);
            places.problems.extend(report.found.into_iter().map(|flaw| Problem::of_force(index, flaw)));
        }
        resolved
    };
    description.forces.iter().enumerate().map(of_force).collect()
}

/// Which point every event watches.
fn event_places(description: &Description, places: &mut Places<'_>) -> Vec<Option<Place>> {
    let of_event = |(index, event): (usize, &watch::EventDescription)| {
        watch::attachment(event).map(|on| places.resolve(on, Element::Event(index), "on"))
    };
    description.events.iter().enumerate().map(of_event).collect()
}

/// Which points and bodies every output names.
fn output_places(description: &Description, places: &mut Places<'_>) -> Vec<Vec<Place>> {
    let of_output = |(index, output): (usize, &output::OutputDescription)| {
        let named = output::attachments(&output.of).into_iter();
        // A beam's reaction is at its root, not at its tip.
        if let output::QuantityDescription::Reaction { body, .. } = &output.of
            && let Some(index) = places.names.get(body.as_str())
        {
            return vec![(Some(*index), Vector3::zeros())];
        }
        named.map(|(key, on)| places.resolve(&on, Element::Output(index), key)).collect()
    };
    description.outputs.iter().enumerate().map(of_output).collect()
}
