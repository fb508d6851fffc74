//! Parameter studies against the certified results of the same sets, one by one.
#![cfg(feature = "engine")]

use crate::batch_support;
use crate::common;

use std::path::{Path, PathBuf};

use batch_support::{check_exponents, check_vectors, model, random};
use common::load;
use faer::c64;
use librate::batch::{Options, Outcome, Study, StudyError};
use librate::linearize::linearize;
use librate::model::Model;
use librate::modes::Kind;
use librate::oscillation::normal_modes;
use librate::precision::Ball;
use librate_studies::batch::Solution;

/// The parameters that may vary and their values.
fn free_parameters(model: &Model) -> (Vec<String>, Vec<f64>) {
    let mut free = (Vec::new(), Vec::new());
    for parameter in &model.parameters {
        let value = parameter.value.and_then(|value| model.pool.as_number(value));
        let Some(value) = value else { continue };
        if Study::new(model.clone(), &[&parameter.name]).is_ok() {
            free.0.push(parameter.name.clone());
            free.1.push(value.to_f64());
        }
    }
    free
}

/// Checks one set against its certified modes; gives the largest error in units of the largest
/// |ω²|.
fn check(name: &str, study: &Study, set: &[f64], own: &Solution<'_>) -> f64 {
    let Ok(want) = study.certified(set) else {
        assert!(!own.outcome.is_solved(), "{name} {set:?}: {:?}", own.outcome);
        return 0.0;
    };
    assert!(own.outcome.is_solved(), "{name} {set:?}: {:?}", own.outcome);
    let n = study.dimension();
    assert_eq!(want.modes.len(), n, "{name}");
    let mut exact: Vec<Ball> = want.modes.iter().map(|mode| mode.omega_squared.unwrap()).collect();
    exact.sort_by(|a, b| a.mid_f64().total_cmp(&b.mid_f64()));
    let largest = exact.iter().fold(0.0_f64, |most, x| most.max(x.mid_f64().abs()));
    let mut worst = 0.0_f64;
    for (i, (mode, exact)) in own.modes().zip(&exact).enumerate() {
        let (value, bound) = (own.omega_squared[i], own.omega_squared_bounds[i]);
        let off = (*exact - Ball::exact(value)).mid_f64().abs();
        assert!(off <= bound + exact.radius, "{name}: omega² {i} is off by {off:e}, its bound is {bound:e}");
        assert!(bound <= 1e-8 * largest, "{name}: bound {bound:e} of {largest:e}");
        worst = worst.max(off / largest);
        let omega = (*exact).max_zero_root();
        assert!((omega - mode.omega).abs() <= mode.error_bound, "{name}: omega {i}");
        let growth = (-*exact).max_zero_root();
        assert!((growth - mode.growth).abs() <= mode.error_bound, "{name}: growth {i}");
        match mode.kind {
            Kind::Oscillation => assert!(exact.is_positive(), "{name}"),
            Kind::Unstable => assert!(exact.is_negative(), "{name}"),
            Kind::Zero => panic!("{name}: a zero can't be proved here"),
            Kind::Undecided => assert!(value.abs() <= bound, "{name}"),
            other => panic!("{name}: {other:?}"),
        }
    }
    for (own, exact) in own.equilibrium.iter().zip(study_equilibrium(study, set)) {
        assert!((own - exact).abs() <= 1e-12 * (1.0 + exact.abs()), "{name}: {own} {exact}");
    }
    check_vectors(name, n, own);
    worst
}

trait Root {
    fn max_zero_root(self) -> f64;
}

impl Root for Ball {
    fn max_zero_root(self) -> f64 {
        self.mid_f64().max(0.0).sqrt()
    }
}

/// The equilibrium of one set, where it is not searched for.
fn study_equilibrium(study: &Study, set: &[f64]) -> Vec<f64> {
    let linearized = linearize(study.model_at(set).unwrap()).unwrap();
    if linearized.equilibrium().steps > 0 {
        return Vec::new();
    }
    let values = &linearized.equilibrium().values;
    values.iter().map(Ball::mid_f64).collect()
}

#[test]
fn models_agree_with_certified_results() {
    let mut files: Vec<PathBuf> = std::fs::read_dir("models")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "lag"))
        .collect();
    files.sort();
    let (mut models, mut proved, mut general, mut state) = (0, 0, [0, 0], 7);
    for path in files {
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let model = load(&path);
        if model.coordinates.len() > 30 {
            continue;
        }
        let (names, nominal) = free_parameters(&model);
        if names.is_empty() {
            continue;
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        if linearize(model.clone()).is_ok_and(|own| own.massless_directions() > 0) {
            let error = Study::new(model, &names).unwrap_err();
            assert!(error.to_string().contains("has no inertia"), "{name}: {error}");
            continue;
        }
        let study = Study::new(model, &names).unwrap();
        let sets: Vec<f64> = (0..11)
            .flat_map(|set| {
                let spread = if set == 0 { 0.0 } else { 0.4 };
                nominal.iter().map(|value| value * (1.0 + spread * (random(&mut state) - 0.5))).collect::<Vec<_>>()
            })
            .collect();
        let solutions = study.solve(&sets).unwrap();
        assert_eq!(solutions.len(), 11);
        models += 1;
        for (set, own) in sets.chunks(names.len()).zip(solutions.iter()) {
            if !study.is_conservative() {
                let certified = study.certified(set);
                assert_eq!(certified.is_ok(), own.outcome.is_solved(), "{name} {set:?}: {:?}", own.outcome);
                let Ok(want) = certified else { continue };
                let [all, apart] = check_exponents(&name, study.dimension(), &own, &want);
                general[0] += 1;
                general[1] += usize::from(all < 1e-10);
                assert!(apart < 1e-11, "{name} {set:?}: {apart:e}");
                continue;
            }
            let worst = check(&name, &study, set, &own);
            assert!(worst <= 1e-12, "{name}: off by {worst:e} of the largest");
            proved += usize::from(own.outcome == Outcome::Solved);
        }
    }
    assert!(models > 40, "{models}");
    assert!(proved > 400, "{proved}");
    assert!(general[0] > 250 && 2 * general[1] > general[0], "{general:?}");
}

const LINKS: &str = "
    param N = 5  param g = 9.81  param l[1..N] = 1  param m[1..N] = 1
    coord th[1..N]
    let x[0] = 0
    let y[0] = 0
    let x[k in 1..N] = x[k-1] + l[k]*sin(th[k])
    let y[k in 1..N] = y[k-1] - l[k]*cos(th[k])
    T = sum(k in 1..N, 1/2*m[k]*(x[k]'^2 + y[k]'^2))
    V = sum(k in 1..N, m[k]*g*y[k])
";

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

fn assert_same_bits(a: &Solution<'_>, b: &Solution<'_>) {
    assert_eq!(a.outcome, b.outcome);
    for (a, b) in [
        (a.equilibrium, b.equilibrium),
        (a.omega_squared, b.omega_squared),
        (a.omega_squared_bounds, b.omega_squared_bounds),
        (a.vectors, b.vectors),
        (a.mass, b.mass),
        (a.stiffness, b.stiffness),
        (a.velocity, b.velocity),
        (a.exponent_bounds, b.exponent_bounds),
    ] {
        assert_eq!(bits(a), bits(b));
    }
    let parts = |all: &[c64]| -> Vec<f64> { all.iter().flat_map(|own| [own.re, own.im]).collect() };
    for (a, b) in [(a.exponents, b.exponents), (a.shapes, b.shapes)] {
        assert_eq!(bits(&parts(a)), bits(&parts(b)));
    }
}

/// Every set by itself gives the same bits as among others, good and bad.
pub(crate) fn assert_independent(study: &Study, sets: &[f64]) {
    let width = study.width();
    let together = study.solve(sets).unwrap();
    let mut again = study.solve(&sets[..width]).unwrap();
    for count in [1, 5, 9] {
        for (first, stretch) in sets.chunks(count * width).enumerate() {
            study.solve_into(stretch, &mut again).unwrap();
            assert_eq!(again.len(), stretch.len() / width);
            for (k, own) in again.iter().enumerate() {
                assert_same_bits(&own, &together.get(first * count + k).unwrap());
            }
        }
    }
}

#[test]
fn sets_do_not_see_their_neighbours() {
    let study = Study::new(model(LINKS), &["m", "l", "g"]).unwrap();
    let mut state = 3;
    let mut sets: Vec<f64> = (0..21 * 11).map(|_| 0.1 + random(&mut state)).collect();
    sets[5 * 11] = f64::NAN;
    sets[7 * 11 + 3] = f64::INFINITY;
    sets[9 * 11 + 4] = -3.0;
    sets[12 * 11 + 10] = 0.0;
    sets[13 * 11 + 6] = 1e-8;
    assert_independent(&study, &sets);
    let outcomes = study.solve(&sets).unwrap().outcomes().to_vec();
    for (set, outcome) in outcomes.iter().enumerate() {
        let expected = match set {
            5 | 7 => Outcome::NotFinite,
            9 => Outcome::MassNotPositive,
            _ => Outcome::Solved,
        };
        assert_eq!(*outcome, expected, "set {set}");
    }
}

#[test]
fn searched_sets_do_not_see_their_neighbours() {
    let text = "
        param g = 9.81  param k = 40  param l = 1  param m = 1  param a = 0.3
        coord r, phi
        T = 1/2*m*(r'^2 + r^2*phi'^2)
        V = -m*g*r*cos(phi) + 1/2*k*(r - l)^2 - a*sin(phi)
        guess r = 1
    ";
    let study = Study::new(model(text), &["g", "k", "l", "m", "a"]).unwrap();
    let mut state = 4;
    let nominal = [9.81, 40.0, 1.0, 1.0, 0.3];
    let mut sets: Vec<f64> = (0..21).flat_map(|_| nominal.map(|x| x * (0.6 + 0.8 * random(&mut state)))).collect();
    sets[5] = f64::NAN;
    sets[4 * 5 + 3] = 0.0;
    assert_independent(&study, &sets);
    let solutions = study.solve(&sets).unwrap();
    for (set, own) in sets.chunks(5).zip(solutions.iter()) {
        if set.iter().all(|x| x.is_finite() && *x != 0.0) {
            assert_eq!(own.outcome, Outcome::Solved);
            assert!(check("a spring pendulum", &study, set, &own) < 1e-13);
        } else {
            assert!(!own.outcome.is_solved());
        }
    }
}

#[test]
fn zero_is_an_equilibrium_for_some_sets_only() {
    let text = "
        param m = 1  param k = 1  param b = 1/10  param f = 1/2
        coord x
        T = 1/2*m*x'^2
        V = 1/2*k*x^2 + b*x^4 - f*x
    ";
    let study = Study::new(model(text), &["k", "f"]).unwrap();
    let sets = [1.0, 0.5, 2.0, 0.0, 1.0, 0.1, -1.0, 0.0];
    let solutions = study.solve(&sets).unwrap();
    for (set, own) in sets.chunks(2).zip(solutions.iter()) {
        assert_eq!(own.outcome, Outcome::Solved);
        assert!(check("a shifted spring", &study, set, &own) < 1e-13);
    }
    // As for a single model: no force at 0, so 0 it is, though it is unstable there.
    assert_eq!(solutions.get(3).unwrap().equilibrium, [0.0]);
    assert_eq!(solutions.get(3).unwrap().mode(0).unwrap().kind, Kind::Unstable);
}

#[test]
fn an_equilibrium_may_be_lost() {
    let study = Study::new(load(Path::new("models/bead_on_hoop_fast.lag")), &["W", "R"]).unwrap();
    let solutions = study.solve(&[10.0, 0.2, 1.0, 0.2, 8.0, 0.3]).unwrap();
    let outcomes = solutions.outcomes();
    assert_eq!(outcomes[0], Outcome::Solved);
    assert!(!outcomes[1].is_solved());
    assert_eq!(outcomes[2], Outcome::Solved);
    assert!(solutions.get(1).unwrap().omega_squared[0].is_nan());
    assert!(solutions.get(1).unwrap().mode(0).is_none());

    let falling = "param f = 0  param k = 1  coord x  T = 1/2*x'^2  V = f*x + 1/2*k*x^2";
    let study = Study::new(model(falling), &["f", "k"]).unwrap();
    let solutions = study.solve(&[1.0, 0.0, 1.0, 1.0, 0.0, 0.0]).unwrap();
    let outcomes = solutions.outcomes();
    assert_eq!(outcomes, [Outcome::NoEquilibrium, Outcome::Solved, Outcome::Solved]);
}

#[test]
fn free_and_unstable_bodies() {
    let chain = "
        param m[1..3] = 1  param k[1..2] = 1
        coord x[1..3]
        T = sum(i in 1..3, 1/2*m[i]*x[i]'^2)
        V = sum(i in 1..2, 1/2*k[i]*(x[i+1] - x[i])^2)
    ";
    let study = Study::new(model(chain), &["m", "k"]).unwrap();
    let sets = [1.0, 2.0, 3.0, 4.0, 5.0, 1.0, 1.0, 1.0, -1.0, 2.0];
    let solutions = study.solve(&sets).unwrap();
    let first = solutions.get(0).unwrap();
    assert_eq!(first.mode(0).unwrap().kind, Kind::Undecided);
    assert!(first.omega_squared[0].abs() <= first.omega_squared_bounds[0]);
    assert!(first.omega_squared_bounds[0] < 1e-13);
    assert_eq!(first.mode(1).unwrap().kind, Kind::Oscillation);
    let second = solutions.get(1).unwrap();
    assert_eq!(second.mode(0).unwrap().kind, Kind::Unstable);
    assert!(second.mode(0).unwrap().growth > 0.5);
    assert_eq!(second.mode(0).unwrap().omega, 0.0);
    assert!(check("a free chain", &study, &sets[5..], &second) < 1e-14);
}

/// A soft mode beside one a million times as fast: neither the value nor its bound has lost digits.
#[test]
fn soft_modes_keep_their_digits() {
    let text = "
        param k = 1  param s = 1e12  param c = 1000
        coord x, y
        T = 1/2*x'^2 + 1/2*y'^2
        V = 1/2*s*x^2 + c*x*y + 1/2*k*y^2
    ";
    let study = Study::new(model(text), &["k", "s", "c"]).unwrap();
    let set = [1.0, 1e12, 1000.0];
    let solutions = study.solve(&set).unwrap();
    let own = solutions.get(0).unwrap();
    check("a soft mode", &study, &set, &own);
    assert!(own.omega_squared_bounds[0] < 1e-14, "{:e}", own.omega_squared_bounds[0]);
}

#[test]
fn requests_that_make_no_study() {
    let study = |names: &[&str]| Study::new(model(LINKS), names).map(|study| study.width());
    assert_eq!(study(&["g", "m[2]"]), Ok(2));
    assert_eq!(study(&["m", "l"]), Ok(10));
    assert_eq!(study(&[]), Err(StudyError::NothingVaries {}));
    let sets_range = StudyError::SetsRange { name: "N".to_owned() };
    assert_eq!(study(&["g", "N"]), Err(sets_range));
    let twice = StudyError::NamedTwice { name: "m[2]".to_owned() };
    assert_eq!(study(&["m[2]", "m"]).map_err(|error| error.to_string()), Err(twice.to_string()));
    let unknown = study(&["gg"]).unwrap_err();
    assert_eq!(unknown.to_string(), "the model has no parameter `gg`");
    let dependent = "param g = 1  param w = 2*g  coord x  T = 1/2*x'^2  V = 1/2*w*x^2";
    let error = Study::new(model(dependent), &["w"]).unwrap_err();
    let own = StudyError::Dependent { name: "w".to_owned(), on: vec!["g".to_owned()] };
    assert_eq!(error, own);
    let study = Study::new(model(dependent), &["g"]).unwrap();
    assert_eq!(study.solve(&[3.0]).unwrap().omega_squared(), [6.0]);
    let study = Study::new(model(LINKS), &["g", "m"]).unwrap();
    let error = study.solve(&[1.0; 7]).unwrap_err();
    assert_eq!(error, StudyError::Length { found: 7, width: 6 });
    assert!(study.solve(&[]).unwrap().is_empty());
    let missing = "param k  param m  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2";
    let error = Study::new(model(missing), &["k"]).unwrap_err();
    assert_eq!(error.to_string(), "the parameter `m` has no value");
    let study = Study::new(model(missing), &["k", "m"]).unwrap();
    assert_eq!(study.solve(&[8.0, 2.0]).unwrap().omega_squared(), [4.0]);
}

#[test]
fn without_bounds_nothing_is_promised() {
    let options = Options::default().without_bounds().without_vectors().without_matrices();
    let study = Study::with_options(model(LINKS), &["g"], options).unwrap();
    let solutions = study.solve(&[9.81, f64::NAN]).unwrap();
    assert!(solutions.vectors().is_empty() && solutions.mass().is_empty());
    let first = solutions.get(0).unwrap();
    assert!(first.omega_squared_bounds.iter().all(|bound| *bound == f64::INFINITY));
    assert!(first.modes().all(|mode| mode.kind == Kind::Undecided));
    let certified = normal_modes(&linearize(model(LINKS)).unwrap(), &Default::default()).unwrap();
    for (own, want) in first.omega_squared.iter().zip(&certified.modes) {
        let want = want.omega_squared.unwrap().mid_f64();
        assert!((own - want).abs() < 1e-12 * want);
    }
}

#[test]
fn studies_go_to_other_threads() {
    fn shared<T: Send + Sync>(_: &T) {}
    shared(&Study::new(model(LINKS), &["g"]).unwrap());
}

/// Coordinates apart from each other: every ω² is one entry, against its value in enclosures.
#[test]
fn entries_hold_against_enclosures() {
    let entries = [
        "sin(a)/3 - b",
        "sqrt((sin(a)/3 - b)^2 + c)",
        "sqrt((sin(a)/3 - b)^2 + c)/b",
        "c^(sqrt((sin(a)/3 - b)^2 + c)/b)",
        "atan2(c^(sqrt((sin(a)/3 - b)^2 + c)/b), sin(a)/3 - b)",
    ];
    let terms: Vec<String> = (1..).zip(&entries).map(|(i, entry)| format!("1/2*({entry})*x[{i}]^2")).collect();
    let model = model(&format!(
        "param a = 0.3  param b = 0.7  param c = 1.9  coord x[1..5]  T = sum(i in 1..5, 1/2*x[i]'^2)  V = {}",
        terms.join(" + ")
    ));
    let study = Study::new(model, &["a", "b", "c"]).unwrap();
    let sets = [0.3, 0.7, 1.9, -4.0, 0.01, 1e-3, 1e5, -3.5, 7.0];
    let solutions = study.solve(&sets).unwrap();
    for (set, own) in sets.chunks(3).zip(solutions.iter()) {
        let [a, b, c] = [0, 1, 2].map(|at: usize| Ball::exact(set[at]));
        let difference = a.sin() / Ball::exact(3.0) - b;
        let root = (difference.powi(2) + c).sqrt();
        let power = c.pow(&(root / b));
        let mut exact = [difference, root, root / b, power, power.atan2(&difference)];
        exact.sort_by(|x, y| x.mid_f64().total_cmp(&y.mid_f64()));
        assert!(own.outcome.is_solved(), "{set:?}");
        for (at, exact) in exact.into_iter().enumerate() {
            let off = (exact - Ball::exact(own.omega_squared[at])).mid_f64().abs();
            let bound = own.omega_squared_bounds[at];
            assert!(off <= bound, "{set:?}: {off:e} {bound:e}");
            assert!(bound <= 1e-9 * exact.mid_f64().abs(), "{set:?}: {bound:e} of {exact:?}");
        }
    }
}
