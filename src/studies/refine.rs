//! More places where curves bend, for pictures.

use librate_core::model::Range;
use librate_core::order::Order;

/// An interval is halved so many times.
pub(crate) const DEEPEST: u32 = 16;
/// What is off by less than this part of the height of a picture is not seen: half a pixel.
pub(crate) const FLAT: f64 = 1.0 / 760.0;
/// So many places are added for each that there is, ...
pub(crate) const MOST_FINER: usize = 4;
/// ... or for all of a few.
pub(crate) const FEW_FINER: usize = 400;

/// A range of many more places, and after how many of these the next one of the range comes.
#[must_use]
pub fn finest(range: &Range) -> (Range, usize) {
    let halved = |(range, step): (Range, usize), _| match range.finer() {
        Some(finer) => (finer, 2 * step),
        None => (range, step),
    };
    (0..DEEPEST).fold((range.clone(), 1), halved)
}

/// How far the second of three points is off the line through the others.
pub(crate) fn off_line(at: [f64; 3], values: [f64; 3]) -> f64 {
    let share = (at[1] - at[0]) / (at[2] - at[0]);
    (values[1] - values[0] - share * (values[2] - values[0])).abs()
}

/// What `make` makes of each `step`th place, so many of them, and of places between where curves through the numbers of `row` would be off.
///
/// # Errors
/// Those of `make`.
pub fn refined<P, E>(
    count: usize,
    step: usize,
    row: impl Fn(&P) -> Vec<f64>,
    mut make: impl FnMut(&[usize]) -> Result<Vec<P>, E>,
) -> Result<Vec<P>, E> {
    let mut known: Vec<(usize, Vec<f64>, P)> = Vec::new();
    let mut wanted: Vec<usize> = (0..count).map(|at| at * step).collect();
    let mut left = count + (MOST_FINER * count).max(FEW_FINER);
    let mut slack: Vec<f64> = Vec::new();
    while !wanted.is_empty() && left > 0 {
        wanted.truncate(left);
        left -= wanted.len();
        let made = make(&wanted)?.into_iter();
        known.extend(wanted.iter().zip(made).map(|(at, place)| (*at, row(&place), place)));
        known.order_by_key(|own| own.0);
        if slack.is_empty() {
            let parts = known.first().map_or(0, |own| own.1.len());
            let span = |part: usize| span(known.iter().map(|own| own.1[part]));
            slack = (0..parts).map(span).map(|[span, rounding]| FLAT * span.max(rounding)).collect();
        }
        // A few points are on many curves.
        let mut bent = vec![known.len() < 5; known.len().saturating_sub(1)];
        for (at, three) in known.windows(3).enumerate() {
            let [a, b, c] = [&three[0], &three[1], &three[2]];
            let places = [a, b, c].map(|own| own.0 as f64);
            let off = |part: usize| off_line(places, [a, b, c].map(|own| own.1[part]));
            if slack.iter().enumerate().any(|(part, slack)| off(part) > *slack) {
                (bent[at], bent[at + 1]) = (true, true);
            }
        }
        let pairs = known.windows(2).map(|pair| [pair[0].0, pair[1].0]).zip(bent);
        let halved = pairs.filter(|([from, to], is_bent)| *is_bent && to - from > 1);
        wanted = halved.map(|([from, to], _)| from + (to - from) / 2).collect();
    }
    Ok(known.into_iter().map(|own| own.2).collect())
}

/// From the least to the largest finite number, and what rounding may be of that.
pub(crate) fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|own| own.is_finite());
    let (least, most) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), own| (least.min(own), most.max(own)));
    [most - least, 1e-9 * most.abs().max(least.abs())]
}
