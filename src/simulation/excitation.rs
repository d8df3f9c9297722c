//! How the arm is moved: smooth paths of every joint, with exact derivatives.

use std::f64::consts::{PI, TAU};

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::{SimulationError, demand, sensible};

/// Most samples that a recording may have in all, so that a slip of the keyboard does not fill the memory.
const MOST_SAMPLES: f64 = 2e7;

/// How the arm is moved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Excitation {
    /// The paper's motion (Li, Wu, Chen, Sun, Mathematics 12 (2024) 2527, section 4.2.1): every joint goes from q₀ to q_f,
    /// both drawn uniformly from ±`range`, in the time T:
    ///
    /// ```text
    /// q(t) = q₀ + (q_f − q₀)/T · (t − T/(2π) sin(2π t/T))
    /// ```
    PaperPointToPoint {
        /// How many runs.
        trajectories: usize,
        /// T \[s\]. The paper prints 8 s; its table 2 fits 4 s.
        duration: f64,
        /// Samples of each run, at k T / `samples`.
        samples: usize,
        /// Largest |q₀| and |q_f| \[rad\].
        range: f64,
    },
    /// A sum of sines with random frequencies and phases about a random place; it starts from rest.
    MultiSine {
        /// How many runs.
        trajectories: usize,
        /// How long each lasts \[s\].
        duration: f64,
        /// Samples per second \[Hz\].
        rate: f64,
        /// How many sines are added in each joint.
        harmonics: usize,
        /// Lowest frequency that is drawn \[Hz\].
        lowest_frequency: f64,
        /// Highest frequency that is drawn \[Hz\], at most half the rate.
        highest_frequency: f64,
        /// No joint goes further than this from 0 \[rad\].
        max_position: f64,
        /// No joint turns faster than this \[rad/s\] (at speed scale 1).
        max_velocity: f64,
    },
    /// The policy of the paper's real arm (section 4.3.1): C + A Σ Bᵢ sin(ωᵢ t + φᵢ) in each joint, all of them drawn, within a
    /// part of the space; it starts from rest.
    SuperposedSines {
        /// How many runs.
        trajectories: usize,
        /// How long each lasts \[s\].
        duration: f64,
        /// Samples per second \[Hz\].
        rate: f64,
        /// How many sines are added in each joint.
        sines: usize,
        /// Lowest frequency that is drawn \[Hz\].
        lowest_frequency: f64,
        /// Highest frequency that is drawn \[Hz\], at most half the rate.
        highest_frequency: f64,
        /// Smallest and largest position of each joint \[rad\].
        space: Vec<[f64; 2]>,
    },
    /// From place to place with a pause at each, all joints at a time; the places are drawn. With a few places in turn it is
    /// pick and place, with many it never comes back.
    Stops {
        /// How many runs.
        trajectories: usize,
        /// How long each lasts \[s\].
        duration: f64,
        /// Samples per second \[Hz\].
        rate: f64,
        /// How many places are visited before it begins again.
        places: usize,
        /// How long it stays at each \[s\].
        pause: f64,
        /// No place is further than this from 0 \[rad\], in any joint.
        max_position: f64,
        /// No joint turns faster than this \[rad/s\] (at speed scale 1), however far it has to go.
        max_velocity: f64,
    },
}

/// The way of one joint over time, twice differentiable.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Path {
    PointToPoint { from: f64, travel: f64, duration: f64 },
    MultiSine { centre: f64, rise: f64, sines: Vec<Sine> },
    Stops { places: Vec<f64>, travel: f64, pause: f64 },
}

/// a sin(ω t + φ)
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sine {
    amplitude: f64,
    angular_frequency: f64,
    phase: f64,
}

impl Excitation {
    /// The training set of the paper's simulation, at the speed that fits its table 2: 200 runs of 4 s, ±3 rad.
    pub fn paper() -> Self {
        Excitation::PaperPointToPoint { trajectories: 200, duration: 4.0, samples: 400, range: 3.0 }
    }

    /// Checks that it can be carried out.
    ///
    /// # Errors
    /// [`SimulationError::Value`] or [`SimulationError::TooLarge`] says which number can't be.
    pub fn check(&self) -> Result<(), SimulationError> {
        let counted = |what, count: usize| demand(what, count as f64, count > 0, "1 or more");
        match *self {
            Excitation::PaperPointToPoint { trajectories, duration, samples, range } => {
                counted("number of trajectories", trajectories)?;
                counted("number of samples", samples)?;
                sensible("duration", duration)?;
                sensible("range", range)?;
            }
            Excitation::MultiSine {
                trajectories,
                duration,
                rate,
                harmonics,
                lowest_frequency,
                highest_frequency,
                max_position,
                max_velocity,
            } => {
                counted("number of trajectories", trajectories)?;
                demand("number of harmonics", harmonics as f64, (1..=1000).contains(&harmonics), "between 1 and 1000")?;
                sensible("duration", duration)?;
                sensible("rate", rate)?;
                frequencies(lowest_frequency, highest_frequency, rate)?;
                sensible("largest position", max_position)?;
                sensible("largest velocity", max_velocity)?;
            }
            Excitation::SuperposedSines {
                trajectories,
                duration,
                rate,
                sines,
                lowest_frequency,
                highest_frequency,
                ref space,
            } => {
                counted("number of trajectories", trajectories)?;
                demand("number of sines", sines as f64, (1..=1000).contains(&sines), "between 1 and 1000")?;
                sensible("duration", duration)?;
                sensible("rate", rate)?;
                frequencies(lowest_frequency, highest_frequency, rate)?;
                for [low, high] in space {
                    demand("largest position", *high, low < high && low.is_finite(), "above the smallest position")?;
                }
            }
            Excitation::Stops { trajectories, duration, rate, places, pause, max_position, max_velocity } => {
                counted("number of trajectories", trajectories)?;
                demand("number of places", places as f64, (2..=100_000).contains(&places), "between 2 and 100000")?;
                sensible("duration", duration)?;
                sensible("rate", rate)?;
                demand("pause", pause, (0.0..=1e6).contains(&pause), "0 to 1e6 s")?;
                sensible("largest position", max_position)?;
                sensible("largest velocity", max_velocity)?;
            }
        }
        Ok(())
    }

    /// Checks that it can move an arm of so many joints.
    ///
    /// # Errors
    /// [`SimulationError::Space`] if it has the space of more or fewer joints.
    pub fn check_joints(&self, joints: usize) -> Result<(), SimulationError> {
        match self {
            Excitation::SuperposedSines { space, .. } if space.len() != joints => {
                Err(SimulationError::Space { space: space.len(), joints })
            }
            _ => Ok(()),
        }
    }

    /// How many runs it has.
    pub fn trajectory_count(&self) -> usize {
        match self {
            Excitation::PaperPointToPoint { trajectories, .. }
            | Excitation::MultiSine { trajectories, .. }
            | Excitation::SuperposedSines { trajectories, .. }
            | Excitation::Stops { trajectories, .. } => *trajectories,
        }
    }

    /// Time stamps of every run \[s\] when the paths are travelled `speed` times as fast.
    ///
    /// The number of samples is kept where the excitation states it; so is the sampling rate.
    pub(super) fn time(&self, speed: f64) -> Result<Vec<f64>, SimulationError> {
        let (count, step, drawn) = match *self {
            Excitation::PaperPointToPoint { duration, samples, .. } => {
                (samples as f64, duration / speed / samples as f64, 0.0)
            }
            // However fast it is travelled, a path is drawn in its own time.
            Excitation::MultiSine { duration, rate, .. }
            | Excitation::SuperposedSines { duration, rate, .. }
            | Excitation::Stops { duration, rate, .. } => {
                ((duration / speed * rate).round().max(1.0), 1.0 / rate, duration * rate)
            }
        };
        let samples = count.max(drawn) * self.trajectory_count() as f64;
        if samples > MOST_SAMPLES {
            return Err(SimulationError::TooLarge { samples, most: MOST_SAMPLES });
        }
        Ok((0..count as usize).map(|sample| sample as f64 * step).collect())
    }

    /// Draws the way of each joint for one run.
    pub(super) fn draw(&self, joints: usize, random: &mut impl Rng) -> Vec<Path> {
        (0..joints).map(|joint| self.draw_path(joint, random)).collect()
    }

    fn draw_path(&self, joint: usize, random: &mut impl Rng) -> Path {
        match *self {
            Excitation::PaperPointToPoint { duration, range, .. } => {
                let from = random.random_range(-range..=range);
                let to = random.random_range(-range..=range);
                Path::PointToPoint { from, travel: to - from, duration }
            }
            Excitation::MultiSine {
                duration,
                harmonics,
                lowest_frequency,
                highest_frequency,
                max_position,
                max_velocity,
                ..
            } => {
                let centre = 0.4 * max_position * random.random_range(-1.0..=1.0);
                let draw_sine = |_| {
                    let frequency = random.random_range(lowest_frequency..=highest_frequency);
                    // Amplitudes as 1/f give every sine about the same part of the velocity.
                    let amplitude = random.random_range(0.5..=1.0) / frequency;
                    Sine { amplitude, angular_frequency: TAU * frequency, phase: random.random_range(-PI..=PI) }
                };
                let mut sines: Vec<Sine> = (0..harmonics).map(draw_sine).collect();
                let rise = (0.25 * duration).min(2.0);
                let (reach, speed) = Path::MultiSine { centre: 0.0, rise, sines: sines.clone() }
                    .extremes(duration, (duration * highest_frequency * 40.0).ceil().max(100.0));
                // Between the points that `extremes` looks at there may be 0.3 % more.
                let scale = 0.99 * ((max_position - centre.abs()) / reach).min(max_velocity / speed);
                for sine in &mut sines {
                    sine.amplitude *= scale;
                }
                Path::MultiSine { centre, rise, sines }
            }
            Excitation::SuperposedSines { duration, sines, lowest_frequency, highest_frequency, ref space, .. } => {
                let [low, high] = space[joint];
                let draw_sine = |_| Sine {
                    amplitude: random.random_range(0.2..=1.0),
                    angular_frequency: TAU * random.random_range(lowest_frequency..=highest_frequency),
                    phase: random.random_range(-PI..=PI),
                };
                let mut sines: Vec<Sine> = (0..sines).map(draw_sine).collect();
                // A in part of what the space allows, C so that the path stays inside.
                let reach: f64 = sines.iter().map(|sine| sine.amplitude).sum();
                let amplitude = 0.5 * (high - low) * random.random_range(0.6..=1.0);
                for sine in &mut sines {
                    sine.amplitude *= amplitude / reach;
                }
                let centre = random.random_range(low + amplitude..=f64::max(low + amplitude, high - amplitude));
                Path::MultiSine { centre, rise: (0.25 * duration).min(2.0), sines }
            }
            Excitation::Stops { places, pause, max_position, max_velocity, .. } => {
                // A smooth step is 15/8 times as fast in its middle as on average.
                let travel = 15.0 / 8.0 * 2.0 * max_position / max_velocity;
                let place = |_| random.random_range(-max_position..=max_position);
                Path::Stops { places: (0..places).map(place).collect(), travel, pause }
            }
        }
    }
}

impl Path {
    /// q \[rad\], q̇ \[rad/s\] and q̈ \[rad/s²\] at time t \[s\].
    pub(super) fn at(&self, t: f64) -> [f64; 3] {
        match self {
            Path::PointToPoint { from, travel, duration } => {
                let (sin, cos) = (TAU * t / duration).sin_cos();
                [
                    from + travel * (t / duration - sin / TAU),
                    travel / duration * (1.0 - cos),
                    travel * TAU / duration.powi(2) * sin,
                ]
            }
            Path::MultiSine { centre, rise, sines } => {
                let [mut x, mut xd, mut xdd] = [0.0; 3];
                for Sine { amplitude, angular_frequency, phase } in sines {
                    let (sin, cos) = (angular_frequency * t + phase).sin_cos();
                    x += amplitude * sin;
                    xd += amplitude * angular_frequency * cos;
                    xdd -= amplitude * angular_frequency.powi(2) * sin;
                }
                let [w, wd, wdd] = smooth_step(t, *rise);
                [centre + w * x, wd * x + w * xd, wdd * x + 2.0 * wd * xd + w * xdd]
            }
            Path::Stops { places, travel, pause } => {
                let leg = (t / (travel + pause)).floor();
                let place = |number: usize| places[number % places.len()];
                let (from, to) = (place(leg as usize), place(leg as usize + 1));
                let [w, wd, wdd] = smooth_step(t - leg * (travel + pause), *travel);
                [from + (to - from) * w, (to - from) * wd, (to - from) * wdd]
            }
        }
    }

    /// Largest |q| and |q̇| among `points` points of time.
    fn extremes(&self, duration: f64, points: f64) -> (f64, f64) {
        (0..=points as usize)
            .map(|point| self.at(duration * point as f64 / points))
            .fold((0.0, 0.0), |(reach, speed), [q, qd, _]| (f64::max(reach, q.abs()), f64::max(speed, qd.abs())))
    }
}

fn frequencies(lowest: f64, highest: f64, rate: f64) -> Result<(), SimulationError> {
    sensible("lowest frequency", lowest)?;
    let ordered = (lowest..=0.5 * rate).contains(&highest);
    demand("highest frequency", highest, ordered, "between the lowest frequency and half the sampling rate")
}

/// Rises from 0 to 1 within `rise` with velocity and acceleration 0 at both ends; value and two derivatives.
fn smooth_step(t: f64, rise: f64) -> [f64; 3] {
    if t >= rise {
        return [1.0, 0.0, 0.0];
    }
    let x = t / rise;
    [
        x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x),
        30.0 * (x * (1.0 - x)).powi(2) / rise,
        60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / rise.powi(2),
    ]
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn multi_sine() -> Excitation {
        Excitation::MultiSine {
            trajectories: 2,
            duration: 6.0,
            rate: 100.0,
            harmonics: 4,
            lowest_frequency: 0.1,
            highest_frequency: 1.5,
            max_position: 2.0,
            max_velocity: 3.0,
        }
    }

    fn stops() -> Excitation {
        Excitation::Stops {
            trajectories: 1,
            duration: 30.0,
            rate: 100.0,
            places: 4,
            pause: 0.5,
            max_position: 1.5,
            max_velocity: 3.0,
        }
    }

    fn paths(excitation: &Excitation, count: usize) -> Vec<Path> {
        excitation.draw(count, &mut ChaCha8Rng::seed_from_u64(5))
    }

    #[test]
    fn velocity_and_acceleration_are_the_derivatives_of_position() {
        for excitation in [Excitation::paper(), multi_sine(), stops()] {
            for path in paths(&excitation, 20) {
                for t in [0.01, 0.3, 0.99, 1.7, 3.2] {
                    let h = 1e-4;
                    let [before, now, after] = [path.at(t - h), path.at(t), path.at(t + h)];
                    for order in [0, 1] {
                        let slope = (after[order] - before[order]) / (2.0 * h);
                        assert!((slope - now[order + 1]).abs() < 1e-4, "{slope} is not {} at {t}", now[order + 1]);
                    }
                }
            }
        }
    }

    #[test]
    fn the_paper_path_goes_from_rest_to_rest() {
        for path in paths(&Excitation::paper(), 10) {
            let Path::PointToPoint { from, travel, duration } = path else { panic!("{path:?}") };
            assert!(from.abs() <= 3.0 && (from + travel).abs() <= 3.0);
            for (t, q) in [(0.0, from), (duration, from + travel)] {
                let state = path.at(t);
                assert!((state[0] - q).abs() < 1e-12 && state[1].abs() < 1e-12 && state[2].abs() < 1e-12, "{state:?}");
            }
        }
    }

    #[test]
    fn the_multi_sine_starts_from_rest_and_keeps_its_limits_and_uses_them() {
        let mut fullest = 0.0_f64;
        for path in paths(&multi_sine(), 50) {
            assert_eq!(path.at(0.0)[1..], [0.0, 0.0]);
            let (reach, speed) = path.extremes(6.0, 50_000.0);
            assert!(reach <= 2.0 && speed <= 3.0, "{reach} rad, {speed} rad/s");
            fullest = fullest.max((reach / 2.0).min(1.0)).max(speed / 3.0);
        }
        assert!(fullest > 0.95);
    }

    #[test]
    fn superposed_sines_start_from_rest_and_keep_to_their_space() {
        let space = vec![[-1.6, -0.2], [0.1, 0.5]];
        let excitation = Excitation::SuperposedSines {
            trajectories: 1,
            duration: 10.0,
            rate: 100.0,
            sines: 5,
            lowest_frequency: 0.1,
            highest_frequency: 0.5,
            space: space.clone(),
        };
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..20 {
            for (path, [low, high]) in excitation.draw(2, &mut random).iter().zip(&space) {
                assert_eq!(path.at(0.0)[1..], [0.0, 0.0]);
                for t in 0..1000 {
                    let [q, ..] = path.at(0.01 * f64::from(t));
                    assert!((*low..=*high).contains(&q), "{q} is not in {low}..{high}");
                }
            }
        }
        let message = excitation.check_joints(3).unwrap_err().to_string();
        assert!(message.contains("the space of 2 joints, the arm has 3"), "{message}");
    }

    #[test]
    fn it_rests_at_every_place_and_comes_back_to_the_first() {
        let travel = 15.0 / 8.0 * 3.0 / 3.0;
        for path in paths(&stops(), 20) {
            let (reach, speed) = path.extremes(30.0, 30_000.0);
            assert!(reach <= 1.5 && speed <= 3.0, "{reach} rad, {speed} rad/s");
            let Path::Stops { places, .. } = &path else { panic!("{path:?}") };
            for leg in 0..9 {
                let arrived = (leg as f64 + 1.0) * (travel + 0.5);
                for t in [arrived - 0.45, arrived - 0.01] {
                    let [q, qd, qdd] = path.at(t);
                    assert!((q - places[(leg + 1) % 4]).abs() < 1e-12 && qd == 0.0 && qdd == 0.0, "{q} at {t}");
                }
            }
        }
    }

    #[test]
    fn what_can_not_be_carried_out_is_named() {
        let message = |excitation: Excitation| excitation.check().unwrap_err().to_string();
        let paper = |trajectories, duration, samples| {
            message(Excitation::PaperPointToPoint { trajectories, duration, samples, range: 3.0 })
        };
        assert_eq!(paper(0, 4.0, 400), "the scenario's number of trajectories is 0, but must be 1 or more");
        assert!(paper(1, -4.0, 400).contains("duration is -4"));
        assert!(paper(1, 4.0, 0).contains("number of samples is 0"));
        let mut fast = multi_sine();
        if let Excitation::MultiSine { highest_frequency, .. } = &mut fast {
            *highest_frequency = 51.0;
        }
        assert!(message(fast).contains("highest frequency is 51, but must be between the lowest"));
    }

    #[test]
    fn a_huge_recording_is_refused() {
        let huge =
            Excitation::PaperPointToPoint { trajectories: usize::MAX, duration: 1.0, samples: usize::MAX, range: 1.0 };
        assert!(matches!(huge.time(1.0), Err(SimulationError::TooLarge { .. })));
    }

    #[test]
    fn faster_keeps_what_the_excitation_states() {
        let paper = Excitation::paper().time(2.5).unwrap();
        assert_eq!(paper.len(), 400);
        assert!((paper[1] - 0.004).abs() < 1e-15);
        let sines = multi_sine().time(2.0).unwrap();
        assert_eq!((sines.len(), sines[1]), (300, 0.01));
    }
}
