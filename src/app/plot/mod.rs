//! Plots: one [`Chart`] widget for time series and point clouds, and what it is made of.

mod adapter;
pub mod arm;
pub mod chart;
pub mod export;
mod gestures;
mod header;
mod linked;
mod screen;
pub mod series;
#[cfg(test)]
mod tests;
mod view;

pub use crate::figure::{decimate, ticks};
pub use chart::{Cells, Chart};
pub use decimate::Decimator;
pub use gestures::Region;
pub use linked::{Along, Views, Window};
use view::Tools;
pub use view::{PanelView, Shown};
