//! Verdicts: what a trial, a rule or a requirement comes to. No false green.

use std::fmt;

/// What a trial or a rule comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// Everything asked for was seen.
    Pass,
    /// The device did something else than its manual says.
    Fail,
    /// A precondition or the environment broke: nothing can be said about the device.
    Inconclusive,
    /// A claim or a missing ability excludes it; the reason names it.
    NotApplicable,
    /// The harness or the suite broke.
    Error,
    /// It failed as the ledger of known failures says.
    Xfail,
    /// The ledger expects a failure and it passed: the entry has to go.
    Xpass,
    /// It was not looked at.
    NotRun,
}

/// How a verdict weighs in the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Counts for the device.
    Green,
    /// Counts neither way and names its reason.
    Neutral,
    /// Makes the run fail.
    Red,
}

impl Verdict {
    /// Every verdict, in the order in which summaries list them.
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

    /// The word in every report, as the JSON contract has it.
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

/// The worse of two verdicts: what is red weighs more than what is green, and a failure most of all.
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
