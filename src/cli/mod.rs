//! From arguments to an exit status: reads files, calls the library, writes.

mod args;
mod chart;
mod check;
mod equilibria;
mod export;
mod fmt;
mod guard;
mod inertia;
mod input;
mod lsp;
mod messages;
mod motion;
mod output;
mod period;
mod plot;
mod progress;
mod repl;
mod response;
mod show;
mod sweep;
mod threads;
mod watch;

use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use clap::CommandFactory;
use clap_complete::Shell;
use librate::derive::{self, Parts};
use librate::diagnostic::Diagnostic;
use librate::model::{self, Constant, Model, Parameter, Range, Settings, TableTexts};
use librate::report::{self, Style};
use librate::{Error, Source as Made, amplitude, explain, floquet, linearize, modes, oscillation, sensitivity, syntax};

use args::{Cli, Command, MessageFormat, ModelArgs};
use guard::Guard;
use input::Source;
use output::write_out;
use progress::Progress;

/// The model or the request is at fault.
const FAULT: u8 = 1;
/// Wrong usage.
const USAGE: u8 = 2;
/// Columns where the output is no terminal: fixed, so that it is the same everywhere.
const PLAIN_WIDTH: usize = 80;
/// Messages in a pipe are wrapped by whoever reads them.
const PLAIN_MESSAGE_WIDTH: usize = 140;

/// Why a command ended without a result.
enum Failure {
    /// Mistakes in the model, to be drawn into its text.
    Model(Source, Vec<Diagnostic>),
    /// Anything else, with the exit status.
    Other { message: String, help: Option<String>, status: u8 },
    /// Help, or arguments that are wrong.
    Usage(clap::Error),
    /// Nobody reads the output any more.
    BrokenPipe,
}

/// What a command has to say: its result, and what was suspicious on the way.
struct Answer {
    text: String,
    /// Warnings, and the text that they are about.
    remarks: Option<(Source, Vec<Diagnostic>)>,
}

impl Answer {
    fn new(text: String, remarks: Option<(Source, Vec<Diagnostic>)>) -> Self {
        Self { text, remarks }
    }

    /// Writes the text into a file that is asked for, and leaves nothing of it to be printed.
    fn into_file(mut self, file: Option<&Path>) -> Result<Self, Failure> {
        if let (Some(file), Some((source, _))) = (file, &mut self.remarks) {
            output::write_file(file, &self.text, source)?;
            self.text.clear();
        }
        Ok(self)
    }
}

/// A model on its way through a command, and what it is made from.
struct Loaded {
    source: Source,
    made: Made,
    model: Model,
    warnings: Vec<Diagnostic>,
}

impl Loaded {
    /// The answer that `work` computes of the model, with the warnings that it adds, while progress is shown.
    fn answer(
        self,
        args: &ModelArgs,
        what: &'static str,
        work: impl FnOnce(&Made, Model, &mut Vec<Diagnostic>) -> Result<String, Error>,
    ) -> Result<Answer, Failure> {
        let Self { source, made, model, mut warnings } = self;
        match during(args, what, || work(&made, model, &mut warnings)) {
            Ok(text) => Ok(Answer::new(text, Some((source, warnings)))),
            Err(error) => Err(failed(&source, &warnings, error)),
        }
    }
}

/// Runs the command that was typed.
pub(crate) fn run() -> ExitCode {
    let mut cli = match args::parsed(std::env::args_os()) {
        Ok(cli) => cli,
        Err(error) => return ended(Err(Failure::Usage(error)), MessageFormat::Text),
    };
    let format = cli.message_format;
    let tells = cli.command.model().is_some_and(|model| model.verbose);
    let guard = Guard::new(cli.budget.unwrap_or_default(), format, tells);
    let is_drawn = matches!(cli.command, Command::Plot { .. } | Command::Show(_));
    if let Some(model) = cli.command.model() {
        model.guard = guard.clone();
        model.drawn = is_drawn;
    }
    let answer = match &mut cli.command {
        Command::Modes(modes) => modes_text(modes, report::modes_svg),
        Command::Sweep(sweep) => sweep::text(sweep),
        Command::Period(period) => period::text(period),
        Command::Amplitude(amplitude) => amplitude_text(amplitude),
        Command::Sensitivity(sensitivity) => sensitivity_text(sensitivity),
        Command::Floquet(floquet) => floquet_text(floquet),
        Command::Response(response) => response::text(response),
        Command::Motion(motion) => motion::text(motion, format),
        Command::Plot { what } => plot::text(what, format),
        Command::Show(show) => show::text(show),
        Command::Equilibria(equilibria) => equilibria::text(equilibria),
        Command::Inertia(inertia) => inertia::text(inertia),
        Command::Export(export) => export::text(export),
        Command::Check(check) => check::text(check),
        Command::Derive(derive) => derive_text(derive),
        Command::Explain { code } => explain_text(code.as_deref()),
        Command::Completions { shell } => Ok(Answer::new(completions(*shell), None)),
        Command::Man { command } => manual(command.as_deref()),
        // Has several files, each with a result of its own.
        Command::Fmt(fmt) => return fmt::run(fmt, format),
        Command::Repl { file } => return repl::run(file.as_deref(), format),
        Command::Watch(watch) => return watch::run(watch, format),
        // Answers as long as it is asked.
        Command::Lsp => return lsp::run(),
    };
    let written = guard.finish(answer).and_then(|answer| {
        if let Some((source, warnings)) = answer.remarks
            && !warnings.is_empty()
        {
            tell(&source, &warnings, format);
        }
        output::write_paged(&answer.text)
    });
    ended(written, format)
}

/// The exit status of a command, once it is said what went wrong.
fn ended(result: Result<(), Failure>, format: MessageFormat) -> ExitCode {
    ExitCode::from(result.map_or_else(|failure| complain(failure, format), |()| 0))
}

/// Help, or what is wrong about the arguments; these may be names of files.
fn usage(error: &clap::Error) -> u8 {
    let text = error.render();
    // Beside colours of ours there are none of an argument's.
    let foreign = |argument: OsString| {
        let argument = argument.to_string_lossy();
        output::visible(&argument, false) != argument
    };
    let plain = std::env::args_os().any(foreign);
    let colored = |has_color: bool| if has_color && !plain { text.ansi().to_string() } else { text.to_string() };
    if error.use_stderr() {
        output::write_messages(&colored(output::has_color(&io::stderr())));
        return USAGE;
    }
    let written = write_out(&colored(output::has_color(&io::stdout())));
    written.map_or_else(|failure| complain(failure, MessageFormat::Text), |()| 0)
}

fn explain_text(code: Option<&str>) -> Result<Answer, Failure> {
    let title = |code| Some(format!("{}\n", explain::explain(code)?.lines().next()?.trim_start_matches(['#', ' '])));
    let help = "codes follow `error` and `warning`, like E0201; `librate explain` lists them";
    let none = |code: &str| wrong_request(format!("there is no code `{code}`"), help);
    let text = match code {
        None => explain::codes().filter_map(title).collect(),
        Some(code) => explain::explain(code).map(readable).ok_or_else(|| none(code))?,
    };
    Ok(Answer::new(text, None))
}

/// A page for a terminal: models indented, without fences.
fn readable(page: &str) -> String {
    let mut inside = false;
    let mut out = String::new();
    for line in page.lines() {
        if line.starts_with("```") {
            inside = !inside;
            continue;
        }
        let line = if inside { format!("    {line}") } else { line.trim_start_matches("# ").to_owned() };
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

/// Modes as text or JSON, or as a picture where that is wanted.
fn modes_text(
    args: &args::Modes,
    picture: impl Fn(&linearize::Linearized, &oscillation::NormalModes) -> String,
) -> Result<Answer, Failure> {
    let few = args.lowest.is_some() || args.near.is_some() || args.certify.is_some();
    let loaded = load(&args.model, if few { Size::Any } else { Size::Dense })?;
    let mut options = modes::Options::default().digits(args.digits);
    options.lowest = args.lowest;
    options.near = args.near.zip(args.count);
    options.given = args.certify.as_ref().map(|file| vectors_to_certify(file, &loaded.model)).transpose()?;
    options.vectors = !args.no_vectors;
    options.threads = args.threads.unwrap_or_else(threads::cores);
    loaded.answer(&args.model, "computing the modes", |_, model, warnings| {
        let (linearized, mut modes) = solved(model, &options)?;
        warnings.extend(modes.warnings(&linearized));
        sensitivity::put_uncertainties(&linearized, &mut modes, &options)?;
        if args.normalize == "max" {
            modes = modes.with_largest_component_one();
        }
        Ok(if args.model.drawn {
            picture(&linearized, &modes)
        } else if args.json {
            report::modes_json(&linearized, &modes, &options)
        } else {
            report::modes_text(&linearized, &modes, &options, &style().unit(args.unit))
        })
    })
}

/// The vectors of an archive, one component a coordinate.
fn vectors_to_certify(file: &Path, model: &Model) -> Result<Arc<[f64]>, Failure> {
    let help = "write them with `numpy.savez(\"vectors.npz\", vectors=x)`, one row a coordinate and one column a mode";
    let refused = |reason: String| {
        let message = format!("`{}`: {reason}", file.display());
        Failure::Other { message, help: Some(help.to_owned()), status: FAULT }
    };
    let found = report::read_vectors(&input::read_bytes(file)?).map_err(refused)?;
    let (rows, coordinates) = (found.dimension, model.coordinates.len());
    if rows != coordinates {
        return Err(refused(format!("the vectors have {rows} components, the model {coordinates} coordinates")));
    }
    Ok(found.components.into())
}

/// A model about its equilibrium, and its modes.
fn solved(
    model: Model,
    options: &modes::Options,
) -> Result<(linearize::Linearized, oscillation::NormalModes), linearize::LinearizeError> {
    let linearized = derive::linearized(model)?;
    let modes = oscillation::normal_modes(&linearized, options)?;
    Ok((linearized, modes))
}

fn sensitivity_text(args: &args::Sensitivity) -> Result<Answer, Failure> {
    let mut options = modes::Options::default().digits(args.digits);
    options.lowest = args.lowest;
    load(&args.model, Size::Dense)?.answer(&args.model, "computing the modes", |_, model, warnings| {
        let (linearized, mut modes) = solved(model, &options)?;
        let found = sensitivity::sensitivities(&linearized, &modes);
        found.put_uncertainties(&linearized, &mut modes);
        warnings.extend(modes.warnings(&linearized));
        Ok(if args.json {
            report::sensitivity_json(&linearized, &modes, &found, &options)
        } else {
            report::sensitivity_text(&linearized, &modes, &found, &options, &style())
        })
    })
}

/// What a later stage says, below what was suspicious already.
fn failed(source: &Source, warnings: &[Diagnostic], error: impl Into<Error>) -> Failure {
    Failure::Model(source.clone(), [warnings, &error.into().diagnostics()].concat())
}

fn floquet_text(args: &args::Floquet) -> Result<Answer, Failure> {
    if let [first, second] = args.map.as_slice() {
        return chart::run(args, first, second);
    }
    let options = floquet::Options::default().digits(args.digits);
    let loaded = load_values(&args.model, Size::Any)?;
    loaded.answer(&args.model, "integrating the motion over a period", |_, model, _| {
        let found = floquet::floquet(&model, &options)?;
        Ok(if args.json {
            report::floquet_json(&model, &found, args.digits)
        } else {
            report::floquet_text(&model, &found, args.digits, &style())
        })
    })
}

/// Shapes to fewer digits would cost digits of the change.
const SHAPE_DIGITS: usize = 14;

fn amplitude_text(args: &args::Amplitude) -> Result<Answer, Failure> {
    let options = modes::Options::default().digits(args.digits.max(SHAPE_DIGITS));
    let loaded = load_values(&args.model, Size::Dense)?;
    loaded.answer(&args.model, "computing the modes and their change", |_, model, warnings| {
        amplitude::check(&model)?;
        let linearized = linearize::linearize(model)?;
        let normal = oscillation::normal_modes(&linearized, &options)?;
        let found = amplitude::amplitude(&linearized, &normal)?;
        warnings.extend(normal.warnings(&linearized));
        Ok(if args.json {
            report::amplitude_json(&linearized, &normal, &found, args.digits)
        } else {
            report::amplitude_text(&linearized, &normal, &found, args.digits, &style())
        })
    })
}

fn derive_text(args: &args::Derive) -> Result<Answer, Failure> {
    let loaded = load(&args.model, Size::Any)?;
    let known: Vec<&str> = loaded.model.parameters.iter().map(|p| p.name.as_str()).collect();
    let limits = args.limits.iter().map(|text| limit(text, &known, &loaded.model));
    let limits: Vec<(String, Constant)> = limits.collect::<Result<_, _>>()?;
    if let Some((name, _)) =
        limits.iter().enumerate().find_map(|(at, own)| limits[..at].iter().find(|other| other.0 == own.0))
    {
        return Err(wrong_request(
            format!("`{name}` has two limits"),
            "each parameter has one limit: run the command once for each",
        ));
    }
    let expansion = match args.expand.as_slice() {
        [name, power] => Some(expansion(name, power, &known, &loaded.model)?),
        _ => None,
    };
    let parts = args.only.as_ref().map_or_else(|| Parts::all().numbers(true), |only| Parts::of(only));
    let parts = parts.cubic(args.cubic).quartic(args.quartic);
    // Only a page has numbers, and none at other values than the limits.
    let parts = parts.numbers(parts.numbers && !args.json && limits.is_empty());
    let mut refused = None;
    let answer = loaded.answer(&args.model, "deriving the equations", |made, model, warnings| {
        let mut derivation = derive::derive(&model, &parts)?;
        if let Some(exceeded) = &derivation.left_out {
            if args.only.is_some() {
                return Err(linearize::LinearizeError::from(exceeded.clone()).into());
            }
            args.model.guard.accept();
            warnings.push(report::left_out(exceeded));
        }
        for (name, value) in &limits {
            if let Some(e) = derivation.sign_against(name, value) {
                refused = Some((name.clone(), e));
                return Ok(String::new());
            }
            derivation.limit(name, value.clone());
        }
        if let Some((name, order)) = &expansion {
            derivation.expand(name, *order);
        }
        derivation.only.clone_from(&args.only);
        if !args.json {
            derivation.put_given(&made.file, &made.settings, &model);
        }
        Ok(match &derivation {
            own if args.json => report::derive_json(own),
            own if args.latex => report::derive_latex(own, args.standalone),
            own if args.html => report::derive_html(own),
            own if args.typst => report::derive_typst(own),
            own => report::derive_text(own, &style().ascii(args.ascii)),
        })
    })?;
    let Some((name, e)) = refused else { return Ok(answer) };
    let what = format!("the formulas hold where `{e}` has the sign that it has at the values of the parameters");
    Err(wrong_request(
        what,
        &format!("give `{name}` a value from where the limit is to be taken: `--set {name}=VALUE`"),
    ))
}

/// A script for a shell.
fn completions(shell: Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "librate", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// A page for `man`.
fn manual(name: Option<&str>) -> Result<Answer, Failure> {
    let mut program = Cli::command();
    program.build();
    let command = match name {
        Some(name) => program.find_subcommand(name).ok_or_else(|| {
            let message = format!("there is no command `{}`", output::visible(name, false));
            wrong_request(message, "`librate --help` lists them")
        })?,
        None => &program,
    };
    let mut page = Vec::new();
    let rendered = clap_mangen::Man::new(command.clone()).render(&mut page);
    rendered.map_err(|error| fault(format!("the page can't be written: {error}")))?;
    Ok(Answer::new(String::from_utf8_lossy(&page).into_owned(), None))
}

/// Wrong words on the command line, and what is to be written in their place.
fn wrong_request(message: String, help: &str) -> Failure {
    Failure::Other { message, help: Some(help.to_owned()), status: USAGE }
}

/// Reads a range; `help` says how one is written.
fn range(text: &str, help: &str) -> Result<Range, Failure> {
    Range::parse(text).map_err(|error| wrong_request(error.to_string(), help))
}

/// Reads a number that is given as an expression.
fn constant(text: &str, help: &str) -> Result<Constant, Failure> {
    Constant::read(text).map_err(|reason| wrong_request(format!("can't read `{text}`: {reason}"), help))
}

/// The first few parameters there are, for one that there is not.
fn no_parameter(name: &str, known: &[&str], otherwise: &str) -> Failure {
    const MOST: usize = 8;
    let names: Vec<String> = known.iter().take(MOST).map(|name| format!("`{name}`")).collect();
    let help = match known.len() {
        0 => otherwise.to_owned(),
        1 => format!("the model has the parameter {}", names.join(", ")),
        2..=MOST => format!("the model has the parameters {}", names.join(", ")),
        _ => format!("the model has the parameters {}, ...", names.join(", ")),
    };
    Failure::Other { message: format!("there is no parameter `{name}`"), help: Some(help), status: FAULT }
}

/// `k=0` of `--limit`, with the value in SI.
fn limit(text: &str, known: &[&str], model: &Model) -> Result<(String, Constant), Failure> {
    let help = "a parameter and a number are needed: `--limit k=0`, `--limit k=pi/2`";
    let wrong = || wrong_request(format!("`{text}` is not a limit"), help);
    let (name, value) = text.split_once('=').ok_or_else(wrong)?;
    let parameter = symbol(name.trim(), known, help, model)?;
    let own = Constant::of_parameter(value, parameter, &model.pool);
    let own = own.map_err(|reason| wrong_request(format!("can't read `{value}`: {reason}"), help))?;
    Ok((parameter.name.clone(), own))
}

/// A parameter that formulas are made of.
fn symbol<'a>(name: &str, known: &[&str], help: &str, model: &'a Model) -> Result<&'a Parameter, Failure> {
    let found = model.parameters.iter().find(|own| own.name == name);
    let found = found.ok_or_else(|| no_parameter(name, known, help))?;
    if found.is_symbol(&model.pool) {
        return Ok(found);
    }
    let what = format!("`{name}` is not in the formulas: what it is defined as is written out there");
    Err(wrong_request(what, "limits and series are those of parameters that are given as numbers and set no ranges"))
}

/// `k 2` of `--expand`.
fn expansion(name: &str, power: &str, known: &[&str], model: &Model) -> Result<(String, u32), Failure> {
    let help = "a parameter and the highest power are needed: `--expand k 2`";
    symbol(name, known, help, model)?;
    match power.parse() {
        Ok(power) => Ok((name.to_owned(), power)),
        Err(_) => Err(wrong_request(format!("`{power}` is not a power"), help)),
    }
}

/// How many coordinates a command can do with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Size {
    Any,
    /// As many as dense matrices can have; more are refused before the energies are worked out.
    Dense,
}

/// Does what takes a while, with a sign of life.
fn during<T>(args: &ModelArgs, what: &'static str, work: impl FnOnce() -> T) -> T {
    let _shown = Progress::start(what, &args.guard);
    work()
}

/// What is set on the command line.
fn settings(args: &ModelArgs) -> Result<Settings, Failure> {
    let mut settings = Settings::new();
    for text in &args.settings {
        settings.add(text).map_err(|error| wrong_value(&error))?;
    }
    Ok(settings)
}

fn fault(message: String) -> Failure {
    Failure::Other { message, help: None, status: FAULT }
}

/// A value on the command line that the library refuses.
fn wrong_value<'a, E>(error: &'a E) -> Failure
where
    Diagnostic: From<&'a E>,
{
    let Diagnostic { message, help, .. } = error.into();
    Failure::Other { message, help, status: USAGE }
}

/// Parses a model and reads its tables; from then on its budget counts.
fn parsed(args: &ModelArgs, mut source: Source) -> Result<(Source, Made), Failure> {
    let settings = settings(args)?;
    let file = model::parse(&source.text, &settings).map_err(|all| Failure::Model(source.clone(), all))?;
    let tables = input::read_tables(args, &file, &mut source)?;
    let settings = settings.within(args.guard.begin(&source, tables.bytes()));
    Ok((source, Made { file, tables, settings }))
}

/// The model, and what is suspicious in it.
fn checked(
    args: &ModelArgs,
    file: &syntax::File,
    tables: &TableTexts,
    settings: &Settings,
    size: Size,
) -> Result<(Model, Vec<Diagnostic>), Error> {
    if size == Size::Dense {
        linearize::check_size(model::coordinate_count(file, tables, settings))?;
    }
    let model = match args.drawn {
        true => model::elaborate(file, tables, &settings.clone().with_points())?,
        false => model::elaborate(file, tables, settings)?,
    };
    let told = [model.warnings(file), librate::inertia::warnings(&model)].concat();
    Ok((model, told))
}

/// The checked model, and its text for messages.
fn load(args: &ModelArgs, size: Size) -> Result<Loaded, Failure> {
    load_text(args, input::read_model(&args.file)?, size)
}

/// The same of a text.
fn load_text(args: &ModelArgs, source: Source, size: Size) -> Result<Loaded, Failure> {
    let (source, made) = parsed(args, source)?;
    let read = || checked(args, &made.file, &made.tables, &made.settings, size);
    let (model, warnings) = during(args, "reading the model", read).map_err(|error| failed(&source, &[], error))?;
    Ok(Loaded { source, made, model, warnings })
}

/// As [`load`], for what takes parameters at their values and says so where these are uncertain.
fn load_values(args: &ModelArgs, size: Size) -> Result<Loaded, Failure> {
    let mut loaded = load(args, size)?;
    loaded.warnings.extend(sensitivity::ignored(&loaded.model));
    Ok(loaded)
}

fn style() -> Style {
    Style::default().color(output::has_color(&io::stdout())).width(terminal_width(&io::stdout()).unwrap_or(PLAIN_WIDTH))
}

fn terminal_width(stream: &impl IsTerminal) -> Option<usize> {
    if !stream.is_terminal() {
        return None;
    }
    let (terminal_size::Width(width), _) = terminal_size::terminal_size()?;
    Some(usize::from(width).max(40))
}

/// Writes diagnostics to standard error.
fn tell(source: &Source, all: &[Diagnostic], format: MessageFormat) {
    let stream = io::stderr();
    let text = match format {
        MessageFormat::Json => messages::diagnostics(source, all),
        MessageFormat::Text => {
            let width = terminal_width(&stream).unwrap_or(PLAIN_MESSAGE_WIDTH);
            let style = Style::default().color(output::has_color(&stream)).width(width);
            report::diagnostics_text(&source.shown(), &source.text, all, &style)
        }
    };
    output::write_messages(&text);
}

/// Writes what went wrong to standard error; gives the exit status.
fn complain(failure: Failure, format: MessageFormat) -> u8 {
    match failure {
        Failure::Model(source, all) => {
            tell(&source, &all, format);
            FAULT
        }
        Failure::Other { message, help, status } => {
            let text = match format {
                MessageFormat::Json => messages::message(&message, help.as_deref()),
                MessageFormat::Text => {
                    let style = Style::default().color(output::has_color(&io::stderr()));
                    report::message_text(&message, help.as_deref(), &style)
                }
            };
            output::write_messages(&text);
            status
        }
        Failure::Usage(error) => usage(&error),
        Failure::BrokenPipe => 0,
    }
}
