//! Motions: integration and its proofs, periods, amplitudes, driven systems.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod amplitude;
mod charts;
#[cfg(feature = "cli")]
#[path = "../cli_support/mod.rs"]
mod cli_support;
#[cfg(feature = "engine")]
#[path = "../common/mod.rs"]
mod common;
mod floquet;
mod floquet_limits;
mod floquet_random;
mod following;
mod motion;
mod motion_hard;
mod motion_proved;
mod motion_steps;
#[cfg(feature = "cli")]
mod motion_support;
mod peaks;
mod period;
mod response;
