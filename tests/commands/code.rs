//! Source code of models, compiled and run: against the matrices of the library, and its own accelerations against these.
#![cfg(feature = "cli")]

use crate::cli_support;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cli_support::*;
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::precision::Ball;

const MODELS: [&str; 12] = [
    "ziegler_column",
    "controlled_pendulum",
    "three_pendulums",
    "double_pendulum",
    "elastic_pendulum",
    "bead_on_hoop_fast",
    "penning_trap",
    "damped_pair",
    "whirling_shaft_above",
    "conical_pendulum",
    "fput_chain",
    "co2",
];

/// Reads parameters, and how many states follow; prints the equilibrium, the matrices there, and for each state accelerations, M, forces
/// and the energy.
const MAIN_C: &str = "
#include <stdio.h>
#include \"model.c\"
static void get(double *x, int n) { int i; for (i = 0; i < n; i++) if (scanf(\"%lf\", &x[i]) != 1) x[i] = NAN; }
static void put(const double *x, int n) { int i; for (i = 0; i < n; i++) printf(\"%.17g\\n\", x[i]); }
int main(void) {
    double p[LIBRATE_PARAMETERS + 1], q[LIBRATE_N], v[LIBRATE_N], a[LIBRATE_N], m[LIBRATE_N*LIBRATE_N], count;
    librate_defaults(p); put(p, LIBRATE_PARAMETERS);
    get(p, LIBRATE_PARAMETERS); get(&count, 1);
    librate_equilibrium(p, q); put(q, LIBRATE_N);
    MATRIX librate_NAME(p, m); put(m, LIBRATE_N*LIBRATE_N);
    for (; count > 0; count--) {
        get(q, LIBRATE_N); get(v, LIBRATE_N);
        librate_acceleration(0.0, q, v, p, a); put(a, LIBRATE_N);
        librate_mass_matrix(0.0, q, v, p, m); put(m, LIBRATE_N*LIBRATE_N);
        librate_forces(0.0, q, v, p, a); put(a, LIBRATE_N);
        a[0] = librate_energy(0.0, q, v, p); put(a, 1);
    }
    return 0;
}
";

const MAIN_RUST: &str = "
#[allow(dead_code)]
mod model;
use model::*;
fn main() {
    let text = std::io::read_to_string(std::io::stdin()).unwrap();
    let mut words = text.split_whitespace().map(|word| word.parse::<f64>().unwrap());
    let mut get = |n: usize| -> Vec<f64> { words.by_ref().take(n).collect() };
    let put = |x: &[f64]| x.iter().for_each(|x| println!(\"{x:?}\"));
    let mut p = [0.0; LIBRATE_PARAMETERS];
    librate_defaults(&mut p);
    put(&p);
    let p = get(LIBRATE_PARAMETERS);
    let count = get(1)[0] as usize;
    let mut q = [0.0; LIBRATE_N];
    let mut m = [0.0; LIBRATE_N * LIBRATE_N];
    librate_equilibrium(&p, &mut q);
    put(&q);
    MATRIX librate_NAME(&p, &mut m); put(&m);
    for _ in 0..count {
        let (q, v) = (get(LIBRATE_N), get(LIBRATE_N));
        let mut a = [0.0; LIBRATE_N];
        librate_acceleration(0.0, &q, &v, &p, &mut a);
        put(&a);
        librate_mass_matrix(0.0, &q, &v, &p, &mut m);
        put(&m);
        librate_forces(0.0, &q, &v, &p, &mut a);
        put(&a);
        put(&[librate_energy(0.0, &q, &v, &p)]);
    }
}
";

const MAIN_PYTHON: &str = "
import sys
from model import *
words = iter(map(float, sys.stdin.read().split()))
get = lambda n: [next(words) for _ in range(n)]
put = lambda x: [print(repr(float(own))) for own in x]
put(PARAMETERS.values())
p = dict(zip(PARAMETERS, get(len(PARAMETERS))))
count = int(get(1)[0])
put(equilibrium(p))
MATRIX put(sum(NAME(list(p.values())), []))
for _ in range(count):
    q, v = get(N), get(N)
    put(acceleration(0.0, q, v, p))
    put(sum(mass_matrix(0.0, q, v, p), []))
    put(forces(0.0, q, v, p))
    put([energy(0.0, q, v, p)])
";

/// The code of a model in a folder, and how it is run; `None` where that is not installed.
fn built(model: &Path, language: &str, matrices: &[&str]) -> Option<Command> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("code").join(model.file_stem().unwrap()).join(language);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let (end, main) = match language {
        "c" => ("c", MAIN_C),
        "rust" => ("rs", MAIN_RUST),
        _ => ("py", MAIN_PYTHON),
    };
    let file = folder.join(format!("model.{end}"));
    assert_eq!(printed(&["export", model.to_str()?, "--code", language, "-o", file.to_str()?]), "");
    // A line for each of the matrices that there are.
    let main: String = main
        .lines()
        .flat_map(|line| match line.split_once("MATRIX ") {
            Some((_, own)) => matrices.iter().map(|name| own.replace("NAME", name) + "\n").collect(),
            None => vec![format!("{line}\n")],
        })
        .collect();
    fs::write(folder.join(format!("main.{end}")), main).unwrap();
    let mut build = match language {
        "c" => Command::new("cc"),
        "rust" => Command::new("rustc"),
        _ => {
            let mut run = Command::new("python3");
            run.current_dir(&folder).arg("main.py");
            return run_succeeds(Command::new("python3").arg("--version")).then_some(run);
        }
    };
    if !run_succeeds(Command::new(build.get_program()).arg("--version")) {
        return None;
    }
    build.current_dir(&folder);
    match language {
        "c" => build.args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "main.c", "-o", "main", "-lm"]),
        _ => build.args(["--edition=2021", "-Dwarnings", "main.rs", "-o", "main"]),
    };
    let done = build.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    Some(Command::new(folder.join("main")))
}

fn run_succeeds(command: &mut Command) -> bool {
    command.output().is_ok_and(|run| run.status.success())
}

fn numbers(mut command: Command, input: &[f64]) -> Vec<f64> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let text: String = input.iter().map(|x| format!("{x:?}\n")).collect();
    child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    let done = child.wait_with_output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect()
}

fn linearized(path: &Path, settings: &Settings) -> Linearized {
    let file = librate::syntax::parse(&fs::read_to_string(path).unwrap()).unwrap();
    linearize(elaborate(&file, &TableTexts::new(), settings).unwrap()).unwrap()
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1e-300_f64, |most, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= tolerance * scale, "{what}: {found} instead of {expected}");
    }
}

#[allow(clippy::print_stderr, reason = "says what is skipped")]
fn check(path: &Path, language: &str) {
    let what = format!("{} in {language}", path.display());
    // Other parameters than the defaults, where these have a name in the file.
    let probe = fs::read_to_string(path).unwrap();
    let file = librate::syntax::parse(&probe).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let code = librate::code::code(&model).unwrap();
    let names: Vec<&str> = code.rest.as_ref().unwrap().matrices.iter().map(|own| own.name).collect();
    let Some(command) = built(path, language, &names) else {
        eprintln!("skipped: nothing that runs {language} is installed");
        return;
    };
    let mut settings = Settings::new();
    let mut p = Vec::new();
    for (at, (name, value)) in code.parameters.iter().enumerate() {
        let scale = if model.has_units { 1.0 } else { 1.0 + 0.01 * (at % 3) as f64 };
        p.push(value.unwrap() * scale);
        if scale != 1.0 {
            settings.add(&format!("{name} = {:?}", p[at])).unwrap();
        }
    }
    let own = linearized(path, &settings);
    let n = own.coordinates();
    let doubles = |entries: Vec<Ball>| -> Vec<f64> { entries.iter().map(Ball::mid_f64).collect() };
    let transposed = |m: Vec<f64>| -> Vec<f64> { (0..n * n).map(|at| m[at / n + n * (at % n)]).collect() };
    let q: Vec<f64> = doubles(own.equilibrium().values.clone());
    let v = doubles(own.rates());
    let (mass, stiffness) = (transposed(doubles(own.mass())), transposed(doubles(own.stiffness())));
    let (velocity, force) = own.velocity_and_stiffness();
    // The equilibrium, then a step to either side of each coordinate and each velocity.
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let length = Some(largest(&q)).filter(|most| *most > 0.0).unwrap_or(1.0);
    let rate = (largest(&stiffness) / largest(&mass)).sqrt().max(1.0);
    let step = |at: usize| 1e-5 * length * if at < n { 1.0 } else { rate };
    let mut states = vec![(q.clone(), v.clone())];
    for at in 0..2 * n {
        for side in [step(at), -step(at)] {
            let (mut q, mut v) = (q.clone(), v.clone());
            *if at < n { &mut q[at] } else { &mut v[at - n] } += side;
            states.push((q, v));
        }
    }
    // Energies bend less than forces: a longer step.
    for at in 0..2 * n {
        for side in [100.0 * step(at), -100.0 * step(at)] {
            let (mut q, mut v) = (q.clone(), v.clone());
            *if at < n { &mut q[at] } else { &mut v[at - n] } += side;
            states.push((q, v));
        }
    }
    let mut input = p.clone();
    input.push(states.len() as f64);
    input.extend(states.iter().flat_map(|(q, v)| q.iter().chain(v)));
    let out = numbers(command, &input);
    let (defaults, out) = out.split_at(p.len());
    let values: Vec<f64> = code.parameters.iter().map(|(_, value)| value.unwrap()).collect();
    assert_eq!(defaults, values, "{what}");
    let (found, out) = out.split_at(n);
    assert_near(found, &q, 1e-12, &format!("{what}, equilibrium"));
    let others = [own.damping(), own.gyroscopic(), own.circulatory()];
    let all = [Some(mass.clone()), Some(stiffness.clone())].into_iter();
    let all: Vec<Vec<f64>> = all.chain(others.map(|own| own.map(|own| transposed(doubles(own))))).flatten().collect();
    assert_eq!(all.len(), names.len(), "{what}: {names:?}");
    let (matrices, out) = out.split_at(all.len() * n * n);
    for ((found, expected), name) in matrices.chunks(n * n).zip(&all).zip(&names) {
        assert_near(found, expected, 1e-11, &format!("{what}, {name}"));
    }
    let found: Vec<&[f64]> = out.chunks(n * n + 2 * n + 1).collect();
    assert_eq!(found.len(), states.len());
    let accelerations: Vec<&[f64]> = found.iter().map(|own| &own[..n]).collect();
    let energies: Vec<f64> = found.iter().map(|own| own[n * n + 2 * n]).collect();
    // M q'' = f.
    for own in &found {
        let (acceleration, rest) = own.split_at(n);
        let image: Vec<f64> = (0..n).map(|i| (0..n).map(|j| rest[n * i + j] * acceleration[j]).sum()).collect();
        let scale = largest(&rest[..n * n]) * largest(acceleration);
        for (image, force) in image.iter().zip(&rest[n * n..]) {
            assert!((image - force).abs() <= 1e-11 * scale, "{what}: {image} instead of {force}");
        }
    }
    assert_near(&found[0][n..n + n * n], &mass, 1e-11, &format!("{what}, M(q)"));
    // At rest the energy bends as M and K do.
    let is_conservative = own.circulatory().is_none() && model.forces.iter().all(|own| own.acts_on.is_none());
    for at in (0..2 * n).filter(|at| *at >= n || largest(&v) == 0.0 && is_conservative) {
        let [up, down] = [0, 1].map(|side| energies[1 + 4 * n + 2 * at + side]);
        let bent = (up - 2.0 * energies[0] + down) / (100.0 * step(at)).powi(2);
        let (matrix, i) = if at < n { (&stiffness, at) } else { (&mass, at - n) };
        assert!((bent - matrix[n * i + i]).abs() <= 1e-4 * largest(matrix), "{what}, energy by {at}: {bent}");
    }
    assert!(largest(accelerations[0]) <= 1e-11 * length * rate.powi(2), "{what} {:?}", accelerations[0]);
    // M da/dq = -(K + N), M da/dq' = -(G + C).
    for at in 0..2 * n {
        let [up, down] = [1, 2].map(|side| accelerations[2 * at + side]);
        let slope: Vec<f64> = up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * step(at))).collect();
        let image: Vec<f64> = (0..n).map(|i| (0..n).map(|j| mass[n * i + j] * slope[j]).sum()).collect();
        let all = doubles(if at < n { force.clone() } else { velocity.clone() });
        let column: Vec<f64> = (0..n).map(|i| -all[i + n * (at % n)]).collect();
        let scale = largest(&all).max(1e-3 * largest(&mass) * rate * if at < n { rate } else { 1.0 });
        for (image, column) in image.iter().zip(&column) {
            assert!((image - column).abs() < 1e-6 * scale, "{what}, column {at}: {image} instead of {column}");
        }
    }
}

#[test]
fn code_computes_what_the_library_does() {
    for model in MODELS {
        let path = PathBuf::from(format!("models/{model}.lag"));
        for language in ["c", "rust", "python"] {
            check(&path, language);
        }
    }
}

/// Every function of the language, a power with a parameter, a point that is searched for from a guess.
#[test]
fn code_has_every_function() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("code");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("every.lag");
    let text = "param a = 3/10  param n = 3  param big = 2*a
        coord x, y
        T = 1/2*(2 + sin(x)*cos(y) + tan(a)^2)*x'^2 + 1/2*exp(a*y)*y'^2 + 1/10*x'*y'
        V = 1/2*x^2*(2 + atan(y)) + cosh(x - 1) + sinh(a)*y + y^2 + 1/10*asin(a)*x + acos(a)*y^2 + tanh(y)*a + ln(2 + y)
          + abs(3 + x)*a + sqrt(2 + x*y) + 1/100*(y + 2)^n + big*atan2(y, 2 + x) + 1/(4 + x)^2
        guess x = 1/10
        guess y = -1/10";
    fs::write(&path, text).unwrap();
    for language in ["c", "rust", "python"] {
        check(&path, language);
    }
}

/// Where nothing holds a motion the equilibrium is searched for across it.
#[test]
fn free_bodies_are_searched_for_across_their_motion() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("code");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("free.lag");
    let text = "param s = 1/10  coord x[1..2]  T = 1/2*dot(x', x')
        V = (1 - exp(-(x[2] - x[1] - 1)))^2 - s*(x[2] - x[1])
        guess x[2] = 1";
    fs::write(&path, text).unwrap();
    for language in ["c", "rust", "python"] {
        check(&path, language);
    }
}

/// Beside 0 steps are as long as the place itself.
#[test]
fn equilibria_at_zero_are_found() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("code");
    fs::create_dir_all(&folder).unwrap();
    for (name, text) in [
        (
            "zero.lag",
            "param a = 0.1  param c = 0.2  param b = 0.3
             coord x  T = 1/2*x'^2  V = 1/2*(x + a + c - b)^2 + 1/4*(x + a + c - b)^4
             guess x = 0.1",
        ),
        // Steps towards it shrink by a third only, for long.
        ("slow.lag", "param F = 1e-30  coord y  T = 1/2*y'^2  V = 1/4*y^4 + 1/6*y^6 - F*y  guess y = 1"),
    ] {
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        for language in ["c", "rust", "python"] {
            check(&path, language);
        }
    }
}

/// A model that contains the time has no equilibrium, but a motion.
#[test]
fn driven_models_have_the_code_of_their_motion() {
    let text = "param F = 2  param W = 3  coord x  T = 1/2*x'^2  V = 1/2*x^2 - F*x*cos(W*t)";
    for (language, absent) in [("c", "librate_equilibrium"), ("rust", "librate_equilibrium"), ("python", "def mass(")] {
        let code = with_input(&["export", "-", "--code", language], text);
        let about = format!("written by librate {}. All", env!("CARGO_PKG_VERSION"));
        assert!(code.out.lines().nth(usize::from(language == "c")).is_some_and(|line| line.contains(&about)));
        assert!(code.status == 0 && !code.out.contains(absent), "{}", code.err);
    }
    let code = with_input(&["export", "-", "--code", "python"], text).out;
    let ask = "t, q, v, p = 0.5, [0.1], [0.2], PARAMETERS\nprint(acceleration(t, q, v, p)[0], forces(t, q, v, p)[0], energy(t, q, v, p), mass_matrix(t, q, v, p)[0][0])";
    let Ok(run) = Command::new("python3").arg("-c").arg(code + ask).output() else { return };
    let found: Vec<f64> =
        String::from_utf8(run.stdout).unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect();
    let force = -0.1 + 2.0 * 1.5_f64.cos();
    assert_near(&found, &[force, force, 0.02 + 0.005 - 0.2 * 1.5_f64.cos(), 1.0], 1e-15, "driven");
}

#[test]
fn what_has_no_code_is_refused() {
    for (model, code) in [("models/pendulum_in_x_and_y.lag", "E0308"), ("models/heavy_roller_on_incline.lag", "E03")] {
        let run = run(&["export", model, "--code", "c"]);
        assert_eq!((run.status, run.out.as_str()), (1, ""), "{model}");
        assert!(run.err.contains(code), "{}", run.err);
    }
    // No row of M vanishes, but M is singular.
    let singular = with_input(&["export", "-", "--code", "c"], "coord x, y  T = (x' + y')^2  V = x^2 + (y - 1)^2");
    assert!(singular.status == 1 && singular.err.contains("E0308"), "{}", singular.err);
    let named = printed(&["export", PENDULUMS, "--code", "python"]);
    assert!(named.contains(" from three_pendulums.lag. All") && !named.contains("1.0*"), "{named}");
    let large = run(&["export", "models/chain_walls.lag", "--set", "N=201", "--code", "python"]);
    assert!(large.status == 1 && large.err.contains("201 coordinates"), "{}", large.err);
    assert!(large.err.contains("`librate export --matrix-market`") && !large.err.contains("--lowest"), "{}", large.err);
    assert_eq!(run(&["export", PENDULUMS, "--code", "fortran"]).status, 2);
    assert_eq!(run(&["export", PENDULUMS, "--code", "c", "--npz"]).status, 2);
    // To standard output without a file, and a parameter without a value is no number.
    let open = with_input(&["export", "-", "--code", "python"], "param k  coord x  T = x'^2/2  V = k*x^2/2");
    assert!(
        open.status == 0 && open.out.contains("\"k\": math.nan") && open.out.contains("def mass(p):"),
        "{}",
        open.err
    );
    for (value, told) in [("1.7e308", "\"k\": 1.7e308"), ("2e308", "beyond the range of doubles")] {
        let model = format!("param k = {value}  coord x  T = x'^2/2  V = k*x^2/2");
        let far = with_input(&["export", "-", "--code", "python"], &model);
        assert!((far.out + &far.err).contains(told), "{value}");
    }
}
