//! Tells the library whether it is built to be fast.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(slow_build)");
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("OPT_LEVEL").is_ok_and(|level| level == "0" || level == "1") {
        println!("cargo::rustc-cfg=slow_build");
    }
}
