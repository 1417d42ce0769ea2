//! What acts in the systems of an ensemble: hinge forces, and wrenches of force elements.

use super::{LaneSystems, Numbers};
use crate::dynamics::applied;
use crate::force::lanes::{LoadLanes, SpringLanes};
use crate::force::{Act, Law};
use crate::model::{Link, Model};
use crate::motion::LinkMotion;
use crate::spatial::Wrench;
use crate::spatial::lanes::{LaneWrench, Lanes, LinkLanes, WIDTH, all, each, each_vector, less, sum};
use std::sync::Arc;

/// The forces of all systems.
#[derive(Debug, Clone)]
pub(super) struct Acting {
    /// Of every velocity coordinate: constant force (N, N m) and damping.
    given: Vec<[Lanes; 2]>,
    springs: Vec<HingeSpring>,
    /// Links whose balls have springs.
    balls: Vec<usize>,
    /// Whether motors or tables push coordinates.
    pushed: bool,
    between: Vec<SpringLanes>,
    loads: Vec<LoadLanes>,
    /// Force elements of other kinds, by their index: each system's law is asked by itself.
    others: Vec<usize>,
    /// The links that those act on.
    ends: Vec<usize>,
    links: Vec<LinkMotion>,
    /// Wrenches on the links at their root markers; empty if no force element is there.
    pub(super) applied: Vec<LaneWrench>,
    pub(super) tau: Vec<Lanes>,
}

/// A spring in a coordinate that is an angle or a distance.
#[derive(Debug, Clone)]
struct HingeSpring {
    position: usize,
    velocity: usize,
    stiffness: Lanes,
    rest: Lanes,
}

impl Acting {
    /// `None` if not the same kinds of forces act on the same links.
    pub(super) fn new(models: &[Arc<Model>; WIDTH]) -> Option<Self> {
        let first = &models[0];
        let pushes = |model: &Model| (model.motors.len(), model.curves.len());
        if models.iter().any(|model| model.forces.len() != first.forces.len() || pushes(model) != pushes(first)) {
            return None;
        }
        let coordinate = |lane: usize, at: usize| &models[lane].coordinates[at];
        let given = |at: usize| [each(|lane| coordinate(lane, at).force), each(|lane| coordinate(lane, at).damping)];
        let has_spring = |link: &Link| {
            let coordinates = link.velocity..link.velocity + link.joint.counts().1;
            coordinates.clone().any(|at| (0..WIDTH).any(|lane| coordinate(lane, at).stiffness != 0.0))
        };
        let spring = |link: &Link| HingeSpring {
            position: link.position,
            velocity: link.velocity,
            stiffness: each(|lane| coordinate(lane, link.velocity).stiffness),
            rest: each(|lane| coordinate(lane, link.velocity).rest),
        };
        let links = || first.links.iter().enumerate().filter(|(_, link)| has_spring(link));
        let mut acting = Self {
            given: (0..first.velocity_count()).map(given).collect(),
            springs: links().filter(|(_, link)| link.joint.is_scalar()).map(|(_, link)| spring(link)).collect(),
            balls: links().filter(|(_, link)| link.joint.is_ball()).map(|(index, _)| index).collect(),
            pushed: first.pushed().next().is_some(),
            between: Vec::new(),
            loads: Vec::new(),
            others: Vec::new(),
            ends: Vec::new(),
            links: Vec::new(),
            applied: vec![LaneWrench::default(); if first.forces.is_empty() { 0 } else { first.links.len() }],
            tau: vec![all(0.0); first.velocity_count()],
        };
        (0..first.forces.len()).try_for_each(|index| acting.take(models, index))?;
        if !acting.others.is_empty() {
            acting.ends.sort_unstable();
            acting.ends.dedup();
            acting.links = vec![LinkMotion::GROUND; first.links.len()];
        }
        Some(acting)
    }

    /// Takes a force element in.
    fn take(&mut self, models: &[Arc<Model>; WIDTH], index: usize) -> Option<()> {
        let laws = models.each_ref().map(|model| &model.forces[index].law);
        let springs = laws.map(|law| if let Law::Spring(law) = law { Some(law) } else { None });
        if let [Some(_), ..] = springs {
            let springs: Vec<_> = springs.into_iter().collect::<Option<_>>()?;
            self.between.push(SpringLanes::of(std::array::from_fn(|lane| springs[lane]))?);
            return Some(());
        }
        let loads = laws.map(|law| if let Law::Load(law) = law { Some(law) } else { None });
        if let [Some(_), ..] = loads {
            let loads: Vec<_> = loads.into_iter().collect::<Option<_>>()?;
            self.loads.push(LoadLanes::of(std::array::from_fn(|lane| loads[lane]))?);
            return Some(());
        }
        let links = |law: &Law| law.ends().iter().map(|end| end.link).collect::<Vec<_>>();
        let same = |law: &&Law| {
            std::mem::discriminant(*law) == std::mem::discriminant(laws[0]) && links(law) == links(laws[0])
        };
        if !laws.iter().all(same) {
            return None;
        }
        self.ends.extend(links(laws[0]).into_iter().filter(|link| *link != 0));
        self.others.push(index);
        Some(())
    }

    /// Whether force elements ask where the links are.
    pub(super) fn has_elements(&self) -> bool {
        !self.applied.is_empty()
    }

    /// Hinge forces and wrenches at a place.
    pub(super) fn gather(&mut self, systems: &mut LaneSystems, links: &[LinkLanes], place: &Numbers<'_>) {
        self.hinges(place);
        if !self.balls.is_empty() || self.pushed {
            self.one_by_one(systems, place);
        }
        self.applied.fill(LaneWrench::default());
        for spring in &self.between {
            spring.apply(links, &mut self.applied);
        }
        for load in &self.loads {
            load.apply(links, &mut self.applied);
        }
        if !self.others.is_empty() {
            self.elements(systems, links);
        }
    }

    fn hinges(&mut self, place: &Numbers<'_>) {
        for ((tau, [force, damping]), v) in self.tau.iter_mut().zip(&self.given).zip(place.v) {
            *tau = less(*damping, Lanes::new(*v), *force);
        }
        for HingeSpring { position, velocity, stiffness, rest } in &self.springs {
            let tau = &mut self.tau[*velocity];
            *tau = less(*stiffness, Lanes::new(place.q[*position]) - *rest, *tau);
        }
    }

    /// What is computed for each system by itself: springs of balls, motors, tables.
    #[cold]
    fn one_by_one(&mut self, systems: &mut LaneSystems, place: &Numbers<'_>) {
        for lane in 0..WIDTH {
            let (q, v) = (&mut systems.q, &mut systems.v);
            q.iter_mut().zip(place.q).for_each(|(own, q)| *own = q[lane]);
            v.iter_mut().zip(place.v).for_each(|(own, v)| *own = v[lane]);
            let system = &mut systems.all[lane];
            let model = &system.model;
            let mut add = |at: usize, force: f64| {
                let mut tau = self.tau[at].to_array();
                tau[lane] += force;
                self.tau[at] = Lanes::new(tau);
            };
            for index in &self.balls {
                let link = &model.links[*index];
                let torque = applied::hinge::ball_torque(model, link, q);
                (0..3).for_each(|i| add(link.velocity + i, torque[i]));
            }
            if self.pushed {
                applied::motor::pushes(model, &system.laws, place.time[lane], q, v, &mut system.pushes);
                let pushed = system.pushes.iter().zip(model.pushed());
                pushed.for_each(|(push, coordinate)| add(coordinate.velocity, push.force));
            }
        }
    }

    /// Force elements whose laws are asked for each system by itself.
    fn elements(&mut self, systems: &LaneSystems, links: &[LinkLanes]) {
        let Self { others, ends, links: own, applied, .. } = self;
        for lane in 0..WIDTH {
            ends.iter().for_each(|link| links[*link].write(lane, &mut own[*link]));
            let system = &systems.all[lane];
            for index in others.iter() {
                let law = &system.laws.forces[*index].law;
                law.wrenches(own, &mut |end, wrench: Wrench| {
                    let on = &mut applied[law.ends()[end].link];
                    let only = |x| each_vector(|other| if other == lane { x } else { nalgebra::zero() });
                    (on.force, on.moment) =
                        (sum(&on.force, &only(wrench.force)), sum(&on.moment, &only(wrench.moment)));
                });
            }
        }
    }
}
