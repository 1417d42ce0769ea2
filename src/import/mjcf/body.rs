//! `<worldbody>` and everything in it: bodies, joints, geoms, sites, and the frames around them.

use super::super::log::{Problem, Taken};
use super::super::xml::Element;
use super::defaults::Settled;
use super::geom;
use super::joint;
use super::mass;
use super::model::{Instance, Model};
use super::pose;
use super::scene::{Body, Names, Scene, Site, WORLD};
use super::settings::FromGeoms;
use super::touch::Touch;
use crate::model::description::{GROUND, MassProperties};
use crate::model::problem::number;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// The most elements that `<replicate>` may make.
const MOST_COPIES: usize = 100_000;

/// What MuJoCo takes for no mass (kg) or no inertia (kg m²) of a body that moves: its `mjMINVAL`.
const LEAST: f64 = 1e-15;

/// More levels of elements than any model has, with what is attached.
const DEEPEST: usize = 300;

/// Reads the bodies of a model, by its place in the list, and of those that it attaches.
pub(super) fn read<'a>(models: &[Model<'a>], at: usize) -> Scene<'a> {
    let main = &models[at];
    let mut walk = Walk {
        models,
        at,
        scene: Scene {
            settings: main.settings.clone(),
            bodies: Vec::new(),
            joints: Vec::new(),
            sites: Vec::new(),
            geoms: Vec::new(),
            excluded: Vec::new(),
            pairs: Vec::new(),
            names: Names::default(),
            prefix: String::new(),
            instances: Vec::new(),
        },
        copies: 0,
        attached: 0,
        level: 0,
    };
    walk.add_body(main.tree.root, "world".to_owned(), WORLD, Isometry3::identity());
    let around =
        Around { body: WORLD, frame: Isometry3::identity(), class: None, suffix: String::new(), weighs: false };
    walk.world(&around, &mut Parts::default());
    let bodies = 0..walk.scene.bodies.len();
    walk.scene.instances.push(Instance { model: at, prefix: String::new(), bodies });
    walk.scene
}

pub(super) struct Walk<'w, 'a> {
    pub(super) models: &'w [Model<'a>],
    /// The model whose elements are being read.
    pub(super) at: usize,
    pub(super) scene: Scene<'a>,
    /// Elements that `<replicate>` and `<attach>` have made.
    copies: usize,
    /// How many `<attach>` are within each other.
    pub(super) attached: usize,
    /// How many elements.
    level: usize,
}

/// Where an element stands.
#[derive(Clone)]
pub(super) struct Around {
    pub(super) body: usize,
    /// From the body to what stands directly here.
    pub(super) frame: Isometry3<f64>,
    pub(super) class: Option<usize>,
    /// What `<replicate>` puts behind names.
    pub(super) suffix: String,
    /// Whether geoms make up the mass.
    pub(super) weighs: bool,
}

/// What a body weighs, in parts.
#[derive(Default)]
pub(super) struct Parts {
    inertial: Option<MassProperties>,
    /// Principal axes of `inertial`.
    axes: UnitQuaternion<f64>,
    geoms: Vec<MassProperties>,
    /// Principal axes of those geoms that have mass.
    turns: Vec<UnitQuaternion<f64>>,
    /// Why the mass of a geom is not known.
    unknown: Option<String>,
}

impl<'w, 'a> Walk<'w, 'a> {
    pub(super) fn model(&self) -> &'w Model<'a> {
        &self.models[self.at]
    }

    /// What stands in the world of the model that is being read.
    pub(super) fn world(&mut self, around: &Around, parts: &mut Parts) {
        let model = self.model();
        for world in model.tree.all(&model.tree.root, "worldbody") {
            let class = world.attribute("childclass").and_then(|class| model.defaults.class(&class));
            self.children(&world, &Around { class, ..around.clone() }, parts);
        }
    }

    fn add_body(&mut self, element: Element<'a>, name: String, parent: usize, pose: Isometry3<f64>) -> usize {
        let index = self.scene.bodies.len();
        if self.scene.names.bodies.insert(name.clone(), index).is_some() {
            let problem = Problem::at(element.place(), format!("two bodies are called `{name}`"));
            element.refuse(problem.help("names must be unique"));
        }
        self.scene.bodies.push(Body {
            element,
            name,
            parent,
            pose,
            joints: Vec::new(),
            mass: mass::NOTHING,
            principal: Isometry3::identity(),
            shapes: Vec::new(),
            gravity_compensation: 0.0,
        });
        index
    }

    pub(super) fn children(&mut self, element: &Element<'a>, around: &Around, parts: &mut Parts) {
        if self.level == DEEPEST {
            let message =
                format!("{}: with what is attached, elements are deeper than {DEEPEST} levels", element.label());
            let help = "what is attached must not attach itself";
            element.refuse(Problem::at(element.place(), message).help(help));
            return;
        }
        self.level += 1;
        self.each_child(element, around, parts);
        self.level -= 1;
    }

    fn each_child(&mut self, element: &Element<'a>, around: &Around, parts: &mut Parts) {
        for child in self.model().tree.children(element) {
            if !around.suffix.is_empty() || self.attached > 0 {
                self.copies += 1;
            }
            if self.copies > MOST_COPIES {
                if self.copies == MOST_COPIES + 1 {
                    let message =
                        format!("{}: <replicate> and <attach> make more than {MOST_COPIES} elements", child.label());
                    child.refuse(Problem::at(child.place(), message).help("count the nested ones"));
                }
                return;
            }
            match child.name() {
                "body" => self.body(&child, around),
                "frame" => {
                    let inner = self.frame(&child, around);
                    self.children(&child, &inner, parts);
                }
                "replicate" => self.replicate(&child, around, parts),
                "attach" => self.attach(&child, around, parts),
                "joint" | "freejoint" => self.joint(&child, around),
                "geom" => self.geom(&child, around, parts),
                "site" => self.site(&child, around),
                "inertial" if around.body != WORLD => {
                    let settled = Settled::bare(&child);
                    let found = mass::inertial(&settled, &self.scene.settings, &around.frame);
                    parts.inertial = found.map(|(mass, _)| mass);
                    parts.axes = found.map(|(_, axes)| axes).unwrap_or_default();
                }
                // Others are noted with everything else that nobody reads.
                _ => {}
            }
        }
    }

    pub(super) fn frame(&mut self, element: &Element<'a>, around: &Around) -> Around {
        let settled = Settled::bare(element);
        element.text("name");
        let class = element.attribute("childclass").and_then(|class| self.model().defaults.class(&class));
        Around {
            frame: around.frame * pose::pose(&settled, &self.scene.settings),
            class: class.or(around.class),
            ..around.clone()
        }
    }

    fn replicate(&mut self, element: &Element<'a>, around: &Around, parts: &mut Parts) {
        element.see();
        let Some(attribute) = element.required("count") else { return };
        let Some(count) = attribute.number() else { return };
        if !(count >= 1.0 && count.fract() == 0.0 && count <= MOST_COPIES as f64) {
            let problem = attribute.wrong(&format!("must be a whole number from 1 to {MOST_COPIES}, found {count}"));
            element.refuse(problem);
            return;
        }
        let offset = element.vector("offset").unwrap_or_default();
        let angles = Vector3::from(element.vector("euler").unwrap_or_default());
        let offset = Vector3::from(offset);
        let separator = element.text("sep").unwrap_or_default().to_owned();
        let digits = (count as usize).to_string().len();
        let mut at = Vector3::zeros();
        for copy in 0..count as usize {
            // Angles are multiplied, turns are not: so the compiler of MuJoCo has it.
            let turn = pose::euler(angles * copy as f64, &self.scene.settings);
            let inner = Around {
                frame: around.frame * Isometry3::from_parts(Translation3::from(at), turn),
                suffix: format!("{separator}{copy:0digits$}{}", around.suffix),
                ..around.clone()
            };
            self.children(element, &inner, parts);
            at += turn * offset;
        }
    }

    /// The name of an element here; copies have their numbers.
    fn name(&mut self, element: &Element<'a>, around: &Around) -> Option<String> {
        let name = element.text("name").filter(|name| !name.is_empty())?;
        let name = self.scene.full(name);
        if !around.suffix.is_empty() {
            self.scene.names.copied.push(name.clone());
        }
        Some(format!("{name}{}", around.suffix))
    }

    pub(super) fn body(&mut self, element: &Element<'a>, around: &Around) {
        let settled = Settled::bare(element);
        let number = self.scene.bodies.len();
        let given = self.name(element, around);
        let mut name = given.unwrap_or_else(|| format!("body_{number}"));
        if name == GROUND {
            name = format!("{GROUND}_body");
            element.note(Taken::Used, format!("it is called `{name}` here: `{GROUND}` is what does not move"));
        }
        let own = pose::pose(&settled, &self.scene.settings);
        let body = self.add_body(*element, name, around.body, around.frame * own);
        self.scene.bodies[body].gravity_compensation = settled.number("gravcomp").unwrap_or(0.0);
        if settled.flag("mocap") == Some(true) {
            element.note(Taken::Approximated, "a mocap body stays where it is: nothing moves it from outside");
        }
        let class = element.attribute("childclass").and_then(|class| self.model().defaults.class(&class));
        let given = self.model().tree.children(element).iter().any(|child| child.name() == "inertial");
        let inner = Around {
            body,
            frame: Isometry3::identity(),
            class: class.or(around.class),
            suffix: around.suffix.clone(),
            weighs: match self.scene.settings.inertia_from_geoms {
                FromGeoms::Always => true,
                FromGeoms::Auto => !given,
                FromGeoms::Never => false,
            },
        };
        let mut parts = Parts::default();
        // Joints, geoms and inertia first: a body's joints stand before those of the bodies in it.
        self.children(element, &inner, &mut parts);
        self.weigh(body, &parts, &own.translation.vector);
    }

    /// `place` is the body's `pos`, as it is written.
    fn weigh(&mut self, body: usize, parts: &Parts, place: &Vector3<f64>) {
        let settings = &self.scene.settings;
        let element = self.scene.bodies[body].element;
        let moves = !self.scene.bodies[body].joints.is_empty();
        let from_geoms = parts.inertial.is_none() || settings.inertia_from_geoms == FromGeoms::Always;
        if let Some(why) = parts.unknown.as_ref().filter(|_| from_geoms) {
            let message = format!("{}: its mass follows from a mesh, and that is not known: {why}", element.label());
            let help = "give the body an <inertial> (`mj_saveLastXML` writes one), or set it apart with mass=\"0\"";
            element.refuse(Problem::at(element.place(), message).help(help));
        }
        let given = mass::of_body(parts.inertial, &parts.geoms, settings);
        let axes = match parts.turns[..] {
            _ if parts.inertial == Some(given) => parts.axes,
            // One geom alone keeps its axes.
            [axes] => axes,
            _ => mass::principal(&given.inertia),
        };
        let mut bounded = mass::bounded(given, settings);
        if bounded != given && parts.inertial.is_none() && given == mass::NOTHING {
            // As MuJoCo does: the frame of inertia that nothing gives is a copy of the body's frame in its parent.
            bounded.center = *place;
        }
        if bounded != given {
            let moments = |mass: &MassProperties| number(mass.inertia.symmetric_eigenvalues().min());
            let what = format!(
                "`boundmass`, `boundinertia` or `balanceinertia` make {} kg of {} kg, and a smallest moment of {} kg m² of {}",
                number(bounded.mass),
                number(given.mass),
                moments(&bounded),
                moments(&given)
            );
            element.note(Taken::Used, what);
        }
        self.scene.bodies[body].principal = Isometry3::from_parts(bounded.center.into(), axes);
        self.scene.bodies[body].mass = bounded;
        let given_alone = self.scene.settings.inertia_from_geoms == FromGeoms::Never;
        if given_alone && parts.inertial.is_none() && moves && !self.weighs_with_welded(body) {
            let message = format!("{}: `<inertial>` is missing", element.label());
            let help = "the model asks for inertiafromgeom=\"false\": a body that moves needs its own, or one within it that has no joint does";
            element.refuse(Problem::at(element.place(), message).help(help));
        }
    }

    /// Whether a body, or one that is welded to it through bodies without joints, has mass and moments of inertia above what
    /// MuJoCo takes for 0. The bodies within it are read already.
    fn weighs_with_welded(&self, body: usize) -> bool {
        let weighs = |mass: &MassProperties| mass.mass.min(mass.inertia.symmetric_eigenvalues().min()) >= LEAST;
        let bodies = &self.scene.bodies;
        let mut welded = vec![true];
        for inner in &bodies[body + 1..] {
            let with = inner.parent.checked_sub(body).and_then(|at| welded.get(at)).is_some_and(|with| *with);
            welded.push(with && inner.joints.is_empty());
        }
        bodies[body..].iter().zip(welded).any(|(inner, with)| with && weighs(&inner.mass))
    }

    fn joint(&mut self, element: &Element<'a>, around: &Around) {
        let settled = match element.name() {
            "freejoint" => Settled::bare(element),
            _ => self.model().defaults.of(element, around.class),
        };
        let body = around.body;
        if body == WORLD {
            settled.refuse("the world has no joints", "joints belong within a <body>");
            return;
        }
        let index = self.scene.joints.len();
        let name = self.name(element, around);
        let named = name.is_some();
        let name = name.unwrap_or_else(|| format!("joint_{}", self.scene.bodies[body].joints.len()));
        let mut joint = joint::joint(&settled, &self.scene.settings, &around.frame, name.clone(), body);
        let others = &self.scene.bodies[body].joints;
        let alone = matches!(joint.kind, super::scene::Kind::Free);
        let free_already = others.iter().any(|other| self.scene.joints[*other].kind == super::scene::Kind::Free);
        if (alone && !others.is_empty()) || free_already {
            settled.refuse("a body with a free joint has no other joints", "put it into a body within this one");
            return;
        }
        if alone && self.scene.bodies[body].parent != WORLD {
            settled.refuse("only bodies of the world can have a free joint", "move the body to <worldbody>");
            return;
        }
        let wanted = match settled.element.text("align") {
            Some("true") => true,
            Some("false") => false,
            _ => self.scene.settings.align_free,
        };
        if alone && wanted {
            element
                .note(Taken::Used, "`align`: the body keeps its own axes; MuJoCo's qpos is that of the principal axes");
            joint.aligned = true;
        }
        if named && self.scene.names.joints.insert(name.clone(), index).is_some() {
            settled.refuse(&format!("two joints are called `{name}`"), "names must be unique");
        }
        self.scene.bodies[body].joints.push(index);
        self.scene.joints.push(joint);
    }

    fn geom(&mut self, element: &Element<'a>, around: &Around, parts: &mut Parts) {
        let settled = self.model().defaults.of(element, around.class);
        let contacts = self.scene.settings.contacts;
        let name = if contacts { self.name(element, around) } else { element.text("name").map(str::to_owned) };
        let Some(mut geom) =
            geom::geom(&settled, &self.scene.settings, &self.model().assets, &around.frame, around.weighs)
        else {
            return;
        };
        match geom.mass {
            Ok(mass) => {
                parts.turns.extend((mass.mass > 0.0).then_some(geom.axes));
                parts.geoms.push(mass);
            }
            Err(why) => parts.unknown = Some(why),
        }
        let shapes = &mut self.scene.bodies[around.body].shapes;
        if contacts {
            let at = geom.drawn.as_ref().map(|_| shapes.len());
            let Some(touch) = Touch::read(&settled, name.clone()) else { return };
            match (&geom.touching, &mut geom.drawn) {
                (Ok(()), Some(drawn)) => drawn.touch = Some(touch),
                (Err(why), _) if touch.is_willing() => {
                    element.note(Taken::Ignored, format!("it touches nothing: {why}"))
                }
                _ => {}
            }
            let index = self.scene.geoms.len();
            self.scene.geoms.push((around.body, at));
            if let Some(name) = name
                && self.scene.names.geoms.insert(name.clone(), index).is_some()
            {
                settled.refuse(&format!("two geoms are called `{name}`"), "names must be unique");
            }
        }
        shapes.extend(geom.drawn);
    }

    fn site(&mut self, element: &Element<'a>, around: &Around) {
        let settled = self.model().defaults.of(element, around.class);
        let name = self.name(element, around);
        let mut pose = around.frame * pose::pose(&settled, &self.scene.settings);
        if let Some([a, b, c, d, e, f]) = settled.vector("fromto") {
            let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
            let inner = Isometry3::from_parts(Translation3::from(0.5 * (from + to)), pose::from_z_to(&(from - to)));
            pose = around.frame * inner;
        }
        let index = self.scene.sites.len();
        if let Some(name) = &name
            && self.scene.names.sites.insert(name.clone(), index).is_some()
        {
            settled.refuse(&format!("two sites are called `{name}`"), "names must be unique");
        }
        self.scene.sites.push(Site { name, body: around.body, pose, place: element.place() });
    }
}
