//! A derivation held against what a person wrote down, part by part and up to algebraic equality: for
//! users' own tests.
//!
//! An expected part is text in the model language, as it stands in a book or in one's notes; the
//! derivation may write it differently. Where the two are not the same, [`Mismatches`] shows both. Names
//! are those of the model's parameters and coordinates; `x'` is a velocity, `x''` an acceleration, `p_x` a
//! momentum and, where the equilibrium is not 0, `delta_x` a displacement.
//!
//! ```
//! use librate::derive::{Parts, derive};
//! use librate::{assert_derives, model, syntax};
//!
//! let text = "param g  param l  param m  coord phi
//!     T = 1/2*m*l^2*phi'^2
//!     V = m*g*l*(1 - cos(phi))";
//! let file = syntax::parse(text)?;
//! let model = model::elaborate(&file, &Default::default(), &Default::default())?;
//! let derivation = derive(&model, &Parts::all())?;
//! assert_derives!(
//!     &derivation,
//!     mass = "[[m*l^2]]",
//!     stiffness = "[[m*g*l]]",
//!     equations = ["phi'' = -(g/l)*sin(phi)"],
//!     hamiltonian = "p_phi^2/(2*m*l^2) + 2*m*g*l*sin(phi/2)^2",
//!     frequencies = ["g/l"],
//! );
//! # Ok::<(), librate::Error>(())
//! ```
//!
//! *Compares and nothing else: what is expected changes nothing in the derivation.*

mod equal;
mod mismatch;
mod read;

use std::collections::BTreeMap;

use librate_core::derive::{Derivation, Frequencies, Linear, Motion, MotionSum, Names, SecondOrder};
use librate_core::expr::{ExprId, Pool, Substitution};

pub use equal::are_equal;
use equal::same_equation;
pub use mismatch::{Mismatch, Mismatches};
use read::{Reader, Written};

/// The parts: what they are, the name of each and of the method of [`Expected`] for it, and whether it has one text or several.
macro_rules! parts {
    ($($(#[$about:meta])+ $part:ident $name:ident: $count:ident,)+) => {
        /// The parts of a derivation that can be expected.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub(crate) enum Part {
            $($(#[$about])+ $part,)+
        }

        impl Part {
            /// What the part is called in [`assert_derives!`](crate::assert_derives) and in messages.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$part => stringify!($name),)+
                }
            }
        }

        impl Expected {
            $(parts! { $count $(#[$about])+ $part $name })+
        }
    };
    (one $(#[$about:meta])+ $part:ident $name:ident) => {
        $(#[$about])+
        #[must_use]
        pub fn $name(self, text: impl AsRef<str>) -> Self {
            self.with(Part::$part, [text])
        }
    };
    (several $(#[$about:meta])+ $part:ident $name:ident) => {
        $(#[$about])+
        #[must_use]
        pub fn $name(self, texts: impl IntoIterator<Item = impl AsRef<str>>) -> Self {
            self.with(Part::$part, texts)
        }
    };
}

parts! {
    /// The equilibrium, one value a coordinate.
    Equilibrium equilibrium: several,
    /// M, `[[a, b], [b, c]]`.
    Mass mass: one,
    /// K, `[[a, b], [b, c]]`.
    Stiffness stiffness: one,
    /// Lagrange's equations, one a coordinate, `left = right`; each may be divided by anything.
    Equations equations: several,
    /// The linearized equations alike, of the motions that constraints allow or massless coordinates follow.
    Linearized linearized: several,
    /// T to second order.
    Kinetic kinetic: one,
    /// V to second order (V - T0, where T has a part without velocities), without its constant.
    Potential potential: one,
    /// The momenta, one a coordinate.
    Momenta momenta: several,
    /// The energy function.
    EnergyFunction energy_function: one,
    /// The Hamiltonian.
    Hamiltonian hamiltonian: one,
    /// All closed forms of omega^2 in any order, each as often as it occurs. Where the derivation has more of them
    /// with parameters taken to be equal, these are meant.
    Frequencies frequencies: several,
    /// G, `[[a, b], [b, c]]`.
    Gyroscopic gyroscopic: one,
    /// C, `[[a, b], [b, c]]`.
    Damping damping: one,
    /// The coefficients of the characteristic polynomial, the constant first; all of them may be divided by anything.
    Characteristic characteristic: several,
    /// What has to be positive for stability, in any order.
    Stability stability: several,
}

/// What a derivation is expected to say; what is not given is not compared.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Expected {
    parts: Vec<(Part, Vec<String>)>,
}

impl Expected {
    /// Nothing is expected.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn with(mut self, part: Part, texts: impl IntoIterator<Item = impl AsRef<str>>) -> Self {
        let texts = texts.into_iter().map(|text| text.as_ref().to_owned());
        self.parts.push((part, texts.collect()));
        self
    }

    /// Compares.
    ///
    /// # Errors
    /// Everything that is not as expected. Functions beyond rational ones are compared at random points with 100
    /// digits where no identity decides.
    pub fn compare(&self, derivation: &Derivation) -> Result<(), Mismatches> {
        let mut comparison = Comparison::new(derivation);
        for (part, texts) in &self.parts {
            comparison.part(*part, texts);
        }
        if comparison.mismatches.is_empty() { Ok(()) } else { Err(Mismatches(comparison.mismatches)) }
    }
}

/// Stops a test where a [`Derivation`] is not what is expected, and shows the expected and the found parts.
///
/// The parts are the methods of [`Expected`](crate::expect::Expected): `mass`, `stiffness`, `equilibrium`, `equations`,
/// `linearized`, `kinetic`, `potential`, `momenta`, `energy_function`, `hamiltonian`, `frequencies`, `gyroscopic`, `damping`,
/// `characteristic`, `stability`.
///
/// # Panics
/// Where anything differs.
#[macro_export]
macro_rules! assert_derives {
    ($derivation:expr, $($part:ident = $expected:expr),+ $(,)?) => {
        if let ::std::result::Result::Err(mismatches) =
            $crate::expect::Expected::new()$(.$part($expected))+.compare($derivation)
        {
            ::std::panic!("{mismatches}");
        }
    };
}

/// What is found for an expected text: its place, and the value.
struct Found {
    place: String,
    value: ExprId,
    text: String,
}

struct Comparison<'a> {
    derivation: &'a Derivation,
    pool: Pool,
    reader: Reader,
    mismatches: Vec<Mismatch>,
}

impl<'a> Comparison<'a> {
    fn new(derivation: &'a Derivation) -> Self {
        let mut pool = derivation.reduced().pool.clone();
        let mut names: BTreeMap<String, ExprId> = derivation.symbols.clone();
        for own in [&derivation.names, &derivation.reduced().names] {
            for i in 0..own.coordinates.len() {
                let all = [Motion::Acceleration(i), Motion::Velocity(i), Motion::Momentum(i), Motion::Displacement(i)];
                for name in all.into_iter().flat_map(|motion| [own.of(motion), own.displaced(motion)]) {
                    // Displacements from 0 are the coordinates themselves.
                    names.entry(name).or_insert_with_key(|name| {
                        let symbol = pool.fresh_symbol(name);
                        pool.symbol_expr(symbol)
                    });
                }
            }
        }
        Self { derivation, pool, reader: Reader { names }, mismatches: Vec::new() }
    }

    fn part(&mut self, part: Part, texts: &[String]) {
        match self.found(part) {
            Err(reason) => self.mismatches.push(Mismatch::NotThere { part: part.name(), reason }),
            Ok(found) => match part {
                Part::Mass | Part::Stiffness | Part::Gyroscopic | Part::Damping => self.matrix(part, texts, &found),
                Part::Frequencies => {
                    let ties = self.ties();
                    self.in_any_order(part, texts, &found, &ties);
                }
                Part::Stability => self.in_any_order(part, texts, &found, &Substitution::new()),
                Part::Characteristic => self.proportional(texts, &found),
                Part::Equations | Part::Linearized => self.one_by_one(part, texts, &found, true),
                Part::Equilibrium
                | Part::Kinetic
                | Part::Potential
                | Part::Momenta
                | Part::EnergyFunction
                | Part::Hamiltonian => self.one_by_one(part, texts, &found, false),
            },
        }
    }

    /// What the derivation has of a part, or why it has nothing.
    fn found(&mut self, part: Part) -> Result<Vec<Found>, String> {
        let derivation = self.derivation;
        Ok(match part {
            Part::Equilibrium => {
                let values = linear(derivation)?.equilibrium.iter();
                let named = derivation.names.coordinates.iter().zip(values);
                named.map(|(name, value)| self.plain(format!("equilibrium of {name}"), *value)).collect()
            }
            Part::Mass => self.entries(part, &linear(derivation)?.mass),
            Part::Stiffness => self.entries(part, &linear(derivation)?.stiffness),
            Part::Equations => self.sums("equation of", asked(derivation.equations.as_ref())?, false),
            Part::Linearized => self.sums("linearized equation of", &second_order(derivation)?.equations, true),
            Part::Kinetic => vec![self.sum(part.name(), &second_order(derivation)?.kinetic, true)],
            Part::Potential => vec![self.sum(part.name(), &second_order(derivation)?.potential, true)],
            Part::Momenta => self.sums("momentum of", &asked(derivation.energy.as_ref())?.momenta, false),
            Part::EnergyFunction => vec![self.sum(part.name(), &asked(derivation.energy.as_ref())?.function, false)],
            Part::Hamiltonian => {
                let sum = asked(derivation.energy.as_ref())?.hamiltonian.as_ref();
                let sum = sum.ok_or("the inertia is neither diagonal nor two by two")?;
                vec![self.sum(part.name(), sum, false)]
            }
            Part::Frequencies => {
                let linear = linear(derivation.reduced())?;
                let case =
                    linear.frequencies.as_ref().map(Frequencies::best).filter(|case| !case.frequencies.is_empty());
                match (case, &linear.exponents) {
                    (Some(case), _) => {
                        let all = case.frequencies.iter();
                        let all = all.flat_map(|f| std::iter::repeat_n(f.omega_squared, f.multiplicity));
                        all.map(|value| self.plain(part.name(), value)).collect()
                    }
                    // Of gyroscopic models.
                    (None, Some(own)) if linear.damping.is_none() && !own.exponents.is_empty() => {
                        let all = own.squares_of_frequencies(&mut self.pool).into_iter();
                        let all = all.flat_map(|(text, multiplicity)| std::iter::repeat_n(text, multiplicity));
                        let found = |text: String| {
                            let value = self.reader.expression(&mut self.pool, &text)?;
                            Ok(Found { place: part.name().to_owned(), value, text })
                        };
                        all.map(found).collect::<Result<_, String>>()?
                    }
                    (None, _) => return Err("there are no closed forms".to_owned()),
                }
            }
            Part::Gyroscopic | Part::Damping => {
                let linear = linear(derivation)?;
                let rows = if part == Part::Damping { &linear.damping } else { &linear.gyroscopic };
                self.entries(part, rows.as_ref().ok_or("it is 0")?)
            }
            Part::Characteristic => {
                let own = asked(linear(derivation.reduced())?.exponents.as_ref())?;
                let values = own.characteristic.as_ref().ok_or("it is too long to be written out")?;
                values.iter().map(|value| self.plain(part.name(), *value)).collect()
            }
            Part::Stability => {
                let own = asked(linear(derivation.reduced())?.exponents.as_ref())?;
                let conditions = own.stability.as_ref().ok_or("there are no conditions")?;
                conditions.iter().map(|own| self.plain(part.name(), own.positive)).collect()
            }
        })
    }

    fn plain(&self, place: impl Into<String>, value: ExprId) -> Found {
        Found { place: place.into(), value, text: self.derivation.reduced().pool.display(value) }
    }

    fn entries(&self, part: Part, rows: &[Vec<ExprId>]) -> Vec<Found> {
        let mut all = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let place = format!("{}[{}, {}]", part.name(), i + 1, j + 1);
                all.push(self.plain(place, *value));
            }
        }
        all
    }

    fn sum(&mut self, place: impl Into<String>, sum: &MotionSum, displaced: bool) -> Found {
        let names = self.names(displaced);
        let name = |motion| {
            if displaced { names.displaced(motion) } else { names.of(motion) }
        };
        let reader = &self.reader;
        let value = sum.expression(&mut self.pool, |pool, motion| {
            reader.names.get(&name(motion)).copied().unwrap_or_else(|| pool.undefined())
        });
        Found { place: place.into(), value, text: sum.text(&self.derivation.reduced().pool, name) }
    }

    /// Those of displacements are of the motions that constraints allow, or that massless coordinates follow.
    fn names(&self, displaced: bool) -> &'a Names {
        if displaced { &self.derivation.reduced().names } else { &self.derivation.names }
    }

    fn sums(&mut self, place: &str, sums: &[MotionSum], displaced: bool) -> Vec<Found> {
        let names = self.names(displaced).coordinates.iter();
        names.zip(sums).map(|(name, sum)| self.sum(format!("{place} {name}"), sum, displaced)).collect()
    }

    /// What was read of a text; notes where that was nothing.
    fn readable<T>(&mut self, place: &str, text: &str, read: Result<T, String>) -> Option<T> {
        let unreadable = |message| Mismatch::Unreadable { part: place.to_owned(), text: text.to_owned(), message };
        read.map_err(|message| self.mismatches.push(unreadable(message))).ok()
    }

    fn differs(&mut self, place: &str, expected: &str, found: &str) {
        self.mismatches.push(Mismatch::Differs {
            part: place.to_owned(),
            expected: expected.to_owned(),
            found: found.to_owned(),
        });
    }

    fn matrix(&mut self, part: Part, texts: &[String], found: &[Found]) {
        for text in texts {
            let read = self.reader.rows(&mut self.pool, text);
            let Some(rows) = self.readable(part.name(), text, read) else { continue };
            let side = self.derivation.names.coordinates.len();
            if rows.len() != side || rows.iter().any(|row| row.len() != side) {
                let wide = rows.iter().map(Vec::len).max().unwrap_or(0);
                self.differs(part.name(), &format!("{} by {wide}", rows.len()), &format!("{side} by {side}"));
                continue;
            }
            for (Written { value, text }, found) in rows.into_iter().flatten().zip(found) {
                if !are_equal(&mut self.pool, value, found.value) {
                    self.differs(&found.place, &text, &found.text);
                }
            }
        }
    }

    fn one_by_one(&mut self, part: Part, texts: &[String], found: &[Found], is_equation: bool) {
        if texts.len() != found.len() {
            return self.differs(part.name(), &texts.len().to_string(), &found.len().to_string());
        }
        for (text, found) in texts.iter().zip(found) {
            let read = if is_equation {
                self.reader.equation(&mut self.pool, text)
            } else {
                self.reader.expression(&mut self.pool, text)
            };
            let Some(value) = self.readable(&found.place, text, read) else { continue };
            let is_same = if is_equation {
                let accelerations = self.accelerations();
                same_equation(&mut self.pool, &accelerations, value, found.value)
            } else {
                are_equal(&mut self.pool, value, found.value)
            };
            if !is_same {
                let end = if is_equation { " = 0" } else { "" };
                self.differs(&found.place, text, &format!("{}{end}", found.text));
            }
        }
    }

    /// The symbols of accelerations, of displacements too.
    fn accelerations(&self) -> Vec<ExprId> {
        let names = &self.derivation.names;
        let count = names.coordinates.len();
        let all = (0..count).flat_map(|i| {
            let motion = Motion::Acceleration(i);
            [names.of(motion), names.displaced(motion)]
        });
        all.filter_map(|name| self.reader.names.get(&name).copied()).collect()
    }

    /// The same but for a common factor.
    fn proportional(&mut self, texts: &[String], found: &[Found]) {
        let place = Part::Characteristic.name();
        let read = texts.iter().map(|text| self.reader.expression(&mut self.pool, text));
        let read = read.collect::<Result<Vec<ExprId>, String>>();
        let Some(values) = self.readable(place, &texts.join(", "), read) else { return };
        let (Some(last), Some(of_found), true) = (values.last(), found.last(), values.len() == found.len()) else {
            return self.differs(place, &values.len().to_string(), &found.len().to_string());
        };
        for ((text, value), found) in texts.iter().zip(&values).zip(found) {
            let (left, right) = (self.pool.mul(*value, of_found.value), self.pool.mul(found.value, *last));
            if !are_equal(&mut self.pool, left, right) {
                self.differs(place, text, &found.text);
            }
        }
    }

    /// Each expected one is to be found, and each found one expected.
    fn in_any_order(&mut self, part: Part, texts: &[String], found: &[Found], ties: &Substitution) {
        let place = part.name();
        let mut left: Vec<&Found> = found.iter().collect();
        let mut missing: Vec<&str> = Vec::new();
        for text in texts {
            let read = self.reader.expression(&mut self.pool, text);
            let Some(value) = self.readable(place, text, read) else { continue };
            let value = self.pool.substitute_one(value, ties);
            match left.iter().position(|found| are_equal(&mut self.pool, value, found.value)) {
                Some(at) => {
                    left.remove(at);
                }
                None => missing.push(text),
            }
        }
        if !missing.is_empty() || !left.is_empty() {
            let or_none = |texts: Vec<&str>| match texts.as_slice() {
                [] => "no more".to_owned(),
                _ => texts.join("\n            "),
            };
            let left = left.iter().map(|found| found.text.as_str()).collect();
            self.differs(place, &or_none(missing), &or_none(left));
        }
    }

    /// Parameters that are taken to be equal, by the first of each set.
    fn ties(&mut self) -> Substitution {
        let mut map = Substitution::new();
        let linear = self.derivation.reduced().linear.as_ref().ok();
        let Some(frequencies) = linear.and_then(|linear| linear.frequencies.as_ref()) else { return map };
        for set in &frequencies.best().ties {
            let mut members = set.iter().map(|name| {
                let plain = name.strip_prefix('-');
                (plain.is_some(), self.reader.names.get(plain.unwrap_or(name)).copied())
            });
            let Some((_, Some(leader))) = members.next() else { continue };
            for (negative, value) in members {
                if let Some(symbol) = value.and_then(|value| self.pool.as_symbol(value)) {
                    let image = if negative { self.pool.neg(leader) } else { leader };
                    map.insert(symbol, image);
                }
            }
        }
        map
    }
}

fn linear(derivation: &Derivation) -> Result<&Linear, String> {
    derivation.linear.as_ref().map_err(|error| format!("there are no mass and stiffness matrices: {error}"))
}

fn second_order(derivation: &Derivation) -> Result<&SecondOrder, String> {
    asked(linear(derivation.reduced())?.second_order.as_ref())
}

fn asked<T>(part: Option<T>) -> Result<T, String> {
    part.ok_or_else(|| "it was not asked for".to_owned())
}
