//! Bugs of what Set_Prm says, the scaling apart.

use crate::seams::measuring::Step;
use crate::tables::Deviation;
use encoder_profile::encoder::Direction;
use reference_devices::models::datalogic_amt58::knobs::has;
use reference_devices::models::datalogic_amt58::preset::{self, Order, TRIGGER};
use reference_devices::models::datalogic_amt58::program::{
    CLASS_2, EXTENDED, LAST, OCTETS, OPERATING, Program, SPEED_UNIT, VELOCITY,
};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    "operating-octet-9" "The operating parameters are read from octet 9 of the telegram, all others from where they are."
        => |b| b.slave.parameters(|parameters| if parameters.user.len() > OPERATING {
            parameters.user.copy_within(2..3, OPERATING);
        });
    "zero-resolution-in-class-1" "Counts per revolution of 0 are refused in Class 1 too."
        => |b| b.amt58.takes_octets = |octets| has(octets[OPERATING], CLASS_2) || octets[4..8] != [0; 4];
    "reserved-octets-of-class-1-checked" "In Class 1 octet 20 has to be 0, else Prm_Fault."
        => |b| b.amt58.takes_octets = |octets| has(octets[OPERATING], CLASS_2) || octets[LAST] == 0;
    "unit-octet-looked-at-in-class-2" "In Class 2 octet 19 has to be 0, else Prm_Fault."
        => |b| b.amt58.takes_octets = |octets| {
            octets[OPERATING] & (CLASS_2 | VELOCITY) != CLASS_2 || octets[SPEED_UNIT] == 0
        };
    "velocity-not-recognised" "The bit of the velocity is ignored; there are 4 input octets, and D3 E1 is refused."
        => |b| b.amt58.has_velocity = |_, _| false;
    "unit-from-octet-20" "The unit of the velocity is read from octet 20; values above 1 are refused."
        => |b| b.slave.parameters(|parameters| if parameters.user.len() == OCTETS {
            parameters.user.copy_within(LAST.., SPEED_UNIT);
        });
    "direction-reversed" "Code sequence 0 rises counterclockwise and 1 clockwise."
        => |b| b.amt58.in_force = |program, _| Program { direction: other(program.direction), ..program };
    "distance-for-direction" "The position rises with each movement, whichever way it goes."
        => |b| b.measuring.slip(|step| rising(step, true));
    "code-sequence-ignored" "The position rises clockwise whatever the code sequence is."
        => |b| b.amt58.in_force = |program, _| Program { direction: Direction::Clockwise, ..program };
    "reversed-one-way-only" "With code sequence 1 the position rises counterclockwise, and clockwise too."
        => |b| b.measuring.slip(|step| rising(step, step.settings.direction == Direction::Counterclockwise));
    "code-sequence-without-class-1" "In Class 1 the position rises clockwise whatever the code sequence is."
        => |b| b.amt58.in_force = |program, _| match program.is_class_2 {
            true => program,
            false => Program { direction: Direction::Clockwise, ..program },
        };
    "class-bit-ignored" "The device is in Class 2 whatever bit 1 says."
        => |b| b.slave.parameters(|parameters| if let Some(bits) = parameters.user.get_mut(OPERATING) {
            *bits |= CLASS_2;
        });
    "velocity-in-class-1" "In Class 1 the bit of the velocity is obeyed, and D3 E1 accepted."
        => |b| b.amt58.has_velocity = |bits, _| has(bits, VELOCITY);
    "reserved-bit-acts" "Bit 2 of octet 10 reverses the counting direction."
        => |b| b.amt58.in_force = |program, _| match has(program.octets[OPERATING], 0x04) {
            true => Program { direction: other(program.direction), ..program },
            false => program,
        };
    "outputs-as-parameters" "Outputs with bit 31 at 0 whose first octet is 0Ah set the counts per revolution to the number in the other three."
        => |b| b.amt58.order = |trigger, outputs, _| match preset::order(trigger, outputs) {
            Order::Nothing if outputs >> 24 == 0x0A && outputs & TRIGGER == 0 => Order::Units((outputs & 0xFF_FFFF).into()),
            order => order,
        };
    "missing-octets-from-old-buffer" "Octets that a Set_Prm lacks are taken from the one before, at first from the defaults."
        => |b| (b.amt58.takes_length, b.amt58.fills_from_before) = (|length| length <= OCTETS, true);
    "parameter-length-not-checked" "Octets of Set_Prm behind the last are not looked at."
        => |b| b.amt58.takes_length = |length| length >= OCTETS;
    "reduced-diagnosis-always" "The diagnosis has 16 octets whatever its type is."
        => |b| b.amt58.is_extended = |_| false;
    "extended-diagnosis-always" "The diagnosis has 63 octets in Class 2 whatever its type is."
        => |b| b.amt58.is_extended = |bits| has(bits, CLASS_2);
    "extended-diagnosis-always-in-class-1" "In Class 1 the diagnosis has 63 octets, with the bit of its type at 0 too."
        => |b| b.amt58.is_extended = |bits| has(bits, EXTENDED) || !has(bits, CLASS_2);
    "extended-diagnosis-needs-no-velocity" "In Class 2 with velocity the diagnosis has 16 octets whatever its type is."
        => |b| b.amt58.is_extended = |bits| has(bits, CLASS_2 | EXTENDED) && !has(bits, VELOCITY);
    "extended-diagnosis-in-class-1" "In Class 1 the bit of the extended diagnosis is obeyed."
        => |b| b.amt58.is_extended = |bits| has(bits, EXTENDED);
};

fn other(direction: Direction) -> Direction {
    match direction {
        Direction::Clockwise => Direction::Counterclockwise,
        Direction::Counterclockwise => Direction::Clockwise,
    }
}

/// Lets the position rise where it should fall.
fn rising(step: &Step, acts: bool) -> i64 {
    let units = |way: i64| way * step.settings.scaling.units_per_revolution as i64;
    let way = units(step.way()) / step.hardware.steps_per_revolution as i64;
    if acts && way < 0 { step.slip - 2 * way } else { step.slip }
}
