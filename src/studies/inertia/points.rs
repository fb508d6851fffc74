//! Bodies made of points: a table of masses and places.

use super::InertiaError;
use crate::source;
use librate_core::model::{Cell, Table};
use librate_core::number::Number;

use super::body::{Integrals, Made, Sums};

/// What the column of masses may be called.
const MASS: [&str; 2] = ["m", "mass"];
/// The columns of the place.
const PLACE: [&str; 3] = ["x", "y", "z"];

/// The columns of a table by the names searched for.
fn column(table: &Table, names: &[&'static str]) -> Result<usize, InertiaError> {
    let mut fitting =
        (0..table.columns.len()).filter(|at| names.iter().any(|name| table.columns[*at].eq_ignore_ascii_case(name)));
    match (fitting.next(), fitting.next()) {
        (Some(one), None) => Ok(one),
        (Some(one), Some(other)) => {
            Err(InertiaError::ColumnTwice { first: table.columns[one].clone(), second: table.columns[other].clone() })
        }
        (None, _) => Err(InertiaError::MissingColumn { wanted: names.to_vec(), found: table.some_columns() }),
    }
}

/// Σ m, Σ m r and Σ m r rᵀ, from the exact decimals of a CSV text.
pub(super) fn read(text: &str) -> Result<Integrals, InertiaError> {
    let table = source::table(text, "points").map_err(|(line, reason)| InertiaError::BadTable { line, reason })?;
    let mass = column(&table, &MASS)?;
    let place = [column(&table, &PLACE[..1])?, column(&table, &PLACE[1..2])?, column(&table, &PLACE[2..])?];
    let mut sums = Sums::default();
    for row in 1..=table.rows() {
        let number = |column: usize| match table.field(row as i64, column) {
            Some(Cell::Number(number)) => Ok(number),
            Some(Cell::Text(text)) => Err(InertiaError::NotANumber {
                text: text.clone(),
                column: table.columns[column].clone(),
                line: table.line(row),
            }),
            None => Err(InertiaError::NoMass { rows: table.rows() }),
        };
        let m = number(mass)?;
        if m.is_negative() {
            return Err(InertiaError::NegativeMass { line: table.line(row), mass: m.to_decimal(6) });
        }
        let r = [number(place[0])?, number(place[1])?, number(place[2])?];
        sums.add(m, r);
    }
    if sums.size.is_zero() {
        return Err(InertiaError::NoMass { rows: table.rows() });
    }
    Ok(Integrals::new(sums, Made::Points { count: table.rows() }))
}

impl Sums {
    fn add(&mut self, m: &Number, r: [&Number; 3]) {
        self.size = self.size.add(m);
        for i in 0..3 {
            let moment = m.mul(r[i]);
            self.first[i] = self.first[i].add(&moment);
            for (j, r) in r.iter().enumerate().take(i + 1) {
                self.second[i][j] = self.second[i][j].add(&moment.mul(r));
                self.second[j][i] = self.second[i][j].clone();
            }
        }
    }
}
