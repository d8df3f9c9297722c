//! Effects of one's own: a TOML file with formulas is an [`Effect`] like any other, for as long as the program runs.
//!
//! ```toml
//! id = "cable"
//! description = "A cable pulls at the joint, the more so the faster it is paid out."
//! source = "our bench, 3 May"
//!
//! [[linear]]
//! name = "pull"
//! unit = "N m"
//! min = 0.0
//! column = "tanh(qd / v) * cos(q2)"
//!
//! [[shape]]
//! name = "v"
//! unit = "rad/s"
//! start = [0.1, 0.4, 1.6]
//! ```
//!
//! [`load`] reads it, [`super::registry::find`] knows it from then on, and a model or a session that uses it keeps its text
//! ([`Facts::written`](super::Facts::written)), so that it can be read where the file is not.

mod draft;
mod expression;
mod file;
mod formula;

use std::sync::{PoisonError, RwLock};

pub use draft::{Draft, DraftColumn};
pub use expression::{Expression, Input, Mistake, Writer};
use file::Definition;
pub use formula::{Formula, Of, Quantity};

use super::{Effect, registry};

/// A file is no effect, or can't be had beside those that there are.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum OwnEffectError {
    /// Something in it is wrong.
    #[error("line {line}, column {column}: {what}")]
    Wrong {
        /// Counted from 1.
        line: usize,
        /// Counted from 1, in letters.
        column: usize,
        /// What is wrong, and how to mend it.
        what: String,
    },
    /// The program has an effect of this id.
    #[error("the program has an effect `{0}` already: give yours another id")]
    Taken(String),
    /// Another file has stated this id otherwise.
    #[error("an effect `{0}` that says something else is in use already: give this one another id, such as `{0}-2`")]
    Changed(String),
}

impl OwnEffectError {
    /// What is wrong at an offset (in bytes) of the text.
    fn at(text: &str, offset: usize, what: impl Into<String>) -> Self {
        let before = text.get(..offset).unwrap_or(text);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.rsplit('\n').next().unwrap_or_default().chars().count();
        OwnEffectError::Wrong { line, column, what: what.into() }
    }
}

/// What was loaded since the program began.
static LOADED: RwLock<Vec<(Definition, &'static Effect)>> = RwLock::new(Vec::new());

/// Every effect that was loaded, oldest first.
pub fn loaded() -> Vec<&'static Effect> {
    LOADED.read().unwrap_or_else(PoisonError::into_inner).iter().map(|(_, effect)| *effect).collect()
}

/// The effect that this text (TOML) states. The same text gives the same effect; what was loaded stays.
///
/// ```
/// use torquescope::effect::own;
///
/// let effect = own::load(include_str!("../../../examples/plate_drag.toml"))?;
/// assert_eq!(effect.id, "plate-drag");
/// assert_eq!(own::load(effect.facts.written.unwrap_or_default())?, effect);
/// # Ok::<(), own::OwnEffectError>(())
/// ```
///
/// # Errors
/// [`OwnEffectError`] says what is wrong, where, and how to mend it.
pub fn load(text: &str) -> Result<&'static Effect, OwnEffectError> {
    let file = Definition::parse(text)?;
    if registry::ALL.iter().any(|effect| effect.id == file.id()) {
        return Err(OwnEffectError::Taken(file.id().to_owned()));
    }
    let mut loaded = LOADED.write().unwrap_or_else(PoisonError::into_inner);
    match loaded.iter().find(|(_, effect)| effect.id == file.id()) {
        Some((same, effect)) if *same == file => Ok(effect),
        Some(_) => Err(OwnEffectError::Changed(file.id().to_owned())),
        None => {
            // It lives as long as the program, as those do that come with it.
            let effect: &'static Effect = Box::leak(Box::new(file.effect(text)?));
            loaded.push((file, effect));
            Ok(effect)
        }
    }
}

/// The texts of those effects that are one's own, each once.
pub fn texts(effects: impl IntoIterator<Item = &'static Effect>) -> Vec<String> {
    let mut texts: Vec<String> = Vec::new();
    for text in effects.into_iter().filter_map(|effect| effect.facts.written) {
        if !texts.iter().any(|known| known == text) {
            texts.push(text.to_owned());
        }
    }
    texts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::Sample;
    use crate::effect::{Axis, Dimension, Lack, Motion, Role, Scope, Starts};

    const STRIBECK: &str = include_str!("../../../examples/own_stribeck.toml");

    fn wrong(text: &str) -> String {
        load(text).map(|_| ()).unwrap_err().to_string()
    }

    /// A file of one column.
    fn stating(id: &str, column: &str) -> String {
        format!(
            "id = \"{id}\"\ndescription = \"d\"\nsource = \"s\"\n\n[[linear]]\nname = \"k\"\nunit = \"N m\"\n{column}\n"
        )
    }

    #[test]
    fn a_file_is_an_effect_like_the_built_in_one() {
        let own = load(STRIBECK).unwrap();
        let built_in = registry::find("stribeck-friction").unwrap();
        assert_eq!(registry::find("own-stribeck").unwrap(), own);
        let sample = Sample::new();
        let [one, other] = [own, built_in].map(|effect| effect.columns(&sample.motion(), 1, &[0.3]).unwrap());
        assert_eq!(one.len(), 2);
        for (one, other) in one.iter().zip(&other) {
            let ([(joint, one)], [(same, other)]) = (&one.parts[..], &other.parts[..]) else { panic!() };
            assert_eq!((joint, same), (&1, &1));
            assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-15));
        }
        assert_eq!((own.scope, own.axis), (Scope::Joint, Axis::Velocity));
        assert_eq!((own.parameters[0].min, own.parameters[2].max), (0.0, 10.0));
        assert_eq!(own.parameters[0].dimension, Dimension::Torque);
        assert_eq!(own.parameters[2].dimension, Dimension::Velocity);
        let Role::Shape { starts: Starts::Values(values), .. } = own.parameters[2].role else {
            panic!("it is a shape")
        };
        assert_eq!(values.len(), 6);
        assert!(own.formula.starts_with("tau = coulomb_torque * direction + "), "{}", own.formula);
    }

    #[test]
    fn the_same_file_is_the_same_effect_and_another_one_needs_another_id() {
        let text = stating("own-twice", "column = \"qd\"");
        let first = load(&text).unwrap();
        assert!(std::ptr::eq(first, load(&format!("# a remark\n{text}")).unwrap()));
        assert!(wrong(&text.replace("\"qd\"", "\"q\"")).contains("another id, such as `own-twice-2`"));
        assert!(
            wrong(&stating("coulomb-friction", "column = \"qd\"")).contains("has an effect `coulomb-friction` already")
        );
        assert_eq!(texts([first, registry::find("cogging").unwrap(), first]), [text]);
    }

    #[test]
    fn a_pair_and_an_arm_say_where_their_torque_acts() {
        let sample = Sample::new();
        let pair = stating("own-pair", "column = \"q + q_before\"\nbefore = \"q + q_before\"").replacen(
            "\n\n",
            "\nscope = \"pair\"\n\n",
            1,
        );
        let columns = load(&pair).unwrap().columns(&sample.motion(), 2, &[]).unwrap();
        let q = &sample.trajectory.q;
        assert_eq!(columns[0].parts.iter().map(|(joint, _)| *joint).collect::<Vec<_>>(), [2, 1]);
        assert!(columns[0].parts.iter().all(|(_, values)| values[4] == q[2][4] + q[1][4]));
        assert_eq!(load(&pair).unwrap().columns(&sample.motion(), 0, &[]).unwrap_err().lack, Lack::Pair);
        let arm = stating("own-arm", "joints = { 1 = \"sin(q3) * t\", 3 = \"-qdd1\" }").replacen(
            "\n\n",
            "\nscope = \"arm\"\n\n",
            1,
        );
        let columns = load(&arm).unwrap().columns(&sample.motion(), 0, &[]).unwrap();
        let [(0, first), (2, third)] = &columns[0].parts[..] else { panic!("{columns:?}") };
        assert_eq!((first[0], first[5]), (0.0, q[2][5].sin() * 0.05));
        assert_eq!(third[7], -sample.trajectory.qdd[0][7]);
        let fourth = load(&stating("own-fourth", "column = \"q4\"")).unwrap();
        assert_eq!(fourth.columns(&sample.motion(), 0, &[]).unwrap_err().lack, Lack::NoJoint { joint: 4, joints: 3 });
    }

    #[test]
    fn load_and_numbers_that_are_none_are_told() {
        let sample = Sample::new();
        let load_effect = load(&stating("own-load", "column = \"abs(tau_load) * sign(qd)\"")).unwrap();
        assert!(load_effect.facts.depends_on_load);
        let built_in = registry::find("load-friction").unwrap();
        let [own, other] = [load_effect, built_in].map(|effect| effect.columns(&sample.motion(), 1, &[]).unwrap());
        assert_eq!(own, other);
        let without = load_effect.columns(&Motion { load: None, ..sample.motion() }, 1, &[]);
        assert_eq!(without.unwrap_err().lack, Lack::Load);
        // The sample's velocity of joint 1 (from 0) passes 0.
        let infinite = load(&stating("own-infinite", "column = \"1 / qd\"")).unwrap();
        let error = infinite.columns(&sample.motion(), 1, &[]).unwrap_err();
        assert!(matches!(error.lack, Lack::NotFinite { .. }), "{error}");
        assert!(error.to_string().contains("division by 0"), "{error}");
    }

    #[test]
    fn what_is_wrong_with_a_file_is_told_with_line_and_column() {
        let good = stating("own-wrong", "column = \"sin(q) * qd\"");
        let replaced = |from: &str, to: &str| wrong(&good.replacen(from, to, 1));
        for (from, to, expected) in [
            ("sin(q) * qd", "sin(q) * qdot", "line 8, column 20: there is no channel `qdot`; there are q, qd, qdd, t"),
            ("sin(q) * qd", "sin(q * qd", "line 8, column 14: this bracket is never closed"),
            ("sin(q) * qd", "sinus(q)", "line 8, column 11: there is no function `sinus`"),
            ("sin(q) * qd", "q_before", "there is no channel `q_before`; there are q, "),
            ("sin(q) * qd", "q0", "there is no channel `q0`"),
            ("column = \"sin(q) * qd\"\n", "", "line 5, column 1: `k` says no `column`"),
            ("column = ", "before = ", "line 8, column 10: `before` is for pairs"),
            ("unit = \"N m\"\n", "", "line 5, column 1: missing field `unit`"),
            ("name = \"k\"", "name = \"2k\"", "line 6, column 8: `2k` is no name"),
            ("name = \"k\"", "name = \"qd\"", "`qd` is a channel"),
            ("unit", "units", "line 7, column 1: unknown field `units`"),
            ("own-wrong", "Own Wrong", "line 1, column 6: `Own Wrong` is no id"),
            ("source = \"s\"", "source = \"\"", "`source` is empty"),
            ("unit = \"N m\"", "unit = \"N m\"\nmin = 2.0\nmax = 1.0", "`k` lies between 2 and 1"),
            ("[[linear]]", "[[shape]]\nname = \"v\"\nunit = \"1\"\nstart = []\n\n[[linear]]", "`start` of `v`"),
            ("[[linear]]", "[[shape]]\nname = \"v\"\nunit = \"1\"\nstart = [2.0, 1.0]\n\n[[linear]]", "ascending"),
            ("[[linear]]", "[[shape]]\nname = \"v\"\nunit = \"1\"\nstart = [-1.0]\n\n[[linear]]", "greater than 0"),
            ("[[linear]]", "[[shape]]\nname = \"v\"\nunit = \"1\"\nstart = [1.0]\n\n[[linear]]", "no formula has `v`"),
            (
                "[[linear]]",
                "[[shape]]\nname = \"k\"\nunit = \"1\"\nstart = [1.0]\n\n[[linear]]",
                "two parameters are named",
            ),
            ("id = ", "id : ", "line 1, column 4"),
            ("source = \"s\"", "source = \"s\"\nstage = \"drive\"", "unknown variant `drive`"),
        ] {
            assert!(replaced(from, to).contains(expected), "{from} -> {to}: {}", replaced(from, to));
        }
        let none = good.split("[[linear]]").next().unwrap();
        assert!(wrong(none).contains("no `[[linear]]`"), "{}", wrong(none));
        assert!(registry::find("own-wrong").is_err(), "what is wrong is not kept");
    }
}
