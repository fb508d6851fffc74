//! The texts of models that several programs measure.

pub(crate) const PENDULUMS: &str = "
param m = 1  param l = 1  param g = 9.81  param L = 0.5  param k12 = 2  param k23 = 3
coord phi[1..3]
T = sum(i in 1..3, 1/2*m*l^2*phi[i]'^2)
V = sum(i in 1..3, m*g*l*(1 - cos(phi[i]))) + L^2/2*(k12*(phi[2] - phi[1])^2 + k23*(phi[3] - phi[2])^2)
";

pub(crate) const LINKS: &str = "
param g = 9.81
param l[1..N] = 1
param m[1..N] = 1
coord theta[1..N]
let x[0] = 0
let y[0] = 0
let x[k in 1..N] = x[k-1] + l[k]*sin(theta[k])
let y[k in 1..N] = y[k-1] - l[k]*cos(theta[k])
T = sum(k in 1..N, 1/2*m[k]*(x[k]'^2 + y[k]'^2))
V = sum(k in 1..N, m[k]*g*y[k])
";

pub(crate) const DAMPING: &str = "
param c[1..N] = 1
dissipation = sum(k in 1..N, 1/2*c[k]*theta[k]'^2)
";
