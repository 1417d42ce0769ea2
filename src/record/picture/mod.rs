//! Pictures of a drawing at one instant: SVG, and PNG or PDF of that SVG.
//!
//! A parallel projection along one direction, so that the scale bar holds for the whole picture. Each triangle that faces the eye becomes a
//! polygon of one colour; `order` puts them behind each other. Neither window, graphics processor nor network is needed; the library
//! that paints (`resvg`) brings letters of its own.

mod eye;
mod order;
#[cfg(feature = "picture")]
mod paint;
#[cfg(feature = "picture")]
mod pdf;
mod shade;
mod svg;

pub use eye::{Eye, Frame};
#[cfg(feature = "picture")]
pub use paint::{Painter, Pixels};
pub use svg::svg;
