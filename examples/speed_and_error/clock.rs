//! CPU time: measurements hold on busy machines too.

use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// Of this process.
fn cpu() -> Duration {
    read(ClockId::ProcessCPUTime)
}

/// Of this thread.
pub(crate) fn of_thread() -> Duration {
    read(ClockId::ThreadCPUTime)
}

fn read(clock: ClockId) -> Duration {
    let time = clock_gettime(clock);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or(0);
    Duration::from_secs(seconds) + Duration::from_nanos(nanoseconds)
}

/// Wall and CPU time since it was started or read.
pub(crate) struct Clock {
    wall: Instant,
    cpu: Duration,
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self { wall: Instant::now(), cpu: cpu() }
    }

    /// Both times in seconds.
    pub(crate) fn lap(&mut self) -> (f64, f64) {
        let now = Self::start();
        let wall = (now.wall - self.wall).as_secs_f64();
        let cpu = now.cpu.saturating_sub(self.cpu).as_secs_f64();
        *self = now;
        (wall, cpu)
    }
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

/// The medians of wall and CPU time of repeated calls, in seconds: of at least five, for about a second.
pub(crate) fn repeat<T>(mut call: impl FnMut() -> Result<T, Box<dyn Error>>) -> Result<(f64, f64), Box<dyn Error>> {
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    let start = Instant::now();
    while wall.len() < 5 || (wall.len() < 2000 && start.elapsed() < Duration::from_secs(1)) {
        let mut clock = Clock::start();
        black_box(call()?);
        let times = clock.lap();
        wall.push(times.0);
        cpu.push(times.1);
    }
    Ok((median(wall).unwrap_or_default(), median(cpu).unwrap_or_default()))
}

/// The one in the middle; the upper one of two.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
