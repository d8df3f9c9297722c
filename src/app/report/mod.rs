//! The report of a session: what was measured, what was found, the model, what is missing, what is not known, and how to do it again.
//! One [`Document`], written as a page that needs nothing else ([`html`]), as pages of paper ([`pdf`]), or its tables for a paper
//! ([`latex`], [`markdown`]). Two sessions stand [side by side](mod@comparison).

mod comparison;
mod document;
mod html;
mod latex;
mod markdown;
mod pdf;

use std::sync::Arc;

pub use comparison::Side;
use document::{Block, Document, Table};

use super::desk::ReportFormat;
use super::screens::{compare, diagnose, extrapolation, ladder, residuals};
use super::{About, plots};
use crate::diagnosis::{Alternative, Presence, Report};
use crate::figure::{self, Figure, FigureError, Panel, Size, Style, Theme};
use crate::model::JointError;
use crate::progress::{Monitor, Stopped};
use crate::recording::{Origin, Recording, joints_text};
use crate::session::{Session, Step, View, again};
use crate::simulation::extrapolation::{Basis, Curve, Sweep};

/// Refused candidates that are told.
const MOST_REFUSED: usize = 25;
/// The screens whose plots are shown, in the order of the report.
const SHOWN: [&About; 4] = [&compare::ABOUT, &residuals::ABOUT, &ladder::ABOUT, &extrapolation::ABOUT];
/// What is drawn: these, and before the last two the evidence.
const DRAWINGS: usize = SHOWN.len() + 1;
/// Plots of one screen that are shown.
const MOST_PLOTS: usize = 9;
/// The part of the work that is drawing.
const DRAWN: f32 = 0.9;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A PDF can't be written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// Somebody asked for a stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The report of a session with a recording.
///
/// # Errors
/// [`ReportError`] if a PDF can't be written, or somebody stopped it.
pub fn report(session: &Session, format: ReportFormat, monitor: &Monitor) -> Result<Vec<u8>, ReportError> {
    let drawn = monitor.part(0.0..DRAWN);
    let pictures = Pictures { mark: "", size: Size::TwoColumn, monitor: &drawn, share: [0.0, 1.0] };
    let document = document(session, format.has_figures().then_some(pictures))?;
    monitor.report(DRAWN, "writing")?;
    Ok(written(&document, format)?)
}

/// Two sessions side by side, each with its name.
///
/// # Errors
/// As [`report`].
pub fn comparison(sides: [Side; 2], format: ReportFormat, monitor: &Monitor) -> Result<Vec<u8>, ReportError> {
    let document = comparison::document(sides, format.has_figures(), &monitor.part(0.0..DRAWN))?;
    monitor.report(DRAWN, "writing")?;
    Ok(written(&document, format)?)
}

fn written(document: &Document, format: ReportFormat) -> Result<Vec<u8>, FigureError> {
    let text = match format {
        ReportFormat::Html => html::page(document),
        ReportFormat::Pdf => return pdf::pages(document),
        ReportFormat::Latex => latex::tables(document),
        ReportFormat::Markdown => markdown::text(document),
    };
    Ok(text.into_bytes())
}

/// How the figures of a report are drawn.
#[derive(Clone, Copy)]
struct Pictures<'a> {
    /// Begins the marks of their parts, which nothing else on the page may have.
    mark: &'a str,
    size: Size,
    /// Of the drawing of everything.
    monitor: &'a Monitor,
    /// The part of it that these are.
    share: [f32; 2],
}

impl Pictures<'_> {
    /// One of so many parts.
    fn part(self, number: usize, of: usize) -> Self {
        let [begin, end] = self.share;
        let at = |number: usize| begin + (end - begin) * number as f32 / of.max(1) as f32;
        Pictures { share: [at(number), at(number + 1)], ..self }
    }

    fn report(&self, doing: &str) -> Result<(), Stopped> {
        self.monitor.report(self.share[0], doing)
    }
}

fn document(session: &Session, pictures: Option<Pictures>) -> Result<Document, Stopped> {
    let name = session.recording.as_ref().map_or("no recording", |recording| &recording.name);
    let mut document = Document { title: format!("What a model of {name} is missing"), blocks: Vec::new() };
    let Some(recording) = session.recording.as_deref() else { return Ok(document) };
    let blocks = &mut document.blocks;
    if let Some(report) = &session.report {
        blocks.push(Block::Text(report.headline().to_owned()));
        blocks.push(Block::List(
            report
                .effects
                .iter()
                .map(|effect| {
                    format!("{}, {} ({})", effect.effect.name, joints_text(&effect.joints), effect.sureness())
                })
                .collect(),
        ));
    }
    data(session, recording, blocks);
    findings(session, blocks);
    models(session, recording, blocks);
    let part = |number: usize| pictures.map(|pictures| pictures.part(number, DRAWINGS));
    figures(session, SHOWN[0], part(0), blocks)?;
    figures(session, SHOWN[1], part(1), blocks)?;
    if let Some(report) = &session.report {
        missing(report, recording, part(2), blocks)?;
        figures(session, SHOWN[2], part(3), blocks)?;
    }
    if let Some(sweep) = &session.sweep {
        outside(sweep, blocks);
        figures(session, SHOWN[3], part(4), blocks)?;
    }
    if let Some(report) = &session.report {
        ruled_out(report, blocks);
        not_known(report, blocks);
    }
    reproduce(session, blocks);
    Ok(document)
}

fn data(session: &Session, recording: &Recording, blocks: &mut Vec<Block>) {
    blocks.push(Block::Heading("The data".to_owned()));
    let origin = |origin: &Origin| match origin {
        Origin::Measured => "measured".to_owned(),
        Origin::Derived(how) => format!("derived: {how}"),
    };
    let duration: f64 =
        recording.trajectories.iter().filter_map(|run| Some(run.time.last()? - run.time.first()?)).sum();
    let samples =
        |segments: &[crate::recording::split::Segment]| segments.iter().map(|one| one.samples.len()).sum::<usize>();
    let mut rows = vec![
        row(["joints", &recording.joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>().join(", ")]),
        row(["trajectories", &recording.trajectories.len().to_string()]),
        row(["samples", &recording.sample_count().to_string()]),
        row(["duration [s]", &number(duration)]),
        row(["velocity", &origin(&recording.provenance.velocity)]),
        row(["acceleration", &origin(&recording.provenance.acceleration)]),
        row([recording.effort(), &recording.torque.text()]),
        row(["samples to train on", &samples(&session.split.train).to_string()]),
        row(["samples held out", &samples(&session.split.held_out).to_string()]),
    ];
    if let Some(mapping) = &session.mapping {
        let columns = |names: &Vec<String>| names.join(", ");
        rows.push(row(["columns of position", &columns(&mapping.q)]));
        rows.push(row(["columns of torque", &columns(&mapping.tau)]));
    }
    blocks.push(Block::Table(Table { title: "the recording".to_owned(), head: row(["what", "value"]), rows }));
}

fn findings(session: &Session, blocks: &mut Vec<Block>) {
    if session.findings.is_empty() {
        blocks.push(Block::Text("Nothing is odd about the recording.".to_owned()));
        return;
    }
    let rows = session.findings.iter().map(|finding| row([finding.severity.word(), &finding.what, &finding.remedy]));
    let (title, head) = ("what is odd about it".to_owned(), row(["", "what was found", "what to do"]));
    blocks.push(Block::Table(Table { title, head, rows: rows.collect() }));
}

fn models(session: &Session, recording: &Recording, blocks: &mut Vec<Block>) {
    blocks.push(Block::Heading("The model, step by step".to_owned()));
    let joints: Vec<String> = (1..=recording.joint_count()).map(|joint| format!("joint {joint}")).collect();
    let head = [row(["model"]), joints, row(["all", "MSE of all", "R² of all"])].concat();
    let line = |step: &Arc<Step>| {
        let all = step.evaluation.all_held_out;
        let own = step.evaluation.held_out.iter().map(|joint| number(joint.nmse));
        let mut line = vec![step.name.clone()];
        line.extend(own);
        line.extend([number(all.nmse), number(all.mse), format!("{:.5}", all.r2)]);
        line
    };
    let rows = session.ladder.iter().map(line).collect();
    blocks.push(Block::Table(Table { title: "held-out nMSE of every step".to_owned(), head, rows }));
    let Some(step) = session.current() else { return };
    if let Some(floor) = &step.evaluation.noise_floor_nmse {
        let floor = floor.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", ");
        blocks.push(Block::Text(format!("Noise alone would leave, by joint: {floor}.")));
    }
    let joint = |joint: Option<usize>| joint.map_or("–".to_owned(), |joint| (joint + 1).to_string());
    let line = |parameter: &crate::model::Parameter| {
        let interval = parameter
            .interval
            .map_or("not shown by these data".to_owned(), |[low, high]| format!("{} … {}", number(low), number(high)));
        vec![
            step.fitted.model.terms[parameter.term].label(),
            parameter.name.clone(),
            joint(parameter.joint),
            number(parameter.value),
            interval,
            parameter.stated.map_or(String::new(), number),
            parameter.unit.clone(),
        ]
    };
    let mut head = row(["term", "parameter", "joint", "value", "95 % interval", "as stated", "unit"]);
    let mut rows: Vec<Vec<String>> = step.fitted.parameters.iter().map(line).collect();
    if step.fitted.parameters.iter().all(|parameter| parameter.stated.is_none()) {
        let stated = head.len() - 2;
        rows.iter_mut().chain([&mut head]).for_each(|cells| drop(cells.remove(stated)));
    }
    if !rows.is_empty() {
        blocks.push(Block::Table(Table { title: format!("parameters of {}", step.name), head, rows }));
    }
    blocks.extend(step.fitted.beside_stated().map(Block::Text));
    let line = |(joint, (train, held_out)): (usize, (&JointError, &JointError))| {
        let cells = [train.nmse, held_out.nmse, held_out.mse].map(number);
        [vec![(joint + 1).to_string()], cells.to_vec(), vec![format!("{:.5}", held_out.r2)]].concat()
    };
    let errors = step.evaluation.train.iter().zip(&step.evaluation.held_out).enumerate();
    let head = row(["joint", "nMSE, training", "nMSE, held out", "MSE, held out", "R², held out"]);
    blocks.push(Block::Table(Table {
        title: format!("errors of {}", step.name),
        head,
        rows: errors.map(line).collect(),
    }));
}

/// The plots of a screen.
fn figures(
    session: &Session,
    screen: &'static About,
    pictures: Option<Pictures>,
    blocks: &mut Vec<Block>,
) -> Result<(), Stopped> {
    let Some(pictures) = pictures else { return Ok(()) };
    pictures.report(&format!("asking {}", screen.title))?;
    let mut panels = plots(session.clone(), View::default(), screen);
    panels.truncate(MOST_PLOTS);
    drawn(panels, screen.id, screen.title, pictures, blocks)
}

/// Panels, each as a figure with a mark and a title that begin so.
fn drawn(
    mut panels: Vec<Panel>,
    mark: &str,
    about: &str,
    pictures: Pictures,
    blocks: &mut Vec<Block>,
) -> Result<(), Stopped> {
    let style = Style { size: pictures.size, theme: Theme::Print, ..Style::default() };
    name_axes(&mut panels);
    let count = panels.len();
    for (number, panel) in panels.into_iter().enumerate() {
        let title = panel.title.clone();
        pictures.part(number, count).report(&format!("drawing {title}"))?;
        // Every picture of the page has marks of its own.
        let mark = format!("{}{mark}{number}", pictures.mark);
        if let Ok(svg) = figure::inline(&Figure::new(vec![panel]), &style, &mark) {
            blocks.push(Block::Figure { title: format!("{about}: {title}"), svg });
        }
    }
    Ok(())
}

/// Of panels above each other only the last one names their common axis; here each stands alone.
fn name_axes(panels: &mut [Panel]) {
    for above in (1..panels.len()).rev() {
        let (before, behind) = panels.split_at_mut(above);
        let (upper, lower) = (&mut before[above - 1].x, &behind[0].x);
        if upper.label.is_empty() && upper.link == lower.link {
            (upper.label, upper.unit) = (lower.label.clone(), lower.unit.clone());
        }
    }
}

/// Every effect that is named, and behind its text the plots that show it.
fn missing(
    report: &Arc<Report>,
    recording: &Recording,
    pictures: Option<Pictures>,
    blocks: &mut Vec<Block>,
) -> Result<(), Stopped> {
    blocks.push(Block::Heading("What is missing, and the evidence".to_owned()));
    for (place, effect) in report.effects.iter().enumerate() {
        let numbers = |values: &[f64]| values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", ");
        let mut text = format!(
            "{}, {} ({}): {} Its formula is {}. Held-out nMSE {} → {}.",
            effect.effect.name,
            joints_text(&effect.joints),
            effect.sureness(),
            effect.effect.fingerprint,
            effect.effect.formula,
            numbers(&effect.nmse_before),
            numbers(&effect.nmse_after)
        );
        if !effect.alternatives.is_empty() {
            let others = Alternative::texts(&effect.alternatives).join(", ");
            text.push_str(&format!(" Explains nearly as much: {others}."));
        }
        text.push_str(&format!(" Source of the formula: {}.", effect.effect.source));
        blocks.push(Block::Text(text));
        if let Some(pictures) = pictures {
            let mut panels = diagnose::evidence(report, place, false, recording);
            panels.truncate(MOST_PLOTS);
            let pictures = pictures.part(place, report.effects.len());
            drawn(panels, &format!("evidence{place}-"), effect.effect.name, pictures, blocks)?;
        }
    }
    let rows: Vec<Vec<String>> = report
        .presence
        .iter()
        .map(|one| {
            let [presence, share] = [one.probability, one.share].map(|value| format!("{:.1} %", 100.0 * value));
            let mut row = vec![one.place(), presence, one.likelihood().to_owned(), one.effect.name.to_owned(), share];
            if report.asks_held_out() {
                row.push(one.missed());
            }
            row
        })
        .collect();
    if !rows.is_empty() {
        let mut head = row(["what kind, where", "presence", "", "likeliest form", "share of what was measured"]);
        if report.asks_held_out() {
            head.push(Presence::MISSED.to_owned());
        }
        blocks.push(Block::Table(Table { title: "how likely each kind of physics is there".to_owned(), head, rows }));
    }
    Ok(())
}

/// How the errors grow where nothing was recorded.
fn outside(sweep: &Sweep, blocks: &mut Vec<Block>) {
    blocks.push(Block::Heading("Outside the data".to_owned()));
    let what = sweep.stretch.name();
    let how = match sweep.basis {
        Basis::Simulated => "the held-out runs travelled anew by the simulated arm, whose exact torque is known",
        Basis::Measured => "held-out blocks of about a second as measured, relative to the mean of the training part",
    };
    blocks.push(Block::Text(format!("Errors over the {what}: {how}.")));
    let mut head = row(["model"]);
    let scales = sweep.curves.first().into_iter().flat_map(|curve| &curve.points);
    head.extend(scales.map(|point| format!("{:.2} × {what}", point.scale)));
    let line = |curve: &Curve| {
        let errors = curve.points.iter().map(|point| number(point.overall));
        [curve.model.clone()].into_iter().chain(errors).collect()
    };
    let title = format!("nMSE of all joints over the {what}");
    blocks.push(Block::Table(Table { title, head, rows: sweep.curves.iter().map(line).collect() }));
}

fn ruled_out(report: &Report, blocks: &mut Vec<Block>) {
    let refused: Vec<_> = report.ranking.iter().filter(|candidate| !candidate.accepted()).collect();
    if refused.is_empty() {
        return;
    }
    blocks.push(Block::Heading("What was ruled out".to_owned()));
    let rows = refused.iter().take(MOST_REFUSED).map(|candidate| {
        let joint = candidate.joint.map_or("all".to_owned(), |joint| (joint + 1).to_string());
        vec![candidate.effect.name.to_owned(), joint, candidate.divides(), candidate.reason()]
    });
    let head = row(["candidate", "joint", "alone, error", "why not"]);
    blocks.push(Block::Table(Table {
        title: "candidates that are no part of the answer".to_owned(),
        head,
        rows: rows.collect(),
    }));
    if refused.len() > MOST_REFUSED {
        blocks.push(Block::Text(format!("and {} more.", refused.len() - MOST_REFUSED)));
    }
}

fn not_known(report: &Report, blocks: &mut Vec<Block>) {
    blocks.push(Block::Heading("What is not known".to_owned()));
    let unknown = report.not_known.iter().map(|unknown| format!("{}.", unknown.text()));
    let complete = report.completeness.iter().map(|one| one.text());
    blocks.push(Block::List(complete.chain(unknown).collect()));
    let advice = report.notes.iter().map(|note| note.sentence()).collect::<Vec<_>>().join(" ");
    if !advice.is_empty() {
        blocks.push(Block::Text(advice));
    }
}

fn reproduce(session: &Session, blocks: &mut Vec<Block>) {
    blocks.push(Block::Heading("How to do it again".to_owned()));
    blocks.push(Block::Text(this_program()));
    let trained = session.ladder.iter().filter_map(|step| Some((step, step.run.as_deref()?)));
    let seeds: Vec<String> = trained
        .map(|(step, run)| format!("{}: seed {} of the training", step.name, run.asked().options.seed))
        .collect();
    match seeds.is_empty() {
        true => {
            blocks.push(Block::Text("Nothing in it is drawn: no model was trained, so there is no seed.".to_owned()))
        }
        false => blocks.push(Block::List(seeds)),
    }
    blocks.push(Block::Code(again(session).join("\n")));
}

fn this_program() -> String {
    format!("Written by Torquescope {}.", env!("CARGO_PKG_VERSION"))
}

fn row<const WIDTH: usize>(cells: [&str; WIDTH]) -> Vec<String> {
    cells.map(str::to_owned).to_vec()
}

/// Four significant digits.
fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let place = value.abs().log10().floor();
    if (-3.0..6.0).contains(&place) {
        format!("{:.*}", (3.0 - place).max(0.0) as usize, value)
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::session::Command;
    use crate::simulation::Scenario;
    use crate::simulation::extrapolation::Stretch;

    #[test]
    fn the_report_stands_alone_and_says_what_was_found() {
        let monitor = Monitor::new();
        let session = Command::Simulate(Box::new(Scenario::embedded())).run(&Session::default(), &monitor).unwrap();
        let session = Command::Diagnose.run(&session, &monitor).unwrap();
        let steps = session.ladder.clone();
        let session = Command::Extrapolate { steps, stretch: Stretch::Speed }.run(&session, &monitor).unwrap();
        let text_of = |bytes: Result<Vec<u8>, ReportError>| String::from_utf8(bytes.unwrap()).unwrap();
        let page = text_of(report(&session, ReportFormat::Html, &monitor));
        for word in [
            "Coulomb friction, joint",
            "evidence0-0",
            "What was ruled out",
            "What is not known",
            "<svg",
            "torquescope diagnose three-joint-demo.npz",
        ] {
            assert!(page.contains(word), "{word}");
        }
        // It is read without a network, and each mark in it is there once.
        let without_names = page.replace("http://www.w3.org/", "");
        assert!(page.contains("data-series=\"measured") && page.contains("<script>"), "its charts tell values");
        assert!(!without_names.contains("http") && !page.contains("<script src") && !page.contains("<link"));
        let marks: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        let unique: std::collections::HashSet<&&str> = marks.iter().collect();
        assert_eq!(unique.len(), marks.len());
        let tex = text_of(report(&session, ReportFormat::Latex, &monitor));
        assert!(tex.contains("\\toprule") && tex.contains("Coulomb friction") && tex.contains("95 \\%"), "{tex}");
        assert_eq!(tex.matches("\\begin{table}").count(), tex.matches("\\end{table}").count());
        let text = text_of(report(&session, ReportFormat::Markdown, &monitor));
        assert!(text.starts_with("# What a model of") && text.contains("| model |"), "{text}");
        assert!(text.contains("Outside the data") && text.contains("| 1.00 × speed |"), "{text}");
        assert_eq!([0.0, 1.5, 1.23456e-7, 123_456.0].map(number), ["0", "1.500", "1.235e-7", "123456"]);

        let pdf = report(&session, ReportFormat::Pdf, &monitor).unwrap();
        assert!(pdf.starts_with(b"%PDF") && pdf.len() > 50_000, "its figures are in it");
        assert!(!figure::embedded::fonts(&pdf).is_empty(), "its fonts are in it, too");
        figure::embedded::pdffonts_agrees(&pdf);

        let effect = &session.report.as_ref().unwrap().effects[0];
        let add = Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() };
        let repaired = Session { report: session.report.clone(), ..add.run(&session, &monitor).unwrap() };
        let sides = [("before", &session), ("after", &repaired)];
        let text = text_of(comparison(sides, ReportFormat::Markdown, &monitor));
        assert!(text.contains("| what | before | after |") && text.contains("### before"), "{text}");
        let coulomb = text.lines().find(|line| line.contains("coulomb_torque")).unwrap();
        assert!(coulomb.contains("| – |"), "only one of them has it: {coulomb}");
        let page = text_of(comparison(sides, ReportFormat::Html, &monitor));
        let marks: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(marks.len() > 10 && marks.iter().collect::<std::collections::HashSet<_>>().len() == marks.len());
        let tex = text_of(comparison(sides, ReportFormat::Latex, &monitor));
        assert!(tex.contains("% before") && tex.matches("\\toprule").count() > 6, "{tex}");
    }
}
