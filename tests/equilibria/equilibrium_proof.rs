//! Searched equilibria are proved to be there, and known to as many digits as wanted.
#![cfg(feature = "engine")]

use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::{Kind, Options};
use librate::number::Number;
use librate::oscillation::normal_modes;
use librate::precision::{Ball, Big};
use librate::syntax::parse;
use librate_core::linearize::Origin;
use librate_core::precision::Magnitude;
use proptest::prelude::*;

fn at(text: &str) -> Linearized {
    let file = parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    linearize(model).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn number(text: &str) -> Number {
    match text.strip_prefix('-') {
        Some(rest) => Number::parse(rest).unwrap().neg(),
        None => Number::parse(text).unwrap(),
    }
}

/// Whether `own` holds a number known to 40 digits.
fn holds(own: &Big, want: &Big) -> bool {
    let slack = want.abs_upper().to_f64() * 1e-39;
    (own - want).with_added_radius(Magnitude::from_f64(slack)).contains_zero()
}

fn check(linearized: &Linearized, want: &[Big]) {
    let equilibrium = linearized.equilibrium();
    assert!(equilibrium.proved);
    let precise = linearized.precisely(400).unwrap();
    let scale = want.iter().map(|x| x.mid_f64().abs()).fold(0.0, f64::max);
    for (i, want) in want.iter().enumerate() {
        let own = &equilibrium.values[i];
        assert!(holds(&Big::from_ball(own, 400), want), "{own:?} {want:?}");
        let more = &precise.equilibrium[i];
        assert!(holds(more, want), "{} {}", more.decimal(45).text, want.decimal(45).text);
        if equilibrium.origins[i] == Origin::Found {
            assert!(own.radius <= 1e-26 * scale.max(1e-300), "{own:?}");
            assert!(more.radius().to_f64() <= 1e-110 * scale.max(1e-300), "{more:?}");
        }
    }
}

fn all_entries(linearized: &Linearized) {
    // M and K in balls hold those at 400 bits.
    let precise = linearized.precisely(400).unwrap();
    let (velocity, stiffness) = linearized.velocity_and_stiffness();
    let mut pairs = vec![(linearized.mass(), &precise.mass), (stiffness, &precise.stiffness)];
    pairs.extend(precise.velocity.as_ref().map(|own| (velocity, own)));
    for (balls, bigs) in pairs {
        for (ball, big) in balls.iter().zip(bigs) {
            assert!((&Big::from_ball(ball, 400) - big).contains_zero());
            assert!(big.radius().to_f64() <= 1e-100 * (1.0 + big.mid_f64().abs()));
        }
    }
    let modes = linearized.zero_modes();
    let precise = linearized.precise_zero_modes(&precise, &modes).unwrap();
    assert_eq!(modes.len(), precise.len());
    for (mode, precise) in modes.iter().zip(&precise) {
        assert_eq!(mode.meaning, precise.meaning);
        for (ball, big) in mode.vector.iter().zip(&precise.vector) {
            assert!((&Big::from_ball(ball, 400) - big).contains_zero());
        }
    }
}

/// M_ij = l_i l_j cos(θ_i - θ_j) Σ m_k over k >= i, j: prefix sums share their gradients, which more than a few do in evaluation, too.
#[test]
fn inertia_of_a_long_pendulum_is_the_closed_form() {
    let text = "model long  param N = 24  param l[i in 1..N] = 1 + i/7  param m[i in 1..N] = 1/i  coord q[1..N]
        equilibrium q[i in 1..N] = i/5
        let x[0] = 0  let x[i in 1..N] = x[i-1] + l[i]*sin(q[i])
        let y[0] = 0  let y[i in 1..N] = y[i-1] - l[i]*cos(q[i])
        T = sum(i in 1..N, 1/2*m[i]*(x[i]'^2 + y[i]'^2))
        V = sum(i in 1..N, 1/2*(q[i] - i/5)^2)";
    let linearized = at(&text.replace("  ", "\n"));
    all_entries(&linearized);
    let (mass, n) = (linearized.mass(), 24);
    let ratio = |a: usize, b: usize| Ball::exact(a as f64) / Ball::exact(b as f64);
    for (i, j) in (1..=n).flat_map(|i| (1..=n).map(move |j| (i, j))) {
        let load = (i.max(j)..=n).fold(Ball::ZERO, |sum, k| sum + ratio(1, k));
        let want = ratio(7 + i, 7) * ratio(7 + j, 7) * (ratio(i, 5) - ratio(j, 5)).cos() * load;
        let own = mass[i - 1 + n * (j - 1)];
        assert!((own - want).contains_zero() && own.radius < 1e-28 * own.mid_f64().abs(), "{i} {j} {own:?} {want:?}");
    }
}

#[test]
fn references_are_held_by_what_is_found() {
    let mut searched = Vec::new();
    for entry in std::fs::read_dir("models").unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        if path.extension().is_none_or(|extension| extension != "lag") || name == "ubiquitin" {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let reference = std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap();
        let reference: serde_json::Value = serde_json::from_str(&reference).unwrap();
        let (None, Ok(file)) = (reference.get("error"), parse(&text)) else {
            continue;
        };
        let Ok(model) = elaborate(&file, &TableTexts::new(), &Settings::new()) else {
            continue;
        };
        let linearized = linearize(model).unwrap();
        let want: Vec<Big> = reference["equilibrium"]
            .as_array()
            .unwrap()
            .iter()
            .map(|value| Big::from_number(&number(value.as_str().unwrap()), 400))
            .collect();
        check(&linearized, &want);
        if linearized.dimension() <= 30 {
            all_entries(&linearized);
        }
        if linearized.equilibrium().origins.contains(&Origin::Found) {
            searched.push(name);
        }
    }
    searched.sort();
    for name in ["charged_pendulums", "double_well", "ion_chain"] {
        assert!(searched.iter().any(|own| own == name), "{searched:?}");
    }
}

#[test]
fn a_degenerate_equilibrium_is_not_called_proved() {
    let flat = at("coord x  T = 1/2*x'^2  V = (x^2 - 2)^4  guess x = 1");
    let equilibrium = flat.equilibrium();
    assert!(!equilibrium.proved);
    let precise = flat.precisely(200).unwrap();
    assert_eq!(precise.equilibrium[0].to_ball().mid_f64(), equilibrium.values[0].mid_f64());
    // Where it is a simple number no force acts there exactly, and that is seen.
    for (well, want) in [("x^4", 0.0), ("(x - 3/2)^4", 1.5), ("(x + 1)^6 - 7", -1.0)] {
        let simple = at(&format!("coord x  T = 1/2*x'^2  V = {well}  guess x = 1"));
        let equilibrium = simple.equilibrium();
        assert!(equilibrium.proved, "{well}");
        assert!(equilibrium.values[0].is_exact() && equilibrium.values[0].mid_f64() == want);
    }
    // A valley along no straight line and no circle: nothing is neutral by a symmetry.
    let valley = at("coord x, y  T = x'^2 + y'^2  V = (y - cos(x))^2  guess x = 1  guess y = 2");
    assert!(!valley.equilibrium().proved);
    // Unless the search ends in a point where the forces are 0 and not just small.
    let exact = at("coord x  T = x'^2  V = (x - 1)^4  guess x = 1");
    assert!(exact.equilibrium().proved && exact.equilibrium().values[0].is_exact());
    assert!(exact.precisely(200).unwrap().equilibrium[0].is_exact());
    // Where nothing is searched for, nothing has to be proved.
    assert!(at("coord x  T = x'^2  V = x^4").equilibrium().proved);
}

/// cos th = g/(R w^2), just above the critical speed: th is small and K smaller.
#[test]
fn near_a_bifurcation_the_radius_is_honest() {
    for (speed, digits) in [("1.01", 25), ("1.0001", 22), ("1.0000001", 17), ("1.0000000001", 11)] {
        let text =
            format!("coord th  T = 1/2*th'^2  V = -1/2*{speed}*sin(th)^2 - cos(th)  guess th = 3*({speed} - 1)^(1/2)");
        let found = at(&text);
        assert!(found.equilibrium().proved, "{speed}");
        let cos = &Big::one(400) / &Big::from_number(&number(speed), 400);
        let want = cos.acos();
        let own = &found.equilibrium().values[0];
        assert!((&Big::from_ball(own, 400) - &want).contains_zero(), "{own:?}");
        assert!(own.radius <= own.mid_f64() * 10f64.powi(-digits), "{speed}: {own:?}");
        let precise = &found.precisely(400).unwrap().equilibrium[0];
        assert!((precise - &want).contains_zero());
        assert!(precise.radius().to_f64() < 1e-90);
    }
}

#[test]
fn the_shape_of_a_free_body_is_proved_whatever_its_place() {
    // Three atoms in a plane that may move and turn; distances 1 in the middle of three bonds.
    let text = "
        coord r[1..3, 1..2]
        let a = sqrt((r[1, 1] - r[2, 1])^2 + (r[1, 2] - r[2, 2])^2)
        let b = (r[2, 1] - r[3, 1])^2 + (r[2, 2] - r[3, 2])^2
        let c = sqrt((r[1, 1] - r[3, 1])^2 + (r[1, 2] - r[3, 2])^2)
        T = sum(i in 1..3, r[i, 1]'^2 + r[i, 2]'^2)
        V = (a - 1)^4 + (a^2 - 1)^2 + (b - 2)^2 + (c - 1.3)^2
        guess r[1, 1] = 0.1
        guess r[2, 1] = 1.05
        guess r[3, 2] = 1.2
    ";
    let found = at(text);
    assert!(found.equilibrium().origins.contains(&Origin::Found));
    assert!(found.equilibrium().proved);
    let precise = found.precisely(400).unwrap();
    let r = &precise.equilibrium;
    let distance = |a: usize, b: usize| {
        let (x, y) = (&r[2 * a] - &r[2 * b], &r[2 * a + 1] - &r[2 * b + 1]);
        (&x.powi(2) + &y.powi(2)).sqrt()
    };
    let one = Big::one(400);
    assert!((&distance(0, 1) - &one).contains_zero());
    assert!((&distance(1, 2) - &Big::from_f64(2.0, 400).sqrt()).contains_zero());
    assert!(distance(0, 2).radius().to_f64() < 1e-100);
    let modes = found.precise_zero_modes(&precise, &found.zero_modes());
    assert_eq!(modes.unwrap().len(), 3);
    all_entries(&found);
    // A chain that may slide, with a spring that is not linear.
    let chain = at("
        coord x[1..4]
        T = sum(i in 1..4, i*x[i]'^2)
        V = sum(i in 1..3, exp(x[i + 1] - x[i]) - 2*i*(x[i + 1] - x[i]))
        guess x[2] = 1
    ");
    assert!(chain.equilibrium().proved);
    let x = chain.precisely(300).unwrap().equilibrium;
    for i in 0..3 {
        let want = Big::from_number(&Number::from(2 * (i as i64 + 1)), 300).ln();
        let gap = &x[i + 1] - &x[i];
        assert!((&gap - &want).contains_zero() && gap.radius().to_f64() < 1e-80);
    }
}

/// With a coordinate given, what it holds is not neutral.
#[test]
fn a_given_coordinate_fixes_the_others() {
    let text = "
        coord x, y, z
        T = x'^2 + y'^2 + z'^2
        V = (x - y - 1)^2 + (x - y - 1)^4 + (y - z)^2*(1 + (x - y - 1)^2)
        equilibrium x = pi
    ";
    let found = at(text);
    assert!(found.equilibrium().proved);
    let y = &found.precisely(300).unwrap().equilibrium[1];
    let want = &Big::pi(300) - &Big::one(300);
    assert!((y - &want).contains_zero() && y.radius().to_f64() < 1e-85);
    assert!(!found.equilibrium().values[1].sub_contains(&want));
}

/// In SI a molecule is tiny, light and stiff; a planet is not.
#[test]
fn scales_are_no_obstacle() {
    for (mass, length, energy) in
        [("1e-26", "1e-10", "1e-19"), ("1e24", "1e11", "1e33"), ("1", "1e-30", "1"), ("1e-30", "1", "1e30")]
    {
        let text = format!(
            "param m = {mass}  param a = {length}  param e = {energy}
             coord x, y
             T = 1/2*m*x'^2 + 3*m*y'^2
             V = e*exp(x/a) - 2*e*x/a + e*(x/a)*(y/a)^2 + e*(y/a)^4 - e*y/a/3"
        );
        let found = at(&text);
        assert!(found.equilibrium().proved, "{text}");
        let scale = length.parse::<f64>().unwrap();
        let precise = found.precisely(300).unwrap();
        for (own, more) in found.equilibrium().values.iter().zip(&precise.equilibrium) {
            assert!((&Big::from_ball(own, 300) - more).contains_zero());
            assert!(own.radius < 1e-27 * scale, "{own:?}");
            assert!(more.radius().to_f64() < 1e-80 * scale);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// What is proved holds what is known better, at every precision, soft or stiff.
    #[test]
    fn enclosures_are_nested(
        forces in proptest::collection::vec(-2.0..2.0f64, 4),
        soft in 0..10u32,
        bits in 60..300usize,
        free in any::<bool>(),
    ) {
        let walls = if free { "0" } else { "1/10^s*x[1]^2 + x[4]^4" };
        let text = format!(
            "param s = {soft}
             coord x[1..4]
             T = sum(i in 1..4, i*x[i]'^2)
             V = {walls} + sum(i in 1..3, exp(x[i + 1] - x[i]) + 1/10^s*(x[i + 1] - x[i])^4)
                 - 2*(x[2] - x[1]) - 1/3*(x[4] - x[3]) - sin({})*(x[3] - x[1]) - ({})*(x[3] - x[2])
             guess x[1] = {}
             guess x[3] = {}",
            forces[0], forces[1].abs() / 8.0 + 1.2, forces[2], forces[3],
        );
        let file = parse(&text).unwrap();
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
        let Ok(found) = linearize(model) else { return Ok(()); };
        prop_assert!(found.equilibrium().proved, "{}", text);
        let (some, more) = (found.precisely(bits).unwrap(), found.precisely(900).unwrap());
        let gap = |x: &[Big], i: usize| &x[i + 1] - &x[i];
        let first: Vec<Big> =
            found.equilibrium().values.iter().map(|x| Big::from_ball(x, 900)).collect();
        for i in 0..3 {
            // A free chain may be refined at another place; its shape is the same.
            let best = gap(&more.equilibrium, i);
            prop_assert!((&gap(&some.equilibrium, i) - &best).contains_zero(), "{}", text);
            prop_assert!((&gap(&first, i) - &best).contains_zero(), "{}", text);
            prop_assert!(best.radius().to_f64() < 1e-230);
        }
    }
}

trait Holds {
    fn sub_contains(&self, want: &Big) -> bool;
}

impl Holds for Ball {
    /// Whether the ball misses the number.
    fn sub_contains(&self, want: &Big) -> bool {
        !(&Big::from_ball(self, 300) - want).contains_zero()
    }
}

/// Most residues modulo a prime are those of some fraction: a root passes for one unless it is tried in
/// true numbers.
#[test]
fn an_irrational_ratio_is_not_taken_for_a_fraction() {
    for square in [2, 3, 5, 6, 7, 10, 11, 13, 17, 19] {
        let found = at(&format!(
            "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)
             V = 1/2*(sqrt({square})*x - y)^2 + cosh(z) - 2*z  guess z = 1"
        ));
        let modes = found.zero_modes();
        let [mode] = modes.as_slice() else {
            panic!("{square}: {modes:?}");
        };
        let ratio = mode.vector[1] / mode.vector[0];
        let off = ratio * ratio - Ball::from(f64::from(square));
        assert!(off.contains_zero() && off.radius < 1e-25, "{square}");
        assert!(mode.vector[2].is_zero());
        let normal = normal_modes(&found, &Options::default()).unwrap();
        let kinds: Vec<Kind> = normal.modes.iter().map(|mode| mode.kind).collect();
        assert_eq!(kinds, [Kind::Zero, Kind::Oscillation, Kind::Oscillation], "{square}");
    }
}
