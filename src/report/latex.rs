//! The derivation as LaTeX.

use super::constraints::{
    FOLLOWS_TITLE, REDUCED_TITLE, constraint_texts, constraints_title, direction_texts, displacements_title,
    follow_texts, multiplier_texts, reduced_texts, unsolved,
};
use super::derive::{
    MOST_FOR_ENERGIES, assumed_of, assumption_texts, conserved_because, conserved_name, definition_text, notation,
    potential_name, quadratic_forms, rate_texts, root_texts, symmetry_of,
};
use super::exponents::exponent_sections;
use super::frequencies::{
    MOST_IN_BLOCK, MOST_LISTED, alone, exchange, kind, motion, normal_lines, on_request, remarks, signs, solved_lines,
    waves_lines,
};
use librate_core::derive::{
    Approximation, Case, Conserved, Definition, Derivation, Energy, Exchange, Frequencies, Linear, Motion, SecondOrder,
};
use librate_core::expr::ExprId;
use librate_core::number::Number;
use librate_core::typeset::{Formula, Notation};

/// Matrices of more rows than this are given by their entries: a page has no room for more.
const MOST_FOR_MATRICES: usize = 8;

/// The derivation in LaTeX, in the order of [`derive_text`](super::derive_text): headings and displayed formulas to
/// be read into a document that has the package `amsmath`, or with `standalone` a whole document.
#[must_use]
pub fn derive_latex(derivation: &Derivation, standalone: bool) -> String {
    let abbreviated = derivation.abbreviated();
    let (derivation, definitions) = match &abbreviated {
        Some((derivation, definitions)) => (derivation, definitions.as_slice()),
        None => (derivation, [].as_slice()),
    };
    let mut page = Page::new(derivation, definitions);
    if !definitions.is_empty() {
        page.heading("Abbreviations");
        let texts: Vec<String> = definitions.iter().map(definition_text).collect();
        page.equations(&texts);
    }
    page.write();
    if !standalone {
        return page.out;
    }
    let title = derivation
        .model
        .as_deref()
        .map_or(String::new(), |name| format!("\\section*{{{}}}\n", escaped(&name.replace('_', " "))));
    format!(
        "\\documentclass{{article}}\n\\usepackage{{amsmath}}\n\\allowdisplaybreaks\n\\begin{{document}}\n{title}{}\\end{{document}}\n",
        page.out
    )
}

/// Text, not formula.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '_' | '%' | '&' | '#' | '$' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            '\\' => out.push_str("\\textbackslash{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '\'' | '`' => out.push(c),
            c if c.is_ascii() => out.push(c),
            // Classes of straight molecules.
            'Σ' => out.push_str("$\\Sigma$"),
            'Π' => out.push_str("$\\Pi$"),
            // What the language has none of outside comments.
            _ => out.push('?'),
        }
    }
    out
}

/// `, with ...` behind a heading.
fn with(assumed: &str) -> String {
    if assumed.is_empty() { String::new() } else { format!(", with {assumed}") }
}

struct Page<'a> {
    derivation: &'a Derivation,
    notation: Notation,
    out: String,
}

impl<'a> Page<'a> {
    fn new(derivation: &'a Derivation, definitions: &[Definition]) -> Self {
        Self { derivation, notation: notation(derivation, definitions), out: String::new() }
    }

    /// An expression of the language; where it nests too deeply for a formula, as it is written.
    fn formula(&self, text: &str) -> Formula {
        self.notation.read(text).unwrap_or_else(|| Formula::Verbatim(text.to_owned()))
    }

    fn expression(&self, at: ExprId) -> Formula {
        self.formula(&self.derivation.pool.display(at))
    }

    fn heading(&mut self, title: &str) {
        if !self.out.is_empty() {
            self.out.push('\n');
        }
        let title = capitalized(title);
        self.out.push_str(&format!("\\subsection*{{{title}}}\n"));
    }

    fn display(&mut self, formula: &Formula) {
        let text = formula.latex_display();
        self.out.push_str(&format!("\\[\n{text}\n\\]\n"));
    }

    /// `left` is a name, with indices or without.
    fn equality(&mut self, left: &str, right: Formula) {
        let left = if left.contains('[') {
            self.formula(left)
        } else {
            // `T` is a word of the language.
            self.notation.symbol(left)
        };
        self.display(&Formula::equation(left, right));
    }

    fn write(&mut self) {
        let derivation = self.derivation;
        if !derivation.assumptions.is_empty() {
            let assumed = self.relations(&assumption_texts(derivation)).join(", ");
            self.out.push_str(&format!("Assumed: {assumed}.\n"));
        }
        if derivation.equations.is_some() && derivation.shows("equations") {
            self.heading("Lagrange's equations");
            self.equations(&derivation.equation_texts());
        }
        let constraints = constraint_texts(derivation);
        if !constraints.is_empty() && derivation.shows("constraints") {
            self.heading(&constraints_title(derivation));
            for (text, name) in constraints {
                let name = self.formula(&name).latex();
                self.relation(&text, &format!(r" \qquad ({name})"));
            }
        }
        if let Some(own) = derivation.independent.as_ref().filter(|_| derivation.shows("equations")) {
            self.heading(FOLLOWS_TITLE);
            let follows = follow_texts(derivation, own).into_iter().map(|(name, speed)| format!("{name} = {speed}"));
            self.equations(&follows.collect::<Vec<_>>());
            self.heading(REDUCED_TITLE);
            self.equations(&reduced_texts(derivation, own));
        }
        if let Some(energy) = &derivation.energy {
            self.energy(energy);
        }
        if let Some(roots) = &derivation.equilibria
            && derivation.names.coordinates.len() <= MOST_FOR_ENERGIES
            && !roots.is_empty()
            && derivation.shows("equilibria")
        {
            let signs = self.relations(&signs(derivation, &assumed_of(roots)));
            self.heading(&format!("The force vanishes where{}", with(&signs.join(", "))));
            self.equations(&root_texts(derivation, roots));
        }
        match &derivation.linear {
            Ok(linear) => self.linear(linear),
            Err(error) => {
                self.heading("Mass and stiffness matrices");
                let reason = escaped(&format!("There are none: {error}."));
                self.out.push_str(&format!("{reason}\n"));
            }
        }
    }

    /// Relations in the model language, each on a line of its own.
    fn equations(&mut self, texts: &[String]) {
        for text in texts {
            self.relation(text, "");
        }
    }

    /// A relation with a remark behind it, which is LaTeX.
    fn relation(&mut self, text: &str, remark: &str) {
        let formula = self.notation.read_relation(text).unwrap_or_else(|| Formula::Verbatim(text.to_owned()));
        let text = formula.latex_display();
        self.out.push_str(&format!("\\[\n{text}{remark}\n\\]\n"));
    }

    fn energy(&mut self, energy: &Energy) {
        let names = &self.derivation.names;
        if names.coordinates.len() <= MOST_FOR_ENERGIES {
            if self.derivation.shows("momenta") {
                self.heading("Momenta");
                for (i, sum) in energy.momenta.iter().enumerate() {
                    let right = self.formula(&self.derivation.text(sum));
                    self.equality(&names.of(Motion::Momentum(i)), right);
                }
            }
            if self.derivation.shows("hamiltonian") {
                self.heading("Energy function and Hamiltonian");
                let right = self.formula(&self.derivation.text(&energy.function));
                self.equality("h", right);
                if let Some(hamiltonian) = &energy.hamiltonian {
                    let right = self.formula(&self.derivation.text(hamiltonian));
                    self.equality("H", right);
                }
            }
        }
        if energy.conserved.is_empty() || !self.derivation.shows("conserved") {
            return;
        }
        self.heading("Conserved");
        self.out.push_str("\\begin{itemize}\n");
        for quantity in &energy.conserved {
            let (what, why) = match quantity {
                Conserved::Momentum(i) => {
                    let coordinate = names.coordinates.get(*i).map_or("", String::as_str);
                    let coordinate = self.formula(coordinate).latex();
                    let momentum = self.formula(&names.of(Motion::Momentum(*i))).latex();
                    let why = format!("${coordinate}$ is cyclic, only its velocity occurs in $L$");
                    (format!("${momentum}$"), why)
                }
                Conserved::Motion { .. } => {
                    let sum = self.formula(&conserved_name(self.derivation, quantity));
                    let why = escaped(&conserved_because(quantity, names));
                    let why = why.replace(" L ", " $L$ ");
                    (format!("${}$", sum.latex()), why)
                }
                Conserved::Energy { is_total: true } => {
                    ("the energy $T + V$".to_owned(), "the time does not occur in $L$".to_owned())
                }
                Conserved::Energy { .. } => ("$h$".to_owned(), escaped(&conserved_because(quantity, names))),
            };
            self.out.push_str(&format!("\\item {what}: {why}\n"));
        }
        self.out.push_str("\\end{itemize}\n");
    }

    fn linear(&mut self, linear: &'a Linear) {
        let whole = self.derivation;
        if whole.shows("equilibrium") {
            self.heading("Equilibrium");
            self.equilibrium(linear);
            let rates = rate_texts(self.derivation);
            if !rates.is_empty() {
                self.out.push_str("Steady motion:\n");
                self.equations(&rates);
            }
        }
        let potential = potential_name(self.derivation);
        self.matrices(whole, linear, potential, "");
        self.exponents(self.derivation, linear);
        let Some(tangent) = &linear.tangent else {
            return;
        };
        if tangent.massless.is_empty() && whole.shows("constraints") {
            self.heading("Gradients of the constraints");
            self.matrix("A", &tangent.gradients);
        }
        let Some(reduced) = &tangent.reduced else {
            return;
        };
        self.heading(displacements_title(tangent));
        self.equations(&direction_texts(self.derivation, reduced));
        if let Ok(linear) = &reduced.derivation.linear {
            self.derivation = &reduced.derivation;
            let free = self.displacements().join("$, $");
            self.heading(&format!("In terms of ${free}$"));
            self.matrices(whole, linear, potential, "_r");
            self.exponents(whole, linear);
            self.derivation = whole;
        }
    }

    /// Exponents and stability.
    fn exponents(&mut self, names: &Derivation, linear: &Linear) {
        for (title, lines) in exponent_sections(self.derivation, linear, names) {
            self.heading(&title);
            for (text, remark) in lines {
                let remark = if remark.is_empty() { remark } else { format!(r"\text{{{remark}}}") };
                self.relation(&text, &remark);
            }
        }
    }

    /// Energies to second order, matrices, linearized equations and frequencies.
    fn matrices(&mut self, whole: &Derivation, linear: &'a Linear, potential: &str, suffix: &str) {
        let signs = self.relations(&signs(self.derivation, &linear.signs));
        if !signs.is_empty() {
            let signs = signs.join(", ");
            self.out.push_str(&format!("Below, as at the values of the parameters: {signs}.\n"));
        }
        if let Some(part) = &linear.second_order
            && linear.mass.len() <= MOST_FOR_ENERGIES
            && whole.shows("linearized")
        {
            self.second_order(part, potential);
        }
        let both = [("mass matrix", "M", &linear.mass), ("stiffness matrix", "K", &linear.stiffness)];
        for (title, letter, rows) in both.into_iter().chain(linear.others()) {
            if !whole.shows(title.trim_end_matches(" matrix")) {
                continue;
            }
            self.heading(title);
            self.matrix(&format!("{letter}{suffix}"), rows);
        }
        if linear.second_order.is_some() && linear.mass.len() <= MOST_FOR_ENERGIES && whole.shows("linearized") {
            self.heading("Linearized equations");
            self.equations(&self.derivation.linearized_texts());
        }
        if let Some(frequencies) = linear.frequencies.as_ref().filter(|_| whole.shows("frequencies")) {
            self.case(frequencies, &frequencies.general);
            if let Some(tied) = &frequencies.tied {
                self.case(frequencies, tied);
            }
            if let Some(words) = on_request(frequencies) {
                self.out.push_str(&format!("\n{}\n", escaped(words).replace("--", "-{}-")));
            }
            if let Some(found) = &frequencies.would_be {
                let ties = self.ties(&found.ties);
                self.heading(&format!("It would have a symmetry, if {ties}"));
                self.exchanges(found);
            }
        }
    }

    /// The sets of equal parameters, in the text.
    fn ties(&self, sets: &[Vec<String>]) -> String {
        let sets = sets.iter().map(|set| {
            let formula = self.notation.read_relation(&set.join(" = "));
            formula.map_or_else(String::new, |formula| format!("${}$", formula.latex()))
        });
        sets.collect::<Vec<_>>().join(", ")
    }

    /// The displacements as LaTeX, for lists of them that are put together as text.
    fn displacements(&self) -> Vec<String> {
        let names = self.derivation.names.displacements.iter();
        names.map(|name| self.formula(name).latex()).collect()
    }

    fn exchanges(&mut self, found: &Exchange) {
        let names = self.displacements();
        for g in found.generators.iter().take(MOST_FOR_MATRICES) {
            let arrows =
                exchange(g, &names).replace("<->", r"\leftrightarrow").replace("->", r"\to").replace('…', r"\dots");
            self.out.push_str(&format!("\\[\n{arrows}\n\\]\n"));
        }
    }

    /// Symmetry, blocks and closed forms of one case.
    fn case(&mut self, frequencies: &Frequencies, case: &Case) {
        if let Some(found) = &case.symmetry {
            let ties = self.ties(&found.ties);
            let because = if ties.is_empty() { String::new() } else { format!(", as {ties}") };
            self.heading(&format!("Symmetry: {}{because}", kind(&found.kind)));
            self.exchanges(found);
        }
        let ties = self.ties(&case.ties);
        if !case.blocks.is_empty() {
            self.heading(&format!("Blocks of $M$ and $K$, one for each class{}", with(&ties)));
            let names = self.displacements();
            for block in &case.blocks {
                let moves =
                    motion(block, &names).replace("all others 0", r"\text{all others } 0").replace('…', r"\dots");
                let class = escaped(&block.class);
                self.out.push_str(&format!("{class}: ${moves}$\n"));
                if block.mass.len() <= MOST_IN_BLOCK {
                    self.matrix("M", &block.mass);
                    self.matrix("K", &block.stiffness);
                }
            }
        }
        if case.frequencies.is_empty() {
            return;
        }
        self.closed_forms(frequencies, case);
        let lines = match &case.normal {
            Some(normal) => normal_lines(self.derivation, normal),
            None => waves_lines(self.derivation, &case.waves),
        };
        if !lines.is_empty() {
            let assumed = self.assumed(case, &frequencies.signs);
            self.heading(&format!("Normal coordinates{}", with(&assumed)));
            for (text, remark) in lines {
                let remark = remark.replace("..", r", \dots, ");
                self.relation(&text, &remark.replacen(", ", r",\quad ", 1));
            }
        }
    }

    /// What a case and its formulas take for granted, in the text.
    fn assumed(&self, case: &Case, signs_taken: &[(ExprId, bool)]) -> String {
        let mut assumed: Vec<String> = Vec::new();
        if !case.ties.is_empty() {
            assumed.push(self.ties(&case.ties));
        }
        assumed.extend(self.relations(&signs(self.derivation, signs_taken)));
        assumed.join(", ")
    }

    /// Relations in the model language, in the text.
    fn relations(&self, texts: &[String]) -> Vec<String> {
        let formulas = texts.iter().filter_map(|text| self.notation.read_relation(text));
        formulas.map(|formula| format!("${}$", formula.latex())).collect()
    }

    fn closed_forms(&mut self, frequencies: &Frequencies, case: &Case) {
        let title = if case.complete { "Normal frequencies" } else { "Normal frequencies with a closed form" };
        let assumed = self.assumed(case, &frequencies.signs);
        let mut title = format!("{title}{}", with(&assumed));
        for done in &frequencies.approximations {
            title.push_str(&match done {
                Approximation::Limit { name, value } => {
                    let name = self.formula(name).latex();
                    format!(", for ${name} \\to {value}$")
                }
                Approximation::Expansion { name, order } => {
                    format!(", to order {order} in ${}$", self.formula(name).latex())
                }
            });
        }
        self.heading(&title);
        for series in &case.series {
            let ranges = series.numbers.iter().map(|(name, angles)| {
                let name = self.formula(name).latex();
                format!(r"{name} = {}, \dots, {}", angles.first, angles.last)
            });
            let ranges = ranges.collect::<Vec<_>>().join(r",\; ");
            self.frequency(series.omega_squared, &ranges);
        }
        if case.series.is_empty() || (!case.complete && case.frequencies.len() <= MOST_LISTED) {
            for frequency in alone(case) {
                let remarks = remarks(frequency).join(", ");
                let remark = if remarks.is_empty() { remarks } else { format!(r"\text{{({})}}", escaped(&remarks)) };
                self.frequency(frequency.omega_squared, &remark);
            }
        }
        for solved in &case.solved {
            for (text, remark) in solved_lines(self.derivation, solved) {
                let (numbers, class) = remark.split_once("  ").unwrap_or((&remark, ""));
                let mut remark = numbers.replacen(", ", r",\quad ", 1);
                if !class.is_empty() {
                    remark.push_str(&format!(r" \qquad \text{{{}}}", escaped(class)));
                }
                self.relation(&text, &remark);
            }
        }
    }

    /// One square of a frequency, with a remark behind it.
    fn frequency(&mut self, omega_squared: ExprId, remark: &str) {
        let square = self.formula("omega^2");
        let formula = Formula::equation(square, self.expression(omega_squared));
        let text = formula.latex_display();
        let remark = if remark.is_empty() { String::new() } else { format!(r" \qquad {remark}") };
        self.out.push_str(&format!("\\[\n{text}{remark}\n\\]\n"));
    }

    fn equilibrium(&mut self, linear: &Linear) {
        let pool = &self.derivation.pool;
        let zero = |at: &ExprId| pool.as_number(*at).is_some_and(Number::is_zero);
        let multipliers = linear.tangent.as_ref();
        let multipliers = multipliers.map_or_else(Vec::new, |tangent| multiplier_texts(self.derivation, tangent));
        if linear.equilibrium.iter().all(zero) {
            self.out.push_str("All coordinates are 0.\n");
            self.equations(&multipliers);
            return;
        }
        let mut searched = Vec::new();
        for (name, value) in self.derivation.names.coordinates.iter().zip(&linear.equilibrium) {
            if pool.display(*value) == *name {
                searched.push(format!("${}$", self.formula(name).latex()));
            } else {
                let right = self.expression(*value);
                self.equality(name, right);
            }
        }
        self.equations(&multipliers);
        let tangent = linear.tangent.iter();
        for name in tangent.flat_map(|own| unsolved(self.derivation, own)) {
            searched.push(format!("${}$", self.formula(&name).latex()));
        }
        if !searched.is_empty() {
            self.out.push_str(&format!("Found numerically; standing for its value below: {}.\n", searched.join(", ")));
        }
    }

    fn second_order(&mut self, part: &SecondOrder, potential: &str) {
        let written = match potential {
            "V" => "$V$",
            _ => "$V - T_0$",
        };
        self.heading(&format!("$T$ and {written} to second order"));
        let names = &self.derivation.names;
        if names.displacements != names.coordinates {
            let pairs = names.displacements.iter().zip(&names.coordinates);
            let items: Vec<String> = pairs
                .map(|(displacement, name)| {
                    let (displacement, name) = (self.formula(displacement), self.formula(name));
                    format!("${}$ of ${}$", displacement.latex(), name.latex())
                })
                .collect();
            self.out.push_str(&format!("Displacements from it: {}.\n", items.join(", ")));
        }
        self.equations(&quadratic_forms(self.derivation, part, potential));
    }

    /// A small matrix as a whole; of a large one the entries that are not zero, the upper triangle standing for both.
    fn matrix(&mut self, letter: &str, rows: &[Vec<ExprId>]) {
        let columns = rows.first().map_or(0, Vec::len);
        if rows.len().max(columns) <= MOST_FOR_MATRICES {
            let entries = rows.iter().map(|row| row.iter().map(|at| self.expression(*at)).collect()).collect();
            self.equality(letter, Formula::Matrix(entries));
            return;
        }
        let (remark, all) = symmetry_of(letter);
        let sentence = format!("{remark}the entries that are not zero:\n");
        self.out.push_str(&capitalized(&sentence));
        for (i, row) in rows.iter().enumerate() {
            let first = if all { 0 } else { i };
            for (j, at) in row.iter().enumerate().skip(first) {
                let pool = &self.derivation.pool;
                if pool.as_number(*at).is_some_and(Number::is_zero) {
                    continue;
                }
                let right = self.expression(*at);
                self.equality(&format!("{letter}[{}, {}]", i + 1, j + 1), right);
            }
        }
    }
}

fn capitalized(text: &str) -> String {
    let mut rest = text.chars();
    let first = rest.next();
    first.into_iter().flat_map(char::to_uppercase).chain(rest).collect()
}
