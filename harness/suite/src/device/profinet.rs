//! What only devices on PROFINET have.
//!
//! This is data about devices; which frames carry it is said elsewhere.

use super::Origin;
use serde::{Deserialize, Serialize};

/// What `device.yaml` says of a device on PROFINET alone.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ProfinetFacts {
    /// Which device it is.
    pub identity: Identity,
    /// The class of its cyclic frames: 1 or 2.
    pub rt_class: u8,
    /// The interface and the ports: subslot of slot 0 and ident of the submodule.
    pub network: Vec<(u16, u32)>,
    /// The submodule at which the base mode parameter access stands, as an index into [`Device::submodules`](super::Device::submodules);
    /// without one the one of the module in use that the records of the start-up go to.
    pub parameter_point: Option<usize>,
}

/// Which device it is.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Identity {
    /// Vendor ID of PI.
    pub vendor_id: u16,
    /// Device ID of the vendor.
    pub device_id: u16,
    /// Type of station, as DCP shows it.
    pub station_type: String,
    /// Where the device ID comes from.
    pub device_id_origin: Origin,
}
