//! What no effect explains: on which channels the remainder depends, in which order, and formulas for it.
//!
//! The remainder is what the model, with all effects in it, leaves of the prepared torque. A flexible basis of each channel, and
//! of pairs, is asked to predict blocks that were left out (`dependence`). Formulas are products of sines of angles, speeds,
//! signs, loads and time (`candidates`), chosen beside the model one after the other (`selection`), first on thinned rows
//! (`rows`), then among the best ones exactly as a fit would have them; one is proposed if half of the blocks choose it again
//! and again and left-out blocks confirm it. If no function of the state predicts the remainder although it is
//! no noise, it has a memory: a state of its own, which no formula of the channels can have.
//!
//! Source of stability selection: Meinshausen and Bühlmann, J. R. Stat. Soc. B 72 (2010) 417; of complementary halves: Shah and
//! Samworth, J. R. Stat. Soc. B 75 (2013) 55.

mod candidates;
mod dependence;
mod formulas;
mod rows;
mod selection;
mod words;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use candidates::Library;
use dependence::Basis;
use rows::Thinning;
pub use words::percent;

use super::linear_counterpart;
use super::report::alone;
use crate::effect::Effect;
use crate::effect::own::{Draft, DraftColumn};
use crate::model::design::Design;
use crate::model::equations::PreparedColumn;
use crate::model::terms::OperatingPoint;
use crate::model::{Fitted, ModelError, fit};
use crate::progress::Monitor;
use crate::recording::split::Split;
use crate::recording::{JointKind, Recording};
use crate::signals::Signals;

/// Share of the remainder that must be predicted for it to be more than noise.
const LEAST_PREDICTED: f64 = 0.05;
/// What depends on the state less than this, and is coloured, has a memory.
const LEAST_STATIC: f64 = 0.15;
/// So many samples of the remainder count as one, where it is coloured; white noise that was filtered has up to two.
const COLOURED: f64 = 4.0;
/// Smallest share of the joint's torque (RMS) that is worth a word.
const LEAST_SHARE: f64 = 1e-3;

/// What the remainder of a model depends on, and formulas for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposals {
    /// One for each joint.
    pub remainders: Vec<Remainder>,
    /// Formulas that could be added, joint by joint; within a joint each beside those before it.
    pub formulas: Vec<Proposal>,
}

/// What is left on one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Remainder {
    /// Counted from 0; written counted from 1.
    #[serde(with = "alone")]
    pub joint: usize,
    /// Its RMS \[N m or N\].
    pub rms: f64,
    /// That over the RMS of the joint's torque.
    pub share: f64,
    /// What it is.
    pub nature: Nature,
    /// Share of its energy that the channels predict on blocks that were left out.
    pub predicted: f64,
    /// So many neighbouring samples say the same: 1 for white noise.
    pub correlation: f64,
    /// Each channel alone, the best first.
    pub channels: Vec<Dependence>,
    /// Pairs of channels that say more together.
    pub pairs: Vec<Dependence>,
    /// Which channel says most, which most beside it.
    pub order: Vec<Step>,
}

/// What a remainder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Nature {
    /// Nothing worth a word, or nothing that follows from anything.
    Noise,
    /// It follows from the state of the arm.
    Static,
    /// It is no noise, but does not follow from the state: it remembers.
    Memory,
}

/// How much of the remainder some channels predict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Dependence {
    /// Such as `q1`, `qd2`.
    pub channels: Vec<String>,
    /// Share of its energy on blocks that were left out; negative if they do harm.
    pub share: f64,
}

/// A channel in the order of what it says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Such as `qd2`.
    pub channel: String,
    /// Share of the remainder that is predicted with it and those before it.
    pub share: f64,
}

/// A formula for the remainder of a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// Counted from 0; written counted from 1.
    #[serde(with = "alone")]
    pub joint: usize,
    /// The torque that a value of 1 makes, in the channels of all joints.
    pub formula: String,
    /// The factor, in [`Proposal::unit`].
    pub value: f64,
    /// Its 95 % confidence interval; `None` with too few blocks.
    pub interval: Option<[f64; 2]>,
    /// SI unit.
    pub unit: String,
    /// Share of the remainder that it explains on blocks that were left out, beside those before it.
    pub share: f64,
    /// 95 % confidence interval of the share; `None` with too few blocks.
    pub share_interval: Option<[f64; 2]>,
    /// Share of the halves of the data that choose it, or one that looks like it.
    pub stability: f64,
    /// Formulas that these data hardly tell from it.
    pub look_alikes: Vec<String>,
    /// A constant torque beside it \[N m or N\], if the data show one.
    pub offset: Option<f64>,
    /// The effect of the catalogue that it is, if it is one.
    pub known: Option<&'static Effect>,
}

impl Proposal {
    /// As an effect of one's own on a joint of this kind. The same formula is the same effect, whatever the data.
    pub fn draft(&self, kind: JointKind) -> Draft {
        let mut words = String::from("own-");
        for letter in self.formula.chars() {
            match letter {
                '+' => words.push_str("plus"),
                '-' => words.push_str("minus"),
                '^' => words.push_str("-to-"),
                letter if letter.is_ascii_alphanumeric() || letter == '_' => words.push(letter),
                _ if !words.ends_with('-') => words.push('-'),
                _ => {}
            }
        }
        let mut columns =
            vec![DraftColumn { name: "factor".into(), unit: self.unit.clone(), formula: self.formula.clone() }];
        let mut id = words.trim_end_matches('-').replace('_', "-");
        if self.offset.is_some() {
            id.push_str("-and-offset");
            columns.push(DraftColumn { name: "offset".into(), unit: kind.units()[3].into(), formula: "1".into() });
        }
        Draft {
            id,
            name: self.formula.clone(),
            description: "A formula that a remainder proposed: nobody has said yet what it is.".into(),
            source: "Proposed from a remainder by Torquescope: sparse regression over products of channels.".into(),
            columns,
        }
    }
}

/// Asks on what depends what `fitted` leaves of the training part, and by which formulas. For a network, the rigid body stands
/// that it has learned.
///
/// ```
/// use torquescope::diagnosis::proposal::{Nature, propose};
/// use torquescope::{model, prelude::*};
///
/// let monitor = Monitor::new();
/// // Coulomb friction is hidden in it.
/// let recording = simulate(&Scenario::embedded(), &monitor)?;
/// let split = Split::automatic(&recording);
/// let body = model::fit(&Preset::RigidBody.model(&recording)?, &recording, &split, &monitor)?;
/// let proposals = propose(&body, &recording, &split, &monitor)?;
/// assert_eq!(proposals.remainders[0].nature, Nature::Static);
/// assert_eq!(proposals.formulas[0].formula, "direction1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ModelError`] if the model does not fit the recording, or the work was stopped.
pub fn propose(
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Proposals, ModelError> {
    monitor.report(0.02, "filtering the torque")?;
    let design = Design::new(recording, split)?;
    let counterpart;
    let fitted = if fitted.model.is_learned() {
        counterpart = fit::fit_design(&linear_counterpart(fitted), &design, monitor)?;
        &counterpart
    } else {
        fitted
    };
    let body = fitted.body().or(design.point().body.clone()).filter(|_| !fitted.model.is_pinned());
    let design = design.at(OperatingPoint::new(body, fitted.effects()));
    let left = Left::of(fitted, &design)?;
    let kinds = &design.setting().kinds;
    let libraries: Vec<Library> = (0..kinds.len()).map(|joint| Library::new(joint, kinds)).collect();
    let most = libraries.iter().map(|library| library.candidates.len()).max().unwrap_or_default();
    let thinning = Thinning::new(&design, most);
    monitor.report(0.15, "asking every channel")?;
    let basis = Basis::new(&thinning);
    monitor.report(0.3, "trying formulas")?;
    let of_joint = |(joint, library): (usize, &Library)| {
        monitor.check()?;
        let rows = thinning.of_joint(&left.columns, &left.torque, joint)?;
        let mut remainder = left.remainder(joint, basis.find(&rows));
        let formulas = match remainder.nature {
            Nature::Noise => Vec::new(),
            Nature::Static | Nature::Memory => formulas::of_joint(&left, library, &thinning, &rows, joint)?,
        };
        // What a formula explains is static, whatever the basis could say of it.
        if !formulas.is_empty() {
            remainder.nature = Nature::Static;
        }
        Ok((remainder, formulas))
    };
    let answers: Vec<_> = libraries.par_iter().enumerate().map(of_joint).collect::<Result<_, ModelError>>()?;
    let (remainders, first): (Vec<Remainder>, Vec<Vec<Proposal>>) = answers.into_iter().unzip();
    // What one joint lacks bends the rigid body, and so what another one seems to lack: each once more, beside the others.
    monitor.report(0.7, "each joint beside the others")?;
    let once_more = |(joint, library): (usize, &Library)| {
        monitor.check()?;
        let others: Vec<&Proposal> = first.iter().flatten().filter(|formula| formula.joint != joint).collect();
        if first[joint].is_empty() || others.is_empty() {
            return Ok(first[joint].clone());
        }
        let left = left.beside(&others)?;
        let rows = thinning.of_joint(&left.columns, &left.torque, joint)?;
        formulas::of_joint(&left, library, &thinning, &rows, joint)
    };
    let formulas: Vec<_> = libraries.par_iter().enumerate().map(once_more).collect::<Result<_, ModelError>>()?;
    monitor.report(1.0, "proposed")?;
    Ok(Proposals { remainders, formulas: formulas.into_iter().flatten().collect() })
}

/// What a model leaves of the prepared torque.
struct Left<'a> {
    design: &'a Design<'a>,
    /// Columns of the model.
    columns: Vec<PreparedColumn>,
    /// 1 / error variance of each joint.
    weights: Vec<f64>,
    /// What is to be explained by the columns.
    whole: Vec<Signals>,
    /// What they leave.
    torque: Vec<Signals>,
    /// How many samples count as one, by joint.
    correlation: Vec<f64>,
}

impl<'a> Left<'a> {
    fn of(fitted: &Fitted, design: &'a Design<'a>) -> Result<Self, ModelError> {
        let columns = design.columns(&fitted.model, fitted.shapes())?;
        let whole = design.unexplained_torque(&fitted.model)?;
        Ok(Left::by(design, columns, whole))
    }

    /// What is left beside the model and formulas for other joints.
    fn beside(&self, formulas: &[&Proposal]) -> Result<Self, ModelError> {
        let mut columns = self.columns.clone();
        for formula in formulas {
            let texts = ["1", formula.formula.as_str()];
            columns.extend(formulas::columns(self.design, &texts, formula.joint)?);
        }
        Ok(Left::by(self.design, columns, self.whole.clone()))
    }

    fn by(design: &'a Design<'a>, columns: Vec<PreparedColumn>, whole: Vec<Signals>) -> Self {
        let equations = design.equations(&columns, &whole);
        let joints = design.joint_count();
        // The first weights take each joint's torque for its error; the second know the error.
        let mut weights: Vec<f64> =
            (0..joints).map(|joint| 1.0 / design.energy(joint).max(f64::MIN_POSITIVE)).collect();
        weights = design.residual_weights(&equations, &equations.total(&weights, |_| true).solve().factors);
        let factors = equations.total(&weights, |_| true).solve().factors;
        let correlation = (0..joints).map(|joint| equations.correlation(&columns, &factors, &whole, joint)).collect();
        let mut torque = whole.clone();
        columns.iter().zip(&factors).for_each(|(column, factor)| column.add_to(&mut torque, -factor));
        Left { design, columns, weights, whole, torque, correlation }
    }

    fn remainder(&self, joint: usize, found: dependence::Found) -> Remainder {
        let samples = self.design.sample_count(joint).max(1) as f64;
        let squared: f64 = self
            .design
            .blocks()
            .iter()
            .flat_map(|block| &self.torque[block.trajectory][joint][block.samples.clone()])
            .map(|left| left * left)
            .sum();
        let rms = (squared / samples).sqrt();
        let share = rms / (self.design.energy(joint) / samples).sqrt().max(f64::MIN_POSITIVE);
        let is_coloured = self.correlation[joint] >= COLOURED;
        let nature = match found.predicted {
            _ if share < LEAST_SHARE => Nature::Noise,
            predicted if predicted >= LEAST_STATIC => Nature::Static,
            _ if is_coloured => Nature::Memory,
            predicted if predicted >= LEAST_PREDICTED => Nature::Static,
            _ => Nature::Noise,
        };
        Remainder {
            joint,
            rms,
            share,
            nature,
            predicted: found.predicted,
            correlation: self.correlation[joint],
            channels: found.alone,
            pairs: found.pairs,
            order: found.order,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::arm::Arm;
    use crate::effect::own;
    use crate::model::Preset;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// Whatever is proposed can be adopted, and no two formulas are the same effect.
    #[test]
    fn every_formula_is_an_effect_with_an_id_of_its_own() {
        let mut ids = HashSet::new();
        for candidate in Library::new(1, &[JointKind::Revolute; 4]).candidates {
            let proposal = Proposal {
                joint: 1,
                unit: candidate.unit(JointKind::Revolute),
                formula: candidate.text,
                value: 1.0,
                interval: None,
                share: 0.5,
                share_interval: None,
                stability: 1.0,
                look_alikes: Vec::new(),
                offset: Some(1.0),
                known: None,
            };
            let draft = proposal.draft(JointKind::Revolute);
            assert_eq!(draft.columns[1].unit, "N m");
            assert_eq!(proposal.draft(JointKind::Prismatic).columns[1].unit, "N", "what slides is moved by a force");
            assert!(ids.insert(draft.id.clone()), "{} is there twice: {}", draft.id, proposal.formula);
            // As many as are enough to read every kind of factor.
            if ids.len() % 17 == 0 {
                let effect = own::load(&draft.to_toml()).unwrap();
                assert_eq!((effect.id, effect.name), (draft.id.as_str(), proposal.formula.as_str()));
            }
        }
        assert!(ids.len() > 500);
    }

    /// Coulomb friction with a constant beside it, which the catalogue has without the constant.
    #[test]
    fn a_formula_is_found_with_its_numbers_and_known_by_its_column() {
        let motion = Excitation::PaperPointToPoint { trajectories: 8, duration: 4.0, samples: 200, range: 2.0 };
        let [friction, ..] = &Scenario::embedded().effects[..] else { panic!("it hides friction") };
        let scenario =
            Scenario { motion, arm: Arm::uniform(1), effects: vec![friction.clone()], ..Scenario::embedded() };
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let model = Preset::RigidBody.model(&recording).unwrap();
        let body = fit::fit(&model, &recording, &split, &Monitor::new()).unwrap();
        let Proposals { remainders, formulas } = propose(&body, &recording, &split, &Monitor::new()).unwrap();
        assert_eq!((remainders[0].nature, &*remainders[0].channels[0].channels[0]), (Nature::Static, "qd1"));
        let found = &formulas[0];
        assert_eq!((&*found.formula, &*found.unit, found.offset), ("direction1", "N m", None));
        assert_eq!(found.known.map(|effect| effect.id), Some("coulomb-friction"));
        let [low, high] = found.interval.unwrap();
        assert!((found.value - 2.4).abs() < 0.1 && low < found.value && found.value < high, "{found:?}");
        assert!(high - low < 0.5, "{low} to {high}");
        let [low, high] = found.share_interval.unwrap();
        assert!(found.share > 0.9 && low <= found.share && found.share <= high && found.stability == 1.0);
        let remarks = found.remarks(&recording.joints[0]);
        assert!(remarks.iter().any(|remark| remark.ends_with("add coulomb-friction@1")), "{remarks:?}");
        assert!(!remarks.iter().any(|remark| remark.contains("a constant beside it")));
        let beside = Proposal { offset: Some(0.5), look_alikes: vec!["a".into(), "b".into()], ..found.clone() };
        let remarks = beside.remarks(&recording.joints[0]);
        assert_eq!(remarks[1..], ["is hardly told from a, b", "has a constant beside it: 0.500 N m"]);
    }
}
