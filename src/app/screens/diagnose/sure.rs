//! How sure would you be? Known effects are planted into the open recording, one at a time, and the card tells how often they are
//! found there, and how often something is named that is not there.

use egui::{RichText, Ui, WidgetText};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::app::desk::Desk;
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;
use crate::progress::Progress;
use crate::session::Session;
use crate::trial::planted::{Fared, Plan, Summary};
use crate::work::{Job, Outcome};

/// How many effects are planted, and how strong they are: enough for a first answer; `bench planted` takes as many as one likes.
const DRAWS: u64 = 8;
const STRENGTHS: [f64; 2] = [0.05, 0.2];

/// The card's memory.
#[derive(Default)]
pub struct Sure {
    running: Option<Job<Summary>>,
    answer: Option<Result<Answer, String>>,
}

/// What is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Answer {
    sentence: String,
    /// By strength: how strong, how many were planted, found, and found with certainty.
    rows: Vec<[String; 4]>,
}

impl Sure {
    /// Draws the card.
    pub fn card(&mut self, ui: &mut Ui, desk: &mut Desk) {
        widgets::card(ui, "How sure would you be?", |ui| {
            if let Some((_, progress)) = self.at_work() {
                return self.working(ui, progress);
            }
            match &self.answer {
                Some(Ok(answer)) => answer.show(ui),
                Some(Err(problem)) => {
                    let color = Palette::in_ui(ui).error;
                    ui.label(RichText::new(format!("✖ {problem}")).color(color));
                }
                None => {
                    let text = format!(
                        "Known effects are planted into this recording, {DRAWS} of them one at a time, and it is asked again what \
                         is missing: how many are found?"
                    );
                    widgets::weak(ui, text);
                }
            }
            ui.add_space(GAP / 2.0);
            if ui.add_enabled(desk.busy.is_none(), egui::Button::new("Plant effects")).clicked() {
                self.begin(ui.ctx(), desk.session);
            }
        });
    }

    fn working(&mut self, ui: &mut Ui, progress: Progress) {
        widgets::progress(ui, progress.fraction, ui.available_width());
        widgets::weak(ui, progress.activity);
        if ui.button("Stop planting").clicked() {
            self.stop();
        }
    }

    fn begin(&mut self, ctx: &egui::Context, session: &Session) {
        let Some(recording) = session.recording.clone() else { return };
        let (split, context) = (session.split.clone(), ctx.clone());
        let plan = Plan { draws: DRAWS, twins: 0, seed: 1, strengths: STRENGTHS.to_vec() };
        self.answer = None;
        self.running = Some(Job::spawn(
            "plant effects",
            move || context.request_repaint(),
            move |monitor| plan.of_recording(&recording, &split, monitor),
        ));
    }

    /// Receives what the job has.
    pub fn poll(&mut self) {
        let Some(outcome) = self.running.as_mut().and_then(Job::poll) else { return };
        self.running = None;
        self.answer = match outcome {
            Outcome::Done(summary) => Some(Ok(Answer::of(&summary))),
            Outcome::Stopped(_) => None,
            Outcome::Failed(message) => Some(Err(message)),
            Outcome::Panicked(message) => Some(Err(format!("a defect of the program ended it: {message}"))),
        };
    }

    /// Whether the job is at work.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// The job: its name, and how far it is.
    pub fn at_work(&self) -> Option<(&str, Progress)> {
        self.running.as_ref().map(|job| (job.name(), job.progress()))
    }

    /// Stops the job.
    pub fn stop(&mut self) {
        if let Some(job) = &mut self.running {
            job.stop("you pressed Stop");
        }
    }

    /// The answer, as a file keeps it.
    pub fn kept(&self) -> Value {
        let answer = self.answer.as_ref().and_then(|answer| answer.as_ref().ok());
        serde_json::to_value(answer).unwrap_or_default()
    }

    /// What a file tells of this recording.
    pub fn keep(&mut self, kept: Value) {
        *self = Sure { running: None, answer: serde_json::from_value(kept).ok().map(Ok) };
    }

    /// What was found in another recording says nothing of this one.
    pub fn follow(&mut self, before: &Session, after: &Session) {
        if !after.has_recording_of(before) {
            if let Some(job) = &mut self.running {
                job.stop("another recording was opened");
            }
            *self = Sure::default();
        }
    }
}

impl Answer {
    fn of(summary: &Summary) -> Self {
        let row = |fared: &Fared| {
            let counts = [fared.planted, fared.named, fared.sure].map(|count| count.to_string());
            let [planted, named, sure] = counts;
            [format!("{:.0} %", 100.0 * fared.strength), planted, named, sure]
        };
        Answer { sentence: sentence(summary), rows: summary.planted.by_strength.iter().map(row).collect() }
    }

    fn show(&self, ui: &mut Ui) {
        ui.label(&self.sentence);
        let rows: Vec<Vec<WidgetText>> =
            self.rows.iter().map(|row| row.iter().map(|cell| cell.clone().into()).collect()).collect();
        let header = ["of the measured", "planted", "found", "at 90 % or more"];
        widgets::table(ui, "planted effects", &header, &rows);
        widgets::weak(ui, "`torquescope bench planted` plants as many as you like, and tells each.");
    }
}

/// What became of the planted effects, in words.
fn sentence(summary: &Summary) -> String {
    let group = &summary.planted;
    let sum = |count: fn(&Fared) -> usize| group.by_strength.iter().map(count).sum::<usize>();
    let (new, named, there) = (sum(|fared| fared.planted), sum(|fared| fared.named), sum(|fared| fared.there_before));
    let false_names: usize = summary.cases.iter().map(|tried| tried.false_names.len()).sum();
    let found = match new {
        0 => "All effects that were planted had been named before, or a form of them".to_owned(),
        new => format!("Of {new} effects that were planted here and had not been named before, {named} were found"),
    };
    let more = match there {
        0 => String::new(),
        there => format!("; {there} more were planted where they, or a form of them, had been named before"),
    };
    let names = match false_names {
        0 => "No name was false.".to_owned(),
        1 => "One name was false.".to_owned(),
        count => format!("{count} names were false."),
    };
    format!("{found}{more}. {names}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_is_a_sentence() {
        let mut summary = Summary::of(Vec::new(), &STRENGTHS, Vec::new());
        assert_eq!(
            sentence(&summary),
            "All effects that were planted had been named before, or a form of them. No name was false."
        );
        let fared = |planted, named, there_before| Fared { planted, named, there_before, ..Fared::default() };
        summary.planted.by_strength = vec![fared(3, 1, 1), fared(4, 4, 0)];
        assert_eq!(
            sentence(&summary),
            "Of 7 effects that were planted here and had not been named before, 5 were found; 1 more were planted where they, \
             or a form of them, had been named before. No name was false."
        );
    }
}
