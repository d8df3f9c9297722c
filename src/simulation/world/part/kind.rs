//! The kinds of parts by name: each is made for the way that an arm is to go, and then as strong as it is wanted.

use super::{
    BaseTilt, BiarticularSpring, Cable, Cogging, ConstantTorque, CurrentLoop, DragPlate, DryFriction, ElasticGear,
    Floor, HeatingFriction, JointStop, LeaningLink, LoadFriction, Part, Pendulum, Rotor, SaturatedReading, Sloshing,
    SpeedFriction, Spring, TipLoad, TorqueConstant, TorqueFilter, UnevenFriction, WarmingFriction,
};
use crate::simulation::world::course::{Course, Draws};

/// Makes a part at a joint; how strong it is, is for later.
type Maker = fn(usize, &Course, &mut Draws) -> Part;

/// Something that can be put into a world.
#[derive(Debug)]
pub struct Kind {
    /// Its name on the command line.
    pub id: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// Who has it.
    pub rank: Rank,
    /// The first joint on which it can be, counted from 0; `None` if it is of the whole arm.
    pub first_joint: Option<usize>,
    make: Maker,
}

/// Who has a kind of part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// Every robot has a little of it; the catalogue of effects describes it.
    Common,
    /// Some robots have it; the catalogue of effects describes it.
    Findable,
    /// The catalogue of effects does not describe it.
    Outside,
}

impl Kind {
    /// All of them. Draws go by their order.
    pub const ALL: &[Kind] = &[
        at_joint(Rank::Common, "coulomb-friction", "dry friction", |joint, course, random| {
            Part::DryFriction(DryFriction::coulomb(joint, course, random))
        }),
        at_joint(Rank::Common, "stribeck-friction", "dry friction that is more at rest", |joint, course, random| {
            Part::DryFriction(DryFriction::stribeck(joint, course, random))
        }),
        at_joint(Rank::Findable, "asymmetric-friction", "dry friction of two sizes", |joint, course, random| {
            Part::DryFriction(DryFriction::asymmetric(joint, course, random))
        }),
        at_joint(Rank::Findable, "dahl-friction", "friction with soft bristles", |joint, course, random| {
            Part::DryFriction(DryFriction::dahl(joint, course, random))
        }),
        at_joint(Rank::Findable, "lugre-friction", "friction with bristles, more at rest", |joint, course, random| {
            Part::DryFriction(DryFriction::lugre(joint, course, random))
        }),
        at_joint(Rank::Findable, "load-friction", "friction that grows with the load", |joint, course, random| {
            Part::LoadFriction(LoadFriction::drawn(joint, course, random))
        }),
        at_joint(Rank::Findable, "warming-friction", "friction that warms up", |joint, course, random| {
            Part::WarmingFriction(WarmingFriction::drawn(joint, course, random))
        }),
        at_joint(Rank::Findable, "heating-friction", "friction that its own heat lowers", |joint, course, random| {
            Part::HeatingFriction(HeatingFriction::drawn(joint, course, random))
        }),
        at_joint(Rank::Findable, "uneven-friction", "friction that changes with the angle", |joint, course, random| {
            Part::UnevenFriction(UnevenFriction::drawn(joint, course, random))
        }),
        at_joint(Rank::Common, "viscous-friction", "viscous friction", |joint, course, random| {
            Part::SpeedFriction(SpeedFriction::viscous(joint, course, random))
        }),
        at_joint(Rank::Common, "quadratic-friction", "friction by the square of speed", |joint, course, random| {
            Part::SpeedFriction(SpeedFriction::quadratic(joint, course, random))
        }),
        at_joint(Rank::Findable, "thinning-friction", "grease that thins with speed", |joint, course, random| {
            Part::SpeedFriction(SpeedFriction::thinning(joint, course, random))
        }),
        at_joint(Rank::Common, "spring", "spring in a joint", |joint, course, random| {
            Part::Spring(Spring::linear(joint, course, random))
        }),
        at_joint(Rank::Findable, "hardening-spring", "spring that hardens", |joint, course, random| {
            Part::Spring(Spring::hardening(joint, course, random))
        }),
        at_joint(Rank::Findable, "joint-stop", "end stop of a joint", |joint, course, random| {
            Part::JointStop(JointStop::drawn(joint, course, random))
        }),
        at_joint(Rank::Common, "torque-offset", "steady torque", |joint, course, random| {
            Part::ConstantTorque(ConstantTorque::steady(joint, course, random))
        }),
        at_joint(Rank::Findable, "torque-drift", "torque that drifts", |joint, course, random| {
            Part::ConstantTorque(ConstantTorque::drifting(joint, course, random))
        }),
        at_joint(Rank::Common, "cogging", "ripple of the motor", |joint, course, random| {
            Part::Cogging(Cogging::drawn(joint, course, random))
        }),
        at_joint(Rank::Common, "torque-constant", "wrong torque constant", |joint, course, random| {
            Part::TorqueConstant(TorqueConstant::drawn(joint, course, random))
        }),
        at_joint(Rank::Common, "current-loop", "current that comes late", |joint, course, random| {
            Part::CurrentLoop(CurrentLoop::drawn(joint, course, random))
        }),
        at_joint(Rank::Findable, "torque-filter", "torque reading that comes late", |joint, course, random| {
            Part::TorqueFilter(TorqueFilter::drawn(joint, course, random))
        }),
        at_joint(Rank::Findable, "saturated-reading", "torque reading that is cut off", |joint, course, random| {
            Part::SaturatedReading(SaturatedReading::drawn(joint, course, random))
        }),
        // The rotor of the first joint is part of the rigid body.
        from_second(Rank::Findable, "rotor", "rotor behind a stiff gear", |joint, course, random| {
            Part::Rotor(Rotor::drawn(joint, course, random))
        }),
        at_joint(Rank::Findable, "elastic-gear", "elastic gear", |joint, course, random| {
            Part::ElasticGear(ElasticGear::elastic(joint, course, random))
        }),
        at_joint(Rank::Findable, "backlash", "backlash", |joint, course, random| {
            Part::ElasticGear(ElasticGear::with_play(joint, course, random))
        }),
        of_arm(Rank::Common, "base-tilt", "tilted base", |joint, course, random| {
            Part::BaseTilt(BaseTilt::drawn(joint, course, random))
        }),
        at_joint(Rank::Common, "leaning-link", "centre of mass beside the link", |joint, course, random| {
            Part::LeaningLink(LeaningLink::drawn(joint, course, random))
        }),
        of_arm(
            Rank::Outside,
            "drag-plate",
            "plate on the last link that the air holds back",
            |joint, course, random| Part::DragPlate(DragPlate::drawn(joint, course, random)),
        ),
        of_arm(Rank::Outside, "cable", "cable to the last link", |joint, course, random| {
            Part::Cable(Cable::drawn(joint, course, random))
        }),
        from_second(Rank::Outside, "biarticular-spring", "spring over two joints", |joint, course, random| {
            Part::BiarticularSpring(BiarticularSpring::drawn(joint, course, random))
        }),
        of_arm(Rank::Outside, "pendulum", "payload that swings", |joint, course, random| {
            Part::Pendulum(Pendulum::drawn(joint, course, random))
        }),
        of_arm(Rank::Outside, "sloshing", "liquid in the last link", |joint, course, random| {
            Part::Sloshing(Sloshing::drawn(joint, course, random))
        }),
        of_arm(Rank::Outside, "payload", "payload that is picked up and put down", |joint, course, random| {
            Part::TipLoad(TipLoad::picked_up(joint, course, random))
        }),
        of_arm(Rank::Outside, "floor", "floor that the tip touches", |joint, course, random| {
            Part::Floor(Floor::drawn(joint, course, random))
        }),
    ];

    /// What motors behind gears bring along: kinds of dry friction, of speed friction, and their rotors.
    pub(in crate::simulation::world) fn of_gears() -> [Vec<&'static Kind>; 3] {
        let ids: [&[&str]; 3] =
            [&["coulomb-friction", "stribeck-friction"], &["viscous-friction", "thinning-friction"], &["rotor"]];
        ids.map(|ids| Kind::ALL.iter().filter(|kind| ids.contains(&kind.id)).collect())
    }

    /// The kind of this name on the command line.
    pub fn find(id: &str) -> Option<&'static Kind> {
        Kind::ALL.iter().find(|kind| kind.id == id)
    }

    /// A part of this kind, on a joint or the first that can have it; how strong it is, is for later.
    pub(in crate::simulation::world) fn make(&self, joint: usize, course: &Course, random: &mut Draws) -> Part {
        (self.make)(joint.max(self.first_joint.unwrap_or(0)), course, random)
    }
}

const fn at_joint(rank: Rank, id: &'static str, name: &'static str, make: Maker) -> Kind {
    Kind { id, name, rank, first_joint: Some(0), make }
}

const fn from_second(rank: Rank, id: &'static str, name: &'static str, make: Maker) -> Kind {
    Kind { id, name, rank, first_joint: Some(1), make }
}

const fn of_arm(rank: Rank, id: &'static str, name: &'static str, make: Maker) -> Kind {
    Kind { id, name, rank, first_joint: None, make }
}
