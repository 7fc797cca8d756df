//! The world of one trial: the segment, the observations on it, and all rules and expectations that judge them.

use super::outcome::Disturbance;
use super::segment::Segment;
use super::stations::{HarnessStations, sender};
use super::step_log::StepLog;
use judge::follow::{ConnectionChange, Ending};
use judge::observe::{Address, ArId, BusTracker, Observation, ObservedAr};
use judge::observed_state::ObservedState;
use judge::rule_set::RuleSet;
use judge::view::NameView;
use judge::{JudgeTick, TickKind};
use station::{Duration, Time};
use suite::device::{DeviceDescription, NameKind};
use suite::model::{Manual, SuiteVariant};
use virtual_wire::Trace;

use super::block::BlockWatch;
use super::expect::Expectation;
use judge::image::{ConnectionImage, CurrentEvent};

/// The comment of a frame that a trial damages on purpose.
const BROKEN: &str = "broken on purpose";

/// Typical number of frames and of bytes in a trial.
const USUAL: (usize, usize) = (512, 32 * 1024);

/// The watchdog of connections that give none.
const USUAL_WATCHDOG: Duration = Duration::from_secs(1);
/// The shortest watchdog that holds use.
const SHORTEST_WATCHDOG: Duration = Duration::from_millis(1);

/// How long the LEDs are not queried while the device is not touched; they may also change with time alone.
const LOOK: Duration = Duration::from_millis(1);

/// An event on the trial's connection, kept for expectations of later steps.
pub struct ConnectionEvent {
    /// Time and frame.
    pub tick: JudgeTick,
    /// The data at that instant.
    pub image: ConnectionImage,
    /// Whether it has satisfied an expectation; each event satisfies one.
    pub used: bool,
    /// Whether a rule over the block used it, so that it is not unexpected.
    pub counted: bool,
}

/// The end of the trial's connection that the harness did not request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LostConnection {
    /// Time and frame.
    pub tick: JudgeTick,
    pub ending: Ending,
}

/// All rules and expectations that judge the observations.
pub struct TrialJudges<'a> {
    /// The rules of the suite.
    pub rules: RuleSet<'a>,
    /// The rules over the running blocks, the innermost last.
    pub blocks: Vec<BlockWatch<'a>>,
    /// The expectation of the present step.
    pub expecting: Option<Expectation<'a>>,
}

/// The world of one trial.
pub struct TrialWorld<'a> {
    pub manual: &'a Manual,
    /// The variant of the device under test.
    pub variant: &'a SuiteVariant,
    /// The wire, the device and the stand.
    pub segment: Box<dyn Segment + 'a>,
    /// The stations of the harness, first and second.
    pub stations: HarnessStations,
    /// Their addresses, in the same order.
    pub addresses: Vec<Address>,
    /// All frames so far.
    pub trace: Trace,
    /// The state of the trial's connection and all other known values.
    pub scene: ObservedState<'a>,
    /// The rules and expectations.
    pub judges: TrialJudges<'a>,
    /// The events since the last action.
    pub events: Vec<ConnectionEvent>,
    /// The index of the one that satisfied the last expectation that waited for an event.
    pub expected_event: Option<usize>,
    /// The last observation on the trial's connection.
    pub last: Option<JudgeTick>,
    /// The last sample of the trial's connection.
    pub last_sample: Option<JudgeTick>,
    /// Number of consecutive good samples on the trial's connection.
    pub samples: u64,
    /// Number of output frames on the trial's connection.
    pub output_frames: u64,
    /// The end of the trial's connection, if the harness did not request it.
    pub lost: Option<LostConnection>,
    /// Events that no step expects: text and frame.
    pub unexpected: Vec<(String, u64)>,
    /// Unreadable frames: sentence and frame.
    pub unreadable: Vec<(String, u64)>,
    /// How long a hold may last without samples.
    pub watchdog: Duration,
    /// The cycle time if the frames do not contain it (PROFIBUS).
    pub cycle: Option<Duration>,
    /// Whether the trial itself switched off the line or the power, so that the line may break.
    pub line_may_break: bool,
    /// Whether the trial is releasing the device, which it does however it ended.
    pub closing: bool,
    /// `None` only while a frame is processed.
    tracker: Option<BusTracker>,
    /// The LEDs that the suite uses, and the last word of each.
    leds: Vec<(usize, Option<&'static str>)>,
    /// The time of their last query.
    led_query: Time,
    comment: Option<String>,
    damaged: Vec<Vec<u8>>,
    recording: Option<Box<StepRecording>>,
    /// The record of what the device does in each step, of a trial that is not judged.
    pub log: Option<Box<StepLog>>,
    /// The time of a virtual wire, which advances only in a step; `None` on a live wire.
    virtual_clock: Option<Time>,
    /// Whether the device is a model, whose wire never breaks.
    is_model: bool,
}

/// The observations from the begin of a step on.
struct StepRecording {
    began: Time,
    /// The state at the begin.
    before: ObservedMoment,
    kept: Vec<ObservedMoment>,
}

/// The state at one tick.
struct ObservedMoment {
    tick: JudgeTick,
    image: ConnectionImage,
    leds: Vec<Option<i64>>,
}

/// The origin of a tick.
#[derive(Clone, Copy, PartialEq, Eq)]
enum TickSource {
    /// A frame: all rules and expectations receive it.
    Wire,
    /// The stand: the rules of the suite do not receive it, so that they work the same on a capture.
    Stand,
}

impl<'a> TrialWorld<'a> {
    /// A world before the first frame.
    pub fn new(
        manual: &'a Manual,
        variant: &'a SuiteVariant,
        segment: Box<dyn Segment + 'a>,
        stations: HarnessStations,
    ) -> TrialWorld<'a> {
        let device: &DeviceDescription = &manual.device;
        let watchdog = USUAL_WATCHDOG;
        let mut scene = ObservedState::new(manual, variant);
        scene.notebook_mut().leds = vec![None; device.stand.leds.len()];
        let leds = |name: &NameKind| match name {
            NameKind::Led(led) => Some((*led, None)),
            _ => None,
        };
        let tracker = BusTracker::of_harness(device.bus.kind());
        TrialWorld {
            manual,
            variant,
            virtual_clock: segment.is_virtual().then(|| segment.now()),
            is_model: segment.is_model(),
            segment,
            addresses: stations.addresses(),
            stations,
            trace: Trace::with_room(USUAL.0, USUAL.1),
            scene,
            judges: TrialJudges { rules: RuleSet::new(&variant.rules, watchdog), blocks: Vec::new(), expecting: None },
            events: Vec::new(),
            expected_event: None,
            last: None,
            last_sample: None,
            samples: 0,
            output_frames: 0,
            lost: None,
            unexpected: Vec::new(),
            unreadable: Vec::new(),
            watchdog,
            cycle: None,
            line_may_break: false,
            closing: false,
            tracker: Some(tracker),
            leds: variant.names.iter().filter_map(leds).collect(),
            led_query: Time::ZERO,
            comment: None,
            damaged: Vec::new(),
            recording: None,
            log: None,
        }
    }

    /// Records what the device does in each step, all LEDs included.
    pub fn record_steps(&mut self) {
        self.leds = (0..self.manual.device.stand.leds.len()).map(|led| (led, None)).collect();
        self.log = Some(Box::new(StepLog::new(&self.manual.device)));
    }

    /// Queries only these LEDs: a query costs more than a frame.
    pub fn use_leds(&mut self, named: &[usize]) {
        self.leds.retain(|(led, _)| named.contains(led));
    }

    /// The time of the segment's clock.
    #[inline]
    pub fn now(&self) -> Time {
        self.virtual_clock.unwrap_or_else(|| self.segment.now())
    }

    /// The values of all names at this instant.
    pub fn view(&self) -> NameView<'_> {
        let tick = JudgeTick { time: self.now(), frame: self.trace.len() as u64, kind: TickKind::Event };
        self.view_at(self.last.map_or(tick, |last| JudgeTick { time: tick.time, ..last }))
    }

    /// The values of all names, with the time of `tick`.
    pub fn view_at(&self, tick: JudgeTick) -> NameView<'_> {
        self.scene.view(tick)
    }

    /// Adds `text` as a comment to the next frame of the capture.
    pub fn note(&mut self, text: &str) {
        self.comment = Some(match self.comment.take() {
            Some(before) => format!("{before}\n{text}"),
            None => text.to_owned(),
        });
    }

    /// Marks the harness's own requests since frame `before` as wrong on purpose, for readers of the capture.
    pub fn mark_broken(&mut self, before: usize, is_it: impl Fn(&[u8]) -> bool) {
        let is_own = |frame: &[u8]| self.is_own_frame(frame);
        let marked: Vec<usize> = (before + 1..=self.trace.len())
            .filter(|&number| self.trace.get(number).is_some_and(|frame| is_own(frame.octets) && is_it(frame.octets)))
            .collect();
        for number in marked {
            self.trace.comment(number, BROKEN);
        }
    }

    /// Marks a frame of the harness since frame `before` as wrong on purpose, even if its damage hides who sent it.
    pub fn mark_damaged(&mut self, before: usize, octets: &[u8]) {
        for number in before + 1..=self.trace.len() {
            if self.trace.get(number).is_some_and(|frame| frame.octets == octets) {
                self.trace.comment(number, BROKEN);
                self.unreadable.retain(|(_, at)| *at != number as u64);
            }
        }
    }

    /// Whether the sender of a frame is one of the harness's stations.
    pub fn is_own_frame(&self, frame: &[u8]) -> bool {
        self.addresses.iter().any(|&own| sender(frame, own) == Some(own))
    }

    /// Marks a frame as wrong on purpose when it is observed.
    pub fn expect_broken(&mut self, frame: &[u8]) {
        self.damaged.push(frame.to_vec());
    }

    /// One line for each of these consecutive frames of the trace.
    pub fn describe(&self, numbers: std::ops::RangeInclusive<usize>) -> Vec<String> {
        let frames = numbers.filter_map(|number| Some(self.trace.get(number)?.octets));
        self.tracker.as_ref().map_or_else(Vec::new, |tracker| tracker.describe(frames))
    }

    /// Why the trial cannot continue: the user has requested the end of the run, or the line broke.
    #[inline]
    pub fn stop_reason(&self) -> Option<String> {
        self.stop().map(|stop| stop.why)
    }

    /// The same, with what a repetition would help against.
    pub fn stop(&self) -> Option<Disturbance> {
        if self.is_model { None } else { self.line_stop() }
    }

    fn line_stop(&self) -> Option<Disturbance> {
        if let Some(stop) = self.segment.invalidated() {
            return Some(stop);
        }
        match self.segment.broken_line() {
            _ if self.segment.is_interrupted() => Some(Disturbance::lasting("the run was interrupted")),
            Some(why) if !self.line_may_break => Some(Disturbance::lasting(why)),
            _ => None,
        }
    }

    /// Runs until `done` returns true, but not beyond `until`; returns whether it was done.
    ///
    /// It returns at once if the trial cannot continue, unless the trial is releasing the device.
    pub fn run(&mut self, until: Time, mut done: impl FnMut(&mut TrialWorld<'a>) -> bool) -> bool {
        loop {
            if done(self) {
                return true;
            }
            if !self.closing && self.stop_reason().is_some() {
                return false;
            }
            if self.now() >= until && !self.step(until) {
                return done(self);
            }
            if self.now() < until {
                self.step(until);
            }
        }
    }

    /// The connections that were observed.
    pub fn ars(&self) -> &[ObservedAr] {
        self.tracker.as_ref().map_or(&[], BusTracker::ars)
    }

    /// Processes the next event, not later than `until`; returns false if there is none until then.
    pub fn step(&mut self, until: Time) -> bool {
        let TrialWorld { segment, stations: ours, trace, comment, .. } = self;
        let before = trace.len();
        let worked = segment.step(ours, until, &mut |time, frame| {
            let number = trace.push(time, 0, frame);
            if let Some(text) = comment.take() {
                trace.comment(number, &text);
            }
        });
        if let Some(clock) = &mut self.virtual_clock {
            *clock = self.segment.now();
        }
        if self.trace.len() > before {
            self.process_frames_after(before);
        }
        if self.segment.take_touch() || !worked || self.now() >= self.led_query + LOOK {
            self.query_leds();
        }
        self.advance_time();
        worked
    }

    /// Processes the frames of the trace after number `before`.
    fn process_frames_after(&mut self, before: usize) {
        let mut trace = std::mem::take(&mut self.trace);
        for number in before + 1..=trace.len() {
            // A short frame arrives padded.
            let is_sent = |broken: &Vec<u8>| trace.get(number).is_some_and(|frame| frame.octets.starts_with(broken));
            if let Some(at) = self.damaged.iter().position(is_sent) {
                self.damaged.swap_remove(at);
                trace.comment(number, BROKEN);
            }
            if let Some(frame) = trace.get(number) {
                self.process_frame(number as u64, frame.time, frame.octets);
            }
        }
        self.trace = trace;
    }

    fn process_frame(&mut self, number: u64, time: Time, octets: &[u8]) {
        self.judges.rules.time(&self.scene.view_at(time, number), time);
        let Some(mut tracker) = self.tracker.take() else { return };
        let own = self.addresses.first().copied();
        tracker.frame(number, time, octets, &mut |ars, observation| {
            // Frames damaged by the harness are no fault of the device.
            if let Observation::Unreadable { why } = &observation
                && !self.is_own_frame(octets)
            {
                self.unreadable.push(((*why).to_owned(), number));
            }
            let ours = |ar: &ObservedAr| Some(ar.controller.address) == own;
            let (at, device) = ((time, number), self.scene.device);
            match self.scene.follower.observe(device, ars, ours, at, &observation) {
                Some(ConnectionChange::Opened) => self.opened(ars, self.scene.follower.ar()),
                Some(ConnectionChange::Tick(tick)) => self.tick(tick, TickSource::Wire),
                Some(ConnectionChange::Closed(tick, ending)) => {
                    self.tick(tick, TickSource::Wire);
                    self.closed(tick, ending);
                }
                None => {}
            }
        });
        self.tracker = Some(tracker);
    }

    fn opened(&mut self, ars: &[ObservedAr], ar: Option<ArId>) {
        self.samples = 0;
        self.output_frames = 0;
        self.last_sample = None;
        self.lost = None;
        if let Some(ar) = ar.and_then(|ar| ars.get(ar.0 as usize)) {
            self.watchdog = match (ar.slave.is_some(), ar.inputs.watchdog.is_zero()) {
                (true, true) => USUAL_WATCHDOG,
                _ => ar.inputs.watchdog.max(SHORTEST_WATCHDOG),
            };
        }
        if let Some(cycle) = self.cycle {
            self.scene.follower.image.set_cycle(cycle);
        }
        self.judges.rules.cut();
        self.judges.blocks.iter_mut().for_each(BlockWatch::cut);
    }

    fn closed(&mut self, tick: JudgeTick, ending: Ending) {
        self.judges.rules.cut();
        self.judges.blocks.iter_mut().for_each(BlockWatch::cut);
        if ending != Ending::Released {
            self.lost = Some(LostConnection { tick, ending });
        }
    }

    /// Processes a frame or an event of the trial's connection, or a change of the stand.
    fn tick(&mut self, tick: JudgeTick, from: TickSource) {
        let happens = tick.kind == TickKind::Event && self.scene.follower.image.happening != CurrentEvent::Nothing;
        match tick.kind {
            TickKind::Sample => {
                self.samples += 1;
                self.last_sample = Some(tick);
            }
            TickKind::BadSample => self.samples = 0,
            TickKind::Output => self.output_frames += 1,
            TickKind::Event => {}
        }
        self.last = Some(tick);
        if let Some(mut recording) = self.recording.take() {
            recording.kept.push(self.moment(tick));
            self.recording = Some(recording);
        }
        if let Some(log) = &mut self.log {
            log.tick(&self.scene, tick);
        }
        let view = self.scene.view(tick);
        // Rules are judged on connections; LLDP announcements and diagnoses also come without one.
        let is_beside = matches!(
            self.scene.follower.image.happening,
            CurrentEvent::Lldp(_) | CurrentEvent::Hello(_) | CurrentEvent::Diagnosis
        );
        if from == TickSource::Wire && (self.scene.follower.ar().is_some() || !is_beside) {
            self.judges.rules.tick(&view, None);
        }
        let counted = self.judges.blocks.iter_mut().fold(false, |counted, block| block.tick(&view) | counted);
        let expected = self.judges.expecting.as_mut();
        let used = expected.is_some_and(|expecting| expecting.tick(&view) && expecting.uses_events());
        if happens {
            if used {
                self.expected_event = Some(self.events.len());
            }
            self.events.push(ConnectionEvent { tick, image: self.scene.follower.image.clone(), used, counted });
        }
        self.scene.end_of(tick);
    }

    fn moment(&self, tick: JudgeTick) -> ObservedMoment {
        ObservedMoment { tick, image: self.scene.follower.image.clone(), leds: self.scene.notebook().leds.clone() }
    }

    /// Evaluates the present expectation at this instant without an observation: answers and the connection itself may be expected.
    /// Rules do not receive it, since nothing happened.
    pub fn evaluate_now(&mut self) {
        let tick = JudgeTick { time: self.now(), frame: self.trace.len() as u64, kind: TickKind::Event };
        let view = self.scene.view(tick);
        if let Some(expecting) = &mut self.judges.expecting {
            expecting.tick(&view);
        }
    }

    /// Evaluates the present expectation on the state of the stand, as a sample. Rules do not receive it, since nothing was sent.
    pub fn evaluate_stand(&mut self) {
        let tick = JudgeTick { time: self.now(), frame: self.trace.len() as u64, kind: TickKind::Sample };
        let view = self.scene.view(tick);
        if let Some(expecting) = &mut self.judges.expecting {
            expecting.tick(&view);
        }
    }

    /// Keeps all observations from now on, for readings of the manual that are tried one after the other.
    pub fn record_from_here(&mut self) {
        let began = self.now();
        let before = self.moment(self.view().tick);
        self.recording = Some(Box::new(StepRecording { began, before, kept: Vec::new() }));
    }

    /// Drops the kept observations.
    pub fn stop_recording(&mut self) {
        self.recording = None;
    }

    /// The time at which the recording began.
    pub fn recording_began(&self) -> Time {
        self.recording.as_ref().map_or(self.now(), |recording| recording.began)
    }

    /// Replays the recording to an expectation, beginning with the state before it.
    pub fn replay_recording(&self, expectation: &mut Expectation<'_>) {
        let Some(StepRecording { before, kept, .. }) = self.recording.as_deref() else { return };
        let mut notebook = self.scene.notebook().clone();
        let mut show = |moment: &ObservedMoment, look: &mut dyn FnMut(&NameView<'_>)| {
            notebook.leds.clone_from(&moment.leds);
            look(&NameView { image: &moment.image, notebook: &notebook, ..self.view_at(moment.tick) });
        };
        show(before, &mut |view| expectation.begin_with(view));
        for moment in kept {
            show(moment, &mut |view| {
                expectation.tick(view);
            });
        }
    }

    fn query_leds(&mut self) {
        let now = self.now();
        self.led_query = now;
        let mut changed = false;
        let stand = self.segment.stand();
        for (led, before) in &mut self.leds {
            let led = *led;
            let (name, words) = &self.manual.device.stand.leds[led];
            let word = stand.led(now, name);
            let is_as_before = match (word, std::mem::replace(before, word)) {
                // Nearly always it is the same word.
                (Some(word), Some(before)) => std::ptr::eq(word, before) || word == before,
                (word, before) => word == before,
            };
            if is_as_before {
                continue;
            }
            let number = word.and_then(|word| words.iter().position(|known| known == word)).map(|index| index as i64);
            if self.scene.notebook().leds[led] != number {
                self.scene.notebook_mut().leds[led] = number;
                changed = true;
            }
        }
        if changed {
            self.tick(
                JudgeTick { time: now, frame: self.trace.len() as u64, kind: TickKind::Event },
                TickSource::Stand,
            );
        }
    }

    fn advance_time(&mut self) {
        if self.judges.blocks.is_empty() && self.judges.expecting.is_none() {
            return;
        }
        let now = self.now();
        let view = self.scene.view_at(now, self.trace.len() as u64);
        self.judges.blocks.iter_mut().for_each(|block| block.time(&view, now));
        if let Some(expecting) = &mut self.judges.expecting {
            expecting.time(&view, now);
        }
    }

    /// Begins an action: events before it do not count for the expectations after it; alarms that no step expected are kept as
    /// unexpected.
    pub fn act(&mut self) {
        self.expected_event = None;
        for event in self.events.drain(..) {
            let alarm = matches!(event.image.happening, CurrentEvent::Alarm(_));
            if alarm && !event.used && !event.counted {
                self.unexpected.push((happening(&event.image.happening), event.tick.frame));
            }
        }
    }
}

/// An event in words.
pub fn happening(happening: &CurrentEvent) -> String {
    match happening {
        CurrentEvent::Nothing => "nothing".into(),
        CurrentEvent::Alarm(alarm) => {
            let error = alarm.error.map_or_else(String::new, |error| format!(", channel error 0x{error:04X}"));
            format!("an alarm for slot {} subslot 0x{:04X}{error}", alarm.slot, alarm.subslot)
        }
        CurrentEvent::Abort(code) => {
            format!("an abort with PNIO status {}", wire::profinet::status::PnioStatus::from(*code))
        }
        CurrentEvent::Lldp(_) => "an LLDP announcement".into(),
        CurrentEvent::Hello(_) => "a Hello".into(),
        CurrentEvent::Ready(_) => "an ApplicationReady of a plugged or released submodule".into(),
        CurrentEvent::Diagnosis => "a diagnosis".into(),
    }
}
