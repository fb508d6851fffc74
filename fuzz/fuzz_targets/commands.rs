//! Every subcommand answers any model within its time and memory.
#![no_main]

#[path = "../commands.rs"]
mod commands;

libfuzzer_sys::fuzz_target!(|text: &str| commands::check(text));
