//! From a text to normal modes through the library, one function a stage.
//!
//! ```text
//! cargo run --example whole_trip
//! ```
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use librate::model::{self, Settings, TableTexts};
use librate::precision::decimal;
use librate::{Error, derive, linearize, modes, oscillation, syntax};

/// Two carts between walls, the springs from a table; the library reads no files, so the table is
/// handed over as text.
const CARTS: &str = "
    model carts
    table springs = \"springs.csv\"
    param m[1..2] = [1, 2]
    coord x[1..2]
    let at[0] = 0
    let at[i in 1..2] = x[i]
    let at[3] = 0
    T = sum(i in 1..2, 1/2*m[i]*x[i]'^2)
    V = sum(s in springs, 1/2*s.k*(at[s.right] - at[s.left])^2)
";

const SPRINGS: &str = "left,right,k\n0,1,3\n1,2,0.5\n2,3,4\n";

fn main() -> Result<(), Error> {
    let file = syntax::parse(CARTS)?;
    let tables = TableTexts::new().with("springs.csv", SPRINGS);
    let mut settings = Settings::new();
    settings.add("m[2]=5/2")?;
    let model = model::elaborate(&file, &tables, &settings)?;

    // The matrices in symbols.
    let derivation = derive::derive(&model, &derive::Parts::default())?;
    for row in &derivation.linear?.stiffness {
        let row: Vec<String> = row.iter().map(|entry| derivation.pool.display(*entry)).collect();
        println!("K: {}", row.join(", "));
    }

    // The same in numbers with bounds, and the modes.
    let linearized = linearize::linearize(model)?;
    let options = modes::Options::default().digits(20);
    let normal = oscillation::normal_modes(&linearized, &options)?;
    for mode in &normal.modes {
        let omega = decimal(&mode.omega, options.digits);
        println!("omega = {}, shape {:.3?}", omega.text, mode.vector);
    }
    Ok(())
}
