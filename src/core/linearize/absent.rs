//! Why no equilibrium was found: a force that is proved to be the same everywhere, or simply no way on.

use nalgebra::DMatrix;

use super::equilibrium::{Search, short};
use super::error::{LinearizeError, combination_words};
use super::exact::simplest;
use super::newton::Spectrum;
use super::symbolic::{constant_along, constant_force};
use super::undefined::point_text;
use crate::number::Number;
use crate::precision::{Ball, Scalar, reduce};

/// Combinations with larger denominators are not tried.
const LARGEST_DENOMINATOR: u64 = 10_000;

/// The fraction that a double seems to stand for.
fn fraction(x: f64) -> Option<Number> {
    let near = simplest(&Number::from_f64_exact(x)?, &Number::from_f64_exact(1e-9)?)?;
    near.small_parts().filter(|(_, denominator)| *denominator <= LARGEST_DENOMINATOR).map(|_| near)
}

/// The columns in reduced echelon form, by the largest pivots.
fn reduced(columns: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = columns.column_iter().map(|column| column.iter().copied().collect()).collect();
    reduce(&mut rows, columns.nrows(), |x| x.abs(), ());
    rows
}

impl Search<'_> {
    /// The error that there is none, if a force along a coordinate or a combination of them is proved to be
    /// the same everywhere.
    pub(super) fn nowhere(
        &self,
        at: &[Ball],
        metric: &DMatrix<f64>,
        spectrum: Option<&Spectrum>,
    ) -> Option<LinearizeError> {
        let gradient = self.gradient(at);
        let mut forces = Vec::new();
        let mut span = None;
        for i in &self.free {
            if let Some(text) = constant_force(self.model, *i, -gradient[*i].mid_f64()) {
                span = span.or(Some(self.model.coordinates.at(*i).span));
                forces.push((format!("`{}`", self.model.coordinates.at(*i).name()), text));
            }
        }
        if forces.is_empty() {
            for motion in self.unheld(metric, spectrum?) {
                let factors = motion.iter().map(|(i, factor)| (*i, Ball::from_number(factor, ())));
                let total = factors.clone().fold(Ball::ZERO, |sum, (i, factor)| sum.sub(&gradient[i].mul(&factor)));
                let acts = total.is_finite() && !total.contains_zero();
                let is_constant = || constant_along(self.model, &motion) == Some(true);
                let Some((first, _)) = motion.first().filter(|_| acts && is_constant()) else { continue };
                let words = factors.map(|(i, factor)| (self.model.coordinates.at(i).name(), factor.mid_f64()));
                let words: Vec<(String, f64)> = words.collect();
                span = span.or(Some(self.model.coordinates.at(*first).span));
                forces.push((combination_words(&words), short(total.mid_f64())));
            }
        }
        span.map(|span| LinearizeError::NoEquilibrium { forces, span })
    }

    /// Motions against which there seems to be no stiffness, as the fractions they seem to be.
    fn unheld(&self, metric: &DMatrix<f64>, spectrum: &Spectrum) -> Vec<Vec<(usize, Number)>> {
        let values = &spectrum.eigen.eigenvalues;
        let floor = 1e-12 * values.amax();
        let soft: Vec<usize> = (0..values.len()).filter(|mode| values[*mode].abs() <= floor).collect();
        let axes = spectrum.eigen.eigenvectors.select_columns(&soft);
        let Some(motions) = metric.transpose().solve_upper_triangular(&axes) else { return Vec::new() };
        let rational = |motion: &Vec<f64>| {
            let entries = self.free.iter().zip(motion);
            entries.filter(|(_, x)| x.abs() > 1e-9).map(|(i, x)| Some((*i, fraction(*x)?))).collect::<Option<Vec<_>>>()
        };
        reduced(&motions).iter().filter_map(rational).collect()
    }

    /// The first constraint whose gradient vanishes where the search ended, or where it began: there it says nothing of
    /// where to go.
    pub(super) fn flat_constraint(&self, end: &[Ball], start: &[Ball]) -> Option<LinearizeError> {
        let order = end.len();
        let flat = |at: &[Ball]| {
            let stiffness = self.assembly.stiffness(at, self.values);
            (self.visible..order).find(|multiplier| {
                let gradient = &stiffness[order * multiplier..][..self.visible];
                gradient.iter().all(Ball::contains_zero)
            })
        };
        let (number, ended) = [(end, true), (start, false)]
            .into_iter()
            .take(if self.visible < order { 2 } else { 0 })
            .find_map(|(at, ended)| Some((flat(at)?, ended)))?;
        let at = if ended { end } else { start };
        Some(LinearizeError::ConstraintFlat {
            point: point_text(self.model, &at[..self.visible]),
            ended,
            // The potential has the term -lambda c.
            holds: self.gradient(at)[number].contains_zero(),
            span: self.model.coordinates.at(number).span,
        })
    }

    /// The error that the search ended here.
    pub(super) fn not_found(&self, at: &[Ball]) -> LinearizeError {
        let gradient = self.gradient(at);
        let size = |i: &usize| gradient[*i].mid_f64().abs();
        let worst = self.free.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let own = self.model.coordinates.at(worst);
        if worst >= self.visible {
            return LinearizeError::ConstraintsContradict { difference: None, span: own.span };
        }
        LinearizeError::EquilibriumNotFound {
            coordinate: own.name(),
            force: short(-gradient[worst].mid_f64()),
            point: point_text(self.model, &at[..self.visible]),
            span: own.span,
        }
    }
}
