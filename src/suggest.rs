//! "Did you mean": the known name nearest to one that is not known.

/// The known name nearest to `wanted`, if it is near enough to be what was meant.
///
/// Near is measured in inserted, removed, replaced and swapped neighbouring characters, letter case aside: at most one
/// for every three characters of the longer name. Of equally near names the first wins.
///
/// ```
/// use stillpoint::suggest::closest;
/// assert_eq!(closest("stifness", ["damping", "stiffness"].into_iter()), Some("stiffness"));
/// assert_eq!(closest("colour", ["damping", "stiffness"].into_iter()), None);
/// ```
pub fn closest<'a>(wanted: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = letters(wanted);
    let mut best: Option<(usize, &'a str)> = None;
    for name in known {
        let letters = letters(name);
        let near_enough = (wanted.len().max(letters.len()) / 3).max(1);
        let limit = best.map_or(near_enough, |(distance, _)| near_enough.min(distance.saturating_sub(1)));
        if wanted.len().abs_diff(letters.len()) > limit {
            continue;
        }
        let distance = distance(&wanted, &letters);
        if distance <= limit && best.is_none_or(|(least, _)| distance < least) && distance < letters.len() {
            best = Some((distance, name));
        }
    }
    best.map(|(_, name)| name)
}

fn letters(name: &str) -> Vec<char> {
    name.chars().flat_map(char::to_lowercase).collect()
}

/// Edits between two names, a swap of neighbours counting once (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before_last = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
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
