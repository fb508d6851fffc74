//! How frequencies change with the amplitude, as text and as JSON.

use super::json::{Object, array, lines, null, number, string};
use super::modes::numbered;
use super::table::{Column, GAP, draw};
use super::{Style, Tone, Written, bound_text, headline, nearest, nearest_bound, shown_unit, with_unit};
use librate_core::linearize::Linearized;
use librate_core::order::Gather;
use librate_core::oscillation::NormalModes;
use librate_core::precision::Ball;
use librate_studies::amplitude::{Amplitudes, ModeAmplitude, Obstacle};

/// Digits of a change.
const DIGITS: usize = 6;
/// So many modes of the same frequency are told by number.
const MOST_EQUAL: usize = 4;

/// The change as it is printed, and a bound of its error.
fn change_text(change: &Ball) -> (String, String) {
    if change.contains_zero() {
        return ("0".to_owned(), bound_text(change.abs_upper()));
    }
    let written = Written::new(change, DIGITS);
    (written.text(), bound_text(written.bound))
}

fn obstacle_words(obstacle: Obstacle) -> String {
    match obstacle {
        Obstacle::NoOscillation => "no oscillation".to_owned(),
        Obstacle::Drift { with } => format!("drives mode {} away", with + 1),
        Obstacle::OneToOne { with } => format!("1:1 with mode {}: the shape is determined at fourth order", with + 1),
        Obstacle::OneToTwo { with } => format!("1:2 with mode {}", with + 1),
        Obstacle::OneToThree { with } => format!("1:3 with mode {}", with + 1),
        Obstacle::Undecided => "shapes are not separated".to_owned(),
    }
}

fn remark(found: &ModeAmplitude) -> String {
    if let Some(obstacle) = found.obstacle {
        return obstacle_words(obstacle);
    }
    if let Some(slow) = found.drives {
        return format!("2:1 with mode {}: unstable", slow + 1);
    }
    let equal: Vec<String> = found.equal.iter().map(|k| (k + 1).to_string()).collect();
    match equal.as_slice() {
        [] => String::new(),
        own if own.len() <= MOST_EQUAL => format!("1:1 with mode {}, not driven", own.join(", ")),
        own => format!("1:1 with {} modes, not driven", own.len()),
    }
}

/// The changes as a table to read.
#[must_use]
pub fn amplitude_text(
    linearized: &Linearized,
    modes: &NormalModes,
    amplitudes: &Amplitudes,
    digits: usize,
    style: &Style,
) -> String {
    let model = linearized.model();
    let count = linearized.dimension();
    let mut out = style.paint(Tone::Heading, &headline(model.name.as_deref(), count)) + "\n\n";
    let found = &amplitudes.modes;
    let rows = found.len();
    let name = |own: &ModeAmplitude| match own.change {
        Some(_) => {
            let coordinate = model.coordinates.at(own.coordinate);
            with_unit(&coordinate.name(), shown_unit(coordinate).filter(|_| model.has_units))
        }
        None => String::new(),
    };
    let frequency = if model.has_units { "omega (rad/s)" } else { "omega" };
    let none = || ("none".to_owned(), String::new());
    let changes = found.iter().map(|own| own.change.as_ref().map_or_else(none, change_text));
    let (changes, bounds): (Vec<String>, Vec<String>) = changes.unzip();
    let reach = found.iter().map(|own| match (own.reach, &own.change) {
        (Some(reach), _) => format!("{reach:.1e}").parse().map_or_else(|_| String::new(), plain),
        (None, Some(_)) => "-".to_owned(),
        (None, None) => String::new(),
    });
    let mut columns = vec![
        Column::counting("mode", rows),
        Column::numbers(frequency, modes.modes.iter().map(|mode| Written::of_mode(mode, digits)[0].text()).collect()),
        Column::numbers("change", changes),
        Column::words("bound", bounds),
        Column::words("amplitude of", found.iter().map(name).collect()),
        Column::words("up to about", reach.collect()),
    ];
    let remarks: Vec<String> = found.iter().map(remark).collect();
    let mut below = Vec::new();
    let column = Column::words("", remarks.clone());
    if columns.iter().chain([&column]).map(Column::width).sum::<usize>() > style.width + GAP {
        below = remarks.iter().zip(0..).filter(|(words, _)| !words.is_empty()).grouped();
    } else if remarks.iter().any(|words| !words.is_empty()) {
        columns.push(column);
    }
    out.push_str(&draw(&columns, rows, |_| None, style));
    out.extend(below.iter().map(|(words, modes)| format!("{}: {words}\n", numbered(modes))));
    out.push_str("\nomega is that of small oscillations times 1 + change A^2 for an amplitude A.\n");
    if !linearized.equilibrium().proved {
        out.push_str("The existence of the equilibrium is not proved: its position is an estimate, and the bounds do not include its error.\n");
    }
    out
}

/// Two digits.
fn plain(value: f64) -> String {
    if (1e-3..1e5).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

/// The changes as a JSON object: `model`, `coordinates`, and `modes`, each with `omega`, `omega_digits` and `error_bound`,
/// the `coordinate` whose amplitude is meant, `frequency_change` (omega = omega_0 (1 + frequency_change A² + …); `null` where
/// `obstacle` says why) with `frequency_change_error_bound`, `up_to` (`null` where nothing up to third order does so), and `equal`, modes of the
/// same frequency that this one does not drive from rest, and `drives`, a mode of half the frequency that it makes grow, by number from 1.
#[must_use]
pub fn amplitude_json(linearized: &Linearized, modes: &NormalModes, amplitudes: &Amplitudes, digits: usize) -> String {
    let model = linearized.model();
    let objects = modes.modes.iter().zip(&amplitudes.modes).map(|(mode, found)| {
        let [written, _] = Written::of_mode(mode, digits);
        let mut object = Object::new(", ");
        object.certified("omega", &mode.omega, &written);
        object.field("coordinate", string(&model.coordinates.at(found.coordinate).name()));
        match &found.change {
            Some(change) => {
                object.field("frequency_change", number(nearest(change)));
                object.field("frequency_change_error_bound", number(nearest_bound(change)));
                object.field("up_to", found.reach.map_or_else(null, number));
            }
            None => object.field("frequency_change", null()),
        }
        if let Some(obstacle) = found.obstacle {
            let (kind, with) = match obstacle {
                Obstacle::NoOscillation => ("no oscillation", None),
                Obstacle::Drift { with } => ("drift", Some(with)),
                Obstacle::OneToOne { with } => ("1:1", Some(with)),
                Obstacle::OneToTwo { with } => ("1:2", Some(with)),
                Obstacle::OneToThree { with } => ("1:3", Some(with)),
                Obstacle::Undecided => ("undecided", None),
            };
            let mut own = Object::new(", ");
            own.field("kind", string(kind));
            own.optional("mode", with.map(|with| with + 1));
            object.field("obstacle", own.end());
        }
        object.optional("drives", found.drives.map(|slow| slow + 1));
        let equal = || array(found.equal.iter().map(|k| (k + 1).to_string()));
        object.optional("equal", (!found.equal.is_empty()).then(equal));
        object.end()
    });
    let mut object = Object::of_model(model);
    object.field("modes", lines(objects));
    object.optional("equilibrium_proved", (!linearized.equilibrium().proved).then_some(false));
    object.end() + "\n"
}
