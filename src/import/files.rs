//! Where the files are that a model names.

use super::Options;
use std::path::{Component, Path, PathBuf};

/// Finds the file that a model names.
///
/// `package://name/…` (also `model://`) is looked for in the package folders of the options, and in the folders around
/// the model; what has no package is found from the model's folder.
pub(super) fn find(uri: &str, model: &Path, options: &Options) -> Option<PathBuf> {
    let folder = model.parent().unwrap_or(Path::new(""));
    let packaged = ["package://", "model://"].iter().find_map(|scheme| uri.strip_prefix(scheme));
    let Some(packaged) = packaged else {
        let path = Path::new(uri.strip_prefix("file://").unwrap_or(uri));
        return Some(folder.join(path)).filter(|path| path.is_file());
    };
    let (package, inside) = packaged.split_once('/').unwrap_or((packaged, ""));
    let named = options.packages.iter().filter(|(name, _)| name == package).map(|(_, path)| path.join(inside));
    let listed = options.package_path.iter().flat_map(|root| within(root, package, inside));
    let whole = std::path::absolute(model).unwrap_or_else(|_| model.to_owned());
    let around = whole.ancestors().skip(1).flat_map(|folder| within(folder, package, inside));
    named.chain(listed).chain(around).find(|path| path.is_file())
}

/// A file of a package that lies in this folder, or that is this folder.
fn within(folder: &Path, package: &str, inside: &str) -> Vec<PathBuf> {
    let mut found = vec![folder.join(package).join(inside)];
    if folder.file_name().is_some_and(|name| name == package) {
        found.push(folder.join(inside));
    }
    found
}

/// A path as it is written in scenario text that is read from `folder`: from there if it lies within, else in full.
pub(super) fn from_folder(path: &Path, folder: Option<&Path>, model: &Path) -> String {
    let folder = folder.unwrap_or_else(|| model.parent().unwrap_or(Path::new("")));
    let whole = |path: &Path| plain(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned()));
    let (path, folder) = (whole(path), whole(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }));
    let written = path.strip_prefix(&folder).unwrap_or(&path);
    written.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/")
}

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}
