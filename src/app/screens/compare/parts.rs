//! What the predicted torque is made of: inertial, Coriolis, gravity and each effect, beside the truth where the seal is open.

use crate::app::memo::Question;
use crate::effect::registry;
use crate::model::Term;
use crate::session::{Generation, Session};
use crate::signals::Signals;
use crate::simulation::TrueParts;
use crate::training::components;

/// One part of the torque.
pub struct Part {
    pub name: String,
    /// Its formula in TeX, and in plain text.
    pub formula: [&'static str; 2],
    /// Of the model \[N m\]; `None` if it has no such part.
    pub own: Option<Signals>,
    /// The truth \[N m\]; `None` while it is sealed, or if nobody knows it.
    pub truth: Option<Signals>,
}

/// Inertial, Coriolis and gravity torque: what they are called, in TeX, and in plain text.
const RIGID: [(&str, &str, [&str; 2]); 3] = [
    ("inertial", "inertial", [r"H(q)\,\ddot q", "H(q) q̈"]),
    ("coriolis", "Coriolis", [r"c(q, \dot q)", "c(q, q̇)"]),
    ("gravity", "gravity", ["g(q)", "g(q)"]),
];

/// The parts of the torque along a trajectory; none if the model has none.
#[derive(Clone, PartialEq)]
pub struct Decomposition {
    pub trajectory: usize,
    /// Of which model.
    pub model: Generation,
}

impl Question for Decomposition {
    type Answer = Vec<Part>;

    fn answer(&self, session: &Session) -> Result<Vec<Part>, String> {
        let index = self.trajectory;
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.model).ok_or("there is no such model")?;
        let truth = session.truth.as_deref();
        let run = recording.trajectories.get(index).ok_or("there is no such trajectory")?;
        let named = components(&step.fitted, run).map_err(|error| error.to_string())?;
        let exact = truth.as_ref().map(|truth| TrueParts::along(truth, run)).transpose();
        let exact = exact.map_err(|error| error.to_string())?;
        let rigid = RIGID.into_iter().enumerate().map(|(number, (id, name, formula))| Part {
            name: name.to_owned(),
            formula,
            own: named.iter().find(|(name, _)| *name == id).map(|(_, torque)| torque.clone()),
            truth: exact.as_ref().map(|exact| {
                let parts = &exact.arm;
                [&parts.inertial, &parts.coriolis, &parts.gravity][number].clone()
            }),
        });
        let mut parts: Vec<Part> = rigid.collect();
        for (number, term) in step.fitted.model.terms.iter().enumerate() {
            if let Term::Effect(placed) = term {
                let formula = [placed.effect.typeset, placed.effect.formula];
                let own = step.evaluation.predictions.get(index).map(|prediction| prediction.terms[number].clone());
                parts.push(Part { name: term.label(), formula, own, truth: None });
            }
        }
        for (hidden, torque) in
            truth.iter().flat_map(|truth| &truth.effects).zip(exact.into_iter().flat_map(|exact| exact.effects))
        {
            let same = step.fitted.model.terms.iter().find_map(|term| match term {
                Term::Effect(own) if own.effect.id == hidden.effect && own.joint == hidden.joint => Some(term.label()),
                _ => None,
            });
            match parts.iter_mut().find(|part| Some(&part.name) == same.as_ref()) {
                Some(part) => part.truth = Some(torque),
                None => {
                    let known = registry::find(&hidden.effect);
                    let name = known.as_ref().map_or("unknown", |effect| effect.name);
                    let formula = known.as_ref().map_or(["?", "?"], |effect| [effect.typeset, effect.formula]);
                    parts.push(Part { name: format!("hidden: {name}"), formula, own: None, truth: Some(torque) });
                }
            }
        }
        Ok(parts)
    }
}
