//! Numbers that a figure shows without copying them.

use std::any::Any;
use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Weak};

/// A run of values inside something that others hold, too: half a million samples cost a mark no more than ten.
///
/// ```
/// use std::sync::Arc;
/// use torquescope::figure::Shared;
/// struct Log { time: Vec<f64> }
/// let log = Arc::new(Log { time: vec![0.0, 0.1] });
/// let time = Shared::of(&log, |log| &log.time);
/// assert_eq!(time[1], 0.1);
/// ```
pub struct Shared<T>(Arc<dyn Source<T>>);

/// Something that holds values.
trait Source<T>: Send + Sync {
    fn values(&self) -> &[T];
    fn owner(&self) -> Weak<dyn Any + Send + Sync>;
}

/// A part of an owner.
struct PartOf<O, F> {
    owner: Arc<O>,
    part: F,
}

impl<T, O: Send + Sync + 'static, F: Fn(&O) -> &[T] + Send + Sync> Source<T> for PartOf<O, F> {
    fn values(&self) -> &[T] {
        (self.part)(&self.owner)
    }

    fn owner(&self) -> Weak<dyn Any + Send + Sync> {
        let owner: Weak<O> = Arc::downgrade(&self.owner);
        owner
    }
}

impl<T: 'static> Shared<T> {
    /// A part of what `owner` holds.
    pub fn of<O: Send + Sync + 'static>(owner: &Arc<O>, part: impl Fn(&O) -> &[T] + Send + Sync + 'static) -> Self {
        Shared(Arc::new(PartOf { owner: Arc::clone(owner), part }))
    }
}

impl<T> Shared<T> {
    /// Which values these are, as long as their owner lives.
    pub(super) fn identity(&self) -> Identity {
        let owner = self.0.owner();
        let values = self.0.values();
        Identity { owner: owner.as_ptr().cast::<()>() as usize, first: values.as_ptr() as usize, len: values.len() }
    }

    /// Whoever keeps this keeps the owner's address from being given to another, but not its values.
    pub(super) fn owner(&self) -> Weak<dyn Any + Send + Sync> {
        self.0.owner()
    }
}

/// Where values lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Identity {
    owner: usize,
    first: usize,
    len: usize,
}

impl<T> Deref for Shared<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.0.values()
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Shared(Arc::clone(&self.0))
    }
}

impl<T: Send + Sync + 'static> From<Vec<T>> for Shared<T> {
    fn from(values: Vec<T>) -> Self {
        Shared::of(&Arc::new(values), |values| values)
    }
}

impl<T: Send + Sync + 'static> From<&Arc<Vec<T>>> for Shared<T> {
    fn from(values: &Arc<Vec<T>>) -> Self {
        Shared::of(values, |values| values)
    }
}

impl<T> fmt::Debug for Shared<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{} values", self.len())
    }
}
