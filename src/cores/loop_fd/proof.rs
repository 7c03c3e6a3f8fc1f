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
//!
//! Reduced numbers round on the way. What reaches the output then is the mask *and an error whose bounds are
//! known*: every rounding that the hardware does adds its own, and no register that a vertex depends on can
//! overflow, whatever the control points are. The bounds of all vertices together are the result. Patches at
//! boundaries are run too, with ghosts that are combinations of the other points, at the coarse levels,
//! where differences are largest. (Saturation is left out: a clamp only moves a vertex towards the exact one,
//! which lies in the format.)

use std::rc::Rc;

use super::{AXES, Parameters};
use crate::error::{Error, Kind, Result};
use crate::fixed::{Form, Near, Precision, Range, Reduced};
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
    /// Of reduced numbers: how far a vertex can be from the exact one.
    pub error: Option<ErrorBounds>,
}

/// Output less exact vertex, in units of the output's last place: at least `below`, at most `above`, each a
/// numerator and a denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ErrorBounds {
    pub below: (i128, i128),
    pub above: (i128, i128),
}

impl ErrorBounds {
    /// The larger of both, as a distance, rounded to `f64`.
    pub fn largest(&self) -> f64 {
        let number = |(numerator, denominator): (i128, i128)| numerator as f64 / denominator as f64;
        (-number(self.below)).max(number(self.above))
    }

    fn union(self, other: ErrorBounds) -> ErrorBounds {
        let less = |(a, b): (i128, i128), (c, d): (i128, i128)| a * d < c * b;
        ErrorBounds {
            below: if less(other.below, self.below) { other.below } else { self.below },
            above: if less(self.above, other.above) { other.above } else { self.above },
        }
    }
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
    /// The control points that are variables; the others are ghosts, or 0.
    variables: Vec<usize>,
    /// Points V + B - I, and of which points.
    ghosts: Vec<(usize, [usize; 3])>,
    range: Range,
}

impl Patch {
    /// A control point as a form over the variables of a group.
    fn point(&self, group: u32, point: usize) -> Value<12> {
        let mut form = Form::variable(group, point);
        if let Some((_, [v, b, i])) = self.ghosts.iter().find(|(ghost, _)| *ghost == point) {
            form.coefficients = [0; 12];
            (form.coefficients[*v], form.coefficients[*b], form.coefficients[*i]) = (1, 1, -1);
        } else if !self.variables.contains(&point) {
            return Value::Integer(0);
        }
        Value::Form(form)
    }
}

fn patches(parameters: Parameters) -> Vec<Patch> {
    let (w, r) = (parameters.coordinates.width(), parameters.max_level);
    let coordinate = Range::signed(w);
    let with_ghosts = |level, ghosts: &[(usize, [usize; 3])]| Patch {
        level,
        variables: (0..12).filter(|v| !ghosts.iter().any(|(g, _)| g == v)).collect(),
        ghosts: ghosts.to_vec(),
        // A control point of a patch of this level carries 4 (R - level) more fraction bits.
        range: coordinate * (1i128 << (4 * (r - level))),
    };
    // Three limit positions over 12 * 16^R, sent as a patch of level 0.
    let range = coordinate * (12i128 << (4 * r));
    let positions = Patch { level: 0, variables: vec![0, 2, 10], ghosts: vec![], range };
    let regular = (parameters.min_level..=r).rev().map(|level| with_ghosts(level, &[]));
    let positions = (parameters.min_level == 0).then_some(positions);
    // Exact vertices are in the hull whatever their ghosts are; differences, where their words are narrow, are not.
    let modular = parameters.precision == Precision::Exact && parameters.min_level == 0;
    let ghosted = if modular { 0 } else { 3 };
    let ghosts = (parameters.min_level..=r).take(ghosted).flat_map(|level| {
        BOUNDARIES.map(|way| {
            let ghosts: Vec<_> = way.iter().flat_map(|&at| GHOSTS[at]).copied().collect();
            with_ghosts(level, &ghosts)
        })
    });
    regular.chain(ghosts).chain(positions).collect()
}

/// Points V + B - I, across a boundary edge (V, B) with the point I inside: of a patch whose edge (0,1), (1,2)
/// or (2,0) is at the boundary, and of one that touches it with corner 0, 1 or 2 alone.
const GHOSTS: [&[(usize, [usize; 3])]; 6] = [
    &[(0, [4, 3, 7]), (1, [4, 5, 8]), (2, [5, 6, 9])],
    &[(6, [5, 2, 1]), (9, [5, 8, 4]), (11, [8, 10, 7])],
    &[(10, [8, 11, 9]), (7, [8, 4, 5]), (3, [4, 0, 1])],
    &[(3, [4, 7, 8]), (0, [4, 1, 5])],
    &[(2, [5, 1, 4]), (6, [5, 9, 8])],
    &[(11, [8, 9, 5]), (10, [8, 7, 4])],
];

/// All ways a regular patch can lie at boundaries, as places in [`GHOSTS`]: edges, corners, an edge and the
/// corner across.
const BOUNDARIES: [&[usize]; 13] =
    [&[0], &[1], &[2], &[3], &[4], &[5], &[3, 4], &[4, 5], &[3, 5], &[3, 4, 5], &[0, 5], &[1, 3], &[2, 4]];

/// Runs the proof; an error is a refutation, with the first signal or vertex that is wrong.
pub fn prove(core: &Rc<Module>, parameters: Parameters) -> Result<Proof> {
    if let Some(reduced) = parameters.precision.reduced().filter(|reduced| reduced.saturate) {
        let plain = Parameters {
            precision: Precision::Reduced(Reduced { saturate: false, ..reduced }),
            ..parameters
        };
        return prove(&super::build(plain)?, plain);
    }
    if parameters.chunk.is_some() {
        // Chunks change when, not what; the numbers are proved whole.
        let whole = Parameters { chunk: None, ..parameters };
        return prove(&super::build(whole)?, whole);
    }
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
    let mut run = Run::new(flat, groups, parameters)?;
    run.simulator.domain.dropped_carry = dropped_carry;
    let mut sent =
        patches.iter().enumerate().flat_map(|(index, patch)| (0..12).map(move |point| (index, patch, point)));
    let mut expected =
        patches.iter().enumerate().flat_map(|(index, patch)| beats(index, patch, parameters)).peekable();
    let (mut offered, mut coordinates, mut quiet, mut error) = (sent.next(), 0, 0, None);

    // A buffered column fills its memory before the first beat of a patch.
    let patience = 1000 + (1u64 << parameters.max_level);
    run.edge(true)?;
    while expected.peek().is_some() {
        run.offer(offered);
        if run.flag("m_axis_tvalid")? {
            // The loop runs while there is a beat to come.
            let Some(beat) = expected.next() else { break };
            coordinates += run.compare(&beat, parameters, &mut error)?;
            quiet = 0;
        }
        quiet += 1;
        if quiet > patience {
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
        error,
    })
}

fn refuted(why: String) -> Error {
    Error::new(Kind::Mismatch, format!("the proof by linear forms fails: {why}"))
        .help("the core is wrong for some input; nothing was written")
}

/// A beat that must come out: where it lies, and the forms of its vertices, where there is one.
struct Beat {
    what: String,
    vertices: Vec<Option<[Form<12>; 3]>>,
    last: bool,
    user: i128,
}

/// The beats of a patch in the order of its strips.
fn beats(index: usize, patch: &Patch, parameters: Parameters) -> impl Iterator<Item = Beat> + '_ {
    let steps = 1u32 << patch.level;
    let vertex = move |i: u32, j: u32| {
        let mask = basis::mask(patch.level, i, j);
        let mut coefficients = [0; 12];
        patch.variables.iter().for_each(|&v| coefficients[v] = mask[v]);
        for &(ghost, [v, b, i]) in &patch.ghosts {
            coefficients[v] += mask[ghost];
            coefficients[b] += mask[ghost];
            coefficients[i] -= mask[ghost];
        }
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
    let lanes = parameters.lanes.unwrap_or(1);
    (0..steps).step_by(lanes as usize).flat_map(move |i| {
        (0..=steps - i).map(move |j| {
            let (first, last) = (i == 0 && j == 0, j == steps - i);
            let end = last && i + lanes >= steps;
            Beat {
                what: format!("patch {index} (level {}), strip {i}, row {j}", patch.level),
                vertices: (0..=lanes).map(|k| (i + k + j <= steps).then(|| vertex(i + k, j))).collect(),
                last,
                user: i128::from(first) + 2 * i128::from(end),
            }
        })
    })
}

/// The core in the simulator, and its ports.
struct Run {
    simulator: Simulator<LinearForms<12>>,
    inputs: [NodeId; 3],
    controls: [NodeId; 4],
    /// The coordinates of each vertex of a beat.
    vertices: Vec<[NodeId; 3]>,
}

impl Run {
    fn new(flat: Flat, groups: Vec<Range>, parameters: Parameters) -> Result<Run> {
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
        let vertices = match parameters.lanes {
            None => vec![side("left")?, side("right")?],
            Some(lanes) => (0..=lanes).map(|k| side(&format!("v{k}"))).collect::<Result<_>>()?,
        };
        let (inputs, controls) = ([x?, y?, z?], [user?, last?, valid?, ready?]);
        let mut run =
            Run { simulator: Simulator::new(flat, LinearForms::new(groups)), inputs, controls, vertices };
        run.offer(None);
        Ok(run)
    }

    /// Puts a control point, or nothing, at the input, with the output always ready.
    fn offer(&mut self, point: Option<(usize, &Patch, usize)>) {
        let simulator = &mut self.simulator;
        for (axis, &input) in self.inputs.iter().enumerate() {
            let value = match point {
                Some((index, patch, point)) => patch.point((3 * index + axis) as u32, point),
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

    /// Checks what stands at the output, and widens the bounds of the error; returns how many coordinates were
    /// compared.
    fn compare(&self, beat: &Beat, parameters: Parameters, error: &mut Option<ErrorBounds>) -> Result<u64> {
        let reduced = parameters.precision != Precision::Exact;
        let wrong = |what: &str| Err(refuted(format!("{}: {what}", beat.what)));
        if self.flag("m_axis_tlast")? != beat.last {
            return wrong("m_axis_tlast does not mark the end of the strip");
        }
        if self.output("m_axis_tuser")? != beat.user {
            return wrong("m_axis_tuser does not mark the ends of the patch");
        }
        let kept = self.kept()?;
        if kept.len() != beat.vertices.len()
            || kept.iter().zip(&beat.vertices).any(|(k, v)| *k != v.is_some())
        {
            return wrong("m_axis_tkeep does not tell which vertices there are");
        }
        let mut compared = 0;
        for (ids, expected) in self.vertices.iter().zip(&beat.vertices) {
            for ((&id, expected), axis) in ids.iter().zip(expected.iter().flatten()).zip(AXES) {
                let value = self.simulator.get(id);
                if let (true, Some(bounds)) = (reduced, within(value, expected)) {
                    *error = Some(error.map_or(bounds, |all: ErrorBounds| all.union(bounds)));
                    compared += 1;
                    continue;
                }
                match value {
                    Value::Form(form) if form.canonical() == *expected => compared += 1,
                    Value::Form(_) | Value::Near(_) => {
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

    /// Which vertices are kept, each with all of its bytes.
    fn kept(&self) -> Result<Vec<bool>> {
        let flat = &self.simulator.flat;
        let width = |name: &str| flat.output(name).map_or(0, |id| flat.node(id).word.width());
        // One port for all of them, or one for each.
        let words = match width("m_axis_tkeep") {
            0 => (0..self.vertices.len())
                .map(|k| format!("m_axis_tkeep_v{k}"))
                .map(|name| Ok((self.output(&name)?, width(&name))))
                .collect::<Result<Vec<_>>>()?,
            all => {
                let (both, half) = (self.output("m_axis_tkeep")?, all / 2);
                vec![(both & ((1 << half) - 1), half), (both >> half, half)]
            }
        };
        let whole = |(bits, width): (i128, u32)| match bits.count_ones() {
            0 => Ok(false),
            count if count == width => Ok(true),
            _ => Err(refuted("m_axis_tkeep keeps part of a vertex".into())),
        };
        words.into_iter().map(whole).collect()
    }

    /// An unknown value mostly has a cause that was noted when it arose.
    fn unknown(&self, axis: &str) -> String {
        match self.simulator.domain.failures.first() {
            Some(cause) => format!("{axis} is unknown, as {cause}"),
            None => format!("{axis} is no function of the control points, or was never set"),
        }
    }
}

/// The bounds of the error of an output, if it is the expected mask up to an error.
fn within(value: &Value<12>, expected: &Form<12>) -> Option<ErrorBounds> {
    let near = match value {
        Value::Near(near) => *near,
        Value::Form(form) => Near::from_form(form)?,
        _ => return None,
    };
    let mut coefficients = near.coefficients.iter().zip(&expected.coefficients);
    let same = coefficients.all(|(&c, &m)| i128::from(c) * expected.divisor == i128::from(m) * near.divisor);
    (same && near.modulus == 0 && near.group == expected.group)
        .then_some(ErrorBounds { below: (near.low, near.divisor), above: (near.high, near.divisor) })
}
