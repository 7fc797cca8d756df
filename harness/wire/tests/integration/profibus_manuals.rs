//! Examples in manuals of encoders and other devices, byte by byte; where a manual has no example, bytes built from its tables.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::profibus::call::{Call, DpIm0, FunctionIndex};
use encspec_wire::profibus::cfg::{Identifier, IoLengths, Length, ManufacturerData, io_lengths};
use encspec_wire::profibus::diag::{
    ChannelType, DiagnosisBlock, DiagnosisMessage, DpChannelDiagnosis, ErrorType, SlaveDiag, Status1, Status2,
    StatusType, identifiers,
};
use encspec_wire::profibus::dpv1::{
    Dpv1AbortReason, Dpv1ErrorDecode, Dpv1Function, Dpv1Pdu, Dpv1Record, Dpv1Refusal, PduDirection, RecordError, Subnet,
};
use encspec_wire::profidrive::ParameterRequest;
use rstest::rstest;
use testing::hex;

/// datalogic-amt58-profibus, section 5.2, screen of the diagnosis of 63 bytes; bytes outside the screenshot are 00 here.
#[test]
fn the_diagnosis_of_63_octets() {
    let octets = hex("000C0002 16553900 CA000000 04000000
         00000000 00000001 01000200 00000000 00000000 00000000 00040000 04000000 00000000 00000000 00000000 000000");
    assert_eq!(octets.len(), 63);
    let diag = SlaveDiag::parse(&octets).unwrap();
    assert_eq!((diag.status_1, diag.status_2), (Status1(0), Status2::FIXED_ONE.with(Status2::WD_ON)));
    assert_eq!(diag.status_2.words().collect::<Vec<_>>(), ["fixed_one", "wd_on"]);
    assert_eq!((diag.master, diag.ident, diag.status_3.0), (2, 0x1655, 0));
    let blocks: Vec<_> = diag.blocks().collect::<Result<_, _>>().unwrap();
    let [DiagnosisBlock::Device(data)] = blocks[..] else { panic!("{blocks:?}") };
    assert_eq!((data.len(), data[1]), (56, 0xCA), "operating status");
    assert_eq!(written(|out| diag.write(out)), octets);
}

/// datalogic-amt58-profibus, section 6.7, table of the 16 bytes: the header is byte 6, and its length of 10 bytes includes it.
#[test]
fn the_diagnosis_of_16_octets() {
    let diag = SlaveDiag::parse(&hex("000C0002 1655 0A 000A0000 04000001 00 00")[..16]).unwrap();
    assert!(matches!(diag.blocks().next(), Some(Ok(DiagnosisBlock::Device(data))) if data.len() == 9));
    assert_eq!(diag.blocks().count(), 1);
}

/// sick-a3m60-profibus, section 5.4.1, tables 33 and 34: two errors at once.
#[test]
fn channel_related_diagnosis() {
    let diag = SlaveDiag::parse(&hex("080C00020C0A 814036 814038")).unwrap();
    let channel = |error| {
        Ok(DiagnosisBlock::Channel(DpChannelDiagnosis {
            identifier: 1,
            direction: 1,
            channel: 0,
            channel_type: ChannelType::BIT,
            error_type: ErrorType(error),
        }))
    };
    assert_eq!(diag.blocks().collect::<Vec<_>>(), [channel(0x16), channel(0x18)]);
    assert_eq!(diag.status_1, Status1::EXT_DIAG);
}

/// Blocks from the tables of a valve drive (Emerson OM9 EPI2, data exchange mode) and of an inverter (ABB FPBA-01).
#[test]
fn identifier_related_diagnosis_and_status() {
    let diag = SlaveDiag::parse(&hex("080C0002 1234 4201 0681000010AA")).unwrap();
    let blocks: Vec<_> = diag.blocks().collect::<Result<_, _>>().unwrap();
    let [DiagnosisBlock::Identifier(modules), DiagnosisBlock::Device(status)] = blocks[..] else {
        panic!("{blocks:?}")
    };
    assert_eq!(identifiers(modules).collect::<Vec<_>>(), [0]);
    let message = DiagnosisMessage::parse(status).unwrap();
    assert_eq!((message.status(), message.alarm()), (Some(StatusType::STATUS_MESSAGE), None));
    assert_eq!((message.slot, message.data), (0, &[0x10, 0xAA][..]));
}

#[rstest]
#[case::zero("08 0C 00 02 16 55 00 81 40 36", "byte 6: block length is 0x0")]
#[case::zero_identifier("08 0C 00 02 16 55 81 40 36 40", "byte 9: block length is 0x0")]
#[case::cut("08 0C 00 02 16 55 81 40 36 0A 01", "byte 10: expected 9 bytes, 1 left")]
#[case::cut_channel("08 0C 00 02 16 55 81 40", "byte 8: expected 1 bytes, 0 left")]
fn an_invalid_block_ends_the_iteration(#[case] octets: &str, #[case] says: &str) {
    let diag = SlaveDiag::parse(&hex(octets)).unwrap();
    let error = diag.blocks().last().unwrap().unwrap_err();
    assert!(error.to_string().contains(says), "{error}");
    assert_eq!(diag.blocks().filter(Result::is_err).count(), 1);
}

/// datalogic-amt58-profibus, section 6.5: D1 4 bytes of inputs, D3 8 of them, E1 4 of outputs.
#[rstest]
#[case("D1E1", 4, 4)]
#[case("D3E1", 8, 4)]
fn configurations(#[case] octets: &str, #[case] inputs: usize, #[case] outputs: usize) {
    let identifiers = Identifier::parse_all(&hex(octets)).unwrap();
    assert_eq!(io_lengths(&identifiers), IoLengths { inputs, outputs });
    assert!(identifiers.iter().all(|identifier| {
        matches!(identifier, Identifier::General { length: Length { words: true, whole: true, .. }, .. })
    }));
}

/// The identifiers of PROFIdrive telegrams 81 and 83 (PROFIdrive profile, mapping to PROFIBUS DP).
#[rstest]
#[case("C3C1C5FD0051", 12, 4, 0x51)]
#[case("C3C1C7FD0053", 16, 4, 0x53)]
fn telegrams(#[case] octets: &str, #[case] inputs: usize, #[case] outputs: usize, #[case] telegram: u8) {
    let identifiers = Identifier::parse_all(&hex(octets)).unwrap();
    assert_eq!(io_lengths(&identifiers), IoLengths { inputs, outputs });
    let [Identifier::Special { maker: ManufacturerData::Octets(maker), .. }] = &identifiers[..] else {
        panic!("{identifiers:?}")
    };
    assert_eq!(maker, &[0xFD, 0x00, telegram]);
}

/// The example of a write in the manual of a transducer (Balluff BTL7-T500, table 4-8), with the actual length.
#[test]
fn a_write_of_record_47() {
    let pdu = Dpv1Pdu::parse(&hex("5F002F10 01020001 100107D00000 4301000003E8"), PduDirection::Request).unwrap();
    let Dpv1Pdu::Write(Dpv1Record { slot: 0, index: 47, length: 16, data }) = pdu else { panic!("{pdu:?}") };
    let request = ParameterRequest::parse(&data).unwrap();
    assert_eq!((request.header.reference, request.addresses[0].number), (1, 2000));
    assert_eq!(
        Dpv1Pdu::parse(&hex("5F002F10"), PduDirection::Response).map(|pdu| pdu.function()),
        Ok(Dpv1Function::WRITE)
    );
}

/// Refusals with the names of PROFIdrive and of the manuals of encoders: state conflict, invalid index.
#[rstest]
#[case("DE80B500", Dpv1Function::READ_REFUSED, RecordError::STATE_CONFLICT)]
#[case("DE80B000", Dpv1Function::READ_REFUSED, RecordError::INVALID_INDEX)]
#[case("DF80B000", Dpv1Function::WRITE_REFUSED, RecordError::INVALID_INDEX)]
#[case("DF80B200", Dpv1Function::WRITE_REFUSED, RecordError::INVALID_SLOT)]
#[case("DF80A100", Dpv1Function::WRITE_REFUSED, RecordError::WRITE_ERROR)]
#[case("DE80C300", Dpv1Function::READ_REFUSED, RecordError::RESOURCE_UNAVAILABLE)]
fn refusals(#[case] octets: &str, #[case] function: Dpv1Function, #[case] error: RecordError) {
    let pdu = Dpv1Pdu::parse(&hex(octets), PduDirection::Response).unwrap();
    let expected = Dpv1Refusal { function, decode: Dpv1ErrorDecode::DPV1, code_1: error.0, code_2: 0 };
    assert_eq!(pdu, Dpv1Pdu::Refused(expected));
    assert_eq!(expected.record_error(), Some(error));
    assert!(error.word().is_some());
    assert_eq!(written(|out| pdu.write(out)), hex(octets));
}

/// Resource manager, abort and idle from the tables of slave stacks and of a master (ProSoft MVI69-PDPMV1, abort reasons).
#[test]
fn connections() {
    let manager = Dpv1Pdu::parse(&hex("56300064"), PduDirection::Response);
    assert_eq!(manager, Ok(Dpv1Pdu::ResourceManager { sap: 48, send_timeout: 100 }));
    let abort = Dpv1Pdu::parse(&hex("580113"), PduDirection::Request).unwrap();
    assert_eq!(abort, Dpv1Pdu::Abort { subnet: Subnet::LOCAL, reason: Dpv1AbortReason::TIMEOUT, more: Vec::new() });
    assert_eq!(Dpv1Pdu::parse(&hex("48"), PduDirection::Response), Ok(Dpv1Pdu::Idle(Vec::new())));
}

/// The Initiate of a transducer (Balluff BTL7-T500, configuration guide, tables 4-16 and 4-18); the additional addresses, which the tables
/// shorten to the two APIs, with types and lengths.
#[test]
fn initiate_of_a_class_2_master() {
    let request = hex("57 000000 0064 0100 0000 0303 00 02 00 02 0000 0000");
    let Dpv1Pdu::InitiateRequest { reserved, send_timeout, abilities } =
        Dpv1Pdu::parse(&request, PduDirection::Request).unwrap()
    else {
        panic!("no Initiate")
    };
    assert_eq!((reserved, send_timeout, abilities.features, abilities.profile), ([0; 3], 100, [1, 0], 0x0303));
    assert_eq!((abilities.source.kind, abilities.source.address), (0, vec![0, 0]));
    let response = hex("57 F0 0100 0000 0303 00 02 00 02 0000 0000");
    let Dpv1Pdu::InitiateResponse { most_data, abilities } = Dpv1Pdu::parse(&response, PduDirection::Response).unwrap()
    else {
        panic!("no response")
    };
    assert_eq!((most_data, abilities.profile, abilities.destination.address), (240, 0x0303, vec![0, 0]));
}

/// The header of CALL for I&M0 (Balluff BTL7-T500, table 4-9; ABB FPBA-01, Call-REQ-PDU; ifm AC412S, I&M0 data).
#[test]
fn the_call_of_identification_and_maintenance_data() {
    let call = Call::read_of(FunctionIndex::IM0);
    assert_eq!(written(|out| call.write(out)), hex("0800 FDE8"));
    assert_eq!(Call::parse(&hex("0800 FDE8")).unwrap(), call);
    assert_eq!(FunctionIndex::im(2), Some(FunctionIndex(0xFDEA)), "the last of the ifm AC412S is I&M2");
    assert_eq!(FunctionIndex::im(200), None);
    assert!(Call::parse(&hex("0800 FD")).is_err());
}

/// I&M0 with the values of an adapter (ABB FPBA-01, response structure for I&M0): 10 bytes of the manufacturer, then 54.
#[test]
fn the_identification_of_a_module_on_profibus() {
    let mut octets = b"FPBA-01   ".to_vec();
    octets.extend(hex("001A"));
    octets.extend(b"68469325            ");
    octets.extend(b"1234567890ABCDEF");
    octets.extend(hex("0001 56010000 0000 3A00 0000 0101 0003"));
    assert_eq!(octets.len(), 64);
    let record = DpIm0::parse(&octets).unwrap();
    assert_eq!((record.im0.vendor_id, &record.im0.order_id), (0x001A, b"68469325            "));
    assert_eq!((record.im0.software_revision.prefix, record.im0.profile_id), (b'V', 0x3A00));
    assert_eq!((record.im0.im_version, record.im0.im_supported), ([1, 1], 3));
    assert_eq!(written(|out| record.write(out)), octets);
    assert!(DpIm0::parse(&octets[..63]).is_err() && DpIm0::parse(&[&octets[..], &[0]].concat()).is_err());
}
