//! The commands that lead to a session anew, as they are typed into a terminal: what a report ends with.
//!
//! What no option can say goes into a file, which the lines write themselves (`cat > FILE <<'END'`). What no command can say is a
//! remark that tells so.

use super::source::Origin;
use super::{Session, Source, Step};
use crate::arm::Posture;
use crate::effect::place::Place;
use crate::model::{Model, Preset};
use crate::recording::Recording;
use crate::recording::catalogue;
use crate::recording::hold_out::HoldOut;
use crate::recording::mapping::MappingSpec;
use crate::recording::read::ReadOptions;
use crate::simulation::Scenario;
use crate::training::fit::{Plan, SavedRun};
use crate::training::optimiser::Optimiser;
use crate::training::schedule::Schedule;

/// How far two errors are apart that were computed from the same numbers.
const SAME: f64 = 1e-9;

/// The lines that make a session anew: its recording, its model with the error that it has, and the diagnosis that it tells of.
pub fn again(session: &Session) -> Vec<String> {
    let Some(recording) = session.recording.as_deref() else { return Vec::new() };
    let mut lines = Lines::default();
    let Some(source) = session.source.as_deref() else {
        lines.remark("The recording is in no file of its own; the session, once it is saved, has it and all models.");
        lines.command(["report", "saved.torquescope", "-o", "report.html"]);
        return lines.0;
    };
    let Some(data) = lines.data(source, session, recording) else { return lines.0 };
    for effect in &session.own_effects {
        lines.own_effect(effect.id, effect.facts.written);
    }
    let own = session.own_effects.iter().flat_map(|effect| ["--effect-file".to_owned(), format!("{}.toml", effect.id)]);
    let data: Vec<String> = data.into_iter().chain(own).collect();
    if let Some(step) = session.current() {
        lines.model("train", &data, step, recording);
    }
    if let Some(step) = diagnosed(session) {
        lines.model("diagnose", &data, step, recording);
    }
    lines.0
}

/// The step that the session's report is about.
fn diagnosed(session: &Session) -> Option<&Step> {
    let told = &session.report.as_deref()?.held_out_nmse;
    let is_of = |step: &&std::sync::Arc<Step>| {
        let own = step.evaluation.held_out_nmse();
        own.len() == told.len() && own.iter().zip(told).all(|(own, told)| (own - told).abs() <= SAME * told.abs())
    };
    session.ladder.iter().rev().find(is_of).or(session.ladder.last()).map(|step| &**step)
}

/// What is typed, line by line.
#[derive(Default)]
struct Lines(Vec<String>);

impl Lines {
    fn remark(&mut self, text: &str) {
        self.0.push(format!("# {text}"));
    }

    fn command<T: AsRef<str>>(&mut self, words: impl IntoIterator<Item = T>) {
        let words = words.into_iter().map(|word| quoted(word.as_ref()));
        self.0.push(std::iter::once("torquescope".to_owned()).chain(words).collect::<Vec<_>>().join(" "));
    }

    /// Writes a file that later lines read.
    fn file(&mut self, name: &str, text: &str) {
        self.0.push(format!("cat > {} <<'END'\n{}\nEND", quoted(name), text.trim_end()));
    }

    fn own_effect(&mut self, id: &str, text: Option<&str>) {
        match text {
            Some(text) => self.file(&format!("{id}.toml"), text),
            None => self.remark(&format!("{id}.toml is the file of the effect of that name.")),
        }
    }

    /// What says which recording is read and how; `None` if no command does.
    fn data(&mut self, source: &Source, session: &Session, recording: &Recording) -> Option<Vec<String>> {
        let mut words = match &source.origin {
            Origin::Files(paths) => paths.iter().map(|path| path.display().to_string()).collect(),
            made => vec![self.simulated(made, session, recording)?],
        };
        words.extend(self.reading(&source.options));
        match &source.held_out {
            HoldOut::Fifth(0) => (),
            HoldOut::Fifth(turn) => words.extend(["--held-out-fifth".to_owned(), (turn + 1).to_string()]),
            HoldOut::Trajectories(names) => {
                words.push("--held-out".to_owned());
                words.extend(names.iter().cloned());
            }
        }
        Some(words)
    }

    /// The file of a recording that is simulated anew; `None` if that would spell out what is sealed.
    fn simulated(&mut self, made: &Origin, session: &Session, recording: &Recording) -> Option<String> {
        let plain = |letter: char| if letter.is_alphanumeric() { letter } else { '-' };
        let name: String = recording.name.chars().map(plain).collect();
        let output = format!("{name}.npz");
        let (words, scenario) = match made {
            Origin::Mystery { level, seed } => {
                (vec![format!("--mystery={}", level.name()), "--seed".to_owned(), seed.to_string()], None)
            }
            Origin::Simulated(scenario) if **scenario == Scenario::embedded() => (vec!["--embedded".to_owned()], None),
            _ if session.truth.is_none() => {
                self.remark(
                    "How the recording was simulated would tell what is sealed in it. Open the seal to have it told; the session, \
                     once it is saved, has the recording and all models.",
                );
                self.command(["report", "saved.torquescope", "-o", "report.html"]);
                return None;
            }
            Origin::Simulated(scenario) => {
                let file = (format!("{name}.json"), serde_json::to_string_pretty(scenario).ok()?);
                (vec!["--scenario".to_owned(), file.0.clone()], Some(file))
            }
            Origin::World(world) => {
                let file = (format!("{name}.toml"), toml::to_string(world).ok()?);
                (vec!["--world".to_owned(), "--scenario".to_owned(), file.0.clone()], Some(file))
            }
            Origin::Files(_) => return None,
        };
        if let Some((name, text)) = scenario {
            self.file(&name, &text);
        }
        let whole = std::iter::once("simulate".to_owned()).chain(words).chain(["-o".to_owned(), output.clone()]);
        self.command(whole);
        Some(output)
    }

    /// How files are read, as options.
    fn reading(&mut self, options: &ReadOptions) -> Vec<String> {
        let mut words = Vec::new();
        let mut say = |option: &str, value: String| words.extend([option.to_owned(), value]);
        if let Some(mapping) = &options.mapping {
            say("--map", self.mapping(mapping));
        }
        if let Some(zero) = options.zero {
            match direction(zero) {
                Some(direction) => say("--zero", direction.to_owned()),
                None => self.remark(&format!("No option says this zero position and sense of the joints: {zero:?}.")),
            }
        }
        if let Some(arm) = &options.arm {
            // Numbers always have a JSON form.
            self.file("arm.json", &serde_json::to_string_pretty(arm).unwrap_or_default());
            say("--arm", "arm.json".to_owned());
        }
        if let Some(facts) = options.torque.as_ref().filter(|facts| !facts.is_empty()) {
            say("--torque", facts.iter().map(|fact| fact.name()).collect::<Vec<_>>().join(","));
        }
        let numbers = [
            ("--rate", options.rate_hz),
            ("--low-pass", options.low_pass_hz),
            ("--gaussian", options.gaussian_samples),
        ];
        if let Some(side) = options.encoders {
            say("--encoders", side.name().to_owned());
        }
        for (option, value) in numbers {
            value.into_iter().for_each(|value| say(option, value.to_string()));
        }
        options.set_right.iter().for_each(|correction| say("--set-right", correction.to_string()));
        words
    }

    /// A mapping by its name, as text, or by the file that it needs.
    fn mapping(&mut self, mapping: &MappingSpec) -> String {
        let known = catalogue::ALL.iter().map(|(name, _)| *name);
        let by_name = known.into_iter().find(|name| catalogue::mapping(name).as_ref() == Ok(mapping));
        let text = mapping.to_string();
        if let Some(name) = by_name {
            return name.to_owned();
        }
        if text.parse::<MappingSpec>().as_ref() == Ok(mapping) {
            return text;
        }
        match mapping.to_toml() {
            Ok(file) => self.file("mapping.toml", &file),
            Err(problem) => self.remark(&format!("mapping.toml can't be told: {problem}")),
        }
        "mapping.toml".to_owned()
    }

    /// A command on a model of these data.
    fn model(&mut self, command: &str, data: &[String], step: &Step, recording: &Recording) {
        let run = step.run.as_deref();
        let plan = run.map_or_else(Plan::default, SavedRun::asked);
        let model = run.map_or(&step.fitted.model, |run| &run.model);
        let Some(model) = model_words(model, recording, &plan) else {
            return self.remark(&format!("No option of `{command}` says this model: {}.", step.name));
        };
        let training = if run.is_some() { self.training(&plan) } else { Vec::new() };
        if run.is_some_and(|run| run.is_warm) {
            self.remark("Its networks went on from the weights of another model; trained from the start, they end a bit elsewhere.");
        }
        if let Some(reason) = step.early_end() {
            self.remark(&format!("Its training ended early: {reason}."));
        }
        let words = [command.to_owned()].into_iter().chain(data.iter().cloned()).chain(model).chain(training);
        self.command(words);
    }

    /// What a plan has that its recipe has not, as options.
    fn training(&mut self, plan: &Plan) -> Vec<String> {
        let usual = Plan::of(plan.recipe);
        let mut words = Vec::new();
        let mut say = |option: &str, differs: bool, value: String| {
            if differs {
                words.extend([option.to_owned(), value]);
            }
        };
        let (options, of_recipe) = (&plan.options, &usual.options);
        say("--recipe", plan.recipe != Plan::default().recipe, as_in_files(&plan.recipe));
        say("--epochs", options.epochs != of_recipe.epochs, options.epochs.to_string());
        say("--batch", options.batch != of_recipe.batch, options.batch.to_string());
        say("--learning-rate", options.rate != of_recipe.rate, options.rate.to_string());
        let schedule = match options.schedule {
            Schedule::Constant => "constant",
            Schedule::Cosine { .. } => "cosine",
            Schedule::OneCycle { .. } => "one-cycle",
        };
        say("--schedule", options.schedule != of_recipe.schedule, schedule.to_owned());
        let optimiser = match options.optimiser {
            Optimiser::AdamW { .. } => "adamw",
            Optimiser::Soap { .. } => "soap",
        };
        say("--optimiser", options.optimiser != of_recipe.optimiser, optimiser.to_owned());
        say("--weight-decay", options.decay != of_recipe.decay, options.decay.to_string());
        let hidden = plan.layers.hidden.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
        say("--hidden", plan.layers.hidden != usual.layers.hidden, hidden);
        let activation = as_in_files(&plan.layers.activation);
        say("--activation", plan.layers.activation != usual.layers.activation, activation);
        if let Some(features) = plan.features {
            say("--features", plan.features != usual.features, as_in_files(&features));
        }
        say("--smoothness", plan.smoothness != usual.smoothness, plan.smoothness.to_string());
        say("--cholesky", plan.cholesky != usual.cholesky, plan.cholesky.to_string());
        say("--normalise", plan.normalise != usual.normalise, plan.normalise.to_string());
        say("--precision", plan.precision != usual.precision, as_in_files(&plan.precision));
        if let Some(goal) = options.goal {
            say("--goal", true, goal.to_string());
        }
        // Always told: it is what a stranger asks for.
        say("--training-seed", true, options.seed.to_string());
        words
    }
}

/// The model as a preset with effects, if it is one.
fn model_words(model: &Model, recording: &Recording, plan: &Plan) -> Option<Vec<String>> {
    let base = model.terms.len() - model.effects().count();
    let begins = |preset: &Preset| {
        let begun = plan.shaped(&preset.model(recording).ok()?);
        (begun.terms == model.terms[..base]).then_some((*preset, begun))
    };
    let (preset, begun) = Preset::ALL.iter().find_map(begins)?;
    let mut words = Vec::new();
    if preset != Preset::default() {
        words.extend(["--model".to_owned(), preset.id().to_owned()]);
    }
    let mut built = begun;
    for place in places(model) {
        built = built.with_effect(place.effect, place.joints.as_deref().unwrap_or_default()).ok()?;
        words.extend(["--add".to_owned(), place.to_string()]);
    }
    (built == *model).then_some(words)
}

/// Its effects, those that follow each other on several joints in one.
fn places(model: &Model) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::new();
    for term in model.effects() {
        match (places.last_mut(), term.joint) {
            (Some(Place { effect, joints: Some(joints) }), Some(joint)) if *effect == term.effect => joints.push(joint),
            _ => places.push(Place { effect: term.effect, joints: term.joint.map(|joint| vec![joint]) }),
        }
    }
    places
}

/// The option that says a posture.
fn direction(zero: Posture) -> Option<&'static str> {
    let known = [("down", Posture::DOWN), ("right", Posture::RIGHT), ("up", Posture::UP)];
    known.into_iter().find(|(_, posture)| *posture == zero).map(|(name, _)| name)
}

/// A setting by its name, which is the same in files.
fn as_in_files(setting: &impl serde::Serialize) -> String {
    let name = serde_json::to_value(setting).ok();
    name.and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// A word as a shell needs it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=@,:+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}
