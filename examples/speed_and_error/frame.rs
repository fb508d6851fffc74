//! Frames of pictures with two logarithmic axes, as SVG. They bring their own light background, so that they can be read on
//! dark pages too.

use std::error::Error;

use librate_core::typeset::superscript;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub(crate) type Result<T> = std::result::Result<T, Box<dyn Error>>;
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(crate) const PAPER: RGBColor = RGBColor(252, 252, 250);
pub(crate) const INK: RGBColor = RGBColor(40, 44, 52);
pub(crate) const FAINT: RGBColor = RGBColor(222, 222, 218);
pub(crate) const FONT: &str = "Helvetica, Arial, sans-serif";

/// 10 to a whole power, as one writes it.
pub(crate) fn power(exponent: f64) -> String {
    let exponent = exponent.round() as i64;
    match exponent {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        2 => "100".to_owned(),
        _ => format!("10{}", superscript(&exponent.to_string()).unwrap_or_default()),
    }
}

/// A range of powers of ten with marks where they are wanted.
pub(crate) struct Axis {
    range: (f64, f64),
    marks: Vec<f64>,
}

impl Axis {
    fn new(range: (f64, f64), marks: &[f64]) -> Self {
        let marks = marks.iter().copied();
        Self { range, marks: marks.filter(|x| (range.0..=range.1).contains(x)).collect() }
    }
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.range.0) / (self.range.1 - self.range.0);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.marks.clone() }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.0..self.range.1
    }
}

/// A frame with two logarithmic axes, both given as powers of ten.
pub(crate) struct Frame<'a> {
    pub(crate) caption: &'a str,
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
    pub(crate) x_title: &'a str,
    pub(crate) y_title: &'a str,
    pub(crate) x_label: fn(f64) -> String,
    pub(crate) y_label: fn(f64) -> String,
    pub(crate) x_marks: &'a [f64],
    pub(crate) y_marks: &'a [f64],
}

pub(crate) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

impl Frame<'_> {
    pub(crate) fn draw<'a, 'b>(&self, area: &'a Area<'b>) -> Result<Chart<'a, 'b>> {
        let mut chart = ChartBuilder::on(area)
            .caption(self.caption, (FONT, 16).into_font().color(&INK))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(66)
            .build_cartesian_2d(Axis::new(self.x, self.x_marks), Axis::new(self.y, self.y_marks))?;
        chart
            .configure_mesh()
            .light_line_style(PAPER)
            .bold_line_style(FAINT)
            .axis_style(INK)
            .label_style((FONT, 12).into_font().color(&INK))
            .axis_desc_style((FONT, 13).into_font().color(&INK))
            .x_desc(self.x_title)
            .y_desc(self.y_title)
            .x_labels(self.x_marks.len())
            .y_labels(self.y_marks.len())
            .x_label_formatter(&|x| (self.x_label)(*x))
            .y_label_formatter(&|y| (self.y_label)(*y))
            .draw()?;
        Ok(chart)
    }
}

/// An SVG of a size, drawn by a function.
pub(crate) fn svg(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Result<()>) -> Result<String> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&PAPER)?;
        draw(&area)?;
        area.present()?;
    }
    Ok(text)
}

/// Dots with names from the top, and where to go on below them.
pub(crate) fn legend<'a>(area: &Area<'_>, entries: impl Iterator<Item = (RGBColor, &'a str)>) -> Result<i32> {
    let mut y = 60;
    for (color, name) in entries {
        area.draw(&Circle::new((14, y), 5, color.filled()))?;
        let style = (FONT, 13).into_font().color(&INK);
        let style = style.pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(name, (25, y), style))?;
        y += 19;
    }
    Ok(y + 14)
}

pub(crate) fn note(area: &Area<'_>, at: (i32, i32), lines: &[&str]) -> Result<()> {
    for (row, line) in lines.iter().enumerate() {
        let style = (FONT, 12).into_font().color(&INK.mix(0.75));
        area.draw(&Text::new(*line, (at.0, at.1 + 17 * row as i32), style))?;
    }
    Ok(())
}
