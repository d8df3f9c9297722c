//! Which models are drawn over the current one: the same on all screens, each with an ink of its own as long as it is shown.

use crate::figure::Ink;
use crate::figure::colours::MODEL_DASHES;
use crate::session::Generation;

/// Models that are drawn over the current one, by the ink that they have. There are not more of them than dashes that can be told
/// apart on paper.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Overlaid([Option<Generation>; MODEL_DASHES.len()]);

impl Overlaid {
    /// Shows these, as far as there are inks.
    pub fn of(models: impl IntoIterator<Item = Generation>) -> Self {
        let mut overlaid = Overlaid::default();
        models.into_iter().for_each(|model| overlaid.set(model, true));
        overlaid
    }

    /// Those that are shown, in the order of their inks.
    pub fn shown(&self) -> impl Iterator<Item = Generation> {
        self.0.iter().copied().flatten()
    }

    /// The ink of a model; `None` if it is hidden.
    pub fn ink(&self, model: Generation) -> Option<Ink> {
        self.0.iter().position(|shown| *shown == Some(model)).map(Ink::Model)
    }

    /// Whether one more would look like another.
    pub fn is_full(&self) -> bool {
        self.0.iter().all(Option::is_some)
    }

    /// Shows or hides a model.
    pub fn set(&mut self, model: Generation, shown: bool) {
        match (self.0.iter().position(|other| *other == Some(model)), shown) {
            (Some(place), false) => self.0[place] = None,
            (None, true) => {
                if let Some(free) = self.0.iter_mut().find(|place| place.is_none()) {
                    *free = Some(model);
                }
            }
            _ => (),
        }
    }

    /// Keeps only these.
    pub fn keep(&mut self, is_kept: impl Fn(Generation) -> bool) {
        for place in &mut self.0 {
            *place = place.filter(|model| is_kept(*model));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ink_is_free_again_when_its_model_is_hidden() {
        let models: Vec<Generation> = (0..9).map(|_| Generation::next()).collect();
        let mut overlaid = Overlaid::of(models.iter().copied());
        assert!(overlaid.is_full() && overlaid.ink(models[8]).is_none(), "a ninth would look like the first");
        overlaid.set(models[3], false);
        overlaid.set(models[8], true);
        assert_eq!((overlaid.ink(models[8]), overlaid.ink(models[2])), (Some(Ink::Model(3)), Some(Ink::Model(2))));
        assert!(overlaid.shown().eq([0, 1, 2, 8, 4, 5, 6, 7].map(|place: usize| models[place])));
    }
}
