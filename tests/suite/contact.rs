//! A log of a pendulum that meets a bumper in four of twenty time blocks alone: where nothing is learned when nobody chooses what is
//! held out. Formulas of this file, none of the program's.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

const BLOCKS: usize = 20;
const SAMPLES_OF_BLOCK: usize = 150;
const TIME_STEP: f64 = 0.01;
/// The blocks with a contact, counted from 0.
const WITH_CONTACT: [usize; 4] = [2, 9, 11, 18];
/// Where the bumper is \[rad\]; nothing but a contact brings the arm there.
pub const STOP: f64 = -1.6;
/// Its stiffness \[N m/rad\].
pub const STIFFNESS: f64 = 25.0;

/// As CSV; at q = 0 the arm hangs.
pub fn log() -> String {
    let mut text = "time,q1,qd1,qdd1,tau1\n".to_owned();
    let mut noise = 1u32;
    for sample in 0..BLOCKS * SAMPLES_OF_BLOCK {
        let time = sample as f64 * TIME_STEP;
        let (mut q, mut qd, mut qdd) = (0.0, 0.0, 0.0);
        for (amplitude, pulse, phase) in [(0.7, 1.3, 0.0), (0.5, 2.9, 1.0), (0.2, 5.3, 2.0)] {
            let (sin, cos) = f64::sin_cos(pulse * time + phase);
            q += amplitude * sin;
            qd += amplitude * pulse * cos;
            qdd -= amplitude * pulse * pulse * sin;
        }
        if WITH_CONTACT.contains(&(sample / SAMPLES_OF_BLOCK)) {
            let length = SAMPLES_OF_BLOCK as f64 * TIME_STEP;
            let (depth, angle) = (2.2, TAU * (time % length) / length);
            q -= depth * (1.0 - angle.cos()) / 2.0;
            qd -= depth * PI / length * angle.sin();
            qdd -= depth * PI / length * TAU / length * angle.cos();
        }
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let scatter = 0.05 * (f64::from(noise) / f64::from(u32::MAX) - 0.5);
        // The bumper pushes up, so that the motor has less to do.
        let tau = 0.6 * qdd + 7.0 * q.sin() - STIFFNESS * (STOP - q).max(0.0) + scatter;
        writeln!(text, "{time:.2},{q},{qd},{qdd},{tau}").unwrap();
    }
    text
}
