//! What the held-out part counts, learned where the truth is known.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use serde_json::Value;

use crate::diagnosis::{HeldOut, held_out_weights};
use crate::file::read_text;
use crate::trial::foreign::Asked;

/// Learns how much it says for an effect that the error rises without it where it is held out: what `bench diagnosis --json` (of worlds or
/// recordings) and `bench planted --json` have seen is laid beside whether the effect is there.
///
/// The weights are those of a logistic regression: a constant, what the log-odds of before count, what t of the rise over pieces of the
/// held-out part does, and what the rise in training does.
#[derive(Args)]
#[command(after_help = "Example:
  torquescope bench held-out worlds.json planted.json  # which `bench diagnosis --world --json` and `bench planted --json` printed")]
pub struct HeldOutBench {
    /// What these benches printed as JSON.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

impl HeldOutBench {
    /// Reads, learns, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let mut examples: Vec<(HeldOut, bool)> = Vec::new();
        for path in &self.files {
            let asked = read(path).with_context(|| format!("{} is no result of these benches", path.display()))?;
            examples.extend(asked.into_iter().map(|asked| (asked.held_out, asked.is_there)));
        }
        let there = examples.iter().filter(|(_, is_there)| *is_there).count();
        anyhow::ensure!(
            there > 0 && there < examples.len(),
            "of {} families that were asked about {there} are there: nothing can be learned; give more results",
            examples.len()
        );
        let [constant, before, t, in_training] = held_out_weights(&examples);
        if self.json {
            let told = serde_json::json!({"asked": examples.len(), "there": there, "constant": constant, "before": before, "t": t, "in_training": in_training});
            println!("{}", serde_json::to_string_pretty(&told)?);
        } else {
            println!("{there} of {} families that were asked about are there", examples.len());
            println!(
                "log-odds = {constant:.3} + {before:.3} × those of before + {t:.3} × t of the rise where it is held out + {in_training:.3} × e-folds of the rise in training"
            );
        }
        Ok(())
    }
}

fn read(path: &std::path::Path) -> anyhow::Result<Vec<Asked>> {
    let all: Value = serde_json::from_str(&read_text(path)?)?;
    let asked = |cases: &str| -> Option<anyhow::Result<Vec<Asked>>> {
        let of_case = |case: &Value| Ok(serde_json::from_value::<Vec<Asked>>(case["asked"].clone())?);
        let cases = all.get(cases)?.as_array()?;
        Some(cases.iter().map(of_case).collect::<anyhow::Result<Vec<_>>>().map(|cases| cases.concat()))
    };
    let of_log = || asked("cases").map(|asked| asked.map(once));
    asked("recordings").or_else(of_log).context("neither \"recordings\" nor \"cases\" stands there")?
}

/// What is not planted in a case is not there in any of this log: it counts once.
fn once(asked: Vec<Asked>) -> Vec<Asked> {
    let mut absent = BTreeSet::new();
    let is_new = |one: &Asked| one.is_there || absent.insert((one.effect.clone(), one.joint));
    asked.into_iter().filter(is_new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(file: &std::path::Path) -> anyhow::Result<()> {
        HeldOutBench { files: vec![file.to_owned()], json: true }.run()
    }

    #[test]
    fn results_without_a_question_and_other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("result.json");
        let reason = |text: &str| {
            std::fs::write(&file, text).unwrap();
            format!("{:#}", told(&file).unwrap_err())
        };
        assert!(reason("{}").contains("neither"), "{}", reason("{}"));
        assert!(reason(r#"{"recordings": [{}]}"#).contains("no result of these benches"));
        let asked = |is_there: bool| {
            format!(
                r#"{{"effect": "cogging", "joint": 1, "is_there": {is_there},
                "held_out": {{"before": 0.8, "rises": 1.5, "rises_in_training": 1.2, "t": 1.5}}}}"#
            )
        };
        let results = |asked: &[String]| format!(r#"{{"recordings": [{{"asked": [{}]}}]}}"#, asked.join(","));
        assert!(reason(&results(&[asked(true)])).contains("of 1 families that were asked about 1 are there"));
        std::fs::write(&file, results(&[asked(true), asked(false)])).unwrap();
        told(&file).unwrap();
    }

    #[test]
    fn what_a_log_does_not_have_counts_once_in_all_its_cases() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("result.json");
        let asked = |joint: usize, is_there: bool| {
            format!(
                r#"{{"asked": [{{"effect": "cogging", "joint": {joint}, "is_there": {is_there},
                "held_out": {{"before": 0.8, "rises": 1.5, "rises_in_training": 1.2, "t": 1.5}}}}]}}"#
            )
        };
        let all = [asked(1, true), asked(1, true), asked(2, false), asked(2, false), asked(1, false)].join(",");
        let counted = |cases: &str| {
            std::fs::write(&file, format!(r#"{{"{cases}": [{all}]}}"#)).unwrap();
            read(&file).unwrap().into_iter().map(|one| (one.joint, one.is_there)).collect::<Vec<_>>()
        };
        let each = [(Some(1), true), (Some(1), true), (Some(2), false), (Some(1), false)];
        assert_eq!(counted("cases"), each);
        assert_eq!(counted("recordings").len(), 5, "each is an arm for itself");
    }
}
