//! What can be typed.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::LazyLock;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use librate::budget::Limits;
use librate::derive::CHAPTERS;
use librate::linearize;
use librate::model::Constant;
use librate::number::Number;
use librate::report::{FrequencyUnit, Language, SweepView};

use super::equilibria::Equilibria;
use super::guard::Guard;
use super::response::ResponseArgs;
use super::sweep::{Part, part};
use super::watch::Watch;

/// What a command does, and its examples.
fn help(command: &str) -> [String; 2] {
    // Each start asks for all of them.
    static ALL: LazyLock<Vec<&str>> = LazyLock::new(|| include_str!("help.txt").split("\n== ").collect());
    let own = ALL.iter().find_map(|own| own.strip_prefix(command)?.strip_prefix('\n')).unwrap_or_default();
    let (about, examples) = own.split_once("---\n").unwrap_or((own, ""));
    [about, examples].map(flowing)
}

fn about(command: &str) -> String {
    let [about, _] = help(command);
    about
}

fn examples(command: &str) -> String {
    let [_, examples] = help(command);
    examples
}

/// Paragraphs without the line breaks that they have in the file: they are broken as the terminal is wide. What is indented and
/// what stands behind a colon keeps its lines.
fn flowing(text: &str) -> String {
    let mut out = String::new();
    let mut before = "";
    for line in text.lines() {
        let apart = [before, line].iter().any(|own| own.is_empty() || own.starts_with(' '));
        if !out.is_empty() {
            out.push(if apart || before.ends_with(':') { '\n' } else { ' ' });
        }
        out.push_str(line);
        before = line;
    }
    out
}

/// The option that reports how modes are computed.
pub(super) fn shown(verbose: Arg) -> Arg {
    verbose.hide(false)
}

/// How a command is called that takes one of several things: a line for each, as no line of usages is ever broken.
fn usage(command: &str, ways: &[&str]) -> String {
    let lines: Vec<String> = ways.iter().map(|way| format!("librate {command} [OPTIONS] {way} <FILE>")).collect();
    lines.join("\n       ")
}

const PERIODS: [&str; 3] = ["--amplitude <A>", "--energy <E>", "--over <NAME=a..b:count>"];
const MOTIONS: [&str; 3] = ["--start <VALUES>", "--start-table <FILE.csv>", "--mode <NUMBER>"];
const EXPORTS: [&str; 4] = ["--matrix-market -o <PATH>", "--npz -o <PATH>", "--petsc -o <PATH>", "--code <LANGUAGE>"];

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "librate", version, about = about("librate"), after_help = examples("librate"))]
#[command(arg_required_else_help = true, disable_help_subcommand = true, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// The format of errors and warnings
    #[arg(long, global = true, value_enum, value_name = "FORMAT", default_value_t)]
    pub(crate) message_format: MessageFormat,
    /// Time and memory for the computation: `60s`, `4GB`, `60s,4GB`, `none`; 10 s and 1 GB for a model of up to 8 kB, more in
    /// proportion for a longer one
    #[arg(long, global = true, value_name = "LIMITS", allow_hyphen_values = true, value_parser = Limits::parse)]
    pub(crate) budget: Option<Limits>,
}

impl Command {
    /// What the command reads a model by.
    pub(crate) fn model(&mut self) -> Option<&mut ModelArgs> {
        match self {
            Self::Modes(args) => Some(&mut args.model),
            Self::Sweep(args) => Some(&mut args.model),
            Self::Period(args) => Some(&mut args.model),
            Self::Amplitude(args) => Some(&mut args.model),
            Self::Sensitivity(args) => Some(&mut args.model),
            Self::Floquet(args) => Some(&mut args.model),
            Self::Motion(args) => Some(&mut args.model),
            Self::Plot { what } => Some(what.model()),
            Self::Show(args) => Some(&mut args.model),
            Self::Response(args) => Some(&mut args.model),
            Self::Equilibria(args) => Some(&mut args.model),
            Self::Inertia(args) => Some(&mut args.model),
            Self::Export(args) => Some(&mut args.model),
            Self::Check(args) => Some(&mut args.model),
            Self::Derive(args) => Some(&mut args.model),
            _ => None,
        }
    }
}

/// The format of errors and warnings on standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    /// With the lines of the model, for people
    #[default]
    Text,
    /// One JSON object per line, for programs
    Json,
}

impl MessageFormat {
    /// A line that is neither an error nor a warning.
    pub(crate) fn note(self, text: &str) -> String {
        match self {
            Self::Text => format!("{text}\n"),
            Self::Json => super::messages::note(text),
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Frequencies and mode shapes about the equilibrium
    #[command(long_about = about("modes"), after_help = examples("modes"))]
    Modes(Modes),
    /// Frequencies over a range of a parameter, as CSV
    #[command(long_about = about("sweep"), after_help = examples("sweep"))]
    Sweep(Sweep),
    /// The exact period of one coordinate at finite amplitude
    #[command(override_usage = usage("period", &PERIODS), long_about = about("period"), after_help = examples("period"))]
    Period(Period),
    /// How the frequency of each mode changes with its amplitude
    #[command(long_about = about("amplitude"))]
    Amplitude(Amplitude),
    /// How much each frequency changes with each parameter
    #[command(long_about = about("sensitivity"))]
    Sensitivity(Sensitivity),
    /// Stability of a periodically driven model: Floquet multipliers
    #[command(long_about = about("floquet"), after_help = examples("floquet"))]
    Floquet(Floquet),
    /// The steady response to a harmonic force, as CSV
    #[command(long_about = about("response"), after_help = examples("response"))]
    Response(ResponseArgs),
    /// Time evolution, as CSV
    #[command(override_usage = usage("motion", &MOTIONS), long_about = about("motion"), after_help = examples("motion"))]
    Motion(Motion),
    /// A picture of the result of another command, as SVG
    #[command(long_about = about("plot"), after_help = examples("plot"))]
    Plot {
        /// What is drawn
        #[command(subcommand)]
        what: Plotted,
    },
    /// A page with the modes in motion, for a browser
    #[command(long_about = about("show"), after_help = examples("show"))]
    Show(Show),
    /// Every equilibrium in a box of coordinates
    #[command(long_about = about("equilibria"), after_help = examples("equilibria"))]
    Equilibria(Equilibria),
    /// Principal moments and axes of inertia: of a model's tensors, of points, of a mesh
    #[command(long_about = about("inertia"), after_help = examples("inertia"))]
    Inertia(Inertia),
    /// The matrices as files for other programs, the equations as source code
    #[command(override_usage = usage("export", &EXPORTS), long_about = about("export"), after_help = examples("export"))]
    Export(Export),
    /// Check a model file without computing anything
    #[command(long_about = about("check"))]
    Check(Check),
    /// Lagrange's equations, mass and stiffness matrices in symbols
    #[command(long_about = about("derive"), after_help = examples("derive"))]
    Derive(Derive),
    /// What the code of an error or warning means, with an example
    #[command(long_about = about("explain"))]
    Explain {
        /// The code printed after `error` or `warning`: `E0201`; without one, all codes
        #[arg(value_name = "CODE")]
        code: Option<String>,
    },
    /// Completions for a shell, to be saved in the shell's completion folder
    #[command(after_help = examples("completions"))]
    Completions {
        /// The shell
        #[arg(value_enum)]
        shell: Shell,
    },
    /// A manual page, for man
    #[command(after_help = examples("man"))]
    Man {
        /// The page of a command, such as `modes`; by default that of librate
        #[arg(value_name = "COMMAND")]
        command: Option<String>,
    },
    /// Put model files in canonical layout, comments kept
    #[command(long_about = about("fmt"), after_help = examples("fmt"))]
    Fmt(Fmt),
    /// Run a command again each time its model is saved
    #[command(long_about = about("watch"), after_help = examples("watch"))]
    Watch(Watch),
    /// Enter a model line by line and see how its frequencies move
    #[command(long_about = about("repl"), after_help = examples("repl"))]
    Repl {
        /// A model to begin with
        #[arg(value_name = "FILE")]
        file: Option<PathBuf>,
    },
    /// Language server for editors: errors while you type, values, completions, renaming
    #[command(long_about = about("lsp"))]
    Lsp,
}

#[derive(Debug, Args)]
pub(crate) struct ModelArgs {
    /// The model file; `-` reads standard input
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Give a parameter a value: `k=8`, `m[2]=3/2`, `N=50`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Also permit tables in or below this folder, not only in that of the model; may be repeated
    #[arg(long = "allow-path", value_name = "DIR")]
    pub(crate) allow_paths: Vec<PathBuf>,
    /// Report on standard error which solver is chosen, and why
    // Shown where there is something to report.
    #[arg(long, hide = true)]
    pub(crate) verbose: bool,
    /// Watches over the budget.
    #[arg(skip)]
    pub(crate) guard: Guard,
    /// Whether a picture is wanted in place of text.
    #[arg(skip)]
    pub(crate) drawn: bool,
}

#[derive(Debug, Args)]
#[command(mut_arg("verbose", shown))]
pub(crate) struct Show {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Only the K lowest modes, in the order of `modes`
    #[arg(long, value_name = "K", value_parser = positive)]
    pub(crate) lowest: Option<usize>,
    /// Add a slider for this parameter (may be given twice); between its values modes are interpolated
    #[arg(long, value_name = "NAME=a..b:count")]
    pub(crate) over: Vec<String>,
    /// Significant digits of the frequencies, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// Write the page to a file instead of standard output
    #[arg(short, long, value_name = "FILE.html")]
    pub(crate) output: Option<PathBuf>,
    /// Let the page look for a newer one beside it, as `watch` writes them
    #[arg(long, hide = true, requires = "output")]
    pub(crate) live: bool,
}

/// The commands whose answers can be drawn.
#[derive(Debug, Subcommand)]
pub(crate) enum Plotted {
    /// The shape of each mode
    Modes(Drawn<Modes>),
    /// The frequency of each mode, over the wave number in a ring
    Spectrum(Drawn<Modes>),
    /// Frequencies over a parameter, each mode followed by its shape
    Sweep(DrawnSweep),
    /// Amplitude and phase of the steady response over the frequency
    Response(Drawn<ResponseArgs>),
    /// The period over the amplitude or the energy
    #[command(override_usage = usage("plot period", &PERIODS))]
    Period(Drawn<Period>),
    /// The stability chart over two parameters
    Floquet(Drawn<Floquet>),
    /// The coordinates over the time
    #[command(override_usage = usage("plot motion", &MOTIONS))]
    Motion(Drawn<Motion>),
    /// The equilibria in a box, or their branches over a parameter
    Equilibria(Drawn<Equilibria>),
}

impl Plotted {
    fn model(&mut self) -> &mut ModelArgs {
        match self {
            Self::Modes(own) | Self::Spectrum(own) => &mut own.args.model,
            Self::Sweep(own) => &mut own.drawn.args.model,
            Self::Response(own) => &mut own.args.model,
            Self::Period(own) => &mut own.args.model,
            Self::Floquet(own) => &mut own.args.model,
            Self::Motion(own) => &mut own.args.model,
            Self::Equilibria(own) => &mut own.args.model,
        }
    }
}

/// A command with a picture for its answer.
#[derive(Debug, Args)]
#[command(mut_arg("json", |json| json.hide(true)))]
pub(crate) struct Drawn<A: Args> {
    #[command(flatten)]
    pub(crate) args: A,
    /// Write the picture to a file instead of standard output
    // Without a long name: `--output` is a coordinate of `response`.
    #[arg(short, value_name = "FILE.svg", conflicts_with = "json")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(mut_arg("verbose", shown))]
pub(crate) struct Modes {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Only the K lowest modes, in the order printed
    #[arg(long, value_name = "K", value_parser = positive)]
    pub(crate) lowest: Option<usize>,
    /// Only the --count modes nearest to this frequency in rad/s, in the usual order
    #[arg(long, value_name = "OMEGA", value_parser = frequency, requires = "count", conflicts_with = "lowest")]
    pub(crate) near: Option<f64>,
    /// Bounds for mode shapes computed by another program: a NumPy array `vectors`, one column per mode
    #[arg(long, value_name = "FILE.npz", conflicts_with_all = ["lowest", "near"])]
    pub(crate) certify: Option<PathBuf>,
    /// With --near: how many modes
    #[arg(long, value_name = "K", value_parser = positive, requires = "near")]
    pub(crate) count: Option<usize>,
    /// Significant digits of the frequencies, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// Frequencies only, without mode shapes
    #[arg(long)]
    pub(crate) no_vectors: bool,
    /// Normalisation of the shapes: x^T M x = 1, or largest component 1
    #[arg(long, value_parser = ["mass", "max"], value_name = "LENGTH", default_value = "mass")]
    pub(crate) normalize: String,
    /// Add a column of frequencies in this unit to the text
    #[arg(long, value_parser = frequency_unit(), value_name = "UNIT")]
    pub(crate) unit: Option<FrequencyUnit>,
    /// Threads for some modes of a large model; by default one per core
    #[arg(long, value_name = "COUNT", value_parser = positive)]
    pub(crate) threads: Option<usize>,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// A language of source code.
fn language() -> impl TypedValueParser<Value = Language> {
    let about = ["C, and C++", "Rust", "Python 3, without any package"];
    let values = Language::ALL.into_iter().zip(about).map(|(own, about)| PossibleValue::new(own.as_str()).help(about));
    let parser = PossibleValuesParser::new(values);
    parser.map(|name| Language::ALL.into_iter().find(|own| own.as_str() == name).unwrap_or(Language::C))
}

/// A unit of frequencies.
fn frequency_unit() -> impl TypedValueParser<Value = FrequencyUnit> {
    let parser = PossibleValuesParser::new(FrequencyUnit::ALL.map(FrequencyUnit::as_str));
    parser.map(|name| FrequencyUnit::ALL.into_iter().find(|unit| unit.as_str() == name).unwrap_or(FrequencyUnit::Hertz))
}

#[derive(Debug, Args)]
#[command(mut_arg("verbose", shown))]
pub(crate) struct Sweep {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The parameter, its first and last value and the number of values: `k=0..8:17`
    #[arg(long, value_name = "NAME=a..b:count")]
    pub(crate) over: String,
    /// Only the K lowest modes, in the order of `modes`
    #[arg(long, value_name = "K", value_parser = positive)]
    pub(crate) lowest: Option<usize>,
    /// Significant digits of the frequencies, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// Columns for growth, even where it is 0
    #[arg(long, conflicts_with = "json")]
    pub(crate) growth: bool,
    /// The i-th of n parts of the values, for job arrays: `2/10`; part 1 has the header
    #[arg(long, value_name = "I/N", value_parser = part, conflicts_with = "json")]
    pub(crate) part: Option<Part>,
    /// Write the table to a file, or continue an interrupted one
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub(crate) resume: Option<PathBuf>,
    /// Threads; by default as many as there are cores
    #[arg(long, value_name = "COUNT", value_parser = positive)]
    pub(crate) threads: Option<usize>,
    /// With --json: without mode shapes
    #[arg(long, requires = "json")]
    pub(crate) no_vectors: bool,
    /// JSON instead of CSV: an array with the modes at each value
    #[arg(long)]
    pub(crate) json: bool,
    #[arg(skip)]
    pub(crate) view: SweepView,
}

/// A sweep that is drawn.
#[derive(Debug, Args)]
pub(crate) struct DrawnSweep {
    #[command(flatten)]
    pub(crate) drawn: Drawn<Sweep>,
    /// For a rotation rate: a line for each of these multiples, `1,2` (Campbell diagram)
    #[arg(long, value_name = "ORDERS", value_delimiter = ',', value_parser = frequency)]
    pub(crate) orders: Vec<f64>,
    /// Growth against frequency instead of both over the parameter
    #[arg(long, conflicts_with = "orders")]
    pub(crate) root_locus: bool,
}

#[derive(Debug, Args)]
#[group(id = "motion", args = ["amplitude", "energy", "over"], required = true, multiple = false)]
pub(crate) struct Period {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The upper turning point, as a distance from the equilibrium: `1/2`, `pi - 1e-6`
    #[arg(long, value_name = "A", allow_hyphen_values = true)]
    pub(crate) amplitude: Option<String>,
    /// The energy of the motion, in SI
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    pub(crate) energy: Option<String>,
    /// A curve, as CSV: `amplitude=1/10..3:30` or `energy=0.1..5:50`
    #[arg(long, value_name = "NAME=a..b:count")]
    pub(crate) over: Option<String>,
    /// Significant digits of the period, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Amplitude {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Significant digits of the frequencies, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(mut_arg("verbose", shown))]
pub(crate) struct Sensitivity {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Only the K lowest modes, in the order of `modes`
    #[arg(long, value_name = "K", value_parser = positive)]
    pub(crate) lowest: Option<usize>,
    /// Significant digits of the frequencies, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Floquet {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A stability chart over two parameters, as CSV: `a=0..10:400 q=0..5:200`
    #[arg(long, num_args = 2, action = ArgAction::Set, value_names = ["NAME=a..b:n", "NAME=c..d:m"], conflicts_with = "json")]
    pub(crate) map: Vec<String>,
    /// With --map: the borders between stable and unstable neighbours, as CSV
    #[arg(long, value_name = "FILE", requires = "map")]
    pub(crate) borders: Option<PathBuf>,
    /// Threads for a chart; by default as many as there are cores
    #[arg(long, value_name = "COUNT", requires = "map", value_parser = positive)]
    pub(crate) threads: Option<usize>,
    /// Significant digits of the multipliers, up to 30
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<DOUBLE_DOUBLE_DIGITS>)]
    pub(crate) digits: usize,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Inertia {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// For a mesh: mass per volume; 1 if neither this nor --mass is given
    #[arg(long, value_name = "RHO", conflicts_with = "mass")]
    pub(crate) density: Option<String>,
    /// For a mesh: the mass of the whole body
    #[arg(long, value_name = "M")]
    pub(crate) mass: Option<String>,
    /// Significant digits, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[group(id = "beginning", args = ["start", "start_table", "mode"], required = true, multiple = false)]
pub(crate) struct Motion {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Initial values: `phi[1]=0.1, phi[1]'=0`; coordinates left out start at rest in the equilibrium
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    pub(crate) start: Option<String>,
    /// A start in each row of a table, with columns named as coordinates and velocities; results have a column `start`
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["linear", "json"])]
    pub(crate) start_table: Option<PathBuf>,
    /// With --start-table: threads, by default as many as there are cores
    #[arg(long, value_name = "COUNT", value_parser = positive, requires = "start_table")]
    pub(crate) threads: Option<usize>,
    /// Start with a mode, by its number in `modes`
    #[arg(long, value_name = "NUMBER", value_parser = positive, requires = "amplitude")]
    pub(crate) mode: Option<usize>,
    /// With --mode: the displacement of its largest component
    #[arg(long, value_name = "A", allow_hyphen_values = true, requires = "mode", conflicts_with = "start")]
    pub(crate) amplitude: Option<String>,
    /// The time at which the table ends
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, required_unless_present = "at")]
    pub(crate) until: Option<String>,
    /// The number of rows, from t = 0 to the end; by default 101, for a picture 601
    #[arg(long, value_name = "N", value_parser = positive)]
    pub(crate) samples: Option<usize>,
    /// A row for each time in the column `t` of a table, in its order
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["until", "samples", "linear"])]
    pub(crate) at: Option<PathBuf>,
    /// Significant digits of the table, up to 30
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<DOUBLE_DOUBLE_DIGITS>, conflicts_with = "tolerance")]
    pub(crate) digits: usize,
    /// Prove every digit: rigorous bounds for every value, where possible
    #[arg(long, conflicts_with_all = ["tolerance", "linear"])]
    pub(crate) proved: bool,
    /// Integrate once in double precision, with this truncation error per step
    #[arg(long, value_name = "EPS", value_parser = tolerance)]
    pub(crate) tolerance: Option<f64>,
    /// Add the superposition of modes in further columns
    #[arg(long)]
    pub(crate) linear: bool,
    /// JSON instead of CSV, with the error of each value
    #[arg(long, conflicts_with = "linear")]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[group(id = "files", args = ["matrix_market", "npz", "petsc", "code"], required = true, multiple = false)]
pub(crate) struct Export {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// M.mtx, K.mtx and, where the model has them, G, C and N in a folder, as text
    #[arg(long)]
    pub(crate) matrix_market: bool,
    /// All in one NumPy archive
    #[arg(long)]
    pub(crate) npz: bool,
    /// M, K and, where the model has them, G, C and N in a folder, in PETSc's binary format
    #[arg(long)]
    pub(crate) petsc: bool,
    /// Functions for M, K and the accelerations, as source code
    #[arg(long, value_parser = language(), value_name = "LANGUAGE")]
    pub(crate) code: Option<Language>,
    /// The folder, created if necessary, or the file for --npz and --code; code goes to standard output by default
    #[arg(short, long, value_name = "PATH", required_unless_present = "code")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Make the corrections that are certain enough, in the file itself, and show what changed
    #[arg(long)]
    pub(crate) fix: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Derive {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Also solve blocks of three for their frequencies, by Viète's formula
    #[arg(long)]
    pub(crate) cubic: bool,
    /// Also solve blocks of three and of four, the latter by Ferrari's formula
    #[arg(long)]
    pub(crate) quartic: bool,
    /// Closed forms in the limit of a parameter: `k=0`; may be repeated
    #[arg(long = "limit", value_name = "NAME=VALUE")]
    pub(crate) limits: Vec<String>,
    /// Closed forms as a series in a small parameter, up to a power of it: `k 2`
    #[arg(long, num_args = 2, action = ArgAction::Set, value_names = ["NAME", "POWER"])]
    pub(crate) expand: Vec<String>,
    /// Only these chapters, with commas: `equations,mass`
    #[arg(long, value_name = "CHAPTERS", value_delimiter = ',', value_parser = PossibleValuesParser::new(CHAPTERS))]
    pub(crate) only: Option<Vec<String>>,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// LaTeX instead of text, for a document that has the package amsmath
    #[arg(long, conflicts_with = "json")]
    pub(crate) latex: bool,
    /// HTML with MathML instead of text, for a web page
    #[arg(long, conflicts_with_all = ["json", "latex"])]
    pub(crate) html: bool,
    /// Typst instead of text: a document, or a part of one
    #[arg(long, conflicts_with_all = ["json", "latex", "html"])]
    pub(crate) typst: bool,
    /// Formulas in the model language, without Unicode letters and fractions
    #[arg(long, conflicts_with_all = ["json", "latex", "html", "typst"])]
    pub(crate) ascii: bool,
    /// With --latex: a whole document
    #[arg(long, requires = "latex", conflicts_with_all = ["json", "html", "typst", "ascii"])]
    pub(crate) standalone: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Fmt {
    /// Model files, rewritten in place; `-` reads standard input and prints
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Write nothing; show what would change and exit with 1 if anything would
    #[arg(long)]
    pub(crate) check: bool,
}

/// More digits than this are not certified, and their bounds would leave the range of doubles.
const MOST_DIGITS: usize = 250;

/// As many digits as a double-double holds.
pub(crate) const DOUBLE_DOUBLE_DIGITS: usize = 30;

pub(crate) fn positive(text: &str) -> Result<usize, String> {
    // 1e6 is one too.
    let number = Number::parse(text).and_then(|number| number.to_i64());
    let count = number.and_then(|number| usize::try_from(number).ok()).filter(|count| *count > 0);
    count.ok_or_else(|| "a whole number, 1 or more, is needed".to_owned())
}

/// What was typed. A negative number behind an option is its value, so that the option says what it takes.
pub(crate) fn parsed(typed: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> Result<Cli, clap::Error> {
    let mut program = with_negative_numbers(Cli::command());
    let mut matches = program.try_get_matches_from_mut(typed)?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut program))
}

fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let options = command.mut_args(|own| {
        let takes_values = own.get_long().is_some() && own.get_action().takes_values();
        if takes_values && !own.is_allow_hyphen_values_set() { own.allow_negative_numbers(true) } else { own }
    });
    options.mut_subcommands(with_negative_numbers)
}

/// What a constant expression is worth.
fn worth(text: &str) -> Option<f64> {
    let constant = Constant::parse(text).ok()?;
    linearize::constant(constant.pool(), constant.value()).map(|value| value.mid_f64())
}

fn frequency(text: &str) -> Result<f64, String> {
    let omega = worth(text).filter(|omega| (0.0..1e150).contains(omega));
    omega.ok_or("a frequency in rad/s, 0 or more, is needed".to_owned())
}

/// A number of digits, up to so many.
pub(crate) fn digits<const MOST: usize>(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if (1..=MOST).contains(&count) => Ok(count),
        Ok(_) | Err(_) => Err(format!("a whole number from 1 to {MOST} is needed")),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value = worth(text).filter(|value| (1e-17..=0.1).contains(value));
    value.ok_or("a number from 1e-17 to 0.1 is needed".to_owned())
}
