use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use super::data::Data;
use super::failure::OrUsage;
use super::table::{number, table};
use super::{progress, write_file};
use crate::diagnosis::proposal::{Proposal, Proposals, percent};
use crate::recording::Recording;
use crate::session::{Command, Session, SessionError};

/// Say on what the remainder of a model depends, and propose formulas for it.
///
/// For what no effect of the catalogue explains. Each formula stands beside the model and those before it on its joint; --adopt
/// writes one as an effect of your own, which --effect-file gives to other commands.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope propose arm.npz
  torquescope propose arm.npz --add viscous-friction --add coulomb-friction --json
  torquescope propose arm.npz --diagnosed --adopt 1 -o drag.toml")]
pub struct Propose {
    /// First add what the diagnosis names.
    #[arg(long)]
    diagnosed: bool,
    /// Write this proposal, by its number, as an effect of your own.
    #[arg(long, value_name = "NUMBER", requires = "output")]
    adopt: Option<usize>,
    /// Where to write it.
    #[arg(short, long, value_name = "EFFECT.toml", requires = "adopt")]
    output: Option<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    data: Data,
}

impl Propose {
    /// Reads, fits, asks, prints, writes.
    pub fn run(&self) -> anyhow::Result<()> {
        self.output.iter().try_for_each(|path| self.data.check_output(path))?;
        let mut session = self.data.session_with_model()?;
        if self.diagnosed {
            session = with_named(&session)?;
        }
        let session = progress::run(Command::Propose, &session)?;
        let recording = session.recording.as_deref().context("no recording was read")?;
        let Some(proposals) = session.proposals.as_deref() else { return Ok(()) };
        if self.json {
            println!("{}", serde_json::to_string_pretty(proposals)?);
        } else {
            println!("{}", text(proposals, recording));
        }
        if let (Some(number), Some(path)) = (self.adopt, &self.output) {
            let count = proposals.formulas.len();
            let chosen = number.checked_sub(1).and_then(|place| proposals.formulas.get(place));
            let chosen = chosen.ok_or(SessionError::NoSuchProposal { number, count }).or_usage()?;
            let draft = chosen.draft(recording.joints[chosen.joint].kind);
            write_file(path, draft.to_toml().as_bytes())?;
            if !self.json {
                let (path, id, joint) = (path.display(), &draft.id, chosen.joint + 1);
                progress::told(format_args!("\nsaved {path}: --effect-file {path} --add {id}@{joint}"));
            }
        }
        Ok(())
    }
}

/// The session with everything that the diagnosis names and a model can have.
fn with_named(session: &Session) -> anyhow::Result<Session> {
    let diagnosed = progress::run(Command::Diagnose, session)?;
    let effects = diagnosed.report.as_ref().map_or(Vec::new(), |report| report.effects.clone());
    let addable = effects.into_iter().filter(|effect| effect.effect.check_addable().is_ok());
    addable.into_iter().try_fold(diagnosed, |session, effect| {
        progress::run(Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints }, &session)
    })
}

/// The answer for people.
fn text(proposals: &Proposals, recording: &Recording) -> String {
    let mut lines = Vec::new();
    for remainder in &proposals.remainders {
        lines.push(remainder.sentence(&recording.joints[remainder.joint]));
        lines.extend(remainder.dependence().into_iter().map(|(how, channels)| format!("   {how:8} {channels}")));
        lines.push(String::new());
    }
    if proposals.formulas.is_empty() {
        lines.push("No formula is stable enough to be proposed.".to_owned());
        return lines.join("\n");
    }
    lines.push("Formulas, each beside the model and those before it on its joint:".to_owned());
    lines.push(String::new());
    let row = |(place, proposal): (usize, &Proposal)| {
        vec![
            (place + 1).to_string(),
            (proposal.joint + 1).to_string(),
            number(proposal.value),
            interval(proposal.interval, number),
            format!("{} * {}", proposal.unit, proposal.formula),
            percent(proposal.share),
            interval(proposal.share_interval, percent),
            percent(proposal.stability),
        ]
    };
    let rows: Vec<Vec<String>> = proposals.formulas.iter().enumerate().map(row).collect();
    let heads =
        ["", "joint", "factor", "95 % interval", " torque", "of the remainder", "95 % interval", "chosen by halves"];
    lines.push(table(&heads, &rows));
    for (place, proposal) in proposals.formulas.iter().enumerate() {
        let remarks = proposal.remarks(&recording.joints[proposal.joint]);
        lines.extend(remarks.into_iter().map(|remark| format!("{}. {remark}", place + 1)));
    }
    lines.push(String::new());
    lines.push("A formula is no law: try it on other recordings, and ask what it could be.".to_owned());
    lines.join("\n")
}

fn interval(interval: Option<[f64; 2]>, text: impl Fn(f64) -> String) -> String {
    interval.map_or("–".to_owned(), |[low, high]| format!("{} … {}", text(low), text(high)))
}
