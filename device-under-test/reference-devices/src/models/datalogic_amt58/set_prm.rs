//! The parameters of Set_Prm (manual, 6.4).
//!
//! Bytes of the telegram: 7 to 9 network, 10 operating parameters, 11 to 14 counts per revolution, 15 to 18 total resolution,
//! 19 velocity unit, 20 reserved. The user bytes begin with byte 7.

use super::encoder::Amt58;
use super::hooks::{Amt58Check, NewOffset};
use super::scaling::SentScaling;
use encoder_profile::encoder::{CountingDirection, Hardware, MeasuringSettings, RedZone, Scaling, VelocityUnit};
use station::Time;

/// The number of user bytes.
pub const OCTETS: usize = 14;
/// The user byte with the operating parameters: byte 10.
pub const OPERATING: usize = 3;
/// The first user byte of the counts per revolution: byte 11.
pub const COUNTS: usize = 4;
/// The first user byte of the total resolution: byte 15.
pub const RESOLUTION: usize = 8;
/// The user byte with the unit of the velocity: byte 19.
pub const VELOCITY_UNIT: usize = 12;
/// The last user byte, which is reserved: byte 20.
pub const RESERVED: usize = 13;

/// Code sequence: positions rise counterclockwise (6.4.1, bit 0).
pub const CODE_SEQUENCE: u8 = 0x01;
/// Class 2 functionality (6.4.1, bit 1).
pub const CLASS_2: u8 = 0x02;
/// Scaling function control (6.4.1, bit 3).
pub const SCALING: u8 = 0x08;
/// Diagnostic type: extended (6.4.1, bit 6).
pub const EXTENDED: u8 = 0x40;
/// Exchange type: position and velocity (6.4.1, bit 7).
pub const VELOCITY: u8 = 0x80;

/// The parameters in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderParameters {
    /// The operating parameters that have an effect: byte 8 of the diagnosis.
    pub operating: u8,
    /// The direction in which positions rise.
    pub direction: CountingDirection,
    /// Whether the functions of Class 2 are on.
    pub is_class_2: bool,
    /// Whether scaling acts.
    pub scales: bool,
    /// Whether the diagnosis is extended.
    pub is_extended: bool,
    /// Whether the velocity is exchanged.
    pub has_velocity: bool,
    /// Counts per revolution and total resolution: those of the hardware if scaling is off.
    pub scaling: Scaling,
    /// The velocity unit.
    pub unit: VelocityUnit,
}

impl EncoderParameters {
    /// Returns the parameters before any Set_Prm: Class 1; invented.
    pub fn before_set_prm(hardware: &Hardware) -> EncoderParameters {
        EncoderParameters {
            operating: 0,
            direction: CountingDirection::Clockwise,
            is_class_2: false,
            scales: false,
            is_extended: false,
            has_velocity: false,
            scaling: Scaling::hardware(hardware),
            unit: VelocityUnit::Rpm,
        }
    }

    /// Returns the measuring settings. The red zone ends with the last position of the range (6.9).
    pub fn settings(&self) -> MeasuringSettings {
        MeasuringSettings {
            red_zone: RedZone::ToTheEnd,
            ..MeasuringSettings::scaled(self.direction, self.scaling, true)
        }
    }

    /// Parses user bytes; `None` if the parameters are invalid.
    fn read(
        user: &[u8],
        hardware: &Hardware,
        check: impl Fn(Amt58Check<'_>, bool) -> bool,
    ) -> Option<EncoderParameters> {
        if !check(Amt58Check::UserOctets(user), user.len() == OCTETS) {
            return None;
        }
        let octets: &[u8; OCTETS] = user.first_chunk()?;
        let (bits, unit) = (octets[OPERATING], octets[VELOCITY_UNIT]);
        // Scaling, extended diagnosis and velocity are functions of Class 2 (6.4.1).
        let is_class_2 = has(bits, CLASS_2);
        let scales = check(Amt58Check::Scales(bits), has(bits, CLASS_2 | SCALING));
        let is_extended = check(Amt58Check::IsExtended(bits), has(bits, CLASS_2 | EXTENDED));
        let has_velocity = check(Amt58Check::HasVelocity(bits), has(bits, CLASS_2 | VELOCITY));
        let scaling = SentScaling::new(number(octets, COUNTS), number(octets, RESOLUTION), hardware);
        if scales && !check(Amt58Check::Scaling(scaling), scaling.is_possible()) {
            return None;
        }
        // The units are 0 and 1 (6.4.4). Without velocity the byte is reserved.
        if has_velocity && !check(Amt58Check::Unit(unit), unit <= 1) {
            return None;
        }
        let is_reversed = has(bits, CODE_SEQUENCE);
        let in_effect = [
            (is_reversed, CODE_SEQUENCE),
            (is_class_2, CLASS_2),
            (scales, SCALING),
            (is_extended, EXTENDED),
            (has_velocity, VELOCITY),
        ];
        Some(EncoderParameters {
            operating: in_effect.iter().filter(|(acts, _)| *acts).map(|(_, bit)| bit).sum(),
            direction: if is_reversed { CountingDirection::Counterclockwise } else { CountingDirection::Clockwise },
            is_class_2,
            scales,
            is_extended,
            has_velocity,
            scaling: if scales { scaling.forced } else { Scaling::hardware(hardware) },
            unit: if has_velocity && unit == 1 { VelocityUnit::PerSecond } else { VelocityUnit::Rpm },
        })
    }
}

/// Returns whether all bits of `mask` are set.
pub fn has(bits: u8, mask: u8) -> bool {
    bits & mask == mask
}

/// Reads four user bytes from `at` on as a number, most significant byte first.
pub fn number(user: &[u8], at: usize) -> u32 {
    user.iter().skip(at).take(4).fold(0, |number, octet| number << 8 | u32::from(*octet))
}

impl Amt58 {
    /// Applies the user bytes of Set_Prm if they are valid. The preset offset does not change.
    pub(super) fn take_parameters(&mut self, now: Time, user: &[u8]) -> bool {
        self.sample(now);
        self.ram.has_expired = false;
        let read = EncoderParameters::read(user, &self.ram.hardware, |check, verdict| self.check(now, check, verdict));
        self.ram.is_invalid = read.is_none();
        let Some(parameters) = read else { return false };
        let parameters =
            self.hooks.apply(parameters, |hooks, parameters| hooks.parameters(&self.view(now), user, parameters));
        self.ram.parameters = parameters;
        self.ram.measuring.settings = parameters.settings();
        self.ram.velocity.set_unit(parameters.unit);
        let offset = self.ram.offset;
        let offset = self.hooks.apply(offset, |hooks, offset| hooks.offset(&self.view(now), NewOffset::SetPrm, offset));
        self.use_offset(offset);
        true
    }
}
