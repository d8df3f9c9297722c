//! A tiny part of the selftest, whose measures count what goes wrong: they work, and nothing does.

use std::path::Path;

use crate::runner::{fails, json};

#[test]
fn a_tiny_part_of_every_quick_measure_passes() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["selftest", "logs", "crafted", "documents", "faults", "places", "--cases", "3", "--json"];
    let taken = json(&arguments, folder.path());
    let taken = taken.as_array().unwrap();
    assert_eq!(taken.len(), 5);
    for measure in taken {
        assert_eq!(measure["passed"], true, "{measure}");
        assert!(measure["cases"].as_u64().unwrap() >= 3 && !measure["counts"].as_object().unwrap().is_empty());
    }
    assert!(folder.path().read_dir().unwrap().next().is_none(), "it writes into folders of its own");
}

#[test]
fn an_unknown_measure_is_told_with_those_that_are_known() {
    let message = fails(&["selftest", "luck"], Path::new("."), 2);
    assert!(message.contains("luck") && message.contains("logs, crafted, documents, faults"), "{message}");
}

/// Every measure has its row, with its command and what was measured.
#[test]
fn the_scoreboard_tells_every_measure() {
    let scoreboard = include_str!("../SCOREBOARD.md");
    for measure in torquescope::selftest::MEASURES {
        let command = format!("`torquescope selftest {} --long`", measure.id);
        assert!(scoreboard.contains(&command), "{} is not told", measure.id);
    }
}
