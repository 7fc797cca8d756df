//! Bugs of the inputs: positions and velocity.

use super::diagnosis::{extend, patch};
use crate::seams::Deviations;
use crate::tables::Deviation;
use alloc::vec::Vec;
use core::mem;
use encoder_profile::encoder::Scaling;
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View, NewOffset};
use reference_devices::models::datalogic_amt58::set_prm::{
    COUNTS, EncoderParameters, RESOLUTION, VELOCITY_UNIT, number,
};

/// The bugs of the inputs.
pub static BUGS: &[Deviation] = bugs! {
    // Bytes
    "position-little-endian" "The position is sent least significant byte first."
        => |d| d.amt58.inputs(|_, inputs| set_position(inputs, position(inputs).swap_bytes()));
    "scaled-position-words-swapped" "In Class 2 with scaling on the two words of the position are swapped."
        => |d| d.amt58.inputs(|view, inputs| if view.parameters.scales {
            set_position(inputs, position(inputs).rotate_left(16));
        });
    "velocity-before-position" "The velocity is in bytes 1 to 4 and the position in bytes 5 to 8."
        => |d| d.amt58.inputs(|_, inputs| if inputs.len() == 8 {
            inputs.rotate_left(4);
        });
    "velocity-little-endian" "The velocity is sent least significant byte first."
        => |d| d.amt58.inputs(|_, inputs| set_velocity(inputs, velocity(inputs).swap_bytes()));
    "inputs-renewed-with-outputs" "The inputs are updated only when the outputs have changed since the previous cycle."
        => |d| d.amt58.add(HeldInputs::default());
    "position-torn" "While the position changes, its upper 16 bits are those of the previous frame."
        => |d| {
            let mut before = 0;
            d.amt58.inputs(move |_, inputs| {
                let now = position(inputs);
                set_position(inputs, mem::replace(&mut before, now) & 0xFFFF_0000 | now & 0xFFFF);
            });
        };
    "position-negative-below-zero" "One step backward from 0 the position is FFFFFFFFh, and counts down from there to half the range."
        => |d| d.amt58.inputs(|view, inputs| {
            let (range, position) = (view.parameters.scaling.range, position(inputs));
            if u64::from(position) >= range / 2 {
                set_position(inputs, position.wrapping_sub(range as u32));
            }
        });
    "turns-counted-by-singleturn" "The singleturn encoder counts turns above its 18 bits."
        => |d| d.amt58.inputs(|view, inputs| if view.hardware.revolutions == 1 {
            let turns = view.shaft.position(view.now).div_euclid(view.hardware.range() as i64) as u32;
            set_position(inputs, position(inputs).wrapping_add(turns << 18));
        });
    "turns-of-12-bits" "The multiturn encoder counts 4096 turns."
        => |d| d.amt58.inputs(|view, inputs| {
            let turns = view.parameters.scaling.units_per_revolution * 4096;
            set_position(inputs, (u64::from(position(inputs)) % turns.max(1)) as u32);
        });

    // Velocity
    "speed-units-exchanged" "The unit codes 0 and 1 are swapped."
        => |d| d.slave.parameters(|parameters| if let Some(unit) = parameters.user.get_mut(VELOCITY_UNIT) {
            *unit ^= 1;
        });
    "unused-scaling-in-velocity" "With scaling off the velocity still uses the counts per revolution of Set_Prm."
        => |d| d.amt58.add(UnusedScaling::default());
    "programmed-range-of-16384" "The full counts per revolution of the hardware are shown as 16384, also used for the velocity."
        => |d| {
            velocity_by(d, |view| match view.parameters.scaling {
                of if is_whole(view) => Scaling { units_per_revolution: 16_384, ..of },
                of => of,
            });
            extend(d, |view, octets| patch(octets, 39, if is_whole(view) { &[0, 0, 0x40, 0] } else { &[] }));
        };
    "speed-unit-not-checked" "Unit 2 is accepted, and the velocity is in tenths of a revolution per minute."
        => |d| d.amt58.add(TenthsOfRpm::default());
    "noise-shows-as-speed" "At standstill the velocity is 1 in every hundredth cycle."
        => |d| {
            let mut count = 0_u32;
            d.amt58.inputs(move |_, inputs| {
                count = count.wrapping_add(1);
                if velocity(inputs) == 0 && count.is_multiple_of(100) {
                    set_velocity(inputs, 1);
                }
            });
        };
    "preset-shows-as-speed" "The jump of the position at a preset is reported as a velocity."
        => |d| d.amt58.add(PresetJumpVelocity::default());
};

/// Reads the position from the inputs; 0 if they are too short.
pub(super) fn position(inputs: &[u8]) -> u32 {
    inputs.first_chunk().copied().map_or(0, u32::from_be_bytes)
}

/// Writes a position to the inputs.
pub(super) fn set_position(inputs: &mut [u8], position: u32) {
    if let Some(octets) = inputs.first_chunk_mut() {
        *octets = position.to_be_bytes();
    }
}

/// Reads the velocity from the inputs; 0 if they have none.
pub fn velocity(inputs: &[u8]) -> i32 {
    let octets = inputs.split_at_checked(4).and_then(|(_, velocity)| velocity.try_into().ok());
    octets.map_or(0, i32::from_be_bytes)
}

/// Writes a velocity to the inputs, if they have one.
pub fn set_velocity(inputs: &mut [u8], velocity: i32) {
    if let Some((_, octets)) = inputs.split_at_mut_checked(4).filter(|(_, octets)| octets.len() == 4) {
        octets.copy_from_slice(&velocity.to_be_bytes());
    }
}

/// Computes the velocity with another scaling.
pub fn velocity_by(d: &mut Deviations, scaling: fn(&Amt58View<'_>) -> Scaling) {
    d.amt58.inputs(move |view, inputs| {
        set_velocity(inputs, view.velocity.value(&scaling(view), view.parameters.direction) as i32);
    });
}

/// Whether the counts per revolution are the full counts of the hardware.
fn is_whole(view: &Amt58View<'_>) -> bool {
    view.parameters.scaling.units_per_revolution == view.hardware.steps_per_revolution
}

/// Repeats the inputs while the outputs stay the same.
#[derive(Default)]
struct HeldInputs {
    /// The outputs of this cycle and of the previous one.
    outputs: [u32; 2],
    inputs: Option<Vec<u8>>,
}

impl Amt58Hooks for HeldInputs {
    fn outputs(&mut self, _: &Amt58View<'_>, outputs: u32) -> u32 {
        self.outputs = [outputs, self.outputs[0]];
        outputs
    }

    fn inputs(&mut self, _: &Amt58View<'_>, inputs: &mut [u8]) {
        if let Some(before) = self.inputs.as_ref().filter(|_| self.outputs[0] == self.outputs[1]) {
            let length = before.len().min(inputs.len());
            inputs[..length].copy_from_slice(&before[..length]);
        }
        self.inputs = Some(inputs.to_vec());
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        *self = HeldInputs::default();
        offset
    }
}

/// Computes the velocity with the scaling of Set_Prm, which is off.
#[derive(Default)]
struct UnusedScaling {
    sent: Option<Scaling>,
}

impl Amt58Hooks for UnusedScaling {
    fn parameters(&mut self, _: &Amt58View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        let (units_per_revolution, range) = (number(user, COUNTS).into(), number(user, RESOLUTION).into());
        self.sent = (!parameters.scales).then_some(Scaling { units_per_revolution, range });
        parameters
    }

    fn inputs(&mut self, view: &Amt58View<'_>, inputs: &mut [u8]) {
        if let Some(scaling) = self.sent {
            set_velocity(inputs, view.velocity.value(&scaling, view.parameters.direction) as i32);
        }
    }
}

/// Treats the undefined unit 2 as tenths of a revolution per minute.
#[derive(Default)]
struct TenthsOfRpm {
    acts: bool,
}

impl Amt58Hooks for TenthsOfRpm {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        verdict || check == Amt58Check::Unit(2)
    }

    fn parameters(&mut self, _: &Amt58View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        self.acts = user.get(VELOCITY_UNIT) == Some(&2);
        parameters
    }

    fn inputs(&mut self, _: &Amt58View<'_>, inputs: &mut [u8]) {
        if self.acts {
            set_velocity(inputs, velocity(inputs).wrapping_mul(10));
        }
    }
}

/// Adds the change of the position at a preset to the velocity.
#[derive(Default)]
struct PresetJumpVelocity {
    is_preset: bool,
    before: u32,
}

impl Amt58Hooks for PresetJumpVelocity {
    fn offset(&mut self, _: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        self.is_preset |= cause == NewOffset::Preset;
        offset
    }

    fn inputs(&mut self, _: &Amt58View<'_>, inputs: &mut [u8]) {
        let now = position(inputs);
        let before = mem::replace(&mut self.before, now);
        if mem::take(&mut self.is_preset) {
            set_velocity(inputs, velocity(inputs).wrapping_add(now.wrapping_sub(before) as i32));
        }
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        *self = PresetJumpVelocity::default();
        offset
    }
}
