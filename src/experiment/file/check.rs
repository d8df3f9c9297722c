//! What a single value does not show: whether the parts of an experiment fit each other. Each mistake is told with its line.

use std::str::FromStr;

use serde::Deserialize;
use toml::{Spanned, Table, Value};

use super::{Effects, Experiment, Model, Source, TestSet};
use crate::effect::place::Place;

/// Where in the text the parts stand.
#[derive(Deserialize)]
struct Places {
    data: Spanned<Table>,
    #[serde(rename = "model")]
    models: Vec<Spanned<ModelPlaces>>,
    #[serde(default)]
    quick: QuickPlaces,
}

#[derive(Deserialize)]
struct ModelPlaces {
    name: Spanned<String>,
    training: Option<Spanned<Table>>,
    effects: Option<Spanned<Value>>,
}

#[derive(Default, Deserialize)]
struct QuickPlaces {
    #[serde(default)]
    models: Vec<Spanned<String>>,
    #[serde(default)]
    tests: Vec<Spanned<String>>,
}

/// `line 7: `, where this offset lies.
pub(super) fn line_at(text: &str, offset: usize) -> String {
    let line = 1 + text[..offset].matches('\n').count();
    format!("line {line}: ")
}

impl Experiment {
    /// What serde does not see: whether parts fit each other.
    pub(super) fn check(&self, text: &str) -> Result<(), String> {
        let places: Places = toml::from_str(text).map_err(|error| error.to_string())?;
        let at = |offset: usize| line_at(text, offset);
        self.check_data().map_err(|(offset, problem)| at(offset.unwrap_or(places.data.span().start)) + &problem)?;
        if self.models.is_empty() {
            return Err("there is no [[model]]: add at least one".to_owned());
        }
        for (index, (model, places)) in self.models.iter().zip(&places.models).enumerate() {
            self.check_model(model, &self.models[..index], places, text)?;
        }
        self.check_tests().map_err(|(offset, problem)| at(offset) + &problem)?;
        let models: Vec<&str> = self.models.iter().map(|model| model.name.as_str()).collect();
        let tests: Vec<&str> = self.tests.iter().map(|test| test.get_ref().name.as_str()).collect();
        let kept = [("model", &places.quick.models, models), ("test set", &places.quick.tests, tests)];
        for (kind, names, known) in kept {
            if let Some(name) = names.iter().find(|name| !known.contains(&name.get_ref().as_str())) {
                let (place, name, known) = (at(name.span().start), name.get_ref(), known.join(", "));
                return Err(format!("{place}`quick` keeps the {kind} `{name}`, which is not among {known}"));
            }
        }
        Ok(())
    }

    /// A mistake comes with its offset in the text; without one it is about `data`.
    fn check_data(&self) -> Result<(), (Option<usize>, String)> {
        if self.data.simulation.is_some() != self.data.recordings.is_empty() {
            return Err((None, "`data` needs either a `simulation` or `recordings`, and not both".to_owned()));
        }
        let Some(simulation) = &self.data.simulation else { return Ok(()) };
        let wrong = |problem: String| (Some(simulation.span().start), problem);
        let source = self.training_source_of(0).map_err(wrong)?;
        check_scenarios(&source).map_err(wrong)
    }

    fn check_model(
        &self,
        model: &Model,
        before: &[Model],
        places: &Spanned<ModelPlaces>,
        text: &str,
    ) -> Result<(), String> {
        let name = &model.name;
        let at = |offset: usize| line_at(text, offset);
        let own = places.get_ref();
        let of_name = own.name.span().start;
        if before.iter().any(|other| other.name == *name) {
            return Err(format!("{}two models are named `{name}`: rename one", at(of_name)));
        }
        if model.preset.is_some() != model.terms.is_empty() {
            let place = at(places.span().start);
            return Err(format!("{place}model `{name}` needs either a `preset` or `terms`, and not both"));
        }
        if let Effects::Named(effects) = &model.effects {
            for effect in effects {
                let place = || {
                    let list = own.effects.as_ref().map_or(of_name..of_name, Spanned::span);
                    let within = text[list.clone()].find(&format!("\"{effect}\"")).unwrap_or(0);
                    at(list.start + within)
                };
                let wrong = |problem: String| format!("{}model `{name}`: {problem}", place());
                let effect = Place::from_str(effect).map_err(|problem| wrong(problem.to_string()))?.effect;
                effect.check_addable().map_err(|problem| wrong(problem.to_string()))?;
            }
        }
        let place = || at(own.training.as_ref().map_or(of_name, |training| training.span().start));
        let options = self.plan_of(model, 0).options;
        options.check().map_err(|problem| format!("{}model `{name}`: {problem}", place()))
    }

    fn check_tests(&self) -> Result<(), (usize, String)> {
        let names = self.tests.iter().map(|test| &test.get_ref().name);
        for (index, test) in self.tests.iter().enumerate() {
            let name = &test.get_ref().name;
            if names.clone().take(index).any(|other| other == name) {
                return Err((test.span().start, format!("two test sets are named `{name}`: rename one")));
            }
        }
        if let Some(curve) = self.curves.iter().find(|curve| curve.get_ref().values.is_empty()) {
            return Err((curve.span().start, format!("curve `{}` has no values", curve.get_ref().name)));
        }
        if self.tests.is_empty() && self.curves.is_empty() {
            return Err((0, "there is no [[test]] and no [[curve]]: add at least one".to_owned()));
        }
        let of_curves = self.curves.iter().flat_map(|curve| vec![curve.span().start; curve.get_ref().values.len()]);
        let places = self.tests.iter().map(|test| test.span().start).chain(of_curves);
        for (offset, set) in places.zip(self.test_sets_of(0)) {
            set.and_then(|set| check_test_set(&set)).map_err(|problem| (offset, problem))?;
        }
        Ok(())
    }
}

fn check_test_set(set: &TestSet) -> Result<(), String> {
    match &set.source {
        Source::Recorded(runs, _) if runs.is_empty() => {
            Err("a test set of an experiment with recordings needs `recordings`".to_owned())
        }
        source => check_scenarios(source),
    }
}

fn check_scenarios(source: &Source) -> Result<(), String> {
    let Source::Simulated(scenarios) = source else { return Ok(()) };
    scenarios.iter().try_for_each(|scenario| scenario.check().map_err(|problem| problem.to_string()))
}
