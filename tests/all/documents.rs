//! The documents: what they show is what the program prints, what they link to is there, what the code cites is written
//! down.

mod citations;
mod console;
mod links;

use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Every page for people: name within the repository, and text.
fn pages() -> Vec<(String, String)> {
    let mut paths = vec![root().join("README.md"), root().join("ARCHITECTURE.md"), root().join("CHANGELOG.md")];
    for folder in ["docs", "docs/guide", "docs/decisions"] {
        let entries = fs::read_dir(root().join(folder)).expect("a folder");
        let mut found: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
        found.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
        found.sort();
        paths.append(&mut found);
    }
    let name = |path: &Path| path.strip_prefix(root()).expect("below the root").display().to_string();
    paths.iter().map(|path| (name(path), fs::read_to_string(path).expect("a page"))).collect()
}

/// Renew it with `stillpoint schema --markdown > docs/guide/scenario_reference.md`.
#[test]
fn the_scenario_reference_is_what_the_program_prints() {
    let printed = Command::new(env!("CARGO_BIN_EXE_stillpoint")).args(["schema", "--markdown"]).output();
    let printed = String::from_utf8(printed.expect("the program starts").stdout).expect("text");
    let page = fs::read_to_string(root().join("docs/guide/scenario_reference.md")).expect("the page");
    let differs = printed.lines().zip(page.lines()).find(|(new, old)| new != old);
    assert!(
        printed == page,
        "stale; renew it with `stillpoint schema --markdown > docs/guide/scenario_reference.md`\n{differs:#?}"
    );
}

#[test]
fn the_scenario_reference_has_every_key() {
    let reference = stillpoint::scenario::reference();
    let schema = stillpoint::scenario::schema();
    let mut keys = Vec::new();
    properties(&schema, &mut keys);
    assert!(keys.len() > 100, "the schema has lost its keys: {keys:?}");
    for key in keys {
        assert!(reference.contains(&format!("`{key}`")), "`{key}` is in the schema and not in the reference");
    }
}

fn properties(schema: &serde_json::Value, keys: &mut Vec<String>) {
    match schema {
        serde_json::Value::Object(map) => {
            if let Some(serde_json::Value::Object(named)) = map.get("properties") {
                keys.extend(named.keys().cloned());
            }
            map.values().for_each(|value| properties(value, keys));
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| properties(value, keys)),
        _ => {}
    }
}

/// The map names files and folders of `src`: each is there.
#[test]
fn every_path_of_the_map_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let map = std::fs::read_to_string(root.join("ARCHITECTURE.md")).expect("the map");
    let named: Vec<&str> =
        map.split('`').skip(1).step_by(2).filter(|name| name.contains('/') && !name.contains(' ')).collect();
    assert!(named.len() > 40, "{named:?}");
    for name in named {
        let there = |folder: &str| root.join(folder).join(name).exists();
        assert!(["src", "", "scenarios"].into_iter().any(there), "`{name}` is not there");
    }
}

/// Pages that tell of the code name its files, as `statics/search/curve.rs`, and its modules, as `statics::search`: each is there.
#[test]
fn every_file_and_module_that_pages_name_is_there() {
    let mut named = 0;
    for (page, text) in pages().into_iter().filter(|(page, _)| page != "CHANGELOG.md") {
        for name in text.split('`').skip(1).step_by(2) {
            let is_path = |name: &str| name.chars().all(|c| c.is_ascii_alphanumeric() || "_/:.".contains(c));
            if name.ends_with(".rs") && name.contains('/') && is_path(name) {
                named += 1;
                let there = ["", "src", "tests/all"].into_iter().any(|folder| root().join(folder).join(name).exists());
                assert!(there, "{page}: `{name}` is not there");
            }
            let parts: Vec<&str> = name.split("::").collect();
            if parts.len() > 1
                && parts.iter().all(|part| !part.is_empty() && is_path(part))
                && module(&root().join("src"), parts[0]).is_some()
            {
                named += 1;
                assert!(is_in_code(&parts), "{page}: `{name}` is not there");
            }
        }
    }
    assert!(named > 60, "{named}");
}

/// The file or folder of a module.
fn module(folder: &Path, name: &str) -> Option<PathBuf> {
    [folder.join(name), folder.join(format!("{name}.rs"))].into_iter().find(|path| path.exists())
}

/// Whether modules lead to a module, or to something whose name stands in the last of them.
fn is_in_code(parts: &[&str]) -> bool {
    let (mut at, mut deep) = (root().join("src"), 0);
    while let Some(next) = parts.get(deep).and_then(|name| module(&at, name)) {
        (at, deep) = (next.with_extension(""), deep + 1);
    }
    let Some(item) = parts.get(deep) else { return true };
    let files = [at.with_extension("rs"), at.join("mod.rs")];
    files.iter().filter_map(|path| fs::read_to_string(path).ok()).any(|text| text.contains(item))
}
