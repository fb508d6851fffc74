//! The equations that a file sets up, statement by statement.

use std::collections::BTreeMap;
use std::slice;

use hashbrown::{HashMap, HashSet};

use super::error::Unnamed;
use super::operations::{Context, Equations, Quantity, base, energy, power};
use super::solve::Combination;
use super::{Dimension, DimensionError};
use crate::model::survey::mentions;
use crate::model::units;
use crate::order::Gather;
use crate::span::Span;
use crate::syntax::{
    Binding, ExprKind, ExprRef, File, IndexEntry, IndexKind, Indices, Name, Statement, StatementKind, UnitKind,
    UnitRef, print_expr,
};

/// Families of up to so many members may have a dimension for each.
const MOST_OWN_DIMENSIONS: i64 = 16;

/// What was found out.
#[derive(Debug, Default)]
pub(in crate::model) struct Dimensions {
    pub(in crate::model) errors: Vec<DimensionError>,
    /// By name: what is known of it, for each member where they may differ.
    known: HashMap<String, Vec<Option<Dimension>>>,
    /// Names whose unit says that they are angles.
    angles: HashSet<String>,
}

impl Dimensions {
    /// The SI unit of a coordinate or one of its members (from 0), or of a named expression, where it is known.
    pub(in crate::model) fn unit(&self, name: &str, member: usize) -> Option<String> {
        if self.angles.contains(name) {
            return Some("rad".to_owned());
        }
        let members = self.known.get(name)?;
        let own = if let [only] = members.as_slice() { only } else { members.get(member)? };
        own.as_ref().map(Dimension::unit)
    }

    /// The units of so many members: one for all where they share it.
    pub(in crate::model) fn units(&self, name: &str, count: usize) -> Vec<Option<String>> {
        let own = self.known.get(name).map_or(1, Vec::len);
        let different = if own > 1 && !self.angles.contains(name) { count } else { 1 };
        (0..different).map(|member| self.unit(name, member)).collect()
    }
}

/// Solves for the dimensions of all names, in a file with units; without, nothing is known.
pub(in crate::model) fn infer(file: &File) -> Dimensions {
    if file.units.is_empty() {
        return Dimensions::default();
    }
    let mut inference = Inference {
        file,
        equations: Equations::default(),
        names: HashMap::new(),
        tables: HashSet::new(),
        columns: HashMap::new(),
        scopes: vec![Scope { outer: 0, name: "", table: None, bounds: None }],
        varied: varied_families(file),
        memo: vec![Quantity::Any; file.expressions.len()],
        within: HashMap::new(),
        lists: Default::default(),
    };
    // Energies and what is given may stand before what they use.
    let declares = |own: &&Statement| {
        use StatementKind::{Coord, Let, Param, Table};
        matches!(own.kind, Param(_) | Coord { .. } | Let(_) | Table { .. })
    };
    let (first, then): (Vec<_>, Vec<_>) = file.statements.iter().partition(declares);
    first.into_iter().chain(then).for_each(|statement| inference.statement(statement));
    inference.finish()
}

/// The dimensions of the parameters, coordinates and named expressions of a file with units, as far as these follow from the
/// file and are those of all members.
///
/// ```
/// use librate::{model, syntax};
/// let file = syntax::parse("param k  coord x : m  T = 1/2*x'^2  V = 1/2*k*x^2")?;
/// assert_eq!(model::dimensions(&file).get("k").map(ToString::to_string).as_deref(), Some("a spring constant"));
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
#[must_use]
pub fn dimensions(file: &File) -> BTreeMap<String, Dimension> {
    let known = infer(file).known.into_iter();
    let known = known.filter_map(|(name, own)| {
        Some((name, own.first()?.clone().filter(|first| own.iter().all(|x| x.as_ref() == Some(first)))?))
    });
    known.gather()
}

/// The families that are indexed by more than literals somewhere: their members are alike.
fn varied_families(file: &File) -> HashSet<&str> {
    let mut varied = HashSet::new();
    for expr in file.expressions.iter() {
        if let ExprKind::Index { base, indices } = expr.kind
            && let ExprKind::Name(name) = file.expr(base).kind
            && !indices.iter().all(|at| matches!(file.expr(*at).kind, ExprKind::Number(_)))
        {
            varied.insert(name);
        }
    }
    varied
}

/// An index variable and those around it; number 0 is the empty scope.
pub(super) struct Scope<'a> {
    pub(super) outer: usize,
    pub(super) name: &'a str,
    /// The table whose rows it runs over.
    pub(super) table: Option<&'a str>,
    /// Of an integral: its bounds, and what they are once these are known.
    pub(super) bounds: Option<([ExprRef; 2], Option<Quantity>)>,
}

pub(super) struct Inference<'a> {
    pub(super) file: &'a File,
    pub(super) equations: Equations,
    pub(super) names: HashMap<&'a str, Quantity>,
    pub(super) tables: HashSet<&'a str>,
    pub(super) columns: HashMap<(&'a str, &'a str), Combination>,
    pub(super) scopes: Vec<Scope<'a>>,
    pub(super) varied: HashSet<&'a str>,
    /// By expression: its dimension, taken out by the one that contains it.
    pub(super) memo: Vec<Quantity>,
    /// The scope of the names, rows and sums that stand within one.
    pub(super) within: HashMap<ExprRef, usize>,
    /// Empty lists of expressions, for the next one that is looked at.
    pub(super) lists: [Vec<ExprRef>; 2],
}

impl<'a> Inference<'a> {
    fn statement(&mut self, statement: &'a Statement) {
        let word = |length: u32| Span::new(statement.span.start, statement.span.start + length);
        match &statement.kind {
            StatementKind::Param(bindings) => bindings.iter().for_each(|binding| self.parameter(binding)),
            StatementKind::Coord { declarations } => declarations.iter().for_each(|one| self.coordinate(one)),
            StatementKind::Let(binding) => self.named_expression(binding),
            StatementKind::Kinetic(root) => self.energy("T", *root, &energy(), word(1)),
            StatementKind::Potential(root) => self.energy("V", *root, &energy(), word(1)),
            StatementKind::Lagrangian(root) => self.energy("lagrangian", *root, &energy(), word(10)),
            StatementKind::Dissipation(root) => self.energy("dissipation", *root, &power(), word(11)),
            StatementKind::Force(binding) => self.force(binding),
            StatementKind::Constraint { indices, left, right } => {
                let scope = self.binders(indices.as_deref(), 0);
                let sides = [*left, *right].map(|side| (self.evaluate(side, scope), self.file.expr(side).span));
                self.equations.alike(&sides, &Context::Arguments("the sides of a constraint"));
            }
            StatementKind::Draw { indices, points, .. } => {
                let scope = self.binders(indices.as_deref(), 0);
                for point in points {
                    self.evaluate(*point, scope);
                }
            }
            StatementKind::Assume(relations) => {
                for at in relations {
                    if let ExprKind::Compare { left, right, .. } = self.file.expr(*at).kind {
                        let sides = [left, right].map(|side| (self.evaluate(side, 0), self.file.expr(side).span));
                        self.equations.alike(&sides, &Context::Arguments("the sides of an assumption"));
                    }
                }
            }
            StatementKind::Guess { binding, rate } => self.given(binding, "guess", *rate),
            StatementKind::Equilibrium { binding, rate } => {
                let side = if *rate { "rate" } else { "equilibrium" };
                self.given(binding, side, *rate);
            }
            StatementKind::Period(root) => {
                if self.names_something(*root) {
                    self.energy("period", *root, &base("s"), word(6));
                }
            }
            StatementKind::Table { name, .. } => _ = self.tables.insert(&name.text),
            StatementKind::Model { .. } => {}
        }
    }

    /// The dimension of a unit; what is not known as one fits everything.
    fn unit(&self, at: UnitRef) -> Quantity {
        let exponents = units::dimension(self.file, at);
        exponents.map_or(Quantity::Any, |exponents| Quantity::Of(Combination::from_exponents(exponents)))
    }

    /// A quantity of its own for a name without a unit; one for each member of a small family whose
    /// members are told apart wherever they are used.
    fn fresh(&mut self, name: &'a Name, indices: Option<&Indices>) -> Quantity {
        let members = indices.and_then(|indices| {
            let [IndexEntry { kind: IndexKind::Range { variable: None, from, to }, .. }] = &*indices.entries else {
                return None;
            };
            let (from, to) = (self.whole(*from)?, self.whole(*to)?);
            (from == 1 && (2..=MOST_OWN_DIMENSIONS).contains(&to)).then_some(to)
        });
        match members {
            Some(count) if !self.varied.contains(name.text.as_str()) => {
                let names = (1..=count).map(|at| format!("{}[{at}]", name.text));
                Quantity::list(names.map(|own| Quantity::Of(self.equations.solver.unknown(&own))).collect())
            }
            _ => Quantity::Of(self.equations.solver.unknown(&name.text)),
        }
    }

    /// Whether an expression names a quantity of the file, so that units do not convert it.
    fn names_something(&self, root: ExprRef) -> bool {
        mentions(self.file, root, |name| self.names.contains_key(name))
    }

    fn declare(&mut self, name: &'a str, quantity: Quantity) -> Quantity {
        self.names.entry(name).or_insert(quantity).clone()
    }

    /// What is declared with a unit, or without one.
    fn declared(&mut self, name: &'a Name, indices: Option<&Indices>, unit: Option<UnitRef>) -> Quantity {
        let quantity = unit.map(|unit| self.unit(unit)).unwrap_or_else(|| self.fresh(name, indices));
        self.declare(&name.text, quantity)
    }

    fn parameter(&mut self, binding: &'a Binding) {
        let scope = self.binders(binding.indices.as_deref(), 0);
        let sides = [(binding.value, "right side"), (binding.uncertainty, "uncertainty")];
        let sides = sides.map(|(side, what)| (side.filter(|root| self.names_something(*root)), what));
        let quantity = self.declared(&binding.name, binding.indices.as_deref(), binding.unit);
        self.of_one_kind(binding, &binding.name, &quantity, "unit");
        for (side, what) in sides {
            if let Some(root) = side {
                self.same(binding, &binding.name, &quantity, what, (root, scope));
            }
        }
    }

    /// The unit of what has its dimension already, as a later piece of a family, whose members are all of one kind.
    fn of_one_kind(&mut self, binding: &Binding, name: &Name, known: &Quantity, side: &'static str) {
        if let Some(unit) = binding.unit {
            let (own, span) = (self.unit(unit), self.file.unit(unit).span);
            self.same_at(name, name.span, known, side, own, span);
        }
    }

    fn coordinate(&mut self, declaration: &'a Binding) {
        self.binders(declaration.indices.as_deref(), 0);
        self.declared(&declaration.name, declaration.indices.as_deref(), declaration.unit);
    }

    fn named_expression(&mut self, binding: &'a Binding) {
        let Some(root) = binding.value else { return };
        let scope = self.binders(binding.indices.as_deref(), 0);
        let names = self.names_something(root);
        if names && binding.unit.is_none() && binding.indices.is_none() {
            let quantity = self.evaluate(root, scope);
            self.declare(&binding.name.text, quantity);
            return;
        }
        // A member of a family may use lower ones: the family has its dimension first.
        let quantity = match binding.unit {
            Some(unit) => self.unit(unit),
            None => Quantity::Of(self.equations.solver.unknown(&binding.name.text)),
        };
        let quantity = self.declare(&binding.name.text, quantity);
        self.of_one_kind(binding, &binding.name, &quantity, "unit");
        if names {
            self.same(binding, &binding.name, &quantity, "right side", (root, scope));
        }
    }

    /// A generalised force times the velocity is a power.
    fn force(&mut self, binding: &'a Binding) {
        let Some(coordinate) = self.names.get(binding.name.text.as_str()).cloned() else { return };
        let name = Name { text: format!("force {}", binding.name.text), span: binding.name.span };
        self.stated(binding, coordinate.conjugate(), "right side", name);
    }

    fn given(&mut self, binding: &'a Binding, side: &'static str, rate: bool) {
        let Some(mut quantity) = self.names.get(binding.name.text.as_str()).cloned() else { return };
        let mut name = binding.name.clone();
        if rate {
            quantity = quantity.rate();
            name.text.push('\'');
        }
        self.stated(binding, quantity, side, name);
    }

    /// What a statement gives, in its unit and by its right side.
    fn stated(&mut self, binding: &'a Binding, quantity: Quantity, side: &'static str, name: Name) {
        let scope = self.binders(binding.indices.as_deref(), 0);
        self.of_one_kind(binding, &name, &quantity, side);
        if let Some(root) = binding.value.filter(|root| self.names_something(*root)) {
            self.same(binding, &name, &quantity, side, (root, scope));
        }
    }

    /// Requires a right side, read in a scope, to be what its name is.
    fn same(&mut self, binding: &Binding, name: &Name, known: &Quantity, side: &'static str, at: (ExprRef, usize)) {
        let value = self.evaluate(at.0, at.1);
        let declared = binding.unit.map_or(name.span, |unit| self.file.unit(unit).span);
        self.same_at(name, declared, known, side, value, self.file.expr(at.0).span);
    }

    /// Requires one quantity to be what another is.
    fn same_at(
        &mut self,
        name: &Name,
        declared_span: Span,
        quantity: &Quantity,
        side: &'static str,
        value: Quantity,
        span: Span,
    ) {
        let wanted = match (quantity, &value) {
            (Quantity::Any, _) | (_, Quantity::Any) => return,
            (Quantity::Of(_), Quantity::Of(_)) => vec![(quantity.clone(), value)],
            (Quantity::List(own), Quantity::List(parts)) if own.len() != parts.len() => return,
            (Quantity::List(own), _) => {
                (0..own.len()).filter_map(|at| Some((own.get(at)?.clone(), value.element(at)?))).collect()
            }
            (Quantity::Of(_), Quantity::List(parts)) => {
                parts.iter().map(|part| (quantity.clone(), part.clone())).collect()
            }
        };
        for (quantity, value) in wanted {
            match (quantity, value) {
                (Quantity::Of(own), Quantity::Of(value)) => {
                    let error = |found, declared, inferred| {
                        let name = name.text.to_string();
                        DimensionError::WrongSide { name, declared, declared_span, side, found, span, inferred }
                    };
                    let before = self.equations.errors.len();
                    self.equations.require([&value, &own], span, error);
                    if self.equations.errors.len() > before {
                        return;
                    }
                }
                (Quantity::Any, _) | (_, Quantity::Any) => {}
                (quantity, value) => {
                    let value = self.equations.uniform(value, "the elements of a list", span);
                    self.same_at(name, declared_span, &quantity, side, value, span);
                }
            }
        }
    }

    /// Requires every term of an energy, those within sums included, to be one.
    fn energy(&mut self, what: &'static str, root: ExprRef, wanted: &Combination, statement: Span) {
        let mut todo = vec![(root, 0)];
        while let Some((at, scope)) = todo.pop() {
            let span = self.file.expr(at).span;
            match self.file.expr(at).kind {
                ExprKind::Sum(terms) => todo.extend(terms.iter().rev().map(|term| (term.value(), scope))),
                ExprKind::Negate(inner) => todo.push((inner, scope)),
                ExprKind::SumOver { indices, body } => {
                    let inner = self.binders(Some(indices), scope);
                    todo.push((body, inner));
                }
                _ => {
                    let value = self.evaluate(at, scope);
                    let own = self.equations.uniform(value, "the terms", span);
                    let Quantity::Of(own) = own else { continue };
                    self.equations.require([&own, wanted], span, |found, wanted, inferred| {
                        DimensionError::WrongEnergy { what, found, wanted, span, statement, inferred }
                    });
                }
            }
        }
    }

    fn finish(mut self) -> Dimensions {
        let mut result = Dimensions::default();
        for statement in &self.file.statements {
            let coordinates = statement.kind.coordinates();
            for name in statement.kind.declared() {
                let Some(quantity) = self.names.get(name.text.as_str()) else { continue };
                let parts = match quantity {
                    Quantity::List(parts) if !coordinates.is_empty() => parts.as_slice(),
                    all => slice::from_ref(all),
                };
                let known = parts.iter().map(|part| self.of_all(part)).collect();
                result.known.insert(name.text.to_string(), known);
            }
            let angles = coordinates.iter().filter(|one| one.unit.is_some_and(|unit| self.is_angle(unit)));
            result.angles.extend(angles.map(|one| one.name.text.to_string()));
        }
        result.errors = std::mem::take(&mut self.equations.errors);
        for error in &mut result.errors {
            if let DimensionError::UnlikeTerms { span, found, other, other_span, unnamed, .. }
            | DimensionError::UnlikeArguments { span, found, other, other_span, unnamed, .. } = error
            {
                *unnamed = self.unnamed(*span, other).or_else(|| self.unnamed(*other_span, found));
            }
        }
        result
    }

    /// The declaration of the number at a place, if one stands there, as something of that dimension.
    fn unnamed(&self, span: Span, dimension: &Dimension) -> Option<Box<Unnamed>> {
        let at = self.file.expressions.iter().position(|own| own.span == span)?;
        let at = ExprRef(u32::try_from(at).ok()?);
        let number = print_expr(self.file, at);
        let is_number =
            !mentions(self.file, at, |_| true) && number.chars().all(|c| c.is_ascii_digit() || "./*-()e".contains(c));
        let name = ["a", "b", "c", "d", "e"].into_iter().find(|own| !self.names.contains_key(own))?;
        let declaration = format!("param {name} : {} = {number}", dimension.unit());
        (is_number && !dimension.is_number()).then(|| Box::new(Unnamed { number, declaration }))
    }

    /// The dimension of all elements, where these are alike; zeros fit any.
    fn of_all(&self, quantity: &Quantity) -> Option<Dimension> {
        let mut todo = vec![quantity];
        let mut found: Option<Dimension> = None;
        while let Some(next) = todo.pop() {
            match next {
                Quantity::Any => {}
                Quantity::List(parts) => todo.extend(parts),
                Quantity::Of(own) => {
                    let own = self.equations.known(own)?;
                    if found.get_or_insert_with(|| own.clone()) != &own {
                        return None;
                    }
                }
            }
        }
        found
    }

    fn is_angle(&self, unit: UnitRef) -> bool {
        match self.file.unit(unit).kind {
            UnitKind::Name(name) => name.ends_with("rad") || name == "deg" || name == "rev",
            UnitKind::One | UnitKind::Product(_) | UnitKind::Power { .. } => false,
        }
    }
}
