//! Protobuf schemas of the numeric channels, made for one scene.

use super::names;
use super::numbers::field_number;
use crate::record::Scene;
use crate::record::scene::Channel;
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::collections::BTreeMap;

/// A channel's schema and what its metadata says of its fields.
pub(super) struct Schema {
    /// Full name of the message type.
    pub(super) name: &'static str,
    /// Encoded `FileDescriptorSet`.
    pub(super) data: Vec<u8>,
    /// Field name → name in the scenario and unit.
    pub(super) fields: BTreeMap<String, String>,
}

/// `/hinges`.
pub(super) fn hinges(scene: &Scene) -> Schema {
    let positions = names::channel_fields(&scene.positions);
    let velocities = names::channel_fields(&scene.velocities);
    let mut fields = BTreeMap::new();
    for (field, channel) in positions.iter().zip(&scene.positions) {
        fields.insert(format!("positions.{field}"), format!("{}.{} [{}]", channel.body, channel.name, channel.unit));
    }
    for (field, channel) in velocities.iter().zip(&scene.velocities) {
        let name = format!("{}.{}", channel.body, channel.name);
        fields.insert(format!("velocities.{field}"), format!("{name} [{}]", channel.unit));
        fields.insert(format!("accelerations.{field}"), format!("{name} [{}/s]", channel.unit));
    }
    let messages = vec![
        numbers("Positions", &positions),
        numbers("Velocities", &velocities),
        DescriptorProto {
            name: Some("Hinges".into()),
            field: vec![
                number("time", 0),
                nested("positions", 1, "Positions"),
                nested("velocities", 2, "Velocities"),
                nested("accelerations", 3, "Velocities"),
            ],
            ..Default::default()
        },
    ];
    Schema { name: "stillpoint.Hinges", data: encode("stillpoint/hinges.proto", messages), fields }
}

/// `/energy`.
pub(super) fn energy() -> Schema {
    let names = ["time", "kinetic", "potential", "work", "dissipated", "error"].map(String::from);
    let unit = |name: &String| (name.clone(), if name == "time" { "time [s]".into() } else { format!("{name} [J]") });
    Schema {
        name: "stillpoint.Energy",
        data: encode("stillpoint/energy.proto", vec![numbers("Energy", &names)]),
        fields: names.iter().map(unit).collect(),
    }
}

/// `/couplings`.
pub(super) fn couplings(scene: &Scene) -> Schema {
    let said = |channel: &Channel| {
        let free = scene.not_unique.contains(&channel.body) && channel.name != "gap";
        let remark = if free { ", not unique: the smallest that balances" } else { "" };
        format!("{}.{} [{}]{remark}", channel.body, channel.name, channel.unit)
    };
    let (fields, names) = timed(&scene.couplings, said);
    let data = encode("stillpoint/couplings.proto", vec![numbers("Couplings", &names)]);
    Schema { name: "stillpoint.Couplings", data, fields }
}

/// `/outputs`.
pub(super) fn outputs(scene: &Scene) -> Schema {
    let (fields, names) = timed(&scene.outputs, |channel| format!("{} [{}]", channel.name, channel.unit));
    let data = encode("stillpoint/outputs.proto", vec![numbers("Outputs", &names)]);
    Schema { name: "stillpoint.Outputs", data, fields }
}

/// The fields of a message of the time and the numbers of channels: what is said of each, and their names in order.
fn timed(channels: &[Channel], said: impl Fn(&Channel) -> String) -> (BTreeMap<String, String>, Vec<String>) {
    let mut names = vec!["time".to_owned()];
    names.extend(names::channel_fields(channels));
    // The field of a channel that is called as the time is gets a number.
    names = names::fields(names);
    let mut fields = BTreeMap::from([("time".to_owned(), "time [s]".to_owned())]);
    fields.extend(names[1..].iter().cloned().zip(channels.iter().map(said)));
    (fields, names)
}

/// `/reactions`.
pub(super) fn reactions(scene: &Scene) -> Schema {
    let names = names::fields(scene.bodies.iter().map(|body| body.name.clone()));
    let fields = names.iter().zip(&scene.bodies).map(|(field, body)| {
        (field.clone(), format!("{}: hinge force [N] and moment [N m] at the root marker, inertial axes", body.name))
    });
    let fields = fields.collect();
    let bodies = names.iter().enumerate().map(|(index, name)| nested(name, index, "Wrench")).collect();
    let messages = vec![
        numbers("Vector", &["x", "y", "z"].map(String::from)),
        DescriptorProto {
            name: Some("Wrench".into()),
            field: vec![nested("force", 0, "Vector"), nested("moment", 1, "Vector")],
            ..Default::default()
        },
        DescriptorProto { name: Some("Reactions".into()), field: bodies, ..Default::default() },
    ];
    Schema { name: "stillpoint.Reactions", data: encode("stillpoint/reactions.proto", messages), fields }
}

fn numbers(name: &str, fields: &[String]) -> DescriptorProto {
    let field = fields.iter().enumerate().map(|(index, field)| number(field, index)).collect();
    DescriptorProto { name: Some(name.into()), field, ..Default::default() }
}

fn number(name: &str, index: usize) -> FieldDescriptorProto {
    field(name, index, Type::Double, None)
}

fn nested(name: &str, index: usize, message: &str) -> FieldDescriptorProto {
    field(name, index, Type::Message, Some(format!(".stillpoint.{message}")))
}

fn field(name: &str, index: usize, kind: Type, type_name: Option<String>) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(field_number(index) as i32),
        label: Some(Label::Optional as i32),
        r#type: Some(kind as i32),
        type_name,
        ..Default::default()
    }
}

fn encode(file: &str, message_type: Vec<DescriptorProto>) -> Vec<u8> {
    let file = FileDescriptorProto {
        name: Some(file.into()),
        package: Some("stillpoint".into()),
        message_type,
        syntax: Some("proto3".into()),
        ..Default::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}
