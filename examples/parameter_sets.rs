//! A thousand parameter sets of M, K and modes, timed, beside numpy on the same numbers.
//!
//! ```text
//! cargo run --release --no-default-features --features engine --example parameter_sets -- [--sets 1000] [--python PYTHON]
//! ```
//!
//! The problems are those of the example `peer`: `A`, three pendulums joined by springs, six
//! parameters; `B`, a pendulum of n links, every mass, every length and g; `C`, the same with friction. Every
//! parameter is the nominal value times 0.5 to 1.5. All times are CPU seconds of one core, medians of repeats, for
//! all sets together; `sets` is M, K, ω² and mode shapes with rigorous bounds, `plain` the same
//! without bounds, `frequencies` ω² with bounds alone; of `C` exponents in place of ω². `--python` (with numpy) adds
//! what the same takes there: M and K from closed forms written by hand for arrays of sets, batched Cholesky and
//! eigenvalues (`numpy_values`; of `C` those of the first-order matrix), with vectors (`numpy_vectors`), and how far
//! the two are apart.

use std::error::Error;
use std::hint::black_box;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::Instant;

#[path = "speed_and_error/clock.rs"]
#[allow(dead_code, reason = "other examples use more of it")]
mod clock;
#[path = "speed_and_error/problems.rs"]
mod problems;

use clock::repeat;
use librate::batch::{Options, Solutions, Study};
use librate::model::{Settings, TableTexts, elaborate};
use librate::syntax::parse;
use problems::{DAMPING, LINKS, PENDULUMS};

/// Reads the sets as doubles; prints CPU seconds, then all ω², or |s|.
const NUMPY: &str = r#"
import sys, json, time, statistics, numpy as np
family, n = sys.argv[1], int(sys.argv[2])
P = np.frombuffer(sys.stdin.buffer.read(), '<f8').reshape(int(sys.argv[3]), -1)
mx = np.maximum.outer(np.arange(n), np.arange(n))
def matrices():
    if family == 'A':
        m, l, g, L, k12, k23 = P.T
        a, b, c = L**2 * k12, L**2 * k23, m * g * l
        z = np.zeros_like(a)
        K = np.stack([c + a, -a, z, -a, c + a + b, -b, z, -b, c + b], -1)
        return K.reshape(K.shape[:-1] + (3, 3)), (m * l * l)[..., None, None] * np.eye(3)
    m, l, g = P[:, :n], P[:, n:2 * n], P[:, 2 * n]
    s = m[:, ::-1].cumsum(1)[:, ::-1]
    K = np.zeros((len(P), n, n)); i = np.arange(n)
    K[:, i, i] = g[:, None] * l * s
    return K, s[:, mx] * l[:, :, None] * l[:, None, :]
def first_order(K, M):
    Mi = np.linalg.inv(M)
    A = np.zeros((len(P), 2 * n, 2 * n)); i = np.arange(n)
    A[:, i, n + i] = 1
    A[:, n:, :n] = -Mi @ K
    A[:, n:, n:] = -Mi * P[:, None, 2 * n + 1:]
    return A
def values(K, M):
    if family == 'C':
        return np.sort(np.abs(np.linalg.eigvals(first_order(K, M))), 1)
    Li = np.linalg.inv(np.linalg.cholesky(M))
    return np.linalg.eigvalsh(Li @ K @ Li.swapaxes(1, 2))
def vectors(K, M):
    if family == 'C':
        return np.linalg.eig(first_order(K, M))
    Li = np.linalg.inv(np.linalg.cholesky(M))
    w, q = np.linalg.eigh(Li @ K @ Li.swapaxes(1, 2))
    return w, Li.swapaxes(1, 2) @ q
def seconds(f):
    ts, start = [], time.perf_counter()
    while len(ts) < 5 or time.perf_counter() - start < 1:
        t = time.process_time(); f(); ts.append(time.process_time() - t)
    return statistics.median(ts)
K, M = matrices()
print(json.dumps([seconds(matrices), seconds(lambda: values(K, M)), seconds(lambda: vectors(K, M))]))
print(json.dumps(values(K, M).ravel().tolist()))
"#;

/// The model, the parameters that vary, and their nominal values.
fn problem(family: &str, n: usize) -> (String, Vec<&'static str>, Vec<f64>) {
    if family == "A" {
        let names = vec!["m", "l", "g", "L", "k12", "k23"];
        (PENDULUMS.to_owned(), names, vec![1.0, 1.0, 9.81, 0.5, 2.0, 3.0])
    } else {
        let mut nominal = vec![1.0; 2 * n];
        nominal.push(9.81);
        if family == "B" {
            return (format!("param N = {n}{LINKS}"), vec!["m", "l", "g"], nominal);
        }
        nominal.extend(vec![1.0; n]);
        (format!("param N = {n}{LINKS}{DAMPING}"), vec!["m", "l", "g", "c"], nominal)
    }
}

/// Nominal values times 0.5 to 1.5, from a linear congruential generator (Knuth's MMIX).
fn random_sets(nominal: &[f64], count: usize) -> Vec<f64> {
    let mut state = 20_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.5 + (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).flat_map(|_| nominal.iter().map(|value| value * random()).collect::<Vec<_>>()).collect()
}

/// Runs numpy on the same sets: its times and all ω².
fn numpy(
    python: &str,
    family: &str,
    n: usize,
    (sets, count): (&[f64], usize),
) -> Result<(Vec<f64>, Vec<f64>), Box<dyn Error>> {
    let mut child = Command::new(python)
        .args(["-c", NUMPY, family, &n.to_string(), &count.to_string()])
        .env("OPENBLAS_NUM_THREADS", "1")
        .env("OMP_NUM_THREADS", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let bytes: Vec<u8> = sets.iter().flat_map(|value| value.to_le_bytes()).collect();
    child.stdin.take().ok_or("no pipe")?.write_all(&bytes)?;
    let output = child.wait_with_output()?;
    let text = String::from_utf8(output.stdout)?;
    let mut lines = text.lines();
    let mut numbers = || -> Result<Vec<f64>, Box<dyn Error>> {
        let line = lines.next().ok_or("numpy gave no answer")?;
        Ok(line.trim_matches(['[', ']']).split(", ").map(str::parse).collect::<Result<_, _>>()?)
    };
    Ok((numbers()?, numbers()?))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut count, mut python) = (1000, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().ok_or("every option takes a value")?;
        match argument.as_str() {
            "--sets" => count = value.parse()?,
            "--python" => python = Some(value),
            _ => return Err(format!("unknown argument {argument}").into()),
        }
    }
    let mut stdout = std::io::stdout().lock();
    for (family, n) in [("A", 3), ("B", 3), ("B", 10), ("B", 20), ("B", 50), ("C", 3), ("C", 10), ("C", 20)] {
        let (text, names, nominal) = problem(family, n);
        let sets = random_sets(&nominal, count);
        let file = parse(&text).map_err(|errors| errors[0].clone())?;
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).map_err(|errors| errors[0].clone())?;
        let plain = Options::default().without_bounds();
        let frequencies = Options::default().without_vectors().without_matrices();
        let start = Instant::now();
        let study = Study::new(model.clone(), &names)?;
        let derive = start.elapsed().as_secs_f64();
        write!(stdout, "{{\"model\": \"{family}\", \"n\": {n}, \"sets\": {count}, \"derive_s\": {derive:.1e}")?;
        let mut solutions = Solutions::new();
        let mut fastest = f64::NAN;
        for (key, options) in [("sets_s", Options::default()), ("plain_s", plain), ("frequencies_s", frequencies)] {
            let study = Study::with_options(model.clone(), &names, options)?;
            let (_, time) = repeat(|| Ok(study.solve_into(black_box(&sets), &mut solutions)?))?;
            if key == "sets_s" {
                fastest = time;
            }
            write!(stdout, ", \"{key}\": {time:.2e}")?;
        }
        study.solve_into(&sets, &mut solutions)?;
        let (values, bounds) = if study.is_conservative() {
            (solutions.omega_squared().to_vec(), solutions.omega_squared_bounds())
        } else {
            (solutions.exponents().iter().map(|s| s.re.hypot(s.im)).collect(), solutions.exponent_bounds())
        };
        let mut bounds: Vec<f64> = bounds.iter().zip(&values).map(|(bound, value)| bound / value).collect();
        bounds.sort_by(f64::total_cmp);
        write!(
            stdout,
            ", \"median_relative_bound\": {:.1e}, \"largest_relative_bound\": {:.1e}",
            bounds[bounds.len() / 2],
            bounds[bounds.len() - 1]
        )?;
        if let Some(python) = &python {
            let (times, theirs) = numpy(python, family, n, (&sets, count))?;
            let mut values = values;
            values.chunks_mut(theirs.len() / count).for_each(|own| own.sort_by(f64::total_cmp));
            let apart = theirs.iter().zip(&values).fold(0.0_f64, |most, (a, b)| most.max((a / b - 1.0).abs()));
            write!(
                stdout,
                ", \"numpy_matrices_s\": {:.2e}, \"numpy_values_s\": {:.2e}, \"numpy_vectors_s\": {:.2e}, \"apart\": {apart:.1e}, \"ratio_values\": {:.2}, \"ratio_vectors\": {:.2}",
                times[0],
                times[1],
                times[2],
                fastest / (times[0] + times[1]),
                fastest / (times[0] + times[2])
            )?;
        }
        writeln!(stdout, "}}")?;
    }
    Ok(())
}
