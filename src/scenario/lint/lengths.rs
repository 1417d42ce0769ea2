//! A length in millimetres among metres.

use super::{Scene, Written, by_coordinate, exactly, hinge_of, in_millimetres, limits, tables, text, units};
use crate::hinge::HingeKind;
use crate::model::description::GROUND;
use crate::model::problem::{number, rounded};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A length is out of line if it is so many times the median of all...
const APART: f64 = 200.0;
/// ... and in line, within this factor, if it is taken as millimetres...
const ALIKE: f64 = 5.0;
/// ... unless lengths lead up to it, none so many times the one before: a long row of bodies is no slip.
const GAP: f64 = 10.0;
/// Among this many lengths, or if all others are so many times smaller, one that no other of its body bears out is out of line a bit earlier...
const MANY: usize = 4;
/// ... at so many times the median...
const EARLY: f64 = 100.0;
/// ... and in line within this factor.
const NEAR: f64 = 10.0;

/// What a length is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Where a hinge is on the ground.
    Place,
    /// Where a hinge is on a body, and its centre of mass.
    Chain,
    /// Another point of a body, or its size.
    Own,
    /// How far something goes or reaches: it may be far in any scene.
    Travel,
}

/// A length or a point.
#[derive(Debug)]
struct Length<'a> {
    numbers: Vec<Written>,
    /// The largest of its numbers in size (m).
    extent: f64,
    /// The body that it is of; empty of none.
    owner: &'a str,
    role: Role,
}

/// The lengths of a scene, with what all of them but one have together.
#[derive(Debug)]
pub(super) struct Lengths<'a> {
    all: Vec<Length<'a>>,
}

impl<'a> Lengths<'a> {
    /// All of a scene but zeros.
    pub(super) fn new(scene: &Scene<'a>) -> Self {
        Self { all: found(scene) }
    }

    /// The longest (m); 0 without any.
    pub(super) fn longest(&self) -> f64 {
        self.all.iter().fold(0.0, |longest, length| longest.max(length.extent))
    }
}

fn found<'a>(scene: &Scene<'a>) -> Vec<Length<'a>> {
    let mut found = Found { scene, lengths: Vec::new() };
    for body in scene.tables("body") {
        found.of_body(body);
    }
    for beam in scene.tables("beam") {
        found.hinge(beam, "");
        found.add(beam.get("length"), "", Role::Travel);
    }
    for cable in scene.tables("cable") {
        found.add(cable.get("length"), "", Role::Travel);
    }
    for list in ["force", "loop"] {
        for table in scene.tables(list) {
            for point in ["between", "through", "on"].into_iter().flat_map(|key| tables(table.get(key))) {
                let owner = text(point, "body").unwrap_or(GROUND);
                found.add(point.get("at"), owner, if owner == GROUND { Role::Travel } else { Role::Own });
            }
            found.add(table.get("length"), "", Role::Travel);
        }
    }
    found.lengths
}

/// Lengths as they are found.
struct Found<'f, 'a> {
    scene: &'f Scene<'a>,
    lengths: Vec<Length<'a>>,
}

impl<'a> Found<'_, 'a> {
    fn add(&mut self, place: Option<&Spanned<DeValue<'_>>>, owner: &'a str, role: Role) {
        let numbers = place.map_or_else(Vec::new, |place| self.scene.numbers(place));
        let extent = numbers.iter().fold(0.0, |extent: f64, written| extent.max(written.value.abs()));
        if extent > 0.0 {
            self.lengths.push(Length { numbers, extent, owner, role });
        }
    }

    fn of_body(&mut self, body: &'a DeTable<'a>) {
        let name = text(body, "name").unwrap_or_default();
        self.hinge(body, name);
        let is_ground = |kind: &HingeKind| *kind == HingeKind::Fixed && parent(body) == GROUND;
        // What stands still may be as large as it likes.
        if hinge_of(body).as_ref().map_or_else(|| !body.contains_key("hinge"), is_ground) {
            return;
        }
        self.add(body.get("center"), name, Role::Chain);
        self.add(body.get("next"), name, Role::Chain);
        self.add(exactly(body, "hinge.next"), name, Role::Chain);
        let markers = body.get("markers").and_then(|markers| markers.get_ref().as_table());
        for (_, place) in markers.into_iter().flat_map(|markers| markers.iter()) {
            self.add(Some(place), name, Role::Own);
        }
        for shape in tables(body.get("shape")) {
            self.add(shape.get("at"), name, Role::Own);
            for key in ["box", "sphere", "cylinder", "capsule"] {
                self.add(shape.get(key), name, Role::Own);
                self.add(exactly(shape, &format!("{key}.length")), name, Role::Own);
            }
        }
    }

    /// Where a hinge is, and how far it slides.
    fn hinge(&mut self, body: &'a DeTable<'a>, name: &'a str) {
        let (at, parent) = (exactly(body, "hinge.at"), parent(body));
        self.add(at, parent, if parent == GROUND { Role::Place } else { Role::Chain });
        let units = hinge_of(body).map(|kind| units(&kind)).unwrap_or_default();
        for key in ["position", "rest", "limits"] {
            let Some(place) = exactly(body, &format!("hinge.{key}")) else { continue };
            let found = if key == "limits" { limits(place) } else { by_coordinate(place, units.len()) };
            for (_, place) in found.into_iter().filter(|(coordinate, _)| units.get(*coordinate) == Some(&"m")) {
                self.add(Some(place), name, Role::Travel);
            }
        }
    }
}

fn parent<'a>(body: &'a DeTable<'a>) -> &'a str {
    text(body, "hinge.parent").unwrap_or(GROUND)
}

/// Warns of lengths that are out of line.
pub(super) fn check(scene: &Scene<'_>, lengths: &Lengths<'_>) {
    let of = |roles: &[Role]| lengths.all.iter().filter(|length| roles.contains(&length.role)).collect::<Vec<_>>();
    // Places on the ground are beside each other and not beside what is small: a curtain of beads hangs from somewhere.
    let chain = of(&[Role::Place, Role::Chain]);
    if chain.len() > 2 {
        check_among(scene, &chain, |_, times| is_between(times, APART, ALIKE));
    }
    let all = of(&[Role::Place, Role::Chain, Role::Own]);
    let is_lone = all.len() > 2 && lead(&all) >= EARLY;
    check_among(scene, &all, |length, times| {
        let early = (all.len() >= MANY || is_lone) && is_between(times, EARLY, NEAR);
        length.role != Role::Place && (early || is_between(times, APART, ALIKE)) && !is_borne_out(length, &all)
    });
}

/// How many times the second the longest is.
fn lead(lengths: &[&Length<'_>]) -> f64 {
    let [first, second] = lengths.iter().fold([0.0, 0.0], |[first, second]: [f64; 2], length| {
        [first.max(length.extent), second.max(first.min(length.extent))]
    });
    first / second
}

/// Whether so many times the median is much, and in line if it is taken as millimetres.
fn is_between(times: f64, apart: f64, alike: f64) -> bool {
    times >= apart && (1.0 / alike..=alike).contains(&(times / 1000.0))
}

/// Whether another length of its body is alike: a large body has several that are large.
fn is_borne_out(length: &Length<'_>, all: &[&Length<'_>]) -> bool {
    let alike = |other: &Length<'_>| (1.0 / NEAR..=NEAR).contains(&(other.extent / length.extent));
    all.iter().any(|other| !std::ptr::eq(*other, length) && other.owner == length.owner && alike(other))
}

/// Warns of the numbers of `judged` lengths that lie behind a gap and are `out` of line at so many times the median.
fn check_among(scene: &Scene<'_>, judged: &[&Length<'_>], out: impl Fn(&Length<'_>, f64) -> bool) {
    let mut sizes: Vec<f64> = judged.iter().map(|length| length.extent).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let middle = match sizes.len() {
        0 | 1 => return,
        2 => 0,
        count => count / 2,
    };
    let above = &sizes[middle..];
    let median = above[0];
    let Some(gap) = above.windows(2).find(|pair| pair[1] > GAP * pair[0]) else { return };
    for length in judged {
        for written in length.numbers.iter().filter(|written| written.value.abs() >= gap[1]) {
            let times = written.value.abs() / median;
            if out(length, times) {
                let of = if sizes.len() == 2 {
                    "the other length of the scene"
                } else {
                    "the median of the scene's lengths"
                };
                let message =
                    format!("{} m is {} times {of}, {} m", written.value, rounded(times.round()), number(median));
                scene.warn(written, message, in_millimetres(written.value));
            }
        }
    }
}
