//! Input that nobody means well: huge ranges, deep chains, values that are not defined. On a small
//! stack, within two seconds each, every one of these comes to modes or to an error.
//!
//! The two seconds hold for optimized builds.
#![cfg(feature = "engine")]

use crate::language_support;

use std::fmt::Write;
use std::time::Duration;

use language_support::run_with_table;

/// A name, the model, a table named `t.csv` if there is one, and part of an error if there must be
/// one; `""` for any error, `None` where there must be modes.
struct Nasty {
    name: &'static str,
    source: String,
    table: Option<String>,
    error: Option<&'static str>,
}

fn bad(name: &'static str, error: &'static str, source: impl Into<String>) -> Nasty {
    Nasty { name, source: source.into(), table: None, error: Some(error) }
}

fn good(name: &'static str, source: impl Into<String>) -> Nasty {
    Nasty { name, source: source.into(), table: None, error: None }
}

fn chain(n: &str) -> String {
    format!(
        "param N = {n}  coord x[1..N]
         T = sum(i in 1..N, 1/2*x[i]'^2)
         V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2 + 1/2*x[N]^2"
    )
}

fn one(potential: &str) -> String {
    format!("coord x  T = 1/2*x'^2  V = {potential}")
}

fn repeated(count: usize, mut line: impl FnMut(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, i| {
        text.push_str(&line(i));
        text.push('\n');
        text
    })
}

fn cases() -> Vec<Nasty> {
    let mut cases = vec![
        bad("chain of 1e6", "too many", chain("1000000")),
        bad("chain of 1e12", "too many", chain("1000000000000")),
        bad("chain of 1e30", "", chain("1e30")),
        bad("chain of 1e400", "", chain("1e400")),
        bad("chain of 10^10^10", "", chain("10^10^10")),
        bad("negative chain", "", chain("-5")),
        bad("chain of none", "", chain("0")),
        bad("half a chain", "whole number", chain("2.5")),
        good("a sum of 1e6 terms", one("sum(i in 1..1000000, 1/2*x^2/1000000)")),
        bad("a sum of 1e12 terms", "too many", one("sum(i in 1..1e12, x^2)")),
        bad("a sum of 1e18 x 1e18", "too many", one("sum(i in 1..1e18, j in 1..1e18, x^2)")),
        bad("a sum of 1e30 terms", "", one("sum(i in 1..1e30, x^2)")),
        bad("a filtered sum of 1e12", "too many", one("sum(i in 1..1e12 where i == 1, x^2)")),
        bad("nested sums", "too many", one("sum(i in 1..100000, sum(j in 1..100000, x^2))")),
        bad(
            "nested sums of sums",
            "too many",
            one("sum(a in 1..3000, sum(b in 1..3000, sum(c in 1..3000, x^2*a*b*c)))"),
        ),
        bad("a family with 1e12 members", "too many", format!("param k[1..1e12] = 1 {}", one("k[1]*x^2"))),
        bad(
            "a family with 1e12 members by three indices",
            "too many",
            format!("param k[1..10000, 1..10000, 1..10000] = 1 {}", one("k[1,1,1]*x^2")),
        ),
        bad("a let family with 1e12 members", "too many", format!("let k[i in 1..1e12] = i {}", one("k[1]*x^2"))),
        bad(
            "coordinates at the end of integers",
            "",
            "coord x[9223372036854775800..9223372036854775807] T = x[9223372036854775800]'^2",
        ),
        bad(
            "indices beyond integers",
            "",
            one(
                "sum(i in 9223372036854775806..9223372036854775807, j in 1..2 where j == i + 9223372036854775807, x^2) + sum(i in 1..2, sum(j in i*9223372036854775807..3, x^2))*y",
            ),
        ),
        bad("members beyond integers", "", "coord x[1..3] T = sum(i in 1..3, x[i + 9223372036854775807]'^2)"),
        good("an empty family beside another", "coord y[1..0], x  T = 1/2*x'^2 + sum(i in 1..0, y[i]'^2)  V = x^2"),
        good("an empty family of parameters", "param k[1..0] = 3  coord x  T = 1/2*x'^2  V = x^2"),
        good("exponents of 1e9", one("x^2 + (1 + x)^1000000000*0 + x^1000000000")),
        bad("exponents of 1e30", "", one("(2 + x)^1e30")),
        good("towers", one("x^2 + 0*2^3^4")),
        bad("high towers", "", one("x^2 + 2^3^4^5^6^7")),
        good("huge literals", one("x^2*1e280")),
        bad("literals beyond doubles", "", one("x^2*1e3000000000")),
        bad("literals beyond sense", "", one("x^2*1e99999999999999999999")),
        bad("small literals beyond sense", "", one("x^2*1e-99999999999999999999")),
        bad("root at 0", "not defined", one("x^0.5")),
        bad("root of x at 0", "not defined", one("sqrt(x)")),
        bad("logarithm of 0", "not defined", one("x^2 + ln(0)")),
        bad("logarithm of x at 0", "not defined", one("ln(x)")),
        bad("logarithm of -1", "not defined", one("x^2*ln(-1)")),
        bad("asin of 2", "not defined", one("x^2*asin(2)")),
        bad("root of -1", "not defined", one("x^2*sqrt(-1)")),
        bad("1/0", "not defined", one("x^2/0")),
        bad("1/(1 - 1)", "not defined", one("x^2/(1 - 1)")),
        bad("0^-1", "not defined", one("x^2*0^-1")),
        bad("1/x", "not defined", one("1/x")),
        bad("abs at its kink", "", one("abs(x)")),
        bad("x^1.5 at 0", "", one("x^1.5")),
        bad("tan at its pole", "", format!("{} equilibrium x = pi/2", one("tan(x)^2"))),
        bad("mod by 0", "", one("sum(i in 1..3 where mod(i, 0) == 1, x^2)")),
        bad("index by 0", "", "coord x[1..3] T = sum(i in 1..3, x[i/0]'^2)"),
        bad("an undefined family member", "not defined", format!("param k[i in 0..3] = 1/i {}", one("x^2*k[1]"))),
        bad("primes", "acceleration", "coord x T = 1/2*x''^2"),
        bad("many primes", "acceleration", format!("coord x T = 1/2*x{}^2", "'".repeat(200))),
        bad("thousands of primes", "", format!("coord x T = 1/2*x{}^2", "'".repeat(100_000))),
        bad("primes of a product", "", format!("coord x T = 1/2*(sin(x)*cos(x)*exp(x)){}^2", "'".repeat(60))),
        bad("a family of 1000 indices", "", format!("coord x[{}] T = 1", vec!["1..1"; 1000].join(", "))),
        bad("a member of 1000 indices", "", format!("coord x[1..2] T = x[{}]'^2", vec!["1"; 1000].join(", "))),
        bad(
            "a sum of 1000 indices",
            "",
            one(&format!("sum({}, x^2)", (0..1000).map(|i| format!("i{i} in 1..2")).collect::<Vec<_>>().join(", "))),
        ),
        good(
            "a sum of 100 indices over one",
            one(&format!("sum({}, x^2)", (0..100).map(|i| format!("i{i} in 1..1")).collect::<Vec<_>>().join(", "))),
        ),
    ];
    cases.push(good(
        "100,000 chained lets",
        format!(
            "coord x let a0 = x\n{} T = 1/2*x'^2 V = 1/2*a99999^2",
            repeated(99_999, |i| format!("let a{} = a{i} + x/100000", i + 1))
        ),
    ));
    cases.push(good(
        "100,000 chained parameters",
        format!(
            "coord x param a0 = 1\n{} T = 1/2*x'^2 V = 1/2*a99999*x^2",
            repeated(99_999, |i| format!("param a{} = a{i} + 1/100000", i + 1))
        ),
    ));
    cases.push(good(
        "deep functions",
        format!(
            "coord x let a0 = x\n{} T = 1/2*x'^2 V = 1/2*a5000^2",
            repeated(5_000, |i| format!("let a{} = sin(a{i})", i + 1))
        ),
    ));
    cases.push(good(
        "families of lets, 5,000 deep",
        format!(
            "coord x[1..2] let a0[i in 1..2] = x[i]\n{}
             T = sum(i in 1..2, 1/2*x[i]'^2) V = sum(i in 1..2, 1/2*a5000[i]^2)",
            repeated(5_000, |i| format!("let a{}[i in 1..2] = a{i}[i] + x[i]", i + 1))
        ),
    ));
    cases.push(good(
        "families of lets, doubling",
        format!(
            "coord x[1..2] let a0[i in 1..2] = x[i]/1e9\n{}
             T = sum(i in 1..2, 1/2*x[i]'^2) V = sum(i in 1..2, 1/2*a60[i]^2)",
            repeated(60, |i| format!("let a{}[i in 1..2] = a{i}[i] + a{i}[3 - i]", i + 1))
        ),
    ));
    cases.push(good(
        "a recursion of 20,000",
        "coord x  let a[0] = x  let a[k in 1..20000] = a[k-1] + x/20000
         T = 1/2*x'^2  V = 1/2*a[20000]^2",
    ));
    cases.push(good(
        "a recursion of sines of 3,000",
        "coord x  let a[0] = x  let a[k in 1..3000] = sin(a[k-1])
         T = 1/2*x'^2  V = 1/2*a[3000]^2",
    ));
    cases.push(good(
        "Fibonacci through 200 lets of a coordinate",
        "coord x  let a[0] = x  let a[1] = x  let a[k in 2..200] = (a[k-1] + a[k-2])/2
         T = 1/2*x'^2  V = 1/2*a[200]^2",
    ));
    cases.push(bad(
        "squares of squares",
        "this value is too long",
        "coord x  let a[0] = 1 + x/1e30  let a[k in 1..60] = a[k-1]^2
         T = 1/2*x'^2  V = 1/2*x^2 + a[60]*1e-60",
    ));
    cases.push(good(
        "velocities through a recursion",
        "coord x  let a[0] = x  let a[k in 1..2000] = a[k-1] + sin(x)/2000
         T = 1/8*a[2000]'^2  V = x^2",
    ));
    cases.push(good("a sum of 50,000 written out", one(&vec!["x^2/50000"; 50_000].join(" + "))));
    cases.push(good("a product of 3,000", one(&format!("x^2*{}", vec!["cos(x)"; 3_000].join("*")))));
    cases.push(good("differences of 3,000", one(&format!("x^2 - {}", vec!["x^3"; 3_000].join(" - ")))));
    cases.push(good("200 parentheses", one(&format!("{}x^2{}", "(".repeat(200), ")".repeat(200)))));
    cases.push(bad("1e5 parentheses", "", one(&format!("{}x^2{}", "(".repeat(100_000), ")".repeat(100_000)))));
    cases.push(bad("1e5 minus signs and no operand", "", one(&"-".repeat(100_000))));
    cases.push(bad("1e4 minus signs", "nested too deeply", one(&format!("{}x^2", "-".repeat(10_000)))));
    cases.push(bad(
        "members given twice through a filter",
        "given twice",
        format!("param a[3] = 1 param a[i in 1..3 where i != 2] = 2 {}", one("sum(i in 1..1, a[i]*x^2)")),
    ));
    cases.push(good("powers of one", one(&format!("x^2{}", "^1".repeat(200)))));
    cases.push(bad("an open vector", "", one(&"[".repeat(100_000))));
    cases.push(bad("a matrix too deep", "", one(&format!("{}x{}", "[".repeat(200), "]".repeat(200)))));
    let mut vectors = String::from("let u = [x");
    (0..20_000).for_each(|_| vectors.push_str(", x"));
    cases.push(good("a vector of 20,001", format!("coord x {vectors}] T = 1/2*x'^2 V = dot(u, u)/20001")));
    cases.push(bad("tensors of tensors", "", "coord x let A = [[x,x],[x,x]] T = 1/2*x'^2 V = dot(A, A)"));
    cases.push(bad("shapes that do not fit", "", "coord x let A = [[1,2],[3]] T = 1/2*x'^2 V = (A*[x, x])[1]"));
    cases.push(bad("cross in the plane", "", "coord x let A = cross([1,2],[3,4]) T = 1/2*x'^2 V = x^2*A"));
    let mut rows = String::from("m,k\n");
    for i in 0..100_000 {
        let _ = writeln!(rows, "{},{}", 1 + i % 7, 1 + i % 3);
    }
    cases.push(Nasty {
        name: "a table with 100,000 rows",
        source: "table t = \"t.csv\" coord x T = sum(a in t, 1/2*a.m*x'^2) V = sum(a in t, a.k*x^2)"
            .to_owned()
            .replace("table t ", "table tt ")
            .replace("in t,", "in tt,"),
        table: Some(rows.clone()),
        error: None,
    });
    cases.push(Nasty {
        name: "a family of 100,000 rows",
        source: "table s = \"t.csv\" param m[a in s] = 2*a.m coord x T = sum(a in s, 1/2*m[a]*x'^2) V = x^2".to_owned(),
        table: Some(rows.clone()),
        error: None,
    });
    cases.push(Nasty {
        name: "coordinates of 100,000 rows",
        source: "table s = \"t.csv\" coord x[a in s] T = sum(a in s, 1/2*a.m*x[a]'^2)".to_owned(),
        table: Some(rows.clone()),
        error: Some("too many"),
    });
    cases.push(Nasty {
        name: "pairs of 100,000 rows",
        source: "table s = \"t.csv\" coord x T = 1/2*x'^2 V = sum(a in s, b in s, a.m*b.k*x^2)".to_owned(),
        table: Some(rows),
        error: Some("too many"),
    });
    for (name, table, error) in [
        ("an empty table", "", Some("")),
        ("a table without rows", "k\n", Some("")),
        ("a table with 0", "k\n0\n", Some("not defined")),
        ("a table with a word", "k\nabc\n", Some("")),
        ("a table with nan", "k\nnan\n", Some("")),
        ("a table with inf", "k\ninf\n", Some("")),
        ("a table with 1e999999999999", "k\n1e999999999999\n", Some("")),
        ("a ragged table", "k,m\n1\n", Some("")),
        ("a table with a double header", "k,k\n1,2\n", Some("")),
        ("a table with a byte order mark", "\u{feff}k\n1\n", None),
        ("a table with CRLF", "k\r\n1\r\n", None),
        ("a table with spaces", " k , m \n 1 , 2 \n", None),
        ("a table with quotes", "\"k\",m\n\"1\",2\n", None),
        ("a table with negative and signed numbers", "k,m\n+1,-2e-3\n", None),
        ("a table with an empty line at the end", "k\n1\n\n", None),
        ("a table with a name", "k,name\n1,oxygen\n", None),
        ("a table with binary", "k\n\u{0}\n", Some("")),
    ] {
        cases.push(Nasty {
            name,
            source: "table s = \"t.csv\" coord x T = 1/2*x'^2 V = x^2/s[1].k".to_owned(),
            table: Some(table.to_owned()),
            error,
        });
    }
    cases
}

#[test]
fn nasty_input_comes_to_an_end() {
    let only = std::env::var("ONLY").ok();
    let mut faults = Vec::new();
    for case in cases() {
        if only.as_ref().is_some_and(|only| !case.name.contains(only.as_str())) {
            continue;
        }
        let (source, table) = (case.source.clone(), case.table.clone());
        // An overflow of the stack takes the process down: this is the name to look for then.
        println!("{}", case.name);
        let (sender, receiver) = std::sync::mpsc::channel();
        std::thread::Builder::new()
            .stack_size(2 << 20)
            .spawn(move || {
                let result = run_with_table(&source, table.as_deref())
                    .map(|done| done.normal.modes.len())
                    .map_err(|fault| fault.messages);
                let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
                let _ = sender.send((result, time.tv_sec));
            })
            .unwrap();
        let result = receiver.recv_timeout(Duration::from_secs(60));
        // Without optimization everything takes three times as long. Time of the thread: tests run side by side.
        let most = if cfg!(debug_assertions) { 8 } else { 2 };
        let took = result.as_ref().map_or(60, |(_, seconds)| *seconds);
        if took >= most {
            faults.push(format!("{}: takes {took} s", case.name));
        }
        match (result.map(|(result, _)| result), case.error) {
            (Err(std::sync::mpsc::RecvTimeoutError::Timeout), _) => {}
            (Err(_), _) => faults.push(format!("{}: a panic", case.name)),
            (Ok(Ok(_)), None) => {}
            (Ok(Ok(_)), Some(_)) => faults.push(format!("{}: no error", case.name)),
            (Ok(Err(messages)), None) => {
                let shown: String = format!("{messages:?}").chars().take(300).collect();
                faults.push(format!("{}: {shown}", case.name));
            }
            (Ok(Err(messages)), Some(error)) => {
                if !messages.iter().any(|(text, _)| text.contains(error)) {
                    let shown: String = format!("{messages:?}").chars().take(300).collect();
                    faults.push(format!("{}: not `{error}`: {shown}", case.name));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
