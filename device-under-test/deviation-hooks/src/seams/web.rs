//! Deviations at the hooks of the web server of the XAC77.

use alloc::string::String;
use encoder_profile::hooks::EncoderView;
use reference_devices::models::lika_xac77::hooks::{PresetEntry, WebCheck, WebHooks};
use wire::http::{HttpRequest, HttpResponse};

hooks! { WebServer: WebHooks
    /// Changes a decision, given the check and the decision of the server.
    check(check: WebCheck) -> bool;
    /// Is called at power-up.
    powered_up();
    /// Is called when a connection begins.
    connected();
    /// Changes a request before the server reads it.
    request(request: &mut HttpRequest);
    /// Changes how an entered preset value is used.
    entry() -> PresetEntry;
    /// Changes a page, given the request.
    page(view: &EncoderView<'_>, request: &HttpRequest) -> HttpResponse;
}

impl WebServer {
    /// Fixes the result of a check, whatever the manual says.
    pub fn set(&mut self, of: WebCheck, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Changes the text of each page.
    pub fn text(&mut self, change: impl Fn(&str) -> String + 'static) {
        self.page(move |_, _, page| with_text(page, &change));
    }

    /// Changes the text entered on the preset page.
    pub fn entered(&mut self, change: impl Fn(&str) -> String + 'static) {
        self.request(move |request| {
            if request.method == "POST"
                && let Some(entry) = request.field("value")
            {
                *request = HttpRequest::post(&request.path, &[("value", &change(&entry))]);
            }
        });
    }
}

/// Changes the text of a page.
pub fn with_text(page: HttpResponse, change: impl Fn(&str) -> String) -> HttpResponse {
    HttpResponse { body: change(&String::from_utf8_lossy(&page.body)).into_bytes(), ..page }
}
