//! What the screen shows, as figures.

use std::sync::Arc;

use super::asked::{Facts, Moved};
use super::parts::Part;
use crate::app::desk::{Desk, time_extent};
use crate::app::plot::{Along, series};
use crate::figure::colours::{DASHES, Dash};
use crate::figure::mark::{Line, Points, Shade};
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::model::Term;
use crate::recording::{Joint, Recording};
use crate::session::{Session, Step};
use crate::signals::Signals;

/// Most points of one plot of predicted against measured torque.
const MOST_POINTS: usize = 2500;
/// Width of the measured torque, which is seen under the predicted one.
pub const UNDER: f64 = 1.36;
/// Width of what stands out.
const STRONG: f64 = 1.86;
/// How much of its colour a part has while another one is lit.
const BEHIND: f64 = 0.3;

/// Width and dashes of another trajectory: of what was measured, and of what is predicted.
const THIN: f64 = 0.9;
const BESIDE: [Dash; 2] = [DASHES[5], DASHES[6]];
/// How much of its colour another trajectory has.
const FAINT: f64 = 0.75;

/// Along one trajectory: measured and predicted torque of a joint, and below it what is left, or what it is made of.
pub struct Torques<'a> {
    pub recording: &'a Arc<Recording>,
    pub step: &'a Arc<Step>,
    pub facts: &'a Arc<Facts>,
    pub run: usize,
    /// The held-out stretches \[s\].
    pub held_out: Vec<[f64; 2]>,
    /// Other models over it.
    pub overlaid: &'a [Overlay],
    pub show_terms: bool,
    /// Another trajectory over it.
    pub beside: Option<Beside>,
    /// In place of the residual.
    pub parts: Option<&'a Arc<Vec<Part>>>,
    /// Only the part of this name, of all models over each other.
    pub only: Option<&'a str>,
    /// The part whose line stands out.
    pub lit: Option<&'a str>,
}

/// Another trajectory, drawn over the shown one.
pub struct Beside {
    pub run: usize,
    /// What does not stand in the recording as it is.
    pub moved: Arc<Moved>,
}

/// A model that is drawn over the current one.
pub struct Overlay {
    pub step: Arc<Step>,
    pub ink: Ink,
    /// Measured minus predicted torque by joint; `None` until it is known.
    pub residual: Option<Arc<Signals>>,
    /// What its torque is made of; `None` if nobody asks, or until it is known.
    pub parts: Option<Arc<Vec<Part>>>,
}

/// A panel of a joint's torque over this time, in which what is held out is shaded.
pub fn over_time(joint: &Joint, what: &str, time: [f64; 2], held_out: &[[f64; 2]]) -> Panel {
    let x = Axis::new("time t", "s").range(time).linked(Along::Time);
    let panel = Panel::new(format!("{}: {what}", joint.name), [x, Axis::new("", joint.kind.units()[3])]);
    panel.with_all(held_out.iter().map(|stretch| Shade(*stretch)))
}

impl Torques<'_> {
    /// A panel over the time of the trajectory.
    fn panel(&self, joint: usize, what: &str) -> Panel {
        let info = &self.recording.joints[joint];
        let [first, last] = time_extent(&self.recording.trajectories[self.run].time);
        let others = self.beside.iter().flat_map(|beside| beside.moved.time.last().copied());
        over_time(info, what, [first, others.fold(last, f64::max)], &self.held_out)
    }

    fn line(&self, name: &str, values: Shared<f64>, ink: Ink) -> Line {
        Line::new(name, series::time(self.recording, self.run), values, ink).sampled()
    }

    /// A line of the other trajectory, the one of its number; `None` if there is none.
    fn line_beside(&self, number: usize, name: &str, values: Shared<f64>, ink: Ink) -> Option<Line> {
        let Beside { run, moved } = self.beside.as_ref()?;
        let name = format!("{name}, {}", self.recording.trajectories[*run].name);
        let line = Line::new(name, Shared::of(moved, |moved| &moved.time[..]), values, ink).sampled();
        Some(line.dash(BESIDE[number]).width(THIN).opacity(FAINT))
    }

    /// Measured and predicted torque of a joint, with the terms of the model and other models.
    pub fn torque(&self, joint: usize) -> Panel {
        let measured = self.line("measured τ", series::torque(self.recording, self.run, joint), Ink::Measured);
        let mut panel = self.panel(joint, self.recording.joints[joint].kind.effort()).with(measured.width(UNDER));
        let terms = self.step.fitted.model.terms.iter().map(Term::label).enumerate();
        let terms = terms.filter(|(term, _)| self.show_terms && self.facts.acts[*term][joint]);
        for (term, label) in terms {
            // Unbroken is what was measured. There is one dash less than colours: 42 look different.
            let dash = DASHES[1 + term % (DASHES.len() - 1)];
            let torque = series::term(self.step, self.run, term, joint);
            panel.push(self.line(&format!("term: {label}"), torque, Ink::Series(term)).dash(dash));
        }
        for Overlay { step, ink, .. } in self.overlaid {
            panel.push(self.line(&step.name, series::predicted(step, self.run, joint), *ink));
        }
        if let Some(Beside { run, .. }) = &self.beside {
            let (measured, predicted) =
                (series::torque(self.recording, *run, joint), series::predicted(self.step, *run, joint));
            panel = panel.with_all(self.line_beside(0, "measured τ", measured, Ink::Measured));
            panel = panel.with_all(self.line_beside(1, "predicted τ̂", predicted, Ink::Predicted));
        }
        panel.with(self.line("predicted τ̂", series::predicted(self.step, self.run, joint), Ink::Predicted))
    }

    /// What the model leaves of the torque of a joint, or the parts of which it is made.
    pub fn below(&self, joint: usize) -> Panel {
        let Some(parts) = self.parts else {
            let mut panel = self.panel(joint, "residual");
            for Overlay { step, ink, residual, .. } in self.overlaid {
                let residual = residual.as_ref().map(|residual| Shared::of(residual, move |residual| &residual[joint]));
                panel = panel.with_all(residual.map(|residual| self.line(&step.name, residual, *ink)));
            }
            if let Some(Beside { moved, .. }) = &self.beside {
                let residual = Shared::of(moved, move |moved| &moved.residual[joint]);
                panel = panel.with_all(self.line_beside(0, "τ − τ̂", residual, Ink::Residual));
            }
            let residual = Shared::of(self.facts, move |facts| &facts.residual[joint]);
            return panel.with(self.line("τ − τ̂", residual, Ink::Residual));
        };
        if let Some(only) = self.only {
            return self.one_part(joint, only, parts);
        }
        let mut panel = self.panel(joint, "decomposition");
        for (number, part) in parts.iter().enumerate() {
            let ink = Ink::Series(number);
            let seen = if self.lit.is_none_or(|lit| lit == part.name) { 1.0 } else { BEHIND };
            let width = if self.lit.is_some_and(|lit| lit == part.name) { STRONG } else { 1.0 };
            let acts_in = |torque: &Option<Signals>| torque.as_ref().is_some_and(|torque| acts(&torque[joint]));
            if acts_in(&part.truth) {
                let truth = Shared::of(parts, move |parts| torque_of(&parts[number].truth, joint));
                let truth = self.line(&format!("truth of {}", part.name), truth, ink).wide_and_pale();
                let pale = truth.opacity * seen;
                // What the model lacks has its own name: nothing else tells what it is.
                let truth = if acts_in(&part.own) { truth.together("truth") } else { truth };
                panel.push(truth.opacity(pale));
            }
            if acts_in(&part.own) {
                let own = Shared::of(parts, move |parts| torque_of(&parts[number].own, joint));
                panel.push(self.line(&part.name, own, ink).opacity(seen).width(width));
            }
        }
        panel
    }

    /// One part of the torque: the truth, what the current model has of it, and what the others have.
    fn one_part(&self, joint: usize, only: &str, parts: &Arc<Vec<Part>>) -> Panel {
        let mut panel = self.panel(joint, only);
        let place = |parts: &Vec<Part>| parts.iter().position(|part| part.name == only);
        if let Some(number) = place(parts).filter(|number| parts[*number].truth.is_some()) {
            let truth = Shared::of(parts, move |parts| torque_of(&parts[number].truth, joint));
            panel.push(self.line("truth", truth, Ink::Series(0)).wide_and_pale());
        }
        let mut push = |name: &str, parts: &Arc<Vec<Part>>, ink: Ink| {
            if let Some(number) = place(parts).filter(|number| parts[*number].own.is_some()) {
                let own = Shared::of(parts, move |parts| torque_of(&parts[number].own, joint));
                panel.push(self.line(name, own, ink));
            }
        };
        for Overlay { step, ink, parts, .. } in self.overlaid {
            if let Some(parts) = parts {
                push(&step.name, parts, *ink);
            }
        }
        push(&self.step.name, parts, Ink::Predicted);
        panel
    }
}

fn acts(torque: &[f64]) -> bool {
    torque.iter().any(|value| *value != 0.0)
}

fn torque_of(part: &Option<Signals>, joint: usize) -> &[f64] {
    part.as_ref().map_or(&[], |part| &part[joint])
}

/// Predicted against measured torque of every joint on held-out data, on the diagonal where the model is right: of the current model,
/// and of each that is drawn over it.
pub fn scatter(desk: &Desk) -> Vec<Panel> {
    let Some(step) = desk.session.current() else { return Vec::new() };
    let others = desk.overlaid();
    let title = |step: &Step| if others.is_empty() { "τ̂".to_owned() } else { format!("τ̂ of {}", step.name) };
    let all = [(step, Ink::Predicted)].into_iter().chain(others.iter().map(|(step, ink)| (step, *ink)));
    all.flat_map(|(step, ink)| scatter_of(desk.session, step, ink, &title(step))).collect()
}

fn scatter_of(session: &Session, step: &Step, ink: Ink, title: &str) -> Vec<Panel> {
    let Some(recording) = &session.recording else { return Vec::new() };
    let samples: usize = session.split.held_out.iter().map(|segment| segment.samples.len()).sum();
    if samples == 0 {
        return Vec::new();
    }
    let every = samples.div_ceil(MOST_POINTS);
    let panel = |joint: usize| {
        let mut points = Vec::with_capacity(MOST_POINTS);
        for segment in &session.split.held_out {
            let measured = &recording.trajectories[segment.trajectory].tau[joint];
            let predicted = &step.evaluation.predictions[segment.trajectory].total[joint];
            points.extend(segment.samples.clone().step_by(every).map(|n| [measured[n], predicted[n]]));
        }
        let ends = |[low, high]: [f64; 2], point: &[f64; 2]| [low.min(point[0]), high.max(point[0])];
        let extent = points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        let (name, unit) = (&recording.joints[joint].name, recording.joints[joint].kind.units()[3]);
        let x = Axis::new("measured τ", unit).range(extent).linked(Along::Load(joint));
        Panel::new(format!("{name}: {title}"), [x, Axis::new("", unit)])
            .with(Points::new("", points, ink).radius(0.55).opacity(0.6))
            .with(Line::through("", extent.map(|end| [end, end]), Ink::Weak).width(STRONG))
    };
    (0..recording.joint_count()).map(panel).collect()
}
