//! Whether names stay where a log is looked at in another way.

use clap::Args;

use super::planted::names_text;
use super::rates::percent;
use super::recordings::at;
use crate::cli::data::Files;
use crate::cli::progress;
use crate::cli::table::table;
use crate::recording::read::ReadOptions;
use crate::session::{Command, Session};
use crate::trial::stability::{CUTOFFS, Class, Said, Stability, Stays, Variant, stability, variants};

/// Which names of the diagnosis stay when your recording is looked at in another way: halves of it, every second and fourth
/// sample, other choices of what is held out, and other cut-offs of the filter where velocity or acceleration is derived.
///
/// A name survives that at least 80 % of these variants give. In some form: another name that says the same of this motion
/// counts too, such as a hysteresis for Coulomb friction. What is sure is the kind; how sure the form of it is stands beside it.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench stability my-log.csv --zero down
  torquescope bench stability DATA_EMPS.mat --map emps --json")]
pub struct StabilityBench {
    #[command(flatten)]
    files: Files,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

impl StabilityBench {
    /// Reads, varies, diagnoses, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let session = self.files.session()?;
        let Some(recording) = session.recording.clone() else { return Ok(()) };
        let mut others = variants(&recording, &session.split);
        others.extend(filtered(&session)?);
        let split = session.split;
        let result =
            progress::watch("bench stability", move |monitor| stability(&recording, &split, &others, monitor))?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&result)?);
        } else {
            print(&result);
        }
        Ok(())
    }
}

/// The log read again with other cut-offs, if anything in it was derived.
fn filtered(session: &Session) -> anyhow::Result<Vec<Variant>> {
    let cutoff = session.recording.as_ref().and_then(|recording| recording.provenance.low_pass_hz);
    let (Some(cutoff), Some(source)) = (cutoff, session.source.as_deref()) else { return Ok(Vec::new()) };
    let read = |factor: f64| {
        let low_pass = factor * cutoff;
        let options = ReadOptions { low_pass_hz: Some(low_pass), ..source.options.clone() };
        let Some(open) = Command::read_again(source, options) else { return Ok(None) };
        let again = progress::run(open, &Session::default())?;
        let name = format!("derived with a cut-off of {low_pass:.1} Hz");
        let variant = |recording| Variant { name, recording, split: again.split };
        anyhow::Ok(again.recording.map(|recording| variant((*recording).clone())))
    };
    Ok(CUTOFFS.into_iter().map(read).collect::<anyhow::Result<Vec<_>>>()?.into_iter().flatten().collect())
}

fn print(result: &Stability) {
    let of_name = |name: &Stays| {
        vec![
            format!("{}@{}", name.effect, at(name.joint)),
            format!("{:.0} %", 100.0 * name.confidence),
            format!("{:.0} %", 100.0 * name.form),
            percent(Some(name.same)),
            percent(Some(name.in_some_form)),
        ]
    };
    let rows: Vec<Vec<String>> = result.names.iter().map(of_name).collect();
    println!("{}\n", table(&["name", "is there", "in this form", "variants that give it", "in some form"], &rows));
    print_classes("is there", &result.classes);
    print_classes("is there in this form", &result.forms);
    let of_variant = |said: &Said| {
        let names = match &said.problem {
            Some(problem) => format!("could not be asked: {problem}"),
            None => names_text(&said.names),
        };
        vec![said.name.clone(), said.others.to_string(), names]
    };
    let rows: Vec<Vec<String>> = result.variants.iter().map(of_variant).collect();
    println!("{}", table(&["variant", "other names", " all its names"], &rows));
}

/// How many names survive, by how sure the diagnosis is of what.
fn print_classes(what: &str, classes: &[Class]) {
    let percents = classes.iter().map(|class| format!("{:.0} %", 100.0 * class.from)).collect::<Vec<_>>();
    let of_class = |(number, class): (usize, &Class)| {
        let title = match number {
            0 => format!("{} or more", percents[0]),
            number if class.from == 0.0 => format!("below {}", percents[number - 1]),
            number => format!("{} to {}", percents[number], percents[number - 1]),
        };
        vec![title, class.names.to_string(), percent(class.survive), percent(class.survive_in_some_form)]
    };
    let rows: Vec<Vec<String>> = classes.iter().enumerate().map(of_class).collect();
    println!("{}\n", table(&[what, "names", "survive 80 % of the variants", "in some form"], &rows));
}
