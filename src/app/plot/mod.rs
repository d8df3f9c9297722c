//! Plots: one [`Chart`] widget for time series and point clouds, and what it is made of.

pub mod arm;
pub mod chart;
pub mod export;
mod linked;

pub use crate::figure::{decimate, ticks};
pub use chart::{Cells, Chart, Region, Window};
pub use decimate::Decimator;
pub use linked::{Along, Views};
