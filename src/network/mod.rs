//! Networks with all the derivatives that a Lagrangian needs. Nothing here knows of robots.
//!
//! [`graph`] (what is computed) → [`differentiate`] (derivatives, which are graphs again) → [`program`] (instructions over
//! tiles of 64 samples) → [`kernel`] (the inner loops, for AVX-512, AVX2 and every other machine). [`mod@dense`] makes layers,
//! [`layout`] says where each weight stands, [`team`] runs tiles on all cores, [`onnx`] writes a graph for others.
//!
//! The cost of torque from a structured Lagrangian does not grow with the square of the number of joints: one tangent and one
//! reverse pass give it, one more reverse pass gives the gradient by all weights.

pub mod buffer;
pub mod dense;
pub mod differentiate;
pub mod graph;
pub mod kernel;
pub mod layout;
pub mod onnx;
pub mod program;
pub mod team;

pub use buffer::Buffer;
pub use dense::{Activation, dense, draw_weights};
pub use graph::{Graph, Node};
pub use kernel::{AdamStep, Element, Function, Kernels, TILE, lower_index};
pub use layout::{Block, BlockId, Layout};
pub use program::{Arena, Program};
