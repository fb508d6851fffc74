//! Time against true error, for every path to the frequencies: writes `docs/speed-and-error.md` and its
//! pictures.
//!
//! ```text
//! cargo run --release --example speed_and_error -- [--python PATH] [--quick] [--only dense|sparse] [--out DIR]
//! ```
//!
//! `--only sparse` measures the chapter on large models alone and puts it into the document that is there, `--only dense` leaves that
//! chapter as it is. The peers run in Python (`peers.py`), those that are installed with the interpreter given; without any the
//! document says so. `--quick` leaves out what takes longer than a second; `--out` writes elsewhere than to
//! `docs`. True values: `truth`. What is measured: `case` (problems), `paths` and `peers.py` (calls), `large` (some modes of
//! large models), `judge` (errors), `run` (all together). What is written: `document`, `growth` (that chapter), `plots`.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "tells where the document went")]

mod case;
mod cells;
#[allow(dead_code, reason = "other examples use more of it")]
mod clock;
mod document;
mod frame;
mod growth;
mod judge;
mod large;
mod machine;
mod paths;
mod peers;
mod plots;
#[allow(dead_code, reason = "a program of its own")]
#[path = "../points.rs"]
mod points;
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
    let mut arguments = std::env::args().skip(1).peekable();
    if arguments.next_if(|first| first == large::ONE).is_some() {
        let own: Vec<String> = arguments.collect();
        println!("{}", large::one(root, own.try_into().map_err(|_| "four arguments are needed")?)?);
        return Ok(());
    }
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--python" => python = value()?,
            "--out" => out = PathBuf::from(value()?),
            "--quick" => {
                plan.patience = 0.01;
                plan.longest = 1.0;
                plan.longest_sparse = 5.0;
                plan.largest = plan.largest.min(100);
                plan.largest_sparse = plan.largest_sparse.min(10_000);
            }
            "--only" => match value()?.as_str() {
                "dense" => plan.largest_sparse = 0,
                "sparse" => (plan.hard, plan.largest) = (&[], 0),
                other => return Err(format!("what is {other}?").into()),
            },
            _ => return Err(format!("what is {argument}?").into()),
        }
    }
    let mut peers = Peers::start(&python, &root.join("examples/speed_and_error/peers.py"))
        .inspect_err(|reason| eprintln!("no peers: {reason}"));
    // Shows itself on a terminal only.
    let bar = ProgressBar::new(plan.len() as u64);
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}")?);
    let tell = |name: &str| {
        bar.set_message(name.to_owned());
        bar.inc(1);
    };
    let dense = (plan.largest > 0).then(|| plan.run(root, &mut peers, tell)).transpose()?;
    let sparse =
        (plan.largest_sparse > 0).then(|| large::run(&plan, &mut peers, &large::ask_child, tell)).transpose()?;
    bar.finish_and_clear();
    document::write(dense.as_ref(), sparse.as_ref(), &plan, &out)?;
    println!("{}", out.join("speed-and-error.md").display());
    let reports = dense.iter().chain(sparse.iter().map(|own| &own.report));
    let wrong: Vec<String> = reports.flat_map(run::Report::violations).collect();
    if wrong.is_empty() { Ok(()) } else { Err(format!("bounds that do not hold: {}", wrong.join(", ")).into()) }
}
