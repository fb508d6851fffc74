//! Matrices in the Matrix Market format as tables with the columns i, j and v (R. Boisvert, R. Pozo, K. Remington, "The Matrix Market exchange
//! formats: initial design", NISTIR 5935 (1996)).

use super::table::{excerpt, parse_field};
use crate::number::Number;

/// The entries of a matrix, and the lines that they stand in, from 1.
pub(super) type Entries = Vec<([Number; 3], u64)>;

/// What is wrong, and in which line.
pub(super) type Mistake = (u64, String);

/// What mirrored entries are.
#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

/// What the first line says.
struct Header {
    /// Whether every entry stands there, column by column, instead of rows `i j v`.
    is_array: bool,
    /// Whether entries have no values; they are 1.
    is_pattern: bool,
    symmetry: Symmetry,
}

impl Header {
    fn read(line: &str) -> Result<Self, String> {
        let line = line.to_ascii_lowercase();
        let words: Vec<&str> = line.split_whitespace().collect();
        let ["%%matrixmarket", "matrix", format, field, symmetry] = words[..] else {
            return Err(
                "the first line of a Matrix Market file is `%%MatrixMarket matrix coordinate real symmetric`, or \
                        the like"
                    .to_owned(),
            );
        };
        let is_array = match format {
            "coordinate" => false,
            "array" => true,
            _ => return Err(format!("the format `{}` is neither coordinate nor array", excerpt(format))),
        };
        let is_pattern = match field {
            "real" | "integer" | "double" => false,
            "pattern" if !is_array => true,
            _ => return Err(format!("entries that are `{}` can't be read: real and integer ones can", excerpt(field))),
        };
        let symmetry = match symmetry {
            "general" => Symmetry::General,
            "symmetric" | "hermitian" => Symmetry::Symmetric,
            "skew-symmetric" => Symmetry::Skew,
            _ => return Err(format!("the symmetry `{}` is none of the format", excerpt(symmetry))),
        };
        Ok(Self { is_array, is_pattern, symmetry })
    }
}

/// All entries of a matrix; of a symmetric one also those that are mirrored, each behind its own.
pub(super) fn entries(text: &str) -> Result<Entries, Mistake> {
    let mut lines = (1..).zip(text.lines());
    let header = Header::read(lines.next().map_or("", |(_, line)| line)).map_err(|reason| (1, reason))?;
    let mut lines = lines.filter(|(_, line)| !line.trim_start().starts_with('%') && !line.trim().is_empty());
    let Some((at, sizes)) = lines.next() else {
        return Err((1, "the line with the numbers of rows and columns is missing".to_owned()));
    };
    let sizes: Option<Vec<u64>> = sizes.split_whitespace().map(|size| size.parse().ok()).collect();
    let (rows, columns, count) = match (sizes.as_deref(), header.is_array) {
        (Some([rows, columns]), true) => (*rows, *columns, None),
        (Some([rows, columns, count]), false) => (*rows, *columns, Some(*count)),
        _ => {
            let wanted = if header.is_array { "rows and columns" } else { "rows, columns and entries" };
            return Err((at, format!("this line should have the numbers of {wanted}")));
        }
    };
    if rows == 0 || columns == 0 {
        return Err((at, "the matrix has no entries".to_owned()));
    }
    if header.symmetry != Symmetry::General && rows != columns {
        return Err((at, format!("a symmetric matrix of {rows} rows has not {columns} columns")));
    }
    let mut found: Entries = Vec::new();
    let mut add = |i: u64, j: u64, value: Number, line: u64| {
        let number = |x: u64| i64::try_from(x).map_or(Number::ZERO, Number::from);
        let mirrored = match header.symmetry {
            Symmetry::Symmetric if i != j => Some(value.clone()),
            Symmetry::Skew if i != j => Some(value.neg()),
            _ => None,
        };
        found.push(([number(i), number(j), value], line));
        found.extend(mirrored.map(|value| ([number(j), number(i), value], line)));
    };
    let number =
        |field: &str, line: u64| parse_field(field).ok_or_else(|| (line, format!("`{}` is no number", excerpt(field))));
    let (mut read, mut last) = (0_u64, at);
    // Of one triangle the other one follows: entries of both would count twice.
    let mut is_lower = None;
    let mut places = places(rows, columns, header.symmetry);
    for (line, text) in lines {
        last = line;
        let fields: Vec<&str> = text.split_whitespace().collect();
        if header.is_array {
            for field in fields {
                let Some((i, j)) = places.next() else {
                    return Err((line, format!("there are more numbers than a matrix of {rows} by {columns} has")));
                };
                add(i, j, number(field, line)?, line);
            }
            continue;
        }
        let (i, j, value) = match (&fields[..], header.is_pattern) {
            ([i, j], true) => (i, j, Number::ONE),
            ([i, j, value], false) => (i, j, number(value, line)?),
            _ => {
                let wanted = if header.is_pattern { "row and column" } else { "row, column and value" };
                return Err((line, format!("this line should have {wanted}")));
            }
        };
        let inside = |index: &str, most: u64| {
            let own = index.parse().ok().filter(|own| (1..=most).contains(own));
            own.ok_or_else(|| (line, format!("the index `{}` is not in 1..{most}", excerpt(index))))
        };
        let (i, j) = (inside(i, rows)?, inside(j, columns)?);
        if header.symmetry != Symmetry::General && i != j && *is_lower.get_or_insert(i > j) != (i > j) {
            let reason =
                "a symmetric file has the entries of one triangle, the others follow: this one is in the other";
            return Err((line, reason.to_owned()));
        }
        add(i, j, value, line);
        read += 1;
    }
    match count {
        Some(count) if count != read => Err((last, format!("there are {read} entries where {count} are announced"))),
        None if places.next().is_some() => {
            Err((last, format!("there are fewer numbers than a matrix of {rows} by {columns} has")))
        }
        Some(_) | None => Ok(found),
    }
}

/// The places of an array in the order of its numbers: column by column, of symmetric ones the lower triangle.
fn places(rows: u64, columns: u64, symmetry: Symmetry) -> impl Iterator<Item = (u64, u64)> {
    let first = move |j: u64| match symmetry {
        Symmetry::General => 1,
        Symmetry::Symmetric => j,
        Symmetry::Skew => j + 1,
    };
    (1..=columns).flat_map(move |j| (first(j)..=rows).map(move |i| (i, j)))
}
