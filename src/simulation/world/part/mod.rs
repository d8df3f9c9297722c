//! What is in a world besides the bare arm: one file a part, and one line in [`Part`].
//!
//! A part *installs* itself in the plan of a run: as a device that acts on the bodies, as a stage that a torque passes in the
//! drive or on its way to the log, or as a change of the bodies. It gives its name there, in the words of the catalogue of
//! effects where that has some; what it really does is counted under that name while the world moves.

mod base_tilt;
mod biarticular_spring;
mod bristle;
mod cable;
mod cogging;
mod constant_torque;
mod current_loop;
mod drag_plate;
mod dry_friction;
mod elastic_gear;
mod floor;
mod heating_friction;
mod joint_stop;
mod kind;
mod leaning_link;
mod load_friction;
mod low_pass;
mod pendulum;
mod rotor;
mod saturated_reading;
mod sloshing;
mod speed_friction;
mod spring;
mod tip_load;
mod torque_constant;
mod torque_filter;
mod uneven_friction;
mod warming_friction;

use serde::{Deserialize, Serialize};

pub use base_tilt::BaseTilt;
pub use biarticular_spring::BiarticularSpring;
pub use cable::Cable;
pub use cogging::Cogging;
pub use constant_torque::ConstantTorque;
pub use current_loop::CurrentLoop;
pub use drag_plate::DragPlate;
pub use dry_friction::DryFriction;
pub use elastic_gear::ElasticGear;
pub use floor::Floor;
pub use heating_friction::HeatingFriction;
pub use joint_stop::JointStop;
pub use kind::{Kind, Rank};
pub use leaning_link::LeaningLink;
pub use load_friction::LoadFriction;
pub use pendulum::Pendulum;
pub use rotor::Rotor;
pub use saturated_reading::SaturatedReading;
pub use sloshing::Sloshing;
pub use speed_friction::SpeedFriction;
pub use spring::Spring;
pub use tip_load::TipLoad;
pub use torque_constant::TorqueConstant;
pub use torque_filter::TorqueFilter;
pub use uneven_friction::UnevenFriction;
pub use warming_friction::WarmingFriction;

use super::plan::Plan;
use crate::simulation::SimulationError;

/// Something in the world besides the bare arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs)] // each type says what it is
pub enum Part {
    BaseTilt(BaseTilt),
    BiarticularSpring(BiarticularSpring),
    Cable(Cable),
    Cogging(Cogging),
    ConstantTorque(ConstantTorque),
    CurrentLoop(CurrentLoop),
    DragPlate(DragPlate),
    DryFriction(DryFriction),
    ElasticGear(ElasticGear),
    Floor(Floor),
    HeatingFriction(HeatingFriction),
    JointStop(JointStop),
    LeaningLink(LeaningLink),
    LoadFriction(LoadFriction),
    Pendulum(Pendulum),
    Rotor(Rotor),
    SaturatedReading(SaturatedReading),
    Sloshing(Sloshing),
    SpeedFriction(SpeedFriction),
    Spring(Spring),
    TipLoad(TipLoad),
    TorqueConstant(TorqueConstant),
    TorqueFilter(TorqueFilter),
    UnevenFriction(UnevenFriction),
    WarmingFriction(WarmingFriction),
}

/// What every part can do.
pub(super) trait Install {
    /// Puts it into the plan of a run.
    fn install(&self, plan: &mut Plan);

    /// Makes it so many times as strong.
    fn scale(&mut self, factor: f64);

    /// The last joint or link that it touches, counted from 0; `None` for the whole arm.
    fn place(&self) -> Option<usize> {
        None
    }

    /// Whether a robot could have it so strong.
    fn is_plausible(&self) -> bool {
        true
    }

    /// Checks its numbers.
    fn check(&self) -> Result<(), SimulationError>;
}

/// Evaluates an expression for the part inside, whichever it is.
macro_rules! of_part {
    ($part:expr, $inner:ident => $value:expr) => {
        match $part {
            Part::BaseTilt($inner) => $value,
            Part::BiarticularSpring($inner) => $value,
            Part::Cable($inner) => $value,
            Part::Cogging($inner) => $value,
            Part::ConstantTorque($inner) => $value,
            Part::CurrentLoop($inner) => $value,
            Part::DragPlate($inner) => $value,
            Part::DryFriction($inner) => $value,
            Part::ElasticGear($inner) => $value,
            Part::Floor($inner) => $value,
            Part::HeatingFriction($inner) => $value,
            Part::JointStop($inner) => $value,
            Part::LeaningLink($inner) => $value,
            Part::LoadFriction($inner) => $value,
            Part::Pendulum($inner) => $value,
            Part::Rotor($inner) => $value,
            Part::SaturatedReading($inner) => $value,
            Part::Sloshing($inner) => $value,
            Part::SpeedFriction($inner) => $value,
            Part::Spring($inner) => $value,
            Part::TipLoad($inner) => $value,
            Part::TorqueConstant($inner) => $value,
            Part::TorqueFilter($inner) => $value,
            Part::UnevenFriction($inner) => $value,
            Part::WarmingFriction($inner) => $value,
        }
    };
}

impl Part {
    pub(super) fn as_install(&self) -> &dyn Install {
        of_part!(self, part => part)
    }

    pub(super) fn as_install_mut(&mut self) -> &mut dyn Install {
        of_part!(self, part => part)
    }
}

/// Joints and links count from 1 in files, as people do, and from 0 here.
mod from_one {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(joint: &usize, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u64(*joint as u64 + 1)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
        let number = usize::deserialize(deserializer)?;
        number.checked_sub(1).ok_or_else(|| D::Error::custom("joints and links are counted from 1"))
    }
}

/// How far dry friction gives before it slides where a file does not say \[rad\]: the teeth and bearings of a gear.
fn short_reach() -> f64 {
    5e-4
}
