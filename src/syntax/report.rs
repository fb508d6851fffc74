//! What is said about each mistake: a remark at its place, second places, and the fix.
//!
//! Words only; the places come with the error.

use super::error::SyntaxError;
use crate::diagnostic::Diagnostic;
use crate::span::Span;

const STATEMENTS: &str = "a statement starts with `model`, `param`, `coord`, `let`, `T`, `V`, `lagrangian`, \
     `dissipation`, `constraint`, `guess`, `equilibrium`, `period` or `table`";

fn partner(bracket: char) -> char {
    if bracket == '(' { ')' } else { ']' }
}

impl From<&SyntaxError> for Diagnostic {
    fn from(error: &SyntaxError) -> Self {
        let message = error.to_string();
        let (label, secondary, help) = error.remarks();
        let mut diagnostic = match error {
            SyntaxError::FileTooLarge { .. } => Self::global(message),
            _ => Self::error(message, error.span(), label),
        }
        .with_code(error.code());
        for (span, text) in secondary {
            diagnostic = diagnostic.with_secondary(span, text);
        }
        if let Some(help) = help {
            diagnostic = diagnostic.with_help(help);
        }
        diagnostic
    }
}

impl SyntaxError {
    /// The remark at the place, the second places, and the fix.
    fn remarks(&self) -> (String, Vec<(Span, String)>, Option<String>) {
        let plain = |label: &str, help: &str| (label.to_owned(), Vec::new(), Some(help.to_owned()));
        match self {
            Self::FileTooLarge { .. } => plain(
                "",
                "write repeated terms as sum(i in 1..n, …), or keep the numbers in a table",
            ),
            Self::UnknownStatement {
                suggestion: Some(word),
                ..
            } => plain("not a statement word", &format!("write `{word}`")),
            Self::UnknownStatement {
                suggestion: None, ..
            }
            | Self::NoStatement { .. } => plain("a statement begins here", STATEMENTS),
            Self::MissingStatementWord { fix: Some(fix), .. } => {
                plain("a statement begins here", &format!("write `{fix}`"))
            }
            Self::MissingStatementWord {
                name, fix: None, ..
            } => plain(
                "a statement begins here",
                &format!(
                    "write `param {name} = …` for a constant, `let {name} = …` for anything else"
                ),
            ),
            Self::ReservedName { name, meaning, .. } => {
                plain(meaning, &format!("take another name, such as `{name}_0`"))
            }
            Self::WordInExpression { word, .. } => plain(
                "begins a statement",
                match word.as_str() {
                    "T" | "V" => {
                        "the energies are no names: give the common part a name with `let` and use that"
                    }
                    _ => "take another name",
                },
            ),
            Self::MissingMultiplication { left, right, .. } => plain(
                "two factors without a sign between them",
                &format!("write `{left}*{right}`"),
            ),
            Self::HalfNumber { fix, .. } => {
                plain("not a complete number", &format!("write `{fix}`"))
            }
            Self::DecimalComma { fix, .. } => plain("two numbers here", &format!("write `{fix}`")),
            Self::UnaryPlus { .. } => plain("no sign for positive numbers", "leave the `+` out"),
            Self::DoubleStar { .. } => plain("no such sign", "a power is written `x^2`"),
            Self::MissingOperand { found, .. } => (
                "nothing to work on behind it".to_owned(),
                found
                    .iter()
                    .map(|(what, span)| (*span, format!("{what} stands here already")))
                    .collect(),
                None,
            ),
            Self::MissingLeftOperand { sign, .. } => (
                format!("`{sign}` stands between two operands"),
                Vec::new(),
                None,
            ),
            Self::MissingValue { .. } => plain(
                "nothing follows",
                "write the value; a `param` may go without, but then without `=` too",
            ),
            Self::MissingRightSide { statement, .. } => plain(
                "`= …` is missing here",
                match *statement {
                    "constraint" => "a constraint is written `constraint EXPR = EXPR`",
                    "T" | "V" | "lagrangian" | "dissipation" => "write `=` and the expression",
                    "table" => "write `= \"file.csv\"`",
                    _ => "only a `param` may go without a value",
                },
            ),
            Self::MissingExpression { statement, .. } => plain(
                "nothing follows",
                match *statement {
                    "period" => "write the period of the explicit time dependence: `period 2*pi/W`",
                    _ => "a constraint is written `constraint EXPR = EXPR`",
                },
            ),
            Self::MissingName {
                statement: "model",
                found,
                ..
            } => plain(
                &format!("{found} instead of a name"),
                "write `model NAME`; a name is a letter or `_`, then letters, digits and `_`, without quotes",
            ),
            Self::MissingName { found, .. } => plain(
                &format!("{found} instead of a name"),
                "a name is a letter or `_`, then letters, digits and `_`",
            ),
            Self::SeveralNames { statement, .. } => plain(
                "a second name",
                match *statement {
                    "model" => "a model's name is one word; join words with `_`",
                    _ => "write a statement for each name",
                },
            ),
            Self::MissingComma { left, right, .. } => plain(
                "two names without a comma",
                &format!("write `{left}, {right}`"),
            ),
            Self::EqualsForComparison { .. } => plain("gives a value", "write `==`"),
            Self::ComparisonForEquals { .. } => plain("compares two values", "write `=`"),
            Self::MissingUnit {
                assignment: true, ..
            } => plain(
                "begins a unit",
                "write `=` alone, or a unit behind the colon: `g : m/s^2 = …`",
            ),
            Self::MissingUnit { .. } => plain(
                "no unit follows",
                "write a unit, `: 1` for a pure number, or leave the colon out",
            ),
            Self::SecondEquals { .. } => plain(
                "the statement has its `=` already",
                "if a new statement begins here, its first word is missing",
            ),
            Self::CoordinateValue { .. } => plain(
                "gives a value",
                "where it rests is said by `equilibrium NAME = …`, where to search for that by `guess NAME = …`",
            ),
            Self::NeedlessEquals { statement, .. } => plain(
                "not needed",
                match *statement {
                    "period" => "write `period EXPR`",
                    "model" => "write `model NAME`",
                    _ => "leave the `=` out",
                },
            ),
            Self::UnclosedBracket { bracket, open, .. } => (
                format!("`{}` is missing here at the latest", partner(*bracket)),
                vec![(*open, "opened here".to_owned())],
                None,
            ),
            Self::StrayBracket { .. } => (
                "no bracket is open here".to_owned(),
                Vec::new(),
                Some("remove it, or open a bracket before it".to_owned()),
            ),
            Self::MismatchedBracket { bracket, open, .. } => (
                format!("`{}` expected", partner(*bracket)),
                vec![(*open, "opened here".to_owned())],
                None,
            ),
            Self::NestingTooDeep { .. } => plain(
                "one level too many",
                "name a part of the expression with `let`",
            ),
            Self::IllegalCharacter { hint, fix, .. } => (
                "not a sign of the language".to_owned(),
                Vec::new(),
                match (fix, hint) {
                    (Some(fix), _) => Some(format!("write `{fix}`")),
                    (None, Some(hint)) => Some((*hint).to_owned()),
                    (None, None) => None,
                },
            ),
            Self::OpenText { .. } => plain(
                "opened here, not closed on this line",
                "end the text with `\"`",
            ),
            Self::MisplacedText {
                number: Some(number),
                ..
            } => plain(
                "not a value",
                &format!("numbers are written without quotes: `{number}`"),
            ),
            Self::MisplacedText { number: None, .. } => plain(
                "not a value",
                "names and numbers are written without quotes",
            ),
            Self::SemicolonInBrackets { open, .. } => (
                "ends a statement".to_owned(),
                vec![(*open, "inside this bracket".to_owned())],
                Some("the rows of a matrix are vectors: `[[1, 2], [3, 4]]`".to_owned()),
            ),
            Self::MisplacedUncertainty { .. } => plain(
                "not behind a parameter's value",
                "only a parameter has an uncertainty, once, behind its whole value: `param g = 9.81 ± 0.01`",
            ),
            Self::ConditionOutsideFilter { .. } => plain(
                "a condition has no value",
                "pick terms of a sum with a filter: `sum(i in 1..n where i != 2, …)`",
            ),
            Self::ChainedComparison { first, .. } => (
                "a second comparison".to_owned(),
                vec![(*first, "compared already".to_owned())],
                Some("join two comparisons with `and`: `1 < i and i < n`".to_owned()),
            ),
            Self::FunctionDefinition { .. } => plain(
                "no argument can stand here",
                "a family has square brackets: `let f[i in 1..n] = …`; other names are used as they are in the expression",
            ),
            Self::CommaBeforeWhere { .. } => plain(
                "another index would follow",
                "the condition stands right behind the last index: `i in 1..n where i != 2`",
            ),
            Self::MisplacedNot { .. } => plain(
                "no condition begins here",
                "put the condition in parentheses: `not (…)`",
            ),
            Self::MisplacedRange { .. } => plain(
                "ranges stand only in indices",
                "add the members up with `sum(i in 1..n, …)`",
            ),
            Self::HalfRange { .. } => plain(
                "only one end",
                "write `i in 1..n`, or `b in TABLE` for the rows of a table",
            ),
            Self::SumWithoutIndex { .. } => plain(
                "no index with `in`",
                "write `sum(i in 1..n, …)`, or `sum(b in TABLE, …)` for the rows of a table",
            ),
            Self::SumWithoutBody { .. } => plain(
                "only indices before it",
                "write the expression to be summed behind a comma: `sum(i in 1..n, x[i])`",
            ),
            Self::PostfixOnNumber { sign, .. } => plain(
                "not behind a number",
                match sign.as_str() {
                    "'" => "the derivative of a number is 0",
                    _ => "only names, calls, vectors and parentheses have members",
                },
            ),
            Self::MisplacedRate { statement, .. } => match *statement {
                "equilibrium" | "guess" => plain(
                    "not here",
                    &format!(
                        "a rate has one prime, behind the brackets if there are any: `{statement} x[1]' = …`"
                    ),
                ),
                _ => plain(
                    "not for this statement",
                    "leave the `'` out; only `equilibrium` may give a rate, and `guess` a velocity",
                ),
            },
            Self::TwoNumbers { .. } => plain(
                "nothing between them",
                "write an operator or a comma between them",
            ),
            Self::MissingParentheses {
                function, argument, ..
            } => plain(
                "a function without parentheses",
                &format!("write `{function}({argument})`"),
            ),
            Self::PrefixedFunction { fix, .. } => plain(
                "a name and a point before a function",
                &format!("write `{fix}`"),
            ),
            Self::FunctionPower {
                function, exponent, ..
            } => plain(
                "a power before the argument",
                &format!("write `{function}(…)^{exponent}`"),
            ),
            Self::SeveralValues { .. } => {
                plain("a second value", "write a statement for each name")
            }
            Self::MisplacedUnit { statement, .. } => plain(
                "begins a unit",
                match *statement {
                    "T" | "V" | "lagrangian" => "leave it out: this is an energy",
                    "dissipation" => "leave it out: this is a power",
                    _ => "leave it out",
                },
            ),
            Self::IndexWithoutIn { name, .. } => plain(
                "an index and its range without a word between them",
                &format!("write `{name} in 1..n`"),
            ),
            Self::UnitBehindValue { fix, .. } => plain(
                "behind the value",
                &format!(
                    "write `{}`",
                    fix.as_deref().unwrap_or("NAME : UNIT = VALUE")
                ),
            ),
            Self::BadUnit { .. } => plain(
                "no part of a unit",
                "a unit is made of names, `*`, `/`, `^` and parentheses: `kg*m/s^2`; `1` for a pure number",
            ),
            Self::UnitExponent { .. } => {
                plain("not such an exponent", "write `m^2`, `s^-1` or `m^(1/2)`")
            }
            Self::BrokenName { fix, .. } => plain("not one name", &format!("write `{fix}`")),
            Self::MissingColumn { .. } => plain(
                "nothing follows",
                "write a column of the table: `b.k`; a range has two points: `1..n`",
            ),
            Self::MissingPath { .. } => {
                plain("no text in quotes", "write `table NAME = \"file.csv\"`")
            }
            Self::Unexpected { expected, .. } => (
                match expected.as_slice() {
                    [] => String::new(),
                    [one] => format!("expected {one}"),
                    [first @ .., last] => format!("expected {} or {last}", first.join(", ")),
                },
                Vec::new(),
                None,
            ),
        }
    }
}
