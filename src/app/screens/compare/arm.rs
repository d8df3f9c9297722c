//! The arm at the cursor: in the plane, or in space where its axes are stated.

use super::asked::Facts;
use crate::app::desk::time_extent;
use crate::app::plot::arm::{self, Pose};
use crate::app::plot::spatial::{self, Sight, SpatialPose};
use crate::arm::Arm;
use crate::arm::chain::Chain;
use crate::figure::Panel;
use crate::figure::mark::nearest;
use crate::recording::{JointKind, Recording};
use crate::session::Step;
use crate::signals::Signals;

/// Where the cursor stands at first, as a part of the trajectory.
pub const START: f64 = 0.35;

/// What is known of the arm's shape.
pub enum Body {
    /// As stated, or links of equal length.
    Planar(Arm),
    /// Where its axes are, and which joints slide.
    Spatial(Chain, Vec<bool>),
}

impl Body {
    /// Of the arm of a recording; `None` if it slides in the plane.
    pub fn of(recording: &Recording) -> Option<Body> {
        let sliding: Vec<bool> = recording.joints.iter().map(|joint| joint.kind == JointKind::Prismatic).collect();
        if let Some(chain) = recording.spatial() {
            return Some(Body::Spatial(chain.clone(), sliding));
        }
        let mut arm = recording.stated_arm.clone().unwrap_or_else(|| Arm::uniform(recording.joint_count()));
        arm.posture = recording.posture.unwrap_or(arm.posture);
        (!sliding.contains(&true)).then_some(Body::Planar(arm))
    }

    /// Where its tip is \[m\]; an arm in the plane stays at y = 0.
    pub fn tip(&self, q: &[f64]) -> [f64; 3] {
        match self {
            Body::Planar(arm) => {
                let [x, z] = arm.tip(q);
                [x, 0.0, z]
            }
            Body::Spatial(chain, sliding) => chain.skeleton(q, sliding).tip(),
        }
    }
}

/// The arm at the cursor as it is seen from somewhere; `None` if it has no shape.
pub fn panel(
    recording: &Recording,
    step: &Step,
    facts: &Facts,
    run: usize,
    cursor: Option<f64>,
    sight: Sight,
) -> Option<Panel> {
    let signals = &recording.trajectories[run];
    let [first, last] = time_extent(&signals.time);
    let time = cursor.unwrap_or(first + START * (last - first)).clamp(first, last);
    let sample = nearest(&signals.time, time);
    let at = |signal: &Signals| -> Vec<f64> { signal.iter().filter_map(|joint| joint.get(sample).copied()).collect() };
    let (q, measured, predicted) = (at(&signals.q), at(&signals.tau), at(&step.evaluation.predictions[run].total));
    let (q, measured, predicted, largest) = (&*q, &*measured, &*predicted, &*facts.largest);
    Some(match Body::of(recording)? {
        Body::Planar(arm) => {
            let path: Vec<[f64; 2]> = facts.tip.iter().map(|[x, _, z]| [*x, *z]).collect();
            arm::panel(&Pose { time, arm: &arm, q, measured, predicted, largest, path: &path })
        }
        Body::Spatial(chain, sliding) => {
            let (chain, sliding, path) = (&chain, &*sliding, &*facts.tip);
            spatial::panel(&SpatialPose { time, chain, sliding, sight, q, measured, predicted, largest, path })
        }
    })
}
