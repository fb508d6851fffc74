//! The matrices of a linearized model as files of other programs: Matrix Market, PETSc and NumPy.
//!
//! Entries are the doubles nearest to the centres of their enclosures, in SI. Rows and columns are the coordinates in the order of the
//! model; under constraints, those that the others follow. Files are written entry by entry.

use librate_core::worded;
use std::io::{self, BufWriter, Write};

use librate_core::linearize::{Linearized, Units};
use librate_core::precision::{Ball, SparseMatrix};
use rawzip::ZipArchiveWriter;

/// The number with which a matrix in PETSc's binary format begins.
const PETSC_MATRIX: i32 = 1_211_216;

worded! {
/// What a matrix and its transpose have to do with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
Mirror {
    /// They are the same.
    Symmetric "symmetric",
    /// The one is the negative of the other.
    Skew "skew-symmetric",
    /// Neither.
    General "general",
}
/// The word of Matrix Market.
as_str
}

/// One of the matrices M, G, C, K and N, square, row by row, without the entries that are 0 exactly.
#[derive(Clone, Debug)]
pub struct Matrix {
    name: &'static str,
    mirror: Mirror,
    /// Where each row begins in `columns` and `values`; one more than there are rows.
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

/// M and K, and what there is of G, C and N.
///
/// # Errors
/// The first entry that is no double in SI, or loses digits as one: it is not finite, or closer to 0 than 2.2e-308.
pub fn matrices(linearized: &Linearized) -> Result<Vec<Matrix>, String> {
    let free = linearized.free_coordinates();
    let units = linearized.units();
    let n = free.len();
    let double = |matrix, by_rate: i64| {
        let (units, free) = (units, &free);
        move |i: usize, j: usize, entry: &Ball| {
            let in_si = |units: &Units| entry.scale_far(power(units, by_rate, free[i], free[j]));
            let value = units.map_or(*entry, in_si).mid_f64();
            let lost = value.abs() < f64::MIN_POSITIVE && !entry.contains_zero();
            let place = || format!("the entry of {matrix} in row {} and column {}", i + 1, j + 1);
            if value.is_finite() && !lost { Ok(value) } else { Err(place() + " is beyond the range of doubles") }
        }
    };
    let (mass, stiffness) = match linearized.sparse() {
        Some((mass, stiffness)) => {
            (Matrix::sparse("M", &mass, double("M", 2))?, Matrix::sparse("K", &stiffness, double("K", 0))?)
        }
        None => (
            Matrix::dense("M", Mirror::Symmetric, n, &linearized.mass(), double("M", 2))?,
            Matrix::dense("K", Mirror::Symmetric, n, &linearized.stiffness(), double("K", 0))?,
        ),
    };
    let mut all = vec![mass, stiffness];
    let others = [
        ("G", Mirror::Skew, 1, linearized.gyroscopic()),
        ("C", Mirror::Symmetric, 1, linearized.damping()),
        ("N", Mirror::General, 0, linearized.circulatory()),
    ];
    for (name, mirror, by_rate, entries) in others {
        let Some(entries) = entries else { continue };
        let matrix = Matrix::dense(name, mirror, n, &entries, double(name, by_rate))?;
        if matrix.stored() > 0 {
            all.push(matrix);
        }
    }
    Ok(all)
}

/// The power of two that brings an entry to SI, of a matrix that belongs to so many derivatives by the time.
fn power(units: &Units, by_rate: i64, i: usize, j: usize) -> i64 {
    units.energy() - by_rate * units.rate() - units.length(i) - units.length(j)
}

impl Matrix {
    /// From the lower triangle of a symmetric matrix.
    fn sparse(
        name: &'static str,
        lower: &SparseMatrix,
        double: impl Fn(usize, usize, &Ball) -> Result<f64, String>,
    ) -> Result<Self, String> {
        let n = lower.dimension();
        let mut next = vec![0_usize; n + 1];
        for (i, j, _) in lower.entries() {
            next[i + 1] += 1;
            next[j + 1] += usize::from(i != j);
        }
        for row in 0..n {
            next[row + 1] += next[row];
        }
        let starts = next.clone();
        let (mut columns, mut values) = (vec![0_u32; starts[n]], vec![0.0; starts[n]]);
        // Column by column: what is left of the diagonal of a row comes before its own column, which is what is right of it.
        for (i, j, entry) in lower.entries() {
            let value = double(i, j, entry)?;
            let mut put = |row: usize, column: usize| {
                columns[next[row]] = index(column);
                values[next[row]] = value;
                next[row] += 1;
            };
            put(i, j);
            if i != j {
                put(j, i);
            }
        }
        Ok(Self { name, mirror: Mirror::Symmetric, starts, columns, values })
    }

    /// From all entries, column by column; the matrix is written whole where it has no such mirror image to the last bit.
    fn dense(
        name: &'static str,
        mirror: Mirror,
        n: usize,
        entries: &[Ball],
        double: impl Fn(usize, usize, &Ball) -> Result<f64, String>,
    ) -> Result<Self, String> {
        let (mut columns, mut values, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        let mut holds = true;
        for i in 0..n {
            for j in 0..n {
                let entry = &entries[i + n * j];
                let other = entries[j + n * i].mid_f64();
                holds &= entry.mid_f64() == if mirror == Mirror::Skew { -other } else { other };
                if !entry.is_zero() {
                    columns.push(index(j));
                    values.push(double(i, j, entry)?);
                }
            }
            starts.push(values.len());
        }
        let mirror = if holds { mirror } else { Mirror::General };
        Ok(Self { name, mirror, starts, columns, values })
    }

    /// M, G, C, K or N.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// What the matrix and its transpose have to do with each other.
    #[must_use]
    pub fn mirror(&self) -> Mirror {
        self.mirror
    }

    /// The number of rows, which is that of the columns.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.starts.len() - 1
    }

    /// The number of entries, those on both sides of the diagonal.
    #[must_use]
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// Row, column and value of all entries, row by row.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        (0..self.dimension()).flat_map(move |i| {
            let own = self.starts[i]..self.starts[i + 1];
            self.columns[own.clone()].iter().zip(&self.values[own]).map(move |(j, value)| (i, *j as usize, *value))
        })
    }

    /// Writes the matrix in the coordinate format of Matrix Market: of a symmetric or skew matrix its lower triangle, numbers as the
    /// shortest decimals that read back to the same doubles. Comments are lines of their own.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_matrix_market(&self, comments: &[String], out: impl Write) -> io::Result<()> {
        let mut out = BufWriter::new(out);
        let shown = |i: usize, j: usize| match self.mirror {
            Mirror::Symmetric => j <= i,
            Mirror::Skew => j < i,
            Mirror::General => true,
        };
        writeln!(out, "%%MatrixMarket matrix coordinate real {}", self.mirror.as_str())?;
        for comment in comments {
            writeln!(out, "% {comment}")?;
        }
        let count = self.entries().filter(|(i, j, _)| shown(*i, *j)).count();
        writeln!(out, "{n} {n} {count}", n = self.dimension())?;
        for (i, j, value) in self.entries().filter(|(i, j, _)| shown(*i, *j)) {
            writeln!(out, "{} {} {value:?}", i + 1, j + 1)?;
        }
        out.flush()
    }

    /// Writes the matrix in PETSc's binary format for matrices by rows (AIJ): its number, rows, columns and entries, the lengths of the
    /// rows, the columns, all of 32 bits, then the values; the most significant byte first.
    ///
    /// # Errors
    /// Those of the writer, and more entries than 32 bits count.
    pub fn write_petsc(&self, out: impl Write) -> io::Result<()> {
        let mut out = BufWriter::new(out);
        let rows = signed(self.dimension())?;
        let entries = signed(self.stored())?;
        for word in [PETSC_MATRIX, rows, rows, entries] {
            out.write_all(&word.to_be_bytes())?;
        }
        for pair in self.starts.windows(2) {
            out.write_all(&signed(pair[1] - pair[0])?.to_be_bytes())?;
        }
        for column in &self.columns {
            out.write_all(&column.to_be_bytes())?;
        }
        for value in &self.values {
            out.write_all(&value.to_be_bytes())?;
        }
        out.flush()
    }
}

/// Writes matrices as an archive of NumPy, `.npz`, each as the four arrays of a matrix by rows: `M_data`, `M_indices`, `M_indptr` and
/// `M_shape`, for `scipy.sparse.csr_array((data, indices, indptr), shape)`.
///
/// # Errors
/// Those of the writer, and more entries than 32 bits count.
pub fn write_npz(matrices: &[Matrix], out: impl Write) -> io::Result<()> {
    let mut archive = ZipArchiveWriter::new(BufWriter::new(out));
    for matrix in matrices {
        let Matrix { name, starts, columns, values, .. } = matrix;
        signed(matrix.stored())?;
        let n = matrix.dimension() as u64;
        let starts = starts.iter().map(|start| index(*start).to_le_bytes());
        let columns = columns.iter().map(|column| column.to_le_bytes());
        let values = values.iter().map(|value| value.to_le_bytes());
        write_npy(&mut archive, &format!("{name}_data"), "<f8", values)?;
        write_npy(&mut archive, &format!("{name}_indices"), "<i4", columns)?;
        write_npy(&mut archive, &format!("{name}_indptr"), "<i4", starts)?;
        write_npy(&mut archive, &format!("{name}_shape"), "<i8", [n, n].iter().map(|count| count.to_le_bytes()))?;
    }
    archive.finish().map_err(io::Error::other)?.flush()
}

/// Adds an array of one index to an archive.
fn write_npy<const BYTES: usize>(
    archive: &mut ZipArchiveWriter<impl Write>,
    name: &str,
    kind: &str,
    numbers: impl ExactSizeIterator<Item = [u8; BYTES]>,
) -> io::Result<()> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({},), }}", numbers.len());
    // Ten bytes stand in front; the numbers begin at a multiple of 64, behind the end of a line.
    let padding = 63 - (10 + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', padding).chain(['\n']));
    let (mut entry, config) = archive.new_file(format!("{name}.npy")).start().map_err(io::Error::other)?;
    let mut out = BufWriter::new(config.wrap(&mut entry));
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&u16::try_from(header.len()).unwrap_or(u16::MAX).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    for number in numbers {
        out.write_all(&number)?;
    }
    let data = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    let (_, descriptor) = data.finish().map_err(io::Error::other)?;
    entry.finish(descriptor).map(drop).map_err(io::Error::other)
}

/// A number of 32 bits with a sign, which is what the formats have.
fn signed(count: usize) -> io::Result<i32> {
    let reason = "a matrix of more than 2147483647 entries does not fit into the format";
    i32::try_from(count).map_err(|_| io::Error::other(reason))
}

/// The number of a row; a model has fewer coordinates than 32 bits count.
fn index(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}
