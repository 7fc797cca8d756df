//! The hooks of the web server of the XAC77, as the rows of the tables attach to them.

use alloc::string::String;
use encoder_profile::hooks::EncoderView;
use reference_devices::models::lika_xac77::hooks::{Check, Entry, WebHooks};
use wire::http::{Request, Response};

hooks! { WebServer: WebHooks
    /// Flips a decision: from what it is about and what the server has decided.
    check(check: Check) -> bool;
    /// Does something when the supply has come.
    powered_up();
    /// Does something when a connection has begun.
    connected();
    /// Changes a request before the server reads it.
    request(request: &mut Request);
    /// Changes what becomes of a preset value that was entered.
    entry() -> Entry;
    /// Changes a page, from what was requested.
    page(view: &EncoderView<'_>, request: &Request) -> Response;
}

impl WebServer {
    /// Decides about this always so, whatever the manual says.
    pub fn set(&mut self, of: Check, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Changes the text of each page.
    pub fn text(&mut self, change: impl Fn(&str) -> String + 'static) {
        self.page(move |_, _, page| with_text(page, &change));
    }

    /// Changes what was entered on the preset page.
    pub fn entered(&mut self, change: impl Fn(&str) -> String + 'static) {
        self.request(move |request| {
            if request.method == "POST"
                && let Some(entry) = request.field("value")
            {
                *request = Request::post(&request.path, &[("value", &change(&entry))]);
            }
        });
    }
}

/// A page with another text.
pub fn with_text(page: Response, change: impl Fn(&str) -> String) -> Response {
    Response { body: change(&String::from_utf8_lossy(&page.body)).into_bytes(), ..page }
}
