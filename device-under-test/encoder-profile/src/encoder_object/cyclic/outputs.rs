//! Control words in: the outputs of the controller as they arrive.

use super::CONTROL_BY_PLC;
use crate::encoder_object::memory::Source;
use crate::encoder_object::{Live, Model, Phase};
use crate::profidrive::life_sign::Watch;
use crate::profidrive::mantel::Known;
use crate::profidrive::sensor::Request;
use crate::profidrive::telegram::{Control, Outputs};

impl<M: Model> Live<'_, M> {
    /// Takes the outputs of one submodule; of those that are bad or missing only what it brings is given up.
    pub fn take(&mut self, subslot: u16, outputs: Option<&[u8]>) {
        let Some(submodule) = self.ram.submodules.iter().copied().find(|one| one.subslot == subslot) else { return };
        let telegram = submodule.telegram;
        let arrived = Outputs::read(telegram, outputs);
        let hooks = &self.behaviour.hooks;
        let arrived = hooks.apply(arrived, |hooks, arrived| hooks.outputs(&self.view(), telegram, arrived));
        self.ram.outputs.replace(telegram, arrived);
        if submodule.telegram.outputs.contains(&Control::Preset) && matches!(self.ram.phase, Phase::Data(_)) {
            self.take_preset();
        }
        if !submodule.telegram.outputs.contains(&Control::Stw2Enc) {
            return;
        }
        let Some([stw2_enc, _]) = self.ram.outputs.words else { return };
        let (rules, user) = (&self.behaviour.life_sign, &self.ram.user);
        let watched = rules.watches_without_control || stw2_enc & CONTROL_BY_PLC != 0;
        if (rules.is_watched)(M::watches_controller(self)) && watched && !self.ram.sensor.is_parked() {
            let tolerated = match user.compatible {
                true => user.life_sign_failures,
                false => (rules.tolerated_without_compatibility)(user.life_sign_failures),
            };
            self.ram.watch.take((rules.read)(stw2_enc), (rules.tolerated)(tolerated), rules);
        } else {
            self.ram.watch = Watch::default();
        }
        self.look_for_errors();
    }

    /// Looks for the trigger of a preset in what was taken.
    fn take_preset(&mut self) {
        let user_range = self.ram.user.range;
        let known =
            Known { range: self.positions().max(1), user_range, preset_value: self.ram.preset_value, before: 0 };
        if let Some(value) = self.ram.trigger.take(self.ram.outputs.preset, &known) {
            let g1_stw = self.ram.outputs.words.map_or(0, |[_, g1_stw]| g1_stw);
            let mode = (self.behaviour.mantel.mode)(Request::of(g1_stw).mode());
            self.preset(Source::Value(mode, value as u32));
        }
    }
}
