//! Requests to stop: SIGINT (Ctrl-C) and SIGTERM (`kill`).

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once, OnceLock};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();
static WATCH: Once = Once::new();

/// From now on the first interrupt only sets the flag that [`requested`] returns; a second one ends the process at once.
///
/// The process then exits with status 130, the status that shells use for an interrupt. Calling it again has no effect.
pub fn watch() {
    WATCH.call_once(|| {
        let flag = REQUESTED.get_or_init(Arc::default);
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the handler that ends the process reads the flag before the other handler sets it. If the
            // registration fails, an interrupt ends the process as by default.
            let _ = signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(flag));
            let _ = signal_hook::flag::register(signal, Arc::clone(flag));
        }
    });
}

static RELOAD: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// From now on SIGHUP only sets the flag that [`take_reload`] returns.
pub fn watch_reload() {
    let flag = RELOAD.get_or_init(Arc::default);
    // If the registration fails, the signal ends the process as by default.
    let _ = signal_hook::flag::register(SIGHUP, Arc::clone(flag));
}

/// Whether a SIGHUP has occurred since the last call.
pub fn take_reload() -> bool {
    RELOAD.get().is_some_and(|flag| flag.swap(false, Ordering::Relaxed))
}

/// Whether an interrupt has occurred since [`watch`] was called.
pub fn requested() -> bool {
    REQUESTED.get().is_some_and(|flag| flag.load(Ordering::Relaxed))
}
