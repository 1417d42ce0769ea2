//! The FMU as a zip archive; equal contents give equal bytes.

use super::library::Library;
use super::resources::Resources;
use crate::fmu::{MANIFEST, Manifest};
use std::env::consts::DLL_SUFFIX;
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

pub(super) fn archive(
    description: &str,
    manifest: &Manifest,
    resources: &Resources,
    library: &Library,
    identifier: &str,
) -> anyhow::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    let mut file = |name: &str, bytes: &[u8], mode: u32| -> anyhow::Result<()> {
        zip.start_file(name, options.unix_permissions(mode))?;
        Ok(zip.write_all(bytes)?)
    };
    file("modelDescription.xml", description.as_bytes(), 0o644)?;
    file(&format!("resources/{MANIFEST}"), manifest.to_json().as_bytes(), 0o644)?;
    for (name, bytes) in &resources.files {
        file(&format!("resources/{name}"), bytes, 0o644)?;
    }
    file(&format!("binaries/{}/{identifier}{DLL_SUFFIX}", library.platform), &library.bytes, 0o755)?;
    Ok(zip.finish()?.into_inner())
}
