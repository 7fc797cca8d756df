//! A word in a suite, such as `{ refused: limit }`, is unambiguous: the code tables share no word.

use encspec_wire::profidrive::ErrorNumber;
use encspec_wire::profinet::dcp::BlockError;
use encspec_wire::profinet::status::{AbortReason, CmrpcError, ErrorSource, PnioStatus, RecordError};

#[test]
fn refusals_of_different_services_share_no_word() {
    let parameter: Vec<&str> = ErrorNumber::TABLE.iter().map(|entry| entry.1).collect();
    let dcp: Vec<&str> = BlockError::TABLE.iter().map(|entry| entry.1).filter(|word| *word != "ok").collect();
    let records = RecordError::TABLE.iter().map(|entry| entry.1);
    let finders = ErrorSource::TABLE.iter().map(|entry| entry.1);
    let calls = CmrpcError::TABLE.iter().map(|entry| entry.1);
    let aborts = AbortReason::TABLE.iter().map(|entry| entry.1);
    let status: Vec<&str> = records.chain(finders).chain(calls).chain(aborts).collect();
    let shared = |one: &[&str], other: &[&str]| one.iter().filter(|word| other.contains(word)).count();
    assert!(parameter.len() > 20 && dcp.len() > 5 && status.len() > 50, "the tables are not empty");
    assert_eq!(shared(&parameter, &dcp), 0, "PROFIdrive and DCP");
    assert_eq!(shared(&parameter, &status), 0, "PROFIdrive and PNIO status: {status:?}");
    assert_eq!(shared(&dcp, &status), 0, "DCP and PNIO status: {status:?}");
    assert!(parameter.iter().chain(&dcp).all(|word| !PnioStatus::is_status_word(word)));
}

#[test]
fn numbers_of_the_parameter_table_ascend_and_its_words_differ() {
    assert!(ErrorNumber::TABLE.is_sorted_by(|one, next| one.0 < next.0));
    for (number, word, sentence) in ErrorNumber::TABLE {
        assert_eq!(ErrorNumber::by_word(word), Some(*number));
        assert_eq!((number.word(), number.sentence()), (Some(*word), Some(*sentence)));
    }
    assert_eq!(ErrorNumber(0x65).word(), None, "vendor-specific numbers have no word");
}
