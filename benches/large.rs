//! Some modes of large models from the text on, at several sizes: a chain, a net in its plane, an elastic network.
//!
//! `cargo bench --bench large --no-default-features --features engine`

use divan::Bencher;
use librate::budget::Budget;
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::syntax::parse;

#[allow(dead_code, reason = "a program of its own")]
#[path = "../examples/points.rs"]
mod points;

fn main() {
    divan::main();
}

const CHAIN: &str = include_str!("../models/large/chain.lag");
const NET: &str = include_str!("../models/large/net.lag");
const NETWORK: &str = include_str!("../models/large/network.lag");

/// A model that can't be read is a mistake of the benchmark.
fn stop() -> ! {
    std::process::exit(1)
}

fn linear(text: &str, setting: Option<String>, points: Option<u32>) -> Linearized {
    let mut settings = Settings::new().within(Budget::new(8_000_000_000));
    if setting.is_some_and(|own| settings.add(&own).is_err()) {
        stop();
    }
    let mut tables = TableTexts::new();
    if let Some(count) = points {
        tables = tables.with("points.csv".to_owned(), points::table(count));
    }
    let file = parse(text).unwrap_or_else(|_| stop());
    let model = elaborate(&file, &tables, &settings).unwrap_or_else(|_| stop());
    linearize(model).unwrap_or_else(|_| stop())
}

fn chain(n: usize) -> Linearized {
    linear(CHAIN, Some(format!("N={n}")), None)
}

fn net(n: usize) -> Linearized {
    linear(NET, Some(format!("N={n}")), None)
}

fn network(n: usize) -> Linearized {
    linear(NETWORK, None, u32::try_from(n).ok())
}

/// So many of the lowest.
fn options(count: usize) -> Options {
    Options::default().lowest(count).without_vectors()
}

#[divan::bench(max_time = 3, args = [10, 100, 1000, 10_000, 100_000, 1_000_000])]
fn c_chain(bencher: Bencher<'_, '_>, n: usize) {
    bencher.bench(|| normal_modes(&chain(n), &options(10)));
}

/// To M and K alone.
#[divan::bench(max_time = 3, args = [10, 100, 1000, 10_000, 100_000, 1_000_000])]
fn c_chain_matrices(bencher: Bencher<'_, '_>, n: usize) {
    bencher.bench(|| chain(n).sparse());
}

#[divan::bench(max_time = 3, args = [10, 30, 100])]
fn d_net(bencher: Bencher<'_, '_>, n: usize) {
    bencher.bench(|| normal_modes(&net(n), &options(10)));
}

#[divan::bench(max_time = 3, args = [10, 30, 100])]
fn d_net_matrices(bencher: Bencher<'_, '_>, n: usize) {
    bencher.bench(|| net(n).sparse());
}

#[divan::bench(max_time = 3, args = [100, 1000, 10_000])]
fn e_network(bencher: Bencher<'_, '_>, n: usize) {
    bencher.bench(|| normal_modes(&network(n), &options(20)));
}

#[divan::bench(max_time = 3, args = [100, 1000, 10_000])]
fn e_network_matrices(bencher: Bencher<'_, '_>, n: usize) {
    bencher.bench(|| network(n).sparse());
}
