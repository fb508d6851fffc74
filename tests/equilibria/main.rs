//! Equilibria: the search and its proofs, constraints, zero modes, symmetries, parts apart from each other.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod boxes;
mod branches;
#[cfg(feature = "engine")]
#[path = "../common/mod.rs"]
mod common;
mod conditioning;
mod constraints;
mod decoupled;
mod equilibrium;
mod equilibrium_proof;
mod patterns;
mod point_groups;
mod roots;
mod symmetry;
mod zero_modes;
