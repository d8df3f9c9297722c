//! Work on all cores.
