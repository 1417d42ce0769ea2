//! Parts of a scene: what is joined to each other.

/// Per link the lowest of those that pairs join it to, directly or by others; a link that nothing joins is its own.
pub(in crate::statics) fn joined(links: usize, pairs: impl IntoIterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut of: Vec<usize> = (0..links).collect();
    let first = |of: &[usize], mut link: usize| {
        while of[link] != link {
            link = of[link];
        }
        link
    };
    for pair in pairs {
        let [one, other] = pair.map(|link| first(&of, link));
        of[one.max(other)] = one.min(other);
    }
    (0..links).map(|link| first(&of, link)).collect()
}
