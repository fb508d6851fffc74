//! Steady responses, as CSV and JSON.

use super::json::{Object, array, error_bound, lines, model_and_version, null, number, string};
use super::picture::{Axis, Curve, Panel, Picture, Stroke, titled};
use super::{Written, csv_text, units, with_unit};
use librate_core::order::Order;
use librate_core::precision::{Ball, push_decimal, quick_decimal};
use librate_studies::response::{Output, Peak, PeakKind, Peaks, Response, ResponseError, Study, Value};
use std::ops::Range;

/// A number for a cell: all digits, or those that are certain.
fn cell(value: &Ball, digits: usize) -> String {
    quick_decimal(value, digits).or_else(|| Written::new(value, digits).digits).unwrap_or_default()
}

fn push_cell(out: &mut Vec<u8>, value: &Ball, digits: usize) -> Option<()> {
    out.extend_from_slice(cell(value, digits).as_bytes());
    Some(())
}

/// The names of the columns of [`response_csv`].
#[must_use]
pub fn response_header(response: &Response) -> String {
    let names = response.outputs.iter().map(|own| &own.coordinate);
    let names = names.flat_map(|name| [format!("{name} amplitude"), format!("{name} phase")]);
    csv_text(std::iter::once(response.name.clone()).chain(names), std::iter::empty::<[&str; 0]>())
}

/// A line a frequency: the frequency, then amplitude and phase of each output. `inf` is a resonance, and empty what is not decided.
#[must_use]
pub fn response_csv(response: &Response, digits: usize) -> String {
    let mut out = response_header(response).into_bytes();
    for (at, place) in response.places.iter().enumerate() {
        let values = response.outputs.iter().map(|output| &output.values[at]);
        push_line(&mut out, *place, values, |out, value| push_cell(out, value, digits));
    }
    String::from_utf8(out).unwrap_or_default()
}

/// A line; no number is quoted. `None` where a number can't be written.
fn push_line<'a>(
    out: &mut Vec<u8>,
    place: f64,
    values: impl Iterator<Item = &'a Value>,
    push: impl Fn(&mut Vec<u8>, &Ball) -> Option<()>,
) -> Option<()> {
    out.extend_from_slice(number(place).as_bytes());
    for value in values {
        out.push(b',');
        match value {
            Value::Known { amplitude, phase } => {
                push(out, amplitude)?;
                out.push(b',');
                phase.as_ref().map_or(Some(()), |phase| push(out, phase))?;
            }
            Value::Infinite => out.extend_from_slice(b"inf,"),
            _ => out.push(b','),
        }
    }
    out.push(b'\n');
    Some(())
}

/// Lines of a table.
#[derive(Debug, Default)]
pub struct ResponseLines {
    /// All of them.
    pub text: String,
    /// Those of which something is to be said beside the table: the frequency, and the response there.
    pub remarkable: Vec<(f64, Vec<Value>)>,
}

/// The lines of [`response_csv`] for some places: from doubles where these decide all digits.
///
/// # Errors
/// As [`Study::values`].
pub fn response_lines(study: &Study, places: Range<usize>, digits: usize) -> Result<ResponseLines, ResponseError> {
    let (mut out, mut remarkable) = (Vec::with_capacity(places.len() * 32 * study.outputs()), Vec::new());
    for (place, values) in places.clone().zip(study.in_doubles(places)) {
        let (start, at) = (out.len(), study.place(place));
        let quick = |out: &mut Vec<u8>, own: &Ball| push_decimal(out, own, digits).then_some(());
        if values.and_then(|own| push_line(&mut out, at, own.iter(), quick)).is_some() {
            continue;
        }
        out.truncate(start);
        let values = study.values(place)?;
        push_line(&mut out, at, values.iter(), |out, value| push_cell(out, value, digits));
        if !values.iter().all(|value| matches!(value, Value::Known { .. })) {
            remarkable.push((at, values));
        }
    }
    Ok(ResponseLines { text: String::from_utf8(out).unwrap_or_default(), remarkable })
}

/// A line a maximum or minimum: the output, what it is, where, the amplitude, and where it has fallen to 1/√2 of a maximum on both sides.
#[must_use]
pub fn peaks_csv(response: &Response, peaks: &[Peaks], digits: usize) -> String {
    let cell_of = |value: &Option<Ball>| value.as_ref().map_or_else(String::new, |value| cell(value, digits));
    let all = peaks.iter().flat_map(|own| own.found.iter().map(|peak| (&own.coordinate, peak)));
    let rows = all.map(|(output, peak)| {
        let amplitude = if is_infinite(peak) { "inf".to_owned() } else { cell_of(&peak.amplitude) };
        let [from, to] = peak.half_power.each_ref().map(cell_of);
        let kind = peak.kind.name().to_owned();
        [output.clone(), kind, cell(&peak.place, digits), amplitude, from, to]
    });
    csv_text(["output", "kind", &response.name, "amplitude", "half power from", "half power to"], rows)
}

fn is_infinite(peak: &Peak) -> bool {
    peak.kind == PeakKind::Resonance
}

/// The maxima and minima as a JSON object: `model`, `input`, `parameter`, and `outputs`, each with `coordinate`, `unit`, `peaks` and the pieces of the
/// range that are `undecided`.
#[must_use]
pub fn peaks_json(response: &Response, peaks: &[Peaks]) -> String {
    let with_bound = |name: &str, value: Option<&Ball>| {
        let [own, bound] =
            value.map_or_else(|| [null(), null()], |value| [number(value.mid_f64()), error_bound(value)]);
        format!("\"{name}\": {own}, \"{name}_error_bound\": {bound}")
    };
    let of_peak = |peak: &Peak| {
        let amplitude = with_bound("amplitude", peak.amplitude.as_ref());
        let amplitude = if is_infinite(peak) { amplitude.replacen("null", "\"inf\"", 1) } else { amplitude };
        let [from, to] = peak.half_power.each_ref().map(Option::as_ref);
        format!(
            "\n    {{\"kind\": {}, {}, {amplitude},\n     {}, {}}}",
            string(peak.kind.name()),
            with_bound("at", Some(&peak.place)),
            with_bound("half_power_from", from),
            with_bound("half_power_to", to),
        )
    };
    let of_output = |own: &Peaks| {
        format!(
            "\n  {{\"coordinate\": {},\n   \"unit\": {},\n   \"peaks\": {},\n   \"undecided\": {}}}",
            string(&own.coordinate),
            own.unit.as_deref().map_or_else(null, string),
            array(own.found.iter().map(of_peak)),
            array(own.undecided.iter().map(|piece| array(piece.iter().map(|end| number(*end))))),
        )
    };
    written(head(response), response, array(peaks.iter().map(of_output)))
}

/// The beginning of an object.
fn head(response: &Response) -> Object {
    let mut object = Object::new(",\n ");
    object.field("model", model_and_version(response.model.as_deref()));
    object.field("input", response.input.as_deref().map_or_else(null, string));
    object.field("parameter", string(&response.name));
    object
}

/// All of it, with its outputs.
fn written(mut object: Object, response: &Response, outputs: String) -> String {
    object.field("outputs", outputs);
    object.optional("equilibrium_proved", (!response.proved).then_some(false));
    object.end() + "\n"
}

/// The response as a JSON object: `model`, `input`, the frequencies under the name of their column, and `outputs`, each with
/// `coordinate`, `amplitude`, `phase` and their bounds, one a frequency. An amplitude is `"inf"` at a resonance, and what is not decided is
/// `null`, as is the phase of an amplitude that is 0 or infinite.
#[must_use]
pub fn response_json(response: &Response) -> String {
    let mut object = head(response);
    object.field(&response.name, array(response.places.iter().map(|place| number(*place))));
    let outputs = response.outputs.iter().map(|output| {
        let values = || output.values.iter();
        let known = |value: &Value| match value {
            Value::Known { amplitude, phase } => (Some(*amplitude), *phase),
            _ => (None, None),
        };
        let amplitudes = values().map(|value| match value {
            Value::Infinite => string("inf"),
            value => known(value).0.map_or_else(null, |own| number(own.mid_f64())),
        });
        let phases = values().map(|value| known(value).1.map_or_else(null, |own| number(own.mid_f64())));
        let amplitude_bounds = values().map(|value| known(value).0.as_ref().map_or_else(null, error_bound));
        let phase_bounds = values().map(|value| known(value).1.as_ref().map_or_else(null, error_bound));
        let mut own = Object::new(",\n   ");
        own.field("coordinate", string(&output.coordinate));
        own.field("unit", output.unit.as_deref().map_or_else(null, string));
        own.field("amplitude", array(amplitudes));
        own.field("amplitude_error_bound", array(amplitude_bounds));
        own.field("phase", array(phases));
        own.field("phase_error_bound", array(phase_bounds));
        own.end()
    });
    written(object, response, lines(outputs))
}

/// Amplitudes of more than so many times the median one have a logarithmic axis where friction limits them; without friction they leave
/// the picture, as all do near a resonance.
const TALLEST: f64 = 25.0;
/// A logarithmic axis shows no more powers of ten below the largest amplitude.
const DEEPEST: i32 = 7;
/// The median is one of so many places.
const EVEN: usize = 200;
/// More curves than this tell nobody anything.
pub const MOST_RESPONSES: usize = 10;

/// Amplitude and phase over the frequency as an SVG picture, one below the other, of many outputs the first ten; rings mark finite peaks.
#[must_use]
pub fn response_svg(response: &Response, peaks: &[Peaks]) -> String {
    let shown = response.outputs.iter().take(MOST_RESPONSES);
    let curves = |pick: fn(&Value) -> f64, jump: f64| -> Vec<Curve> {
        let one = |(colour, output): (usize, &Output)| {
            let mut points: Vec<[f64; 2]> = Vec::new();
            for (place, value) in response.places.iter().zip(&output.values) {
                let size = pick(value);
                let point = [*place, if size.is_finite() { size } else { f64::NAN }];
                // From -pi to pi is no way.
                if points.last().is_some_and(|last| (last[1] - point[1]).abs() > jump) {
                    points.push([f64::NAN; 2]);
                }
                points.push(point);
            }
            Curve { name: output.coordinate.clone(), colour, stroke: Stroke::Solid, points }
        };
        shown.clone().enumerate().map(one).collect()
    };
    let [mut amplitudes, phases] =
        [curves(Value::amplitude, f64::INFINITY), curves(Value::phase, std::f64::consts::PI)];
    let rings = peaks.iter().take(MOST_RESPONSES).enumerate().map(|(colour, own)| {
        let points = own.found.iter().filter_map(|peak| Some([peak.place.mid_f64(), peak.amplitude?.mid_f64()]));
        Curve { name: String::new(), colour, stroke: Stroke::Rings, points: points.collect() }
    });
    let rings: Vec<Curve> = rings.collect();
    for (curve, ring) in amplitudes.iter_mut().zip(&rings) {
        // A curve goes through its peaks.
        for peak in &ring.points {
            let at = curve.points.partition_point(|own| own[0] < peak[0]);
            if curve.points.get(at).is_none_or(|own| own[0] != peak[0]) {
                curve.points.insert(at, *peak);
            }
        }
    }
    amplitudes.extend(rings);
    let (up, is_cut) = amplitude_axis(response, &mut amplitudes);
    let unit = response.unit.as_deref().or((response.input.is_some()).then_some("rad/s"));
    let name = with_unit(&response.name, unit);
    let across = || Axis::over(&name, response.places.iter().copied(), 0.0);
    let turn = Axis::over("phase (rad)", [-std::f64::consts::PI, std::f64::consts::PI].into_iter(), 0.05);
    let source =
        response.input.as_ref().map_or_else(|| "its own drive".to_owned(), |name| format!("a force on {name}"));
    let cut = if is_cut { "; curves leave it near resonances without damping" } else { "" };
    let description = format!("Amplitude and phase of the steady response to {source}{cut}.");
    let panels = vec![Panel::new(across(), up, amplitudes), Panel::new(across(), turn, phases)];
    let picture = Picture::column(titled("Response", response.model.as_deref()), description, [600.0, 230.0], panels);
    picture.without(response.outputs.len().saturating_sub(MOST_RESPONSES)).svg()
}

/// The axis of amplitudes, and whether some are beyond it; where it is logarithmic, zeros are taken out of the curves.
fn amplitude_axis(response: &Response, curves: &mut [Curve]) -> (Axis, bool) {
    let shown = || response.outputs.iter().take(MOST_RESPONSES);
    let label = with_unit("amplitude", units(shown().map(|own| own.unit.as_deref())).as_deref());
    // At even steps: places crowd about the peaks.
    let ends = response.places.first().zip(response.places.last());
    let step = ends.map_or(0.0, |(from, to)| (to - from) / EVEN as f64);
    let even = (0..=EVEN).filter_map(|at| {
        let place = ends?.0 + step * at as f64;
        Some(response.places.partition_point(|own| *own < place))
    });
    let sizes = shown().flat_map(|own| even.clone().filter_map(move |at| Some(own.values.get(at)?.amplitude())));
    let mut sizes: Vec<f64> = sizes.filter(|own| *own > 0.0).collect();
    sizes.order_by(f64::total_cmp);
    let most = sizes.get(sizes.len() / 2).map_or(f64::INFINITY, |median| TALLEST * median);
    let points = || curves.iter().flat_map(|own| &own.points).map(|point| point[1]).filter(|size| size.is_finite());
    let top = points().fold(0.0, f64::max);
    // Without friction all moves in phase, or against it.
    let turns = |value: &Value| value.phase().sin().abs() > 1e-9;
    let is_damped = shown().flat_map(|own| &own.values).any(turns);
    if top <= most || !is_damped {
        let is_cut = top > most || sizes.last().is_some_and(|own| own.is_infinite());
        return (Axis::over(label, points().filter(|size| *size <= most).chain([0.0]), 0.05), is_cut);
    }
    let least = top / 10_f64.powi(DEEPEST);
    let axis = Axis::powers(label, points().filter(|size| *size >= least));
    for point in curves.iter_mut().flat_map(|own| &mut own.points).filter(|point| point[1] <= 0.0) {
        point[1] = f64::NAN;
    }
    (axis, false)
}
