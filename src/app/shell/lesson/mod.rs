//! The lesson beside the screens: what is read and asked, and what it was worth. Nothing is judged here: every click is an
//! [`Act`], and the lesson's journal in the session is what is shown.

mod answer;
mod arm;
mod list;

use std::sync::Arc;

use egui::{Align, Button, Frame, Layout, Margin, Panel, ProgressBar, RichText, ScrollArea, Stroke, Ui, WidgetInfo};

use super::frame::Shell;
use crate::app::desk::{About, Desk, Order};
use crate::app::screens;
use crate::app::theme::{GAP, HEADLINE, Palette, SMALL, TITLE};
use crate::app::{math, widgets};
use crate::lesson::grade::{Grade, grade};
use crate::lesson::{Act, Course, Lesson, Progress, Stage, Step, Task};
use crate::session::study::{Pose, Study};
use crate::session::{Generation, Session};

pub use list::list;

/// Width of the lesson \[points\].
const WIDTH: f32 = 350.0;
/// The least that is left for the screen \[points\].
const LEFT_FOR_SCREEN: f32 = 420.0;

/// What is remembered of a lesson from frame to frame.
#[derive(Default)]
pub struct LessonPanel {
    /// Whether it is out of the way.
    pub hidden: bool,
    /// The list of all lessons, while it is open.
    pub choosing: Option<list::Choosing>,
    /// What lacked when an answer was tried last.
    pub lacks: Option<String>,
    /// The lesson as it was read last, by what it was read from.
    read: Option<(Arc<Study>, Lesson)>,
    /// What it was worth, of which session.
    worth: Option<(Generation, Grade)>,
    entered: Entered,
}

/// What was entered in a step so far.
#[derive(Default)]
struct Entered {
    choice: Option<String>,
    /// How sure one is \[%\].
    sure: f64,
    number: String,
    /// The state of the arm, which goes from step to step.
    pose: Pose,
    /// What was told of it in the last frame.
    seen: Option<(Progress, bool, Option<String>)>,
}

impl LessonPanel {
    /// The session has changed: another step begins with nothing entered, on the screen that it is about.
    pub fn follow(&mut self, before: &Session, after: &Session) -> Option<&'static About> {
        let step = |session: &Session| {
            let journal = session.study.as_ref().map(|study| study.journal());
            journal.and_then(|journal| journal.last()).map(|entry| entry.note.step.clone())
        };
        let is_same = match (&before.study, &after.study) {
            (Some(one), Some(other)) => one.is_same_course(other),
            (one, other) => one.is_none() && other.is_none(),
        };
        if !is_same {
            *self = LessonPanel { read: self.read.take(), ..LessonPanel::default() };
        }
        if is_same && step(before) == step(after) {
            return None;
        }
        self.lacks = None;
        self.entered = Entered { pose: std::mem::take(&mut self.entered.pose), ..Entered::default() };
        let lesson = self.lesson(after)?;
        let screen = lesson.step(&step(after)?)?.screen.as_ref()?;
        screens::find(screen.get_ref()).ok()
    }

    /// The lesson of a session, read once.
    fn lesson(&mut self, session: &Session) -> Option<&Lesson> {
        let study = session.study.as_ref()?;
        if self.read.as_ref().is_none_or(|(known, _)| known.source != study.source) {
            self.read = Some((Arc::clone(study), Lesson::read(&study.source).ok()?));
        }
        self.read.as_ref().map(|(_, lesson)| lesson)
    }
}

/// The lesson at the right side, while one is taken and it is not hidden.
pub fn show(ui: &mut Ui, shell: &mut Shell, panel: &mut LessonPanel) {
    let session = shell.desk.session;
    if panel.hidden || session.study.is_none() {
        return;
    }
    let palette = Palette::in_ui(ui);
    let width = WIDTH.min(ui.available_width() - LEFT_FOR_SCREEN).max(240.0);
    let frame = Frame::new().fill(palette.card).inner_margin(Margin::symmetric(14, 10));
    Panel::right("lesson").frame(frame).resizable(false).exact_size(width).show(ui, |ui| {
        let Some(lesson) = panel.lesson(session).cloned() else {
            widgets::weak(ui, "The lesson of this session can't be read.");
            return;
        };
        let Some(study) = &session.study else { return };
        let course = Course::of(&lesson, study);
        header(ui, &lesson, &course, study.seed, panel);
        Panel::bottom("lesson's way on").frame(Frame::new()).resizable(false).show(ui, |ui| {
            way_on(ui, &mut shell.desk, &lesson, &course);
        });
        ScrollArea::vertical().id_salt(("lesson", course.place)).auto_shrink(false).show(ui, |ui| {
            step(ui, &mut shell.desk, panel, &lesson, &course);
        });
    });
}

fn header(ui: &mut Ui, lesson: &Lesson, course: &Course, seed: u64, panel: &mut LessonPanel) {
    let palette = Palette::in_ui(ui);
    ui.horizontal(|ui| {
        let title = format!("Lesson {}: {}", lesson.number, lesson.title);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let hide = ui.add(Button::new("×").small()).on_hover_text("Hide it; Lessons brings it back");
            hide.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, "Hide the lesson"));
            panel.hidden |= hide.clicked();
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(title).size(TITLE).color(palette.text)).wrap());
            });
        });
    });
    let count = lesson.steps.len();
    let done = course.place + usize::from(course.is_finished(lesson));
    let share = done as f32 / count as f32;
    ui.add(ProgressBar::new(share).desired_height(4.0).fill(palette.accent));
    let text = format!("Step {} of {count} · seed {seed}", course.place + 1);
    ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    ui.add_space(GAP);
}

fn step(ui: &mut Ui, desk: &mut Desk, panel: &mut LessonPanel, lesson: &Lesson, course: &Course) {
    let (step, progress) = (&lesson.steps[course.place], course.here());
    let palette = Palette::in_ui(ui);
    widgets::chip(ui, stage_text(step.stage), palette.accent);
    ui.label(RichText::new(&step.text.title).size(HEADLINE - 2.0).color(palette.text));
    ui.add_space(4.0);
    paragraphs(ui, &step.text.text);
    if step.arm {
        arm::show(ui, desk.session, &mut panel.entered.pose);
    }
    if !step.text.ask.is_empty() {
        ui.label(RichText::new(&step.text.ask).strong());
        ui.add_space(2.0);
    }
    answer::show(ui, desk, &mut panel.entered, step, progress);
    offers(ui, desk, step);
    answer::outcome(ui, desk.session, panel.lacks.as_deref(), step, progress);
    if let Task::Reveal(of) = &step.task {
        answer::revealed(ui, desk, lesson, course, of);
    }
    // What became of an answer is not to be looked for below.
    let seen = (progress.clone(), course.may_go_on(lesson), panel.lacks.clone());
    if panel.entered.seen.replace(seen.clone()).is_some_and(|before| before != seen) {
        ui.scroll_to_cursor(Some(Align::BOTTOM));
    }
    if course.is_finished(lesson) {
        worth(ui, desk.session, panel);
    }
}

fn stage_text(stage: Stage) -> &'static str {
    match stage {
        Stage::Puzzle => "puzzle",
        Stage::Predict => "predict: what you say is locked in",
        Stage::Act => "do it",
        Stage::Reveal => "what you said, and what is so",
        Stage::Why => "say why",
        Stage::Changed => "another case",
    }
}

/// Text in which an empty line is a gap, and a line break is none; what stands between `$$` is a formula.
fn paragraphs(ui: &mut Ui, text: &str) {
    for paragraph in text.trim().split("\n\n") {
        let formula = paragraph.trim().strip_prefix("$$").and_then(|rest| rest.strip_suffix("$$"));
        match formula {
            Some(tex) => {
                let color = Palette::in_ui(ui).text;
                ui.vertical_centered(|ui| math::show(ui, tex.trim(), tex.trim(), color));
            }
            None => {
                ui.label(paragraph.replace('\n', " "));
            }
        }
        ui.add_space(6.0);
    }
}

fn offers(ui: &mut Ui, desk: &mut Desk, step: &Step) {
    for (place, offer) in step.offers.iter().enumerate() {
        let name = widgets::sentence_case(&step.name_of_offer(offer));
        if ui.add_enabled(desk.busy.is_none(), Button::new(&name).wrap()).clicked() {
            desk.orders.push(Order::Lesson(Act::Offer(place)));
        }
    }
    if !step.offers.is_empty() {
        ui.add_space(GAP);
    }
}

/// On to the next step, or what keeps one here.
fn way_on(ui: &mut Ui, desk: &mut Desk, lesson: &Lesson, course: &Course) {
    let palette = Palette::in_ui(ui);
    let step = &lesson.steps[course.place];
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let idle = desk.busy.is_none();
        if course.is_finished(lesson) {
            ui.label(RichText::new("✔ the lesson is done").color(palette.good));
            return;
        }
        let may = course.may_go_on(lesson);
        let go_on = ui.add_enabled(idle && may, Button::new("Go on →").stroke(Stroke::new(1.0, palette.accent)));
        let why_not = if may { "Something is at work; see below" } else { "The step asks for something first" };
        if go_on.on_disabled_hover_text(why_not).clicked() {
            desk.orders.push(Order::Lesson(Act::GoOn));
        }
        if course.may_give_up(lesson) {
            let hint = "The step is left without its points, and the answer is shown";
            if ui.add_enabled(idle, Button::new("Give up")).on_hover_text(hint).clicked() {
                desk.orders.push(Order::Lesson(Act::GiveUp));
            }
        }
        if course.case.is_some() && matches!(step.task, Task::Want(_)) {
            let hint = "The recording of this step as it was at first; undo takes it back";
            if ui.add_enabled(idle, Button::new("Bring the recording again")).on_hover_text(hint).clicked() {
                desk.orders.push(Order::Lesson(Act::Again));
            }
        }
    });
}

/// What the lesson was worth.
fn worth(ui: &mut Ui, session: &Session, panel: &mut LessonPanel) {
    if panel.worth.as_ref().is_none_or(|(of, _)| *of != session.generation) {
        panel.worth = grade(session).ok().map(|grade| (session.generation, grade));
    }
    let Some((_, grade)) = &panel.worth else { return };
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "What it was worth", |ui| {
        let (word, color) = if grade.passed { ("passed", palette.good) } else { ("not passed", palette.warning) };
        ui.horizontal(|ui| {
            ui.label(format!("{:.1} of {:.0} points", grade.points, grade.most));
            widgets::chip(ui, word, color);
        });
        let counted = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let minutes = (grade.seconds as f64 / 60.0).round() as u64;
        let text = format!("{}, {} tried.", counted(minutes, "minute"), counted(grade.tries as u64, "answer"));
        widgets::weak(ui, text);
        widgets::weak(ui, "Save the session (Ctrl+S): the journal in it is what is graded.");
    });
}
