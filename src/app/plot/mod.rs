//! Plots: panels of figures, printed in the window, and what can be done with them.

mod adapter;
mod along;
pub mod arm;
pub mod export;
mod gestures;
mod header;
mod key;
mod linked;
mod menu;
mod own;
mod screen;
pub mod series;
pub mod spatial;
#[cfg(test)]
mod tests;
mod view;

pub use crate::figure::{decimate, ticks};
pub use along::Along;
pub use decimate::Decimator;
pub use gestures::Region;
pub use key::key_of;
pub use linked::{Views, Window};
pub use own::{CHANNELS, Drawn, OwnLine, OwnLines, OwnSeries};
use view::Tools;
pub use view::{PanelView, Shown};
