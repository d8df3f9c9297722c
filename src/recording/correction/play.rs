//! Where a link is behind what its motor shows: the play of a gear, whose flank the measured torque tells.
//!
//! A motor-side encoder does not see the play. What its gear carries is the measured torque less the friction before the gear; whenever
//! that changes its sign the teeth part, and the link comes to lie on their other flanks. A torque that is predicted from such angles is
//! no guide to the flank, since what it is predicted from jumps with it: the measured one is.
//!
//! Source: Nordin and Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002) 1633; the crossing as a cycloid.

use std::f64::consts::TAU;

use crate::recording::Trajectory;
use crate::recording::differentiate::{central_difference, low_pass};

/// Friction turns round within this share of a joint's highest speed: a velocity has noise.
const REVERSAL: f64 = 0.03;
/// What is quicker than the teeth are on their way changes no flank: the torque is filtered at so many times the inverse of that time.
const FILTER: f64 = 0.5;

/// The play of one joint's gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Play {
    /// From flank to flank, at the joint \[rad\].
    pub gap: f64,
    /// Dry friction between the motor and the gear, at the joint \[N m\].
    pub friction: f64,
    /// How long the teeth are on their way \[s\].
    pub crossing_time: f64,
}

impl Play {
    /// Takes it out of a joint's motion: its link in the place of its motor.
    pub fn take_out(&self, run: &mut Trajectory, joint: usize) {
        take_out(run, joint, &self.behind(run, joint));
    }

    /// The same of a gear that has no play and twists as far as it carries `compliance` \[rad/(N m)\] times a torque.
    pub fn take_twist_out(&self, run: &mut Trajectory, joint: usize, compliance: f64) {
        let twist: Vec<f64> = self.load(run, joint).iter().map(|load| compliance * load).collect();
        let rate = central_difference(&twist, &run.time);
        let bend = central_difference(&rate, &run.time);
        take_out(run, joint, &[twist, rate, bend]);
    }

    /// How far the link is behind its motor, with both rates.
    fn behind(&self, run: &Trajectory, joint: usize) -> [Vec<f64>; 3] {
        let load = self.load(run, joint);
        let changes = changes(&run.time, &load);
        let side = |sign: f64| 0.5 * self.gap * sign;
        let mut behind = [vec![0.0; load.len()], vec![0.0; load.len()], vec![0.0; load.len()]];
        // Where it rests, but for those changes that it is on its way from `ended` to `begun`.
        let mut rest = side(load.iter().find(|load| **load != 0.0).map_or(0.0, |load| load.signum()));
        let (mut ended, mut begun) = (0, 0);
        for (sample, &time) in run.time.iter().enumerate() {
            begun += changes[begun..].iter().take_while(|(start, _)| *start < time).count();
            while ended < begun && changes[ended].0 + self.crossing_time <= time {
                rest += 2.0 * side(changes[ended].1);
                ended += 1;
            }
            behind[0][sample] = rest;
            for &(start, sign) in &changes[ended..begun] {
                let (turn, size) = (TAU * (time - start) / self.crossing_time, 2.0 * side(sign));
                behind[0][sample] += size * (turn - turn.sin()) / TAU;
                behind[1][sample] += size * (1.0 - turn.cos()) / self.crossing_time;
                behind[2][sample] += size * TAU * turn.sin() / self.crossing_time.powi(2);
            }
        }
        behind
    }

    /// What the gear carries \[N m\].
    fn load(&self, run: &Trajectory, joint: usize) -> Vec<f64> {
        let smooth = |signal: &[f64]| low_pass(signal, run.time_step(), FILTER / self.crossing_time);
        let (torque, speed) = (smooth(&run.tau[joint]), smooth(&run.qd[joint]));
        let width = REVERSAL * speed.iter().fold(0.0, |most: f64, qd| most.max(qd.abs()));
        let direction = |qd: f64| if width > 0.0 { (qd / width).tanh() } else { 0.0 };
        torque.iter().zip(&speed).map(|(tau, qd)| tau - self.friction * direction(*qd)).collect()
    }
}

/// Takes what its link is behind off a joint's motion.
fn take_out(run: &mut Trajectory, joint: usize, behind: &[Vec<f64>; 3]) {
    let channels = run.channels_mut();
    for (mut signal, behind) in [channels.q, channels.qd, channels.qdd].into_iter().zip(behind) {
        signal[joint].iter_mut().zip(behind).for_each(|(value, behind)| *value -= behind);
    }
}

/// When a signal changes its sign, found between samples on the straight line, and to which; at exactly zero it has the sign that it had
/// before.
fn changes(time: &[f64], signal: &[f64]) -> Vec<(f64, f64)> {
    let mut changes = Vec::new();
    let mut sign = 0.0;
    let mut before = (0.0, 0.0);
    for (&time, &value) in time.iter().zip(signal) {
        if value * sign < 0.0 {
            changes.push((before.0 + before.1 / (before.1 - value) * (time - before.0), value.signum()));
        }
        if value != 0.0 {
            sign = value.signum();
        }
        before = (time, value);
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;
    use crate::signals::Signals;

    /// Two joints that stand, a hundred samples a second; the torque of joint 2 is a cosine of 4 s, and its velocity what is given.
    fn run(velocity: f64) -> Trajectory {
        let time: Vec<f64> = (0..=800).map(|sample| 0.01 * f64::from(sample)).collect();
        let still = || Signals::zeros(2, time.len());
        let torque = |joint: usize, sample: usize| if joint == 1 { (TAU * time[sample] / 4.0).cos() } else { 1.0 };
        let tau = Signals::from_fn(2, time.len(), torque);
        let qd = Signals::from_fn(2, time.len(), |_, _| velocity);
        Trajectory::new("run", Channels { q: still(), qd, qdd: still(), tau, time: time.clone() }).unwrap()
    }

    const PLAY: Play = Play { gap: 0.02, friction: 0.0, crossing_time: 0.2 };

    fn taken_out(play: Play, velocity: f64) -> Trajectory {
        let mut run = run(velocity);
        play.take_out(&mut run, 1);
        run
    }

    /// The torque changes its sign at 1 s, to minus, and at 3 s, to plus.
    #[test]
    fn a_link_lies_on_the_flank_to_which_it_is_pushed() {
        let without = taken_out(PLAY, 0.0);
        let at = |seconds: f64| (100.0 * seconds).round() as usize;
        for (seconds, beside) in [(0.5, -0.01), (2.0, 0.01), (4.0, -0.01), (6.0, 0.01)] {
            assert!((without.q[1][at(seconds)] - beside).abs() < 1e-12, "{seconds}");
        }
        assert!(without.q[1][at(1.1)].abs() < 1e-3, "half way it is in the middle");
        let derived = [&without.q, &without.qd].map(|signal| central_difference(&signal[1], &without.time));
        for (rate, told) in derived.iter().zip([&without.qd[1], &without.qdd[1]]) {
            let most = told.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let worst = rate.iter().zip(told.iter()).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
            assert!(worst < 0.1 * most, "{worst} of {most}");
        }
        assert_eq!((&without.q[0], &without.tau), (&run(0.0).q[0], &run(0.0).tau), "nothing else changes");
    }

    /// At half of the torque's size the friction takes a third of a half period off, to either side.
    #[test]
    fn friction_before_the_gear_moves_the_change_of_flanks() {
        let play = Play { friction: 0.5, ..PLAY };
        let changes = |velocity: f64| changes(&run(velocity).time, &play.load(&run(velocity), 1));
        for (velocity, expected) in [(1.0, [2.0 / 3.0, 10.0 / 3.0]), (-1.0, [4.0 / 3.0, 8.0 / 3.0]), (0.0, [1.0, 3.0])]
        {
            for ((moment, _), expected) in changes(velocity).iter().zip(expected) {
                assert!((moment - expected).abs() < 0.02, "{velocity}: {moment} for {expected}");
            }
        }
    }

    #[test]
    fn a_change_of_sign_through_zero_is_one() {
        let time = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(changes(&time, &[0.0, 2.0, 0.0, -1.0, 0.0, -1.0]), [(2.0, -1.0)]);
        assert_eq!(changes(&time, &[1.0, -1.0, -1.0, 3.0, 0.0, 0.0]), [(0.5, -1.0), (2.25, 1.0)]);
    }

    #[test]
    fn a_twist_follows_what_the_gear_carries() {
        let mut twisted = run(0.0);
        PLAY.take_twist_out(&mut twisted, 1, 0.01);
        let middle = 200..600;
        let most = |values: &[f64], expected: &dyn Fn(f64) -> f64| {
            let off = |sample: usize| (values[sample] - expected(twisted.time[sample])).abs();
            middle.clone().map(off).fold(0.0, f64::max)
        };
        let rate = TAU / 4.0;
        assert!(most(&twisted.q[1], &|time| -0.01 * (rate * time).cos()) < 1e-4);
        assert!(most(&twisted.qdd[1], &|time| 0.01 * rate.powi(2) * (rate * time).cos()) < 1e-3);
    }
}
