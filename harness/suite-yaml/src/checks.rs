//! Whether the steps of a case check anything, and more than a dead device can show.

use super::answer::dead_gives;
use suite::model::{
    AcyclicService, AnswerMatcher, BlockObservation, Condition, DpService, Matcher, PartTest, RuleBody, TrialStep, Verb,
};

/// Whether `test` holds for a step or one inside it.
pub(super) fn any_step(steps: &[TrialStep], test: &dyn Fn(&TrialStep) -> bool) -> bool {
    steps.iter().any(|step| {
        test(step)
            || match &step.verb {
                Verb::Block { steps, .. } => any_step(steps, test),
                Verb::Either(readings) => readings.iter().any(|reading| any_step(&reading.steps, test)),
                _ => false,
            }
    })
}

/// Whether a step contains a check that can fail the trial.
pub(super) fn is_check(step: &TrialStep) -> bool {
    match &step.verb {
        Verb::Expect { .. } | Verb::Read { .. } => true,
        Verb::Send { service, answer, .. } => is_answered(service, answer.as_ref()),
        Verb::Write(access) => access.answer.is_some(),
        Verb::Connect { answer, .. } => answer.is_some(),
        Verb::Block { observe, .. } => !observe.is_empty(),
        Verb::Exchange(entries) => entries.iter().any(|entry| entry.expect.is_some()),
        _ => false,
    }
}

/// Whether a check among the steps is judged for what the case itself covers; one with requirements of its own is not, nor
/// what is inside it.
///
/// That a service of `send` is carried out counts as a check of the case only where its answer is named.
pub(super) fn any_check_of_the_case(steps: &[TrialStep]) -> bool {
    let judged = |step: &&TrialStep| step.covers.is_empty();
    steps.iter().filter(judged).any(|step| match &step.verb {
        Verb::Block { steps, observe, .. } => !observe.is_empty() || any_check_of_the_case(steps),
        Verb::Either(readings) => readings.iter().any(|reading| any_check_of_the_case(&reading.steps)),
        Verb::Send { answer: None, .. } => false,
        _ => is_check(step),
    })
}

/// Whether a step requires something that a dead or absent device does not do.
pub(super) fn wants_life(step: &TrialStep) -> bool {
    let answered = |answer: &Option<AnswerMatcher>| answer.as_ref().is_none_or(|answer| !dead_gives(answer));
    match &step.verb {
        Verb::Expect { condition, .. } => !gone(condition),
        Verb::Read { .. } => true,
        Verb::Write(access) => answered(&access.answer),
        Verb::Send { service, answer, .. } => is_answered(service, answer.as_ref()) && answered(answer),
        Verb::Connect { answer, .. } => answered(answer),
        Verb::Exchange(entries) => entries.iter().filter_map(|entry| entry.expect.as_ref()).any(|of| !gone(of)),
        Verb::Block { observe, .. } => observe.iter().any(|rule| match rule {
            BlockObservation::Rule { body: RuleBody::Always(condition), .. } => !gone(condition),
            BlockObservation::Rule { .. } | BlockObservation::Count { .. } => false,
            BlockObservation::Sequence { .. } => true,
        }),
        _ => false,
    }
}

/// Whether a service has an answer; one without an answer says nothing about the device. What comes after a damaged frame is judged
/// only where the suite says what is right.
fn is_answered(service: &AcyclicService, answer: Option<&AnswerMatcher>) -> bool {
    match service {
        AcyclicService::Broken(_) => answer.is_some(),
        AcyclicService::Load { .. }
        | AcyclicService::Lldp { .. }
        | AcyclicService::Abort
        | AcyclicService::Dp(DpService::GlobalControl { .. }) => false,
        AcyclicService::DcpReset { .. }
        | AcyclicService::DcpSignal
        | AcyclicService::DcpIdentify(_)
        | AcyclicService::Arp { .. }
        | AcyclicService::RecordRead { .. }
        | AcyclicService::RecordWrite { .. }
        | AcyclicService::RecordsWrite(_)
        | AcyclicService::DcpGet { .. }
        | AcyclicService::DcpSet { .. }
        | AcyclicService::Rpc(_)
        | AcyclicService::Snmp(_)
        | AcyclicService::Ping(_)
        | AcyclicService::Dp(_)
        | AcyclicService::HttpGet { .. }
        | AcyclicService::HttpPost { .. } => true,
    }
}

/// `connection: none` alone.
fn gone(condition: &Condition) -> bool {
    condition.parts.iter().all(|part| match &part.test {
        PartTest::Name(_, Matcher::Equal(_)) => part.text.replace(' ', "") == "connection:none",
        PartTest::Expression(program) => program.text().replace(' ', "") == "connection==none",
        PartTest::Name(..) => false,
    })
}
