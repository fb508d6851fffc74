//! Replacing symbols by expressions.

use super::{ExprId, Node, Pool, Substitution};

impl Pool {
    /// The roots with their symbols replaced, all at once, and simplified anew.
    pub fn substitute(&mut self, roots: &[ExprId], map: &Substitution) -> Vec<ExprId> {
        let reachable = self.reachable_places(roots);
        let dependent = self.dependent(&reachable, |symbol| map.contains_key(&symbol));
        if !dependent.contains(&true) {
            return roots.to_vec();
        }
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
                    self.apply(function, x)
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
