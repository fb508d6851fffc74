//! Compiles the parser that tree-sitter made of `grammar.js`.
#![allow(clippy::print_stdout, reason = "so cargo is told")]

fn main() {
    println!("cargo::rerun-if-changed=src");
    cc::Build::new().std("c11").include("src").file("src/parser.c").compile("tree-sitter-librate");
}
