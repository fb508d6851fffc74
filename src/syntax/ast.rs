//! The syntax tree: what stands in the file, with places, and nothing about what it means.
//!
//! Expressions live in one arena per file and refer to each other by [`ExprRef`]; a child always
//! has a smaller index than its parent, so that every pass is a loop, however deep the text nests.

use crate::span::Span;

/// Index of an expression in its [`File`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
    pub expressions: Vec<Expr>,
    /// All unit expressions; children before parents.
    pub units: Vec<Unit>,
    /// All comments in the order of the file, without `#` and line break.
    pub comments: Vec<Comment>,
}

impl File {
    /// The expression behind a reference of this file.
    #[must_use]
    pub fn expr(&self, at: ExprRef) -> &Expr {
        &self.expressions[at.0 as usize]
    }

    /// The unit behind a reference of this file.
    #[must_use]
    pub fn unit(&self, at: UnitRef) -> &Unit {
        &self.units[at.0 as usize]
    }
}

/// A comment.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Comment {
    /// The text behind `#`, without the line break.
    pub text: String,
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

/// What a statement says.
#[derive(Clone, Debug, PartialEq)]
pub enum StatementKind {
    /// `model NAME`
    Model {
        /// The model's name.
        name: Name,
    },
    /// `param …`
    Param(Binding),
    /// `coord a, b[1..n] : m`
    Coord {
        /// The declared names.
        declarations: Vec<Declaration>,
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
    /// `constraint [indices] EXPR = EXPR`
    Constraint {
        /// `[i in 1..n where …]`, if there.
        indices: Option<Indices>,
        /// Left of `=`.
        left: ExprRef,
        /// Right of `=`.
        right: ExprRef,
    },
    /// `guess …`
    Guess(Binding),
    /// `equilibrium …`, with `rate` for `equilibrium NAME' = …`
    Equilibrium {
        /// Name, indices and value.
        binding: Binding,
        /// Whether a constant rate is given (`NAME'`) instead of a value.
        rate: bool,
    },
    /// `period EXPR`
    Period(ExprRef),
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

/// `NAME[indices] : unit = EXPR ± EXPR`, the common form of `param`, `let`, `guess`, `equilibrium`.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// The bound name.
    pub name: Name,
    /// The indices in brackets, if there.
    pub indices: Option<Indices>,
    /// The unit behind the colon.
    pub unit: Option<UnitRef>,
    /// The right side; only `param` may go without.
    pub value: Option<ExprRef>,
    /// Standard uncertainty behind `±` or `+/-`; only `param` may have one.
    pub uncertainty: Option<ExprRef>,
}

/// One name of a `coord` statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// The coordinate or family.
    pub name: Name,
    /// The ranges in brackets, if there.
    pub indices: Option<Indices>,
    /// The unit behind the colon.
    pub unit: Option<UnitRef>,
}

/// Indices in brackets or of a sum, with the filter behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Indices {
    /// The place, brackets included where there are any.
    pub span: Span,
    /// One entry an index.
    pub entries: Vec<IndexEntry>,
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
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// From its first to its last token.
    pub span: Span,
    /// What it is.
    pub kind: ExprKind,
}

/// The forms of an expression.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// A literal as written: `2`, `0.5`, `6.02e23`. Exact: its text is its value.
    Number(String),
    /// A name, `pi` and `t` included.
    Name(String),
    /// `base[i, j]`
    Index {
        /// What is indexed.
        base: ExprRef,
        /// One or more indices.
        indices: Vec<ExprRef>,
    },
    /// `b.col`, `bonds[3].col`
    Field {
        /// A row.
        base: ExprRef,
        /// The column.
        field: Name,
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
    Product(Vec<Factor>),
    /// `a + b - c`: two or more terms, the first never subtracted (`-a + b` starts with a
    /// [`ExprKind::Negate`]).
    Sum(Vec<Term>),
    /// `sin(x)`, `atan2(y, x)`, `rows(bonds)`
    Call {
        /// The function's name, not checked here.
        function: Name,
        /// The arguments.
        arguments: Vec<ExprRef>,
    },
    /// `sum(i in a..b, j in c..d where …, body)`
    SumOver {
        /// Indices and filter.
        indices: Indices,
        /// What is summed.
        body: ExprRef,
    },
    /// `[a, b, c]`
    Vector(Vec<ExprRef>),
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
    And(Vec<ExprRef>),
    /// `a or b or c`
    Or(Vec<ExprRef>),
}

/// A factor of a product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factor {
    /// Whether `/` stands before it.
    pub divided: bool,
    /// The factor.
    pub value: ExprRef,
}

/// A term of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// Whether `-` stands before it.
    pub subtracted: bool,
    /// The term.
    pub value: ExprRef,
}

/// The comparisons of filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
}

/// Index of a unit expression in its [`File`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct UnitRef(pub u32);

/// A unit and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// From its first to its last token.
    pub span: Span,
    /// What it is.
    pub kind: UnitKind,
}

/// The forms of a unit.
#[derive(Clone, Debug, PartialEq)]
pub enum UnitKind {
    /// `1`
    One,
    /// `kg`, `mm`, `deg`: not looked up here.
    Name(String),
    /// `kg*m/s^2`; `true` where `/` stands before the factor.
    Product(Vec<(bool, UnitRef)>),
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
