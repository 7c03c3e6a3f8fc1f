//! From the names of the tools back to ours.
//!
//! ```text
//!   core.engine_x.left_0_TRELLIS_FF_Q_7            engine_x.left_0[7]
//!   core.control.pairs_left_CCU2C_S0_1_S0_LUT4_D   control.pairs_left
//!   core.loader.full_TRELLIS_FF_Q_CE_LUT4_Z        loader.full
//! ```
//!
//! Yosys names a cell after the nearest net with a name, then the type of the cell and the port, perhaps several
//! times, perhaps with a number. The number is no bit; the bit of a register stands in its net.

/// Types of cells that Yosys writes into names.
const TYPES: [&str; 24] = [
    "TRELLIS_FF",
    "TRELLIS_DPR16X4",
    "LUT4",
    "LUT3",
    "LUT2",
    "LUT1",
    "PFUMX",
    "L6MUX21",
    "CCU2C",
    "CCU2",
    "DP16KD",
    "MULT18X18D",
    "SB_LUT4",
    "SB_CARRY",
    "SB_DFF",
    "SB_RAM40",
    "SB_MAC16",
    "ALU",
    "DFF",
    "MUX2_LUT",
    "RAM16S",
    "FD1P3",
    "WIDEFN9",
    "DPR16X4",
];

/// What of a tool's name is ours, from the core on.
pub fn ours(name: &str) -> String {
    let inside = name.strip_prefix("core.").unwrap_or(name);
    let inside = inside.split('$').next().unwrap_or(inside);
    let (path, last) = inside.rsplit_once('.').map_or(("", inside), |(path, last)| (path, last));
    let cut = TYPES.iter().filter_map(|kind| last.find(&format!("_{kind}"))).min();
    let own = &last[..cut.unwrap_or(last.len())];
    // What followed the type is gone, and with it a bit; a bit without a type is part of our name.
    if path.is_empty() { own.to_string() } else { format!("{path}.{own}") }
}

/// The bit at the end of a net's name: 3 of `core.control.pairs_left[3]`, where the name is ours alone.
pub fn bit_of(net: &str) -> Option<u32> {
    let (name, bit) = net.strip_suffix(']')?.rsplit_once('[')?;
    TYPES.iter().all(|kind| !name.contains(&format!("_{kind}"))).then(|| bit.parse().ok())?
}

/// The unit a cell belongs to: the outermost instance within the core, or the core itself.
pub fn unit(name: &str) -> &str {
    let inside = name.strip_prefix("core.").unwrap_or(name);
    match inside.split_once('.') {
        Some((unit, _)) if !unit.contains('$') => unit,
        _ => TOP,
    }
}

/// What stands in the core outside of its units.
pub const TOP: &str = "(top)";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_suffixes_of_the_tools_are_taken_off() {
        for (theirs, own) in [
            ("core.engine_x.left_0_TRELLIS_FF_Q_7", "engine_x.left_0"),
            ("core.control.pairs_left_CCU2C_S0_1_S0_LUT4_D", "control.pairs_left"),
            ("core.loader.full_TRELLIS_FF_Q_CE_LUT4_Z", "loader.full"),
            ("core.s_axis_tvalid_LUT4_D_Z[4]", "s_axis_tvalid"),
            ("core.engine_x.left_0[52]", "engine_x.left_0[52]"),
            ("core.loader.p3_SB_DFFE_Q_12_D_SB_LUT4_O", "loader.p3"),
            ("core.a.b.c_ALU_SUM", "a.b.c"),
            ("core.startup.n00$nextpnr_ff", "startup.n00"),
            ("fold_4_TRELLIS_FF_Q", "fold_4"),
            ("core.m_axis_tvalid", "m_axis_tvalid"),
        ] {
            assert_eq!(ours(theirs), own, "{theirs}");
        }
    }

    #[test]
    fn a_cell_belongs_to_the_outermost_instance() {
        assert_eq!(unit("core.engine_x.rounder.sum_LUT4_Z"), "engine_x");
        assert_eq!(unit("startup.n00_LUT4_Z"), "startup");
        assert_eq!(unit("core.reserved_LUT4_B"), TOP);
        assert_eq!(unit("$abc$1.2"), TOP);
    }
}
