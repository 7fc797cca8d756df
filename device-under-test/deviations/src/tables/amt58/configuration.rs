//! Bugs of Chk_Cfg and Get_Cfg, and of how much is exchanged.

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
    "velocity-configuration-always-taken" "D3 E1 is accepted whatever the parameters say, and 8 octets are sent."
        => |d| configure(d, |_, sent, right| right.or(accepted(sent, sent == POSITION_AND_VELOCITY)));
    "short-configuration-always-taken" "D1 E1 is accepted with the velocity parameterised, and the inputs are cut to 4 octets."
        => |d| configure(d, |_, sent, right| right.or(accepted(sent, sent == POSITION)));
    "configuration-of-another-class" "In Class 1 the identifiers D3 E1 are wanted, and D1 E1 is refused."
        => |d| configure(d, |class, sent, right| match class.number() {
            0 => accepted(sent, sent == POSITION_AND_VELOCITY),
            _ => right,
        });
    "class-2-wants-d3" "In Class 2 the identifiers D3 E1 are wanted, and D1 E1 is refused."
        => |d| configure(d, |class, sent, right| match class.number() {
            1 => accepted(sent, sent == POSITION_AND_VELOCITY),
            _ => right,
        });
    "only-first-identifier-checked" "Of the configuration only the first identifier is compared."
        => |d| configure(d, |class, sent, _| class.takes(sent.first() == class.identifiers.first()));
    "consistency-bit-ignored" "Bit 7 of the identifiers is not compared."
        => |d| configure(d, |class, sent, _| {
            let without_bit = |octets: &[u8]| octets.iter().map(|octet| octet & 0x7F).collect::<Vec<_>>();
            class.takes(without_bit(sent) == without_bit(&class.identifiers))
        });
    "only-lengths-compared" "Of the identifiers only how many octets of input and output they mean is compared."
        => |d| configure(d, |class, sent, _| class.takes(lengths(sent) == lengths(&class.identifiers)));
    "identifiers-as-a-set" "The order of the identifiers is not compared."
        => |d| configure(d, |class, sent, right| match (sent, &class.identifiers[..]) {
            ([first, second], [one, other]) => {
                class.takes([first, second] == [one, other] || [second, first] == [one, other])
            }
            _ => right,
        });
    "output-identifier-first" "The configuration is wanted with the output identifier first."
        => |d| configure(d, |class, sent, _| class.takes(sent.iter().rev().eq(&class.identifiers)));
    "longer-inputs-accepted" "An identifier with more input octets than the device has is accepted."
        => |d| configure(d, |class, sent, right| {
            let (of, own) = (lengths(sent), lengths(&class.identifiers));
            right.or(class.takes(of.inputs > own.inputs && of.outputs == own.outputs))
        });
    "configuration-compared-as-received" "The configuration is compared over the length that came, so that a shorter one fits."
        => |d| configure(d, |class, sent, _| class.takes(class.identifiers.starts_with(sent)));
    "surplus-identifiers-ignored" "Identifiers behind the second are not looked at."
        => |d| configure(d, |class, sent, _| class.takes(sent.starts_with(&class.identifiers)));
    "output-length-not-compared" "The length of the outputs is not compared."
        => |d| configure(d, |class, sent, right| {
            let is_pair = sent.len() == 2 && sent.first() == class.identifiers.first();
            right.or(accepted(sent, is_pair && sent.get(1).is_some_and(|second| second & 0xF0 == 0xE0)))
        });
    "get-cfg-constant" "Get_Cfg answers D1 E1 whatever the class is."
        => |d| d.slave.get_cfg(|identifiers| *identifiers = POSITION.into());
    "directions-confused" "Get_Cfg and the data exchange have the lengths of input and output exchanged in Class 2 with velocity."
        => |d| {
            d.slave.get_cfg(|identifiers| if *identifiers == POSITION_AND_VELOCITY {
                *identifiers = [0xD1, 0xE3].into();
            });
            configure(d, |class, _, right| right.map(|sums| match class.number() {
                2 => IoLengths { inputs: sums.outputs, outputs: sums.inputs },
                _ => sums,
            }));
        };
    "velocity-in-class-2" "In Class 2 the inputs have 8 octets, with the velocity, although D1 E1 is the configuration."
        => |d| configure(d, |class, _, right| right.map(|sums| match class.number() {
            1 => IoLengths { inputs: 8, ..sums },
            _ => sums,
        }));
    "unit-activates-velocity" "A unit other than 0 brings the velocity into the inputs of Class 2 too, which then have 8 octets."
        => |d| configure(d, |class, _, right| right.map(|sums| match class.number() == 1 && class.unit != 0 {
            true => IoLengths { inputs: 8, ..sums },
            false => sums,
        }));
    "inputs-of-two-octets" "In Class 1 the inputs have two octets, the lower half of the position."
        => |d| {
            configure(d, |class, _, right| right.map(|sums| match class.number() {
                0 => IoLengths { inputs: 2, ..sums },
                _ => sums,
            }));
            d.amt58.inputs(|view, octets| if let [_, _] = octets {
                octets.copy_from_slice(&(view.measuring.shifted() as u16).to_be_bytes());
            });
        };
    "inputs-of-six-octets" "In Class 2 with velocity the inputs have six octets, the velocity having two."
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

/// What the last Set_Prm says about the configuration.
#[derive(Default)]
struct Class {
    /// The operating parameters.
    operating: u8,
    /// The unit of the velocity.
    unit: u8,
    /// The identifiers that belong to them.
    identifiers: Vec<u8>,
}

impl Class {
    /// 0 for Class 1, 1 for Class 2, 2 for Class 2 with velocity.
    fn number(&self) -> u32 {
        u32::from(has(self.operating, CLASS_2)) + u32::from(has(self.operating, CLASS_2 | VELOCITY))
    }

    /// The lengths of the class, if the configuration is accepted.
    fn takes(&self, is_accepted: bool) -> Option<IoLengths> {
        is_accepted.then(|| lengths(&self.identifiers))
    }
}

/// The lengths that were sent, if they are accepted.
fn accepted(sent: &[u8], is_accepted: bool) -> Option<IoLengths> {
    is_accepted.then(|| lengths(sent))
}

/// Lets Chk_Cfg result in other lengths: from the class, the identifiers that were sent, and the lengths of the manual.
fn configure(d: &mut Deviations, change: impl Fn(&Class, &[u8], Option<IoLengths>) -> Option<IoLengths> + 'static) {
    d.slave.add(Configures { class: Class::default(), change });
}

struct Configures<F> {
    class: Class,
    change: F,
}

impl<F: Fn(&Class, &[u8], Option<IoLengths>) -> Option<IoLengths>> SlaveHooks for Configures<F> {
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
