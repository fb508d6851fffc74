//! Results in writing: text for a person, JSON for a program.
//!
//! Every number that has a bound is printed with the digits its bound decides and no others
//! ([`librate_core::precision::decimal`]). Nothing is computed here, and no file is opened: the functions return text, or
//! write to what they are handed.

mod amplitude;
mod chart;
mod code;
mod constraints;
mod diagnostics;
mod equilibria;
mod equilibria_pictures;
mod exponents;
mod floquet;
mod frequencies;
mod html;
mod inertia;
mod json;
mod latex;
mod markup;
mod matrices;
mod mode_pictures;
mod modes;
mod motion;
mod npz;
mod page;
mod period;
mod period_picture;
mod picture;
mod plain;
mod response;
mod runs;
mod sensitivity;
mod show;
mod sweep;
mod table;
mod typst;

pub use amplitude::{amplitude_json, amplitude_text};
pub use chart::{borders_csv, chart_csv, chart_svg};
pub use code::{Language, code_text};
pub use diagnostics::{Remarks, diagnostics_text, message_text};
pub use equilibria::{diagram_json, diagram_text, equilibria_json, equilibria_text};
pub use equilibria_pictures::{diagram_svg, equilibria_svg};
pub use floquet::{floquet_json, floquet_text};
pub use html::derive_html;
pub use inertia::{body_json, body_text, tensors_json, tensors_text};
pub use json::{derive_json, modes_json};
pub use latex::derive_latex;
pub use matrices::{Matrix, Mirror, matrices, write_npz};
pub use mode_pictures::{SweepView, modes_svg, spectrum_svg, sweep_svg};
pub use modes::modes_text;
pub use motion::{MotionsCsv, motion_csv, motion_json, motion_remark, motion_svg, start_remark};
pub use npz::{Vectors, read_vectors};
pub use page::left_out;
pub use period::{period_csv, period_curve_json, period_json, period_text};
pub use period_picture::period_svg;
pub use plain::derive_text;
pub use response::{
    MOST_RESPONSES, ResponseLines, peaks_csv, peaks_json, response_csv, response_header, response_json, response_lines,
    response_svg,
};
pub use sensitivity::{sensitivity_json, sensitivity_text};
pub use show::{MOST_MODES, Shown, show_html, still_words};
pub use sweep::{SweepColumns, SweepCsv, SweepKept, SweepRow, sweep_json};
pub use typst::derive_typst;

use anstyle::{AnsiColor, Effects};
use librate_core::worded;

use librate_core::model::Coordinate;
use librate_core::modes::Kind;
use librate_core::modes::exponents::Limit;
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::oscillation::{NormalMode, NormalModes};
use librate_core::precision::{
    Ball, Big, Decimal, Rounding, decimal, decimal_to_place, one_digit_up, one_digit_up_text,
};
use librate_core::typeset;

/// How text is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Style {
    /// Whether escape sequences for colours are wanted.
    pub color: bool,
    /// How many columns a line should have at most; tables that don't fit leave things out, but
    /// never a frequency.
    pub width: usize,
    /// Whether formulas stand in the model language instead of Unicode letters, indices and fractions.
    pub ascii: bool,
    /// What frequencies are given in beside rad/s; without it in Hz where the model has units.
    pub unit: Option<FrequencyUnit>,
}

worded! {
/// A unit of frequencies, beside rad/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
FrequencyUnit {
    /// Turns per second.
    Hertz "Hz",
    /// The wave number of light of this frequency, in 1/cm; c is 299792458 m/s, exactly.
    Wavenumber "cm-1",
    /// Turns per minute.
    Rpm "rpm",
    /// 1e12 Hz.
    Terahertz "THz",
}
/// How it is written.
as_str
/// All of them.
ALL
}

impl FrequencyUnit {
    /// One hertz in it.
    pub(crate) fn of_hertz(self) -> Option<Number> {
        match self {
            Self::Hertz => Some(Number::ONE),
            Self::Wavenumber => Number::ratio(1, 29_979_245_800),
            Self::Rpm => Some(Number::from(60)),
            Self::Terahertz => Number::ratio(1, 1_000_000_000_000),
        }
    }
}

impl Default for Style {
    /// Without colours, 80 columns, formulas in Unicode.
    fn default() -> Self {
        Self { color: false, width: 80, ascii: false, unit: None }
    }
}

impl Style {
    librate_core::choices! {
        /// With escape sequences for colours, or without.
        color: bool,
        /// With formulas in the model language, or in Unicode.
        ascii: bool,
        /// With frequencies in a unit of their own.
        unit: Option<FrequencyUnit>,
        /// For lines of so many columns.
        width: usize,
    }
}

/// What a piece of text is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tone {
    Heading,
    Good,
    Careful,
    Bad,
}

impl Style {
    fn paint(&self, tone: Tone, text: &str) -> String {
        if !self.color {
            return text.to_owned();
        }
        let style = match tone {
            Tone::Heading => anstyle::Style::new().effects(Effects::BOLD),
            Tone::Good => AnsiColor::Green.on_default(),
            Tone::Careful => AnsiColor::Yellow.on_default(),
            Tone::Bad => AnsiColor::Red.on_default().effects(Effects::BOLD),
        };
        format!("{style}{text}{style:#}")
    }
}

/// Digits of a standard uncertainty.
const SIGMA_DIGITS: usize = 2;
/// In place of a number that may be 0 or near.
const UNDECIDED: &str = "~0";

/// A number with a bound, in decimal.
struct Written {
    /// The digits that are certain; `None` where nothing is.
    digits: Option<String>,
    /// A bound of the error of the digits, one digit itself.
    bound: f64,
    /// Whether all digits asked for are there.
    complete: bool,
}

impl Written {
    fn new(value: &Ball, digits: usize) -> Self {
        Self::from_decimal(decimal(value, digits), value.is_zero())
    }

    /// From the more precise number, where there is one.
    fn finest(value: &Ball, precise: Option<&Big>, digits: usize) -> Self {
        let written = |precise: &Big| Self::from_decimal(precise.decimal(digits), precise.is_zero());
        precise.map_or_else(|| Self::new(value, digits), written)
    }

    /// The digits that a standard uncertainty leaves: those down to the second digit of it, but at least one. With the
    /// uncertainty itself in two digits; `none` where it has no first order.
    fn measured(value: &Ball, precise: Option<&Big>, sigma: Option<&Ball>, digits: usize) -> (Self, String) {
        let full = || Self::finest(value, precise, digits);
        let Some(sigma) = sigma else { return (full(), "none".to_owned()) };
        if sigma.contains_zero() {
            let word = if sigma.is_zero() { "0" } else { UNDECIDED };
            return (full(), word.to_owned());
        }
        let written = decimal(sigma, SIGMA_DIGITS).text;
        let place = i32::try_from(last_place(&written)).unwrap_or(i32::MIN);
        let own = match precise {
            Some(precise) => Self::from_decimal(precise.decimal_to_place(place, digits), precise.is_zero()),
            None => Self::from_decimal(decimal_to_place(value, place, digits), value.is_zero()),
        };
        (own, written)
    }

    fn from_decimal(decimal: Decimal, is_zero: bool) -> Self {
        let bound = match decimal.rounding {
            // Half a unit of the last place holds for whatever is correctly rounded. The ball may
            // know better, but differently on every machine.
            Rounding::Correct | Rounding::Fewer if !is_zero => half_unit(&decimal.text),
            Rounding::Correct | Rounding::Fewer | Rounding::Tie | Rounding::Undecided => {
                one_digit_up(decimal.error_bound)
            }
        };
        Self {
            // Beyond the range of doubles a bound is not finite, but digits may be decided.
            digits: (decimal.error_bound.is_finite() || decimal.digits > 0).then_some(decimal.text),
            bound,
            complete: matches!(decimal.rounding, Rounding::Correct | Rounding::Tie),
        }
    }

    /// Frequency and growth of a mode.
    fn of_mode(mode: &NormalMode, digits: usize) -> [Self; 2] {
        let precise = mode.precise.as_deref();
        [
            Self::finest(&mode.omega, precise.map(|own| &own.omega), digits),
            Self::finest(&mode.growth, precise.map(|own| &own.growth), digits),
        ]
    }

    /// The digits, or a question mark where there are none.
    fn text(&self) -> String {
        self.digits.clone().unwrap_or_else(|| "?".to_owned())
    }

    /// The digits as a JSON string, or `null`.
    fn json(&self) -> String {
        self.digits.as_deref().map_or_else(json::null, json::string)
    }
}

/// The power of ten of the last place of a number as [`decimal`] writes it.
fn last_place(number: &str) -> i64 {
    let (mantissa, exponent) = number.split_once('e').unwrap_or((number, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let exponent: i64 = exponent.parse().unwrap_or(0);
    exponent - i64::try_from(decimals).unwrap_or(0)
}

/// Half a unit of that place.
fn half_unit(number: &str) -> f64 {
    let bound: f64 = format!("5e{}", last_place(number) - 1).parse().unwrap_or(f64::INFINITY);
    // Below all doubles it is still not 0.
    bound.max(f64::from_bits(1))
}

/// The numbers of a mode in writing.
struct Exponent {
    omega: Written,
    omega_sigma: String,
    growth: Written,
    growth_sigma: String,
}

impl Exponent {
    fn new(mode: &NormalMode, digits: usize) -> Self {
        let precise = mode.precise.as_deref();
        let part = |value: &Ball, precise: Option<&Big>, sigma: Option<Option<&Ball>>| match sigma {
            Some(sigma) => Written::measured(value, precise, sigma, digits),
            None => (Written::finest(value, precise, digits), String::new()),
        };
        let sigmas = mode.uncertainty.as_ref();
        let (omega, omega_sigma) =
            part(&mode.omega, precise.map(|own| &own.omega), sigmas.map(|own| own.omega.as_ref()));
        let (growth, growth_sigma) =
            part(&mode.growth, precise.map(|own| &own.growth), sigmas.map(|own| own.growth.as_ref()));
        Self { omega, omega_sigma, growth, growth_sigma }
    }
}

/// The damping ratio zeta and the quality factor 1/(2 zeta) of a damped mode.
fn damping(mode: &NormalMode, digits: usize) -> Option<[Written; 2]> {
    let (ratio, precise) = mode.damping_ratio()?;
    let quality = Ball::ONE / ratio.scale(1);
    let precise_quality = precise.as_ref().map(|own| &Big::from_number(&Number::ONE, own.bits()) / &own.scale(1));
    Some([
        Written::finest(&ratio, precise.as_ref(), digits),
        Written::finest(&quality, precise_quality.as_ref(), digits),
    ])
}

/// The double for a number: 0 for what can't be told from it, so that it is the same everywhere.
fn nearest(value: &Ball) -> f64 {
    if value.contains_zero() { 0.0 } else { value.mid_f64() }
}

/// A bound of the error of that double.
fn nearest_bound(value: &Ball) -> f64 {
    one_digit_up(if value.contains_zero() { value.abs_upper() } else { value.mid_f64_error() })
}

/// A table as CSV.
fn csv_text<C: AsRef<[u8]>, R: IntoIterator<Item: AsRef<[u8]>>>(
    header: impl IntoIterator<Item = C>,
    rows: impl IntoIterator<Item = R>,
) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    // Writing to memory does not fail.
    let written = table.write_record(header);
    let written = written.and_then(|()| rows.into_iter().try_for_each(|row| table.write_record(row)));
    let bytes = written.ok().and_then(|()| table.into_inner().ok());
    String::from_utf8(bytes.unwrap_or_default()).unwrap_or_default()
}

/// A bound in one digit.
fn bound_text(bound: f64) -> String {
    if bound == 0.0 { "0".to_owned() } else { one_digit_up_text(bound) }
}

/// The unit of a coordinate, in SI; none where there is nothing to say.
fn shown_unit(coordinate: Coordinate<'_>) -> Option<&str> {
    coordinate.unit.filter(|unit| *unit != "1")
}

/// The unit that all of them have.
fn common<'a>(mut units: impl Iterator<Item = Option<&'a str>>) -> Option<&'a str> {
    let first = units.next()??;
    units.all(|other| other == Some(first)).then_some(first)
}

/// The units that there are: `m, rad`; none where one of them has none.
fn units<'a>(units: impl Iterator<Item = Option<&'a str>>) -> Option<String> {
    let all = units.collect::<Option<Vec<&str>>>()?.into_iter().distinct();
    (!all.is_empty()).then(|| all.join(", "))
}

/// `omega (rad/s)`
fn with_unit(name: &str, unit: Option<&str>) -> String {
    unit.map_or_else(|| name.to_owned(), |unit| format!("{name} ({})", typeset::unit(unit)))
}

/// `three_pendulums: 3 coordinates`
fn headline(name: Option<&str>, coordinates: usize) -> String {
    headed(name, counted(coordinates, "coordinate"))
}

/// Behind the name of a model.
fn headed(name: Option<&str>, what: String) -> String {
    name.map_or_else(|| what.clone(), |name| format!("{name}: {what}"))
}

/// `1 coordinate`, `3 coordinates`
fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// What the zero modes are together, where they are all there: their vectors are some basis of the
/// space that these motions span, and a part of them spans something else.
fn zero_motions(modes: &NormalModes, dimension: usize) -> Vec<&str> {
    let all = modes.modes.len() == dimension || modes.modes.last().is_some_and(|mode| mode.kind != Kind::Zero);
    let named = modes.zero_motions.iter().map(String::as_str);
    if all { named.collect() } else { Vec::new() }
}

/// Why an exponent is known less well than was asked for, or is a peculiar one.
fn limit_words(limit: &Limit, kind: Kind) -> String {
    match limit {
        Limit::Defective { order } if kind == Kind::Zero => {
            format!("a Jordan block of size {order} at the exponent 0: the motion grows as t^{}", order - 1)
        }
        Limit::Defective { order } => format!(
            "a Jordan block, one shape for {order} equal exponents: they depend on the parameters like a root of order {order}"
        ),
        Limit::Unresolved { count } => {
            format!("{count} exponents are too close together to be distinguished")
        }
        Limit::Open => "bounds do not decide all of its digits or signs".to_owned(),
    }
}

/// `title: a, b, c` on one line where that fits, else the items below the title.
fn listed(title: &str, items: &[String], width: usize) -> String {
    let line = format!("{title}: {}", items.join(", "));
    if line.chars().count() <= width {
        return format!("{line}\n");
    }
    // Lists of values are too wide themselves.
    let is_wide = |item: &&String| item.chars().count() + 2 > width;
    let items: Vec<String> = match items.iter().find(is_wide) {
        Some(_) => items.join(", ").split(", ").map(str::to_owned).collect(),
        None => items.to_vec(),
    };
    format!("{title}:\n{}", flow(&items, "  ", width))
}

/// Joins items with commas into lines of at most `width` columns, each with the same indentation.
fn flow(items: &[String], indentation: &str, width: usize) -> String {
    let mut out = String::new();
    let mut used = 0;
    for (at, item) in items.iter().enumerate() {
        let comma = if at + 1 < items.len() { "," } else { "" };
        let size = item.chars().count() + comma.len();
        if at == 0 || used + 1 + size > width {
            if at > 0 {
                out.push('\n');
            }
            out.push_str(indentation);
            used = indentation.len();
        } else {
            out.push(' ');
            used += 1;
        }
        out.push_str(item);
        out.push_str(comma);
        used += size;
    }
    out.push('\n');
    out
}
