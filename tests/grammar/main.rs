//! Texts: the grammar, the language sentence by sentence, the formatter, highlighting.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod abbreviations;
#[cfg(feature = "cli")]
#[path = "../common/mod.rs"]
mod common;
#[allow(clippy::duplicate_mod, reason = "the fuzzers' checks bring theirs along")]
mod crashers;
mod cut;
mod format_files;
#[cfg(feature = "format")]
mod format_laws;
mod format_random;
mod highlighting;
mod language;
mod language_nasty;
#[cfg(feature = "engine")]
mod language_support;
mod stretches;
mod syntax;
#[path = "../syntax_common/mod.rs"]
mod syntax_common;
mod syntax_errors;
mod syntax_files;
mod syntax_random;
mod syntax_trees;
mod textmate;
mod tree_sitter;
mod typed;
