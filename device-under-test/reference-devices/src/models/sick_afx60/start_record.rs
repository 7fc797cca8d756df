//! The vendor-specific record of the start-up, 0x1000. Manual, 3.6.10 to 3.6.17. The figure with its layout is missing; the layout
//! is invented: byte 0 save mode (0 automatic, 1 by P971), 1 whether the preset value is transmitted, 2 round axis (1
//! off, 2 on), 3 sampling interval in ms, 4 number of measurements, 5-8 nominator, 9-12 divisor, 13-16 preset value.
//!
//! Interpretation: like record 0xBF00 it belongs to the start-up. If a value is out of its limits, nothing of the record is applied
//! and an invalid parameter is reported. Without the record the factory settings are in force.

use super::hooks::Afx60Check;
use super::limits::LimitSettings;
use super::round_axis::{OFF, ON};
use super::{Afx60State, PoweredEncoder, limits, round_axis};
use device_stack::profinet::{RecordAccess, RecordRefusal};
use encoder_profile::encoder_object::ConnectionPhase;
use wire::octets::ByteReader;

/// Record index.
pub const RECORD: u16 = 0x1000;
/// Number of bytes.
pub const OCTETS: usize = 17;

/// The fields of the record, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartRecordFields {
    /// Save mode: 0 automatic, 1 by P971.
    pub save_mode: u8,
    /// Whether the preset value is transmitted: 0 or 1.
    pub transmits: u8,
    /// Round axis: 1 off, 2 on.
    pub axis: u8,
    /// T1, the sampling interval in milliseconds.
    pub interval: u8,
    /// T2, the number of measurements per mean.
    pub measurements: u8,
    /// CNR_N, the nominator of the round axis.
    pub nominator: u32,
    /// CNR_D, the divisor of the round axis.
    pub divisor: u32,
    /// The preset value.
    pub preset_value: u32,
}

impl StartRecordFields {
    /// The values in force without the record: factory settings, saved by P971.
    pub const WITHOUT: StartRecordFields = StartRecordFields {
        save_mode: 1,
        transmits: 0,
        axis: OFF as u8,
        interval: 2,
        measurements: 10,
        nominator: 2048,
        divisor: 1,
        preset_value: 0,
    };

    fn parse(octets: &[u8]) -> wire::Result<StartRecordFields> {
        let mut reader = ByteReader::new("vendor-specific parameter data", octets);
        let [save_mode, transmits, axis, interval, measurements] = reader.array()?;
        let (nominator, divisor, preset_value) = (reader.u32()?, reader.u32()?, reader.u32()?);
        Ok(StartRecordFields { save_mode, transmits, axis, interval, measurements, nominator, divisor, preset_value })
    }

    fn is_right(&self) -> bool {
        self.save_mode <= 1
            && self.transmits <= 1
            && (OFF..=ON).contains(&self.axis.into())
            && (1..=100).contains(&self.interval)
            && (1..=200).contains(&self.measurements)
            && (1..=2048).contains(&self.nominator)
            && (1..=65535).contains(&self.divisor)
    }

    fn has_axis(&self) -> bool {
        u32::from(self.axis) == ON
    }
}

/// Checks and applies the record.
pub fn write_start_record(
    live: &mut PoweredEncoder<'_, Afx60State>,
    access: RecordAccess,
    octets: &[u8],
) -> Result<(), RecordRefusal> {
    if !live.is_at_access_point(&access) {
        return Err(RecordRefusal::InvalidIndex);
    }
    if octets.len() != OCTETS {
        return Err(RecordRefusal::WriteLength);
    }
    if !access.ar.is_some_and(|ar| live.ram.phase == ConnectionPhase::Parameters(ar)) {
        return Err(RecordRefusal::StateConflict);
    }
    let fields = StartRecordFields::parse(octets).map_err(|_| RecordRefusal::WriteLength)?;
    let fields = live.model.hooks.0.apply(fields, |hooks, fields| hooks.start_record(fields));
    let is_right = fields.is_right() && (!fields.has_axis() || round_axis::has_axis(live));
    if live.model.hooks.check(Afx60Check::StartRecord(fields), is_right) {
        apply(live, &fields);
    } else {
        live.model.record_is_wrong = true;
    }
    Ok(())
}

/// Applies the fields of a valid record.
fn apply(live: &mut PoweredEncoder<'_, Afx60State>, fields: &StartRecordFields) {
    let is_stored = live.store.preset_value.writes() > 0;
    if live.model.hooks.check(Afx60Check::StartPresetValue { is_stored }, fields.transmits == 1) {
        live.set_preset_value(fields.preset_value);
    }
    let Afx60State { saves_each_change, limits: LimitSettings { speed, .. }, axis, .. } = &mut *live.model;
    *saves_each_change = fields.save_mode == 0;
    (speed.refresh_time, speed.measurements) = (fields.interval.into(), fields.measurements.into());
    axis.set_mode(fields.has_axis());
    (axis.nominator, axis.divisor) = (fields.nominator, fields.divisor);
    limits::measure_speed(live);
}
