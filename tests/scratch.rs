//! scratch
use librate::{linearize, model, syntax};
#[test]
fn all() {
    let mut names: Vec<_> = std::fs::read_dir("models").unwrap().map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|x| x == "lag")).collect();
    names.sort();
    for path in names {
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let t0 = std::time::Instant::now();
        let file = match syntax::parse(&text) { Ok(f) => f, Err(e) => { println!("{name}: SYNTAX {e:?}"); continue; } };
        let mut tables = model::TableTexts::new();
        for s in &file.statements { if let syntax::StatementKind::Table { path: p, .. } = &s.kind {
            tables = tables.with(p.clone(), std::fs::read_to_string(path.parent().unwrap().join(p)).unwrap()); } }
        let t1 = t0.elapsed();
        let model = match model::elaborate(&file, &tables, &model::Settings::new()) { Ok(m) => m, Err(e) => { for e in e { println!("{name}: MODEL {e}  {e:?}"); } continue; } };
        let t2 = t0.elapsed();
        let fam: Vec<String> = model.kinetic.iter().chain(&model.potential).map(|f| format!("{}x{}", f.count, f.locals.len())).collect();
        if name.contains("roller") { println!("{name}: {}", linearize::linearize(model).unwrap_err()); continue; }
        let lin = match linearize::linearize(model) { Ok(m) => m, Err(e) => { println!("{name}: LIN {e}"); continue; } };
        let t3 = t0.elapsed();
        let n = lin.dimension();
        let (m, k) = (lin.mass(), lin.stiffness());
        let t4 = t0.elapsed();
        let mm = nalgebra::DMatrix::from_fn(n, n, |i, j| m[i + n * j].mid_f64());
        let kk = nalgebra::DMatrix::from_fn(n, n, |i, j| k[i + n * j].mid_f64());
        let l = match nalgebra::Cholesky::new(mm) { Some(l) => l.l(), None => { println!("{name}: M not pos"); continue; } };
        let a = l.solve_lower_triangular(&kk).unwrap();
        let a = l.solve_lower_triangular(&a.transpose()).unwrap();
        let e = nalgebra::SymmetricEigen::new((&a + a.transpose()) * 0.5);
        let mut w: Vec<f64> = e.eigenvalues.iter().copied().collect();
        w.sort_by(f64::total_cmp);
        let reference: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap()).unwrap();
        let mut want: Vec<f64> = reference["modes"].as_array().unwrap().iter().map(|m| {
            let o: f64 = m["omega"].as_str().unwrap().parse().unwrap(); let g: f64 = m["growth"].as_str().unwrap().parse().unwrap(); o * o - g * g }).collect();
        want.sort_by(f64::total_cmp);
        let scale = w.last().unwrap().abs().max(w[0].abs());
        let err = w.iter().zip(&want).map(|(a, b)| (a - b).abs() / scale).fold(0.0, f64::max);
        println!("{name}: n={n} err {err:.1e} steps {} fam {fam:?} parse {t1:.0?} elab {:.0?} lin {:.0?} eval {:.0?}", lin.equilibrium().steps, t2 - t1, t3 - t2, t4 - t3);
        assert_eq!(w.len(), want.len());
    }
}
