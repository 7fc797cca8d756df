//! The contents of Set_Prm: the user bytes, and the times of isochronous operation.
//!
//! No manual prints the layout; it is invented, and follows the record of the profile for the same data. After the
//! three DP-V1 bytes: bytes 0 and 1 switches, 2-5 steps per revolution, 6-9 total range, 10 tolerated failures of the
//! sign of life, 11 unit of the speed, 12-15 nominator, 16-19 divisor, 20 samples, 21-23 reserved.
//!
//! Interpretation: without any user bytes the factory settings are in force. Only values in force are checked. If one is out of its limits, the parameters are refused as a whole.
//! A round axis needs class 2/4, like scaling, but does not need scaling.

use super::hooks::{A3m60Check, A3m60Deviations};
use super::{A3m60State, HARDWARE};
use crate::models::sick::axis::{LARGEST_FRACTION, LARGEST_RANGE};
use crate::models::sick::hooks::SickCheck;
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use core::time::Duration;
use encoder_profile::encoder::Gear;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::profidrive::telegram::STANDARD;
use encoder_profile::profidrive::user_parameters::{self, UserParameterData};
use wire::octets::{Append, ByteReader};
use wire::profibus::prm::{Dpv1Status3, Isochronous, PrmBlock, PrmBlockType, SetPrm};

/// The number of user bytes.
pub const OCTETS: usize = 24;
/// Permitted cycle times in nanoseconds: manual, table 24, P1008.3.
const CYCLES: RangeInclusive<u64> = 1_000_000..=32_000_000;

/// The fields of the user bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UserByteFields {
    /// Bytes 0 and 1. Byte 0 is that of the profile: bit 0 code sequence, 1 class 2/4, 2 preset control (0 is active), 3
    /// scaling, 4 alarm channel, 5 compatibility mode (0 is enabled). Byte 1: bit 0 round axis, 1 simulated clock, 2
    /// fault codes are shown, 3 the speed is calculated.
    pub switches: [u8; 2],
    /// Steps per revolution.
    pub units: u32,
    /// Total resolution.
    pub range: u32,
    /// Tolerated failures of the sign of life.
    pub failures: u8,
    /// Unit of the speed.
    pub speed_unit: u8,
    /// CNR_N, the nominator of the round axis.
    pub nominator: u32,
    /// CNR_D, the divisor of the round axis.
    pub divisor: u32,
    /// Number of samples per position.
    pub samples: u8,
}

/// Bits of byte 0.
const CLASS_4: u8 = 1 << 1;
const SCALING: u8 = 1 << 3;
/// Bits of byte 1.
const ROUND_AXIS: u8 = 1;
const SIMULATED: u8 = 1 << 1;
const FAULT_CODES: u8 = 1 << 2;
const SPEED: u8 = 1 << 3;

impl UserByteFields {
    /// The factory settings: manual, 4.4.5.
    pub const DELIVERED: UserByteFields = UserByteFields {
        switches: [CLASS_4, FAULT_CODES | SPEED],
        units: 16384,
        range: 1 << 31,
        failures: 1,
        speed_unit: 3,
        nominator: 4096,
        divisor: 1,
        samples: 8,
    };

    /// Parses the user bytes; `None` if there are too few.
    pub fn parse(octets: &[u8]) -> Option<UserByteFields> {
        let mut reader = ByteReader::new("user octets", octets);
        let switches = reader.array().ok()?;
        let (units, range) = (reader.u32().ok()?, reader.u32().ok()?);
        let [failures, speed_unit] = reader.array().ok()?;
        let (nominator, divisor) = (reader.u32().ok()?, reader.u32().ok()?);
        let samples = reader.u8().ok()?;
        Some(UserByteFields { switches, units, range, failures, speed_unit, nominator, divisor, samples })
    }

    fn has(&self, octet: usize, bit: u8) -> bool {
        self.switches[octet] & bit != 0
    }

    /// Returns whether the round axis is in force.
    pub fn has_axis(&self) -> bool {
        self.has(0, CLASS_4) && self.has(1, ROUND_AXIS)
    }

    /// Returns whether the clock of the bus is simulated.
    pub fn simulates(&self) -> bool {
        self.has(1, SIMULATED)
    }

    /// Returns whether a fault code replaces the position in the vendor telegrams.
    pub fn shows_codes(&self) -> bool {
        self.has(1, FAULT_CODES)
    }

    /// Returns whether the speed is calculated.
    pub fn measures_speed(&self) -> bool {
        self.has(1, SPEED)
    }

    /// Returns the gear of the round axis, in force or not.
    pub fn gear(&self) -> Gear {
        Gear { nominator: self.nominator.into(), divisor: self.divisor.into(), range: self.range.into() }
    }

    /// Writes the same settings as a record of the profile. A round axis works without scaling.
    pub fn record(&self) -> [u8; user_parameters::OCTETS] {
        let [bits, _] = self.switches;
        let mut record = Vec::with_capacity(user_parameters::OCTETS);
        record.put_u8(if self.has_axis() { bits & !SCALING } else { bits });
        record.put(&u64::from(self.units).to_be_bytes());
        record.put(&u64::from(self.range).to_be_bytes());
        record.put(&[self.failures, self.speed_unit]);
        let mut octets = [0; user_parameters::OCTETS];
        octets.iter_mut().zip(record).for_each(|(octet, set)| *octet = set);
        octets
    }
}

/// Returns the factory settings as user parameters of the profile.
pub fn delivered() -> UserParameterData {
    let UserByteFields { switches: [bits, _], units, range, failures, speed_unit, .. } = UserByteFields::DELIVERED;
    let scaling = encoder_profile::encoder::Scaling { units_per_revolution: units.into(), range: range.into() };
    UserParameterData::of(bits, scaling, failures, speed_unit)
}

/// The parsed contents of a Set_Prm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPrmContents {
    /// The user bytes.
    pub fields: UserByteFields,
    /// The times of isochronous operation.
    pub isochronous: Option<Isochronous>,
}

impl SetPrmContents {
    /// The settings in force without a Set_Prm.
    pub const DELIVERED: SetPrmContents = SetPrmContents { fields: UserByteFields::DELIVERED, isochronous: None };

    /// Parses a Set_Prm; `None` if there are too few or too many bytes.
    ///
    /// Two forms are accepted: structured blocks for user bytes and times, or plain user bytes followed by the block of the times.
    fn read(parameters: &SetPrm, hooks: &A3m60Deviations) -> Option<SetPrmContents> {
        let head = parameters.dpv1()?;
        let after_dpv1 = parameters.user_after_dpv1();
        let structured =
            head.status_3.has(Dpv1Status3::PRM_STRUCTURE).then(|| PrmBlock::parse_all(after_dpv1).ok()).flatten();
        let of =
            |blocks: &[PrmBlock], kind| blocks.iter().find(|block| block.kind == kind).map(|block| block.data.clone());
        let wrapped = structured.and_then(|blocks| Some((of(&blocks, PrmBlockType::USER_PRM_DATA)?, blocks)));
        let (user, blocks) = match wrapped {
            Some(wrapped) => wrapped,
            None => {
                let (user, blocks) = after_dpv1.split_at(after_dpv1.len().min(OCTETS));
                (user.to_vec(), PrmBlock::parse_all(blocks).ok()?)
            }
        };
        if !hooks.check(A3m60Check::UserOctets(user.len()), matches!(user.len(), 0 | OCTETS)) {
            return None;
        }
        let times = of(&blocks, PrmBlockType::ISOCHRONOUS).map(|data| Isochronous::parse(&data));
        let fields = if user.is_empty() {
            hooks.0.apply(UserByteFields::DELIVERED, |hooks, fields| hooks.delivered(fields))
        } else {
            UserByteFields::parse(&user)?
        };
        Some(SetPrmContents { fields, isochronous: times.transpose().ok()? })
    }
}

/// Parses and checks a Set_Prm; `None` if its parameters are invalid.
pub fn check_set_prm(live: &PoweredEncoder<'_, A3m60State>, parameters: &SetPrm) -> Option<SetPrmContents> {
    let brought = SetPrmContents::read(parameters, &live.model.hooks)?;
    are_right(live, &brought.fields, brought.isochronous.as_ref()).then_some(brought)
}

fn are_right(
    live: &PoweredEncoder<'_, A3m60State>,
    fields: &UserByteFields,
    isochronous: Option<&Isochronous>,
) -> bool {
    let Some(user) = UserParameterData::parse(&fields.record()) else { return false };
    let user = live.hooked_user_parameters(user);
    let is_served = user.are_right(&live.encoder(), &STANDARD[0]);
    let axis = !fields.has_axis() || axis_is_right(live, fields, &user);
    let hooks = &live.model.hooks;
    let follows = |times| hooks.check(A3m60Check::Cycle(cycle(times)), CYCLES.contains(&times.cycle_nanoseconds()));
    is_served
        && axis
        && hooks.check(A3m60Check::Samples(fields.samples), matches!(fields.samples, 1 | 2 | 4 | 8))
        && isochronous.is_none_or(follows)
}

/// Whether the encoder can serve a round axis: manual, 3.6.14 to 3.6.16. Its steps per revolution are at most those of the
/// hardware (interpretation).
fn axis_is_right(live: &PoweredEncoder<'_, A3m60State>, fields: &UserByteFields, user: &UserParameterData) -> bool {
    let Gear { nominator, divisor, range } = fields.gear();
    let fraction = 1..=LARGEST_FRACTION;
    let is_fine = range * divisor <= HARDWARE.steps_per_revolution * nominator;
    let shared = &live.model.shared;
    let takes = |at, value: u64, right| shared.check(SickCheck::Setting((1009, at), value as i64), right);
    let UserParameterData { units_per_revolution, .. } = *user;
    let has_range = SickCheck::RoundAxisRange { range: user.range, units_per_revolution };
    takes(1, nominator, fraction.contains(&nominator))
        && takes(2, divisor, fraction.contains(&divisor))
        && shared.check(has_range, (1..=LARGEST_RANGE).contains(&range) && is_fine)
}

/// Returns the cycle time.
pub fn cycle(times: &Isochronous) -> Duration {
    Duration::from_nanos(times.cycle_nanoseconds())
}
