//! Work against precision of motions: writes `docs/work-precision.md` and its picture.
//!
//! ```text
//! cargo run --release --example work_precision -- [--python PATH] [--quick] [--out DIR]
//! ```
//!
//! A double pendulum over a hundred seconds, by librate and by integrators in Python (`integrators.py`: SciPy, heyoka), those
//! that are installed with the interpreter given; without any the document says so. Errors are held against 40 digits that
//! share no code with any of them (`tests/reference/motion.py`). `--quick` leaves out what takes longer than a tenth of a second.
//! What is measured: `run`. What is written: `document`, `picture`.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "tells where the document went")]

#[allow(dead_code, reason = "other examples use more of it")]
#[path = "../speed_and_error/clock.rs"]
mod clock;
mod document;
#[path = "../speed_and_error/frame.rs"]
mod frame;
#[path = "../speed_and_error/machine.rs"]
mod machine;
mod picture;
#[path = "../speed_and_error/process.rs"]
mod process;
mod run;

use std::error::Error;
use std::path::{Path, PathBuf};

use process::Peers;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut python, mut out) = ("python3".to_owned(), root.join("docs"));
    let (mut patience, mut longest) = (1.0, 60.0);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--python" => python = value()?,
            "--out" => out = PathBuf::from(value()?),
            "--quick" => (patience, longest) = (0.01, 0.1),
            _ => return Err(format!("what is {argument}?").into()),
        }
    }
    let peers = Peers::start(&python, &root.join("examples/work_precision/integrators.py"))
        .inspect_err(|reason| eprintln!("no peers: {reason}"));
    let report = run::run(root, peers, patience, longest)?;
    document::write(&report, &out)?;
    println!("{}", out.join("work-precision.md").display());
    Ok(())
}
