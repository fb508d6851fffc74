//! What to write for characters that look like something the language has.

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
    let Some(first) = run.chars().next() else {
        return Lookalike::Unknown;
    };
    match run {
        "<>" => return Lookalike::Write("!=".to_owned()),
        "=<" => return Lookalike::Write("<=".to_owned()),
        "=>" => return Lookalike::Write(">=".to_owned()),
        "||" => return Lookalike::Write("or".to_owned()),
        _ => {}
    }
    let scripts: String = run.chars().filter_map(plain_script).collect();
    if !scripts.is_empty() {
        return match first {
            '₀'..='₉' => {
                Lookalike::Say("write an index in brackets, `x[1]`, or in the name, `x1`")
            }
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
        '½' => "1/2",
        '⅓' => "1/3",
        '¼' => "1/4",
        '¾' => "3/4",
        '（' => "(",
        '）' => ")",
        '，' => ",",
        '：' => ":",
        '；' => ";",
        _ => return said(first),
    };
    Lookalike::Write(plain.to_owned())
}

fn said(character: char) -> Lookalike {
    Lookalike::Say(match character {
        '{' | '}' => "group with parentheses: `(…)`; vectors and indices have square brackets",
        '|' => "write `abs(x)` or `norm(v)`; in a condition `or`",
        '%' => "write `mod(a, b)`; a comment begins with `#`",
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
    Some(match c {
        '⁰' | '₀' => '0',
        '¹' | '₁' => '1',
        '²' | '₂' => '2',
        '³' | '₃' => '3',
        '⁴' | '₄' => '4',
        '⁵' | '₅' => '5',
        '⁶' | '₆' => '6',
        '⁷' | '₇' => '7',
        '⁸' | '₈' => '8',
        '⁹' | '₉' => '9',
        '⁻' => '-',
        _ => return None,
    })
}
