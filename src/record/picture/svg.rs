//! A drawing as SVG.

use super::eye::{FOOT, Frame};
use super::order::{Face, back_to_front};
use super::shade::{faces, shadows};
use crate::record::drawing::ground::round_down;
use crate::record::drawing::shades::shade;
use crate::record::drawing::{Drawing, Legend};
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::fmt::Write;

/// Points nearer to a plane than this part of the picture are in it.
const TOLERANCE: f64 = 1e-6;
/// The scale bar is at most this part of the picture.
const BAR: f64 = 0.22;

/// The picture as SVG text: floor with shadows, parts, scale bar.
pub fn svg(drawing: &Drawing, poses: &[Pose], frame: &Frame) -> String {
    let [width, height] = frame.size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    floor(&mut out, drawing, poses, frame);
    let extent = f64::from(width.max(height)) / frame.scale;
    // Arrows last: one that pushes on a body would vanish in it.
    for of_arrows in [false, true] {
        let mut shown = faces(drawing, poses, frame, of_arrows);
        shown.retain(|face| frame.shows(&face.points));
        if of_arrows && !shown.is_empty() {
            halo(&mut out, &shown, frame);
        }
        paint(&mut out, &back_to_front(shown, TOLERANCE * extent), frame);
    }
    scale_bar(&mut out, frame);
    drawing.legend.iter().for_each(|legend| legend_bar(&mut out, legend, frame));
    out.push_str("</svg>\n");
    out
}

/// Grid and shadows, seen from above; from the side a line. Nothing where there is no ground.
fn floor(out: &mut String, drawing: &Drawing, poses: &[Pose], frame: &Frame) {
    let Some([[x0, y0], [x1, y1]]) = frame.floor else { return };
    let (height, spacing) = (frame.ground.floor, frame.ground.spacing);
    let place = |x: f64, y: f64| frame.place(&frame.turned(&Vector3::new(x, y, height)));
    let mut lines = String::new();
    let mut line = |from: [f64; 2], to: [f64; 2]| {
        // Writing to a `String` cannot fail.
        let _ = write!(lines, "M{:.1} {:.1}L{:.1} {:.1}", from[0], from[1], to[0], to[1]);
    };
    let count = |low: f64, high: f64| ((high - low) / spacing).round() as usize;
    for k in 0..=count(x0, x1) {
        let x = x0 + k as f64 * spacing;
        line(place(x, y0), place(x, y1));
    }
    for k in 0..=count(y0, y1) {
        let y = y0 + k as f64 * spacing;
        line(place(x0, y), place(x1, y));
    }
    let _ = writeln!(out, "<path d=\"{lines}\" fill=\"none\" stroke=\"#d9dde2\" stroke-width=\"1\"/>");
    if frame.back.z < 0.05 {
        return;
    }
    let mut outlines = String::new();
    for outline in shadows(drawing, poses, frame).iter().filter(|outline| frame.shows(outline)) {
        polygon(&mut outlines, outline, frame);
    }
    if !outlines.is_empty() {
        let _ = writeln!(out, "<path d=\"{outlines}\" fill=\"#26313f\" fill-opacity=\"0.13\" fill-rule=\"nonzero\"/>");
    }
}

/// White around faces, so that they can be told from what is behind them, whatever its colour.
fn halo(out: &mut String, faces: &[Face], frame: &Frame) {
    let mut path = String::new();
    faces.iter().for_each(|face| polygon(&mut path, &face.points, frame));
    let _ = writeln!(
        out,
        "<path d=\"{path}\" fill=\"none\" stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\"/>"
    );
}

/// Faces in their order; neighbours of one colour are one path.
fn paint(out: &mut String, faces: &[Face], frame: &Frame) {
    let looks = |face: &Face| (face.color, face.opacity);
    // Edges that are smoothed one by one let what lies beyond shine through between neighbours.
    out.push_str("<g shape-rendering=\"crispEdges\">\n");
    for group in faces.chunk_by(|a, b| looks(a) == looks(b)) {
        let mut path = String::new();
        for face in group {
            // Where faces of one path turn opposite ways they would leave a hole (the nonzero rule counts turns).
            let mut points = face.points.clone();
            if area(&points) < 0.0 {
                points.reverse();
            }
            polygon(&mut path, &points, frame);
        }
        let ([r, g, b], opacity) = looks(&group[0]);
        let opacity = if opacity < 1.0 { format!(" fill-opacity=\"{opacity:.3}\"") } else { String::new() };
        let _ = writeln!(out, "<path d=\"{path}\" fill=\"#{r:02x}{g:02x}{b:02x}\"{opacity}/>");
    }
    out.push_str("</g>\n");
}

/// Twice the area of a polygon as the eye sees it (m²); negative if its corners are clockwise.
fn area(points: &[Vector3<f64>]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x).sum()
}

fn polygon(path: &mut String, points: &[Vector3<f64>], frame: &Frame) {
    for (k, point) in points.iter().enumerate() {
        let [x, y] = frame.place(point);
        let _ = write!(path, "{}{x:.2} {y:.2}", if k == 0 { 'M' } else { 'L' });
    }
    path.push('Z');
}

/// A length of 1, 2 or 5 times a power of ten.
fn scale_bar(out: &mut String, frame: &Frame) {
    let [width, height] = frame.size.map(f64::from);
    let length = round_down(BAR * width / frame.scale);
    let (left, y) = (24.0, height - 0.5 * FOOT);
    let right = left + length * frame.scale;
    let _ = writeln!(
        out,
        "<path d=\"M{left:.1} {:.1}V{:.1}M{left:.1} {y:.1}H{right:.1}M{right:.1} {:.1}V{:.1}\" fill=\"none\" stroke=\"#333333\" \
         stroke-width=\"1.5\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"14\" \
         fill=\"#333333\">{}</text>",
        y - 5.0,
        y + 5.0,
        y - 5.0,
        y + 5.0,
        right + 10.0,
        y + 5.0,
        length_text(length)
    );
}

/// What the colours of beams mean, right of the scale bar.
fn legend_bar(out: &mut String, legend: &Legend, frame: &Frame) {
    const STRIPES: usize = 40;
    let [width, height] = frame.size.map(f64::from);
    let (length, y) = ((0.2 * width).min(240.0), height - 0.5 * FOOT);
    let text = format!("{} {}: {}", legend.number(), legend.unit, legend.what);
    // Six tenths of the height of letters are about their mean width.
    let left = width - 24.0 - length - 8.0 - 8.6 * text.chars().count() as f64;
    let stripe = length / STRIPES as f64;
    for k in 0..STRIPES {
        let [r, g, b] = shade(k as f64 / (STRIPES - 1) as f64).map(|part| (255.0 * part).round() as u8);
        let _ = writeln!(
            out,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"12\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            left + k as f64 * stripe,
            y - 6.0,
            stripe + 0.5
        );
    }
    for (x, anchor, text) in [(left - 8.0, "end", "0"), (left + length + 8.0, "start", text.as_str())] {
        let _ = writeln!(
            out,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"14\" \
             fill=\"#333333\">{text}</text>",
            y + 5.0
        );
    }
}

/// In the unit in which a round length has few digits.
fn length_text(length: f64) -> String {
    let (number, unit) = match length {
        l if l >= 1000.0 => (l / 1000.0, "km"),
        l if l >= 0.1 => (l, "m"),
        l if l >= 1e-3 => (l * 1e3, "mm"),
        l => (l * 1e6, "µm"),
    };
    // One digit and a power of ten: rounding takes away what binary fractions add.
    format!("{} {unit}", (number * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::length_text;

    #[test]
    fn lengths_have_the_unit_that_suits_them() {
        let shown = [0.2, 5.0, 0.02, 2e-5, 2000.0, 0.1].map(length_text);
        assert_eq!(shown, ["0.2 m", "5 m", "20 mm", "20 µm", "2 km", "0.1 m"]);
    }
}
