//! A page to look at: the model, its modes in motion, its derivation. One file that needs nothing else.

use std::fmt::Write;

use super::code::script;
use super::json::{array, middles, null, number, string, strings};
use super::mode_pictures::{axis_labels, caption};
use super::modes::Beside;
use super::page::capitalized;
use super::picture::{escaped, titled};
use super::{Exponent, counted, derive_html, modes_svg};
use librate_core::derive::Derivation;
use librate_core::linearize::Linearized;
use librate_core::linearize::short;
use librate_core::modes::Options;
use librate_core::oscillation::{NormalMode, NormalModes};
use librate_studies::figure::{Figure, Line, Link};
use librate_studies::grid::{Axis, Grid, Node};

const STYLE: &str = include_str!("show/page.css");
const SCRIPT: &str = include_str!("show/page.js");
/// A page of more modes would be too long to look through.
pub const MOST_MODES: usize = 200;
/// A longer derivation is left to `derive`.
const MOST_DERIVED: usize = 120_000;

/// What is on a page.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The text of the model.
    pub text: &'a str,
    /// The model about its equilibrium.
    pub linearized: &'a Linearized,
    /// Its modes, with shapes.
    pub modes: &'a NormalModes,
    /// What they were computed with.
    pub options: &'a Options,
    /// Its points, where they are known.
    pub figure: Option<&'a Figure>,
    /// Its derivation, where there is one.
    pub derivation: Option<&'a Derivation>,
    /// The modes over parameters that can be moved; these are inputs of the figure, too, behind the coordinates.
    pub grid: Option<&'a Grid>,
}

/// The page as HTML. Without scripts it has the shapes as a still picture in place of moving ones.
#[must_use]
pub fn show_html(shown: &Shown<'_>) -> String {
    let Shown { text, linearized, modes, .. } = shown;
    let model = linearized.model();
    let title = titled("Normal modes", model.name.as_deref());
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<h1>{0}</h1>\n<p>{1}, equilibrium {2}{3}.</p>\n",
        escaped(&title),
        counted(linearized.coordinates(), "coordinate"),
        modes.stability.as_str(),
        if shown.grid.is_some() { " at the model's own values" } else { "" },
    );
    if !modes.modes.is_empty() {
        out.push_str(&STAGE.replace("SLIDERS", &shown.grid.map_or_else(String::new, sliders)));
        match shown.figure {
            Some(figure) if figure.still.is_empty() => {}
            Some(figure) => out.push_str(&format!("<p>{}.</p>\n", escaped(&capitalized(&still_words(figure))))),
            None => out.push_str(BARS),
        }
        let _ = write!(out, "<div class=\"still\">\n{}</div>\n", modes_svg(linearized, modes));
        out.push_str(&table(shown));
    }
    let text: String = text.lines().map(|line| escaped(line) + "\n").collect();
    let _ = write!(out, "<h2>Model</h2>\n<pre><code>{text}</code></pre>\n");
    if let Some(derivation) = shown.derivation {
        let page = derive_html(derivation);
        if page.len() <= MOST_DERIVED {
            let _ = write!(out, "<details>\n<summary><strong>Derivation</strong></summary>\n{page}</details>\n");
        } else {
            out.push_str("<p>The derivation is long: <code>librate derive --html</code> writes it.</p>\n");
        }
    }
    if !modes.modes.is_empty() {
        let positions = shown.figure.map_or_else(null, |figure| format!("q => {{\n{}}}", script(&figure.positions)));
        let script = SCRIPT.replacen(
            "const canvas =",
            &format!(
                "const positions = {positions};\nif (data.figure) data.figure.positions = positions;\nconst canvas ="
            ),
            1,
        );
        let _ = write!(
            out,
            "<script type=\"application/json\" id=\"data\">{}</script>\n<script>\n{script}</script>\n",
            // Nothing in a text ends the element.
            data(shown).replace('<', "\\u003c")
        );
    }
    out.push_str("</body>\n</html>\n");
    out
}

/// Where modes move, and what moves them.
const STAGE: &str = "<div id=\"stage\">
<p id=\"caption\" aria-live=\"polite\"></p>
<canvas id=\"canvas\" tabindex=\"0\" role=\"img\" title=\"drag or arrow keys: turn in space; space bar: pause\"></canvas>
<div class=\"controls\">
<button id=\"pause\" type=\"button\">Pause</button>
<label>amplitude <input id=\"size\" type=\"range\" min=\"0\" max=\"2\" step=\"0.02\" value=\"1\"></label>
<label>speed <input id=\"speed\" type=\"range\" min=\"0.1\" max=\"4\" step=\"0.1\" value=\"1\"></label>
</div>
SLIDERS</div>
";

const BARS: &str = "<p>The model has no points to draw, so that each coordinate is a bar: \
                    <code>draw point</code>, <code>draw line</code> and <code>draw spring</code> say what is to be drawn.</p>\n";

/// That a picture does not tell all.
#[must_use]
pub fn still_words(figure: &Figure) -> String {
    const MOST: usize = 6;
    let more = figure.still.len().saturating_sub(MOST);
    let more = if more > 0 { format!(" and {more} more coordinates") } else { String::new() };
    let names: Vec<&str> = figure.still.iter().take(MOST).map(String::as_str).collect();
    format!("no drawn point moves with {}{more}: what these do in a mode is not to be seen", names.join(", "))
}

/// What moves parameters; without a value in the range it stands in the middle.
fn sliders(grid: &Grid) -> String {
    let mut out = String::from("<div class=\"controls\">\n");
    for axis in &grid.axes {
        let Axis { ends: [from, to], own, .. } = axis;
        let unit = axis.unit.as_ref().map_or_else(String::new, |unit| format!(" {}", escaped(unit)));
        let value = short(from + own.unwrap_or(0.5) * (to - from));
        let _ = writeln!(
            out,
            "<label>{} <input data-axis type=\"range\" min=\"0\" max=\"1\" step=\"any\" value=\"{}\"> <output>{value}</output>{unit}</label>",
            escaped(&axis.name),
            own.unwrap_or(0.5),
        );
    }
    out + "<button id=\"own\" type=\"button\" disabled>As in the model</button>\n</div>\n"
}

/// The modes with their digits, a row each that selects what moves.
fn table(shown: &Shown<'_>) -> String {
    let Shown { linearized, modes, options, .. } = shown;
    let exponents: Vec<Exponent> = modes.modes.iter().map(|mode| Exponent::new(mode, options.digits)).collect();
    let grows = exponents.iter().any(|own| own.growth.text() != "0");
    let has_classes = modes.modes.iter().any(|mode| mode.symmetry.is_some());
    let [omega, growth] = axis_labels(linearized.model().has_units);
    let beside = Beside::new(linearized, modes, options);
    let titles = ["mode", "kind", omega].into_iter().chain(grows.then_some(growth)).chain(["bound"]);
    let titles = titles.chain((!beside.hertz.is_empty()).then_some("f (Hz)")).chain(has_classes.then_some("symmetry"));
    let titles = titles.chain((!beside.motions.is_empty()).then_some("motion"));
    let head: String = titles.map(|title| format!("<th scope=\"col\">{title}</th>")).collect();
    let mut out = format!("<h2>Modes</h2>\n<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n");
    for ((mode, exponent), number) in modes.modes.iter().zip(&exponents).zip(1..) {
        let button = format!("<button type=\"button\" aria-label=\"show mode {number}\">{number}</button>");
        let mut cells = vec![button, mode.kind.as_str().to_owned(), exponent.omega.text()];
        cells.extend(grows.then(|| exponent.growth.text()));
        let own = |all: &[String]| all.get(number - 1).cloned();
        cells.extend(own(&beside.bounds).into_iter().chain(own(&beside.hertz)));
        cells.extend(has_classes.then(|| escaped(mode.symmetry.as_deref().unwrap_or(""))));
        cells.extend(own(&beside.motions).as_deref().map(escaped));
        let _ = writeln!(out, "<tr data-mode=\"{number}\"><td>{}</td></tr>", cells.join("</td><td>"));
    }
    out.push_str("</tbody>\n</table></div>\n");
    for remark in &beside.remarks {
        let _ = writeln!(out, "<p>{}</p>", escaped(remark));
    }
    out
}

/// A number that is only drawn.
fn rough(value: f64) -> String {
    format!("{value:.4e}").parse().map_or_else(|_| null(), number)
}

/// A mode as it is drawn, but for its caption.
fn drawn(mode: &NormalMode) -> String {
    let list = |parts: &[f64]| array(parts.iter().map(|part| rough(*part)));
    let imaginary = if mode.imaginary.is_empty() { null() } else { list(&mode.imaginary) };
    format!(
        "\"kind\": \"{}\", \"omega\": {}, \"growth\": {}, \"shape\": {}, \"imaginary\": {imaginary}}}",
        mode.kind.as_str(),
        rough(mode.omega.mid_f64()),
        rough(mode.growth.mid_f64()),
        list(&mode.vector),
    )
}

/// The nodes that sliders move between.
fn nodes(grid: &Grid) -> String {
    let axes = grid.axes.iter().map(|axis| {
        let pair = |ends: [f64; 2]| array(ends.into_iter().map(number));
        let own = axis.own.map_or_else(null, number);
        let (ends, si) = (pair(axis.ends), pair(axis.ends_si));
        let name = string(&axis.name);
        format!("{{\"name\": {name}, \"count\": {}, \"ends\": {ends}, \"si\": {si}, \"own\": {own}}}", axis.count)
    });
    let node = |node: &Option<Node>| {
        node.as_ref().map_or_else(null, |node| {
            let modes =
                node.modes.iter().map(|mode| mode.as_ref().map_or_else(null, |mode| format!("{{{}", drawn(mode))));
            let equilibrium = array(node.equilibrium.iter().map(|value| rough(*value)));
            format!("{{\"count\": {}, \"equilibrium\": {equilibrium}, \"modes\": {}}}", node.count, array(modes))
        })
    };
    format!("{{\"axes\": {}, \"nodes\": {}}}", array(axes), array(grid.nodes.iter().map(node)))
}

/// What the script draws.
fn data(shown: &Shown<'_>) -> String {
    let Shown { linearized, modes, figure, .. } = shown;
    let model = linearized.model();
    let drawn =
        modes.modes.iter().zip(1..).map(|(mode, at)| {
            format!("{{\"caption\": {}, {}", string(&caption(mode, at, model.has_units)), drawn(mode))
        });
    let lines = figure.iter().flat_map(|figure| &figure.lines).map(|Line { from, to, link, .. }| {
        let kind = if *link == Link::Rod { "rod" } else { "spring" };
        format!("[{from}, {}, \"{kind}\"]", to.map_or_else(null, |to| to.to_string()))
    });
    let figure = figure.map_or_else(null, |figure| {
        format!("{{\"dimension\": {}, \"dots\": {}, \"lines\": {}}}", figure.dimension, figure.dots, array(lines))
    });
    // Positions bend with angles, and only with them.
    let angles = model.coordinates.iter().any(|own| own.unit == Some("rad")) || !model.has_units;
    format!(
        "{{\"units\": {}, \"names\": {}, \"equilibrium\": {}, \"angles\": {angles}, \"figure\": {figure}, \"grid\": {},\n\"modes\": [\n{}]}}",
        model.has_units,
        strings(model.coordinates.names()),
        middles(linearized.equilibrium().values.iter().take(model.coordinates.len())),
        shown.grid.map_or_else(null, nodes),
        drawn.collect::<Vec<_>>().join(",\n"),
    )
}
