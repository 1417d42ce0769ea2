//! "Did you mean": the known name nearest to one that is not known.

use crate::budget;
use strsim::osa_distance;

/// The known name nearest to `wanted`, if it is near enough to be what was meant.
///
/// Near is measured in inserted, removed, replaced and swapped neighbouring characters (optimal string alignment), letter
/// case aside: at most one for every three characters of the longer name. Of equally near names the first wins. Of very
/// many names the first [`SUGGESTED_NAMES`](budget::SUGGESTED_NAMES) are looked at, and a name longer than
/// [`SUGGESTED_LENGTH`](budget::SUGGESTED_LENGTH) is no slip of the finger.
///
/// ```
/// use stillpoint::suggest::closest;
/// assert_eq!(closest("stifness", ["damping", "stiffness"].into_iter()), Some("stiffness"));
/// assert_eq!(closest("colour", ["damping", "stiffness"].into_iter()), None);
/// ```
pub fn closest<'a>(wanted: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    if wanted.len() > budget::SUGGESTED_LENGTH {
        return None;
    }
    let wanted = wanted.to_lowercase();
    let length = wanted.chars().count();
    let mut best: Option<(usize, &'a str)> = None;
    let short = |name: &&str| name.len() <= budget::SUGGESTED_LENGTH;
    for name in known.take(budget::SUGGESTED_NAMES).filter(short) {
        let lower = name.to_lowercase();
        let letters = lower.chars().count();
        let near_enough = (length.max(letters) / 3).max(1);
        let limit = best.map_or(near_enough, |(distance, _)| near_enough.min(distance.saturating_sub(1)));
        if length.abs_diff(letters) > limit {
            continue;
        }
        let distance = osa_distance(&wanted, &lower);
        if distance <= limit && best.is_none_or(|(least, _)| distance < least) && distance < letters {
            best = Some((distance, name));
        }
    }
    best.map(|(_, name)| name)
}

/// The [`closest`] name for the problem that comes after `before` others of its kind: if very many names are wrong, the last ones
/// get no suggestion. Each costs a comparison with all known names.
pub fn closest_of_many<'a>(before: usize, wanted: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    if before < budget::SUGGESTIONS { closest(wanted, known) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn among(wanted: &str, known: &[&'static str]) -> Option<&'static str> {
        closest(wanted, known.iter().copied())
    }

    #[test]
    fn finds_slips_of_the_finger() {
        assert_eq!(among("mas", &["name", "mass"]), Some("mass"));
        assert_eq!(among("hnige", &["mass", "hinge"]), Some("hinge"));
        assert_eq!(among("Gravity", &["gravity"]), Some("gravity"));
        assert_eq!(among("link[3]", &["link[0]", "upper"]), Some("link[0]"));
    }

    #[test]
    fn leaves_strangers_alone() {
        assert_eq!(among("x", &["y"]), None);
        assert_eq!(among("", &["mass"]), None);
        assert_eq!(among("wheel", &["hinge", "mass"]), None);
    }
}
