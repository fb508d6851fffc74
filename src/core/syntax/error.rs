//! The ways in which a text fails to be a model file.
//!
//! One entry a kind of mistake, each with its place.

use super::units::look_up;
use super::words::is_control;
use crate::diagnostic::{Diagnostic, at, nowhere};
use crate::mistakes;
use crate::span::Span;

const STATEMENTS: &str = "a statement starts with `model`, `param`, `coord`, `let`, `T`, `V`, `lagrangian`, \
     `dissipation`, `force`, `constraint`, `assume`, `guess`, `equilibrium`, `period`, `table` or `draw`";

/// Words of other languages that bring functions from elsewhere.
pub(super) fn is_import(word: &str) -> bool {
    matches!(word, "import" | "from" | "using")
}

/// What to write for a word that may mean a statement.
fn perhaps_meant(word: &str, meant: &str) -> String {
    match (word, meant) {
        ("def" | "define", "T" | "V" | "lagrangian" | "dissipation") => {
            format!("write `{meant} = …`, without arguments")
        }
        (_, "dissipation" | "force") => {
            "write `force x = …` for a force on the coordinate x, `dissipation = …` for half the power that friction dissipates"
                .to_owned()
        }
        ("var" | "variable", _) => "write `coord …` for a coordinate, `param …` for a constant".to_owned(),
        (_, "lagrangian") => format!(
            "write `lagrangian = …` in place of T and V, or remove it; for a quantity, `let {word} = …`"
        ),
        (_, "guess") if ["start", "initial", "init"].contains(&word) => {
            "the start of a motion is given by `librate motion --start`; `guess` is the start of the search for the equilibrium"
                .to_owned()
        }
        ("t", _) => "write `T = …` for the kinetic energy; `t` is the time".to_owned(),
        (_, "T" | "V") => format!("write `{meant} = …` for the energy, `param {word} = …` or `let {word} = …` for a quantity"),
        _ => format!("did you mean `{meant}`?"),
    }
}

/// The coordinate that the force acts on in `Q_x = …`, `Fx = …`, or `x` for any.
fn force_on(name: &str) -> Option<&str> {
    let behind = name.strip_prefix(['Q', 'F'])?;
    let coordinate = behind.strip_prefix('_').or((behind.chars().count() == 1).then_some(behind));
    let coordinate = coordinate.filter(|own| own.starts_with(char::is_alphabetic));
    coordinate.or((name == "Q").then_some("x"))
}

/// What to write for `x = 0` where `x` is declared by a statement with that word.
fn given_again(name: &str, word: &str) -> String {
    match word {
        "coord" if name.ends_with('\'') => format!(
            "write `equilibrium {name} = …` for the rate of a steady motion, `guess {name} = …` for the start of the search \
             for a periodic one; a motion begins with `librate motion --start \"{name}=…\"`"
        ),
        "coord" => format!(
            "write `equilibrium {name} = …` for the equilibrium, `guess {name} = …` for the start of the search for it"
        ),
        _ => format!("`{name}` has a statement with `{word}` already: change its value there, or take another name"),
    }
}

/// Both readings of what stands behind a number.
fn unit_or_product(fix: Option<&str>, product: Option<&str>, given: Option<&str>, is_same: bool) -> String {
    let fix = fix.unwrap_or("NAME : UNIT = VALUE");
    let unit = match given {
        None => format!("write `{fix}`"),
        Some(_) if is_same => "remove it, the name has this unit already".to_owned(),
        Some(given) => format!("the name has the unit `{given}` already; for another one write `{fix}`"),
    };
    match product {
        Some(product) => format!("{unit}, or `{product}` for a product"),
        None => unit,
    }
}

fn partner(bracket: char) -> char {
    if bracket == '(' { ')' } else { ']' }
}

mistakes! {
/// A mistake in the text of a model file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
Error SyntaxError {
    /// The file is longer than the parser accepts.
    #[error("the file is too large: at most {most} bytes are read")]
    "E0001" FileTooLarge {
        /// Its length, or so much of it as was read.
        bytes: usize,
        /// The greatest length read.
        most: usize,
    } => nowhere().with_help("write repeated terms as sum(i in 1..n, …), or keep the numbers in a table"),

    /// A statement begins with a word that is none.
    #[error("there is no statement `{word}`")]
    "E0002" UnknownStatement(span) {
        /// The word.
        word: String,
        /// The statement word probably meant.
        suggestion: Option<&'static str>,
        /// Whether nothing else can be meant.
        is_certain: bool,
    } => match suggestion {
        Some(meant) if *is_certain => at(*span, "not a statement word").written(*span, *meant),
        Some(meant) => at(*span, "not a statement word").with_help(perhaps_meant(word, meant)),
        None if *is_certain => at(*span, "not needed")
            .with_help("remove it: a statement ends where the next one begins, a model with the file")
            .replacing(*span, ""),
        None if is_control(word) => at(*span, "nothing is repeated or chosen")
            .with_help("a sum is written `sum(i in 1..n, …)`, a family `let a[i in 1..n] = …`"),
        None if is_import(word) => at(*span, "nothing has to be imported")
            .with_help("remove the line: `sin`, `exp`, `pi` and the other functions are built in")
            .replacing(*span, ""),
        None => at(*span, "a statement begins here").with_help(STATEMENTS),
    },

    /// `m = 2` without `param` or another statement word before it.
    #[error("a statement word is missing before `{name}`")]
    "E0003" MissingStatementWord(span) {
        /// The name that stands in its place.
        name: String,
        /// The statement in full, where the one before it tells which word is meant.
        fix: Option<String>,
        /// The word of the statement that declares it already.
        declared: Option<&'static str>,
    } => at(*span, "a statement begins here").with_help(match (fix, force_on(name)) {
        _ if declared.is_some() => given_again(name, declared.unwrap_or_default()),
        (Some(fix), _) => format!("write `{fix}`"),
        (None, Some(coordinate)) => format!(
            "write `force {coordinate} = …` for the force on a coordinate `{coordinate}`, `let {name} = …` for anything else"
        ),
        (None, None) => format!("write `param {name} = …` for a constant, `let {name} = …` for anything else"),
    }),

    /// Something that can't begin a statement.
    #[error("a statement can't begin with {found}")]
    "E0004" NoStatement(span) {
        /// What stands there.
        found: String,
    } => at(*span, "a statement begins here").with_help(STATEMENTS),

    /// A reserved word is declared.
    #[error("`{name}` can't be used as a name")]
    "E0005" ReservedName(span) {
        /// The word.
        name: String,
        /// What it is: `is the time`.
        meaning: &'static str,
    } => at(*span, *meaning).with_help(format!("take another name, such as `{name}_0`")),

    /// A statement word inside an expression.
    #[error("`{word}` can't be used in an expression")]
    "E0006" WordInExpression(span) {
        /// The word.
        word: String,
        /// The statement, where it is `lagrangian = T - V`.
        needless: Option<Span>,
    } => {
        let shown = at(*span, "begins a statement");
        match (needless, word.as_str()) {
            (Some(line), _) => shown
                .with_help("remove `lagrangian = T - V`: without it the Lagrangian is just this")
                .replacing(*line, ""),
            (None, "T" | "V") => shown
                .with_help("the energies are not names: give the common part a name with `let` and use that"),
            (None, _) => shown.with_help("take another name"),
        }
    },

    /// Two operands without a sign between them.
    #[error("the multiplication sign is missing")]
    "E0007" MissingMultiplication(span) {
        /// The product as it should be, or its beginning.
        fix: String,
        /// What is replaced.
        place: Span,
        /// By what: the whole product, or a `*` in the gap.
        text: String,
        /// Whether all of it are factors.
        is_certain: bool,
        /// What may be missing instead: a comma, or the word of a second statement.
        separator: Option<&'static str>,
        /// What to write if it is no product, where it may be a unit or an uncertainty: `if a unit is meant, …`.
        instead: Option<String>,
    } => {
        let shown = at(*span, "two factors without an operator between them");
        let separated = separator.zip(fix.rsplit_once('*')).map(|(separator, (left, right))| match separator {
            "," => format!("{left}, {right}"),
            word => format!("{word} {right} = …"),
        });
        match (instead, separated) {
            (Some(instead), _) => shown.with_help(format!("write `{fix}`, or, {instead}")),
            (None, Some(separated)) => shown.with_help(format!("write `{separated}`, or `{fix}` for a product")),
            (None, None) if *is_certain => shown.with_help(format!("write `{fix}`")).replacing(*place, text),
            (None, None) => shown.with_help(format!("write `{fix}`")),
        }
    },

    /// `3 4`
    #[error("two numbers side by side")]
    "E0008" TwoNumbers(span) =>
        at(*span, "nothing between them").with_help("write an operator or a comma between them"),

    /// `sin x`
    #[error("the argument of `{function}` needs parentheses")]
    "E0009" MissingParentheses(span) {
        /// The function.
        function: String,
        /// The argument, or its beginning.
        argument: String,
    } => at(*span, "a function without parentheses").with_help(format!("write `{function}({argument})`")),

    /// `np.cos(x)`, `v.norm()`
    #[error("a function has no prefix: `{function}`")]
    "E0059" PrefixedFunction(span) {
        /// The function with what stands before it.
        function: String,
        /// The call as the language has it, if it has the function.
        fix: Option<String>,
        /// What is replaced, where the whole of it is known, and by what.
        change: Option<(Span, String)>,
    } => at(*span, "a name and a point before a function")
        .with_help(match fix {
            Some(fix) => format!("write `{fix}`"),
            None => format!("there is no function `{}` without it either", function.rsplit('.').next().unwrap_or_default()),
        })
        .or_replacing(change.as_ref()),

    /// `sin^2(x)`
    #[error("the power of `{function}` is written after its argument")]
    "E0010" FunctionPower(span) {
        /// The function.
        function: String,
        /// The exponent.
        exponent: String,
        /// What is replaced, where the argument is in parentheses, and by what.
        change: Option<(Span, String)>,
    } => at(*span, "a power before the argument")
        .with_help(match (exponent.as_str(), function.as_str()) {
            ("-1", "sin" | "cos" | "tan") => {
                format!("write `a{function}(…)` for the inverse function, `1/{function}(…)` for the reciprocal")
            }
            _ => format!("write `{function}(…)^{exponent}`"),
        })
        .or_replacing(change.as_ref()),

    /// `1.` or `.5`.
    #[error("a number needs digits on both sides of the point")]
    "E0011" HalfNumber(span) {
        /// The number in full; none where the point belongs to what stands on its other side.
        fix: Option<String>,
    } => match fix {
        Some(fix) => at(*span, "not a complete number").written(*span, fix),
        None => at(*span, "one point too many").with_help("a number has one point, a range two, a product none: `1.5`, `1..3`, `2*x`"),
    },

    /// `9,81`
    #[error("the decimal sign is a point, not a comma")]
    "E0012" DecimalComma(span) {
        /// The number with a point for the comma.
        decimal: Option<String>,
        /// The number without the commas or points between its thousands.
        thousands: Option<String>,
        /// Whether there is no blank in it, and it is one number only.
        is_certain: bool,
    } => match (decimal, thousands) {
        (Some(decimal), None) if *is_certain => at(*span, "two numbers here").written(*span, decimal),
        (Some(decimal), None) => at(*span, "two numbers here")
            .with_help(format!("write `{decimal}` for a number, `[…, …]` for a list")),
        (Some(decimal), Some(thousands)) => at(*span, "two numbers here").with_help(format!(
            "write `{decimal}` if the comma is the decimal sign, `{thousands}` if it separates thousands"
        )),
        (None, thousands) => at(*span, "several numbers here").with_help(format!(
            "write `{}` for a number, without signs between the digits; `[…, …]` for a list",
            thousands.as_deref().unwrap_or("…")
        )),
    },

    /// `+x`
    #[error("a plus sign needs something on its left")]
    "E0013" UnaryPlus(span) => at(*span, "positive numbers have no sign").with_help("remove the `+`").replacing(*span, ""),

    /// `**`
    #[error("`**` is not an operator")]
    "E0014" DoubleStar(span) => at(*span, "no such operator").with_help("a power is written `x^2`").replacing(*span, "^"),

    /// An operator without its right operand.
    #[error("something is missing after `{sign}`")]
    "E0015" MissingOperand(span) {
        /// The operator, comma or bracket.
        sign: String,
        /// What stands there instead.
        found: Option<(String, Span)>,
    } => match found {
        Some((what, place)) => at(*span, "no operand after it").with_secondary(*place, format!("{what} follows")),
        None => at(*span, "no operand after it"),
    },

    /// An operator without its left operand.
    #[error("something is missing before `{sign}`")]
    "E0016" MissingLeftOperand(span) {
        /// The operator.
        sign: String,
    } => at(*span, format!("`{sign}` needs an operand on each side")),

    /// Nothing behind `=`.
    #[error("the value after `=` is missing")]
    "E0017" MissingValue(span) =>
        at(*span, "nothing follows").with_help("write the value; a `param` without a value has no `=`"),

    /// A statement that needs a right side has none, or no `=` before it.
    #[error("{}", match .value {
        Some(_) => "`=` is missing before the value".to_owned(),
        None => format!("`{statement}` needs a right side: `= …`"),
    })]
    "E0018" MissingRightSide(span) {
        /// The statement word.
        statement: &'static str,
        /// The value, where it stands there.
        value: Option<String>,
    } => match value {
        Some(value) => at(*span, "no `=` before it").written(*span, format!("= {value}")),
        None => at(*span, "`= …` is missing here").with_help(match *statement {
        "constraint" => "a constraint is written `constraint EXPR = EXPR`",
        "T" | "V" | "lagrangian" | "dissipation" => "write `=` and the expression",
        "table" => "write `= \"file.csv\"`",
        _ => "only a `param` may have no value",
        }),
    },

    /// Nothing where a statement expects an expression.
    #[error("an expression is missing after `{statement}`")]
    "E0019" MissingExpression(span) {
        /// The statement word.
        statement: &'static str,
    } => at(*span, "nothing follows").with_help(match *statement {
        "period" => "write the period of the explicit time dependence: `period 2*pi/W`",
        "draw" => "what is drawn is written `draw point r`, `draw line r, s` or `draw spring r, s`",
        "assume" => "write a relation between parameters: `assume k > 0, l > d`",
        _ => "a constraint is written `constraint EXPR = EXPR`",
    }),

    /// No name behind a word that needs one.
    #[error("a name is missing after `{statement}`")]
    "E0020" MissingName(span) {
        /// The statement word.
        statement: &'static str,
        /// What stands there instead, or the end.
        found: String,
    } => at(*span, format!("{found} instead of a name")).with_help(match *statement {
        "model" => "write `model NAME`; a name is a letter or `_`, then letters, digits and `_`, without quotes",
        "force" => "write `force x = …`, with the coordinate that the force acts on",
        _ => "a name is a letter or `_`, then letters, digits and `_`",
    }),

    /// `let m = 1, k = 2`
    #[error("`{statement}` gives one value")]
    "E0021" SeveralValues(span) {
        /// The statement word.
        statement: &'static str,
    } => at(*span, "a second value").with_help("write a statement for each name"),

    /// `T : J = …`
    #[error("`{statement}` takes no unit")]
    "E0022" MisplacedUnit(span) {
        /// The statement word.
        statement: &'static str,
    } => at(*span, "begins a unit").with_help(match *statement {
        "T" | "V" | "lagrangian" => "remove it: this is an energy",
        "dissipation" => "remove it: this is a power",
        _ => "remove it",
    }),

    /// `x[i 1..n]`
    #[error("`in` is missing")]
    "E0023" IndexWithoutIn(span) {
        /// The index's name.
        name: String,
    } => at(*span, "an index and its range without a word between them").with_help(format!("write `{name} in 1..n`")),

    /// Two names where one belongs.
    #[error("`{statement}` takes one name")]
    "E0024" SeveralNames(span) {
        /// The statement word.
        statement: &'static str,
    } => at(*span, "a second name").with_help(match *statement {
        "model" => "a model's name is one word; join words with `_`",
        _ => "write a statement for each name",
    }),

    /// `coord x y`
    #[error("a comma is missing between the names")]
    "E0025" MissingComma(span) {
        /// The first name.
        left: String,
        /// The second name.
        right: String,
    } => at(*span, "two names without a comma").with_help(match look_up(right) {
        Some(_) => format!("write `{left} : {right}` for a unit, `{left}, {right}` for two names"),
        None => format!("write `{left}, {right}`"),
    }),

    /// `=` inside a condition.
    #[error("a comparison is written `==`")]
    "E0026" EqualsForComparison(span) => at(*span, "gives a value").written(*span, "=="),

    /// `==` where a value is given.
    #[error("a value is given with a single `=`")]
    "E0027" ComparisonForEquals(span) => at(*span, "compares two values").written(*span, "="),

    /// `:=`, `<-`, `+=`, or a colon without a unit.
    #[error("{}", match .assignment {
        Some(sign) => format!("a value is given with `=`, not with `{sign}`"),
        None => "a unit is missing after the colon".to_owned(),
    })]
    "E0028" MissingUnit(span) {
        /// The sign of another language.
        assignment: Option<&'static str>,
    } => match *assignment {
        Some(":=") => at(*span, "a colon begins a unit").written(*span, "="),
        Some("<-") => at(*span, "not a sign of the language").written(*span, "="),
        Some(_) => at(*span, "nothing is added up in steps").with_help("write `=` and all terms in one sum"),
        None => at(*span, "no unit follows").with_help("write a unit, `: 1` for a pure number, or remove the colon"),
    },

    /// A second `=`.
    #[error("a second `=` in one statement")]
    "E0029" SecondEquals(span) => at(*span, "the statement has its `=` already").with_help("if a new statement begins here, its first word is missing"),

    /// `coord x = 1`
    #[error("a coordinate has no value of its own")]
    "E0030" CoordinateValue(span) => at(*span, "gives a value").with_help("`equilibrium NAME = …` gives its equilibrium, `guess NAME = …` the start of the search for it"),

    /// `param f(x) = …`
    #[error("functions can't be defined")]
    "E0031" FunctionDefinition(span) => at(*span, "no argument is allowed here").with_help("a family has square brackets: `let f[i in 1..n] = …`; other names are used directly in the expression"),

    /// `period = …`, `model = …`
    #[error("`{statement}` is written without `=`")]
    "E0032" NeedlessEquals(span) {
        /// The statement word.
        statement: &'static str,
    } => at(*span, "not needed").with_help(match *statement {
        "period" => "write `period EXPR`",
        "model" => "write `model NAME`",
        _ => "remove the `=`",
    }),

    /// A bracket without its partner.
    #[error("the bracket `{bracket}` is never closed")]
    "E0033" UnclosedBracket {
        /// The bracket.
        bracket: char,
        /// Its place.
        open: Span,
        /// The end of the statement, where the partner is missing at the latest.
        end: Span,
    } => at(*end, format!("`{}` is missing, at the latest here", partner(*bracket)))
        .with_secondary(*open, "opened here"),

    /// A closing bracket without an opening one.
    #[error("`{bracket}` closes no bracket")]
    "E0034" StrayBracket(span) {
        /// The bracket.
        bracket: char,
    } => at(*span, "no bracket is open here").with_help("remove it, or open a bracket before it"),

    /// `(…]`
    #[error("`{close}` closes `{bracket}`")]
    "E0035" MismatchedBracket(span) {
        /// The opening bracket.
        bracket: char,
        /// Its place.
        open: Span,
        /// The closing bracket.
        close: char,
    } => at(*span, format!("`{}` expected", partner(*bracket))).with_secondary(*open, "opened here"),

    /// Brackets, signs or powers within each other beyond the limit.
    #[error("this is nested too deeply: more than {most} levels")]
    "E0036" NestingTooDeep(span) {
        /// The deepest level read.
        most: usize,
    } => at(*span, "one level too many").with_help("name a part of the expression with `let`"),

    /// A character the language has no use for.
    #[error("`{character}` has no meaning here")]
    "E0037" IllegalCharacter(span) {
        /// The character or a run of them.
        character: String,
        /// What to write instead.
        hint: Option<&'static str>,
        /// A rewriting that depends on the character, such as `^2`.
        fix: Option<String>,
        /// Whether it may be something else together with what stands before it, as a number and a fraction.
        is_glued: bool,
    } => {
        let is_word = fix.is_some() && character.chars().all(char::is_alphabetic);
        let what = if is_word { "not a word of the language" } else { "not a character of the language" };
        // Of a longer run it is the first character's.
        let is_whole = is_word || character.chars().count() == 1;
        match (fix, at(*span, what)) {
            (Some(fix), told) if *is_glued => told.with_help(format!("write `{fix}`")),
            (Some(fix), told) if is_whole || fix.starts_with('^') => {
                told.with_help(format!("write `{}`", fix.trim())).replacing(*span, fix.as_str())
            }
            (Some(fix), told) => told.with_help(format!("write `{}`", fix.trim())),
            (None, told) => told.or_help(hint.map(str::to_owned)),
        }
    },

    /// A quote without its partner.
    #[error("the closing quote is missing")]
    "E0038" OpenText(span) => at(*span, "opened here, not closed on this line").with_help("end the text with `\"`"),

    /// Quoted text where none belongs.
    #[error("text in quotes is allowed only after `table NAME =`")]
    "E0039" MisplacedText(span) {
        /// The number within the quotes, if it is one.
        number: Option<String>,
    } => at(*span, "not a value").with_help(match number {
        Some(number) => format!("numbers are written without quotes: `{number}`"),
        None => "names and numbers are written without quotes".to_owned(),
    }),

    /// `;` within brackets.
    #[error("a semicolon is not allowed inside brackets")]
    "E0040" SemicolonInBrackets(span) {
        /// The bracket around it.
        open: Span,
    } => at(*span, "ends a statement")
        .with_secondary(*open, "inside this bracket")
        .with_help("the rows of a matrix are vectors: `[[1, 2], [3, 4]]`"),

    /// `±` where no parameter gets its value.
    #[error("an uncertainty is not allowed here")]
    "E0041" MisplacedUncertainty(span) {
        /// Whether it stands in a list of values of a parameter.
        in_list: bool,
    } => at(*span, "not after the value of a parameter").with_help(if *in_list {
        "the uncertainties of a list are a list after it: `param k[1..2] = [2, 3] ± [0.3, 0.4]`"
    } else {
        "only a parameter has an uncertainty, once, after its whole value: `param g = 9.81 ± 0.01`"
    }),

    /// A comparison outside of a filter.
    #[error("a condition is allowed only after `where`")]
    "E0042" ConditionOutsideFilter(span) {
        /// Whether a word chooses between two values.
        is_choice: bool,
    } => at(*span, "a condition has no value").with_help(if *is_choice {
        "there is no `if`: `(x + abs(x))/2` is x where x > 0, else 0; terms of a sum are selected by `sum(i in 1..n where i != 2, …)`"
    } else {
        "select terms of a sum with a filter: `sum(i in 1..n where i != 2, …)`"
    }),

    /// `1 < i < n`
    #[error("comparisons can't be chained")]
    "E0043" ChainedComparison(span) {
        /// The first comparison.
        first: Span,
    } => at(*span, "a second comparison")
        .with_secondary(*first, "compared already")
        .with_help("write two comparisons: `1 < i and i < n`, and `assume 0 < d, d < l` with a comma"),

    /// `assume k`, `assume k == 1`
    #[error("an assumption is an inequality")]
    "E0060" NoRelation(span) => at(*span, "not one").with_help("write `assume k > 0, l > d`, with `>`, `<`, `>=`, `<=` or `!=` and several with commas; a value is given by `param k = 1`"),

    /// `i in 1..3, where …`
    #[error("no comma belongs before `where`")]
    "E0044" CommaBeforeWhere(span) => at(*span, "another index would follow").with_help("the condition follows the last index directly: `i in 1..n where i != 2`"),

    /// `not` where no condition begins.
    #[error("`not` can only begin a condition")]
    "E0045" MisplacedNot(span) =>
        at(*span, "no condition begins here").with_help("put the condition in parentheses: `not (…)`"),

    /// `..` outside of indices.
    #[error("a range is not allowed here")]
    "E0046" MisplacedRange(span) =>
        at(*span, "ranges are allowed only in indices").with_help("add up the members with `sum(i in 1..n, …)`"),

    /// An index with `in` but neither a range nor a table behind it.
    #[error("a range needs two ends")]
    "E0047" HalfRange(span) =>
        at(*span, "only one end").with_help("write `i in 1..n`, or `b in TABLE` for the rows of a table"),

    /// `sum(x)`, `sum(1..3, x)`, `sum(i=1..3, x)`
    #[error("`sum` needs an index: `sum(i in 1..n, …)`")]
    "E0048" SumWithoutIndex(span) => at(*span, "no index with `in`").with_help("write `sum(i in 1..n, …)`, or `sum(b in TABLE, …)` for the rows of a table"),

    /// `sum(i in 1..n)`
    #[error("nothing is summed here")]
    "E0049" SumWithoutBody(span) =>
        at(*span, "no summand after the indices").with_help("write the summand after a comma: `sum(i in 1..n, x[i])`"),

    /// `integral(x)`, `integral(x in a..b)`, `integral(x in a..b, y in c..d, …)`, `integral(x in a..b where …, …)`
    #[error("an integral has one variable with its bounds, and an integrand")]
    "E0061" IntegralForm(span) => at(*span, "here").with_help("write `integral(x in a..b, …)`; nest integrals over several variables"),

    /// `2'` or `2[1]`
    #[error("a number can't be followed by `{sign}`")]
    "E0050" PostfixOnNumber(span) {
        /// The sign.
        sign: String,
    } => at(*span, "not after a number").with_help(match sign.as_str() {
        "'" => "the derivative of a number is 0",
        _ => "only names, function values, vectors and parentheses have members",
    }),

    /// `param x' = 1`
    #[error("a prime is not allowed here")]
    "E0051" MisplacedRate(span) {
        /// The statement word.
        statement: &'static str,
    } => match *statement {
        "equilibrium" | "guess" => at(*span, "not here").with_help(format!(
            "a rate has one prime, after the brackets if there are any: `{statement} x[1]' = …`"
        )),
        _ => at(*span, "not for this statement").with_help(
            "remove the `'`; only `equilibrium` may give a rate, and `guess` a velocity",
        ),
    },

    /// `param g = 9.81 : m/s^2`, `param l = 30 cm`
    #[error("the unit belongs after the name")]
    "E0052" UnitBehindValue(span) {
        /// The statement with the unit where it belongs, if it is short.
        fix: Option<String>,
        /// The value as a product, which may be meant.
        product: Option<String>,
        /// The unit that the name has already.
        given: Option<String>,
        /// What is replaced, where it can only be a unit, and by what.
        change: Option<(Span, String)>,
    } => at(*span, "after the value")
        .with_help(unit_or_product(fix.as_deref(), product.as_deref(), given.as_deref(), change.is_some()))
        .or_replacing(change.as_ref()),

    /// Something in a unit that is no part of one.
    #[error("this is not a unit")]
    "E0053" BadUnit(span) => at(*span, "not part of a unit").with_help("a unit is made of names, `*`, `/`, `^` and parentheses: `kg*m/s^2`; `1` for a pure number"),

    /// An exponent of a unit that is not a fraction of small integers.
    #[error("the exponent of a unit is an integer or a fraction in parentheses")]
    "E0054" UnitExponent(span) => at(*span, "not such an exponent").with_help("write `m^2`, `s^-1` or `m^(1/2)`"),

    /// A name with a hyphen: `model double-pendulum`
    #[error("a name has no hyphens, points or blanks")]
    "E0055" BrokenName(span) {
        /// The name with underscores.
        fix: String,
        /// Whether nothing else calls it by the name.
        is_certain: bool,
    } => at(*span, "not one name")
        .with_help(format!("write `{fix}`"))
        .or_replacing(is_certain.then(|| (*span, fix.clone())).as_ref()),

    /// A point without a column behind it.
    #[error("the name of a column is missing after the point")]
    "E0056" MissingColumn(span) =>
        at(*span, "nothing follows").with_help("write a column of the table: `b.k`; a range has two points: `1..n`"),

    /// `table NAME` without a path in quotes.
    #[error("`table` needs the path of a CSV file in quotes")]
    "E0057" MissingPath(span) {
        /// The path in the quotes that it needs, where it has others.
        fix: Option<String>,
    } => match fix {
        Some(fix) => at(*span, "no double quotes").written(*span, fix),
        None => at(*span, "no text in quotes").with_help("write `table NAME = \"file.csv\"`"),
    },

    /// `x'(t)`, `d/dt x`, `x.diff(t)`
    #[error("{}", match .fix {
        None => "a time derivative takes no argument",
        Some(_) => "a time derivative is written with a prime, without an argument",
    })]
    "E0062" ArgumentOfDerivative(span) {
        /// The derivative as the language has it, where it has no prime.
        fix: Option<String>,
    } => match fix {
        None => at(*span, "not needed")
            .with_help("remove it: coordinates depend on the time as they are")
            .replacing(*span, ""),
        Some(fix) => at(*span, "a time derivative").written(*span, fix),
    },

    /// `// …`, `% …`, `/* … */`
    #[error("a comment begins with `#`")]
    "E0063" ForeignComment(span) {
        /// What to do where it may be an operator, or goes on behind the line or ends before it.
        help: Option<&'static str>,
    } => match help {
        None => at(*span, "begins no comment here").written(*span, "#"),
        Some(help) => at(*span, "begins no comment here").with_help(*help),
    },

    /// `x'' + k*x = 0`
    #[error("an equation of motion is derived from the energies, not given")]
    "E0064" EquationOfMotion(span) {
        /// The coordinate whose acceleration is in it.
        coordinate: String,
    } => at(*span, "an equation of motion").with_help(format!(
        "give the energies that it follows from, such as `T = 1/2*m*{coordinate}'^2` and `V = 1/2*k*{coordinate}^2`; \
         `librate derive` gives the equation"
    )),

    /// `Sum[m[i], {i, 1, 3}]`
    #[error("the index of {} comes first, and has no braces", if .fix.starts_with("sum") { "a sum" } else { "an integral" })]
    "E0065" IndexInBraces(span) {
        /// The sum as the language has it, or its beginning.
        fix: String,
        /// The same in full.
        text: String,
    } => at(*span, "the index behind what is summed").with_help(format!("write `{fix}`")).replacing(*span, text),

    /// `constraint rod[i in 1..n]: …`, `constraint i in 1..n: …`
    #[error("the indices of a constraint belong in brackets before it")]
    "E0066" ConstraintIndices(span) {
        /// The indices in brackets.
        fix: String,
        /// What is replaced, where the end of it is known.
        place: Option<Span>,
    } => at(*span, "an index of the constraint")
        .with_help(format!("write `constraint {fix} …`"))
        .or_replacing(place.map(|place| (place, format!(" {fix}"))).as_ref()),

    /// `x[1:3]`, `i in 1 to 3`, `sum(i in 1..3: x[i])`
    #[error("{}", if *.is_end { "a comma ends the indices of a sum" } else { "a range is written with two points" })]
    "E0067" ColonForRange(span) {
        /// Whether it is the word `to`.
        is_word: bool,
        /// Whether the range stands before it.
        is_end: bool,
    } => at(*span, if *is_word { "not a word of the language" } else { "a colon begins a unit" })
        .written(*span, if *is_end { "," } else { ".." }),

    /// `x(0) = 1`
    #[error("a model has no initial values")]
    "E0068" InitialValue(span) {
        /// The value as the command has it.
        fix: String,
    } => at(*span, "a value at one time").with_help(format!(
        "remove the line, and give the value to the motion that begins with it: `librate motion FILE --start \"{fix}\"`"
    )),

    /// `0x10`, `1_000`, `6.02x10^23`, `1e`
    #[error("this is not a number of the language")]
    "E0069" ForeignNumber(span) {
        /// The number as the language has it.
        fix: Option<String>,
    } => match fix {
        Some(fix) => at(*span, "a number and letters").written(*span, fix),
        None => at(*span, "digits are missing after the `e`")
            .with_help("write the power of ten after it: `6.02e23`, `1e-3`"),
    },

    /// A name with a letter that looks like another one: the sign of the ohm for Omega.
    #[error(
        "`{character}` (U+{:04X}) is the same as `{meant}` (U+{:04X}) and is not used in names",
        u32::from(*.character),
        u32::from(*.meant)
    )]
    "E0070" UnusualLetter(span) {
        /// As it is written.
        character: char,
        /// The letter that Unicode has it for.
        meant: char,
    } => at(*span, format!("`{meant}` is meant")).written(*span, *meant),

    /// Anything else.
    #[error("{found} is not allowed here")]
    "E0058" Unexpected(span) {
        /// What stands there.
        found: String,
        /// What could stand there, in plain words.
        expected: Vec<&'static str>,
    } => at(*span, match expected.as_slice() {
        [] => String::new(),
        [one] => format!("expected {one}"),
        [first @ .., last] => format!("expected {} or {last}", first.join(", ")),
    })
    .or_help((found == "`in`").then(|| {
        "indices come first, then the filter: `sum(i in 1..3, j in 1..3 where i != j, …)`; what is said of a family as a whole, as in `assume k > 0`, holds for each member".to_owned()
    })),
}
}

impl SyntaxError {
    /// The place of the mistake; empty at 0 where the whole file is at fault.
    pub fn span(&self) -> Span {
        let place = Diagnostic::from(self).primary;
        place.map_or(Span::default(), |label| label.span)
    }
}
