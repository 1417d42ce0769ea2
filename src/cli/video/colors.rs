//! The colours of a picture with at most 256 of them.
//!
//! Pictures have flat faces of few colours, and along their edges very many that are nobody's: boxes of colours are divided where they are
//! most unlike, and each keeps the colour that most of its points have. Flat faces stay as they are, and nothing flickers.

use std::collections::BTreeMap;

/// Colours that a GIF picture may have.
const MOST: usize = 256;

/// A picture by the numbers of its colours.
pub(super) struct Indexed {
    /// Red, green and blue of each colour.
    pub(super) palette: Vec<u8>,
    /// The colour of each point.
    pub(super) points: Vec<u8>,
}

/// Of red, green, blue and opacity of each point.
pub(super) fn indexed(rgba: &[u8]) -> Indexed {
    let colors: Vec<[u8; 3]> = rgba.chunks_exact(4).map(|point| [point[0], point[1], point[2]]).collect();
    let mut counts: BTreeMap<[u8; 3], usize> = BTreeMap::new();
    // Neighbours have mostly one colour.
    colors.chunk_by(|a, b| a == b).for_each(|run| *counts.entry(run[0]).or_default() += run.len());
    let mut boxes = vec![Group::new(counts.into_iter().collect())];
    while boxes.len() < MOST {
        let Some(widest) = (0..boxes.len()).max_by(|a, b| boxes[*a].unlike.total_cmp(&boxes[*b].unlike)) else { break };
        let Some((low, high)) = boxes[widest].halves() else { break };
        boxes[widest] = low;
        boxes.push(high);
    }
    let numbers: BTreeMap<[u8; 3], u8> = (boxes.iter().zip(0..=u8::MAX))
        .flat_map(|(one, number)| one.colors.iter().map(move |(color, _)| (*color, number)))
        .collect();
    let number = |color: &[u8; 3]| numbers.get(color).copied().unwrap_or_default();
    let points = colors.chunk_by(|a, b| a == b).flat_map(|run| std::iter::repeat_n(number(&run[0]), run.len()));
    Indexed { points: points.collect(), palette: boxes.iter().flat_map(Group::most_frequent).collect() }
}

/// Colours that become one, with how many points have them.
struct Group {
    colors: Vec<([u8; 3], usize)>,
    /// Along which part they differ most, where its mean is, and the sum of the squares of how far they are from that: zero of one colour.
    axis: usize,
    mean: f64,
    unlike: f64,
}

impl Group {
    fn new(colors: Vec<([u8; 3], usize)>) -> Self {
        // By the edges of areas rather than by the areas: a small ball counts beside a large floor.
        let weight = |count: usize| (count as f64).sqrt();
        let whole: f64 = colors.iter().map(|(_, count)| weight(*count)).sum();
        let spread = |axis: usize| {
            let mean = colors.iter().map(|(color, count)| weight(*count) * f64::from(color[axis])).sum::<f64>() / whole;
            let square = |(color, count): &([u8; 3], usize)| weight(*count) * (f64::from(color[axis]) - mean).powi(2);
            (axis, mean, colors.iter().map(square).sum::<f64>())
        };
        let widest = (0..3).map(spread).max_by(|a, b| a.2.total_cmp(&b.2));
        let (axis, mean, unlike) = widest.filter(|_| colors.len() > 1).unwrap_or((0, 0.0, 0.0));
        Self { colors, axis, mean, unlike }
    }

    /// Divided at its mean; `None` of one colour.
    fn halves(&self) -> Option<(Self, Self)> {
        let is_low = |(color, _): &([u8; 3], usize)| f64::from(color[self.axis]) <= self.mean;
        let (low, high): (Vec<_>, Vec<_>) = self.colors.iter().copied().partition(is_low);
        (!low.is_empty() && !high.is_empty()).then(|| (Self::new(low), Self::new(high)))
    }

    fn most_frequent(&self) -> [u8; 3] {
        self.colors.iter().max_by_key(|(_, count)| *count).map_or([0; 3], |(color, _)| *color)
    }
}

#[cfg(test)]
mod tests {
    use super::indexed;

    /// A large floor of many greys, two faces of like colours, and a ball of a few points.
    #[test]
    fn faces_keep_their_colours_however_small_they_are() {
        let faces = [([200, 90, 20], 4000), ([190, 40, 30], 300), ([60, 160, 80], 40)];
        let grey = |k: usize| ([(k % 251) as u8, (k * 7 % 256) as u8, (k * 13 % 241) as u8], 1);
        let all = faces.into_iter().chain((0..5000).map(grey));
        let rgba: Vec<u8> =
            all.flat_map(|([r, g, b], count)| [r, g, b, 255].repeat(count)).chain([255; 400_000]).collect();
        let shown = indexed(&rgba);
        assert!(shown.palette.len() <= 3 * 256 && shown.points.len() == rgba.len() / 4);
        let color = |point: usize| &shown.palette[3 * usize::from(shown.points[point])..][..3];
        for (point, (face, _)) in [0, 4000, 4300].into_iter().zip(faces) {
            assert_eq!(color(point), face);
        }
        assert_eq!(color(rgba.len() / 4 - 1), [255; 3]);
    }

    #[test]
    fn few_colours_stay_exact() {
        let rgba: Vec<u8> = (0..=255).rev().flat_map(|k| [k, 255 - k, 7, 255]).collect();
        let shown = indexed(&rgba);
        let back = shown.points.iter().flat_map(|number| shown.palette[3 * usize::from(*number)..][..3].to_vec());
        assert!(back.eq(rgba.chunks(4).flat_map(|point| point[..3].to_vec())));
    }
}
