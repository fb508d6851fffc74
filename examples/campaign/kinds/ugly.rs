//! Small models with friction and rotation that go wrong: repeated and defective exponents, singular
//! matrices, cyclic and spherical coordinates, and all of it at scales far from 1.

use dashu_ratio::RBig;

use super::{Model, Reference};
use crate::draw::*;
use crate::exponents::Scaled;
use crate::pencil::Pencil;

fn whole(x: i64) -> RBig {
    RBig::from(x)
}

fn unit(n: usize) -> Exact {
    diagonal(&vec![Number::integer(1); n])
}

/// AᵀA for `rank` rows of small integers.
fn gram(draw: &mut Draw, n: usize, rank: usize) -> Exact {
    let mut a = zeros(n);
    for _ in 0..rank {
        let row: Vec<(usize, RBig)> = (0..n).map(|j| (j, whole(draw.int(-2, 2)))).collect();
        add_square(&mut a, &RBig::ONE, &row);
    }
    a
}

fn sum(a: &Exact, b: &Exact) -> Exact {
    let rows = a.iter().zip(b);
    rows.map(|(a, b)| a.iter().zip(b).map(|(x, y)| x + y).collect()).collect()
}

fn skew(draw: &mut Draw, n: usize) -> Exact {
    let mut a = zeros(n);
    for (i, j) in pairs(n, n).filter(|(i, j)| i < j) {
        let x = if draw.once_in(2) { draw.int(-2, 2) } else { 0 };
        (a[i][j], a[j][i]) = (whole(x), whole(-x));
    }
    a
}

/// The same in coordinates that are sums and differences of the old ones.
fn mixed(draw: &mut Draw, mut pencil: Pencil) -> Pencil {
    let n = pencil.mass.len();
    for _ in 0..draw.size(0, n) {
        let (to, from) = (draw.size(0, n - 1), draw.size(0, n - 1));
        let factor = whole(draw.pick(&[-1, 1, 2]));
        if to == from {
            continue;
        }
        for a in [&mut pencil.mass, &mut pencil.velocity, &mut pencil.position] {
            let row = a[from].clone();
            for (x, y) in a[to].iter_mut().zip(&row) {
                *x += &factor * y;
            }
            for row in a.iter_mut() {
                let y = row[from].clone();
                row[to] += &factor * y;
            }
        }
    }
    pencil
}

/// Oscillators of a few sorts, critical ones among them, perhaps with forces of one on the next.
pub(super) fn repeated(draw: &mut Draw) -> Pencil {
    let n = draw.size(1, 6);
    // q̈ + c q̇ + k q with roots -1, -1; -1, -2; 0, 0; 0, -1; ±i; ±1; complex; -2, -2; far apart.
    let sorts = [(2, 1), (3, 2), (0, 0), (1, 0), (0, 1), (0, -1), (1, 1), (4, 4), (1_000_000, 1)];
    let few: Vec<(i64, i64)> = (0..draw.size(1, 3)).map(|_| draw.pick(&sorts)).collect();
    let mut pencil = Pencil { mass: unit(n), velocity: zeros(n), position: zeros(n) };
    for i in 0..n {
        let (c, k) = draw.pick(&few);
        pencil.velocity[i][i] = whole(c);
        pencil.position[i][i] = whole(k);
    }
    if draw.once_in(3) {
        for (i, j) in pairs(n, n).filter(|(i, j)| i < j) {
            if draw.once_in(3) {
                pencil.position[i][j] = whole(draw.int(-1, 1));
            }
        }
    }
    mixed(draw, pencil)
}

/// No friction; rotation about what is bound, free and inverted.
pub(super) fn gyroscopic(draw: &mut Draw) -> Pencil {
    let n = draw.size(2, 6);
    let stiffness: Vec<Number> = (0..n).map(|_| Number::integer(draw.pick(&[-1, 0, 0, 1, 1, 4]))).collect();
    let mut pencil = Pencil { mass: unit(n), velocity: skew(draw, n), position: diagonal(&stiffness) };
    if draw.once_in(3) {
        pencil.mass = sum(&pencil.mass, &gram(draw, n, 1));
    }
    mixed(draw, pencil)
}

/// Neither friction nor rotation; forces of each on the others that go round, repeated exponents and four together.
pub(super) fn circulatory(draw: &mut Draw) -> Pencil {
    let drawn = gyroscopic(draw);
    Pencil { position: sum(&drawn.position, &drawn.velocity), velocity: zeros(drawn.mass.len()), mass: drawn.mass }
}

/// Friction and springs on fewer directions than there are.
pub(super) fn low_rank(draw: &mut Draw) -> Pencil {
    let n = draw.size(2, 7);
    let ranks = [(); 3].map(|()| draw.size(0, n));
    let mut pencil = Pencil {
        mass: sum(&unit(n), &gram(draw, n, ranks[0].min(2))),
        velocity: gram(draw, n, ranks[1]),
        position: gram(draw, n, ranks[2]),
    };
    if draw.once_in(3) {
        pencil.velocity = sum(&pencil.velocity, &skew(draw, n));
    }
    pencil
}

/// A bead in a central force going round on a circle, in spherical coordinates: V = k/p r^p.
pub(super) fn steady(draw: &mut Draw) -> Model {
    let power: i64 = draw.pick(&[-3, -2, -1, 1, 2, 4]);
    let (mass, radius, rate) = (draw.plain(), draw.plain(), draw.plain());
    let (m, r, w) = (&mass.value, &radius.value, &rate.value);
    let square = m * w * w;
    // The force balances: k r^(p-1) = m w² r.
    let spring = Number::exactly(&square * r.pow(2 - power as isize));
    let text = format!(
        "param m = {m}  param k = {k}
coord r, theta, phi
T = m/2*(r'^2 + r^2*theta'^2 + r^2*sin(theta)^2*phi'^2)
V = k/({power})*r^({power})
equilibrium r = {r}
equilibrium theta = pi/2
equilibrium phi' = {w}
",
        m = mass.text,
        k = spring.text,
        r = radius.text,
        w = rate.text,
    );
    let mut pencil = Pencil { mass: zeros(3), velocity: zeros(3), position: zeros(3) };
    pencil.mass[0][0] = m.clone();
    pencil.mass[1][1] = m * r * r;
    pencil.mass[2][2] = m * r * r;
    pencil.velocity[0][2] = whole(-2) * m * r * w;
    pencil.velocity[2][0] = whole(2) * m * r * w;
    pencil.position[0][0] = &square * whole(power - 2);
    pencil.position[1][1] = &square * r * r;
    Model::new(text, Reference::Exponents(Box::new(Scaled { pencil, lengths: vec![0; 3], rate: 0 })))
}

/// Any of them with an energy, a time and each coordinate in units that are far apart.
pub(super) fn scaled(draw: &mut Draw) -> Model {
    let drawings = [repeated, gyroscopic, circulatory, low_rank];
    let pencil = draw.pick(&drawings)(draw);
    let reach = draw.pick(&[3, 30, 60, 280, 280]);
    let mut length = || draw.int(-reach / 4, reach / 4);
    let lengths = pencil.mass.iter().map(|_| length()).collect();
    let rate = draw.int(-reach / 8, reach / 8);
    let energy = draw.int(-reach / 4, reach / 4);
    written(pencil, lengths, rate, energy)
}

pub(super) fn plain(pencil: Pencil) -> Model {
    let lengths = vec![0; pencil.mass.len()];
    written(pencil, lengths, 0, 0)
}

/// `+ (3/2)*1e-20*x[1]*x[2]'`, nothing for 0.
fn term(value: &RBig, exponent: i64, factors: &str) -> String {
    if *value == RBig::ZERO {
        return String::new();
    }
    let scale = if exponent == 0 { String::new() } else { format!("*1e{exponent}") };
    format!(" + ({value}){scale}*{factors}")
}

fn written(pencil: Pencil, lengths: Vec<i64>, rate: i64, energy: i64) -> Model {
    let n = pencil.mass.len();
    let half = RBig::ONE / whole(2);
    let [mut kinetic, mut potential, mut rotation, mut friction] = [const { String::new() }; 4];
    for (i, j) in pairs(n, n) {
        let of = |order: i64| lengths[i] + lengths[j] + energy + order * rate;
        let (x, y) = (format!("x[{}]", i + 1), format!("x[{}]", j + 1));
        let (s, b) = (&pencil.position, &pencil.velocity);
        kinetic += &term(&(&pencil.mass[i][j] * &half), of(0), &format!("{x}'*{y}'"));
        let symmetric = (&s[i][j] + &s[j][i]) * &half;
        potential += &term(&(symmetric * &half), of(2), &format!("{x}*{y}"));
        let circulatory = (&s[i][j] - &s[j][i]) * &half;
        friction += &term(&circulatory, of(2), &format!("{x}'*{y}"));
        let symmetric = (&b[i][j] + &b[j][i]) * &half;
        friction += &term(&(symmetric * &half), of(1), &format!("{x}'*{y}'"));
        // G_ij = -g for g/2 (x_i x_j' - x_j x_i').
        let g = (&b[j][i] - &b[i][j]) * &half * &half;
        rotation += &term(&g, of(1), &format!("{x}*{y}'"));
    }
    let friction = if friction.is_empty() { String::new() } else { format!("dissipation = 0{friction}\n") };
    let energies = if rotation.is_empty() {
        format!("T = 0{kinetic}\nV = 0{potential}\n")
    } else {
        format!("lagrangian = 0{kinetic}{rotation} - (0{potential})\n")
    };
    let text = format!("coord x[1..{n}]\n{energies}{friction}");
    Model::new(text, Reference::Exponents(Box::new(Scaled { pencil, lengths, rate })))
}
