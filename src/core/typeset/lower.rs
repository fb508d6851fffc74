//! From a syntax tree to a formula: where brackets are needed, what goes below a fraction bar.

use std::collections::{BTreeMap, BTreeSet};

use super::symbol::{Subscript, kept_apart};
use super::{Formula, Sign, Symbol};
use crate::order::Order;
use crate::syntax::{self, Comparison, ExprKind, ExprRef, File, IndexKind, Indices, Member, StatementKind, parse};

/// What displacements and momenta of a derivation begin with, in front of a coordinate.
const DERIVED: [&str; 6] = ["delta", "xi", "eta", "p", "P", "pi"];

/// What the names of an expression stand for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[must_use]
pub struct Notation {
    /// The coordinates and their families, without indices: `delta_x` is a displacement and `p_x` a momentum
    /// where `x` is one of them.
    pub coordinates: BTreeSet<String>,
    /// The names of the model, without indices: none of them is a displacement or a momentum.
    own: BTreeSet<String>,
    /// Names that have other symbols than [`Symbol::of`] says, so that no two of a model look alike.
    apart: BTreeMap<String, Symbol>,
}

/// A name without indices.
fn family(name: &str) -> String {
    name.split('[').next().unwrap_or(name).to_owned()
}

impl Notation {
    /// For coordinates of these names; indices are left out.
    pub fn new<'a>(coordinates: impl IntoIterator<Item = &'a str>) -> Self {
        Self { coordinates: coordinates.into_iter().map(family).collect(), ..Self::default() }
    }

    /// With all names of a model, no two of which are to look alike; indices belong to them.
    pub fn names<'a>(mut self, names: impl IntoIterator<Item = &'a str> + Clone) -> Self {
        self.own = names.clone().into_iter().map(family).collect();
        self.apart = kept_apart(names);
        self
    }

    /// The formula of an expression in the model language; `None` if the text is none.
    #[must_use]
    pub fn read(&self, text: &str) -> Option<Formula> {
        // Most entries of matrices are 0.
        if !text.is_empty() && text.bytes().all(|own| own.is_ascii_digit()) {
            return Some(number(text));
        }
        let file = parse(&format!("V = {text}\n")).ok()?;
        let [statement] = file.statements.as_slice() else { return None };
        if let StatementKind::Potential(at) = statement.kind { Some(self.formula(&file, at)) } else { None }
    }

    /// Expressions with signs between them: `a = b`, `a = b, if c <= d`, `a = b; or c = d`. On the left, `T` and
    /// `V` are symbols like others.
    #[must_use]
    pub fn read_relation(&self, text: &str) -> Option<Formula> {
        const SIGNS: [(&str, Sign); 8] = [
            ("; or ", Sign::Or),
            (", if ", Sign::If),
            (" != ", Sign::Comparison(Comparison::NotEqual)),
            (" <= ", Sign::Comparison(Comparison::LessEqual)),
            (" >= ", Sign::Comparison(Comparison::GreaterEqual)),
            (" < ", Sign::Comparison(Comparison::Less)),
            (" > ", Sign::Comparison(Comparison::Greater)),
            (" = ", Sign::Comparison(Comparison::Equal)),
        ];
        for (between, sign) in SIGNS {
            if let Some((left, right)) = split_outside(text, between) {
                let mut parts = vec![self.read_relation(left)?, Formula::Sign(sign)];
                match self.read_relation(right)? {
                    Formula::Relation(more) => parts.extend(more),
                    other => parts.push(other),
                }
                if let Formula::Relation(first) = &mut parts[0] {
                    let first = std::mem::take(first);
                    parts.splice(0..1, first);
                }
                return Some(Formula::Relation(parts));
            }
        }
        let name = |text: &str| {
            let plain = text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
            plain && text.starts_with(|c: char| c.is_ascii_alphabetic())
        };
        match text.split_once(" - ") {
            // `V - T0` is no expression of the language.
            Some((left, right)) if name(left) && name(right) => {
                Some(Formula::Sum(vec![(false, self.symbol(left)), (true, self.symbol(right))]))
            }
            _ if name(text) => Some(self.symbol(text)),
            _ => self.read(text),
        }
    }

    /// The same; what is no formula, as what nests too deeply, as it is written.
    #[must_use]
    pub fn relation(&self, text: &str) -> Formula {
        self.read_relation(text).unwrap_or_else(|| Formula::Verbatim(text.to_owned()))
    }

    /// The formula of an expression of a parsed file.
    ///
    /// Recursive: a file has at most 256 levels of nesting.
    #[must_use]
    pub fn formula(&self, file: &File, at: ExprRef) -> Formula {
        let lower = |at: ExprRef| self.formula(file, at);
        match file.expr(at).kind {
            ExprKind::Number(text) => number(text),
            ExprKind::Name(name) => self.symbol(name),
            ExprKind::Index { base, indices } => {
                indexed(lower(base), indices.iter().map(|at| Subscript::Index(lower(*at))))
            }
            ExprKind::Field { base, field } => {
                let word = Subscript::Word(field.text.to_string());
                indexed(lower(base), [word])
            }
            ExprKind::Prime(inner) => match lower(inner) {
                Formula::Symbol(mut symbol) => {
                    symbol.dots += 1;
                    Formula::Symbol(symbol)
                }
                other => Formula::Rate(Box::new(other.bracketed_if(|own| !own.is_atom()))),
            },
            ExprKind::Negate(inner) => negated(true, lower(inner)),
            ExprKind::Power { base, exponent } => power(lower(base), lower(exponent)),
            ExprKind::Product(factors) => self.product(file, factors),
            ExprKind::Sum(terms) => self.sum(file, terms),
            ExprKind::Call { function, arguments } => {
                let arguments = arguments.iter().map(|at| lower(*at)).collect();
                call(&function.text, arguments)
            }
            ExprKind::SumOver { indices, body } => self.total(file, indices, addend(lower(body))),
            ExprKind::IntegralOver { indices, body } => self.integral(file, indices, addend(lower(body))),
            ExprKind::Vector(entries) => {
                let rows = entries.iter().map(|at| match lower(*at) {
                    // Vectors in a vector: the rows of a matrix.
                    Formula::Matrix(column) if column.iter().all(|row| row.len() == 1) => {
                        column.into_iter().flatten().collect()
                    }
                    entry => vec![entry],
                });
                Formula::Matrix(rows.collect())
            }
            ExprKind::Compare { operator, left, right } => {
                Formula::Relation(vec![lower(left), Formula::Sign(Sign::Comparison(operator)), lower(right)])
            }
            ExprKind::Not(inner) => Formula::Relation(vec![Formula::Sign(Sign::Not), condition(lower(inner))]),
            ExprKind::And(parts) => joined(Sign::And, parts.iter().map(|at| lower(*at))),
            ExprKind::Or(parts) => joined(Sign::Or, parts.iter().map(|at| lower(*at))),
        }
    }

    /// The symbol of a name without indices.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Formula {
        Formula::Symbol(self.named(name))
    }

    fn named(&self, name: &str) -> Symbol {
        let of = |name: &str| self.apart.get(name).cloned().unwrap_or_else(|| Symbol::of(name));
        let is_own = self.own.contains(name);
        // Displacements and momenta, and what these are called where the model has such names of its own.
        let known = name.split_once('_').filter(|(prefix, coordinate)| {
            !is_own && DERIVED.contains(prefix) && self.coordinates.contains(*coordinate)
        });
        match known {
            Some(("delta", coordinate)) => Symbol { delta: true, ..of(coordinate) },
            Some((letter, coordinate)) => {
                Symbol { subscript: vec![Subscript::Coordinate(of(coordinate))], ..Symbol::of(letter) }
            }
            None => of(name),
        }
    }

    fn sum(&self, file: &File, terms: &[Member]) -> Formula {
        let parts = terms.iter().map(|one| {
            let (negative, formula) = signed(self.formula(file, one.value()));
            (negative != one.inverted(), term(formula))
        });
        Formula::Sum(parts.collect())
    }

    fn product(&self, file: &File, factors: &[Member]) -> Formula {
        let mut numbers = Vec::new();
        let (mut above, mut below) = (Vec::new(), Vec::new());
        let (mut rest, mut negative) = (factors, false);
        // `1/2*...` keeps its fraction to itself where nothing else stands below.
        if let [first, second, others @ ..] = factors
            && second.inverted()
            && let (minus, first) = match file.expr(first.value()).kind {
                ExprKind::Negate(inner) => (true, inner),
                _ => (false, first.value()),
            }
            && let (Some(a), Some(b)) = (literal(file, first), literal(file, second.value()))
        {
            numbers = vec![Formula::Number(a), Formula::Number(b)];
            (rest, negative) = (others, minus);
        }
        for factor in rest {
            let (minus, formula) = signed(self.formula(file, factor.value()));
            negative ^= minus;
            if factor.inverted() {
                below.push(formula);
            } else {
                above.push(formula);
            }
        }
        if let [a, b] = numbers.as_slice() {
            if below.is_empty() {
                above.insert(0, Formula::Fraction(Box::new(a.clone()), Box::new(b.clone())));
            } else {
                let one = *a == Formula::Number("1".to_owned());
                if !one || above.is_empty() {
                    above.insert(0, a.clone());
                }
                below.insert(0, b.clone());
            }
        }
        // 1/m*x^2
        if above.len() > 1 && above.first() == Some(&Formula::Number("1".to_owned())) {
            above.remove(0);
        }
        gather_roots(&mut above, &mut below);
        let above = side_by_side(above);
        let formula =
            if below.is_empty() { above } else { Formula::Fraction(Box::new(above), Box::new(side_by_side(below))) };
        negated(negative, formula)
    }

    /// An integral with the differential of its variable behind what is integrated.
    fn integral(&self, file: &File, indices: &Indices, body: Formula) -> Formula {
        let (mut below, mut above, mut row) = (Vec::new(), None, vec![body]);
        for entry in &indices.entries {
            if let IndexKind::Range { variable, from, to } = &entry.kind {
                below.push(self.formula(file, *from));
                above = Some(Box::new(self.formula(file, *to)));
                row.extend(variable.iter().map(|name| Formula::Differential(self.named(&name.text))));
            }
        }
        Formula::Total { integral: true, below, above, body: Box::new(side_by_side(row)) }
    }

    /// Sums from the innermost index outwards; a filter stands below the innermost.
    fn total(&self, file: &File, indices: &Indices, body: Formula) -> Formula {
        let mut body = body;
        for (at, entry) in indices.entries.iter().enumerate().rev() {
            let mut above = None;
            let mut below = match &entry.kind {
                IndexKind::Member(value) => vec![self.formula(file, *value)],
                IndexKind::Range { variable, from, to } => {
                    let from = self.formula(file, *from);
                    above = Some(Box::new(self.formula(file, *to)));
                    vec![match variable {
                        Some(name) => Formula::equation(self.symbol(&name.text), from),
                        None => from,
                    }]
                }
                IndexKind::Rows { variable, table } => vec![Formula::Relation(vec![
                    self.symbol(&variable.text),
                    Formula::Sign(Sign::In),
                    self.symbol(&table.text),
                ])],
            };
            if at + 1 == indices.entries.len()
                && let Some(filter) = indices.filter
            {
                below.push(self.formula(file, filter));
            }
            body = Formula::Total { integral: false, below, above, body: Box::new(body) };
        }
        body
    }
}

/// What stands before and behind a sign outside of brackets: filters of sums have signs, too.
fn split_outside<'a>(text: &'a str, sign: &str) -> Option<(&'a str, &'a str)> {
    if !text.contains(sign) {
        return None;
    }
    let mut depth = 0_usize;
    let is_between = |(at, byte): &(usize, u8)| {
        match byte {
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && text.as_bytes()[*at..].starts_with(sign.as_bytes())
    };
    let (at, _) = text.bytes().enumerate().find(is_between)?;
    text.split_at_checked(at).map(|(left, right)| (left, &right[sign.len()..]))
}

/// A number that is written as digits and nothing else.
fn literal(file: &File, at: ExprRef) -> Option<String> {
    match file.expr(at).kind {
        ExprKind::Number(text) if text.bytes().all(|b| b.is_ascii_digit()) => Some(text.to_owned()),
        _ => None,
    }
}

fn number(text: &str) -> Formula {
    match text.split_once(['e', 'E']) {
        Some((digits, exponent)) => {
            Formula::Scientific { digits: digits.to_owned(), exponent: exponent.trim_start_matches('+').to_owned() }
        }
        None => Formula::Number(text.to_owned()),
    }
}

fn indexed(base: Formula, feet: impl IntoIterator<Item = Subscript>) -> Formula {
    match base {
        Formula::Symbol(mut symbol) => {
            // The index of a momentum belongs to its coordinate.
            let foot = match symbol.subscript.as_mut_slice() {
                [Subscript::Coordinate(coordinate)] => coordinate,
                _ => &mut symbol,
            };
            foot.subscript.extend(feet);
            Formula::Symbol(symbol)
        }
        other => Formula::Indexed(Box::new(other.bracketed_if(|own| !own.is_atom())), feet.into_iter().collect()),
    }
}

/// A leading minus sign taken off.
fn signed(formula: Formula) -> (bool, Formula) {
    match formula {
        Formula::Sum(mut terms) if terms.len() == 1 => terms.pop().unwrap_or((false, Formula::Sum(Vec::new()))),
        other => (false, other),
    }
}

/// With a minus sign, if it is to have one.
fn negated(negative: bool, formula: Formula) -> Formula {
    if !negative {
        return formula;
    }
    match signed(formula) {
        (true, formula) => formula,
        (false, formula) => Formula::Sum(vec![(true, term(formula))]),
    }
}

/// As a term of a sum.
fn term(formula: Formula) -> Formula {
    formula.bracketed_if(|own| matches!(own, Formula::Sum(_) | Formula::Relation(_)))
}

/// As what stands behind a sum sign.
fn addend(formula: Formula) -> Formula {
    formula.bracketed_if(|own| matches!(own, Formula::Sum(terms) if terms.len() > 1))
}

fn condition(formula: Formula) -> Formula {
    formula.bracketed_if(|own| matches!(own, Formula::Relation(_)))
}

fn joined(sign: Sign, parts: impl Iterator<Item = Formula>) -> Formula {
    Formula::Relation(parts.flat_map(|part| [Formula::Sign(sign), part]).skip(1).collect())
}

/// Factors in a row: sums among others in brackets, products as they are.
fn side_by_side(factors: Vec<Formula>) -> Formula {
    let mut row = Vec::with_capacity(factors.len());
    let last = factors.len().saturating_sub(1);
    let alone = factors.len() == 1;
    for (at, factor) in factors.into_iter().enumerate() {
        match factor {
            Formula::Product(inner) => row.extend(inner),
            Formula::Sum(_) if alone => return factor,
            Formula::Sum(_) | Formula::Relation(_) | Formula::Between { .. } => row.push(factor.bracketed()),
            Formula::Total { .. } if at < last => row.push(factor.bracketed()),
            other => row.push(other),
        }
    }
    Formula::product(row)
}

/// Puts roots above and below a bar under one, and a^(3/2) and the like with them: √G/a^(3/2) is √(G/a³).
fn gather_roots(above: &mut Vec<Formula>, below: &mut Vec<Formula>) {
    let two = Formula::Number("2".to_owned());
    // The number of halves in the exponent of something other than a root. A sum is left as it is.
    let halves = |formula: &Formula| match formula {
        Formula::Power(base, exponent) if !matches!(**base, Formula::Parentheses(_)) => match exponent.as_ref() {
            Formula::Fraction(halves, divisor) if **divisor == two && matches!(**halves, Formula::Number(_)) => {
                Some(halves.clone())
            }
            _ => None,
        },
        _ => None,
    };
    let is_root = |own: &Formula| matches!(own, Formula::Root(_));
    let both = above.iter().any(is_root) && below.iter().any(is_root);
    if !both && !above.iter().chain(below.iter()).any(|own| halves(own).is_some()) {
        return;
    }
    let taken = |row: &mut Vec<Formula>| {
        let (roots, others): (Vec<Formula>, Vec<Formula>) =
            row.drain(..).partition(|own| is_root(own) || halves(own).is_some());
        *row = others;
        let bare = roots.into_iter().map(|own| match (halves(&own), own) {
            (Some(halves), Formula::Power(base, _)) => Formula::Power(base, halves),
            (None, Formula::Root(inner)) => *inner,
            (_, own) => own,
        });
        bare.collect::<Vec<Formula>>()
    };
    let (over, under) = (taken(above), taken(below));
    let root = |inner: Formula| Formula::Root(Box::new(inner));
    match (over.is_empty(), under.is_empty()) {
        (true, _) => below.push(root(side_by_side(under))),
        (false, true) => above.push(root(side_by_side(over))),
        (false, false) => {
            // One bar for all.
            let (mut top, mut bottom) = (Vec::new(), Vec::new());
            for (own, is_over) in
                over.into_iter().map(|own| (own, true)).chain(under.into_iter().map(|own| (own, false)))
            {
                let (numerator, denominator) = match own {
                    Formula::Fraction(numerator, denominator) => (*numerator, Some(*denominator)),
                    own => (own, None),
                };
                let (here, there) = if is_over { (&mut top, &mut bottom) } else { (&mut bottom, &mut top) };
                here.push(numerator);
                there.extend(denominator);
            }
            let one = Formula::Number("1".to_owned());
            top.retain(|own| *own != one);
            bottom.order_by_key(|own| !matches!(own, Formula::Number(_)));
            above.push(root(Formula::Fraction(Box::new(side_by_side(top)), Box::new(side_by_side(bottom)))));
        }
    }
}

fn power(base: Formula, exponent: Formula) -> Formula {
    let half = Formula::Fraction(Box::new(Formula::Number("1".to_owned())), Box::new(Formula::Number("2".to_owned())));
    if exponent == half {
        return Formula::Root(Box::new(base));
    }
    match base {
        Formula::Function { name, power: None, arguments } if matches!(exponent, Formula::Number(_)) => {
            Formula::Function { name, power: Some(Box::new(exponent)), arguments }
        }
        // Dots in place of the exponent would be taken for one.
        Formula::Symbol(ref symbol) if symbol.dots > 3 => {
            Formula::Power(Box::new(base.bracketed()), Box::new(exponent))
        }
        base => Formula::Power(Box::new(base.bracketed_if(|own| !own.is_atom())), Box::new(exponent)),
    }
}

/// Functions that have the same name in print.
const FUNCTIONS: [&str; 9] = ["sin", "cos", "tan", "atan2", "sinh", "cosh", "tanh", "ln", "rows"];

/// What a function of the language is called in print.
fn name_in_print(function: &str) -> Option<&'static str> {
    match function {
        "asin" => Some("arcsin"),
        "acos" => Some("arccos"),
        "atan" => Some("arctan"),
        other => FUNCTIONS.into_iter().find(|own| *own == other),
    }
}

fn call(function: &str, mut arguments: Vec<Formula>) -> Formula {
    let only = arguments.len() == 1;
    match (function, arguments.as_mut_slice()) {
        ("sqrt", [_]) => Formula::Root(Box::new(arguments.swap_remove(0))),
        ("abs" | "norm", [_]) => {
            Formula::Bars { double: function == "norm", inner: Box::new(arguments.swap_remove(0)) }
        }
        ("exp", [_]) => {
            let e = Formula::Function { name: "exp", power: None, arguments: Vec::new() };
            Formula::Power(Box::new(e), Box::new(arguments.swap_remove(0)))
        }
        ("dot" | "cross", [_, _]) => {
            let [second, first] = [1, 0].map(|at| {
                let side = arguments.swap_remove(at);
                side.bracketed_if(|own| matches!(own, Formula::Sum(_) | Formula::Between { .. }))
            });
            Formula::Between { cross: function == "cross", sides: Box::new((first, second)) }
        }
        _ => match name_in_print(function) {
            Some(name) => Formula::Function { name, power: None, arguments },
            // Without a sign of its own: a name with what it is given.
            None => {
                let is_own = syntax::FUNCTIONS.contains(&function);
                let name = Formula::Symbol(if is_own { Symbol::whole(function) } else { Symbol::of(function) });
                let inner = if only { arguments.swap_remove(0) } else { joined(Sign::Comma, arguments.into_iter()) };
                Formula::Product(vec![name, inner.bracketed()])
            }
        },
    }
}
