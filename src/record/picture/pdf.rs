//! SVG as PDF: one page of filled and stroked paths, letters as outlines.

use super::paint::Painter;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref};
use resvg::tiny_skia::PathSegment;
use resvg::usvg::{self, FillRule, Group, LineCap, LineJoin, Node, Paint, Transform, Tree};

/// Points of a page for one pixel: 96 pixels are an inch, 72 points are.
const POINTS: f32 = 0.75;

/// The pages' objects, in the order of their numbers; states of opacity follow.
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const STATES: i32 = 5;

/// What is drawn so far.
struct Page {
    content: Content,
    /// Opacities of fills and strokes that are used, one state each.
    opacities: Vec<f32>,
}

impl Painter {
    /// One page of the size of the picture.
    ///
    /// # Errors
    /// If the text is no SVG, or draws what is neither a path in one colour nor a text.
    pub fn pdf(&self, svg: &str) -> Result<Vec<u8>, String> {
        let tree = Tree::from_str(svg, &self.options()).map_err(|error| error.to_string())?;
        let [width, height] = [tree.size().width(), tree.size().height()].map(|edge| edge * POINTS);
        let mut page = Page { content: Content::new(), opacities: Vec::new() };
        // Up is up on a page.
        page.content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, height]);
        page.group(tree.root(), 1.0)?;
        let mut pdf = Pdf::new();
        pdf.catalog(CATALOG).pages(PAGES);
        pdf.pages(PAGES).kids([PAGE]).count(1);
        let mut only = pdf.page(PAGE);
        only.media_box(Rect::new(0.0, 0.0, width, height)).parent(PAGES).contents(CONTENT);
        let mut resources = only.resources();
        let mut states = resources.ext_g_states();
        for index in 0..page.opacities.len() {
            states.pair(Name(state(index).as_bytes()), Ref::new(STATES + index as i32));
        }
        states.finish();
        resources.finish();
        only.finish();
        for (index, opacity) in page.opacities.iter().enumerate() {
            let mut one = pdf.ext_graphics(Ref::new(STATES + index as i32));
            one.non_stroking_alpha(*opacity).stroking_alpha(*opacity);
        }
        pdf.stream(CONTENT, &page.content.finish());
        Ok(pdf.finish())
    }
}

/// The name of a state of opacity.
fn state(index: usize) -> String {
    format!("A{index}")
}

impl Page {
    fn group(&mut self, group: &Group, opacity: f32) -> Result<(), String> {
        // What is alone in its group has the opacity of the group; parts that cover each other would not.
        let own = group.opacity().get();
        let plain = group.clip_path().is_none() && group.mask().is_none() && group.filters().is_empty();
        if !plain || own < 1.0 && group.children().len() > 1 {
            return Err("masks, clips, filters and the opacity of several parts cannot be written as PDF".to_owned());
        }
        let opacity = opacity * own;
        group.children().iter().try_for_each(|node| match node {
            Node::Group(group) => self.group(group, opacity),
            Node::Path(path) => self.path(path, opacity),
            Node::Text(text) => self.group(text.flattened(), opacity),
            Node::Image(_) => Err("images of pixels cannot be written as PDF".to_owned()),
        })
    }

    fn path(&mut self, path: &usvg::Path, opacity: f32) -> Result<(), String> {
        if !path.is_visible() {
            return Ok(());
        }
        self.content.save_state();
        let Transform { sx, ky, kx, sy, tx, ty } = path.abs_transform();
        self.content.transform([sx, ky, kx, sy, tx, ty]);
        if let Some(fill) = path.fill() {
            let [red, green, blue] = color(fill.paint())?;
            self.opacity(opacity * fill.opacity().get());
            self.content.set_fill_rgb(red, green, blue);
            self.outline(path);
            match fill.rule() {
                FillRule::NonZero => self.content.fill_nonzero(),
                FillRule::EvenOdd => self.content.fill_even_odd(),
            };
        }
        if let Some(stroke) = path.stroke() {
            let [red, green, blue] = color(stroke.paint())?;
            self.opacity(opacity * stroke.opacity().get());
            let content = &mut self.content;
            content.set_stroke_rgb(red, green, blue).set_line_width(stroke.width().get());
            content.set_miter_limit(stroke.miterlimit().get());
            content.set_line_cap(match stroke.linecap() {
                LineCap::Butt => LineCapStyle::ButtCap,
                LineCap::Round => LineCapStyle::RoundCap,
                LineCap::Square => LineCapStyle::ProjectingSquareCap,
            });
            content.set_line_join(match stroke.linejoin() {
                LineJoin::Miter | LineJoin::MiterClip => LineJoinStyle::MiterJoin,
                LineJoin::Round => LineJoinStyle::RoundJoin,
                LineJoin::Bevel => LineJoinStyle::BevelJoin,
            });
            content.set_dash_pattern(stroke.dasharray().unwrap_or_default().iter().copied(), stroke.dashoffset());
            self.outline(path);
            self.content.stroke();
        }
        self.content.restore_state();
        Ok(())
    }

    fn opacity(&mut self, opacity: f32) {
        let known = self.opacities.iter().position(|known| *known == opacity);
        let index = known.unwrap_or_else(|| {
            self.opacities.push(opacity);
            self.opacities.len() - 1
        });
        self.content.set_parameters(Name(state(index).as_bytes()));
    }

    fn outline(&mut self, path: &usvg::Path) {
        let mut last = [0.0_f32; 2];
        for segment in path.data().segments() {
            let end = match segment {
                PathSegment::MoveTo(to) => {
                    self.content.move_to(to.x, to.y);
                    to
                }
                PathSegment::LineTo(to) => {
                    self.content.line_to(to.x, to.y);
                    to
                }
                PathSegment::QuadTo(by, to) => {
                    // The cubic curve that a quadratic one is.
                    let toward = |from: f32, by: f32| from + (by - from) * 2.0 / 3.0;
                    let (a, b) = (toward(last[0], by.x), toward(last[1], by.y));
                    self.content.cubic_to(a, b, toward(to.x, by.x), toward(to.y, by.y), to.x, to.y);
                    to
                }
                PathSegment::CubicTo(a, b, to) => {
                    self.content.cubic_to(a.x, a.y, b.x, b.y, to.x, to.y);
                    to
                }
                PathSegment::Close => {
                    self.content.close_path();
                    continue;
                }
            };
            last = [end.x, end.y];
        }
    }
}

/// Red, green, blue, each 0 … 1.
fn color(paint: &Paint) -> Result<[f32; 3], String> {
    match paint {
        Paint::Color(color) => Ok([color.red, color.green, color.blue].map(|part| f32::from(part) / 255.0)),
        _ => Err("gradients and patterns cannot be written as PDF".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::Painter;

    fn pdf(inside: &str) -> Result<String, String> {
        let svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"96\" height=\"48\">{inside}</svg>");
        Painter::default().pdf(&svg).map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
    }

    #[test]
    fn a_page_has_the_size_colours_and_opacities_of_the_picture() {
        let page = pdf(
            "<rect x=\"8\" y=\"4\" width=\"10\" height=\"20\" fill=\"#ff0000\" fill-opacity=\"0.5\"/>\
             <g opacity=\"0.5\"><path d=\"M0 0L9 9\" stroke=\"#0000ff\" stroke-width=\"3\" stroke-opacity=\"0.5\" stroke-dasharray=\"2 1\"/></g>",
        )
        .expect("a page");
        // An inch by half an inch, upside down.
        for text in ["/MediaBox [0 0 72 36]", "0.75 0 0 -0.75 0 36 cm", "1 0 0 rg", "8 4 m", "18 24 l", "/ca 0.5"] {
            assert!(page.contains(text), "no `{text}` in {page}");
        }
        for text in ["0 0 1 RG", "3 w", "[2 1] 0 d", "9 9 l", "/CA 0.25"] {
            assert!(page.contains(text), "no `{text}` in {page}");
        }
        let letters =
            pdf("<text x=\"1\" y=\"20\" font-family=\"sans-serif\" font-size=\"12\">x</text>").expect("a page");
        assert!(letters.contains(" l\n") && !letters.contains("BT"), "letters are outlines: {letters}");
    }

    #[test]
    fn what_cannot_be_written_is_an_error() {
        let gradient = "<linearGradient id=\"g\"><stop offset=\"0\"/><stop offset=\"1\" stop-color=\"red\"/></linearGradient>\
                        <rect width=\"9\" height=\"9\" fill=\"url(#g)\"/>";
        let covered =
            "<g opacity=\"0.5\"><rect width=\"9\" height=\"9\"/><rect width=\"5\" height=\"5\" fill=\"red\"/></g>";
        for inside in [gradient, covered] {
            assert!(pdf(inside).is_err_and(|why| why.contains("cannot be written as PDF")), "{inside}");
        }
        assert!(Painter::default().pdf("no picture").is_err());
    }
}
