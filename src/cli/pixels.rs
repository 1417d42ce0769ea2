//! SVG as PNG, if the program was built with what paints.

#[cfg(feature = "picture")]
use crate::record::picture::Painter;

/// A picture in another format, from SVG.
pub(super) type Encode = fn(String) -> anyhow::Result<Vec<u8>>;

/// What makes PNG of SVG.
///
/// # Errors
/// In a program without the feature `picture`.
pub(super) fn png() -> anyhow::Result<Encode> {
    #[cfg(feature = "picture")]
    return Ok(|svg| {
        let pixels = Painter::default().paint(&svg, 2).map_err(anyhow::Error::msg)?;
        pixels.png().map_err(anyhow::Error::msg)
    });
    #[cfg(not(feature = "picture"))]
    anyhow::bail!(
        "this program was built without PNG; name a file that ends in .svg, or build it with `--features picture`"
    )
}
