//! What expressions do to dimensions: those below first, each once.

use super::infer::{Inference, Scope};
use super::operations::{Context, Quantity, base};
use super::solve::Combination;
use crate::number::Number;
use crate::order::Order;
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, IndexEntry, IndexKind, Indices, Member};

impl<'a> Inference<'a> {
    /// Brings index variables into scope. What sets ranges is a number.
    pub(super) fn binders(&mut self, indices: Option<&'a Indices>, mut scope: usize) -> usize {
        let Some(indices) = indices else { return scope };
        for entry in &indices.entries {
            let (name, table) = match &entry.kind {
                IndexKind::Member(at) => {
                    self.count(*at);
                    continue;
                }
                IndexKind::Range { variable, from, to } => {
                    self.count(*from);
                    self.count(*to);
                    if let Some(name) = variable { (name, None) } else { continue }
                }
                IndexKind::Rows { variable, table } => (variable, Some(table.text.as_str())),
            };
            self.scopes.push(Scope { outer: scope, name: &name.text, table, bounds: None });
            scope = self.scopes.len() - 1;
        }
        scope
    }

    /// Names that set an index or a range are pure numbers.
    fn count(&mut self, root: ExprRef) {
        let mut todo = vec![root];
        while let Some(at) = todo.pop() {
            let expr = self.file.expr(at);
            match expr.kind {
                ExprKind::Name(name) => {
                    if let Some(Quantity::Of(own)) = self.names.get(name) {
                        // One with a unit in a range is told by what becomes of the range.
                        let own = own.clone();
                        self.equations.solver.equate(&own, &Combination::default(), expr.span);
                    }
                }
                ExprKind::Field { .. } => {}
                _ => self.file.children(at, &mut todo),
            }
        }
    }

    fn variable(&self, name: &str, mut scope: usize) -> Option<usize> {
        while scope > 0 {
            let own = &self.scopes[scope];
            if own.name == name {
                return Some(scope);
            }
            scope = own.outer;
        }
        None
    }

    /// The dimension of an expression: those below it first, which stand before it.
    pub(super) fn evaluate(&mut self, root: ExprRef, scope: usize) -> Quantity {
        let [mut order, mut below] = std::mem::take(&mut self.lists);
        let mut todo = Vec::with_capacity(16);
        todo.push((root, scope));
        while let Some((at, scope)) = todo.pop() {
            order.push(at);
            if scope > 0 {
                self.within.insert(at, scope);
            }
            match self.file.expr(at).kind {
                ExprKind::SumOver { indices, body } => {
                    let inner = self.binders(Some(indices), scope);
                    todo.push((body, inner));
                }
                ExprKind::IntegralOver { indices, body } => {
                    if let [IndexEntry { kind: IndexKind::Range { variable: Some(name), from, to }, .. }] =
                        &*indices.entries
                    {
                        let bounds = Some(([*from, *to], None));
                        self.scopes.push(Scope { outer: scope, name: &name.text, table: None, bounds });
                        todo.extend([(*from, scope), (*to, scope), (body, self.scopes.len() - 1)]);
                        self.within.insert(at, self.scopes.len() - 1);
                    }
                }
                ExprKind::Index { base, indices } => {
                    for index in indices {
                        self.count(*index);
                    }
                    todo.push((base, scope));
                }
                ExprKind::Field { .. } => {}
                _ => {
                    self.file.children(at, &mut below);
                    todo.extend(below.drain(..).map(|child| (child, scope)));
                }
            }
        }
        order.put_in_order();
        for at in order.drain(..) {
            let own = self.one(at);
            self.memo[at.0 as usize] = own;
        }
        self.lists = [order, below];
        self.take(root)
    }

    fn take(&mut self, at: ExprRef) -> Quantity {
        std::mem::replace(&mut self.memo[at.0 as usize], Quantity::Any)
    }

    /// One expression, those below it done.
    fn one(&mut self, at: ExprRef) -> Quantity {
        let file = self.file;
        let span = file.expr(at).span;
        match file.expr(at).kind {
            ExprKind::Number(text) => {
                let mantissa = text.split(['e', 'E']).next().unwrap_or("");
                if mantissa.chars().all(|c| matches!(c, '0' | '.')) { Quantity::Any } else { Quantity::number() }
            }
            ExprKind::Name(name) => self.name(name, at),
            ExprKind::Index { base, indices } => {
                let mut part = self.take(base);
                for index in indices {
                    part = match self.whole(*index).and_then(|at| usize::try_from(at - 1).ok()) {
                        Some(at) => part.element(at).unwrap_or(Quantity::Any),
                        None => self.equations.uniform(part, "the elements of a list", span),
                    };
                }
                part
            }
            ExprKind::Field { base, field } => self.column(at, base, &field.text),
            ExprKind::Prime(inner) => self.take(inner).rate(),
            ExprKind::Negate(inner) => self.take(inner),
            ExprKind::Power { base, exponent } => self.raised(base, exponent),
            ExprKind::Product(factors) => self.factors(factors, span),
            ExprKind::Sum(terms) => {
                let terms: Vec<(Quantity, Span)> =
                    terms.iter().map(|term| (self.take(term.value()), file.expr(term.value()).span)).collect();
                self.equations.alike(&terms, &Context::Sum)
            }
            ExprKind::Call { function, arguments } => {
                let arguments: Vec<(Quantity, Span)> =
                    arguments.iter().map(|own| (self.take(*own), file.expr(*own).span)).collect();
                self.call(&function.text, arguments, span)
            }
            ExprKind::SumOver { body, .. } => self.take(body),
            ExprKind::IntegralOver { body, .. } => {
                let (body, scope) = (self.take(body), self.within.get(&at).copied());
                let variable = scope.map_or(Quantity::Any, |scope| self.variable_of_integral(scope));
                self.equations.product(body, variable, false, span)
            }
            ExprKind::Vector(parts) => Quantity::list(parts.iter().map(|part| self.take(*part)).collect()),
            ExprKind::Compare { .. } | ExprKind::Not(_) | ExprKind::And(_) | ExprKind::Or(_) => Quantity::Any,
        }
    }

    /// What both bounds are, which stand before all that uses the variable.
    fn variable_of_integral(&mut self, scope: usize) -> Quantity {
        match self.scopes.get(scope).and_then(|own| own.bounds.clone()) {
            Some((_, Some(known))) => known,
            Some((bounds, None)) => {
                let sides = bounds.map(|at| (self.memo[at.0 as usize].clone(), self.file.expr(at).span));
                let own = self.equations.alike(&sides, &Context::Arguments("the bounds of an integral"));
                self.scopes[scope].bounds = Some((bounds, Some(own.clone())));
                own
            }
            None => Quantity::number(),
        }
    }

    fn name(&mut self, name: &str, at: ExprRef) -> Quantity {
        let scope = self.within.get(&at).copied().unwrap_or(0);
        if let Some(own) = self.variable(name, scope) {
            return self.variable_of_integral(own);
        }
        match name {
            "pi" => Quantity::number(),
            "t" => Quantity::Of(base("s")),
            _ => self.names.get(name).cloned().unwrap_or(Quantity::Any),
        }
    }

    /// `b.col` and `bonds[3].col`: every column has a dimension of its own.
    fn column(&mut self, at: ExprRef, row: ExprRef, field: &'a str) -> Quantity {
        let file = self.file;
        let scope = self.within.get(&at).copied().unwrap_or(0);
        let table = match file.expr(row).kind {
            ExprKind::Name(name) => self.variable(name, scope).and_then(|own| self.scopes[own].table),
            ExprKind::Index { base, .. } => match file.expr(base).kind {
                ExprKind::Name(name) if self.tables.contains(name) => Some(name),
                _ => None,
            },
            _ => None,
        };
        let Some(table) = table else { return Quantity::Any };
        let solver = &mut self.equations.solver;
        let own = self.columns.entry((table, field)).or_insert_with(|| solver.unknown(&format!("{table}.{field}")));
        Quantity::Of(own.clone())
    }

    fn raised(&mut self, under: ExprRef, exponent: ExprRef) -> Quantity {
        let below = self.take(under);
        let above = self.take(exponent);
        let span = self.file.expr(exponent).span;
        self.equations.number(&above, "an exponent", span);
        if let Some(exponent) = self.literal(exponent) {
            return below.power(&exponent);
        }
        // A power with an exponent that may vary is a number if its base is one.
        match below {
            Quantity::Of(own) if self.equations.known(&own).is_some_and(|own| own.is_number()) => Quantity::number(),
            Quantity::Any | Quantity::Of(_) | Quantity::List(_) => Quantity::Any,
        }
    }

    /// The value of a whole number that is written in digits.
    pub(super) fn whole(&self, at: ExprRef) -> Option<i64> {
        self.digits(at)?.to_i64()
    }

    fn digits(&self, at: ExprRef) -> Option<Number> {
        if let ExprKind::Number(text) = self.file.expr(at).kind { Number::parse(text) } else { None }
    }

    /// What a function gives of an expression, or of the one behind its minus sign with the sign.
    fn signed(&self, at: ExprRef, unsigned: impl Fn(ExprRef) -> Option<Number>) -> Option<Number> {
        match self.file.expr(at).kind {
            ExprKind::Negate(inner) => unsigned(inner).map(|n| n.neg()),
            _ => unsigned(at),
        }
    }

    /// The value of a constant that is written in digits: `2`, `-1/2`, `(3/2)`.
    fn literal(&self, at: ExprRef) -> Option<Number> {
        self.signed(at, |own| match self.file.expr(own).kind {
            ExprKind::Product(factors) => self.ratio(factors),
            _ => self.digits(own),
        })
    }

    fn ratio(&self, factors: &[Member]) -> Option<Number> {
        factors.iter().try_fold(Number::ONE, |product, factor| {
            let own = self.signed(factor.value(), |own| self.digits(own))?;
            if factor.inverted() { product.div(&own) } else { Some(product.mul(&own)) }
        })
    }

    fn factors(&mut self, factors: &[Member], span: Span) -> Quantity {
        factors.iter().fold(Quantity::number(), |product, factor| {
            let own = self.take(factor.value());
            self.equations.product(product, own, factor.inverted(), span)
        })
    }

    fn call(&mut self, function: &str, arguments: Vec<(Quantity, Span)>, span: Span) -> Quantity {
        let argument = |at: usize| arguments.get(at).map_or(Quantity::Any, |own| own.0.clone());
        let two = Number::from(2);
        let components = |own: &mut Self, at| own.equations.uniform(argument(at), "the components of a vector", span);
        match function {
            "sin" | "cos" | "tan" | "asin" | "acos" | "atan" | "sinh" | "cosh" | "tanh" | "exp" | "ln" | "rot_x"
            | "rot_y" | "rot_z" => {
                let what = format!("the argument of `{function}`");
                for (own, span) in &arguments {
                    self.equations.number(own, &what, *span);
                }
                Quantity::number()
            }
            "atan2" => {
                self.equations.alike(&arguments, &Context::Arguments("the arguments of `atan2`"));
                Quantity::number()
            }
            "sqrt" => argument(0).power(&Number::half()),
            "abs" | "floor" | "transpose" => argument(0),
            "norm" => {
                let (value, span) = (argument(0), arguments.first().map_or(span, |own| own.1));
                self.equations.uniform(value, "the components of a vector", span)
            }
            "dot" => self.equations.dot(&argument(0), &argument(1), span),
            "cross" => {
                let (u, v) = (components(self, 0), components(self, 1));
                self.equations.product(u, v, false, span)
            }
            "mod" => self.equations.alike(&arguments, &Context::Arguments("the arguments of `mod`")),
            "angular_velocity" => argument(0).rate(),
            "inertia_sphere" | "inertia_shell" | "inertia_rod" | "inertia_cylinder" | "inertia_box" => {
                let what = format!("the lengths of `{function}`");
                let lengths = arguments.get(1..).unwrap_or_default();
                let length = self.equations.alike(lengths, &Context::Arguments(&what));
                let square = length.power(&two);
                self.equations.product(argument(0), square, false, span)
            }
            "inertia_point" => {
                let place = components(self, 1);
                self.equations.product(argument(0), place.power(&two), false, span)
            }
            "steiner" => {
                let shift = components(self, 2);
                let moved = self.equations.product(argument(1), shift.power(&two), false, span);
                self.equations.alike(&[(argument(0), span), (moved, span)], &Context::Sum)
            }
            "about" => {
                let axis = components(self, 1);
                let axis_span = arguments.get(1).map_or(span, |own| own.1);
                self.equations.number(&axis, "the axis of `about`", axis_span);
                argument(0)
            }
            "rows" => Quantity::number(),
            // Told as unknown elsewhere.
            _ => Quantity::Any,
        }
    }
}
