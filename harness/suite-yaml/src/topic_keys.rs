//! The keys of topic files, common suites and procedures.

use super::keys::WordChoices;

key_set! {
    pub(crate) topic "a topic file" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        suite must Name, "The name of the file.";
        defaults may Keys(&defaults::KEYS), "What all cases of the file begin with.";
        cases may NonEmpty(&Keys(&case::KEYS)), "The cases.";
        rules may NonEmpty(&Keys(&rule::KEYS)), "Rules that hold on every trace.";
    } [AnyOf(&[&cases, &rules])]
}

key_set! {
    pub(crate) defaults "defaults" {
        start may Start, "Merged key by key with the start of each case.";
        within may Duration, "The deadline of expectations that have none.";
        given may List(&Step), "Goes before what the case is given.";
        finally may List(&Step), "Goes after the case's own.";
    }
}

key_set! {
    pub(crate) case "a case" {
        id must Label, "Unique in the file.";
        why must Text, "One sentence.";
        covers may NonEmpty(&Name), "The requirements.";
        variants may NonEmpty(&Label), "The variants it runs on, all by default.";
        catches may NonEmpty(&Label), "Bugs of the reference device that must make this case fail, in each of its rows.";
        start may Start, "The connection it begins with, or `none`.";
        bit_timing may Flag, "The case is about bit times, which no serial line keeps: it does not run on a live bench.";
        with may Table, "A table: each entry is a trial; in a common suite also its columns, for which the manual gives the rows.";
        given may List(&Step), "Brings the device where the test begins.";
        steps must NonEmpty(&Step), "The test.";
        finally may List(&Step), "Runs always.";
    }
}

key_set! {
    pub(crate) rule "a rule" {
        id must Label, "Unique in the file.";
        why must Text, "One sentence.";
        covers may NonEmpty(&Name), "The requirements.";
        variants may NonEmpty(&Label), "The variants it is judged on, all by default.";
        catches may NonEmpty(&Label), "Bugs of the reference device that must break this rule.";
        always may Checks, "True at every sample at which it is known.";
        when may Condition, "The premise.";
        then may Checks, "What follows from the premise.";
        within may Duration, "The deadline after the premise.";
        r#for may Duration, "How long it stays true.";
        until may Checks, "It stays true up to the first sample at which this is true.";
    } [OneOf(&[&always, &when]), Together(&[&when, &then, &within]), With(&[&r#for, &until], &when), NotBoth(&r#for, &until)]
}

key_set! {
    pub(crate) row "a row of a table" {
        row may Text, "The label of the row; by default its first column.";
        covers may NonEmpty(&Name), "Requirements that only this row covers.";
        catches may NonEmpty(&Label), "Bugs that make only this row fail.";
        variants may NonEmpty(&Label), "The variants that it runs on, all by default.";
    }
}

key_set! {
    pub(crate) uses "a topic file that uses a common suite" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        suite must Name, "The name of the file.";
        r#use must Name, "The common suite.";
        defaults may Keys(&defaults::KEYS), "What all cases of the file begin with.";
        give may Map(&Any), "What the common suite takes.";
        covers may Map(&List(&Name)), "For each case and rule of the common suite the requirements that it covers here.";
        omit may Map(&Text), "Cases and rules of the common suite that are left out, with the reason.";
        variants may Map(&NonEmpty(&Label)), "For cases and rules of the common suite the variants that they run on here.";
        rows may Map(&NonEmpty(&Row)), "For cases of the common suite the rows of their tables.";
        catches may Map(&NonEmpty(&Label)), "For cases and rules of the common suite more bugs that make them fail here.";
        cases may NonEmpty(&Keys(&case::KEYS)), "Cases of this manual alone, beside those of the common suite.";
        rules may NonEmpty(&Keys(&rule::KEYS)), "Rules of this manual alone.";
    }
}

key_set! {
    pub(crate) common_suite "a common suite" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        common must Name, "The name of the file.";
        why must Text, "One sentence.";
        takes may Map(&Keys(&takes::KEYS)), "What a manual has to give.";
        cases may NonEmpty(&Keys(&case::KEYS)), "The cases.";
        rules may NonEmpty(&Keys(&rule::KEYS)), "Rules that hold on every trace.";
    } [AnyOf(&[&cases, &rules])]
}

/// What a common suite can take: the word, and what a manual has to write for it.
pub(super) static KINDS: WordChoices<&str> = WordChoices(&[
    ("parameter", "a parameter, as `P65000`"),
    ("number", "a number, or `=` and an expression"),
    ("bits", "bits by name, as `[parked, sensor_error]`, or a number"),
    ("word", "a word"),
    ("role", "a role, as `role.position`"),
    ("name", "a name of the device, as `G1_ZSW.parked`"),
    ("text", "a text in quotes"),
    ("bytes", "bytes in quotes, as \"40 .. 00\""),
    ("span", "a duration, as `20ms`, or a number of cycles"),
    ("words", "a list of single values, as `[read_only, limit]`"),
    ("values", "a mapping of names and values, as `{ G1_STW.park: 1 }`"),
    ("condition", "a condition, as `G1_ZSW.parked and not G1_ZSW.sensor_error`"),
    ("requirements", "a list of requirements, or `none`"),
    ("any", "any value that fits where it is used"),
]);

key_set! {
    pub(crate) takes "an entry of takes" {
        is must Word(&KINDS), "What is taken.";
        why must Text, "One sentence.";
    }
}

key_set! {
    pub(crate) procedures "a file of procedures" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        procedures must Map(&Keys(&procedure::KEYS)), "Named steps.";
    }
}

key_set! {
    pub(crate) procedure "a procedure" {
        takes must List(&Label), "Names that are replaced in the steps by what `give` says.";
        steps must NonEmpty(&Step), "The steps; none of them does another procedure.";
        about may Covers, "The requirements that a failure in it is about; it ends the case, and nothing else is judged.";
    }
}

key_set! {
    pub(crate) exchanged "an entry of exchange" {
        set may Settings, "What is set at its begin.";
        expect may Checks, "What the answer of each cycle shows (PROFIBUS).";
        times may Whole(0, 0xFFFF_FFFF), "How many cycles, one by default; 0 leaves the entry out.";
    }
}

key_set! {
    pub(crate) turn "a turn" {
        revolutions may Number, "How far in revolutions, clockwise positive.";
        counts may Number, "How far in hardware steps.";
        degrees may Number, "How far in degrees.";
        rpm may Number, "How fast, 60 by default.";
    } [OneOf(&[&revolutions, &counts, &degrees])]
}

key_set! {
    pub(crate) observed "an observed rule" {
        always may Checks, "True at every sample at which it is known.";
        when may Condition, "The premise.";
        then may Checks, "What follows from the premise.";
        within may Duration, "The deadline after the premise.";
        r#for may Duration, "How long it stays true.";
        until may Checks, "It stays true up to the first sample at which this is true.";
        count may Condition, "The number of frames or events at which this is true is counted.";
        sequence may NonEmpty(&Condition), "The values of these, one after the other, equal neighbours taken as one.";
        is may Observation, "The right number, or the right sequence.";
    } [
        OneOf(&[&always, &when, &count, &sequence]),
        Together(&[&when, &then, &within]),
        With(&[&r#for, &until], &when),
        NotBoth(&r#for, &until),
        OneOf(&[&is, &always, &when]),
    ]
}
