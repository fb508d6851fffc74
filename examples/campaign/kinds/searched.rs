//! Models whose equilibrium is irrational and has to be searched for. The reference takes over which
//! one was found and pins it down by itself.

use super::plane::add_block;
use super::{Model, Reference, Searched};
use crate::draw::*;
use crate::real::*;
use crate::reference::{Square, to_reals};

fn searched(text: String, problem: impl Searched + 'static) -> Model {
    Model::new(text, Reference::Searched(Box::new(problem)))
}

/// Adds the spring force k d + β d³ and its derivative, d = x_i - x_j - rest; no j: the ground.
struct Spring<'a> {
    k: &'a Real,
    cubic: Option<&'a Real>,
}

impl Spring<'_> {
    fn add(&self, (gradient, hessian): (&mut [Real], &mut Square), x: &[Real], (i, j): (usize, Option<usize>)) {
        let d = j.map_or_else(|| x[i].clone(), |j| &x[i] - &x[j]);
        let mut force = self.k * &d;
        let mut slope = self.k.clone();
        if let Some(cubic) = self.cubic {
            let square = &d * &d;
            force += cubic * &square * &d;
            slope += cubic * &square + cubic * &square + cubic * &square;
        }
        add((gradient, hessian), &force, &slope, (i, j));
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
struct Wells {
    m: Vec<Number>,
    a: Vec<Number>,
    b: Vec<Number>,
    f: Vec<Number>,
    k: Vec<Number>,
}

pub(super) fn wells(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(16);
    let wells =
        Wells { m: some(draw, n), a: draw.plains(n), b: draw.plains(n), f: draw.plains(n), k: some(draw, n - 1) };
    let start: Vec<Number> = (0..n).map(|_| Number::integer(draw.pick(&[-1, 1, 2]))).collect();
    let mut text = format!("param n = {n}\n");
    let names = ["m", "a", "b", "f"];
    for (name, values) in names.iter().zip([&wells.m, &wells.a, &wells.b, &wells.f]) {
        text += &family(name, values);
    }
    let mut springs = String::new();
    if n > 1 {
        text += &family("k", &wells.k);
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
    searched(text, wells)
}

impl Searched for Wells {
    fn mass(&self, bits: usize) -> Square {
        to_reals(&diagonal(&self.m), bits)
    }

    fn derivatives(&self, x: &[Real], bits: usize) -> (Vec<Real>, Square) {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        for i in 0..x.len() {
            let [a, b, f] = [&self.a, &self.b, &self.f].map(|v| real(&v[i].value, bits));
            let well = Spring { k: &-b, cubic: Some(&a) };
            well.add((&mut gradient, &mut hessian), x, (i, None));
            gradient[i] -= f;
        }
        for (i, k) in self.k.iter().enumerate() {
            let k = real(&k.value, bits);
            let spring = Spring { k: &k, cubic: None };
            spring.add((&mut gradient, &mut hessian), x, (i + 1, Some(i)));
        }
        (gradient, hessian)
    }
}

/// Masses on hardening springs under each other.
struct Hanging {
    m: Vec<Number>,
    k: Vec<Number>,
    b: Vec<Number>,
}

pub(super) fn hanging(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(20);
    let problem = Hanging { m: draw.plains(n), k: some(draw, n), b: some(draw, n) };
    let text = format!(
        "param n = {n}
param g = 9.81
{}{}{}coord x[1..n]
let d[1] = x[1]
let d[i in 2..n] = x[i] - x[i-1]
T = sum(i in 1..n, 1/2*m[i]*x[i]'^2)
V = sum(i in 1..n, 1/2*k[i]*d[i]^2 + 1/4*b[i]*d[i]^4 - m[i]*g*x[i])
",
        family("m", &problem.m),
        family("k", &problem.k),
        family("b", &problem.b),
    );
    searched(text, problem)
}

impl Searched for Hanging {
    fn mass(&self, bits: usize) -> Square {
        to_reals(&diagonal(&self.m), bits)
    }

    fn derivatives(&self, x: &[Real], bits: usize) -> (Vec<Real>, Square) {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let g = real(&Number::scaled(981, -2).value, bits);
        for i in 0..x.len() {
            let [m, k, b] = [&self.m, &self.k, &self.b].map(|v| real(&v[i].value, bits));
            let spring = Spring { k: &k, cubic: Some(&b) };
            spring.add((&mut gradient, &mut hessian), x, (i, i.checked_sub(1)));
            gradient[i] -= m * &g;
        }
        (gradient, hessian)
    }
}

/// Charges in a trap.
struct Ions {
    m: Vec<Number>,
    q: Vec<Number>,
    k: Number,
}

pub(super) fn ions(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(10);
    let problem = Ions { m: some(draw, n), q: (0..n).map(|_| draw.decimal(0)).collect(), k: draw.plain() };
    let text = format!(
        "param N = {n}
param k = {}
{}{}coord x[1..N]
T = sum(i in 1..N, 1/2*m[i]*x[i]'^2)
V = sum(i in 1..N, 1/2*k*x[i]^2) + sum(i in 1..N, j in i+1..N, q[i]*q[j]/(x[j] - x[i]))
guess x[i in 1..N] = i - (N + 1)/2
",
        problem.k.text,
        family("m", &problem.m),
        family("q", &problem.q),
    );
    searched(text, problem)
}

impl Searched for Ions {
    fn mass(&self, bits: usize) -> Square {
        to_reals(&diagonal(&self.m), bits)
    }

    fn derivatives(&self, x: &[Real], bits: usize) -> (Vec<Real>, Square) {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let k = real(&self.k.value, bits);
        for i in 0..x.len() {
            gradient[i] += &k * &x[i];
            hessian[i][i] += &k;
            for j in i + 1..x.len() {
                let charges = real(&(&self.q[i].value * &self.q[j].value), bits);
                let d = &x[j] - &x[i];
                let force = charges / (&d * &d);
                let slope = integer(2, bits) * &force / &d;
                add((&mut gradient, &mut hessian), &force, &slope, (i, Some(j)));
            }
        }
        (gradient, hessian)
    }
}

/// Pendulums that torsion springs pull aside.
struct Torsion {
    m: Vec<Number>,
    l: Vec<Number>,
    k: Vec<Number>,
    a: Vec<Number>,
    c: Vec<Number>,
}

pub(super) fn torsion(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(16);
    let problem = Torsion {
        m: some(draw, n),
        l: draw.plains(n),
        k: some(draw, n),
        a: (0..n).map(|_| Number::scaled(draw.int(1, 200), -2)).collect(),
        c: some(draw, n - 1),
    };
    let mut text = format!("param n = {n}\nparam g = 9.81\n");
    text += &family("m", &problem.m);
    text += &family("l", &problem.l);
    text += &family("k", &problem.k);
    text += &family("a", &problem.a);
    let mut coupling = String::new();
    if n > 1 {
        text += &family("c", &problem.c);
        coupling += "\n  + sum(i in 2..n, 1/2*c[i-1]*(phi[i] - phi[i-1])^2)";
    }
    text += &format!(
        "coord phi[1..n]
T = sum(i in 1..n, 1/2*m[i]*l[i]^2*phi[i]'^2)
V = sum(i in 1..n, 1/2*k[i]*(phi[i] - a[i])^2 - m[i]*g*l[i]*cos(phi[i])){coupling}
"
    );
    searched(text, problem)
}

impl Searched for Torsion {
    fn mass(&self, bits: usize) -> Square {
        let inertia = |(m, l): (&Number, &Number)| Number::exactly(&m.value * &l.value * &l.value);
        let all: Vec<Number> = self.m.iter().zip(&self.l).map(inertia).collect();
        to_reals(&diagonal(&all), bits)
    }

    fn derivatives(&self, x: &[Real], bits: usize) -> (Vec<Real>, Square) {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let g = real(&Number::scaled(981, -2).value, bits);
        for i in 0..x.len() {
            let [m, l, k, a] = [&self.m, &self.l, &self.k, &self.a].map(|v| real(&v[i].value, bits));
            let weight = m * l * &g;
            let (sin, cos) = sin_cos(&x[i], bits);
            gradient[i] += &k * (&x[i] - a) + &weight * sin;
            hessian[i][i] += k + weight * cos;
        }
        for (i, c) in self.c.iter().enumerate() {
            let c = real(&c.value, bits);
            let spring = Spring { k: &c, cubic: None };
            spring.add((&mut gradient, &mut hessian), x, (i + 1, Some(i)));
        }
        (gradient, hessian)
    }
}

/// Beads on elastic strings between two hooks, sagging.
struct Sagging {
    m: Vec<Number>,
    k: Vec<Number>,
    a: Number,
    width: Number,
}

pub(super) fn sagging(draw: &mut Draw) -> Model {
    let n = draw.dimension().min(16).div_ceil(2);
    let stiff = draw.int(1, 4);
    let problem = Sagging {
        m: draw.plains(n),
        k: (0..=n).map(|_| draw.decimal(stiff)).collect(),
        a: Number::scaled(draw.int(50, 120), -2),
        width: Number::integer(n as i64 + 1),
    };
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
        problem.a.text,
        problem.width.text,
        family("m", &problem.m),
        family("k", &problem.k),
    );
    searched(text, problem)
}

impl Searched for Sagging {
    fn mass(&self, bits: usize) -> Square {
        to_reals(&diagonal(self.m.iter().flat_map(|m| [m, m])), bits)
    }

    fn derivatives(&self, x: &[Real], bits: usize) -> (Vec<Real>, Square) {
        let (mut gradient, mut hessian) = empty(x.len(), bits);
        let points = self.m.len();
        let g = real(&Number::scaled(981, -2).value, bits);
        for (i, m) in self.m.iter().enumerate() {
            gradient[2 * i + 1] += real(&m.value, bits) * &g;
        }
        let a = real(&self.a.value, bits);
        for (i, k) in self.k.iter().enumerate() {
            let k = real(&k.value, bits);
            let end = |i: Option<usize>| match i {
                Some(i) if i < points => [x[2 * i].clone(), x[2 * i + 1].clone()],
                Some(_) => [real(&self.width.value, bits), integer(0, bits)],
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
                if i < points {
                    gradient[2 * i + p] += &force;
                }
                if let Some(from) = from {
                    gradient[2 * from + p] -= &force;
                }
            }
            let mut slopes = [0, 1].map(|p| [0, 1].map(|q| &rest * &d[p] * &d[q]));
            slopes[0][0] += &pull;
            slopes[1][1] += &pull;
            let (own, other) = ends(i, points);
            add_block(&mut hessian, &slopes, own, other);
        }
        (gradient, hessian)
    }
}
