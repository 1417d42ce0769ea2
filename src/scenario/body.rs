//! `[[body]]`: one body or the template of a chain of copies.

use super::findings::Finding;
use super::hinge::{Hinge, hinge, point};
use super::mass::{Mass, STAND_IN, burn, mass};
use super::modal::{Made, modal};
use super::quantities::Parameters;
use super::reader::Reader;
use super::shape::shapes;
use crate::model::burn::BurnDescription;
use crate::model::description::{
    Attachment, BeamDescription, BodyDescription, Description, GROUND, ModalDescription, Point,
};
use nalgebra::Vector3;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// A body as it is written once.
#[derive(Debug)]
pub(super) struct Template {
    pub(super) repeat: Option<usize>,
    body: BodyDescription,
    unphysical: bool,
    burn: Option<BurnDescription>,
    modal: Option<Made>,
    next: Option<Point>,
    mass: Mass,
    hinge: Hinge,
}

/// Reads a `[[body]]`; without a readable name there is nothing that others could refer to.
pub(super) fn template(table: &Reader<'_>, folder: &Path, parameters: &Parameters) -> Option<Template> {
    let name = table.text("name")?;
    let repeat = table.count("repeat");
    let shapes = shapes(table, name, folder);
    let mut mass = mass(table, name, repeat, &shapes);
    let burn = burn(table, name);
    if table.has("burn") {
        let readable = burn.as_ref().filter(|burn| burn.timeline.flaw(burn.rows.len()).is_none());
        mass.properties = readable.map_or(STAND_IN, |burn| burn.at(0.0));
    }
    let modal = modal(table, name, folder);
    let mut hinge = hinge(table, name, repeat, parameters);
    // A marker that could not be read is there all the same: others may hang on it.
    let markers = table.names("markers").into_iter();
    let body = BodyDescription {
        name: name.to_owned(),
        mass: mass.properties,
        markers: markers.map(|(name, all)| (name.to_owned(), all.vector(name).unwrap_or_default())).collect(),
        shapes,
        hinge: hinge.description.clone(),
    };
    let unphysical = table.flag("unphysical").unwrap_or(false);
    Some(Template { repeat, body, unphysical, burn, modal, next: hinge.next.take(), mass, hinge })
}

impl Template {
    /// How many bodies it makes.
    pub(super) fn count(&self) -> usize {
        self.repeat.unwrap_or(1)
    }

    /// The bodies it makes.
    pub(super) fn expand(&self, description: &mut Description) {
        let bodies = &mut description.bodies;
        let first = bodies.len();
        self.expand_bodies(bodies);
        description.burns.extend(self.burn.clone());
        if let Some(Made { modal, file }) = &self.modal {
            let of_body = |body: &BodyDescription| ModalDescription {
                body: body.name.clone(),
                modal: Arc::clone(modal),
                file: Some(file.clone()),
                position: Vec::new(),
                velocity: Vec::new(),
            };
            description.modals.extend(description.bodies[first..].iter().map(of_body));
        }
        let bodies = &description.bodies;
        if self.unphysical {
            description.unphysical.extend(bodies[first..].iter().map(|body| body.name.clone()));
        }
    }

    fn expand_bodies(&self, bodies: &mut Vec<BodyDescription>) {
        let Some(copies) = self.repeat else {
            bodies.push(self.body.clone());
            return;
        };
        let next = self.next.as_ref().unwrap_or(&self.body.hinge.at);
        for copy in 0..copies {
            let mut body = self.body.clone();
            body.name = copy_name(&self.body.name, copy);
            if copy > 0 {
                body.hinge.parent = copy_name(&self.body.name, copy - 1);
                body.hinge.at = next.clone();
            }
            if let Some(masses) = &self.mass.each {
                body.mass.mass = masses[copy];
            }
            for (field, lists) in &self.hinge.each {
                field(&mut body.hinge).clone_from(&lists[copy]);
            }
            bodies.push(body);
        }
    }
}

/// What a copy is called.
pub(super) fn copy_name(name: &str, copy: usize) -> String {
    format!("{name}[{copy}]")
}

/// The names of all bodies and of the ground, to tell a body's dots from the dot before a marker.
pub(super) struct Names<'b>(HashSet<&'b str>);

impl<'b> Names<'b> {
    pub(super) fn new(bodies: &'b [BodyDescription], beams: &'b [BeamDescription]) -> Self {
        let beams = beams.iter().map(|beam| beam.name.as_str());
        Self(bodies.iter().map(|body| body.name.as_str()).chain(beams).chain([GROUND]).collect())
    }

    /// `body.marker` or `body`: the longest body name that is known, and the rest of the text is the marker. Where
    /// none is known the text is cut at its last dot.
    pub(super) fn attachment(&self, text: &str) -> Attachment {
        let root = |body: &str| Attachment { body: body.to_owned(), point: Point::At(Vector3::zeros()) };
        if self.0.contains(text) {
            return root(text);
        }
        let cuts = text.rmatch_indices('.').map(|(dot, _)| (&text[..dot], &text[dot + 1..]));
        let known = cuts.clone().find(|(body, _)| self.0.contains(body));
        match known.or_else(|| cuts.clone().next()) {
            Some((body, marker)) => Attachment { body: body.to_owned(), point: Point::Marker(marker.to_owned()) },
            None => root(text),
        }
    }

    /// `{ body = …, at = … }`
    pub(super) fn attachment_table(&self, table: &Reader<'_>) -> Option<Attachment> {
        let body = table.text("body")?.to_owned();
        if table.has("at") && table.has("marker") {
            let message = format!("attachment to body `{body}`: both `at` and `marker`");
            table.findings.push(Finding::error(table.key_span("marker"), message).help("keep one of the two"));
        }
        let point = match table.text("marker") {
            Some(marker) => Point::Marker(marker.to_owned()),
            None => point(table, "at").unwrap_or(Point::At(Vector3::zeros())),
        };
        Some(Attachment { body, point })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_belong_to_the_longest_known_body() {
        let names = Names(["arm", "arm.left", "link[2]", GROUND].into_iter().collect());
        let split = |text: &str| {
            let attachment = names.attachment(text);
            match attachment.point {
                Point::Marker(marker) => (attachment.body, marker),
                Point::At(_) => (attachment.body, String::new()),
            }
        };
        let pair = |body: &str, marker: &str| (body.to_owned(), marker.to_owned());
        assert_eq!(split("arm.left"), pair("arm.left", ""));
        assert_eq!(split("arm.left.tip"), pair("arm.left", "tip"));
        assert_eq!(split("arm.right.tip"), pair("arm", "right.tip"));
        assert_eq!(split("link[2].tip"), pair("link[2]", "tip"));
        assert_eq!(split("ground"), pair("ground", ""));
        assert_eq!(split("lnk.tip"), pair("lnk", "tip"));
        assert_eq!(split("lnk"), pair("lnk", ""));
    }
}
