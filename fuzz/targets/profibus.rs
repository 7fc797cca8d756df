//! Each format of PROFIBUS alone; the first byte says which. What was read is written and read again, and is the same.
#![no_main]

use encspec_fuzz::twice;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::call::{Call, DpIm0};
use wire::profibus::cfg::Identifier;
use wire::profibus::diag::{DiagnosisMessage, SlaveDiag};
use wire::profibus::dpv1::{Dpv1Pdu, PduDirection};
use wire::profibus::fdl::FdlFrame;
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::{Isochronous, PrmBlock, SetPrm};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((which, octets)) = data.split_first() else { return };
    match which % 11 {
        0 => twice!(FdlFrame::parse, octets),
        1 => twice!(SlaveDiag::parse, octets),
        2 => twice!(DiagnosisMessage::parse, octets),
        3 => twice!(SetPrm::parse, octets),
        4 => drop(PrmBlock::parse_all(octets)),
        5 => twice!(Isochronous::parse, octets),
        6 => drop(Identifier::parse_all(octets)),
        7 => twice!(|octets| Dpv1Pdu::parse(octets, PduDirection::Request), octets),
        8 => twice!(|octets| Dpv1Pdu::parse(octets, PduDirection::Response), octets),
        9 => {
            twice!(Call::parse, octets);
            twice!(DpIm0::parse, octets);
        }
        _ => {
            twice!(GlobalControl::parse, octets);
            twice!(SetSlaveAddress::parse, octets);
        }
    }
});
