//! Writes trees as text that parses to the same trees, with no more parentheses than needed.
//!
//! Comments and blank lines are not kept here; where lines may be broken is told to a [`Sink`],
//! which may or may not care. Works from an explicit stack: the depth of a tree
//! costs no depth of calls.

mod expressions;
mod statements;

use std::borrow::Cow;

use super::ast::{ExprRef, File, Indices, Statement, UnitRef};
use expressions::Strength;

/// Where a line may be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Break {
    /// Between terms, the entries of a list, conditions: at all such places of a group or at none.
    Member,
    /// Between indices and around comparisons: where the line is full.
    Fill,
    /// Between factors: where the line is full, if a good part of it is.
    Factor,
    /// Where only what doesn't fit otherwise is broken.
    Weak,
    /// As weak, and no place for a comment either.
    Hidden,
}

/// What belongs together in layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// Terms; signs that begin a line stand left of them.
    Sum,
    /// Entries with commas.
    List,
    /// A sum that is the whole right side of a statement.
    WholeSum,
    /// A vector that is the whole right side of a statement.
    WholeList,
    /// Anything else.
    Other,
}

/// What a text is written to, token by token.
pub(super) trait Sink<'f> {
    /// One token.
    fn token(&mut self, text: Cow<'f, str>);
    /// A blank that ends no line.
    fn blank(&mut self);
    /// A place to break the line; written as `flat` where it isn't.
    fn place(&mut self, kind: Break, flat: &'static str);
    /// A group begins.
    fn open(&mut self, group: Group);
    /// The group that began last ends.
    fn close(&mut self);
}

/// Everything in one line.
impl<'f> Sink<'f> for String {
    fn token(&mut self, text: Cow<'f, str>) {
        self.push_str(&text);
    }

    fn blank(&mut self) {
        self.push(' ');
    }

    fn place(&mut self, _: Break, flat: &'static str) {
        self.push_str(flat);
    }

    fn open(&mut self, _: Group) {}

    fn close(&mut self) {}
}

/// How an expression is written, its parentheses aside.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// The whole right side of a statement.
    Whole,
    /// With blanks around the signs of sums.
    Wide,
    /// Without, as simple indices and bounds are written.
    Tight,
}

impl Manner {
    fn inner(self) -> Self {
        match self {
            Self::Whole | Self::Wide => Self::Wide,
            Self::Tight => Self::Tight,
        }
    }
}

/// What is still to be written.
enum Job<'f> {
    Token(&'f str),
    Blank,
    Place(Break, &'static str),
    Open(Group),
    Close,
    /// An expression, in parentheses if it binds less than the strength.
    Expr(ExprRef, Strength, Manner),
    Unit(UnitRef, bool),
    Exponent(i32, i32),
    Indices(&'f Indices, bool),
}

/// Jobs in the order of the text, from which the stack is filled backwards.
pub(super) struct Printer<'f, S> {
    file: &'f File,
    out: S,
    stack: Vec<Job<'f>>,
    next: Vec<Job<'f>>,
}

/// The expression in the language's own syntax.
#[must_use]
pub fn print_expr(file: &File, at: ExprRef) -> String {
    let mut printer = Printer::new(file, String::new());
    printer.run(Job::Expr(at, Strength::Any, Manner::Wide));
    printer.out
}

/// The unit in the language's own syntax.
#[must_use]
pub fn print_unit(file: &File, at: UnitRef) -> String {
    let mut printer = Printer::new(file, String::new());
    printer.run(Job::Unit(at, false));
    printer.out
}

/// What indices run over, without brackets.
#[cfg(feature = "engine")]
pub(crate) fn print_indices(file: &File, indices: &Indices) -> String {
    let mut printer = Printer::new(file, String::new());
    printer.run(Job::Indices(indices, false));
    printer.out
}

/// The statement in one line, without a line break.
#[must_use]
pub fn print_statement(file: &File, statement: &Statement) -> String {
    let mut printer = Printer::new(file, String::new());
    printer.statement(statement);
    printer.out
}

/// The file's statements, one a line.
///
/// ```
/// use librate_core::syntax::{parse, print_file};
/// let file = parse("coord x T=((1/2)*x'^2)")?;
/// assert_eq!(print_file(&file), "coord x\nT = (1/2)*x'^2\n");
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
#[must_use]
pub fn print_file(file: &File) -> String {
    let mut printer = Printer::new(file, String::new());
    for statement in &file.statements {
        printer.statement(statement);
        printer.out.push('\n');
    }
    printer.out
}

impl<'f, S: Sink<'f>> Printer<'f, S> {
    pub(super) fn new(file: &'f File, out: S) -> Self {
        Self { file, out, stack: Vec::new(), next: Vec::new() }
    }

    /// What has been written to.
    #[cfg(feature = "format")]
    pub(super) fn out(&mut self) -> &mut S {
        &mut self.out
    }

    fn run(&mut self, job: Job<'f>) {
        self.stack.push(job);
        while let Some(job) = self.stack.pop() {
            match job {
                Job::Token(text) => self.out.token(Cow::Borrowed(text)),
                Job::Blank => self.out.blank(),
                Job::Place(kind, flat) => self.out.place(kind, flat),
                Job::Open(group) => self.out.open(group),
                Job::Close => self.out.close(),
                Job::Expr(at, least, manner) => self.expr(at, least, manner),
                Job::Unit(at, grouped) => self.unit(at, grouped),
                Job::Exponent(numerator, denominator) => self.exponent(numerator, denominator),
                Job::Indices(indices, brackets) => self.indices(indices, brackets),
            }
            self.stack.extend(self.next.drain(..).rev());
        }
    }

    fn token(&mut self, text: &'f str) {
        self.next.push(Job::Token(text));
    }

    fn blank(&mut self) {
        self.next.push(Job::Blank);
    }

    fn place(&mut self, kind: Break, flat: &'static str) {
        self.next.push(Job::Place(kind, flat));
    }

    fn open(&mut self, group: Group) {
        self.next.push(Job::Open(group));
    }

    fn close(&mut self) {
        self.next.push(Job::Close);
    }

    fn child(&mut self, at: ExprRef, least: Strength, manner: Manner) {
        self.next.push(Job::Expr(at, least, manner));
    }
}
