//! Expressions of the model language as expressions of a pool, over names that are known.

use std::collections::BTreeMap;

use librate_core::expr::{ExprId, Pool, function_from_name};
use librate_core::number::Number;
use librate_core::syntax::{Expr, ExprKind, ExprRef, File, Member, StatementKind, parse};

/// What names stand for: `m[1]`, `phi`, `phi'`, `p_phi`.
pub(super) struct Reader {
    pub(super) names: BTreeMap<String, ExprId>,
}

/// An entry as it was written.
pub(super) struct Written {
    pub(super) value: ExprId,
    pub(super) text: String,
}

/// In front of a text, so that it is a model file.
const BEFORE: &str = "V = ";

impl Reader {
    /// A text as one expression.
    pub(super) fn expression(&self, pool: &mut Pool, text: &str) -> Result<ExprId, String> {
        let (file, at) = parsed(text)?;
        self.value(pool, &file, at)
    }

    /// `left = right` as left - right.
    pub(super) fn equation(&self, pool: &mut Pool, text: &str) -> Result<ExprId, String> {
        let (left, right) = text.split_once('=').ok_or("an equation has two sides, `left = right`")?;
        let left = self.expression(pool, left)?;
        let right = self.expression(pool, right)?;
        Ok(pool.sub(left, right))
    }

    /// `[[a, b], [c, d]]` row by row.
    pub(super) fn rows(&self, pool: &mut Pool, text: &str) -> Result<Vec<Vec<Written>>, String> {
        let (file, at) = parsed(text)?;
        let no_matrix = "a matrix is written by rows, `[[a, b], [c, d]]`";
        let ExprKind::Vector(rows) = file.expr(at).kind else { return Err(no_matrix.to_owned()) };
        let mut result = Vec::new();
        for row in rows {
            let ExprKind::Vector(entries) = file.expr(*row).kind else { return Err(no_matrix.to_owned()) };
            let mut written = Vec::new();
            for entry in entries {
                let value = self.value(pool, &file, *entry)?;
                let Expr { span, .. } = file.expr(*entry);
                let [start, end] = [span.start, span.end].map(|at| (at as usize).saturating_sub(BEFORE.len()));
                let text = text.get(start..end).unwrap_or("").to_owned();
                written.push(Written { value, text });
            }
            result.push(written);
        }
        Ok(result)
    }

    /// The value of an expression of a parsed file.
    ///
    /// Recursive: a file has at most 256 levels of nesting.
    fn value(&self, pool: &mut Pool, file: &File, at: ExprRef) -> Result<ExprId, String> {
        match file.expr(at).kind {
            ExprKind::Number(text) => {
                let number = Number::parse(text).ok_or_else(|| format!("`{text}` is not a number"))?;
                Ok(pool.number(number))
            }
            ExprKind::Name("pi") => Ok(pool.pi()),
            ExprKind::Name(_) | ExprKind::Index { .. } | ExprKind::Prime(_) => {
                let name = name(file, at)?;
                self.names.get(&name).copied().ok_or_else(|| format!("`{name}` is not a name of the model"))
            }
            ExprKind::Negate(inner) => {
                let value = self.value(pool, file, inner)?;
                Ok(pool.neg(value))
            }
            ExprKind::Power { base, exponent } => {
                let base = self.value(pool, file, base)?;
                let exponent = self.value(pool, file, exponent)?;
                Ok(pool.power(base, exponent))
            }
            ExprKind::Product(factors) => {
                let parts = self.parts(pool, file, factors)?;
                Ok(pool.product_of_powers(&parts))
            }
            ExprKind::Sum(terms) => {
                let parts = self.parts(pool, file, terms)?;
                Ok(pool.linear(&parts))
            }
            ExprKind::Call { function, arguments } => {
                let values = arguments.iter().map(|argument| self.value(pool, file, *argument));
                let values: Vec<ExprId> = values.collect::<Result<_, _>>()?;
                call(pool, &function.text, &values)
            }
            ExprKind::Field { .. }
            | ExprKind::SumOver { .. }
            | ExprKind::IntegralOver { .. }
            | ExprKind::Vector(_)
            | ExprKind::Compare { .. }
            | ExprKind::Not(_)
            | ExprKind::And(_)
            | ExprKind::Or(_) => {
                Err("what is compared consists of numbers, names with their indices, `+ - * / ^` and \
                 elementary functions"
                    .to_owned())
            }
        }
    }

    /// Terms with their signs, or factors with their exponents: -1 for what is subtracted or divided by.
    fn parts(&self, pool: &mut Pool, file: &File, members: &[Member]) -> Result<Vec<(ExprId, Number)>, String> {
        let parts = members.iter().map(|member| {
            let weight = if member.inverted() { Number::MINUS_ONE } else { Number::ONE };
            Ok((self.value(pool, file, member.value())?, weight))
        });
        parts.collect()
    }
}

/// The only expression of a text.
fn parsed(text: &str) -> Result<(File, ExprRef), String> {
    let file = parse(&format!("{BEFORE}{text}\n")).map_err(|errors| {
        errors.first().map(ToString::to_string).unwrap_or_else(|| "it is not an expression".to_owned())
    })?;
    match file.statements.as_slice() {
        [statement] => match statement.kind {
            StatementKind::Potential(at) => Ok((file, at)),
            _ => Err("it is not an expression".to_owned()),
        },
        _ => Err("it is not a single expression".to_owned()),
    }
}

/// `r[1,2]''` from a name with whole numbers for indices, and primes.
fn name(file: &File, at: ExprRef) -> Result<String, String> {
    match file.expr(at).kind {
        ExprKind::Name(name) => Ok(name.to_owned()),
        ExprKind::Index { base, indices } => {
            let mut numbers = Vec::with_capacity(indices.len());
            for index in indices {
                match file.expr(*index).kind {
                    ExprKind::Number(text) => numbers.push(text),
                    _ => return Err("indices have to be numbers".to_owned()),
                }
            }
            Ok(format!("{}[{}]", name(file, base)?, numbers.join(",")))
        }
        ExprKind::Prime(inner) => Ok(format!("{}'", name(file, inner)?)),
        _ => Err("indices and primes belong to names".to_owned()),
    }
}

fn call(pool: &mut Pool, function: &str, arguments: &[ExprId]) -> Result<ExprId, String> {
    match (function, arguments) {
        ("sqrt", [x]) => Ok(pool.sqrt(*x)),
        ("atan2", [y, x]) => Ok(pool.atan2(*y, *x)),
        (name, [x]) => match function_from_name(name) {
            Some(function) => Ok(pool.apply(function, *x)),
            None => Err(format!("`{name}` is not an elementary function")),
        },
        (name, _) => Err(format!("`{name}` does not take {} values", arguments.len())),
    }
}
