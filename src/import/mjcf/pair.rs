//! `<contact>`: geoms that touch whatever else is said, and bodies that do not.

use super::super::log::Taken;
use super::defaults::{Defaults, Settled};
use super::scene::{Scene, WORLD, find};
use super::touch::{Pair, dimension, refuse_negative};
use super::tree::Tree;

/// Reads what `<contact>` says in an instance of a model.
pub(super) fn read<'a>(tree: &Tree<'a>, defaults: &Defaults<'a>, scene: &mut Scene<'a>) {
    for element in tree.section("contact") {
        match element.name() {
            "exclude" => {
                let settled = Settled::bare(&element);
                element.text("name");
                let body = |key| find(&settled.element.required(key)?, "body", &scene.names.bodies, scene);
                if let (Some(one), Some(other)) = (body("body1"), body("body2")) {
                    scene.excluded.push([one, other]);
                }
            }
            "pair" => {
                let settled = defaults.of(&element, None);
                let read = pair(&settled, scene);
                scene.pairs.extend(read);
            }
            _ => {}
        }
    }
}

fn pair(settled: &Settled<'_>, scene: &Scene<'_>) -> Option<Pair> {
    let element = settled.element;
    let name = element.text("name").map(str::to_owned);
    let geom = |key| find(&element.required(key)?, "geom", &scene.names.geoms, scene);
    let geoms = [geom("geom1")?, geom("geom2")?];
    let dimension = dimension(settled)?.unwrap_or(3);
    let mut along = [1.0; 2];
    if settled.attribute("friction").is_some() {
        let numbers = settled.numbers("friction", 5)?;
        along.iter_mut().zip(&numbers).for_each(|(own, given)| *own = *given);
    }
    let friction = along[0].min(along[1]);
    refuse_negative(settled, friction)?;
    if along[0] != along[1] && dimension > 1 {
        let what = "its friction depends on the direction: the smaller coefficient counts in all of them";
        element.note(Taken::Approximated, what);
    }
    for geom in geoms {
        let (body, shape) = scene.geoms[geom];
        let touches = shape.is_some_and(|shape| scene.bodies[body].shapes[shape].touch.is_some());
        if !touches {
            element.note(Taken::Ignored, "one of its geoms touches nothing here");
            return None;
        }
    }
    let carrier = |geom: usize| {
        let mut body = scene.geoms[geom].0;
        while body != WORLD && scene.bodies[body].joints.is_empty() {
            body = scene.bodies[body].parent;
        }
        body
    };
    if carrier(geoms[0]) == carrier(geoms[1]) {
        element.note(Taken::Ignored, "its geoms do not move against each other");
        return None;
    }
    Some(Pair::new(geoms, name, dimension, friction))
}
