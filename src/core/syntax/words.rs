//! The language's own words, and the words that other languages use for the same things.
//!
//! Tables only; nothing here reads text.

/// The words that begin a statement.
pub const STATEMENT_WORDS: [&str; 15] = [
    "model",
    "param",
    "coord",
    "let",
    "T",
    "V",
    "lagrangian",
    "dissipation",
    "force",
    "constraint",
    "assume",
    "guess",
    "equilibrium",
    "period",
    "table",
];

/// Words with a meaning inside expressions, besides the functions.
const EXPRESSION_WORDS: [&str; 10] = ["t", "pi", "sum", "integral", "in", "where", "and", "or", "not", "rows"];

/// The functions, `sum`, `integral` and `rows` apart.
pub const FUNCTIONS: [&str; 32] = [
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "ln",
    "sqrt",
    "abs",
    "norm",
    "dot",
    "cross",
    "transpose",
    "mod",
    "floor",
    "rot_x",
    "rot_y",
    "rot_z",
    "angular_velocity",
    "inertia_sphere",
    "inertia_shell",
    "inertia_cylinder",
    "inertia_rod",
    "inertia_box",
    "inertia_point",
    "steiner",
    "about",
];

/// The function that is meant by a name behind a prefix, `np.arctan`.
pub(super) fn function_meant(word: &str) -> Option<&'static str> {
    let own = FUNCTIONS.into_iter().find(|own| *own == word);
    own.or(match word {
        "arcsin" => Some("asin"),
        "arccos" => Some("acos"),
        "arctan" => Some("atan"),
        "arctan2" => Some("atan2"),
        "log" => Some("ln"),
        "fabs" | "absolute" | "Abs" => Some("abs"),
        "inner" | "vdot" => Some("dot"),
        "fmod" | "remainder" => Some("mod"),
        _ => None,
    })
}

pub(super) fn is_statement_word(word: &str) -> bool {
    STATEMENT_WORDS.contains(&word)
}

/// `T`, `V`, `lagrangian`, `dissipation`: followed by `=`.
pub(super) fn is_function_statement(word: &str) -> bool {
    matches!(word, "T" | "V" | "lagrangian" | "dissipation")
}

/// Statement words behind which a name stands.
pub(super) fn is_naming(word: &str) -> bool {
    matches!(word, "model" | "param" | "coord" | "let" | "force" | "guess" | "equilibrium" | "table")
}

/// Statement words behind which an expression stands.
pub(super) fn takes_expression(word: &str) -> bool {
    matches!(word, "constraint" | "assume" | "period")
}

/// Statement words behind which several names may stand, with commas.
pub(super) fn takes_several(word: &str) -> bool {
    matches!(word, "param" | "coord")
}

/// Words between operands: none of them can be an operand.
pub(super) fn is_connective(word: &str) -> bool {
    matches!(word, "in" | "where" | "and" | "or" | "not")
}

/// Whether a parenthesis may follow at a distance: `sin (x)`.
pub(super) fn is_function(word: &str) -> bool {
    matches!(word, "sum" | "integral" | "rows") || FUNCTIONS.contains(&word)
}

/// What a reserved word means, for the error about declaring it; `None` where it is free.
pub(super) fn reserved_for(word: &str) -> Option<&'static str> {
    match word {
        "T" => Some("is the kinetic energy"),
        "V" => Some("is the potential energy"),
        "t" => Some("is the time"),
        "pi" => Some("is the number 3.14159…"),
        _ if is_statement_word(word) => Some("begins a statement"),
        _ if EXPRESSION_WORDS.contains(&word) => Some("is a word of the language"),
        _ if FUNCTIONS.contains(&word) => Some("is a function"),
        _ => None,
    }
}

/// The statement word that somebody means who writes `word`, where the spelling doesn't tell.
pub(super) fn synonym(word: &str) -> Option<&'static str> {
    match word {
        "parameter" | "parameters" | "params" | "const" | "constant" | "var" | "variable" | "set" | "par" => {
            Some("param")
        }
        "coordinate" | "coordinates" | "coords" | "dof" | "generalized" | "q" => Some("coord"),
        "def" | "define" => Some("let"),
        "kinetic" | "kinetic_energy" | "K" | "KE" | "Ekin" | "E_kin" | "Tkin" => Some("T"),
        "potential" | "potential_energy" | "U" | "PE" | "Epot" | "E_pot" | "W" => Some("V"),
        "L" | "Lagrangian" | "lagrange" | "lag" => Some("lagrangian"),
        "F" | "D" | "rayleigh" | "damping" | "friction" => Some("dissipation"),
        "Q" | "forcing" | "torque" | "moment" | "input" => Some("force"),
        "constrain" | "subject" | "restrict" => Some("constraint"),
        "assumption" | "assumptions" | "assuming" | "suppose" | "given" => Some("assume"),
        "start" | "initial" | "init" => Some("guess"),
        "equilibria" | "rest" | "eq" => Some("equilibrium"),
        "name" | "title" | "system" => Some("model"),
        "csv" | "data" | "load" | "import" | "include" => Some("table"),
        _ => None,
    }
}
