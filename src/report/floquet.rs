//! Floquet multipliers, as text and as JSON.

use std::fmt::Write;

use super::json::{Object, array, bound, middles, null, number, string};
use super::plain::wrapped;
use super::table::{Column, draw};
use super::{Style, Tone, Written, headline};
use librate_core::model::Model;
use librate_core::precision::{Ball, one_digit_up, one_digit_up_text};
use librate_studies::floquet::{Floquet, Multiplier, Place, Resonance, TRIALS, exponent};

/// Real part, imaginary part and modulus.
fn parts(own: &Multiplier, digits: usize) -> [Written; 3] {
    let precise = own.precise.as_deref();
    let part = |at: usize, value: &Ball| Written::finest(value, precise.map(|own| &own[at]), digits);
    [part(0, &own.re), part(1, &own.im), part(2, &own.modulus)]
}

/// The multipliers as a JSON object: `model`, `coordinates`, `period`, `multipliers` and what else the schema
/// `floquet.schema.json` describes.
#[must_use]
pub fn floquet_json(model: &Model, floquet: &Floquet, digits: usize) -> String {
    let state = floquet.place.iter().chain(&floquet.velocities);
    let state_error = state.map(Ball::mid_f64_error).fold(0.0, f64::max);
    let pairs =
        floquet.multipliers.iter().map(|own| format!("[{}, {}]", number(own.re.mid_f64()), number(own.im.mid_f64())));
    let mut digits_bound = 0.0_f64;
    let texts = array(floquet.multipliers.iter().map(|own| {
        let [re, im, _] = parts(own, digits).map(|part| {
            digits_bound = digits_bound.max(part.bound);
            part.json()
        });
        format!("[{re}, {im}]")
    }));
    let moduli = floquet.multipliers.iter().map(|own| number(own.modulus.mid_f64()));
    let places = floquet.multipliers.iter().map(|own| string(own.place.as_str()));
    let exponents = floquet.multipliers.iter().map(|own| {
        let (growth, omega) = exponent(own, &floquet.period);
        let part = |value: Ball| {
            if value.is_finite() { number(value.mid_f64()) } else { null() }
        };
        format!("[{}, {}]", part(growth), part(omega))
    });
    let rate = floquet.growth_rate.map(|rate| (rate, Written::new(&rate, digits)));
    let of_rate = |part: fn(&Ball) -> f64| rate.as_ref().map_or_else(null, |(rate, _)| number(part(rate)));
    let mut object = Object::of_model(model);
    object.field("period", number(floquet.period.mid_f64()));
    object.field("period_proved", floquet.period_proved);
    object.field("cycles", floquet.cycles);
    object.field("about", string(if floquet.rests { "equilibrium" } else { "periodic motion" }));
    object.field("place", middles(&floquet.place));
    object.field("velocities", middles(&floquet.velocities));
    object.field("place_error_bound", bound(state_error));
    object.field("multipliers", array(pairs));
    object.field("multipliers_digits", texts);
    object.field("error_bound", bound(floquet.error_bound()));
    object.field("digits_error_bound", number(digits_bound));
    object.field("moduli", array(moduli));
    object.field("circle", array(places));
    object.field("exponents", array(exponents));
    object.field("stable", floquet.stable.map_or_else(null, |stable| stable.to_string()));
    object.field("growth_rate", of_rate(Ball::mid_f64));
    object.field("growth_rate_digits", rate.as_ref().map_or_else(null, |(_, own)| own.json()));
    object.field("growth_rate_error_bound", of_rate(|rate| one_digit_up(rate.mid_f64_error())));
    object.field("frequencies", array(floquet.frequencies.iter().map(|own| number(*own))));
    let resonance = floquet.resonance.map(|own| {
        format!("{{\"of\": [{}, {}], \"sum\": {}, \"order\": {}}}", own.of.0 + 1, own.of.1 + 1, own.sum, own.order)
    });
    object.field("resonance", resonance.unwrap_or_else(null));
    object.end() + "\n"
}

/// The multipliers as text: what is examined, whether it is stable, and a line a multiplier.
#[must_use]
pub fn floquet_text(model: &Model, floquet: &Floquet, digits: usize, style: &Style) -> String {
    let heading = headline(model.name.as_deref(), model.coordinates.len());
    let mut out = style.paint(Tone::Heading, &heading);
    let unit = if model.has_units { " s" } else { "" };
    let _ = writeln!(out, "\nperiod: {}{unit}", Written::new(&floquet.period, digits).text());
    let place = place_text(model, floquet, digits);
    out.extend(place.lines().flat_map(|line| wrapped(line, style.width)).map(|line| line + "\n"));
    let (tone, word) = match floquet.stable {
        Some(true) => (Tone::Good, "stable"),
        Some(false) => (Tone::Bad, "unstable"),
        None => (Tone::Careful, "undecided"),
    };
    let _ = writeln!(out, "stability: {}", style.paint(tone, word));
    let unit = if model.has_units { " 1/s" } else { "" };
    match &floquet.growth_rate {
        Some(rate) => _ = writeln!(out, "growth rate: {}{unit}", Written::new(rate, digits).text()),
        None if floquet.stable == Some(false) => _ = writeln!(out, "growth rate: undecided"),
        None => {}
    }
    if let Some(resonance) = floquet.resonance {
        let text = format!("resonance: {}", resonance_text(floquet, resonance));
        out.extend(wrapped(&text, style.width).into_iter().map(|line| line + "\n"));
    }
    out.push('\n');
    let rows: Vec<[Written; 3]> = floquet.multipliers.iter().map(|own| parts(own, digits)).collect();
    let column = |at: usize| rows.iter().map(|row| row[at].text()).collect();
    let bound = |row: &[Written; 3]| {
        let bound = row[0].bound.max(row[1].bound);
        // Beyond the range of doubles half a unit of the last place, as everywhere.
        if bound == 0.0 || bound == f64::INFINITY && row.iter().all(|part| part.complete) {
            String::new()
        } else {
            one_digit_up_text(bound)
        }
    };
    let places = floquet.multipliers.iter().map(|own| own.place.as_str().to_owned());
    let columns = [
        Column::numbers("re", column(0)),
        Column::numbers("im", column(1)),
        Column::words("bound", rows.iter().map(bound).collect()),
        Column::numbers("modulus", column(2)),
        Column::words("unit circle", places.collect()),
    ];
    let painted = |at: usize| match floquet.multipliers[at].place {
        own @ Place::Outside => Some((Tone::Bad, own.as_str())),
        own @ Place::Undecided => Some((Tone::Careful, own.as_str())),
        Place::Inside | Place::On => None,
    };
    out.push_str(&draw(&columns, floquet.multipliers.len(), painted, style));
    if floquet.stable.is_none() {
        out.push_str("\nthe bounds do not decide on which side of the unit circle every multiplier lies, or whether two on it coincide\n");
    }
    if !floquet.period_proved {
        let _ = writeln!(out, "\nthat the drive repeats after this period was tested at {TRIALS} states, not proved");
    }
    out
}

fn place_text(model: &Model, floquet: &Floquet, digits: usize) -> String {
    let named = |prime: &str, values: &[Ball]| {
        let each = model.coordinates.names().zip(values);
        let each = each.map(|(name, value)| format!("{name}{prime} = {}", Written::new(value, digits).text()));
        each.collect::<Vec<_>>().join(", ")
    };
    let place = named("", &floquet.place);
    if floquet.rests {
        return format!("about the equilibrium {place}\n");
    }
    let velocities = named("'", &floquet.velocities);
    let mut text = format!("about the periodic motion through {place}, {velocities} at t = 0\n");
    for own in &floquet.away {
        let prime = if own.velocity { "'" } else { "" };
        let name = format!("{}{prime}", model.coordinates.at(own.coordinate).name());
        let (low, high) = own.range;
        let _ = writeln!(
            text,
            "which does not pass the guess {name} = {:.4}: {name} is between {low:.4} and {high:.4}",
            own.guess
        );
    }
    text
}

fn resonance_text(floquet: &Floquet, resonance: Resonance) -> String {
    let frequency = |at: usize| {
        let value = floquet.frequencies.get(at).copied().unwrap_or(f64::NAN);
        format!("{value:.4}")
    };
    let (i, j) = resonance.of;
    let drive = std::f64::consts::TAU * f64::from(floquet.cycles) / floquet.period.mid_f64();
    let order = resonance.order;
    if i == j {
        let of = if order == 1 { String::new() } else { format!("/{order}") };
        return format!(
            "the drive, {drive:.4} rad/s, is near 2*omega{of} with omega = {} rad/s without the drive",
            frequency(i)
        );
    }
    let sign = if resonance.sum { '+' } else { '-' };
    let (first, second) = if resonance.sum { (i, j) } else { (j, i) };
    let times = if order == 1 { String::new() } else { format!("{order} times ") };
    format!("{times}the drive, {drive:.4} rad/s, is near {} {sign} {} rad/s", frequency(first), frequency(second))
}
