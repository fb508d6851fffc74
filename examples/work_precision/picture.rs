//! CPU time against error, as SVG.

use plotters::prelude::*;

use super::frame::{Frame, Result, legend, note, power, svg};
use super::run::{FULL, QUICK, Report};

fn color(name: &str) -> RGBColor {
    match name {
        QUICK => RGBColor(214, 39, 40),
        FULL => RGBColor(128, 12, 40),
        "heyoka" => RGBColor(44, 150, 60),
        "heyoka, 80 bits" => RGBColor(23, 100, 50),
        "SciPy DOP853" => RGBColor(255, 127, 14),
        "SciPy LSODA" => RGBColor(188, 160, 34),
        _ => RGBColor(140, 86, 75),
    }
}

fn time(exponent: f64) -> String {
    match exponent.round() as i64 {
        -4 => "0.1 ms".to_owned(),
        -3 => "1 ms".to_owned(),
        -2 => "10 ms".to_owned(),
        -1 => "0.1 s".to_owned(),
        0 => "1 s".to_owned(),
        1 => "10 s".to_owned(),
        _ => power(exponent) + " s",
    }
}

const X: (f64, f64) = (-4.0, 1.5);
const Y: (f64, f64) = (-32.0, 1.0);

pub(crate) fn picture(report: &Report) -> Result<String> {
    let frame = Frame {
        caption: "A double pendulum for 100 s: CPU time against the error at the end",
        x: X,
        y: Y,
        x_title: "CPU time of a run",
        y_title: "largest error of the angles and their rates",
        x_label: time,
        y_label: power,
        x_marks: &[-4.0, -3.0, -2.0, -1.0, 0.0, 1.0],
        y_marks: &[-30.0, -25.0, -20.0, -15.0, -10.0, -5.0, 0.0],
    };
    let shown: Vec<_> = report.lines.iter().filter(|line| !line.trips.is_empty()).collect();
    svg((940, 560), |area| {
        let (left, right) = area.split_horizontally(740);
        let mut chart = frame.draw(&left)?;
        for line in &shown {
            let points: Vec<(f64, f64)> = line
                .trips
                .iter()
                .map(|trip| {
                    let error = trip.error.max(1e-300).log10();
                    (trip.seconds.log10().clamp(X.0, X.1), error.clamp(Y.0, Y.1))
                })
                .collect();
            let style = ShapeStyle::from(&color(line.name)).stroke_width(2);
            chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
            let radius = if line.name == FULL { 7 } else { 4 };
            let style = color(line.name).filled();
            chart.draw_series(points.iter().map(|&at| Circle::new(at, radius, style)))?;
        }
        let below = legend(&right, shown.iter().map(|line| (color(line.name), line.name)))?;
        note(&right, (8, below), &["A dot for each power of ten", "that was the tolerance."])
    })
}
