//! `<attach>`: a body, a frame or the whole world of another model, or of the same one, with a prefix before its names.

use super::super::log::Problem;
use super::super::xml::{Attribute, Element};
use super::body::{Around, Parts, Walk};
use super::model::{Instance, Model};
use crate::suggest::closest;

impl<'a> Walk<'_, 'a> {
    /// Puts what is attached to where `<attach>` stands.
    pub(super) fn attach(&mut self, element: &Element<'a>, around: &Around, parts: &mut Parts) {
        element.see();
        let (other, prefix) = (element.attribute("model"), element.required("prefix"));
        let part = element.attribute("body").or_else(|| element.attribute("frame"));
        let Some(prefix) = prefix else { return };
        let index = match other {
            Some(name) => match self.other(&name) {
                Some(index) => index,
                None => return,
            },
            None if part.is_some() => self.at,
            None => {
                let message = format!("{}: it names neither a model nor a body or frame of this one", element.label());
                element.refuse(Problem::at(element.place(), message).help("give `model`, `body` or `frame`"));
                return;
            }
        };
        let first = self.scene.bodies.len();
        let outer = (self.at, self.scene.prefix.clone(), self.scene.settings.clone());
        self.scene.prefix += prefix.value;
        self.at = index;
        self.scene.settings = self.models[index].settings.clone();
        self.attached += 1;
        match part {
            Some(name) => self.part(&name, around, parts),
            None => self.world(around, parts),
        }
        self.attached -= 1;
        if other.is_some() {
            let (prefix, bodies) = (self.scene.prefix.clone(), first..self.scene.bodies.len());
            self.scene.instances.push(Instance { model: index, prefix, bodies });
        }
        (self.at, self.scene.prefix, self.scene.settings) = outer;
    }

    fn other(&self, name: &Attribute<'a>) -> Option<usize> {
        let models = &self.model().models;
        let found = models.get(name.value).copied();
        if found.is_none() {
            let near = closest(name.value, models.keys().map(String::as_str));
            let help = near.map_or_else(
                || "models are declared in <asset>, as in <model name=\"hand\" file=\"hand.xml\"/>".to_owned(),
                |near| format!("did you mean `{near}`?"),
            );
            let problem = name.wrong(&format!("is \"{}\": there is no such model in <asset>", name.value));
            name.element.refuse(problem.help(help));
        }
        found
    }

    /// A body, in its pose in what it stands in, or a frame with its pose and everything in it.
    fn part(&mut self, name: &Attribute<'a>, around: &Around, parts: &mut Parts) {
        let Some((part, class)) = find(self.model(), name.key, name.value) else {
            let problem = name.wrong(&format!("is \"{}\": there is no such {} in the model", name.value, name.key));
            name.element.refuse(problem);
            return;
        };
        let around = Around { class, ..around.clone() };
        if name.key == "body" {
            self.body(&part, &around);
        } else {
            let inner = self.frame(&part, &around);
            self.children(&part, &inner, parts);
        }
    }
}

/// A body or a frame by its name, and the class of elements there.
fn find<'a>(model: &Model<'a>, kind: &str, name: &str) -> Option<(Element<'a>, Option<usize>)> {
    let class_of = |element: &Element<'a>, around: Option<usize>| {
        element.attribute("childclass").and_then(|class| model.defaults.class(&class)).or(around)
    };
    let worlds = model.tree.all(&model.tree.root, "worldbody");
    let mut stack: Vec<(Element<'a>, Option<usize>)> =
        worlds.into_iter().rev().map(|world| (world, class_of(&world, None))).collect();
    while let Some((element, class)) = stack.pop() {
        let children = model.tree.children(&element).into_iter().rev();
        for child in children.filter(|child| ["body", "frame"].contains(&child.name())) {
            if child.name() == kind && child.text("name") == Some(name) {
                return Some((child, class));
            }
            stack.push((child, class_of(&child, class)));
        }
    }
    None
}
