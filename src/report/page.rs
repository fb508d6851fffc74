//! A derivation as a page: what is on it, in order. How it is written is the business of `plain`, `latex`, `html` and
//! `typst`.

use super::Written;
use super::constraints::{
    FOLLOWS_TITLE, REDUCED_TITLE, constraint_texts, constraints_title, direction_texts, displacements_title,
    follow_texts, multiplier_texts, reduced_texts, unsolved,
};
use super::exponents::{exponent_parts, imaginary_unit, unit_note};
use super::frequencies::{frequency_parts, signs};
use super::runs::{ends, gathered};
use librate_core::budget::Exceeded;
use librate_core::derive::{
    Condition, Conserved, Definition, Derivation, Energy, Given, Linear, Motion, Names, Root, SecondOrder,
};
use librate_core::diagnostic::Diagnostic;
use librate_core::expr::ExprId;
use librate_core::linearize::LinearizeError;
use librate_core::number::Number;
use librate_core::order::{Gather, Order};
use librate_core::oscillation::{NormalMode, NormalModes};
use librate_core::typeset::{self, Formula, Notation};

/// The momenta and energies of more coordinates than this are not written out.
const MOST_FOR_ENERGIES: usize = 12;
/// Matrices of more columns than this are given by their entries.
const MOST_COLUMNS: usize = 40;
/// What takes more characters of the model language is left out, unless one asks for chapters.
const MOST_IN_CHAPTER: usize = 20_000;
/// Digits of the frequencies at the end.
const DIGITS: usize = 10;

/// Words with names and short formulas of the model language between backticks.
pub(super) type Words = String;

/// A page.
pub(super) struct Page {
    /// What its names stand for.
    pub(super) notation: Notation,
    /// The name of the model.
    pub(super) model: Option<String>,
    /// How many coordinates there are.
    pub(super) dimension: usize,
    pub(super) parts: Vec<Part>,
}

/// What a page consists of; formulas are in the model language.
pub(super) enum Part {
    /// `title: a, b`
    List(Words, Vec<Words>),
    /// A heading with lines below.
    Section(Words, Vec<Line>, Form),
    Matrix(Matrix),
    Paragraph(Words),
    /// What follows is something else, though without a heading.
    Gap,
}

impl Part {
    /// A chapter that nobody would read is named instead.
    fn shorten(&mut self) {
        let (title, length) = match self {
            Self::Section(title, lines, _) => (&*title, lines.iter().map(Line::length).sum()),
            Self::Matrix(matrix) => (&matrix.title, matrix.length()),
            Self::List(..) | Self::Paragraph(_) | Self::Gap => return,
        };
        if length > MOST_IN_CHAPTER {
            let why = format!(
                "{title}: too long for a page with {length} characters; --only has single chapters, and the JSON all"
            );
            *self = Self::Paragraph(why);
        }
    }
}

/// How the lines of a section follow each other.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// High ones set apart.
    Apart,
    Close,
    /// Behind the title where they are short.
    Inline,
}

/// A line of a section.
pub(super) enum Line {
    /// A relation or formula with a remark behind it.
    Formula(String, Words),
    /// The same, in words: a formula and what is said about it.
    Item(String, Words),
    Words(Words),
    /// A matrix that belongs to the words before.
    Below(Matrix),
}

impl Line {
    /// How many characters it takes in the model language.
    fn length(&self) -> usize {
        match self {
            Self::Formula(text, words) | Self::Item(text, words) => text.len() + words.len(),
            Self::Words(words) => words.len(),
            Self::Below(matrix) => matrix.length(),
        }
    }

    pub(super) fn plain(text: String) -> Self {
        Self::Formula(text, String::new())
    }
}

/// A matrix with its letter.
pub(super) struct Matrix {
    pub(super) title: Words,
    pub(super) letter: String,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// What is not zero: where entries are symmetric and many, on the diagonal and above.
    pub(super) entries: Vec<(usize, usize, String)>,
}

impl Matrix {
    pub(super) fn new(title: &str, letter: String, rows: &[Vec<ExprId>], derivation: &Derivation) -> Self {
        let pool = &derivation.pool;
        let columns = rows.first().map_or(0, Vec::len);
        let is_shown = |i: usize, j: usize, at: ExprId| {
            (columns <= MOST_COLUMNS || j >= i || symmetry_of(&letter).1)
                && !pool.as_number(at).is_some_and(Number::is_zero)
        };
        let mut entries = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            let shown = row.iter().enumerate().filter(|(j, at)| is_shown(i, *j, **at));
            entries.extend(shown.map(|(j, at)| (i, j, pool.display(*at))));
        }
        Self { title: title.to_owned(), letter, rows: rows.len(), columns, entries }
    }

    fn length(&self) -> usize {
        let all = self.entries.iter().map(|(.., text)| text.len()).sum();
        if all <= MOST_IN_CHAPTER { all } else { self.listed().1.iter().map(Line::length).sum() }
    }

    /// All entries, row by row; nothing where there are too many.
    pub(super) fn dense(&self) -> Option<Vec<Vec<&str>>> {
        let mut rows = vec![vec!["0"; self.columns]; self.rows];
        for (i, j, text) in &self.entries {
            *rows.get_mut(*i)?.get_mut(*j)? = text;
        }
        (self.columns <= MOST_COLUMNS).then_some(rows)
    }

    /// `M = ...`; nothing where there are more columns than so many.
    pub(super) fn formula(&self, notation: &Notation, most_columns: usize) -> Option<Formula> {
        let rows = self.dense().filter(|_| self.columns <= most_columns)?;
        let rows = rows.iter().map(|row| row.iter().map(|text| notation.relation(text)).collect());
        Some(Formula::equation(notation.symbol(&self.letter), Formula::Matrix(rows.collect())))
    }

    /// What is said about the entries, and these as relations, the upper triangle standing for both.
    pub(super) fn listed(&self) -> (&'static str, Vec<Line>) {
        let (remark, all) = symmetry_of(&self.letter);
        let mut shown: Vec<_> = self.entries.iter().filter(|(i, j, _)| all || j >= i).collect();
        let lines = |shown: &[&(usize, usize, String)]| {
            gathered(shown.iter().map(|(i, j, text)| format!("{}[{}, {}] = {text}", self.letter, i + 1, j + 1)))
        };
        let by_row = lines(&shown);
        if by_row.len() == shown.len() {
            return (remark, by_row);
        }
        shown.order_by_key(|(i, j, _)| (j.abs_diff(*i), j < i, *i));
        let by_diagonal = lines(&shown);
        (remark, if by_diagonal.len() < by_row.len() { by_diagonal } else { by_row })
    }
}

/// What the entries of a matrix above the diagonal tell about those below, and whether all are written.
fn symmetry_of(letter: &str) -> (&'static str, bool) {
    match letter.trim_end_matches("_r") {
        "M" | "K" | "C" => ("symmetric; ", false),
        "G" => ("skew; ", false),
        _ => ("", true),
    }
}

/// What the budget has left out of a derivation.
pub fn left_out(exceeded: &Exceeded) -> Diagnostic {
    let own = Diagnostic::from(exceeded);
    let remark = Diagnostic::remark(format!("{}: what would follow is left out", own.message));
    remark.with_help(format!("{}; with `--only` other chapters are not worked out", own.help.unwrap_or_default()))
}

/// Words, in which units are as books have them, with what is between backticks written by another function.
pub(super) fn words(text: &str, plain: impl Fn(&str) -> String, formula: impl Fn(&str) -> String) -> String {
    let parts = text.split('`').enumerate();
    parts.map(|(at, part)| if at % 2 == 0 { plain(&typeset::unit(part)) } else { formula(part) }).collect()
}

/// With a capital letter at the beginning.
pub(super) fn capitalized(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().into_iter().flat_map(char::to_uppercase).chain(rest).collect()
}

/// Between backticks.
pub(super) fn ticked<T: AsRef<str>>(names: impl IntoIterator<Item = T>) -> Vec<Words> {
    names.into_iter().map(|name| format!("`{}`", name.as_ref())).collect()
}

/// `, with ...` behind a heading.
pub(super) fn with(assumed: &[Words]) -> Words {
    if assumed.is_empty() { String::new() } else { format!(", with {}", assumed.join(", ")) }
}

pub(super) fn section(title: &str, texts: impl IntoIterator<Item = String>) -> Part {
    Part::Section(title.to_owned(), gathered(texts), Form::Apart)
}

impl Page {
    /// The page of a derivation: Lagrange's equations, momenta and what is conserved, the equilibrium, T and V to second order, M,
    /// K, the linearized equations, symmetry and closed forms of the frequencies. What would be repeated too often is given a
    /// name at the top.
    pub(super) fn new(derivation: &Derivation) -> Self {
        let abbreviated = derivation.abbreviated();
        let (derivation, definitions) = match &abbreviated {
            Some((derivation, definitions)) => (derivation, definitions.as_slice()),
            None => (derivation, [].as_slice()),
        };
        let mut page = Self {
            notation: notation(derivation, definitions),
            model: derivation.model.clone(),
            dimension: derivation.names.coordinates.len(),
            parts: vec![Part::List("coordinates".to_owned(), ends(ticked(&derivation.names.coordinates)))],
        };
        if !derivation.assumptions.is_empty() {
            page.parts.push(Part::List("assumed".to_owned(), ticked(assumption_texts(derivation))));
        }
        if let Some(given) = derivation.given.as_ref().filter(|_| derivation.shows("model")) {
            page.given(given);
        }
        if !definitions.is_empty() {
            let texts = definitions.iter().map(|own| format!("{} = {}", own.name, own.text));
            page.parts.push(section("abbreviations", texts));
        }
        page.motion(derivation);
        page.parts.extend(derivation.shows("equilibrium").then_some(Part::Gap));
        match &derivation.linear {
            Ok(linear) => page.linear(derivation, linear),
            Err(error) => {
                // At rest they may carry what the energies leave over.
                let carried = derivation.independent.is_some();
                let without = if carried { " of the equations with multipliers" } else { "" };
                let help = match error {
                    LinearizeError::ForceOfParameters { unsigned, .. } if !unsigned.is_empty() => {
                        format!("; that is decided where `{} > 0` is assumed", unsigned[0])
                    }
                    _ => String::new(),
                };
                page.parts.push(Part::Paragraph(format!("no mass and stiffness matrices{without}: {error}{help}")));
            }
        }
        if let (Some(given), Some(modes)) = (&derivation.given, &derivation.numbers)
            && derivation.shows("numbers")
        {
            page.numbers(modes, given.has_units, &derivation.names.omega, &imaginary_unit(derivation));
        }
        if derivation.only.is_none() {
            page.parts.iter_mut().for_each(Part::shorten);
        }
        let left_out = derivation.left_out.iter().map(|own| Part::Paragraph(left_out(own).message));
        page.parts.extend(left_out);
        page
    }

    /// The energies as the file has them, and the values of the parameters.
    fn given(&mut self, given: &Given) {
        let lines = given.statements.iter().map(|(text, over)| {
            let remark = over.as_ref().map_or_else(String::new, |over| format!(", for {over}"));
            Line::Formula(text.clone(), remark)
        });
        self.parts.push(Part::Section("the model".to_owned(), lines.collect(), Form::Apart));
        if !given.values.is_empty() {
            self.parts.push(Part::Gap);
            let values = given.values.iter().map(|(text, behind)| match behind {
                Some(behind) if text.contains('=') => format!("`{text}` {behind}"),
                Some(behind) => format!("`{text}` = {behind}"),
                None => format!("`{text}`"),
            });
            self.parts.push(Part::List("values".to_owned(), values.collect()));
        }
    }

    /// The frequencies at these values; exponents where some motion grows or decays.
    fn numbers(&mut self, modes: &NormalModes, has_units: bool, letter: &str, unit: &str) {
        let are_frequencies = modes.modes.iter().all(|mode| mode.growth.is_zero());
        let is_damped = !modes.paired;
        let item = |mode: &NormalMode| {
            let [omega, growth] = Written::of_mode(mode, DIGITS).map(|own| own.digits);
            let (omega, growth) = (omega?, growth?);
            Some(match (mode.growth.is_zero(), mode.omega.is_zero()) {
                (true, true) => omega,
                (true, false) if are_frequencies => format!("`{omega}`"),
                (true, false) => format!("± `{omega}` {unit}"),
                (false, true) if is_damped => format!("`{growth}`"),
                (false, true) => format!("± `{growth}`"),
                (false, false) if is_damped => format!("`{growth}` ± `{omega}` {unit}"),
                (false, false) => format!("± `{growth}` ± `{omega}` {unit}"),
            })
        };
        // Of pairs those that grow stand for both.
        let listed = modes.modes.iter().filter(|mode| is_damped || !mode.growth.is_negative());
        let Some(items) = listed.map(item).collect::<Option<Vec<Words>>>() else { return };
        let note = unit_note(unit);
        let is_said = |part: &Part| matches!(part, Part::Section(title, ..) if title.contains(&note));
        let (what, unit) = if are_frequencies {
            (format!("`{letter}` at these values"), ", in rad/s")
        } else {
            let note = if self.parts.iter().any(is_said) { "" } else { &note };
            (format!("exponents at these values{note}"), ", in 1/s")
        };
        self.parts.push(Part::Gap);
        self.parts.push(Part::List(format!("{what}{}", if has_units { unit } else { "" }), items));
    }

    /// Equations of motion, constraints, energies, and where the force vanishes.
    fn motion(&mut self, derivation: &Derivation) {
        if derivation.equations.is_some() && derivation.shows("equations") {
            self.parts.push(section("Lagrange's equations", derivation.equation_texts()));
        }
        let constraints = constraint_texts(derivation);
        if !constraints.is_empty() && derivation.shows("constraints") {
            let lines = constraints.into_iter();
            let lines = lines.map(|(text, name)| Line::Formula(text, format!(", with the multiplier `{name}`")));
            self.parts.push(Part::Section(constraints_title(derivation), lines.collect(), Form::Apart));
        }
        if let Some(own) = derivation.independent.as_ref().filter(|_| derivation.shows("equations")) {
            let follows = follow_texts(derivation, own).into_iter().map(|(name, speed)| format!("{name} = {speed}"));
            self.parts.push(section(FOLLOWS_TITLE, follows));
            self.parts.push(section(REDUCED_TITLE, reduced_texts(derivation, own)));
        }
        if let Some(energy) = &derivation.energy {
            self.energy(derivation, energy);
        }
        if let Some(roots) = &derivation.equilibria
            && self.dimension <= MOST_FOR_ENERGIES
            && !roots.is_empty()
            && derivation.shows("equilibria")
        {
            let signs = ticked(signs(derivation, &assumed_of(roots)));
            let mut of: Vec<usize> = roots.iter().map(|root| root.coordinate).collect();
            of.dedup();
            let names = of.iter().map(|at| format!("`{}`", derivation.names.coordinates[*at]));
            let names = names.collect::<Vec<_>>().join(", ");
            let forces = match of.len() {
                all if all == self.dimension => "the force vanishes".to_owned(),
                1 => format!("the force on {names} vanishes"),
                _ => format!("the forces on {names} vanish"),
            };
            let title = format!("{forces} where{}", with(&signs));
            self.parts.push(section(&title, root_texts(derivation, roots)));
        }
    }

    fn energy(&mut self, derivation: &Derivation, energy: &Energy) {
        let names = &derivation.names;
        if self.dimension <= MOST_FOR_ENERGIES {
            if derivation.shows("momenta") {
                let momenta = energy.momenta.iter().enumerate();
                let texts =
                    momenta.map(|(i, sum)| format!("{} = {}", names.of(Motion::Momentum(i)), derivation.text(sum)));
                self.parts.push(section("momenta", texts));
            }
            if derivation.shows("hamiltonian") {
                let [_, function, hamiltonian] = &names.energies;
                let function = format!("{function} = {}", derivation.text(&energy.function));
                let own = energy.hamiltonian.iter();
                let hamiltonian = own.map(|own| format!("{hamiltonian} = {}", derivation.text(own)));
                let title =
                    if energy.hamiltonian.is_some() { "energy function and Hamiltonian" } else { "energy function" };
                self.parts.push(section(title, [function].into_iter().chain(hamiltonian)));
            }
        }
        let conserved: Vec<Line> = energy
            .conserved
            .iter()
            .map(|quantity| {
                let because = conserved_because(quantity, names);
                match quantity {
                    Conserved::Energy { is_total: Some(true) } => {
                        Line::Words(format!("the energy `T` + `V`: {because}"))
                    }
                    Conserved::Energy { .. } => Line::Words(format!("`{}`: {because}", names.energies[1])),
                    Conserved::Momentum(i) => Line::Item(names.of(Motion::Momentum(*i)), because),
                    Conserved::Motion { momenta: sum, .. } | Conserved::Integral { value: sum, .. } => {
                        Line::Item(derivation.text(sum), because)
                    }
                }
            })
            .collect();
        if !conserved.is_empty() && derivation.shows("conserved") {
            self.parts.push(Part::Section("conserved".to_owned(), conserved, Form::Apart));
        }
    }

    fn linear(&mut self, derivation: &Derivation, linear: &Linear) {
        if derivation.shows("equilibrium") {
            self.equilibrium(derivation, linear);
            let rates = derivation.rates.iter();
            let rates = rates.map(|(name, rate)| format!("{name}' = {}", derivation.pool.display(*rate)));
            self.inline("steady motion", rates.collect());
        }
        self.matrices(derivation, derivation, linear, "");
        let Some(tangent) = &linear.tangent else { return };
        if tangent.massless.is_empty() && derivation.shows("constraints") {
            let matrix = Matrix::new("gradients of the constraints", "A".to_owned(), &tangent.gradients, derivation);
            self.parts.push(Part::Matrix(matrix));
        }
        let Some(reduced) = &tangent.reduced else { return };
        if !reduced.follows.is_empty() {
            let title = displacements_title(tangent, reduced);
            self.parts.push(section(title, direction_texts(derivation, reduced)));
        }
        let own = &*reduced.derivation;
        if let Ok(linear) = &own.linear {
            let title = format!("in terms of {}", ticked(&own.names.displacements).join(", "));
            self.parts.push(section(&title, []));
            self.matrices(own, derivation, linear, "_r");
        }
    }

    /// A list of formulas behind a title.
    fn inline(&mut self, title: &str, texts: Vec<String>) {
        if !texts.is_empty() {
            let lines = texts.into_iter().map(Line::plain).collect();
            self.parts.push(Part::Section(title.to_owned(), lines, Form::Inline));
        }
    }

    /// Energies to second order, matrices, linearized equations, frequencies, exponents and stability. `suffix` stands behind the
    /// letters of the matrices.
    fn matrices(&mut self, derivation: &Derivation, whole: &Derivation, linear: &Linear, suffix: &str) {
        if !linear.signs.is_empty() {
            let signs = ticked(signs(derivation, &linear.signs));
            self.parts.push(Part::List("assumed below, from the values of the parameters".to_owned(), signs));
        }
        if let Some(part) = linear.second_order.as_ref().filter(|_| whole.shows("linearized")) {
            // The part of T that is linear in the velocities is in G.
            let kinetic = if linear.gyroscopic.is_some() { "T2" } else { "T" };
            self.second_order(derivation, part, [kinetic, potential_name(whole)]);
        }
        let both = [("mass matrix", "M", &linear.mass), ("stiffness matrix", "K", &linear.stiffness)];
        for (title, letter, rows) in both.into_iter().chain(linear.others()) {
            if whole.shows(title.trim_end_matches(" matrix")) {
                self.parts.push(Part::Matrix(Matrix::new(title, format!("{letter}{suffix}"), rows, derivation)));
            }
        }
        if linear.second_order.is_some() && linear.mass.len() <= MOST_FOR_ENERGIES && whole.shows("linearized") {
            self.parts.push(section("linearized equations", derivation.linearized_texts()));
        }
        if whole.shows("frequencies") {
            frequency_parts(derivation, linear, &mut self.parts);
        }
        self.parts.extend(exponent_parts(derivation, linear, whole));
    }

    fn second_order(&mut self, derivation: &Derivation, part: &SecondOrder, [kinetic, potential]: [&str; 2]) {
        let names = &derivation.names;
        if names.displacements != names.coordinates {
            let pairs = names.displacements.iter().zip(&names.coordinates);
            let items = pairs.map(|(displacement, name)| format!("`{displacement}` of `{name}`"));
            self.parts.push(Part::List("displacements from it".to_owned(), ends(items.collect())));
        }
        if names.coordinates.len() <= MOST_FOR_ENERGIES && !part.kinetic.terms.is_empty() {
            let both = [(kinetic, &part.kinetic), (potential, &part.potential)];
            let texts = both.map(|(name, sum)| format!("{name} = {}", derivation.displaced_text(sum)));
            self.parts.push(section(&format!("`{kinetic}` and `{potential}` to second order"), texts));
        }
    }

    fn equilibrium(&mut self, derivation: &Derivation, linear: &Linear) {
        let pool = &derivation.pool;
        let tangent = linear.tangent.as_ref().filter(|tangent| tangent.massless.is_empty());
        let multipliers = tangent.map_or_else(Vec::new, |tangent| multiplier_texts(derivation, tangent));
        if linear.equilibrium.iter().all(|at| pool.as_number(*at).is_some_and(Number::is_zero)) {
            self.parts.push(Part::List("equilibrium".to_owned(), vec!["all coordinates 0".to_owned()]));
        } else {
            let mut searched = Vec::new();
            let mut items = Vec::new();
            for (name, value) in derivation.names.coordinates.iter().zip(&linear.equilibrium) {
                let text = pool.display(*value);
                if text == *name {
                    searched.push(name.clone());
                } else {
                    items.push(format!("{name} = {text}"));
                }
            }
            searched.extend(linear.tangent.iter().flat_map(|own| unsolved(derivation, own)));
            self.inline("equilibrium", items);
            if !searched.is_empty() {
                let title = match linear.open {
                    true => "equilibrium left open, as parameters have no values; it is kept as symbols below",
                    false => "equilibrium found numerically; it is kept as symbols below",
                };
                self.parts.push(Part::List(title.to_owned(), ticked(searched)));
            }
        }
        if let Some((coordinate, force)) = &linear.at_values {
            let title = format!("it is one at these values; the force on `{coordinate}` there is");
            self.parts.push(section(&title, [force.clone()]));
        }
        self.inline("multipliers at the equilibrium", multipliers);
    }
}

/// What the names of a page stand for.
fn notation(derivation: &Derivation, definitions: &[Definition]) -> Notation {
    let names = &derivation.names;
    let notation = Notation::new(names.coordinates.iter().map(String::as_str));
    let own = definitions.iter().map(|definition| &definition.name);
    let given = derivation.given.iter().flat_map(|own| &own.names);
    notation.names(derivation.symbols.keys().chain(&names.coordinates).chain(own).chain(given).map(String::as_str))
}

/// `l > d`, one for each assumption of the model.
pub(super) fn assumption_texts(derivation: &Derivation) -> Vec<String> {
    let side = |e| derivation.pool.display(e);
    let assumptions = derivation.assumptions.iter().filter(|own| !own.follows);
    assumptions.map(|own| format!("{} {} {}", side(own.left), own.relation.sign(), side(own.right))).collect()
}

/// One line a coordinate: its possibilities, with what each needs to exist.
fn root_texts(derivation: &Derivation, roots: &[Root]) -> Vec<String> {
    let pool = &derivation.pool;
    let lines = roots.chunk_by(|a, b| a.coordinate == b.coordinate);
    lines
        .map(|roots| {
            let texts = roots.iter().map(|root| {
                let value = pool.display(root.value);
                let left = pool.display(root.left);
                let condition = root.condition.as_ref().map(|own| format!(", if {}", condition_text(derivation, own)));
                format!("{left} = {value}{}", condition.unwrap_or_default())
            });
            texts.collect::<Vec<_>>().join("; or ")
        })
        .collect()
}

/// `W^2 > g/R`
pub(super) fn condition_text(derivation: &Derivation, condition: &Condition) -> String {
    let pool = &derivation.pool;
    let sign = condition.relation.sign();
    format!("{} {sign} {}", pool.display(condition.left), pool.display(condition.right))
}

/// What the conditions take for granted, each once.
fn assumed_of(roots: &[Root]) -> Vec<(ExprId, bool)> {
    let conditions = roots.iter().filter_map(|root| root.condition.as_ref());
    conditions.flat_map(|condition| condition.signs.iter().copied()).distinct()
}

/// Why something is conserved, in words.
pub(super) fn conserved_because(quantity: &Conserved, names: &Names) -> Words {
    let [lagrangian, function, _] = &names.energies;
    let lagrangian = if lagrangian == "L" { "`L`" } else { "the Lagrangian" };
    match quantity {
        Conserved::Motion { motion, .. } => format!("{motion} leaves {lagrangian} unchanged"),
        Conserved::Momentum(i) => {
            let name = names.coordinates.get(*i).map_or("", String::as_str);
            format!("`{name}` is cyclic, only its velocity occurs in {lagrangian}")
        }
        Conserved::Integral { coordinate, .. } => {
            format!(
                "its derivative is the reduced equation of `{}`",
                names.coordinates.get(*coordinate).map_or("", String::as_str)
            )
        }
        Conserved::Energy { is_total: Some(false) } => {
            format!("the time does not occur in {lagrangian}; `{function}` is not `T` + `V`")
        }
        Conserved::Energy { .. } => format!("the time does not occur in {lagrangian}"),
    }
}

/// What has its minimum at the equilibrium: V, or V - T0 where T has a part without velocities, as rates leave one.
fn potential_name(derivation: &Derivation) -> &'static str {
    let energy = derivation.energy.as_ref();
    if !derivation.rates.is_empty() || energy.is_some_and(|energy| energy.rest_energy) { "V - T0" } else { "V" }
}
