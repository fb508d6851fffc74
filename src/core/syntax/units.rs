//! The units by name, their prefixes, and how people write them otherwise.
//!
//! Tables, and looking up in them: what a unit is worth is the business of the model.
#![cfg_attr(not(feature = "engine"), allow(dead_code, reason = "the values are the model's"))]

use crate::order::Gather;

/// A unit: its SI factor as a decimal literal, of an angle by which part of pi, and whether it takes prefixes.
pub(crate) struct Known {
    pub(crate) name: &'static str,
    pub(crate) factor: &'static str,
    /// The factor is to be multiplied by pi over this.
    pub(crate) pi_over: Option<i64>,
    pub(crate) prefixes: bool,
    /// The exponents of kg, m, s, A, K, mol, cd.
    pub(crate) exponents: [i8; 7],
}

const fn unit(name: &'static str, factor: &'static str, prefixes: bool, exponents: [i8; 7]) -> Known {
    Known { name, factor, pi_over: None, prefixes, exponents }
}

/// A unit with an angle: pi over a number, times a whole one.
const fn angle(name: &'static str, factor: &'static str, pi_over: i64, exponents: [i8; 7]) -> Known {
    Known { name, factor, pi_over: Some(pi_over), prefixes: false, exponents }
}

/// SI base and derived units (the SI Brochure, 9th edition), those accepted beside them, atomic
/// ones with CODATA 2022 values, and those of engineers: the thermochemical calorie, the international inch and pound,
/// and the pound-force with the standard gravity 9.80665 m/s^2.
pub(crate) const UNITS: &[Known] = &[
    unit("m", "1", true, [0, 1, 0, 0, 0, 0, 0]),
    unit("g", "1e-3", true, [1, 0, 0, 0, 0, 0, 0]),
    unit("s", "1", true, [0, 0, 1, 0, 0, 0, 0]),
    unit("A", "1", true, [0, 0, 0, 1, 0, 0, 0]),
    unit("K", "1", true, [0, 0, 0, 0, 1, 0, 0]),
    unit("mol", "1", true, [0, 0, 0, 0, 0, 1, 0]),
    unit("cd", "1", true, [0, 0, 0, 0, 0, 0, 1]),
    unit("rad", "1", true, [0, 0, 0, 0, 0, 0, 0]),
    unit("sr", "1", true, [0, 0, 0, 0, 0, 0, 0]),
    unit("Hz", "1", true, [0, 0, -1, 0, 0, 0, 0]),
    unit("N", "1", true, [1, 1, -2, 0, 0, 0, 0]),
    unit("Pa", "1", true, [1, -1, -2, 0, 0, 0, 0]),
    unit("J", "1", true, [1, 2, -2, 0, 0, 0, 0]),
    unit("W", "1", true, [1, 2, -3, 0, 0, 0, 0]),
    unit("C", "1", true, [0, 0, 1, 1, 0, 0, 0]),
    unit("V", "1", true, [1, 2, -3, -1, 0, 0, 0]),
    unit("F", "1", true, [-1, -2, 4, 2, 0, 0, 0]),
    unit("ohm", "1", true, [1, 2, -3, -2, 0, 0, 0]),
    unit("Ω", "1", true, [1, 2, -3, -2, 0, 0, 0]),
    unit("S", "1", true, [-1, -2, 3, 2, 0, 0, 0]),
    unit("Wb", "1", true, [1, 2, -2, -1, 0, 0, 0]),
    unit("T", "1", true, [1, 0, -2, -1, 0, 0, 0]),
    unit("H", "1", true, [1, 2, -2, -2, 0, 0, 0]),
    unit("lm", "1", true, [0, 0, 0, 0, 0, 0, 1]),
    unit("lx", "1", true, [0, -2, 0, 0, 0, 0, 1]),
    unit("Bq", "1", true, [0, 0, -1, 0, 0, 0, 0]),
    unit("Gy", "1", true, [0, 2, -2, 0, 0, 0, 0]),
    unit("Sv", "1", true, [0, 2, -2, 0, 0, 0, 0]),
    unit("kat", "1", true, [0, 0, -1, 0, 0, 1, 0]),
    unit("L", "1e-3", true, [0, 3, 0, 0, 0, 0, 0]),
    unit("l", "1e-3", true, [0, 3, 0, 0, 0, 0, 0]),
    unit("min", "60", false, [0, 0, 1, 0, 0, 0, 0]),
    unit("h", "3600", false, [0, 0, 1, 0, 0, 0, 0]),
    unit("d", "86400", false, [0, 0, 1, 0, 0, 0, 0]),
    unit("angstrom", "1e-10", false, [0, 1, 0, 0, 0, 0, 0]),
    unit("t", "1e3", false, [1, 0, 0, 0, 0, 0, 0]),
    unit("u", "1.66053906892e-27", false, [1, 0, 0, 0, 0, 0, 0]),
    unit("eV", "1.602176634e-19", true, [1, 2, -2, 0, 0, 0, 0]),
    unit("cal", "4.184", true, [1, 2, -2, 0, 0, 0, 0]),
    unit("bar", "1e5", true, [1, -1, -2, 0, 0, 0, 0]),
    unit("atm", "101325", false, [1, -1, -2, 0, 0, 0, 0]),
    unit("in", "0.0254", false, [0, 1, 0, 0, 0, 0, 0]),
    unit("ft", "0.3048", false, [0, 1, 0, 0, 0, 0, 0]),
    unit("lb", "0.45359237", false, [1, 0, 0, 0, 0, 0, 0]),
    unit("lbf", "4.4482216152605", false, [1, 1, -2, 0, 0, 0, 0]),
    angle("deg", "1", 180, [0; 7]),
    angle("rev", "2", 1, [0; 7]),
    angle("rpm", "1", 30, [0, 0, -1, 0, 0, 0, 0]),
];

/// The prefixes of the powers of 1000 from the tenth down; the power 0 has none.
const BY_THOUSANDS: &str = "QRYZEPTGMk munpfazyrq";

/// The others, each with its power of ten.
const PREFIXES: [(&str, i32); 6] = [("da", 1), ("h", 2), ("d", -1), ("c", -2), ("µ", -6), ("μ", -6)];

/// The unit that a name means, and the power of ten of its prefix.
pub(crate) fn look_up(name: &str) -> Option<(&'static Known, i32)> {
    if let Some(known) = UNITS.iter().find(|known| known.name == name) {
        return Some((known, 0));
    }
    let by_thousands = BY_THOUSANDS.split_inclusive(|_| true).zip((-10..=10).rev().map(|power| 3 * power));
    PREFIXES.into_iter().chain(by_thousands).find_map(|(prefix, exponent)| {
        let rest = name.strip_prefix(prefix)?;
        let known = UNITS.iter().find(|known| known.name == rest && known.prefixes)?;
        Some((known, exponent))
    })
}

/// By what a number in a unit is multiplied in SI: `*pi/180` for `deg`, nothing for `N` and `kg`.
pub(crate) fn in_si(name: &str) -> Option<String> {
    let (known, power) = look_up(name)?;
    let (digits, own) = known.factor.split_once('e').unwrap_or((known.factor, "0"));
    let number = match (digits, power + own.parse::<i32>().ok()?) {
        ("1", 0) => String::new(),
        ("1", power) => format!("*1e{power}"),
        (digits, 0) => format!("*{digits}"),
        (digits, power) => format!("*{digits}e{power}"),
    };
    Some(match known.pi_over {
        None => number,
        Some(1) => format!("{number}*pi"),
        Some(over) => format!("{number}*pi/{over}"),
    })
}

/// `kg` for `Kg` and `KG`, `Hz` for `hz`: of the units that are often written so the only one.
pub(crate) fn of_other_case(name: &str) -> Option<&'static str> {
    let plain = UNITS.iter().map(|known| known.name).chain(["kg", "cm", "km"]);
    plain.filter(|own| own.eq_ignore_ascii_case(name)).only()
}

/// `s2`, as many programs write it, in the language: `s^2`.
pub(crate) fn power(name: &str) -> Option<String> {
    let base = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let exponent = name.get(base.len()..).filter(|digits| !digits.is_empty())?;
    look_up(base).map(|_| format!("{base}^{exponent}"))
}

/// The units that are written together with another one behind them: many words can be split into some units.
const BEFORE_OTHERS: [&str; 14] = ["N", "mN", "kN", "MN", "kg", "J", "Pa", "W", "kW", "MW", "A", "mA", "V", "C"];

/// `Nm` in the language: `N*m`; what ends in s may be a plural.
pub(crate) fn product(name: &str) -> Option<String> {
    BEFORE_OTHERS.into_iter().find_map(|left| {
        let right = name.strip_prefix(left).filter(|own| matches!(*own, "m" | "mm" | "cm" | "km" | "h" | "s" | "A"))?;
        Some(format!("{left}*{right}"))
    })
}

/// The unit by the name that a text or another program has for it, if it has one reading.
pub(crate) fn elsewhere(name: &str) -> Option<&'static str> {
    Some(match name.to_lowercase().as_str() {
        "meter" | "meters" | "metre" | "metres" | "mtr" => "m",
        "second" | "seconds" | "sec" | "secs" => "s",
        "gram" | "grams" | "gramm" | "gr" | "gm" | "gms" => "g",
        "kilogram" | "kilograms" | "kgs" => "kg",
        "radian" | "radians" | "rads" => "rad",
        "degree" | "degrees" | "degs" | "°" => "deg",
        "newton" | "newtons" => "N",
        "joule" | "joules" => "J",
        "watt" | "watts" => "W",
        "pascal" | "pascals" => "Pa",
        "hertz" => "Hz",
        "kelvin" | "kelvins" => "K",
        "volt" | "volts" => "V",
        "ampere" | "amperes" | "amp" | "amps" => "A",
        "coulomb" | "coulombs" => "C",
        "liter" | "liters" | "litre" | "litres" => "L",
        "revolution" | "revolutions" | "turn" | "turns" => "rev",
        "inch" | "inches" => "in",
        "foot" | "feet" => "ft",
        "calorie" | "calories" => "cal",
        "minute" | "minutes" | "mins" => "min",
        "hour" | "hours" | "hr" | "hrs" => "h",
        "day" | "days" => "d",
        "ton" | "tons" | "tonne" | "tonnes" => "t",
        "amu" | "dalton" | "da" => "u",
        "ang" | "å" => "angstrom",
        _ => return None,
    })
}

/// Whether a word is a unit or is meant as one: `kg`, and `Kg`, `s2`, `Nm`; one letter in another case may be anything.
pub(super) fn is_like_unit(word: &str) -> bool {
    let other_case = || word.len() > 1 && of_other_case(word).is_some();
    look_up(word).is_some() || other_case() || power(word).is_some() || product(word).is_some()
}
