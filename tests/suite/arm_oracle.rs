//! The planar arm against an independent computation: a closed form that was checked against Pinocchio 4.1.0.

use torquescope::arm::{Arm, Link, Posture, Sense};

use crate::oracle::Oracle;
use crate::outside;

const TOLERANCE: f64 = 1e-9;

/// Largest error relative to the largest entry.
fn assert_close(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let error = found.iter().zip(expected).fold(0.0_f64, |error, (a, b)| error.max((a - b).abs()));
    println!("{what}: error {:.1e} of {largest:.1e}", error / largest.max(1e-300));
    assert!(error <= TOLERANCE * largest, "{what}: off by {error:e}, the largest entry is {largest:e}");
}

#[test]
fn equals_the_reference_for_one_to_seven_joints() {
    let of = |n: usize| outside::references().into_iter().map(move |folder| (n, folder));
    for (n, folder) in [1, 2, 3, 5, 7].into_iter().flat_map(of) {
        let mut reference = Oracle::open(&folder.join(format!("arm/oracle_planar_n{n}.npz")));
        let [m, l, r, inertia, gravity, phi0, set] =
            ["m", "l", "r", "I", "gravity", "phi0", "set"].map(|name| reference.array(name));
        let [q, qd, qdd] = ["q", "qd", "qdd"].map(|name| reference.array(name));

        let [mut tau, mut mass, mut coriolis, mut weight, mut kinetic, mut potential] = [const { Vec::new() }; 6];
        for (sample, &set) in set.iter().enumerate() {
            let set = set as usize;
            let arm = Arm {
                links: (set * n..(set + 1) * n)
                    .map(|i| Link { mass: m[i], length: l[i], com: r[i], inertia: inertia[i] })
                    .collect(),
                gravity: gravity[set],
                posture: Posture { zero_angle: phi0[set], sense: Sense::CounterClockwise },
            };
            let state = sample * n..(sample + 1) * n;
            let (q, qd, qdd) = (&q[state.clone()], &qd[state.clone()], &qdd[state]);
            tau.extend(arm.inverse_dynamics(q, qd, qdd));
            mass.extend_from_slice(arm.mass_matrix(q).as_slice()); // symmetric: row order is column order
            coriolis.extend(arm.coriolis(q, qd));
            weight.extend(arm.gravity_torque(q));
            kinetic.push(arm.kinetic_energy(q, qd));
            potential.push(arm.potential_energy(q));
        }
        for (name, found) in
            [("tau", tau), ("H", mass), ("c", coriolis), ("g", weight), ("T", kinetic), ("V", potential)]
        {
            assert_close(&format!("{name} of {n} joints"), &found, &reference.array(name));
        }
    }
}
