//! Random points for `models/large/network.lag`, one a unit of volume, as CSV.
//!
//! ```text
//! cargo run --release --example points -- 10000 > models/large/points.csv
//! ```

use std::fmt::Write as _;
use std::io::Write as _;

/// The table, the same each time.
pub(crate) fn table(count: u32) -> String {
    let side = f64::from(count).cbrt();
    // G. Marsaglia, "Xorshift RNGs", J. Stat. Softw. 8 (2003).
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        side * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut out = "x,y,z\n".to_owned();
    for _ in 0..count {
        let _ = writeln!(out, "{:.6},{:.6},{:.6}", next(), next(), next());
    }
    out
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count = std::env::args().nth(1).ok_or("how many points?")?.parse()?;
    Ok(std::io::stdout().write_all(table(count).as_bytes())?)
}
