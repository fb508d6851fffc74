//! Short runs of the measuring examples.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]
#![cfg(feature = "cli")]
#![allow(dead_code, reason = "the examples report more than a test asks for")]

mod campaign;
mod speed_and_error;
mod work_precision;

#[path = "../../examples/campaign/check.rs"]
mod check;
#[path = "../../examples/speed_and_error/clock.rs"]
mod clock;
#[path = "../../examples/campaign/digits.rs"]
mod digits;
#[path = "../../examples/campaign/draw.rs"]
mod draw;
#[path = "../../examples/campaign/exponents.rs"]
mod exponents;
#[path = "../../examples/speed_and_error/frame.rs"]
mod frame;
#[path = "../../examples/campaign/kinds/mod.rs"]
mod kinds;
#[path = "../../examples/speed_and_error/machine.rs"]
mod machine;
#[path = "../../examples/campaign/pencil.rs"]
mod pencil;
#[path = "../../examples/points.rs"]
mod points;
#[path = "../../examples/speed_and_error/process.rs"]
mod process;
#[path = "../../examples/campaign/real.rs"]
mod real;
#[path = "../../examples/campaign/reference.rs"]
mod reference;
#[path = "../../examples/campaign/survey.rs"]
mod survey;
