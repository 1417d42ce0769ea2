//! Which rows act in a system beside those of its loops, drives and gears, and which of these do not.
//!
//! A selection is a value beside positions and velocities. A model never changes with it: a lock that holds for the time of a search,
//! or a drive that is let go to see what it does, is another selection of the same model.

use crate::model::prescribed::Instant;
use crate::model::{Model, Scalar};

/// Which rows act. The default has the model as it is: all of its loops, drives and gears act, nothing else.
#[derive(Debug, Clone, Default)]
pub struct RowSelection {
    /// What is held beside what the model has.
    pub held: Vec<HeldRow>,
    /// Drives that do not act, by their index in `Model::drives`. What building has added to the armature of a massless driven
    /// body (`Drive::armature`) stays: accelerations are right if that is 0 or something else holds the coordinate.
    pub released: Vec<usize>,
}

/// A row of a coordinate, or three of a ball, beside those of the model.
#[derive(Debug, Clone, Copy)]
pub enum HeldRow {
    /// A coordinate, and where or at which rate.
    Coordinate {
        /// Which.
        coordinate: Scalar,
        /// Where (m or rad) and at which rate.
        at: Instant,
    },
    /// The ball of this link, as it stands where the rows are made.
    Ball(usize),
}

impl RowSelection {
    /// Every locked coordinate held where the model starts.
    pub(crate) fn locks(model: &Model) -> Self {
        let balls = model.links.iter().enumerate().filter(|(_, link)| link.joint.is_ball());
        let balls =
            balls.filter(|(_, link)| model.coordinates[link.velocity].lock).map(|(index, _)| HeldRow::Ball(index));
        let held = locked_scalars(model, &model.start_position).chain(balls).collect();
        Self { held, released: Vec::new() }
    }

    /// Every locked turn and slide held at `q`, and every drive replaced by one that stands at `q` and goes on with the rate
    /// that `velocity` has there.
    pub(crate) fn standing(model: &Model, q: &[f64], velocity: &[f64]) -> Self {
        let of_drives = model.drives.iter().map(|drive| {
            let coordinate = drive.coordinate;
            let (position, velocity) = (q[coordinate.position], velocity[coordinate.velocity]);
            HeldRow::Coordinate { coordinate, at: Instant { position, velocity, acceleration: 0.0 } }
        });
        let held = of_drives.chain(locked_scalars(model, q)).collect();
        Self { held, released: (0..model.drives.len()).collect() }
    }

    /// The model without one of its drives.
    pub(crate) fn without_drive(index: usize) -> Self {
        Self { held: Vec::new(), released: vec![index] }
    }
}

/// Locked turns and slides, held at `q`.
fn locked_scalars<'a>(model: &'a Model, q: &'a [f64]) -> impl Iterator<Item = HeldRow> + 'a {
    let locked = scalars(model).filter(|scalar| model.coordinates[scalar.velocity].lock);
    locked.map(|coordinate| {
        let at = Instant { position: q[coordinate.position], ..Instant::default() };
        HeldRow::Coordinate { coordinate, at }
    })
}

/// The turns and slides of a model.
pub(super) fn scalars(model: &Model) -> impl Iterator<Item = Scalar> + '_ {
    let plain = model.links.iter().enumerate().filter(|(_, link)| link.joint.is_scalar());
    plain.map(|(index, link)| Scalar {
        link: index,
        position: link.position,
        velocity: link.velocity,
        slides: link.joint.is_distance(),
    })
}
