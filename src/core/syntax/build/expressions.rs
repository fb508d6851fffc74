//! Trees of expressions, by the table of precedences.

use pest::iterators::Pair;

use super::super::ast::{Comparison, Expr, ExprKind, ExprRef, IndexEntry, IndexKind, Member, Name};
use super::super::error::SyntaxError;
use super::super::grammar::{PRECEDENCES, Rule};
use super::super::words;
use super::{Builder, incomplete};
use crate::span::Span;

/// An operand on its way through the precedence parser: sums, products and the like stay open
/// for further members until a stronger or weaker operator takes them.
struct Operand<'i> {
    /// Parentheses included.
    span: Span,
    form: Form<'i>,
}

enum Form<'i> {
    Done(ExprRef),
    Name(&'i str),
    Sum(Vec<Member>),
    Product(Vec<Member>),
    Compare(Comparison, ExprRef, ExprRef),
    And(Vec<ExprRef>),
    Or(Vec<ExprRef>),
}

impl Builder {
    pub(in crate::syntax) fn push(&self, span: Span, kind: ExprKind<'_>) -> ExprRef {
        self.expressions.borrow_mut().push(Expr { span, kind })
    }

    pub(super) fn expression(&self, pair: Pair<'_, Rule>) -> ExprRef {
        self.close(self.operand(pair))
    }

    fn operand<'i>(&self, pair: Pair<'i, Rule>) -> Operand<'i> {
        PRECEDENCES
            .map_primary(|pair| self.primary(pair))
            .map_prefix(|sign, operand| self.prefix(&sign, operand))
            .map_postfix(|operand, sign| self.postfix(operand, sign))
            .map_infix(|left, sign, right| self.infix(left, &sign, right))
            .parse(pair.into_inner())
    }

    pub(super) fn expressions_in(&self, pair: Pair<'_, Rule>) -> Vec<ExprRef> {
        pair.into_inner().filter(|part| part.as_rule() == Rule::expr).map(|part| self.expression(part)).collect()
    }

    /// Makes a node of an operand that takes no more members.
    fn close(&self, operand: Operand<'_>) -> ExprRef {
        let kind = match &operand.form {
            Form::Done(at) => return *at,
            Form::Name(name) => ExprKind::Name(name),
            Form::Sum(terms) => ExprKind::Sum(terms),
            Form::Product(factors) => ExprKind::Product(factors),
            Form::Compare(operator, left, right) => {
                ExprKind::Compare { operator: *operator, left: *left, right: *right }
            }
            Form::And(members) => ExprKind::And(members),
            Form::Or(members) => ExprKind::Or(members),
        };
        self.push(operand.span, kind)
    }

    fn primary<'i>(&self, pair: Pair<'i, Rule>) -> Operand<'i> {
        let span = self.span(&pair);
        let form = match pair.as_rule() {
            Rule::name => Form::Name(pair.as_str()),
            Rule::number => Form::Done(self.push(span, ExprKind::Number(pair.as_str()))),
            Rule::vector => Form::Done(self.push(span, ExprKind::Vector(&self.expressions_in(pair)))),
            Rule::sum_over => Form::Done(self.sum_over(pair)),
            // A parenthesis closes what is inside and leaves no node of its own.
            _ => match self.expressions_in(pair).first() {
                Some(inner) => Form::Done(*inner),
                None => self.impossible(span),
            },
        };
        Operand { span, form }
    }

    /// For shapes of pairs that the grammar has no way to make: an error instead of a tree.
    fn impossible<'i>(&self, span: Span) -> Form<'i> {
        self.object(incomplete(span));
        Form::Name("")
    }

    fn sum_over(&self, pair: Pair<'_, Rule>) -> ExprRef {
        let span = self.span(&pair);
        let mut indices = Err(incomplete(span));
        let (mut body, mut integral) = (None, false);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::integral_word => integral = true,
                Rule::sum_indices => indices = self.indices(part),
                // The condition around a sum doesn't reach into it.
                Rule::expr => body = Some(self.with_filter(false, || self.expression(part))),
                _ => {}
            }
        }
        let missing = match (indices, body) {
            (Ok(indices), Some(body)) => {
                let indices = &indices;
                if !integral {
                    return self.push(span, ExprKind::SumOver { indices, body });
                }
                match (&*indices.entries, indices.filter) {
                    ([IndexEntry { kind: IndexKind::Range { .. }, .. }], None) => {}
                    _ => self.object(SyntaxError::IntegralForm { span: indices.span }),
                }
                return self.push(span, ExprKind::IntegralOver { indices, body });
            }
            (Err(error), _) => error,
            (Ok(_), None) => incomplete(span),
        };
        self.object(missing);
        self.push(span, ExprKind::Vector(&[]))
    }

    fn prefix<'i>(&self, sign: &Pair<'i, Rule>, operand: Operand<'i>) -> Operand<'i> {
        let at = self.span(sign);
        let span = at.to(operand.span);
        let inner = self.close(operand);
        let kind = if sign.as_rule() == Rule::not {
            self.condition(at);
            ExprKind::Not(inner)
        } else {
            ExprKind::Negate(inner)
        };
        Operand { span, form: Form::Done(self.push(span, kind)) }
    }

    fn postfix<'i>(&self, operand: Operand<'i>, sign: Pair<'i, Rule>) -> Operand<'i> {
        let at = self.span(&sign);
        let span = operand.span.to(at);
        if sign.as_rule() == Rule::arguments {
            return self.call(operand, sign);
        }
        let base = self.close(operand);
        let node = match sign.as_rule() {
            Rule::subscript => self.push(span, ExprKind::Index { base, indices: &self.expressions_in(sign) }),
            Rule::field => match sign.into_inner().find(|part| part.as_rule() == Rule::column) {
                Some(column) => self.push(span, ExprKind::Field { base, field: &self.name(&column) }),
                None => {
                    self.object(incomplete(at));
                    self.push(span, ExprKind::Prime(base))
                }
            },
            _ => self.push(span, ExprKind::Prime(base)),
        };
        Operand { span, form: Form::Done(node) }
    }

    fn call<'i>(&self, operand: Operand<'i>, list: Pair<'i, Rule>) -> Operand<'i> {
        let at = self.span(&list);
        let span = operand.span.to(at);
        let Form::Name(name) = operand.form else {
            return Operand { span, form: self.impossible(span) };
        };
        if operand.span.end != at.start && !words::is_function(name) {
            self.object(SyntaxError::MissingMultiplication {
                fix: format!("{name}*(…)"),
                place: Span::new(operand.span.end, at.start),
                text: "*".to_owned(),
                is_certain: false,
                separator: None,
                instead: None,
                span: Span::new(operand.span.start, at.start + 1),
            });
        }
        let function = Name { text: name.into(), span: operand.span };
        let arguments = self.expressions_in(list);
        let kind = ExprKind::Call { function: &function, arguments: &arguments };
        Operand { span, form: Form::Done(self.push(span, kind)) }
    }

    fn infix<'i>(&self, left: Operand<'i>, sign: &Pair<'i, Rule>, right: Operand<'i>) -> Operand<'i> {
        let span = left.span.to(right.span);
        let at = self.span(sign);
        let form = match sign.as_rule() {
            rule @ (Rule::add | Rule::subtract | Rule::multiply | Rule::divide) => {
                let is_sum = matches!(rule, Rule::add | Rule::subtract);
                let mut members = match (is_sum, left.form) {
                    (true, Form::Sum(members)) | (false, Form::Product(members)) => members,
                    (_, form) => vec![Member::new(false, self.close(Operand { form, ..left }))],
                };
                members.push(Member::new(matches!(rule, Rule::subtract | Rule::divide), self.close(right)));
                if is_sum { Form::Sum(members) } else { Form::Product(members) }
            }
            Rule::equal => self.compare(at, left, Comparison::Equal, right),
            Rule::not_equal => self.compare(at, left, Comparison::NotEqual, right),
            Rule::less => self.compare(at, left, Comparison::Less, right),
            Rule::less_equal => self.compare(at, left, Comparison::LessEqual, right),
            Rule::greater => self.compare(at, left, Comparison::Greater, right),
            Rule::greater_equal => self.compare(at, left, Comparison::GreaterEqual, right),
            rule @ (Rule::and | Rule::or) => {
                self.condition(at);
                let mut members = match (rule, left.form) {
                    (Rule::and, Form::And(members)) | (Rule::or, Form::Or(members)) => members,
                    (_, form) => vec![self.close(Operand { form, ..left })],
                };
                members.push(self.close(right));
                if rule == Rule::and { Form::And(members) } else { Form::Or(members) }
            }
            _ => {
                let base = self.close(left);
                let exponent = self.close(right);
                Form::Done(self.push(span, ExprKind::Power { base, exponent }))
            }
        };
        Operand { span, form }
    }

    fn compare<'i>(&self, at: Span, left: Operand<'i>, operator: Comparison, right: Operand<'i>) -> Form<'i> {
        self.condition(at);
        if let Form::Compare(..) = left.form {
            self.object(SyntaxError::ChainedComparison { first: left.span, span: at });
        }
        Form::Compare(operator, self.close(left), self.close(right))
    }

    /// What is read as a part of a filter, where conditions may stand, or of none.
    pub(super) fn with_filter<T>(&self, is_filter: bool, read: impl FnOnce() -> T) -> T {
        let outside = self.in_filter.replace(is_filter);
        let own = read();
        self.in_filter.set(outside);
        own
    }

    /// Conditions stand only behind `where`.
    fn condition(&self, span: Span) {
        if !self.in_filter.get() {
            self.object(SyntaxError::ConditionOutsideFilter { is_choice: false, span });
        }
    }
}
