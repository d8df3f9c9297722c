//! The file of an effect of one's own, read and checked.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::OwnEffectError;
use super::expression::functions;
use super::formula::{Formula, Formulas, Of, Quantity, Source, joint_number};
use crate::effect::{Axis, Dimension, Effect, Facts, Family, ParameterSpec, Scope, Stage};

/// Longest id and name, so that tables can be read.
const LONGEST_NAME: usize = 160;

/// The file, as it is written.
#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct Definition {
    id: Spanned<String>,
    /// For people; the id without its hyphens if not given.
    name: Option<String>,
    description: Spanned<String>,
    source: Spanned<String>,
    #[serde(default)]
    scope: ScopeWord,
    #[serde(default)]
    stage: StageWord,
    /// What it is hardly told from; by its channels if not given.
    family: Option<Family>,
    /// Over which state its residual shows best; by its channels if not given.
    axis: Option<Axis>,
    fingerprint: Option<String>,
    absorbed: Option<String>,
    tex: Option<String>,
    #[serde(default)]
    linear: Vec<Spanned<LinearEntry>>,
    #[serde(default)]
    shape: Vec<Spanned<ShapeEntry>>,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum ScopeWord {
    #[default]
    Joint,
    Pair,
    Arm,
}

/// Formulas add torque; what a drive or a reading does to it is no sum.
#[derive(Debug, Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum StageWord {
    #[default]
    Body,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct LinearEntry {
    name: Spanned<String>,
    symbol: Option<String>,
    unit: String,
    min: Option<f64>,
    max: Option<f64>,
    /// Torque on its own joint, for a value of 1.
    column: Option<Spanned<String>>,
    /// The same on the joint before, of a pair.
    before: Option<Spanned<String>>,
    /// The same on these joints, counted from 1, of the arm.
    #[serde(default)]
    joints: BTreeMap<String, Spanned<String>>,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct ShapeEntry {
    name: Spanned<String>,
    symbol: Option<String>,
    unit: String,
    min: Option<f64>,
    max: Option<f64>,
    /// Values that are tried first.
    start: Spanned<Vec<f64>>,
}

/// A text or a list that lives as long as the program.
fn kept(text: impl Into<String>) -> &'static str {
    Box::leak(text.into().into_boxed_str())
}

impl Definition {
    /// Reads the file; what it says is checked when it becomes an [`Effect`].
    pub(super) fn parse(text: &str) -> Result<Self, OwnEffectError> {
        let file: Definition = toml::from_str(text)
            .map_err(|error| OwnEffectError::at(text, error.span().map_or(0, |span| span.start), error.message()))?;
        let id = file.id();
        let is_id = id.starts_with(|c: char| c.is_ascii_lowercase())
            && id.len() <= LONGEST_NAME
            && id.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
        if !is_id {
            let what =
                format!("`{id}` is no id: begin with a small letter; small letters, digits and hyphens may follow");
            return Err(OwnEffectError::at(text, file.id.span().start, what));
        }
        Ok(file)
    }

    pub(super) fn id(&self) -> &str {
        self.id.get_ref()
    }

    /// The effect that it states.
    pub(super) fn effect(&self, text: &str) -> Result<Effect, OwnEffectError> {
        self.check_texts(text)?;
        let scope = match self.scope {
            ScopeWord::Joint => Scope::Joint,
            ScopeWord::Pair => Scope::Pair,
            ScopeWord::Arm => Scope::Arm,
        };
        let mut parameters = self.linear.iter().map(|entry| linear(text, entry)).collect::<Result<Vec<_>, _>>()?;
        let shapes = self.shape.iter().map(|entry| shape(text, entry)).collect::<Result<Vec<_>, _>>()?;
        parameters.extend(shapes);
        self.check_names(text, scope)?;
        let columns =
            self.linear.iter().map(|entry| self.formulas(text, entry, scope)).collect::<Result<Vec<_>, _>>()?;
        self.check_use_of_shapes(text, &columns)?;
        let sources = || columns.iter().flatten().flat_map(|(_, formula)| &formula.sources);
        let depends_on_load = sources().any(|source| matches!(source, Source::Channel(Quantity::Load, _)));
        let axis = self.axis.unwrap_or_else(|| axis(sources().copied()));
        let family = self.family.unwrap_or_else(|| family(sources().copied()));
        let formula = self.formula();
        let tex = self
            .tex
            .clone()
            .unwrap_or_else(|| format!(r"\mathtt{{{}}}", formula.replace('_', r"\_").replace('^', r"\hat{}")));
        let fingerprint = self
            .fingerprint
            .clone()
            .unwrap_or_else(|| format!("Residual against {}: the shape of its formula.", axis_word(axis)));
        let absorbed = self.absorbed.clone().unwrap_or_else(|| "Its file does not say it.".to_owned());
        Ok(Effect {
            id: kept(self.id()),
            name: kept(self.name.clone().unwrap_or_else(|| self.id().replace('-', " "))),
            formula: kept(formula),
            typeset: kept(tex),
            description: kept(self.description.get_ref()),
            fingerprint: kept(fingerprint),
            absorbed: kept(absorbed),
            source: kept(self.source.get_ref()),
            stage: Stage::Body(Box::leak(Box::new(Formulas { scope, columns }))),
            family,
            scope,
            axis,
            parameters: Vec::leak(parameters),
            facts: Facts { depends_on_load, written: Some(kept(text)), ..Facts::USUAL },
        })
    }

    fn check_texts(&self, text: &str) -> Result<(), OwnEffectError> {
        for (key, value) in [("description", &self.description), ("source", &self.source)] {
            if value.get_ref().trim().is_empty() {
                return Err(OwnEffectError::at(
                    text,
                    value.span().start,
                    format!("`{key}` is empty: say it in a sentence"),
                ));
            }
        }
        if self.linear.is_empty() {
            let what = "there is no `[[linear]]`: an effect has at least one linear parameter with its column";
            return Err(OwnEffectError::at(text, 0, what));
        }
        Ok(())
    }

    fn check_names(&self, text: &str, scope: Scope) -> Result<(), OwnEffectError> {
        let names = self.linear.iter().map(|entry| &entry.get_ref().name);
        let mut seen = HashSet::new();
        for name in names.chain(self.shape.iter().map(|entry| &entry.get_ref().name)) {
            let wrong = |what: String| Err(OwnEffectError::at(text, name.span().start, what));
            let word = name.get_ref().as_str();
            let is_name = word.starts_with(|c: char| c.is_ascii_alphabetic())
                && word.len() <= LONGEST_NAME
                && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            if !is_name {
                return wrong(format!("`{word}` is no name: begin with a letter; letters, digits and _ may follow"));
            }
            if word == "pi" || functions().any(|function| function == word) || Source::named(word, scope).is_some() {
                return wrong(format!(
                    "`{word}` is a channel, a function or a constant: give the parameter another name"
                ));
            }
            if !seen.insert(word) {
                return wrong(format!("two parameters are named `{word}`: rename one"));
            }
        }
        Ok(())
    }

    /// A shape that no formula has could never be found.
    fn check_use_of_shapes(&self, text: &str, columns: &[Vec<(Of, Formula)>]) -> Result<(), OwnEffectError> {
        for (place, entry) in self.shape.iter().enumerate() {
            let is_used = columns.iter().flatten().any(|(_, formula)| formula.sources.contains(&Source::Shape(place)));
            if !is_used {
                let what =
                    format!("no formula has `{}`: use it in a column, or take it out", entry.get_ref().name.get_ref());
                return Err(OwnEffectError::at(text, entry.get_ref().name.span().start, what));
            }
        }
        Ok(())
    }

    /// The formulas of a linear parameter, and where each acts.
    fn formulas(
        &self,
        text: &str,
        entry: &Spanned<LinearEntry>,
        scope: Scope,
    ) -> Result<Vec<(Of, Formula)>, OwnEffectError> {
        let LinearEntry { name, column, before, joints, .. } = entry.get_ref();
        let wrong = |span: Range<usize>, what: String| Err(OwnEffectError::at(text, span.start, what));
        let name = name.get_ref();
        let mut written = Vec::new();
        match scope {
            Scope::Arm => {
                if let Some(other) = column.as_ref().or(before.as_ref()) {
                    let what = format!(
                        "an effect of the arm has no joint of its own: write `joints = {{ 1 = \"…\" }}` for `{name}`"
                    );
                    return wrong(other.span(), what);
                }
                for (number, formula) in joints {
                    let Some(joint) = joint_number(number) else {
                        return wrong(formula.span(), format!("`{number}` is no joint: joints are counted from 1"));
                    };
                    written.push((Of::Joint(joint), formula));
                }
            }
            Scope::Joint | Scope::Pair => {
                if let Some(formula) = joints.values().next() {
                    return wrong(
                        formula.span(),
                        format!("`joints` is for effects of the arm: write `column` for `{name}`"),
                    );
                }
                written.extend(column.iter().map(|formula| (Of::Own, formula)));
                match before {
                    Some(formula) if scope == Scope::Joint => {
                        return wrong(formula.span(), "`before` is for pairs: write `scope = \"pair\"`".to_owned());
                    }
                    before => written.extend(before.iter().map(|formula| (Of::Before, formula))),
                }
            }
        }
        if written.is_empty() {
            let key = if scope == Scope::Arm { "joints" } else { "column" };
            return wrong(entry.span(), format!("`{name}` says no `{key}`: the torque that a value of 1 makes"));
        }
        let shapes: Vec<&str> = self.shape.iter().map(|entry| entry.get_ref().name.get_ref().as_str()).collect();
        let part = |(acts_on, written)| Ok((acts_on, formula(text, written, scope, &shapes)?));
        written.into_iter().map(part).collect()
    }

    /// All of it as one formula, for people.
    fn formula(&self) -> String {
        let mut sums: Vec<(String, Vec<String>)> = Vec::new();
        for entry in &self.linear {
            let LinearEntry { name, column, before, joints, .. } = entry.get_ref();
            let own = column.iter().map(|formula| ("tau".to_owned(), formula));
            let before = before.iter().map(|formula| ("tau_before".to_owned(), formula));
            let joints = joints.iter().map(|(joint, formula)| (format!("tau_{joint}"), formula));
            for (torque, formula) in own.chain(before).chain(joints) {
                let formula = formula.get_ref().trim();
                let is_sum = formula.contains(['+', '-']);
                let factor = if is_sum { format!("({formula})") } else { formula.to_owned() };
                let summand = format!("{} * {factor}", name.get_ref());
                match sums.iter_mut().find(|(known, _)| *known == torque) {
                    Some((_, summands)) => summands.push(summand),
                    None => sums.push((torque, vec![summand])),
                }
            }
        }
        let sum = |(torque, summands): &(String, Vec<String>)| format!("{torque} = {}", summands.join(" + "));
        sums.iter().map(sum).collect::<Vec<_>>().join(", ")
    }
}

fn linear(text: &str, entry: &Spanned<LinearEntry>) -> Result<ParameterSpec, OwnEffectError> {
    let LinearEntry { name, symbol, unit, min, max, .. } = entry.get_ref();
    let (min, max) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
    let (name, symbol) = (kept(name.get_ref()), kept(symbol.as_ref().unwrap_or(name.get_ref())));
    let spec = ParameterSpec::linear(name, symbol, Dimension::of_unit(unit)).between(min, max);
    check_bounds(text, entry.span().start, &spec)?;
    Ok(spec)
}

fn shape(text: &str, entry: &Spanned<ShapeEntry>) -> Result<ParameterSpec, OwnEffectError> {
    let ShapeEntry { name, symbol, unit, min, max, start } = entry.get_ref();
    let wrong = |what: String| Err(OwnEffectError::at(text, start.span().start, what));
    let (word, values) = (name.get_ref(), start.get_ref());
    if values.is_empty() {
        return wrong(format!("`start` of `{word}` is empty: give values that are tried first, such as [0.1, 1.0]"));
    }
    // The search goes over its logarithm.
    if values.iter().any(|value| !value.is_finite() || *value <= 0.0) {
        return wrong(format!(
            "`start` of `{word}` must be greater than 0: where it is to be less, write -{word} in the formula"
        ));
    }
    if !values.is_sorted_by(|one, next| one < next) {
        return wrong(format!("`start` of `{word}` must be ascending"));
    }
    let (min, max) = (min.unwrap_or(0.0), max.unwrap_or(f64::INFINITY));
    let (name, symbol) = (kept(word), kept(symbol.as_ref().unwrap_or(word)));
    let spec =
        ParameterSpec::shape(name, symbol, Dimension::of_unit(unit), Vec::leak(values.clone())).between(min, max);
    check_bounds(text, entry.span().start, &spec)?;
    if min < 0.0 || values.iter().any(|value| !spec.admits(*value)) {
        return wrong(format!("`start` and `min` of `{word}` must lie between 0 and its bounds {min} and {max}"));
    }
    Ok(spec)
}

fn check_bounds(text: &str, at: usize, spec: &ParameterSpec) -> Result<(), OwnEffectError> {
    let ParameterSpec { name, min, max, .. } = spec;
    match min < max {
        true => Ok(()),
        false => Err(OwnEffectError::at(
            text,
            at,
            format!("`{name}` lies between {min} and {max}: `min` must be less than `max`"),
        )),
    }
}

/// Reads a formula; its mistakes are told where they stand in the file.
fn formula(text: &str, written: &Spanned<String>, scope: Scope, shapes: &[&str]) -> Result<Formula, OwnEffectError> {
    Formula::parse(written.get_ref(), scope, shapes).map_err(|mistake| {
        // Where the formula itself begins, if the file has it letter by letter.
        let within = text.get(written.span()).and_then(|quoted| quoted.find(written.get_ref().as_str()));
        let offset = within.map_or(0, |within| within + mistake.at);
        OwnEffectError::at(text, written.span().start + offset, mistake.what)
    })
}

/// The state over which formulas in these channels most likely show.
fn axis(sources: impl Iterator<Item = Source>) -> Axis {
    let rank = |source: Source| match source {
        Source::Channel(Quantity::Velocity | Quantity::Direction | Quantity::PairDirection, _) => Axis::Velocity,
        Source::Channel(Quantity::Acceleration, _) => Axis::Acceleration,
        Source::Channel(Quantity::Position | Quantity::Load, _) | Source::Shape(_) => Axis::Position,
        Source::Time => Axis::Time,
    };
    let axes: Vec<Axis> = sources.map(rank).collect();
    let order = [Axis::Velocity, Axis::Acceleration, Axis::Time];
    order.into_iter().find(|axis| axes.contains(axis)).unwrap_or(Axis::Position)
}

/// What formulas in these channels are most likely hardly told from.
fn family(sources: impl Iterator<Item = Source>) -> Family {
    let sources: Vec<Source> = sources.collect();
    let has =
        |wanted: Quantity| sources.iter().any(|source| matches!(source, Source::Channel(found, _) if *found == wanted));
    let order = [
        (Quantity::PairDirection, Family::SharedFriction),
        (Quantity::Direction, Family::DryFriction),
        (Quantity::Velocity, Family::SpeedFriction),
        (Quantity::Acceleration, Family::RotorInertia),
        (Quantity::Position, Family::Spring),
        (Quantity::Load, Family::Gain),
    ];
    order.into_iter().find(|(quantity, _)| has(*quantity)).map_or(Family::Offset, |(_, family)| family)
}

fn axis_word(axis: Axis) -> &'static str {
    match axis {
        Axis::Time => "time",
        Axis::Position => "position",
        Axis::Velocity => "velocity",
        Axis::Acceleration => "acceleration",
    }
}
