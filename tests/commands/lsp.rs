//! `librate lsp` from outside: an editor that opens texts, changes them and asks.
#![cfg(feature = "cli")]

use crate::cli_support::command;

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use proptest::prelude::*;
use serde_json::{Value, json};

/// Letters of two bytes and one unit of UTF-16, and one of four bytes and two units.
const PENDULUM: &str = "\
model pendel
param m : kg = 1  param g : m/s^2 = 9.81  # 𝒢 and φ before names
param ℓ : m = 0.5
param ω0 = sqrt(g/ℓ)
coord φ : rad
T = 1/2*m*ℓ^2*φ'^2
V = m*g*ℓ*(1 - cos(φ))
assume ω0 > 0
";

struct Editor {
    server: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    asked: u64,
    version: u64,
}

impl Editor {
    fn new() -> Self {
        let mut server = command(&["lsp"]).stdin(Stdio::piped()).spawn().unwrap();
        let (input, output) = (server.stdin.take(), BufReader::new(server.stdout.take().unwrap()));
        let mut editor = Self { server, input, output, asked: 0, version: 0 };
        let answer = editor.ask("initialize", json!({"capabilities": {}}));
        assert_eq!(answer["capabilities"]["renameProvider"]["prepareProvider"], json!(true));
        editor.tell("initialized", json!({}));
        assert_eq!(editor.asked("workspace/symbol", json!({"query": ""}))["error"]["code"], json!(-32601));
        editor
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let input = self.input.as_mut().unwrap();
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        input.flush().unwrap();
    }

    fn receive(&mut self) -> Value {
        let (mut line, mut length) = (String::new(), 0);
        loop {
            line.clear();
            assert_ne!(self.output.read_line(&mut line).unwrap(), 0, "the server ended");
            match line.trim().split_once(": ") {
                Some(("Content-Length", count)) => length = count.parse().unwrap(),
                Some(_) => {}
                None => break,
            }
        }
        let mut text = vec![0; length];
        self.output.read_exact(&mut text).unwrap();
        serde_json::from_slice(&text).unwrap()
    }

    fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({"jsonrpc": "2.0", "method": method, "params": params}));
    }

    /// The whole response.
    fn asked(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let id = self.asked;
        self.send(&json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}));
        loop {
            let message = self.receive();
            if message["id"] == json!(id) {
                return message;
            }
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        let answer = self.asked(method, params);
        assert!(answer.get("error").is_none(), "{answer}");
        answer["result"].clone()
    }

    /// The mistakes that are shown for a text.
    fn open(&mut self, uri: &str, text: &str) -> Vec<Value> {
        self.version += 1;
        let document = json!({"uri": uri, "version": self.version, "languageId": "librate", "text": text});
        self.tell("textDocument/didOpen", json!({"textDocument": document}));
        self.shown()
    }

    fn change(&mut self, uri: &str, text: &str) {
        self.version += 1;
        let document = json!({"uri": uri, "version": self.version});
        self.tell("textDocument/didChange", json!({"textDocument": document, "contentChanges": [{"text": text}]}));
    }

    fn shown(&mut self) -> Vec<Value> {
        loop {
            let message = self.receive();
            if message["params"]["version"] == json!(self.version) {
                return message["params"]["diagnostics"].as_array().unwrap().clone();
            }
        }
    }

    /// At the place of `|` in a line of the text.
    fn at(&mut self, method: &str, uri: &str, text: &str, place: &str, more: Value) -> Value {
        let mut params = json!({"textDocument": {"uri": uri}, "position": position(text, place)});
        for (key, value) in more.as_object().unwrap() {
            params[key] = value.clone();
        }
        self.ask(&format!("textDocument/{method}"), params)
    }

    /// The hover, once it has a part: what takes longer comes a moment after the mistakes.
    fn hover(&mut self, uri: &str, text: &str, place: &str, part: &str) -> String {
        let start = Instant::now();
        loop {
            let told = self.at("hover", uri, text, place, json!({}))["contents"]["value"].to_string();
            if told.contains(part) {
                return told;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "{told}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn end(mut self) {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        assert_eq!(self.server.wait().unwrap().code(), Some(0));
    }
}

/// As the protocol counts: units of UTF-16.
fn position(text: &str, place: &str) -> Value {
    let (before, after) = place.split_once('|').unwrap();
    let at = text.find(&format!("{before}{after}")).unwrap() + before.len();
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    json!({"line": text[..at].matches('\n').count(), "character": text[start..at].encode_utf16().count()})
}

/// The texts at ranges, counted independently of the server.
fn source(text: &str, range: &Value) -> String {
    let line = |side: &str| range[side]["line"].as_u64().unwrap() as usize;
    assert_eq!(line("start"), line("end"));
    let units: Vec<u16> = text.lines().nth(line("start")).unwrap().encode_utf16().collect();
    let unit = |side: &str| range[side]["character"].as_u64().unwrap() as usize;
    String::from_utf16(&units[unit("start")..unit("end")]).unwrap()
}

const URI: &str = "untitled:pendel.lag";

#[test]
fn mistakes_are_shown_where_they_are() {
    let mut editor = Editor::new();
    let text = PENDULUM.to_owned();
    assert_eq!(editor.open(URI, &text), Vec::<Value>::new());
    // Two at once; what follows from them is not shown.
    let wrong = text.replace("cos(φ)", "cos(ϕϕ)").replace("param ℓ", "parm ℓ");
    editor.change(URI, &wrong);
    let shown = editor.shown();
    let told = |at: usize| (source(&wrong, &shown[at]["range"]), shown[at]["code"].clone());
    assert_eq!(shown.len(), 2, "{shown:?}");
    assert_eq!((told(0), told(1)), (("parm".to_owned(), json!("E0002")), ("ϕϕ".to_owned(), json!("E0101"))));
    let wrong = text.replace("assume ω0", "assume omega0") + "let 𝒢 = 2 let b = ω1 + gg";
    editor.change(URI, &wrong);
    let shown = editor.shown();
    let places: Vec<String> = shown.iter().map(|own| source(&wrong, &own["range"])).collect();
    assert_eq!(places, ["omega0", "ω1", "gg"]);
    assert!(shown[0]["message"].as_str().unwrap().contains("did you mean `ω0`?"), "{}", shown[0]);
    // The fix, and the text with it.
    let range = shown[0]["range"].clone();
    let params = json!({"textDocument": {"uri": URI}, "range": range, "context": {"diagnostics": []}});
    let fixes = editor.ask("textDocument/codeAction", params);
    assert_eq!(fixes[0]["title"], json!("Write `ω0`"));
    let edit = &fixes[0]["edit"]["changes"][URI][0];
    assert_eq!((source(&wrong, &edit["range"]).as_str(), &edit["newText"]), ("omega0", &json!("ω0")));
    // One that has to be asked for, and a name for what is unused.
    let wrong = text.replace("m*g*ℓ", "m*gg*ℓ");
    for (wrong, place, new) in [(&wrong, "gg", "g"), (&(text.clone() + "param z = 1"), "z", "_z")] {
        editor.change(URI, wrong);
        let range = editor.shown()[0]["range"].clone();
        let params = json!({"textDocument": {"uri": URI}, "range": range, "context": {"diagnostics": []}});
        let fix = &editor.ask("textDocument/codeAction", params)[0];
        let edit = &fix["edit"]["changes"][URI][0];
        assert_eq!((source(wrong, &edit["range"]).as_str(), &edit["newText"]), (place, &json!(new)));
        assert_eq!(fix["isPreferred"], json!(false));
    }
    // A second place.
    let twice = PENDULUM.to_owned() + "param g = 2\n";
    editor.change(URI, &twice);
    let shown = editor.shown();
    let related = &shown[0]["relatedInformation"][0]["location"];
    assert_eq!((&related["uri"], source(&twice, &related["range"]).as_str()), (&json!(URI), "g"));
    assert_eq!(related["range"]["start"]["line"], json!(1));
    editor.end();
}

#[test]
fn what_is_no_message_has_an_answer() {
    let mut editor = Editor::new();
    for body in ["{nothing", "[1]", ""] {
        let input = editor.input.as_mut().unwrap();
        write!(input, "Content-Length: {}\r\n\r\n{body}", body.len()).unwrap();
        let answer = editor.receive();
        assert_eq!((&answer["id"], &answer["error"]["code"]), (&Value::Null, &json!(-32700)));
    }
    assert_eq!(editor.open(URI, PENDULUM), Vec::<Value>::new());
    editor.end();
    // No memory is taken for what is longer than any text.
    let mut editor = Editor::new();
    write!(editor.input.as_mut().unwrap(), "Content-Length: 99999999999\r\n\r\n{{}}").unwrap();
    drop(editor.input.take());
    assert_eq!(editor.receive()["error"]["code"], json!(-32700));
}

#[test]
fn names_lead_to_each_other() {
    let mut editor = Editor::new();
    let text = PENDULUM.to_owned() + "let a = sum(i in 1..2, i*sum(j in 1..i, j)) + sum(i in 1..3, i)\n";
    editor.open(URI, &text);
    let told = editor.hover(URI, &text, "sqrt(g/|ℓ)", "`ℓ = 0.5 m`");
    for part in ["param ℓ : m = 0.5", "a length"] {
        assert!(told.contains(part), "{told}");
    }
    let told = editor.hover(URI, &text, "assume ω|0", "1/s");
    assert!(told.contains("ω0 = 4.42945 1/s") && told.contains("a rate"), "{told}");
    let told = editor.at("hover", URI, &text, "co|s(", json!({}))["contents"]["value"].to_string();
    assert!(told.contains("cos(x)"), "{told}");
    let told = editor.at("hover", URI, &text, "coord φ : ra|d", json!({}))["contents"]["value"].to_string();
    assert!(told.contains("a pure number"), "{told}");
    for (place, part) in
        [("|T = ", "is the kinetic energy"), ("su|m(i", "sum(i in a..b, EXPR)"), ("# 𝒢 and φ be|fore", "")]
    {
        let told = editor.at("hover", URI, &text, place, json!({}));
        assert_eq!(
            told["contents"]["value"].as_str().is_some_and(|own| own.contains(part)),
            !part.is_empty(),
            "{told}"
        );
    }
    let found = editor.at("definition", URI, &text, "cos(|φ)", json!({}));
    assert_eq!(found[0]["range"]["start"], position(&text, "coord |φ"));
    let context = json!({"context": {"includeDeclaration": true}});
    let all = editor.at("references", URI, &text, "cos(|φ)", context.clone());
    let lines: Vec<&Value> = all.as_array().unwrap().iter().map(|own| &own["range"]["start"]["line"]).collect();
    assert_eq!(lines, [4, 5, 6]);
    // An index is that of its sum alone.
    let all = editor.at("references", URI, &text, "2, |i*sum", context);
    assert_eq!(all.as_array().unwrap().len(), 3);
    let edits = editor.at("rename", URI, &text, "g/|ℓ", json!({"newName": "länge"}));
    let edits = edits["changes"][URI].as_array().unwrap().clone();
    let old: Vec<String> = edits.iter().map(|own| source(&text, &own["range"])).collect();
    assert_eq!(old, ["ℓ"; 4]);
    for (place, new) in [("g/|ℓ", "φ"), ("g/|ℓ", "sin"), ("g/|ℓ", "a b"), ("g/|ℓ", "2"), ("co|s(φ", "f"), ("g/|ℓ", "j")]
    {
        let params = json!({"textDocument": {"uri": URI}, "position": position(&text, place), "newName": new});
        let refused = editor.asked("textDocument/rename", params);
        assert!(refused["error"]["message"].is_string(), "{new}: {refused}");
    }
    editor.end();
}

#[test]
fn what_can_be_written_is_offered() {
    let mut editor = Editor::new();
    let folder = format!("file://{}/tests/language", env!("CARGO_MANIFEST_DIR"));
    let uri = format!("{folder}/a%20new%20one.lag");
    let text = "table s = \"springs.csv\"\nparam k : N/m = 2\ncoord x[1..3]\nT = sum(i in 1..3, x[i]'^2)\nV = sum(b in s, 1/2*b.k*x[b.i]^2)\n";
    assert_eq!(editor.open(&uri, text).len(), 1, "k is never used");
    let labels = |found: Value| -> Vec<String> {
        found.as_array().unwrap().iter().map(|own| own["label"].as_str().unwrap().to_owned()).collect()
    };
    // While it is being written it can't be read.
    let wrong = text.replace("b.k*x[b.i]^2)", "b.") + "let y = s[1].";
    editor.change(&uri, &wrong);
    assert!(!editor.shown().is_empty());
    let header = std::fs::read_to_string("tests/language/springs.csv").unwrap();
    let columns: Vec<&str> = header.lines().next().unwrap().split(',').collect();
    assert_eq!(labels(editor.at("completion", &uri, &wrong, "1/2*b.|", json!({}))), columns);
    assert_eq!(labels(editor.at("completion", &uri, &wrong, "s[1].|", json!({}))), columns);
    let units = labels(editor.at("completion", &uri, &wrong, "k : |N", json!({})));
    assert!(["lbf", "kg", "cm", "mm", "ms", "kN"].iter().all(|own| units.contains(&(*own).to_owned())));
    assert!(!units.contains(&"sin".to_owned()));
    let names = labels(editor.at("completion", &uri, &wrong, "T = |sum", json!({})));
    assert!(["k", "x", "s", "sin", "integral", "pi"].iter().all(|own| names.contains(&(*own).to_owned())), "{names:?}");
    assert!(!names.contains(&"param".to_owned()));
    let begun = labels(editor.at("completion", &uri, &wrong, "|param", json!({})));
    assert!(begun.contains(&"constraint".to_owned()));
    let drawn = format!("{text}draw spring [0], x[1]\n");
    editor.change(&uri, &drawn);
    editor.shown();
    assert_eq!(labels(editor.at("completion", &uri, &drawn, "draw |spring", json!({}))), ["point", "line", "spring"]);
    // A column is defined in its file.
    editor.change(&uri, text);
    editor.shown();
    let found = editor.at("definition", &uri, text, "b.|k", json!({}));
    assert_eq!(found[0]["uri"], json!(format!("{folder}/springs.csv")));
    // Outside of the folder nothing is read.
    editor.change(&uri, &text.replace("springs.csv", "../../Cargo.toml"));
    assert!(editor.shown()[0]["message"].as_str().unwrap().contains("there is no such file"));
    editor.end();
}

#[test]
fn coordinates_have_their_stiffness_and_inertia_at_the_equilibrium() {
    let mut editor = Editor::new();
    // d²V/dφ² = m g l cos φ and d²T/dφ'² = m l² at φ = 0.
    editor.open(URI, PENDULUM);
    let told = editor.hover(URI, PENDULUM, "cos(|φ)", "equilibrium");
    let line = "at the equilibrium `φ = 0`: stiffness K = `m*g*ℓ = 4.905 J`, inertia M = `m*ℓ^2 = 0.25 kg*m^2`";
    assert!(told.contains(line), "{told}");
    // A soft spring that hangs: its third power leaves 3 a x² of K, where a x³ = m g. Without units there are none.
    let text = "param m = 2 param g = 10 param a = 20\ncoord x, y[1..9]\nT = 1/2*m*x'^2 + sum(i in 1..9, 3/2*y[i]'^2)\n\
        V = 1/4*a*x^4 - m*g*x + sum(i in 1..9, i*y[i]^2)\nguess x = 2\n";
    editor.change(URI, text);
    editor.shown();
    let told = editor.hover(URI, text, "coord |x", "equilibrium");
    assert!(told.contains("`x = 1`: stiffness K = `3*a*(m*g/a)^(2/3) = 60`, inertia M = `m = 2`"), "{told}");
    let told = editor.hover(URI, text, "x, |y[1", "equilibrium");
    assert!(told.contains("`y[6] = 0`: stiffness K = `12`, inertia M = `3`"), "{told}");
    assert!(!told.contains("y[7] = 0") && told.contains('…'), "{told}");
    // On a circle of radius 2 about the lowest point, K is that of the motions which are left: m g/l.
    let text = "param m = 3 param l = 2 param g = 10\ncoord x, y\nconstraint x^2 + y^2 = l^2\n\
        T = 1/2*m*(x'^2 + y'^2)\nV = m*g*y\nequilibrium x = 0 equilibrium y = -l\n";
    editor.change(URI, text);
    editor.shown();
    let told = editor.hover(URI, text, "coord |x", "equilibrium");
    assert!(told.contains("stiffness K = `m*g/l = 15`, inertia M = `m = 3`"), "{told}");
    let told = editor.hover(URI, text, "x, |y", "equilibrium");
    assert!(told.contains("at the equilibrium `y = -2`, near which it follows other coordinates"), "{told}");
    // A model that is wrong has none.
    let wrong = text.replace("m*g*y", "m*g*z");
    editor.change(URI, &wrong);
    editor.shown();
    let told = editor.at("hover", URI, &wrong, "coord |x", json!({}))["contents"]["value"].to_string();
    assert!(told.contains("coord x, y") && !told.contains("stiffness"), "{told}");
    editor.end();
}

#[test]
fn arguments_are_named_while_they_are_written() {
    let mut editor = Editor::new();
    editor.open(URI, PENDULUM);
    let cases = [
        ("let a = sin(|", Some(("sin(x)", "x"))),
        ("let a = atan2(φ, |", Some(("atan2(y, x)", "x"))),
        ("let a = atan2(|φ, 1)", Some(("atan2(y, x)", "y"))),
        // Whatever is closed, or no call, is passed over.
        ("let a = cross([1, 0, 0], [sin(φ), (0|", Some(("cross(u, v)", "v"))),
        ("let a = inertia_box(m, 1,\n  2 # (ends, here\n  , |", Some(("inertia_box(m, a, b, c)", "c"))),
        ("let a = dot (|", Some(("dot(u, v)", "u"))),
        ("let a = sum(i in 1..3, j in 1..i, |", Some(("sum(i in a..b, EXPR)", "EXPR"))),
        ("let a = norm(sin(φ)|)", Some(("norm(v)", "v"))),
        ("let a = norm(φ)|", None),
        ("let a = wrong(|", None),
        ("let a = (|", None),
        ("# sin(|", None),
        // What is open above does not reach below.
        ("let a = sin(\ncoord x|", None),
    ];
    for (written, expected) in cases {
        let text = format!("{PENDULUM}{}", written.replace('|', ""));
        editor.change(URI, &text);
        let help = editor.at("signatureHelp", URI, &text, written, json!({}));
        let found = help["signatures"][0]["label"].as_str().map(|call| {
            let active = help["activeParameter"].as_u64().unwrap() as usize;
            (call, help["signatures"][0]["parameters"][active]["label"].as_str().unwrap())
        });
        assert_eq!(found, expected, "{written}");
    }
    editor.end();
}

#[test]
fn the_text_is_laid_out_and_summed_up() {
    let mut editor = Editor::new();
    let text = PENDULUM.replace("T = 1/2", "T  =  1/2");
    editor.open(URI, &text);
    let document = json!({"textDocument": {"uri": URI}});
    let outline = editor.ask("textDocument/documentSymbol", document.clone());
    let names: Vec<&str> = outline.as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["pendel", "m", "g", "ℓ", "ω0", "φ", "T", "V", "assume"]);
    let whole = json!({"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}});
    editor.hover(URI, &text, "assume ω|0", "1/s");
    let hints = editor.ask("textDocument/inlayHint", json!({"textDocument": {"uri": URI}, "range": whole}));
    let labels: Vec<&str> = hints.as_array().unwrap().iter().map(|own| own["label"].as_str().unwrap()).collect();
    assert_eq!(labels, [": 1/s", "= 4.42945"]);
    assert_eq!(hints[0]["position"], position(&text, "param ω0|"));
    let other = "file:///other.lag";
    let metres =
        "param l : cm = 2*15, k : N/m = 1, m : kg = 1\ncoord x : m\nT = 1/2*m*x'^2\nV = 1/2*k*(x - l)^2\nguess x = l\n";
    editor.open(other, metres);
    editor.hover(other, metres, "param l|", "0.3");
    let hints = editor.ask("textDocument/inlayHint", json!({"textDocument": {"uri": other}, "range": whole}));
    assert!(hints.as_array().unwrap().iter().any(|own| own["label"] == "= 0.3 m"), "{hints}");
    let edits = editor.ask("textDocument/formatting", document.clone());
    assert_eq!(edits[0]["newText"].as_str().unwrap(), librate::syntax::format(&text).unwrap());
    let start = Instant::now();
    loop {
        let lens = editor.ask("textDocument/codeLens", document.clone());
        if let Some(title) = lens[0]["command"]["title"].as_str() {
            assert_eq!(title, "omega = 4.42945 rad/s, stable");
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(20));
    }
    // It stays while something is written that is no model yet, and goes when that stays.
    editor.change(URI, &format!("{text}let a = "));
    editor.shown();
    let mut lens = || editor.ask("textDocument/codeLens", document.clone());
    assert_eq!(lens()[0]["command"]["title"], "omega = 4.42945 rad/s, stable");
    while lens() != json!([]) {
        assert!(start.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(20));
    }
    editor.tell("textDocument/didClose", document);
    editor.end();
}

#[test]
fn values_are_those_of_the_statements_without_mistakes() {
    let mut editor = Editor::new();
    let text = "param k : N/m = 3\nparam j = 2*z\nlet w = sqrt(3*k)\nlet y = k*x\nlet u = j\nlet q=\ncoord x : m\n";
    editor.open(URI, text);
    editor.hover(URI, text, "param |k", "`k = 3 N/m`");
    editor.hover(URI, text, "let |w", "`w = 3 ");
    for place in ["|j = 2", "let |y", "let |u"] {
        let told = editor.at("hover", URI, text, place, json!({}))["contents"]["value"].to_string();
        let has_value = ["`j = ", "`y = ", "`u = "].iter().any(|own| told.contains(own));
        assert!(told.contains("```librate") && !has_value, "{told}");
    }
    editor.end();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is written and asked, there is an answer.
    #[test]
    fn any_text_is_survived(
        edits in prop::collection::vec((0_usize..400, 0_usize..40, "[ -~\n\t\r\\u{feff}φ𝒢']{0,12}", 0_u32..12, 0_u32..40), 150),
    ) {
        const METHODS: [&str; 9] = [
            "hover", "definition", "references", "completion", "documentSymbol", "formatting", "codeLens", "prepareRename",
            "signatureHelp",
        ];
        let mut editor = Editor::new();
        let mut text = PENDULUM.to_owned();
        editor.open(URI, &text);
        for (number, (start, length, new, line, character)) in edits.into_iter().enumerate() {
            let letters: Vec<char> = text.chars().collect();
            let start = start.min(letters.len());
            let end = (start + length).min(letters.len());
            text = letters[..start].iter().copied().chain(new.chars()).chain(letters[end..].iter().copied()).collect();
            if number % 25 == 24 {
                text = PENDULUM.to_owned();
            }
            editor.change(URI, &text);
            let params = json!({
                "textDocument": {"uri": URI},
                "position": {"line": line, "character": character},
            });
            editor.ask(&format!("textDocument/{}", METHODS[number % METHODS.len()]), params);
        }
        editor.change(URI, PENDULUM);
        prop_assert_eq!(editor.shown(), Vec::<Value>::new());
        editor.end();
    }
}
