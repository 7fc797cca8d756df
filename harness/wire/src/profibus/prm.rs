//! Set_Prm: how a master takes a slave and parameterises it; Set_Ext_Prm: more of its structured blocks.
//!
//! This room must not know what the user octets mean: that is told by the GSD and the manual of the device. Source:
//! IEC 61158-6-3, Set_Prm and Set_Ext_Prm.

use crate::codes::{codes, flags};
use crate::error::Result;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;

flags! {
    /// What the master wants of the slave (IEC 61158-6-3, Station_Status of Set_Prm).
    pub struct StationStatus(u8) {
        0x08 WD_ON wd_on "The watchdog is to be on.",
        0x10 FREEZE_REQ freeze_req "The slave is to be able to freeze its inputs.",
        0x20 SYNC_REQ sync_req "The slave is to be able to synchronise its outputs.",
        0x40 UNLOCK_REQ unlock_req "Other masters may have the slave.",
        0x80 LOCK_REQ lock_req "Other masters may not have the slave; without this bit it takes none of the parameters but min TSDR.",
    }
}

flags! {
    /// The first octet of DP-V1 (IEC 61158-6-3, DPV1_Status_1).
    pub struct Dpv1Status1(u8) {
        0x04 WD_BASE_1MS wd_base_1ms "The watchdog counts in 1 ms, else in 10 ms.",
        0x20 PUBLISHER_ENABLE publisher_enable "The slave is to be a publisher: others may hear its inputs.",
        0x40 FAIL_SAFE fail_safe "Outputs without data mean clear; else outputs of zeros do.",
        0x80 DPV1_ENABLE dpv1_enable "The slave is to use DP-V1.",
    }
}

flags! {
    /// The second octet of DP-V1: how the configuration is checked, and which alarms the slave may send (IEC 61158-6-3, DPV1_Status_2).
    pub struct Dpv1Status2(u8) {
        0x01 CHECK_CFG_MODE check_cfg_mode "The user of the slave checks the configuration in its own way.",
        0x04 UPDATE_ALARM update_alarm "Update alarms may be sent.",
        0x08 STATUS_ALARM status_alarm "Status alarms may be sent.",
        0x10 MAKER_ALARM maker_alarm "Alarms of the maker may be sent.",
        0x20 DIAGNOSIS_ALARM diagnosis_alarm "Diagnosis alarms may be sent.",
        0x40 PROCESS_ALARM process_alarm "Process alarms may be sent.",
        0x80 PULL_PLUG_ALARM pull_plug_alarm "Pull and plug alarms may be sent.",
    }
}

/// The third octet of DP-V1: bits 2-0 how many alarms may be open, bit 3 structured blocks follow, bit 4 isochronous, bit 7
/// redundancy commands; bits 5 and 6 are reserved (IEC 61158-6-3, DPV1_Status_3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Dpv1Status3(pub u8);

impl Dpv1Status3 {
    /// Bit 3: what follows are structured blocks ([`PrmBlock`]).
    pub const PRM_STRUCTURE: u8 = 0x08;
    /// Bit 4: the slave is to work isochronously.
    pub const ISOCHRONOUS: u8 = 0x10;
    /// Bit 7: a redundancy command is among the blocks.
    pub const PRM_COMMAND: u8 = 0x80;

    /// Whether the bit or bits of `mask` are set.
    pub fn has(self, mask: u8) -> bool {
        self.0 & mask == mask
    }

    /// How many alarms may be open at once: 1 of each type for alarm mode 0, else this many in all.
    pub fn alarms(self) -> AlarmMode {
        match self.0 & 7 {
            0 => AlarmMode::OneOfEachType,
            mode => AlarmMode::InAll([2, 4, 8, 12, 16, 24, 32][usize::from(mode) - 1]),
        }
    }

    /// The reserved bits, which are to be 0.
    pub fn reserved(self) -> u8 {
        self.0 & 0x60
    }
}

/// How many alarms may be open at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AlarmMode {
    /// One of each type.
    OneOfEachType,
    /// So many, whatever their types: 2, 4, 8, 12, 16, 24 or 32.
    InAll(u8),
}

/// The parameters of a slave.
///
/// Octets: 0 station status, 1 and 2 watchdog factors, 3 min TSDR, 4-5 ident number, 6 groups, then up to 237 user octets, of
/// which the first three belong to DP-V1 where the GSD says so (IEC 61158-6-3, Set_Prm request).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetPrm {
    /// What the master wants.
    pub status: StationStatus,
    /// WD_Fact_1, 1 to 255.
    pub wd_fact_1: u8,
    /// WD_Fact_2, 1 to 255.
    pub wd_fact_2: u8,
    /// The least time until the slave answers, in bit times; below 11 the slave keeps what it had.
    pub min_tsdr: u8,
    /// Ident_Number; another one than the slave's own is refused.
    pub ident: u16,
    /// Group_Ident: a bit for each of the groups 1 to 8 to which the slave belongs.
    pub groups: u8,
    /// User_Prm_Data, with the octets of DP-V1.
    pub user: Vec<u8>,
}

/// The three octets of DP-V1 at the beginning of the user octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Dpv1 {
    /// Watchdog, publisher, fail safe, DP-V1.
    pub status_1: Dpv1Status1,
    /// Alarms and the check of the configuration.
    pub status_2: Dpv1Status2,
    /// Open alarms, structured blocks, isochronous, redundancy.
    pub status_3: Dpv1Status3,
}

impl SetPrm {
    /// The octets that every Set_Prm has.
    pub const HEAD: usize = 7;

    /// Reads the data of a Set_Prm request; fails only if there are fewer than seven octets.
    pub fn parse(octets: &[u8]) -> Result<SetPrm> {
        let mut reader = Reader::new("Set_Prm", octets);
        Ok(SetPrm {
            status: StationStatus(reader.u8()?),
            wd_fact_1: reader.u8()?,
            wd_fact_2: reader.u8()?,
            min_tsdr: reader.u8()?,
            ident: reader.u16()?,
            groups: reader.u8()?,
            user: reader.rest().to_vec(),
        })
    }

    /// Appends the data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.status.0, self.wd_fact_1, self.wd_fact_2, self.min_tsdr]);
        out.put_u16(self.ident);
        out.put_u8(self.groups);
        out.put(&self.user);
    }

    /// The first three user octets as those of DP-V1; none if there are fewer. Whether they are, the GSD of the device says.
    pub fn dpv1(&self) -> Option<Dpv1> {
        match self.user.as_slice() {
            [one, two, three, ..] => {
                Some(Dpv1 { status_1: Dpv1Status1(*one), status_2: Dpv1Status2(*two), status_3: Dpv1Status3(*three) })
            }
            _ => None,
        }
    }

    /// The user octets behind those of DP-V1.
    pub fn behind_dpv1(&self) -> &[u8] {
        self.user.get(3..).unwrap_or_default()
    }

    /// The time of the watchdog in milliseconds, counted in `base` milliseconds (10, or 1 by DP-V1); none if it is to be off.
    pub fn watchdog_ms(&self, base: u32) -> Option<u32> {
        let factors = u32::from(self.wd_fact_1) * u32::from(self.wd_fact_2);
        self.status.has(StationStatus::WD_ON).then(|| factors.saturating_mul(base))
    }
}

impl Dpv1 {
    /// The unit of the watchdog in milliseconds: 10 or 1.
    pub fn watchdog_base_ms(self) -> u32 {
        if self.status_1.has(Dpv1Status1::WD_BASE_1MS) { 1 } else { 10 }
    }

    /// The three octets.
    pub fn octets(self) -> [u8; 3] {
        [self.status_1.0, self.status_2.0, self.status_3.0]
    }
}

codes! {
    /// What a structured block holds; 32 to 128 belong to the maker (IEC 61158-6-3, Structure_Type).
    pub struct PrmBlockType(u8) {
        2 PRM_COMMAND prm_command "A redundancy command.",
        3 DXB_LINK_TABLE dxb_link_table "The publishers that the slave hears.",
        4 ISOCHRONOUS isochronous "The times of isochronous operation.",
        7 DXB_SUBSCRIBER_TABLE dxb_subscriber_table "Where the data of the publishers go.",
        8 TIME_AR time_ar "How often the time is told, and how late.",
        129 USER_PRM_DATA user_prm_data "Parameters of the user.",
    }
}

/// A structured block: behind the octets of DP-V1 in Set_Prm if these say so, and all that Set_Ext_Prm holds.
///
/// Octets: 0 length with this octet, 4 to 237; 1 type; 2 slot; 3 reserved; then data (IEC 61158-6-3, Structured_Prm_Data).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrmBlock {
    /// What the block holds.
    pub kind: PrmBlockType,
    /// The slot that is meant; 0 is the device.
    pub slot: u8,
    /// To be 0.
    pub reserved: u8,
    /// What belongs to the type.
    pub data: Vec<u8>,
}

impl PrmBlock {
    const HEAD: u8 = 4;

    /// Reads blocks to the end of `octets`; fails at a block that says it is shorter than its head or longer than what is left.
    pub fn parse_all(octets: &[u8]) -> Result<Vec<PrmBlock>> {
        let mut reader = Reader::new("structured parameters", octets);
        let mut blocks = Vec::new();
        while !reader.is_empty() {
            blocks.push(PrmBlock::read(&mut reader)?);
        }
        Ok(blocks)
    }

    fn read(reader: &mut Reader<'_>) -> Result<PrmBlock> {
        let length = reader.u8()?;
        if length < PrmBlock::HEAD {
            return Err(reader.wrong("Structure_Length", 1, "4 or more, with the head", length.into()));
        }
        let mut block = reader.sub(usize::from(length) - 1)?;
        Ok(PrmBlock {
            kind: PrmBlockType(block.u8()?),
            slot: block.u8()?,
            reserved: block.u8()?,
            data: block.rest().to_vec(),
        })
    }

    /// Appends the block; the caller sees to it that it has no more than 251 octets of data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[(self.data.len() as u8).wrapping_add(PrmBlock::HEAD), self.kind.0, self.slot, self.reserved]);
        out.put(&self.data);
    }
}

/// The times of isochronous operation: the data of a block of [`PrmBlockType::ISOCHRONOUS`], which is 28 octets long in all.
///
/// Octets: 0 version, 1-4 T_BASE_DP, 5-6 T_DP, 7 T_MAPC, 8-11 T_BASE_IO, 12-13 T_I, 14-15 T_O, 16-19 T_DX, 20-21 T_PLL_W, 22-23
/// T_PLL_D (IEC 61158-6-3, IsoM_Parameter).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Isochronous {
    /// Version of the block: 1.
    pub version: u8,
    /// Unit of `t_dp` in twelfths of a microsecond: 375, 750, 1500, 3000, 6000 or 12000.
    pub t_base_dp: u32,
    /// Time from one cycle to the next in `t_base_dp`, 1 to 65535.
    pub t_dp: u16,
    /// Cycles of the application of the master, in `t_dp`, 1 to 14.
    pub t_mapc: u8,
    /// Unit of `t_i` and `t_o` in twelfths of a microsecond: 375, 750, 1500, 3000, 6000 or 12000.
    pub t_base_io: u32,
    /// When the actual value is taken, before the end of the cycle, in `t_base_io`.
    pub t_i: u16,
    /// When the set point takes effect, after the beginning of the cycle, in `t_base_io`.
    pub t_o: u16,
    /// How long the Data_Exchange with all slaves lasts, in twelfths of a microsecond.
    pub t_dx: u32,
    /// Half the window in which Global_Control has to come, in twelfths of a microsecond; usually 12.
    pub t_pll_w: u16,
    /// The delay of Global_Control, in twelfths of a microsecond; usually 0.
    pub t_pll_d: u16,
}

impl Isochronous {
    /// Reads the data of a block; fails if they are not 24 octets.
    pub fn parse(octets: &[u8]) -> Result<Isochronous> {
        let mut reader = Reader::new("isochronous parameters", octets);
        let times = Isochronous {
            version: reader.u8()?,
            t_base_dp: reader.u32()?,
            t_dp: reader.u16()?,
            t_mapc: reader.u8()?,
            t_base_io: reader.u32()?,
            t_i: reader.u16()?,
            t_o: reader.u16()?,
            t_dx: reader.u32()?,
            t_pll_w: reader.u16()?,
            t_pll_d: reader.u16()?,
        };
        reader.end("24 octets")?;
        Ok(times)
    }

    /// Appends the data of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u8(self.version);
        out.put_u32(self.t_base_dp);
        out.put_u16(self.t_dp);
        out.put_u8(self.t_mapc);
        out.put_u32(self.t_base_io);
        out.put_u16(self.t_i);
        out.put_u16(self.t_o);
        out.put_u32(self.t_dx);
        out.put_u16(self.t_pll_w);
        out.put_u16(self.t_pll_d);
    }

    /// The time from one cycle to the next in nanoseconds, rounded down.
    pub fn cycle_nanoseconds(&self) -> u64 {
        u64::from(self.t_base_dp) * u64::from(self.t_dp) * 1_000 / 12
    }
}
