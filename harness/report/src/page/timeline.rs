//! Timelines as SVG: lanes below each other with a common time axis.
//!
//! A lane has its own units: 10,000 along the time axis, 100 from its lowest value to its highest.

use super::html::escape;
use std::fmt::Write as _;

/// Units along the time axis.
const WIDTH: f64 = 10_000.0;
/// Units from the lowest value of a lane to its highest.
const HEIGHT: f64 = 100.0;

/// Values over time.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    pub heading: String,
    /// The first instant, in seconds.
    pub from: f64,
    /// The last instant, in seconds.
    pub to: f64,
    /// The lanes, from top to bottom.
    pub lanes: Vec<Lane>,
    /// Instants marked in all lanes.
    pub marks: Vec<Mark>,
    /// The signals that did not change, on one line.
    pub steady: String,
}

/// One quantity over time.
#[derive(Clone, Debug)]
pub struct Lane {
    pub name: String,
    pub shape: LaneShape,
}

/// How a lane is drawn.
#[derive(Clone, Debug)]
pub enum LaneShape {
    /// A number.
    Line(Vec<ValueSpan>),
    /// A bit.
    Bit(Vec<ValueSpan>),
    /// The phases of the connection.
    Phases(Vec<LanePhase>),
}

/// A span of time in which a value stayed between two bounds; between two spans the value is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueSpan {
    /// The begin, in seconds.
    pub from: f64,
    /// The end, in seconds.
    pub to: f64,
    /// The lowest value.
    pub least: f64,
    /// The highest value.
    pub most: f64,
    /// Whether the value before it is known, so that a line joins them.
    pub joined: bool,
}

/// A named span of time.
#[derive(Clone, Debug, PartialEq)]
pub struct LanePhase {
    /// The begin, in seconds.
    pub from: f64,
    /// The end, in seconds.
    pub to: f64,
    pub word: String,
}

/// A marked instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The time, in seconds.
    pub at: f64,
    /// Whether it is a finding or an event.
    pub is_finding: bool,
    pub text: String,
    /// The entry with the details.
    pub anchor: Option<String>,
}

impl Timeline {
    /// Writes the timeline, unless it has no lanes.
    pub(super) fn write(&self, out: &mut String) {
        if self.lanes.is_empty() {
            return;
        }
        let (from, to) = (self.from, self.to);
        let _ = write!(
            out,
            "<figure class=\"timeline\" data-from=\"{from}\" data-to=\"{to}\"><figcaption>{}</figcaption>\n<div class=\"lanes\">\n",
            escape(&self.heading)
        );
        for lane in &self.lanes {
            self.lane(lane, out);
        }
        out.push_str("</div>\n<div class=\"axis\"><span></span><span class=\"ticks\">");
        let _ = writeln!(out, "<span>{from:.6} s</span><span>{to:.6} s</span></span></div>");
        if !self.steady.is_empty() {
            let _ = writeln!(out, "<p class=\"steady\">{}</p>", escape(&self.steady));
        }
        out.push_str("</figure>\n");
    }

    fn lane(&self, lane: &Lane, out: &mut String) {
        let class = match &lane.shape {
            LaneShape::Line(_) => "line",
            LaneShape::Bit(_) => "bit",
            LaneShape::Phases(_) => "phases",
        };
        let range = match &lane.shape {
            LaneShape::Line(spans) => {
                let (least, most) = bounds(spans);
                format!("{least} to {most}")
            }
            LaneShape::Bit(_) | LaneShape::Phases(_) => String::new(),
        };
        let _ = write!(
            out,
            "<div class=\"lane {class}\"><span class=\"name\">{}<small>{range}</small></span>\
             <svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" preserveAspectRatio=\"none\">",
            escape(&lane.name)
        );
        match &lane.shape {
            LaneShape::Line(spans) => self.line(spans, out),
            LaneShape::Bit(spans) => spans.iter().for_each(|span| self.bit(span, out)),
            LaneShape::Phases(phases) => phases.iter().for_each(|phase| self.phase(phase, out)),
        }
        for mark in &self.marks {
            self.mark(mark, out);
        }
        out.push_str("</svg></div>\n");
    }

    fn x(&self, seconds: f64) -> f64 {
        let length = self.to - self.from;
        if length <= 0.0 { 0.0 } else { ((seconds - self.from) / length * WIDTH).clamp(0.0, WIDTH) }
    }

    fn line(&self, spans: &[ValueSpan], out: &mut String) {
        let (least, most) = bounds(spans);
        let y = |value: f64| match most - least {
            0.0 => HEIGHT / 2.0,
            height => HEIGHT - 4.0 - (value - least) / height * (HEIGHT - 8.0),
        };
        out.push_str("<path d=\"");
        let mut pen = PathPen::default();
        for span in spans {
            let (from, to) = (self.x(span.from), self.x(span.to));
            let (low, high) = (y(span.least), y(span.most));
            pen.go(from, low, span.joined, out);
            if low != high {
                let middle = (from + to) / 2.0;
                pen.go(middle, low, true, out);
                pen.go(middle, high, true, out);
            }
            pen.go(to, high, true, out);
        }
        out.push_str("\"/>");
    }

    fn bit(&self, span: &ValueSpan, out: &mut String) {
        let (from, to) = (self.x(span.from), self.x(span.to));
        let class = match (span.least != 0.0, span.most != 0.0) {
            (true, _) => "one",
            (false, false) => "zero",
            (false, true) => "both",
        };
        let width = (to - from).max(1.0);
        let (top, height) = if class == "zero" { (HEIGHT - 12.0, 6.0) } else { (10.0, HEIGHT - 16.0) };
        let _ = write!(
            out,
            "<rect class=\"{class}\" x=\"{from:.2}\" y=\"{top}\" width=\"{width:.2}\" height=\"{height}\"/>"
        );
    }

    fn phase(&self, phase: &LanePhase, out: &mut String) {
        let (from, to) = (self.x(phase.from), self.x(phase.to));
        let (width, word) = ((to - from).max(1.0), escape(&phase.word));
        let _ = write!(
            out,
            "<rect class=\"phase\" x=\"{from:.2}\" y=\"10\" width=\"{width:.2}\" height=\"{}\"><title>{word}, {:.6} to {:.6} s</title></rect>",
            HEIGHT - 20.0,
            phase.from,
            phase.to
        );
    }

    fn mark(&self, mark: &Mark, out: &mut String) {
        let x = self.x(mark.at);
        let class = if mark.is_finding { "finding" } else { "event" };
        let line = format!(
            "<line class=\"{class}\" x1=\"{x:.2}\" x2=\"{x:.2}\" y1=\"0\" y2=\"{HEIGHT}\"><title>{:.6} s: {}</title></line>",
            mark.at,
            escape(&mark.text)
        );
        match &mark.anchor {
            Some(anchor) => {
                let _ = write!(out, "<a href=\"#{}\">{line}</a>", escape(anchor));
            }
            None => out.push_str(&line),
        }
    }
}

/// Draws a path in steps of a tenth of a unit, relative to the last point: equal steps have equal texts.
#[derive(Default)]
struct PathPen(Option<(i64, i64)>);

impl PathPen {
    fn go(&mut self, x: f64, y: f64, is_joined: bool, out: &mut String) {
        let tenths = |units: f64| (units * 10.0).round() as i64;
        let (x, y) = (tenths(x), tenths(y));
        let text = |tenths: i64| match tenths % 10 {
            0 => (tenths / 10).to_string(),
            _ => format!("{:.1}", tenths as f64 / 10.0),
        };
        let _ = match self.0.filter(|_| is_joined) {
            None => write!(out, "M{} {}", text(x), text(y)),
            Some((before_x, before_y)) => match (x - before_x, y - before_y) {
                (0, 0) => Ok(()),
                (right, 0) => write!(out, "h{}", text(right)),
                (0, down) => write!(out, "v{}", text(down)),
                (right, down) => write!(out, "l{} {}", text(right), text(down)),
            },
        };
        self.0 = Some((x, y));
    }
}

fn bounds(spans: &[ValueSpan]) -> (f64, f64) {
    let least = spans.iter().map(|span| span.least).fold(f64::INFINITY, f64::min);
    let most = spans.iter().map(|span| span.most).fold(f64::NEG_INFINITY, f64::max);
    if least.is_finite() && most.is_finite() { (least, most) } else { (0.0, 0.0) }
}
