//! Joints of level bodies: what slides or rolls over one is carried on, and the edge behind it curves away.

use super::{ContactState, Contacts, GAP};
use crate::contact::frame::Frame;
use crate::contact::geometry::feature::Meeting;
use crate::contact::pairs::LOOSE;

/// Rows along the normal that differ by less than this part are one, and what their contacts part by of themselves differs clearly if it does by
/// more than this part of it and of gravity: ten times what such rows can differ by.
const ALIKE_ROWS: f64 = 1e-3;
const CURVES: f64 = 1e-2;

impl Contacts {
    /// Leaves out what only curves away from where another contact bears ([`Contacts::is_behind`]).
    pub(super) fn leave_out(&self, frames: &mut Vec<Frame>) {
        let all: Vec<bool> = frames.iter().map(|one| frames.iter().any(|other| self.is_behind(one, other))).collect();
        let mut all = all.into_iter();
        frames.retain(|_| !all.next().is_some_and(|behind| behind));
    }

    /// Whether `one` parts whatever bears as long as `other` does not sink: both are moved alike, `J` being one, and its own way over the bodies
    /// parts it faster, `c` being more; nor does it meet before that, as `g − u²/2c` is left of its gap where it is nearest. So does the edge of
    /// a table behind a wheel that has rolled on onto the next one, and the edge of that before: beside the contact that holds the wheel their
    /// rows are dependent, and wrong. What is about to end by itself, `other` being at the end of where it counts, holds nothing.
    fn is_behind(&self, one: &Frame, other: &Frame) -> bool {
        let (more, own) = (one.bias.x - other.bias.x, self.model.gravity.norm());
        let clear = more > CURVES * (one.bias.x.abs() + other.bias.x.abs() + own);
        let comes = (other.speed.x - one.speed.x).max(0.0);
        let meets =
            0.5 * comes * comes / more > one.meeting.gap.max(0.0) + GAP * self.pairs.couples[one.key.couple].size;
        let size = other.columns[0].iter().map(|(_, value)| value.abs()).fold(0.0, f64::max);
        let value = |i: usize| one.columns[0].iter().find(|(at, _)| *at == i).map_or(0.0, |(_, value)| *value);
        let alike = |(i, own): &(usize, f64)| (value(*i) - own).abs() < ALIKE_ROWS * size;
        let known =
            |(i, own): &(usize, f64)| own.abs() < ALIKE_ROWS * size || other.columns[0].iter().any(|(at, _)| at == i);
        clear
            && !meets
            && other.meeting.inside >= 0.0
            && one.links == other.links
            && [one, other].iter().all(|frame| self.is_rigid(frame.key.couple))
            && other.columns[0].iter().all(alike)
            && one.columns[0].iter().all(known)
    }

    /// Contacts that bear, where shapes stand now, with their couples.
    pub(super) fn bearing(&self) -> Vec<(usize, Meeting)> {
        let bears = self.closed.iter().filter(|closed| closed.state != ContactState::Spare);
        bears.filter_map(|closed| Some((closed.key.couple, self.pairs.meeting(&closed.key)?))).collect()
    }

    /// Whether a body of a couple is carried by another one, level with where they touched.
    pub(super) fn is_carried(&self, couple: usize, place: &Meeting, now: &[(usize, Meeting)]) -> bool {
        let bodies = |of: usize| self.pairs.couples[of].pieces.map(|piece| self.pairs.pieces[piece].body);
        now.iter().any(|(other, at)| {
            let shared = bodies(couple).iter().any(|body| bodies(*other).contains(body));
            let size = self.pairs.couples[couple].size;
            // Which of both bodies a rule names first says which way its normal is.
            let level = at.normal.dot(&place.normal).abs() > 1.0 - 1e-6;
            let above = place.normal.dot(&(at.point - place.point)).abs();
            *other != couple && shared && level && above < 10.0 * LOOSE * size
        })
    }
}
