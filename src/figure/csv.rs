//! The numbers behind a figure, one row a point: all samples in the shown range, none left out.

use super::{Axis, Figure, FigureError, Mark};

const HEADER: [&str; 10] = ["panel", "mark", "series", "x", "y", "low", "high", "least", "most", "value"];

/// Kind of mark, series, and the numbers of a row.
type Row<'a> = (&'static str, &'a str, [Option<f64>; 7]);

/// Every number of the figure.
pub fn table(figure: &Figure) -> Result<Vec<u8>, FigureError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let failed = |error: ::csv::Error| FigureError::Conversion { format: "CSV", reason: error.to_string() };
    writer.write_record(HEADER).map_err(failed)?;
    for panel in &figure.panels {
        for mark in &panel.marks {
            for (kind, series, numbers) in rows(mark, &panel.x) {
                // What a mark does not have, and what is a hole, is an empty field.
                let text = |number: Option<f64>| {
                    number.filter(|number| !number.is_nan()).map_or_else(String::new, |number| number.to_string())
                };
                let fields = [panel.title.clone(), kind.to_owned(), series.to_owned()];
                writer.write_record(fields.into_iter().chain(numbers.map(text))).map_err(failed)?;
            }
        }
    }
    writer.into_inner().map_err(|error| FigureError::Conversion { format: "CSV", reason: error.to_string() })
}

/// One row a point.
fn rows<'a>(mark: &'a Mark, axis: &'a Axis) -> Vec<Row<'a>> {
    let shown = |x: f64| axis.range.is_none_or(|[from, to]| (from..=to).contains(&x));
    match mark {
        Mark::Line { name, points, .. } => plain("line", name, points, shown),
        Mark::Points { name, points, .. } => plain("points", name, points, shown),
        Mark::Band { name, points, .. } => points
            .iter()
            .filter(|point| shown(point[0]))
            .map(|[x, low, high]| ("band", name.as_str(), [Some(*x), None, Some(*low), Some(*high), None, None, None]))
            .collect(),
        Mark::Bars { name, bars, .. } => bars
            .iter()
            .map(|[x, y, low, high]| {
                ("bar", name.as_str(), [Some(*x), Some(*y), Some(*low), Some(*high), None, None, None])
            })
            .collect(),
        Mark::Boxes { name, boxes, .. } => boxes
            .iter()
            .map(|[x, least, low, median, high, most]| {
                let [x, y, low, high, least, most] = [*x, *median, *low, *high, *least, *most].map(Some);
                ("box", name.as_str(), [x, y, low, high, least, most, None])
            })
            .collect(),
        Mark::Cells { size: [columns, rows], extent, values, .. } => values
            .iter()
            .enumerate()
            .map(|(index, value)| {
                let middle = |at: usize, count: usize, [from, to]: [f64; 2]| {
                    from + (to - from) * (at as f64 + 0.5) / count as f64
                };
                let (x, y) = (middle(index % columns, *columns, extent[0]), middle(index / columns, *rows, extent[1]));
                ("cell", "", [Some(x), Some(y), None, None, None, None, Some(*value)])
            })
            .collect(),
        Mark::Frame { sides: [[left, right], [low, high]], .. } => {
            plain("frame", "", &[[*left, *low], [*right, *high]], |_| true)
        }
        Mark::Arrow { ends, .. } => plain("arrow", "", ends, |_| true),
        Mark::Word { text, at, .. } => plain("word", text, &[*at], |_| true),
        Mark::Shade([from, to]) => vec![("held out", "", [None, None, Some(*from), Some(*to), None, None, None])],
    }
}

fn plain<'a>(kind: &'static str, name: &'a str, points: &[[f64; 2]], shown: impl Fn(f64) -> bool) -> Vec<Row<'a>> {
    let rows = points.iter().filter(|point| shown(point[0]));
    rows.map(|[x, y]| (kind, name, [Some(*x), Some(*y), None, None, None, None, None])).collect()
}
