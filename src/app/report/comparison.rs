//! Two sessions side by side: first what differs in one table each, then their reports, section beside section.

use super::document::{Block, Document, Table};
use super::{Pictures, number, row, this_program};
use crate::figure::Size;
use crate::model::Parameter;
use crate::progress::{Monitor, Stopped};
use crate::session::{Session, Step};

/// A session and what it is called.
pub type Side<'a> = (&'a str, &'a Session);

/// The page of both.
pub(super) fn document(sides: [Side; 2], has_figures: bool, monitor: &Monitor) -> Result<Document, Stopped> {
    let names = sides.map(|(name, _)| name.to_owned());
    let mut blocks = vec![
        Block::Heading("In short".to_owned()),
        Block::Table(beside("both sessions", "what", &names, in_short(sides))),
        Block::Table(beside("what is missing", "effect", &names, effects(sides))),
        Block::Table(beside("parameters of the newest models", "parameter", &names, parameters(sides))),
    ];
    let report_of = |(_, session): Side, mark: &str, monitor: &Monitor| {
        let pictures = has_figures.then_some(Pictures { mark, size: Size::OneColumn, monitor, share: [0.0, 1.0] });
        Ok(sections(super::document(session, pictures)?.blocks))
    };
    let first = report_of(sides[0], "left-", &monitor.part(0.0..0.5))?;
    let second = report_of(sides[1], "right-", &monitor.part(0.5..1.0))?;
    for (heading, own, other) in paired(first, second) {
        blocks.extend(heading.map(Block::Heading));
        let [one, two] = names.clone();
        blocks.push(Block::Beside([(one, own), (two, other)]));
    }
    blocks.push(Block::Text(this_program()));
    Ok(Document { title: format!("{} beside {}", names[0], names[1]), blocks })
}

/// A table with a column for each session.
fn beside(title: &str, what: &str, names: &[String; 2], rows: Vec<Vec<String>>) -> Table {
    let [one, two] = names;
    Table { title: title.to_owned(), head: row([what, one, two]), rows }
}

fn in_short(sides: [Side; 2]) -> Vec<Vec<String>> {
    let error = |step: Option<&std::sync::Arc<Step>>| {
        step.map_or("–".to_owned(), |step| format!("{} ({})", number(step.evaluation.all_held_out.nmse), step.name))
    };
    let of = |(_, session): Side| {
        let recording = session.recording.as_deref();
        let counted = |count: Option<usize>| count.map_or("–".to_owned(), |count| count.to_string());
        [
            recording.map_or("–".to_owned(), |recording| recording.name.clone()),
            counted(recording.map(crate::recording::Recording::joint_count)),
            counted(recording.map(crate::recording::Recording::sample_count)),
            session.findings.len().to_string(),
            error(session.ladder.first()),
            error(session.current()),
        ]
    };
    let [one, two] = sides.map(of);
    let what = ["recording", "joints", "samples", "findings", "held-out nMSE at first", "and now"];
    what.into_iter().zip(one.iter().zip(&two)).map(|(what, (one, two))| row([what, one, two])).collect()
}

/// Effects that either session names, joint by joint, and how surely.
fn effects(sides: [Side; 2]) -> Vec<Vec<String>> {
    joined(sides.map(|(_, session)| {
        let mut named = Vec::new();
        for effect in session.report.iter().flat_map(|report| &report.effects) {
            let (name, sureness) = (effect.effect.name, effect.sureness().to_string());
            if effect.joints.is_empty() {
                named.push((name.to_owned(), sureness.clone()));
            }
            named.extend(effect.joints.iter().map(|joint| (format!("{name}, joint {}", joint + 1), sureness.clone())));
        }
        named
    }))
}

/// Parameters that either newest model has, with their intervals.
fn parameters(sides: [Side; 2]) -> Vec<Vec<String>> {
    joined(sides.map(|(_, session)| {
        let Some(step) = session.current() else { return Vec::new() };
        let known = |parameter: &Parameter| {
            let term = step.fitted.model.terms[parameter.term].label();
            let (name, unit) = (&parameter.name, &parameter.unit);
            let place = parameter.joint.map_or(String::new(), |joint| format!(", joint {}", joint + 1));
            // The name of most effects says it already.
            let joint = if term.ends_with(&place) { "" } else { &place };
            let interval = parameter
                .interval
                .map_or(String::new(), |[low, high]| format!(" ({} … {})", number(low), number(high)));
            (format!("{name}{joint} [{unit}] of {term}"), format!("{}{interval}", number(parameter.value)))
        };
        step.fitted.parameters.iter().map(known).collect()
    }))
}

/// What has the same name, in one line; what one side lacks is a dash.
fn joined([one, two]: [Vec<(String, String)>; 2]) -> Vec<Vec<String>> {
    let of = |side: &[(String, String)], name: &str| {
        side.iter().find(|(other, _)| other == name).map_or("–".to_owned(), |(_, text)| text.clone())
    };
    let mut names: Vec<&String> = one.iter().map(|(name, _)| name).collect();
    for (name, _) in &two {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.into_iter().map(|name| row([name, &of(&one, name), &of(&two, name)])).collect()
}

/// Blocks under their headings; what stands before the first has none.
type Sections = Vec<(Option<String>, Vec<Block>)>;

fn sections(blocks: Vec<Block>) -> Sections {
    let mut sections: Sections = vec![(None, Vec::new())];
    for block in blocks {
        match (block, sections.last_mut()) {
            (Block::Heading(heading), _) => sections.push((Some(heading), Vec::new())),
            (other, Some((_, own))) => own.push(other),
            (_, None) => {}
        }
    }
    sections
}

/// Sections of the same heading, in the order of the first; then those that only the second has.
fn paired(first: Sections, mut second: Sections) -> Vec<(Option<String>, Vec<Block>, Vec<Block>)> {
    let mut pairs = Vec::new();
    for (heading, own) in first {
        let place = second.iter().position(|(other, _)| *other == heading);
        let other = place.map_or(Vec::new(), |place| second.remove(place).1);
        pairs.push((heading, own, other));
    }
    pairs.extend(second.into_iter().map(|(heading, other)| (heading, Vec::new(), other)));
    pairs
}
