//! The modules of slot 1 and their submodules: chapter 8. All idents and the order of subslots are invented.

use encoder_profile::facts::{ModuleFacts, SubmoduleFacts};
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord, STANDARD, Telegram};

static MANTEL: Telegram = Telegram {
    number: 860,
    inputs: &[InputSignal::Position, InputSignal::NistB],
    input_octets: 8,
    outputs: &[OutputWord::Preset],
    output_octets: 4,
};
static SPEED: Telegram = input(&[InputSignal::NistA], 2);
static SINGLE_TURN: Telegram = input(&[InputSignal::SingleTurn], 4);
static MULTI_TURN: Telegram = input(&[InputSignal::MultiTurn], 4);
static SEPARATE_G1_ZSW: Telegram = input(&[InputSignal::SeparateG1Zsw], 2);
static SEPARATE_G1_STW: Telegram =
    Telegram { number: 0, inputs: &[], input_octets: 0, outputs: &[OutputWord::SeparateG1Stw], output_octets: 2 };

const fn input(inputs: &'static [InputSignal], input_octets: u16) -> Telegram {
    Telegram { number: 0, inputs, input_octets, outputs: &[], output_octets: 0 }
}

/// The ident of the parameter submodule.
const PARAMETERS: u32 = 2;

const AT_2: SubmoduleFacts = SubmoduleFacts { subslot: 2, ident: 860, telegram: &MANTEL };
const AT_3: SubmoduleFacts = SubmoduleFacts { subslot: 3, ident: 81, telegram: &STANDARD[0] };
const AT_4: SubmoduleFacts = SubmoduleFacts { subslot: 4, ident: 0x101, telegram: &SPEED };
const AT_5: SubmoduleFacts = SubmoduleFacts { subslot: 5, ident: 0x102, telegram: &SINGLE_TURN };
const AT_6: SubmoduleFacts = SubmoduleFacts { subslot: 6, ident: 0x103, telegram: &MULTI_TURN };
const AT_7: SubmoduleFacts = SubmoduleFacts { subslot: 7, ident: 0x104, telegram: &SEPARATE_G1_STW };
const AT_8: SubmoduleFacts = SubmoduleFacts { subslot: 8, ident: 0x105, telegram: &SEPARATE_G1_ZSW };

/// ManTel860, StdTel81 without and with extensions, and the universal module.
pub const MODULES: &[ModuleFacts] = &[
    ModuleFacts { ident: 0x10, access_point: PARAMETERS, submodules: &[AT_2] },
    ModuleFacts { ident: 0x20, access_point: PARAMETERS, submodules: &[AT_3] },
    ModuleFacts { ident: 0x21, access_point: PARAMETERS, submodules: &[AT_3, AT_4, AT_5, AT_6] },
    ModuleFacts { ident: 0x30, access_point: PARAMETERS, submodules: &[AT_2, AT_3, AT_4, AT_5, AT_6, AT_7, AT_8] },
];
