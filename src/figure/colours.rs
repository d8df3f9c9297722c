//! Colours and dashes by quantity, the same on the screen and on paper.
//!
//! They have the hues of Okabe and Ito, which people with a colour vision deficiency can tell apart, as dark or as light as
//! they must be to stand out from their ground; the dash tells the same without colour.

use std::str::FromStr;

/// Red, green, blue.
pub type Rgb = [u8; 3];
/// How a line is broken: lengths of ink and gap \[points\]. Empty for an unbroken line.
pub type Dash = &'static [f32];

/// Dashes of series. Neither these nor those of models look like each other, or like that of predicted signals.
pub const DASHES: [Dash; 7] =
    [&[], &[14.0, 3.0], &[2.0, 2.5], &[9.0, 3.0, 2.0, 3.0], &[4.0, 2.0], &[2.0, 6.0], &[9.0, 2.0, 2.0, 2.0, 2.0, 2.0]];
/// Dashes of models that are drawn over the current one.
pub const MODEL_DASHES: [Dash; 8] = [
    &[14.0, 3.0, 4.0, 3.0],
    &[2.0, 2.0, 2.0, 7.0],
    &[6.0, 2.0, 6.0, 8.0],
    &[14.0, 2.5, 2.0, 2.5, 2.0, 2.5, 2.0, 2.5],
    &[4.0, 2.0, 4.0, 2.0, 4.0, 9.0],
    &[20.0, 6.0],
    &[2.0, 2.0, 2.0, 2.0, 2.0, 9.0],
    &[9.0, 2.5, 9.0, 2.5, 2.0, 2.5],
];
/// Colours of models, by their place in the series: not the one that is like that of predicted signals.
const OF_MODELS: [usize; 6] = [4, 1, 6, 0, 2, 3];
/// Dash of measured signals.
pub const MEASURED_DASH: Dash = &[];
/// Dash of predicted signals.
pub const PREDICTED_DASH: Dash = &[7.0, 4.0];

/// What a mark shows, which sets its colour and dash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Measured signals.
    Measured,
    /// Predicted signals.
    Predicted,
    /// Measured minus predicted.
    Residual,
    /// The n-th joint, effect or term.
    Series(usize),
    /// The n-th model that is drawn over the current one.
    Model(usize),
    /// As text: references, diagonals, floors.
    Text,
    /// As text of less weight: what is planned, or perfect.
    Weak,
    /// What is marked by hand.
    Marked,
    /// Where the cursor is.
    Cursor,
}

impl Ink {
    /// How its lines are broken.
    pub fn dash(self) -> Dash {
        match self {
            Ink::Measured | Ink::Residual | Ink::Marked | Ink::Cursor => MEASURED_DASH,
            Ink::Predicted => PREDICTED_DASH,
            // There are as many colours as dashes: another round pairs them otherwise, so that 49 look different.
            Ink::Series(n) => DASHES[(n + n / DASHES.len()) % DASHES.len()],
            Ink::Model(n) => MODEL_DASHES[n % MODEL_DASHES.len()],
            Ink::Text | Ink::Weak => &[2.0, 2.0],
        }
    }
}

/// The colours of a plot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colours {
    /// Behind the figure.
    pub ground: Rgb,
    /// Behind plots.
    pub canvas: Rgb,
    /// Frames of plots.
    pub border: Rgb,
    /// Lines of the grid.
    pub grid: Rgb,
    /// Titles.
    pub text: Rgb,
    /// Numbers and legends.
    pub weak: Rgb,
    /// Measured signals.
    pub measured: Rgb,
    /// Predicted signals.
    pub predicted: Rgb,
    /// Measured minus predicted.
    pub residual: Rgb,
    /// Behind stretches that are held out.
    pub held_out: Rgb,
    /// What is marked by hand.
    pub marked: Rgb,
    /// Where the cursor is.
    pub cursor: Rgb,
    /// Joints, effects, terms, models.
    pub series: [Rgb; 7],
}

/// On light ground.
pub const LIGHT: Colours = Colours {
    ground: [0xff, 0xff, 0xff],
    canvas: [0xfc, 0xfc, 0xfd],
    border: [0xda, 0xde, 0xe5],
    grid: [0xeb, 0xed, 0xf1],
    text: [0x1a, 0x1e, 0x26],
    weak: [0x5a, 0x63, 0x72],
    measured: [0x3a, 0x42, 0x50],
    predicted: [0xb2, 0x4d, 0x00],
    residual: [0xa8, 0x3f, 0x7d],
    held_out: [0xe2, 0xf0, 0xf6],
    marked: [0x1a, 0x66, 0xc8],
    cursor: [0x7a, 0x5c, 0x00],
    series: [
        [0x04, 0x70, 0xaf],
        [0x00, 0x7a, 0x59],
        [0x9a, 0x5d, 0x02],
        [0xab, 0x47, 0x81],
        [0x4a, 0x55, 0xc8],
        [0xb2, 0x4d, 0x00],
        [0x75, 0x6c, 0x00],
    ],
};

/// On dark ground.
pub const DARK: Colours = Colours {
    ground: [0x17, 0x1a, 0x20],
    canvas: [0x12, 0x15, 0x1a],
    border: [0x2a, 0x2f, 0x39],
    grid: [0x22, 0x26, 0x2f],
    text: [0xe4, 0xe7, 0xec],
    weak: [0x9b, 0xa4, 0xb2],
    measured: [0xa4, 0xad, 0xbb],
    predicted: [0xf5, 0xa6, 0x23],
    residual: [0xdd, 0x8f, 0xbb],
    held_out: [0x1a, 0x2a, 0x34],
    marked: [0x6c, 0xb0, 0xff],
    cursor: [0xf0, 0xe4, 0x42],
    series: [
        [0x56, 0xb4, 0xe9],
        [0x2f, 0xc0, 0x92],
        [0xe6, 0x9f, 0x00],
        [0xcc, 0x79, 0xa7],
        [0x6f, 0x8f, 0xff],
        [0xf0, 0x74, 0x3a],
        [0xe8, 0xdf, 0x5e],
    ],
};

/// On paper: white ground, black letters.
const PRINT: Colours = Colours {
    canvas: [0xff, 0xff, 0xff],
    border: [0x60, 0x60, 0x60],
    grid: [0xe4, 0xe4, 0xe4],
    text: [0x00, 0x00, 0x00],
    weak: [0x20, 0x20, 0x20],
    measured: [0x00, 0x00, 0x00],
    held_out: [0xe8, 0xf2, 0xf8],
    ..LIGHT
};

/// On paper without colours: lines are told apart by their dashes, and a little by how dark they are.
const GREY: Colours = Colours {
    predicted: [0x50, 0x50, 0x50],
    residual: [0x38, 0x38, 0x38],
    held_out: [0xee, 0xee, 0xee],
    marked: [0x20, 0x20, 0x20],
    cursor: [0x20, 0x20, 0x20],
    // Those that share a dash are next to each other here, and far from each other to see.
    series: [
        [0x10, 0x10, 0x10],
        [0x4c, 0x4c, 0x4c],
        [0x88, 0x88, 0x88],
        [0x38, 0x38, 0x38],
        [0x74, 0x74, 0x74],
        [0x24, 0x24, 0x24],
        [0x60, 0x60, 0x60],
    ],
    ..PRINT
};

/// A set of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    /// For paper.
    #[default]
    Print,
    /// As the light window.
    Light,
    /// As the dark window.
    Dark,
    /// For paper without colours.
    Grey,
}

impl FromStr for Theme {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "print" => Ok(Theme::Print),
            "light" => Ok(Theme::Light),
            "dark" => Ok(Theme::Dark),
            "grey" => Ok(Theme::Grey),
            other => Err(format!("there is no theme `{other}`: choose print, light, dark or grey")),
        }
    }
}

impl Theme {
    /// Its colours.
    pub fn colours(self) -> &'static Colours {
        match self {
            Theme::Print => &PRINT,
            Theme::Light => &LIGHT,
            Theme::Dark => &DARK,
            Theme::Grey => &GREY,
        }
    }
}

impl Colours {
    /// The colour of an ink.
    pub fn of(&self, ink: Ink) -> Rgb {
        match ink {
            Ink::Model(n) => self.of(Ink::Series(OF_MODELS[n % OF_MODELS.len()])),
            Ink::Measured => self.measured,
            Ink::Predicted => self.predicted,
            Ink::Residual => self.residual,
            Ink::Series(n) => self.series[n % self.series.len()],
            Ink::Text => self.text,
            Ink::Weak => self.weak,
            Ink::Marked => self.marked,
            Ink::Cursor => self.cursor,
        }
    }

    /// Colour of a value between −1 and 1: two hues that people with a colour vision deficiency can tell apart, nothing at 0.
    pub fn signed(&self, share: f64) -> Rgb {
        mixed(self.canvas, if share < 0.0 { self.series[2] } else { self.series[0] }, share)
    }

    /// Colour of an amount between 0 and 1, the least of which can be told from nothing.
    pub fn amount(&self, share: f64) -> Rgb {
        mixed(self.grid, self.series[0], share)
    }
}

/// From one colour to another; small shares are seen, too.
fn mixed(from: Rgb, to: Rgb, share: f64) -> Rgb {
    let part = share.abs().clamp(0.0, 1.0).sqrt();
    std::array::from_fn(|n| (f64::from(from[n]) * (1.0 - part) + f64::from(to[n]) * part).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On paper without colours only the dash is left.
    #[test]
    fn no_two_dashes_are_alike() {
        let mut all: Vec<Dash> = DASHES.into_iter().chain(MODEL_DASHES).chain([PREDICTED_DASH]).collect();
        let count = all.len();
        let is_like = |one: &Dash, other: &Dash| {
            one.len() == other.len() && one.iter().zip(*other).all(|(one, other)| (one / other - 1.0f32).abs() < 0.4)
        };
        while let Some(dash) = all.pop() {
            assert!(!all.iter().any(|other| is_like(&dash, other)), "{dash:?}");
        }
        assert_eq!(count, 16);
    }

    /// Also without colours: where a dash comes again, the grey is another.
    #[test]
    fn forty_series_look_different_on_paper() {
        let look = |n: usize| (Ink::Series(n).dash(), i32::from(GREY.of(Ink::Series(n))[0]));
        for n in 0..40 {
            for other in 0..n {
                let ((dash, grey), (dash_of_other, grey_of_other)) = (look(n), look(other));
                assert!(dash != dash_of_other || (grey - grey_of_other).abs() >= 0x14, "{other} and {n}");
            }
        }
    }
}
