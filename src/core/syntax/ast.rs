//! The syntax tree: what stands in the file, with places, and nothing about what it means.
//!
//! Expressions live in one arena per file and refer to each other by [`ExprRef`]; a child always
//! has a smaller index than its parent, so that every pass is a loop, however deep the text nests.
//! The kinds can be matched exhaustively on purpose: a tool that walks the tree wants its compiler
//! to tell it of a new form, so a new form of the language is a new major version of the crate.
//! The arena packs them; an [`Expr`] is how one reads, and how it is put in.

use super::arena::{Expressions, Units};
use crate::span::Span;
use crate::worded;

/// Index of an expression in its [`File`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprRef(pub u32);

/// A name and where it stands.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Name {
    /// The letters.
    pub text: String,
    /// The place.
    pub span: Span,
}

/// A parsed model file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct File {
    /// The statements in the order of the file.
    pub statements: Vec<Statement>,
    /// All expressions; children before parents.
    pub expressions: Expressions,
    /// All unit expressions; children before parents.
    pub units: Units,
    /// All comments in the order of the file, without `#` and line break.
    pub comments: Vec<Comment>,
}

impl File {
    /// The expression behind a reference of this file; an empty vector behind one of another.
    #[must_use]
    pub fn expr(&self, at: ExprRef) -> Expr<'_> {
        self.expressions.get(at).unwrap_or(Expr { span: Span::default(), kind: ExprKind::Vector(&[]) })
    }

    /// The unit behind a reference of this file; a pure number behind one of another.
    #[must_use]
    pub fn unit(&self, at: UnitRef) -> Unit<'_> {
        self.units.get(at).unwrap_or(Unit { span: Span::default(), kind: UnitKind::One })
    }
}

/// A comment.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Comment {
    /// The text behind `#`, without the line break.
    pub text: Box<str>,
    /// From the `#` to the end of the line.
    pub span: Span,
    /// Whether something else stands before it on its line.
    pub trailing: bool,
}

/// One statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// From its first word to the end of its last token.
    pub span: Span,
    /// What it says.
    pub kind: StatementKind,
}

worded! {
/// What a `draw` statement draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
Drawn {
    /// A dot at each point.
    Point "point",
    /// A line from each point to the next.
    Line "line",
    /// A spring from each point to the next.
    Spring "spring",
}
/// As it is written.
as_str
/// What there is.
ALL
}

/// What a statement says.
#[derive(Clone, Debug, PartialEq)]
pub enum StatementKind {
    /// `model NAME`
    Model {
        /// The model's name.
        name: Name,
    },
    /// `param …`, several with commas: names that share a unit or a value refer to the same one.
    Param(Vec<Binding>),
    /// `coord a, b[1..n] : m`
    Coord {
        /// The declared names.
        declarations: Vec<Binding>,
    },
    /// `let …`
    Let(Binding),
    /// `T = EXPR`
    Kinetic(ExprRef),
    /// `V = EXPR`
    Potential(ExprRef),
    /// `lagrangian = EXPR`
    Lagrangian(ExprRef),
    /// `dissipation = EXPR`
    Dissipation(ExprRef),
    /// `force NAME = EXPR`
    Force(Binding),
    /// `constraint [indices] EXPR = EXPR`
    Constraint {
        /// `[i in 1..n where …]`, if there.
        indices: Option<Box<Indices>>,
        /// Left of `=`.
        left: ExprRef,
        /// Right of `=`.
        right: ExprRef,
    },
    /// `assume EXPR > EXPR, …`: comparisons, none of them with `==`.
    Assume(Vec<ExprRef>),
    /// `guess …`, with `rate` for `guess NAME' = …`
    Guess {
        /// Name, indices and value.
        binding: Binding,
        /// Whether a velocity is guessed (`NAME'`) instead of a value.
        rate: bool,
    },
    /// `equilibrium …`, with `rate` for `equilibrium NAME' = …`
    Equilibrium {
        /// Name, indices and value.
        binding: Binding,
        /// Whether a constant rate is given (`NAME'`) instead of a value.
        rate: bool,
    },
    /// `period EXPR`
    Period(ExprRef),
    /// `draw point [indices] EXPR, …`, also `draw line` and `draw spring` through several points
    Draw {
        /// What is drawn.
        drawn: Drawn,
        /// `[i in 1..n where …]`, if there.
        indices: Option<Box<Indices>>,
        /// Points as vectors.
        points: Vec<ExprRef>,
    },
    /// `table NAME = "file.csv"`
    Table {
        /// The table's name.
        name: Name,
        /// The path as written, without the quotes.
        path: String,
        /// Where the path stands, quotes included.
        path_span: Span,
    },
}

/// `NAME[indices] : unit = EXPR ± EXPR`, the common form of `param`, `coord`, `let`, `force`, `guess`, `equilibrium`.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// The bound name.
    pub name: Name,
    /// The indices in brackets, if there.
    pub indices: Option<Box<Indices>>,
    /// The unit behind the colon.
    pub unit: Option<UnitRef>,
    /// The right side; only `param` may go without, and `coord` always does.
    pub value: Option<ExprRef>,
    /// Standard uncertainty behind `±` or `+/-`; only `param` may have one.
    pub uncertainty: Option<ExprRef>,
}

/// Indices in brackets, of a sum or of an integral, with the filter behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Indices {
    /// The place, brackets included where there are any.
    pub span: Span,
    /// One entry an index.
    pub entries: Box<[IndexEntry]>,
    /// The condition behind `where`.
    pub filter: Option<ExprRef>,
}

/// One index of a binding or a sum.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexEntry {
    /// The place.
    pub span: Span,
    /// The form.
    pub kind: IndexKind,
}

/// The forms of an index entry.
#[derive(Clone, Debug, PartialEq)]
pub enum IndexKind {
    /// `3` or `n+1`: a single member.
    Member(ExprRef),
    /// `1..n`, with `name in` before it where the right side uses the index.
    Range {
        /// The index variable.
        variable: Option<Name>,
        /// First value.
        from: ExprRef,
        /// Last value, included.
        to: ExprRef,
    },
    /// `b in bonds`: the rows of a table.
    Rows {
        /// The row variable.
        variable: Name,
        /// The table.
        table: Name,
    },
}

/// An expression and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expr<'f> {
    /// From its first to its last token.
    pub span: Span,
    /// What it is.
    pub kind: ExprKind<'f>,
}

/// The forms of an expression. Lists and texts are borrowed from the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExprKind<'f> {
    /// A literal as written: `2`, `0.5`, `6.02e23`. Exact: its text is its value.
    Number(&'f str),
    /// A name, `pi` and `t` included.
    Name(&'f str),
    /// `base[i, j]`
    Index {
        /// What is indexed.
        base: ExprRef,
        /// One or more indices.
        indices: &'f [ExprRef],
    },
    /// `b.col`, `bonds[3].col`
    Field {
        /// A row.
        base: ExprRef,
        /// The column.
        field: &'f Name,
    },
    /// `x'`
    Prime(ExprRef),
    /// `-x`
    Negate(ExprRef),
    /// `base ^ exponent`
    Power {
        /// Below.
        base: ExprRef,
        /// Above.
        exponent: ExprRef,
    },
    /// `a*b/c`: two or more factors, the first never a divisor.
    Product(&'f [Member]),
    /// `a + b - c`: two or more terms, the first never subtracted (`-a + b` starts with a
    /// [`ExprKind::Negate`]).
    Sum(&'f [Member]),
    /// `sin(x)`, `atan2(y, x)`, `rows(bonds)`
    Call {
        /// The function's name, not checked here.
        function: &'f Name,
        /// The arguments.
        arguments: &'f [ExprRef],
    },
    /// `sum(i in a..b, j in c..d where …, body)`
    SumOver {
        /// Indices and filter.
        indices: &'f Indices,
        /// What is summed.
        body: ExprRef,
    },
    /// `integral(x in a..b, body)`
    IntegralOver {
        /// The variable with its bounds: a single range, no filter.
        indices: &'f Indices,
        /// What is integrated.
        body: ExprRef,
    },
    /// `[a, b, c]`
    Vector(&'f [ExprRef]),
    /// `a < b`
    Compare {
        /// Which comparison.
        operator: Comparison,
        /// Left side.
        left: ExprRef,
        /// Right side.
        right: ExprRef,
    },
    /// `not a`
    Not(ExprRef),
    /// `a and b and c`
    And(&'f [ExprRef]),
    /// `a or b or c`
    Or(&'f [ExprRef]),
}

/// A term of a sum or a factor of a product, with the sign before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    inverted: bool,
    value: ExprRef,
}

impl Member {
    /// The term or factor `value`, with `-` or `/` before it if it is `inverted`.
    #[must_use]
    pub const fn new(inverted: bool, value: ExprRef) -> Self {
        Self { inverted, value }
    }

    /// Whether `-` or `/` stands before it.
    #[must_use]
    pub const fn inverted(self) -> bool {
        self.inverted
    }

    /// The term or factor.
    #[must_use]
    pub const fn value(self) -> ExprRef {
        self.value
    }
}

worded! {
/// The comparisons of filters and assumptions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
Comparison {
    /// `==`
    Equal "==",
    /// `!=`
    NotEqual "!=",
    /// `<`
    Less "<",
    /// `<=`
    LessEqual "<=",
    /// `>`
    Greater ">",
    /// `>=`
    GreaterEqual ">=",
}
/// As the language writes it.
sign
}

/// Index of a unit expression in its [`File`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct UnitRef(pub u32);

/// A unit and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit<'f> {
    /// From its first to its last token.
    pub span: Span,
    /// What it is.
    pub kind: UnitKind<'f>,
}

/// The forms of a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitKind<'f> {
    /// `1`
    One,
    /// `kg`, `mm`, `deg`: not looked up here.
    Name(&'f str),
    /// `kg*m/s^2`; `true` where `/` stands before the factor.
    Product(&'f [(bool, UnitRef)]),
    /// `m^2`, `s^-1`, `m^(1/2)`: the exponent as numerator and denominator.
    Power {
        /// The unit below.
        base: UnitRef,
        /// Numerator of the exponent.
        numerator: i32,
        /// Denominator of the exponent, positive.
        denominator: i32,
    },
}
