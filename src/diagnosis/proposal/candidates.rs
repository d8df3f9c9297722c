//! The formulas that are tried: products of what physics is made of. Each is a text that an effect of one's own can have, with
//! its values computed from the same parts.

use crate::effect::own::Formula;
use crate::effect::{Lack, Motion, Scope};
use crate::recording::JointKind;

/// Up to so many joints every sum of neighbouring angles is a direction of a link; with more, only pairs are tried.
const MOST_FOR_ALL_SUMS: usize = 4;

/// A formula, made of factors.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The formula, in the channels of all joints.
    pub text: String,
    /// Its factors, as places among [`Library::atoms`].
    factors: Vec<usize>,
    /// How much it asks one to believe: its operations, and channels of other joints.
    pub cost: usize,
    powers: Powers,
}

/// A factor of formulas.
#[derive(Debug, Clone)]
pub struct Atom {
    text: String,
    powers: Powers,
    cost: usize,
}

/// The dimension of a formula, in halves of the powers of its units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Powers {
    radian: i32,
    metre: i32,
    second: i32,
    torque: i32,
}

/// All formulas for the remainder of one joint.
#[derive(Debug, Clone)]
pub struct Library {
    /// What they are made of.
    pub atoms: Vec<Atom>,
    /// The formulas.
    pub candidates: Vec<Candidate>,
}

impl Powers {
    fn plus(self, other: Powers) -> Powers {
        Powers {
            radian: self.radian + other.radian,
            metre: self.metre + other.metre,
            second: self.second + other.second,
            torque: self.torque + other.torque,
        }
    }

    /// The unit of the factor that makes a torque on a joint of this kind of it.
    fn unit_of_factor(self, kind: JointKind) -> String {
        let torque = kind.units()[3];
        let raised = |unit: &str, halves: i32| match (halves, halves % 2) {
            (2, _) => unit.to_owned(),
            (4, _) => format!("{unit}²"),
            (6, _) => format!("{unit}³"),
            (_, 0) => format!("{unit}^{}", halves / 2),
            _ => format!("{unit}^{:.1}", f64::from(halves) / 2.0),
        };
        let parts = [("rad", self.radian), ("m", self.metre), ("s", self.second), (torque, self.torque - 2)];
        let side = |sign: i32| {
            let there = parts.iter().filter(|(_, halves)| halves * sign > 0);
            there.map(|&(unit, halves)| raised(unit, halves * sign)).collect::<Vec<_>>()
        };
        // The torque itself is the first thing that one reads.
        let (mut above, below) = (side(-1), side(1));
        if self.torque < 2 && !above.is_empty() {
            above.rotate_right(1);
        }
        let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.as_slice() {
            [] => above,
            [one] => format!("{above}/{one}"),
            several => format!("{above}/({})", several.join(" ")),
        }
    }
}

impl Atom {
    /// Its values along a motion.
    ///
    /// # Errors
    /// [`Lack`] if the motion lacks a channel.
    pub fn values(&self, motion: &Motion) -> Result<Vec<f64>, Lack> {
        values(&self.text, motion)
    }
}

/// The values of a formula in the channels of all joints.
///
/// # Errors
/// [`Lack`] if the motion lacks a channel.
pub fn values(text: &str, motion: &Motion) -> Result<Vec<f64>, Lack> {
    let formula = Formula::parse(text, Scope::Arm, &[]).expect("a test reads all formulas that are tried");
    formula.values(motion, 0, &[])
}

impl Candidate {
    /// Its values, from those of the atoms.
    pub fn values(&self, atoms: &[Vec<f64>]) -> Vec<f64> {
        let mut factors = self.factors.iter().map(|&factor| &atoms[factor]);
        let mut product = factors.next().cloned().unwrap_or_default();
        for factor in factors {
            product.iter_mut().zip(factor).for_each(|(product, factor)| *product *= factor);
        }
        product
    }

    /// The unit of its factor, on a joint of this kind.
    pub fn unit(&self, kind: JointKind) -> String {
        self.powers.unit_of_factor(kind)
    }
}

impl Library {
    /// All formulas for the remainder of `joint`, of an arm with joints of these kinds.
    pub fn new(joint: usize, kinds: &[JointKind]) -> Library {
        let mut library = Library { atoms: Vec::new(), candidates: Vec::new() };
        library.fill(joint, kinds);
        library
    }

    fn atom(&mut self, text: String, powers: Powers, cost: usize) -> usize {
        self.atoms.push(Atom { text, powers, cost });
        self.atoms.len() - 1
    }

    fn candidate(&mut self, factors: &[usize]) {
        let atoms: Vec<&Atom> = factors.iter().map(|&factor| &self.atoms[factor]).collect();
        let candidate = Candidate {
            text: atoms.iter().map(|atom| atom.text.as_str()).collect::<Vec<_>>().join(" * "),
            factors: factors.to_vec(),
            cost: atoms.iter().map(|atom| atom.cost).sum(),
            powers: atoms.iter().fold(Powers::default(), |sum, atom| sum.plus(atom.powers)),
        };
        self.candidates.push(candidate);
    }

    fn fill(&mut self, joint: usize, kinds: &[JointKind]) {
        let joints = kinds.len();
        // What is its own comes to mind before what is another's.
        let cost = |first: usize, last: usize| 1 + (last - first) + usize::from(first != joint || last != joint);
        let length = |joint: usize, halves: i32, second: i32| match kinds[joint] {
            JointKind::Revolute => Powers { radian: halves, second, ..Powers::default() },
            JointKind::Prismatic => Powers { metre: halves, second, ..Powers::default() },
        };
        let none = Powers::default();
        let sum = |quantity: &str, first: usize, last: usize| {
            let names: Vec<String> = (first..=last).map(|joint| format!("{quantity}{}", joint + 1)).collect();
            if names.len() == 1 { names[0].clone() } else { format!("({})", names.join(" + ")) }
        };
        let longest = if joints <= MOST_FOR_ALL_SUMS { joints } else { 2 };
        let spans: Vec<(usize, usize)> = (0..joints)
            .flat_map(|first| (first..joints.min(first + longest)).map(move |last| (first, last)))
            .filter(|&(first, last)| kinds[first..=last].iter().all(|kind| *kind == kinds[first]))
            .collect();

        let mut waves = Vec::new();
        for &(first, last) in spans.iter().filter(|(first, _)| kinds[*first] == JointKind::Revolute) {
            let angle = sum("q", first, last);
            let angle = angle.trim_matches(['(', ')']);
            for function in ["sin", "cos"] {
                waves.push(self.atom(format!("{function}({angle})"), none, 1 + cost(first, last)));
            }
        }
        let own_waves = waves.len();
        let mut differences = Vec::new();
        for (first, second) in (0..joints).flat_map(|first| (first + 1..joints).map(move |second| (first, second))) {
            if kinds[first] == kinds[second] {
                let [one, other] = [first + 1, second + 1];
                differences.push(self.atom(
                    format!("(q{one} - q{other})"),
                    length(first, 2, 0),
                    1 + cost(first, second),
                ));
                if kinds[first] == JointKind::Revolute {
                    waves.push(self.atom(format!("sin(q{one} - q{other})"), none, 2 + cost(first, second)));
                    waves.push(self.atom(format!("cos(q{one} - q{other})"), none, 2 + cost(first, second)));
                }
            }
        }
        let mut positions = Vec::new();
        for &(first, last) in &spans {
            positions.push(self.atom(sum("q", first, last), length(first, 2, 0), cost(first, last)));
        }
        // Of each span: its speed, and the size of that.
        let (mut speeds, mut plain_speeds, mut sizes, mut own_signs) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for &(first, last) in &spans {
            let (qd, cost) = (sum("qd", first, last), cost(first, last));
            let of = |halves: i32| length(first, halves, -halves);
            let inner = qd.trim_matches(['(', ')']).to_owned();
            let plain = self.atom(qd.clone(), of(2), cost);
            // Of one joint, as friction has it; of a sum, as mathematics has it.
            let word = if first == last { format!("direction{}", first + 1) } else { format!("sign({inner})") };
            let sign = self.atom(word.clone(), none, 1 + cost);
            let size = self.atom(format!("abs({inner})"), of(2), 1 + cost);
            plain_speeds.push(plain);
            sizes.push(size);
            own_signs.extend((first == joint && last == joint).then_some(sign));
            speeds.extend([
                plain,
                sign,
                size,
                self.atom(format!("{qd} * abs({inner})"), of(4), 1 + cost),
                self.atom(format!("{qd}^2"), of(4), 1 + cost),
            ]);
            if first == last {
                speeds.push(self.atom(format!("{qd}^3"), of(6), 2 + cost));
                speeds.push(self.atom(format!("{word} * sqrt(abs({inner}))"), of(1), 4 + cost));
            }
        }
        let accelerations: Vec<usize> = (0..joints)
            .map(|other| self.atom(format!("qdd{}", other + 1), length(other, 2, -4), cost(other, other)))
            .collect();
        let number = joint + 1;
        let torque = Powers { torque: 2, ..none };
        let load = self.atom(format!("tau_load{number}"), torque, 2);
        let size_of_load = self.atom(format!("abs(tau_load{number})"), torque, 3);
        let time = self.atom("t".to_owned(), Powers { second: 2, ..none }, 1);

        for &atom in waves.iter().chain(&positions).chain(&differences).chain(&speeds).chain(&accelerations) {
            self.candidate(&[atom]);
        }
        let multiplied = if joints <= MOST_FOR_ALL_SUMS { waves.len() } else { own_waves };
        for &wave in &waves[..multiplied] {
            speeds.iter().chain(&accelerations).for_each(|&other| self.candidate(&[wave, other]));
        }
        // The spans that are one joint; the lists of positions and speeds are by span.
        let singles: Vec<usize> = (0..spans.len()).filter(|&place| spans[place].0 == spans[place].1).collect();
        for &place in &singles {
            let position = positions[place];
            let text = self.atoms[position].text.clone();
            let (powers, cost) = (self.atoms[position].powers, self.atoms[position].cost);
            for power in [2, 3] {
                let raised = (1..power).fold(powers, |sum, _| sum.plus(powers));
                let atom = self.atom(format!("{text}^{power}"), raised, power as usize + cost);
                self.candidate(&[atom]);
            }
            for &other in &singles {
                self.candidate(&[position, plain_speeds[other]]);
                if other > place {
                    self.candidate(&[position, positions[other]]);
                }
                if other != place {
                    self.candidate(&[plain_speeds[place], sizes[other]]);
                    if other > place {
                        self.candidate(&[plain_speeds[place], plain_speeds[other]]);
                    }
                }
            }
            own_signs.iter().for_each(|&sign| self.candidate(&[position, sign]));
        }
        for &own in &own_signs {
            self.candidate(&[size_of_load, own]);
            self.candidate(&[time, own]);
        }
        self.candidate(&[load]);
        self.candidate(&[size_of_load]);
        self.candidate(&[time]);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::arm::{Arm, Posture};
    use crate::effect::Load;
    use crate::recording::{Channels, Trajectory};
    use crate::signals::Signals;

    /// What is offered to be adopted is what was computed.
    #[test]
    fn every_text_has_the_values_of_its_factors() {
        let arm = Arm::uniform(3);
        let signal = |scale: f64| Signals::from_fn(3, 9, |joint, t| scale * (t as f64 - 3.6 + 1.3 * joint as f64));
        let time: Vec<f64> = (0..9).map(|t| 0.1 * t as f64).collect();
        let channels = Channels { time, q: signal(0.3), qd: signal(-0.4), qdd: signal(0.9), tau: signal(0.0) };
        let run = Trajectory::new("", channels).unwrap();
        let load = Load::of_arm(&arm, &run);
        let kinds = [JointKind::Revolute; 3];
        let motion = Motion {
            trajectory: &run,
            kinds: &kinds,
            posture: Posture::RIGHT,
            gravity: arm.gravity,
            reversal_widths: &[],
            arm: Some(&arm),
            chain: None,
            load: Some(&load),
        };
        let library = Library::new(1, &kinds);
        let atoms: Vec<Vec<f64>> = library.atoms.iter().map(|atom| atom.values(&motion).unwrap()).collect();
        for candidate in &library.candidates {
            let by_text = values(&candidate.text, &motion).unwrap();
            let by_factors = candidate.values(&atoms);
            let are_close = by_text.iter().zip(&by_factors).all(|(one, other)| (one - other).abs() < 1e-12);
            assert!(are_close, "{}: {by_text:?} {by_factors:?}", candidate.text);
        }
        let texts: HashSet<&str> = library.candidates.iter().map(|candidate| candidate.text.as_str()).collect();
        assert_eq!(texts.len(), library.candidates.len(), "one stands there twice");
        for wanted in [
            "sin(q1) * qd2 * abs(qd2)",
            "(q1 + q2)",
            "(qd1 + qd2 + qd3) * abs(qd1 + qd2 + qd3)",
            "cos(q2 + q3)",
            "q2 * direction2",
        ] {
            assert!(texts.contains(wanted), "{wanted}: {texts:?}");
        }
        let units = |text: &str| {
            let found = library.candidates.iter().find(|candidate| candidate.text == text);
            found.map(|candidate| candidate.unit(JointKind::Revolute)).unwrap()
        };
        for (text, unit) in [
            ("sin(q1)", "N m"),
            ("qd2", "N m s/rad"),
            ("sin(q1) * qd2 * abs(qd2)", "N m s²/rad²"),
            ("(q1 + q2)", "N m/rad"),
            ("qdd3", "N m s²/rad"),
            ("direction1 * sqrt(abs(qd1))", "N m s^0.5/rad^0.5"),
            ("abs(tau_load2) * direction2", "1"),
            ("t", "N m/s"),
        ] {
            assert_eq!(units(text), unit, "{text}");
        }
    }

    #[test]
    fn an_arm_of_seven_joints_has_no_more_than_can_be_tried() {
        let count = |joints: usize| Library::new(0, &vec![JointKind::Revolute; joints]).candidates.len();
        assert!((20..60).contains(&count(1)), "{}", count(1));
        assert!((300..900).contains(&count(3)), "{}", count(3));
        assert!(count(7) < 6000, "{}", count(7));
        let sliding = Library::new(0, &[JointKind::Prismatic]);
        assert!(sliding.candidates.iter().all(|candidate| !candidate.text.contains("sin")));
        assert_eq!(
            sliding.candidates.iter().find(|candidate| candidate.text == "qd1").unwrap().unit(JointKind::Prismatic),
            "N s/m"
        );
    }
}
