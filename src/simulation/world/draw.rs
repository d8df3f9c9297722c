//! Worlds drawn by a seed: arm, motion, sensors and what is hidden are random, within what robots have.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::course::{Course, Draws};
use super::part::{Kind, Part, Rank};
use super::{LoggedTorque, Scenario, Sensors, Servo, longest_step};
use crate::arm::{Arm, GRAVITY, Link, Posture};
use crate::progress::Monitor;
use crate::recording::Trajectory;
use crate::recording::encoders::Side;
use crate::simulation::{self, Draw, Excitation, SimulationError, demand};

/// How many draws of a part are tried before another is drawn.
const TRIES: usize = 40;
/// Shares of the joint's torque of what is there to be found.
const STRONG: [f64; 2] = [0.05, 0.2];
/// Samples in a second of a mystery.
const MYSTERY_RATE: f64 = 250.0;
/// Shares of what every robot has besides.
const WEAK: [f64; 2] = [0.003, 0.01];
/// Shares of dry and of speed friction of a geared joint: from a tenth of the least to the most that was identified on the six joints
/// of a KUKA KR 300, a Staeubli TX40 and a UR10 (RESULTS.md).
const GEARED: [f64; 2] = [0.01, 0.7];
/// How often the rotor of a geared joint counts: it goes with the square of the ratio.
const HEAVY_ROTOR: f64 = 0.3;

/// How much is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Nothing.
    None,
    /// One effect of the catalogue, of 5 to 20 % of the torque.
    Single,
    /// Two or three of those.
    Several,
    /// One or two of those, and four to eight of 0.3 to 1 %.
    Realistic,
    /// Dry and speed friction on every joint, of all sizes, as motors behind gears have it; on some joints a rotor; and none or one of
    /// those of 5 to 20 %.
    Geared,
    /// Something that the catalogue does not have, perhaps beside dry friction.
    Unknown,
}

impl Class {
    /// All of them.
    pub const ALL: [Class; 6] =
        [Class::None, Class::Single, Class::Several, Class::Realistic, Class::Geared, Class::Unknown];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Class::None => "none",
            Class::Single => "single",
            Class::Several => "several",
            Class::Realistic => "realistic",
            Class::Geared => "geared",
            Class::Unknown => "unknown",
        }
    }
}

/// The kinds of some ranks.
fn kinds(ranks: &[Rank]) -> Vec<&'static Kind> {
    Kind::ALL.iter().filter(|kind| ranks.contains(&kind.rank)).collect()
}

/// What there is to be found.
fn findable() -> Vec<&'static Kind> {
    kinds(&[Rank::Common, Rank::Findable])
}

/// A world that the seed draws. The same seed gives the same world.
///
/// # Errors
/// [`SimulationError`] if no part fits the motion that was drawn, which no seed tried so far brought about.
pub fn draw(seed: u64, class: Class) -> Result<Scenario, SimulationError> {
    let mut drawn = Drawn::new(seed)?;
    match class {
        Class::None => {}
        Class::Single => drawn.add(&findable(), 1, STRONG)?,
        Class::Several => {
            let count = 2 + drawn.random.one_of(2);
            drawn.add(&findable(), count, STRONG)?;
        }
        Class::Realistic => {
            let count = 1 + drawn.random.one_of(2);
            drawn.add(&findable(), count, STRONG)?;
            drawn.add_common()?;
        }
        Class::Geared => {
            drawn.add_gears()?;
            let count = drawn.random.one_of(2);
            drawn.add(&findable(), count, STRONG)?;
        }
        Class::Unknown => {
            drawn.add(&kinds(&[Rank::Outside]), 1, STRONG)?;
            let count = drawn.random.one_of(2);
            drawn.add(&kinds(&[Rank::Common])[..1], count, STRONG)?;
        }
    }
    Ok(drawn.scenario)
}

/// One effect of the catalogue among four to eight weak ones, in a world that the seed draws; its first part is that one. It is
/// logged no faster than somebody wants to wait for an answer.
///
/// # Errors
/// As [`draw`].
pub fn mystery(seed: u64) -> Result<Scenario, SimulationError> {
    let mut drawn = Drawn::new(seed)?;
    drawn.add(&findable(), 1, STRONG)?;
    drawn.add_common()?;
    let mut scenario = drawn.scenario;
    if let Excitation::MultiSine { rate, .. } | Excitation::Stops { rate, .. } = &mut scenario.motion {
        *rate = MYSTERY_RATE;
    }
    Ok(scenario)
}

impl Scenario {
    /// Puts parts of a kind into the world, one on each of these joints (from 0; a kind of the whole arm takes none), of about
    /// this strength: RMS of what a part does over that of its joint's torque. What is random about it is drawn by the seed; what
    /// only the way of the world tells, such as how hard a floor is touched, is as it is drawn.
    ///
    /// # Errors
    /// [`SimulationError`] if the kind can't be there, or the log can't show it.
    pub fn hide_by_strength(&mut self, kind: &Kind, joints: &[usize], strength: f64) -> Result<(), SimulationError> {
        demand("strength of the part", strength, strength > 0.0, "a finite number above 0")?;
        let places: Vec<usize> = match kind.first_joint {
            Some(_) if joints.is_empty() => return Err(SimulationError::JointMissing(kind.name)),
            Some(first) => {
                joints.iter().map(|joint| self.joint_for(kind.name, *joint, first)).collect::<Result<_, _>>()?
            }
            None => vec![0],
        };
        let course = Course::along(&self.arm, &course(self)?);
        for joint in places {
            let mut part = kind.make(joint, &course, &mut Draws::new(self.seed, Draw::World as u64));
            resize(&mut part, strength, &course);
            if !self.sensors.log(&part) {
                let joint = kind.first_joint.map(|_| joint);
                return Err(SimulationError::NoTorque { effect: kind.name, joint });
            }
            part.as_install().check()?;
            self.parts.push(part);
        }
        Ok(())
    }

    fn joint_for(&self, part: &'static str, joint: usize, first: usize) -> Result<usize, SimulationError> {
        let joints = self.arm.joint_count();
        match (first..joints).contains(&joint) {
            true => Ok(joint),
            false => Err(SimulationError::NotThere { part, joint: joint + 1, first: first + 1, joints }),
        }
    }
}

/// A world that is being drawn.
struct Drawn {
    scenario: Scenario,
    course: Course,
    random: Draws,
}

impl Drawn {
    /// With nothing hidden.
    fn new(seed: u64) -> Result<Self, SimulationError> {
        let mut random = Draws::new(seed, Draw::World as u64);
        let scenario = bare(seed, &mut random);
        let course = Course::along(&scenario.arm, &course(&scenario)?);
        Ok(Drawn { scenario, course, random })
    }

    /// So many parts more, each on any joint.
    fn add(&mut self, kinds: &[&Kind], count: usize, strength: [f64; 2]) -> Result<(), SimulationError> {
        (0..count).try_for_each(|_| self.add_on(None, kinds, strength))
    }

    /// One part more, on this joint if one is named.
    fn add_on(&mut self, joint: Option<usize>, kinds: &[&Kind], strength: [f64; 2]) -> Result<(), SimulationError> {
        let part = fitting(kinds, joint, strength, &self.course, &self.scenario, &mut self.random)?;
        self.scenario.parts.push(part);
        Ok(())
    }

    /// What motors behind gears bring along.
    fn add_gears(&mut self) -> Result<(), SimulationError> {
        let [dry, speed, rotor] = Kind::of_gears();
        for joint in 0..self.course.joint_count() {
            self.add_on(Some(joint), &dry, GEARED)?;
            self.add_on(Some(joint), &speed, GEARED)?;
            // That of the first joint is part of the rigid body.
            if joint > 0 && self.random.happens(HEAVY_ROTOR) {
                self.add_on(Some(joint), &rotor, STRONG)?;
            }
        }
        Ok(())
    }

    /// What every robot has a little of.
    fn add_common(&mut self) -> Result<(), SimulationError> {
        let count = 4 + self.random.one_of(5);
        self.add(&kinds(&[Rank::Common]), count, WEAK)
    }
}

/// Arm, motion and sensors, with nothing hidden.
fn bare(seed: u64, random: &mut Draws) -> Scenario {
    let joints = 2 + random.one_of(4);
    let link = |number: usize, random: &mut Draws| {
        let length = random.between(0.2, 0.5);
        let mass = random.between(1.5, 5.0) * 0.7f64.powi(number as i32);
        let com = length * random.between(0.3, 0.6);
        Link { mass, length, com, inertia: mass * length * length / 12.0 * random.between(0.8, 1.5) }
    };
    let links = (0..joints).map(|number| link(number, random)).collect();
    let posture = [Posture::UP, Posture::RIGHT, Posture::DOWN][random.one_of(3)];
    let trajectories = 1 + random.one_of(2);
    let duration = random.between(20.0, 40.0) / trajectories as f64;
    let rate = [250.0, 500.0, 1000.0][random.one_of(3)];
    let max_position = random.between(1.2, 2.5);
    let max_velocity = random.between(1.5, 4.0);
    let stops = |places, pause| Excitation::Stops {
        trajectories,
        duration,
        rate,
        places,
        pause,
        max_position: 0.7 * max_position,
        max_velocity,
    };
    let motion = match random.one_of(4) {
        0 => stops(1000, random.between(0.2, 0.6)),
        1 => stops(4 + random.one_of(3), random.between(0.1, 0.4)),
        _ => Excitation::MultiSine {
            trajectories,
            duration,
            rate,
            harmonics: 3 + random.one_of(5),
            lowest_frequency: 0.1,
            highest_frequency: random.between(0.6, 1.5),
            max_position,
            max_velocity,
        },
    };
    Scenario {
        name: format!("world {seed}"),
        arm: Arm { links, gravity: GRAVITY, posture },
        motion,
        servo: Servo { bandwidth: random.between(4.0, 7.0), ..Servo::default() },
        sensors: Sensors {
            encoder_resolution: Some(TAU / f64::from(1 << (14 + random.one_of(5)))),
            side: if random.happens(0.3) { Side::Motor } else { Side::Link },
            velocity: random.happens(0.5),
            velocity_noise: 0.002,
            torque: if random.happens(0.3) { LoggedTorque::Measured } else { LoggedTorque::Commanded },
            torque_noise: random.between_logarithms(0.005, 0.03),
        },
        parts: Vec::new(),
        step: longest_step(),
        seed,
        stated: false,
    }
}

/// The motion of the first run with the torque that the bare arm needs, sampled as seldom as sizing allows.
fn course(scenario: &Scenario) -> Result<Trajectory, SimulationError> {
    let mut motion = scenario.motion.clone();
    match &mut motion {
        Excitation::MultiSine { trajectories, rate, .. } | Excitation::Stops { trajectories, rate, .. } => {
            (*trajectories, *rate) = (1, 100.0);
        }
        Excitation::PaperPointToPoint { trajectories, .. } | Excitation::SuperposedSines { trajectories, .. } => {
            *trajectories = 1;
        }
    }
    let prescribed = simulation::Scenario {
        arm: scenario.arm.clone(),
        motion,
        effects: Vec::new(),
        seed: scenario.seed,
        ..simulation::Scenario::embedded()
    };
    let mut runs = prescribed.exact_runs(&Monitor::new())?;
    Ok(runs.swap_remove(0))
}

/// A part of about the wanted strength that goes with those that are there, on this joint or on any.
fn fitting(
    kinds: &[&Kind],
    joint: Option<usize>,
    [least, most]: [f64; 2],
    course: &Course,
    scenario: &Scenario,
    random: &mut Draws,
) -> Result<Part, SimulationError> {
    for _ in 0..TRIES {
        let joint = joint.unwrap_or_else(|| random.one_of(course.joint_count()));
        let mut part = kinds[random.one_of(kinds.len())].make(joint, course, random);
        resize(&mut part, random.between_logarithms(least, most), course);
        let is_alone = scenario.parts.iter().all(|other| group(other) != group(&part));
        if scenario.sensors.log(&part)
            && is_alone
            && part.as_install().is_plausible()
            && part.as_install().check().is_ok()
        {
            return Ok(part);
        }
    }
    Err(SimulationError::EmptyRegistry)
}

/// Makes a part about as strong as it is wanted: RMS of what it does over that of its joint's torque.
fn resize(part: &mut Part, wanted: f64, course: &Course) {
    // Twice, since not everything is in proportion.
    for _ in 0..2 {
        let strength = course.strength(part);
        if strength > 0.0 {
            part.as_install_mut().scale(wanted / strength);
        }
    }
}

/// Parts of one group on one joint could not be told apart, or could not both be there.
fn group(part: &Part) -> (&'static str, Option<usize>) {
    let name = match part {
        Part::DryFriction(_)
        | Part::LoadFriction(_)
        | Part::WarmingFriction(_)
        | Part::HeatingFriction(_)
        | Part::UnevenFriction(_) => "dry",
        Part::SpeedFriction(_) => "speed",
        Part::Spring(_) | Part::JointStop(_) => "spring",
        Part::ConstantTorque(_) => "constant",
        Part::Cogging(_) => "ripple",
        Part::CurrentLoop(_) | Part::TorqueFilter(_) => "lag",
        Part::TorqueConstant(_) | Part::SaturatedReading(_) => "reading",
        Part::Rotor(_) | Part::ElasticGear(_) => "gear",
        Part::BaseTilt(_) => "tilt",
        Part::LeaningLink(_) => "lean",
        Part::BiarticularSpring(_)
        | Part::Cable(_)
        | Part::DragPlate(_)
        | Part::Floor(_)
        | Part::Pendulum(_)
        | Part::Sloshing(_)
        | Part::TipLoad(_) => "outside",
    };
    (name, part.as_install().place())
}
