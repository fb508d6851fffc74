//! What can be wrong with a model whose syntax is right: one variant a kind of mistake.

use super::dimension::DimensionError;
use crate::budget::Exceeded;
use crate::diagnostic::Diagnostic;
use crate::span::Span;

/// A mistake in what a model file says.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A name that is not declared before it is used.
    #[error("`{name}` is not declared")]
    UndeclaredName {
        /// The name.
        name: String,
        /// Where it is used.
        span: Span,
        /// A declared name that it may have been meant to be.
        nearest: Option<String>,
        /// Where it is declared, but too late.
        later: Option<Span>,
    },
    /// A call of something that is no function.
    #[error("there is no function `{name}`")]
    UnknownFunction {
        /// The name.
        name: String,
        /// Where it stands.
        span: Span,
        /// A function that it may have been meant to be.
        nearest: Option<String>,
        /// Whether the name is a declared quantity, so that a `*` is missing.
        quantity: bool,
    },
    /// A name declared twice, or a member given twice.
    #[error("{} is given twice", quoted(.name))]
    GivenTwice {
        /// The name or member.
        name: String,
        /// The second place.
        span: Span,
        /// The first place.
        first: Span,
    },
    /// A second statement where the model can have only one.
    #[error("{what} is given twice")]
    SecondStatement {
        /// `T`, `V`, …
        what: &'static str,
        /// The second place.
        span: Span,
        /// The first place.
        first: Span,
    },
    /// `lagrangian` beside `T` or `V`.
    #[error("a model has either `lagrangian` or `T` and `V`, not both")]
    LagrangianBesideEnergies {
        /// The lagrangian.
        span: Span,
        /// The energy.
        energy: Span,
    },
    /// A model without kinetic energy.
    #[error("the model has no kinetic energy")]
    MissingKinetic {},
    /// A model without coordinates.
    #[error("the model has no coordinates")]
    NoCoordinates {},
    /// A `let` that uses itself, or a member that uses one with the same or a higher index.
    #[error("`{name}` is defined through itself")]
    RecursiveLet {
        /// The name or member.
        name: String,
        /// Where it uses itself.
        span: Span,
    },
    /// A member outside the family.
    #[error("there is no member `{member}`")]
    IndexOutOfRange {
        /// The member as asked for.
        member: String,
        /// Which members there are.
        available: String,
        /// Where it is asked for.
        span: Span,
        /// Where the family is declared.
        declared: Option<Span>,
    },
    /// An index or bound that is not a whole number.
    #[error("{value} is not a whole number")]
    NotAnInteger {
        /// What it came out as.
        value: String,
        /// Where.
        span: Span,
    },
    /// Too many indices or an index on something that has none.
    #[error("{what} {}", index_words(*.available))]
    TooManyIndices {
        /// What is indexed.
        what: String,
        /// How many indices it has.
        available: usize,
        /// Where.
        span: Span,
    },
    /// Operands whose shapes don't fit.
    #[error("{what}")]
    Shape {
        /// What doesn't fit.
        what: String,
        /// Where.
        span: Span,
        /// The way out, if there is one.
        help: Option<String>,
    },
    /// A function with the wrong number of arguments.
    #[error("`{function}` takes {expected}, not {found}")]
    ArgumentCount {
        /// The function.
        function: String,
        /// How many it takes, in words.
        expected: String,
        /// How many there are.
        found: usize,
        /// Where.
        span: Span,
    },
    /// A list of values of the wrong length.
    #[error("`{name}` has {expected} members, but {found} values are given")]
    ListLength {
        /// The family.
        name: String,
        /// Its members.
        expected: usize,
        /// The values.
        found: usize,
        /// Where the values stand.
        span: Span,
    },
    /// An acceleration in an energy.
    #[error("{energy} contains an acceleration")]
    Acceleration {
        /// `T`, `V`, …
        energy: &'static str,
        /// Where.
        span: Span,
    },
    /// A constraint that is not one of coordinates alone.
    #[error("a constraint is among coordinates, and this one contains the velocity `{on}`")]
    ConstraintOnVelocities {
        /// The velocity.
        on: String,
        /// Where the constraint stands.
        span: Span,
    },
    /// A constant that depends on coordinates or time.
    #[error("{what} must be constant, but depends on `{on}`")]
    NotConstant {
        /// What should be constant.
        what: String,
        /// What it depends on.
        on: String,
        /// Where.
        span: Span,
    },
    /// A parameter without a value where a number is needed.
    #[error("the parameter `{name}` has no value")]
    MissingValue {
        /// The parameter.
        name: String,
        /// Where the number is needed, or where the parameter is declared.
        span: Span,
    },
    /// `--set` of something that is no parameter.
    #[error("`{name}` can't be set: the model has no such parameter")]
    UnknownSetting {
        /// What was to be set.
        name: String,
        /// A parameter that it may have been meant to be.
        nearest: Option<String>,
    },
    /// A `--set` that can't be read.
    #[error("can't read the setting `{text}`: {reason}")]
    BadSetting {
        /// As given.
        text: String,
        /// What is wrong.
        reason: String,
    },
    /// A table whose file was not handed over.
    #[error("the table `{path}` can't be read{reason}")]
    MissingTable {
        /// As written.
        path: String,
        /// Why, with a leading `: `; may be empty.
        reason: String,
        /// Where.
        span: Span,
    },
    /// A table that is not a table.
    #[error("the table `{path}` has a mistake in line {line}: {reason}")]
    BadTable {
        /// As written.
        path: String,
        /// Line of the CSV file.
        line: u64,
        /// What is wrong.
        reason: String,
        /// Where the model names the file.
        span: Span,
    },
    /// A column that the table does not have.
    #[error("the table `{table}` has no column `{column}`")]
    UnknownColumn {
        /// The table.
        table: String,
        /// The column.
        column: String,
        /// The first columns.
        available: String,
        /// A column that it may have been meant to be.
        nearest: Option<String>,
        /// Where.
        span: Span,
    },
    /// More members or terms than fit into memory.
    #[error("{count} are too many")]
    TooLarge {
        /// How many of what.
        count: String,
        /// Where.
        span: Span,
    },
    /// An exact number of more than [`MAX_BITS`](crate::number::MAX_BITS) bits.
    #[error("{what} is too long for an exact number")]
    NumberTooLong {
        /// What comes to it.
        what: String,
        /// Where.
        span: Span,
    },
    /// The model grows beyond its budget.
    #[error(transparent)]
    Budget(#[from] Exceeded),
    /// A comparison of numbers that can't be told apart.
    #[error("this comparison can't be decided")]
    UndecidedComparison {
        /// Where.
        span: Span,
    },
    /// An index with the name of something declared.
    #[error("the index `{name}` has the name of something else")]
    IndexReusesName {
        /// The name.
        name: String,
        /// Where the index stands.
        span: Span,
        /// Where the other is declared.
        declared: Option<Span>,
    },
    /// A condition where a value is expected, or the reverse.
    #[error("{what}")]
    ConditionOrValue {
        /// What is expected and what there is.
        what: &'static str,
        /// Where.
        span: Span,
    },
    /// A form that can't set indices, bounds or filters.
    #[error("{what} can't stand in an index, a range or a filter")]
    NotForIndices {
        /// What.
        what: String,
        /// Where.
        span: Span,
    },
    /// A division by exactly zero, or a function outside its domain.
    #[error("{what} is not defined")]
    Undefined {
        /// What.
        what: String,
        /// Where.
        span: Span,
        /// The rule that is broken, if there is a short one.
        help: Option<&'static str>,
    },
    /// A unit that is not known.
    #[error("`{name}` is not a unit")]
    UnknownUnit {
        /// As written.
        name: String,
        /// Where.
        span: Span,
        /// A unit that it may have been meant to be.
        nearest: Option<String>,
    },
    /// A table or a row where a number is expected.
    #[error("`{name}` is a table, not a number")]
    TableAsValue {
        /// The table.
        name: String,
        /// Where.
        span: Span,
    },
    /// A `guess` or `equilibrium` for something that is no coordinate.
    #[error("`{name}` is not a coordinate")]
    NotACoordinate {
        /// The name.
        name: String,
        /// Where.
        span: Span,
        /// A coordinate that it may have been meant to be.
        nearest: Option<String>,
    },
    /// A mistake that only follows from another one. It is never returned.
    #[error("this follows from another mistake")]
    FollowOn {},
    /// Quantities of different kinds where they have to be alike.
    #[error(transparent)]
    Dimension(Box<DimensionError>),
    /// A coordinate without a range where the family needs one.
    #[error("{what}")]
    BadIndices {
        /// What is wrong.
        what: String,
        /// Where.
        span: Span,
    },
}

impl From<DimensionError> for ModelError {
    fn from(error: DimensionError) -> Self {
        Self::Dimension(Box::new(error))
    }
}

/// A name in the quotes of code; a description in words as it is.
fn quoted(name: &str) -> String {
    if name.contains(' ') {
        name.to_owned()
    } else {
        format!("`{name}`")
    }
}

/// `one index`, `3 indices`
pub(super) fn counted_indices(count: usize) -> String {
    match count {
        0 => "no index".to_owned(),
        1 => "one index".to_owned(),
        more => format!("{more} indices"),
    }
}

fn index_words(available: usize) -> String {
    match available {
        0 => "has no indices".to_owned(),
        1 => "has one index only".to_owned(),
        2 => "has two indices only".to_owned(),
        more => format!("has {more} indices only"),
    }
}

/// What a function of other languages is called here.
fn function_elsewhere(name: &str) -> Option<&'static str> {
    let help = match name.to_lowercase().as_str() {
        "log" => "the natural logarithm is `ln`; to base 10, write `ln(x)/ln(10)`",
        "log10" | "lg" => "write `ln(x)/ln(10)`",
        "log2" | "ld" => "write `ln(x)/ln(2)`",
        "cosine" => "the cosine is `cos`",
        "sine" => "the sine is `sin`",
        "tangent" | "tg" => "the tangent is `tan`",
        "arctg" => "write `atan`",
        "sh" => "write `sinh`",
        "ch" => "write `cosh`",
        "th" => "write `tanh`",
        "pow" | "power" => "powers are written `x^n`",
        "sqr" | "square" => "powers are written `x^2`",
        "cbrt" => "write `x^(1/3)`",
        "sec" => "write `1/cos(x)`",
        "csc" | "cosec" => "write `1/sin(x)`",
        "cot" | "cotan" | "ctg" => "write `cos(x)/sin(x)`",
        "diff" | "dot_product" | "derivative" | "ddt" => {
            "the time derivative is written `x'`, the product of vectors `dot(u, v)`"
        }
        "length" | "magnitude" => "the length of a vector is `norm`",
        "fabs" => "write `abs`",
        "product" | "prod" => "there are only sums",
        _ => return None,
    };
    Some(help)
}

/// What a unit that is written otherwise elsewhere is called here.
fn unit_elsewhere(name: &str) -> &'static str {
    match name.to_lowercase().as_str() {
        "meter" | "meters" | "metre" | "metres" => "the metre is `m`",
        "second" | "seconds" | "sec" => "the second is `s`",
        "gram" | "grams" | "gr" => "the gram is `g`",
        "kilogram" | "kilograms" | "kgs" => "the kilogram is `kg`",
        "radian" | "radians" => "the radian is `rad`",
        "degree" | "degrees" | "°" => "the degree is `deg`",
        "newton" | "newtons" => "the newton is `N`",
        "joule" | "joules" => "the joule is `J`",
        "minute" | "minutes" => "the minute is `min`",
        "hour" | "hours" | "hr" => "the hour is `h`",
        "amu" | "dalton" | "da" => "the atomic mass unit is `u`",
        "ang" | "å" => "the angstrom is `angstrom`",
        "dimensionless" | "none" => "a quantity without a dimension has the unit `1`",
        _ => {
            "SI base and derived units with prefixes are known, and deg, min, h, d, u, eV and angstrom"
        }
    }
}

fn meant(nearest: Option<&String>) -> Option<String> {
    nearest.map(|name| format!("did you mean `{name}`?"))
}

impl From<&ModelError> for Diagnostic {
    fn from(error: &ModelError) -> Self {
        described(error).with_code(error.code())
    }
}

fn described(error: &ModelError) -> Diagnostic {
    let message = error.to_string();
    let at = |span: Span, label: &str| Diagnostic::error(message.clone(), span, label);
    let or_help = |diagnostic: Diagnostic, help: Option<String>| match help {
        Some(help) => diagnostic.with_help(help),
        None => diagnostic,
    };
    match error {
        ModelError::UndeclaredName {
            span,
            nearest,
            later,
            name,
        } => match later {
            Some(later) => at(*span, "used here")
                .with_secondary(*later, "declared only here")
                .with_help(format!(
                    "move the declaration of `{name}` before its first use"
                )),
            None => or_help(
                at(*span, "unknown name"),
                meant(nearest.as_ref()).or_else(|| {
                    Some(format!(
                        "declare it: `param {name} = …`, `coord {name}` or `let {name} = …`"
                    ))
                }),
            ),
        },
        ModelError::UnknownFunction {
            span,
            nearest,
            quantity,
            name,
        } => or_help(
            at(*span, "not a function"),
            if *quantity {
                Some(format!(
                    "`{name}` is a quantity; to multiply, write `{name}*(…)`"
                ))
            } else {
                function_elsewhere(name)
                    .map(str::to_owned)
                    .or_else(|| meant(nearest.as_ref()))
            },
        ),
        ModelError::GivenTwice { span, first, .. } => {
            at(*span, "given again here").with_secondary(*first, "first given here")
        }
        ModelError::SecondStatement { span, first, what } => at(*span, "given again here")
            .with_secondary(*first, "first given here")
            .with_help(match *what {
                "model" | "period" => "leave one of them out".to_owned(),
                energy => format!("add the terms into one `{energy} = …`"),
            }),
        ModelError::LagrangianBesideEnergies { span, energy } => at(*span, "the lagrangian")
            .with_secondary(*energy, "an energy beside it")
            .with_help("write everything into the lagrangian, L = T - V, or leave it out"),
        ModelError::Dimension(error) => Diagnostic::from(&**error),
        ModelError::FollowOn {} => Diagnostic::global(message.clone()),
        ModelError::MissingKinetic {} => Diagnostic::global(message.clone())
            .with_help("add a line `T = …`, for example `T = 1/2*m*x'^2`"),
        ModelError::NoCoordinates {} => Diagnostic::global(message.clone())
            .with_help("declare the generalised coordinates, for example `coord x`"),
        ModelError::RecursiveLet { span, name } => {
            at(*span, "uses itself here").with_help(if name.contains('[') {
                "a member of a family may use members with a lower index only"
            } else {
                "a `let` may use what is declared before it, and not itself"
            })
        }
        ModelError::IndexOutOfRange {
            span,
            available,
            declared,
            ..
        } => {
            let diagnostic = at(*span, available);
            match declared {
                Some(declared) => diagnostic.with_secondary(*declared, "declared here"),
                None => diagnostic,
            }
        }
        ModelError::NotAnInteger { span, .. } => {
            at(*span, "indices and ranges count in whole numbers")
        }
        ModelError::TooManyIndices {
            span, available: 0, ..
        } => at(*span, "an index here"),
        ModelError::TooManyIndices { span, .. } => at(*span, "more indices than that"),
        ModelError::Shape { span, help, .. } => or_help(at(*span, ""), help.clone()),
        ModelError::ArgumentCount { span, .. } => at(*span, ""),
        ModelError::ListLength { span, expected, .. } => at(*span, "").with_help(format!(
            "give {expected} values, or a single one that fills the family"
        )),
        ModelError::Acceleration { span, energy } => at(*span, "a second time derivative")
            .with_help(format!(
                "{energy} may contain coordinates and velocities only; was one `'` too many?"
            )),
        ModelError::ConstraintOnVelocities { span, .. } => at(*span, "of velocities")
            .with_help("integrate it: rolling without slipping, x' = r*theta', is x = r*theta"),
        ModelError::NotConstant { span, .. } => at(*span, "not constant"),
        ModelError::MissingValue { span, name } => at(*span, "a number is needed").with_help(
            format!("give it a value in the file, or `--set {name}=VALUE`"),
        ),
        ModelError::UnknownSetting { nearest, .. } => {
            or_help(Diagnostic::global(message.clone()), meant(nearest.as_ref()))
        }
        ModelError::BadSetting { .. } => Diagnostic::global(message.clone()).with_help(
            "write `--set NAME=VALUE` with a value in numbers, for example `--set 'm[2]=3/2'`",
        ),
        ModelError::MissingTable { span, .. } => {
            at(*span, "named here").with_help("the path is taken relative to the model file")
        }
        ModelError::BadTable { span, .. } => at(*span, "read here"),
        ModelError::UnknownColumn {
            span,
            nearest,
            available,
            ..
        } => or_help(
            at(*span, "unknown column"),
            meant(nearest.as_ref()).or_else(|| Some(format!("its columns are {available}"))),
        ),
        ModelError::TooLarge { span, .. } => at(*span, "this does not fit into memory"),
        ModelError::NumberTooLong { span, .. } => at(*span, "more than 30,000 digits").with_help(
            "exact numbers have up to 100,000 bits; is an exponent wrong, or a number squared again and again?",
        ),
        ModelError::Budget(exceeded) => Diagnostic::from(exceeded),
        ModelError::UndecidedComparison { span } => {
            at(*span, "the two sides agree to thirty digits").with_help(
                "write the condition without roots or functions, for example with squares",
            )
        }
        ModelError::IndexReusesName { span, declared, .. } => {
            let diagnostic = at(*span, "an index needs a name of its own");
            match declared {
                Some(declared) => diagnostic.with_secondary(*declared, "declared here"),
                None => diagnostic.with_help("an index of that name is already running here"),
            }
        }
        ModelError::ConditionOrValue { span, .. } => at(*span, ""),
        ModelError::NotForIndices { span, .. } => at(*span, "").with_help(
            "literals, parameters, table fields and outer indices can, with mod and floor",
        ),
        ModelError::Undefined { span, help, .. } => {
            or_help(at(*span, "not defined"), help.map(str::to_owned))
        }
        ModelError::UnknownUnit {
            span,
            nearest,
            name,
        } => {
            let known = || Some(unit_elsewhere(name).to_owned());
            or_help(
                at(*span, "unknown unit"),
                meant(nearest.as_ref()).or_else(known),
            )
        }
        ModelError::TableAsValue { span, name } => at(*span, "a table").with_help(format!(
            "`rows({name})` is its length, `{name}[3].column` one of its fields"
        )),
        ModelError::NotACoordinate { span, nearest, .. } => {
            or_help(at(*span, "not a coordinate"), meant(nearest.as_ref()))
        }
        ModelError::BadIndices { span, .. } => at(
            *span,
            "all members of a family have as many indices, three at most",
        ),
    }
}
