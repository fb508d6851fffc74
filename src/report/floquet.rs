//! Floquet multipliers, as text and as JSON.

use std::fmt::Write;

use super::json::{array, null, number, string};
use super::table::{Column, draw};
use super::{Style, Tone, Written, headline};
use crate::floquet::{Floquet, Multiplier, Place, Resonance, exponent};
use crate::model::Model;
use crate::precision::{Ball, one_digit_up, one_digit_up_text};

/// A part of a multiplier by the digits that are certain; what can't be told from 0 beside its modulus is 0 with its bound.
fn written(part: &Ball, digits: usize) -> Written {
    Written::new(part, digits)
}

fn place_words(place: Place) -> &'static str {
    match place {
        Place::Inside => "inside",
        Place::On => "on",
        Place::Outside => "outside",
        Place::Undecided => "undecided",
    }
}

/// The multipliers as a JSON object: `model`, `coordinates`, `period`, `multipliers` and what else the schema
/// `floquet.schema.json` describes.
#[must_use]
pub fn floquet_json(model: &Model, floquet: &Floquet, digits: usize) -> String {
    let names = model.coordinates.iter().map(|own| string(&own.name));
    let middles = |values: &[Ball]| array(values.iter().map(|value| number(value.mid_f64())));
    let state = floquet.place.iter().chain(&floquet.velocities);
    let state_error = state.map(Ball::mid_f64_error).fold(0.0, f64::max);
    let pairs = floquet.multipliers.iter().map(|own| {
        format!(
            "[{}, {}]",
            number(own.re.mid_f64()),
            number(own.im.mid_f64())
        )
    });
    let mut digits_bound = 0.0_f64;
    let mut texts = Vec::new();
    for own in &floquet.multipliers {
        let parts = [&own.re, &own.im].map(|part| {
            let part = written(part, digits);
            digits_bound = digits_bound.max(part.bound);
            part.digits.as_deref().map_or_else(null, string)
        });
        texts.push(format!("[{}, {}]", parts[0], parts[1]));
    }
    let moduli = floquet
        .multipliers
        .iter()
        .map(|own| number(own.modulus.mid_f64()));
    let places = floquet
        .multipliers
        .iter()
        .map(|own| string(place_words(own.place)));
    let exponents = floquet.multipliers.iter().map(|own| {
        let (growth, omega) = exponent(own, &floquet.period);
        let part = |value: Ball| {
            if value.is_finite() {
                number(value.mid_f64())
            } else {
                null()
            }
        };
        format!("[{}, {}]", part(growth), part(omega))
    });
    let rate = floquet
        .growth_rate
        .map(|rate| (rate, written(&rate, digits)));
    let mut out = String::new();
    let _ = write!(
        out,
        "{{\"model\": {},\n \"coordinates\": {},\n \"period\": {},\n \"about\": \"{}\",\n \"place\": {},\n \"velocities\": {},\n \"place_error_bound\": {},\n \"multipliers\": {},\n \"multipliers_digits\": {},\n \"error_bound\": {},\n \"digits_error_bound\": {},\n \"moduli\": {},\n \"circle\": {},\n \"exponents\": {},\n \"stable\": {},\n \"growth_rate\": {},\n \"growth_rate_digits\": {},\n \"growth_rate_error_bound\": {},\n \"frequencies\": {},\n \"resonance\": {}}}\n",
        model.name.as_deref().map_or_else(null, string),
        array(names),
        number(floquet.period.mid_f64()),
        if floquet.rests {
            "equilibrium"
        } else {
            "periodic motion"
        },
        middles(&floquet.place),
        middles(&floquet.velocities),
        number(one_digit_up(state_error)),
        array(pairs),
        array(texts.into_iter()),
        number(one_digit_up(floquet.error_bound())),
        number(digits_bound),
        array(moduli),
        array(places),
        array(exponents),
        floquet
            .stable
            .map_or_else(null, |stable| stable.to_string()),
        rate.as_ref()
            .map_or_else(null, |(rate, _)| number(rate.mid_f64())),
        rate.as_ref()
            .and_then(|(_, text)| text.digits.as_deref())
            .map_or_else(null, string),
        rate.as_ref()
            .map_or_else(null, |(rate, _)| number(one_digit_up(rate.mid_f64_error()))),
        array(floquet.frequencies.iter().map(|own| number(*own))),
        floquet.resonance.map_or_else(null, |own| {
            format!(
                "{{\"of\": [{}, {}], \"sum\": {}, \"order\": {}}}",
                own.of.0 + 1,
                own.of.1 + 1,
                own.sum,
                own.order
            )
        }),
    );
    out
}

/// The multipliers as text: what is looked at, whether it is stable, and a line a multiplier.
#[must_use]
pub fn floquet_text(model: &Model, floquet: &Floquet, digits: usize, style: &Style) -> String {
    let heading = headline(model.name.as_deref(), model.coordinates.len());
    let mut out = style.paint(Tone::Heading, &heading);
    let unit = if model.has_units { " s" } else { "" };
    let _ = writeln!(
        out,
        "\nperiod: {}{unit}",
        written(&floquet.period, digits).text()
    );
    out.push_str(&place_text(model, floquet, digits));
    let (tone, word) = match floquet.stable {
        Some(true) => (Tone::Good, "stable"),
        Some(false) => (Tone::Bad, "unstable"),
        None => (Tone::Careful, "undecided"),
    };
    let _ = writeln!(out, "stability: {}", style.paint(tone, word));
    if let Some(rate) = &floquet.growth_rate {
        let unit = if model.has_units { " 1/s" } else { "" };
        let _ = writeln!(out, "growth rate: {}{unit}", written(rate, digits).text());
    }
    if let Some(resonance) = floquet.resonance {
        let _ = writeln!(out, "resonance: {}", resonance_text(floquet, resonance));
    }
    out.push('\n');
    let column = |part: &dyn Fn(&Multiplier) -> String| -> Vec<String> {
        floquet.multipliers.iter().map(part).collect()
    };
    let bound = |own: &Multiplier| {
        let parts = [&own.re, &own.im].map(|part| written(part, digits).bound);
        let bound = parts[0].max(parts[1]);
        if bound == 0.0 {
            String::new()
        } else {
            one_digit_up_text(bound)
        }
    };
    let columns = [
        Column::numbers("re", column(&|own| written(&own.re, digits).text())),
        Column::numbers("im", column(&|own| written(&own.im, digits).text())),
        Column::words("±", column(&bound)),
        Column::numbers(
            "modulus",
            column(&|own| written(&own.modulus, digits).text()),
        ),
        Column::words(
            "unit circle",
            column(&|own| place_words(own.place).to_owned()),
        ),
    ];
    let painted = |at: usize| match floquet.multipliers[at].place {
        Place::Outside => Some((Tone::Bad, "outside")),
        Place::Undecided => Some((Tone::Careful, "undecided")),
        Place::Inside | Place::On => None,
    };
    out.push_str(&draw(&columns, floquet.multipliers.len(), painted, style));
    if floquet.stable.is_none() {
        out.push_str("\nthe bounds do not tell on which side of the unit circle every multiplier lies, or whether two on it coincide\n");
    }
    out
}

fn place_text(model: &Model, floquet: &Floquet, digits: usize) -> String {
    let named = |names: Vec<String>, values: &[Ball]| -> Vec<String> {
        names
            .iter()
            .zip(values)
            .map(|(name, value)| format!("{name} = {}", written(value, digits).text()))
            .collect()
    };
    let names = |suffix: &str| {
        let names = model.coordinates.iter();
        names.map(|own| format!("{}{suffix}", own.name)).collect()
    };
    if floquet.rests {
        let place = named(names(""), &floquet.place).join(", ");
        return format!("about the equilibrium {place}\n");
    }
    let mut state = named(names(""), &floquet.place);
    state.extend(named(names("'"), &floquet.velocities));
    format!(
        "about the periodic motion through {} at t = 0\n",
        state.join(", ")
    )
}

fn resonance_text(floquet: &Floquet, resonance: Resonance) -> String {
    let frequency = |at: usize| {
        let value = floquet.frequencies.get(at).copied().unwrap_or(f64::NAN);
        format!("{value:.4}")
    };
    let (i, j) = resonance.of;
    let drive = std::f64::consts::TAU / floquet.period.mid_f64();
    let order = resonance.order;
    if i == j {
        let of = if order == 1 {
            String::new()
        } else {
            format!("/{order}")
        };
        return format!(
            "the drive, {drive:.4} rad/s, is near 2*omega{of} of omega = {} rad/s without it",
            frequency(i)
        );
    }
    let sign = if resonance.sum { '+' } else { '-' };
    let (first, second) = if resonance.sum { (i, j) } else { (j, i) };
    let of = if order == 1 {
        String::new()
    } else {
        format!(", {order} times over,")
    };
    format!(
        "the drive, {drive:.4} rad/s{of} is near {} {sign} {} rad/s",
        frequency(first),
        frequency(second)
    )
}
