//! The web pages of the XAC77. Manual, chapter 17.
//!
//! The manual prints neither the paths nor the layout of its pages, and its figures are missing; all of that is invented. Also
//! invented: a preset value is stored before the page reports it, an entry that is not a hexadecimal number of up to 8 digits
//! changes nothing, and a stopped server refuses connections.

use super::hooks::{PresetEntry, WebCheck, WebDeviations};
use alloc::format;
use alloc::string::String;
use encoder_profile::encoder::CountingDirection;
use encoder_profile::encoder_object::{EncoderModel, PoweredEncoder};
use encoder_profile::facts::FaultEffect;
use encoder_profile::profidrive::user_parameters::UserParameterData;
use wire::http::{HttpRequest, HttpResponse};

/// The site of the vendor, the target of links.
const SITE: &str = "www.lika.it";
/// The password of the firmware upgrade: manual, 17.1.
const PASSWORD: &str = "lika";
const PRESET_TITLE: &str = "Change the preset value";

/// The web server: manual, chapter 17.
#[derive(Clone, Debug, Default)]
pub struct Xac77State {
    hooks: WebDeviations,
    /// Whether the encoder waits for new firmware, until power-off.
    waits_for_firmware: bool,
}

impl Xac77State {
    /// Creates a web server with these hooks.
    pub fn new(hooks: WebDeviations) -> Xac77State {
        Xac77State { hooks, ..Xac77State::default() }
    }
}

impl EncoderModel for Xac77State {
    fn started(live: &mut PoweredEncoder<'_, Xac77State>) {
        live.model.hooks.0.notify(|hooks| hooks.connected());
    }

    fn power_up(live: &mut PoweredEncoder<'_, Xac77State>) {
        live.model.waits_for_firmware = false;
        live.model.hooks.0.notify(|hooks| hooks.powered_up());
    }

    fn serves_pages(&self) -> bool {
        self.hooks.check(WebCheck::AcceptsConnections, !self.waits_for_firmware)
    }

    fn page(live: &mut PoweredEncoder<'_, Xac77State>, request: &HttpRequest) -> HttpResponse {
        let hooks = live.model.hooks.0.clone();
        let mut request = request.clone();
        hooks.notify(|hooks| hooks.request(&mut request));
        let page = answer(live, &request);
        hooks.apply(page, |hooks, page| hooks.page(&live.view(), &request, page))
    }
}

fn answer(live: &mut PoweredEncoder<'_, Xac77State>, request: &HttpRequest) -> HttpResponse {
    let path = request.path.split('?').next().unwrap_or_default();
    match (request.method.as_str(), path) {
        ("GET", "/") => home(),
        ("GET", "/information.htm") => information(&live.ram.user),
        ("GET", "/parameters.htm") => parameters(live),
        ("GET", "/position.htm") => position(live.ram.measuring.shifted()),
        ("GET", "/preset.htm") => preset_form(live),
        ("POST", "/preset.htm") => enter_preset_value(live, &request.field("value").unwrap_or_default()),
        ("GET", "/upgrade.htm") => upgrade_form(""),
        ("POST", "/upgrade.htm") => upgrade(live, &request.field("password").unwrap_or_default()),
        ("GET", _) => page(404, "Not found", ""),
        _ => page(405, "Not allowed", ""),
    }
}

fn home() -> HttpResponse {
    let confirm = " onclick=\"return confirm('Are you sure?')\"";
    let body = format!(
        "<p><a href=\"http://{SITE}/\">website</a> <a href=\"http://{SITE}/eng/certificazioni.php\">certificates</a></p>\
         <ul><li><a href=\"/information.htm\">Encoder Information</a></li>\
         <li><a href=\"/parameters.htm\">Encoder Specific Profile Parameters</a></li>\
         <li><a href=\"/position.htm\">Encoder position</a></li>\
         <li><a href=\"/preset.htm\"{confirm}>Change the preset value</a></li>\
         <li><a href=\"http://{SITE}/eng/prodotti.php?id_cat=267&amp;id_fam=270&amp;id_sfam=492\">technical documentation</a></li>\
         </ul><h2>Password protected menus</h2><ul><li><a href=\"/upgrade.htm\"{confirm}>Firmware upgrade</a></li></ul>"
    );
    page(200, "XAC77", &body)
}

/// Writes the information page with these user parameters.
pub fn information(user: &UserParameterData) -> HttpResponse {
    // As bits of the record, where 0 is "enabled" for two of them.
    let rows = [
        ("Code sequence", u64::from(user.direction == CountingDirection::Counterclockwise)),
        ("Class 4 functionality", user.class_4.into()),
        ("G1_XIST1 preset control", (!user.preset_acts_on_xist1).into()),
        ("Scaling function control", user.scaling.into()),
        ("Alarm channel control", user.alarm_channel.into()),
        ("Compatibility mode", (!user.compatible).into()),
        ("Measuring units / Revolution", user.units_per_revolution),
        ("Total measuring range", user.range),
        ("Maximum Master Sign-Of-Life failures", user.life_sign_failures.into()),
        ("Velocity measuring units", user.speed_unit.into()),
    ];
    page(200, "Encoder Information", &table(&rows))
}

fn parameters(live: &PoweredEncoder<'_, Xac77State>) -> HttpResponse {
    let [version, year, day] = live.facts.software.map(u64::from);
    let rows = [("Firmware version", version), ("Firmware year", year), ("Firmware day and month", day)];
    page(200, "Encoder Specific Profile Parameters", &table(&rows))
}

/// Writes the position page.
pub fn position(position: u64) -> HttpResponse {
    page(200, "Encoder position", &table(&[("Current position", position)]))
}

fn preset_form(live: &PoweredEncoder<'_, Xac77State>) -> HttpResponse {
    let value = live.ram.preset_value;
    let body = format!(
        "<p>Preset value (hex): {value:X}</p><form method=\"post\" action=\"/preset.htm\">\
         <input name=\"value\" maxlength=\"8\"><input type=\"submit\" value=\"Submit\"></form>"
    );
    page(200, PRESET_TITLE, &body)
}

/// Processes an entry on the preset page: manual, 17.2, step 4.
fn enter_preset_value(live: &mut PoweredEncoder<'_, Xac77State>, entry: &str) -> HttpResponse {
    let Some(value) = hexadecimal(entry) else {
        return page(200, PRESET_TITLE, "<p>This is no hexadecimal number.</p>");
    };
    if live.faults.have(FaultEffect::NoMemory, live.facts) {
        return page(200, PRESET_TITLE, "<p>The preset value could not be stored.</p>");
    }
    let is_known = *live.store.preset_value.stored() == value;
    let entry = PresetEntry { value, is_used: true, is_stored: !is_known };
    let entry = live.model.hooks.0.apply(entry, |hooks, entry| hooks.entry(entry));
    if entry.is_used {
        live.set_preset_value(value);
    }
    if entry.is_stored {
        live.store.preset_value.replace(value);
    } else if is_known {
        return page(200, PRESET_TITLE, "<p>This preset value is already stored.</p>");
    }
    page(200, PRESET_TITLE, "<p>The preset value is stored.</p>")
}

/// Parses one to eight hexadecimal digits.
fn hexadecimal(entry: &str) -> Option<u32> {
    let is_number = (1..=8).contains(&entry.len()) && entry.bytes().all(|octet| octet.is_ascii_hexdigit());
    u32::from_str_radix(entry, 16).ok().filter(|_| is_number)
}

fn upgrade(live: &mut PoweredEncoder<'_, Xac77State>, password: &str) -> HttpResponse {
    if !live.model.hooks.check(WebCheck::Password, password == PASSWORD) {
        return upgrade_form("<p>Wrong password.</p>");
    }
    live.model.waits_for_firmware = true;
    let body = "<p>The web server is stopped, the encoder waits for its firmware.</p>";
    HttpResponse::page(200, html("Firmware upgrade", " style=\"background-color: red\"", body))
}

fn upgrade_form(note: &str) -> HttpResponse {
    let body = format!(
        "{note}<form method=\"post\" action=\"/upgrade.htm\">Password <input type=\"password\" name=\"password\">\
         <input type=\"submit\" value=\"Submit\"></form>"
    );
    page(200, "Firmware upgrade", &body)
}

fn page(status: u16, title: &str, body: &str) -> HttpResponse {
    HttpResponse::page(status, html(title, "", body))
}

fn html(title: &str, style: &str, body: &str) -> String {
    format!("<!DOCTYPE html><html><head><title>{title}</title></head><body{style}><h1>{title}</h1>{body}</body></html>")
}

fn table(rows: &[(&str, u64)]) -> String {
    let rows = rows.iter().map(|(name, value)| format!("<tr><td>{name}</td><td>{value}</td></tr>"));
    format!("<table>{}</table>", rows.collect::<String>())
}
