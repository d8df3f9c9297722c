//! How far to trust the diagnosis on one's own robot: effects planted into its log, and into twins of it.

use clap::Args;

use super::rates::{percent, print_reliability};
use super::recordings::{at, word};
use crate::cli::data::Files;
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::trial::foreign::Name;
use crate::trial::planted::{Before, Detection, Fared, Group, Plan, STRENGTHS, Summary, Tried};

/// How often the diagnosis finds what is planted into your own recording, and how often it names what is not there.
///
/// Each draw plants one effect of the catalogue, drawn by a seed with its joint and its parameters, into the measured torque and
/// asks for a diagnosis beside a rigid body. What was named before may be named again; then its parameter has to grow by what was
/// planted. Names that are new and were not planted are false; names that are gone are lost. A strength is that within the band in
/// which models are compared. What a rigid body takes up where models learn, together with the friction and offsets that nearly every
/// joint has, is not planted, nor is what hardly acts there, or what the log can't have, such as late velocities where they are derived
/// from the positions.
///
/// A twin is the log made anew from its rigid body and the effects that were named, as they were fitted, with what they leave
/// as noise, moved in time; up to three effects are planted there. In a twin all that is there is known, so every name is
/// right or false.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench planted my-log.csv --zero down
  torquescope bench planted DATA_EMPS.mat --map emps --draws 40 --twins 20
  torquescope bench planted log.npz --strengths 0.05,0.2 --draws 20 --twins 0 --list")]
pub struct Planted {
    #[command(flatten)]
    files: Files,
    /// How many effects are planted into the log, one at a time; the strengths take turns.
    #[arg(long, default_value_t = 16)]
    draws: u64,
    /// How many twins are made.
    #[arg(long, default_value_t = 4)]
    twins: u64,
    /// First seed: each draw has the next one.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Torque of the planted effects, as shares (RMS) of that of the joints that feel them: above 0 to 1.
    #[arg(long, value_name = "SHARES", value_delimiter = ',', default_values_t = STRENGTHS, value_parser = strength)]
    strengths: Vec<f64>,
    /// Tell what became of every case.
    #[arg(long)]
    list: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

fn strength(text: &str) -> Result<f64, String> {
    let share: f64 = text.trim().parse().map_err(|_| format!("`{text}` is not a number"))?;
    let is_share = share > 0.0 && share <= 1.0;
    is_share
        .then_some(share)
        .ok_or_else(|| "a strength is a share of the torque, above 0 to 1 (0.05 is 5 %)".to_owned())
}

impl Planted {
    /// Reads, diagnoses, plants, diagnoses again, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let session = self.files.session()?;
        let Some(recording) = session.recording else { return Ok(()) };
        let plan = Plan { draws: self.draws, twins: self.twins, seed: self.seed, strengths: self.strengths.clone() };
        let split = session.split;
        let summary = progress::watch("bench planted", move |monitor| plan.of_recording(&recording, &split, monitor))?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&summary)?);
        } else {
            print(&summary);
        }
        if self.list {
            summary.cases.iter().for_each(|tried| eprintln!("{}", tell(tried)));
        }
        Ok(())
    }
}

fn print(summary: &Summary) {
    let Summary { before, planted, twins, .. } = summary;
    println!("named before anything was planted: {}\n", names_text(before));
    if planted.cases > 0 {
        println!("{} effects planted into the log, one at a time:\n", planted.cases);
        print_found(planted);
    }
    if twins.cases > 0 {
        println!("{} twins of the log, with up to three effects planted in each:\n", twins.cases);
        print_found(twins);
    }
}

fn print_found(group: &Group) {
    let header = |first| {
        [
            first,
            "planted, not named before",
            "named now",
            "at 90 % or more",
            "named before",
            "its parameter followed by",
        ]
    };
    let cells = |(title, fared): (String, &Fared)| {
        let Fared { planted, named, sure, there_before, followed, .. } = fared;
        let mut cells = vec![title];
        cells.extend([planted, named, sure, there_before].map(ToString::to_string));
        cells.push(percent(*followed));
        cells
    };
    let strengths = group.by_strength.iter().map(|fared| (format!("up to {} %", number_of(fared.strength)), fared));
    println!("{}\n", table(&header("strength"), &strengths.map(cells).collect::<Vec<_>>()));
    let effects = group.by_effect.iter().map(|(effect, fared)| (effect.clone(), fared));
    println!("{}\n", table(&header("effect"), &effects.map(cells).collect::<Vec<_>>()));
    let plain = |value: Option<f64>| value.map_or("–".to_owned(), number);
    let rows = [
        ("false names a case", plain(group.false_names)),
        ("false names a case, at 90 % or more", plain(group.sure_false_names)),
        ("false names a case, likely (50 % or more) before", plain(group.likely_before)),
        ("false names a case, of what nearly every joint has", plain(group.everyday)),
        ("names a case that were there before and are lost", plain(group.lost)),
        ("calibration error", plain(group.calibration_error)),
        ("95 % interval holds truth", percent(group.coverage)),
        ("said to have more than is named", percent(group.flagged)),
        ("s each", number(group.seconds_per_case)),
    ];
    let cells: Vec<Vec<String>> = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect();
    println!("{}\n", table(&[&format!("{} cases", group.cases), "rate"], &cells));
    if !group.reliability.is_empty() {
        print_reliability(&group.reliability);
        println!();
    }
}

/// A share in per cent, without digits that say nothing.
fn number_of(share: f64) -> String {
    let percent = 100.0 * share;
    format!("{}", (1e3 * percent).round() / 1e3)
}

/// Names with their joints and confidences.
pub(super) fn names_text(names: &[Name]) -> String {
    let text = |name: &Name| format!("{}@{} ({:.0} %)", name.effect, at(name.joint), 100.0 * name.confidence);
    match names {
        [] => "nothing".to_owned(),
        names => names.iter().map(text).collect::<Vec<_>>().join(", "),
    }
}

/// One case in a line.
fn tell(tried: &Tried) -> String {
    let planted = |detection: &Detection| {
        let Detection { planting, before, named, confidence } = detection;
        let before = match before {
            Before::Absent => String::new(),
            Before::AsAnotherForm => ", another form was named before".to_owned(),
            Before::There { followed } => format!(", was named before: followed by {}", percent(*followed)),
        };
        let found = match (named, confidence) {
            (Some(verdict), Some(confidence)) => format!("{} at {:.0} %", word(*verdict), 100.0 * confidence),
            _ => "not named".to_owned(),
        };
        let strength = number_of(planting.strength);
        format!("{}@{} of {strength} %: {found}{before}", planting.effect, at(planting.joint))
    };
    let planted: Vec<String> = tried.detections.iter().map(planted).collect();
    format!(
        "{}: {}; false: {}; lost: {}{}",
        tried.answered.name,
        if planted.is_empty() { "nothing planted".to_owned() } else { planted.join(", ") },
        names_text(&tried.false_names),
        names_text(&tried.lost),
        if tried.answered.flagged { "; more is left than noise" } else { "" },
    )
}
