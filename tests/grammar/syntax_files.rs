//! Every model file parses, and prints to what parses to the same tree.

use librate::syntax::parse;
use librate_core::syntax::print_file;

#[test]
fn files_parse_to_their_trees() {
    insta::with_settings!({ snapshot_path => "../syntax", prepend_module_to_snapshot => false }, {
        insta::glob!("../syntax", "*.lag", |path| {
            let source = std::fs::read_to_string(path).unwrap();
            let file = parse(&source).unwrap_or_else(|errors| panic!("{}: {errors:#?}", path.display()));
            let printed = print_file(&file);
            assert_eq!(print_file(&parse(&printed).unwrap()), printed);
            insta::assert_snapshot!(printed);
        });
    });
}

#[test]
fn models_parse() {
    insta::glob!("../../models", "*.lag", |path| {
        let source = std::fs::read_to_string(path).unwrap();
        let file = parse(&source).unwrap_or_else(|errors| panic!("{}: {errors:#?}", path.display()));
        let printed = print_file(&file);
        assert_eq!(print_file(&parse(&printed).unwrap()), printed);
    });
}

#[allow(missing_docs, reason = "the rules are documented in the grammar")]
mod whole {
    #[derive(pest_derive::Parser)]
    #[grammar = "grammar/librate.pest"]
    pub(super) struct Grammar;
}

/// `file` in the grammar is for readers; the parser takes statements one by one. They must agree.
#[test]
fn the_whole_file_is_the_same_language() {
    let agree = |source: &str, right: bool| {
        let read = <whole::Grammar as pest::Parser<whole::Rule>>::parse(whole::Rule::file, source);
        assert_eq!(read.is_ok(), right, "{source}");
        assert_eq!(parse(source).is_ok(), right, "{source}");
    };
    for source in [
        include_str!("../../models/three_pendulums.lag"),
        include_str!("../../models/triple_pendulum.lag"),
        include_str!("../../models/diatomic_ring.lag"),
        "param B : T = 1 T = 2 V = 3; ; coord x : V/m, y",
        "constraint [i in 1..n] x[i] = b.period period 3 # end",
        "param g = 9.81 +/- 0.01 coord T_1",
        "",
    ] {
        agree(source, true);
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
        agree(source, false);
    }
}
