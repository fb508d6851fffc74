//! What the measurements were made on and with.

/// The version of a crate in Cargo.lock.
pub(crate) fn locked(name: &str) -> &'static str {
    let all = include_str!("../../Cargo.lock");
    let at = all.split("[[package]]").find_map(|package| {
        let own = package.lines().any(|line| line == format!("name = \"{name}\""));
        let version = package.lines().find_map(|line| line.strip_prefix("version = "));
        version.filter(|_| own)
    });
    at.map_or("?", |version| version.trim_matches('"'))
}

/// What a program prints, the first line of it.
pub(crate) fn said(program: &str, argument: &str) -> Option<String> {
    let output = std::process::Command::new(program).arg(argument).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().next().map(str::to_owned)
}

/// The processor, as far as the system tells.
pub(crate) fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let model = line.and_then(|line| line.split(':').nth(1));
    let mut vectors = [("AVX-512", "avx512f"), ("AVX2", "avx2")].into_iter();
    let vectors = vectors.find(|(_, flag)| text.split_whitespace().any(|word| word == *flag));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "{} ({}{}), {cores} cores of it, {}",
        model.map_or("a processor of unknown name", str::trim),
        std::env::consts::ARCH,
        vectors.map_or(String::new(), |(name, _)| format!(", {name}")),
        std::env::consts::OS,
    )
}

/// A text with values for the names that it has in braces.
pub(crate) fn filled(text: &str, value: impl Fn(&str) -> String) -> String {
    let parts = text.split(['{', '}']).enumerate();
    parts.map(|(at, part)| if at % 2 == 0 { part.to_owned() } else { value(part) }).collect()
}
