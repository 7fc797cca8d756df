//! The hooks of the web server: the seams at which a deviation may change a request, what is done with it, and the page.
//!
//! The web server itself is plain. Without the feature `deviations` no hook is ever called.

use device_stack::Attached;
use encoder_profile::hooks::EncoderView;
use wire::http::{Request, Response};

/// A decision of the web server; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The server takes connections.
    Serves,
    /// The password that was entered opens the firmware upgrade.
    Password,
}

/// What becomes of a preset value that was entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The value.
    pub value: u32,
    /// Whether P65000 takes it.
    pub is_used: bool,
    /// Whether it is written to memory.
    pub is_stored: bool,
}

/// The hooks of the web server; each default changes nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait WebHooks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict
    }

    /// The supply has come.
    fn powered_up(&mut self) {}

    /// A connection with cyclic data has begun.
    fn connected(&mut self) {}

    /// Changes a request before the server reads it.
    fn request(&mut self, request: &mut Request) {}

    /// What becomes of a preset value that was entered.
    fn entry(&mut self, entry: Entry) -> Entry {
        entry
    }

    /// The page that answers a request.
    fn page(&mut self, view: &EncoderView<'_>, request: &Request, page: Response) -> Response {
        page
    }
}

/// The handle of the deviations of a web server.
#[derive(Clone, Debug, Default)]
pub struct Hooks(pub Attached<dyn WebHooks>);

impl Hooks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    pub fn check(&self, check: Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
