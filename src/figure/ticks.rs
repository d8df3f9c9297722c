//! Round numbers on axes, and numbers as text.

/// Round values inside `range`, about `count` of them.
pub fn linear(range: [f64; 2], count: usize) -> Vec<f64> {
    let span = range[1] - range[0];
    if span <= 0.0 || !span.is_finite() {
        return Vec::new();
    }
    let rough = span / count.max(1) as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough);
    let step = step.unwrap_or(rough);
    let (first, last) = ((range[0] / step).ceil() as i64, (range[1] / step).floor() as i64);
    (first..=last).map(|tick| tick as f64 * step).collect()
}

/// Powers of ten inside a range of decimal logarithms, where these are too few also their double and fivefold: where they
/// lie, and what they say.
pub fn logarithmic(range: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let span = range[1] - range[0];
    if span <= 0.0 || !span.is_finite() || range.iter().any(|end| end.abs() > 300.0) {
        return Vec::new();
    }
    let decades = range[0].floor() as i32..=range[1].ceil() as i32;
    let factors: &[u8] = if 3.0 * span <= count as f64 + 1.0 { &[1, 2, 5] } else { &[1] };
    let every = (span / count.max(1) as f64).ceil().max(1.0) as i32;
    let decades = decades.filter(|decade| decade.rem_euclid(every) == 0);
    let all = decades.flat_map(|decade| factors.iter().map(move |factor| (decade, *factor)));
    all.map(|(decade, factor)| {
        let text = match decade {
            -3..=-1 => format!("{:.*}", -decade as usize, f64::from(factor) * 10f64.powi(decade)),
            0..=3 => format!("{}", u32::from(factor) * 10u32.pow(decade as u32)),
            _ => minus(&format!("{factor}e{decade}")),
        };
        (f64::from(decade) + f64::from(factor).log10(), text)
    })
    .filter(|(at, _)| (range[0]..=range[1]).contains(at))
    .collect()
}

/// Tick values as texts with as many decimals as their distance needs.
pub fn labels(ticks: &[f64]) -> Vec<String> {
    let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(1.0);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let largest = ticks.iter().fold(0.0, |most: f64, tick| most.max(tick.abs()));
    let plain = largest < 1e5 && decimals <= 4;
    // As many digits as tell one from the next.
    let digits = (largest.log10().floor() - step.log10().floor()).clamp(1.0, 15.0) as usize;
    let text = |tick: &f64| if plain { format!("{tick:.decimals$}") } else { format!("{tick:.digits$e}") };
    ticks.iter().map(|tick| zero(&text(tick))).collect()
}

/// `-0.0` is shown as `0.0`.
fn zero(text: &str) -> String {
    let digits = text.trim_start_matches('-');
    if digits.chars().all(|digit| digit == '0' || digit == '.') { digits.to_owned() } else { minus(text) }
}

/// A number for reading: four significant digits.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "—".to_owned();
    }
    let size = value.abs();
    let text = match size {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        _ => format!("{value:.*}", (3 - size.log10().floor() as i32).clamp(0, 6) as usize),
    };
    minus(&text)
}

/// A number for reading, without zeros that say nothing: for given, not for estimated values.
pub fn short(value: f64) -> String {
    let text = number(value);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A fraction as a percentage with two significant digits.
pub fn percent(fraction: f64) -> String {
    if !fraction.is_finite() {
        return "—".to_owned();
    }
    let value = 100.0 * fraction;
    // What three decimals would show as nothing is not nothing.
    if value > 0.0 && value < 5e-4 {
        return "< 0.001 %".to_owned();
    }
    let decimals = if value == 0.0 { 0 } else { (1 - value.abs().log10().floor() as i32).clamp(0, 3) as usize };
    minus(&format!("{value:.decimals$} %"))
}

/// The typographic minus, as wide as a digit.
fn minus(text: &str) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_share_is_not_nothing() {
        assert_eq!([0.0, 1e-7, 1e-5, 0.0123].map(percent), ["0 %", "< 0.001 %", "0.001 %", "1.2 %"]);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(linear([-0.9, 2.1], 4), vec![0.0, 1.0, 2.0]);
        assert_eq!(labels(&linear([-0.3, 0.3], 4)), ["−0.2", "0.0", "0.2"]);
        assert!(linear([1.0, 1.0], 4).is_empty());
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten_or_finer() {
        let texts = |range, count| logarithmic(range, count).into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        assert_eq!(texts([-4.2, 1.3], 8), ["1e−4", "0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(texts([-1.1, 0.1], 8), ["0.1", "0.2", "0.5", "1"]);
        assert_eq!(texts([-9.0, 1.0], 5), ["1e−8", "1e−6", "1e−4", "0.01", "1"]);
        assert!(texts([0.0, 0.0], 5).is_empty());
    }

    #[test]
    fn no_two_ticks_say_the_same() {
        for range in [[0.02, 0.020_000_4], [-3e-7, 5e-7], [123_456.0, 123_460.0], [0.1, 0.1 + 1e-9]] {
            let texts = labels(&linear(range, 5));
            let other = |place: usize| texts[..place].iter().all(|other| *other != texts[place]);
            assert!(texts.len() > 2 && (0..texts.len()).all(other), "{texts:?}");
        }
        assert_eq!(labels(&linear([2e-6, 8e-6], 3)), ["2.0e−6", "4.0e−6", "6.0e−6", "8.0e−6"]);
    }

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(number(-1.23456), "−1.235");
        assert_eq!(number(0.0), "0");
        assert_eq!(number(f64::NAN), "—");
        assert_eq!(number(123456.0), "1.23e5");
        assert_eq!(percent(0.0123), "1.2 %");
    }
}
