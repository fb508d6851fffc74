//! Every subcommand on any text, with flags drawn from it: each answers, or has mistakes to tell, within a budget.
//!
//! The verdict on time and memory is the fuzzer's (`-timeout=10 -rss_limit_mb=1024` in `fuzz/run`): ten seconds and one GB, as
//! the command line promises for a small model. Builds for fuzzing are some ten times slower than released ones, so the budget
//! has a fifth of that time here; what asks it ends then, and what asks nobody has to be through before the other four are.

#[path = "checks.rs"]
mod checks;

use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use librate::Source;
use librate::budget::{Budget, Limit};
use librate::derive::{self, Parts};
use librate::diagnostic::Diagnostic;
use librate::model::{self, Constant, Model, Range, Settings};
use librate::motion::{Enclosed, Start, System, Times};
use librate::period::{self, Oscillator, Request};
use librate::report::{self, Style, SweepColumns, SweepRow};
use librate::sweep::Sweep;
use librate::{Error, amplitude, floquet, inertia, linearize, modes, oscillation, sensitivity, syntax};

/// The longest text, in bytes: what is small to the command line.
const MOST_BYTES: usize = 8192;
const SECONDS: u64 = 2;
/// Half of what the fuzzer allows, which counts itself and what is freed already.
const BYTES: u64 = 500_000_000;

/// What is stopped when its time has come.
type Watched = Mutex<Option<(Duration, Budget)>>;

/// Processor time, so that a busy machine shortens no budget; where the system does not tell it, what has passed.
fn worked() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    let passed = START.get_or_init(Instant::now).elapsed();
    let read = || -> Option<Duration> {
        let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
        // Behind the name, in hundredths of a second: user time, system time.
        let (_, fields) = stat.rsplit_once(')')?;
        let mut ticks = fields.split_whitespace().skip(11);
        let mut next = || ticks.next()?.parse::<u64>().ok();
        Some(Duration::from_millis(10 * (next()? + next()?)))
    };
    read().unwrap_or(passed)
}

fn watched() -> &'static Watched {
    static WATCHED: OnceLock<Watched> = OnceLock::new();
    WATCHED.get_or_init(|| {
        thread::spawn(|| {
            loop {
                thread::sleep(Duration::from_millis(20));
                let own = watched().lock().unwrap_or_else(PoisonError::into_inner);
                if let Some((end, budget)) = &*own
                    && worked() > *end
                {
                    budget.stop(Limit::Time(SECONDS));
                }
            }
        });
        Mutex::new(None)
    })
}

fn watch(budget: Option<Budget>) {
    let end = worked() + Duration::from_secs(SECONDS);
    *watched().lock().unwrap_or_else(PoisonError::into_inner) = budget.map(|own| (end, own));
}

/// Flags, from the bytes of the text one after the other.
struct Flags<'a>(std::slice::Iter<'a, u8>);

impl Flags<'_> {
    fn one<'b, T: ?Sized>(&mut self, among: &[&'b T]) -> &'b T {
        let at = usize::from(*self.0.next().unwrap_or(&0)) % among.len();
        among[at]
    }

    fn digits(&mut self) -> usize {
        *self.one(&[&10, &1, &20, &30])
    }
}

/// One subcommand, chosen by the sum of the bytes, so that every change of a text may come to another one.
pub(crate) fn check(text: &str) {
    if text.len() > MOST_BYTES {
        return;
    }
    let sum = text.bytes().fold(0_usize, |sum, byte| sum + usize::from(byte));
    let reversed: Vec<u8> = text.bytes().rev().collect();
    let mut flags = Flags(reversed.iter());
    let budget = Budget::new(BYTES);
    watch(Some(budget.clone()));
    let answer = command(sum % COMMANDS, text, &mut flags, &budget);
    watch(None);
    match answer {
        Ok(text) => assert!(budget.check().is_err() || !text.is_empty()),
        Err(error) => checks::answered(text, &error.diagnostics()),
    }
}

const COMMANDS: usize = 11;

fn command(number: usize, text: &str, flags: &mut Flags, budget: &Budget) -> Result<String, Error> {
    if number == 0 {
        return Ok(syntax::format(text)? + "\n");
    }
    let file = syntax::parse(text)?;
    let tables = checks::tables();
    let settings = Settings::new().within(budget.clone());
    if number == 1 {
        let model = model::elaborate(&file, &tables, &settings.only_tensors())?;
        let digits = flags.digits();
        return Ok(match inertia::of_model(&model, digits) {
            Ok(found) => report::tensors_text(None, &found, digits, &Style::default()),
            Err(errors) => told(&errors.iter().map(Diagnostic::from).collect::<Vec<_>>()),
        });
    }
    if number == 2 {
        let Ok(range) = Range::parse(flags.one(&["k=1..4:4", "m=1/2..2:3", "g=0..10:3"])) else {
            return Ok("no range".to_owned());
        };
        let options = modes::Options::default();
        let digits = options.digits;
        let (name, count) = (range.name().to_owned(), range.len());
        let sweep = Sweep::new(Source { file, tables, settings }, range, options);
        let row = |place: usize| {
            let place = sweep.place(place);
            match &place.result {
                Ok((_, modes)) => SweepRow::new(place.value, modes, digits),
                Err(_) => SweepRow::empty(place.value),
            }
        };
        let rows: Vec<SweepRow> = (0..count).map(row).collect();
        let columns = SweepColumns::of(&name, rows.iter(), false);
        let lines: Vec<String> = rows.iter().map(|row| columns.cells(row).join(",")).collect();
        return Ok(lines.join("\n"));
    }
    if number > 4 {
        linearize::check_size(model::coordinate_count(&file, &tables, &settings))?;
    }
    let model = model::elaborate(&file, &tables, &settings)?;
    match number {
        3 => Ok(told(&model.warnings(&file))),
        4 => {
            let parts = Parts::all().cubic(*flags.one(&[&false, &true]));
            let derivation = derive::derive(&model, &parts)?;
            Ok(match flags.one(&["text", "json", "latex"]) {
                "json" => report::derive_json(&derivation),
                "latex" => report::derive_latex(&derivation, true),
                _ => report::derive_text(&derivation, &Style::default()),
            })
        }
        5 => motion(&model, flags),
        6 => {
            let digits = flags.digits();
            let found = floquet::floquet(&model, &floquet::Options::default().digits(digits))?;
            Ok(report::floquet_json(&model, &found, digits))
        }
        7 => {
            let oscillator = Oscillator::of_model(&model)?;
            let request = Request::Amplitude(Constant::parse(flags.one(&["1", "1/100", "pi", "50"]))?);
            let options = period::Options::default().digits(flags.digits());
            let found = oscillator.period(&request, &options)?;
            Ok(report::period_json(&oscillator, &found, &options))
        }
        _ => of_modes(number, model, flags),
    }
}

/// What stands on the modes of a model.
fn of_modes(number: usize, model: Model, flags: &mut Flags) -> Result<String, Error> {
    if number == 8 {
        amplitude::check(&model)?;
    }
    let digits = if number == 8 { 14 } else { flags.digits() };
    let options = modes::Options::default().digits(digits);
    let linearized = linearize::linearize(model)?;
    let normal = oscillation::normal_modes(&linearized, &options)?;
    assert!(normal.warnings(&linearized).iter().all(|own| !own.message.is_empty()));
    Ok(match number {
        8 => {
            let found = amplitude::amplitude(&linearized, &normal)?;
            report::amplitude_json(&linearized, &normal, &found, 10)
        }
        9 => {
            let found = sensitivity::sensitivities(&linearized, &normal);
            report::sensitivity_json(&linearized, &normal, &found, &options)
        }
        _ => report::modes_json(&linearized, &normal, &options),
    })
}

fn motion(model: &Model, flags: &mut Flags) -> Result<String, Error> {
    let until = Constant::parse(flags.one(&["1", "100", "1e6", "1/1000"]))?;
    let times = Times::new(&until, 11)?;
    let system = System::new(model)?;
    let linearized = linearize::linearize(model.clone()).ok();
    let start = Start::parse(flags.one(&["x=1", "", "x=1/10", "y'=1"]), model, linearized.as_ref(), &system)?;
    let found = match flags.one(&["plain", "quick", "proved"]) {
        "quick" => system.quick(&start, &times, 1e-9)?,
        "proved" => Enclosed::new(model)?.motion(&start, &times, 10)?,
        _ => system.motion(&start, &times)?,
    };
    Ok(report::motion_csv(model, &found, None, 10))
}

fn told(all: &[Diagnostic]) -> String {
    let messages: Vec<&str> = all.iter().map(|own| own.message.as_str()).collect();
    format!("{}\n", messages.join("\n"))
}
