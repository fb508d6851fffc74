//! Vectors from elsewhere: an array of NumPy's in an archive, `.npz`.

use std::io::Read;

use rawzip::{CompressionMethod, ZipArchive};

/// The name that the array has in the archive.
const NAME: &str = "vectors";

/// Vectors of doubles, one a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Vectors {
    /// The number of components of each.
    pub dimension: usize,
    /// The number of vectors.
    pub count: usize,
    /// Column by column.
    pub components: Vec<f64>,
}

/// Reads the array `vectors` of an archive as `numpy.savez(file, vectors=x)` writes it: doubles, n by k for k vectors, in either order,
/// or n for a single one.
///
/// # Errors
/// What is wrong with the archive, in words.
pub fn read_vectors(archive: &[u8]) -> Result<Vectors, String> {
    let bad = |error: rawzip::Error| format!("it is no archive of NumPy's ({error})");
    let archive = ZipArchive::from_slice(archive).map_err(bad)?;
    let mut entries = archive.entries();
    let wanted = format!("{NAME}.npy");
    let entry = loop {
        match entries.next_entry().map_err(bad)? {
            Some(entry) if entry.file_path().as_ref() == wanted.as_bytes() => break entry,
            Some(_) => {}
            None => return Err(format!("it has no array `{NAME}`; write it with `numpy.savez(file, {NAME}=x)`")),
        }
    };
    if entry.compression_method() != CompressionMethod::STORE {
        return Err(format!("the array `{NAME}` is compressed; write it with `numpy.savez`, not `savez_compressed`"));
    }
    let file = archive.get_entry(entry.wayfinder()).map_err(bad)?;
    let mut bytes = Vec::new();
    let read = file.verifying_reader(file.data()).read_to_end(&mut bytes);
    read.map_err(|error| format!("the array `{NAME}` is damaged ({error})"))?;
    let broken = || format!("the array `{NAME}` is no array of NumPy's");
    let (header, data) = split(&bytes).ok_or_else(broken)?;
    let kind = field(header, "descr").ok_or_else(broken)?;
    let read: fn([u8; 8]) -> f64 = match kind.trim_matches(['\'', '"']) {
        "<f8" => f64::from_le_bytes,
        ">f8" => f64::from_be_bytes,
        other => return Err(format!("the array `{NAME}` has numbers of the kind {other}; doubles are needed")),
    };
    let by_columns = field(header, "fortran_order").ok_or_else(broken)? == "True";
    let (_, shape) = header.split_once("'shape': (").ok_or_else(broken)?;
    let (shape, _) = shape.split_once(')').ok_or_else(broken)?;
    let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
    let sizes: Vec<usize> = sizes.map(str::parse).collect::<Result<_, _>>().map_err(|_| broken())?;
    let (dimension, count) = match sizes.as_slice() {
        [n] => (*n, 1),
        [n, k] => (*n, *k),
        _ => return Err(format!("the array `{NAME}` has {} indices; one vector a column is needed", sizes.len())),
    };
    let (numbers, rest) = data.as_chunks::<8>();
    if dimension.checked_mul(count) != Some(numbers.len()) || !rest.is_empty() {
        return Err(broken());
    }
    let at = |place: usize| match by_columns {
        true => place,
        false => place % dimension * count + place / dimension,
    };
    let components = (0..numbers.len()).map(|place| read(numbers[at(place)])).collect();
    Ok(Vectors { dimension, count, components })
}

/// The header of an array and its numbers.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let rest = bytes.strip_prefix(b"\x93NUMPY")?;
    let (version, rest) = rest.split_at_checked(2)?;
    let width = if version[0] == 1 { 2 } else { 4 };
    let (length, rest) = rest.split_at_checked(width)?;
    let length = length.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
    let (header, data) = rest.split_at_checked(length)?;
    Some((std::str::from_utf8(header).ok()?, data))
}

/// What stands behind a key of a header, up to the next comma.
fn field<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{key}':"))?;
    Some(rest.split_once(',')?.0.trim())
}
