//! What is claimed of the exponents of a small model, held against the roots of its polynomial.

use librate::modes::{Kind, Stability};
use librate::oscillation::{NormalMode, NormalModes};
use librate::precision::{Rounding, decimal};

use crate::check::{Asked, Outcome, Wrong, centre, is_rounded, within};
use crate::digits::{absolute, digits, read};
use crate::draw::power_of_ten;
use crate::pencil::{Complex, Pencil, Root};
use crate::real::*;
use crate::reference::AWAY;

/// A drawn pencil and the units that the text is written in: of the text, coordinate i is 10^-lengths[i]
/// of the pencil's, and exponents are 10^rate of its.
pub(crate) struct Scaled {
    pub(crate) pencil: Pencil,
    pub(crate) lengths: Vec<i64>,
    pub(crate) rate: i64,
}

impl Scaled {
    /// How many powers of ten the units of two coordinates are apart, at most.
    fn spread(&self) -> i64 {
        let (least, most) = (self.lengths.iter().min(), self.lengths.iter().max());
        most.zip(least).map_or(0, |(most, least)| most - least)
    }

    /// So many bits tell vectors apart that only components in small units do: kernels have a quarter of them at least.
    fn least_bits(&self) -> usize {
        4 * (10 * self.spread().unsigned_abs() as usize / 3) + 256
    }
}

/// What has to be printed: one for a conjugate pair, a real exponent or a conservative pair.
struct Entry {
    growth: Real,
    omega: Real,
    kind: Kind,
    root: usize,
}

struct Judge<'a> {
    scaled: &'a Scaled,
    bits: usize,
    roots: Vec<Root>,
    entries: Vec<Entry>,
}

/// `None`: more bits are needed.
pub(crate) fn judge(
    scaled: &Scaled,
    modes: &NormalModes,
    asked: &Asked,
    bits: usize,
    outcome: &mut Outcome,
) -> Option<()> {
    if bits < scaled.least_bits() {
        return None;
    }
    let roots = scaled.pencil.roots(bits)?;
    let entries = entries(scaled, &roots, bits);
    let judge = Judge { scaled, bits, roots, entries };
    judge.stability(modes, outcome);
    if modes.modes.len() != judge.entries.len() {
        let (claimed, expected) = (modes.modes.len(), judge.entries.len());
        outcome.wrong(Wrong::Error, format!("{claimed} modes instead of {expected}: {}", judge.listed()));
        return Some(());
    }
    outcome.zeros = modes.modes.iter().filter(|m| m.kind == Kind::Zero).count();
    outcome.undecided += modes.modes.iter().filter(|m| m.kind == Kind::Undecided).count();
    let Some(pairs) = judge.pairs(&modes.modes, outcome) else {
        return Some(());
    };
    for (mode, entry) in modes.modes.iter().zip(&pairs) {
        judge.printed(mode, &judge.entries[*entry], asked, outcome);
    }
    if asked.vectors {
        judge.shapes(&modes.modes, &pairs, outcome);
    }
    Some(())
}

fn entries(scaled: &Scaled, roots: &[Root], bits: usize) -> Vec<Entry> {
    let damped = scaled.pencil.is_damped();
    let unit = real(&power_of_ten(scaled.rate), bits);
    let mut entries = Vec::new();
    for (index, root) in roots.iter().enumerate() {
        let (re, im) = (&root.value.re, &root.value.im);
        let zero = is_zero(re) && is_zero(im);
        let (kind, count) = if zero {
            let count = if damped { root.kernel.len() } else { root.multiplicity / 2 };
            (Kind::Zero, count)
        } else if !is_zero(re) && !is_negative(re) {
            (Kind::Unstable, root.multiplicity)
        } else if is_zero(re) {
            (Kind::Oscillation, root.multiplicity)
        } else if !is_zero(im) {
            (Kind::Damped, root.multiplicity)
        } else if damped {
            (Kind::Overdamped, root.multiplicity)
        } else {
            // The decaying one of a pair ±s.
            (Kind::Overdamped, 0)
        };
        entries.extend((0..count).map(|_| Entry { growth: re * &unit, omega: im * &unit, kind, root: index }));
    }
    entries
}

impl Judge<'_> {
    fn stability(&self, modes: &NormalModes, outcome: &mut Outcome) {
        let unstable = self.entries.iter().any(|e| e.kind == Kind::Unstable);
        let zero = self.entries.iter().any(|e| e.kind == Kind::Zero);
        let few = |root: &Root| root.kernel.len() < root.multiplicity;
        let secular = self.scaled.pencil.drifts_faster()
            || self.roots.iter().any(|root| root.is_imaginary() && !root.is_real() && few(root));
        if modes.secular.is_some_and(|claimed| claimed != secular) {
            outcome.wrong(Wrong::Kind, format!("secular growth: {secular}"));
        }
        let truth = if unstable {
            Stability::Unstable
        } else if zero || secular {
            Stability::Neutral
        } else {
            Stability::Stable
        };
        if modes.stability == Stability::Undecided {
            outcome.undecided += 1;
        } else if modes.stability != truth {
            let (claimed, truth) = (modes.stability.as_str(), truth.as_str());
            outcome.wrong(Wrong::Kind, format!("{claimed} is wrong: {truth}"));
        }
    }

    fn listed(&self) -> String {
        let entries = self.entries.iter();
        let texts: Vec<String> =
            entries.map(|e| format!("{} {:e} {:e}", e.kind.as_str(), float(&e.growth), float(&e.omega))).collect();
        texts.join("; ")
    }

    fn fits(&self, mode: &NormalMode, entry: &Entry) -> bool {
        let kind = mode.kind == Kind::Undecided || mode.kind == entry.kind;
        kind && within(&entry.growth, &mode.growth, self.bits) && within(&entry.omega, &mode.omega, self.bits)
    }

    /// Which entry each mode stands for: all of them, each once.
    fn pairs(&self, modes: &[NormalMode], outcome: &mut Outcome) -> Option<Vec<usize>> {
        let fits: Vec<Vec<usize>> = modes
            .iter()
            .map(|mode| {
                let all = 0..self.entries.len();
                all.filter(|e| self.fits(mode, &self.entries[*e])).collect()
            })
            .collect();
        for (index, (mode, fits)) in modes.iter().zip(&fits).enumerate() {
            if fits.is_empty() {
                let message = format!(
                    "mode {}, {} {:?} {:?}, is none of {}",
                    index + 1,
                    mode.kind.as_str(),
                    mode.growth,
                    mode.omega,
                    self.listed()
                );
                outcome.wrong(Wrong::Bound, message);
            }
        }
        if fits.iter().any(Vec::is_empty) {
            return None;
        }
        // Augmenting paths (Kuhn).
        let mut owner: Vec<Option<usize>> = vec![None; self.entries.len()];
        for mode in 0..modes.len() {
            let mut seen = vec![false; self.entries.len()];
            if !placed(mode, &fits, &mut owner, &mut seen) {
                outcome.wrong(Wrong::Zeros, "modes and true exponents don't pair off".to_owned());
                return None;
            }
        }
        let mut pairs = vec![0; modes.len()];
        for (entry, mode) in owner.iter().enumerate() {
            pairs[(*mode)?] = entry;
        }
        Some(pairs)
    }

    fn printed(&self, mode: &NormalMode, entry: &Entry, asked: &Asked, outcome: &mut Outcome) {
        let numbers = [("growth", &mode.growth, &entry.growth), ("omega", &mode.omega, &entry.omega)];
        for (name, ball, truth) in numbers {
            if ball.is_zero() {
                continue;
            }
            outcome.numbers += 1;
            let floor = scale(&abs(truth), -107);
            let error = larger(abs(&(truth - centre(ball, self.bits))), floor);
            if !is_zero(&error) {
                let radius = real(&exact(ball.radius), self.bits);
                outcome.ratios.push(float(&(radius / error)));
            }
            let printed = decimal(ball, asked.digits);
            let text = printed.text.trim_start_matches('-');
            let Some((number, shown)) = read(text) else {
                outcome.fewer.push(0);
                continue;
            };
            match printed.rounding {
                Rounding::Correct | Rounding::Tie => {}
                Rounding::Fewer => outcome.fewer.push(shown),
                Rounding::Undecided => {
                    outcome.fewer.push(0);
                    continue;
                }
            }
            let truth = absolute(ratio(truth));
            if !is_rounded(&number, &truth, shown, printed.rounding) {
                let message = format!(
                    "{name} `{}` ({:?}), true {}",
                    printed.text,
                    printed.rounding,
                    digits(&real(&truth, self.bits))
                );
                outcome.wrong(Wrong::Digit, message);
            }
        }
    }

    /// Each shape against the vectors of the exponents of its cluster; and whether the shapes of an exponent span
    /// as many dimensions as it has vectors.
    fn shapes(&self, modes: &[NormalMode], pairs: &[usize], outcome: &mut Outcome) {
        let n = self.scaled.lengths.len();
        for (index, mode) in modes.iter().enumerate() {
            let bound = mode.vector_error_bound;
            outcome.loose_shapes += usize::from(bound.is_nan() || bound > 1e-9);
            if !bound.is_finite() {
                continue;
            }
            let cluster = modes.iter().zip(pairs).filter(|(m, _)| m.cluster == mode.cluster);
            let mut own: Vec<usize> = cluster.map(|(_, e)| self.entries[*e].root).collect();
            own.sort_unstable();
            own.dedup();
            let kernel = own.iter().flat_map(|root| &self.roots[*root].kernel);
            let least = real(&power_of_ten(-6 - self.scaled.spread()), self.bits);
            let basis = orthonormal(kernel.map(|x| self.in_text(x)), &least, self.bits);
            let x = self.shape(mode);
            let size = float(&length(&x, self.bits));
            let rest = length(&without(x, &basis), self.bits);
            // What the reference itself may be off by.
            let slack = size * 2f64.powi(-(AWAY as i32));
            let allowed = (bound + slack) * (n as f64).sqrt();
            if float(&rest) > allowed * (1.0 + 1e-9) {
                let message = format!(
                    "shape {} is {:e} from the space of its exponent, bound {bound:e}",
                    index + 1,
                    float(&rest)
                );
                outcome.wrong(Wrong::Shape, message);
            }
        }
        for (index, root) in self.roots.iter().enumerate() {
            let own = |e: &usize| self.entries[*e].root == index;
            let members: Vec<&NormalMode> = modes
                .iter()
                .zip(pairs)
                .filter(|(mode, e)| own(e) && self.is_certain(mode))
                .map(|(mode, _)| mode)
                .collect();
            // Below the number of vectors, something is missing.
            let full = pairs.iter().filter(|e| own(e)).count() == members.len();
            let vectors = members.iter().flat_map(|mode| {
                let x = self.in_pencil(&self.shape(mode));
                let size = length(&x, self.bits);
                let of = |z: Real| Complex::new(z / &size, integer(0, self.bits));
                let whole = |z: &Complex| Complex::new(&z.re / &size, &z.im / &size);
                if root.is_real() {
                    // Without friction two motions at 0 may be one entry: real and imaginary part.
                    let re = x.iter().map(|z| of(z.re.clone())).collect();
                    let im = x.iter().map(|z| of(z.im.clone())).collect();
                    vec![re, im]
                } else {
                    vec![x.iter().map(whole).collect()]
                }
            });
            let least = real(&power_of_ten(-6), self.bits);
            let spanned = orthonormal(vectors, &least, self.bits).len();
            if full && !members.is_empty() && spanned < root.kernel.len() {
                let message = format!(
                    "{} shapes of {:e} {:e} span {spanned} of {} dimensions",
                    members.len(),
                    float(&root.value.re),
                    float(&root.value.im),
                    root.kernel.len()
                );
                outcome.wrong(Wrong::Shape, message);
            }
        }
    }

    fn shape(&self, mode: &NormalMode) -> Vec<Complex> {
        let number = |x: f64| real(&exact(x), self.bits);
        let imaginary = |i: usize| mode.imaginary.get(i).copied().unwrap_or(0.0);
        let parts = mode.vector.iter().enumerate();
        parts.map(|(i, x)| Complex::new(number(*x), number(imaginary(i)))).collect()
    }

    /// Whether all components of a shape are worth their bound.
    fn is_certain(&self, mode: &NormalMode) -> bool {
        let sizes = mode.vector.iter().map(|x| x.abs());
        mode.vector_error_bound < 1e-6 * sizes.fold(0.0, f64::max)
    }

    /// A vector of the pencil in the text's coordinates.
    fn in_text(&self, x: &[Complex]) -> Vec<Complex> {
        self.times_units(x, -1)
    }

    /// The way back.
    fn in_pencil(&self, x: &[Complex]) -> Vec<Complex> {
        self.times_units(x, 1)
    }

    fn times_units(&self, x: &[Complex], power: i64) -> Vec<Complex> {
        let parts = x.iter().zip(&self.scaled.lengths);
        parts
            .map(|(x, length)| {
                let unit = real(&power_of_ten(power * length), self.bits);
                Complex::new(&x.re * &unit, &x.im * &unit)
            })
            .collect()
    }
}

fn placed(mode: usize, fits: &[Vec<usize>], owner: &mut [Option<usize>], seen: &mut [bool]) -> bool {
    for &entry in &fits[mode] {
        if std::mem::replace(&mut seen[entry], true) {
            continue;
        }
        if owner[entry].is_none_or(|other| placed(other, fits, owner, seen)) {
            owner[entry] = Some(mode);
            return true;
        }
    }
    false
}

fn inner(a: &[Complex], b: &[Complex]) -> Option<Complex> {
    let products = a.iter().zip(b).map(|(x, y)| x.conjugate().times(y));
    products.reduce(|a, b| Complex::new(a.re + b.re, a.im + b.im))
}

fn length(x: &[Complex], bits: usize) -> Real {
    let sum = x.iter().fold(integer(0, bits), |s, x| s + x.square());
    sqrt(&sum)
}

fn without(mut x: Vec<Complex>, basis: &[Vec<Complex>]) -> Vec<Complex> {
    for b in basis {
        let Some(part) = inner(b, &x) else { continue };
        for (x, b) in x.iter_mut().zip(b) {
            let product = part.times(b);
            x.re -= product.re;
            x.im -= product.im;
        }
    }
    x
}

/// An orthonormal basis of what the vectors span, but for what is less than some part of them.
fn orthonormal(vectors: impl Iterator<Item = Vec<Complex>>, least: &Real, bits: usize) -> Vec<Vec<Complex>> {
    let mut basis: Vec<Vec<Complex>> = Vec::new();
    for x in vectors {
        let before = length(&x, bits);
        if is_zero(&before) {
            continue;
        }
        let x = without(x, &basis);
        let size = length(&x, bits);
        if is_zero(&size) || &size / before < *least {
            continue;
        }
        let part = |z: &Complex| Complex::new(&z.re / &size, &z.im / &size);
        basis.push(x.iter().map(part).collect());
    }
    basis
}
