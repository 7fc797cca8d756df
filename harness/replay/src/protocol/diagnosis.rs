//! Slave diagnoses: parameter and configuration faults, and diagnoses that stay pending, in words.

use super::coverage::{CapturePosition, FindingList, SettledFrames};
use super::slaves::on_bus;
use super::table::{
    DP_CONFIGURATION_FAULT, DP_DIAGNOSIS, DP_NOT_SUPPORTED, DP_OTHER_MASTER, DP_PARAMETER_FAULT, ProtocolCheck,
};
use super::text::times;
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, Dp, Observation, ObservedAr};
use plain_text::hex_start;
use std::collections::BTreeMap;
use wire::profibus::diag::{DiagnosisBlock, SlaveDiag, Status1, Status2, Status3};

/// Upper limit of the diagnosis bytes in the text of a finding.
const MOST_OCTETS: usize = 32;

/// A diagnosis of one kind that a slave reported.
#[derive(Clone, Debug)]
struct PendingDiagnosis {
    count: u64,
    first: u64,
    last: u64,
    octet: usize,
    text: String,
    ar: Option<ArId>,
    /// The frame in which it was cleared.
    gone: Option<u64>,
}

/// The diagnoses of a capture by slave and kind.
#[derive(Clone, Debug, Default)]
pub(super) struct SlaveDiagnoses(BTreeMap<(u8, &'static str), PendingDiagnosis>);

const KINDS: [(&ProtocolCheck, FindingSeverity, CaptureBlame, &str); 5] = [
    (DP_PARAMETER_FAULT, FindingSeverity::Error, CaptureBlame::Controller, "refuses its parameters (Prm_Fault)"),
    (DP_CONFIGURATION_FAULT, FindingSeverity::Error, CaptureBlame::Controller, "refuses its configuration (Cfg_Fault)"),
    (
        DP_NOT_SUPPORTED,
        FindingSeverity::Warning,
        CaptureBlame::Controller,
        "does not support a requested function (Not_Supported)",
    ),
    (DP_OTHER_MASTER, FindingSeverity::Error, CaptureBlame::Controller, "is locked by another master (Master_Lock)"),
    (DP_DIAGNOSIS, FindingSeverity::Warning, CaptureBlame::Device, "reports"),
];

impl SlaveDiagnoses {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        _ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        let Observation::Dp { ar, event: Dp::Diagnosis { station, octets, at, .. } } = observation else { return };
        let Ok(diag) = SlaveDiag::parse(octets) else { return };
        let first = diag.status_1;
        let reports = first.has(Status1::EXT_DIAG)
            || diag.status_2.has(Status2::STAT_DIAG)
            || diag.status_3.has(Status3::EXT_DIAG_OVERFLOW);
        let is = [
            (first.has(Status1::PRM_FAULT), 0),
            (first.has(Status1::CFG_FAULT), 0),
            (first.has(Status1::NOT_SUPPORTED), 0),
            (first.has(Status1::MASTER_LOCK), 0),
            (reports, if first.has(Status1::EXT_DIAG) || !diag.status_2.has(Status2::STAT_DIAG) { 0 } else { 1 }),
        ];
        for ((is, octet), (check, .., what)) in is.into_iter().zip(KINDS) {
            let key = (*station, check.id);
            match (is, self.0.get_mut(&key)) {
                (true, None) => {
                    findings.note(now.frame);
                    let text = format!("{what}: {}", words(&diag));
                    let (first, last, octet) = (now.frame, now.frame, at + octet);
                    self.0.insert(key, PendingDiagnosis { count: 1, first, last, octet, text, ar: *ar, gone: None });
                }
                (true, Some(known)) => {
                    (known.count, known.last, known.gone) = (known.count + 1, now.frame, None);
                    known.ar = known.ar.or(*ar);
                }
                (false, Some(known)) => {
                    known.gone.get_or_insert(now.frame);
                }
                (false, None) => {}
            }
        }
    }

    pub fn end(self, _ars: &[ObservedAr], findings: &mut FindingList) {
        for ((station, id), standing) in self.0 {
            let Some((check, severity, blame, _)) = KINDS.into_iter().find(|(check, ..)| check.id == id) else {
                continue;
            };
            let until = match standing.gone {
                Some(frame) => format!("cleared in frame {frame}"),
                None => "still set in its last diagnosis".to_owned(),
            };
            let severity =
                if standing.gone.is_some() && id == DP_DIAGNOSIS.id { FindingSeverity::Info } else { severity };
            let text = format!("slave {station} {}{}; {until}", standing.text, times(standing.count, standing.last));
            let finding = check.finding(severity, blame, standing.first, text).at(standing.octet, None);
            findings.add(on_bus(finding, standing.ar));
        }
    }
}

/// The bits that are set, and the blocks after them.
fn words(diag: &SlaveDiag) -> String {
    let bits = diag.status_1.words().chain(diag.status_2.words().filter(|word| *word != "fixed_one"));
    let mut words = vec![bits.chain(diag.status_3.words()).collect::<Vec<_>>().join(" ")];
    for block in diag.blocks().map_while(Result::ok).take(8) {
        words.push(match block {
            DiagnosisBlock::Device(data) => format!("device: {}", hex_start(data, MOST_OCTETS)),
            DiagnosisBlock::Identifier(data) => format!("identifiers: {}", hex_start(data, MOST_OCTETS)),
            DiagnosisBlock::Channel(channel) => {
                let error = channel.error_type;
                let error =
                    error.word().map_or_else(|| format!("error type {}", error.0), |word| word.replace('_', " "));
                format!("channel {} of identifier {}: {error}", channel.channel, channel.identifier)
            }
            DiagnosisBlock::Revision(revision) => format!("revision {revision}"),
        });
    }
    words.join(", ")
}

impl SlaveDiagnoses {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.0.retain(|_, known| known.gone.is_none_or(|gone| gone > settled.reported));
        let is_forgotten = |ar: Option<ArId>| ar.is_some_and(|ar| !settled.keeps(ar));
        self.0.values_mut().filter(|known| is_forgotten(known.ar)).for_each(|known| known.ar = None);
    }
}
