//! Half a million samples on a thousand pixels: per pixel column only the first, smallest, largest and last are drawn.
//!
//! The picture is the same as with all samples (M4; Jugel and others, VLDB 7 (2014) 797). Values that are not finite and
//! jumps of the clock split the line, so that gaps are seen as gaps.

use std::collections::HashMap;
use std::sync::Arc;

/// A time step longer than this many median steps is a gap.
const GAP_STEPS: f64 = 5.0;
/// How many decimated signals are kept.
const MOST_KEPT: usize = 256;

/// Pieces of a line, ready to be scaled to the screen.
pub type Pieces = Arc<Vec<Vec<[f64; 2]>>>;

/// Decimates signals and keeps the results for the next frames.
///
/// Signals are told apart by where they lie in memory, so it has to be cleared when the data change.
#[derive(Default)]
pub struct Decimator {
    kept: HashMap<Key, Pieces>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    x: usize,
    y: usize,
    len: usize,
    range: [u64; 2],
    columns: usize,
    gaps: bool,
}

impl Decimator {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.kept.clear();
    }

    /// The line `y` over ascending `x` within `range`, for so many pixel columns; with `gaps` it is split where x jumps.
    pub fn pieces(&mut self, x: &[f64], y: &[f64], range: [f64; 2], columns: usize, gaps: bool) -> Pieces {
        let (x_at, y_at) = (x.as_ptr() as usize, y.as_ptr() as usize);
        let key = Key { x: x_at, y: y_at, len: x.len(), range: range.map(f64::to_bits), columns, gaps };
        if self.kept.len() > MOST_KEPT {
            self.kept.clear();
        }
        Arc::clone(self.kept.entry(key).or_insert_with(|| Arc::new(decimate(x, y, range, columns, gaps))))
    }
}

/// The pieces of the line within `range`, and one sample more on either side.
fn decimate(x: &[f64], y: &[f64], range: [f64; 2], columns: usize, gaps: bool) -> Vec<Vec<[f64; 2]>> {
    let len = x.len().min(y.len());
    let from = x[..len].partition_point(|x| *x < range[0]).saturating_sub(1);
    let to = (x[..len].partition_point(|x| *x <= range[1]) + 1).min(len);
    let step = if len > 1 { (x[len - 1] - x[0]) / (len - 1) as f64 } else { 0.0 };
    let per_column = columns as f64 / (range[1] - range[0]);
    let mut pieces = vec![Vec::new()];
    let mut column = Column::default();
    for sample in from..to {
        let gap = gaps && sample > from && x[sample] - x[sample - 1] > GAP_STEPS * step.max(1e-12);
        if gap || !y[sample].is_finite() {
            column.flush(&mut pieces);
            pieces.push(Vec::new());
            if !y[sample].is_finite() {
                continue;
            }
        }
        column.add(((x[sample] - range[0]) * per_column) as i64, [x[sample], y[sample]], &mut pieces);
    }
    column.flush(&mut pieces);
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

/// What is kept of the samples of one pixel column.
#[derive(Default)]
struct Column {
    number: i64,
    kept: Option<[[f64; 2]; 4]>,
}

impl Column {
    fn add(&mut self, number: i64, point: [f64; 2], pieces: &mut [Vec<[f64; 2]>]) {
        if number != self.number {
            self.flush(pieces);
        }
        self.number = number;
        match &mut self.kept {
            None => self.kept = Some([point; 4]),
            Some([_, least, most, last]) => {
                if point[1] < least[1] {
                    *least = point;
                }
                if point[1] > most[1] {
                    *most = point;
                }
                *last = point;
            }
        }
    }

    fn flush(&mut self, pieces: &mut [Vec<[f64; 2]>]) {
        let (Some([first, least, most, last]), Some(piece)) = (self.kept.take(), pieces.last_mut()) else { return };
        let (early, late) = if least[0] <= most[0] { (least, most) } else { (most, least) };
        for point in [first, early, late, last] {
            if piece.last() != Some(&point) {
                piece.push(point);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_sample_survives_and_there_are_few_points() {
        let x: Vec<f64> = (0..500_000).map(|n| n as f64 * 1e-3).collect();
        let mut y = vec![0.0; x.len()];
        y[123_456] = 7.0;
        let pieces = Decimator::default().pieces(&x, &y, [0.0, 500.0], 1000, true);
        let points: Vec<_> = pieces.iter().flatten().collect();
        assert!(points.len() <= 4 * 1001);
        assert!(points.iter().any(|point| point[1] == 7.0));
    }

    #[test]
    fn gaps_and_holes_split_the_line() {
        let x = [0.0, 1.0, 2.0, 30.0, 31.0, 32.0, 33.0];
        let y = [0.0, 0.0, 0.0, 1.0, f64::NAN, 1.0, 1.0];
        let pieces = decimate(&x, &y, [0.0, 40.0], 400, true);
        assert_eq!(pieces.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1, 2]);
    }

    #[test]
    fn empty_signals_have_no_pieces() {
        assert!(decimate(&[], &[], [0.0, 1.0], 10, true).is_empty());
    }
}
