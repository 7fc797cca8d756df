//! The value ranges of a connection (IEC 61158-6-10 and IEC 61158-5-10, context management).
//!
//! To send values out of range on purpose, set [`ArConfig::unchecked`].

use super::connection::{ArConfig, DeviceAddress};
use super::layout::Layout;
use core::fmt;
use wire::profinet::blocks::connect::RtClass;
use wire::profinet::rt::{FrameId, FrameKind, LONGEST_DATA};

/// A value of a [`ArConfig`] that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitError {
    /// The field name in the standard.
    pub field: &'static str,
    /// The value.
    pub value: u64,
    /// The allowed range, as text.
    pub allowed: &'static str,
}

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, allowed is {}", self.field, self.value, self.allowed)
    }
}

/// A field, its value, whether the value is allowed, and the allowed range as text.
type LimitCheck = (&'static str, u64, bool, &'static str);

impl ArConfig {
    /// Checks every value; the error names the first field that is out of range.
    pub fn check(&self) -> Result<(), LimitError> {
        let wrong = self.names().into_iter().chain(self.timing()).chain(self.data()).find(|(_, _, good, _)| !good);
        match wrong {
            Some((field, value, _, allowed)) => Err(LimitError { field, value, allowed }),
            None => Ok(()),
        }
    }

    fn names(&self) -> [LimitCheck; 3] {
        let name = match &self.device {
            DeviceAddress::Name(name) => name.len(),
            DeviceAddress::Mac(_) => 1,
        };
        let own = self.station_name.as_ref().map_or(1, |name| name.len());
        let activity = self.activity_timeout_factor;
        [
            ("NameOfStation length", name as u64, (1..=240).contains(&name), "1 to 240"),
            ("CMInitiatorStationName length", own as u64, (1..=240).contains(&own), "1 to 240"),
            within("CMInitiatorActivityTimeoutFactor", activity, 1, 1000, "1 to 1000 (unit 100 ms)"),
        ]
    }

    fn timing(&self) -> [LimitCheck; 13] {
        let (clock, ratio) = (u64::from(self.send_clock_factor), u64::from(self.reduction_ratio));
        let (watchdog, hold) = (self.watchdog_factor, self.data_hold_factor);
        let units = clock * ratio * u64::from(watchdog);
        let references = self.iocr_references.0 != self.iocr_references.1;
        let power = self.reduction_ratio.is_power_of_two() && ratio <= 512;
        [
            within("SendClockFactor", self.send_clock_factor, 1, 128, "1 to 128 (unit 31.25 us)"),
            ("ReductionRatio", ratio, power, "a power of two, 1 to 512"),
            ("SendClockFactor x ReductionRatio", clock * ratio, clock * ratio <= 16_384, "at most 16384 (512 ms)"),
            within("Phase (input)", self.phase_in, 1, self.reduction_ratio, "1 to the ReductionRatio"),
            within("Phase (output)", self.phase_out, 1, self.reduction_ratio, "1 to the ReductionRatio"),
            ("IOCRReference", self.iocr_references.0.into(), references, "two that differ"),
            within("WatchdogFactor", watchdog, 1, 7680, "1 to 7680"),
            within("DataHoldFactor", hold, 1, 7680, "1 to 7680"),
            ("DataHoldFactor", hold.into(), hold >= watchdog, "at least the WatchdogFactor"),
            ("SendClockFactor x ReductionRatio x WatchdogFactor", units, units <= 61_440, "at most 61440 (1.92 s)"),
            within("RTATimeoutFactor", self.rta_timeout_factor, 1, 100, "1 to 100 (unit 100 ms)"),
            within("RTARetries", self.rta_retries, 3, 15, "3 to 15"),
            within("MaxAlarmDataLength", self.max_alarm_data_length, 200, 1432, "200 to 1432"),
        ]
    }

    fn data(&self) -> [LimitCheck; 7] {
        let class = self.rt_class;
        let known = matches!(class, RtClass::RT_CLASS_1 | RtClass::RT_CLASS_2);
        let of_class = |id: u16| match FrameId(id).kind() {
            FrameKind::RtClass1 => class == RtClass::RT_CLASS_1 && id < 0xF800,
            FrameKind::RtClass2 => class == RtClass::RT_CLASS_2 && id < 0xBC00,
            _ => false,
        };
        let (frame_id_in, frame_id_out) = (self.frame_id_in, self.frame_id_out);
        let out_good = frame_id_out == FrameId::DEVICE_CHOOSES.0 || of_class(frame_id_out);
        let layout = Layout::of(&self.submodules);
        let fits = |length: usize| length <= LONGEST_DATA;
        let (input, output) = (layout.input.data_length, layout.output.data_length);
        let enough = self.device_access || !self.submodules.is_empty();
        let twice = self.submodules.iter().enumerate().find(|(at, one)| {
            self.submodules[..*at].iter().any(|other| (other.slot, other.subslot) == (one.slot, one.subslot))
        });
        [
            ("RTClass", class.0.into(), known, "1 or 2"),
            ("FrameID (input)", frame_id_in.into(), of_class(frame_id_in), "a unicast id of the RT class"),
            ("FrameID (output)", frame_id_out.into(), out_good, "65535 or a unicast id of the RT class"),
            ("DataLength (input)", input as u64, fits(input), "at most 1440"),
            ("DataLength (output)", output as u64, fits(output), "at most 1440"),
            ("number of submodules", self.submodules.len() as u64, enough, "at least 1"),
            (
                "SubslotNumber",
                twice.map_or(0, |(_, one)| one.subslot.into()),
                twice.is_none(),
                "a subslot that its slot has only once",
            ),
        ]
    }
}

fn within(field: &'static str, value: u16, least: u16, most: u16, allowed: &'static str) -> LimitCheck {
    (field, value.into(), (least..=most).contains(&value), allowed)
}
