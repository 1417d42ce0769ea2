//! Implicit steps of a system of bodies: what their methods ask of it is in `newton`, the matrices that they factorize are in `tangent`, with
//! rows of loops, drives and gears in `bordered`, beside contacts that move in `differenced`.

mod bordered;
mod differenced;
mod newton;
pub(super) mod tangent;
