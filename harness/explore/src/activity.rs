//! What happens within a connection: pulses, requests, pauses, and what the stand does, each at its time.

use crate::draw::Draw;
use crate::names::{ModuleNames, OutputChoices, SequenceNames};
use crate::requests;
use crate::schedule::Schedule;
use crate::stand::speed;
use compare::action::ControllerAction;
use controllers::{profibus_dp, profinet_io};

/// The longest pulse in cycles.
const LONGEST_PULSE: u64 = 30;
/// The most parameters in one request.
const MOST_PARAMETERS: u64 = 4;

/// Draws activities within a connection of this many cycles.
pub(crate) struct Activities<'a> {
    pub names: &'a SequenceNames,
    pub module: &'a ModuleNames,
    pub length: u64,
    /// Whether everything is drawn that the suite language can say, broken requests too.
    pub is_broad: bool,
}

impl Activities<'_> {
    /// Adds one activity.
    pub fn add(&self, draw: &mut Draw, to: &mut Schedule) {
        let at = draw.between(1, self.length);
        if self.is_broad && draw.chance(self.names.share_of_requests) {
            if let Some(step) = requests::draw(self.names, &self.module.name, draw) {
                to.add(at, step);
            }
            return;
        }
        match draw.between(0, 99) {
            0..=59 => self.pulse(draw, to, at),
            60..=69 => self.parameters(draw, to, at),
            70..=73 => self.records_and_pages(draw, to, at),
            74..=77 => self.service(draw, to, at),
            78..=83 => self.lost_frames(draw, to, at),
            84..=89 => self.shaft(draw, to, at),
            90..=95 => self.stand(draw, to, at),
            96..=98 => self.controller(draw, to, at),
            _ => to.add(at, damaged(draw, self.names.on_profinet)),
        }
    }

    /// The outputs that hold for the whole sequence.
    pub fn hold(&self, draw: &mut Draw, to: &mut Schedule) {
        for output in &self.module.outputs {
            let held = draw.chance(output.held_percent);
            if held && !matches!(output.values, OutputChoices::Counter) {
                to.set(0, &output.name, output.values.draw(draw));
            }
        }
    }

    /// An output for 1 to 30 cycles; now and then one that stays, or one that is taken back for a while.
    fn pulse(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let Some(output) = draw.weighted(&self.module.outputs, |of| of.weight) else { return };
        let (value, rest) = (output.values.draw(draw), output.values.rest());
        let until = at + length_of_pulse(draw);
        match draw.between(0, 9) {
            0 => to.set(at, &output.name, value),
            1 => {
                to.set(at, &output.name, rest);
                to.set(until, &output.name, value);
            }
            _ => {
                to.set(at, &output.name, value);
                to.set(until, &output.name, rest);
            }
        }
    }

    fn parameters(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let count = if draw.chance(70) { 1 } else { draw.between(2, MOST_PARAMETERS) };
        let action = if draw.chance(55) {
            let mut entries: Vec<(String, String)> = Vec::new();
            for _ in 0..count {
                let Some((name, width)) = draw.one(&self.names.writable) else { return };
                if !entries.iter().any(|(known, _)| known == name) {
                    entries.push((name.clone(), draw.number(*width).to_string()));
                }
            }
            ControllerAction::Write(entries)
        } else {
            let mut names: Vec<String> = Vec::new();
            for _ in 0..count {
                let Some(name) = draw.one(&self.names.readable) else { return };
                if !names.contains(name) {
                    names.push(name.clone());
                }
            }
            ControllerAction::Read(names)
        };
        to.add(at, action);
    }

    fn records_and_pages(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let field = draw.one(&self.names.record_fields).map(|name| ControllerAction::Read(vec![name.clone()]));
        let page = draw.one(&self.names.pages).map(|(page, fields)| match fields.first() {
            Some(field) if draw.chance(50) => {
                let value = draw.number(32);
                send("http_post", &format!("{{ page: {page}, fields: {{ {field}: '{value}' }} }}"))
            }
            _ => send("http_get", &format!("{{ page: {page} }}")),
        });
        let both: Vec<ControllerAction> = field.into_iter().chain(page).collect();
        if let Some(action) = draw.one(&both) {
            to.add(at, action.clone());
        }
    }

    fn service(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let (name, fields) = if self.names.on_profinet {
            let services =
                [("dcp_identify", "{ who: all }"), ("dcp_identify", "{ who: own_name }"), ("dcp_signal", "{}")];
            *draw.one(&services).unwrap_or(&services[0])
        } else {
            let services = [
                ("fdl_status", "{}"),
                ("slave_diag", "{}"),
                ("get_cfg", "{}"),
                ("read_inputs", "{}"),
                ("read_outputs", "{}"),
                ("global_control", "{ freeze: 1 }"),
                ("global_control", "{ unfreeze: 1 }"),
                ("global_control", "{ sync: 1 }"),
                ("global_control", "{ unsync: 1 }"),
                ("global_control", "{ clear: 1 }"),
                ("global_control", "{ clear: 0 }"),
            ];
            *draw.one(&services).unwrap_or(&services[0])
        };
        to.add(at, send(name, fields));
    }

    /// Cyclic frames that are not sent, fewer than the watchdog takes or more.
    fn lost_frames(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let count = if draw.chance(80) { draw.between(1, 5) } else { draw.between(6, 20) };
        to.set(at, "io.cyclic", "paused");
        to.set(at + count, "io.cyclic", "running");
    }

    fn shaft(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        if !self.names.stand.has_shaft {
            return;
        }
        match draw.between(0, 3) {
            0 => {
                let counts = i128::from(draw.number(17));
                let counts = if draw.chance(50) { counts } else { -counts };
                to.add(at, ControllerAction::Turn { counts, rpm: 600 });
            }
            1 => to.set(at, "shaft.counts", draw.number(30).to_string()),
            _ => {
                let acceleration = if draw.chance(70) { 0 } else { draw.between(1, 20_000) };
                to.set(at, "shaft.acceleration", acceleration.to_string());
                to.set(at, "shaft.speed", speed(draw).to_string());
                if draw.chance(60) {
                    to.set(at + draw.between(1, self.length), "shaft.speed", "0");
                }
            }
        }
    }

    fn stand(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let stand = &self.names.stand;
        let until = at + draw.between(1, self.length);
        let kind = draw.between(0, 9);
        if let (0..=6, Some(fault)) = (kind, draw.one(&stand.faults)) {
            to.set(at, fault, "present");
            if draw.chance(80) {
                to.set(until, fault, "absent");
            }
        } else if let (7, Some(button)) = (kind, draw.one(&stand.buttons)) {
            to.set(at, button, "pressed");
            to.set(until, button, "released");
        } else if let Some((name, home, [low, high])) = draw.one(&stand.supplies) {
            let value = low + (high - low) * draw.between(0, 100) as f64 / 100.0;
            to.set(at, name, format!("{value:.1}"));
            to.set(until, name, format!("{home:.1}"));
        }
    }

    /// What a controller marks and acknowledges besides its data.
    fn controller(&self, draw: &mut Draw, to: &mut Schedule, at: u64) {
        let until = at + length_of_pulse(draw);
        if !self.names.on_profinet {
            return;
        }
        if draw.chance(50) {
            to.set(at, "io.output_status", "bad");
            to.set(until, "io.output_status", "good");
        } else {
            to.set(at, "io.alarm_acknowledge", *draw.one(&["held", "received"]).unwrap_or(&"held"));
            to.set(until, "io.alarm_acknowledge", "given");
        }
    }
}

/// Mostly a few cycles.
fn length_of_pulse(draw: &mut Draw) -> u64 {
    if draw.chance(40) { draw.between(1, 3) } else { draw.between(1, LONGEST_PULSE) }
}

/// A service of `send` that is answered or not.
fn send(service: &str, fields: &str) -> ControllerAction {
    let answered = !["global_control", "broken", "abort", "lldp"].contains(&service);
    ControllerAction::Send { service: service.to_owned(), fields: fields.to_owned(), answered }
}

/// A damaged frame.
fn damaged(draw: &mut Draw, on_profinet: bool) -> ControllerAction {
    let words: Vec<&str> = if on_profinet {
        profinet_io::broken_frames().map(|(word, _)| word).collect()
    } else {
        profibus_dp::broken_frames().map(|(word, _)| word).collect()
    };
    let word = draw.one(&words).copied().unwrap_or_default();
    send("broken", &format!("{{ frame: {word} }}"))
}

/// The end of a connection by the controller.
pub(crate) fn abort() -> ControllerAction {
    send("abort", "{}")
}
