//! The supply state of a device.

use station::Time;

/// Whether a device has power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SupplyState {
    Off,
    Booting { until: Time },
    On,
}
