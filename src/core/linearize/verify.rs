//! What was read off modulo one prime, tried in true numbers.

use super::assemble::{Assembly, Part, Values, head};
use super::symmetry::Symmetry;
use crate::expr::mix;
use crate::model::Model;
use crate::number::Number;
use crate::precision::{Ball, Big, Enclosure, Magnitude};

/// Generators read off modulo the prime are tried in true numbers of so many bits ...
const BITS_TO_CHECK: usize = 256;

/// ... in which what vanishes leaves less than this power of 1/2 of its parts.
const LEFT_OVER: i64 = 160;

/// The same of balls, which is enough for whole numbers up to [`SMALL`]: by chance a residue is one of these once in 1e17.
const LEFT_OVER_OF_BALLS: i64 = 60;

/// 0, 1 and -1 are those of translations.
const SMALL: i64 = 8;

/// Those of the constant generators along which no term (`together`: not the sum of all) changes in true numbers
/// either, near `at`.
///
/// Most residues are those of some fraction with numerator and denominator below 1e9. Where the
/// generator is irrational, the residue stands for an algebraic number, and the fraction has nothing
/// to do with it: it misses xi·∇U = 0 by some 1e-19 of the terms, while numbers of [`BITS_TO_CHECK`]
/// bits tell 1e-48. So what vanishes both modulo the prime, at random points, and here is a
/// symmetry.
pub(crate) fn hold_in_true_numbers(
    model: &Model,
    assembly: &Assembly,
    at: &[Ball],
    found: Vec<Symmetry>,
    together: bool,
) -> Vec<Symmetry> {
    let is_small = |x: &Number| x.to_i64().is_some_and(|x| x.abs() <= SMALL);
    let is_plain = |symmetry: &Symmetry| symmetry.constant().is_some_and(|vector| vector.iter().all(is_small));
    let plain: Vec<bool> = found.iter().map(is_plain).collect();
    let quick = Check { assembly, at, together, left_over: LEFT_OVER_OF_BALLS };
    let held = if plain.contains(&true) { quick.holds::<Ball>(model, &found, ()) } else { vec![false; found.len()] };
    let sure: Vec<bool> = plain.iter().zip(&held).map(|(plain, held)| *plain && *held).collect();
    if sure.iter().all(|sure| *sure) {
        return found;
    }
    let slow = Check { left_over: LEFT_OVER, ..quick };
    let held = slow.holds::<Big>(model, &found, BITS_TO_CHECK);
    let kept = sure.iter().zip(&held).map(|(sure, held)| *sure || *held);
    found.into_iter().zip(kept).filter_map(|(symmetry, kept)| kept.then_some(symmetry)).collect()
}

/// What generators are tried on.
struct Check<'a> {
    assembly: &'a Assembly,
    at: &'a [Ball],
    /// Whether the sum of all terms is meant.
    together: bool,
    /// What vanishes leaves less than this power of 1/2 of its parts.
    left_over: i64,
}

impl Check<'_> {
    /// Whether nothing changes along each of the generators.
    fn holds<E: Enclosure>(&self, model: &Model, found: &[Symmetry], precision: E::Precision) -> Vec<bool> {
        let mut held = vec![false; found.len()];
        let Ok(values) = self.assembly.values::<E>(model, precision) else { return held };
        // Nearer where a term is not defined further off.
        let tried = [10, 30, 60].into_iter().find_map(|halvings| {
            let near = beside::<E>(self.at, halvings, precision);
            self.changes(&near, &values, found)
        });
        if let Some(changes) = tried {
            held.iter_mut().zip(changes).for_each(|(held, changes)| *held = !changes);
        }
        held
    }

    /// For each constant generator whether some term (`together`: the sum of all) changes along it or may do so by
    /// more than what may be left over; `None` where a term is not defined.
    fn changes<E: Enclosure>(&self, at: &[E], values: &Values<E>, found: &[Symmetry]) -> Option<Vec<bool>> {
        // Whether it may be 0.
        let is_open = |x: &E| x.abs_lower_magnitude().is_zero();
        // What the parts come to, and how large they are.
        let nothing = (E::from_number(&Number::ZERO, values.precision()), Magnitude::ZERO);
        let mut sums = vec![nothing.clone(); found.len()];
        let mut changes = vec![false; found.len()];
        let mut compare = |sums: &mut Vec<(E, Magnitude)>| {
            for ((total, size), changes) in sums.iter().zip(&mut changes) {
                *changes |= !is_open(total) || total.abs_upper_magnitude() > size.scale(-self.left_over);
            }
            sums.fill(nothing.clone());
        };
        let mut defined = true;
        self.assembly.run(Part::Force, at, values, |family, instance, numbers, _| {
            let coordinates = family.terms.coordinates_of(instance);
            let mut gradient = vec![nothing.clone(); coordinates.len()];
            let mut rest = numbers;
            for element in &family.potential {
                let (first, slopes) = head(&mut rest, 1, element.slope.len());
                let parts: Vec<E> = slopes.iter().map(|slope| first[0].mul(slope)).collect();
                defined &= parts.iter().all(E::is_finite);
                // A slope that is what is left of terms that cancel says nothing of how large these are; those in
                // other directions do.
                let own = parts.iter().filter(|part| !is_open(part));
                let Some(own) = own.map(E::abs_upper_magnitude).reduce(Magnitude::max) else { continue };
                for ((place, _), part) in element.slope.iter().zip(parts) {
                    let (total, size) = &mut gradient[*place];
                    *size = *size + own;
                    *total = total.add(&part);
                }
            }
            for (symmetry, (total, size)) in found.iter().zip(&mut sums) {
                let Some(vector) = symmetry.constant() else { continue };
                for (i, (slope, own)) in coordinates.iter().zip(&gradient) {
                    let Some(factor) = vector.get(*i as usize).filter(|x| !x.is_zero()) else { continue };
                    let factor = E::from_number(factor, values.precision());
                    *size = *size + *own * factor.abs_upper_magnitude();
                    *total = total.add(&slope.mul(&factor));
                }
            }
            if !self.together {
                compare(&mut sums);
            }
        });
        compare(&mut sums);
        defined.then_some(changes)
    }
}

/// A point beside another: every coordinate moved by up to 2^-halvings of its size and 1.
fn beside<E: Enclosure>(at: &[Ball], halvings: i32, precision: E::Precision) -> Vec<E> {
    let mut state = 0_u64;
    let moved = |x: &Ball| {
        let unit = (mix(state) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let size = x.mid_f64().abs().max(1.0) * 2f64.powi(-halvings);
        E::from_ball(x, precision).center().add(&E::exact(unit * size, precision)).center()
    };
    at.iter().map(moved).collect()
}
