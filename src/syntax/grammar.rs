//! pest's parser for `grammar/librate.pest`, its table of precedences, and its rules in words.

use pest::pratt_parser::{Assoc, Op, PrattParser};

#[allow(missing_docs, reason = "the rules are documented in the grammar")]
mod generated {
    #[derive(pest_derive::Parser)]
    #[grammar = "grammar/librate.pest"]
    pub(in crate::syntax) struct Grammar;
}

pub(super) use generated::{Grammar, Rule};

/// Binding strengths, weakest first.
pub(super) fn precedences() -> PrattParser<Rule> {
    let left = |rule| Op::infix(rule, Assoc::Left);
    PrattParser::new()
        .op(left(Rule::or))
        .op(left(Rule::and))
        .op(Op::prefix(Rule::not))
        .op(left(Rule::equal)
            | left(Rule::not_equal)
            | left(Rule::less)
            | left(Rule::less_equal)
            | left(Rule::greater)
            | left(Rule::greater_equal))
        .op(left(Rule::add) | left(Rule::subtract))
        .op(left(Rule::multiply) | left(Rule::divide))
        .op(Op::prefix(Rule::negate))
        .op(Op::infix(Rule::power, Assoc::Right))
        .op(Op::postfix(Rule::prime)
            | Op::postfix(Rule::subscript)
            | Op::postfix(Rule::field)
            | Op::postfix(Rule::arguments))
}

/// What the grammar would have accepted, in plain words, each once.
pub(super) fn in_words(rules: &[Rule]) -> Vec<&'static str> {
    let mut said = Vec::new();
    for rule in rules {
        if let Some(words) = rule_in_words(*rule)
            && !said.contains(&words)
        {
            said.push(words);
        }
    }
    said
}

fn rule_in_words(rule: Rule) -> Option<&'static str> {
    match rule {
        Rule::name | Rule::declaration => Some("a name"),
        Rule::column => Some("a column's name"),
        Rule::number
        | Rule::expr
        | Rule::condition
        | Rule::operand
        | Rule::primary
        | Rule::paren
        | Rule::vector
        | Rule::sum_over
        | Rule::negate
        | Rule::not => Some("an expression"),
        Rule::text => Some("text in quotes"),
        Rule::infix
        | Rule::add
        | Rule::subtract
        | Rule::multiply
        | Rule::divide
        | Rule::power
        | Rule::equal
        | Rule::not_equal
        | Rule::less
        | Rule::less_equal
        | Rule::greater
        | Rule::greater_equal
        | Rule::and
        | Rule::or => Some("an operator"),
        Rule::equals => Some("`=`"),
        Rule::uncertainty => Some("`±`"),
        Rule::indices => Some("indices in brackets"),
        Rule::index | Rule::rows | Rule::range | Rule::unnamed | Rule::sum_indices => Some("an index"),
        Rule::in_word => Some("`in`"),
        Rule::where_word | Rule::filter => Some("`where`"),
        Rule::unit_part | Rule::unit | Rule::unit_factor | Rule::unit_one | Rule::unit_name => Some("a unit"),
        Rule::exponent | Rule::integer | Rule::natural => Some("an exponent"),
        Rule::EOI
        | Rule::file
        | Rule::single
        | Rule::alone
        | Rule::statement
        | Rule::model
        | Rule::param
        | Rule::coord
        | Rule::let_named
        | Rule::kinetic
        | Rule::potential
        | Rule::lagrangian
        | Rule::dissipation
        | Rule::constraint
        | Rule::guess
        | Rule::equilibrium
        | Rule::period
        | Rule::table
        | Rule::model_word
        | Rule::param_word
        | Rule::coord_word
        | Rule::let_word
        | Rule::kinetic_word
        | Rule::potential_word
        | Rule::lagrangian_word
        | Rule::dissipation_word
        | Rule::constraint_word
        | Rule::guess_word
        | Rule::equilibrium_word
        | Rule::period_word
        | Rule::table_word => Some("the next statement"),
        // What may always follow an operand is not worth saying.
        Rule::postfix
        | Rule::prime
        | Rule::subscript
        | Rule::field
        | Rule::arguments
        | Rule::rate
        | Rule::sum_word
        | Rule::letter
        | Rule::word_rest
        | Rule::keyword
        | Rule::WHITESPACE
        | Rule::COMMENT => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Grammar, Rule};
    use pest::Parser;

    /// `file` is for readers; the parser takes statements one by one. They must agree.
    #[test]
    fn the_whole_file_is_the_same_language() {
        for source in [
            include_str!("../../models/three_pendulums.lag"),
            include_str!("../../models/triple_pendulum.lag"),
            include_str!("../../models/diatomic_ring.lag"),
            "param B : T = 1 T = 2 V = 3; ; coord x : V/m, y",
            "constraint [i in 1..n] x[i] = b.period period 3 # end",
            "param g = 9.81 +/- 0.01 coord T_1",
            "",
        ] {
            assert!(Grammar::parse(Rule::file, source).is_ok(), "{source}");
            assert!(crate::syntax::parse(source).is_ok(), "{source}");
        }
        for source in [
            "x = 1",
            "param T = 1",
            "V = 2 x",
            "V = 1. T = 2",
            "V = a**b",
            "V = 2'",
            "V = +1",
            "V = a < not b",
            "param a : m m",
            "let a = 1 ± 2",
        ] {
            assert!(Grammar::parse(Rule::file, source).is_err(), "{source}");
            assert!(crate::syntax::parse(source).is_err(), "{source}");
        }
    }
}
