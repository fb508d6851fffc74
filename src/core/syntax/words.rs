//! The language's own words, and the words that other languages use for the same things.
//!
//! Tables only; nothing here reads text.

/// The words that begin a statement.
pub const STATEMENT_WORDS: [&str; 16] = [
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
    "draw",
];

/// Units that parameters are often called as.
pub(crate) const SHORT_UNITS: [&str; 12] = ["m", "g", "s", "N", "A", "C", "F", "H", "J", "K", "h", "d"];

/// Units that stand behind a number in a text, if no such name is declared.
pub(super) const UNITS_BEHIND_NUMBERS: [&str; 22] = [
    "m", "g", "s", "N", "J", "K", "kg", "mm", "cm", "km", "ms", "rad", "deg", "Hz", "kN", "Pa", "kPa", "MPa", "GPa",
    "W", "eV", "rpm",
];

/// Words with a meaning inside expressions, besides the functions.
const EXPRESSION_WORDS: [&str; 10] = ["t", "pi", "sum", "integral", "in", "where", "and", "or", "not", "rows"];

/// The Greek letters by name: LaTeX, Unicode.
#[cfg(feature = "format")]
pub(crate) const GREEK: &[(&str, &str, &str)] = &[
    ("alpha", r"\alpha", "α"),
    ("beta", r"\beta", "β"),
    ("gamma", r"\gamma", "γ"),
    ("delta", r"\delta", "δ"),
    ("epsilon", r"\varepsilon", "ε"),
    ("zeta", r"\zeta", "ζ"),
    ("eta", r"\eta", "η"),
    ("theta", r"\theta", "θ"),
    ("iota", r"\iota", "ι"),
    ("kappa", r"\kappa", "κ"),
    ("lambda", r"\lambda", "λ"),
    ("mu", r"\mu", "μ"),
    ("nu", r"\nu", "ν"),
    ("xi", r"\xi", "ξ"),
    ("pi", r"\pi", "π"),
    ("rho", r"\rho", "ρ"),
    ("sigma", r"\sigma", "σ"),
    ("tau", r"\tau", "τ"),
    ("upsilon", r"\upsilon", "υ"),
    ("phi", r"\varphi", "φ"),
    ("chi", r"\chi", "χ"),
    ("psi", r"\psi", "ψ"),
    ("omega", r"\omega", "ω"),
    ("Gamma", r"\Gamma", "Γ"),
    ("Delta", r"\Delta", "Δ"),
    ("Theta", r"\Theta", "Θ"),
    ("Lambda", r"\Lambda", "Λ"),
    ("Xi", r"\Xi", "Ξ"),
    ("Pi", r"\Pi", "Π"),
    ("Sigma", r"\Sigma", "Σ"),
    ("Upsilon", r"\Upsilon", "Υ"),
    ("Phi", r"\Phi", "Φ"),
    ("Psi", r"\Psi", "Ψ"),
    ("Omega", r"\Omega", "Ω"),
];

/// The functions, `sum`, `integral` and `rows` apart.
pub const FUNCTIONS: [&str; 32] = {
    let mut names = [""; 32];
    let mut at = 0;
    while at < names.len() {
        names[at] = name_in(SIGNATURES[at].0);
        at += 1;
    }
    names
};

/// What is called.
const fn name_in(call: &'static str) -> &'static str {
    let mut end = 0;
    while call.as_bytes()[end] != b'(' {
        end += 1;
    }
    call.split_at(end).0
}

/// How each function is called, and what it gives; the three that are words of the language at the end.
const SIGNATURES: [(&str, &str); 35] = [
    ("sin(x)", "sine, of an angle in rad"),
    ("cos(x)", "cosine, of an angle in rad"),
    ("tan(x)", "tangent, of an angle in rad"),
    ("asin(x)", "the angle in -pi/2..pi/2 whose sine is x"),
    ("acos(x)", "the angle in 0..pi whose cosine is x"),
    ("atan(x)", "the angle in -pi/2..pi/2 whose tangent is x"),
    ("atan2(y, x)", "the angle of the point (x, y), in -pi..pi"),
    ("sinh(x)", "hyperbolic sine"),
    ("cosh(x)", "hyperbolic cosine"),
    ("tanh(x)", "hyperbolic tangent"),
    ("exp(x)", "exponential function"),
    ("ln(x)", "natural logarithm"),
    ("sqrt(x)", "square root"),
    ("abs(x)", "absolute value"),
    ("norm(v)", "length of a vector"),
    ("dot(u, v)", "scalar product"),
    ("cross(u, v)", "vector product in space"),
    ("transpose(A)", "the matrix with rows and columns exchanged"),
    ("mod(a, b)", "remainder of a divided by b, in ranges and indices"),
    ("floor(a)", "the largest whole number up to a, in ranges and indices"),
    ("rot_x(a)", "rotation by the angle a about the x axis: a matrix"),
    ("rot_y(a)", "rotation by the angle a about the y axis: a matrix"),
    ("rot_z(a)", "rotation by the angle a about the z axis: a matrix"),
    ("angular_velocity(R)", "angular velocity of a rotation matrix, in the frame of the body"),
    ("inertia_sphere(m, r)", "tensor of inertia of a solid sphere, about its centre"),
    ("inertia_shell(m, r)", "tensor of inertia of a hollow sphere, about its centre"),
    ("inertia_cylinder(m, r, h)", "tensor of inertia of a solid cylinder along z, about its centre"),
    ("inertia_rod(m, l)", "tensor of inertia of a thin rod along z, about its centre"),
    ("inertia_box(m, a, b, c)", "tensor of inertia of a box with edges along x, y and z, about its centre"),
    ("inertia_point(m, r)", "tensor of inertia of a point mass at the vector r, about the origin"),
    ("steiner(I, m, d)", "a tensor about the centre of mass, moved by the vector d"),
    ("about(I, n)", "moment of inertia about the axis along n, which may have any length"),
    ("sum(i in a..b, EXPR)", "sum over an index, or over the rows of a table: `sum(b in TABLE, EXPR)`"),
    ("integral(x in a..b, EXPR)", "integral over a variable, worked out in symbols"),
    ("rows(TABLE)", "number of rows of a table"),
];

/// How a function is called, and what it gives.
///
/// ```
/// let (call, meaning) = librate::syntax::signature("ln").unwrap_or_default();
/// assert_eq!((call, meaning), ("ln(x)", "natural logarithm"));
/// ```
#[must_use]
pub fn signature(function: &str) -> Option<(&'static str, &'static str)> {
    SIGNATURES.into_iter().find(|(call, _)| name_in(call) == function)
}

/// The function that is meant by a name as other languages have it, `np.arctan`.
pub(crate) fn function_meant(word: &str) -> Option<&'static str> {
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

/// Functions of other languages that make a vector or a matrix of a list.
pub(super) fn is_list(word: &str) -> bool {
    matches!(word, "array" | "asarray" | "matrix" | "Matrix" | "Vector" | "vector")
}

/// Functions and fields of other languages that are the time derivative.
pub(crate) fn is_derivative(word: &str) -> bool {
    matches!(word, "dot" | "diff" | "D" | "d" | "dt" | "Dt" | "ddt" | "der" | "deriv" | "derivative")
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
    matches!(word, "constraint" | "assume" | "period" | "draw")
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

/// What a word of the language means; `None` where it is free for names.
///
/// ```
/// assert_eq!(librate::syntax::reserved_meaning("T"), Some("is the kinetic energy"));
/// ```
#[must_use]
pub fn reserved_meaning(word: &str) -> Option<&'static str> {
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

/// The statement word that `word` is another name of.
pub(super) fn synonym(word: &str) -> Option<&'static str> {
    match word {
        "parameter" | "parameters" | "params" | "const" | "constant" => Some("param"),
        "coordinate" | "coordinates" | "coords" | "dof" => Some("coord"),
        "def" | "define" => Some("let"),
        "kinetic" | "kinetic_energy" | "KE" | "Ekin" | "E_kin" | "Tkin" => Some("T"),
        "potential" | "potential_energy" | "PE" | "Epot" | "E_pot" => Some("V"),
        "constrain" => Some("constraint"),
        "assumption" | "assumptions" | "assuming" | "suppose" => Some("assume"),
        "equilibria" => Some("equilibrium"),
        _ => STATEMENT_WORDS.into_iter().find(|own| own.len() > 1 && own.eq_ignore_ascii_case(word)),
    }
}

/// The statement word that `word` may be another name of; it may be a quantity or mean something else as well.
pub(super) fn guessed(word: &str) -> Option<&'static str> {
    match word {
        "var" | "variable" | "set" | "par" => Some("param"),
        "generalized" | "q" => Some("coord"),
        "K" | "Ek" | "E_k" => Some("T"),
        "U" | "W" | "Ep" | "E_p" => Some("V"),
        "L" | "lagrange" | "lag" => Some("lagrangian"),
        "F" | "D" | "rayleigh" | "damping" | "friction" => Some("dissipation"),
        "Q" | "forcing" | "torque" | "moment" | "input" => Some("force"),
        "subject" | "restrict" => Some("constraint"),
        "given" => Some("assume"),
        "start" | "initial" | "init" => Some("guess"),
        "rest" | "eq" => Some("equilibrium"),
        "name" | "title" | "system" => Some("model"),
        "csv" | "data" | "load" | "import" | "include" => Some("table"),
        _ => None,
    }
}

/// Words of other languages that repeat or choose.
pub(super) fn is_control(word: &str) -> bool {
    matches!(word, "for" | "while" | "if" | "else" | "elif" | "then" | "when" | "end")
}
