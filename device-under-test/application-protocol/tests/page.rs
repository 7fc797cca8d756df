//! `docs/application-protocol.md`: each example on the page is a message or an answer, and no message is missing.

use application_protocol::{ApplicationAnswer, ApplicationRequest, VERSION};
use std::collections::BTreeSet;
use std::path::Path;

fn page() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/application-protocol.md");
    std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()))
}

/// The examples of the page: `> ` before what encspec sends, `< ` before what the program answers.
fn examples(page: &str, begin: &str) -> Vec<String> {
    page.lines().filter_map(|line| line.strip_prefix(begin)).map(str::to_owned).collect()
}

#[test]
fn each_message_has_an_example_that_is_read_and_written_as_printed() {
    let page = page();
    let mut found = BTreeSet::new();
    for line in examples(&page, "> {") {
        let line = format!("{{{line}");
        let request: ApplicationRequest = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line}: {error}"));
        assert_eq!(serde_json::to_string(&request).expect("text"), line);
        found.insert(request.word());
    }
    let known: BTreeSet<&str> = ApplicationRequest::WORDS.into_iter().collect();
    assert_eq!(found, known);
    assert_eq!(known.len(), ApplicationRequest::WORDS.len());
}

#[test]
fn each_example_is_followed_by_its_answer() {
    let page = page();
    let lines: Vec<&str> = page.lines().collect();
    let mut answers = 0;
    for pair in lines.windows(2).filter(|pair| pair[0].starts_with("> {")) {
        let answer = pair[1].strip_prefix("< ").unwrap_or_else(|| panic!("{} has no answer", pair[0]));
        let request: ApplicationRequest = serde_json::from_str(&pair[0][2..]).expect("a message");
        let read: ApplicationAnswer = serde_json::from_str(answer).unwrap_or_else(|error| panic!("{answer}: {error}"));
        assert_eq!(read.answer, request.word(), "{answer}");
        answers += 1;
    }
    assert!(answers >= ApplicationRequest::WORDS.len(), "only {answers} answers");
}

#[test]
fn page_names_the_version_and_each_field_of_an_answer() {
    let page = page();
    assert!(page.contains(&format!("version {VERSION} of the messages")), "the version is missing");
    // The error of an unknown field lists the known ones.
    let unknown = serde_json::from_str::<ApplicationAnswer>(r#"{"?":1}"#).expect_err("an unknown field").to_string();
    let known: Vec<&str> = unknown.split('`').skip(3).step_by(2).collect();
    assert!(known.len() > 15, "{unknown}");
    for field in known {
        let is_named = page.contains(&format!("`{field}`")) || page.contains(&format!("\"{field}\":"));
        assert!(is_named, "the page does not name the field {field}");
    }
}
