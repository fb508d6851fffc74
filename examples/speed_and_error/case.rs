//! The problems: hard models with references of 40 digits, and families of any size with closed forms.

use std::error::Error;
use std::path::Path;

use dashu_ratio::RBig;
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::precision::{Ball, Big};
use librate::syntax::{StatementKind, parse};
use librate_core::modes::{PreciseProblem, Problem, Source};
use librate_core::number::gcd64;
use serde_json::Value;

use super::judge;
use super::real::exact;
use super::truth::{Known, computed, free_chain, laguerre_zeros};

/// The models of `models/hard` that are measured: those whose difficulty is in M and K. What makes the
/// others hard is finding the equilibrium, which is not the subject here.
pub(crate) const HARD: &[&str] = &[
    "springs_16_8_0",
    "springs_0_16_8",
    "springs_8_0_16",
    "chain_alternating",
    "inerters_alternating",
    "masses_sorted",
    "masses_shuffled",
    "masses_and_springs",
    "nearly_massless_bead",
    "nearly_massless_support",
    "hilbert_mass",
    "hilbert_mass_rounded",
    "pendulums_barely_coupled",
    "weak_bond",
    "free_body_weak_pair",
    "column_just_falls",
    "wilkinson_chain",
    "gear_train",
    "chain_free_50",
    "complete_graph",
    "pendulum_20_links",
    "pendulum_50_links",
    "lieb_lattice",
    "free_body_100",
];

/// Up to this size M and K go to the tools for many digits, and true values to 100 digits are computed.
pub(crate) const MANY_DIGITS: usize = 64;
/// M and K for those tools: bits of the numbers, and digits of the strings.
const BITS: usize = 1100;
const DIGITS: usize = 300;

/// One problem.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) n: usize,
    /// M and K as doubles, column by column, the way any tool would get them.
    pub(crate) mass: Vec<f64>,
    pub(crate) stiffness: Vec<f64>,
    /// M and K in 300 digits, for tools that take so many.
    pub(crate) texts: Option<[Vec<String>; 2]>,
    /// K = Σ k a aᵀ where it is such a sum.
    pub(crate) squares: Option<Vec<Square>>,
    /// True ω², rising.
    pub(crate) known: Known,
    pub(crate) origin: Origin,
}

/// One term k a aᵀ with k > 0: k, and the entries of a with their places.
#[derive(Clone)]
pub(crate) struct Square {
    pub(crate) weight: f64,
    pub(crate) entries: Vec<(usize, f64)>,
}

/// What librate starts from.
pub(crate) enum Origin {
    /// A model: M and K are evaluated, zero modes proved, within the time that is taken.
    Model(Box<Linearized>),
    /// The matrices, as exact numbers.
    Matrices(Box<Exact>),
}

/// Matrices of doubles, taken as exact.
pub(crate) struct Exact {
    pub(crate) problem: Problem,
}

impl Source for Exact {
    fn precisely(&self, bits: usize) -> Option<PreciseProblem> {
        let all = |a: &[Ball]| a.iter().map(|x| Big::from_ball(x, bits)).collect();
        Some(PreciseProblem {
            dimension: self.problem.dimension,
            mass: all(&self.problem.mass),
            stiffness: all(&self.problem.stiffness),
            zero_vectors: self.problem.zero_vectors.iter().map(|z| all(z)).collect(),
        })
    }
}

impl Case {
    /// Whether M is diagonal and K tridiagonal.
    pub(crate) fn is_chain(&self) -> bool {
        let n = self.n;
        (0..n * n).all(|at| {
            let apart = (at / n).abs_diff(at % n);
            (apart < 1 || self.mass[at] == 0.0) && (apart < 2 || self.stiffness[at] == 0.0)
        })
    }

    /// Whether fewer than a fifth of the entries are not zero.
    pub(crate) fn is_sparse(&self) -> bool {
        let entries = self.mass.iter().chain(&self.stiffness);
        5 * entries.filter(|x| **x != 0.0).count() < 2 * self.n * self.n
    }

    pub(crate) fn zeros(&self) -> usize {
        self.known.values.iter().filter(|x| x.is_zero()).count()
    }

    /// A model of `models/hard` under the root of the repository.
    pub(crate) fn hard(root: &Path, name: &str) -> Result<Self, Box<dyn Error>> {
        let linearized = load(&root.join(format!("models/hard/{name}.lag")))?;
        let n = linearized.dimension();
        let reference = root.join(format!("tests/reference/hard/{name}.json"));
        let mut known = published(&std::fs::read_to_string(reference)?)?;
        let mut texts = None;
        if n <= MANY_DIGITS
            && let Some(precise) = linearized.precisely(BITS)
        {
            if let Some(longer) = computed(&rationals(&precise.mass, n), &rationals(&precise.stiffness, n)) {
                // Beyond 40 digits they are those of a solver of its own, held against the reference.
                let off = judge::judge(&longer.values, &known.values, longer.digits);
                if off.error > 1e-39 || off.zero.unwrap_or(0.0) > 0.0 {
                    return Err(format!("two references for {name} differ by {:e}", off.error).into());
                }
                known = longer;
            }
            let text = |a: &[Big]| a.iter().map(|x| x.decimal(DIGITS).text).collect();
            texts = Some([text(&precise.mass), text(&precise.stiffness)]);
        }
        let squares = linearized.squares().map(|squares| {
            let entry = |(place, x): (usize, Ball)| (place, x.mid_f64());
            let square = |own: Vec<_>| Square { weight: 1.0, entries: own.into_iter().map(entry).collect() };
            squares.into_iter().map(square).collect()
        });
        let doubles = |a: Vec<Ball>| a.iter().map(Ball::mid_f64).collect();
        Ok(Self {
            name: name.to_owned(),
            n,
            mass: doubles(linearized.mass()),
            stiffness: doubles(linearized.stiffness()),
            texts,
            squares,
            known,
            origin: Origin::Model(Box::new(linearized)),
        })
    }

    /// Matrices whose entries are doubles, with zero vectors and squares.
    fn exact(
        name: &str,
        [mass, stiffness]: [Vec<f64>; 2],
        zero_vectors: Vec<Vec<f64>>,
        squares: Vec<Square>,
        known: Known,
    ) -> Self {
        let n = known.values.len();
        let balls = |a: &[f64]| -> Vec<Ball> { a.iter().map(|&x| Ball::exact(x)).collect() };
        let text =
            |a: &[f64]| -> Vec<String> { a.iter().map(|&x| Big::from_f64(x, 64).decimal(DIGITS).text).collect() };
        let problem = Problem {
            dimension: n,
            mass: balls(&mass),
            stiffness: balls(&stiffness),
            zero_vectors: zero_vectors.iter().map(|z| balls(z)).collect(),
        };
        Self {
            name: name.to_owned(),
            n,
            texts: (n <= MANY_DIGITS).then(|| [text(&mass), text(&stiffness)]),
            mass,
            stiffness,
            squares: Some(squares),
            known,
            origin: Origin::Matrices(Box::new(Exact { problem })),
        }
    }
}

fn rationals(a: &[Big], n: usize) -> Vec<Vec<RBig>> {
    let entry = |i: usize, j: usize| {
        let (significand, exponent) = a[i.max(j) + n * i.min(j)].mid();
        RBig::from(significand.clone()) * RBig::from(2).pow(exponent as isize)
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// A model file with its tables, at its equilibrium.
fn load(path: &Path) -> Result<Linearized, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let file = parse(&text).map_err(librate::Error::from)?;
    let mut tables = TableTexts::new();
    for statement in &file.statements {
        if let StatementKind::Table { path: table, .. } = &statement.kind {
            let beside = path.parent().unwrap_or(path).join(table);
            tables = tables.with(table.clone(), std::fs::read_to_string(beside)?);
        }
    }
    let model = elaborate(&file, &tables, &Settings::new()).map_err(librate::Error::from)?;
    Ok(linearize(model)?)
}

/// A reference of 40 digits: the true ω², rising.
fn published(text: &str) -> Result<Known, Box<dyn Error>> {
    let all: Value = serde_json::from_str(text)?;
    let modes = all["modes"].as_array().ok_or("a reference without modes")?;
    let mut values = Vec::with_capacity(modes.len());
    for mode in modes {
        let number = |key: &str| mode[key].as_str().and_then(judge::parse);
        let omega = number("omega").ok_or("a reference without omega")?;
        let growth = number("growth").ok_or("a reference without growth")?;
        values.push(omega.mul(&omega).sub(&growth.mul(&growth)));
    }
    // Forty digits of ω are 39 of ω².
    Ok(Known { values, digits: 39 })
}

/// Problems of one kind in several sizes.
pub(crate) struct Family {
    pub(crate) slug: &'static str,
    pub(crate) title: &'static str,
    pub(crate) sizes: &'static [usize],
    pub(crate) make: fn(usize) -> Option<Case>,
}

pub(crate) const FAMILIES: [Family; 4] = [
    Family {
        slug: "chain",
        title: "free chain (tridiagonal, one zero mode)",
        sizes: &[3, 10, 30, 100, 300, 1000],
        make: chain,
    },
    Family {
        slug: "pendulum",
        title: "pendulum of n links (full M)",
        sizes: &[3, 10, 30, 100, 300, 1000],
        make: pendulum,
    },
    Family { slug: "network", title: "network of all pairs (full K)", sizes: &[3, 10, 30, 60], make: network },
    Family {
        slug: "hilbert",
        title: "Hilbert's mass matrix (ever nearer to singular)",
        sizes: &[3, 6, 9, 12, 13, 14, 15, 20],
        make: hilbert,
    },
];

fn flat(n: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    (0..n * n).map(|at| entry(at % n, at / n)).collect()
}

/// A spring between two coordinates.
fn spring(weight: f64, i: usize, j: usize) -> Square {
    Square { weight, entries: vec![(i, -1.0), (j, 1.0)] }
}

/// A spring from a coordinate to the wall.
fn anchor(weight: f64, i: usize) -> Square {
    Square { weight, entries: vec![(i, 1.0)] }
}

/// The rows of a symmetric matrix of doubles, exactly.
fn rows(a: &[f64], n: usize) -> Vec<Vec<RBig>> {
    let row = |row: &[f64]| row.iter().map(|&x| exact(x)).collect();
    a.chunks(n).map(row).collect()
}

/// Equal masses on equal springs, both ends free.
fn chain(n: usize) -> Option<Case> {
    let mass = flat(n, |i, j| f64::from(u8::from(i == j)));
    let stiffness = flat(n, |i, j| match i.abs_diff(j) {
        0 if i == 0 || i == n - 1 => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    });
    let springs = (1..n).map(|i| spring(1.0, i - 1, i)).collect();
    let drift = vec![vec![1.0; n]];
    let name = format!("free chain, n = {n}");
    Some(Case::exact(&name, [mass, stiffness], drift, springs, free_chain(n)))
}

/// A pendulum of n equal links in angles, in units of its link and of gravity.
fn pendulum(n: usize) -> Option<Case> {
    let below = |i: usize| (n - i) as f64;
    let mass = flat(n, |i, j| below(i.max(j)));
    let stiffness = flat(n, |i, j| if i == j { below(i) } else { 0.0 });
    let weights = (0..n).map(|i| anchor(below(i), i)).collect();
    let name = format!("pendulum, n = {n}");
    Some(Case::exact(&name, [mass, stiffness], Vec::new(), weights, laguerre_zeros(n)?))
}

/// Masses on a line, a spring between any two and one to the wall from each; all numbers between 1 and 2,
/// scattered, with ten bits after the point, so that no sum is rounded.
fn network(n: usize) -> Option<Case> {
    let scattered = |i: usize, j: usize| {
        // Weyl's sequence, whose parts in lowest bits repeat late enough.
        let hash = (i as u64 * 65_537 + j as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        1.0 + (hash >> 54) as f64 / 1024.0
    };
    let constant = |i: usize, j: usize| scattered(i.min(j) + 1, i.max(j) + 1);
    let mass = flat(n, |i, j| if i == j { scattered(0, i) } else { 0.0 });
    let stiffness = flat(n, |i, j| if i == j { (0..n).map(|k| constant(i, k)).sum() } else { -constant(i, j) });
    let mut squares = Vec::new();
    for i in 0..n {
        squares.push(anchor(constant(i, i), i));
        squares.extend((0..i).map(|j| spring(constant(i, j), j, i)));
    }
    let known = computed(&rows(&mass, n), &rows(&stiffness, n))?;
    let name = format!("network, n = {n}");
    Some(Case::exact(&name, [mass, stiffness], Vec::new(), squares, known))
}

/// A chain between walls whose M is Hilbert's matrix 1/(i + j - 1) times the least common multiple of the
/// denominators: up to n = 20 whole numbers below 2^53.
fn hilbert(n: usize) -> Option<Case> {
    let multiple = (1..2 * n as u64).fold(1, |all, k| all / gcd64(all, k) * k);
    if multiple >= 1 << 53 {
        return None;
    }
    let mass = flat(n, |i, j| (multiple / (i + j + 1) as u64) as f64);
    let stiffness = flat(n, |i, j| match i.abs_diff(j) {
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    });
    let mut springs = vec![anchor(1.0, 0), anchor(1.0, n - 1)];
    springs.extend((1..n).map(|i| spring(1.0, i - 1, i)));
    let known = computed(&rows(&mass, n), &rows(&stiffness, n))?;
    let name = format!("Hilbert, n = {n}");
    Some(Case::exact(&name, [mass, stiffness], Vec::new(), springs, known))
}
