//! Whether a period is one: from the form of the equations, and by trying.

use super::error::FloquetError;
use super::monodromy::short;
use super::motion::Driven;
use librate_core::expr::{ExprId, Node, Pool, Substitution, Symbol, Tape};
use librate_core::number::{Number, gcd64};
use librate_core::precision::{Ball, Function};

/// Times at which a period is tried.
pub const TRIALS: u32 = 24;

/// What an expression becomes when the time goes on by a period.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Later {
    /// The same.
    Same,
    /// Its opposite.
    Opposite,
    /// More by something that does not contain the time.
    More(ExprId),
    /// Something else, as far as the form shows.
    Other,
}

/// Whether expressions are the same a period later, for any values of all other symbols; `None` where their form does not
/// show it.
///
/// Sines and cosines of what grows by a multiple of pi return, or change their sign; sums, products and functions of what
/// returns return too. What is left over is compared with itself a period later ([`Pool::is_zero`]).
pub(crate) fn repeats(pool: &mut Pool, time: Symbol, period: ExprId, roots: &[ExprId]) -> Option<u32> {
    let turns = shown(pool, time, period, roots)?;
    // A drive that goes through several cycles in the period has all its angles go through as many half turns, or twice as many.
    let common = turns.iter().fold(0, |a, b| gcd64(a, *b));
    let half = if common % 2 == 0 { common / 2 } else { 0 };
    let mut cycles = 1;
    for count in [common, half] {
        let Some(count) = u32::try_from(count).ok().filter(|count| *count > 1) else { continue };
        let share = Number::from(i64::from(count)).recip();
        let Some(share) = share else { continue };
        let part = pool.scale(period, &share);
        if shown(pool, time, part, roots).is_some() {
            cycles = count;
            break;
        }
    }
    Some(cycles)
}

/// By how many half turns the angles of sines and cosines grow, where all roots are shown to return.
fn shown(pool: &mut Pool, time: Symbol, period: ExprId, roots: &[ExprId]) -> Option<Vec<u64>> {
    let ids = pool.reachable(roots);
    let mut later: Vec<Later> = Vec::with_capacity(ids.len());
    let mut turns = Vec::new();
    for id in &ids {
        // Children stand before their parents.
        let of = |child: ExprId| ids.binary_search(&child).map_or(Later::Other, |at| later[at]);
        let own = match pool.node(*id).clone() {
            Node::Symbol(symbol) if symbol == time => Later::More(period),
            Node::Number(_) | Node::Pi | Node::Undefined | Node::Symbol(_) => Later::Same,
            Node::Sum { constant, terms } => {
                let parts: Vec<(Later, Number)> = terms.iter().map(|(term, c)| (of(*term), c.clone())).collect();
                sum(pool, constant.is_zero(), &parts)
            }
            Node::Product(factors) => {
                let parts: Vec<(Later, ExprId, Number)> =
                    factors.iter().map(|(base, exponent)| (of(*base), *base, exponent.clone())).collect();
                product(pool, time, &parts)
            }
            Node::Power { base, exponent } => both(of(base), of(exponent)),
            Node::Atan2 { y, x } => both(of(y), of(x)),
            Node::Function(function, x) => match of(x) {
                Later::Same => Later::Same,
                Later::Opposite => match function {
                    Function::Cos | Function::Cosh | Function::Abs => Later::Same,
                    Function::Sin
                    | Function::Tan
                    | Function::Asin
                    | Function::Atan
                    | Function::Sinh
                    | Function::Tanh => Later::Opposite,
                    Function::Acos | Function::Exp | Function::Ln => Later::Other,
                },
                Later::More(by) => match (function, half_turns(pool, by)) {
                    (Function::Tan, Some(count)) => {
                        turns.push(count);
                        Later::Same
                    }
                    (Function::Sin | Function::Cos, Some(count)) => {
                        turns.push(count);
                        if count % 2 == 0 { Later::Same } else { Later::Opposite }
                    }
                    _ => Later::Other,
                },
                Later::Other => Later::Other,
            },
        };
        later.push(own);
    }
    for root in roots {
        let own = ids.binary_search(root).map_or(Later::Other, |at| later[at]);
        if own != Later::Same {
            let now = pool.symbol_expr(time);
            let then = pool.add(now, period);
            let moved = pool.substitute_one(*root, &Substitution::from([(time, then)]));
            if !pool.agree(moved, *root) {
                return None;
            }
        }
    }
    Some(turns)
}

fn both(first: Later, second: Later) -> Later {
    if first == Later::Same && second == Later::Same { Later::Same } else { Later::Other }
}

fn sum(pool: &mut Pool, without_constant: bool, parts: &[(Later, Number)]) -> Later {
    if parts.iter().all(|(own, _)| *own == Later::Same) {
        return Later::Same;
    }
    if without_constant && parts.iter().all(|(own, _)| *own == Later::Opposite) {
        return Later::Opposite;
    }
    let mut terms = Vec::new();
    for (own, factor) in parts {
        match own {
            Later::Same => {}
            Later::More(by) => terms.push((*by, factor.clone())),
            Later::Opposite | Later::Other => return Later::Other,
        }
    }
    more(pool, &terms)
}

fn more(pool: &mut Pool, terms: &[(ExprId, Number)]) -> Later {
    let by = pool.linear(terms);
    if pool.vanishes(by) { Later::Same } else { Later::More(by) }
}

/// Of (base, exponent) with what each base becomes.
fn product(pool: &mut Pool, time: Symbol, factors: &[(Later, ExprId, Number)]) -> Later {
    let mut opposite = false;
    let mut grows = None;
    for (own, _, exponent) in factors {
        match own {
            Later::Same => {}
            Later::Opposite if exponent.is_integer() => {
                let two = Number::from(2);
                opposite ^= exponent.rem_floor(&two).is_none_or(|rest| !rest.is_zero());
            }
            Later::More(by) if grows.is_none() && *exponent == Number::ONE => grows = Some(*by),
            Later::Opposite | Later::More(_) | Later::Other => return Later::Other,
        }
    }
    let Some(by) = grows else { return if opposite { Later::Opposite } else { Later::Same } };
    // (x + by) c is more by c times as much, for a c without the time.
    let mut others = vec![(by, Number::ONE)];
    for (own, base, exponent) in factors {
        if matches!(own, Later::More(_)) {
            continue;
        }
        if pool.depends_on(*base, &|symbol| symbol == time) {
            return Later::Other;
        }
        others.push((*base, exponent.clone()));
    }
    let by = pool.product_of_powers(&others);
    more(pool, &[(by, Number::ONE)])
}

/// How many half turns an angle is, where it is a whole number of them; their sign does not matter.
fn half_turns(pool: &mut Pool, angle: ExprId) -> Option<u64> {
    let pi = pool.pi();
    let ratio = pool.div(angle, pi);
    let count = match pool.as_number(ratio) {
        Some(number) => number.to_i64()?,
        None => {
            // A sum that is not brought to one term: 2 pi (sqrt(2) - 1)/(sqrt(2) - 1).
            let middle = librate_core::linearize::constant(pool, ratio)?.mid_f64();
            if middle.abs() > 1e15 {
                return None;
            }
            let count = middle.round() as i64;
            let whole = pool.integer(count);
            if !pool.agree(ratio, whole) {
                return None;
            }
            count
        }
    };
    Some(count.unsigned_abs())
}

/// Compares the equations of motion at many states with those a period later; states are drawn around one. What
/// is analytic and agrees at so many irregular places to 28 digits is likely to agree.
pub(crate) fn try_period(driven: &Driven, period: &Ball, state: &[f64]) -> Result<(), FloquetError> {
    let undefined = FloquetError::NotDefined { span: driven.driven_at };
    let Ok(tape) = Tape::compile(&driven.pool, &driven.expressions(), &driven.symbols()) else { return Err(undefined) };
    let prepared = tape.prepare::<Ball>(());
    let mut scratch = Vec::new();
    let mut compared = false;
    for trial in 1..=TRIALS {
        // Multiples of an irrational number spread evenly.
        let fraction = |k: u32| {
            let x = f64::from(trial * 64 + k) * 0.618_033_988_749_894_9;
            x - x.floor()
        };
        let time = *period * Ball::exact(fraction(0));
        let scale = if trial % 2 == 0 { 0.3 } else { 1e-3 };
        let mut inputs = vec![time];
        for (k, at) in state.iter().enumerate() {
            let shift = scale * (fraction(k as u32 + 1) - 0.5);
            inputs.push(Ball::exact(at + shift * at.abs().max(1.0)));
        }
        let now = prepared.evaluate(&inputs, &mut scratch);
        inputs[0] = time + *period;
        let later = prepared.evaluate(&inputs, &mut scratch);
        for (now, later) in now.iter().zip(&later) {
            let difference = *now - *later;
            if !difference.is_finite() {
                continue;
            }
            compared = true;
            if !difference.contains_zero() {
                return Err(FloquetError::NotAPeriod {
                    time: short(time.mid_f64()),
                    span: driven.period.1,
                    energy: driven.driven_at,
                });
            }
        }
    }
    if compared { Ok(()) } else { Err(undefined) }
}
