//! A model out of the house: into the [`controller`] that drives the arm, back into the [`robot`]'s own file, a [`network`] with what
//! computes its torque elsewhere.

pub mod controller;
pub mod network;
pub mod robot;
pub mod share;

#[cfg(test)]
mod tests;
