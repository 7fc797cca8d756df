//! A trial from begin to end: proof of life, start, `given`, `steps`, `finally`, clean-up; and what it comes to.
//!
//! A step is a verb that acts ([`verbs`], [`settings`], [`access`]) or one that looks ([`looks`]); what went wrong is a
//! [`trouble`], which [`failure`] tells to people. What differs with the bus goes through [`driver`]. [`probe`] looks at a live
//! device before the first trial. This room must not know which buses there are, nor what becomes of a verdict.

pub mod access;
pub mod driver;
pub mod failure;
mod looks;
pub mod probe;
mod settings;
pub mod slave;
pub mod trouble;
mod verbs;

use crate::outputs;
use crate::place::Place;
use crate::world::World;
use controllers::profinet_io::StationSeen;
use driver::BusDriver;
use expression::NameId;
use judge::image::Image;
use judge::view::{BenchAddresses, StationNumbers};
use results::outcome::{Blame, Failure};
use results::verdict::Verdict;
use slave::SlaveAt;
use station::Duration;
use std::net::Ipv4Addr;
use suite::device::{EventName, NameKind, StandName};
use suite::model::{Step, Trial, Verb};
use trouble::{Done, Trouble, halted};
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

/// Good samples that prove that a device lives.
const LIVING_SAMPLES: u64 = 3;

/// A check with requirements of its own.
pub struct Check {
    /// The requirements.
    pub covers: Vec<usize>,
    /// What it came to.
    pub verdict: Verdict,
    /// The failure, where it is one.
    pub failure: Option<Failure>,
}

/// A trial at work.
pub struct Run<'a> {
    /// What differs with the bus.
    pub driver: &'static dyn BusDriver,
    /// Everything that can be seen.
    pub world: World<'a>,
    /// The trial.
    pub trial: &'a Trial,
    /// Where the device is found.
    pub place: &'a Place,
    /// The address of the device.
    pub mac: Mac,
    /// What the device said it is.
    pub identity: Option<StationSeen>,
    /// Where a slave of PROFIBUS is, and what it said.
    pub slave: SlaveAt,
    /// Whether the trial may have changed the station name.
    pub renamed: bool,
    /// The address that the device was last given.
    pub station_ip: IpParameter,
    /// The last address that it had.
    pub last_ip: Ipv4Addr,
    /// The module in use.
    pub module: Option<usize>,
    /// Whether cyclic frames are paused.
    pub paused: bool,
    /// The last reference of a parameter request.
    pub reference: u8,
    /// What was known at the last sample before the last action.
    pub before_action: Option<Image>,
    /// Whether the trial has done something that may end the connection since it was made, or asks for its end now.
    pub may_end: bool,
    /// Whether a reading of the manual is being tried: it begins no action of its own.
    pub in_reading: bool,
    /// Whether the test itself runs, not what goes before and after it.
    pub in_test: bool,
    /// Checks with requirements of their own.
    pub checked: Vec<Check>,
    /// Readings that the device took.
    pub readings: Vec<(String, String)>,
    /// Readings that are faults, in which the device was found, with the sentence about it.
    pub findings: Vec<(String, String)>,
    /// How many checks were judged.
    pub checks: u64,
    /// Steps not reached, for the report.
    pub not_reached: Vec<String>,
    /// The extra time that deadlines get on a live bench.
    pub slack: Duration,
    /// Stand names that were set and have to go back.
    pub touched: Vec<StandName>,
    /// By how many revolutions per minute each second the shaft reaches a speed; 0: at once.
    pub acceleration: f64,
    /// What does not change the verdict.
    pub notes: Vec<String>,
}

impl<'a> Run<'a> {
    /// A trial that has not begun, on the bus of `driver`.
    pub fn new(driver: &'static dyn BusDriver, mut world: World<'a>, trial: &'a Trial, place: &'a Place) -> Run<'a> {
        let notebook = world.scene.notebook_mut();
        notebook.bench = Some(BenchAddresses {
            controller: place.controllers[0].1,
            device: place.ip.address,
            mask: place.ip.mask,
            free: place.free_ip,
            stations: StationNumbers {
                device: place.line.station,
                master: place.line.masters[0],
                second: place.line.masters[1],
                free: place.line.free,
            },
        });
        notebook.noise = place.noise;
        notebook.slack = place.slack;
        if let Some(sent) = world.ours.outputs_mut() {
            outputs::declare(&world.manual.device, sent);
        }
        Run {
            driver,
            mac: place.mac.unwrap_or_default(),
            identity: None,
            slave: SlaveAt::new(place.line.station),
            renamed: false,
            station_ip: place.ip,
            last_ip: place.ip.address,
            module: None,
            paused: false,
            reference: 0,
            before_action: None,
            may_end: false,
            in_reading: false,
            in_test: false,
            checked: Vec::new(),
            readings: Vec::new(),
            findings: Vec::new(),
            checks: 0,
            not_reached: Vec::new(),
            slack: place.slack,
            touched: Vec::new(),
            acceleration: 0.0,
            notes: Vec::new(),
            world,
            trial,
            place,
        }
    }

    /// What a name is.
    pub fn kind(&self, name: NameId) -> Option<&'a NameKind> {
        self.world.variant.names.get(name.0 as usize)
    }

    /// The place of the variant among those of the device.
    pub fn variant_number(&self) -> usize {
        let name = &self.world.variant.name;
        self.world.manual.device.variants.iter().position(|known| known == name).unwrap_or_default()
    }

    /// Runs the trial; the failure that decided, if there is one.
    pub fn run(&mut self) -> Option<(Verdict, Failure)> {
        let trial = self.trial;
        if let Err(trouble) = self.prove_life() {
            // Whoever this is, or nobody: it is left alone.
            let verdict = trouble.verdict.unwrap_or(Verdict::Inconclusive);
            return Some((verdict, failure::failure(self, None, trouble, &[])));
        }
        let decided = self.test().err().map(|(trouble, step)| {
            let verdict = trouble.verdict.unwrap_or(Verdict::Fail);
            (verdict, failure::failure(self, step, trouble, &[]))
        });
        let decided = decided.map(|decided| self.not_ours(decided));
        self.world.closing = true;
        let finally = self.steps(&trial.how().finally).map_err(|(trouble, step)| (trouble, Some(step)));
        let cleaned = self.clean_up().map_err(|trouble| (trouble, None));
        let cleaned = finally.and(cleaned);
        // A trial that was not applicable on its way says nothing; a device that is not there any more does.
        let decided = decided.filter(|(verdict, _)| *verdict != Verdict::NotApplicable || cleaned.is_ok());
        let decided = decided.or_else(|| {
            let (trouble, step) = cleaned.err()?;
            Some((Verdict::Inconclusive, failure::failure(self, step, trouble.before_the_test(), &[])))
        });
        decided.or_else(|| self.unexpected()).or_else(|| self.disturbed())
    }

    /// A trial in which everything was right says nothing all the same if the line broke or frames were lost in it, or were
    /// never sent: no answer to those is no answer.
    fn disturbed(&mut self) -> Option<(Verdict, Failure)> {
        self.world.segment.look_at_line();
        let why = self.world.halted().or_else(|| self.world.segment.withheld())?;
        Some((Verdict::Inconclusive, failure::failure(self, None, halted(&why), &[])))
    }

    /// Why nothing can be said about the device, whatever was seen: the line, the end of the run, or ourselves.
    pub fn not_the_device(&self) -> Option<String> {
        let (late, slack) = (self.world.segment.lateness(), self.slack);
        let too_late = || {
            (late > slack)
                .then(|| format!("the harness itself was {late:?} late, more than the {slack:?} that are allowed"))
        };
        let held_back =
            || self.world.segment.objections().into_iter().next().filter(|_| !self.world.segment.is_model());
        let answer = self.world.segment.latest_answer();
        let answered_late = || {
            (answer > slack).then(|| {
                format!(
                    "an answer came {answer:?} after its request, more than the {slack:?} that are allowed, and this link does \
                     not tell a slow device from a slow line"
                )
            })
        };
        self.world.halted().or_else(held_back).or_else(too_late).or_else(answered_late)
    }

    /// A failure of the device, unless the line broke, the run was interrupted or we were late ourselves: then nothing can be
    /// said about it. Where a precondition broke for that reason it is told as well.
    fn not_ours(&mut self, decided: (Verdict, Failure)) -> (Verdict, Failure) {
        let (verdict, mut failure) = decided;
        if !matches!(verdict, Verdict::Fail | Verdict::Inconclusive) {
            return (verdict, failure);
        }
        match self.not_the_device() {
            Some(why) if verdict == Verdict::Fail => {
                failure.what = format!("Nothing can be said, because {why}. What was seen: {}", failure.what);
                failure.blame = Blame::Environment;
                (Verdict::Inconclusive, failure)
            }
            Some(why) if !failure.what.contains(&why) => {
                failure.what = format!("{} Besides, {why}.", failure.what);
                (verdict, failure)
            }
            _ => (verdict, failure),
        }
    }

    fn test(&mut self) -> Result<(), (Trouble, Option<&'a Step>)> {
        let trial = self.trial;
        if let Some(start) = trial.start() {
            self.start(start).map_err(|trouble| (trouble.before_the_test(), None))?;
        }
        self.steps(&trial.how().given).map_err(|(trouble, step)| (trouble.before_the_test(), Some(step)))?;
        self.in_test = true;
        let tested = self.steps(&trial.how().steps).map_err(|(trouble, step)| (trouble, Some(step)));
        self.in_test = false;
        tested
    }

    /// The device answers and is what the bench claims; anything else says nothing about it.
    fn prove_life(&mut self) -> Done {
        self.world.note("who is there?");
        self.driver.prove_life(self)
    }

    /// How long the device may be away after a trial that restarted it.
    pub fn patience(&self) -> Duration {
        let timing = &self.world.manual.device.timing;
        timing.power_up.max(timing.start)
    }

    fn start(&mut self, start: &'a suite::model::Start) -> Done {
        self.world.note("start");
        self.connect(start, None, false, None)?;
        let until = self.world.now() + self.world.watchdog * 5;
        let lives = self.world.run(until, |world| world.samples >= LIVING_SAMPLES || world.lost.is_some());
        if lives && self.world.lost.is_none() {
            return Ok(());
        }
        let what = "The device sends no good data although the connection stands.";
        Err(Trouble::other(Blame::Device, Verdict::Inconclusive, what))
    }

    /// Leaves the bench as it was found, and makes sure that the device still lives: one that died after the last check
    /// proves nothing.
    fn clean_up(&mut self) -> Done {
        self.world.note("clean-up");
        if self.paused {
            self.pause(false);
            self.paused = false;
        }
        self.driver.undo_settings(self);
        if !self.world.segment.is_model() {
            self.outputs_to_zero();
        }
        let is_read_at_power_on = |name: &StandName| matches!(name, StandName::Switch(_) | StandName::Fault(_));
        let has_read = self.touched.contains(&StandName::Delivery)
            || self.touched.contains(&StandName::Power) && self.touched.iter().any(is_read_at_power_on);
        let parts = [
            self.disconnect(true),
            self.disconnect(false),
            self.put_stand_back(),
            self.driver.still_lives(self),
            self.driver.put_station_back(self, has_read),
        ];
        parts.into_iter().collect()
    }

    /// A machine may hang on the device: it is left with all outputs 0.
    fn outputs_to_zero(&mut self) {
        if let Some(sent) = self.world.ours.outputs_mut() {
            sent.reset();
        }
        if self.world.ours.exchanges(0) {
            // Where it cannot be sent any more the connection is gone, and the device takes zero by itself.
            let _ = self.cycles(2);
        }
    }

    /// The firmware that the device names in I&M0, for the report and the ledger of known failures.
    pub fn firmware(&mut self) -> Option<String> {
        if !self.driver.names_firmware() {
            return None;
        }
        self.prove_life().ok()?;
        self.start(self.trial.start()?).ok()?;
        self.driver.firmware(self)
    }

    /// On a model an alarm that nobody expected, or a frame that cannot be read, fails the trial; on a live bench, where more
    /// may be going on, it is noted.
    fn unexpected(&mut self) -> Option<(Verdict, Failure)> {
        self.world.act();
        if !self.world.segment.is_model() {
            let alarms = self.world.unexpected.iter();
            self.notes.extend(alarms.map(|(what, frame)| format!("no step expected {what} (frame {frame})")));
            // What others send is not the device's; what is no frame at all on PROFIBUS has made the trial inconclusive already.
            let trace = &self.world.trace;
            let from_device =
                |number: u64| trace.get(number as usize).is_some_and(|of| self.driver.is_from_device(self, of.octets));
            let (why, frame) = self.world.unreadable.iter().find(|(_, frame)| from_device(*frame))?.clone();
            let trouble = Trouble::device(format!("A frame cannot be read: {why}."), Vec::new()).at(frame);
            let failure = failure::failure(self, None, trouble, &[]);
            return Some(self.not_ours((Verdict::Fail, failure)));
        }
        if let Some(what) = self.world.segment.out_of_turn().into_iter().next() {
            let trouble = Trouble::device(format!("The device sent out of turn: {what}."), Vec::new());
            return Some((Verdict::Fail, failure::failure(self, None, trouble, &[])));
        }
        let (what, frame) = match (self.world.unexpected.first(), self.world.unreadable.first()) {
            (Some((what, frame)), _) => (format!("The device sent {what}, which no step expected."), *frame),
            (_, Some((why, frame))) => (format!("A frame cannot be read: {why}."), *frame),
            _ => return None,
        };
        let failure = failure::failure(self, None, Trouble::device(what, Vec::new()).at(frame), &[]);
        Some((Verdict::Fail, failure))
    }

    /// Does the steps in order; the first that fails ends them, except for independent checks.
    pub fn steps(&mut self, steps: &'a [Step]) -> Result<(), (Trouble, &'a Step)> {
        for (index, step) in steps.iter().enumerate() {
            let outcome = self.step(step).and_then(|()| {
                let asked_for = self.asks_for_the_end(&steps[index + 1..]);
                self.may_end |= asked_for && self.world.lost.is_some();
                self.lost_connection().map_or(Ok(()), |lost| Err((lost, step)))
            });
            if let Err(trouble) = outcome {
                self.not_reached.extend(steps.iter().skip(index + 1).map(|step| step.text.clone()));
                return Err(trouble);
            }
        }
        Ok(())
    }

    fn step(&mut self, step: &'a Step) -> Result<(), (Trouble, &'a Step)> {
        self.world.note(&format!("line {}: {}", step.at.line, step.text));
        if let Some(why) = self.excluded(step) {
            let what = format!("The check is not applicable: {why}.");
            let trouble = Trouble::other(Blame::Environment, Verdict::NotApplicable, what);
            let failure = failure::failure(self, Some(step), trouble, &step.covers);
            let covers = step.covers.clone();
            self.checked.push(Check { covers, verdict: Verdict::NotApplicable, failure: Some(failure) });
            return Ok(());
        }
        let may_end = self.may_end;
        self.may_end |= self.asks_for_the_end(std::slice::from_ref(step));
        let outcome = self.verb(step);
        let lost = if outcome.is_err() { self.lost_connection() } else { None };
        // What a step asked for is over with it, unless the end came; what it did may still end the connection.
        if self.world.lost.is_none() && !may_end && self.asks_for_the_end(std::slice::from_ref(step)) {
            self.may_end = false;
        }
        let outcome = match (outcome, lost) {
            (Err((trouble, step)), Some(lost)) if trouble.verdict == Some(Verdict::Inconclusive) => {
                let mut lost = lost;
                lost.parts.clone_from(&trouble.parts);
                Err((lost, step))
            }
            (outcome, _) => outcome,
        };
        if step.covers.is_empty() || (!self.in_test && outcome.is_err()) {
            return outcome;
        }
        let (verdict, failure) = match outcome {
            Ok(()) => (Verdict::Pass, None),
            Err((trouble, at)) => {
                let verdict = trouble.verdict.unwrap_or(Verdict::Fail);
                let failure = failure::failure(self, Some(at), trouble, &step.covers);
                let (verdict, failure) = self.not_ours((verdict, failure));
                (verdict, Some(failure))
            }
        };
        self.checked.push(Check { covers: step.covers.clone(), verdict, failure });
        Ok(())
    }

    /// Why a check that is judged for itself cannot be served by a live bench.
    fn excluded(&self, step: &Step) -> Option<String> {
        let bench = self.place.bench.as_ref().filter(|_| !step.covers.is_empty())?;
        let needs = crate::needs::of_step(self.world.manual, self.world.variant, step);
        crate::needs::missing(&needs, bench, true, u32::MAX)
    }

    /// Whether the next expectation among `steps`, before another connection, asks for the end of this one.
    fn asks_for_the_end(&self, steps: &[Step]) -> bool {
        let is_end = |name: &NameId| {
            let kind = self.kind(*name);
            matches!(kind, Some(NameKind::Connection | NameKind::Event(EventName::Abort | EventName::AbortCode)))
        };
        for step in steps {
            match &step.verb {
                Verb::Connect { .. } | Verb::Disconnect { .. } => return false,
                Verb::Expect { .. } | Verb::Block { .. } | Verb::Either(_) => {
                    return crate::scan::names(std::slice::from_ref(step)).iter().any(is_end);
                }
                _ => {}
            }
        }
        false
    }

    /// The device ended the connection where nothing in the trial expected it.
    fn lost_connection(&mut self) -> Option<Trouble> {
        let lost = self.world.lost?;
        if self.may_end {
            return None;
        }
        self.world.lost = None;
        Some(Trouble::device(failure::lost(&lost), Vec::new()).at(lost.tick.frame))
    }
}
