//! Bugs of the parameters in Set_Prm, except for the scaling.

use super::values::{set_position, set_velocity};
use crate::seams::amt58::Amt58;
use crate::seams::measuring::ShaftStep;
use crate::tables::Deviation;
use device_stack::profibus::SlaveHooks;
use encoder_profile::encoder::{CountingDirection, MeasuringSettings, Scaling};
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View};
use reference_devices::models::datalogic_amt58::set_prm::{
    CLASS_2, COUNTS, EXTENDED, EncoderParameters, OCTETS, OPERATING, RESERVED, VELOCITY, VELOCITY_UNIT, has, number,
};
use wire::profibus::prm::SetPrm;

/// The bugs of the parameters.
pub static BUGS: &[Deviation] = bugs! {
    "operating-byte-9" "The operating parameters are read from byte 9 of the telegram instead of byte 10."
        => |d| d.slave.parameters(|parameters| if parameters.user.len() > OPERATING {
            parameters.user.copy_within(2..3, OPERATING);
        });
    "zero-resolution-in-class-1" "Counts per revolution of 0 are refused even in Class 1."
        => |d| d.amt58.user_octets(|_, user, right| right && (is_class_2(user) || number(user, COUNTS) != 0));
    "reserved-bytes-of-class-1-checked" "In Class 1 byte 20 has to be 0, else Prm_Fault."
        => |d| d.amt58.user_octets(|_, user, right| right && (is_class_2(user) || user[RESERVED] == 0));
    "unit-byte-checked-in-class-2" "In Class 2 byte 19 has to be 0, else Prm_Fault."
        => |d| d.amt58.user_octets(|_, user, right| {
            right && (user[OPERATING] & (CLASS_2 | VELOCITY) != CLASS_2 || user[VELOCITY_UNIT] == 0)
        });
    "velocity-not-recognised" "The velocity bit is ignored; there are 4 input bytes, and D3 E1 is refused."
        => |d| velocity(&mut d.amt58, |_| false);
    "unit-from-byte-20" "The velocity unit is read from byte 20; values above 1 are refused."
        => |d| d.slave.parameters(|parameters| if parameters.user.len() == OCTETS {
            parameters.user.copy_within(RESERVED.., VELOCITY_UNIT);
        });
    "direction-reversed" "With code sequence 0 the position rises counterclockwise, with 1 clockwise."
        => |d| direction(&mut d.amt58, |_, of| other(of.direction));
    "distance-for-direction" "The position rises with each movement, in both directions."
        => |d| d.measuring.slip(|step| rising(step, true));
    "code-sequence-ignored" "The position always rises clockwise, whatever the code sequence."
        => |d| direction(&mut d.amt58, |_, _| CountingDirection::Clockwise);
    "reversed-one-way-only" "With code sequence 1 the position rises in both directions."
        => |d| d.measuring.slip(|step| rising(step, step.settings.direction == CountingDirection::Counterclockwise));
    "code-sequence-without-class-1" "In Class 1 the position always rises clockwise, whatever the code sequence."
        => |d| direction(&mut d.amt58, |_, of| if of.is_class_2 { of.direction } else { CountingDirection::Clockwise });
    "class-bit-ignored" "The device is always in Class 2, whatever bit 1 is."
        => |d| d.slave.parameters(|parameters| if let Some(bits) = parameters.user.get_mut(OPERATING) {
            *bits |= CLASS_2;
        });
    "velocity-in-class-1" "In Class 1 the velocity bit is obeyed, and D3 E1 is accepted."
        => |d| velocity(&mut d.amt58, |bits| has(bits, VELOCITY));
    "reserved-bit-acts" "Bit 2 of byte 10 reverses the counting direction."
        => |d| direction(&mut d.amt58, |bits, of| if has(bits, 0x04) { other(of.direction) } else { of.direction });
    "outputs-as-parameters" "Outputs whose first byte is 0Ah set the counts per revolution to the number in the other three bytes."
        => |d| d.amt58.add(CountsByOutputs::default());
    "missing-bytes-from-old-buffer" "Missing bytes of a Set_Prm are taken from the previous one, at first from the defaults."
        => |d| d.slave.add(MissingUserBytes::default());
    "parameter-length-not-checked" "Surplus bytes of Set_Prm are ignored."
        => |d| d.slave.parameters(|parameters| parameters.user.truncate(OCTETS));
    "reduced-diagnosis-always" "The diagnosis always has 16 bytes, whatever its type."
        => |d| extended(&mut d.amt58, |_| false);
    "extended-diagnosis-always" "In Class 2 the diagnosis always has 63 bytes, whatever its type."
        => |d| extended(&mut d.amt58, |bits| has(bits, CLASS_2));
    "extended-diagnosis-always-in-class-1" "In Class 1 the diagnosis always has 63 bytes, even with the diagnosis type bit at 0."
        => |d| extended(&mut d.amt58, |bits| has(bits, EXTENDED) || !has(bits, CLASS_2));
    "extended-diagnosis-needs-no-velocity" "In Class 2 with velocity the diagnosis always has 16 bytes, whatever its type."
        => |d| extended(&mut d.amt58, |bits| has(bits, CLASS_2 | EXTENDED) && !has(bits, VELOCITY));
    "extended-diagnosis-in-class-1" "In Class 1 the extended diagnosis bit is obeyed."
        => |d| extended(&mut d.amt58, |bits| has(bits, EXTENDED));
};

fn is_class_2(user: &[u8]) -> bool {
    has(user[OPERATING], CLASS_2)
}

/// Changes the rule by which the operating parameters select the velocity.
fn velocity(amt58: &mut Amt58, decide: fn(u8) -> bool) {
    amt58.check(move |_, check, right| if let Amt58Check::HasVelocity(bits) = check { decide(bits) } else { right });
}

/// Changes the rule by which the operating parameters select the extended diagnosis.
fn extended(amt58: &mut Amt58, decide: fn(u8) -> bool) {
    amt58.check(move |_, check, right| if let Amt58Check::IsExtended(bits) = check { decide(bits) } else { right });
}

/// Changes the counting direction, given the received operating parameters and the parameters of the manual.
fn direction(amt58: &mut Amt58, direction: fn(u8, &EncoderParameters) -> CountingDirection) {
    amt58.parameters(move |_, user, of| EncoderParameters { direction: direction(user[OPERATING], &of), ..of });
}

fn other(direction: CountingDirection) -> CountingDirection {
    match direction {
        CountingDirection::Clockwise => CountingDirection::Counterclockwise,
        CountingDirection::Counterclockwise => CountingDirection::Clockwise,
    }
}

/// Lets the position rise where it should fall, if `acts`.
fn rising(step: &ShaftStep, acts: bool) -> i64 {
    let units = |way: i64| way * step.settings.scaling.units_per_revolution as i64;
    let way = units(step.movement()) / step.hardware.steps_per_revolution as i64;
    if acts && way < 0 { step.slip - 2 * way } else { step.slip }
}

/// Uses the counts per revolution set by outputs.
#[derive(Default)]
struct CountsByOutputs {
    counts: Option<u64>,
}

impl Amt58Hooks for CountsByOutputs {
    fn outputs(&mut self, _: &Amt58View<'_>, outputs: u32) -> u32 {
        if outputs >> 24 == 0x0A {
            self.counts = Some((outputs & 0xFF_FFFF).into());
        }
        outputs
    }

    fn inputs(&mut self, view: &Amt58View<'_>, inputs: &mut [u8]) {
        let Some(units_per_revolution) = self.counts else { return };
        let scaling = Scaling { units_per_revolution, ..view.parameters.scaling };
        let measuring = view.measuring.with_settings(MeasuringSettings { scaling, ..view.measuring.settings });
        set_position(inputs, measuring.shifted() as u32);
        set_velocity(inputs, view.velocity.value(&scaling, view.parameters.direction) as i32);
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.counts = None;
        offset
    }

    fn parameters(&mut self, _: &Amt58View<'_>, _: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        self.counts = None;
        parameters
    }
}

/// Fills missing user bytes with those of the previous Set_Prm.
#[derive(Default)]
struct MissingUserBytes {
    user: [u8; OCTETS],
}

impl SlaveHooks for MissingUserBytes {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        let user = &mut parameters.user;
        user.extend(self.user.iter().skip(user.len()));
        if let Ok(octets) = user.as_slice().try_into() {
            self.user = octets;
        }
        true
    }

    fn starts(&mut self) {
        self.user = [0; OCTETS];
    }
}
