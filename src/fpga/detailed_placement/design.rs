//! A placed design: cells in slots, and the arcs from the driver of each net to its readers.
//!
//! ```text
//!   tile (x, y)   slice A: LUT 0, register 0, LUT 1, register 1 · slice B: 2, 3 · slice C: 4, 5 · slice D: 6, 7
//! ```

/// What has no number.
pub const NONE: u32 = u32::MAX;

/// Slots of a tile.
pub const SLOTS: usize = 8;

/// What a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Lut,
    /// A LUT whose output goes through a multiplexer of its slice: it does not move.
    Wide,
    /// A half of a slice of carry.
    Carry,
    /// A LUT as 16 bits of RAM, in slices A and B.
    Ram,
    /// A LUT of slice C that the RAM beside it takes.
    RamBlock,
    /// What the RAM is written by, in slice C.
    RamWrite,
    Register,
    BlockRam,
    /// One without registers.
    Multiplier,
    /// Pads, clock buffers and the like, which do not move.
    Other,
}

impl Kind {
    /// Whether it takes the place of a LUT.
    pub fn is_lut(self) -> bool {
        matches!(self, Kind::Lut | Kind::Wide | Kind::Carry | Kind::Ram | Kind::RamBlock)
    }

    /// Whether it stands in a tile of logic.
    pub fn in_tile(self) -> bool {
        self.is_lut() || matches!(self, Kind::RamWrite | Kind::Register)
    }
}

/// The ports that mean something here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Port {
    A,
    B,
    C,
    D,
    M,
    Di,
    Ce,
    Lsr,
    Clk,
    Wre,
    Fci,
    Fco,
    F,
    F1,
    Fxa,
    Fxb,
    Ofx,
    Q,
    /// One of the rest, by its number among the names of the design.
    Other(u16),
}

impl Port {
    /// Those with a name here.
    pub const NAMED: [(Port, &str); 18] = [
        (Port::A, "A"),
        (Port::B, "B"),
        (Port::C, "C"),
        (Port::D, "D"),
        (Port::M, "M"),
        (Port::Di, "DI"),
        (Port::Ce, "CE"),
        (Port::Lsr, "LSR"),
        (Port::Clk, "CLK"),
        (Port::Wre, "WRE"),
        (Port::Fci, "FCI"),
        (Port::Fco, "FCO"),
        (Port::F, "F"),
        (Port::F1, "F1"),
        (Port::Fxa, "FXA"),
        (Port::Fxb, "FXB"),
        (Port::Ofx, "OFX"),
        (Port::Q, "Q"),
    ];
}

/// The port of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Pin {
    pub port: Port,
    pub net: u32,
    /// [`NONE`] where it drives.
    pub arc: u32,
}

impl Pin {
    pub fn drives(&self) -> bool {
        self.arc == NONE
    }
}

/// What the registers of a slice or a tile must have in common: nets, and how each is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Control {
    pub clock: u32,
    pub reset: u32,
    pub enable: u32,
    pub clock_inverted: bool,
    pub reset_inverted: bool,
    /// Of the enable: inverted, or constant.
    pub enable_setting: u8,
}

impl Control {
    /// What is one for a tile.
    pub fn of_tile(&self) -> (u32, bool, u32, bool) {
        (self.clock, self.clock_inverted, self.reset, self.reset_inverted)
    }

    /// What is one for a slice.
    pub fn of_slice(&self) -> (u32, u8) {
        (self.enable, self.enable_setting)
    }
}

#[derive(Clone, Debug)]
pub struct Cell {
    pub name: String,
    pub kind: Kind,
    pub x: i16,
    pub y: i16,
    /// In its tile; as LUTs and registers have their own.
    pub slot: u8,
    pub pins: Vec<Pin>,
    pub control: Control,
    /// A register behind the LUT of its own slot, and that LUT.
    pub paired: bool,
    /// Its carry goes on into the next tile.
    pub chains_on: bool,
    /// Wires that its tile has for it.
    pub load: u8,
}

#[derive(Clone, Debug)]
pub struct Arc {
    pub net: u32,
    pub to: u32,
    pub port: Port,
    /// A wire within the slice or a global one: it takes no time, wherever it is.
    pub free: bool,
    /// What it may take, in nanoseconds.
    pub budget: f32,
}

#[derive(Clone, Debug)]
pub struct Net {
    pub driver: u32,
    /// The driver's.
    pub port: Port,
    pub arcs: Vec<u32>,
    /// Global, constant or without a driver.
    pub ignored: bool,
    /// As in the file.
    pub bit: u64,
    /// Driven by a block RAM without a register at its output.
    pub from_array: bool,
    /// Among the groups of equal registers; 0 for none.
    pub group: u32,
}

/// All of it.
#[derive(Clone, Debug, Default)]
pub struct Design {
    pub cells: Vec<Cell>,
    pub nets: Vec<Net>,
    pub arcs: Vec<Arc>,
    /// Of the other ports.
    pub ports: Vec<String>,
    /// Nets of registers that always hold the same; the first is empty.
    pub groups: Vec<Vec<u32>>,
    pub slots: super::slots::Slots,
    /// Each net behind those that it depends on within a clock.
    pub order: Vec<u32>,
}

impl Design {
    /// What an arc takes.
    pub fn delay(&self, arc: &Arc) -> f32 {
        if arc.free {
            return 0.0;
        }
        let net = &self.nets[arc.net as usize];
        let (from, to) = (&self.cells[net.driver as usize], &self.cells[arc.to as usize]);
        super::delays::wire(
            i32::from(from.x) - i32::from(to.x),
            i32::from(from.y) - i32::from(to.y),
            to.kind,
            net.arcs.len(),
        )
    }

    /// Nets that a cell drives.
    pub fn driven(&self, cell: usize) -> impl Iterator<Item = u32> + '_ {
        self.cells[cell].pins.iter().filter(|pin| pin.drives()).map(|pin| pin.net)
    }
}
