//! From syntax to programs: names are looked up here, once, and every mistake is collected.

use std::cell::OnceCell;

use hashbrown::HashMap;

use super::ModelError;
use super::functions::{Builtin, check_count};
use super::names::{Entity, World};
use super::program::{Binder, Field, IndexOp, IndexProgram, Op, Program, SumProgram};
use super::survey::{declared_names, mentions};
use crate::diagnostic::Meant;
use crate::expr::ExprId;
use crate::number::Number;
use crate::span::Span;
use crate::syntax::{self, ExprKind, ExprRef, File, IndexEntry, IndexKind, Indices, Member, Name, Statement};

/// Mistakes beyond this number are not reported.
pub(super) const MOST_ERRORS: usize = 1000;

/// What an index variable in scope holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variable {
    Index,
    Row(usize),
    /// The row of what is no table, which is reported already.
    RowOfNone,
}

/// The index variables in scope; the place in the list is the slot.
#[derive(Clone, Debug, Default)]
pub(super) struct Scope {
    pub(super) variables: Vec<(String, Variable)>,
    /// The variables of the integrals around the place, which have no slots.
    pub(super) integrated: Vec<(String, ExprId)>,
}

impl Scope {
    /// The symbol of the integral over a variable of this name.
    pub(super) fn integrated(&self, name: &str) -> Option<ExprId> {
        self.integrated.iter().find(|(own, _)| own == name).map(|(_, symbol)| *symbol)
    }

    pub(super) fn find(&self, name: &str) -> Option<(usize, Variable)> {
        let slot = self.variables.iter().rposition(|(own, _)| own == name)?;
        Some((slot, self.variables[slot].1))
    }
}

/// Compiles expressions of one file; mistakes are collected in `errors`.
pub(super) struct Compiler<'a> {
    pub(super) file: &'a File,
    pub(super) world: &'a mut World,
    /// Where names are declared that are not yet declared here.
    pub(super) later: &'a OnceCell<HashMap<String, Span>>,
    pub(super) errors: &'a mut Vec<ModelError>,
    /// Deepest nesting of `let` families read so far.
    pub(super) depth: usize,
    /// How many members of other families the value reads, through all the families below.
    pub(super) cost: u64,
    /// The `let` family being compiled reads itself.
    pub(super) recursive: bool,
    pub(super) current_let: Option<usize>,
}

/// What is left to do: an expression, or an operation on what others leave.
pub(super) enum Task<O = Op> {
    Visit(ExprRef),
    Emit(O, Span),
}

/// An operation on what its children leave.
pub(super) fn then<O>(tasks: &mut Vec<Task<O>>, op: O, span: Span, children: &[ExprRef]) {
    tasks.push(Task::Emit(op, span));
    tasks.extend(children.iter().rev().map(|child| Task::Visit(*child)));
}

/// Which terms or factors have a sign before them, and what they are.
pub(super) fn apart(members: &[Member]) -> (Box<[bool]>, Vec<ExprRef>) {
    (members.iter().map(|own| own.inverted()).collect(), members.iter().map(|own| own.value()).collect())
}

impl<'a> Compiler<'a> {
    pub(super) fn new(
        file: &'a File,
        world: &'a mut World,
        later: &'a OnceCell<HashMap<String, Span>>,
        errors: &'a mut Vec<ModelError>,
    ) -> Self {
        Self { file, world, later, errors, depth: 0, cost: 0, recursive: false, current_let: None }
    }

    pub(super) fn fail(&mut self, error: ModelError) {
        // More mistakes than this are of no use to anybody.
        if self.errors.len() < MOST_ERRORS {
            self.errors.push(error);
        }
    }

    /// The same for an expression that can't be compiled.
    fn refuse(&mut self, error: ModelError, span: Span, tasks: &mut Vec<Task>) {
        self.fail(error);
        tasks.push(Task::Emit(Op::Broken, span));
    }

    /// Reports a name that is not declared, with the indices behind it; `span` is the place of both.
    pub(super) fn undeclared(&mut self, name: &str, indices: &[ExprRef], span: Span, scope: &Scope) {
        if self.errors.len() >= MOST_ERRORS {
            return;
        }
        let later = self.declared_later(name);
        if let Some(error) = later.and_then(|later| self.circular(name, later, span)) {
            self.errors.push(error);
            return;
        }
        // Suggestions are for people, who neither make nor read hundreds of such mistakes.
        let few = later.is_none() && self.errors.len() < 50 && self.world.names.len() < 10_000;
        let by_place = if few { self.twin(name) } else { None };
        let few = few && by_place.is_none();
        let nearest = if few { self.meant(name, indices, scope) } else { None };
        // What moves is a coordinate of its own, unless it is one in another notation.
        let is_own = nearest.as_ref().is_none_or(|own| !own.is_certain && !own.text.ends_with('\''));
        let integral = if few && is_own { self.integral_over(name) } else { None };
        let coordinate = if few && is_own { self.missing_coordinate(name, span, scope) } else { None };
        let again = |error: &ModelError| matches!(error, ModelError::UndeclaredName { name: own, coordinate: Some(_), .. } if own == name);
        if coordinate.is_some() && self.errors.iter().any(again) {
            return;
        }
        let name = name.to_owned();
        self.errors.push(ModelError::UndeclaredName { name, span, nearest, later, integral, coordinate, by_place });
    }

    /// Where the file declares a name; looked for only once one is missing.
    pub(super) fn declared_later(&self, name: &str) -> Option<Span> {
        self.later.get_or_init(|| declared_names(self.file)).get(name).copied()
    }

    /// `param m = m`, and `let a = b` where `b` is declared later and uses `a`.
    fn circular(&self, name: &str, later: Span, span: Span) -> Option<ModelError> {
        let holds = |own: &&Statement, place: Span| own.span.start <= place.start && place.end <= own.span.end;
        let user = self.file.statements.iter().find(|own| holds(own, span))?;
        let through = Some(name.to_owned());
        let own: Vec<&Name> = user.kind.declared().collect();
        if let Some(own) = own.iter().find(|own| own.text.as_str() == name) {
            (own.span.end <= span.start).then_some(())?;
            return Some(ModelError::RecursiveLet { name: own.text.to_string(), through, span });
        }
        let [user] = own.as_slice() else { return None };
        let definition = self.file.statements.iter().find(|own| holds(own, later))?;
        // Members of two families may use each other.
        definition.kind.indices().next().is_none().then_some(())?;
        let mut values = definition.kind.bindings().iter().filter_map(|own| own.value);
        let uses = values.any(|value| mentions(self.file, value, |own| own == user.text.as_str()));
        uses.then(|| ModelError::RecursiveLet { name: user.text.to_string(), through, span })
    }

    /// The same where a table or a row of one belongs.
    pub(super) fn undeclared_table(&mut self, name: &str, span: Span, scope: &Scope) {
        let rows = scope.variables.iter().filter(|(_, own)| matches!(own, Variable::Row(_)));
        let known = rows.map(|(own, _)| own.as_str()).chain(self.world.tables.iter().map(|own| own.name.as_str()));
        let nearest = Meant::near(name, known);
        let later = self.declared_later(name);
        let by_place = nearest.is_none().then(|| {
            let row = format!("a row of one by an index: `{name} in TABLE`");
            Box::new(("unknown name", format!("declare a table by `table {name} = \"file.csv\"`, {row}")))
        });
        let (name, integral, coordinate) = (name.to_owned(), None, None);
        self.fail(ModelError::UndeclaredName { name, span, nearest, later, integral, coordinate, by_place });
    }

    pub(super) fn entity(&self, name: &str) -> Option<Entity> {
        self.world.names.get(name).map(|(entity, _)| *entity)
    }

    /// Compiles an expression that yields a value.
    pub(super) fn value(&mut self, root: ExprRef, scope: &mut Scope) -> Program {
        let mut program = Program { ops: Vec::with_capacity(8), span: self.file.expr(root).span };
        let mut tasks = Vec::with_capacity(8);
        tasks.push(Task::Visit(root));
        while let Some(task) = tasks.pop() {
            match task {
                Task::Emit(op, span) => program.ops.push((op, span)),
                Task::Visit(at) => self.visit(at, scope, &mut tasks),
            }
        }
        program
    }

    fn visit(&mut self, at: ExprRef, scope: &mut Scope, tasks: &mut Vec<Task>) {
        let file = self.file;
        let expr = file.expr(at);
        let span = expr.span;
        let then = |tasks: &mut Vec<Task>, op: Op, children: &[ExprRef]| then(tasks, op, span, children);
        match &expr.kind {
            ExprKind::Number(text) => {
                let number = self.literal(text, span);
                let op = Op::Literal(self.world.pool.number(number));
                tasks.push(Task::Emit(op, span));
            }
            ExprKind::Name(name) => {
                let op = self.read(name, span, &[], scope);
                tasks.push(Task::Emit(op, span));
            }
            ExprKind::Index { .. } => {
                if let Some(error) = self.foreign_index(at, scope) {
                    return self.refuse(error, span, tasks);
                }
                let (base, indices) = self.flatten_index(at);
                let compiled: Vec<IndexProgram> = indices.iter().map(|index| self.index(*index, scope)).collect();
                if let ExprKind::Name(name) = &file.expr(base).kind
                    && scope.find(name).is_none()
                {
                    let op = if self.entity(name).is_some() {
                        self.read(name, span, &compiled, scope)
                    } else {
                        self.undeclared(name, &indices, span, scope);
                        Op::Broken
                    };
                    tasks.push(Task::Emit(op, span));
                } else {
                    then(tasks, Op::Component(compiled.into()), &[base]);
                }
            }
            ExprKind::Field { base, field } => {
                let op = self.field(*base, field, scope).map_or(Op::Broken, Op::Field);
                tasks.push(Task::Emit(op, span));
            }
            ExprKind::Prime(inner) => then(tasks, Op::Prime, &[*inner]),
            ExprKind::Negate(inner) => then(tasks, Op::Negate, &[*inner]),
            ExprKind::Power { base, exponent } => {
                if let Some(error) = self.foreign_power(at, scope) {
                    return self.refuse(error, span, tasks);
                }
                tasks.extend([Op::Power, Op::EndExponent].map(|op| Task::Emit(op, span)));
                tasks.extend([Task::Visit(*exponent), Task::Emit(Op::BeginExponent, span), Task::Visit(*base)]);
            }
            ExprKind::Product(factors) => {
                if let Some((at, error)) = self.foreign_quotient(factors) {
                    let others = factors.iter().enumerate().filter(|(own, _)| *own != at && *own != at + 1);
                    let others: Vec<ExprRef> = others.map(|(_, own)| own.value()).collect();
                    then(tasks, Op::Together(others.len()), &others);
                    return self.refuse(error, span, tasks);
                }
                let (divided, children) = apart(factors);
                then(tasks, Op::Product(divided), &children);
            }
            ExprKind::Sum(terms) => {
                let (subtracted, children) = apart(terms);
                then(tasks, Op::Sum(subtracted), &children);
            }
            ExprKind::Call { function, arguments } => self.call(at, function, arguments, scope, tasks),
            ExprKind::SumOver { indices, body } => {
                let outer = scope.variables.len();
                let (binders, filter) = self.binders(indices, scope);
                let body = self.value(*body, scope);
                scope.variables.truncate(outer);
                let sum = SumProgram { binders, filter, body };
                tasks.push(Task::Emit(Op::SumOver(Box::new(sum)), span));
            }
            ExprKind::IntegralOver { indices, body } => self.integral(indices, *body, span, scope, tasks),
            ExprKind::Vector(parts) => then(tasks, Op::Vector(parts.len()), parts),
            ExprKind::Compare { .. } | ExprKind::Not(_) | ExprKind::And(_) | ExprKind::Or(_) => {
                let what = "a condition where a value is expected; conditions are allowed only after `where`";
                self.refuse(ModelError::ConditionOrValue { what, span }, span, tasks);
            }
        }
    }

    fn call(&mut self, at: ExprRef, function: &Name, arguments: &[ExprRef], scope: &mut Scope, tasks: &mut Vec<Task>) {
        let span = self.file.expr(at).span;
        if matches!(function.text.as_str(), "mod" | "floor" | "rows") {
            let before = self.errors.len();
            let number = self.index(at, scope);
            for error in self.errors.iter_mut().skip(before) {
                if let ModelError::NotForIndices { inside, .. } = error {
                    *inside = Some(function.text.to_string());
                }
            }
            tasks.push(Task::Emit(Op::Number(number), span));
            return;
        }
        if let Some(error) = self.foreign_call(function, arguments, span) {
            return self.refuse(error, span, tasks);
        }
        let builtin = Builtin::from_name(&function.text);
        let error = builtin.and_then(|_| check_count(function, arguments.len(), span));
        if let (Some(builtin), None) = (builtin, &error) {
            self.world.rigid |= matches!(builtin, Builtin::AngularVelocity | Builtin::Steiner | Builtin::About);
            return then(tasks, Op::Call(builtin, arguments.len()), span, arguments);
        }
        match error {
            Some(error) => self.fail(error),
            None => self.unknown_function(function, arguments, span, scope),
        }
        then(tasks, Op::Together(arguments.len()), span, arguments);
        // Stands before what its arguments leave: the run ends there.
        tasks.push(Task::Emit(Op::Broken, span));
    }

    /// Its bounds stand on the stack; its form depends on the numbers in it, as a power does on its exponent.
    fn integral(&mut self, range: &Indices, body: ExprRef, span: Span, scope: &mut Scope, tasks: &mut Vec<Task>) {
        let [IndexEntry { kind: IndexKind::Range { variable: Some(name), from, to }, .. }] = &*range.entries else {
            tasks.push(Task::Emit(Op::Broken, span));
            return;
        };
        self.new_index(name, scope);
        let variable = self.world.pool.fresh_symbol(&name.text);
        scope.integrated.push((name.text.to_string(), self.world.pool.symbol_expr(variable)));
        let body = self.value(body, scope);
        scope.integrated.pop();
        let op = Op::Integral(variable, Box::new(body));
        tasks.extend([Task::Emit(Op::EndExponent, span), Task::Emit(op, span)]);
        tasks.extend([Task::Visit(*to), Task::Visit(*from), Task::Emit(Op::BeginExponent, span)]);
    }

    /// `r[i][2]` reads like `r[i,2]`.
    pub(super) fn flatten_index(&self, at: ExprRef) -> (ExprRef, Vec<ExprRef>) {
        let mut base = at;
        let mut groups = Vec::new();
        while let ExprKind::Index { base: inner, indices } = &self.file.expr(base).kind {
            groups.push(*indices);
            base = *inner;
        }
        (base, groups.into_iter().rev().flatten().copied().collect())
    }

    pub(super) fn literal(&mut self, text: &str, span: Span) -> Number {
        Number::parse(text).unwrap_or_else(|| {
            self.fail(ModelError::NumberTooLong { what: text.to_owned(), span });
            Number::from(0)
        })
    }

    fn read(&mut self, name: &str, span: Span, indices: &[IndexProgram], scope: &Scope) -> Op {
        let is_plain = indices.is_empty();
        if let Some((slot, _)) = scope.find(name).filter(|_| is_plain) {
            return Op::Number(IndexProgram::of(IndexOp::Variable(slot), span));
        }
        if let Some(variable) = scope.integrated(name).filter(|_| is_plain) {
            return Op::Literal(variable);
        }
        match self.entity(name) {
            Some(Entity::Table(_)) => {
                self.fail(ModelError::TableAsValue { name: name.to_owned(), span });
                Op::Broken
            }
            Some(entity) => {
                if let Entity::Let(family) = entity {
                    if self.current_let == Some(family) {
                        self.recursive = true;
                    } else if let Some(family) = self.world.lets.get(family)
                        && family.family.grid.rank > 0
                    {
                        self.depth = self.depth.max(family.depth);
                        self.cost = self.cost.saturating_add(family.cost);
                    }
                }
                Op::Read { entity, indices: indices.into() }
            }
            None if is_plain && name == "pi" => Op::Literal(self.world.pool.pi()),
            None if is_plain && name == "t" => Op::Time,
            None => {
                self.undeclared(name, &[], span, scope);
                Op::Broken
            }
        }
    }

    pub(super) fn field(&mut self, base: ExprRef, field: &Name, scope: &mut Scope) -> Option<Field> {
        let file = self.file;
        if let Some(error) = self.foreign_field(base, field, scope) {
            self.fail(error);
            return None;
        }
        let (head, indices) = self.flatten_index(base);
        let span = file.expr(base).span;
        let ExprKind::Name(name) = &file.expr(head).kind else {
            self.fail(ModelError::Shape { what: "only the rows of a table have fields".to_owned(), span, help: None });
            return None;
        };
        let (table, row) = match (scope.find(name), self.entity(name), indices.as_slice()) {
            (Some((slot, Variable::Row(table))), _, []) => (table, IndexProgram::of(IndexOp::Variable(slot), span)),
            (Some((_, Variable::RowOfNone)), _, []) => return None,
            (None, Some(Entity::Table(table)), [row]) => (table, self.index(*row, scope)),
            (None, Some(Entity::Table(_)), _) => {
                let what = format!("`{name}` is a whole table; a field belongs to one row");
                let help = format!("write `{name}[3].{}`, or sum over its rows", field.text);
                self.fail(ModelError::shape((what, Some(help)), span));
                return None;
            }
            (None, None, _) => {
                self.undeclared_table(name, file.expr(head).span, scope);
                return None;
            }
            (Some(_), _, _) | (None, Some(_), _) => {
                let what = format!("`{name}` is not a row of a table and has no fields");
                self.fail(ModelError::shape((what, None), span));
                return None;
            }
        };
        if self.world.broken.contains(&Entity::Table(table)) {
            return None;
        }
        let known = &self.world.tables[table];
        let column = known.columns.iter().position(|own| **own == *field.text);
        if column.is_none() {
            let error = ModelError::UnknownColumn {
                table: known.name.clone(),
                column: field.text.to_string(),
                available: known.some_columns().join(", "),
                nearest: Meant::near(&field.text, known.columns.iter().map(String::as_str)),
                span: field.span,
            };
            self.fail(error);
        }
        column.map(|column| Field { table, row, column })
    }

    pub(super) fn unknown_function(&mut self, function: &Name, arguments: &[ExprRef], call: Span, scope: &Scope) {
        let quantity = self.entity(&function.text).is_some() || scope.find(&function.text).is_some();
        let known = syntax::FUNCTIONS.into_iter().chain(["sum", "integral", "rows"]);
        let same = known.clone().find(|own| own.eq_ignore_ascii_case(&function.text));
        let same = same.or_else(|| syntax::function_meant(&function.text)).map(|own| Meant::certain(own.to_owned()));
        let product = || self.product_called(&function.text, arguments).map(Meant::guess);
        let nearest = same.or_else(product).or_else(|| Meant::near(&function.text, known));
        self.fail(ModelError::UnknownFunction {
            name: function.text.to_string(),
            span: function.span,
            nearest,
            quantity,
            has_one: arguments.len() == 1,
            member: self
                .member_called(&function.text, arguments, scope)
                .or_else(|| self.multiplied(&function.text, arguments, call))
                .map(|meant| (call, meant)),
        });
    }

    /// Compiles indices of a sum or a binding and brings their variables into scope.
    pub(super) fn binders(&mut self, indices: &Indices, scope: &mut Scope) -> (Vec<Binder>, Option<IndexProgram>) {
        let mut binders = Vec::new();
        for entry in &indices.entries {
            let (name, variable, ends) = match &entry.kind {
                IndexKind::Member(value) => {
                    let at = self.index(*value, scope);
                    (None, Variable::Index, [at.clone(), at])
                }
                IndexKind::Range { variable, from, to } => {
                    (variable.as_ref(), Variable::Index, [from, to].map(|end| self.index(*end, scope)))
                }
                IndexKind::Rows { variable, table } => match self.entity(&table.text) {
                    Some(Entity::Table(number)) => {
                        let rows = rows(self.world.tables[number].rows(), entry.span);
                        (Some(variable), Variable::Row(number), rows)
                    }
                    other => {
                        if other.is_none() {
                            self.undeclared_table(&table.text, table.span, scope);
                        } else {
                            let what = format!("`{}` is not a table", table.text);
                            let help = format!("to run over numbers, write `{} in 1..{}`", variable.text, table.text);
                            self.fail(ModelError::shape((what, Some(help)), table.span));
                        }
                        (Some(variable), Variable::RowOfNone, rows(0, entry.span))
                    }
                },
            };
            if let Some(name) = name {
                self.new_index(name, scope);
            }
            // Every index has a slot, so that slots and indices count alike.
            scope.variables.push((name.map_or_else(String::new, |name| name.text.to_string()), variable));
            binders.push(Binder { ends, span: entry.span });
        }
        let filter = indices.filter.map(|filter| self.condition(filter, scope));
        (binders, filter)
    }

    /// Refuses an index that has the name of something else.
    fn new_index(&mut self, name: &Name, scope: &Scope) {
        let declared = self.world.names.get(name.text.as_str()).map(|(_, span)| *span);
        if declared.is_some() || scope.find(&name.text).is_some() || scope.integrated(&name.text).is_some() {
            self.fail(ModelError::IndexReusesName { name: name.text.to_string(), span: name.span, declared });
        }
    }
}

/// The ends of the rows of a table.
fn rows(count: usize, span: Span) -> [IndexProgram; 2] {
    let ends = [1, i64::try_from(count).unwrap_or(i64::MAX)];
    ends.map(|end| IndexProgram::of(IndexOp::Number(Number::from(end)), span))
}
