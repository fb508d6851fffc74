//! Stability charts as CSV and as a picture.

use super::json::number;
use super::picture::{Axis, Cell, Panel, Picture, Sample};
use super::{csv_text, with_unit};
use librate_studies::chart::{Border, Chart, Place};

/// Shades of growth above the faintest; what is stable stays white.
const SHADES: f64 = 11.0;
const FAINTEST: f64 = 0.16;

/// Digits of a rate at most.
const MOST_DIGITS: usize = 10;

/// A line for each place, the second parameter running faster: both parameters, `stable` (`true`, `false` or nothing) and
/// `growth_rate` with so many digits, ten at most: multipliers without bounds have no more.
#[must_use]
pub fn chart_csv(chart: &Chart, rows: &[Vec<Place>], digits: usize) -> String {
    let written = |rate: f64| match rate {
        0.0 => "0e0".to_owned(),
        rate => format!("{rate:.*e}", digits.clamp(1, MOST_DIGITS) - 1),
    };
    let [firsts, seconds] = &[0, 1].map(|axis| chart.values(axis));
    let places = firsts.iter().zip(rows).flat_map(|(a, row)| {
        seconds.iter().zip(row).map(move |(b, place)| {
            let [stable, growth] = match place.stable {
                Some(stable) => [stable.to_string(), written(place.growth_rate)],
                None => [String::new(), String::new()],
            };
            [number(*a), number(*b), stable, growth]
        })
    });
    let [first, second] = chart.names();
    csv_text([first, second, "stable", "growth_rate"], places)
}

/// A line for each place where stable and unstable meet: both parameters.
#[must_use]
pub fn borders_csv(chart: &Chart, borders: &[Border]) -> String {
    csv_text(chart.names(), borders.iter().map(|border| border.at.map(number)))
}

/// The chart as an SVG picture: the first parameter to the right, the second one up; the darker, the faster the growth.
/// Neighbours of one shade are one rectangle.
#[must_use]
pub fn chart_svg(chart: &Chart, rows: &[Vec<Place>]) -> String {
    let rates = rows.iter().flatten().filter(|place| place.stable == Some(false)).map(|place| place.growth_rate);
    let most = rates.fold(0.0, f64::max);
    // `None` is stable; shades are few, so that neighbours are alike.
    let shade = |place: &Place| match place.stable {
        None => Some(None),
        Some(true) => None,
        Some(false) => {
            let share = (place.growth_rate / most).clamp(0.0, 1.0).sqrt();
            Some(Some(FAINTEST + (1.0 - FAINTEST) * (share * SHADES).round() / SHADES))
        }
    };
    let [first, second] = [chart.values(0), chart.values(1)];
    // A place stands for what is nearer to it than to its neighbours.
    let width = |values: &[f64]| match values {
        [from, .., to] => (to - from) / (values.len() - 1) as f64,
        _ => 1.0,
    };
    let [across, up] = [width(&first), width(&second)];
    let mut cells = Vec::new();
    for (a, row) in first.iter().zip(rows) {
        let mut from = 0;
        for alike in row.chunk_by(|own, next| shade(own) == shade(next)) {
            let to = from + alike.len();
            if let (Some(shade), Some(low), Some(high)) = (shade(&alike[0]), second.get(from), second.get(to - 1)) {
                let corners = [[a - 0.5 * across, low - 0.5 * up], [a + 0.5 * across, high + 0.5 * up]];
                cells.push(Cell { corners, shade });
            }
            from = to;
        }
    }
    let axis = |at: usize, values: &[f64], width: f64| {
        let ends = values.first().into_iter().chain(values.last()).copied();
        Axis::over(
            with_unit(chart.names()[at], chart.units()[at]),
            ends.flat_map(|end| [end - 0.5 * width, end + 0.5 * width]),
            0.0,
        )
    };
    let mut panel = Panel::new(axis(0, &first, across), axis(1, &second, up), Vec::new());
    let undecided = rows.iter().flatten().any(|place| place.stable.is_none());
    panel.cells = cells;
    let description =
        "Places without a shade are stable; the stronger the shade, the faster the motion grows there.".to_owned();
    let mut picture = Picture::single("Stability chart", description, panel);
    picture.size = [600.0, 600.0];
    picture.legend.push((Sample::Cell(Some(0.0)), "stable".to_owned()));
    if most > 0.0 {
        picture.legend.push((Sample::Cell(Some(FAINTEST)), "growth slow".to_owned()));
        picture.legend.push((
            Sample::Cell(Some(1.0)),
            format!("growth rate {most:.3}{}", if chart.has_units() { " 1/s" } else { "" }),
        ));
    }
    picture.legend.extend(undecided.then(|| (Sample::Cell(None), "undecided".to_owned())));
    picture.svg()
}
