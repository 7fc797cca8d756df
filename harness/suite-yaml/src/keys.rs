//! The closed key sets of suite files: name, whether it must be there, what stands behind it, and one sentence.
//!
//! The loader refuses what is not in these tables and `encspec schema` is made from them, so they cannot drift apart.

use super::error::{Mistake, Read};
use super::yaml::Node;

/// What stands behind a key, as far as a schema can say it.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Free text.
    Text,
    /// A name that is declared here.
    Label,
    /// A name that is declared elsewhere.
    Name,
    /// One of these words.
    Word(&'static [&'static str]),
    /// A number.
    Number,
    /// A text, or one with its origin.
    SourcedText,
    /// Only `true`; a flag that is not set is left out.
    Flag,
    /// A duration or a number of cycles.
    Duration,
    /// A condition.
    Condition,
    /// A condition, or a mapping of names and what they have to be.
    Checks,
    /// Whatever the place asks for.
    Any,
    /// A mapping of names and values.
    Values,
    /// A list.
    List(&'static Shape),
    /// A mapping with names of its own, all values alike.
    Map(&'static Shape),
    /// A mapping with these keys.
    Keys(&'static KeySet),
    /// A step: one verb and its modifiers.
    Step,
    /// A bit, a pair of bits, or a mapping.
    Bits,
    /// A list of rows, or a mapping of columns as in `takes`.
    Table,
}

/// A key.
#[derive(Debug)]
pub struct Key {
    /// The key as it is written.
    pub name: &'static str,
    /// Whether the mapping needs it.
    pub required: bool,
    /// What its value looks like.
    pub shape: Shape,
    /// What it is for.
    pub sentence: &'static str,
}

/// A closed set of keys.
#[derive(Debug)]
pub struct KeySet {
    /// What has these keys, with its article.
    pub what: &'static str,
    /// The keys in the order of the schema.
    pub keys: &'static [Key],
}

macro_rules! key_sets {
    ($($name:ident $what:literal { $($key:literal $must:ident $shape:expr, $sentence:literal;)* })*) => {
        $(#[doc = $what]
        pub static $name: KeySet = KeySet {
            what: $what,
            keys: &[$(Key { name: $key, required: key_sets!(@$must), shape: $shape, sentence: $sentence }),*],
        };)*

        /// Every key set, by the name of its table.
        pub static ALL: &[(&str, &KeySet)] = &[$((stringify!($name), &$name)),*];
    };
    (@must) => { true };
    (@may) => { false };
}

use Shape::*;

key_sets! {
    TOPIC "a topic file" {
        "suite" must Label, "The name of the file.";
        "defaults" may Keys(&DEFAULTS), "What all cases of the file begin with.";
        "cases" may List(&Keys(&CASE)), "The cases.";
        "rules" may List(&Keys(&RULE)), "Rules that hold on every trace.";
    }
    USE "a topic file that uses a common suite" {
        "suite" must Label, "The name of the file.";
        "use" must Name, "The common suite.";
        "defaults" may Keys(&DEFAULTS), "What all cases of the file begin with.";
        "give" may Values, "What the common suite takes.";
        "covers" may Map(&List(&Name)), "For each case and rule of the common suite the requirements that it covers here.";
        "omit" may Map(&Text), "Cases and rules of the common suite that are left out, with the reason.";
        "variants" may Map(&List(&Name)), "For cases and rules of the common suite the variants that they run on here.";
        "rows" may Map(&List(&Values)), "For cases of the common suite the rows of their tables.";
        "catches" may Map(&List(&Name)), "For cases and rules of the common suite more bugs that make them fail here.";
        "cases" may List(&Keys(&CASE)), "Cases of this manual alone, beside those of the common suite.";
        "rules" may List(&Keys(&RULE)), "Rules of this manual alone.";
    }
    COMMON "a common suite" {
        "common" must Label, "The name of the file.";
        "why" must Text, "One sentence.";
        "takes" may Map(&Keys(&TAKES)), "What a manual has to give.";
        "cases" may List(&Keys(&CASE)), "The cases.";
        "rules" may List(&Keys(&RULE)), "Rules that hold on every trace.";
    }
    TAKES "an entry of takes" {
        "is" must Word(TAKEN), "What is taken.";
        "why" must Text, "One sentence.";
    }
    PROCEDURES "a file of procedures" {
        "procedures" must Map(&Keys(&PROCEDURE)), "Named steps.";
    }
    PROCEDURE "a procedure" {
        "takes" must List(&Label), "Names that are replaced in the steps by what `give` says.";
        "steps" must List(&Step), "The steps; none of them does another procedure.";
    }
    DEFAULTS "defaults" {
        "start" may Values, "Merged key by key with the start of each case.";
        "within" may Duration, "The deadline of expectations that have none.";
        "given" may List(&Step), "Goes before what the case is given.";
        "finally" may List(&Step), "Goes after the case's own.";
    }
    CASE "a case" {
        "id" must Label, "Unique in the file.";
        "why" must Text, "One sentence.";
        "covers" may List(&Name), "The requirements.";
        "variants" may List(&Name), "The variants it runs on, all by default.";
        "catches" may List(&Name), "Bugs of the reference device that must make this case fail, in each of its rows.";
        "start" may Values, "The connection it begins with, or `none`.";
        "with" may Table, "A table: each entry is a trial; in a common suite also its columns, for which the manual gives the rows.";
        "given" may List(&Step), "Brings the device where the test begins.";
        "steps" must List(&Step), "The test.";
        "finally" may List(&Step), "Runs always.";
    }
    RULE "a rule" {
        "id" must Label, "Unique in the file.";
        "why" must Text, "One sentence.";
        "covers" may List(&Name), "The requirements.";
        "variants" may List(&Name), "The variants it is judged on, all by default.";
        "catches" may List(&Name), "Bugs of the reference device that must break this rule.";
        "always" may Condition, "True at every sample at which it is known.";
        "when" may Condition, "The premise.";
        "then" may Checks, "What follows from the premise.";
        "within" may Duration, "The deadline after the premise.";
        "for" may Duration, "How long it stays true.";
        "until" may Condition, "It stays true up to the first sample at which this is true.";
    }
    OBSERVED "an observed rule" {
        "always" may Condition, "True at every sample at which it is known.";
        "when" may Condition, "The premise.";
        "then" may Checks, "What follows from the premise.";
        "within" may Duration, "The deadline after the premise.";
        "for" may Duration, "How long it stays true.";
        "until" may Condition, "It stays true up to the first sample at which this is true.";
        "count" may Condition, "The number of frames or events at which this is true is counted.";
        "sequence" may List(&Condition), "The values of these, one after the other, equal neighbours taken as one.";
        "is" may Any, "The right number, or the right sequence.";
    }
    EXCHANGED "an entry of exchange" {
        "set" may Values, "What is set at its begin.";
        "expect" may Checks, "What the answer of each cycle shows (PROFIBUS).";
        "times" may Number, "How many cycles, one by default; 0 leaves the entry out.";
    }
    TURN "a turn" {
        "revolutions" may Number, "How far in revolutions, clockwise positive.";
        "counts" may Number, "How far in hardware steps.";
        "degrees" may Number, "How far in degrees.";
        "rpm" may Number, "How fast, 60 by default.";
    }

    REQUIREMENTS "a file of requirements" {
        "source" may Word(SOURCES), "The source of each requirement of the file that names none itself.";
        "channel" may Word(CHANNELS), "The channel of each requirement of the file that names none itself.";
        "requirements" must List(&Keys(&REQUIREMENT)), "The requirements of one topic of the manual.";
    }
    REQUIREMENT "a requirement" {
        "id" must Label, "Its id, unique in the manual; it stays when the requirement moves.";
        "cites" must Text, "The clause: section, table, page.";
        "statement" must Text, "What the clause says of the device, in one sentence of our own.";
        "level" must Word(LEVELS), "How strict it is; `must` only where the manual says it without ambiguity.";
        "source" may Word(SOURCES), "Who says it: the manual, a profile that it refers to, or common practice; by default as the file says.";
        "channel" may Word(CHANNELS), "Where it can be observed; by default as the file says.";
        "variants" may List(&Name), "The variants that it applies to, all by default.";
        "ambiguity" may Text, "What the manual leaves open, and the reading that was chosen.";
        "class" may Word(CLASSES), "Why no case can cover it; without a class it can be tested.";
        "reason" may Text, "The reason of its class.";
        "reading" may Text, "With `class: contradictory`: the reading that was chosen.";
    }
    BUGS "a list of bugs" {
        "bugs" must Map(&List(&Name)), "For each bug of the reference device the requirements that it breaks.";
    }
    LEDGER "a ledger of known failures" {
        "known_failures" must List(&Keys(&KNOWN_FAILURE)), "The failures that are known and followed.";
    }
    KNOWN_FAILURE "a known failure" {
        "test" must Text, "The test, `SUITE/CASE[ROW]` with or without the manual in front; `*` stands for any letters.";
        "device" must Name, "The manual.";
        "variant" may Name, "The variant, every one by default.";
        "firmware" may Keys(&FIRMWARE), "The firmware that has the failure, every one by default.";
        "reason" must Text, "Why it fails, in one sentence.";
        "ticket" must Text, "Where the failure is followed.";
        "expires" must Text, "The last day on which the entry excuses anything, as YYYY-MM-DD.";
        "signature" must Text, "How it fails, as the JSON report has it under `signature`; `*` stands for any letters.";
    }
    FIRMWARE "a range of firmware" {
        "from" may Text, "The first firmware that has the failure.";
        "to" may Text, "The last one.";
    }
    MASKS "masks.yaml" {
        "masks" must Map(&Text), "Names that are not compared with a capture, each with the reason.";
        "tolerance" may Number, "By how many cycles a value may come earlier or later than recorded, 5 by default.";
        "noise" may Number, "By how many steps a measured number may differ, 0 by default.";
        "periods" may Map(&Duration), "Names that are measured anew only once in this time: while the shaft turns they may come so much earlier or later.";
    }

    DEVICE "device.yaml" {
        "device" must Label, "The name of the folder.";
        "bus" must Word(&["profinet", "profibus"]), "The bus.";
        "title" must Text, "The title for people.";
        "identity" must Keys(&IDENTITY), "Who it is.";
        "variants" must List(&Label), "The variants.";
        "timing" must Keys(&TIMING), "The times that the manual gives.";
        "rt_class" may Number, "The class of its cyclic frames, 1 or 2 (PROFINET); 1 by default.";
        "constants" may Map(&Any), "One number, or one for each variant.";
        "words" may Map(&Map(&Number)), "Tables of words and their numbers.";
        "derived" may Map(&Condition), "Expressions over start parameters and constants.";
        "signals" must Map(&Keys(&SIGNAL)), "What goes over the cyclic exchange.";
        "network" may Map(&Number), "The interface and the ports: by subslot of slot 0 the ident of the submodule.";
        "submodules" must Map(&Keys(&SUBMODULE)), "Submodules.";
        "modules" must Map(&Keys(&MODULE)), "What one connection consists of.";
        "records" may Map(&Keys(&RECORD)), "Records.";
        "parameters" may Map(&Keys(&PARAMETER)), "Parameters of the base mode parameter access.";
        "parameter_access" may Keys(&PARAMETER_ACCESS), "How the parameters are reached, where it is not as the drive profile has it.";
        "codes" may Map(&Map(&Number)), "Code tables of the manual.";
        "stand" may Keys(&STAND), "What a stand can do with it.";
        "roles" may Map(&List(&Name)), "Device-independent names.";
        "changes" may Keys(&CHANGES), "What changes the device for good.";
        "pages" may Map(&Keys(&PAGE)), "Its web pages.";
    }
    SLAVE "device.yaml of a device on PROFIBUS" {
        "device" must Label, "The name of the folder.";
        "bus" must Word(&["profinet", "profibus"]), "The bus.";
        "title" must Text, "The title for people.";
        "identity" must Keys(&SLAVE_IDENTITY), "Who it is.";
        "address" must Number, "The station address that a trial finds it at, as its switches are then.";
        "variants" must List(&Label), "The variants.";
        "timing" must Keys(&TIMING), "The times that the manual gives.";
        "constants" may Map(&Any), "One number, or one for each variant.";
        "words" may Map(&Map(&Number)), "Tables of words and their numbers.";
        "derived" may Map(&Condition), "Expressions over start parameters and constants.";
        "signals" must Map(&Keys(&SIGNAL)), "What goes over the cyclic exchange.";
        "modules" must Map(&Keys(&SLAVE_MODULE)), "What one connection consists of.";
        "set_prm" may Keys(&SET_PRM), "The octets of Set_Prm behind the seven that every slave has.";
        "diagnosis" must Keys(&DIAGNOSIS), "What Slave_Diag holds besides what every slave has.";
        "parameters" may Map(&Keys(&PARAMETER)), "Parameters of the base mode parameter access.";
        "parameter_access" may Keys(&SLAVE_PARAMETER_ACCESS), "How the parameters are reached, where it is not data set 47 of slot 0.";
        "codes" may Map(&Map(&Number)), "Code tables of the manual.";
        "stand" may Keys(&STAND), "What a stand can do with it.";
        "roles" may Map(&List(&Name)), "Device-independent names.";
        "changes" may Keys(&CHANGES), "What changes the device for good.";
    }
    SLAVE_IDENTITY "identity on PROFIBUS" {
        "ident" must Number, "The ident number that PI gave to the type of device.";
    }
    SLAVE_MODULE "a module on PROFIBUS" {
        "cfg" must Text, "The identifiers that Chk_Cfg sends for it.";
        "octets" must Keys(&OCTETS), "Lengths of its cyclic data.";
        "outputs" may List(&Name), "Signals of its output data in order.";
        "inputs" may List(&Name), "Signals of its input data in order.";
        "fixes" may Values, "Start parameters that go with it where a case does not say them.";
        "from_source" may Word(ORIGINS), "Where its identifiers come from if the manual does not print them.";
    }
    SET_PRM "set_prm" {
        "octets" must Number, "How many user octets there are behind those of DP-V1.";
        "dpv1" may Text, "The three octets of DP-V1 that a connection sends; left out where the slave has none.";
        "structured" may Flag, "The slave takes structured blocks, which isochronous mode needs.";
        "fields" must Map(&Keys(&RECORD_FIELD)), "The fields of the user octets: the start parameters.";
        "from_source" may Word(ORIGINS), "Where the layout comes from if the manual does not print it.";
    }
    DIAGNOSIS "diagnosis" {
        "octets" must List(&Number), "The lengths that it can have; with `blocks` the shortest and the longest.";
        "fields" may Map(&Keys(&DIAGNOSIS_FIELD)), "Fields at fixed places.";
        "blocks" may Keys(&DIAGNOSIS_BLOCKS), "Blocks that are all alike, one for each error.";
    }
    DIAGNOSIS_FIELD "a field of the diagnosis" {
        "byte" may Number, "The byte it lies in, counted from 0 at the first of the six that every slave has.";
        "bytes" may List(&Number), "Its first and its last byte.";
        "bit" may Number, "Its bit in the byte.";
        "bits" may List(&Number), "Its lowest and its highest bit in the byte.";
        "signed" may Flag, "It is a two's complement.";
        "words" may Name, "The table of its words.";
        "from_source" may Word(ORIGINS), "Where its place comes from if the manual does not print it.";
    }
    DIAGNOSIS_BLOCKS "blocks of the diagnosis" {
        "after" must Number, "How many bytes stand before the first one.";
        "bytes" must Text, "The bytes of one; `..` where the code stands.";
        "code" must Name, "The table of `codes` with the words for the codes.";
    }
    SLAVE_PARAMETER_ACCESS "parameter_access on PROFIBUS" {
        "index" may Number, "Index of the data set; 47 by default.";
        "slot" may Number, "Its slot; 0 by default.";
        "do_id" may Number, "The drive object that is asked, 1 to 255; 1 by default.";
        "save" may Name, "The parameter that saves the others; P971 by default.";
    }
    PARAMETER_ACCESS "parameter_access" {
        "index" may Number, "Index of its record; 0xB02E by default.";
        "at" may Name, "The submodule that its record stands at; by default the one of the module in use that the records of the start-up go to.";
        "do_id" may Number, "The drive object that is asked, 1 to 255; 1 by default.";
        "save" may Name, "The parameter that saves the others; P971 by default.";
    }
    CHANGES "changes" {
        "position_reference" may List(&Name), "Outputs, parameters and records that give the present place another value.";
        "nvm_write" may List(&Name), "Outputs, parameters and records that make it write its memory, besides `permanent` parameters.";
        "factory_reset" may List(&Name), "Outputs, parameters and records that bring back what it was delivered with, besides DCP.";
        "firmware" may List(&Name), "Forms of web pages that let it wait for another firmware.";
    }
    PAGE "a web page" {
        "path" must Text, "Where it is, from the first slash on.";
        "fields" may Map(&Text), "The fields of its form: a name, and the one in the page.";
        "shows" may Map(&Keys(&PAGE_VALUE)), "The values that it shows, each under a name that is unique among all pages.";
        "from_source" may Word(ORIGINS), "Where all this comes from if the manual does not print it.";
    }
    PAGE_VALUE "a value on a web page" {
        "behind" must Text, "The text in front of it, as a reader sees the page.";
        "form" must Word(FORMS), "How it is written.";
        "steps" may Flag, "It is a place in steps.";
        "words" may Name, "The table of its words.";
    }
    BENCH_PAGE "a web page of a bench" {
        "path" may Text, "Where it is; without it where device.yaml says.";
        "fields" may Map(&Text), "The fields of its form that have other names than in device.yaml.";
        "shows" may Map(&Text), "The texts in front of its values, where they are others.";
    }
    IDENTITY "identity" {
        "vendor_id" must Number, "Vendor ID of PI.";
        "device_id" must Number, "Device ID of the vendor.";
        "station_type" must SourcedText, "Type of station as DCP shows it.";
    }
    SOURCED "a datum with its origin" {
        "value" must Any, "The datum.";
        "from_source" must Word(ORIGINS), "Where it comes from.";
    }
    TIMING "timing" {
        "reaction" must Duration, "The deadline of an expectation without `within`.";
        "start" must Duration, "From Connect to the first good sample, at most.";
        "power_up" must Duration, "From power to an answer, at most.";
        "save" must Duration, "Saving, at most.";
    }
    SIGNAL "a signal" {
        "from" must Word(&["controller", "device"]), "Who sends it.";
        "width" must Number, "In bits: 8, 16, 32 or 64.";
        "signed" may Flag, "It is a two's complement.";
        "position_in" may Condition, "The size of the circle on which it is a place.";
        "shift" may Any, "By how many bits it stands further left than its lowest step, one number or one for each variant; its name speaks in steps.";
        "fields" may Map(&Bits), "Its bits and groups of bits, counted as they are on the wire.";
        "from_source" may Word(ORIGINS), "Where it comes from if the manual does not print it.";
    }
    FIELD "a field of a signal or element" {
        "bit" may Number, "Its bit; 0 is the lowest.";
        "bits" may List(&Number), "Its lowest and its highest bit.";
        "signed" may Flag, "It is a two's complement.";
        "words" may Name, "The table of its words.";
        "counts" may List(&Number), "The first and the last number that it counts through by itself.";
    }
    SUBMODULE "a submodule" {
        "slot" must Number, "Slot number.";
        "subslot" must Number, "Subslot number.";
        "api" may Number, "API, 0 by default.";
        "ident" must Number, "Ident number.";
        "module_ident" may Any, "Ident number of the module it is part of, one or one for each variant, where it is not that of the module in use; in slot 0: where it is not its own.";
        "octets" may Keys(&OCTETS), "Lengths of its cyclic data.";
        "outputs" may List(&Name), "Signals of its output data in order.";
        "inputs" may List(&Name), "Signals of its input data in order.";
        "from_source" may Word(ORIGINS), "Where its ident comes from if the manual does not print it.";
    }
    OCTETS "octets" {
        "out" must Number, "Octets of output data.";
        "in" must Number, "Octets of input data.";
    }
    MODULE "a module" {
        "ident" must Number, "Ident number.";
        "submodules" must List(&Name), "Its submodules.";
        "from_source" may Word(ORIGINS), "Where its ident comes from if the manual does not print it.";
    }
    RECORD "a record" {
        "index" must Number, "Index.";
        "at" must Name, "The submodule it is read from and written to.";
        "octets" must Number, "Its length.";
        "start" may Flag, "It is part of the start-up.";
        "with" may List(&Name), "The modules with whose start-up it is sent; all by default.";
        "fields" must Map(&Keys(&RECORD_FIELD)), "Its fields.";
        "from_source" may Word(ORIGINS), "Where its layout comes from if the manual does not print it.";
    }
    RECORD_FIELD "a field of a record" {
        "octet" may Number, "The octet it lies in.";
        "octets" may List(&Number), "Its first and its last octet.";
        "bit" may Number, "Its bit in the octet.";
        "bits" may List(&Number), "Its lowest and its highest bit in the octet.";
        "words" may Name, "The table of its words.";
        "text" may Flag, "Its octets are text.";
        "default" may Any, "Its documented default.";
        "from" may Any, "The lowest number that the manual allows.";
        "to" may Any, "The highest number that the manual allows.";
        "from_source" may Word(ORIGINS), "Where its place comes from if the manual does not print it.";
    }
    PARAMETER "a parameter" {
        "type" must Word(TYPES), "The type of its elements.";
        "octets" may Number, "For bytes and text: how many.";
        "access" must Word(&["read", "read_write"]), "Whether it can be written.";
        "default" may Any, "Its default.";
        "permanent" may Flag, "A write changes the device for good.";
        "elements" may Map(&Number), "Names and subindices of its elements.";
        "bits" may Map(&Any), "Names of bits, of the parameter or of an element.";
        "from_source" may Word(ORIGINS), "Where it comes from if the manual does not print it.";
    }
    STAND "stand" {
        "faults" may Map(&Text), "Conditions of the encoder that the manual describes.";
        "buttons" may Map(&Text), "Buttons and where each is.";
        "switches" may Map(&List(&Number)), "Coding switches with their lowest and highest position, then the one that a trial finds and that they are put back to, by default the lowest.";
        "supply" may Keys(&SUPPLY), "The supply and the temperature that a trial finds and that they are put back to.";
        "leds" may Map(&List(&Label)), "LEDs and what each can show.";
        "counters" may Map(&Text), "Counters.";
    }

    SUPPLY "supply" {
        "voltage" may Number, "In volts.";
        "temperature" may Number, "In degrees Celsius.";
    }

    BENCH "a bench file" {
        "device" must Name, "The manual and the variant that it claims to be, as `manual/variant`; `none` for a device without a manual.";
        "description" may Text, "With `device: none`: a file that describes it in the words of device.yaml.";
        "link" must Text, "Where it is: `nic:INTERFACE`, `socket:ADDRESS` for Ethernet frames on a stream as QEMU has them, or `serial:TTY` for a PROFIBUS.";
        "line" may Keys(&BENCH_LINE), "What the PROFIBUS at a serial line is like.";
        "station_name" may Text, "Its station name; without it the only station that fits the claim is meant.";
        "mac" may Text, "Its MAC address, where it has to be this one.";
        "ip" may Text, "The address that it is given; without it the one that it has.";
        "mask" may Text, "The mask of the segment, 255.255.255.0 by default.";
        "controller" may Keys(&BENCH_CONTROLLER), "Our own addresses on the segment.";
        "cycle" may Duration, "The cycle of connections that say none.";
        "watchdog" may Duration, "The watchdog of connections that say none.";
        "persona" may Name, "In the manner of which controller the device is addressed; that of the command line wins.";
        "boot_time" may Duration, "From power to an answer, at most, where it differs from the manual.";
        "gsdml" may Text, "The vendor's GSDML, a file (PROFINET).";
        "gsd" may Text, "The vendor's GSD, a file (PROFIBUS).";
        "telegrams" may List(&Name), "The modules that it supports, by their names in device.yaml; all by default.";
        "lacks" may List(&Name), "Records and parameters of device.yaml that it does not have.";
        "firmware" may Text, "The firmware that it is said to have, as I&M0 tells it: `1.1.0`.";
        "ledger" may Text, "The ledger of its known failures, a file.";
        "direct_cable" may Flag, "Our cable ends at the device, with no switch between, at which LLDP stops; `true` or left out.";
        "position_noise" may Number, "By how many steps a place may differ, because the shaft is never quite still; 0 by default.";
        "pages" may Map(&Keys(&BENCH_PAGE)), "Its web pages whose looks the manual does not print, as they are on this device.";
        "stand" may Keys(&BENCH_STAND), "What holds it; without it nobody does.";
        "consent" may Keys(&BENCH_CONSENT), "What may be done to it that lasts; without it nothing.";
    }
    PERSONA "a persona" {
        "persona" must Label, "The name of the file, which `--persona` takes; it says a trait, not a product.";
        "why" must Text, "One sentence: what is special about it.";
        "source" must Text, "Where it was seen: a capture and its frames, an address, or `invented`.";
        "station_name" may Text, "The name of the controller's station in the Connect.";
        "start_up" may Word(START_UPS), "Which start-up it asks for; `legacy` by default.";
        "byte_order" may Word(BYTE_ORDERS), "The byte order of its RPC; `big` by default.";
        "blocks" may Keys(&PERSONA_BLOCKS), "The blocks of the Connect after the ARBlockReq.";
        "write" may Word(WRITES), "Whether start-up records go one by one or in one; `single` by default.";
        "records" may Word(RECORD_ORDERS), "The order of the start-up records; `listed` by default.";
        "expects" may Word(EXPECTED), "Which submodules it expects besides those of the module; `access_point` by default.";
        "cycle" may Keys(&PERSONA_CYCLE), "The cycle of connections that say none.";
        "factors" may Keys(&PERSONA_FACTORS), "How many cycles without a frame it takes; what a case says of its watchdog wins.";
        "class" may Keys(&PERSONA_CLASS), "The class of the cyclic frames.";
        "tags" may Keys(&PERSONA_TAGS), "The tags of its frames.";
        "references" may Keys(&PERSONA_REFERENCES), "The numbers that it gives its connections.";
        "rta" may Keys(&PERSONA_RTA), "How it takes alarms.";
        "activity_timeout" may Number, "How long the device waits for its next step, in units of 100 ms; 1 to 1000, 600 by default.";
        "args_max" may Number, "How many octets of an answer to Connect it says it can take, 4096 by default.";
        "reconnect" may Keys(&PERSONA_RECONNECT), "What it does after a connection was lost.";
    }
    PERSONA_BLOCKS "blocks" {
        "order" may List(&Word(CONNECT_PARTS)), "The order of the blocks; `inputs, outputs, submodules, alarms, extra` by default.";
        "extra" may List(&Text), "Whole blocks with their headers that are passed along as they are, in hexadecimal octets.";
    }
    PERSONA_CYCLE "cycle" {
        "send_clock" may Number, "The send clock in units of 31.25 us, 1 to 128; 32 by default.";
        "reduction" may Number, "A frame in each n-th send clock, a power of two up to 512; 2 by default.";
        "phase_in" may Number, "The phase of the inputs, 1 to the reduction; 1 by default.";
        "phase_out" may Number, "The phase of the outputs, 1 to the reduction; 1 by default.";
    }
    PERSONA_FACTORS "factors" {
        "watchdog" must Number, "Cycles without a frame until a consumer objects.";
        "data_hold" may Number, "Cycles without a frame until the connection ends; the watchdog by default.";
    }
    PERSONA_CLASS "class" {
        "rt" must Number, "The class: 1 or 2.";
        "frame_id_in" may Number, "The frame id that is proposed for the inputs.";
        "frame_id_out" may Number, "The frame id that is proposed for the outputs; 0xFFFF, the default, leaves it to the device.";
    }
    PERSONA_TAGS "tags" {
        "frames" may Word(TAGGED), "Whether its cyclic frames and alarms carry tags; `tagged` by default.";
        "cyclic" may Number, "The tag of cyclic frames, 0xC000 by default.";
        "alarm_high" may Number, "The tag of alarms of high priority, 0xC000 by default.";
        "alarm_low" may Number, "The tag of alarms of low priority, 0xA000 by default.";
    }
    PERSONA_REFERENCES "references" {
        "inputs" may Number, "IOCRReference of the inputs, 1 by default.";
        "outputs" may Number, "IOCRReference of the outputs, 2 by default.";
        "alarm" may Number, "LocalAlarmReference; by default a new one for each connection.";
    }
    PERSONA_RTA "rta" {
        "timeout" may Number, "How long it waits for an acknowledgement, in units of 100 ms; 1 to 100, 1 by default.";
        "retries" may Number, "How often it repeats; 3 to 15, 3 by default.";
        "max_alarm" may Number, "The most octets of an alarm that it takes; 200 to 1432, 200 by default.";
    }
    PERSONA_RECONNECT "reconnect" {
        "after" must Duration, "How long after the loss it connects again.";
        "uuid" must Word(UUIDS), "Whether the connection has the same name again or a new one.";
    }
    BENCH_CONTROLLER "controller" {
        "ip" may Text, "Our IP address; without it one of the subnet that nobody has.";
        "mac" may Text, "Our MAC address; without it one derived from the interface's.";
    }
    BENCH_LINE "line" {
        "baud" may Number, "Bits in a second, 1500000 by default on a pseudoterminal and 19200 on any other line.";
        "parity" may Word(PARITIES), "The parity bit; PROFIBUS has `even`, the default.";
        "slot_time" may Number, "How many bit times an answer is waited for; by default those of the standard, and 20 ms at least.";
        "max_tsdr" may Number, "How many bit times a slave takes to answer at most; by default those of the standard.";
        "driver" may Word(DRIVERS), "Which hardware switches the driver of the RS-485 adapter; needed on any line but a pseudoterminal.";
        "echo" may Flag, "The adapter lets what we send come back; `true` or left out.";
        "address" may Number, "The station address that the device has, by default that of device.yaml.";
        "masters" may List(&Number), "The addresses of our masters, `[1, 2]` by default.";
    }
    BENCH_STAND "stand" {
        "control" may Text, "A Unix socket that understands the control lines, as `encspec serve --control` makes one.";
        "hooks" may Map(&Text), "For a name that is set or looked at, the command that does it; `{value}` stands for the value.";
        "ask" may List(&Name), "Names that somebody sets who is asked at the terminal.";
        "shaft" may List(&Text), "How the shaft can be moved: `hand`, `position(\u{b1}STEPS)`, `speed(\u{b1}RPM)`.";
    }
    BENCH_CONSENT "consent" {
        "factory_reset" may Flag, "It may be reset to factory settings.";
        "set_name" may Flag, "Its station name may be changed; it is put back.";
        "set_ip" may Flag, "Its address may be changed; it is put back.";
        "set_address" may Flag, "Its station address may be changed over the bus; it is put back (PROFIBUS).";
        "nvm_write" may Number, "So many times in a run its memory may be written, 0 by default.";
        "position_reference" may Flag, "Its position may be preset: a machine around it loses its reference.";
        "firmware" may Flag, "It may be told to wait for another firmware, which stops its web server.";
        "alone" may Flag, "Nothing else is on the segment that could be disturbed.";
    }
}

/// Parities of a serial line.
pub const PARITIES: &[&str] = &["even", "odd", "none"];
/// Who switches the driver of an RS-485 adapter.
pub const DRIVERS: &[&str] = &["adapter", "port"];
/// Start-ups.
pub const START_UPS: &[&str] = &["legacy", "advanced"];
/// Byte orders.
pub const BYTE_ORDERS: &[&str] = &["big", "little"];
/// How start-up records are written.
pub const WRITES: &[&str] = &["single", "multiple"];
/// In which order start-up records are written.
pub const RECORD_ORDERS: &[&str] = &["listed", "reversed"];
/// Which submodules a persona expects.
pub const EXPECTED: &[&str] = &["module", "access_point", "interface_and_ports"];
/// The parts of a Connect.
pub const CONNECT_PARTS: &[&str] = &["inputs", "outputs", "submodules", "alarms", "extra"];
/// Whether frames carry tags.
pub const TAGGED: &[&str] = &["tagged", "untagged"];
/// The name of a connection that is made again.
pub const UUIDS: &[&str] = &["same", "new"];
/// What a common suite can take.
pub const TAKEN: &[&str] = &[
    "parameter",
    "number",
    "bits",
    "word",
    "role",
    "name",
    "text",
    "bytes",
    "span",
    "words",
    "values",
    "condition",
    "requirements",
    "any",
];
/// How strict a requirement is.
pub const LEVELS: &[&str] = &["must", "should", "info"];
/// Who says what is required.
pub const SOURCES: &[&str] = &["manual", "profile", "convention"];
/// Where a requirement can be observed.
pub const CHANNELS: &[&str] = &["cyclic", "acyclic", "startup", "record", "dcp", "alarm", "web", "model", "diagnosis"];
/// Why no case can cover a requirement.
pub const CLASSES: &[&str] = &["implicit", "untestable", "out-of-scope", "contradictory"];
/// Where a datum can come from that the manual does not print.
pub const ORIGINS: &[&str] = &["description", "invented"];
/// How values are written on web pages.
pub const FORMS: &[&str] = &["decimal", "hexadecimal", "text"];
/// Types of parameters.
pub const TYPES: &[&str] = &["u8", "u16", "u32", "u64", "i8", "i16", "i32", "i64", "bytes", "text"];

impl KeySet {
    /// The names of the keys.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.keys.iter().map(|key| key.name)
    }
}

/// A mapping whose keys were found to be in their set.
#[derive(Clone, Copy)]
pub struct Keyed<'n> {
    /// The mapping.
    pub node: &'n Node,
}

impl<'n> Keyed<'n> {
    /// Checks the keys of `node` against `set`.
    pub fn new(node: &'n Node, set: &'static KeySet) -> Read<Keyed<'n>> {
        for (key, _) in node.entries(set.what)? {
            let name = key.text("a key")?;
            if !set.names().any(|known| known == name) {
                return Err(Mistake::unknown(key.spot, &format!("key of {}", set.what), name, set.names()));
            }
        }
        match set.keys.iter().find(|key| key.required && node.get(key.name).is_none()) {
            Some(key) => Err(node.wrong(format!("{} needs the key `{}`", set.what, key.name)).help(key.sentence)),
            None => Ok(Keyed { node }),
        }
    }

    /// The value of a key that may be missing.
    pub fn get(&self, key: &str) -> Option<&'n Node> {
        self.node.get(key)
    }

    /// The value of a key that the set requires.
    pub fn must(&self, key: &str) -> Read<&'n Node> {
        self.node.get(key).ok_or_else(|| self.node.wrong(format!("the key `{key}` is missing")))
    }

    /// The key's own node, to point at.
    pub fn key(&self, key: &str) -> Option<&'n Node> {
        self.node.mapping()?.iter().map(|(name, _)| name).find(|name| name.scalar() == Some(key))
    }
}

/// The names that hooks can serve, and what the command is given or has to answer.
pub const HOOKS: &[(&str, &str)] = &[
    ("power", "`{value}` is up or down"),
    ("link", "`{value}` is up or down"),
    ("shaft.speed", "`{value}` in revolutions per minute, clockwise positive"),
    ("shaft.acceleration", "`{value}` in revolutions per minute, reached by `{acceleration}` of them each second"),
    ("shaft.counts", "`{value}` is a raw place in hardware steps"),
    ("turn", "`{value}` is the way, `{unit}` is counts or revolutions, `{rpm}` the speed"),
    ("supply.voltage", "`{value}` in volts"),
    ("supply.temperature", "`{value}` in degrees Celsius"),
    ("fault.NAME", "`{value}` is present or absent"),
    ("button.NAME", "`{value}` is pressed or released"),
    ("switch.NAME", "`{value}` is the position"),
    ("led.NAME", "the first line that it writes is what the LED shows, in a word of device.yaml"),
    ("counter.NAME", "the first line that it writes is the number"),
    ("renew", "puts a device as delivered into its place, with the same name and address"),
    (
        "device",
        "`{value}` is as_delivered: the device loses its address and everything stored, and has the name that it was delivered with, if any",
    ),
    ("clock", "`{value}` seconds go by for the device at once"),
];
