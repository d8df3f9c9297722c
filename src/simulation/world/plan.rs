//! The plan of a run: what is built, what acts, and under which name each hidden thing is counted.

use super::moment::{Forces, Moment, Planar};
use super::transmission::Transmission;
use crate::arm::Arm;
use crate::recording::encoders::Side;

/// Radius of the ball around the tip that touches obstacles \[m\].
pub(super) const TIP_RADIUS: f64 = 0.01;

/// Where in [`Plan::hidden`] something is counted.
pub(super) type Slot = usize;

/// Acts on the bodies of the arm.
pub(super) trait Device {
    /// Gives its forces for the coming step.
    fn act(&mut self, now: &Moment, forces: &mut Forces);
}

/// Stands in the way of a joint's torque, in the drive or before the log.
pub(super) trait Stage {
    /// What becomes of the torque \[N m\] in this step.
    fn pass(&mut self, torque: f64, now: &Moment) -> f64;
}

/// Stages in the order in which a torque passes them, each with where it is counted.
pub(super) type Stages = Vec<(Slot, Box<dyn Stage>)>;

/// The name of something hidden.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    /// Id of the catalogue of effects, or a name that the catalogue does not have.
    pub(super) effect: &'static str,
    /// Counted from 0; `None` for the whole arm.
    pub(super) joint: Option<usize>,
    /// In the order of the catalogue; empty where they have no counterpart there.
    pub(super) parameters: Vec<f64>,
}

/// The drive of one joint and the way of its torque to the log.
pub(super) struct JointPlan {
    /// From the servo's command to the current.
    pub(super) current: Stages,
    /// From the current to the torque of the motor.
    pub(super) motor: Stages,
    /// Between motor and link.
    pub(super) transmission: Transmission,
    /// From the torque that is logged to the log.
    pub(super) reading: Stages,
}

/// A mass that is fixed to the tip for some time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TipLoad {
    /// \[kg\]
    pub(super) mass: f64,
    /// From when until when \[s\].
    pub(super) during: [f64; 2],
}

impl TipLoad {
    /// Whether it is at the tip now.
    pub(super) fn is_carried(&self, time: f64) -> bool {
        (self.during[0]..self.during[1]).contains(&time)
    }
}

/// A body that the arm carries and that moves by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RiderPlan {
    /// \[kg\]
    pub(super) mass: f64,
    /// Which link carries it.
    pub(super) link: usize,
    /// Where on the link \[m\].
    pub(super) place: Planar,
    /// How it moves against the link.
    pub(super) freedom: Freedom,
}

/// How a rider moves against its link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Freedom {
    /// It hangs from its place on a rod of this length \[m\], with damping \[N m s/rad\].
    Swings { length: f64, damping: f64 },
    /// It slides along the link about its place, on a spring \[N/m\] with damping \[N s/m\].
    Slides { stiffness: f64, damping: f64 },
}

/// A half-plane that the tip can't enter: the floor, a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Obstacle {
    /// A point of its surface \[m\].
    pub(super) at: Planar,
    /// Out of it, towards the arm.
    pub(super) normal: Planar,
}

/// Everything that a run is built of.
pub(super) struct Plan {
    /// The arm as its maker would state it.
    pub(super) arm: Arm,
    /// How far the base leans \[rad\].
    pub(super) tilt: f64,
    /// How far each centre of mass lies beside the line of its link \[m\].
    pub(super) beside: Vec<f64>,
    /// Masses at the tip.
    pub(super) tip_loads: Vec<TipLoad>,
    /// Bodies that the arm carries.
    pub(super) riders: Vec<RiderPlan>,
    /// What stands in the way.
    pub(super) obstacles: Vec<Obstacle>,
    /// Drives and readings, one for each joint.
    pub(super) joints: Vec<JointPlan>,
    /// What acts on the bodies.
    pub(super) devices: Vec<(Slot, Box<dyn Device>)>,
    /// Where the encoders are.
    pub(super) side: Side,
    /// What is hidden.
    pub(super) hidden: Vec<Name>,
}

impl Plan {
    /// The bare arm with perfect drives and readings, and encoders on its links.
    pub(super) fn bare(arm: &Arm) -> Self {
        let joint = || JointPlan {
            current: Vec::new(),
            motor: Vec::new(),
            transmission: Transmission::default(),
            reading: Vec::new(),
        };
        Plan {
            arm: arm.clone(),
            tilt: 0.0,
            beside: vec![0.0; arm.joint_count()],
            tip_loads: Vec::new(),
            riders: Vec::new(),
            obstacles: Vec::new(),
            joints: (0..arm.joint_count()).map(|_| joint()).collect(),
            devices: Vec::new(),
            side: Side::Link,
            hidden: Vec::new(),
        }
    }

    /// Gives something that is hidden its name and its place in the count.
    pub(super) fn hide(&mut self, effect: &'static str, joint: Option<usize>, parameters: Vec<f64>) -> Slot {
        self.hidden.push(Name { effect, joint, parameters });
        self.hidden.len() - 1
    }

    /// Adds something that acts on the bodies.
    pub(super) fn act(&mut self, slot: Slot, device: impl Device + 'static) {
        self.devices.push((slot, Box::new(device)));
    }
}
