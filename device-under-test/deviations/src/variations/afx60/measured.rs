//! What the encoder measures besides the position: supply, temperature, speed, turns.

use super::super::rounding::{nearest_of_gear, nearest_position};
use crate::needs::Need;
use crate::tables::Group;
use encoder_profile::encoder::CountingDirection;
use encoder_profile::encoder::velocity::MeasuredWay;
use reference_devices::manuals;
use reference_devices::models::sick_afx60::StartRecordFields;
use reference_devices::models::sick_afx60::hooks::MeasuredSupply;

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        "warmer-inside" "The encoder is 12 degrees warmer than its surroundings, and the reading drifts by a degree."
            "3.5.5, Table 34 (1014): the operating temperature; neither place nor accuracy of the sensor is printed"
            => |d| d.afx60.measured(|now, right| {
                let drift = if now.as_nanos() / 1_700_000_000 % 2 == 0 { 0.0 } else { 1.0 };
                MeasuredSupply { celsius: right.celsius + 12.0 + drift, ..right }
            });
        "voltage-drop-inside" "The encoder measures a supply that is 0.4 V lower, and the reading drifts by 0.1 V."
            "3.5.5, Table 34 (1007, 1002.10): neither place nor accuracy of the measurement is printed"
            => |d| d.afx60.measured(|now, right| {
                let drift = if now.as_nanos() / 1_300_000_000 % 2 == 0 { 0.0 } else { 0.1 };
                MeasuredSupply { volts: right.volts - 0.4 - drift, ..right }
            });
        "long-filter-by-default" "By default the velocity is the mean of 100 measurements at 50 ms, or at 2 ms on the AFS60."
            "4.4, Figure 14: the default filter is not legible; 3.5.5, Table 34 (1005.2, 1005.3): up to 50 ms and 100"
            => |d| d.afx60.start_record(|fields| match (fields.interval, fields.measurements) {
                (2, 10) => StartRecordFields { measurements: 100, ..fields },
                _ => fields,
            });
        "velocity-sign-of-the-shaft" "The velocity is positive for clockwise rotation, whatever the code sequence is."
            "3.4.1, Table 5: signed; which direction is negative is not printed"
            => |d| d.velocity.velocity(|way, _| MeasuredWay { direction: CountingDirection::Clockwise, ..*way }.velocity());
        "scaled-positions-rounded" "A scaled position is rounded to the nearest step."
            "3.6.4, 3.6.7 and 3.6.12 do not print how a position is rounded"
            => |d| {
                d.measuring.scale(nearest_position);
                d.measuring.gear(nearest_of_gear);
            };
        "only-full-turns-count" "The service log counts a turn when it is complete."
            "3.5.5, Table 34 (1002.3, 1002.4): what the counters of rotation count is not printed"
            => |d| d.sick.turns(|begins, turns| if begins { 0 } else { turns });
        "only-begun-turns-count" "The service log counts each begin of a rotation."
            "3.5.5, Table 34 (1002.3, 1002.4): what the counters of rotation count is not printed"
            => |d| d.sick.turns(|begins, _| u32::from(begins));
        "acceleration-of-a-real-shaft" "The acceleration deviates by 3 rpm/s."
            "3.5.5, Table 34 (1002.7): no accuracy is printed"
            => |d| d.sick.log_element(7, |reading, log| {
                let noise = if reading.operating.as_millis() / 900 % 2 == 0 { 3 } else { -3 };
                u64::from((log[7] as i32).wrapping_add(noise) as u32)
            });
    },
};
