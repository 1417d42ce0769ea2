//! Equations that comments cite.

use super::root;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Labels of equations that a module's documentation writes down: `(1)` or `(J1)` at the beginning of a line or at its end.
fn written(text: &str) -> BTreeSet<String> {
    let lines = text.lines().filter_map(|line| line.trim_start().strip_prefix("//!"));
    lines.flat_map(|line| [label_first(line.trim()), label_last(line.trim())]).flatten().collect()
}

fn label_first(line: &str) -> Option<String> {
    label(line.strip_prefix('(')?.split_once(')')?.0)
}

fn label_last(line: &str) -> Option<String> {
    label(line.strip_suffix(')')?.rsplit_once('(')?.1).filter(|_| line.contains("  ") && !line.contains("paper"))
}

fn label(text: &str) -> Option<String> {
    let digits = text.strip_prefix('J').unwrap_or(text);
    (!digits.is_empty() && digits.len() < 3 && digits.bytes().all(|b| b.is_ascii_digit())).then(|| text.to_owned())
}

/// Labels that follow `eq.` or `eqs.`, ranges included, and the rest of the line.
fn cited(text: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for line in text.lines().filter(|line| line.trim_start().starts_with("//")) {
        let lower = line.to_lowercase();
        for word in ["eq. (", "eqs. ("] {
            for (at, _) in lower.match_indices(word) {
                let rest = &line[at + word.len() - 1..];
                let mut tail = rest;
                // `(5), (7) and (J1) to (J3)`
                while let Some(inner) = tail.strip_prefix('(') {
                    let Some((inside, after)) = inner.split_once(')') else { break };
                    let Some(one) = label(inside) else { break };
                    found.push((one, line.trim().to_owned()));
                    let next = [", ", " to ", " and ", ""].into_iter().find_map(|word| {
                        after.strip_prefix(word).filter(|next| next.starts_with('(') && !word.is_empty())
                    });
                    let Some(next) = next else { break };
                    tail = next;
                }
            }
        }
    }
    found
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The file itself, then the modules around it: `transfer/tangent/hinge.rs`, `transfer/tangent.rs`, `transfer/mod.rs`.
fn around(path: &Path) -> Vec<PathBuf> {
    let mut files = vec![path.to_owned()];
    let mut folder = path.parent();
    while let Some(at) = folder.filter(|at| at.ends_with("src") || at.starts_with(root().join("src"))) {
        files.extend([at.join("mod.rs"), at.with_extension("rs")].into_iter().filter(|file| file.exists()));
        folder = at.parent();
    }
    files
}

#[test]
fn every_cited_equation_is_written_down() {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let (mut count, mut missing) = (0, Vec::new());
    for path in files {
        let text = fs::read_to_string(&path).expect("a source");
        let citations = cited(&text);
        if citations.is_empty() {
            continue;
        }
        let known: BTreeSet<String> =
            around(&path).iter().flat_map(|file| written(&fs::read_to_string(file).expect("a source"))).collect();
        for (label, line) in citations {
            count += 1;
            // One of another module is named with it: `eq. (3) of [`crate::constraint`]`.
            let of = line.split("of [`crate::").nth(1).and_then(|rest| rest.split('`').next());
            let there = of.map(|module| {
                let file = root().join("src").join(module.replace("::", "/"));
                let text =
                    fs::read_to_string(file.join("mod.rs")).or_else(|_| fs::read_to_string(file.with_extension("rs")));
                written(&text.expect("the module that is named"))
            });
            if !there.as_ref().unwrap_or(&known).contains(&label) {
                missing.push(format!("{}: ({label}): {line}", path.display()));
            }
        }
    }
    assert!(count > 30, "only {count} citations were found");
    assert!(missing.is_empty(), "{missing:#?}");
}

/// The guide's derivation numbers its equations as the modules do.
#[test]
fn the_guide_has_the_equations_of_the_core() {
    let guide = fs::read_to_string(root().join("docs/guide/method.md")).expect("the page");
    let section = |heading: &str| -> String {
        let start = guide.find(heading).unwrap_or_else(|| panic!("the guide has no section {heading}"));
        let rest = &guide[start + heading.len()..];
        rest[..rest.find("\n## ").unwrap_or(rest.len())].to_owned()
    };
    for (heading, file) in [
        ("## Accelerations", "transfer/mod.rs"),
        ("## The tangent", "transfer/tangent.rs"),
        ("## Jacobians", "transfer/jacobian.rs"),
        ("## Loops", "constraint/mod.rs"),
        ("## Stops", "simulate/stops/nonsmooth.rs"),
        ("## Impacts", "simulate/stops/instant.rs"),
    ] {
        let text = fs::read_to_string(root().join("src").join(file)).expect("a source");
        let part = section(heading);
        let labels = written(&text);
        assert!(labels.len() > 1, "{file}: {labels:?}");
        for label in labels {
            let there = part.lines().any(|line| line.trim_start().starts_with(&format!("({label})")));
            assert!(there, "{heading}: equation ({label}) of {file} is not there");
        }
    }
}
