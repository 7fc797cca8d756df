//! Bugs of the scaling.

use crate::seams::amt58::Amt58;
use crate::tables::Deviation;
use alloc::vec;
use alloc::vec::Vec;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use encoder_profile::encoder::{Hardware, Scaling};
use reference_devices::models::datalogic_amt58::hooks::Amt58Check;
use reference_devices::models::datalogic_amt58::scaling::is_possible;
use reference_devices::models::datalogic_amt58::set_prm::{
    CLASS_2, COUNTS, EncoderParameters, OCTETS, OPERATING, RESOLUTION, SCALING, VELOCITY, has, number,
};
use wire::profibus::prm::SetPrm;

/// The bugs of the scaling.
pub static BUGS: &[Deviation] = bugs! {
    // Activation
    "scaling-bit-ignored" "In Class 2 scaling is active although it is off; a range of 0 means that of the hardware."
        => |d| {
            scales(&mut d.amt58, |bits| has(bits, CLASS_2));
            d.slave.parameters(|parameters| for at in [COUNTS, RESOLUTION] {
                // The highest number is limited to that of the hardware.
                if number(&parameters.user, at) == 0 && let Some(octets) = parameters.user.get_mut(at..at + 4) {
                    octets.fill(0xFF);
                }
            });
        };
    "scaling-bit-inverted" "Scaling is active when its bit is 0."
        => |d| scales(&mut d.amt58, |bits| has(bits, CLASS_2) && !has(bits, SCALING));
    "scaling-without-class-2" "Scaling is active in Class 1 if its bit is set."
        => |d| scales(&mut d.amt58, |bits| has(bits, SCALING));
    "scaling-needs-velocity" "Scaling is active only in Class 2 with velocity."
        => |d| scales(&mut d.amt58, |bits| has(bits, CLASS_2 | SCALING | VELOCITY));
    "scaling-lost-with-velocity" "In Class 2 with velocity the position is not scaled."
        => |d| scales(&mut d.amt58, |bits| has(bits, CLASS_2 | SCALING) && !has(bits, VELOCITY));
    "scaling-remembered" "The first accepted scaling stays in force in all later parameterisations, even in Class 1 and after a power cycle."
        => |d| {
            let mut first = None;
            d.amt58.parameters(move |_, _, now| {
                let first = first.get_or_insert(now);
                EncoderParameters { scaling: first.scaling, scales: first.scales, ..now }
            });
        };
    "unused-values-in-force" "With scaling off its values are in force nevertheless, and are not checked."
        => |d| {
            d.amt58.scaling(|of, right| right || of.forced.units_per_revolution > 0 && of.forced.range > 0);
            scales(&mut d.amt58, |bits| has(bits, CLASS_2));
        };
    "units-and-range-little-endian" "Counts per revolution and total resolution are read least significant byte first."
        => |d| d.slave.parameters(|parameters| for at in [4, 8] {
            if let Some(number) = parameters.user.get_mut(at..at + 4) {
                number.reverse();
            }
        });

    // Limits
    "limits-of-the-other-variant" "Hardware resolution and scaling limits are those of the other variant."
        => |d| d.amt58.sensor(|hardware| if hardware.revolutions == 1 { MULTITURN } else { SINGLETURN });
    "one-unit-refused" "One step per revolution is refused with Prm_Fault."
        => |d| d.amt58.scaling(|of, right| right && of.forced.units_per_revolution > 1);
    "full-units-refused" "The full steps per revolution of the hardware are refused with Prm_Fault."
        => |d| d.amt58.scaling(|of, right| right && of.forced.units_per_revolution < of.hardware.steps_per_revolution);
    "full-range-refused" "The full range of the hardware is refused with Prm_Fault."
        => |d| d.amt58.scaling(|of, right| right && of.forced.range < of.hardware.range());
    "range-of-one-revolution-refused" "A range of one revolution is refused with Prm_Fault."
        => |d| d.amt58.scaling(|of, right| right && of.forced.range != of.forced.units_per_revolution);
    "too-large-units-refused" "Counts per revolution above those of the hardware are refused with Prm_Fault."
        => |d| d.amt58.scaling(|of, right| right && of.sent.units_per_revolution <= of.hardware.steps_per_revolution);
    "too-large-range-refused" "A total resolution above that of the hardware is refused with Prm_Fault."
        => |d| d.amt58.scaling(|of, right| right && of.sent.range <= of.hardware.range());
    "units-with-a-sign" "A scaling value with its highest bit set is treated as negative and refused."
        => |d| d.amt58.scaling(|of, right| right && of.sent.units_per_revolution.max(of.sent.range) <= i32::MAX as u64);
    "units-reduced" "Counts per revolution above those of the hardware are reduced modulo them, and not limited."
        => |d| d.amt58.parameters(|view, user, parameters| {
            let (sent, hardware) = (u64::from(number(user, COUNTS)), view.hardware.steps_per_revolution);
            if parameters.scales && sent > hardware {
                let scaling = Scaling { units_per_revolution: (sent % hardware).max(1), ..parameters.scaling };
                EncoderParameters { scaling, ..parameters }
            } else {
                parameters
            }
        });
    "range-not-clamped" "A total resolution above that of the hardware is not limited."
        => |d| total_resolution(&mut d.amt58, |sent| sent);
    "range-clamped-to-multiturn" "The singleturn encoder limits the total resolution to 1073741824 and accepts more than one revolution."
        => |d| {
            d.amt58.scaling(|of, _| {
                is_possible(&Scaling { range: of.sent.range.min(MULTITURN.range()), ..of.forced }, &MULTITURN)
            });
            total_resolution(&mut d.amt58, |sent| sent.min(MULTITURN.range()));
        };
    "impossible-scaling-accepted" "A total resolution of more revolutions than the hardware has is accepted."
        => |d| d.amt58.scaling(|of, _| has_a_revolution(&of.forced));
    "range-below-a-revolution-accepted" "A total resolution below the counts per revolution is accepted."
        => |d| d.amt58.scaling(|of, right| right || of.forced.range > 0 && of.forced.range < of.forced.units_per_revolution);
    "zero-units-stop-the-device" "Counts per revolution of 0 stop the device until power-off."
        => |d| d.slave.add(StopsOnZero { at: COUNTS, has_stopped: false });
    "zero-range-stops-the-device" "A total resolution of 0 stops the device until power-off."
        => |d| d.slave.add(StopsOnZero { at: RESOLUTION, has_stopped: false });
    "ratio-cut-off" "The number of revolutions is rounded down before it is compared with that of the hardware."
        => |d| d.amt58.scaling(|of, _| {
            has_a_revolution(&of.forced) && of.forced.range / of.forced.units_per_revolution <= of.hardware.revolutions
        });
    "clamped-scaling-not-checked" "A scaling with a value that was limited to that of the hardware is not checked further."
        => |d| d.amt58.scaling(|of, right| right || of.sent != of.forced);
    "revolutions-of-multiturn" "The singleturn encoder accepts up to 16384 revolutions."
        => |d| d.amt58.scaling(|of, _| is_possible(&of.forced, &MULTITURN));
    "check-overflows" "The check of the number of revolutions overflows."
        => |d| d.amt58.scaling(|of, _| {
            let most = of.forced.units_per_revolution * of.hardware.revolutions;
            has_a_revolution(&of.forced) && of.forced.range % (1 << 20) <= most % (1 << 20)
        });
    "most-revolutions-refused" "The full number of revolutions of the hardware is refused if the steps are scaled."
        => |d| d.amt58.scaling(|of, right| {
            let Scaling { units_per_revolution: units, range } = of.forced;
            right && (units == of.hardware.steps_per_revolution || range < units * of.hardware.revolutions)
        });

    // Positions
    "range-as-mask" "The range is rounded up to the next power of two."
        => |d| d.measuring.range(|scaling, _, _| scaling.range.next_power_of_two());
};

const SINGLETURN: Hardware = Hardware { steps_per_revolution: 262_144, revolutions: 1 };
const MULTITURN: Hardware = Hardware { steps_per_revolution: 65_536, revolutions: 16_384 };

fn has_a_revolution(scaling: &Scaling) -> bool {
    scaling.units_per_revolution > 0 && scaling.range >= scaling.units_per_revolution
}

/// Changes the rule by which the operating parameters turn scaling on.
fn scales(amt58: &mut Amt58, decide: fn(u8) -> bool) {
    amt58.check(move |_, check, right| if let Amt58Check::Scales(bits) = check { decide(bits) } else { right });
}

/// Changes the total resolution, given the received one.
fn total_resolution(amt58: &mut Amt58, of: fn(u64) -> u64) {
    amt58.parameters(move |_, user, parameters| {
        if parameters.scales {
            let range = of(number(user, RESOLUTION).into());
            EncoderParameters { scaling: Scaling { range, ..parameters.scaling }, ..parameters }
        } else {
            parameters
        }
    });
}

/// Does not answer after a Set_Prm that turns scaling on with 0 as the number at `at`, until power-off.
struct StopsOnZero {
    at: usize,
    has_stopped: bool,
}

impl SlaveHooks for StopsOnZero {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if self.has_stopped { Vec::new() } else { vec![telegram.to_vec()] }
    }

    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        let user = &parameters.user;
        let scales = user.get(OPERATING).is_some_and(|bits| has(*bits, CLASS_2 | SCALING));
        self.has_stopped |= user.len() == OCTETS && scales && number(user, self.at) == 0;
        true
    }

    fn starts(&mut self) {
        self.has_stopped = false;
    }
}
