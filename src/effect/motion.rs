//! What an effect is told: the motion, and what the rigid body needs along it.

use std::borrow::Cow;
use std::fmt;
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};

use super::{Column, sign};
use crate::arm::chain::Chain;
use crate::arm::{Arm, Posture};
use crate::recording::encoders::Side;
use crate::recording::{JointKind, Trajectory};
use crate::signals::Signals;

/// What an effect is told of the motion.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Position, velocity, acceleration; the torque in it is not to be read.
    pub trajectory: &'a Trajectory,
    /// What each joint does.
    pub kinds: &'a [JointKind],
    /// Where q = 0 points and which way q grows.
    pub posture: Posture,
    /// Acceleration of free fall that the torque shows \[m/s²\].
    pub gravity: f64,
    /// The arm's geometry, where it is known.
    pub arm: Option<&'a Arm>,
    /// The axes of an arm that is not planar, where they are known.
    pub chain: Option<&'a Chain>,
    /// What the rigid body needs, where it is known.
    pub load: Option<&'a Load>,
    /// The speed within which each joint's dry friction turns round; none for joints that are not listed.
    pub reversal_widths: &'a [f64],
}

/// What the rigid body needs along one trajectory, for effects that depend on it: friction under load, errors of the torque
/// reading. It comes from a rigid body, never from the measured torque, or the effects would explain the torque by itself.
#[derive(Clone)]
pub struct Load {
    /// Torque of the rigid body \[N m\].
    pub torque: Signals,
    /// Derivative of its gravity torque by the zero angle of the posture \[N m/rad\].
    pub turned_gravity: Signals,
    /// Its lumped parameters, if it is a planar arm; see [`crate::arm::regressor`].
    pub lumped: Option<Vec<f64>>,
    /// Its torque \[N m\] along any other trajectory.
    pub body: Arc<dyn Fn(&Trajectory) -> Signals + Send + Sync>,
    /// The motion that it is of, without its torque.
    along: Trajectory,
    /// What the state of each joint does to it, once somebody asked.
    slopes: Arc<[OnceLock<Slopes>]>,
}

/// Derivatives of the body's torque on all joints by the state of one.
#[derive(Clone)]
pub struct Slopes {
    /// ∂τ/∂q \[N m/rad\]
    pub position: Signals,
    /// ∂τ/∂q̇ \[N m s/rad\]
    pub velocity: Signals,
    /// ∂τ/∂q̈, a column of H \[kg m²\]
    pub acceleration: Signals,
}

/// The distance over which derivatives are taken \[rad, m; per s\]: torque changes with angles over a radian.
const SLOPE_STEP: f64 = 1e-6;

impl fmt::Debug for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Load").field("torque", &self.torque).finish_non_exhaustive()
    }
}

impl Load {
    /// The load of a known arm.
    pub fn of_arm(arm: &Arm, trajectory: &Trajectory) -> Load {
        let turned_gravity = arm.turned_gravity_along(&trajectory.q);
        let (arm, lumped) = (arm.clone(), arm.lumped_parameters());
        let body =
            move |trajectory: &Trajectory| arm.inverse_dynamics_along(&trajectory.q, &trajectory.qd, &trajectory.qdd);
        Load::by(body, turned_gravity, Some(lumped), trajectory)
    }

    /// The load of a rigid body that gives its torque along any trajectory.
    pub fn by(
        body: impl Fn(&Trajectory) -> Signals + Send + Sync + 'static,
        turned_gravity: Signals,
        lumped: Option<Vec<f64>>,
        trajectory: &Trajectory,
    ) -> Load {
        let torque = body(trajectory);
        let slopes = vec![OnceLock::new(); torque.joint_count()].into();
        Load { torque, turned_gravity, lumped, body: Arc::new(body), along: trajectory.without_torque(), slopes }
    }

    /// The body's torque along a motion; that of the load's own is known.
    pub(super) fn torque_along(&self, motion: &Trajectory) -> Cow<'_, Signals> {
        let is_own = [(&motion.q, &self.along.q), (&motion.qd, &self.along.qd), (&motion.qdd, &self.along.qdd)];
        if is_own.iter().all(|(signal, own)| signal == own) {
            Cow::Borrowed(&self.torque)
        } else {
            Cow::Owned((self.body)(motion))
        }
    }

    /// What the state of a joint does to the body's torque, along the motion of this load: whoever asks first, on whatever thread and
    /// with whatever motion of his own, all get the same.
    pub(super) fn slopes(&self, joint: usize) -> &Slopes {
        self.slopes[joint].get_or_init(|| {
            let slope = |part: usize, step: f64| {
                let mut moved = self.along.clone();
                let channels = moved.channels_mut();
                let mut signals = [channels.q, channels.qd, channels.qdd];
                signals[part].iter_mut().nth(joint).into_iter().flatten().for_each(|value| *value += step);
                let mut change = (self.body)(&moved);
                change.add(&self.torque, -1.0);
                change.map(|value| value / step)
            };
            // Torque is linear in accelerations.
            Slopes { position: slope(0, SLOPE_STEP), velocity: slope(1, SLOPE_STEP), acceleration: slope(2, 1.0) }
        })
    }
}

impl Motion<'_> {
    /// The load.
    pub(super) fn load(&self) -> Result<&Load, Lack> {
        self.load.ok_or(Lack::Load)
    }

    /// The direction of dry friction at this velocity of a joint: its sign, and where a width is known tanh(q̇ / width). At a
    /// reversal a real joint sticks, slides by its bristles and is read with noise, so its friction does not jump.
    pub fn direction(&self, joint: usize, velocity: f64) -> f64 {
        match self.reversal_widths.get(joint) {
            Some(&width) if width > 0.0 => (velocity / width).tanh(),
            _ => sign(velocity),
        }
    }

    /// The column of Coulomb friction, which most forms of dry friction contain: the direction, sample by sample.
    pub(super) fn coulomb(&self, joint: usize) -> Column {
        Column::on_joint(joint, self.trajectory.qd[joint].iter().map(|&qd| self.direction(joint, qd)))
    }

    /// A joint behind the one before it, for the effect of a pair.
    pub(super) fn pair(&self, joint: usize) -> Result<[usize; 2], Lack> {
        match joint.checked_sub(1) {
            Some(before) if joint < self.trajectory.joint_count() => Ok([before, joint]),
            _ => Err(Lack::Pair),
        }
    }
}

/// An effect can't be computed for this motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{effect} can't be computed: {lack}")]
pub struct NotApplicable {
    /// Name of the effect.
    pub effect: &'static str,
    /// What is lacking and how to give it.
    #[source]
    pub lack: Lack,
}

/// What an effect lacks to be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Lack {
    /// The load.
    #[error("it needs the torque of a rigid body: choose the preset `rigid-body`")]
    Load,
    /// A joint before its own.
    #[error("it needs two neighbouring joints")]
    Pair,
    /// The arm's geometry.
    #[error("it needs the link lengths: state the arm")]
    Arm,
    /// The end of an arm in space.
    #[error(
        "it needs the place of the tip: state a frame that is fixed to the last link (a fixed joint of the robot's file)"
    )]
    Tip,
    /// An arm of as many links as there are joints.
    #[error("the stated arm has {links} links, the motion has {joints} joints: state an arm that fits")]
    OtherArm {
        /// Of the arm.
        links: usize,
        /// Of the motion.
        joints: usize,
    },
    /// Joints that all turn.
    #[error("its formula is for arms whose joints all turn")]
    TurningJoints,
    /// A second joint.
    #[error("with one joint it is the same as a base tilt")]
    SecondJoint,
    /// Encoders on the side of the gears that its formula speaks of.
    #[error(
        "its formula takes the encoders to be on the {side}s, and they are stated to be on the other side of the gears"
    )]
    Encoders {
        /// The side that it speaks of.
        side: Side,
    },
    /// A velocity or an acceleration that was measured.
    #[error("it is about measured velocities, and here they are derived from the positions, which makes them no later")]
    MeasuredDerivatives,
    /// An arm in a plane.
    #[error("it is about planar arms")]
    PlanarArm,
    /// A joint that its formula speaks of.
    #[error("its formula speaks of joint {joint}, the motion has {joints}")]
    NoJoint {
        /// Counted from 1.
        joint: usize,
        /// Of the motion.
        joints: usize,
    },
    /// A number.
    #[error(
        "its formula is no finite number at sample {sample} of a trajectory, as after a division by 0: write it so that it is \
         finite everywhere"
    )]
    NotFinite {
        /// Counted from 1.
        sample: usize,
    },
    /// As many parameters as its formula has.
    #[error("it has {needed} parameters, {given} were given")]
    Parameters {
        /// Of its formula.
        needed: usize,
        /// Of the caller.
        given: usize,
    },
    /// It is a fault of the torque readings, which the readings show by themselves.
    #[error("it is a fault of the readings, which are left out where they show it")]
    InReadings,
}
