//! The library and the command line, without a window. One program, so that there is one to link: `cargo test --test suite NAME`
//! runs the tests whose path, such as `journeys::`, contains NAME.

#![allow(clippy::unwrap_used)] // a test fails where something is not as it should be

mod again;
mod architecture;
mod arm_oracle;
mod catalogue;
mod circles;
mod command_line;
mod contact;
mod experiment;
mod gallery;
mod hold_out;
mod journeys;
mod lessons;
mod network_oracle;
mod oracle;
mod outside;
mod own_effects;
mod pairs;
mod real_logs;
mod recordings;
mod runner;
mod selftest;
mod set_up;
mod stated_arm;
mod torque;
mod training;
