//! What to write for characters that look like something the language has.

use super::words::function_meant;

/// The advice for an illegal character.
pub(super) enum Lookalike {
    /// Write this instead.
    Write(String),
    /// More than a replacement.
    Say(&'static str),
    /// Nothing known.
    Unknown,
}

/// The advice for a run of illegal characters.
pub(super) fn advice(run: &str) -> Lookalike {
    let Some(first) = run.chars().next() else { return Lookalike::Unknown };
    if let Some(command) = run.strip_prefix('\\')
        && command.starts_with(|c: char| c.is_ascii_alphabetic())
    {
        return typeset(command);
    }
    match run {
        ".*" => return Lookalike::Say("write `*`; members of families are multiplied one by one: `a[i]*b[i]`"),
        "./" => return Lookalike::Say("write `/`; members of families are divided one by one: `a[i]/b[i]`"),
        ".^" => return Lookalike::Say("write `^`; members of families are raised one by one: `a[i]^2`"),
        "<>" => return Lookalike::Write("!=".to_owned()),
        "=<" => return Lookalike::Write("<=".to_owned()),
        "=>" => return Lookalike::Write(">=".to_owned()),
        "\\," | "\\;" | "\\:" | "\\!" => {
            return Lookalike::Say("leave it out: blanks mean nothing; a product is written `a*b`");
        }
        "&=" => return Lookalike::Say("leave the `&` out: it sets equations below each other in TeX"),
        "||" => return Lookalike::Write("or".to_owned()),
        _ => {}
    }
    let scripts: String = run.chars().filter_map(plain_script).collect();
    if !scripts.is_empty() {
        return match first {
            '₀'..='₉' => Lookalike::Say("write an index in brackets, `x[1]`, or in the name, `x1`"),
            _ => Lookalike::Write(format!("^{scripts}")),
        };
    }
    let plain = match first {
        // The dashes and the minus signs of the other tables.
        '−' | '‐' | '‑' | '‒' | '–' | '—' | '―' | '﹣' | '－' => "-",
        '×' | '·' | '⋅' | '∙' | '•' | '∗' | '＊' => "*",
        '÷' | '∕' | '⁄' | '／' => "/",
        '＋' => "+",
        '＝' => "=",
        '′' | '‘' | '’' | '`' | '´' | '＇' | '‛' => "'",
        '″' => "''",
        '“' | '”' | '„' | '‟' | '«' | '»' | '＂' => "\"",
        '…' | '‥' => "..",
        '≤' | '⩽' | '≦' => "<=",
        '≥' | '⩾' | '≧' => ">=",
        '≠' => "!=",
        '∧' | '&' => "and",
        '∨' => "or",
        '¬' => "not",
        '∈' => "in",
        '½' => "(1/2)",
        '⅓' => "(1/3)",
        '¼' => "(1/4)",
        '¾' => "(3/4)",
        '（' => "(",
        '）' => ")",
        '，' => ",",
        '：' => ":",
        '；' => ";",
        _ => return said(first),
    };
    Lookalike::Write(plain.to_owned())
}

/// The letter that Unicode holds a Greek or Latin one for, which then is never seen in a text in its normal form (NFC).
pub(super) fn composed(letter: char) -> Option<char> {
    Some(match letter {
        '\u{2126}' => 'Ω',
        '\u{212a}' => 'K',
        '\u{212b}' => 'Å',
        '\u{1f71}' => 'ά',
        '\u{1f73}' => 'έ',
        '\u{1f75}' => 'ή',
        '\u{1f77}' => 'ί',
        '\u{1f79}' => 'ό',
        '\u{1f7b}' => 'ύ',
        '\u{1f7d}' => 'ώ',
        '\u{1fbb}' => 'Ά',
        '\u{1fbe}' => 'ι',
        '\u{1fc9}' => 'Έ',
        '\u{1fcb}' => 'Ή',
        '\u{1fd3}' => 'ΐ',
        '\u{1fdb}' => 'Ί',
        '\u{1fe3}' => 'ΰ',
        '\u{1feb}' => 'Ύ',
        '\u{1ff9}' => 'Ό',
        '\u{1ffb}' => 'Ώ',
        _ => return None,
    })
}

/// The Latin letter that a Cyrillic or Greek one looks like.
#[cfg_attr(not(feature = "engine"), allow(dead_code, reason = "the model's names are compared"))]
pub(crate) fn latin(letter: char) -> Option<char> {
    let alike =
        "аеорсухіјѕһАВЕКМНОРСТУХІЈЅονΑΒΕΖΗΙΚΜΝΟΡΤΥΧ".chars().zip("aeopcyxijshABEKMHOPCTYXIJSovABEZHIKMNOPTYX".chars());
    alike.into_iter().find(|(own, _)| *own == letter).map(|(_, latin)| latin)
}

/// What to write for a command of TeX, given without its backslash.
fn typeset(command: &str) -> Lookalike {
    let (word, group) = match command.split_once('{') {
        Some((word, group)) => (word, Some(untypeset(group.strip_suffix('}').unwrap_or("{")))),
        None => (command, None),
    };
    let function = || function_meant(word);
    // Of TeX's own commands none has a digit in its name.
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let is_short = matches!(stem, "frac" | "tfrac" | "dfrac" | "sqrt");
    let digits: Vec<char> = word.chars().skip(stem.len()).filter(|_| is_short).collect();
    let word = if is_short { stem } else { word };
    let plain = match (word, group.as_deref()) {
        (word, _) if word == "sum" || word.starts_with("sum_") => return Lookalike::Say("write `sum(i in 1..n, …)`"),
        (word, _) if word == "int" || word.starts_with("int_") => {
            return Lookalike::Say("write `integral(x in a..b, …)`");
        }
        (word, Some(index)) if word.ends_with('_') && index != "…" => {
            return Lookalike::Write(format!("{word}{index}"));
        }
        ("dot", Some(name)) => return Lookalike::Write(format!("{}'", in_parentheses(name))),
        ("ddot", Some(name)) => return Lookalike::Write(format!("{}''", in_parentheses(name))),
        ("dot" | "ddot", None) | ("prime", _) => {
            return Lookalike::Say("write the time derivative after the name: `x'`");
        }
        ("vec" | "hat" | "bar" | "tilde" | "mathbf" | "boldsymbol" | "bm", _) => {
            return Lookalike::Say("names have no accents and no type: write `r`, or `r_hat` where both occur");
        }
        // `\frac12`, `\sqrt2`
        ("frac" | "tfrac" | "dfrac", _) => match *digits {
            [above, below] => return Lookalike::Write(format!("({above}/{below})")),
            _ => return Lookalike::Say("write a fraction as `a/b`"),
        },
        ("sqrt", None) => match *digits {
            [only] => return Lookalike::Write(format!("sqrt({only})")),
            _ => return Lookalike::Say("write `sqrt(x)`, and other roots as powers: `x^(1/3)`"),
        },
        ("max" | "min", _) => {
            return Lookalike::Say(
                "write the larger of two as `(a + b + abs(a - b))/2`, the smaller with `- abs(a - b)`",
            );
        }
        ("lvert" | "rvert" | "vert" | "lVert" | "rVert" | "Vert", _) => return said('|'),
        ("left" | "right" | "quad" | "qquad", _) => return Lookalike::Say("leave it out"),
        (word, None) if matches!(word.to_lowercase().trim_end_matches(['l', 'r', 'm']), "big" | "bigg") => {
            return Lookalike::Say("leave it out");
        }
        ("cdot" | "times", _) => "*",
        ("div", _) => "/",
        ("pm", _) => "+/-",
        ("leq" | "le", _) => "<=",
        ("geq" | "ge", _) => ">=",
        ("neq" | "ne", _) => "!=",
        ("in", _) => "in",
        // Greek letters and functions.
        (word, None) => function().unwrap_or(word),
        ("mathrm" | "mathit" | "mathsf" | "text" | "textrm" | "mbox" | "operatorname", Some(name)) if name != "…" => {
            name
        }
        (_, Some(inside)) => match function() {
            Some(function) => return Lookalike::Write(format!("{function}({inside})")),
            None => return Lookalike::Unknown,
        },
    };
    Lookalike::Write(plain.to_owned())
}

/// What stands in the braces of a command, with words for the commands in it, or `…`.
fn untypeset(group: &str) -> String {
    let mut parts = group.trim().split('\\');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (word, rest) = part.split_at(part.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(part.len()));
        let plain = if word.is_empty() || function_meant(word).is_some() { Lookalike::Unknown } else { typeset(word) };
        let Lookalike::Write(plain) = plain else { return "…".to_owned() };
        let is_factor = out.ends_with(char::is_alphanumeric) && plain.starts_with(char::is_alphabetic);
        out.extend([if is_factor { "*" } else { "" }, &plain, rest]);
    }
    if out.contains(['{', '}']) { "…".to_owned() } else { out }
}

/// As the operand of a prime: a name, or parentheses.
fn in_parentheses(operand: &str) -> String {
    if operand.chars().all(|c| c.is_alphanumeric() || c == '_') { operand.to_owned() } else { format!("({operand})") }
}

fn said(character: char) -> Lookalike {
    Lookalike::Say(match character {
        '{' | '}' => "group with parentheses: `(…)`; vectors and indices have square brackets",
        '|' => "write `abs(x)` or `norm(v)`; in a condition `or`",
        '%' => "10% is `0.1`, as an uncertainty `± 0.1*VALUE`; a remainder is `mod(a, b)`; a comment begins with `#`",
        '\\' => "line breaks mean nothing: just go on in the next line",
        '!' => "write `not`, or `!=` for unequal",
        '°' => "degrees are a unit: `param a : deg = 30`",
        '√' => "write `sqrt(x)`",
        '∑' => "write `sum(i in 1..n, …)`",
        '∞' => "there is no infinity",
        '∂' => "derivatives are taken for you; `x'` is the one by time",
        '\u{307}' | '\u{308}' => "write the derivative by time as `x'`",
        '\u{a0}' | '\u{2000}'..='\u{200b}' | '\u{202f}' | '\u{205f}' | '\u{3000}' | '\u{feff}' => {
            "this is a special blank: write an ordinary one"
        }
        '\u{300}'..='\u{36f}' => "accents have to be part of their letter (precomposed)",
        _ => return Lookalike::Unknown,
    })
}

fn plain_script(c: char) -> Option<char> {
    let plain = ["⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "₀₁₂₃₄₅₆₇₈₉"].map(|scripts| scripts.chars().zip("0123456789-".chars()));
    plain.into_iter().flatten().find(|(script, _)| *script == c).map(|(_, plain)| plain)
}
