//! Random models by the thousand, every claim about them held against a reference that shares nothing
//! with the library.
//!
//! ```text
//! cargo run --release --example campaign -- N [--seed S] [--kind NAME] [--digits D] [--first I]
//!     [--model I] [--print] [--keep DIR] [--threads T]
//! ```
//!
//! Models are drawn as texts (`kinds`), go the whole trip from parsing to modes, and are judged
//! (`check`) against M and K written down by hand from the same numbers, with eigenvalues in floats of
//! 768 bits and more (`reference`). The exit status is 1 if anything is wrong. A model is a function of
//! the seed, its kind and its number: `--kind NAME --model I` draws it again, `--print` prints its
//! text, and `--keep DIR` writes the texts of all models with something wrong.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a report on standard output")]

mod check;
#[path = "../speed_and_error/clock.rs"]
#[allow(dead_code, reason = "other examples use more of it")]
mod clock;
mod digits;
mod draw;
mod exponents;
mod kinds;
mod pencil;
mod real;
mod reference;
mod survey;

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use comfy_table::{CellAlignment, Table, presets};

use check::{Outcome, WRONGS, Wrong};
use kinds::KINDS;
use survey::{Done, Plan, current};

struct Request {
    plan: Plan,
    print: bool,
    keep: Option<PathBuf>,
}

fn request() -> Result<Request, Box<dyn Error>> {
    let clock = SystemTime::now().duration_since(UNIX_EPOCH)?;
    let mut plan = Plan {
        seed: clock.as_secs() % 1_000_000,
        models: 0..0,
        kind: None,
        digits: None,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
    };
    let (mut count, mut first) = (None, 0);
    let (mut print, mut keep) = (false, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--seed" => plan.seed = value()?.parse()?,
            "--kind" => {
                let name = value()?;
                let known = KINDS.iter().position(|kind| kind.0 == name);
                let all = KINDS.map(|kind| kind.0).join(", ");
                plan.kind = Some(known.ok_or(format!("no kind {name}; there are {all}"))?);
            }
            "--digits" => plan.digits = Some(value()?.parse()?),
            "--first" => first = value()?.parse()?,
            "--model" => {
                first = value()?.parse()?;
                count = Some(1);
            }
            "--threads" => plan.threads = value()?.parse()?,
            "--print" => print = true,
            "--keep" => keep = Some(PathBuf::from(value()?)),
            _ => count = Some(argument.parse().map_err(|_| format!("what is {argument}?"))?),
        }
    }
    let count: usize = count.ok_or("how many models?")?;
    plan.models = first..first + count;
    Ok(Request { plan, print, keep })
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let Request { plan, print, keep } = request()?;
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if let Some((kind, index)) = current() {
            eprintln!("in model {index} of kind {}:", KINDS[kind].0);
        }
        hook(panic);
    }));
    if print && plan.models.len() == 1 {
        println!("{}", text(&plan, plan.models.start));
    }
    let start = Instant::now();
    let done = plan.run(|done| {
        if done.is_multiple_of(1000) {
            eprintln!("{done} models");
        }
    });
    println!(
        "seed {}, {} models, {:.0} s on {} threads",
        plan.seed,
        plan.models.len(),
        start.elapsed().as_secs_f64(),
        plan.threads
    );
    println!("{}", table(&plan, &done));
    let failures = || done.iter().filter(|done| !done.outcome.violations.is_empty());
    let only_lost = |failure: &&Done| failure.outcome.violations.iter().all(|v| v.0 == Wrong::Lost);
    let (lost, others): (Vec<&Done>, Vec<&Done>) = failures().partition(only_lost);
    if !lost.is_empty() {
        let numbers: Vec<String> = lost.iter().map(|f| f.index.to_string()).collect();
        println!("no equilibrium found in: {}", numbers.join(" "));
    }
    // A few of a sort say as much as all.
    for failure in others.into_iter().chain(lost.into_iter().take(20)) {
        println!("--seed {} --kind {} --model {}", plan.seed, KINDS[plan.kind_of(failure.index)].0, failure.index);
        for (wrong, message) in &failure.outcome.violations {
            println!("    {wrong:?}: {message}");
        }
        if print && plan.models.len() > 1 {
            println!("{}", text(&plan, failure.index));
        }
        if let Some(folder) = &keep {
            keep_model(&plan, failure, folder)?;
        }
    }
    Ok(if failures().next().is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A model's text and tables.
fn text(plan: &Plan, index: usize) -> String {
    let (model, asked) = plan.model(index);
    let mut text =
        format!("# {} digits, vectors: {}, lowest: {:?}\n{}", asked.digits, asked.vectors, asked.lowest, model.text);
    for (name, content) in &model.tables {
        let _ = write!(text, "# {name}:\n{content}");
    }
    text
}

/// Writes the model where it can be run: its tables beside it.
fn keep_model(plan: &Plan, failure: &Done, folder: &Path) -> Result<(), Box<dyn Error>> {
    let own = folder.join(format!("{}-{}", KINDS[plan.kind_of(failure.index)].0, failure.index));
    std::fs::create_dir_all(&own)?;
    let (model, asked) = plan.model(failure.index);
    let mut text = format!("# seed {}, {} digits\n", plan.seed, asked.digits);
    for (wrong, message) in &failure.outcome.violations {
        let _ = writeln!(text, "# {wrong:?}: {}", message.replace('\n', " "));
    }
    std::fs::write(own.join("model.lag"), text + &model.text)?;
    for (name, content) in &model.tables {
        std::fs::write(own.join(name), content)?;
    }
    Ok(())
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    let at = (share * last as f64).round() as usize;
    sorted.get(at).copied().unwrap_or(f64::NAN)
}

fn row(name: &str, done: &[&Done]) -> Vec<String> {
    let outcomes = || done.iter().map(|done| &done.outcome);
    let sum = |of: &dyn Fn(&Outcome) -> usize| outcomes().map(of).sum::<usize>();
    let mut sizes: Vec<usize> = outcomes().map(|own| own.coordinates).collect();
    sizes.sort_unstable();
    let mut ratios: Vec<f64> = outcomes().flat_map(|own| &own.ratios).copied().collect();
    ratios.sort_by(f64::total_cmp);
    let mut times: Vec<f64> = outcomes().map(|own| own.cpu.as_secs_f64() * 1e3).collect();
    times.sort_by(f64::total_cmp);
    let mut cells = vec![
        name.to_owned(),
        done.len().to_string(),
        sizes.get(sizes.len() / 2).map_or(String::new(), ToString::to_string),
        sum(&|t| t.numbers).to_string(),
    ];
    let count = |wrong: Wrong| sum(&|own| own.violations.iter().filter(|v| v.0 == wrong).count());
    cells.extend(WRONGS.map(|(wrong, _)| count(wrong).to_string()));
    let fewest = done.iter().filter_map(|done| Some((done.outcome.fewer.iter().min()?, done.index)));
    let fewer = sum(&|t| t.fewer.len());
    cells.push(match fewest.min() {
        Some((digits, index)) => format!("{fewer} (model {index}: {digits})"),
        None => "0".to_owned(),
    });
    cells.push(sum(&|t| t.undecided).to_string());
    cells.push(sum(&|t| t.zeros).to_string());
    cells.push(sum(&|t| t.ties).to_string());
    cells.push(sum(&|t| t.loose_shapes).to_string());
    for share in [0.5, 0.9, 1.0] {
        cells.push(format!("{:.3e}", quantile(&ratios, share)));
    }
    for share in [0.5, 1.0] {
        cells.push(format!("{:.2}", quantile(&times, share)));
    }
    cells
}

fn table(plan: &Plan, done: &[Done]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let mut header = vec!["kind", "models", "n", "numbers"];
    header.extend(WRONGS.map(|(_, title)| title));
    header.extend([
        "fewer digits",
        "undecided",
        "zeros",
        "ties",
        "shape > 1e-9",
        "bound/error",
        "90 %",
        "max",
        "CPU ms",
        "max",
    ]);
    let columns = header.len();
    table.set_header(header);
    for (number, (kind, _)) in KINDS.iter().enumerate() {
        let own: Vec<&Done> = done.iter().filter(|done| plan.kind_of(done.index) == number).collect();
        if !own.is_empty() {
            table.add_row(row(kind, &own));
        }
    }
    table.add_row(row("all", &done.iter().collect::<Vec<_>>()));
    for column in 1..columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
