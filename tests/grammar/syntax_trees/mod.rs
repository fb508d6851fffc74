//! Random trees, and files that are made of them.

use librate::span::Span;
use librate_core::syntax::*;
use proptest::prelude::*;
use proptest::sample::select;

/// A tree with owned children, which proptest can shrink.
#[derive(Clone, Debug)]
pub(crate) enum Tree {
    Number(&'static str),
    Name(&'static str),
    Index(Box<Tree>, Vec<Tree>),
    Field(Box<Tree>, &'static str),
    Prime(Box<Tree>),
    Negate(Box<Tree>),
    Power(Box<Tree>, Box<Tree>),
    Product(Vec<(bool, Tree)>),
    Sum(Vec<(bool, Tree)>),
    Call(&'static str, Vec<Tree>),
    SumOver(Vec<Entry>, Option<Condition>, Box<Tree>),
    IntegralOver(Box<Entry>, Box<Tree>),
    Vector(Vec<Tree>),
}

#[derive(Clone, Debug)]
pub(crate) enum Entry {
    Member(Tree),
    Range(Option<&'static str>, Tree, Tree),
    Rows(&'static str, &'static str),
}

#[derive(Clone, Debug)]
pub(crate) enum Condition {
    Compare(Comparison, Box<Tree>, Box<Tree>),
    Not(Box<Condition>),
    And(Vec<Condition>),
    Or(Vec<Condition>),
}

#[derive(Clone, Debug)]
pub(crate) enum UnitTree {
    One,
    Name(&'static str),
    Product(Vec<(bool, UnitTree)>),
    Power(Box<UnitTree>, i32, i32),
}

#[derive(Clone, Debug)]
pub(crate) struct Bound {
    name: &'static str,
    indices: Option<(Vec<Entry>, Option<Condition>)>,
    unit: Option<UnitTree>,
    value: Tree,
    uncertainty: Option<Tree>,
    rate: bool,
}

pub(crate) const NAMES: [&str; 10] = ["x", "phi", "m", "k1", "φ", "ω0", "r_2", "Te", "In", "b"];

pub(crate) fn names() -> impl Strategy<Value = &'static str> {
    select(NAMES.to_vec())
}

pub(crate) fn entries(tree: BoxedStrategy<Tree>, binding: bool) -> BoxedStrategy<Vec<Entry>> {
    let pair = (tree.clone(), tree.clone());
    let rows = (names(), names()).prop_map(|(b, table)| Entry::Rows(b, table));
    let range = (names(), pair.clone()).prop_map(|(i, (a, b))| Entry::Range(Some(i), a, b));
    if binding {
        let unnamed = pair.prop_map(|(a, b)| Entry::Range(None, a, b));
        let member = tree.prop_map(Entry::Member);
        proptest::collection::vec(prop_oneof![rows, range, unnamed, member], 1..3).boxed()
    } else {
        proptest::collection::vec(prop_oneof![rows, range], 1..3).boxed()
    }
}

pub(crate) fn conditions(tree: BoxedStrategy<Tree>) -> BoxedStrategy<Condition> {
    let operator = select(vec![
        Comparison::Equal,
        Comparison::NotEqual,
        Comparison::Less,
        Comparison::LessEqual,
        Comparison::Greater,
        Comparison::GreaterEqual,
    ]);
    (operator, tree.clone(), tree)
        .prop_map(|(operator, a, b)| Condition::Compare(operator, Box::new(a), Box::new(b)))
        .prop_recursive(3, 8, 3, |inner| {
            let several = proptest::collection::vec(inner.clone(), 2..4);
            prop_oneof![
                inner.prop_map(|c| Condition::Not(Box::new(c))),
                several.clone().prop_map(Condition::And),
                several.prop_map(Condition::Or),
            ]
        })
        .boxed()
}

pub(crate) fn trees() -> BoxedStrategy<Tree> {
    let leaf = prop_oneof![
        select(vec!["1", "2", "0.5", "6.02e23", "1e-3", "10E+2"]).prop_map(Tree::Number),
        names().prop_map(Tree::Name),
        Just(Tree::Name("t")),
        Just(Tree::Name("pi")),
    ];
    leaf.prop_recursive(5, 40, 4, |inner| {
        let boxed = inner.clone().prop_map(Box::new);
        let list = |least| proptest::collection::vec(inner.clone(), least..4);
        let signed = proptest::collection::vec((any::<bool>(), inner.clone()), 2..4);
        let signed = signed.prop_map(|mut list| {
            list[0].0 = false;
            list
        });
        prop_oneof![
            (boxed.clone(), list(1)).prop_map(|(base, i)| Tree::Index(base, i)),
            (boxed.clone(), select(vec!["k", "T", "mass", "in"])).prop_map(|(base, field)| Tree::Field(base, field)),
            boxed.clone().prop_map(Tree::Prime),
            boxed.clone().prop_map(Tree::Negate),
            (boxed.clone(), boxed.clone()).prop_map(|(a, b)| Tree::Power(a, b)),
            signed.clone().prop_map(Tree::Product),
            signed.prop_map(Tree::Sum),
            (select(vec!["sin", "rows", "f"]), list(0)).prop_map(|(f, a)| Tree::Call(f, a)),
            (entries(inner.clone().boxed(), false), proptest::option::of(conditions(inner.clone().boxed())), boxed)
                .prop_map(|(entries, filter, body)| Tree::SumOver(entries, filter, body)),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(from, to, body)| Tree::IntegralOver(
                Box::new(Entry::Range(Some("k"), from, to)),
                Box::new(body)
            )),
            list(1).prop_map(Tree::Vector),
        ]
    })
    .boxed()
}

pub(crate) fn unit_trees() -> BoxedStrategy<UnitTree> {
    let leaf = prop_oneof![Just(UnitTree::One), select(vec!["kg", "T", "V", "µm", "Ω", "s"]).prop_map(UnitTree::Name),];
    leaf.prop_recursive(3, 8, 3, |inner| {
        let list = proptest::collection::vec((any::<bool>(), inner.clone()), 2..4);
        prop_oneof![
            list.prop_map(|mut list| {
                list[0].0 = false;
                UnitTree::Product(list)
            }),
            (inner, -4..5, 1..4).prop_map(|(base, n, d)| UnitTree::Power(Box::new(base), n, d)),
        ]
    })
    .boxed()
}

pub(crate) fn bounds() -> impl Strategy<Value = Bound> {
    let indices = (entries(trees(), true), proptest::option::of(conditions(trees())));
    (
        names(),
        proptest::option::of(indices),
        proptest::option::of(unit_trees()),
        trees(),
        proptest::option::of(trees()),
        any::<bool>(),
    )
        .prop_map(|(name, indices, unit, value, uncertainty, rate)| Bound {
            name,
            indices,
            unit,
            value,
            uncertainty,
            rate,
        })
}

/// Puts trees into the arenas of a file.
#[derive(Default)]
pub(crate) struct Planter {
    pub(crate) file: File,
}

pub(crate) fn named(text: &str) -> Name {
    Name { text: text.into(), span: Span::default() }
}

impl Planter {
    pub(crate) fn push(&mut self, kind: ExprKind<'_>) -> ExprRef {
        let span = Span::default();
        self.file.expressions.push(Expr { span, kind })
    }

    pub(crate) fn all(&mut self, trees: &[Tree]) -> Vec<ExprRef> {
        trees.iter().map(|tree| self.tree(tree)).collect()
    }

    pub(crate) fn tree(&mut self, tree: &Tree) -> ExprRef {
        match tree {
            Tree::Number(text) => self.push(ExprKind::Number(text)),
            Tree::Name(text) => self.push(ExprKind::Name(text)),
            Tree::Index(base, list) => {
                let base = self.tree(base);
                let indices = &self.all(list);
                self.push(ExprKind::Index { base, indices })
            }
            Tree::Field(base, field) => {
                let base = self.tree(base);
                let field = &named(field);
                self.push(ExprKind::Field { base, field })
            }
            Tree::Prime(inner) => {
                let inner = self.tree(inner);
                self.push(ExprKind::Prime(inner))
            }
            Tree::Negate(inner) => {
                let inner = self.tree(inner);
                self.push(ExprKind::Negate(inner))
            }
            Tree::Power(base, exponent) => {
                let base = self.tree(base);
                let exponent = self.tree(exponent);
                self.push(ExprKind::Power { base, exponent })
            }
            Tree::Product(list) => {
                let factors: Vec<Member> =
                    list.iter().map(|(divided, tree)| Member::new(*divided, self.tree(tree))).collect();
                self.push(ExprKind::Product(&factors))
            }
            Tree::Sum(list) => {
                let terms: Vec<Member> =
                    list.iter().map(|(subtracted, tree)| Member::new(*subtracted, self.tree(tree))).collect();
                self.push(ExprKind::Sum(&terms))
            }
            Tree::Call(function, list) => {
                let function = &named(function);
                let arguments = &self.all(list);
                self.push(ExprKind::Call { function, arguments })
            }
            Tree::SumOver(entries, filter, body) => {
                let indices = &self.indices(entries, filter.as_ref());
                let body = self.tree(body);
                self.push(ExprKind::SumOver { indices, body })
            }
            Tree::IntegralOver(range, body) => {
                let indices = &self.indices(std::slice::from_ref(&**range), None);
                let body = self.tree(body);
                self.push(ExprKind::IntegralOver { indices, body })
            }
            Tree::Vector(list) => {
                let members = self.all(list);
                self.push(ExprKind::Vector(&members))
            }
        }
    }

    pub(crate) fn condition(&mut self, condition: &Condition) -> ExprRef {
        let all = |this: &mut Self, list: &[Condition]| list.iter().map(|c| this.condition(c)).collect::<Vec<_>>();
        match condition {
            Condition::Compare(operator, left, right) => {
                let left = self.tree(left);
                let right = self.tree(right);
                self.push(ExprKind::Compare { operator: *operator, left, right })
            }
            Condition::Not(inner) => {
                let inner = self.condition(inner);
                self.push(ExprKind::Not(inner))
            }
            Condition::And(list) => {
                let members = all(self, list);
                self.push(ExprKind::And(&members))
            }
            Condition::Or(list) => {
                let members = all(self, list);
                self.push(ExprKind::Or(&members))
            }
        }
    }

    pub(crate) fn indices(&mut self, entries: &[Entry], filter: Option<&Condition>) -> Indices {
        Indices {
            span: Span::default(),
            entries: entries
                .iter()
                .map(|entry| IndexEntry {
                    span: Span::default(),
                    kind: match entry {
                        Entry::Member(tree) => IndexKind::Member(self.tree(tree)),
                        Entry::Range(variable, from, to) => {
                            IndexKind::Range { variable: variable.map(named), from: self.tree(from), to: self.tree(to) }
                        }
                        Entry::Rows(variable, table) => {
                            IndexKind::Rows { variable: named(variable), table: named(table) }
                        }
                    },
                })
                .collect(),
            filter: filter.map(|c| self.condition(c)),
        }
    }

    pub(crate) fn unit(&mut self, unit: &UnitTree) -> UnitRef {
        let factors: Vec<(bool, UnitRef)>;
        let kind = match unit {
            UnitTree::One => UnitKind::One,
            UnitTree::Name(text) => UnitKind::Name(text),
            UnitTree::Product(list) => {
                factors = list.iter().map(|(d, u)| (*d, self.unit(u))).collect();
                UnitKind::Product(&factors)
            }
            UnitTree::Power(base, numerator, denominator) => {
                UnitKind::Power { base: self.unit(base), numerator: *numerator, denominator: *denominator }
            }
        };
        let span = Span::default();
        self.file.units.push(Unit { span, kind })
    }

    /// The bound thing as each of the statements it can be.
    pub(crate) fn statements(&mut self, bound: &Bound) {
        for variant in 0..14 {
            let indices = bound.indices.as_ref();
            let indices = indices.map(|(entries, c)| Box::new(self.indices(entries, c.as_ref())));
            let unit = bound.unit.as_ref().map(|unit| self.unit(unit));
            let mut binding = Binding {
                name: named(bound.name),
                indices,
                unit,
                value: Some(self.tree(&bound.value)),
                uncertainty: None,
            };
            let kind = match variant {
                0 => {
                    binding.uncertainty = bound.uncertainty.as_ref().map(|tree| self.tree(tree));
                    StatementKind::Param(vec![binding])
                }
                1 => {
                    binding.value = None;
                    StatementKind::Param(vec![binding])
                }
                2 => StatementKind::Let(binding),
                3 => StatementKind::Guess { binding, rate: bound.rate },
                4 => StatementKind::Equilibrium { binding, rate: bound.rate },
                5 => StatementKind::Force(binding),
                6 => StatementKind::Kinetic(self.tree(&bound.value)),
                7 => {
                    binding.uncertainty = bound.uncertainty.as_ref().map(|tree| self.tree(tree));
                    let own = Binding { value: Some(self.tree(&bound.value)), uncertainty: None, ..binding.clone() };
                    StatementKind::Param(vec![own, binding.clone(), binding])
                }
                8 => {
                    binding.value = None;
                    StatementKind::Coord { declarations: vec![binding.clone(), binding] }
                }
                9 => {
                    let relation = |planter: &mut Self| {
                        let span = Span::default();
                        let left = planter.tree(&bound.value);
                        let right = planter.file.expressions.push(Expr { span, kind: ExprKind::Number("0") });
                        let kind = ExprKind::Compare { operator: Comparison::GreaterEqual, left, right };
                        planter.file.expressions.push(Expr { span, kind })
                    };
                    StatementKind::Assume(vec![relation(self), relation(self)])
                }
                10..=12 => {
                    let drawn = [Drawn::Point, Drawn::Line, Drawn::Spring][variant - 10];
                    let points = vec![self.tree(&bound.value), self.tree(&bound.value)];
                    StatementKind::Draw { drawn, indices: None, points }
                }
                _ => StatementKind::Constraint {
                    indices: None,
                    left: self.tree(&bound.value),
                    right: self.tree(&bound.value),
                },
            };
            self.file.statements.push(Statement { span: Span::default(), kind });
        }
    }
}
