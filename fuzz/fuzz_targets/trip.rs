//! The whole trip from text to modes answers any small model.
#![no_main]

#[path = "../checks.rs"]
mod checks;

libfuzzer_sys::fuzz_target!(|text: &str| checks::trip(text));
