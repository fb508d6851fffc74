//! Formulas as LaTeX and as text of several lines.
#![cfg(feature = "format")]

use librate::typeset::{Formula, Notation};
use librate_core::typeset::{Subscript, Symbol};

fn latex(text: &str) -> String {
    Notation::new(["phi[1]", "x"]).read(text).map_or_else(|| format!("unread: {text}"), |formula| formula.latex())
}

#[test]
fn signs_in_filters_are_none_of_a_relation() {
    let read = |text: &str| Notation::new(["x"]).read_relation(text).map(|own| own.latex());
    let sum = r"V = \sum_{i = 1}^{3} \sum_{j = 1,\, i < j}^{3} x_{j}";
    assert_eq!(read("V = sum(i in 1..3, j in 1..3 where i < j, x[j])").as_deref(), Some(sum));
    assert_eq!(read("a = b, if c <= d").as_deref(), Some(r"a = b \quad \text{if } c \leq d"));
}

#[test]
fn what_a_physicist_writes() {
    for (text, expected) in [
        ("1/2*m*l^2*phi[1]'^2", r"\frac{1}{2} m l^{2} \dot{\varphi}_{1}^{2}"),
        ("m[1]*g*l[1]*(1 - cos(phi[1]))", r"m_{1} g l_{1} (1 - \cos \varphi_{1})"),
        ("g/l[1] + k12*L^2/(m[1]*l[1]^2)", r"\frac{g}{l_{1}} + \frac{k_{12} L^{2}}{m_{1} l_{1}^{2}}"),
        ("3/2*k/m", r"\frac{3 k}{2 m}"),
        ("1/2*k/m", r"\frac{k}{2 m}"),
        ("1/m", r"\frac{1}{m}"),
        ("sqrt(2)/2", r"\frac{\sqrt{2}}{2}"),
        ("x''", r"\ddot{x}"),
        ("delta_x' + p_x - p_phi[2]", r"\delta \dot{x} + p_{x} - p_{\varphi_{2}}"),
        ("sin(phi[1])^2*m", r"\sin^{2} \varphi_{1} \, m"),
        ("cos(phi[1] - phi[2])", r"\cos(\varphi_{1} - \varphi_{2})"),
        ("-(a - b)*c", r"-(a - b) c"),
        ("a - (b - c)", "a - (b - c)"),
        ("a - -b*c/-d", r"a - \frac{b c}{d}"),
        ("-a^2 + b", "-a^{2} + b"),
        ("2*3*x", r"2 \cdot 3 x"),
        ("6.02e23*x", r"6.02 \cdot 10^{23} x"),
        ("(1 + x/a)^2", r"\left( 1 + \frac{x}{a} \right)^{2}"),
        ("x^(1/2)", r"\sqrt{x}"),
        ("exp(-x/a)", r"\mathrm{e}^{-\frac{x}{a}}"),
        ("atan2(y, x)", r"\operatorname{atan2}(y, x)"),
        ("abs(x)", r"\left\vert x \right\vert"),
        ("about(I, angular_velocity(R))", r"\mathrm{about} \, (I,\; \mathrm{angular\_velocity} \, (R))"),
        ("\u{b5}*x", r"\mu x"),
        ("norm(r[1] - r[2])^2", r"\left\Vert r_{1} - r_{2} \right\Vert^{2}"),
        ("dot(u, v)*cross(u, v)[1]", r"(u \cdot v) (u \times v)_{1}"),
        ("[x, 0]", r"\begin{pmatrix} x \\ 0 \end{pmatrix}"),
        ("(x*y)'", r"\frac{\mathrm{d}}{\mathrm{d}t} (x y)"),
        ("sum(i in 1..N, x[i]^2)", r"\sum_{i = 1}^{N} x_{i}^{2}"),
        (
            "sum(i in 1..N, j in 1..N where i < j, x[i] + x[j])",
            r"\sum_{i = 1}^{N} \sum_{j = 1,\, i < j}^{N} (x_{i} + x_{j})",
        ),
        ("integral(x in 0..L/2, rho*x^2)", r"\int_{0}^{\frac{L}{2}} \rho x^{2} \,\mathrm{d}x"),
        ("2*integral(s in a..b, a + s)*m", r"2 \left( \int_{a}^{b} (a + s) \,\mathrm{d}s \right) m"),
        ("sum(b in bonds, b.k*(x[b.i] - 1)^2)", r"\sum_{b \in \mathrm{bonds}} b_{k} (x_{b_{i}} - 1)^{2}"),
    ] {
        assert_eq!(latex(text), expected, "{text}");
    }
}

#[test]
fn long_sums_are_broken_before_a_sign() {
    let terms: Vec<String> = (1..30).map(|i| format!("k*x[{i}]^2")).collect();
    let left = Formula::Symbol(Symbol::of("V"));
    let sum = Notation::default().read(&terms.join(" + ")).unwrap_or(Formula::Number(String::new()));
    let text = Formula::equation(left, sum).latex_display();
    assert!(text.starts_with("\\begin{aligned}\nV & = k x_{1}^{2} + "), "{text}");
    assert!(text.lines().count() > 3 && text.lines().all(|line| line.len() < 400));
}

fn text(source: &str) -> String {
    let formula = Notation::new(["phi[1]", "x"]).read(source);
    formula.map_or_else(|| format!("unread: {source}"), |formula| formula.text(60).join("\n"))
}

#[test]
fn what_a_terminal_shows() {
    for (source, expected) in [
        ("1/2*m*l^2*phi[1]'^2", "½ m l² φ\u{307}₁²"),
        ("x''", "x\u{308}"),
        ("g/l[1] + k12", "g\n── + k₁₂\nl₁"),
        ("(1 + x/a)^2", "⎛    x⎞²\n⎜1 + ─⎟\n⎝    a⎠"),
        ("sqrt(2)/2*x^-1", "√2 x⁻¹\n──────\n  2"),
        ("sin(x)^2*cos(2*x)", "sin² x cos(2 x)"),
        ("2*3*x", "2 · 3 x"),
        ("u[1,2] + u[10,2]", "u₁₂ + u[10, 2]"),
        ("m_eff + theta_0", "m_eff + θ₀"),
        ("delta_x' + p_phi[2] - p_x", "δx\u{307} + p_φ₂ - p_x"),
        ("m_a + m_b + omega0_x + k_12", "m_a + m_b + ω₀_x + k₁₂"),
        ("th' + th_1 + th1' + th[1] + xyz'", "θ\u{307} + θ₁ + θ\u{307}₁ + θ₁ + xyz′"),
        ("roll''*roll1'^2", "roll″ roll₁′²"),
        ("(1 + x)^(3/2)", "       3/2\n(1 + x)"),
        ("cos(1/10*pi)", "cos(⅒ π)"),
        ("exp(-x)", " -x\ne"),
        ("sum(i in 1..N, x[i]^2)", "  N\n  Σ   xᵢ²\ni = 1"),
        ("[x, 0]", "⎡x⎤\n⎣0⎦"),
        ("6.02e23", "6.02·10²³"),
        ("norm(x)", "‖x‖"),
        ("2/3*x/a", "2 x\n───\n3 a"),
    ] {
        assert_eq!(text(source), expected, "{source}");
    }
}

/// What the model itself declares is neither a displacement nor a momentum.
#[test]
fn names_of_the_model_are_their_own() {
    let notation = Notation::new(["x"]).names(["x", "delta_x", "p_x"]);
    let latex = |text: &str| notation.read(text).unwrap().latex();
    assert_eq!(latex("delta_x*x + p_x"), r"\delta_{x} x + p_{x}");
    assert_ne!(notation.read("p_x"), Notation::new(["x"]).read("p_x"));
}

#[test]
fn long_sums_are_broken() {
    let terms: Vec<String> = (1..20).map(|i| format!("k*x[{i}]^2")).collect();
    let lines = text(&terms.join(" + "));
    assert!(lines.lines().count() > 2);
    assert!(lines.lines().all(|line| line.chars().count() <= 60));
    assert!(lines.lines().skip(1).all(|line| line.starts_with("     + ")));
}

/// A model's names are never printed alike; short names of Greek letters are none beside others of their kind.
#[test]
fn names_are_kept_apart() {
    for (names, expected) in [
        (vec!["th", "ph_1", "Om"], "θ, φ₁, Ω"),
        (vec!["th", "theta"], "th, θ"),
        (vec!["th_1", "theta[1]", "theta[2]"], "th₁, θ₁, θ₂"),
        (vec!["la", "lb", "la_1"], "la, lb, la₁"),
        (vec!["al", "ar", "be"], "al, ar, β"),
        (vec!["x1", "x_1", "x"], "x1, x_1, x"),
        (vec!["φ", "phi", "ph"], "φ, phi, ph"),
        (vec!["th1", "th_1"], "th1, th_1"),
        (vec!["k[1]", "k[1]'", "k1"], "k₁, k\u{307}₁, k1"),
    ] {
        let notation = Notation::default().names(names.iter().copied());
        let texts = names.iter().filter_map(|name| notation.read(name)).map(|formula| formula.text(60).join("\n"));
        assert_eq!(texts.collect::<Vec<_>>().join(", "), expected, "{names:?}");
    }
    let notation = Notation::default().names(["th", "theta", "phi", "φ"]);
    let latex = |name: &str| notation.read(name).map(|formula| formula.latex()).unwrap_or_default();
    assert_eq!([latex("th"), latex("theta'")], [r"\mathrm{th}", r"\dot{\theta}"]);
    assert_eq!([latex("phi"), latex("φ")], [r"\mathrm{phi}", r"\varphi"]);
    let notation = Notation::default().names(["phi_1", "φ_1"]);
    assert_eq!(notation.read("φ_1").unwrap().latex(), r"\text{φ\_1}");
    // What stands for displacements and momenta beside names that these have elsewhere.
    let notation = Notation::new(["th", "theta"]).names(["th", "theta", "p_x", "delta_x"]);
    let texts = ["P_th", "P_theta", "xi_th'", "xi_theta"].map(|name| notation.read(name).unwrap().text(60).join(""));
    assert_eq!(texts, ["P_th", "P_θ", "ξ\u{307}_th", "ξ_θ"]);
}

#[test]
fn names_fall_into_letters_and_subscripts() {
    let parts = |name: &str| {
        let symbol = Symbol::of(name);
        let feet: Vec<String> = symbol
            .subscript
            .iter()
            .filter_map(|part| match part {
                Subscript::Word(word) => Some(word.clone()),
                _ => None,
            })
            .collect();
        (symbol.letter, feet.join(","))
    };
    let expected = |letter: &str, feet: &str| (letter.to_owned(), feet.to_owned());
    assert_eq!(parts("k12"), expected("k", "12"));
    assert_eq!(parts("theta_0"), expected("theta", "0"));
    assert_eq!(parts("m_eff"), expected("m", "eff"));
    assert_eq!(parts("omega0_x"), expected("omega", "0,x"));
    assert_eq!(parts("mass"), expected("mass", ""));
    assert_eq!(parts("x"), expected("x", ""));
    assert_eq!(Formula::Symbol(Symbol::of("mass")).latex(), r"\mathrm{mass}");
    assert_eq!(Formula::Symbol(Symbol::of("phi")).latex(), r"\varphi");
    assert_eq!(Formula::Symbol(Symbol::of("φ")).latex(), r"\varphi");
    assert_eq!(Formula::Symbol(Symbol::of("é")).latex(), r"\text{é}");
    assert_eq!(Formula::Symbol(Symbol::of("k12")).latex(), "k_{12}");
}
