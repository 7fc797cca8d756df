//! The encoder as the application of a PROFIBUS slave.

use super::encoder::{Amt58, SUPPLY};
use super::hooks::Amt58Check;
use super::leds::Leds;
use super::{data_exchange, slave_diag};
use alloc::vec::Vec;
use device_stack::profibus::{DiagnosisBits, ExchangeEnd, SlaveApplication, SlaveIdentity, SlaveStatus};
use station::{StandAction, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::prm::SetPrm;

impl SlaveApplication for Amt58 {
    fn identity(&self) -> &SlaveIdentity {
        &self.identity
    }

    fn power_up(&mut self, now: Time) {
        self.start(now);
    }

    fn power_down(&mut self, now: Time) {
        self.hooks.notify(|hooks| hooks.power_down(&self.view(now)));
    }

    fn address(&self) -> u8 {
        let of = self.node_number();
        self.hooks.apply(of.address(), |hooks, address| hooks.address(&of, address))
    }

    fn takes_address(&self) -> bool {
        self.node_number().is_left_to_bus()
    }

    /// The lock of the node number is not supported (6.8).
    fn set_address(&mut self, _: Time, address: u8, _: bool) {
        self.stored_address.replace(Some(address));
    }

    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool {
        self.take_parameters(now, &parameters.user)
    }

    fn check_configuration(&mut self, _: Time, identifiers: &[u8]) -> Option<IoLengths> {
        (identifiers == self.ram.parameters.identifiers()).then(|| data_exchange::lengths(identifiers))
    }

    fn configuration(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.ram.parameters.identifiers());
    }

    fn exchange_begins(&mut self, _: Time) {
        self.ram.preset_cycles = 0;
    }

    fn exchange_ends(&mut self, _: Time, end: ExchangeEnd) {
        self.ram.has_expired |= end == ExchangeEnd::Watchdog;
    }

    fn outputs(&mut self, now: Time, data: Option<&[u8]>) {
        let octets = data.and_then(|data| data.try_into().ok()).unwrap_or_default();
        self.take_outputs(now, octets);
    }

    fn inputs(&mut self, now: Time, data: &mut [u8]) {
        self.write_inputs(now, data);
    }

    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        slave_diag::write(&self.ram.parameters, &self.ram.hardware, self.ram.offset, out);
        self.hooks.apply(DiagnosisBits::default(), |hooks, bits| hooks.diagnosis(&self.view(now), out, bits))
    }

    fn diagnosis_changed(&mut self) -> bool {
        false
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.sample(now);
        let mut done = now;
        match *action {
            StandAction::ShaftSpeed(rpm) => self.shaft.turn(now, rpm),
            StandAction::ShaftRamp { rpm, acceleration } => self.shaft.ramp(now, rpm, acceleration),
            StandAction::ShaftCounts(counts) => {
                self.shaft.move_to(now, (counts % self.sensor.range()) as i64);
                self.ram.velocity.restart(now, &self.shaft);
                self.ram.measuring.jump(self.place(now));
            }
            StandAction::Turn { steps, rpm } => done = self.shaft.turn_by(now, steps, rpm),
            StandAction::TurnRevolutions { revolutions, rpm } => {
                done = self.shaft.turn_revolutions(now, revolutions, rpm);
            }
            StandAction::SupplyVoltage(volts) => self.volts = volts,
            StandAction::Fault("flash", present) => self.has_broken_memory = present,
            StandAction::Switch("address", position) => {
                self.switches = u8::try_from(position).ok().filter(|position| *position < 128)?;
            }
            StandAction::Switch("termination_a", position) => self.termination[0] = position,
            StandAction::Switch("termination_b", position) => self.termination[1] = position,
            // Not used (4.8).
            StandAction::Switch("eighth", _) => {}
            _ => return None,
        }
        self.sample(now);
        Some(done)
    }

    fn is_alive(&self) -> bool {
        let [lowest, highest] = SUPPLY;
        let millivolts = self.millivolts();
        let suffices = (lowest..=highest).contains(&millivolts);
        self.check(Time::ZERO, Amt58Check::Supply(millivolts), suffices)
    }

    fn led(&mut self, now: Time, name: &str, status: &SlaveStatus) -> Option<&'static str> {
        let Leds { fault, power } = self.leds(now, status);
        match name {
            "fault" => Some(fault),
            "power" => Some(power),
            _ => None,
        }
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        match name {
            "nvm_writes" => Some(self.stored_offset.writes() + self.stored_address.writes()),
            // Both switches on (4.6).
            "termination" => {
                let switches = self.termination;
                Some(self.check(now, Amt58Check::Terminated(switches), switches == [1; 2]).into())
            }
            _ => None,
        }
    }

    /// There is no timer, since presets are stored at once.
    fn deadline(&self) -> Option<Time> {
        None
    }

    fn advance(&mut self, _: Time) {}
}
