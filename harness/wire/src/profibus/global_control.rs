//! Global_Control: a command to the slaves of some groups or to all; nobody answers it.
//!
//! Source: IEC 61158-6-3, Global_Control.

use crate::codes::flags;
use crate::error::Result;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;

flags! {
    /// The command; the others of its bits are to be 0 (IEC 61158-6-3, Control_Command).
    pub struct ControlCommand(u8) {
        0x02 CLEAR_DATA clear_data "Outputs are cleared.",
        0x04 UNFREEZE unfreeze "Inputs follow the process again; it overrules freeze.",
        0x08 FREEZE freeze "Inputs are taken now and kept.",
        0x10 UNSYNC unsync "Outputs take effect at once again; it overrules sync.",
        0x20 SYNC sync "Outputs take effect now, and then with each further sync.",
    }
}

/// A command to slaves.
///
/// Octets: 0 command, 1 groups (IEC 61158-6-3, Global_Control request).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GlobalControl {
    /// What is to be done.
    pub command: ControlCommand,
    /// Group_Select: a bit for each of the groups 1 to 8; 0 means all slaves.
    pub groups: u8,
}

impl GlobalControl {
    /// Reads the data of a Global_Control request; fails if they are not two octets.
    pub fn parse(octets: &[u8]) -> Result<GlobalControl> {
        let mut reader = Reader::new("Global_Control", octets);
        let control = GlobalControl { command: ControlCommand(reader.u8()?), groups: reader.u8()? };
        reader.end("two octets")?;
        Ok(control)
    }

    /// Appends the data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.command.0, self.groups]);
    }

    /// Whether a slave of the groups `own`, as its Set_Prm has them, is meant.
    pub fn is_for(&self, own: u8) -> bool {
        self.groups == 0 || self.groups & own != 0
    }
}
