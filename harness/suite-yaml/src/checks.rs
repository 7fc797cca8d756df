//! Whether the steps of a case look at anything, and at more than a dead device can show.

use super::answer::dead_gives;
use suite::model::{Answer, Condition, DpService, Matcher, Observation, RuleBody, Service, Step, Test, Verb};

/// Whether `test` holds for a step or one inside it.
pub(super) fn any_step(steps: &[Step], test: &dyn Fn(&Step) -> bool) -> bool {
    steps.iter().any(|step| {
        test(step)
            || match &step.verb {
                Verb::Block { steps, .. } => any_step(steps, test),
                Verb::Either(readings) => readings.iter().any(|reading| any_step(&reading.steps, test)),
                _ => false,
            }
    })
}

/// Whether a step can fail the trial by what it looks at.
pub(super) fn is_check(step: &Step) -> bool {
    match &step.verb {
        Verb::Expect { .. } | Verb::Read { .. } => true,
        Verb::Send { service, .. } => is_answered(service),
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
/// That a service of `send` is carried out is asked for by the way, and is a check of the case only where its answer is named.
pub(super) fn any_check_of_the_case(steps: &[Step]) -> bool {
    let judged = |step: &&Step| step.covers.is_empty();
    steps.iter().filter(judged).any(|step| match &step.verb {
        Verb::Block { steps, observe, .. } => !observe.is_empty() || any_check_of_the_case(steps),
        Verb::Either(readings) => readings.iter().any(|reading| any_check_of_the_case(&reading.steps)),
        Verb::Send { answer: None, .. } => false,
        _ => is_check(step),
    })
}

/// Whether a step asks for something that a device that is dead or absent does not do.
pub(super) fn wants_life(step: &Step) -> bool {
    let answered = |answer: &Option<Answer>| answer.as_ref().is_none_or(|answer| !dead_gives(answer));
    match &step.verb {
        Verb::Expect { condition, .. } => !gone(condition),
        Verb::Read { .. } => true,
        Verb::Write(access) => answered(&access.answer),
        Verb::Send { service, answer, .. } => is_answered(service) && answered(answer),
        Verb::Connect { answer, .. } => answered(answer),
        Verb::Exchange(entries) => entries.iter().filter_map(|entry| entry.expect.as_ref()).any(|of| !gone(of)),
        Verb::Block { observe, .. } => observe.iter().any(|rule| match rule {
            Observation::Rule { body: RuleBody::Always(condition), .. } => !gone(condition),
            Observation::Rule { .. } | Observation::Count { .. } => false,
            Observation::Sequence { .. } => true,
        }),
        _ => false,
    }
}

/// Whether anybody answers a service; one that nobody answers says nothing about the device.
fn is_answered(service: &Service) -> bool {
    match service {
        Service::Lldp { .. } | Service::Abort | Service::Broken(_) | Service::Dp(DpService::GlobalControl { .. }) => {
            false
        }
        Service::DcpReset { .. }
        | Service::DcpSignal
        | Service::DcpIdentify(_)
        | Service::Arp { .. }
        | Service::RecordRead { .. }
        | Service::RecordWrite { .. }
        | Service::Dp(_)
        | Service::HttpGet { .. }
        | Service::HttpPost { .. } => true,
    }
}

/// `connection: none` alone.
fn gone(condition: &Condition) -> bool {
    condition.parts.iter().all(|part| match &part.test {
        Test::Name(_, Matcher::Equal(_)) => part.text.replace(' ', "") == "connection:none",
        Test::Expression(program) => program.text().replace(' ', "") == "connection==none",
        Test::Name(..) => false,
    })
}
