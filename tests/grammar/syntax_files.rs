//! Every model file parses, and prints to what parses to the same tree.

use librate::syntax::{parse, print_file};

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
