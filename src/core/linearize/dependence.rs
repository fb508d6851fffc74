//! Whether constraints follow from others, decided with so many bits that numbers as exact as those of the file differ.
//!
//! In doubles x = y and x (1 + 1e-32) = y are one constraint. Two numbers made of numbers of b bits that differ at all
//! differ, but for high powers and deep formulas, by more than 2^-(4b): so many bits and more are taken.

use super::constrained::{choose_bound, solve};
use super::parameters::{Formulas, known_values};
use crate::expr::ExprId;
use crate::model::Model;
use crate::precision::{Ball, Big, Magnitude, Scalar};

/// Beside twice the bits that numbers of the file leave to a difference.
const LEAST_BITS: usize = 640;

/// Numbers of the file of more bits than that are not told apart.
const MOST_BITS: usize = 40_000;

/// Newton steps onto the surface: each doubles the digits.
const MOST_STEPS: usize = 40;

/// Constraints and their gradients, with the values of parameters put in.
struct Surface {
    formulas: Formulas,
    count: usize,
    /// Constraint and coordinate of each slope, which stand behind the constraints.
    slopes: Vec<(usize, usize)>,
    coordinates: usize,
}

/// So many bits tell numbers of a model's constraints apart; `None` where that would be too many.
pub(super) fn bits(model: &Model) -> Option<usize> {
    let known = known_values(model);
    let mut roots: Vec<ExprId> = model.constraints.iter().map(|own| own.expression).collect();
    let used = model.pool.symbols_of(&roots);
    roots.extend(used.iter().filter_map(|symbol| known.get(symbol).copied()));
    let given = model.equilibria.given().chain(model.guesses.given());
    roots.extend(given.filter_map(|given| given.value));
    let mut largest = 0;
    for id in model.pool.reachable(&roots) {
        let node = model.pool.node(id);
        node.for_each_number(|number| largest = largest.max(number.bits()));
    }
    (largest <= MOST_BITS).then_some(LEAST_BITS + 8 * largest)
}

impl Surface {
    /// Some constraints, by number.
    fn new(model: &Model, numbers: &[usize]) -> Option<Self> {
        let mut pool = model.pool.clone();
        let expressions: Vec<ExprId> =
            numbers.iter().map(|number| Some(model.constraints.get(*number)?.expression)).collect::<Option<_>>()?;
        let mut roots = expressions.clone();
        let mut slopes = Vec::new();
        for (number, expression) in expressions.iter().enumerate() {
            for (place, slope) in model.symbols.slopes(&mut pool, *expression) {
                slopes.push((number, place));
                roots.push(slope);
            }
        }
        Some(Self {
            formulas: Formulas::new(model, &pool, &roots)?,
            count: expressions.len(),
            slopes,
            coordinates: model.coordinates.len(),
        })
    }

    /// The constraints and their gradients at a point.
    fn at(&self, model: &Model, point: &[Big], bits: usize) -> Option<(Vec<Big>, Vec<Vec<Big>>)> {
        let mut numbers = self.formulas.at(model, point, bits)?;
        if !numbers.iter().all(Big::is_finite) {
            return None;
        }
        let slopes = numbers.split_off(self.count);
        let mut rows = vec![vec![Big::zero(bits); self.coordinates]; self.count];
        for ((number, place), slope) in self.slopes.iter().zip(slopes) {
            *rows.get_mut(*number)?.get_mut(*place)? = slope;
        }
        Some((numbers, rows))
    }

    /// A point of the surface beside one, by Newton's method for as many coordinates as there are constraints.
    fn near(&self, model: &Model, start: &[Big], bits: usize) -> Option<Vec<Big>> {
        let mut point: Vec<Big> = start.iter().map(Big::center).collect();
        let mut last: Option<Magnitude> = None;
        for _ in 0..MOST_STEPS {
            let (gaps, rows) = self.at(model, &point, bits)?;
            let rows: Vec<Vec<Big>> = rows.iter().map(|row| row.iter().map(Big::center).collect()).collect();
            let bound = choose_bound(&rows, None, bits)?;
            let equations = rows.iter().zip(&gaps).map(|(row, gap)| {
                let own = bound.iter().map(|place| row[*place].clone());
                own.chain(std::iter::once(gap.center().neg())).collect::<Vec<Big>>()
            });
            let step = solve(equations.collect(), bits)?;
            let length = step.iter().map(Big::abs_upper).fold(Magnitude::ZERO, Magnitude::max);
            for (place, step) in bound.iter().zip(&step) {
                point[*place] = point[*place].add(step).center();
            }
            // At the rounding of these numbers steps get no shorter.
            let done = length.is_zero() || last.is_some_and(|last| last <= length);
            if done && length <= size(&point).scale(-(bits as i64 * 3 / 4)) {
                return Some(point);
            }
            if done && last.is_some_and(|last| last.scale(4) <= length) {
                return None;
            }
            last = Some(length);
        }
        None
    }
}

/// How large the coordinates of a point are.
fn size(point: &[Big]) -> Magnitude {
    let sizes = point.iter().map(Big::abs_upper);
    sizes.fold(Magnitude::from_f64(1e-3), Magnitude::max)
}

/// The first of some constraints that does not hold where those `kept`, by number, hold beside a point, and what its sides differ by
/// there, if all don't follow; `None` where that can't be told.
pub(super) fn follow(model: &Model, kept: &[usize], others: &[usize], start: &[Ball]) -> Option<Option<(usize, f64)>> {
    let bits = bits(model)?;
    let start: Vec<Big> = start.iter().map(|x| Big::from_ball(x, bits)).collect();
    let point = Surface::new(model, kept)?.near(model, &start, bits)?;
    let (gaps, rows) = Surface::new(model, others)?.at(model, &point, bits)?;
    let size = size(&point);
    Some(others.iter().zip(&gaps).zip(&rows).find_map(|((number, gap), row)| {
        let slope = row.iter().map(Big::abs_upper).fold(Magnitude::ZERO, Magnitude::max);
        (gap.abs_upper() > (slope * size).scale(-(bits as i64 / 2))).then(|| (*number, gap.mid_f64()))
    }))
}
