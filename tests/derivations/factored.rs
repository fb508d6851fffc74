//! Sums that are products, or have squares in them, are written so.
#![cfg(feature = "cli")]

use std::path::Path;

use crate::common::model_in;
use librate::derive::{Parts, derive};
use librate::report::{Style, derive_json, derive_text};

/// The derivation as JSON, and as a page.
fn derived(text: &str) -> [String; 2] {
    let page = derive(&model_in(text, Path::new("models"), &[]), &Parts::default().frequencies(true)).unwrap();
    [derive_json(&page), derive_text(&page, &Style::default())]
}

#[track_caller]
fn has(text: &str, parts: &[&str]) {
    let [json, page] = derived(text);
    for part in parts {
        assert!(json.contains(part) || page.contains(part), "{part} is not in {json}\n{page}");
    }
}

fn model(name: &str) -> String {
    std::fs::read_to_string(format!("models/{name}.lag")).unwrap()
}

#[test]
fn fractions_without_what_their_sides_have_in_common() {
    has(&model("ball_rolling_in_bowl"), &["\"5/7*g/(R - r)\""]);
    // A disc in a ring that rolls itself.
    let ring = "param M, R, m, r, g  assume M>0, R>0, m>0, r>0, R>r, g>0  coord x, th, phi, w
let c = [x + (R-r)*sin(phi), -(R-r)*cos(phi)]
T = 1/2*M*x'^2 + 1/2*M*R^2*th'^2 + 1/2*m*dot(c',c') + 1/4*m*r^2*w'^2
V = m*g*c[2]
constraint x = R*th
constraint r*w = R*th - (R-r)*phi";
    has(ring, &["g*(4*M + 3*m)/((R - r)*(3*M + 2*m))"]);
    // A body that rocks on a sphere.
    let rocking = "param m, r, R, h, rho, g  assume m>0, r>0, R>0, h>0, rho>0, g>0  coord th
let ps = th + R*th/r
let G = (R+r)*[sin(th), cos(th)] - (r-h)*[sin(ps), cos(ps)]
T = 1/2*m*dot(G', G') + 1/2*m*rho^2*ps'^2
V = m*g*G[2]";
    has(rocking, &["(rho^2 + h^2)"]);
}

#[test]
fn radicands_in_factors_and_with_squares() {
    has(&model("gyroscope_in_gimbals"), &["sqrt((J + B[1] + A)*(B[2] + A))"]);
    let plane = "param m, w1, w2, wB  assume m>0, w1>0, w2>0, wB>0  coord x, y
lagrangian = 1/2*m*(x'^2+y'^2) - 1/2*m*(w1^2*x^2 + w2^2*y^2) + 1/2*m*wB*(x*y' - y*x')";
    has(plane, &["sqrt(wB^2 + (w1 + w2)^2)", "sqrt(wB^2 + (w2 - w1)^2)"]);
    let shaft = "param m, k1, k2, W  assume m>0, k1>0, k2>k1, W>0  coord x, y
T = 1/2*m*((x'-W*y)^2 + (y'+W*x)^2)
V = 1/2*k1*x^2 + 1/2*k2*y^2";
    has(shaft, &["(k2 - k1)^2 + 8*m*W^2*(k1 + k2)"]);
    let line = "param m1, m2, m3, k  assume m1 > 0, m2 > 0, m3 > 0, k > 0  coord x, y, z
T = 1/2*m1*x'^2 + 1/2*m2*y'^2 + 1/2*m3*z'^2
V = 1/2*k*(x - y)^2 + 1/2*k*(y - z)^2";
    has(line, &["(1/m3 - 1/m1)^2"]);
}
