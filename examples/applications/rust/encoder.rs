//! An absolute encoder without a network stack, to be tested by encspec over standard input and output.
//!
//! On PROFINET it is an encoder of the encoder profile with telegram 81, on PROFIBUS one of class 2. The protocol is described in
//! `docs/application-protocol.md`. `--mistake NAME` makes it deviate on purpose.

use serde_json::{Value, json};
use std::collections::HashMap;
use std::io::{self, BufRead, Write};

/// Steps per revolution and revolutions of the hardware.
const STEPS: i64 = 8192;
const REVOLUTIONS: i64 = 4096;
const TOTAL: i64 = STEPS * REVOLUTIONS;
const SECOND: f64 = 1e9;
const FOREVER: u64 = 1 << 53;
/// Subslots of slot 1, and the records of the first.
const MAP: u64 = 1;
const TELEGRAM: u64 = 2;
const START_RECORD: u64 = 0xBF00;
const START_LENGTH: usize = 31;
const PARAMETERS: u64 = 0xB02E;
/// Bits of the start parameters.
const CODE_SEQUENCE: u8 = 1;
const CLASS_4: u8 = 2;
const PRESET_NOT_XIST1: u8 = 4;
const SCALING: u8 = 8;
const ALARMS: u8 = 16;
const NOT_COMPATIBLE: u8 = 32;
/// Codes in G1_XIST2.
const SENSOR_ERROR: u16 = 0x0001;
const PARKING_ERROR: u16 = 0x0003;
const LIFE_SIGN_ERROR: u16 = 0x0F02;
/// The faults that the stand can set, with their ChannelErrorType. The first one is that of the sensor.
const FAULTS: [(&str, u16); 3] = [("fault.sensor", 0x0009), ("fault.passing", 0x0005), ("fault.standing", 0x0006)];
/// Formats of parameters.
const WORD: u8 = 0x42;
const DOUBLE_WORD: u8 = 0x43;
const OCTETS: u8 = 0x0A;

const DESCRIPTION: &str = r#"{"version": 1, "name": "example encoder in Rust",
    "stand": ["shaft.speed", "shaft.counts", "turn", "fault.sensor", "fault.passing", "fault.standing"],
    "profinet": {"vendor_id": 65261, "device_id": 224, "station_type": "EXAMPLE ENCODER", "order_id": "EXAMPLE-81",
        "serial_number": "0001", "profile_id": 15616, "im_supported": 14, "ports": 2, "submodules": [
        {"slot": 0, "module_ident": 1, "subslot": 1, "submodule_ident": 1},
        {"slot": 1, "module_ident": 81, "subslot": 1, "submodule_ident": 2, "api": 15616},
        {"slot": 1, "module_ident": 81, "subslot": 2, "submodule_ident": 81, "api": 15616, "inputs": 12, "outputs": 4}]},
    "profibus": {"ident": 65261, "configuration": "D1E1", "dpv1": true, "fail_safe": true, "freeze": true, "sync": true,
        "set_address": true}}"#;

/// The shaft, in hardware steps without a limit: it turns steadily, or until it has reached a target.
#[derive(Default)]
struct Shaft {
    begin: u64,
    start: i64,
    rate: f64,
    end: u64,
    target: i64,
}

impl Shaft {
    fn standing(counts: i64) -> Shaft {
        Shaft { start: counts, target: counts, end: FOREVER, ..Shaft::default() }
    }

    fn at(&self, now: u64) -> i64 {
        if now >= self.end {
            return self.target;
        }
        self.start + (self.rate * (now - self.begin) as f64 / SECOND).floor() as i64
    }

    fn is_still(&self, now: u64) -> bool {
        self.rate == 0.0 || now >= self.end
    }

    fn speed(&mut self, now: u64, rpm: f64) {
        *self = Shaft { start: self.at(now), begin: now, rate: rpm * STEPS as f64 / 60.0, end: FOREVER, target: 0 };
    }

    /// Turns by a distance, and returns when it is done.
    fn turn(&mut self, now: u64, steps: f64, rpm: f64) -> u64 {
        self.speed(now, rpm.copysign(steps));
        self.target = self.start + steps.round() as i64;
        self.end = now + ((steps / self.rate).abs() * SECOND).ceil() as u64;
        self.end
    }
}

/// What the supply keeps: the offset and the preset value.
type Saved = (i64, u32);

/// The state of the connection.
#[derive(Default)]
struct Connection {
    stw2: u16,
    g1_stw: u16,
    is_preset: bool,
    sign: u16,
    last_sign: u16,
    account: u32,
    is_watched: bool,
    is_acknowledging: bool,
    is_parked: bool,
    errors: Vec<u16>,
}

/// A parameter: its number and format, whether it has subindices and can be written, and its values.
type Parameter = (u16, u8, bool, bool, Vec<u32>);

/// A value to write: size, count, bytes. Why a parameter is refused: error number and subindex.
type Written<'a> = Option<(usize, u8, &'a [u8])>;
type Refusal = (u16, Option<u16>);

/// What both buses share: settings, position and preset.
#[derive(Default)]
struct Encoder {
    mistake: String,
    shaft: Shaft,
    saved: Saved,
    memory: Saved,
    flags: u8,
    units: i64,
    range: i64,
    tolerated: u8,
    speed_unit: u8,
    faults: [bool; FAULTS.len()],
    changes: Vec<Value>,
    connection: Connection,
    responses: HashMap<u64, Vec<u8>>,
}

impl Encoder {
    fn deviates(&self, name: &str) -> bool {
        self.mistake == name
    }

    fn reset(&mut self, counts: i64) {
        *self = Encoder { mistake: std::mem::take(&mut self.mistake), ..Encoder::default() };
        self.shaft = Shaft::standing(counts);
        self.start_up();
    }

    /// Everything that is lost with the supply.
    fn start_up(&mut self) {
        (self.flags, self.units, self.range) = (CLASS_4 | SCALING | NOT_COMPATIBLE, STEPS, TOTAL);
        (self.tolerated, self.speed_unit) = (1, 0);
        self.memory = self.saved;
        self.responses.clear();
        self.begin_connection();
    }

    fn begin_connection(&mut self) {
        self.connection = Connection { errors: self.causes(), ..Connection::default() };
    }

    /// The errors whose cause is present.
    fn causes(&self) -> Vec<u16> {
        if self.faults[0] { vec![SENSOR_ERROR] } else { Vec::new() }
    }

    fn raise_if(&mut self, holds: bool, error: u16) {
        if holds && !self.connection.is_parked && !self.connection.errors.contains(&error) {
            self.connection.errors.push(error);
        }
    }

    /// Whether all of these bits are set in the start parameters.
    fn has(&self, flags: u8) -> bool {
        self.flags & flags == flags
    }

    fn is_scaled(&self) -> bool {
        self.has(CLASS_4 | SCALING)
    }

    fn span(&self) -> i64 {
        if self.is_scaled() { self.range } else { TOTAL }
    }

    fn measured(&self, now: u64) -> i64 {
        let is_reversed = self.has(CODE_SEQUENCE | CLASS_4) && !self.deviates("direction");
        let counts = if is_reversed { -self.shaft.at(now) } else { self.shaft.at(now) };
        let scaled = if self.is_scaled() { (counts * self.units).div_euclid(STEPS) } else { counts };
        scaled.rem_euclid(self.span())
    }

    fn position(&self, now: u64) -> i64 {
        let offset = if self.has(CLASS_4) { self.memory.0 } else { 0 };
        (self.measured(now) + offset).rem_euclid(self.span())
    }

    fn preset(&mut self, now: u64, value: i64, is_relative: bool) {
        let value = value + i64::from(self.deviates("preset"));
        let offset = if is_relative { self.memory.0 + value } else { value - self.measured(now) };
        self.memory.0 = offset.rem_euclid(self.span());
        self.saved.0 = self.memory.0;
    }

    /// Does an action of the stand, and returns when it is done.
    fn act(&mut self, now: u64, message: &Value) -> Option<u64> {
        let (name, value) = (message["name"].as_str()?, &message["value"]);
        match name {
            "shaft.speed" => self.shaft.speed(now, value.as_f64()?),
            "shaft.counts" => self.shaft = Shaft::standing(value.as_i64()?),
            "turn" => {
                let unit = if message["unit"] == "revolutions" { STEPS as f64 } else { 1.0 };
                return Some(self.shaft.turn(now, value.as_f64()? * unit, message["rpm"].as_f64()?));
            }
            _ => self.fault(FAULTS.iter().position(|(known, _)| *known == name)?, value.as_bool()?),
        }
        Some(now)
    }

    fn fault(&mut self, fault: usize, is_present: bool) {
        if self.faults[fault] == is_present || (!is_present && self.deviates("diagnosis")) {
            return;
        }
        self.faults[fault] = is_present;
        self.raise_if(fault == 0 && is_present, SENSOR_ERROR);
        if fault != 0 || self.has(ALARMS) {
            self.report(fault, is_present);
        }
    }

    fn report(&mut self, fault: usize, appears: bool) {
        let error_type = FAULTS[fault].1;
        self.changes.push(json!({ "appears": appears, "slot": 1, "subslot": MAP, "error_type": error_type }));
    }

    // Signals of telegram 81.

    fn outputs(&mut self, now: u64, data: Option<&[u8]>) {
        let word = data.map_or(0, number);
        let (stw2, request) = ((word >> 16) as u16, word as u16);
        if data.is_some() {
            self.watch(stw2 >> 12);
        }
        // Without control by PLC no request is valid.
        let request = if self.has(NOT_COMPATIBLE) && stw2 & 0x0400 == 0 { 0 } else { request };
        let (new, is_still) = (request & !self.connection.g1_stw, self.shaft.is_still(now));
        let parks = new & 0x4000 != 0 && is_still;
        self.raise_if(new & 0x4000 != 0 && !is_still, PARKING_ERROR);
        let connection = &mut self.connection;
        connection.is_parked = request & 0x4000 != 0 && (connection.is_parked || parks);
        if parks {
            (connection.is_acknowledging, connection.is_preset) = (false, false);
            connection.errors.clear();
        }
        let is_parked = connection.is_parked;
        if new & 0x1000 != 0 && !is_parked && self.has(CLASS_4) {
            self.preset(now, self.memory.1.into(), request & 0x0800 != 0);
            self.connection.is_preset = true;
        }
        self.connection.is_preset &= request & 0x1000 != 0;
        if new & 0x8000 != 0 && !is_parked && !self.connection.errors.is_empty() {
            self.connection.is_acknowledging = true;
        } else if request & 0x8000 == 0 && self.connection.is_acknowledging {
            self.connection.is_acknowledging = false;
            self.connection.errors = self.causes();
        }
        (self.connection.stw2, self.connection.g1_stw) = (stw2, request);
    }

    /// The sign of life of the controller: a failure weighs ten times as much as a good one.
    fn watch(&mut self, sign: u16) {
        let limit = if self.has(NOT_COMPATIBLE) { 10 } else { u32::from(self.tolerated) * 10 };
        let connection = &mut self.connection;
        let last = std::mem::replace(&mut connection.last_sign, sign);
        if !connection.is_watched {
            connection.is_watched = sign != 0;
            return;
        }
        let is_next = sign == last % 15 + 1;
        let account = connection.account;
        connection.account = if is_next { account.saturating_sub(1) } else { (account + 10).min(limit + 1) };
        let has_failed = connection.account > limit;
        self.raise_if(has_failed, LIFE_SIGN_ERROR);
    }

    fn inputs(&mut self, now: u64) -> String {
        self.connection.sign = self.connection.sign % 15 + 1;
        let Connection { sign, stw2, g1_stw, is_preset, is_acknowledging, is_parked, .. } = self.connection;
        let error = self.connection.errors.first().copied();
        let bit = |number: u16, holds: bool| u16::from(holds) << number;
        let zsw2 = sign << 12 | bit(9, self.has(NOT_COMPATIBLE) && stw2 & 0x0400 != 0);
        let position = if is_parked { 0 } else { self.position(now) };
        let xist1 = if self.has(PRESET_NOT_XIST1) && !is_parked { self.measured(now) } else { position };
        // With the mistake the second error does not end the transfer of the absolute value.
        let is_hidden = error.is_some() && !(self.deviates("sequence") && self.connection.errors.len() > 1);
        let is_shown = !is_hidden && !is_parked && g1_stw & 0x2000 != 0;
        let xist2 = error.map_or(if is_shown { position } else { 0 }, i64::from);
        let low = bit(11, is_acknowledging) | bit(12, is_preset) | bit(13, is_shown);
        let g1_zsw = low | bit(14, is_parked) | bit(15, error.is_some());
        format!("{zsw2:04X}{g1_zsw:04X}{xist1:08X}{xist2:08X}")
    }

    // Records: start parameters, and base mode parameter access.

    /// Applies flags, units per revolution and range, if they are valid.
    fn apply(&mut self, flags: u8, units: u32, range: u32) -> bool {
        let (units, range) = (i64::from(units), i64::from(range));
        let is_valid = (1..=STEPS).contains(&units) && (2..=units * REVOLUTIONS).contains(&range);
        if flags & CLASS_4 != 0 && flags & SCALING != 0 && !is_valid {
            return false;
        }
        (self.flags, self.units, self.range) = (flags, units, range);
        true
    }

    fn start_parameters(&mut self, data: &[u8]) -> Result<(), &'static str> {
        if data.len() != START_LENGTH {
            return Err("write_length_error");
        }
        let is_used = data[0] & (CLASS_4 | SCALING) == CLASS_4 | SCALING;
        let is_small = !is_used || number(&data[1..5]) == 0 && number(&data[9..13]) == 0;
        let is_valid = is_small && data[17] >= 1 && data[18] <= 3;
        if !is_valid || !self.apply(data[0], number(&data[5..9]), number(&data[13..17])) {
            return Err("invalid_parameter");
        }
        (self.tolerated, self.speed_unit) = (data[17], data[18]);
        Ok(())
    }

    fn write_record(&mut self, place: (u64, u64), connection: u64, data: &[u8]) -> Result<(), &'static str> {
        match place {
            (MAP, START_RECORD) => self.start_parameters(data),
            (MAP, PARAMETERS) if !is_request(data) => Err("write_length_error"),
            (MAP, PARAMETERS) => {
                let response = self.respond(data);
                self.responses.insert(connection, response);
                Ok(())
            }
            _ => Err("invalid_index"),
        }
    }

    fn read_record(&mut self, place: (u64, u64), connection: u64) -> Result<Vec<u8>, &'static str> {
        match place {
            (MAP, START_RECORD) => {
                let words = [self.units as u64, self.range as u64].map(u64::to_be_bytes).concat();
                let mut record = [&[self.flags], words.as_slice(), &[self.tolerated, self.speed_unit]].concat();
                record.resize(START_LENGTH, 0);
                Ok(record)
            }
            (MAP, PARAMETERS) => self.responses.remove(&connection).ok_or("state_conflict"),
            _ if self.deviates("record") => Ok(vec![0]),
            _ => Err("invalid_index"),
        }
    }

    fn parameters(&self) -> Vec<Parameter> {
        let format = vec![0x5011, 0x8000_0000, STEPS as u32, 0, 0, REVOLUTIONS as u32];
        let (fault, offset) = (u32::from(self.faults[0]), self.memory.0 as u32);
        let (flags, units, range) = (self.flags.into(), self.units as u32, self.range as u32);
        let (unit, version) = (self.speed_unit.into(), if self.has(NOT_COMPATIBLE) { 41 } else { 31 });
        let status = vec![0x000C_0101, flags, fault, 0x31, 0, 0, 0x0101_0000, u32::MAX, offset, units, range, unit];
        let listed = vec![922, 925, 964, 965, 971, 974, 975, 979, 65000, 65001, 0];
        vec![
            (922, WORD, false, false, vec![81]),
            (925, WORD, false, true, vec![self.tolerated.into()]),
            (964, WORD, true, false, vec![0xFEED, 1, 100, 2026, 2811, 1]),
            (965, OCTETS, false, false, vec![0x3D, version]),
            (971, WORD, false, true, vec![0]),
            (974, WORD, true, false, vec![240, 39, 0]),
            (975, WORD, true, false, vec![0xFEED, 1, 100, 2026, 2811, 0x0005, 0x8000, 1]),
            (979, DOUBLE_WORD, true, false, format),
            (980, WORD, true, false, listed),
            (65000, DOUBLE_WORD, false, true, vec![self.memory.1]),
            (65001, DOUBLE_WORD, true, false, status),
        ]
    }

    fn respond(&mut self, data: &[u8]) -> Vec<u8> {
        let (addresses, mut rest) = data[4..].split_at(6 * usize::from(data[3]));
        let (mut body, mut has_error) = (Vec::new(), false);
        for (index, address) in addresses.chunks(6).enumerate() {
            let left = usize::from(data[3]) - index - 1;
            let mut value = None;
            if let (2, [format, count, values @ ..]) = (data[1], rest) {
                let octets = usize::from(*count) * size(*format);
                value = values.get(..octets).map(|octets| (size(*format), *count, octets));
                rest = values.get(octets + octets % 2..).unwrap_or_default();
            }
            match self.access(data, address, value) {
                Ok(part) if body.len() + part.len() + 6 * left <= 236 => body.extend(part),
                // The response would be too long.
                other => {
                    let (error, place) = other.err().unwrap_or((0x15, None));
                    has_error = true;
                    body.extend([0x44, 1 + u8::from(place.is_some())]);
                    body.extend([Some(error), place].into_iter().flatten().flat_map(u16::to_be_bytes));
                }
            }
        }
        if data[1] == 2 && !has_error {
            body.clear();
        }
        let kind = if data[1] == 2 { 2 } else { 1 } | u8::from(has_error) << 7;
        [&[data[0], kind, data[2], data[3]], body.as_slice()].concat()
    }

    /// One parameter of a request: its part of the response, or an error number and the subindex of the error.
    fn access(&mut self, request: &[u8], address: &[u8], value: Written<'_>) -> Result<Vec<u8>, Refusal> {
        let (kind, elements) = (request[1], usize::from(address[1]));
        let (id, subindex) = (number(&address[2..4]), number(&address[4..6]) as usize);
        let known = self.parameters().into_iter().find(|known| u32::from(known.0) == id);
        let refusal = match &known {
            _ if ![1, 2].contains(&kind) => Some(0x21),
            _ if request[2] > 1 => Some(0x19),
            None => Some(0x00),
            _ if address[0] != 0x10 => Some(0x16),
            Some(known) if kind == 2 && !known.3 => Some(0x01),
            Some(known) if !known.2 && (subindex > 0 || elements > 1) => Some(0x04),
            Some(_) => None,
        };
        let refused = |error| Err((error, None));
        let (Some((id, format, .., values)), None) = (known, refusal) else { return refused(refusal.unwrap_or(0x00)) };
        let count = if format == OCTETS { values.len() } else { elements.max(1) };
        let Some(addressed) = values.get(subindex..subindex + count) else {
            return Err((0x03, Some(subindex.max(values.len()) as u16)));
        };
        let width = size(format);
        if kind == 1 {
            let mut part = vec![format, count as u8];
            part.extend(addressed.iter().flat_map(|value| value.to_be_bytes()[4 - width..].to_vec()));
            part.resize(part.len().next_multiple_of(2), 0);
            return Ok(part);
        }
        match value {
            None | Some((0, ..)) => refused(0x17),
            Some((_, count, _)) if count != 1 => refused(0x18),
            Some((size, ..)) if size != width => refused(0x05),
            Some((.., octets)) if self.write(id, number(octets)) => Ok(vec![0x40, 0]),
            Some(_) => refused(0x02),
        }
    }

    fn write(&mut self, id: u16, value: u32) -> bool {
        match id {
            925 if (1..=255).contains(&value) => self.tolerated = value as u8,
            971 if value <= 1 => self.saved = self.memory,
            65000 if i64::from(value) < self.span() => self.memory.1 = value,
            _ => return false,
        }
        true
    }

    // PROFIBUS, class 2.

    /// Bit 31 requests a preset to the value in the other bits.
    fn dp_outputs(&mut self, now: u64, data: Option<&[u8]>) {
        let word = data.map_or(0, number);
        let is_held = std::mem::replace(&mut self.connection.is_preset, word >> 31 != 0);
        if self.connection.is_preset && !is_held {
            self.preset(now, i64::from(word & 0x7FFF_FFFF) % self.span(), false);
            self.saved.0 = self.memory.0;
        }
    }

    fn dp_diagnosis(&self) -> (String, bool) {
        let is_faulty = self.faults.contains(&true);
        let head = format!("33{:02X}{:02X}01{STEPS:08X}{REVOLUTIONS:04X}", u8::from(is_faulty), self.flags & 0x0F);
        let settings = format!("{:08X}00000000{:08X}{:08X}", self.memory.0, self.units, self.range);
        (format!("{head}0000010000000001100100FFFFFFFF{settings}30303030303030303031"), is_faulty)
    }

    /// The fields of an answer, beside the word of the message.
    fn answer(&mut self, word: &str, message: &Value) -> Value {
        let now = message["now"].as_u64().unwrap_or_default();
        let whole = |key: &str| message[key].as_u64().unwrap_or_default();
        let wants_inputs = message["inputs"] == true;
        let place = (whole("subslot"), whole("index"));
        let data = bytes(&message["data"]).unwrap_or_default();
        match word {
            "cycle" => {
                for outputs in message["outputs"].as_array().into_iter().flatten() {
                    self.outputs(outputs["at"].as_u64().unwrap_or(now), bytes(&outputs["data"]).as_deref());
                }
                if wants_inputs {
                    let (data, good) = (self.inputs(now), !self.faults[0]);
                    return json!({ "inputs": [{ "slot": 1, "subslot": TELEGRAM, "data": data, "good": good }] });
                }
            }
            "data_exchange" => {
                if message.get("outputs").is_some() {
                    self.dp_outputs(now, bytes(&message["outputs"]).as_deref());
                }
                if wants_inputs {
                    let until = if self.shaft.is_still(now) { FOREVER } else { 0 };
                    return json!({ "data": format!("{:08X}", self.position(now)), "constant_until": until });
                }
            }
            "hello" => return json!({ "description": serde_json::from_str::<Value>(DESCRIPTION).ok() }),
            "reset" => self.reset(message["shaft"].as_i64().unwrap_or_default()),
            "power_up" => {
                self.start_up();
                let present = (0..FAULTS.len()).filter(|fault| self.faults[*fault]).collect::<Vec<_>>();
                present.into_iter().for_each(|fault| self.report(fault, true));
            }
            "connect" | "exchange_begins" => self.begin_connection(),
            "disconnect" => drop(self.responses.remove(&whole("connection"))),
            "read_record" => {
                let data = self.read_record(place, whole("connection"));
                return data.map_or_else(|refused| json!({ "refused": refused }), |data| json!({ "data": hex(&data) }));
            }
            "write_record" => {
                let written = self.write_record(place, whole("connection"), &data);
                return written.map_or_else(|refused| json!({ "refused": refused }), |()| json!({}));
            }
            "factory_reset" => match message["scope"].as_str().unwrap_or_default() {
                "engineering" | "factory_image" | "other" => {}
                scope => {
                    if scope != "communication" {
                        (self.saved, self.memory) = Default::default();
                    }
                    return json!({ "done": now });
                }
            },
            "set_prm" => {
                return json!({ "accepted": data.len() == 14 && self.apply(data[3], number(&data[4..8]), number(&data[8..12])) });
            }
            "chk_cfg" => {
                let is_right = data == [0xD1, 0xE1] || self.deviates("configuration");
                return json!({ "accepted": is_right, "input_length": 4, "output_length": 4 });
            }
            "diagnosis" => {
                let (data, ext_diag) = self.dp_diagnosis();
                return json!({ "data": data, "ext_diag": ext_diag });
            }
            "act" => return self.act(now, message).map_or(json!({}), |done| json!({ "done": done })),
            _ => {}
        }
        json!({})
    }
}

/// Whether the bytes are a request for 1 to 39 parameters.
fn is_request(data: &[u8]) -> bool {
    let count = data.get(3).map_or(0, |count| usize::from(*count));
    (1..=39).contains(&count) && data.len() >= 4 + 6 * count
}

/// The bytes of each value of a format.
fn size(format: u8) -> usize {
    match format {
        0x41 | 0x05 | 0x02 | OCTETS => 1,
        WORD | 0x06 | 0x03 => 2,
        DOUBLE_WORD | 0x07 | 0x04 => 4,
        _ => 0,
    }
}

fn number(octets: &[u8]) -> u32 {
    octets.iter().fold(0, |number, octet| number << 8 | u32::from(*octet))
}

fn bytes(text: &Value) -> Option<Vec<u8>> {
    let text = text.as_str()?;
    (0..text.len() / 2).map(|at| u8::from_str_radix(text.get(2 * at..2 * at + 2)?, 16).ok()).collect()
}

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect()
}

fn main() -> io::Result<()> {
    let mistake = std::env::args().skip_while(|word| word != "--mistake").nth(1).unwrap_or_default();
    let mut encoder = Encoder { mistake, ..Encoder::default() };
    let (mut is_profinet, mut out) = (true, io::stdout().lock());
    for line in io::stdin().lock().lines() {
        let message: Value = serde_json::from_str(&line?)?;
        let word = message["message"].as_str().unwrap_or_default();
        is_profinet = if word == "hello" { message["bus"] == "profinet" } else { is_profinet };
        let mut answer = encoder.answer(word, &message);
        answer["answer"] = word.into();
        let changes = std::mem::take(&mut encoder.changes);
        if is_profinet && !changes.is_empty() {
            answer["diagnosis"] = changes.into();
        } else if !changes.is_empty() {
            answer["diagnosis_changed"] = true.into();
        }
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}
