//! Parameters, configurations and diagnoses of PROFIBUS slaves in the words of the manual.
//!
//! The ident number says which device it is; without a manual for it the bytes are shown. This module must not know rules.

use expression::{FormattedValue, Type};
use judge::diagnosis;
use judge::image::field_number;
use plain_text::hex;
use suite::device::{DeviceDescription, DiagnosisName, UserPrmLayout};
use suite::model::Manual;
use wire::profibus::diag::{NO_MASTER, SlaveDiag};
use wire::profibus::prm::{Dpv1, SetPrm, StationStatus};

/// The manuals of devices on PROFIBUS.
#[derive(Clone, Debug, Default)]
pub(super) struct Decoder<'a>(Vec<&'a DeviceDescription>);

impl<'a> Decoder<'a> {
    pub fn new(manuals: &'a [Manual]) -> Decoder<'a> {
        let devices = manuals.iter().map(|manual| &*manual.device).filter(|device| device.profibus().is_some());
        Decoder(devices.collect())
    }

    /// The device of an ident number.
    pub fn device(&self, ident: Option<u16>) -> Option<&'a DeviceDescription> {
        self.0.iter().copied().find(|device| ident.is_some() && device.ident() == ident)
    }

    /// Set_Prm: the standard fields, then the user fields that the manual knows.
    pub fn parameters(&self, octets: &[u8]) -> String {
        let Ok(prm) = SetPrm::parse(octets) else { return hex(octets) };
        let mut words: Vec<String> = prm.status.words().map(str::to_owned).collect();
        if prm.status.has(StationStatus::WD_ON) {
            let base = prm.dpv1().filter(|dpv1| dpv1.status_1.reserved() == 0).map_or(10, Dpv1::watchdog_base_ms);
            words.push(format!("watchdog {} ms", prm.watchdog_ms(base).unwrap_or_default()));
        }
        words.push(format!("ident 0x{:04X}", prm.ident));
        let Some(device) = self.device(Some(prm.ident)) else {
            words.extend(Some(hex(&prm.user)).filter(|octets| !octets.is_empty()));
            return words.join(", ");
        };
        let dpv1 = device.profibus().is_some_and(|slave| slave.set_prm.dpv1.is_some());
        let user = if dpv1 { prm.user_after_dpv1() } else { &prm.user };
        let record = device.records.get(UserPrmLayout::RECORD).filter(|record| record.octets == user.len());
        match record {
            Some(record) => words.extend(record.fields.iter().filter_map(|field| {
                let number = field_number(field, user)?;
                let word = field.words.iter().find(|(_, value)| *value == number).map(|(word, _)| word.clone());
                Some(format!("{} {}", field.name, word.unwrap_or_else(|| number.to_string())))
            })),
            None => words.extend(Some(hex(user)).filter(|octets| !octets.is_empty())),
        }
        words.join(", ")
    }

    /// Chk_Cfg: the bytes, and the modules with these identifiers.
    pub fn configuration(&self, ident: Option<u16>, octets: &[u8]) -> String {
        let modules = self.device(ident).map_or(&[][..], |device| &device.modules);
        let names: Vec<&str> =
            modules.iter().filter(|module| module.cfg() == octets).map(|module| module.name.as_str()).collect();
        match names.as_slice() {
            [] => hex(octets),
            names => format!("{} ({})", hex(octets), names.join(" or ")),
        }
    }

    /// Slave_Diag: the bits that are set, the master, and the fields and errors that the manual knows.
    pub fn diagnosis(&self, octets: &[u8]) -> String {
        let Ok(diag) = SlaveDiag::parse(octets) else { return hex(octets) };
        let bits = diag.status_1.words().chain(diag.status_2.words()).chain(diag.status_3.words());
        let mut words: Vec<String> = vec![bits.collect::<Vec<_>>().join(" ")];
        words.push(match diag.master {
            NO_MASTER => "no master".to_owned(),
            master => format!("master {master}"),
        });
        let device = self.device(Some(diag.ident));
        let layout = device.and_then(|device| Some((device, &device.profibus()?.diagnosis)));
        let Some((device, layout)) = layout else {
            if !diag.ext.is_empty() {
                words.push(hex(&diag.ext));
            }
            return words.join(", ");
        };
        if let Some(blocks) = &layout.blocks {
            let codes = blocks.codes(octets).unwrap_or_default();
            let word = |code: u8| blocks.table.word(code.into()).map_or_else(|| format!("{code:#04X}"), str::to_owned);
            let errors: Vec<String> = codes.into_iter().map(word).collect();
            if !errors.is_empty() {
                words.push(format!("errors {}", errors.join(" ")));
            }
        }
        for (index, field) in layout.fields.iter().enumerate() {
            let value = diagnosis::value(device, DiagnosisName::Field(index), octets, None);
            if !value.is_unknown() {
                let ty = field.table.as_ref().map_or(Type::WHOLE, |table| Type::Word(table.clone()));
                words.push(format!("{} {}", field.name, FormattedValue(&value, &ty)));
            }
        }
        words.join(", ")
    }
}
