//! Replacing symbols by expressions, and absolute values by signs.

use hashbrown::HashMap;

use super::{ExprId, Function, Node, Pool, Substitution, Symbol, Tape};
use crate::number::Number;

/// From this power of two on an exponential is large.
const LARGE: f64 = 200.0;

impl Pool {
    /// The roots with their symbols replaced, all at once, and simplified anew.
    pub fn substitute(&mut self, roots: &[ExprId], map: &Substitution) -> Vec<ExprId> {
        self.rebuilt(roots, Some(&|symbol| map.contains_key(&symbol)), map, &mut |_, _, _| None)
    }

    /// The roots with each absolute value |x| of something that depends on a wanted symbol written s x, and all these x with
    /// their s: where s is the sign of x, they are what they were. An x has no other such absolute value in it.
    pub fn with_signs(
        &mut self,
        roots: &[ExprId],
        is_wanted: impl Fn(Symbol) -> bool,
    ) -> (Vec<ExprId>, Vec<(ExprId, Symbol)>) {
        let mut signs: Vec<(ExprId, Symbol)> = Vec::new();
        let mut signed = |pool: &mut Self, function: Function, x: ExprId| {
            if function != Function::Abs {
                return None;
            }
            let known = signs.iter().find(|known| known.0 == x);
            let sign = known.map(|known| known.1).unwrap_or_else(|| {
                let sign = pool.fresh_symbol("sign");
                signs.push((x, sign));
                sign
            });
            Some(pool.times(x, sign))
        };
        let roots = self.rebuilt(roots, Some(&is_wanted), &Substitution::default(), &mut signed);
        (roots, signs)
    }

    /// The same, simplified anew by what is assumed since they were made.
    pub(crate) fn built_anew(&mut self, roots: &[ExprId]) -> Vec<ExprId> {
        self.rebuilt(roots, None, &Substitution::default(), &mut |_, _, _| None)
    }

    /// The same with exp(c) for a large constant c as 2^n exp(c - n ln 2) where that is about 1: products with numbers are then within the
    /// range of doubles on their way.
    pub fn with_small_exponentials(&mut self, roots: &[ExprId]) -> Vec<ExprId> {
        let mut smaller = |pool: &mut Self, function: Function, x: ExprId| {
            if function != Function::Exp || !pool.is_constant(x) {
                return None;
            }
            let tape = Tape::compile(pool, &[x], &[]).ok()?;
            let value = *tape.evaluate::<f64>(&[], &mut Vec::new()).first()?;
            let power = (value / std::f64::consts::LN_2).round();
            if !(LARGE..LARGE * 1000.0).contains(&power.abs()) {
                return None;
            }
            let by = Number::from(power as i64);
            let two = pool.integer(2);
            let (log, factor) = (pool.apply(Function::Ln, two), pool.powr(two, &by));
            let rest = pool.linear(&[(x, Number::ONE), (log, by.neg())]);
            let rest = pool.apply(Function::Exp, rest);
            Some(pool.mul(factor, rest))
        };
        self.rebuilt(roots, None, &Substitution::default(), &mut smaller)
    }

    /// The roots with some of their parts replaced, all at once, and what these are in simplified anew.
    pub fn replaced(&mut self, roots: &[ExprId], parts: &HashMap<ExprId, ExprId>) -> Vec<ExprId> {
        let reachable = self.reachable_places(roots);
        let mut images: Vec<ExprId> = Vec::with_capacity(reachable.ids.len());
        for id in &reachable.ids {
            let image = |child: ExprId| images[reachable.place(child)];
            images.push(parts.get(id).copied().unwrap_or_else(|| self.rebuilt_from(*id, image)));
        }
        roots.iter().map(|root| images[reachable.place(*root)]).collect()
    }

    /// The roots built anew from what replaces their symbols, and their functions where `replaced` gives something: all that a
    /// wanted symbol occurs in, or all.
    fn rebuilt(
        &mut self,
        roots: &[ExprId],
        is_wanted: Option<&dyn Fn(Symbol) -> bool>,
        map: &Substitution,
        replaced: &mut impl FnMut(&mut Self, Function, ExprId) -> Option<ExprId>,
    ) -> Vec<ExprId> {
        let reachable = self.reachable_places(roots);
        let dependent = match is_wanted {
            Some(is_wanted) => self.dependent(&reachable, is_wanted),
            None => vec![true; reachable.ids.len()],
        };
        if !dependent.contains(&true) {
            return roots.to_vec();
        }
        let mut images: Vec<ExprId> = Vec::with_capacity(reachable.ids.len());
        for (place, id) in reachable.ids.iter().enumerate() {
            if !dependent[place] {
                images.push(*id);
                continue;
            }
            let image = |child: ExprId| images[reachable.place(child)];
            let symbol = self.as_symbol(*id).and_then(|symbol| map.get(&symbol).copied());
            let new = match self.as_function(*id) {
                Some((function, x)) => replaced(self, function, image(x)),
                None => symbol,
            };
            let new = new.unwrap_or_else(|| self.with_children(*id, image));
            images.push(new);
        }
        roots.iter().map(|root| images[reachable.place(*root)]).collect()
    }

    /// The expression built anew from the images of its children, if these are not the children themselves.
    pub(crate) fn rebuilt_from(&mut self, id: ExprId, image: impl Fn(ExprId) -> ExprId) -> ExprId {
        let mut changed = false;
        self.node(id).for_each_child(|child| changed |= image(child) != child);
        if changed { self.with_children(id, image) } else { id }
    }

    /// The expression built anew from the images of its children.
    fn with_children(&mut self, id: ExprId, image: impl Fn(ExprId) -> ExprId) -> ExprId {
        let node = self.node(id).clone();
        self.built(node, image).unwrap_or(id)
    }

    /// An expression without symbols of another pool.
    pub fn adopted(&mut self, pool: &Self, e: ExprId) -> ExprId {
        let reachable = pool.reachable_places(&[e]);
        let mut images: Vec<ExprId> = Vec::with_capacity(reachable.ids.len());
        for id in &reachable.ids {
            let new = match pool.node(*id) {
                Node::Number(number) => self.number(number.clone()),
                Node::Pi => self.pi(),
                node => self.built(node.clone(), |child| images[reachable.place(child)]).unwrap_or(self.undefined()),
            };
            images.push(new);
        }
        images[reachable.place(e)]
    }

    /// What has children, of their images.
    fn built(&mut self, node: Node, image: impl Fn(ExprId) -> ExprId) -> Option<ExprId> {
        let images = |parts: Box<[(ExprId, Number)]>| parts.into_iter().map(|(part, x)| (image(part), x));
        Some(match node {
            Node::Number(_) | Node::Pi | Node::Symbol(_) | Node::Undefined => return None,
            Node::Sum { constant, terms } => {
                let constant = self.number(constant);
                let parts: Vec<_> = images(terms).chain([(constant, Number::ONE)]).collect();
                self.linear(&parts)
            }
            Node::Product(factors) => {
                let parts: Vec<_> = images(factors).collect();
                self.product_of_powers(&parts)
            }
            Node::Power { base, exponent } => self.power(image(base), image(exponent)),
            Node::Function(function, x) => self.apply(function, image(x)),
            Node::Atan2 { y, x } => self.atan2(image(y), image(x)),
        })
    }

    /// One expression with its symbols replaced.
    pub fn substitute_one(&mut self, root: ExprId, map: &Substitution) -> ExprId {
        self.substitute(&[root], map).first().copied().unwrap_or(root)
    }
}
