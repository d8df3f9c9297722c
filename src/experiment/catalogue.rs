//! Experiments that come with the program: one file in `datasets/experiments/` and one line here.

use super::{Experiment, ExperimentError};

/// Name and text of each, in the order in which lists show them.
pub const ALL: &[(&str, &str)] = &[
    ("table-2", include_str!("../../datasets/experiments/table-2.toml")),
    ("velocity", include_str!("../../datasets/experiments/velocity.toml")),
    ("twin-policies", include_str!("../../datasets/experiments/twin-policies.toml")),
    ("twin-payload", include_str!("../../datasets/experiments/twin-payload.toml")),
    ("dfki", include_str!("../../datasets/experiments/dfki.toml")),
    ("paper-table-3", include_str!("../../datasets/experiments/paper-table-3.toml")),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::cell;

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
