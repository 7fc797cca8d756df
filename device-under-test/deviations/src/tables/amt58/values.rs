//! Bugs of the inputs: positions and velocity.

use crate::tables::Deviation;
use encoder_profile::encoder::velocity::MeasuredWay;
use encoder_profile::encoder::{Scaling, Unit};
use reference_devices::models::datalogic_amt58::program::unit;
use reference_devices::models::datalogic_amt58::told::{Shown, inputs, put};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Octets
    "position-little-endian" "The position is sent least significant octet first."
        => |b| b.amt58.inputs = |shown, octets| inputs(&with_position(shown, shown.position.swap_bytes()), octets);
    "scaled-position-words-swapped" "In Class 2 with scaling on the two words of the position are swapped."
        => |b| b.amt58.inputs = |shown, octets| {
            let swapped = if shown.program.scales { shown.position.rotate_left(16) } else { shown.position };
            inputs(&with_position(shown, swapped), octets);
        };
    "velocity-before-position" "The velocity stands in octets 1 to 4 and the position in octets 5 to 8."
        => |b| b.amt58.inputs = |shown, octets| match octets.len() {
            8 => inputs(&Shown { position: shown.velocity as u32, velocity: shown.position as i32, ..*shown }, octets),
            _ => inputs(shown, octets),
        };
    "velocity-little-endian" "The velocity is sent least significant octet first."
        => |b| b.amt58.inputs = |shown, octets| inputs(&with_velocity(shown, shown.velocity.swap_bytes()), octets);
    "inputs-renewed-with-outputs" "The inputs are taken anew only when the outputs differ from those of the cycle before."
        => |b| b.amt58.inputs = |shown, octets| match shown.count > 0 && shown.outputs[0] == shown.outputs[1] {
            true => put(octets, &shown.before),
            false => inputs(shown, octets),
        };
    "position-torn" "While the position changes, its upper 16 bits are those of the frame before."
        => |b| b.amt58.inputs = |shown, octets| {
            let torn = shown.truth_before.0 & 0xFFFF_0000 | shown.position & 0xFFFF;
            inputs(&with_position(shown, torn), octets);
        };
    "position-negative-below-zero" "One step backward from 0 the position is FFFFFFFFh, and counts down from there to half the range."
        => |b| b.amt58.inputs = |shown, octets| {
            let range = shown.program.scaling.range;
            let is_above = u64::from(shown.position) >= range / 2;
            let below = if is_above { shown.position.wrapping_sub(range as u32) } else { shown.position };
            inputs(&with_position(shown, below), octets);
        };
    "turns-counted-by-singleturn" "The singleturn encoder counts turns above its 18 bits."
        => |b| b.amt58.inputs = |shown, octets| {
            let turns = shown.endless.div_euclid(shown.hardware.range() as i64) as u32;
            let above = if shown.hardware.revolutions == 1 { turns << 18 } else { 0 };
            inputs(&with_position(shown, shown.position.wrapping_add(above)), octets);
        };
    "turns-of-12-bits" "The multiturn encoder counts 4096 turns."
        => |b| b.amt58.inputs = |shown, octets| {
            let turns = shown.program.scaling.units_per_revolution * 4096;
            inputs(&with_position(shown, (u64::from(shown.position) % turns.max(1)) as u32), octets);
        };

    // Velocity
    "speed-units-exchanged" "The unit codes 0 and 1 are swapped."
        => |b| b.amt58.unit = |code| unit(code ^ 1);
    "speed-in-hardware-steps" "The velocity in steps counts steps of the hardware although scaling is on."
        => |b| b.amt58.scaling_of_velocity = |_, hardware| Scaling::hardware(hardware);
    "unused-scaling-in-velocity" "With scaling off the velocity still counts the units per revolution of Set_Prm."
        => |b| b.amt58.scaling_of_velocity = |program, _| if program.scales { program.scaling } else { program.sent };
    "programmed-range-of-16384" "Counts per revolution that are those of the hardware are shown, and used for the velocity, as 16384."
        => |b| {
            b.amt58.scaling_of_velocity = |program, hardware| match program.scaling.units_per_revolution {
                units if units == hardware.steps_per_revolution => {
                    Scaling { units_per_revolution: 16_384, ..program.scaling }
                }
                _ => program.scaling,
            };
            b.amt58.diagnosis = |told, octets, _| {
                let is_whole = told.program.scaling.units_per_revolution == told.hardware.steps_per_revolution;
                super::diagnosis::patch(octets, 39, if is_whole { &[0, 0, 0x40, 0] } else { &[] });
            };
        };
    "speed-without-sign" "The velocity has no sign."
        => |b| b.amt58.inputs = |shown, octets| inputs(&with_velocity(shown, shown.velocity.wrapping_abs()), octets);
    "speed-unit-not-checked" "Unit 2 is accepted, and the velocity is in tenths of a revolution per minute."
        => |b| {
            b.amt58.unit = |code| if code == 2 { Some(Unit::RevolutionsPerSecond) } else { unit(code) };
            b.velocity.velocity(|way, right| match way.unit {
                Unit::RevolutionsPerSecond => MeasuredWay { unit: Unit::Rpm, steps: way.steps * 10, ..*way }.velocity(),
                _ => right,
            });
        };
    "noise-shows-as-speed" "At standstill the velocity is 1 once in a hundred cycles."
        => |b| b.amt58.inputs = |shown, octets| {
            let noise = shown.velocity == 0 && shown.count % 100 == 99;
            inputs(&with_velocity(shown, shown.velocity + i32::from(noise)), octets);
        };
    "preset-shows-as-speed" "The jump of the position by a preset is taken for a velocity."
        => |b| b.amt58.inputs = |shown, octets| {
            let jump = if shown.is_preset { shown.position.wrapping_sub(shown.truth_before.0) as i32 } else { 0 };
            inputs(&with_velocity(shown, shown.velocity.wrapping_add(jump)), octets);
        };
};

fn with_position<'a>(shown: &Shown<'a>, position: u32) -> Shown<'a> {
    Shown { position, ..*shown }
}

fn with_velocity<'a>(shown: &Shown<'a>, velocity: i32) -> Shown<'a> {
    Shown { velocity, ..*shown }
}
