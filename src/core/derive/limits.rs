//! Closed forms for special values of a parameter, and their series in a small one.

use std::collections::HashMap;

use super::frequencies::{Approximation, Case, Frequencies, Frequency};
use super::roots::root;
use super::simplify::{Algebra, rebuild};
use crate::expr::{ExprId, Substitution, Symbol};
use crate::number::Number;

/// The highest power of a series.
const MOST_ORDERS: u32 = 12;

impl Frequencies {
    /// The frequencies where a parameter goes to a value: `--limit k=0`. A form that isn't defined there
    /// is dropped.
    pub(super) fn limit(&mut self, pool: &mut Algebra<'_>, name: &str, value: &Number) {
        self.transform(pool, name, |pool, e, symbol| {
            let value = pool.number(value.clone());
            pool.substitute_one(e, &Substitution::from([(symbol, value)]))
        });
        self.approximations.push(Approximation::Limit { name: name.to_owned(), value: value.clone() });
    }

    /// The frequencies to some power of a parameter, by Taylor's formula about 0: `--expand k 2`. A
    /// form without such a series is dropped.
    pub(super) fn expand(&mut self, pool: &mut Algebra<'_>, name: &str, order: u32) {
        let order = order.min(MOST_ORDERS);
        self.transform(pool, name, |pool, e, symbol| {
            let zero = pool.zero();
            let at_zero = Substitution::from([(symbol, zero)]);
            let variable = pool.symbol_expr(symbol);
            let mut derivative = e;
            let mut factorial = Number::ONE;
            let mut terms = Vec::new();
            for power in 0..=order {
                if power > 0 {
                    derivative = pool.diff(derivative, symbol);
                    factorial = factorial.mul(&Number::from(i64::from(power)));
                }
                let value = pool.substitute_one(derivative, &at_zero);
                let value = pool.simplify(value);
                let inverse = factorial.recip().unwrap_or_default();
                let power = pool.powi(variable, i64::from(power));
                let term = pool.mul(value, power);
                terms.push((term, inverse));
            }
            pool.linear(&terms)
        });
        self.approximations.push(Approximation::Expansion { name: name.to_owned(), order });
    }

    fn transform(
        &mut self,
        pool: &mut Algebra<'_>,
        name: &str,
        change: impl Fn(&mut Algebra<'_>, ExprId, Symbol) -> ExprId,
    ) {
        // Where all is known without equalities, one that the parameter would have to drag along says nothing of this limit.
        let drags = |tied: &mut Case| tied.ties.iter().flatten().any(|own| own == name);
        if self.general.complete {
            self.tied.take_if(drags);
        }
        for case in [Some(&mut self.general), self.tied.as_mut()].into_iter().flatten() {
            // Where several are equal the first stands for all.
            let set = case.ties.iter().find(|set| set.iter().any(|own| own == name));
            let leader = set.and_then(|set| set.first()).map_or(name, String::as_str);
            let all: Vec<ExprId> = case.frequencies.iter().map(|f| f.omega_squared).collect();
            let symbols = pool.symbols_of(&all);
            let symbol = symbols.iter().find(|symbol| pool.symbol_name(**symbol) == leader);
            if let Some(symbol) = symbol.copied() {
                transform_case(pool, case, |pool, e| change(pool, e, symbol));
            }
        }
    }
}

/// An expression with the square roots drawn that have become those of squares.
fn with_drawn_roots(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let mut images: HashMap<ExprId, ExprId> = HashMap::new();
    for id in pool.reachable(&[e]) {
        let image = rebuild(pool, id, &images);
        let mut factors = pool.factors(image);
        for (base, exponent) in &mut factors {
            if *exponent == Number::half()
                && pool.is_sum(*base)
                && let (square, true) = root(pool, *base)
            {
                (*base, *exponent) = (square, Number::ONE);
            }
        }
        images.insert(id, pool.product_of_powers(&factors));
    }
    images.get(&e).copied().unwrap_or(e)
}

fn transform_case(pool: &mut Algebra<'_>, case: &mut Case, change: impl Fn(&mut Algebra<'_>, ExprId) -> ExprId) {
    // Their names stand for what was before.
    case.solved.clear();
    let mut frequencies: Vec<Frequency> = Vec::new();
    let mut values: Vec<ExprId> = case.frequencies.iter().map(|form| change(pool, form.omega_squared)).collect();
    // Both signs of a root are there, so that which one is positive makes no difference.
    if !values.iter().any(|value| pool.is_undefined(*value)) {
        values.iter_mut().for_each(|value| *value = with_drawn_roots(pool, *value));
    }
    for (mut form, value) in case.frequencies.drain(..).zip(values) {
        if pool.is_undefined(value) {
            case.complete = false;
            continue;
        }
        form.omega_squared = pool.simplify(value);
        let same = |other: &&mut Frequency| other.omega_squared == form.omega_squared;
        match frequencies.iter_mut().find(same) {
            Some(other) => other.join(&form),
            None => frequencies.push(form),
        }
    }
    case.frequencies = frequencies;
    for series in &mut case.series {
        series.omega_squared = change(pool, series.omega_squared);
    }
    case.series.retain(|series| !pool.is_undefined(series.omega_squared));
}
