//! Half a million samples on a thousand pixels: per pixel column only the first, smallest, largest and last are drawn.
//!
//! The picture is the same as with all samples (M4; Jugel and others, VLDB 7 (2014) 797). Values that are not finite and
//! jumps of the clock split the line, so that gaps are seen as gaps. Of every `BLOCK` samples these four points are remembered, one
//! block after the other, so that a zoomed or moved view reads a little memory in its order and not all samples.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

use super::shared::{Identity, Shared};

/// A time step longer than this many median steps is a gap.
const GAP_STEPS: f64 = 5.0;
/// How many decimated signals are kept, before those that nobody asked for in the meantime are forgotten.
const MOST_KEPT: usize = 128;

/// Samples of a block.
const BLOCK: usize = 32;
/// Shorter signals have no blocks.
const SHORTEST_WITH_BLOCKS: usize = 64 * BLOCK;

/// Pieces of a line, ready to be scaled to the screen.
pub type Pieces = Arc<Vec<Vec<[f64; 2]>>>;

/// What is asked of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Which part of x is seen.
    pub range: [f64; 2],
    /// On how many pixel columns.
    pub columns: usize,
    /// Whether it is split where x jumps.
    pub gaps: bool,
    /// Whether it is split where it is not positive, as on a logarithmic axis.
    pub positive: bool,
}

/// Decimates signals and keeps the results for the next frames, as long as the signals live.
#[derive(Default)]
pub struct Decimator {
    kept: HashMap<Key, Kept<Pieces>>,
    /// What was kept until there was too much of it: who asks for it keeps it anew.
    older: HashMap<Key, Kept<Pieces>>,
    blocks: HashMap<[Identity; 2], Kept<Arc<Blocks>>>,
}

/// Signals, range as bits, columns, gaps, positive.
type Key = ([Identity; 2], [u64; 2], usize, [bool; 2]);

/// Something known of two signals. It holds their owners so far that nothing else can be at the same address.
struct Kept<T> {
    of: [Weak<dyn Any + Send + Sync>; 2],
    what: T,
}

impl<T> Kept<T> {
    fn is_alive(&self) -> bool {
        self.of.iter().all(|owner| owner.strong_count() > 0)
    }
}

impl Decimator {
    /// The line `y` over ascending `x` as it is seen.
    pub fn line(&mut self, x: &Shared<f64>, y: &Shared<f64>, sight: Sight) -> Pieces {
        let signals = [x.identity(), y.identity()];
        let key = (signals, sight.range.map(f64::to_bits), sight.columns, [sight.gaps, sight.positive]);
        if let Some(kept) = self.kept.get(&key) {
            return Arc::clone(&kept.what);
        }
        let kept = self.older.remove(&key).unwrap_or_else(|| self.thinned(x, y, sight));
        let pieces = Arc::clone(&kept.what);
        self.make_room();
        self.kept.insert(key, kept);
        pieces
    }

    fn thinned(&mut self, x: &Shared<f64>, y: &Shared<f64>, sight: Sight) -> Kept<Pieces> {
        let of = || [x.owner(), y.owner()];
        let blocks = (x.len().min(y.len()) >= SHORTEST_WITH_BLOCKS).then(|| {
            let compute = || Kept { of: of(), what: Arc::new(Blocks::of(x, y)) };
            Arc::clone(&self.blocks.entry([x.identity(), y.identity()]).or_insert_with(compute).what)
        });
        Kept { of: of(), what: Arc::new(decimate(x, y, sight, blocks.as_deref())) }
    }

    /// How many views of lines are remembered.
    pub fn kept(&self) -> usize {
        self.kept.len() + self.older.len()
    }

    fn make_room(&mut self) {
        if self.kept.len() >= MOST_KEPT {
            self.blocks.retain(|_, kept| kept.is_alive());
            self.older = std::mem::take(&mut self.kept);
        }
    }
}

/// What is drawn of each block of a signal, if it falls into one pixel column.
struct Blocks(Vec<Block>);

#[derive(Clone, Copy)]
struct Block {
    /// First, the smallest and largest in their order, last.
    points: [[f64; 2]; 4],
    least: f64,
    /// Whether all values are numbers.
    finite: bool,
    /// Whether the clock does not jump inside, nor before it.
    unbroken: bool,
}

impl Blocks {
    fn of(x: &[f64], y: &[f64]) -> Self {
        let len = x.len().min(y.len());
        let longest = longest_step(x, len);
        let block = |(number, (time, values)): (usize, (&[f64], &[f64]))| {
            let (mut least, mut most) = (0, 0);
            for (sample, value) in values.iter().enumerate() {
                if *value < values[least] {
                    least = sample;
                }
                if *value > values[most] {
                    most = sample;
                }
            }
            let before = (number * BLOCK).checked_sub(1).map_or(time[0], |sample| x[sample]);
            let unbroken = time[0] - before <= longest && time.windows(2).all(|pair| pair[1] - pair[0] <= longest);
            let points = [0, least.min(most), least.max(most), BLOCK - 1].map(|sample| [time[sample], values[sample]]);
            Block { points, least: values[least], finite: values.iter().all(|value| value.is_finite()), unbroken }
        };
        Blocks(x[..len].chunks_exact(BLOCK).zip(y[..len].chunks_exact(BLOCK)).enumerate().map(block).collect())
    }

    /// The block that begins at `sample`, if it may stand for its samples.
    fn at(&self, sample: usize, sight: &Sight) -> Option<&Block> {
        let block = self.0.get(sample / BLOCK).filter(|_| sample.is_multiple_of(BLOCK))?;
        let shown = !sight.positive || block.least > 0.0;
        (block.finite && shown && (block.unbroken || !sight.gaps)).then_some(block)
    }
}

/// A longer time step is a gap.
fn longest_step(x: &[f64], len: usize) -> f64 {
    let step = if len > 1 { (x[len - 1] - x[0]) / (len - 1) as f64 } else { 0.0 };
    GAP_STEPS * step.max(1e-12)
}

/// The pieces of the line in sight, and one sample more on either side, without a cache.
pub fn pieces(x: &[f64], y: &[f64], sight: Sight) -> Vec<Vec<[f64; 2]>> {
    decimate(x, y, sight, None)
}

fn decimate(x: &[f64], y: &[f64], sight: Sight, blocks: Option<&Blocks>) -> Vec<Vec<[f64; 2]>> {
    let Sight { range, columns, gaps, positive } = sight;
    let is_hole = |y: f64| !y.is_finite() || (positive && y <= 0.0);
    let len = x.len().min(y.len());
    let from = x[..len].partition_point(|x| *x < range[0]).saturating_sub(1);
    let to = (x[..len].partition_point(|x| *x <= range[1]) + 1).min(len);
    let longest = longest_step(x, len);
    let per_column = columns as f64 / (range[1] - range[0]);
    let number = |x: f64| ((x - range[0]) * per_column) as i64;
    let mut pieces = vec![Vec::new()];
    let mut column = Column::default();
    let mut sample = from;
    while sample < to {
        if let Some(Block { points, .. }) = blocks.and_then(|blocks| blocks.at(sample, &sight))
            && sample > from
            && sample + BLOCK <= to
            && number(points[0][0]) == number(points[3][0])
        {
            let at = number(points[0][0]);
            column.add_block(at, points, &mut pieces);
            sample += BLOCK;
            continue;
        }
        let gap = gaps && sample > from && x[sample] - x[sample - 1] > longest;
        if gap || is_hole(y[sample]) {
            column.flush(&mut pieces);
            pieces.push(Vec::new());
        }
        if !is_hole(y[sample]) {
            column.add(number(x[sample]), [x[sample], y[sample]], &mut pieces);
        }
        sample += 1;
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

    /// The points of a block that lies in one column.
    fn add_block(&mut self, number: i64, points: &[[f64; 2]; 4], pieces: &mut [Vec<[f64; 2]>]) {
        self.add(number, points[0], pieces);
        let Some([_, least, most, last]) = &mut self.kept else { return };
        let [low, high] = if points[1][1] <= points[2][1] { [points[1], points[2]] } else { [points[2], points[1]] };
        if low[1] < least[1] {
            *least = low;
        }
        if high[1] > most[1] {
            *most = high;
        }
        *last = points[3];
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

    fn sight(range: [f64; 2], columns: usize) -> Sight {
        Sight { range, columns, gaps: true, positive: false }
    }

    #[test]
    fn a_spike_of_one_sample_survives_and_there_are_few_points() {
        let x: Vec<f64> = (0..500_000).map(|n| n as f64 * 1e-3).collect();
        let mut y = vec![0.0; x.len()];
        y[123_456] = 7.0;
        let pieces = Decimator::default().line(&x.into(), &y.into(), sight([0.0, 500.0], 1000));
        let points: Vec<_> = pieces.iter().flatten().collect();
        assert!(points.len() <= 4 * 1001);
        assert!(points.iter().any(|point| point[1] == 7.0));
    }

    /// With or without blocks the picture is the same, whatever the view, the holes and the jumps.
    #[test]
    fn blocks_change_nothing() {
        let mut x: Vec<f64> = (0..20_000).map(|n| n as f64 * 1e-3).collect();
        x[9_000..].iter_mut().for_each(|x| *x += 3.0);
        let mut y: Vec<f64> = x.iter().map(|x| (37.0 * x).sin() + (1e4 * x).cos()).collect();
        y[12_345] = f64::NAN;
        for range in [[0.0, 23.0], [4.0, 13.5], [8.99, 12.1], [12.3, 15.4]] {
            for (columns, positive) in [(40, false), (333, true), (1000, false)] {
                let sight = Sight { positive, ..sight(range, columns) };
                let plain = decimate(&x, &y, sight, None);
                let quick = decimate(&x, &y, sight, Some(&Blocks::of(&x, &y)));
                assert_eq!(plain, quick, "{range:?} on {columns} columns");
            }
        }
    }

    #[test]
    fn gaps_and_holes_split_the_line() {
        let x = [0.0, 1.0, 2.0, 30.0, 31.0, 32.0, 33.0];
        let y = [0.0, 0.0, 0.0, 1.0, f64::NAN, 1.0, 1.0];
        let lengths = |sight| decimate(&x, &y, sight, None).iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!(lengths(sight([0.0, 40.0], 400)), [3, 1, 2]);
        let positive = Sight { positive: true, ..sight([0.0, 40.0], 400) };
        assert_eq!(lengths(positive), [1, 2], "a logarithm has no place for 0");
    }

    #[test]
    fn empty_signals_have_no_pieces() {
        assert!(decimate(&[], &[], sight([0.0, 1.0], 10), None).is_empty());
    }

    /// The same view is computed once; another view, and another signal, are computed anew, even where a signal that is gone
    /// has lain.
    #[test]
    fn a_view_is_computed_once_as_long_as_its_signal_lives() {
        let mut decimator = Decimator::default();
        let x: Shared<f64> = (0..10_000).map(f64::from).collect::<Vec<_>>().into();
        let y: Shared<f64> = vec![1.0; 10_000].into();
        let first = decimator.line(&x, &y, sight([0.0, 1e4], 100));
        let again = decimator.line(&x.clone(), &y.clone(), sight([0.0, 1e4], 100));
        assert!(Arc::ptr_eq(&first, &again));
        assert!(!Arc::ptr_eq(&first, &decimator.line(&x, &y, sight([0.0, 5e3], 100))));
        for value in 0..3 * MOST_KEPT {
            let other = vec![value as f64; 10_000].into();
            let pieces = decimator.line(&x, &other, sight([0.0, 1e4], 100));
            assert_eq!(pieces[0][0][1], value as f64);
            let asked_again = decimator.line(&x, &y, sight([0.0, 1e4], 100));
            assert!(Arc::ptr_eq(&first, &asked_again), "what is asked for is not forgotten");
        }
        assert!(decimator.kept() <= 2 * MOST_KEPT);
        assert!(decimator.blocks.len() <= MOST_KEPT + 2, "signals that are gone are forgotten");
    }
}
