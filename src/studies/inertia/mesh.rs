//! Closed surfaces of triangles, and the exact integrals over what they enclose.
//!
//! Coordinates are the single-precision numbers of a file and nothing else: vertices are the same where all three
//! are equal, and every integral is a sum of whole numbers over a power of two. No tolerance occurs anywhere.

use std::collections::HashMap;

use dashu_int::{IBig, UBig};

use super::body::{Amount, Body, Integrals, Made, Sums};
use super::{InertiaError, square, stl};
use librate_core::groups::Groups;
use librate_core::number::Number;
use librate_core::precision::Big;

type Point = [f32; 3];

/// A closed surface of triangles, or several, oriented so that normals point out of the body.
#[derive(Clone, Debug)]
pub struct Mesh {
    sums: Sums,
    made: Made,
}

/// An edge and the triangles that have it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Edge {
    /// One end.
    pub from: [f32; 3],
    /// The other.
    pub to: [f32; 3],
    /// The numbers of the triangles, from 1 in the order of the file; at most the first four.
    pub triangles: Vec<usize>,
    /// How many triangles there are.
    pub count: usize,
}

impl Mesh {
    /// A mesh from the bytes of an STL file, binary or ASCII.
    ///
    /// # Errors
    /// [`InertiaError`] where this is no STL file, or none of a closed and oriented surface: see [`Mesh::new`].
    ///
    /// ```
    /// use librate::inertia::{InertiaError, Mesh};
    /// assert!(matches!(Mesh::read_stl(b"PK"), Err(InertiaError::NotAMesh { .. })));
    /// ```
    pub fn read_stl(bytes: &[u8]) -> Result<Self, InertiaError> {
        Self::new(&stl::read(bytes)?)
    }

    /// A mesh from the corners of its triangles, each counterclockwise seen from outside.
    ///
    /// A surface that encloses a cavity is oriented the other way round and lies within another one. Where surfaces
    /// cut each other, or one lies in another and is no cavity, what they share counts twice: that is not searched for.
    ///
    /// # Errors
    /// Where a coordinate is not finite; an edge does not belong to two triangles which run through it in opposite
    /// directions; or the volume is not positive.
    pub fn new(triangles: &[[[f32; 3]; 3]]) -> Result<Self, InertiaError> {
        if triangles.is_empty() {
            return Err(InertiaError::NotAMesh { reason: "there is no triangle in it".to_owned() });
        }
        let indexed = Indexed::new(triangles)?;
        indexed.check_edges()?;
        indexed.measured()
    }

    /// The body inside, of one density: its volume, mass, centre of mass, tensor and principal moments to so many
    /// digits.
    ///
    /// # Errors
    /// [`InertiaError::OutOfRange`] where numbers leave the range of doubles.
    ///
    /// ```
    /// use librate::inertia::{Amount, Mesh};
    /// // The corner of a cube of edge 1.
    /// let (o, x, y, z) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    /// let mesh = Mesh::new(&[[o, y, x], [o, x, z], [o, z, y], [x, y, z]])?;
    /// let body = mesh.body(&Amount::Unit, 10)?;
    /// assert_eq!(body.mass.decimal(6).text, "0.166667");
    /// assert_eq!(body.centre[0].decimal(3).text, "0.250");
    /// # Ok::<(), librate::inertia::InertiaError>(())
    /// ```
    pub fn body(&self, amount: &Amount, digits: usize) -> Result<Body, InertiaError> {
        Integrals::new(self.sums.clone(), self.made.clone()).with_amount(amount).body(digits)
    }
}

/// Triangles as numbers of vertices.
struct Indexed {
    vertices: Vec<Point>,
    triangles: Vec<[u32; 3]>,
    /// Their numbers in the file, from 1.
    numbers: Vec<usize>,
    left_out: usize,
}

/// A side of a triangle: its ends in ascending order, whether it runs that way, and the triangle's place.
type Side = (u32, u32, bool, usize);

impl Indexed {
    fn new(corners: &[[Point; 3]]) -> Result<Self, InertiaError> {
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        let mut own = Self {
            vertices: Vec::new(),
            triangles: Vec::with_capacity(corners.len()),
            numbers: Vec::with_capacity(corners.len()),
            left_out: 0,
        };
        for (at, triangle) in corners.iter().enumerate() {
            if !triangle.as_flattened().iter().all(|x| x.is_finite()) {
                return Err(InertiaError::NotFinite { triangle: at + 1 });
            }
            let numbers = triangle.map(|point| {
                // -0 and 0 are the same place.
                let key = point.map(|x| (x + 0.0).to_bits());
                *known.entry(key).or_insert_with(|| {
                    own.vertices.push(point);
                    own.vertices.len() as u32 - 1
                })
            });
            let [a, b, c] = numbers;
            if a == b || b == c || c == a {
                own.left_out += 1;
            } else {
                own.triangles.push(numbers);
                own.numbers.push(at + 1);
            }
        }
        Ok(own)
    }

    /// Every edge has two triangles, which run through it in opposite directions.
    fn check_edges(&self) -> Result<(), InertiaError> {
        let edges = self.triangles.iter().enumerate().flat_map(|(at, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to, at))
        });
        let mut sides: Vec<Side> = edges.collect();
        sides.sort_unstable();
        // The kinds of mistakes, the worst first, each by its first edge in the order of the vertices.
        let mut found: [(usize, Option<Edge>); 3] = [(0, None), (0, None), (0, None)];
        for own in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let forwards = own.iter().filter(|side| side.2).count();
            let kind = match (own.len(), forwards) {
                (2, 1) => continue,
                (1, _) => 2,
                (2, _) => 1,
                _ => 0,
            };
            let (count, first) = &mut found[kind];
            *count += 1;
            first.get_or_insert_with(|| self.edge(own));
        }
        let [many, twice, open] = found;
        match (many, twice, open) {
            ((edges, Some(edge)), _, _) => Err(InertiaError::NotAManifold { edge, edges }),
            (_, _, (edges, Some(edge))) => Err(InertiaError::OpenMesh { edge, edges }),
            (_, (edges, Some(edge)), _) => Err(InertiaError::TurnedTriangle { edge, edges }),
            ((_, None), (_, None), (_, None)) => Ok(()),
        }
    }

    fn edge(&self, sides: &[Side]) -> Edge {
        let (low, high) = sides.first().map_or((0, 0), |side| (side.0, side.1));
        let place = |vertex: u32| self.vertices.get(vertex as usize).copied().unwrap_or_default();
        let mut triangles: Vec<usize> = sides.iter().map(|side| self.numbers[side.3]).collect();
        triangles.sort_unstable();
        triangles.truncate(4);
        Edge { from: place(low), to: place(high), triangles, count: sides.len() }
    }

    /// For each triangle the surface that it belongs to, and how many there are.
    fn surfaces(&self) -> (Vec<usize>, usize) {
        let mut groups = Groups::new(self.vertices.len());
        for [a, b, c] in self.triangles.iter().map(|corners| corners.map(|at| at as usize)) {
            groups.join(a, b);
            groups.join(b, c);
        }
        let mut numbers: HashMap<usize, usize> = HashMap::new();
        let own = self.triangles.iter().map(|triangle| {
            let top = groups.least(triangle[0] as usize);
            let next = numbers.len();
            *numbers.entry(top).or_insert(next)
        });
        let own: Vec<usize> = own.collect();
        (own, numbers.len())
    }

    /// The integrals over all tetrahedra between the origin and a triangle, with signs.
    ///
    /// For corners 0, a, b, c, D = a . (b x c) and s = a + b + c: 6 ∫ dV = D, 24 ∫ r dV = D s and
    /// 120 ∫ r rᵀ dV = D (s sᵀ + a aᵀ + b bᵀ + c cᵀ) (Tonon, J. Math. Stat. 1 (2005) 8; the divergence theorem
    /// of Mirtich, J. Graphics Tools 1 (1996) 31, gives the same sums).
    fn measured(&self) -> Result<Mesh, InertiaError> {
        let (places, scale) = whole(&self.vertices);
        let (surface, surfaces) = self.surfaces();
        let mut volumes = vec![IBig::ZERO; surfaces];
        let mut first = [IBig::ZERO; 3];
        let mut second: [[IBig; 3]; 3] = Default::default();
        for (&[a, b, c], surface) in self.triangles.iter().zip(&surface) {
            let [a, b, c] = [a, b, c].map(|vertex| &places[vertex as usize]);
            let determinant = (0..3).fold(IBig::ZERO, |sum, i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                sum + &a[i] * (&b[j] * &c[k] - &b[k] * &c[j])
            });
            let sum = [0, 1, 2].map(|i| &a[i] + &b[i] + &c[i]);
            for i in 0..3 {
                first[i] += &determinant * &sum[i];
                for j in 0..=i {
                    let products = &sum[i] * &sum[j] + &a[i] * &a[j] + &b[i] * &b[j] + &c[i] * &c[j];
                    second[i][j] += &determinant * products;
                }
            }
            volumes[*surface] += determinant;
        }
        let total: IBig = volumes.iter().sum();
        let volume = fraction(total, 3 * scale, 6);
        if volume.is_zero() {
            return Err(InertiaError::NoVolume {});
        }
        if volume.is_negative() {
            return Err(InertiaError::InsideOut { volume: volume.to_decimal(6), vertex: None });
        }
        let cavities = self.check_cavities(&surface, &volumes, scale)?;
        let second = square(|i, j| fraction(second[i.max(j)][i.min(j)].clone(), 5 * scale, 120));
        let zero = || Box::new(Big::zero(2));
        let made = Made::Solid {
            triangles: self.triangles.len(),
            left_out: self.left_out,
            surfaces,
            cavities,
            volume: zero(),
            density: zero(),
            by_default: true,
        };
        let first = first.map(|sum| fraction(sum, 4 * scale, 24));
        Ok(Mesh { sums: Sums { size: volume, first, second }, made })
    }

    /// How many surfaces are inside out, each of which has to lie within one that is not. That its box lies within the
    /// other's box is necessary for that, and what is examined.
    fn check_cavities(&self, surface: &[usize], volumes: &[IBig], scale: i64) -> Result<usize, InertiaError> {
        let negative = |volume: &IBig| *volume < IBig::ZERO;
        let cavities = volumes.iter().filter(|volume| negative(volume)).count();
        if cavities == 0 {
            return Ok(0);
        }
        let mut boxes = vec![[[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]]; volumes.len()];
        let mut corners = vec![Point::default(); volumes.len()];
        for (triangle, surface) in self.triangles.iter().zip(surface) {
            let [low, high] = &mut boxes[*surface];
            for vertex in triangle {
                let point = self.vertices[*vertex as usize];
                for i in 0..3 {
                    low[i] = low[i].min(point[i]);
                    high[i] = high[i].max(point[i]);
                }
                corners[*surface] = point;
            }
        }
        for (own, volume) in volumes.iter().enumerate() {
            if !negative(volume) {
                continue;
            }
            let [low, high] = boxes[own];
            let holds = |(other, around): (usize, &[Point; 2])| {
                !negative(&volumes[other]) && (0..3).all(|i| around[0][i] <= low[i] && high[i] <= around[1][i])
            };
            if !boxes.iter().enumerate().any(holds) {
                return Err(InertiaError::InsideOut {
                    volume: fraction(volume.clone(), 3 * scale, 6).to_decimal(6),
                    vertex: Some(corners[own]),
                });
            }
        }
        Ok(cavities)
    }
}

/// n 2^exponent / divisor.
fn fraction(n: IBig, exponent: i64, divisor: u8) -> Number {
    let shift = exponent.unsigned_abs() as usize;
    let (n, under) = if exponent < 0 { (n, UBig::from(divisor) << shift) } else { (n << shift, UBig::from(divisor)) };
    Number::from_parts(n, under).unwrap_or_default()
}

/// The coordinates as whole numbers over 2^scale, exactly.
fn whole(points: &[Point]) -> (Vec<[IBig; 3]>, i64) {
    let parts = |x: f32| -> (i64, i64) {
        let bits = x.to_bits();
        let field = i64::from((bits >> 23) & 0xff);
        let fraction = i64::from(bits & 0x7f_ffff);
        // A normal number is 1.fraction 2^(field - 127), a subnormal one 0.fraction 2^-126.
        let (mantissa, exponent) = if field == 0 { (fraction, -149) } else { (fraction | (1 << 23), field - 150) };
        let zeros = mantissa.trailing_zeros() % 64;
        let mantissa = mantissa >> zeros;
        let sign = if x < 0.0 { -1 } else { 1 };
        (sign * mantissa, exponent + i64::from(zeros))
    };
    let scale = points.as_flattened().iter().filter(|x| **x != 0.0).map(|x| parts(*x).1).min().unwrap_or(0);
    let places = points.iter().map(|point| {
        point.map(|x| {
            let (mantissa, exponent) = parts(x);
            if mantissa == 0 { IBig::ZERO } else { IBig::from(mantissa) << (exponent - scale).unsigned_abs() as usize }
        })
    });
    (places.collect(), scale)
}
