//! What tests of derivations have in common: models from files and texts, Lagrange's equations by brute
//! force, values of printed expressions through the parser.

#![allow(dead_code, reason = "each test file uses a part of it")]

use librate::derive::{Derivation, Motion, MotionSum};
use librate::expr::{ExprId, Pool, Symbol, Tape};
use librate::model::Model;
use librate::number::Number;
use librate::precision::{Big, Scalar};
use librate_core::expr::{Seeds, Substitution};
use librate_core::model::TermFamily;

fn written_out(model: &Model, pool: &mut Pool, families: &[TermFamily]) -> ExprId {
    let mut terms = Vec::new();
    for family in families {
        for at in 0..family.count {
            let mut map = Substitution::default();
            for (local, number) in family.locals.iter().zip(family.coordinates_of(at)) {
                let coordinate = &model.coordinates.at(*number as usize);
                let q = pool.symbol_expr(coordinate.symbol);
                let v = pool.symbol_expr(coordinate.velocity);
                map.insert(local.coordinate, q);
                map.insert(local.velocity, v);
            }
            for (symbol, value) in family.values.iter().zip(family.constants_of(at)) {
                map.insert(*symbol, *value);
            }
            terms.push(pool.substitute_one(family.body, &map));
        }
    }
    pool.sum(&terms)
}

/// The plainest way to the equations: L as one expression, the chain rule for d/dt.
pub(crate) struct BruteForce {
    pub(crate) lagrangian: ExprId,
    pub(crate) dissipation: ExprId,
    /// By coordinate.
    pub(crate) forces: Vec<ExprId>,
    coordinates: Vec<Symbol>,
    velocities: Vec<Symbol>,
    accelerations: Vec<ExprId>,
    time: Option<Symbol>,
}

impl BruteForce {
    pub(crate) fn new(model: &Model, pool: &mut Pool) -> Self {
        let kinetic = written_out(model, pool, &model.kinetic);
        let potential = written_out(model, pool, &model.potential);
        let (acting, friction): (Vec<_>, Vec<_>) = model.forces.iter().cloned().partition(|own| own.acts_on.is_some());
        let mut forces = vec![pool.zero(); model.coordinates.len()];
        for family in acting {
            for at in 0..family.count {
                let on = family.coordinates_of(at)[family.acts_on.unwrap()] as usize;
                let mut one = family.clone();
                one.count = 1;
                one.coordinates = family.coordinates_of(at).to_vec();
                one.constants = family.constants_of(at).to_vec();
                let force = written_out(model, pool, &[one]);
                forces[on] = pool.add(forces[on], force);
            }
        }
        let symbols = model.coordinates.iter();
        let (coordinates, velocities) = symbols.map(|c| (c.symbol, c.velocity)).unzip();
        let accelerations = (0..model.coordinates.len())
            .map(|i| {
                let symbol = pool.fresh_symbol(&format!("a{i}"));
                pool.symbol_expr(symbol)
            })
            .collect();
        Self {
            lagrangian: pool.sub(kinetic, potential),
            dissipation: written_out(model, pool, &friction),
            forces,
            coordinates,
            velocities,
            accelerations,
            time: model.symbols.time(),
        }
    }

    /// The symbol of an acceleration.
    pub(crate) fn acceleration(&self, pool: &Pool, i: usize) -> Symbol {
        pool.as_symbol(self.accelerations[i]).unwrap()
    }

    /// The total time derivative.
    pub(crate) fn rate(&self, pool: &mut Pool, e: ExprId) -> ExprId {
        let mut seeds = Seeds::default();
        for i in 0..self.coordinates.len() {
            let velocity = pool.symbol_expr(self.velocities[i]);
            seeds.insert(self.coordinates[i], velocity);
            seeds.insert(self.velocities[i], self.accelerations[i]);
        }
        if let Some(time) = self.time {
            seeds.insert(time, pool.one());
        }
        pool.derivation(&[e], &seeds)[0]
    }

    pub(crate) fn momentum(&self, pool: &mut Pool, i: usize) -> ExprId {
        pool.diff(self.lagrangian, self.velocities[i])
    }

    pub(crate) fn equation(&self, pool: &mut Pool, i: usize) -> ExprId {
        let momentum = self.momentum(pool, i);
        let rate = self.rate(pool, momentum);
        let force = pool.diff(self.lagrangian, self.coordinates[i]);
        let friction = pool.diff(self.dissipation, self.velocities[i]);
        let difference = pool.sub(rate, force);
        let left = pool.add(difference, friction);
        pool.sub(left, self.forces[i])
    }

    pub(crate) fn explicit_rate(&self, pool: &mut Pool) -> ExprId {
        match self.time {
            Some(time) => pool.diff(self.lagrangian, time),
            None => pool.zero(),
        }
    }

    pub(crate) fn velocity(&self, pool: &mut Pool, i: usize) -> ExprId {
        pool.symbol_expr(self.velocities[i])
    }

    /// A sum of the derivation in the symbols used here, momenta replaced by what they are.
    pub(crate) fn expression(&self, pool: &mut Pool, sum: &MotionSum, momenta: &[ExprId]) -> ExprId {
        sum.expression(pool, |pool, motion| match motion {
            Motion::Acceleration(i) => self.accelerations[i],
            Motion::Velocity(i) => pool.symbol_expr(self.velocities[i]),
            Motion::Momentum(i) => momenta[i],
            other => panic!("{other:?} in an equation of motion"),
        })
    }
}

/// The names in a text of the language with their indices and primes replaced by others: `th[1]''`.
fn renamed(text: &str, new: &dyn Fn(&str, usize) -> Option<String>) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::new();
    let mut at = 0;
    while at < chars.len() {
        if !(chars[at].is_alphabetic() || chars[at] == '_') {
            // Digits may not run into a name: 1e5 has none.
            let number = chars[at].is_ascii_digit();
            out.push(chars[at]);
            at += 1;
            while number && at < chars.len() && (chars[at].is_alphanumeric() || chars[at] == '.') {
                out.push(chars[at]);
                at += 1;
            }
            continue;
        }
        let start = at;
        while at < chars.len() && (chars[at].is_alphanumeric() || chars[at] == '_') {
            at += 1;
        }
        if chars.get(at) == Some(&'[') {
            while chars[at] != ']' {
                at += 1;
            }
            at += 1;
        }
        let name: String = chars[start..at].iter().collect();
        let mut primes = 0;
        while chars.get(at) == Some(&'\'') {
            primes += 1;
            at += 1;
        }
        match new(&name, primes) {
            Some(new) => out.push_str(&new),
            None => {
                assert_eq!(primes, 0, "{name} in {text}");
                out.push_str(&name);
            }
        }
    }
    out
}

/// The values of printed expressions at a point, through the parser: the model's parameters have their
/// values, coordinates and their derivatives those of `point[primes][coordinate]` (in decimal).
pub(crate) fn values(model: &Model, texts: &[String], point: &[Vec<String>; 3], bits: usize) -> Vec<Big> {
    let mut file = String::from("coord z\nT = z'^2\n");
    for (k, parameter) in model.parameters.iter().enumerate() {
        let value = model.pool.display(parameter.value.unwrap());
        file.push_str(&format!("param par_{k} = {value}\n"));
    }
    for (primes, values) in point.iter().enumerate() {
        for (k, value) in values.iter().enumerate() {
            file.push_str(&format!("param q_{primes}_{k} = {value}\n"));
        }
    }
    let new = |name: &str, primes: usize| {
        let coordinate = model.coordinates.names().position(|own| own == name);
        let parameter = model.parameters.iter().position(|p| p.name == name);
        match (coordinate, parameter) {
            (Some(k), _) => Some(format!("q_{primes}_{k}")),
            (None, Some(k)) if primes == 0 => Some(format!("par_{k}")),
            _ => None,
        }
    };
    for (k, text) in texts.iter().enumerate() {
        file.push_str(&format!("param value_{k} = {}\n", renamed(text, &new)));
    }
    let read = crate::common::model(&file);
    let roots: Vec<ExprId> = (0..texts.len())
        .map(|k| {
            let name = format!("value_{k}");
            let parameter = read.parameters.iter().find(|p| p.name == name).unwrap();
            parameter.value.unwrap()
        })
        .collect();
    let tape = Tape::compile(&read.pool, &roots, &[]).unwrap();
    tape.prepare::<Big>(bits).evaluate(&[], &mut Vec::new())
}

/// A decimal number of any length.
pub(crate) fn decimal(text: &str, bits: usize) -> Big {
    match text.strip_prefix('-') {
        Some(digits) => Big::from_number(&Number::parse(digits).unwrap(), bits).neg(),
        None => Big::from_number(&Number::parse(text).unwrap(), bits),
    }
}

/// The left sides as printed, without `= 0`.
pub(crate) fn left_sides(derivation: &Derivation) -> Vec<String> {
    let texts = derivation.equation_texts();
    let texts = texts.iter();
    texts.map(|text| text.strip_suffix(" = 0").unwrap().to_owned()).collect()
}
