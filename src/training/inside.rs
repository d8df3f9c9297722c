//! What a model has learned, looked into: H, V, g and c over a slice of the configuration space, and energy and power along a run.
//!
//! All of it is read off the model's inertial, Coriolis and gravity torque ([`components`]) at motions that are made for it, so
//! that it means the same for a rigid body, a Lagrangian network, a network without physics, and the true arm:
//! H(q) eⱼ is the inertial torque of the acceleration eⱼ, ½ q̇ᵀ H q̇ that of the acceleration q̇ times ½ q̇, and V is the work
//! against gravity.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{TrainError, components};
use crate::arm::Arm;
use crate::model::Fitted;
use crate::recording::{Channels, Trajectory};
use crate::signals::Signals;
use crate::statistics::integral;

/// How many places of a slice are looked at.
const PLACES: usize = 181;
/// Time between the samples of a motion that is only made to ask the model \[s\].
const STEP: f64 = 0.01;

/// How long an arm is watched that was let go, and in which steps.
const FALL_STEPS: usize = 375;
const FALL_STEP: f64 = 0.004;
/// No arm moves as fast as this \[rad/s or m/s\].
pub(super) const RUNS_AWAY: f64 = 200.0;

/// One joint goes from here to there, the others stand.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    /// The joint that goes, counted from 0.
    pub joint: usize,
    /// From where to where \[rad or m\].
    pub range: [f64; 2],
    /// Where the joints stand \[rad or m\]; that of the joint which goes is not used.
    pub posture: Vec<f64>,
    /// With which velocities c is asked for \[rad/s or m/s\].
    pub velocity: Vec<f64>,
}

/// What a model has at the places of a slice.
#[derive(Debug, Clone, PartialEq)]
pub struct Inside {
    /// Where the joint stands \[rad or m\].
    pub places: Vec<f64>,
    /// H(q), one signal for each element, row after row \[kg m²\].
    pub mass: Signals,
    /// Its eigenvalues, the smallest first \[kg m²\]; of its symmetric part, if it is not symmetric.
    pub eigenvalues: Signals,
    /// c(q, q̇) at the velocities of the slice \[N m\].
    pub coriolis: Signals,
    /// g(q) \[N m\].
    pub gravity: Signals,
    /// V(q) \[J\], 0 at the first place.
    pub potential: Vec<f64>,
}

/// Energy and power along a run, one value for each sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// ½ q̇ᵀ H(q) q̇ \[J\].
    pub kinetic: Vec<f64>,
    /// V \[J\], 0 at the beginning.
    pub potential: Vec<f64>,
    /// How fast both together change, Σ q̇ (H q̈ + c + g) \[W\].
    pub change: Vec<f64>,
}

/// Inertial, Coriolis and gravity torque along a motion.
type Parts = [Signals; 3];

fn parts_of_model(fitted: &Fitted, motion: &Trajectory) -> Result<Parts, TrainError> {
    let mut named = components(fitted, motion)?;
    let mut take = |name: &str| {
        let place = named.iter().position(|(known, _)| *known == name);
        place.map_or_else(Signals::default, |place| named.swap_remove(place).1)
    };
    Ok([take("inertial"), take("coriolis"), take("gravity")])
}

fn parts_of_arm(arm: &Arm, motion: &Trajectory) -> Parts {
    let parts = arm.components_along(&motion.q, &motion.qd, &motion.qdd);
    [parts.inertial, parts.coriolis, parts.gravity]
}

impl Inside {
    /// Of a model.
    ///
    /// # Errors
    /// [`TrainError`] if the slice is of another arm.
    pub fn of_model(fitted: &Fitted, slice: &Slice) -> Result<Self, TrainError> {
        Ok(Self::from_parts(slice, &parts_of_model(fitted, &slice.motion()?)?))
    }

    /// Of an arm that is known.
    ///
    /// # Errors
    /// [`TrainError`] if the slice is of another arm.
    pub fn of_arm(arm: &Arm, slice: &Slice) -> Result<Self, TrainError> {
        Ok(Self::from_parts(slice, &parts_of_arm(arm, &slice.motion()?)))
    }

    fn from_parts(slice: &Slice, [inertial, coriolis, gravity]: &Parts) -> Self {
        let n = slice.posture.len();
        let (places, asked) = (slice.places(), n + 1);
        let mass = Signals::from_fn(n * n, places.len(), |entry, place| inertial[entry / n][place * asked + entry % n]);
        let of_last =
            |parts: &Signals| Signals::from_fn(n, places.len(), |joint, place| parts[joint][place * asked + n]);
        let (coriolis, gravity) = (of_last(coriolis), of_last(gravity));
        let potential = integral(&gravity[slice.joint], &places);
        Inside { eigenvalues: eigenvalues(&mass, n), places, mass, coriolis, gravity, potential }
    }
}

impl Slice {
    /// Where the joint stands.
    fn places(&self) -> Vec<f64> {
        let [from, to] = self.range;
        (0..PLACES).map(|place| from + (to - from) * place as f64 / (PLACES - 1) as f64).collect()
    }

    fn motion(&self) -> Result<Trajectory, TrainError> {
        let posture = |place: f64| {
            let mut posture = self.posture.clone();
            posture[self.joint] = place;
            posture
        };
        questions(&self.places().into_iter().map(posture).collect::<Vec<_>>(), &self.velocity)
    }
}

/// In each posture a unit acceleration of each joint at rest, then the velocities without acceleration.
fn questions(postures: &[Vec<f64>], velocity: &[f64]) -> Result<Trajectory, TrainError> {
    let n = velocity.len();
    let asked = n + 1;
    let count = postures.len() * asked;
    let signal = |value: &dyn Fn(usize, usize, usize) -> f64| {
        Signals::from_fn(n, count, |joint, sample| value(joint, sample / asked, sample % asked))
    };
    Ok(Trajectory::new(
        "questions",
        Channels {
            time: (0..count).map(|sample| sample as f64 * STEP).collect(),
            q: signal(&|joint, place, _| postures[place][joint]),
            qd: signal(&|joint, _, asked| if asked == n { velocity[joint] } else { 0.0 }),
            qdd: signal(&|joint, _, asked| if asked == joint { 1.0 } else { 0.0 }),
            tau: Signals::zeros(n, count),
        },
    )?)
}

/// An arm that is let go at rest: it falls as its H, c and g say, without motors and friction. It ends early if it runs away.
#[derive(Debug, Clone, PartialEq)]
pub struct Fall {
    /// \[s\]
    pub time: Vec<f64>,
    /// Positions \[rad or m\], one signal for each joint.
    pub q: Signals,
}

impl Fall {
    /// Of a model.
    ///
    /// # Errors
    /// [`TrainError`] if the posture is of another arm.
    pub fn of_model(fitted: &Fitted, posture: &[f64]) -> Result<Self, TrainError> {
        Self::by(posture, |motion| parts_of_model(fitted, motion))
    }

    /// Of an arm that is known.
    ///
    /// # Errors
    /// [`TrainError`] if the posture is of another arm.
    pub fn of_arm(arm: &Arm, posture: &[f64]) -> Result<Self, TrainError> {
        Self::by(posture, |motion| Ok(parts_of_arm(arm, motion)))
    }

    /// By steps that take the new velocity for the way, which neither feed nor brake it much.
    fn by(posture: &[f64], parts: impl Fn(&Trajectory) -> Result<Parts, TrainError>) -> Result<Self, TrainError> {
        let (mut q, mut qd) = (posture.to_vec(), vec![0.0; posture.len()]);
        let mut passed = vec![q.clone()];
        for _ in 0..FALL_STEPS {
            let parts = parts(&questions(&[q.clone()], &qd)?)?;
            let Some(acceleration) = free_acceleration(&parts, q.len()) else { break };
            for (joint, acceleration) in acceleration.into_iter().enumerate() {
                qd[joint] += FALL_STEP * acceleration;
                q[joint] += FALL_STEP * qd[joint];
            }
            if qd.iter().any(|speed| speed.is_nan() || speed.abs() >= RUNS_AWAY) {
                break;
            }
            passed.push(q.clone());
        }
        let time = (0..passed.len()).map(|step| step as f64 * FALL_STEP).collect();
        Ok(Fall { time, q: Signals::from_fn(q.len(), passed.len(), |joint, step| passed[step][joint]) })
    }
}

/// −H⁻¹ (c + g), as one posture was asked for; `None` if H has no inverse.
fn free_acceleration([inertial, coriolis, gravity]: &Parts, n: usize) -> Option<Vec<f64>> {
    let mass = DMatrix::from_fn(n, n, |row, column| inertial[row][column]);
    let torque = DVector::from_fn(n, |joint, _| -coriolis[joint][n] - gravity[joint][n]);
    mass.lu().solve(&torque).map(|acceleration| acceleration.as_slice().to_vec())
}

impl Balance {
    /// Of a model along a run.
    ///
    /// # Errors
    /// [`TrainError`] if the run is of another arm.
    pub fn of_model(fitted: &Fitted, run: &Trajectory) -> Result<Self, TrainError> {
        let (own, moving) = (parts_of_model(fitted, run)?, parts_of_model(fitted, &momentum_of(run)?)?);
        Ok(Self::from_parts(run, &own, &moving))
    }

    /// Of an arm that is known.
    ///
    /// # Errors
    /// [`TrainError`] if the run is of another arm.
    pub fn of_arm(arm: &Arm, run: &Trajectory) -> Result<Self, TrainError> {
        Ok(Self::from_parts(run, &parts_of_arm(arm, run), &parts_of_arm(arm, &momentum_of(run)?)))
    }

    fn from_parts(run: &Trajectory, [inertial, coriolis, gravity]: &Parts, [momentum, ..]: &Parts) -> Self {
        let with_velocity = |torque: &Signals| power(torque, run);
        let against_gravity = with_velocity(gravity);
        let rest = with_velocity(inertial).into_iter().zip(with_velocity(coriolis));
        Balance {
            kinetic: with_velocity(momentum).into_iter().map(|double| 0.5 * double).collect(),
            potential: integral(&against_gravity, &run.time),
            change: rest
                .zip(&against_gravity)
                .map(|((inertial, coriolis), gravity)| inertial + coriolis + gravity)
                .collect(),
        }
    }
}

impl Balance {
    /// What became of the energy that this power \[W\] put in and that is not there: what was lost so far, at each sample \[J\].
    pub fn lost(&self, power: &[f64], time: &[f64]) -> Vec<f64> {
        let energy = |sample: usize| self.kinetic[sample] + self.potential[sample];
        integral(power, time)
            .into_iter()
            .enumerate()
            .map(|(sample, put_in)| put_in - energy(sample) + energy(0))
            .collect()
    }
}

/// Σ τ q̇ at each sample \[W\].
pub fn power(torque: &Signals, run: &Trajectory) -> Vec<f64> {
    let at = |sample: usize| torque.at(sample).zip(run.qd.at(sample)).map(|(torque, velocity)| torque * velocity).sum();
    (0..run.len()).map(at).collect()
}

/// A run that stands still with its velocity for an acceleration: its inertial torque is the momentum H q̇.
fn momentum_of(run: &Trajectory) -> Result<Trajectory, TrainError> {
    let still = Signals::zeros(run.joint_count(), run.len());
    Ok(Trajectory::new(&run.name, Channels { qd: still, qdd: run.qd.clone(), ..Channels::clone(run) })?)
}

/// Eigenvalues of the symmetric parts of n × n matrices, the smallest first.
fn eigenvalues(mass: &Signals, n: usize) -> Signals {
    let mut all = Signals::zeros(n, mass.sample_count());
    for place in 0..mass.sample_count() {
        let at = |row: usize, column: usize| 0.5 * (mass[row * n + column][place] + mass[column * n + row][place]);
        let mut values = SymmetricEigen::new(DMatrix::from_fn(n, n, at)).eigenvalues;
        values.as_mut_slice().sort_by(f64::total_cmp);
        (0..n).for_each(|index| all[index][place] = values[index]);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    fn close(one: &[f64], other: &[f64], tolerance: f64) -> bool {
        one.len() == other.len() && one.iter().zip(other).all(|(one, other)| (one - other).abs() < tolerance)
    }

    /// A rod that hangs from its joint and is let go at its side swings like the pendulum of its length.
    #[test]
    fn an_arm_that_is_let_go_swings() {
        let arm = Arm::uniform(1);
        let down = -std::f64::consts::FRAC_PI_2 - arm.posture.zero_angle;
        let fall = Fall::of_arm(&arm, &[down + 0.1]).unwrap();
        // A uniform rod of 1 m: ω² = 3 g / (2 l).
        let omega = (1.5 * arm.gravity).sqrt();
        for (time, q) in fall.time.iter().zip(&fall.q[0]) {
            assert!((q - down - 0.1 * (omega * time).cos()).abs() < 4e-3, "{q} at {time} s");
        }
        assert_eq!(fall.time.len(), FALL_STEPS + 1);
    }

    /// A body that is identified from exact data is the arm, which knows its mass matrix and energies by formulas of its own.
    #[test]
    fn what_is_read_off_a_body_is_that_of_the_arm() {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 400, range: 3.0 };
        let scenario = Scenario { effects: Vec::new(), torque_noise: 0.0, motion, ..Scenario::embedded() };
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let preset = Preset::RigidBody.model(&recording).unwrap();
        let fitted = model::fit(&preset, &recording, &Split::automatic(&recording), &Monitor::new()).unwrap();
        let arm = &scenario.arm;
        let slice =
            Slice { joint: 1, range: [-1.0, 2.0], posture: vec![0.3, 0.0, -0.7], velocity: vec![1.0, -2.0, 0.5] };
        let (own, truth) = (Inside::of_model(&fitted, &slice).unwrap(), Inside::of_arm(arm, &slice).unwrap());
        assert!(close(own.mass.values(), truth.mass.values(), 1e-6));
        assert!(close(own.coriolis.values(), truth.coriolis.values(), 1e-6));
        assert!(close(own.eigenvalues.values(), truth.eigenvalues.values(), 1e-6));
        assert!(truth.eigenvalues.values().iter().all(|value| *value > 0.0), "an arm has only positive ones");
        let posture = |place: f64| [0.3, place, -0.7];
        let first = arm.potential_energy(&posture(-1.0));
        let exact: Vec<f64> = own.places.iter().map(|place| arm.potential_energy(&posture(*place)) - first).collect();
        assert!(close(&own.potential, &exact, 1e-2), "{:?} {:?}", &own.potential[170..], &exact[170..]);

        let run = &recording.trajectories[0];
        let balance = Balance::of_model(&fitted, run).unwrap();
        let state = |signal: &Signals, sample: usize| signal.at(sample).collect::<Vec<f64>>();
        let kinetic: Vec<f64> =
            (0..run.len()).map(|t| arm.kinetic_energy(&state(&run.q, t), &state(&run.qd, t))).collect();
        assert!(close(&balance.kinetic, &kinetic, 1e-6));
        // Without friction all power that goes in is found in the energy.
        assert!(close(&balance.change, &power(&run.tau, run), 1e-6));
        let gained = integral(&balance.change, &run.time);
        let last = run.len() - 1;
        let energy = balance.kinetic[last] - balance.kinetic[0] + balance.potential[last];
        assert!((gained[last] - energy).abs() < 1e-2, "{} J went in, {energy} J are there", gained[last]);
        // A brake that takes 3 W is all that is lost.
        let braked: Vec<f64> = power(&run.tau, run).into_iter().map(|power| power + 3.0).collect();
        let (lost, seconds) = (balance.lost(&braked, &run.time)[last], run.time[last] - run.time[0]);
        assert!((lost - 3.0 * seconds).abs() < 1e-2, "{lost} J in {seconds} s");
    }
}
