//! The ways in which a text fails to be a model file.
//!
//! One variant a kind of mistake, each with its place. What is said about it besides the message is
//! in `report`.

use crate::span::Span;

/// A mistake in the text of a model file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxError {
    /// The file is longer than the parser accepts.
    #[error("the file is too large: at most {most} bytes are read")]
    FileTooLarge {
        /// Its length, or so much of it as was read.
        bytes: usize,
        /// The greatest length read.
        most: usize,
    },
    /// A statement begins with a word that is none.
    #[error("there is no statement `{word}`")]
    UnknownStatement {
        /// The word.
        word: String,
        /// The statement word probably meant.
        suggestion: Option<&'static str>,
        /// The word's place.
        span: Span,
    },
    /// `m = 2` without `param` or another statement word before it.
    #[error("a statement word is missing before `{name}`")]
    MissingStatementWord {
        /// The name that stands in its place.
        name: String,
        /// The statement in full, where the one before it tells which word is meant.
        fix: Option<String>,
        /// The name's place.
        span: Span,
    },
    /// Something that can't begin a statement.
    #[error("a statement can't begin with {found}")]
    NoStatement {
        /// What stands there.
        found: String,
        /// The place.
        span: Span,
    },
    /// A reserved word is declared.
    #[error("`{name}` can't be used as a name")]
    ReservedName {
        /// The word.
        name: String,
        /// What it is: `is the time`.
        meaning: &'static str,
        /// The place.
        span: Span,
    },
    /// A statement word inside an expression.
    #[error("`{word}` can't be used in an expression")]
    WordInExpression {
        /// The word.
        word: String,
        /// The place.
        span: Span,
    },
    /// Two operands without a sign between them.
    #[error("the multiplication sign is missing")]
    MissingMultiplication {
        /// The text left of the gap.
        left: String,
        /// The text right of it.
        right: String,
        /// Both operands.
        span: Span,
    },
    /// `3 4`
    #[error("two numbers side by side")]
    TwoNumbers {
        /// Both.
        span: Span,
    },
    /// `sin x`
    #[error("the argument of `{function}` needs parentheses")]
    MissingParentheses {
        /// The function.
        function: String,
        /// The argument, or its beginning.
        argument: String,
        /// Both.
        span: Span,
    },
    /// `np.cos(x)`, `v.norm()`
    #[error("functions have no prefix: `{function}`")]
    PrefixedFunction {
        /// The function with what stands before it.
        function: String,
        /// The call as the language has it.
        fix: String,
        /// The function with what stands before it.
        span: Span,
    },
    /// `sin^2(x)`
    #[error("the power of `{function}` stands behind its argument")]
    FunctionPower {
        /// The function.
        function: String,
        /// The exponent.
        exponent: String,
        /// From the function to the exponent.
        span: Span,
    },
    /// `1.` or `.5`.
    #[error("a number needs digits on both sides of the point")]
    HalfNumber {
        /// The number in full.
        fix: String,
        /// The place.
        span: Span,
    },
    /// `9,81`
    #[error("the decimal sign is a point, not a comma")]
    DecimalComma {
        /// The number with a point.
        fix: String,
        /// The place.
        span: Span,
    },
    /// `+x`
    #[error("a plus sign needs something on its left")]
    UnaryPlus {
        /// The sign.
        span: Span,
    },
    /// `**`
    #[error("`**` is not an operator")]
    DoubleStar {
        /// The sign.
        span: Span,
    },
    /// An operator without its right operand.
    #[error("something is missing behind `{sign}`")]
    MissingOperand {
        /// The operator, comma or bracket.
        sign: String,
        /// Its place.
        span: Span,
        /// What stands there instead.
        found: Option<(String, Span)>,
    },
    /// An operator without its left operand.
    #[error("something is missing before `{sign}`")]
    MissingLeftOperand {
        /// The operator.
        sign: String,
        /// Its place.
        span: Span,
    },
    /// Nothing behind `=`.
    #[error("the value behind `=` is missing")]
    MissingValue {
        /// The `=`.
        span: Span,
    },
    /// A statement that needs a right side has none.
    #[error("`{statement}` needs a right side: `= …`")]
    MissingRightSide {
        /// The statement word.
        statement: &'static str,
        /// The end of what is there.
        span: Span,
    },
    /// Nothing where a statement expects an expression.
    #[error("an expression is missing behind `{statement}`")]
    MissingExpression {
        /// The statement word.
        statement: &'static str,
        /// Its place.
        span: Span,
    },
    /// No name behind a word that needs one.
    #[error("a name is missing behind `{statement}`")]
    MissingName {
        /// The statement word.
        statement: &'static str,
        /// What stands there instead, or the end.
        found: String,
        /// The place.
        span: Span,
    },
    /// `param m = 1, k = 2`
    #[error("`{statement}` gives one value")]
    SeveralValues {
        /// The statement word.
        statement: &'static str,
        /// The comma.
        span: Span,
    },
    /// `T : J = …`
    #[error("`{statement}` takes no unit")]
    MisplacedUnit {
        /// The statement word.
        statement: &'static str,
        /// The colon.
        span: Span,
    },
    /// `x[i 1..n]`
    #[error("`in` is missing")]
    IndexWithoutIn {
        /// The index's name.
        name: String,
        /// From the name to what follows.
        span: Span,
    },
    /// Two names where one belongs.
    #[error("`{statement}` takes one name")]
    SeveralNames {
        /// The statement word.
        statement: &'static str,
        /// The second name.
        span: Span,
    },
    /// `coord x y`
    #[error("a comma is missing between the names")]
    MissingComma {
        /// From the first to the second name.
        span: Span,
        /// The first name.
        left: String,
        /// The second name.
        right: String,
    },
    /// `=` inside a condition.
    #[error("a comparison is written `==`")]
    EqualsForComparison {
        /// The `=`.
        span: Span,
    },
    /// `==` where a value is given.
    #[error("a value is given with a single `=`")]
    ComparisonForEquals {
        /// The `==`.
        span: Span,
    },
    /// `:=`, or a colon without a unit.
    #[error("a unit is missing behind the colon")]
    MissingUnit {
        /// The colon.
        span: Span,
        /// Whether `=` follows at once.
        assignment: bool,
    },
    /// A second `=`.
    #[error("a second `=` in one statement")]
    SecondEquals {
        /// The second one.
        span: Span,
    },
    /// `coord x = 1`
    #[error("a coordinate has no value of its own")]
    CoordinateValue {
        /// The `=`.
        span: Span,
    },
    /// `param f(x) = …`
    #[error("functions can't be defined")]
    FunctionDefinition {
        /// The bracket behind the name.
        span: Span,
    },
    /// `period = …`, `model = …`
    #[error("`{statement}` is written without `=`")]
    NeedlessEquals {
        /// The statement word.
        statement: &'static str,
        /// The `=`.
        span: Span,
    },
    /// A bracket without its partner.
    #[error("the bracket `{bracket}` is never closed")]
    UnclosedBracket {
        /// The bracket.
        bracket: char,
        /// Its place.
        open: Span,
        /// The end of the statement, where the partner is missing at the latest.
        end: Span,
    },
    /// A closing bracket without an opening one.
    #[error("the bracket `{bracket}` closes nothing")]
    StrayBracket {
        /// The bracket.
        bracket: char,
        /// Its place.
        span: Span,
    },
    /// `(…]`
    #[error("`{close}` closes `{bracket}`")]
    MismatchedBracket {
        /// The opening bracket.
        bracket: char,
        /// Its place.
        open: Span,
        /// The closing bracket.
        close: char,
        /// Its place.
        span: Span,
    },
    /// Brackets, signs or powers within each other beyond the limit.
    #[error("this nests too deep: more than {most} levels")]
    NestingTooDeep {
        /// The deepest level read.
        most: usize,
        /// Where it is exceeded.
        span: Span,
    },
    /// A character the language has no use for.
    #[error("`{character}` means nothing here")]
    IllegalCharacter {
        /// The character or a run of them.
        character: String,
        /// What to write instead.
        hint: Option<&'static str>,
        /// A rewriting that depends on the character, such as `^2`.
        fix: Option<String>,
        /// The place.
        span: Span,
    },
    /// A quote without its partner.
    #[error("the closing quote is missing")]
    OpenText {
        /// From the quote to the end of the line.
        span: Span,
    },
    /// Quoted text where none belongs.
    #[error("text in quotes belongs only behind `table NAME =`")]
    MisplacedText {
        /// The number within the quotes, if it is one.
        number: Option<String>,
        /// The text.
        span: Span,
    },
    /// `;` within brackets.
    #[error("a semicolon can't stand inside brackets")]
    SemicolonInBrackets {
        /// The semicolon.
        span: Span,
        /// The bracket around it.
        open: Span,
    },
    /// `±` where no parameter gets its value.
    #[error("an uncertainty can't stand here")]
    MisplacedUncertainty {
        /// The sign.
        span: Span,
    },
    /// A comparison outside of a filter.
    #[error("a condition can only stand behind `where`")]
    ConditionOutsideFilter {
        /// The operator.
        span: Span,
    },
    /// `1 < i < n`
    #[error("comparisons can't be chained")]
    ChainedComparison {
        /// The first comparison.
        first: Span,
        /// The second operator.
        span: Span,
    },
    /// `i in 1..3, where …`
    #[error("no comma belongs before `where`")]
    CommaBeforeWhere {
        /// The comma.
        span: Span,
    },
    /// `not` where no condition begins.
    #[error("`not` can only begin a condition")]
    MisplacedNot {
        /// The word.
        span: Span,
    },
    /// `..` outside of indices.
    #[error("a range can't stand here")]
    MisplacedRange {
        /// The `..`.
        span: Span,
    },
    /// An index with `in` but neither a range nor a table behind it.
    #[error("a range needs two ends")]
    HalfRange {
        /// What stands behind `in`.
        span: Span,
    },
    /// `sum(x)`, `sum(1..3, x)`, `sum(i=1..3, x)`
    #[error("`sum` needs an index: `sum(i in 1..n, …)`")]
    SumWithoutIndex {
        /// What stands there.
        span: Span,
    },
    /// `sum(i in 1..n)`
    #[error("nothing is summed here")]
    SumWithoutBody {
        /// The closing bracket.
        span: Span,
    },
    /// `2'` or `2[1]`
    #[error("a number can't be followed by `{sign}`")]
    PostfixOnNumber {
        /// The sign.
        sign: String,
        /// Its place.
        span: Span,
    },
    /// `param x' = 1`
    #[error("a prime can't stand here")]
    MisplacedRate {
        /// The statement word.
        statement: &'static str,
        /// The prime.
        span: Span,
    },
    /// `param g = 9.81 : m/s^2`, `param l = 30 cm`
    #[error("the unit belongs behind the name")]
    UnitBehindValue {
        /// The statement with the unit where it belongs, if it is short.
        fix: Option<String>,
        /// The colon, or the unit.
        span: Span,
    },
    /// Something in a unit that is no part of one.
    #[error("this is not a unit")]
    BadUnit {
        /// The place.
        span: Span,
    },
    /// An exponent of a unit that is not a fraction of small integers.
    #[error("the exponent of a unit is an integer or a fraction in parentheses")]
    UnitExponent {
        /// The exponent.
        span: Span,
    },
    /// A name with a hyphen: `model double-pendulum`
    #[error("a name has no hyphens, points or blanks")]
    BrokenName {
        /// The name with underscores.
        fix: String,
        /// The place.
        span: Span,
    },
    /// A point without a column behind it.
    #[error("a column's name is missing behind the point")]
    MissingColumn {
        /// The point.
        span: Span,
    },
    /// `table NAME` without a path in quotes.
    #[error("`table` needs the path of a CSV file in quotes")]
    MissingPath {
        /// What stands there instead.
        span: Span,
    },
    /// Anything else.
    #[error("{found} can't stand here")]
    Unexpected {
        /// What stands there.
        found: String,
        /// What could stand there, in plain words.
        expected: Vec<&'static str>,
        /// The place.
        span: Span,
    },
}

impl SyntaxError {
    /// The place of the mistake; empty at 0 where the whole file is at fault.
    #[must_use]
    pub fn span(&self) -> Span {
        match self {
            Self::FileTooLarge { .. } => Span::default(),
            Self::UnclosedBracket { end: span, .. }
            | Self::UnknownStatement { span, .. }
            | Self::MissingStatementWord { span, .. }
            | Self::NoStatement { span, .. }
            | Self::ReservedName { span, .. }
            | Self::WordInExpression { span, .. }
            | Self::MissingMultiplication { span, .. }
            | Self::HalfNumber { span, .. }
            | Self::DecimalComma { span, .. }
            | Self::UnaryPlus { span }
            | Self::DoubleStar { span }
            | Self::MissingOperand { span, .. }
            | Self::MissingLeftOperand { span, .. }
            | Self::MissingValue { span }
            | Self::MissingRightSide { span, .. }
            | Self::MissingExpression { span, .. }
            | Self::MissingName { span, .. }
            | Self::SeveralNames { span, .. }
            | Self::MissingComma { span, .. }
            | Self::EqualsForComparison { span }
            | Self::ComparisonForEquals { span }
            | Self::MissingUnit { span, .. }
            | Self::SecondEquals { span }
            | Self::CoordinateValue { span }
            | Self::NeedlessEquals { span, .. }
            | Self::StrayBracket { span, .. }
            | Self::MismatchedBracket { span, .. }
            | Self::NestingTooDeep { span, .. }
            | Self::IllegalCharacter { span, .. }
            | Self::OpenText { span }
            | Self::MisplacedText { span, .. }
            | Self::SemicolonInBrackets { span, .. }
            | Self::MisplacedUncertainty { span }
            | Self::ConditionOutsideFilter { span }
            | Self::ChainedComparison { span, .. }
            | Self::MisplacedNot { span }
            | Self::CommaBeforeWhere { span }
            | Self::FunctionDefinition { span }
            | Self::MisplacedRange { span }
            | Self::HalfRange { span }
            | Self::SumWithoutIndex { span }
            | Self::SumWithoutBody { span }
            | Self::PostfixOnNumber { span, .. }
            | Self::MisplacedRate { span, .. }
            | Self::TwoNumbers { span }
            | Self::MissingParentheses { span, .. }
            | Self::PrefixedFunction { span, .. }
            | Self::FunctionPower { span, .. }
            | Self::SeveralValues { span, .. }
            | Self::MisplacedUnit { span, .. }
            | Self::IndexWithoutIn { span, .. }
            | Self::UnitBehindValue { span, .. }
            | Self::BadUnit { span }
            | Self::UnitExponent { span }
            | Self::BrokenName { span, .. }
            | Self::MissingColumn { span }
            | Self::MissingPath { span }
            | Self::Unexpected { span, .. } => *span,
        }
    }
}
