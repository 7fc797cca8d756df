//! Bugs of what Set_Prm says, the scaling apart.

use super::values::{set_position, set_velocity};
use crate::seams::amt58::Amt58;
use crate::seams::measuring::Step;
use crate::tables::Deviation;
use device_stack::profibus::SlaveHooks;
use encoder_profile::encoder::{CountingDirection, MeasuringSettings, Scaling};
use reference_devices::models::datalogic_amt58::hooks::{Amt58Hooks, Check, View};
use reference_devices::models::datalogic_amt58::set_prm::{
    CLASS_2, COUNTS, EXTENDED, EncoderParameters, OCTETS, OPERATING, RESERVED, VELOCITY, VELOCITY_UNIT, has, number,
};
use wire::profibus::prm::SetPrm;

/// The bugs of the parameters.
pub static BUGS: &[Deviation] = bugs! {
    "operating-octet-9" "The operating parameters are read from octet 9 of the telegram, all others from where they are."
        => |d| d.slave.parameters(|parameters| if parameters.user.len() > OPERATING {
            parameters.user.copy_within(2..3, OPERATING);
        });
    "zero-resolution-in-class-1" "Counts per revolution of 0 are refused in Class 1 too."
        => |d| d.amt58.user_octets(|_, user, right| right && (is_class_2(user) || number(user, COUNTS) != 0));
    "reserved-octets-of-class-1-checked" "In Class 1 octet 20 has to be 0, else Prm_Fault."
        => |d| d.amt58.user_octets(|_, user, right| right && (is_class_2(user) || user[RESERVED] == 0));
    "unit-octet-looked-at-in-class-2" "In Class 2 octet 19 has to be 0, else Prm_Fault."
        => |d| d.amt58.user_octets(|_, user, right| {
            right && (user[OPERATING] & (CLASS_2 | VELOCITY) != CLASS_2 || user[VELOCITY_UNIT] == 0)
        });
    "velocity-not-recognised" "The bit of the velocity is ignored; there are 4 input octets, and D3 E1 is refused."
        => |d| velocity(&mut d.amt58, |_| false);
    "unit-from-octet-20" "The unit of the velocity is read from octet 20; values above 1 are refused."
        => |d| d.slave.parameters(|parameters| if parameters.user.len() == OCTETS {
            parameters.user.copy_within(RESERVED.., VELOCITY_UNIT);
        });
    "direction-reversed" "Code sequence 0 rises counterclockwise and 1 clockwise."
        => |d| direction(&mut d.amt58, |_, of| other(of.direction));
    "distance-for-direction" "The position rises with each movement, whichever way it goes."
        => |d| d.measuring.slip(|step| rising(step, true));
    "code-sequence-ignored" "The position rises clockwise whatever the code sequence is."
        => |d| direction(&mut d.amt58, |_, _| CountingDirection::Clockwise);
    "reversed-one-way-only" "With code sequence 1 the position rises counterclockwise, and clockwise too."
        => |d| d.measuring.slip(|step| rising(step, step.settings.direction == CountingDirection::Counterclockwise));
    "code-sequence-without-class-1" "In Class 1 the position rises clockwise whatever the code sequence is."
        => |d| direction(&mut d.amt58, |_, of| if of.is_class_2 { of.direction } else { CountingDirection::Clockwise });
    "class-bit-ignored" "The device is in Class 2 whatever bit 1 says."
        => |d| d.slave.parameters(|parameters| if let Some(bits) = parameters.user.get_mut(OPERATING) {
            *bits |= CLASS_2;
        });
    "velocity-in-class-1" "In Class 1 the bit of the velocity is obeyed, and D3 E1 accepted."
        => |d| velocity(&mut d.amt58, |bits| has(bits, VELOCITY));
    "reserved-bit-acts" "Bit 2 of octet 10 reverses the counting direction."
        => |d| direction(&mut d.amt58, |bits, of| if has(bits, 0x04) { other(of.direction) } else { of.direction });
    "outputs-as-parameters" "Outputs with bit 31 at 0 whose first octet is 0Ah set the counts per revolution to the number in the other three."
        => |d| d.amt58.add(CountsByOutputs::default());
    "missing-octets-from-old-buffer" "Octets that a Set_Prm lacks are taken from the one before, at first from the defaults."
        => |d| d.slave.add(OldOctets::default());
    "parameter-length-not-checked" "Octets of Set_Prm behind the last are not looked at."
        => |d| d.slave.parameters(|parameters| parameters.user.truncate(OCTETS));
    "reduced-diagnosis-always" "The diagnosis has 16 octets whatever its type is."
        => |d| extended(&mut d.amt58, |_| false);
    "extended-diagnosis-always" "The diagnosis has 63 octets in Class 2 whatever its type is."
        => |d| extended(&mut d.amt58, |bits| has(bits, CLASS_2));
    "extended-diagnosis-always-in-class-1" "In Class 1 the diagnosis has 63 octets, with the bit of its type at 0 too."
        => |d| extended(&mut d.amt58, |bits| has(bits, EXTENDED) || !has(bits, CLASS_2));
    "extended-diagnosis-needs-no-velocity" "In Class 2 with velocity the diagnosis has 16 octets whatever its type is."
        => |d| extended(&mut d.amt58, |bits| has(bits, CLASS_2 | EXTENDED) && !has(bits, VELOCITY));
    "extended-diagnosis-in-class-1" "In Class 1 the bit of the extended diagnosis is obeyed."
        => |d| extended(&mut d.amt58, |bits| has(bits, EXTENDED));
};

fn is_class_2(user: &[u8]) -> bool {
    has(user[OPERATING], CLASS_2)
}

/// Lets the operating parameters select the velocity by another rule.
fn velocity(amt58: &mut Amt58, decide: fn(u8) -> bool) {
    amt58.check(move |_, check, right| if let Check::HasVelocity(bits) = check { decide(bits) } else { right });
}

/// Lets the operating parameters select the extended diagnosis by another rule.
fn extended(amt58: &mut Amt58, decide: fn(u8) -> bool) {
    amt58.check(move |_, check, right| if let Check::IsExtended(bits) = check { decide(bits) } else { right });
}

/// Lets positions rise in another direction, by the operating parameters as sent and the parameters of the manual.
fn direction(amt58: &mut Amt58, direction: fn(u8, &EncoderParameters) -> CountingDirection) {
    amt58.parameters(move |_, user, of| EncoderParameters { direction: direction(user[OPERATING], &of), ..of });
}

fn other(direction: CountingDirection) -> CountingDirection {
    match direction {
        CountingDirection::Clockwise => CountingDirection::Counterclockwise,
        CountingDirection::Counterclockwise => CountingDirection::Clockwise,
    }
}

/// Lets the position rise where it should fall.
fn rising(step: &Step, acts: bool) -> i64 {
    let units = |way: i64| way * step.settings.scaling.units_per_revolution as i64;
    let way = units(step.way()) / step.hardware.steps_per_revolution as i64;
    if acts && way < 0 { step.slip - 2 * way } else { step.slip }
}

/// Counts by other counts per revolution once outputs have set them.
#[derive(Default)]
struct CountsByOutputs {
    counts: Option<u64>,
}

impl Amt58Hooks for CountsByOutputs {
    fn outputs(&mut self, _: &View<'_>, outputs: u32) -> u32 {
        if outputs >> 24 == 0x0A {
            self.counts = Some((outputs & 0xFF_FFFF).into());
        }
        outputs
    }

    fn inputs(&mut self, view: &View<'_>, inputs: &mut [u8]) {
        let Some(units_per_revolution) = self.counts else { return };
        let scaling = Scaling { units_per_revolution, ..view.parameters.scaling };
        let measuring = view.measuring.with_settings(MeasuringSettings { scaling, ..view.measuring.settings });
        set_position(inputs, measuring.shifted() as u32);
        set_velocity(inputs, view.velocity.value(&scaling, view.parameters.direction) as i32);
    }

    fn load(&mut self, _: &View<'_>, offset: i64) -> i64 {
        self.counts = None;
        offset
    }

    fn parameters(&mut self, _: &View<'_>, _: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        self.counts = None;
        parameters
    }
}

/// Fills user octets that are missing with those of the Set_Prm before.
#[derive(Default)]
struct OldOctets {
    user: [u8; OCTETS],
}

impl SlaveHooks for OldOctets {
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
