//! The clocks of a log of messages: a message tells when it was measured, the log when it received it. How far they are apart is told;
//! channels of two topics are brought to one clock by what both have in common, the clock of the log.

use super::budget::{Budget, TooMuch};
use super::table::Column;
use crate::recording::check::GAP_STEPS;
use crate::statistics::median;

/// When the messages of a topic were measured and received \[ns\].
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Clock {
    /// None where messages bear no stamps.
    pub stamps: Vec<i64>,
    pub received: Vec<i64>,
}

/// Something about clocks that whoever reads the log should know.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Told {
    pub what: String,
    /// Whether samples were moved in time.
    pub is_moved: bool,
}

/// Clocks that differ by less agree \[ms\].
const AGREE: f64 = 1e-3;

impl Clock {
    /// Whether its stamps are a clock: they are there, and increase.
    fn is_stamped(&self) -> bool {
        !self.stamps.is_empty() && self.stamps.windows(2).all(|pair| pair[1] > pair[0])
    }

    /// When the messages were measured; received, where nobody stamped them.
    fn measured(&self) -> &[i64] {
        if self.is_stamped() { &self.stamps } else { &self.received }
    }

    /// The same from the first one on \[s\].
    pub fn seconds(&self) -> Vec<f64> {
        let start = self.measured().first().copied().unwrap_or_default();
        self.measured().iter().map(|time| time.wrapping_sub(start) as f64 * 1e-9).collect()
    }

    /// By how much the clock of the log is ahead of the stamps \[ms\]: least, median, most.
    fn lag(&self) -> Option<[f64; 3]> {
        let apart = |(received, stamp): (&i64, &i64)| received.wrapping_sub(*stamp) as f64 * 1e-6;
        let lags: Vec<f64> = self.received.iter().zip(self.measured()).map(apart).collect();
        let middle = median(lags.clone())?;
        let least = lags.iter().copied().fold(f64::INFINITY, f64::min);
        Some([least, middle, lags.iter().copied().fold(f64::NEG_INFINITY, f64::max)])
    }

    /// What is to be said of a topic's clock; nothing where its stamps are those of the log.
    pub fn told(&self, topic: &str) -> Option<Told> {
        let what = match self.lag()? {
            _ if !self.is_stamped() => format!(
                "the messages of `{topic}` {}, so time is when the log received them",
                if self.stamps.is_empty() { "bear no stamps" } else { "bear stamps that do not increase" }
            ),
            [least, _, most] if least.abs().max(most.abs()) < AGREE => return None,
            [least, middle, most] => format!(
                "time is that of the stamps of `{topic}`; the clock of the log is {middle:.3} ms ahead of them ({least:.3} to {most:.3} ms), \
                 which changes nothing"
            ),
        };
        Some(Told { what, is_moved: false })
    }

    /// How much another clock is to be turned on to agree with this one \[ns\], and what is said of it. What the log received late may only
    /// have been long on its way: a difference within that is none of the clocks.
    fn align(&self, other: &Clock, names: [&str; 2]) -> (i64, Told) {
        let lags = self.lag().zip(other.lag());
        let Some(([least, middle, most], [other_least, other_middle, other_most])) = lags else {
            return (0, Told { what: String::new(), is_moved: false });
        };
        let apart = other_middle - middle;
        let unsure = (most - least).max(other_most - other_least).max(median_step(self.measured()) * 1e-6);
        let [first, second] = names;
        if self.is_stamped() == other.is_stamped() && apart.abs() <= unsure {
            let what = format!(
                "the channels of `{second}` are put at the times of `{first}`; by when the log received them \
                 their clocks are {apart:.3} ms apart, no more than messages are on their way ({unsure:.3} ms): nothing was moved"
            );
            return (0, Told { what, is_moved: false });
        }
        let what = format!(
            "the channels of `{second}` are put at the times of `{first}`; by when the log received them their \
             clocks are {apart:.3} ms apart, so those of `{second}` were moved by as much"
        );
        ((apart * 1e6).round() as i64, Told { what, is_moved: true })
    }
}

fn median_step(times: &[i64]) -> f64 {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1].wrapping_sub(pair[0]) as f64).collect();
    median(steps).unwrap_or(0.0)
}

/// Columns of another topic at the times of the first, straight between two messages; NaN where the other has none, or a gap.
pub(super) fn beside(
    clock: &Clock,
    other: &Clock,
    names: [&str; 2],
    columns: Vec<Column>,
    budget: &mut Budget,
) -> Result<(Vec<Column>, Told), TooMuch> {
    let (shift, told) = clock.align(other, names);
    let (times, others) = (clock.measured(), other.measured());
    budget.unpack((times.len() as u64).saturating_mul(columns.len() as u64 * size_of::<f64>() as u64))?;
    let longest = GAP_STEPS * median_step(others);
    // The message before each time, and how far the way to the next one is.
    let place = |time: &i64| {
        let time = time.wrapping_sub(shift);
        let after = others.partition_point(|other| *other <= time);
        let before = after.checked_sub(1)?;
        let gone = time.wrapping_sub(others[before]) as f64;
        match others.get(after) {
            _ if gone == 0.0 => Some((before, before, 0.0)),
            Some(next) => {
                let way = next.wrapping_sub(others[before]) as f64;
                (way > 0.0 && way <= longest).then(|| (before, after, gone / way))
            }
            None => None,
        }
    };
    let places: Vec<_> = times.iter().map(place).collect();
    let at = |column: Column| {
        let value = |place: &Option<(usize, usize, f64)>| {
            place.map_or(f64::NAN, |(before, after, share)| {
                column.values[before] + share * (column.values[after] - column.values[before])
            })
        };
        Column { values: places.iter().map(value).collect(), ..column }
    };
    Ok((columns.into_iter().map(at).collect(), told))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 100 Hz, received `lag` ns after it was measured, with a clock that is `ahead`.
    fn clock(ahead: i64, lag: i64) -> Clock {
        let times = (0..200).map(|sample| 1_000_000_000 + 10_000_000 * sample);
        let stamps = times.clone().map(|time| time + ahead).collect();
        Clock { stamps, received: times.map(|time| time + lag + time / 10_000_000 % 3 * 100_000).collect() }
    }

    fn beside_of(first: &Clock, other: &Clock) -> (Vec<f64>, Told) {
        let values = other.received.iter().map(|time| *time as f64 * 1e-9).collect();
        let column = Column { name: "effort[0]".to_owned(), values, text: None };
        let budget = &mut Budget::of(1000, 1 << 20);
        let (columns, told) = beside(first, other, ["/a", "/b"], vec![column], budget).unwrap();
        (columns[0].values.clone(), told)
    }

    #[test]
    fn clocks_that_are_apart_are_found_and_brought_together() {
        let (values, told) = beside_of(&clock(0, 2_000_000), &clock(-500_000_000, 2_000_000));
        assert!(told.is_moved && told.what.contains("500.000 ms apart"), "{}", told.what);
        assert!((values[100] - 2.002).abs() < 1e-3, "what was measured then: {}", values[100]);
        assert!(values.iter().all(|value| value.is_finite()));
        let (_, told) = beside_of(&clock(0, 2_000_000), &clock(0, 3_000_000));
        assert!(!told.is_moved && told.what.contains("1.000 ms apart, no more than"), "{}", told.what);
    }

    #[test]
    fn what_the_other_topic_has_not_is_not_made_up() {
        let mut other = clock(0, 0);
        for times in [&mut other.stamps, &mut other.received] {
            times.truncate(150);
            times.drain(50..100);
        }
        let (values, _) = beside_of(&clock(0, 0), &other);
        assert!(values[..50].iter().chain(&values[100..150]).all(|value| value.is_finite()));
        assert!(values[50..100].iter().chain(&values[150..]).all(|value| value.is_nan()));
    }

    #[test]
    fn the_lag_of_a_log_is_told_and_stamps_that_are_none() {
        let told = clock(0, 5_000_000).told("/a").unwrap();
        assert!(told.what.contains("5.100 ms ahead of them (5.000 to 5.200 ms)"), "{}", told.what);
        let exact = Clock { stamps: vec![1, 2, 3], received: vec![1, 2, 3] };
        assert_eq!(exact.told("/a"), None);
        let zeros = Clock { stamps: vec![0; 3], received: vec![1, 2, 3] };
        assert!(zeros.told("/a").unwrap().what.contains("do not increase, so time is when the log received them"));
        assert_eq!(zeros.seconds(), [0.0, 1e-9, 2e-9]);
    }
}
