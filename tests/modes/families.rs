//! Random sums over families, nested in functions and other sums, against the same written out term by term.
#![cfg(feature = "engine")]

use librate::linearize::linearize;
use proptest::prelude::*;

use crate::common::model;

/// What the inner sum adds up: how members are declared, and what one of them is.
#[derive(Clone, Copy, Debug)]
enum Members {
    List,
    Parameters,
    Formula,
    Rows,
    Following,
}

impl Members {
    fn declared(self, numbers: &[i32]) -> String {
        let n = numbers.len();
        let backwards: Vec<i32> = numbers.iter().rev().copied().collect();
        match self {
            Self::List => format!("let p[1..{n}] = {numbers:?}"),
            Self::Parameters => format!("param p[1..{n}] = {numbers:?}"),
            Self::Formula => format!("let p[k in 1..{n}] = k + 1"),
            Self::Rows => format!("let p[1..2, 1..{n}] = [{numbers:?}, {backwards:?}]"),
            Self::Following => format!("let p[0] = 0  let p[k in 1..{n}] = p[k-1] + k*x[k]"),
        }
    }

    /// As it is read in the sum, and as it is written out for i and j.
    fn read(self) -> &'static str {
        match self {
            Self::Rows => "p[i, j]*x[j]",
            Self::Following => "i*p[j]",
            Self::List | Self::Parameters | Self::Formula => "p[j]*x[j]",
        }
    }

    fn written_out(self, numbers: &[i32], i: usize, j: usize) -> String {
        let number = match self {
            Self::List | Self::Parameters => numbers[j - 1],
            Self::Formula => j as i32 + 1,
            Self::Rows if i == 1 => numbers[j - 1],
            Self::Rows => numbers[numbers.len() - j],
            Self::Following => {
                let terms: Vec<String> = (1..=j).map(|k| format!("{k}*x[{k}]")).collect();
                return format!("{i}*({})", terms.join(" + "));
            }
        };
        format!("({number})*x[{j}]")
    }
}

/// Functions that rest at 0 where what is in them does.
const FUNCTIONS: [&str; 4] = ["(#)^2", "(1 - cos(#))", "sqrt(1 + (#)^2)", "(#)^2*exp(#)"];

fn stiffness(text: &str) -> Vec<f64> {
    linearize(model(text)).unwrap().stiffness().iter().map(|own| own.mid_f64()).collect()
}

proptest! {
    #[test]
    fn nested_sums_are_what_they_stand_for(
        members in prop_oneof![
            Just(Members::List),
            Just(Members::Parameters),
            Just(Members::Formula),
            Just(Members::Rows),
            Just(Members::Following),
        ],
        numbers in proptest::collection::vec(-4..5, 2..6),
        function in 0..FUNCTIONS.len(),
        (from_outer, to_outer, without_two, is_product) in any::<(bool, bool, bool, bool)>(),
    ) {
        let n = numbers.len();
        let (from, to) = (if from_outer { "i" } else { "1" }, if to_outer { "i".to_owned() } else { n.to_string() });
        let filter = if without_two { " where j != 2" } else { "" };
        let inner = format!("sum(j in {from}..{to}{filter}, {})", members.read());
        let body = FUNCTIONS[function].replace('#', &inner);
        let nested = match is_product {
            true => format!("sum(i in 1..2, sum(k in 1..i, 2*k/(i + 1))*sum(l in 1..2, l*{body})/sum(k in 1..2, k))"),
            false => format!("sum(i in 1..2, i*{body})"),
        };
        let outer = (1..=2).map(|i| {
            let (from, to) = (if from_outer { i } else { 1 }, if to_outer { i } else { n });
            let terms = (from..=to).filter(|j| !(without_two && *j == 2));
            let terms: Vec<String> = terms.map(|j| members.written_out(&numbers, i, j)).collect();
            let sum = if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") };
            format!("{i}*{}", FUNCTIONS[function].replace('#', &sum))
        });
        let written_out = outer.collect::<Vec<_>>().join(" + ");
        let with = |energy: &str| {
            let declared = members.declared(&numbers);
            format!(
                "coord x[1..{n}]  {declared}
                 T = sum(i in 1..{n}, 1/2*x[i]'^2)  V = {energy} + sum(i in 1..{n}, i*x[i]^2)
                 equilibrium x[i in 1..{n}] = 0"
            )
        };
        prop_assert_eq!(stiffness(&with(&nested)), stiffness(&with(&written_out)), "{}", with(&nested));
    }
}
