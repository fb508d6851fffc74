//! Modes over a range of a parameter, as CSV and JSON.

use std::io::{self, Write};

use super::json::{number, string};
use super::motion::plain;
use super::{Written, modes_json};
use librate_core::modes::Options;
use librate_core::oscillation::NormalModes;
use librate_core::precision::quick_decimal;
use librate_studies::sweep::{Enclosed, Place};

/// A line of a table: the parameter, and frequency and growth of each mode in writing.
#[derive(Clone, Debug, Default, PartialEq)]
#[must_use]
pub struct SweepRow {
    value: f64,
    modes: Vec<[String; 2]>,
}

impl SweepRow {
    /// The line of a value without modes.
    pub fn empty(value: f64) -> Self {
        Self { value, modes: Vec::new() }
    }

    /// Numbers have so many correctly rounded digits, or those that are certain.
    pub fn new(value: f64, modes: &NormalModes, digits: usize) -> Self {
        let cells = |mode| Written::of_mode(mode, digits).map(|written| written.digits.unwrap_or_default());
        Self { value, modes: modes.modes.iter().map(cells).collect() }
    }

    /// The same line from enclosures, where these decide all digits.
    #[must_use]
    pub fn enclosed(value: f64, modes: &[Enclosed], digits: usize) -> Option<Self> {
        let cells =
            modes.iter().map(|mode| Some([quick_decimal(&mode.omega, digits)?, quick_decimal(&mode.growth, digits)?]));
        Some(Self { value, modes: cells.collect::<Option<_>>()? })
    }
}

/// The columns of a table: the parameter, `omega1`, `omega2`, …, and maybe `growth1`, …
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepColumns {
    name: String,
    modes: usize,
    growth: bool,
}

impl SweepColumns {
    /// Those that lines need: as many modes as the longest, and growth where some isn't 0, or asked for.
    #[must_use]
    pub fn of<'a>(name: &str, rows: impl Iterator<Item = &'a SweepRow>, growth: bool) -> Self {
        let mut columns = Self { name: name.to_owned(), modes: 0, growth };
        for row in rows {
            columns.modes = columns.modes.max(row.modes.len());
            columns.growth |= row.modes.iter().any(|[_, growth]| growth != "0");
        }
        columns
    }

    /// Those of a header; `None` where it is none of this parameter's.
    fn of_header(name: &str, header: &csv::StringRecord) -> Option<Self> {
        let count = header.len() - 1;
        let fitting = [(count, false), (count / 2, true)];
        let fitting = fitting.map(|(modes, growth)| Self { name: name.to_owned(), modes, growth });
        fitting.into_iter().find(|columns| header == columns.header())
    }

    /// The cells of the first line.
    fn header(&self) -> Vec<String> {
        let mut header = vec![self.name.clone()];
        let kinds = ["omega", "growth"].into_iter().take(1 + usize::from(self.growth));
        header.extend(kinds.flat_map(|kind| (1..=self.modes).map(move |at| format!("{kind}{at}"))));
        header
    }

    /// Whether all of a line has a place in them.
    #[must_use]
    pub fn hold(&self, row: &SweepRow) -> bool {
        row.modes.len() <= self.modes && (self.growth || row.modes.iter().all(|[_, growth]| growth == "0"))
    }

    /// The cells of a line; empty ones where it has fewer modes than others, or none.
    #[must_use]
    pub fn cells(&self, row: &SweepRow) -> Vec<String> {
        let mut cells = vec![number(row.value)];
        for kind in 0..=usize::from(self.growth) {
            let own = row.modes.iter().map(|mode| mode[kind].clone());
            cells.extend(own.chain(std::iter::repeat_with(String::new)).take(self.modes));
        }
        cells
    }
}

/// A table with one line a place, written line by line.
#[derive(Debug)]
pub struct SweepCsv<W: Write> {
    table: csv::Writer<W>,
    columns: SweepColumns,
}

impl<W: Write> SweepCsv<W> {
    /// Begins or goes on with a table of these columns.
    #[must_use]
    pub fn new(out: W, columns: SweepColumns) -> Self {
        Self { table: csv::Writer::from_writer(out), columns }
    }

    /// Writes the header.
    ///
    /// # Errors
    /// Those of the writer, here and below.
    pub fn header(&mut self) -> io::Result<()> {
        self.table.write_record(self.columns.header()).map_err(plain)
    }

    /// Writes a line.
    pub fn row(&mut self, row: &SweepRow) -> io::Result<()> {
        self.table.write_record(self.columns.cells(row)).map_err(plain)
    }

    /// Hands on all lines.
    pub fn flush(&mut self) -> io::Result<()> {
        self.table.flush()
    }
}

/// What there is of a table that was cut: its whole lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepKept {
    /// The columns; `None` without a header.
    pub columns: Option<SweepColumns>,
    /// The number of lines below the header.
    pub rows: usize,
    /// The last of them.
    pub last: Option<Vec<String>>,
    /// The length of all whole lines.
    pub bytes: u64,
}

impl SweepKept {
    /// Reads a table of a parameter, with a header or without, whose lines have these values.
    ///
    /// # Errors
    /// In words, what does not fit.
    pub fn read(bytes: &[u8], name: &str, header: bool, value: impl Fn(usize) -> Option<f64>) -> Result<Self, String> {
        let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let mut kept = Self { bytes: end as u64, ..Self::default() };
        let mut width = None;
        let mut lines = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&bytes[..end]);
        for (at, line) in lines.records().enumerate() {
            let place = at + 1;
            let line = line.map_err(|error| format!("line {place} can't be read ({error})"))?;
            if header && at == 0 {
                let columns = SweepColumns::of_header(name, &line);
                width = Some(line.len());
                kept.columns = Some(columns.ok_or_else(|| format!("line 1 is not the header of a sweep over {name}"))?);
                continue;
            }
            let value = value(kept.rows).ok_or_else(|| format!("line {place} is beyond the last value"))?;
            let value = number(value);
            if line.get(0) != Some(value.as_str()) {
                return Err(format!("line {place} does not begin with {value}, the value of {name} there"));
            }
            if *width.get_or_insert(line.len()) != line.len() {
                return Err(format!("line {place} has {} cells, others have more or fewer", line.len()));
            }
            kept.rows += 1;
            kept.last = Some(line.iter().map(str::to_owned).collect());
        }
        if kept.columns.is_none() && kept.last.is_none() {
            kept.bytes = 0;
        }
        Ok(kept)
    }
}

/// A place as an object: the parameter under its name, then all that [`modes_json`] has; `error` in its place where there are no modes.
#[must_use]
pub fn sweep_json(name: &str, place: &Place, options: &Options) -> String {
    let value = format!("{{{}: {}", string(name), number(place.value));
    match &place.result {
        Ok((linearized, modes)) => {
            let own = modes_json(linearized, modes, options);
            format!("{value}, {}", own.trim_start_matches('{').trim_end())
        }
        Err(error) => format!("{value}, \"error\": {}}}", string(&error.to_string())),
    }
}
