//! The kinds of models. Each draws numbers once and uses them twice: in a text, written the way a user
//! would, and in M and K, written down by hand.

mod chains;
mod forms;
mod lattices;
mod plane;
mod searched;
mod ugly;

use super::draw::{Draw, Exact, mix};
use super::exponents::Scaled;
use super::real::Real;
use super::reference::{Matrices, Square};

/// A drawn model.
pub(crate) struct Model {
    pub(crate) text: String,
    /// File names and contents.
    pub(crate) tables: Vec<(String, String)>,
    pub(crate) reference: Reference,
}

/// M and K once more.
pub(crate) enum Reference {
    Exact {
        mass: Exact,
        stiffness: Exact,
    },
    Real(Box<dyn Fn(usize) -> Matrices>),
    /// M, and V of a model whose equilibrium the reference has to search for as well.
    Searched(Exact, Box<Derivatives>),
    Exponents(Box<Scaled>),
}

/// The gradient of V and its second derivatives, at some number of bits.
pub(crate) type Derivatives = dyn Fn(&[Real], usize) -> (Vec<Real>, Square);

impl Model {
    fn new(text: String, reference: Reference) -> Self {
        Self { text, tables: Vec::new(), reference }
    }

    fn exact(text: String, mass: Exact, stiffness: Exact) -> Self {
        Self::new(text, Reference::Exact { mass, stiffness })
    }

    fn with_table(mut self, name: &str, text: String) -> Self {
        self.tables.push((name.to_owned(), text));
        self
    }
}

type Drawing = fn(&mut Draw) -> Model;

/// All kinds, each with the ways it is drawn.
pub(crate) const KINDS: [(&str, &[Drawing]); 11] = [
    ("graded", &[chains::graded, chains::powers, chains::network, chains::pendulums]),
    ("clustered", &[chains::copies, chains::copies, chains::detuned]),
    (
        "degenerate",
        &[lattices::ring, lattices::square, lattices::torus, lattices::uncoupled, lattices::complete, forms::hidden],
    ),
    ("indefinite", &[chains::negative_springs, chains::inverted, plane::links, forms::indefinite]),
    ("free", &[chains::free, lattices::free_ring, plane::network, plane::network, forms::few]),
    ("prestressed", &[plane::net, plane::string, plane::hanging, plane::wheel, plane::hanging_links]),
    ("dense", &[forms::dense, forms::dense, forms::squares]),
    ("singular", &[forms::light, forms::nearly_rigid]),
    ("searched", &[searched::wells, searched::hanging, searched::ions, searched::torsion, searched::sagging]),
    (
        "ugly",
        &[
            |draw| ugly::plain(ugly::repeated(draw)),
            |draw| ugly::plain(ugly::gyroscopic(draw)),
            |draw| ugly::plain(ugly::circulatory(draw)),
            |draw| ugly::plain(ugly::low_rank(draw)),
            ugly::steady,
        ],
    ),
    ("scaled", &[ugly::scaled]),
];

/// The model with this number: a function of its arguments alone.
pub(crate) fn draw(seed: u64, kind: usize, index: usize) -> (Model, Draw) {
    let mut draw = Draw::new(mix(seed) ^ mix(index as u64 * 64 + kind as u64 + 1));
    let ways = KINDS[kind].1;
    let way = draw.size(0, ways.len() - 1);
    let model = ways[way](&mut draw);
    (model, draw)
}
