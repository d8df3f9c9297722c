//! Out of the house. A model: into the [`controller`] that drives the arm, back into the [`robot`]'s own file, a [`network`] with what
//! computes its torque elsewhere; [`outgoing`] makes the files of any [`kind`]. Data: what was [`recorded`], and the [`torques`] of a
//! model there, whole or a [`part`]. [`files`] are written in one way.

pub mod controller;
pub mod files;
pub mod kind;
pub mod network;
pub mod outgoing;
pub mod part;
pub mod recorded;
pub mod robot;
pub mod share;
pub mod torques;

#[cfg(test)]
mod tests;
