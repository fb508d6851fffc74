//! Expressions as text in the model language, which reads back as the same expression.
//!
//! Terms and factors stand in the order in which they were created, numbers first, then symbols, functions last;
//! negative powers below a fraction bar, no doubled signs. The text is put together from a stack
//! of pieces, so that its depth does not matter.

use super::flags::content;
use super::{ExprId, Function, Node, PI, Pool};
use crate::number::Number;
use crate::order::Order;

/// Where an expression stands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Alone, in parentheses or as an argument.
    Open,
    /// Between `*` and `/`.
    Factor,
    /// On the left or right of `^`.
    Power,
}

/// Something still to be written.
enum Piece {
    Text(&'static str),
    Owned(String),
    Expression(ExprId, Place),
    /// A sum times a positive number, in parentheses unless it stands open, its signs reversed where asked for.
    Sum {
        id: ExprId,
        by: Number,
        negated: bool,
        place: Place,
    },
    /// `coefficient*factors` (the coefficient positive); the flagged factor with its sign reversed.
    Term {
        coefficient: Number,
        factors: Factors,
        negated: Option<ExprId>,
    },
}

/// A root that takes up a number.
struct Joined {
    /// The base below the root.
    base: ExprId,
    /// Whether it stands above the fraction bar.
    above: bool,
    /// What stands below the root then.
    inner: Piece,
}

/// Bases with their exponents.
type Factors = Vec<(ExprId, Number)>;

/// The function of a name in the model language, if it is one of one argument.
#[must_use]
pub fn function_from_name(name: &str) -> Option<Function> {
    Function::ALL.into_iter().find(|own| own.name() == name)
}

impl Pool {
    /// The expression in the language's own syntax; read back it gives the same id. (What has no
    /// value is `1/0`. Texts beyond 16 MiB are cut off and end in `…`.)
    #[must_use]
    pub fn display(&self, e: ExprId) -> String {
        self.written(Piece::Expression(e, Place::Open))
    }

    /// A sum with the fraction in front that is the size of all its coefficients, as the factor of a product: `1/2*(a + b)`, `(a - b)`; any other
    /// expression as [`Pool::display`] has it.
    pub(crate) fn display_as_factor(&self, e: ExprId) -> String {
        let Node::Sum { constant, terms } = self.node(e) else { return self.display(e) };
        if terms.len() + usize::from(!constant.is_zero()) < 2 {
            return self.display(e);
        }
        let content = content(constant, terms);
        // (m r^2/2 + m d^2) stays what it is.
        let mut sizes = terms.iter().map(|(_, c)| c).chain((!constant.is_zero()).then_some(constant));
        let alike = !content.is_integer() && sizes.all(|c| c.abs() == content);
        match content.recip().filter(|_| alike) {
            Some(by) => {
                let sum = self.written(Piece::Sum { id: e, negated: false, by, place: Place::Factor });
                format!("{}*{sum}", number_text(&content))
            }
            None => self.written(Piece::Expression(e, Place::Factor)),
        }
    }

    /// A number times powers of bases, as the factor of a product; nothing for 1. A difference takes up its minus sign.
    pub(crate) fn display_factors(&self, coefficient: &Number, factors: Vec<(ExprId, Number)>) -> Option<String> {
        if factors.is_empty() && coefficient.is_one() {
            return None;
        }
        let negated = if coefficient.is_negative() { self.reversible_factor(&factors) } else { None };
        Some(self.written(Piece::Term { coefficient: coefficient.abs(), factors, negated }))
    }

    fn written(&self, whole: Piece) -> String {
        let mut out = String::new();
        let mut stack = vec![whole];
        let mut pieces = Vec::new();
        // An expression with shared parts can be exponentially longer than its pool.
        let longest = self.budget().longest_text();
        while let Some(piece) = stack.pop() {
            if out.len() > longest || self.is_spent() {
                out.push('…');
                break;
            }
            match piece {
                Piece::Text(text) => out.push_str(text),
                Piece::Owned(text) => out.push_str(&text),
                Piece::Expression(id, place) => self.write_node(id, place, &mut pieces),
                Piece::Sum { id, negated, by, place } => self.write_sum((id, &by), negated, place, &mut pieces),
                Piece::Term { coefficient, factors, negated } => {
                    self.write_term(&coefficient, factors, negated, &mut pieces);
                }
            }
            stack.extend(pieces.drain(..).rev());
        }
        self.budget().count_text(out.len());
        out
    }

    fn write_node(&self, id: ExprId, place: Place, out: &mut Vec<Piece>) {
        match self.node(id) {
            Node::Number(value) => {
                let bare = place == Place::Open || (value.is_integer() && !value.is_negative());
                in_parentheses(!bare, out, |out| out.push(Piece::Owned(number_text(value))));
            }
            Node::Pi => out.push(Piece::Text("pi")),
            Node::Symbol(symbol) => out.push(Piece::Owned(self.symbol_name(*symbol).into_owned())),
            Node::Sum { constant, terms } => {
                // 1/2*(a - sqrt(b + c)) rather than every term halved.
                let is_one_term = constant.is_zero() && terms.len() == 1;
                let is_divided = |own: &Number| own.is_zero() || !own.is_integer();
                let goes_in_front = place == Place::Open
                    && !is_one_term
                    && is_divided(constant)
                    && terms.iter().all(|own| is_divided(&own.1))
                    && terms.iter().any(|own| self.has_root(own.0));
                let by = if goes_in_front { content(constant, terms).recip() } else { None };
                match by.filter(|by| by.is_integer() && !by.is_one()) {
                    Some(by) => {
                        out.push(Piece::Owned(format!("1/{by}*")));
                        out.push(Piece::Sum { id, negated: false, by, place: Place::Factor });
                    }
                    None => out.push(Piece::Sum { id, negated: false, by: Number::ONE, place }),
                }
            }
            Node::Product(factors) => in_parentheses(place != Place::Open, out, |out| {
                out.push(Piece::Term { coefficient: Number::ONE, factors: factors.to_vec(), negated: None });
            }),
            Node::Power { base, exponent } => in_parentheses(place == Place::Power, out, |out| {
                let [base, exponent] = [*base, *exponent].map(|e| Piece::Expression(e, Place::Power));
                out.extend([base, Piece::Text("^"), exponent]);
            }),
            Node::Function(function, x) => {
                out.push(Piece::Text(function.name()));
                in_parentheses(true, out, |out| out.push(Piece::Expression(*x, Place::Open)));
            }
            Node::Atan2 { y, x } => {
                let [y, x] = [*y, *x].map(|e| Piece::Expression(e, Place::Open));
                out.extend([Piece::Text("atan2("), y, Piece::Text(", "), x, Piece::Text(")")]);
            }
            Node::Undefined => out.push(Piece::Text("1/0")),
        }
    }

    fn write_sum(&self, (id, by): (ExprId, &Number), negated: bool, place: Place, out: &mut Vec<Piece>) {
        // Where a sign is reversed there is a difference.
        let Node::Sum { constant, terms } = self.node(id) else { return };
        let positive = |c: &Number| c.is_negative() == negated && !c.is_zero();
        let all_negative = !positive(constant) && !terms.iter().any(|(_, c)| positive(c));
        // (negative, piece)
        let mut parts: Vec<(bool, Piece)> = Vec::with_capacity(terms.len() + 1);
        if !constant.is_zero() {
            let text = number_text(&constant.abs().mul(by));
            parts.push((!positive(constant), Piece::Owned(text)));
        }
        let mut has_positive = !all_negative;
        for (term, coefficient) in terms {
            let factors = self.factors(*term);
            // Where nothing else could lead without a sign, a difference takes up the minus; of three terms and more,
            // where most of them lose theirs.
            let is_meant = |id: &ExprId| !has_positive || (!positive(coefficient) && self.is_mostly_negative(*id));
            let reversed = self.reversible_factor(&factors).filter(is_meant);
            has_positive |= reversed.is_some();
            let negative = !positive(coefficient) && reversed.is_none();
            let piece = Piece::Term { coefficient: coefficient.abs().mul(by), factors, negated: reversed };
            parts.push((negative, piece));
        }
        // What has a root stands behind what has none, as in a - √b and a + √b.
        let has_root = |(_, piece): &(bool, Piece)| match piece {
            Piece::Term { factors, .. } => factors.iter().any(|own| self.is_root_of_sum(own)),
            Piece::Text(_) | Piece::Owned(_) | Piece::Expression(..) | Piece::Sum { .. } => false,
        };
        parts.order_by_key(has_root);
        if parts.first().is_some_and(|(negative, _)| *negative) {
            // A stable sort: terms of equal sign keep their order.
            parts.order_by_key(|(negative, _)| *negative);
        }
        in_parentheses(place != Place::Open, out, |out| {
            for (at, (negative, piece)) in parts.into_iter().enumerate() {
                match (at, negative) {
                    (0, false) => {}
                    (0, true) => out.push(Piece::Text("-")),
                    (_, false) => out.push(Piece::Text(" + ")),
                    (_, true) => out.push(Piece::Text(" - ")),
                }
                out.push(piece);
            }
        });
    }

    fn is_mostly_negative(&self, sum: ExprId) -> bool {
        let Node::Sum { constant, terms } = self.node(sum) else { return false };
        let negative = terms.iter().filter(|(_, c)| c.is_negative()).count() + usize::from(constant.is_negative());
        2 * negative > terms.len() + usize::from(!constant.is_zero())
    }

    fn is_root_of_sum(&self, (base, e): &(ExprId, Number)) -> bool {
        *e == Number::half() && matches!(self.node(*base), Node::Sum { .. })
    }

    fn has_root(&self, term: ExprId) -> bool {
        self.factors(term).iter().any(|own| self.is_root_of_sum(own))
    }

    /// The first difference under an odd power: it takes up the minus sign of its term,
    /// `-k*(x - y)` as `k*(y - x)`.
    fn reversible_factor(&self, factors: &[(ExprId, Number)]) -> Option<ExprId> {
        let is_difference = |id: ExprId| self.terms(id).iter().any(|(_, c)| c.is_negative());
        factors.iter().find(|(base, e)| e.is_integer() && !e.is_even() && is_difference(*base)).map(|(base, _)| *base)
    }

    /// Numbers and pi, then symbols in order of creation, then the rest likewise, functions last: what stands behind an
    /// argument would be read as part of it.
    fn factor_order(&self, base: ExprId) -> (u8, usize) {
        match self.node(base) {
            Node::Number(_) | Node::Pi => (0, base.index()),
            Node::Symbol(symbol) => (1, symbol.index()),
            Node::Function(function, _) if *function != Function::Abs => (3, base.index()),
            Node::Atan2 { .. } => (3, base.index()),
            _ => (2, base.index()),
        }
    }

    fn write_term(&self, coefficient: &Number, mut factors: Factors, negated: Option<ExprId>, out: &mut Vec<Piece>) {
        // `a*(2 + x)/2` is written `a*(1 + x/2)`.
        let begins_with_one = |(base, e): &&(ExprId, Number)| match self.node(*base) {
            Node::Sum { constant, .. } => e.is_one() && constant.mul(coefficient).is_one(),
            _ => false,
        };
        let may_be = factors.len() > 1 && negated.is_none() && !coefficient.is_integer();
        let divided =
            factors.iter().filter(|_| may_be).find(begins_with_one).map(|(base, _)| (*base, coefficient.clone()));
        let coefficient = if divided.is_some() { &Number::ONE } else { coefficient };
        factors.order_by_key(|(base, _)| match self.factor_order(*base) {
            (2, _) if divided.as_ref().is_some_and(|own| own.0 == *base) => (2, usize::MAX),
            order => order,
        });
        let (coefficient, mut under_root) = match self.roots_together(coefficient, &mut factors) {
            Some((coefficient, joined)) => (coefficient, Some(joined)),
            None => self.joined_root(coefficient, &mut factors),
        };
        let coefficient = &coefficient;
        let mut above: Vec<Vec<Piece>> = Vec::new();
        let mut below: Vec<Vec<Piece>> = Vec::new();
        let mut only_numbers = true;
        // pi*j/12: as angles are written.
        let has_pi = factors.iter().any(|(base, e)| *base == PI && e.is_one());
        let is_angle = factors.len() > 1 && has_pi;
        for (base, exponent) in factors {
            only_numbers &= matches!(self.node(base), Node::Number(_));
            let magnitude = exponent.abs();
            let mut piece = Vec::new();
            if let Some((_, by)) = divided.clone().filter(|(own, _)| *own == base) {
                write_power(&magnitude, &mut piece, |place| Piece::Sum { id: base, negated: false, by, place });
            } else if negated == Some(base) {
                write_power(&magnitude, &mut piece, |place| Piece::Sum {
                    id: base,
                    negated: true,
                    by: Number::ONE,
                    place,
                });
            } else if let Some(joined) = under_root.take_if(|joined| joined.base == base && !exponent.is_integer()) {
                write_root(&magnitude, vec![joined.inner], &mut piece);
                let side = if joined.above { &mut above } else { &mut below };
                side.push(piece);
                continue;
            } else if let (true, Some(inverse)) = (exponent.is_negative(), self.inverted(base)) {
                // (x/y)^(-1/2) reads better as sqrt(y/x).
                let sign = inverse.has_minus.then_some(Piece::Text("-"));
                let inner = sign.into_iter().chain([inverse.times(Number::ONE)]).collect();
                write_root(&magnitude, inner, &mut piece);
                above.push(piece);
                continue;
            } else {
                write_power(&magnitude, &mut piece, |place| Piece::Expression(base, place));
            }
            if exponent.is_negative() { below.push(piece) } else { above.push(piece) }
        }
        let whole = Number::from_integer(coefficient.numerator());
        let divisor = Number::from_integer(coefficient.denominator().into());
        // 1/2*k, but sqrt(2)/2 and 1/(2*k); 0.1*k, but 1/10*pi.
        let decimal = decimal_text(coefficient).filter(|_| !has_pi);
        if !is_angle && (decimal.is_some() || (!above.is_empty() && !only_numbers)) {
            if !coefficient.is_one() || above.is_empty() {
                above.insert(0, vec![Piece::Owned(decimal.unwrap_or_else(|| coefficient.to_string()))]);
            }
        } else {
            if !whole.is_one() || above.is_empty() {
                above.insert(0, vec![Piece::Owned(whole.to_string())]);
            }
            if !divisor.is_one() {
                below.insert(0, vec![Piece::Owned(divisor.to_string())]);
            }
        }
        write_joined(above, out);
        if !below.is_empty() {
            out.push(Piece::Text("/"));
            in_parentheses(below.len() > 1, out, |out| write_joined(below, out));
        }
    }

    /// `sqrt(2)/(2*sqrt(m))` is written `1/sqrt(2*m)`, and `sqrt(2)*sqrt(a/b)/2` as `sqrt(a/(2*b))`: what is left of the
    /// coefficient, and the factor that takes up the number below its root, with what stands there then.
    fn joined_root(&self, coefficient: &Number, factors: &mut Factors) -> (Number, Option<Joined>) {
        let half = Number::half();
        let whole =
            factors.iter().position(|(base, e)| *e == half && self.as_number(*base).is_some_and(Number::is_integer));
        let root = factors.iter().filter(|(base, e)| e.abs() == half && self.as_number(*base).is_none());
        let below = root.clone().find(|(_, e)| e.is_negative());
        let root = below.or_else(|| root.clone().next());
        if let (Some(at), Some((base, exponent))) = (whole, root)
            && let Some(number) = self.as_number(factors[at].0).cloned()
        {
            let (base, below) = (*base, exponent.is_negative());
            let rest = coefficient.mul(&number);
            // Only where the number goes away above.
            let divisor = Number::from_integer(coefficient.denominator().into());
            let left = Number::from_integer(rest.denominator().into());
            if left.mul(&number) == divisor {
                let divided = (factors[at].0, Number::MINUS_ONE);
                factors.remove(at);
                let inverse = if below { self.inverted(base).filter(|own| !own.has_minus) } else { None };
                let above = !below || inverse.is_some();
                let as_it_is = || Inverse { factors: self.factors(base), negated: None, has_minus: false };
                let mut inner = inverse.unwrap_or_else(as_it_is);
                if above {
                    inner.factors.push(divided);
                }
                let inner = inner.times(if above { Number::ONE } else { number });
                return (rest, Some(Joined { base, above, inner }));
            }
        }
        (coefficient.clone(), None)
    }

    /// `sqrt(a)*sqrt(b)/sqrt(c)` of what is not negative is written `sqrt(a*b/c)`, with a number that has a root as well,
    /// and `a^(3/2)` as `a` and a root of it: what is left of the coefficient, and the root, for which its last factor
    /// stands.
    fn roots_together(&self, coefficient: &Number, factors: &mut Factors) -> Option<(Number, Joined)> {
        let half = Number::half();
        let is_root = |(base, e): &(ExprId, Number)| {
            let is_short = e.abs() == half || matches!(self.node(*base), Node::Symbol(_));
            is_short && e.sub(&half).is_integer() && self.as_number(*base).is_none() && self.is_nonnegative(*base)
        };
        if factors.iter().filter(|own| is_root(own)).count() < 2 {
            return None;
        }
        let (roots, mut rest): (Factors, Factors) = std::mem::take(factors).into_iter().partition(is_root);
        let mut above = roots.iter().any(|(_, e)| !e.is_negative());
        let mut coefficient = coefficient.clone();
        let is_whole =
            |(base, e): &(ExprId, Number)| *e == half && self.as_number(*base).is_some_and(Number::is_integer);
        let mut inner = Factors::new();
        if let Some(at) = rest.iter().position(is_whole) {
            let (base, _) = rest.remove(at);
            let number = self.as_number(base).cloned().unwrap_or_default();
            let divided = coefficient.mul(&number);
            // As in `joined_root`.
            let [left, divisor] = [&divided, &coefficient].map(|own| Number::from_integer(own.denominator().into()));
            let goes_below = left.mul(&number) == divisor;
            above |= !goes_below;
            coefficient = if goes_below { divided } else { coefficient };
            inner.push((base, if goes_below && above { Number::MINUS_ONE } else { Number::ONE }));
        }
        let (base, _) = *roots.last()?;
        for (base, e) in roots {
            let side = if e.is_negative() { half.neg() } else { half.clone() };
            inner.push((base, if e.is_negative() && above { Number::MINUS_ONE } else { Number::ONE }));
            rest.push((base, e.sub(&side)));
        }
        rest.retain(|(_, e)| !e.is_zero());
        rest.order_by_key(|(base, _)| self.factor_order(*base));
        let functions = rest.iter().position(|(base, _)| self.factor_order(*base).0 == 3).unwrap_or(rest.len());
        rest.insert(functions, (base, half));
        *factors = rest;
        Some((
            coefficient,
            Joined { base, above, inner: Piece::Term { coefficient: Number::ONE, factors: inner, negated: None } },
        ))
    }

    /// The inverse of a product that has factors below the fraction bar, or of minus it.
    fn inverted(&self, base: ExprId) -> Option<Inverse> {
        let opposite = match self.node(base) {
            Node::Sum { constant, terms } if constant.is_zero() => match &**terms {
                [(term, coefficient)] if *coefficient == Number::MINUS_ONE => Some(*term),
                _ => None,
            },
            _ => None,
        };
        let Node::Product(factors) = self.node(opposite.unwrap_or(base)) else { return None };
        let inverse: Factors = factors.iter().map(|(b, e)| (*b, e.neg())).collect();
        let negated = opposite.and_then(|_| self.reversible_factor(&inverse));
        let has_minus = opposite.is_some() && negated.is_none();
        // A root of minus what is not negative has no value, and is kept as it was made.
        let may_be_negative = || factors.iter().any(|(b, e)| !self.is_nonnegative_power(*b, e));
        let is_quotient = factors.iter().any(|(_, e)| e.is_negative()) && (!has_minus || may_be_negative());
        is_quotient.then_some(Inverse { factors: inverse, negated, has_minus })
    }
}

/// A product, or minus it, where a difference that takes up the sign is negated or there is a minus sign in front.
struct Inverse {
    factors: Factors,
    negated: Option<ExprId>,
    has_minus: bool,
}

impl Inverse {
    fn times(self, coefficient: Number) -> Piece {
        Piece::Term { coefficient, factors: self.factors, negated: self.negated }
    }
}

fn in_parentheses(wanted: bool, out: &mut Vec<Piece>, inner: impl FnOnce(&mut Vec<Piece>)) {
    if wanted {
        out.push(Piece::Text("("));
    }
    inner(out);
    if wanted {
        out.push(Piece::Text(")"));
    }
}

fn write_joined(factors: Vec<Vec<Piece>>, out: &mut Vec<Piece>) {
    for (at, factor) in factors.into_iter().enumerate() {
        if at > 0 {
            out.push(Piece::Text("*"));
        }
        out.extend(factor);
    }
}

/// `base^exponent` for a positive exponent.
fn write_power(exponent: &Number, out: &mut Vec<Piece>, base: impl FnOnce(Place) -> Piece) {
    if exponent.is_one() {
        out.push(base(Place::Factor));
    } else if *exponent == Number::half() {
        out.extend([Piece::Text("sqrt("), base(Place::Open), Piece::Text(")")]);
    } else {
        out.push(base(Place::Power));
        write_exponent(exponent, out);
    }
}

/// A root of what is written already.
fn write_root(exponent: &Number, base: Vec<Piece>, out: &mut Vec<Piece>) {
    let root = *exponent == Number::half();
    out.push(Piece::Text(if root { "sqrt(" } else { "(" }));
    out.extend(base);
    out.push(Piece::Text(")"));
    if !root {
        write_exponent(exponent, out);
    }
}

fn write_exponent(exponent: &Number, out: &mut Vec<Piece>) {
    out.push(Piece::Text("^"));
    in_parentheses(!exponent.is_integer(), out, |out| out.push(Piece::Owned(exponent.to_string())));
}

/// The number as a person writes it: `3/4`, but `9.81`.
fn number_text(value: &Number) -> String {
    decimal_text(value).unwrap_or_else(|| value.to_string())
}

/// A short finite decimal, for fractions whose denominator is a multiple of 10.
fn decimal_text(value: &Number) -> Option<String> {
    const MAX_PLACES: u32 = 12;
    let (numerator, denominator) = value.small_parts()?;
    if !denominator.is_multiple_of(10) {
        return None;
    }
    let places = (1..=MAX_PLACES).find(|k| 10u64.pow(*k).is_multiple_of(denominator))?;
    let unit = 10u64.pow(places);
    let scaled = u128::from(numerator.unsigned_abs()) * u128::from(unit / denominator);
    let (whole, fraction) = (scaled / u128::from(unit), scaled % u128::from(unit));
    let sign = if numerator < 0 { "-" } else { "" };
    Some(format!("{sign}{whole}.{fraction:0width$}", width = places as usize))
}
