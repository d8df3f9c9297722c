//! The columns of an effect as formulas in what moves now: what a controller can compute, in whatever language.

use super::Scope;
use super::own::{Formula, Of, Quantity, Writer};

/// For each linear parameter the torque that its unit value makes, as formulas, and the joints on which they act.
#[derive(Debug, Clone)]
pub struct ClosedForm {
    columns: Vec<Vec<(Of, Formula)>>,
}

/// What one linear parameter makes, by the joints on which it acts.
pub type Parts<Value> = Vec<(usize, Value)>;

impl ClosedForm {
    /// Of these formulas; `None` if one speaks of the time.
    pub(super) fn of(columns: Vec<Vec<(Of, Formula)>>) -> Option<ClosedForm> {
        let knows_time = columns.iter().flatten().any(|(_, formula)| formula.knows_time());
        (!knows_time).then_some(ClosedForm { columns })
    }

    /// Of an effect on one joint: a formula for each linear parameter, in the channels of its joint and in these shape
    /// parameters.
    pub(super) fn on_joint(columns: &[&str], shapes: &[&str]) -> Option<ClosedForm> {
        let formula = |text: &&str| Some(vec![(Of::Own, Formula::parse(text, Scope::Joint, shapes).ok()?)]);
        ClosedForm::of(columns.iter().map(formula).collect::<Option<_>>()?)
    }

    /// Of an effect on a pair of joints: for each linear parameter the formulas of the joints on which it acts.
    pub(super) fn on_pair(columns: &[&[(Of, &str)]]) -> Option<ClosedForm> {
        let part = |&(of, text): &(Of, &str)| Some((of, Formula::parse(text, Scope::Pair, &[]).ok()?));
        let column = |parts: &&[(Of, &str)]| parts.iter().map(part).collect::<Option<Vec<_>>>();
        ClosedForm::of(columns.iter().map(column).collect::<Option<_>>()?)
    }

    /// Hands all formulas to a writer, on an arm of so many joints, for the effect on the joint `own` (from 0): for each linear
    /// parameter the joints on which it acts, and what acts there. `None` if a formula speaks of a joint that is not there.
    pub fn write<W: Writer>(
        &self,
        joints: usize,
        own: usize,
        shape: &[W::Value],
        writer: &mut W,
        mut channel: impl FnMut(&mut W, Quantity, usize) -> W::Value,
    ) -> Option<Vec<Parts<W::Value>>> {
        let mut part = |(of, formula): &(Of, Formula)| {
            Some((of.among(joints, own)?, formula.write(joints, own, shape, writer, &mut channel)?))
        };
        self.columns.iter().map(|parts| parts.iter().map(&mut part).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Sample;
    use super::super::{Motion, registry};

    /// What is written in another language is what is computed here.
    #[test]
    fn closed_forms_are_the_columns() {
        let sample = Sample::new();
        let widths = [0.0, 0.3, 0.0];
        let motion = Motion { reversal_widths: &widths, ..sample.motion() };
        let mut written = 0;
        for effect in registry::addable() {
            let Some(form) = effect.closed_form() else { continue };
            let shape: Vec<f64> = effect.shapes().map(|(_, starts)| starts.values([-1.0, 1.2])[0]).collect();
            let columns = effect.columns(&motion, 1, &shape).unwrap();
            assert_eq!(columns.len(), form.columns.len(), "{}", effect.id);
            for (column, parts) in columns.iter().zip(&form.columns) {
                for (of, formula) in parts {
                    let joint = of.among(3, 1).unwrap();
                    let values = formula.values(&motion, 1, &shape).unwrap();
                    let (_, own) = column.parts.iter().find(|(acting, _)| *acting == joint).unwrap();
                    let agree = values.iter().zip(own).all(|(a, b)| (a - b).abs() < 1e-12);
                    assert!(agree, "{}, joint {joint}: {values:?} is not {own:?}", effect.id);
                }
                assert_eq!(column.parts.len(), parts.len(), "{}", effect.id);
            }
            written += 1;
        }
        assert_eq!(written, 20, "effects have a closed form");
    }
}
