//! Between motor and link: a stiff shaft with the rotor's inertia on it, or an elastic gear, perhaps with backlash.
//!
//! All in coordinates of the joint, so inertia is that of the rotor times the gear ratio squared, and so on.
//! Two-mass model: Spong, Journal of Dynamic Systems, Measurement and Control 109 (1987) 310, without the small coupling of
//! the rotor's spin with the motion of the links before it.

use super::plan::Slot;

/// What transmits the motor's torque to the link.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) enum Transmission {
    /// Motor and link are one.
    #[default]
    Direct,
    /// The rotor turns with the link.
    Stiff {
        /// I_r \[kg m²\]
        inertia: f64,
    },
    /// The rotor turns by itself.
    Elastic(Gear),
}

/// Rotor and spring, with the rotor's motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Gear {
    /// I_r \[kg m²\]
    pub(super) inertia: f64,
    /// k \[N m/rad\]
    pub(super) stiffness: f64,
    /// d \[N m s/rad\]
    pub(super) damping: f64,
    /// Width of the play \[rad\].
    pub(super) play: f64,
    /// Where the work of the elasticity is counted.
    pub(super) slot: Slot,
    /// Position of the rotor \[rad\].
    pub(super) position: f64,
    /// Velocity of the rotor \[rad/s\].
    pub(super) velocity: f64,
    /// Acceleration of the rotor in the last step \[rad/s²\].
    pub(super) acceleration: f64,
}

impl Gear {
    /// Lets the motor turn the rotor for a step; gives the torque that reaches the link.
    pub(super) fn turn(&mut self, motor: f64, q: f64, qd: f64, step: f64) -> f64 {
        let twist = self.position - q;
        let wound = twist - twist.clamp(-0.5 * self.play, 0.5 * self.play);
        let torque = match wound {
            0.0 => 0.0,
            // Teeth push, they don't pull.
            _ => {
                let torque = self.stiffness * wound + self.damping * (self.velocity - qd);
                if self.play > 0.0 && torque * wound < 0.0 { 0.0 } else { torque }
            }
        };
        self.acceleration = (motor - torque) / self.inertia;
        self.velocity += step * self.acceleration;
        self.position += step * self.velocity;
        torque
    }

    /// At rest at a position of the joint, wound up by a torque.
    pub(super) fn rest(&mut self, q: f64, torque: f64) {
        self.position = q + torque / self.stiffness + 0.5 * self.play * sign(torque);
        (self.velocity, self.acceleration) = (0.0, 0.0);
    }
}

fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gear(play: f64) -> Gear {
        let (stiffness, damping) = (400.0, 0.2);
        let (slot, position, velocity, acceleration) = (0, 0.0, 0.0, 0.0);
        Gear { inertia: 0.1, stiffness, damping, play, slot, position, velocity, acceleration }
    }

    #[test]
    fn a_rotor_against_a_held_link_swings_with_its_own_frequency() {
        let (mut gear, step) = (gear(0.0), 1e-5);
        gear.position = 0.01;
        let mut crossings = Vec::new();
        for number in 0..200_000 {
            let before = gear.position;
            gear.turn(0.0, 0.0, 0.0, step);
            if before > 0.0 && gear.position <= 0.0 {
                crossings.push(f64::from(number) * step);
            }
        }
        let periods = (crossings.len() - 1) as f64;
        let found = periods / (crossings[crossings.len() - 1] - crossings[0]);
        let expected = ((400.0_f64 / 0.1) - (0.5 * 0.2 / 0.1_f64).powi(2)).sqrt() / std::f64::consts::TAU;
        assert!((found - expected).abs() < 1e-3 * expected, "{found} Hz is not {expected} Hz");
    }

    #[test]
    fn nothing_passes_within_the_play_and_all_of_it_at_rest_beyond() {
        let mut gear = gear(0.02);
        assert_eq!(gear.turn(0.0, 0.005, 0.0, 1e-4), 0.0);
        gear.rest(0.3, 2.0);
        let (position, torque) = (gear.position, gear.turn(2.0, 0.3, 0.0, 1e-4));
        assert!((torque - 2.0).abs() < 1e-12 && (gear.position - position).abs() < 1e-12);
        assert!((position - 0.3 - 2.0 / 400.0 - 0.01).abs() < 1e-12);
    }
}
