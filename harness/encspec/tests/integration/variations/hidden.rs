//! Bugs that a device cannot show while it has certain permitted variations.

/// Bugs that are hidden by variations.
pub struct HiddenBugs {
    /// The variations that hide them together.
    pub by: &'static [&'static str],
    pub bugs: &'static [&'static str],
    pub why: &'static str,
}

impl HiddenBugs {
    /// Whether a device with these variations cannot show the bug.
    pub fn hides(&self, bug: &str, variations: &[&str]) -> bool {
        self.bugs.contains(&bug) && self.by.iter().all(|name| variations.contains(name))
    }
}

const fn hidden(by: &'static [&'static str], bugs: &'static [&'static str], why: &'static str) -> HiddenBugs {
    HiddenBugs { by, bugs, why }
}

/// Always hidden.
pub const ALWAYS: &[HiddenBugs] = &[
    hidden(
        &["alarm-switch-refused-in-v41-mode"],
        &["alarm-switch-in-v41-mode"],
        "the switch is refused before it could act",
    ),
    hidden(&["any-axis-answered"], &["axis-unknown-as-parameter"], "no axis is unknown"),
    hidden(
        &["bf-flashes"],
        &["bf-led-dark-without-connection", "bf-led-red-while-starting"],
        "the LED flashes where the bug shows a steady colour",
    ),
    hidden(
        &["bits-of-class-2-refused-in-class-1"],
        &["extended-diagnosis-in-class-1", "velocity-in-class-1"],
        "the parameters are refused",
    ),
    hidden(
        &["calculation-off-holds-the-velocity"],
        &["speed-mode-ignored"],
        "the velocity is held whatever the mode says",
    ),
    hidden(
        &["class-3-keeps-the-settings"],
        &["code-sequence-without-class-4", "scaling-without-class-4"],
        "without class 4 the settings before stay in force, which may be those that the bug uses",
    ),
    hidden(
        &["codes-of-the-telegrams-hidden-too"],
        &["error-bit-hidden-with-the-codes"],
        "the bit is hidden with the codes on purpose",
    ),
    hidden(&["compatibility-mode-refused"], &["compatibility-mode-works"], "the mode is refused"),
    hidden(&["configured-scaling-shown"], &["default-range-of-one-revolution"], "what is in force is not shown"),
    hidden(&["control-always-requested"], &["control-requested-latches"], "bit 9 is always set"),
    hidden(&["counters-continue-at-1"], &["occurrences-wrap"], "the counter wraps as with the bug"),
    hidden(&["counters-start-at-1"], &["occurrences-wrap"], "the counter wraps as with the bug"),
    hidden(&["counters-without-bit-0"], &["occurrences-0-from-elsewhere"], "the counter has no place of its own"),
    hidden(
        &["date-in-bcd"],
        &["month-before-day"],
        "the order of the parts is the only difference, and the variation replaces it",
    ),
    hidden(&["identify-answered-twice"], &["identify-answered-too-late"], "the other answer comes in time"),
    hidden(
        &["diagnosis-announced-again"],
        &["diagnosis-fetched-by-anybody"],
        "the announcement comes again whoever has fetched it",
    ),
    hidden(&["diagnosis-in-portions"], &["one-header-for-two-blocks"], "each response has one block"),
    hidden(
        &["error-cleared-step-by-step"],
        &["code-stays-after-acknowledgement", "position-unrequested-after-error"],
        "the code and the bit go one after the other on purpose",
    ),
    hidden(&["error-code-before-its-bit"], &["error-code-one-frame-late"], "the code comes first"),
    hidden(&["errors-clear-themselves"], &["acknowledgement-ignored"], "the error is gone before it is acknowledged"),
    hidden(
        &["excessive-preset-reduced"],
        &["preset-beyond-the-range-shown", "preset-limit-one-too-high"],
        "the value is reduced before the limit is checked",
    ),
    hidden(
        &["excessive-preset-reduced-up-to-the-hardware"],
        &["preset-beyond-the-range-shown", "preset-limit-one-too-high"],
        "the value is reduced before the limit is checked",
    ),
    hidden(
        &["faults-0-in-v31"],
        &["other-fault-bits-in-compatibility-mode"],
        "there are no faults in compatibility mode",
    ),
    hidden(
        &["firmware-of-a-prototype"],
        &["page-shows-old-version"],
        "the version of the page is that of the variation",
    ),
    hidden(
        &["firmware-of-two-digits"],
        &["page-shows-old-version"],
        "the version of the page is that of the variation",
    ),
    hidden(&["forbidden-address-is-126"], &["address-modulo-128", "works-at-0"], "the address is replaced"),
    hidden(
        &["functions-stay-without-control"],
        &["control-by-plc-ignored", "xist2-freezes-without-control"],
        "the functions go on without control on purpose",
    ),
    hidden(
        &["held-request-needs-a-new-edge"],
        &["control-remembered"],
        "a held request does nothing without a new edge",
    ),
    hidden(
        &["idents-of-32-bits"],
        &["encoder-in-slot-0"],
        "the encoder in slot 0 has a wrong ident, which is reported as it should",
    ),
    hidden(
        &["idents-of-another-list"],
        &["encoder-in-slot-0"],
        "the encoder in slot 0 has a wrong ident, which is reported as it should",
    ),
    hidden(
        &["impossible-scaling-on-leds-only"],
        &[
            "check-overflows",
            "clamped-scaling-not-checked",
            "impossible-scaling-accepted",
            "range-below-a-revolution-accepted",
            "ratio-cut-off",
            "revolutions-of-multiturn",
            "unused-values-in-force",
        ],
        "no telegram shows whether a scaling was accepted",
    ),
    hidden(
        &["inputs-and-outputs-not-read"],
        &["read-inputs-are-old", "read-outputs-are-old"],
        "the services do not exist",
    ),
    hidden(
        &["inputs-one-cycle-old"],
        &["preset-in-the-second-cycle"],
        "the preset of the second cycle is seen in the third, where it is right",
    ),
    hidden(
        &["inputs-one-cycle-old", "outputs-one-cycle-late"],
        &["preset-in-the-first-cycle"],
        "the preset of the first cycle is seen in the third, where it is right",
    ),
    hidden(
        &["inputs-two-cycles-old"],
        &["preset-in-the-first-cycle", "preset-in-the-second-cycle"],
        "the preset of an earlier cycle is seen in the third, where it is right",
    ),
    hidden(
        &["invalid-records-refused"],
        &[
            "impossible-scaling-accepted",
            "invalid-parameters-as-memory-error",
            "invalid-record-accepted",
            "other-ratios-accepted",
            "single-limits-not-checked",
            "speed-unit-not-checked",
            "upper-scaling-bytes-ignored",
            "zero-units-stop-the-device",
        ],
        "the record is refused before anything of it is judged or reported",
    ),
    hidden(
        &["invalid-start-parameters-refused"],
        &[
            "divisor-0-accepted",
            "filter-not-checked",
            "invalid-configuration-not-on-led",
            "invalid-scaling-not-noticed",
            "round-axis-range-not-checked",
            "single-limits-not-checked",
            "upper-scaling-bytes-ignored",
            "wrong-value-clipped",
        ],
        "the record is refused before anything of it is judged or reported",
    ),
    hidden(&["io-positions-of-26-bits"], &["highest-preset-is-an-error"], "there is no such preset"),
    hidden(
        &["last-control-word-held"],
        &["control-by-plc-ignored", "control-by-plc-not-noticed"],
        "the control word before stays in force without control; only bit 9 tells, which is another requirement's",
    ),
    hidden(
        &["last-control-word-held", "control-always-requested"],
        &["reserved-stw2-bits-act"],
        "neither the word nor bit 9 shows the end of control",
    ),
    hidden(
        &["life-sign-failures-counted-slowly"],
        &["life-sign-failures-add-up", "life-sign-tolerance-off-by-one"],
        "failures are counted otherwise",
    ),
    hidden(
        &["list-ends-with-zero"],
        &["number-list-ends-with-ffff", "number-list-misses-one"],
        "the last entry of the list is that of the variation",
    ),
    hidden(&["lock-of-the-address-refused"], &["address-locked"], "the address is never locked"),
    hidden(
        &["lowest-speed-above-the-highest-refused"],
        &["speed-limits-exchanged"],
        "the exchanged limits are refused",
    ),
    hidden(
        &["memory-alarm-supported"],
        &["announced-alarm-not-raised", "unannounced-alarm-raised"],
        "the alarm is announced and raised",
    ),
    hidden(&["no-clock-with-io-modules"], &["code-for-a-missing-clock"], "the mode is refused"),
    hidden(&["no-sign-of-life"], &["sign-of-life-carries"], "there is no sign of life"),
    hidden(&["offset-stored-after-500-ms"], &["offset-only-in-ram"], "the variation stores the offset by itself"),
    hidden(
        &["one-parameter-at-a-time"],
        &["multi-write-stops-at-first-error", "one-error-drops-all", "response-cut-off"],
        "requests for several parameters are refused",
    ),
    hidden(&["operating-time-in-motion"], &["operating-time-not-kept"], "the parameter is another counter"),
    hidden(&["other-lengths-reported"], &["record-length-not-checked"], "a record of another length is reported"),
    hidden(&["outputs-one-cycle-late"], &["single-failure-is-error"], "the error is there from the first cycles on"),
    hidden(
        &["outputs-one-cycle-late"],
        &["preset-in-the-second-cycle"],
        "the preset of the second cycle is made in the third, where it is right",
    ),
    hidden(&["p925-always-1"], &["default-tolerance-wrong", "tolerance-of-4-bits"], "P925 is 1 in either case"),
    hidden(
        &["p971-cannot-be-read"],
        &["p971-confirms-too-early", "p971-reads-memory", "save-never-ends"],
        "no value is read",
    ),
    hidden(
        &["parameter-responses-late"],
        &["record-read-freezes-position", "torn-write-taken"],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(&["parked-while-turning"], &["parking-code-wrong"], "parking is never refused, so there is no code"),
    hidden(&["parking-clears-errors"], &["acknowledgement-lost-while-parked"], "parking clears the error"),
    hidden(
        &["parking-freezes-stdtel81-only"],
        &["parked-positions-disagree"],
        "the positions differ while parked on purpose",
    ),
    hidden(
        &["position-flickers"],
        &["default-samples-1", "preset-value-of-erased-memory", "revolutions-of-16-bits", "trigger-limit-one-short"],
        "one step away, as the flicker is",
    ),
    hidden(
        &["positions-before-bit-14"],
        &["position-before-parking-shown", "unpark-status-first"],
        "the positions come before bit 14 on purpose",
    ),
    hidden(
        &["powers-of-two-ratios-only"],
        &["first-position-limited", "second-position-runs-below-0", "second-position-wraps"],
        "the ratio at which it shows is refused",
    ),
    hidden(
        &["preset-beyond-the-range-is-reduced"],
        &["preset-checked-against-multiturn", "preset-range-not-checked"],
        "the value is reduced and never beyond the range",
    ),
    hidden(
        &["preset-done-within-a-cycle"],
        &["preset-acknowledge-stays", "preset-acknowledged-too-early"],
        "bit 12 is never seen",
    ),
    hidden(
        &["preset-in-the-first-cycle-shown-in-the-third"],
        &["preset-in-the-first-cycle", "preset-in-the-second-cycle", "preset-mixes-telegrams"],
        "when the preset is made is not seen",
    ),
    hidden(
        &["preset-value-refused-at-the-write"],
        &[
            "invalid-preset-not-on-led",
            "preset-checked-against-multiturn",
            "preset-range-not-checked",
            "preset-value-reduced",
            "preset-warning-at-the-write",
            "preset-warning-missing",
        ],
        "the value is refused before the preset",
    ),
    hidden(
        &["preset-while-its-bit-is-set"],
        &["old-offset-added-again", "preset-undone-with-its-bit"],
        "the preset is made again while its bit is set",
    ),
    hidden(
        &["presets-at-once"],
        &["preset-acknowledged-too-early", "sign-of-life-stops-during-preset", "simultaneous-presets-add"],
        "the preset is over before the next cycle",
    ),
    hidden(&["presets-fast"], &["simultaneous-presets-add"], "the first preset is stored before the second begins"),
    hidden(&["presets-fast"], &["sign-of-life-stops-during-preset"], "the preset is over before the next cycle"),
    hidden(
        &["presets-fast", "inputs-two-cycles-old"],
        &["preset-acknowledged-before-stored"],
        "the inputs show the acknowledgement when the preset is stored",
    ),
    hidden(
        &["presets-late", "fail-safe-without-its-bit"],
        &["short-outputs-taken"],
        "the outputs are replaced before the preset is made",
    ),
    hidden(
        &["presets-late", "inputs-and-outputs-not-read"],
        &["short-outputs-taken"],
        "the outputs are replaced before the preset is made, and cannot be read",
    ),
    hidden(
        &["presets-wait-for-the-end-of-errors"],
        &["memory-error-swallowed", "preset-acknowledged-not-done"],
        "the preset waits until the error is gone",
    ),
    hidden(
        &["range-below-a-revolution-is-an-error"],
        &["range-below-a-revolution-ignored"],
        "such a range is an error",
    ),
    hidden(&["range-limited-to-all-revolutions"], &["more-revolutions-than-there-are"], "the range is replaced"),
    hidden(&["range-rounded-down"], &["rule-of-powers-missing"], "the range is replaced"),
    hidden(
        &["read-late"],
        &[
            "interrupted-save-is-mixed",
            "p971-confirms-too-early",
            "record-read-freezes-position",
            "save-during-save-lost",
            "saved-before-it-is-written",
            "second-save-spoils-memory",
        ],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(
        &["ready-after-2-s"],
        &["inputs-before-configuration"],
        "the time until it is ready is that of the variation",
    ),
    hidden(
        &["ready-after-30-ms"],
        &["inputs-before-configuration", "ready-before-parameters"],
        "the time until it is ready is that of the variation",
    ),
    hidden(
        &["ready-time-jitters"],
        &["inputs-before-configuration", "ready-before-parameters"],
        "the time until it is ready is that of the variation",
    ),
    hidden(&["ready-very-late"], &["error-led-off-late"], "the LED is off when the start ends"),
    hidden(&["record-in-force-at-once"], &["record-half-taken-in-data-exchange"], "the record takes effect as a whole"),
    hidden(
        &["record-time-jitters"],
        &["busy-answered-with-another-error", "torn-write-taken"],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(
        &["records-after-80-ms"],
        &["busy-answered-with-another-error", "record-read-freezes-position", "torn-write-taken"],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(
        &["records-jitter"],
        &["p971-confirms-too-early", "record-read-freezes-position", "saved-before-it-is-written"],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(
        &["red-and-orange-flash"],
        &["invalid-configuration-not-on-led", "invalid-preset-not-on-led"],
        "the LED flashes as with the bug",
    ),
    hidden(
        &["relative-log-is-read-only"],
        &["relative-log-is-the-absolute-one", "reset-clears-both-logs"],
        "the log is never reset",
    ),
    hidden(
        &["reserved-bits-refused"],
        &["reserved-bit-7-acts", "reserved-bit-acts", "reserved-bytes-act"],
        "the record is refused",
    ),
    hidden(
        &["reserved-bits-reported"],
        &["reserved-bit-7-acts", "reserved-bytes-act"],
        "the record is reported as wrong",
    ),
    hidden(&["reserved-preset-bits-block"], &["reserved-preset-bits-double"], "with reserved bits there is no preset"),
    hidden(
        &["reserved-preset-bits-limit"],
        &["reserved-preset-bits-double"],
        "with reserved bits the value is limited",
    ),
    hidden(&["round-axis-of-the-start"], &["fraction-as-remainder"], "the gear is that of the start"),
    hidden(&["round-axis-results-ignore-writes"], &["round-axis-outputs-written"], "writes have no effect"),
    hidden(&["snmp-set-unanswered"], &["snmp-objects-writable"], "the request is discarded"),
    hidden(&["speed-in-hardware-steps"], &["rpm-from-scaled-steps"], "the unit is that of the variation"),
    hidden(&["speed-of-the-last-100-ms"], &["speed-every-100ms"], "the speed is renewed as with the bug"),
    hidden(&["speed-settings-kept"], &["settings-kept-in-part"], "all settings are kept"),
    hidden(&["speed-without-sign"], &["velocity-halved-backward"], "no velocity is below 0"),
    hidden(
        &["start-parameters-elsewhere"],
        &[
            "missing-bytes-from-old-buffer",
            "parameter-length-not-checked",
            "tolerance-of-4-bits",
            "undefined-speed-unit-taken",
        ],
        "the parameter is at another place than the bug acts on",
    ),
    hidden(&["tolerance-limited"], &["tolerance-of-4-bits"], "the tolerance is replaced"),
    hidden(&["traffic-flashes-green"], &["link-led-without-activity"], "the LED flashes in the colour of the bug"),
    hidden(
        &["undervoltage-without-a-word"],
        &["code-of-undervoltage-missing", "undervoltage-until-power-off"],
        "undervoltage is not reported",
    ),
    hidden(&["unknown-unit-is-rpm"], &["undefined-speed-unit-taken"], "the unit is replaced"),
    hidden(
        &["values-checked-without-scaling"],
        &[
            "check-overflows",
            "clamped-scaling-not-checked",
            "impossible-scaling-accepted",
            "range-below-a-revolution-accepted",
            "ratio-cut-off",
            "revolutions-of-multiturn",
            "unused-values-in-force",
        ],
        "the variation checks the values",
    ),
    hidden(&["velocity-in-hardware-steps"], &["rpm-from-scaled-steps"], "the unit is that of the variation"),
    hidden(
        &["voltage-limits-only-warn"],
        &["error-codes-combined", "limits-not-checked-again"],
        "there is no error, only a warning",
    ),
    hidden(
        &["without-sync-and-freeze"],
        &["freeze-ignored", "mode-requests-corrupt-class", "sync-ignored"],
        "the modes do not exist",
    ),
    hidden(
        &["working-before-answer"],
        &[
            "interrupted-save-is-mixed",
            "p971-confirms-too-early",
            "record-read-freezes-position",
            "save-during-save-lost",
            "saved-before-it-is-written",
            "second-save-spoils-memory",
        ],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(
        &["write-late"],
        &[
            "interrupted-save-is-mixed",
            "p971-confirms-too-early",
            "record-read-freezes-position",
            "save-during-save-lost",
            "saved-before-it-is-written",
            "second-save-spoils-memory",
        ],
        "the answer takes longer than what the bug does during it",
    ),
    hidden(
        &["write-taken-late"],
        &["record-read-freezes-position", "save-during-save-lost"],
        "the request is taken when what the bug spoils is over",
    ),
    hidden(
        &["wrong-parameters-refused"],
        &[
            "diagnosis-record-empty",
            "faults-survive-restart",
            "impossible-scaling-accepted",
            "no-alarm-for-parameters",
            "one-alarm-for-all",
            "single-limits-not-checked",
            "speed-unit-not-checked",
            "tolerance-0-accepted",
            "upper-scaling-bytes-ignored",
        ],
        "the record is refused before anything of it is judged or reported",
    ),
];

/// Hidden or not, as the times fall.
pub const SOMETIMES: &[HiddenBugs] = &[
    hidden(
        &["position-flickers"],
        &["highest-position-wraps", "resolution-of-13-bits", "sum-not-divided"],
        "what is wrong is one step, as the flicker is",
    ),
    hidden(
        &["input-frames-lost"],
        &[
            "outputs-of-anybody",
            "park-clears-position-first",
            "position-before-parking-shown",
            "position-torn",
            "preset-flashes-error",
            "preset-interrupts-transfer",
            "unpark-status-first",
        ],
        "the wrong frame may be one that is lost",
    ),
    hidden(
        &["input-frames-lost-in-a-row"],
        &[
            "park-clears-position-first",
            "position-before-parking-shown",
            "position-torn",
            "preset-acknowledged-too-early",
            "unpark-status-first",
        ],
        "the wrong frame may be one that is lost",
    ),
    hidden(
        &["output-frames-lost"],
        &["life-sign-tolerance-off-by-one"],
        "the sign of life that fails may be one that is lost",
    ),
    hidden(
        &["ready-time-jitters"],
        &["speed-held-at-standstill"],
        "the update of the speed may fall on the standstill",
    ),
    hidden(&["ready-after-30-ms"], &["speed-held-at-standstill"], "the update of the speed may fall on the standstill"),
    hidden(
        &["answers-twice"],
        &["p971-confirms-too-early", "record-read-freezes-position", "save-during-save-lost"],
        "the answer may take longer than what the bug does during it",
    ),
    hidden(
        &["records-jitter"],
        &["interrupted-save-is-mixed", "save-during-save-lost", "second-save-spoils-memory"],
        "the answer may take longer than what the bug does during it",
    ),
    hidden(
        &["record-time-jitters"],
        &["record-read-freezes-position"],
        "the answer may take longer than what the bug does during it",
    ),
    hidden(
        &["write-taken-late"],
        &["p971-confirms-too-early", "saved-before-it-is-written", "second-save-spoils-memory"],
        "the request may be taken when what the bug spoils is over",
    ),
];
