//! What was read off modulo one prime, tried in true numbers.

use super::assemble::{Assembly, Part, Values, head};
use super::symmetry::Symmetry;
use crate::expr::mix;
use crate::model::Model;
use crate::precision::{Ball, Big, Magnitude, Scalar};

/// Generators read off modulo the prime are tried at so many points in true numbers ...
const POINTS_TO_CHECK: u64 = 2;

/// ... of so many bits ...
const BITS_TO_CHECK: usize = 256;

/// ... in which what vanishes leaves less than this power of 1/2 of its parts.
const LEFT_OVER: i64 = 160;

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
    mut found: Vec<Symmetry>,
    together: bool,
) -> Vec<Symmetry> {
    if found.is_empty() {
        return found;
    }
    let Ok(values) = assembly.values::<Big>(model, BITS_TO_CHECK) else {
        return Vec::new();
    };
    for point in 0..POINTS_TO_CHECK {
        // Nearer where a term is not defined further off.
        let tried = [10, 30, 60].into_iter().find_map(|halvings| {
            let near = beside(at, point, halvings);
            changes(assembly, &near, &values, &found, together)
        });
        let Some(changes) = tried else {
            return Vec::new();
        };
        let mut changes = changes.into_iter();
        found.retain(|_| changes.next() == Some(false));
    }
    found
}

/// A point beside another: every coordinate moved by up to 2^-halvings of its size and 1.
fn beside(at: &[Ball], point: u64, halvings: i32) -> Vec<Big> {
    let mut state = point;
    let moved = |x: &Ball| {
        let unit = (mix(state) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let size = x.mid_f64().abs().max(1.0) * 2f64.powi(-halvings);
        &Big::from_ball(x, BITS_TO_CHECK).center() + &Big::from_f64(unit * size, BITS_TO_CHECK)
    };
    at.iter().map(moved).map(|x| x.center()).collect()
}

/// For each constant generator whether some term (`together`: the sum of all) changes along it or may do so by
/// more than 2^-[`LEFT_OVER`] of its parts; `None` where a term is not defined.
fn changes(
    assembly: &Assembly,
    at: &[Big],
    values: &Values<Big>,
    found: &[Symmetry],
    together: bool,
) -> Option<Vec<bool>> {
    // What the parts come to, and how large they are.
    let nothing = (Big::zero(BITS_TO_CHECK), Magnitude::ZERO);
    let mut sums = vec![nothing.clone(); found.len()];
    let mut changes = vec![false; found.len()];
    let mut compare = |sums: &mut Vec<(Big, Magnitude)>| {
        for ((total, size), changes) in sums.iter().zip(&mut changes) {
            *changes |= !total.contains_zero() || total.abs_upper() > size.scale(-LEFT_OVER);
        }
        sums.fill(nothing.clone());
    };
    let mut defined = true;
    assembly.run(Part::Force, at, values, |family, instance, numbers| {
        let coordinates = family.terms.coordinates_of(instance);
        let mut gradient = vec![nothing.clone(); coordinates.len()];
        let mut rest = numbers;
        for element in &family.potential {
            let (first, slopes) = head(&mut rest, 1, element.slope.len());
            let parts: Vec<Big> = slopes.iter().map(|slope| first[0].mul(slope)).collect();
            defined &= parts.iter().all(Big::is_finite);
            // A slope that is what is left of terms that cancel says nothing of how large these are; those in
            // other directions do.
            let own = parts.iter().filter(|part| !part.contains_zero());
            let Some(own) = own.map(Big::abs_upper).reduce(Magnitude::max) else {
                continue;
            };
            for ((place, _), part) in element.slope.iter().zip(parts) {
                let (total, size) = &mut gradient[*place];
                *size = *size + own;
                *total = total.add(&part);
            }
        }
        for (symmetry, (total, size)) in found.iter().zip(&mut sums) {
            let Some(vector) = symmetry.constant() else {
                continue;
            };
            for (i, (slope, own)) in coordinates.iter().zip(&gradient) {
                let Some(factor) = vector.get(*i as usize).filter(|x| !x.is_zero()) else {
                    continue;
                };
                let factor = Big::from_number(factor, BITS_TO_CHECK);
                *size = *size + *own * factor.abs_upper();
                *total = total.add(&slope.mul(&factor));
            }
        }
        if !together {
            compare(&mut sums);
        }
    });
    compare(&mut sums);
    defined.then_some(changes)
}
