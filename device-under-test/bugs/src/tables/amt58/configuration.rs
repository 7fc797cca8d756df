//! Bugs of Chk_Cfg and Get_Cfg, and of the input and output lengths.

use crate::seams::Deviations;
use crate::tables::Deviation;
use alloc::vec::Vec;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use reference_devices::models::datalogic_amt58::data_exchange::{POSITION, POSITION_AND_VELOCITY, lengths};
use reference_devices::models::datalogic_amt58::set_prm::{CLASS_2, OPERATING, VELOCITY, VELOCITY_UNIT, has};
use wire::profibus::cfg::IoLengths;
use wire::profibus::prm::SetPrm;

/// The bugs of the configuration.
pub static BUGS: &[Deviation] = bugs! {
    "velocity-configuration-always-taken" "D3 E1 is accepted with any parameters, and 8 bytes are sent."
        => |d| configure(d, |_, sent, right| right.or(accepted(sent, sent == POSITION_AND_VELOCITY)));
    "short-configuration-always-taken" "D1 E1 is accepted with the velocity parameterised, and the inputs are cut to 4 bytes."
        => |d| configure(d, |_, sent, right| right.or(accepted(sent, sent == POSITION)));
    "configuration-of-another-class" "In Class 1 the identifiers D3 E1 are required, and D1 E1 is refused."
        => |d| configure(d, |class, sent, right| match class.number() {
            0 => accepted(sent, sent == POSITION_AND_VELOCITY),
            _ => right,
        });
    "class-2-requires-d3" "In Class 2 the identifiers D3 E1 are required, and D1 E1 is refused."
        => |d| configure(d, |class, sent, right| match class.number() {
            1 => accepted(sent, sent == POSITION_AND_VELOCITY),
            _ => right,
        });
    "only-first-identifier-checked" "Only the first identifier of the configuration is compared."
        => |d| configure(d, |class, sent, _| class.takes(sent.first() == class.identifiers.first()));
    "consistency-bit-ignored" "Bit 7 of the identifiers is not compared."
        => |d| configure(d, |class, sent, _| {
            let without_bit = |octets: &[u8]| octets.iter().map(|octet| octet & 0x7F).collect::<Vec<_>>();
            class.takes(without_bit(sent) == without_bit(&class.identifiers))
        });
    "only-lengths-compared" "Only the input and output lengths of the identifiers are compared."
        => |d| configure(d, |class, sent, _| class.takes(lengths(sent) == lengths(&class.identifiers)));
    "identifiers-as-a-set" "The order of the identifiers is not compared."
        => |d| configure(d, |class, sent, right| match (sent, &class.identifiers[..]) {
            ([first, second], [one, other]) => {
                class.takes([first, second] == [one, other] || [second, first] == [one, other])
            }
            _ => right,
        });
    "output-identifier-first" "The output identifier has to come first in the configuration."
        => |d| configure(d, |class, sent, _| class.takes(sent.iter().rev().eq(&class.identifiers)));
    "longer-inputs-accepted" "An identifier with more input bytes than the device has is accepted."
        => |d| configure(d, |class, sent, right| {
            let (of, own) = (lengths(sent), lengths(&class.identifiers));
            right.or(class.takes(of.inputs > own.inputs && of.outputs == own.outputs))
        });
    "configuration-compared-as-received" "The configuration is compared over the received length only, so a shorter one is accepted."
        => |d| configure(d, |class, sent, _| class.takes(class.identifiers.starts_with(sent)));
    "surplus-identifiers-ignored" "Identifiers after the second are not checked."
        => |d| configure(d, |class, sent, _| class.takes(sent.starts_with(&class.identifiers)));
    "output-length-not-compared" "The length of the outputs is not compared."
        => |d| configure(d, |class, sent, right| {
            let is_pair = sent.len() == 2 && sent.first() == class.identifiers.first();
            right.or(accepted(sent, is_pair && sent.get(1).is_some_and(|second| second & 0xF0 == 0xE0)))
        });
    "get-cfg-constant" "Get_Cfg always answers D1 E1, whatever the class."
        => |d| d.slave.get_cfg(|identifiers| *identifiers = POSITION.into());
    "directions-confused" "In Class 2 with velocity the input and output lengths are swapped in Get_Cfg and data exchange."
        => |d| {
            d.slave.get_cfg(|identifiers| if *identifiers == POSITION_AND_VELOCITY {
                *identifiers = [0xD1, 0xE3].into();
            });
            configure(d, |class, _, right| right.map(|sums| match class.number() {
                2 => IoLengths { inputs: sums.outputs, outputs: sums.inputs },
                _ => sums,
            }));
        };
    "velocity-in-class-2" "In Class 2 the inputs have 8 bytes, with the velocity, although D1 E1 is the configuration."
        => |d| configure(d, |class, _, right| right.map(|sums| match class.number() {
            1 => IoLengths { inputs: 8, ..sums },
            _ => sums,
        }));
    "unit-activates-velocity" "A velocity unit other than 0 adds the velocity to the inputs of Class 2, which then have 8 bytes."
        => |d| configure(d, |class, _, right| right.map(|sums| if class.number() == 1 && class.unit != 0 {
            IoLengths { inputs: 8, ..sums }
        } else {
            sums
        }));
    "inputs-of-two-bytes" "In Class 1 the inputs have two bytes, the lower half of the position."
        => |d| {
            configure(d, |class, _, right| right.map(|sums| match class.number() {
                0 => IoLengths { inputs: 2, ..sums },
                _ => sums,
            }));
            d.amt58.inputs(|view, octets| if let [_, _] = octets {
                octets.copy_from_slice(&(view.measuring.shifted() as u16).to_be_bytes());
            });
        };
    "inputs-of-six-bytes" "In Class 2 with velocity the inputs have six bytes, two of them for the velocity."
        => |d| {
            configure(d, |class, _, right| right.map(|sums| match class.number() {
                2 => IoLengths { inputs: 6, ..sums },
                _ => sums,
            }));
            d.amt58.inputs(|view, octets| {
                let parameters = view.parameters;
                let now = view.velocity.value(&parameters.scaling, parameters.direction) as i16;
                if let [_, _, _, _, velocity @ ..] = octets && velocity.len() == 2 {
                    velocity.copy_from_slice(&now.to_be_bytes());
                }
            });
        };
};

/// The settings of the last Set_Prm that determine the configuration.
#[derive(Default)]
struct ConfiguredClass {
    /// The operating parameters.
    operating: u8,
    /// The unit of the velocity.
    unit: u8,
    /// The identifiers that belong to these settings.
    identifiers: Vec<u8>,
}

impl ConfiguredClass {
    /// Returns 0 for Class 1, 1 for Class 2, 2 for Class 2 with velocity.
    fn number(&self) -> u32 {
        u32::from(has(self.operating, CLASS_2)) + u32::from(has(self.operating, CLASS_2 | VELOCITY))
    }

    /// Returns the lengths of the class, if the configuration is accepted.
    fn takes(&self, is_accepted: bool) -> Option<IoLengths> {
        is_accepted.then(|| lengths(&self.identifiers))
    }
}

/// Returns the lengths of the received identifiers, if they are accepted.
fn accepted(sent: &[u8], is_accepted: bool) -> Option<IoLengths> {
    is_accepted.then(|| lengths(sent))
}

/// Changes the lengths that Chk_Cfg results in, given the class, the received identifiers and the lengths of the manual.
fn configure(
    d: &mut Deviations,
    change: impl Fn(&ConfiguredClass, &[u8], Option<IoLengths>) -> Option<IoLengths> + 'static,
) {
    d.slave.add(ConfigurationHook { class: ConfiguredClass::default(), change });
}

struct ConfigurationHook<F> {
    class: ConfiguredClass,
    change: F,
}

impl<F: Fn(&ConfiguredClass, &[u8], Option<IoLengths>) -> Option<IoLengths>> SlaveHooks for ConfigurationHook<F> {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        let octet = |at: usize| parameters.user.get(at).copied().unwrap_or_default();
        (self.class.operating, self.class.unit) = (octet(OPERATING), octet(VELOCITY_UNIT));
        true
    }

    fn configuration(
        &mut self,
        encoder: &dyn SlaveApplication,
        sent: &[u8],
        right: Option<IoLengths>,
    ) -> Option<IoLengths> {
        self.class.identifiers.clear();
        encoder.configuration(&mut self.class.identifiers);
        (self.change)(&self.class, sent, right)
    }
}
