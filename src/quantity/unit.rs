//! The symbols of units: SI, what engineers use beside it, and the prefixes.

use std::f64::consts::{PI, TAU};

const MASS: [i8; 4] = [1, 0, 0, 0];
const LENGTH: [i8; 4] = [0, 1, 0, 0];
const TIME: [i8; 4] = [0, 0, 1, 0];
const ANGLE: [i8; 4] = [0, 0, 0, 1];
const FORCE: [i8; 4] = [1, 1, -2, 0];
const PRESSURE: [i8; 4] = [1, -1, -2, 0];
const ENERGY: [i8; 4] = [1, 2, -2, 0];

/// Symbol, factor to SI units, powers of kg, m, s and rad, whether it takes prefixes.
pub const SYMBOLS: [(&str, f64, [i8; 4], bool); 25] = [
    ("m", 1.0, LENGTH, true),
    ("g", 1e-3, MASS, true),
    ("s", 1.0, TIME, true),
    ("rad", 1.0, ANGLE, true),
    ("deg", PI / 180.0, ANGLE, false),
    ("°", PI / 180.0, ANGLE, false),
    ("rev", TAU, ANGLE, false),
    ("turn", TAU, ANGLE, false),
    ("N", 1.0, FORCE, true),
    // Written together by many: a torque, never a millinewton.
    ("Nm", 1.0, ENERGY, true),
    ("J", 1.0, ENERGY, true),
    ("W", 1.0, [1, 2, -3, 0], true),
    ("Pa", 1.0, PRESSURE, true),
    ("bar", 1e5, PRESSURE, true),
    ("Hz", 1.0, [0, 0, -1, 0], true),
    ("rpm", TAU / 60.0, [0, 0, -1, 1], false),
    ("min", 60.0, TIME, false),
    ("h", 3600.0, TIME, false),
    ("t", 1000.0, MASS, false),
    ("in", 0.0254, LENGTH, false),
    ("ft", 0.3048, LENGTH, false),
    // International avoirdupois pound; pound-force at standard gravity.
    ("lb", 0.453_592_37, MASS, false),
    ("lbf", 4.448_221_615_260_5, FORCE, false),
    ("psi", 6_894.757_293_168_361, PRESSURE, false),
    ("kgf", 9.806_65, FORCE, false),
];

/// Prefix, power of ten; centi and deci for lengths alone.
const PREFIXES: [(&str, i32); 10] =
    [("G", 9), ("M", 6), ("k", 3), ("d", -1), ("c", -2), ("m", -3), ("µ", -6), ("μ", -6), ("u", -6), ("n", -9)];

/// A symbol with its prefix: the factor to SI units (or, if told so, the number to divide by) and the powers of kg, m, s
/// and rad.
pub(super) fn symbol(text: &str) -> Option<(f64, bool, [i8; 4])> {
    if let Some((_, factor, powers, _)) = SYMBOLS.iter().find(|(symbol, ..)| *symbol == text && text != "g") {
        return Some((*factor, false, *powers));
    }
    let prefixed = PREFIXES.into_iter().chain([("", 0)]);
    prefixed.filter_map(|(prefix, power)| Some((text.strip_prefix(prefix)?, power))).find_map(|(rest, power)| {
        let (symbol, factor, powers, _) =
            SYMBOLS.iter().find(|(symbol, _, _, prefixes)| *symbol == rest && *prefixes)?;
        if (-2..0).contains(&power) && *symbol != "m" {
            return None;
        }
        // The gram is a thousandth of the SI unit.
        let (factor, power) = if *symbol == "g" { (1.0, power - 3) } else { (*factor, power) };
        Some(match power < 0 {
            true => (10.0_f64.powi(-power) / factor, true, *powers),
            false => (10.0_f64.powi(power) * factor, false, *powers),
        })
    })
}
