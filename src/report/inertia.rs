//! Mass, centre of mass, tensors and their principal moments, as text and as JSON.

use super::json::{Object, array, bound, lines, model_and_version, number, record, string};
use super::table::{Column, draw};
use super::{Style, Tone, Written, counted, headed, listed, with_unit};
use librate_core::precision::{Ball, Big, one_digit_up_text};
use librate_studies::inertia::{Body, Equal, Made, Moment, NamedTensor, Principal};

/// Digits of a component of an axis in a table.
const AXIS_DIGITS: usize = 6;
/// The names of the axes of a file.
const AXES: [&str; 3] = ["x", "y", "z"];

fn written(value: &Big, digits: usize) -> Written {
    Written::from_decimal(value.decimal(digits), value.is_zero())
}

/// Principal moments and axes of the tensors of a model as tables to read, one a tensor.
///
/// Moments have `digits` correctly rounded digits, as [`of_model`](librate_studies::inertia::of_model) was asked for.
#[must_use]
pub fn tensors_text(model: Option<&str>, tensors: &[NamedTensor], digits: usize, style: &Style) -> String {
    let mut out = style.paint(Tone::Heading, &headed(model, counted(tensors.len(), "tensor"))) + "\n";
    for tensor in tensors {
        out.push_str(&format!("\n{}\n", style.paint(Tone::Heading, &tensor.name)));
        out.push_str(&principal_text(&tensor.principal, tensor.unit.as_deref(), digits, style));
    }
    out
}

/// A body as text: what it is made of, its mass, centre of mass, tensor about that, and principal moments and axes.
#[must_use]
pub fn body_text(name: &str, body: &Body, digits: usize, style: &Style) -> String {
    let made = match &body.made {
        Made::Points { count } => counted(*count, "point"),
        Made::Solid { triangles, surfaces, .. } => {
            let triangles = counted(*triangles, "triangle");
            match surfaces {
                0 | 1 => triangles,
                more => format!("{triangles}, {more} surfaces"),
            }
        }
    };
    let mut out = style.paint(Tone::Heading, &format!("{name}: {made}")) + "\n";
    let text = |value: &Big| written(value, digits).text();
    if let Made::Solid { left_out, cavities, volume, density, by_default, .. } = &body.made {
        if *cavities > 0 {
            let holes = if *cavities == 1 { "cavity" } else { "cavities" };
            out.push_str(&format!("{cavities} {holes} inside\n"));
        }
        if *left_out > 0 {
            let flat = counted(*left_out, "triangle");
            out.push_str(&format!("{flat} with coinciding corners ignored\n"));
        }
        out.push_str(&format!("volume: {}\n", text(volume)));
        let how = if *by_default { " (none was given)" } else { "" };
        let density = if *by_default { "1".to_owned() } else { text(density) };
        out.push_str(&format!("density: {density}{how}\n"));
    }
    out.push_str(&format!("mass: {}\n", text(&body.mass)));
    let places = AXES.iter().zip(&body.centre);
    let places: Vec<String> = places.map(|(axis, place)| format!("{axis} = {}", text(place))).collect();
    out.push_str(&listed("centre of mass", &places, style.width));
    out.push_str("\ntensor about the centre of mass\n");
    let mut columns = vec![Column::words("", AXES.map(str::to_owned).to_vec())];
    columns.extend(AXES.iter().enumerate().map(|(j, axis)| {
        let cells = body.tensor.iter().map(|row| text(&row[j]));
        Column::numbers(axis, cells.collect())
    }));
    out.push_str(&draw(&columns, 3, |_| None, style));
    out.push_str("\nprincipal moments and axes\n");
    out.push_str(&principal_text(&body.principal, None, digits, style));
    out
}

fn moment_digits(moment: &Moment, digits: usize) -> Written {
    Written::finest(&moment.value, moment.precise.as_ref(), digits)
}

fn principal_text(principal: &Principal, unit: Option<&str>, digits: usize, style: &Style) -> String {
    let moments = &principal.moments;
    let all: Vec<Written> = moments.iter().map(|m| moment_digits(m, digits)).collect();
    let mut columns = vec![
        Column::counting("axis", moments.len()),
        Column::numbers(&with_unit("moment", unit), all.iter().map(Written::text).collect()),
        Column::right("bound", all.iter().map(|one| one_digit_up_text(one.bound)).collect()),
    ];
    columns.extend(AXES.iter().enumerate().map(|(at, axis)| {
        let cells = moments.iter().map(|moment| component(moment, at));
        Column::numbers(axis, cells.collect())
    }));
    let mut out = draw(&columns, moments.len(), |_| None, style);
    for equal in &principal.equal {
        out.push_str(&equal_words(equal));
        out.push('\n');
    }
    if all.iter().any(|one| !one.complete) {
        out.push_str(&style.paint(Tone::Careful, "fewer digits than requested are certain"));
        out.push('\n');
    }
    out
}

/// A component of an axis, with the digits that its bound decides.
fn component(moment: &Moment, at: usize) -> String {
    let value = moment.axis[at];
    // What may be 0 has no size.
    if value.abs() <= moment.axis_error_bound {
        return "0".to_owned();
    }
    let value = Ball::from(value).with_added_radius(moment.axis_error_bound);
    Written::new(&value, AXIS_DIGITS).text()
}

fn equal_words(equal: &Equal) -> String {
    let (first, last) = (equal.moments.start + 1, equal.moments.end);
    if equal.moments.len() > 2 {
        return if equal.proved {
            "the moments are equal: any axis is a principal axis".to_owned()
        } else {
            "the moments are equal within their bounds: any three perpendicular axes are equally valid, within them"
                .to_owned()
        };
    }
    // The one of the three that is left.
    let other = if first == 1 { 3 } else { 1 };
    let across = match equal.across {
        Some(axis) => AXES[axis.min(2)].to_owned(),
        None => format!("axis {other}"),
    };
    if equal.proved {
        format!("moments {first} and {last} are equal: any axis perpendicular to {across} is a principal axis")
    } else {
        format!(
            "moments {first} and {last} are equal within their bounds: any two perpendicular axes perpendicular to {across} are equally valid, within them"
        )
    }
}

/// The tensors of a model as a JSON object: `model`, `tensors`.
#[must_use]
pub fn tensors_json(model: Option<&str>, tensors: &[NamedTensor], digits: usize) -> String {
    let all = tensors.iter().map(|tensor| {
        let unit = match &tensor.unit {
            Some(unit) => format!(", \"unit\": {}", string(unit)),
            None => String::new(),
        };
        format!(
            "{{\"name\": {}{unit},\n   {},\n   {}}}",
            string(&tensor.name),
            matrix(&tensor.entries, digits),
            principal_json(&tensor.principal, digits)
        )
    });
    format!("{{\"model\": {},\n \"tensors\": {}}}\n", model_and_version(model), lines(all))
}

/// A body as a JSON object: `points`, or `triangles`, `surfaces`, `volume` and `density`; `mass`, `centre`, `tensor`,
/// `moments`, `equal`, `possible`.
#[must_use]
pub fn body_json(body: &Body, digits: usize) -> String {
    let mut fields = match &body.made {
        Made::Points { count } => vec![format!("\"points\": {count}")],
        Made::Solid { triangles, left_out, surfaces, cavities, volume, density, .. } => vec![
            format!("\"triangles\": {triangles}"),
            format!("\"left_out\": {left_out}"),
            format!("\"surfaces\": {surfaces}"),
            format!("\"cavities\": {cavities}"),
            quantity("volume", volume, digits),
            quantity("density", density, digits),
        ],
    };
    fields.push(quantity("mass", &body.mass, digits));
    let centre = body.centre.iter();
    fields.push(format!(
        "\"centre\": {}, \"centre_digits\": {}",
        array(centre.clone().map(double)),
        array(centre.map(|place| written(place, digits).json())),
    ));
    fields.push(matrix(&body.tensor, digits));
    fields.push(principal_json(&body.principal, digits));
    format!("{{{}}}\n", fields.join(",\n "))
}

fn double(value: &Big) -> String {
    number(value.mid_f64())
}

fn quantity(name: &str, value: &Big, digits: usize) -> String {
    let text = written(value, digits).json();
    format!("\"{name}\": {}, \"{name}_digits\": {text}", double(value))
}

fn matrix(entries: &[[Big; 3]; 3], digits: usize) -> String {
    let rows = entries.iter();
    let values = rows.clone().map(|row| array(row.iter().map(double)));
    let texts = rows.map(|row| array(row.iter().map(|x| written(x, digits).json())));
    format!("\"tensor\": {}, \"tensor_digits\": {}", array(values), array(texts))
}

/// `moments`, `equal`, `possible`.
fn principal_json(principal: &Principal, digits: usize) -> String {
    let moments = principal.moments.iter().map(|moment| {
        let mut object = Object::new(", ");
        object.certified("moment", &moment.value, &moment_digits(moment, digits));
        object.field("axis", array(moment.axis.iter().map(|x| number(*x))));
        object.field("axis_error_bound", bound(moment.axis_error_bound));
        object.end()
    });
    let equal = principal.equal.iter().map(|equal| {
        let numbers = equal.moments.clone().map(|at| (at + 1).to_string());
        record([("moments", array(numbers)), ("proved", equal.proved.to_string())])
    });
    format!(
        "\"moments\": {},\n   \"equal\": {}, \"possible\": {}",
        lines(moments),
        array(equal),
        principal.impossible.is_none()
    )
}
