//! The units put together between two AXI4-Streams.

use std::rc::Rc;

use super::{AXES, LEVEL_BITS, Parameters, control, engine, loader, startup};
use crate::cores::stream_fifo;
use crate::error::Result;
use crate::fixed::Precision;
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
            ("point_x", &points.lanes[0]),
            ("point_y", &points.lanes[1]),
            ("point_z", &points.lanes[2]),
            ("slot_free", &!&reserved),
        ],
    );

    let names: Vec<String> = (0..12).map(|i| format!("p{i}")).collect();
    let p: Vec<Signal> = names.iter().map(|name| loader.out(name)).collect();
    let patch_level = loader.out("level");
    let mut inputs: Vec<(&str, &Signal)> = names.iter().map(String::as_str).zip(&p).collect();
    inputs.push(("level", &patch_level));
    let handed_over = loader.out("strobe");
    if parameters.precision != Precision::Exact {
        inputs.push(("valid", &handed_over));
    }
    let startup = m.instance("startup", &startup::build(parameters)?, &inputs);
    let differences: Vec<(String, Signal)> = engine::DIFFERENCES
        .iter()
        .map(|(k, l)| (format!("n{k}{l}"), m.restart(&startup.out(&format!("n{k}{l}")), 0)))
        .collect();

    // What belongs to the axis that leaves the start-up now.
    let arrival = startup.out("n00").time().unwrap_or(0);
    let arrive = |signal: &Signal| m.restart(&m.at_time(signal, arrival), 0);
    let strobe = loader.out("strobe");
    let strobe = m.restart(&m.delay_reset(&strobe, arrival - strobe.time().unwrap_or(0), 0), 0);
    let axis = arrive(&loader.out("axis_out"));
    let arrived_level = arrive(&patch_level);
    let captures = [0, 1, 2]
        .map(|index| m.wire(format!("capture_{}", AXES[index]), &strobe & m.is(&axis, index as i128)));
    let waiting_level = m.register("waiting_level", arrived_level.word());
    m.on(&captures[2], &waiting_level, &arrived_level);

    let has_room = m.forward("has_room", Word::bit());
    let control = m.instance(
        "control",
        &control::build(parameters)?,
        &[("waiting", &waiting), ("level", &waiting_level), ("has_room", &has_room)],
    );
    let [load, strip, step] = ["load", "strip", "step"].map(|name| control.out(name));
    let [beat, pair] = ["valid", "pair"].map(|name| control.out(name));
    m.on(&captures[2], &waiting, m.bit(true));
    m.on(&load, &waiting, m.bit(false));
    m.on(&loader.out("begins"), &reserved, m.bit(true));
    m.on(&load, &reserved, m.bit(false));

    let engine = engine::build(parameters)?;
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
    let flags = ["pair", "strip_end", "patch_start", "patch_end"].map(|name| control.out(name));
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
    // Credits must cover the way there and back: the pipeline, the RAM's write and read, the credit.
    let log_depth = (depth + 6).next_power_of_two().ilog2();
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
