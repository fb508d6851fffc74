//! Frequencies and shapes as a table to read.

use std::borrow::Cow;

use super::plain::wrapped;
use super::runs::ends;
use super::table::{Column, GAP, draw};
use super::{
    Exponent, FrequencyUnit, Style, Tone, Written, common, counted, damping, headline, limit_words, listed, shown_unit,
    with_unit, zero_motions,
};
use librate_core::linearize::{Linearized, Origin};
use librate_core::model::Coordinates;
use librate_core::modes::exponents::Limit;
use librate_core::modes::{Kind, Method, Options, Stability};
use librate_core::order::{Gather, Order};
use librate_core::oscillation::{NormalMode, NormalModes, Normalization};
use librate_core::precision::{Ball, Big, Scalar, one_digit_up_text};

/// With more coordinates than this, a shape names its largest components only.
const MOST_COMPONENTS: usize = 6;
/// Digits of a component of a shape.
const SHAPE_DIGITS: usize = 4;
/// Digits of a component where the shape names its largest ones.
const ROUGH_DIGITS: usize = 2;
/// A component that is known no better than this beside the largest one, and may be 0, is no 0.
const VAGUE_SHARE: f64 = 5e-4;
/// Characters of a shape.
const MOST_HEIGHTS: usize = 30;
/// Parts of a shape that are smaller a quarter of a period later than this part of the largest are not seen.
const COMMON_PHASE: f64 = 0.05;
/// A list of the equilibrium's coordinates ends here.
const MOST_LISTED: usize = 12;
/// So many components are searched at a time for the largest ones.
const PART: usize = 1000;
/// Of more components than these that print alike, the largest are shown.
const MOST_COMPARED: usize = 200;
/// A list of groups of equal modes ends here.
const MOST_GROUPS: usize = 5;
/// Beyond this share of a frequency an uncertainty is not small: the second order is felt.
const ROUGH_SHARE: f64 = 0.3;
/// With less room than this beside the frequencies, shapes stand below them.
const LEAST_SHAPE: usize = 30;

/// The name of a model, and how many coordinates, constraints and massless directions it has.
pub(super) fn heading(linearized: &Linearized) -> String {
    let mut heading = headline(linearized.model().name.as_deref(), linearized.coordinates());
    if linearized.is_constrained() {
        let constraints = counted(linearized.constraints(), "constraint");
        heading.push_str(&format!(", {constraints}"));
    }
    if linearized.massless_directions() > 0 {
        let massless = counted(linearized.massless_directions(), "massless direction");
        heading.push_str(&format!(", {massless}"));
    }
    let follow = &linearized.model().follow;
    if !follow.is_empty() {
        let names = ends(follow.clone()).join(", ");
        let follow = if follow.len() == 1 { "follows" } else { "follow" };
        heading.push_str(&format!("; {names} {follow} from the conditions"));
    }
    heading
}

/// The modes of a model as text: a headline, the equilibrium, its stability and a table with one
/// line a mode.
///
/// `options` are those that the modes were computed with. Frequencies have `options.digits`
/// correctly rounded digits or, where the bounds decide fewer, those, and a remark below the table.
#[must_use]
pub fn modes_text(linearized: &Linearized, modes: &NormalModes, options: &Options, style: &Style) -> String {
    let model = linearized.model();
    let count = linearized.mode_count();
    let mut out = style.paint(Tone::Heading, &heading(linearized)) + "\n";
    out.push_str(&equilibrium_text(linearized, options, style));
    out.push_str(&rates_text(linearized, options, style));
    let (tone, word) = (stability_tone(modes.stability), modes.stability.as_str());
    let secular = if modes.secular == Some(true) { ", secular growth: motions grow as powers of t" } else { "" };
    out.push_str(&format!("stability: {}{secular}\n", style.paint(tone, word)));
    if let Some(group) = &modes.point_group {
        out.push_str(&format!("point group: {group}\n"));
    }
    out.push('\n');
    // A count of all eigenvalues up to there is part of the bounds.
    let proved = if modes.method.is_some() { ", counted: none is missing" } else { "" };
    match (modes.modes.len(), options.near) {
        (some, _) if modes.method == Some(Method::Given) => {
            out.push_str(&format!("{some} of {count} modes, from given vectors, none between them missing\n"));
        }
        // The number of all is not known beforehand where friction holds what has no inertia.
        // Fewer than were asked for are all there are.
        (some, _)
            if some >= count
                || linearized.is_first_order()
                || options.lowest.is_none_or(|own| own > some) && options.near.is_none() => {}
        (1, None) => out.push_str(&format!("the lowest of {count} modes{proved}\n")),
        (some, None) => out.push_str(&format!("the {some} lowest of {count} modes{proved}\n")),
        (1, Some((omega, _))) => out.push_str(&format!("the mode nearest to {omega} rad/s of {count}{proved}\n")),
        (some, Some((omega, _))) => {
            out.push_str(&format!("the {some} modes nearest to {omega} rad/s of {count}{proved}\n"));
        }
    }
    let unit = style.unit.or(model.has_units.then_some(FrequencyUnit::Hertz));
    let rows: Vec<Row> = modes.modes.iter().map(|mode| Row::new(mode, options, unit)).collect();
    let common = common(model.coordinates.iter().map(shown_unit));
    let names = Headings { coordinates: &model.coordinates, with_unit: common.is_none() };
    let motions = zero_motions(modes, count);
    let motion = if let [only] = motions[..] { Some(only) } else { None };
    out.push_str(&table(&modes.modes, &rows, &names, motion, model.has_units, style));
    let remarks = remarks(modes, &rows, &motions, options, style);
    if let Some(unit) = common
        && options.vectors
        && !modes.modes.is_empty()
    {
        let complex = modes.modes.iter().any(|mode| !mode.imaginary.is_empty());
        let transposed = if complex { 'H' } else { 'T' };
        out.push_str(&match modes.normalization {
            Normalization::Mass => format!("\nshapes in {unit}, x^{transposed} M x = 1 kg*m^2\n"),
            Normalization::Largest => "\nshapes with 1 for their largest component\n".to_owned(),
        });
    }
    out.push_str(&remarks);
    out
}

/// What a page has beside the exponents of the modes.
pub(super) struct Beside {
    pub(super) bounds: Vec<String>,
    /// Empty without units.
    pub(super) hertz: Vec<String>,
    /// What the zero modes are; empty where there is more than one answer, or none.
    pub(super) motions: Vec<String>,
    /// What is said of several modes.
    pub(super) remarks: Vec<String>,
}

impl Beside {
    pub(super) fn new(linearized: &Linearized, modes: &NormalModes, options: &Options) -> Self {
        let unit = linearized.model().has_units.then_some(FrequencyUnit::Hertz);
        let rows: Vec<Row> = modes.modes.iter().map(|mode| Row::new(mode, options, unit)).collect();
        let motions = zero_motions(modes, linearized.mode_count());
        let style = Style { width: usize::from(u16::MAX), ..Style::default() };
        let remarks = remarks(modes, &rows, &motions, options, &style);
        let motion = |mode: &NormalMode| match (mode.kind, &motions[..]) {
            (Kind::Zero, [only]) => (*only).to_owned(),
            _ => String::new(),
        };
        let motions: Vec<String> = modes.modes.iter().map(motion).collect();
        Self {
            bounds: rows.iter().map(Row::bound).collect(),
            hertz: unit.map_or_else(Vec::new, |_| rows.iter().map(|row| row.hertz.clone()).collect()),
            motions: if motions.iter().all(String::is_empty) { Vec::new() } else { motions },
            remarks: remarks.lines().filter(|line| !line.is_empty()).map(str::to_owned).collect(),
        }
    }
}

pub(super) fn stability_tone(stability: Stability) -> Tone {
    match stability {
        Stability::Stable => Tone::Good,
        Stability::Neutral | Stability::Undecided => Tone::Careful,
        Stability::Unstable => Tone::Bad,
    }
}

fn kind_tone(kind: Kind) -> Option<Tone> {
    match kind {
        Kind::Oscillation | Kind::Damped | Kind::Overdamped => None,
        Kind::Zero | Kind::Undecided => Some(Tone::Careful),
        Kind::Unstable => Some(Tone::Bad),
    }
}

fn equilibrium_text(linearized: &Linearized, options: &Options, style: &Style) -> String {
    let equilibrium = linearized.equilibrium();
    let origins = &equilibrium.origins;
    let given = origins.contains(&Origin::Given);
    let found = origins.contains(&Origin::Found);
    let steps = format!("found in {}", counted(equilibrium.steps, "step"));
    let zero = equilibrium.values.iter().all(Ball::is_zero);
    let mixed =
        given && origins.iter().any(|origin| *origin != Origin::Given) || found && origins.contains(&Origin::Zero);
    let how = match (given, found) {
        (_, true) => format!(" ({steps})"),
        (true, false) if !mixed => " (given)".to_owned(),
        (true | false, false) => String::new(),
    };
    if zero {
        let all = if equilibrium.values.len() == 1 { "0" } else { "all coordinates 0" };
        return format!("equilibrium: {all}{how}\n");
    }
    let coordinates = &linearized.model().coordinates;
    let common = common(coordinates.iter().map(shown_unit));
    let largest = equilibrium.values.iter().map(|value| value.mid_f64().abs()).fold(0.0, f64::max);
    let mut items: Vec<String> = coordinates
        .iter()
        .zip(&equilibrium.values)
        .zip(origins)
        .take(MOST_LISTED)
        .map(|((coordinate, value), origin)| {
            let remark = if mixed && *origin == Origin::Given { " (given)" } else { "" };
            let written = known(value, largest, options.digits);
            let unit = shown_unit(coordinate).filter(|_| common.is_none());
            let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
            format!("{} = {written}{unit}{remark}", coordinate.name())
        })
        .collect();
    let count = equilibrium.values.len();
    items.extend((count > MOST_LISTED).then(|| format!("… ({} more)", count - MOST_LISTED)));
    let unit = common.map_or_else(String::new, |unit| format!(" in {unit}"));
    listed(&format!("equilibrium{unit}{how}"), &items, style.width)
}

/// The rates of a steady motion.
fn rates_text(linearized: &Linearized, options: &Options, style: &Style) -> String {
    let model = linearized.model();
    let turning = model.coordinates.iter().zip(model.rates.iter()).zip(linearized.rates());
    let items: Vec<String> = turning
        .filter(|((_, given), _)| given.is_some())
        .map(|((coordinate, _), rate)| {
            format!("{}' = {}", coordinate.name(), Written::new(&rate, options.digits).text())
        })
        .collect();
    if items.is_empty() { String::new() } else { listed("steady motion", &items, style.width) }
}

/// A coordinate with the digits that are decided; where these are fewer than asked for, with its bound,
/// unless it is 0 in all places that the largest coordinate has.
fn known(value: &Ball, largest: f64, digits: usize) -> String {
    let written = Written::new(value, digits);
    let places = i32::try_from(digits).unwrap_or(i32::MAX);
    let nothing = value.abs_upper() <= 0.5 * largest * 10f64.powi(-places);
    if written.complete {
        written.text()
    } else if nothing {
        "0".to_owned()
    } else {
        format!("{} (bound {})", written.text(), one_digit_up_text(written.bound))
    }
}

/// The coordinates at the heads of their columns.
struct Headings<'a> {
    coordinates: &'a Coordinates,
    with_unit: bool,
}

impl Headings<'_> {
    fn name(&self, at: usize) -> String {
        self.coordinates.get(at).map_or_else(String::new, |own| own.name())
    }

    fn with_unit(&self, at: usize) -> String {
        let unit = self.coordinates.get(at).filter(|_| self.with_unit).and_then(shown_unit);
        with_unit(&self.name(at), unit)
    }
}

/// The numbers of a mode in writing.
struct Row {
    own: Exponent,
    /// The damping ratio and the quality factor.
    damping: [String; 2],
    hertz: String,
}

impl Row {
    fn new(mode: &NormalMode, options: &Options, unit: Option<FrequencyUnit>) -> Self {
        let hertz = if let Some(size) = unit.and_then(FrequencyUnit::of_hertz) {
            let precise = mode.precise.as_deref();
            let of_radian = Ball::from_number(&size, ()) / Ball::PI.scale(1);
            let turns = mode.omega * of_radian;
            let precise = precise.map(|x| {
                let bits = x.omega.bits();
                &x.omega * &(&Big::from_number(&size, bits) / &Big::pi(bits).scale(1))
            });
            let sigma = mode.uncertainty.as_ref().and_then(|own| own.omega).map(|sigma| sigma * of_radian);
            Written::measured(&turns, precise.as_ref(), sigma.as_ref(), options.digits).0.text()
        } else {
            String::new()
        };
        let damping = damping(mode, options.digits).map_or_else(Default::default, |own| own.map(|own| own.text()));
        Self { own: Exponent::new(mode, options.digits), damping, hertz }
    }

    fn bound(&self) -> String {
        one_digit_up_text(self.own.omega.bound.max(self.own.growth.bound))
    }

    /// Whether all digits asked for are there.
    fn is_complete(&self) -> bool {
        self.own.omega.complete && self.own.growth.complete
    }
}

fn table(
    modes: &[NormalMode],
    rows: &[Row],
    names: &Headings<'_>,
    motion: Option<&str>,
    has_units: bool,
    style: &Style,
) -> String {
    if modes.is_empty() {
        return "there are no degrees of freedom: constraints, or what has no inertia, leave no motion\n".to_owned();
    }
    let of = |text: fn(&Row) -> String| rows.iter().map(text).collect();
    let heading = |plain: &str, unit: &str| with_unit(plain, has_units.then_some(unit));
    let mut columns = vec![
        Column::counting("mode", modes.len()),
        Column::numbers(&heading("omega", "rad/s"), of(|row| row.own.omega.text())),
    ];
    let uncertain = modes.iter().any(|mode| mode.uncertainty.is_some());
    columns.extend(uncertain.then(|| Column::numbers("sigma", of(|row| row.own.omega_sigma.clone()))));
    if modes.iter().any(|mode| !mode.growth.is_zero()) {
        columns.push(Column::numbers(&heading("growth", "1/s"), of(|row| row.own.growth.text())));
        columns.extend(uncertain.then(|| Column::numbers("sigma", of(|row| row.own.growth_sigma.clone()))));
    }
    columns.push(Column::right("bound", of(Row::bound)));
    let unit = style.unit.or(has_units.then_some(FrequencyUnit::Hertz));
    columns.extend(unit.map(|unit| Column::numbers(&format!("f ({})", unit.as_str()), of(|row| row.hertz.clone()))));
    let kinds = modes.iter().map(|mode| mode.kind.as_str().to_owned()).collect();
    columns.push(Column::words("kind", kinds));
    if modes.iter().any(|mode| mode.symmetry.is_some()) {
        let cells = modes.iter().map(|mode| mode.symmetry.clone().unwrap_or_default());
        columns.push(Column::words("symmetry", cells.collect()));
    }
    let meaning = motion.map(|motion| {
        let cells = modes.iter().map(|mode| match mode.kind {
            Kind::Zero => motion.to_owned(),
            Kind::Oscillation | Kind::Unstable | Kind::Damped | Kind::Overdamped | Kind::Undecided => String::new(),
        });
        Column::words("motion", cells.collect())
    });
    let painted = |at: usize| {
        let kind = modes.get(at)?.kind;
        Some((kind_tone(kind)?, kind.as_str()))
    };
    let width = |columns: &[Column]| columns.iter().map(Column::width).sum::<usize>();
    let mut tables = Vec::new();
    // What finds no room beside the columns begins a table; nothing separates a last column from a next one.
    let mut beside = |columns: &mut Vec<Column>, next: &[Column]| {
        if !next.is_empty() && width(columns) + width(next) > style.width + GAP {
            tables.push(std::mem::replace(columns, vec![Column::counting("mode", modes.len())]));
        }
    };
    if rows.iter().any(|row| !row.damping[0].is_empty()) {
        let damping = [("zeta", 0), ("Q", 1)]
            .map(|(name, at)| Column::numbers(name, rows.iter().map(|row| row.damping[at].clone()).collect()));
        beside(&mut columns, &damping);
        columns.extend(damping);
    }
    beside(&mut columns, meaning.as_slice());
    let shapes = modes.iter().any(|mode| !mode.vector.is_empty());
    let used = width(&columns) + meaning.iter().map(Column::width).sum::<usize>();
    let beside = if shapes { shape(modes, names, style.width.saturating_sub(used)) } else { Some(Vec::new()) };
    let has_room = beside.is_some();
    columns.extend(beside.unwrap_or_default());
    columns.extend(meaning);
    tables.push(columns);
    if !has_room {
        // No room beside the frequencies: the shapes have a table of their own.
        let room = style.width.saturating_sub(Column::counting("mode", modes.len()).width());
        let shapes = shape(modes, names, room).unwrap_or_else(|| vec![largest_of(modes, names, room)]);
        tables.push(std::iter::once(Column::counting("mode", modes.len())).chain(shapes).collect());
    }
    tables.iter().map(|columns| draw(columns, modes.len(), painted, style)).collect::<Vec<_>>().join("\n")
}

/// The shapes: a column a coordinate where there are few, else heights and the largest components by name;
/// `None` where there is not enough room.
fn shape(modes: &[NormalMode], names: &Headings<'_>, room: usize) -> Option<Vec<Column>> {
    if names.coordinates.len() > MOST_COMPONENTS {
        return by_name(modes, names, room);
    }
    let columns: Vec<Column> = (0..names.coordinates.len())
        .map(|at| {
            let parts = modes.iter().flat_map(|mode| {
                let of = |part: &[f64]| part.get(at).copied();
                // What may be 0 has no size.
                let certain = |x: &f64| x.abs() > mode.error_bound_of(at);
                of(&mode.vector).into_iter().chain(of(&mode.imaginary)).filter(certain).collect::<Vec<f64>>()
            });
            let parts: Vec<f64> = parts.collect();
            let power = common_power([parts.as_slice()]);
            let cells = modes.iter().map(|mode| component(mode, at, power, SHAPE_DIGITS));
            Column::numbers(&over_power(&names.with_unit(at), power), cells.collect())
        })
        .collect();
    let width: usize = columns.iter().map(Column::width).sum();
    // Nothing separates the last column from a next one.
    (width <= room + GAP).then_some(columns)
}

fn by_name(modes: &[NormalMode], names: &Headings<'_>, room: usize) -> Option<Vec<Column>> {
    let shapes: Vec<String> = modes.iter().map(sparkline).collect();
    let heading = if shapes.iter().any(|own| own.contains(' ')) { "shape, and a quarter later" } else { "shape" };
    let mut columns = vec![Column::words(heading, shapes)];
    let left = room.saturating_sub(columns.iter().map(Column::width).sum());
    columns.push(largest_of(modes, names, left));
    (left >= LEAST_SHAPE).then_some(columns)
}

fn largest_of(modes: &[NormalMode], names: &Headings<'_>, room: usize) -> Column {
    let power = common_power(modes.iter().flat_map(|mode| [mode.vector.as_slice(), &mode.imaginary]));
    let cells = modes.iter().map(|mode| largest(mode, names, power, room)).collect();
    Column::words(&over_power("largest", power), cells)
}

/// A shape by the heights of characters, the coordinates in their order: half height for 0. Of more coordinates than there are characters
/// the largest of those side by side. Where coordinates do not move in phase, those a quarter of a period later follow.
fn sparkline(mode: &NormalMode) -> String {
    let top = greatest(&sizes(mode));
    if mode.imaginary.is_empty() {
        return heights(&mode.vector, top);
    }
    // From where the first of the largest is farthest.
    let Some(first) = mode.leading() else { return String::new() };
    let [c, s] = [mode.vector[first], mode.imaginary[first]].map(|part| part / mode.modulus(first));
    let parts = mode.vector.iter().zip(&mode.imaginary);
    let now: Vec<f64> = parts.clone().map(|(re, im)| c * re + s * im).collect();
    let later: Vec<f64> = parts.map(|(re, im)| s * re - c * im).collect();
    let is_common = later.iter().all(|own| own.abs() <= COMMON_PHASE * top);
    if is_common { heights(&now, top) } else { format!("{} {}", heights(&now, top), heights(&later, top)) }
}

fn heights(parts: &[f64], top: f64) -> String {
    const HEIGHTS: [char; 9] = ['▁', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let each = parts.len().div_ceil(MOST_HEIGHTS).max(1);
    let height = |own: &[f64]| {
        let size = greatest(own);
        let share = own.iter().find(|x| x.abs() == size).map_or(0.0, |x| x / top);
        // Shares between two heights are the lower on every machine.
        let steps = (4.0 * share.abs() + 0.5 - 1e-6).floor().clamp(0.0, 4.0) as usize;
        HEIGHTS[if share < 0.0 { 4 - steps } else { 4 + steps }]
    };
    parts.chunks(each).map(height).collect()
}

/// The sizes of components; of real ones with their signs.
fn sizes(mode: &NormalMode) -> Cow<'_, [f64]> {
    match mode.imaginary.as_slice() {
        [] => Cow::Borrowed(&mode.vector),
        _ => (0..mode.vector.len()).map(|at| mode.modulus(at)).collect(),
    }
}

/// The size of the largest of some numbers.
fn greatest(numbers: &[f64]) -> f64 {
    // As one instruction a number; `f64::max` takes several.
    numbers.iter().fold(0.0, |top, x| if x.abs() > top { x.abs() } else { top })
}

/// The power of ten that is written once over a column: normalised shapes of molecules are of the
/// order 1e13. 0 where the numbers are handy as they are.
fn common_power<'a>(values: impl IntoIterator<Item = &'a [f64]>) -> i32 {
    let top = values.into_iter().map(greatest).fold(0.0, f64::max);
    if top == 0.0 || !top.is_finite() || (1e-2..1e4).contains(&top) { 0 } else { top.log10().floor() as i32 }
}

/// `x / 1e13`: the heading of a column whose numbers are divided by a power of ten.
fn over_power(name: &str, power: i32) -> String {
    if power == 0 { name.to_owned() } else { format!("{name} / 1e{power}") }
}

/// A component over a power of ten, with the digits its bound decides: `0.5000`, `0.5000 - 0.1000i`.
fn component(mode: &NormalMode, at: usize, power: i32, digits: usize) -> String {
    let ten = Ball::from(10.0).powi(power.abs());
    let bound = mode.error_bound_of(at);
    let tells = |at: usize| mode.error_bound_of(at) <= VAGUE_SHARE * mode.modulus(at);
    let vague = !(0..mode.vector.len()).any(tells);
    let written = |value: f64| {
        let value = Ball::from(value).with_added_radius(bound);
        let scaled = if power < 0 { value * ten } else { value / ten };
        let text = Written::new(&scaled, digits).text();
        // What may be 0, or else as large as others, is not called 0.
        if vague && text == "0" { "?".to_owned() } else { text }
    };
    let real = mode.vector.get(at).copied().unwrap_or(0.0);
    let imaginary = mode.imaginary.get(at).copied().unwrap_or(0.0);
    // What may be 0 is no part.
    let counts = |part: f64, other: f64| part.abs() > bound && part.abs() > 1e-13 * other.abs();
    if !counts(imaginary, real) || mode.imaginary.is_empty() {
        return written(real);
    }
    let sign = if imaginary < 0.0 { "-" } else { "+" };
    let size = written(imaginary.abs());
    if !counts(real, imaginary) {
        let sign = sign.trim_start_matches('+');
        return format!("{sign}{size}i");
    }
    format!("{} {sign} {size}i", written(real))
}

/// `phi[1] 0.50, phi[2] -0.50, …`: the components by falling size, as many as there is room for.
fn largest(mode: &NormalMode, names: &Headings<'_>, power: i32, room: usize) -> String {
    // Sizes are compared as printed, so that equal ones stay in order whatever their rounding errors.
    let sizes = sizes(mode);
    let parts = || sizes.chunks(PART).enumerate().map(|(number, part)| (number * PART, part));
    let tops: Vec<f64> = parts().map(|(_, part)| greatest(part)).collect();
    // A thousandth of the largest can't be seen in a shape.
    let least = greatest(&tops) * 1e-3;
    let from = |least: f64| {
        let high = parts().zip(&tops).filter(move |(_, top)| **top >= least);
        let all = high.flat_map(|((first, part), _)| part.iter().zip(first..));
        let own = all.map(|(x, at)| (x.abs(), at)).filter(move |own| own.0 >= least);
        own.filter(|(size, at)| *size > mode.error_bound_of(*at))
    };
    // Of a million only those are ordered that are as large as the last shown can be: parts have one as large each.
    let mut high: Vec<f64> = tops.clone();
    high.order_by(|a, b| b.total_cmp(a));
    let is_certain = greatest(&mode.component_error_bounds).max(mode.vector_error_bound) < least;
    let last = high.get(MOST_COMPONENTS).filter(|_| is_certain);
    let mut order: Vec<(f64, usize)> = from(last.map_or(least, |own| own.max(least))).collect();
    if order.len() > MOST_COMPONENTS {
        order.select_nth_unstable_by(MOST_COMPONENTS, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        // Two digits are within 5 % of the number: below nine tenths of the last that may be shown
        // nothing can print as large.
        let near: Vec<_> = from(least.max(0.9 * order[MOST_COMPONENTS].0)).take(MOST_COMPARED + 1).collect();
        order.truncate(MOST_COMPONENTS);
        if near.len() <= MOST_COMPARED {
            order = near;
        }
    }
    let mut texts: Vec<(f64, usize, String)> = order
        .into_iter()
        .map(|(_, at)| {
            let text = component(mode, at, power, ROUGH_DIGITS);
            let size = text.parse().map_or_else(|_| mode.modulus(at) / 10f64.powi(power), f64::abs);
            (size, at, text)
        })
        .collect();
    texts.order_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut out = String::new();
    let mut used = 0;
    let count = texts.len();
    for (rank, (_, at, text)) in texts.into_iter().enumerate() {
        let name = names.name(at);
        let separator = if rank == 0 { "" } else { ", " };
        let item = format!("{separator}{name} {text}");
        let size = item.chars().count();
        let rest = if rank + 1 < count { 3 } else { 0 };
        if rank >= MOST_COMPONENTS || rank > 0 && used + size + rest > room {
            out.push_str(", …");
            break;
        }
        out.push_str(&item);
        used += size;
    }
    out
}

/// What the table can't say.
fn remarks(modes: &NormalModes, rows: &[Row], motions: &[&str], options: &Options, style: &Style) -> String {
    let mut first = String::new();
    if motions.len() > 1 {
        let zero = of_kind(modes, Kind::Zero);
        let together = if zero.len() > 1 { "together are" } else { "represents" };
        let title = format!("{} {together}", numbered(&zero));
        first = listed(&title, &alike_together(motions), style.width);
    }
    let mut out = String::new();
    if modes.gyroscopically_stabilised {
        out.push_str("gyroscopically stabilised: the potential has no minimum here, but the motion is stable\n");
    }
    for block in limited(&modes.modes) {
        if let Some(mode) = block.first().and_then(|at| modes.modes.get(*at))
            && let Some(limit) = &mode.limit
        {
            let words = limit_words(limit, mode.kind);
            out.push_str(&format!("{}: {words}\n", numbered(&block)));
        }
    }
    out.push_str(&clusters_remark(&clusters(modes)));
    out.push_str(&uncertainty_remark(modes));
    let undecided = of_kind(modes, Kind::Undecided);
    let damped = undecided.iter().any(|at| modes.modes[*at].omega.is_positive());
    if !undecided.is_empty() {
        let list = numbered(&undecided);
        out.push_str(&format!(
            "{}: {} of {list} can't be distinguished from zero within its bound, so it may {}\n",
            style.paint(Tone::Careful, "undecided"),
            if damped { "the growth" } else { "omega^2" },
            if damped { "grow, decay or neither" } else { "oscillate, grow or rest" },
        ));
    } else if modes.stability == Stability::Undecided {
        out.push_str("the stability is undecided: the bounds do not decide it\n");
    }
    let short: Vec<usize> = (0..rows.len()).filter(|at| !rows[*at].is_complete() && !undecided.contains(at)).collect();
    if !short.is_empty() {
        out.push_str(&format!(
            "fewer than {} digits of {}: only those that are certain are printed\n",
            options.digits,
            numbered(&short)
        ));
    }
    first.extend(out.lines().flat_map(|line| wrapped(line, style.width)).map(|line| line + "\n"));
    if first.is_empty() { first } else { format!("\n{first}") }
}

/// Modes with shapes that bounds do not separate. What zero modes are is said elsewhere, and so it is where shapes are missing.
fn clusters(modes: &NormalModes) -> Vec<Vec<usize>> {
    let is_told = |mode: &NormalMode| mode.kind != Kind::Zero && !mode.vector.is_empty() && mode.limit.is_none();
    let told = modes.modes.iter().enumerate().filter(|(_, mode)| is_told(mode));
    let groups = told.map(|(at, mode)| (mode.cluster, at)).grouped().into_iter();
    groups.map(|(_, group)| group).filter(|group| group.len() > 1).collect()
}

/// That shapes of equal modes are one choice of many; of many clusters in one line.
fn clusters_remark(clusters: &[Vec<usize>]) -> String {
    let own = match clusters {
        [] => return String::new(),
        [_] => "the space that their shapes span",
        _ => "the space that the shapes of one group span",
    };
    let group = |modes: &Vec<usize>| numbered(modes).replace("modes ", "");
    let mut groups: Vec<String> = clusters.iter().take(MOST_GROUPS).map(group).collect();
    let more = clusters.len() - groups.len();
    groups.extend((more > 0).then(|| format!("and {more} more groups")));
    let groups = groups.join("; ");
    format!("modes {groups} are equal within their bounds: any other basis of {own} is equally valid, within them\n")
}

/// What the columns of uncertainties mean, and where they mean little.
fn uncertainty_remark(modes: &NormalModes) -> String {
    if modes.modes.iter().all(|mode| mode.uncertainty.is_none()) {
        return String::new();
    }
    let mut out =
        "sigma is the standard uncertainty that those of the parameters give; numbers end at its second digit\n\
                   shapes and the equilibrium are those of the values, as if these were exact\n"
            .to_owned();
    let mut remark = |test: &dyn Fn(&Ball, Option<Ball>) -> bool, words: &str| {
        let parts = |mode: &NormalMode| {
            let own = mode.uncertainty.as_ref()?;
            Some(test(&mode.omega, own.omega) || test(&mode.growth, own.growth))
        };
        let each = modes.modes.iter().enumerate();
        let those: Vec<usize> = each.filter(|(_, mode)| parts(mode) == Some(true)).map(|(at, _)| at).collect();
        if !those.is_empty() {
            out.push_str(&format!("sigma of {} is {words}\n", numbered(&those)));
        }
    };
    remark(
        &|_, sigma| sigma.is_none(),
        "none: the exponent has no derivative there, or none is proved, and all digits refer to the values",
    );
    let is_rough = |value: &Ball, sigma: Option<Ball>| {
        let sigma = sigma.map_or(0.0, |sigma| sigma.mid_f64());
        !value.contains_zero() && sigma > ROUGH_SHARE * value.mid_f64().abs()
    };
    remark(
        &is_rough,
        "not small compared with the number itself: it is of first order, and only a rough estimate there",
    );
    out
}

/// Modes whose digits or vectors are limited, those together that share the reason: the members of a Jordan block, or
/// exponents that are not told apart.
fn limited(modes: &[NormalMode]) -> Vec<Vec<usize>> {
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    for (at, mode) in modes.iter().enumerate() {
        let together = |count: usize| match mode.limit {
            None | Some(Limit::Open) => false,
            Some(Limit::Defective { order }) => mode.kind == Kind::Zero || count < order,
            Some(Limit::Unresolved { count: all }) => count < all,
        };
        if mode.limit.is_none() {
            continue;
        }
        let follows = |block: &&mut Vec<usize>| {
            let before = &modes[block[0]];
            together(block.len())
                && block.last() == Some(&(at - 1))
                && (before.limit, before.cluster, before.kind) == (mode.limit, mode.cluster, mode.kind)
        };
        match blocks.last_mut().filter(follows) {
            Some(block) => block.push(at),
            None => blocks.push(vec![at]),
        }
    }
    blocks
}

fn of_kind(modes: &NormalModes, kind: Kind) -> Vec<usize> {
    modes.modes.iter().enumerate().filter(|(_, mode)| mode.kind == kind).map(|(at, _)| at).collect()
}

/// `mode 3`, `modes 1, 2 and 5`, `modes 1 to 6`, `modes 1, 2, 5 and 40 more`
pub(super) fn numbered(modes: &[usize]) -> String {
    match modes {
        [] => "no mode".to_owned(),
        [only] => format!("mode {}", only + 1),
        [first, .., last] if last - first + 1 == modes.len() && modes.len() > 2 => {
            format!("modes {} to {}", first + 1, last + 1)
        }
        [some @ .., last] if some.len() < 6 => {
            let some: Vec<String> = some.iter().map(|at| (at + 1).to_string()).collect();
            format!("modes {} and {}", some.join(", "), last + 1)
        }
        all => {
            let some: Vec<String> = all.iter().take(5).map(|at| (at + 1).to_string()).collect();
            format!("modes {} and {} more", some.join(", "), all.len() - 5)
        }
    }
}

/// Motions with equal names are named once, with their number.
fn alike_together(meanings: &[&str]) -> Vec<String> {
    let groups = meanings.iter().map(|meaning| (*meaning, ())).grouped().into_iter();
    groups
        .map(|(meaning, all)| match all.len() {
            1 => meaning.to_owned(),
            count => format!("{meaning} ({count} times)"),
        })
        .collect()
}
