//! Bodies on springs: a line of very unequal ones, and a bushing.

use super::case::case;
use super::scene::{Scene, frequencies, head};

/// Relative coordinates keep the elongations of springs that are a thousand million times stiffer than others.
#[test]
fn b09_spring_line_1e9() {
    let case = case("B09_spring_line_1e9");
    let parameters = case.at("parameters");
    let (stiffness, mass) = (parameters.at("k").numbers(), parameters.at("m").numbers());
    let text = head([0.0, 0.0, -case.parameter("g")], "dopri5", 1e-8)
        + &format!(
            "[[body]]\nname = \"mass\"\nrepeat = {}\nmass = {mass:?}\n\
             hinge = {{ type = \"prismatic\", axis = [0, 0, -1], stiffness = {stiffness:?} }}\n",
            mass.len()
        );
    let found = Scene::read(&text).rest();
    let (reference, mut below) = (case.at("reference"), 0.0);
    let soft = case.tolerance("rel_soft");
    for (i, elongation) in found.position.iter().enumerate() {
        below += elongation;
        reference.at("x").items()[i].check_relative(below, soft);
        // Relative coordinates: the stiff ones are as good as the soft ones, 1e8 times better than asked.
        reference.at("elongation").items()[i].check_relative(*elongation, soft);
    }
    for (expected, found) in reference.at("omega").items().iter().zip(frequencies(&found)) {
        expected.check_relative(found, soft);
    }
}

#[test]
fn b11_bushing_free_body() {
    let case = case("B11_bushing_free_body");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("abs"));
    let [k, kr, m, a, inertia] = ["k", "kr", "m", "a", "I_com"].map(|key| case.parameter(key));
    let body = format!(
        "[[body]]\nname = \"body\"\nmass = {m:?}\ncenter = {:?}\ninertia = {:?}\nhinge = {{ type = \"free\" }}\n\
         [[force]]\ntype = \"bushing\"\nbetween = [\"body\", {{ body = \"ground\", at = [0, 0, 0] }}]\n\
         stiffness = {{ translation = {k:?}, rotation = {kr:?} }}\n",
        [a, 0.0, 0.0],
        [inertia; 3],
    );
    let found = Scene::read(&(head([0.0, 0.0, -case.parameter("g")], "dopri5", 1e-8) + &body)).rest();
    let pose = &found.poses[0];
    reference.at("a_attachment_z").check(pose.translation.vector.z, tolerance);
    reference.at("a_rotation_y").check(pose.rotation.scaled_axis().y, tolerance);
    let center = pose * nalgebra::Point3::new(a, 0.0, 0.0);
    reference.at("a_com").check_list(center.coords.as_slice(), tolerance);
    reference.at("a_quat_wxyz").check_list(&wxyz(pose), tolerance);

    let torque = "[[force]]\ntype = \"load\"\non = \"body\"\ntorque = [1, -2, 3]\n";
    // A torque that is constant in space has no potential: without damping this equilibrium flutters.
    let any = "[statics]\nwant = \"any\"\n";
    let found = Scene::read(&(head([0.0; 3], "dopri5", 1e-8) + any + &body + torque)).rest();
    let pose = &found.poses[0];
    reference.at("b_rotation_vector").check_list(pose.rotation.scaled_axis().as_slice(), tolerance);
    reference.at("b_quat_wxyz").check_list(&wxyz(pose), tolerance);
}

fn wxyz(pose: &nalgebra::Isometry3<f64>) -> [f64; 4] {
    let p = pose.rotation;
    [p.w, p.i, p.j, p.k].map(|x| x * p.w.signum())
}
