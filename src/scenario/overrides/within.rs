//! Entries within lists, and in tables within lists: `spring.curve[4][0]`, `stay.between[1].at[2]`.
//!
//! What is addressed so has to be written in the file, since it is found by its place there.

use super::super::findings::Finding;
use super::{Change, split_component, walk};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// One step from a value to one within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step<'p> {
    Key(&'p str),
    Index(usize),
}

/// Whether a path leads through a list to something within one of its entries. Names of markers and of parameters may look so.
pub(super) fn is_within_a_list(table: &DeTable<'_>, path: &str) -> bool {
    let (plain, _) = split_component(path);
    plain.contains('[') && [path, plain].iter().all(|path| walk(table, path, true).is_none()) && steps(path).is_some()
}

/// A path without the list components that are written with leading zeros: two addresses of one entry are the same text.
pub(super) fn plainly(path: &str) -> String {
    let Some(steps) = steps(path) else { return path.to_owned() };
    shown(&steps)
}

/// The value that a path leads to.
pub(super) fn value<'t, 'a>(table: &'t DeTable<'a>, path: &str) -> Option<&'t Spanned<DeValue<'a>>> {
    let steps = steps(path)?;
    let (Step::Key(first), rest) = steps.split_first()? else { return None };
    rest.iter().try_fold(table.get(*first)?, |value, step| match (step, value.get_ref()) {
        (Step::Key(key), DeValue::Table(inner)) => inner.get(*key),
        (Step::Index(index), DeValue::Array(items)) => items.get(*index),
        _ => None,
    })
}

/// Puts the value of a change where its path leads within a list.
///
/// # Errors
/// If there is no such place in what is written.
pub(super) fn put<'a>(change: &Change<'a>, table: &mut DeTable<'a>, path: &str) -> Result<(), Finding> {
    let refuse = |message: String, help: String| {
        let message = format!("`{}`: {message}", change.path);
        Err(Finding::error(change.span.clone(), message).help(help))
    };
    let whole = |to: usize, steps: &[Step<'_>]| format!("set `{}` as a whole", shown(&steps[..to]));
    let steps = steps(path).unwrap_or_default();
    let Some((Step::Key(first), rest)) = steps.split_first() else {
        return refuse("it leads nowhere".to_owned(), "write a key, and places within it in brackets".to_owned());
    };
    let Some(mut value) = table.get_mut(*first) else {
        return refuse(format!("`{first}` is not given"), whole(1, &steps));
    };
    for (place, step) in rest.iter().enumerate() {
        let before = shown(&steps[..=place]);
        let is_last = place + 1 == rest.len();
        value = match (step, value.get_mut()) {
            (Step::Index(index), DeValue::Array(items)) => {
                let count = items.len();
                match items.get_mut(*index) {
                    Some(item) => item,
                    None if count == 0 => return refuse(format!("`{before}` is empty"), whole(place + 1, &steps)),
                    None => {
                        let help = format!("its components are 0 to {}", count - 1);
                        return refuse(format!("there is no component {index} in `{before}`"), help);
                    }
                }
            }
            (Step::Key(key), DeValue::Table(inner)) => {
                if is_last && !inner.contains_key(*key) {
                    inner.insert(Spanned::new(change.span.clone(), (*key).to_owned().into()), change.value.clone());
                    return Ok(());
                }
                match inner.get_mut(*key) {
                    Some(inner) => inner,
                    None => return refuse(format!("`{before}.{key}` is not given"), whole(place + 2, &steps)),
                }
            }
            (Step::Index(_), _) => return refuse(format!("`{before}` is not a list"), whole(place + 1, &steps)),
            (Step::Key(key), _) => {
                return refuse(
                    format!("`{before}` is not a table, there is no `{key}` in it"),
                    whole(place + 1, &steps),
                );
            }
        };
    }
    *value = change.value.clone();
    Ok(())
}

/// A path taken apart; `None` if its brackets are no places of lists.
fn steps(path: &str) -> Option<Vec<Step<'_>>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (key, mut rest) = part.find('[').map_or((part, ""), |at| part.split_at(at));
        if key.is_empty() {
            return None;
        }
        steps.push(Step::Key(key));
        while !rest.is_empty() {
            let (index, after) = rest.strip_prefix('[')?.split_once(']')?;
            steps.push(Step::Index(index.parse().ok()?));
            rest = after;
        }
    }
    Some(steps)
}

fn shown(steps: &[Step<'_>]) -> String {
    let each = steps.iter().enumerate().map(|(place, step)| match step {
        Step::Key(key) if place == 0 => (*key).to_owned(),
        Step::Key(key) => format!(".{key}"),
        Step::Index(index) => format!("[{index}]"),
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_taken_apart_and_put_together() {
        for (path, plain) in [("a[01][2]", "a[1][2]"), ("a.b[1].c[2]", "a.b[1].c[2]"), ("a", "a")] {
            assert_eq!(plainly(path), plain);
        }
        for path in ["a[x]", "a[1", "a[1]b", ".a", "a..b", "[1]", "a[-1]"] {
            assert_eq!(steps(path), None, "{path}");
        }
    }
}
