//! What pictures of curves have in common. They bring their own light background, so that they can be read on dark pages too.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

pub(super) const PAPER: RGBColor = RGBColor(252, 252, 250);
pub(super) const INK: RGBColor = RGBColor(40, 44, 52);
pub(super) const FAINT: RGBColor = RGBColor(222, 222, 218);
pub(super) const FONT: &str = "Helvetica, Arial, sans-serif";

/// What is drawn on an area.
pub(super) type Drawing<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Axes to draw curves in.
pub(super) type Axes<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// An SVG picture of some size in pixels.
pub(super) fn svg(size: (u32, u32), draw: impl FnOnce(&Drawing<'_>) -> Result<(), Box<dyn Error>>) -> String {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
    // Drawing into a text does not fail; what could be drawn is there in any case.
    let _ = area
        .fill(&PAPER)
        .map_err(Box::from)
        .and_then(|()| draw(&area))
        .and_then(|()| area.present().map_err(Box::from));
    drop(area);
    text
}

/// Axes over two ranges, with what they are called where that is said.
pub(super) fn axes<'a>(
    area: &Drawing<'a>,
    x: Range<f64>,
    y: Range<f64>,
    names: (&str, Option<&str>),
) -> Result<Axes<'a>, Box<dyn Error>> {
    let mut chart =
        ChartBuilder::on(area).margin(16).x_label_area_size(40).y_label_area_size(64).build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    mesh.bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style((FONT, 13).into_font().color(&INK))
        .axis_desc_style((FONT, 14).into_font().color(&INK))
        .x_desc(names.0);
    if let Some(name) = names.1 {
        mesh.y_desc(name);
    }
    mesh.draw()?;
    drop(mesh);
    Ok(chart)
}
