//! A basis to start from where double-double has none: M = L Lᵀ at full precision, X = L⁻ᵀ, without
//! the zero vectors. Its couplings are anything but small; the improvement sees one cluster,
//! decomposes it in doubles, then what of it is below the rounding of doubles, and so on.

use dashu_int::IBig;
use dashu_int::ops::SquareRoot;

use super::data::Data;
use super::fixed::{Sum, dot, length, shifted};
use super::measure::Columns;

/// `None` if M has no Cholesky factor at this precision.
pub(super) fn start(data: &Data) -> Option<Columns> {
    let (n, p) = (data.n, data.scale);
    let factor = factor(data)?;
    // Columns of L⁻ᵀ: Lᵀ x = e_j, upwards from row j.
    let mut x: Vec<Vec<IBig>> = Vec::with_capacity(n);
    for j in 0..n {
        let mut column = vec![IBig::ZERO; n];
        for i in (0..=j).rev() {
            let mut rest = if i == j { IBig::ONE << (2 * p) as usize } else { IBig::ZERO };
            for k in i + 1..=j {
                if factor[k][i] != IBig::ZERO && column[k] != IBig::ZERO {
                    rest -= &factor[k][i] * &column[k];
                }
            }
            column[i] = rest / &factor[i][i];
        }
        x.push(column);
    }
    // Reflections take Lᵀz to an axis; the columns that remain are M-orthogonal to z.
    let mut sum = Sum::default();
    let zeros = data.zero.vectors.len();
    for at in 0..zeros {
        // Xᵀ M z in the columns that are left.
        let image = data.mass.times(&data.zero.vectors[at], &mut sum);
        let image: Vec<IBig> = image.iter().map(|y| shifted(y, -p)).collect();
        let mut v: Vec<IBig> = x[at..].iter().map(|x| shifted(&dot(x, &image, &mut sum), -p)).collect();
        let norm = root_of_squares(&v, &mut sum);
        if v[0] < IBig::ZERO {
            v[0] -= &norm;
        } else {
            v[0] += &norm;
        }
        let norm = root_of_squares(&v, &mut sum);
        if norm == IBig::ZERO {
            return None;
        }
        for v in &mut v {
            *v = (&*v << p as usize) / &norm;
        }
        // X <- X - 2 (X v) vᵀ
        for row in 0..n {
            let along = x[at..].iter().zip(&v).fold(IBig::ZERO, |sum, (x, v)| sum + &x[row] * v);
            let along = shifted(&along, 1 - p);
            for (x, v) in x[at..].iter_mut().zip(&v) {
                x[row] -= shifted(&(&along * v), -p);
            }
        }
    }
    let x = x.split_off(zeros);
    Some(Columns { scale: p, own: (0..x.len()).collect(), x })
}

fn root_of_squares(v: &[IBig], sum: &mut Sum) -> IBig {
    let (_, square) = dot(v, v, sum).into_parts();
    IBig::from(square.sqrt())
}

/// The Cholesky factor, row by row. A pivot has to keep half of the bits: what is below that is not
/// told from 0.
fn factor(data: &Data) -> Option<Vec<Vec<IBig>>> {
    let p = data.scale;
    let mut a = data.mass.lower();
    for k in 0..a.len() {
        if a[k][k] <= IBig::ZERO || 2 * (length(&a[k][k]) as i64) < p {
            return None;
        }
        let (_, pivot) = (&a[k][k] << p as usize).into_parts();
        let root = IBig::from(pivot.sqrt());
        let mut column = Vec::with_capacity(a.len() - k - 1);
        for row in &mut a[k + 1..] {
            row[k] = (&row[k] << p as usize) / &root;
            column.push(row[k].clone());
        }
        a[k][k] = root;
        for (i, row) in a[k + 1..].iter_mut().enumerate() {
            if column[i] == IBig::ZERO {
                continue;
            }
            for (j, other) in column[..=i].iter().enumerate() {
                if *other != IBig::ZERO {
                    row[k + 1 + j] -= shifted(&(&column[i] * other), -p);
                }
            }
        }
    }
    Some(a)
}
