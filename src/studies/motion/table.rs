//! Starts and times from tables: CSV texts with a header.

use super::{MotionError, Times};
use crate::source;
use librate_core::model::{Cell, Constant, Table};
use librate_core::number::Number;

/// Reads a CSV text that has rows.
pub(super) fn read(text: &str) -> Result<Table, MotionError> {
    let table = source::table(text, "table").map_err(|(line, reason)| MotionError::BadTable { line, reason })?;
    if table.rows() == 0 {
        return Err(MotionError::BadTable { line: 1, reason: "there is no row below the header".to_owned() });
    }
    Ok(table)
}

pub(super) fn bad(table: &Table, row: usize, reason: String) -> MotionError {
    MotionError::BadTable { line: table.line(row), reason }
}

/// The number in a row counted from 1.
pub(super) fn number(table: &Table, row: usize, column: usize) -> Result<&Number, MotionError> {
    match table.field(row as i64, column) {
        Some(Cell::Number(number)) => Ok(number),
        Some(Cell::Text(text)) => {
            let column = &table.columns[column];
            Err(bad(table, row, format!("`{}` in the column `{column}` is not a number", text.escape_debug())))
        }
        None => Err(bad(table, row, "the row is too short".to_owned())),
    }
}

impl Times {
    /// The times in the column `t` of a CSV text, in any order.
    ///
    /// # Errors
    /// What is no table of numbers, a table without such a column, and a time before the start.
    pub fn table(text: &str) -> Result<Self, MotionError> {
        let table = read(text)?;
        let column = table.columns.iter().position(|own| own == "t").ok_or_else(|| MotionError::BadTable {
            line: 1,
            reason: format!("there is no column `t`, but {}", table.some_columns().join(", ")),
        })?;
        let mut times = Vec::with_capacity(table.rows());
        for row in 1..=table.rows() {
            let number = number(&table, row, column)?;
            if number.is_negative() {
                return Err(bad(&table, row, "a motion begins at t = 0; this time is before".to_owned()));
            }
            let time = Constant::parse(&number.to_string()).map_err(|error| bad(&table, row, error.to_string()))?;
            times.push(time);
        }
        Self::listed(&times)
    }
}
