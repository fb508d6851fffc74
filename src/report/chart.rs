//! Stability charts as CSV and as a picture.

use std::fmt::Write;

use librate_studies::chart::{Border, Chart, Place};

/// Side of the picture's plane in its own units.
const SIDE: f64 = 640.0;
const MARGIN: [f64; 2] = [70.0, 50.0];
/// Shades of growth, from the weakest to the strongest; what is stable stays white.
const SHADES: usize = 12;

/// A line for each place, the second parameter running faster: both parameters, `stable` (`true`, `false` or nothing) and
/// `growth_rate`.
#[must_use]
pub fn chart_csv(chart: &Chart, rows: &[Vec<Place>]) -> String {
    let [first, second] = chart.names();
    let mut out = format!("{},{},stable,growth_rate\n", cell(first), cell(second));
    let seconds = chart.values(1);
    for (a, row) in chart.values(0).iter().zip(rows) {
        for (b, place) in seconds.iter().zip(row) {
            let _ = match place.stable {
                Some(stable) => writeln!(out, "{a},{b},{stable},{:e}", place.growth_rate),
                None => writeln!(out, "{a},{b},,"),
            };
        }
    }
    out
}

/// A line for each place where stable and unstable meet: both parameters.
#[must_use]
pub fn borders_csv(chart: &Chart, borders: &[Border]) -> String {
    let [first, second] = chart.names();
    let mut out = format!("{},{}\n", cell(first), cell(second));
    for border in borders {
        let _ = writeln!(out, "{},{}", border.at[0], border.at[1]);
    }
    out
}

/// A name in CSV: members of families have commas.
fn cell(name: &str) -> String {
    if name.contains(',') { format!("\"{name}\"") } else { name.to_owned() }
}

/// The chart as an SVG picture: the first parameter to the right, the second one up; the darker, the faster the growth.
/// Neighbours of one shade are one rectangle.
#[must_use]
pub fn chart_svg(chart: &Chart, rows: &[Vec<Place>]) -> String {
    let [across, up] = chart.len();
    let rates = rows.iter().flatten();
    let unstable = rates.filter(|place| place.stable == Some(false));
    let most = unstable.map(|place| place.growth_rate).fold(0.0, f64::max);
    let shade = |place: &Place| match place.stable {
        None => Some(0),
        Some(true) => None,
        Some(false) => {
            let share = (place.growth_rate / most).clamp(0.0, 1.0);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            Some(1 + (share.sqrt() * (SHADES - 1) as f64) as usize)
        }
    };
    let (width, height) = (SIDE / across.max(1) as f64, SIDE / up.max(1) as f64);
    let [left, below] = MARGIN;
    let total = SIDE + left + 20.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{total}\" height=\"{}\" font-family=\"sans-serif\" font-size=\"14\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        SIDE + below + 20.0
    );
    let color = |shade: usize| match shade {
        0 => "#dddddd".to_owned(),
        shade => {
            let share = (shade - 1) as f64 / (SHADES - 1) as f64;
            let mix = |light: f64, dark: f64| light + (dark - light) * share;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let part = |value: f64| value as u8;
            let (r, g, b) = (mix(215.0, 60.0), mix(225.0, 20.0), mix(240.0, 90.0));
            format!("#{:02x}{:02x}{:02x}", part(r), part(g), part(b))
        }
    };
    for (i, row) in rows.iter().enumerate() {
        let mut from = 0;
        while from < row.len() {
            let own = shade(&row[from]);
            let same = row[from..].iter().take_while(|place| shade(place) == own);
            let to = from + same.count();
            if let Some(own) = own {
                // A little wider, so that no gaps show between neighbours.
                let _ = writeln!(
                    out,
                    "<rect x=\"{:.3}\" y=\"{:.3}\" width=\"{:.3}\" height=\"{:.3}\" fill=\"{}\"/>",
                    left + i as f64 * width,
                    20.0 + SIDE - to as f64 * height,
                    width * 1.02,
                    (to - from) as f64 * height,
                    color(own)
                );
            }
            from = to;
        }
    }
    let bottom = 20.0 + SIDE;
    let _ = writeln!(
        out,
        "<rect x=\"{left}\" y=\"20\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"none\" stroke=\"#333333\"/>"
    );
    let [first, second] = [chart.values(0), chart.values(1)];
    for quarter in 0..=4_usize {
        let share = quarter as f64 / 4.0;
        let tick = |values: &[f64]| match (values.first(), values.last()) {
            (Some(from), Some(to)) => short(from + (to - from) * share),
            _ => String::new(),
        };
        let (x, y) = (left + share * SIDE, bottom - share * SIDE);
        let _ = writeln!(
            out,
            "<text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            bottom + 20.0,
            tick(&first),
            left - 8.0,
            y + 5.0,
            tick(&second)
        );
    }
    let [first, second] = chart.names();
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n<text x=\"18\" y=\"{}\" text-anchor=\"middle\">{}</text>\n</svg>",
        left + 0.5 * SIDE,
        bottom + 42.0,
        escaped(first),
        20.0 + 0.5 * SIDE,
        escaped(second)
    );
    out
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// A number at an axis: four digits.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}
