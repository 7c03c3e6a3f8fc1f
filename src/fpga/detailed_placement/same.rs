//! That two placements are of the same circuit.
//!
//! Registers with one input, one control and the same settings hold the same in every clock, from the first one on. If
//! every pin reads what it read before or such a copy of it, then all registers take the same at every edge as they did
//! before; so nothing that anybody can see is another.

use super::design::Design;

/// Whether nothing but places and the choice among copies differs.
///
/// # Errors
/// What else does.
pub fn proved(before: &Design, after: &Design) -> Result<(), String> {
    let differs = |what: &str| Err(format!("{what} is not what it was before it was moved"));
    if before.cells.len() != after.cells.len() || before.nets.len() != after.nets.len() {
        return differs("the number of cells and nets");
    }
    let highest = before.nets.iter().map(|net| net.bit).max().unwrap_or(0);
    let mut equal = vec![0; highest as usize + 1];
    for net in &before.nets {
        equal[net.bit as usize] = net.group;
    }
    for (was, is) in before.cells.iter().zip(&after.cells) {
        if was.name != is.name || was.kind != is.kind || was.pins.len() != is.pins.len() {
            return differs(&was.name);
        }
        for (was_pin, pin) in was.pins.iter().zip(&is.pins) {
            let bits = (before.nets[was_pin.net as usize].bit, after.nets[pin.net as usize].bit);
            let group = equal[bits.0 as usize];
            let copy = !pin.drives() && group > 0 && equal.get(bits.1 as usize) == Some(&group);
            if was_pin.port != pin.port || was_pin.drives() != pin.drives() || (bits.0 != bits.1 && !copy) {
                return differs(&was.name);
            }
        }
    }
    Ok(())
}
