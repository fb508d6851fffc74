//! Energies as quadratic forms: full matrices, and sums of squares of linear forms.

use dashu_ratio::RBig;

use super::Model;
use crate::draw::*;

/// Σ w_k/2 (row k · x)² as a matrix.
fn sum_of_squares(n: usize, weights: &[Number], rows: &[Vec<i64>]) -> Exact {
    let mut a = zeros(n);
    for (w, row) in weights.iter().zip(rows) {
        let g: Vec<(usize, RBig)> =
            row.iter().enumerate().filter(|(_, x)| **x != 0).map(|(j, x)| (j, RBig::from(*x))).collect();
        add_square(&mut a, &w.value, &g);
    }
    a
}

fn integers(rows: &[Vec<i64>]) -> Vec<Vec<Number>> {
    rows.iter().map(|row| row.iter().map(|x| Number::integer(*x)).collect()).collect()
}

/// T and V over forms B x and A x, each with its weights.
fn squares_of(b: &[Vec<i64>], masses: &[Number], a: &[Vec<i64>], springs: &[Number]) -> Model {
    let n = b.len();
    let count = a.len();
    let same = a == b;
    let mut text = format!("param n = {n}\n");
    text += &format!("param B[1..n, 1..n] = {}\n", matrix(&integers(b)));
    if !same {
        text += &format!("param A[1..{count}, 1..n] = {}\n", matrix(&integers(a)));
    }
    text += &family("m", masses);
    text += &family("w", springs);
    let name = if same { "B" } else { "A" };
    text += &format!(
        "coord x[1..n]
let q[k in 1..n] = sum(j in 1..n, B[k,j]*x[j])
T = sum(k in 1..n, 1/2*m[k]*q[k]'^2)
V = sum(k in 1..{count}, 1/2*w[k]*sum(j in 1..n, {name}[k,j]*x[j])^2)
"
    );
    Model::exact(text, sum_of_squares(n, masses, b), sum_of_squares(n, springs, a))
}

/// Equal eigenvalues of full matrices: the same forms in T and V, weights repeated.
pub(super) fn hidden(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(24);
    let b = draw.regular(n);
    let few = [draw.plain(), draw.plain(), draw.plain()];
    let springs: Vec<Number> = (0..n).map(|_| few[draw.size(0, 2)].clone()).collect();
    squares_of(&b, &vec![Number::integer(1); n], &b, &springs)
}

pub(super) fn squares(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(24);
    let (b, a) = (draw.regular(n), draw.regular(n));
    let (m, w) = (draw.plains(n), draw.plains(n));
    squares_of(&b, &m, &a, &w)
}

/// Weights of either sign.
pub(super) fn indefinite(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(24);
    let (b, a) = (draw.regular(n), draw.regular(n));
    let m = draw.plains(n);
    let w: Vec<Number> = (0..n).map(|_| draw.signed(2)).collect();
    squares_of(&b, &m, &a, &w)
}

/// Fewer springs than coordinates.
pub(super) fn few(draw: &mut Draw) -> Model {
    let n = draw.dimension().clamp(2, 16);
    let count = draw.size(1, n - 1);
    let b = draw.regular(n);
    let a: Vec<Vec<i64>> = draw.regular(n).into_iter().take(count).collect();
    let (m, w) = (draw.plains(n), draw.plains(count));
    squares_of(&b, &m, &a, &w)
}

/// Forms in T whose weights fade away.
pub(super) fn light(draw: &mut Draw) -> Model {
    let n = draw.dimension().clamp(2, 16);
    let (b, a) = (draw.regular(n), draw.regular(n));
    let mut m = draw.plains(n);
    let exponent = draw.int(-20, -4);
    let light = draw.size(0, n - 1);
    m[light] = draw.decimal(exponent);
    let w = draw.plains(n);
    squares_of(&b, &m, &a, &w)
}

/// Masses that are next to nothing on coordinates that share a heavy one.
pub(super) fn nearly_rigid(draw: &mut Draw) -> Model {
    let n = draw.dimension().max(2);
    let exponent = draw.int(-22, -6);
    let (m, e) = (draw.plain(), draw.decimal(exponent));
    let k = draw.plains(n);
    let mut mass = zeros(n);
    let all: Vec<(usize, RBig)> = (0..n).map(|j| (j, RBig::ONE)).collect();
    add_square(&mut mass, &m.value, &all);
    for (i, row) in mass.iter_mut().enumerate() {
        row[i] += &e.value;
    }
    let text = format!(
        "param n = {n}
param m = {}
param eps = {}
{}coord x[1..n]
T = 1/2*m*sum(i in 1..n, x[i]')^2 + 1/2*eps*sum(i in 1..n, x[i]'^2)
V = sum(i in 1..n, 1/2*k[i]*x[i]^2)
",
        m.text,
        e.text,
        family("k", &k)
    );
    Model::exact(text, mass, diagonal(&k))
}

/// Full M and K of small rationals.
pub(super) fn dense(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(30);
    // BᵀB/d with something added on the diagonal is positive; K is any symmetric matrix, or made alike.
    let positive = |draw: &mut Draw| -> Exact {
        let b = draw.regular(n);
        let d = RBig::from(draw.int(1, 7));
        let weights = vec![Number::integer(1); n];
        let mut a = sum_of_squares(n, &weights, &b);
        let more = draw.fraction().value;
        for (i, row) in a.iter_mut().enumerate() {
            row[i] += &more * &more;
            for x in row.iter_mut() {
                *x = &*x / &d;
            }
        }
        a
    };
    let mass = positive(draw);
    let stiffness = if draw.once_in(2) {
        positive(draw)
    } else {
        let mut a = zeros(n);
        for (i, j) in pairs(n, n).filter(|(i, j)| j <= i) {
            a[i][j] = draw.fraction().value;
            a[j][i] = a[i][j].clone();
        }
        a
    };
    let written = |a: &Exact| {
        let rows: Vec<Vec<Number>> =
            a.iter().map(|row| row.iter().map(|x| Number::exactly(x.clone())).collect()).collect();
        matrix(&rows)
    };
    let forms = [
        ("1/2*dot(x', A*x')", "1/2*dot(x, C*x)"),
        ("1/2*sum(i in 1..n, j in 1..n, A[i,j]*x[i]'*x[j]')", "1/2*sum(i in 1..n, j in 1..n, C[i,j]*x[i]*x[j])"),
        (
            "sum(i in 1..n, 1/2*A[i,i]*x[i]'^2 + sum(j in 1..i-1, A[i,j]*x[i]'*x[j]'))",
            "sum(i in 1..n, 1/2*C[i,i]*x[i]^2 + sum(j in 1..i-1, C[i,j]*x[i]*x[j]))",
        ),
    ];
    let (kinetic, potential) = draw.pick(&forms);
    let text = format!(
        "param n = {n}
param A[1..n, 1..n] = {}
param C[1..n, 1..n] = {}
coord x[1..n]
T = {kinetic}
V = {potential}
",
        written(&mass),
        written(&stiffness)
    );
    Model::exact(text, mass, stiffness)
}
