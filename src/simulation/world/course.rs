//! The way that an arm is to go, and how strong a part would be on it. Only draws need it: a world moves as it moves.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::moment::{Forces, Moment, Planar};
use super::part::Part;
use super::plan::{Plan, Stages};
use crate::arm::Arm;
use crate::recording::Trajectory;
use crate::statistics::ends;

/// A prescribed motion with the torque that the bare arm needs for it.
pub(super) struct Course {
    arm: Arm,
    moments: Vec<Moment>,
}

impl Course {
    /// Along a motion whose torque is that of the bare arm.
    pub(super) fn along(arm: &Arm, motion: &Trajectory) -> Self {
        let step = motion.time_step();
        let mut moment = Moment::new(arm, 0.0, step);
        let at = |sample: usize| {
            moment.time = motion.time[sample];
            for joint in 0..arm.joint_count() {
                moment.q[joint] = motion.q[joint][sample];
                moment.qd[joint] = motion.qd[joint][sample];
                moment.qdd[joint] = motion.qdd[joint][sample];
                moment.sent[joint] = motion.tau[joint][sample];
            }
            moment.place_links();
            moment.clone()
        };
        Course { arm: arm.clone(), moments: (0..motion.len()).map(at).collect() }
    }

    /// How strong a part is: RMS of what it would do over RMS of the bare arm's torque, on the joint where that is most.
    pub(super) fn strength(&self, part: &Part) -> f64 {
        let mut plan = Plan::bare(&self.arm);
        part.as_install().install(&mut plan);
        let joints = self.joint_count();
        let mut done = vec![0.0; joints];
        let mut forces = Forces::none(joints);
        for now in &self.moments {
            let mut sum = vec![0.0; joints];
            for (_, device) in &mut plan.devices {
                forces.clear();
                device.act(now, &mut forces);
                (0..joints).for_each(|joint| sum[joint] += forces.needed(now, joint));
            }
            for (joint, plan) in plan.joints.iter_mut().enumerate() {
                let stages = [&mut plan.current, &mut plan.motor, &mut plan.reading];
                sum[joint] += stages.map(|stages| change(stages, now, now.sent[joint])).iter().sum::<f64>();
            }
            done.iter_mut().zip(sum).for_each(|(done, sum)| *done += sum * sum);
        }
        let share = |joint: usize| (done[joint] / self.sum(|now| now.sent[joint].powi(2))).sqrt();
        (0..joints).map(share).fold(0.0, f64::max)
    }

    /// How many joints the arm has.
    pub(super) fn joint_count(&self) -> usize {
        self.arm.joint_count()
    }

    /// How long it lasts \[s\].
    pub(super) fn duration(&self) -> f64 {
        self.moments.last().map_or(0.0, |last| last.time)
    }

    /// Least and greatest position of a joint \[rad\].
    pub(super) fn ends(&self, joint: usize) -> [f64; 2] {
        ends(self.moments.iter().map(|now| now.q[joint]))
    }

    /// How far a joint goes \[rad\].
    pub(super) fn range(&self, joint: usize) -> f64 {
        let [least, most] = self.ends(joint);
        most - least
    }

    /// Halfway between the ends \[rad\].
    pub(super) fn middle(&self, joint: usize) -> f64 {
        let [least, most] = self.ends(joint);
        0.5 * (least + most)
    }

    /// RMS of a joint's velocity \[rad/s\].
    pub(super) fn speed(&self, joint: usize) -> f64 {
        (self.sum(|now| now.qd[joint].powi(2)) / self.moments.len() as f64).sqrt()
    }

    /// Largest torque of a joint \[N m\].
    pub(super) fn largest_torque(&self, joint: usize) -> f64 {
        self.moments.iter().fold(0.0, |most, now| f64::max(most, now.sent[joint].abs()))
    }

    /// Mean inertia about a joint \[kg m²\].
    pub(super) fn inertia(&self, joint: usize) -> f64 {
        let some: Vec<&Moment> = self.moments.iter().step_by(self.moments.len().div_ceil(50).max(1)).collect();
        let sum: f64 = some.iter().map(|now| self.arm.mass_matrix(&now.q)[(joint, joint)]).sum();
        sum / some.len() as f64
    }

    /// How far the arm reaches \[m\].
    pub(super) fn reach(&self) -> f64 {
        self.arm.links.iter().map(|link| link.length).sum()
    }

    /// Nearest and farthest that the end of a link comes to a place \[m\].
    pub(super) fn distances(&self, link: usize, place: Planar) -> [f64; 2] {
        ends(self.places(link).map(|[x, z]| (x - place[0]).hypot(z - place[1])))
    }

    /// Lowest and highest place of the tip \[m\].
    pub(super) fn heights(&self) -> [f64; 2] {
        ends(self.places(self.joint_count() - 1).map(|[_, z]| z))
    }

    fn places(&self, link: usize) -> impl Iterator<Item = Planar> {
        let end = [self.arm.links[link].length, 0.0];
        self.moments.iter().map(move |now| now.links[link].point(end).at)
    }

    fn sum(&self, value: impl Fn(&Moment) -> f64) -> f64 {
        self.moments.iter().map(value).sum()
    }
}

/// How much stages change a torque.
fn change(stages: &mut Stages, now: &Moment, torque: f64) -> f64 {
    stages.iter_mut().fold(torque, |torque, (_, stage)| stage.pass(torque, now)) - torque
}

/// Random numbers of the kinds that parts are drawn with.
pub(super) struct Draws(ChaCha8Rng);

impl Draws {
    /// The same for the same seed and use.
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Draws(random)
    }

    /// Even between two numbers.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..=high)
    }

    /// Even between the logarithms of two positive numbers.
    pub(super) fn between_logarithms(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// 1 or −1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.0.random_bool(0.5) { 1.0 } else { -1.0 }
    }

    /// One of so many, from 0.
    pub(super) fn one_of(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// True so often.
    pub(super) fn happens(&mut self, probability: f64) -> bool {
        self.0.random_bool(probability)
    }
}
