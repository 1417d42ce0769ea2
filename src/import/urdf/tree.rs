//! Which link hangs on which.

use crate::import::Options;
use crate::import::log::{Log, Place, Problem, Taken};
use crate::import::xml::{Attribute, Element};
use crate::model::description::GROUND;
use std::collections::HashMap;

/// A `<link>`.
pub(super) struct Link<'a> {
    pub(super) name: &'a str,
    pub(super) name_place: Place,
    /// What it is called in the scenario.
    pub(super) body: String,
    pub(super) element: Element<'a>,
    /// The joint that carries it; none for the root.
    pub(super) joint: Option<usize>,
}

/// A `<joint>`.
pub(super) struct Joint<'a> {
    pub(super) name: &'a str,
    pub(super) element: Element<'a>,
    /// The links it connects.
    pub(super) parent: usize,
    pub(super) child: usize,
    pub(super) parent_place: Place,
    /// Fixed, whatever its type: it carries nothing with mass.
    pub(super) welded: bool,
}

/// A robot whose links hang together in one tree.
pub(super) struct Tree<'a> {
    pub(super) links: Vec<Link<'a>>,
    pub(super) joints: Vec<Joint<'a>>,
    /// All links, parents first, otherwise in the order of the file.
    pub(super) order: Vec<usize>,
    by_joint: HashMap<&'a str, usize>,
}

impl<'a> Tree<'a> {
    /// Reads all links and joints. `None` if they are no tree: that has been said.
    pub(super) fn read(root: &Element<'a>, options: &Options) -> Option<Self> {
        let (links, by_link) = links(root, options);
        let mut tree = Self { links, joints: Vec::new(), order: Vec::new(), by_joint: HashMap::new() };
        let mut fine = true;
        for element in root.children("joint") {
            let Some(name) = element.required("name") else {
                fine = false;
                continue;
            };
            let ends = ["parent", "child"].map(|end| tree.end(&element, end, &by_link));
            let [Some((parent, parent_place)), Some((child, child_place))] = ends else {
                fine = false;
                continue;
            };
            fine &= tree.add(name, element, (parent, parent_place), (child, child_place));
        }
        if tree.links.is_empty() {
            let message = format!("{} has no <link>", root.label());
            root.refuse(Problem::at(root.place(), message));
            return None;
        }
        (fine && root.log.is_fine() && tree.sort(root)).then_some(tree)
    }

    /// The joint of this name.
    pub(super) fn joint(&self, name: &str) -> Option<usize> {
        self.by_joint.get(name).copied()
    }

    /// The joint's name that is nearest to this one, or the only one that ends with it.
    pub(super) fn near(&self, name: &str, log: &Log) -> Option<&'a str> {
        let names = || self.joints.iter().map(|joint| joint.name);
        let mut longer = names().filter(|joint| !name.is_empty() && joint.ends_with(name));
        match (log.near(name, names()), longer.next(), longer.next()) {
            (Some(near), ..) => Some(near),
            (None, Some(only), None) => Some(only),
            _ => None,
        }
    }

    /// A name of the scenario that no link has: this one, with as many endings as it takes.
    pub(super) fn free(&self, name: String, ending: &str) -> String {
        free(&self.links, name, ending)
    }

    fn end(&self, joint: &Element<'a>, end: &str, by_link: &HashMap<&'a str, usize>) -> Option<(usize, Place)> {
        let Some(element) = joint.child(end) else {
            joint.refuse(Problem::at(joint.place(), format!("{}: <{end} link=\"…\"/> is missing", joint.label())));
            return None;
        };
        let link = element.required("link")?;
        let found = by_link.get(link.value).map(|index| (*index, link.place()));
        if found.is_none() {
            let near = joint.log.near(link.value, self.links.iter().map(|link| link.name));
            let help = near.map(|near| format!("did you mean `{near}`?"));
            let message = format!("{}: there is no link `{}`", joint.label(), link.value);
            joint.refuse(Problem::at(link.place(), message).maybe_help(help));
        }
        found
    }

    fn add(
        &mut self,
        name: Attribute<'a>,
        element: Element<'a>,
        parent: (usize, Place),
        child: (usize, Place),
    ) -> bool {
        let index = self.joints.len();
        if self.by_joint.insert(name.value, index).is_some() {
            let message = format!("there are two joints called `{}`", name.value);
            element.refuse(Problem::at(name.place(), message).help("a joint's name stands for it alone"));
            return false;
        }
        if parent.0 == child.0 {
            let message = format!("joint `{}` connects link `{}` with itself", name.value, self.links[child.0].name);
            element.refuse(Problem::at(child.1, message));
            return false;
        }
        if let Some(other) = self.links[child.0].joint {
            let message = format!(
                "link `{}` is the child of joint `{}` and of joint `{}`",
                self.links[child.0].name, self.joints[other].name, name.value
            );
            let help = "a URDF is a tree; close loops in the scenario, with a [[loop]]";
            element.refuse(Problem::at(child.1, message).help(help));
            return false;
        }
        self.links[child.0].joint = Some(index);
        let (parent, parent_place) = parent;
        self.joints.push(Joint { name: name.value, element, parent, child: child.0, parent_place, welded: false });
        true
    }

    /// Puts parents before children; false if there is no root, several, or a cycle: that has been said.
    fn sort(&mut self, root: &Element<'_>) -> bool {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); self.links.len()];
        for joint in &self.joints {
            children[joint.parent].push(joint.child);
        }
        let roots: Vec<usize> = (0..self.links.len()).filter(|link| self.links[*link].joint.is_none()).collect();
        if let [first, second, ..] = roots[..] {
            let link = &self.links[second];
            let message = format!(
                "{} links are not reached by any joint: `{}`, `{}`{}",
                roots.len(),
                self.links[first].name,
                link.name,
                if roots.len() > 2 { ", …" } else { "" }
            );
            let help = "a URDF has one root, on which everything hangs; a joint is missing";
            root.refuse(Problem::at(link.element.place(), message).help(help));
            return false;
        }
        let mut waiting: Vec<usize> = roots;
        while let Some(link) = waiting.pop() {
            self.order.push(link);
            // The first child comes next.
            waiting.extend(children[link].iter().rev());
        }
        if self.order.len() < self.links.len() {
            let mut reached = vec![false; self.links.len()];
            self.order.iter().for_each(|link| reached[*link] = true);
            self.refuse_cycle(reached.iter().position(|reached| !reached).unwrap_or(0));
            return false;
        }
        true
    }

    /// Says which links form a cycle of parents.
    fn refuse_cycle(&self, start: usize) {
        let above = |link: usize| self.links[link].joint.map(|joint| self.joints[joint].parent);
        // From any link without a way to the root, as many steps up as there are links end in the circle.
        let mut link = start;
        for _ in 0..self.links.len() {
            link = above(link).unwrap_or(link);
        }
        let first = link;
        let mut names = vec![self.links[first].name];
        let mut next = above(first).unwrap_or(first);
        while next != first {
            names.push(self.links[next].name);
            next = above(next).unwrap_or(first);
        }
        names.push(self.links[first].name);
        let shown: Vec<String> = names.iter().take(8).map(|name| format!("`{name}`")).collect();
        let more = if names.len() > shown.len() { ", child of …" } else { "" };
        let message = format!("the links form a cycle of parents: {}{more}", shown.join(", child of "));
        let Some(joint) = self.links[first].joint.map(|joint| &self.joints[joint]) else { return };
        let help = "a URDF is a tree; close loops in the scenario, with a [[loop]]";
        joint.element.refuse(Problem::at(joint.parent_place.clone(), message).help(help));
    }
}

fn links<'a>(root: &Element<'a>, options: &Options) -> (Vec<Link<'a>>, HashMap<&'a str, usize>) {
    let (mut links, mut by_name): (Vec<Link<'_>>, HashMap<&str, usize>) = (Vec::new(), HashMap::new());
    for element in root.children("link") {
        let Some(name) = element.required("name") else { continue };
        if name.value.is_empty() {
            element.refuse(name.wrong("is empty"));
        }
        if let Some(first) = by_name.insert(name.value, links.len()) {
            let first: &Link<'_> = &links[first];
            let message = format!("there are two links called `{}`", first.name);
            element.refuse(Problem::at(name.place(), message).help("a link's name stands for it alone"));
        }
        let body = format!("{}{}", options.prefix, name.value);
        links.push(Link { name: name.value, name_place: name.place(), body, element, joint: None });
    }
    if let Some(index) = links.iter().position(|link| link.body == GROUND) {
        links[index].body = free(&links, GROUND.to_owned(), "_link");
        let what = format!("it is called `{}` here: `{GROUND}` is what does not move", links[index].body);
        links[index].element.note(Taken::Used, what);
    }
    (links, by_name)
}

fn free(links: &[Link<'_>], mut name: String, ending: &str) -> String {
    while name == GROUND || links.iter().any(|link| link.body == name) {
        name += ending;
    }
    name
}
