//! The pictures, as SVG.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::clock::median;
use super::frame::{FONT, Frame, INK, Result, legend, note, power, svg};
use super::run::{CHOLMOD, Group, PATHS, PathInfo, Report};

fn color(path: &PathInfo) -> RGBColor {
    match (path.group, path.label) {
        (Group::Doubles, "faer") => RGBColor(31, 119, 180),
        (Group::Doubles, _) => RGBColor(23, 170, 190),
        (Group::Peer, "numpy") => RGBColor(188, 160, 34),
        (Group::Peer, "LAPACK tridiagonal") => RGBColor(140, 86, 75),
        (Group::Peer, "ARPACK") => RGBColor(227, 119, 194),
        (Group::Peer, CHOLMOD) => RGBColor(31, 119, 180),
        (Group::Peer, _) => RGBColor(255, 127, 14),
        (Group::Jacobi, _) => RGBColor(44, 150, 60),
        (Group::Librate(digits), _) => match digits {
            0..=10 => RGBColor(214, 39, 40),
            11..=15 => RGBColor(170, 24, 40),
            16..=25 => RGBColor(128, 12, 40),
            26..=50 => RGBColor(90, 5, 40),
            _ => RGBColor(60, 0, 40),
        },
        (Group::Mpmath(digits), _) => match digits {
            0..=30 => RGBColor(165, 140, 215),
            31..=50 => RGBColor(120, 90, 180),
            _ => RGBColor(75, 45, 140),
        },
        (Group::Flint(digits), _) => match digits {
            0..=50 => RGBColor(140, 140, 140),
            _ => RGBColor(80, 80, 80),
        },
    }
}

fn times(exponent: f64) -> String {
    format!(
        "{} ×",
        match exponent.round() as i64 {
            -1 => "0.1".to_owned(),
            -2 => "0.01".to_owned(),
            _ => power(exponent),
        }
    )
}

fn whole(value: f64) -> String {
    format!("{:.0}", 10f64.powf(value))
}

fn entry(path: &&PathInfo) -> (RGBColor, &'static str) {
    (color(path), path.label)
}

/// The lowest error that is drawn; what is below stands at the edge.
const FLOOR: f64 = -34.0;
const TOP: f64 = 1.5;
/// Where errors have marks.
const ERRORS: [f64; 7] = [-30.0, -25.0, -20.0, -15.0, -10.0, -5.0, 0.0];

fn drawn_error(error: f64) -> f64 {
    error.max(1e-300).log10().clamp(FLOOR + 0.5, TOP - 0.3)
}

/// Time against true error on the hard problems: a dot for each problem and path, a larger one where the
/// medians of a path meet.
pub(crate) fn hard(report: &Report) -> Result<String> {
    let reference = format!("CPU time, {} of the same problem = 1", report.unit);
    let frame = Frame {
        caption: "Hard problems: time against true error of the worst frequency",
        x: (-2.0, 4.0),
        y: (FLOOR, TOP),
        x_title: &reference,
        y_title: "largest relative error of a frequency",
        x_label: times,
        y_label: power,
        x_marks: &[-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0],
        y_marks: &ERRORS,
    };
    let shown: Vec<&PathInfo> = PATHS
        .iter()
        .filter(|path| report.hard().any(|m| m.of(path.label).is_some()))
        .filter(|path| match path.group {
            Group::Librate(digits) | Group::Mpmath(digits) | Group::Flint(digits) => digits <= 50,
            Group::Doubles | Group::Peer | Group::Jacobi => true,
        })
        .collect();
    svg((940, 560), |area| {
        let (left, right) = area.split_horizontally(740);
        let mut chart = frame.draw(&left)?;
        let mut medians = Vec::new();
        for path in &shown {
            let points: Vec<(f64, f64)> = report
                .hard()
                .filter_map(|m| {
                    let time = report.ratio(m, path.label)?.log10();
                    let error = m.of(path.label)?.judged.error;
                    Some((time.clamp(-2.0, 4.0), drawn_error(error)))
                })
                .collect();
            let style = color(path).mix(0.45).filled();
            chart.draw_series(points.iter().map(|&at| Circle::new(at, 3, style)))?;
            let middle = |of: fn(&(f64, f64)) -> f64| median(points.iter().map(of).collect());
            if let (Some(x), Some(y)) = (middle(|p| p.0), middle(|p| p.1)) {
                medians.push((path, (x, y)));
            }
        }
        for (path, at) in medians {
            let edge = ShapeStyle::from(&INK).stroke_width(1);
            chart.draw_series([Circle::new(at, 8, color(path).filled())])?;
            chart.draw_series([Circle::new(at, 8, edge)])?;
            if let Group::Librate(digits) | Group::Mpmath(digits) | Group::Flint(digits) = path.group {
                let style = (FONT, 9).into_font().color(&WHITE);
                let style = style.pos(Pos::new(HPos::Center, VPos::Center));
                chart.draw_series([Text::new(digits.to_string(), at, style)])?;
            }
        }
        let below = legend(&right, shown.iter().map(entry))?;
        note(
            &right,
            (8, below),
            &[
                "small: one problem",
                "large: the median",
                "number: digits asked for",
                "above 1: sign of ω² wrong",
                "bottom edge: below 10⁻³³",
            ],
        )
    })
}

/// Time and error against the number of coordinates, one row a family: its slug and title.
pub(crate) fn sizes(report: &Report, families: &[(&str, &str)]) -> Result<String> {
    let reference = format!("CPU time, {} = 1", report.unit);
    let shown: Vec<&PathInfo> = PATHS
        .iter()
        .filter(|path| report.measured.iter().any(|m| m.family.is_some() && m.of(path.label).is_some()))
        .collect();
    let count = families.len() as u32;
    svg((1120, 330 * count), |area| {
        let (left, right) = area.split_horizontally(920);
        for (cell, (slug, title)) in left.split_evenly((families.len(), 1)).iter().zip(families) {
            let sizes = || report.family(slug).map(|m| (m.n as f64).log10());
            let (Some(least), Some(most)) = (sizes().reduce(f64::min), sizes().reduce(f64::max)) else {
                continue;
            };
            let x = (least - 0.1, most + 0.1);
            // No two marks on top of each other.
            let mut marks: Vec<f64> = Vec::new();
            for mark in sizes() {
                if marks.last().is_none_or(|last| mark > last + 0.07) {
                    marks.push(mark);
                }
            }
            let halves = cell.split_evenly((1, 2));
            let time = Frame {
                caption: title,
                x,
                y: (-1.5, 4.2),
                x_title: "coordinates n",
                y_title: &reference,
                x_label: whole,
                y_label: times,
                x_marks: &marks,
                y_marks: &[-1.0, 0.0, 1.0, 2.0, 3.0, 4.0],
            };
            let error = Frame {
                caption: "true error",
                y: (FLOOR, TOP),
                y_title: "largest relative error",
                y_label: power,
                y_marks: &ERRORS,
                ..time
            };
            for (half, frame, is_time) in [(&halves[0], &time, true), (&halves[1], &error, false)] {
                let mut chart = frame.draw(half)?;
                for path in &shown {
                    let points: Vec<(f64, f64)> = report
                        .family(slug)
                        .filter_map(|m| {
                            let outcome = m.of(path.label)?;
                            let y = if is_time {
                                report.ratio(m, path.label)?.log10().clamp(-1.4, 4.1)
                            } else {
                                drawn_error(outcome.judged.error)
                            };
                            Some(((m.n as f64).log10(), y))
                        })
                        .collect();
                    let style = color(path).stroke_width(2);
                    chart.draw_series(LineSeries::new(points.clone(), style))?;
                    let dot = color(path).filled();
                    chart.draw_series(points.iter().map(|&at| Circle::new(at, 3, dot)))?;
                }
            }
        }
        legend(&right, shown.iter().map(entry)).map(drop)
    })
}
