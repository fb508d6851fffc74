//! Closed forms for special values of a parameter, and their series in a small one.

use std::collections::BTreeSet;

use hashbrown::HashMap;

use super::exponents::{ClosedExponent, Exponents};
use super::frequencies::{Approximation, Case, Frequencies, Frequency};
use super::roots::{best_to_read, factors, of_polynomial, root, without_zeros};
use super::simplify::{Algebra, bases_with, rebuild};
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol, Tape, ZeroVerdict, evaluate_closed};
use crate::number::Number;
use crate::precision::Function;

/// The highest power of a series.
const MOST_ORDERS: u32 = 12;

/// A limit or a series in a symbol, and the values of the parameters there.
#[derive(Clone, Copy)]
struct Special<'a> {
    done: &'a Approximation,
    symbol: Symbol,
    values: &'a [(Symbol, f64)],
}

impl Approximation {
    fn name(&self) -> &str {
        match self {
            Self::Limit { name, .. } | Self::Expansion { name, .. } => name,
        }
    }

    /// What an expression is where the parameter goes to a value, or its series by Taylor's formula about 0; undefined where it has none.
    fn of(&self, pool: &mut Algebra<'_>, e: ExprId, symbol: Symbol) -> ExprId {
        match self {
            Self::Limit { value, .. } => {
                let value = pool.adopted(value.pool(), value.value());
                pool.substitute_one(e, &Substitution::from([(symbol, value)]))
            }
            Self::Expansion { order, .. } => series(pool, e, symbol, *order),
        }
    }
}

fn series(pool: &mut Algebra<'_>, e: ExprId, symbol: Symbol, order: u32) -> ExprId {
    let coefficients = taylor(pool, e, symbol, order);
    let is_root = |(_, exponent): &(ExprId, Number)| !exponent.is_integer();
    let front = coefficients.first().copied().filter(|own| match pool.terms(*own).as_slice() {
        [(term, _)] => pool.factors(*term).iter().any(is_root),
        _ => false,
    });
    let Some(front) = front else { return polynomial(pool, coefficients, symbol) };
    let ratios = coefficients.iter().map(|own| {
        let ratio = pool.short(|pool| pool.div(*own, front));
        best_to_read(pool, ratio)
    });
    let ratios: Vec<ExprId> = ratios.collect();
    // A root that all have stands in front; that of a sum does whatever its sign: √f and √(1/f) in one sum would be one of them times ±1.
    let has_sum = |own: &(ExprId, Number)| is_root(own) && pool.factors(own.0).iter().any(|(own, _)| pool.is_sum(*own));
    let has_root = |own: &ExprId| pool.terms(*own).iter().any(|(term, _)| pool.factors(*term).iter().any(is_root));
    if !pool.factors(front).iter().any(has_sum) && ratios.iter().any(has_root) {
        return polynomial(pool, coefficients, symbol);
    }
    let series = polynomial(pool, ratios, symbol);
    pool.mul(front, series)
}

/// The coefficients of the powers of a symbol about 0, undefined from the first that does not exist.
fn taylor(pool: &mut Algebra<'_>, e: ExprId, symbol: Symbol, order: u32) -> Vec<ExprId> {
    let at_zero = Substitution::from([(symbol, pool.zero())]);
    let (mut derivative, mut factorial) = (e, Number::ONE);
    let coefficients = (0..=order.min(MOST_ORDERS)).map(|power| {
        if power > 0 {
            derivative = pool.diff(derivative, symbol);
            factorial = factorial.mul(&Number::from(i64::from(power)));
        }
        let value = pool.substitute_one(derivative, &at_zero);
        let inverse = pool.number(factorial.recip().unwrap_or_default());
        let value = pool.mul(value, inverse);
        let value = pool.simplify(value);
        best_to_read(pool, value)
    });
    coefficients.collect()
}

/// The polynomial in a symbol with these coefficients, the constant first.
fn polynomial(pool: &mut Algebra<'_>, coefficients: impl IntoIterator<Item = ExprId>, symbol: Symbol) -> ExprId {
    let variable = pool.symbol_expr(symbol);
    let terms = coefficients.into_iter().zip(0..).map(|(own, power)| {
        let power = pool.powi(variable, power);
        (pool.mul(own, power), Number::ONE)
    });
    let terms: Vec<(ExprId, Number)> = terms.collect();
    pool.linear(&terms)
}

/// The symbol of a name that some expressions depend on.
fn symbol(pool: &Algebra<'_>, all: &[ExprId], name: &str) -> Option<Symbol> {
    pool.symbols_of(all).into_iter().find(|symbol| pool.symbol_name(*symbol) == name)
}

/// Expressions where parameters are equal, or the opposite of each other: in the first one of each set.
fn tied(pool: &mut Algebra<'_>, ties: &[Vec<String>], all: &[ExprId]) -> Vec<ExprId> {
    let mut known = Substitution::new();
    for set in ties {
        let Some(first) = set.first().and_then(|name| symbol(pool, all, name)) else { continue };
        let first = pool.symbol_expr(first);
        for name in &set[1..] {
            let (name, is_opposite) = name.strip_prefix('-').map_or((name.as_str(), false), |name| (name, true));
            if let Some(own) = symbol(pool, all, name) {
                known.insert(own, if is_opposite { pool.neg(first) } else { first });
            }
        }
    }
    pool.substitute(all, &known)
}

impl Frequencies {
    /// The frequencies for a special value of a parameter, `--limit k=0`, or to some power of it, `--expand k 2`. Where forms are not defined
    /// there, the zeros of the characteristic polynomial that stay finite stand for all.
    pub(super) fn approximate(
        &mut self,
        pool: &mut Algebra<'_>,
        done: &Approximation,
        characteristic: Option<&[ExprId]>,
        values: &[(Symbol, f64)],
    ) {
        // Where all is known without equalities, one that the parameter would have to drag along says nothing of this limit.
        let drags = |tied: &Case| tied.ties.iter().flatten().any(|own| own == done.name());
        if !self.general.complete
            && self.tied.as_ref().is_some_and(drags)
            && let Some(all) = characteristic
            && let Some(found) =
                symbol(pool, all, done.name()).and_then(|symbol| finite(pool, all, Special { done, symbol, values }))
        {
            self.general.frequencies = found;
            self.tied = None;
        }
        if self.general.complete {
            self.tied.take_if(|tied| drags(tied));
        }
        // Nor does one with the opposite of it.
        let opposes =
            |tied: &mut Case| tied.ties.iter().flatten().any(|own| own.strip_prefix('-') == Some(done.name()));
        self.tied.take_if(opposes);
        for case in [Some(&mut self.general), self.tied.as_mut()].into_iter().flatten() {
            // Where several are equal the first stands for all.
            let set = case.ties.iter().find(|set| set.iter().any(|own| own == done.name()));
            let leader = set.and_then(|set| set.first()).map_or(done.name(), String::as_str);
            let all: Vec<ExprId> = case.frequencies.iter().map(|f| f.omega_squared).collect();
            if let Some(symbol) = symbol(pool, &all, leader) {
                let cost = |pool: &mut Algebra<'_>, all: &[Frequency]| {
                    pool.cost(&all.iter().map(|own| own.omega_squared).collect::<Vec<_>>())
                };
                let plain = case.frequencies.iter().all(|own| own.symmetry.is_none());
                let before = case.known();
                let is_series = matches!(done, Approximation::Expansion { .. });
                transform_case(pool, case, (values, is_series), |pool, e| {
                    let is_open = is_series && is_branching(pool, &[e], symbol, values);
                    if is_open { pool.undefined() } else { done.of(pool, e, symbol) }
                });
                let is_short = case.known() < before;
                let found = characteristic.filter(|_| is_short || is_series && plain);
                let found = found.and_then(|all| {
                    let all = tied(pool, &case.ties, all);
                    finite(pool, &all, Special { done, symbol, values })
                });
                if let Some(found) = found
                    && found.iter().all(|own| !divides_by_zero(pool, &[own.omega_squared], values))
                    && (is_short || found.len() == before && cost(pool, &found) < cost(pool, &case.frequencies))
                {
                    case.frequencies = found;
                }
            }
        }
        self.approximations.push(done.clone());
    }
}

/// Whether a polynomial is one in the square.
fn is_even(characteristic: &[ExprId]) -> bool {
    characteristic.iter().skip(1).step_by(2).all(|odd| odd.is_zero())
}

impl Exponents {
    /// Those that belong to limits of frequencies.
    pub(super) fn of_limit(self, pool: &mut Algebra<'_>, case: &Case, done: &Approximation) -> Self {
        let Self { values, mut approximations, .. } = self;
        approximations.push(done.clone());
        let mut own = Self { complete: case.complete, values, approximations, ..Self::default() };
        own.values = done.there(pool, &own.values);
        own.add_squares(pool, &case.frequencies);
        own
    }

    /// The exponents that stay finite in a limit, where their polynomial is one in s² there or has factors of degree two: its degree may fall.
    fn finite(&self, pool: &mut Algebra<'_>, at: Special<'_>) -> Option<Vec<ClosedExponent>> {
        let characteristic = self.characteristic.as_ref()?;
        let mut own = Self { values: at.values.to_vec(), ..Self::default() };
        let at_limit = at.done.polynomial(pool, characteristic, at.symbol);
        if is_even(&at_limit) {
            let squares = finite(pool, characteristic, at)?;
            own.add_squares(pool, &squares);
            return Some(own.exponents);
        }
        let zeros = at_limit.iter().take_while(|own| pool.vanishes(**own)).count();
        let zero = pool.zero();
        if zeros > 0 {
            own.add(ClosedExponent::on_axis(pool, zero, true, zeros));
        }
        for (factor, multiplicity) in factors(pool, at_limit.get(zeros..)?) {
            let (middle, square) = match factor[..] {
                [b, a] => (pool.div(b, a), zero),
                [c, b, a] => {
                    let (middle, product) = (pool.div(b, a), pool.div(c, a));
                    let middle = pool.scale(middle, &Number::half());
                    let square = pool.square(middle);
                    (middle, pool.short(|pool| pool.sub(square, product)))
                }
                _ => continue,
            };
            let middle = pool.short(|pool| pool.neg(middle));
            let (square, oscillates) = positive_at(pool, square, at.values);
            let (size, _) = root(pool, square);
            for x in [size, pool.neg(size)].into_iter().take(factor.len() - 1) {
                let [real, imaginary] = if oscillates { [middle, x] } else { [pool.add(middle, x), zero] };
                own.add(ClosedExponent { real, imaginary, multiplicity, damping_ratio: None });
            }
        }
        Some(own.exponents)
    }

    /// Adds the pairs of some frequencies.
    fn add_squares(&mut self, pool: &mut Algebra<'_>, frequencies: &[Frequency]) {
        for Frequency { omega_squared, multiplicity, .. } in frequencies {
            let (square, grows) = positive_at(pool, *omega_squared, &self.values);
            let (size, _) = root(pool, square);
            for x in [size, pool.neg(size)] {
                self.add(ClosedExponent::on_axis(pool, x, grows, *multiplicity));
            }
        }
    }

    /// The same of the exponents; what else is known of the whole model is left out then.
    pub(super) fn approximate(&mut self, pool: &mut Algebra<'_>, done: &Approximation) {
        let all: Vec<ExprId> = self.exponents.iter().flat_map(|own| [own.real, own.imaginary]).collect();
        let with_polynomial: Vec<ExprId> = all.iter().chain(self.characteristic.iter().flatten()).copied().collect();
        if let Some(symbol) = symbol(pool, &with_polynomial, done.name()) {
            let known = |all: &[ClosedExponent]| all.iter().map(|own| own.multiplicity).sum::<usize>();
            let count = self.characteristic.as_ref().map_or(known(&self.exponents), |all| all.len() - 1);
            let undamped = self.characteristic.as_ref().is_none_or(|all| is_even(all))
                && self.exponents.iter().all(|own| own.real.is_zero());
            let magnitudes = magnitudes_in(pool, &all);
            let is_series = matches!(done, Approximation::Expansion { .. });
            self.exponents
                .retain(|own| !is_series || !has_open_roots(pool, &[own.real, own.imaginary], symbol, &magnitudes));
            let values = self.values.clone();
            self.exponents.retain(|own| !is_series || !is_branching(pool, &[own.real, own.imaginary], symbol, &values));
            for own in &mut self.exponents {
                for part in [&mut own.real, &mut own.imaginary] {
                    let value = done.of(pool, *part, symbol);
                    // A series is simple as it is, with its root in front.
                    *part = if is_series { value } else { pool.simplify(value) };
                }
                own.damping_ratio = None;
            }
            // A series has the sign of its leading term.
            let near = done.there(pool, &self.values);
            let special = Special { done, symbol, values: &near };
            let holds = |pool: &Algebra<'_>, own: &ClosedExponent| {
                let parts = [own.real, own.imaginary];
                let has_value = |part: &ExprId| !pool.is_undefined(*part) && !is_nan(pool, *part, &near);
                parts.iter().all(has_value) && !divides_by_zero(pool, &parts, &near)
            };
            self.exponents.retain(|own| holds(pool, own));
            if !is_series && let Some(mut found) = self.finite(pool, special) {
                found.retain(|own| holds(pool, own));
                let cost = |pool: &mut Algebra<'_>, all: &[ClosedExponent]| {
                    pool.cost(&all.iter().flat_map(|own| [own.real, own.imaginary]).collect::<Vec<_>>())
                };
                let more = known(&found).cmp(&known(&self.exponents));
                if more.is_gt() || more.is_eq() && cost(pool, &found) < cost(pool, &self.exponents) {
                    self.exponents = found;
                }
            }
            let imaginary: Vec<ExprId> = self.exponents.iter().map(|own| own.imaginary).collect();
            if undamped && let Some(drawn) = drawn(pool, &imaginary) {
                let each = self.exponents.iter_mut().zip(drawn);
                each.for_each(|(own, drawn)| own.imaginary = pool.simplify(drawn));
            }
            if is_series {
                // Where a root has become that of a square, either sign of it may leave nothing to divide by; and what
                // oscillates at the values may grow beside 0.
                let is_open = |pool: &mut Algebra<'_>, own: &ClosedExponent| {
                    let square = pool.square(own.imaginary);
                    magnitudes_in(pool, &[own.real, own.imaginary]).iter().any(|own| !magnitudes.contains(own))
                        || sign_at(pool, square, &near) == Some(true)
                };
                self.exponents.retain(|own| !is_open(pool, own));
                if known(&self.exponents) < count {
                    let series = self.series(pool, special);
                    let series = series.or_else(|| self.series_of_any(pool, special)).unwrap_or_default();
                    if known(&series) > known(&self.exponents) && series.iter().all(|own| holds(pool, own)) {
                        self.exponents = series;
                    }
                }
            }
            let all = std::mem::take(&mut self.exponents).into_iter();
            let drawn = all.map(|own| {
                let own = own.drawn(pool, &near);
                let [real, imaginary] = [own.real, own.imaginary].map(|part| divided_below_roots(pool, part, &near));
                ClosedExponent { real, imaginary, ..own }
            });
            self.exponents = drawn.collect();
            self.complete = known(&self.exponents) == count;
            self.merge(pool, &near);
            if !is_series {
                self.values = near;
            }
        }
        self.characteristic = None;
        (self.stability, self.stability_exact) = (None, None);
        self.approximations.push(done.clone());
    }

    /// The exponents of an undamped system from the series of the zeros of its characteristic polynomial.
    fn series(&self, pool: &mut Algebra<'_>, at: Special<'_>) -> Option<Vec<ClosedExponent>> {
        let characteristic = self.characteristic.as_ref()?;
        let Approximation::Expansion { name, order } = at.done else { return None };
        if !is_even(characteristic) {
            return None;
        }
        // The root of a zero that begins with the power v is known to v/2 powers fewer.
        let squares = Approximation::Expansion { name: name.clone(), order: (2 * order).min(MOST_ORDERS) };
        let mut found = Vec::new();
        for Frequency { omega_squared, .. } in finite(pool, characteristic, Special { done: &squares, ..at })? {
            let (square, grows) = positive_at(pool, omega_squared, at.values);
            let root = root_of_series(pool, square, at.symbol, *order)?;
            found.extend([root, pool.neg(root)].map(|x| ClosedExponent::on_axis(pool, x, grows, 1)));
        }
        Some(found)
    }

    /// Those exponents that are finite where the parameter is 0 and no others are equal to, of any system.
    fn series_of_any(&self, pool: &mut Algebra<'_>, at: Special<'_>) -> Option<Vec<ClosedExponent>> {
        let Approximation::Expansion { name, order } = at.done else { return None };
        let at_zero = Approximation::Limit { name: name.clone(), value: (&Number::ZERO).into() };
        let limits = self.finite(pool, Special { done: &at_zero, ..at })?.into_iter();
        let characteristic = self.characteristic.as_ref()?;
        let mut known: Vec<(Parts, Parts)> = Vec::new();
        for own in limits {
            let opposite = pool.neg(own.imaginary);
            let conjugate = known.iter().find(|(from, _)| *from == [own.real, opposite]).map(|(_, to)| *to);
            let found = match conjugate {
                Some([real, imaginary]) => Some([real, pool.neg(imaginary)]),
                None => continued(pool, characteristic, at, [own.real, own.imaginary], *order),
            };
            known.extend(found.map(|found| ([own.real, own.imaginary], found)));
        }
        let exponent = |(_, [real, imaginary]): (Parts, Parts)| ClosedExponent {
            real,
            imaginary,
            multiplicity: 1,
            damping_ratio: None,
        };
        Some(known.into_iter().map(exponent).collect())
    }

    /// Adds an exponent, to the same one where there is one.
    pub(super) fn add(&mut self, new: ClosedExponent) {
        match self.exponents.iter_mut().find(|own| (own.real, own.imaginary) == (new.real, new.imaginary)) {
            Some(same) => same.multiplicity += new.multiplicity,
            None => self.exponents.push(new),
        }
    }

    /// Makes equal exponents one, and puts the one of a pair first that has no minus sign.
    fn merge(&mut self, pool: &mut Algebra<'_>, values: &[(Symbol, f64)]) {
        std::mem::take(&mut self.exponents).into_iter().for_each(|own| self.add(own));
        let merged = &mut self.exponents;
        for at in 0..merged.len() {
            let (real, imaginary) = (merged[at].real, merged[at].imaginary);
            let opposite = pool.neg(imaginary);
            let other = merged[at..].iter().position(|own| (own.real, own.imaginary) == (real, opposite));
            let mut is_negative = || {
                let there = sign_at(pool, imaginary, values);
                there.unwrap_or_else(|| pool.split_content(imaginary).0.is_negative())
            };
            if let Some(other) = other.filter(|_| is_negative()) {
                merged.swap(at, at + other);
            }
        }
    }
}

impl ClosedExponent {
    /// A real one, or an imaginary one.
    fn on_axis(pool: &Algebra<'_>, x: ExprId, is_real: bool, multiplicity: usize) -> Self {
        let [real, imaginary] = if is_real { [x, pool.zero()] } else { [pool.zero(), x] };
        Self { real, imaginary, multiplicity, damping_ratio: None }
    }

    /// The exponent with a real part where its imaginary part has become the root of minus a square, and with an imaginary one where its real
    /// part has become the root of what is negative at the values of the parameters.
    fn drawn(self, pool: &mut Algebra<'_>, values: &[(Symbol, f64)]) -> Self {
        let square = pool.square(if self.imaginary.is_zero() { self.real } else { self.imaginary });
        let opposite = pool.neg(square);
        if self.imaginary.is_zero() {
            if sign_at(pool, square, values) != Some(true) {
                return self;
            }
            let (size, _) = root(pool, opposite);
            let is_negative = pool.split_content(self.real).0.is_negative();
            let imaginary = if is_negative { pool.neg(size) } else { size };
            return Self { real: pool.zero(), imaginary: pool.simplify(imaginary), ..self };
        }
        let (size, is_drawn) = root(pool, opposite);
        if !is_drawn && sign_at(pool, square, values) != Some(true) {
            return self;
        }
        let is_negative = pool.split_content(self.imaginary).0.is_negative();
        let real = if is_negative { pool.add(self.real, size) } else { pool.sub(self.real, size) };
        Self { real: pool.simplify(real), imaginary: pool.zero(), ..self }
    }
}

/// Whether a root of which an exponent is made vanishes where a symbol is 0, or may do so for one sign of a magnitude: Taylor's formula then has
/// nothing to go by, though a factor 0 may hide that.
fn has_open_roots(pool: &mut Algebra<'_>, all: &[ExprId], symbol: Symbol, magnitudes: &BTreeSet<ExprId>) -> bool {
    roots_at_zero(pool, all, symbol)
        .into_iter()
        .any(|there| pool.vanishes(there) || magnitudes_in(pool, &[there]).iter().any(|own| !magnitudes.contains(own)))
}

/// Whether such a root vanishes at the values of the parameters, where forms that are apart elsewhere meet: no series in a coupling there is one
/// in it alone.
fn is_branching(pool: &mut Algebra<'_>, all: &[ExprId], symbol: Symbol, values: &[(Symbol, f64)]) -> bool {
    let roots = roots_at_zero(pool, all, symbol);
    roots.into_iter().any(|there| !pool.vanishes(there) && vanishes_at(pool, there, values))
}

/// What stands below roots, where a symbol in it is 0.
fn roots_at_zero(pool: &mut Algebra<'_>, all: &[ExprId], symbol: Symbol) -> Vec<ExprId> {
    let at_zero = Substitution::from([(symbol, pool.zero())]);
    let mut roots = bases_with(pool, all, |_, exponent| !exponent.is_integer());
    roots.retain(|base| pool.symbols_of(&[*base]).contains(&symbol));
    let at_zero = roots.into_iter().map(|base| {
        let there = pool.substitute_one(base, &at_zero);
        pool.simplify(there)
    });
    at_zero.collect()
}

/// The root, to some power of a symbol, of a polynomial in it that is known to twice that power, or to as many powers as there are; `None` where these
/// are too few.
fn root_of_series(pool: &mut Algebra<'_>, square: ExprId, symbol: Symbol, order: u32) -> Option<ExprId> {
    let known = (2 * order).min(MOST_ORDERS);
    let coefficients = taylor(pool, square, symbol, known);
    let first = (0_u32..).zip(&coefficients).find(|(_, own)| !own.is_zero()).map(|(power, _)| power);
    let Some(first) = first else { return (known == 2 * order).then(|| pool.zero()) };
    let more = order.checked_sub(first.div_ceil(2)).filter(|more| *more <= known - first)?;
    let rest = polynomial(pool, coefficients.into_iter().skip(first as usize), symbol);
    let root = pool.sqrt(rest);
    let root = series(pool, root, symbol, more);
    let half = Number::half().mul(&Number::from(i64::from(first)));
    let variable = pool.symbol_expr(symbol);
    let front = pool.product_of_powers(&[(variable, half)]);
    Some(pool.mul(front, root))
}

impl Approximation {
    /// A polynomial in a limit, the constant first, without the leading coefficients that vanish there.
    fn polynomial(&self, pool: &mut Algebra<'_>, coefficients: &[ExprId], symbol: Symbol) -> Vec<ExprId> {
        let limits = coefficients.iter().map(|own| {
            let value = self.of(pool, *own, symbol);
            pool.simplify(value)
        });
        let mut limits: Vec<ExprId> = limits.collect();
        while limits.last().is_some_and(|last| pool.vanishes(*last)) {
            limits.pop();
        }
        limits
    }

    /// The values of the parameters in a limit, or where the one of a series is a million times nearer to 0.
    fn there(&self, pool: &Pool, values: &[(Symbol, f64)]) -> Vec<(Symbol, f64)> {
        let own = |&(symbol, value): &(Symbol, f64)| match self {
            _ if pool.symbol_name(symbol) != self.name() => (symbol, value),
            Self::Limit { value, .. } => (symbol, evaluate_closed(value.pool(), value.value(), ()).unwrap_or(f64::NAN)),
            Self::Expansion { .. } => (symbol, if value == 0.0 { 1e-6 } else { 1e-6 * value }),
        };
        values.iter().map(own).collect()
    }
}

/// Whether something that is divided by vanishes at the values of the parameters.
fn divides_by_zero(pool: &Algebra<'_>, all: &[ExprId], values: &[(Symbol, f64)]) -> bool {
    bases_with(pool, all, |_, exponent| exponent.is_negative()).into_iter().any(|base| vanishes_at(pool, base, values))
}

/// Whether an expression vanishes at the values of its parameters.
fn vanishes_at(pool: &Algebra<'_>, e: ExprId, values: &[(Symbol, f64)]) -> bool {
    let (symbols, there): (Vec<Symbol>, Vec<f64>) = values.iter().copied().unzip();
    let terms = pool.terms(e);
    let own: Vec<ExprId> = [e].into_iter().chain(terms.iter().map(|own| own.0)).collect();
    let Ok(tape) = Tape::compile(pool, &own, &symbols) else { return false };
    let found = tape.evaluate(&there, &mut Vec::new());
    found[0].abs() <= 1e-14 * found[1..].iter().map(|own: &f64| own.abs()).sum::<f64>()
}

/// Whether an expression is negative at the values of its parameters; `None` where some have none.
fn sign_at(pool: &Algebra<'_>, e: ExprId, values: &[(Symbol, f64)]) -> Option<bool> {
    let found = value_at(pool, e, values)?;
    (found.is_finite() && found != 0.0).then_some(found < 0.0)
}

/// An expression at the values of its parameters; `None` where some have none.
fn value_at(pool: &Algebra<'_>, e: ExprId, values: &[(Symbol, f64)]) -> Option<f64> {
    let (symbols, there): (Vec<Symbol>, Vec<f64>) = values.iter().copied().unzip();
    Some(Tape::compile(pool, &[e], &symbols).ok()?.evaluate(&there, &mut Vec::new())[0])
}

/// Whether an expression has roots of what is negative at the values of its parameters.
fn is_nan(pool: &Algebra<'_>, e: ExprId, values: &[(Symbol, f64)]) -> bool {
    value_at(pool, e, values).is_some_and(f64::is_nan)
}

/// ω², or -ω² where it is negative at the values, and which of them it is.
fn positive_at(pool: &mut Algebra<'_>, omega_squared: ExprId, values: &[(Symbol, f64)]) -> (ExprId, bool) {
    let grows = sign_at(pool, omega_squared, values) == Some(true);
    (if grows { pool.neg(omega_squared) } else { omega_squared }, grows)
}

/// Each term over one fraction bar, where that is easier to read.
fn term_by_term(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let mut terms = pool.terms(e);
    for (own, _) in &mut terms {
        let short = pool.simplify(*own);
        *own = best_to_read(pool, short);
    }
    pool.linear(&terms)
}

/// `sqrt(m*k)/m` as `sqrt(k/m)` in each term, where m is positive at the values of the parameters.
fn divided_below_roots(pool: &mut Algebra<'_>, e: ExprId, values: &[(Symbol, f64)]) -> ExprId {
    let mut terms = pool.terms(e);
    for (term, _) in &mut terms {
        let mut factors = pool.factors(*term);
        let is_below =
            |(base, e): &&(ExprId, Number)| *e == Number::MINUS_ONE && sign_at(pool, *base, values) == Some(false);
        let below: Vec<ExprId> = factors.iter().filter(is_below).map(|own| own.0).collect();
        for divisor in below {
            let holds = |(base, e): &(ExprId, Number)| {
                *e == Number::half() && pool.factors(*base).contains(&(divisor, Number::ONE))
            };
            if let Some(at) = factors.iter().position(holds) {
                let square = pool.square(divisor);
                factors[at].0 = pool.div(factors[at].0, square);
                factors.retain(|own| *own != (divisor, Number::MINUS_ONE));
            }
        }
        *term = pool.product_of_powers(&factors);
    }
    pool.linear(&terms)
}

/// The magnitudes that expressions are made of.
fn magnitudes_in(pool: &Algebra<'_>, all: &[ExprId]) -> BTreeSet<ExprId> {
    let is_magnitude = |id: &ExprId| matches!(pool.node(*id), Node::Function(Function::Abs, _));
    pool.reachable(all).into_iter().filter(is_magnitude).collect()
}

/// The squares of the frequencies that stay finite in a limit: zeros of det(K - z M), whose degree falls there; or their series.
fn finite(pool: &mut Algebra<'_>, characteristic: &[ExprId], at: Special<'_>) -> Option<Vec<Frequency>> {
    let limit = match at.done {
        Approximation::Limit { .. } => at.done.clone(),
        Approximation::Expansion { name, .. } => {
            Approximation::Limit { name: name.clone(), value: (&Number::ZERO).into() }
        }
    };
    let even = characteristic.iter().step_by(2).enumerate();
    let polynomial: Vec<ExprId> = even.map(|(power, own)| if power % 2 == 0 { *own } else { pool.neg(*own) }).collect();
    let at_limit = limit.polynomial(pool, &polynomial, at.symbol);
    let mut squares = of_polynomial(pool, &at_limit).or_else(|| {
        let (zeros, rest) = without_zeros(pool, &at_limit);
        let mut squares = vec![pool.zero(); zeros.len()];
        for (factor, multiplicity) in factors(pool, rest) {
            let own = of_polynomial(pool, &factor);
            squares.extend(own.iter().flat_map(|own| own.repeat(multiplicity)));
        }
        Some(squares).filter(|own| own.len() > zeros.len())
    })?;
    if let Approximation::Expansion { order, .. } = at.done {
        let from = std::mem::take(&mut squares);
        let none = pool.zero();
        let continued =
            from.into_iter().filter_map(|zero| Some(continued(pool, &polynomial, at, [zero, none], *order)?[0]));
        squares = continued.collect();
    }
    squares.retain(|square| !pool.is_undefined(*square));
    let found = squares.into_iter().map(|omega_squared| Frequency::new(omega_squared, 1, None));
    Some(found.collect())
}

/// Real and imaginary part.
type Parts = [ExprId; 2];

/// The series in a symbol of a zero of a polynomial from where it is for 0; `None` where it is no simple one there, or not at the values.
///
/// With z right to the power before, the coefficient of the next in p(z) is what p'(z) times the next of z cancels.
fn continued(
    pool: &mut Algebra<'_>,
    polynomial: &[ExprId],
    Special { symbol, values, .. }: Special<'_>,
    zero: Parts,
    order: u32,
) -> Option<Parts> {
    let variable = pool.symbol_expr(symbol);
    let horner = |pool: &mut Algebra<'_>, coefficients: &[ExprId], [x, y]: Parts| {
        coefficients.iter().rev().fold([pool.zero(); 2], |[re, im], own| {
            let [xx, yy, xy, yx] = [(re, x), (im, y), (re, y), (im, x)].map(|(a, b)| pool.mul(a, b));
            let real = pool.sub(xx, yy);
            [pool.add(real, *own), pool.add(xy, yx)]
        })
    };
    let slopes =
        polynomial.iter().enumerate().skip(1).map(|(power, own)| pool.scale(*own, &Number::from(power as i64)));
    let slopes: Vec<ExprId> = slopes.collect();
    let slope = horner(pool, &slopes, zero).map(|part| taylor(pool, part, symbol, 0)[0]);
    let is_open = |pool: &mut Algebra<'_>, part: ExprId| {
        let known =
            pool.is_zero(part) == ZeroVerdict::NonZero || value_at(pool, part, values).is_some_and(f64::is_finite);
        !known || pool.vanishes(part) || vanishes_at(pool, part, values)
    };
    if slope.iter().all(|part| is_open(pool, *part)) {
        return None;
    }
    let [c, d] = slope.map(|part| if pool.vanishes(part) { pool.zero() } else { part });
    let mut z = zero;
    for power in 1..=order.min(MOST_ORDERS) {
        let mut residual = Vec::new();
        for part in horner(pool, polynomial, z) {
            let own = *taylor(pool, part, symbol, power).last()?;
            residual.push(best_to_read(pool, own));
        }
        let [a, b] = residual[..] else { return None };
        // (a + i b)/(c + i d)
        let step = if d.is_zero() {
            [a, b].map(|own| {
                let own = pool.short(|pool| pool.div(own, c));
                best_to_read(pool, own)
            })
        } else if c.is_zero() {
            let im = pool.short(|pool| pool.div(a, d));
            [pool.short(|pool| pool.div(b, d)), pool.neg(im)]
        } else {
            let [ac, bd, bc, ad, cc, dd] =
                [(a, c), (b, d), (b, c), (a, d), (c, c), (d, d)].map(|(x, y)| pool.mul(x, y));
            let below = pool.add(cc, dd);
            let above = [pool.add(ac, bd), pool.sub(bc, ad)];
            above.map(|above| {
                let own = pool.short(|pool| pool.div(above, below));
                best_to_read(pool, own)
            })
        };
        let scale = pool.powi(variable, i64::from(power));
        for (z, step) in z.iter_mut().zip(step) {
            let term = pool.mul(step, scale);
            *z = pool.sub(*z, term);
        }
    }
    Some(z)
}

/// An expression with the square roots drawn that have become those of squares, and their powers, and magnitudes, which are such roots; `turns`
/// tells which of them take the other sign.
fn with_drawn_roots(pool: &mut Algebra<'_>, e: ExprId, turns: &mut dyn FnMut(ExprId) -> bool) -> ExprId {
    let mut images: HashMap<ExprId, ExprId> = HashMap::new();
    let mut signed = |pool: &mut Algebra<'_>, e: ExprId| {
        let (_, core) = pool.split_content(e);
        let opposite = pool.neg(core);
        if turns(core.min(opposite)) { pool.neg(e) } else { e }
    };
    for id in pool.reachable(&[e]) {
        let image = match *pool.node(id) {
            Node::Function(Function::Abs, inner) => {
                let inner = images.get(&inner).copied().unwrap_or(inner);
                signed(pool, inner)
            }
            _ => rebuild(pool, id, &images),
        };
        let mut factors = pool.factors(image);
        for (base, exponent) in &mut factors {
            let twice = exponent.mul(&Number::from(2));
            if twice.is_integer()
                && !exponent.is_integer()
                && pool.is_sum(*base)
                && let (square, true) = root(pool, *base)
            {
                (*base, *exponent) = (signed(pool, square), twice);
            }
        }
        images.insert(id, pool.product_of_powers(&factors));
    }
    images.get(&e).copied().unwrap_or(e)
}

/// Squares of frequencies with roots drawn, where each stands there with both signs, so that which one is positive makes no difference.
fn drawn(pool: &mut Algebra<'_>, values: &[ExprId]) -> Option<Vec<ExprId>> {
    if values.iter().any(|value| pool.is_undefined(*value)) {
        return None;
    }
    let of = |pool: &mut Algebra<'_>, turns: &mut dyn FnMut(ExprId) -> bool| -> Vec<ExprId> {
        values.iter().map(|value| with_drawn_roots(pool, *value, turns)).collect()
    };
    let mut roots = BTreeSet::new();
    let plus = of(pool, &mut |root| {
        roots.insert(root);
        false
    });
    // Each for itself, and as often as before.
    let is_same = |root: ExprId| {
        let mut left = of(pool, &mut |own| own == root);
        plus.iter().all(|own| {
            let at = left.iter().position(|other| pool.agree(*own, *other));
            at.map(|at| left.swap_remove(at)).is_some()
        })
    };
    roots.into_iter().all(is_same).then_some(plus)
}

fn transform_case(
    pool: &mut Algebra<'_>,
    case: &mut Case,
    (values, is_series): (&[(Symbol, f64)], bool),
    change: impl Fn(&mut Algebra<'_>, ExprId) -> ExprId,
) {
    // They stand for what was before.
    case.solved.clear();
    case.normal = None;
    case.waves.clear();
    let mut frequencies: Vec<Frequency> = Vec::new();
    let squares: Vec<ExprId> = case.frequencies.iter().map(|form| change(pool, form.omega_squared)).collect();
    let squares = drawn(pool, &squares).unwrap_or(squares);
    for (mut form, value) in case.frequencies.drain(..).zip(squares) {
        if pool.is_undefined(value) || divides_by_zero(pool, &[value], values) {
            case.complete = false;
            continue;
        }
        // A series is simple as it is, but for its coefficients.
        form.omega_squared = if is_series { term_by_term(pool, value) } else { pool.simplify(value) };
        let same = |other: &&mut Frequency| other.omega_squared == form.omega_squared;
        match frequencies.iter_mut().find(same) {
            Some(other) => other.join(&form),
            None => frequencies.push(form),
        }
    }
    case.frequencies = frequencies;
    case.series.iter_mut().for_each(|series| series.omega_squared = change(pool, series.omega_squared));
    case.series.retain(|series| !pool.is_undefined(series.omega_squared));
}
