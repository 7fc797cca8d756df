//! Disagreements between manual and GSD. Values that `device.yaml` marks as invented are not compared.

use super::model::{FieldType, Gsd, GsdField, GsdModule};
use plain_text::hex;
use results::outcome::{DescriptionKind, DeviceFinding, FindingSeverity};
use suite::device::{DeviceDescription, Origin, ProfibusFacts, RecordField};

/// All disagreements of the manual (`device`, for the variant with this index) with a GSD, in a fixed order; none for a device that
/// is not on PROFIBUS.
pub fn compare(device: &DeviceDescription, variant: usize, gsd: &Gsd) -> Vec<DeviceFinding> {
    let Some(slave) = device.profibus() else { return Vec::new() };
    let mut work = GsdComparison { device, slave, variant, gsd, findings: Vec::new() };
    work.ident();
    work.modules();
    work.diagnosis();
    work.parameters();
    work.findings
}

/// The number of Set_Prm bytes between the first seven bytes and the user bytes whose fields the manual has.
pub(super) fn dpv1_length(slave: &ProfibusFacts) -> usize {
    slave.set_prm.dpv1.map_or(0, |octets| octets.len())
}

/// Whether a field of a GSD has the offset and size of a field of the manual.
pub(super) fn is_at(field: &RecordField, before: usize, at: usize, known: &GsdField) -> bool {
    let place = before + field.octet == at;
    place
        && match (field.bits, known.kind) {
            (None, FieldType::Octets { octets, .. }) => octets == field.octets,
            (Some((low, width)), FieldType::Bits { low: first, high }) => {
                low == u32::from(first) && width == u32::from(high - first) + 1
            }
            // A GSD may describe a field of a whole byte by its bits.
            (None, FieldType::Bits { low, high }) => field.octets == 1 && low == 0 && high == 7,
            (Some(_), FieldType::Octets { .. }) => false,
        }
}

struct GsdComparison<'w> {
    device: &'w DeviceDescription,
    slave: &'w ProfibusFacts,
    variant: usize,
    gsd: &'w Gsd,
    findings: Vec<DeviceFinding>,
}

impl<'w> GsdComparison<'w> {
    fn differ(&mut self, id: &str, severity: FindingSeverity, subject: &str, manual: String, gsd: String) {
        if manual == gsd {
            return;
        }
        let text = format!("{subject}: the manual says {manual}, the GSD says {gsd}.");
        let (manual, description) = (Some(manual), Some((DescriptionKind::Gsd, gsd)));
        self.findings.push(DeviceFinding { id: id.into(), severity, text, manual, description, device: None });
    }

    fn ident(&mut self) {
        if self.slave.ident_origin == Origin::Manual {
            let said = |ident: u16| format!("0x{ident:04X}");
            let (manual, gsd) = (said(self.slave.ident), said(self.gsd.ident));
            self.differ("ident_number", FindingSeverity::Error, "Ident number", manual, gsd);
        }
    }

    /// The modules of the GSD with these identifiers.
    fn modules_with_cfg(&self, cfg: &[u8]) -> Vec<&'w GsdModule> {
        self.gsd.modules.iter().filter(|module| module.cfg == cfg).collect()
    }

    fn modules(&mut self) {
        for module in self.device.modules.iter().filter(|module| module.ident_origin == Origin::Manual) {
            if self.modules_with_cfg(module.cfg()).is_empty() {
                let known: Vec<String> = self.gsd.modules.iter().map(|known| hex(&known.cfg)).collect();
                let id = format!("{}.cfg", module.name);
                let subject = format!("Identifiers of {}", module.name);
                self.differ(&id, FindingSeverity::Warning, &subject, hex(module.cfg()), known.join(", "));
            }
        }
    }

    fn diagnosis(&mut self) {
        if let (Some(manual), Some(gsd)) = (self.slave.diagnosis.lengths.last(), self.gsd.max_diagnosis) {
            let (manual, gsd) = (format!("{manual} bytes"), format!("{gsd} bytes"));
            self.differ("diagnosis.octets", FindingSeverity::Warning, "Longest diagnosis", manual, gsd);
        }
    }

    /// Compares the fields of the user bytes with those of the GSD at the same offsets, whatever their names.
    fn parameters(&mut self) {
        let Some(record) = self.device.records.first().filter(|record| record.origin == Origin::Manual) else { return };
        let before = dpv1_length(self.slave);
        let lengths: Vec<usize> =
            self.gsd.modules.iter().map(|of| self.gsd.parameters.octets + of.parameters.octets).collect();
        if !lengths.is_empty() && !lengths.contains(&(before + record.octets)) {
            let said: Vec<String> = lengths.iter().map(ToString::to_string).collect();
            let (manual, gsd) = (format!("{} bytes", before + record.octets), format!("{} bytes", said.join(", ")));
            self.differ("set_prm.octets", FindingSeverity::Warning, "User bytes of Set_Prm", manual, gsd);
        }
        for field in record.fields.iter().filter(|field| field.origin == Origin::Manual) {
            let found = self.gsd.modules.iter().flat_map(|module| self.gsd.fields(module));
            let Some((_, known)) = found.into_iter().find(|(at, known)| is_at(field, before, *at, known)) else {
                continue;
            };
            let id = |what: &str| format!("{}.{what}", field.name);
            let subject = |what: &str| format!("{what} of {} ({})", field.name, known.name.escape_debug());
            if let Some(default) = field.default.get(self.variant).or(field.default.first()) {
                let (manual, gsd) = (default.to_string(), known.default.to_string());
                self.differ(&id("default"), FindingSeverity::Info, &subject("Default"), manual, gsd);
            }
            if let ((Some(low), Some(high)), Some((first, last))) = (field.range, known.range) {
                let (manual, gsd) = (format!("{low} to {high}"), format!("{first} to {last}"));
                self.differ(&id("range"), FindingSeverity::Warning, &subject("Range"), manual, gsd);
            }
        }
    }
}
