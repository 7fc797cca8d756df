//! The verbs of steps with their modifiers: in each set the first key is the verb.

use super::keys::KeySet;
use super::topic_keys::{exchanged, observed, turn};

/// Which verb a step has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VerbWord {
    Set,
    Turn,
    Exchange,
    Connect,
    Write,
    Read,
    Send,
    Expect,
    Wait,
    Save,
    Steps,
    Either,
    Do,
}

/// The verbs, each with the keys of its step.
pub(super) static VERBS: &[(VerbWord, &KeySet)] = &[
    (VerbWord::Set, &set_step::KEYS),
    (VerbWord::Turn, &turn_step::KEYS),
    (VerbWord::Exchange, &exchange_step::KEYS),
    (VerbWord::Connect, &connect_step::KEYS),
    (VerbWord::Write, &write_step::KEYS),
    (VerbWord::Read, &read_step::KEYS),
    (VerbWord::Send, &send_step::KEYS),
    (VerbWord::Expect, &expect_step::KEYS),
    (VerbWord::Wait, &wait_step::KEYS),
    (VerbWord::Save, &save_step::KEYS),
    (VerbWord::Steps, &block_step::KEYS),
    (VerbWord::Either, &either_step::KEYS),
    (VerbWord::Do, &procedure_step::KEYS),
];

/// The word of a verb: the first key of its set.
pub(super) fn word_of(set: &'static KeySet) -> &'static str {
    set.keys.first().map_or("", |key| key.name)
}

key_set! {
    pub(crate) set_step "a step with `set`" {
        set must Settings, "Holds from now on; outputs also over reconnects, until the trial ends.";
    }
}

key_set! {
    pub(crate) turn_step "a step with `turn`" {
        turn must Keys(&turn::KEYS), "Moves the shaft through all positions between.";
    }
}

key_set! {
    pub(crate) exchange_step "a step with `exchange`" {
        exchange must NonEmpty(&Keys(&exchanged::KEYS)), "Each entry is exactly `times` cycles.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    }
}

key_set! {
    pub(crate) connect_step "a step with `connect`" {
        connect must Start, "Ends the connection of the same controller, then starts one; `none` only ends it.";
        answer may Answer, "The right answers of the start-up, stage by stage.";
        r#as may Only("second"), "The second controller or master acts.";
        to may Scalar, "The addressed station where it is not the device (PROFIBUS).";
        covers may Covers, "The requirements that this step covers by itself.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    } [NotBoth(&covers, &about)]
}

key_set! {
    pub(crate) write_step "a step with `write`" {
        write must Written, "One request that changes something.";
        answer may Answer, "The right answer; by default the request is accepted.";
        instead may Instead, "What is changed in the right request.";
        r#as may Only("second"), "The second controller or master acts.";
        to may Scalar, "The addressed station where it is not the device (PROFIBUS).";
        covers may Covers, "The requirements that this step covers by itself.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    } [NotBoth(&covers, &about)]
}

key_set! {
    pub(crate) read_step "a step with `read`" {
        read must Access, "One request; each value is the right answer.";
        within may Duration, "The request is repeated until its answer is right, at most so long.";
        instead may Instead, "What is changed in the right request.";
        r#as may Only("second"), "The second controller or master acts.";
        to may Scalar, "The addressed station where it is not the device (PROFIBUS).";
        covers may CoversApart, "The requirements that this step covers by itself; a mapping gives each name its own.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
        otherwise may Text, "Why the trial is not applicable where this does not hold: for what a device may lack.";
    } [NotBoth(&covers, &about), NotBoth(&covers, &otherwise), NotBoth(&about, &otherwise)]
}

key_set! {
    pub(crate) send_step "a step with `send`" {
        send must Service, "One service without a value.";
        answer may Answer, "The right answer; by default the service is carried out.";
        r#as may Only("second"), "The second controller or master acts.";
        to may Scalar, "The addressed station where it is not the device (PROFIBUS).";
        repeats may Whole(1, 100), "How often each frame is sent again with the same frame count bit; each time the first answer is right (PROFIBUS).";
        covers may Covers, "The requirements that this step covers by itself.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    } [NotBoth(&covers, &about)]
}

key_set! {
    pub(crate) expect_step "a step with `expect`" {
        expect must Checks, "Checks what comes by itself.";
        within may Duration, "The deadline; by default `timing.reaction`.";
        r#for may Duration, "How long it then stays true.";
        until may Checks, "It then stays true up to the first sample at which this is true.";
        covers may CoversApart, "The requirements that this step covers by itself; a mapping gives each name its own.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
        otherwise may Text, "Why the trial is not applicable where this does not hold: for what a device may lack.";
    } [NotBoth(&r#for, &until), NotBoth(&covers, &about), NotBoth(&covers, &otherwise), NotBoth(&about, &otherwise)]
}

key_set! {
    pub(crate) wait_step "a step with `wait`" {
        wait must Duration, "Waits.";
    }
}

key_set! {
    pub(crate) save_step "a step with `save`" {
        save must NonEmptyMap(&Expression), "Saves values of this trial under names; the report shows them as well.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    }
}

key_set! {
    pub(crate) block_step "a block" {
        steps must NonEmpty(&Step), "A block of steps.";
        times may Whole(1, 0xFFFF_FFFF), "How often the block is done, once by default.";
        observe may NonEmpty(&Keys(&observed::KEYS)), "Rules over the block.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    }
}

key_set! {
    pub(crate) either_step "a step with `either`" {
        either must Readings, "Readings of the manual: the first that holds is taken; one with a `finding` is a fault that says so.";
        finding may Map(&Text), "For readings that are faults a sentence each.";
        about may Covers, "The requirements that a failure of this step is about; it ends the case, and nothing else is judged.";
    }
}

key_set! {
    pub(crate) procedure_step "a step with `do`" {
        r#do must Name, "Named steps.";
        give may Map(&Any), "What the procedure takes.";
        about may CoversOrCase, "The requirements that a failure in it is about, or `case`, whatever the procedure says; it ends the case.";
    }
}
