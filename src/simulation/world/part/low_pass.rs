//! The first-order lag that current loops and filters have.

/// dy/dt = (x − y) / T, exact for an input that is held for each step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LowPass {
    value: Option<f64>,
}

impl LowPass {
    /// The output after a step; the first input is taken as it is.
    pub(super) fn follow(&mut self, input: f64, time: f64, step: f64) -> f64 {
        let before = self.value.unwrap_or(input);
        let value = before - (input - before) * (-step / time).exp_m1();
        self.value = Some(value);
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_by_its_time_constant_whatever_the_step() {
        for steps in [1, 7, 300] {
            let mut filter = LowPass::default();
            filter.follow(0.0, 0.2, 0.2);
            let mut value = 0.0;
            for _ in 0..steps {
                value = filter.follow(1.0, 0.2, 0.2 / f64::from(steps));
            }
            assert!((value - (1.0 - (-1.0_f64).exp())).abs() < 1e-12, "{value}");
        }
    }
}
