//! The model as figures.

use super::diagram;
use super::share::Share;
use crate::figure::mark::Bars;
use crate::figure::{Axis, Ink, Panel};
use crate::model::Term;
use crate::recording::Recording;
use crate::session::Step;

/// Width for which the drawing of the structure is laid out \[points\].
const WIDTH: f64 = 760.0;

/// How the model is wired, and what each of its terms carries: the root mean square of its torque over that of the measured one.
pub fn figures(recording: &Recording, step: &Step, shares: &[Vec<Share>]) -> Vec<Panel> {
    let (model, joints) = (&step.fitted.model, recording.joint_count());
    let terms = model.terms.iter().map(Term::label).collect();
    let axes = [Axis::names("", terms), Axis::new("RMS over that of the measured torque", "")];
    let mut carried = Panel::new("what each term carries", axes);
    for (joint, info) in recording.joints.iter().enumerate() {
        let heights: Vec<[f64; 3]> = shares.iter().map(|shares| [shares[joint].part, f64::NAN, f64::NAN]).collect();
        carried.push(Bars::beside(&info.name, [joint, joints], &heights, Ink::Series(joint)));
    }
    vec![diagram::figure(model, joints, WIDTH), carried]
}
