//! How rates stand in the tables of benchmarks.

use crate::cli::table::{number, table};
use crate::trial::rates::Reliability;

/// How often names of a confidence are right, as a table.
pub(super) fn print_reliability(classes: &[Reliability]) {
    print_classes("confidence", classes);
}

/// How often the form of what is there is right, as a table.
pub(super) fn print_forms(classes: &[Reliability]) {
    print_classes("in this form", classes);
}

fn print_classes(of: &str, classes: &[Reliability]) {
    let of_class = |class: &Reliability| vec![number(class.confidence), number(class.right), class.names.to_string()];
    let cells: Vec<Vec<String>> = classes.iter().map(of_class).collect();
    println!("{}", table(&[of, "right", "names"], &cells));
}

/// A rate as it stands in tables; a dash where there is none.
pub(super) fn percent(share: Option<f64>) -> String {
    share.map_or("–".to_owned(), |share| format!("{:.1} %", 100.0 * share))
}
