//! Programs that fail: each failure is one sentence that says what happened and what to do, and none lets a test go on.

use application_protocol::{
    ApplicationBus, ApplicationProgram, ApplicationRequest, ProgramCommand, ProgramFailure, VERSION,
};
use std::path::Path;
use std::time::{Duration, Instant};

/// A description of a slave, with an answer to `hello`.
const HELLO: &str =
    r#"{"answer":"hello","description":{"version":1,"name":"test","profibus":{"ident":1,"configuration":"D1"}}}"#;

/// Starts a shell script, which reads lines and answers them, with a short patience.
fn start(script: &str) -> Result<ApplicationProgram, ProgramFailure> {
    let words = ["sh", "-c", script].map(str::to_owned).to_vec();
    ApplicationProgram::start(
        ProgramCommand::new(words, Path::new("")),
        ApplicationBus::Profibus,
        Duration::from_secs(5),
    )
}

/// The failure of a program that answers `hello`, and the next message by `script`.
fn failure_after_hello(script: &str) -> String {
    let mut program = start(&format!("read line; echo '{HELLO}'; read line; {script}")).expect("it answers `hello`");
    assert_eq!(program.ask(&ApplicationRequest::PowerDown { now: 5 }), None);
    let failure = program.failure().expect("a failure").to_string();
    assert_eq!(program.ask(&ApplicationRequest::PowerUp { now: 6 }), None, "a failed program is not asked again");
    assert_eq!(program.failure().map(ToString::to_string), Some(failure.clone()));
    failure
}

#[test]
fn program_that_is_not_there() {
    let words = vec!["./no-such-program".to_owned()];
    let command = ProgramCommand::new(words, Path::new("/"));
    let failure =
        ApplicationProgram::start(command, ApplicationBus::Profinet, Duration::from_secs(1)).expect_err("none");
    let text = failure.to_string();
    assert!(text.starts_with("the program ./no-such-program cannot be started (No such file"), "{text}");
    assert!(text.ends_with("; check the command after `app:`, which is looked up in /"), "{text}");
}

#[test]
fn program_that_exits_says_how_and_what_it_complained_about() {
    let text = failure_after_hello("echo one >&2; echo 'no \x1b[31mmemory' >&2; exit 3");
    let asked = r#"`{"message":"power_down","now":5}`"#;
    assert!(text.starts_with(&format!("the program ended (exit status: 3) instead of answering {asked}; ")), "{text}");
    assert!(text.ends_with(r"its last lines on standard error: one / no \u{1b}[31mmemory"), "{text}");
}

#[test]
fn program_that_is_killed() {
    let text = failure_after_hello("kill -9 $$");
    assert!(text.starts_with("the program ended (signal: 9 (SIGKILL)) instead of answering"), "{text}");
}

#[test]
fn program_that_is_silent() {
    let began = Instant::now();
    let words = ["sh", "-c", "read line; exec sleep 100"].map(str::to_owned).to_vec();
    let command = ProgramCommand::new(words, Path::new(""));
    let patience = Duration::from_millis(300);
    let failure = ApplicationProgram::start(command, ApplicationBus::Profibus, patience).expect_err("silent");
    assert!(began.elapsed() >= patience);
    let text = failure.to_string();
    assert!(
        text.starts_with("the program was silent for 0.3 s of real time when it was asked `{\"message\":\"hello\""),
        "{text}"
    );
    assert!(text.contains("flush standard output"), "{text}");
}

#[test]
fn program_that_prints_something_else() {
    let text = failure_after_hello(r"printf 'debug: \033[31mred\n'");
    assert!(text.contains(r"is not an answer (expected value at line 1 column 1): `debug: \u{1b}[31mred`"), "{text}");
    let text = failure_after_hello(&format!("printf '{}\\n'", "x".repeat(500)));
    assert!(text.contains(&format!("`{}...`; print nothing else", "x".repeat(160))), "{text}");
    let text = failure_after_hello(r#"echo '{"answer":"power_down","deadlin":7}'"#);
    assert!(text.contains("unknown field `deadlin`, expected one of `answer`, `error`"), "{text}");
    let text = failure_after_hello(r#"echo '{"answer":"power_down","data":"0x04"}'"#);
    assert!(text.contains("hexadecimal digits without spaces"), "{text}");
    let text = failure_after_hello(r"printf 'no line feed'");
    assert!(text.contains("it has no line feed: no line feed"), "{text}");
}

#[test]
fn program_that_answers_something_else() {
    let text = failure_after_hello(r#"echo '{"answer":"power_up"}'"#);
    assert!(
        text.starts_with("the program answered `power_up` when it was asked `{\"message\":\"power_down\""),
        "{text}"
    );
    let text = failure_after_hello(r#"echo '{"answer":"power_down","error":"the EEPROM is full"}'; read line"#);
    assert!(text.contains("reported an error") && text.ends_with("the EEPROM is full"), "{text}");
}

#[test]
fn program_that_prints_too_much() {
    let mut program = start(&format!(
        "read line; echo '{HELLO}'; read line; echo '{{\"answer\":\"power_down\"}}'; echo more; read line"
    ))
    .expect("it answers `hello`");
    assert!(program.ask(&ApplicationRequest::PowerDown { now: 5 }).is_some());
    assert_eq!(program.ask(&ApplicationRequest::PowerUp { now: 6 }), None);
    // The second line may arrive before the next message or instead of its answer.
    let text = program.failure().expect("a failure").to_string();
    assert!(text.contains("`more`"), "{text}");
}

#[test]
fn program_of_another_version() {
    let other = HELLO.replace("\"version\":1", "\"version\":2");
    let failure = start(&format!("read line; echo '{other}'; read line")).expect_err("another version");
    assert_eq!(failure, ProgramFailure::Version { theirs: 2 });
    let own = format!("the program speaks version 2 of the messages, and this encspec speaks version {VERSION}");
    assert_eq!(failure.to_string(), own);
}

#[test]
fn program_of_the_other_bus() {
    let script = format!("read line; echo '{HELLO}'; read line");
    let words = ["sh", "-c", script.as_str()].map(str::to_owned).to_vec();
    let command = ProgramCommand::new(words, Path::new(""));
    let failure =
        ApplicationProgram::start(command, ApplicationBus::Profinet, Duration::from_secs(5)).expect_err("a slave");
    assert!(failure.to_string().ends_with("it has no `profinet`, and the suite is one of PROFINET"), "{failure}");
}

#[test]
fn failed_program_is_started_again_and_may_not_change() {
    let folder = std::env::temp_dir().join(format!("encspec-revive-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let other = HELLO.replace("\"ident\":1", "\"ident\":2");
    let script = format!(
        "if [ -e third ]; then hello='{other}'; else hello='{HELLO}'; fi; [ -e second ] && touch third; touch second; \
         read line; echo \"$hello\"; read line; exit 1"
    );
    let words = ["sh", "-c", script.as_str()].map(str::to_owned).to_vec();
    let command = ProgramCommand::new(words, &folder);
    let mut program =
        ApplicationProgram::start(command, ApplicationBus::Profibus, Duration::from_secs(5)).expect("the first start");
    assert_eq!(program.ask(&ApplicationRequest::Reset { shaft: 1 }), None);
    assert_eq!(program.revive(), Ok(()));
    assert_eq!(program.failure(), None);
    assert_eq!(program.ask(&ApplicationRequest::Reset { shaft: 1 }), None);
    assert_eq!(program.revive(), Err(ProgramFailure::Changed));
    std::fs::remove_dir_all(&folder).expect("the folder");
}
