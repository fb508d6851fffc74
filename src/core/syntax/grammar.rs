//! pest's parser for `grammar/librate.pest`, its table of precedences, and its rules in words.

use std::sync::LazyLock;

use pest::pratt_parser::{Assoc, Op, PrattParser};

#[allow(missing_docs, reason = "the rules are documented in the grammar")]
mod generated {
    #[derive(pest_derive::Parser)]
    #[grammar = "../../grammar/librate.pest"]
    pub(in crate::syntax) struct Grammar;
}

pub(super) use generated::{Grammar, Rule};

/// Binding strengths, weakest first.
pub(super) static PRECEDENCES: LazyLock<PrattParser<Rule>> = LazyLock::new(|| {
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
});

/// What the grammar would have accepted, in plain words, each once.
pub(super) fn in_words(rules: &[Rule]) -> Vec<&'static str> {
    let mut said = Vec::new();
    for words in rules.iter().filter_map(|rule| rule_in_words(*rule)) {
        if !said.contains(&words) {
            said.push(words);
        }
    }
    said
}

fn rule_in_words(rule: Rule) -> Option<&'static str> {
    match rule {
        Rule::drawn => Some("`point`, `line` or `spring`"),
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
        | Rule::operator
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
        Rule::EOI => Some("the next statement"),
        // What may always follow an operand is not worth saying.
        _ => None,
    }
}
