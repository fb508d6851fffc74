//! One model: the whole trip, and what it claims held against the reference.

use std::time::Duration;

use dashu_ratio::RBig;
use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::{Kind, Options, Stability};
use librate::oscillation::{NormalMode, NormalModes, normal_modes};
use librate::precision::{Ball, Rounding, decimal};
use librate::syntax::parse;

use crate::clock::of_thread;
use crate::digits::{absolute, digits, read, round};
use crate::draw::power_of_ten;
use crate::exponents;
use crate::kinds::{Derivatives, Model, Reference};
use crate::real::*;
use crate::reference::{AWAY, BITS, Factors, Matrices, Square, Truth, inner, times, to_reals};

/// What is wrong with a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Wrong {
    /// A frequency, rate of growth or ω² outside its bound.
    Bound,
    /// A printed digit.
    Digit,
    /// The number of zero modes.
    Zeros,
    /// The kind of a mode, or the stability.
    Kind,
    /// A shape outside its bound.
    Shape,
    /// The place of the equilibrium outside its bound.
    Equilibrium,
    /// An equilibrium that is there but was not found.
    Lost,
    /// No result otherwise, or no reference.
    Error,
}

/// All of them, as columns of a table are called.
pub(crate) const WRONGS: [(Wrong, &str); 8] = [
    (Wrong::Bound, "bound!"),
    (Wrong::Digit, "digit!"),
    (Wrong::Zeros, "zeros!"),
    (Wrong::Kind, "kind!"),
    (Wrong::Shape, "shape!"),
    (Wrong::Equilibrium, "place!"),
    (Wrong::Lost, "lost!"),
    (Wrong::Error, "error!"),
];

/// What came of one model.
#[derive(Default)]
pub(crate) struct Outcome {
    pub(crate) violations: Vec<(Wrong, String)>,
    pub(crate) coordinates: usize,
    /// Frequencies and rates of growth that were checked.
    pub(crate) numbers: usize,
    /// Those of them with fewer digits than asked for, and how many digits these had.
    pub(crate) fewer: Vec<usize>,
    pub(crate) undecided: usize,
    pub(crate) zeros: usize,
    pub(crate) ties: usize,
    /// Bound over true error of every number, the error taken to be at least half a unit of a
    /// double-double: below that a ratio tells nothing.
    pub(crate) ratios: Vec<f64>,
    /// Shapes whose bound is worse than 1e-9.
    pub(crate) loose_shapes: usize,
    pub(crate) cpu: Duration,
}

impl Outcome {
    pub(crate) fn wrong(&mut self, wrong: Wrong, message: String) {
        self.violations.push((wrong, message));
    }
}

/// What is asked for.
#[derive(Clone, Copy)]
pub(crate) struct Asked {
    pub(crate) digits: usize,
    pub(crate) vectors: bool,
    pub(crate) lowest: Option<usize>,
}

const LOST: &str = "no equilibrium was found";

fn trip(model: &Model, asked: &Asked) -> Result<(Vec<Ball>, NormalModes), String> {
    let said = |errors: Vec<String>| errors.join("; ");
    let tables = model.tables.iter().cloned();
    let tables = tables.fold(TableTexts::new(), |tables, (name, text)| tables.with(name, text));
    let file = parse(&model.text).map_err(|errors| said(errors.iter().map(ToString::to_string).collect()))?;
    let elaborated = elaborate(&file, &tables, &Settings::new())
        .map_err(|errors| said(errors.iter().map(ToString::to_string).collect()))?;
    let linearized = linearize(elaborated).map_err(|error| error.to_string())?;
    let mut options = Options::default().digits(asked.digits);
    options.vectors = asked.vectors;
    options.lowest = asked.lowest.filter(|_| !matches!(model.reference, Reference::Exponents(_)));
    let modes = normal_modes(&linearized, &options).map_err(|error| error.to_string())?;
    Ok((linearized.equilibrium().values.clone(), modes))
}

pub(crate) fn check(model: &Model, asked: &Asked) -> Outcome {
    let mut outcome = Outcome::default();
    let start = of_thread();
    let result = trip(model, asked);
    outcome.cpu = of_thread().saturating_sub(start);
    let (point, modes) = match result {
        Ok(result) => result,
        Err(message) => {
            // Every model has an equilibrium, most but not all near where the search starts.
            outcome.wrong(if message == LOST { Wrong::Lost } else { Wrong::Error }, message);
            return outcome;
        }
    };
    outcome.coordinates = point.len();
    let mut bits = BITS;
    loop {
        let mut attempt = Outcome { coordinates: outcome.coordinates, cpu: outcome.cpu, ..Outcome::default() };
        let judged = if let Reference::Exponents(scaled) = &model.reference {
            exponents::judge(scaled, &modes, asked, bits, &mut attempt)
        } else {
            Judge::new(model, &point, bits, &mut attempt).and_then(|judge| judge.judge(&modes, asked, &mut attempt))
        };
        if judged.is_some() {
            return attempt;
        }
        if bits >= 8 * BITS {
            outcome.wrong(Wrong::Error, format!("the reference is ambiguous at {bits} bits"));
            return outcome;
        }
        bits *= 2;
    }
}

/// The reference at some number of bits.
struct Judge {
    bits: usize,
    matrices: Matrices,
    truth: Truth,
}

/// The equilibrium next to the found one, to all bits.
fn pinned(mass: &Square, derivatives: &Derivatives, found: &[Ball], bits: usize) -> Option<Vec<Real>> {
    let mut x: Vec<Real> = found.iter().map(|ball| centre(ball, bits)).collect();
    for _ in 0..40 {
        let (gradient, stiffness) = derivatives(&x, bits);
        let matrices = Matrices { mass: mass.clone(), stiffness };
        let factors = Factors::new(&matrices, &integer(0, bits), bits)?;
        let step = factors.solve(&gradient);
        let size = x.iter().map(log2).max().unwrap_or(0);
        let moved = step.iter().map(log2).max().unwrap_or(0);
        for (x, step) in x.iter_mut().zip(&step) {
            *x -= step;
        }
        // Another step would square this.
        if moved < size.max(-100) - bits as isize * 5 / 8 {
            return Some(x);
        }
    }
    None
}

pub(crate) fn centre(ball: &Ball, bits: usize) -> Real {
    real(&(exact(ball.mid.hi) + exact(ball.mid.lo)), bits)
}

/// Whether |value - centre| is within the radius, up to what the reference itself may be off by.
pub(crate) fn within(value: &Real, ball: &Ball, bits: usize) -> bool {
    let error = abs(&(value - centre(ball, bits)));
    let slack = scale(&abs(value), -AWAY);
    !ball.is_finite() || error <= real(&exact(ball.radius), bits) + slack
}

/// Whether a number is the true one, rounded to so many digits.
pub(crate) fn is_rounded(number: &RBig, truth: &RBig, digits: usize, rounding: Rounding) -> bool {
    let (rounded, place) = round(truth, digits);
    let place = power_of_ten(place);
    let off = absolute(number - truth);
    // At a tie both neighbours are as good to a reference that is a little off.
    let tie = absolute(&off - &place / RBig::from(2)) <= &place * power_of_ten(-60);
    rounded == *number || tie || rounding == Rounding::Tie && off <= place
}

impl Judge {
    fn new(model: &Model, point: &[Ball], bits: usize, outcome: &mut Outcome) -> Option<Self> {
        let matrices = match &model.reference {
            Reference::Exact { mass, stiffness } => {
                Matrices { mass: to_reals(mass, bits), stiffness: to_reals(stiffness, bits) }
            }
            Reference::Real(matrices) => matrices(bits),
            Reference::Exponents(_) => return None,
            Reference::Searched(mass, derivatives) => {
                let mass = to_reals(mass, bits);
                let x = pinned(&mass, derivatives, point, bits)?;
                for (i, (x, ball)) in x.iter().zip(point).enumerate() {
                    if !within(x, ball, bits) {
                        let message =
                            format!("coordinate {}: {ball:?} is off by {:e}", i + 1, float(&(x - centre(ball, bits))));
                        outcome.wrong(Wrong::Equilibrium, message);
                    }
                }
                Matrices { mass, stiffness: derivatives(&x, bits).1 }
            }
        };
        let truth = Truth::new(&matrices, bits)?;
        Some(Self { bits, matrices, truth })
    }

    /// `None`: more bits are needed.
    fn judge(&self, modes: &NormalModes, asked: &Asked, outcome: &mut Outcome) -> Option<()> {
        let n = self.truth.values.len();
        let count = asked.lowest.unwrap_or(n).min(n);
        if modes.modes.len() != count {
            outcome.wrong(Wrong::Error, format!("{} modes instead of {count}", modes.modes.len()));
            return Some(());
        }
        let positions = self.positions(modes, outcome)?;
        self.stability(modes, outcome);
        for (mode, &position) in modes.modes.iter().zip(&positions) {
            self.number(mode, position, asked, outcome)?;
        }
        if asked.vectors {
            self.shapes(&modes.modes, &positions, outcome)?;
        }
        Some(())
    }

    /// Which true eigenvalue each mode stands for: proved zeros are taken out, the others pair off in
    /// order.
    fn positions(&self, modes: &NormalModes, outcome: &mut Outcome) -> Option<Vec<usize>> {
        let is_zero = |k: &usize| Some(self.truth.group[*k]) == self.truth.zero;
        let all = 0..self.truth.values.len();
        let mut zeros = all.clone().filter(is_zero).collect::<Vec<_>>().into_iter();
        let claimed = modes.modes.iter().filter(|m| m.kind == Kind::Zero).count();
        outcome.zeros = claimed;
        let cut =
            modes.modes.len() < self.truth.values.len() && modes.modes.last().is_some_and(|m| m.kind == Kind::Zero);
        let ends_before =
            modes.modes.len() < self.truth.values.len() && modes.modes.last().is_some_and(|m| m.kind == Kind::Unstable);
        let true_zeros = self.truth.zeros();
        if claimed > true_zeros || claimed < true_zeros && !cut && !ends_before {
            outcome.wrong(Wrong::Zeros, format!("{claimed} zero modes instead of {true_zeros}"));
        }
        let mut proved: Vec<usize> = zeros.by_ref().take(claimed).collect();
        let taken = if cut { true_zeros } else { proved.len() };
        let mut skip = taken;
        let mut others = all.filter(|k| {
            let skipped = skip > 0 && is_zero(k);
            skip -= usize::from(skipped);
            !skipped
        });
        // More zeros than there are: nothing pairs off any more.
        if claimed > true_zeros {
            return Some((0..modes.modes.len()).collect());
        }
        proved.reverse();
        modes.modes.iter().map(|mode| if mode.kind == Kind::Zero { proved.pop() } else { others.next() }).collect()
    }

    fn stability(&self, modes: &NormalModes, outcome: &mut Outcome) {
        let unstable = self.truth.values.iter().any(is_negative);
        let right = match modes.stability {
            Stability::Unstable => unstable,
            Stability::Stable => !unstable && self.truth.zero.is_none(),
            Stability::Neutral => !unstable && self.truth.zero.is_some(),
            _ => true,
        };
        if !right {
            outcome.wrong(Wrong::Kind, format!("{} is wrong", modes.stability.as_str()));
        }
    }

    fn number(&self, mode: &NormalMode, position: usize, asked: &Asked, outcome: &mut Outcome) -> Option<()> {
        let bits = self.bits;
        let value = &self.truth.values[position];
        let name = format!("eigenvalue {}", position + 1);
        let right = match mode.kind {
            Kind::Zero => is_zero(value),
            Kind::Oscillation => !is_zero(value) && !is_negative(value),
            Kind::Unstable => is_negative(value),
            _ => true,
        };
        if !right {
            outcome.wrong(Wrong::Kind, format!("{name}, {:e}, is no {}", float(value), mode.kind.as_str()));
        }
        // Models without friction have a square.
        let square = &mode.omega_squared?;
        if !within(value, square, bits) {
            outcome.wrong(Wrong::Bound, format!("{name}: ω² {square:?}, true {}", digits(value)));
        }
        match mode.kind {
            Kind::Zero => return Some(()),
            Kind::Oscillation | Kind::Unstable => {}
            _ => {
                outcome.undecided += 1;
                let radius = real(&exact(square.radius), bits);
                let square = centre(square, bits);
                return self.count(&(&square - &radius), &(square + radius), position, outcome);
            }
        }
        let unstable = mode.kind == Kind::Unstable;
        let ball = if unstable { &mode.growth } else { &mode.omega };
        let root = sqrt(&abs(value));
        outcome.numbers += 1;
        let error = abs(&(&root - centre(ball, bits)));
        if !within(&root, ball, bits) {
            outcome.wrong(Wrong::Bound, format!("{name}: {ball:?}, true {}", digits(&root)));
        }
        let floor = scale(&root, -107);
        let radius = real(&exact(ball.radius), bits);
        outcome.ratios.push(float(&(&radius / larger(error, floor))));
        // The same by counting, from both ends of the printed interval.
        let middle = centre(ball, bits);
        let least = larger(&middle - &radius, integer(0, bits));
        let most = middle + radius;
        let (least, most) = (&least * &least, &most * &most);
        if unstable {
            self.count(&-most, &-least, position, outcome)?;
        } else {
            self.count(&least, &most, position, outcome)?;
        }
        self.printed(&name, ball, &root, asked.digits, outcome);
        Some(())
    }

    /// Whether the eigenvalue with this position lies between the ends, by counting those below.
    fn count(&self, least: &Real, most: &Real, position: usize, outcome: &mut Outcome) -> Option<()> {
        let bits = self.bits;
        let least = least - scale(&abs(least), -AWAY);
        let most = most + scale(&abs(most), -AWAY);
        let below = |shift: &Real| {
            if is_zero(shift) {
                let before = self.truth.values.iter().filter(|x| is_negative(x)).count();
                return Some((before, before + self.truth.zeros()));
            }
            let count = Factors::new(&self.matrices, shift, bits)?.below();
            Some((count, count))
        };
        let (before, _) = below(&least)?;
        let (_, after) = below(&most)?;
        if before > position || after <= position {
            let message = format!(
                "eigenvalue {} is not between {:e} and {:e}: {before} lie below, {after} below the upper end",
                position + 1,
                float(&least),
                float(&most)
            );
            outcome.wrong(Wrong::Bound, message);
        }
        Some(())
    }

    fn printed(&self, name: &str, ball: &Ball, root: &Real, asked: usize, outcome: &mut Outcome) {
        let printed = decimal(ball, asked);
        let truth = ratio(root);
        let Some((number, shown)) = read(&printed.text) else {
            outcome.wrong(Wrong::Digit, format!("{name}: `{}` is no number", printed.text));
            return;
        };
        match printed.rounding {
            Rounding::Correct | Rounding::Tie => {
                if shown != asked {
                    outcome.wrong(Wrong::Digit, format!("{name}: {} has not {asked} digits", printed.text));
                }
            }
            Rounding::Fewer => outcome.fewer.push(shown),
            Rounding::Undecided => {
                outcome.fewer.push(0);
                return;
            }
        }
        outcome.ties += usize::from(printed.rounding == Rounding::Tie);
        let right = is_rounded(&number, &truth, shown, printed.rounding);
        let bound = exact(printed.error_bound) * (RBig::ONE + power_of_ten(-15));
        if !right || absolute(number - truth) > bound {
            let message = format!(
                "{name}: `{}` ({:?}, bound {:e}), true {}",
                printed.text,
                printed.rounding,
                printed.error_bound,
                digits(root)
            );
            outcome.wrong(Wrong::Digit, message);
        }
    }

    /// Each shape against its projection on the exact eigenspaces of its cluster, component by
    /// component for a mode of its own; and whether shapes of a cluster are orthonormal.
    fn shapes(&self, modes: &[NormalMode], positions: &[usize], outcome: &mut Outcome) -> Option<()> {
        let bits = self.bits;
        let m = &self.matrices.mass;
        let total = m.iter().flatten().fold(integer(0, bits), |s, x| s + abs(x));
        let length = sqrt(&total);
        let mut projectors: Vec<(usize, Real, Factors)> = Vec::new();
        let mut start = 0;
        for members in modes.chunk_by(|a, b| a.cluster == b.cluster) {
            let end = start + members.len();
            // Of a cluster at the end of what `lowest` asks for, members may be out of sight.
            let cut = end == modes.len() && modes.len() < self.truth.values.len();
            let mut groups: Vec<usize> = positions[start..end].iter().map(|k| self.truth.group[*k]).collect();
            groups.dedup();
            projectors.retain(|(group, _, _)| groups.contains(group));
            for &group in &groups {
                if projectors.iter().all(|(known, _, _)| *known != group) {
                    let k = self.truth.group.iter().position(|g| *g == group)?;
                    let shift = self.truth.beside(k, bits);
                    let factors = Factors::new(&self.matrices, &shift, bits)?;
                    projectors.push((group, &self.truth.values[k] - shift, factors));
                }
            }
            let mut images = Vec::new();
            for mode in members {
                let x: Vec<Real> = mode.vector.iter().map(|x| real(&exact(*x), bits)).collect();
                let image = times(m, &x, bits);
                let bound = mode.vector_error_bound;
                outcome.loose_shapes += usize::from(bound.is_nan() || bound > 1e-9);
                if bound.is_finite() && !cut {
                    let mut projected = vec![integer(0, bits); x.len()];
                    for (_, offset, factors) in &projectors {
                        // (K - σM)⁻¹M x times λ - σ leaves the part in the eigenspace of λ.
                        for (sum, y) in projected.iter_mut().zip(factors.solve(&image)) {
                            *sum += y * offset;
                        }
                    }
                    let allowed = real(&exact(bound), bits);
                    // What is rounded here lies within half of the digits.
                    let largest = x.iter().map(abs).fold(integer(0, bits), larger);
                    let slack = scale(&allowed, -40) + scale(&largest, -(bits as isize) / 2);
                    // Where the exact eigenvalue is repeated, no single vector can be meant.
                    let repeated = self.truth.group.iter().filter(|g| groups.contains(g)).count();
                    if members.len() == 1 && repeated == 1 {
                        let norm = sqrt(&inner(&projected, &times(m, &projected, bits), bits));
                        let worst =
                            x.iter().zip(&projected).map(|(x, y)| abs(&(x - y / &norm))).fold(integer(0, bits), larger);
                        if worst > &allowed + slack {
                            let message = format!(
                                "shape of eigenvalue {}: off by {:e}, bound {bound:e}",
                                positions[start] + 1,
                                float(&worst)
                            );
                            outcome.wrong(Wrong::Shape, message);
                        }
                    } else {
                        let rest: Vec<Real> = x.iter().zip(&projected).map(|(x, y)| x - y).collect();
                        let away = sqrt(&abs(&inner(&rest, &times(m, &rest, bits), bits)));
                        if away > &length * (&allowed + slack) {
                            let message = format!(
                                "shape in the cluster of eigenvalue {}: M-distance {:e}, bound {bound:e}",
                                positions[start] + 1,
                                float(&(away / &length))
                            );
                            outcome.wrong(Wrong::Shape, message);
                        }
                    }
                }
                images.push((x, image));
            }
            self.orthonormal(&images, members, positions[start], outcome);
            start = end;
        }
        Some(())
    }

    /// Promised within a cluster; doubles can hold it to their rounding.
    fn orthonormal(
        &self,
        images: &[(Vec<Real>, Vec<Real>)],
        modes: &[NormalMode],
        position: usize,
        outcome: &mut Outcome,
    ) {
        let bits = self.bits;
        for (a, (x, _)) in images.iter().enumerate() {
            for (b, (y, image)) in images.iter().enumerate().take(a + 1) {
                let unit = integer(i64::from(a == b), bits);
                let off = abs(&(inner(x, image, bits) - unit));
                let size = self.rounding(x, y);
                let bound = modes[a].vector_error_bound.max(modes[b].vector_error_bound);
                // Relative to the largest component, a bound below rounding says nothing here.
                let largest = x.iter().chain(y).map(|x| float(x).abs()).fold(0.0, f64::max);
                let relative = bound / largest + 2.0_f64.powi(-50);
                if float(&off) > 4.0 * relative * size {
                    let message = format!(
                        "shapes {} and {} of the cluster of eigenvalue {}: xᵀMy is off by {:e}",
                        a + 1,
                        b + 1,
                        position + 1,
                        float(&off)
                    );
                    outcome.wrong(Wrong::Shape, message);
                }
            }
        }
    }

    /// Σ |M_ij| |x|max |y|max: what one relative error of the largest components changes xᵀMy by.
    fn rounding(&self, x: &[Real], y: &[Real]) -> f64 {
        let top = |v: &[Real]| v.iter().map(|x| float(x).abs()).fold(0.0, f64::max);
        let sum: f64 = self.matrices.mass.iter().flatten().map(|m| float(m).abs()).sum();
        (sum * top(x) * top(y)).max(1.0)
    }
}
