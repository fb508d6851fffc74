//! The command line, its files, messages and schemas; documents; the layout of the house.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod book;
mod budget;
mod cli;
mod cli_files;
mod cli_fmt;
mod cli_messages;
#[cfg(feature = "cli")]
#[path = "../cli_support/mod.rs"]
mod cli_support;
mod code;
#[cfg(feature = "engine")]
#[path = "../common/mod.rs"]
mod common;
mod dimensions;
mod embedding;
mod expect;
mod explanations;
mod export;
mod forces;
mod guide;
mod inertia;
mod inertia_meshes;
mod layers;
mod limits;
mod lsp;
mod mistakes;
mod pictures;
mod reference;
mod schema;
mod snapshots;
mod sweep;
mod typing;
mod written;
