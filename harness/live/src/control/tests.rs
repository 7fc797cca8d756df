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
#[case("renew", StandAction::Renew, "renew")]
#[case("device as_delivered", StandAction::Deliver, "device")]
#[case("clock 60.500000000", StandAction::Skip(Duration::from_millis(60_500)), "clock")]
fn each_action_has_one_line(#[case] line: &str, #[case] action: StandAction<'_>, #[case] needs: &str) {
    assert_eq!(Command::parse(line), Ok(Command::Act(action.clone())));
    assert_eq!(Command::Act(action.clone()).to_string(), line);
    assert_eq!(ability(&action), needs);
}

#[rstest]
#[case("led bf", Command::Led("bf"))]
#[case("counter nvm_writes", Command::Counter("nvm_writes"))]
#[case("abilities", Command::Abilities)]
#[case("help", Command::Help)]
fn questions(#[case] line: &str, #[case] command: Command<'_>) {
    assert_eq!(Command::parse(&format!("  {line} \r\n")), Ok(command.clone()));
    assert_eq!(command.to_string(), line);
}

#[rstest]
#[case("", "the line is empty; ask for help")]
#[case("powr up", "there is no command powr; did you mean power?")]
#[case("\u{1b}[2Jx", "there is no command \\u{1b}[2Jx; ask for help")]
#[case("power", "write it as power up|down")]
#[case("power on", "`on` is neither up nor down")]
#[case("power up now", "write it as power up|down")]
#[case("device new", "write it as device as_delivered")]
#[case("shaft", "write it as shaft speed RPM or shaft speed RPM acceleration A or shaft counts N")]
#[case("shaft speed 60 acceleration 0", "the shaft moves by more than 0 rpm, not by 0")]
#[case("shaft speed NaN", "`NaN` is no number")]
#[case("shaft speed inf", "`inf` is no number")]
#[case("shaft speed 1e999", "`1e999` is no number")]
#[case("shaft counts -1", "`-1` is no whole number in range")]
#[case("shaft counts 18446744073709551616", "`18446744073709551616` is no whole number in range")]
#[case("turn counts 5 rpm 0", "the shaft moves by more than 0 rpm, not by 0")]
#[case("fault a;b present", "`a;b` is no name")]
#[case("clock -1", "`-1` is no number of seconds")]
#[case("clock 1.", "`1.` is no number of seconds")]
#[case("clock 4294967296", "`4294967296` is no number of seconds")]
fn a_line_that_is_no_command(#[case] line: &str, #[case] why: &str) {
    assert_eq!(Command::parse(line), Err(why.to_owned()));
}

#[test]
fn a_line_has_an_end() {
    let long = format!("led {}", "x".repeat(LONGEST_LINE));
    assert_eq!(Command::parse(&long), Err("a line has at most 1000 octets, this one has 1004".into()));
    assert!(Answer::parse(&format!("ok {long}")).is_err());
    assert!(Answer::Cannot("\u{7}".repeat(5_000)).to_string().len() <= LONGEST_LINE);
}

#[rstest]
#[case("ok", Answer::Done(Duration::ZERO))]
#[case("ok done-in 1500000000", Answer::Done(Duration::from_millis(1_500)))]
#[case("ok green_flashing", Answer::Word("green_flashing".into()))]
#[case("ok power link clock", Answer::Word("power link clock".into()))]
#[case("cannot press a button", Answer::Cannot("press a button".into()))]
#[case("broken the relay sticks", Answer::Broken("the relay sticks".into()))]
fn answers(#[case] line: &str, #[case] answer: Answer) {
    assert_eq!(Answer::parse(&format!("{line}\n")), Ok(answer.clone()));
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
fn what_is_no_answer(#[case] line: &str) {
    let error = Answer::parse(line).expect_err("no answer");
    assert_eq!(error, format!("the stand answered `{line}`, which is no answer"));
}

#[test]
fn no_line_breaks_the_reader_or_the_terminal() {
    for (form, _) in FORMS {
        let line = form.replace("RPM", "5").replace("NAME", "a").split('|').next().expect("a form").to_owned();
        for end in 0..=line.len() {
            for octet in 0..=0x7F {
                let damaged = format!("{}{}{}", &line[..end], char::from(octet), line.get(end + 1..).unwrap_or(""));
                for text in [&line[..end], &damaged] {
                    if let Ok(command) = Command::parse(text) {
                        assert_eq!(Command::parse(&command.to_string()), Ok(command), "{text:?}");
                    }
                    let said = match Answer::parse(text) {
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
fn help_names_every_form() {
    let Answer::Word(text) = Answer::help() else { panic!("help is a text") };
    assert!(FORMS.iter().all(|(form, _)| text.contains(form)));
    assert!(text.len() < LONGEST_LINE - 10, "help is one line of {} octets", text.len());
    for (form, _) in FORMS {
        let head = form.split(' ').next().expect("a word");
        assert!(Command::parse(&format!("{head} of too many words here")).is_err());
    }
}
