//! Sets a stand back after a trial that was interrupted: power and cable there, shaft still, no fault, switches at home.
//!
//! A trial does this itself at its end; this is for `encspec bench restore --stand`. This module must not know trials.

use super::thread::{StandJob, StandJobResult};
use super::{LiveStand, sentence};
use crate::control::ability;
use station::{Duration, StandAction};
use std::thread::park_timeout;
use std::time::Instant;
use suite::device::StandNames;

/// How long one action may take, an operator included.
const LONGEST_ACTION: Duration = Duration::from_secs(300);
/// How long the power is off in a power cycle.
const WITHOUT_POWER: Duration = Duration::from_secs(1);

/// The actions that set back the stand names `set`, in their order.
///
/// A device reads switches and faults when it starts, so it starts again where one of them was set and its power can be switched.
pub fn actions<'n>(set: &'n [String], declared: &'n StandNames) -> Vec<StandAction<'n>> {
    let mut actions = Vec::new();
    let has = |name: &str| set.iter().any(|set| set == name);
    let of_kind = |kind: &'static str| set.iter().filter_map(move |set| set.strip_prefix(kind)?.strip_prefix('.'));
    if of_kind("shaft").next().is_some() || has("turn") {
        actions.push(StandAction::ShaftSpeed(0.0));
    }
    actions.extend(of_kind("button").map(|name| StandAction::Button(name, false)));
    actions.extend(of_kind("fault").map(|name| StandAction::Fault(name, false)));
    let homes = declared.switches.iter().filter(|switch| of_kind("switch").any(|name| name == switch.name));
    actions.extend(homes.map(|switch| StandAction::Switch(&switch.name, switch.home)));
    if has("supply.voltage") {
        actions.extend(declared.voltage.map(StandAction::SupplyVoltage));
    }
    if has("supply.temperature") {
        actions.extend(declared.temperature.map(StandAction::Temperature));
    }
    if has("link") {
        actions.push(StandAction::Link(true));
    }
    if has("power") {
        if of_kind("fault").chain(of_kind("switch")).next().is_some() {
            actions.push(StandAction::Power(false));
        }
        actions.push(StandAction::Power(true));
    }
    actions
}

impl LiveStand {
    /// Carries out `actions` one after the other and waits for each; fails with a sentence.
    pub fn act_in_turn(&mut self, actions: &[StandAction<'_>]) -> Result<(), String> {
        for action in actions {
            let name = ability(action);
            if !self.spec.serves(&name) {
                continue;
            }
            self.doing.send_job(StandJob::act(action, &name));
            match self.doing.wait_result(LONGEST_ACTION) {
                Some(StandJobResult::Done(Ok(more))) => wait(more),
                Some(StandJobResult::Done(Err(refusal))) => return Err(format!("{name}: {}", sentence(&refusal))),
                _ => return Err(format!("{name}: the stand does not answer")),
            }
            if matches!(action, StandAction::Power(false)) {
                wait(WITHOUT_POWER);
            }
        }
        Ok(())
    }
}

/// Waits for this time.
fn wait(time: Duration) {
    let begin = Instant::now();
    while let Some(rest) = time.checked_sub(begin.elapsed()).filter(|rest| !rest.is_zero()) {
        park_timeout(rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use suite::device::CodingSwitch;

    #[test]
    fn everything_that_was_set_is_set_back_and_the_power_comes_last() {
        let switch = |name: &str| CodingSwitch { name: name.into(), lowest: 0, highest: 9, home: 3 };
        let declared = StandNames { switches: vec![switch("tens"), switch("ones")], ..StandNames::default() };
        let set = |names: &[&str]| -> Vec<String> { names.iter().map(|name| (*name).to_owned()).collect() };
        let names = set(&["power", "switch.tens", "shaft.speed"]);
        let expected = [
            StandAction::ShaftSpeed(0.0),
            StandAction::Switch("tens", 3),
            StandAction::Power(false),
            StandAction::Power(true),
        ];
        assert_eq!(actions(&names, &declared), expected);
        let names = set(&["link", "power", "fault.memory"]);
        let expected = [
            StandAction::Fault("memory", false),
            StandAction::Link(true),
            StandAction::Power(false),
            StandAction::Power(true),
        ];
        assert_eq!(actions(&names, &declared), expected);
        assert_eq!(actions(&set(&["power"]), &declared), [StandAction::Power(true)]);
        assert_eq!(actions(&set(&["device"]), &declared), []);
    }
}
