//! Source and core as one unit: `start` in, the vertex stream of the whole mesh out.

use std::rc::Rc;

use super::{Patches, patch_source};
use crate::cores::loop_fd::{self, AXES, Parameters};
use crate::error::Result;
use crate::hdl::{Builder, Module, Word};

/// Inputs: `start`, ignored while the mesh is on its way, and `ready`. Outputs: those of the vertex stream, and
/// `running`.
pub fn build(parameters: Parameters, patches: &Patches) -> Result<Rc<Module>> {
    let m = Builder::new("mesh_evaluator");
    m.purpose("A mesh in block RAM, evaluated: at each start, the vertices of its triangle strips.");
    let [start, ready] = ["start", "ready"].map(|name| m.input(name, Word::bit()));
    let running = m.register_reset("running", Word::bit(), 0);
    let begin = m.wire("begin_mesh", &start & !&running);

    let core_ready = m.forward("core_ready", Word::bit());
    let source = patch_source::build(parameters, patches)?;
    let source = m.instance("source", &source, &[("start", &begin), ("ready", &core_ready)]);
    let core = without_buses(&loop_fd::build(parameters)?);
    let points = AXES.map(|axis| (format!("s_axis_tdata_{axis}"), source.out(&format!("point_{axis}"))));
    let [level, last, valid] = ["level", "last", "valid"].map(|name| source.out(name));
    let mut inputs: Vec<_> = points.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
    inputs.extend([
        ("s_axis_tuser", &level),
        ("s_axis_tlast", &last),
        ("s_axis_tvalid", &valid),
        ("m_axis_tready", &ready),
    ]);
    let core = m.instance("core", &core, &inputs);
    m.drive(&core_ready, core.out("s_axis_tready"));

    // `tkeep` has one bit a byte; the highest belongs to the right vertex.
    let keep = core.out("m_axis_tkeep");
    let pair = m.wire("pair", m.slice(&keep, keep.width() - 1, 1));
    let user = core.out("m_axis_tuser");
    let patch_start = m.wire("patch_start", m.slice(&user, 0, 1));
    let patch_end = m.wire("patch_end", m.slice(&user, 1, 1));
    let valid = core.out("m_axis_tvalid");

    let last_patch = patches.levels.len() as i128 - 1;
    let patch = m.register_reset("patch", Word::range(0, last_patch.max(1)), 0);
    let mesh_start = m.wire("mesh_start", &patch_start & m.is(&patch, 0));
    let mesh_end = m.wire("mesh_end", &patch_end & m.is(&patch, last_patch));
    let taken = m.wire("taken", &valid & &ready);
    m.on(&(&taken & &mesh_end), &patch, m.constant(0, patch.word()));
    m.on(&(&taken & &patch_end), &patch, m.wrap(&patch + 1, patch.word()));
    m.on(&(&taken & &mesh_end), &running, m.bit(false));
    m.on(&begin, &running, m.bit(true));

    for name in super::coordinate_names() {
        m.output(
            &name,
            m.rescale(&core.out(&format!("m_axis_tdata_{name}")), parameters.output_fraction as i32),
        );
    }
    let strip_end = core.out("m_axis_tlast");
    let flags = [pair, strip_end, patch_start, patch_end, mesh_start, mesh_end];
    super::FLAGS.iter().zip(&flags).for_each(|(name, flag)| m.output(*name, flag));
    m.output("valid", &valid);
    m.output("running", &running);
    m.finish()
}

/// The same module with its ports one by one: only a top has buses.
fn without_buses(core: &Rc<Module>) -> Rc<Module> {
    Rc::new(Module { buses: vec![], ..core.as_ref().clone() })
}
