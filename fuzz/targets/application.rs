//! The answers of a program that is an application without a network.
#![no_main]

use application_protocol::ApplicationAnswer;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(answer) = serde_json::from_slice::<ApplicationAnswer>(data) else { return };
    let text = serde_json::to_string(&answer).expect("an answer is JSON");
    let again: ApplicationAnswer = serde_json::from_str(&text).expect("what was written is read");
    assert_eq!(again, answer);
});
