//! The format as a JSON Schema, for editors.

use super::fields::{Key, Kind, Range, Table};
use super::format::SCENARIO;
use serde_json::{Map, Value, json};

/// JSON Schema (draft 2020-12) of scenario files, from the same declarations that check them.
pub fn schema() -> Value {
    let mut schema = of_table(&SCENARIO);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("stillpoint scenario");
    schema
}

fn of_table(table: &Table) -> Value {
    if table.types.is_empty() {
        return object(table, None);
    }
    let variants: Vec<Value> = table.types.iter().map(|(name, doc)| object(table, Some((name, doc)))).collect();
    json!({ "description": table.doc, "oneOf": variants })
}

fn object(table: &Table, of_type: Option<(&str, &str)>) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    if let Some((name, doc)) = of_type {
        properties.insert("type".to_owned(), json!({ "const": name, "description": doc }));
        required.push("type");
    }
    let keys = table.keys.iter().filter(|key| of_type.is_none_or(|(name, _)| key.belongs_to(name)));
    for key in keys.filter(|key| !matches!(key.kind, Kind::Refused(_))) {
        properties.insert(key.name.to_owned(), of_key(key));
        if key.required {
            required.push(key.name);
        }
    }
    json!({
        "type": "object",
        "description": of_type.map_or(table.doc, |(_, doc)| doc),
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn of_key(key: &Key) -> Value {
    let mut schema = of_kind(&key.kind);
    if key.kind.elements().is_some() {
        schema["minItems"] = json!(0);
    }
    let unit = if key.unit.is_empty() { String::new() } else { format!(" [{}]", key.unit) };
    schema["description"] = json!(format!("{}{unit}", key.doc));
    for (name, text) in [("default", key.default), ("examples", key.example)] {
        let Some(value) = json_value(text) else { continue };
        schema[name] = if name == "examples" { json!([value]) } else { value };
    }
    schema
}

/// A value as written in a file, in JSON.
fn json_value(text: &str) -> Option<Value> {
    let table: toml::Table = toml::from_str(&format!("value = {text}")).ok()?;
    serde_json::to_value(table.get("value")?).ok()
}

fn of_kind(kind: &Kind) -> Value {
    match kind {
        Kind::Text => json!({ "type": "string" }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Integer(range) => ranged("integer", *range),
        Kind::Number(range) => number_or_text(*range),
        Kind::Choice(words) => {
            let words: Vec<Value> =
                words.iter().map(|(word, doc)| json!({ "const": word, "description": doc })).collect();
            json!({ "oneOf": words })
        }
        Kind::List(of, lengths) => list(of, lengths),
        Kind::Either(kinds) => either(kinds.iter().map(of_kind).collect()),
        Kind::Table(table) => of_table(table),
        Kind::Map(of) => json!({ "type": "object", "additionalProperties": of_kind(of) }),
        Kind::Refused(_) => json!(false),
    }
}

/// One of several. Where they differ in type it is one schema of all those types, for what is asked of objects does not
/// concern text: then a validator names the wrong key, and not only that nothing fits.
fn either(kinds: Vec<Value>) -> Value {
    let (mut types, mut together) = (Vec::new(), Map::new());
    for kind in kinds.iter().filter_map(Value::as_object) {
        for (key, value) in kind {
            match key.as_str() {
                "type" => types.push(value.clone()),
                _ if together.contains_key(key) => return json!({ "anyOf": kinds }),
                _ => drop(together.insert(key.clone(), value.clone())),
            }
        }
    }
    let differ = types.iter().all(|one| one.is_string() && types.iter().filter(|other| *other == one).count() == 1);
    if types.len() < kinds.len() || !differ {
        return json!({ "anyOf": kinds });
    }
    together.insert("type".to_owned(), Value::Array(types));
    Value::Object(together)
}

fn list(of: &Kind, lengths: &[usize]) -> Value {
    let of_length =
        |length: &usize| json!({ "type": "array", "items": of_kind(of), "minItems": length, "maxItems": length });
    match lengths {
        [] => json!({ "type": "array", "items": of_kind(of), "minItems": 1 }),
        [length] => of_length(length),
        several => json!({ "anyOf": several.iter().map(of_length).collect::<Vec<_>>() }),
    }
}

/// Quantities with units and formulas of parameters begin like a number or hold a brace.
const TEXTS: &str = "^\\s*[-+−]?\\s*[0-9.]|\\{";

fn number_or_text(range: Range) -> Value {
    let mut schema = ranged("number", range);
    schema["type"] = json!(["number", "string"]);
    schema["pattern"] = json!(TEXTS);
    schema
}

fn ranged(of_type: &str, range: Range) -> Value {
    match range {
        Range::Any => json!({ "type": of_type }),
        Range::AtLeast(low) => json!({ "type": of_type, "minimum": low }),
        Range::Above(low) => json!({ "type": of_type, "exclusiveMinimum": low }),
        Range::Between(low, high) => json!({ "type": of_type, "minimum": low, "maximum": high }),
    }
}
