//! The cases of a sweep.

/// One number that is varied.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Axis {
    /// As after `--set`.
    pub(super) path: String,
    /// As written in a file.
    pub(super) values: Vec<String>,
}

/// More cases than this are a slip of the finger.
const MOST_CASES: usize = 1_000_000;

impl Axis {
    /// Reads `path=from:to:count` (both ends belong to it) or `path=1,2,5`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let (path, values) =
            text.split_once('=').ok_or("write a path and values: arm.mass=1:5:9, or arm.mass=1,2,5")?;
        let (path, values) = (path.trim(), values.trim());
        if path.is_empty() || values.is_empty() {
            return Err("write a path and values: arm.mass=1:5:9, or arm.mass=1,2,5".to_owned());
        }
        let values = match values.split(':').collect::<Vec<_>>()[..] {
            [from, to, count] => range(from, to, count)?,
            [list] => split_list(list),
            _ => return Err("a range is from:to:count".to_owned()),
        };
        Ok(Self { path: path.to_owned(), values })
    }
}

/// At the commas outside of brackets and quotes, so that a value may be a list: `gravity=[0,0,-9.81],[0,0,-1.62]`.
fn split_list(list: &str) -> Vec<String> {
    let (mut values, mut depth, mut quote) = (vec![String::new()], 0_usize, None);
    for letter in list.chars() {
        match (quote, letter) {
            (Some(open), close) if open == close => quote = None,
            (None, '"' | '\'') => quote = Some(letter),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            (None, ',') if depth == 0 => {
                values.push(String::new());
                continue;
            }
            _ => {}
        }
        values.last_mut().into_iter().for_each(|value| value.push(letter));
    }
    values.iter().map(|value| value.trim().to_owned()).collect()
}

/// A range of numbers, in one unit where they have one: both ends have the same.
fn range(from: &str, to: &str, count: &str) -> Result<Vec<String>, String> {
    let ([from, from_unit], [to, to_unit]) = (split_unit(from), split_unit(to));
    if from_unit != to_unit {
        return Err(format!("both ends of a range have the same unit: `{from_unit}` is not `{to_unit}`"));
    }
    let number = |text: &str| match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is not a number")),
    };
    let (from, to) = (number(from)?, number(to)?);
    let count: usize = match count.trim().parse() {
        Ok(count) if (1..=MOST_CASES).contains(&count) => count,
        _ => return Err(format!("`{count}` is not a number of cases from 1 to {MOST_CASES}")),
    };
    // Both ends come out as they are given.
    let value = |k: usize| match k {
        0 => from,
        k if k + 1 == count => to,
        k => from + (to - from) * (k as f64 / (count - 1) as f64),
    };
    Ok((0..count).map(|k| format!("{:?} {from_unit}", value(k)).trim_end().to_owned()).collect())
}

/// `45 deg` → `45` and `deg`.
fn split_unit(text: &str) -> [&str; 2] {
    let text = text.trim();
    match text.split_once(' ') {
        Some((number, unit)) => [number, unit.trim()],
        None => [text, ""],
    }
}

/// Every combination, the last axis moving fastest.
pub(super) fn cases(axes: &[Axis]) -> Result<Vec<Vec<&str>>, String> {
    let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
    if count.is_none_or(|count| count > MOST_CASES) {
        return Err(format!("these are more than {MOST_CASES} cases"));
    }
    let mut cases = vec![Vec::new()];
    for axis in axes {
        let extended = cases.iter().flat_map(|case: &Vec<&str>| {
            axis.values.iter().map(|value| case.iter().copied().chain([value.as_str()]).collect())
        });
        cases = extended.collect();
    }
    Ok(cases)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_both_ends_and_lists_stay_as_written() {
        let axis = Axis::parse("a.mass=1:2:3").expect("a range");
        assert_eq!((axis.path.as_str(), axis.values), ("a.mass", ["1.0", "1.5", "2.0"].map(String::from).to_vec()));
        assert_eq!(Axis::parse("a=0.1:0.3:3").expect("a range").values[2], "0.3");
        assert_eq!(Axis::parse("s = any, stable").expect("a list").values, ["any", "stable"]);
        assert_eq!(Axis::parse("g=[0,0,-1],[0, 0, 2]").expect("lists").values, ["[0,0,-1]", "[0, 0, 2]"]);
        assert_eq!(Axis::parse("a=0 deg:90 deg:3").expect("a range").values, ["0.0 deg", "45.0 deg", "90.0 deg"]);
        for wrong in ["a", "=1", "a=", "a=1:2", "a=1:2:0", "a=1:x:3", "a=1:2:3:4", "a=nan:1:2", "a=0 deg:1:3"] {
            assert!(Axis::parse(wrong).is_err(), "{wrong}");
        }
        let axes = [Axis::parse("a=1,2").expect("a list"), Axis::parse("b=3,4").expect("a list")];
        assert_eq!(cases(&axes).expect("few"), [["1", "3"], ["1", "4"], ["2", "3"], ["2", "4"]]);
    }
}
