//! Convex polygons in a plane, points and segments among them.

/// A point of the plane.
pub(super) type Point = [f64; 2];

fn cross(o: Point, a: Point, b: Point) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Corners of the convex hull, counter-clockwise, without those within `slack` of the line between their neighbours
/// (Andrew's monotone chain).
pub(super) fn hull(points: &[Point], slack: f64) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup_by(|a, b| distance(*a, *b) <= slack);
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = &Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while chain.len() > 1 {
                let (a, b) = (chain[chain.len() - 2], chain[chain.len() - 1]);
                if cross(a, b, *point) > slack * distance(a, *point) {
                    break;
                }
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut sorted.iter());
    corners.extend(half(&mut sorted.iter().rev()));
    // Sorted by x, points of one place may stand apart in the list.
    if corners.len() == 2 && distance(corners[0], corners[1]) <= slack {
        corners.pop();
    }
    corners
}

/// What two convex polygons have in common, within `slack`; each a list of corners from [`hull`].
pub(super) fn common(a: &[Point], b: &[Point], slack: f64) -> Vec<Point> {
    let (a, b) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    let found = match (a.len(), b.len()) {
        (0, _) => Vec::new(),
        (1, _) => {
            if holds(b, a[0], slack) {
                a.to_vec()
            } else {
                Vec::new()
            }
        }
        (2, 2) => segments([a[0], a[1]], [b[0], b[1]], slack),
        _ => clip(a, b, slack),
    };
    // Both were widened by the slack: what is no wider than that is a segment or a point.
    hull(&found, 4.0 * slack)
}

/// Whether a polygon has a point in it, or within `slack` of it.
pub(super) fn holds(polygon: &[Point], point: Point, slack: f64) -> bool {
    match polygon {
        [] => false,
        [one] => distance(*one, point) <= slack,
        [a, b] => to_segment(point, *a, *b) <= slack,
        _ => (0..polygon.len()).all(|i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            cross(a, b, point) >= -slack * distance(a, b)
        }),
    }
}

fn to_segment(point: Point, a: Point, b: Point) -> f64 {
    let (along, length) = ([b[0] - a[0], b[1] - a[1]], distance(a, b));
    let at = ((point[0] - a[0]) * along[0] + (point[1] - a[1]) * along[1]) / (length * length);
    let at = at.clamp(0.0, 1.0);
    distance(point, [a[0] + at * along[0], a[1] + at * along[1]])
}

/// Where two segments cross, or the part in which they lie on each other.
fn segments([a, b]: [Point; 2], [c, d]: [Point; 2], slack: f64) -> Vec<Point> {
    let mut on: Vec<Point> = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)]
        .into_iter()
        .filter(|(point, from, to)| to_segment(*point, *from, *to) <= slack)
        .map(|(point, ..)| point)
        .collect();
    if on.is_empty() {
        let (p, q) = (cross(a, b, c), cross(a, b, d));
        let (r, s) = (cross(c, d, a), cross(c, d, b));
        if p * q < 0.0 && r * s < 0.0 {
            let at = r / (r - s);
            on.push([a[0] + at * (b[0] - a[0]), a[1] + at * (b[1] - a[1])]);
        }
    }
    on
}

/// A polygon or segment `a` within a polygon `b` of three corners or more (Sutherland, Hodgman 1974).
fn clip(a: &[Point], b: &[Point], slack: f64) -> Vec<Point> {
    let mut left = a.to_vec();
    for i in 0..b.len() {
        let (from, to) = (b[i], b[(i + 1) % b.len()]);
        let inside = |point: Point| cross(from, to, point) / distance(from, to) + slack;
        let mut next = Vec::new();
        // A segment has one side, not two.
        let sides = if left.len() == 2 { 1 } else { left.len() };
        if left.len() == 1 && inside(left[0]) >= 0.0 {
            next.push(left[0]);
        }
        for k in 0..if left.len() > 1 { sides } else { 0 } {
            let (p, q) = (left[k], left[(k + 1) % left.len()]);
            let (u, v) = (inside(p), inside(q));
            if u >= 0.0 {
                next.push(p);
            }
            if u * v < 0.0 {
                let at = u / (u - v);
                next.push([p[0] + at * (q[0] - p[0]), p[1] + at * (q[1] - p[1])]);
            }
            if sides == 1 && v >= 0.0 {
                next.push(q);
            }
        }
        left = next;
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, half: f64) -> Vec<Point> {
        vec![[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]
    }

    fn area(polygon: &[Point]) -> f64 {
        (1..polygon.len().saturating_sub(1)).map(|i| 0.5 * cross(polygon[0], polygon[i], polygon[i + 1])).sum()
    }

    #[test]
    fn hulls_have_the_corners_and_nothing_between() {
        let mut points = square(0.0, 0.0, 1.0);
        points.extend([[0.0, 1.0], [0.2, 0.3], [1.0, 0.0], [1.0, 1.0]]);
        let corners = hull(&points, 1e-12);
        assert_eq!(corners.len(), 4);
        assert!((area(&corners) - 4.0).abs() < 1e-12);
        assert_eq!(hull(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], 1e-12).len(), 2);
        assert_eq!(hull(&[[0.5, 0.0], [0.5, 0.0]], 1e-12).len(), 1);
    }

    #[test]
    fn squares_overlap_in_rectangles_edges_and_corners() {
        let (one, slack) = (hull(&square(0.0, 0.0, 1.0), 1e-12), 1e-9);
        let with = |x, y| common(&one, &hull(&square(x, y, 1.0), 1e-12), slack);
        assert!((area(&with(0.5, 1.0)) - 1.5).abs() < 1e-8);
        assert_eq!(with(2.0, 0.5).len(), 2);
        assert_eq!(with(2.0, 2.0).len(), 1);
        assert!(with(2.1, 0.0).is_empty());
    }

    #[test]
    fn segments_cross_in_a_point_and_lie_on_each_other_in_two() {
        let slack = 1e-9;
        let common = |a: [Point; 2], b: [Point; 2]| common(&a, &b, slack);
        assert_eq!(common([[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 2.0]]), vec![[0.0, 0.0]]);
        assert_eq!(common([[-1.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [3.0, 0.0]]), vec![[0.0, 0.0], [1.0, 0.0]]);
        assert!(common([[-1.0, 0.0], [1.0, 0.0]], [[2.0, 0.0], [3.0, 0.0]]).is_empty());
        let square = hull(&square(0.0, 0.0, 1.0), 1e-12);
        assert_eq!(super::common(&square, &[[-3.0, 0.5], [0.0, 0.5]], slack).len(), 2);
        assert_eq!(super::common(&square, &[[0.25, 0.5]], slack), vec![[0.25, 0.5]]);
    }
}
