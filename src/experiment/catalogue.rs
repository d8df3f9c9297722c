//! Experiments that come with the program: one file in `datasets/experiments/` and one line here.

use std::path::Path;

use super::{Experiment, ExperimentError};
use crate::file;

/// Name and text of each, in the order in which lists show them.
pub const ALL: &[(&str, &str)] = &[
    ("table-2", include_str!("../../datasets/experiments/table-2.toml")),
    ("table-2-paper-recipe", include_str!("../../datasets/experiments/table-2-paper-recipe.toml")),
    ("velocity", include_str!("../../datasets/experiments/velocity.toml")),
    ("twin-policies", include_str!("../../datasets/experiments/twin-policies.toml")),
    ("twin-payload", include_str!("../../datasets/experiments/twin-payload.toml")),
    ("dfki", include_str!("../../datasets/experiments/dfki.toml")),
    ("emps", include_str!("../../datasets/experiments/emps.toml")),
    ("kuka-kr300", include_str!("../../datasets/experiments/kuka-kr300.toml")),
    ("tx40", include_str!("../../datasets/experiments/tx40.toml")),
    ("paper-table-3", include_str!("../../datasets/experiments/paper-table-3.toml")),
    ("paper-table-4", include_str!("../../datasets/experiments/paper-table-4.toml")),
];

/// The experiment of this name.
///
/// # Errors
/// [`ExperimentError::Unknown`] lists the names that exist.
pub fn find(name: &str) -> Result<Experiment, ExperimentError> {
    let (_, text) = ALL.iter().find(|(other, _)| *other == name).ok_or_else(|| ExperimentError::Unknown {
        name: name.to_owned(),
        known: ALL.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "),
    })?;
    Experiment::parse(name, text)
}

/// The built-in experiment of this name, or the one in this TOML file.
///
/// # Errors
/// [`ExperimentError`] if there is no such experiment, or the file is none.
pub fn open(name_or_file: &str) -> Result<Experiment, ExperimentError> {
    let path = Path::new(name_or_file);
    if path.extension().is_none_or(|ending| ending != "toml") {
        return find(name_or_file);
    }
    let text = file::read_text(path).map_err(|problem| ExperimentError::Store { path: path.to_owned(), problem })?;
    Experiment::parse(name_or_file, &text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::cell;

    /// A simulated twin has another scale of torque than the paper's arm: its errors can't be held against the paper's.
    #[test]
    fn twins_are_not_compared_with_the_papers_real_arms() {
        let twins = ALL.iter().filter(|(name, _)| name.starts_with("twin"));
        assert_eq!(twins.clone().count(), 2);
        assert!(twins.into_iter().all(|(name, _)| find(name).unwrap().paper_table.is_none()));
    }

    #[test]
    fn every_experiment_can_be_read_and_planned() {
        for (name, _) in ALL {
            let experiment = find(name).unwrap();
            if !experiment.needs_data() {
                for experiment in [experiment.quick(), experiment] {
                    let cells = cell::plan(&experiment, None).unwrap();
                    assert_eq!(cells.len() as u64, experiment.models.len() as u64 * experiment.seeds, "{name}");
                }
            }
        }
    }
}
