//! Global_Control: a command to some groups of slaves or to all slaves; it is not answered.
//!
//! Source: IEC 61158-6-3, Global_Control.

use crate::codes::flags;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

flags! {
    /// The command; all other bits must be 0 (IEC 61158-6-3, Control_Command).
    pub struct GlobalCommand(u8) {
        0x02 CLEAR_DATA clear_data "Outputs are cleared.",
        0x04 UNFREEZE unfreeze "Inputs follow the process again; overrides freeze.",
        0x08 FREEZE freeze "Inputs are sampled now and held.",
        0x10 UNSYNC unsync "Outputs take effect at once again; overrides sync.",
        0x20 SYNC sync "Outputs take effect now, and after that only with each further sync.",
    }
}

/// A Global_Control command.
///
/// Bytes: 0 command, 1 groups (IEC 61158-6-3, Global_Control request).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GlobalControl {
    /// The command bits.
    pub command: GlobalCommand,
    /// Group_Select: a bit for each of the groups 1 to 8; 0 means all slaves.
    pub groups: u8,
}

impl GlobalControl {
    /// Parses the data of a Global_Control request; fails unless they are two bytes.
    pub fn parse(octets: &[u8]) -> Result<GlobalControl> {
        let mut reader = ByteReader::new("Global_Control", octets);
        let control = GlobalControl { command: GlobalCommand(reader.u8()?), groups: reader.u8()? };
        reader.end("two bytes")?;
        Ok(control)
    }

    /// Appends the data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.command.0, self.groups]);
    }

    /// Whether the command is for a slave of the groups `own`, which its Set_Prm has set.
    pub fn is_for(&self, own: u8) -> bool {
        self.groups == 0 || self.groups & own != 0
    }
}
