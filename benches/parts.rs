//! What each part of a model costs, and that a model without it pays nothing: one chain of T and V, and the same chain with a
//! term linear in velocities, with friction, with a constraint, turning steadily, stage by stage, time and allocations side by
//! side. And the derivatives of its frequencies.
//!
//! `cargo bench --bench parts --no-default-features --features engine`
//!
//! The line to watch is `plain`: its allocations are the same on every machine, so that work done for a part that a model
//! doesn't have shows as a number that differs between two commits (`-- plain` runs these lines alone). The lines below
//! it are what each part adds.

use std::fmt::{self, Display, Formatter};

use divan::{AllocProfiler, Bencher};
use librate::linearize::{Linearized, linearize};
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::sensitivity::sensitivities;
use librate::syntax::parse;

#[global_allocator]
static ALLOCATIONS: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

/// A chain of twenty between walls; every mass and every spring is a parameter.
const CHAIN: &str = "param N = 20  param k[1..20] = 2  param m[1..20] = 3
    coord x[1..N]
    V = 1/2*x[1]^2 + sum(i in 1..N-1, 1/2*k[i]*(x[i+1] - x[i])^2) + 1/2*k[N]*x[N]^2";

#[derive(Clone, Copy)]
struct Part {
    name: &'static str,
    /// Beside the inertia of the chain.
    kinetic: &'static str,
    statements: &'static str,
}

const PLAIN: Part = Part { name: "plain", kinetic: "", statements: "" };

const PARTS: [Part; 5] = [
    PLAIN,
    Part { name: "rotation", kinetic: " + sum(i in 1..N-1, 1/9*x[i]*x[i+1]')", statements: "" },
    Part { name: "friction", kinetic: "", statements: "dissipation = sum(i in 1..N, 1/40*i*x[i]'^2)" },
    Part { name: "constraint", kinetic: "", statements: "constraint x[5] = 2*x[9]" },
    Part {
        name: "steady motion",
        kinetic: " + 1/2*(5 + x[3] + x[7]^2)*psi'^2",
        statements: "coord psi  equilibrium psi' = 1/3",
    },
];

impl Display for Part {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// A model that can't be read is a mistake of the benchmark.
fn stop() -> ! {
    std::process::exit(1)
}

fn text(part: Part) -> String {
    let Part { kinetic, statements, .. } = part;
    format!("{CHAIN}\n{statements}\nT = sum(i in 1..N, 1/2*m[i]*x[i]'^2){kinetic}")
}

fn model(text: &str) -> Model {
    let file = parse(text).unwrap_or_else(|_| stop());
    elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap_or_else(|_| stop())
}

fn linear(model: Model) -> Linearized {
    linearize(model).unwrap_or_else(|_| stop())
}

#[divan::bench(args = PARTS)]
fn a_read(bencher: Bencher<'_, '_>, part: Part) {
    let text = text(part);
    bencher.bench(|| model(&text));
}

#[divan::bench(args = PARTS)]
fn b_linearize(bencher: Bencher<'_, '_>, part: Part) {
    let model = model(&text(part));
    bencher.with_inputs(|| model.clone()).bench_values(linear);
}

#[divan::bench(args = PARTS)]
fn c_evaluate(bencher: Bencher<'_, '_>, part: Part) {
    let linear = linear(model(&text(part)));
    bencher.bench(|| (linear.mass(), linear.stiffness()));
}

#[divan::bench(args = PARTS)]
fn d_modes(bencher: Bencher<'_, '_>, part: Part) {
    let linear = linear(model(&text(part)));
    let modes = || normal_modes(&linear, &Options::default());
    if modes().is_err() {
        stop();
    }
    bencher.bench(modes);
}

/// Forty parameters and, but for the coordinate that turns, twenty modes.
#[divan::bench(args = PARTS)]
fn e_sensitivities(bencher: Bencher<'_, '_>, part: Part) {
    let linear = linear(model(&text(part)));
    let Ok(modes) = normal_modes(&linear, &Options::default()) else { stop() };
    bencher.bench(|| sensitivities(&linear, &modes));
}

#[divan::bench(args = PARTS)]
fn f_whole_trip(bencher: Bencher<'_, '_>, part: Part) {
    let text = text(part);
    bencher.bench(|| normal_modes(&linear(model(&text)), &Options::default()));
}

/// Two coordinates without and with rotation.
#[divan::bench(args = ["plain", "Foucault"])]
fn g_foucault(bencher: Bencher<'_, '_>, name: &str) {
    let text = match name {
        "plain" => include_str!("../models/coupled_oscillators_equal.lag"),
        _ => include_str!("../models/foucault_pendulum.lag"),
    };
    bencher.bench(|| normal_modes(&linear(model(text)), &Options::default()));
}
