use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use super::rates::{percent, print_reliability};
use super::recordings;
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::cli::world::Class;
use crate::cli::write_file;
use crate::diagnosis::{Alternative, MissingEffect};
use crate::effect::registry;
use crate::figure;
use crate::simulation::{Excitation, Scenario};
use crate::trial::blind::{Drawing, Trial};
use crate::trial::rates::{EffectRates, Rates};
use crate::trial::{TrialError, answer_of};

/// How often the diagnosis is right on blind draws: arm, motion, noise, sensors, effects, strengths and joints are random.
///
/// The diagnosis sees the recording only; the seal is opened afterwards to score it. A draw is exact if all effects and all
/// their joints are named and nothing else. Of every eight draws two hide nothing, two hide one effect, two hide two, one
/// hides three, and in one the single hidden effect is left out of the candidates, so that it is unknown. All effects of the
/// catalogue are hidden; one that no data tell from a sum of others is to be named as that sum.
///
/// The evidence suffices if the true set, with its true shapes, beats each set that lacks one of its effects, has another one in its
/// place, or two everyday ones with no more parameters, by what a name needs: 1.5 ln(samples) for each parameter. Rates are about draws
/// where it does; those about all draws are beside them.
///
/// With --recordings the truth was made by others: a folder of NAME.npz, each with a NAME.json that says what acts there. An
/// answer is exact if every strong effect is named as what it is and nothing falsely; in family if another form of it will do.
/// With --world rigid bodies made it, and what has at least 3 % of its joint's torque is strong.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench diagnosis --draws 40
  torquescope bench diagnosis --draws 200 --seed 110000 --figures figures
  torquescope bench diagnosis --draws 80 --unknown --list")]
pub struct Diagnosis {
    /// How many recordings.
    #[arg(long, default_value_t = 40)]
    draws: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Hide always this many effects (0 to 3), all of them known.
    #[arg(long, value_parser = clap::value_parser!(u8).range(0..=3))]
    hidden: Option<u8>,
    /// Leave the hidden effect out of the candidates in every draw.
    #[arg(long, conflicts_with = "hidden")]
    unknown: bool,
    /// Hide only these effects.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// The embedded arm and kind of motion, exact accelerations and 2 % noise in every draw.
    #[arg(long)]
    embedded: bool,
    /// Diagnose these recordings instead of draws: NAME.npz with NAME.json each.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["draws", "seed", "hidden", "unknown", "only", "embedded", "figures"])]
    pub(super) recordings: Option<PathBuf>,
    /// Diagnose logs of worlds of rigid bodies that a servo moves, instead of torques of a prescribed motion; classes take turns
    /// with the seeds.
    #[arg(long, conflicts_with_all = ["hidden", "unknown", "only", "embedded", "figures", "recordings"])]
    pub(super) world: bool,
    /// Only worlds of this class.
    #[arg(long, requires = "world")]
    class: Option<Class>,
    /// Tell every draw that was not exact, and every unknown one; of recordings every name and what was missed.
    #[arg(long)]
    pub(super) list: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
    /// Save the confusion matrix and the reliability diagram in this folder, as SVG and CSV.
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
}

impl Diagnosis {
    /// Draws worlds, diagnoses, prints.
    pub(super) fn run_worlds(&self) -> anyhow::Result<()> {
        let seeds = self.seed..self.seed.saturating_add(self.draws);
        recordings::run_worlds(seeds, self.class.map(Into::into), self.json, self.list)
    }

    /// Draws, diagnoses, prints.
    pub(super) fn run(&self) -> anyhow::Result<()> {
        for id in &self.only {
            registry::find(id)?;
        }
        let drawing = Drawing {
            hidden: self.hidden.map(usize::from),
            unknown: self.unknown,
            only: self.only.clone(),
            embedded: self.embedded,
        };
        let (draws, seed) = (self.draws, self.seed);
        let trials = progress::watch("bench diagnosis", move |monitor| {
            let draw = |number: u64| {
                monitor.report(number as f32 / draws as f32, "drawing and diagnosing")?;
                drawing.case(seed + number).run(monitor)
            };
            (0..draws).map(draw).collect::<Result<Vec<Trial>, TrialError>>()
        })?;
        let rates = Rates::of(&trials);
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rates)?);
        } else {
            print(&rates);
        }
        if let Some(folder) = &self.figures {
            save_figures(&rates, &trials, folder)?;
        }
        if self.list {
            trials
                .iter()
                .filter(|trial| trial.unknown || !trial.is_exact())
                .for_each(|trial| eprintln!("{}", tell(trial)));
        }
        Ok(())
    }
}

fn save_figures(rates: &Rates, trials: &[Trial], folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let hidden: Vec<String> = rates.confusion.keys().cloned().collect();
    let named: BTreeSet<&String> = rates.confusion.values().flat_map(BTreeMap::keys).collect();
    let named: Vec<String> = named.into_iter().cloned().collect();
    let count = |row: &String, column: &String| rates.confusion[row].get(column).copied().unwrap_or(0);
    let row = |hidden: &String| named.iter().map(|named| count(hidden, named)).collect();
    let counts: Vec<Vec<usize>> = hidden.iter().map(row).collect();
    let confidences: Vec<(f64, bool)> = trials.iter().flat_map(Trial::confidences).collect();
    let figures = [
        ("confusion", figure::diagnosis::confusion(&hidden, &named, &counts)),
        ("reliability", figure::diagnosis::reliability(&confidences, 10)),
    ];
    for (name, drawn) in figures {
        for (ending, format) in [("svg", figure::Format::Svg), ("csv", figure::Format::Csv)] {
            let path = folder.join(name).with_extension(ending);
            write_file(&path, &figure::render(&drawn, format, &figure::Style::default())?)?;
            eprintln!("saved {}", path.display());
        }
    }
    Ok(())
}

/// A joint counted from 0, for people.
fn place_text(place: Option<usize>) -> String {
    place.map_or("all".to_owned(), |joint| (joint + 1).to_string())
}

/// One draw in a line.
fn tell(trial: &Trial) -> String {
    let Trial { report, seed, .. } = trial;
    let expected = trial.expected();
    let hidden: Vec<String> =
        expected.iter().map(|(effect, joint)| format!("{effect}@{}", place_text(*joint))).collect();
    let named = |named: &MissingEffect| {
        let joints: Vec<String> = answer_of(named).iter().map(|(_, joint)| place_text(*joint)).collect();
        let alternatives = Alternative::texts(&named.alternatives);
        format!("{}@{} {:.2} [{}]", named.effect.id, joints.join(","), named.presence, alternatives.join("|"))
    };
    let named: Vec<String> = report.effects.iter().map(named).collect();
    let Scenario { arm, torque_noise, encoder_resolution, motion, stated, .. } = &trial.scenario;
    let missed = report.ranking.iter().filter(|candidate| {
        !candidate.accepted() && expected.contains(&(candidate.effect.id.to_owned(), candidate.joint))
    });
    let missed: Vec<String> = missed
        .map(|candidate| format!("{}@{}: {}", candidate.effect.id, place_text(candidate.joint), candidate.reason()))
        .collect();
    format!(
        "seed {seed}{}: {} joints, {}, noise {:.1} %{}{}; hidden {}; named {}; left on {:?}; {}; sufficiency {:.2}",
        if trial.unknown { " (unknown)" } else { "" },
        arm.joint_count(),
        if matches!(motion, Excitation::MultiSine { .. }) { "sines" } else { "point to point" },
        100.0 * torque_noise,
        if encoder_resolution.is_some() { ", encoders" } else { "" },
        if *stated { ", stated" } else { "" },
        hidden.join(" "),
        named.join("; "),
        report.unexplained_joints.iter().map(|joint| joint + 1).collect::<Vec<_>>(),
        missed.join("; "),
        trial.sufficiency,
    )
}

fn print(rates: &Rates) {
    let plain = |value: Option<f64>| value.map_or("–".to_owned(), number);
    let rows = [
        ("exact", percent(rates.exact)),
        ("exact, of all draws", percent(rates.exact_of_all)),
        ("evidence suffices", percent(rates.sufficient)),
        ("silent where nothing is hidden", percent(rates.silent)),
        ("exact, one effect", percent(rates.one)),
        ("exact, two effects", percent(rates.two)),
        ("exact, three effects", percent(rates.three)),
        ("first named is right", percent(rates.first_right)),
        ("unknown effect flagged", percent(rates.unknown_flagged)),
        ("unknown effect: all names doubted", percent(rates.unknown_doubted)),
        ("flagged although exact", percent(rates.false_flags)),
        ("95 % interval holds truth", percent(rates.coverage)),
        ("error / noise floor", plain(rates.error_over_noise_floor)),
        ("calibration error", plain(rates.calibration_error)),
        ("s each", number(rates.seconds_per_recording)),
        ("s, the slowest", number(rates.seconds_of_slowest)),
        ("samples each", number(rates.samples_per_recording)),
    ];
    let cells: Vec<Vec<String>> = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect();
    println!("{}\n", table(&[&format!("{} draws", rates.draws), "rate"], &cells));
    let of_effect = |(id, rates): (&&str, &EffectRates)| {
        vec![(*id).to_owned(), rates.hidden.to_string(), rates.named.to_string(), rates.named_falsely.to_string()]
    };
    let cells: Vec<Vec<String>> = rates.by_effect.iter().map(of_effect).collect();
    println!("{}\n", table(&["effect", "hidden", "named", "named falsely"], &cells));
    print_reliability(&rates.reliability);
}
