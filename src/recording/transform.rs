//! What else than columns a mapping may state: factors, matrices and offsets, from the numbers of a file to SI units.
//!
//! Drives record what they have: motor angles, currents, volts. `x = F · numbers + offset`, where F is a number, one number
//! a joint, a matrix (with the couplings of belts and differentials), or a constant that stands in the file itself.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use ndarray::ArrayD;
use serde::{Deserialize, Serialize};

use crate::signals::Signals;

/// From the numbers of a file, one column a joint, to a channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Transform {
    /// What the numbers are multiplied by; 1 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<Factor>,
    /// Whether they are divided by it instead, or multiplied by the inverse of the matrix.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub inverse: bool,
    /// What is added afterwards, one number a joint in SI units; 0 if empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub offset: Vec<f64>,
}

/// A linear map over the joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a factor is a number, a list with one a joint, a matrix (a list of rows) or the name of a constant in the file"
)]
pub enum Factor {
    /// The same for all joints.
    Number(f64),
    /// One a joint.
    PerJoint(Vec<f64>),
    /// Row after row.
    Matrix(Vec<Vec<f64>>),
    /// Name of a number or list in the file.
    Constant(String),
}

/// The transform does not fit the file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TransformError {
    /// A named constant is missing.
    #[error("the factor `{name}` is no constant of the file; it has: {known}")]
    NoConstant {
        /// Its name.
        name: String,
        /// All there are.
        known: String,
    },
    /// Another number of joints.
    #[error("the {what} has {found} numbers for {joints} joints")]
    Size {
        /// Factor or offset.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many there are.
        joints: usize,
    },
    /// It can't be inverted.
    #[error("the factor has no inverse")]
    Singular,
}

impl Transform {
    /// The channel in SI units.
    ///
    /// # Errors
    /// [`TransformError`] if it does not fit the joints or the constants of the file.
    pub fn apply(
        &self,
        numbers: Signals,
        constants: &BTreeMap<String, ArrayD<f64>>,
    ) -> Result<Signals, TransformError> {
        let joints = numbers.joint_count();
        let mut channel = match &self.factor {
            None => numbers,
            Some(factor) => {
                let matrix = factor.matrix(joints, constants)?;
                let matrix = if self.inverse { matrix.try_inverse().ok_or(TransformError::Singular)? } else { matrix };
                numbers.map_each(|joint, _| combined(&numbers, matrix.row(joint).iter().copied()))
            }
        };
        if !self.offset.is_empty() {
            if self.offset.len() != joints {
                return Err(TransformError::Size { what: "offset", found: self.offset.len(), joints });
            }
            for (signal, offset) in channel.iter_mut().zip(&self.offset) {
                signal.iter_mut().for_each(|value| *value += offset);
            }
        }
        Ok(channel)
    }

    /// In words, for a finding.
    pub fn describe(&self) -> String {
        let (verb, by) = if self.inverse { ("divided", "the inverse of a matrix") } else { ("multiplied", "a matrix") };
        let factor = self.factor.as_ref().map(|factor| match factor {
            Factor::Number(number) => format!("{verb} by {number}"),
            Factor::PerJoint(numbers) => format!("{verb} by {numbers:?} joint by joint"),
            Factor::Matrix(_) => format!("multiplied by {by}"),
            Factor::Constant(name) => format!("{verb} by `{name}` of the file"),
        });
        let offset = (!self.offset.is_empty()).then(|| format!("shifted by {:?}", self.offset));
        factor.into_iter().chain(offset).collect::<Vec<_>>().join(" and ")
    }
}

/// Σ row · numbers; a joint with the weight 0 adds nothing, not even its missing values.
fn combined(numbers: &Signals, row: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = vec![0.0; numbers.sample_count()];
    for (signal, weight) in numbers.iter().zip(row).filter(|(_, weight)| *weight != 0.0) {
        for (sum, value) in sum.iter_mut().zip(signal) {
            *sum += weight * value;
        }
    }
    sum
}

impl Factor {
    fn matrix(&self, joints: usize, constants: &BTreeMap<String, ArrayD<f64>>) -> Result<DMatrix<f64>, TransformError> {
        let size = |found| TransformError::Size { what: "factor", found, joints };
        let diagonal = |numbers: &[f64]| match numbers {
            [number] => Ok(DMatrix::identity(joints, joints) * *number),
            _ if numbers.len() == joints => Ok(DMatrix::from_diagonal(&DVector::from_column_slice(numbers))),
            _ => Err(size(numbers.len())),
        };
        match self {
            Factor::Number(number) => diagonal(&[*number]),
            Factor::PerJoint(numbers) if numbers.len() != joints => Err(size(numbers.len())),
            Factor::PerJoint(numbers) => diagonal(numbers),
            Factor::Matrix(rows) => match rows.iter().find(|row| row.len() != joints) {
                Some(row) => Err(size(row.len())),
                None if rows.len() != joints => Err(size(rows.len())),
                None => Ok(DMatrix::from_fn(joints, joints, |row, column| rows[row][column])),
            },
            Factor::Constant(name) => {
                let known = || constants.keys().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                let constant = constants.get(name);
                let constant =
                    constant.ok_or_else(|| TransformError::NoConstant { name: name.clone(), known: known() })?;
                match *constant.shape() {
                    [rows, columns] if rows == joints && columns == joints => {
                        Ok(DMatrix::from_fn(joints, joints, |row, column| constant[[row, column]]))
                    }
                    _ => diagonal(&constant.iter().copied().collect::<Vec<f64>>()),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    fn transform(toml: &str) -> Transform {
        toml::from_str(toml).unwrap()
    }

    fn apply(toml: &str) -> Result<Signals, TransformError> {
        let ratios = array![10.0, 100.0].into_dyn();
        let numbers = Signals::from_joints([[1.0, 2.0], [3.0, 4.0]]).unwrap();
        transform(toml).apply(numbers, &[("u".to_owned(), ratios)].into())
    }

    #[test]
    fn factors_are_numbers_lists_matrices_or_constants_of_the_file() {
        assert_eq!(apply("factor = 2").unwrap().view(), array![[2.0, 4.0], [6.0, 8.0]]);
        assert_eq!(apply("factor = [2, -1]\noffset = [0.5, 0]").unwrap().view(), array![[2.5, 4.5], [-3.0, -4.0]]);
        assert_eq!(apply("factor = [[1, 0], [1, 1]]").unwrap().view(), array![[1.0, 2.0], [4.0, 6.0]]);
        assert_eq!(apply("factor = [[1, 0], [1, 1]]\ninverse = true").unwrap().view(), array![[1.0, 2.0], [2.0, 2.0]]);
        assert_eq!(apply("factor = 'u'").unwrap().view(), array![[10.0, 20.0], [300.0, 400.0]]);
        assert_eq!(apply("").unwrap().view(), array![[1.0, 2.0], [3.0, 4.0]]);
    }

    #[test]
    fn what_does_not_fit_is_told() {
        for (toml, word) in [
            ("factor = [1, 2, 3]", "3 numbers for 2 joints"),
            ("factor = [[1, 0], [1]]", "1 numbers"),
            ("offset = [1]", "offset"),
            ("factor = 'x'", "`u`"),
            ("factor = [0, 1]\ninverse = true", "no inverse"),
        ] {
            let message = apply(toml).unwrap_err().to_string();
            assert!(message.contains(word), "{toml}: {message}");
        }
        assert!(toml::from_str::<Transform>("factor = true").unwrap_err().to_string().contains("one a joint"));
    }

    #[test]
    fn it_says_what_it_does() {
        let said = |toml: &str| transform(toml).describe();
        assert_eq!(said("factor = 2"), "multiplied by 2");
        assert_eq!(said("factor = [2, -1]\ninverse = true"), "divided by [2.0, -1.0] joint by joint");
        assert_eq!(said("factor = [[1, 0], [1, 1]]"), "multiplied by a matrix");
        assert_eq!(said("factor = [[1, 0], [1, 1]]\ninverse = true"), "multiplied by the inverse of a matrix");
        assert_eq!(said("factor = 'u'\noffset = [0.5]"), "multiplied by `u` of the file and shifted by [0.5]");
    }
}
