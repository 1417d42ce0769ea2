//! What a link looks like.

use super::pose::place;
use crate::import::draft::Entry;
use crate::import::log::{Place, Taken};
use crate::import::xml::{Attribute, Element, cut};
use crate::import::{Options, files};
use crate::mesh::Mesh;
use std::collections::HashMap;
use std::path::Path;

/// What becomes of a solid that is not understood: of a visible one, and of one that collides.
const DRAWN: &str = "is not drawn";
const TOUCHES: &str = "touches nothing";

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

    /// The shapes of a link: what is visible, failing that what collides. Returns how many of them can touch.
    pub(super) fn write(&self, link: &Element<'a>, body: &mut Entry) -> usize {
        let mut shapes: Vec<Entry> = link.children("visual").filter_map(|visual| self.shape(&visual, DRAWN)).collect();
        let visible = link.children("visual").next().is_some();
        let contact = self.options.contact;
        if contact {
            shapes.iter_mut().for_each(|shape| shape.set("contact", false, None));
        }
        let seen = shapes.len();
        for collision in link.children("collision") {
            collision.text("name");
            if contact {
                let mut shape = self.touching(&collision);
                if let Some(shape) = shape.as_mut().filter(|_| visible) {
                    shape.set("visible", false, None);
                }
                shapes.extend(shape);
            } else if visible {
                // What is in it is of no interest then.
                collision.see_all();
                collision.note(Taken::Ignored, "it touches nothing without `[model] contact = true`");
            } else {
                shapes.extend(self.shape(&collision, DRAWN));
                let what = "for pictures: nothing is visible; it touches nothing without `[model] contact = true`";
                collision.note(Taken::Approximated, what);
            }
        }
        let touching = if contact { shapes.len() - seen } else { 0 };
        body.lines("shape", shapes);
        touching
    }

    /// The shape of a `<collision>` that can touch.
    fn touching(&self, collision: &Element<'a>) -> Option<Entry> {
        let mut shape = self.shape(collision, TOUCHES)?;
        let solid = collision.child("geometry")?.all_children().next()?;
        if solid.name() == "mesh" {
            let file = solid.attribute("filename")?;
            let path = files::find(file.value, self.path, self.options)?;
            let scale = solid.attribute("scale").and_then(|scale| drawn_numbers::<3>(&scale)).unwrap_or([1.0; 3]);
            if let Err(why) = hull_of(&path, scale) {
                solid.note(Taken::Ignored, format!("it {TOUCHES}: {why}"));
                return None;
            }
            solid.note(Taken::Used, "its convex hull touches");
            shape.set("hull", true, None);
        }
        Some(shape)
    }

    /// The solid of a `<visual>` or `<collision>`; `lost` says what becomes of one that is not understood.
    fn shape(&self, visual: &Element<'a>, lost: &str) -> Option<Entry> {
        visual.text("name");
        let geometry = visual.child("geometry")?;
        let solid = geometry.all_children().next();
        let Some(solid) = solid else {
            geometry.note(Taken::Ignored, "there is no solid in it");
            return None;
        };
        let mut shape = Entry::new(Some(solid.place()));
        self.solid(&solid, &mut shape, lost)?;
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

    fn solid(&self, solid: &Element<'a>, shape: &mut Entry, lost: &str) -> Option<()> {
        match solid.name() {
            "box" => {
                let size = self.given(solid, "size", lost)?;
                let edges = self.sized::<3>(&size, lost)?;
                shape.numbers("box", &edges, Some(size.place()));
            }
            "sphere" => {
                let radius = self.given(solid, "radius", lost)?;
                let [number] = self.sized(&radius, lost)?;
                shape.set("sphere", number, Some(radius.place()));
            }
            round @ ("cylinder" | "capsule") => {
                let (radius, length) = (self.given(solid, "radius", lost)?, self.given(solid, "length", lost)?);
                let ([r], [l]) = (self.sized(&radius, lost)?, self.sized(&length, lost)?);
                shape.numbers(round, &[r, l], Some(radius.place()));
            }
            "mesh" => return self.mesh(solid, shape, lost),
            other => {
                solid.note(Taken::Ignored, format!("a <{other}> {lost}"));
                solid.see_all();
                return None;
            }
        }
        Some(())
    }

    /// A size; that it is missing is said.
    fn given(&self, solid: &Element<'a>, key: &str, lost: &str) -> Option<Attribute<'a>> {
        let found = solid.attribute(key);
        if found.is_none() {
            solid.note(Taken::Ignored, format!("`{key}` is missing: it {lost}"));
        }
        found
    }

    /// Sizes that can be drawn.
    fn sized<const N: usize>(&self, attribute: &Attribute<'_>, lost: &str) -> Option<[f64; N]> {
        let size = drawn_numbers(attribute).filter(|size: &[f64; N]| size.iter().all(|number| *number > 0.0));
        if size.is_none() {
            let what = format!("it has no size (`{} = \"{}\"`): it {lost}", attribute.key, cut(attribute.value));
            attribute.element.note(Taken::Ignored, what);
        }
        size
    }

    fn mesh(&self, mesh: &Element<'a>, shape: &mut Entry, lost: &str) -> Option<()> {
        let file = self.given(mesh, "filename", lost)?;
        let Some(path) = files::find(file.value, self.path, self.options) else {
            let hint = match file.value.strip_prefix("package://").and_then(|rest| rest.split('/').next()) {
                Some(package) => {
                    format!("; say where the package is with `--package {package}=FOLDER` or ROS_PACKAGE_PATH")
                }
                None => String::new(),
            };
            mesh.note(Taken::Ignored, format!("no file `{}`: it {lost}{hint}", file.value));
            mesh.see_all();
            return None;
        };
        let written = files::from_folder(&path, self.options.folder.as_deref(), self.path);
        shape.set("mesh", written, Some(file.place()));
        let Some(scale) = mesh.attribute("scale") else { return Some(()) };
        let Some(factors) = drawn_numbers::<3>(&scale).filter(|factors| factors.iter().all(|factor| *factor > 0.0))
        else {
            let what = format!("`scale = \"{}\"`: three positive numbers are understood; it {lost}", cut(scale.value));
            mesh.note(Taken::Ignored, what);
            return None;
        };
        if factors != [1.0; 3] {
            shape.numbers("scale", &factors, Some(scale.place()));
        }
        Some(())
    }
}

/// Whether the convex hull of a mesh can be found.
fn hull_of(file: &Path, scale: [f64; 3]) -> Result<(), String> {
    let mesh = Mesh::read(file).map_err(|error| error.to_string())?;
    mesh.convex_parts(scale.into(), true).map(|_| ()).map_err(|error| error.to_string())
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
