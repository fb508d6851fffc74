//! What can be typed.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use librate::budget::Limits;
use librate::derive::CHAPTERS;
use librate::linearize;
use librate::model::Constant;
use librate::number::Number;
use librate::report::{FrequencyUnit, SweepView};

use super::equilibria::{self, Equilibria};
use super::export::CodeLanguage;
use super::guard::Guard;
use super::repl::{self, Repl};
use super::response::{RESPONSE, RESPONSE_EXAMPLE, ResponseArgs};
use super::sweep::{Part, part};
use super::watch::{self, Watch};

/// Paragraphs without the line breaks that they have here: they are broken as the terminal is wide. What is indented and
/// what stands behind a colon keeps its lines.
fn flowing(text: &str) -> String {
    let mut out = String::new();
    let mut before = "";
    for line in text.lines() {
        let apart = [before, line];
        let apart = apart.iter().any(|own| own.is_empty() || own.starts_with(' '));
        if !out.is_empty() {
            out.push(if apart || before.ends_with(':') { '\n' } else { ' ' });
        }
        out.push_str(line);
        before = line;
    }
    out
}

/// How a command is called that takes one of several things: a line for each, as no line of usages is ever broken.
fn usage(command: &str, ways: &[&str]) -> String {
    let lines: Vec<String> = ways.iter().map(|way| format!("librate {command} [OPTIONS] {way} <FILE>")).collect();
    lines.join("\n       ")
}

const PERIODS: [&str; 3] = ["--amplitude <A>", "--energy <E>", "--over <NAME=a..b:count>"];
const MOTIONS: [&str; 3] = ["--start <VALUES>", "--start-table <FILE.csv>", "--mode <NUMBER>"];
const EXPORTS: [&str; 4] = ["--matrix-market -o <PATH>", "--npz -o <PATH>", "--petsc -o <PATH>", "--code <LANGUAGE>"];

const ABOUT: &str = "\
Small oscillations: write T and V as on the blackboard, get normal frequencies in which every printed
digit is right.";

const EXAMPLE: &str = "\
A model file, three_pendulums.lag:

    model three_pendulums

    param g : m/s^2 = 9.81
    param L : m     = 0.3
    param m[1..3] : kg = [1, 2, 1]
    param l[1..3] : m  = 1  # one value fills the family
    param k : N/m = 4

    coord phi[1..3] : rad

    T = sum(i in 1..3, 1/2*m[i]*l[i]^2*phi[i]'^2)
    V = sum(i in 1..3, m[i]*g*l[i]*(1 - cos(phi[i])))
      + k*L^2/2*((phi[2] - phi[1])^2 + (phi[3] - phi[2])^2)

Commands:

    librate check three_pendulums.lag                 is the model valid?
    librate derive three_pendulums.lag                equations, M and K in symbols
    librate modes three_pendulums.lag                 frequencies and mode shapes
    librate modes three_pendulums.lag --set k=8       the same with stronger springs
    librate sweep three_pendulums.lag --over k=0..8:17
                                                      frequencies for a range of springs
    librate period pendulum.lag --amplitude 2         the exact period of one coordinate
    librate explain E0201                             more about an error, by its code
    librate fmt three_pendulums.lag                   put the file in canonical layout

`librate COMMAND --help` has details. Exit status: 0 success, 1 an error in the model or the
request, 2 wrong usage.";

const MODES: &str = "\
Frequencies and mode shapes about the equilibrium.

The equilibrium is the one given in the file with `equilibrium`, else all coordinates 0 if no force
acts there, else it is searched for, starting at `guess`. Unstable modes come first, then zero modes,
then oscillations by increasing omega. Only digits that are certain are printed; `bound` bounds the
error of omega and growth as printed.";

const MODES_EXAMPLE: &str = "\
Examples:
    librate modes models/water.lag --digits 15
    librate modes models/three_pendulums.lag --set k12=6 --set 'm[1]=3/2' --lowest 2
    librate modes models/chain_walls.lag --json --no-vectors
    echo \"coord x  T = 1/2*x'^2  V = 2*x^2\" | librate modes -";

const SWEEP: &str = "\
Frequencies over a range of a parameter, as CSV: a line for each value, with the parameter, omega1, omega2, …
and, where some growth isn't 0, growth1, … At each value the equilibrium is determined anew, as in
`modes`. Where there are no modes, cells are empty, and the reason is reported on standard error.

Values are computed on all cores, and lines are written as they are made. --resume keeps them in a file
and goes on with one that was interrupted; --part computes the i-th of n parts, whose outputs one after the other are the
whole table. The time of --budget is that for a single value.";

const SWEEP_EXAMPLE: &str = "\
Examples:
    librate sweep models/three_pendulums.lag --over k12=0..8:17
    librate sweep models/bead_on_hoop.lag --over 'W=sqrt(50)..10:51' --digits 15
    librate sweep models/three_pendulums.lag --over 'm[2]=1..4:4' --json
    librate sweep models/chain_walls.lag --over k=1..2:1000 --part 3/20 --resume part3.csv";

const PERIOD: &str = "\
The exact period of a model with one coordinate at finite amplitude, from energy conservation; the mass may depend
on the position. The amplitude is the distance of the upper turning point from the equilibrium, in the unit of the
coordinate; the energy is E = T + V with V as the model writes it. Above the barriers of a potential that is periodic
in the coordinate the motion is a rotation, and its period is the time in which the coordinate advances by the period
of V.";

const PERIOD_EXAMPLE: &str = "\
Examples:
    librate period models/simple_pendulum.lag --amplitude 'pi/2'
    librate period models/simple_pendulum.lag --amplitude 'pi - 1e-6' --digits 20
    librate period models/double_well.lag --energy 3 --json
    librate plot period models/simple_pendulum.lag --over 'amplitude=1/10..3:30' -o period.svg";

const SENSITIVITY: &str = "\
d omega / d parameter for every mode and every parameter that has a value: how much a frequency changes with a
parameter, including the shift of the equilibrium. Parameters that are defined by others have no entry of their own; their
effect is included in that of the others. Where frequencies coincide, the derivatives are those of the modes into which
they split.";

const FLOQUET: &str = "\
Stability of a periodically driven model: its Floquet multipliers, the factors by which displacements are
multiplied in a period of the drive, with bounds.

They belong to the equilibrium given in the file with `equilibrium`, else to the point 0 if no force acts
there at any time, else to the periodic motion near `guess`, which is searched for. That a multiplier lies on the unit
circle is concluded from symmetry, never from its numerical value; what the bounds do not decide is reported as
undecided. The file gives the period with `period`.";

const FLOQUET_EXAMPLE: &str = "\
Examples:
    librate floquet models/child_on_swing.lag
    librate floquet models/mathieu.lag --set q=0.5 --digits 15
    librate floquet models/mathieu.lag --json
    librate plot floquet models/mathieu.lag --map a=-2..10:60 q=0..10:60 -o chart.svg

A chart has a line for each point, the second parameter varying faster: both parameters, stable (true or false, empty
where there is no periodic motion), and growth_rate in 1/s. It is computed in double precision, on all cores. --borders
writes the points on the lines of the grid where stable and unstable meet.";

const CHECK: &str = "\
Checks a model file: its syntax, names, ranges, shapes and tables, without computing anything.";

const PLOT: &str = "\
A picture of what the other commands answer, as SVG: mode shapes, frequencies over a parameter, responses, periods, motions, stability charts. \
The arguments are those of the command. Pictures scale, text in them is text, and they follow the reader's light or dark colours.";
const PLOT_EXAMPLE: &str = "\
Examples:
    librate plot modes models/three_pendulums.lag -o modes.svg
    librate plot sweep models/three_pendulums_unequal.lag --over k12=0..8:81 -o sweep.svg
    librate plot sweep models/whirling_shaft_above.lag --over W=0..60:61 --orders 1";
const SHOW: &str = "\
One HTML page that needs nothing else: the model, its modes in motion, their digits, and the derivation. Points are drawn where \
the model has them: vectors whose velocities are used (`let r = [...]`), coordinates that are read as vectors (`coord r[1..N, 1..3]`), \
and what is named x, y and z; rods are where distances can't change, springs where a term of V couples two points. Otherwise each \
coordinate is a bar. With `--over` a slider moves a parameter: modes are followed by their shapes from one of its values to the next.";
const SHOW_EXAMPLE: &str = "\
Examples:
    librate show models/double_pendulum.lag -o page.html
    librate show models/water.lag -o water.html
    librate show models/double_pendulum.lag --over 'l[2]=0.3..3:9' -o l.html";
const INERTIA: &str = "\
Principal moments and axes of inertia, every printed digit right. FILE is one of three, recognised by
the extension of its name (.lag, .csv, .stl) or else by its first bytes:

A model: all its named tensors, that is each `let` which is a symmetric 3 x 3 matrix of parameters and
numbers alone. T and coordinates may be missing.

A table of points: CSV with a header that has the columns m (or mass), x, y and z. Mass, centre of mass
and the tensor about it are printed, too.

A mesh: STL, binary or ASCII, a closed surface whose triangles are ordered counterclockwise seen from
outside, surfaces of cavities clockwise. The volume is printed, too. Coordinates are the
single-precision numbers of the file, and results are in its units.";

const INERTIA_EXAMPLE: &str = "\
Examples:
    librate inertia models/box_on_gimbals.lag --set a=0.5
    librate inertia models/data/body_points.csv --digits 15
    librate inertia models/data/box_with_cavity.stl --density 2700 --json";

const EXPORT: &str = "\
The matrices of M q'' + (G + C) q' + (K + N) q = 0 about the equilibrium, for other programs: mass and
stiffness M and K, and what there is of the gyroscopic, damping and circulatory matrices G, C and N.
Entries are doubles, in SI, those that are 0 left out. Rows are the coordinates in the order of the
model; under constraints those that the others follow.

--matrix-market writes M.mtx, K.mtx and so on: a triangle of what is symmetric, numbers as the
shortest decimals that read back to the same doubles. --npz writes one archive for NumPy, in which
`M_data`, `M_indices`, `M_indptr` and `M_shape` are M as scipy.sparse.csr_array((data, indices,
indptr), shape) takes it, K and the others likewise. --petsc writes M, K and so on in PETSc's binary
format.

--code writes functions of doubles: librate_defaults(p), the parameters; librate_equilibrium(p, q);
librate_mass(p, M), librate_stiffness(p, K) and what there is of librate_damping, librate_gyroscopic
and librate_circulatory there, row by row; and of the full equations of motion librate_mass_matrix(t,
q, v, p, M), librate_forces(t, q, v, p, f), librate_acceleration(t, q, v, p, a) and librate_energy(t,
q, v, p). In Python they are PARAMETERS, equilibrium(p), mass(p) and so on, with p a dict or a list.";

const EXPORT_EXAMPLE: &str = "\
Examples:
    librate export models/chain_walls.lag --set N=1000 --matrix-market -o chain
    librate export models/response/whirling_rotor.lag --npz -o rotor.npz
    librate export models/chain_walls.lag --petsc -o chain
    librate export models/double_pendulum.lag --code c -o double_pendulum.c";

const EXPLAIN: &str = "\
More about a kind of error or warning: what is wrong, why it matters, a model with it and one
without. Without a code, the list of all codes.";

const COMPLETIONS_EXAMPLE: &str = "\
Examples:
    librate completions bash > ~/.local/share/bash-completion/completions/librate
    librate completions fish > ~/.config/fish/completions/librate.fish";

const MAN_EXAMPLE: &str = "\
Examples:
    librate man modes | man -l -
    librate man > ~/.local/share/man/man1/librate.1";

const DERIVE: &str = "\
Lagrange's equations, momenta, the Hamiltonian and conserved quantities; then the equilibrium, T and V to
second order about it, the mass matrix M, the stiffness matrix K and the linearized equations; symmetry
classes and closed forms of the frequencies; all as expressions in the parameters.

M_ij = d2T/dq_i'dq_j' and K_ij = d2V/dq_idq_j at the equilibrium. Parameters need no values. Coordinates
whose equilibrium has to be searched for remain symbols.";

const FMT: &str = "\
Puts model files in canonical layout: one statement a line, lines of at most 100 columns, even
spacing, no parentheses that aren't needed. Comments, blank lines and statements that share a line are
kept; the meaning of the file never changes. A file with syntax errors is not changed.";

const LSP: &str = "\
A language server for editors, on standard input and output: errors while you type, values and dimensions of names, definitions,
references, renaming, completion, arguments of functions, layout, an outline, K and M of coordinates at the equilibrium, and the
frequencies above the model.

An editor starts it by itself once it is told to use `librate lsp` for files that end in .lag.";

const FMT_EXAMPLE: &str = "\
Examples:
    librate fmt models/*.lag
    librate fmt --check models/water.lag
    librate fmt - < models/water.lag";

const DERIVE_EXAMPLE: &str = "\
Examples:
    librate derive models/double_pendulum.lag
    librate derive models/three_pendulums.lag --expand k12 2
    librate derive models/chain_walls.lag --set N=4 --json
    librate derive models/double_pendulum.lag --latex --standalone > page.tex";

const AMPLITUDE: &str = "\
The leading change of the frequency of each mode with its amplitude: omega = omega_0*(1 + change*A^2 + ...), where A is the
amplitude of the mode's largest component, in SI (rad for an angle). It comes from third and fourth derivatives at the equilibrium,
with a bound; for a pendulum it is -1/16.

`up to about` is the amplitude at which the next corrections to the motion, or the change of the frequency, reach a tenth of
the mode itself. If a mode of once, twice or three times the frequency is driven, there is no such change; this is reported
instead.";

const MOTION: &str = "\
The motion from initial values, by the full equations of motion: as CSV with the columns t, the coordinates and
their velocities. Numbers in --start are in the units of the coordinates; the table is in SI. Constraints, friction and
driving are covered.

The equations are integrated twice, with 31 and with 16 digits. The difference shows how much the motion amplifies errors,
and only the remaining digits are printed: a chaotic motion loses them in the course of time. That is an estimate.
With --proved the motion is enclosed step by step, with as many bits as are needed, and every digit is proved. With
--tolerance it is integrated once in double precision, and the doubles are printed as they are. The change of the energy is
reported on standard error.";
const MOTION_EXAMPLE: &str = "\
Examples:
    librate motion models/double_pendulum.lag --start \"th[1]=0.3\" --until 100 --samples 1001
    librate motion models/double_pendulum.lag --start \"th[1]=0.3\" --until 10 --digits 20 --proved
    librate plot motion models/three_pendulums.lag --mode 2 --amplitude 0.5 --until 20 -o motion.svg";

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "librate", version, about = flowing(ABOUT), after_help = flowing(EXAMPLE))]
#[command(arg_required_else_help = true, disable_help_subcommand = true, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// The format of errors and warnings
    #[arg(long, global = true, value_enum, value_name = "FORMAT", default_value_t)]
    pub(crate) message_format: MessageFormat,
    /// Time and memory for the computation: `60s`, `4GB`, `60s,4GB`, `none`; 10 s and 1 GB for a model of up to 8 kB, more in
    /// proportion for a longer one
    #[arg(long, global = true, value_name = "LIMITS", value_parser = Limits::parse)]
    pub(crate) budget: Option<Limits>,
}

impl Command {
    /// Whether the command says on the way what it does.
    pub(crate) fn tells(&self) -> bool {
        matches!(self, Self::Modes(Modes { verbose: true, .. }))
    }

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
            Self::Plot(plot) => Some(plot.what.model()),
            Self::Show(args) => Some(&mut args.model),
            Self::Response(args) => Some(&mut args.model),
            Self::Equilibria(args) => Some(&mut args.model),
            Self::Inertia(args) => Some(&mut args.model),
            Self::Export(args) => Some(&mut args.model),
            Self::Check(args) => Some(&mut args.model),
            Self::Derive(args) => Some(&mut args.model),
            Self::Explain(_)
            | Self::Completions(_)
            | Self::Man(_)
            | Self::Fmt(_)
            | Self::Watch(_)
            | Self::Repl(_)
            | Self::Lsp => None,
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
    #[command(long_about = flowing(MODES), after_help = flowing(MODES_EXAMPLE))]
    Modes(Modes),
    /// Frequencies over a range of a parameter, as CSV
    #[command(long_about = flowing(SWEEP), after_help = flowing(SWEEP_EXAMPLE))]
    Sweep(Sweep),
    /// The exact period of one coordinate at finite amplitude
    #[command(override_usage = usage("period", &PERIODS), long_about = flowing(PERIOD), after_help = flowing(PERIOD_EXAMPLE))]
    Period(Period),
    /// How the frequency of each mode changes with its amplitude
    #[command(long_about = flowing(AMPLITUDE))]
    Amplitude(Amplitude),
    /// How much each frequency changes with each parameter
    #[command(long_about = flowing(SENSITIVITY))]
    Sensitivity(Sensitivity),
    /// Stability of a periodically driven model: Floquet multipliers
    #[command(long_about = flowing(FLOQUET), after_help = flowing(FLOQUET_EXAMPLE))]
    Floquet(Floquet),
    /// The steady response to a harmonic force, as CSV
    #[command(long_about = flowing(RESPONSE), after_help = flowing(RESPONSE_EXAMPLE))]
    Response(ResponseArgs),
    /// Time evolution, as CSV
    #[command(override_usage = usage("motion", &MOTIONS), long_about = flowing(MOTION), after_help = flowing(MOTION_EXAMPLE))]
    Motion(Motion),
    /// A picture of what another command answers, as SVG
    #[command(long_about = flowing(PLOT), after_help = flowing(PLOT_EXAMPLE))]
    Plot(Plot),
    /// A page with the modes in motion, for a browser
    #[command(long_about = flowing(SHOW), after_help = flowing(SHOW_EXAMPLE))]
    Show(Show),
    /// Every equilibrium in a box of coordinates
    #[command(long_about = flowing(equilibria::ABOUT), after_help = flowing(equilibria::EXAMPLE))]
    Equilibria(Equilibria),
    /// Principal moments and axes of inertia: of a model's tensors, of points, of a mesh
    #[command(long_about = flowing(INERTIA), after_help = flowing(INERTIA_EXAMPLE))]
    Inertia(Inertia),
    /// The matrices as files of other programs, the equations as source code
    #[command(override_usage = usage("export", &EXPORTS), long_about = flowing(EXPORT), after_help = flowing(EXPORT_EXAMPLE))]
    Export(Export),
    /// Check a model file without computing anything
    #[command(long_about = flowing(CHECK))]
    Check(Check),
    /// Lagrange's equations, mass and stiffness matrices in symbols
    #[command(long_about = flowing(DERIVE), after_help = flowing(DERIVE_EXAMPLE))]
    Derive(Derive),
    /// What the code of an error or warning means, with an example
    #[command(long_about = flowing(EXPLAIN))]
    Explain(Explain),
    /// Completions for a shell, to be put where it looks for them
    #[command(after_help = flowing(COMPLETIONS_EXAMPLE))]
    Completions(Completions),
    /// A manual page, for man
    #[command(after_help = flowing(MAN_EXAMPLE))]
    Man(Man),
    /// Put model files in canonical layout, comments kept
    #[command(long_about = flowing(FMT), after_help = flowing(FMT_EXAMPLE))]
    Fmt(Fmt),
    /// A command again each time its model is saved
    #[command(long_about = flowing(watch::ABOUT), after_help = flowing(watch::EXAMPLE))]
    Watch(Watch),
    /// A model line by line, and how its frequencies move
    #[command(long_about = flowing(repl::ABOUT), after_help = flowing(repl::EXAMPLE))]
    Repl(Repl),
    /// Answer an editor: errors while you type, values, completions, renaming
    #[command(long_about = flowing(LSP))]
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
    /// Watches over the budget.
    #[arg(skip)]
    pub(crate) guard: Guard,
    /// Whether a picture is wanted in place of text.
    #[arg(skip)]
    pub(crate) drawn: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Plot {
    /// What is drawn
    #[command(subcommand)]
    pub(crate) what: Plotted,
}

#[derive(Debug, Args)]
pub(crate) struct Show {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Only the K lowest modes, in the order of `modes`
    #[arg(long, value_name = "K", value_parser = positive)]
    pub(crate) lowest: Option<usize>,
    /// A slider that moves this parameter, once or twice; between its values modes are interpolated
    #[arg(long, value_name = "NAME=a..b:count")]
    pub(crate) over: Vec<String>,
    /// Significant digits of the frequencies, up to 250
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<MOST_DIGITS>)]
    pub(crate) digits: usize,
    /// Write the page into a file; without it it goes to standard output
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
    /// Write the picture into a file; without it it goes to standard output
    // Without a long name: `--output` is a coordinate of `response`.
    #[arg(short, value_name = "FILE.svg", conflicts_with = "json")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Modes {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Only the K lowest modes, in the order printed
    #[arg(long, value_name = "K", value_parser = positive)]
    pub(crate) lowest: Option<usize>,
    /// Only the modes nearest to this frequency in rad/s, as many as --count says, in the usual order
    #[arg(long, value_name = "OMEGA", value_parser = frequency, requires = "count", conflicts_with = "lowest")]
    pub(crate) near: Option<f64>,
    /// Bounds for vectors that something else computed: an array `vectors` of NumPy's, one column a mode
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
    /// What the lengths of the shapes are: x^T M x = 1, or 1 for the largest component
    #[arg(long, value_parser = ["mass", "max"], value_name = "LENGTH", default_value = "mass", conflicts_with = "no_vectors")]
    pub(crate) normalize: String,
    /// A unit for a column of frequencies beside rad/s, in the text
    #[arg(long, value_parser = frequency_unit(), value_name = "UNIT")]
    pub(crate) unit: Option<FrequencyUnit>,
    /// Threads, where some modes of a large model are wanted; by default as many as there are cores
    #[arg(long, value_name = "COUNT", value_parser = positive)]
    pub(crate) threads: Option<usize>,
    /// Say on standard error which solver is chosen, and why
    #[arg(long)]
    pub(crate) verbose: bool,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// A unit of frequencies.
fn frequency_unit() -> impl TypedValueParser<Value = FrequencyUnit> {
    let parser = PossibleValuesParser::new(FrequencyUnit::ALL.map(FrequencyUnit::as_str));
    parser.map(|name| FrequencyUnit::ALL.into_iter().find(|unit| unit.as_str() == name).unwrap_or(FrequencyUnit::Hertz))
}

#[derive(Debug, Args)]
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
    /// Write the table into a file, or go on with one that was interrupted
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
    /// Of a rate of rotation: a line for each of these multiples, `1,2` (Campbell diagram)
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
    #[arg(long, num_args = 2, value_names = ["NAME=a..b:n", "NAME=c..d:m"], conflicts_with = "json")]
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
    /// Of a mesh: mass per volume; 1 if neither this nor --mass is given
    #[arg(long, value_name = "RHO", conflicts_with = "mass")]
    pub(crate) density: Option<String>,
    /// Of a mesh: the mass of the whole body
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
    /// Initial values: `phi[1]=0.1, phi[1]'=0`; coordinates left out rest at the equilibrium
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    pub(crate) start: Option<String>,
    /// A start for each row of a table, with columns named as coordinates and velocities; a column `start` in the results
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
    /// The number of rows, from t = 0 to the end
    #[arg(long, value_name = "N", default_value = "101", value_parser = positive)]
    pub(crate) samples: usize,
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
    /// M.mtx, K.mtx and what there is of G, C and N in a folder, as text
    #[arg(long)]
    pub(crate) matrix_market: bool,
    /// All in one archive of NumPy
    #[arg(long)]
    pub(crate) npz: bool,
    /// M, K and what there is of G, C and N in a folder, in PETSc's binary format
    #[arg(long)]
    pub(crate) petsc: bool,
    /// Functions for M, K and the accelerations, as source code
    #[arg(long, value_enum, value_name = "LANGUAGE")]
    pub(crate) code: Option<CodeLanguage>,
    /// The folder, which is made where there is none, or the file for --npz and --code; code goes to standard output without it
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
pub(crate) struct Explain {
    /// The code printed after `error` or `warning`: `E0201`; without one, all codes
    #[arg(value_name = "CODE")]
    pub(crate) code: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

#[derive(Debug, Args)]
pub(crate) struct Man {
    /// The page of a command: `modes`; without it that of librate
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Option<String>,
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
    #[arg(long, num_args = 2, value_names = ["NAME", "POWER"])]
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
    /// HTML with MathML instead of text, to be put into a page
    #[arg(long, conflicts_with_all = ["json", "latex"])]
    pub(crate) html: bool,
    /// Typst instead of text: a document, or a part of one
    #[arg(long, conflicts_with_all = ["json", "latex", "html"])]
    pub(crate) typst: bool,
    /// Formulas in the model language, without Unicode letters and fractions
    #[arg(long, conflicts_with_all = ["json", "latex", "html", "typst"])]
    pub(crate) ascii: bool,
    /// With --latex: a whole document
    #[arg(long, requires = "latex")]
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
    match number.and_then(|number| usize::try_from(number).ok()) {
        Some(0) | None => Err("a whole number, 1 or more, is needed".to_owned()),
        Some(count) => Ok(count),
    }
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
