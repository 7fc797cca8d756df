//! Bugs of the web server.

use super::Group;
use super::station_memory::PagesStay;
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
use reference_devices::models::lika_xac77::hooks::{Check, Entry, WebHooks};
use reference_devices::models::lika_xac77::web;
use wire::http::HttpResponse;

/// The bugs of a web server.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: BUGS }];

static BUGS: &[super::Deviation] = bugs! {
    // Server
    "web-waits-for-connection" "The web server answers only after the first connection."
        => |d| d.web.add(WaitsForConnection::default());
    "web-at-fixed-address" "The web server answers only at the first address that the device had."
        => |d| d.stack.add(PagesStay::default());
    "password-for-every-page" "The position page asks for a password."
        => |d| d.web.page(|_, request, page| match request.path.as_str() {
            "/position.htm" => HttpResponse::page(401, "<p>Password?</p>"),
            _ => page,
        });
    "page-freezes-position" "While a page is made the signals of the telegram stand still."
        => |d| page_freezes_position(d);

    // What is shown
    "links-of-another-vendor" "The links lead to another vendor."
        => |d| d.web.text(|text| text.replace("www.lika.it", "www.example.com"));
    "menu-of-one-group" "The menu does not say which pages are protected."
        => |d| d.web.text(|text| text.replace("<h2>Password protected menus</h2>", ""));
    "pages-without-confirmation" "Pages that lead to a change open without asking."
        => |d| d.web.text(|text| text.replace(" onclick=\"return confirm('Are you sure?')\"", ""));
    "page-shows-defaults" "The information page shows the defaults, and not what the controller has sent."
        => |d| d.web.page(|view, request, page| match request.path.as_str() {
            "/information.htm" => web::information(&(view.facts.default_record)(&view.hardware)),
            _ => page,
        });
    "page-made-once" "The information page is made once and shown for ever."
        => |d| shows_first(d, "/information.htm");
    "page-shows-old-version" "The pages show the firmware before this one."
        => |d| d.web.page(|view, _, page| {
            let version = view.facts.software[0];
            with_text(page, |text| text.replace(&format!("<td>{version}</td>"), &format!("<td>{}</td>", version - 10)))
        });
    "page-shows-raw-position" "The position page shows the raw place."
        => |d| d.web.page(|view, request, page| match request.path.as_str() {
            "/position.htm" => web::position(view.measuring.with_settings(MeasuringSettings::hardware(&view.hardware)).position()),
            _ => page,
        });
    "page-position-frozen" "The position page shows for ever what it showed first."
        => |d| shows_first(d, "/position.htm");

    // Preset value
    "web-entry-decimal" "A preset value that is entered is taken as decimal."
        => |d| d.web.entered(|entry| entry.parse::<u32>().map_or("none".to_string(), |value| format!("{value:X}")));
    "web-entry-until-bad-digit" "A preset value that is entered is read up to the first character that is no digit."
        => |d| d.web.entered(|entry| {
            let digits = entry.bytes().take_while(u8::is_ascii_hexdigit).count();
            if digits == 0 { "0".to_string() } else { entry[..digits.min(8)].to_string() }
        });
    "web-entry-presets" "Entering a preset value carries out a preset."
        => |d| web_entry_presets(d);
    "web-entry-always-stored" "A preset value that is stored already is stored again."
        => |d| d.web.entry(|entry| Entry { is_stored: true, ..entry });
    "web-value-only-stored" "A preset value that is entered is used only after the next start."
        => |d| d.web.entry(|entry| Entry { is_used: false, ..entry });
    "web-value-not-stored" "A preset value that is entered is gone after the next start."
        => |d| d.web.entry(|entry| Entry { is_stored: false, ..entry });
    "web-value-apart" "The web server has a preset value of its own."
        => |d| web_value_apart(d);

    // Firmware upgrade
    "any-password" "Any password opens the firmware upgrade."
        => |d| d.web.set(Check::Password, true);
    "server-goes-on" "The web server goes on while the encoder waits for its firmware."
        => |d| d.web.set(Check::Serves, true);
};

/// The frames for which the signals stand still while a page is made.
const FROZEN_FRAMES: u32 = 5;

/// Serves from the first connection since power-up on.
#[derive(Default)]
struct WaitsForConnection {
    was_connected: bool,
}

impl WebHooks for WaitsForConnection {
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict && (check != Check::Serves || self.was_connected)
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
    d.web.page(move |_, request, page| match request.path == path {
        true => first.get_or_insert(page).clone(),
        false => page,
    });
}

fn web_value_apart(d: &mut Deviations) {
    let entered = Rc::new(Cell::new(None));
    let shown = entered.clone();
    d.web.entry(move |entry| {
        entered.set(Some(entry.value));
        Entry { is_used: false, is_stored: false, ..entry }
    });
    d.web.page(move |view, _, page| match shown.get() {
        Some(value) => {
            let right = format!("(hex): {:X}<", view.preset_value);
            with_text(page, |text| text.replace(&right, &format!("(hex): {value:X}<")))
        }
        None => page,
    });
}
