//! What hinges and gears have of their own to be drawn: curves of hinges of type `along`, springs of prismatic ones, racks on their pinions.

use crate::model::{Body, CurveOver, Gear, HingeCurve, Link, Model};
use crate::record::scene::{CurvePicture, LinePicture};
use nalgebra::{Point3, Vector3};

/// Axes that are perpendicular have a cosine of no more than what rounding makes of unit vectors.
const PERPENDICULAR: f64 = 1e-9;

/// The curves of all hinges along one, in the axes of the bodies that have them; those that several bodies share once.
pub(super) fn curves(model: &Model) -> Vec<CurvePicture> {
    let of_link = |link: &Link| {
        let guide = model.rods[link.joint.rod()?].guide()?;
        let body =
            model.bodies.iter().find(|body| body.hinge.position == link.position && body.hinge.kind.counts().0 > 0)?;
        let on_parent = |at: Vector3<f64>| (body.hinge.parent_from_hinge * Point3::from(at)).coords.into();
        let points = guide.outline().into_iter().map(on_parent).collect();
        Some(CurvePicture { name: body.name.clone(), body: body.parent, points })
    };
    let mut all: Vec<CurvePicture> = Vec::new();
    for curve in model.links.iter().filter_map(of_link) {
        if !all.iter().any(|known| known.body == curve.body && known.points == curve.points) {
            all.push(curve);
        }
    }
    all
}

/// Springs of hinges, and racks.
pub(super) fn lines(model: &Model) -> impl Iterator<Item = LinePicture> + '_ {
    springs(model).chain(racks(model))
}

/// The springs of prismatic hinges that are as long as they are relaxed: from the hinge's point on the parent to the root marker.
fn springs(model: &Model) -> impl Iterator<Item = LinePicture> + '_ {
    let of_body = |(index, body): (usize, &Body)| {
        if body.hinge.kind.name() != "prismatic" {
            return None;
        }
        let coordinate = model.coordinates.get(body.hinge.velocity)?;
        let is_own =
            |curve: &&HingeCurve| curve.over == CurveOver::Position && curve.coordinate.velocity == body.hinge.velocity;
        let (spring, coil) = match model.curves.iter().find(is_own) {
            Some(curve) => (None, Some(curve.rest)),
            None if coordinate.stiffness > 0.0 => (Some([coordinate.stiffness, coordinate.rest]), None),
            None => return None,
        };
        let at = body.hinge.parent_from_hinge.translation.vector.into();
        let ends = vec![(body.parent, at), (Some(index), [0.0; 3])];
        let has_length = spring.map(|[_, rest]| rest).or(coil).is_some_and(|rest| rest > 0.0);
        has_length.then(|| LinePicture { name: body.name.clone(), ends, spring, coil, ..LinePicture::default() })
    };
    model.bodies.iter().enumerate().filter_map(of_body)
}

/// A line from each body that is a rack, or hangs on a rope about a drum, to where the pinion takes it up.
fn racks(model: &Model) -> impl Iterator<Item = LinePicture> + '_ {
    let of_gear = |gear: &Gear| {
        let [rack, pinion] = gear.coordinates.map(|one| {
            let has = |body: &&Body| body.hinge.velocity == one.velocity && body.hinge.kind.counts().1 == 1;
            model.bodies.iter().find(has)
        });
        let (rack, pinion) = (rack?, pinion?);
        if rack.parent != pinion.parent
            || (rack.hinge.kind.name(), pinion.hinge.kind.name()) != ("prismatic", "revolute")
        {
            return None;
        }
        let [(from, along), (middle, about)] = [axis(rack)?, axis(pinion)?];
        // A nut goes along its screw.
        if along.dot(&about).abs() > PERPENDICULAR {
            return None;
        }
        let taken_up = from + (middle - from).dot(&along) * along;
        let body = model.body(&rack.name)?;
        let ends = vec![(Some(body), [0.0; 3]), (rack.parent, taken_up.into())];
        Some(LinePicture { name: gear.name.clone(), ends, goes_on: true, ..LinePicture::default() })
    };
    model.gears.iter().filter_map(of_gear)
}

/// A point of the axis of a hinge that has one, and its direction, in the axes of its parent.
fn axis(body: &Body) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let place = &body.hinge.parent_from_hinge;
    let axis = body.hinge.kind.axes().first()?.try_normalize(0.0)?;
    Some((place.translation.vector, place.rotation * axis))
}
