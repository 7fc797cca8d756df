//! Bugs of the web server.

use super::Group;
use super::station_state::PagesStay;
use super::unrequested_presets::next_preset;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::web::with_text;
use alloc::format;
use alloc::rc::Rc;
use alloc::string::ToString;
use core::cell::Cell;
use encoder_profile::encoder::MeasuringSettings;
use encoder_profile::profidrive::telegram::SignalImage;
use reference_devices::manuals;
use reference_devices::models::lika_xac77::hooks::{PresetEntry, WebCheck, WebHooks};
use reference_devices::models::lika_xac77::web;
use wire::http::HttpResponse;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: BUGS }];

static BUGS: &[super::Deviation] = bugs! {
    // Server
    "web-waits-for-connection" "The web server answers only after the first connection."
        => |d| d.web.add(WaitsForConnection::default());
    "web-at-fixed-address" "The web server answers only at the first IP address of the device."
        => |d| d.stack.add(PagesStay::default());
    "password-for-every-page" "The position page requires a password."
        => |d| d.web.page(|_, request, page| match request.path.as_str() {
            "/position.htm" => HttpResponse::page(401, "<p>Password?</p>"),
            _ => page,
        });
    "page-freezes-position" "The signals of the telegram are frozen while a page is generated."
        => |d| page_freezes_position(d);

    // Contents of pages
    "links-of-another-vendor" "The links lead to the site of another vendor."
        => |d| d.web.text(|text| text.replace("www.lika.it", "www.example.com"));
    "menu-of-one-group" "The menu does not show which pages are protected."
        => |d| d.web.text(|text| text.replace("<h2>Password protected menus</h2>", ""));
    "pages-without-confirmation" "Pages for changes open without confirmation."
        => |d| d.web.text(|text| text.replace(" onclick=\"return confirm('Are you sure?')\"", ""));
    "page-shows-defaults" "The information page shows the default parameters instead of those in force."
        => |d| d.web.page(|view, request, page| match request.path.as_str() {
            "/information.htm" => web::information(&(view.facts.default_record)(&view.hardware)),
            _ => page,
        });
    "page-made-once" "The information page is generated only once and never updated."
        => |d| shows_first(d, "/information.htm");
    "page-shows-old-version" "The pages show the previous firmware version."
        => |d| d.web.page(|view, _, page| {
            let version = view.facts.software[0];
            with_text(page, |text| text.replace(&format!("<td>{version}</td>"), &format!("<td>{}</td>", version - 10)))
        });
    "page-shows-raw-position" "The position page shows the position without scaling and offset."
        => |d| d.web.page(|view, request, page| match request.path.as_str() {
            "/position.htm" => web::position(view.measuring.with_settings(MeasuringSettings::hardware(&view.hardware)).position()),
            _ => page,
        });
    "page-position-frozen" "The position page is never updated."
        => |d| shows_first(d, "/position.htm");

    // Preset value
    "web-entry-decimal" "An entered preset value is read as decimal."
        => |d| d.web.entered(|entry| entry.parse::<u32>().map_or("none".to_string(), |value| format!("{value:X}")));
    "web-entry-until-bad-digit" "An entered preset value is read up to the first invalid character."
        => |d| d.web.entered(|entry| {
            let digits = entry.bytes().take_while(u8::is_ascii_hexdigit).count();
            if digits == 0 { "0".to_string() } else { entry[..digits.min(8)].to_string() }
        });
    "web-entry-presets" "Entering a preset value makes a preset."
        => |d| web_entry_presets(d);
    "web-entry-always-stored" "A preset value that is already stored is written to memory again."
        => |d| d.web.entry(|entry| PresetEntry { is_stored: true, ..entry });
    "web-value-only-stored" "An entered preset value is used only after the next power-up."
        => |d| d.web.entry(|entry| PresetEntry { is_used: false, ..entry });
    "web-value-not-stored" "An entered preset value is lost at power-off."
        => |d| d.web.entry(|entry| PresetEntry { is_stored: false, ..entry });
    "web-value-apart" "The web server has a separate preset value."
        => |d| web_value_apart(d);

    // Firmware upgrade
    "page-stays-white" "The page of the firmware upgrade does not turn red."
        => |d| d.web.text(|text| text.replace(" style=\"background-color: red\"", ""));
    "any-password" "Any password opens the firmware upgrade."
        => |d| d.web.set(WebCheck::Password, true);
    "server-goes-on" "The web server is not stopped while the encoder waits for new firmware."
        => |d| d.web.set(WebCheck::AcceptsConnections, true);
};

/// Number of frames for which the signals are frozen.
const FROZEN_FRAMES: u32 = 5;

/// Serves pages only after the first connection since power-up.
#[derive(Default)]
struct WaitsForConnection {
    was_connected: bool,
}

impl WebHooks for WaitsForConnection {
    fn check(&mut self, check: WebCheck, verdict: bool) -> bool {
        verdict && (check != WebCheck::AcceptsConnections || self.was_connected)
    }

    fn powered_up(&mut self) {
        self.was_connected = false;
    }

    fn connected(&mut self) {
        self.was_connected = true;
    }
}

fn web_entry_presets(d: &mut Deviations) {
    let next = next_preset(d);
    d.web.entry(move |entry| {
        next.set(Some(entry.value.into()));
        entry
    });
}

fn page_freezes_position(d: &mut Deviations) {
    let frames = Rc::new(Cell::new(0));
    let left = frames.clone();
    d.web.request(move |_| frames.set(FROZEN_FRAMES));
    d.encoder.signals(move |before, now| {
        if left.get() == 0 {
            return now;
        }
        left.set(left.get() - 1);
        SignalImage { zsw2_enc: now.zsw2_enc, outputs: now.outputs, trigger: now.trigger, ..before.sent }
    });
}

fn shows_first(d: &mut Deviations, path: &'static str) {
    let mut first = None;
    d.web.page(move |_, request, page| if request.path == path { first.get_or_insert(page).clone() } else { page });
}

fn web_value_apart(d: &mut Deviations) {
    let entered = Rc::new(Cell::new(None));
    let shown = entered.clone();
    d.web.entry(move |entry| {
        entered.set(Some(entry.value));
        PresetEntry { is_used: false, is_stored: false, ..entry }
    });
    d.web.page(move |view, _, page| match shown.get() {
        Some(value) => {
            let right = format!("(hex): {:X}<", view.preset_value);
            with_text(page, |text| text.replace(&right, &format!("(hex): {value:X}<")))
        }
        None => page,
    });
}
