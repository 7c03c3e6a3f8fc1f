//! The proof by linear forms that a generated `loop-fd` computes its masks, for all inputs.
//!
//! One run feeds patches of every level, back to back, whose control points are variables; what reaches
//! the output must be, beat by beat,
//!
//! ```text
//! floor((sum mask[m](i, j) P_m + 3 * 2^(s-1)) / (3 * 2^s))
//! ```
//!
//! with the masks of the quartic box spline. Each patch has variables of its own, so a value left over
//! from another patch cannot pass for the right one; whatever no reset has set is unknown, and an unknown
//! at an output fails.

use std::rc::Rc;

use super::{AXES, Parameters};
use crate::error::{Error, Kind, Result};
use crate::fixed::{Form, Range};
use crate::hdl::fault::Fault;
use crate::hdl::linear::Value;
use crate::hdl::{Flat, LinearForms, Module, NodeId, Simulator};
use crate::surface::basis;

/// What was proved.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Proof {
    /// Patches fed: one of each level, and one of three limit positions.
    pub patches: u32,
    /// Coordinates of vertices whose form was compared with the mask.
    pub coordinates: u64,
    pub clocks: u64,
    /// Every claim with the largest range that occurs, and the range claimed.
    pub claims: Vec<Claim>,
}

#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Claim {
    pub signal: String,
    pub occurs: String,
    pub claimed: String,
}

/// One packet of the run.
struct Patch {
    level: u32,
    /// The control points that are variables; the others are 0.
    variables: Vec<usize>,
    range: Range,
}

fn patches(parameters: Parameters) -> Vec<Patch> {
    let (w, r) = (parameters.coordinates.width(), parameters.max_level);
    let coordinate = Range::signed(w);
    let regular = |level| Patch {
        level,
        variables: (0..12).collect(),
        // A control point of a patch of this level carries 4 (R - level) more fraction bits.
        range: coordinate * (1i128 << (4 * (r - level))),
    };
    // Three limit positions over 12 * 16^R, sent as a patch of level 0.
    let positions = Patch { level: 0, variables: vec![0, 2, 10], range: coordinate * (12i128 << (4 * r)) };
    (0..=r).rev().map(regular).chain([positions]).collect()
}

/// Runs the proof; an error is a refutation, with the first signal or vertex that is wrong.
pub fn prove(core: &Rc<Module>, parameters: Parameters) -> Result<Proof> {
    prove_flat(Flat::new(core)?, parameters)
}

/// The same for a core laid out flat, which may have been changed since.
pub fn prove_flat(flat: Flat, parameters: Parameters) -> Result<Proof> {
    run(flat, parameters, None)
}

/// Whether a fault changes nothing: the proof of the design that has it.
///
/// In a data path a lost carry is no linear function; there the proof shows that no carry arises, or that
/// the bits from there on do not matter.
pub fn prove_fault(flat: &Flat, fault: &Fault, parameters: Parameters) -> Result<Proof> {
    let broken = run(fault.apply(flat)?, parameters, None);
    match fault.dropped_carry() {
        Some(carry) if broken.is_err() => run(flat.clone(), parameters, Some(carry)),
        _ => broken,
    }
}

fn run(flat: Flat, parameters: Parameters, dropped_carry: Option<(NodeId, u32)>) -> Result<Proof> {
    let patches = patches(parameters);
    let groups = patches.iter().flat_map(|patch| [patch.range; 3]).collect();
    let mut run = Run::new(flat, groups)?;
    run.simulator.domain.dropped_carry = dropped_carry;
    let mut sent =
        patches.iter().enumerate().flat_map(|(index, patch)| (0..12).map(move |point| (index, patch, point)));
    let mut expected =
        patches.iter().enumerate().flat_map(|(index, patch)| beats(index, patch, parameters)).peekable();
    let (mut offered, mut coordinates, mut quiet) = (sent.next(), 0, 0);

    run.edge(true)?;
    while expected.peek().is_some() {
        run.offer(offered);
        if run.flag("m_axis_tvalid")? {
            // The loop runs while there is a beat to come.
            let Some(beat) = expected.next() else { break };
            coordinates += run.compare(&beat)?;
            quiet = 0;
        }
        quiet += 1;
        if quiet > 1000 {
            return Err(refuted(format!("no output for {quiet} clocks")));
        }
        if run.flag("s_axis_tready")? && offered.is_some() {
            offered = sent.next();
        }
        run.edge(false)?;
    }
    if let Some(failure) = run.simulator.domain.failures.first() {
        return Err(Error { kind: Kind::Mismatch, ..failure.clone() });
    }
    let flat = &run.simulator.flat;
    let claim = |(&id, &range): (&NodeId, &Range)| Claim {
        signal: flat.describe(id),
        occurs: range.to_string(),
        claimed: flat.node(id).word.range.to_string(),
    };
    Ok(Proof {
        patches: patches.len() as u32,
        coordinates,
        clocks: run.simulator.clock_count(),
        claims: run.simulator.domain.proved.iter().map(claim).collect(),
    })
}

fn refuted(why: String) -> Error {
    Error::new(Kind::Mismatch, format!("the proof by linear forms fails: {why}"))
        .help("the core is wrong for some input; nothing was written")
}

/// A beat that must come out: where it lies, and the forms of its vertices.
struct Beat {
    what: String,
    left: [Form<12>; 3],
    right: Option<[Form<12>; 3]>,
    user: i128,
}

/// The beats of a patch in the order of its strips.
fn beats(index: usize, patch: &Patch, parameters: Parameters) -> impl Iterator<Item = Beat> + '_ {
    let steps = 1u32 << patch.level;
    let vertex = move |i: u32, j: u32| {
        let mask = basis::mask(patch.level, i, j);
        let mut coefficients = [0; 12];
        patch.variables.iter().for_each(|&v| coefficients[v] = mask[v]);
        let unit = 3i128 << parameters.shift();
        [0, 1, 2].map(|axis| {
            Form {
                coefficients,
                constant: unit / 2,
                divisor: unit,
                ..Form::variable(3 * index as u32 + axis, 0)
            }
            .canonical()
        })
    };
    (0..steps).flat_map(move |i| {
        (0..=steps - i).map(move |j| {
            let single = j == steps - i;
            let (first, last) = (i == 0 && j == 0, i + 1 == steps && single);
            Beat {
                what: format!("patch {index} (level {}), strip {i}, row {j}", patch.level),
                left: vertex(i, j),
                right: (!single).then(|| vertex(i + 1, j)),
                user: i128::from(first) + 2 * i128::from(last),
            }
        })
    })
}

/// The core in the simulator, and its ports.
struct Run {
    simulator: Simulator<LinearForms<12>>,
    inputs: [NodeId; 3],
    controls: [NodeId; 4],
    sides: [[NodeId; 3]; 2],
}

impl Run {
    fn new(flat: Flat, groups: Vec<Range>) -> Result<Run> {
        let port = |found: Option<NodeId>, name: &str| {
            found.ok_or_else(|| Error::usage(format!("the core has no port {name}")))
        };
        let input = |name: &str| port(flat.input(name), name);
        let output = |name: String| port(flat.output(&name), &name);
        let [x, y, z] = AXES.map(|axis| input(&format!("s_axis_tdata_{axis}")));
        let [user, last, valid, ready] =
            ["s_axis_tuser", "s_axis_tlast", "s_axis_tvalid", "m_axis_tready"].map(input);
        let side = |side: &str| -> Result<[NodeId; 3]> {
            let [x, y, z] = AXES.map(|axis| output(format!("m_axis_tdata_{side}_{axis}")));
            Ok([x?, y?, z?])
        };
        let sides = [side("left")?, side("right")?];
        let (inputs, controls) = ([x?, y?, z?], [user?, last?, valid?, ready?]);
        let mut run =
            Run { simulator: Simulator::new(flat, LinearForms::new(groups)), inputs, controls, sides };
        run.offer(None);
        Ok(run)
    }

    /// Puts a control point, or nothing, at the input, with the output always ready.
    fn offer(&mut self, point: Option<(usize, &Patch, usize)>) {
        let simulator = &mut self.simulator;
        for (axis, &input) in self.inputs.iter().enumerate() {
            let value = match point {
                Some((index, patch, point)) if patch.variables.contains(&point) => {
                    Value::Form(Form::variable((3 * index + axis) as u32, point))
                }
                Some(_) => Value::Integer(0),
                None => Value::Unknown,
            };
            simulator.set(input, value);
        }
        let level = point.map_or(0, |(_, patch, _)| patch.level.into());
        let last = point.is_some_and(|(_, _, point)| point == 11);
        let values = [level, last.into(), point.is_some().into(), 1];
        for (&control, value) in self.controls.iter().zip(values) {
            simulator.set(control, Value::Integer(value));
        }
        simulator.settle();
    }

    fn edge(&mut self, reset: bool) -> Result<()> {
        self.simulator.edge(reset)
    }

    fn output(&self, name: &str) -> Result<i128> {
        let id = self.simulator.flat.output(name);
        match id.map(|id| self.simulator.get(id)) {
            Some(Value::Integer(value)) => Ok(*value),
            _ => Err(refuted(format!("{name} is not known at clock {}", self.simulator.clock_count()))),
        }
    }

    fn flag(&self, name: &str) -> Result<bool> {
        Ok(self.output(name)? != 0)
    }

    /// Checks what stands at the output; returns how many coordinates were compared.
    fn compare(&self, beat: &Beat) -> Result<u64> {
        let wrong = |what: &str| Err(refuted(format!("{}: {what}", beat.what)));
        if self.flag("m_axis_tlast")? == beat.right.is_some() {
            return wrong("m_axis_tlast does not mark the end of the strip");
        }
        if self.output("m_axis_tuser")? != beat.user {
            return wrong("m_axis_tuser does not mark the ends of the patch");
        }
        let kept = self.output("m_axis_tkeep")?.count_ones();
        let all = self
            .simulator
            .flat
            .output("m_axis_tkeep")
            .map_or(0, |id| self.simulator.flat.node(id).word.width());
        if kept != if beat.right.is_some() { all } else { all / 2 } {
            return wrong("m_axis_tkeep does not tell whether there is a right vertex");
        }
        let mut compared = 0;
        for (ids, expected) in self.sides.iter().zip([Some(&beat.left), beat.right.as_ref()]) {
            for ((&id, expected), axis) in ids.iter().zip(expected.into_iter().flatten()).zip(AXES) {
                match self.simulator.get(id) {
                    Value::Form(form) if form.canonical() == *expected => compared += 1,
                    Value::Form(_) => {
                        return wrong(&format!("{axis} is another function of the control points"));
                    }
                    // With all its control points 0, as for a mask without variables.
                    Value::Integer(_) => {
                        return wrong(&format!("{axis} does not depend on the control points"));
                    }
                    Value::Unknown => return wrong(&self.unknown(axis)),
                }
            }
        }
        Ok(compared)
    }

    /// An unknown value mostly has a cause that was noted when it arose.
    fn unknown(&self, axis: &str) -> String {
        match self.simulator.domain.failures.first() {
            Some(cause) => format!("{axis} is unknown, as {cause}"),
            None => format!("{axis} is no function of the control points, or was never set"),
        }
    }
}
