//! Derivations: every printed equation against values that were found by other means (tests/reference),
//! against brute force for all parameter values, and the laws of mechanics as identities.
#![cfg(feature = "cli")]

use crate::common;
use crate::derive_support;

use common::{load, model, model_files};
use derive_support::{BruteForce, decimal, left_sides, values};
use librate::derive::{Conserved, Motion, Parts, derive};
use librate::expect::are_equal;
use librate::expr::Tape;
use librate::linearize::LinearizeError;
use librate::model::Model;
use librate::precision::Scalar;
use librate::report::{Style, derive_json, derive_text};
use librate::syntax::Comparison;
use serde_json::Value;

/// Models of more coordinates have no references.
const MOST: usize = 12;

/// Models that need more than the language of conservative systems at rest.
const DRIVEN: &[(&str, &str)] = &[
    (
        "swing",
        "param g = 9.81  param l0 = 2  param eps = 0.1  param m = 30
         param W = 2*sqrt(g/l0)
         coord phi
         let l = l0*(1 + eps*cos(W*t))
         T = 1/2*m*(l'^2 + l^2*phi'^2)
         V = -m*g*l*cos(phi)
         period 2*pi/W",
    ),
    (
        "magnetic",
        "param m  param q  param B  param k
         coord x, y
         lagrangian = 1/2*m*(x'^2 + y'^2) + 1/2*q*B*(x*y' - y*x') - 1/2*k*(x^2 + y^2)",
    ),
    (
        "rotating frame",
        "param m  param W
         coord x, y
         lagrangian = 1/2*m*((x' - W*y)^2 + (y' + W*x)^2)",
    ),
    (
        "drag",
        "param m  param k  param c  param d
         coord x[1..2]
         T = sum(i in 1..2, 1/2*m*x[i]'^2)
         V = 1/2*k*(x[2] - x[1])^2
         dissipation = 1/2*c*(x[2]' - x[1]')^2 + 1/3*d*abs(x[1]')^3",
    ),
    (
        "relativistic",
        "param m  param c  param k
         coord x
         lagrangian = -m*c^2*sqrt(1 - x'^2/c^2) - 1/2*k*x^2",
    ),
    (
        "shaken pendulum",
        "param m  param l  param g  param a  param W
         coord phi
         let r = [l*sin(phi), a*cos(W*t) - l*cos(phi)]
         T = 1/2*m*dot(r', r')
         V = m*g*r[2]",
    ),
];

fn all_models() -> Vec<(String, Model)> {
    let files = model_files();
    let files = files.iter().map(|path| {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        (name, load(path))
    });
    let driven = DRIVEN.iter().map(|(name, text)| ((*name).to_owned(), model(text)));
    files.chain(driven).filter(|(_, model)| model.coordinates.len() <= MOST && model.constraints.is_empty()).collect()
}

#[test]
fn printed_equations_have_the_reference_values() {
    const BITS: usize = 320;
    let mut checked = 0;
    let mut wrong = Vec::new();
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let reference = format!("tests/reference/equations/{name}.json");
        let Ok(reference) = std::fs::read_to_string(&reference) else {
            continue;
        };
        let reference: Value = serde_json::from_str(&reference).unwrap();
        let model = load(&path);
        let derivation = derive(&model, &Parts::default().equations(true)).unwrap();
        let texts = left_sides(&derivation);
        for point in reference["points"].as_array().unwrap() {
            let list = |key: &str| -> Vec<String> {
                let values = point[key].as_array().unwrap().iter();
                values.map(|value| value.as_str().unwrap().to_owned()).collect()
            };
            let own = values(&model, &texts, &[list("q"), list("v"), list("a")], BITS);
            let want = list("lhs");
            assert_eq!(own.len(), want.len(), "{name}");
            // Parts of a left side may cancel: right digits are counted from the largest one.
            let largest = want.iter().map(|want| decimal(want, BITS).mid_f64().abs());
            let largest = largest.fold(0.0, f64::max);
            for (i, (own, want)) in own.iter().zip(&want).enumerate() {
                let off = own.sub(&decimal(want, BITS)).mid_f64().abs();
                if off > 1e-37 * largest {
                    let (text, got) = (&texts[i], own.mid_f64());
                    wrong.push(format!("{name}, equation {i}: {text} is {got}, not {want}"));
                }
            }
            checked += 1;
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(checked >= 3 * 40, "{checked}");
}

#[test]
fn equations_momenta_and_energies_agree_with_brute_force() {
    let mut sums = 0;
    for (name, model) in all_models() {
        let derivation = derive(&model, &Parts::all()).unwrap();
        let mut pool = derivation.pool.clone();
        let brute = BruteForce::new(&model, &mut pool);
        let energy = derivation.energy.as_ref().unwrap();
        let equations = derivation.equations.as_ref().unwrap();
        let same = |what: &str, pool: &mut librate::expr::Pool, a, b| {
            assert!(are_equal(pool, a, b), "{name}: {what}");
        };
        let mut work = pool.zero();
        let mut momenta = Vec::new();
        for (i, (equation, momentum)) in equations.iter().zip(&energy.momenta).enumerate() {
            let want = brute.equation(&mut pool, i);
            let own = brute.expression(&mut pool, equation, &[]);
            same("equation", &mut pool, own, want);
            let want = brute.momentum(&mut pool, i);
            let own = brute.expression(&mut pool, momentum, &[]);
            same("momentum", &mut pool, own, want);
            momenta.push(own);
            let velocity = brute.velocity(&mut pool, i);
            let friction = brute.equation(&mut pool, i);
            let power = pool.mul(velocity, friction);
            work = pool.add(work, power);
        }
        // dh/dt = sum of q' times (equation without friction) - dL/dt.
        let h = brute.expression(&mut pool, &energy.function, &momenta);
        let rate = brute.rate(&mut pool, h);
        let explicit = brute.explicit_rate(&mut pool);
        let mut balance = pool.sub(work, explicit);
        for i in 0..momenta.len() {
            let velocity = brute.velocity(&mut pool, i);
            let symbol = pool.as_symbol(velocity).unwrap();
            let drag = pool.diff(brute.dissipation, symbol);
            let drag = pool.sub(drag, brute.forces[i]);
            let power = pool.mul(velocity, drag);
            balance = pool.sub(balance, power);
        }
        same("rate of h", &mut pool, rate, balance);
        if let Some(hamiltonian) = &energy.hamiltonian {
            let own = brute.expression(&mut pool, hamiltonian, &momenta);
            same("Hamiltonian", &mut pool, own, h);
        }
        for quantity in &energy.conserved {
            match quantity {
                Conserved::Momentum(i) => {
                    // dp/dt is the equation of motion itself: no force is left.
                    let rate = brute.rate(&mut pool, momenta[*i]);
                    let equation = brute.equation(&mut pool, *i);
                    same("conserved momentum", &mut pool, rate, equation);
                }
                Conserved::Energy { .. } => same("conserved energy", &mut pool, rate, work),
                Conserved::Motion { momenta: sum, value, .. } => {
                    let own = brute.expression(&mut pool, sum, &momenta);
                    let in_velocities = brute.expression(&mut pool, value, &momenta);
                    same("sum of momenta", &mut pool, own, in_velocities);
                    // Its rate is the same sum of the equations of motion, weighted as the momenta are.
                    let rate = brute.rate(&mut pool, own);
                    let mut want = pool.zero();
                    for term in &sum.terms {
                        let [(Motion::Momentum(i), 1)] = term.motion.as_slice() else {
                            panic!("{:?}", term.motion);
                        };
                        let equation = brute.equation(&mut pool, *i);
                        let product = pool.mul(term.coefficient, equation);
                        want = if term.negative { pool.sub(want, product) } else { pool.add(want, product) };
                    }
                    same("conserved sum", &mut pool, rate, want);
                    sums += 1;
                }
                Conserved::Integral { .. } => panic!("no conditions on velocities here"),
            }
        }
    }
    assert!(sums > 12, "{sums}");
}

fn conserved(text: &str) -> Vec<String> {
    let derivation = derive(&model(text), &Parts::default().energy(true)).unwrap();
    let energy = derivation.energy.as_ref().unwrap();
    let sums = energy.conserved.iter().filter_map(|quantity| match quantity {
        Conserved::Motion { motion, momenta, .. } => Some(format!("{} ({motion})", derivation.text(momenta))),
        _ => None,
    });
    sums.collect()
}

#[test]
fn sums_of_momenta_are_conserved() {
    // A multiplier does not move.
    for constraint in ["z = 0", "2*x' - 2*y' + 3*z' = 0", "x' - y' = z*z'"] {
        let text = format!("coord x, y, z  T = x'^2 + y'^2 + z'^2  V = (x - y)^2  constraint {constraint}");
        assert_eq!(conserved(&text).len(), 1, "{constraint}");
    }
    assert_eq!(
        conserved(
            "param m[1..3]  param k  coord x[1..3]
             T = sum(i in 1..3, 1/2*m[i]*x[i]'^2)
             V = 1/2*k*((x[2] - x[1])^2 + (x[3] - x[2])^2)"
        ),
        ["p_x[1] + p_x[2] + p_x[3] (translation of x)"]
    );
    assert_eq!(
        conserved("param m  param k  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = k*(x^2 + y^2)^2"),
        ["x*p_y - y*p_x (rotation)"]
    );
    // T has to stay the same too: two masses that differ do not turn into each other, and one that depends on the
    // place does not drift.
    let lame = "param k  coord x, y  T = x'^2 + 2*y'^2  V = k*(x^2 + y^2)";
    assert!(conserved(lame).is_empty());
    let heavy = "param k  coord x, y  T = (1 + x^2)*x'^2 + y'^2  V = k*(x - y)^2";
    assert!(conserved(heavy).is_empty());
    // Friction between the two keeps their momentum, friction on the floor does not.
    let pair = "param k  param c  coord x, y  T = x'^2 + y'^2  V = k*(x - y)^2";
    let between = conserved(&format!("{pair}  dissipation = c*(x' - y')^2"));
    assert_eq!(between, ["p_x + p_y (translation)"]);
    assert!(conserved(&format!("{pair}  dissipation = c*(x'^2 + y'^2)")).is_empty());
    // In a magnetic field: the angular momentum, with its part from the field.
    let spin = "param m  param b  param k  coord x, y
        lagrangian = 1/2*m*(x'^2 + y'^2) + 1/2*b*(x*y' - y*x') - 1/2*k*(x^2 + y^2)";
    assert_eq!(conserved(spin), ["x*p_y - y*p_x (rotation)"]);
}

#[test]
fn conditions_read_as_a_physicist_writes_them() {
    let conditions = |text: &str| {
        let derivation = derive(&model(text), &Parts::default().equilibria(true)).unwrap();
        let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
        let roots = json["force_vanishes"].as_array().unwrap().iter();
        let texts = roots.filter_map(|root| {
            let signs = root["if_signs"].as_array().unwrap().iter();
            let signs: Vec<&str> = signs.map(|sign| sign.as_str().unwrap()).collect();
            Some(format!("{} with {}", root["if"].as_str()?, signs.join(", ")))
        });
        texts.collect::<Vec<_>>()
    };
    let hoop = "coord th  T = 1/2*m*R^2*(th'^2 + W^2*sin(th)^2)  V = -m*g*R*cos(th)";
    let with_values = format!("param g = 9.81  param R = 1  param W = 2  param m = 1 {hoop}");
    assert_eq!(conditions(&with_values), ["W^2 > g/R with g > 0, R > 0"]);
    let without = format!("param g  param R  param W  param m {hoop}");
    assert_eq!(conditions(&without), ["W^2 > abs(g)/abs(R) with "]);
    // A torque on a pendulum: at the largest one there still is a point of rest.
    let torque = "param g = 10  param l = 1  param m = 1  param D = -3  coord a
        T = 1/2*m*l^2*a'^2  V = -m*g*l*cos(a) - D*a";
    assert_eq!(conditions(torque), ["-D <= g*l*m with g > 0, l > 0, m > 0, D < 0"]);
    let sum = "param g = 10  param l = 1  param m[1..2] = 1  param k = 3  coord a
        T = a'^2  V = -(m[1] + m[2])*g*l*cos(a) - k^3*a";
    assert_eq!(conditions(sum), ["k^3 <= g*l*(m[1] + m[2]) with g > 0, l > 0, m[1] > 0, m[2] > 0, k > 0"]);
}

/// The condition is the inequality |value| <= 1 itself, at any values of the parameters.
#[test]
fn conditions_say_that_the_value_is_one_of_a_sine() {
    let mut checked = 0;
    for (name, model) in all_models() {
        let derivation = derive(&model, &Parts::default().equilibria(true)).unwrap();
        for root in derivation.equilibria.iter().flatten() {
            let Some(condition) = &root.condition else {
                continue;
            };
            let pool = &derivation.pool;
            let roots = [root.value, condition.left, condition.right];
            let symbols = pool.symbols_of(&roots);
            let tape = Tape::compile(pool, &roots, &symbols).unwrap();
            for seed in 0..40 {
                let negative = |at: usize| {
                    let symbol = symbols[at];
                    let taken = condition.signs.iter();
                    taken.clone().any(|(e, minus)| *minus && pool.as_symbol(*e) == Some(symbol))
                };
                let point: Vec<f64> = (0..symbols.len())
                    .map(|at| {
                        let size = 0.2 + ((at + 1) * (seed + 3) * 7919 % 1000) as f64 / 300.0;
                        if negative(at) { -size } else { size }
                    })
                    .collect();
                let values = tape.evaluate::<f64>(&point, &mut Vec::new());
                let [value, left, right] = values.as_slice() else { panic!() };
                let holds = match condition.relation {
                    Comparison::Less => left < right,
                    Comparison::LessEqual => left <= right,
                    Comparison::Greater => left > right,
                    Comparison::GreaterEqual => left >= right,
                    other => panic!("{other:?}"),
                };
                assert_eq!(holds, value.abs() < 1.0, "{name}: {values:?}");
                checked += 1;
            }
        }
    }
    assert!(checked >= 3 * 40, "{checked}");
}

#[test]
fn linearized_equations_are_the_matrices() {
    for (name, model) in all_models() {
        let derivation = derive(&model, &Parts::all()).unwrap();
        let Ok(linear) = &derivation.linear else {
            continue;
        };
        let matrices = librate_core::linearize::derive(model.assumed().into_owned()).unwrap();
        // What was found from a guess stands for what is solved on the page.
        if linear.equilibrium != matrices.equilibrium {
            continue;
        }
        let mut pool = derivation.pool.clone();
        let pairs = [(&linear.mass, &matrices.mass), (&linear.stiffness, &matrices.stiffness)];
        for (own, other) in pairs {
            for (own, other) in own.iter().flatten().zip(other.iter().flatten()) {
                // Both pools grew from the model's in the same way up to the matrices.
                assert!(are_equal(&mut pool, *own, *other), "{name}");
            }
        }
        let count = linear.mass.len();
        assert_eq!(derivation.linearized_texts().len(), count);
    }
}

fn page(text: &str) -> String {
    derive_text(&derive(&model(text), &Parts::all()).unwrap(), &Style::default())
}

#[test]
fn models_beyond_modes_have_equations() {
    let texts = DRIVEN.iter().map(|(name, text)| format!("## {name}\n{}", page(text)));
    insta::assert_snapshot!(texts.collect::<Vec<_>>().join("\n"));
}

#[test]
fn what_has_no_matrices_says_why() {
    let swing = derive(&model(DRIVEN[0].1), &Parts::all()).unwrap();
    assert!(matches!(swing.linear, Err(LinearizeError::TimeDependent { .. })));
    let json: Value = serde_json::from_str(&derive_json(&swing)).unwrap();
    assert!(json.get("mass").is_none());
    let reason = json["not_linearized"].as_str().unwrap();
    assert!(reason.contains("time"), "{reason}");
    assert_eq!(json["equations"].as_array().unwrap().len(), 1);
    assert_eq!(json["conserved"].as_array().unwrap().len(), 0);
    // Where the force has a value, its derivative need not have one.
    let corner = model("coord x  T = x'^2*(1 + x^2)  V = 2*x^2 + x*abs(x)");
    let reason = derive(&corner, &Parts::all()).unwrap().linear.unwrap_err().to_string();
    assert!(reason.starts_with("a second derivative of the energies is not defined"), "{reason}");
    // A point that is no equilibrium is a mistake of the model.
    let wrong = model("param k = 1  coord x  T = 1/2*x'^2  V = 1/2*k*x^2  equilibrium x = 1");
    let error = derive(&wrong, &Parts::all()).unwrap_err();
    assert!(matches!(error, LinearizeError::NotAnEquilibrium { .. }));
}

/// Models that `modes` refuses have a page, or an error: nothing moves along some direction, an equilibrium is none.
#[test]
fn every_model_with_a_mistake_has_a_page_or_an_error() {
    let mut pages = 0;
    for entry in std::fs::read_dir("tests/errors").unwrap() {
        let path = entry.unwrap().path();
        let Some(file) = std::fs::read_to_string(&path).ok().and_then(|text| librate::syntax::parse(&text).ok()) else {
            continue;
        };
        let model =
            librate::model::elaborate(&file, &librate::model::TableTexts::new(), &librate::model::Settings::new());
        pages += usize::from(model.is_ok_and(|model| derive(&model, &Parts::all()).is_ok()));
    }
    assert!(pages > 10, "{pages}");
}

#[test]
fn coordinates_that_lose_a_motion_are_told() {
    let spherical = "T = 1/2*m*l^2*(th'^2 + phi'^2*sin(th)^2)  V = -m*l*cos(th)";
    let euler = "T = 1/2*m*(th'^2 + psi'^2*sin(th)^2) + 1/2*l*(phi' + psi'*cos(th))^2  V = th^2";
    let cases = [
        ("param m  param l  coord th, phi", spherical, "`phi`"),
        ("param m = 2  param l = 3  coord th, phi", spherical, "`phi`"),
        ("param m  param l  coord psi, th, phi", euler, "of `psi`, `phi` together"),
    ];
    for (names, energies, motion) in cases {
        let derivation = derive(&model(&format!("{names}  {energies}")), &Parts::all()).unwrap();
        let error = derivation.linear.unwrap_err();
        assert!(matches!(error, LinearizeError::SingularCoordinates { .. }));
        assert!(error.to_string().contains(motion), "{error}");
        assert!(derivation.energy.is_some() && derivation.equations.is_some());
    }
    // Where the angle is away from the axis, and where a coordinate has no inertia anywhere, M and K stand.
    for text in [
        "param m  coord th, phi  T = 1/2*m*(th'^2 + phi'^2*sin(th)^2)  V = cos(th)^2  equilibrium th = pi/2",
        "param m  coord x, y  T = 1/2*m*x'^2  V = x^2 + (x - y)^2",
    ] {
        assert!(derive(&model(text), &Parts::all()).unwrap().linear.is_ok());
    }
}

#[test]
fn parameters_that_decide_whether_a_force_acts() {
    // The sign of a root, and what vanishes for some values only.
    let spring = "param k  param l  param h  coord x  T = 1/2*x'^2  V = 1/2*k*(sqrt(x^2 + h^2) - l)^2";
    let cases = [
        (format!("{spring}  equilibrium x = sqrt(l^2 - h^2)"), "abs(l)"),
        ("param a  param b  coord x  T = x'^2  V = x^2 - 2*a*x  equilibrium x = b".to_owned(), "a - 2*b"),
    ];
    for (text, force) in cases {
        let error = derive(&model(&text), &Parts::all()).unwrap().linear.unwrap_err();
        assert!(matches!(error, LinearizeError::ForceOfParameters { .. }), "{error}");
        assert!(error.to_string().contains(force), "{error}");
    }
    // With values the sign is known.
    let valued =
        spring.replace("param k", "param k = 2").replace("param l", "param l = 5").replace("param h", "param h = 3");
    let derivation = derive(&model(&format!("{valued}  equilibrium x = sqrt(l^2 - h^2)")), &Parts::all());
    assert!(derivation.unwrap().linear.is_ok());
}

#[test]
fn steady_motions_are_told_with_their_rates() {
    let text = "param m  param k  param l  param W  coord r, phi  T = 1/2*m*(r'^2 + r^2*phi'^2)  V = 1/2*k*(r - l)^2
        equilibrium r = k*l/(k - m*W^2)  equilibrium phi' = W";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let page = librate::report::derive_text(&derivation, &librate::report::Style::default());
    assert!(page.contains("steady motion: φ̇ = W"), "{page}");
    assert!(page.contains("T₂ and V - T₀ to second order"), "{page}");
    let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
    assert_eq!(json["rates"], serde_json::json!({"phi": "W"}));
}

#[test]
fn parts_are_worked_out_where_they_are_asked_for() {
    let pendulum = model("param l  coord phi  T = 1/2*l^2*phi'^2  V = -l*cos(phi)");
    let derivation = derive(&pendulum, &Parts::default()).unwrap();
    assert!(derivation.equations.is_none() && derivation.energy.is_none());
    assert!(derivation.equation_texts().is_empty());
    assert!(derivation.linear.unwrap().second_order.is_none());
    let some = derive(&pendulum, &Parts::default().energy(true)).unwrap();
    assert!(some.equations.is_none() && some.energy.is_some());
}

#[test]
fn equations_read_as_a_person_writes_them() {
    let printed = |text: &str| {
        let derivation = derive(&model(text), &Parts::default().equations(true)).unwrap();
        derivation.equation_texts().join("\n")
    };
    // A free particle, a coordinate that occurs nowhere, one without inertia.
    assert_eq!(printed("coord x  T = 1/2*x'^2"), "x'' = 0");
    assert_eq!(printed("coord x, y  T = 1/2*x'^2"), "x'' = 0\n0 = 0");
    assert_eq!(printed("param k  coord x  T = 0*x'  V = 1/2*k*x^2"), "k*x = 0");
    // Parameters that are numbers stay symbols, those made of others are written out, integers that set
    // ranges are numbers.
    assert_eq!(
        printed("param N = 2  param k = 3  param c = 2*k  coord x[1..N]  T = sum(i in 1..N, x[i]'^2)  V = c*N*x[1]^2"),
        "2*x[1]'' + 8*k*x[1] = 0\n2*x[2]'' = 0"
    );
    assert_eq!(
        printed("param m  param k  coord r, phi  T = 1/2*m*(r'^2 + r^2*phi'^2)  V = -k/r"),
        "m*r'' - m*r*phi'^2 + k/r^2 = 0\nm*r^2*phi'' + 2*m*r*r'*phi' = 0"
    );
    // Squares behind a minus sign.
    assert_eq!(
        printed("coord x, y, z  T = 1/2*x'^2 + (1 + x)*(y'^2 + z'^2)  V = 1/2*x^2").lines().next(),
        Some("x'' - (y'^2 + z'^2) + x = 0")
    );
}

/// Twice the potential energy to second order has its brackets behind a minus sign, too, and is halved.
#[test]
fn energies_to_second_order_keep_their_signs() {
    let printed = |potential: &str| {
        let text = format!("coord x, y  T = 1/2*(x'^2 + y'^2)  V = {potential}");
        let own = derive(&model(&text), &Parts::all()).unwrap();
        own.displaced_text(&own.linear.as_ref().unwrap().second_order.as_ref().unwrap().potential)
    };
    assert_eq!(printed("cos(x) + cos(y)"), "-1/2*(x^2 + y^2)");
    assert_eq!(printed("-1/2*(x + y)^2"), "1/2*(-(x^2 + y^2) - 2*x*y)");
    assert_eq!(printed("x^2 + y^2"), "x^2 + y^2");
    assert_eq!(printed("-3*x^2 - 3*y^2"), "-1/2*6*(x^2 + y^2)");
}

#[test]
fn forces_that_can_be_solved_are() {
    let solved = |text: &str| {
        let derivation = derive(&model(text), &Parts::default().equilibria(true)).unwrap();
        let pool = &derivation.pool;
        let roots = derivation.equilibria.as_ref().unwrap().iter();
        let texts = roots.map(|root| {
            let (left, value) = (pool.display(root.left), pool.display(root.value));
            format!("{left} = {value}")
        });
        texts.collect::<Vec<_>>()
    };
    assert_eq!(
        solved(
            "param g  param R  param W  param m  coord th
             T = 1/2*m*R^2*(th'^2 + W^2*sin(th)^2)  V = -m*g*R*cos(th)"
        ),
        ["sin(th) = 0", "cos(th) = g/(R*W^2)"]
    );
    assert_eq!(
        solved(
            "param g  param m  param k  param l  coord x
             T = 1/2*m*x'^2  V = 1/2*k*(x - l)^2 - m*g*x"
        ),
        ["x = l + g*m/k"]
    );
    // Two coordinates in one force, a root of higher degree: not by hand.
    assert!(solved("param k  coord x, y  T = x'^2 + y'^2  V = k*(x - y)^2").is_empty());
    assert!(solved("param k  coord x  T = x'^2  V = x^2 + exp(x)").is_empty());
}

#[test]
fn coefficients_have_their_shortest_form() {
    for (force, want) in [
        ("m*sin(a)*sin(b) + m*cos(a)*cos(b)", "m*cos(b - a)"),
        ("sqrt(m*l^2*sin(a)^2 + m*l^2*cos(a)^2)", "sqrt(m)*abs(l)"),
        ("l^2*k + l^2*h + g*k", "k*g + l^2*(k + h)"),
        ("m*(l + k)^2", "m*(l + k)^2"),
    ] {
        let text = format!(
            "param a  param b  param m  param l  param k  param h  param g  coord x  T = 1/2*x'^2  V = ({force})*x"
        );
        let derivation = derive(&model(&text), &Parts::default().equations(true)).unwrap();
        assert_eq!(derivation.equation_texts(), [format!("x'' + {want} = 0")]);
    }
}

/// Bodies whose coordinates are named by axis and number turn together, and their zero mode is this rotation.
#[test]
fn numbered_coordinates_turn_together() {
    let text = "param m  coord x1, y1, x2, y2  T = 1/2*m*(x1'^2 + y1'^2 + x2'^2 + y2'^2)
        V = (sqrt((x1 - x2)^2 + (y1 - y2)^2) - 1)^2  guess x2 = 1";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
    let names: Vec<&str> =
        json["conserved"].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap()).collect();
    assert_eq!(names[2], "x1*p_y1 - y1*p_x1 + x2*p_y2 - y2*p_x2");
    let linearized = librate::linearize::linearize(model(&text.replace("param m", "param m = 1"))).unwrap();
    let all: Vec<String> = linearized.zero_modes().iter().map(|own| format!("{own:?}")).collect();
    assert!(all.len() == 3 && all.iter().any(|own| own.contains("otation")), "{all:?}");
}
