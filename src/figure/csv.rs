//! The numbers behind a figure, one row a point: all samples in the shown range, none left out.

use super::mark::Row;
use super::{Axis, Figure, FigureError, Scale};

const HEADER: [&str; 11] = ["panel", "mark", "series", "x", "y", "low", "high", "least", "most", "value", "name"];

/// Every number of the figure.
pub fn table(figure: &Figure) -> Result<Vec<u8>, FigureError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let mut outcome = writer.write_record(HEADER);
    for panel in &figure.panels {
        for mark in &panel.marks {
            mark.rows(&panel.x, &mut |row| {
                if outcome.is_ok() {
                    outcome = writer.write_record(fields(&panel.title, &panel.x, mark.kind(), &row));
                }
            });
        }
    }
    let failed = |reason: String| FigureError::Conversion { format: "CSV", reason };
    outcome.map_err(|error| failed(error.to_string()))?;
    writer.into_inner().map_err(|error| failed(error.to_string()))
}

/// What a mark does not have, and what is a hole, is an empty field. Where names stand along the horizontal axis, the last field
/// is the one that is nearest to the point.
fn fields(panel: &str, along: &Axis, kind: &str, row: &Row) -> [String; 11] {
    let text = |number: f64| if number.is_nan() { String::new() } else { number.to_string() };
    let [x, y, low, high] = [row.x, row.y, row.low, row.high].map(text);
    let [least, most, value] = [row.least, row.most, row.value].map(text);
    let name = match &along.scale {
        Scale::Names(names) => names.get(row.x.round() as usize).cloned().unwrap_or_default(),
        Scale::Linear | Scale::Logarithmic => String::new(),
    };
    [panel.to_owned(), kind.to_owned(), row.series.to_owned(), x, y, low, high, least, most, value, name]
}
