//! The memory of a tree: nodes of twelve bytes, what they hold in pools beside them.
//!
//! A file of ten megabytes has millions of expressions. Each is a [`Span`] and one word: its form,
//! the length of a short list, and a child or a place in the pool of its form. What is read is an
//! [`Expr`] or a [`Unit`], made on the way out.

use std::fmt::{self, Debug, Formatter};

use super::ast::{Comparison, Expr, ExprKind, ExprRef, Indices, Member, Name, Unit, UnitKind, UnitRef};
use crate::span::Span;

/// Texts, most of which come again and again.
#[derive(Clone, Default)]
struct Texts {
    letters: String,
    /// Where each text ends in `letters`; it begins where the one before it ends.
    ends: Vec<u32>,
    /// One text a slot, found by what it says; a text that lost its slot is stored once more.
    recent: Vec<u32>,
}

/// Slots of a small file, and the most there are.
const FEW_SLOTS: usize = 1 << 6;
const MOST_SLOTS: usize = 1 << 12;

impl Texts {
    fn get(&self, number: u32) -> &str {
        let at = number as usize;
        let start = self.end_of(at);
        let end = self.ends.get(at).map_or(start, |end| *end as usize);
        self.letters.get(start..end).unwrap_or_default()
    }

    /// Where the first so many texts end.
    fn end_of(&self, count: usize) -> usize {
        let last = count.checked_sub(1).and_then(|last| self.ends.get(last));
        last.map_or(0, |end| *end as usize)
    }

    fn add(&mut self, text: &str) -> u32 {
        let slots = self.recent.len();
        if self.ends.len() >= slots && slots < MOST_SLOTS {
            self.recent.clear();
            let slots = (8 * slots).clamp(FEW_SLOTS, MOST_SLOTS);
            self.recent.resize(slots, u32::MAX);
        }
        // The hash of Fowler, Noll and Vo.
        let hash = text.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
        // A power of two.
        let slot = (hash ^ hash >> 16) as usize & (self.recent.len() - 1);
        if let Some(&number) = self.recent.get(slot)
            && number != u32::MAX
            && self.get(number) == text
        {
            return number;
        }
        self.letters.push_str(text);
        self.ends.push(self.letters.len() as u32);
        let number = self.ends.len() as u32 - 1;
        if let Some(place) = self.recent.get_mut(slot) {
            *place = number;
        }
        number
    }

    fn finish(&mut self) {
        self.letters.shrink_to_fit();
        self.ends.shrink_to_fit();
        self.recent = Vec::new();
    }
}

/// What a node is, and so what its payload says.
macro_rules! forms {
    ($($form:ident)*) => {
        #[derive(Clone, Copy, PartialEq, Eq)]
        enum Form { $($form),* }

        const FORMS: &[Form] = &[$(Form::$form),*];
    };
}

forms!(Number Name Index Field Prime Negate Power Product Sum Call SumOver IntegralOver Vector Compare Not And Or);

/// Bits of a node's word that hold its form.
const FORM_BITS: u32 = 5;

/// Bits above them for the length of a list of one to three; 0 where it stands before the list.
///
/// The 25 bits left number all that a text of 2^25 bytes can hold: no node and no entry of a pool
/// comes from less than a byte.
const LENGTH_BITS: u32 = 2;

#[derive(Clone, Copy)]
struct Node {
    span: Span,
    word: u32,
}

impl Node {
    fn form(self) -> Form {
        let number = self.word as usize % (1 << FORM_BITS);
        FORMS.get(number).copied().unwrap_or(Form::Number)
    }

    fn payload(self) -> usize {
        (self.word >> (FORM_BITS + LENGTH_BITS)) as usize
    }

    /// The length of a short list.
    fn length(self) -> Option<usize> {
        match self.word >> FORM_BITS & ((1 << LENGTH_BITS) - 1) {
            0 => None,
            length => Some(length as usize),
        }
    }
}

/// All expressions of a file, each numbered by its [`ExprRef`]; children before parents.
///
/// Holds what a text of [`MOST_BYTES`](super::MOST_BYTES) can say.
#[derive(Clone, Default)]
pub struct Expressions {
    nodes: Vec<Node>,
    texts: Texts,
    /// Children, and the lengths of lists in front of them.
    children: Vec<ExprRef>,
    /// Lists of terms and of factors, each with its length in front.
    members: Vec<Member>,
    names: Vec<Name>,
    indices: Vec<Indices>,
}

/// The part of a pool at `at`, `length` long or as long as the first entry says.
fn list<T: Copy>(pool: &[T], at: usize, length: Option<usize>, number: fn(T) -> ExprRef) -> &[T] {
    let rest = pool.get(at..).unwrap_or_default();
    match (length, rest.split_first()) {
        (Some(length), _) => rest.get(..length),
        (None, Some((first, rest))) => rest.get(..number(*first).0 as usize),
        (None, None) => None,
    }
    .unwrap_or_default()
}

/// Puts a list at the end of a pool, with its length in front unless a node's word can hold it.
fn push_list<T: Copy>(pool: &mut Vec<T>, members: &[T], number: fn(ExprRef) -> T) -> usize {
    let short = matches!(members.len(), 1..=3);
    if !short {
        pool.push(number(ExprRef(members.len() as u32)));
    }
    pool.extend(members);
    if short { members.len() } else { 0 }
}

/// How an arena is read.
macro_rules! reading {
    ($arena:ident, $number:ident, $read:ident) => {
        impl $arena {
            /// How many there are.
            #[must_use]
            pub fn len(&self) -> usize {
                self.nodes.len()
            }

            /// Whether there are none.
            #[must_use]
            pub fn is_empty(&self) -> bool {
                self.nodes.is_empty()
            }

            /// All of them, children before parents.
            pub fn iter(&self) -> impl ExactSizeIterator<Item = $read<'_>> + DoubleEndedIterator {
                self.nodes.iter().map(|node| self.read(*node))
            }

            /// The one of that number, if there is one.
            #[must_use]
            pub fn get(&self, at: $number) -> Option<$read<'_>> {
                let node = self.nodes.get(at.0 as usize)?;
                Some(self.read(*node))
            }
        }

        impl PartialEq for $arena {
            fn eq(&self, other: &Self) -> bool {
                self.iter().eq(other.iter())
            }
        }

        impl Debug for $arena {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.debug_list().entries(self.iter()).finish()
            }
        }
    };
}

reading!(Expressions, ExprRef, Expr);
reading!(Units, UnitRef, Unit);

impl Expressions {
    fn child(&self, at: usize) -> ExprRef {
        self.children.get(at).copied().unwrap_or(ExprRef(0))
    }

    fn read(&self, node: Node) -> Expr<'_> {
        let payload = node.payload();
        let only = ExprRef(payload as u32);
        let (first, second) = (self.child(payload), self.child(payload + 1));
        let members = |at| list(&self.children, at, node.length(), |length| length);
        let name = |number: ExprRef| &self.names[number.0 as usize];
        let signed = || list(&self.members, payload, node.length(), Member::value);
        let kind = match node.form() {
            Form::Number => ExprKind::Number(self.texts.get(payload as u32)),
            Form::Name => ExprKind::Name(self.texts.get(payload as u32)),
            Form::Index => ExprKind::Index { base: first, indices: members(payload + 1) },
            Form::Field => ExprKind::Field { base: first, field: name(second) },
            Form::Prime => ExprKind::Prime(only),
            Form::Negate => ExprKind::Negate(only),
            Form::Power => ExprKind::Power { base: first, exponent: second },
            Form::Product => ExprKind::Product(signed()),
            Form::Sum => ExprKind::Sum(signed()),
            Form::Call => ExprKind::Call { function: name(first), arguments: members(payload + 1) },
            Form::SumOver => ExprKind::SumOver { indices: &self.indices[first.0 as usize], body: second },
            Form::IntegralOver => ExprKind::IntegralOver { indices: &self.indices[first.0 as usize], body: second },
            Form::Vector => ExprKind::Vector(members(payload)),
            Form::Compare => {
                let operator = Comparison::ALL[self.child(payload + 2).0 as usize];
                ExprKind::Compare { operator, left: first, right: second }
            }
            Form::Not => ExprKind::Not(only),
            Form::And => ExprKind::And(members(payload)),
            Form::Or => ExprKind::Or(members(payload)),
        };
        Expr { span: node.span, kind }
    }

    /// Adds an expression, whose children are there already.
    pub fn push(&mut self, expr: Expr<'_>) -> ExprRef {
        let here = self.children.len();
        let mut length = 0;
        let mut list = |children: &mut Vec<ExprRef>, members: &[ExprRef]| -> usize {
            length = push_list(children, members, |length| length);
            here
        };
        let (form, payload) = match expr.kind {
            ExprKind::Number(text) => (Form::Number, self.texts.add(text) as usize),
            ExprKind::Name(text) => (Form::Name, self.texts.add(text) as usize),
            ExprKind::Index { base, indices } => {
                self.children.push(base);
                (Form::Index, list(&mut self.children, indices))
            }
            ExprKind::Field { base, field } => {
                let field = self.push_name(field);
                self.children.extend([base, field]);
                (Form::Field, here)
            }
            ExprKind::Prime(inner) => (Form::Prime, inner.0 as usize),
            ExprKind::Negate(inner) => (Form::Negate, inner.0 as usize),
            ExprKind::Power { base, exponent } => {
                self.children.extend([base, exponent]);
                (Form::Power, here)
            }
            ExprKind::Product(members) | ExprKind::Sum(members) => {
                let here = self.members.len();
                length = push_list(&mut self.members, members, |n| Member::new(false, n));
                (if matches!(expr.kind, ExprKind::Sum(_)) { Form::Sum } else { Form::Product }, here)
            }
            ExprKind::Call { function, arguments } => {
                let function = self.push_name(function);
                self.children.push(function);
                (Form::Call, list(&mut self.children, arguments))
            }
            ExprKind::SumOver { indices, body } | ExprKind::IntegralOver { indices, body } => {
                let number = ExprRef(self.indices.len() as u32);
                self.indices.push(indices.clone());
                self.children.extend([number, body]);
                (if matches!(expr.kind, ExprKind::SumOver { .. }) { Form::SumOver } else { Form::IntegralOver }, here)
            }
            ExprKind::Vector(members) => (Form::Vector, list(&mut self.children, members)),
            ExprKind::Compare { operator, left, right } => {
                self.children.extend([left, right, ExprRef(operator as u32)]);
                (Form::Compare, here)
            }
            ExprKind::Not(inner) => (Form::Not, inner.0 as usize),
            ExprKind::And(members) => (Form::And, list(&mut self.children, members)),
            ExprKind::Or(members) => (Form::Or, list(&mut self.children, members)),
        };
        let word = (payload as u32) << LENGTH_BITS | length as u32;
        self.nodes.push(Node { span: expr.span, word: word << FORM_BITS | form as u32 });
        ExprRef(self.nodes.len() as u32 - 1)
    }

    fn push_name(&mut self, name: &Name) -> ExprRef {
        self.names.push(name.clone());
        ExprRef(self.names.len() as u32 - 1)
    }

    /// Gives back what was reserved and not needed.
    pub(super) fn finish(&mut self) {
        self.nodes.shrink_to_fit();
        self.texts.finish();
        self.children.shrink_to_fit();
        self.members.shrink_to_fit();
        self.names.shrink_to_fit();
        self.indices.shrink_to_fit();
    }
}

/// The form of a unit as it is stored.
#[derive(Clone, Copy)]
enum UnitForm {
    One,
    /// The number of its text.
    Name(u32),
    /// A range of the pool of factors.
    Product(u32, u32),
    Power(UnitRef, i32, i32),
}

/// All units of a file, each numbered by its [`UnitRef`]; children before parents.
#[derive(Clone, Default)]
pub struct Units {
    nodes: Vec<(Span, UnitForm)>,
    texts: Texts,
    factors: Vec<(bool, UnitRef)>,
}

impl Units {
    fn read(&self, (span, form): (Span, UnitForm)) -> Unit<'_> {
        let kind = match form {
            UnitForm::One => UnitKind::One,
            UnitForm::Name(number) => UnitKind::Name(self.texts.get(number)),
            UnitForm::Product(start, end) => {
                UnitKind::Product(self.factors.get(start as usize..end as usize).unwrap_or_default())
            }
            UnitForm::Power(base, numerator, denominator) => UnitKind::Power { base, numerator, denominator },
        };
        Unit { span, kind }
    }

    /// Adds a unit, whose parts are there already.
    pub fn push(&mut self, unit: Unit<'_>) -> UnitRef {
        let form = match unit.kind {
            UnitKind::One => UnitForm::One,
            UnitKind::Name(name) => UnitForm::Name(self.texts.add(name)),
            UnitKind::Product(factors) => {
                let start = self.factors.len() as u32;
                self.factors.extend(factors);
                UnitForm::Product(start, self.factors.len() as u32)
            }
            UnitKind::Power { base, numerator, denominator } => UnitForm::Power(base, numerator, denominator),
        };
        self.nodes.push((unit.span, form));
        UnitRef(self.nodes.len() as u32 - 1)
    }

    /// Gives back what was reserved and not needed.
    pub(super) fn finish(&mut self) {
        self.nodes.shrink_to_fit();
        self.texts.finish();
        self.factors.shrink_to_fit();
    }
}
