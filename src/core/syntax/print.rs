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

/// A piece of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Piece<'f> {
    Token(Cow<'f, str>),
    /// A blank that ends no line.
    Blank,
    /// A place to break the line; written as the text where it isn't.
    Place(Break, &'static str),
    /// A group begins.
    Open(Group),
    /// The group that began last ends.
    Close,
}

impl Piece<'_> {
    /// The text in one line.
    pub(super) fn flat(&self) -> &str {
        match self {
            Self::Token(text) => text,
            Self::Blank => " ",
            Self::Place(_, flat) => flat,
            Self::Open(_) | Self::Close => "",
        }
    }
}

/// What a text is written to, piece by piece.
pub(super) trait Sink<'f> {
    fn put(&mut self, piece: Piece<'f>);
}

/// Everything in one line.
impl<'f> Sink<'f> for String {
    fn put(&mut self, piece: Piece<'f>) {
        self.push_str(piece.flat());
    }
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
    Put(Piece<'f>),
    /// An expression, in parentheses if it binds less than the strength.
    Expr(ExprRef, Strength, Manner),
    Unit(UnitRef, bool),
    Indices(&'f Indices, bool),
}

/// Jobs in the order of the text, from which the stack is filled backwards.
pub(super) struct Printer<'f, S> {
    file: &'f File,
    out: S,
    stack: Vec<Job<'f>>,
    next: Vec<Job<'f>>,
    /// The sign before an uncertainty.
    pub(super) plus_minus: &'static str,
}

/// The expression in the language's own syntax.
#[must_use]
pub fn print_expr(file: &File, at: ExprRef) -> String {
    printed(file, Job::Expr(at, Strength::Any, Manner::Wide))
}

/// The unit in the language's own syntax.
#[must_use]
pub fn print_unit(file: &File, at: UnitRef) -> String {
    printed(file, Job::Unit(at, false))
}

/// What indices run over, without brackets.
#[cfg(feature = "engine")]
pub(crate) fn print_indices(file: &File, indices: &Indices) -> String {
    printed(file, Job::Indices(indices, false))
}

fn printed<'f>(file: &'f File, whole: Job<'f>) -> String {
    let mut printer = Printer::new(file, String::new());
    printer.next.push(whole);
    printer.run();
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
        Self { file, out, stack: Vec::new(), next: Vec::new(), plus_minus: "±" }
    }

    /// What has been written to.
    #[cfg(feature = "format")]
    pub(super) fn out(&mut self) -> &mut S {
        &mut self.out
    }

    /// Writes what is to come next.
    fn run(&mut self) {
        loop {
            self.stack.extend(self.next.drain(..).rev());
            match self.stack.pop() {
                Some(Job::Put(piece)) => self.out.put(piece),
                Some(Job::Expr(at, least, manner)) => self.expr(at, least, manner),
                Some(Job::Unit(at, grouped)) => self.unit(at, grouped),
                Some(Job::Indices(indices, brackets)) => self.indices(indices, brackets),
                None => return,
            }
        }
    }

    fn put(&mut self, piece: Piece<'f>) {
        self.next.push(Job::Put(piece));
    }

    fn token(&mut self, text: impl Into<Cow<'f, str>>) {
        self.put(Piece::Token(text.into()));
    }

    fn blank(&mut self) {
        self.put(Piece::Blank);
    }

    fn place(&mut self, kind: Break, flat: &'static str) {
        self.put(Piece::Place(kind, flat));
    }

    /// A sign or a word with blanks on both sides, the first of which may end a line.
    fn between(&mut self, kind: Break, sign: &'static str) {
        self.place(kind, " ");
        self.token(sign);
        self.blank();
    }

    /// What stands before one of several things that fill lines.
    fn comma(&mut self, position: usize) {
        if position > 0 {
            self.token(",");
            self.place(Break::Fill, " ");
        }
    }

    fn open(&mut self, group: Group) {
        self.put(Piece::Open(group));
    }

    fn close(&mut self) {
        self.put(Piece::Close);
    }

    fn child(&mut self, at: ExprRef, least: Strength, manner: Manner) {
        self.next.push(Job::Expr(at, least, manner));
    }
}
