//! Elements whose gradients contain each other: the prefix sums of a chain of links.
//!
//! Where ∇s_1 ⊂ ∇s_2 ⊂ … share their entries, as the same expressions, each is the sum of what those up to it add: ∇s_e = Σ_{f<=e} δ_f, and
//!
//! ```text
//!   Σ_e k_e ∇s_e∇s_eᵀ = Σ_{f,g} δ_f δ_gᵀ Σ_{e>=max(f,g)} k_e
//! ```
//!
//! so that n elements of up to n entries take n² products instead of n³, of which none cancels more than before.

use super::elements::Element;
use crate::expr::ExprId;
use crate::order::Order;
use crate::precision::Scalar;

/// Shorter gradients stand alone: their products are few.
const LEAST: usize = 16;

/// An element of a nest.
#[derive(Clone, Debug)]
struct Member {
    element: usize,
    /// Where the numbers of w·phi' and w·phi'' are.
    start: usize,
    /// The entries of ∇s that those before it don't have: which they are, and where their numbers are.
    added: Vec<(usize, usize)>,
    /// Where the numbers of ∇∇s start.
    bends: usize,
}

impl Member {
    /// The entries that it adds: places and numbers.
    fn added<'a, S>(&'a self, elements: &'a [Element], numbers: &'a [S]) -> impl Iterator<Item = (usize, &'a S)> {
        let slope = &elements[self.element].slope;
        self.added.iter().map(|(k, number)| (slope[*k].0, &numbers[*number]))
    }
}

/// Elements each of whose gradients has all entries of those before it.
#[derive(Clone, Debug)]
pub(super) struct Nest {
    members: Vec<Member>,
}

impl Nest {
    /// How many shares there are at most.
    pub(super) fn count(&self, elements: &[Element]) -> u64 {
        let (mut before, mut count) = (0, 0);
        for Member { element, added, .. } in &self.members {
            let added = added.len() as u64;
            count += added * (added + 1) / 2 + added * before + elements[*element].curvature.len() as u64;
            before += added;
        }
        count
    }

    /// What its elements add to a second derivative, from the numbers of all: two places, a share, and whether it stands for both
    /// (a, b) and (b, a).
    pub(super) fn shares<S: Scalar>(
        &self,
        elements: &[Element],
        numbers: &[S],
        mut share: impl FnMut(usize, usize, &S, bool),
    ) {
        let added = |member| Member::added(member, elements, numbers);
        let mut sum: Option<S> = None;
        for (at, last) in self.members.iter().enumerate().rev() {
            let own = &numbers[last.start + 1];
            let weight = sum.take().map_or_else(|| own.clone(), |sum| sum.add(own));
            if !weight.is_exact_zero() {
                for (k, (a, slope)) in added(last).enumerate() {
                    if slope.is_exact_zero() {
                        continue;
                    }
                    let row = weight.mul(slope);
                    let among = added(last).enumerate().skip(k).map(|(l, own)| (own, k != l));
                    let before = self.members[..at].iter().flat_map(added).map(|own| (own, true));
                    for ((b, other), both) in among.chain(before).filter(|((_, other), _)| !other.is_exact_zero()) {
                        share(a, b, &row.mul(other), both);
                    }
                }
            }
            sum = Some(weight);
        }
        for member in &self.members {
            let element = &elements[member.element];
            let first = &numbers[member.start];
            if !first.is_exact_zero() {
                for ((a, b, _), bend) in element.curvature.iter().zip(&numbers[member.bends..]) {
                    share(*a, *b, &first.mul(bend), a != b);
                }
            }
        }
    }
}

/// Leaves out the numbers that members share: gives those that are left, in the order in which [`Nest::shares`] wants them from now on.
pub(super) fn compact(nests: &mut [Nest], elements: &[Element]) -> Vec<ExprId> {
    let mut numbers = Vec::new();
    for member in nests.iter_mut().flat_map(|nest| &mut nest.members) {
        let element = &elements[member.element];
        member.start = numbers.len();
        numbers.extend([element.first, element.second]);
        for (k, number) in &mut member.added {
            *number = numbers.len();
            numbers.push(element.slope[*k].1);
        }
        member.bends = numbers.len();
        numbers.extend(element.curvature.iter().map(|(.., entry)| *entry));
    }
    numbers
}

/// Puts elements into nests, in the order of the first of each; numbers are in the order of [`Element::entries`].
pub(super) fn nests(elements: &[Element]) -> Vec<Nest> {
    let sizes = elements.iter().map(|element| 2 + element.slope.len() + element.curvature.len());
    let starts: Vec<usize> = sizes.scan(0, |start, size| Some(std::mem::replace(start, *start + size))).collect();
    let member = |element: usize, added: Vec<usize>| {
        let start = starts[element];
        let added = added.into_iter().map(|k| (k, start + 2 + k)).collect();
        Member { element, start, added, bends: start + 2 + elements[element].slope.len() }
    };
    let alone = |element: usize| Nest { members: vec![member(element, (0..elements[element].slope.len()).collect())] };
    let (mut long, short): (Vec<usize>, Vec<usize>) =
        (0..elements.len()).partition(|number| elements[*number].slope.len() >= LEAST);
    let mut nests: Vec<Nest> = short.into_iter().map(alone).collect();
    long.order_by_key(|number| elements[*number].slope.len());
    let mut grown: Vec<Nest> = Vec::new();
    for number in long {
        let fitting = grown.iter_mut().rev().find_map(|nest| {
            let last = nest.members.last()?.element;
            Some((added(&elements[last], &elements[number])?, nest))
        });
        match fitting {
            Some((added, nest)) => nest.members.push(member(number, added)),
            None => grown.push(alone(number)),
        }
    }
    nests.extend(grown);
    nests.order_by_key(|nest| nest.members.iter().map(|member| member.element).min());
    nests
}

/// Where the entries of ∇s stand that another element doesn't have; `None` unless it shares all of its own.
fn added(before: &Element, element: &Element) -> Option<Vec<usize>> {
    // Both are sorted by their places.
    let mut own = before.slope.iter().peekable();
    let mut added = Vec::new();
    for (at, entry) in element.slope.iter().enumerate() {
        match own.peek() {
            Some(next) if *next == entry => _ = own.next(),
            Some((place, _)) if *place <= entry.0 => return None,
            Some(_) | None => added.push(at),
        }
    }
    own.peek().is_none().then_some(added)
}
