//! Every comment can be read by itself.

use std::fs;
use std::path::{Path, PathBuf};

/// Beginnings that lean on the comment before.
const LEANING: [&str; 4] = ["The same", "Nor ", "Those ", "Even so"];

/// Files with doc comments that still begin so, and how many. The list may only shrink.
const STILL: &[(&str, usize)] = &[
    ("contact/support/mod.rs", 2),
    ("force/bushing.rs", 1),
    ("hinge/declared.rs", 3),
    ("hinge/question.rs", 1),
    ("simulate/events.rs", 1),
    ("simulate/instant.rs", 1),
];

#[test]
fn doc_comments_begin_with_what_they_speak_of() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files: Vec<PathBuf> = Vec::new();
    super::sources(&root, &mut files);
    let mut found: Vec<(String, usize)> = Vec::new();
    for path in files {
        let text = fs::read_to_string(&path).expect("a file");
        let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
        let is_doc = |line: &str| line.starts_with("///") || line.starts_with("//!");
        let begins = |at: usize| {
            let blank = |line: &str| !is_doc(line) || line.len() == 3;
            let said = lines[at].get(4..).unwrap_or_default();
            is_doc(lines[at]) && (at == 0 || blank(lines[at - 1])) && LEANING.iter().any(|word| said.starts_with(word))
        };
        let count = (0..lines.len()).filter(|at| begins(*at)).count();
        if count > 0 {
            let inner = path.strip_prefix(&root).expect("within src");
            found.push((inner.to_str().expect("a name").replace('\\', "/"), count));
        }
    }
    found.sort();
    let still: Vec<(String, usize)> = STILL.iter().map(|(file, count)| ((*file).to_owned(), *count)).collect();
    assert_eq!(found, still, "doc comments that begin with one of {LEANING:?}");
}
