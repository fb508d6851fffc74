//! Chains and networks of masses on a line, and pendulums: everything rational.

use std::fmt::Write as _;

use dashu_ratio::RBig;

use super::Model;
use crate::draw::*;

/// The text of a chain between walls with masses m and springs k, and its matrices.
fn chain(head: String, m: &[Number], k: &[Number]) -> Model {
    let n = m.len();
    let text = format!(
        "{head}coord x[1..{n}]
let u[0] = 0
let u[i in 1..{n}] = x[i]
let u[{last}] = 0
T = sum(i in 1..{n}, 1/2*m[i]*x[i]'^2)
V = sum(i in 1..{last}, 1/2*k[i]*(u[i] - u[i-1])^2)
",
        last = n + 1
    );
    Model::exact(text, diagonal(m), chain_stiffness(n, k))
}

fn chain_stiffness(n: usize, k: &[Number]) -> Exact {
    let mut stiffness = zeros(n);
    for (i, k) in k.iter().enumerate() {
        let (own, other) = ends(i, n);
        add_spring(&mut stiffness, &k.value, own, other);
    }
    stiffness
}

pub(super) fn graded(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let (m, k) = (draw.spread(n, 8), draw.spread(n + 1, 12));
    chain(family("m", &m) + &family("k", &k), &m, &k)
}

/// Masses and springs by formula.
pub(super) fn powers(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let steep = 16 / n.max(2) as i64;
    let (a, b) = (draw.int(-steep, steep), draw.int(-steep, steep));
    let (m0, k0) = (draw.plain(), draw.plain());
    let scaled = |base: &Number, power: i64| Number { text: String::new(), value: &base.value * power_of_ten(power) };
    let m: Vec<Number> = (1..=n as i64).map(|i| scaled(&m0, a * i)).collect();
    let k: Vec<Number> = (1..=n as i64 + 1).map(|i| scaled(&k0, b * i)).collect();
    let head = format!(
        "param n = {n}
param m[i in 1..n] = {}*10^({a}*i)
param k[i in 1..n+1] = {}*10^({b}*i)
",
        m0.text, k0.text
    );
    chain(head, &m, &k)
}

/// Masses and springs from tables, point 0 being the ground.
pub(super) fn network(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let m = draw.spread(n, 8);
    // Each point hangs on an earlier one, the first on the ground, and a few springs more.
    let mut pairs: Vec<(usize, usize)> = (1..=n).map(|i| (draw.size(0, i - 1), i)).collect();
    for _ in 0..draw.size(0, n) {
        let (i, j) = (draw.size(0, n), draw.size(1, n));
        if i != j {
            pairs.push((i.min(j), i.max(j)));
        }
    }
    let k = draw.spread(pairs.len(), 12);
    let mut points = "mass\n".to_owned();
    for m in &m {
        let _ = writeln!(points, "{}", m.text);
    }
    let mut springs = "i,j,k\n".to_owned();
    let mut stiffness = zeros(n);
    for ((i, j), k) in pairs.iter().zip(&k) {
        let _ = writeln!(springs, "{i},{j},{}", k.text);
        add_spring(&mut stiffness, &k.value, j - 1, i.checked_sub(1));
    }
    let text = "table points = \"points.csv\"
table springs = \"springs.csv\"
coord x[1..rows(points)]
let u[0] = 0
let u[i in 1..rows(points)] = x[i]
T = sum(p in points, 1/2*p.mass*x[p]'^2)
V = sum(s in springs, 1/2*s.k*(u[s.j] - u[s.i])^2)
";
    Model::exact(text.to_owned(), diagonal(&m), stiffness)
        .with_table("points.csv", points)
        .with_table("springs.csv", springs)
}

/// m l²
fn inertia(m: &Number, l: &Number) -> RBig {
    &m.value * &l.value * &l.value
}

/// Pendulums side by side, springs between their rods, each hanging (1) or standing (-1).
fn coupled_pendulums(m: &[Number], l: &[Number], c: &[Number], signs: Option<&[Number]>) -> Model {
    let n = m.len();
    let g = Number::scaled(981, -2);
    let (mut mass, mut stiffness) = (zeros(n), zeros(n));
    for i in 0..n {
        mass[i][i] = inertia(&m[i], &l[i]);
        let weight = &m[i].value * &g.value * &l[i].value;
        stiffness[i][i] += match signs {
            Some(signs) => weight * &signs[i].value,
            None => weight,
        };
    }
    for (i, c) in c.iter().enumerate() {
        add_spring(&mut stiffness, &c.value, i, Some(i + 1));
    }
    let mut text = format!("param g = {}\n", g.text);
    text += &family("m", m);
    text += &family("l", l);
    let potential = match signs {
        Some(signs) => {
            text += &family("s", signs);
            "sum(i in 1..N, -m[i]*g*l[i]*s[i]*cos(phi[i]))"
        }
        None => "sum(i in 1..N, m[i]*g*l[i]*(1 - cos(phi[i])))",
    };
    let mut potential = potential.to_owned();
    if !c.is_empty() {
        text += &family("c", c);
        potential += "\n  + sum(i in 1..N-1, 1/2*c[i]*(phi[i+1] - phi[i])^2)";
    }
    let text = format!(
        "param N = {n}\n{text}coord phi[1..N]
T = sum(i in 1..N, 1/2*m[i]*l[i]^2*phi[i]'^2)
V = {potential}
"
    );
    Model::exact(text, mass, stiffness)
}

pub(super) fn pendulums(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let (m, l) = (draw.spread(n, 8), draw.spread(n, 3));
    let c = draw.spread(n - 1, 12);
    coupled_pendulums(&m, &l, &c, None)
}

pub(super) fn inverted(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let (m, l, c) = (draw.plains(n), draw.plains(n), draw.plains(n - 1));
    let signs: Vec<Number> = (0..n).map(|_| Number::integer(draw.pick(&[1, -1]))).collect();
    coupled_pendulums(&m, &l, &c, Some(&signs))
}

/// Springs of either sign, also to the ground.
pub(super) fn negative_springs(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let m = draw.plains(n);
    let share = draw.int(2, 6);
    let k: Vec<Number> = (0..=n).map(|_| draw.signed(share)).collect();
    chain(family("m", &m) + &family("k", &k), &m, &k)
}

/// One or more pieces of chain that nothing holds.
pub(super) fn free(draw: &mut Draw) -> Model {
    let n = draw.dimension();
    let m = draw.spread(n, 4);
    let k = draw.spread(n - 1, 4);
    let cut = (n > 2 && draw.once_in(3)).then(|| draw.size(1, n - 1));
    let mut stiffness = zeros(n);
    for (i, k) in k.iter().enumerate() {
        if cut != Some(i + 1) {
            add_spring(&mut stiffness, &k.value, i, Some(i + 1));
        }
    }
    let mut text = format!("param n = {n}\n{}", family("m", &m));
    if !k.is_empty() {
        text += &family("k", &k);
    }
    text += "coord x[1..n]\nT = sum(i in 1..n, 1/2*m[i]*x[i]'^2)\n";
    if !k.is_empty() {
        let filter = cut.map(|c| format!(" where i != {c}")).unwrap_or_default();
        let _ = writeln!(text, "V = sum(i in 1..n-1{filter}, 1/2*k[i]*(x[i+1] - x[i])^2)");
    }
    Model::exact(text, diagonal(&m), stiffness)
}

/// Copies of one short chain, and what couples them.
struct Copies {
    copies: usize,
    m: Vec<Number>,
    k: Vec<Number>,
}

impl Copies {
    fn draw(draw: &mut Draw) -> Self {
        let p = draw.size(1, 5);
        let most = if draw.once_in(5) { 36 } else { 14 };
        let copies = draw.size(2, (most / p).max(2));
        let (m, k) = (draw.plains(p), draw.plains(p));
        Self { copies, m, k }
    }

    fn matrices(&self) -> (Exact, Exact) {
        let p = self.m.len();
        let n = p * self.copies;
        let mut stiffness = zeros(n);
        for at in 0..n {
            let j = at % p;
            let below = (j > 0).then(|| at - 1);
            add_spring(&mut stiffness, &self.k[j].value, at, below);
        }
        let mass = diagonal((0..n).map(|at| &self.m[at % p]));
        (mass, stiffness)
    }

    fn head(&self) -> String {
        let p = self.m.len();
        let mut text = format!("param N = {}\nparam p = {p}\n", self.copies);
        text += &family("m", &self.m);
        text += &family("k", &self.k);
        text + "coord x[1..N, 1..p]\n"
    }

    /// The energy of all copies, without what couples them.
    const POTENTIAL: &str = "sum(a in 1..N, 1/2*k[1]*x[a,1]^2)
  + sum(a in 1..N, j in 2..p, 1/2*k[j]*(x[a,j] - x[a,j-1])^2)";
}

pub(super) fn copies(draw: &mut Draw) -> Model {
    let copies = Copies::draw(draw);
    let (mass, mut stiffness) = copies.matrices();
    let (n, p) = (copies.copies, copies.m.len());
    let exponent = draw.int(-16, -3);
    let c = draw.decimal(exponent);
    let all_masses = draw.once_in(2);
    let (range, pairs): (&str, Vec<(usize, usize)>) = match draw.int(0, 2) {
        0 => ("a in 1..N-1, b in a+1..a+1", (1..n).map(|a| (a - 1, a)).collect()),
        1 => ("a in 1..N, b in a+1..N", (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).collect()),
        _ => ("a in 1..N, b in 1..N where b == mod(a, N) + 1", (0..n).map(|a| (a, (a + 1) % n)).collect()),
    };
    for (a, b) in pairs {
        for j in 0..if all_masses { p } else { 1 } {
            add_spring(&mut stiffness, &c.value, a * p + j, Some(b * p + j));
        }
    }
    let coupling = if all_masses {
        format!("sum({range}, 1/2*c*sum(j in 1..p, (x[b,j] - x[a,j])^2))")
    } else {
        format!("c/2*sum({range}, (x[b,1] - x[a,1])^2)")
    };
    let text = format!(
        "{}param c = {}
T = sum(a in 1..N, j in 1..p, 1/2*m[j]*x[a,j]'^2)
V = {}
  + {coupling}
",
        copies.head(),
        c.text,
        Copies::POTENTIAL
    );
    Model::exact(text, mass, stiffness)
}

/// Uncoupled, or all but, with masses that differ a little from copy to copy.
pub(super) fn detuned(draw: &mut Draw) -> Model {
    let copies = Copies::draw(draw);
    let (mut mass, mut stiffness) = copies.matrices();
    let (n, p) = (copies.copies, copies.m.len());
    let exponent = draw.int(-16, -3);
    let e = draw.decimal(exponent);
    let exponent = draw.int(-16, -3);
    let c = draw.decimal(exponent);
    for (at, row) in mass.iter_mut().enumerate() {
        row[at] = &row[at] * (RBig::ONE + &e.value * RBig::from(at / p + 1));
    }
    for a in 1..n {
        add_spring(&mut stiffness, &c.value, a * p, Some((a - 1) * p));
    }
    let text = format!(
        "{}param c = {}
param eps = {}
T = sum(a in 1..N, j in 1..p, 1/2*m[j]*(1 + a*eps)*x[a,j]'^2)
V = {}
  + sum(a in 2..N, 1/2*c*(x[a,1] - x[a-1,1])^2)
",
        copies.head(),
        c.text,
        e.text,
        Copies::POTENTIAL
    );
    Model::exact(text, mass, stiffness)
}
