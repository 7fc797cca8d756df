//! Bugs that only the DP encoder without a manual can have: the manual of the AMT58 permits them, or says more.

use super::amt58::diagnosis::extend;
use super::amt58::values::{set_velocity, velocity};
use super::{Deviation, Group};
use crate::needs::Need;
use reference_devices::manuals::DP_ENCODER;

/// The group.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&DP_ENCODER)], deviations: BUGS }];

/// The bugs.
static BUGS: &[Deviation] = bugs! {
    "velocity-negated" "The velocity is negative while the position rises."
        => |d| d.amt58.inputs(|_, inputs| set_velocity(inputs, velocity(inputs).wrapping_neg()));
    "velocity-halved-backward" "While the position falls the velocity is half as large."
        => |d| d.amt58.inputs(|_, inputs| set_velocity(inputs, velocity(inputs).max(velocity(inputs) / 2)));
    "short-encoder-diagnosis" "The diagnosis ends after the encoder type."
        => |d| extend(d, |_, octets| {
            octets.truncate(4);
            if let Some(header) = octets.first_mut() {
                *header = 4;
            }
        });
};
