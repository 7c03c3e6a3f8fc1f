//! The units put together between two AXI4-Streams.

use std::rc::Rc;

use super::super::top::{Arrivals, Flags, arrivals, stream_out};
use super::super::{AXES, Parameters};
use super::{AHEAD, buffer, columns, control, outer, single};
use crate::error::Result;
use crate::hdl::serial::following;
use crate::hdl::skew::{LEAD, SkewedPorts, skew};
use crate::hdl::{Builder, Module, Signal, Word};

/// Signals by the names of the ports that they go to.
type Named = Vec<(String, Signal)>;

/// Clocks from what is common to all coordinates to each of them.
pub const HOP: u32 = 1;

/// A register of its own for each coordinate, so that nothing is decided on the way there. Whole, what steers is reset:
/// the proof follows no unknown choice; in digits, what it would steer has not come yet.
fn nearer(m: &Builder, parameters: Parameters, axis: &str, name: &str, signal: &Signal) -> Signal {
    let name = format!("{axis}_{name}");
    if parameters.digit().is_none() && signal.width() == 1 {
        return m.unmerged(m.pipe_reset(name, signal, 0));
    }
    m.copy(name, signal)
}

/// A pulse, and what is 1 behind it as long as digits of its number come; so that few signals say how long.
fn throughout(m: &Builder, parameters: Parameters, pulse: &Signal) -> [Signal; 2] {
    if parameters.digits() == 1 {
        return [pulse.clone(), m.bit(false)];
    }
    let behind = following(m, pulse, parameters.digits() - 1, None);
    let behind = m.any(&behind.iter().collect::<Vec<_>>());
    let name = format!("{}_goes_on", pulse.name().unwrap_or_else(|| "pulse".into()));
    [pulse.clone(), m.restart(&m.pipe(name, &behind), pulse.time().unwrap_or(0))]
}

pub fn build(parameters: Parameters, lanes: u32) -> Result<Rc<Module>> {
    let m = Builder::new("loop_fd");
    m.purpose(
        "Forward-difference engine for Loop patches: 12 control points in, the vertices of neighbouring",
    );
    m.purpose("triangle strips out, a row of all at once, each the exact limit point correctly rounded.");
    m.parameter("lanes", lanes);
    if parameters.is_buffered() {
        m.parameter("columns", parameters.columns);
    }
    m.parameter("digits", parameters.digits());
    m.parameter("waiting_patches", u32::from(parameters.differences_wait()));
    let Arrivals { captures, differences, waiting, taken, released, level } = arrivals(&m, parameters)?;

    let has_room = m.forward("has_room", Word::bit());
    let inputs = [("waiting", &waiting), ("level", &level), ("has_room", &has_room)];
    let control = match lanes {
        1 => single::build(parameters)?,
        _ => control::build(parameters, lanes)?,
    };
    let control = m.instance("control", &control, &inputs);
    let registered = |name: &str| m.restart(&control.out(name), 0);
    m.drive(&taken, registered("load"));
    m.drive(&released, registered(if lanes == 1 { "released" } else { "load" }));
    let named = |names: Vec<String>| -> Vec<(String, Signal)> {
        names.into_iter().map(|name| (name.clone(), registered(&name))).collect()
    };
    let steps = named(["load", "advance"].map(String::from).to_vec());
    let keeps = named((1..=lanes).map(|k| format!("keep_{k}")).collect());
    let takes = if lanes == 1 { 0 } else { lanes };
    let mut rows = named((0..takes).map(|k| format!("take_{k}")).collect());
    rows.extend(named(["strip", "step"].map(String::from).to_vec()));
    let beat = registered("valid");
    let buffered = parameters.is_buffered();
    if buffered {
        rows.push(("valid".into(), registered("makes")));
    } else {
        rows.push(("valid".into(), beat.clone()));
        rows.extend(keeps.iter().cloned());
    }
    let issue = if lanes == 1 { registered("issue") } else { beat.clone() };

    // Digits come a clock behind what is said of them.
    let lead = parameters.digit().map_or(0, |_| LEAD);
    let outer = outer::build(parameters)?;
    let columns = columns::build(parameters, lanes)?;
    let columns = match parameters.digit() {
        Some(chunk) => skew(&columns, chunk, SkewedPorts { inputs: true, outputs: false })?,
        None => columns,
    };
    let [load, advance] = [&steps[0].1, &steps[1].1];
    let turn = m.wire("turn", load | advance);
    let waits = parameters.differences_wait();
    let [loads, advances] = [load, advance].map(|pulse| throughout(&m, parameters, pulse));
    let mut vertices: Vec<Vec<Signal>> = vec![];
    for (axis, capture) in AXES.iter().zip(&captures) {
        let nearer = |signals: &mut dyn Iterator<Item = &(String, Signal)>| -> Vec<(String, Signal)> {
            signals.map(|(name, signal)| (name.clone(), nearer(&m, parameters, axis, name, signal))).collect()
        };
        let (mut says, mut turns): (Named, Named) = (vec![], vec![]);
        if parameters.digit().is_some() {
            // Each of the three goes on through all digits; where it does stands in a register, and from there goes near.
            let through = |name: &str, pulses: &[&[Signal; 2]]| {
                let ahead = m.any(&pulses.iter().copied().flatten().collect::<Vec<_>>());
                (name.to_string(), m.pipe(format!("{axis}_{name}_ahead"), ahead))
            };
            let captures = throughout(&m, parameters, capture);
            let (turn, loads) = match waits {
                true => (turn.clone(), &loads),
                false => (m.wire(format!("{axis}_turn"), capture | advance), &captures),
            };
            says.push(("turn".into(), turn));
            if waits {
                turns.push(through("waiting_turns", &[&captures, loads]));
            }
            turns.push(through("outer_turns", &[loads, &advances]));
            turns.push(through("loading", &[loads]));
        } else {
            says.push(("capture".into(), capture.clone()));
            says.extend(steps.iter().filter(|(name, _)| waits || name != "load").cloned());
        }
        let near = nearer(&mut says.iter().chain(&differences));
        // What stands in a register of this coordinate already is near.
        let inputs: Vec<(String, Signal)> = near.into_iter().chain(turns).collect();
        let inputs: Vec<(&str, &Signal)> =
            inputs.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
        let placed = m.instance(&format!("outer_{axis}"), &outer, &inputs);
        let head = |name: String, word: Word| {
            let bits = placed.out(&name);
            let bits = match lanes {
                1 => m.restart(&m.pipe(format!("{axis}_{name}"), &bits), bits.time().unwrap_or(0)),
                _ => bits,
            };
            let number = match parameters.digit() {
                None => bits,
                // Chunk c is what is on the bus c clocks later.
                Some(size) => {
                    let wide = m.concat(&vec![&bits; word.width().div_ceil(size) as usize]);
                    m.wrap(&wide, word)
                }
            };
            (name, m.restart(&number, HOP + lead))
        };
        let sides: &[&str] = if buffered { &["last"] } else { &["last", "next"] };
        let orders = (0..4).flat_map(|l| sides.iter().map(move |side| (format!("{side}_{l}"), (0, l))));
        let orders = orders.chain([("fourth".into(), (1, 3))]);
        let heads: Vec<(String, Signal)> =
            orders.map(|(name, kl)| head(name, parameters.difference(kl))).collect();
        let rows = nearer(&mut rows.iter());
        let inputs = rows.iter().chain(&heads).map(|(name, signal)| (name.as_str(), signal));
        let placed = m.instance(&format!("columns_{axis}"), &columns, &inputs.collect::<Vec<_>>());
        let columns = if buffered { 0..=0 } else { 0..=lanes };
        vertices.push(columns.map(|k| placed.out(&format!("v{k}"))).collect());
    }
    let mut vertices: Vec<[Signal; 3]> =
        (0..vertices[0].len()).map(|k| [0, 1, 2].map(|axis: usize| vertices[axis][k].clone())).collect();
    if buffered {
        let said = ["row", "strip_end"].map(registered);
        vertices = beside_the_column_before(&m, parameters, &vertices[0], said)?.to_vec();
    }
    let names: Vec<String> = (0..=lanes).map(|k| format!("v{k}")).collect();
    let [last, start, end] = ["strip_end", "patch_start", "patch_end"].map(registered);
    let keeps = keeps.into_iter().map(|(_, keep)| keep).collect();
    let flags = Flags { keeps, last: &last, start: &start, end: &end };
    let room = stream_out(&m, parameters, &names, &vertices, [&issue, &beat], flags)?;
    m.drive(&has_room, &room);
    m.finish()
}

/// The vertices that leave the column, and in front of them those of the column before. Of a row is said, when it is decided
/// on, that it runs, and whether it is the last one of its pass.
fn beside_the_column_before(
    m: &Builder,
    parameters: Parameters,
    made: &[Signal; 3],
    [row, ends]: [Signal; 2],
) -> Result<[[Signal; 3]; 2]> {
    let ahead = made[0].time().unwrap_or(0) - AHEAD;
    let (row, ends) = (m.delay_reset(&row, ahead, 0), m.delay(&ends, ahead));
    let names = AXES.map(|axis| format!("made_{axis}"));
    let mut inputs = vec![("row", &row), ("ends", &ends)];
    inputs.extend(names.iter().map(String::as_str).zip(made));
    let placed = m.instance("buffer", &buffer::build(parameters, made[0].word())?, &inputs);
    Ok(["left", "right"].map(|side| AXES.map(|axis| placed.out(&format!("{side}_{axis}")))))
}
