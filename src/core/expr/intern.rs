//! The table from the contents of a node to its id.
//!
//! Open addressing with linear probing; a slot holds the hash and the id, never the node, which
//! is compared in the arena. The hash has no random seed: ids depend on the order of construction
//! alone.

use std::hash::{Hash, Hasher};

use super::{ExprId, Node};
use crate::number::Number;

/// The memory that a node takes in a pool, with its place in the table.
pub(super) fn bytes(node: &Node) -> usize {
    const SLOTS: usize = 4 * size_of::<(u32, u32)>();
    let mut more = 0;
    if let Node::Sum { terms: parts, .. } | Node::Product(parts) = node {
        more += size_of_val(&**parts);
    }
    node.for_each_number(|number| more += number.bytes());
    size_of::<Node>() + SLOTS + more
}

/// A multiplicative hash, as fast as a small node asks for.
#[derive(Default)]
pub(super) struct NodeHasher(u64);

const MULTIPLIER: u64 = 0xf135_7aea_2e62_a9c5;

impl Hasher for NodeHasher {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, value: u32) {
        self.write_u64(u64::from(value));
    }

    fn write_u64(&mut self, value: u64) {
        self.0 = (self.0.rotate_left(5) ^ value).wrapping_mul(MULTIPLIER);
    }

    fn write_usize(&mut self, value: usize) {
        self.write_u64(value as u64);
    }

    fn finish(&self) -> u64 {
        // The low bits of a product depend on the low bits of its factors only: fold.
        let product = u128::from(self.0) * u128::from(MULTIPLIER);
        product as u64 ^ (product >> 64) as u64
    }
}

fn finish(parts: impl Hash) -> u32 {
    let mut hasher = NodeHasher::default();
    parts.hash(&mut hasher);
    hasher.finish() as u32
}

/// The hash of a product.
pub(super) fn hash_of_product(factors: &[(ExprId, Number)]) -> u32 {
    finish((2_u32, factors))
}

/// The hash of a node.
pub(super) fn hash(node: &Node) -> u32 {
    match node {
        Node::Sum { constant, terms } => finish((1_u32, constant, terms)),
        Node::Product(factors) => hash_of_product(factors),
        Node::Number(value) => finish(value),
        Node::Pi => finish(3_u32),
        Node::Undefined => finish(4_u32),
        Node::Symbol(symbol) => finish((5_u32, symbol)),
        Node::Power { base, exponent } => finish((6_u32, base, exponent)),
        Node::Function(function, x) => finish((7_u32, function, x)),
        Node::Atan2 { y, x } => finish((8_u32, y, x)),
    }
}

const EMPTY: u32 = u32::MAX;

/// From hashes to ids.
#[derive(Clone, Debug, Default)]
pub(super) struct IdTable {
    /// (hash, id), with id [`EMPTY`] where the slot is free; a power of two of them.
    slots: Vec<(u32, u32)>,
    used: usize,
}

impl IdTable {
    /// The id with this hash for which `is_same` holds.
    pub(super) fn find(&self, hash: u32, is_same: impl Fn(u32) -> bool) -> Option<u32> {
        let mask = self.slots.len().wrapping_sub(1);
        let mut at = hash as usize & mask;
        // At most three quarters of the slots are in use: a free one ends the search.
        loop {
            let (slot_hash, id) = *self.slots.get(at)?;
            if id == EMPTY {
                return None;
            }
            if slot_hash == hash && is_same(id) {
                return Some(id);
            }
            at = (at + 1) & mask;
        }
    }

    /// Enters an id that is not there yet.
    pub(super) fn insert(&mut self, hash: u32, id: u32) {
        if self.used * 4 >= self.slots.len() * 3 {
            let size = (self.slots.len() * 2).max(64);
            let old = std::mem::replace(&mut self.slots, vec![(0, EMPTY); size]);
            old.into_iter().filter(|(_, id)| *id != EMPTY).for_each(|(hash, id)| self.place(hash, id));
        }
        self.place(hash, id);
        self.used += 1;
    }

    fn place(&mut self, hash: u32, id: u32) {
        let mask = self.slots.len() - 1;
        let mut at = hash as usize & mask;
        while self.slots[at].1 != EMPTY {
            at = (at + 1) & mask;
        }
        self.slots[at] = (hash, id);
    }
}
