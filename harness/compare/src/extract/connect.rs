//! The start-up of a connection on PROFINET: the module, its records, and how far the start-up got.

use super::requests::{field_value, fields, refused};
use super::{ConversationState, module_of};
use crate::action::{ConnectAction, ControllerAction, span};
use crate::conversation::{AnsweredAction, SuiteValue};
use judge::observe::{ArId, Observation, ObservedAr, StartRecord};
use plain_text::hex;
use suite::device::DeviceRecord;

/// The usual watchdog factor: cycles without a frame after which connections end.
const WATCHDOG_FACTOR: u32 = 10;

impl ConversationState<'_> {
    /// Takes in a Connect and its answer; everything up to the first good sample belongs to it.
    pub(super) fn connect(&mut self, id: ArId, ar: &ObservedAr, observation: &Observation<'_>) {
        self.flush();
        let Some(module) = module_of(self.device, ar).and_then(|module| self.device.modules.get(module)) else {
            self.left_out("a Connect whose layout fits no module of the manual");
            return;
        };
        let mut settings = Vec::new();
        let cycle = ar.outputs.cycle;
        if cycle != self.device.timing.cycle && !cycle.is_zero() {
            settings.push(("cycle".to_owned(), span(cycle)));
        }
        let usual = self.device.timing.watchdog.unwrap_or(cycle * WATCHDOG_FACTOR).max(cycle);
        if ar.outputs.watchdog != usual && !ar.outputs.watchdog.is_zero() {
            settings.push(("watchdog".to_owned(), span(ar.outputs.watchdog)));
        }
        let accepted = match observation {
            Observation::ConnectRefused { status, .. } => refused(status),
            _ => SuiteValue::word("accepted"),
        };
        let (now, frame) = self.now;
        let connection =
            ConnectAction { module: module.name.clone(), settings, instead: self.other_idents(ar, module.ident()) };
        let ask = ControllerAction::Connect(connection);
        let at = ar.connect_time.unwrap_or(now);
        if matches!(observation, Observation::Connected { .. }) {
            self.open = Some((self.conversation.actions.len(), id));
        }
        let mut asked = AnsweredAction::new(ask, (at, now), frame);
        asked.part("connect", accepted, frame);
        self.conversation.actions.push(asked);
    }

    /// Takes in a stage of the start-up; at the end of the parameters its records are known.
    pub(super) fn stage(&mut self, ars: &[ObservedAr], id: ArId, stage: &str) {
        let stood = self.open.is_none();
        let Some((place, open)) = self.open.or(self.stood) else { return };
        let Some(ar) = ars.get(id.0 as usize).filter(|_| open == id) else { return };
        if stage != "application_ready" {
            self.parameters(place, ar);
        }
        let (now, frame) = self.now;
        if let Some(asked) = self.conversation.actions.get_mut(place) {
            // Good data may come before the ApplicationReady call.
            if !stood {
                (asked.done, asked.frame) = (now, frame);
            }
            if !stage.is_empty() {
                asked.part(stage, SuiteValue::word("accepted"), frame);
            }
        }
    }

    /// Module idents that the manual does not have: with them the controller requests another device.
    fn other_idents(&self, ar: &ObservedAr, module: Option<u32>) -> Vec<(String, String)> {
        let idents = |is_head: bool| {
            let of = self.device.submodules.iter().filter(move |of| (of.slot == 0) == is_head);
            of.filter_map(|of| of.module_idents.as_ref()).flatten().copied()
        };
        let mut instead = Vec::new();
        for (name, is_head) in [("dap_ident", true), ("module_ident", false)] {
            let is_known =
                |ident: u32| idents(is_head).any(|known| known == ident) || (!is_head && Some(ident) == module);
            let mut asked = ar.submodules.iter().filter(|placed| (placed.slot == 0) == is_head);
            if let Some(other) = asked.find(|placed| !is_known(placed.module_ident)) {
                instead.push((name.to_owned(), format!("0x{:X}", other.module_ident)));
            }
        }
        instead
    }

    fn parameters(&mut self, place: usize, ar: &ObservedAr) {
        let device = self.device;
        let Some(module) = module_of(device, ar) else { return };
        let (mut settings, mut instead, mut answers) = (Vec::new(), Vec::new(), Vec::new());
        for record in device.records.iter().filter(|record| record.starts(module)) {
            let at = device.submodules.get(record.at).map(|at| (at.slot, at.subslot));
            let is_it = |sent: &&StartRecord| {
                let (_, slot, subslot, index) = sent.target;
                index == record.index && Some((slot, subslot)) == at
            };
            let Some(sent) = ar.start_records.iter().find(is_it) else {
                instead.push((record.name.clone(), "none".to_owned()));
                continue;
            };
            let value = if sent.accepted { "accepted" } else { "{ refused: any }" };
            answers.push((record.name.clone(), SuiteValue::word(value)));
            match self.of_record(record, &sent.data) {
                Some(of) => settings.extend(of),
                None => instead.push((record.name.clone(), format!("\"{}\"", hex(&sent.data)))),
            }
        }
        let frame = self.now.1;
        let Some(asked) = self.conversation.actions.get_mut(place) else { return };
        if let ControllerAction::Connect(connection) = &mut asked.ask {
            connection.settings.extend(settings);
            connection.instead.extend(instead);
            answers.into_iter().for_each(|(name, value): (String, SuiteValue)| asked.part(name, value, frame));
        }
    }

    /// The fields of a start-up record that differ from their defaults; `None` if the fields do not cover all its bytes.
    pub(super) fn of_record(&self, record: &DeviceRecord, octets: &[u8]) -> Option<Vec<(String, String)>> {
        let known = fields(record, octets)?;
        let other = known.into_iter().filter(|(field, _)| {
            let number = judge::image::field_number(field, octets);
            number != field.default.get(self.variant).copied()
        });
        let mut settings = Vec::new();
        for (field, _) in other {
            settings.push((field.name.clone(), field_value(field, octets)?.text));
        }
        Some(settings)
    }
}
