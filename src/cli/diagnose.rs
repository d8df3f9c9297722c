use clap::Args;
use serde::Serialize;

use super::data::Data;
use super::progress;
use super::table::{number, numbers, table};
use crate::diagnosis::{Alternative, Completeness, Presence, Report};
use crate::recording::finding::{Finding, Severity};
use crate::recording::joints_text;
use crate::session::Command;

/// Most candidates that are told without being part of the answer.
const MOST_REFUSED: usize = 20;

/// Say which physical effect the model is missing.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope diagnose arm.npz
  torquescope diagnose log.csv --zero down --json
  torquescope diagnose DATA_EMPS.mat --map emps
  torquescope diagnose arm.npz --model structured-delan")]
pub struct Diagnose {
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    data: Data,
}

impl Diagnose {
    /// Reads, fits, diagnoses, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let session = progress::run(Command::Diagnose, &self.data.session_with_model()?)?;
        let Some(report) = &session.report else { return Ok(()) };
        let findings: Vec<&Finding> = session.findings.iter().filter(|finding| matters(finding)).collect();
        if self.json {
            println!("{}", serde_json::to_string_pretty(&Answer { findings, report })?);
            return Ok(());
        }
        for finding in &findings {
            println!("{}: {finding}", finding.severity.word());
        }
        if !findings.is_empty() {
            println!();
        }
        println!("{}", text(report));
        Ok(())
    }
}

/// What is to be known of the recording before the report is believed, and the report.
#[derive(Serialize)]
struct Answer<'a> {
    findings: Vec<&'a Finding>,
    #[serde(flatten)]
    report: &'a Report,
}

/// Whether results may be wrong for it.
fn matters(finding: &Finding) -> bool {
    finding.severity >= Severity::Warning
}

/// The report for people.
pub fn text(report: &Report) -> String {
    let mut lines = vec![report.headline().to_owned(), String::new()];
    for (number_in_list, effect) in report.effects.iter().enumerate() {
        let name = effect.effect.name;
        let (place, sureness) = (joints_text(&effect.joints), effect.sureness());
        lines.push(format!("{}. {name}, {place} ({sureness})", number_in_list + 1));
        lines.push(format!("   held-out nMSE {} -> {}", numbers(&effect.nmse_before), numbers(&effect.nmse_after)));
        for parameter in &effect.parameters {
            let joint = parameter.joint.map_or(String::new(), |joint| format!(", joint {}", joint + 1));
            let interval =
                parameter.interval.map_or(String::new(), |[low, high]| format!(" [{}, {}]", number(low), number(high)));
            lines.push(format!(
                "   {}{joint}: {}{interval} {}",
                parameter.name,
                number(parameter.value),
                parameter.unit
            ));
        }
        if !effect.alternatives.is_empty() {
            lines.push(format!("   explains nearly as much: {}", Alternative::texts(&effect.alternatives).join(", ")));
        }
        lines.push(String::new());
    }
    let presence: Vec<Vec<String>> = report
        .presence
        .iter()
        .map(|one| {
            let mut row = vec![
                one.place(),
                format!("{:.0} %", 100.0 * one.probability),
                one.likelihood().to_owned(),
                one.effect.name.to_owned(),
                format!("{:.1} %", 100.0 * one.share),
            ];
            if report.asks_held_out() {
                row.push(one.missed());
            }
            row
        })
        .collect();
    if !presence.is_empty() {
        let mut titles = vec!["what kind, where", "presence", " ", " likeliest form", "of the measured"];
        if report.asks_held_out() {
            titles.push(Presence::MISSED);
        }
        lines.extend([table(&titles, &presence), String::new()]);
    }
    lines.extend(report.completeness.iter().map(Completeness::text));
    lines.push(String::new());
    let accepted = report.ranking.iter().filter(|candidate| candidate.accepted()).count();
    let told = report.ranking.len().min(accepted + MOST_REFUSED);
    let rows: Vec<Vec<String>> = report.ranking[..told]
        .iter()
        .map(|candidate| {
            vec![
                candidate.effect.id.to_owned(),
                candidate.joint.map_or("all".to_owned(), |joint| (joint + 1).to_string()),
                candidate.divides(),
                if candidate.accepted() { "yes" } else { "no" }.to_owned(),
                candidate.reason(),
            ]
        })
        .collect();
    if !rows.is_empty() {
        lines.push(table(&["candidate", "joint", "alone, error", "found", " why"], &rows));
        let others = report.ranking.len() - told;
        if others > 0 {
            lines.push(format!("… and {others} more candidates, which --json tells"));
        }
        lines.push(String::new());
    }
    lines.push(format!("held-out nMSE by joint: {}", numbers(&report.held_out_nmse)));
    if let Some(floor) = &report.noise_floor_nmse {
        lines.push(format!("noise floor by joint:   {}", numbers(floor)));
    }
    lines.push(String::new());
    lines.push(report.advice());
    lines.join("\n")
}
