//! How the learning rate changes over a run.

use serde::{Deserialize, Serialize};

/// The course of the learning rate, as a factor of its highest value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// Always the same, as in the paper.
    Constant,
    /// Rises linearly over the first share of the run, then falls as half a cosine to zero.
    Cosine {
        /// Share of the run, 0 to 1.
        warm_up: f64,
    },
    /// One cycle (Smith 2018): from a 25th up to the peak and down to nearly nothing, both as half cosines.
    OneCycle {
        /// Where the peak lies, 0 to 1.
        peak: f64,
    },
}

impl Schedule {
    /// Half a cosine with the warm-up that SOAP needs.
    pub const COSINE: Schedule = Schedule::Cosine { warm_up: 0.15 };
    /// One cycle with its usual peak.
    pub const ONE_CYCLE: Schedule = Schedule::OneCycle { peak: 0.3 };

    /// The factor of step `step` (counted from 0) of `steps`.
    pub fn factor(self, step: u64, steps: u64) -> f64 {
        let at = (step as f64 + 0.5) / steps.max(1) as f64;
        let fall = |at: f64| 0.5 * (1.0 + (std::f64::consts::PI * at.clamp(0.0, 1.0)).cos());
        match self {
            Schedule::Constant => 1.0,
            Schedule::Cosine { warm_up } if at < warm_up => at / warm_up,
            Schedule::Cosine { warm_up } => fall((at - warm_up) / (1.0 - warm_up)),
            Schedule::OneCycle { peak } if at < peak => 1.0 - (1.0 - 1.0 / 25.0) * fall(at / peak),
            Schedule::OneCycle { peak } => fall((at - peak) / (1.0 - peak)).max(1e-5),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules_rise_to_one_and_fall_to_nothing() {
        for (schedule, peak) in [(Schedule::Cosine { warm_up: 0.05 }, 50), (Schedule::OneCycle { peak: 0.3 }, 300)] {
            let factors: Vec<f64> = (0..1000).map(|step| schedule.factor(step, 1000)).collect();
            assert!(factors[0] < 0.05 && factors[999] < 1e-4 && (factors[peak] - 1.0).abs() < 1e-2, "{schedule:?}");
            assert!(factors[..peak].is_sorted() && factors[peak + 1..].is_sorted_by(|a, b| a >= b), "{schedule:?}");
        }
        assert_eq!(Schedule::Constant.factor(7, 10), 1.0);
    }
}
