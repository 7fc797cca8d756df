//! A value over time in bounded memory: merged samples keep their lowest and highest value.

use report::page::ValueSpan;

/// Upper limit of the spans of one value.
const MOST_SPANS: usize = 512;

/// A value over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Series {
    spans: Vec<ValueSpan>,
    last: f64,
    /// Whether the value is known since the last sample.
    known: bool,
}

impl Series {
    /// Takes in the value at a time, in seconds; a time that steps back extends nothing.
    pub fn sample(&mut self, at: f64, value: f64) {
        let joined = self.known;
        self.known = true;
        if let Some(span) = self.spans.last_mut().filter(|_| joined) {
            let at = at.max(span.to);
            if value == self.last {
                span.to = at;
                return;
            }
            // The old value was valid until now.
            span.to = at;
        }
        self.last = value;
        self.spans.push(ValueSpan { from: at, to: at, least: value, most: value, joined });
        if self.spans.len() > MOST_SPANS {
            self.halve();
        }
    }

    /// The value is unknown from here to the next sample.
    pub fn cut(&mut self) {
        self.known = false;
    }

    /// Whether it had two different values.
    pub fn moved(&self) -> bool {
        let first = self.spans.first().map(|span| span.least);
        self.spans.iter().any(|span| Some(span.least) != first || Some(span.most) != first)
    }

    /// Its last value, if it had one.
    pub fn value(&self) -> Option<f64> {
        (!self.spans.is_empty()).then_some(self.last)
    }

    /// The spans, the earliest first.
    pub fn into_spans(self) -> Vec<ValueSpan> {
        self.spans
    }

    /// Merges pairs of joined spans.
    fn halve(&mut self) {
        let mut kept: Vec<ValueSpan> = Vec::with_capacity(MOST_SPANS);
        let mut may_take = false;
        for span in self.spans.drain(..) {
            match kept.last_mut().filter(|_| may_take && span.joined) {
                Some(before) => {
                    *before = ValueSpan {
                        to: span.to,
                        least: before.least.min(span.least),
                        most: before.most.max(span.most),
                        ..*before
                    };
                    may_take = false;
                }
                None => {
                    kept.push(span);
                    may_take = true;
                }
            }
        }
        // A value that comes and goes has no joined spans to merge: then the earliest spans are dropped.
        if kept.len() > MOST_SPANS {
            kept.drain(..MOST_SPANS / 2);
        }
        self.spans = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_stays_is_one_span() {
        let mut series = Series::default();
        (0..1_000).for_each(|at| series.sample(f64::from(at), 7.0));
        assert!(!series.moved());
        let spans = series.into_spans();
        assert_eq!(spans, [ValueSpan { from: 0.0, to: 999.0, least: 7.0, most: 7.0, joined: false }]);
    }

    /// A peak of one sample is still present after a hundred thousand others, and memory does not grow.
    #[test]
    fn a_peak_is_never_lost() {
        let mut series = Series::default();
        for at in 0..200_000u32 {
            series.sample(f64::from(at), if at == 77_777 { 1e9 } else { f64::from(at % 2) });
        }
        let spans = series.into_spans();
        assert!(spans.len() <= MOST_SPANS, "{}", spans.len());
        let peak = spans.iter().find(|span| span.most == 1e9).expect("the peak");
        assert!(peak.from <= 77_777.0 && peak.to >= 77_777.0, "{peak:?}");
        assert!(spans.windows(2).all(|two| two[0].to == two[1].from), "there is no gap between two spans");
    }

    #[test]
    fn a_gap_stays_a_gap() {
        let mut series = Series::default();
        series.sample(0.0, 1.0);
        series.sample(1.0, 1.0);
        series.cut();
        series.sample(5.0, 1.0);
        let spans = series.into_spans();
        assert_eq!(
            spans.iter().map(|span| (span.from, span.to, span.joined)).collect::<Vec<_>>(),
            [(0.0, 1.0, false), (5.0, 5.0, false)]
        );
    }

    #[test]
    fn a_time_that_steps_back_extends_nothing() {
        let mut series = Series::default();
        [(3.0, 1.0), (1.0, 2.0), (4.0, 2.0)].iter().for_each(|&(at, value)| series.sample(at, value));
        assert!(series.into_spans().iter().all(|span| span.to >= span.from));
    }
}
