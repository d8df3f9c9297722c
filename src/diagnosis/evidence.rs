//! The plot that shows an effect: what the rest of the model leaves of the torque, over the state where the effect shows.

use super::report::Evidence;
use crate::effect::{Axis, Effect};
use crate::model::{Evaluation, Fitted, Term};
use crate::recording::split::Split;
use crate::recording::{Recording, Trajectory};

/// Most points of one plot.
const MOST_POINTS: usize = 3000;

/// The signal on the axis, for one joint.
pub fn state(trajectory: &Trajectory, axis: Axis, joint: usize) -> &[f64] {
    match axis {
        Axis::Time => &trajectory.time,
        Axis::Position => &trajectory.q[joint],
        Axis::Velocity => &trajectory.qd[joint],
        Axis::Acceleration => &trajectory.qdd[joint],
    }
}

/// Component-plus-residual plots of one effect of a fitted model, one for each of `joints`, on held-out data.
///
/// The residual shown is that of the whole model plus the effect's own torque: what all other terms, at their final values,
/// leave for the effect to explain.
pub fn of_effect(
    fitted: &Fitted,
    evaluation: &Evaluation,
    recording: &Recording,
    split: &Split,
    effect: &Effect,
    joints: &[usize],
) -> Vec<Evidence> {
    let axis = effect.axis;
    let samples: usize = split.held_out.iter().map(|segment| segment.samples.len()).sum();
    let every = samples.div_ceil(MOST_POINTS).max(1);
    let of_joint = |&joint: &usize| {
        let acts = |term: &Term| matches!(term, Term::Effect(term) if term.effect == effect && term.joint.is_none_or(|on| on == joint));
        let term = fitted.model.terms.iter().position(acts)?;
        let mut evidence = Evidence { joint, axis, residual: Vec::new(), explained: Vec::new() };
        for segment in &split.held_out {
            let trajectory = &recording.trajectories[segment.trajectory];
            let prediction = &evaluation.predictions[segment.trajectory];
            let state = state(trajectory, axis, joint);
            for sample in segment.samples.clone().step_by(every) {
                let effect = prediction.terms[term][joint][sample];
                let residual = trajectory.tau[joint][sample] - prediction.total[joint][sample];
                evidence.residual.push([state[sample], residual + effect]);
                evidence.explained.push([state[sample], effect]);
            }
        }
        evidence.explained.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Some(evidence)
    };
    joints.iter().filter_map(of_joint).collect()
}
