//! Memory whose first element stands at the start of a cache line, so that vectors never straddle two.

use std::ops::{Deref, DerefMut};

use super::kernel::Element;

/// Bytes in a cache line, and in the widest vector.
const LINE: usize = 64;

/// A slice of its own, aligned to a cache line.
#[derive(Debug)]
pub struct Buffer<E> {
    data: Vec<E>,
    start: usize,
    length: usize,
}

impl<E> Default for Buffer<E> {
    fn default() -> Self {
        Buffer { data: Vec::new(), start: 0, length: 0 }
    }
}

impl<E: Element> Buffer<E> {
    /// Zeros.
    pub fn zeros(length: usize) -> Self {
        let spare = LINE / size_of::<E>();
        let data = vec![E::ZERO; length + spare];
        let start = data.as_ptr().align_offset(LINE).min(spare);
        Buffer { data, start, length }
    }

    /// A copy of these values.
    pub fn from_slice(values: &[E]) -> Self {
        let mut buffer = Buffer::zeros(values.len());
        buffer.copy_from_slice(values);
        buffer
    }
}

impl<E: Element> Clone for Buffer<E> {
    fn clone(&self) -> Self {
        Buffer::from_slice(self)
    }
}

impl<E> Deref for Buffer<E> {
    type Target = [E];
    fn deref(&self) -> &[E] {
        &self.data[self.start..self.start + self.length]
    }
}

impl<E> DerefMut for Buffer<E> {
    fn deref_mut(&mut self) -> &mut [E] {
        &mut self.data[self.start..self.start + self.length]
    }
}
