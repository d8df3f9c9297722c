//! The results of an experiment as a figure.

use std::collections::HashSet;

use super::trials::Joined;
use crate::figure::mark::{Band, Line};
use crate::figure::{Axis, Ink, Panel};

/// Width of a curve relative to that of other lines.
const CURVE: f64 = 1.8;
/// How much of a band is seen.
const FAINT: f64 = 0.16;

/// The error of all models along a curve of test sets, but of those that are left out; `None` if none is there.
pub fn curve(joined: &Joined, name: &str, left_out: &HashSet<String>) -> Option<Panel> {
    let is_drawn = |model: &String| !left_out.contains(model);
    let curves: Vec<_> = joined.curves.iter().filter(|curve| curve.curve == name && is_drawn(&curve.model)).collect();
    let points = || curves.iter().flat_map(|curve| &curve.points).map(|point| point[0]);
    let extent = [points().fold(f64::INFINITY, f64::min), points().fold(f64::NEG_INFINITY, f64::max)];
    let x = Axis::new(&curves.first()?.axis, "").range(extent).linked(format!("experiment: {name}"));
    let mut panel = Panel::new("nMSE of the torque, logarithmic", [x, Axis::default().logarithmic()]);
    for curve in &curves {
        let (title, number) = joined.experiment.called(&curve.model);
        let ink = Ink::Series(number);
        let band: Vec<[f64; 3]> = curve.points.iter().map(|[x, _, least, most]| [*x, *least, *most]).collect();
        panel.push(Band { opacity: FAINT, ..Band::new("", band, ink) });
        panel.push(Line::through(title, curve.points.iter().map(|[x, mean, ..]| [*x, *mean]), ink).width(CURVE));
    }
    Some(panel)
}
