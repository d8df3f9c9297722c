use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use serde::Serialize;

use super::failure::OrUsage;
use super::table::{number, table};
use super::{progress, write_file};
use crate::recording::mapping::Draft;
use crate::recording::read::{ReadOptions, preview};

/// How many values are shown of a column.
const SHOWN: usize = 3;

/// Show the columns of a log, what each is taken for and why; save that as a mapping file.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope columns log.csv
  torquescope columns log.csv --save-map log.toml     # then: torquescope diagnose log.csv --map log.toml
  torquescope columns gallery/nameless-logger --json")]
pub struct Columns {
    /// The log.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Save it as a mapping file, to be changed by hand where the guess is wrong.
    #[arg(long, value_name = "FILE.toml")]
    save_map: Option<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
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
        let file = self.file.clone();
        let seen = progress::watch("look", move |monitor| preview(&file, &ReadOptions::default(), monitor))?;
        let draft = Draft::guess(&seen.names());
        let answers = draft.columns.iter().zip(&seen.columns).map(|(role, column)| Answer {
            column: role.name.clone(),
            values: column.values.iter().take(SHOWN).copied().collect(),
            quantity: role.channel.map(|channel| channel.title()),
            joint: role.of_joint().map(|joint| joint + 1),
            unit: role.unit,
            why: role.why.clone(),
        });
        if self.json {
            println!("{}", serde_json::to_string_pretty(&answers.collect::<Vec<_>>())?);
        } else {
            let row = |one: Answer| {
                let values: Vec<String> = one.values.into_iter().map(number).collect();
                let joint = one.joint.map_or(String::new(), |joint| joint.to_string());
                vec![
                    one.column,
                    one.quantity.unwrap_or("–").to_owned(),
                    joint,
                    one.unit.to_owned(),
                    values.join("  "),
                    one.why,
                ]
            };
            let titles = ["column", " quantity", "joint", " unit", " first values", " why"];
            println!("{}", table(&titles, &answers.map(row).collect::<Vec<_>>()));
        }
        let Some(path) = &self.save_map else { return Ok(()) };
        let spec = draft.spec().context("no mapping can be saved").or_usage()?;
        write_file(path, spec.to_toml()?.as_bytes())?;
        progress::remark(format_args!("saved {}: read the log with --map {}", path.display(), path.display()));
        Ok(())
    }
}
