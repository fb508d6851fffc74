//! A generalised force beside the same as a dissipation function, as a potential, or as a term of the Lagrangian: every
//! command says the same of both.
#![cfg(feature = "cli")]

use crate::cli_support::*;

/// What a command prints of a model from standard input.
fn said(command: &str, model: &str) -> String {
    let (name, flags) = command.split_once(' ').unwrap_or((command, ""));
    let mut arguments = vec![name, "-"];
    arguments.extend(flags.split_whitespace());
    let run = with_input(&arguments, model);
    assert_eq!(run.status, 0, "{command}: {}\n{model}", run.err);
    run.out
}

fn both(commands: &[&str], model: &str, one: &str, other: &str) {
    for command in commands {
        let [one, other] = [one, other].map(|rest| said(command, &format!("{model}\n{rest}")));
        assert_eq!(one, other, "{command}\n{model}");
    }
}

/// All that follows from a model; how it is written differs.
const DERIVE: &str = "derive --only equations,momenta,hamiltonian,conserved,equilibria,equilibrium,mass,stiffness,gyroscopic,\
                      damping,circulatory,linearized,frequencies,characteristic,exponents,stability,numbers";

const TWO: &str = "param k = 3  param m = 2  param c = 0.3  param d = 0.1
    coord x, y
    T = 1/2*m*(x'^2 + 2*y'^2)
    V = 1/2*k*(x^2 + (y - x)^2 + x^4)";

#[test]
fn friction() {
    let commands = [
        "modes",
        "modes --json --digits 30",
        DERIVE,
        "sensitivity",
        "sweep --over c=0.1..1:4",
        "motion --start x=0.5 --until 3 --samples 5",
        "motion --start x=0.5 --until 1 --samples 3 --proved",
    ];
    let dissipation = "dissipation = 1/2*c*x'^2 + 1/2*d*(y' - x')^2";
    let force = "force x = -c*x' + d*(y' - x')  force y = -d*(y' - x')";
    both(&commands, TWO, dissipation, force);
}

#[test]
fn drag_that_does_not_matter_for_small_oscillations() {
    let commands = ["modes", "motion --start x=0.5 --until 3 --samples 5"];
    both(&commands, TWO, "dissipation = 1/3*c*abs(x')^3", "force x = -c*abs(x')*x'");
}

#[test]
fn a_moving_medium() {
    let commands = ["modes", DERIVE, "motion --start x=0.5 --until 3 --samples 5"];
    let model = "param k = 3  param c = 0.3  param W = 0.5  param u = 2
        coord x, y
        T = 1/2*(x'^2 + y'^2)
        V = 1/2*k*(x^2 + 2*y^2) + x^4";
    let dissipation = "dissipation = 1/2*c*((x' - u + W*y)^2 + (y' - W*x)^2)";
    both(&commands, model, dissipation, "force x = -c*(x' - u + W*y)  force y = -c*(y' - W*x)");
}

#[test]
fn a_drive_and_a_parametric_force() {
    let model = "param w0 = 1  param c = 0.1  param h = 0.3  param W = 1.9
        coord x
        T = 1/2*x'^2
        V = 1/2*w0^2*x^2
        period 2*pi/W";
    let commands = ["floquet", "floquet --json", "motion --start x=1 --until 5 --samples 4"];
    let dissipation = "dissipation = 1/2*c*x'^2";
    let potential = |model: &str| model.replace("1/2*w0^2*x^2", "1/2*w0^2*(1 + h*cos(W*t))*x^2");
    for command in commands {
        let energies = said(command, &format!("{}\n{dissipation}", potential(model)));
        let forces = said(command, &format!("{model}\nforce x = -c*x' - w0^2*h*cos(W*t)*x"));
        // The one is known to be symplectic but for its friction, the other is not: digits agree, bounds need not.
        let digits =
            |text: &str| text.split(|c: char| !c.is_ascii_digit() && c != '.').map(str::to_owned).collect::<Vec<_>>();
        let common = digits(&energies).iter().zip(&digits(&forces)).filter(|(a, b)| a == b && a.len() > 8).count();
        assert!(common >= 2, "{command}:\n{energies}\n{forces}");
    }
}

#[test]
fn a_magnetic_field() {
    let model = "param k = 3  param B = 0.7
        coord x, y
        V = 1/2*k*(x^2 + 2*y^2)";
    let lagrangian = "T = 1/2*(x'^2 + y'^2) + B*x*y'";
    let force = "T = 1/2*(x'^2 + y'^2)  force x = B*y'  force y = -B*x'";
    both(&["modes", "modes --json --digits 40", "sensitivity", "sweep --over B=0.1..1:3"], model, lagrangian, force);
}

#[test]
fn numbers_far_from_usual_ones() {
    let model = |force: &str| {
        format!(
            "param m = 3e-250  param k = 2e-200  param c = 1e-225  param D = 4e-230  param J = 7e-290
            coord x, phi
            T = 1/2*m*x'^2 + 1/2*J*phi'^2
            V = 1/2*k*x^2 + 1/2*D*phi^2
            {force}"
        )
    };
    let one = said("modes", &model("dissipation = 1/2*c*(x' - 1e10*x + 1e-20*phi')^2"));
    let other = said(
        "modes",
        &model("force x = -c*(x' - 1e10*x + 1e-20*phi')  force phi = -1e-20*c*(x' - 1e10*x + 1e-20*phi')"),
    );
    assert_eq!(one, other);
}

#[test]
fn work_is_done() {
    let derived = said(DERIVE, "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x - y)^2  force x = -y  force y = x");
    assert!(!derived.contains("conserved"), "{derived}");
    let pair = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x - y)^2  force x = y' - x'  force y = x' - y'";
    let derived = said(DERIVE, pair);
    assert!(derived.contains("conserved") && derived.contains("translation leaves L unchanged"), "{derived}");
    let refused = with_input(&["period", "-", "--amplitude", "1"], "coord x  T = 1/2*x'^2  V = x^2  force x = -x^3");
    assert_eq!(refused.status, 1);
    assert!(refused.err.contains("E0502") && refused.err.contains("write it into V"), "{}", refused.err);
}
