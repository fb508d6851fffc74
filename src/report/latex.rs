//! The derivation as LaTeX.

use super::derive::{
    MOST_FOR_ENERGIES, conserved_because, potential_name, quadratic_forms, root_texts,
};
use crate::derive::{Conserved, Derivation, Energy, Linear, Motion, SecondOrder};
use crate::expr::ExprId;
use crate::number::Number;
use crate::typeset::{Formula, Notation};

/// Matrices of more rows than this are given by their entries: a page has no room for more.
const MOST_FOR_MATRICES: usize = 8;

/// The derivation in LaTeX, in the order of [`derive_text`](super::derive_text): headings and displayed formulas to
/// be read into a document that has the package `amsmath`, or with `standalone` a whole document.
#[must_use]
pub fn derive_latex(derivation: &Derivation, standalone: bool) -> String {
    let mut page = Page::new(derivation);
    page.write();
    if !standalone {
        return page.out;
    }
    let title = derivation.model.as_deref().map_or(String::new(), |name| {
        format!("\\section*{{{}}}\n", escaped(&name.replace('_', " ")))
    });
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
            // What the language has none of outside comments.
            _ => out.push('?'),
        }
    }
    out
}

struct Page<'a> {
    derivation: &'a Derivation,
    notation: Notation,
    out: String,
}

impl<'a> Page<'a> {
    fn new(derivation: &'a Derivation) -> Self {
        let names = derivation.names.coordinates.iter().map(String::as_str);
        Self {
            derivation,
            notation: Notation::new(names),
            out: String::new(),
        }
    }

    /// An expression of the language; where it nests too deeply for a formula, as it is written.
    fn formula(&self, text: &str) -> Formula {
        self.notation
            .read(text)
            .unwrap_or_else(|| Formula::Verbatim(text.to_owned()))
    }

    fn expression(&self, at: ExprId) -> Formula {
        self.formula(&self.derivation.pool.display(at))
    }

    fn heading(&mut self, title: &str) {
        if !self.out.is_empty() {
            self.out.push('\n');
        }
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
        if derivation.equations.is_some() {
            self.heading("Lagrange's equations");
            self.equations(&derivation.equation_texts());
        }
        if let Some(energy) = &derivation.energy {
            self.energy(energy);
        }
        if let Some(roots) = &derivation.equilibria
            && derivation.names.coordinates.len() <= MOST_FOR_ENERGIES
            && !roots.is_empty()
        {
            self.heading("The force vanishes where");
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
            let formula = self
                .notation
                .read_relation(text)
                .unwrap_or_else(|| Formula::Verbatim(text.clone()));
            self.display(&formula);
        }
    }

    fn energy(&mut self, energy: &Energy) {
        let names = &self.derivation.names;
        if names.coordinates.len() <= MOST_FOR_ENERGIES {
            self.heading("Momenta");
            for (i, sum) in energy.momenta.iter().enumerate() {
                let right = self.formula(&self.derivation.text(sum));
                self.equality(&names.of(Motion::Momentum(i)), right);
            }
            self.heading("Energy function and Hamiltonian");
            let right = self.formula(&self.derivation.text(&energy.function));
            self.equality("h", right);
            if let Some(hamiltonian) = &energy.hamiltonian {
                let right = self.formula(&self.derivation.text(hamiltonian));
                self.equality("H", right);
            }
        }
        if energy.conserved.is_empty() {
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
                Conserved::Energy { is_total: true } => (
                    "the energy $T + V$".to_owned(),
                    "the time does not occur in $L$".to_owned(),
                ),
                Conserved::Energy { .. } => (
                    "$h$".to_owned(),
                    escaped(&conserved_because(*quantity, names)),
                ),
            };
            self.out.push_str(&format!("\\item {what}: {why}\n"));
        }
        self.out.push_str("\\end{itemize}\n");
    }

    fn linear(&mut self, linear: &Linear) {
        self.heading("Equilibrium");
        self.equilibrium(linear);
        if let Some(part) = &linear.second_order
            && linear.mass.len() <= MOST_FOR_ENERGIES
        {
            self.second_order(part);
        }
        for (title, letter, rows) in [
            ("Mass matrix", "M", &linear.mass),
            ("Stiffness matrix", "K", &linear.stiffness),
        ] {
            self.heading(title);
            self.matrix(letter, rows);
        }
        if linear.second_order.is_some() && linear.mass.len() <= MOST_FOR_ENERGIES {
            self.heading("Linearized equations");
            self.equations(&self.derivation.linearized_texts());
        }
    }

    fn equilibrium(&mut self, linear: &Linear) {
        let pool = &self.derivation.pool;
        let zero = |at: &ExprId| pool.as_number(*at).is_some_and(Number::is_zero);
        if linear.equilibrium.iter().all(zero) {
            self.out.push_str("All coordinates are 0.\n");
            return;
        }
        let mut searched = Vec::new();
        for (name, value) in self
            .derivation
            .names
            .coordinates
            .iter()
            .zip(&linear.equilibrium)
        {
            if pool.display(*value) == *name {
                searched.push(format!("${}$", self.formula(name).latex()));
            } else {
                let right = self.expression(*value);
                self.equality(name, right);
            }
        }
        if !searched.is_empty() {
            self.out.push_str(&format!(
                "Found numerically; standing for its value below: {}.\n",
                searched.join(", ")
            ));
        }
    }

    fn second_order(&mut self, part: &SecondOrder) {
        let potential = match potential_name(self.derivation) {
            "V" => "$V$",
            _ => "$V - T_0$",
        };
        self.heading(&format!("$T$ and {potential} to second order"));
        let names = &self.derivation.names;
        if names.displacements != names.coordinates {
            let pairs = names.displacements.iter().zip(&names.coordinates);
            let items: Vec<String> = pairs
                .map(|(displacement, name)| {
                    let (displacement, name) = (self.formula(displacement), self.formula(name));
                    format!("${}$ of ${}$", displacement.latex(), name.latex())
                })
                .collect();
            self.out
                .push_str(&format!("Displacements from it: {}.\n", items.join(", ")));
        }
        self.equations(&quadratic_forms(self.derivation, part));
    }

    /// A small matrix as a whole; of a large one the entries that are not zero, the upper triangle standing for both.
    fn matrix(&mut self, letter: &str, rows: &[Vec<ExprId>]) {
        if rows.len() <= MOST_FOR_MATRICES {
            let entries = rows
                .iter()
                .map(|row| row.iter().map(|at| self.expression(*at)).collect())
                .collect();
            self.equality(letter, Formula::Matrix(entries));
            return;
        }
        self.out
            .push_str("Symmetric; the entries that are not zero:\n");
        for (i, row) in rows.iter().enumerate() {
            for (j, at) in row.iter().enumerate().skip(i) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escaped("a_b 5%"), r"a\_b 5\%");
        assert_eq!(escaped(r"\x^ü"), r"\textbackslash{}x\textasciicircum{}?");
    }
}
