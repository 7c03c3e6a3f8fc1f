//! The groups of levels in a chain between two AXI4-Streams.
//!
//! ```text
//! s_axis ──► loader ──► group 0 ──► group 1 ──► ... ──► output ──► m_axis
//!              │           └───────────┴──────────────────▲
//!              └── level of the strip: which group's columns leave
//! ```

use std::rc::Rc;

use super::buffered::COUNTS_LATE;
use super::engine::{self, Outgoing, equals, incoming_places, producer};
use super::output::{Offer, Output};
use super::ring_walk::{Times, fan_outputs, strobe_endings};
use super::schedule::Group;
use super::turns;
use super::wait::Waits;
use super::window::Producer;
use super::{Parameters, USER_BITS, control, loader, sending, walked_control, word_stage};
use crate::cores::loop_fd::AXES;
use crate::error::Result;
use crate::hdl::{Builder, Module, Placed, Signal, Word};

/// Words that steer are narrower than any that is steered.
const MOST_BITS: u32 = 5;

/// A group with its control and its three engines.
struct Stage {
    control: Placed,
    /// What leaves, by axis; and the second column where the unit makes two.
    columns: [Outgoing; 3],
    second: Option<[Outgoing; 3]>,
    /// Fans that leave by themselves, by axis: names of ports of the next window.
    fans: [Vec<(String, Signal)>; 3],
}

pub fn build(parameters: Parameters) -> Result<Rc<Module>> {
    let m = Builder::new("cc_strip");
    m.purpose("Catmull-Clark subdivision of a strip of quads: columns in, columns of the fine strip out.");
    m.parameter("coordinates", parameters.coordinates);
    m.parameter("output_fraction", parameters.output_fraction);
    m.parameter("levels", parameters.levels);
    m.parameter("max_valence", parameters.max_valence);
    m.parameter("precision", format!("{:?}", parameters.precision));
    m.parameter("table_bits", parameters.table_bits);
    m.parameter("schedule", parameters.schedule);

    let lane = parameters.coordinates.width().next_multiple_of(8);
    let port = m.stream_input("s_axis", lane, &AXES.map(|axis| (axis, parameters.input_word())), USER_BITS);
    let input = if parameters.walked() { Some(word_stage::build(&m, &port)) } else { None };
    let goes = input.as_ref().map(|stage| stage.goes.clone());
    let free = input.as_ref().map(|stage| stage.free.clone());
    let input = input.map_or(port, |stage| stage.word);
    let consumer = m.stream_ready("m_axis");
    let groups = parameters.groups();

    // What a stage needs to know of those behind it.
    let ready: Vec<Signal> =
        (0..groups.len()).map(|g| m.forward(format!("ready_{g}"), Word::bit())).collect();
    let idle = m.forward("idle", Word::bit());
    let output_ready = m.forward("output_ready", Word::bit());

    let loader = m.instance(
        "loader",
        &loader::build(parameters)?,
        &[
            ("valid", &input.valid),
            ("user", &input.user),
            ("last", &input.last),
            ("taken", &ready[0]),
            ("idle", &idle),
        ],
    );
    if let Some(goes) = goes {
        m.drive(&goes, loader.out("ready"));
    }
    m.output("s_axis_tready", free.unwrap_or(loader.out("ready")));
    // It stands long before a column of its strip leaves.
    let level = loader.out("level");
    let level = if parameters.walked() { m.restart(&m.pipe("level_late", &level), 0) } else { level };

    // A word waits until it is known what it is.
    let words: Vec<Signal> = input
        .lanes
        .iter()
        .zip(AXES)
        .map(|(word, axis)| match parameters.walked() {
            true => {
                m.restart(&m.pipe(format!("later_word_{axis}"), m.pipe(format!("late_word_{axis}"), word)), 0)
            }
            false => word.clone(),
        })
        .collect();
    let waits = Waits::new(&m, parameters);
    let mut stages: Vec<Stage> = vec![];
    for (index, group) in groups.iter().enumerate() {
        let before = index.checked_sub(1).map(|at| (&groups[at], &stages[at]));
        let flags = match before {
            None => ["accept", "begins", "ends", "first", "last_column", "top_valence", "bottom_valence"]
                .map(|name| loader.out(name)),
            Some((_, stage)) => ["next", "begins", "ends", "first", "last", "top_valence", "bottom_valence"]
                .map(|name| stage.control.out(&format!("out_{name}"))),
        };
        let names = ["valid", "begins", "ends", "first", "last", "top_valence", "bottom_valence"];
        let mut inputs: Vec<(&str, &Signal)> = names.into_iter().zip(&flags).collect();
        // Nothing is behind the last group but the output.
        let never = m.bit(false);
        let next_ready = ready.get(index + 1).unwrap_or(&never);
        inputs.extend([("level", &level), ("next_ready", next_ready), ("output_ready", &output_ready)]);
        let comes = if group.in_turn { Some(turns::comes(&m, before.is_none(), &flags[0])) } else { None };
        let from_axis = comes.as_ref().map(|comes| match before {
            Some((_, stage)) => stage.control.out("axis"),
            None => comes.axis.clone(),
        });
        inputs.extend(comes.iter().map(|comes| ("comes", &comes.comes)));
        inputs.extend(from_axis.iter().map(|axis| ("from_axis", axis)));
        let unit = match group.walked {
            true => walked_control::build(index, group, Times::of(parameters).clocks())?,
            false => control::build(index, group, parameters.registered)?,
        };
        let control = m.instance(&format!("control_{index}"), &unit, &inputs);
        m.drive(&ready[index], m.wire(format!("group_{index}_ready"), control.out("ready")));

        let unit = engine::build(parameters, index, &groups)?;
        let mut steering_late: Option<Vec<Signal>> = None;
        let mut place = |axis: usize| -> Placed {
            let mut ports = match &comes {
                Some(comes) if before.is_none() => {
                    let word = turns::word(&m, comes, &words);
                    turns::thrice(&m, incoming(&m, parameters, before, &control, &loader, &word, axis))
                }
                _ => incoming(&m, parameters, before, &control, &loader, &words[axis], axis),
            };
            if group.in_turn {
                ports.push(("in_axis".into(), control.out("looks_at")));
            }
            ports.extend(steering(group, &control));
            // Of what comes in turn every engine takes its own.
            let others = before.filter(|(before, _)| before.in_turn && !group.in_turn);
            ports.extend(others.map(|(_, stage)| (turns::OWNER.to_string(), stage.control.out("axis"))));
            if group.walked {
                let times = ports.iter().filter_map(|(_, signal)| signal.time());
                let mut data = before.map_or_else(
                    || times.max().unwrap_or(0) + 3,
                    |(_, stage)| stage.columns[axis].rows[0].time().unwrap_or(1),
                );
                if others.is_some() {
                    // The engines lie far apart: a register of its own for each.
                    let sent = ports.iter_mut().filter(|(_, signal)| !is_early(signal, data - 2));
                    for (port, signal) in sent.filter(|(_, signal)| signal.time().is_some()) {
                        *signal = m.copy(format!("{port}_of_{}", AXES[axis]), &*signal);
                    }
                    data += 1;
                }
                steering_late.get_or_insert_with(|| steer_late(&m, &waits, data - 2, index, &ports));
                let late = steering_late.iter().flatten();
                let early = |ports: &[(String, Signal)]| -> Vec<usize> {
                    (0..ports.len()).filter(|&at| is_early(&ports[at].1, data - 2)).collect()
                };
                let late: Vec<(usize, &Signal)> = early(&ports).into_iter().zip(late).collect();
                let owner = late.iter().find(|(at, _)| ports[*at].0 == turns::OWNER).map(|(_, late)| *late);
                for (at, late) in late {
                    let name = late.name().unwrap_or_default();
                    let (port, signal) = &mut ports[at];
                    let own = owner.filter(|_| turns::is_owned(port));
                    let late = own.map_or(late.clone(), |owner| late & m.is(owner, axis as i128));
                    *signal = m.copy(format!("{name}_{}", AXES[axis]), &late);
                }
                ports.retain(|(port, _)| port != turns::OWNER);
            } else if parameters.registered {
                let data = before.map_or(1, |(_, stage)| stage.columns[axis].rows[0].time().unwrap_or(1));
                own_copies(&m, data, AXES[axis], &mut ports);
            }
            let inputs: Vec<(&str, &Signal)> = ports.iter().map(|(n, s)| (n.as_str(), s)).collect();
            m.instance(&format!("engine_{index}_{}", AXES[axis]), &unit, &inputs)
        };
        let engines: Vec<Placed> = (0..if group.in_turn { 1 } else { 3 }).map(&mut place).collect();
        let engine = |axis: usize| &engines[axis.min(engines.len() - 1)];
        let columns =
            |prefix: &str| [0, 1, 2].map(|axis| Outgoing::of(engine(axis), prefix, parameters, group));
        let second = group.double.then(|| columns("face"));
        let fans = [0, 1, 2].map(|axis| fans(parameters, group, engine(axis), axis));
        stages.push(Stage { columns: columns("out"), second, fans, control });
    }
    let offers: Vec<Offer> = groups
        .iter()
        .zip(&stages)
        .map(|(group, stage)| Offer {
            group,
            control: &stage.control,
            period: if group.in_turn { sending::period(group, Times::of(parameters).clocks()) } else { 0 },
            columns: &stage.columns,
            second: stage.second.as_ref(),
        })
        .collect();
    let [room, empty] = Output::new(&m, parameters, offers, &level, consumer).build()?;
    m.drive(&output_ready, &room);
    let mut settled: Vec<Signal> = stages.iter().map(|stage| stage.control.out("idle")).collect();
    settled.push(empty);
    let comes = m.wire("comes_in", loader.out("comes") | loader.out("accept"));
    let mut comes = comes;
    if parameters.walked() {
        // From wherever they are to a register beside the loader's; what is issued counts later than a level that
        // rests, and a word a clock later than it comes.
        let accepted = m.restart(&m.pipe_reset("came_in", loader.out("accept"), 0), 0);
        comes = m.wire("comes_or_came", &comes | &accepted);
        let known = |at: usize, now: &Signal, clocks: u32| {
            m.restart(&m.delay_reset(&m.wire(format!("rests_{at}"), now), clocks, 1), 0)
        };
        let levels = settled.len() - 1;
        settled = settled
            .iter()
            .enumerate()
            .map(|(at, now)| known(at, now, 1 + if at < levels { COUNTS_LATE } else { 0 }))
            .collect();
        settled.push(known(levels + 1, &!&comes, 1));
    }
    let all_idle = m.wire("all_idle", m.all(&settled.iter().collect::<Vec<_>>()));
    if parameters.registered {
        // Known a clock late: a word that came in then may be the last of a column.
        let was_idle = m.register_reset("was_idle", Word::bit(), 1);
        m.always(&was_idle, &all_idle & &!comes);
        m.drive(&idle, &was_idle);
    } else {
        m.drive(&idle, &all_idle);
    }
    m.finish()
}

/// The fans that leave a group by themselves, of a coordinate.
fn fans(parameters: Parameters, group: &Group, engine: &Placed, axis: usize) -> Vec<(String, Signal)> {
    if !group.walked || group.finest() + 1 == parameters.levels {
        return vec![];
    }
    let endings = strobe_endings(parameters, group.finest());
    let port = |name: &String| match endings.get(axis).filter(|_| endings.len() > 1) {
        // Strobes of the other coordinates are for other engines.
        Some(ending) if name.contains("_fan_") => name.strip_suffix(ending.as_str()).map(String::from),
        _ => Some(name.clone()),
    };
    let names = fan_outputs(parameters, group.finest());
    names.iter().filter_map(|name| Some((port(name)?, engine.out(&format!("out_{name}"))))).collect()
}

/// What the window of a group's first level takes in.
fn incoming(
    m: &Builder,
    parameters: Parameters,
    before: Option<(&Group, &Stage)>,
    control: &Placed,
    loader: &Placed,
    word: &Signal,
    axis: usize,
) -> Vec<(String, Signal)> {
    let Some((group, stage)) = before else {
        let mut ports =
            vec![("in_shift".to_string(), control.out("shift_0")), ("in_word".to_string(), word.clone())];
        for place in incoming_places(parameters, 0, Producer::Words) {
            ports.push((format!("in_write_{place}"), loader.out(&format!("write_{place}"))));
        }
        return ports;
    };
    let level = group.finest() + 1;
    let from = producer(Some(group));
    let mut ports = vec![("in_shift".to_string(), control.out(&format!("shift_{level}")))];
    if group.walked {
        ports.extend(stage.fans[axis].iter().map(|(name, signal)| (format!("in_{name}"), signal.clone())));
    } else {
        let fans = if group.double { m.bit(true) } else { !stage.control.out("face") };
        ports.push(("in_fans".to_string(), fans));
    }
    let outgoing = &stage.columns[axis];
    let signals = outgoing.rows.iter().take(parameters.rows(level)).chain(&outgoing.outside);
    for (place, signal) in incoming_places(parameters, level, from).into_iter().zip(signals) {
        ports.push((format!("in_{place}"), signal.clone()));
    }
    let write = control.out(&format!("write_{level}"));
    let slices = group.slices(group.finest());
    let bits: Vec<Signal> = match slices {
        1 => vec![],
        _ => (0..slices.ilog2()).map(|at| m.slice(&stage.control.out("slice"), at, 1)).collect(),
    };
    let reads_rows = parameters.reads_rows(level);
    if reads_rows {
        ports.push(("in_comes".to_string(), write.clone()));
        ports.push(("in_from".to_string(), stage.control.out("slice")));
    }
    for p in (0..slices).filter(|p| !reads_rows || *p == 0 || p + 1 == slices) {
        let here = equals(m, &bits, p);
        ports.push((format!("in_write_{p}"), here.map_or(write.clone(), |here| &write & &here)));
    }
    ports
}

/// Brings the ports of an engine to the clock of its data, the last one by a register that no other engine reads.
fn own_copies(m: &Builder, data: u32, axis: &str, ports: &mut [(String, Signal)]) {
    for (port, signal) in ports {
        if signal.time().is_some_and(|time| time < data) {
            *signal = m.copy(format!("{port}_{data}_{axis}"), m.at_time(signal, data - 1));
        }
    }
}

/// Whether a port is for what steers an engine, and comes before a clock.
fn is_early(signal: &Signal, clock: u32) -> bool {
    signal.width() <= MOST_BITS && signal.time().is_some_and(|time| time < clock)
}

/// What steers the engines of a group at a later clock, by way of RAMs: control is far ahead of the data.
fn steer_late(
    m: &Builder,
    waits: &Waits,
    clock: u32,
    index: usize,
    ports: &[(String, Signal)],
) -> Vec<Signal> {
    let early = ports.iter().filter(|(_, signal)| is_early(signal, clock));
    // A register before each RAM.
    let signals: Vec<(String, Signal)> = early
        .map(|(port, signal)| (format!("{port}_{index}"), m.pipe(format!("{port}_{index}_sent"), signal)))
        .collect();
    let late = waits.until(&format!("steering_slot_{index}"), &signals, clock);
    signals.iter().zip(late).map(|((name, _), signal)| m.wire(format!("{name}_steers"), &signal)).collect()
}

/// What steers the engine of a group beside the column that comes in.
fn steering(group: &Group, control: &Placed) -> Vec<(String, Signal)> {
    let mut ports = vec![];
    let mut copy = |port: String, from: &str| ports.push((port, control.out(from)));
    for level in group.levels.clone().skip(1) {
        copy(format!("shift_{level}"), &format!("shift_{level}"));
        copy(format!("write_{level}"), &format!("write_{level}"));
    }
    if group.levels.clone().count() > 1 {
        group.levels.clone().for_each(|l| copy(format!("serve_{l}"), &format!("serve_{l}")));
    }
    if engine::slice_bits(group) > 0 {
        copy("slice".into(), "slice");
    }
    if !group.double {
        copy("face".into(), "face");
    }
    if group.walked {
        copy("walk".into(), "walk");
    }
    copy("top_valence".into(), "top_degree");
    copy("bottom_valence".into(), "bottom_degree");
    ports
}
