//! The files of a lesson, read and checked. Whatever is wrong is told with file, line and column.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::case::Case;
use super::number::Number;
use super::pose::PoseWish;
use super::wish::Wish;
use crate::effect::registry;
use crate::model::Preset;
use crate::recording::correction::Correction;
use crate::session::study::{Lock, Source};
use crate::simulation::extrapolation::Stretch;

/// Nobody is to read longer than this at a time \[s\].
pub const LONGEST_READING: f64 = 90.0;
/// What is read in a second, in a language that is not one's own \[words\].
const WORDS_A_SECOND: f64 = 3.0;

/// A lesson.
#[derive(Debug, Clone)]
pub struct Lesson {
    /// The files that it was read from.
    pub source: Source,
    /// Its short name.
    pub id: String,
    /// Its place among the others.
    pub number: u32,
    /// How long it takes \[min\].
    pub minutes: u32,
    /// The share of the points by which it is passed.
    pub pass: f64,
    /// What it is called.
    pub title: String,
    /// What it is about, in a sentence.
    pub summary: String,
    /// Its steps, in order; at least one.
    pub steps: Vec<Step>,
    pub(super) cases: BTreeMap<Spanned<String>, Case>,
}

/// What a step is in the course of a lesson.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Something that one would not have thought.
    Puzzle,
    /// What one thinks will come; locked in.
    Predict,
    /// Something to be done.
    Act,
    /// What came, beside what one thought.
    Reveal,
    /// Why it is so.
    Why,
    /// The same in another case.
    Changed,
}

/// A step of a lesson.
#[derive(Debug, Clone)]
pub struct Step {
    /// Its short name.
    pub id: String,
    /// What it is in the course of the lesson.
    pub stage: Stage,
    /// The screen that it is about, by its id.
    pub screen: Option<Spanned<String>>,
    /// The recording that it begins with; without one it goes on with what is there.
    pub case: Option<String>,
    /// What stays locked while it lasts.
    pub locks: Vec<Lock>,
    /// What it is worth.
    pub points: f64,
    /// Whether the arm can be posed beside it.
    pub arm: bool,
    /// What it asks for.
    pub task: Task,
    /// What can be done with a click beside the text.
    pub offers: Vec<Offer>,
    /// What is read.
    pub text: StepText,
}

/// What a step asks for.
#[derive(Debug, Clone)]
pub enum Task {
    /// Nothing: it is read.
    Read,
    /// One of several.
    Choice(Choice),
    /// A number.
    Number(Asked),
    /// A state of the arm.
    Pose(Vec<PoseWish>),
    /// Something to be done, after which the session fulfils all of these.
    Want(Vec<Wish>),
    /// The predictions of these steps are held against what is so.
    Reveal(Vec<String>),
}

/// A question with several answers.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Choice {
    /// The answers, by their names: ids of effects, numbers of joints, or names that the text explains.
    pub options: Vec<String>,
    /// Which is right.
    pub right: Right,
    /// Whether one says how sure one is.
    #[serde(default)]
    pub confidence: bool,
}

/// What [`Right::MassPositive`] can be.
pub(super) const MASS_ANSWERS: [&str; 2] = ["positive", "not-positive"];

/// Which of several answers is right.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Right {
    /// Always this one.
    Is(String),
    /// The effect that is hidden in the recording of the step, by its id.
    HiddenEffect,
    /// The joint on which it is hidden, counted from 1.
    HiddenJoint,
    /// The fault with this place among those that were drawn, counted from 0.
    Fault(usize),
    /// The model, by its preset, whose held-out error is the least.
    BestModel,
    /// `positive` if the mass matrix of the newest structured DeLaN is positive definite wherever the recording went, or else
    /// `not-positive`.
    MassPositive,
    /// The model, by its preset, whose error is the least outside the data.
    BestAt {
        /// In which way the motion leaves the data.
        stretch: Stretch,
        /// How far: times the speed, range or load of the data.
        at: f64,
    },
}

/// A question for a number.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Asked {
    /// What is right.
    pub is: Number,
    /// How many times too much or too little is still right.
    pub within: f64,
    /// What stands behind it.
    #[serde(default)]
    pub unit: String,
}

/// What can be done with a click beside the text.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Offer {
    /// To set something right in the recording.
    SetRight(Correction),
    /// To record the same arm in another way: a case of the lesson.
    Record(String),
    /// To train a model, with the settings of the session.
    Train(Preset),
    /// To see how the errors of all models grow.
    Extrapolate(Stretch),
}

/// What is read in a step.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct StepText {
    /// In a few words.
    pub title: String,
    /// What is read first.
    pub text: String,
    /// What is asked.
    #[serde(default)]
    pub ask: String,
    /// The answers or offers that are no effects and no joints, by their names.
    #[serde(default)]
    pub names: BTreeMap<String, String>,
    /// What helps after a wrong answer.
    #[serde(default)]
    pub hint: String,
    /// What is read once it is answered.
    #[serde(default)]
    pub after: String,
}

impl StepText {
    /// How long it takes to read all of it \[s\].
    pub fn reading_time(&self) -> f64 {
        let texts = [&self.title, &self.text, &self.ask, &self.hint, &self.after];
        let words = texts.into_iter().chain(self.names.values()).map(|text| text.split_whitespace().count());
        words.sum::<usize>() as f64 / WORDS_A_SECOND
    }
}

/// A lesson can't be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}, line {line}, column {column}: {what}", file.words())]
pub struct LessonFileError {
    /// In which file.
    pub file: Which,
    /// Counted from 1.
    pub line: usize,
    /// Counted from 1.
    pub column: usize,
    /// What is wrong, and how to mend it.
    pub what: String,
}

/// One of the two files of a lesson.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// Steps and what they ask.
    Data,
    /// What is read.
    Text,
}

impl Which {
    fn words(self) -> &'static str {
        match self {
            Which::Data => "the lesson",
            Which::Text => "the lesson's text",
        }
    }
}

/// The file with the text of a lesson in a language: `en/mine.toml` beside `mine.toml`.
pub fn text_beside(data: &Path, language: &str) -> PathBuf {
    let folder = data.parent().unwrap_or(Path::new("")).join(language);
    data.file_name().map_or(folder.clone(), |name| folder.join(name))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Data {
    id: String,
    number: u32,
    minutes: u32,
    #[serde(default = "usual_pass")]
    pass: Spanned<f64>,
    #[serde(default, rename = "case")]
    cases: BTreeMap<Spanned<String>, Case>,
    #[serde(rename = "step")]
    steps: Vec<Spanned<StepData>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct StepData {
    id: Spanned<String>,
    stage: Stage,
    screen: Option<Spanned<String>>,
    case: Option<Spanned<String>>,
    #[serde(default)]
    locks: Vec<Lock>,
    #[serde(default = "one")]
    points: Spanned<f64>,
    #[serde(default)]
    arm: bool,
    choice: Option<Spanned<Choice>>,
    number: Option<Spanned<Asked>>,
    pose: Option<Spanned<Vec<PoseWish>>>,
    want: Option<Spanned<Vec<Wish>>>,
    reveal: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    offers: Vec<Spanned<Offer>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Text {
    title: String,
    summary: String,
    #[serde(default, rename = "step")]
    steps: BTreeMap<Spanned<String>, Spanned<StepText>>,
}

fn usual_pass() -> Spanned<f64> {
    Spanned::new(0..0, 0.6)
}

fn one() -> Spanned<f64> {
    Spanned::new(0..0, 1.0)
}

/// Tells what is wrong at a place of a file.
struct Reader<'a> {
    file: Which,
    text: &'a str,
}

impl Reader<'_> {
    fn wrong(&self, place: Range<usize>, what: impl Into<String>) -> LessonFileError {
        let before = self.text.get(..place.start).unwrap_or(self.text);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.rsplit('\n').next().unwrap_or_default().chars().count();
        LessonFileError { file: self.file, line, column, what: what.into() }
    }

    fn read<T: serde::de::DeserializeOwned>(&self) -> Result<T, LessonFileError> {
        toml::from_str(self.text).map_err(|error| self.wrong(error.span().unwrap_or(0..0), error.message()))
    }
}

impl Lesson {
    /// Reads a lesson and checks that its parts fit each other.
    ///
    /// # Errors
    /// [`LessonFileError`] for the first thing that can't be.
    pub fn read(source: &Source) -> Result<Lesson, LessonFileError> {
        let reader = Reader { file: Which::Data, text: &source.data };
        let texts = Reader { file: Which::Text, text: &source.text };
        let (data, mut text): (Data, Text) = (reader.read()?, texts.read()?);
        if !(0.0..=1.0).contains(data.pass.get_ref()) {
            return Err(reader.wrong(data.pass.span(), "the share of the points that passes is from 0 to 1"));
        }
        for (name, case) in &data.cases {
            case.check().map_err(|what| reader.wrong(name.span(), what))?;
        }
        let mut steps: Vec<Step> = Vec::new();
        for step in data.steps {
            let (place, id) = (step.span(), step.get_ref().id.get_ref().clone());
            if steps.iter().any(|other| other.id == id) {
                return Err(reader.wrong(place, format!("another step has the id `{id}` already")));
            }
            let of_step = text.steps.remove(id.as_str()).ok_or_else(|| {
                let end = source.text.len()..source.text.len();
                texts.wrong(end, format!("there is no text for the step `{id}`: add [step.{id}]"))
            })?;
            let (written, own) = (of_step.span(), of_step.into_inner());
            let seconds = own.reading_time();
            if seconds > LONGEST_READING {
                let what =
                    format!("the step `{id}` takes {seconds:.0} s to read: {LONGEST_READING} s at most, say less");
                return Err(texts.wrong(written, what));
            }
            let known = Known { reader: &reader, cases: &data.cases, before: &steps };
            let step = known.step(step.into_inner(), place, own)?;
            check_names(&step).map_err(|what| texts.wrong(written, what))?;
            steps.push(step);
        }
        if let Some(id) = text.steps.keys().next() {
            let what = format!("the lesson has no step `{}`", id.get_ref());
            return Err(texts.wrong(id.span(), what));
        }
        if steps.is_empty() {
            return Err(reader.wrong(0..0, "there is no [[step]]: add at least one"));
        }
        Ok(Lesson {
            source: source.clone(),
            id: data.id,
            number: data.number,
            minutes: data.minutes,
            pass: data.pass.into_inner(),
            title: text.title,
            summary: text.summary,
            steps,
            cases: data.cases,
        })
    }

    /// The step of this id.
    pub fn step(&self, id: &str) -> Option<&Step> {
        self.steps.iter().find(|step| step.id == id)
    }

    /// Says where in the file a case stands that can't be simulated. That takes a moment, so reading does not ask for it.
    ///
    /// # Errors
    /// [`LessonFileError`] with what can't be.
    pub fn check_cases(&self) -> Result<(), LessonFileError> {
        let reader = Reader { file: Which::Data, text: &self.source.data };
        for (name, case) in &self.cases {
            // Whatever can't be simulated shows with any seed.
            case.making(1).map_err(|error| reader.wrong(name.span(), error.to_string()))?;
        }
        Ok(())
    }

    /// Says where in the file a screen is named that there is not; whoever knows the screens calls it.
    ///
    /// # Errors
    /// [`LessonFileError`] with what there is instead.
    pub fn check_screens(&self, known: &[&str]) -> Result<(), LessonFileError> {
        let reader = Reader { file: Which::Data, text: &self.source.data };
        for screen in self.steps.iter().filter_map(|step| step.screen.as_ref()) {
            if !known.contains(&screen.get_ref().as_str()) {
                let what = format!("there is no screen `{}`; there are: {}", screen.get_ref(), known.join(", "));
                return Err(reader.wrong(screen.span(), what));
            }
        }
        Ok(())
    }
}

/// What is known where a step is read.
struct Known<'a> {
    reader: &'a Reader<'a>,
    cases: &'a BTreeMap<Spanned<String>, Case>,
    before: &'a [Step],
}

impl Known<'_> {
    fn step(&self, data: StepData, place: Range<usize>, text: StepText) -> Result<Step, LessonFileError> {
        let StepData { id, stage, screen, case, locks, points, arm, choice, number, pose, want, reveal, offers } = data;
        if let Some(case) = &case {
            self.check_case(case.get_ref(), case.span())?;
        }
        for offer in &offers {
            if let Offer::Record(case) = offer.get_ref() {
                self.check_case(case, offer.span())?;
            }
        }
        if !(0.0..=100.0).contains(points.get_ref()) {
            return Err(self.reader.wrong(points.span(), "a step is worth 0 to 100 points"));
        }
        let mut tasks = Vec::new();
        if let Some(choice) = choice {
            self.check_choice(&choice)?;
            tasks.push(Task::Choice(choice.into_inner()));
        }
        if let Some(number) = number {
            if number.get_ref().within <= 1.0 {
                let what = "`within` says how many times too much is still right, so it is more than 1";
                return Err(self.reader.wrong(number.span(), what));
            }
            tasks.push(Task::Number(number.into_inner()));
        }
        tasks.extend(pose.map(|pose| Task::Pose(pose.into_inner())));
        tasks.extend(want.map(|want| Task::Want(want.into_inner())));
        if let Some(reveal) = reveal {
            for of in &reveal {
                let is_predicted = |step: &Step| step.id == *of.get_ref() && step.stage == Stage::Predict;
                if !self.before.iter().any(is_predicted) {
                    let what = format!("no step before it predicts `{}`", of.get_ref());
                    return Err(self.reader.wrong(of.span(), what));
                }
            }
            tasks.push(Task::Reveal(reveal.into_iter().map(Spanned::into_inner).collect()));
        }
        if tasks.len() > 1 {
            let what = "a step asks for one thing: choice, number, pose, want or reveal";
            return Err(self.reader.wrong(place, what));
        }
        let task = tasks.pop().unwrap_or(Task::Read);
        if stage == Stage::Predict && !matches!(task, Task::Choice(_) | Task::Number(_)) {
            return Err(self.reader.wrong(place, "what is predicted is a choice or a number"));
        }
        Ok(Step {
            id: id.into_inner(),
            stage,
            screen,
            case: case.map(Spanned::into_inner),
            locks,
            points: points.into_inner(),
            arm: arm || matches!(task, Task::Pose(_)),
            task,
            offers: offers.into_iter().map(Spanned::into_inner).collect(),
            text,
        })
    }

    fn check_case(&self, name: &str, place: Range<usize>) -> Result<(), LessonFileError> {
        if self.cases.contains_key(name) {
            return Ok(());
        }
        Err(self.reader.wrong(place, format!("there is no case `{name}`: add [case.{name}]")))
    }

    fn check_choice(&self, choice: &Spanned<Choice>) -> Result<(), LessonFileError> {
        let Choice { options, right, .. } = choice.get_ref();
        let wrong = |what: String| Err(self.reader.wrong(choice.span(), what));
        if options.len() < 2 {
            return wrong("a choice has at least two options".to_owned());
        }
        match right {
            Right::Is(right) if !options.contains(right) => wrong(format!("`{right}`, which is right, is no option")),
            Right::HiddenEffect => match options.iter().find(|option| registry::find(option).is_err()) {
                Some(option) => wrong(format!("`{option}` is no effect: `torquescope effects` lists them")),
                None => Ok(()),
            },
            Right::MassPositive if options.iter().any(|option| !MASS_ANSWERS.contains(&option.as_str())) => {
                wrong(format!("the answers are {}", MASS_ANSWERS.join(" and ")))
            }
            Right::HiddenJoint if options.iter().any(|option| option.parse::<usize>().is_err()) => {
                wrong("joints are numbers, counted from 1".to_owned())
            }
            _ => Ok(()),
        }
    }
}

/// Every answer and offer needs a name, unless the program has one.
fn check_names(step: &Step) -> Result<(), String> {
    let options = match &step.task {
        Task::Choice(choice) => choice.options.as_slice(),
        _ => &[],
    };
    match options.iter().find(|option| step.name_of(option).is_none()) {
        Some(option) => Err(format!("the answer `{option}` has no name: add it to [step.{}.names]", step.id)),
        None => Ok(()),
    }
}

impl Step {
    /// What an answer is called; `None` if nothing says it.
    pub fn name_of(&self, option: &str) -> Option<String> {
        let of_effect = || registry::find(option).ok().map(|effect| effect.name.to_owned());
        let of_model = || Preset::ALL.into_iter().find(|preset| preset.id() == option).map(|it| it.title().to_owned());
        let of_joint = || option.parse::<usize>().ok().map(|joint| format!("joint {joint}"));
        let of_fault = || option.parse::<Correction>().ok().map(|fault| fault.fault());
        let own = self.text.names.get(option).cloned();
        own.or_else(of_effect).or_else(of_model).or_else(of_joint).or_else(of_fault)
    }

    /// What an offer is called.
    pub fn name_of_offer(&self, offer: &Offer) -> String {
        let (name, usual) = match offer {
            Offer::SetRight(correction) => (correction.to_string(), format!("set right: {}", correction.fault())),
            Offer::Record(case) => (case.clone(), format!("record {case}")),
            Offer::Train(preset) => (preset.id().to_owned(), format!("train {}", preset.title())),
            Offer::Extrapolate(stretch) => (stretch.name().to_owned(), format!("extrapolate in {}", stretch.name())),
        };
        self.text.names.get(&name).cloned().unwrap_or(usual)
    }
}
