use super::*;
use rstest::rstest;

#[rstest]
#[case("power up", StandAction::Power(true), "power")]
#[case("power down", StandAction::Power(false), "power")]
#[case("link down", StandAction::Link(false), "link")]
#[case("shaft speed -12.5", StandAction::ShaftSpeed(-12.5), "shaft.speed")]
#[case("shaft speed 60 acceleration 1.5", StandAction::ShaftRamp { rpm: 60.0, acceleration: 1.5 }, "shaft.acceleration")]
#[case("shaft counts 262143", StandAction::ShaftCounts(262_143), "shaft.counts")]
#[case("turn counts -100 rpm 60", StandAction::Turn { steps: -100.0, rpm: 60.0 }, "turn")]
#[case("turn revolutions 1.5 rpm 0.1", StandAction::TurnRevolutions { revolutions: 1.5, rpm: 0.1 }, "turn")]
#[case("fault memory present", StandAction::Fault("memory", true), "fault.memory")]
#[case("button preset released", StandAction::Button("preset", false), "button.preset")]
#[case("switch address_high 15", StandAction::Switch("address_high", 15), "switch.address_high")]
#[case("voltage 24", StandAction::SupplyVoltage(24.0), "supply.voltage")]
#[case("temperature -40", StandAction::Temperature(-40.0), "supply.temperature")]
#[case("renew", StandAction::ReplaceDevice, "renew")]
#[case("device as_delivered", StandAction::RestoreFactoryState, "device")]
#[case("clock 60.500000000", StandAction::Skip(Duration::from_millis(60_500)), "clock")]
fn each_action_has_one_line(#[case] line: &str, #[case] action: StandAction<'_>, #[case] needs: &str) {
    assert_eq!(StandCommand::parse(line), Ok(StandCommand::Act(action.clone())));
    assert_eq!(StandCommand::Act(action.clone()).to_string(), line);
    assert_eq!(ability(&action), needs);
}

#[rstest]
#[case("led bf", StandCommand::Led("bf"))]
#[case("counter nvm_writes", StandCommand::Counter("nvm_writes"))]
#[case("abilities", StandCommand::Abilities)]
#[case("help", StandCommand::Help)]
fn questions(#[case] line: &str, #[case] command: StandCommand<'_>) {
    assert_eq!(StandCommand::parse(&format!("  {line} \r\n")), Ok(command.clone()));
    assert_eq!(command.to_string(), line);
}

#[rstest]
#[case("", "the line is empty; send `help` for a list of commands")]
#[case("powr up", "unknown command powr; did you mean power?")]
#[case("\u{1b}[2Jx", "unknown command \\u{1b}[2Jx; send `help` for a list of commands")]
#[case("power", "the form is power up|down")]
#[case("power on", "`on` is neither up nor down")]
#[case("power up now", "the form is power up|down")]
#[case("device new", "the form is device as_delivered")]
#[case("shaft", "the form is shaft speed RPM or shaft speed RPM acceleration A or shaft counts N")]
#[case("shaft speed 60 acceleration 0", "the speed must be more than 0 rpm, not 0")]
#[case("shaft speed NaN", "`NaN` is not a number")]
#[case("shaft speed inf", "`inf` is not a number")]
#[case("shaft speed 1e999", "`1e999` is not a number")]
#[case("shaft counts -1", "`-1` is not a whole number in range")]
#[case("shaft counts 18446744073709551616", "`18446744073709551616` is not a whole number in range")]
#[case("turn counts 5 rpm 0", "the speed must be more than 0 rpm, not 0")]
#[case("fault a;b present", "`a;b` is not a name")]
#[case("clock -1", "`-1` is not a number of seconds")]
#[case("clock 1.", "`1.` is not a number of seconds")]
#[case("clock 4294967296", "`4294967296` is not a number of seconds")]
fn a_line_that_is_not_a_command_is_refused(#[case] line: &str, #[case] why: &str) {
    assert_eq!(StandCommand::parse(line), Err(why.to_owned()));
}

#[test]
fn a_line_that_is_too_long_is_refused() {
    let long = format!("led {}", "x".repeat(LONGEST_LINE));
    assert_eq!(StandCommand::parse(&long), Err("a line has at most 1000 bytes, this one has 1004".into()));
    assert!(StandAnswer::parse(&format!("ok {long}")).is_err());
    assert!(StandAnswer::Cannot("\u{7}".repeat(5_000)).to_string().len() <= LONGEST_LINE);
}

#[rstest]
#[case("ok", StandAnswer::Done(Duration::ZERO))]
#[case("ok done-in 1500000000", StandAnswer::Done(Duration::from_millis(1_500)))]
#[case("ok green_flashing", StandAnswer::Word("green_flashing".into()))]
#[case("ok power link clock", StandAnswer::Word("power link clock".into()))]
#[case("cannot press a button", StandAnswer::Cannot("press a button".into()))]
#[case("broken the relay sticks", StandAnswer::Broken("the relay sticks".into()))]
fn answers(#[case] line: &str, #[case] answer: StandAnswer) {
    assert_eq!(StandAnswer::parse(&format!("{line}\n")), Ok(answer.clone()));
    assert_eq!(answer.to_string(), line);
}

#[rstest]
#[case("")]
#[case("okay")]
#[case("OK")]
#[case("cannot")]
#[case("broken ")]
#[case("ok done-in soon")]
#[case("ok done-in -1")]
fn an_invalid_answer_is_refused(#[case] line: &str) {
    let error = StandAnswer::parse(line).expect_err("no answer");
    assert_eq!(error, format!("the stand answered `{line}`, which is not a valid answer"));
}

#[test]
fn no_damaged_line_reaches_the_terminal_unescaped() {
    for (form, _) in FORMS {
        let line = form.replace("RPM", "5").replace("NAME", "a").split('|').next().expect("a form").to_owned();
        for end in 0..=line.len() {
            for octet in 0..=0x7F {
                let damaged = format!("{}{}{}", &line[..end], char::from(octet), line.get(end + 1..).unwrap_or(""));
                for text in [&line[..end], &damaged] {
                    if let Ok(command) = StandCommand::parse(text) {
                        assert_eq!(StandCommand::parse(&command.to_string()), Ok(command), "{text:?}");
                    }
                    let said = match StandAnswer::parse(text) {
                        Ok(answer) => answer.to_string(),
                        Err(why) => why,
                    };
                    assert!(said.bytes().all(|octet| octet == b' ' || octet.is_ascii_graphic()), "{said:?}");
                }
            }
        }
    }
}

#[test]
fn help_lists_every_form() {
    let StandAnswer::Word(text) = StandAnswer::help() else { panic!("help is a text") };
    assert!(FORMS.iter().all(|(form, _)| text.contains(form)));
    assert!(text.len() < LONGEST_LINE - 10, "help is one line of {} bytes", text.len());
    for (form, _) in FORMS {
        let head = form.split(' ').next().expect("a word");
        assert!(StandCommand::parse(&format!("{head} of too many words here")).is_err());
    }
}
