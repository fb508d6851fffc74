//! Pictures as SVG: panels with axes, curves and a legend beside them. Text stays text, colours follow the reader's scheme,
//! and the same numbers give the same bytes everywhere. Nothing is computed here but places on the page.

use std::fmt::Write;

use librate_core::typeset::{Notation, superscript};
use unicode_width::UnicodeWidthStr;

/// Colours that people with any kind of sight tell apart (Okabe and Ito, 2008), and two more.
pub(super) const COLOURS: usize = 8;
/// Of the page, in both schemes; a class is a colour, what is drawn takes it.
const STYLE: &str = "\
.librate-plot{color-scheme:light dark;font:13px Helvetica,Arial,sans-serif}\
.librate-plot .paper{fill:#fcfcfa}.librate-plot text{fill:#282c34}.librate-plot .small{font-size:11.5px}.librate-plot .title{font-size:15px;font-weight:bold}\
.librate-plot .grid{stroke:#dededa;fill:none}.librate-plot .frame{stroke:#8a8f98;fill:none}.librate-plot .zero{stroke:#8a8f98;fill:none}\
.librate-plot .line{fill:none;stroke:currentColor;stroke-width:2;stroke-linejoin:round}\
.librate-plot .dashed{stroke-dasharray:6 4}.librate-plot .dotted{stroke-dasharray:2 4}.librate-plot .thin{stroke-width:1;stroke-opacity:.6}\
.librate-plot .dot{fill:currentColor}.librate-plot .ring{fill:none;stroke:currentColor;stroke-width:1.5}\
.librate-plot .c0{color:#0072b2}.librate-plot .c1{color:#d55e00}.librate-plot .c2{color:#009e73}.librate-plot .c3{color:#cc79a7}\
.librate-plot .c4{color:#56b4e9}.librate-plot .c5{color:#e69f00}.librate-plot .c6{color:#785e3c}.librate-plot .c7{color:#5a5a5a}.librate-plot .unknown{color:#9a9a9a}.librate-plot .cell{shape-rendering:crispEdges}\
@media (prefers-color-scheme:dark){.librate-plot .paper{fill:#16181d}.librate-plot text{fill:#e4e6ea}.librate-plot .grid{stroke:#33373f}\
.librate-plot .c0{color:#4aa8e8}.librate-plot .c6{color:#c2a075}.librate-plot .c7{color:#b5b5b5}}";

/// Around panels.
const MARGIN: f64 = 14.0;
/// Left of a panel for the numbers of its axis, and below.
const LEFT: f64 = 66.0;
const BELOW: f64 = 46.0;
/// Between numbers of an upright axis, and the width of a digit there.
const EACH_UP: f64 = 42.0;
const DIGIT: f64 = 6.5;
/// Of a line of text.
const LINE: f64 = 20.0;
/// Centres a text.
const MIDDLE: &str = " text-anchor=\"middle\"";
/// Between points as near as this a curve is straight for any eye.
const MOST_SMOOTH: usize = 1000;

/// An axis: what it says and from where to where it goes.
pub(super) struct Axis {
    label: String,
    low: f64,
    high: f64,
    ticks: Ticks,
}

/// What stands along an axis.
#[derive(PartialEq)]
enum Ticks {
    Numbers,
    /// Whole numbers alone.
    Whole,
    /// Powers of ten, the axis a logarithmic one.
    Powers,
    /// At 1, 2, …
    Names(Vec<String>),
    None,
}

impl Axis {
    /// Over all of some values with a share of them for room at both ends; numbers that are not finite do not count.
    pub(super) fn over(label: impl Into<String>, values: impl Iterator<Item = f64>, room: f64) -> Self {
        let finite = values.filter(|value| value.is_finite()).map(|value| value.clamp(-1e300, 1e300));
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let size = low.abs().max(high.abs());
        // A single value, or none, has an axis as well; what differs by rounding errors is one.
        let (low, high) = match high - low {
            span if span > 1e-12 * size => (low - room * span, high + room * span),
            _ if low > high => (0.0, 1.0),
            _ if size == 0.0 => (-1.0, 1.0),
            _ => (low - 0.5 * size, high + 0.5 * size),
        };
        Self { label: label.into(), low, high, ticks: Ticks::Numbers }
    }

    /// With whole numbers alone.
    pub(super) fn whole(self) -> Self {
        Self { ticks: Ticks::Whole, ..self }
    }

    /// A logarithmic one over positive values.
    pub(super) fn powers(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        let own = Self::over(label, values.map(f64::log10), 0.05);
        Self { low: 10_f64.powf(own.low), high: 10_f64.powf(own.high), ticks: Ticks::Powers, ..own }
    }

    /// With a name at each of 1, 2, …
    pub(super) fn names(label: impl Into<String>, names: Vec<String>) -> Self {
        Self { label: label.into(), low: 0.4, high: names.len() as f64 + 0.6, ticks: Ticks::Names(names) }
    }

    /// Without a number on it.
    pub(super) fn blank(low: f64, high: f64) -> Self {
        Self { label: String::new(), low, high, ticks: Ticks::None }
    }

    fn share(&self, value: f64) -> f64 {
        match self.ticks {
            Ticks::Powers => (value / self.low).ln() / (self.high / self.low).ln(),
            _ => (value - self.low) / (self.high - self.low),
        }
    }

    /// Places with what stands there, and the power of ten that all numbers are to be multiplied by.
    fn marks(&self, most: usize) -> (Vec<(f64, String)>, i32) {
        match &self.ticks {
            Ticks::None => (Vec::new(), 0),
            Ticks::Names(names) => {
                let step = names.len().div_ceil(most.max(1)).max(1);
                let shown = names.iter().enumerate().step_by(step);
                (shown.map(|(at, name)| (at as f64 + 1.0, name.clone())).collect(), 0)
            }
            Ticks::Powers => {
                let [first, last] = [power_of_ten(self.low) + 1, power_of_ten(self.high)];
                let step = (usize::try_from(last - first).unwrap_or(0) / most.max(1) + 1).max(1);
                let power = |n: i32| Some((ten_to(n), format!("10{}", superscript(&n.to_string())?)));
                ((first..=last).step_by(step).filter_map(power).collect(), 0)
            }
            Ticks::Numbers | Ticks::Whole => self.numbers(most),
        }
    }

    fn numbers(&self, most: usize) -> (Vec<(f64, String)>, i32) {
        let least = if self.ticks == Ticks::Whole { 1.0 } else { 0.0 };
        let rough = ((self.high - self.low) / most.max(1) as f64).max(least);
        let tens = power_of_ten(rough);
        // 1, 2, 5 or 10 of that power; numbers are whole multiples, which print exactly.
        let unit = ten_to(tens);
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * unit >= rough).unwrap_or(10.0);
        let step = factor * unit;
        let top = power_of_ten(self.low.abs().max(self.high.abs()));
        let scale = if (-3..6).contains(&top) { 0 } else { top };
        let decimals = usize::try_from(scale - tens).unwrap_or(0);
        let (first, last) = ((self.low / step - 1e-9).ceil(), (self.high / step + 1e-9).floor());
        let mut marks = Vec::new();
        let mut at = first;
        while at <= last && marks.len() <= 2 * most {
            marks.push((at * step, shortest(at * factor * ten_to(tens - scale), decimals.min(17))));
            at += 1.0;
        }
        (marks, scale)
    }
}

/// The power of ten of the first digit.
fn power_of_ten(value: f64) -> i32 {
    format!("{value:e}").split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

/// 10^n as the nearest double on every machine.
fn ten_to(power: i32) -> f64 {
    format!("1e{power}").parse().unwrap_or(1.0)
}

/// How a curve is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Stroke {
    Solid,
    Dashed,
    Thin,
    Dots,
    Rings,
    /// Upright lines from 0.
    Stems,
}

/// Points of one kind, in the order in which they are joined.
pub(super) struct Curve {
    /// For the legend; curves of one name have one entry.
    pub(super) name: String,
    pub(super) colour: usize,
    pub(super) stroke: Stroke,
    /// Broken where a number is not finite.
    pub(super) points: Vec<[f64; 2]>,
}

/// A rectangle, by two opposite corners; from 0, hardly to be seen, to 1. `None` for what is not known.
pub(super) struct Cell {
    pub(super) corners: [[f64; 2]; 2],
    pub(super) shade: Option<f64>,
}

/// A pair of axes with what is drawn between them.
pub(super) struct Panel {
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) cells: Vec<Cell>,
    pub(super) curves: Vec<Curve>,
}

impl Panel {
    pub(super) fn new(x: Axis, y: Axis, curves: Vec<Curve>) -> Self {
        Self { title: String::new(), x, y, cells: Vec::new(), curves }
    }

    pub(super) fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }
}

/// What an entry of a legend shows.
pub(super) enum Sample {
    Curve(usize, Stroke),
    Cell(Option<f64>),
    Nothing,
}

/// A picture: panels row by row.
pub(super) struct Picture {
    pub(super) title: String,
    /// What is to be seen, in words.
    pub(super) description: String,
    pub(super) columns: usize,
    /// Of each panel between its axes.
    pub(super) size: [f64; 2],
    pub(super) panels: Vec<Panel>,
    /// Beside the names of the curves.
    pub(super) legend: Vec<(Sample, String)>,
}

impl Picture {
    /// A picture of one panel.
    pub(super) fn single(title: impl Into<String>, description: String, panel: Panel) -> Self {
        Self::column(title, description, [600.0, 360.0], vec![panel])
    }

    /// Panels of one size, one below the other.
    pub(super) fn column(title: impl Into<String>, description: String, size: [f64; 2], panels: Vec<Panel>) -> Self {
        Self { title: title.into(), description, columns: 1, size, panels, legend: Vec::new() }
    }

    /// With a word in the legend on curves that are left out, if any are.
    pub(super) fn without(mut self, left_out: usize) -> Self {
        self.legend.extend((left_out > 0).then(|| (Sample::Nothing, format!("and {left_out} more"))));
        self
    }

    /// Names as a page has them, θ₁ for `th[1]`, no two of which look alike.
    fn put_letters(&mut self) {
        let panels = self.panels.iter_mut().flat_map(|panel| {
            let Panel { x, y, curves, .. } = panel;
            let axes = [x, y].into_iter().flat_map(|axis| {
                let names = if let Ticks::Names(names) = &mut axis.ticks { names.as_mut_slice() } else { &mut [] };
                names.iter_mut().chain([&mut axis.label])
            });
            axes.chain(curves.iter_mut().map(|curve| &mut curve.name))
        });
        let mut labels: Vec<&mut String> = panels.chain(self.legend.iter_mut().map(|(_, name)| name)).collect();
        let notation = Notation::default().names(labels.iter().filter_map(|label| name_in(label)).collect::<Vec<_>>());
        for label in &mut labels {
            let Some(name) = name_in(label) else { continue };
            let lines = notation.read(name).map(|name| name.text(usize::MAX));
            if let Some([line]) = lines.as_deref() {
                **label = format!("{line}{}", &label[name.len()..]);
            }
        }
    }

    /// The whole file.
    pub(super) fn svg(mut self) -> String {
        self.put_letters();
        let legend = self.entries();
        let widest = legend.iter().map(|(_, name)| name.width()).max();
        let beside = widest.map_or(0.0, |columns| 44.0 + 7.2 * columns as f64);
        let [width, height] = self.size;
        let is_titled = self.panels.iter().any(|panel| !panel.title.is_empty());
        let is_numbered = |axis: &Axis| !matches!(axis.ticks, Ticks::None) || !axis.label.is_empty();
        let ticks = |panel: &Panel| panel.y.marks(ticks_in(height, EACH_UP)).0;
        let longest = self.panels.iter().flat_map(ticks).map(|(_, text)| text.width()).max().unwrap_or(0);
        let left = match self.panels.iter().any(|panel| is_numbered(&panel.y)) {
            true => LEFT.max(32.0 + DIGIT * longest as f64),
            false => MARGIN,
        };
        let below = if self.panels.iter().any(|panel| is_numbered(&panel.x)) { BELOW } else { MARGIN };
        let above = if is_titled { LINE } else { 0.0 };
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let [across, down] = [left + width + MARGIN, above + height + below];
        let top = MARGIN + LINE + 6.0;
        let titles = MARGIN * 2.0 + 8.4 * self.title.width() as f64;
        let total = (columns as f64 * across + beside + MARGIN).max(titles);
        let least = LINE * legend.len() as f64;
        let deep = top + (rows as f64 * down).max(least) + MARGIN * 0.5;
        let mut out = String::new();
        self.open(&mut out, [total, deep]);
        for (at, panel) in self.panels.iter().enumerate() {
            let [x, y] = [(at % columns) as f64 * across + left, top + (at / columns) as f64 * down + above];
            draw(&mut out, panel, [x, y, left], self.size);
        }
        let x = columns as f64 * across + MARGIN;
        for (at, (sample, name)) in legend.iter().enumerate() {
            entry(&mut out, sample, name, [x, top + above + LINE * (at as f64 + 0.5)]);
        }
        out.push_str("</svg>\n");
        out
    }

    /// Names of curves, each once, and what else is said.
    fn entries(&mut self) -> Vec<(Sample, String)> {
        let mut legend: Vec<(Sample, String)> = Vec::new();
        for curve in self.panels.iter().flat_map(|panel| &panel.curves) {
            if !curve.name.is_empty() && legend.iter().all(|(_, name)| *name != curve.name) {
                legend.push((Sample::Curve(curve.colour, curve.stroke), curve.name.clone()));
            }
        }
        legend.append(&mut self.legend);
        legend
    }

    fn open(&self, out: &mut String, [width, height]: [f64; 2]) {
        let id = name_of(&[&self.title, &self.description]);
        let (title, description) = (escaped(&self.title), escaped(&self.description));
        let _ = write!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"librate-plot\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             role=\"img\" aria-labelledby=\"{id}t {id}d\">\n<title id=\"{id}t\">{title}</title>\n<desc id=\"{id}d\">{description}</desc>\n\
             <style>{STYLE}</style>\n<rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n\
             <text class=\"title\" x=\"{MARGIN}\" y=\"{}\">{title}</text>\n",
            MARGIN + 12.0,
            w = place(width),
            h = place(height),
        );
    }
}

/// `Motion: three_pendulums`
pub(super) fn titled(what: &str, model: Option<&str>) -> String {
    model.map_or_else(|| what.to_owned(), |name| format!("{what}: {name}"))
}

/// The name that a label begins with, before a unit or a remark; no symmetry class, as E'.
fn name_in(label: &str) -> Option<&str> {
    let name = label.split(' ').next()?.trim_end_matches(',');
    let letters = name.trim_end_matches('\'');
    let is_name = letters.starts_with(|c: char| c.is_alphabetic() && (letters == name || c.is_lowercase()));
    (is_name && letters.chars().all(|c| c.is_alphanumeric() || "_[],".contains(c))).then_some(name)
}

/// A name for what a page may hold several of.
fn name_of(texts: &[&str]) -> String {
    let bytes = texts.iter().flat_map(|text| text.bytes());
    // Fowler, Noll and Vo's hash.
    let hash =
        bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    format!("p{hash:016x}")
}

/// For text and attributes.
pub(super) fn escaped(text: &str) -> String {
    let visible = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>();
    visible.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A length in hundredths, as short as possible.
fn place(value: f64) -> String {
    shortest(value.clamp(-1e5, 1e5), 2)
}

/// With so many decimals but for zeros at the end.
fn shortest(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// So many numbers and names find room along an axis.
fn ticks_in(length: f64, each: f64) -> usize {
    ((length / each) as usize).max(2)
}

/// A panel whose upper left corner between the axes is at a place, with so much room on its left.
fn draw(out: &mut String, panel: &Panel, [left, top, beside]: [f64; 3], [width, height]: [f64; 2]) {
    let (x, y) = (&panel.x, &panel.y);
    if !panel.title.is_empty() {
        put_text(out, [left, top - 6.0], "", &panel.title);
    }
    // So many that names and numbers stand apart.
    let longest = match &x.ticks {
        Ticks::Names(names) => names.iter().map(|name| name.width()).max().unwrap_or(1),
        Ticks::Numbers | Ticks::Whole | Ticks::Powers | Ticks::None => 8,
    };
    let (across, x_scale) = x.marks(ticks_in(width, 9.0 * (longest as f64 + 1.0)));
    let (up, y_scale) = y.marks(ticks_in(height, EACH_UP));
    let bottom = top + height;
    let _ = writeln!(out, "<g class=\"small\">");
    for (value, text) in &across {
        let at = left + x.share(*value) * width;
        let _ = write!(out, "<path class=\"grid\" d=\"M{} {}V{}\"/>", place(at), place(top), place(bottom));
        // A long name at the border of the page is not cut.
        put_text(out, [at.max(3.4 * text.width() as f64 + 2.0), bottom + 16.0], MIDDLE, text);
    }
    for (value, text) in &up {
        let at = bottom - y.share(*value) * height;
        let _ = write!(out, "<path class=\"grid\" d=\"M{} {}H{}\"/>", place(left), place(at), place(left + width));
        put_text(out, [left - 7.0, at + 4.0], " text-anchor=\"end\"", text);
    }
    out.push_str("</g>\n");
    let [middle, half] = [left + 0.5 * width, top + 0.5 * height];
    if !x.label.is_empty() {
        put_text(out, [middle, bottom + 36.0], MIDDLE, &format!("{}{}", x.label, scaled(x_scale)));
    }
    if !y.label.is_empty() {
        let corner = [left - beside + 16.0, half];
        let turned = format!("{MIDDLE} transform=\"rotate(-90 {})\"", corner.map(place).join(" "));
        put_text(out, corner, &turned, &format!("{}{}", y.label, scaled(y_scale)));
    }
    // What is drawn ends at the frame.
    let frame = rectangle([left, top], [width, height]);
    let _ = writeln!(out, "<svg {frame}>");
    let on_page = |[a, b]: [f64; 2]| [x.share(a) * width, height - y.share(b) * height];
    if y.low < 0.0 && y.high > 0.0 && !matches!(y.ticks, Ticks::Names(_)) {
        let _ = writeln!(out, "<path class=\"zero\" d=\"M0 {}H{}\"/>", place(on_page([0.0, 0.0])[1]), place(width));
    }
    for cell in &panel.cells {
        let [[a, b], [c, d]] = cell.corners.map(on_page);
        let own = rectangle([a.min(c), b.min(d)], [(c - a).abs(), (d - b).abs()]);
        let _ = writeln!(out, "<rect {own}{}/>", shaded(cell.shade));
    }
    for curve in &panel.curves {
        draw_curve(out, curve, &on_page);
    }
    let _ = writeln!(out, "</svg>\n<rect class=\"frame\" {frame}/>");
}

/// A text with attributes besides its place.
fn put_text(out: &mut String, corner: [f64; 2], attributes: &str, text: &str) {
    let [x, y] = corner.map(place);
    let _ = writeln!(out, "<text x=\"{x}\" y=\"{y}\"{attributes}>{}</text>", escaped(text));
}

/// A place and a size as attributes.
fn rectangle(corner: [f64; 2], size: [f64; 2]) -> String {
    let ([x, y], [width, height]) = (corner.map(place), size.map(place));
    format!("x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"")
}

/// Behind a label: the power of ten that its numbers are divided by.
fn scaled(power: i32) -> String {
    let raised = superscript(&power.to_string()).filter(|_| power != 0);
    raised.map_or_else(String::new, |raised| format!(" / 10{raised}"))
}

fn shaded(shade: Option<f64>) -> String {
    match shade {
        Some(share) => format!(" class=\"c1 dot cell\" fill-opacity=\"{}\"", place(share)),
        None => " class=\"unknown dot cell\" fill-opacity=\"0.6\"".to_owned(),
    }
}

fn draw_curve(out: &mut String, curve: &Curve, on_page: &dyn Fn([f64; 2]) -> [f64; 2]) {
    let colour = curve.colour % COLOURS;
    let pieces = curve.points.split(|point| !point.iter().all(|value| value.is_finite()));
    for piece in pieces.filter(|piece| !piece.is_empty()) {
        let points: Vec<[f64; 2]> = piece.iter().copied().map(on_page).collect();
        let (class, is_point) = match curve.stroke {
            // Colours come again, with another stroke.
            Stroke::Solid if curve.colour / COLOURS % 2 == 1 => ("line dashed", false),
            Stroke::Dashed if curve.colour / COLOURS % 2 == 1 => ("line dotted", false),
            Stroke::Solid | Stroke::Stems => ("line", false),
            Stroke::Dashed => ("line dashed", false),
            Stroke::Thin => ("line thin", false),
            Stroke::Dots => ("dot", true),
            Stroke::Rings => ("ring", true),
        };
        if curve.stroke == Stroke::Stems {
            let feet = piece.iter().map(|[x, _]| on_page([*x, 0.0])[1]);
            let stems =
                points.iter().zip(feet).map(|([x, y], foot)| format!("M{} {}V{}", place(*x), place(foot), place(*y)));
            let _ = writeln!(out, "<path class=\"c{colour} line\" d=\"{}\"/>", stems.collect::<String>());
        } else if is_point || points.len() == 1 {
            let class = if is_point { class } else { "dot" };
            for [x, y] in points {
                let _ = writeln!(
                    out,
                    "<circle class=\"c{colour} {class}\" cx=\"{}\" cy=\"{}\" r=\"3\"/>",
                    place(x),
                    place(y)
                );
            }
        } else {
            let _ = writeln!(out, "<path class=\"c{colour} {class}\" d=\"{}\"/>", path(&points));
        }
    }
}

/// Cubic pieces through points where one coordinate rises from each to the next, straight ones where not.
fn path(points: &[[f64; 2]]) -> String {
    let mut out = String::new();
    let Some([x, y]) = points.first() else { return out };
    let _ = write!(out, "M{} {}", place(*x), place(*y));
    let rises = points.windows(2).all(|pair| matches!(pair, [a, b] if b[0] > a[0]));
    if !rises || points.len() < 3 || points.len() > MOST_SMOOTH {
        for [x, y] in &points[1..] {
            let _ = write!(out, "L{} {}", place(*x), place(*y));
        }
        return out;
    }
    let slopes = slopes(points);
    for ((pair, from), to) in points.windows(2).zip(&slopes).zip(&slopes[1..]) {
        let [[a, b], [c, d]] = [pair[0], pair[1]];
        let third = (c - a) / 3.0;
        let numbers = [a + third, b + from * third, c - third, d - to * third, c, d].map(place);
        let _ = write!(out, "C{}", numbers.join(" "));
    }
    out
}

/// Slopes with which cubic pieces rise and fall where their ends do (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300).
fn slopes(points: &[[f64; 2]]) -> Vec<f64> {
    let chords: Vec<[f64; 2]> = points
        .windows(2)
        .map(|pair| {
            let run = pair[1][0] - pair[0][0];
            [run, (pair[1][1] - pair[0][1]) / run]
        })
        .collect();
    let inner = chords.windows(2).map(|pair| {
        let [[h, s], [k, t]] = [pair[0], pair[1]];
        if s * t <= 0.0 {
            return 0.0;
        }
        let share = (h + 2.0 * k) / (3.0 * (h + k));
        s * t / (share * t + (1.0 - share) * s)
    });
    let first = chords.first().map(|chord| chord[1]);
    let last = chords.last().map(|chord| chord[1]);
    first.into_iter().chain(inner).chain(last).collect()
}

/// An entry of the legend, its middle at a height.
fn entry(out: &mut String, sample: &Sample, name: &str, [x, y]: [f64; 2]) {
    match sample {
        Sample::Curve(colour, stroke) => {
            let at = |x: f64| [x, y];
            let points = match stroke {
                Stroke::Dots | Stroke::Rings => vec![at(x + 11.0)],
                Stroke::Solid | Stroke::Dashed | Stroke::Thin | Stroke::Stems => vec![at(x), at(x + 22.0)],
            };
            let stroke = if *stroke == Stroke::Stems { Stroke::Solid } else { *stroke };
            draw_curve(out, &Curve { name: String::new(), colour: *colour, stroke, points }, &|point| point);
        }
        Sample::Cell(shade) => {
            let own = rectangle([x, y - 6.0], [22.0, 12.0]);
            let _ = writeln!(out, "<rect {own}{}/><rect class=\"frame\" {own}/>", shaded(*shade));
        }
        Sample::Nothing => {}
    }
    put_text(out, [x + 30.0, y + 4.5], "", name);
}
