//! No file imports one that imports it, directly or through others. A parent and what is in its folder may know each other.

use super::files;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Files that still import each other, each circle in alphabetical order. The list may only shrink.
const CIRCLES: &[&[&str]] = &[&[
    "model/beam",
    "model/build",
    "model/burn",
    "model/check",
    "model/contact",
    "model/controller",
    "model/couple",
    "model/couplings",
    "model/description",
    "model/hinge_curve",
    "model/modal",
    "model/motor",
    "model/output",
    "model/parameter",
    "model/prescribed",
    "model/shape",
    "model/tree",
    "model/watch",
]];

/// File → the files that it imports, each by its path without `.rs` and `/mod.rs`.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// The paths of a tree of `use`, each with `prefix` before it.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let Some((head, list)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().expect("a first part");
        paths.push(format!("{prefix}{}", path.trim()));
        return;
    };
    let (mut depth, mut start) = (0, 0);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                expand(&format!("{prefix}{}", head.trim()), &list[start..at], paths);
                start = at + 1;
            }
            _ => {}
        }
    }
}

/// All paths with `::` in a text: those of `use`, and those that are written where they are needed.
fn paths(text: &str) -> Vec<String> {
    let mut paths = Vec::new();
    let mut rest = String::new();
    for statement in text.split_inclusive(';') {
        match statement
            .rfind("use ")
            .filter(|at| !statement[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
        {
            Some(at) if !statement[at..].contains('(') => {
                expand("", statement[at + "use ".len()..].trim_end_matches(';'), &mut paths);
                rest.push_str(&statement[..at]);
            }
            _ => rest.push_str(statement),
        }
    }
    let words = rest.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    paths.extend(words.filter(|word| word.contains("::")).map(str::to_owned));
    paths
}

/// The file that a path leads to from the file `from`.
fn leads_to(from: &str, path: &str, known: &BTreeSet<String>) -> Option<String> {
    let mut place: Vec<&str> = from.split('/').collect();
    let mut names = path.split("::").peekable();
    match *names.peek()? {
        "crate" => {
            place.clear();
            names.next();
        }
        "self" => drop(names.next()),
        "super" => {
            while names.next_if_eq(&"super").is_some() {
                place.pop();
            }
        }
        _ => {}
    }
    let outside = place.len();
    for name in names {
        place.push(name);
        if !known.contains(&place.join("/")) {
            place.pop();
            break;
        }
    }
    let found = place.join("/");
    // A first name that is no file of ours belongs to another crate, or to what was imported above.
    let named = place.len() > outside || path.starts_with("super") || path.starts_with("self");
    (named && found != from && known.contains(&found)).then_some(found)
}

/// Whether one of two files is in the folder of the other.
fn related(a: &str, b: &str) -> bool {
    Path::new(a).starts_with(b) || Path::new(b).starts_with(a)
}

fn imports() -> Imports {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let name = |path: &Path| {
        let inner = path.strip_prefix(&root).expect("within src").with_extension("");
        inner.to_str().expect("a name").trim_end_matches("/mod").to_owned()
    };
    let files: Vec<(String, String)> = files().into_iter().map(|(_, path, text)| (name(&path), text)).collect();
    let known: BTreeSet<String> = files.iter().map(|(name, _)| name.clone()).collect();
    let imported = |name: &str, text: &str| {
        let code = text.split("#[cfg(test)]\nmod tests {").next().expect("a first part");
        let found = paths(code).into_iter().filter_map(|path| leads_to(name, &path, &known));
        found.filter(|other| !related(name, other)).collect()
    };
    files.iter().map(|(name, text)| (name.clone(), imported(name, text))).collect()
}

/// Everything that a file imports, directly or through others.
fn reached<'i>(from: &str, imports: &'i Imports) -> BTreeSet<&'i str> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&str> = vec![from];
    while let Some(name) = open.pop() {
        for next in &imports[name] {
            if reached.insert(next.as_str()) {
                open.push(next);
            }
        }
    }
    reached
}

/// The files that import each other, by circles.
fn circles(imports: &Imports) -> BTreeSet<Vec<String>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        imports.keys().map(|name| (name.as_str(), reached(name, imports))).collect();
    let circle = |name: &str| -> Vec<String> {
        let back = |other: &&&str| reached[**other].contains(name);
        reached[name].iter().filter(back).map(|other| (*other).to_owned()).collect()
    };
    imports.keys().map(|name| circle(name)).filter(|circle| !circle.is_empty()).collect()
}

#[test]
fn files_that_import_each_other_are_found() {
    let known: BTreeSet<String> = ["a", "a/b", "a/c", "d"].map(str::to_owned).into();
    let of = |from: &str, text: &str| {
        let found: BTreeSet<String> = paths(text).iter().filter_map(|path| leads_to(from, path, &known)).collect();
        found.into_iter().collect::<Vec<_>>()
    };
    assert_eq!(
        of("a/b", "use super::c::{Thing, other::{self, More}};\nfn f() { crate::d::g(); Vec::new() }"),
        ["a/c", "d"]
    );
    assert_eq!(of("a/b", "use super::{c, Own};\nuse crate::{a::c as z, d};"), ["a", "a/c", "d"]);
    assert_eq!(of("a", "pub use b::Thing;\nuse std::fmt;"), ["a/b"]);
    let imports: Imports = [("a", vec!["b"]), ("b", vec!["c"]), ("c", vec!["b", "d"]), ("d", vec![])]
        .into_iter()
        .map(|(name, list)| (name.to_owned(), list.into_iter().map(str::to_owned).collect()))
        .collect();
    assert_eq!(circles(&imports).into_iter().collect::<Vec<_>>(), [["b", "c"]]);
}

#[test]
fn no_file_imports_one_that_imports_it() {
    let found = circles(&imports());
    let allowed: BTreeSet<Vec<String>> =
        CIRCLES.iter().map(|circle| circle.iter().map(|file| (*file).to_owned()).collect()).collect();
    let new: Vec<_> = found.difference(&allowed).collect();
    assert!(new.is_empty(), "files that import each other: {new:?}");
    let gone: Vec<_> = allowed.difference(&found).collect();
    assert!(gone.is_empty(), "no longer circles, take them out of the list: {gone:?}");
}
