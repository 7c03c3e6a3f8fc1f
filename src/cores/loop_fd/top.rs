//! The units put together between two AXI4-Streams.

use std::rc::Rc;

use super::{AXES, LEVEL_BITS, Parameters, control, engine, loader, startup};
use crate::cores::stream_fifo;
use crate::error::Result;
use crate::fixed::Precision;
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
    let ready = m.stream_ready("m_axis");

    // One patch may wait in the engines while another runs. `reserved` from the moment it is handed over
    // until it is loaded; `waiting` once it has arrived whole.
    let reserved = m.register_reset("reserved", Word::bit(), 0);
    let waiting = m.register_reset("waiting", Word::bit(), 0);
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
    // In chunks, single bits come before the numbers they belong to.
    let lead = if parameters.chunk.is_some() { LEAD } else { 0 };
    let beat = beat.map(|point| m.restart(&m.delay(&m.restart(&point, 0), lead), lead));
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
    let startup = startup::build(parameters)?;
    let startup = match parameters.chunk {
        Some(chunk) => skew(&startup, chunk, SkewedPorts { inputs: false, outputs: true })?,
        None => startup,
    };
    let startup = m.instance("startup", &startup, &inputs);
    let differences: Vec<(String, Signal)> = engine::DIFFERENCES
        .iter()
        .map(|(k, l)| (format!("n{k}{l}"), m.restart(&startup.out(&format!("n{k}{l}")), 0)))
        .collect();

    // What belongs to the axis that leaves the start-up now.
    let arrival = startup.out("n00").time().unwrap_or(0);
    let arrive = |signal: &Signal| m.restart(&m.delay(signal, arrival), 0);
    let [arrived_x, arrived_y, arrived_level] = [&axis_x, &axis_y, &level].map(arrive);
    let arrived = m.restart(&m.delay_reset(&strobe, arrival, 0), 0);
    let whose = [arrived_x.clone(), arrived_y.clone(), !&(&arrived_x | &arrived_y)];
    let captures =
        [0, 1, 2].map(|index| m.wire(format!("capture_{}", AXES[index]), &arrived & &whose[index]));
    let differences: Vec<(String, Signal)> =
        differences.into_iter().map(|(name, n)| (name, m.restart(&m.delay(&n, lead), lead))).collect();
    let waiting_level = if parameters.has_one_level() {
        level.clone()
    } else {
        let kept = m.register("waiting_level", arrived_level.word());
        m.on(&captures[2], &kept, &arrived_level);
        kept
    };

    let has_room = m.forward("has_room", Word::bit());
    let control = m.instance(
        "control",
        &control::build(parameters)?,
        &[("waiting", &waiting), ("level", &waiting_level), ("has_room", &has_room)],
    );
    let taken = control.out("taken");
    let registered = |name: &str| m.restart(&control.out(name), 0);
    let [load, strip, step] = ["load", "strip", "step"].map(registered);
    let [beat, pair] = ["valid", "pair"].map(registered);
    m.on(&captures[2], &waiting, m.bit(true));
    m.on(&taken, &waiting, m.bit(false));
    m.on(&begins, &reserved, m.bit(true));
    m.on(&taken, &reserved, m.bit(false));

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

    // The flags of a beat travel beside its numbers.
    let depth = left[0].time().unwrap_or(0);
    let flags = ["pair", "strip_end", "patch_start", "patch_end"].map(registered);
    let flags: Vec<Signal> = flags.iter().map(|flag| m.restart(&m.delay(flag, depth), 0)).collect();
    let push = m.restart(&m.delay_reset(&beat, depth, 0), 0);

    let lane = |side: &str, axis: &str| format!("{side}_{axis}");
    let mut lanes: Vec<(String, Signal)> = vec![];
    for (side, signals) in [("left", &left), ("right", &right)] {
        for (axis, signal) in AXES.iter().zip(signals) {
            lanes.push((lane(side, axis), m.restart(signal, 0)));
        }
    }
    for (name, flag) in ["pair", "last", "start", "end"].iter().zip(&flags) {
        lanes.push((name.to_string(), flag.clone()));
    }
    let shapes: Vec<(String, Word)> = lanes.iter().map(|(name, s)| (name.clone(), s.word())).collect();
    let log_depth = (depth + stream_fifo::OVERHEAD).next_power_of_two().ilog2();
    let ports: Vec<String> = lanes.iter().map(|(name, _)| format!("in_{name}")).collect();
    let mut inputs: Vec<(&str, &Signal)> =
        ports.iter().map(String::as_str).zip(lanes.iter().map(|(_, s)| s)).collect();
    inputs.extend([("issue", &beat), ("push", &push), ("ready", &ready)]);
    let fifo = m.instance("output_fifo", &stream_fifo::build(log_depth, &shapes)?, &inputs);
    m.drive(&has_room, fifo.out("has_room"));

    m.output("s_axis_tready", loader.out("ready"));
    let out: Vec<Signal> = lanes.iter().map(|(name, _)| fifo.out(&format!("out_{name}"))).collect();
    let vertices: Vec<(&str, &Signal)> = lanes[..6].iter().map(|(name, _)| name.as_str()).zip(&out).collect();
    let [pair, end_of_strip, start, end] = [&out[6], &out[7], &out[8], &out[9]];
    // One bit for each byte: the left vertex is always there, the right one in pairs.
    let bytes = (3 * parameters.output_lane() / 8) as usize;
    let always = m.bit(true);
    let keep: Vec<&Signal> =
        std::iter::repeat_n(pair, bytes).chain(std::iter::repeat_n(&always, bytes)).collect();
    let beat = StreamBeat {
        lanes: &vertices,
        keep: &m.concat(&keep),
        user: &m.concat(&[end, start]),
        last: end_of_strip,
        valid: &fifo.out("valid"),
    };
    m.stream_output("m_axis", parameters.output_lane(), beat);
    m.finish()
}
