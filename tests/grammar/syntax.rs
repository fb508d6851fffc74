//! What the grammar promises: precedences, spans, statement ends, limits.

use librate::span::Span;
use librate_core::syntax::*;

/// The expression with every operator in parentheses.
fn full(file: &File, at: ExprRef) -> String {
    let all = |list: &[ExprRef], sign: &str| {
        let members: Vec<String> = list.iter().map(|e| full(file, *e)).collect();
        members.join(sign)
    };
    match file.expr(at).kind {
        ExprKind::Number(text) | ExprKind::Name(text) => text.to_owned(),
        ExprKind::Index { base, indices } => {
            format!("({}[{}])", full(file, base), all(indices, ", "))
        }
        ExprKind::Field { base, field } => format!("({}.{})", full(file, base), field.text),
        ExprKind::Prime(inner) => format!("({}')", full(file, inner)),
        ExprKind::Negate(inner) => format!("(-{})", full(file, inner)),
        ExprKind::Power { base, exponent } => {
            format!("({}^{})", full(file, base), full(file, exponent))
        }
        ExprKind::Product(factors) => {
            let mut out = String::new();
            for (position, factor) in factors.iter().enumerate() {
                let sign = if factor.inverted() { "/" } else { "*" };
                out += if position == 0 { "" } else { sign };
                out += &full(file, factor.value());
            }
            format!("({out})")
        }
        ExprKind::Sum(terms) => {
            let mut out = String::new();
            for (position, term) in terms.iter().enumerate() {
                let sign = if term.inverted() { " - " } else { " + " };
                out += if position == 0 { "" } else { sign };
                out += &full(file, term.value());
            }
            format!("({out})")
        }
        ExprKind::Call { function, arguments } => format!("{}({})", function.text, all(arguments, ", ")),
        ExprKind::SumOver { indices, body } => match indices.filter {
            Some(filter) => format!("sum(where {}: {})", full(file, filter), full(file, body)),
            None => format!("sum({}: {})", indices.entries.len(), full(file, body)),
        },
        ExprKind::IntegralOver { body, .. } => format!("integral({})", full(file, body)),
        ExprKind::Vector(list) => format!("[{}]", all(list, ", ")),
        ExprKind::Compare { operator, left, right } => {
            format!("({} {operator:?} {})", full(file, left), full(file, right))
        }
        ExprKind::Not(inner) => format!("(not {})", full(file, inner)),
        ExprKind::And(list) => format!("({})", all(list, " and ")),
        ExprKind::Or(list) => format!("({})", all(list, " or ")),
    }
}

fn expr(text: &str) -> String {
    let file = parse(&format!("V = {text}")).unwrap_or_else(|e| panic!("{text}: {e:#?}"));
    match &file.statements[0].kind {
        StatementKind::Potential(at) => full(&file, *at),
        other => panic!("{other:?}"),
    }
}

fn condition(text: &str) -> String {
    let whole = expr(&format!("sum(i in 1..3 where {text}, 1)"));
    whole.trim_start_matches("sum(where ").trim_end_matches(": 1)").to_owned()
}

fn messages(source: &str) -> Vec<String> {
    match parse(source) {
        Ok(_) => Vec::new(),
        Err(errors) => errors.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn precedences() {
    for (text, tree) in [
        ("-x^2", "(-(x^2))"),
        ("2^-1", "(2^(-1))"),
        ("2^-x^2", "(2^(-(x^2)))"),
        ("2^-x*y", "((2^(-x))*y)"),
        ("a^b^c", "(a^(b^c))"),
        ("(a^b)^c", "((a^b)^c)"),
        ("-a*b", "((-a)*b)"),
        ("a*-b", "(a*(-b))"),
        ("a/b*c", "(a/b*c)"),
        ("a/(b*c)", "(a/(b*c))"),
        ("a*b + c/d - e", "((a*b) + (c/d) - e)"),
        ("(a + b) + c", "((a + b) + c)"),
        ("a + (b + c)", "(a + (b + c))"),
        ("a - b - c", "(a - b - c)"),
        ("-a + b", "((-a) + b)"),
        ("a - -b", "(a - (-b))"),
        ("--a", "(-(-a))"),
        ("x'^2", "((x')^2)"),
        ("-x'", "(-(x'))"),
        ("x[1]'^2", "(((x[1])')^2)"),
        ("x''", "((x')')"),
        ("f(x)'[1]", "((f(x)')[1])"),
        ("[a, b]'", "([a, b]')"),
        ("(x)'", "(x')"),
        ("(2)'", "(2')"),
        ("bonds[3].col", "((bonds[3]).col)"),
        ("b.T^2", "((b.T)^2)"),
        ("R[i][j]", "((R[i])[j])"),
        ("R[i,j]", "(R[i, j])"),
        ("sin (x)", "sin(x)"),
        ("1/2*m*v^2", "(1/2*m*(v^2))"),
        ("sum(i in 1..n, x[i])^2", "(sum(1: (x[i]))^2)"),
        ("sum(i in 1..N, j in i+1..N, 1)", "sum(2: 1)"),
        ("sum(b in bonds, b.k)", "sum(1: (b.k))"),
        ("6.02e23", "6.02e23"),
        ("1e-3", "1e-3"),
        ("Tau", "Tau"),
        ("notation + android*orbit^inner", "(notation + (android*(orbit^inner)))"),
        ("φ'^2", "((φ')^2)"),
    ] {
        assert_eq!(expr(text), tree, "{text}");
    }
    for (text, tree) in [
        ("i != j", "(i NotEqual j)"),
        ("i + 1 == j*2", "((i + 1) Equal (j*2))"),
        ("not i < j", "(not (i Less j))"),
        ("not not i < j", "(not (not (i Less j)))"),
        ("not i < j and k > l", "((not (i Less j)) and (k Greater l))"),
        (
            "a < 1 or b <= 2 and c >= 3 and d == 4",
            "((a Less 1) or ((b LessEqual 2) and (c GreaterEqual 3) and (d Equal 4)))",
        ),
        ("(a < 1 or b < 2) and c < 3", "(((a Less 1) or (b Less 2)) and (c Less 3))"),
        ("not (i == j)", "(not (i Equal j))"),
        ("mod(i, 2) == 0", "(mod(i, 2) Equal 0)"),
    ] {
        assert_eq!(condition(text), tree, "{text}");
    }
}

#[test]
fn places_are_exact() {
    let source = "\u{feff}# c\r\nV = k * (x - 2)^2 ; T = b.q'\r\n";
    let file = parse(source).unwrap();
    let at = |span: Span| &source[span.range()];
    let statements: Vec<&str> = file.statements.iter().map(|s| at(s.span)).collect();
    assert_eq!(statements, ["V = k * (x - 2)^2", "T = b.q'"]);
    let mut places: Vec<&str> = file.expressions.iter().map(|e| at(e.span)).collect();
    places.sort_unstable();
    assert_eq!(places, ["(x - 2)^2", "2", "2", "b", "b.q", "b.q'", "k", "k * (x - 2)^2", "x", "x - 2"]);
    assert_eq!(file.comments.len(), 1);
    assert_eq!(&*file.comments[0].text, " c");
    assert_eq!(at(file.comments[0].span).trim_end(), "# c");
    assert!(!file.comments[0].trailing);
}

#[test]
fn children_stand_before_parents() {
    let file = parse("V = a*f(b, -c)[d.e] + sum(i in 1..n where i != 2, [x[i]', 2^i])").unwrap();
    for (position, expr) in file.expressions.iter().enumerate() {
        let text = format!("{:?}", expr.kind);
        for piece in text.split("ExprRef(").skip(1) {
            let child: usize = piece.split(')').next().unwrap().parse().unwrap();
            assert!(child < position, "{text}");
        }
    }
}

#[test]
fn comments_know_what_stands_before_them() {
    let file = parse("# first\nparam a = 1 # second\n  # third\n\tparam b # fourth").unwrap();
    let comments: Vec<(&str, bool)> = file.comments.iter().map(|c| (&*c.text, c.trailing)).collect();
    assert_eq!(comments, [(" first", false), (" second", true), (" third", false), (" fourth", true)]);
}

#[test]
fn statements_end_where_the_next_begins() {
    for (source, printed) in [
        ("param a=1 param b param c=2", "param a = 1\nparam b\nparam c = 2\n"),
        ("coord x : m T = x'^2 V = x^2", "coord x : m\nT = x'^2\nV = x^2\n"),
        ("param B : T = 1 T = 2", "param B : T = 1\nT = 2\n"),
        ("param B : V*s/m^2 = 1", "param B : V*s/m^2 = 1\n"),
        ("param B : kg/(A*T) V = 1", "param B : kg/(A*T)\nV = 1\n"),
        ("param B : 1/T\nV = 1", "param B : 1/T\nV = 1\n"),
        ("coord x : T, y : V T = 1", "coord x : T, y : V\nT = 1\n"),
        ("coord x : T T = 1", "coord x : T\nT = 1\n"),
        (";;param a = 1;;; param b;", "param a = 1\nparam b\n"),
        ("V =\n\n# comment\n 1 +\n 2\n\n", "V = 1 + 2\n"),
        ("let a = b.T let c = b.period\nV = 1", "let a = b.T\nlet c = b.period\nV = 1\n"),
        ("param g = 9.81 +/- 0.01", "param g = 9.81 ± 0.01\n"),
        ("param g=9.81±0.01 T=1", "param g = 9.81 ± 0.01\nT = 1\n"),
        ("param a : m^(1/2)*s^-1*(kg)^(2)", "param a : m^(1/2)*s^-1*kg^2\n"),
        ("param a : 1 = 1", "param a : 1 = 1\n"),
        ("constraint [i in 1..n] x[i] = 0", "constraint [i in 1..n] x[i] = 0\n"),
        ("constraint [a, b][1] = 0", "constraint [a, b][1] = 0\n"),
        ("constraint [x, y] = [0, 0]", "constraint [x, y] = [0, 0]\n"),
        ("equilibrium x[i in 1..n]' : m/s = 2", "equilibrium x[i in 1..n]' : m/s = 2\n"),
        ("equilibrium phi' = W", "equilibrium phi' = W\n"),
        ("let x[k in 1..n] = x[k-1]", "let x[k in 1..n] = x[k-1]\n"),
        ("let x[n+1] = 0", "let x[n+1] = 0\n"),
        ("param m[a in atoms] = a.mass", "param m[a in atoms] = a.mass\n"),
        ("coord r[1..rows(atoms), 1..3]", "coord r[1..rows(atoms), 1..3]\n"),
        ("let a[i in 1..3, j in b where i != j] = 1", "let a[i in 1..3, j in b where i != j] = 1\n"),
        ("dissipation = 1 lagrangian = 2 period 3", "dissipation = 1\nlagrangian = 2\nperiod 3\n"),
        ("param modelled = 1 let periods = 2", "param modelled = 1\nlet periods = 2\n"),
        ("table a = \"b # c; T = 1.csv\"", "table a = \"b # c; T = 1.csv\"\n"),
        ("", ""),
        ("# only a comment", ""),
    ] {
        let file = parse(source).unwrap_or_else(|e| panic!("{source}: {e:#?}"));
        assert_eq!(print_file(&file), printed, "{source}");
    }
}

#[test]
fn line_ends_do_not_matter() {
    let source = include_str!("../syntax/three_pendulums.lag");
    let plain = print_file(&parse(source).unwrap());
    assert_eq!(print_file(&parse(&source.replace('\n', "\r\n")).unwrap()), plain);
    assert_eq!(print_file(&parse(&format!("\u{feff}{source}")).unwrap()), plain);
}

#[test]
fn one_mistake_does_not_hide_the_next() {
    let source = "coord x y\nT = 1/2*m*x'^2\nV = 2 x\nlet a = (\nparam sin = .5\n";
    assert_eq!(
        messages(source),
        [
            "a comma is missing between the names",
            "the multiplication sign is missing",
            "the bracket `(` is never closed",
            "a number needs digits on both sides of the point",
        ]
    );
}

/// Every way of nesting, `levels` deep.
fn nested(levels: usize) -> Vec<String> {
    let around = |open: &str, inner: &str, close: &str, levels: usize| {
        format!("{}{inner}{}", open.repeat(levels), close.repeat(levels))
    };
    vec![
        format!("V = {}", around("(", "x", ")", levels)),
        format!("V = {}", around("[", "x", "]", levels)),
        format!("V = {}", around("sin(", "x", ")", levels)),
        format!("V = {}", around("a*(b + ", "x", ")", levels)),
        format!("V = {}", around("sum(i in 1..2, ", "x", ")", levels)),
        format!("V = {}", around("x[", "1", "]", levels)),
        format!("V = x{}", "[1]".repeat(levels - 1)),
        format!("V = x{}", "'".repeat(levels)),
        format!("V = x{}", ".c".repeat(levels)),
        format!("V = {}x", "-".repeat(levels)),
        format!("period {}x", "-".repeat(levels)),
        format!("constraint {} = 0", around("[", "x", "]", levels)),
        format!("V = {}2", "2^".repeat(levels)),
        format!("V = {}2", "2^-".repeat(levels / 2)),
        format!("V = {}", around("-(", "x", ")", levels / 2)),
        format!("V = {}", around("2^(", "x", ")", levels / 2)),
        format!("V = {}", around("(-2)^(", "x", ")", levels / 2)),
        format!("V = sum(i in 1..2 where {}i == 1, 1)", "not ".repeat(levels - 1)),
        format!("V = sum(i in 1..2 where {}, 1)", around("not (", "i == 1", ")", levels / 2 - 1)),
        format!(
            "V = {}",
            around(
                "sum(i in 1..sum(j in 1..2 where j == 1 and j*2 == (j), 2), j in b where i + 1 == 1, 2*",
                "x",
                ")",
                levels - 2
            )
        ),
        format!("V = {}", around("sum(i in 1..", "3", ", 1)", levels)),
        format!("param a : {} = 1", around("(", "m", ")", levels)),
        format!("let a{} = 1", around("[x", "[1]", "]", levels / 2 - 1)),
    ]
}

#[test]
fn nesting_has_the_same_limit_everywhere() {
    // A small stack: what a thread gets by default.
    let thread = std::thread::Builder::new().stack_size(2 << 20);
    let work = thread.spawn(|| {
        for source in nested(256) {
            let start: String = source.chars().take(40).collect();
            let file = parse(&source).unwrap_or_else(|e| panic!("{start}: {e:#?}"));
            let printed = print_file(&file);
            // Parentheses leave no trace, the rest prints as deep as it is.
            parse(&printed).unwrap_or_else(|e| panic!("{start}: {e:#?}"));
        }
        for source in ["(", "[", "-", "sin(", "x[", "2^", "not "] {
            let errors = messages(&format!("V = {}", source.repeat(257)));
            assert_eq!(errors, ["this is nested too deeply: more than 256 levels"], "{source}");
        }
        for source in ["-", "("] {
            let errors = messages(&format!("period {}", source.repeat(257)));
            assert_eq!(errors, ["this is nested too deeply: more than 256 levels"]);
        }
        for (text, times) in [("x''", 1), ("x[1]", 1), ("b.c", 1)] {
            let (name, postfix) = text.split_at(1);
            let source = format!("V = {name}{}", postfix.repeat(257 * times));
            assert_eq!(messages(&source), ["this is nested too deeply: more than 256 levels"]);
        }
        // Far beyond the limit it is still only a message.
        for source in ["(", "[", "-", "sin(", "x[", "2^", "not ", "sum(i in 1..", "'", ")", "x["] {
            assert!(!messages(&format!("V = x{}", source.repeat(200_000))).is_empty());
            assert!(!messages(&format!("V = {}", source.repeat(200_000))).is_empty());
        }
    });
    work.unwrap().join().unwrap();
}

#[test]
fn length_is_not_depth() {
    let thread = std::thread::Builder::new().stack_size(2 << 20);
    let work = thread.spawn(|| {
        for (first, more) in
            [("1", " + 1"), ("1", " - -x[1]'^2"), ("1", "*2"), ("1", "/2^3"), ("[1", ", 2"), ("f(1", ", -2")]
        {
            let close = match first {
                "[1" => "]",
                "f(1" => ")",
                _ => "",
            };
            let source = format!("V = {first}{}{close}", more.repeat(20_000));
            let file = parse(&source).unwrap_or_else(|e| panic!("{more}: {:#?}", e[0]));
            assert_eq!(print_file(&file).trim_end(), source);
        }
        let source = format!("V = sum(i in 1..2 where 1 == 1{}, 1)", " and not 2 == i".repeat(20_000));
        assert!(parse(&source).is_ok());
        let source = format!("V = sum(i in 1..2{}, 1)", ", j in 1..2".repeat(20_000));
        assert!(parse(&source).is_ok());
    });
    work.unwrap().join().unwrap();
}

#[test]
fn too_much_is_refused() {
    let errors = parse(&" ".repeat((32 << 20) + 1)).unwrap_err();
    assert!(matches!(errors[..], [SyntaxError::FileTooLarge { .. }]));
    // Errors beyond counting are not all kept.
    assert!(parse(&"V = )\n".repeat(100_000)).unwrap_err().len() <= 1000);
    assert_eq!(parse(&"a = 1\n".repeat(100_000)).unwrap_err().len(), 1000);
    let source = format!("param b = 1\n{}", "a = 1\n".repeat(100_000));
    assert_eq!(parse(&source).unwrap_err().len(), 1000);
}

#[test]
fn a_mistake_stays_in_its_statement() {
    assert_eq!(messages("param sin : m^(1/0) = 1\nV = 1"), ["`sin` can't be used as a name"]);
}
