//! What sparse problems take is worked out before it is taken; what fills their factors, and what does not.

#![cfg(feature = "engine")]

use std::path::Path;
use std::sync::{Arc, Mutex};

use librate::Error;
use librate::budget::Budget;
use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::{NormalModes, normal_modes};
use librate::syntax::parse;

use crate::common::model_in;

/// One coordinate tied to all others.
const ARROW: &str = "
coord x[1..N], y
T = sum(i in 1..N, 1/2*x[i]'^2) + 1/2*N*y'^2
V = sum(i in 1..N, 1/2*i*x[i]^2 + 1/2*(x[i] - y)^2)
";

/// All coordinates tied to all others by a single term.
const FULL: &str = "
coord x[1..N]
T = sum(i in 1..N, 1/2*x[i]'^2)
V = sum(i in 1..N, 1/2*i*x[i]^2) + 1/2*sum(i in 1..N, x[i])^2
";

/// A lattice in space of N^3 masses that move along one line.
const LATTICE: &str = "
coord u[1..N, 1..N, 1..N]
T = sum(i in 1..N, j in 1..N, l in 1..N, 1/2*u[i,j,l]'^2)
V = sum(i in 1..N-1, j in 1..N, l in 1..N, 1/2*(u[i+1,j,l] - u[i,j,l])^2)
  + sum(i in 1..N, j in 1..N-1, l in 1..N, 1/2*(u[i,j+1,l] - u[i,j,l])^2)
  + sum(i in 1..N, j in 1..N, l in 1..N-1, 1/2*(u[i,j,l+1] - u[i,j,l])^2)
  + sum(i in 1..N, j in 1..N, l in 1..N, 1/200*u[i,j,l]^2)
";

/// Modes within a budget, and what is said on the way.
fn modes(text: &str, n: usize, bytes: u64, options: &Options) -> (Result<NormalModes, Error>, Vec<String>) {
    let budget = Budget::new(bytes);
    let heard = Arc::new(Mutex::new(Vec::new()));
    let lines = Arc::clone(&heard);
    budget.listen(move |line| lines.lock().unwrap().push(line.to_owned()));
    let computed = || {
        let file = parse(&format!("param N = {n}\n{text}"))?;
        let model = elaborate(&file, &TableTexts::new(), &Settings::new().within(budget))?;
        Ok(normal_modes(&linearize(model)?, options)?)
    };
    let computed = computed();
    let lines = heard.lock().unwrap().clone();
    (computed, lines)
}

/// Message and help of what is refused.
fn refused(text: &str, n: usize, bytes: u64, lowest: usize) -> (String, String) {
    let options = Options::default().lowest(lowest).without_vectors();
    let told = modes(text, n, bytes, &options).0.unwrap_err().diagnostics().remove(0);
    assert_eq!(told.code, Some("E0901"));
    (told.message, told.help.unwrap())
}

/// The number before a word in a line that begins with another.
fn number(lines: &[String], start: &str, word: &str) -> usize {
    let line = lines.iter().find(|line| line.starts_with(start)).unwrap();
    let before = line.split(word).next().unwrap();
    before.split_whitespace().next_back().unwrap().parse().unwrap()
}

#[test]
fn a_coordinate_tied_to_all_others_fills_nothing() {
    let n = 20_000;
    let (found, lines) = modes(ARROW, n, 100_000_000, &Options::default().lowest(3).without_vectors());
    // w^2 = i + 1, but for what the heavy one does to it.
    for (i, mode) in found.unwrap().modes.iter().enumerate() {
        let square = if i == 0 { 1.0 } else { (i + 1) as f64 };
        assert!((mode.omega.mid_f64() - square.sqrt()).abs() < 1e-3, "{i}: {}", mode.omega.mid_f64());
    }
    assert_eq!(number(&lines, "solver: block Lanczos steps", " entries"), 2 * n + 1, "{lines:?}");
}

#[test]
fn a_term_that_ties_all_to_all_is_refused_before_it_is_worked_out() {
    let (message, help) = refused(FULL, 50_000, 1_000_000_000, 3);
    assert_eq!(message, "the budget of 1 GB is less than the 46 GB for 1250125000 shares of the entries of M and K");
    assert!(help.contains("one of differences of neighbours few"), "{help}");
}

#[test]
fn factors_that_fill_are_refused_with_their_size() {
    let (found, lines) = modes(LATTICE, 18, 100_000_000, &Options::default().lowest(4).without_vectors());
    let sine = (std::f64::consts::PI / 36.0).sin();
    for (mode, exact) in found.unwrap().modes.iter().zip([0.1, (0.01 + 4.0 * sine * sine).sqrt()]) {
        assert!((mode.omega.mid_f64() - exact).abs() < 1e-12);
    }
    // Two factors at a time alone are more than this.
    let entries = number(&lines, "solver: block Lanczos steps", " entries");
    let (message, help) = refused(LATTICE, 18, 16 * entries as u64, 4);
    let figure = message.split_once(" is less than the ").unwrap().1;
    assert!(
        figure.contains(&format!(" MB for 2 triangular factors of K - s M with {entries} entries each")),
        "{message}"
    );
    let megabytes: usize = figure.split(' ').next().unwrap().parse().unwrap();
    assert!((16 * entries..16 * entries + 10_000_000).contains(&(1_000_000 * megabytes)), "{message}");
    assert!(help.contains("on what is coupled with what"), "{help}");
}

#[test]
fn more_modes_than_there_is_memory_for_are_refused() {
    let (message, help) = refused(ARROW, 50_000, 1_000_000_000, 49_000);
    assert!(message.starts_with("the budget of 1 GB is less than the 59 GB for 147084 vectors of 50001 "), "{message}");
    assert!(help.starts_with("fewer modes take less; `--budget` raises it: `--budget "), "{help}");
}

#[test]
fn what_is_chosen_is_said() {
    let chain = std::fs::read_to_string("models/large/chain.lag").unwrap();
    let all = |settings: &str, options: &Options| {
        let model = model_in(&chain, Path::new("models/large"), &[settings]);
        let heard = Arc::new(Mutex::new(Vec::new()));
        let lines = Arc::clone(&heard);
        model.pool.budget().listen(move |line| lines.lock().unwrap().push(line.to_owned()));
        normal_modes(&linearize(model).unwrap(), options).unwrap();
        heard.lock().unwrap().clone()
    };
    let lines = all("N = 1000", &Options::default().lowest(3));
    let (known, counts) = lines.split_at(3);
    assert_eq!(
        known,
        [
            "energies: 2001 terms of 4 forms; equilibrium: not searched for",
            "structure: 1000 coordinates; M diagonal, 1000 entries; K tridiagonal, 2998 entries",
            "solver: Sturm counts and twisted factorizations, since M and K are tridiagonal",
        ]
    );
    assert!(counts[0].starts_with("inertia at omega^2 = 0 +- ") && counts[0].ends_with(": 0 below"), "{counts:?}");
    assert!(counts[1].starts_with("inertia at omega^2 = ") && counts[1].ends_with(": 3 below"), "{counts:?}");
    assert!(counts[2].starts_with("3 modes from the end to ") && counts[2].ends_with(": proved"), "{counts:?}");
    assert_eq!(counts[3], "precision: doubles");
    for (options, why) in
        [(Options::default(), "all modes are wanted"), (Options::default().lowest(3), "they are as fast for so few")]
    {
        let lines = all("N = 10", &options);
        assert_eq!(lines[1], format!("solver: dense matrices of 10 coordinates, since {why}"));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let membrane = std::fs::read_to_string("models/large/membrane.lag").unwrap();
    let of = |threads: usize| {
        let model = model_in(&membrane, Path::new("models/large"), &["N = 24"]);
        let options = Options::default().near(1.3, 5).threads(threads);
        let found = normal_modes(&linearize(model).unwrap(), &options).unwrap();
        assert!(found.method.is_some());
        format!("{:?}", found.modes)
    };
    let one = of(1);
    assert_eq!(one, of(2));
    assert_eq!(one, of(7));
}
