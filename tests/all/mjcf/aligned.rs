//! `align` of a free joint: what a keyframe says counts from the principal axes of the body, which keeps its own here.

use super::scenario;
use nalgebra::{Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Where two geoms are, given in body axes, and how fast they move: `geom_xpos` and `mj_objectVelocity` of MuJoCo 4.0.0.
const GEOMS: [([f64; 3], [f64; 3], [f64; 3]); 2] = [
    (
        [0.2, 0.1, 0.0],
        [0.5254219957770975, -0.6010665458125573, 1.812309336232821],
        [-0.6987801828692319, -1.0619726784901984, -0.7166280236559555],
    ),
    (
        [0.3, 0.3, 0.0],
        [0.4672072388964021, -0.3920446176416295, 1.8663544620540196],
        [-0.7780193344666934, -1.1152924103541897, -0.5957641137503669],
    ),
];

#[test]
fn a_keyframe_of_an_aligned_body_counts_from_its_principal_axes() {
    let scenario = scenario(
        r#"<mujoco><worldbody><body name="f" pos="0 0 2" euler="20 30 40"><freejoint align="true"/>
<geom type="box" size=".1 .2 .3" pos=".2 .1 0" euler="10 20 30"/><geom size=".1" pos=".3 .3 0"/></body></worldbody>
<keyframe><key qpos="0.5207495478732656 -0.5842899736430869 1.8166471201279442 0.8527292312190031
0.1056228384931774 -0.05888346430220706 0.5081627808537961"
qvel="-0.7051400961905527 -1.0662522406275334 -0.7069272131957375
1.1336127776816387 0.2783120821740968 0.38115021952402534"/></keyframe></mujoco>"#,
    );
    let hinge = &scenario.description.bodies[0].hinge;
    let [x, y, z, w, i, j, k] = hinge.position[..] else { panic!("{:?}", hinge.position) };
    let [u, v, s, a, b, c] = hinge.velocity[..] else { panic!("{:?}", hinge.velocity) };
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    let pose = Translation3::new(x, y, z) * turn;
    for (at, position, velocity) in GEOMS.map(|(a, b, c)| (Vector3::from(a), Vector3::from(b), Vector3::from(c))) {
        let found = (pose * Point3::from(at)).coords;
        // Round-off of the principal axes, which is that of the inertia over the differences of its moments.
        assert!((found - position).norm() < 1e-12, "{found} {position}");
        let found = Vector3::new(u, v, s) + turn * Vector3::new(a, b, c).cross(&at);
        assert!((found - velocity).norm() < 1e-12, "{found} {velocity}");
    }
}
