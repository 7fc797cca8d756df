//! The hooks of the web server, with which a deviation can change a request, what is done with it, and the page.
//!
//! The web server itself has no deviations. Without the feature `deviations` no hook is called.

use device_stack::Attached;
use encoder_profile::hooks::EncoderView;
use wire::http::{HttpRequest, HttpResponse};

/// A decision of the web server; each comment describes `true`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WebCheck {
    /// The server accepts connections.
    AcceptsConnections,
    /// The password that was entered opens the firmware upgrade.
    Password,
}

/// A preset value entered on the preset page, and how it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetEntry {
    /// The entered value.
    pub value: u32,
    /// Whether P65000 is set to the value.
    pub is_used: bool,
    /// Whether the value is written to memory.
    pub is_stored: bool,
}

/// The hooks of the web server. The default implementations change nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait WebHooks {
    /// Returns the decision to use, given the check and the decision of the manual.
    fn check(&mut self, check: WebCheck, verdict: bool) -> bool {
        verdict
    }

    /// Called at power-up.
    fn powered_up(&mut self) {}

    /// Called when a connection with cyclic data begins.
    fn connected(&mut self) {}

    /// Changes a request before the server reads it.
    fn request(&mut self, request: &mut HttpRequest) {}

    /// Returns how an entered preset value is used.
    fn entry(&mut self, entry: PresetEntry) -> PresetEntry {
        entry
    }

    /// Returns the page that answers a request.
    fn page(&mut self, view: &EncoderView<'_>, request: &HttpRequest, page: HttpResponse) -> HttpResponse {
        page
    }
}

/// The deviations attached to a web server.
#[derive(Clone, Debug, Default)]
pub struct WebDeviations(pub Attached<dyn WebHooks>);

impl WebDeviations {
    /// Returns `verdict`, unless a deviation changes it.
    pub fn check(&self, check: WebCheck, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
