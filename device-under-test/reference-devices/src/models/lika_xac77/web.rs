//! The web pages of the XAC77. Manual, chapter 17.
//!
//! The manual prints neither the paths nor the looks of its pages, its figures are lost: all of that is invented here. So is
//! that a preset value is stored before the page says so, that an entry which is no hexadecimal number of up to 8 digits
//! changes nothing, and that a server which has stopped refuses connections.

use super::knobs::{Kept, Shown, Web};
use alloc::format;
use alloc::string::String;
use encoder_profile::encoder::{Direction, PresetMode};
use encoder_profile::encoder_object::{Live, Model};
use encoder_profile::facts::Effect;
use encoder_profile::profidrive::user_parameters::UserParameters;
use wire::http::{Request, Response};

const PRESET_TITLE: &str = "Change the preset value";

/// What the web server remembers until the power goes.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Whether there was a connection.
    pub was_connected: bool,
    /// Whether the encoder waits for its firmware.
    waits_for_firmware: bool,
    /// The user parameters that were shown first.
    information: Option<UserParameters>,
    /// The position that was shown first.
    position: Option<u64>,
    /// The preset value that was entered, where it goes nowhere else.
    entry: Option<u32>,
}

impl State {
    fn serves(&self, rules: &Web) -> bool {
        (rules.is_ready_alone || self.was_connected) && !(self.waits_for_firmware && rules.stops)
    }
}

impl Model for State {
    type Rules = Web;

    fn started(live: &mut Live<'_, State>) {
        live.model.was_connected = true;
    }

    fn power_up(live: &mut Live<'_, State>) {
        *live.model = State::default();
    }

    fn serves_pages(&self, rules: &Web) -> bool {
        self.serves(rules)
    }

    fn page(live: &mut Live<'_, State>, request: &Request) -> Response {
        answer(live, request)
    }
}

fn answer(live: &mut Live<'_, State>, request: &Request) -> Response {
    let takes = live.rules.takes;
    live.ram.held_up_until = live.ram.held_up_until.max(live.now + takes);
    let path = request.path.split('?').next().unwrap_or_default();
    match (request.method.as_str(), path) {
        ("GET", "/") => home(live),
        ("GET", "/information.htm") => information(live),
        ("GET", "/parameters.htm") => parameters(live),
        ("GET", "/position.htm") => position(live),
        ("GET", "/preset.htm") => preset_form(live),
        ("POST", "/preset.htm") => enter_preset_value(live, &request.field("value").unwrap_or_default()),
        ("GET", "/upgrade.htm") => upgrade_form(""),
        ("POST", "/upgrade.htm") => upgrade(live, &request.field("password").unwrap_or_default()),
        ("GET", _) => page(404, "Not found", ""),
        _ => page(405, "Not allowed", ""),
    }
}

fn home(live: &Live<'_, State>) -> Response {
    let rules = live.rules;
    let site = rules.site;
    let asks = if rules.confirms { " onclick=\"return confirm('Are you sure?')\"" } else { "" };
    let label = if rules.parts_menu { "<h2>Password protected menus</h2>" } else { "" };
    let body = format!(
        "<p><a href=\"http://{site}/\">website</a> <a href=\"http://{site}/eng/certificazioni.php\">certificates</a></p>\
         <ul><li><a href=\"/information.htm\">Encoder Information</a></li>\
         <li><a href=\"/parameters.htm\">Encoder Specific Profile Parameters</a></li>\
         <li><a href=\"/position.htm\">Encoder position</a></li>\
         <li><a href=\"/preset.htm\"{asks}>Change the preset value</a></li>\
         <li><a href=\"http://{site}/eng/prodotti.php?id_cat=267&amp;id_fam=270&amp;id_sfam=492\">technical documentation</a></li>\
         </ul>{label}<ul><li><a href=\"/upgrade.htm\"{asks}>Firmware upgrade</a></li></ul>"
    );
    page(200, "XAC77", &body)
}

fn information(live: &mut Live<'_, State>) -> Response {
    let user = match live.rules.information {
        Shown::InForce => live.ram.user,
        Shown::Default => live.behaviour.delivered(live.facts, &live.hardware),
        Shown::First => *live.model.information.get_or_insert(live.ram.user),
    };
    // As bits of the record, where 0 is "enabled" for two of them.
    let rows = [
        ("Code sequence", u64::from(user.direction == Direction::Counterclockwise)),
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

fn parameters(live: &Live<'_, State>) -> Response {
    let [version, year, day] = live.facts.software.map(u64::from);
    let version = (live.rules.version)(version);
    let rows = [("Firmware version", version), ("Firmware year", year), ("Firmware day and month", day)];
    page(200, "Encoder Specific Profile Parameters", &table(&rows))
}

fn position(live: &mut Live<'_, State>) -> Response {
    let rules = live.rules;
    if !rules.position_is_free {
        return page(401, "Encoder position", "<p>Password?</p>");
    }
    let place = live.hardware.sense(live.shaft.place(live.now));
    let mut position = (rules.position)(live.ram.measuring.shifted(), place);
    if !rules.position_is_present {
        position = *live.model.position.get_or_insert(position);
    }
    page(200, "Encoder position", &table(&[("Current position", position)]))
}

fn preset_form(live: &Live<'_, State>) -> Response {
    let value = live.model.entry.unwrap_or(live.ram.preset_value);
    let body = format!(
        "<p>Preset value (hex): {value:X}</p><form method=\"post\" action=\"/preset.htm\">\
         <input name=\"value\" maxlength=\"8\"><input type=\"submit\" value=\"Submit\"></form>"
    );
    page(200, PRESET_TITLE, &body)
}

fn enter_preset_value(live: &mut Live<'_, State>, entry: &str) -> Response {
    let rules = live.rules;
    let Some(value) = (rules.entry)(entry) else {
        return page(200, PRESET_TITLE, "<p>This is no hexadecimal number.</p>");
    };
    if live.faults.have(Effect::NoMemory, live.facts) {
        return page(200, PRESET_TITLE, "<p>The preset value could not be stored.</p>");
    }
    if rules.entry_presets {
        live.ram.measuring.offset = live.ram.measuring.preset(PresetMode::Absolute, value.into());
    }
    if matches!(rules.keeps, Kept::Everywhere | Kept::Used) {
        live.set_preset_value(value);
    }
    if rules.keeps == Kept::Apart {
        live.model.entry = Some(value);
    } else if rules.knows_stored && *live.store.preset_value.stored() == value {
        return page(200, PRESET_TITLE, "<p>This preset value is already stored.</p>");
    }
    if matches!(rules.keeps, Kept::Everywhere | Kept::Stored) {
        live.store.preset_value.replace(value);
    }
    page(200, PRESET_TITLE, "<p>The preset value is stored.</p>")
}

fn upgrade(live: &mut Live<'_, State>, password: &str) -> Response {
    if !(live.rules.is_password)(password) {
        return upgrade_form("<p>Wrong password.</p>");
    }
    live.model.waits_for_firmware = true;
    let body = "<p>The web server is stopped, the encoder waits for its firmware.</p>";
    Response::page(200, html("Firmware upgrade", " style=\"background-color: red\"", body))
}

fn upgrade_form(note: &str) -> Response {
    let body = format!(
        "{note}<form method=\"post\" action=\"/upgrade.htm\">Password <input type=\"password\" name=\"password\">\
         <input type=\"submit\" value=\"Submit\"></form>"
    );
    page(200, "Firmware upgrade", &body)
}

fn page(status: u16, title: &str, body: &str) -> Response {
    Response::page(status, html(title, "", body))
}

fn html(title: &str, look: &str, body: &str) -> String {
    format!("<!DOCTYPE html><html><head><title>{title}</title></head><body{look}><h1>{title}</h1>{body}</body></html>")
}

fn table(rows: &[(&str, u64)]) -> String {
    let rows = rows.iter().map(|(name, value)| format!("<tr><td>{name}</td><td>{value}</td></tr>"));
    format!("<table>{}</table>", rows.collect::<String>())
}
