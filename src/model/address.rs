//! How the numbers of a scene are addressed: `NAME.KEY`, and `NAME.KEY[i]` for one component.
//!
//! These rules hold wherever an address is written:
//!
//! - names may hold dots and brackets: the longest name that is known is taken;
//! - of a repeated element the name stands for all copies, `name[i]` for one of them;
//! - `force[2]`, `drive[0]`, … stands for the element at this place of its list, whatever its name, unless something
//!   is called so.

/// `tip.force[2]` → `tip.force` and 2.
pub fn split_component(address: &str) -> (&str, Option<usize>) {
    let inner = address.strip_suffix(']').and_then(|text| text.rsplit_once('['));
    match inner.and_then(|(path, index)| Some((path, index.parse().ok()?))) {
        Some((path, index)) => (path, Some(index)),
        None => (address, None),
    }
}

/// Something that addresses may begin with.
#[derive(Debug, Clone, Copy)]
pub struct Entry<'n, T> {
    /// What it is.
    pub element: T,
    /// Its name; empty for none.
    pub name: &'n str,
    /// The key of its list in scenario files and its place there, if it is addressed so; bodies are not, they have names.
    pub place: Option<(&'static str, usize)>,
    /// How many copies the name stands for; `None` for one element.
    pub copies: Option<usize>,
}

/// What the beginning of an address stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target<'p, T> {
    /// The element.
    pub element: T,
    /// Which of its copies; `None` for the element as a whole.
    pub copy: Option<usize>,
    /// The rest of the address.
    pub rest: &'p str,
}

/// What an address begins with; `has` tells which of several elements of one name has what the rest says.
pub fn resolve<'n, 'p, T: Copy>(
    address: &'p str,
    entries: impl Iterator<Item = Entry<'n, T>> + Clone,
    has: impl Fn(T, &str) -> bool,
) -> Option<Target<'p, T>> {
    let named = entries.clone().filter_map(|entry| {
        let after = address.strip_prefix(entry.name).filter(|_| !entry.name.is_empty())?;
        let (copy, rest) = match after.strip_prefix('.') {
            Some(rest) => (None, rest),
            None => {
                let (index, rest) = after.strip_prefix('[')?.split_once("].")?;
                (Some(index.parse().ok().filter(|index| *index < entry.copies.unwrap_or(0))?), rest)
            }
        };
        Some(Target { element: entry.element, copy, rest })
    });
    let placed = || {
        entries.filter_map(|entry| {
            let (list, index) = entry.place?;
            let (written, rest) = address.strip_prefix(list)?.strip_prefix('[')?.split_once("].")?;
            (written.parse() == Ok(index)).then_some(Target { element: entry.element, copy: None, rest })
        })
    };
    named.min_by_key(|target| (target.rest.len(), !has(target.element, target.rest))).or_else(|| placed().next())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_name_is_taken_and_places_stand_for_what_has_no_such_name() {
        let names =
            [("a", "body", None), ("a.b", "force", None), ("link", "body", Some(3)), ("force[0]", "body", None)];
        let entries = names.iter().enumerate().map(|(i, (name, list, copies))| Entry {
            element: i,
            name,
            place: (*list != "body").then_some((*list, i)),
            copies: *copies,
        });
        let found = |address: &'static str| {
            resolve(address, entries.clone(), |_, _| true).map(|target| (target.element, target.copy, target.rest))
        };
        assert_eq!(found("a.force"), Some((0, None, "force")));
        assert_eq!(found("a.b.force"), Some((1, None, "force")));
        assert_eq!(found("link[2].mass"), Some((2, Some(2), "mass")));
        assert_eq!(found("link[3].mass"), None);
        assert_eq!(found("link.mass"), Some((2, None, "mass")));
        assert_eq!(found("force[1].force"), Some((1, None, "force")));
        assert_eq!(found("force[0].mass"), Some((3, None, "mass")));
        assert_eq!(found("body[0].mass"), None);
        assert_eq!(found("b.mass"), None);
        assert_eq!(split_component("a[1].b[2]"), ("a[1].b", Some(2)));
        assert_eq!(split_component("a[1].b"), ("a[1].b", None));
    }
}
