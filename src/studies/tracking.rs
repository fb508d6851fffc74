//! Modes over a range of a parameter, followed by their shapes: which mode at one value is which at the next.
//!
//! Two modes belong together where |xᴴ M y|² is large, M being the mass matrix at the first value (the modal assurance criterion of
//! R. J. Allemang and D. L. Brown, Proc. 1st Int. Modal Analysis Conf., 1982). Where it decides nothing, or two modes seem to change
//! places, the interval is halved, and halved again: at an avoided crossing shapes turn into each other, at a crossing they keep what
//! they are. Modes of different symmetry classes never belong together. Among equal frequencies no shape is one of a mode; those before
//! are kept until they part again.

use crate::sweep::{Place, Sweep};
use librate_core::linearize::Linearized;
use librate_core::modes::Kind;
use librate_core::oscillation::NormalModes;

/// Shapes that agree less leave it open what belongs together.
const SURE: f64 = 0.7;
/// Those that agree less than this have nothing in common.
const LEAST: f64 = 0.05;
/// An interval is halved so many times.
const DEEPEST: u32 = 16;
/// Masses of more coordinates count alike.
const MOST_DENSE: usize = 600;

/// A mode followed over a range.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Branch {
    /// Its symmetry class, where it has one.
    pub class: Option<String>,
    /// The places where it is, each with its number among the modes there.
    pub at: Vec<(usize, usize)>,
}

/// A mode as it is compared.
#[derive(Clone, Debug)]
struct Shape {
    /// Real and imaginary part of each component.
    vector: Vec<[f64; 2]>,
    /// M times it, and the root of xᴴMx.
    image: Vec<[f64; 2]>,
    length: f64,
    class: Option<String>,
    cluster: u32,
    kind: Kind,
}

impl Shape {
    /// |xᴴ M y|²/(xᴴMx · yᴴMy), 1 for the same shape.
    fn agreement(&self, other: &Self) -> f64 {
        if let (Some(own), Some(others)) = (&self.class, &other.class)
            && own != others
        {
            return 0.0;
        }
        let (mut re, mut im) = (0.0, 0.0);
        let (mut square, mut cross) = (0.0, 0.0);
        for ([a, b], ([c, d], [e, f])) in self.image.iter().zip(other.vector.iter().zip(&other.image)) {
            re += a * c + b * d;
            im += a * d - b * c;
            square += c * e + d * f;
            cross += a * a + b * b;
        }
        if cross == 0.0 || square <= 0.0 { 0.0 } else { (re * re + im * im) / (self.length * square) }
    }
}

/// The modes at a place.
type Shapes = Vec<Shape>;

fn shapes(linearized: &Linearized, modes: &NormalModes) -> Shapes {
    let n = modes.modes.first().map_or(0, |mode| mode.vector.len());
    let mass = if n <= MOST_DENSE { linearized.mass() } else { Vec::new() };
    let mass: Vec<f64> = if mass.len() == n * n { mass.iter().map(|own| own.mid_f64()).collect() } else { Vec::new() };
    let shape = |mode: &librate_core::oscillation::NormalMode| {
        let imaginary = mode.imaginary.iter().copied().chain(std::iter::repeat(0.0));
        let vector: Vec<[f64; 2]> = mode.vector.iter().zip(imaginary).map(|(re, im)| [*re, im]).collect();
        let image: Vec<[f64; 2]> = if mass.is_empty() {
            vector.clone()
        } else {
            let row = |row: &[f64]| {
                let mut sums = [0.0; 2];
                for (entry, part) in row.iter().zip(&vector) {
                    sums[0] += entry * part[0];
                    sums[1] += entry * part[1];
                }
                sums
            };
            mass.chunks(n).map(row).collect()
        };
        let length = vector.iter().zip(&image).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum();
        Shape { vector, image, length, class: mode.symmetry.clone(), cluster: mode.cluster, kind: mode.kind }
    };
    modes.modes.iter().map(shape).collect()
}

/// For each mode of one place that of another, and how sure the least certain pair is.
fn matched(from: &Shapes, to: &Shapes) -> (Vec<Option<usize>>, f64) {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, own) in from.iter().enumerate() {
        for (j, other) in to.iter().enumerate() {
            let agreement = own.agreement(other);
            if agreement > LEAST {
                pairs.push((agreement, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut found = vec![None; from.len()];
    let mut taken = vec![false; to.len()];
    let mut sure: f64 = 1.0;
    for (agreement, i, j) in pairs {
        if found[i].is_none() && !taken[j] {
            found[i] = Some(j);
            taken[j] = true;
            // Among equal exponents any basis is as good.
            let several = |all: &Shapes, at: usize| all.iter().filter(|one| one.cluster == all[at].cluster).count() > 1;
            if !several(from, i) && !several(to, j) && from[i].kind != Kind::Zero {
                sure = sure.min(agreement);
            }
        }
    }
    if from.len() == to.len() && found.iter().any(Option::is_none) {
        sure = 0.0;
    }
    (found, sure)
}

/// Whether two modes change places that may only seem to: shapes that turn into each other within a short way, and are not told apart by
/// their classes.
fn swaps([from, to]: [&Shapes; 2], found: &[Option<usize>]) -> bool {
    let known: Vec<(usize, usize)> = found.iter().enumerate().filter_map(|(i, j)| Some((i, (*j)?))).collect();
    let alike = |i: usize, k: usize| from[i].class.is_none() || from[i].class == from[k].class;
    let single = |i: usize, k: usize| from[i].cluster != from[k].cluster;
    known.iter().enumerate().any(|(at, (i, j))| {
        let later = &known[at + 1..];
        later.iter().any(|(k, l)| l < j && alike(*i, *k) && single(*i, *k) && to[*j].cluster != to[*l].cluster)
    })
}

/// The modes between two places of a range, which is refined where their shapes leave it open.
fn connected(sweep: &Sweep, ends: [&Shapes; 2], between: [usize; 2], depth: u32) -> Vec<Option<usize>> {
    let (found, sure) = matched(ends[0], ends[1]);
    if sure >= SURE && !swaps(ends, &found) || depth == DEEPEST {
        return found;
    }
    let [from, to] = between.map(|place| 2 * place);
    let Some(finer) = sweep.finer() else {
        return found;
    };
    let Ok((linearized, modes)) = finer.place(from + 1).result else {
        return found;
    };
    let middle = shapes(&linearized, &modes);
    // A crossing itself, at which any basis is as good.
    if (1..middle.len()).any(|at| middle[at].cluster == middle[at - 1].cluster && middle[at].kind != Kind::Zero) {
        return found;
    }
    let first = connected(&finer, [ends[0], &middle], [from, from + 1], depth + 1);
    let second = connected(&finer, [&middle, ends[1]], [from + 1, to], depth + 1);
    first.into_iter().map(|at| second.get(at?).copied().flatten()).collect()
}

/// Follows the modes of a sweep from place to place; `places` are all of its places, with shapes, in order. A place without modes
/// ends all branches.
#[must_use]
pub fn branches(sweep: &Sweep, places: &[Place]) -> Vec<Branch> {
    let mut branches: Vec<Branch> = Vec::new();
    // Of the modes at the place before: their shapes, and their branches.
    let mut before: Option<(Shapes, Vec<usize>)> = None;
    for (place, own) in places.iter().enumerate() {
        let Ok((linearized, modes)) = &own.result else {
            before = None;
            continue;
        };
        let mut here = shapes(linearized, modes);
        let mut owners = vec![None; here.len()];
        if let Some((shapes, known)) = &before {
            let found = connected(sweep, [shapes, &here], [place - 1, place], 0);
            for ((old, at), branch) in shapes.iter().zip(found).zip(known) {
                let Some(at) = at else { continue };
                owners[at] = Some(*branch);
                let cluster = here[at].cluster;
                if here.iter().filter(|one| one.cluster == cluster).count() > 1 {
                    let old = old.clone();
                    here[at] = Shape { cluster, ..old };
                }
            }
        }
        let mut known = Vec::with_capacity(here.len());
        for (at, owner) in owners.into_iter().enumerate() {
            let branch = owner.unwrap_or_else(|| {
                branches.push(Branch { class: here[at].class.clone(), at: Vec::new() });
                branches.len() - 1
            });
            branches[branch].at.push((place, at));
            known.push(branch);
        }
        before = Some((here, known));
    }
    branches
}
