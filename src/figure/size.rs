//! How large a figure is on paper, and with it its letters and lines, as those who print it ask.
//!
//! Lines have an eighth of the letters' height: 1 point at IEEE's 8, 0.75 at Nature's 6, which is within what both want.

use std::str::FromStr;

/// Points of a millimetre.
pub(super) const POINTS_PER_MILLIMETRE: f64 = 72.0 / 25.4;

/// How wide a figure is, which also sets its letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Size {
    /// One column of a page: 85 mm.
    OneColumn,
    /// A page from margin to margin: 175 mm.
    #[default]
    TwoColumn,
    /// One column of an IEEE journal.
    Ieee,
    /// Both columns of an IEEE journal.
    IeeeTwoColumn,
    /// One column of Nature.
    Nature,
    /// Both columns of Nature.
    NatureTwoColumn,
    /// A slide of 254 × 143 mm; panels share its height.
    Slide,
}

impl Size {
    /// All sizes, in the order in which lists show them.
    pub const ALL: [Size; 7] = [
        Size::OneColumn,
        Size::TwoColumn,
        Size::Ieee,
        Size::IeeeTwoColumn,
        Size::Nature,
        Size::NatureTwoColumn,
        Size::Slide,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Size::OneColumn => "one-column",
            Size::TwoColumn => "two-column",
            Size::Ieee => "ieee",
            Size::IeeeTwoColumn => "ieee-two-column",
            Size::Nature => "nature",
            Size::NatureTwoColumn => "nature-two-column",
            Size::Slide => "slide",
        }
    }

    /// What it is, for lists.
    pub fn about(self) -> &'static str {
        match self {
            Size::OneColumn => "one column, 85 mm",
            Size::TwoColumn => "two columns, 175 mm",
            Size::Ieee => "IEEE, one column of 88.9 mm, 8 pt",
            Size::IeeeTwoColumn => "IEEE, two columns, 182 mm, 8 pt",
            Size::Nature => "Nature, one column of 89 mm, 6 pt",
            Size::NatureTwoColumn => "Nature, two columns, 183 mm, 6 pt",
            Size::Slide => "slide, 254 × 143 mm",
        }
    }

    /// Its width \[points\].
    ///
    /// IEEE: 21 and 43 picas of 12 points (IEEE Author Center, Size Requirements for Graphics: 88.9 and 182 mm). Nature: 89 and 183 mm
    /// (Nature research figure guide, Figure sizing).
    pub(super) fn width(self) -> f64 {
        match self {
            Size::OneColumn => 241.0,
            Size::TwoColumn => 496.0,
            Size::Ieee => 21.0 * 12.0,
            Size::IeeeTwoColumn => 43.0 * 12.0,
            Size::Nature => 89.0 * POINTS_PER_MILLIMETRE,
            Size::NatureTwoColumn => 183.0 * POINTS_PER_MILLIMETRE,
            Size::Slide => 720.0,
        }
    }

    /// Height of its letters \[points\]; titles are a tenth larger.
    ///
    /// IEEE: 8 points throughout (Guidelines for author supplied electronic text and graphics). Nature: 5 to 7 points (Nature research
    /// figure guide, Fonts).
    pub(super) fn letter(self) -> f64 {
        match self {
            Size::OneColumn => 7.0,
            Size::TwoColumn | Size::Ieee | Size::IeeeTwoColumn => 8.0,
            Size::Nature | Size::NatureTwoColumn => 6.0,
            Size::Slide => 12.0,
        }
    }

    /// Pixels per inch of a picture in pixels: 600 for line art (IEEE, the same guidelines; Nature asks for 450 at least); a slide is
    /// looked at on a screen.
    pub fn dpi(self) -> f64 {
        if self == Size::Slide { 300.0 } else { 600.0 }
    }

    /// Whether a page has room for two of it beside each other.
    pub(super) fn is_narrow(self) -> bool {
        matches!(self, Size::OneColumn | Size::Ieee | Size::Nature)
    }

    /// Whether lines behind the plot go on from its numbers; without, short marks stand at the axes (Nature research figure guide,
    /// Graphs: no background gridlines, but tick marks).
    pub(super) fn has_grid(self) -> bool {
        !matches!(self, Size::Nature | Size::NatureTwoColumn)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Size::ALL.into_iter().find(|size| size.name() == text);
        let known = || Size::ALL.map(Size::name).join(", ");
        found.ok_or_else(|| format!("there is no size `{text}`: choose one of {}", known()))
    }
}
