//! Constraints that depend on each other only where they all hold.
//!
//! A closed linkage with a bar too many, or a surface written twice in different ways: the gradients are independent at a
//! random point, and dependent all along the surface that the constraints leave. That can't be told from expressions, so
//! points of the surface near the start of the search are examined, in doubles, and what seems to follow there is
//! decided with many bits. It is asked only where the linearization
//! fails for dependent gradients.

use nalgebra::{DMatrix, DVector};

use super::constrained::independent;
use super::dependence::{self, Surface};
use super::units;
use crate::model::Model;
use crate::precision::Ball;

/// The rank must come out the same at so many points.
const POINTS: usize = 3;

/// Gauss-Newton steps onto the surface.
const MOST_STEPS: usize = 60;

/// Beside the largest, what is below counts as 0, and what is above this times a thousand does not.
const NOTHING: f64 = 1e-9;

/// Steps do without directions that are so little determined beside the others.
const NEARLY: f64 = 1e-3;

/// Beyond so many constraints decompositions take too long for what is a mistake mostly.
const MOST: usize = 200;

/// The numbers of constraints that follow from those before them all along the surface; `None` where that can't be told.
pub(super) fn dependent(model: &Model) -> Option<Vec<usize>> {
    let visible = model.coordinates.len();
    let (left, _) = independent(&mut model.clone());
    if left.len() > MOST {
        return None;
    }
    let surface = Surface::new(model, &left)?;
    // c and ∂c/∂q at a point.
    let look = |q: &DVector<f64>| {
        let (gap, rows) = surface.at(model, q.as_slice(), ())?;
        Some((DVector::from_vec(gap), DMatrix::from_fn(rows.len(), visible, |a, i| rows[a][i])))
    };
    let start = DVector::from_vec(units::start::<f64>(model, ())?);
    let size = start.amax().max(1e-3);
    let mut found: Option<Vec<usize>> = None;
    for point in 0..POINTS {
        // Beside the start, a different way each time and the same on every machine.
        let mut q = start.clone();
        for (i, x) in q.iter_mut().enumerate() {
            let angle = 1.0 + (point * visible + i) as f64 * 2.399_963;
            *x += 0.05 * size * angle.sin();
        }
        for _ in 0..MOST_STEPS {
            let (gap, rows) = look(&q)?;
            // c = A (q - q'); what is nearly dependent is left to the others.
            let small = NEARLY * rows.amax();
            let step = rows.svd(true, true).solve(&gap, small).ok()?;
            q -= &step;
            if step.amax() <= 1e-15 * q.amax().max(size) {
                break;
            }
        }
        let (gap, rows) = look(&q)?;
        let scale = rows.amax() * q.amax().max(size);
        if gap.amax().is_nan() || gap.amax() > 1e-11 * scale {
            return None;
        }
        let here = follow(&rows)?;
        // What doubles can't tell from a combination of the others may be none.
        let numbers = |places: &[usize]| -> Vec<usize> { places.iter().map(|place| left[*place]).collect() };
        let kept: Vec<usize> = (0..left.len()).filter(|at| !here.contains(at)).collect();
        let point: Vec<Ball> = q.iter().map(|x| Ball::exact(*x)).collect();
        let point = dependence::exactly(model, &point)?;
        if dependence::follow(model, &numbers(&kept), &numbers(&here), &point)?.is_some() {
            return None;
        }
        if *found.get_or_insert_with(|| here.clone()) != here {
            return None;
        }
    }
    found.map(|places| places.into_iter().map(|place| left[place]).collect())
}

/// The rows that are combinations of those before them, by Gram-Schmidt; `None` where one is neither nor.
fn follow(rows: &DMatrix<f64>) -> Option<Vec<usize>> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut dependent = Vec::new();
    for (number, row) in rows.row_iter().enumerate() {
        let mut rest: DVector<f64> = row.transpose();
        let length = rest.norm();
        if length == 0.0 {
            return None;
        }
        rest /= length;
        for _ in 0..2 {
            for other in &basis {
                let overlap = other.dot(&rest);
                rest.axpy(-overlap, other, 1.0);
            }
        }
        let left = rest.norm();
        if left <= NOTHING {
            dependent.push(number);
        } else if left >= 1e3 * NOTHING {
            basis.push(rest / left);
        } else {
            return None;
        }
    }
    Some(dependent)
}
