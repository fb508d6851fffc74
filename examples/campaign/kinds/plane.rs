//! Points in a plane held by springs V = k/2 (|d| - a)², slack or under tension, and chains of links.
//!
//! A spring of length L in the direction e that pulls with the force τ has the second derivatives
//! k eeᵀ + τ/L (1 - eeᵀ).

use std::fmt::Write as _;

use dashu_ratio::RBig;

use super::{Model, Reference};
use crate::draw::*;
use crate::real::*;
use crate::reference::{Matrices, Square, to_reals};

/// Horizontal and vertical strings under tension, crossing at points.
pub(super) fn net(draw: &mut Draw) -> Model {
    let (rows, columns) =
        if draw.once_in(6) { (draw.size(2, 4), draw.size(2, 5)) } else { (draw.size(1, 2), draw.size(1, 3)) };
    let n = rows * columns;
    let (s, t) = (draw.plains(columns + 1), draw.plains(rows + 1));
    let tau: Vec<Number> = (0..rows).map(|_| draw.signed(5)).collect();
    let sigma: Vec<Number> = (0..columns).map(|_| draw.signed(5)).collect();
    let stiff = draw.int(0, 6);
    let (k, c, m) = (draw.decimal(stiff), draw.plain(), draw.plain());
    let mut stiffness = zeros(2 * n);
    let u = |i: usize, j: usize| i * columns + j;
    for (i, j) in pairs(rows, columns + 1) {
        let across = &tau[i].value / &s[j].value;
        let (own, other) = ends(j, columns);
        let (own, other) = (u(i, own), other.map(|j| u(i, j)));
        add_spring(&mut stiffness, &k.value, own, other);
        add_spring(&mut stiffness, &across, own + n, other.map(|o| o + n));
    }
    for (i, j) in pairs(rows + 1, columns) {
        let across = &sigma[j].value / &t[i].value;
        let (own, other) = ends(i, rows);
        let (own, other) = (u(own, j), other.map(|i| u(i, j)));
        add_spring(&mut stiffness, &across, own, other);
        add_spring(&mut stiffness, &c.value, own + n, other.map(|o| o + n));
    }
    let text = format!(
        "param R = {rows}  param C = {columns}
param m = {}  param k = {}  param c = {}
{}{}{}{}let X[0] = 0
let X[j in 1..C+1] = X[j-1] + s[j]
let Y[0] = 0
let Y[i in 1..R+1] = Y[i-1] + h[i]
coord u[1..R, 1..C], v[1..R, 1..C]
let p[i in 1..R, j in 1..C] = [X[j] + u[i,j], Y[i] + v[i,j]]
let p[i in 1..R, j in 0..C+1 where j == 0 or j == C+1] = [X[j], Y[i]]
let p[i in 0..R+1, j in 1..C where i == 0 or i == R+1] = [X[j], Y[i]]
T = sum(i in 1..R, j in 1..C, 1/2*m*(u[i,j]'^2 + v[i,j]'^2))
V = sum(i in 1..R, j in 1..C+1, 1/2*k*(norm(p[i,j] - p[i,j-1]) - (s[j] - tau[i]/k))^2)
  + sum(i in 1..R+1, j in 1..C, 1/2*c*(norm(p[i,j] - p[i-1,j]) - (h[i] - sigma[j]/c))^2)
",
        m.text,
        k.text,
        c.text,
        family("s", &s),
        family("h", &t),
        family("tau", &tau),
        family("sigma", &sigma),
    );
    Model::exact(text, diagonal(&vec![m; 2 * n]), stiffness)
}

/// Adds the block of one spring between two points of the plane, or a point and the wall.
pub(super) fn add_block(a: &mut Square, block: &[[Real; 2]; 2], i: usize, j: Option<usize>) {
    for p in 0..2 {
        for q in 0..2 {
            a[2 * i + p][2 * i + q] += &block[p][q];
            if let Some(j) = j {
                a[2 * j + p][2 * j + q] += &block[p][q];
                a[2 * i + p][2 * j + q] -= &block[p][q];
                a[2 * j + p][2 * i + q] -= &block[p][q];
            }
        }
    }
}

/// along·eeᵀ + across·(1 - eeᵀ)
fn block(along: &Real, across: &Real, e: &[Real; 2]) -> [[Real; 2]; 2] {
    let entry = |p: usize, q: usize| {
        let both = (along - across) * &e[p] * &e[q];
        if p == q { both + across } else { both }
    };
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

pub(super) fn each_twice(m: &[Number]) -> Exact {
    diagonal(m.iter().flat_map(|m| [m, m]))
}

/// A string under tension in a direction whose steps have irrational lengths.
pub(super) fn string(draw: &mut Draw) -> Model {
    let n = draw.dimension().div_ceil(2);
    let (p, q) = (draw.int(1, 5), draw.int(-5, 5));
    let m = draw.plains(n);
    let (t, k) = (draw.plains(n + 1), draw.spread(n + 1, 5));
    let tau = draw.signed(6);
    let text = format!(
        "param n = {n}  param p = {p}  param q = {q}
param tau = {}
{}{}{}param a[i in 1..n+1] = s[i]*sqrt(p^2 + q^2) - tau/k[i]
param X[i in 1..n+1] = sum(j in 1..i, s[j])
coord r[1..n, 1..2]
let P[0] = [0, 0]
let P[i in 1..n] = r[i]
let P[n+1] = X[n+1]*[p, q]
T = sum(i in 1..n, 1/2*m[i]*dot(r[i]', r[i]'))
V = sum(i in 1..n+1, 1/2*k[i]*(norm(P[i] - P[i-1]) - a[i])^2)
equilibrium r[i in 1..n] = [p*X[i], q*X[i]]
",
        tau.text,
        family("m", &m),
        family("s", &t),
        family("k", &k),
    );
    let matrices = move |bits: usize| {
        let unit = sqrt(&integer(p * p + q * q, bits));
        let e = [integer(p, bits) / &unit, integer(q, bits) / &unit];
        let mut stiffness = to_reals(&zeros(2 * n), bits);
        for i in 0..=n {
            let length = real(&t[i].value, bits) * &unit;
            let across = real(&tau.value, bits) / length;
            let block = block(&real(&k[i].value, bits), &across, &e);
            let (own, other) = ends(i, n);
            add_block(&mut stiffness, &block, own, other);
        }
        Matrices { mass: to_reals(&each_twice(&m), bits), stiffness }
    };
    Model::new(text, Reference::Real(Box::new(matrices)))
}

/// Beads on stiff springs under each other: the upper ones carry the lower ones.
pub(super) fn hanging(draw: &mut Draw) -> Model {
    let n = draw.dimension().div_ceil(2);
    let (m, l) = (draw.plains(n), draw.plains(n));
    let stiff = draw.int(1, 12);
    let k: Vec<Number> = (0..n).map(|_| draw.decimal(stiff)).collect();
    let g = Number::scaled(981, -2);
    let mut stiffness = zeros(2 * n);
    let mut weight = RBig::ZERO;
    for i in (0..n).rev() {
        weight += &g.value * &m[i].value;
        let across = &weight / &l[i].value;
        let (x, above) = (2 * i, i.checked_sub(1).map(|a| 2 * a));
        add_spring(&mut stiffness, &across, x, above);
        add_spring(&mut stiffness, &k[i].value, x + 1, above.map(|a| a + 1));
    }
    let text = format!(
        "param n = {n}
param g = {}
{}{}{}param W[i in 1..n] = g*sum(j in i..n, m[j])
coord r[1..n, 1..2]
let P[0] = [0, 0]
let P[i in 1..n] = r[i]
T = sum(i in 1..n, 1/2*m[i]*dot(r[i]', r[i]'))
V = sum(i in 1..n, m[i]*g*r[i,2] + 1/2*k[i]*(norm(P[i] - P[i-1]) - (l[i] - W[i]/k[i]))^2)
equilibrium r[i in 1..n] = [0, -sum(j in 1..i, l[j])]
",
        g.text,
        family("m", &m),
        family("l", &l),
        family("k", &k),
    );
    Model::exact(text, each_twice(&m), stiffness)
}

/// A rim under tension on spokes that push: it can turn about its hub.
pub(super) fn wheel(draw: &mut Draw) -> Model {
    let n = draw.dimension().div_ceil(2).max(3);
    let (m, k, c, radius) = (draw.plain(), draw.plain(), draw.plain(), draw.plain());
    let tau = draw.signed(3);
    let text = format!(
        "param N = {n}
param m = {}  param k = {}  param c = {}  param R = {}  param tau = {}
param chord = 2*R*sin(pi/N)
param spoke = R + 2*tau*sin(pi/N)/c
coord r[1..N, 1..2]
T = sum(i in 1..N, 1/2*m*dot(r[i]', r[i]'))
V = sum(i in 1..N, 1/2*k*(norm(r[mod(i, N) + 1] - r[i]) - (chord - tau/k))^2)
  + sum(i in 1..N, 1/2*c*(norm(r[i]) - spoke)^2)
equilibrium r[i in 1..N] = [R*cos(2*pi*i/N), R*sin(2*pi*i/N)]
",
        m.text, k.text, c.text, radius.text, tau.text
    );
    let matrices = move |bits: usize| {
        let [m, k, c, radius, tau] = [&m, &k, &c, &radius, &tau].map(|x| real(&x.value, bits));
        let half = pi(bits) / integer(n as i64, bits);
        let (sine, _) = sin_cos(&half, bits);
        let chord = integer(2, bits) * &radius * &sine;
        let push = -(integer(2, bits) * &tau * &sine);
        let mut stiffness = to_reals(&zeros(2 * n), bits);
        for i in 0..n {
            let at = |steps: i64| sin_cos(&(&half * integer(steps, bits)), bits);
            // Point i + 1 of the text stands at the angle 2π(i + 1)/N; its chord leads to the next one.
            let (sin, cos) = at(2 * i as i64 + 2);
            let spoke = block(&c, &(&push / &radius), &[cos, sin]);
            add_block(&mut stiffness, &spoke, i, None);
            let (sin, cos) = at(2 * i as i64 + 3);
            let rim = block(&k, &(&tau / &chord), &[-sin, cos]);
            add_block(&mut stiffness, &rim, i, Some((i + 1) % n));
        }
        let mut mass = to_reals(&zeros(2 * n), bits);
        for (i, row) in mass.iter_mut().enumerate() {
            row[i] = m.clone();
        }
        Matrices { mass, stiffness }
    };
    Model::new(text, Reference::Real(Box::new(matrices)))
}

/// A chain of links by its angles, some of them standing on end.
fn linked(draw: &mut Draw, standing: bool) -> Model {
    let n = draw.dimension().min(16);
    let (m, l) = (draw.plains(n), draw.plains(n));
    let g = Number::scaled(981, -2);
    let up: Vec<bool> = (0..n).map(|_| standing && draw.once_in(2)).collect();
    let cos = |i: usize| RBig::from(if up[i] { -1 } else { 1 });
    let (mut mass, mut stiffness) = (zeros(n), zeros(n));
    for i in 0..n {
        let below = |from: usize| m[from..].iter().fold(RBig::ZERO, |s, m| s + &m.value);
        for j in 0..n {
            mass[i][j] = below(i.max(j)) * &l[i].value * &l[j].value * cos(i) * cos(j);
        }
        stiffness[i][i] = &g.value * &l[i].value * below(i) * cos(i);
    }
    let mut text = format!(
        "param N = {n}
param g = {}
{}{}coord theta[1..N]
let x[0] = 0
let y[0] = 0
let x[k in 1..N] = x[k-1] + l[k]*sin(theta[k])
let y[k in 1..N] = y[k-1] - l[k]*cos(theta[k])
T = sum(k in 1..N, 1/2*m[k]*(x[k]'^2 + y[k]'^2))
V = sum(k in 1..N, m[k]*g*y[k])
",
        g.text,
        family("m", &m),
        family("l", &l),
    );
    for (i, up) in up.iter().enumerate() {
        if *up {
            let _ = writeln!(text, "equilibrium theta[{}] = pi", i + 1);
        }
    }
    Model::exact(text, mass, stiffness)
}

pub(super) fn links(draw: &mut Draw) -> Model {
    linked(draw, true)
}

pub(super) fn hanging_links(draw: &mut Draw) -> Model {
    linked(draw, false)
}

/// Slack springs between points that nothing holds; perhaps too few to make them rigid.
pub(super) fn network(draw: &mut Draw) -> Model {
    let count = draw.dimension().div_ceil(2).max(2);
    let mut places: Vec<[Number; 2]> = Vec::new();
    while places.len() < count {
        let mut component = || {
            let x = draw.int(-99, 99);
            Number::scaled(x, 0 - i64::from(x >= 0))
        };
        let place = [component(), component()];
        let new = places.iter().all(|p| p[0].value != place[0].value || p[1].value != place[1].value);
        if new {
            places.push(place);
        }
    }
    let mut pairs: Vec<(usize, usize)> = (1..count).map(|i| (draw.size(0, i - 1), i)).collect();
    for _ in 0..draw.size(0, 2 * count) {
        let (i, j) = (draw.size(0, count - 1), draw.size(0, count - 1));
        let pair = (i.min(j), i.max(j));
        if i != j && !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    let m = draw.plains(count);
    let k = draw.spread(pairs.len(), 3);
    let mut points = "x,y,mass\n".to_owned();
    for (place, m) in places.iter().zip(&m) {
        let _ = writeln!(points, "{},{},{}", place[0].text, place[1].text, m.text);
    }
    let m: Vec<Number> = (0..count).map(|i| m[i].clone()).collect();
    let mut bonds = "i,j,k\n".to_owned();
    let mut stiffness = zeros(2 * count);
    for ((i, j), k) in pairs.iter().zip(&k) {
        let _ = writeln!(bonds, "{},{},{}", i + 1, j + 1, k.text);
        let d = [0, 1].map(|p| &places[*j][p].value - &places[*i][p].value);
        let square = &d[0] * &d[0] + &d[1] * &d[1];
        let g: Vec<(usize, RBig)> =
            (0..2).flat_map(|p| [(2 * j + p, d[p].clone()), (2 * i + p, -d[p].clone())]).collect();
        add_square(&mut stiffness, &(&k.value / square), &g);
    }
    let text = "table points = \"points.csv\"
table bonds = \"bonds.csv\"
coord r[1..rows(points), 1..2]
let rest[a in points] = [a.x, a.y]
T = sum(a in points, 1/2*a.mass*dot(r[a]', r[a]'))
V = sum(b in bonds, 1/2*b.k*(norm(r[b.j] - r[b.i]) - norm(rest[b.j] - rest[b.i]))^2)
equilibrium r[a in points] = [a.x, a.y]
";
    Model::exact(text.to_owned(), each_twice(&m), stiffness)
        .with_table("points.csv", points)
        .with_table("bonds.csv", bonds)
}
