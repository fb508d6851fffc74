//! Symbolic expressions: a hash-consed pool in which equal means same index.
//!
//! Expressions live in a [`Pool`] and are referred to by [`ExprId`]. They are made only by the
//! pool's constructors, which bring every expression to a canonical form ([`Node`] lists its
//! invariants), so that two expressions the simplifier knows to be equal have the same id.
//! Children have smaller ids than their parents: the ids are a topological order, and every pass
//! (derivatives, substitution, evaluation, printing) is a loop over ascending or descending ids
//! with a memo, never a recursion to the depth of the input.
//!
//! The constructors apply only what is always right for real arguments in the domain of the
//! expression; as any computer algebra does they cancel `x/x` and `sqrt(x)^2` without recording
//! that x is not 0 or not negative. Sums are never expanded: `(a + b)^2` stays a square.
//!
//! This module knows nothing of mechanics, of files and of places in them. It never fails:
//! what has no value (`1/0`, `ln(0)`, `acos(2)`) is [`Node::Undefined`], which spreads to
//! everything made of it.
//!
//! ```
//! use librate::expr::{Pool, Tape, ZeroVerdict};
//!
//! let mut pool = Pool::default();
//! let (x, k) = (pool.symbol("x"), pool.symbol("k"));
//! let (ex, ek) = (pool.symbol_expr(x), pool.symbol_expr(k));
//! let cosine = pool.cos(ex);
//! let one = pool.one();
//! let height = pool.sub(one, cosine);
//! let energy = pool.mul(ek, height);
//! assert_eq!(pool.display(energy), "k*(1 - cos(x))");
//! let force = pool.diff(energy, x);
//! assert_eq!(pool.display(force), "k*sin(x)");
//! let difference = pool.sub(force, energy);
//! assert_eq!(pool.is_zero(difference), ZeroVerdict::NonZero);
//! assert!(Tape::compile(&pool, &[force], &[x]).is_err()); // k has no value
//! ```

mod angle;
mod derive;
mod exponential;
mod flags;
mod function;
mod integral;
mod intern;
mod modular;
mod point;
mod print;
mod product;
mod series;
mod substitute;
mod sum;
mod tape;
mod traverse;
mod zero;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::panic::{RefUnwindSafe, UnwindSafe};
use std::sync::Arc;

use hashbrown::HashMap;

use crate::budget::{Budget, Held};
use crate::number::Number;

pub use crate::precision::Function;
pub(crate) use angle::ratio;
pub use derive::Derivatives;
pub use integral::Exponentials;
pub use modular::{
    PRIME, add_mod, fraction_mod, inverse_mod, mul_mod, neg_mod, pow_mod, rational_reconstruct, sqrt_mod, sub_mod,
};
pub(crate) use point::mix;
pub use point::{Certainty, ModularPoint};
pub use print::function_from_name;
pub use series::Series;
pub(crate) use sum::collect_equal;
pub use tape::{Prepared, Tape, UnboundSymbol, evaluate_closed};
pub use zero::ZeroVerdict;

use flags::Flags;
use intern::IdTable;

/// Index of an expression in its [`Pool`].
#[derive(Copy, Clone, Eq, PartialEq, Hash, Ord, PartialOrd, Debug)]
pub struct ExprId(u32);

impl ExprId {
    /// The place of the expression in its pool, for side tables.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }

    /// Whether the expression is the number 0.
    pub(crate) fn is_zero(self) -> bool {
        self == ZERO
    }
}

/// A variable of a [`Pool`].
#[derive(Copy, Clone, Eq, PartialEq, Hash, Ord, PartialOrd, Debug)]
pub struct Symbol(u32);

impl Symbol {
    /// How many symbols of the pool were created before this one.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }

    /// The symbol that was created so many after this one.
    pub(crate) fn after(self, count: usize) -> Symbol {
        Symbol(u32::try_from(self.index() + count).unwrap_or(u32::MAX))
    }
}

/// The names of symbols that are created together.
pub(crate) trait SymbolNames: Debug + Send + Sync + UnwindSafe + RefUnwindSafe {
    /// The name of the symbol in a place among them, from 0.
    fn name(&self, place: usize) -> String;
}

/// What the seeds of a derivation are given in: the derivative of each symbol.
pub type Seeds = BTreeMap<Symbol, ExprId>;

/// What replaces the symbols in a substitution.
pub type Substitution = BTreeMap<Symbol, ExprId>;

/// What an expression is made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Node {
    /// An exact number.
    Number(Number),
    /// The number pi.
    Pi,
    /// A variable.
    Symbol(Symbol),
    /// `constant + sum of coefficient*term`. Numeric coefficients stand nowhere else.
    ///
    /// Terms are neither sums nor numbers, distinct, in ascending order of id, their
    /// coefficients not 0. A lone term with coefficient 1 and constant 0 is not a sum.
    Sum {
        /// The term without a variable part.
        constant: Number,
        /// Terms with their coefficients.
        terms: Box<[(ExprId, Number)]>,
    },
    /// The product of `base^exponent`, without a numeric coefficient.
    ///
    /// Bases are distinct and in ascending order of id, exponents not 0. A product is a base
    /// only under an exponent that is not whole (or where it has more than 64 factors). A sum that is a base has coprime whole
    /// coefficients; under a whole exponent its leading one is positive (the constant, or where
    /// it is 0 the last term's). Number bases are whole, above 1, coprime and under exponents
    /// between 0 and 1, one base an exponent. A lone base with exponent 1 is not a product.
    Product(Box<[(ExprId, Number)]>),
    /// A power whose exponent is not a number; its base is positive where it has a value.
    Power {
        /// The base.
        base: ExprId,
        /// The exponent.
        exponent: ExprId,
    },
    /// A function of one argument.
    Function(Function, ExprId),
    /// The angle of the point (x, y) in (-pi, pi].
    Atan2 {
        /// The ordinate.
        y: ExprId,
        /// The abscissa.
        x: ExprId,
    },
    /// What has no value: a quotient by exactly 0, the logarithm of 0, a number beyond all
    /// bounds.
    Undefined,
}

/// What a symbol is called and the expression that consists of it.
#[derive(Clone, Debug)]
struct SymbolEntry {
    name: Box<str>,
    expression: ExprId,
}

/// Symbols that were created together, in a row: neither their names nor their expressions are made before they are
/// asked for.
#[derive(Clone, Debug)]
struct SymbolRow {
    first: usize,
    count: usize,
    names: Arc<dyn SymbolNames>,
}

/// An arena of expressions; see the [module](self).
///
/// Clones are independent: an id made before the clone means the same expression in both.
#[derive(Clone, Debug)]
pub struct Pool {
    nodes: Vec<Node>,
    flags: Vec<Flags>,
    table: IdTable,
    /// Those that are in no row.
    symbols: Vec<SymbolEntry>,
    rows: Vec<SymbolRow>,
    names: HashMap<Box<str>, Symbol>,
    /// Angles with exact sines and tangents, filled when first needed.
    known_angles: Vec<angle::KnownAngle>,
    /// The memory of the nodes.
    held: Held,
    /// A number has outgrown [`crate::number::MAX_BITS`].
    outgrown: bool,
}

/// The expressions every pool begins with.
pub(crate) const ZERO: ExprId = ExprId(0);
const ONE: ExprId = ExprId(1);
const UNDEFINED: ExprId = ExprId(2);
const PI: ExprId = ExprId(3);
const MINUS_ONE: ExprId = ExprId(4);

impl Default for Pool {
    fn default() -> Pool {
        Pool::within(Budget::default())
    }
}

impl Pool {
    /// A pool without symbols.
    #[must_use]
    pub fn new() -> Pool {
        Pool::default()
    }

    /// A pool without symbols that grows only within a budget: when that is spent, everything new is
    /// [`Node::Undefined`].
    pub(crate) fn within(budget: Budget) -> Pool {
        let mut pool = Pool {
            nodes: Vec::new(),
            flags: Vec::new(),
            table: IdTable::default(),
            symbols: Vec::new(),
            rows: Vec::new(),
            names: HashMap::new(),
            known_angles: Vec::new(),
            held: Held::new(budget),
            outgrown: false,
        };
        for node in [
            Node::Number(Number::ZERO),
            Node::Number(Number::ONE),
            Node::Undefined,
            Node::Pi,
            Node::Number(Number::MINUS_ONE),
        ] {
            pool.intern(node);
        }
        pool
    }

    /// The budget that the pool grows within.
    #[must_use]
    pub fn budget(&self) -> &Budget {
        self.held.budget()
    }

    /// Leaves a budget that is spent for a new one, so that what is there can be written out.
    pub(crate) fn renew_budget(&mut self) {
        self.held = Held::default();
    }

    /// Counts memory that is held beside the expressions as long as they are.
    pub(crate) fn hold(&mut self, bytes: usize) {
        self.held.grow(bytes);
    }

    /// Whether nothing new is made any more.
    pub(crate) fn is_spent(&self) -> bool {
        self.budget().is_spent()
    }

    /// Whether a number has outgrown [`crate::number::MAX_BITS`] since this was asked last.
    pub(crate) fn take_outgrown(&mut self) -> bool {
        std::mem::take(&mut self.outgrown)
    }

    /// The expression in place of a number that is too long.
    fn too_long(&mut self) -> ExprId {
        self.outgrown = true;
        UNDEFINED
    }

    /// The symbol of this name; the same one whenever the same name is asked for.
    pub fn symbol(&mut self, name: &str) -> Symbol {
        if let Some(symbol) = self.names.get(name) {
            return *symbol;
        }
        let symbol = self.fresh_symbol(name);
        self.names.insert(name.into(), symbol);
        symbol
    }

    /// A new symbol, different from all others, which is displayed as `name`.
    pub fn fresh_symbol(&mut self, name: &str) -> Symbol {
        let symbol = self.next_symbol();
        let expression = self.intern(Node::Symbol(symbol));
        self.held.grow(size_of::<SymbolEntry>() + name.len());
        self.symbols.push(SymbolEntry { name: name.into(), expression });
        symbol
    }

    /// New symbols in a row: the first, which the others follow ([`Symbol::after`]).
    ///
    /// The expressions of a few are made at once, so that expressions are in the order of their symbols, whichever is
    /// used first; many take no memory each.
    pub(crate) fn fresh_symbols(&mut self, count: usize, names: Arc<dyn SymbolNames>) -> Symbol {
        const FEW: usize = 10_000;
        let first = self.next_symbol();
        if count <= FEW {
            for place in 0..count {
                self.fresh_symbol(&names.name(place));
            }
        } else {
            self.rows.push(SymbolRow { first: first.index(), count, names });
        }
        first
    }

    fn next_symbol(&self) -> Symbol {
        let in_rows: usize = self.rows.iter().map(|row| row.count).sum();
        Symbol(0).after(self.symbols.len() + in_rows)
    }

    /// The entry of a symbol, or the row that has it.
    fn symbol_entry(&self, symbol: Symbol) -> Result<&SymbolEntry, Option<&SymbolRow>> {
        let mut place = symbol.index();
        for row in &self.rows {
            match symbol.index().checked_sub(row.first) {
                None => break,
                Some(within) if within < row.count => return Err(Some(row)),
                Some(_) => place -= row.count,
            }
        }
        self.symbols.get(place).ok_or(None)
    }

    /// What the symbol is displayed as; empty for a symbol of another pool.
    #[must_use]
    pub fn symbol_name(&self, symbol: Symbol) -> Cow<'_, str> {
        match self.symbol_entry(symbol) {
            Ok(entry) => Cow::Borrowed(&entry.name),
            Err(Some(row)) => Cow::Owned(row.names.name(symbol.index() - row.first)),
            Err(None) => Cow::Borrowed(""),
        }
    }

    /// The expression that consists of the symbol.
    pub fn symbol_expr(&mut self, symbol: Symbol) -> ExprId {
        match self.symbol_entry(symbol) {
            Ok(entry) => entry.expression,
            Err(_) => self.intern(Node::Symbol(symbol)),
        }
    }

    /// The expression of the symbol of this name.
    pub fn variable(&mut self, name: &str) -> ExprId {
        let symbol = self.symbol(name);
        self.symbol_expr(symbol)
    }

    /// What the expression is made of.
    ///
    /// An id of another pool gives some expression of this one or [`Node::Undefined`].
    #[must_use]
    pub fn node(&self, id: ExprId) -> &Node {
        self.nodes.get(id.index()).unwrap_or(&Node::Undefined)
    }

    /// The expressions from a place on, in ascending order: those made since the pool was as long.
    pub(crate) fn ids_from(&self, place: usize) -> impl Iterator<Item = ExprId> + use<> {
        let end = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        (u32::try_from(place).unwrap_or(u32::MAX)..end).map(ExprId)
    }

    /// The value of an expression that is a number.
    #[must_use]
    pub fn as_number(&self, id: ExprId) -> Option<&Number> {
        if let Node::Number(value) = self.node(id) { Some(value) } else { None }
    }

    /// The function and its argument, of an expression that is a function's value.
    pub(crate) fn as_function(&self, id: ExprId) -> Option<(Function, ExprId)> {
        if let Node::Function(function, x) = self.node(id) { Some((*function, *x)) } else { None }
    }

    /// Whether the expression is a sum.
    pub fn is_sum(&self, id: ExprId) -> bool {
        matches!(self.node(id), Node::Sum { .. })
    }

    /// The symbol an expression consists of.
    #[must_use]
    pub fn as_symbol(&self, id: ExprId) -> Option<Symbol> {
        if let Node::Symbol(symbol) = self.node(id) { Some(*symbol) } else { None }
    }

    /// Whether no symbol occurs in the expression.
    #[must_use]
    pub fn is_constant(&self, id: ExprId) -> bool {
        self.flags(id).constant
    }

    /// Whether the expression is not negative wherever it has a value, as far as its form shows.
    #[must_use]
    pub fn is_nonnegative(&self, id: ExprId) -> bool {
        self.flags(id).nonnegative
    }

    /// Whether the expression has no value anywhere.
    #[must_use]
    pub fn is_undefined(&self, id: ExprId) -> bool {
        id == UNDEFINED
    }

    /// An exact number; [`Node::Undefined`] beyond [`crate::number::MAX_BITS`].
    pub fn number(&mut self, value: Number) -> ExprId {
        if value.is_oversized() {
            return self.too_long();
        }
        match value.to_i64() {
            Some(0) => ZERO,
            Some(1) => ONE,
            Some(-1) => MINUS_ONE,
            _ => self.intern(Node::Number(value)),
        }
    }

    /// A whole number.
    pub fn integer(&mut self, value: i64) -> ExprId {
        self.number(Number::from(value))
    }

    /// The number 0.
    #[must_use]
    pub fn zero(&self) -> ExprId {
        ZERO
    }

    /// The number 1.
    #[must_use]
    pub fn one(&self) -> ExprId {
        ONE
    }

    /// The number pi.
    #[must_use]
    pub fn pi(&self) -> ExprId {
        PI
    }

    /// The expression without a value.
    #[must_use]
    pub fn undefined(&self) -> ExprId {
        UNDEFINED
    }

    fn flags(&self, id: ExprId) -> Flags {
        self.flags.get(id.index()).copied().unwrap_or_default()
    }

    /// The id of a node that is canonical already.
    fn intern(&mut self, node: Node) -> ExprId {
        let hash = intern::hash(&node);
        self.find(hash, &node).unwrap_or_else(|| self.insert(hash, node))
    }

    /// The id of a node that is there.
    fn find(&self, hash: u32, node: &Node) -> Option<ExprId> {
        self.table.find(hash, |id| self.nodes.get(id as usize) == Some(node)).map(ExprId)
    }

    /// Adds a node that is not there yet.
    fn insert(&mut self, hash: u32, node: Node) -> ExprId {
        // Memory for four thousand million nodes runs out first; nothing is to be said then.
        let Ok(id) = u32::try_from(self.nodes.len()) else { return UNDEFINED };
        if self.is_spent() {
            return UNDEFINED;
        }
        self.held.grow(intern::bytes(&node));
        let flags = self.flags_of(&node);
        self.nodes.push(node);
        self.flags.push(flags);
        self.table.insert(hash, id);
        ExprId(id)
    }
}
