//! A model out of the house: into the [`controller`] that drives the arm, and back into the [`robot`]'s own file.

pub mod controller;
pub mod robot;
pub mod share;
