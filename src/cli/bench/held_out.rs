//! What the held-out part counts, learned where the truth is known.

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
/// The weights are those of a logistic regression: a constant, what the log-odds of before count, and what the rise of the held-out error
/// counts.
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
        let [constant, before, rise] = held_out_weights(&examples);
        if self.json {
            let told = serde_json::json!({"asked": examples.len(), "there": there, "constant": constant, "before": before, "rise": rise});
            println!("{}", serde_json::to_string_pretty(&told)?);
        } else {
            println!("{there} of {} families that were asked about are there", examples.len());
            println!(
                "log-odds = {constant:.3} + {before:.3} × those of before + {rise:.3} × rise of the held-out error"
            );
        }
        Ok(())
    }
}

fn read(path: &std::path::Path) -> anyhow::Result<Vec<Asked>> {
    let all: Value = serde_json::from_str(&read_text(path)?)?;
    let cases = all.get("recordings").or_else(|| all.get("cases")).and_then(Value::as_array);
    let cases = cases.context("neither \"recordings\" nor \"cases\" stands there")?;
    let of_case = |case: &Value| Ok(serde_json::from_value::<Vec<Asked>>(case["asked"].clone())?);
    Ok(cases.iter().map(of_case).collect::<anyhow::Result<Vec<_>>>()?.concat())
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
                "held_out": {{"before": 0.8, "joints": 1, "rises": 1.5, "rises_in_training": 1.2}}}}"#
            )
        };
        let results = |asked: &[String]| format!(r#"{{"cases": [{{"asked": [{}]}}]}}"#, asked.join(","));
        assert!(reason(&results(&[asked(true)])).contains("of 1 families that were asked about 1 are there"));
        std::fs::write(&file, results(&[asked(true), asked(false)])).unwrap();
        told(&file).unwrap();
    }
}
