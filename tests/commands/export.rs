//! Matrices in files: read back with readers of the test's own, and by SciPy and PETSc where these are installed.
#![cfg(feature = "cli")]

use crate::cli_support;

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cli_support::*;
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::precision::Ball;
use librate::report::read_vectors;

/// A model with all five matrices, none of which is diagonal.
const ALL: &str = "
model all_five
param W = 3/10  param c = 1/7
coord x, y, z
T = 1/2*(x'^2 + 2*y'^2 + 3*z'^2) + 1/3*x'*z' + W*(x*y' - y*x') + W*z*y'
V = 1/2*(5*x^2 + 6*y^2 + 7*z^2) + 1/3*x*y + 1/7*y*z
dissipation = 1/2*c*(x' - y')^2 + 1/2*(z' + W*x)^2
";

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("export").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn linearized(text: &str) -> Linearized {
    let file = librate::syntax::parse(text).unwrap();
    linearize(elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap()).unwrap()
}

/// What the files should hold: column by column, as the entries are.
fn expected(model: &Linearized) -> HashMap<&'static str, Vec<f64>> {
    let doubles = |entries: Vec<Ball>| -> Vec<f64> { entries.iter().map(Ball::mid_f64).collect() };
    let mut all = HashMap::from([("M", doubles(model.mass())), ("K", doubles(model.stiffness()))]);
    for (name, entries) in [("G", model.gyroscopic()), ("C", model.damping()), ("N", model.circulatory())] {
        if let Some(entries) = entries.filter(|own| own.iter().any(|entry| !entry.is_zero())) {
            all.insert(name, doubles(entries));
        }
    }
    all
}

/// A square matrix, column by column.
#[derive(Debug, PartialEq)]
struct Dense {
    n: usize,
    entries: Vec<f64>,
}

impl Dense {
    fn new(n: usize) -> Self {
        Self { n, entries: vec![0.0; n * n] }
    }

    fn put(&mut self, i: usize, j: usize, value: f64) {
        let entry = &mut self.entries[i + self.n * j];
        assert_eq!(*entry, 0.0, "twice");
        *entry = value;
    }
}

/// Reads a file of Matrix Market; also the word for its symmetry.
fn matrix_market(file: &Path) -> (Dense, String) {
    let text = fs::read_to_string(file).unwrap();
    let symmetry = text.lines().next().unwrap().strip_prefix("%%MatrixMarket matrix coordinate real ").unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('%'));
    let sizes: Vec<usize> = lines.next().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    let mut matrix = Dense::new(sizes[0]);
    assert_eq!(sizes[0], sizes[1]);
    let mut count = 0;
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        let (i, j): (usize, usize) = (words[0].parse().unwrap(), words[1].parse().unwrap());
        let value: f64 = words[2].parse().unwrap();
        matrix.put(i - 1, j - 1, value);
        if i != j && symmetry != "general" {
            assert!(i > j);
            matrix.put(j - 1, i - 1, if symmetry == "symmetric" { value } else { -value });
        }
        count += 1;
    }
    assert_eq!(count, sizes[2]);
    (matrix, symmetry.to_owned())
}

/// Rows of entries from their lengths.
fn by_rows(n: usize, ends: &[usize], columns: &[usize], values: &[f64]) -> Dense {
    let mut matrix = Dense::new(n);
    for i in 0..n {
        let own = ends[i]..ends[i + 1];
        assert!(columns[own.clone()].is_sorted());
        for at in own {
            matrix.put(i, columns[at], values[at]);
        }
    }
    assert_eq!((ends[0], ends[n]), (0, values.len()));
    assert_eq!(columns.len(), values.len());
    matrix
}

fn petsc(file: &Path) -> Dense {
    let bytes = fs::read(file).unwrap();
    let (head, rest) = bytes.split_at(16);
    let words = |bytes: &[u8]| -> Vec<usize> {
        bytes.chunks(4).map(|own| i32::from_be_bytes(own.try_into().unwrap()).try_into().unwrap()).collect()
    };
    let head = words(head);
    let (n, count) = (head[1], head[3]);
    assert_eq!((head[0], head[2]), (1_211_216, n));
    let (lengths, rest) = rest.split_at(4 * n);
    let (columns, values) = rest.split_at(4 * count);
    let mut ends = vec![0];
    for length in words(lengths) {
        ends.push(ends[ends.len() - 1] + length);
    }
    let values: Vec<f64> = values.chunks(8).map(|own| f64::from_be_bytes(own.try_into().unwrap())).collect();
    by_rows(n, &ends, &words(columns), &values)
}

fn little(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte))
}

/// The files of an uncompressed archive, from its list of contents at the end.
fn unzip(bytes: &[u8]) -> HashMap<String, Vec<u8>> {
    let end = bytes.windows(4).rposition(|own| own == b"PK\x05\x06").unwrap();
    let mut at = little(&bytes[end + 16..end + 20]);
    let mut files = HashMap::new();
    for _ in 0..little(&bytes[end + 10..end + 12]) {
        let own = &bytes[at..];
        assert_eq!((&own[..4], little(&own[10..12])), (b"PK\x01\x02".as_slice(), 0));
        let [size, name, extra, comment, place] =
            [20..24, 28..30, 30..32, 32..34, 42..46].map(|range| little(&own[range]));
        let local = &bytes[place..];
        let begin = 30 + little(&local[26..28]) + little(&local[28..30]);
        let key = String::from_utf8(own[46..46 + name].to_vec()).unwrap();
        files.insert(key, local[begin..begin + size].to_vec());
        at += 46 + name + extra + comment;
    }
    files
}

/// An array of NumPy's: what its header says, and the bytes of its numbers.
fn npy(file: &[u8]) -> (String, &[u8]) {
    assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
    let length = little(&file[8..10]);
    assert_eq!((10 + length) % 64, 0);
    let header = std::str::from_utf8(&file[10..10 + length]).unwrap();
    assert!(header.ends_with('\n'));
    (header.trim_end().to_owned(), &file[10 + length..])
}

fn npz(file: &Path) -> HashMap<String, Dense> {
    let files = unzip(&fs::read(file).unwrap());
    let array = |name: String, kind: &str, width: usize| -> Vec<Vec<u8>> {
        let (header, data) = npy(&files[&name]);
        let count = data.len() / width;
        assert_eq!(header, format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({count},), }}"));
        data.chunks(width).map(<[u8]>::to_vec).collect()
    };
    let mut matrices = HashMap::new();
    for name in files.keys().filter_map(|name| name.strip_suffix("_data.npy")) {
        let whole = |part: &str, kind: &str, width: usize| -> Vec<usize> {
            array(format!("{name}_{part}.npy"), kind, width).iter().map(|own| little(own)).collect()
        };
        let shape = whole("shape", "<i8", 8);
        assert_eq!(shape[0], shape[1]);
        let values = array(format!("{name}_data.npy"), "<f8", 8);
        let values: Vec<f64> = values.into_iter().map(|own| f64::from_le_bytes(own.try_into().unwrap())).collect();
        let matrix = by_rows(shape[0], &whole("indptr", "<i4", 4), &whole("indices", "<i4", 4), &values);
        matrices.insert(name.to_owned(), matrix);
    }
    assert_eq!(files.len(), 4 * matrices.len());
    matrices
}

/// All formats hold the numbers of the library, bit for bit.
fn assert_exported(name: &str, text: &str) -> PathBuf {
    let folder = folder(name);
    let model = folder.join("model.lag");
    fs::write(&model, text).unwrap();
    let own = linearized(text);
    let n = own.dimension();
    let expected = expected(&own);
    for (flag, output) in [("--matrix-market", "mtx"), ("--petsc", "petsc"), ("--npz", "all.npz")] {
        let output = folder.join(output);
        let out = printed(&["export", model.to_str().unwrap(), flag, "-o", output.to_str().unwrap()]);
        assert_eq!(out.lines().count(), expected.len(), "{out}");
    }
    let archive = npz(&folder.join("all.npz"));
    assert_eq!(archive.len(), expected.len());
    for name in ["M", "K", "G", "C", "N"] {
        let files = [folder.join("mtx").join(format!("{name}.mtx")), folder.join("petsc").join(name)];
        let Some(entries) = expected.get(name) else {
            assert!(files.iter().all(|file| !file.exists()), "{name}");
            continue;
        };
        let matrix = Dense { n, entries: entries.clone() };
        let (read, symmetry) = matrix_market(&files[0]);
        assert_eq!(read, matrix, "{name}");
        let word = match name {
            "G" => "skew-symmetric",
            "N" => "general",
            _ => "symmetric",
        };
        assert_eq!(symmetry, word);
        assert_eq!(petsc(&files[1]), matrix, "{name}");
        assert_eq!(archive[name], matrix, "{name}");
    }
    folder
}

#[test]
fn files_hold_the_matrices_of_the_library() {
    assert_exported("all_five", ALL);
    for model in
        ["three_pendulums", "penning_trap", "cyclotron", "double_pendulum", "four_bar_linkage", "pendulum_in_x_and_y"]
    {
        assert_exported(model, &fs::read_to_string(format!("models/{model}.lag")).unwrap());
    }
}

#[test]
fn entries_are_in_si_and_in_the_range_of_doubles() {
    let folder = folder("units");
    let of = |text: &str| {
        fs::write(folder.join("m.lag"), text).unwrap();
        let output = folder.join("mtx");
        run(&["export", folder.join("m.lag").to_str().unwrap(), "--matrix-market", "-o", output.to_str().unwrap()])
    };
    // Worked out in units of its own.
    let fine = of("coord x, y  T = 1e-290*(x'^2 + y'^2)/2  V = 1e-280*(x^2 + x*y + y^2)/2");
    assert_eq!((fine.status, fine.err.as_str()), (0, ""));
    assert_eq!(matrix_market(&folder.join("mtx/M.mtx")).0.entries, [1e-290, 0.0, 0.0, 1e-290]);
    assert_eq!(matrix_market(&folder.join("mtx/K.mtx")).0.entries, [1e-280, 5e-281, 5e-281, 1e-280]);
    let far = of("coord x  T = 1e-320*x'^2/2  V = 1e-300*x^2/2");
    assert_eq!((far.status, far.out.as_str()), (1, ""));
    assert!(far.err.contains("the entry of M in row 1 and column 1 is beyond the range of doubles"), "{}", far.err);
    let far = of("coord x  T = 1e200*x'^2/2  V = 1e310*x^2/2");
    assert!(far.err.contains("the entry of K in row 1 and column 1"), "{}", far.err);
}

#[test]
fn rows_are_named_under_constraints() {
    let folder = assert_exported("constraints", &fs::read_to_string("models/pendulum_in_x_and_y.lag").unwrap());
    let text = fs::read_to_string(folder.join("mtx/M.mtx")).unwrap();
    let comments: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("% ")).collect();
    assert_eq!(
        comments,
        [
            "M q'' + (G + C) q' + (K + N) q = 0 of pendulum_in_x_and_y, in SI where the model has units",
            "rows and columns are the coordinates that the others follow under the constraints:",
            "1 x"
        ]
    );
}

#[test]
fn what_is_not_written_is_told() {
    let folder = folder("refused");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let chain = "models/chain_walls.lag";
    for wrong in [
        &["export", chain, "--npz"][..],
        &["export", chain, "-o", &path("a.npz")],
        &["export", chain, "--npz", "--petsc", "-o", &path("a")],
    ] {
        assert_eq!(run(wrong).status, 2);
    }
    let driven = run(&["export", "models/mathieu.lag", "--npz", "-o", &path("a.npz")]);
    assert!(driven.status == 1 && driven.err.contains("E0309"), "{}", driven.err);
    assert!(!folder.join("a.npz").exists());
    // Matrices of another model would be taken for this one's.
    let trap = ["export", "models/penning_trap.lag", "--matrix-market", "-o", &path("mtx")];
    printed(&trap);
    let stale = run(&["export", chain, "--matrix-market", "-o", &path("mtx")]);
    assert_eq!((stale.status, stale.out.as_str()), (1, ""));
    assert!(stale.err.contains("G.mtx` is of another model: this one has no G"), "{}", stale.err);
    assert_eq!(matrix_market(&folder.join("mtx/M.mtx")).0.n, 3);
    printed(&trap);
    // Nothing is written over what is read.
    fs::copy(folder.join("mtx/K.mtx"), folder.join("K.mtx")).unwrap();
    let text = "table k = \"K.mtx\"  coord x[1..3]  T = dot(x', x')/2  V = sum(r in k, 1/2*k[r].v*x[k[r].i]*x[k[r].j])";
    fs::write(folder.join("own.lag"), text).unwrap();
    let own = run(&["export", &path("own.lag"), "--matrix-market", "-o", &path("")]);
    assert!(own.status == 1 && own.err.contains("K.mtx"), "{}", own.err);
    // A file where a folder should be, and the other way round.
    for (flag, output) in [("--petsc", "own.lag"), ("--npz", "mtx")] {
        let run = run(&["export", chain, flag, "-o", &path(output)]);
        assert!(run.status == 1 && run.err.contains("can't"), "{}", run.err);
    }
}

/// A program in the environment that docs/slepc.md sets up.
fn with_slepc(program: &str) -> Command {
    let recipe = fs::read_to_string("docs/slepc.md").unwrap();
    let mut command = Command::new(program);
    command.envs(recipe.lines().filter_map(|line| line.strip_prefix("    export ")?.split_once('=')));
    command
}

/// A Python that has the modules, where there is one.
#[allow(clippy::print_stderr, reason = "says what is skipped")]
fn python(modules: &str) -> Option<&'static str> {
    let found = ["python3", "/usr/bin/python3"].into_iter().find(|python| {
        let run = with_slepc(python).args(["-c", &format!("import {modules}")]).output();
        run.is_ok_and(|run| run.status.success())
    });
    if found.is_none() {
        eprintln!("skipped: no Python with {modules} is installed");
    }
    found
}

fn run_python(python: &str, script: &str, folder: &Path) -> String {
    let run = with_slepc(python).args(["-c", script]).current_dir(folder).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn scipy_reads_the_same() {
    let Some(python) = python("numpy, scipy") else { return };
    let folder = assert_exported("scipy", ALL);
    let script = "
import numpy, scipy.io, scipy.sparse
file = numpy.load('all.npz')
for name in 'MKGCN':
    data, indices, indptr, shape = (file[f'{name}_{part}'] for part in ('data', 'indices', 'indptr', 'shape'))
    matrix = scipy.sparse.csr_matrix((data, indices, indptr), shape=shape)
    matrix.check_format()
    assert (matrix != scipy.io.mmread(f'mtx/{name}.mtx').tocsr()).nnz == 0
    print(name, *(value.hex() for value in matrix.toarray().ravel(order='F')))
";
    let read = run_python(python, script, &folder);
    let own = expected(&linearized(ALL));
    for line in read.lines() {
        let mut words = line.split(' ');
        let entries = &own[words.next().unwrap()];
        for (word, entry) in words.zip(entries) {
            let (mantissa, exponent) = word.split_once('p').unwrap();
            let digits: String = mantissa.chars().filter(|c| c.is_ascii_hexdigit()).collect();
            let digits = u64::from_str_radix(digits.strip_prefix('0').unwrap(), 16).unwrap();
            let places = mantissa.split_once('.').unwrap().1.len() as i32;
            let value = digits as f64 * 2_f64.powi(exponent.parse::<i32>().unwrap() - 4 * places);
            assert_eq!(value, entry.abs(), "{line}");
        }
    }
    assert_eq!(read.lines().count(), 5);
}

#[test]
fn petsc_reads_the_same() {
    let Some(python) = python("numpy, petsc4py.PETSc") else { return };
    let folder = assert_exported("petsc4py", ALL);
    let script = "
import numpy
from petsc4py import PETSc
file = numpy.load('all.npz')
for name in 'MKGCN':
    matrix = PETSc.Mat().load(PETSc.Viewer().createBinary(f'petsc/{name}', 'r'))
    indptr, indices, data = matrix.getValuesCSR()
    for part, own in ('indptr', indptr), ('indices', indices), ('data', data):
        assert (file[f'{name}_{part}'] == own).all()
print('the same')
";
    assert_eq!(run_python(python, script, &folder), "the same\n");
}

/// What docs/slepc.md tells to do.
#[test]
fn slepc_solves_what_is_exported_on_two_processes() {
    let Some(python) = python("numpy, slepc4py.SLEPc") else { return };
    if Command::new("mpiexec").arg("--version").output().is_err() {
        eprintln!("skipped: no mpiexec is installed");
        return;
    }
    let folder = folder("slepc");
    let recipe = fs::read_to_string("docs/slepc.md").unwrap();
    let script = recipe.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    fs::write(folder.join("slepc_modes.py"), script).unwrap();
    let line = |start: &str| -> Vec<String> {
        let line = recipe.lines().find_map(|line| line.strip_prefix(start)).unwrap_or_else(|| panic!("{start}"));
        line.split(' ').map(str::to_owned).collect()
    };
    let mut export = command(&["export"]);
    let output = folder.join("chain");
    let arguments = line("    librate export ");
    export.args(arguments.iter().map(|word| if word == "chain" { output.to_str().unwrap() } else { word.as_str() }));
    assert_eq!(finish(export, b"").status, 0);
    let mut solve = with_slepc("mpiexec");
    solve.args(["--allow-run-as-root", "--oversubscribe"]);
    let words = line("    mpiexec ");
    solve.args(words.iter().map(|word| if word == "/usr/bin/python3" { python } else { word.as_str() }));
    let solved = solve.current_dir(&folder).output().unwrap();
    let (out, errors) = (String::from_utf8(solved.stdout).unwrap(), String::from_utf8_lossy(&solved.stderr));
    assert!(solved.status.success(), "{out}{errors}");
    let modes: Vec<f64> = out.lines().skip(1).map(|line| line.split(' ').next().unwrap().parse().unwrap()).collect();
    assert_eq!(modes.len(), 5, "{out}");
    for (j, omega) in (1..).zip(modes) {
        let exact = 2.0 * (f64::from(j) * std::f64::consts::PI / 2002.0).sin();
        assert!((omega - exact).abs() < 1e-9 * exact, "{omega} {exact}");
    }
    let vectors = read_vectors(&fs::read(output.join("vectors.npz")).unwrap()).unwrap();
    assert_eq!((vectors.dimension, vectors.count), (1000, 5));
    let shape: Vec<f64> = (1..=1000).map(|i| (f64::from(i) * std::f64::consts::PI / 1001.0).sin()).collect();
    let first = &vectors.components[..1000];
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    assert!((dot(first, &shape).powi(2) / dot(first, first) / dot(&shape, &shape) - 1.0).abs() < 1e-9);
}

/// An array of NumPy's in an archive, stored as it is.
fn archive(name: &str, header: &str, data: &[u8]) -> Vec<u8> {
    let mut array = b"\x93NUMPY\x01\x00".to_vec();
    array.extend((header.len() as u16).to_le_bytes());
    array.extend(header.as_bytes());
    array.extend(data);
    let crc = !array.iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    });
    let mut common = vec![0; 10];
    common.extend(crc.to_le_bytes());
    let size = (array.len() as u32).to_le_bytes();
    common.extend([size, size].concat());
    common.extend((name.len() as u16).to_le_bytes());
    common.extend([0; 2]);
    let mut out = b"PK\x03\x04".to_vec();
    out.extend(&common);
    out.extend(name.as_bytes());
    out.extend(&array);
    let directory = out.len();
    out.extend(b"PK\x01\x02\0\0");
    out.extend(&common);
    out.extend([0; 14]);
    out.extend(name.as_bytes());
    let length = ((out.len() - directory) as u32).to_le_bytes();
    out.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    out.extend(length);
    out.extend((directory as u32).to_le_bytes());
    out.extend([0; 2]);
    out
}

#[test]
fn vectors_of_others_are_read() {
    let data = |values: &[f64]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let six = data(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let header = |kind: &str, order: &str, shape: &str| {
        format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}\n")
    };
    let read = |header: &str, data: &[u8]| read_vectors(&archive("vectors.npy", header, data));
    let rows = read(&header("<f8", "False", "(3, 2)"), &six).unwrap();
    assert_eq!((rows.dimension, rows.count), (3, 2));
    assert_eq!(rows.components, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    let columns = read(&header("<f8", "True", "(3, 2)"), &six).unwrap();
    assert_eq!(columns.components, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let single = read(&header("<f8", "False", "(6,)"), &six).unwrap();
    assert_eq!((single.dimension, single.count), (6, 1));
    let big: Vec<u8> = [1.0_f64, 2.0].iter().flat_map(|value| value.to_be_bytes()).collect();
    assert_eq!(read(&header(">f8", "False", "(2, 1)"), &big).unwrap().components, [1.0, 2.0]);
    for (bytes, word) in [
        (Vec::new(), "it is no archive"),
        (b"PK\x05\x06".to_vec(), "it is no archive"),
        (archive("x.npy", "", &[]), "it has no array `vectors`"),
        (archive("vectors.npy", &header("<f4", "False", "(6, 2)"), &six), "the kind <f4; doubles are needed"),
        (archive("vectors.npy", &header("<f8", "False", "(3, 2, 1)"), &six), "has 3 indices"),
        (archive("vectors.npy", &header("<f8", "False", "(3, 3)"), &six), "is no array"),
        (archive("vectors.npy", &header("<f8", "False", "(18446744073709551615, 8)"), &six), "is no array"),
        (archive("vectors.npy", "{}", &six), "is no array"),
    ] {
        let error = read_vectors(&bytes).unwrap_err();
        assert!(error.contains(word), "{error}");
    }
    let mut damaged = archive("vectors.npy", &header("<f8", "False", "(3, 2)"), &six);
    let at = damaged.windows(8).position(|own| own == 6.0_f64.to_le_bytes()).unwrap();
    damaged[at] = 1;
    assert!(read_vectors(&damaged).unwrap_err().contains("is damaged"));
    let Some(python) = python("numpy") else { return };
    let folder = folder("vectors");
    let script = "
import numpy
x = numpy.arange(6.0).reshape(3, 2)
numpy.savez('c.npz', vectors=x, omega=x[0])
numpy.savez('f.npz', vectors=numpy.asfortranarray(x))
numpy.savez_compressed('z.npz', vectors=x)
";
    run_python(python, script, &folder);
    for name in ["c.npz", "f.npz"] {
        let read = read_vectors(&fs::read(folder.join(name)).unwrap()).unwrap();
        assert_eq!(read.components, [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
    }
    let error = read_vectors(&fs::read(folder.join("z.npz")).unwrap()).unwrap_err();
    assert!(error.contains("is compressed"), "{error}");
}
