//! Rings and lattices of equal parts: eigenvalues that are repeated exactly.

use dashu_ratio::RBig;

use super::Model;
use crate::draw::*;

/// m on every diagonal place.
fn equal(n: usize, m: &Number) -> Exact {
    diagonal(&vec![m.clone(); n])
}

fn round(draw: &mut Draw, held: bool) -> Model {
    let n = draw.dimension().max(3);
    let (m, k, ground) = (draw.plain(), draw.plain(), draw.plain());
    let mut stiffness = zeros(n);
    for i in 0..n {
        add_spring(&mut stiffness, &k.value, i, Some((i + 1) % n));
        if held {
            add_spring(&mut stiffness, &ground.value, i, None);
        }
    }
    let walls = if held { format!(" + sum(i in 1..N, {}/2*x[i]^2)", ground.text) } else { String::new() };
    let text = format!(
        "model ring
param N = {n}
param m = {}
param k = {}
coord x[1..N]
T = 1/2*m*sum(i in 1..N, x[i]'^2)
V = 1/2*k*sum(i in 1..N, (x[mod(i, N) + 1] - x[i])^2){walls}
",
        m.text, k.text
    );
    Model::exact(text, equal(n, &m), stiffness)
}

pub(super) fn ring(draw: &mut Draw) -> Model {
    round(draw, true)
}

pub(super) fn free_ring(draw: &mut Draw) -> Model {
    round(draw, false)
}

/// A square net between walls: the modes (p, q) and (q, p) have one frequency.
pub(super) fn square(draw: &mut Draw) -> Model {
    let side = if draw.once_in(4) { draw.size(4, 6) } else { draw.size(2, 3) };
    let (m, k) = (draw.plain(), draw.plain());
    let mut stiffness = zeros(side * side);
    let at = |i: usize, j: usize| i * side + j;
    for i in 0..side {
        for j in 0..side {
            for (a, next) in [(i, (i + 1, j)), (j, (i, j + 1))] {
                if a == 0 {
                    add_spring(&mut stiffness, &k.value, at(i, j), None);
                }
                let beyond = next.0 == side || next.1 == side;
                let to = (!beyond).then(|| at(next.0, next.1));
                add_spring(&mut stiffness, &k.value, at(i, j), to);
            }
        }
    }
    let text = format!(
        "param N = {side}
param k = {}
coord z[1..N, 1..N]
let u[i in 0..N+1, j in 0..N+1 where i == 0 or i == N+1 or j == 0 or j == N+1] = 0
let u[i in 1..N, j in 1..N] = z[i,j]
T = sum(i in 1..N, j in 1..N, {}/2*z[i,j]'^2)
V = sum(i in 0..N, j in 1..N, 1/2*k*((u[i+1,j] - u[i,j])^2 + (u[j,i+1] - u[j,i])^2))
",
        k.text, m.text
    );
    Model::exact(text, equal(side * side, &m), stiffness)
}

/// A lattice closed in both directions, free or held.
pub(super) fn torus(draw: &mut Draw) -> Model {
    let (p, q) = if draw.once_in(5) { (draw.size(4, 8), draw.size(3, 5)) } else { (draw.size(3, 4), 3) };
    let (m, k, c) = (draw.plain(), draw.plain(), draw.plain());
    let ground = if draw.once_in(3) { Number::integer(0) } else { draw.plain() };
    let n = p * q;
    let mut stiffness = zeros(n);
    for i in 0..p {
        for j in 0..q {
            let own = i * q + j;
            add_spring(&mut stiffness, &k.value, own, Some((i + 1) % p * q + j));
            add_spring(&mut stiffness, &c.value, own, Some(i * q + (j + 1) % q));
            add_spring(&mut stiffness, &ground.value, own, None);
        }
    }
    let text = format!(
        "param P = {p}  param Q = {q}
param m = {}  param k = {}  param c = {}  param f = {}
coord z[1..P, 1..Q]
T = sum(i in 1..P, j in 1..Q, 1/2*m*z[i,j]'^2)
V = sum(i in 1..P, j in 1..Q,
        1/2*k*(z[mod(i, P) + 1, j] - z[i,j])^2 + 1/2*c*(z[i, mod(j, Q) + 1] - z[i,j])^2
      + 1/2*f*z[i,j]^2)
",
        m.text, k.text, c.text, ground.text
    );
    Model::exact(text, equal(n, &m), stiffness)
}

/// Equal pendulums, or equal pairs of them, that know nothing of each other.
pub(super) fn uncoupled(draw: &mut Draw) -> Model {
    let n = draw.dimension().max(2);
    let (m, l) = (draw.plain(), draw.plain());
    if draw.once_in(2) {
        let mass = Number::exactly(&m.value * &l.value * &l.value);
        let stiffness = Number::exactly(RBig::from(10) * &m.value * &l.value);
        let text = format!(
            "param g = 10  param m = {}  param l = {}
coord phi[1..{n}]
T = sum(i in 1..{n}, 1/2*m*l^2*phi[i]'^2)
V = -sum(i in 1..{n}, m*g*l*cos(phi[i]))
",
            m.text, l.text
        );
        return Model::exact(text, equal(n, &mass), equal(n, &stiffness));
    }
    let pairs = n.div_ceil(2);
    let c = draw.plain();
    let mut stiffness = zeros(2 * pairs);
    for a in 0..pairs {
        add_spring(&mut stiffness, &l.value, 2 * a, None);
        add_spring(&mut stiffness, &c.value, 2 * a, Some(2 * a + 1));
    }
    let text = format!(
        "coord x[1..{pairs}, 1..2]
T = sum(a in 1..{pairs}, {}/2*dot(x[a]', x[a]'))
V = sum(a in 1..{pairs}, {}/2*x[a,1]^2 + {}/2*(x[a,2] - x[a,1])^2)
",
        m.text, l.text, c.text
    );
    Model::exact(text, equal(2 * pairs, &m), stiffness)
}

/// Everyone with everyone: n - 1 equal frequencies beside one.
pub(super) fn complete(draw: &mut Draw) -> Model {
    let n = draw.dimension().max(2);
    let (m, k, ground) = (draw.plain(), draw.plain(), draw.plain());
    let mut stiffness = zeros(n);
    for i in 0..n {
        add_spring(&mut stiffness, &ground.value, i, None);
        for j in i + 1..n {
            add_spring(&mut stiffness, &k.value, i, Some(j));
        }
    }
    let text = format!(
        "param N = {n}
param m = {}  param k = {}  param f = {}
coord x[1..N]
T = sum(i in 1..N, 1/2*m*x[i]'^2)
V = sum(i in 1..N, j in i+1..N, 1/2*k*(x[i] - x[j])^2) + 1/2*f*dot(x, x)
",
        m.text, k.text, ground.text
    );
    Model::exact(text, equal(n, &m), stiffness)
}
