//! Equations among dimensions: linear in the exponents, solved one at a time by elimination.

use std::collections::BTreeMap;

use super::error::Inferred;
use super::{BASE, Dimension};
use crate::number::Number;
use crate::order::Gather;
use crate::span::Span;

/// A base unit (below 7) or something of unknown dimension.
type Generator = u32;

/// The first generator that is no base unit.
const FIRST_UNKNOWN: Generator = BASE.len() as Generator;

/// A relation among more unknowns than this is let go: no physicist's file comes near, and it keeps
/// the work of a hostile one in bounds.
const MOST_GENERATORS: usize = 64;

/// A product of powers of generators, sorted, without powers of zero.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Combination(Vec<(Generator, Number)>);

impl Combination {
    pub(super) fn generator(at: Generator) -> Self {
        Self(vec![(at, Number::from(1))])
    }

    pub(super) fn from_exponents(exponents: [Number; 7]) -> Self {
        Self((0..).zip(exponents).filter(|(_, e)| !e.is_zero()).collect())
    }

    /// `self · other^factor`
    pub(super) fn times_power(&self, other: &Self, factor: &Number) -> Self {
        let mut product: BTreeMap<Generator, Number> = self.0.iter().cloned().gather();
        for (at, exponent) in &other.0 {
            let own = product.entry(*at).or_default();
            *own = own.add(&exponent.mul(factor));
        }
        Self(product.into_iter().filter(|(_, exponent)| !exponent.is_zero()).collect())
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        self.times_power(other, &Number::from(1))
    }

    pub(super) fn over(&self, other: &Self) -> Self {
        self.times_power(other, &Number::from(-1))
    }

    pub(super) fn power(&self, exponent: &Number) -> Self {
        Self::default().times_power(self, exponent)
    }

    /// The dimension, where nothing in it is unknown.
    pub(super) fn dimension(&self) -> Option<Dimension> {
        let mut dimension = Dimension::default();
        for (at, exponent) in &self.0 {
            *dimension.exponents.get_mut(*at as usize)? = exponent.clone();
        }
        Some(dimension)
    }

    fn is_oversized(&self) -> bool {
        self.0.len() > MOST_GENERATORS || self.0.iter().any(|(_, e)| e.bits() > 64)
    }
}

/// What became known about an unknown, and where.
#[derive(Clone, Debug)]
struct Solved {
    value: Combination,
    span: Span,
    /// The how-manieth equation told.
    step: usize,
}

#[derive(Clone, Debug)]
struct Unknown {
    name: String,
    solved: Option<Solved>,
}

/// The equations so far, solved.
#[derive(Clone, Debug, Default)]
pub(super) struct Solver {
    unknowns: Vec<Unknown>,
    steps: usize,
}

impl Solver {
    pub(super) fn unknown(&mut self, name: &str) -> Combination {
        let at = FIRST_UNKNOWN + self.unknowns.len() as Generator;
        self.unknowns.push(Unknown { name: name.to_owned(), solved: None });
        Combination::generator(at)
    }

    fn solved(&self, at: Generator) -> Option<&Solved> {
        let at = at.checked_sub(FIRST_UNKNOWN)?;
        self.unknowns.get(at as usize)?.solved.as_ref()
    }

    /// The same with all that is known put in; `None` beyond the bounds of this stage.
    pub(super) fn resolve(&self, combination: &Combination) -> Option<Combination> {
        let mut result = combination.clone();
        // Values hold older unknowns only, so that the newest that is solved never comes back.
        while let Some((at, exponent)) = result.0.iter().rev().find(|(at, _)| self.solved(*at).is_some()).cloned() {
            if result.is_oversized() {
                return None;
            }
            let Some(solved) = self.solved(at) else { break };
            let own = Combination(vec![(at, exponent.clone())]);
            result = result.over(&own).times_power(&solved.value, &exponent);
        }
        (!result.is_oversized()).then_some(result)
    }

    /// Requires two dimensions to be equal; `false` if they are known and differ.
    pub(super) fn equate(&mut self, a: &Combination, b: &Combination, span: Span) -> bool {
        if a == b {
            return true;
        }
        let Some(quotient) = self.resolve(&a.over(b)) else { return true };
        let Some((newest, exponent)) = quotient.0.last().cloned() else { return true };
        if newest < FIRST_UNKNOWN {
            return false;
        }
        let Some(inverse) = exponent.neg().recip() else { return true };
        let rest = quotient.over(&Combination(vec![(newest, exponent)]));
        self.steps += 1;
        let solved = Solved { value: rest.power(&inverse), span, step: self.steps };
        if let Some(unknown) = self.unknowns.get_mut((newest - FIRST_UNKNOWN) as usize) {
            unknown.solved = Some(solved);
        }
        true
    }

    /// The name in a combination that was found out last, and where.
    pub(super) fn last_found(&self, combination: &Combination) -> Option<Inferred> {
        let found = combination.0.iter().filter_map(|(at, _)| {
            let solved = self.solved(*at)?;
            let unknown = self.unknowns.get((*at - FIRST_UNKNOWN) as usize)?;
            let dimension = self.resolve(&solved.value)?.dimension()?;
            let found = Inferred { name: unknown.name.clone(), dimension, span: solved.span };
            Some((solved.step, found))
        });
        found.max_by_key(|(step, _)| *step).map(|(_, found)| found)
    }
}
