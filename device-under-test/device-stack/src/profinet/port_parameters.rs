//! What a controller lets a port check and adjust: records 0x802B (PDPortDataCheck) and 0x802F (PDPortDataAdjust).
//!
//! The device checks the neighbour (CheckPeers) and the MAU type (CheckMAUType), and sets the domain boundary
//! (AdjustDomainBoundary). It accepts other known checks and compares nothing. What was written holds until the next power-up.

use super::hooks::StackCheck;
use super::plugged::{PORT_SUBSLOT, SubmoduleAddress};
use super::stack::Stack;
use crate::profinet::{DiagnosisChange, DiagnosisSeverity, SubmoduleDiagnosis};
use alloc::vec::Vec;
use wire::octets::ByteReader;
use wire::profinet::blocks::{BlockHeader, BlockType, RawBlock};
use wire::profinet::diagnosis::ChannelDiagnosis;
use wire::profinet::status::RecordError;

/// CheckPeers: number of neighbours, and for each the length and the name of the port and of the station.
const CHECK_PEERS: BlockType = BlockType(0x020A);
/// CheckMAUType: the MAU type.
const CHECK_MAU_TYPE: BlockType = BlockType(0x020C);
/// CheckLineDelay, CheckLinkState, CheckSyncDifference and CheckMAUTypeDifference, which the device accepts.
const OTHER_CHECKS: [BlockType; 4] = [BlockType(0x020B), BlockType(0x021C), BlockType(0x021E), BlockType(0x021F)];
/// AdjustDomainBoundary: padding of two, the boundary of four, properties of two.
const ADJUST_DOMAIN_BOUNDARY: BlockType = BlockType(0x0209);

/// ChannelErrorType: data transmission impossible; ExtChannelErrorType of it: another MAU type.
const TRANSMISSION_IMPOSSIBLE: u16 = 0x8000;
const OTHER_MAU_TYPE: u16 = 0x8001;
/// ChannelErrorType: remote mismatch.
const REMOTE_MISMATCH: u16 = 0x8001;
/// ExtChannelErrorTypes of it: another station, another port, no neighbour.
const OTHER_STATION: u16 = 0x8000;
const OTHER_PORT: u16 = 0x8001;
const NO_PEER: u16 = 0x8005;

/// What was written to one port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct PortParameters {
    subslot: u16,
    check: Option<Vec<u8>>,
    adjust: Option<Vec<u8>>,
    /// The expected neighbour: its port and its station.
    peer: Option<ExpectedPeer>,
    /// The expected MAU type.
    mau_type: Option<u16>,
    domain_boundary: u32,
    /// The diagnosis that is pending because of the neighbour or the MAU type.
    mismatch: Option<SubmoduleDiagnosis>,
}

/// Which of the two records is accessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PortRecord {
    /// PDPortDataCheck.
    Check,
    /// PDPortDataAdjust.
    Adjust,
}

impl PortRecord {
    fn block(self) -> BlockType {
        match self {
            PortRecord::Check => BlockType::PD_PORT_DATA_CHECK,
            PortRecord::Adjust => BlockType::PD_PORT_DATA_ADJUST,
        }
    }
}

fn text(reader: &mut ByteReader<'_>) -> Result<Vec<u8>, RecordError> {
    let invalid = |_| RecordError::INVALID_PARAMETER;
    let length = reader.u8().map_err(invalid)?;
    Ok(reader.take(length.into()).map_err(invalid)?.to_vec())
}

/// Port and station of a neighbour that the controller expects.
type ExpectedPeer = (Vec<u8>, Vec<u8>);

/// The first expected neighbour of CheckPeers.
fn expected_peer(body: &[u8]) -> Result<Option<ExpectedPeer>, RecordError> {
    let mut reader = ByteReader::new("CheckPeers", body);
    match reader.u8() {
        Ok(0) => Ok(None),
        Ok(_) => Ok(Some((text(&mut reader)?, text(&mut reader)?))),
        Err(_) => Err(RecordError::INVALID_PARAMETER),
    }
}

impl Stack {
    /// What was written to the port at `place`.
    fn parameters(&self, place: SubmoduleAddress) -> Option<&PortParameters> {
        self.port_parameters.iter().find(|port| port.subslot == place.subslot)
    }

    /// The domain boundary of the port at `place`.
    pub(super) fn domain_boundary(&self, place: SubmoduleAddress) -> u32 {
        self.parameters(place).map_or(0, |port| port.domain_boundary)
    }

    /// Reads what was written to the port at `place`; before that there is no such record.
    pub(super) fn read_port(&self, place: SubmoduleAddress, record: PortRecord) -> Result<&[u8], RecordError> {
        let port = self.parameters(place).ok_or(RecordError::INVALID_INDEX)?;
        let written = match record {
            PortRecord::Check => &port.check,
            PortRecord::Adjust => &port.adjust,
        };
        written.as_deref().ok_or(RecordError::INVALID_INDEX)
    }

    /// Writes one of the records of the port at `place`.
    pub(super) fn write_port(
        &mut self,
        place: SubmoduleAddress,
        record: PortRecord,
        data: &[u8],
    ) -> Result<(), RecordError> {
        if !self.plugged.ports().any(|plug| SubmoduleAddress::from(plug) == place) {
            return Err(RecordError::INVALID_INDEX);
        }
        let mut reader = ByteReader::new("port", data);
        let wrong_length = |_| RecordError::WRITE_LENGTH_ERROR;
        let (header, mut body) = BlockHeader::read(&mut reader).map_err(wrong_length)?;
        if !reader.is_empty() {
            return Err(RecordError::WRITE_LENGTH_ERROR);
        }
        let is_known = header.kind == record.block() && (header.version_high, header.version_low) == (1, 0);
        if !self.hooks.check(StackCheck::PortBlock, is_known) {
            return Err(RecordError::INVALID_PARAMETER);
        }
        body.u16().map_err(wrong_length)?;
        let at = (body.u16().map_err(wrong_length)?, body.u16().map_err(wrong_length)?);
        if !self.hooks.check(StackCheck::PortAddress, at == (place.slot, place.subslot)) {
            return Err(RecordError::INVALID_PARAMETER);
        }
        let mut changed = self.parameters(place).cloned().unwrap_or_default();
        changed.subslot = place.subslot;
        match record {
            PortRecord::Check => (changed.check, changed.peer, changed.mau_type) = (Some(data.to_vec()), None, None),
            PortRecord::Adjust => (changed.adjust, changed.domain_boundary) = (Some(data.to_vec()), 0),
        }
        while !body.is_empty() {
            let block = RawBlock::read(&mut body).map_err(|_| RecordError::INVALID_PARAMETER)?;
            match (record, block.header.kind) {
                (PortRecord::Check, CHECK_PEERS) => changed.peer = expected_peer(&block.body)?,
                (PortRecord::Check, CHECK_MAU_TYPE) => {
                    let [high, low] = block.body[..] else { return Err(RecordError::INVALID_PARAMETER) };
                    changed.mau_type = Some(u16::from_be_bytes([high, low]));
                }
                (PortRecord::Check, kind) if OTHER_CHECKS.contains(&kind) => {}
                (PortRecord::Adjust, ADJUST_DOMAIN_BOUNDARY) => {
                    let [_, _, a, b, c, d, ..] = block.body[..] else { return Err(RecordError::INVALID_PARAMETER) };
                    changed.domain_boundary = u32::from_be_bytes([a, b, c, d]);
                }
                _ => return Err(RecordError::INVALID_PARAMETER),
            }
        }
        self.port_parameters.retain(|port| port.subslot != place.subslot);
        self.port_parameters.push(changed);
        Ok(())
    }

    /// Compares neighbour and MAU type of each port with the expected ones, and reports what has changed.
    pub(super) fn check_peers(&mut self) {
        for at in 0..self.port_parameters.len() {
            let port = &self.port_parameters[at];
            let mismatch = self.mismatch(port);
            let before = port.mismatch;
            if before == mismatch {
                continue;
            }
            let appears = |appears| move |diagnosis| DiagnosisChange { appears, diagnosis };
            for change in before.map(appears(false)).into_iter().chain(mismatch.map(appears(true))) {
                self.report_diagnosis(change);
            }
            self.port_parameters[at].mismatch = mismatch;
        }
    }

    /// How a port differs from what is expected of it.
    fn mismatch(&self, port: &PortParameters) -> Option<SubmoduleDiagnosis> {
        let (error_type, detail) = self.peer_mismatch(port).or_else(|| self.mau_mismatch(port))?;
        Some(SubmoduleDiagnosis {
            api: 0,
            slot: 0,
            subslot: port.subslot,
            channel: ChannelDiagnosis::WHOLE_SUBMODULE,
            error_type,
            extended: Some((detail, 0)),
            severity: DiagnosisSeverity::Fault,
        })
    }

    /// Whether a linked port has another MAU type than the expected one.
    fn mau_mismatch(&self, port: &PortParameters) -> Option<(u16, u16)> {
        let expected = port.mau_type?;
        let actual = self.port(SubmoduleAddress { api: 0, slot: 0, subslot: port.subslot })?.mau_type;
        (actual != 0 && actual != expected).then_some((TRANSMISSION_IMPOSSIBLE, OTHER_MAU_TYPE))
    }

    /// How the neighbour of a port differs from the expected one.
    fn peer_mismatch(&self, port: &PortParameters) -> Option<(u16, u16)> {
        let (expected_port, expected_station) = port.peer.as_ref()?;
        let detail = match self.neighbour().filter(|_| port.subslot == PORT_SUBSLOT) {
            None => NO_PEER,
            Some(neighbour) => {
                let is_same_station = *neighbour.chassis() == expected_station[..];
                let is_same_station = self.hooks.check(StackCheck::PeerStation, is_same_station);
                let is_same_port = self.hooks.check(StackCheck::PeerPort, neighbour.port == *expected_port);
                match (is_same_station, is_same_port) {
                    (false, _) => OTHER_STATION,
                    (true, false) => OTHER_PORT,
                    (true, true) => return None,
                }
            }
        };
        Some((REMOTE_MISMATCH, detail))
    }
}
