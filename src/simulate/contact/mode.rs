//! What contacts of a run do, as a value: a run that is left and taken up again has it from before.

use super::capture::Memory;
use super::{Closed, ContactState, Contacts, GAP, Regime, Stretch};
use crate::contact::geometry::feature::Feature;
use crate::contact::hinges::Id;
use crate::contact::pairs::Key;
use crate::dynamics::System;
use crate::model::Side;
use crate::simulate::mode::Numbers;
use nalgebra::Vector3;

/// What contacts do: which are closed and how, or what the last captured step has left.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::simulate) struct ContactMode {
    regime: Regime,
    stretch: Stretch,
    closed: Vec<Kept>,
    memory: Memory,
    /// As in [`Contacts`].
    recent: Vec<(f64, usize)>,
    accepted: usize,
}

/// A closed contact without what follows from where it is.
#[derive(Debug, Clone, PartialEq)]
struct Kept {
    key: Key,
    state: ContactState,
    axis: Vector3<f64>,
    gap: f64,
    force: Vector3<f64>,
    straight: bool,
    across: f64,
    moved: bool,
    begins: Vector3<f64>,
    pushes: bool,
    since: f64,
}

impl Contacts {
    /// What they do.
    pub(in crate::simulate) fn mode(&self) -> ContactMode {
        let keep = |closed: &Closed| {
            let Closed { key, state, axis, gap, force, straight, across, moved, begins, pushes, since, .. } = *closed;
            Kept { key, state, axis, gap, force, straight, across, moved, begins, pushes, since }
        };
        ContactMode {
            regime: self.regime,
            stretch: self.stretch,
            closed: self.closed.iter().map(keep).collect(),
            memory: Memory { steps: 0, lost: 0.0, work: 0.0, ..self.memory.clone() },
            recent: self.recent.iter().copied().collect(),
            accepted: self.accepted,
        }
    }

    /// Goes on with what contacts did at the place of a system; false if they are of another scene.
    pub(in crate::simulate) fn set_mode(&mut self, system: &System, mode: &ContactMode) -> bool {
        self.pairs.place_at(system.links());
        let of_here = |id: &Id| match id {
            Id::Contact(key) => self.pairs.knows(key),
            Id::Stop(side) => side.stop < self.model.stops.len(),
            Id::Friction(index) => *index < self.model.hinge_friction.len(),
        };
        let ids = mode.memory.forces.iter().map(|(id, _)| *id).chain(mode.memory.active.iter().copied());
        if !ids.chain(mode.closed.iter().map(|kept| Id::Contact(kept.key))).all(|id| of_here(&id)) {
            return false;
        }
        (self.regime, self.stretch) = (mode.regime, mode.stretch);
        (self.memory, self.accepted) = (mode.memory.clone(), mode.accepted);
        self.recent = mode.recent.iter().copied().collect();
        self.closing = GAP;
        let close = |kept: &Kept| {
            let Kept { key, state, axis, gap, force, straight, across, moved, begins, pushes, since } = *kept;
            let (meeting, slip) = (self.pairs.meeting(&key)?, Vector3::zeros());
            Some(Closed { key, state, axis, gap, meeting, force, slip, straight, across, moved, begins, pushes, since })
        };
        self.closed = mode.closed.iter().filter_map(close).collect();
        true
    }
}

impl ContactMode {
    /// Whether forces are those of captured steps, which are at work or have come to rest: they bear what stops and dry friction hold, too.
    pub(in crate::simulate) fn follows_steps(&self) -> bool {
        matches!(self.regime, Regime::Captured | Regime::Frozen)
    }

    /// What rests by the forces of captured steps is asked again whether it does.
    pub(in crate::simulate) fn wake(&mut self) {
        if self.regime == Regime::Frozen {
            self.regime = Regime::Captured;
        }
    }

    /// As numbers, see [`crate::simulate::mode`].
    pub(in crate::simulate) fn write(&self, out: &mut Vec<f64>) {
        let flag = |on: bool| f64::from(u8::from(on));
        out.extend([self.regime as usize as f64, self.stretch.until, self.stretch.length, self.closed.len() as f64]);
        for kept in &self.closed {
            write_key(&kept.key, out);
            let (state, direction) = match kept.state {
                ContactState::Stick => (0.0, Vector3::zeros()),
                ContactState::Slip(direction) => (1.0, direction),
                ContactState::Spare => (2.0, Vector3::zeros()),
            };
            out.push(state);
            out.extend([direction, kept.axis, kept.force, kept.begins].iter().flatten());
            out.extend([kept.gap, kept.across, kept.since]);
            out.extend([kept.straight, kept.moved, kept.pushes].map(flag));
        }
        let Memory { forces, pressed, active, calm, still, last, step, depth, .. } = &self.memory;
        out.push(forces.len() as f64);
        for (id, force) in forces {
            write_id(id, out);
            out.extend(force.iter());
        }
        out.push(pressed.len() as f64);
        out.extend(pressed);
        out.push(active.len() as f64);
        active.iter().for_each(|id| write_id(id, out));
        out.extend([*calm as f64, *still as f64, last[0], last[1], *step, depth.unwrap_or(-1.0)]);
        out.extend([self.accepted as f64, self.recent.len() as f64]);
        self.recent.iter().for_each(|(time, steps)| out.extend([*time, *steps as f64]));
    }

    /// From such numbers.
    pub(in crate::simulate) fn read(numbers: &mut Numbers<'_>) -> Option<Self> {
        let regime = [Regime::Events, Regime::Captured, Regime::Resting, Regime::Frozen];
        let regime = *regime.get(numbers.count()?)?;
        let stretch = Stretch { until: numbers.next()?, length: numbers.next()? };
        let closed = numbers.list(|numbers| {
            let (key, state) = (read_key(numbers)?, numbers.count()?);
            let [direction, axis, force, begins] =
                [numbers.vector()?, numbers.vector()?, numbers.vector()?, numbers.vector()?];
            let [gap, across, since] = [numbers.next()?, numbers.next()?, numbers.next()?];
            let [straight, moved, pushes] = [numbers.flag()?, numbers.flag()?, numbers.flag()?];
            let state = match state {
                0 => ContactState::Stick,
                1 => ContactState::Slip(direction),
                2 => ContactState::Spare,
                _ => return None,
            };
            Some(Kept { key, state, axis, gap, force, straight, across, moved, begins, pushes, since })
        })?;
        let memory = Memory {
            forces: numbers.list(|numbers| Some((read_id(numbers)?, numbers.vector()?)))?,
            pressed: numbers.list(Numbers::next)?,
            active: numbers.list(read_id)?,
            calm: numbers.count()?,
            still: numbers.count()?,
            last: [numbers.next()?, numbers.next()?],
            step: numbers.next()?,
            depth: Some(numbers.next()?).filter(|depth| *depth >= 0.0),
            ..Memory::default()
        };
        let accepted = numbers.count()?;
        let recent = numbers.list(|numbers| Some((numbers.next()?, numbers.count()?)))?;
        Some(Self { regime, stretch, closed, memory, recent, accepted })
    }
}

fn write_feature(feature: Feature, out: &mut Vec<f64>) {
    let (kind, index) = match feature {
        Feature::Face(index) => (0.0, index),
        Feature::Edge(index) => (1.0, index),
        Feature::Vertex(index) => (2.0, index),
    };
    out.extend([kind, f64::from(index)]);
}

fn read_feature(numbers: &mut Numbers<'_>) -> Option<Feature> {
    let (kind, index) = (numbers.count()?, u16::try_from(numbers.count()?).ok()?);
    match kind {
        0 => Some(Feature::Face(index)),
        1 => Some(Feature::Edge(index)),
        2 => Some(Feature::Vertex(index)),
        _ => None,
    }
}

fn write_key(key: &Key, out: &mut Vec<f64>) {
    out.push(key.couple as f64);
    key.features.iter().for_each(|feature| write_feature(*feature, out));
}

fn read_key(numbers: &mut Numbers<'_>) -> Option<Key> {
    Some(Key { couple: numbers.count()?, features: [read_feature(numbers)?, read_feature(numbers)?] })
}

fn write_id(id: &Id, out: &mut Vec<f64>) {
    match id {
        Id::Contact(key) => {
            out.push(0.0);
            write_key(key, out);
        }
        Id::Stop(side) => out.extend([1.0, side.stop as f64, f64::from(u8::from(side.at == Side::High))]),
        Id::Friction(index) => out.extend([2.0, *index as f64]),
    }
}

fn read_id(numbers: &mut Numbers<'_>) -> Option<Id> {
    match numbers.count()? {
        0 => read_key(numbers).map(Id::Contact),
        1 => numbers.side().map(Id::Stop),
        2 => numbers.count().map(Id::Friction),
        _ => None,
    }
}
