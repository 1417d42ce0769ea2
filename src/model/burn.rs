//! Bodies whose mass burns away: mass, centre of mass and inertia by a table over time.
//!
//! What leaves has the velocity of the body where it leaves it: the equations of motion are those of the rigid body that is
//! there, and thrust is a load. What leaves takes its energy along; with dots for rates of the table,
//!
//! ```text
//! (1) J = R I Rᵀ + m (c² 1 − c cᵀ),   J̇ = R İ Rᵀ + ṁ (c² 1 − c cᵀ) + m (2 c·ċ 1 − ċ cᵀ − c ċᵀ),   (m c)˙ = ṁ c + m ċ
//! (2) P = −½ ṁ v² − v·(ω × (m c)˙) − ½ ωᵀ J̇ ω + g·(ṁ r + (m c)˙)
//! ```

use super::description::{Description, MassProperties};
use super::problem::{Element, Problem, number};
use super::tree::weld;
use super::{Link, Model};
use crate::force::timeline::{Between, Timeline};
use crate::round_off::FORMULA;
use crate::spatial::link::LinkMotion;
use crate::spatial::{Principal, Sym3};
use nalgebra::{Matrix3, Vector3};

/// A body whose mass burns away.
#[derive(Debug, Clone, PartialEq)]
pub struct BurnDescription {
    /// The body; what it has itself is what the table has at t = 0.
    pub body: String,
    /// (s)
    pub timeline: Timeline,
    /// What the body has at those times.
    pub rows: Vec<MassProperties>,
}

/// A mass that burns away, compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Burn {
    /// Index of the body.
    pub body: usize,
    /// (s)
    pub timeline: Timeline,
    /// What the body has at those times.
    rows: Vec<MassProperties>,
    /// All bodies of its link.
    members: Vec<usize>,
}

impl BurnDescription {
    /// What the body has at a time (s).
    pub fn at(&self, time: f64) -> MassProperties {
        mixed(&self.rows, &self.timeline.at(time))
    }
}

fn mixed(rows: &[MassProperties], at: &Between) -> MassProperties {
    let (a, b, x) = (&rows[at.before], &rows[at.after], at.part);
    MassProperties {
        mass: a.mass + x * (b.mass - a.mass),
        center: a.center + x * (b.center - a.center),
        inertia: a.inertia + x * (b.inertia - a.inertia),
    }
}

/// The problems of all tables; those of single rows are the caller's, who is told which.
pub(super) fn check(description: &Description, row: &mut dyn FnMut(usize, &MassProperties)) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (at, burn) in description.burns.iter().enumerate() {
        let Some(index) = description.bodies.iter().position(|body| body.name == burn.body) else {
            let message = format!("there is no body `{}` to burn", burn.body);
            problems.push(Problem { element: Element::Scene, field: "body".to_owned(), message, help: None });
            continue;
        };
        let mut add = |field: &str, message: String, help: &str| {
            let (element, help) = (Element::Body(index), Some(help.to_owned()));
            problems.push(Problem { element, field: field.to_owned(), message, help });
        };
        if let Some(flaw) = burn.timeline.flaw(burn.rows.len()) {
            let help = "times must not decrease; given twice, the numbers jump there";
            add("burn.times", format!("the burn of `{}` {flaw}", burn.body), help);
            continue;
        }
        if let Some(bad) = burn.rows.iter().position(|row| !(row.mass > 0.0)) {
            let (mass, time) = (number(burn.rows[bad].mass), number(burn.timeline.times[bad]));
            add("burn.mass", format!("at t = {time} s the mass of `{}` is {mass} kg", burn.body), "allowed: > 0 kg");
        }
        let grows = |pair: &[MassProperties]| pair[1].mass > FORMULA.above(pair[0].mass);
        if let Some(k) = burn.rows.windows(2).position(grows) {
            let [before, after] = [k, k + 1].map(|k| (number(burn.rows[k].mass), number(burn.timeline.times[k])));
            let message = format!(
                "the mass of `{}` grows from {} kg at t = {} s to {} kg at t = {} s",
                burn.body, before.0, before.1, after.0, after.1
            );
            let help = "what burns becomes less: masses must not grow. What a body takes up has a velocity of its own: let another \
                        body join it by a `[[stage]]` with `close`";
            add(&format!("burn.mass[{}]", k + 1), message, help);
        }
        if description.burns[..at].iter().any(|other| other.body == burn.body) {
            add("burn", format!("`{}` burns twice", burn.body), "one table for a body");
        }
        if burn.at(0.0) != description.bodies[index].mass {
            let message = format!("`{}` has another mass than its burn at t = 0", burn.body);
            add("burn", message, "leave out `mass`, `center` and `inertia`, or give what the table has at t = 0");
        }
        burn.rows.iter().for_each(|properties| row(index, properties));
    }
    problems
}

/// The tables of a scene without problems.
pub(super) fn compile(description: &Description, model: &mut Model) {
    let of = |burn: &BurnDescription| {
        let body = model.body(&burn.body)?;
        let link = model.bodies[body].link;
        let members = (0..model.bodies.len()).filter(|other| model.bodies[*other].link == link).collect();
        Some(Burn { body, timeline: burn.timeline.clone(), rows: burn.rows.clone(), members })
    };
    model.burns = description.burns.iter().filter_map(of).collect();
}

impl Model {
    /// Gives all bodies that burn the mass that they have at a time (s); `changed` gets their links.
    pub(crate) fn burn(&mut self, time: f64, mut changed: impl FnMut(usize, &Link)) {
        for burn in &self.burns {
            self.bodies[burn.body].mass = mixed(&burn.rows, &burn.timeline.at(time));
            let index = self.bodies[burn.body].link;
            let link = &mut self.links[index];
            (link.mass, link.center, link.inertia) = (0.0, Vector3::zeros(), Sym3::ZERO);
            for body in burn.members.iter().map(|member| &self.bodies[*member]) {
                weld(link, &body.mass, &body.link_from_body);
            }
            link.principal = Principal::of(&link.inertia);
            changed(index, link);
        }
    }

    /// Power that leaving mass takes along at a time (s), eq. (2).
    pub(crate) fn burnt(&self, time: f64, links: &[LinkMotion]) -> f64 {
        self.burns.iter().map(|burn| self.burnt_of(burn, time, links)).sum()
    }

    fn burnt_of(&self, burn: &Burn, time: f64, links: &[LinkMotion]) -> f64 {
        let at = burn.timeline.at(time);
        let (before, after, now) = (&burn.rows[at.before], &burn.rows[at.after], mixed(&burn.rows, &at));
        let mass = at.rate * (after.mass - before.mass);
        let body = &self.bodies[burn.body];
        let link = &links[body.link];
        let turn = link.turn * body.link_from_body.rotation.to_rotation_matrix().matrix();
        let c = link.turn * body.link_from_body.translation.vector + turn * now.center;
        let c_rate = turn * (at.rate * (after.center - before.center));
        let inertia = turn * (at.rate * (after.inertia - before.inertia)) * turn.transpose();
        let (v, w) = (link.velocity, link.angular_velocity);
        let moment = mass * c + now.mass * c_rate;
        let both = c * c_rate.transpose();
        let steiner = mass * (Matrix3::from_diagonal_element(c.norm_squared()) - c * c.transpose())
            + now.mass * (Matrix3::from_diagonal_element(2.0 * c.dot(&c_rate)) - both - both.transpose());
        let kinetic =
            0.5 * mass * v.norm_squared() + v.dot(&w.cross(&moment)) + 0.5 * w.dot(&((inertia + steiner) * w));
        -(kinetic - self.gravity.dot(&(mass * link.position + moment)))
    }
}
