//! The keys of a ledger.

use suite_yaml::key_set;
use suite_yaml::keys::Pattern;

/// A day as YYYY-MM-DD.
static DAY: Pattern = Pattern { regex: r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$" };

key_set! {
    pub ledger "a ledger of known failures" {
        known_failures must List(&Keys(&known_failure::KEYS)), "The failures that are known and followed.";
    }
}

key_set! {
    pub(super) known_failure "a known failure" {
        test must FilledText, "The test, `SUITE/CASE[ROW]` with or without the manual in front; `*` stands for any letters.";
        device must FilledText, "The manual.";
        variant may FilledText, "The variant, every one by default.";
        firmware may Keys(&firmware::KEYS), "The firmware that has the failure, every one by default.";
        reason must FilledText, "Why it fails, in one sentence.";
        ticket must FilledText, "Where the failure is followed.";
        expires must Pattern(&DAY), "The last day on which the entry excuses anything, as YYYY-MM-DD.";
        signature must FilledText, "How it fails, as the JSON report has it under `signature`; `*` stands for any letters.";
    }
}

key_set! {
    pub(super) firmware "a range of firmware" {
        from may FilledText, "The first firmware that has the failure.";
        to may FilledText, "The last one.";
    }
}
