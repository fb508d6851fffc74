//! Periods of one coordinate, as text, JSON and CSV.

use super::json::{Object, array, model_and_version, null, number, string};
use super::plain::wrapped;
use super::{Style, Tone, Written, csv_text, headline, nearest, nearest_bound, shown_unit};
use librate_core::model::Range;
use librate_core::precision::{Ball, Big, Scalar, one_digit_up_text};
use librate_studies::period::{Motion, Options, Oscillator, Period, Place};

/// Digits of the leading change of the frequency.
const DIGITS: usize = 6;

/// The period of a motion to read.
#[must_use]
pub fn period_text(oscillator: &Oscillator, found: &Period, options: &Options, style: &Style) -> String {
    let model = oscillator.model();
    let name = &oscillator.coordinate_name();
    let digits = options.digits;
    let period = Written::finest(&found.period, found.precise.as_ref(), digits);
    let mut out = style.paint(Tone::Heading, &headline(model.name.as_deref(), 1)) + "\n\n";
    let written = |value: &Ball, precise: Option<&Big>| Written::finest(value, precise, digits).text();
    let precise = |at: usize| found.motion_precise.get(at);
    let behind = |unit: &'static str| if model.has_units { unit } else { "" };
    let coordinate = model.coordinates.first();
    let unit =
        coordinate.and_then(shown_unit).filter(|_| model.has_units).map_or_else(String::new, |unit| format!(" {unit}"));
    let mut rows =
        vec![("period", format!("{}{}  bound {}", period.text(), behind(" s"), one_digit_up_text(period.bound)))];
    rows.push(match &found.motion {
        Motion::Libration { turning: [low, high] } => {
            let [low, high] = [written(low, precise(0)), written(high, precise(1))];
            ("turning points", format!("{name} = {low} and {high}{unit}"))
        }
        Motion::Rotation { advance } => {
            ("rotation", format!("{name} advances by {}{unit} in a period", written(advance, precise(0))))
        }
    });
    let equilibrium = written(&found.equilibrium, found.equilibrium_precise.as_ref());
    rows.push(("equilibrium", format!("{name} = {equilibrium}{unit}")));
    rows.push(("energy", written(&found.energy, found.energy_precise.as_ref()) + behind(" J")));
    let small = match &found.small {
        Some(small) => Written::finest(small, found.small_precise.as_ref(), digits).text() + behind(" s"),
        None if found.corner => "none: the force jumps at the equilibrium".to_owned(),
        None if found.proved => "none: the stiffness is not positive at the equilibrium".to_owned(),
        None => "unknown: the equilibrium is not proved".to_owned(),
    };
    rows.push(("small oscillations", small));
    if let Some(bend) = &found.bend {
        let within = if unit.is_empty() { String::new() } else { format!(" in{unit}") };
        let own = if bend.is_zero() {
            "0".to_owned()
        } else if bend.contains_zero() {
            format!("0, to within {},", one_digit_up_text(bend.abs_upper()))
        } else {
            Written::new(bend, DIGITS).text()
        };
        rows.push((
            "change of frequency",
            format!("{own} times the amplitude{within} squared, relative, to the leading order"),
        ));
    }
    let width = rows.iter().map(|(title, _)| title.len()).max().unwrap_or(0) + 2;
    for (title, value) in rows {
        let line = format!("{title:width$}{value}");
        out.extend(wrapped(&line, style.width).into_iter().map(|line| line + "\n"));
    }
    if !found.proved {
        out.push_str(
            "\nThe existence of the equilibrium is not proved: its position is an estimate, and the bound does not include its error.\n",
        );
    }
    out
}

/// The period of a motion as a JSON object: `period` with `error_bound`, `period_digits` with `digits_error_bound`,
/// `small_amplitude_period` (`null` where the stiffness is not positive), `motion`, `amplitude` and `turning_points` of a
/// libration or the `advance` of a rotation, `equilibrium`, `energy`, `frequency_change` (omega = omega_0 (1 +
/// frequency_change A² + …)).
#[must_use]
pub fn period_json(oscillator: &Oscillator, found: &Period, options: &Options) -> String {
    let mut object = Object::new(",\n ");
    period_fields(&mut object, oscillator, found, options);
    object.end() + "\n"
}

fn period_fields(object: &mut Object, oscillator: &Oscillator, found: &Period, options: &Options) {
    let model = oscillator.model();
    let value = |ball: &Ball| number(ball.mid_f64());
    let period = Written::finest(&found.period, found.precise.as_ref(), options.digits);
    let motion = match &found.motion {
        Motion::Libration { .. } => "libration",
        Motion::Rotation { .. } => "rotation",
    };
    object.field("model", model_and_version(model.name.as_deref()));
    object.field("coordinate", string(&oscillator.coordinate_name()));
    object.field("motion", string(motion));
    object.certified("period", &found.period, &period);
    object.field("small_amplitude_period", found.small.as_ref().map_or_else(null, value));
    let small = found.small.as_ref();
    let small = small.map(|small| Written::finest(small, found.small_precise.as_ref(), options.digits));
    object.optional("small_amplitude_period_digits", small.as_ref().map(Written::json));
    object.field("equilibrium", value(&found.equilibrium));
    object.optional("equilibrium_proved", (!found.proved).then_some(false));
    match &found.motion {
        Motion::Libration { turning } => {
            object.field("amplitude", value(&turning[1].sub(&found.equilibrium)));
            object.field("turning_points", array(turning.iter().map(value)));
        }
        Motion::Rotation { advance } => object.field("advance", value(advance)),
    }
    object.field("energy", number(nearest(&found.energy)));
    if let Some(bend) = &found.bend {
        let [own, bound] = [nearest(bend), nearest_bound(bend)].map(number);
        object.field("frequency_change", format!("{own}, \"frequency_change_error_bound\": {bound}"));
    }
}

/// A table with one line a place: the amplitude or energy, `period` and `error_bound`, a bound of the error of the period
/// as printed. Cells are empty where there is no periodic motion.
#[must_use]
pub fn period_csv(range: &Range, places: &[Place], options: &Options) -> String {
    let rows = places.iter().map(|place| {
        let written = place.result.as_ref().ok();
        let written = written.map(|found| Written::finest(&found.period, found.precise.as_ref(), options.digits));
        let bound = written.as_ref().map_or_else(String::new, |own| number(own.bound));
        [number(place.value), written.and_then(|own| own.digits).unwrap_or_default(), bound]
    });
    csv_text([range.name(), "period", "error_bound"], rows)
}

/// An array with one object a place: the amplitude or energy under its name as it was put in (`given`), then all that
/// [`period_json`] has; `error` in its place where there is no periodic motion.
#[must_use]
pub fn period_curve_json(oscillator: &Oscillator, places: &[Place], options: &Options) -> String {
    let objects = places.iter().map(|place| {
        let given = number(place.value);
        let mut object = Object::new(",\n ");
        match &place.result {
            Ok(found) => period_fields(&mut object, oscillator, found, options),
            Err(error) => object.field("error", string(&error.to_string())),
        }
        format!("{{\"given\": {given}, {}", object.end().trim_start_matches('{'))
    });
    format!("[{}]\n", objects.collect::<Vec<_>>().join(",\n"))
}
