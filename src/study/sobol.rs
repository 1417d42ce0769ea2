//! Sobol points: a low-discrepancy sequence in base 2 (Sobol 1967), with the direction numbers of Joe and Kuo, *SIAM J. Sci.
//! Comput.* 30 (2008) 2635, and a random digital shift.
//!
//! Coordinate `d` of point `i` is a sum modulo 2 of direction numbers, those of the digits of `i`:
//!
//! ```text
//! x_d(i) = i₀ v₁ ⊕ i₁ v₂ ⊕ i₂ v₃ ⊕ …,     v_k = m_k / 2ᵏ                                        (1)
//! m_k = 2 a₁ m_{k−1} ⊕ … ⊕ 2^{s−1} a_{s−1} m_{k−s+1} ⊕ 2^s m_{k−s} ⊕ m_{k−s}                  (2)
//! ```
//!
//! The shift `x ⊕ r_d`, `r_d` uniform, makes every point uniform and keeps how evenly they fill the space.

/// Points that the sequence can give: one for every 32-bit number.
pub const MOST_POINTS: u64 = 1 << 32;

/// Coordinates that a point can have.
pub const MOST_DIMENSIONS: usize = PRIMITIVE.len() + 1;

/// Of every dimension after the first: `a₁ … a_{s−1}` as the digits of a number, and `m₁ … m_s`.
#[rustfmt::skip]
const PRIMITIVE: [(u32, &[u32]); 63] = [
    (0, &[1]), (1, &[1, 3]), (1, &[1, 3, 1]), (2, &[1, 1, 1]), (1, &[1, 1, 3, 3]), (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]), (4, &[1, 1, 5, 5, 5]), (7, &[1, 1, 7, 11, 19]), (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]), (14, &[1, 3, 5, 5, 31]), (1, &[1, 3, 3, 9, 7, 49]), (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]), (19, &[1, 1, 1, 15, 7, 5]), (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]), (1, &[1, 3, 7, 11, 23, 15, 103]), (4, &[1, 3, 7, 13, 13, 15, 69]),
    (7, &[1, 1, 3, 13, 7, 35, 63]), (8, &[1, 3, 5, 9, 1, 25, 53]), (14, &[1, 3, 1, 13, 9, 35, 107]),
    (19, &[1, 3, 1, 5, 27, 61, 31]), (21, &[1, 1, 5, 11, 19, 41, 61]), (28, &[1, 3, 5, 3, 3, 13, 69]),
    (31, &[1, 1, 7, 13, 1, 19, 1]), (32, &[1, 3, 7, 5, 13, 19, 59]), (37, &[1, 1, 3, 9, 25, 29, 41]),
    (41, &[1, 3, 5, 13, 23, 1, 55]), (42, &[1, 3, 7, 3, 13, 59, 17]), (50, &[1, 3, 1, 3, 5, 53, 69]),
    (55, &[1, 1, 5, 5, 23, 33, 13]), (56, &[1, 1, 7, 7, 1, 61, 123]), (59, &[1, 1, 7, 9, 13, 61, 49]),
    (62, &[1, 3, 3, 5, 3, 55, 33]), (14, &[1, 3, 1, 15, 31, 13, 49, 245]), (21, &[1, 3, 5, 15, 31, 59, 63, 97]),
    (22, &[1, 3, 1, 11, 11, 11, 77, 249]), (38, &[1, 3, 1, 11, 27, 43, 71, 9]), (47, &[1, 1, 7, 15, 21, 11, 81, 45]),
    (49, &[1, 3, 7, 3, 25, 31, 65, 79]), (50, &[1, 3, 1, 1, 19, 11, 3, 205]), (52, &[1, 1, 5, 9, 19, 21, 29, 157]),
    (56, &[1, 3, 7, 11, 1, 33, 89, 185]), (67, &[1, 3, 3, 3, 15, 9, 79, 71]), (70, &[1, 3, 7, 11, 15, 39, 119, 27]),
    (84, &[1, 1, 3, 1, 11, 31, 97, 225]), (97, &[1, 1, 1, 3, 23, 43, 57, 177]), (103, &[1, 3, 7, 7, 17, 17, 37, 71]),
    (115, &[1, 3, 1, 5, 27, 63, 123, 213]), (122, &[1, 1, 3, 5, 11, 43, 53, 133]),
    (8, &[1, 3, 5, 5, 29, 17, 47, 173, 479]), (13, &[1, 3, 3, 11, 3, 1, 109, 9, 69]),
    (16, &[1, 1, 1, 5, 17, 39, 23, 5, 343]), (22, &[1, 3, 1, 5, 25, 15, 31, 103, 499]),
    (25, &[1, 1, 1, 11, 11, 17, 63, 105, 183]), (44, &[1, 1, 5, 11, 9, 29, 97, 231, 363]),
    (47, &[1, 1, 5, 15, 19, 45, 41, 7, 383]), (52, &[1, 3, 7, 7, 31, 19, 83, 137, 221]),
    (55, &[1, 1, 1, 3, 23, 15, 111, 223, 83]), (59, &[1, 1, 5, 13, 31, 15, 55, 25, 161]),
    (62, &[1, 1, 3, 13, 25, 47, 39, 87, 257]),
];

/// The directions of one dimension.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Directions([u32; 32]);

impl Directions {
    /// Directions of dimension `d` < [`MOST_DIMENSIONS`].
    pub fn new(d: usize) -> Self {
        let mut v = [0; 32];
        let Some((a, first)) = d.checked_sub(1).map(|d| PRIMITIVE[d]) else {
            return Self(std::array::from_fn(|k| 1 << (31 - k)));
        };
        let s = first.len();
        for k in 0..32 {
            v[k] = match first.get(k) {
                Some(m) => m << (31 - k),
                // (2), times 2^(32 − k).
                None => {
                    (1..s).filter(|j| a >> (s - 1 - j) & 1 == 1).fold(v[k - s] ^ v[k - s] >> s, |sum, j| sum ^ v[k - j])
                }
            };
        }
        Self(v)
    }

    /// Equation (1), times 2³².
    pub fn point(&self, i: u32) -> u32 {
        self.0.iter().enumerate().filter(|(k, _)| i >> k & 1 == 1).fold(0, |sum, (_, v)| sum ^ v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first points of the sequence as others print it, in the order of the digits of i.
    #[test]
    fn the_first_points_are_the_published_ones() {
        let third: Vec<f64> = (0..8).map(|i| f64::from(Directions::new(2).point(i)) / 2_f64.powi(32)).collect();
        assert_eq!(third, [0.0, 0.5, 0.75, 0.25, 0.375, 0.875, 0.625, 0.125]);
    }

    /// Every 2ᵐ points from a multiple of 2ᵐ have one number in each of the 2ᵐ equal intervals, in every dimension; and
    /// 2ᵐ points of two dimensions fill the boxes of a grid evenly for the first pair, which is a (0, m, 2)-net.
    #[test]
    fn points_fill_every_dimension_evenly() {
        for d in 0..MOST_DIMENSIONS {
            let directions = Directions::new(d);
            for start in [0_u32, 256, 7 * 256] {
                let mut seen = [false; 256];
                (start..start + 256).for_each(|i| seen[(directions.point(i) >> 24) as usize] = true);
                assert!(seen.iter().all(|seen| *seen), "dimension {d} from {start}");
            }
        }
        let (x, y) = (Directions::new(0), Directions::new(1));
        let mut boxes = [0; 64];
        (0..64).for_each(|i| boxes[(x.point(i) >> 29 << 3 | y.point(i) >> 29) as usize] += 1);
        assert_eq!(boxes, [1; 64]);
    }
}
