//! Reading STL, binary and ASCII, from bytes.
//!
//! `stl_io` reads the triangles; here it is decided which of the two forms a file has, by its length rather than by
//! its first word, and mistakes get their places. Nothing is allocated for what a file only declares.

use std::io::{Cursor, ErrorKind};

use super::InertiaError;

type Corners = [[f32; 3]; 3];

/// Bytes of the head of a binary file, with the number of triangles.
const HEAD: usize = 84;
/// Bytes of a triangle.
const TRIANGLE: usize = 50;

/// The triangles in the order of the file.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Corners>, InertiaError> {
    let declared = bytes.get(80..HEAD).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let fits = |count: u32| HEAD as u64 + TRIANGLE as u64 * u64::from(count) == bytes.len() as u64;
    if declared.is_none_or(|count| !fits(count)) && is_text(bytes) {
        return read_ascii(&String::from_utf8_lossy(bytes));
    }
    let Some(declared) = declared else {
        return Err(InertiaError::NotAMesh { reason: format!("{} bytes are too few", bytes.len()) });
    };
    if !fits(declared) {
        return Err(InertiaError::WrongLength { declared, room: (bytes.len() - HEAD) / TRIANGLE });
    }
    // The reader takes a head that begins with `solid` for ASCII.
    let mut plain = bytes.to_vec();
    plain[..80].fill(0);
    collect(plain, &|triangle, error| InertiaError::BadTriangle { triangle, line: None, reason: error })
}

/// Whether this begins as an ASCII file does.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let word = start.get(..5);
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && start.get(5).is_none_or(u8::is_ascii_whitespace)
}

/// The triangles of a file that the reader knows the form of.
fn collect(file: Vec<u8>, bad: &dyn Fn(usize, String) -> InertiaError) -> Result<Vec<Corners>, InertiaError> {
    let mut cursor = Cursor::new(file);
    let mut found: Vec<Corners> = Vec::new();
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|error| bad(0, error.to_string()))?;
    for triangle in triangles {
        match triangle {
            Ok(triangle) => found.push(triangle.vertices.map(|vertex| vertex.0)),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                return Err(InertiaError::CutOff { triangles: found.len() });
            }
            Err(error) => return Err(bad(found.len() + 1, error.to_string())),
        }
    }
    Ok(found)
}

/// Several solids in one file are read as one, which the reader would end at the first; keywords may be in capitals.
fn read_ascii(text: &str) -> Result<Vec<Corners>, InertiaError> {
    let lower = text.to_ascii_lowercase();
    let mut plain = String::with_capacity(lower.len() + 32);
    plain.push_str("solid mesh\n");
    let mut open = false;
    for line in lower.lines() {
        match line.split_whitespace().next() {
            Some("solid") if !open => open = true,
            Some("endsolid") if open => open = false,
            Some(_) | None => {
                plain.push_str(line);
                plain.push('\n');
            }
        }
    }
    if !open {
        plain.push_str("endsolid mesh\n");
    }
    collect(plain.into_bytes(), &|triangle, reason| {
        let mut facets = lower.lines().enumerate().filter(|(_, line)| line.trim_start().starts_with("facet"));
        let first = facets.nth(triangle.saturating_sub(1)).map(|(line, _)| line);
        let own = lower.lines().skip(first.unwrap_or(0));
        let own = own.take_while(|line| !line.trim_start().starts_with("endfacet"));
        let mut numbers = own.flat_map(str::split_whitespace);
        let infinite = |word: &str| word.parse::<f32>().is_ok_and(|x| !x.is_finite());
        if first.is_some() && numbers.any(infinite) {
            return InertiaError::NotFinite { triangle };
        }
        InertiaError::BadTriangle { triangle, line: first.map(|line| line + 1), reason }
    })
}
