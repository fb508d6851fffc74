//! The periodic motion that a mode becomes, to the third order of its amplitude.
//!
//! For L = T2 - U and a mode of shape s (sᵀMs = 1) and frequency w, put q = q0 + a s cos u + a² (C0 + C2 cos 2u) + … with
//! u = w (1 + β a² + …) t (A. Lindstedt; A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations (1979), §2.3.1, for one coordinate).
//! The remainder ∂L/∂q - d/dt ∂L/∂q' of each order of a has to vanish in each harmonic. Let F be the coefficients of ∂L/∂q and P
//! those of ∂T2/∂q' along the path, in the order of the amplitude:
//!
//! - order 2: F = F0 + F2 cos 2u and P = P2 sin 2u along q0 + a s cos u, so that K C0 = F0 and (K - 4w²M) C2 = F2 - 2w P2.
//!   With A = ∂_s²∇U/2, D = ∇(sᵀMs)/2 and B = (∂_s M)s these are F0 = (-A + w²D)/2 and F2 - 2w P2 = (-A - w²D)/2 + w²B.
//! - order 3: F = F1 cos u + F3 cos 3u, P = P1 sin u + P3 sin 3u along the path with C0 and C2. The forces at w and 3w are
//!   G1 = F1 - w P1 and G3 = F3 - 3w P3; the change of the frequency leaves 2 β w² M s, so that β = -sᵀG1/(2w²). What G1 and G3
//!   displace of other modes is c/(ω_k² - w²) and c/(ω_k² - 9w²).
//!
//! All coefficients are Taylor coefficients of compiled gradients along straight and curved paths ([`Series`]), two phases for two
//! harmonics: no tensor of third or fourth derivatives is ever built.

use super::basis::Basis;
use super::energies::Energies;
use super::{ModeAmplitude, Obstacle};
use librate_core::expr::Series;
use librate_core::modes::Kind;
use librate_core::oscillation::NormalMode;
use librate_core::precision::Ball;

/// A part of the motion beside the mode itself may be so large, of the mode's size, where the range ends.
const SHARE: f64 = 0.1;

/// What all modes share.
pub(super) struct Expansion<'a> {
    basis: &'a Basis,
    equilibrium: &'a [Ball],
    potential: Series<Ball>,
    kinetic: Option<Series<Ball>>,
}

/// Why the expansion of a mode ends early.
pub(super) enum Ended {
    /// Derivatives are no numbers.
    NotSmooth,
    Obstacle(Obstacle),
}

/// A path to the second order: coordinates and velocities.
struct Path {
    place: [Vec<Ball>; 2],
    speed: [Vec<Ball>; 2],
}

fn scaled(vector: &[Ball], factor: &Ball) -> Vec<Ball> {
    if factor.is_zero() { vec![Ball::ZERO; vector.len()] } else { vector.iter().map(|x| *x * *factor).collect() }
}

/// a x + b y
fn combined(x: &[Ball], a: &Ball, y: &[Ball], b: &Ball) -> Vec<Ball> {
    x.iter().zip(y).map(|(x, y)| *a * *x + *b * *y).collect()
}

fn norm(parts: &[Ball]) -> f64 {
    parts.iter().map(certain).fold(0.0, f64::hypot)
}

/// The size, 0 where it is not told from 0.
fn certain(value: &Ball) -> f64 {
    if value.contains_zero() { 0.0 } else { value.mid_f64().abs() }
}

/// The coefficients of one order, of a series that runs up to it.
fn coefficients(series: &mut Series<Ball>, inputs: &[Vec<Ball>], zeros: &[Ball], order: usize) -> Vec<Ball> {
    series.clear();
    let mut out = Vec::new();
    for k in 0..=order {
        out = series.next(inputs.get(k).map_or(zeros, Vec::as_slice)).to_vec();
    }
    out
}

impl<'a> Expansion<'a> {
    pub(super) fn new(energies: &Energies, basis: &'a Basis, equilibrium: &'a [Ball]) -> Self {
        Self {
            basis,
            equilibrium,
            potential: energies.potential.prepare::<Ball>(()).series(),
            kinetic: energies.kinetic.as_ref().map(|tape| tape.prepare::<Ball>(()).series()),
        }
    }

    /// ∂U/∂q of an order along a path.
    fn force(&mut self, place: &[&[Ball]], order: usize) -> Vec<Ball> {
        let mut inputs = vec![self.equilibrium.to_vec()];
        inputs.extend(place.iter().map(|own| own.to_vec()));
        coefficients(&mut self.potential, &inputs, &vec![Ball::ZERO; self.equilibrium.len()], order)
    }

    /// ∂T2/∂q and ∂T2/∂q' of an order along a path; `None` where the masses are the same everywhere: then the first is 0 and
    /// the second has no further terms than M times the velocity.
    fn inertia(&mut self, path: &Path, order: usize) -> Option<(Vec<Ball>, Vec<Ball>)> {
        let series = self.kinetic.as_mut()?;
        let n = self.equilibrium.len();
        let zeros = vec![Ball::ZERO; 2 * n];
        let mut inputs = vec![self.equilibrium.to_vec()];
        inputs[0].resize(2 * n, Ball::ZERO);
        inputs.extend(path.place.iter().zip(&path.speed).map(|(q, v)| [q.as_slice(), v].concat()));
        let mut both = coefficients(series, &inputs, &zeros, order);
        let second = both.split_off(n);
        Some((both, second))
    }

    /// What becomes of a mode, by its number, for an amplitude of the coordinate of `found`.
    ///
    /// Where an obstacle ends it, `found` keeps what was found before.
    pub(super) fn mode(&mut self, at: usize, own: &NormalMode, found: &mut ModeAmplitude) -> Result<(), Ended> {
        let basis = self.basis;
        let group = &basis.groups[basis.group_of[at]];
        let square = group.square;
        if own.kind == Kind::Zero || !square.is_positive() {
            return Err(Ended::Obstacle(Obstacle::NoOscillation));
        }
        let omega = square.sqrt();
        let shape = &basis.shapes[at];
        let (still, double) = self.second_order(shape, square)?;
        let fourfold = square.scale(2);
        let (still, double) = (basis.components(&still), basis.components(&double));
        let displaced = |components: &[Ball], square: &Ball, obstacle: fn(usize) -> Obstacle| {
            basis.response(components, square).map_err(|with| Ended::Obstacle(obstacle(with)))
        };
        let zeroth = displaced(&still, &Ball::ZERO, |with| Obstacle::Drift { with })?;
        let second = displaced(&double, &fourfold, |with| Obstacle::OneToTwo { with })?;

        // Third order.
        let c0 = basis.displacement(&zeroth);
        let c2 = basis.displacement(&second);
        let (first, triple) = self.third_order(shape, &omega, &c0, &c2);
        if !(first.iter().chain(&triple).all(Ball::is_finite)) {
            // Derivatives, unless bounds of shapes that are not told apart left nothing of the second order.
            if c0.iter().chain(&c2).all(Ball::is_finite) {
                return Err(Ended::NotSmooth);
            }
            return Err(Ended::Obstacle(Obstacle::Undecided));
        }
        let (mut first, triple) = (basis.components(&first), basis.components(&triple));
        let change = -(first[at] / square.scale(1));
        for (place, group) in basis.groups.iter().enumerate() {
            if place != basis.group_of[at] && !(group.square - square).contains_zero() {
                continue;
            }
            for k in group.members.iter().filter(|k| **k != at) {
                if !first[*k].contains_zero() {
                    found.equal = Vec::new();
                    return Err(Ended::Obstacle(Obstacle::OneToOne { with: *k }));
                }
                found.equal.push(*k);
            }
        }
        let ninefold = square * Ball::exact(9.0);
        let third = displaced(&triple, &ninefold, |with| Obstacle::OneToThree { with })?;
        // All of that frequency is either the mode itself or not displaced.
        first[at] = Ball::ZERO;
        let beside = displaced(&first, &square, |with| Obstacle::OneToOne { with })?;
        let largest = shape[found.coordinate];
        let change_per_square = change / (largest * largest);
        if !change_per_square.is_finite() {
            return Err(Ended::Obstacle(Obstacle::Undecided));
        }
        // Parts that grow with a beside the mode, then those that grow with a².
        let linear = [norm(&zeroth), norm(&second)].map(|part| part / SHARE);
        let quadratic = [norm(&beside), norm(&third), certain(&change)].map(|part| (part / SHARE).sqrt());
        let steepest = linear.into_iter().chain(quadratic).fold(0.0, f64::max);
        let reach = largest.mid_f64().abs() / steepest;
        found.change = Some(change_per_square);
        found.reach = reach.is_finite().then_some(reach);
        Ok(())
    }

    /// What is constant in the second order, and what has twice the frequency.
    fn second_order(&mut self, shape: &[Ball], square: Ball) -> Result<(Vec<Ball>, Vec<Ball>), Ended> {
        let shape = shape.to_vec();
        let none = vec![Ball::ZERO; shape.len()];
        let mut still: Vec<Ball> = self.force(&[&shape], 2).iter().map(|a| -a.scale(-1)).collect();
        let mut double = still.clone();
        let straight = Path { place: [shape.clone(), none.clone()], speed: [shape, none] };
        if let Some((d, b)) = self.inertia(&straight, 2) {
            for i in 0..still.len() {
                let gradient = square * d[i] * Ball::ONE.scale(-1);
                still[i] = still[i] + gradient;
                double[i] = double[i] - gradient + square * b[i];
            }
        }
        if still.iter().chain(&double).all(Ball::is_finite) { Ok((still, double)) } else { Err(Ended::NotSmooth) }
    }

    /// G1 and G3.
    fn third_order(&mut self, shape: &[Ball], omega: &Ball, c0: &[Ball], c2: &[Ball]) -> (Vec<Ball>, Vec<Ball>) {
        let n = shape.len();
        let (one, half, three) = (Ball::ONE, Ball::ONE.scale(-1), Ball::exact(3.0));
        let (third, two_thirds, root) = (one / three, Ball::exact(2.0) / three, three.sqrt() * half);
        // At u = 0 all is at rest: F1 + F3.
        let most = combined(c0, &one, c2, &one);
        let whole: Vec<Ball> = self.force(&[shape, &most], 3).iter().map(|f| -*f).collect();
        // At u = pi/3: F1/2 - F3.
        let path = Self::path(shape, omega, (c0, c2), [half, root, -half, root]);
        let mut part: Vec<Ball> =
            self.force(&path.place.each_ref().map(Vec::as_slice), 3).iter().map(|f| -*f).collect();
        let inertia = self.inertia(&path, 3);
        if let Some((gradient, _)) = &inertia {
            for (place, g) in part.iter_mut().zip(gradient) {
                *place = *place + *g;
            }
        }
        let mut first: Vec<Ball> = whole.iter().zip(&part).map(|(a, b)| (*a + *b) * two_thirds).collect();
        // F3 = (F1 + F3)/3 - (F1/2 - F3) 2/3
        let mut triple: Vec<Ball> = whole.iter().zip(&part).map(|(a, b)| *a * third - *b * two_thirds).collect();
        if inertia.is_none() {
            return (first, triple);
        }
        // At u = pi/2: P1 - P3; at u = pi/6: P1/2 + P3.
        let path = Self::path(shape, omega, (c0, c2), [Ball::ZERO, one, -one, Ball::ZERO]);
        let difference = self.inertia(&path, 3);
        let path = Self::path(shape, omega, (c0, c2), [root, half, half, root]);
        let sum = self.inertia(&path, 3);
        if let (Some((_, difference)), Some((_, sum))) = (difference, sum) {
            let threefold = *omega * three;
            for i in 0..n {
                let p1 = (difference[i] + sum[i]) * two_thirds;
                let p3 = sum[i] - p1 * half;
                first[i] = first[i] - *omega * p1;
                triple[i] = triple[i] - threefold * p3;
            }
        }
        (first, triple)
    }

    /// a s cos u + a² (C0 + C2 cos 2u) and its derivative -a w s sin u - 2 a² w C2 sin 2u, from cos u, sin u, cos 2u and sin 2u.
    fn path(
        s: &[Ball],
        omega: &Ball,
        (c0, c2): (&[Ball], &[Ball]),
        [cosine, sine, double_cosine, double_sine]: [Ball; 4],
    ) -> Path {
        Path {
            place: [scaled(s, &cosine), combined(c0, &Ball::ONE, c2, &double_cosine)],
            speed: [scaled(s, &-(*omega * sine)), scaled(c2, &-(omega.scale(1) * double_sine))],
        }
    }
}
