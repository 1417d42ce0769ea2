//! `modal` of a `[[body]]`: the file of finite elements that it is made of.

use super::findings::Finding;
use super::reader::Reader;
use crate::element::modal::Modal;
use crate::fem::{Flaw, ModalDamping};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a body is made of, and the file.
#[derive(Debug, Clone)]
pub(super) struct Made {
    pub(super) modal: Arc<Modal>,
    pub(super) file: PathBuf,
}

/// Reads and reduces the file of a body of this name; `None` for a rigid one, or where something is wrong.
pub(super) fn modal(body: &Reader<'_>, owner: &str, folder: &Path) -> Option<Made> {
    if !body.has("modal") {
        for key in ["modes", "modal_damping", "geometric"].into_iter().filter(|key| body.has(key)) {
            let message = format!("body `{owner}`: `{key}` without `modal`");
            let help = "it is for bodies that are made of a file of finite elements";
            body.findings.push(Finding::error(body.key_span(key), message).help(help));
        }
        return None;
    }
    let beside = ["mass", "density", "burn", "center", "inertia"].into_iter().find(|key| body.has(key));
    if let Some(key) = beside {
        let message = format!("body `{owner}`: `{key}` beside `modal`");
        let help = "its mass is that of its file; weld another body to it with a fixed hinge";
        body.findings.push(Finding::error(body.key_span(key), message).help(help));
        return None;
    }
    let file = folder.join(body.text("modal")?);
    let modes = body.count("modes").unwrap_or(0);
    let made = read(&file).and_then(|mut model| {
        if body.flag("geometric") == Some(false) {
            model.geometric.clear();
        }
        model.reduce(modes, damping(body))
    });
    match made {
        Ok(modal) => Some(Made { modal: Arc::new(modal), file }),
        Err(Flaw { message, help }) => {
            let message = format!("body `{owner}`: `{}`: {message}", file.display());
            body.findings.push(Finding::error(body.span_of("modal"), message).maybe_help(help));
            None
        }
    }
}

fn damping(body: &Reader<'_>) -> ModalDamping {
    let Some(table) = body.table("modal_damping") else { return ModalDamping::None };
    let number = |key: &str| table.number(key).unwrap_or(0.0);
    match table.number("ratio") {
        Some(ratio) => {
            if let Some(key) = ["mass", "stiffness"].into_iter().find(|key| table.has(key)) {
                let message = format!("`{key}` beside `ratio`");
                let help = "either every mode has a part of its critical damping, or the matrix is a sum of mass and stiffness";
                table.findings.push(Finding::error(table.key_span(key), message).help(help));
            }
            ModalDamping::Ratio(ratio)
        }
        None => ModalDamping::Rayleigh { mass: number("mass"), stiffness: number("stiffness") },
    }
}

#[cfg(feature = "import")]
fn read(file: &Path) -> Result<crate::fem::FiniteElements, Flaw> {
    use crate::budget::FEM_BYTES;
    use std::io::Read;
    let cannot = |why: std::io::Error| Flaw { message: format!("it cannot be read: {why}"), help: None };
    let open = std::fs::File::open(file).map_err(cannot)?;
    let mut bytes = Vec::new();
    open.take(FEM_BYTES + 1).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > FEM_BYTES {
        return Err(Flaw { message: format!("it has more than {} MB", FEM_BYTES >> 20), help: None });
    }
    crate::fem::npz::read(&bytes)
}

#[cfg(not(feature = "import"))]
fn read(_file: &Path) -> Result<crate::fem::FiniteElements, Flaw> {
    let message = "this build does not read files of finite elements".to_owned();
    Err(Flaw { message, help: Some("build it with the feature `import`".to_owned()) })
}
