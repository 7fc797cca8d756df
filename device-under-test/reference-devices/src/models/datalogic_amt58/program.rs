//! What Set_Prm asks for: the operating bits and the scaling behind the octets of the network, and what is made of them.
//!
//! Octets of the telegram: 7 to 9 network, 10 operating bits, 11 to 14 counts per revolution, 15 to 18 total resolution, 19 unit
//! of the velocity, 20 reserved (manual, 6.4). The user octets begin with octet 7.

use super::knobs::{Rules, Zone};
use encoder_profile::encoder::{Direction, Hardware, RedZone, Scaling, Settings, Unit};
use wire::profibus::cfg::{Identifier, Sums, sums};

/// How many user octets there are.
pub const OCTETS: usize = 14;

/// Where the operating bits stand among the user octets.
pub const OPERATING: usize = 3;
const UNITS: usize = 4;
const RANGE: usize = 8;
/// Where the unit of the velocity stands.
pub const SPEED_UNIT: usize = 12;
/// Where the last octet stands, which is reserved.
pub const LAST: usize = 13;

/// Bits of the operating parameters.
pub const CODE_SEQUENCE: u8 = 0x01;
/// Class 2 is on.
pub const CLASS_2: u8 = 0x02;
/// Scaling is on.
pub const SCALING: u8 = 0x08;
/// The diagnosis is extended.
pub const EXTENDED: u8 = 0x40;
/// The velocity is exchanged.
pub const VELOCITY: u8 = 0x80;

/// What the encoder was told to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// The user octets as they came.
    pub octets: [u8; OCTETS],
    /// The operating bits that have an effect.
    pub operating: u8,
    /// In which direction positions rise.
    pub direction: Direction,
    /// Whether the functions of Class 2 are on.
    pub is_class_2: bool,
    /// Whether scaling acts.
    pub scales: bool,
    /// Whether the diagnosis is extended.
    pub is_extended: bool,
    /// Whether the velocity is exchanged.
    pub has_velocity: bool,
    /// The scaling in force: that of the hardware where scaling does not act.
    pub scaling: Scaling,
    /// The scaling as it was sent.
    pub sent: Scaling,
    /// The unit of the velocity.
    pub unit: Unit,
}

/// A scaling that is to be looked at.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    /// As it was sent.
    pub sent: Scaling,
    /// As it was forced to the limits of the hardware.
    pub clamped: Scaling,
    /// The hardware.
    pub hardware: Hardware,
}

impl Scales {
    /// The scaling of user octets.
    pub fn of(user: &[u8], hardware: &Hardware) -> Scales {
        let mut octets = [0; OCTETS];
        for (octet, sent) in octets.iter_mut().zip(user) {
            *octet = *sent;
        }
        let sent = Scaling { units_per_revolution: number(&octets, UNITS), range: number(&octets, RANGE) };
        Scales { sent, clamped: clamped(sent, hardware), hardware: *hardware }
    }

    /// Whether its number of revolutions is no power of two.
    pub fn has_zone(&self) -> bool {
        zone(&self.clamped, &self.hardware).1 > 0
    }
}

/// Why parameters were not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// They are wrong.
    Wrong,
    /// They stop the device.
    Stops,
}

impl Program {
    /// An encoder that was told nothing yet: Class 1.
    pub fn unprogrammed(hardware: &Hardware) -> Program {
        Program {
            octets: [0; OCTETS],
            operating: 0,
            direction: Direction::Clockwise,
            is_class_2: false,
            scales: false,
            is_extended: false,
            has_velocity: false,
            scaling: Scaling::hardware(hardware),
            sent: Scaling { units_per_revolution: 0, range: 0 },
            unit: Unit::Rpm,
        }
    }

    /// Reads user octets; `before` is what was in force, `first` the first program that was ever taken.
    pub fn read(
        user: &[u8],
        hardware: &Hardware,
        before: &Program,
        first: Option<&Program>,
        rules: &Rules,
    ) -> Result<Program, Refused> {
        if !(rules.takes_length)(user.len()) {
            return Err(Refused::Wrong);
        }
        let mut octets = if rules.fills_from_before { before.octets } else { [0; OCTETS] };
        for (octet, sent) in octets.iter_mut().zip(user) {
            *octet = *sent;
        }
        if !(rules.takes_octets)(&octets) {
            return Err(Refused::Wrong);
        }
        let bits = octets[OPERATING];
        let (is_class_2, unit_code) = (bits & CLASS_2 != 0, octets[SPEED_UNIT]);
        let scales = (rules.scales)(bits);
        let is_extended = (rules.is_extended)(bits);
        let has_velocity = (rules.has_velocity)(bits, unit_code);
        let is_reversed = bits & CODE_SEQUENCE != 0;
        let sent = Scales::of(&octets, hardware).sent;
        let clamped = (rules.clamped)(sent, hardware);
        if (rules.checks_scaling)(scales, &octets) {
            if (rules.stops_at)(&sent) {
                return Err(Refused::Stops);
            }
            if !(rules.takes_scaling)(&Scales { sent, clamped, hardware: *hardware }) {
                return Err(Refused::Wrong);
            }
        }
        let unit = match (rules.checks_unit)(has_velocity) {
            true => (rules.unit)(unit_code).ok_or(Refused::Wrong)?,
            false => Unit::Rpm,
        };
        let flags = [
            (is_reversed, CODE_SEQUENCE),
            (is_class_2, CLASS_2),
            (scales, SCALING),
            (is_extended, EXTENDED),
            (has_velocity, VELOCITY),
        ];
        let program = Program {
            octets,
            operating: flags.iter().filter(|(is_set, _)| *is_set).map(|(_, bit)| bit).sum(),
            direction: if is_reversed { Direction::Counterclockwise } else { Direction::Clockwise },
            is_class_2,
            scales,
            is_extended,
            has_velocity,
            scaling: if scales { clamped } else { Scaling::hardware(hardware) },
            sent,
            unit,
        };
        Ok((rules.in_force)(program, first))
    }

    /// The settings of the measuring task; the red zone ends with the last position of the range (manual, 6.9).
    pub fn settings(&self) -> Settings {
        Settings { red_zone: RedZone::ToTheEnd, ..Settings::scaled(self.direction, self.scaling, true) }
    }

    /// 0 for Class 1, 1 for Class 2, 2 for Class 2 with velocity.
    pub fn class(&self) -> usize {
        usize::from(self.is_class_2) + usize::from(self.has_velocity)
    }

    /// The identifiers that belong to the class (manual, 6.5).
    pub fn identifiers(&self) -> &'static [u8] {
        if self.has_velocity { &[0xD3, 0xE1] } else { &[0xD1, 0xE1] }
    }

    /// How much is exchanged, if the identifiers are those of the class.
    pub fn check(&self, identifiers: &[u8]) -> Option<Sums> {
        (identifiers == self.identifiers()).then(|| lengths(identifiers))
    }
}

/// How much identifiers say is exchanged; nothing if they say nonsense.
pub fn lengths(identifiers: &[u8]) -> Sums {
    Identifier::parse_all(identifiers).map(|all| sums(&all)).unwrap_or_default()
}

fn number(octets: &[u8; OCTETS], at: usize) -> u64 {
    octets.iter().skip(at).take(4).fold(0, |number, octet| number << 8 | u64::from(*octet))
}

/// A scaling that is too large is forced to that of the hardware (manual, 6.4.2 and 6.4.3).
pub fn clamped(sent: Scaling, hardware: &Hardware) -> Scaling {
    Scaling {
        units_per_revolution: sent.units_per_revolution.min(hardware.steps_per_revolution),
        range: sent.range.min(hardware.range()),
    }
}

/// Whether a scaling has at least one unit and one revolution and no more revolutions than the hardware.
pub fn is_possible(scaling: &Scaling, hardware: &Hardware) -> bool {
    let Scaling { units_per_revolution, range } = *scaling;
    units_per_revolution > 0
        && range >= units_per_revolution
        && range <= units_per_revolution.saturating_mul(hardware.revolutions)
}

/// The unit of a code (manual, 6.4.4).
pub fn unit(code: u8) -> Option<Unit> {
    match code {
        0 => Some(Unit::Rpm),
        1 => Some(Unit::PerSecond),
        _ => None,
    }
}

/// The units of all revolutions, and those that are no whole range at their end: the red zone (manual, 6.9).
pub fn zone(scaling: &Scaling, hardware: &Hardware) -> (u128, u128) {
    let all = scaling.units(hardware, hardware.range());
    (all, scaling.within_range(all).into())
}

/// Whether the shaft is in the red zone.
pub fn is_in_zone(of: &Zone<'_>) -> bool {
    if !of.program.scales {
        return false;
    }
    let (all, zone) = zone(&of.program.scaling, of.hardware);
    zone > 0 && of.program.scaling.units(of.hardware, of.place) >= all - zone
}
