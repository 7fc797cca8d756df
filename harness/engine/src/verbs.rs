//! The verbs that act: set, exchange, connect, write, read, send, wait, save; those that look are in [`super::looks`].

use super::access::{Answered, unexpected};
use super::looks::NO_SAMPLE;
use super::ours::Ours;
use super::startup;
use super::station::dcp;
use super::trial::{Done, IDENTIFY, Run, Trouble};
use controllers::profinet_io::{Broken, Ended, IdentifyBy, Outcome, Request, Reset, Target};
use expression::{Program, State, Value};
use judge::Truth;
use judge::answer::{self, Reply};
use judge::condition;
use judge::rule::length;
use results::bench_file::BenchFile;
use results::outcome::{Blame, PartSeen};
use results::verdict::Verdict;
use station::{Duration, StandAction};
use std::net::Ipv4Addr;
use std::sync::Arc;
use suite::device::{Bus, NameId, NameKind};
use suite::model::{Access, Answer, AnswerPart, ExchangeEntry, Matcher, Service, Sought, Span, Start, Step, Verb};
use wire::profinet::status::{AbortReason, ErrorCode};

/// The longest that a request may take before it counts as a mistake of ours: every wait of the controller is shorter.
const LONGEST_REQUEST: Duration = Duration::from_secs(120);
/// How long answers to an ARP request are collected.
const ARP_WAIT: Duration = Duration::from_millis(500);
/// The time between two reads of a `read` with `within`.
const REPEAT: Duration = Duration::from_millis(20);

/// How a step went, with the step (one inside it, perhaps) that did not.
pub type Stepped<'a> = Result<(), (Trouble, &'a Step)>;

impl<'a> Run<'a> {
    /// Does what a step says.
    pub fn verb(&mut self, step: &'a Step) -> Stepped<'a> {
        let done = match &step.verb {
            Verb::Set(settings) => self.set(settings),
            Verb::Turn(turn) => self.turn(turn),
            Verb::Exchange(entries) => self.exchange(entries),
            Verb::Connect { start, answer, second, to } => self.connect(start, answer.as_ref(), *second, to.as_ref()),
            Verb::Disconnect { second } => self.disconnect(*second),
            Verb::Write(access) => self.write(access),
            Verb::Read { access, within } => self.read(access, within.as_ref()),
            Verb::Send { service: Service::Dp(service), answer, second, to } => {
                self.serve(service, answer.as_ref(), *second, to.as_ref())
            }
            Verb::Send { service: Service::Broken(word), to, second, .. } if self.world.ours.master(0).is_some() => {
                self.broken_frame(word, *second, to.as_ref())
            }
            Verb::Send { service, answer, second, to: _ } => self.send(service, answer.as_ref(), *second),
            Verb::Expect { condition, within, hold } => self.expect(condition, within, hold),
            Verb::Wait(span) => self.wait(span),
            Verb::Save(values) => self.save(values),
            Verb::Block { steps, times, observe } => return self.block(step, steps, *times, observe),
            Verb::Either(readings) => return self.either(step, readings),
        };
        done.map_err(|trouble| (trouble, step))
    }

    /// Sends a request and waits for its outcome.
    pub fn ask(&mut self, second: bool, request: Request) -> Result<Outcome, Trouble> {
        let which = usize::from(second);
        let now = self.world.now();
        let begin = |ours: &mut Ours| {
            let controller = ours.controller_mut(which).ok_or("There is no second controller on this bench.")?;
            controller.request(now, request).map_err(|why| format!("Our controller cannot: {why}."))
        };
        self.request(begin, |ours| ours.controller_mut(which)?.take_outcome())
    }

    /// Begins a request of one of our stations and waits until it has an outcome.
    pub fn request<O>(
        &mut self,
        begin: impl FnOnce(&mut Ours) -> Result<(), String>,
        take: impl Fn(&mut Ours) -> Option<O>,
    ) -> Result<O, Trouble> {
        let now = self.world.now();
        let busy = |why: String| Trouble::other(Blame::Harness, Verdict::Error, why);
        if let Some(why) = self.world.halted().filter(|_| !self.world.closing) {
            return Err(halted(&why));
        }
        begin(&mut self.world.ours).map_err(busy)?;
        let mut outcome = None;
        self.world.run(now + LONGEST_REQUEST, |world| {
            outcome = take(&mut world.ours);
            outcome.is_some()
        });
        outcome.ok_or_else(|| match self.world.halted() {
            Some(why) => halted(&why),
            None => busy("Our controller did not come to an end with a request.".into()),
        })
    }

    /// Sends a request that goes through a connection; where none stands nothing was sent, and nothing can be an answer.
    pub fn ask_in_connection(&mut self, second: bool, request: Request) -> Result<Outcome, Trouble> {
        let is_inside = !matches!(request, Request::ReadImplicit { .. });
        if is_inside && !self.world.ours.is_connected(usize::from(second)) {
            return Err(no_connection());
        }
        self.ask(second, request)
    }

    /// Begins an action: what is expected afterwards is told apart from what was true before.
    pub fn action(&mut self) {
        if self.in_reading {
            return;
        }
        self.before_action = self.world.last_sample.is_some().then(|| self.world.scene.follower.image.clone());
        self.world.act();
    }

    fn turn(&mut self, turn: &'a suite::model::Turn) -> Done {
        self.action();
        self.turn_shaft(turn)
    }

    fn exchange(&mut self, entries: &'a [ExchangeEntry]) -> Done {
        self.action();
        for entry in entries {
            let times = entry.times.eval(&self.world.view(), &State::default()).as_whole();
            let Some(times) = times.and_then(|times| u64::try_from(times).ok()) else {
                return Err(Trouble::other(Blame::Suite, Verdict::Error, "The number of cycles is not known."));
            };
            if times == 0 {
                continue;
            }
            self.apply_settings(&entry.set)?;
            match &entry.expect {
                None => self.cycles(times)?,
                Some(condition) => self.judged_cycles(condition, times)?,
            }
        }
        Ok(())
    }

    /// Waits until so many cyclic frames have left, the last one seen on the wire.
    pub fn cycles(&mut self, count: u64) -> Done {
        if self.world.ours.master(0).is_some() {
            return self.whole_cycles(count);
        }
        let Some(cycle) = self.world.scene.follower.image.cycle() else {
            return Err(no_connection());
        };
        let target = self.world.ours.cycles_begun() + count;
        let until = self.world.now() + cycle * u32::try_from(count.saturating_mul(4) + 100).unwrap_or(u32::MAX);
        let mut left = None;
        let done = self.world.run(until, |world| {
            if world.ours.cycles_done() >= target {
                // On a real wire our frames are seen as they leave, on the virtual one as they arrive.
                if !world.segment.is_model() {
                    return true;
                }
                let seen = *left.get_or_insert(world.outputs_seen);
                return world.outputs_seen > seen || world.lost.is_some();
            }
            world.lost.is_some() || !world.ours.is_connected(0)
        });
        if done && self.world.lost.is_none() { Ok(()) } else { Err(no_connection()) }
    }

    /// Makes a connection, in the place of the own one.
    pub fn connect(
        &mut self,
        start: &'a Start,
        answer: Option<&'a Answer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> Done {
        if !second {
            self.disconnect(false)?;
        }
        self.action();
        if self.world.manual.device.bus == Bus::Profibus {
            return self.parameterise(start, answer, second, to);
        }
        let device = &self.world.manual.device;
        let whereabouts = self.whereabouts();
        let (connection, records) = startup::connection(device, self.variant_number(), start, &whereabouts);
        if !second {
            self.module = Some(start.module);
            self.apply_outputs();
        }
        let outcome = self.ask(second, Request::Connect(Box::new(connection)))?;
        let Outcome::StartUp(outcome) = outcome else { return Err(unexpected(&outcome)) };
        self.world.scene.notebook_mut().answers =
            startup::replies(&self.world.manual.device, start, &outcome, &records);
        let mut replies = outcome.records.iter().map(|outcome| startup::record(outcome, true));
        let refused = replies.find(|reply| *reply != Reply::Accepted);
        let refused = refused.map(|reply| format!("A start-up record was not taken: {reply}."));
        let stands = match (outcome.standing, outcome.failed) {
            (true, _) => Ok(refused),
            (false, failed) => Err(failed.map(|failed| failed.to_string())),
        };
        self.started(stands, answer, second)
    }

    /// What follows a start-up on either bus: the first data of the own connection are awaited, then `answer` is judged. Without
    /// one the connection has to stand and nothing may be refused; `stands` says what was, or why it does not stand.
    pub(super) fn started(
        &mut self,
        stands: Result<Option<String>, Option<String>>,
        answer: Option<&'a Answer>,
        second: bool,
    ) -> Done {
        if !second {
            self.may_end = false;
        }
        if stands.is_ok() && !second {
            let until = self.world.now() + NO_SAMPLE;
            self.world.run(until, |world| world.samples > 0 || world.lost.is_some());
        }
        let what = match (answer, stands) {
            (Some(answer), _) => return self.judge_answer(answer),
            (None, Ok(None)) => return Ok(()),
            (None, Ok(Some(refused))) => refused,
            (None, Err(why)) => {
                format!("The connection did not come about: {}.", why.as_deref().unwrap_or("it ended"))
            }
        };
        Err(Trouble::device(what, Vec::new()))
    }

    /// Ends the own connection, if there is one.
    pub fn disconnect(&mut self, second: bool) -> Done {
        let which = usize::from(second);
        if !self.world.ours.is_connected(which) {
            return Ok(());
        }
        self.action();
        if self.world.ours.master(which).is_some() {
            return self.release(second);
        }
        match self.ask(second, Request::Release)? {
            Outcome::Ended(Ended::Released(outcome)) => {
                let reply = startup::control(&outcome, ErrorCode::RELEASE_RESPONSE);
                self.world.scene.notebook_mut().answers = vec![(AnswerPart::Whole, reply)];
                Ok(())
            }
            Outcome::Ended(Ended::Aborted | Ended::NoAr) => Ok(()),
            outcome => Err(unexpected(&outcome)),
        }
    }

    pub fn judge_answer(&mut self, answer: &Answer) -> Done {
        self.checks += 1;
        let parts = answer::judge(answer, &self.world.scene.notebook().answers, &self.world.view());
        if parts.iter().all(|part| part.held) {
            return Ok(());
        }
        Err(Trouble::device("The answer is not the one that is right.", parts).at(self.world.trace.len() as u64))
    }

    fn write(&mut self, access: &'a Access) -> Done {
        self.action();
        let answered = self.access(access, true)?;
        self.world.scene.notebook_mut().answers = answered.replies;
        self.judge_answer(access.answer.as_ref().unwrap_or(&Answer::Accepted))
    }

    fn read(&mut self, access: &'a Access, within: Option<&'a Span>) -> Done {
        self.action();
        let began = self.world.now();
        let deadline = match within {
            Some(within) => Some(began + self.length(within)? + self.slack),
            None => None,
        };
        loop {
            let answered = self.access(access, false)?;
            let parts = self.read_parts(access, answered);
            if parts.iter().all(|part| part.held) {
                self.checks += 1;
                return Ok(());
            }
            let again = self.world.now() + REPEAT;
            if deadline.is_none_or(|deadline| again > deadline) {
                self.checks += 1;
                let what = match deadline {
                    Some(_) => "The right answer did not come in time.",
                    None => "The answer is not the one that is right.",
                };
                return Err(Trouble::device(what, parts).at(self.world.trace.len() as u64));
            }
            self.world.run(again, |_| false);
        }
    }

    /// Takes in what was read and compares each name with what is right.
    fn read_parts(&mut self, access: &Access, answered: Answered) -> Vec<PartSeen> {
        let notebook = self.world.scene.notebook_mut();
        for (item, value) in access.items.iter().zip(&answered.values) {
            notebook.read.retain(|(name, _)| *name != item.name);
            if !value.is_unknown() {
                notebook.read.push((item.name, value.clone()));
            }
        }
        notebook.answers = answered.replies;
        let view = self.world.view();
        let replies = &self.world.scene.notebook().answers;
        let whole = replies.iter().find(|(part, _)| *part == AnswerPart::Whole).map(|(_, reply)| reply);
        let part = |(item, value): (&suite::model::AccessItem, &Value)| {
            let own = match view.variant.names.get(item.name.0 as usize) {
                Some(NameKind::Parameter { number, subindex, .. }) => {
                    let part = AnswerPart::Parameter(*number, *subindex);
                    replies.iter().find(|(known, _)| *known == part).map(|(_, reply)| reply)
                }
                _ => None,
            };
            let reply = own.or(whole);
            let (held, seen) = match (&item.value, reply) {
                (Matcher::Refused(codes), Some(reply)) => (answer::refuses(reply, codes), reply.to_string()),
                (matcher, Some(Reply::Accepted)) => {
                    (condition::matches(matcher, value, &view) == Truth::True, view.show(item.name, value))
                }
                (_, reply) => (false, reply.map_or_else(|| "nothing".to_owned(), Reply::to_string)),
            };
            PartSeen {
                text: view.name(item.name),
                wanted: condition::wanted_of(&item.value, item.name, &view),
                seen,
                held,
            }
        };
        access.items.iter().zip(&answered.values).map(part).collect()
    }

    fn send(&mut self, service: &'a Service, answer: Option<&'a Answer>, second: bool) -> Done {
        self.action();
        let to = self.mac;
        let request = match service {
            Service::DcpReset { suboption: 5, .. } => Request::DcpReset { to, reset: Reset::Factory },
            Service::DcpReset { qualifier, .. } => {
                Request::DcpReset { to, reset: Reset::ToFactory { qualifier: *qualifier } }
            }
            Service::DcpSignal => Request::DcpSignal { to },
            Service::DcpIdentify(sought) => {
                let by = match sought {
                    Sought::All => IdentifyBy::All,
                    Sought::OwnName => IdentifyBy::Name(self.place.name.clone().into_bytes()),
                    Sought::Name(name) => IdentifyBy::Name(name.clone().into_bytes()),
                    Sought::Alias(alias) => IdentifyBy::Alias(alias.clone().into_bytes()),
                };
                let wait = if by == IdentifyBy::All { IDENTIFY } else { Duration::from_secs(1) };
                Request::Identify { by, wait }
            }
            Service::RecordRead { slot, subslot, index, length } => {
                self.record_read(second, self.target(*slot, *subslot, *index), *length)
            }
            Service::RecordWrite { slot, subslot, index, bytes } => {
                Request::Write { target: self.target(*slot, *subslot, *index), data: bytes.clone() }
            }
            Service::Lldp { chassis, port } => {
                Request::Lldp { chassis: chassis.clone().into_bytes(), port: port.clone().into_bytes() }
            }
            Service::Arp { ip, probe } => {
                let target = match ip.as_ref().map(|ip| ip.eval(&self.world.view(), &State::default())) {
                    None => self.station_ip.address,
                    Some(Value::Address(octets)) => Ipv4Addr::from(octets),
                    Some(_) => {
                        return Err(Trouble::other(
                            Blame::Suite,
                            Verdict::Error,
                            "The address to be asked for is not known.",
                        ));
                    }
                };
                Request::Arp { target, probe: *probe, wait: ARP_WAIT }
            }
            Service::Abort => Request::Abort { code: AbortReason::RELEASE_RECEIVED },
            Service::Broken(word) => {
                let broken = Broken::TABLE.iter().find(|(_, known, _)| known == word).map(|(broken, ..)| *broken);
                let Some(broken) = broken else {
                    return Err(Trouble::other(
                        Blame::Suite,
                        Verdict::Error,
                        format!("There is no broken frame {word}."),
                    ));
                };
                Request::Broken { broken, partner: None }
            }
            Service::Dp(_) => return Err(other_bus()),
            Service::HttpGet { page } => self.page_request(*page, None)?,
            Service::HttpPost { page, fields } => self.page_request(*page, Some(fields))?,
        };
        self.may_end |= matches!(service, Service::DcpReset { .. } | Service::Abort | Service::Broken(_));
        self.renamed |= match service {
            Service::DcpReset { .. } => true,
            // A device that does not see the damage takes the name.
            Service::Broken(word) => word.starts_with("dcp") && !self.world.segment.is_model(),
            _ => false,
        };
        let before = self.world.trace.len();
        let outcome = match service {
            Service::RecordRead { .. } | Service::RecordWrite { .. } => self.ask_in_connection(second, request)?,
            _ => self.ask(second, request)?,
        };
        if let Outcome::Broken(broken) = &outcome {
            // On a real wire it was seen already, on the virtual one it is still on its way.
            match self.world.segment.is_model() {
                true => self.world.expect_broken(broken),
                false => self.world.mark_broken(before, |frame| frame.starts_with(broken) || broken.starts_with(frame)),
            }
        }
        let is_refused = !matches!(answer, None | Some(Answer::Accepted));
        if is_refused && matches!(service, Service::RecordWrite { .. }) {
            self.world.mark_broken(before, super::access::is_request);
        }
        let mut replies = Vec::new();
        let whole = match &outcome {
            Outcome::Dcp(outcome) => dcp(outcome),
            Outcome::Stations(stations) if stations.iter().any(|station| station.mac == to) => Reply::Accepted,
            Outcome::Owners(owners) if owners.contains(&to) => Reply::Accepted,
            Outcome::Owners(_) => Reply::Silent("the device did not answer".into()),
            Outcome::Stations(_) => Reply::Silent("the device did not answer".into()),
            Outcome::Record(outcome) => {
                if let controllers::profinet_io::RecordOutcome::Accepted { data } = outcome {
                    replies.push((AnswerPart::Bytes, Reply::Value(Value::bytes(data.as_slice()))));
                }
                startup::record(outcome, matches!(service, Service::RecordWrite { .. }))
            }
            Outcome::Page(outcome) => {
                let (whole, parts) = super::web::replies(outcome);
                replies.extend(parts);
                whole
            }
            // Nobody answers these, so that they say nothing about the device.
            Outcome::Sent | Outcome::Ended(_) | Outcome::Broken(_) => return Ok(()),
            outcome => return Err(unexpected(outcome)),
        };
        replies.push((AnswerPart::Whole, whole));
        self.world.scene.notebook_mut().answers = replies;
        self.judge_answer(answer.unwrap_or(&Answer::Accepted))
    }

    fn target(&self, slot: u16, subslot: u16, index: u16) -> Target {
        let submodules = &self.world.manual.device.submodules;
        let known = submodules.iter().find(|submodule| (submodule.slot, submodule.subslot) == (slot, subslot));
        Target { api: known.map_or(0, |submodule| submodule.api), slot, subslot, index }
    }

    /// A span as time; one that cannot be known is a mistake of the suite.
    pub fn length(&self, span: &Span) -> Result<Duration, Trouble> {
        let unknown = || Trouble::other(Blame::Suite, Verdict::Error, "The length is not known.");
        length(span, &self.world.view()).ok_or_else(unknown)
    }

    fn wait(&mut self, span: &'a Span) -> Done {
        match span {
            Span::Cycles(cycles) => self.cycles(*cycles),
            span => {
                let length = self.length(span)?;
                if self.can_skip(length) {
                    return self.act_on_stand(&StandAction::Skip(length));
                }
                let until = self.world.now() + length;
                self.world.run(until, |_| false);
                Ok(())
            }
        }
    }

    /// Whether the stand lets a long time go by for the device at once; while a connection stands the time is ours, too.
    fn can_skip(&self, length: Duration) -> bool {
        let serves = |bench: &Arc<BenchFile>| bench.stand.serves("clock");
        length >= super::needs::LONG
            && self.place.bench.as_ref().is_some_and(serves)
            && !self.world.ours.is_connected(0)
    }

    fn save(&mut self, values: &'a [(NameId, expression::Program)]) -> Done {
        for (name, program) in values {
            let value = program.eval(&self.world.view(), &State::default());
            if value.is_unknown() {
                let what = format!("{} is not known, so it cannot be saved.", program.text());
                return Err(Trouble::device(what, Vec::new()));
            }
            if let Some(NameKind::Saved(index)) = self.kind(*name) {
                let saved = &mut self.world.scene.notebook_mut().saved;
                if saved.len() <= *index {
                    saved.resize(index + 1, Value::Unknown);
                }
                saved[*index] = value;
            }
        }
        Ok(())
    }
}

/// The trouble with a step that the end of the run or of the line came upon.
pub fn halted(why: &str) -> Trouble {
    Trouble::other(Blame::Environment, Verdict::Inconclusive, format!("The trial could not go on: {why}."))
}

/// The trouble with a step that needs a connection where none stands.
pub fn no_connection() -> Trouble {
    Trouble::device("No connection stands, so nothing can be exchanged or asked for.", Vec::new())
}

/// A suite for one bus asks for something of the other; the loader does not let it through.
pub(super) fn other_bus() -> Trouble {
    Trouble::other(Blame::Suite, Verdict::Error, "This is a service of the other bus.")
}
