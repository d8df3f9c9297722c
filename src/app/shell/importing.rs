//! The import assistant: what each column of a log is taken for and why, how it looks then, and all of it to be changed.

use std::path::{Path, PathBuf};

use egui::{Align, Button, ComboBox, DragValue, Label, Layout, RichText, ScrollArea, TextEdit, Ui, WidgetInfo, vec2};

use super::filter::Filter;
use super::frame::Shell;
use super::hanging::hanging;
use super::law::Law;
use super::primary::primary;
use super::topics::Topics;
use crate::app::desk::{Order, Templates};
use crate::app::facts;
use crate::app::plot::PanelView;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;
use crate::figure::mark::Line;
use crate::figure::{Axis, Ink, Panel};
use crate::file;
use crate::progress::Monitor;
use crate::recording::catalogue;
use crate::recording::drive::DriveError;
use crate::recording::encoders::Side;
use crate::recording::hold_out::HoldOut;
use crate::recording::mapping::{Channel, Draft, Mapping, MappingError, MappingSpec, Role};
use crate::recording::read::{self, Preview, ReadOptions, preview};
use crate::recording::torque::TorqueFacts;
use crate::session::Command;
use crate::work::{Job, Outcome};

/// Widths of the columns of the table: name, values, quantity, joint, unit, sign \[points\].
const WIDTHS: [f32; 6] = [130.0, 160.0, 118.0, 44.0, 84.0, 26.0];
/// Height of a row, and of all that are seen \[points\].
const ROW: f32 = 28.0;
const TABLE: f32 = 250.0;
/// What stands above and below what can be scrolled \[points\].
const AROUND: f32 = 290.0;
/// Points of the plot of a column.
const POINTS: usize = 600;

/// The assistant, while it is open on a log.
pub struct Importing {
    /// The logs of one arm, whose columns have the same names.
    paths: Vec<PathBuf>,
    /// Whether they hold channels of the same samples, and not one run each.
    side_by_side: bool,
    /// How the log was to be read; what it says of columns is made anew.
    options: ReadOptions,
    /// What the torque is.
    torque: TorqueFacts,
    /// On which side of the gears the encoders are.
    encoders: Option<Side>,
    /// How the torque follows from a command, as it is typed.
    law: Law,
    /// The filter of what is derived.
    filter: Filter,
    job: Option<Job<Preview>>,
    log: Option<Result<Log, String>>,
    /// The topics of a log of messages, as they were seen last.
    topics: Topics,
    /// The file for the template, as it is typed.
    template: String,
    /// The template that was there for a log like this one when it was looked into.
    offered: Option<PathBuf>,
    /// The mappings that come with the program and have all that they need here: name, what it is for, and itself.
    ready: Vec<(&'static str, &'static str, MappingSpec)>,
    /// What is wrong with the template that was offered.
    problem: Option<String>,
}

/// The log as it is, and what is made of it.
struct Log {
    preview: Preview,
    draft: Draft,
    /// The column that is plotted.
    shown: usize,
    /// The mapping that the draft made when it was last asked, and that draft.
    made: Option<(Draft, Result<MappingSpec, MappingError>)>,
}

impl Log {
    /// The mapping that the draft makes.
    fn spec(&mut self) -> &Result<MappingSpec, MappingError> {
        let draft = &self.draft;
        if self.made.as_ref().is_some_and(|(of, _)| of != draft) {
            self.made = None;
        }
        let (_, spec) = self.made.get_or_insert_with(|| (draft.clone(), draft.spec()));
        spec
    }
}

impl Importing {
    /// Looks into logs.
    pub fn new(paths: Vec<PathBuf>, options: ReadOptions, ctx: &egui::Context) -> Self {
        Importing::of(paths, false, options, ctx)
    }

    /// Looks into the first of several runs, or into all channels of one.
    fn of(paths: Vec<PathBuf>, side_by_side: bool, options: ReadOptions, ctx: &egui::Context) -> Self {
        let path = if side_by_side { read::side_by_side(&paths) } else { paths.first().cloned().unwrap_or_default() };
        let (context, file, reading) = (ctx.clone(), path.clone(), options.clone());
        let wake = move || context.request_repaint();
        let look = move |monitor: &Monitor| preview(&file, &reading, monitor).map_err(|error| error.to_string());
        // What comes with the program has no folder.
        let beside = if path.exists() {
            path.with_extension("toml")
        } else {
            PathBuf::from(shown(&path)).with_extension("toml")
        };
        let template = beside.display().to_string();
        Importing {
            torque: options.stated_torque().cloned().unwrap_or_default(),
            encoders: options.stated_encoders(),
            law: Law::default(),
            filter: Filter::new(options.mapping.as_ref().and_then(|mapping| mapping.low_pass_hz)),
            job: Some(Job::spawn("look into the log", wake, look)),
            paths,
            side_by_side,
            options,
            log: None,
            topics: Topics::default(),
            template,
            offered: None,
            ready: Vec::new(),
            problem: None,
        }
    }

    /// Looks into the log again for columns of other topics; what was said of the rest stays.
    fn of_topics(&mut self, asked: Vec<String>, ctx: &egui::Context) {
        let options = self.options.clone().on_topics(asked.clone());
        let fresh = Importing::of(self.paths.clone(), self.side_by_side, options, ctx);
        let topics = std::mem::take(&mut self.topics).taking(asked);
        let (torque, template) = (self.torque.clone(), std::mem::take(&mut self.template));
        *self = Importing { torque, encoders: self.encoders, topics, template, ..fresh };
    }

    /// Whether the file is being read.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// The names of all columns, once they are known.
    fn columns(&self) -> impl Iterator<Item = &str> + Clone {
        let draft = self.log.iter().flatten().map(|log| &log.draft);
        draft.flat_map(|draft| draft.columns.iter().map(|role| role.name.as_str()))
    }

    /// Receives what was read, and the template that was saved for its like.
    fn poll(&mut self, templates: &Templates) {
        let Some(outcome) = self.job.as_mut().and_then(Job::poll) else { return };
        self.job = None;
        self.log = Some(match outcome {
            Outcome::Done(preview) => {
                let mut draft = Draft::guess(&preview.names());
                let stated = self.options.mapping.as_ref();
                let found = stated.and_then(|mapping| Mapping::find(&preview.names(), mapping).ok());
                if let (Some(drive), Some(found)) = (stated.and_then(|mapping| mapping.drive.clone()), found) {
                    draft.state_command(drive, &found.tau);
                }
                self.law = Law::of(draft.drive.as_ref());
                self.topics = Topics::of(&preview);
                let shown = first_torque(&draft).unwrap_or(0);
                Ok(Log { preview, draft, shown, made: None })
            }
            Outcome::Failed(reason) | Outcome::Stopped(reason) | Outcome::Panicked(reason) => Err(reason),
        });
        self.offered = templates.of(self.columns()).map(Path::to_owned);
        let columns: Vec<String> = self.columns().map(str::to_owned).collect();
        self.ready = catalogue::fitting(&columns);
    }

    /// What is opened: each log a run, or all one.
    fn opened(&self) -> Vec<PathBuf> {
        if self.side_by_side { vec![read::side_by_side(&self.paths)] } else { self.paths.clone() }
    }

    /// What opens the logs by a mapping that says what the torque is, too.
    pub fn opening(&self, spec: MappingSpec) -> Command {
        Command::open(self.opened(), self.options.clone().by(spec), HoldOut::default())
    }
}

/// The assistant, while it is open.
pub fn show(ui: &mut Ui, shell: &mut Shell, place: &mut Option<Importing>) {
    let Some(mut open) = place.take() else { return };
    open.poll(shell.desk.templates);
    let mut is_over = false;
    let room = ui.ctx().content_rect();
    let modal = hanging("importing").show(ui.ctx(), |ui| {
        ui.set_width((room.width() - 80.0).min(940.0));
        ui.heading("What is in this log?");
        which(ui, &mut open);
        ui.add_space(GAP);
        let top = ui.cursor().top();
        if let Some(asked) = open.topics.ask(ui) {
            open.of_topics(asked, ui.ctx());
        }
        is_over = offer(ui, shell, &mut open);
        let height = (room.height() - AROUND - (ui.cursor().top() - top)).max(80.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(80.0).show(ui, |ui| match &mut open.log {
            None => drop(widgets::weak(ui, "It is being read…")),
            Some(Err(reason)) => drop(ui.label(RichText::new(&*reason).color(Palette::in_ui(ui).error))),
            Some(Ok(log)) => {
                table(ui, log);
                rate(ui, log);
                ui.label("What is the torque?");
                if open.law.ask(ui, &mut log.draft) {
                    log.shown = first_torque(&log.draft).unwrap_or(log.shown);
                }
                facts::choose(ui, &mut open.torque);
                facts::choose_encoders(ui, &mut open.encoders);
                plot(ui, shell, log);
                open.filter.ask(ui, shell, &log.draft, &log.preview, log.shown);
            }
        });
        ui.add_space(GAP);
        is_over |= choose(ui, shell, &mut open);
    });
    if !is_over && !modal.should_close() {
        *place = Some(open);
    }
}

/// Which logs these are, and whether several are runs or channels of one.
fn which(ui: &mut Ui, open: &mut Importing) {
    let names: Vec<String> = open.paths.iter().map(|path| path.display().to_string()).collect();
    ui.add(Label::new(RichText::new(names.join("\n")).size(SMALL).color(Palette::in_ui(ui).weak)));
    if open.paths.len() < 2 {
        return;
    }
    let mut side_by_side = open.side_by_side;
    ui.horizontal_wrapped(|ui| {
        ui.label("Each file is");
        ui.radio_value(&mut side_by_side, false, "a run of the arm").on_hover_text("Their columns have the same names");
        let what = "Such as angles in one file and currents in the other, of the same samples";
        ui.radio_value(&mut side_by_side, true, "a part of the channels").on_hover_text(what);
    });
    if side_by_side != open.side_by_side {
        *open = Importing::of(open.paths.clone(), side_by_side, open.options.clone(), ui.ctx());
    }
}

/// A row for each column of the log; where there is no room for all that is in a row it can be scrolled.
fn table(ui: &mut Ui, log: &mut Log) {
    let Log { preview, draft, shown, .. } = log;
    let (mut chosen, torque) = (None, torque_of(draft));
    ScrollArea::horizontal().id_salt("rows").show(ui, |ui| {
        titles(ui);
        let rows = ScrollArea::vertical().id_salt("columns").max_height(TABLE);
        rows.show_rows(ui, ROW, draft.columns.len(), |ui, rows| {
            for number in rows {
                let (role, values) = (&mut draft.columns[number], &preview.columns[number].values);
                let asked = ui.push_id(number, |ui| column(ui, role, values, number, shown, torque)).inner;
                chosen = chosen.or(asked.map(|channel| (number, channel)));
            }
        });
    });
    if let Some((number, channel)) = chosen {
        draft.take_for(number, channel);
        *shown = number;
    }
}

fn titles(ui: &mut Ui) {
    let title =
        |ui: &mut Ui, text: &str| drop(ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak)));
    row(ui, |ui, cell| {
        for (width, text) in WIDTHS.into_iter().zip(["column", "first values", "quantity", "joint", "unit", "−"]) {
            cell(ui, width, &mut |ui| title(ui, text));
        }
        title(ui, "why");
    });
}

/// What draws a cell of some width.
type Cell<'a> = &'a dyn Fn(&mut Ui, f32, &mut dyn FnMut(&mut Ui));

fn row(ui: &mut Ui, content: impl FnOnce(&mut Ui, Cell)) {
    let cell = |ui: &mut Ui, width: f32, draw: &mut dyn FnMut(&mut Ui)| {
        ui.allocate_ui_with_layout(vec2(width, ROW), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(width);
            draw(ui);
        });
    };
    ui.horizontal(|ui| {
        ui.set_min_height(ROW);
        content(ui, &cell);
    });
}

/// One of them; what it is to be taken for, if that was chosen.
fn column(
    ui: &mut Ui,
    role: &mut Role,
    values: &[f64],
    number: usize,
    shown: &mut usize,
    torque: &'static str,
) -> Option<Option<Channel>> {
    let (before, mut chosen) = (role.clone(), None);
    let name = role.name.clone();
    row(ui, |ui, cell| {
        let [of_name, of_values, of_quantity, of_joint, of_unit, of_sign] = WIDTHS;
        cell(ui, of_name, &mut |ui| {
            let chosen = ui.add(Button::selectable(*shown == number, role.name.as_str()).truncate());
            if chosen.on_hover_text("Plot it").clicked() {
                *shown = number;
            }
        });
        cell(ui, of_values, &mut |ui| {
            let first: Vec<String> = values.iter().take(3).map(|value| short(*value)).collect();
            let text = RichText::new(first.join("  ")).size(SMALL).color(Palette::in_ui(ui).weak);
            ui.add(Label::new(text).truncate());
        });
        cell(ui, of_quantity, &mut |ui| chosen = quantity(ui, role, torque));
        let is_of_joint = role.of_joint().is_some();
        cell(ui, of_joint, &mut |ui| {
            if is_of_joint {
                let mut from_one = role.joint + 1;
                let field = ui.add(DragValue::new(&mut from_one).range(1..=99));
                field.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, format!("joint of {name}")));
                role.joint = from_one - 1;
            }
        });
        cell(ui, of_unit, &mut |ui| {
            if is_of_joint {
                unit(ui, role);
            }
        });
        cell(ui, of_sign, &mut |ui| {
            if is_of_joint {
                let check = ui.checkbox(&mut role.turned, "");
                let spoken = format!("turn the sign of {name}");
                check.widget_info(|| WidgetInfo::selected(egui::Role::CheckBox, true, role.turned, &spoken));
                check.on_hover_text("The other sign");
            }
        });
        ui.add(Label::new(RichText::new(&role.why).size(SMALL).color(Palette::in_ui(ui).weak)).extend());
    });
    if *role != before {
        *shown = number;
    }
    chosen
}

/// The first column that is taken for torque, or its command.
fn first_torque(draft: &Draft) -> Option<usize> {
    draft.columns.iter().position(|role| role.channel == Some(Channel::Torque))
}

/// What columns hold that are taken for torque.
fn torque_of(draft: &Draft) -> &'static str {
    draft.drive.as_ref().map_or(Channel::Torque.title(), |_| "command")
}

fn quantity(ui: &mut Ui, role: &Role, torque: &'static str) -> Option<Option<Channel>> {
    let mut chosen = None;
    let title = |channel: Option<Channel>| match channel {
        Some(Channel::Torque) => torque,
        channel => channel.map_or("not used", Channel::title),
    };
    let chooser = ComboBox::from_id_salt("quantity").width(100.0).selected_text(title(role.channel));
    let chooser = chooser.show_ui(ui, |ui| {
        for channel in std::iter::once(None).chain(Channel::ALL.map(Some)) {
            if ui.selectable_label(role.channel == channel, title(channel)).clicked() && role.channel != channel {
                chosen = Some(channel);
            }
        }
    });
    let spoken = format!("quantity of {}", role.name);
    chooser.response.widget_info(|| WidgetInfo::labeled(egui::Role::ComboBox, true, &spoken));
    chosen
}

fn unit(ui: &mut Ui, role: &mut Role) {
    let units = role.units();
    let chooser = ComboBox::from_id_salt("unit").width(66.0).selected_text(role.unit);
    let chooser = chooser.show_ui(ui, |ui| {
        for unit in units {
            ui.selectable_value(&mut role.unit, unit, *unit);
        }
    });
    let spoken = format!("unit of {}", role.name);
    chooser.response.widget_info(|| WidgetInfo::labeled(egui::Role::ComboBox, true, &spoken));
}

/// A log without a clock needs a rate, unless its velocity tells it.
fn rate(ui: &mut Ui, log: &mut Log) {
    if log.draft.columns.iter().any(|role| role.channel == Some(Channel::Time)) {
        log.draft.rate_hz = None;
        return;
    }
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("No column is a clock. Sampling rate [Hz]");
        let mut rate = log.draft.rate_hz.unwrap_or(0.0);
        ui.add(DragValue::new(&mut rate).range(0.0..=1e6).speed(1.0)).labelled_by(label.id);
        log.draft.rate_hz = (rate > 0.0).then_some(rate);
        widgets::weak(ui, "0: it follows from position and velocity, if both are there");
    });
}

/// The column that was touched last, as it is taken.
fn plot(ui: &mut Ui, shell: &mut Shell, log: &Log) {
    let Some((role, seen)) = log.draft.columns.get(log.shown).zip(log.preview.columns.get(log.shown)) else { return };
    let factor = role.to_si();
    let step = (seen.values.len() / POINTS).max(1);
    let points = seen.values.iter().enumerate().step_by(step).map(|(sample, value)| [sample as f64, factor * value]);
    let quantity = match role.channel {
        Some(Channel::Time) => "time".to_owned(),
        Some(Channel::Torque) => format!("{} of joint {}", torque_of(&log.draft), role.joint + 1),
        Some(channel) => format!("{} of joint {}", channel.title(), role.joint + 1),
        None => "not used".to_owned(),
    };
    let unit = role.units().first().copied().unwrap_or_default();
    let axes = [Axis::new("sample", ""), Axis::new(quantity.as_str(), unit)];
    let panel = Panel::new(format!("{}: {quantity}", role.name), axes);
    let panel =
        panel.with(Line::through(role.name.clone(), points.filter(|point| point[1].is_finite()), Ink::Measured));
    PanelView::new(panel).height(150.0).show(ui, &mut shell.desk.focus.views, &mut shell.desk.memo.decimator);
}

/// The template that was saved for a log like this one, and mappings that come with the program; whether the log is opened by one.
fn offer(ui: &mut Ui, shell: &mut Shell, open: &mut Importing) -> bool {
    let mut is_over = of_the_program(ui, shell, open);
    let Some(template) = open.offered.clone() else { return is_over };
    ui.horizontal_wrapped(|ui| {
        widgets::weak(ui, "A template was saved for logs with these columns.");
        let button =
            ui.add_enabled(shell.desk.busy.is_none(), Button::new(format!("Open it as in {}", shown(&template))));
        if button.on_hover_text(template.display().to_string()).clicked() {
            let text = file::read_text(&template).map_err(|error| error.to_string());
            match text.and_then(|text| MappingSpec::from_toml(&text).map_err(|error| error.to_string())) {
                Ok(spec) => {
                    shell.desk.run(open.opening(spec));
                    is_over = true;
                }
                Err(problem) => open.problem = Some(format!("{} can't be used: {problem}", template.display())),
            }
        }
        if let Some(problem) = &open.problem {
            ui.label(RichText::new(problem).color(Palette::in_ui(ui).error));
        }
    });
    is_over
}

/// The mappings of the program that fit; whether the log is opened by one.
fn of_the_program(ui: &mut Ui, shell: &mut Shell, open: &Importing) -> bool {
    if open.ready.is_empty() {
        return false;
    }
    let mut is_over = false;
    ui.horizontal_wrapped(|ui| {
        widgets::weak(ui, "A mapping that comes with the program fits these columns.");
        for (name, what, spec) in &open.ready {
            let button = ui.add_enabled(shell.desk.busy.is_none(), Button::new(format!("Open it as {name}")));
            if button.on_hover_text(*what).clicked() {
                shell.desk.run(open.opening(spec.clone()));
                is_over = true;
            }
        }
    });
    is_over
}

/// What is to be done with it; whether the assistant is done.
fn choose(ui: &mut Ui, shell: &mut Shell, open: &mut Importing) -> bool {
    let spec = match &mut open.log {
        Some(Ok(log)) => Some(log.spec().clone().map(|spec| completed(spec, open))),
        _ => None,
    };
    match &spec {
        Some(Ok(_)) => drop(widgets::weak(
            ui,
            "Position and torque of every joint are there. What is not there is derived, and said.",
        )),
        Some(Err(problem)) => drop(ui.label(RichText::new(in_short(problem)).color(Palette::in_ui(ui).warning))),
        None => {}
    }
    let spec = spec.and_then(Result::ok);
    let label = ui.label("Template for logs like this one");
    ui.add(TextEdit::singleline(&mut open.template).desired_width(f32::INFINITY)).labelled_by(label.id);
    if let Some(text) = shell.filed.would_overwrite(open.template.trim().as_ref()) {
        let text = format!("{text} What it is now stays beside it as .bak.");
        ui.label(RichText::new(text).color(Palette::in_ui(ui).warning));
    }
    ui.add_space(GAP);
    let mut is_over = false;
    ui.horizontal_wrapped(|ui| {
        let can_open = spec.is_some() && shell.desk.busy.is_none();
        if let (true, Some(spec)) = (primary(ui, can_open, "Open it so").clicked(), &spec) {
            shell.desk.run(open.opening(spec.clone()));
            is_over = true;
        }
        let path = PathBuf::from(open.template.trim());
        let text = spec.as_ref().and_then(|spec| spec.to_toml().ok());
        let save = ui.add_enabled(text.is_some() && !open.template.trim().is_empty(), Button::new("Save as template"));
        let what = format!(
            "The command line takes it: torquescope {} --map {}",
            open.opened().iter().map(|log| shown(log)).collect::<Vec<_>>().join(" "),
            shown(&path)
        );
        if let Some(text) = text.filter(|_| save.on_hover_text(what).clicked()) {
            let columns = open.columns().map(str::to_owned).collect();
            shell.desk.orders.push(Order::SaveTemplate { path, text, columns });
        }
        is_over |= ui.button("Cancel").clicked();
    });
    is_over
}

/// With what is said of the torque and the encoders, and what was said before of the arm and the like.
fn completed(spec: MappingSpec, open: &Importing) -> MappingSpec {
    let before = open.options.mapping.clone().unwrap_or_default();
    let low_pass_hz = open.filter.cutoff_hz();
    let gaussian_samples = before.gaussian_samples.filter(|_| low_pass_hz.is_none());
    let kind = before.kind.or(spec.kind);
    let chain = before.chain;
    let read = open.log.iter().flatten().next();
    let topic = read.and_then(|log| log.preview.stated_topics()).or(before.topic);
    let (torque, encoders) = (open.torque.clone(), open.encoders);
    MappingSpec { low_pass_hz, gaussian_samples, kind, chain, topic, torque, encoders, ..spec }
}

/// What is wrong, without the list of all columns, which stand above.
fn in_short(problem: &MappingError) -> String {
    match problem {
        MappingError::Missing { channel, .. } => format!("No column is taken for {}.", channel.title()),
        MappingError::Drive(DriveError::Value { name, value, .. }) if value.is_nan() => {
            format!("Say {name} of the drive: one number, or one a joint.")
        }
        other => format!("{}.", widgets::sentence_case(&other.to_string())),
    }
}

fn shown(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn short(value: f64) -> String {
    if value.is_finite() { format!("{value:.4}") } else { "–".to_owned() }
}
