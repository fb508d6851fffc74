//! Trees of units.

use pest::iterators::Pair;

use super::super::ast::{Unit, UnitKind, UnitRef};
use super::super::error::SyntaxError;
use super::super::grammar::Rule;
use super::{Builder, required};
use crate::span::Span;

impl Builder {
    fn push_unit(&mut self, span: Span, kind: UnitKind<'_>) -> UnitRef {
        self.units.push(Unit { span, kind })
    }

    pub(super) fn unit(&mut self, pair: Pair<'_, Rule>) -> Result<UnitRef, SyntaxError> {
        let span = self.span(&pair);
        let mut factors = Vec::new();
        let mut divided = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::divide => divided = true,
                Rule::multiply => divided = false,
                Rule::unit_factor => factors.push((divided, self.unit_factor(part)?)),
                _ => {}
            }
        }
        match factors.as_slice() {
            [(_, only)] => Ok(*only),
            _ => Ok(self.push_unit(span, UnitKind::Product(&factors))),
        }
    }

    fn unit_factor(&mut self, pair: Pair<'_, Rule>) -> Result<UnitRef, SyntaxError> {
        let span = self.span(&pair);
        let mut base = None;
        let mut power = None;
        for part in pair.into_inner() {
            let here = self.span(&part);
            match part.as_rule() {
                Rule::unit_one => base = Some(self.push_unit(here, UnitKind::One)),
                Rule::unit_name => base = Some(self.push_unit(here, UnitKind::Name(part.as_str()))),
                Rule::unit => base = Some(self.unit(part)?),
                Rule::exponent => power = Some(self.unit_exponent(part)?),
                _ => {}
            }
        }
        let base = required(base, span)?;
        Ok(match power {
            Some((numerator, denominator)) => self.push_unit(span, UnitKind::Power { base, numerator, denominator }),
            None => base,
        })
    }

    fn unit_exponent(&self, pair: Pair<'_, Rule>) -> Result<(i32, i32), SyntaxError> {
        let span = self.span(&pair);
        let mut numerator = None;
        let mut denominator = Some(1);
        for part in pair.into_inner() {
            let value = part.as_str().parse::<i32>().ok();
            match part.as_rule() {
                Rule::integer => numerator = value,
                Rule::natural => denominator = value,
                _ => {}
            }
        }
        match (numerator, denominator) {
            (Some(numerator), Some(denominator)) if denominator != 0 => Ok((numerator, denominator)),
            _ => Err(SyntaxError::UnitExponent { span }),
        }
    }
}
