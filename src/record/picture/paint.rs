//! SVG as pixels.

use resvg::tiny_skia::{FilterQuality, Pixmap, PixmapPaint, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::Arc;

/// Letters of DejaVu Sans (Latin, Greek, what units need): a machine may have none. Its licence stands beside it.
const FONT: &[u8] = include_bytes!("font.ttf");

/// Paints SVG texts, with the letters read once.
#[derive(Debug, Clone)]
pub struct Painter {
    fonts: Arc<fontdb::Database>,
}

/// What was painted.
#[derive(Debug, Clone)]
pub struct Pixels(Pixmap);

impl Default for Painter {
    fn default() -> Self {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(FONT.to_vec());
        // Whatever family a text asks for, there is one.
        fonts.set_sans_serif_family("DejaVu Sans");
        fonts.set_serif_family("DejaVu Sans");
        Self { fonts: Arc::new(fonts) }
    }
}

impl Painter {
    /// How texts are read: with our letters.
    pub(super) fn options(&self) -> Options<'_> {
        Options { fontdb: self.fonts.clone(), font_family: "DejaVu Sans".into(), ..Options::default() }
    }

    /// Paints a text, with `halvings` times four samples for each pixel: faces have sharp edges, which only samples smooth.
    ///
    /// # Errors
    /// If it is no SVG, or has no size that can be painted.
    pub fn paint(&self, svg: &str, halvings: u32) -> Result<Pixels, String> {
        let tree = Tree::from_str(svg, &self.options()).map_err(|error| error.to_string())?;
        let edges = [tree.size().width(), tree.size().height()].map(|edge| edge.ceil() as u32);
        let blank = |times: u32| {
            let [width, height] = edges.map(|edge| edge.saturating_mul(times));
            Pixmap::new(width, height).ok_or_else(|| format!("{width} × {height} pixels cannot be painted"))
        };
        let times = 1 << halvings;
        let mut pixels = blank(times)?;
        resvg::render(&tree, Transform::from_scale(times as f32, times as f32), &mut pixels.as_mut());
        // Between the middles of four pixels the bilinear filter is their mean.
        let paint = PixmapPaint { quality: FilterQuality::Bilinear, ..PixmapPaint::default() };
        for halving in (0..halvings).rev() {
            let mut half = blank(1 << halving)?;
            half.draw_pixmap(0, 0, pixels.as_ref(), &paint, Transform::from_scale(0.5, 0.5), None);
            pixels = half;
        }
        Ok(Pixels(pixels))
    }
}

impl Pixels {
    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        [self.0.width(), self.0.height()]
    }

    /// As PNG.
    ///
    /// # Errors
    /// If they cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        self.0.encode_png().map_err(|error| error.to_string())
    }

    /// Red, green, blue, opacity of each pixel, row by row from above.
    pub fn rgba(&self) -> Vec<u8> {
        let bytes = |pixel: &resvg::tiny_skia::PremultipliedColorU8| {
            let color = pixel.demultiply();
            [color.red(), color.green(), color.blue(), color.alpha()]
        };
        self.0.pixels().iter().flat_map(bytes).collect()
    }
}
