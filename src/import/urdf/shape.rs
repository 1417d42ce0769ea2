//! What a link looks like.

use super::pose::place;
use crate::import::draft::Entry;
use crate::import::log::{Place, Taken};
use crate::import::xml::{Attribute, Element, cut};
use crate::import::{Options, files};
use std::collections::HashMap;
use std::path::Path;

/// The colours that a file gives names to, and where its meshes are found.
pub(super) struct Looks<'a> {
    materials: HashMap<&'a str, ([f64; 4], Place)>,
    path: &'a Path,
    options: &'a Options,
}

impl<'a> Looks<'a> {
    pub(super) fn read(root: &Element<'a>, path: &'a Path, options: &'a Options) -> Self {
        let mut looks = Self { materials: HashMap::new(), path, options };
        for material in root.children("material") {
            looks.define(&material);
        }
        // A colour that one visual names is there for all.
        for link in root.children("link") {
            for visual in link.children("visual") {
                visual.child("material").into_iter().for_each(|material| looks.define(&material));
            }
        }
        looks
    }

    fn define(&mut self, material: &Element<'a>) {
        let name = material.text("name").filter(|name| !name.is_empty());
        if let (Some(name), Some(color)) = (name, own_color(material)) {
            self.materials.entry(name).or_insert(color);
        }
    }

    /// The shapes of a link: what is visible, failing that what collides.
    pub(super) fn write(&self, link: &Element<'a>, body: &mut Entry) {
        let mut shapes: Vec<Entry> = link.children("visual").filter_map(|visual| self.shape(&visual)).collect();
        let visible = link.children("visual").next().is_some();
        for collision in link.children("collision") {
            collision.text("name");
            if visible {
                // What is in it is of no interest then.
                collision.see_all();
                collision
                    .note(Taken::Ignored, "contacts between bodies are not imported: describe them with `[[contact]]`");
            } else {
                shapes.extend(self.shape(&collision));
                let what = "for pictures: nothing is visible; contacts between bodies are not imported";
                collision.note(Taken::Approximated, what);
            }
        }
        body.lines("shape", shapes);
    }

    fn shape(&self, visual: &Element<'a>) -> Option<Entry> {
        visual.text("name");
        let geometry = visual.child("geometry")?;
        let solid = geometry.all_children().next();
        let Some(solid) = solid else {
            geometry.note(Taken::Ignored, "there is no solid in it");
            return None;
        };
        let mut shape = Entry::new(Some(solid.place()));
        self.solid(&solid, &mut shape)?;
        place(visual, &mut shape);
        if let Some(material) = visual.child("material") {
            let named = || self.materials.get(material.text("name")?).cloned();
            match own_color(&material).or_else(named) {
                Some((color, place)) => shape.numbers("color", &color, Some(place)),
                None => material.note(Taken::Ignored, "it has no colour"),
            }
        }
        Some(shape)
    }

    fn solid(&self, solid: &Element<'a>, shape: &mut Entry) -> Option<()> {
        match solid.name() {
            "box" => {
                let size = self.given(solid, "size")?;
                let edges = self.sized::<3>(&size)?;
                shape.numbers("box", &edges, Some(size.place()));
            }
            "sphere" => {
                let radius = self.given(solid, "radius")?;
                let [number] = self.sized(&radius)?;
                shape.set("sphere", number, Some(radius.place()));
            }
            round @ ("cylinder" | "capsule") => {
                let (radius, length) = (self.given(solid, "radius")?, self.given(solid, "length")?);
                let ([r], [l]) = (self.sized(&radius)?, self.sized(&length)?);
                shape.numbers(round, &[r, l], Some(radius.place()));
            }
            "mesh" => return self.mesh(solid, shape),
            other => {
                solid.note(Taken::Ignored, format!("a <{other}> is not drawn"));
                solid.see_all();
                return None;
            }
        }
        Some(())
    }

    /// A size; that it is missing is said.
    fn given(&self, solid: &Element<'a>, key: &str) -> Option<Attribute<'a>> {
        let found = solid.attribute(key);
        if found.is_none() {
            solid.note(Taken::Ignored, format!("`{key}` is missing: it is not drawn"));
        }
        found
    }

    /// Sizes that can be drawn.
    fn sized<const N: usize>(&self, attribute: &Attribute<'_>) -> Option<[f64; N]> {
        let size = drawn_numbers(attribute).filter(|size: &[f64; N]| size.iter().all(|number| *number > 0.0));
        if size.is_none() {
            let what = format!("it has no size (`{} = \"{}\"`): it is not drawn", attribute.key, cut(attribute.value));
            attribute.element.note(Taken::Ignored, what);
        }
        size
    }

    fn mesh(&self, mesh: &Element<'a>, shape: &mut Entry) -> Option<()> {
        let file = self.given(mesh, "filename")?;
        let Some(path) = files::find(file.value, self.path, self.options) else {
            let hint = match file.value.strip_prefix("package://").and_then(|rest| rest.split('/').next()) {
                Some(package) => {
                    format!("; say where the package is with `--package {package}=FOLDER` or ROS_PACKAGE_PATH")
                }
                None => String::new(),
            };
            mesh.note(Taken::Ignored, format!("no file `{}`: it is not drawn{hint}", file.value));
            mesh.see_all();
            return None;
        };
        let written = files::from_folder(&path, self.options.folder.as_deref(), self.path);
        shape.set("mesh", written, Some(file.place()));
        let Some(scale) = mesh.attribute("scale") else { return Some(()) };
        let Some(factors) = drawn_numbers::<3>(&scale).filter(|factors| factors.iter().all(|factor| *factor > 0.0))
        else {
            let what =
                format!("`scale = \"{}\"`: three positive numbers can be drawn; it is not drawn", cut(scale.value));
            mesh.note(Taken::Ignored, what);
            return None;
        };
        if factors != [1.0; 3] {
            shape.numbers("scale", &factors, Some(scale.place()));
        }
        Some(())
    }
}

/// Finite numbers of what is there for pictures: where they make no sense nothing is drawn, and the physics goes on.
fn drawn_numbers<const N: usize>(attribute: &Attribute<'_>) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = attribute.value.split_whitespace().map(|word| word.parse().ok()).collect();
    <[f64; N]>::try_from(numbers?).ok().filter(|numbers| numbers.iter().all(|number| number.is_finite()))
}

/// The colour that stands in a `<material>` itself.
fn own_color(material: &Element<'_>) -> Option<([f64; 4], Place)> {
    let rgba = material.child("color")?.attribute("rgba")?;
    let Some(color) = drawn_numbers::<4>(&rgba) else {
        let what = format!("`rgba = \"{}\"`: a colour is four numbers", cut(rgba.value));
        rgba.element.note(Taken::Ignored, what);
        return None;
    };
    if color.iter().all(|part| (0.0..=1.0).contains(part)) {
        return Some((color, rgba.place()));
    }
    rgba.element.note(Taken::Approximated, "the parts of a colour are 0 to 1: it is cut to that");
    Some((color.map(|part| part.clamp(0.0, 1.0)), rgba.place()))
}
