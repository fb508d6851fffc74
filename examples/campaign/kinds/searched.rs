//! Models whose equilibrium is irrational and has to be searched for. The reference takes over which
//! one was found and pins it down by itself.

use super::plane::{add_block, each_twice};
use super::{Derivatives, Model, Reference};
use crate::draw::*;
use crate::real::*;
use crate::reference::{Square, to_reals};

fn searched(text: String, mass: Exact, derivatives: Box<Derivatives>) -> Model {
    Model::new(text, Reference::Searched(mass, derivatives))
}

/// Adds the spring force k d + β d³ and its derivative, d = x_i - x_j; no j: the ground.
fn spring(sums: (&mut [Real], &mut Square), [k, cubic]: [&Real; 2], x: &[Real], (i, j): (usize, Option<usize>)) {
    let d = j.map_or_else(|| x[i].clone(), |j| &x[i] - &x[j]);
    let square = &d * &d;
    let force = k * &d + cubic * &square * &d;
    let slope = k + (cubic * &square + cubic * &square + cubic * &square);
    add(sums, &force, &slope, (i, j));
}

/// Adds linear springs between neighbours.
fn coupled((gradient, hessian): (&mut [Real], &mut Square), k: &[Number], x: &[Real], bits: usize) {
    for (i, k) in k.iter().enumerate() {
        let k = real(&k.value, bits);
        add((gradient, hessian), &(&k * (&x[i + 1] - &x[i])), &k, (i + 1, Some(i)));
    }
}

/// Adds a force between two coordinates, or of the ground on one, and its derivative.
fn add((gradient, hessian): (&mut [Real], &mut Square), force: &Real, slope: &Real, (i, j): (usize, Option<usize>)) {
    gradient[i] += force;
    hessian[i][i] += slope;
    if let Some(j) = j {
        gradient[j] -= force;
        hessian[j][j] += slope;
        hessian[i][j] -= slope;
        hessian[j][i] -= slope;
    }
}

fn empty(n: usize, bits: usize) -> (Vec<Real>, Square) {
    (vec![integer(0, bits); n], to_reals(&zeros(n), bits))
}

/// Numbers alike, or over many decades.
fn some(draw: &mut Draw, count: usize) -> Vec<Number> {
    if draw.once_in(3) { draw.spread(count, 6) } else { draw.plains(count) }
}

/// Quartic wells with a force on them, coupled.
pub(super) fn wells(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(16);
    let (m, a, b, f, k) = (some(draw, n), draw.plains(n), draw.plains(n), draw.plains(n), some(draw, n - 1));
    let start: Vec<Number> = (0..n).map(|_| Number::integer(draw.pick(&[-1, 1, 2]))).collect();
    let mut text = format!("param n = {n}\n");
    let names = ["m", "a", "b", "f"];
    for (name, values) in names.iter().zip([&m, &a, &b, &f]) {
        text += &family(name, values);
    }
    let mut springs = String::new();
    if n > 1 {
        text += &family("k", &k);
        springs += "\n  + sum(i in 1..n-1, 1/2*k[i]*(x[i+1] - x[i])^2)";
    }
    text += &format!(
        "coord x[1..n]
T = sum(i in 1..n, 1/2*m[i]*x[i]'^2)
V = sum(i in 1..n, 1/4*a[i]*x[i]^4 - 1/2*b[i]*x[i]^2 - f[i]*x[i]){springs}
guess x = {}
",
        list(&start)
    );
    let derivatives = move |x: &[Real], bits: usize| {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        for i in 0..x.len() {
            let [a, b, f] = [&a, &b, &f].map(|v| real(&v[i].value, bits));
            spring((&mut gradient, &mut hessian), [&-b, &a], x, (i, None));
            gradient[i] -= f;
        }
        coupled((&mut gradient, &mut hessian), &k, x, bits);
        (gradient, hessian)
    };
    searched(text, diagonal(&m), Box::new(derivatives))
}

/// Masses on hardening springs under each other.
pub(super) fn hanging(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(20);
    let (m, k, b) = (draw.plains(n), some(draw, n), some(draw, n));
    let text = format!(
        "param n = {n}
param g = 9.81
{}{}{}coord x[1..n]
let d[1] = x[1]
let d[i in 2..n] = x[i] - x[i-1]
T = sum(i in 1..n, 1/2*m[i]*x[i]'^2)
V = sum(i in 1..n, 1/2*k[i]*d[i]^2 + 1/4*b[i]*d[i]^4 - m[i]*g*x[i])
",
        family("m", &m),
        family("k", &k),
        family("b", &b),
    );
    let mass = diagonal(&m);
    let derivatives = move |x: &[Real], bits: usize| {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let g = real(&Number::scaled(981, -2).value, bits);
        for i in 0..x.len() {
            let [m, k, b] = [&m, &k, &b].map(|v| real(&v[i].value, bits));
            spring((&mut gradient, &mut hessian), [&k, &b], x, (i, i.checked_sub(1)));
            gradient[i] -= m * &g;
        }
        (gradient, hessian)
    };
    searched(text, mass, Box::new(derivatives))
}

/// Charges in a trap.
pub(super) fn ions(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(10);
    let m = some(draw, n);
    let q: Vec<Number> = (0..n).map(|_| draw.decimal(0)).collect();
    let k = draw.plain();
    let text = format!(
        "param N = {n}
param k = {}
{}{}coord x[1..N]
T = sum(i in 1..N, 1/2*m[i]*x[i]'^2)
V = sum(i in 1..N, 1/2*k*x[i]^2) + sum(i in 1..N, j in i+1..N, q[i]*q[j]/(x[j] - x[i]))
guess x[i in 1..N] = i - (N + 1)/2
",
        k.text,
        family("m", &m),
        family("q", &q),
    );
    let derivatives = move |x: &[Real], bits: usize| {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let k = real(&k.value, bits);
        for i in 0..x.len() {
            gradient[i] += &k * &x[i];
            hessian[i][i] += &k;
            for j in i + 1..x.len() {
                let charges = real(&(&q[i].value * &q[j].value), bits);
                let d = &x[j] - &x[i];
                let force = charges / (&d * &d);
                let slope = integer(2, bits) * &force / &d;
                add((&mut gradient, &mut hessian), &force, &slope, (i, Some(j)));
            }
        }
        (gradient, hessian)
    };
    searched(text, diagonal(&m), Box::new(derivatives))
}

/// Pendulums that torsion springs pull aside.
pub(super) fn torsion(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(16);
    let (m, l, k) = (some(draw, n), draw.plains(n), some(draw, n));
    let a: Vec<Number> = (0..n).map(|_| Number::scaled(draw.int(1, 200), -2)).collect();
    let c = some(draw, n - 1);
    let mut text = format!("param n = {n}\nparam g = 9.81\n");
    text += &family("m", &m);
    text += &family("l", &l);
    text += &family("k", &k);
    text += &family("a", &a);
    let mut coupling = String::new();
    if n > 1 {
        text += &family("c", &c);
        coupling += "\n  + sum(i in 2..n, 1/2*c[i-1]*(phi[i] - phi[i-1])^2)";
    }
    text += &format!(
        "coord phi[1..n]
T = sum(i in 1..n, 1/2*m[i]*l[i]^2*phi[i]'^2)
V = sum(i in 1..n, 1/2*k[i]*(phi[i] - a[i])^2 - m[i]*g*l[i]*cos(phi[i])){coupling}
"
    );
    let inertia = |(m, l): (&Number, &Number)| Number::exactly(&m.value * &l.value * &l.value);
    let all: Vec<Number> = m.iter().zip(&l).map(inertia).collect();
    let derivatives = move |x: &[Real], bits: usize| {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let g = real(&Number::scaled(981, -2).value, bits);
        for i in 0..x.len() {
            let [m, l, k, a] = [&m, &l, &k, &a].map(|v| real(&v[i].value, bits));
            let weight = m * l * &g;
            let (sin, cos) = sin_cos(&x[i], bits);
            gradient[i] += &k * (&x[i] - a) + &weight * sin;
            hessian[i][i] += k + weight * cos;
        }
        coupled((&mut gradient, &mut hessian), &c, x, bits);
        (gradient, hessian)
    };
    searched(text, diagonal(&all), Box::new(derivatives))
}

/// Beads on elastic strings between two hooks, sagging.
pub(super) fn sagging(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(16).div_ceil(2);
    let stiff = draw.int(1, 4);
    let m = draw.plains(n);
    let k: Vec<Number> = (0..=n).map(|_| draw.decimal(stiff)).collect();
    let (a, width) = (Number::scaled(draw.int(50, 120), -2), Number::integer(n as i64 + 1));
    let text = format!(
        "param n = {n}
param g = 9.81
param a = {}
param D = {}
{}{}coord r[1..n, 1..2]
let P[0] = [0, 0]
let P[i in 1..n] = r[i]
let P[n+1] = [D, 0]
T = sum(i in 1..n, 1/2*m[i]*dot(r[i]', r[i]'))
V = sum(i in 1..n, m[i]*g*r[i,2]) + sum(i in 1..n+1, 1/2*k[i]*(norm(P[i] - P[i-1]) - a)^2)
guess r[i in 1..n] = [i*D/(n + 1), -1]
",
        a.text,
        width.text,
        family("m", &m),
        family("k", &k),
    );
    let mass = each_twice(&m);
    let derivatives = move |x: &[Real], bits: usize| {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let g = real(&Number::scaled(981, -2).value, bits);
        for (i, m) in m.iter().enumerate() {
            gradient[2 * i + 1] += real(&m.value, bits) * &g;
        }
        let a = real(&a.value, bits);
        for (i, k) in k.iter().enumerate() {
            let k = real(&k.value, bits);
            let end = |i: Option<usize>| match i {
                Some(i) if i < n => [x[2 * i].clone(), x[2 * i + 1].clone()],
                Some(_) => [real(&width.value, bits), integer(0, bits)],
                None => [integer(0, bits), integer(0, bits)],
            };
            let (from, to) = (i.checked_sub(1), Some(i));
            let (start, stop) = (end(from), end(to));
            let d = [&stop[0] - &start[0], &stop[1] - &start[1]];
            let length = sqrt(&(&d[0] * &d[0] + &d[1] * &d[1]));
            let pull = &k * (&length - &a) / &length;
            let rest = &k * &a / (&length * &length * &length);
            for p in 0..2 {
                let force = &pull * &d[p];
                if i < n {
                    gradient[2 * i + p] += &force;
                }
                if let Some(from) = from {
                    gradient[2 * from + p] -= &force;
                }
            }
            let mut slopes = [0, 1].map(|p| [0, 1].map(|q| &rest * &d[p] * &d[q]));
            slopes[0][0] += &pull;
            slopes[1][1] += &pull;
            let (own, other) = ends(i, n);
            add_block(&mut hessian, &slopes, own, other);
        }
        (gradient, hessian)
    };
    searched(text, mass, Box::new(derivatives))
}
