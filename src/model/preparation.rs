//! The same low-pass filter and decimation for the torque and for every column that is to explain it.
//!
//! Parameters are estimated on filtered data: what lies above the arm's own motion is noise of the torque and of the
//! differentiated acceleration. A linear filter leaves the factors of a linear model unchanged if both sides pass it.

use rayon::prelude::*;

use crate::recording::differentiate::{TOGETHER, default_cutoff, low_pass, low_pass_together};
use crate::recording::{Origin, Recording};
use crate::signals::Signals;

/// Cut-off where acceleration was measured or is exact \[Hz\]. Where it was differentiated, its noise grows with frequency,
/// and the cut-off follows the motion as in [`default_cutoff`].
const CUTOFF: f64 = 25.0;

/// Samples for each period of the cut-off that are kept: two would do for the factors; with three, neighbours also tell slow
/// remainders from noise.
const KEPT: f64 = 3.125;

/// Periods of the cut-off after which the filter has forgotten a pulse.
const REACH: f64 = 3.0;

/// How signals of one trajectory are filtered and thinned out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preparation {
    /// Time step before \[s\].
    pub time_step: f64,
    /// Cut-off of the zero-phase low-pass \[Hz\]; `None` where the sampling rate is too low to need one.
    pub cutoff: Option<f64>,
    /// Every how manieth sample is kept.
    pub every: usize,
}

impl Preparation {
    /// The preparation for one trajectory of a recording.
    pub fn of(recording: &Recording, trajectory: usize) -> Preparation {
        let trajectory = &recording.trajectories[trajectory];
        let time_step = trajectory.time_step();
        let cutoff = match recording.provenance.acceleration {
            Origin::Measured => CUTOFF,
            Origin::Derived(_) => default_cutoff(&trajectory.q, &trajectory.qd, time_step),
        };
        Preparation::at(cutoff, time_step)
    }

    /// The preparations for all trajectories, whose torque does not follow the motion `up_to` any frequency, if that is given \[Hz\].
    pub fn of_all(recording: &Recording, up_to: Option<f64>) -> Vec<Preparation> {
        let of = |index: usize| Preparation::of(recording, index).within(up_to.unwrap_or(f64::INFINITY));
        (0..recording.trajectories.len()).map(of).collect()
    }

    /// The preparation for one trajectory whose derivatives are taken as they are, wherever they come from.
    pub fn plain(recording: &Recording, trajectory: usize) -> Preparation {
        Preparation::at(CUTOFF, recording.trajectories[trajectory].time_step())
    }

    /// With this cut-off \[Hz\] and time step \[s\].
    fn at(cutoff: f64, time_step: f64) -> Preparation {
        let rate = if time_step > 0.0 { 1.0 / time_step } else { 0.0 };
        if rate <= 2.5 * cutoff {
            return Preparation { time_step, cutoff: None, every: 1 };
        }
        Preparation { time_step, cutoff: Some(cutoff), every: ((rate / (KEPT * cutoff)).round() as usize).max(1) }
    }

    /// With a cut-off that is not above this one \[Hz\].
    pub fn within(self, highest: f64) -> Preparation {
        self.cutoff.filter(|cutoff| *cutoff > highest).map_or(self, |_| Preparation::at(highest, self.time_step))
    }

    /// What does the same to signals of which only every `every`th sample is left.
    pub fn after(&self, every: usize) -> Preparation {
        let time_step = every as f64 * self.time_step;
        self.cutoff.map_or(*self, |cutoff| Preparation::at(cutoff, time_step))
    }

    /// Filters and decimates one signal.
    pub fn apply(&self, signal: &[f64]) -> Vec<f64> {
        self.apply_each(&[signal]).pop().unwrap_or_default()
    }

    /// The same for signals of one length, on all cores.
    pub fn apply_each(&self, signals: &[&[f64]]) -> Vec<Vec<f64>> {
        let Some(cutoff) = self.cutoff else { return signals.iter().map(|signal| self.thin_out(signal)).collect() };
        let prepared = |group: &[&[f64]]| {
            let passed = low_pass_together(group, self.time_step, cutoff).into_iter();
            passed.map(|signal| self.thin_out(&signal)).collect::<Vec<_>>()
        };
        signals.par_chunks(TOGETHER).flat_map_iter(prepared).collect()
    }

    /// ρ₁ of white noise that was filtered and decimated so: neighbours of what is kept still resemble each other.
    pub fn noise_correlation(&self) -> f64 {
        let Some(cutoff) = self.cutoff else { return 0.0 };
        let reach = (REACH / (cutoff * self.time_step)).ceil() as usize + self.every;
        let mut pulse = vec![0.0; 2 * reach + 1];
        pulse[reach] = 1.0;
        let response = low_pass(&pulse, self.time_step, cutoff);
        let product = |lag: usize| response.iter().zip(&response[lag..]).map(|(a, b)| a * b).sum::<f64>();
        product(self.every) / product(0)
    }

    /// Decimates without filtering.
    pub fn thin_out<T: Copy>(&self, signal: &[T]) -> Vec<T> {
        signal.iter().copied().step_by(self.every).collect()
    }

    /// The same for a signal of all joints.
    pub fn apply_all(&self, signal: &Signals) -> Signals {
        signal.map_together(|joints| self.apply_each(joints))
    }

    /// Which of the kept samples lie in this range of the original ones.
    pub fn range(&self, samples: &std::ops::Range<usize>) -> std::ops::Range<usize> {
        samples.start.div_ceil(self.every)..samples.end.div_ceil(self.every)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn filtered_noise_resembles_its_neighbours_as_told() {
        let preparation = Preparation::at(10.0, 0.001);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let noise: Vec<f64> = (0..400_000).map(|_| StandardNormal.sample(&mut random)).collect();
        let kept = preparation.apply(&noise);
        let product = |lag: usize| kept.iter().zip(&kept[lag..]).map(|(a, b)| a * b).sum::<f64>();
        let told = preparation.noise_correlation();
        assert!((product(1) / product(0) - told).abs() < 0.03 && told > 0.2, "{told}");
        assert_eq!(Preparation::at(10.0, 0.05).noise_correlation(), 0.0);
    }
}
