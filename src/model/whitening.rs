//! Whitening: taking from a joint's torque, and from every column that stands for it, what the last sample tells of the next.
//!
//! What a model leaves of a real robot is not white: it moves as slowly as the arm. Least squares then trusts its slow part no less than
//! the rest, and an effect that changes faster (a wave along the way, a delay) drowns in what is left although nothing like it is left.
//! With xₜ − ρ xₜ₋₁ in the place of xₜ, on both sides of the equations, each part counts as much as it tells.
//!
//! Source: Cochrane and Orcutt, J. Am. Stat. Assoc. 44 (1949) 32; the first sample as Prais and Winsten have it, Cowles Commission
//! Discussion Paper 383 (1954).

/// ρ of each joint, at least 0 and below 1; nothing is whitened where it is 0, and nowhere if there are none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Whitening {
    rho: Vec<f64>,
}

impl Whitening {
    /// With this ρ of each joint.
    pub fn new(rho: Vec<f64>) -> Self {
        Whitening { rho }
    }

    /// Whether it changes anything.
    pub fn is_any(&self) -> bool {
        self.rho.iter().any(|&rho| rho > 0.0)
    }

    fn of(&self, joint: usize) -> f64 {
        self.rho.get(joint).copied().unwrap_or(0.0)
    }

    /// Whitens what belongs to a joint. A sample that does not count stays what it is, and tells nothing of the next.
    pub(super) fn apply(&self, joint: usize, values: &mut [f64], counts: &[bool]) {
        let rho = self.of(joint);
        if rho == 0.0 {
            return;
        }
        let mut before: Option<f64> = None;
        for (value, &counts) in values.iter_mut().zip(counts) {
            if !counts {
                before = None;
                continue;
            }
            let own = *value;
            *value = before.map_or((1.0 - rho * rho).sqrt() * own, |before| own - rho * before);
            before = Some(own);
        }
    }

    /// ρ₁ of noise of a joint that had ρ₁ = `before`, and ρ₂ = ρ₁².
    pub(super) fn correlation(&self, joint: usize, before: f64) -> f64 {
        let rho = self.of(joint);
        let energy = 1.0 + rho * rho - 2.0 * rho * before;
        ((1.0 + rho * rho) * before - rho * (1.0 + before * before)) / energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An autoregressive motion with known shocks leaves the shocks; behind a gap it begins anew.
    #[test]
    fn what_the_last_sample_tells_is_taken_away() {
        let rho = 0.9f64;
        let shocks: Vec<f64> = (0..40).map(|t| (f64::from(t) * 2.3).sin()).collect();
        let mut values: Vec<f64> = Vec::new();
        for shock in &shocks {
            values.push(values.last().map_or(shock / (1.0 - rho * rho).sqrt(), |last| rho * last + shock));
        }
        let mut counts = vec![true; values.len()];
        counts[20] = false;
        values[20] = 0.0;
        let plain = values.clone();
        let whitening = Whitening::new(vec![0.0, rho]);
        whitening.apply(1, &mut values, &counts);
        for (t, (value, shock)) in values.iter().zip(&shocks).enumerate().filter(|(t, _)| !(20..=21).contains(t)) {
            assert!((value - shock).abs() < 1e-12, "{t}: {value} for {shock}");
        }
        assert_eq!((values[20], values[21]), (0.0, (1.0 - rho * rho).sqrt() * plain[21]));
        let mut untouched = plain.clone();
        whitening.apply(0, &mut untouched, &counts);
        Whitening::default().apply(1, &mut untouched, &counts);
        assert_eq!(untouched, plain);
        assert!(whitening.is_any() && !Whitening::default().is_any() && !Whitening::new(vec![0.0]).is_any());
    }

    #[test]
    fn noise_that_was_filtered_keeps_a_resemblance() {
        let whitening = Whitening::new(vec![0.8, 0.0]);
        assert!(whitening.correlation(0, 0.8).abs() < 1e-12, "its own kind of motion has none left");
        assert!((whitening.correlation(0, 0.0) + 0.8 / 1.64).abs() < 1e-12, "white noise is the worse for it");
        assert_eq!(whitening.correlation(1, 0.3), 0.3);
    }
}
