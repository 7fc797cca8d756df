//! What a GSD says, as far as a master or a suite has to do with it.

/// A GSD.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gsd {
    /// `GSD_Revision`.
    pub gsd_revision: u32,
    /// `Vendor_Name`.
    pub vendor: String,
    /// `Model_Name`.
    pub model: String,
    /// `Revision` of the device.
    pub revision: String,
    /// `Ident_Number`.
    pub ident: u16,
    /// The baud rates that it knows, in kbit/s as the keywords have them (`9.6`, `1.5M`).
    pub bauds: Vec<String>,
    /// `Freeze_Mode_supp`.
    pub freeze: bool,
    /// `Sync_Mode_supp`.
    pub sync: bool,
    /// `Auto_Baud_supp`.
    pub auto_baud: bool,
    /// `Set_Slave_Add_supp`.
    pub set_slave_address: bool,
    /// `Fail_Safe`.
    pub fail_safe: bool,
    /// `DPV1_Slave`.
    pub dpv1: bool,
    /// `Isochron_Mode_supp`.
    pub isochronous: bool,
    /// `Max_Diag_Data_Len` in octets, where it is said.
    pub max_diagnosis: Option<usize>,
    /// `Max_Input_Len` in octets, where it is said.
    pub max_inputs: Option<usize>,
    /// `Max_Output_Len` in octets, where it is said.
    pub max_outputs: Option<usize>,
    /// `Max_User_Prm_Data_Len`, else `User_Prm_Data_Len`, in octets.
    pub max_user_octets: Option<usize>,
    /// The user octets of Set_Prm that go with every module.
    pub parameters: Parameters,
    /// The modules in the order of the file.
    pub modules: Vec<Module>,
}

/// A module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Module {
    /// Its name.
    pub name: String,
    /// Its identifiers in Chk_Cfg.
    pub cfg: Vec<u8>,
    /// The user octets that it adds behind those of the slave.
    pub parameters: Parameters,
}

/// User octets of Set_Prm: what always stands there, and what can be chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parameters {
    /// How many octets there are.
    pub octets: usize,
    /// Octets that stand there before the fields are put in: offset and octets.
    pub constants: Vec<(usize, Vec<u8>)>,
    /// The fields with their offsets.
    pub fields: Vec<(usize, Field)>,
}

/// A field of the user octets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Where it lies in its octets.
    pub kind: FieldType,
    /// Its default.
    pub default: i64,
    /// The numbers that it can have, where they are limited: lowest and highest.
    pub range: Option<(i64, i64)>,
}

/// Where a field lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldType {
    /// So many whole octets, perhaps a two's complement.
    Octets {
        /// How many: 1, 2 or 4.
        octets: usize,
        /// Whether it is a two's complement.
        signed: bool,
    },
    /// Bits `low` to `high` of an octet.
    Bits {
        /// The lowest bit.
        low: u8,
        /// The highest bit.
        high: u8,
    },
}

impl FieldType {
    /// How many octets it lies in.
    pub fn octets(self) -> usize {
        match self {
            FieldType::Octets { octets, .. } => octets,
            FieldType::Bits { .. } => 1,
        }
    }
}

impl Gsd {
    /// The fields of the user octets with a module, at offsets behind the seven octets of Set_Prm.
    ///
    /// The octets of a module follow those that go with every module.
    pub fn fields<'g>(&'g self, module: &'g Module) -> impl Iterator<Item = (usize, &'g Field)> {
        let before = self.parameters.octets;
        let own = self.parameters.fields.iter().map(|(at, field)| (*at, field));
        own.chain(module.parameters.fields.iter().map(move |(at, field)| (before + at, field)))
    }

    /// The user octets of Set_Prm with a module and every field at its default.
    pub fn default_octets(&self, module: &Module) -> Vec<u8> {
        let mut octets = vec![0; self.parameters.octets + module.parameters.octets];
        let parts = [(0, &self.parameters), (self.parameters.octets, &module.parameters)];
        for (begin, part) in parts {
            for (at, constant) in &part.constants {
                if let Some(place) = octets.get_mut(begin + at..begin + at + constant.len()) {
                    place.copy_from_slice(constant);
                }
            }
        }
        for (at, field) in self.fields(module) {
            let count = field.kind.octets();
            let Some(place) = octets.get_mut(at..at + count) else { continue };
            match field.kind {
                FieldType::Octets { .. } => place.copy_from_slice(&field.default.to_be_bytes()[8 - count..]),
                FieldType::Bits { low, high } => {
                    let mask = (((2u16 << high) - 1) & !((1u16 << low) - 1)) as u8;
                    place[0] = place[0] & !mask | ((field.default as u8) << low) & mask;
                }
            }
        }
        octets
    }
}
