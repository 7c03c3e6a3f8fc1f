//! The units put together between two AXI4-Streams.

use std::rc::Rc;

use super::{AXES, LEVEL_BITS, Parameters, control, engine, loader, startup};
use crate::cores::stream_fifo;
use crate::error::Result;
use crate::fixed::Precision;
use crate::hdl::serial::following;
use crate::hdl::skew::{LEAD, SkewedPorts, skew};
use crate::hdl::{Builder, Module, Signal, StreamBeat, Word};

pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("loop_fd");
    m.purpose("Forward-difference engine for Loop patches: 12 control points in, the vertices of the");
    match parameters.precision {
        Precision::Exact => {
            m.purpose("triangle strips out, two a clock, each the exact limit point correctly rounded.");
        }
        Precision::Reduced(_) => {
            m.purpose("triangle strips out, two a clock, each within a proven bound of the limit point.");
        }
    }
    let Arrivals { captures, differences, waiting, taken, released, level } = arrivals(&m, parameters)?;

    let has_room = m.forward("has_room", Word::bit());
    let control = m.instance(
        "control",
        &control::build(parameters)?,
        &[("waiting", &waiting), ("level", &level), ("has_room", &has_room)],
    );
    m.drive(&taken, control.out("taken"));
    m.drive(&released, control.out("taken"));
    let registered = |name: &str| m.restart(&control.out(name), 0);
    let [load, strip, step] = ["load", "strip", "step"].map(registered);
    let [beat, pair] = ["valid", "pair"].map(registered);
    let engine = engine::build(parameters)?;
    let engine = match parameters.chunk {
        Some(chunk) => skew(&engine, chunk, SkewedPorts { inputs: true, outputs: false })?,
        None => engine,
    };
    let (mut left, mut right) = (vec![], vec![]);
    for (axis, capture) in AXES.iter().zip(&captures) {
        let mut inputs: Vec<(&str, &Signal)> = vec![
            ("capture", capture),
            ("load", &load),
            ("strip", &strip),
            ("step", &step),
            ("valid", &beat),
            ("pair", &pair),
        ];
        inputs.extend(differences.iter().map(|(name, signal)| (name.as_str(), signal)));
        let placed = m.instance(&format!("engine_{axis}"), &engine, &inputs);
        left.push(placed.out("left"));
        right.push(placed.out("right"));
    }

    let names = ["left", "right"].map(String::from);
    let vertices = [left, right].map(|axes| [0, 1, 2].map(|axis: usize| axes[axis].clone()));
    let flags = ["pair", "strip_end", "patch_start", "patch_end"].map(registered);
    let [pair, last, start, end] = &flags;
    let flags = Flags { keeps: vec![pair.clone()], last, start, end };
    let room = stream_out(&m, parameters, &names, &vertices, [&beat, &beat], flags)?;
    m.drive(&has_room, &room);
    m.finish()
}

/// A patch in front of the engines.
pub(super) struct Arrivals {
    /// When the differences of each axis come.
    pub captures: [Signal; 3],
    pub differences: Vec<(String, Signal)>,
    /// Whether a patch is there whole, of this level.
    pub waiting: Signal,
    pub level: Signal,
    /// To be driven: the engines take it.
    pub taken: Signal,
    /// To be driven: another patch may come to them.
    pub released: Signal,
}

/// The input stream, loader and start-up.
pub(super) fn arrivals(m: &Builder, parameters: Parameters) -> Result<Arrivals> {
    m.parameter("coordinates", parameters.coordinates);
    m.parameter("output_fraction", parameters.output_fraction);
    m.parameter("max_level", parameters.max_level);
    m.parameter("registers", parameters.registers);
    if let Some(chunk) = parameters.chunk {
        m.parameter("chunk", chunk);
    }
    if parameters.min_level > 0 {
        m.parameter("min_level", parameters.min_level);
    }
    if parameters.precision != Precision::Exact {
        m.parameter("differences", parameters.precision);
    }

    let axes = AXES.map(|axis| (axis, parameters.point()));
    let points = m.stream_input("s_axis", parameters.input_lane(), &axes, LEVEL_BITS);

    // `reserved` from the moment when a patch is handed over until another one may come: as one may wait in the engines while
    // another runs, mostly until it is loaded. `waiting` once it has arrived whole.
    let reserved = m.register_reset("reserved", Word::bit(), 0);
    let waiting = m.register_reset("waiting", Word::bit(), 0);
    let [taken, released] = ["taken_now", "released_now"].map(|name| m.forward(name, Word::bit()));
    let loader = m.instance(
        "loader",
        &loader::build(parameters)?,
        &[
            ("valid", &points.valid),
            ("last", &points.last),
            ("level_in", &points.user),
            ("slot_free", &!&reserved),
        ],
    );

    let [shift, begins] = ["shift", "begins"].map(|name| loader.out(name));
    let registered = |name: &str| m.restart(&loader.out(name), 0);
    let [strobe, axis_x, axis_y] = ["strobe", "axis_x", "axis_y"].map(registered);
    let beat = [0, 1, 2].map(|i| m.pipe(format!("point_{}", AXES[i]), &points.lanes[i]));
    let digit = parameters.lanes.and(parameters.digit());
    let chunk = if parameters.lanes.is_some() { None } else { parameters.chunk };
    let lead = if chunk.is_some() { LEAD } else { 0 };
    // In chunks, single bits come before the numbers they belong to. In front of digits, all banks are told out of registers.
    let beat = beat.map(|point| m.restart(&m.delay(&m.restart(&point, 0), lead), lead));
    let (shift, beat) = match digit {
        None => (shift, beat),
        Some(_) => {
            let later = |signal: &Signal| m.restart(&m.delay(signal, 1), 0);
            (later(&m.restart(&shift, 0)), [0, 1, 2].map(|axis: usize| later(&beat[axis])))
        }
    };
    let mut inputs: Vec<(&str, &Signal)> = vec![("shift", &shift), ("axis_x", &axis_x), ("axis_y", &axis_y)];
    inputs.extend(["point_x", "point_y", "point_z"].into_iter().zip(&beat));
    let level = if parameters.has_one_level() {
        m.constant(parameters.max_level.into(), parameters.level())
    } else {
        registered("level")
    };
    if !parameters.has_one_level() {
        inputs.push(("level", &level));
    }
    if parameters.precision != Precision::Exact {
        inputs.push(("valid", &strobe));
    }
    if digit.is_some() {
        inputs.push(("first", &strobe));
    }
    let startup = startup::build(parameters)?;
    let startup = match chunk {
        Some(chunk) => skew(&startup, chunk, SkewedPorts { inputs: false, outputs: true })?,
        None => startup,
    };
    let startup = m.instance("startup", &startup, &inputs);
    let differences: Vec<(String, Signal)> = engine::DIFFERENCES
        .iter()
        .map(|(k, l)| (format!("n{k}{l}"), m.restart(&startup.out(&format!("n{k}{l}")), 0)))
        .collect();

    // What belongs to the axis that leaves the start-up now. Digits follow a clock behind.
    let arrival = startup.out("n00").time().unwrap_or(0) - if digit.is_some() { LEAD } else { 0 };
    let arrive = |signal: &Signal, clocks| m.restart(&m.delay(signal, clocks), 0);
    let arrived_level = arrive(&level, arrival);
    // Decided a clock before, so that each comes out of a register.
    let [arrives_x, arrives_y] = [&axis_x, &axis_y].map(|axis| arrive(axis, arrival - 1));
    let arrives = m.restart(&m.delay_reset(&strobe, arrival - 1, 0), 0);
    let whose = [arrives_x.clone(), arrives_y.clone(), !&(&arrives_x | &arrives_y)];
    let captures = [0, 1, 2].map(|index| {
        m.restart(&m.pipe_reset(format!("capture_{}", AXES[index]), &arrives & &whose[index], 0), 0)
    });
    let behind = if digit.is_some() { LEAD } else { lead };
    let differences: Vec<(String, Signal)> =
        differences.into_iter().map(|(name, n)| (name, m.restart(&m.delay(&n, lead), behind))).collect();
    let waiting_level = if parameters.has_one_level() {
        level.clone()
    } else {
        let kept = m.register("waiting_level", arrived_level.word());
        m.on(&captures[2], &kept, &arrived_level);
        kept
    };
    // Its last digit comes so much later.
    let whole = following(m, &captures[2], if digit.is_some() { parameters.digits() } else { 1 }, Some(0));
    m.on(&whole[whole.len() - 1], &waiting, m.bit(true));
    m.on(&taken, &waiting, m.bit(false));
    m.on(&begins, &reserved, m.bit(true));
    m.on(&released, &reserved, m.bit(false));
    m.output("s_axis_tready", loader.out("ready"));
    Ok(Arrivals { captures, differences, waiting, taken, released, level: waiting_level })
}

/// What is said of a beat when it is decided on.
pub(super) struct Flags<'a> {
    /// Whether there is a second vertex, a third ...
    pub keeps: Vec<Signal>,
    pub last: &'a Signal,
    pub start: &'a Signal,
    pub end: &'a Signal,
}

/// The FIFO behind the engines, and the output stream; returns whether a beat may be issued. The vertices come as many
/// clocks after `beat` and the flags as they declare; `issue` is the beat when it was decided on, the same or clocks
/// before.
pub(super) fn stream_out(
    m: &Builder,
    parameters: Parameters,
    names: &[String],
    vertices: &[[Signal; 3]],
    [issue, beat]: [&Signal; 2],
    flags: Flags,
) -> Result<Signal> {
    let ready = m.stream_ready("m_axis");
    // The flags of a beat travel beside its numbers.
    let depth = vertices[0][0].time().unwrap_or(0);
    let beside = |flag: &Signal| m.restart(&m.delay(flag, depth), 0);
    let push = m.restart(&m.delay_reset(beat, depth - 1, 0), 0);
    let mut lanes: Vec<(String, Signal)> = vec![];
    for (name, vertex) in names.iter().zip(vertices) {
        for (axis, signal) in AXES.iter().zip(vertex) {
            lanes.push((format!("{name}_{axis}"), m.restart(signal, 0)));
        }
    }
    let numbers = lanes.len();
    let flags: Vec<Signal> =
        flags.keeps.iter().chain([flags.last, flags.start, flags.end]).map(beside).collect();
    lanes.push(("flags".into(), m.concat(&flags.iter().rev().collect::<Vec<_>>())));
    let mut shapes: Vec<(String, Word)> = lanes.iter().map(|(name, s)| (name.clone(), s.word())).collect();
    // What comes from one engine stays together.
    shapes.sort_by_key(|(name, _)| name.chars().last());
    let log_depth = (parameters.decided_before() + depth + stream_fifo::OVERHEAD).next_power_of_two().ilog2();
    let ports: Vec<String> = lanes.iter().map(|(name, _)| format!("in_{name}")).collect();
    let mut inputs: Vec<(&str, &Signal)> =
        ports.iter().map(String::as_str).zip(lanes.iter().map(|(_, s)| s)).collect();
    inputs.extend([("issue", issue), ("push", &push), ("ready", &ready)]);
    let fifo = m.instance("output_fifo", &stream_fifo::build(log_depth, &shapes)?, &inputs);

    let out: Vec<Signal> = lanes.iter().map(|(name, _)| fifo.out(&format!("out_{name}"))).collect();
    let (out, told) = out.split_at(numbers);
    let flags: Vec<Signal> = (0..flags.len() as u32).map(|bit| m.slice(&told[0], bit, 1)).collect();
    let vertices: Vec<(&str, &Signal)> = lanes.iter().map(|(name, _)| name.as_str()).zip(out).collect();
    let (keeps, ends) = flags.split_at(flags.len() - 3);
    // One bit for each byte: the first vertex is always there.
    let bytes = (3 * parameters.output_lane() / 8) as usize;
    let always = m.bit(true);
    let kept = [&always].into_iter().chain(keeps);
    let kept: Vec<Signal> = kept.map(|keep| m.concat(&vec![keep; bytes])).collect();
    let (user, valid) = (m.concat(&[&ends[2], &ends[1]]), fifo.out("valid"));
    if parameters.lanes.is_none() {
        let keep = m.concat(&[&kept[1], &kept[0]]);
        let beat = StreamBeat { lanes: &vertices, keep: &keep, user: &user, last: &ends[0], valid: &valid };
        m.stream_output("m_axis", parameters.output_lane(), beat);
    } else {
        let kept: Vec<(&str, &Signal)> = names.iter().map(String::as_str).zip(&kept).collect();
        m.output_bus("m_axis_tdata", parameters.output_lane(), &vertices);
        m.output_bus("m_axis_tkeep", bytes as u32, &kept);
        m.output("m_axis_tuser", &user);
        m.output("m_axis_tlast", &ends[0]);
        m.output("m_axis_tvalid", &valid);
    }
    Ok(fifo.out("has_room"))
}
