//! Time against true error, for every path to the frequencies: writes `docs/speed-and-error.md` and its
//! pictures.
//!
//! ```text
//! cargo run --release --example speed_and_error -- [--python PATH] [--quick] [--out DIR]
//! ```
//!
//! The peers run in Python (`peers.py`), those that are installed with the interpreter given; without any the
//! document says so. `--quick` leaves out what takes longer than a second; `--out` writes elsewhere than to
//! `docs`. True values: `truth`. What is measured: `case` (problems), `paths` and `peers.py` (calls),
//! `judge` (errors), `run` (all together). What is written: `document`, `plots`.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "tells where the document went")]

mod case;
mod cells;
mod clock;
mod document;
mod frame;
mod judge;
mod machine;
mod paths;
mod peers;
mod plots;
mod process;
#[allow(dead_code, reason = "the campaign uses more of it")]
#[path = "../campaign/real.rs"]
mod real;
#[allow(dead_code, reason = "the campaign uses more of it")]
#[path = "../campaign/reference.rs"]
mod reference;
mod run;
mod truth;

use std::error::Error;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};

use peers::Peers;
use run::Plan;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut python, mut out) = ("python3".to_owned(), root.join("docs"));
    let mut plan = Plan::FULL;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--python" => python = value()?,
            "--out" => out = PathBuf::from(value()?),
            "--quick" => {
                plan.patience = 0.01;
                plan.longest = 1.0;
                plan.largest = 100;
            }
            _ => return Err(format!("what is {argument}?").into()),
        }
    }
    let peers = Peers::start(&python, &root.join("examples/speed_and_error/peers.py"));
    if let Err(reason) = &peers {
        eprintln!("no peers: {reason}");
    }
    // Shows itself on a terminal only.
    let bar = ProgressBar::new(plan.len() as u64);
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}")?);
    let report = plan.run(root, peers, |name| {
        bar.set_message(name.to_owned());
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    document::write(&report, &plan, &out)?;
    println!("{}", out.join("speed-and-error.md").display());
    let wrong = report.violations();
    if wrong.is_empty() { Ok(()) } else { Err(format!("bounds that do not hold: {}", wrong.join(", ")).into()) }
}
