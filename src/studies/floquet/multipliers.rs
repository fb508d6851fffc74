//! Certified eigenvalues of a monodromy matrix, and on which side of the unit circle they lie.
//!
//! Two by two they come from trace and determinant, larger ones from discs ([`super::discs`]).
//!
//! Without friction the monodromy is similar to a symplectic matrix: with z, 1/z̄ is an eigenvalue (V. I. Arnold, Mathematical
//! Methods of Classical Mechanics, §42). An eigenvalue in a disc of its own whose mirror image by the circle meets no
//! other disc is therefore its own image and lies on the circle; and one far inside is known from its partner outside,
//! beside which it would be lost. Several that are not told apart lie on it where their form is definite ([`super::signature`]).

use super::basis::Basis;
use super::discs::{Cover, Covers, Disc};
use super::signature::is_definite;
use librate_core::precision::{Ball, Big, Enclosure, Function, Magnitude, Scalar, up};
use librate_core::worded;

/// Bits for logarithms and hulls of what leaves the range of balls.
const BITS: usize = 160;

worded! {
/// Where a multiplier lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
Place {
    /// Inside the unit circle: what it multiplies decays.
    Inside "inside",
    /// On it, exactly.
    On "on",
    /// Outside: what it multiplies grows.
    Outside "outside",
    /// The bounds do not tell.
    Undecided "undecided",
}
/// In words.
as_str
}

/// A Floquet multiplier.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Multiplier {
    /// The real part.
    pub re: Ball,
    /// The imaginary part.
    pub im: Ball,
    /// The modulus.
    pub modulus: Ball,
    /// Where it lies.
    pub place: Place,
    /// Whether no other multiplier is within its bounds.
    pub single: bool,
    /// Whether it is known to have as many eigenvectors as it repeats, so that on the circle nothing grows.
    pub semisimple: bool,
    /// Real part, imaginary part and modulus with more bits or beyond the range of doubles, where they were needed.
    pub precise: Option<Box<[Big; 3]>>,
}

impl Multiplier {
    fn new<S: Enclosure>(re: S, im: S, place: Place, single: bool) -> Self {
        let modulus = match place {
            Place::On => None,
            _ if im.is_zero() => Some(re.apply(Function::Abs)),
            _ => Some(re.mul(&re).add(&im.mul(&im)).sqrt()),
        };
        Self {
            re: re.to_ball(),
            im: im.to_ball(),
            modulus: modulus.as_ref().map_or(Ball::ONE, Enclosure::to_ball),
            place,
            single,
            semisimple: single,
            precise: re.precise().zip(im.precise()).map(|(re, im)| {
                let modulus = modulus.and_then(Enclosure::precise).unwrap_or_else(|| Big::one(re.bits()));
                Box::new([re, im, modulus])
            }),
        }
    }

    /// The natural logarithm of the modulus, also where that leaves the range of doubles.
    #[must_use]
    pub fn log_modulus(&self) -> Ball {
        match &self.precise {
            _ if self.place == Place::On => Ball::ZERO,
            Some(precise) if !self.modulus.is_positive() => precise[2].apply(Function::Ln).to_ball(),
            _ => self.modulus.ln(),
        }
    }

    /// About log2 of the modulus; no bound.
    pub(super) fn log_size(&self) -> f64 {
        match &self.precise {
            Some(precise) => precise[2].abs_upper_magnitude().log2(),
            None => self.modulus.mid_f64().log2(),
        }
    }

    /// The modulus with enough range.
    pub(super) fn wide_modulus(&self) -> Big {
        self.precise.as_ref().map_or_else(|| Big::from_ball(&self.modulus, BITS), |precise| precise[2].clone())
    }

    /// An upper bound of the distance of the multiplier from the midpoints of its parts in doubles.
    #[must_use]
    pub fn error(&self) -> f64 {
        up(self.re.mid_f64_error() + self.im.mid_f64_error())
    }
}

/// Which side of 1 a positive number lies on; its square, alike.
fn side<S: Enclosure>(modulus: &S, precision: S::Precision) -> Place {
    let above = modulus.sub(&S::exact(1.0, precision));
    if above.neg().is_positive() {
        Place::Inside
    } else if above.is_positive() {
        Place::Outside
    } else {
        Place::Undecided
    }
}

/// Whether bounds decide less of these multipliers than is asked for: on which side of the circle each lies, whether those
/// on it coincide, and so many digits of each part (fewer of one that is small beside the other).
pub(super) fn is_lacking(multipliers: &[Multiplier], digits: usize) -> bool {
    let lacks = |own: &Multiplier| {
        own.place == Place::Undecided
            || own.place == Place::On && !own.semisimple
            || own.parts(digits).iter().any(|(spread, allowed)| spread > allowed)
    };
    multipliers.is_empty() || multipliers.iter().any(lacks)
}

/// About how many bits more it takes for these digits.
pub(super) fn missing_bits(multipliers: &[Multiplier], digits: usize) -> usize {
    let missing = multipliers.iter().flat_map(|own| own.parts(digits));
    missing.map(|(spread, allowed)| (spread / allowed).log2()).fold(0.0_f64, f64::max).min(1e6) as usize
}

impl Multiplier {
    /// Of both parts, the bound of the error and what it may be: a tenth of a unit of the last place, of a part that is as
    /// much smaller than the other as there are digits a tenth of such a unit of it. What may lie on the circle has about the
    /// size 1.
    fn parts(&self, digits: usize) -> [(Magnitude, Magnitude); 2] {
        let digits = i32::try_from(digits).unwrap_or(i32::MAX).saturating_add(1);
        let share = Magnitude::from_f64(0.1).powi(digits.unsigned_abs());
        let parts = match &self.precise {
            Some(precise) => [&precise[0], &precise[1]].map(|x| (x.abs_upper_magnitude(), x.radius_magnitude())),
            None => [&self.re, &self.im].map(|x| (x.abs_upper_magnitude(), x.radius_magnitude())),
        };
        if self.place == Place::Undecided {
            return parts.map(|(_, spread)| (spread, share));
        }
        let size = parts[0].0.max(parts[1].0);
        parts.map(|(own, spread)| (spread, own.max(size * share) * share))
    }
}

/// Discs for multipliers of which nothing is known: all lie within the largest row sum of the matrix.
pub(super) fn unknown<S: Enclosure>(monodromy: &[S], n: usize, precision: S::Precision) -> Vec<Multiplier> {
    let row = |row: &[S]| row.iter().fold(Magnitude::ZERO, |sum, x| sum + x.abs_upper_magnitude());
    let reach = monodromy.chunks_exact(n).map(row).fold(Magnitude::ZERO, Magnitude::max);
    let part = S::exact(0.0, precision).with_added_magnitude(reach);
    vec![Multiplier::new(part.clone(), part, Place::Undecided, false); n]
}

/// The eigenvalues of a matrix of two rows; `symplectic` says that its determinant is 1.
///
/// With half the trace h and the determinant d they are h ± sqrt(h² - d). For d = 1 both lie on the circle where |h| < 1, and
/// one is outside where |h| > 1.
pub(super) fn of_two<S: Enclosure>(matrix: &[S], symplectic: bool, precision: S::Precision) -> Vec<Multiplier> {
    let [a, b, c, d] = matrix else { return Vec::new() };
    let (one, half) = (S::exact(1.0, precision), S::exact(0.5, precision));
    let trace = a.add(d).mul(&half);
    let determinant = if symplectic { one.clone() } else { a.mul(d).sub(&b.mul(c)) };
    // (h - 1)(h + 1) loses nothing beside the border.
    let below = if symplectic { one.sub(&trace).mul(&one.add(&trace)) } else { determinant.sub(&trace.mul(&trace)) };
    if below.is_positive() {
        let (re, im) = (trace, below.sqrt());
        let place = if symplectic { Place::On } else { side(&determinant, precision) };
        return vec![Multiplier::new(re.clone(), im.clone(), place, true), Multiplier::new(re, im.neg(), place, true)];
    }
    let real = |value: S, place: Option<Place>| {
        let place = place.unwrap_or_else(|| side(&value.apply(Function::Abs), precision));
        Multiplier::new(value, S::exact(0.0, precision), place, true)
    };
    let above = below.neg();
    if above.is_positive() {
        let root = above.sqrt();
        let larger = if trace.is_positive() {
            trace.add(&root)
        } else if trace.neg().is_positive() {
            trace.sub(&root)
        } else {
            // h may be 0: both roots as they are.
            return [trace.add(&root), trace.sub(&root)].map(|x| real(x, None)).to_vec();
        };
        let smaller = determinant.div(&larger);
        let places = [Place::Outside, Place::Inside].map(|own| symplectic.then_some(own));
        return vec![real(larger, places[0]), real(smaller, places[1])];
    }
    // A double one, or two beside each other: |z - h| = sqrt |h² - d|.
    let reach = above.abs_upper_magnitude().sqrt();
    let im = S::exact(0.0, precision).with_added_magnitude(reach);
    let own = Multiplier::new(trace.with_added_magnitude(reach), im, Place::Undecided, false);
    let place =
        if symplectic && own.re.abs() == Ball::ONE && own.im.is_zero() { Place::On } else { side(&own.modulus, ()) };
    let own = Multiplier { place, ..own };
    vec![own.clone(), own]
}

/// The eigenvalues of a matrix given row by row, each as often as it has discs; `symplectic` as above, and gives the form that the
/// matrix leaves unchanged, where that is needed; `careful` says to take eigenvectors at the precision of the entries. Empty where
/// eigenvectors could not be told apart.
pub(super) fn of_many<S: Enclosure>(
    matrix: &[S],
    n: usize,
    symplectic: Option<&dyn Fn() -> Option<Vec<S>>>,
    careful: bool,
    precision: S::Precision,
) -> Vec<Multiplier> {
    let basis = if careful { Basis::careful(matrix, n, precision) } else { Basis::quick(matrix, n, precision) };
    let Some(basis) = basis else { return Vec::new() };
    let Some(covers) = Covers::new(matrix, n, &basis, precision) else { return Vec::new() };
    let partners = if symplectic.is_some() { partners(&covers, precision) } else { vec![None; n] };
    let own = covers.of.iter().zip(partners).map(|(cover, partner)| {
        let disc = &cover.disc;
        // An eigenvalue that is in none of the others is in this one.
        let is_own = |image: &Disc<S>| cover.others.iter().all(|other| image.is_apart(other, precision));
        let real = disc.single && is_own(&disc.conjugate());
        let part = |disc: &Disc<S>, real: bool| {
            let re = disc.center.re.with_added_magnitude(disc.radius);
            let im = if real { S::exact(0.0, precision) } else { disc.center.im.with_added_magnitude(disc.radius) };
            (re, im)
        };
        if let Some((image, real)) = partner {
            let (re, im) = part(&image, real);
            return Multiplier::new(re, im, Place::Inside, image.single);
        }
        let (re, im) = part(disc, real);
        let mirrored = || disc.mirrored(precision).is_some_and(|mirror| is_own(&mirror));
        let place = if symplectic.is_some() && disc.single && mirrored() {
            Place::On
        } else {
            // By the disc, not by its square.
            let modulus = disc.center.square_of_modulus().sqrt();
            side(&modulus.with_added_magnitude(disc.radius), precision)
        };
        Multiplier::new(re, im, place, disc.single)
    });
    let mut multipliers: Vec<Multiplier> = own.collect();
    if let Some(form) = symplectic
        && multipliers.iter().any(|own| own.place == Place::Undecided)
        && let Some(form) = form()
    {
        together(&mut multipliers, &covers, &basis, &form, precision);
    }
    multipliers
}

/// Those that are not told apart, but stay on the circle together.
fn together<S: Enclosure>(
    multipliers: &mut [Multiplier],
    covers: &Covers<S>,
    basis: &Basis<S>,
    form: &[S],
    precision: S::Precision,
) {
    for members in &covers.sets {
        let mut open = members.iter().map(|at| multipliers[*at].place);
        if open.all(|place| place == Place::Undecided) && is_definite(members, covers, basis, form, precision) {
            for at in members {
                let own = &mut multipliers[*at];
                own.place = Place::On;
                own.semisimple = true;
                own.modulus = Ball::ONE;
                if let Some(precise) = &mut own.precise {
                    precise[2] = Big::one(precise[2].bits());
                }
            }
        }
    }
}

/// Discs far inside that are known from their partners outside: for each, that of its own multiplier, and whether that is
/// real.
///
/// A single disc outside the circle holds an eigenvalue z, and its mirror image another one, 1/z̄. Discs that are connected hold as
/// many eigenvalues as there are discs. If just as many images meet none of the other discs, they hold the same eigenvalues,
/// since those of different z are different.
fn partners<S: Enclosure>(covers: &Covers<S>, precision: S::Precision) -> Vec<Option<(Disc<S>, bool)>> {
    let n = covers.plain.len();
    let image = |cover: &Cover<S>| {
        let disc = &cover.disc;
        let modulus = disc.center.square_of_modulus().sqrt();
        let modulus = modulus.sub(&S::from_magnitude(disc.radius, precision));
        if side(&modulus, precision) != Place::Outside {
            return None;
        }
        let conjugate = disc.conjugate();
        let real = cover.others.iter().all(|other| conjugate.is_apart(other, precision));
        Some((disc.mirrored(precision)?, real))
    };
    let images: Vec<(Disc<S>, bool)> = covers.of.iter().filter(|cover| cover.disc.single).filter_map(image).collect();
    let mut partners = vec![None; n];
    for members in &covers.sets {
        let others = (0..n).filter(|at| !members.contains(at));
        let others: Vec<&Disc<S>> = others.map(|at| &covers.plain[at]).collect();
        let here = images.iter().filter(|(image, _)| others.iter().all(|other| image.is_apart(other, precision)));
        let here: Vec<&(Disc<S>, bool)> = here.collect();
        if here.len() != members.len() {
            continue;
        }
        for (place, (at, (image, real))) in members.iter().zip(&here).enumerate() {
            let mut rest = here.iter().enumerate().filter(|(k, _)| *k != place);
            let single = rest.all(|(_, (other, _))| image.is_apart(other, precision));
            partners[*at] = Some((Disc { single, ..image.clone() }, *real));
        }
    }
    partners
}
