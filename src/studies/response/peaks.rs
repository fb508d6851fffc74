//! Where an amplitude has its maxima and minima between the ends of a range: all of them, each enclosed.
//!
//! The slope of |x|² over the range is 2 Re(x* x'), with x' from a second elimination (`solve`). Where it excludes 0 over a whole piece of the range,
//! nothing is missed there; other pieces are halved (branch and bound) until what is left is so narrow that the signs at its ends decide: from
//! rising to falling is a maximum. Without friction x is real, and where its sign changes the maximum is a pole if 1/x is finite throughout, and
//! the minimum a zero if x is; with friction it is one where a factor of x that is real changes its sign. Pieces without a change that can't
//! be excluded are reported, not passed over: a mode that the force does not excite makes the linear system singular, too.

use librate_core::worded;
use std::collections::VecDeque;

use super::solve::{Matrices, Slope};
use super::{Force, LEVELS, ResponseError, Study, System};
use crate::source::{End, between, written_ends};
use librate_core::number::Number;
use librate_core::order::Order;
use librate_core::precision::{Ball, Complex, Enclosure, Scalar};

/// Pieces of the range are not halved more often: two maxima so close are taken for one.
const NARROWEST: usize = 34;
/// Pieces at the ends of the range, whose slope may be 0 right there, and how often what lies behind them is halved at least.
const AT_ENDS: usize = 70;
const BEHIND_ENDS: usize = 24;
/// Places in a piece that are looked at, in thousandths of it.
const INSIDE: [i64; 3] = [333, 571, 802];
/// Multiplications for one output, and pieces that are examined. About a place at which a factor cancels, more and more of them lie side by side:
/// such long rows come last.
const MOST_WORK: f64 = 1e8;
const MOST_PIECES: f64 = 2e4;
const LONG_ROW: usize = 1 << 8;
/// Halvings of an enclosure at most.
const MOST_HALVINGS: usize = 200;

worded! {
/// What an amplitude does at a place.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
#[non_exhaustive]
PeakKind {
    /// A finite largest amplitude.
    Maximum "maximum",
    /// An infinite amplitude: an undamped resonance.
    Resonance "resonance",
    /// A smallest amplitude.
    Minimum "minimum",
    /// The coordinate rests.
    Antiresonance "antiresonance",
}
/// In words.
name
}

/// A maximum or a minimum of an amplitude.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Peak {
    /// Which.
    pub kind: PeakKind,
    /// The frequency, or the parameter in it in the unit that it is declared with.
    pub place: Ball,
    /// The amplitude in SI; `None` where it is infinite.
    pub amplitude: Option<Ball>,
    /// Where below and above a maximum the amplitude has fallen to 1/√2 of it, half the power; `None` where it does not before the next minimum, the
    /// end of the range or a piece that is not decided.
    pub half_power: [Option<Ball>; 2],
}

/// The maxima and minima of one output.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Peaks {
    /// The coordinate.
    pub coordinate: String,
    /// The unit of its amplitude in SI, where the file tells.
    pub unit: Option<String>,
    /// In the order of the range.
    pub found: Vec<Peak>,
    /// Pieces of the range in which bounds do not decide. There may be more in them, in the rest there is none.
    pub undecided: Vec<[f64; 2]>,
}

/// A piece of the range: shares of the way from its first value to its last.
type Piece = [Number; 2];

/// The response of an output over a piece.
struct Sample {
    x: Complex<Ball>,
    square: Ball,
    /// Half the slope of the square over the share of the range.
    slope: Ball,
}

/// The search for the maxima and minima of one output.
struct Search<'a> {
    system: &'a System,
    /// The ends in SI, and as they are written.
    ends: [&'a [End; 2]; 2],
    output: usize,
    accuracy: f64,
}

fn middle([from, to]: &Piece) -> Number {
    from.add(to).mul(&Number::half())
}

/// A place in a piece, in thousandths of it.
fn from_share([from, to]: &Piece, share: i64) -> Number {
    from.add(&to.sub(from).mul(&Number::ratio(share, 1000).unwrap_or_default()))
}

/// Pieces in order, those that overlap or touch each other as one.
fn joined(mut pieces: Vec<Piece>) -> Vec<Piece> {
    pieces.order_by(|left, right| left[0].cmp(&right[0]));
    let mut all = Vec::<Piece>::new();
    for piece in pieces {
        match all.last_mut().filter(|last| last[1] >= piece[0]) {
            Some(last) if last[1] >= piece[1] => {}
            Some(last) => last[1] = piece[1].clone(),
            None => all.push(piece),
        }
    }
    all
}

impl Study {
    /// The maxima and minima of the amplitude of one of the outputs (from 0) between the ends of the range: all that are farther apart than
    /// 2⁻³⁴ of it, and from its ends than 2⁻⁷⁰, or in [`Peaks::undecided`].
    ///
    /// # Errors
    /// [`ResponseError::Unsupported`] where M, C, K or the equilibrium depend on the parameter of the range.
    pub fn peaks(&self, output: usize) -> Result<Peaks, ResponseError> {
        let span = self.model.time_dependent.unwrap_or_default();
        let what = "the peaks over a parameter on which more than the drive depends";
        let Some(system) = &self.fixed else { return Err(ResponseError::Unsupported { what, span }) };
        let given = written_ends(&self.request.range)?;
        let is_empty = given.each_ref().map(End::rational);
        if matches!(is_empty, [Some(from), Some(to)] if from == to) {
            return Err(ResponseError::EmptyRange { range: self.request.range.expression(0) });
        }
        let number = self.outputs[output];
        // As many as a double has for JSON; an enclosure is not narrower than double-double.
        let accuracy = 10_f64.powi(-3 - self.request.digits.max(16) as i32).max(1e-30);
        let (found, undecided) = Search { system, ends: [&self.ends, &given], output: number, accuracy }.run();
        let unit = self.unit(number);
        Ok(Peaks { coordinate: self.model.coordinates.at(number).name(), unit, found, undecided })
    }

    /// How many coordinates are wanted.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }
}

impl Search<'_> {
    fn run(&self) -> (Vec<Peak>, Vec<[f64; 2]>) {
        let (pieces, mut undecided) = self.narrowed();
        let [first, last] = [Number::ZERO, Number::ONE];
        let mut turns: Vec<(Piece, bool)> = Vec::new();
        let narrow = pieces.len();
        for (at, piece) in pieces.into_iter().chain(undecided.clone()).enumerate() {
            // An end of the range is no extremum, whatever the slope is there.
            if piece[0] == first || piece[1] == last {
                continue;
            }
            match piece.each_ref().map(|end| self.rises(end)) {
                [Some(true), Some(false)] => turns.push((piece, true)),
                [Some(false), Some(true)] => turns.push((piece, false)),
                _ if at < narrow => undecided.push(piece),
                _ => {}
            }
        }
        turns.order_by(|(left, _), (right, _)| left[0].cmp(&right[0]));
        let halved = |(piece, is_top): &(Piece, bool)| self.closed_in(piece, |at| Some(self.rises(at)? == *is_top));
        let exact: Vec<(Piece, bool)> = turns.iter().map(|own| (halved(own), own.1)).collect();
        let mut found = Vec::with_capacity(exact.len());
        let open = joined(undecided.clone());
        for (at, (piece, is_top)) in exact.iter().enumerate() {
            let before = at.checked_sub(1).map_or(&first, |before| &exact[before].0[1]);
            let after = exact.get(at + 1).map_or(&last, |(after, _)| &after[0]);
            // Between these, and up to where nothing is decided, the amplitude rises or falls throughout.
            let before = open.iter().map(|own| &own[1]).filter(|end| *end <= &piece[0]).fold(before, Ord::max);
            let after = open.iter().map(|own| &own[0]).filter(|end| *end >= &piece[1]).fold(after, Ord::min);
            let is_inside = open.iter().any(|own| own[0] < piece[1] && piece[0] < own[1]);
            match self.peak(piece, *is_top, [before, after]) {
                Some(peak) if is_inside => found.push(Peak { half_power: [None, None], ..peak }),
                Some(peak) => found.push(peak),
                None => undecided.push(piece.clone()),
            }
        }
        let place = |share: &Number| self.place([share, share]).map_or(f64::NAN, |place| place.mid_f64());
        (found, joined(undecided).iter().map(|piece| piece.each_ref().map(place)).collect())
    }

    /// The narrow pieces in which the slope may be 0, and those that there was no time for.
    fn narrowed(&self) -> (Vec<Piece>, Vec<Piece>) {
        let mut left = (MOST_WORK / self.system.balls.work_over()).min(MOST_PIECES);
        let (mut narrow, mut undecided) = (Vec::<Piece>::new(), Vec::<Piece>::new());
        // What rests over a piece of the range rests everywhere.
        let somewhere = [333, 334].map(|share| from_share(&[Number::ZERO, Number::ONE], share));
        let is_decided = |own: Sample| !own.slope.contains_zero();
        if self.eliminated(&somewhere, None, false).is_some_and(|x| x.re.is_zero() && x.im.is_zero()) {
            return (narrow, undecided);
        }
        // So close to an end the slope may be lost in rounding: then it is everywhere in the piece, not at a peak alone.
        let is_lost = |piece: &Piece| {
            INSIDE.iter().all(|from| {
                let inside = [*from, from + 1].map(|share| from_share(piece, share));
                !self.sample(&inside, None).is_some_and(is_decided)
            })
        };
        let [mut rows, mut long] =
            [VecDeque::from([(0, vec![(AT_ENDS, [Number::ZERO, Number::ONE])])]), VecDeque::new()];
        while let Some((depth, row)) = rows.pop_front().or_else(|| long.pop_front()) {
            left -= row.len() as f64;
            if left < 0.0 {
                undecided.extend(row.into_iter().map(|(_, piece)| piece));
                continue;
            }
            let mut next = Vec::new();
            for (narrowest, piece) in row {
                if self.sample(&piece, None).is_some_and(is_decided)
                    || depth > NARROWEST && narrowest != AT_ENDS && is_lost(&piece)
                {
                    continue;
                }
                if depth >= narrowest {
                    narrow.push(piece);
                    continue;
                }
                let half = middle(&piece);
                let [from, to] = piece;
                next.extend([[from, half.clone()], [half, to]].map(|own| {
                    let is_at_end = own[0].is_zero() || own[1].is_one();
                    let behind = if narrowest == AT_ENDS { NARROWEST.max(depth + 1 + BEHIND_ENDS) } else { narrowest };
                    (if is_at_end { AT_ENDS } else { behind }, own)
                }));
            }
            for row in next.chunk_by(|(_, left), (_, right)| left[1] == right[0]) {
                if row.len() > LONG_ROW { &mut long } else { &mut rows }.push_back((depth + 1, row.to_vec()));
            }
        }
        (joined(narrow), joined(undecided))
    }

    /// What the response is over a piece: in double-double, or at a level above.
    fn sample(&self, piece: &Piece, level: Option<usize>) -> Option<Sample> {
        match level {
            None => self.sample_in(&self.system.balls, piece),
            Some(level) => self.sample_in(self.system.level(level)?, piece),
        }
    }

    fn sample_in<S: Enclosure>(&self, matrices: &Matrices<S>, piece: &Piece) -> Option<Sample> {
        let force = self.force(matrices, piece)?;
        let rise = |[x, slope]: &[Complex<S>; 2]| x.re.mul(&slope.re).add(&x.im.mul(&slope.im)).to_ball();
        let plain = || matrices.with_slope(&force, self.output);
        let both = match self.system.force {
            Force::Unit(_) if piece[0] != piece[1] => {
                let [omega, way] = &force.omega;
                let center = omega.center();
                let reach = omega.sub(&center);
                let over = matrices.with_slope_over([&center, &reach], &force.forces, self.output);
                let over = over.map(|[x, slope]| [x, slope.times(way)]);
                // Its bounds have the size of the largest response: where this one is tiny, elimination tells more.
                let is_open = |own: &[Complex<S>; 2]| rise(own).contains_zero();
                if over.as_ref().is_none_or(is_open) { plain().filter(|own| !is_open(own)).or(over)? } else { over? }
            }
            _ => plain()?,
        };
        let (slope, [x, _]) = (rise(&both), both);
        let square = axis(&x).map_or_else(|| x.square_of_modulus(), |axis| axis.part(&x).powi(2));
        let (x, square) = (Complex::new(x.re.to_ball(), x.im.to_ball()), square.to_ball());
        let is_usable = slope.is_finite() && square.is_finite();
        is_usable.then_some(Sample { x, square, slope })
    }

    /// What drives the model over a piece.
    fn force<S: Enclosure>(&self, matrices: &Matrices<S>, piece: &Piece) -> Option<Slope<S>> {
        let precision = matrices.precision;
        let [from, to] = piece.each_ref().map(|share| between::<S>(self.ends[0], share, precision));
        let (from, to) = (from?, to?);
        let quantity = if piece[0] == piece[1] { from } else { from.hull(&to) };
        let [start, end] = [Number::ZERO, Number::ONE].map(|share| between::<S>(self.ends[0], &share, precision));
        let way = end?.sub(&start?);
        match &self.system.force {
            Force::Unit(at) => {
                let forces = vec![(*at, Complex::real(1.0, precision))];
                Some(Slope { omega: [quantity, way], forces, slopes: Vec::new() })
            }
            Force::Own(drive) => {
                let [(omega, forces), (rise, slopes)] = drive.at(&quantity, &matrices.point, precision)?;
                let slopes = slopes.into_iter().map(|(at, slope)| (at, slope.times(&way))).collect();
                Some(Slope { omega: [omega, rise.mul(&way)], forces, slopes })
            }
        }
    }

    fn levels() -> impl Iterator<Item = Option<usize>> {
        std::iter::once(None).chain((0..LEVELS.len()).map(Some))
    }

    /// Whether the amplitude rises at a place.
    fn rises(&self, at: &Number) -> Option<bool> {
        let piece = [at.clone(), at.clone()];
        Self::levels().find_map(|level| sign(&self.sample(&piece, level)?.slope))
    }

    /// A piece in units of the range as it is written.
    fn place(&self, [from, to]: [&Number; 2]) -> Option<Ball> {
        let [from, to] = [from, to].map(|share| between::<Ball>(self.ends[1], share, ()));
        Some(from?.hull(&to?))
    }

    /// Halves a piece around a change from true to false until its digits are decided.
    fn closed_in(&self, piece: &Piece, is_before: impl Fn(&Number) -> Option<bool>) -> Piece {
        let mut piece = piece.clone();
        for _ in 0..MOST_HALVINGS {
            let is_known = |place: Ball| place.radius <= self.accuracy * place.mid_f64().abs();
            if self.place(piece.each_ref()).is_none_or(is_known) {
                break;
            }
            let half = middle(&piece);
            // The place itself may be hit, where nothing is decided.
            let quarters = || [middle(&[piece[0].clone(), half.clone()]), middle(&[half.clone(), piece[1].clone()])];
            let tried = if is_before(&half).is_some() { vec![half] } else { quarters().to_vec() };
            let before = piece.clone();
            for at in tried {
                match is_before(&at) {
                    Some(true) => piece[0] = at,
                    Some(false) => {
                        piece[1] = at;
                        break;
                    }
                    None => {}
                }
            }
            if piece == before {
                break;
            }
        }
        piece
    }

    /// What is in a piece around a change of the slope's sign, `None` where bounds do not tell.
    fn peak(&self, piece: &Piece, is_top: bool, neighbours: [&Number; 2]) -> Option<Peak> {
        let place = self.place(piece.each_ref())?;
        let ends = piece.each_ref().map(|end| {
            let x = Self::levels().find_map(|level| self.sample(&[end.clone(), end.clone()], level))?.x;
            let axis = axis(&x)?;
            Some((axis, sign(axis.part(&x))?))
        });
        let turned = match ends {
            [Some((axis, left)), Some((other, right))] if axis == other && left != right => Some(axis),
            _ => None,
        };
        let of = |kind, amplitude| Some(Peak { kind, place, amplitude, half_power: [None, None] });
        if let Some(turned) = turned {
            let stays = |x: Option<Complex<Ball>>| x.is_some_and(|x| axis(&x) == Some(turned));
            // The reciprocal has a zero at a pole.
            if !Self::levels().any(|level| stays(self.eliminated(piece, level, is_top))) {
                return None;
            }
            return if is_top { of(PeakKind::Resonance, None) } else { of(PeakKind::Antiresonance, Some(Ball::ZERO)) };
        }
        let Some(square) = Self::levels().find_map(|level| self.square(piece, level)) else {
            let is_finite = |level| self.eliminated(piece, level, false).is_some();
            let vanishes = |level| self.vanishes(piece, level) == Some(true);
            let rests = !is_top && Self::levels().any(vanishes) && Self::levels().any(is_finite);
            return if rests { of(PeakKind::Antiresonance, Some(Ball::ZERO)) } else { None };
        };
        let amplitude = Some(square.sqrt());
        if !is_top {
            return of(PeakKind::Minimum, amplitude);
        }
        let half = square * Ball::exact(0.5);
        let mut half_power = [self.fall(neighbours[0], &piece[0], half), self.fall(neighbours[1], &piece[1], half)];
        // In a range from high to low.
        let beyond = |side: usize| half_power[side].map(|own| own - place);
        if beyond(0).is_some_and(|own| own.is_positive()) || beyond(1).is_some_and(|own| own.is_negative()) {
            half_power.reverse();
        }
        Some(Peak { kind: PeakKind::Maximum, place, amplitude, half_power })
    }

    /// x or, in some unit, 1/x over a piece, where it is finite, with parts that are exactly 0 as such.
    fn eliminated(&self, piece: &Piece, level: Option<usize>, is_reciprocal: bool) -> Option<Complex<Ball>> {
        match level {
            None => self.eliminated_in(&self.system.balls, piece, is_reciprocal),
            Some(level) => self.eliminated_in(self.system.level(level)?, piece, is_reciprocal),
        }
    }

    fn eliminated_in<S: Enclosure>(
        &self,
        matrices: &Matrices<S>,
        piece: &Piece,
        is_reciprocal: bool,
    ) -> Option<Complex<Ball>> {
        let force = self.force(matrices, piece)?;
        let response = || matrices.response(&force.omega[0], &force.forces, &[self.output])?.pop();
        let found = if is_reciprocal { matrices.reciprocal(&force, self.output) } else { response() }?;
        Some(Complex::new(found.re.to_ball(), found.im.to_ball()))
    }

    /// Whether x, if finite, is proved to be 0 somewhere in a piece.
    fn vanishes(&self, piece: &Piece, level: Option<usize>) -> Option<bool> {
        match level {
            None => self.vanishes_in(&self.system.balls, piece),
            Some(level) => self.vanishes_in(self.system.level(level)?, piece),
        }
    }

    fn vanishes_in<S: Enclosure>(&self, matrices: &Matrices<S>, piece: &Piece) -> Option<bool> {
        let [from, to] =
            piece.each_ref().map(|end| Some(self.force(matrices, &[end.clone(), end.clone()])?.omega[0].clone()));
        matrices.vanishes(&self.force(matrices, piece)?, [&from?, &to?], self.output)
    }

    /// |x|² at a maximum or minimum in a piece, by the mean value theorem, where its digits are decided.
    fn square(&self, piece: &Piece, level: Option<usize>) -> Option<Ball> {
        let half = middle(piece);
        let there = self.sample(&[half.clone(), half], level)?.square;
        let width = Ball::from_number(&piece[1].sub(&piece[0]), ());
        let change = self.sample(piece, level)?.slope * width;
        let square = there.with_added_radius(change.abs_upper());
        (square.radius <= self.accuracy * square.mid_f64()).then_some(square)
    }

    /// Where |x|² falls to a value between a maximum and what is next to it on one side.
    fn fall(&self, far: &Number, near: &Number, value: Ball) -> Option<Ball> {
        let is_over = |at: &Number| {
            let piece = [at.clone(), at.clone()];
            Self::levels().find_map(|level| sign(&(self.sample(&piece, level)?.square - value)))
        };
        // At the end of a range it may be singular: then a place inside decides.
        let inside = |part: i32| Some(far.add(&near.sub(far).mul(&Number::from(2).powi(-part)?)));
        let places = std::iter::once(far.clone()).chain([40, 30, 20, 10].into_iter().filter_map(inside));
        let mut decided = places.filter_map(|at| Some((is_over(&at)?, at)));
        let (false, far) = decided.next()? else { return None };
        let to_the_left = far.sub(near).is_negative();
        let piece = if to_the_left { [far.clone(), near.clone()] } else { [near.clone(), far.clone()] };
        let piece = self.closed_in(&piece, |at| Some(is_over(at)? != to_the_left));
        self.place(piece.each_ref())
    }
}

/// The axis of the complex plane that a number is on for certain.
#[derive(Clone, Copy, PartialEq)]
enum Axis {
    Real,
    Imaginary,
}

impl Axis {
    fn part<S: Scalar>(self, x: &Complex<S>) -> &S {
        match self {
            Self::Real => &x.re,
            Self::Imaginary => &x.im,
        }
    }
}

fn axis<S: Enclosure>(x: &Complex<S>) -> Option<Axis> {
    if x.im.is_exact_zero() { Some(Axis::Real) } else { x.re.is_exact_zero().then_some(Axis::Imaginary) }
}

/// Whether a number is positive, where that is decided.
fn sign(value: &Ball) -> Option<bool> {
    (value.is_positive() || value.is_negative()).then(|| value.is_positive())
}
