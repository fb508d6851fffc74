//! Symmetry and closed forms on a page.

use std::collections::HashSet;

use super::exponents::sum_text;
use super::page::{Form, Line, Matrix, Part, Words, ticked, with};
use librate_core::derive::{
    Abbreviation, Approximation, Block, Case, Derivation, Exchange, Frequencies, Frequency, Linear, NormalCoordinates,
    NormalWaves, Solved, WaveNumber,
};
use librate_core::expr::ExprId;
use librate_core::symmetry::{GroupKind, SignedPermutation};

/// Exchanges and equalities of more coordinates than this are broken off.
const MOST_NAMED: usize = 8;
/// Frequencies that a formula gives by their number are not listed beyond this.
const MOST_LISTED: usize = 24;
/// So many are listed where each is shorter than the formula.
const MOST_SINGLE: usize = 4;
/// Blocks of more coordinates than this are not written out.
const MOST_IN_BLOCK: usize = 4;

/// The sets of equal parameters: `l[1] = l[3], k12 = k23`.
fn ties(sets: &[Vec<String>]) -> Vec<Words> {
    ticked(sets.iter().map(|set| set.join(" = ")))
}

/// Where a signed permutation takes the coordinates: `x <-> y`, `x -> -x`, `x -> y -> z -> x`.
pub(super) fn exchange(g: &SignedPermutation, names: &[String]) -> String {
    let name = |i: usize| names.get(i).map_or("", String::as_str);
    let sign = |negative: bool| if negative { "-" } else { "" };
    let mut seen = vec![false; g.len()];
    let mut cycles = Vec::new();
    for start in 0..g.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let (to, negative) = g.of(start);
        if to == start {
            cycles.extend(negative.then(|| format!("{0} -> -{0}", name(start))));
            continue;
        }
        let (back, again) = g.of(to);
        if back == start && negative == again {
            seen[to] = true;
            cycles.push(format!("{} <-> {}{}", name(start), sign(negative), name(to)));
            continue;
        }
        let mut text = name(start).to_owned();
        let (mut at, mut minus, mut length) = (to, negative, 1);
        while !seen[at] {
            seen[at] = true;
            if length < MOST_NAMED {
                text.push_str(&format!(" -> {}{}", sign(minus), name(at)));
            } else if length == MOST_NAMED {
                text.push_str(" -> …");
            }
            let (next, turned) = g.of(at);
            (at, minus) = (next, minus != turned);
            length += 1;
        }
        cycles.push(format!("{text} -> {}{}", sign(minus), name(at)));
    }
    shortened(cycles)
}

fn shortened(mut items: Vec<String>) -> String {
    if items.len() > MOST_NAMED {
        items.truncate(MOST_NAMED);
        items.push("…".to_owned());
    }
    items.join(", ")
}

/// The name of a kind of group.
pub(super) fn kind(kind: &GroupKind) -> String {
    match kind {
        GroupKind::Mirrors(mirrors) if mirrors.len() == 1 => "mirror".to_owned(),
        GroupKind::Mirrors(_) => "mirrors".to_owned(),
        GroupKind::Ring { length, .. } => format!("ring of {length}"),
        GroupKind::Other => "group".to_owned(),
    }
}

/// How the coordinates move in a class: `phi[1] = -phi[3], phi[2] = 0`.
fn motion(block: &Block, names: &[String]) -> String {
    let name = |i: usize| names.get(i).map_or("", String::as_str);
    let moved: HashSet<usize> = block.basis.iter().flatten().map(|(i, _)| *i).collect();
    let mut parts = Vec::new();
    for vector in &block.basis {
        if let [(first, sign), others @ ..] = vector.as_slice()
            && !others.is_empty()
        {
            let minus = |other: i64| if (other < 0) == (*sign < 0) { "" } else { "-" };
            let others: String = others.iter().map(|(i, own)| format!(" = {}{}", minus(*own), name(*i))).collect();
            parts.push(format!("{}{others}", name(*first)));
        }
    }
    let resting: Vec<&str> = (0..names.len()).filter(|i| !moved.contains(i)).map(name).collect();
    if !resting.is_empty() {
        parts.push(if resting.len() > MOST_NAMED {
            "all others 0".to_owned()
        } else {
            format!("{} = 0", resting.join(" = "))
        });
    }
    shortened(parts)
}

/// `x <-> y`, one line for each generator.
fn exchanges(found: &Exchange, names: &[Words]) -> Vec<Line> {
    found.generators.iter().take(MOST_NAMED).map(|g| Line::Words(exchange(g, names))).collect()
}

/// How coordinates move in a class, and the matrices of its block.
fn block_lines(derivation: &Derivation, block: &Block, names: &[Words]) -> Vec<Line> {
    let mut lines = vec![Line::Words(format!("{}: {}", block.class, motion(block, names)))];
    if block.mass.len() > MOST_IN_BLOCK {
        return lines;
    }
    let both = [("M", &block.mass), ("K", &block.stiffness)];
    lines.extend(both.map(|(letter, rows)| Line::Below(Matrix::new("", letter.to_owned(), rows, derivation))));
    lines
}

/// How many times there is a frequency, if more than once, and its class.
fn remark(frequency: &Frequency) -> String {
    let times = match frequency.multiplicity {
        1 => None,
        2 => Some("twice".to_owned()),
        n => Some(format!("{n} times")),
    };
    let at_values = || Some(format!("{} at these values", frequency.symmetry_at_values.as_ref()?));
    let class = frequency.symmetry.clone().or_else(at_values);
    let remarks: Vec<String> = times.into_iter().chain(class).collect();
    if remarks.is_empty() { String::new() } else { format!("  ({})", remarks.join(", ")) }
}

/// `a > 0`, one for each sign that is taken from the values.
pub(super) fn signs(derivation: &Derivation, signs: &[(ExprId, bool)]) -> Vec<String> {
    let signs = signs.iter();
    signs
        .map(|(e, negative)| {
            let relation = if *negative { "<" } else { ">" };
            let text = derivation.pool.display(*e);
            // alpha < pi, not alpha - pi < 0.
            match text.split_once(" - ") {
                Some((a, b)) if !text.contains(['+', '(']) && !b.contains(" - ") => {
                    format!("{a} {relation} {b}")
                }
                _ => format!("{text} {relation} 0"),
            }
        })
        .collect()
}

/// `, for k -> 0` and `, to order 2 in k`.
pub(super) fn approximations(done: &[Approximation]) -> Words {
    let texts = done.iter().map(|done| match done {
        Approximation::Limit { name, value } => {
            format!(", for `{name}` -> `{}`", value.pool().display(value.value()))
        }
        Approximation::Expansion { name, order } => format!(", to order {order} in `{name}`"),
    });
    texts.collect()
}

/// Symmetry, blocks, closed forms and normal coordinates of a case.
fn case_parts(derivation: &Derivation, frequencies: &Frequencies, case: &Case, parts: &mut Vec<Part>) {
    let names = &ticked(&derivation.names.displacements);
    if let Some(found) = &case.symmetry {
        let ties = ties(&found.ties);
        let because = if ties.is_empty() { String::new() } else { format!(", as {}", ties.join(", ")) };
        let title = format!("symmetry: {}{because}", kind(&found.kind));
        parts.push(Part::Section(title, exchanges(found, names), Form::Close));
    }
    let tied = ties(&case.ties);
    if !case.blocks.is_empty() {
        let title = format!("blocks of `M` and `K`, one for each class{}", with(&tied));
        let lines = case.blocks.iter().flat_map(|block| block_lines(derivation, block, names));
        parts.push(Part::Section(title, lines.collect(), Form::Close));
    }
    if case.frequencies.is_empty() {
        if !frequencies.approximations.is_empty() {
            let title = format!("no closed form was found{}", approximations(&frequencies.approximations));
            parts.push(Part::Section(title, Vec::new(), Form::Close));
        }
        return;
    }
    let assumed: Vec<Words> = tied.into_iter().chain(ticked(signs(derivation, &frequencies.signs))).collect();
    let rest = if case.complete { "" } else { " with a closed form" };
    let title = format!("normal frequencies{rest}{}{}", with(&assumed), approximations(&frequencies.approximations));
    let mut lines = Vec::new();
    let is_listed = is_listed(derivation, case, frequencies.point_group.is_some());
    for series in case.series.iter().filter(|_| !is_listed) {
        let value = derivation.pool.display(series.omega_squared);
        let ranges = series.numbers.iter();
        let ranges = ranges.map(|(name, angles)| format!("`{name}` = {}..{}", angles.first, angles.last));
        let remark = format!(", {}", ranges.collect::<Vec<_>>().join(", "));
        lines.push(Line::Formula(format!("{}^2 = {value}", derivation.names.omega), remark));
    }
    if is_listed {
        lines.extend(alone(case).map(|frequency| {
            let value = derivation.pool.display(frequency.omega_squared);
            Line::Formula(format!("{}^2 = {value}", derivation.names.omega), remark(frequency))
        }));
    }
    lines.extend(case.solved.iter().flat_map(|solved| solved_lines(derivation, case, solved)));
    parts.push(Part::Section(title, lines, Form::Close));
    let lines = match &case.normal {
        Some(normal) => normal_lines(derivation, normal),
        None => waves_lines(derivation, &case.waves),
    };
    if !lines.is_empty() {
        let title = format!("normal coordinates{}", with(&assumed));
        parts.push(Part::Section(title, lines, Form::Apart));
    }
}

/// Whether frequencies are written down one by one: without a formula that gives them by their number, beside one that does not give
/// all, and in place of one that is longer than each of a few; of a molecule more of them, with their classes.
fn is_listed(derivation: &Derivation, case: &Case, is_molecule: bool) -> bool {
    let length = |e: ExprId| derivation.pool.display(e).len();
    let most = if is_molecule { MOST_LISTED } else { MOST_SINGLE };
    let is_few = case.frequencies.len() <= most && (is_molecule || case.waves.is_empty()) && {
        let longest = case.frequencies.iter().map(|own| length(own.omega_squared)).max();
        let mut longer = case.series.iter().map(|own| Some(length(own.omega_squared)) > longest);
        if is_molecule { longer.any(|own| own) } else { longer.all(|own| own) }
    };
    case.series.is_empty() || !case.complete && case.frequencies.len() <= MOST_LISTED || case.complete && is_few
}

/// The closed forms that are not written down with names of their own.
fn alone(case: &Case) -> impl Iterator<Item = &Frequency> {
    let has_names =
        |frequency: &&Frequency| case.solved.iter().any(|solved| solved.frequencies.contains(&frequency.omega_squared));
    case.frequencies.iter().filter(move |frequency| !has_names(frequency))
}

/// Relations in the model language with remarks behind them: the zeros of a cubic or quartic, and what is abbreviated there.
fn solved_lines(derivation: &Derivation, case: &Case, solved: &Solved) -> Vec<Line> {
    let pool = &derivation.pool;
    let own = case.frequencies.iter().filter(|own| solved.frequencies.contains(&own.omega_squared));
    let mut all: Vec<String> = own.map(remark).collect();
    all.dedup();
    // What is remarked about all of them.
    let own = if let [own] = all.as_slice() { own.as_str() } else { "" };
    let formulas = solved.formulas.iter().map(|formula| {
        let numbers = formula.numbers.iter().map(|(letter, numbers)| {
            let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
            format!(", `{letter}` = {}", numbers.join(", "))
        });
        let remark: String = numbers.chain([own.to_owned()]).collect();
        let sum = sum_text(formula.terms.iter().map(|term| pool.display(*term)));
        Line::Formula(format!("{}^2 = {sum}", derivation.names.omega), remark)
    });
    formulas.chain(abbreviation_lines(derivation, &solved.abbreviations)).collect()
}

/// The equations that are solved on request, in words.
fn on_request(frequencies: &Frequencies) -> Option<&'static str> {
    match frequencies.best().on_request? {
        3 => Some("the frequencies of blocks of three are zeros of cubics: --cubic prints them"),
        4 => Some("the frequencies of blocks of four are zeros of quartics: --quartic prints them"),
        _ => None,
    }
}

/// Relations in the model language with remarks behind them: `x = ...`, one a coordinate, the abbreviations in them,
/// and `L = ...`.
fn normal_lines(derivation: &Derivation, normal: &NormalCoordinates) -> Vec<Line> {
    let names = &derivation.names;
    let coordinates = names.displacements.iter().zip(&normal.coordinates);
    let mut lines: Vec<Line> =
        coordinates.map(|(name, sum)| Line::plain(format!("{name} = {}", derivation.displaced_text(sum)))).collect();
    lines.extend(abbreviation_lines(derivation, &normal.abbreviations));
    let lagrangian = derivation.displaced_text(&normal.lagrangian);
    let name = &derivation.names.energies[0];
    lines.push(Line::plain(format!("{name} = {lagrangian}")));
    lines
}

/// The displacements of chains, rings and nets as sums over their normal coordinates, and L in them.
fn waves_lines(derivation: &Derivation, all: &[NormalWaves]) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut lagrangian = Vec::new();
    for waves in all {
        let normal = &waves.normal;
        lines.extend(displacement_lines(derivation, waves));
        // All sums together run over what the frequencies run over.
        let mut numbers: Vec<WaveNumber> = Vec::new();
        for sum in &waves.sums {
            for (at, number) in sum.numbers.iter().enumerate() {
                match numbers.get_mut(at) {
                    Some(own) => {
                        (own.first, own.last) = (own.first.min(number.first), own.last.max(number.last));
                    }
                    None => numbers.push(number.clone()),
                }
            }
        }
        let (own, omega) = (letters(&numbers), &waves.omega);
        lagrangian
            .push(format!("1/2*sum({}, {normal}[{own}]'^2 - {omega}[{own}]^2*{normal}[{own}]^2)", ranges(&numbers)));
    }
    if !lines.is_empty() {
        let name = &derivation.names.energies[0];
        lines.push(Line::plain(format!("{name} = {}", lagrangian.join(" + "))));
    }
    lines
}

/// `m, n`
fn letters(numbers: &[WaveNumber]) -> String {
    let names: Vec<&str> = numbers.iter().map(|own| own.name.as_str()).collect();
    names.join(", ")
}

/// `j in 1..100`
fn ranges(numbers: &[WaveNumber]) -> String {
    let range = |own: &WaveNumber| format!("{} in {}..{}", own.name, own.first, own.last);
    numbers.iter().map(range).collect::<Vec<_>>().join(", ")
}

/// `x[n] = ...`, and what is meant by a name that the model has not.
fn displacement_lines(derivation: &Derivation, waves: &NormalWaves) -> Vec<Line> {
    let pool = &derivation.pool;
    let parts: Vec<String> = waves
        .sums
        .iter()
        .map(|sum| {
            let [factor, square, shape] = [sum.factor, sum.factor_squared, sum.shape].map(|e| pool.display(e));
            let root = format!("sqrt({square})");
            // sqrt(2/(101*m)), not sqrt(202)/(101*sqrt(m)); but 1/(2*sqrt(3*m)).
            let mut factors = vec![if root.len() + 4 < factor.len() { root } else { factor }];
            match sum.numbers.as_slice() {
                [WaveNumber { first, last, .. }] if first == last => {
                    factors.extend([shape, format!("{}[{first}]", waves.normal)]);
                }
                numbers => {
                    let own = letters(numbers);
                    let body = format!("{shape}*{}[{own}]", waves.normal);
                    factors.push(format!("sum({}, {body})", ranges(numbers)));
                }
            }
            factors.retain(|factor| factor != "1");
            factors.join("*")
        })
        .collect();
    let names = &derivation.names.displacements;
    let along: Vec<&str> = waves.order.iter().filter_map(|i| names.get(*i).map(String::as_str)).collect();
    let family = family(&along, &waves.places);
    let own = unused(derivation, &["q", "u", "y", "xi"]);
    let left = family.clone().unwrap_or_else(|| {
        let letters: Vec<&str> = waves.places.iter().map(|(name, _)| name.as_str()).collect();
        format!("{own}[{}]", letters.join(", "))
    });
    let places: String = waves.places.iter().map(|(name, last)| format!(", `{name}` = 1..{last}")).collect();
    let mut lines = vec![Line::Formula(format!("{left} = {}", parts.join(" + ")), places)];
    lines.extend(family.is_none().then(|| Line::plain(format!("{own} = [{}]", along.join(", ")))));
    lines
}

/// The first of some names that the model does not have.
pub(super) fn unused(derivation: &Derivation, names: &[&str]) -> String {
    first_free(names, |name| derivation.own_names().any(|own| own == name))
}

/// The first of some names that is not taken, or of the first of them with a number.
pub(super) fn first_free(names: &[&str], is_taken: impl Fn(&str) -> bool) -> String {
    let numbered = (0..).map(|number| format!("{}_{number}", names.first().unwrap_or(&"")));
    let mut all = names.iter().map(ToString::to_string).chain(numbered);
    all.find(|name| !is_taken(name)).unwrap_or_default()
}

/// `x[n]`, where the coordinates along a chain are x[1], x[2], …; `x[n + 2]` where they begin with x[3]; of a net `z[m, n]`.
fn family(along: &[&str], places: &[(String, i64)]) -> Option<String> {
    let split = |name: &str| -> Option<(String, Vec<i64>)> {
        let (base, rest) = name.split_once('[')?;
        let indices = rest.strip_suffix(']')?.split(',').map(|index| index.trim().parse().ok());
        Some((base.to_owned(), indices.collect::<Option<_>>()?))
    };
    let (base, start) = split(along.first()?)?;
    if start.len() != places.len() {
        return None;
    }
    for (at, name) in along.iter().enumerate() {
        let mut rest = i64::try_from(at).ok()?;
        let mut want = start.clone();
        for (index, (_, size)) in want.iter_mut().zip(places).rev() {
            *index += rest % size;
            rest /= size;
        }
        if split(name)? != (base.clone(), want) {
            return None;
        }
    }
    let letters = places.iter().zip(&start).map(|((letter, _), first)| match first - 1 {
        0 => letter.clone(),
        more if more > 0 => format!("{letter} + {more}"),
        less => format!("{letter} - {}", -less),
    });
    Some(format!("{base}[{}]", letters.collect::<Vec<_>>().join(", ")))
}

/// What names stand for, and for which modes.
fn abbreviation_lines(derivation: &Derivation, abbreviations: &[Abbreviation]) -> impl Iterator<Item = Line> {
    abbreviations.iter().map(|abbreviation| {
        let names = abbreviation.names.join(" = ");
        let value = derivation.pool.display(abbreviation.value);
        let remark = abbreviation.modes.as_ref().map_or_else(String::new, |(letter, modes)| {
            let modes: Vec<String> = modes.iter().map(|r| (r + 1).to_string()).collect();
            format!(", `{letter}` = {}", modes.join(", "))
        });
        Line::Formula(format!("{names} = {value}"), remark)
    })
}

/// Symmetry, blocks and closed forms; what holds in general first, then with parameters that are equal.
pub(super) fn frequency_parts(derivation: &Derivation, linear: &Linear, parts: &mut Vec<Part>) {
    let Some(frequencies) = &linear.frequencies else { return };
    if let Some(group) = &frequencies.point_group {
        let title = if frequencies.group_of_values { "point group at these values" } else { "point group" };
        parts.push(Part::List(title.to_owned(), vec![group.clone()]));
    }
    for case in [&frequencies.general].into_iter().chain(&frequencies.tied) {
        case_parts(derivation, frequencies, case, parts);
    }
    parts.extend(on_request(frequencies).map(|words| Part::Paragraph(words.to_owned())));
    if let Some(found) = &frequencies.would_be {
        let title = format!("it would have a symmetry if {}", ties(&found.ties).join(", "));
        parts.push(Part::Section(title, exchanges(found, &ticked(&derivation.names.displacements)), Form::Close));
    }
}
