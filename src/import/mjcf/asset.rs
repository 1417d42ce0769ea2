//! `<asset>`: meshes, and materials for their colours.

use super::super::log::Taken;
use super::super::xml::Element;
use super::super::{Options, files};
use super::defaults::{Defaults, Settled};
use super::settings::{Settings, choice};
use super::tree::Tree;
use super::weigh::{Rule, Surface, Weight};
use crate::mesh;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A mesh as `<asset>` declares it.
#[derive(Debug)]
pub(super) struct Mesh {
    /// File as found from the scenario's folder, where it can be drawn.
    pub(super) file: Option<String>,
    pub(super) placing: Placing,
    source: Source,
    rule: Rule,
    /// Reckoned where it is asked for, once.
    weight: OnceCell<Result<Weight, String>>,
    /// Whether its convex hull can be found, looked for once.
    hull: OnceCell<Result<(), String>>,
}

/// What geoms refer to.
#[derive(Default)]
pub(super) struct Assets {
    pub(super) meshes: HashMap<String, Mesh>,
    pub(super) colors: HashMap<String, [f64; 4]>,
}

/// Where files are found, and from where they are named.
pub(super) struct Folders<'o> {
    pub(super) model: &'o Path,
    pub(super) options: &'o Options,
}

pub(super) fn read<'a>(tree: &Tree<'a>, defaults: &Defaults<'a>, settings: &Settings, folders: &Folders<'_>) -> Assets {
    let mut assets = Assets::default();
    for element in tree.section("asset") {
        match element.name() {
            "mesh" => {
                let settled = defaults.of(&element, None);
                if let Some((name, mesh)) = mesh(&settled, settings, folders) {
                    assets.meshes.insert(name, mesh);
                }
            }
            "material" => {
                let settled = defaults.of(&element, None);
                if let (Some(name), Some(color)) = (element.text("name"), settled.vector::<4>("rgba")) {
                    assets.colors.insert(name.to_owned(), color.map(|part| part.clamp(0.0, 1.0)));
                }
            }
            _ => {}
        }
    }
    assets
}

/// The last part of a file's path, whichever way it leans.
fn base(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

fn mesh(settled: &Settled<'_>, settings: &Settings, folders: &Folders<'_>) -> Option<(String, Mesh)> {
    let element: Element<'_> = settled.element;
    let file = settled.text("file");
    let stem = || file.map(|file| base(file).rsplit_once('.').map_or(base(file), |(stem, _)| stem).to_owned());
    let name = element.text("name").map(str::to_owned).or_else(stem)?;
    let scale = settled.vector("scale").unwrap_or([1.0; 3]);
    let path = file.and_then(|file| {
        let within = settings.mesh_folder.join(if settings.strip_path { base(file) } else { file });
        let path = folders.model.parent().unwrap_or(Path::new("")).join(within);
        let found = path.is_file();
        if !found {
            element.note(Taken::Ignored, format!("no file `{}`: it is not drawn", path.display()));
        }
        found.then_some(path)
    });
    let drawable = scale.iter().all(|factor| *factor > 0.0);
    if file.is_none() {
        element.note(Taken::Ignored, "its corners are in the model itself: it is not drawn");
    } else if !drawable {
        element.note(Taken::Ignored, "`scale` mirrors it: it is not drawn");
    }
    let drawn = path.as_ref().filter(|_| drawable);
    let file = drawn.map(|path| files::from_folder(path, folders.options.folder.as_deref(), folders.model));
    let placing = Placing::read(settled, scale);
    if file.is_some() && !placing.is_drawn_exactly() {
        element.note(Taken::Approximated, "`refquat` with unequal `scale`: it is drawn scaled along its old axes");
    }
    let rule = settled.attribute("inertia").and_then(|at| choice(&at, &["convex", "exact", "legacy", "shell"]));
    let rule = [Rule::Convex, Rule::Exact, Rule::Legacy, Rule::Shell][rule.unwrap_or(2)];
    let (most, hull) = (settled.number("maxhullvert").filter(|most| *most >= 0.0), rule == Rule::Convex);
    let source = Source { path, own: own(settled), most_of_hull: most.filter(|_| hull) };
    Some((name, Mesh { file, placing, source, rule, weight: OnceCell::new(), hull: OnceCell::new() }))
}

/// The corners and triangles that the model has itself, as 32-bit numbers, which MuJoCo keeps.
fn own(settled: &Settled<'_>) -> Option<Own> {
    let corners = settled.attribute("vertex")?.numbers()?;
    let faces = settled.attribute("face").and_then(|face| face.numbers()).unwrap_or_default();
    let corners = corners.as_chunks::<3>().0.iter().map(|at| at.map(|x| x as f32)).collect();
    let faces = faces.as_chunks::<3>().0.iter().map(|face| face.map(|corner| corner as usize)).collect();
    Some((corners, faces))
}

/// `refpos`, `refquat` and `scale`: p = S Rᵀ (v − r) for a corner v of the file.
#[derive(Debug, Clone)]
pub(super) struct Placing {
    at: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    pub(super) scale: [f64; 3],
}

impl Placing {
    fn read(settled: &Settled<'_>, scale: [f64; 3]) -> Self {
        let at = settled.vector("refpos").map_or_else(Vector3::zeros, Vector3::from);
        let turn = settled.vector("refquat").map_or_else(UnitQuaternion::identity, |[w, x, y, z]: [f64; 4]| {
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
        });
        Self { at, turn, scale }
    }

    /// Whether a pose and a scale along the file's axes are the same.
    fn is_drawn_exactly(&self) -> bool {
        self.turn.angle() == 0.0 || self.scale == [self.scale[0]; 3]
    }

    /// Where the scaled mesh is drawn in the axes of the geom.
    pub(super) fn pose(&self) -> Isometry3<f64> {
        let moved = Translation3::from(self.at.component_mul(&Vector3::from(self.scale)));
        (moved * self.turn).inverse()
    }

    fn place(&self, corner: [f32; 3]) -> Vector3<f64> {
        let from = Vector3::from(corner).cast::<f64>() - self.at;
        (self.turn.inverse() * from).component_mul(&Vector3::from(self.scale))
    }
}

/// Corners, and triangles by their corners.
type Own = (Vec<[f32; 3]>, Vec<[usize; 3]>);

/// Where corners and triangles come from.
#[derive(Debug, Clone)]
pub(super) struct Source {
    path: Option<PathBuf>,
    own: Option<Own>,
    /// `maxhullvert`, where it changes what the mesh weighs.
    most_of_hull: Option<f64>,
}

impl Mesh {
    /// What it weighs with a density of one.
    ///
    /// # Errors
    /// Why that cannot be told.
    pub(super) fn weight(&self) -> Result<&Weight, &str> {
        self.weight.get_or_init(|| self.weigh()).as_ref().map_err(String::as_str)
    }

    /// Whether it can touch with its convex hull.
    ///
    /// # Errors
    /// Why it cannot.
    pub(super) fn hull(&self) -> Result<(), &str> {
        let find = || {
            let path = self.source.path.as_ref().filter(|_| self.file.is_some());
            let path = path.ok_or("it is not drawn from a file, and touches nothing then")?;
            let mesh = mesh::Mesh::read(path).map_err(|error| error.to_string())?;
            let found = mesh.convex_parts(Vector3::from(self.placing.scale), true);
            found.map(|_| ()).map_err(|error| error.to_string())
        };
        self.hull.get_or_init(find).as_ref().copied().map_err(String::as_str)
    }

    fn weigh(&self) -> Result<Weight, String> {
        if let Some(most) = self.source.most_of_hull {
            return Err(format!("`maxhullvert = {most}` leaves out corners of its hull, which ones is not known here"));
        }
        let (whole, scale) = (self.read()?, Vector3::from(self.placing.scale));
        let closed = whole.solid(scale).map(|solid| solid.volume);
        let turned = scale.product() < 0.0;
        let triangle = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|corner| corner as usize);
            if turned { [a, c, b] } else { [a, b, c] }
        };
        let corners = whole.vertices.iter().map(|at| self.placing.place(*at)).collect();
        let triangles = whole.triangles.iter().copied().map(triangle).collect();
        Surface { corners, triangles }.weigh(self.rule, &closed)
    }

    fn read(&self) -> Result<mesh::Mesh, String> {
        if let Some(path) = &self.source.path {
            return mesh::Mesh::read(path).map_err(|error| error.to_string());
        }
        let (corners, faces) =
            self.source.own.as_ref().ok_or("it has neither a file nor corners that are read here")?;
        if let Some(corner) = faces.iter().flatten().find(|corner| **corner >= corners.len()) {
            return Err(format!("a face names corner {corner}, there are {}", corners.len()));
        }
        let triangles = faces.iter().map(|face| face.map(|corner| corner as u32)).collect();
        Ok(mesh::Mesh { vertices: corners.clone(), triangles, normals: None, colors: None })
    }
}
