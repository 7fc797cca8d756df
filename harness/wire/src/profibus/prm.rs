//! Set_Prm: a master locks a slave and parameterises it; Set_Ext_Prm: more structured parameter blocks.
//!
//! This module must not know the meaning of the user parameters: the GSD and the manual of the device define it. Source:
//! IEC 61158-6-3, Set_Prm and Set_Ext_Prm.

use crate::codes::{codes, flags};
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

flags! {
    /// What the master requests of the slave (IEC 61158-6-3, Station_Status of Set_Prm).
    pub struct StationStatus(u8) {
        0x08 WD_ON wd_on "The watchdog must be on.",
        0x10 FREEZE_REQ freeze_req "The slave must support freezing its inputs.",
        0x20 SYNC_REQ sync_req "The slave must support synchronising its outputs.",
        0x40 UNLOCK_REQ unlock_req "The slave is released for other masters.",
        0x80 LOCK_REQ lock_req "The slave is locked for other masters; without this bit it accepts no parameter except min TSDR.",
    }
}

flags! {
    /// The first byte of DP-V1 (IEC 61158-6-3, DPV1_Status_1).
    pub struct Dpv1Status1(u8) {
        0x04 WD_BASE_1MS wd_base_1ms "The unit of the watchdog is 1 ms; otherwise 10 ms.",
        0x20 PUBLISHER_ENABLE publisher_enable "The slave works as a publisher: other slaves may receive its inputs.",
        0x40 FAIL_SAFE fail_safe "Output telegrams without data mean clear (fail-safe); otherwise outputs of zeros do.",
        0x80 DPV1_ENABLE dpv1_enable "The slave works in DP-V1 mode.",
    }
}

flags! {
    /// The second byte of DP-V1: how the configuration is checked, and which alarms the slave may send (IEC 61158-6-3,
    /// DPV1_Status_2).
    pub struct Dpv1Status2(u8) {
        0x01 CHECK_CFG_MODE check_cfg_mode "The application of the slave checks the configuration in a manufacturer-specific way.",
        0x04 UPDATE_ALARM update_alarm "Update alarms may be sent.",
        0x08 STATUS_ALARM status_alarm "Status alarms may be sent.",
        0x10 MAKER_ALARM maker_alarm "Manufacturer-specific alarms may be sent.",
        0x20 DIAGNOSIS_ALARM diagnosis_alarm "Diagnosis alarms may be sent.",
        0x40 PROCESS_ALARM process_alarm "Process alarms may be sent.",
        0x80 PULL_PLUG_ALARM pull_plug_alarm "Pull and plug alarms may be sent.",
    }
}

/// The third byte of DP-V1: bits 2-0 alarm mode, bit 3 structured blocks follow, bit 4 isochronous, bit 7
/// redundancy commands; bits 5 and 6 are reserved (IEC 61158-6-3, DPV1_Status_3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Dpv1Status3(pub u8);

impl Dpv1Status3 {
    /// Bit 3: structured blocks ([`PrmBlock`]) follow.
    pub const PRM_STRUCTURE: u8 = 0x08;
    /// Bit 4: the slave works isochronously.
    pub const ISOCHRONOUS: u8 = 0x10;
    /// Bit 7: a redundancy command is among the blocks.
    pub const PRM_COMMAND: u8 = 0x80;

    /// Whether the bit or bits of `mask` are set.
    pub fn has(self, mask: u8) -> bool {
        self.0 & mask == mask
    }

    /// The alarm mode: how many alarms may be open at the same time.
    pub fn alarms(self) -> AlarmMode {
        match self.0 & 7 {
            0 => AlarmMode::OneOfEachType,
            mode => AlarmMode::InAll([2, 4, 8, 12, 16, 24, 32][usize::from(mode) - 1]),
        }
    }

    /// The reserved bits, which must be 0.
    pub fn reserved(self) -> u8 {
        self.0 & 0x60
    }
}

/// How many alarms may be open at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AlarmMode {
    /// One of each type.
    OneOfEachType,
    /// The total number of alarms of all types: 2, 4, 8, 12, 16, 24 or 32.
    InAll(u8),
}

/// The parameters of a slave.
///
/// Bytes: 0 station status, 1 and 2 watchdog factors, 3 min TSDR, 4-5 ident number, 6 groups, then up to 237 user bytes, of
/// which the first three belong to DP-V1 if the GSD says so (IEC 61158-6-3, Set_Prm request).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetPrm {
    /// The requests of the master.
    pub status: StationStatus,
    /// WD_Fact_1, 1 to 255.
    pub wd_fact_1: u8,
    /// WD_Fact_2, 1 to 255.
    pub wd_fact_2: u8,
    /// min TSDR: the minimum time until the slave responds, in bit times; below 11 the slave keeps its present value.
    pub min_tsdr: u8,
    /// Ident_Number; a slave with another ident number refuses the parameters.
    pub ident: u16,
    /// Group_Ident: a bit for each of the groups 1 to 8 to which the slave belongs.
    pub groups: u8,
    /// User_Prm_Data, including the three bytes of DP-V1.
    pub user: Vec<u8>,
}

/// The three bytes of DP-V1 at the start of User_Prm_Data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Dpv1 {
    /// Watchdog base, publisher, fail-safe, DP-V1 mode.
    pub status_1: Dpv1Status1,
    /// Alarms and the check of the configuration.
    pub status_2: Dpv1Status2,
    /// Alarm mode, structured blocks, isochronous mode, redundancy.
    pub status_3: Dpv1Status3,
}

impl SetPrm {
    /// Length of the fixed part, in bytes.
    pub const HEAD: usize = 7;

    /// Parses the data of a Set_Prm request; fails only if it has fewer than seven bytes.
    pub fn parse(octets: &[u8]) -> Result<SetPrm> {
        let mut reader = ByteReader::new("Set_Prm", octets);
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

    /// The first three bytes of User_Prm_Data as those of DP-V1; `None` if there are fewer. The GSD defines whether they are.
    pub fn dpv1(&self) -> Option<Dpv1> {
        match self.user.as_slice() {
            [one, two, three, ..] => {
                Some(Dpv1 { status_1: Dpv1Status1(*one), status_2: Dpv1Status2(*two), status_3: Dpv1Status3(*three) })
            }
            _ => None,
        }
    }

    /// User_Prm_Data after the three bytes of DP-V1.
    pub fn user_after_dpv1(&self) -> &[u8] {
        self.user.get(3..).unwrap_or_default()
    }

    /// The watchdog time in milliseconds: `base` (10, or 1 with DP-V1) times the watchdog factors; `None` if the watchdog is off.
    pub fn watchdog_ms(&self, base: u32) -> Option<u32> {
        let factors = u32::from(self.wd_fact_1) * u32::from(self.wd_fact_2);
        self.status.has(StationStatus::WD_ON).then(|| factors.saturating_mul(base))
    }
}

impl Dpv1 {
    /// The unit of the watchdog time in milliseconds: 10 or 1.
    pub fn watchdog_base_ms(self) -> u32 {
        if self.status_1.has(Dpv1Status1::WD_BASE_1MS) { 1 } else { 10 }
    }

    /// The three bytes.
    pub fn octets(self) -> [u8; 3] {
        [self.status_1.0, self.status_2.0, self.status_3.0]
    }
}

codes! {
    /// The type of a structured block; 32 to 128 are manufacturer-specific (IEC 61158-6-3, Structure_Type).
    pub struct PrmBlockType(u8) {
        2 PRM_COMMAND prm_command "A redundancy command.",
        3 DXB_LINK_TABLE dxb_link_table "The publishers that the slave subscribes to.",
        4 ISOCHRONOUS isochronous "The times of isochronous operation.",
        7 DXB_SUBSCRIBER_TABLE dxb_subscriber_table "The mapping of the publishers' data.",
        8 TIME_AR time_ar "The interval and the delay of clock synchronisation.",
        129 USER_PRM_DATA user_prm_data "User parameters.",
    }
}

/// A structured block. Blocks follow the three bytes of DP-V1 in Set_Prm if PRM_STRUCTURE is set, and are the content of
/// Set_Ext_Prm.
///
/// Bytes: 0 length with this byte, 4 to 237; 1 type; 2 slot; 3 reserved; then data (IEC 61158-6-3, Structured_Prm_Data).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrmBlock {
    /// The type of the block.
    pub kind: PrmBlockType,
    /// The slot to which it applies; 0 is the device.
    pub slot: u8,
    /// Reserved, must be 0.
    pub reserved: u8,
    /// The data of the block.
    pub data: Vec<u8>,
}

impl PrmBlock {
    const HEAD: u8 = 4;

    /// Parses the blocks in `octets`; fails if the length of a block is less than its header or more than what is left.
    pub fn parse_all(octets: &[u8]) -> Result<Vec<PrmBlock>> {
        let mut reader = ByteReader::new("structured parameters", octets);
        let mut blocks = Vec::new();
        while !reader.is_empty() {
            blocks.push(PrmBlock::read(&mut reader)?);
        }
        Ok(blocks)
    }

    fn read(reader: &mut ByteReader<'_>) -> Result<PrmBlock> {
        let length = reader.u8()?;
        if length < PrmBlock::HEAD {
            return Err(reader.wrong("Structure_Length", 1, "at least 4, with the header", length.into()));
        }
        let mut block = reader.sub(usize::from(length) - 1)?;
        Ok(PrmBlock {
            kind: PrmBlockType(block.u8()?),
            slot: block.u8()?,
            reserved: block.u8()?,
            data: block.rest().to_vec(),
        })
    }

    /// Appends the block; the caller ensures that it has at most 251 bytes of data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[(self.data.len() as u8).wrapping_add(PrmBlock::HEAD), self.kind.0, self.slot, self.reserved]);
        out.put(&self.data);
    }
}

/// The times of isochronous operation: the data of a block of [`PrmBlockType::ISOCHRONOUS`], which is 28 bytes long in all.
///
/// Bytes: 0 version, 1-4 T_BASE_DP, 5-6 T_DP, 7 T_MAPC, 8-11 T_BASE_IO, 12-13 T_I, 14-15 T_O, 16-19 T_DX, 20-21 T_PLL_W, 22-23
/// T_PLL_D (IEC 61158-6-3, IsoM_Parameter).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Isochronous {
    /// Version of the block: 1.
    pub version: u8,
    /// Unit of `t_dp` in twelfths of a microsecond: 375, 750, 1500, 3000, 6000 or 12000.
    pub t_base_dp: u32,
    /// Time of the DP cycle in `t_base_dp`, 1 to 65535.
    pub t_dp: u16,
    /// Cycles of the application of the master, in `t_dp`, 1 to 14.
    pub t_mapc: u8,
    /// Unit of `t_i` and `t_o` in twelfths of a microsecond: 375, 750, 1500, 3000, 6000 or 12000.
    pub t_base_io: u32,
    /// Time from sampling the actual value to the end of the cycle, in `t_base_io`.
    pub t_i: u16,
    /// Time from the start of the cycle until the set point takes effect, in `t_base_io`.
    pub t_o: u16,
    /// Duration of Data_Exchange with all slaves, in twelfths of a microsecond.
    pub t_dx: u32,
    /// Half the window in which Global_Control must arrive, in twelfths of a microsecond; usually 12.
    pub t_pll_w: u16,
    /// The delay of Global_Control, in twelfths of a microsecond; usually 0.
    pub t_pll_d: u16,
}

impl Isochronous {
    /// Parses the data of a block; fails unless they are 24 bytes.
    pub fn parse(octets: &[u8]) -> Result<Isochronous> {
        let mut reader = ByteReader::new("isochronous parameters", octets);
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
        reader.end("24 bytes")?;
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

    /// The time of the DP cycle in nanoseconds, rounded down.
    pub fn cycle_nanoseconds(&self) -> u64 {
        u64::from(self.t_base_dp) * u64::from(self.t_dp) * 1_000 / 12
    }
}
