//! Web pages: a page is asked for, a form is sent, and values are taken out of pages.

use super::unexpected;
use crate::trial::Run;
use crate::trial::access::Answered;
use crate::trial::trouble::Trouble;
use controllers::profinet_io::{Outcome, PageOutcome, Partner, Request};
use expression::Value;
use judge::answer::{Refusal, Reply};
use judge::page;
use results::outcome::Blame;
use results::verdict::Verdict;
use suite::device::NameKind;
use suite::model::{Access, AnswerPart};
use wire::http;

/// Most characters of a page that can be saved.
const SAVED: usize = 2000;

impl<'a> Run<'a> {
    /// The request for a page, or with its form filled in.
    pub(super) fn page_request(&self, index: usize, entered: Option<&[(usize, String)]>) -> Result<Request, Trouble> {
        let of = &self.world.manual.device.pages[index];
        let request = match entered {
            None => http::Request::get(&of.path),
            Some(entered) => {
                let fields = entered.iter().map(|(field, text)| (of.fields[*field].1.as_str(), text.as_str()));
                http::Request::post(&of.path, &fields.collect::<Vec<_>>())
            }
        };
        // One without an address is asked where it was last: there nobody may answer any more.
        let known = [self.station_ip.address, self.last_ip];
        let Some(ip) = known.into_iter().find(|ip| !ip.is_unspecified()) else {
            let what = "There is no address at which the web server could be asked.";
            return Err(Trouble::other(Blame::Environment, Verdict::Inconclusive, what));
        };
        Ok(Request::Page { partner: Partner { mac: self.mac, ip }, request })
    }

    /// Reads values from pages; each page is asked for once.
    pub(super) fn pages(&mut self, access: &'a Access) -> Result<Answered, Trouble> {
        let mut asked: Vec<(usize, Option<String>)> = Vec::new();
        let mut whole = Reply::Accepted;
        let mut values = Vec::new();
        for item in &access.items {
            let Some(&NameKind::Page { page: index, value }) = self.kind(item.name) else { continue };
            if !asked.iter().any(|(known, _)| *known == index) {
                let outcome = self.ask(access.second, self.page_request(index, None)?)?;
                let Outcome::Page(outcome) = outcome else { return Err(unexpected(&outcome)) };
                let reply = reply(&outcome);
                asked.push((index, source(&outcome).filter(|_| reply == Reply::Accepted)));
                if reply != Reply::Accepted {
                    whole = reply;
                }
            }
            let shown = &self.world.manual.device.pages[index].shows[value];
            let source = asked.iter().find(|(known, _)| *known == index).and_then(|(_, source)| source.as_deref());
            values.push(source.map_or(Value::Unknown, |source| page::value(source, shown)));
        }
        Ok(Answered { replies: vec![(AnswerPart::Whole, whole)], values })
    }
}

/// What a visit to the web server came to, and the parts of the answer.
pub fn replies(outcome: &PageOutcome) -> (Reply, Vec<(AnswerPart, Reply)>) {
    let PageOutcome::Answer(response) = outcome else { return (reply(outcome), Vec::new()) };
    let source = source(outcome).unwrap_or_default();
    let text: String = page::text(&source).chars().take(SAVED).collect();
    let page = || Reply::Value(Value::text(source.as_str()));
    // An error page lacks what the page would have.
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
