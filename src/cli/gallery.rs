mod form;
mod recipe;

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Subcommand};
use serde::Serialize;

use super::table::table;
use super::{output_folder, progress, write_file};
use crate::recording::gallery;

/// List the recordings that come with the program: small arms with a story, each with something to find.
///
/// Wherever a recording is read, `gallery/NAME` reads one of them.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope gallery
  torquescope gallery --json
  torquescope open gallery/sticky-shoulder      # in the window
  torquescope inspect gallery/healthy-arm
  torquescope diagnose gallery/leaning-table
  torquescope seal open gallery/leaning-table   # what was hidden")]
pub struct GalleryCommand {
    #[command(subcommand)]
    command: Option<Developer>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Subcommand)]
enum Developer {
    #[command(hide = true)]
    Make(Make),
}

/// Make the gallery anew, from its recipes: the logs and the seals.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope gallery make -o datasets/gallery
  torquescope gallery make toothed-motor -o new")]
struct Make {
    /// Only these samples.
    names: Vec<String>,
    /// The folder that they are written into.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

#[derive(Serialize)]
struct Answer {
    path: String,
    title: &'static str,
    story: &'static str,
    teaches: &'static str,
    format: &'static str,
}

impl GalleryCommand {
    /// Lists the samples, or makes them.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(Developer::Make(make)) = &self.command {
            return make.run();
        }
        let answers = gallery::all().iter().map(|sample| Answer {
            path: sample.path().display().to_string(),
            title: &sample.told.title,
            story: &sample.told.story,
            teaches: &sample.told.teaches,
            format: &sample.told.format,
        });
        if self.json {
            println!("{}", serde_json::to_string_pretty(&answers.collect::<Vec<_>>())?);
            return Ok(());
        }
        let row = |one: Answer| vec![one.path, one.title.to_owned(), one.format.to_owned()];
        println!("{}", table(&["recording", " title", " format"], &answers.map(row).collect::<Vec<_>>()));
        progress::remark(format_args!("\nopen one in the window: torquescope open gallery/{}", gallery::all()[0].name));
        Ok(())
    }
}

impl Make {
    fn run(&self) -> anyhow::Result<()> {
        output_folder(&self.output)?;
        for name in &self.names {
            recipe::ALL
                .iter()
                .find(|recipe| recipe.name == name)
                .with_context(|| format!("there is no recipe `{name}`"))?;
        }
        let wanted = recipe::ALL
            .iter()
            .filter(|recipe| self.names.is_empty() || self.names.iter().any(|name| name == recipe.name));
        for recipe in wanted {
            let made = progress::watch(recipe.name, move |monitor| recipe.make(monitor))?;
            for (name, bytes) in made {
                let path = self.output.join(&name);
                if let Some(folder) = path.parent() {
                    std::fs::create_dir_all(folder)?;
                }
                write_file(&path, &bytes)?;
                progress::remark(format_args!("{name}: {} kB", bytes.len() / 1000));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;

    #[test]
    fn every_sample_has_its_recipe() {
        let shown: Vec<&str> = gallery::all().iter().map(|sample| sample.name).collect();
        assert_eq!(recipe::ALL.iter().map(|recipe| recipe.name).collect::<Vec<_>>(), shown);
        let size: usize = gallery::all().iter().flat_map(|sample| sample.log).map(|(_, bytes)| bytes.len()).sum();
        assert!(size < 3_200_000, "{size} bytes are much for every binary");
    }

    /// What lies in the repository is what the recipe makes, up to how a machine rounds.
    #[test]
    fn a_sample_is_made_again_as_it_is() {
        let recipe = recipe::ALL.iter().find(|recipe| recipe.name == "toothed-motor").unwrap();
        let made = recipe.make(&Monitor::new()).unwrap();
        let [(name, bytes), (_, seal)] = made.as_slice() else { panic!("a log and a seal") };
        let sample = gallery::all().iter().find(|sample| sample.name == recipe.name).unwrap();
        assert_eq!((name.as_str(), seal.len()), (sample.log[0].0, sample.seal().as_bytes().len()));
        let read = |bytes: &[u8]| crate::recording::read::own_recording(bytes, &Monitor::new()).unwrap();
        let [made, kept] = [read(bytes), read(sample.log[0].1)].map(|recording| recording.trajectories[0].tau.clone());
        let largest = kept.values().iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        for (made, kept) in made.values().iter().zip(kept.values()) {
            assert!((made - kept).abs() < 1e-3 * largest, "{made} and {kept}");
        }
    }
}
