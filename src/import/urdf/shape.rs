//! What a link looks like.

use super::joint::place;
use crate::import::draft::Entry;
use crate::import::log::{Place, Taken};
use crate::import::xml::{Attribute, Element};
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
                collision.note(Taken::Ignored, "contacts between bodies are not simulated");
            } else {
                shapes.extend(self.shape(&collision));
                let what = "for pictures: nothing is visible; contacts between bodies are not simulated";
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
                let size = solid.required("size")?;
                let edges = self.sized(&size, size.vector::<3>()?)?;
                shape.numbers("box", &edges, Some(size.place()));
            }
            "sphere" => {
                let radius = solid.required("radius")?;
                let [number] = self.sized(&radius, [radius.number()?])?;
                shape.set("sphere", number, Some(radius.place()));
            }
            round @ ("cylinder" | "capsule") => {
                let (radius, length) = (solid.required("radius")?, solid.required("length")?);
                let size = self.sized(&radius, [radius.number()?, length.number()?])?;
                shape.numbers(round, &size, Some(radius.place()));
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

    /// Sizes that can be drawn.
    fn sized<const N: usize>(&self, attribute: &Attribute<'_>, size: [f64; N]) -> Option<[f64; N]> {
        if size.iter().all(|number| *number > 0.0) {
            return Some(size);
        }
        let what = format!("it has no size ({}): it is not drawn", size.map(|n| n.to_string()).join(", "));
        attribute.element.note(Taken::Ignored, what);
        None
    }

    fn mesh(&self, mesh: &Element<'a>, shape: &mut Entry) -> Option<()> {
        let file = mesh.required("filename")?;
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
        if let Some(scale) = mesh.attribute("scale")
            && let Some(factors) = scale.vector::<3>().filter(|factors| *factors != [1.0; 3])
        {
            shape.numbers("scale", &factors, Some(scale.place()));
        }
        Some(())
    }
}

/// The colour that stands in a `<material>` itself.
fn own_color(material: &Element<'_>) -> Option<([f64; 4], Place)> {
    let rgba = material.child("color")?.required("rgba")?;
    let color = rgba.vector::<4>()?;
    if color.iter().all(|part| (0.0..=1.0).contains(part)) {
        return Some((color, rgba.place()));
    }
    rgba.element.note(Taken::Approximated, "the parts of a colour are 0 to 1: it is cut to that");
    Some((color.map(|part| part.clamp(0.0, 1.0)), rgba.place()))
}
