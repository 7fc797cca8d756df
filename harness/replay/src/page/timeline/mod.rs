//! The data of the connections over time, for the page: signals with their names, start-up phases, alarms.
//!
//! They are recorded only for a page. This module must not know rules or findings.

mod lanes;
mod series;

use crate::clock::CaptureClock;
use crate::fits_manual;
use judge::image::ConnectionImage;
use judge::observe::{ArId, FrameDirection, Observation, ObservedAr};
use lanes::SignalLanes;
use report::page::{Lane, LanePhase, LaneShape, Mark, Timeline};
use station::Time;
use suite::model::Manual;

/// Upper limit of the connections with a timeline.
const MOST_TIMELINES: usize = 16;
/// Upper limit of the events marked in one timeline.
const MOST_MARKS: usize = 200;

/// The data of the connections over time.
#[derive(Debug)]
pub(super) struct Timelines<'a> {
    manuals: &'a [Manual],
    clock: CaptureClock,
    /// The recorders of the connections, in the order of their numbers.
    of: Vec<Option<TimelineRecorder>>,
    recorded: usize,
}

/// The data of one connection over time.
#[derive(Debug)]
struct TimelineRecorder {
    from: f64,
    to: f64,
    signals: SignalLanes,
    phases: Vec<(f64, &'static str)>,
    marks: Vec<Mark>,
    ended: bool,
}

impl<'a> Timelines<'a> {
    /// Nothing recorded yet; signal names come from `manuals`.
    pub fn new(manuals: &'a [Manual]) -> Timelines<'a> {
        Timelines { manuals, clock: CaptureClock::default(), of: Vec::new(), recorded: 0 }
    }

    /// Takes in an observation of the frame at `time`.
    pub fn observe(&mut self, ars: &[ObservedAr], time: Time, observation: &Observation<'_>) {
        let at = self.seconds(time);
        let Some(id) = observation.ar() else { return };
        if let Observation::Connected { .. } = observation {
            self.connected(ars, id, at);
        }
        let Some(recorder) = self.of.get_mut(id.0 as usize).and_then(Option::as_mut) else { return };
        recorder.to = recorder.to.max(at);
        match observation {
            Observation::Cyclic { direction, data, status, .. } => {
                recorder.signals.sample(at, *direction, data, status)
            }
            Observation::ParameterEnd { .. } => recorder.phase(at, "waiting for the application"),
            Observation::ApplicationReady { .. } => recorder.phase(at, "data exchange"),
            Observation::PlugReady { .. } => recorder.mark(at, "plugged submodule ready".to_owned()),
            Observation::Alarm { notification, .. } => {
                let kind = notification.alarm_type;
                let word = kind.word().map_or_else(|| format!("0x{:04X}", kind.0), str::to_owned);
                recorder.mark(at, format!("alarm {word}"));
            }
            Observation::Aborted { status, .. } => recorder.end(at, format!("ended with an ERR-RTA: {status}")),
            Observation::Released { .. } => recorder.end(at, "released".to_owned()),
            Observation::Starved { direction, .. } => {
                let who = match direction {
                    FrameDirection::ToController => "the device",
                    FrameDirection::ToDevice => "the controller",
                };
                recorder.end(at, format!("{who} sent no frame for longer than its watchdog"));
            }
            Observation::Dp { event: judge::observe::Dp::Left { .. }, .. } => {
                recorder.end(at, "the slave left the data exchange".to_owned());
            }
            _ => {}
        }
    }

    fn connected(&mut self, ars: &[ObservedAr], id: ArId, at: f64) {
        let Some(ar) = ars.get(id.0 as usize) else { return };
        let index = id.0 as usize;
        if self.of.len() <= index {
            self.of.resize_with(index + 1, || None);
        }
        if ar.submodules.is_empty() || self.of[index].is_some() || self.recorded >= MOST_TIMELINES {
            return;
        }
        self.recorded += 1;
        let signals = match self.manuals.iter().find(|manual| fits_manual(manual, ar)) {
            Some(manual) => {
                let mut image = ConnectionImage::new(&manual.device);
                image.open(&manual.device, ar);
                SignalLanes::named(&manual.device, &image)
            }
            None => SignalLanes::by_place(ar),
        };
        let from = ar.connect_time.map_or(at, |time| self.seconds(time));
        let phases = match (ar.connect_time, &ar.slave) {
            // The connection was made before the capture began.
            (None, _) => vec![(at, "data exchange")],
            (Some(_), Some(_)) => vec![(from, "connecting"), (at, "data exchange")],
            (Some(_), None) => vec![(from, "connecting"), (at, "start parameters")],
        };
        self.of[index] = Some(TimelineRecorder { from, to: at, signals, phases, marks: Vec::new(), ended: false });
    }

    fn seconds(&mut self, time: Time) -> f64 {
        self.begin(time);
        self.clock.seconds(time)
    }

    /// Notes the time of a frame, since time counts from the first frame of the capture.
    pub fn begin(&mut self, time: Time) {
        self.clock.take(time);
    }

    /// The timelines, each with the number of its connection.
    pub fn end(self) -> Vec<(usize, Timeline)> {
        let of = self.of.into_iter().enumerate();
        of.filter_map(|(index, recorder)| Some((index, recorder?.timeline()))).collect()
    }
}

impl TimelineRecorder {
    fn phase(&mut self, at: f64, word: &'static str) {
        self.phases.push((at, word));
    }

    fn mark(&mut self, at: f64, text: String) {
        if self.marks.len() < MOST_MARKS {
            self.marks.push(Mark { at, is_finding: false, text, anchor: None });
        }
    }

    fn end(&mut self, at: f64, why: String) {
        self.mark(at, why);
        self.signals.cut();
        if !self.ended {
            self.phases.push((at, ""));
        }
        self.ended = true;
    }

    fn timeline(self) -> Timeline {
        let TimelineRecorder { from, to, signals, phases, marks, .. } = self;
        let ends = phases.iter().skip(1).map(|(at, _)| *at).chain([to]);
        let phases = phases.iter().zip(ends).filter(|((_, word), _)| !word.is_empty());
        let phases =
            phases.map(|(&(from, word), to)| LanePhase { from, to: to.max(from), word: word.to_owned() }).collect();
        let (lanes, steady) = signals.lanes();
        let start_up = Lane { name: "start-up".to_owned(), shape: LaneShape::Phases(phases) };
        let lanes = [start_up].into_iter().chain(lanes).collect();
        Timeline { heading: String::new(), from, to, lanes, marks, steady }
    }
}
