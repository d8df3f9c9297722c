//! Proposals in words, for the command line and the window.

use super::{Dependence, Nature, Proposal, Remainder};
use crate::recording::Joint;

/// Most channels that are told by themselves.
const MOST_CHANNELS: usize = 5;

/// A share in per cent.
pub fn percent(share: f64) -> String {
    format!("{:.*} %", usize::from(share.abs() < 0.1), 100.0 * share)
}

impl Remainder {
    /// What is left on the joint, and what it is.
    pub fn sentence(&self, joint: &Joint) -> String {
        let nature = match self.nature {
            Nature::Noise => "it is noise, or too little to tell".to_owned(),
            Nature::Static => format!("{} of it follows from the state of the arm", percent(self.predicted)),
            Nature::Memory => format!(
                "it has a memory: no function of the state predicts it, but about {:.0} neighbouring samples say the same, so it \
                 is no noise. Something moves, bends, swings or warms up that is not measured",
                self.correlation
            ),
        };
        let (name, unit) = (&joint.name, joint.kind.units()[3]);
        format!("{name}: {:.3} {unit} RMS are left, {} of the torque; {nature}.", self.rms, percent(self.share))
    }

    /// On which channels it depends: alone, together, and in order. Nothing if it depends on none.
    pub fn dependence(&self) -> Vec<(&'static str, String)> {
        if self.nature != Nature::Static {
            return Vec::new();
        }
        let one =
            |dependence: &Dependence| format!("{} {}", dependence.channels.join(" and "), percent(dependence.share));
        let alone: Vec<String> =
            self.channels.iter().filter(|channel| channel.share > 0.0).take(MOST_CHANNELS).map(one).collect();
        let together: Vec<String> = self.pairs.iter().map(one).collect();
        let order: Vec<String> =
            self.order.iter().map(|step| format!("{} {}", step.channel, percent(step.share))).collect();
        let lists =
            [("alone", alone.join(", ")), ("together", together.join(", ")), ("in order", order.join(", then "))];
        lists.into_iter().filter(|(_, list)| !list.is_empty()).collect()
    }
}

impl Proposal {
    /// What is to be said beside its numbers.
    pub fn remarks(&self, joint: &Joint) -> Vec<String> {
        let mut remarks = Vec::new();
        if let Some(effect) = self.known {
            remarks.push(format!("is {} of the catalogue: add {}@{}", effect.name, effect.id, self.joint + 1));
        }
        if !self.look_alikes.is_empty() {
            remarks.push(format!("is hardly told from {}", self.look_alikes.join(", ")));
        }
        if let Some(offset) = self.offset {
            remarks.push(format!("has a constant beside it: {offset:.3} {}", joint.kind.units()[3]));
        }
        remarks
    }
}

#[cfg(test)]
mod tests {
    use super::super::Step;
    use super::*;

    #[test]
    fn a_small_share_has_a_digit_more() {
        assert_eq!([0.0, 0.042, -0.042, 0.42, 1.0].map(percent), ["0.0 %", "4.2 %", "-4.2 %", "42 %", "100 %"]);
    }

    fn remainder(nature: Nature) -> Remainder {
        let dependence = |channels: &[&str], share| Dependence {
            channels: channels.iter().map(|it| it.to_string()).collect(),
            share,
        };
        let step = |channel: &str, share| Step { channel: channel.to_owned(), share };
        Remainder {
            joint: 0,
            rms: 1.25,
            share: 0.05,
            nature,
            predicted: 0.9,
            correlation: 12.4,
            channels: vec![dependence(&["qd1"], 0.8), dependence(&["q1"], 0.3), dependence(&["t"], -0.1)],
            pairs: vec![dependence(&["q1", "qd1"], 0.88)],
            order: vec![step("qd1", 0.8), step("q1", 0.9)],
        }
    }

    #[test]
    fn what_is_left_is_said_with_what_it_is() {
        let said = |nature| remainder(nature).sentence(&Joint::numbered(1));
        let name = &Joint::numbered(1).name;
        let open = format!("{name}: 1.250 N m RMS are left, 5.0 % of the torque; ");
        assert_eq!(said(Nature::Noise), format!("{open}it is noise, or too little to tell."));
        assert_eq!(said(Nature::Static), format!("{open}90 % of it follows from the state of the arm."));
        assert!(said(Nature::Memory).contains("about 12 neighbouring samples say the same"));
    }

    #[test]
    fn only_what_follows_from_the_state_says_from_which_channels() {
        let lists =
            [("alone", "qd1 80 %, q1 30 %"), ("together", "q1 and qd1 88 %"), ("in order", "qd1 80 %, then q1 90 %")];
        assert_eq!(remainder(Nature::Static).dependence(), lists.map(|(what, list)| (what, list.to_owned())));
        assert!(remainder(Nature::Memory).dependence().is_empty() && remainder(Nature::Noise).dependence().is_empty());
        let alone = Remainder { pairs: Vec::new(), order: Vec::new(), ..remainder(Nature::Static) };
        assert_eq!(alone.dependence().len(), 1);
    }
}
