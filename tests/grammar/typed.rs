//! A text that is changed in one place is read as any other, however much of its last tree is copied.

use crate::syntax_random::alphabet;

use librate_core::syntax::*;
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// Sums of terms of all forms, and statements with indices, units and filters around them.
const SUMS: &str = "model sums  param k : N/m = 2 ± 0.1, a, b = 1  param c[1..3] : kg*m^2 = [1, 2, 3]  # of three
table rows_ = \"k.csv\"
coord x[1..3] : m, y
let u[i in 1..3 where i != 2] : m = x[i] - y  assume k > 0, a < b
T = (1/2*x[1]'^2) + 1/2*x[2]'^2 # the second
  + 1/2*x[3]'^2 - (a - b)*y'^2 + sum(i in 1..3, c[i]*x[i]'^2) + (y'^2) - y'^2/2
  + y' + 2
V = k*x[1]^2 + k*(x[1] - x[2])^2 - k/2*(x[2] - x[3])^2 + -a*y + (b*y^2) + sum(r in rows_, r.k*x[r.i]^2) - integral(s in 0..y, s^2)
  + cos(x[1] - x[2]) - (x[1] + x[2] - x[3]) + (u[1]*u[3]) + dot(x, x) + a + b - y
dissipation = x[1]' + y'^2 + x[2]'^2 - x[3]'^2
constraint [i in 1..2] x[i] = y + x[3] + a - b  force y = a + b - y'  guess x[1] = 1 + a + b
equilibrium y = 0 + a - a  period 2 + a + b draw line [i in 1..3] [x[i], 0], [y, 0]
";

/// What is typed: a word at a place, after so many letters have been removed there.
fn keys() -> impl Strategy<Value = Vec<(Index, &'static str, usize)>> {
    let more = select(vec!["#", "\n", " + ", "-", " + a", "1", "", "y", "0", ")", "/", "e", ";"]);
    proptest::collection::vec((any::<Index>(), prop_oneof![alphabet(), more], 0..4_usize), 1..12)
}

fn check(source: &str, keys: &[(Index, &str, usize)]) {
    let mut text = source.to_owned();
    let (mut last, mut tree) = (text.clone(), parse(&text).unwrap());
    for (at, word, removed) in keys {
        let letters: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
        let at = at.index(letters.len());
        let end = letters[(at + removed).min(letters.len() - 1)];
        text.replace_range(letters[at]..end, word);
        let (file, errors) = parse_changed(&tree, &last, &text);
        let (new, mistakes) = parse_readable(&text);
        assert_eq!(errors, mistakes, "{text}\n\nafter\n{last}");
        assert!(file == new, "{text}\n\nafter\n{last}");
        if errors.is_empty() {
            (last, tree) = (text.clone(), file);
        } else if removed % 2 == 0 {
            // A mistake is mended, or there will be others beside it.
            text.clone_from(&last);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_texts_are_read_as_new_ones(keys in keys()) {
        check(SUMS, &keys);
    }
}
