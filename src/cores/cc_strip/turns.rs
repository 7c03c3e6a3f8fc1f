//! Coordinates that take turns: the words of a stream one coordinate after the other, and whose a slice is.
//!
//! ```text
//! a word          x y z     all at once, and no other word in three clocks
//! its strobe      1 0 0
//! thrice          1 1 1
//! comes           x y z     a coordinate a clock
//! ```

use super::sending::axis_word;
use crate::hdl::{Builder, Signal};

/// The port that says whose a slice is, where every coordinate has an engine; it goes to none of them.
pub const OWNER: &str = "owner";

/// Whether a port is for the coordinate that comes in.
pub fn is_owned(port: &str) -> bool {
    ["in_shift", "in_comes"].contains(&port) || port.starts_with("in_write_")
}

/// What comes in.
pub struct Comes {
    pub comes: Signal,
    /// Which coordinate, of a word.
    pub axis: Signal,
    /// Whether it is y, and z.
    late: [Signal; 2],
}

/// The signal in the clocks of y and of z.
fn late(m: &Builder, name: &str, signal: &Signal) -> [Signal; 2] {
    let again = |name: String, signal: &Signal| m.restart(&m.pipe(name, signal), 0);
    let y = again(format!("{name}_of_y"), signal);
    let z = again(format!("{name}_of_z"), &y);
    [y, z]
}

/// Of words, each coordinate has a clock; slices come as they are.
pub fn comes(m: &Builder, words: bool, valid: &Signal) -> Comes {
    if !words {
        let [axis, late] = [m.constant(0, axis_word()), m.bit(false)];
        return Comes { comes: valid.clone(), axis, late: [late.clone(), late] };
    }
    let late = late(m, "comes", valid);
    let [x, y, z] = [0, 1, 2].map(|axis| m.constant(axis, axis_word()));
    let axis = m.wire("word_axis", m.select(&late[1], &z, m.select(&late[0], &y, &x)));
    Comes { comes: m.any(&[valid, &late[0], &late[1]]), axis: m.wrap(&axis, axis_word()), late }
}

/// The coordinate in turn of a word, which stands for the clocks of x and y.
pub fn word(m: &Builder, comes: &Comes, words: &[Signal]) -> Signal {
    let z = m.restart(&m.pipe("word_z_in_turn", &words[2]), 0);
    let [of_y, of_z] = &comes.late;
    m.wire("word_in_turn", m.select(of_z, &z, m.select(of_y, &words[1], &words[0])))
}

/// What steers a window at a word, for each coordinate.
pub fn thrice(m: &Builder, ports: Vec<(String, Signal)>) -> Vec<(String, Signal)> {
    let thrice = |(port, signal): (String, Signal)| match port.as_str() {
        port_of if is_owned(port_of) => {
            let [y, z] = late(m, &port, &signal);
            let all = m.any(&[&signal, &y, &z]);
            (port, all)
        }
        _ => (port, signal),
    };
    ports.into_iter().map(thrice).collect()
}
