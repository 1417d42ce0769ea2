//! One axis of a grid: a number of the scene and the values that it takes.

use crate::quantity::Quantity;

/// One number that is varied.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// As after `--set`.
    pub path: String,
    /// As written in a file.
    pub values: Vec<String>,
}

/// More values of one number than this are a slip of the finger.
const MOST_VALUES: usize = 1_000_000;

/// The option that is read here, as messages name it.
pub const OPTION: &str = "--over";

const EXAMPLES: &str = "write a path and values: arm.mass=1:5:9, or arm.mass=1,2,5";

impl Axis {
    /// Reads `path=from:to:count` (both ends belong to it) or `path=1,2,5`; the values may stand in quotes, together or each
    /// for itself: `arm.position="0 deg:90 deg:3"`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (path, written) = text.split_once('=').ok_or(EXAMPLES)?;
        let (path, written) = (path.trim(), written.trim());
        if path.is_empty() || written.is_empty() {
            return Err(EXAMPLES.to_owned());
        }
        let inner = unquoted(written).filter(|inner| is_quantities(inner)).unwrap_or(written);
        let values = match split(inner, ':')[..] {
            [from, to, count] => range(from, to, count)?,
            [list] => split(list, ',').into_iter().map(str::to_owned).collect(),
            _ => return Err("a range is from:to:count".to_owned()),
        };
        if values.iter().any(String::is_empty) {
            return Err(format!("a value is missing in `{written}`"));
        }
        have_units_together(&values)?;
        Ok(Self { path: path.to_owned(), values })
    }

    /// Its values as numbers, in SI units; `None` if one of them is none.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let number = |text: &String| Quantity::parse(word(text)).ok().map(|found| found.value);
        self.values.iter().map(number).collect()
    }
}

/// A value as it is meant: without the quotes in which it may be written.
pub fn word(text: &str) -> &str {
    unquoted(text).unwrap_or(text)
}

/// The inside of a text that is one pair of quotes.
fn unquoted(text: &str) -> Option<&str> {
    let quote = text.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
    text.strip_prefix(quote)?.strip_suffix(quote).filter(|inner| !inner.contains(quote))
}

/// Whether a text is a range or a list of numbers with or without units, and not a value by itself.
fn is_quantities(text: &str) -> bool {
    let parts: Vec<&str> = text.split([':', ',']).collect();
    let begins = |part: &&str| part.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-−.".contains(c));
    parts.len() > 1 && parts.iter().all(begins)
}

/// At the separators outside of brackets and quotes, so that a value may be a list: `gravity=[0,0,-9.81],[0,0,-1.62]`.
fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut values, mut start, mut depth, mut quote) = (Vec::new(), 0, 0_usize, None);
    for (at, letter) in text.char_indices() {
        match (quote, letter) {
            (Some(open), close) if open == close => quote = None,
            (None, '"' | '\'') => quote = Some(letter),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            (None, letter) if letter == separator && depth == 0 => {
                values.push(text[start..at].trim());
                start = at + letter.len_utf8();
            }
            _ => {}
        }
    }
    values.push(text[start..].trim());
    values
}

/// Refuses a list in which some numbers have units and others none: one unit after the last number reads as that of all.
fn have_units_together(values: &[String]) -> Result<(), String> {
    let unit = |value: &String| {
        let text = word(value);
        Quantity::parse(text).ok().map(|found| text[found.unit_start..].trim().to_owned())
    };
    let Some(units) = values.iter().map(unit).collect::<Option<Vec<_>>>() else { return Ok(()) };
    let Some(bare) = units.iter().position(String::is_empty) else { return Ok(()) };
    let Some(with) = units.iter().rposition(|unit| !unit.is_empty()) else { return Ok(()) };
    let (number, other, unit) = (word(&values[bare]), word(&values[with]), &units[with]);
    let comma = match values {
        [_, _] => "; in a number with decimals the point is `.`",
        _ => "",
    };
    Err(format!(
        "`{number}` has no unit, and `{other}` has one: write the unit on each value, as `{number} {unit},{other}`{comma}"
    ))
}

/// A range of numbers, in one unit where they have one: both ends have the same.
fn range(from: &str, to: &str, count: &str) -> Result<Vec<String>, String> {
    let [from, to] = [from, to].map(word);
    let ([from, from_unit], [to, to_unit]) = (split_unit(from), split_unit(to));
    if from_unit != to_unit {
        return Err(format!("both ends of a range have the same unit: `{from_unit}` is not `{to_unit}`"));
    }
    let number = |text: &str| match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is not a number")),
    };
    let (written, from, to) = ([from, to], number(from)?, number(to)?);
    let count: usize = match count.trim().parse() {
        Ok(count) if (1..=MOST_VALUES).contains(&count) => count,
        _ => return Err(format!("`{count}` is not a number of cases from 1 to {MOST_VALUES}")),
    };
    // Both ends come out as they are given, and 0.3 between 0.1 and 0.5 as such: the last of sixteen digits is that of the sum.
    let rounded = |x: f64| format!("{x:.14e}").parse().unwrap_or(x);
    let value = |k: usize| match k {
        0 => from,
        k if k + 1 == count => to,
        k => rounded(from + (to - from) * (k as f64 / (count - 1) as f64)),
    };
    // Whole numbers stay so: there are keys that take no others.
    let whole = written.iter().all(|end| !end.contains(['.', 'e', 'E'])) && (0..count).all(|k| value(k).fract() == 0.0);
    let shown = |k: usize| if whole { format!("{:.0}", value(k)) } else { format!("{:?}", value(k)) };
    Ok((0..count).map(|k| format!("{} {from_unit}", shown(k)).trim_end().to_owned()).collect())
}

/// `45 deg` → `45` and `deg`.
fn split_unit(text: &str) -> [&str; 2] {
    let text = text.trim();
    match text.split_once(' ') {
        Some((number, unit)) => [number, unit.trim()],
        None => [text, ""],
    }
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
        assert_eq!(Axis::parse("a=0 deg:90 deg:3").expect("a range").values, ["0 deg", "45 deg", "90 deg"]);
        for quoted in ["a=\"0 deg:90 deg:3\"", "a='0 deg:90 deg:3'", "a=\"0 deg\":\"90 deg\":3"] {
            assert_eq!(Axis::parse(quoted).expect("a range").values, ["0 deg", "45 deg", "90 deg"], "{quoted}");
        }
        assert_eq!(Axis::parse("a=\"1 m, 2 m\"").expect("a list").values, ["1 m", "2 m"]);
        assert_eq!(Axis::parse("a=\"1 m\",\"2 m\"").expect("a list").values, ["\"1 m\"", "\"2 m\""]);
        assert_eq!(Axis::parse("f=\"a:b\", 'c, d'").expect("texts").values, ["\"a:b\"", "'c, d'"]);
        for (mixed, said) in [
            ("a=1,2,3 g", "`1` has no unit, and `3 g` has one: write the unit on each value, as `1 g,3 g`"),
            ("a=1 mm, 2", "`2` has no unit, and `1 mm` has one"),
            ("a=\"0, 5 deg\"", "`0` has no unit, and `5 deg` has one"),
            ("a=3,5 mm", "in a number with decimals the point is `.`"),
        ] {
            let why = Axis::parse(mixed).expect_err(mixed);
            assert!(why.contains(said), "{mixed}: {why}");
        }
        for wrong in ["a", "=1", "a=", "a=1:2", "a=1:2:0", "a=1:x:3", "a=1:2:3:4", "a=nan:1:2", "a=0 deg:1:3", "a=1,,2"]
        {
            assert!(Axis::parse(wrong).is_err(), "{wrong}");
        }
        assert_eq!(Axis::parse("a=1 mm, 2 m").expect("a list").numbers(), Some(vec![0.001, 2.0]));
        assert_eq!(Axis::parse("s=any, stable").expect("a list").numbers(), None);
    }
}
