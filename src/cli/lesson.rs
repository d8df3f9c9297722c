use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use serde::Serialize;

use super::failure::OrUsage;
use super::progress;
use super::table::table;
use crate::app;
use crate::app::screens;
use crate::file;
use crate::lesson::file::text_beside;
use crate::lesson::grade::{Grade, verified};
use crate::lesson::{Lesson, begin, catalogue};
use crate::session::study::Source;
use crate::session::{Command, Session};

/// List the lessons, take one in the window, check one of your own, or grade sessions.
#[derive(Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:
  torquescope lesson
  torquescope lesson 6 --seed 17
  torquescope lesson mine.toml --seed 3
  torquescope lesson grade handed-in/*.torquescope --csv"
)]
pub struct LessonCommand {
    #[command(subcommand)]
    command: Option<Sub>,
    /// Number or name of a lesson, or a file of your own; without one, all are listed.
    #[arg(value_name = "LESSON|FILE.toml")]
    lesson: Option<String>,
    /// The student's seed: each has another arm, and the same seed has the same.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The language of the texts: the folder beside the lesson in which they are.
    #[arg(long, default_value = "en")]
    language: String,
    /// Print the list as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Subcommand)]
enum Sub {
    Check(Check),
    Grade(GradeCommand),
    Seeds(Seeds),
}

/// Check a lesson of your own: what is wrong is told with its line and column.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope lesson check mine.toml
  torquescope lesson check assets/lessons/*.toml")]
struct Check {
    /// Files with the steps; the texts are in the folder `en` beside each.
    #[arg(required = true, value_name = "FILE.toml")]
    files: Vec<PathBuf>,
    /// The language of the texts.
    #[arg(long, default_value = "en")]
    language: String,
}

/// Grade sessions in which a lesson was taken.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope lesson grade mine.torquescope
  torquescope lesson grade handed-in/*.torquescope --csv > grades.csv")]
struct GradeCommand {
    /// Sessions that the window saved.
    #[arg(required = true, value_name = "SESSION.torquescope")]
    sessions: Vec<PathBuf>,
    /// Print all of it as JSON.
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print a line for each session as CSV.
    #[arg(long)]
    csv: bool,
}

/// Draw the seeds of a class: the same word gives the same seeds.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope lesson seeds 6 --class robotics-2026 --count 30")]
struct Seeds {
    /// Number or name of a lesson, or a file of your own.
    lesson: String,
    /// A word for the class, so that another class has other arms.
    #[arg(long)]
    class: String,
    /// How many students there are.
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=1000))]
    count: u16,
}

/// A lesson in the list.
#[derive(Serialize)]
struct Listed {
    number: u32,
    id: String,
    title: String,
    summary: String,
    minutes: u32,
    steps: usize,
    points: f64,
}

/// A session and its grade, or why it has none.
#[derive(Serialize)]
struct Graded {
    file: String,
    #[serde(flatten)]
    grade: Option<Grade>,
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

impl LessonCommand {
    /// Whether it opens the window.
    pub fn opens_window(&self) -> bool {
        self.command.is_none() && self.lesson.is_some()
    }

    /// Does what is asked for.
    pub fn run(&self) -> anyhow::Result<()> {
        match (&self.command, &self.lesson) {
            (Some(Sub::Check(command)), _) => command.run(),
            (Some(Sub::Grade(command)), _) => command.run(),
            (Some(Sub::Seeds(command)), _) => command.run(),
            (None, Some(name)) => {
                let begun = begin(&open(name, &self.language)?, self.seed, app::now()).or_usage()?;
                app::run_window(Session::default(), Some(begun.command))
            }
            (None, None) => self.list(),
        }
    }

    fn list(&self) -> anyhow::Result<()> {
        let listed: Vec<Listed> = catalogue::all()
            .map(|lesson| Listed {
                number: lesson.number,
                steps: lesson.steps.len(),
                points: lesson.most_points(),
                id: lesson.id,
                title: lesson.title,
                summary: lesson.summary,
                minutes: lesson.minutes,
            })
            .collect();
        if self.json {
            println!("{}", serde_json::to_string_pretty(&listed)?);
            return Ok(());
        }
        let row = |lesson: &Listed| {
            let (number, minutes) = (lesson.number.to_string(), format!("{} min", lesson.minutes));
            vec![number, lesson.title.clone(), minutes, lesson.summary.clone()]
        };
        println!("{}", table(&["lesson", " title", "takes", " about"], &listed.iter().map(row).collect::<Vec<_>>()));
        println!("\nTake one: torquescope lesson {}", listed.first().map_or(1, |lesson| lesson.number));
        Ok(())
    }
}

/// The lesson of this number or name, or the one in this file.
fn open(name: &str, language: &str) -> anyhow::Result<Lesson> {
    let path = Path::new(name);
    if path.extension().is_none_or(|ending| ending != "toml") {
        return catalogue::find(name).or_usage();
    }
    let text = text_beside(path, language);
    let read = |path: &Path| file::read_text(path).with_context(|| format!("can't read {}", path.display())).or_usage();
    let source = Source { data: read(path)?, text: read(&text)? };
    let both = || format!("{} and {}", path.display(), text.display());
    let lesson = Lesson::read(&source).with_context(both).or_usage()?;
    let known: Vec<&str> = screens::all().map(|about| about.id).collect();
    lesson.check_screens(&known).and_then(|()| lesson.check_cases()).with_context(both).or_usage()?;
    Ok(lesson)
}

impl Check {
    fn run(&self) -> anyhow::Result<()> {
        for path in &self.files {
            let lesson = open(&path.to_string_lossy(), &self.language)?;
            let longest = lesson.steps.iter().map(|step| step.text.reading_time()).fold(0.0, f64::max);
            let (steps, points) = (lesson.steps.len(), lesson.most_points());
            println!(
                "{}: “{}”, {steps} steps, {points} points, at most {longest:.0} s of reading in a step",
                path.display(),
                lesson.title
            );
        }
        Ok(())
    }
}

impl GradeCommand {
    fn run(&self) -> anyhow::Result<()> {
        let all: Vec<Graded> = self.sessions.iter().map(|path| graded(path)).collect();
        if self.json {
            println!("{}", serde_json::to_string_pretty(&all)?);
        } else if self.csv {
            let mut writer = csv::Writer::from_writer(Vec::new());
            writer.write_record(COLUMNS)?;
            all.iter().try_for_each(|graded| writer.write_record(graded.row()))?;
            print!("{}", String::from_utf8(writer.into_inner()?)?);
        } else {
            println!("{}", table(&COLUMNS, &all.iter().map(Graded::row).collect::<Vec<_>>()));
        }
        match all.iter().filter(|graded| graded.grade.is_none()).count() {
            0 => Ok(()),
            count => anyhow::bail!("{count} of {} sessions could not be graded", all.len()),
        }
    }
}

const COLUMNS: [&str; 11] =
    ["file", "lesson", "seed", "points", "of", "passed", "finished", "minutes", "tries", "gave up", " tampered"];

fn graded(path: &Path) -> Graded {
    let restored = progress::run(Command::Restore { path: path.to_owned() }, &Session::default());
    let grade = restored.and_then(|session| Ok(verified(&session)?));
    let problem = grade.as_ref().err().map(|error| file::without_number(&error.to_string()));
    Graded { file: path.display().to_string(), grade: grade.ok(), problem }
}

impl Graded {
    fn row(&self) -> Vec<String> {
        let Some(grade) = &self.grade else {
            let mut row = vec![self.file.clone()];
            row.resize(COLUMNS.len() - 1, String::new());
            row.extend(self.problem.clone());
            return row;
        };
        let word = |is_so: bool| if is_so { "yes" } else { "no" }.to_owned();
        let published = if grade.as_published { "no" } else { "no; a lesson that does not come with this program" };
        vec![
            self.file.clone(),
            grade.lesson.clone(),
            grade.seed.to_string(),
            format!("{:.2}", grade.points),
            format!("{:.0}", grade.most),
            word(grade.passed),
            word(grade.finished),
            format!("{:.1}", grade.seconds as f64 / 60.0),
            grade.tries.to_string(),
            grade.gave_up.to_string(),
            grade.tampered.clone().map_or(published.to_owned(), |what| format!("yes: {what}")),
        ]
    }
}

impl Seeds {
    fn run(&self) -> anyhow::Result<()> {
        let lesson = open(&self.lesson, "en")?;
        for number in 1..=self.count {
            let seed = lesson.seed_of(&self.class, number);
            println!("{number:>4}  torquescope lesson {} --seed {seed}", self.lesson);
        }
        Ok(())
    }
}
