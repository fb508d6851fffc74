//! Meshes and points that are moved, turned, damaged or made of garbage.
#![cfg(feature = "engine")]

use librate::inertia::{Amount, Body, InertiaError, Mesh, of_points};
use proptest::prelude::*;

type Triangle = [[f32; 3]; 3];

fn cube(low: f32, high: f32) -> Vec<Triangle> {
    let corner = |bits: usize| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { high } else { low });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|half| half.map(corner)).collect()
}

fn turned_over(mesh: &[Triangle]) -> Vec<Triangle> {
    mesh.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

fn binary(triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        for x in triangle.as_flattened() {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn text(triangles: &[Triangle]) -> String {
    let mut out = "solid\n".to_owned();
    for triangle in triangles {
        out.push_str("FACET NORMAL 0 0 0\nOUTER LOOP\n");
        for [x, y, z] in triangle {
            out.push_str(&format!("VERTEX {x:e} {y:e} {z:e}\n"));
        }
        out.push_str("ENDLOOP\nENDFACET\n");
    }
    out + "endsolid\n"
}

fn body(mesh: &[Triangle]) -> Body {
    Mesh::new(mesh).unwrap().body(&Amount::Unit, 10).unwrap()
}

fn tensor(body: &Body) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| body.tensor[i][j].mid_f64()))
}

#[test]
fn both_forms_of_a_file_are_read() {
    let mesh = cube(-1.0, 1.0);
    let code = |bytes: &[u8]| Mesh::read_stl(bytes).map(|_| ()).map_err(|error| error.code());
    assert_eq!(code(&binary(&mesh)), Ok(()));
    assert_eq!(code(text(&mesh).as_bytes()), Ok(()));
    // Some programs begin the head of a binary file with the word of the other form.
    let mut solid = binary(&mesh);
    solid[..6].copy_from_slice(b"solid ");
    assert_eq!(code(&solid), Ok(()));
    // Several solids in one file are one body.
    let two = text(&cube(0.0, 1.0)) + &text(&cube(2.0, 4.0));
    let two = Mesh::read_stl(two.as_bytes()).unwrap();
    let two = two.body(&Amount::Unit, 10).unwrap();
    assert_eq!(two.mass.decimal(3).text, "9.00");
}

#[test]
fn damaged_files_are_told_apart() {
    let mesh = cube(-1.0, 1.0);
    let error = |bytes: &[u8]| Mesh::read_stl(bytes).unwrap_err();
    let whole = binary(&mesh);
    // Every shorter file, and a longer one.
    for length in 0..whole.len() {
        let code = error(&whole[..length]).code();
        assert_eq!(code, if length < 84 { "E0410" } else { "E0411" }, "{length}");
    }
    let mut longer = whole.clone();
    longer.push(0);
    assert_eq!(error(&longer).code(), "E0411");
    // A number of triangles that nobody has memory for.
    let mut greedy = whole.clone();
    greedy[80..84].copy_from_slice(&4_000_000_000_u32.to_le_bytes());
    let told = error(&greedy);
    assert!(matches!(told, InertiaError::WrongLength { declared: 4_000_000_000, room: 12 }));
    assert_eq!(error(&[0; 84]).code(), "E0410");
    assert_eq!(error(&vec![0xff; 5000]).code(), "E0411");
    let ascii = text(&mesh);
    for end in (0..ascii.len() - 10).step_by(7) {
        let code = error(&ascii.as_bytes()[..end]).code();
        assert!(["E0410", "E0412", "E0413"].contains(&code), "{end}: {code}");
    }
    let infinite = ascii.replacen("VERTEX -1e0", "VERTEX inf", 1);
    assert!(matches!(error(infinite.as_bytes()), InertiaError::NotFinite { triangle: 1 }));
    let word = ascii.replacen("VERTEX 1e0", "VERTEX one", 1);
    let told = error(word.as_bytes());
    assert!(matches!(told, InertiaError::BadTriangle { triangle: 1, line: Some(2), .. }), "{told:?}");
    let mut not = mesh.clone();
    not[5][1][2] = f32::NAN;
    assert!(matches!(error(&binary(&not)), InertiaError::NotFinite { triangle: 6 }));
    // Zeros that are no zip file, no text, nothing.
    assert_eq!(error(b"PK\x03\x04").code(), "E0410");
    assert_eq!(error(b"solid").code(), "E0412");
    assert_eq!(error("solid \u{fffd}\nendsolid".as_bytes()).code(), "E0410");
}

#[test]
fn surfaces_that_bound_no_body_are_told_apart() {
    let mesh = cube(-1.0, 1.0);
    let error = |mesh: &[Triangle]| Mesh::new(mesh).unwrap_err();
    let open = error(&mesh[1..]);
    let InertiaError::OpenMesh { edge, edges } = &open else { panic!("{open}") };
    assert_eq!((*edges, edge.count, edge.triangles.len()), (3, 1, 1));
    assert!(open.to_string().contains("(and 2 more edges)"), "{open}");
    let mut turned = mesh.clone();
    turned[3].swap(0, 1);
    let turned = error(&turned);
    let InertiaError::TurnedTriangle { edge, edges } = &turned else { panic!("{turned}") };
    assert!(*edges == 3 && edge.triangles.contains(&4), "{turned}");
    let mut twice = mesh.clone();
    twice.push(mesh[0]);
    assert_eq!(error(&twice).code(), "E0417");
    let inside_out = error(&turned_over(&mesh));
    assert_eq!(inside_out.to_string(), "the mesh is inside out: its volume is -8.00000");
    let mut flat: Vec<Triangle> = mesh[..1].to_vec();
    flat.extend(turned_over(&mesh[..1]));
    assert_eq!(error(&flat).code(), "E0419");
    assert_eq!(error(&[]).code(), "E0410");
    // Vertices that only look the same.
    let mut crack = mesh.clone();
    crack[0][0][0] = -0.999_999_94;
    assert_eq!(error(&crack).code(), "E0415");
    // A second body inside out is no cavity where no body is around it.
    let mut beside = cube(-2.0, 2.0);
    beside.extend(turned_over(&cube(3.0, 4.0)));
    let beside = error(&beside);
    assert!(matches!(beside, InertiaError::InsideOut { vertex: Some(_), .. }), "{beside}");
}

#[test]
fn cavities_and_corners_without_area_are_legal() {
    let mut hollow = cube(-2.0, 2.0);
    hollow.extend(turned_over(&cube(-1.0, 1.0)));
    let [a, b, _] = hollow[0];
    hollow.push([a, b, a]);
    hollow.push([b, b, b]);
    let own = body(&hollow);
    assert_eq!(own.mass.decimal(3).text, "56.0");
    // m a^2/6 of both cubes: 64*16/6 - 8*4/6.
    assert_eq!(own.principal.moments[0].value.mid_f64(), 992.0 / 6.0);
    let equal = &own.principal.equal;
    assert!(equal.len() == 1 && equal[0].proved && equal[0].moments == (0..3));
    // -0 is the same place as 0.
    let mut signs = cube(0.0, 1.0);
    signs[0][0][0] = -0.0;
    assert_eq!(body(&signs).mass.decimal(3).text, "1.00");
}

/// Coordinates of any size are exact: no cube is too small, too large or too far away.
#[test]
fn the_range_of_single_precision_is_no_limit() {
    for size in [1e-40_f32, 1e-20, 1.0, 1e20, 3e38] {
        let own = body(&cube(-size, size));
        let want = (2.0 * f64::from(size)).powi(3);
        let mass = own.mass.mid_f64();
        assert!((mass / want - 1.0).abs() < 1e-12 || want == 0.0 || !want.is_finite());
        let moment = own.principal.moments[0].value.mid_f64();
        let want = want * (2.0 * f64::from(size)).powi(2) / 6.0;
        let relative = (moment / want - 1.0).abs();
        assert!(relative < 1e-12, "{size}: {moment} {want}");
    }
    // 2^-23 is the last bit of 1.
    let small = f32::EPSILON;
    let own = body(&cube(1.0 - small, 1.0));
    assert_eq!(own.mass.mid_f64(), f64::from(small).powi(3));
}

/// A star-shaped polyhedron: a cube whose corners are anywhere on their rays.
fn star() -> impl Strategy<Value = Vec<Triangle>> {
    proptest::array::uniform8(0.25_f32..4.0).prop_map(|sizes| {
        let mesh = cube(-1.0, 1.0);
        let place = |corner: [f32; 3]| {
            let bit = |at: usize| usize::from(corner[at] > 0.0) << at;
            corner.map(|x| x * sizes[bit(0) | bit(1) | bit(2)])
        };
        mesh.into_iter().map(|triangle| triangle.map(place)).collect()
    })
}

fn times(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed(a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[j][i]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A motion by whole numbers in powers of two is exact: the tensor about the centre stays to the last bit, and the
    /// centre moves along.
    #[test]
    fn a_moved_mesh_has_the_same_tensor(mesh in star(), by in proptest::array::uniform3(-8_i8..8)) {
        // On a grid of 2^-12, sums below 16 are exact.
        let grid = |x: f32| (x * 4096.0).round() / 4096.0;
        let mesh: Vec<Triangle> = mesh.iter().map(|t| t.map(|p| p.map(grid))).collect();
        let by = by.map(f32::from);
        let moved: Vec<Triangle> = mesh
            .iter()
            .map(|t| t.map(|p| [p[0] + by[0], p[1] + by[1], p[2] + by[2]]))
            .collect();
        let (here, there) = (body(&mesh), body(&moved));
        prop_assert_eq!(tensor(&here), tensor(&there));
        for (i, by) in by.into_iter().enumerate() {
            let way = &there.centre[i] - &here.centre[i];
            prop_assert!((way.mid_f64() - f64::from(by)).abs() < 1e-15);
        }
    }

    /// Turned by any angles, I becomes R I Rᵀ up to the rounding of the coordinates; exactly for quarter turns.
    #[test]
    fn a_turned_mesh_has_a_turned_tensor(mesh in star(), a in -3.0_f64..3.0, b in -3.0_f64..3.0) {
        let (s, c, t, d) = (a.sin(), a.cos(), b.sin(), b.cos());
        let r = times([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, d, -t], [0.0, t, d]]);
        let turn = |p: [f32; 3]| {
            [0, 1, 2].map(|i| (0..3).map(|k| r[i][k] * f64::from(p[k])).sum::<f64>() as f32)
        };
        let turned: Vec<Triangle> = mesh.iter().map(|t| t.map(turn)).collect();
        let (here, there) = (body(&mesh), body(&turned));
        let want = times(times(r, tensor(&here)), transposed(r));
        let size = want[0][0] + want[1][1] + want[2][2];
        for (own, want) in tensor(&there).as_flattened().iter().zip(want.as_flattened()) {
            prop_assert!((own - want).abs() < 1e-5 * size, "{own} {want}");
        }
        let moments = |body: &Body| [0, 1, 2].map(|i| body.principal.moments[i].value.mid_f64());
        for (own, want) in moments(&there).iter().zip(moments(&here)) {
            prop_assert!((own - want).abs() < 1e-5 * size);
        }
        let quarter: Vec<Triangle> = mesh.iter().map(|t| t.map(|[x, y, z]| [-y, x, z])).collect();
        prop_assert_eq!(moments(&body(&quarter)), moments(&here));
    }

    /// Trace and determinant are those of the moments, and the triangle inequality holds.
    #[test]
    fn moments_of_points_obey_the_triangle_inequality(
        points in proptest::collection::vec((0_u32..1000, -999_i32..999, -999_i32..999, -999_i32..999), 1..12)
    ) {
        let mut table = "x,m,y,z\n".to_owned();
        for (m, x, y, z) in &points {
            table.push_str(&format!("{x}e-2,{}.5,{y}e-3,{z}\n", m));
        }
        let body = of_points(&table, 10).unwrap();
        prop_assert!(body.principal.impossible.is_none());
        let [a, b, c] = [0, 1, 2].map(|i| body.principal.moments[i].value.mid_f64());
        prop_assert!(0.0 <= a && a <= b && b <= c && c <= (a + b) * (1.0 + 1e-12));
        let own = tensor(&body);
        let trace = own[0][0] + own[1][1] + own[2][2];
        prop_assert!((trace - a - b - c).abs() <= 1e-12 * trace.abs());
        if points.len() <= 2 {
            prop_assert!(body.principal.moments[0].value.is_zero(), "a rod");
        }
        let axes = [0, 1, 2].map(|i| body.principal.moments[i].axis);
        for (i, u) in axes.iter().enumerate() {
            for (j, v) in axes.iter().enumerate() {
                let dot: f64 = u.iter().zip(v).map(|(x, y)| x * y).sum();
                prop_assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    /// Nothing panics, and what is read twice is the same.
    #[test]
    fn garbage_is_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400), solid in any::<bool>()) {
        let mut file = if solid { b"solid ".to_vec() } else { Vec::new() };
        file.extend(bytes);
        prop_assert!(Mesh::read_stl(&file).is_err());
        let _ = of_points(&String::from_utf8_lossy(&file), 10);
    }
}
