//! Which cut-off the noise of a log asks for: where derived channels are nearest to the motion.
//!
//! Slopes make noise louder the faster it is, and a low-pass takes away motion with it. How much of either is left at a cut-off follows
//! from the spectrum of what was measured: noise of encoders is as strong at all frequencies (quantization too), and what stands out
//! of it is motion. The cut-off with the least of both together is proposed, with what it leaves.

use std::f64::consts::PI;

use super::differentiate::{central_difference, median_step};
use super::mapping::{Channel, Draft};
use super::read::Preview;
use super::spectrum::power;
use crate::signals::Signals;
use crate::statistics::median;

/// So many samples of a log are looked at.
const MOST: usize = 20_000;
/// Frequencies of which the strength of noise is taken, as shares of half the sampling rate: motion does not reach so far, and a
/// logger's own low-pass would already be felt above.
const OF_NOISE: [f64; 2] = [0.5, 0.9];
/// What stands so many times above the noise is motion.
const STANDS_OUT: f64 = 4.0;
/// The next harmonic of a motion has at most so many times its frequency: what stands out above a wider gap is hum or vibration.
const WIDEST_GAP: f64 = 3.0;
/// Cut-offs that are compared differ by this factor.
const STEP: f64 = 1.02;
/// Highest cut-off, as a share of the sampling rate.
const HIGHEST_SHARE: f64 = 0.2;
/// Less noise than this share of the acceleration behind the highest cut-off of all is none, but the rounding of numbers.
const NO_NOISE: f64 = 1e-3;

/// Channels of a log of which others are derived, from its first row on and without a gap.
pub struct Sampled {
    /// \[s\]
    pub time: Vec<f64>,
    /// Positions, by joint.
    pub q: Signals,
    /// Velocities, where they were measured.
    pub qd: Option<Signals>,
}

/// A cut-off and what derived accelerations have of noise and lack of motion with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal {
    /// Where the filter halves an amplitude \[Hz\].
    pub cutoff_hz: f64,
    /// RMS of the noise that passes, beside the RMS of the acceleration itself: the root of the mean over the joints.
    pub noise: f64,
    /// RMS of the motion that does not pass, as share of the same.
    pub motion: f64,
    /// Up to where motion stands out of the noise \[Hz\]: the highest of the joints.
    pub reach_hz: f64,
}

/// What the noise of a log asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Advice {
    /// A cut-off.
    CutOff(Proposal),
    /// Nothing: none is seen.
    NoNoise,
}

impl Sampled {
    /// What velocities or accelerations are derived from in a log that was looked into, by a draft of its mapping; `None` where both
    /// are measured, without a clock, or where numbers are missing.
    pub fn derived_from(draft: &Draft, preview: &Preview) -> Option<Sampled> {
        let has = |channel: Channel| draft.columns.iter().any(|role| role.channel == Some(channel));
        if has(Channel::Velocity) && has(Channel::Acceleration) {
            return None;
        }
        let of_channel = |channel: Channel| {
            let columns = draft.columns.iter().zip(&preview.columns);
            let columns = columns.filter(move |(role, _)| role.channel == Some(channel));
            let values = |(role, seen): (&super::mapping::Role, &super::read::Seen)| {
                let values = seen.values.iter().take(MOST).map(|value| role.to_si() * value).collect::<Vec<f64>>();
                (role.joint, values)
            };
            let mut joints: Vec<(usize, Vec<f64>)> = columns.map(values).collect();
            joints.sort_by_key(|(joint, _)| *joint);
            joints.into_iter().map(|(_, values)| values).collect::<Vec<_>>()
        };
        let [positions, velocities] = [Channel::Position, Channel::Velocity].map(of_channel);
        let count = positions.first()?.len();
        let time = match (of_channel(Channel::Time).pop(), draft.rate_hz) {
            (Some(time), _) => time,
            (None, Some(rate)) => (0..count).map(|sample| sample as f64 / rate).collect(),
            (None, None) => return None,
        };
        let is_whole = |values: &Vec<f64>| values.len() == count && values.iter().all(|value| value.is_finite());
        let are_whole = positions.iter().chain(&velocities).chain([&time]).all(is_whole);
        if count < 3 || !are_whole || time.windows(2).any(|pair| pair[1] <= pair[0]) {
            return None;
        }
        let qd = if velocities.is_empty() { None } else { Some(Signals::from_joints(velocities).ok()?) };
        Some(Sampled { time, q: Signals::from_joints(positions).ok()?, qd })
    }

    /// What its noise asks for; `None` where it is too short, or where no joint moves out of its noise.
    pub fn advice(&self) -> Option<Advice> {
        let step = median_step(&self.time);
        // Acceleration, which is derived once more than velocity, is what a cut-off matters for.
        let (measured, slopes) = self.qd.as_ref().map_or((&self.q, 2), |qd| (qd, 1));
        let joints: Vec<Spectrum> =
            measured.iter().filter_map(|values| Spectrum::of(values, &self.time, step, slopes)).collect();
        let reach_hz = joints.iter().map(|joint| joint.reach_hz).reduce(f64::max)?;
        let (lowest, highest) = (1.0 / (self.time.last()? - self.time.first()?), HIGHEST_SHARE / step);
        let count = ((highest / lowest).ln() / STEP.ln()).max(0.0) as i32;
        let proposals = (0..=count).map(|number| {
            let cutoff_hz = highest / STEP.powi(number);
            let left = joints.iter().map(|joint| joint.left(cutoff_hz, slopes));
            let [noise, motion] = left.fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]]);
            let mean = |sum: f64| (sum / joints.len() as f64).sqrt();
            Proposal { cutoff_hz, noise: mean(noise), motion: mean(motion), reach_hz }
        });
        let best = proposals.min_by(|one, other| one.error().total_cmp(&other.error()))?;
        let is_noiseless = best.cutoff_hz == highest && best.noise < NO_NOISE;
        Some(if is_noiseless { Advice::NoNoise } else { Advice::CutOff(best) })
    }
}

impl Advice {
    /// The cut-off, if one is asked for, with as many digits as one types \[Hz\].
    pub fn told_hz(&self) -> Option<f64> {
        match self {
            Advice::CutOff(proposal) => Some(short(proposal.cutoff_hz)),
            Advice::NoNoise => None,
        }
    }

    /// Why, in words.
    pub fn reason(&self) -> String {
        match self {
            Advice::CutOff(proposal) => proposal.reason(),
            Advice::NoNoise => {
                "no noise is seen in what they are derived from: any cut-off well above the motion leaves it as it is"
                    .to_owned()
            }
        }
    }
}

impl Proposal {
    /// RMS of both together.
    pub fn error(&self) -> f64 {
        self.noise.hypot(self.motion)
    }

    fn reason(&self) -> String {
        format!(
            "motion stands out of the noise up to {} Hz; behind this cut-off {:.1} % of the acceleration (RMS) is noise and {:.1} % of \
             the motion is lost, the least of both together",
            short(self.reach_hz),
            100.0 * self.noise,
            100.0 * self.motion
        )
    }
}

/// Three digits.
fn short(hertz: f64) -> f64 {
    let unit = 10.0_f64.powf(hertz.log10().floor() - 2.0);
    if unit >= 1.0 { hertz.round() } else { (hertz / unit).round() / (1.0 / unit).round() }
}

/// Motion and noise of a joint, by frequency.
struct Spectrum {
    /// Frequency \[Hz\] and the power of the acceleration there, beside that of all frequencies.
    motion: Vec<[f64; 2]>,
    /// The power of noise in the acceleration is this times that of a slope, beside the same.
    noise: f64,
    reach_hz: f64,
    step: f64,
}

impl Spectrum {
    /// Of a measured channel whose slope of this order is the acceleration; `None` where it does not move out of its noise.
    fn of(values: &[f64], time: &[f64], step: f64, slopes: i32) -> Option<Spectrum> {
        // Of the acceleration: that of the position leaks from the large slow motion into all that is fast.
        let derived = (0..slopes).fold(values.to_vec(), |values, _| central_difference(&values, time));
        let spectrum = power(&[&derived], step);
        let half = 0.5 / step;
        let is_noise = |[hertz, _]: &[f64; 2]| (OF_NOISE[0] * half..=OF_NOISE[1] * half).contains(hertz);
        let louder = |hertz: f64| slope(hertz, step).powi(2 * slopes);
        let measured = |[hertz, power]: &[f64; 2]| power / louder(*hertz);
        let noise = median(spectrum.iter().filter(|line| is_noise(line)).map(measured).collect())?;
        let mut reach_hz: f64 = 0.0;
        let mut motion = Vec::new();
        for [hertz, power] in spectrum {
            let is_in_reach = reach_hz == 0.0 || hertz <= WIDEST_GAP * reach_hz;
            let noise = noise * louder(hertz);
            let stands_out = power > STANDS_OUT * noise && is_in_reach;
            reach_hz = if stands_out { hertz } else { reach_hz };
            motion.push([hertz, if stands_out { power - noise } else { 0.0 }]);
        }
        let whole: f64 = motion.iter().map(|[_, power]| power).sum();
        let beside = |[hertz, power]: [f64; 2]| [hertz, power / whole];
        (whole > 0.0 && whole.is_finite()).then(|| Spectrum {
            motion: motion.into_iter().map(beside).collect(),
            noise: noise / whole,
            reach_hz,
            step,
        })
    }

    /// The shares of noise that passes and of motion that does not, squared.
    fn left(&self, cutoff_hz: f64, slopes: i32) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for [hertz, power] in &self.motion {
            // Each slope has a filter behind it.
            let passes = passes(*hertz, cutoff_hz, self.step).powi(slopes);
            sums[0] += (passes * slope(*hertz, self.step).powi(slopes)).powi(2) * self.noise;
            sums[1] += (1.0 - passes).powi(2) * power;
        }
        sums
    }
}

/// What a central difference makes of an amplitude.
fn slope(hertz: f64, step: f64) -> f64 {
    (2.0 * PI * hertz * step).sin() / step
}

/// What [`low_pass`](super::differentiate::low_pass) leaves of an amplitude: a Butterworth filter of fourth order, run twice.
fn passes(hertz: f64, cutoff_hz: f64, step: f64) -> f64 {
    let warped = |hertz: f64| (PI * hertz * step).tan();
    1.0 / (1.0 + (warped(hertz) / warped(cutoff_hz)).powi(8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::differentiate::derivative;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    const RATE: f64 = 500.0;
    /// Frequency \[Hz\] and amplitude \[rad\].
    const MOTION: [[f64; 2]; 3] = [[0.3, 1.0], [1.1, 0.3], [2.7, 0.05]];

    fn time() -> Vec<f64> {
        (0..10_000).map(|sample| sample as f64 / RATE).collect()
    }

    fn wave(time: &[f64], of: impl Fn(f64, f64, f64) -> f64) -> Vec<f64> {
        time.iter()
            .map(|t| MOTION.iter().map(|[hertz, amplitude]| of(2.0 * PI * hertz, *amplitude, *t)).sum())
            .collect()
    }

    fn noisy(sigma: f64) -> Sampled {
        let (time, noise) = (time(), Normal::new(0.0, sigma).unwrap());
        let mut draws = ChaCha8Rng::seed_from_u64(7);
        let mut q = wave(&time, |omega, amplitude, t| amplitude * (omega * t).sin());
        q.iter_mut().for_each(|q| *q += noise.sample(&mut draws));
        Sampled { q: Signals::from_joints(vec![q]).unwrap(), time, qd: None }
    }

    /// The error of the derived acceleration beside the true one.
    fn error(of: &Sampled, cutoff_hz: f64) -> f64 {
        let truth = wave(&of.time, |omega, amplitude, t| -amplitude * omega * omega * (omega * t).sin());
        let twice = derivative(&derivative(&of.q[0], &of.time, cutoff_hz), &of.time, cutoff_hz);
        let inner = 1000..9000;
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>();
        let off = square(&mut inner.clone().map(|sample| twice[sample] - truth[sample]));
        (off / square(&mut inner.map(|sample| truth[sample]))).sqrt()
    }

    /// Strong noise and weak: the proposed cut-off does nearly as well as the best of all, and its error is the one that it tells.
    #[test]
    fn the_proposed_cut_off_is_nearly_the_best() {
        let mut before = f64::INFINITY;
        for sigma in [1e-5, 1e-4, 1e-3, 1e-2] {
            let log = noisy(sigma);
            let Some(Advice::CutOff(proposal)) = log.advice() else { panic!("{sigma}: {:?}", log.advice()) };
            let best = (1..400).map(|tenth| error(&log, f64::from(tenth) / 10.0)).fold(f64::INFINITY, f64::min);
            let real = error(&log, proposal.cutoff_hz);
            assert!(real < 1.15 * best, "{sigma}: {proposal:?} leaves {real}, the best {best}");
            // With hardly any noise what the difference itself lacks, which no filter gives back, is more than it tells.
            let is_told = sigma < 5e-5 || (0.7..1.4).contains(&(proposal.error() / real));
            assert!(is_told, "{sigma}: {proposal:?}, but it is {real}");
            assert!(proposal.cutoff_hz < before, "the more noise, the lower: {proposal:?}");
            before = proposal.cutoff_hz;
        }
    }

    /// Hum of the mains is no motion: it does not raise the cut-off above itself.
    #[test]
    fn hum_far_above_the_motion_is_not_let_through() {
        let mut log = noisy(1e-4);
        let hum = |(q, t): (&f64, &f64)| q + 1e-3 * (2.0 * PI * 50.0 * t).sin();
        log.q = log.q.map_joints(|q| q.iter().zip(&log.time).map(hum).collect());
        let Some(Advice::CutOff(proposal)) = log.advice() else { panic!("{:?}", log.advice()) };
        assert!((2.7..25.0).contains(&proposal.cutoff_hz), "{proposal:?}");
        // A line of the spectrum is as wide as some of its steps.
        assert!((2.5..5.0).contains(&proposal.reach_hz), "{proposal:?}");
    }

    #[test]
    fn where_no_noise_is_seen_no_cut_off_is_asked_for() {
        let advice = noisy(0.0).advice().unwrap();
        assert_eq!(advice, Advice::NoNoise);
        assert!(advice.told_hz().is_none() && advice.reason().contains("no noise is seen"), "{advice:?}");
    }

    #[test]
    fn what_stands_still_or_is_short_gets_no_proposal() {
        let still = Sampled {
            q: Signals::from_joints(vec![vec![0.5; 1000]]).unwrap(),
            time: time()[..1000].to_vec(),
            qd: None,
        };
        assert_eq!(still.advice(), None);
        let short = Sampled {
            q: Signals::from_joints(vec![vec![0.0, 1.0, 0.0]]).unwrap(),
            time: time()[..3].to_vec(),
            qd: None,
        };
        assert_eq!(short.advice(), None);
    }
}
