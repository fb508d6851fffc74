//! Numbers for the elements of every instance, and their sums: force, stiffness, inertia.
//!
//! The symbolic work is done once a family of terms; here its tapes are run once an instance and
//! the small blocks are scattered into place, as a finite-element code does.

use hashbrown::HashMap;

use super::elements::{Element, Splitter, elements};
use super::error::LinearizeError;
use super::facts::Variable;
use super::inputs::Inputs;
use super::missing_value;
use super::nested::{Nest, compact, nests};
use super::parameters::parameters_of;
use super::velocity::{Derivatives, Matrix, VelocityFamily};
pub use crate::expr::evaluate_closed;
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol, Tape};
use crate::model::{Local, Model, TermFamily};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::{Ball, Big, Function, Scalar};

/// The elements of one family of terms, ready to be evaluated.
#[derive(Clone, Debug)]
pub(crate) struct ElementFamily {
    /// Elements of the kinetic energy with respect to the velocities, at velocity zero.
    pub(super) inertia: Vec<Element>,
    /// Elements of the effective potential V - T0 with respect to the coordinates.
    pub(super) potential: Vec<Element>,
    /// The instances: coordinates and constants.
    pub(super) terms: TermFamily,
    /// The term's share of V - T0.
    pub(super) effective: ExprId,
    /// Logarithms of coordinates in it: ln(u) has no value where u < 0, where its derivatives have one.
    pub(super) logarithms: Vec<ExprId>,
    /// Both in nests.
    inertia_nests: Vec<Nest>,
    potential_nests: Vec<Nest>,
    pub(super) inputs: Inputs,
    inertia_tape: Tape,
    force_tape: Tape,
    stiffness_tape: Tape,
}

/// Bits of numbers of any range, where those of balls do not do.
const WIDE: usize = 192;

/// Of more elements it pays to know that none has a force.
const MANY: usize = 1000;

/// All families, with what they share.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    pub(crate) families: Vec<ElementFamily>,
    /// The distinct constants that fill value slots.
    constants_tape: Option<Tape>,
    constants_parameters: Vec<usize>,
    pub(super) dimension: usize,
    /// What goes with velocities, and friction.
    pub(super) velocity: Vec<VelocityFamily>,
    /// The matrices that are proved to vanish though these have entries of them.
    pub(super) vanishing: Vec<Matrix>,
    /// Whether each element is without force by itself where the equilibrium is given, whatever the numbers are: springs between
    /// points of a table with their distances for lengths. Asked of many elements only.
    pub(super) unstressed: bool,
}

/// Parameter values and constants as numbers of one type.
#[derive(Clone, Debug)]
pub(crate) struct Values<S: Scalar> {
    pub(super) parameters: Vec<Option<S>>,
    pub(super) constants: Vec<S>,
    precision: S::Precision,
    /// Where the range of these numbers does not do: the same in others, which all is evaluated in ([`Scalar::to_wide`]).
    wide: Option<Box<Values<Big>>>,
}

/// What an evaluation is for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Inertia,
    Force,
    Stiffness,
}

/// A term of the energies with the sign it has in L = T - V.
pub fn signed_terms(model: &Model) -> impl Iterator<Item = (bool, &TermFamily)> {
    let kinetic = model.kinetic.iter().map(|family| (false, family));
    let potential = model.potential.iter().map(|family| (true, family));
    kinetic.chain(potential)
}

/// Takes all terms of a model apart.
pub(crate) fn assemble(model: &mut Model) -> Assembly {
    let mut families = Vec::new();
    // Terms that are linear in the velocities at velocity zero, with the coefficient of each.
    let mut linear: Vec<(TermFamily, Vec<(usize, ExprId)>)> = Vec::new();
    let mut constants = Vec::new();
    let mut numbers: HashMap<ExprId, u32> = HashMap::new();
    let mut number = |constant: ExprId| {
        let next = u32::try_from(constants.len()).unwrap_or(u32::MAX);
        *numbers.entry(constant).or_insert_with(|| {
            constants.push(constant);
            next
        })
    };
    let terms: Vec<(bool, TermFamily)> =
        signed_terms(model).map(|(negative, family)| (negative, family.clone())).collect();
    let mut splitter = Splitter::about(terms.iter().flat_map(|(_, family)| &family.locals));
    for (negative, family) in terms {
        if family.count == 0 {
            continue;
        }
        let (effective, parts, coefficients) = split(&mut model.pool, &mut splitter, &family, negative);
        if !coefficients.is_empty() {
            linear.push((family.clone(), coefficients));
        }
        if parts.0.is_empty() && parts.1.is_empty() {
            continue;
        }
        let constants = family.constants.iter().map(|constant| number(*constant)).collect();
        let logarithms = logarithms(&model.pool, &mut splitter, effective);
        families.extend(compile(model, family, (effective, logarithms), parts, constants));
    }
    let mut velocity = Vec::new();
    for (terms, coefficients) in linear {
        let derivatives = Derivatives::gyroscopic(&mut model.pool, &terms, &coefficients);
        velocity.extend(VelocityFamily::new(model, terms, derivatives, &mut number));
    }
    for terms in model.forces.clone() {
        let derivatives = Derivatives::friction(&mut model.pool, &terms);
        velocity.extend(VelocityFamily::new(model, terms, derivatives, &mut number));
    }
    let constants_parameters = parameters_of(model, &constants);
    let inputs: Vec<Symbol> =
        constants_parameters.iter().map(|parameter| model.parameters[*parameter].symbol).collect();
    let constants_tape = Tape::compile(&model.pool, &constants, &inputs).ok();
    Assembly {
        unstressed: velocity.is_empty() && are_unstressed(model, &families),
        families,
        constants_tape,
        constants_parameters,
        dimension: model.coordinates.len(),
        velocity,
        vanishing: Vec::new(),
    }
}

/// Whether elements are without force in symbols: with the value of the instance put in for a coordinate that has the same place in
/// each of them.
fn are_unstressed(model: &mut Model, families: &[ElementFamily]) -> bool {
    let count: usize = families.iter().map(|family| family.terms.count).sum();
    count > MANY
        && model.equilibria.any()
        && families.iter().filter(|family| !family.potential.is_empty()).all(|family| {
            let terms = &family.terms;
            let given = |i: &u32| model.equilibria.get(*i as usize).and_then(|given| given.value);
            let mut same = vec![vec![true; terms.values.len()]; terms.locals.len()];
            for instance in 0..terms.count {
                let constants = terms.constants_of(instance);
                for (own, i) in same.iter_mut().zip(terms.coordinates_of(instance)) {
                    let at = given(i);
                    own.iter_mut().zip(constants).for_each(|(same, constant)| *same &= at == Some(*constant));
                }
            }
            let place = |(own, local): (&Vec<bool>, &Local)| {
                let k = own.iter().position(|same| *same)?;
                Some((local.coordinate, model.pool.symbol_expr(terms.values[k])))
            };
            let places: Substitution = same.iter().zip(&terms.locals).filter_map(place).collect();
            family.potential.iter().all(|element| model.pool.substitute_one(element.first, &places).is_zero())
        })
}

type Parts = (Vec<Element>, Vec<Element>);

/// V - T0 of one term; inertia, effective potential and velocity-linear coefficients.
fn split(
    pool: &mut Pool,
    splitter: &mut Splitter,
    family: &TermFamily,
    negative: bool,
) -> (ExprId, Parts, Vec<(usize, ExprId)>) {
    let coordinates: Vec<Symbol> = family.locals.iter().map(|local| local.coordinate).collect();
    let velocities: Vec<Symbol> = family.locals.iter().map(|local| local.velocity).collect();
    let at_rest = family.at_rest(pool);
    // L = T - V: the body's share of L, and of the effective potential V - T0.
    let share = if negative { pool.neg(family.body) } else { family.body };
    let moving = splitter.facts.varies(pool, share, Variable::Velocity);
    let static_share = splitter.at_rest(pool, share, &at_rest);
    let effective = pool.neg(static_share);
    let potential = elements(pool, splitter, effective, &coordinates, Variable::Coordinate);
    if !moving {
        return (effective, (Vec::new(), potential), Vec::new());
    }
    let mut inertia = Vec::new();
    let mut coefficients: Vec<Vec<ExprId>> = vec![Vec::new(); velocities.len()];
    for element in elements(pool, splitter, share, &velocities, Variable::Velocity) {
        let element = element.at_rest(pool, &mut splitter.facts, &at_rest);
        for (place, slope) in element.slope.iter().filter(|_| !element.first.is_zero()) {
            let coefficient = pool.mul(element.first, *slope);
            coefficients[*place].push(coefficient);
        }
        if !(element.second.is_zero() || element.slope.is_empty()) || !element.curvature.is_empty() {
            inertia.push(element);
        }
    }
    let linear = coefficients.iter().map(|parts| pool.sum(parts)).enumerate();
    let linear = linear.filter(|(_, coefficient)| !coefficient.is_zero()).collect();
    (effective, (inertia, potential), linear)
}

/// The logarithms of coordinates in an expression.
fn logarithms(pool: &Pool, splitter: &mut Splitter, root: ExprId) -> Vec<ExprId> {
    let mut parts = pool.reachable(&[root]);
    parts.retain(|id| {
        matches!(pool.node(*id), Node::Function(Function::Ln, _))
            && splitter.facts.varies(pool, *id, Variable::Coordinate)
    });
    parts
}

fn compile(
    model: &Model,
    terms: TermFamily,
    (effective, logarithms): (ExprId, Vec<ExprId>),
    (inertia, potential): Parts,
    constants: Vec<u32>,
) -> Option<ElementFamily> {
    let mut force_roots = Vec::new();
    let mut stiffness_roots = Vec::new();
    for element in &potential {
        force_roots.push(element.first);
        force_roots.extend(element.slope.iter().map(|(_, entry)| *entry));
        stiffness_roots.extend(element.entries());
    }
    force_roots.extend(&logarithms);
    let mut inertia_nests = nests(&inertia);
    let inertia_roots = compact(&mut inertia_nests, &inertia);
    let all: Vec<ExprId> = stiffness_roots.iter().chain(&inertia_roots).chain(&logarithms).copied().collect();
    let inputs = Inputs::new(model, &all, constants);
    let tape = |roots: &[ExprId]| inputs.tape(model, &model.pool, &terms, roots);
    Some(ElementFamily {
        inertia_tape: tape(&inertia_roots)?,
        force_tape: tape(&force_roots)?,
        stiffness_tape: tape(&stiffness_roots)?,
        inertia_nests,
        potential_nests: nests(&potential),
        inertia,
        potential,
        terms,
        effective,
        logarithms,
        inputs,
    })
}

impl ElementFamily {
    /// What the numbers of an instance add to M or K: for two of its own coordinates, and whether for both orders of them.
    fn shares<S: Scalar>(&self, part: Part, numbers: &[S], mut add: impl FnMut(usize, usize, &S, bool)) {
        let (elements, nests) = self.nests(part);
        for nest in nests {
            nest.shares(elements, numbers, &mut add);
        }
    }

    fn nests(&self, part: Part) -> (&[Element], &[Nest]) {
        match part {
            Part::Inertia => (&self.inertia, &self.inertia_nests),
            Part::Force | Part::Stiffness => (&self.potential, &self.potential_nests),
        }
    }
}

impl<S: Scalar> Values<S> {
    /// A point and the values in numbers of any range, where these do not do.
    pub(super) fn wide(&self, at: &[S]) -> Option<(Vec<Big>, &Values<Big>)> {
        let wide = self.wide.as_deref()?;
        let at: Option<Vec<Big>> = at.iter().map(|x| x.to_wide(WIDE)).collect();
        Some((at?, wide))
    }

    /// What the numbers were made with.
    pub(crate) fn precision(&self) -> S::Precision {
        self.precision
    }
}

impl Assembly {
    /// The values of parameters and constants.
    pub(crate) fn values<S: Scalar>(
        &self,
        model: &Model,
        precision: S::Precision,
    ) -> Result<Values<S>, LinearizeError> {
        self.values_where(model, precision, |_, value| value)
    }

    /// The values, with those of parameters replaced as told by their number.
    pub(crate) fn values_where<S: Scalar>(
        &self,
        model: &Model,
        precision: S::Precision,
        replaced: impl Fn(usize, S) -> S,
    ) -> Result<Values<S>, LinearizeError> {
        let families = self.families.iter().map(|family| &family.inputs);
        let all = families.chain(self.velocity.iter().map(|family| &family.inputs));
        let needed = self.constants_parameters.iter().chain(all.flat_map(|inputs| &inputs.parameters));
        let mut parameters: Vec<Option<S>> = vec![None; model.parameters.len()];
        for number in needed.copied().distinct() {
            let value = model.parameters[number].value.ok_or_else(|| missing_value(model, number))?;
            let own = evaluate_closed(&model.pool, value, precision);
            parameters[number] = own.map(|own| replaced(number, own));
        }
        let inputs: Vec<S> =
            self.constants_parameters.iter().filter_map(|number| parameters[*number].clone()).collect();
        let constants = self
            .constants_tape
            .as_ref()
            .map_or_else(Vec::new, |tape| tape.prepare(precision).evaluate(&inputs, &mut Vec::new()));
        Ok(Values { parameters, constants, precision, wide: None })
    }

    /// The values, for expressions whose parts may be anywhere beyond the range of balls.
    pub(super) fn wide_values(&self, model: &Model) -> Result<Values<Ball>, LinearizeError> {
        let mut values = self.values(model, ())?;
        values.wide = Some(Box::new(self.values(model, WIDE)?));
        Ok(values)
    }

    /// How many shares [`Assembly::entries`] gives for both matrices, at most.
    pub(super) fn shares(&self) -> u64 {
        self.shares_of(Part::Inertia).saturating_add(self.shares_of(Part::Stiffness))
    }

    /// The same for one of them.
    pub(super) fn shares_of(&self, part: Part) -> u64 {
        let shares = self.families.iter().map(|family| {
            let (elements, nests) = family.nests(part);
            let one: u64 = nests.iter().map(|nest| nest.count(elements)).sum();
            one.saturating_mul(family.terms.count as u64)
        });
        shares.fold(0, u64::saturating_add)
    }

    /// Runs one kind of tape for all instances: `scatter` gets the family, the number of the instance, the numbers in the order of
    /// the elements, and whether these are not those of the instance before.
    pub(super) fn run<'a, S: Scalar>(
        &'a self,
        part: Part,
        at: &[S],
        values: &Values<S>,
        mut scatter: impl FnMut(&'a ElementFamily, usize, &[S], bool),
    ) {
        for family in &self.families {
            let (tape, used) = match part {
                Part::Inertia => (&family.inertia_tape, !family.inertia.is_empty()),
                Part::Force => (&family.force_tape, !family.potential.is_empty()),
                Part::Stiffness => (&family.stiffness_tape, !family.potential.is_empty()),
            };
            if used {
                family.inputs.run(&family.terms, tape, at, values, |instance, numbers, is_new| {
                    scatter(family, instance, numbers, is_new);
                });
            }
        }
    }

    /// All terms of the energies, one instance after the other.
    pub(super) fn instances(&self) -> impl Iterator<Item = (&ElementFamily, usize)> {
        self.families.iter().flat_map(|family| (0..family.terms.count).map(move |at| (family, at)))
    }

    /// The gradient of the effective potential, one entry a coordinate; with what friction does at rest.
    pub(crate) fn gradient<S: Scalar>(&self, at: &[S], values: &Values<S>) -> Vec<S> {
        if let Some((at, wide)) = values.wide(at) {
            return self.gradient(&at, wide).iter().filter_map(S::from_wide).collect();
        }
        let mut gradient = vec![S::from_number(&Number::from(0), values.precision); self.dimension];
        self.run(Part::Force, at, values, |family, instance, numbers, _| {
            let coordinates = family.terms.coordinates_of(instance);
            let mut rest = numbers;
            for element in &family.potential {
                let (first, slopes) = head(&mut rest, 1, element.slope.len());
                for ((place, _), slope) in element.slope.iter().zip(slopes) {
                    let entry = &mut gradient[coordinates[*place] as usize];
                    *entry = entry.add(&first[0].mul(slope));
                }
            }
            // Where the energy has no value, no force has one.
            for logarithm in rest.iter().filter(|number| !number.is_finite()) {
                for place in coordinates {
                    let entry = &mut gradient[*place as usize];
                    *entry = entry.add(logarithm);
                }
            }
        });
        self.add_friction_at_rest(at, values, &mut gradient);
        gradient
    }

    /// ∇s of all elements of the effective potential: coordinates, each once, and entries. All that s
    /// depends on is there, also where the entry happens to be zero.
    pub(crate) fn slopes<S: Scalar>(&self, at: &[S], values: &Values<S>) -> Vec<Vec<(usize, S)>> {
        if let Some((at, wide)) = values.wide(at) {
            let rows = self.slopes(&at, wide).into_iter();
            let narrowed = |(place, slope)| Some((place, S::from_wide(&slope)?));
            return rows.map(|row| row.into_iter().filter_map(narrowed).collect()).collect();
        }
        let mut rows = Vec::new();
        let zero = S::from_number(&Number::ZERO, values.precision);
        self.run(Part::Force, at, values, |family, instance, numbers, _| {
            let coordinates = family.terms.coordinates_of(instance);
            let mut rest = numbers;
            for element in &family.potential {
                let (_, slopes) = head(&mut rest, 1, element.slope.len());
                let mut row = element.slopes(coordinates, slopes);
                for place in element.curvature.iter().flat_map(|(a, b, _)| [*a, *b]) {
                    let coordinate = coordinates[place] as usize;
                    if row.iter().all(|(other, _)| *other != coordinate) {
                        row.push((coordinate, zero.clone()));
                    }
                }
                rows.push(row);
            }
        });
        rows
    }

    /// The stiffness matrix, dense, column by column.
    pub(crate) fn stiffness<S: Scalar>(&self, at: &[S], values: &Values<S>) -> Vec<S> {
        self.matrix(Part::Stiffness, at, values)
    }

    /// The mass matrix, dense, column by column.
    pub(crate) fn mass<S: Scalar>(&self, at: &[S], values: &Values<S>) -> Vec<S> {
        self.matrix(Part::Inertia, at, values)
    }

    fn matrix<S: Scalar>(&self, part: Part, at: &[S], values: &Values<S>) -> Vec<S> {
        let n = self.dimension;
        let mut matrix = vec![S::from_number(&Number::from(0), values.precision); n * n];
        self.entries(part, at, values, |i, j, value| {
            let entry = &mut matrix[i as usize + n * j as usize];
            *entry = entry.add(value);
        });
        for j in 0..n {
            for i in 0..j {
                matrix[i + n * j] = matrix[j + n * i].clone();
            }
        }
        matrix
    }

    /// What adds up to the lower triangle of M or K: row, column and share, often several for one entry.
    pub(super) fn entries<S: Scalar>(
        &self,
        part: Part,
        at: &[S],
        values: &Values<S>,
        mut share: impl FnMut(u32, u32, &S),
    ) {
        if let Some((at, wide)) = values.wide(at) {
            let narrowed: &mut dyn FnMut(u32, u32, &Big) = &mut |i, j, own| {
                if let Some(own) = S::from_wide(own) {
                    share(i, j, &own);
                }
            };
            self.entries(part, &at, wide, narrowed);
            return;
        }
        self.run(part, at, values, |family, instance, numbers, _| {
            let coordinates = family.terms.coordinates_of(instance);
            // Into the lower triangle.
            family.shares(part, numbers, |a, b, value, both| {
                let (i, j) = (coordinates[a], coordinates[b]);
                share(i.max(j), i.min(j), value);
                if both && i == j {
                    share(i, j, value);
                }
            });
        });
    }

    /// Whether no instance has a force, and all that adds up to M and K is 0 exactly or plain; with friction or what goes with velocities
    /// never.
    pub(super) fn rests_plainly<S: Scalar>(&self, at: &[S], values: &Values<S>, is_plain: impl Fn(&S) -> bool) -> bool {
        let mut plain = self.velocity.is_empty() && values.wide.is_none();
        for part in [Part::Inertia, Part::Stiffness, Part::Force] {
            if !plain || part == Part::Force && self.unstressed {
                return plain;
            }
            self.run(part, at, values, |family, _, numbers, is_new| {
                if is_new && plain && part == Part::Force {
                    let mut rest = numbers;
                    for element in &family.potential {
                        let (first, slopes) = head(&mut rest, 1, element.slope.len());
                        plain &= first[0].is_exact_zero() || slopes.iter().all(Scalar::is_exact_zero);
                    }
                    plain &= rest.iter().all(Scalar::is_finite);
                } else if is_new && plain {
                    family.shares(part, numbers, |_, _, value, _| plain &= value.is_exact_zero() || is_plain(value));
                }
            });
        }
        plain
    }
}

/// Splits the next numbers off.
pub(super) fn head<'a, S>(rest: &mut &'a [S], first: usize, second: usize) -> (&'a [S], &'a [S]) {
    let (a, tail) = rest.split_at(first.min(rest.len()));
    let (b, tail) = tail.split_at(second.min(tail.len()));
    *rest = tail;
    (a, b)
}
