//! Plots and pictures in the format that a file's name asks for: SVG, and PNG or PDF if the program was built with what paints.

#[cfg(feature = "picture")]
use crate::record::picture::Painter;
use anyhow::bail;
use std::path::Path;

/// A picture in another format, from SVG.
pub(super) type Encode = fn(String) -> anyhow::Result<Vec<u8>>;

/// How a picture is encoded in a file of this name.
///
/// # Errors
/// A name that ends otherwise; PNG and PDF in a program without the feature `picture`.
pub(super) fn by_name(path: &Path) -> anyhow::Result<Encode> {
    let kind = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    match kind.as_deref() {
        None | Some("svg") => Ok(|svg| Ok(svg.into_bytes())),
        #[cfg(feature = "picture")]
        Some("png") => Ok(|svg| {
            let png = Painter::default().paint(&svg, 2).and_then(|pixels| pixels.png());
            png.map_err(anyhow::Error::msg)
        }),
        #[cfg(feature = "picture")]
        Some("pdf") => Ok(|svg| Painter::default().pdf(&svg).map_err(anyhow::Error::msg)),
        #[cfg(not(feature = "picture"))]
        Some(kind @ ("png" | "pdf")) => bail!(
            "this program was built without {}; name a file that ends in .svg, or build it with `--features picture`",
            kind.to_uppercase()
        ),
        _ => bail!("`{}`: the name of a picture ends in .svg, .png or .pdf", path.display()),
    }
}
