//! How often a diagnosis is right: which effect was named for which hidden one, and whether its confidence is honest.

use super::mark::{Band, Cells, Line, Points, Shades};
use super::{Axis, Figure, Ink, Panel};

/// Rows are what was hidden, columns what was named; `counts[hidden][named]`. Colours are shares of a row, the numbers are
/// counts.
pub fn confusion(hidden: &[String], named: &[String], counts: &[Vec<usize>]) -> Figure {
    // The first hidden effect stands at the top.
    let values: Vec<f64> = counts.iter().rev().flatten().map(|count| *count as f64).collect();
    let names = hidden.iter().rev().cloned().collect();
    let axes = [Axis::names("named", named.to_vec()), Axis::names("hidden", names)];
    let extent = [[-0.5, named.len() as f64 - 0.5], [-0.5, hidden.len() as f64 - 0.5]];
    let size = [named.len(), hidden.len()];
    let cells = Cells {
        size,
        extent,
        values: values.into(),
        shades: Shades::Written,
        unit: "",
        scale: String::new(),
        most: None,
    };
    let aspect = hidden.len() as f64 / named.len().max(1) as f64;
    Figure::new(vec![Panel::new("hidden effect × named effect (draws)", axes).with(cells).aspect(aspect)])
}

/// How often the named effect was right against the confidence that was stated, in so many equal bins of confidence; the
/// band is the 95 % interval of Wilson. Each answer is a confidence between 0 and 1 and whether it was right.
pub fn reliability(answers: &[(f64, bool)], bins: usize) -> Figure {
    let bins = bins.max(1);
    let mut sums = vec![(0.0, 0.0, 0.0); bins];
    for (confidence, right) in answers.iter().filter(|(confidence, _)| confidence.is_finite()) {
        let bin = ((confidence * bins as f64) as usize).min(bins - 1);
        let (count, stated, hits) = &mut sums[bin];
        *count += 1.0;
        *stated += confidence;
        *hits += f64::from(u8::from(*right));
    }
    let mut curve = Vec::new();
    let mut band = Vec::new();
    for (count, stated, hits) in sums.into_iter().filter(|(count, ..)| *count > 0.0) {
        let at = stated / count;
        curve.push([at, hits / count]);
        let [low, high] = wilson(hits, count);
        band.push([at, low, high]);
    }
    let axis = |label: &str| Axis::new(label, "").range([0.0, 1.0]);
    let panel = Panel::new("reliability of the diagnosis", [axis("stated confidence"), axis("share that was right")])
        .with(Band::new("95 % interval", band, Ink::Series(0)))
        .with(Line::through("honest", [[0.0, 0.0], [1.0, 1.0]], Ink::Text))
        .with(Line::through("diagnosis", curve.clone(), Ink::Series(0)))
        .with(Points::new("", curve, Ink::Series(0)));
    Figure::new(vec![panel.aspect(1.0)])
}

/// The 95 % interval of a share (Wilson, J. Am. Stat. Assoc. 22 (1927) 209).
fn wilson(hits: f64, count: f64) -> [f64; 2] {
    const Z: f64 = 1.959_963_984_540_054;
    let share = hits / count;
    let scale = 1.0 + Z * Z / count;
    let middle = (share + Z * Z / (2.0 * count)) / scale;
    let half = Z / scale * (share * (1.0 - share) / count + Z * Z / (4.0 * count * count)).sqrt();
    [middle - half, middle + half]
}
