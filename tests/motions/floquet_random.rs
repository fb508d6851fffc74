//! Driven models drawn at random against multipliers of 40 digits that were computed by other means
//! (tests/reference/driven_random.py): no bound is violated, and whatever can be decided is decided.
//!
//! `LIBRATE_DRIVEN=FILE` takes other models, made by the same script.
#![cfg(feature = "engine")]

use librate::floquet::{Floquet, Options, Place, floquet};
use librate::model::{Settings, TableTexts, elaborate};
use librate::number::Number;
use librate::precision::{Ball, Big};
use librate::syntax;
use librate_studies::floquet::Multiplier;
use serde_json::Value;

/// Bits that hold the digits of the references.
const BITS: usize = 200;

fn number(value: &Value) -> Big {
    let text = value.as_str().unwrap();
    let number = match text.strip_prefix('-') {
        Some(rest) => Number::parse(rest).unwrap().neg(),
        None => Number::parse(text).unwrap(),
    };
    Big::from_number(&number, BITS)
}

fn found(text: &str, digits: usize) -> Floquet {
    let file = syntax::parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let options = Options::default().digits(digits);
    floquet(&model, &options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn parts(own: &Multiplier) -> [Big; 2] {
    match &own.precise {
        Some(precise) => [precise[0].clone(), precise[1].clone()],
        None => [&own.re, &own.im].map(|x| Big::from_ball(x, BITS)),
    }
}

/// Whether a bound holds the reference, which has 45 digits itself; `size` is that of the number it is a part of.
fn holds(own: &Big, want: &Big, size: f64) -> bool {
    let rounded = Big::from_f64(1e-42 * size, BITS).abs_upper();
    (own - &want.clone().with_added_radius(rounded)).contains_zero()
}

fn check(model: &Value, digits: usize) {
    let text = model["text"].as_str().unwrap();
    let found = found(text, digits);
    assert!(found.period_proved, "{text}");
    for (name, own) in [("place", &found.place), ("velocities", &found.velocities)] {
        for (own, want) in own.iter().zip(model[name].as_array().unwrap()) {
            let own = Big::from_ball(own, BITS);
            assert!(holds(&own, &number(want), 1.0), "{name} {own:?} {want}\n{text}");
        }
    }
    let wanted = model["multipliers"].as_array().unwrap();
    assert_eq!(found.multipliers.len(), wanted.len(), "{text}");
    let mut free: Vec<[Big; 2]> = wanted.iter().map(|z| [number(&z[0]), number(&z[1])]).collect();
    for own in &found.multipliers {
        let own_parts = parts(own);
        let far = |z: &[Big; 2]| {
            let off = |at: usize| (&own_parts[at] - &z[at]).abs_upper().to_f64();
            off(0).hypot(off(1))
        };
        let best = (0..free.len()).min_by(|a, b| far(&free[*a]).total_cmp(&far(&free[*b])));
        let want = free.remove(best.unwrap());
        let size = want[0].mid_f64().hypot(want[1].mid_f64());
        for (own, want) in own_parts.iter().zip(&want) {
            assert!(holds(own, want, size), "{own:?} is not {want:?}\n{text}");
        }
        let square = &(&want[0] * &want[0]) + &(&want[1] * &want[1]);
        let above = (&square - &Big::one(BITS)).mid_f64();
        let right = match own.place {
            Place::Inside => above < 0.0,
            Place::Outside => above > 0.0,
            Place::On => above.abs() < 1e-40,
            _ => false,
        };
        assert!(right, "{:?} of {want:?}\n{text}", own.place);
        let error = own_parts[0].radius().max(own_parts[1].radius()).to_f64();
        let allowed = 10f64.powi(-i32::try_from(digits).unwrap());
        assert!(error <= allowed * size, "{error:e} of {size:e}\n{text}");
    }
    assert_eq!(found.stable, model["stable"].as_bool(), "{text}");
    if let (Some(false), Some(rate)) = (found.stable, found.growth_rate) {
        let moduli = wanted.iter().map(|z| {
            let [re, im] = [number(&z[0]), number(&z[1])].map(|x| x.to_ball());
            (re.powi(2) + im.powi(2)).sqrt()
        });
        let largest = moduli.max_by(|a, b| a.mid_f64().total_cmp(&b.mid_f64()));
        let want = largest.unwrap().ln() / found.period;
        let tiny = Ball::ZERO.with_added_radius(1e-28);
        assert!((rate - want + tiny).contains_zero(), "{rate:?} {want:?}\n{text}");
    }
}

#[test]
fn random_models_agree_with_references() {
    let path = std::env::var("LIBRATE_DRIVEN");
    // All models of a file that is named, every eighth pair of those here.
    let step = if path.is_ok() { 2 } else { 16 };
    let path = path.unwrap_or_else(|_| "tests/reference/driven/random.json".to_owned());
    let data: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let models = data["models"].as_array().unwrap();
    assert!(models.len() >= 40);
    // Two at a time.
    std::thread::scope(|scope| {
        for half in 0..2 {
            scope.spawn(move || {
                for (at, model) in models.iter().enumerate().skip(half).step_by(step) {
                    check(model, if at % 32 < 2 { 28 } else { 10 });
                }
            });
        }
    });
}
