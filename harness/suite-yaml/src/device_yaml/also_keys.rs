//! The keys of `also`: what a manual says of a suite for any device that it uses too.

key_set! {
    pub(crate) also "a suite that is used too" {
        give may Map(&Any), "What its topics are given instead of what is given in its own folder; `module` is also the module that their cases connect.";
        except may Names(&FilledText), "Its topics, cases (`topic/case`) and rows (`topic/case[row]`) that are left out, each with the reason.";
        contradicted may Names(&Keys(&contradicted::KEYS)), "The same, where the manual says otherwise.";
    }
}

key_set! {
    pub(crate) contradicted "what a manual contradicts" {
        cites must FilledText, "The clause of the manual.";
        why must FilledText, "What it says.";
    }
}
