//! What the cells say together: means over seeds with their intervals, the paper's values, and curves.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::cell::{self, Cell};
use super::file::Point;
use super::metrics::Errors;
use super::store::Store;
use super::{Experiment, ExperimentError, run};
use crate::recording::JointKind;

/// The paper's tables, as published.
const PAPER: [(u8, &str); 3] = [
    (2, include_str!("../../assets/paper/table-2.csv")),
    (3, include_str!("../../assets/paper/table-3.csv")),
    (4, include_str!("../../assets/paper/table-4.csv")),
];
/// Coverage of the intervals of means.
const COVERAGE: f64 = 0.95;

/// One model on one test set: means over the seeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub model: String,
    /// Name of the test set.
    pub test_set: String,
    /// How many seeds are done.
    pub seeds: usize,
    /// Σ‖τ − τ̂‖² / Σ‖τ‖²
    pub nmse_torque: f64,
    /// The same of the inertial torque, where it is known.
    pub nmse_inertial: Option<f64>,
    /// Of the Coriolis torque.
    pub nmse_coriolis: Option<f64>,
    /// Of the gravity torque.
    pub nmse_gravity: Option<f64>,
    /// For each joint, in that unit.
    pub mse_joint: Vec<f64>,
    /// Unit of squared errors: (N m)², N² where joints slide, or both.
    pub mse_unit: &'static str,
    /// All joints together.
    pub r2: f64,
    /// 95 % confidence interval of each mean, by the seeds; empty with one seed.
    pub interval: BTreeMap<&'static str, Value>,
    /// The paper's values, as far as printed.
    pub paper: BTreeMap<String, f64>,
    /// Of an ensemble: share of the samples within its 95 % band.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band_coverage: Option<f64>,
    /// Where it lies on a curve, if it does.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub point: Option<Point>,
    /// nMSE of the torque of each seed.
    #[serde(skip)]
    pub nmse_by_seed: Vec<f64>,
    /// Squared error of each seed, mean over the joints.
    #[serde(skip)]
    pub mse_by_seed: Vec<f64>,
}

impl Row {
    /// Squared error, mean over joints and seeds.
    pub fn mse(&self) -> f64 {
        statistic(&self.mse_by_seed).0
    }

    /// Its 95 % confidence interval by the seeds; `None` with one seed. Errors are positive and differ by factors, so it is
    /// the interval of the logarithm, whose standard error is that of the mean over the mean (delta method).
    pub fn mse_interval(&self) -> Option<[f64; 2]> {
        let (mean, interval) = statistic(&self.mse_by_seed);
        let factor = interval.map(|[_, high]| ((high - mean) / mean).exp())?;
        factor.is_finite().then_some([mean / factor, mean * factor])
    }

    /// The paper's, if it has printed all joints.
    pub fn published_mse(&self) -> Option<f64> {
        let joints = 0..self.mse_joint.len();
        let sum = joints.map(|joint| self.paper.get(&format!("mse_joint_{joint}")).copied()).sum::<Option<f64>>();
        sum.map(|sum| sum / self.mse_joint.len() as f64)
    }
}

/// The error of one model along a curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Name of the curve.
    pub curve: String,
    /// Label of the horizontal axis.
    pub axis: String,
    /// The model.
    pub model: String,
    /// Where, mean nMSE, smallest and largest of all seeds.
    pub points: Vec<[f64; 4]>,
}

/// A model's mean and interval of one quantity.
type Statistic = (f64, Option<[f64; 2]>);

/// Joins what the store holds: model after model, test set after test set. Rows without a seed are left out.
///
/// # Errors
/// [`ExperimentError`] if the store can't be read.
pub fn summarise(experiment: &Experiment, cells: &[Cell], store: &Store) -> Result<Vec<Row>, ExperimentError> {
    let mut rows = Vec::new();
    for model in &experiment.models {
        let own = cell::of_model(cells, &model.name);
        let errors = own.iter().map(|cell| run::errors(store, cell)).collect::<Result<Vec<_>, _>>()?;
        let Some(sets) = own.first().map(|cell| &cell.tests) else { continue };
        for (index, (set, _)) in sets.iter().enumerate() {
            let done: Vec<&Errors> = errors.iter().filter_map(|sets| sets[index].as_ref()).collect();
            if !done.is_empty() {
                let paper = published(experiment.paper_table, &set.name, &model.name);
                rows.push(row(&model.name, &set.name, set.point.clone(), paper, &done));
            }
        }
    }
    Ok(rows)
}

fn row(model: &str, test_set: &str, point: Option<Point>, paper: BTreeMap<String, f64>, done: &[&Errors]) -> Row {
    let of = |value: &dyn Fn(&Errors) -> Option<f64>| -> Option<Statistic> {
        let values: Option<Vec<f64>> = done.iter().map(|errors| value(errors)).collect();
        values.map(|values| statistic(&values))
    };
    let part = |index: usize| of(&|errors| errors.nmse_parts[index]);
    let named = [
        ("nmse_torque", of(&|errors| Some(errors.nmse_torque))),
        ("nmse_inertial", part(0)),
        ("nmse_coriolis", part(1)),
        ("nmse_gravity", part(2)),
        ("r2", of(&|errors| Some(errors.r2))),
    ];
    let joints = done.first().map_or(0, |errors| errors.mse_joint.len());
    let by_joint: Vec<Statistic> =
        (0..joints).filter_map(|joint| of(&|errors| errors.mse_joint.get(joint).copied())).collect();
    let mut interval: BTreeMap<&'static str, Value> = BTreeMap::new();
    for (name, statistic) in &named {
        if let Some((_, Some(ends))) = statistic {
            interval.insert(name, Value::from(ends.to_vec()));
        }
    }
    let ends: Option<Vec<Value>> =
        by_joint.iter().map(|(_, ends)| ends.map(|ends| Value::from(ends.to_vec()))).collect();
    interval.extend(ends.map(|ends| ("mse_joint", Value::from(ends))));
    let mean = |index: usize| named[index].1.map(|(mean, _)| mean);
    Row {
        model: model.to_owned(),
        test_set: test_set.to_owned(),
        seeds: done.len(),
        nmse_torque: mean(0).unwrap_or(f64::NAN),
        nmse_inertial: mean(1),
        nmse_coriolis: mean(2),
        nmse_gravity: mean(3),
        mse_joint: by_joint.iter().map(|(mean, _)| *mean).collect(),
        mse_unit: unit_of_squares(done.first().map_or(&[], |errors| &errors.kinds)),
        r2: mean(4).unwrap_or(f64::NAN),
        interval,
        paper,
        band_coverage: of(&|errors| errors.band_coverage).map(|(mean, _)| mean),
        point,
        nmse_by_seed: done.iter().map(|errors| errors.nmse_torque).collect(),
        mse_by_seed: done
            .iter()
            .map(|errors| errors.mse_joint.iter().sum::<f64>() / errors.mse_joint.len() as f64)
            .collect(),
    }
}

fn unit_of_squares(kinds: &[JointKind]) -> &'static str {
    match (kinds.contains(&JointKind::Prismatic), kinds.contains(&JointKind::Revolute)) {
        (false, _) => "(N m)²",
        (true, false) => "N²",
        (true, true) => "(N m)², N²",
    }
}

/// Mean and its interval by Student's t; no interval for one value, and none but itself for a value that never changes.
fn statistic(values: &[f64]) -> Statistic {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    if values.len() < 2 {
        return (mean, None);
    }
    if values.iter().all(|value| *value == values[0]) {
        return (values[0], Some([values[0]; 2]));
    }
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let quantile = StudentsT::new(0.0, 1.0, count - 1.0).map_or(f64::NAN, |t| t.inverse_cdf(0.5 + 0.5 * COVERAGE));
    let half = quantile * (variance / count).sqrt();
    (mean, half.is_finite().then_some([mean - half, mean + half]))
}

/// The paper's values that ours are above: model, test set and quantity of each, and how many there are to compare with. The
/// coefficient of determination is left out: as printed, it says less than the error.
pub fn above_paper(rows: &[Row]) -> (Vec<String>, usize) {
    let (mut above, mut count) = (Vec::new(), 0);
    for row in rows {
        let joint = |(joint, mse): (usize, &f64)| (format!("mse_joint_{joint}"), Some(*mse));
        let parts = [
            ("nmse_torque", Some(row.nmse_torque)),
            ("nmse_inertial", row.nmse_inertial),
            ("nmse_coriolis", row.nmse_coriolis),
            ("nmse_gravity", row.nmse_gravity),
        ];
        let named = parts.map(|(name, value)| (name.to_owned(), value));
        for (name, value) in named.into_iter().chain(row.mse_joint.iter().enumerate().map(joint)) {
            let (Some(value), Some(paper)) = (value, row.paper.get(&name)) else { continue };
            count += 1;
            if value > *paper {
                above.push(format!("{} on {}: {name} × {:.2}", row.model, row.test_set, value / paper));
            }
        }
    }
    (above, count)
}

/// The paper's values. A set such as `iid, 3 runs` is one more draw of `iid`.
fn published(table: Option<u8>, test_set: &str, model: &str) -> BTreeMap<String, f64> {
    let text = PAPER.iter().find(|(number, _)| Some(*number) == table).map_or("", |(_, text)| text);
    let test_set = test_set.split(',').next().unwrap_or_default();
    let value = |line: &str| {
        let mut fields = line.split(',');
        let is_own = fields.next() == Some(test_set) && fields.next() == Some(model);
        if is_own { Some((fields.next()?.to_owned(), fields.next()?.parse().ok()?)) } else { None }
    };
    text.lines().filter_map(value).collect()
}

/// The curves among the rows.
pub fn curves(rows: &[Row]) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows {
        let Some(Point { curve, axis, x }) = &row.point else { continue };
        let least = row.nmse_by_seed.iter().copied().fold(f64::INFINITY, f64::min);
        let most = row.nmse_by_seed.iter().copied().fold(0.0, f64::max);
        let point = [*x, row.nmse_torque, least, most];
        match curves.iter_mut().find(|own| own.curve == *curve && own.model == row.model) {
            Some(own) => own.points.push(point),
            None => curves.push(Curve {
                curve: curve.clone(),
                axis: axis.clone(),
                model: row.model.clone(),
                points: vec![point],
            }),
        }
    }
    curves
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_above_the_paper_is_named() {
        let errors = Errors {
            nmse_torque: 9e-6,
            nmse_parts: [Some(1e-5), Some(1e-3), None],
            mse_joint: vec![1e-3, 1e-3, 1e-3],
            kinds: vec![JointKind::Revolute; 3],
            r2: 0.9,
            band_coverage: None,
        };
        let paper = published(Some(2), "iid", "structured-delan");
        let row = row("structured-delan", "iid", None, paper, &[&errors]);
        assert!((row.mse() - 1e-3).abs() < 1e-15 && row.mse_interval().is_none());
        assert!((row.published_mse().unwrap() - (0.0022 + 0.0013 + 0.00083) / 3.0).abs() < 1e-12);
        let (above, count) = above_paper(&[row]);
        assert_eq!(count, 6);
        assert_eq!(above.len(), 3, "{above:?}");
        assert!(above[0].starts_with("structured-delan on iid: nmse_torque × 1.11"), "{above:?}");
    }

    #[test]
    fn intervals_are_those_of_student() {
        let (mean, interval) = statistic(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        let half = 2.7764 * (2.5f64 / 5.0).sqrt();
        assert_eq!(mean, 3.0);
        let [low, high] = interval.unwrap();
        assert!((low - (3.0 - half)).abs() < 1e-3 && (high - (3.0 + half)).abs() < 1e-3, "{low} {high}");
        assert_eq!(statistic(&[7.0]), (7.0, None));
        assert_eq!(statistic(&[0.1; 5]), (0.1, Some([0.1, 0.1])));
    }

    /// Seeds that differ by factors: the plain interval would reach below 0, where no error is.
    #[test]
    fn the_interval_of_an_error_is_on_its_logarithm() {
        let errors = |mse: f64| Errors {
            nmse_torque: mse,
            nmse_parts: [None; 3],
            mse_joint: vec![mse],
            kinds: vec![JointKind::Revolute],
            r2: 0.9,
            band_coverage: None,
        };
        let seeds = [1e-3, 1e-2, 0.1].map(errors);
        let row = row("ff-nn", "iid", None, BTreeMap::new(), &seeds.each_ref());
        assert!(statistic(&row.mse_by_seed).1.unwrap()[0] < 0.0);
        let [low, high] = row.mse_interval().unwrap();
        assert!(0.0 < low && low < row.mse() && row.mse() < high);
        assert!((high / row.mse() - row.mse() / low).abs() < 1e-9 * high / row.mse(), "the same factor up and down");
    }

    #[test]
    fn the_papers_values_are_found_by_table_test_set_and_model() {
        assert_eq!(published(Some(2), "iid", "structured-delan")["nmse_torque"], 8.1e-6);
        assert_eq!(published(Some(3), "non-iid-2", "delan-ffnn")["mse_joint_2"], 0.12);
        assert_eq!(published(Some(4), "non-iid", "structured-delan")["mse_joint_0"], 272.8);
        assert_eq!(
            published(Some(2), "iid, 3 runs", "structured-delan"),
            published(Some(2), "iid", "structured-delan")
        );
        assert!(published(None, "iid", "ff-nn").is_empty() && published(Some(2), "iid", "ours").is_empty());
    }
}
