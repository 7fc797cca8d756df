//! Being asked to stop: Ctrl-C and the signal of `kill`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();
static WATCH: Once = Once::new();

/// From now on, the first interrupt only sets what [`requested`] says; a second one ends the process at once.
///
/// The process then ends with the status that shells give to an interrupt, 130. Calling it again changes nothing.
pub fn watch() {
    WATCH.call_once(|| {
        let flag = REQUESTED.get_or_init(Arc::default);
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the one that ends the process looks at the flag before the other sets it. Where
            // the system refuses, an interrupt ends the process as it always does.
            let _ = signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(flag));
            let _ = signal_hook::flag::register(signal, Arc::clone(flag));
        }
    });
}

/// Whether the process has been asked to stop since [`watch`] was called.
pub fn requested() -> bool {
    REQUESTED.get().is_some_and(|flag| flag.load(Ordering::Relaxed))
}
