//! CPU time of this process: measurements hold on busy machines too.

use std::hint::black_box;
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

fn cpu() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or(0);
    Duration::from_secs(seconds) + Duration::from_nanos(nanoseconds)
}

/// What a call gives, and the CPU seconds of the fastest of several: for `patience` seconds after the first
/// one, at least three and at most fifty samples, but of what takes longer than that a single one. A
/// sample lasts a millisecond or more. `peers.py` measures alike.
pub(crate) fn fastest<T>(patience: f64, mut call: impl FnMut() -> T) -> (f64, T) {
    let mut sample = |calls: u32| {
        let start = cpu();
        for _ in 1..calls {
            black_box(call());
        }
        let result = black_box(call());
        let time = cpu().saturating_sub(start).as_secs_f64();
        (time / f64::from(calls), result)
    };
    let (first, mut result) = sample(1);
    let calls = (1e-3 / first.max(1e-7)).clamp(1.0, 1e4) as u32;
    let (mut best, mut spent, mut samples) = (first, 0.0, 0);
    while first < patience && samples < 50 && (samples < 3 || spent < patience) {
        let (time, next) = sample(calls);
        result = next;
        best = best.min(time);
        spent += time * f64::from(calls);
        samples += 1;
    }
    (best, result)
}
