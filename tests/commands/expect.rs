//! `assert_derives!`: what is equal passes however it is written, what is not is shown beside what was found.
#![cfg(feature = "engine")]

use crate::common;

use common::{load, model};
use librate::assert_derives;
use librate::derive::{Derivation, Parts, derive};
use librate::expect::Expected;
use librate_studies::expect::Mismatch;

fn derived(name: &str) -> Derivation {
    let path = format!("models/{name}.lag");
    derive(&load(path.as_ref()), &Parts::all()).unwrap()
}

fn mismatches(derivation: &Derivation, expected: Expected) -> Vec<Mismatch> {
    expected.compare(derivation).unwrap_err().0
}

#[test]
fn other_forms_of_the_same_are_accepted() {
    assert_derives!(
        &derived("double_pendulum"),
        equilibrium = ["0", "0"],
        mass = "[[m[1]*l[1]^2 + m[2]*l[1]^2, m[2]*l[1]*l[2]], [m[2]*l[1]*l[2], m[2]*l[2]^2]]",
        stiffness = "[[(m[1] + m[2])*g*l[1], 0], [0, m[2]*g*l[2]]]",
        equations = [
            "(m[1] + m[2])*l[1]*th[1]'' + m[2]*l[2]*cos(th[1] - th[2])*th[2]''
                + m[2]*l[2]*th[2]'^2*sin(th[1] - th[2]) = -(m[1] + m[2])*g*sin(th[1])",
            "l[2]*th[2]'' + l[1]*cos(th[1] - th[2])*th[1]'' = l[1]*th[1]'^2*sin(th[1] - th[2]) - g*sin(th[2])",
        ],
        linearized = [
            "th[1]'' + m[2]*l[2]/((m[1] + m[2])*l[1])*th[2]'' + g/l[1]*th[1] = 0",
            "th[2]'' + l[1]/l[2]*th[1]'' + g/l[2]*th[2] = 0",
        ],
        kinetic = "m[1]*(l[1]*th[1]')^2/2 + m[2]*(l[1]*th[1]' + l[2]*th[2]')^2/2",
        potential = "(m[1] + m[2])*g*l[1]*th[1]^2/2 + m[2]*g*l[2]*th[2]^2/2",
        momenta = [
            "(m[1] + m[2])*l[1]^2*th[1]' + m[2]*l[1]*l[2]*cos(th[1] - th[2])*th[2]'",
            "m[2]*l[2]*(l[2]*th[2]' + l[1]*cos(th[1] - th[2])*th[1]')",
        ],
        energy_function = "m[1]*l[1]^2*th[1]'^2/2 + m[2]/2*((l[1]*th[1]')^2 + (l[2]*th[2]')^2
            + 2*l[1]*l[2]*th[1]'*th[2]'*(cos(th[1])*cos(th[2]) + sin(th[1])*sin(th[2])))
            - (m[1] + m[2])*g*l[1]*cos(th[1]) - m[2]*g*l[2]*cos(th[2])",
        hamiltonian = "(m[2]*(l[2]*p_th[1])^2 + (m[1] + m[2])*(l[1]*p_th[2])^2
            - 2*m[2]*l[1]*l[2]*p_th[1]*p_th[2]*cos(th[1] - th[2]))
            /(2*m[2]*(l[1]*l[2])^2*(m[1] + m[2]*(1 - cos(th[1] - th[2])^2)))
            - (m[1] + m[2])*g*l[1]*cos(th[1]) - m[2]*g*l[2]*cos(th[2])",
    );
    // With parameters tied, any of the equal ones will do, in any order, multiplied out or not.
    assert_derives!(
        &derived("three_pendulums"),
        frequencies =
            ["g/l[2] + L^2*k23*(m[2] + 2*m[3])/(m[3]*m[2]*l[1]*l[3])", "g/l[3] + L^2*k12/(m[3]*l[2]^2)", "g/l[1]",],
    );
    // Displacements from an equilibrium that is not 0, roots and inverse functions.
    assert_derives!(
        &derived("bead_on_hoop_fast"),
        equilibrium = ["acos(g/(W^2*R))"],
        linearized = ["delta_th'' = -(W^2 - (g/(W*R))^2)*delta_th"],
        frequencies = ["(W - g/(W*R))*(W + g/(W*R))"],
    );
}

#[test]
fn what_differs_is_shown_with_what_was_found() {
    let derivation = derived("double_pendulum");
    let expected = Expected::new()
        .mass("[[m[1]*l[1]^2, m[2]*l[1]*l[2]], [m[2]*l[1]*l[2], m[2]*l[2]^2]]")
        .equations([
            "l[1]*th[1]'' + g*sin(th[1]) = 0",
            "l[2]*th[2]'' + l[1]*cos(th[1] - th[2])*th[1]'' = l[1]*th[1]'^2*sin(th[1] - th[2]) - g*sin(th[2])",
        ])
        .kinetic("th[1]'^2");
    let error = expected.compare(&derivation).unwrap_err();
    insta::assert_snapshot!(error, @r"
    the derivation is not what was expected

    mass[1, 1]
      expected: m[1]*l[1]^2
      found:    l[1]^2*(m[1] + m[2])

    equation of th[1]
      expected: l[1]*th[1]'' + g*sin(th[1]) = 0
      found:    l[1]^2*(m[1] + m[2])*th[1]'' + l[1]*l[2]*m[2]*th[2]''*cos(th[2] - th[1]) - l[1]*l[2]*m[2]*th[2]'^2*sin(th[2] - th[1]) + g*l[1]*(m[1] + m[2])*sin(th[1]) = 0

    kinetic
      expected: th[1]'^2
      found:    1/2*(l[1]^2*(m[1] + m[2])*th[1]'^2 + l[2]^2*m[2]*th[2]'^2 + 2*l[1]*l[2]*m[2]*th[1]'*th[2]')
    ");
    let panic = std::panic::catch_unwind(|| {
        assert_derives!(&derivation, stiffness = "[[g*l[1]*m[1], 0], [0, g*l[2]*m[2]]]");
    });
    let message = *panic.unwrap_err().downcast::<String>().unwrap();
    insta::assert_snapshot!(message, @r"
    the derivation is not what was expected

    stiffness[1, 1]
      expected: g*l[1]*m[1]
      found:    g*l[1]*(m[1] + m[2])
    ");
}

#[test]
fn frequencies_are_compared_as_a_set() {
    let derivation = derived("ball_in_bowl");
    assert_derives!(&derivation, frequencies = ["g/R", "g/R"]);
    let once = mismatches(&derivation, Expected::new().frequencies(["g/R"]));
    let [Mismatch::Differs { expected, found, .. }] = once.as_slice() else { panic!("{once:?}") };
    assert_eq!((expected.as_str(), found.as_str()), ("no more", "g/R"));
    let wrong = mismatches(&derivation, Expected::new().frequencies(["g/R", "g/(2*R)"]));
    let [Mismatch::Differs { expected, found, .. }] = wrong.as_slice() else { panic!("{wrong:?}") };
    assert_eq!((expected.as_str(), found.as_str()), ("g/(2*R)", "g/R"));
}

/// An equation may be multiplied by anything; a sign or a term that is wrong is found all the same.
#[test]
fn equations_are_the_same_up_to_a_factor_and_no_further() {
    let text = "param k = 1  param m = 2  param l = 3  coord x, y
        T = 1/2*m*x'^2 + 1/2*m*(1 + x^2)*y'^2  V = 1/2*k*x^2 + 1/2*l*y^2";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let second = "(1 + x^2)*y'' + 2*x*x'*y' + l/m*y = 0";
    assert_derives!(&derivation, equations = ["-x'' = (k/m - y'^2)*x", second], mass = "[[m, 0], [0, m]]",);
    for wrong in [
        "x'' = (k/m - y'^2)*x",
        "x'' + k/m*x = 0",
        "y'' + (k/m - y'^2)*x = 0",
        "x'' + 0*y'' + (k/m - y'^2)*x + 1 = 0",
        "0 = 0",
    ] {
        let found = mismatches(&derivation, Expected::new().equations([wrong, second]));
        assert!(matches!(found.as_slice(), [Mismatch::Differs { .. }]), "{wrong}: {found:?}");
    }
}

#[test]
fn what_cannot_be_compared_says_why() {
    let derivation = derived("simple_pendulum");
    let kind = |expected: Expected| mismatches(&derivation, expected).remove(0).to_string();
    let unknown = kind(Expected::new().mass("[[M*l^2]]"));
    assert!(unknown.contains("`M` is not a name of the model"), "{unknown}");
    let shape = kind(Expected::new().stiffness("[[g, 0], [0, g]]"));
    assert!(shape.contains("2 by 2") && shape.contains("1 by 1"), "{shape}");
    let flat = kind(Expected::new().stiffness("g"));
    assert!(flat.contains("by rows"), "{flat}");
    let count = kind(Expected::new().momenta(["1", "2"]));
    assert!(count.contains("expected: 2"), "{count}");
    let side = kind(Expected::new().equations(["phi''"]));
    assert!(side.contains("two sides"), "{side}");
    let syntax = kind(Expected::new().equations(["2 phi'' = 0"]));
    assert!(syntax.contains("multiplication"), "{syntax}");
    let two = kind(Expected::new().potential("g  param x = 2"));
    assert!(two.contains("single"), "{two}");
    let plain = derive(&load("models/simple_pendulum.lag".as_ref()), &Parts::default()).unwrap();
    for expected in [
        Expected::new().equations(["phi'' = 0"]),
        Expected::new().momenta(["phi'"]),
        Expected::new().kinetic("1"),
        Expected::new().frequencies(["1"]),
    ] {
        let found = mismatches(&plain, expected);
        assert!(matches!(found.as_slice(), [Mismatch::NotThere { .. }]), "{found:?}");
    }
    let falling = derived("heavy_roller_on_incline");
    let found = mismatches(&falling, Expected::new().mass("[[1]]"));
    assert!(found[0].to_string().contains("no mass and stiffness"), "{found:?}");
}
