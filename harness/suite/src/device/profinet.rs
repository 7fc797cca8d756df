//! Facts of devices on PROFINET.

use super::Origin;
use serde::{Deserialize, Serialize};

/// The part of `device.yaml` that only devices on PROFINET have.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ProfinetFacts {
    pub identity: ProfinetIdentity,
    /// RT class of the cyclic frames: 1 or 2.
    pub rt_class: u8,
    /// Interface and ports: subslot of slot 0 and ident number of the submodule.
    pub network: Vec<(u16, u32)>,
    /// Whether it has an SNMP agent; without one a case that asks it is not applicable.
    pub has_snmp: bool,
    /// Whether it says Hello after record 0x8090; a case that waits for a Hello is not applicable without it.
    pub has_hello: bool,
    /// The submodule with the parameter access point (MAP/PAP), as an index into [`DeviceDescription::submodules`](super::DeviceDescription::submodules);
    /// `None`: the submodule of the current module that the start-up records are written to.
    pub parameter_point: Option<usize>,
}

/// The identity of a device type.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct ProfinetIdentity {
    /// Vendor ID assigned by PI.
    pub vendor_id: u16,
    /// Device ID of the vendor.
    pub device_id: u16,
    /// Type of station, as reported by DCP.
    pub station_type: String,
    /// Source of the device ID.
    pub device_id_origin: Origin,
}
