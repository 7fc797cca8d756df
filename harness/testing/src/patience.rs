//! What tests in real time share: a machine that halts now and then, for milliseconds or for many seconds, spoils no test.
//!
//! A thread looks at the clock all the time. Where it got no turn the machine halted, and whatever failed at that time may have
//! failed for no other reason: it is looked at again. Without a halt a failure is one at once.

use std::any::Any;
use std::panic::resume_unwind;
use std::sync::{Mutex, Once, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// So often a test is tried that halts have spoilt.
const TRIES: usize = 6;
/// How often it is looked whether the machine halts.
const LOOK: Duration = Duration::from_millis(2);
/// So much later than it was to be a look is a halt; no deadline of a live bench is nearer than twice as much.
const HALT: Duration = Duration::from_millis(4);

/// The time between two looks for something that is waited for.
const PAUSE: Duration = Duration::from_millis(10);

/// What is known of the halts.
struct Known {
    /// When the last look was.
    looked: Instant,
    /// When each halt was over, and how long it was.
    halts: Vec<(Instant, Duration)>,
}

static KNOWN: Mutex<Option<Known>> = Mutex::new(None);

fn with_known<T>(use_it: impl FnOnce(&mut Known) -> T) -> T {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    use_it(known.get_or_insert_with(|| Known { looked: Instant::now(), halts: Vec::new() }))
}

/// Looks at the clock until the process ends.
fn watch() {
    static WATCHED: Once = Once::new();
    WATCHED.call_once(|| {
        with_known(|_| ());
        thread::spawn(|| {
            loop {
                thread::park_timeout(LOOK);
                with_known(|known| {
                    let now = Instant::now();
                    let late = now.duration_since(known.looked).saturating_sub(LOOK);
                    if late > HALT {
                        known.halts.push((now, late));
                    }
                    known.looked = now;
                });
            }
        });
    });
}

/// The longest halt since `begin`, one that has not been looked at yet included.
fn longest_halt(begin: Instant) -> Duration {
    with_known(|known| {
        let seen = known.halts.iter().filter(|(end, _)| *end >= begin).map(|(_, length)| *length);
        seen.max().unwrap_or_default().max(known.looked.elapsed().saturating_sub(LOOK))
    })
}

/// Tries a test until it passes, or fails without a halt of this machine; it panics as the last try did.
///
/// Each try has a thread of its own, as a test may have changed what belongs to its thread.
pub fn patiently(test: impl Fn() + Sync) {
    watch();
    for left in (0..TRIES).rev() {
        let begin = Instant::now();
        let Err(panic) = thread::scope(|scope| scope.spawn(&test).join()) else { return };
        let halt = longest_halt(begin);
        if halt <= HALT {
            resume_unwind(panic);
        }
        let why = said(&*panic);
        if left == 0 {
            eprintln!("It failed in each of {TRIES} tries, and in each this machine halted, now for {halt:?}: {why}");
            resume_unwind(panic);
        }
        eprintln!("It is tried again, for this machine halted for {halt:?}: {why}");
    }
}

/// Looks until it is well, or not well without a halt of this machine; it panics with what was last seen.
#[track_caller]
pub fn again(mut look: impl FnMut() -> Result<(), String>) {
    watch();
    let mut last = String::new();
    for _ in 0..TRIES {
        let begin = Instant::now();
        match look() {
            Ok(()) => return,
            Err(seen) => last = seen,
        }
        if longest_halt(begin) <= HALT {
            panic!("{last}");
        }
    }
    panic!("In each of {TRIES} looks this machine halted, and none was well; the last: {last}");
}

/// What `look` gives in a time without a halt longer than `bearable`, which is what it bears.
///
/// What was seen with a longer one is looked at again. It panics where every look had one: then nothing can be said.
pub fn undisturbed<T>(bearable: Duration, look: impl Fn() -> T) -> T {
    watch();
    for _ in 0..TRIES {
        let begin = Instant::now();
        let seen = look();
        if longest_halt(begin) <= bearable {
            return seen;
        }
    }
    panic!("Nothing can be said: this machine halted for more than {bearable:?} in each of {TRIES} looks.");
}

/// Waits until there is something, a minute at most, and leaves the processor to others meanwhile.
#[track_caller]
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "{what} does not come");
        thread::park_timeout(PAUSE);
    }
}

/// What a panic said.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it says nothing")
}
