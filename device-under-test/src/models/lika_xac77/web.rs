//! The web pages of the XAC77. Manual, chapter 17.
//!
//! The manual prints neither the paths nor the looks of its pages, its figures are lost: all of that is invented here. So is
//! that a preset value is stored before the page says so, that an entry which is no hexadecimal number of up to 8 digits
//! changes nothing, and that a server which has stopped refuses connections.

use crate::behaviour::{Behaviour, Kept, Shown, Web};
use crate::encoder::{Direction, PresetMode};
use crate::encoder_object::{Effect, Live, Model};
use crate::profidrive::user_parameters::UserParameters;
use alloc::format;
use alloc::string::String;
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
    fn started(live: &mut Live<'_, State>) {
        live.model.was_connected = true;
    }

    fn power_up(live: &mut Live<'_, State>) {
        *live.model = State::default();
    }

    fn serves_pages(&self, behaviour: &Behaviour) -> bool {
        self.serves(&behaviour.web)
    }

    fn page(live: &mut Live<'_, State>, request: &Request) -> Response {
        live.answer(request)
    }
}

impl Live<'_, State> {
    fn answer(&mut self, request: &Request) -> Response {
        let takes = self.behaviour.web.takes;
        self.ram.held_up_until = self.ram.held_up_until.max(self.now + takes);
        let path = request.path.split('?').next().unwrap_or_default();
        match (request.method.as_str(), path) {
            ("GET", "/") => self.home(),
            ("GET", "/information.htm") => self.information(),
            ("GET", "/parameters.htm") => self.parameters(),
            ("GET", "/position.htm") => self.position(),
            ("GET", "/preset.htm") => self.preset_form(),
            ("POST", "/preset.htm") => self.enter_preset_value(&request.field("value").unwrap_or_default()),
            ("GET", "/upgrade.htm") => upgrade_form(""),
            ("POST", "/upgrade.htm") => self.upgrade(&request.field("password").unwrap_or_default()),
            ("GET", _) => page(404, "Not found", ""),
            _ => page(405, "Not allowed", ""),
        }
    }

    fn home(&self) -> Response {
        let rules = &self.behaviour.web;
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

    fn information(&mut self) -> Response {
        let user = match self.behaviour.web.information {
            Shown::InForce => self.ram.user,
            Shown::Default => {
                let right = (self.facts.default_record)(&self.hardware);
                (self.behaviour.user_parameters.default)(right, &self.hardware)
            }
            Shown::First => *self.model.information.get_or_insert(self.ram.user),
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

    fn parameters(&self) -> Response {
        let [version, year, day] = self.facts.software.map(u64::from);
        let version = (self.behaviour.web.version)(version);
        let rows = [("Firmware version", version), ("Firmware year", year), ("Firmware day and month", day)];
        page(200, "Encoder Specific Profile Parameters", &table(&rows))
    }

    fn position(&mut self) -> Response {
        let rules = &self.behaviour.web;
        if !rules.position_is_free {
            return page(401, "Encoder position", "<p>Password?</p>");
        }
        let place = self.hardware.sense(self.shaft.place(self.now));
        let mut position = (rules.position)(self.ram.measuring.shifted(), place);
        if !rules.position_is_present {
            position = *self.model.position.get_or_insert(position);
        }
        page(200, "Encoder position", &table(&[("Current position", position)]))
    }

    fn preset_form(&self) -> Response {
        let value = self.model.entry.unwrap_or(self.ram.preset_value);
        let body = format!(
            "<p>Preset value (hex): {value:X}</p><form method=\"post\" action=\"/preset.htm\">\
             <input name=\"value\" maxlength=\"8\"><input type=\"submit\" value=\"Submit\"></form>"
        );
        page(200, PRESET_TITLE, &body)
    }

    fn enter_preset_value(&mut self, entry: &str) -> Response {
        let rules = &self.behaviour.web;
        let Some(value) = (rules.entry)(entry) else {
            return page(200, PRESET_TITLE, "<p>This is no hexadecimal number.</p>");
        };
        if self.faults.have(Effect::NoMemory, self.facts) {
            return page(200, PRESET_TITLE, "<p>The preset value could not be stored.</p>");
        }
        if rules.entry_presets {
            self.ram.measuring.offset = self.ram.measuring.preset(PresetMode::Absolute, value.into());
        }
        if matches!(rules.keeps, Kept::Everywhere | Kept::Used) {
            self.set_preset_value(value);
        }
        if rules.keeps == Kept::Apart {
            self.model.entry = Some(value);
        } else if rules.knows_stored && *self.store.preset_value.stored() == value {
            return page(200, PRESET_TITLE, "<p>This preset value is already stored.</p>");
        }
        if matches!(rules.keeps, Kept::Everywhere | Kept::Stored) {
            self.store.preset_value.replace(value);
        }
        page(200, PRESET_TITLE, "<p>The preset value is stored.</p>")
    }

    fn upgrade(&mut self, password: &str) -> Response {
        if !(self.behaviour.web.is_password)(password) {
            return upgrade_form("<p>Wrong password.</p>");
        }
        self.model.waits_for_firmware = true;
        let body = "<p>The web server is stopped, the encoder waits for its firmware.</p>";
        Response::page(200, html("Firmware upgrade", " style=\"background-color: red\"", body))
    }
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
