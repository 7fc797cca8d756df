//! Retries for tests in real time: a host that stalls, for milliseconds or for many seconds, must not fail a test.
//!
//! A thread reads the clock every `POLL`. Where it was not scheduled in time the host stalled, and whatever failed meanwhile may
//! have failed for that reason alone: it is tried again, after the second failure without other tests beside it. A failure without a
//! stall counts at once.

use std::any::Any;
use std::panic::resume_unwind;
use std::sync::{Mutex, Once, PoisonError, RwLock};
use std::thread;
use std::time::{Duration, Instant};

/// How often a test is tried while the host stalls.
const TRIES: usize = 6;
/// How many of them have other tests beside them.
const TOGETHER: usize = 2;
/// The time between two readings of the clock.
const POLL: Duration = Duration::from_millis(2);
/// A reading that is later than this is a stall. The shortest deadline of a live bench is twice as long.
const STALL: Duration = Duration::from_millis(4);

/// The time between two checks in [`wait_for`].
const PAUSE: Duration = Duration::from_millis(10);
/// How long [`wait_for`] waits.
const WAIT: Duration = Duration::from_secs(60);

/// The stalls that were observed so far.
struct Stalls {
    /// When the clock was last read.
    last_reading: Instant,
    /// The end of each stall, and its length.
    observed: Vec<(Instant, Duration)>,
}

/// Held by every test that runs; alone by a test that has to run alone.
static RUNNING: RwLock<()> = RwLock::new(());

static STALLS: Mutex<Option<Stalls>> = Mutex::new(None);

fn with_stalls<T>(use_them: impl FnOnce(&mut Stalls) -> T) -> T {
    let mut stalls = STALLS.lock().unwrap_or_else(PoisonError::into_inner);
    use_them(stalls.get_or_insert_with(|| Stalls { last_reading: Instant::now(), observed: Vec::new() }))
}

/// Starts the thread that reads the clock until the process ends.
fn watch() {
    static WATCHED: Once = Once::new();
    WATCHED.call_once(|| {
        with_stalls(|_| ());
        thread::spawn(|| {
            loop {
                thread::park_timeout(POLL);
                with_stalls(|stalls| {
                    let now = Instant::now();
                    let late = now.duration_since(stalls.last_reading).saturating_sub(POLL);
                    if late > STALL {
                        stalls.observed.push((now, late));
                    }
                    stalls.last_reading = now;
                });
            }
        });
    });
}

/// The longest stall since `begin`, including one that has not ended yet.
fn longest_stall(begin: Instant) -> Duration {
    with_stalls(|stalls| {
        let lengths = stalls.observed.iter().filter(|(end, _)| *end >= begin).map(|(_, length)| *length);
        lengths.max().unwrap_or_default().max(stalls.last_reading.elapsed().saturating_sub(POLL))
    })
}

/// Runs a test until it passes or fails without a stall of the host. Panics as the last try did.
///
/// From the third try on it waits until no other such test of this process runs, and none begins meanwhile. Each try runs on its own
/// thread, since a test may have changed thread-local state.
pub fn retry_on_stall(test: impl Fn() + Sync) {
    watch();
    for left in (0..TRIES).rev() {
        let is_alone = left < TRIES - TOGETHER;
        let alone = is_alone.then(|| RUNNING.write().unwrap_or_else(PoisonError::into_inner));
        let together = (!is_alone).then(|| RUNNING.read().unwrap_or_else(PoisonError::into_inner));
        let begin = Instant::now();
        let Err(panic) = thread::scope(|scope| scope.spawn(&test).join()) else { return };
        let stall = longest_stall(begin);
        drop((alone, together));
        if stall <= STALL {
            resume_unwind(panic);
        }
        let why = panic_message(&*panic);
        if left == 0 {
            eprintln!("failed in each of {TRIES} tries; the host stalled in each of them, last for {stall:?}: {why}");
            resume_unwind(panic);
        }
        eprintln!("trying again, because the host stalled for {stall:?}: {why}");
    }
}

/// Runs `check` until it succeeds or fails without a stall of the host. Panics with the last error.
#[track_caller]
pub fn retry_check_on_stall(mut check: impl FnMut() -> Result<(), String>) {
    watch();
    let mut last = String::new();
    for _ in 0..TRIES {
        let begin = Instant::now();
        match check() {
            Ok(()) => return,
            Err(why) => last = why,
        }
        if longest_stall(begin) <= STALL {
            panic!("{last}");
        }
    }
    panic!("The host stalled in each of {TRIES} tries, and none succeeded. The last error: {last}");
}

/// Runs `work` until no stall during it is longer than `tolerated`, and returns its result.
///
/// Panics if every try had a longer stall: then the result says nothing.
pub fn run_without_stall<T>(tolerated: Duration, work: impl Fn() -> T) -> T {
    watch();
    for _ in 0..TRIES {
        let begin = Instant::now();
        let result = work();
        if longest_stall(begin) <= tolerated {
            return result;
        }
    }
    panic!("No result: the host stalled for more than {tolerated:?} in each of {TRIES} tries.");
}

/// Waits until `find` returns something, for at most `WAIT`, and yields the processor meanwhile.
#[track_caller]
pub fn wait_for<T>(what: &str, mut find: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = find() {
            return found;
        }
        assert!(begin.elapsed() < WAIT, "waited {WAIT:?} for {what}");
        thread::park_timeout(PAUSE);
    }
}

/// The message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message")
}
