//! Inputs that ask for more than they may: each is refused with the number of its budget, before it costs.

use crate::common::Random;
use std::fmt::Write;
use std::path::Path;
use stillpoint::budget;
use stillpoint::import::Options;
use stillpoint::mesh::Mesh;
use stillpoint::record::Recording;
use stillpoint::scenario::{convert_text, parse};

fn refused(text: &str) -> String {
    let options = Options::default();
    convert_text(Path::new("robot.urdf"), text.to_owned(), &options).expect_err("too much").to_string()
}

#[test]
fn entities_that_grow_are_refused_however_they_are_nested() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let levels = 1 + random.below(8);
        let most = budget::XML_ENTITY_BYTES as f64;
        // So many uses at every level that the whole is some times the budget.
        let uses = (3.0 * most / 10.0).powf(1.0 / (levels + 1) as f64).ceil() as usize;
        let mut text = String::from("<!DOCTYPE r [<!ENTITY e0 'ten bytes.'>");
        for level in 1..=levels {
            let quote = if random.below(2) == 0 { '"' } else { '\'' };
            let _ = write!(text, "<!ENTITY e{level} {quote}{}{quote}>", format!("&e{};", level - 1).repeat(uses));
        }
        let _ = write!(text, "]><robot name='r'><link name='{}'/></robot>", format!("&e{levels};").repeat(uses));
        let said = refused(&text);
        assert!(said.contains(&budget::XML_ENTITY_BYTES.to_string()), "{seed}: {said}");
    }
}

#[test]
fn bodies_are_counted_before_any_is_made() {
    let one = |index: usize| {
        format!(
            "[[body]]\nname = \"b{index}\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\nrepeat = 1000000\nhinge = {{ type = \"free\" }}\n"
        )
    };
    let text: String = (0..100).map(one).collect();
    let said = parse("s.toml", &text, &[]).expect_err("too many").to_string();
    assert!(said.contains(&budget::BODIES.to_string()), "{said}");
}

#[test]
fn contacts_of_a_model_that_no_pattern_says_are_counted() {
    // Two crowds, and nobody meets their own: as many pairs as the product.
    let model = |of_each: usize| {
        let ball = |k: usize| {
            let (own, other) = if k.is_multiple_of(2) { (1, 2) } else { (2, 4) };
            format!(
                "<body name=\"b{k}\"><freejoint/><geom size=\"0.1\" contype=\"{own}\" conaffinity=\"{other}\"/></body>"
            )
        };
        let balls: String = (0..2 * of_each).map(ball).collect();
        format!("<mujoco><worldbody>{balls}</worldbody></mujoco>")
    };
    let options = Options { contact: true, ..Options::default() };
    let read = |of_each: usize| convert_text(Path::new("model.xml"), model(of_each), &options);
    assert_eq!(read(20).expect("few").scenario.matches("[[contact]]").count(), 400);
    let said = read(101).expect_err("too many").to_string();
    assert!(said.contains(&format!("more than {} pairs", budget::CONTACTS)), "{said}");
}

#[test]
fn thousands_of_misspelt_names_are_all_problems_and_the_first_ones_get_a_suggestion() {
    let mut text = String::new();
    for k in 0..5000 {
        let parent = if k == 0 { "ground".to_owned() } else { format!("bdoy_number_{}", k - 1) };
        let _ = write!(
            text,
            "[[body]]\nname = \"body_number_{k}\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\nhinge = {{ type = \"free\", parent = \"{parent}\" }}\n"
        );
    }
    let problems = parse("s.toml", &text, &[]).expect_err("unknown parents");
    assert_eq!(problems.errors(), 4999);
    let helped =
        problems.iter().filter(|one| one.help.as_ref().is_some_and(|help| help.contains("did you mean"))).count();
    assert!((1..=budget::SUGGESTIONS).contains(&helped), "{helped}");
}

/// Nodes that each stand twice in the one above: `levels` of them draw the mesh 2^levels times.
fn shared_nodes(levels: usize, primitives: usize) -> String {
    let node = |k: usize| match k == levels {
        true => "{\"mesh\":0}".to_owned(),
        false => format!("{{\"children\":[{0},{0}]}}", k + 1),
    };
    let nodes: Vec<String> = (0..=levels).map(node).collect();
    let primitive = vec!["{\"attributes\":{\"POSITION\":0}}"; primitives].join(",");
    // Three corners at the origin.
    let data = "A".repeat(48);
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{}],\
         \"meshes\":[{{\"primitives\":[{primitive}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
         \"min\":[0,0,0],\"max\":[0,0,0]}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\
         \"buffers\":[{{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,{data}\"}}]}}",
        nodes.join(",")
    )
}

#[test]
fn parts_of_a_mesh_count_as_often_as_they_stand_in_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.gltf");
    let read = |text: String| {
        std::fs::write(&path, text).expect("written");
        Mesh::read(&path)
    };
    assert_eq!(read(shared_nodes(5, 2)).expect("a mesh").triangles.len(), 64);
    for (levels, primitives) in [(30, 1), (60, 3), (98, 1), (15, 200), (24, 1)] {
        let said = read(shared_nodes(levels, primitives)).expect_err("too much").to_string();
        assert!(said.contains(&budget::MESH_NODES.to_string()), "{said}");
    }
}

/// A recording whose one chunk says what its arguments say.
fn forged(size: u64, compression: &[u8], claimed: u32) -> Vec<u8> {
    let mut chunk = vec![0; 16];
    chunk.extend(size.to_le_bytes());
    chunk.extend([0; 4]);
    chunk.extend(claimed.to_le_bytes());
    chunk.extend(compression);
    chunk.extend(0_u64.to_le_bytes());
    let mut bytes = mcap::MAGIC.to_vec();
    bytes.push(6);
    bytes.extend((chunk.len() as u64).to_le_bytes());
    bytes.extend(chunk);
    bytes
}

#[test]
fn lengths_that_claim_more_than_there_is_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("f.mcap");
    let whole = folder.path().join("whole.mcap");
    crate::record::fixture::record(&whole, &crate::record::fixture::Motion::double_link(), 0.1);
    let whole = std::fs::read(&whole).expect("read");
    let from = forged(0, b"", 0).len();
    assert!(from > 8);
    for (size, compression, claimed) in
        [(0, &b""[..], u32::MAX), (4 << 30, b"zstd", 4), (u64::MAX, b"", 0), (budget::CHUNK_BYTES + 1, b"lz4", 3)]
    {
        // Behind a description that is fine: the chunk is met, and nothing of it is believed.
        let mut bytes = whole.clone();
        let end = bytes.windows(9).rposition(|window| window[0] == 0x0f).unwrap_or(bytes.len() / 2);
        bytes.truncate(end);
        bytes.extend(&forged(size, compression, claimed)[8..]);
        std::fs::write(&path, &bytes).expect("written");
        let Ok(recording) = Recording::open(&path) else { continue };
        assert!(!recording.complete);
        let survey = recording.survey().expect("read");
        assert!(survey.damage.is_some() || !recording.complete, "{survey:?}");
        let _ = recording.recover(&folder.path().join("saved.mcap"));
    }
}

/// Whatever the number is: masses, lengths, springs, gravity, from a file, a command line or a start.
#[test]
fn numbers_whose_squares_overflow_are_refused_with_their_name() {
    let scene = "gravity = [0, 0, -9.81]\n[[body]]\nname = \"rod\"\nmass = 1.5\ncenter = [0.25, 0, 0]\ninertia = [1.25, 1.25, 1.125]\n\
        hinge = { type = \"revolute\", axis = [0, 1, 0], stiffness = 2.5, damping = 0.5, position = 0.75 }\n\
        [[force]]\nname = \"tip\"\ntype = \"load\"\non = \"rod\"\nforce = [0, 3.5, 0]\n";
    parse("rod.toml", scene, &[]).expect("a sound scene");
    let keys = [("-9.81", "gravity"), ("1.5", "mass"), ("0.25", "center"), ("1.125", "inertia"), ("2.5", "stiffness")];
    for (number, key) in keys.into_iter().chain([("0.75", "position"), ("3.5", "force")]) {
        let mut random = Random::new(number.len() as u64);
        for _ in 0..5 {
            let exponent = random.between(154.1, 307.0);
            let large = format!("{:e}", 10_f64.powf(exponent));
            let said = parse("rod.toml", &scene.replacen(number, &large, 1), &[]).expect_err("too large").to_string();
            assert!(said.contains(&format!("{:e}", budget::LARGEST)) && said.contains(key), "{key} = {large}: {said}");
        }
        let fine = scene.replacen(number, "1e49", 1);
        assert!(!parse("rod.toml", &fine, &[]).is_err_and(|said| said.to_string().contains("in size")), "{key}");
    }
    // From other programs, without a scenario.
    let mut scenario = parse("rod.toml", scene, &[]).expect("a sound scene");
    scenario.description.bodies[0].mass.mass = 1e160;
    let problems = stillpoint::model::Model::build(&scenario.description).expect_err("too large");
    assert!(problems[0].message.contains("`rod`") && problems[0].message.contains('1'), "{problems:?}");
}
