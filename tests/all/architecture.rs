//! The structure, checked: which module may know which, where foreign crates are used, how long a file may be.

mod circles;
mod comments;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Module → the modules of ours that it may import. Dependencies point one way: no module stands below itself.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("budget", &[]),
    ("foreign", &[]),
    ("whole_file", &[]),
    ("suggest", &["budget"]),
    ("text_file", &["budget", "suggest"]),
    ("markup", &[]),
    ("mesh", &["budget", "foreign"]),
    ("pages", &[]),
    ("round_off", &[]),
    ("extrapolate", &[]),
    ("spatial", &["round_off"]),
    ("sparse", &[]),
    ("integrate", &[]),
    ("quantity", &["suggest"]),
    // `quantity` for what formulas measure.
    ("formula", &["quantity", "suggest", "round_off"]),
    ("force", &["spatial"]),
    ("hinge", &[]),
    // `formula` for curves of guided motion.
    ("element", &["formula", "spatial", "round_off"]),
    // `budget`, `foreign` and `suggest` for files.
    ("fem", &["budget", "element", "foreign", "sparse", "spatial", "suggest"]),
    // `budget` for the largest number.
    ("model", &["budget", "element", "force", "formula", "hinge", "pages", "spatial", "suggest", "round_off"]),
    ("motion", &["element", "model", "pages", "spatial"]),
    ("transfer", &["element", "model", "motion", "pages", "spatial", "round_off"]),
    ("contact", &["dynamics", "model", "motion", "sparse", "spatial", "round_off"]),
    ("constraint", &["element", "hinge", "model", "motion", "transfer", "sparse", "spatial", "round_off"]),
    // `budget` for the memory of matrices, `formula` for the pieces in which a run keeps those of motors.
    (
        "dynamics",
        &[
            "budget",
            "element",
            "formula",
            "model",
            "motion",
            "force",
            "transfer",
            "constraint",
            "sparse",
            "spatial",
            "round_off",
        ],
    ),
    ("output", &["model", "motion", "force", "constraint", "dynamics", "spatial"]),
    (
        "linear",
        &[
            "constraint",
            "model",
            "motion",
            "force",
            "dynamics",
            "extrapolate",
            "output",
            "spatial",
            "suggest",
            "round_off",
        ],
    ),
    // `motion` and `force` for the baseline in maximal coordinates: poses that no tree sweep gives.
    // `hinge` for what loops lock, `suggest` for names of outputs.
    (
        "statics",
        &[
            "contact",
            "hinge",
            "model",
            "motion",
            "force",
            "constraint",
            "dynamics",
            "extrapolate",
            "output",
            "suggest",
            "transfer",
            "sparse",
            "spatial",
            "round_off",
        ],
    ),
    // `element` for the shape of beams.
    ("record", &["budget", "element", "foreign", "markup", "mesh", "spatial", "whole_file", "round_off"]),
    (
        "simulate",
        // `constraint` for the assembly of what a stage closes, `element` for the pieces of curves, `formula` for what expressions do between two looks, `sparse` for rows
        // beside a sparse tangent, `suggest` for names of stages.
        &[
            "constraint",
            "contact",
            "element",
            "force",
            "formula",
            "hinge",
            "model",
            "motion",
            "dynamics",
            "output",
            "statics",
            "integrate",
            "record",
            "sparse",
            "spatial",
            "suggest",
            "round_off",
        ],
    ),
    ("simulator", &["integrate", "model", "record", "simulate"]),
    // `model` for the mass properties of solids.
    ("import", &["budget", "foreign", "mesh", "model", "suggest", "text_file", "round_off"]),
    // `force` for the tables of curves.
    (
        "scenario",
        &[
            "budget",
            // `element` and `fem` for modal bodies.
            "element",
            "fem",
            "force",
            "formula",
            "hinge",
            "import",
            "integrate",
            "mesh",
            "model",
            // `motion` for where the points of a scene are as it is given.
            "motion",
            "quantity",
            "constraint",
            "simulate",
            "statics",
            "record",
            "suggest",
            "text_file",
        ],
    ),
    // `linear` for what pushes, `record` for channels.
    (
        "fmu",
        &[
            "constraint",
            "dynamics",
            "integrate",
            "linear",
            "markup",
            "model",
            "output",
            "quantity",
            "record",
            "scenario",
            "simulate",
            "simulator",
            "statics",
            "text_file",
        ],
    ),
    // `foreign` for panics of a case, `force` for what pulls.
    (
        "study",
        &[
            "constraint",
            "dynamics",
            "force",
            "foreign",
            "model",
            "quantity",
            "record",
            "scenario",
            "simulate",
            // `simulator` and `suggest` for fits: runs from one measured time to the next, names of columns.
            "simulator",
            // `spatial` for how many cases go side by side.
            "spatial",
            "statics",
            "suggest",
            "whole_file",
            "round_off",
        ],
    ),
    (
        "cli",
        &[
            // `element` for the mass of beams.
            "element",
            // `quantity` for options with units.
            "quantity",
            "contact",
            "fmu",
            "foreign",
            "whole_file",
            "import",
            "markup",
            "model",
            "constraint",
            "dynamics",
            "linear",
            "statics",
            "integrate",
            "record",
            "simulate",
            "scenario",
            "spatial",
            "study",
            "suggest",
            "text_file",
            "round_off",
        ],
    ),
];

/// Foreign crate → the modules that may name it.
const FOREIGN: &[(&str, &[&str])] = &[
    ("strsim", &["suggest"]),
    ("stl_io", &["mesh"]),
    ("tobj", &["mesh"]),
    ("gltf", &["mesh"]),
    // `cli` for reports, which are one file.
    ("base64", &["cli", "mesh"]),
    ("roxmltree", &["import"]),
    ("toml_edit", &["import"]),
    ("toml", &["scenario"]),
    ("annotate_snippets", &["scenario"]),
    ("mcap", &["record"]),
    ("foxglove", &["record"]),
    ("re_cdr", &["record"]),
    ("re_build_info", &["record"]),
    ("re_chunk", &["record"]),
    ("re_log_encoding", &["record"]),
    ("re_log_types", &["record"]),
    ("re_protos", &["record"]),
    ("re_sdk_types", &["record"]),
    ("tokio", &["record"]),
    ("tokio_stream", &["record"]),
    ("tonic", &["record"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
    ("ctrlc", &["cli"]),
    ("signal_hook", &["cli"]),
    ("csv", &["cli"]),
    ("parquet", &["cli", "study"]),
    ("arrow_array", &["cli", "study"]),
    ("arrow_schema", &["cli", "study"]),
    ("rand_chacha", &["study"]),
    // `cli` for the hashes by which a report allows its own script alone.
    ("sha2", &["cli", "study"]),
    ("statrs", &["study"]),
    ("clap_complete", &["cli"]),
    ("clap_mangen", &["cli"]),
    ("plotters", &["cli"]),
    // `fem` for archives of NumPy arrays.
    ("zip", &["cli", "fem"]),
    ("gif", &["cli"]),
    ("resvg", &["record"]),
    ("allocator_api2", &["pages"]),
    ("hugealloc", &["pages"]),
    ("faer", &["dynamics", "linear", "sparse", "statics"]),
    ("clarabel", &["contact"]),
    ("wide", &["spatial", "motion"]),
    // `motion` for the halves of large trees, `cli` to make its thread one of the two.
    ("rayon", &["motion", "cli"]),
];

/// What the core is compiled with: every other crate belongs to a feature.
const CORE: &[&str] = &["allocator-api2", "faer", "hugealloc", "nalgebra", "rayon", "strsim", "thiserror", "wide"];

/// A file longer than this is more than one can hold in the head.
const MOST_LINES: usize = 450;

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Every source file with its top module and its text without comments.
fn files() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    sources(&root, &mut found);
    let code =
        |text: String| text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    found
        .into_iter()
        .map(|path| {
            let inner = path.strip_prefix(&root).unwrap();
            let module = inner.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs").to_owned();
            let text = code(fs::read_to_string(&path).unwrap());
            (module, path, text)
        })
        .filter(|(module, ..)| module != "lib" && module != "main")
        .collect()
}

/// What stands between the commas of a list in braces, up to its end; lists within it belong to what precedes them.
fn outer_parts(list: &str) -> Vec<String> {
    let (mut parts, mut depth) = (vec![String::new()], 0);
    for c in list.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => parts.push(String::new()),
            c if depth == 0 => parts.last_mut().expect("never empty").push(c),
            _ => {}
        }
    }
    parts
}

#[test]
fn imports_after_a_nested_list_are_seen() {
    let found = imports("use crate::{model::{Body, Model}, spatial::quad, transfer};");
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["model", "spatial", "transfer"]);
}

/// The names that follow `crate::` in a text, also within `use crate::{…}`.
fn imports(text: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let parts = match rest.strip_prefix('{') {
            Some(inner) => outer_parts(inner),
            None => vec![rest.to_owned()],
        };
        for part in parts {
            let name: String = part.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if name.chars().next().is_some_and(char::is_lowercase) {
                names.insert(name);
            }
        }
    }
    names
}

#[test]
fn dependencies_between_modules_point_one_way() {
    let known: BTreeSet<&str> = MAY_IMPORT.iter().map(|(module, _)| *module).collect();
    for (module, path, text) in files() {
        let (_, allowed) = MAY_IMPORT
            .iter()
            .find(|(name, _)| *name == module)
            .unwrap_or_else(|| panic!("{}: a new module needs its line in MAY_IMPORT", path.display()));
        for name in imports(&text) {
            let fine = name == module || !known.contains(name.as_str()) || allowed.contains(&name.as_str());
            assert!(fine, "{}: `{module}` must not import `{name}`", path.display());
        }
    }
    // One way: an order exists in which every module imports only earlier ones.
    let mut placed: BTreeSet<&str> = BTreeSet::new();
    while placed.len() < MAY_IMPORT.len() {
        let next = MAY_IMPORT
            .iter()
            .find(|(module, needs)| !placed.contains(module) && needs.iter().all(|need| placed.contains(need)));
        placed.insert(next.expect("the table of modules has a cycle").0);
    }
}

#[test]
fn foreign_crates_stay_where_they_belong() {
    for (module, path, text) in files() {
        for (name, homes) in FOREIGN {
            let used = text.contains(&format!("use {name}::")) || text.contains(&format!(" {name}::"));
            assert!(!used || homes.contains(&module.as_str()), "{}: `{name}` belongs in {homes:?}", path.display());
        }
    }
}

/// What counts as zero because arithmetic cannot tell is on one page.
#[test]
fn round_off_has_one_page() {
    for (module, path, text) in files().into_iter().filter(|(module, ..)| module != "round_off") {
        for (at, _) in text.match_indices("const ") {
            let name: String = text[at + "const ".len()..].chars().take_while(|c| *c != ':').collect();
            let is_number = text[at..].split('=').next().is_some_and(|start| start.contains(": f64"));
            let says_so =
                ["ROUND_OFF", "ROUNDING", "ROUNDED", "NOISE", "EPSILON"].iter().any(|word| name.contains(word));
            assert!(!(is_number && says_so), "{}: `{name}` of `{module}` belongs in src/round_off.rs", path.display());
        }
    }
}

#[test]
fn only_the_command_line_prints() {
    for (module, path, text) in files() {
        for call in ["println!", "eprintln!", "print!(", "eprint!(", "dbg!(", "std::process::exit"] {
            assert!(module == "cli" || !text.contains(call), "{}: {call} outside cli", path.display());
        }
    }
}

#[test]
fn files_can_be_held_in_the_head() {
    for (_, path, text) in files() {
        let lines = text.lines().count();
        assert!(lines <= MOST_LINES, "{}: {lines} lines", path.display());
    }
}

/// Who uses the library alone compiles nothing for the program, for files or for pictures.
#[test]
fn whatever_is_not_of_the_core_belongs_to_a_feature() {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    let (_, rest) = manifest.split_once("\n[dependencies]\n").unwrap();
    let (dependencies, _) = rest.split_once("\n[").unwrap();
    let crates = dependencies.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = "));
    let (always, optional): (Vec<_>, Vec<_>) = crates.partition(|(_, needs)| !needs.contains("optional = true"));
    let always: Vec<&str> = always.into_iter().map(|(name, _)| name).collect();
    assert_eq!(always, CORE);
    assert!(optional.len() > 20, "{optional:?}");
    // A feature of its own for each: none is switched on by its name.
    for (name, _) in optional {
        assert!(manifest.contains(&format!("\"dep:{name}\"")), "`{name}` belongs to no feature");
    }
}
