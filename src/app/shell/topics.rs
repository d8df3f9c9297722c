//! Which topic of a log of messages columns are made of, and which stands beside it: in the import assistant.

use egui::{ComboBox, Ui};

use crate::app::widgets;
use crate::recording::read::{Preview, SeenTopic};

/// Width of a list of topics \[points\].
const WIDTH: f32 = 330.0;

/// The topics of a log, and which of them are read.
#[derive(Default)]
pub struct Topics {
    there: Vec<SeenTopic>,
    /// The one that gives the times, and the one beside it.
    taken: Vec<String>,
    /// What is said of their clocks.
    clocks: Vec<String>,
}

impl Topics {
    /// Of a log that was looked into.
    pub fn of(preview: &Preview) -> Self {
        Topics { there: preview.topics.clone(), taken: preview.taken(), clocks: preview.clocks.clone() }
    }

    /// The same, of which these are to be taken; their clocks are not known yet.
    pub fn taking(self, taken: Vec<String>) -> Self {
        Topics { taken, clocks: Vec::new(), ..self }
    }

    /// Asks for them where there is a choice; what is to be read instead, if that was chosen.
    pub fn ask(&self, ui: &mut Ui) -> Option<Vec<String>> {
        let mut asked = self.taken.clone();
        if self.there.len() > 1 {
            ui.horizontal_wrapped(|ui| {
                self.list(ui, "Topic", &mut asked, 0);
                self.list(ui, "and beside it", &mut asked, 1);
            });
        }
        self.clocks.iter().for_each(|told| drop(widgets::weak(ui, format!("{}.", widgets::sentence_case(told)))));
        (asked != self.taken).then_some(asked)
    }

    /// The topics that can stand at a place; the second may be empty.
    fn list(&self, ui: &mut Ui, title: &str, asked: &mut Vec<String>, place: usize) {
        let label = ui.label(title);
        let now = asked.get(place).map_or("no other", String::as_str).to_owned();
        let list = ComboBox::from_id_salt(title).width(WIDTH).truncate().selected_text(now);
        let list = list.show_ui(ui, |ui| {
            if place > 0 && ui.selectable_label(asked.len() <= place, "no other").clicked() {
                asked.truncate(place);
            }
            for topic in &self.there {
                let is_taken = asked.get(place) == Some(&topic.name);
                let at_other_place = !is_taken && asked.contains(&topic.name);
                let told = format!("{} ({}, {} messages)", topic.name, topic.kind, topic.messages);
                if !at_other_place && ui.selectable_label(is_taken, told).clicked() {
                    match asked.get_mut(place) {
                        Some(before) => *before = topic.name.clone(),
                        None => asked.push(topic.name.clone()),
                    }
                }
            }
        });
        list.response.labelled_by(label.id);
    }
}
