//! The complete table of phases and events.

use crate::profinet::phase::{ArPhase, StartUpEvent};
use alloc::format;
use alloc::string::String;

#[test]
fn every_phase_with_every_event() {
    use ArPhase::{Access, Announcing, Data, Parameters, Preparing, Waiting};
    use StartUpEvent::{ApplicationReady, OutputsCame, ParametersEnded, ReadyConfirmed};
    let mut table = String::new();
    for phase in [Parameters, Preparing, Announcing, Waiting, Data, Access] {
        for event in [ParametersEnded, ApplicationReady, ReadyConfirmed, OutputsCame] {
            let next = phase.after(event).map_or(String::from("-"), |next| format!("{next:?}"));
            table += &format!("{phase:?} {event:?} {next}\n");
        }
    }
    let expected = "\
Parameters ParametersEnded Preparing
Parameters ApplicationReady -
Parameters ReadyConfirmed -
Parameters OutputsCame Parameters
Preparing ParametersEnded -
Preparing ApplicationReady Announcing
Preparing ReadyConfirmed -
Preparing OutputsCame Preparing
Announcing ParametersEnded -
Announcing ApplicationReady -
Announcing ReadyConfirmed Waiting
Announcing OutputsCame Announcing
Waiting ParametersEnded -
Waiting ApplicationReady -
Waiting ReadyConfirmed -
Waiting OutputsCame Data
Data ParametersEnded -
Data ApplicationReady -
Data ReadyConfirmed -
Data OutputsCame Data
Access ParametersEnded -
Access ApplicationReady -
Access ReadyConfirmed -
Access OutputsCame -
";
    assert_eq!(table, expected);
}
