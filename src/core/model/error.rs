//! What can be wrong with a model whose syntax is right: one variant a kind of mistake.

use super::dimension::DimensionError;
use super::values::Misfit;
use crate::budget::Exceeded;
use crate::diagnostic::{Meant, at, nowhere};
use crate::mistakes;
use crate::span::Span;
use crate::syntax::FUNCTIONS;
use crate::syntax::units::in_si;

/// What units there are.
const UNITS: &str = "the units are SI base and derived units with prefixes, deg, rev, rpm, min, h, d, u, eV, cal, \
     angstrom, bar, atm, in, ft, lb and lbf";

mistakes! {
/// A mistake in what a model file says.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
Error ModelError {
    /// A name that is not declared before it is used.
    #[error("`{name}` is not declared")]
    "E0101" UndeclaredName(span) {
        /// The name.
        name: String,
        /// A declared name that it may have been meant to be.
        nearest: Option<Meant>,
        /// Where it is declared, but too late.
        later: Option<Span>,
        /// The integral elsewhere that has it for its variable.
        integral: Option<Span>,
        /// How it can be declared as a coordinate, if its time derivative is used.
        coordinate: Option<Box<MissingCoordinate>>,
        /// What its place says, as an index in `draw` and as a table behind `in`: the label and the help.
        by_place: Option<Box<(&'static str, String)>>,
    } => match later {
        Some(later) => at(*span, "used here")
            .with_secondary(*later, "declared only here")
            .with_help(format!("move the declaration of `{name}` before its first use")),
        None => match coordinate.as_deref() {
            Some(MissingCoordinate { declaration, members, .. }) if !members.is_empty() => at(*span, "unknown name")
                .with_help(format!("declare `{declaration}` in place of {}", members.join(", "))),
            Some(MissingCoordinate { declaration, place, .. }) => at(*span, "unknown name")
                .with_help(format!("its time derivative is used, so it is a coordinate: declare it by `{declaration}`"))
                .replacing(Span::new(*place, *place), format!("{declaration}\n")),
            None if nearest.is_none() && (FUNCTIONS.contains(&name.as_str()) || name == "rows") => {
                at(*span, "a function without its argument").with_help(format!("write `{name}(…)`"))
            }
            None if by_place.is_some() => {
                let (label, help) = by_place.as_deref().cloned().unwrap_or_default();
                at(*span, label).with_help(help)
            }
            None if integral.is_some() => at(*span, "outside of the integral")
                .and_at(*integral, "a variable of this integral alone")
                .with_help(format!("write what depends on `{name}` into the integral itself, not into a `let`")),
            None if unit_in_expression(name, nearest.as_ref()).is_some() => {
                at(*span, "a unit has no place in an expression").or_help(unit_in_expression(name, nearest.as_ref()))
            }
            None => at(*span, "unknown name")
                .with_help(format!("declare it: `param {name} = …`, `coord {name}` or `let {name} = …`"))
                .or_meant(*span, nearest.as_ref()),
        },
    },

    /// A call of something that is no function.
    #[error("there is no function `{name}`")]
    "E0102" UnknownFunction(span) {
        /// The name.
        name: String,
        /// A function that it may have been meant to be.
        nearest: Option<Meant>,
        /// Whether the name is a declared quantity, so that a `*` is missing.
        quantity: bool,
        /// Whether it has one argument.
        has_one: bool,
        /// The call and the member or product that is meant by it.
        member: Option<(Span, String)>,
    } => match function_elsewhere(name) {
        _ if member.is_some() => {
            let help = member.as_ref().map(|(_, text)| format!("write `{text}`"));
            at(*span, "not a function").or_help(help).or_replacing(member.as_ref())
        }
        _ if *quantity => at(*span, "not a function")
            .with_help(format!("`{name}` is a quantity; to multiply, write `{name}*(…)`")),
        Some(own) => at(*span, "not a function").with_help(own),
        None => at(*span, "not a function")
            .or_help(has_one.then(|| format!("if `{name}` is a quantity, declare it and write `{name}*(…)`")))
            .or_meant(*span, nearest.as_ref()),
    },

    /// `Cos[phi]`
    #[error("the argument of `{function}` must be in parentheses")]
    "E0138" BracketedFunction(span) {
        /// The function.
        function: &'static str,
        /// The call as the language has it.
        fix: String,
    } => at(*span, "square brackets are for members and components").written(*span, fix),

    /// `phi[t]`, `phi(t)`
    #[error("a coordinate takes no time as an argument")]
    "E0139" TimeArgument(span) => at(*span, "not needed")
        .with_help("remove it: every coordinate depends on time")
        .replacing(*span, ""),

    /// `phi.dot`, `dot(phi)`
    #[error("the time derivative is written with a prime")]
    "E0140" ForeignDerivative(span) {
        /// The derivative as the language has it.
        fix: String,
    } => at(*span, "a time derivative").written(*span, fix),

    /// A name declared twice, or a member given twice.
    #[error("{} is given twice", quoted(.name))]
    "E0103" GivenTwice(span) {
        /// The name or member.
        name: String,
        /// The first place.
        first: Span,
        /// What to do instead.
        help: Option<String>,
    } => at(*span, "given again here").with_secondary(*first, "first given here").or_help(help.clone()),

    /// A second statement where the model can have only one.
    #[error("{what} is given twice")]
    "E0104" SecondStatement(span) {
        /// `T`, `V`, …
        what: &'static str,
        /// The first place.
        first: Span,
    } => at(*span, "given again here")
        .with_secondary(*first, "first given here")
        .with_help(match *what {
            "model" | "period" => "remove one of them".to_owned(),
            energy => format!("add the terms into one `{energy} = …`"),
        }),

    /// `lagrangian` beside `T` or `V`.
    #[error("a model has either `lagrangian` or `T` and `V`, not both")]
    "E0105" LagrangianBesideEnergies(span) {
        /// The energy.
        energy: Span,
    } => at(*span, "the lagrangian")
        .with_secondary(*energy, "an energy as well")
        .with_help("write everything into the lagrangian, L = T - V, or remove it"),

    /// A model without kinetic energy.
    #[error("the model has no kinetic energy")]
    "E0106" MissingKinetic {} => nowhere()
        .with_help("add a line `T = …`, for example `T = 1/2*m*x'^2`; for a model without inertia, `T = 0`"),

    /// A model without coordinates.
    #[error("the model has no coordinates")]
    "E0107" NoCoordinates {
        /// A family of them without members.
        empty: Option<Span>,
    } => match empty {
        Some(span) => at(*span, "an empty family").with_help("the last index of a range is at least the first: `coord x[1..3]`"),
        None => nowhere().with_help("declare the generalised coordinates, for example `coord x`"),
    },

    /// A `let` that uses itself, or a member that uses one with the same or a higher index.
    #[error("`{name}` is defined through itself")]
    "E0108" RecursiveLet(span) {
        /// The name or member.
        name: String,
        /// What is used here and uses it in turn.
        through: Option<String>,
    } => match through {
        Some(through) if through == name => at(*span, "uses itself here")
            .with_help("give its value by a number or by names declared before it"),
        Some(through) => at(*span, format!("`{through}` uses `{name}` in turn"))
            .with_help(format!("give one of the two without the other: neither `{name}` nor `{through}` can come first")),
        None => at(*span, "uses itself here").with_help(if name.contains('[') {
            "a member of a family may use members with a lower index only"
        } else {
            "a `let` may use names declared before it, but not itself"
        }),
    },

    /// A member outside the family.
    #[error("there is no member `{member}`")]
    "E0109" IndexOutOfRange(span) {
        /// The member as asked for.
        member: String,
        /// Which members there are.
        available: String,
        /// Where the family is declared.
        declared: Option<Span>,
        /// How several members are declared, where there is one.
        help: Option<String>,
    } => at(*span, available).and_at(*declared, "declared here").or_help(help.clone()),

    /// An index or bound that is not a whole number.
    #[error("{value} is not a whole number")]
    "E0110" NotAnInteger(span) {
        /// What it came out as.
        value: String,
    } => at(*span, "indices and the ends of ranges are whole numbers"),

    /// Too many indices or an index on something that has none.
    #[error("{what} {}", index_words(*.available))]
    "E0111" TooManyIndices(span) {
        /// What is indexed.
        what: String,
        /// How many indices it has.
        available: usize,
    } => at(*span, if *available == 0 { "an index here" } else { "more indices than that" }),

    /// Operands whose shapes don't fit.
    #[error("{what}")]
    "E0112" Shape(span) {
        /// What doesn't fit.
        what: String,
        /// The way out, if there is one.
        help: Option<String>,
    } => at(*span, "").or_help(help.clone()),

    /// A function with the wrong number of arguments.
    #[error("`{function}` takes {expected}, not {found}")]
    "E0113" ArgumentCount(span) {
        /// The function.
        function: String,
        /// How many it takes, in words.
        expected: String,
        /// How many there are.
        found: usize,
    } => at(*span, ""),

    /// A list of values of the wrong length.
    #[error("`{name}` has {}, but {} given", counted(*.expected, "member"), counted(*.found, "value") + if *.found == 1 { " is" } else { " are" })]
    "E0114" ListLength(span) {
        /// The family.
        name: String,
        /// Its members.
        expected: usize,
        /// The values.
        found: usize,
    } => at(*span, "").with_help(match expected {
        1 => "give one value".to_owned(),
        more => format!("give {more} values, or a single one that fills the family"),
    }),

    /// An acceleration in an energy.
    #[error("{energy} contains an acceleration")]
    "E0115" Acceleration(span) {
        /// `T`, `V`, …
        energy: &'static str,
    } => at(*span, "a second time derivative")
        .with_help(format!("{energy} may contain coordinates and velocities only; was one `'` too many?")),

    /// A constraint that is neither one of coordinates nor linear in velocities.
    #[error("a constraint relates coordinates or, linearly, velocities, but this one is not linear in `{on}`")]
    "E0133" ConstraintNotLinear(span) {
        /// The velocity or acceleration.
        on: String,
    } => at(*span, "not linear in the velocities")
        .with_help("rolling without slipping is linear: x' = r*theta'; a given rate is a steady motion, `equilibrium x' = v`"),

    /// A constant that depends on coordinates or time.
    #[error("{what} must be constant, but depends on `{on}`")]
    "E0116" NotConstant(span) {
        /// What should be constant.
        what: String,
        /// What it depends on.
        on: String,
    } => at(*span, "not constant").or_help((what.starts_with("the rate of") && on != "t").then(|| format!(
        "a rate depends on parameters only: give the value of `{on}` in the steady motion by `equilibrium {on} = …`, and write this value in its place"
    ))),

    /// A parameter without a value where a number is needed.
    #[error("the parameter `{name}` has no value")]
    "E0117" MissingValue(span) {
        /// The parameter.
        name: String,
    } => at(*span, "a number is needed").with_help(format!("give it a value in the file, or `--set {name}=VALUE`")),

    /// `--set` of something that is no parameter.
    #[error("`{name}` can't be set: the model has no such parameter")]
    "E0118" UnknownSetting {
        /// What was to be set.
        name: String,
        /// A parameter that it may have been meant to be.
        nearest: Option<String>,
        /// What it is instead, and what is to be done.
        instead: Option<String>,
    } => nowhere().or_help(nearest.as_ref().map(|name| format!("did you mean `{name}`?")).or_else(|| instead.clone())),

    /// A `--set` that can't be read.
    #[error("can't read the setting `{text}`: {reason}")]
    "E0119" BadSetting {
        /// As given.
        text: String,
        /// What is wrong.
        reason: String,
    } => nowhere().with_help("write `--set NAME=VALUE` with a numeric value, for example `--set 'm[2]=3/2'`"),

    /// A table whose file was not handed over.
    #[error("the table `{path}` can't be read{reason}")]
    "E0120" MissingTable(span) {
        /// As written.
        path: String,
        /// Why, with a leading `: `; may be empty.
        reason: String,
    } => at(*span, "named here").or_help(match reason.as_str() {
        reason if reason.contains("not UTF-8") => Some("save it as UTF-8 text".to_owned()),
        reason if reason.contains("not a file") => Some("save what comes from it in a file".to_owned()),
        _ => Some("the path is taken relative to the model file".to_owned()),
    }),

    /// A table that is not a table.
    #[error("error in line {line} of the table `{path}`: {reason}")]
    "E0121" BadTable(span) {
        /// As written.
        path: String,
        /// Line of the file.
        line: u64,
        /// What is wrong.
        reason: String,
    } => at(*span, "read here"),

    /// A column that the table does not have.
    #[error("the table `{table}` has no column `{column}`")]
    "E0122" UnknownColumn(span) {
        /// The table.
        table: String,
        /// The column.
        column: String,
        /// The first columns.
        available: String,
        /// A column that it may have been meant to be.
        nearest: Option<Meant>,
    } => at(*span, "unknown column")
        .with_help(format!("its columns are {available}"))
        .or_meant(*span, nearest.as_ref()),

    /// More members or terms than fit into memory.
    #[error("{count} are too many")]
    "E0123" TooLarge(span) {
        /// How many of what.
        count: String,
    } => at(*span, "this does not fit into memory"),

    /// A relation that the values of the parameters contradict.
    #[error("this assumption does not hold for the values of the parameters")]
    "E0135" AssumptionBroken(span) {
        /// The relation of the values: `1 > 2`.
        values: String,
    } => at(*span, format!("{values} is false")).with_help(
        "change the values or the assumption: the derivation must hold for these values",
    ),

    /// Two relations of which one at most can hold.
    #[error("these assumptions contradict each other")]
    "E0141" AssumptionsContradict(span) {
        /// The earlier one.
        first: Span,
    } => at(*span, "no value satisfies this").with_secondary(*first, "if this holds").with_help("remove one of them"),

    /// What is integrated is no sum of powers times exponentials.
    #[error("`{part}` can't be integrated over `{variable}` in symbols")]
    "E0136" NoIntegral(span) {
        /// The part for which there is no rule.
        part: String,
        /// The variable.
        variable: String,
    } => at(*span, "in the integrand").with_help(format!(
        "sums and products of powers of `{variable}`, and of sin, cos, exp, sinh and cosh of linear functions of `{variable}`, can be integrated; all other factors must be constant in `{variable}`"
    )),

    /// Whether a rate in the exponentials is 0 decides on the form of an integral, and is open.
    #[error("the value of this integral depends on whether `{rate}` is 0")]
    "E0137" OpenIntegral(span) {
        /// What may be 0.
        rate: String,
        /// Whether it depends on the motion.
        moves: bool,
    } => at(*span, "integrated here").with_help(if *moves {
        "it may pass through 0 in a motion: only bounds and factors may depend on coordinates".to_owned()
    } else {
        format!("give values for which it is not 0, write `assume {rate} != 0`, or write out the integral for the case 0")
    }),

    /// An exact number of more than [`MAX_BITS`](crate::number::MAX_BITS) bits.
    #[error("{what} is too long for an exact number")]
    "E0134" NumberTooLong(span) {
        /// What comes to it.
        what: String,
    } => at(*span, "more than 30,000 digits").with_help(
        "exact numbers have up to 100,000 bits; is an exponent wrong, or a number squared again and again?",
    ),

    /// A comparison of numbers that can't be told apart.
    #[error("this comparison can't be decided")]
    "E0124" UndecidedComparison(span) => at(*span, "the two sides agree to thirty digits").with_help(
        "write the condition without roots or functions, for example with squares",
    ),

    /// An index with the name of something declared.
    #[error("the name of the index `{name}` is already in use")]
    "E0125" IndexReusesName(span) {
        /// The name.
        name: String,
        /// Where the other is declared.
        declared: Option<Span>,
    } => at(*span, "an index needs a new name")
        .and_at(*declared, "declared here")
        .or_help(declared.is_none().then(|| "an outer index has this name".to_owned())),

    /// A condition where a value is expected, or the reverse.
    #[error("{what}")]
    "E0126" ConditionOrValue(span) {
        /// What is expected and what there is.
        what: &'static str,
    } => at(*span, ""),

    /// A form that can't set indices, bounds or filters.
    #[error("{what} is not allowed in {}", match .inside {
        Some(function) => format!("`{function}(…)`"),
        None => "an index, a range or a filter".to_owned(),
    })]
    "E0127" NotForIndices(span) {
        /// What.
        what: String,
        /// The index that is alone in two pairs of brackets.
        index: Option<String>,
        /// The function of whole numbers in whose argument it is.
        inside: Option<String>,
    } => match index {
        Some(index) => at(*span, "an index has one pair of brackets").written(*span, index),
        None if inside.is_some() => at(*span, "").with_help(
            "`mod` and `floor` are for indices: they take numbers, parameters, table fields and indices; \
             a function of coordinates must have derivatives",
        ),
        None => at(*span, "")
            .with_help("literals, parameters, table fields and outer indices are allowed, with mod and floor"),
    },

    /// A division by exactly zero, or a function outside its domain.
    #[error("{what} is not defined")]
    "E0128" Undefined(span) {
        /// What.
        what: String,
        /// The rule that is broken, if there is a short one.
        help: Option<&'static str>,
    } => at(*span, "not defined").or_help(help.map(str::to_owned)),

    /// A unit that is not known.
    #[error("`{name}` is not a unit")]
    "E0129" UnknownUnit(span) {
        /// As written.
        name: String,
        /// A unit that it may have been meant to be.
        nearest: Option<Meant>,
    } => at(*span, "unknown unit").with_help(unit_elsewhere(name).unwrap_or(UNITS)).or_meant(*span, nearest.as_ref()),

    /// A table or a row where a number is expected.
    #[error("`{name}` is a table, not a number")]
    "E0130" TableAsValue(span) {
        /// The table.
        name: String,
    } => at(*span, "a table").with_help(format!("`rows({name})` is its length, `{name}[3].column` one of its fields")),

    /// A `guess` or `equilibrium` for something that is no coordinate.
    #[error("`{name}` is not a coordinate")]
    "E0131" NotACoordinate(span) {
        /// The name.
        name: String,
        /// A coordinate that it may have been meant to be.
        nearest: Option<Meant>,
        /// What the first coordinates are called.
        coordinates: String,
    } => {
        let help = format!("the coordinates are {coordinates}");
        at(*span, "not a coordinate").or_meant(*span, nearest.as_ref()).or_help((nearest.is_none() && !coordinates.is_empty()).then_some(help))
    },

    /// `model` behind other statements.
    #[error("`model` comes first")]
    "E0143" MisplacedModel(span) {
        /// The name of the model.
        name: String,
        /// The statement that comes first instead.
        first: Span,
    } => at(*span, "not the first statement")
        .with_secondary(*first, "before this one it belongs")
        .with_help(format!("move `model {name}` to the top of the file")),

    /// A mistake that only follows from another one. It is never returned.
    #[error("this follows from another error")]
    "E0100" FollowOn {} => nowhere(),

    /// A coordinate without a range where the family needs one.
    #[error("{what}")]
    "E0132" BadIndices(span) {
        /// What is wrong.
        what: String,
    } => at(*span, "all members of a family have the same number of indices, at most three"),
} else {
    /// The model grows beyond its budget.
    #[error(transparent)]
    Budget(#[from] Exceeded),
    /// Quantities of different kinds where they have to be alike.
    #[error(transparent)]
    Dimension(Box<DimensionError>),
}
}

/// A coordinate that is used and not declared.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MissingCoordinate {
    /// Its declaration.
    pub declaration: String,
    /// Where the declaration belongs.
    pub place: u32,
    /// Coordinates that are declared one by one in place of its members.
    pub members: Vec<String>,
}

impl From<DimensionError> for ModelError {
    fn from(error: DimensionError) -> Self {
        Self::Dimension(Box::new(error))
    }
}

impl ModelError {
    /// That the shapes of operands don't fit, with the way out.
    pub(super) fn shape((what, help): Misfit, span: Span) -> Self {
        Self::Shape { what, span, help }
    }

    /// A name that is not declared, with what it may have been meant to be.
    pub(super) fn undeclared(name: &str, nearest: Option<Meant>, span: Span) -> Self {
        let (name, later, integral, coordinate, by_place) = (name.to_owned(), None, None, None, None);
        Self::UndeclaredName { name, nearest, later, integral, coordinate, by_place, span }
    }
}

/// A name in the quotes of code; a description in words as it is.
fn quoted(name: &str) -> String {
    if name.contains(' ') { name.to_owned() } else { format!("`{name}`") }
}

/// `1 member`, `3 members`
pub(super) fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
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

/// What to write for a unit in an expression that is nothing else: `30*pi/180` for `30*deg`.
fn unit_in_expression(name: &str, nearest: Option<&Meant>) -> Option<String> {
    const OFTEN: [&str; 10] = ["kg", "mm", "cm", "km", "rad", "deg", "rpm", "Hz", "kN", "eV"];
    let is_other = nearest.is_some_and(|own| own.is_certain || own.text.contains(['*', ':']));
    let factor = in_si(name).filter(|_| OFTEN.contains(&name) && !is_other)?;
    Some(match factor.strip_prefix('*') {
        Some(factor) => format!(
            "expressions are in SI: write `{factor}` for `{name}`, or declare a quantity in this unit: `param a : {name} = …`"
        ),
        None => format!(
            "expressions are in SI: leave `{name}` out, or declare a quantity in this unit: `param a : {name} = …`"
        ),
    })
}

/// What a function of other languages is called here.
fn function_elsewhere(name: &str) -> Option<&'static str> {
    let help = match name.to_lowercase().as_str() {
        "log" => "the natural logarithm is `ln`; for base 10, write `ln(x)/ln(10)`",
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
        "sech" => "write `1/cosh(x)`",
        "csch" | "cosech" => "write `1/sinh(x)`",
        "coth" | "ctgh" | "cth" => "write `cosh(x)/sinh(x)`",
        "cot" | "cotan" | "ctg" => "write `cos(x)/sin(x)`",
        "diff" | "dot_product" | "derivative" | "ddt" => {
            "the time derivative is written `x'`, the product of vectors `dot(u, v)`"
        }
        "array" | "vector" | "matrix" | "vec" => "a vector is written `[x, y]`, a matrix `[[a, b], [c, d]]`",
        "length" | "magnitude" => "the length of a vector is `norm`",
        "fabs" => "write `abs`",
        "product" | "prod" => "there are only sums",
        "sign" | "sgn" | "signum" => "write `x/abs(x)`",
        "heaviside" | "step" => "write `(1 + x/abs(x))/2`",
        "max" => "write `(x + y + abs(x - y))/2`",
        "min" => "write `(x + y - abs(x - y))/2`",
        _ => return None,
    };
    Some(help)
}

/// What a unit that is written otherwise elsewhere is called here.
pub(super) fn unit_elsewhere(name: &str) -> Option<&'static str> {
    Some(match name.to_lowercase().as_str() {
        "pound" | "pounds" | "lbs" | "lbm" => "the pound is `lb`, the pound-force `lbf`",
        "dimensionless" | "none" => "a quantity without a dimension has the unit `1`",
        "grad" | "gon" | "gradian" | "gradians" => "the degree is `deg`, the radian `rad`; a gradian is 0.9 deg",
        "degc" | "degf" | "°c" | "°f" | "celsius" | "fahrenheit" | "oc" | "of" => {
            "a scale with a zero of its own is no unit: give the temperature in `K`"
        }
        _ => return None,
    })
}
