//! What happens in each sample: a world of rigid bodies, in which none of our formulas is used, and how its log is written.

use crate::arm::{Arm, GRAVITY, Link, Posture};
use crate::progress::Monitor;
use crate::recording::correction::Correction;
use crate::recording::{Recording, Trajectory};
use crate::simulation::world::part::{
    BaseTilt, Cable, Cogging, ConstantTorque, DryFriction, JointStop, Part, SaturatedReading, Sloshing, SpeedFriction,
    Spring, TorqueConstant,
};
use crate::simulation::world::{self, Scenario, Sensors};
use crate::simulation::{self, Excitation};

use super::form::{self, Log};

/// How a sample is made.
pub struct Recipe {
    /// Its name.
    pub name: &'static str,
    world: fn() -> Scenario,
    /// What sets the log right, which is then written wrongly: done twice it is as it was.
    set_up: Option<&'static str>,
    form: fn(&Recording) -> Log,
}

/// Of all samples, in the order of the gallery.
pub const ALL: &[Recipe] = &[
    Recipe { name: "sticky-shoulder", world: sticky_shoulder, set_up: None, form: form::csv },
    Recipe { name: "healthy-arm", world: healthy_arm, set_up: None, form: form::packed_csv },
    Recipe { name: "cold-grease", world: cold_grease, set_up: None, form: form::json_lines },
    Recipe { name: "balanced-elbow", world: balanced_elbow, set_up: None, form: form::npy },
    Recipe { name: "leaning-table", world: leaning_table, set_up: None, form: form::semicolons },
    Recipe { name: "toothed-motor", world: toothed_motor, set_up: None, form: form::own_npz },
    Recipe { name: "rubber-buffer", world: rubber_buffer, set_up: None, form: form::npz },
    Recipe { name: "new-gearbox", world: new_gearbox, set_up: None, form: form::json },
    Recipe { name: "clipped-sensor", world: clipped_sensor, set_up: None, form: form::matrices },
    Recipe { name: "nameless-logger", world: nameless_logger, set_up: None, form: form::nameless },
    Recipe { name: "mirrored-elbow", world: mirrored_elbow, set_up: Some("sign-torque@2"), form: form::tabs },
    // Nothing in the log says where zero is: what is told beside it is wrong.
    Recipe { name: "lost-zero", world: lost_zero, set_up: Some("zero=up"), form: form::structure },
    Recipe { name: "helping-spring", world: helping_spring, set_up: None, form: form::parquet },
    Recipe { name: "old-rig", world: old_rig, set_up: None, form: form::hdf5 },
    Recipe { name: "crossed-plugs", world: crossed_plugs, set_up: Some("order-torque=2,1"), form: form::pickle },
    Recipe { name: "soup-kitchen", world: soup_kitchen, set_up: None, form: form::ros_bag },
    Recipe { name: "welding-hose", world: welding_hose, set_up: None, form: form::ros_mcap },
];

/// Mass \[kg\], length \[m\], place of the centre of mass \[m\] and inertia about it \[kg m²\] of both links.
type Links = [[f64; 4]; 2];

const LARGE: Links = [[6.0, 0.45, 0.22, 0.11], [3.0, 0.40, 0.17, 0.04]];
const MIDDLE: Links = [[4.0, 0.40, 0.18, 0.06], [2.2, 0.35, 0.15, 0.025]];
const SMALL: Links = [[2.5, 0.30, 0.13, 0.02], [1.6, 0.28, 0.12, 0.011]];

fn sticky_shoulder() -> Scenario {
    let friction = DryFriction {
        joint: 0,
        torque: 3.0,
        reach: 5e-4,
        stribeck_torque: 0.0,
        stribeck_velocity: 0.1,
        asymmetry: 0.0,
    };
    swinging(11, MIDDLE, Posture::UP, vec![Part::DryFriction(friction)])
}

fn healthy_arm() -> Scenario {
    swinging(12, LARGE, Posture::RIGHT, Vec::new())
}

fn cold_grease() -> Scenario {
    let grease = SpeedFriction { joint: 1, coefficient: 1.2, exponent: 1.0 };
    swinging(15, LARGE, Posture::DOWN, vec![Part::SpeedFriction(grease)])
}

fn balanced_elbow() -> Scenario {
    let spring = Spring { joint: 1, stiffness: 2.5, cubic_stiffness: 0.0, rest: 0.3 };
    swinging(19, MIDDLE, Posture::DOWN, vec![Part::Spring(spring)])
}

fn leaning_table() -> Scenario {
    swinging(16, MIDDLE, Posture::UP, vec![Part::BaseTilt(BaseTilt { angle: 0.1 })])
}

fn toothed_motor() -> Scenario {
    let motor = Cogging { joint: 1, torque: 0.4, wave_number: 12.0, phase: 0.6 };
    let scenario = swinging(17, SMALL, Posture::RIGHT, vec![Part::Cogging(motor)]);
    Scenario { stated: true, ..at(200.0, 20.0, scenario) }
}

fn rubber_buffer() -> Scenario {
    let stop = JointStop { joint: 1, low: None, high: Some(0.9), stiffness: 30.0, damping: 0.0 };
    swinging(29, MIDDLE, Posture::RIGHT, vec![Part::JointStop(stop)])
}

fn new_gearbox() -> Scenario {
    let constant = TorqueConstant { joint: 0, error: 0.12 };
    swinging(28, LARGE, Posture::UP, vec![Part::TorqueConstant(constant)])
}

fn clipped_sensor() -> Scenario {
    let sensor = SaturatedReading { joint: 0, limit: 28.0 };
    swinging(20, LARGE, Posture::RIGHT, vec![Part::SaturatedReading(sensor)])
}

fn nameless_logger() -> Scenario {
    let pull = ConstantTorque { joint: 1, torque: 0.6, rate: 0.0 };
    swinging(27, SMALL, Posture::DOWN, vec![Part::ConstantTorque(pull)])
}

fn mirrored_elbow() -> Scenario {
    let grease = SpeedFriction { joint: 0, coefficient: 0.8, exponent: 1.0 };
    swinging(13, SMALL, Posture::UP, vec![Part::SpeedFriction(grease)])
}

fn lost_zero() -> Scenario {
    swinging(14, MIDDLE, Posture::UP, Vec::new())
}

fn helping_spring() -> Scenario {
    let spring = Spring { joint: 0, stiffness: 6.0, cubic_stiffness: 0.0, rest: -0.2 };
    at(50.0, 40.0, swinging(41, SMALL, Posture::RIGHT, vec![Part::Spring(spring)]))
}

fn old_rig() -> Scenario {
    let grease = SpeedFriction { joint: 0, coefficient: 1.5, exponent: 1.0 };
    let pull = ConstantTorque { joint: 1, torque: -0.9, rate: 0.0 };
    let parts = vec![Part::SpeedFriction(grease), Part::ConstantTorque(pull)];
    at(50.0, 40.0, swinging(42, MIDDLE, Posture::UP, parts))
}

fn crossed_plugs() -> Scenario {
    let grease = SpeedFriction { joint: 1, coefficient: 0.9, exponent: 1.0 };
    at(50.0, 40.0, swinging(43, MIDDLE, Posture::DOWN, vec![Part::SpeedFriction(grease)]))
}

fn soup_kitchen() -> Scenario {
    let soup = Sloshing { mass: 1.2, frequency: 1.5, damping_ratio: 0.05 };
    at(50.0, 40.0, stopping(21, MIDDLE, Posture::UP, vec![Part::Sloshing(soup)]))
}

fn welding_hose() -> Scenario {
    let hose = Cable { link: 1, anchor: [-0.3, 0.3], length: 0.55, stiffness: 60.0 };
    at(50.0, 40.0, swinging(32, MIDDLE, Posture::UP, vec![Part::Cable(hose)]))
}

/// An arm that swings about.
fn swinging(seed: u64, links: Links, posture: Posture, parts: Vec<Part>) -> Scenario {
    let motion = Excitation::MultiSine {
        trajectories: 1,
        duration: 40.0,
        rate: 100.0,
        harmonics: 5,
        lowest_frequency: 0.1,
        highest_frequency: 0.8,
        max_position: 1.8,
        max_velocity: 2.5,
    };
    world_of(seed, links, posture, motion, parts)
}

/// An arm that goes from place to place.
fn stopping(seed: u64, links: Links, posture: Posture, parts: Vec<Part>) -> Scenario {
    let motion = Excitation::Stops {
        trajectories: 1,
        duration: 40.0,
        rate: 100.0,
        places: 1000,
        pause: 0.3,
        max_position: 1.4,
        max_velocity: 2.5,
    };
    world_of(seed, links, posture, motion, parts)
}

/// The same, logged at another rate \[Hz\] and for another time \[s\].
fn at(hertz: f64, seconds: f64, mut scenario: Scenario) -> Scenario {
    if let Excitation::MultiSine { rate, duration, .. } | Excitation::Stops { rate, duration, .. } =
        &mut scenario.motion
    {
        (*rate, *duration) = (hertz, seconds);
    }
    scenario
}

fn world_of(seed: u64, links: Links, posture: Posture, motion: Excitation, parts: Vec<Part>) -> Scenario {
    let link = |[mass, length, com, inertia]: [f64; 4]| Link { mass, length, com, inertia };
    let arm = Arm { links: links.map(link).to_vec(), gravity: GRAVITY, posture };
    let sensors = Sensors { velocity_noise: 0.002, torque_noise: 0.01, ..Sensors::default() };
    let bare = Scenario::of(&simulation::Scenario::embedded());
    Scenario { arm, motion, sensors, parts, seed, stated: false, ..bare }
}

impl Recipe {
    /// The files of the log and the seal, with their names.
    ///
    /// # Errors
    /// If a world can't be simulated or a file can't be written; none of those here.
    pub fn make(&self, monitor: &Monitor) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
        let mut recording = world::simulate(&(self.world)(), monitor)?;
        recording.name = self.name.to_owned();
        recording.trajectories = recording.trajectories.into_iter().map(single).collect();
        if let Some(text) = self.set_up {
            let correction: Correction = text.parse()?;
            correction.apply(&mut recording)?;
            recording.seal = recording.seal.map(|seal| seal.with_set_up(vec![correction])).transpose()?;
        }
        let log = (self.form)(&recording)?;
        let seal = recording.seal.map(|seal| (".sealed", seal.as_bytes().to_vec()));
        Ok(log.into_iter().chain(seal).map(|(ending, bytes)| (format!("{}{ending}", self.name), bytes)).collect())
    }
}

/// As loggers keep numbers, in single precision: half as large when packed.
fn single(mut run: Trajectory) -> Trajectory {
    let mut channels = run.channels_mut();
    for signal in [&mut channels.q, &mut channels.qd, &mut channels.qdd, &mut channels.tau] {
        signal.values_mut().iter_mut().for_each(|value| *value = f64::from(*value as f32));
    }
    run
}
