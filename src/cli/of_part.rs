use clap::Args;

use super::choice::{Choice, one_of};
use crate::export::part::Part;

/// Which part of a recording is written.
#[derive(Args, Debug, Clone)]
pub struct OfPart {
    /// Of what: all of it, only what a model learns from, or only what is held out.
    #[arg(long, default_value = Part::Whole.name(), value_parser = one_of(parts()))]
    pub part: Part,
}

fn parts() -> [Choice<Part>; 3] {
    Part::ALL.map(|part| (part.name(), part.about(), part))
}
