//! The levels in a chain between two AXI4-Streams: the pipelined schedule.

use std::rc::Rc;

use super::level::{self, column_names};
use super::{Parameters, USER_BITS, control, loader};
use crate::cores::loop_fd::AXES;
use crate::error::Result;
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Module, Placed, Signal, Word};

/// A column that one stage offers to the next.
struct Offer {
    valid: Signal,
    first: Signal,
    last: Signal,
    /// The vertex column before the last face column: the last one to be seen.
    ending: Signal,
    valences: [Signal; 2],
    /// Its vertices for each axis, in the order of [`column_names`].
    places: [Vec<Signal>; 3],
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

    let lane = parameters.coordinates.width().next_multiple_of(8);
    let input = m.stream_input("s_axis", lane, &AXES.map(|axis| (axis, parameters.input_word())), USER_BITS);
    let consumer = m.stream_ready("m_axis");

    // Whether each stage may send its column on; driven by the stage behind it.
    let taken: Vec<Signal> =
        (0..=parameters.levels).map(|l| m.forward(format!("taken_{l}"), Word::bit())).collect();
    let loader = m.instance(
        "loader",
        &loader::control(parameters)?,
        &[("valid", &input.valid), ("user", &input.user), ("last", &input.last), ("taken", &taken[0])],
    );
    m.output("s_axis_tready", loader.out("ready"));
    let mut offer = gathered(&m, parameters, &loader, &input.lanes)?;
    for level in 0..parameters.levels {
        offer = subdivided(&m, parameters, level, offer, &taken)?;
    }

    // Guards are not seen; the others are rounded and kept until the consumer takes them.
    let seen = m.wire("seen", m.all(&[&offer.valid, &!&offer.first, &!&offer.last]));
    let full = m.register_reset("full", Word::bit(), 0);
    let free = m.wire("free", !&full | &consumer);
    m.drive(&taken[parameters.levels as usize], m.wire("column_goes", &offer.valid & &free));
    let keep = m.wire("keep", &seen & &free);
    m.on(&keep, &full, m.bit(true));
    m.on(&consumer, &full, m.bit(false));
    let ending = m.register("strip_end", Word::bit());
    m.on(&keep, &ending, &offer.ending);

    let mut lanes: Vec<(String, Signal)> = vec![];
    let extra = parameters.extra_fraction(parameters.levels) + parameters.coordinates.fraction;
    for row in 0..parameters.rows(parameters.levels) {
        for (axis, places) in AXES.iter().zip(&offer.places) {
            let result: Word = Range::signed(parameters.output_width()).into();
            let result = result.fraction(parameters.output_fraction as i32);
            let rounded = m.round(&places[row], extra - parameters.output_fraction, Rounding::HalfUp);
            let register = m.register(format!("row_{row}_{axis}_kept"), result);
            m.on(&keep, &register, m.wrap(&rounded, result));
            lanes.push((format!("row{row}_{axis}"), register));
        }
    }
    let lanes: Vec<(&str, &Signal)> = lanes.iter().map(|(n, s)| (n.as_str(), s)).collect();
    m.output_bus("m_axis_tdata", parameters.output_width().next_multiple_of(8), &lanes);
    m.output("m_axis_tlast", &ending);
    m.output("m_axis_tvalid", &full);
    m.finish()
}

/// The column that the loader has gathered.
fn gathered(m: &Builder, parameters: Parameters, loader: &Placed, lanes: &[Signal]) -> Result<Offer> {
    let column = loader::column(parameters)?;
    let names = column_names(parameters, 0);
    let writes: Vec<(String, Signal)> = names
        .iter()
        .map(|name| {
            let port = format!("write_{name}");
            let signal = loader.out(&port);
            (port, signal)
        })
        .collect();
    let place = |axis: usize| -> Vec<Signal> {
        let mut inputs: Vec<(&str, &Signal)> = writes.iter().map(|(n, s)| (n.as_str(), s)).collect();
        inputs.push(("word", &lanes[axis]));
        let placed = m.instance(&format!("column_{}", AXES[axis]), &column, &inputs);
        // Guard bits stand below the point from the first level on.
        let guard = parameters.extra_fraction(0);
        let fraction = parameters.word(0).fraction;
        names.iter().map(|name| m.rescale(&m.signal(&placed.out(name) << guard), fraction)).collect()
    };
    Ok(Offer {
        valid: loader.out("full"),
        first: loader.out("first"),
        last: loader.out("ending"),
        ending: loader.out("ending"),
        valences: [loader.out("top_valence"), loader.out("bottom_valence")],
        places: [place(0), place(1), place(2)],
    })
}

/// One level: its control, and a window for each axis.
fn subdivided(
    m: &Builder,
    parameters: Parameters,
    level: u32,
    offer: Offer,
    taken: &[Signal],
) -> Result<Offer> {
    let (this, next) = (level as usize, level as usize + 1);
    let control = m.instance(
        &format!("control_{level}"),
        &control::build()?,
        &[
            ("valid", &offer.valid),
            ("first", &offer.first),
            ("last", &offer.last),
            ("top_valence", &offer.valences[0]),
            ("bottom_valence", &offer.valences[1]),
            ("out_ready", &taken[next]),
        ],
    );
    m.drive(&taken[this], m.wire(format!("goes_{level}"), control.out("arrive")));
    let unit = level::build(parameters, level)?;
    let [arrive, face] = ["arrive", "is_face"].map(|n| control.out(n));
    let [top, bottom] = ["top_degree", "bottom_degree"].map(|n| control.out(n));
    let names = column_names(parameters, level);
    let finer = column_names(parameters, level + 1);
    let place = |axis: usize| -> Vec<Signal> {
        let mut inputs: Vec<(&str, &Signal)> =
            names.iter().map(String::as_str).zip(&offer.places[axis]).collect();
        inputs.extend([
            ("arrive", &arrive),
            ("face", &face),
            ("top_valence", &top),
            ("bottom_valence", &bottom),
        ]);
        let placed = m.instance(&format!("level_{level}_{}", AXES[axis]), &unit, &inputs);
        finer.iter().map(|name| placed.out(&format!("out_{name}"))).collect()
    };
    Ok(Offer {
        valid: control.out("out_valid"),
        first: control.out("out_first"),
        last: control.out("out_last"),
        ending: control.out("ending"),
        valences: [control.out("top_out"), control.out("bottom_out")],
        places: [place(0), place(1), place(2)],
    })
}
