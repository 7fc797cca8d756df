//! The description of a device in the answer to `hello`.

use crate::hex::HexText;
use device_stack::profibus::SlaveIdentity;
use device_stack::profinet::{IoIdentity, PluggableSubmodule};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// What a program says of the device that it implements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ApplicationDescription {
    /// The version of the messages that the program speaks.
    pub version: u32,
    /// The program and its version, for reports.
    pub name: String,
    /// What `act`, `led` and `counter` can do, by the names of `stand` in a bench file: `shaft.counts`, `fault.NAME`, `led.NAME`.
    #[serde(default)]
    pub stand: Vec<String>,
    /// The device on PROFINET.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profinet: Option<DescribedIoDevice>,
    /// The slave on PROFIBUS.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profibus: Option<DescribedDpSlave>,
}

/// A device on PROFINET, as in its GSDML and in I&M0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DescribedIoDevice {
    /// Vendor number.
    pub vendor_id: u16,
    /// Device number.
    pub device_id: u16,
    /// TypeOfStation of DCP.
    pub station_type: String,
    /// Order number, at most 20 characters.
    pub order_id: String,
    /// Serial number, at most 16 characters.
    pub serial_number: String,
    /// Hardware revision.
    #[serde(default)]
    pub hardware_revision: u16,
    /// Software revision: prefix letter, functional enhancement, bug fix, internal change.
    #[serde(default = "first_version")]
    pub software_revision: (char, u8, u8, u8),
    /// Profile id of I&M0.
    #[serde(default)]
    pub profile_id: u16,
    /// Profile specific type of I&M0.
    #[serde(default)]
    pub profile_specific_type: u16,
    /// Bit n is set if I&M n is supported; the stack keeps their content.
    #[serde(default)]
    pub im_supported: u16,
    /// Number of Ethernet ports.
    #[serde(default = "one")]
    pub ports: u16,
    /// Time from power-up to the first frame, in milliseconds.
    #[serde(default = "second")]
    pub boot_ms: u64,
    /// Whether the program wants to know name and addresses of the station (`station`).
    #[serde(default)]
    pub station: bool,
    /// Every submodule that can be plugged. Alternatives for one subslot follow each other, the default one first.
    pub submodules: Vec<DescribedSubmodule>,
}

fn first_version() -> (char, u8, u8, u8) {
    ('V', 1, 0, 0)
}

fn one() -> u16 {
    1
}

fn second() -> u64 {
    1_000
}

/// A submodule that can be plugged, with its module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DescribedSubmodule {
    /// Application process.
    #[serde(default)]
    pub api: u32,
    /// Slot.
    pub slot: u16,
    /// Ident number of the module.
    pub module_ident: u32,
    /// Subslot.
    pub subslot: u16,
    /// Ident number of the submodule.
    pub submodule_ident: u32,
    /// Bytes of inputs.
    #[serde(default)]
    pub inputs: u16,
    /// Bytes of outputs.
    #[serde(default)]
    pub outputs: u16,
}

/// A slave on PROFIBUS, as in its GSD.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DescribedDpSlave {
    /// Ident_Number.
    pub ident: u16,
    /// The identifiers that Get_Cfg reports before a configuration was accepted.
    pub configuration: HexText,
    /// Time from power-up to the first answer, in milliseconds.
    #[serde(default = "second")]
    pub boot_ms: u64,
    /// Freeze_Mode_supp.
    #[serde(default)]
    pub freeze: bool,
    /// Sync_Mode_supp.
    #[serde(default)]
    pub sync: bool,
    /// Fail_Safe.
    #[serde(default)]
    pub fail_safe: bool,
    /// Whether the first three bytes of the user parameters are those of DP-V1.
    #[serde(default)]
    pub dpv1: bool,
    /// Whether a class 1 master can read and write records.
    #[serde(default)]
    pub ms1: bool,
    /// Number of connections of class 2 masters.
    #[serde(default)]
    pub ms2: u8,
    /// Whether the station address can be set over the bus (Set_Slave_Add_Supp); the stack keeps it.
    #[serde(default)]
    pub set_address: bool,
    /// Whether the application follows Global_Control (`clock`).
    #[serde(default)]
    pub clock: bool,
}

/// Text for the whole run, for the identities of the stacks. A run has one program, and each start of it says the same.
fn for_the_run(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

impl DescribedIoDevice {
    /// The identity for the stack.
    pub(crate) fn identity(&self) -> IoIdentity {
        let (prefix, functional, bug_fix, internal) = self.software_revision;
        IoIdentity {
            vendor_id: self.vendor_id,
            device_id: self.device_id,
            station_type: for_the_run(&self.station_type),
            order_id: for_the_run(&self.order_id),
            serial_number: self.serial_number.clone(),
            ports: self.ports,
            hardware_revision: self.hardware_revision,
            software_revision: [u8::try_from(prefix).unwrap_or(b'V'), functional, bug_fix, internal],
            revision_counter: 0,
            profile_id: self.profile_id,
            profile_specific_type: self.profile_specific_type,
            im_version: [1, 1],
            im_supported: self.im_supported,
            boot_time: Duration::from_millis(self.boot_ms),
            has_fast_start_up: false,
        }
    }

    /// The submodules for the stack.
    pub(crate) fn plugs(&self) -> Vec<PluggableSubmodule> {
        let plug = |of: &DescribedSubmodule| PluggableSubmodule {
            api: of.api,
            slot: of.slot,
            module_ident: of.module_ident,
            subslot: of.subslot,
            submodule_ident: of.submodule_ident,
            input_octets: of.inputs,
            output_octets: of.outputs,
        };
        self.submodules.iter().map(plug).collect()
    }

    /// What the stack could not do with this description, in words.
    fn problem(&self) -> Option<String> {
        let printable = |text: &str| text.bytes().all(|octet| octet == b' ' || octet.is_ascii_graphic());
        let texts = [
            ("station_type", &self.station_type, 240),
            ("order_id", &self.order_id, 20),
            ("serial_number", &self.serial_number, 16),
        ];
        if let Some((name, _, most)) = texts.iter().find(|(_, text, most)| text.len() > *most || !printable(text)) {
            return Some(format!("`{name}` has to be at most {most} characters of ASCII"));
        }
        if !(1..=8).contains(&self.ports) {
            return Some("`ports` has to be 1 to 8".to_owned());
        }
        if !self.submodules.iter().any(|of| of.slot == 0) {
            return Some("`submodules` lacks the access point in slot 0".to_owned());
        }
        let stack = self.submodules.iter().find(|of| of.subslot == 0 || of.subslot >= 0x8000);
        stack.map(|of| format!("subslot {} is not for an application; the stack adds interface and ports", of.subslot))
    }
}

impl DescribedDpSlave {
    /// The identity for the stack.
    pub(crate) fn identity(&self) -> SlaveIdentity {
        SlaveIdentity {
            ident: self.ident,
            boot_time: Duration::from_millis(self.boot_ms),
            freeze: self.freeze,
            sync: self.sync,
            fail_safe: self.fail_safe,
            dpv1: self.dpv1,
            ms1: self.ms1,
            extra_alarm_sap: false,
            ms2: self.ms2.into(),
            abilities: None,
            isochronous: false,
            set_ext_prm: false,
        }
    }
}

impl ApplicationDescription {
    /// What is wrong with this description, in words.
    pub(crate) fn problem(&self) -> Option<String> {
        self.profinet.as_ref().and_then(DescribedIoDevice::problem)
    }
}
