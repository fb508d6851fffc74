//! A model as source code in C, Rust or Python.

use std::fmt::Write;

use super::json::string;
use librate_core::expr::Function;
use librate_core::worded;
use librate_studies::code::{Code, Matrix, Rest, Search};
use librate_studies::program::{Operation, Program};

worded! {
/// A programming language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
Language {
    /// C of 1999, and C++.
    C "c",
    /// Rust.
    Rust "rust",
    /// Python 3.
    Python "python",
}
/// What it is asked for by.
as_str
/// All of them.
ALL
}

/// What the accelerations are computed with.
const SOLVE_C: &str = include_str!("code/solve.c");

const SOLVE_RUST: &str = include_str!("code/solve.rust");

const SOLVE_PYTHON: &str = include_str!("code/solve.py");

/// Newton's method: COUNT coordinates, WHICH ones, where they START, and the BODY of forces and slopes.
const SEARCH_C: &str = include_str!("code/search.c");

const SEARCH_RUST: &str = include_str!("code/search.rust");

const SEARCH_PYTHON: &str = include_str!("code/search.py");

impl Language {
    fn applied(self, function: Function) -> String {
        let name = match (function, self) {
            (Function::Ln, Self::C | Self::Python) => "log",
            (Function::Abs, Self::C | Self::Python) => "fabs",
            (other, _) => other.name(),
        };
        self.called(name)
    }

    /// A function of the standard library.
    fn called(self, name: &str) -> String {
        match self {
            Self::C => name.to_owned(),
            Self::Rust => format!("f64::{name}"),
            Self::Python => format!("math.{name}"),
        }
    }

    fn number(self, value: f64) -> String {
        let word = |c, rust, python| match self {
            Self::C => c,
            Self::Rust => rust,
            Self::Python => python,
        };
        if value.is_nan() {
            word("NAN", "f64::NAN", "math.nan").to_owned()
        } else if value.is_infinite() {
            let sign = if value < 0.0 { "-" } else { "" };
            format!("({sign}{})", word("INFINITY", "f64::INFINITY", "math.inf"))
        } else if value < 0.0 {
            format!("({value:?})")
        } else {
            format!("{:?}", value + 0.0)
        }
    }

    /// A line that names a value.
    fn named(self, name: &str, value: &str) -> String {
        match self {
            Self::C => format!("    const double {name} = {value};\n"),
            Self::Rust => format!("    let {name} = {value};\n"),
            Self::Python => format!("    {name} = {value}\n"),
        }
    }

    /// A line that puts a value somewhere.
    fn put(self, place: &str, value: &str) -> String {
        let value = bare(value);
        let end = if self == Self::Python { "" } else { ";" };
        format!("    {place} = {value}{end}\n")
    }
}

/// A name of a file, which ends no comment.
fn in_comment(file: &str) -> String {
    file.replace("*/", "").chars().filter(|own| !own.is_control()).collect()
}

/// A negative number where nothing stands beside it.
fn bare(value: &str) -> &str {
    value.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).unwrap_or(value)
}

/// What a program computes, in lines, and the names of its results.
fn lines(language: Language, program: &Program, inputs: &[String]) -> (String, Vec<String>) {
    let first = program.constants.len();
    let operand = |at: u32| -> String {
        let at = at as usize;
        if at < first {
            language.number(program.constants[at].0)
        } else if at < first + program.inputs {
            inputs[at - first].clone()
        } else {
            format!("r{}", at - first - program.inputs)
        }
    };
    let mut out = String::new();
    for (at, operation) in program.operations.iter().enumerate() {
        let value = match *operation {
            Operation::Add(a, b) => format!("{} + {}", operand(a), operand(b)),
            Operation::Subtract(a, b) => format!("{} - {}", operand(a), operand(b)),
            Operation::Multiply(a, b) => format!("{}*{}", operand(a), operand(b)),
            Operation::Divide(a, b) => format!("{}/{}", operand(a), operand(b)),
            Operation::Negate(a) => format!("-{}", operand(a)),
            Operation::Root(a) => format!("{}({})", language.called("sqrt"), operand(a)),
            Operation::Power(a, b) => {
                let name = if language == Language::Rust { "powf" } else { "pow" };
                format!("{}({}, {})", language.called(name), operand(a), operand(b))
            }
            Operation::Angle { y, x } => format!("{}({}, {})", language.called("atan2"), operand(y), operand(x)),
            Operation::Apply(function, a) => format!("{}({})", language.applied(function), operand(a)),
            Operation::Undefined => language.number(f64::NAN),
        };
        out.push_str(&language.named(&format!("r{at}"), &value));
    }
    (out, program.outputs.iter().map(|output| operand(*output)).collect())
}

/// What a program computes of `q`, as the body of a function that browsers run: C but for the types.
pub(super) fn script(program: &Program) -> String {
    let inputs: Vec<String> = Writer::indexed("q", program.inputs).collect();
    let (lines, results) = lines(Language::C, program, &inputs);
    let lines = lines.replace("    const double ", "const ");
    format!(
        "const {{sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, sqrt, pow, abs: fabs}} = Math, NAN = NaN, \
         INFINITY = Infinity;\n{lines}return [{}];\n",
        results.join(", ")
    )
}

/// Source code with functions of doubles in SI: default parameters, the equilibrium and the matrices there, row by row, and the full
/// equations of motion, M q'' = f.
///
/// In C and Rust `LIBRATE_N`, `librate_defaults(p)`, `librate_equilibrium(p, q)`, `librate_mass(p, M)`, `librate_stiffness(p, K)` and,
/// where there is one, `librate_damping(p, C)`, `librate_gyroscopic(p, G)`, `librate_circulatory(p, N)`; `librate_mass_matrix(t, q, v, p, M)`,
/// `librate_forces(t, q, v, p, f)`, `librate_energy(t, q, v, p)` and `librate_acceleration(t, q, v, p, a)`. In Python the same without
/// `librate_` and the results, which are returned, and `PARAMETERS`. A model that contains the time has the functions of t alone.
/// A comment at the beginning names the `file` of the model.
#[must_use]
pub fn code_text(code: &Code, language: Language, file: Option<&str>) -> String {
    let writer = Writer { code, language, file };
    let mut out = writer.head();
    if let Some(rest) = &code.rest {
        out.push_str(&writer.equilibrium(rest));
        for Matrix { name, letter, entries, .. } in &rest.matrices {
            let text = writer.entries(letter, lines(writer.language, entries, &writer.still(rest)));
            out.push_str(&writer.function(rest, name, letter, &text));
        }
    }
    out.push_str(&writer.mass_matrix());
    out.push_str(&writer.forces());
    out.push_str(&writer.energy());
    out.push_str(&writer.acceleration());
    out
}

struct Writer<'a> {
    code: &'a Code,
    language: Language,
    /// What the model is made from.
    file: Option<&'a str>,
}

impl Writer<'_> {
    fn n(&self) -> usize {
        self.code.coordinates.len()
    }

    /// `p[0]`, `p[1]`, …
    fn indexed(name: &str, count: usize) -> impl Iterator<Item = String> {
        (0..count).map(move |at| format!("{name}[{at}]"))
    }

    /// The parameters, then the coordinates that are searched for.
    fn still(&self, rest: &Rest) -> Vec<String> {
        let free = rest.search.iter().flat_map(|search| &search.free);
        Self::indexed("p", self.code.parameters.len()).chain(free.map(|at| format!("q[{at}]"))).collect()
    }

    /// What the file is, its sizes, the default parameters, and how equations are solved.
    fn head(&self) -> String {
        let (n, parameters) = (self.n(), &self.code.parameters);
        let mut about = vec![format!(
            "{}: M q'' + h(q, q', t) = 0, written by librate {}{}. All numbers are in SI.",
            self.code.model.as_deref().unwrap_or("model"),
            env!("CARGO_PKG_VERSION"),
            self.file.map_or_else(String::new, |file| format!(" from {}", in_comment(file)))
        )];
        if self.code.rest.is_none() {
            about.push("The time occurs in the model: it has no mass and stiffness at an equilibrium.".to_owned());
        }
        about.extend(parameters.iter().enumerate().map(|(at, (name, _))| format!("p[{at}] is {name}")));
        about.extend(self.code.coordinates.iter().enumerate().map(|(at, name)| format!("q[{at}] is {name}")));
        let comment = |mark: &str| about.iter().map(|line| format!("{mark} {line}\n")).collect::<String>();
        let default = |value: &Option<f64>| self.language.number(value.unwrap_or(f64::NAN));
        let defaults = parameters.iter().enumerate();
        let defaults = defaults.map(|(at, (_, value))| self.language.put(&format!("p[{at}]"), &default(value)));
        let defaults: String = defaults.collect();
        let count = parameters.len();
        match self.language {
            Language::C => format!(
                "/*\n{}*/\n#include <math.h>\n\n#define LIBRATE_N {n}\n#define LIBRATE_PARAMETERS {count}\n\n\
                 void librate_defaults(double *p) {{\n    (void)p;\n{defaults}}}\n{SOLVE_C}",
                comment("")
            ),
            Language::Rust => format!(
                "{}\npub const LIBRATE_N: usize = {n};\npub const LIBRATE_PARAMETERS: usize = {count};\n\n\
                 pub fn librate_defaults(p: &mut [f64]) {{\n    let _ = &p;\n{defaults}}}\n{SOLVE_RUST}",
                comment("//")
            ),
            Language::Python => {
                let defaults =
                    parameters.iter().map(|(name, value)| format!("    {}: {},\n", string(name), default(value)));
                let names = self.code.coordinates.iter().map(|name| string(name));
                format!(
                    "{}import math\n\nN = {n}\nPARAMETERS = {{\n{}}}\nCOORDINATES = [{}]\n{SOLVE_PYTHON}",
                    comment("#"),
                    defaults.collect::<String>(),
                    names.collect::<Vec<_>>().join(", ")
                )
            }
        }
    }

    /// A function of the parameters, whose lines may use the equilibrium.
    fn function(&self, rest: &Rest, name: &str, result: &str, lines: &str) -> String {
        let searched = rest.search.is_some() && name != "equilibrium";
        let search = match self.language {
            Language::C => "    double q[LIBRATE_N];\n    librate_equilibrium(p, q);\n",
            Language::Rust => "    let mut q = [0.0_f64; LIBRATE_N];\n    librate_equilibrium(p, &mut q);\n",
            Language::Python => "    q = equilibrium(p)\n",
        };
        let search = if searched { search } else { "" };
        self.defined(name, false, result, &format!("{search}{lines}"))
    }

    /// A function of the parameters, or of the motion too; without a name for the result it is a number.
    fn defined(&self, name: &str, moves: bool, result: &str, text: &str) -> String {
        let is_number = result.is_empty();
        let either = |moving: &'static str, still: &'static str| if moves { moving } else { still };
        match self.language {
            Language::C => {
                let inputs = either("double t, const double *q, const double *v, const double *p", "const double *p");
                let unused = either("(void)t; (void)q; (void)v; (void)p;", "(void)p;");
                let (kind, result) =
                    if is_number { ("double", String::new()) } else { ("void", format!(", double *{result}")) };
                format!("\n{kind} librate_{name}({inputs}{result}) {{\n    {unused}\n{text}}}\n")
            }
            Language::Rust => {
                let inputs = either("t: f64, q: &[f64], v: &[f64], p: &[f64]", "p: &[f64]");
                let unused = either("(t, q, v, p)", "p");
                let (result, kind) = if is_number {
                    (String::new(), " -> f64")
                } else {
                    (format!(", {}: &mut [f64]", result.to_lowercase()), "")
                };
                format!("\npub fn librate_{name}({inputs}{result}){kind} {{\n    let _ = {unused};\n{text}}}\n")
            }
            Language::Python => {
                let inputs = either("t, q, v, p", "p");
                format!("\n\ndef {name}({inputs}):\n    p = _values(p)\n{text}")
            }
        }
    }

    /// Lines that leave a matrix in what has this name, or return it.
    fn entries(&self, name: &str, (mut text, results): (String, Vec<String>)) -> String {
        if self.language == Language::Python {
            let rows = results.chunks(self.n().max(1)).map(|row| format!("        [{}],\n", row.join(", ")));
            let _ = write!(text, "    return [\n{}    ]\n", rows.collect::<String>());
        } else {
            text.push_str(&self.puts(name, &results));
        }
        text
    }

    fn puts(&self, name: &str, values: &[String]) -> String {
        let name = if self.language == Language::Rust { name.to_lowercase() } else { name.to_owned() };
        let line = |(at, value): (usize, &String)| self.language.put(&format!("{name}[{at}]"), value);
        values.iter().enumerate().map(line).collect()
    }

    fn equilibrium(&self, rest: &Rest) -> String {
        let language = self.language;
        let mut text = String::new();
        if language == Language::Python {
            let _ = writeln!(text, "    q = [0.0]*N");
        }
        if let Some(search) = &rest.search {
            text.push_str(&self.search(rest, search));
        }
        let (own, results) = lines(language, &rest.equilibrium, &self.still(rest));
        text.push_str(&own);
        let given = results.iter().enumerate().filter(|(at, value)| **value != format!("q[{at}]"));
        text.extend(given.map(|(at, value)| language.put(&format!("q[{at}]"), value)));
        if language == Language::Python {
            text.push_str("    return q\n");
        }
        self.function(rest, "equilibrium", "q", &text)
    }

    /// Newton's method for the coordinates that are not given; these are no numbers where it does not converge.
    fn search(&self, rest: &Rest, search: &Search) -> String {
        let language = self.language;
        let count = search.free.len();
        let (own, results) = lines(language, &search.step, &self.still(rest));
        let (forces, slopes) = results.split_at(count);
        let listed = |items: Vec<String>| items.join(", ");
        let which = listed(search.free.iter().map(usize::to_string).collect());
        let start = listed(search.start.iter().map(|value| language.number(*value)).collect());
        let mut body = own;
        if language == Language::Python {
            let rows: Vec<String> = slopes.chunks(count).map(|row| format!("[{}]", row.join(", "))).collect();
            let _ = writeln!(body, "    f = _solve([{}], [{}])", rows.join(", "), forces.join(", "));
        } else {
            body.push_str(&self.puts("f", forces));
            body.push_str(&self.puts("h", slopes));
        }
        let body: String = body.lines().map(|line| format!("    {line}\n")).collect();
        let template = match language {
            Language::C => SEARCH_C,
            Language::Rust => SEARCH_RUST,
            Language::Python => SEARCH_PYTHON,
        };
        let text = template.replace("COUNT", &count.to_string()).replace("WHICH", &which);
        text.replace("START", &start).replace("        BODY\n", &body)
    }

    /// What a program of the motion computes.
    fn moving(&self, program: &Program) -> (String, Vec<String>) {
        let inputs = ["q", "v"].into_iter().flat_map(|name| Self::indexed(name, self.n()));
        let parameters = Self::indexed("p", self.code.parameters.len());
        let inputs: Vec<String> = ["t".to_owned()].into_iter().chain(inputs).chain(parameters).collect();
        lines(self.language, program, &inputs)
    }

    fn mass_matrix(&self) -> String {
        self.defined("mass_matrix", true, "M", &self.entries("M", self.moving(&self.code.mass)))
    }

    fn forces(&self) -> String {
        let (mut text, results) = self.moving(&self.code.forces);
        text.push_str(&match self.language {
            Language::Python => format!("    return [{}]\n", results.join(", ")),
            Language::C | Language::Rust => self.puts("f", &results),
        });
        self.defined("forces", true, "f", &text)
    }

    fn energy(&self) -> String {
        let (mut text, results) = self.moving(&self.code.energy);
        let energy = results.concat();
        let energy = bare(&energy);
        text.push_str(&match self.language {
            Language::Rust => format!("    {energy}\n"),
            Language::C => format!("    return {energy};\n"),
            Language::Python => format!("    return {energy}\n"),
        });
        self.defined("energy", true, "", &text)
    }

    fn acceleration(&self) -> String {
        let n = self.n();
        let (text, results) = self.moving(&self.code.motion);
        let (mass, loads) = results.split_at(n * n);
        let loads: Vec<String> = loads.iter().map(|load| format!("-{load}")).collect();
        let solved = |declared: &str, call: &str| {
            let (mass, loads) = (self.puts("m", mass), self.puts("a", &loads));
            format!("    {declared};\n{text}{mass}{loads}    {call};\n")
        };
        let text = match self.language {
            Language::C => solved("double m[LIBRATE_N*LIBRATE_N]", "librate_solve(LIBRATE_N, m, a)"),
            Language::Rust => {
                solved("let mut m = [0.0_f64; LIBRATE_N*LIBRATE_N]", "librate_solve(LIBRATE_N, &mut m, a)")
            }
            Language::Python => {
                let rows = mass.chunks(n.max(1)).map(|row| format!("        [{}],\n", row.join(", ")));
                format!("{text}    return _solve([\n{}    ], [{}])\n", rows.collect::<String>(), loads.join(", "))
            }
        };
        self.defined("acceleration", true, "a", &text)
    }
}
