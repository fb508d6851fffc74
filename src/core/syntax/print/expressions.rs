//! Expressions, indices and units; here alone is decided where parentheses stand.

use super::super::ast::{ExprKind, ExprRef, IndexKind, Indices, Member, Name, UnitKind, UnitRef};
use super::{Break, Group, Job, Manner, Printer, Sink};

/// Binding strengths, weakest first; [`Strength::Any`] asks for no parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Strength {
    Any,
    Or,
    And,
    Not,
    Compare,
    Sum,
    Product,
    Negate,
    Power,
    Number,
    Postfix,
}

fn strength(kind: &ExprKind) -> Strength {
    match kind {
        ExprKind::Or(_) => Strength::Or,
        ExprKind::And(_) => Strength::And,
        ExprKind::Not(_) => Strength::Not,
        ExprKind::Compare { .. } => Strength::Compare,
        ExprKind::Sum(_) => Strength::Sum,
        ExprKind::Product(_) => Strength::Product,
        ExprKind::Negate(_) => Strength::Negate,
        ExprKind::Power { .. } => Strength::Power,
        // A number can't be primed or indexed.
        ExprKind::Number(_) => Strength::Number,
        ExprKind::Name(_)
        | ExprKind::Index { .. }
        | ExprKind::Field { .. }
        | ExprKind::Prime(_)
        | ExprKind::Call { .. }
        | ExprKind::SumOver { .. }
        | ExprKind::IntegralOver { .. }
        | ExprKind::Vector(_) => Strength::Postfix,
    }
}

impl<'f, S: Sink<'f>> Printer<'f, S> {
    /// A list with its brackets.
    fn list(&mut self, brackets: [&'static str; 2], members: &[ExprRef], group: Group) {
        self.members(brackets, members, group, Break::Weak, Manner::Wide);
    }

    fn members(
        &mut self,
        brackets: [&'static str; 2],
        members: &[ExprRef],
        group: Group,
        first: Break,
        manner: Manner,
    ) {
        self.token(brackets[0]);
        self.open(group);
        for (position, member) in members.iter().enumerate() {
            if position == 0 {
                self.place(first, "");
            } else {
                self.token(",");
                self.place(Break::Member, if manner == Manner::Tight { "" } else { " " });
            }
            self.child(*member, Strength::Any, manner);
        }
        self.close();
        self.token(brackets[1]);
    }

    fn subscript(&mut self, members: &[ExprRef]) {
        let simple = members.iter().all(|member| self.is_simple(*member));
        let manner = if simple { Manner::Tight } else { Manner::Wide };
        self.members(["[", "]"], members, Group::List, Break::Hidden, manner);
    }

    /// Whether an index is a sum of literals, names, fields, and products of these: `2*i-1`.
    fn is_simple(&self, at: ExprRef) -> bool {
        match self.file.expr(at).kind {
            ExprKind::Sum(terms) => terms.iter().all(|term| self.is_simple_term(term.value())),
            _ => self.is_simple_term(at),
        }
    }

    fn is_simple_term(&self, at: ExprRef) -> bool {
        match self.file.expr(at).kind {
            ExprKind::Product(factors) => factors.iter().all(|factor| self.is_leaf(factor.value())),
            ExprKind::Negate(inner) => self.is_leaf(inner),
            _ => self.is_leaf(at),
        }
    }

    fn is_leaf(&self, at: ExprRef) -> bool {
        match self.file.expr(at).kind {
            ExprKind::Field { base, .. } => matches!(self.file.expr(base).kind, ExprKind::Name(_)),
            kind => matches!(kind, ExprKind::Number(_) | ExprKind::Name(_)),
        }
    }

    /// Conditions with a word between them.
    fn joined(&mut self, members: &[ExprRef], word: &'static str, least: Strength, manner: Manner) {
        self.open(Group::Other);
        for (position, member) in members.iter().enumerate() {
            if position > 0 {
                self.between(Break::Member, word);
            }
            self.child(*member, least, manner);
        }
        self.close();
    }

    fn product(&mut self, factors: &[Member], manner: Manner) {
        self.open(Group::Other);
        for (position, factor) in factors.iter().enumerate() {
            if position > 0 {
                self.place(Break::Factor, "");
                self.token(if factor.inverted() { "/" } else { "*" });
            }
            self.child(factor.value(), Strength::Negate, manner);
        }
        self.close();
    }

    fn sum(&mut self, terms: &[Member], whole: bool, manner: Manner) {
        let tight = manner == Manner::Tight;
        self.open(match (tight, whole) {
            (true, _) => Group::Other,
            (false, true) => Group::WholeSum,
            (false, false) => Group::Sum,
        });
        for (position, term) in terms.iter().enumerate() {
            if position > 0 {
                let (kind, blank) = if tight { (Break::Hidden, "") } else { (Break::Member, " ") };
                self.place(kind, blank);
                self.token(if term.inverted() { "-" } else { "+" });
                if !tight {
                    self.blank();
                }
            }
            self.child(term.value(), Strength::Product, manner);
        }
        self.close();
    }

    pub(super) fn expr(&mut self, at: ExprRef, least: Strength, manner: Manner) {
        let file = self.file;
        let kind = &file.expr(at).kind;
        let grouped = strength(kind) < least;
        if grouped {
            self.token("(");
            self.open(Group::Other);
            self.place(Break::Weak, "");
        }
        let inner_manner = manner.inner();
        match kind {
            ExprKind::Number(text) | ExprKind::Name(text) => self.token(*text),
            ExprKind::Index { base, indices } => {
                self.child(*base, Strength::Postfix, inner_manner);
                self.subscript(indices);
            }
            ExprKind::Field { base, field } => {
                self.child(*base, Strength::Postfix, inner_manner);
                self.token(".");
                self.token(field.text.as_str());
            }
            ExprKind::Prime(base) => {
                self.child(*base, Strength::Postfix, inner_manner);
                self.token("'");
            }
            ExprKind::Negate(inner) => {
                self.token("-");
                self.place(Break::Hidden, "");
                self.child(*inner, Strength::Negate, inner_manner);
            }
            ExprKind::Power { base, exponent } => {
                self.child(*base, Strength::Number, inner_manner);
                self.place(Break::Hidden, "");
                self.token("^");
                self.child(*exponent, Strength::Negate, inner_manner);
            }
            ExprKind::Product(factors) => self.product(factors, inner_manner),
            ExprKind::Sum(terms) => self.sum(terms, manner == Manner::Whole, inner_manner),
            ExprKind::Call { function, arguments } => {
                self.token(function.text.as_str());
                self.list(["(", ")"], arguments, Group::List);
            }
            ExprKind::SumOver { indices, body } | ExprKind::IntegralOver { indices, body } => {
                self.token(if matches!(kind, ExprKind::SumOver { .. }) { "sum" } else { "integral" });
                self.token("(");
                self.open(Group::Other);
                self.place(Break::Weak, "");
                self.next.push(Job::Indices(indices, false));
                self.token(",");
                self.place(Break::Member, " ");
                self.child(*body, Strength::Any, Manner::Wide);
                self.close();
                self.token(")");
            }
            ExprKind::Vector(members) => {
                let group = if manner == Manner::Whole { Group::WholeList } else { Group::List };
                self.list(["[", "]"], members, group);
            }
            ExprKind::Compare { operator, left, right } => {
                self.open(Group::Other);
                self.child(*left, Strength::Sum, inner_manner);
                self.between(Break::Fill, operator.sign());
                self.child(*right, Strength::Sum, inner_manner);
                self.close();
            }
            ExprKind::Not(inner) => {
                self.token("not");
                self.place(Break::Hidden, " ");
                self.child(*inner, Strength::Not, inner_manner);
            }
            ExprKind::And(members) => self.joined(members, "and", Strength::Not, inner_manner),
            ExprKind::Or(members) => self.joined(members, "or", Strength::And, inner_manner),
        }
        if grouped {
            self.close();
            self.token(")");
        }
    }

    /// `i in`
    fn variable(&mut self, name: &'f Name) {
        self.token(name.text.as_str());
        self.blank();
        self.token("in");
        self.place(Break::Hidden, " ");
    }

    pub(super) fn indices(&mut self, indices: &'f Indices, brackets: bool) {
        if brackets {
            self.token("[");
            self.open(Group::Other);
            self.place(Break::Weak, "");
        }
        for (position, entry) in indices.entries.iter().enumerate() {
            self.comma(position);
            match &entry.kind {
                IndexKind::Member(at) => self.child(*at, Strength::Any, Manner::Tight),
                IndexKind::Range { variable, from, to } => {
                    if let Some(variable) = variable {
                        self.variable(variable);
                    }
                    self.child(*from, Strength::Any, Manner::Tight);
                    self.place(Break::Hidden, "");
                    self.token("..");
                    self.child(*to, Strength::Any, Manner::Tight);
                }
                IndexKind::Rows { variable, table } => {
                    self.variable(variable);
                    self.token(table.text.as_str());
                }
            }
        }
        if let Some(filter) = indices.filter {
            self.between(Break::Fill, "where");
            self.child(filter, Strength::Any, Manner::Wide);
        }
        if brackets {
            self.close();
            self.token("]");
        }
    }

    pub(super) fn unit(&mut self, at: UnitRef, grouped: bool) {
        let file = self.file;
        match &file.unit(at).kind {
            UnitKind::One => self.token("1"),
            UnitKind::Name(name) => self.token(*name),
            UnitKind::Product(factors) => {
                if grouped {
                    self.token("(");
                }
                for (position, (divided, factor)) in factors.iter().enumerate() {
                    if position > 0 {
                        self.place(Break::Hidden, "");
                        self.token(if *divided { "/" } else { "*" });
                    }
                    self.next.push(Job::Unit(*factor, true));
                }
                if grouped {
                    self.token(")");
                }
            }
            UnitKind::Power { base, numerator, denominator } => {
                // Powers of powers need the parentheses, powers in products don't.
                let power = matches!(file.unit(*base).kind, UnitKind::Power { .. });
                if power {
                    self.token("(");
                }
                self.next.push(Job::Unit(*base, true));
                if power {
                    self.token(")");
                }
                self.exponent(*numerator, *denominator);
            }
        }
    }

    fn exponent(&mut self, numerator: i32, denominator: i32) {
        self.token("^");
        if denominator != 1 {
            self.token("(");
        }
        if numerator < 0 {
            self.token("-");
        }
        self.token(numerator.unsigned_abs().to_string());
        if denominator != 1 {
            self.token("/");
            self.token(denominator.to_string());
            self.token(")");
        }
    }
}
