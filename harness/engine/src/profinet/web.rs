//! Web pages: requests pages, sends forms, and reads values from pages.

use super::unexpected;
use crate::trial::Run;
use crate::trial::access::Answered;
use crate::trial::trouble::{Facts, Trouble};
use controllers::profinet_io::{Outcome, PageOutcome, Partner, Request};
use expression::Value;
use judge::answer::{Refusal, Reply};
use judge::page;
use results::outcome::Blame;
use results::verdict::Verdict;
use suite::device::NameKind;
use suite::model::{Access, AnswerPart};
use wire::http;

/// The longest text of a page that can be saved, in characters.
const SAVED: usize = 2000;

impl<'a> Run<'a> {
    /// The request for a page, or for its form with these fields.
    pub(super) fn page_request(&self, index: usize, entered: Option<&[(usize, String)]>) -> Result<Request, Trouble> {
        let of = &self.world.manual.device.pages[index];
        let request = match entered {
            None => http::Request::get(&of.path),
            Some(entered) => {
                let fields = entered.iter().map(|(field, text)| (of.fields[*field].1.as_str(), text.as_str()));
                http::Request::post(&of.path, &fields.collect::<Vec<_>>())
            }
        };
        // A device without an IP address is requested at its last one, where no station may answer any more.
        let known = [self.station_ip.address, self.last_ip];
        let Some(ip) = known.into_iter().find(|ip| !ip.is_unspecified()) else {
            let what = "The IP address of the web server is unknown.";
            return Err(Facts::other(Blame::Environment, Verdict::Inconclusive, what));
        };
        Ok(Request::Page { partner: Partner { mac: self.mac, ip }, request })
    }

    /// Reads values from pages; each page is requested once.
    pub(super) fn pages(&mut self, access: &'a Access) -> Result<Answered, Trouble> {
        let mut pages: Vec<(usize, Option<String>)> = Vec::new();
        let mut whole = Reply::Accepted;
        let mut values = Vec::new();
        for item in &access.items {
            let Some(&NameKind::Page { page: index, value }) = self.kind(item.name) else { continue };
            if !pages.iter().any(|(known, _)| *known == index) {
                let outcome = self.ask(access.second, self.page_request(index, None)?)?;
                let Outcome::Page(outcome) = outcome else { return Err(unexpected(&outcome)) };
                let reply = reply(&outcome);
                pages.push((index, source(&outcome).filter(|_| reply == Reply::Accepted)));
                if reply != Reply::Accepted {
                    whole = reply;
                }
            }
            let place = &self.world.manual.device.pages[index].shows[value];
            let source = pages.iter().find(|(known, _)| *known == index).and_then(|(_, source)| source.as_deref());
            values.push(source.map_or(Value::Unknown, |source| page::value(source, place)));
        }
        Ok(Answered { replies: vec![(AnswerPart::Whole, whole)], values })
    }
}

/// The reply for a request to the web server, and the parts of the answer.
pub fn replies(outcome: &PageOutcome) -> (Reply, Vec<(AnswerPart, Reply)>) {
    let PageOutcome::Answer(response) = outcome else { return (reply(outcome), Vec::new()) };
    let source = source(outcome).unwrap_or_default();
    let text: String = page::text(&source).chars().take(SAVED).collect();
    let page = || Reply::Value(Value::text(source.as_str()));
    // An error page lacks nothing that the page must not contain.
    let lacking = if reply(outcome) == Reply::Accepted { page() } else { reply(outcome) };
    let parts = vec![
        (AnswerPart::Status, Reply::Value(Value::whole(response.status))),
        (AnswerPart::Contains, page()),
        (AnswerPart::Lacks, lacking),
        (AnswerPart::Text, Reply::Value(Value::text(text))),
    ];
    (reply(outcome), parts)
}

fn reply(outcome: &PageOutcome) -> Reply {
    match outcome {
        PageOutcome::Answer(response) if (200..300).contains(&response.status) => Reply::Accepted,
        PageOutcome::Answer(response) => Reply::Refused(Refusal::Http(response.status)),
        PageOutcome::Unreadable(_) => Reply::Wrong(outcome.to_string()),
        PageOutcome::Refused | PageOutcome::NoAnswer(_) => Reply::Silent(outcome.to_string()),
    }
}

fn source(outcome: &PageOutcome) -> Option<String> {
    match outcome {
        PageOutcome::Answer(response) => Some(String::from_utf8_lossy(&response.body).into_owned()),
        _ => None,
    }
}
