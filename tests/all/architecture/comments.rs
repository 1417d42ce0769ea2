//! Every comment can be read by itself.

use std::fs;
use std::path::{Path, PathBuf};

/// Beginnings that lean on the comment before.
const LEANING: [&str; 4] = ["The same", "Nor ", "Those ", "Even so"];

#[test]
fn doc_comments_begin_with_what_they_speak_of() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files: Vec<PathBuf> = Vec::new();
    super::sources(&root, &mut files);
    for path in files {
        let text = fs::read_to_string(&path).expect("a file");
        let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
        let is_doc = |line: &str| line.starts_with("///") || line.starts_with("//!");
        let begins = |at: usize| {
            let blank = |line: &str| !is_doc(line) || line.len() == 3;
            let said = lines[at].get(4..).unwrap_or_default();
            is_doc(lines[at]) && (at == 0 || blank(lines[at - 1])) && LEANING.iter().any(|word| said.starts_with(word))
        };
        if let Some(at) = (0..lines.len()).find(|at| begins(*at)) {
            panic!("{}: a doc comment begins with one of {LEANING:?}: {}", path.display(), lines[at]);
        }
    }
}

/// Words that the glossary of CONTRIBUTING.md replaces, and the folders or files in which they still stand. The lists may only shrink.
const REPLACED: &[(&str, &[&str])] = &[
    ("blow", &[]),
    ("blows", &[]),
    ("left over", &[]),
    ("told by", &[]),
    ("told apart", &[]),
    ("the way out", &[]),
    ("hang on each other", &[]),
    ("hangs on each other", &[]),
];

/// Whether a text has some words, whole ones, in any case.
fn says(text: &str, words: &str) -> bool {
    let text = text.to_lowercase();
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(words)
        .any(|(at, _)| !is_word(text[..at].chars().next_back()) && !is_word(text[at + words.len()..].chars().next()))
}

/// The field's words, in comments and messages alike.
#[test]
fn words_are_those_of_the_glossary() {
    assert!(says("The Blow ends", "blow") && !says("below, blown, air_blow", "blow"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files: Vec<PathBuf> = Vec::new();
    super::sources(&root, &mut files);
    let text = |path: &PathBuf| (path.clone(), fs::read_to_string(path).expect("a file"));
    let files: Vec<(PathBuf, String)> = files.iter().map(text).collect();
    for (words, still) in REPLACED {
        let with = |(path, text): &(PathBuf, String)| {
            let name = path.strip_prefix(&root).expect("within src").to_str().expect("a name").replace('\\', "/");
            says(text, words).then_some(name)
        };
        let found: Vec<String> = files.iter().filter_map(with).collect();
        let new: Vec<&String> =
            found.iter().filter(|name| !still.iter().any(|place| name.starts_with(place))).collect();
        assert!(new.is_empty(), "“{words}” stands in {new:?}: CONTRIBUTING.md has the field's word for it");
        let gone = still.iter().find(|place| !found.iter().any(|name| name.starts_with(**place)));
        assert!(gone.is_none(), "“{words}” stands no longer in {gone:?}: take it out of the list");
    }
}
