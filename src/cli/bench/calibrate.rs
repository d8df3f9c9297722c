use std::path::PathBuf;

use clap::{Args, Parser};

use crate::cli::data::Files;
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::cli::write_file;
use crate::diagnosis::presence::calibration::Calibration;
use crate::progress::Monitor;
use crate::session::Session;
use crate::trial::TrialError;
use crate::trial::calibration::{Labelled, Quality, cross_validate, label_all, learn};
use crate::trial::planted::Log;

/// Learns how sure a diagnosis may be, where the truth is known.
///
/// What the data say of every family of effects is laid beside whether it is there: in blind draws of our own formulas, in worlds
/// of rigid bodies, and in twins of real logs. A logistic map is learned from it. How well it does is measured on recordings that
/// it has not seen: each tenth of them by a map that was learned on the other nine.
///
/// A diagnosis judges what is in doubt one after the other, by the map that the program has; so a new map is one of a series, and learning
/// it again gives another one that is about as good.
#[derive(Args)]
#[command(after_help = "Example:
  torquescope bench calibrate --draws 80 --worlds 240 --twins 20 --log 'DATA_EMPS.mat --map emps' -o presence.json")]
pub struct Calibrate {
    /// How many blind draws of our own formulas.
    #[arg(long, default_value_t = 80)]
    draws: u64,
    /// How many worlds.
    #[arg(long, default_value_t = 240)]
    worlds: u64,
    /// A real log, with the options that it is read with; may be repeated.
    #[arg(long, value_name = "'FILES OPTIONS'", value_parser = parse_log)]
    log: Vec<LogOptions>,
    /// How many twins of each log.
    #[arg(long, default_value_t = 20)]
    twins: u64,
    /// First seed of all.
    #[arg(long, default_value_t = 500_000)]
    seed: u64,
    /// Write the map to this file.
    #[arg(long, short)]
    output: Option<PathBuf>,
    /// Write what was seen in each recording to this file, a line of JSON for each.
    #[arg(long, value_name = "FILE")]
    examples: Option<PathBuf>,
    /// Print the qualities as JSON.
    #[arg(long)]
    json: bool,
}

/// A log as a command reads it.
#[derive(Debug, Clone, Parser)]
#[command(name = "log", no_binary_name = true)]
struct LogOptions {
    #[command(flatten)]
    files: Files,
    /// What it was parsed from.
    #[arg(skip)]
    text: String,
}

fn parse_log(text: &str) -> Result<LogOptions, String> {
    let options = LogOptions::try_parse_from(text.split_whitespace()).map_err(|problem| problem.to_string())?;
    Ok(LogOptions { text: text.to_owned(), ..options })
}

/// One recording to learn from.
enum Case<'a> {
    Draw(u64),
    World(u64),
    Twin(&'a Log, u64),
}

impl Calibrate {
    /// Labels, learns, tests and writes.
    pub fn run(&self) -> anyhow::Result<()> {
        let sessions: Vec<Session> =
            self.log.iter().map(|options| options.files.session()).collect::<anyhow::Result<_>>()?;
        let (draws, worlds, twins, seed) = (self.draws, self.worlds, self.twins, self.seed);
        let (map, qualities, labelled) = progress::watch("bench calibrate", move |monitor| {
            let logs: Vec<Log> = sessions
                .into_iter()
                .filter_map(|session| session.recording.map(|recording| (recording, session.split)))
                .map(|(recording, split)| Log::new((*recording).clone(), split, &Monitor::new()))
                .collect::<Result<_, _>>()?;
            let seeds = |count: u64| seed..seed + count;
            let twins_of = |log| seeds(twins).map(move |seed| Case::Twin(log, seed));
            let drawn = seeds(draws).map(Case::Draw).chain(seeds(worlds).map(Case::World));
            let cases: Vec<Case> = drawn.chain(logs.iter().flat_map(twins_of)).collect();
            let labelled = label_all(&cases, monitor, |case| match case {
                Case::Draw(seed) => Labelled::of_draw(*seed, monitor),
                Case::World(seed) => Labelled::of_world(*seed, monitor),
                Case::Twin(log, seed) => Labelled::of_twin(log, *seed, monitor),
            })?;
            Ok::<_, TrialError>((learn(&labelled.iter().collect::<Vec<_>>()), cross_validate(&labelled), labelled))
        })?;
        let map = Calibration { command: self.command(), ..map };
        if let Some(path) = &self.output {
            write_file(path, &serde_json::to_vec_pretty(&map)?)?;
        }
        if let Some(path) = &self.examples {
            let lines: Vec<String> = labelled.iter().map(serde_json::to_string).collect::<Result<_, _>>()?;
            write_file(path, lines.join("\n").as_bytes())?;
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&qualities)?);
        } else {
            print(&map, &qualities);
        }
        Ok(())
    }

    /// The command that makes the same map again.
    fn command(&self) -> String {
        let Calibrate { draws, worlds, twins, seed, .. } = self;
        let logs: String = self.log.iter().map(|log| format!(" --log '{}'", log.text)).collect();
        format!(
            "torquescope bench calibrate --draws {draws} --worlds {worlds} --twins {twins} --seed {seed}{logs} -o \
             assets/presence.json"
        )
    }
}

fn print(map: &Calibration, qualities: &[Quality]) {
    let of = |[part, all]: [usize; 2]| format!("{part} of {all}");
    let rows: Vec<Vec<String>> = qualities
        .iter()
        .map(|quality| {
            let [strong, sure, likely] = quality.strong;
            vec![
                quality.source.map_or("all".to_owned(), |source| format!("{source:?}").to_lowercase()),
                of([quality.present, quality.sightings]),
                number(quality.auc),
                quality.calibration_error.map_or(String::new(), number),
                of([quality.sure[1], quality.sure[0]]),
                format!("{sure} / {likely} of {strong}"),
                of([quality.complete[1], quality.complete[0]]),
                of([quality.incomplete[1], quality.incomplete[0]]),
            ]
        })
        .collect();
    println!(
        "{}",
        table(
            &[
                "recordings",
                "there",
                "AUC",
                "calibration error",
                "right at 90 %",
                "strong at 90 / 50 %",
                "flagged complete",
                "flagged incomplete"
            ],
            &rows
        )
    );
    if let Some(all) = qualities.last() {
        let rows: Vec<Vec<String>> = all
            .reliability
            .iter()
            .map(|class| vec![number(class.confidence), number(class.right), class.names.to_string()])
            .collect();
        println!("{}", table(&["presence", "there", "sightings"], &rows));
    }
    println!("not complete from {} of a joint's torque on", number(map.remainder));
    for (name, weight) in &map.clues {
        println!("  {name}: {}", number(*weight));
    }
}
