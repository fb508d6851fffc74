//! A model over a grid of one or two parameters, its modes followed from node to node: what the sliders of a page show.
//!
//! Each node is solved by itself and in full. Between nodes nothing is computed here: whoever draws a mode there interpolates, and
//! says so.

use crate::figure::{Figure, figure};
use crate::source::{Source, parameter};
use crate::sweep::{Place, Sweep};
use crate::tracking::{Shape, is_one_of_several, matched, shapes};
use librate_core::linearize::{Linearized, constant};
use librate_core::model::{Model, Range};
use librate_core::modes::Options;
use librate_core::order::Order;
use librate_core::oscillation::{NormalMode, NormalModes};

/// So many numbers of shapes over a grid are about 400 kB.
const MOST_NUMBERS: usize = 50_000;

/// Why parameters have no sliders.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// One parameter twice.
    #[error("`{name}` can't have two sliders")]
    Twice {
        /// Its name.
        name: String,
    },
    /// More than two parameters.
    #[error("a page has room for two sliders")]
    TooMany {},
    /// A single value, or too many.
    #[error("{counts} values are not for a slider")]
    Values {
        /// How many, with a cross between those of two parameters.
        counts: String,
        /// How many numbers the shapes at all of them have.
        numbers: usize,
    },
    /// The model can't be read at the ends of a range.
    #[error("{names} can't be moved")]
    Fixed {
        /// The parameters.
        names: String,
    },
}

impl GridError {
    /// What helps; `None` where it depends on how ranges are written.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Twice { .. } | Self::TooMany {} => None,
            Self::Values { numbers, .. } => Some(format!(
                "of each parameter two at least; shapes of all modes at all of them are {numbers} numbers, and a page has room for {MOST_NUMBERS}"
            )),
            Self::Fixed { .. } => Some("name parameters of the model and ends that these can have".to_owned()),
        }
    }
}

/// A parameter over its range.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// The unit that it is declared with.
    pub unit: Option<String>,
    /// How many nodes there are.
    pub count: usize,
    /// Its ends, in that unit, ...
    pub ends: [f64; 2],
    /// ... and in SI.
    pub ends_si: [f64; 2],
    /// Where the model's own value lies, from 0 to 1; outside the range nowhere.
    pub own: Option<f64>,
}

/// The model at a node.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Node {
    /// The equilibrium, in SI.
    pub equilibrium: Vec<f64>,
    /// How many modes there are.
    pub count: usize,
    /// What has become of each mode at the model's own values: shapes are turned so that they change steadily.
    pub modes: Vec<Option<NormalMode>>,
}

/// A model over a grid.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Grid {
    /// One or two parameters.
    pub axes: Vec<Axis>,
    /// The nodes, the last parameter changing fastest; nothing where the model has no modes.
    pub nodes: Vec<Option<Node>>,
    /// What is drawn, which moves with the parameters, too.
    pub figure: Option<Figure>,
}

/// The nodes of a grid, each of which can be solved for itself.
#[derive(Clone, Debug)]
pub struct Nodes {
    axes: Vec<Axis>,
    /// One for each value of the first of two parameters.
    lines: Vec<Sweep>,
}

impl Nodes {
    /// Over one or two ranges; `model` has the values of the file.
    ///
    /// # Errors
    /// [`GridError`] with what is wrong with the ranges.
    pub fn new(source: &Source, model: &Model, ranges: &[Range], options: &Options) -> Result<Self, GridError> {
        let (names, counts): (Vec<&str>, Vec<usize>) = ranges.iter().map(|own| (own.name(), own.len())).unzip();
        match names[..] {
            [first, second] if first == second => return Err(GridError::Twice { name: first.to_owned() }),
            [_] | [_, _] => {}
            _ => return Err(GridError::TooMany {}),
        }
        let n = model.coordinates.len();
        let numbers = counts.iter().fold(n * options.lowest.unwrap_or(n), |all, count| all.saturating_mul(*count));
        if counts.contains(&1) || numbers > MOST_NUMBERS {
            let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
            return Err(GridError::Values { counts: counts.join(" x "), numbers });
        }
        let source = Source { settings: source.settings.clone().with_points(), ..source.clone() };
        Self::of_parameters(&source, model, ranges, options).ok_or_else(|| {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            GridError::Fixed { names: names.join(" and ") }
        })
    }

    fn of_parameters(source: &Source, model: &Model, ranges: &[Range], options: &Options) -> Option<Self> {
        let sweep = |source: &Source, range: &Range| Sweep::by_places(source.clone(), range.clone(), options.clone());
        let axis = |range: &Range| {
            let sweep = sweep(source, range);
            let (from, to) = sweep.ends_si()?;
            let ends_si = [from.mid_f64(), to.mid_f64()];
            let number = parameter(model, range)?;
            let value = constant(&model.pool, model.parameters[number].value?).map(|value| value.mid_f64());
            let own = value.map(|value| (value - ends_si[0]) / (ends_si[1] - ends_si[0]));
            Some(Axis {
                name: range.name().to_owned(),
                unit: sweep.unit(),
                count: range.len(),
                ends: [sweep.value(0), sweep.value(range.len() - 1)],
                ends_si,
                own: own.filter(|share| (0.0..=1.0).contains(share)),
            })
        };
        let axes: Vec<Axis> = ranges.iter().map(axis).collect::<Option<_>>()?;
        let lines = match ranges {
            [range] => vec![sweep(source, range)],
            [first, second] => {
                let line = |place: usize| {
                    let value = format!("{} = {}", first.name(), first.expression(place));
                    let settings = source.settings_with(&[&value]).ok()?;
                    Some(sweep(&Source { settings, ..source.clone() }, second))
                };
                (0..first.len()).map(line).collect::<Option<_>>()?
            }
            _ => return None,
        };
        Some(Self { axes, lines })
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    /// The model at a node.
    pub fn place(&self, node: usize) -> Place {
        let across = self.count() / self.lines.len();
        self.lines[node / across].place(node % across)
    }

    /// The grid of all nodes in order, with shapes; modes are followed from those at the model's own values.
    #[must_use]
    pub fn followed(self, places: &[Place], (linearized, modes): (&Linearized, &NormalModes)) -> Grid {
        let names: Vec<&str> = self.axes.iter().map(|axis| axis.name.as_str()).collect();
        let solved = places.iter().find_map(|place| place.result.as_ref().ok());
        let figure = solved.and_then(|(linearized, _)| figure(linearized, &names));
        let counts: Vec<usize> = self.axes.iter().map(|axis| axis.count).collect();
        let across = counts.last().copied().unwrap_or(1);
        let nearest = |axis: &Axis| (axis.own.unwrap_or(0.5) * (axis.count - 1) as f64).round() as usize;
        let start = self.axes.iter().fold(0, |at, axis| at * axis.count + nearest(axis));
        let (row, column) = (start / across, start % across);
        let away = |node: usize| (node / across).abs_diff(row) + (node % across).abs_diff(column);
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.order_by_key(|node| away(*node));
        let mut nodes: Vec<Option<Node>> = vec![None; places.len()];
        let mut known: Vec<Option<Vec<Option<Followed>>>> = vec![None; places.len()];
        let own = shapes(linearized, modes);
        let count = linearized.model().coordinates.len();
        let own: Vec<Option<Followed>> =
            own.into_iter().zip(&modes.modes).map(|(shape, mode)| Some((shape, mode.clone()))).collect();
        for node in order {
            let Ok((linearized, modes)) = &places[node].result else { continue };
            let column = node % across;
            let beside = [(column > 0).then(|| node - 1), (column + 1 < across).then_some(node + 1)];
            let neighbours = beside.into_iter().chain([node.checked_sub(across), Some(node + across)]).flatten();
            let nearer = neighbours.filter(|own| *own < places.len() && away(*own) < away(node));
            let before = nearer.filter_map(|own| known[own].as_ref()).next().unwrap_or(&own);
            let found = follow(before, &shapes(linearized, modes), modes);
            let equilibrium = linearized.equilibrium().values.iter().take(count).map(|value| value.mid_f64()).collect();
            let all = modes.modes.len();
            let modes = found.iter().map(|own| own.as_ref().map(|(_, mode)| mode.clone())).collect();
            nodes[node] = Some(Node { equilibrium, count: all, modes });
            known[node] = Some(found);
        }
        Grid { axes: self.axes, nodes, figure }
    }
}

/// A mode with what it is compared by.
type Followed = (Shape, NormalMode);

/// The modes of a node in the order of those before it.
fn follow(before: &[Option<Followed>], here: &[Shape], modes: &NormalModes) -> Vec<Option<Followed>> {
    let known: Vec<usize> = (0..before.len()).filter(|at| before[*at].is_some()).collect();
    let old: Vec<Shape> = before.iter().flatten().map(|(shape, _)| shape.clone()).collect();
    let (pairs, _) = matched(&old, here);
    let mut found: Vec<Option<Followed>> = vec![None; before.len()];
    for ((at, old), new) in known.into_iter().zip(&old).zip(pairs) {
        let Some(new) = new else { continue };
        let mut mode = modes.modes[new].clone();
        // Among equal exponents any basis is as good: the one before is kept.
        if let (true, Some((_, last))) = (is_one_of_several(here, new), &before[at]) {
            mode.vector.clone_from(&last.vector);
            mode.imaginary.clone_from(&last.imaginary);
            found[at] = Some((old.clone().of_mode(&here[new]), mode));
            continue;
        }
        let [re, im] = old.product(&here[new], 1.0);
        let size = re.hypot(im);
        if size > 0.0 {
            let [c, s] = [re / size, -im / size];
            let turned = |(x, y): (f64, f64)| (c * x - s * y, s * x + c * y);
            if mode.imaginary.is_empty() {
                mode.vector.iter_mut().for_each(|part| *part *= c.signum());
            } else {
                let parts = mode.vector.iter().copied().zip(mode.imaginary.iter().copied()).map(turned);
                (mode.vector, mode.imaginary) = parts.unzip();
            }
        }
        found[at] = Some((here[new].clone(), mode));
    }
    found
}
