//! Statements, token by token.

use super::super::ast::{Binding, ExprRef, Indices, Statement, StatementKind, UnitRef};
use super::expressions::Strength;
use super::{Break, Group, Job, Manner, Printer, Sink};

impl<'f, S: Sink<'f>> Printer<'f, S> {
    /// The word and the blank behind it.
    fn word(&mut self, word: &'static str) {
        self.token(word);
        self.place(Break::Weak, " ");
    }

    fn put_expr(&mut self, at: ExprRef) {
        self.child(at, Strength::Any, Manner::Wide);
    }

    /// `= EXPR`
    fn value(&mut self, at: ExprRef) {
        self.blank();
        self.token("=");
        self.place(Break::Weak, " ");
        self.child(at, Strength::Any, Manner::Whole);
    }

    fn head(&mut self, name: &'f str, indices: Option<&'f Indices>, rate: bool, unit: Option<UnitRef>) {
        self.token(name);
        if let Some(indices) = indices {
            self.next.push(Job::Indices(indices, true));
        }
        if rate {
            self.token("'");
        }
        if let Some(unit) = unit {
            self.place(Break::Hidden, " ");
            self.token(":");
            self.blank();
            self.next.push(Job::Unit(unit, false));
        }
    }

    fn binding(&mut self, word: &'static str, binding: &'f Binding, rate: bool) {
        self.word(word);
        self.head(&binding.name.text, binding.indices.as_deref(), rate, binding.unit);
        self.right_side(binding);
    }

    /// `param a, b : kg = 1, c`: what two names share is behind the second.
    fn parameters(&mut self, bindings: &'f [Binding]) {
        self.listed("param", bindings, |own, position, binding| {
            let next = bindings.get(position + 1).filter(|next| next.value == binding.value);
            let unit = binding.unit.filter(|unit| next.is_none_or(|next| next.unit != Some(*unit)));
            own.head(&binding.name.text, binding.indices.as_deref(), false, unit);
            if next.is_none() {
                own.right_side(binding);
            }
        });
    }

    /// A word, and behind it some things with commas between them.
    fn listed<T>(&mut self, word: &'static str, all: &'f [T], mut put: impl FnMut(&mut Self, usize, &'f T)) {
        self.word(word);
        self.open(Group::Other);
        for (position, one) in all.iter().enumerate() {
            self.comma(position);
            put(self, position, one);
        }
        self.close();
    }

    /// `[i in 1..n]` before what holds for each, if it is there.
    fn for_each(&mut self, indices: Option<&'f Indices>) {
        if let Some(indices) = indices {
            self.next.push(Job::Indices(indices, true));
            self.place(Break::Weak, " ");
        }
    }

    /// `= EXPR ± EXPR`, where there is a value.
    fn right_side(&mut self, binding: &'f Binding) {
        if let Some(value) = binding.value {
            self.value(value);
        }
        if let Some(uncertainty) = binding.uncertainty {
            self.between(Break::Fill, self.plus_minus);
            self.put_expr(uncertainty);
        }
    }

    fn equation(&mut self, word: &'static str, value: ExprRef) {
        self.token(word);
        self.value(value);
    }

    /// Writes a statement.
    pub(in super::super) fn statement(&mut self, statement: &'f Statement) {
        self.parts(statement);
        self.run();
    }

    fn parts(&mut self, statement: &'f Statement) {
        match &statement.kind {
            StatementKind::Model { name } => {
                self.word("model");
                self.token(name.text.as_str());
            }
            StatementKind::Param(bindings) => match bindings.as_slice() {
                [binding] => self.binding("param", binding, false),
                bindings => self.parameters(bindings),
            },
            StatementKind::Coord { declarations } => self.listed("coord", declarations, |own, _, declared| {
                own.head(&declared.name.text, declared.indices.as_deref(), false, declared.unit);
            }),
            StatementKind::Let(binding) => self.binding("let", binding, false),
            StatementKind::Kinetic(value) => self.equation("T", *value),
            StatementKind::Potential(value) => self.equation("V", *value),
            StatementKind::Lagrangian(value) => self.equation("lagrangian", *value),
            StatementKind::Dissipation(value) => self.equation("dissipation", *value),
            StatementKind::Force(binding) => self.binding("force", binding, false),
            StatementKind::Constraint { indices, left, right } => {
                self.word("constraint");
                self.for_each(indices.as_deref());
                self.put_expr(*left);
                self.between(Break::Fill, "=");
                self.put_expr(*right);
            }
            StatementKind::Draw { drawn, indices, points } => {
                self.word("draw");
                self.token(drawn.as_str());
                self.blank();
                self.for_each(indices.as_deref());
                for (position, point) in points.iter().enumerate() {
                    self.comma(position);
                    self.put_expr(*point);
                }
            }
            StatementKind::Assume(relations) => {
                self.listed("assume", relations, |own, _, relation| own.put_expr(*relation));
            }
            StatementKind::Guess { binding, rate } => self.binding("guess", binding, *rate),
            StatementKind::Equilibrium { binding, rate } => self.binding("equilibrium", binding, *rate),
            StatementKind::Period(value) => {
                self.word("period");
                self.put_expr(*value);
            }
            StatementKind::Table { name, path, .. } => {
                self.word("table");
                self.token(name.text.as_str());
                self.blank();
                self.token("=");
                self.place(Break::Weak, " ");
                self.token("\"");
                self.token(path.as_str());
                self.token("\"");
            }
        }
    }
}
