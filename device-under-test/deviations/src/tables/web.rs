//! Bugs of the web server.

use super::Deviation;
use super::stack_memory::PagesStay;
use core::time::Duration;
use reference_devices::models::lika_xac77::knobs::{Kept, Shown};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Server
    "web-waits-for-connection" "The web server answers only after the first connection."
        => |b| b.web.is_ready_alone = false;
    "web-at-fixed-address" "The web server answers only at the first address that the device had."
        => |d| d.stack.add(PagesStay::default());
    "password-for-every-page" "The position page asks for a password."
        => |b| b.web.position_is_free = false;
    "page-freezes-position" "While a page is made the signals of the telegram stand still."
        => |b| b.web.takes = Duration::from_millis(20);

    // What is shown
    "links-of-another-vendor" "The links lead to another vendor."
        => |b| b.web.site = "www.example.com";
    "menu-of-one-group" "The menu does not say which pages are protected."
        => |b| b.web.parts_menu = false;
    "pages-without-confirmation" "Pages that lead to a change open without asking."
        => |b| b.web.confirms = false;
    "page-shows-defaults" "The information page shows the defaults, and not what the controller has sent."
        => |b| b.web.information = Shown::Default;
    "page-made-once" "The information page is made once and shown for ever."
        => |b| b.web.information = Shown::First;
    "page-shows-old-version" "The pages show the firmware before this one."
        => |b| b.web.version = |version| version - 10;
    "page-shows-raw-position" "The position page shows the raw place."
        => |b| b.web.position = |_, place| place;
    "page-position-frozen" "The position page shows for ever what it showed first."
        => |b| b.web.position_is_present = false;

    // Preset value
    "web-entry-decimal" "A preset value that is entered is taken as decimal."
        => |b| b.web.entry = |entry| entry.parse().ok();
    "web-entry-until-bad-digit" "A preset value that is entered is read up to the first character that is no digit."
        => |b| b.web.entry = until_bad_digit;
    "web-entry-presets" "Entering a preset value carries out a preset."
        => |b| b.web.entry_presets = true;
    "web-entry-always-stored" "A preset value that is stored already is stored again."
        => |b| b.web.knows_stored = false;
    "web-value-only-stored" "A preset value that is entered is used only after the next start."
        => |b| b.web.keeps = Kept::Stored;
    "web-value-not-stored" "A preset value that is entered is gone after the next start."
        => |b| b.web.keeps = Kept::Used;
    "web-value-apart" "The web server has a preset value of its own."
        => |b| b.web.keeps = Kept::Apart;

    // Firmware upgrade
    "any-password" "Any password opens the firmware upgrade."
        => |b| b.web.is_password = |_| true;
    "server-goes-on" "The web server goes on while the encoder waits for its firmware."
        => |b| b.web.stops = false;
};

fn until_bad_digit(entry: &str) -> Option<u32> {
    let digits = entry.bytes().take_while(u8::is_ascii_hexdigit).count();
    Some(u32::from_str_radix(&entry[..digits.min(8)], 16).unwrap_or(0))
}
