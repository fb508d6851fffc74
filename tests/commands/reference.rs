//! The reference of the language, made from the program's own tables and from the grammar. With `UPDATE_BOOK=1` it is written anew.
#![cfg(feature = "cli")]

use std::fmt::Write;
use std::path::Path;

use fancy_regex::Regex;
use librate::expr::Pool;
use librate::linearize::constant;
use librate::model::{self, Settings, TableTexts, elaborate, unit_dimension};
use librate::precision::decimal;
use librate::syntax::{FUNCTIONS, STATEMENT_WORDS, parse, reserved_meaning, signature};

use librate_core::expr::function_from_name;

use crate::book::{hold, read};

/// A row of a table.
fn row(cells: &[String]) -> String {
    format!("| {} |\n", cells.iter().map(|own| own.replace('|', "\\|")).collect::<Vec<_>>().join(" | "))
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

/// The rules of the grammar as tables of an EBNF, one for each of its parts.
fn rules() -> String {
    let grammar = read(Path::new("grammar/librate.pest"));
    let comments = Regex::new(r"(?m)^// (?!----).*\n").unwrap();
    let grammar = comments.replace_all(&grammar, "").into_owned();
    // Words, which are written where they are used.
    let word = Regex::new(r#"(?m)^(\w+) += @\{ ("\w+"|\("point[^)]*\)) ~ !word_rest \}\n"#).unwrap();
    let words: Vec<_> = word.captures_iter(grammar.as_str()).map(|own| own.unwrap()).collect();
    let words: Vec<(String, String)> = words.iter().map(|own| (own[1].to_owned(), own[2].to_owned())).collect();
    let grammar = word.replace_all(&grammar, "").into_owned();
    let rule = Regex::new(r"(?s)(\w+) += [@_]?\{(.*?)\}\n").unwrap();
    let mut text = String::new();
    for part in grammar.split("// ---- ").skip(1) {
        let (title, rest) = part.split_once(" --").unwrap();
        let _ = write!(text, "\n### {}\n\n| rule | is |\n| --- | --- |\n", title[..1].to_uppercase() + &title[1..]);
        // A statement alone is for the program.
        let all = rule.captures_iter(rest).map(|own| own.unwrap());
        for own in all.filter(|own| &own[1] != "single") {
            let mut body = own[2].split_whitespace().filter(|own| *own != "~").collect::<Vec<_>>().join(" ");
            for (name, word) in &words {
                body = Regex::new(&format!(r#"(?<!")\b{name}\b(?!")"#))
                    .unwrap()
                    .replace_all(&body, word.as_str())
                    .into_owned();
            }
            text += &row(&[code(&own[1]), code(&body)]);
        }
    }
    text
}

/// Whether a constant has a value.
fn is_defined(value: &str) -> bool {
    let file = parse(&format!("param y = {value}  coord q  T = 1/2*q'^2  V = y*q^2")).unwrap();
    elaborate(&file, &TableTexts::new(), &Settings::new()).is_ok()
}

/// Where a function of x is defined, from where it is at a few numbers.
fn domain(name: &str) -> &'static str {
    let defined = |x: &str| is_defined(&format!("{name}({x})"));
    let signs: String = ["-2", "-1", "0", "1/2", "1", "2"].map(|x| if defined(x) { '+' } else { '-' }).iter().collect();
    match signs.as_str() {
        "++++++" if !defined("pi/2") => "all x except π/2 + n π",
        "++++++" => "all x",
        "-++++-" => "-1 ≤ x ≤ 1",
        "--++++" => "x ≥ 0",
        "---+++" => "x > 0",
        _ => panic!("{name} is defined at none but {signs}"),
    }
}

/// The derivatives of a function by each of its arguments.
fn derivatives(name: &str, arguments: &[&str]) -> Vec<String> {
    let mut pool = Pool::new();
    let values: Vec<_> = arguments.iter().map(|own| pool.variable(own)).collect();
    let value = match (function_from_name(name), &values[..]) {
        (Some(function), [x]) => pool.apply(function, *x),
        (None, [x]) => pool.sqrt(*x),
        (_, values) => pool.atan2(values[0], values[1]),
    };
    let slope = |own: &&str| {
        let by = pool.symbol(own);
        let slope = pool.diff(value, by);
        pool.display(slope)
    };
    arguments.iter().map(slope).collect()
}

fn functions() -> String {
    let mut text = "\n| function | is | derivative | for |\n| --- | --- | --- | --- |\n".to_owned();
    for name in FUNCTIONS.into_iter().chain(["sum", "integral", "rows"]) {
        let (call, meaning) = signature(name).unwrap();
        let (slope, domain) = match call.strip_prefix(name).unwrap() {
            "(x)" => (code(&derivatives(name, &["x"])[0]), domain(name)),
            "(y, x)" => {
                let slopes = derivatives(name, &["y", "x"]);
                let by = format!("by y {}, by x {}", code(&slopes[0]), code(&slopes[1]));
                assert!(!is_defined("atan2(0, 0)") && is_defined("atan2(0, -1)"));
                (by, "all but (0, 0)")
            }
            _ => (String::new(), ""),
        };
        text += &row(&[code(call), meaning.to_owned(), slope, domain.to_owned()]);
    }
    text
}

/// What one of a unit is in SI.
fn in_si(unit: &str) -> String {
    let file = parse(&format!("param x : {unit} = 1")).unwrap();
    let (pool, values) = model::constants(&file, &TableTexts::new(), &Settings::new());
    let number = match pool.display(values[0].1) {
        angle if angle.contains("pi") => angle,
        _ => decimal(&constant(&pool, values[0].1).unwrap(), 14).text,
    };
    let (digits, power) = number.split_at(number.find('e').unwrap_or(number.len()));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    match unit_dimension(unit).unwrap() {
        own if own.is_number() => format!("{digits}{power}"),
        own => format!("{digits}{power} {}", own.unit()).replace("1 1/", "1/"),
    }
}

fn units() -> String {
    let mut text = "\n| unit | is | prefixes | measures |\n| --- | --- | --- | --- |\n".to_owned();
    for unit in model::unit_names() {
        let prefixes = if unit_dimension(&format!("M{unit}")).is_some() { "yes" } else { "" };
        let measures = unit_dimension(unit).unwrap().to_string();
        text += &row(&[code(unit), in_si(unit), prefixes.to_owned(), measures]);
    }
    text
}

#[test]
fn the_reference_is_made_from_the_program() {
    let grammar = read(Path::new("grammar/librate.pest"));
    let keywords = grammar.split_once("keyword = @{").unwrap().1.split_once('}').unwrap().0;
    let words = keywords.split('"').skip(1).step_by(2).chain(["t", "pi", "rows"]);
    let is_own = |word: &&str| !STATEMENT_WORDS.contains(word) || matches!(*word, "T" | "V");
    let (plain, named): (Vec<&str>, Vec<&str>) =
        words.filter(is_own).partition(|word| reserved_meaning(word) == Some("is a word of the language"));
    let named = named.into_iter().map(|word| format!("{} {}", code(word), reserved_meaning(word).unwrap()));
    let others: Vec<String> = plain.into_iter().map(code).chain(named).collect();
    let text = format!(
        "# Words, functions, units, grammar\n\nA test makes this page from the program's own tables and from its grammar; \
         [the language guide](language.md) says what the\nforms mean.\n\n## Words\n\nStatements begin with {}. Reserved\nbeside these and the names of functions: {}.\nUnits have names of their own.\n\n## Functions\n{}\n## Units\n\nPrefixes are those of the SI, from `q` to `Q`.\n{}\n## Grammar\n\n\
         A file is a `file`. In the tables `a b` is a, then b; `a | b` is a, or else b; `a*`, `a+`, `a?` are any number, at least one, at most one of a; \
         `!a` means\nthat no a follows, `&a` that one does, which is read by what comes next; `'a'..'b'` is a character from a to b. `SOI` and `EOI` are start and end of the \
         text.\nBetween words and signs there may be blanks, line breaks and comments; a word ends where no `word_rest` follows.\n{}",
        STATEMENT_WORDS.map(code).join(", "),
        others.join(", "),
        functions(),
        units(),
        rules(),
    );
    hold(Path::new("docs/reference.md"), &text);
}
