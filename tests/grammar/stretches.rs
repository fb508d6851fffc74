//! Instances of sums are found in stretches along an index: the same as one by one, which a filter on that index makes
//! them be.
#![cfg(feature = "engine")]

use librate_core::model::{Model, Settings, TableTexts, TermFamily, elaborate};
use librate_core::syntax::parse;

fn model(text: &str) -> Model {
    let table = "x,y,mass,name\n0,0,1,a\n1,0,2,b\n2,0.5,1,c\n3,-1,2,d\n3,1.5,1,e\n";
    let tables = TableTexts::new().with("points.csv", table);
    let file = parse(text).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0]));
    elaborate(&file, &tables, &Settings::new()).unwrap_or_else(|errors| panic!("{text}\n{errors:?}"))
}

/// All that a family says, in words: it does not depend on when an expression was made.
fn described(model: &Model, family: &TermFamily) -> String {
    let mut out = format!("{} instances of {}\n", family.count, model.pool.display(family.body));
    for at in 0..family.count {
        let constants = family.constants_of(at).iter().map(|constant| model.pool.display(*constant));
        let constants: Vec<String> = constants.collect();
        out.push_str(&format!("{:?} {constants:?}\n", family.coordinates_of(at)));
    }
    out
}

const PLAIN: &str = "param m = 1  param N = 9  param k[1..12] = [1,2,3,4,5,6,7,8,9,10,11,12]  coord x[1..9], y[0..9]
T = sum(i in 1..9, 1/2*m*x[i]'^2) + sum(i in 0..9, 1/2*m*y[i]'^2)\n";

#[test]
fn stretches_are_what_single_instances_are() {
    let lets = "let u[0] = 0\nlet u[i in 1..N{let}] = x[i]\nlet u[N+1] = 0\nlet s[i in 0..N{let}] = u[i+1] - u[i]\n";
    let sums = [
        "sum(i in 0..N{i}, 1/2*s[i]^2 + 1/4*s[i]^4)",
        // Leaves that meet, once in the middle and once at an end.
        "sum(i in 1..N{i}, x[i]*x[5])",
        "sum(i in 1..N{i}, x[i]*x[1]*x[9])",
        "sum(i in 1..N{i}, x[i]*x[N+1-i])",
        "sum(i in 1..N{i}, x[i]*x[N-i+1]*x[5])",
        "sum(i in 1..4{i}, x[2*i]*x[2*i+1]*x[9-2*i])",
        "sum(i in 1..N{i}, i*x[i]^2 + 3*x[i]*x[3] + (5 - i)*i^2*x[i])",
        "sum(i in 1..N{i}, k[i+1]*x[i]^2*k[4])",
        "sum(i in 1..4{i}, k[3*i]*x[mod(i, 2) + 1]*x[floor(i/2) + 1])",
        "sum(i in 1..3{i}, x[i]^i*x[i+1]^(4 - i))",
        "sum(i in 1..N{i}, y[i-1]*x[i])",
        // Sums within sums, of fixed and of changing length.
        "sum(i in 1..N-2{i}, sum(j in i..i+2, x[j])^2)",
        "sum(i in 1..N{i}, sum(j in 1..i, x[j])^2)",
        "sum(i in 1..N{i}, sum(j in 1..3, j*x[j]*x[i])^2)",
        "sum(i in 1..N{i}, sum(j in 1..N where j != i, x[j]*x[i])^2)",
        "sum(i in 1..N{i}, sum(j in 1..N where j <= 3, x[j]*x[i])^2)",
        // Two indices, of which the last is short, long, or depends on the first.
        "sum(i in 1..N, j in 1..3{j}, x[i]*x[j])",
        "sum(i in 1..3, j in 1..N, l in 0..1{l}, x[i+l]*y[j]*x[i])",
        "sum(i in 1..N, j in i..N{j}, x[i]*x[j])",
        "sum(i in 1..N, j in 1..3 where i != 4{&j}, x[i]*y[j+1])",
        "sum(i in 1..N, j in i-1..i{j}, x[i]*y[j])",
        "sum(a in points, b in points where a < b{&b}, (x[a] - x[b])^2*a.mass)",
        "sum(a in points{a}, a.mass*x[a]^2*(a.x + a.y) + points[2].x*x[2])",
        "sum(a in points{a}, x[a]^a.mass)",
        "sum(i in 1..4{i}, points[i+1].x*points[3].x*x[i]^2)",
        "dot(x, x) + sum(i in 1..3{i}, dot(p[i], p[i+1]) + p[i][1]^2 + q[i,1]^2*q[1,i] + dot(q[i], q[2]))",
        "sum(i in 2..8{i}, f[i] + f[i-1]*f[2])",
    ];
    let more = "let p[i in 1..9{let}] = [x[i], y[i-1], i]\nlet q[i in 1..3, j in 1..3] = x[i]*y[j]\n\
        let f[i in 1..4] = x[i]\nlet f[i in 5..9] = y[i]^2\n";
    for sum in sums {
        let text = |filter: bool| {
            let mut text = format!("table points = \"points.csv\"\n{PLAIN}{lets}{more}V = {sum}\n");
            for index in ["i", "j", "l", "a"] {
                let with = if filter { format!(" where {index} > -99") } else { String::new() };
                text = text.replace(&format!("{{{index}}}"), &with);
            }
            for index in ["b", "j"] {
                let with = if filter { format!(" and {index} > -99") } else { String::new() };
                text = text.replace(&format!("{{&{index}}}"), &with);
            }
            text.replace("{let}", if filter { " where i > -99" } else { "" })
        };
        let (whole, single) = (model(&text(false)), model(&text(true)));
        let all = |model: &Model| -> Vec<String> {
            model.kinetic.iter().chain(&model.potential).map(|family| described(model, family)).collect()
        };
        assert_eq!(all(&whole), all(&single), "{sum}");
    }
}

#[test]
fn many_coordinates_have_their_names() {
    let text = "coord x[0..99, -50..49], y[1..3, 1..2, 1..2000]  T = sum(i in 0..99, j in -50..49, x[i,j]'^2)\n\
        + sum(i in 1..3, j in 1..2, k in 1..2000, y[i,j,k]'^2)  V = x[3,-7]*y[2,1,17]^2";
    let mut model = model(text);
    let at = 3 * 100 + 43;
    assert_eq!(model.coordinates.at(at).name(), "x[3,-7]");
    let other = 10_000 + 2 * 2000 + 16;
    assert_eq!(model.coordinates.at(other).name(), "y[2,1,17]");
    assert_eq!(model.coordinates.names().filter(|name| name == "y[2,1,17]").count(), 1);
    assert_eq!(model.pool.display(model.potential[0].body), "x[3,-7]*y[2,1,17]^2");
    let velocity = model.coordinates.at(other).velocity;
    assert_eq!(model.pool.symbol_name(velocity), "y[2,1,17]'");
    assert_eq!(model.kinetic.iter().map(|family| family.count).sum::<usize>(), 22_000);
    let time = model.pool.fresh_symbol("later");
    assert_eq!((model.pool.symbol_name(time).as_ref(), model.symbols.get(time)), ("later", None));
}

/// Filters over pairs are sieved: what is left is what visiting all pairs leaves, which a part that nothing is said about in
/// advance makes be done.
#[test]
fn sieved_pairs_are_all_pairs() {
    let mut state = 17_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % 1000
    };
    let mut table = "x,y,z,kind\n".to_owned();
    for _ in 0..150 {
        table.push_str(&format!("{}e-2,{}e-2,{}e-3,{}\n", random(), random(), random(), random() % 3));
    }
    let tables = TableTexts::new().with("points.csv", table);
    let filters = [
        "a < b and (a.x - b.x)^2 + (a.y - b.y)^2 + (a.z - b.z)^2 <= 1.5^2",
        "a != b and norm([a.x - b.x, a.y - b.y]) < c[1]",
        "a < b and sqrt((a.x - b.x)^2 + (a.y - b.y)^2) < 1 and (a.kind == 1 or b.kind == 1 or not a.kind == b.kind)",
        "b == a + 1 or abs(r[a,1] - r[b,1]) <= c[2]*r[b,2]",
        "a > b and 1/(2 + (a.x - b.x)^2) > 0.45",
        "a < b and (a.x - b.x)^3 > 700 or (0.1 + a.x*b.x)^(-1) > 4",
        "a.x - b.x == 0 and a != b",
        "abs(a - b) == 7 and a.kind == b.kind",
        "mod(b, 5) == 2 and floor(b.x) > a.y and a <= 9",
        "a.x > b.x + 9.5 or b.z*0 > 1",
        "a.x > b.x - 100",
        "a.kind == 0 and b < a - 100",
    ];
    let ranges = ["a in points, b in points", "a in 1..150, b in a..150", "a in points, b in 3..120, l in 1..2"];
    for filter in filters {
        for range in ranges {
            let text = |filter: &str| {
                let filter = if range.starts_with("a in 1") {
                    filter.replace("a.", "points[a].").replace("b.", "points[b].")
                } else {
                    filter.replace("b.", if range.contains("..") { "points[b]." } else { "b." })
                };
                format!(
                    "table points = \"points.csv\"\nparam c[1..2] = [0.9, 1/3]  param r[a in points, j in 1..2] = a.x*j/2 + 0*a.y\n\
                     coord x[1..150]\nT = sum(i in 1..150, x[i]'^2)\nV = sum({range} where {filter}, (x[a] - x[b])^2)"
                )
            };
            let read = |text: String| {
                let file = parse(&text).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0]));
                elaborate(&file, &tables, &Settings::new())
            };
            let sieved = read(text(filter)).unwrap_or_else(|errors| panic!("{filter}\n{errors:?}"));
            let all = read(text(&format!("mod(a + b, 1) == 0 and ({filter})"))).unwrap();
            let described = |model: &Model| -> Vec<String> {
                model.potential.iter().map(|family| described(model, family)).collect()
            };
            assert_eq!(described(&sieved), described(&all), "{range}: {filter}");
        }
    }
    // A divisor that is 0 somewhere is an error in both.
    for filter in ["1/(a.kind - b.kind) > 2", "a != b and 1/(a.kind - b.kind) > 2", "sqrt(a.x - b.x) < 1"] {
        let text = format!(
            "table points = \"points.csv\"\ncoord x[1..150]\nT = sum(i in 1..150, x[i]'^2)\nV = sum(a in points, b in points where {filter}, x[a]*x[b])"
        );
        let errors = elaborate(&parse(&text).unwrap(), &tables, &Settings::new()).unwrap_err();
        assert!(errors[0].to_string().contains("is not defined"), "{}", errors[0]);
    }
}
