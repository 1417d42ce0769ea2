//! What a link weighs.

use super::pose::turn;
use crate::import::draft::Entry;
use crate::import::log::{Problem, Taken};
use crate::import::xml::Element;
use crate::round_off::WRITTEN;
use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion};

const MOMENTS: [&str; 6] = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];

/// Mass, centre and inertia out of `<inertial>`; a link without is without mass.
pub(super) fn write(link: &Element<'_>, body: &mut Entry) {
    let Some(inertial) = link.child("inertial") else { return };
    let (Some(mass), Some(inertia)) = (part(&inertial, "mass"), part(&inertial, "inertia")) else { return };
    let Some(value) = mass.required("value") else { return };
    let Some(kilograms) = value.number() else { return };
    if kilograms < 0.0 {
        inertial.refuse(value.wrong(&format!("is {kilograms}, allowed: ≥ 0 kg")));
    }
    body.set("mass", kilograms, Some(value.place()));
    let origin = inertial.child("origin");
    if let Some(xyz) = origin.and_then(|origin| origin.attribute("xyz"))
        && let Some(center) = xyz.vector::<3>().filter(|center| *center != [0.0; 3])
    {
        body.numbers("center", &center, Some(xyz.place()));
    }
    let Some(moments) = moments(&inertia) else { return };
    let turn = turn(&inertial);
    if turn != UnitQuaternion::identity() {
        let rpy = origin.and_then(|origin| origin.text("rpy")).unwrap_or_default();
        body.comment(&format!("its inertia is given in axes turned by rpy = {rpy}"));
    }
    body.numbers("inertia", &in_body_axes(moments, turn), Some(inertia.place()));
    if let Some(why) = impossible(moments, kilograms) {
        body.set("unphysical", true, Some(inertia.place()));
        inertia.note(Taken::Used, format!("no body can have it ({why}): it is taken as it stands"));
    }
}

/// Whether a link has mass or inertia; what cannot be read is said elsewhere.
pub(super) fn weighs(link: &Element<'_>) -> bool {
    let Some(inertial) = link.child("inertial") else { return false };
    let number = |part: &str, key: &str| inertial.child(part).and_then(|part| part.text(key)).map(str::trim);
    let zero = |text: Option<&str>| text.is_none_or(|text| text.parse() == Ok(0.0));
    !zero(number("mass", "value")) || MOMENTS.iter().any(|key| !zero(number("inertia", key)))
}

/// Why no body can have these moments; small excess is rounding.
fn impossible([xx, yy, zz, xy, xz, yz]: [f64; 6], mass: f64) -> Option<String> {
    let matrix = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let mut principal: [f64; 3] = SymmetricEigen::new(matrix).eigenvalues.into();
    principal.sort_by(f64::total_cmp);
    let [small, middle, large] = principal;
    if mass == 0.0 && large > 0.0 {
        return Some("there is no mass with it".to_owned());
    }
    if small < -WRITTEN.of(large.abs().max(f64::MIN_POSITIVE)) {
        return Some(format!("its smallest principal moment is {small:e} kg m²"));
    }
    let excess = large - small - middle;
    (excess > WRITTEN.of(large.abs())).then(|| {
        let part = 100.0 * excess / large;
        format!("its largest principal moment exceeds the sum of the others by {part:.3} %")
    })
}

fn part<'a>(inertial: &Element<'a>, name: &str) -> Option<Element<'a>> {
    let found = inertial.child(name);
    if found.is_none() {
        let message = format!("{}: <{name}> is missing", inertial.label());
        inertial.refuse(Problem::at(inertial.place(), message).help("a link of no mass has no <inertial>"));
    }
    found
}

fn moments(inertia: &Element<'_>) -> Option<[f64; 6]> {
    let mut moments = [0.0; 6];
    for (moment, key) in moments.iter_mut().zip(MOMENTS) {
        *moment = inertia.required(key)?.number()?;
    }
    Some(moments)
}

/// xx, yy, zz, and where they are not zero xy, xz, yz, in axes in which the given ones are turned.
fn in_body_axes(given: [f64; 6], turn: UnitQuaternion<f64>) -> Vec<f64> {
    let [xx, yy, zz, xy, xz, yz] = given;
    let mut moments = given;
    if turn != UnitQuaternion::identity() {
        let turn = turn.to_rotation_matrix();
        let i = turn * Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * turn.transpose();
        moments = [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23];
    }
    if moments[3..] == [0.0; 3] { moments[..3].to_vec() } else { moments.to_vec() }
}
