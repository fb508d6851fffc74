//! Writes trees as text that parses to the same trees, with no more parentheses than needed.
//!
//! Comments and blank lines are not kept here. Works from an explicit stack: the depth of a tree
//! costs no depth of calls.

use super::ast::{
    Binding, Comparison, ExprKind, ExprRef, File, IndexKind, Indices, Statement, StatementKind,
    UnitKind, UnitRef,
};

/// Binding strengths, weakest first; [`Strength::Any`] asks for no parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Strength {
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

/// What is still to be written.
enum Job<'f> {
    Text(&'f str),
    /// An expression, in parentheses if it binds less than the strength; `tight` sums have no
    /// blanks around their signs, as indices are written.
    Expr(ExprRef, Strength, bool),
    Unit(UnitRef, bool),
    Exponent(i32, i32),
    Indices(&'f Indices, bool),
}

/// Jobs in the order of the text, from which the stack is filled backwards.
struct Printer<'f> {
    file: &'f File,
    out: String,
    stack: Vec<Job<'f>>,
    next: Vec<Job<'f>>,
}

/// The expression in the language's own syntax.
#[must_use]
pub fn print_expr(file: &File, at: ExprRef) -> String {
    let mut printer = Printer::new(file);
    printer.run(Job::Expr(at, Strength::Any, false));
    printer.out
}

/// The unit in the language's own syntax.
#[must_use]
pub fn print_unit(file: &File, at: UnitRef) -> String {
    let mut printer = Printer::new(file);
    printer.run(Job::Unit(at, false));
    printer.out
}

/// The statement in one line, without a line break.
#[must_use]
pub fn print_statement(file: &File, statement: &Statement) -> String {
    let mut printer = Printer::new(file);
    printer.statement(statement);
    printer.out
}

/// The file's statements, one a line.
///
/// ```
/// use librate::syntax::{parse, print_file};
/// let file = parse("coord x T=((1/2)*x'^2)")?;
/// assert_eq!(print_file(&file), "coord x\nT = (1/2)*x'^2\n");
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
#[must_use]
pub fn print_file(file: &File) -> String {
    let mut printer = Printer::new(file);
    for statement in &file.statements {
        printer.statement(statement);
        printer.out.push('\n');
    }
    printer.out
}

fn strength(kind: &ExprKind<'_>) -> Strength {
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
        | ExprKind::Vector(_) => Strength::Postfix,
    }
}

const fn sign(operator: Comparison) -> &'static str {
    match operator {
        Comparison::Equal => " == ",
        Comparison::NotEqual => " != ",
        Comparison::Less => " < ",
        Comparison::LessEqual => " <= ",
        Comparison::Greater => " > ",
        Comparison::GreaterEqual => " >= ",
    }
}

impl<'f> Printer<'f> {
    fn new(file: &'f File) -> Self {
        Self {
            file,
            out: String::new(),
            stack: Vec::new(),
            next: Vec::new(),
        }
    }

    fn run(&mut self, job: Job<'f>) {
        self.stack.push(job);
        while let Some(job) = self.stack.pop() {
            match job {
                Job::Text(text) => self.out.push_str(text),
                Job::Expr(at, least, tight) => self.expr(at, least, tight),
                Job::Unit(at, grouped) => self.unit(at, grouped),
                Job::Exponent(numerator, denominator) => {
                    self.out.push_str(&if denominator == 1 {
                        format!("^{numerator}")
                    } else {
                        format!("^({numerator}/{denominator})")
                    });
                }
                Job::Indices(indices, brackets) => self.indices(indices, brackets),
            }
            self.stack.extend(self.next.drain(..).rev());
        }
    }

    fn text(&mut self, text: &'f str) {
        self.next.push(Job::Text(text));
    }

    fn child(&mut self, at: ExprRef, least: Strength, tight: bool) {
        self.next.push(Job::Expr(at, least, tight));
    }

    fn list(&mut self, members: &[ExprRef], tight: bool) {
        for (position, member) in members.iter().enumerate() {
            if position > 0 {
                self.text(", ");
            }
            self.child(*member, Strength::Any, tight);
        }
    }

    fn joined(&mut self, members: &[ExprRef], word: &'static str, least: Strength, tight: bool) {
        for (position, member) in members.iter().enumerate() {
            if position > 0 {
                self.text(word);
            }
            self.child(*member, least, tight);
        }
    }

    fn expr(&mut self, at: ExprRef, least: Strength, tight: bool) {
        let file = self.file;
        let kind = file.expr(at).kind;
        let grouped = strength(&kind) < least;
        if grouped {
            self.text("(");
        }
        match kind {
            ExprKind::Number(text) | ExprKind::Name(text) => self.text(text),
            ExprKind::Index { base, indices } => {
                self.child(base, Strength::Postfix, tight);
                self.text("[");
                self.list(indices, true);
                self.text("]");
            }
            ExprKind::Field { base, field } => {
                self.child(base, Strength::Postfix, tight);
                self.text(".");
                self.text(&field.text);
            }
            ExprKind::Prime(base) => {
                self.child(base, Strength::Postfix, tight);
                self.text("'");
            }
            ExprKind::Negate(inner) => {
                self.text("-");
                self.child(inner, Strength::Negate, tight);
            }
            ExprKind::Power { base, exponent } => {
                self.child(base, Strength::Number, tight);
                self.text("^");
                self.child(exponent, Strength::Negate, tight);
            }
            ExprKind::Product(factors) => {
                for (position, factor) in factors.iter().enumerate() {
                    if position > 0 {
                        self.text(if factor.divided() { "/" } else { "*" });
                    }
                    self.child(factor.value(), Strength::Negate, tight);
                }
            }
            ExprKind::Sum(terms) => {
                for (position, term) in terms.iter().enumerate() {
                    if position > 0 {
                        self.text(match (term.subtracted(), tight) {
                            (false, false) => " + ",
                            (true, false) => " - ",
                            (false, true) => "+",
                            (true, true) => "-",
                        });
                    }
                    self.child(term.value(), Strength::Product, tight);
                }
            }
            ExprKind::Call {
                function,
                arguments,
            } => {
                self.text(&function.text);
                self.text("(");
                self.list(arguments, false);
                self.text(")");
            }
            ExprKind::SumOver { indices, body } => {
                self.text("sum(");
                self.next.push(Job::Indices(indices, false));
                self.text(", ");
                self.child(body, Strength::Any, false);
                self.text(")");
            }
            ExprKind::Vector(members) => {
                self.text("[");
                self.list(members, false);
                self.text("]");
            }
            ExprKind::Compare {
                operator,
                left,
                right,
            } => {
                self.child(left, Strength::Sum, tight);
                self.text(sign(operator));
                self.child(right, Strength::Sum, tight);
            }
            ExprKind::Not(inner) => {
                self.text("not ");
                self.child(inner, Strength::Not, tight);
            }
            ExprKind::And(members) => self.joined(members, " and ", Strength::Not, tight),
            ExprKind::Or(members) => self.joined(members, " or ", Strength::And, tight),
        }
        if grouped {
            self.text(")");
        }
    }

    fn indices(&mut self, indices: &'f Indices, brackets: bool) {
        if brackets {
            self.text("[");
        }
        for (position, entry) in indices.entries.iter().enumerate() {
            if position > 0 {
                self.text(", ");
            }
            match &entry.kind {
                IndexKind::Member(at) => self.child(*at, Strength::Any, true),
                IndexKind::Range { variable, from, to } => {
                    if let Some(variable) = variable {
                        self.text(&variable.text);
                        self.text(" in ");
                    }
                    self.child(*from, Strength::Any, true);
                    self.text("..");
                    self.child(*to, Strength::Any, true);
                }
                IndexKind::Rows { variable, table } => {
                    self.text(&variable.text);
                    self.text(" in ");
                    self.text(&table.text);
                }
            }
        }
        if let Some(filter) = indices.filter {
            self.text(" where ");
            self.child(filter, Strength::Any, true);
        }
        if brackets {
            self.text("]");
        }
    }

    fn unit(&mut self, at: UnitRef, grouped: bool) {
        let file = self.file;
        match file.unit(at).kind {
            UnitKind::One => self.text("1"),
            UnitKind::Name(name) => self.text(name),
            UnitKind::Product(factors) => {
                if grouped {
                    self.text("(");
                }
                for (position, (divided, factor)) in factors.iter().enumerate() {
                    if position > 0 {
                        self.text(if *divided { "/" } else { "*" });
                    }
                    self.next.push(Job::Unit(*factor, true));
                }
                if grouped {
                    self.text(")");
                }
            }
            UnitKind::Power {
                base,
                numerator,
                denominator,
            } => {
                // Powers of powers need the parentheses, powers in products don't.
                let power = matches!(file.unit(base).kind, UnitKind::Power { .. });
                if power {
                    self.text("(");
                }
                self.next.push(Job::Unit(base, true));
                if power {
                    self.text(")");
                }
                self.next.push(Job::Exponent(numerator, denominator));
            }
        }
    }

    // ---- statements ---------------------------------------------------------------------------

    fn put(&mut self, text: &str) {
        self.out.push_str(text);
    }

    fn put_expr(&mut self, at: ExprRef) {
        self.run(Job::Expr(at, Strength::Any, false));
    }

    fn head(
        &mut self,
        name: &str,
        indices: Option<&'f Indices>,
        rate: bool,
        unit: Option<UnitRef>,
    ) {
        self.put(name);
        if let Some(indices) = indices {
            self.run(Job::Indices(indices, true));
        }
        if rate {
            self.put("'");
        }
        if let Some(unit) = unit {
            self.put(" : ");
            self.run(Job::Unit(unit, false));
        }
    }

    fn binding(&mut self, word: &str, binding: &'f Binding, rate: bool) {
        self.put(word);
        self.head(
            &binding.name.text,
            binding.indices.as_deref(),
            rate,
            binding.unit,
        );
        if let Some(value) = binding.value {
            self.put(" = ");
            self.put_expr(value);
        }
        if let Some(uncertainty) = binding.uncertainty {
            self.put(" ± ");
            self.put_expr(uncertainty);
        }
    }

    fn equation(&mut self, word: &str, value: ExprRef) {
        self.put(word);
        self.put(" = ");
        self.put_expr(value);
    }

    fn statement(&mut self, statement: &'f Statement) {
        match &statement.kind {
            StatementKind::Model { name } => {
                self.put("model ");
                self.put(&name.text);
            }
            StatementKind::Param(binding) => self.binding("param ", binding, false),
            StatementKind::Coord { declarations } => {
                self.put("coord ");
                for (position, declaration) in declarations.iter().enumerate() {
                    if position > 0 {
                        self.put(", ");
                    }
                    self.head(
                        &declaration.name.text,
                        declaration.indices.as_deref(),
                        false,
                        declaration.unit,
                    );
                }
            }
            StatementKind::Let(binding) => self.binding("let ", binding, false),
            StatementKind::Kinetic(value) => self.equation("T", *value),
            StatementKind::Potential(value) => self.equation("V", *value),
            StatementKind::Lagrangian(value) => self.equation("lagrangian", *value),
            StatementKind::Dissipation(value) => self.equation("dissipation", *value),
            StatementKind::Constraint {
                indices,
                left,
                right,
            } => {
                self.put("constraint ");
                if let Some(indices) = indices {
                    self.run(Job::Indices(indices, true));
                    self.put(" ");
                }
                self.put_expr(*left);
                self.put(" = ");
                self.put_expr(*right);
            }
            StatementKind::Guess(binding) => self.binding("guess ", binding, false),
            StatementKind::Equilibrium { binding, rate } => {
                self.binding("equilibrium ", binding, *rate);
            }
            StatementKind::Period(value) => {
                self.put("period ");
                self.put_expr(*value);
            }
            StatementKind::Table { name, path, .. } => {
                self.put("table ");
                self.put(&name.text);
                self.put(" = \"");
                self.put(path);
                self.put("\"");
            }
        }
    }
}
