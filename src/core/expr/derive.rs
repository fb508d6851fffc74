//! Derivatives: forward for one direction, reverse for gradients.

use super::{ExprId, Function, Node, ONE, Pool, Seeds, Symbol, UNDEFINED, ZERO};
use crate::number::Number;
use crate::order::Order;

/// Derivatives along seeds that stay the same, kept from one call of `Pool::derivative` to the
/// next. For one pool only.
#[derive(Clone, Debug, Default)]
pub struct Derivatives {
    /// By expression; [`UNKNOWN`] where it has not been needed.
    known: Vec<ExprId>,
    /// What has been begun and not finished, the innermost last.
    open: Vec<ExprId>,
}

/// No expression has this number: the memory for so many does not exist.
const UNKNOWN: ExprId = ExprId(u32::MAX);

impl Derivatives {
    /// Sets the derivative of a symbol.
    pub(crate) fn set(&mut self, pool: &mut Pool, symbol: Symbol, seed: ExprId) {
        let symbol = pool.symbol_expr(symbol);
        self.put(symbol, seed);
    }

    fn get(&self, id: ExprId) -> Option<ExprId> {
        let derivative = self.known.get(id.index()).copied();
        derivative.filter(|derivative| *derivative != UNKNOWN)
    }

    fn put(&mut self, id: ExprId, derivative: ExprId) {
        if self.known.len() <= id.index() {
            self.known.resize(id.index() + 1, UNKNOWN);
        }
        self.known[id.index()] = derivative;
    }
}

impl Pool {
    /// The derivative of each root along the seeds: the sum over the seeded symbols of the
    /// derivative of the root by the symbol, times the seed. (With velocities as seeds, the total
    /// time derivative.)
    pub fn derivation(&mut self, roots: &[ExprId], seeds: &Seeds) -> Vec<ExprId> {
        let reachable = self.reachable_places(roots);
        let dependent = self.dependent(&reachable, |symbol| seeds.contains_key(&symbol));
        let mut derivatives = vec![ZERO; reachable.ids.len()];
        for (place, id) in reachable.ids.iter().enumerate() {
            if *id == UNDEFINED {
                derivatives[place] = UNDEFINED;
            }
            if !dependent[place] {
                continue;
            }
            if let Node::Symbol(symbol) = self.node(*id) {
                derivatives[place] = seeds.get(symbol).copied().unwrap_or(ZERO);
                continue;
            }
            let mut terms = Vec::new();
            let depends = |child: ExprId| dependent[reachable.place(child)];
            for (child, factor, coefficient) in self.partials(*id, depends) {
                let inner = derivatives[reachable.place(child)];
                if inner != ZERO {
                    terms.push((self.mul(factor, inner), coefficient));
                }
            }
            derivatives[place] = self.linear(&terms);
        }
        roots.iter().map(|root| derivatives[reachable.place(*root)]).collect()
    }

    /// The partial derivative by a symbol.
    pub fn diff(&mut self, root: ExprId, symbol: Symbol) -> ExprId {
        let seeds = Seeds::from([(symbol, ONE)]);
        self.derivation(&[root], &seeds).first().copied().unwrap_or(ZERO)
    }

    /// The partial derivatives by each of the symbols, in one reverse sweep.
    pub fn gradient(&mut self, root: ExprId, symbols: &[Symbol]) -> Vec<ExprId> {
        if root == UNDEFINED {
            return vec![UNDEFINED; symbols.len()];
        }
        let mut wanted = symbols.to_vec();
        wanted.put_in_order();
        let slopes = self.slopes(root, |symbol| wanted.binary_search(&symbol).is_ok());
        let slope = |symbol: &Symbol| slopes.binary_search_by_key(symbol, |own| own.0).map_or(ZERO, |at| slopes[at].1);
        symbols.iter().map(slope).collect()
    }

    /// The partial derivatives by the wanted symbols that occur, in one reverse sweep: in order
    /// of creation of the symbols, without those that are 0. None of [`Pool::undefined`].
    pub fn slopes(&mut self, root: ExprId, is_wanted: impl Fn(Symbol) -> bool) -> Vec<(Symbol, ExprId)> {
        let reachable = self.reachable_places(&[root]);
        let dependent = self.dependent(&reachable, is_wanted);
        // What the root's derivative by each expression is the sum of.
        let mut parts: Vec<Vec<(ExprId, Number)>> = vec![Vec::new(); reachable.ids.len()];
        let mut slopes: Vec<(Symbol, ExprId)> = Vec::new();
        if let Some(last) = parts.last_mut() {
            last.push((ONE, Number::ONE));
        }
        for (place, id) in reachable.ids.iter().enumerate().rev() {
            if !dependent[place] {
                continue;
            }
            let adjoint = self.linear(&std::mem::take(&mut parts[place]));
            if adjoint == ZERO {
                continue;
            }
            if let Node::Symbol(symbol) = self.node(*id) {
                slopes.push((*symbol, adjoint));
                continue;
            }
            let depends = |child: ExprId| dependent[reachable.place(child)];
            for (child, factor, coefficient) in self.partials(*id, depends) {
                let place = reachable.place(child);
                let part = self.mul(adjoint, factor);
                let is_modulus = matches!(self.node(*id), Node::Function(Function::Abs, _));
                if !is_modulus || !self.divides_by(part, *id) {
                    parts[place].push((part, coefficient));
                    continue;
                }
                // Term by term, so that x/|x| cancels where a term allows it.
                for term in self.terms(adjoint) {
                    for (term, own) in self.multiplied_out(term, *id) {
                        let part = self.mul(term, factor);
                        parts[place].push((part, own.mul(&coefficient)));
                    }
                }
            }
        }
        slopes.put_in_order();
        slopes
    }

    /// A term with one factor multiplied out that is a sum with a modulus for a term, as x + |x|.
    fn multiplied_out(&mut self, (term, coefficient): (ExprId, Number), modulus: ExprId) -> Vec<(ExprId, Number)> {
        let mut factors = self.factors(term);
        let is_sum = |(base, exponent): &(ExprId, Number)| {
            exponent.is_integer() && !exponent.is_negative() && self.terms(*base).iter().any(|own| own.0 == modulus)
        };
        let Some(at) = factors.iter().position(is_sum).filter(|at| factors[*at].0 != modulus) else {
            return vec![(term, coefficient)];
        };
        let parts = self.terms(factors[at].0);
        factors[at].1 = factors[at].1.sub(&Number::ONE);
        let rest = self.product_of_powers(&factors);
        parts.into_iter().map(|(part, own)| (self.mul(part, rest), own.mul(&coefficient))).collect()
    }

    /// Whether a product, or a multiple of one, has a negative power of an expression.
    fn divides_by(&self, e: ExprId, divisor: ExprId) -> bool {
        let terms = self.terms(e);
        let [(term, _)] = terms.as_slice() else { return false };
        self.factors(*term).iter().any(|(base, power)| *base == divisor && power.is_negative())
    }

    /// The derivative of an expression along seeds that stay the same from call to call, so that
    /// nothing is derived twice.
    ///
    /// # Errors
    ///
    /// A symbol whose seed is not known yet: [`Derivatives::set`] it and call again.
    pub(crate) fn derivative(&mut self, known: &mut Derivatives, root: ExprId) -> Result<ExprId, Symbol> {
        if known.open.first() != Some(&root) {
            known.open.clear();
            known.open.push(root);
        }
        while let Some(id) = known.open.last().copied() {
            if known.get(id).is_some() {
                known.open.pop();
                continue;
            }
            let open = known.open.len();
            let node = self.node(id);
            if let Node::Symbol(symbol) = node {
                return Err(*symbol);
            }
            node.for_each_child(|child| {
                if known.get(child).is_none() {
                    known.open.push(child);
                }
            });
            if known.open.len() > open {
                // The first child is examined first.
                known.open[open..].reverse();
                continue;
            }
            let depends = |child: ExprId| known.get(child) != Some(ZERO);
            let mut varies = false;
            node.for_each_child(|child| varies |= depends(child));
            let derivative = if id == UNDEFINED {
                UNDEFINED
            } else if varies {
                let mut terms = Vec::new();
                for (child, factor, coefficient) in self.partials(id, depends) {
                    let inner = known.get(child).unwrap_or(ZERO);
                    terms.push((self.mul(factor, inner), coefficient));
                }
                self.linear(&terms)
            } else {
                ZERO
            };
            known.put(id, derivative);
            known.open.pop();
        }
        Ok(known.get(root).unwrap_or(ZERO))
    }

    /// The partial derivatives of a node by those of its children that matter, as `(child, factor, coefficient)` with the value `coefficient*factor`.
    fn partials(&mut self, id: ExprId, depends: impl Fn(ExprId) -> bool) -> Vec<(ExprId, ExprId, Number)> {
        match self.node(id) {
            Node::Number(_) | Node::Pi | Node::Symbol(_) | Node::Undefined => Vec::new(),
            Node::Sum { terms, .. } => terms
                .iter()
                .filter(|(term, _)| depends(*term))
                .map(|(term, coefficient)| (*term, ONE, coefficient.clone()))
                .collect(),
            Node::Product(factors) => {
                let factors = factors.to_vec();
                let mut partials = Vec::new();
                let mut changed = factors.clone();
                for (at, (base, exponent)) in factors.iter().enumerate() {
                    if depends(*base) {
                        changed[at].1 = exponent.sub(&Number::ONE);
                        let rest = self.product_of_powers(&changed);
                        changed[at].1 = exponent.clone();
                        partials.push((*base, rest, exponent.clone()));
                    }
                }
                partials
            }
            Node::Power { base, exponent } => {
                let (base, exponent) = (*base, *exponent);
                let mut partials = Vec::new();
                if depends(base) {
                    let quotient = self.div(id, base);
                    partials.push((base, self.mul(exponent, quotient), Number::ONE));
                }
                if depends(exponent) {
                    let logarithm = self.apply(Function::Ln, base);
                    partials.push((exponent, self.mul(id, logarithm), Number::ONE));
                }
                partials
            }
            Node::Function(function, x) => {
                let (function, x) = (*function, *x);
                let (factor, coefficient) = self.slope(function, x, id);
                vec![(x, factor, coefficient)]
            }
            Node::Atan2 { y, x } => {
                let (y, x) = (*y, *x);
                let (y2, x2) = (self.square(y), self.square(x));
                let r2 = self.add(y2, x2);
                let mut partials = Vec::new();
                if depends(y) {
                    partials.push((y, self.div(x, r2), Number::ONE));
                }
                if depends(x) {
                    partials.push((x, self.div(y, r2), Number::MINUS_ONE));
                }
                partials
            }
        }
    }

    /// The derivative of a function at x, where its value is `value`, as an expression and a
    /// numeric factor.
    fn slope(&mut self, function: Function, x: ExprId, value: ExprId) -> (ExprId, Number) {
        let one = Number::ONE;
        match function {
            Function::Sin => (self.apply(Function::Cos, x), one),
            Function::Cos => (self.apply(Function::Sin, x), Number::MINUS_ONE),
            // 1 + tan^2 and 1 - tanh^2 would cancel: 1/cos^2 and 1/cosh^2 do not.
            Function::Tan | Function::Tanh => {
                let cosine = if function == Function::Tan { Function::Cos } else { Function::Cosh };
                let cosine = self.apply(cosine, x);
                (self.powi(cosine, -2), one)
            }
            Function::Asin | Function::Acos => {
                let square = self.square(x);
                let leg = self.sub(ONE, square);
                let factor = self.powr(leg, &Number::half().neg());
                (factor, if function == Function::Acos { Number::MINUS_ONE } else { one })
            }
            Function::Atan => {
                let square = self.square(x);
                let hypotenuse = self.add(ONE, square);
                (self.powi(hypotenuse, -1), one)
            }
            Function::Sinh => (self.apply(Function::Cosh, x), one),
            Function::Cosh => (self.apply(Function::Sinh, x), one),
            Function::Exp => (value, one),
            Function::Ln => (self.powi(x, -1), one),
            Function::Abs => (self.div(x, value), one),
        }
    }
}
