//! The derivation to read.

use std::ops::Deref;

use unicode_width::UnicodeWidthStr;

use super::constraints::{
    FOLLOWS_TITLE, REDUCED_TITLE, constraint_texts, constraints_title, direction_texts, displacements_title,
    follow_texts, multiplier_texts, reduced_texts, unsolved,
};
use super::exponents::exponent_sections;
use super::frequencies::{frequencies_text, signs};
use super::table::{lines, plain};
use super::{Style, Tone, headline, listed};
use librate_core::derive::{
    Condition, Conserved, Definition, Derivation, Energy, Linear, Motion, Names, Relation, Root, SecondOrder,
};
use librate_core::expr::ExprId;
use librate_core::number::Number;
use librate_core::typeset::{Block, Formula, Notation};

/// The momenta and energies of more coordinates than this are not written out.
pub(super) const MOST_FOR_ENERGIES: usize = 12;

/// The derivation as text, in the order of the page: Lagrange's equations, momenta and what is
/// conserved, the equilibrium, T and V to second order, M, K, the linearized equations, symmetry and
/// closed forms of the frequencies.
///
/// What would be repeated too often is given a name at the top. Matrices have aligned columns where they fit into the width, else their entries that are not
/// zero stand one a line, with the upper triangle standing for both.
#[must_use]
pub fn derive_text(derivation: &Derivation, style: &Style) -> String {
    let abbreviated = derivation.abbreviated();
    let (derivation, definitions) = match &abbreviated {
        Some((derivation, definitions)) => (derivation, definitions.as_slice()),
        None => (derivation, [].as_slice()),
    };
    let notation = (!style.ascii).then(|| notation(derivation, definitions));
    let style = &Layout { style: *style, notation };
    let names = &derivation.names.coordinates;
    let mut out = style.paint(Tone::Heading, &headline(derivation.model.as_deref(), names.len()));
    out.push('\n');
    out.push_str(&listed("coordinates", names, style.width));
    if !derivation.assumptions.is_empty() {
        let assumed: Vec<String> = assumption_texts(derivation).iter().map(|text| style.inline(text)).collect();
        out.push_str(&listed("assumed", &assumed, style.width));
    }
    if !definitions.is_empty() {
        let texts = definitions.iter().map(definition_text);
        out.push_str(&section("with", &texts.collect::<Vec<_>>(), style));
    }
    if derivation.equations.is_some() && derivation.shows("equations") {
        out.push_str(&section("Lagrange's equations", &derivation.equation_texts(), style));
    }
    let constraints = constraint_texts(derivation);
    if !constraints.is_empty() && derivation.shows("constraints") {
        let lines = constraints.iter().map(|(text, name)| {
            let name = style.inline(name);
            style.lines_with(text, &format!(", with the multiplier {name}"))
        });
        let title = constraints_title(derivation);
        out.push_str(&set_apart(&title, &lines.collect::<Vec<_>>(), style));
    }
    if let Some(own) = derivation.independent.as_ref().filter(|_| derivation.shows("equations")) {
        let follows = follow_texts(derivation, own).into_iter().map(|(name, speed)| format!("{name} = {speed}"));
        out.push_str(&section(FOLLOWS_TITLE, &follows.collect::<Vec<_>>(), style));
        out.push_str(&section(REDUCED_TITLE, &reduced_texts(derivation, own), style));
    }
    if let Some(energy) = &derivation.energy {
        out.push_str(&energy_text(derivation, energy, style));
    }
    if let Some(roots) = &derivation.equilibria
        && names.len() <= MOST_FOR_ENERGIES
        && !roots.is_empty()
        && derivation.shows("equilibria")
    {
        let mut title = "the force vanishes where".to_owned();
        let signs = signs(derivation, &assumed_of(roots));
        if !signs.is_empty() {
            let signs: Vec<String> = signs.iter().map(|sign| style.inline(sign)).collect();
            title.push_str(&format!(", with {}", signs.join(", ")));
        }
        out.push_str(&section(&title, &root_texts(derivation, roots), style));
    }
    if derivation.shows("equilibrium") || derivation.linear.is_err() {
        out.push('\n');
    }
    match &derivation.linear {
        Ok(linear) => out.push_str(&linear_text(derivation, linear, style)),
        Err(error) => out.push_str(&format!("no mass and stiffness matrices: {error}\n")),
    }
    out
}

/// What the names of a page stand for.
pub(super) fn notation(derivation: &Derivation, definitions: &[Definition]) -> Notation {
    let names = &derivation.names;
    let notation = Notation::new(names.coordinates.iter().map(String::as_str));
    let own = definitions.iter().map(|definition| &definition.name);
    notation.names(derivation.symbols.keys().chain(&names.coordinates).chain(own).map(String::as_str))
}

/// `l > d`, one for each assumption of the model.
pub(super) fn assumption_texts(derivation: &Derivation) -> Vec<String> {
    let side = |e| derivation.pool.display(e);
    let assumptions = derivation.assumptions.iter();
    assumptions.map(|own| format!("{} {} {}", side(own.left), own.relation.sign(), side(own.right))).collect()
}

/// `d12 = norm(r[2] - r[1])`
pub(super) fn definition_text(definition: &Definition) -> String {
    format!("{} = {}", definition.name, definition.text)
}

/// One line a coordinate: its possibilities, with what each needs to exist.
pub(super) fn root_texts(derivation: &Derivation, roots: &[Root]) -> Vec<String> {
    let pool = &derivation.pool;
    let lines = roots.chunk_by(|a, b| a.coordinate == b.coordinate);
    lines
        .map(|roots| {
            let texts = roots.iter().map(|root| {
                let value = pool.display(root.value);
                let left = pool.display(root.left);
                match &root.condition {
                    Some(condition) => {
                        format!("{left} = {value}, if {}", condition_text(derivation, condition))
                    }
                    None => format!("{left} = {value}"),
                }
            });
            texts.collect::<Vec<_>>().join("; or ")
        })
        .collect()
}

/// `W^2 > g/R`
pub(super) fn condition_text(derivation: &Derivation, condition: &Condition) -> String {
    let pool = &derivation.pool;
    let sign = match condition.relation {
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    };
    format!("{} {sign} {}", pool.display(condition.left), pool.display(condition.right))
}

/// What the conditions take for granted, each once.
pub(super) fn assumed_of(roots: &[Root]) -> Vec<(ExprId, bool)> {
    let conditions = roots.iter().filter_map(|root| root.condition.as_ref());
    let mut signs: Vec<(ExprId, bool)> = conditions.flat_map(|condition| condition.signs.iter().copied()).collect();
    signs.sort_unstable();
    signs.dedup();
    signs
}

/// How the page is laid out and what its names stand for.
pub(super) struct Layout {
    style: Style,
    /// None where the language's own notation is wanted.
    notation: Option<Notation>,
}

impl Deref for Layout {
    type Target = Style;

    fn deref(&self) -> &Style {
        &self.style
    }
}

impl Layout {
    /// A formula of the model language, in the lines that it takes; what is none, or is too wide, stays as it
    /// is.
    pub(super) fn lines(&self, text: &str) -> Vec<String> {
        self.lines_with(text, "")
    }

    /// The same with a remark behind it.
    pub(super) fn lines_with(&self, text: &str, remark: &str) -> Vec<String> {
        let width = self.width.saturating_sub(2);
        let lines = match self.formula(text) {
            Some(formula) if remark.is_empty() => formula.text(width),
            Some(formula) => {
                let block = Block::beside(&[formula.block(), Block::line(remark)]);
                if block.width() <= width {
                    block.lines().map(str::to_owned).collect()
                } else {
                    let mut lines = formula.text(width);
                    lines.push(format!("    {}", remark.trim_start()));
                    lines
                }
            }
            None => Vec::new(),
        };
        // Fractions that a terminal wraps can't be read at all.
        let fits = lines.iter().all(|line| line.width() <= width);
        if lines.is_empty() || !fits { vec![format!("{text}{remark}")] } else { lines }
    }

    /// A formula of the model language on one line; what needs more stays as it is.
    pub(super) fn inline(&self, text: &str) -> String {
        let block = self.formula(text).map(|formula| formula.block());
        match block {
            Some(block) if block.height() == 1 => block.lines().collect(),
            Some(_) | None => text.to_owned(),
        }
    }

    /// Names as symbols, and formulas of one line.
    pub(super) fn names(&self, names: &[String]) -> Vec<String> {
        names.iter().map(|name| self.inline(name)).collect()
    }

    fn formula(&self, text: &str) -> Option<Formula> {
        let notation = self.notation.as_ref()?;
        notation.read_relation(text)
    }

    /// An entry of a matrix.
    fn entry(&self, text: &str) -> Block {
        let formula = self.notation.as_ref().and_then(|notation| notation.read(text));
        formula.map_or_else(|| Block::line(text), |formula: Formula| formula.block())
    }
}

/// A heading and indented formulas.
fn section(title: &str, texts: &[String], style: &Layout) -> String {
    let formulas: Vec<Vec<String>> = texts.iter().map(|text| style.lines(text)).collect();
    set_apart(title, &formulas, style)
}

/// A heading and indented formulas, each in lines; those of several lines are set apart.
pub(super) fn set_apart(title: &str, formulas: &[Vec<String>], style: &Layout) -> String {
    let mut out = format!("\n{}\n", style.paint(Tone::Heading, title));
    let tall = formulas.iter().any(|lines| lines.len() > 1);
    for (at, lines) in formulas.iter().enumerate() {
        if tall && at > 0 {
            out.push('\n');
        }
        for line in lines {
            out.push_str(format!("  {line}").trim_end());
            out.push('\n');
        }
    }
    out
}

fn energy_text(derivation: &Derivation, energy: &Energy, style: &Layout) -> String {
    let names = &derivation.names;
    let mut out = String::new();
    if names.coordinates.len() <= MOST_FOR_ENERGIES {
        let momenta: Vec<String> = energy
            .momenta
            .iter()
            .enumerate()
            .map(|(i, sum)| {
                let name = names.of(Motion::Momentum(i));
                format!("{name} = {}", derivation.text(sum))
            })
            .collect();
        if derivation.shows("momenta") {
            out.push_str(&section("momenta", &momenta, style));
        }
        let mut functions = vec![format!("h = {}", derivation.text(&energy.function))];
        if let Some(hamiltonian) = &energy.hamiltonian {
            functions.push(format!("H = {}", derivation.text(hamiltonian)));
        }
        if derivation.shows("hamiltonian") {
            out.push_str(&section("energy function and Hamiltonian", &functions, style));
        }
    }
    let conserved: Vec<Vec<String>> = energy
        .conserved
        .iter()
        .map(|quantity| {
            let because = format!(": {}", conserved_because(quantity, names));
            match quantity {
                Conserved::Energy { .. } => {
                    vec![format!("{}{because}", conserved_name(derivation, quantity))]
                }
                Conserved::Momentum(_) | Conserved::Motion { .. } => {
                    style.lines_with(&conserved_name(derivation, quantity), &because)
                }
            }
        })
        .collect();
    if !conserved.is_empty() && derivation.shows("conserved") {
        out.push_str(&set_apart("conserved", &conserved, style));
    }
    out
}

/// What is conserved: a momentum or a sum of them in the model language, or an energy in words.
pub(super) fn conserved_name(derivation: &Derivation, quantity: &Conserved) -> String {
    match quantity {
        Conserved::Momentum(i) => derivation.names.of(Motion::Momentum(*i)),
        Conserved::Motion { momenta, .. } => derivation.text(momenta),
        Conserved::Energy { is_total: true } => "the energy T + V".to_owned(),
        Conserved::Energy { is_total: false } => "h".to_owned(),
    }
}

/// Why something is conserved, in words.
pub(super) fn conserved_because(quantity: &Conserved, names: &Names) -> String {
    match quantity {
        Conserved::Motion { motion, .. } => format!("{motion} leaves L unchanged"),
        Conserved::Momentum(i) => {
            let name = names.coordinates.get(*i).map_or("", String::as_str);
            format!("{name} is cyclic, only its velocity occurs in L")
        }
        Conserved::Energy { is_total: true } => "the time does not occur in L".to_owned(),
        Conserved::Energy { is_total: false } => "the time does not occur in L; h is not T + V".to_owned(),
    }
}

fn linear_text(derivation: &Derivation, linear: &Linear, style: &Layout) -> String {
    let mut out = String::new();
    if derivation.shows("equilibrium") {
        out.push_str(&equilibrium_text(derivation, linear, style));
        let rates = rate_texts(derivation);
        if !rates.is_empty() {
            out.push_str(&formulas("steady motion", &rates, style));
        }
    }
    let potential = potential_name(derivation);
    out.push_str(&matrices_text((derivation, derivation), linear, potential, "", style));
    out.push_str(&exponents_text(derivation, linear, derivation, style));
    let Some(tangent) = &linear.tangent else {
        return out;
    };
    if tangent.massless.is_empty() && derivation.shows("constraints") {
        out.push('\n');
        out.push_str(&matrix_text("gradients of the constraints", "A", &tangent.gradients, derivation, style));
    }
    let Some(reduced) = &tangent.reduced else {
        return out;
    };
    let page = &*reduced.derivation;
    out.push_str(&section(displacements_title(tangent), &direction_texts(derivation, reduced), style));
    if let Ok(linear) = &page.linear {
        out.push('\n');
        let names = style.names(&page.names.displacements).join(", ");
        out.push_str(&style.paint(Tone::Heading, &format!("in terms of {names}")));
        out.push('\n');
        out.push_str(&matrices_text((page, derivation), linear, potential, "_r", style));
        out.push_str(&exponents_text(page, linear, derivation, style));
    }
    out
}

/// Exponents and stability.
fn exponents_text(page: &Derivation, linear: &Linear, names: &Derivation, style: &Layout) -> String {
    let sections = exponent_sections(page, linear, names).into_iter();
    sections
        .map(|(title, lines)| {
            let lines = lines.iter().map(|(text, remark)| style.lines_with(text, remark));
            set_apart(&title, &lines.collect::<Vec<_>>(), style)
        })
        .collect()
}

/// Energies to second order, matrices, linearized equations and frequencies. `suffix` stands behind the letters of the matrices.
fn matrices_text(
    (derivation, whole): (&Derivation, &Derivation),
    linear: &Linear,
    potential: &str,
    suffix: &str,
    style: &Layout,
) -> String {
    let mut out = String::new();
    if !linear.signs.is_empty() {
        let signs = signs(derivation, &linear.signs);
        let signs: Vec<String> = signs.iter().map(|sign| style.inline(sign)).collect();
        out.push_str(&listed("assumed below, as at the values of the parameters", &signs, style.width));
    }
    if let Some(part) = &linear.second_order
        && whole.shows("linearized")
    {
        out.push_str(&second_order_text(derivation, part, potential, style));
    }
    let both = [("mass matrix", "M", &linear.mass), ("stiffness matrix", "K", &linear.stiffness)];
    for (title, letter, rows) in both.into_iter().chain(linear.others()) {
        if !whole.shows(title.trim_end_matches(" matrix")) {
            continue;
        }
        out.push('\n');
        let letter = format!("{letter}{suffix}");
        out.push_str(&matrix_text(title, &letter, rows, derivation, style));
    }
    if linear.second_order.is_some() && linear.mass.len() <= MOST_FOR_ENERGIES && whole.shows("linearized") {
        let equations = derivation.linearized_texts();
        out.push_str(&section("linearized equations", &equations, style));
    }
    if whole.shows("frequencies") {
        out.push_str(&frequencies_text(derivation, linear, style));
    }
    out
}

fn second_order_text(derivation: &Derivation, part: &SecondOrder, potential: &str, style: &Layout) -> String {
    let names = &derivation.names;
    let mut out = String::new();
    if names.displacements != names.coordinates {
        let pairs = names.displacements.iter().zip(&names.coordinates);
        let items: Vec<String> = pairs
            .map(|(displacement, name)| {
                let (displacement, name) = (style.inline(displacement), style.inline(name));
                format!("{displacement} of {name}")
            })
            .collect();
        out.push_str(&listed("displacements from it", &items, style.width));
    }
    if names.coordinates.len() <= MOST_FOR_ENERGIES {
        let title = format!("T and {potential} to second order");
        let forms = quadratic_forms(derivation, part, potential);
        out.push_str(&section(&title, &forms, style));
    }
    out
}

/// What has its minimum at the equilibrium: V, or V - T0 where T has a part without velocities, as rates leave one.
pub(super) fn potential_name(derivation: &Derivation) -> &'static str {
    let energy = derivation.energy.as_ref();
    if !derivation.rates.is_empty() || energy.is_some_and(|energy| energy.rest_energy) { "V - T0" } else { "V" }
}

/// `T = ...` and `V = ...`.
pub(super) fn quadratic_forms(derivation: &Derivation, part: &SecondOrder, potential: &str) -> [String; 2] {
    [
        format!("T = {}", derivation.displaced_text(&part.kinetic)),
        format!("{potential} = {}", derivation.displaced_text(&part.potential)),
    ]
}

fn equilibrium_text(derivation: &Derivation, linear: &Linear, style: &Layout) -> String {
    let pool = &derivation.pool;
    let zero = |at: &ExprId| pool.as_number(*at).is_some_and(Number::is_zero);
    let multipliers = linear.tangent.as_ref().filter(|tangent| tangent.massless.is_empty());
    let multipliers = multipliers.map(|tangent| multiplier_texts(derivation, tangent));
    if linear.equilibrium.iter().all(zero) {
        let mut out = "equilibrium: all coordinates 0\n".to_owned();
        if let Some(items) = multipliers {
            out.push_str(&formulas("multipliers at the equilibrium", &items, style));
        }
        return out;
    }
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
    let mut out = String::new();
    if !items.is_empty() {
        out.push_str(&formulas("equilibrium", &items, style));
    }
    if !searched.is_empty() {
        let title = "equilibrium found numerically; it is kept as symbols below";
        out.push_str(&listed(title, &style.names(&searched), style.width));
    }
    if let Some(items) = multipliers
        && !items.is_empty()
    {
        out.push_str(&formulas("multipliers at the equilibrium", &items, style));
    }
    out
}

/// `psi' = W`, one a rate of a steady motion.
pub(super) fn rate_texts(derivation: &Derivation) -> Vec<String> {
    let rates = derivation.rates.iter();
    rates.map(|(name, rate)| format!("{name}' = {}", derivation.pool.display(*rate))).collect()
}

/// A list of formulas behind a title; where some take more than one line, each in lines of its own.
fn formulas(title: &str, items: &[String], style: &Layout) -> String {
    let tall = |text: &String| {
        let formula = style.formula(text);
        formula.is_some_and(|formula| formula.block().height() > 1)
    };
    if !items.iter().any(tall) {
        listed(title, &style.names(items), style.width)
    } else if items.len() <= MOST_FOR_ENERGIES {
        let text = section(title, items, style);
        text.trim_start_matches('\n').to_owned()
    } else {
        listed(title, items, style.width)
    }
}

/// What the entries of a matrix above the diagonal tell about those below, and whether all are written.
pub(super) fn symmetry_of(letter: &str) -> (&'static str, bool) {
    match letter.trim_end_matches("_r") {
        "M" | "K" | "C" => ("symmetric; ", false),
        "G" => ("skew; ", false),
        _ => ("", true),
    }
}

fn matrix_text(title: &str, letter: &str, rows: &[Vec<ExprId>], derivation: &Derivation, style: &Layout) -> String {
    let pool = &derivation.pool;
    let zero = |at: ExprId| pool.as_number(at).is_some_and(Number::is_zero);
    let heading = style.paint(Tone::Heading, &format!("{title} {letter}"));
    // A matrix that can't fit is not written out only to be measured.
    let columns = rows.first().map_or(0, Vec::len);
    if columns * 3 <= style.width && style.notation.is_some() {
        let entries: Vec<Vec<Block>> =
            rows.iter().map(|row| row.iter().map(|at| style.entry(&pool.display(*at))).collect()).collect();
        let matrix = Block::matrix(&entries);
        if matrix.width() + 2 <= style.width {
            let body: String = matrix.lines().map(|line| format!("  {line}\n")).collect();
            return format!("{heading}\n{body}");
        }
    } else if columns * 3 <= style.width {
        let mut table = plain();
        for row in rows {
            table.add_row(row.iter().map(|at| pool.display(*at)));
        }
        let lines = lines(&mut table);
        if lines.iter().all(|line| line.chars().count() + 2 <= style.width) {
            let body: String = lines.iter().map(|line| format!("  {line}\n")).collect();
            return format!("{heading}\n{body}");
        }
    }
    let (remark, all) = symmetry_of(letter);
    let mut out = format!("{heading}, {remark}entries that are not zero:\n");
    for (i, row) in rows.iter().enumerate() {
        let first = if all { 0 } else { i };
        for (j, at) in row.iter().enumerate().skip(first) {
            if !zero(*at) {
                let text = pool.display(*at);
                for line in style.lines(&format!("{letter}[{}, {}] = {text}", i + 1, j + 1)) {
                    out.push_str(&format!("  {line}\n"));
                }
            }
        }
    }
    out
}
