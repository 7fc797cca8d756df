//! Actions of the stand, and what it reads: shaft, faults, LEDs and counters.

use super::{EncoderModel, EncoderObject};
use crate::encoder_object::hooks::LedInput;
use crate::facts::ErrorCause;
use crate::profidrive::telegram::OutputValues;
use device_stack::profinet::StackStatus;
use station::{StandAction, Time};

impl<M: EncoderModel> EncoderObject<M> {
    /// Carries out an action of the stand. Returns when it is complete; `None` if the encoder does not support it.
    pub(super) fn act_on_encoder(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        Some(match *action {
            StandAction::ShaftSpeed(rpm) => {
                self.shaft.turn(now, rpm);
                now
            }
            StandAction::ShaftRamp { rpm, acceleration } => {
                self.shaft.ramp(now, rpm, acceleration);
                now
            }
            StandAction::ShaftCounts(counts) => {
                // The shaft jumps: no velocity, and no passage through the positions in between.
                let place = counts % self.variant.hardware.range();
                self.shaft.move_to(now, place as i64);
                self.ram.velocity.restart(now, &self.shaft);
                self.ram.measuring.jump(place);
                M::shaft_moved(&mut self.live(now));
                now
            }
            StandAction::Turn { steps, rpm } => self.shaft.turn_by(now, steps, rpm),
            StandAction::TurnRevolutions { revolutions, rpm } => self.shaft.turn_revolutions(now, revolutions, rpm),
            StandAction::Fault(name, present) if self.fault(name, present) => now,
            _ => M::act(&mut self.live(now), action)?,
        })
    }

    /// Sets (`present`) or clears a fault. Returns `false` if the encoder has no fault of this name.
    fn fault(&mut self, name: &str, present: bool) -> bool {
        let errors = self.facts.errors.iter().flat_map(|error| error.causes);
        let of_errors = errors.filter_map(|cause| match cause {
            ErrorCause::Stand(known) => Some(*known),
            ErrorCause::LifeSign | ErrorCause::WrongParameters | ErrorCause::Model => None,
        });
        let of_warnings = self.facts.warnings.iter().filter_map(|warning| warning.cause);
        let Some(known) = of_errors.chain(of_warnings).find(|known| *known == name) else { return false };
        self.faults.set(known, present);
        true
    }

    /// What an LED shows; `None` if there is no LED of this name.
    pub(super) fn led_state(&mut self, now: Time, name: &str, status: &StackStatus) -> Option<&'static str> {
        let live = self.live(now);
        let right = M::led(&live, name, status)?;
        let faults = live.fault_bits();
        let (has_wrong_parameters, has_record) = (live.ram.wrong_parameters, live.ram.has_record);
        let exchanged_for = live.ram.data_since.map(|since| now.since(since));
        let lit = LedInput {
            name,
            stack: status,
            faults,
            has_wrong_parameters,
            has_record,
            had_warning: live.ram.had_warning,
            exchanged_for,
            has_outputs: live.ram.outputs != OutputValues::default(),
        };
        Some(live.deviations.hooks.apply(right, |hooks, right| hooks.led(&lit, right)))
    }

    /// The value of a counter; `None` if there is no counter of this name.
    pub(super) fn counter_value(&mut self, now: Time, name: &str) -> Option<u64> {
        let live = self.live(now);
        let store = &*live.store;
        let count = match name {
            "nvm_writes" => store.offset.writes() + store.preset_value.writes() + store.station.writes(),
            _ => M::counter(&live, name)?,
        };
        Some(live.deviations.hooks.apply(count, |hooks, count| hooks.counter(name, count)))
    }
}
