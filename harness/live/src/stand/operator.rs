//! The operator at the terminal, who performs the actions that a stand cannot.

use station::{Duration, StandAction, StandRefusal};
use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

/// Timeout for the operator.
const OPERATOR_TIMEOUT: Duration = Duration::from_secs(600);

/// The typed lines; one thread per process reads them.
static LINES: Mutex<Option<Receiver<String>>> = Mutex::new(None);

/// Shows `words` and waits until the operator confirms.
pub(super) fn ask(words: &str) -> Result<(), StandRefusal> {
    if !io::stdin().is_terminal() {
        return Err(StandRefusal::CannotDo(format!("there is no terminal for the operator: {words}")));
    }
    let Ok(mut lines) = LINES.lock() else {
        return Err(StandRefusal::Broken("the terminal cannot be read".to_owned()));
    };
    let lines = lines.get_or_insert_with(typed);
    // Lines typed before the request are discarded.
    while lines.try_recv().is_ok() {}
    // An operator who cannot see the request will not answer it.
    let _ = writeln!(io::stderr(), "\n>>> {words}. Then press Enter; `no` if it cannot be done.");
    answer(lines, words, OPERATOR_TIMEOUT)
}

fn answer(lines: &Receiver<String>, words: &str, patience: Duration) -> Result<(), StandRefusal> {
    match lines.recv_timeout(patience) {
        Ok(line) if ["", "y", "yes", "ok", "done"].contains(&line.trim().to_ascii_lowercase().as_str()) => Ok(()),
        Ok(_) => Err(StandRefusal::CannotDo(format!("the operator says that it cannot be done: {words}"))),
        Err(RecvTimeoutError::Timeout) => {
            Err(StandRefusal::Broken(format!("the operator has not answered for {} s: {words}", patience.as_secs())))
        }
        Err(RecvTimeoutError::Disconnected) => Err(StandRefusal::Broken("the terminal was closed".to_owned())),
    }
}

fn typed() -> Receiver<String> {
    let (give, take) = channel();
    thread::spawn(move || {
        for line in io::stdin().lock().lines() {
            let given = line.is_ok_and(|line| give.send(line).is_ok());
            if !given {
                return;
            }
        }
    });
    take
}

/// The instruction for `action`.
pub(super) fn words(action: &StandAction<'_>) -> String {
    let direction = |way: f64| if way < 0.0 { "counterclockwise" } else { "clockwise" };
    match *action {
        StandAction::Power(true) => "Switch the supply on".into(),
        StandAction::Power(false) => "Switch the supply off".into(),
        StandAction::Link(true) => "Plug the bus cable in".into(),
        StandAction::Link(false) => "Pull the bus cable".into(),
        StandAction::ShaftSpeed(0.0) => "Stop the shaft".into(),
        StandAction::ShaftSpeed(rpm) => format!("Turn the shaft at {} rpm {}", rpm.abs(), direction(rpm)),
        StandAction::ShaftRamp { rpm, acceleration } => format!(
            "Bring the shaft to {} rpm {}, faster or slower by {acceleration} rpm each second",
            rpm.abs(),
            direction(rpm)
        ),
        StandAction::ShaftCounts(place) => format!("Bring the shaft to step {place} from its physical zero"),
        StandAction::Turn { steps, rpm } => {
            format!("Turn the shaft {} by {} steps, at about {rpm} rpm", direction(steps), steps.abs())
        }
        StandAction::TurnRevolutions { revolutions, rpm } => {
            format!(
                "Turn the shaft {} by {} revolutions, at about {rpm} rpm",
                direction(revolutions),
                revolutions.abs()
            )
        }
        StandAction::Fault(name, true) => format!("Cause the fault {name}"),
        StandAction::Fault(name, false) => format!("Clear the fault {name}"),
        StandAction::Button(name, true) => format!("Press the button {name} and hold it"),
        StandAction::Button(name, false) => format!("Release the button {name}"),
        StandAction::Switch(name, position) => format!("Turn the switch {name} to {position}"),
        StandAction::SupplyVoltage(volts) => format!("Set the supply to {volts} V"),
        StandAction::Temperature(degrees) => format!("Bring the device to {degrees} degrees Celsius"),
        StandAction::ReplaceDevice => {
            "Replace the device by one in factory state, with the same name and address".into()
        }
        StandAction::RestoreFactoryState => {
            "Reset the device to factory state, with its factory name, if it had one".into()
        }
        StandAction::Skip(time) => format!("Let {} s pass for the device", time.as_secs_f64()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("", true)]
    #[case(" Done \r", true)]
    #[case("no", false)]
    #[case("what?", false)]
    fn an_answer_is_yes_or_no(#[case] line: &str, #[case] done: bool) {
        let (give, take) = channel();
        give.send(line.to_owned()).expect("it is taken");
        assert_eq!(answer(&take, "Press it", OPERATOR_TIMEOUT).is_ok(), done);
    }

    #[test]
    fn the_wait_for_the_operator_ends() {
        let (give, take) = channel::<String>();
        let late = answer(&take, "Press it", Duration::from_millis(1));
        assert!(matches!(late, Err(StandRefusal::Broken(why)) if why.contains("Press it")));
        drop(give);
        assert!(matches!(answer(&take, "Press it", OPERATOR_TIMEOUT), Err(StandRefusal::Broken(_))));
    }
}
