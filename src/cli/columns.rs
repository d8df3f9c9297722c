use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use serde::Serialize;

use super::failure::OrUsage;
use super::table::{number, table};
use super::{progress, write_file};
use crate::recording::mapping::{Draft, MappingSpec};
use crate::recording::noise_filter::Sampled;
use crate::recording::read::{Preview, ReadOptions, SeenTopic, preview};

/// How many values are shown of a column.
const SHOWN: usize = 3;

/// Show the columns of a log, what each is taken for and why; save that as a mapping file.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope columns log.csv
  torquescope columns log.csv --save-map log.toml     # then: torquescope diagnose log.csv --map log.toml
  torquescope columns log.mcap --topic /positions+/torques
  torquescope columns gallery/nameless-logger --json")]
pub struct Columns {
    /// The log.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Of a log of messages, the topic that the columns are of, or two that stand side by side at the times of the first.
    #[arg(long, value_name = "NAME[+NAME]", value_delimiter = '+')]
    topic: Vec<String>,
    /// Save it as a mapping file, to be changed by hand where the guess is wrong.
    #[arg(long, value_name = "FILE.toml")]
    save_map: Option<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    columns: Vec<Column>,
    /// The topics of a log of messages, and those that the columns are of, the one that gives the times first.
    topics: Vec<Topic>,
    taken_topics: Vec<String>,
    /// What is to be said of their clocks.
    clocks: Vec<String>,
    /// The cut-off of derived channels that the noise asks for; `None` where all is measured, or nothing can be said.
    low_pass: Option<LowPass>,
}

#[derive(Serialize)]
struct Topic {
    name: String,
    kind: String,
    messages: usize,
}

#[derive(Serialize)]
struct LowPass {
    /// `None` where no noise is seen.
    hz: Option<f64>,
    reason: String,
}

#[derive(Serialize)]
struct Column {
    column: String,
    /// The first of them.
    values: Vec<f64>,
    /// `None` where it is not used.
    quantity: Option<&'static str>,
    /// Counted from 1.
    joint: Option<usize>,
    unit: &'static str,
    why: String,
}

impl Columns {
    /// Looks into the log.
    pub fn run(&self) -> anyhow::Result<()> {
        let (file, options) = (self.file.clone(), self.options());
        let seen = progress::watch("look", move |monitor| preview(&file, &options, monitor))?;
        let draft = Draft::guess(&seen.names());
        let answer = Answer::of(&seen, &draft);
        if self.json {
            println!("{}", serde_json::to_string_pretty(&answer)?);
        } else {
            answer.print();
        }
        let Some(path) = &self.save_map else { return Ok(()) };
        let spec = draft.spec().context("no mapping can be saved").or_usage()?;
        let spec = MappingSpec { topic: seen.stated_topics(), ..spec };
        write_file(path, spec.to_toml()?.as_bytes())?;
        progress::remark(format_args!("saved {}: read the log with --map {}", path.display(), path.display()));
        Ok(())
    }

    fn options(&self) -> ReadOptions {
        let options = ReadOptions::default();
        if self.topic.is_empty() { options } else { options.on_topics(self.topic.clone()) }
    }
}

impl Answer {
    fn of(seen: &Preview, draft: &Draft) -> Answer {
        let columns = draft.columns.iter().zip(&seen.columns).map(|(role, column)| Column {
            column: role.name.clone(),
            values: column.values.iter().take(SHOWN).copied().collect(),
            quantity: role.channel.map(|channel| channel.title()),
            joint: role.of_joint().map(|joint| joint + 1),
            unit: role.unit,
            why: role.why.clone(),
        });
        let topic =
            |topic: &SeenTopic| Topic { name: topic.name.clone(), kind: topic.kind.clone(), messages: topic.messages };
        let advice = Sampled::derived_from(draft, seen).and_then(|sampled| sampled.advice());
        Answer {
            columns: columns.collect(),
            topics: seen.topics.iter().map(topic).collect(),
            taken_topics: seen.taken(),
            clocks: seen.clocks.clone(),
            low_pass: advice.map(|advice| LowPass { hz: advice.told_hz(), reason: advice.reason() }),
        }
    }

    fn print(self) {
        let row = |one: Column| {
            let values: Vec<String> = one.values.into_iter().map(number).collect();
            let joint = one.joint.map_or(String::new(), |joint| joint.to_string());
            let quantity = one.quantity.unwrap_or("–").to_owned();
            vec![one.column, quantity, joint, one.unit.to_owned(), values.join("  "), one.why]
        };
        let titles = ["column", " quantity", "joint", " unit", " first values", " why"];
        println!("{}", table(&titles, &self.columns.into_iter().map(row).collect::<Vec<_>>()));
        if self.topics.len() > 1 {
            let taken = &self.taken_topics;
            let row = |topic: Topic| {
                let place = taken.iter().position(|name| *name == topic.name);
                let is_taken =
                    place.map_or("", |place| if taken.len() > 1 && place == 0 { "yes, its times" } else { "yes" });
                vec![topic.name, format!(" {}", topic.kind), topic.messages.to_string(), format!(" {is_taken}")]
            };
            let titles = ["topic", " type", "messages", " taken (others: --topic)"];
            println!("{}", table(&titles, &self.topics.into_iter().map(row).collect::<Vec<_>>()));
        }
        self.clocks.iter().for_each(|told| println!("clocks: {told}"));
        if let Some(LowPass { hz, reason }) = self.low_pass {
            match hz {
                Some(hz) => println!("derived channels: the noise asks for --low-pass {hz}: {reason}"),
                None => println!("derived channels: {reason}"),
            }
        }
    }
}
