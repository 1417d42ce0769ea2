//! Names that protobuf allows, made from names that a scenario allows.

use crate::record::scene::Channel;
use std::collections::{HashMap, HashSet};

/// Field names for hinge coordinates: `upper_angle`, `link_2_quaternion_w`.
pub(super) fn channel_fields(channels: &[Channel]) -> Vec<String> {
    fields(channels.iter().map(|channel| format!("{}_{}", channel.body, channel.name)))
}

/// Legal, distinct protobuf field names, in order.
///
/// Readers derive camel-case names too and refuse two fields that differ only in underscores and case; such pairs get
/// a number.
pub(super) fn fields(names: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut taken = HashSet::new();
    // The next number of every name that had to get one: names may be equal by the thousand.
    let mut numbers: HashMap<String, usize> = HashMap::new();
    names
        .into_iter()
        .map(|name| {
            let base = legal(&name);
            let mut candidate = base.clone();
            while !taken.insert(bare(&candidate)) {
                let number = numbers.entry(base.clone()).or_insert(2);
                candidate = format!("{base}_n{number}");
                *number += 1;
            }
            candidate
        })
        .collect()
}

/// Letters, digits and single underscores, starting with a letter.
fn legal(name: &str) -> String {
    let words: Vec<&str> = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let joined = words.join("_");
    if joined.starts_with(|c: char| c.is_ascii_alphabetic()) { joined } else { format!("n_{joined}") }
}

fn bare(name: &str) -> String {
    name.chars().filter(|c| *c != '_').collect::<String>().to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::fields;

    #[test]
    fn names_are_legal_and_distinct() {
        let given = ["link[2].angle", "link2_angle", "2nd.x", "Körper", "K rper", "", "upper arm.quaternion w"];
        let made = fields(given.map(String::from));
        assert_eq!(
            made,
            ["link_2_angle", "link2_angle_n2", "n_2nd_x", "K_rper", "K_rper_n2", "n_", "upper_arm_quaternion_w"]
        );
    }
}
