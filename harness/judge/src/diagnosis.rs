//! The values of names in a Slave_Diag.

use super::image::big_endian;
use expression::Value;
use suite::device::{DeviceDescription, DiagnosedAlarmPart, DiagnosisField, DiagnosisName};
use wire::profibus::diag::{DiagnosisBlock, DiagnosisMessage, NO_MASTER, SlaveDiag, Status1};

/// The value of a name in Slave_Diag; unknown if the diagnosis is too short.
///
/// `asker` is the address of the requesting master, which decides whether another master has parameterised the slave.
pub fn value(device: &DeviceDescription, name: DiagnosisName, octets: &[u8], asker: Option<u8>) -> Value {
    known(device, name, octets, asker).unwrap_or(Value::Unknown)
}

fn known(device: &DeviceDescription, name: DiagnosisName, octets: &[u8], asker: Option<u8>) -> Option<Value> {
    Some(match name {
        DiagnosisName::Length => Value::whole(octets.len() as i128),
        DiagnosisName::Bytes => Value::bytes(octets),
        DiagnosisName::Ident => Value::whole(i128::from(big_endian(octets.get(4..SlaveDiag::HEAD)?))),
        DiagnosisName::Master => Value::whole(*octets.get(3)?),
        DiagnosisName::MasterLock => {
            let sent = Status1(*octets.first()?).has(Status1::MASTER_LOCK);
            let master = *octets.get(3)?;
            let other = asker.is_some_and(|own| master != own && master != NO_MASTER);
            Value::Bit(sent || other)
        }
        DiagnosisName::Bit { octet, bit } => Value::Bit(octets.get(usize::from(octet))? >> bit & 1 == 1),
        DiagnosisName::Errors => {
            let blocks = device.profibus()?.diagnosis.blocks.as_ref()?;
            Value::set(blocks.codes(octets)?.into_iter().map(i64::from))
        }
        DiagnosisName::Alarm(part) => {
            let diagnosis = SlaveDiag::parse(octets).ok()?;
            let alarm = first_alarm(&diagnosis);
            match part {
                DiagnosedAlarmPart::Type => Value::whole(alarm.map_or(0, |alarm| alarm.kind)),
                DiagnosedAlarmPart::Slot => Value::whole(alarm?.slot),
                DiagnosedAlarmPart::Change => Value::whole(alarm?.specifier.change() as u8),
                DiagnosedAlarmPart::Specifier => Value::whole(alarm?.specifier.0),
            }
        }
        DiagnosisName::Field(index) => field(device.profibus()?.diagnosis.fields.get(index)?, octets)?,
    })
}

/// The first alarm of DP-V1 among the blocks of a diagnosis.
fn first_alarm(diagnosis: &SlaveDiag) -> Option<DiagnosisMessage<'_>> {
    diagnosis.blocks().map_while(Result::ok).find_map(|block| match block {
        DiagnosisBlock::Device(data) => DiagnosisMessage::parse(data).ok().filter(|of| of.alarm().is_some()),
        DiagnosisBlock::Identifier(_) | DiagnosisBlock::Channel(_) | DiagnosisBlock::Revision(_) => None,
    })
}

fn field(field: &DiagnosisField, octets: &[u8]) -> Option<Value> {
    let Some(number) = field.number_in(octets) else { return field.octets_in(octets).map(Value::bytes) };
    Some(match (&field.table, field.bits) {
        (Some(_), _) => Value::Word(i64::try_from(number).ok()?),
        (None, Some((_, 1))) => Value::Bit(number != 0),
        (None, _) => Value::whole(number),
    })
}
