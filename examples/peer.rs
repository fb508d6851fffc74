//! One benchmark problem, timed stage by stage, as JSON lines: the counterpart of the symbolic
//! tools that librate is measured against.
//!
//! ```text
//! cargo run --release --example peer -- --model B --n 10 [--warm] [--print] [--only STAGE]
//! ```
//!
//! The problems: `A`, three pendulums joined by springs; `B`, a pendulum of n links, written with
//! Cartesian positions that build on one another; `C`, the Fermi–Pasta–Ulam–Tsingou chain between
//! walls; `D`, a square net of n by n masses under tension; `E`, a network of n random points or of
//! those of a table (`--points FILE`, columns x, y, z), spring beside spring up to a distance of 1.93.
//! Of large problems the lowest frequencies are computed, from sparse matrices.
//!
//! Keys, times in seconds: `parse_s`, `elaborate_s`, `linearize_s`, their sum with the first M and
//! K, `build_s` (from text to M and K with bounds), `eval1_s` (M and K once more), `eig_s`; all of
//! one cold pass. With `--warm` the medians of repeats follow, wall time (`build_warm_s`) and CPU
//! time (`build_warm_cpu_s`). `freq` holds the frequencies as decimals, every digit certified,
//! `omega` the centre of each as two doubles and the bound of its error.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::{Duration, Instant};

#[path = "speed_and_error/clock.rs"]
#[allow(dead_code, reason = "other examples use more of it")]
mod clock;
#[path = "points.rs"]
#[allow(dead_code, reason = "an example of its own")]
mod points;
#[allow(dead_code, reason = "other examples use more of it")]
#[path = "speed_and_error/problems.rs"]
mod problems;

use clock::{Clock, repeat};
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::precision::decimal;
use librate::syntax::parse;
use problems::{LINKS, PENDULUMS};

/// Digits of the printed frequencies; fewer where the bound decides fewer.
const DIGITS: usize = 25;

/// Matrices of more coordinates are sparse.
const MOST_DENSE: usize = 300;

const CHAIN: &str = "
param m = 1
param k = 1
param beta = 0.3
coord x[1..N]
let u[0] = 0
let u[i in 1..N] = x[i]
let u[N+1] = 0
let s[i in 0..N] = u[i+1] - u[i]
T = sum(i in 1..N, 1/2*m*x[i]'^2)
V = sum(i in 0..N, 1/2*k*s[i]^2 + 1/4*beta*s[i]^4)
";

const NET: &str = "
param k = 1
param m = 1
param a = 0.8
coord u[1..N, 1..N], v[1..N, 1..N]
let p[i in 1..N, j in 1..N] = [i + u[i,j], j + v[i,j]]
T = sum(i in 1..N, j in 1..N, 1/2*m*(u[i,j]'^2 + v[i,j]'^2))
V = sum(i in 1..N-1, j in 1..N, 1/2*k*(norm(p[i+1,j] - p[i,j]) - a)^2)
  + sum(i in 1..N, j in 1..N-1, 1/2*k*(norm(p[i,j+1] - p[i,j]) - a)^2)
  + sum(j in 1..N, 1/2*k*(norm(p[1,j] - [0, j]) - a)^2 + 1/2*k*(norm([N + 1, j] - p[N,j]) - a)^2)
  + sum(i in 1..N, 1/2*k*(norm(p[i,1] - [i, 0]) - a)^2 + 1/2*k*(norm([i, N + 1] - p[i,N]) - a)^2)
";

const POINTS: &str = "
table points = \"points.csv\"
param m = 1
param k = 1
coord r[1..rows(points), 1..3]
let rest[a in points] = [a.x, a.y, a.z]
T = sum(a in points, 1/2*m*dot(r[a]', r[a]'))
V = sum(a in points, b in points where a < b and (a.x - b.x)^2 + (a.y - b.y)^2 + (a.z - b.z)^2 <= 1.93^2,
        1/2*k*(norm(r[b] - r[a]) - norm(rest[b] - rest[a]))^2)
equilibrium r[a in points] = [a.x, a.y, a.z]
";

struct Request {
    model: String,
    n: usize,
    warm: bool,
    print: bool,
    only: Option<String>,
    points: Option<String>,
}

fn request() -> Result<Request, Box<dyn Error>> {
    let mut request = Request { model: "A".to_owned(), n: 3, warm: false, print: false, only: None, points: None };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--model" => request.model = value()?,
            "--n" => request.n = value()?.parse()?,
            "--points" => request.points = Some(value()?),
            "--only" => request.only = Some(value()?),
            "--warm" => request.warm = true,
            "--print" => request.print = true,
            _ => return Err(format!("unknown argument {argument}").into()),
        }
    }
    Ok(request)
}

/// The model as text, and how many frequencies are asked for.
fn problem(model: &str, n: usize) -> Result<(String, Option<usize>), Box<dyn Error>> {
    let (text, lowest) = match model {
        "A" => (PENDULUMS, None),
        "B" => (LINKS, None),
        "C" => (CHAIN, (n > 2000).then_some(10)),
        "D" => (NET, Some(10)),
        "E" => (POINTS, (n > 100).then_some(20)),
        _ => return Err(format!("there is no problem {model}").into()),
    };
    let head = match model {
        "A" => "model three_pendulums".to_owned(),
        "E" => String::new(),
        _ => format!("param N = {n}"),
    };
    Ok((head + text, lowest))
}

/// M and K: of few coordinates dense, of many sparse.
fn matrices(linear: &Linearized) -> impl PartialEq + use<> {
    let is_large = linear.dimension() > MOST_DENSE;
    let dense = (!is_large).then(|| (linear.mass(), linear.stiffness()));
    (dense, is_large.then(|| linear.sparse()))
}

/// From text to a linearization, with the times of the three stages.
fn linearized(text: &str, tables: &TableTexts, mut lap: impl FnMut(&str)) -> Result<Linearized, Box<dyn Error>> {
    let file = parse(text).map_err(|errors| errors[0].clone())?;
    lap("parse");
    let model = elaborate(&file, tables, &Settings::new()).map_err(|errors| errors[0].clone())?;
    lap("elaborate");
    let linearized = linearize(model)?;
    lap("linearize");
    Ok(linearized)
}

/// One stage over and over, for three seconds.
fn for_a_profile(stage: &str, text: &str, tables: &TableTexts, options: &Options) -> Result<(), Box<dyn Error>> {
    let linear = linearized(text, tables, |_| {})?;
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(3) {
        match stage {
            "build" => drop(linearized(text, tables, |_| {})?),
            "eval" => drop(matrices(&linear)),
            _ => drop(normal_modes(&linear, options)?),
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let request = request()?;
    let (text, lowest) = problem(&request.model, request.n)?;
    let mut out = String::new();
    let mut stdout = std::io::stdout().lock();
    if request.print {
        stdout.write_all(text.as_bytes())?;
        return Ok(());
    }
    let mut tables = TableTexts::new();
    if request.model == "E" {
        let table = match request.points {
            Some(path) => std::fs::read_to_string(path)?,
            None => points::table(u32::try_from(request.n)?),
        };
        tables = tables.with("points.csv".to_owned(), table);
    }
    let mut options = Options::default();
    options.lowest = lowest;

    if let Some(stage) = request.only {
        return for_a_profile(&stage, &text, &tables, &options);
    }

    let mut put = |key: &str, time: (f64, f64)| {
        // Writing to a string does not fail.
        let _ = writeln!(out, "{{\"{key}_s\": {:e}, \"{key}_cpu_s\": {:e}}}", time.0, time.1);
    };
    let mut whole = Clock::start();
    let mut clock = Clock::start();
    let linear = linearized(&text, &tables, |stage| put(stage, clock.lap()))?;
    let first = matrices(&linear);
    put("build", whole.lap());
    clock = Clock::start();
    let again = matrices(&linear);
    put("eval1", clock.lap());
    if first != again {
        return Err("M and K differ from one evaluation to the next".into());
    }
    clock = Clock::start();
    let normal = normal_modes(&linear, &options)?;
    put("eig", clock.lap());

    if request.warm {
        put("build_warm", repeat(|| Ok(matrices(&linearized(&text, &tables, |_| {})?)))?);
        put("eval_warm", repeat(|| Ok(matrices(&linear)))?);
        put("eig_warm", repeat(|| Ok(normal_modes(&linear, &options)?))?);
        put("whole_warm", repeat(|| Ok(normal_modes(&linearized(&text, &tables, |_| {})?, &options)?))?);
    }

    let mut oscillating: Vec<_> = normal.modes.iter().collect();
    oscillating.sort_by(|a, b| a.omega.mid_f64().total_cmp(&b.omega.mid_f64()));
    let frequencies: Vec<String> =
        oscillating.iter().map(|mode| format!("\"{}\"", decimal(&mode.omega, DIGITS).text)).collect();
    let centres: Vec<String> = oscillating
        .iter()
        .map(|mode| {
            let omega = &mode.omega;
            format!("[{:e}, {:e}, {:e}]", omega.mid.hi, omega.mid.lo, omega.radius)
        })
        .collect();
    writeln!(out, "{{\"freq\": [{}]}}", frequencies.join(", "))?;
    writeln!(out, "{{\"omega\": [{}]}}", centres.join(", "))?;
    stdout.write_all(out.as_bytes())?;
    Ok(())
}
