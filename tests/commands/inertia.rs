//! Principal moments and axes against references of 40 digits that are computed by other means
//! (tests/reference/inertia.py), the theorems of Steiner and König, and files that are wrong.
#![cfg(feature = "cli")]

use crate::cli_support;

use boon::{Compiler, Schemas};
use cli_support::{printed, run, with_input};
use librate::expr::ZeroVerdict;
use librate::inertia::{self, Amount, Body, InertiaError, Mesh, NamedTensor};
use librate::model::{Settings, TableTexts, elaborate};
use librate::number::Number;
use librate::precision::Big;
use librate_studies::inertia::Impossible;
use serde_json::Value;

const BITS: usize = 400;

fn big(value: &Value) -> Big {
    let text = value.as_str().unwrap();
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let number = Number::parse(digits).unwrap();
    Big::from_number(&if negative { number.neg() } else { number }, BITS)
}

/// `own` encloses a number whose first 40 digits are `want`.
fn assert_near(what: &str, own: &Big, want: &Value) {
    let want = big(want);
    let off = (own - &want).abs();
    let slack = want.mid_f64().abs() * 1e-39 + own.radius().to_f64();
    assert!(off.mid_f64() <= slack, "{what}: {} is not {}", own.mid_f64(), want.mid_f64());
}

fn check_body(name: &str, body: &Body) {
    let text = std::fs::read_to_string(format!("tests/reference/inertia/{name}.json")).unwrap();
    let want: Value = serde_json::from_str(&text).unwrap();
    assert_near(name, &body.mass, &want["mass"]);
    for i in 0..3 {
        assert_near(name, &body.centre[i], &want["centre"][i]);
        for j in 0..3 {
            assert_near(name, &body.tensor[i][j], &want["tensor"][i][j]);
        }
        let moment = &body.principal.moments[i];
        let precise = moment.precise.clone();
        let own = precise.unwrap_or_else(|| Big::from_ball(&moment.value, BITS));
        assert_near(name, &own, &want["moments"][i]);
        check_axis(name, body, i);
    }
}

/// I n = lambda n, as far as the bound of n goes.
fn check_axis(name: &str, body: &Body, at: usize) {
    let moment = &body.principal.moments[at];
    let value = moment.value.mid_f64();
    let largest = body.principal.moments[2].value.mid_f64();
    assert!(moment.axis_error_bound < 1e-15, "{name}");
    for row in &body.tensor {
        let image: f64 = row.iter().zip(&moment.axis).map(|(e, n)| e.mid_f64() * n).sum();
        let at = std::ptr::from_ref(row) as usize - body.tensor.as_ptr() as usize;
        let n = moment.axis[at / size_of::<[Big; 3]>()];
        assert!((image - value * n).abs() < 1e-14 * largest, "{name}");
    }
}

fn mesh(name: &str) -> Mesh {
    Mesh::read_stl(&std::fs::read(format!("models/data/{name}.stl")).unwrap()).unwrap()
}

#[test]
fn bodies_agree_with_references() {
    for name in ["tetrahedron", "box", "box_with_cavity", "ellipsoid"] {
        check_body(name, &mesh(name).body(&Amount::Unit, 38).unwrap());
    }
    let table = std::fs::read_to_string("models/data/body_points.csv").unwrap();
    check_body("body_points", &inertia::of_points(&table, 38).unwrap());
}

#[test]
fn printed_digits_are_those_of_the_references() {
    for (name, file) in [
        ("tetrahedron", "models/data/tetrahedron.stl"),
        ("ellipsoid", "models/data/ellipsoid.stl"),
        ("body_points", "models/data/body_points.csv"),
    ] {
        let text = std::fs::read_to_string(format!("tests/reference/inertia/{name}.json")).unwrap();
        let want: Value = serde_json::from_str(&text).unwrap();
        for digits in [4, 10, 25] {
            let out = printed(&["inertia", file, "--json", "--digits", &digits.to_string()]);
            let own: Value = serde_json::from_str(&out).unwrap();
            let same = |own: &Value, want: &Value| {
                assert_eq!(own.as_str().unwrap(), big(want).decimal(digits).text, "{name}");
            };
            same(&own["mass_digits"], &want["mass"]);
            for i in 0..3 {
                same(&own["centre_digits"][i], &want["centre"][i]);
                same(&own["moments"][i]["moment_digits"], &want["moments"][i]);
            }
        }
    }
}

/// The numbers of `models/pendulum_from_mesh.lag` are those of its mesh.
#[test]
fn the_pendulum_has_the_numbers_of_its_mesh() {
    let amount = Amount::density("2700").unwrap();
    let body = mesh("ellipsoid").body(&amount, 10).unwrap();
    let text = std::fs::read_to_string("models/pendulum_from_mesh.lag").unwrap();
    let stands = |value: &Big| {
        let digits = value.decimal(10).text;
        assert!(text.contains(&digits), "{digits}");
    };
    stands(&body.mass);
    body.centre.iter().for_each(stands);
    body.tensor.as_flattened().iter().for_each(stands);
}

fn tensors(text: &str, digits: usize) -> Result<Vec<NamedTensor>, Vec<InertiaError>> {
    let file = librate::syntax::parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new().only_tensors()).unwrap();
    inertia::of_model(&model, digits)
}

fn moments(tensor: &NamedTensor, digits: usize) -> Vec<String> {
    let moments = tensor.principal.moments.iter();
    let text = |precise: &Big| precise.decimal(digits).text;
    moments
        .map(|m| match &m.precise {
            Some(precise) => text(precise),
            None => text(&Big::from_ball(&m.value, BITS)),
        })
        .collect()
}

/// A turned box has the moments of the box and the columns of R for axes.
#[test]
fn a_turned_box_keeps_its_moments() {
    let found = tensors(
        "param a = 0.7  param b = 1.1  let R = rot_z(a)*rot_x(b)
         let I = R*inertia_box(12, 1, 2, 3)*transpose(R)",
        60,
    )
    .unwrap();
    let [own] = found.as_slice() else { panic!() };
    let zeros = |digits: usize| "0".repeat(digits);
    let want = [format!("5.{}", zeros(59)), format!("10.{}", zeros(58)), format!("13.{}", zeros(58))];
    assert_eq!(moments(own, 60), want);
    let (a, b) = (0.7_f64, 1.1_f64);
    // The columns of R, for the moments 13, 10, 5 about x, y and z of the box; the largest component positive.
    let columns = [
        [a.sin() * b.sin(), -a.cos() * b.sin(), b.cos()],
        [-a.sin() * b.cos(), a.cos() * b.cos(), b.sin()],
        [a.cos(), a.sin(), 0.0],
    ];
    for (moment, column) in own.principal.moments.iter().zip(columns) {
        let largest = column.iter().fold(0.0_f64, |most, x| if x.abs() > most.abs() { *x } else { most });
        for (own, want) in moment.axis.iter().zip(column) {
            assert!((own - want * largest.signum()).abs() < 1e-15);
        }
    }
    assert!(own.principal.equal.is_empty() && own.principal.impossible.is_none());
}

#[test]
fn equal_and_vanishing_moments_are_proved() {
    let found = tensors(
        "param m = 2.5  param r = 1/3  param a = 0.3
         let R = rot_y(a)*rot_x(2*a)
         let ball = inertia_sphere(m, r)
         let rod = R*inertia_rod(m, r)*transpose(R)
         let coin = R*inertia_cylinder(m, r, 0)*transpose(R)
         let point = inertia_point(m, [sqrt(2), pi, -1])
         let nothing = 0*inertia_rod(m, r)
         let upright = inertia_cylinder(m, r, 3*r)
         let near = [[1, 0, 0], [0, 1 + 1e-40, 0], [0, 0, 1.5]]
         let nearer = [[1, 0, 0], [0, 1 + 1e-300, 0], [0, 0, 1.5]]",
        12,
    )
    .unwrap();
    let of = |name: &str| {
        let found = found.iter().find(|tensor| tensor.name == name);
        let principal = &found.unwrap().principal;
        let zeros = principal.moments.iter().filter(|m| m.value.is_zero());
        let equal: Vec<_> = principal.equal.iter().map(|e| (e.moments.clone(), e.proved, e.across)).collect();
        assert!(principal.impossible.is_none(), "{name}");
        (zeros.count(), equal)
    };
    assert_eq!(of("ball"), (0, vec![(0..3, true, None)]));
    assert_eq!(of("rod"), (1, vec![(1..3, true, None)]));
    assert_eq!(of("coin"), (0, vec![(0..2, true, None)]));
    assert_eq!(of("point"), (1, vec![(1..3, true, None)]));
    assert_eq!(of("nothing"), (3, vec![(0..3, true, None)]));
    assert_eq!(of("upright").1, [(1..3, true, Some(2))]);
    assert_eq!(of("near").1, []);
    // Different by less than any bound at hand: not told apart, and not called equal.
    assert_eq!(of("nearer").1, [(0..2, false, None)]);
}

#[test]
fn tensors_that_no_body_has_are_told() {
    let found = tensors(
        "let A = [[1, 0, 0], [0, 2, 0], [0, 0, 3.0001]]  let B = [[1, 0, 0], [0, -2, 0], [0, 0, 1]]
         let C = [[1, 0, 0], [0, 2, 0], [0, 0, 3]]",
        10,
    )
    .unwrap();
    let why: Vec<Option<Impossible>> = found.iter().map(|t| t.principal.impossible).collect();
    assert_eq!(why, [Some(Impossible::Triangle), Some(Impossible::Negative), None]);
    // What the file says to be a stiffness may have any eigenvalues.
    let stiffness = tensors("param k : N/m = 1  let K = k*[[1, 0, 0], [0, 1, 0], [0, 0, 5]]", 10);
    let stiffness = stiffness.unwrap();
    assert_eq!(stiffness[0].unit.as_deref(), Some("N/m"));
    assert_eq!(stiffness[0].warning(), None);
    let body = tensors("param A : kg*m^2 = 1  let I = A*[[1, 0, 0], [0, 1, 0], [0, 0, 5]]", 10);
    assert_eq!(body.unwrap()[0].warning().unwrap().code, Some("W0201"));
}

/// `check` and `modes` warn only where a matrix is certainly a tensor of inertia.
#[test]
fn other_commands_warn_where_a_tensor_turns() {
    let model = |energy: &str| {
        format!(
            "coord a, b  let I = [[1, 0, 0], [0, 1, 0], [0, 0, 5]]
             let w = angular_velocity(rot_x(a)*rot_y(b))  T = 1/2*{energy}  V = a^2 + b^2"
        )
    };
    for (energy, warned) in
        [("dot(w, I*w)", true), ("dot(I*w, w)", true), ("dot(w, 2*I*w)", false), ("(a'^2 + b'^2 + 0*I[1,1])", false)]
    {
        for command in ["check", "modes"] {
            let run = with_input(&[command, "-"], &model(energy));
            assert_eq!(run.status, 0, "{}", run.err);
            assert_eq!(run.err.contains("W0201"), warned, "{energy}: {}", run.err);
        }
    }
}

/// Wherever a tensor is meant, by name or written in full, through `steiner` and turned: 5 > 1 + 1.
#[test]
fn tensors_that_no_body_has_are_told_where_they_are_used() {
    let bad = "[[1, 0, 0], [0, 1, 0], [0, 0, 5]]";
    let good = "[[1, 0, 0], [0, 1, 0], [0, 0, 2]]";
    for (matrix, warned) in [(bad, 1), (good, 0)] {
        for energy in [
            format!("let I = {matrix}  T = 1/2*about(I, [0, 0, 1])*a'^2"),
            format!("let I = {matrix}  T = 1/2*about(steiner(I, 2, [1, 0, 0]), [0, 0, 1])*a'^2"),
            format!("let I = rot_x(1)*{matrix}*transpose(rot_x(1))  T = 1/2*about(I, [0, 0, 1])*a'^2"),
            format!("T = 1/2*about({matrix}, [0, 0, 1])*a'^2"),
            format!("T = 1/2*about(p*{matrix}, [0, 0, 1])*a'^2"),
            format!("let I = {matrix}  T = 1/2*about(rot_x(p)*I*transpose(rot_x(p)), [0, 0, 1])*a'^2"),
            format!("let w = angular_velocity(rot_x(a))  T = 1/2*dot(w, {matrix}*w)"),
        ] {
            let model = format!("param p = 3  coord a  {energy} + 0*p*a'^2  V = a^2");
            let run = with_input(&["modes", "-"], &model);
            assert_eq!(run.status, 0, "{}", run.err);
            assert_eq!(run.err.matches("W0201").count(), warned, "{model}: {}", run.err);
        }
    }
    // What depends on an index or on a coordinate is left alone, and so is what lacks a value.
    for energy in [
        format!("T = sum(i in 1..2, 1/2*about(i*{bad}, [0, 0, 1])*a'^2)"),
        format!("T = 1/2*about((2 + sin(a))*{bad}, [0, 0, 1])*a'^2"),
    ] {
        let run = with_input(&["modes", "-"], &format!("coord a  {energy}  V = a^2"));
        assert_eq!((run.status, run.err.as_str()), (0, ""));
    }
}

#[test]
fn what_is_no_tensor_is_told() {
    let error = |text: &str| {
        let errors = tensors(text, 10).unwrap_err();
        errors.iter().map(|error| (error.code(), error.to_string())).collect::<Vec<_>>()
    };
    assert_eq!(error("param m = 1  let J = [m, m, m]")[0].0, "E0401");
    let run = with_input(&["inertia", "-"], "coord x  let R = rot_x(x)  T = x'^2  V = x^2");
    assert_eq!(run.status, 1);
    assert!(run.err.contains("E0401") && run.err.contains("depends on `x`"), "{}", run.err);
    let run = with_input(&["inertia", "-"], "param a = 1  let R = rot_x(a)");
    assert!(run.err.contains("not symmetric: entries (2, 3) and (3, 2) differ"), "{}", run.err);
    // Every one without a value is named.
    let missing = error("param m  param r = 1  let A = inertia_sphere(m, r)  let B = 2*A");
    assert_eq!(missing.len(), 2);
    assert!(missing.iter().all(|(code, text)| *code == "E0402" && text.contains("`m`")));
    let run = with_input(&["inertia", "-", "--set", "m=5/2"], "param m  let A = inertia_sphere(m, 1)");
    assert!(run.out.contains("1.000000000"), "{}", run.out);
}

#[test]
fn families_are_read_member_by_member() {
    let found = tensors(
        "param r[1..3] = [1, 2, 3]
         let I[k in 1..2] = inertia_sphere(5, r[k])  let I[3] = inertia_shell(3, r[3])
         let x[k in 1..3] = r[k]^2",
        10,
    );
    let found = found.unwrap();
    let names: Vec<&str> = found.iter().map(|tensor| tensor.name.as_str()).collect();
    assert_eq!(names, ["I[1]", "I[2]", "I[3]"]);
    let first = found.iter().map(|tensor| moments(tensor, 5)[0].clone());
    assert_eq!(first.collect::<Vec<_>>(), ["2.0000", "8.0000", "18.000"]);
}

/// Whether the named expression `D` is identically 0, in coordinates, velocities and parameters.
fn vanishes(text: &str) -> bool {
    let text = format!("{text}\nlet matrix = [[D, 0, 0], [0, 0, 0], [0, 0, 0]]");
    let file = librate::syntax::parse(&text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new().only_tensors()).unwrap();
    let matrix = model.tensors.iter().find(|tensor| tensor.name == "matrix");
    model.pool.is_zero(matrix.unwrap().entries[0][0]) == ZeroVerdict::Zero
}

const TURNED: &str = "param m  param a  param b  param c  param d[1..3]
    coord x, y, z, u, v, s
    let R = rot_z(u)*rot_x(v)*rot_z(s)  let w = angular_velocity(R)
    let I = inertia_box(m, a, b, c)  let r = [x, y, z]\n";

/// T = 1/2 M v^2 + 1/2 omega . I . omega is what eight points have with the same mass and tensor.
#[test]
fn energy_is_that_of_the_centre_and_of_rotation() {
    let mut text = TURNED.to_owned();
    let mut sum = Vec::new();
    for point in 0..8 {
        let sign = |bit: usize| if point >> bit & 1 == 1 { "" } else { "-" };
        text.push_str(&format!("let e{point} = r + R*[{}a, {}b, {}c]/(2*sqrt(3))\n", sign(0), sign(1), sign(2)));
        sum.push(format!("dot(e{point}', e{point}')"));
    }
    let points = format!("m/16*({})", sum.join(" + "));
    let whole = "1/2*m*dot(r', r') + 1/2*dot(w, I*w)";
    assert!(vanishes(&format!("{text} let D = {whole} - {points}")));
    assert!(!vanishes(&format!("{text} let D = {whole} - 2*{points}")));
}

/// Steiner: about a point of the body that is at rest, only rotation is left.
#[test]
fn energy_about_another_point_is_that_of_the_moved_tensor() {
    let at_rest = "let p = R*d  let T0 = 1/2*m*dot(p', p') + 1/2*dot(w, I*w)";
    let moved = "1/2*dot(w, steiner(I, m, d)*w)";
    assert!(vanishes(&format!("{TURNED} {at_rest} let D = T0 - {moved}")));
    assert!(!vanishes(&format!("{TURNED} {at_rest} let D = T0 - 1/2*dot(w, I*w)")));
}

/// About its axis with the motion of the centre, or about the line of contact.
#[test]
fn a_rolling_cylinder_has_one_energy() {
    let text = "param m  param r  param h  coord phi
        let I = inertia_cylinder(m, r, h)  let x = r*phi  let n = [0, 0, 1]
        let centre = 1/2*m*x'^2 + 1/2*about(I, n)*phi'^2
        let contact = 1/2*about(steiner(I, m, [0, r, 0]), n)*phi'^2";
    assert!(vanishes(&format!("{text} let D = centre - contact")));
    assert!(vanishes(&format!("{text} let D = contact - 3/4*m*r^2*phi'^2")));
}

fn schema(value: &Value) {
    let mut all = Schemas::new();
    let index = Compiler::new().compile("schema/inertia.schema.json", &mut all).unwrap();
    if let Err(error) = all.validate(value, index) {
        panic!("{value}: {error}");
    }
    let mut wrong = value.clone();
    wrong["moments"] = Value::Null;
    wrong["tensors"] = Value::Null;
    assert!(all.validate(&wrong, index).is_err());
}

#[test]
fn json_is_what_the_schema_says() {
    for arguments in [
        vec!["models/box_on_gimbals.lag"],
        vec!["models/physical_pendulum_steiner.lag", "--digits", "30"],
        vec!["models/data/body_points.csv"],
        vec!["models/data/ellipsoid.stl", "--mass", "1/3"],
        vec!["models/data/box_with_cavity.stl"],
    ] {
        let mut all = vec!["inertia", "--json"];
        all.extend(arguments);
        schema(&serde_json::from_str(&printed(&all)).unwrap());
    }
}

#[test]
fn what_is_printed() {
    let mut out = String::new();
    for arguments in [
        ["models/box_on_torsion_wire.lag"].as_slice(),
        &["models/physical_pendulum_steiner.lag"],
        &["models/data/body_points.csv"],
        &["models/data/box_with_cavity.stl"],
        &["models/data/tetrahedron.stl", "--density", "2700", "--digits", "5"],
    ] {
        let mut all = vec!["inertia"];
        all.extend(arguments);
        out.push_str(&format!("$ librate {}\n{}\n", all.join(" "), printed(&all)));
    }
    insta::assert_snapshot!("inertia", out);
}

#[test]
fn usage_is_checked() {
    let status = |arguments: &[&str]| run(arguments).status;
    let mesh = "models/data/box.stl";
    assert_eq!(status(&["inertia", mesh, "--mass", "0"]), 2);
    assert_eq!(status(&["inertia", mesh, "--density", "x"]), 2);
    assert_eq!(status(&["inertia", mesh, "--density", "1", "--mass", "1"]), 2);
    assert_eq!(status(&["inertia", mesh, "--set", "m=1"]), 2);
    assert_eq!(status(&["inertia", "models/box_on_gimbals.lag", "--mass", "1"]), 2);
    assert_eq!(status(&["inertia", "models/data/none.stl"]), 1);
    assert_eq!(status(&["inertia", "models"]), 1);
    let run = with_input(&["inertia", "-"], "mass, x, y, z\n1, 0, 0, 0\n-2, 0, 0, 1\n");
    assert_eq!(run.status, 1);
    assert!(run.err.contains("E0408") && run.err.contains("<stdin>:3:1"), "{}", run.err);
}

/// Angles that are singular at the equilibrium, at rest, in a steady motion, with friction and under a constraint.
#[test]
fn gimbal_lock_is_told_for_every_kind_of_model() {
    let turning = "coord a, b, c  let R = rot_z(a)*rot_x(b)*rot_z(c)  let w = angular_velocity(R)
        let I = inertia_box(1, 1, 2, 3)\n";
    for rest in [
        "T = 1/2*dot(w, I*w)  V = a^2 + b^2 + c^2",
        "T = 1/2*dot(w, inertia_cylinder(1, 1, 2)*w)  V = cos(b)  equilibrium c' = 100",
        "T = 1/2*dot(w, I*w)  V = a^2 + b^2 + c^2  dissipation = a'^2 + b'^2 + c'^2",
        "coord x  T = 1/2*dot(w, I*w) + x'^2  V = a^2 + b^2 + c^2 + x^2  constraint x = b",
    ] {
        let run = with_input(&["modes", "-"], &format!("{turning}{rest}"));
        assert_eq!(run.status, 1, "{rest}");
        assert!(run.err.contains("E0318"), "{rest}: {}", run.err);
        assert!(run.err.contains("along a - c") && run.err.contains("gimbal lock"), "{}", run.err);
    }
    // A coordinate without inertia anywhere is another mistake.
    let run = with_input(&["modes", "-"], "coord a, b, x  T = a'^2 + x'^2  V = a^2 + x^2  constraint x = a");
    assert!(run.err.contains("E0306"), "{}", run.err);
}
