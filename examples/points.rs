//! Random points for `models/large/network.lag`, one a unit of volume, as CSV.
//!
//! ```text
//! cargo run --release --example points -- 10000 > models/large/points.csv
//! ```

use std::io::{BufWriter, Write as _};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: u32 = std::env::args().nth(1).ok_or("how many points?")?.parse()?;
    let side = f64::from(count).cbrt();
    // G. Marsaglia, "Xorshift RNGs", J. Stat. Softw. 8 (2003): the same points each time.
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        side * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut out = BufWriter::new(std::io::stdout().lock());
    writeln!(out, "x,y,z")?;
    for _ in 0..count {
        writeln!(out, "{:.6},{:.6},{:.6}", next(), next(), next())?;
    }
    Ok(out.flush()?)
}
