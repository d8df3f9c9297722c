use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::choice::{Choice, one_of};
use super::data::OptionalData;
use super::failure::OrUsage;
use super::{output_folder, progress, pupil, write_file};
use crate::app::headless::{Look, Over};
use crate::app::screens::{self, diagnose, extrapolation, ladder, model, train};
use crate::app::{self, About, ScreenshotOptions, Shown};
use crate::lesson::{begin, catalogue};
use crate::model::learned::LearnedPreset;
use crate::session::{Command, Document, Session, Step};
use crate::simulation::extrapolation::{Stretch, Sweep};
use crate::training::fit::Plan;

/// Draw a screen of the window as a picture, without display or GPU.
///
/// For the screen `train` a structured DeLaN is trained first; for `diagnose` the diagnosis is run, for `model`, `ladder` and
/// `extrapolation` what it names is added too.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope screenshot --screen compare --theme light --size 1600x1000 -o compare.png
  torquescope screenshot --all -o screenshots
  torquescope screenshot mine.torquescope --screen ladder -o ladder.png
  torquescope screenshot --screen data --panel Sources --contrast -o sources.png
  torquescope screenshot --screen compare --over export -o export.png
  torquescope screenshot --lesson 6 --screen compare -o lesson.png
  torquescope screenshot --lesson 6 --step add --screen diagnose -o repair.png
  torquescope screenshot --empty --screen data --theme light -o start.png
  torquescope screenshot --screen experiment --experiment table-2 experiments -o table.png")]
pub struct Screenshot {
    #[command(flatten)]
    data: OptionalData,
    /// Which screen.
    #[arg(long, value_parser = one_of(screen_choices()), required_unless_present = "all", conflicts_with = "all")]
    screen: Option<&'static About>,
    /// All screens; the output is then a folder.
    #[arg(long)]
    all: bool,
    /// Light or dark.
    #[arg(long, default_value = "dark", value_parser = one_of(LOOKS))]
    theme: Look,
    /// Width and height of the window.
    #[arg(long, default_value = "1600x1000", value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    size: [f32; 2],
    /// Pixels per point.
    #[arg(long, default_value_t = 1.0)]
    scale: f32,
    /// Size of text and everything else [%], 80 to 200.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u16).range(80..=200))]
    text_size: u16,
    /// More contrast.
    #[arg(long)]
    contrast: bool,
    /// The panel that stands in front of its tabs, such as "What it has learned" of the screen `model`.
    #[arg(long, value_name = "NAME", conflicts_with = "all")]
    panel: Option<String>,
    /// What lies over the screen.
    #[arg(long, value_parser = one_of(OVER))]
    over: Option<Over>,
    /// For the screen `experiment`: which one, and the folder of its results.
    #[arg(long, value_names = ["EXPERIMENT", "FOLDER"], num_args = 2)]
    experiment: Option<Vec<String>>,
    /// Instead of recordings: the beginning of this lesson, by its number or name.
    #[arg(long, conflicts_with = "files")]
    lesson: Option<String>,
    /// The lesson not at its beginning, but where this step begins (`done` for its end), with all before it done right.
    #[arg(long, requires = "lesson", value_name = "STEP")]
    step: Option<String>,
    /// Instead of recordings: nothing yet, as a first start shows it.
    #[arg(long, conflicts_with_all = ["files", "lesson"])]
    empty: bool,
    /// The picture (PNG), or the folder for all.
    #[arg(short, long, value_name = "PICTURE.png|FOLDER")]
    output: PathBuf,
}

impl Screenshot {
    /// Reads or simulates, does what the screen is about, draws.
    pub fn run(&self) -> anyhow::Result<()> {
        self.data.check_output(&self.output)?;
        let start = match &self.lesson {
            Some(name) => {
                let lesson = begin(&catalogue::find(name).or_usage()?, 1, 0)?;
                let begun = progress::run(lesson.command, &Session::default())?;
                match &self.step {
                    Some(step) => pupil::reach(begun, step)?.into(),
                    None => begun.into(),
                }
            }
            None if self.empty => Session::default().into(),
            None => self.data.document_or_embedded()?,
        };
        let Some(screen) = self.screen else {
            output_folder(&self.output)?;
            for screen in screens::all() {
                let name = format!("{}.png", screen.id);
                write_file(&self.output.join(name), &self.draw(screen, &start)?)?;
            }
            return Ok(());
        };
        write_file(&self.output, &self.draw(screen, &start)?)
    }

    fn draw(&self, screen: &About, start: &Document) -> anyhow::Result<Vec<u8>> {
        let session = prepared(screen, start.history.current(), &[])?;
        let options = ScreenshotOptions {
            screen: screen.id.to_owned(),
            theme: self.theme,
            size: self.size,
            scale: self.scale,
            text_scale: f32::from(self.text_size) / 100.0,
            contrast: self.contrast,
            panel: self.panel.clone(),
            over: self.over,
            experiment: self.experiment.as_deref().map(|words| Shown {
                experiment: words[0].clone(),
                results: words[1].clone(),
                quick: false,
                ..Shown::default()
            }),
        };
        app::screenshot(session, start.view.clone(), &options)
    }
}

/// All screens of the window, for options.
pub fn screen_choices() -> impl Iterator<Item = Choice<&'static About>> {
    screens::all().map(|about| (about.id, about.purpose, about))
}

const OVER: [Choice<Over>; 8] = [
    ("export", "how plots are exported, with a preview", Over::Export),
    ("report", "how a report is written", Over::Report),
    ("export-model", "how a model is exported", Over::ModelOut),
    ("export-data", "how data are exported", Over::DataOut),
    ("models", "the table of the session's models", Over::Models),
    ("lessons", "the list of all lessons", Over::Lessons),
    ("commands", "the command palette", Over::Commands),
    ("columns", "what the columns of the log are", Over::Columns),
];

const LOOKS: [Choice<Look>; 2] =
    [("light", "dark text on light ground", Look::Light), ("dark", "light text on dark ground", Look::Dark)];

/// The session in the state that the screen is about: what a saved session has already is not done again, and where models were
/// chosen none are made.
pub fn prepared(screen: &About, start: &Session, chosen: &[Arc<Step>]) -> anyhow::Result<Session> {
    let mut session = start.clone();
    let is_trained = session.current().is_some_and(|step| step.fitted.model.is_learned());
    if *screen == train::ABOUT && session.recording.is_some() && !is_trained {
        let preset = LearnedPreset::StructuredDelan;
        session = progress::run(Command::TrainPreset { preset, plan: Box::new(Plan::default()) }, &session)?;
    }
    let is_of_repair = [&model::ABOUT, &ladder::ABOUT, &extrapolation::ABOUT].contains(&screen);
    let repaired = is_of_repair && session.ladder.len() < 2 && chosen.is_empty();
    if (repaired || *screen == diagnose::ABOUT) && session.current().is_some() && session.report.is_none() {
        session = progress::run(Command::Diagnose, &session)?;
    }
    if repaired {
        for effect in session.report.clone().iter().flat_map(|report| &report.effects) {
            let command = Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() };
            session = progress::run(command, &session)?;
        }
    }
    let has_all = |sweep: &Sweep| chosen.iter().all(|step| sweep.curves.iter().any(|curve| curve.model == step.name));
    let is_swept = session.sweep.as_deref().is_some_and(has_all);
    if *screen == extrapolation::ABOUT && session.current().is_some() && !is_swept {
        let is_chosen = |step: &Step| chosen.iter().any(|chosen| chosen.generation == step.generation);
        let stretch = session.sweep.as_deref().map_or(Stretch::Speed, |sweep| sweep.stretch);
        let command = Command::Extrapolate { steps: extrapolation::computed(&session, is_chosen), stretch };
        session = progress::run(command, &session)?;
    }
    Ok(session)
}

fn parse_size(text: &str) -> Result<[f32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides.ok_or_else(|| format!("`{text}` is not a size: write it like 1600x1000"))
}
