//! Web pages: requests pages, sends forms, and reads values from pages.

use super::unexpected;
use crate::trial::RunningTrial;
use crate::trial::access::AccessAnswer;
use crate::trial::step_error::{BoxedStepError, StepError};
use controllers::profinet_io::{ControllerOutcome, ControllerRequest, PageOutcome, Partner};
use expression::Value;
use judge::answer::{NegativeResponse, ReceivedReply};
use judge::page;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use suite::device::NameKind;
use suite::model::{AcyclicAccess, AnswerPart};
use wire::http;

/// The longest text of a page that can be saved, in characters.
const SAVED: usize = 2000;

impl<'a> RunningTrial<'a> {
    /// The request for a page, or for its form with these fields.
    pub(super) fn page_request(
        &self,
        index: usize,
        entered: Option<&[(usize, String)]>,
    ) -> Result<ControllerRequest, BoxedStepError> {
        let of = &self.world.manual.device.pages[index];
        let request = match entered {
            None => http::HttpRequest::get(&of.path),
            Some(entered) => {
                let fields = entered.iter().map(|(field, text)| (of.fields[*field].1.as_str(), text.as_str()));
                http::HttpRequest::post(&of.path, &fields.collect::<Vec<_>>())
            }
        };
        // A device without an IP address is requested at its last one, where no station may answer any more.
        let known = [self.station_ip.address, self.last_ip];
        let Some(ip) = known.into_iter().find(|ip| !ip.is_unspecified()) else {
            let what = "The IP address of the web server is unknown.";
            return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
        };
        Ok(ControllerRequest::Page { partner: Partner { mac: self.mac, ip }, request })
    }

    /// Reads values from pages; each page is requested once.
    pub(super) fn pages(&mut self, access: &'a AcyclicAccess) -> Result<AccessAnswer, BoxedStepError> {
        let mut pages: Vec<(usize, Option<String>)> = Vec::new();
        let mut whole = ReceivedReply::Accepted;
        let mut values = Vec::new();
        for item in &access.items {
            let Some(&NameKind::Page { page: index, value }) = self.kind(item.name) else { continue };
            if !pages.iter().any(|(known, _)| *known == index) {
                let outcome = self.ask(access.second, self.page_request(index, None)?)?;
                let ControllerOutcome::Page(outcome) = outcome else { return Err(unexpected(&outcome)) };
                let reply = reply(&outcome);
                pages.push((index, source(&outcome).filter(|_| reply == ReceivedReply::Accepted)));
                if reply != ReceivedReply::Accepted {
                    whole = reply;
                }
            }
            let place = &self.world.manual.device.pages[index].shows[value];
            let source = pages.iter().find(|(known, _)| *known == index).and_then(|(_, source)| source.as_deref());
            values.push(source.map_or(Value::Unknown, |source| page::value(source, place)));
        }
        Ok(AccessAnswer { replies: vec![(AnswerPart::Whole, whole)], values })
    }
}

/// The reply for a request to the web server, and the parts of the answer.
pub fn replies(outcome: &PageOutcome) -> (ReceivedReply, Vec<(AnswerPart, ReceivedReply)>) {
    let PageOutcome::Answer(response) = outcome else { return (reply(outcome), Vec::new()) };
    let source = source(outcome).unwrap_or_default();
    let text: String = page::text(&source).chars().take(SAVED).collect();
    let page = || ReceivedReply::Value(Value::text(source.as_str()));
    // An error page lacks nothing that the page must not contain.
    let lacking = if reply(outcome) == ReceivedReply::Accepted { page() } else { reply(outcome) };
    let parts = vec![
        (AnswerPart::Status, ReceivedReply::Value(Value::whole(response.status))),
        (AnswerPart::Contains, page()),
        (AnswerPart::Lacks, lacking),
        (AnswerPart::Text, ReceivedReply::Value(Value::text(text))),
    ];
    (reply(outcome), parts)
}

fn reply(outcome: &PageOutcome) -> ReceivedReply {
    match outcome {
        PageOutcome::Answer(response) if (200..300).contains(&response.status) => ReceivedReply::Accepted,
        PageOutcome::Answer(response) => ReceivedReply::Refused(NegativeResponse::Http(response.status)),
        PageOutcome::Unreadable(_) => ReceivedReply::Wrong(outcome.to_string()),
        PageOutcome::Refused | PageOutcome::NoAnswer(_) => ReceivedReply::Silent(outcome.to_string()),
    }
}

fn source(outcome: &PageOutcome) -> Option<String> {
    match outcome {
        PageOutcome::Answer(response) => Some(String::from_utf8_lossy(&response.body).into_owned()),
        _ => None,
    }
}
