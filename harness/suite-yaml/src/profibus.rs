//! Reads what steps on PROFIBUS have of their own: services of `send`, keys of `start` and of `instead`.

use super::answer::RequestKind;
use super::device_yaml::{duration, plain};
use super::dialect::Service as Refuser;
use super::error::{Mistake, Read};
use super::frame::{StepScope, is_none, octets};
use super::request_keys::{LOCKS, slave_request};
use super::source::ANY_SLAVE;
use super::yaml::Node;
use controllers::profibus_dp::DamagedDpFrame;
use expression::Type;
use std::time::Duration;
use suite::model::{AcyclicService, AlarmToAcknowledge, DpService, StartDeviation};
use wire::profibus::call::FunctionIndex;
use wire::profibus::fdl::BaudRate;
use wire::profibus::global_control::GlobalCommand;
use wire::profibus::sap::{MasterSap, SlaveSap};

/// The bits of `global_control`.
const COMMANDS: [(&str, GlobalCommand); 5] = [
    ("clear", GlobalCommand::CLEAR_DATA),
    ("unfreeze", GlobalCommand::UNFREEZE),
    ("freeze", GlobalCommand::FREEZE),
    ("unsync", GlobalCommand::UNSYNC),
    ("sync", GlobalCommand::SYNC),
];

impl StepScope<'_, '_> {
    /// A service of PROFIBUS whose name and fields are known to be right, and what its answer can consist of.
    pub(super) fn dp_service(&self, name: &str, fields: &Node) -> Read<(AcyclicService, RequestKind<'static>)> {
        let field = |key: &str| fields.get(key).ok_or_else(|| fields.wrong(format!("{name} needs `{key}`")));
        let service = match name {
            "set_slave_address" => DpService::SetSlaveAddress {
                new: self.value(field("new")?, &Type::whole(8, false))?,
                ident: self.number(field("ident")?, "an ident number")?,
                lock: fields.get("lock").map_or(Ok(0), |node| self.number(node, "a byte"))?,
                length: fields.get("length").map(|node| self.number(node, "a length")).transpose()?,
            },
            "global_control" => {
                let mut command = 0;
                for (key, bit) in COMMANDS {
                    let said = fields.get(key).map_or(Ok(false), |node| self.bit(node))?;
                    command |= if said { bit.0 } else { 0 };
                }
                let groups = fields.get("group").map_or(Ok(0), |node| self.number(node, "a mask of groups"))?;
                DpService::GlobalControl { command, groups }
            }
            "fdl_status" => DpService::FdlStatus,
            "slave_diag" => DpService::SlaveDiag,
            "get_cfg" => DpService::GetCfg,
            "set_prm" => DpService::SetPrm(octets(field("bytes")?)?),
            "chk_cfg" => DpService::ChkCfg(fields.get("bytes").map(octets).transpose()?),
            "data_exchange" => DpService::DataExchange(fields.get("bytes").map(octets).transpose()?),
            "access_point" => self.access_point(fields, field("sap")?)?,
            "read_inputs" => DpService::ReadInputs,
            "read_outputs" => DpService::ReadOutputs,
            "ds_read" => DpService::Read {
                slot: self.number(field("slot")?, "a slot")?,
                index: self.number(field("index")?, "an index")?,
                length: self.number(field("length")?, "a length")?,
            },
            "ds_write" => DpService::Write {
                slot: self.number(field("slot")?, "a slot")?,
                index: self.number(field("index")?, "an index")?,
                bytes: octets(field("bytes")?)?,
            },
            "alarm_ack" => DpService::AlarmAck {
                own_access_point: fields.get("own_access_point").map_or(Ok(false), |node| self.bit(node))?,
                alarm: Box::new(AlarmToAcknowledge {
                    slot: self.value(field("slot")?, &Type::whole(8, false))?,
                    alarm_type: self.value(field("alarm_type")?, &Type::whole(8, false))?,
                    specifier: self.value(field("specifier")?, &Type::whole(8, false))?,
                }),
            },
            "im_read" | "ms2_im_read" => {
                let record = field("record")?;
                let number: u8 = self.number(record, "a number of a record")?;
                if FunctionIndex::im(number).is_none() {
                    return Err(record.wrong("there are I&M0 to I&M199"));
                }
                let class_2 = name == "ms2_im_read";
                DpService::ImRead { slot: self.number(field("slot")?, "a slot")?, number, class_2 }
            }
            "ms2_initiate" => self.ms2_initiate(fields)?,
            "ms2_read" => DpService::Ms2Read {
                slot: self.number(field("slot")?, "a slot")?,
                index: self.number(field("index")?, "an index")?,
                length: self.number(field("length")?, "a length")?,
            },
            "ms2_write" => DpService::Ms2Write {
                slot: self.number(field("slot")?, "a slot")?,
                index: self.number(field("index")?, "an index")?,
                bytes: octets(field("bytes")?)?,
            },
            "ms2_abort" => DpService::Ms2Abort {
                subnet: fields.get("subnet").map_or(Ok(0), |node| self.number(node, "a subnet"))?,
                reason: fields.get("reason").map_or(Ok(USER_ABORT), |node| self.number(node, "a reason"))?,
            },
            _ => {
                let frame = field("frame")?;
                let word = plain(frame, "a frame")?;
                let known = DamagedDpFrame::TABLE.iter().map(|(_, word, _)| *word);
                return match DamagedDpFrame::by_word(word) {
                    Some(_) => Ok((AcyclicService::Broken(word.to_owned()), RequestKind::Whole(Refuser::Dp))),
                    None => Err(Mistake::unknown(frame.spot, "broken frame", word, known)),
                };
            }
        };
        Ok((AcyclicService::Dp(service), RequestKind::Whole(Refuser::Dp)))
    }

    /// A request to any access point but that of Set_Slave_Address, which needs consent.
    fn access_point(&self, fields: &Node, point: &Node) -> Read<DpService> {
        let sap: u8 = self.number(point, "an access point")?;
        if SlaveSap(sap) == SlaveSap::SET_SLAVE_ADDRESS {
            return Err(point.wrong("this is the access point of Set_Slave_Address").help("use `set_slave_address`"));
        }
        Ok(DpService::AccessPoint {
            sap,
            source: fields.get("source").map_or(Ok(MasterSap::MS0.0), |node| self.number(node, "an access point"))?,
            bytes: fields.get("bytes").map_or(Ok(Vec::new()), octets)?,
        })
    }

    /// Initiate with its fields; what is not said is a master that reads and writes records of API 0.
    fn ms2_initiate(&self, fields: &Node) -> Read<DpService> {
        let two = |key: &str, usual: [u8; 2]| {
            let Some(node) = fields.get(key) else { return Ok(usual) };
            <[u8; 2]>::try_from(octets(node)?).map_err(|_| node.wrong(format!("`{key}` has two bytes")))
        };
        let end = |kind: &str, address: &str| -> Read<(u8, Vec<u8>)> {
            let kind = fields.get(kind).map_or(Ok(0), |node| self.number(node, "a type"))?;
            let address = fields.get(address).map_or(Ok(vec![0, 0]), octets)?;
            Ok((kind, address))
        };
        let send_timeout = match fields.get("send_timeout") {
            None => USUAL_SEND_TIMEOUT,
            Some(node) => {
                let time = duration(node, "a time")?;
                let units = u16::try_from(time.as_nanos() / SEND_TIMEOUT_UNIT);
                match units {
                    Ok(units) if time.as_nanos().is_multiple_of(SEND_TIMEOUT_UNIT) => units,
                    _ => return Err(node.wrong("Send_Timeout comes in steps of 10ms, up to 655350ms")),
                }
            }
        };
        Ok(DpService::Ms2Initiate {
            send_timeout,
            features: two("features", [1, 0])?,
            profile_features: two("profile_features", [0, 0])?,
            profile: fields.get("profile").map_or(Ok(0), |node| self.number(node, "a profile"))?,
            source: end("s_type", "s_addr")?,
            destination: end("d_type", "d_addr")?,
        })
    }

    /// How often the frames of a service are sent again: they need a frame count bit, and a station that stays where it is.
    pub(super) fn repeats(&self, node: &Node, service: &AcyclicService) -> Read<u8> {
        let why = match service {
            AcyclicService::Dp(DpService::FdlStatus | DpService::GlobalControl { .. }) => {
                "this service has no frame count bit"
            }
            AcyclicService::Dp(DpService::SetSlaveAddress { .. }) => {
                "the device has another address after this service"
            }
            AcyclicService::Dp(_) => return self.number(node, "a number of repetitions"),
            AcyclicService::Broken(_) => "a damaged frame is sent once",
            _ => "`repeats` exists on PROFIBUS only",
        };
        Err(node.wrong(why).help("leave `repeats` out"))
    }

    fn bit(&self, node: &Node) -> Read<bool> {
        match self.number::<u8>(node, "a bit")? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(node.wrong(format!("{other} is no bit")).help("write 0 or 1")),
        }
    }

    /// One key of `instead` in a start-up on PROFIBUS.
    pub(super) fn instead_slave(&self, key: &Node, value: &Node) -> Read<StartDeviation> {
        let name = key.text("a key")?;
        Ok(match name {
            "set_prm" if is_none(value) => StartDeviation::NoSetPrm,
            "set_prm" => StartDeviation::SetPrm(octets(value)?),
            "user_octets" => StartDeviation::UserOctets(octets(value)?),
            "dpv1" => match <[u8; 3]>::try_from(octets(value)?) {
                // A case for a feature of DP-V1 is not applicable to a slave without it, but loads.
                Ok(three)
                    if self.names.device().name == ANY_SLAVE
                        || self.names.device().profibus().is_some_and(|slave| slave.set_prm.dpv1.is_some()) =>
                {
                    StartDeviation::Dpv1(three)
                }
                Ok(_) => {
                    return Err(key.wrong("this device has no bytes of DP-V1").help("`set_prm` declares them: `dpv1`"));
                }
                Err(_) => return Err(value.wrong("DP-V1 has three bytes in Set_Prm")),
            },
            "chk_cfg" if is_none(value) => StartDeviation::NoChkCfg,
            "chk_cfg" => StartDeviation::ChkCfg(octets(value)?),
            "ident" => StartDeviation::Ident(self.number(value, "an ident number")?),
            "lock" => {
                let (lock, unlock) = LOCKS.read(value, &slave_request::lock)?;
                StartDeviation::Lock { lock, unlock }
            }
            "freeze_req" | "sync_req" if !self.bit(value)? => {
                return Err(value.wrong(format!("`{name}` is 1 or left out")));
            }
            "freeze_req" => StartDeviation::FreezeRequest,
            "sync_req" => StartDeviation::SyncRequest,
            "watchdog_factors" => match value.items("two factors")? {
                [one, two] => {
                    StartDeviation::WatchdogFactors(self.number(one, "a factor")?, self.number(two, "a factor")?)
                }
                _ => return Err(value.wrong("there are two factors").help("write [20, 5]")),
            },
            "min_tsdr" => StartDeviation::MinTsdr(self.number(value, "a number of bit times")?),
            "groups" => StartDeviation::Groups(self.number(value, "a mask of groups")?),
            "output_length" => StartDeviation::OutputLength(self.number(value, "a length")?),
            "input_length" => StartDeviation::InputLength(self.number(value, "a length")?),
            _ => {
                let known = slave_request::KEYS.names();
                return Err(Mistake::unknown(key.spot, "key of instead", name, known));
            }
        })
    }

    /// A transmission rate that the standard allows.
    pub(super) fn baud(&self, node: &Node) -> Read<BaudRate> {
        let rate = BaudRate(self.number(node, "a transmission rate")?);
        if BaudRate::STANDARD.contains(&rate) {
            return Ok(rate);
        }
        let known: Vec<String> = BaudRate::STANDARD.iter().map(|rate| rate.0.to_string()).collect();
        Err(node.wrong("no bus runs at this rate").help(format!("the rates are {}", known.join(", "))))
    }

    /// The time of isochronous mode: a whole number of 125 us, for a slave that takes structured blocks.
    pub(super) fn isochronous(&self, node: &Node) -> Read<Duration> {
        let slave = self.names.device().profibus();
        if !slave.is_some_and(|slave| slave.set_prm.structured) {
            return Err(node
                .wrong("this device takes no structured blocks, so it cannot receive the times of isochronous mode")
                .help("`set_prm` in device.yaml declares them: `structured: true`"));
        }
        let time = duration(node, "a time")?;
        match time.as_nanos() {
            0 => Err(node.wrong("a clock needs time between its strokes")),
            nanos if !nanos.is_multiple_of(T_BASE_DP) => Err(node.wrong("the clock comes in steps of 125us")),
            _ => Ok(time),
        }
    }

    /// The watchdog of a slave: two factors of 1 to 255, counted in 10 ms, or 1 ms where the bytes of DP-V1 say so.
    pub(super) fn checked_slave_watchdog(&self, time: Duration, node: &Node, dpv1: Option<[u8; 3]>) -> Read<Duration> {
        let base = if dpv1.is_some_and(|octets| octets[0] & WD_BASE_1MS != 0) { 1 } else { 10 };
        let millis = time.as_millis();
        let units = millis / base;
        let good = time.as_nanos() == units * base * 1_000_000 && factors(units).is_some();
        if good {
            Ok(time)
        } else {
            Err(node.wrong(format!("no two factors of 1 to 255 make this watchdog out of {base} ms")))
        }
    }
}

/// Send_Timeout of a master that says none, in units: 1 s.
const USUAL_SEND_TIMEOUT: u16 = 100;
/// The unit of Send_Timeout, in nanoseconds.
const SEND_TIMEOUT_UNIT: u128 = 10_000_000;
/// Instance and reason of an Abort by the user.
const USER_ABORT: u8 = 0x20;
/// The step of the clock of isochronous mode, in nanoseconds.
const T_BASE_DP: u128 = 125_000;
/// The bit of the first byte of DP-V1 that counts the watchdog in milliseconds.
const WD_BASE_1MS: u8 = wire::profibus::prm::Dpv1Status1::WD_BASE_1MS.0;

/// The two factors of a watchdog, the second as small as can be; none if no two of 1 to 255 make it.
fn factors(units: u128) -> Option<(u8, u8)> {
    let second = (1..=255_u128).find(|second| units.is_multiple_of(*second) && units / second <= 255)?;
    Some((u8::try_from(units / second).ok().filter(|first| *first > 0)?, u8::try_from(second).ok()?))
}
