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
