//! Time and memory of parsing a large file, one process a file so that the peaks stay apart.
//!
//! ```text
//! cargo build --release --no-default-features --example parse_cost
//! for form in statements sum; do target/release/examples/parse_cost $form; done
//! ```
//!
//! The peak is the greatest resident size of the whole process (Linux only), the text included;
//! the time is processor time.
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use std::fmt::Write;

use librate::syntax::parse;
use rustix::time::{ClockId, clock_gettime};

/// Processor time of this process so far, in seconds.
fn seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The greatest resident size so far, in megabytes.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes * 1024.0 / 1e6)
}

/// A file of `count` short statements of three kinds.
fn statements(count: usize) -> String {
    let mut text = String::with_capacity(64 * count);
    for i in 0..count {
        let written = match i % 4 {
            0 => writeln!(text, "param k{i} : N/m = 2.5 + {i}/7  # spring number {i}"),
            1 => writeln!(text, "let r{i} = sqrt((x[{i}] - x[2])^2 + y{i}^2) - l0"),
            2 => writeln!(text, "param m{i} : kg = {i}e-3"),
            _ => writeln!(text, "let u{i} = k{i}/2*(x[{i}] - x[{i}+1] + a)^2 + m*g*sin(phi)"),
        };
        if written.is_err() {
            break;
        }
    }
    text
}

/// One potential of `count` terms.
fn sum(count: usize) -> String {
    let mut text = String::with_capacity(40 * count);
    text.push_str("V = 0");
    for i in 1..=count {
        let sign = if i % 5 == 0 { '-' } else { '+' };
        if write!(text, "\n  {sign} 1/2*k[{i}]*(x[{i}] - x[3])^2").is_err() {
            break;
        }
    }
    text
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let form = std::env::args().nth(1).unwrap_or_default();
    let text = match form.as_str() {
        "statements" => statements(200_000),
        "sum" => sum(300_000),
        path => std::fs::read_to_string(path)?,
    };
    let before = peak();
    let start = seconds();
    let file = parse(&text).map_err(|errors| format!("{} mistakes", errors.len()))?;
    let taken = seconds() - start;
    let megabytes = text.len() as f64 / 1e6;
    println!(
        "{form}: {megabytes:.1} MB of text, {} statements, {} expressions, {} units, {} comments",
        file.statements.len(),
        file.expressions.len(),
        file.units.len(),
        file.comments.len(),
    );
    println!(
        "{taken:.2} s, {:.1} MB/s, at most {:.0} MB of memory ({:.0} MB before parsing)",
        megabytes / taken,
        peak().unwrap_or(f64::NAN),
        before.unwrap_or(f64::NAN),
    );
    Ok(())
}
