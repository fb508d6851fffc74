//! Replacing symbols by expressions, and absolute values by signs.

use super::traverse::Reachable;
use super::{ExprId, Function, Node, Pool, Substitution, Symbol};

impl Pool {
    /// The roots with their symbols replaced, all at once, and simplified anew.
    pub fn substitute(&mut self, roots: &[ExprId], map: &Substitution) -> Vec<ExprId> {
        let reachable = self.reachable_places(roots);
        let dependent = self.dependent(&reachable, |symbol| map.contains_key(&symbol));
        if !dependent.contains(&true) {
            return roots.to_vec();
        }
        self.rebuilt(roots, &reachable, &dependent, map, &mut |_, _| None)
    }

    /// The roots with each absolute value |x| of something that depends on a wanted symbol written s x, and all these x with
    /// their s: where s is the sign of x, they are what they were. An x has no other such absolute value in it.
    pub fn with_signs(
        &mut self,
        roots: &[ExprId],
        is_wanted: impl Fn(Symbol) -> bool,
    ) -> (Vec<ExprId>, Vec<(ExprId, Symbol)>) {
        let reachable = self.reachable_places(roots);
        let dependent = self.dependent(&reachable, is_wanted);
        let mut signs: Vec<(ExprId, Symbol)> = Vec::new();
        let mut signed = |pool: &mut Self, x: ExprId| {
            let known = signs.iter().find(|known| known.0 == x);
            let sign = known.map(|known| known.1).unwrap_or_else(|| {
                let sign = pool.fresh_symbol("sign");
                signs.push((x, sign));
                sign
            });
            let sign = pool.symbol_expr(sign);
            Some(pool.mul(sign, x))
        };
        let none = Substitution::default();
        let roots = self.rebuilt(roots, &reachable, &dependent, &none, &mut signed);
        (roots, signs)
    }

    /// The roots built anew from what replaces their symbols, and their absolute values where `signed` gives something.
    fn rebuilt(
        &mut self,
        roots: &[ExprId],
        reachable: &Reachable,
        dependent: &[bool],
        map: &Substitution,
        signed: &mut impl FnMut(&mut Self, ExprId) -> Option<ExprId>,
    ) -> Vec<ExprId> {
        let mut images: Vec<ExprId> = Vec::with_capacity(reachable.ids.len());
        let mut parts = Vec::new();
        for (place, id) in reachable.ids.iter().enumerate() {
            if !dependent[place] {
                images.push(*id);
                continue;
            }
            let image = |child: ExprId| images[reachable.place(child)];
            let new = match self.node(*id) {
                Node::Number(_) | Node::Pi | Node::Undefined => *id,
                Node::Symbol(symbol) => map.get(symbol).copied().unwrap_or(*id),
                Node::Sum { constant, terms } => {
                    parts.clear();
                    parts.extend(terms.iter().map(|(term, c)| (image(*term), c.clone())));
                    let constant = constant.clone();
                    let constant = self.number(constant);
                    parts.push((constant, crate::number::Number::ONE));
                    self.linear(&parts)
                }
                Node::Product(factors) => {
                    parts.clear();
                    parts.extend(factors.iter().map(|(base, e)| (image(*base), e.clone())));
                    self.product_of_powers(&parts)
                }
                Node::Power { base, exponent } => {
                    let (base, exponent) = (image(*base), image(*exponent));
                    self.power(base, exponent)
                }
                Node::Function(function, x) => {
                    let (function, x) = (*function, image(*x));
                    let signed = (function == Function::Abs).then(|| signed(self, x));
                    match signed.flatten() {
                        Some(signed) => signed,
                        None => self.apply(function, x),
                    }
                }
                Node::Atan2 { y, x } => {
                    let (y, x) = (image(*y), image(*x));
                    self.atan2(y, x)
                }
            };
            images.push(new);
        }
        roots
            .iter()
            .map(|root| images[reachable.place(*root)])
            .collect()
    }

    /// One expression with its symbols replaced.
    pub fn substitute_one(&mut self, root: ExprId, map: &Substitution) -> ExprId {
        self.substitute(&[root], map)
            .first()
            .copied()
            .unwrap_or(root)
    }
}
