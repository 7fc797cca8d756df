//! Deviations at the hooks of an AMT58.

use alloc::vec::Vec;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::Hardware;
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View, NewOffset};
use reference_devices::models::datalogic_amt58::leds::{Leds, Situation};
use reference_devices::models::datalogic_amt58::node_number::NodeNumber;
use reference_devices::models::datalogic_amt58::scaling::SentScaling;
use reference_devices::models::datalogic_amt58::set_prm::EncoderParameters;

hooks! { Amt58: Amt58Hooks
    /// Changes a decision, given the check and the decision of the encoder.
    check(view: &Amt58View<'_>, check: Amt58Check<'_>) -> bool;
    /// Changes the resolution of the sensor.
    sensor() -> Hardware;
    /// Changes the position of the shaft.
    place() -> i64;
    /// Changes the address with which the slave starts.
    address(of: &NodeNumber) -> u8;
    /// Changes the outputs of a cycle as they arrive.
    outputs(view: &Amt58View<'_>) -> u32;
    /// Changes the inputs before they are sent.
    inputs(view: &Amt58View<'_>, inputs: &mut [u8]);
    /// Changes the extended diagnosis (the bytes after the first six) and the bits of the first six bytes that belong to it.
    diagnosis(view: &Amt58View<'_>, octets: &mut Vec<u8>) -> DiagnosisBits;
    /// Changes what the LEDs show.
    leds(view: &Amt58View<'_>, of: &Situation) -> Leds;
    /// Changes the offset that is written to the memory.
    store(view: &Amt58View<'_>) -> Option<i64>;
    /// Changes the offset that is read from the memory.
    load(view: &Amt58View<'_>) -> i64;
    /// Is called at power-down.
    power_down(view: &Amt58View<'_>);
    /// Changes the parameters that come into force.
    parameters(view: &Amt58View<'_>, user: &[u8]) -> EncoderParameters;
    /// Changes the preset offset that comes into force.
    offset(view: &Amt58View<'_>, cause: NewOffset) -> i64;
}

impl Amt58 {
    /// Changes whether a scaling is accepted, given the scaling and the decision of the encoder.
    pub fn scaling(&mut self, decide: impl Fn(&SentScaling, bool) -> bool + 'static) {
        self.check(move |_, check, right| match check {
            Amt58Check::Scaling(of) => decide(&of, right),
            _ => right,
        });
    }

    /// Changes whether a preset is made, given the number of consecutive cycles with bit 31 and the decision of the encoder.
    pub fn preset_cycles(&mut self, decide: impl Fn(u32, bool) -> bool + 'static) {
        self.check(move |_, check, right| match check {
            Amt58Check::PresetCycles(cycles) => decide(cycles, right),
            _ => right,
        });
    }

    /// Changes whether a preset value is accepted, given the value and the decision of the encoder.
    pub fn preset_value(&mut self, decide: impl Fn(&Amt58View<'_>, u64, bool) -> bool + 'static) {
        self.check(move |view, check, right| match check {
            Amt58Check::PresetValue(value) => decide(view, value, right),
            _ => right,
        });
    }

    /// Changes whether the user bytes of Set_Prm are accepted, given the bytes and the decision of the encoder about their number.
    pub fn user_octets(&mut self, decide: impl Fn(&Amt58View<'_>, &[u8], bool) -> bool + 'static) {
        self.check(move |view, check, right| match check {
            Amt58Check::UserOctets(user) => decide(view, user, right),
            _ => right,
        });
    }

    /// Changes whether the LEDs show the red zone.
    pub fn red_zone(&mut self, decide: impl Fn(&Amt58View<'_>, bool) -> bool + 'static) {
        self.check(move |view, check, right| match check {
            Amt58Check::RedZone => decide(view, right),
            _ => right,
        });
    }
}
