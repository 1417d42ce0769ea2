//! Forces by tables of points, between points of bodies and in hinges.

use super::findings::Finding;
use super::reader::{Reader, Value, rows};
use crate::force::table::{Interpolation, Table};
use crate::model::description::{CurveOver, HingeCurveDescription};

/// The points under a key; `None` if there are none that can be read. `whose` is who the message is about.
pub(super) fn points(table: &Reader<'_>, key: &str, whose: &str) -> Option<Vec<[f64; 2]>> {
    let value: Value<'_> = table.value(key)?;
    let pairs = rows(value.get_ref())?;
    let points: Vec<[f64; 2]> = pairs.iter().map(|pair| <[f64; 2]>::try_from(&pair[..]).ok()).collect::<Option<_>>()?;
    let Some(bad) = Table::check(&points) else { return Some(points) };
    let item = bad.index.and_then(|index| value.get_ref().as_array()?.get(index));
    let span = item.map_or_else(|| value.span(), toml::Spanned::span);
    table.findings.push_value(Finding::error(span, format!("{whose} {}", bad.message)).help(bad.help));
    None
}

/// Smooth where nothing is said.
pub(super) fn interpolation(table: &Reader<'_>) -> Interpolation {
    if table.text("interpolation") == Some("linear") { Interpolation::Linear } else { Interpolation::Smooth }
}

/// `spring = { curve = … }` and `damper = { curve = … }` of a hinge, one or a list of each.
pub(super) fn in_hinge(hinge: &Reader<'_>, owner: &str) -> Vec<HingeCurveDescription> {
    let mut curves = Vec::new();
    for over in [CurveOver::Position, CurveOver::Velocity] {
        for table in hinge.tables(over.key()) {
            let whose = format!("hinge of body `{owner}`: the curve of its {}", over.key());
            let Some(points) = points(&table, "curve", &whose) else { continue };
            let coordinate = table.count("coordinate").unwrap_or(0);
            curves.push(HingeCurveDescription { coordinate, over, points, interpolation: interpolation(&table) });
        }
    }
    curves
}
