//! Measured and predicted signals: one value per joint and sample.
//!
//! One type for all of them, whatever they mean: positions that were measured, the torque that a model predicts, one term of
//! it. The layout is always the same, so that a joint's samples are one slice, and all joints have as many samples as each
//! other, because nothing else can be built.

use std::ops::{Index, IndexMut, Range};

use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, concatenate, s};
use rayon::prelude::*;

/// Joints × samples: `signals[joint]` is the slice of a joint's samples, `signals[joint][sample]` one value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Signals {
    /// In standard layout (row after row), always.
    values: Array2<f64>,
}

/// Parts of different sizes can't be put together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{what} has {found}, but {expected} are needed")]
pub struct ShapeError {
    /// What has the wrong shape, such as ``trajectory `run 1`: qd``.
    pub what: String,
    /// What it has, such as `2 joints`.
    pub found: String,
    /// What it must have.
    pub expected: String,
}

impl Signals {
    /// Zeros.
    pub fn zeros(joints: usize, samples: usize) -> Self {
        Signals { values: Array2::zeros((joints, samples)) }
    }

    /// The value of each joint and sample.
    pub fn from_fn(joints: usize, samples: usize, mut value: impl FnMut(usize, usize) -> f64) -> Self {
        Signals { values: Array2::from_shape_fn((joints, samples), |(joint, sample)| value(joint, sample)) }
    }

    /// The samples of each joint.
    ///
    /// # Errors
    /// [`ShapeError`] if a joint has more or fewer samples than the first.
    pub fn from_joints<J: AsRef<[f64]>>(joints: impl IntoIterator<Item = J>) -> Result<Self, ShapeError> {
        let joints = joints.into_iter();
        let (mut values, mut count, mut samples) = (Vec::new(), 0, 0);
        let expected = joints.size_hint().0;
        for joint in joints {
            let joint = joint.as_ref();
            if count == 0 {
                samples = joint.len();
                values.reserve_exact(samples * expected);
            }
            count += 1;
            if joint.len() != samples {
                let (found, expected) = (format!("{} samples", joint.len()), samples.to_string());
                return Err(ShapeError { what: format!("joint {count}"), found, expected });
            }
            values.extend_from_slice(joint);
        }
        let wrong = |error: ndarray::ShapeError| ShapeError {
            what: "a signal".to_owned(),
            found: error.to_string(),
            expected: format!("{count} joints of {samples} samples"),
        };
        Ok(Signals { values: Array2::from_shape_vec((count, samples), values).map_err(wrong)? })
    }

    /// From values sample after sample, as networks and tables have them; what is left over behind the last whole sample is not
    /// taken.
    pub fn from_samples<T: Copy + Into<f64>>(joints: usize, values: &[T]) -> Self {
        let samples = values.len().checked_div(joints).unwrap_or(0);
        Signals::from_fn(joints, samples, |joint, sample| values[sample * joints + joint].into())
    }

    /// The samples of all parts, one part after the other.
    ///
    /// # Errors
    /// [`ShapeError`] if a part has other joints than the first.
    pub fn joined(parts: &[Signals]) -> Result<Self, ShapeError> {
        let joints = parts.first().map_or(0, Signals::joint_count);
        let views: Vec<_> = parts.iter().map(Signals::view).collect();
        let wrong = |_| {
            let other = parts.iter().map(Signals::joint_count).find(|count| *count != joints).unwrap_or(joints);
            let (found, expected) = (format!("{other} joints"), joints.to_string());
            ShapeError { what: "a part".to_owned(), found, expected }
        };
        match views.is_empty() {
            true => Ok(Signals::default()),
            false => Ok(Signals::from_array(concatenate(Axis(1), &views).map_err(wrong)?.view())),
        }
    }

    /// From joints × samples in whatever layout.
    pub fn from_array(joints_by_samples: ArrayView2<'_, f64>) -> Self {
        Signals { values: joints_by_samples.as_standard_layout().into_owned() }
    }

    /// How many joints there are.
    pub fn joint_count(&self) -> usize {
        self.values.nrows()
    }

    /// How many samples each joint has.
    pub fn sample_count(&self) -> usize {
        self.values.ncols()
    }

    /// All joints × samples.
    pub fn view(&self) -> ArrayView2<'_, f64> {
        self.values.view()
    }

    /// The same, to change values: the shape stays.
    pub fn view_mut(&mut self) -> ArrayViewMut2<'_, f64> {
        self.values.view_mut()
    }

    /// The values of all joints, joint after joint.
    pub fn values(&self) -> &[f64] {
        self.values.as_slice().unwrap_or_default()
    }

    /// The same, to change them.
    pub fn values_mut(&mut self) -> &mut [f64] {
        self.values.as_slice_mut().unwrap_or_default()
    }

    /// The samples of a joint; `None` if there is no such joint.
    pub fn get(&self, joint: usize) -> Option<&[f64]> {
        (joint < self.joint_count()).then(|| &self[joint])
    }

    /// The samples of each joint, one joint after the other.
    pub fn iter(&self) -> Joints<'_> {
        Joints { left: self.joint_count(), samples: self.sample_count(), values: self.values() }
    }

    /// The same, to change them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        let (joints, samples) = (self.joint_count(), self.sample_count());
        let mut rest = self.values_mut();
        (0..joints).map(move |_| {
            let (joint, others) = std::mem::take(&mut rest).split_at_mut(samples);
            rest = others;
            joint
        })
    }

    /// The value of every joint at one sample.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn at(&self, sample: usize) -> impl Iterator<Item = f64> + Clone {
        self.values()[sample..].iter().step_by(self.sample_count()).copied()
    }

    /// The same samples of all joints.
    ///
    /// # Panics
    /// If there are no such samples.
    pub fn cut(&self, samples: Range<usize>) -> Signals {
        Signals { values: self.values.slice(s![.., samples]).to_owned() }
    }

    /// Something else of each value.
    pub fn map(&self, value: impl FnMut(f64) -> f64) -> Signals {
        Signals { values: self.values.mapv(value) }
    }

    /// Something else of each joint's samples: a filter, a derivative. Joints are worked on at once.
    ///
    /// # Panics
    /// If it gives more samples for one joint than for another, although all have as many: a programming error.
    pub fn map_joints(&self, joint: impl Fn(&[f64]) -> Vec<f64> + Sync) -> Signals {
        self.map_each(|_, samples| joint(samples))
    }

    /// As [`Signals::map_joints`], told the number of the joint (from 0).
    ///
    /// # Panics
    /// As [`Signals::map_joints`].
    pub fn map_each(&self, joint: impl Fn(usize, &[f64]) -> Vec<f64> + Sync) -> Signals {
        let each = |(number, samples): (usize, &&[f64])| joint(number, samples);
        self.map_together(|joints| joints.par_iter().enumerate().map(each).collect())
    }

    /// As [`Signals::map_joints`], of all joints in one go.
    ///
    /// # Panics
    /// As [`Signals::map_joints`].
    pub fn map_together(&self, all: impl FnOnce(&[&[f64]]) -> Vec<Vec<f64>>) -> Signals {
        let joints: Vec<&[f64]> = self.iter().collect();
        Signals::from_joints(all(&joints))
            .unwrap_or_else(|error| panic!("joints of one length became different: {error}"))
    }

    /// Adds `factor` times other signals.
    ///
    /// # Panics
    /// If they have another shape: a programming error.
    pub fn add(&mut self, other: &Signals, factor: f64) {
        self.values.scaled_add(factor, &other.values);
    }
}

impl Index<usize> for Signals {
    type Output = [f64];

    fn index(&self, joint: usize) -> &[f64] {
        let samples = self.sample_count();
        &self.values()[joint * samples..(joint + 1) * samples]
    }
}

impl IndexMut<usize> for Signals {
    fn index_mut(&mut self, joint: usize) -> &mut [f64] {
        let samples = self.sample_count();
        &mut self.values_mut()[joint * samples..(joint + 1) * samples]
    }
}

impl<'a> IntoIterator for &'a Signals {
    type Item = &'a [f64];
    type IntoIter = Joints<'a>;

    fn into_iter(self) -> Joints<'a> {
        self.iter()
    }
}

/// The samples of each joint, one joint after the other.
#[derive(Debug, Clone)]
pub struct Joints<'a> {
    left: usize,
    samples: usize,
    values: &'a [f64],
}

impl<'a> Iterator for Joints<'a> {
    type Item = &'a [f64];

    fn next(&mut self) -> Option<&'a [f64]> {
        self.left = self.left.checked_sub(1)?;
        let (joint, rest) = self.values.split_at(self.samples);
        self.values = rest;
        Some(joint)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

impl ExactSizeIterator for Joints<'_> {}

/// Signals whose values may be changed, but not their shape, because something else has the same.
#[derive(Debug)]
pub struct SignalsMut<'a>(&'a mut Signals);

impl<'a> SignalsMut<'a> {
    /// For the values of these signals.
    pub fn of(signals: &'a mut Signals) -> Self {
        SignalsMut(signals)
    }

    /// The samples of each joint, to change them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.0.iter_mut()
    }

    /// The values of all joints, joint after joint, to change them.
    pub fn values_mut(&mut self) -> &mut [f64] {
        self.0.values_mut()
    }
}

impl Index<usize> for SignalsMut<'_> {
    type Output = [f64];

    fn index(&self, joint: usize) -> &[f64] {
        &self.0[joint]
    }
}

impl IndexMut<usize> for SignalsMut<'_> {
    fn index_mut(&mut self, joint: usize) -> &mut [f64] {
        &mut self.0[joint]
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn a_joint_is_a_slice_of_its_samples() {
        let mut signals = Signals::from_fn(2, 3, |joint, sample| (10 * joint + sample) as f64);
        assert_eq!(signals[1], [10.0, 11.0, 12.0]);
        signals[1][2] = -1.0;
        signals.iter_mut().for_each(|joint| joint[0] = 7.0);
        assert_eq!(signals.view(), array![[7.0, 1.0, 2.0], [7.0, 11.0, -1.0]]);
        assert_eq!(signals.iter().map(<[f64]>::to_vec).collect::<Vec<_>>(), [[7.0, 1.0, 2.0], [7.0, 11.0, -1.0]]);
        assert_eq!(signals.at(1).collect::<Vec<_>>(), [1.0, 11.0]);
        assert_eq!(signals.cut(1..3).view(), array![[1.0, 2.0], [11.0, -1.0]]);
        assert_eq!(signals.get(2), None);
    }

    #[test]
    fn joints_of_different_lengths_are_an_error_that_names_them() {
        let error = Signals::from_joints([vec![1.0, 2.0], vec![3.0]]).unwrap_err();
        assert_eq!(error.to_string(), "joint 2 has 1 samples, but 2 are needed");
        assert_eq!(Signals::from_joints([[1.0, 2.0], [3.0, 4.0]]).unwrap().view(), array![[1.0, 2.0], [3.0, 4.0]]);
    }

    #[test]
    fn parts_follow_each_other() {
        let parts = [Signals::from_samples(2, &[1.0, 2.0]), Signals::from_samples(2, &[3.0, 4.0, 5.0, 6.0])];
        assert_eq!(Signals::joined(&parts).unwrap().view(), array![[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
        let message = Signals::joined(&[Signals::zeros(2, 1), Signals::zeros(3, 1)]).unwrap_err().to_string();
        assert_eq!(message, "a part has 3 joints, but 2 are needed");
        assert_eq!(Signals::joined(&[]), Ok(Signals::default()));
    }

    #[test]
    fn values_by_sample_become_values_by_joint() {
        let signals = Signals::from_samples(2, &[1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(signals.view(), array![[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
    }

    #[test]
    fn nothing_at_all_has_a_shape_too() {
        for signals in [Signals::default(), Signals::zeros(0, 5), Signals::from_samples::<f64>(0, &[])] {
            assert_eq!((signals.joint_count(), signals.iter().count()), (0, 0));
        }
        let empty = Signals::zeros(3, 0);
        assert_eq!(empty.iter().map(<[f64]>::len).collect::<Vec<_>>(), [0, 0, 0]);
        assert!(empty[2].is_empty());
    }
}
