//! The diagnosis where other physics made the truth: recordings with a file beside each that says what acts there, and worlds of
//! rigid bodies.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use super::rates::{percent, print_forms, print_reliability};
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::simulation::world;
use crate::trial::TrialError;
use crate::trial::foreign::{Answered, Class, Foreign, Summary};
use crate::trial::verdict::Verdict;
use crate::trial::world::WorldTrial;

/// Diagnoses the recordings of a folder and tells how that went.
pub fn run(folder: &Path, as_json: bool, list: bool) -> anyhow::Result<()> {
    let recordings = recordings_in(folder)?;
    let summary = progress::watch("bench diagnosis", move |monitor| {
        let count = recordings.len() as f32;
        let run = |(number, recording): (usize, &Foreign)| {
            monitor.report(number as f32 / count, "diagnosing")?;
            recording.run(monitor)
        };
        Ok::<_, TrialError>(Summary::of(recordings.iter().enumerate().map(run).collect::<Result<_, _>>()?))
    })?;
    print(&summary, as_json, list)
}

/// Draws worlds, diagnoses their logs and tells how that went.
pub fn run_worlds(seeds: Range<u64>, class: Option<world::Class>, as_json: bool, list: bool) -> anyhow::Result<()> {
    let summary = progress::watch("bench diagnosis", move |monitor| {
        let count = (seeds.end - seeds.start) as f32;
        let run = |seed: u64| {
            monitor.report((seed - seeds.start) as f32 / count, "simulating and diagnosing")?;
            WorldTrial::draw(seed, class)?.run(monitor)
        };
        Ok::<_, TrialError>(Summary::of(seeds.clone().map(run).collect::<Result<_, _>>()?))
    })?;
    print(&summary, as_json, list)
}

fn print(summary: &Summary, as_json: bool, list: bool) -> anyhow::Result<()> {
    if as_json {
        println!("{}", serde_json::to_string_pretty(summary)?);
    } else {
        print_summary(summary);
    }
    if list {
        summary.recordings.iter().for_each(|answered| eprintln!("{}", tell_answered(answered)));
    }
    Ok(())
}

/// The recordings of a folder that have a file which says what acts there, by name.
fn recordings_in(folder: &Path) -> anyhow::Result<Vec<Foreign>> {
    let entries = fs::read_dir(folder).with_context(|| format!("can't read the folder {}", folder.display()))?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<PathBuf>>>()?;
    let is_recording = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "npz");
    let mut paths: Vec<PathBuf> = paths.into_iter().filter(is_recording).collect();
    paths.sort();
    if paths.is_empty() {
        bail!("{} holds no NAME.npz with NAME.json beside it", folder.display());
    }
    let foreign = |path: PathBuf| {
        let about = path.with_extension("json");
        let text = fs::read_to_string(&about)
            .with_context(|| format!("can't read {}, which has to say what acts in the recording", about.display()))?;
        Ok(Foreign::new(path, &text)?)
    };
    paths.into_iter().map(foreign).collect()
}

/// One recording in a few words: what was named with what it is, and what was missed.
fn tell_answered(answered: &Answered) -> String {
    let names = answered
        .names
        .iter()
        .map(|name| format!("{}@{} {:.2} {}", name.effect, at(name.joint), name.confidence, word(name.verdict)));
    let missed = answered.wanted.iter().filter(|wanted| wanted.named.is_none());
    format!(
        "{} ({}): {}; named {}; missed {}{}",
        answered.name,
        answered.kind,
        if answered.exact {
            "exact"
        } else if answered.in_family {
            "in family"
        } else {
            "not exact"
        },
        names.collect::<Vec<_>>().join(", "),
        missed.map(|wanted| format!("{}@{}", wanted.effect, at(wanted.joint))).collect::<Vec<_>>().join(", "),
        if answered.flagged { "; flagged" } else { "" },
    )
}

/// A joint counted from 1, for people.
pub(super) fn at(joint: Option<usize>) -> String {
    joint.map_or("all".to_owned(), |joint| joint.to_string())
}

pub(super) fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Right => "right",
        Verdict::Form => "form",
        Verdict::Beside => "beside",
        Verdict::WrongJoint => "wrong joint",
        Verdict::StandIn => "stand-in",
        Verdict::False => "false",
    }
}

fn print_summary(summary: &Summary) {
    let of_class = |class: &Class| {
        vec![
            class.kind.clone(),
            class.recordings.to_string(),
            percent(class.exact),
            percent(class.in_family),
            format!("{} / {} / {}", class.right, class.form, class.missed),
            format!("{:.2}", class.false_names),
            format!("{:.2}", class.stand_ins),
            percent(class.flagged),
        ]
    };
    let cells: Vec<Vec<String>> = summary.classes.iter().map(of_class).collect();
    let header = [
        "class",
        "recordings",
        "exact",
        "in family",
        "strong: right / form / missed",
        "false names each",
        "stand-ins each",
        "flagged",
    ];
    println!("{}\n", table(&header, &cells));
    let count = |verdict: Verdict| {
        let names = summary.recordings.iter().flat_map(|answered| &answered.names);
        names.filter(|name| name.verdict == verdict).count().to_string()
    };
    let rows = Verdict::ALL.map(|verdict| vec![word(verdict).to_owned(), count(verdict)]);
    println!("{}\n", table(&[&format!("{} names", summary.names), "count"], &rows));
    let rows = [
        (format!("names at 90 % or more ({}): right", summary.sure_names), percent(summary.sure_right)),
        ("the same: right, another form or beside".to_owned(), percent(summary.sure_good)),
        (format!("strong effects (of {}) present at 90 % or more", summary.wanted), percent(summary.wanted_sure)),
        (format!("something unknown that shows (of {}): flagged", summary.showing), percent(summary.showing_flagged)),
        (format!("95 % interval holds truth (of {})", summary.intervals), percent(summary.coverage)),
        ("calibration error".to_owned(), summary.calibration_error.map_or("–".to_owned(), number)),
        ("s each".to_owned(), number(summary.seconds_per_recording)),
        ("s, the slowest".to_owned(), number(summary.seconds_of_slowest)),
    ];
    let cells: Vec<Vec<String>> = rows.into_iter().map(|(name, value)| vec![name, value]).collect();
    println!("{}\n", table(&["names and intervals", "rate"], &cells));
    print_reliability(&summary.reliability);
    println!();
    print_forms(&summary.forms);
}
