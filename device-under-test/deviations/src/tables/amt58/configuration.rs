//! Bugs of Chk_Cfg and Get_Cfg, and of how much is exchanged.

use crate::tables::Deviation;
use reference_devices::models::datalogic_amt58::knobs::has;
use reference_devices::models::datalogic_amt58::program::{OPERATING, Program, SPEED_UNIT, VELOCITY, lengths};
use reference_devices::models::datalogic_amt58::told::{Shown, inputs};
use wire::profibus::cfg::Sums;

const POSITION: [u8; 2] = [0xD1, 0xE1];
const BOTH: [u8; 2] = [0xD3, 0xE1];

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    "velocity-configuration-always-taken" "D3 E1 is accepted whatever the parameters say, and 8 octets are sent."
        => |b| b.amt58.takes_configuration = |_, told, right| right.or(accepted(told, told == BOTH));
    "short-configuration-always-taken" "D1 E1 is accepted with the velocity parameterised, and the inputs are cut to 4 octets."
        => |b| b.amt58.takes_configuration = |_, told, right| right.or(accepted(told, told == POSITION));
    "configuration-of-another-class" "In Class 1 the identifiers D3 E1 are wanted, and D1 E1 is refused."
        => |b| b.amt58.takes_configuration = |program, told, right| match program.class() {
            0 => accepted(told, told == BOTH),
            _ => right,
        };
    "class-2-wants-d3" "In Class 2 the identifiers D3 E1 are wanted, and D1 E1 is refused."
        => |b| b.amt58.takes_configuration = |program, told, right| match program.class() {
            1 => accepted(told, told == BOTH),
            _ => right,
        };
    "only-first-identifier-checked" "Of the configuration only the first identifier is compared."
        => |b| b.amt58.takes_configuration = |program, told, _| own(program, told.first() == program.identifiers().first());
    "consistency-bit-ignored" "Bit 7 of the identifiers is not compared."
        => |b| b.amt58.takes_configuration = |program, told, _| {
            let plain = |octets: &[u8]| octets.iter().map(|octet| octet & 0x7F).collect::<alloc::vec::Vec<_>>();
            own(program, plain(told) == plain(program.identifiers()))
        };
    "only-lengths-compared" "Of the identifiers only how many octets of input and output they mean is compared."
        => |b| b.amt58.takes_configuration = |program, told, _| own(program, lengths(told) == lengths(program.identifiers()));
    "identifiers-as-a-set" "The order of the identifiers is not compared."
        => |b| b.amt58.takes_configuration = |program, told, right| match (told, program.identifiers()) {
            ([first, second], [one, other]) => own(program, [first, second] == [one, other] || [second, first] == [one, other]),
            _ => right,
        };
    "output-identifier-first" "The configuration is wanted with the output identifier first."
        => |b| b.amt58.takes_configuration = |program, told, _| {
            own(program, told.iter().rev().eq(program.identifiers()))
        };
    "longer-inputs-accepted" "An identifier with more input octets than the device has is accepted."
        => |b| b.amt58.takes_configuration = |program, told, right| {
            let (asked, wanted) = (lengths(told), lengths(program.identifiers()));
            right.or(own(program, asked.inputs > wanted.inputs && asked.outputs == wanted.outputs))
        };
    "configuration-compared-as-received" "The configuration is compared over the length that came, so that a shorter one fits."
        => |b| b.amt58.takes_configuration = |program, told, _| own(program, program.identifiers().starts_with(told));
    "surplus-identifiers-ignored" "Identifiers behind the second are not looked at."
        => |b| b.amt58.takes_configuration = |program, told, _| own(program, told.starts_with(program.identifiers()));
    "output-length-not-compared" "The length of the outputs is not compared."
        => |b| b.amt58.takes_configuration = |program, told, right| {
            let is_pair = told.len() == 2 && told.first() == program.identifiers().first();
            right.or(accepted(told, is_pair && told.get(1).is_some_and(|second| second & 0xF0 == 0xE0)))
        };
    "get-cfg-constant" "Get_Cfg tells D1 E1 whatever the class is."
        => |b| b.amt58.configuration = |_| &POSITION;
    "directions-confused" "Get_Cfg and the data exchange have the lengths of input and output exchanged in Class 2 with velocity."
        => |b| {
            b.amt58.configuration = |program| if program.has_velocity { &[0xD1, 0xE3] } else { program.identifiers() };
            b.amt58.takes_configuration = |program, _, right| right.map(|sums| match program.has_velocity {
                true => Sums { inputs: sums.outputs, outputs: sums.inputs },
                false => sums,
            });
        };
    "velocity-in-class-2" "In Class 2 the inputs have 8 octets, with the velocity, although D1 E1 is the configuration."
        => |b| b.amt58.takes_configuration = |program, _, right| right.map(|sums| match program.class() {
            1 => Sums { inputs: 8, ..sums },
            _ => sums,
        });
    "unit-activates-velocity" "A unit other than 0 brings the velocity into the inputs of Class 2 too, which then have 8 octets."
        => |b| b.amt58.takes_configuration = |program, _, right| right.map(|sums| {
            let bits = program.octets[OPERATING];
            match program.is_class_2 && !has(bits, VELOCITY) && program.octets[SPEED_UNIT] != 0 {
                true => Sums { inputs: 8, ..sums },
                false => sums,
            }
        });
    "inputs-of-two-octets" "In Class 1 the inputs have two octets, the lower half of the position."
        => |b| {
            b.amt58.takes_configuration = |program, _, right| right.map(|sums| match program.class() {
                0 => Sums { inputs: 2, ..sums },
                _ => sums,
            });
            b.amt58.inputs = |shown, octets| match octets {
                [_, _] => octets.copy_from_slice(&(shown.position as u16).to_be_bytes()),
                _ => inputs(shown, octets),
            };
        };
    "inputs-of-six-octets" "In Class 2 with velocity the inputs have six octets, the velocity having two."
        => |b| {
            b.amt58.takes_configuration = |program, _, right| right.map(|sums| match program.has_velocity {
                true => Sums { inputs: 6, ..sums },
                false => sums,
            });
            b.amt58.inputs = short_velocity;
        };
};

fn accepted(told: &[u8], is_accepted: bool) -> Option<Sums> {
    is_accepted.then(|| lengths(told))
}

fn own(program: &Program, is_accepted: bool) -> Option<Sums> {
    is_accepted.then(|| lengths(program.identifiers()))
}

fn short_velocity(shown: &Shown<'_>, octets: &mut [u8]) {
    inputs(shown, octets);
    if let [_, _, _, _, velocity @ ..] = octets
        && velocity.len() == 2
    {
        velocity.copy_from_slice(&(shown.velocity as i16).to_be_bytes());
    }
}
