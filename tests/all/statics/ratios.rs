//! Masses and stiffnesses of a million to one and more, beside each other: the search finds what is there.

use crate::common::build;
use nalgebra::Vector3;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

/// The equilibrium that the file wants.
fn find(text: &str) -> Equilibrium {
    let scenario = scenario::parse("scene.toml", text, &[]).unwrap_or_else(|found| panic!("{found}"));
    let model = build(&scenario.description);
    equilibrium(&model, &scenario.statics, &model.start_position).expect("finite")
}

fn proved(found: &Equilibrium, what: &str) {
    assert!(found.converged, "{what}: {} at {:.1e}, {:?}", found.stage, found.relative_residual, found.notes);
    assert!(found.relative_residual <= found.round_off.max(1e-10), "{what}: {:.1e}", found.relative_residual);
}

/// A link of a chain: length, mass, and how far its centre is beside the line from end to end.
type Link = (f64, f64, f64);

/// A chain of balls between two walls.
fn balls(links: &[Link], span: f64) -> String {
    let link = |(i, (length, mass, beside)): (usize, &Link)| {
        let on = if i == 0 { String::new() } else { format!(", parent = \"k{}\", at = \"tip\"", i - 1) };
        let inertia = mass * length * length / 12.0;
        format!(
            "[[body]]\nname = \"k{i}\"\nmass = {mass}\ncenter = [{}, 0, {beside}]\n\
             inertia = [{inertia}, {inertia}, {inertia}]\n\
             markers = {{ tip = [{length}, 0, 0], off = [{}, 0, 0.1] }}\nhinge = {{ type = \"spherical\"{on} }}\n",
            0.5 * length,
            length / 3.0
        )
    };
    let bodies: String = links.iter().enumerate().map(link).collect();
    let end = format!("between = [\"k{}.tip\", {{ body = \"ground\", at = [{span}, 0, 0] }}]", links.len() - 1);
    format!("{bodies}[[loop]]\ntype = \"spherical\"\n{end}\n")
}

/// Whether rows are linearly dependent is a matter of geometry: a body a million times heavier than its neighbours does not put a
/// chain into a singular position, and does not keep it from moving.
#[test]
fn heavy_links_among_light_ones_do_not_look_singular() {
    let links = [(0.69, 1.1e6, -0.084), (0.85, 4.8e5, 0.077), (0.49, 5.3e6, 0.045), (0.86, 2.2e6, 0.073)];
    let links = [&links[..], &[(0.91, 0.84, -0.045), (0.83, 0.23, 0.075)]].concat();
    let found = find(&format!("[statics]\nwant = \"any\"\n{}", balls(&links, 1.35)));
    proved(&found, "a chain of balls");
    assert!(found.notes.iter().all(|note| !note.contains("singular")), "{:?}", found.notes);
    // What the walls carry is the weight: the first hinge pushes its link, the loop the last one.
    let weight: f64 = links.iter().map(|link| 9.80665 * link.1).sum();
    let carried = found.reactions[0].force.z + found.loops[0].force.z.abs();
    let error = (carried / weight - 1.0).abs();
    assert!(error < 1e-9, "{carried} of {weight} N");
}

/// A spring of 7·10⁷ N/m that carries bodies of 10⁶ kg draws a chain with links of less than 1 kg tight: what is left of the way
/// down is a valley ten thousand times softer along than across, and bends. Straight steps stop before its end.
#[test]
fn light_links_settle_between_heavy_ones_on_a_stiff_spring() {
    let links = [(0.32, 7.6e5, -0.07), (0.5, 1.7, -0.065), (0.97, 0.17, 0.0026), (0.77, 5.8e6, 0.069)];
    let links = [&links[..], &[(0.39, 3.3e6, -0.067), (0.54, 4.5, 0.079)]].concat();
    let spring = "[[force]]\ntype = \"spring\"\nbetween = [\"k4.off\", { body = \"ground\", at = [0.13, 0, 0.17] }]\n\
                  stiffness = 6.7e7\nlength = 0.11\n";
    let found = find(&format!("{}{spring}", balls(&links, 1.18)));
    proved(&found, "a chain with a spring");
    // What weighs a kilogram costs next to nothing beside the spring.
    assert_ne!(found.stability.map(|s| s.verdict), Some(StabilityVerdict::Unstable));
}

/// A spring of 4·10¹¹ N/m between two pendulums: the floor of its valley is a curve on which no step of 10⁻³ rad is straight
/// enough.
#[test]
fn pendulums_swing_at_the_ends_of_a_spring_that_does_not_give() {
    let found = find(PENDULUMS);
    proved(&found, "pendulums");
    let end = |body: usize, at: [f64; 3]| {
        found.poses[body].translation.vector + found.poses[body].rotation * Vector3::from(at)
    };
    let length = (end(1, [0.863, 0.565, -0.163]) - end(2, [-0.667, 0.221, -0.472])).norm();
    assert!((length - 0.17).abs() < 1e-8, "{length} m");
}

/// Bodies of 10⁶ kg on springs of 40 N/m come to rest half a million metres down. There rounding the potential takes more than
/// all that the light ones can gain: forces at both ends of a step tell whether it leads down.
#[test]
fn light_bodies_settle_where_the_potential_is_all_round_off() {
    let found = find(DEEP);
    proved(&found, "bodies far down");
    assert!(found.relative_residual < 1e-10, "{:.1e}", found.relative_residual);
    assert!(found.iterations < 1000, "{} steps", found.iterations);
}

/// Loops are closed again after each step. In the metric of the inertia light links move first; the last ones of this chain cannot
/// close its gap, and whip about for as long as they are let. When all are bent alike Newton's steps arrive.
#[test]
fn a_gap_that_light_links_cannot_close_is_closed_by_all() {
    let found = find(WHIP);
    proved(&found, "a closed chain");
    assert_eq!(found.stage, "newton", "{:?}", found.stages);
    assert!(found.loops[0].gap < 1e-12, "{} m", found.loops[0].gap);
}

const WHIP: &str = r#"
[statics]
want="any"
[[body]]
name="k0"
mass=7.71
center=[0.232,0,-0.00381]
inertia=[0.138, 0.138, 0.138]
markers={tip=[0.463,0,0],off=[0.154,0,0.1]}
hinge={type="revolute", at=[0, 0, 0], axis=[0,1,0], position=0.81}
[[body]]
name="k1"
mass=2.22e+06
center=[0.444,0,0.00365]
inertia=[1.46e+05, 1.46e+05, 1.46e+05]
markers={tip=[0.889,0,0],off=[0.296,0,0.1]}
hinge={type="revolute", parent="k0", at="tip", axis=[0,1,0], position=-0.436}
[[body]]
name="k2"
mass=3.06
center=[0.318,0,0.063]
inertia=[0.103, 0.103, 0.103]
markers={tip=[0.635,0,0],off=[0.212,0,0.1]}
hinge={type="revolute", parent="k1", at="tip", axis=[0,1,0], position=0.798}
[[body]]
name="k3"
mass=0.435
center=[0.458,0,0.0775]
inertia=[0.0305, 0.0305, 0.0305]
markers={tip=[0.916,0,0],off=[0.305,0,0.1]}
hinge={type="revolute", parent="k2", at="tip", axis=[0,1,0], position=-0.439, stiffness=39.2, rest=-0.361}
[[body]]
name="k4"
mass=9.57e+06
center=[0.336,0,0.0307]
inertia=[3.61e+05, 3.61e+05, 3.61e+05]
markers={tip=[0.673,0,0],off=[0.224,0,0.1]}
hinge={type="revolute", parent="k3", at="tip", axis=[0,1,0], position=0.99}
[[body]]
name="k5"
mass=1.06
center=[0.335,0,0.0317]
inertia=[0.0396, 0.0396, 0.0396]
markers={tip=[0.669,0,0],off=[0.223,0,0.1]}
hinge={type="revolute", parent="k4", at="tip", axis=[0,1,0], position=0.539}
[[body]]
name="k6"
mass=0.6
center=[0.493,0,-0.0271]
inertia=[0.0486, 0.0486, 0.0486]
markers={tip=[0.985,0,0],off=[0.328,0,0.1]}
hinge={type="revolute", parent="k5", at="tip", axis=[0,1,0], position=0.11}
[[loop]]
type="revolute"
between=["k6.tip",{body="ground",at=[3.18,0,0]}]
axis=[0,1,0]
[[force]]
type="spring"
between=["k4.off",{body="ground",at=[1.7, 0, -0.873]}]
stiffness=1.9
length=0.103
[[force]]
type="spring"
between=["k3.off",{body="ground",at=[0.551, 0, -0.594]}]
stiffness=3.79e+06
length=0.45
"#;

const PENDULUMS: &str = r#"
[statics]
want="any"
[[body]]
name="b0"
mass=1.24
center=[0.229, 0.122, -0.363]
inertia=[0.0127, 0.0127, 0.0127]
markers={m=[0.448, 0.979, 0.744],k=[0.331, -0.109, -0.153]}
hinge={type="cylindrical", at=[0.913, 0.125, 0.0377], axis=[0.783, -0.132, -0.607], stiffness=[223, 1], rest=[-0.869, -0.869], position=[-1.31, 1.09]}
[[body]]
name="b1"
mass=0.121
center=[-0.0347, 0.0861, 0.172]
inertia=[0.000466, 0.000466, 0.000466]
markers={m=[0.863, 0.565, -0.163],k=[-0.0421, 0.561, 0.513]}
hinge={type="revolute", at=[-0.222, -0.0319, 0.966], axis=[0.771, 0.354, 0.529], position=[-1.8]}
[[body]]
name="b2"
mass=0.285
center=[0.0784, -0.462, 0.373]
inertia=[3.35e-05, 3.35e-05, 3.35e-05]
markers={m=[-0.309, -0.713, -0.289],k=[-0.667, 0.221, -0.472]}
hinge={type="universal", parent="b0", at="m", axes=[[-0.0335, 0.0717, -0.997],[0.111, -0.991, -0.075]], position=[-1.55, -1.56]}
[[force]]
type="spring"
between=["b1.m","b2.k"]
stiffness=31.4
length=0.187
[[force]]
type="spring"
between=["b1.m","b2.k"]
stiffness=4.27e+11
length=0.17
"#;

const DEEP: &str = r#"
[statics]
want="stable"
[[body]]
name="b0"
mass=0.202
center=[0.0617, -0.353, -0.147]
inertia=[0.000205, 0.000205, 0.000205]
markers={m=[-0.451, -0.824, -0.575],k=[0.518, 0.429, -0.667]}
hinge={type="free", at=[0.6533768, 0.4764671, 0.8042917], position=[0.1, 0.2, 0.3, 0.673524, 0.6688792, 0.06269088, 0.308279]}
[[force]]
type="spring"
between=[{body="b0",at=[0.861, -0.0592, 0.865]},{body="ground",at=[0.795, -1.63, 1.94]}]
stiffness=40.8
length=0.626
[[force]]
type="spring"
between=[{body="b0",at=[-0.227, -0.173, -0.0311]},{body="ground",at=[0.243, -1.37, 0.844]}]
stiffness=41.7
length=0.439
[[force]]
type="spring"
between=[{body="b0",at=[0.425, -0.298, 0.501]},{body="ground",at=[0.203, -1.43, -0.689]}]
stiffness=54.9
length=0.424
[[force]]
type="spring"
between=[{body="b0",at=[0.564, -0.753, 0.259]},{body="ground",at=[1.31, -1.36, -0.436]}]
stiffness=9.2
length=0.838
[[body]]
name="b1"
mass=3.26e+06
center=[-0.138, -0.397, -0.0853]
inertia=[1.34e+04, 1.34e+04, 1.34e+04]
markers={m=[0.581, -0.0955, 0.529],k=[-0.203, 0.647, 0.379]}
hinge={type="revolute", at=[0.17, -0.15, 0.375], axis=[-0.916, 0.183, -0.358], position=[-1.95]}
[[body]]
name="b2"
mass=6.68e+05
center=[-0.404, -0.28, -0.476]
inertia=[125, 125, 125]
markers={m=[0.877, 0.717, 0.298],k=[-0.564, -0.0461, -0.866]}
hinge={type="planar", parent="b0", at="m", stiffness=[8.29e+07, 8.48e+07, 1], rest=[0.433, 0.433, 0.433], position=[0.981, 0.0249, -1.12]}
[[body]]
name="b3"
mass=4.55e+06
center=[-0.423, -0.0135, -0.457]
inertia=[9.26e+04, 9.26e+04, 9.26e+04]
markers={m=[-0.615, 0.172, 0.0709],k=[0.00403, 0.642, 0.338]}
hinge={type="planar", parent="b0", at="m", stiffness=[2.78e+08, 6.86e+08, 1], rest=[-0.343, -0.343, -0.343], position=[0.601, 0.602, 1.66]}
[[body]]
name="b4"
mass=8.93
center=[0.16, 0.0268, -0.426]
inertia=[0.0123, 0.0123, 0.0123]
markers={m=[-0.8, 0.727, 0.327],k=[-0.629, -0.31, 0.392]}
hinge={type="revolute", parent="b2", at="m", axis=[-0.896, 0.31, 0.318], position=[1.11]}
[[body]]
name="b5"
mass=1.02
center=[0.292, 0.453, 0.273]
inertia=[0.00428, 0.00428, 0.00428]
markers={m=[0.724, -0.67, -0.271],k=[-0.896, -0.707, 0.337]}
hinge={type="revolute", parent="b3", at="m", axis=[-0.439, 0.75, 0.495], position=[1.41]}
[[body]]
name="b6"
mass=1.01e+05
center=[0.321, -0.169, 0.186]
inertia=[537, 537, 537]
markers={m=[0.552, 0.587, -0.963],k=[-0.416, -0.507, -0.914]}
hinge={type="spherical", parent="b4", at="m", position=[0.3132416, 0.2355753, -0.1674917, 0.9046162]}
[[force]]
type="spring"
between=["b2.m","b3.k"]
stiffness=16.5
length=0.645
[[force]]
type="load"
on="b5.m"
force=[-11.4, 7.02, -14.1]
"#;
