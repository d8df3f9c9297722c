//! The contact of dry friction: bristles that bend before they slide.
//!
//! LuGre (Canudas de Wit, Olsson, Åström, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419): with the deflection z in
//! units of the one at which a level of 1 slides,
//!
//! ```text
//! dz/dt = (q̇ − |q̇| z / level) / reach        torque = z + micro-damping · dz/dt
//! ```

/// Time constant of the bristles' own damping \[s\]; it ends their ringing when a joint sticks, and is nothing in sliding.
const MICRO_DAMPING: f64 = 1e-3;

/// The bristles of one joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bristle {
    deflection: f64,
}

impl Bristle {
    /// Moves the contact at velocity `qd` for a step; `reach` \[rad\] is how far it goes before it slides at level 1.
    ///
    /// Gives the friction as a share: 1 is sliding at level 1. The step is implicit in the deflection, so it is stable however
    /// short the reach.
    pub(super) fn slide(&mut self, qd: f64, level: f64, reach: f64, step: f64) -> f64 {
        let travel = qd * step / reach;
        let before = self.deflection;
        self.deflection = (before + travel) / (1.0 + travel.abs() / level.max(1e-9));
        self.deflection + MICRO_DAMPING * (self.deflection - before) / step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slides_at_its_level_and_holds_like_a_spring_before() {
        let mut bristle = Bristle::default();
        let mut share = 0.0;
        for _ in 0..1000 {
            share = bristle.slide(0.5, 1.3, 1e-3, 1e-4);
        }
        assert!((share - 1.3).abs() < 1e-9, "{share}");
        let mut bristle = Bristle::default();
        for _ in 0..10 {
            bristle.slide(1e-3, 1.0, 1e-3, 1e-4);
        }
        // 1 µrad of 1 mrad, and then at rest.
        let held = bristle.slide(0.0, 1.0, 1e-3, 1e-4);
        assert!((held - 1e-3).abs() < 2e-6, "{held}");
    }
}
