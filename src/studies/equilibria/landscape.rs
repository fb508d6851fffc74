//! The potential over a box, for pictures.

use librate_core::expr::Tape;
use librate_core::linearize;
use librate_core::model::Model;
use librate_core::precision::Ball;

use super::error::EquilibriaError;
use super::region::Region;

/// Places along a curve, and along each side of a plane.
const PLACES: [usize; 2] = [401, 48];

/// The potential V - T0 over the coordinates of a box, in doubles.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Landscape {
    potential: Tape,
    /// The middles of the ranges; 0 for a coordinate without one.
    middle: Vec<f64>,
    /// The ends of the ranges of the coordinates that have one, by number.
    sides: Vec<(usize, [f64; 2])>,
}

/// The potential over a box.
///
/// # Errors
/// As [`super::find`].
pub fn landscape(model: &Model, region: &Region) -> Result<Landscape, EquilibriaError> {
    let rest = linearize::at_rest(model.clone(), &[])?;
    let potential =
        Tape::compile(&rest.pool, &[rest.potential], &rest.coordinates).map_err(|_| EquilibriaError::NoForces {})?;
    let ends = |(at, side): (usize, &Option<[Ball; 2]>)| Some((at, side.as_ref()?.each_ref().map(Ball::mid_f64)));
    let sides: Vec<(usize, [f64; 2])> = region.sides.iter().enumerate().filter_map(ends).collect();
    let mut middle = vec![0.0; region.sides.len()];
    for (at, [from, to]) in &sides {
        middle[*at] = 0.5 * (from + to);
    }
    Ok(Landscape { potential, middle, sides })
}

impl Landscape {
    /// The coordinates that have a range, by number.
    pub fn coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        self.sides.iter().map(|(at, _)| *at)
    }

    /// The potential at a point in J; no number where it has no value.
    #[must_use]
    pub fn height(&self, point: &[f64]) -> f64 {
        self.potential.evaluate::<f64>(point, &mut Vec::new()).first().copied().unwrap_or(f64::NAN)
    }

    /// Places along the range of a single coordinate, each with the potential there.
    #[must_use]
    pub fn curve(&self) -> Vec<[f64; 2]> {
        let [(at, ends)] = self.sides[..] else { return Vec::new() };
        let mut point = self.middle.clone();
        let height = |x: f64| {
            point[at] = x;
            [x, self.height(&point)]
        };
        places(ends, PLACES[0]).map(height).collect()
    }

    /// The middles of equal rectangles in the plane of two coordinates, each with the potential there, and half their sides.
    #[must_use]
    pub fn plane(&self) -> (Vec<([f64; 2], f64)>, [f64; 2]) {
        let [(first, across), (second, up)] = self.sides[..] else { return (Vec::new(), [0.0; 2]) };
        let half = [across, up].map(|[from, to]| 0.5 * (to - from) / PLACES[1] as f64);
        let inner = |[from, to]: [f64; 2], half: f64| [from + half, to - half];
        let mut point = self.middle.clone();
        let mut all = Vec::new();
        for y in places(inner(up, half[1]), PLACES[1]) {
            for x in places(inner(across, half[0]), PLACES[1]) {
                (point[first], point[second]) = (x, y);
                all.push(([x, y], self.height(&point)));
            }
        }
        (all, half)
    }
}

fn places([from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |at| from + (to - from) * at as f64 / (count - 1) as f64)
}
