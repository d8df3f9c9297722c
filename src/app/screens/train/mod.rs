//! Train: which model, how its networks learn, and the curves while they do and after.

mod figures;

use std::sync::Arc;

use egui::{Align, Button, ComboBox, DragValue, Layout, RadioButton, RichText, Slider, Ui};

use crate::app::desk::{About, Busy, Desk, Needs, Order};
use crate::app::dock::{self, Part};
use crate::app::plot::{PanelView, ticks};
use crate::app::screen::{Screen, Switch};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets::thousands;
use crate::app::{glossary, tables, widgets};
use crate::figure::{Ink, Panel};
use crate::model::Preset;
use crate::model::learned::Features;
use crate::network::Activation;
use crate::progress::Epoch;
use crate::recording::Recording;
use crate::session::{Command, Session, Step};
use crate::training::fit::{self, Plan, SavedRun};
use crate::training::optimiser::Optimiser;
use crate::training::schedule::Schedule;
use crate::training::{Ending, Options, Precision, Recipe};

/// Height of the chart of the learning rate \[points\].
const RATE: f32 = 112.0;
/// Height of the chart of the loss \[points\].
const LOSS: f32 = 100.0;

/// From how many seeds a model is trained where one seed is not enough.
pub const SEEDS: u64 = 5;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "train",
    title: "Train",
    purpose: "Which model, and how its networks learn",
    needs: Needs::Recording,
    on_the_way: false,
};

const PANELS: Part<Train> = Part::Beside(&[
    (1.84, Part::Panel("Curves", Train::course)),
    (1.0, Part::Panel("Model and settings", Train::choices)),
]);

/// The screen of training: what to train and how, and which curves are drawn.
#[derive(Default, Clone)]
pub struct Train {
    preset: Preset,
    plan: Plan,
    /// The epoch whose values are shown.
    cursor: Option<f64>,
    /// Whether of several seeds only the current one is drawn.
    only_one: bool,
    /// How much of the smoothed curves is from earlier epochs, 0 for none.
    smoothing: f64,
}

impl Screen for Train {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        widgets::headline(ui, "Training", &summary(desk));
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let batches = |plan: &Plan| batches(desk.session, &plan.options);
        match epochs(desk) {
            Some((epochs, plan)) => {
                let [errors, loss] = self.errors(desk, epochs);
                vec![errors, loss, figures::rate(epochs, plan, batches(plan))]
            }
            None if is_learned(self.preset) => vec![figures::rate(&[], &self.plan, batches(&self.plan))],
            None => Vec::new(),
        }
    }

    fn switches<'a>(&'a mut self, _: &mut Desk) -> Vec<Switch<'a>> {
        vec![Switch::on("one-seed", &mut self.only_one)]
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(self.clone())
    }

    fn is_done(&self, session: &Session) -> bool {
        session.current().is_some_and(|step| !step.history.is_empty())
    }

    fn hear(&mut self, order: &Order) -> Vec<Order> {
        if let Order::PlanTraining(preset) = order {
            self.preset = *preset;
        }
        Vec::new()
    }

    /// The settings follow the session where that changed; what was only set here stays.
    fn follow(&mut self, before: &Session, after: &Session, _: Option<&Command>) {
        if before.preset != after.preset {
            self.preset = after.preset;
        }
        if before.plan != after.plan {
            self.plan = after.plan.clone();
        }
        self.cursor = None;
    }
}

/// One sentence: what the current model is.
fn summary(desk: &Desk) -> String {
    let Some(step) = desk.session.current() else { return "There is no model yet.".to_owned() };
    let errors: Vec<String> = step.evaluation.held_out_nmse().into_iter().map(ticks::percent).collect();
    let how = if step.fitted.model.is_learned() { "was trained" } else { "was solved for, not trained" };
    format!("The current model, {}, {how}. Held-out error by joint (nMSE): {}.", step.name, errors.join(" · "))
}

/// The epochs of the running training or else of the current model, and the plan; `None` if nothing was trained.
fn epochs<'a>(desk: &Desk<'a>) -> Option<(&'a [Epoch], &'a Plan)> {
    if let Some(Busy { epochs, plan: Some(plan), .. }) = desk.busy {
        return Some((epochs, plan));
    }
    let step = desk.session.current().filter(|step| !step.history.is_empty())?;
    Some((&step.history, step.run.as_ref().map_or(&desk.session.plan, |run| &run.plan)))
}

fn is_learned(preset: Preset) -> bool {
    matches!(preset, Preset::Learned(_))
}

impl Train {
    fn choices(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        self.start(ui, desk);
        self.models(ui, &recording);
        if is_learned(self.preset) {
            self.settings(ui);
        }
    }

    /// The running training, or the last one.
    fn course(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        if let Some(busy @ Busy { epochs, plan: Some(plan), .. }) = desk.busy {
            running(ui, desk, busy, epochs);
            let height = ui.available_height();
            return self.curves(ui, desk, epochs, plan, height);
        }
        match desk.session.current().cloned() {
            Some(step) if !step.history.is_empty() => {
                let table = 125.0 + 26.0 * recording.joint_count() as f32;
                let height = ui.available_height() - table;
                let plan = step.run.as_ref().map_or(&desk.session.plan, |run| &run.plan);
                self.curves(ui, desk, &step.history, plan, height);
                ui.columns(2, |columns| {
                    widgets::card(&mut columns[0], "How it ended", |ui| ending(ui, &step));
                    match self.seeds(desk) {
                        seeds if seeds.len() > 1 => tables::errors_of_seeds(&mut columns[1], &recording, &seeds),
                        _ => tables::errors(&mut columns[1], &recording, &step),
                    }
                });
            }
            _ if is_learned(self.preset) => self.plan_ahead(ui, desk),
            _ => {
                let sentence = "Networks learn what a rigid body can't know, but do not say what it is.\n\
                                Choose a model at the right and start: the curves appear here.";
                widgets::empty(ui, "Nothing was trained yet", sentence, "");
            }
        }
    }

    /// What a training by the chosen settings would do.
    fn plan_ahead(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let plan = self.plan.clone();
        let options = &plan.options;
        widgets::card(ui, "Nothing was trained yet: this is the plan", |ui| {
            if options.check().is_err() {
                widgets::weak(ui, "It can't be drawn with these settings.");
                return;
            }
            let steps = batches(desk.session, options);
            let text = format!(
                "{} epochs with about {} step{} of {} samples each. Start at the right: loss and held-out error appear above the \
                 schedule, and the present step is marked on it.",
                thousands_of(options.epochs),
                thousands_of(steps),
                if steps == 1 { "" } else { "s" },
                options.batch
            );
            widgets::weak(ui, text);
            let height = (ui.available_height() - 60.0).clamp(140.0, 260.0);
            self.rate_chart(ui, desk, &[], &plan, height);
        });
    }

    /// The learning rate: of the whole plan ahead, and of the epochs that are done, the last of which is marked.
    fn rate_chart(&mut self, ui: &mut Ui, desk: &mut Desk, done: &[Epoch], plan: &Plan, height: f32) {
        let panel = figures::rate(done, plan, batches(desk.session, &plan.options));
        let view = PanelView::new(panel).cursor(&mut self.cursor).height(height);
        view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
    }

    /// Loss, held-out error and learning rate over the epochs.
    fn curves(&mut self, ui: &mut Ui, desk: &mut Desk, epochs: &[Epoch], plan: &Plan, height: f32) {
        // Epochs are counted in whole numbers.
        self.cursor = self.cursor.map(f64::round);
        widgets::card(ui, "Loss and held-out error by epoch (logarithmic)", |ui| {
            if epochs.is_empty() {
                widgets::weak(ui, "No epoch is done yet.");
                return;
            }
            let [errors, loss] = self.errors(desk, epochs);
            let height = (height - RATE - LOSS - 128.0).clamp(150.0, 420.0);
            for (panel, height) in [(errors, height), (loss, LOSS)] {
                let view = PanelView::new(panel).cursor(&mut self.cursor).height(height);
                view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
            }
            self.rate_chart(ui, desk, epochs, plan, RATE);
            let text = "Loss: squared error over the variance of each joint's torque, summed over joints. Dot: the best epoch by \
                        the validation part, a tenth of the training runs; its weights are kept, and the held-out runs have no \
                        say in it. On the schedule: the present step.";
            ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
            ui.horizontal(|ui| {
                let seeds = self.seeds(desk).len();
                if desk.busy.is_none() && (seeds > 1 || self.only_one) {
                    ui.checkbox(&mut self.only_one, "This seed alone")
                        .on_hover_text("Its own curve in place of mean and band of all seeds");
                }
                if seeds > 1 {
                    return;
                }
                let label = ui.label("Smoothing");
                let slider = Slider::new(&mut self.smoothing, 0.0..=0.98).max_decimals(2);
                ui.add(slider).labelled_by(label.id).on_hover_text("Pale: as it was. 0: only as it was");
            });
        });
    }

    /// What is drawn over the epochs: one training, or mean and band of those that differ by their seed.
    fn errors(&self, desk: &Desk, epochs: &[Epoch]) -> [Panel; 2] {
        let (seeds, others) = (self.seeds(desk), Self::others(desk));
        match seeds.len() {
            0 | 1 => figures::errors(epochs, self.smoothing, &others),
            _ => figures::of_seeds(&seeds, &others),
        }
    }

    /// The trainings that differ from the current one by their seed, if they are drawn together.
    fn seeds(&self, desk: &Desk) -> Vec<Arc<Step>> {
        let is_running = desk.busy.is_some_and(|busy| busy.plan.is_some());
        let step = desk.session.current().filter(|_| !self.only_one && !is_running);
        step.map_or_else(Vec::new, |step| desk.session.seeds_of(step).into_iter().cloned().collect())
    }

    /// The other models whose training is drawn, with their inks.
    fn others(desk: &Desk) -> Vec<(Arc<Step>, Ink)> {
        let mut others = desk.overlaid();
        others.retain(|(step, _)| !step.history.is_empty());
        others
    }

    /// The choice of model.
    fn models(&mut self, ui: &mut Ui, recording: &Recording) {
        widgets::card(ui, "Model", |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for preset in Preset::ALL {
                let possible = preset != Preset::StatedArm || recording.states_arm();
                let chosen = self.preset == preset;
                let radio = ui.add_enabled(possible, RadioButton::new(chosen, preset.title()));
                let radio = glossary::radio(radio, preset);
                if radio.on_disabled_hover_text("The recording states no arm.").clicked() {
                    self.preset = preset;
                }
                let text = RichText::new(preset.description()).size(SMALL).color(Palette::in_ui(ui).weak);
                egui::Frame::new().inner_margin(egui::Margin { left: 22, bottom: 3, ..Default::default() }).show(
                    ui,
                    |ui| {
                        ui.label(text);
                    },
                );
            }
        });
    }

    fn settings(&mut self, ui: &mut Ui) {
        widgets::card(ui, "Settings", |ui| {
            let weak = Palette::in_ui(ui).weak;
            let plan = &mut self.plan;
            ui.horizontal(|ui| {
                ui.label("Recipe");
                for recipe in [Recipe::Ours, Recipe::Thorough, Recipe::Paper] {
                    if ui.radio(plan.recipe == recipe, tables::recipe_name(recipe)).clicked() && plan.recipe != recipe {
                        let seed = plan.options.seed;
                        *plan = Plan::of(recipe);
                        plan.options.seed = seed;
                    }
                }
            });
            let what = match plan.recipe {
                Recipe::Ours => "SOAP with a cosine schedule, quantities scaled to the data.",
                Recipe::Thorough => "Ours for five times as long.",
                Recipe::Paper => "Table 1: Adam at a constant rate, quantities as they are.",
            };
            ui.label(RichText::new(what).size(SMALL).color(weak));
            let options = &mut plan.options;
            egui::Grid::new("settings").spacing([18.0, 6.0]).show(ui, |ui| {
                let label = ui.label("Epochs");
                ui.add(DragValue::new(&mut options.epochs)).labelled_by(label.id);
                let label = ui.label("Batch");
                ui.add(DragValue::new(&mut options.batch)).labelled_by(label.id);
                ui.end_row();
                let label = ui.label("Learning rate");
                let speed = 0.02 * options.rate.abs().max(1e-6);
                let text = |value: f64, _| {
                    format!("{:.2e}", value).parse().map_or(String::new(), |short: f64| short.to_string())
                };
                ui.add(DragValue::new(&mut options.rate).speed(speed).custom_formatter(text)).labelled_by(label.id);
                let label = ui.label("Seed");
                ui.add(DragValue::new(&mut options.seed)).labelled_by(label.id);
                ui.end_row();
            });
            egui::CollapsingHeader::new("More settings").show(ui, |ui| more_settings(ui, plan));
        });
    }

    /// The buttons that begin, or why they can't.
    fn start(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let palette = Palette::in_ui(ui);
        let (preset, idle) = (self.preset, desk.busy.is_none());
        let current = desk.session.current().is_some_and(|step| step.fitted.model.is_learned() == is_learned(preset))
            && desk.session.preset == preset;
        widgets::card(ui, "", |ui| {
            let Preset::Learned(learned) = preset else {
                let what = "A rigid body is linear in its parameters: it is solved for at once, not trained.";
                widgets::weak(ui, what);
                if current {
                    widgets::weak(ui, "It is the current model.");
                } else if ui.add_enabled(idle, Button::new("Solve for it")).clicked() {
                    desk.run(Command::ChoosePreset(preset));
                }
                return;
            };
            let plan = Box::new(self.plan.clone());
            let problem = plan.options.check().err();
            ui.horizontal_wrapped(|ui| {
                let ready = idle && problem.is_none();
                let begin = match current {
                    // The effects that were added to it stay.
                    true => Command::Train { plan: plan.clone(), warm: false },
                    false => Command::TrainPreset { preset: learned, plan: plan.clone() },
                };
                let anew = ui.add_enabled(ready, Button::new("Start training"));
                if anew.on_hover_text("From new weights, drawn from the seed").clicked() {
                    desk.run(begin.clone());
                }
                let several = ui.add_enabled(ready, Button::new("Train five seeds"));
                let what = "Five times from other weights: how much of the error is chance. Mean and band are drawn";
                if several.on_hover_text(what).clicked() {
                    desk.run(Command::TrainSeeds { begin: Some(Box::new(begin)), seeds: SEEDS });
                }
                let on = ui.add_enabled(ready && current, Button::new("Train on"));
                let on = on.on_hover_text("From the weights of the current model");
                if on.on_disabled_hover_text("Once this model is trained, from its weights").clicked() {
                    desk.run(Command::Train { plan, warm: true });
                }
                if let Some(run) = desk.session.current().and_then(|step| stopped_run(step)).cloned() {
                    let resume = ui.add_enabled(idle, Button::new("Resume"));
                    if resume
                        .on_hover_text("Go on where it was stopped, with its settings, as if it had never been")
                        .clicked()
                    {
                        desk.run(Command::Resume(run));
                    }
                }
            });
            if let Some(problem) = problem {
                ui.label(RichText::new(format!("Can't start: {problem}.")).color(palette.error));
            }
        });
    }
}

/// Where the run stands, and how to end it.
fn running(ui: &mut Ui, desk: &mut Desk, busy: &Busy, epochs: &[Epoch]) {
    let palette = Palette::in_ui(ui);
    let title = match (busy.finishing, busy.paused) {
        (true, _) => "Ending with the best so far…",
        (_, true) => "Paused",
        _ => "Training…",
    };
    widgets::card(ui, title, |ui| {
        widgets::progress(ui, busy.progress.fraction, ui.available_width());
        ui.horizontal_wrapped(|ui| {
            let Some(last) = epochs.last() else {
                widgets::weak(ui, "The first epoch is on its way.");
                return;
            };
            let mut facts = vec![("epoch", format!("{} of {}", thousands_of(last.epoch), thousands_of(last.epochs)))];
            facts.push(("loss", ticks::number(last.loss)));
            facts.extend(last.held_out.map(|error| ("held-out nMSE", ticks::number(error))));
            facts.push(("learning rate", ticks::number(last.rate)));
            facts.push(("samples/s", thousands_of(last.samples_per_s as u64)));
            facts.push(("left", duration(last.remaining_s)));
            for (name, value) in facts {
                ui.label(RichText::new(name).size(SMALL).color(palette.weak));
                ui.label(RichText::new(value).color(palette.text));
                ui.add_space(GAP);
            }
        });
        ui.add_space(2.0);
        ui.horizontal(|ui| {
            let (word, what) = if busy.paused { ("Go on", "Train on") } else { ("Pause", "Wait; the cores are free") };
            if ui.add_enabled(!busy.finishing, Button::new(word)).on_hover_text(what).clicked() {
                desk.orders.push(Order::Pause(!busy.paused));
            }
            let keep = ui.add_enabled(!epochs.is_empty() && !busy.finishing, Button::new("Stop and keep the best"));
            if keep.on_hover_text("End now; the weights of the lowest error become the model").clicked() {
                desk.orders.push(Order::Finish);
            }
            if ui.button("Throw away").on_hover_text("Stop this; nothing is changed (Esc)").clicked() {
                desk.orders.push(Order::Stop);
            }
        });
    });
}

/// About how often the weights change in an epoch.
fn batches(session: &Session, options: &Options) -> u64 {
    (fit::about_learned(&session.split) / options.batch.max(1)).max(1) as u64
}

fn ending(ui: &mut Ui, step: &Step) {
    let (Some(last), Some(best)) = (step.history.last(), figures::best(&step.history)) else { return };
    let (done, all) = (thousands_of(last.epoch), thousands_of(last.epochs));
    let how = match &step.ending {
        Some(Ending::Stopped(reason)) => format!("Stopped after {done} of {all} epochs, because {reason}."),
        Some(Ending::GoalReached) => {
            format!("The validation error is as low as asked for after {done} of {all} epochs.")
        }
        Some(Ending::Failed(reason)) => format!("Ended after {done} of {all} epochs: {reason}."),
        Some(Ending::Finished) | None => format!("All {all} epochs are done."),
    };
    let error = match (best.validation, best.held_out) {
        (Some(error), _) => format!("validation nMSE {}", ticks::percent(error)),
        (None, Some(error)) => format!("held-out nMSE {}", ticks::percent(error)),
        (None, None) => format!("loss {}; nothing is held out", ticks::number(best.loss)),
    };
    let kept = format!("The best was epoch {}: {error}. Its weights are the model.", thousands_of(best.epoch));
    let starts = step.run.as_ref().and_then(|run| run.starts_text()).unwrap_or_default();
    let speed = format!("{} at {} samples/s", duration(last.elapsed_s), thousands_of(last.samples_per_s as u64));
    // Columns justify their text, which tears a short one apart.
    ui.with_layout(Layout::top_down(Align::Min), |ui| ui.label(format!("{how} {kept} {starts}")).on_hover_text(speed));
}

/// Networks, optimiser and numbers.
fn more_settings(ui: &mut Ui, plan: &mut Plan) {
    fn choice<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, choices: &[(T, &str)]) {
        ui.label(name);
        // Settings of an optimiser or schedule that came from elsewhere stay until another one is chosen.
        let text = choices.iter().find(|(choice, _)| choice == value).map_or("as given", |(_, text)| text);
        let combo = ComboBox::from_id_salt(name).width(96.0).selected_text(text).show_ui(ui, |ui| {
            for (choice, text) in choices {
                ui.selectable_value(value, *choice, *text);
            }
        });
        let text = text.to_owned();
        combo.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, format!("{name}: {text}")));
    }
    egui::Grid::new("more settings").spacing([18.0, 6.0]).show(ui, |ui| {
        let hidden = &mut plan.layers.hidden;
        let (mut depth, mut width) = (hidden.len(), hidden.first().copied().unwrap_or(64));
        let label = ui.label("Hidden layers");
        let deeper = ui.add(DragValue::new(&mut depth).range(0..=6)).labelled_by(label.id).changed();
        let label = ui.label("Neurons of each");
        let wider = ui.add(DragValue::new(&mut width).range(1..=512)).labelled_by(label.id).changed();
        if deeper || wider {
            *hidden = vec![width; depth];
        }
        ui.end_row();
        let activations = [
            (Activation::Tanh, "tanh"),
            (Activation::Sigmoid, "sigmoid"),
            (Activation::Softplus, "softplus"),
            (Activation::Silu, "SiLU"),
        ];
        choice(ui, "Activation", &mut plan.layers.activation, &activations);
        choice(
            ui,
            "Angles as",
            &mut plan.features,
            &[
                (None, "suits the arm"),
                (Some(Features::CosSin), "cos, sin"),
                (Some(Features::LinkAngles), "links"),
                (Some(Features::Raw), "q"),
            ],
        );
        ui.end_row();
        choice(
            ui,
            "Optimiser",
            &mut plan.options.optimiser,
            &[(Optimiser::SOAP, "SOAP"), (Optimiser::ADAM_W, "AdamW")],
        );
        let schedules =
            [(Schedule::Constant, "constant"), (Schedule::COSINE, "cosine"), (Schedule::ONE_CYCLE, "one cycle")];
        choice(ui, "Schedule", &mut plan.options.schedule, &schedules);
        ui.end_row();
        choice(ui, "Precision", &mut plan.precision, &[(Precision::F32, "single"), (Precision::F64, "double")]);
        choice(ui, "Quantities", &mut plan.normalise, &[(true, "scaled to data"), (false, "as they are")]);
        ui.end_row();
        choice(ui, "Mass matrix", &mut plan.cholesky, &[(true, "positive"), (false, "any")]);
        ui.end_row();
    });
}

/// The training of a model, if somebody stopped it.
fn stopped_run(step: &Step) -> Option<&Arc<SavedRun>> {
    matches!(step.ending, Some(Ending::Stopped(_))).then_some(step.run.as_ref()).flatten()
}

fn thousands_of(number: u64) -> String {
    thousands(usize::try_from(number).unwrap_or(usize::MAX))
}

/// `12 s`, `3 min 5 s`.
fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "—".to_owned();
    }
    let whole = seconds.max(0.0).round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
