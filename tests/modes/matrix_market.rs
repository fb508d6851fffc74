//! Models whose matrices are Matrix Market files.

#![cfg(feature = "engine")]

use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::syntax::parse;

const MODEL: &str = r#"
table K = "K.MTX"
coord x[1..3]
T = 1/2*dot(x', x')
V = 1/2*sum(e in K, e.v*x[e.i]*x[e.j])
"#;

/// omega^2 of [`MODEL`], or what is said of the table.
fn squares(matrix: &str) -> Result<Vec<f64>, String> {
    let file = parse(MODEL).unwrap();
    let tables = TableTexts::new().with("K.MTX", matrix);
    let model = elaborate(&file, &tables, &Settings::new()).map_err(|errors| errors[0].to_string())?;
    let modes = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap();
    Ok(modes.modes.iter().map(|mode| mode.omega_squared.unwrap().mid_f64()).collect())
}

#[test]
fn every_kind_of_a_matrix_gives_its_entries() {
    // Three masses in a row, tied to walls: 2 - sqrt(2), 2, 2 + sqrt(2).
    let matrices = [
        "%%MatrixMarket matrix coordinate real symmetric\n% lower triangle\n\n3 3 5\n1 1 2.0\n2 1 -1e0\n2 2 2\n3 2 -1.\n3 3 +2\n",
        "%%matrixmarket MATRIX coordinate integer general\r\n3 3 7\r\n1 1 2\r\n1 2 -1\r\n2 1 -1\r\n2 2 2\r\n2 3 -1\r\n3 2 -1\r\n3 3 2\r\n",
        "%%MatrixMarket matrix array real symmetric\n3 3\n2\n-1\n0\n2\n-1\n2\n",
        "%%MatrixMarket matrix array real general\n3 3\n2 -1 0\n-1 2 -1\n0 -1 2\n",
    ];
    for matrix in matrices {
        let found = squares(matrix).unwrap();
        for (own, exact) in found.iter().zip([2.0 - 2.0_f64.sqrt(), 2.0, 2.0 + 2.0_f64.sqrt()]) {
            assert!((own - exact).abs() < 1e-14, "{matrix}: {found:?}");
        }
    }
    let ones = squares("%%MatrixMarket matrix coordinate pattern symmetric\n3 3 3\n1 1\n2 2\n3 3\n").unwrap();
    assert_eq!(ones, [1.0, 1.0, 1.0]);
    // x·Ax of a skew matrix is 0 whatever x is.
    let skew = squares("%%MatrixMarket matrix array integer skew-symmetric\n3 3\n1 2\n3\n").unwrap();
    assert_eq!(skew, [0.0, 0.0, 0.0]);
}

#[test]
fn what_is_wrong_with_a_matrix_is_named_with_its_line() {
    let header = "%%MatrixMarket matrix coordinate real general\n";
    for (text, line, wanted) in [
        (String::new(), 1, "the first line of a Matrix Market file"),
        ("i,j,v\n1,1,2\n".to_owned(), 1, "the first line of a Matrix Market file"),
        (header.replace("real", "complex"), 1, "`complex`"),
        (header.replace("coordinate", "dense"), 1, "neither coordinate nor array"),
        (header.replace("general", "triangular"), 1, "`triangular`"),
        (header.to_owned(), 1, "is missing"),
        (format!("{header}3 3\n"), 2, "rows, columns and entries"),
        (format!("{header}3 3 -1\n"), 2, "rows, columns and entries"),
        (format!("{header}0 99999999999999999 0\n"), 2, "no entries"),
        (format!("{}3 4 0\n", header.replace("general", "symmetric")), 2, "has not 4 columns"),
        (format!("{}2 2 3\n1 1 2\n2 1 -1\n1 2 -1\n", header.replace("general", "symmetric")), 5, "in the other"),
        (format!("{header}3 3 1\n1 4 2\n"), 3, "`4` is not in 1..3"),
        (format!("{header}3 3 1\n1 1.5 2\n"), 3, "`1.5` is not in 1..3"),
        (format!("{header}3 3 1\n1 1 two\n"), 3, "`two` is no number"),
        (format!("{header}3 3 1\n1 1 .\n"), 3, "`.` is no number"),
        (format!("{header}3 3 1\n1 1\n"), 3, "row, column and value"),
        (format!("{header}3 3 2\n% one\n1 1 2\n"), 4, "1 entries where 2 are announced"),
        (format!("{header}3 3 18446744073709551615\n1 1 2\n"), 3, "1 entries where"),
        ("%%MatrixMarket matrix array real general\n3 3\n1 2 3\n".to_owned(), 3, "fewer numbers"),
        ("%%MatrixMarket matrix array real general\n1 1\n1\n2\n".to_owned(), 4, "more numbers"),
    ] {
        let said = squares(&text).unwrap_err();
        assert!(said.starts_with(&format!("error in line {line} of the table")), "{text}: {said}");
        assert!(said.contains(wanted), "{text}: {said}");
    }
}
