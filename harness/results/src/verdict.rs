//! Verdicts of trials, rules and requirements.

use std::fmt;

/// The verdict of a trial, a rule or a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// Everything expected was observed.
    Pass,
    /// The device deviates from its manual.
    Fail,
    /// A precondition or the environment failed, so the device was not judged.
    Inconclusive,
    /// A claim of the bench file or a missing ability of the stand excludes it; the reason names it.
    NotApplicable,
    /// An error of the harness or the suite.
    Error,
    /// It failed as described in the ledger of known failures.
    Xfail,
    /// It passed although the ledger expects a failure; the entry has to be removed.
    Xpass,
    /// It was not run, or its premise never occurred.
    NotRun,
}

/// The effect of a verdict on the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Does not make the run fail.
    Green,
    /// Does not make the run fail; has a reason.
    Neutral,
    /// Makes the run fail.
    Red,
}

impl Verdict {
    /// Every verdict in the order of summaries.
    pub const ALL: [Verdict; 8] = [
        Verdict::Pass,
        Verdict::Fail,
        Verdict::Inconclusive,
        Verdict::NotApplicable,
        Verdict::Error,
        Verdict::Xfail,
        Verdict::Xpass,
        Verdict::NotRun,
    ];

    /// The word in reports and JSON.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "fail",
            Verdict::Inconclusive => "inconclusive",
            Verdict::NotApplicable => "not-applicable",
            Verdict::Error => "error",
            Verdict::Xfail => "xfail",
            Verdict::Xpass => "xpass",
            Verdict::NotRun => "not-run",
        }
    }

    /// Only `pass` and `xfail` are green; `not-applicable` is neutral; everything else is red.
    pub fn colour(self) -> Colour {
        match self {
            Verdict::Pass | Verdict::Xfail => Colour::Green,
            Verdict::NotApplicable => Colour::Neutral,
            Verdict::Fail | Verdict::Inconclusive | Verdict::Error | Verdict::Xpass | Verdict::NotRun => Colour::Red,
        }
    }
}

/// The worse of two verdicts: red is worse than green, and `fail` is the worst.
pub fn worse(one: Verdict, other: Verdict) -> Verdict {
    let weight = |verdict: Verdict| match verdict {
        Verdict::Fail => 7,
        Verdict::Error => 6,
        Verdict::Inconclusive => 5,
        Verdict::Xpass => 4,
        Verdict::NotRun => 3,
        Verdict::Xfail => 2,
        Verdict::Pass => 1,
        Verdict::NotApplicable => 0,
    };
    if weight(other) > weight(one) { other } else { one }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}
