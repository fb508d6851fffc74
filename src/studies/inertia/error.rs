//! Why there is no tensor of inertia.

use thiserror::Error;

use super::mesh::Edge;
use crate::source::quoted;
use librate_core::diagnostic::{at, nowhere};
use librate_core::mistakes;
use librate_core::span::Span;

mistakes! {
/// Why a model, a table of points or a mesh gives no tensor.
#[derive(Clone, Debug, PartialEq, Error)]
Error InertiaError {
    /// No named expression of a model is a constant symmetric matrix of 3 x 3.
    #[error(
        "this model has no constant tensor: no `let` is a symmetric 3 x 3 matrix of parameters and numbers alone"
    )]
    "E0401" NoTensor {
        /// A matrix of 3 x 3 that is none, where it stands, and why.
        nearest: Option<(String, Span, String)>,
    } => {
        let help = "name the tensor, as in `let I = inertia_box(m, a, b, c)`";
        match nearest {
            Some((_, span, why)) => at(*span, why.clone()).with_help(help),
            None => nowhere().with_help(help),
        }
    },

    /// A tensor whose parameter has no value.
    #[error("the tensor `{tensor}` needs a value for the parameter `{parameter}`")]
    "E0402" MissingValue(span) {
        /// The tensor.
        tensor: String,
        /// The parameter.
        parameter: String,
        /// Where that is declared.
        declared: Span,
    } => at(*span, "depends on it").with_secondary(*declared, "declared without a value")
        .with_help(format!("give it a value in the file, or on the command line: --set {parameter}=VALUE")),

    /// An entry of a tensor that is no number.
    #[error("entry ({row}, {column}) of the tensor `{tensor}` is not a finite number")]
    "E0403" NotANumberEntry(span) {
        /// The tensor.
        tensor: String,
        /// The row, from 1.
        row: usize,
        /// The column, from 1.
        column: usize,
    } => at(*span, "this tensor").with_help("is there a division by zero, or a root of a negative number?"),

    /// A table that can't be read.
    #[error("line {line} of the table: {reason}")]
    "E0404" BadTable {
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        reason: String,
    } => nowhere().with_help(
        "a table of points has a header, `m,x,y,z`, and for each point a row with as many numbers",
    ),

    /// A column that is needed and not there.
    #[error("the table has no column `{}`", .wanted.join("` or `"))]
    "E0405" MissingColumn {
        /// What it may be called.
        wanted: Vec<&'static str>,
        /// The first columns that there are.
        found: Vec<String>,
    } => nowhere().with_help(format!(
        "its columns are {}; the header of a table of points is `m,x,y,z`, in any order, other columns are ignored",
        quoted(found)
    )),

    /// Two columns that mean the same.
    #[error("the columns `{first}` and `{second}` mean the same")]
    "E0406" ColumnTwice {
        /// One.
        first: String,
        /// The other.
        second: String,
    } => nowhere().with_help("rename one of them"),

    /// A field that is no number.
    #[error("line {line} of the table: `{text}` in column `{column}` is not a number")]
    "E0407" NotANumber {
        /// As it stands.
        text: String,
        /// The column.
        column: String,
        /// The line, from 1.
        line: u64,
    } => nowhere().with_help("numbers are written 0.5, -2 or 1e-3"),

    /// A negative mass.
    #[error("line {line} of the table: the mass {mass} is negative")]
    "E0408" NegativeMass {
        /// The line, from 1.
        line: u64,
        /// The mass.
        mass: String,
    } => nowhere().with_help(
        "a mass can't be negative; for a hole, subtract the tensor of the missing part in a model: `let I = A - B`",
    ),

    /// No mass at all.
    #[error("the points have no mass: {rows} rows")]
    "E0409" NoMass {
        /// How many rows there are.
        rows: usize,
    } => nowhere().with_help("at least one point needs a mass"),

    /// A file that is no STL file, or an empty one.
    #[error("this is not a mesh: {reason}")]
    "E0410" NotAMesh {
        /// Why not.
        reason: String,
    } => nowhere().with_help("STL files are read, binary and ASCII"),

    /// A binary STL file whose length is not that of the triangles it declares.
    #[error("the file declares {declared} triangles, but its length fits {room}")]
    "E0411" WrongLength {
        /// The number in its head.
        declared: u32,
        /// How many there is room for.
        room: usize,
    } => nowhere().with_help(if (*declared as usize) > *room {
        "is the file truncated, or not an STL file at all?"
    } else {
        "the program that wrote it may not have filled in the number at the end; write the file again"
    }),

    /// An ASCII STL file without its end.
    #[error("the file is truncated after {triangles} triangles")]
    "E0412" CutOff {
        /// How many are whole.
        triangles: usize,
    } => nowhere().with_help("an ASCII STL file ends with `endsolid`"),

    /// A triangle that can't be read.
    #[error("triangle {triangle} can't be read: {reason}")]
    "E0413" BadTriangle {
        /// Its number, from 1.
        triangle: usize,
        /// Its first line in an ASCII file, from 1.
        line: Option<usize>,
        /// What is wrong.
        reason: String,
    } => match line {
        Some(line) => nowhere().with_help(format!("it begins in line {line}")),
        None => nowhere().with_help("STL files are read, binary and ASCII"),
    },

    /// A coordinate that is infinite or no number.
    #[error("a coordinate of triangle {triangle} is not a finite number")]
    "E0414" NotFinite {
        /// The triangle, from 1.
        triangle: usize,
    } => nowhere().with_help("the file is damaged, or a coordinate is beyond single precision"),

    /// Edges that belong to one triangle only.
    #[error("the mesh is open: {}", edge_words(.edge, *.edges, "belongs to triangle", "alone"))]
    "E0415" OpenMesh {
        /// The first of them.
        edge: Edge,
        /// How many there are.
        edges: usize,
    } => nowhere().with_help(
        "the surface of a body has no holes, and vertices are the same only if their coordinates agree to the last bit: fill the holes or merge the vertices in the program that wrote the mesh",
    ),

    /// Edges through which two triangles run in the same direction.
    #[error("the triangles are not all oriented the same way: {}", edge_words(.edge, *.edges, "is traversed in one direction by triangles", ""))]
    "E0416" TurnedTriangle {
        /// The first of them.
        edge: Edge,
        /// How many there are.
        edges: usize,
    } => nowhere().with_help(
        "the corners of a triangle are ordered counterclockwise seen from outside; recompute the normals in the program that wrote the mesh",
    ),

    /// Edges of more than two triangles.
    #[error("the mesh is not the surface of a body: {}", edge_words(.edge, *.edges, "belongs to triangles", "and so to more than two"))]
    "E0417" NotAManifold {
        /// The first of them.
        edge: Edge,
        /// How many there are.
        edges: usize,
    } => nowhere().with_help(
        "where bodies touch in an edge, or a wall has no thickness, inside and outside are not defined; separate them slightly",
    ),

    /// A surface whose normals point inwards.
    #[error("{} is inside out: its volume is {volume}", match .vertex {
        None => "the mesh".to_owned(),
        Some(vertex) => format!("the surface with the vertex {}", point(vertex)),
    })]
    "E0418" InsideOut {
        /// The volume, negative.
        volume: String,
        /// A vertex of the surface, where there are others that are right.
        vertex: Option<[f32; 3]>,
    } => nowhere().with_help(match vertex {
        None => {
            "the corners of its triangles are ordered clockwise seen from outside; reverse the orientation of all of them"
        }
        Some(_) => {
            "only the surface of a cavity inside a body is oriented so; reverse its orientation"
        }
    }),

    /// A mesh that encloses nothing.
    #[error("the mesh encloses no volume")]
    "E0419" NoVolume {} => nowhere().with_help("it is flat, or it consists of a body and a cavity of the same size"),

    /// Numbers beyond the range of doubles.
    #[error("the tensor is beyond the range of the numbers")]
    "E0420" OutOfRange {} => nowhere().with_help("choose other units"),

    /// A density or a mass that is not positive.
    #[error("the {what} must be a positive number, `{text}` is not")]
    "E0421" BadAmount {
        /// `density` or `mass`.
        what: &'static str,
        /// As it was given.
        text: String,
    } => nowhere().with_help(format!("for example --{what} 2700")),

    /// The eigenvalues could not be had.
    #[error("the principal moments could not be found: {reason}")]
    "E0422" NoMoments {
        /// Why.
        reason: String,
    } => nowhere(),
}
}

impl InertiaError {
    /// The line of the table that is at fault, from 1.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        match self {
            Self::BadTable { line, .. } | Self::NotANumber { line, .. } | Self::NegativeMass { line, .. } => {
                Some(*line)
            }
            _ => None,
        }
    }
}

/// (1, 0, 0.5)
fn point(at: &[f32; 3]) -> String {
    format!("({}, {}, {})", at[0], at[1], at[2])
}

fn edge_words(edge: &Edge, edges: usize, verb: &str, after: &str) -> String {
    let (from, to) = (point(&edge.from), point(&edge.to));
    let mut numbers = edge.triangles.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    if edge.count > edge.triangles.len() {
        numbers.push_str(", …");
    }
    let mut words = format!("the edge from {from} to {to} {verb} {numbers}");
    if !after.is_empty() {
        words.push_str(&format!(" {after}"));
    }
    match edges {
        0 | 1 => {}
        2 => words.push_str(" (and 1 more edge)"),
        more => words.push_str(&format!(" (and {} more edges)", more - 1)),
    }
    words
}
