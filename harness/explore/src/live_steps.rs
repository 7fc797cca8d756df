//! Sequences for a live device: without what no bench permits, and with pauses after which values are at rest.

use crate::settled::SETTLING;
use crate::step::SequenceStep;
use compare::action::ControllerAction;
use std::time::Duration;
use suite::device::is_reserved;

/// How many actions follow each other before a pause.
const ACTIONS: usize = 6;
/// The most connections and steps: a sequence takes real time.
const CONNECTIONS: usize = 2;
const MOST_STEPS: usize = 40;
/// A pause that ends at rest.
const PAUSE: Duration = Duration::from_millis(SETTLING.as_millis() as u64 + 20);
/// Damaged frames without outputs, records or parameters.
const HARMLESS_FRAMES: [&str; 3] = ["alarm_endpoint", "unknown_function", "unknown_access_point"];
/// Services whose bytes are drawn, or that submit a form.
const DRAWN_BYTES: [&str; 7] =
    ["record_write", "records_write", "ds_write", "ms2_write", "set_prm", "data_exchange", "http_post"];
/// What in a request may be wrong although its frame can be read.
const READABLE: [&str; 6] = ["reference", "do_id", "attribute", "elements", "subindex", "count"];
/// What in a start-up may be wrong: all but records and parameter data as bytes.
const WRONG_STARTS: [&str; 19] = [
    "output_length",
    "input_length",
    "module_ident",
    "submodule_ident",
    "api",
    "station_name",
    "rt_class",
    "slot",
    "dap_ident",
    "ident",
    "lock",
    "freeze_req",
    "sync_req",
    "watchdog_factors",
    "min_tsdr",
    "groups",
    "chk_cfg",
    "set_prm",
    "fields",
];
/// Elements of DCP that a Set may have: name, address, signal.
const DCP_SETS: [&str; 3] = ["02 02", "01 02", "05 03"];

/// Whether a step may be part of a sequence for a live device. The frames are judged again when they are sent: this only avoids
/// sequences that say nothing.
fn is_usual(step: &SequenceStep) -> bool {
    let instead = step.modifiers.iter().find(|(name, _)| name == "instead").map(|(_, value)| value.as_str());
    let is_write = matches!(step.action, ControllerAction::Write(_));
    let is_readable = |value: &str| {
        let named = READABLE.iter().any(|name| value.contains(&format!("{name}:")));
        named && !(is_write && (value.contains("count:") || value.contains("elements:")))
    };
    if instead.is_some_and(|value| !is_readable(value)) {
        return false;
    }
    match &step.action {
        ControllerAction::Send { service, fields, .. } => match service.as_str() {
            "broken" => HARMLESS_FRAMES.iter().any(|word| fields.contains(word)),
            "dcp_set" => DCP_SETS.iter().any(|element| fields.contains(&format!("\"{element}"))),
            service => !DRAWN_BYTES.contains(&service),
        },
        ControllerAction::Connect(connect) => connect
            .instead
            .iter()
            .all(|(name, value)| WRONG_STARTS.contains(&name.as_str()) && !value.contains("ar_type")),
        ControllerAction::Turn { .. } => false,
        ControllerAction::Set(_)
        | ControllerAction::Disconnect
        | ControllerAction::Read(_)
        | ControllerAction::Write(_)
        | ControllerAction::Wait(_) => true,
    }
}

/// Whether a step changes name or address, which are not those of the reference device.
fn changes_station(step: &SequenceStep) -> bool {
    match &step.action {
        ControllerAction::Write(entries) => entries.iter().any(|(name, _)| name.starts_with("station.")),
        ControllerAction::Send { service, .. } => service == "dcp_set" || service == "dcp_reset",
        _ => false,
    }
}

/// The same steps for a live device. If `is_compared`, a shaft that turns is left out, since its position depends on the time, and so is
/// what changes name or address.
pub(crate) fn adapted(steps: Vec<SequenceStep>, is_compared: bool) -> Vec<SequenceStep> {
    let mut list: Vec<SequenceStep> = Vec::new();
    let (mut actions, mut connections) = (0, 0);
    for mut step in steps.into_iter().filter(|step| is_usual(step) && !(is_compared && changes_station(step))) {
        match &mut step.action {
            ControllerAction::Set(entries) => {
                let turns = |name: &str| name == "shaft.speed" || name == "shaft.acceleration";
                entries.retain(|(name, _)| !(is_reserved(name) || is_compared && turns(name)));
                if entries.is_empty() {
                    continue;
                }
            }
            ControllerAction::Connect(connect) => {
                connect.settings.retain(|(name, _)| !is_reserved(name));
                connections += usize::from(step.modifiers.is_empty());
            }
            _ => {}
        }
        if connections > CONNECTIONS || list.len() > MOST_STEPS {
            break;
        }
        let is_wait = matches!(step.action, ControllerAction::Wait(_));
        let ends = matches!(step.action, ControllerAction::Connect(_) | ControllerAction::Disconnect);
        if (actions >= ACTIONS || ends && actions > 0) && !is_pause(list.last()) {
            list.push(ControllerAction::Wait(PAUSE).into());
            actions = 0;
        }
        actions += usize::from(!is_wait);
        list.push(step);
    }
    if !is_pause(list.last()) {
        list.push(ControllerAction::Wait(PAUSE).into());
    }
    list
}

/// Whether values are at rest after this step.
fn is_pause(step: Option<&SequenceStep>) -> bool {
    matches!(step.map(|step| &step.action), Some(ControllerAction::Wait(wait)) if *wait >= PAUSE)
}

/// The same steps with waits that are a little longer or shorter, as a host makes them.
pub(crate) fn with_other_waits(steps: &[SequenceStep], number: u64) -> Vec<SequenceStep> {
    let mut list = steps.to_vec();
    for (index, step) in list.iter_mut().enumerate() {
        if let ControllerAction::Wait(wait) = &mut step.action {
            // A few milliseconds more or less, in a pattern that differs with the number.
            let by = Duration::from_millis((number + index as u64 * (number / 2 + 1)) % 9);
            let is_shorter = (number + index as u64).is_multiple_of(2);
            *wait = if is_shorter { wait.saturating_sub(by).max(Duration::from_millis(1)) } else { *wait + by };
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use compare::action::ConnectAction;

    fn set(name: &str, value: &str) -> SequenceStep {
        ControllerAction::Set(vec![(name.to_owned(), value.to_owned())]).into()
    }

    #[test]
    fn drawn_bytes_and_forms_are_left_out_and_pauses_added() {
        let connect = ConnectAction { module: "telegram_81".to_owned(), ..ConnectAction::default() };
        let steps = vec![
            ControllerAction::Connect(connect).into(),
            SequenceStep::send("record_write", "{ slot: 1, subslot: 0x1, index: 0xAFF1, bytes: \"00\" }"),
            SequenceStep::send("broken", "{ frame: cyclic_unknown_source }"),
            SequenceStep::send("broken", "{ frame: alarm_endpoint }"),
            SequenceStep::send("dcp_set", "{ blocks: \"02 03 00 06\" }"),
            SequenceStep::from(ControllerAction::Read(vec!["P922".into()])).with("instead", "{ bytes: \"01 02\" }"),
            set("shaft.speed", "60"),
            set("STW2_ENC.reserved_11", "1"),
            ControllerAction::Disconnect.into(),
        ];
        let verbs: Vec<String> = adapted(steps.clone(), true).iter().map(|step| step.action.yaml()).collect();
        let expected = [
            "connect: { module: telegram_81 }",
            "send: { broken: { frame: alarm_endpoint } }",
            "wait: 120ms",
            "connect: none",
            "wait: 120ms",
        ];
        assert_eq!(verbs, expected);
        assert!(adapted(steps, false).iter().any(|step| step.action.yaml().contains("shaft.speed")));
    }
}
