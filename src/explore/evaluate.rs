//! Everything there is to know about a point. What points share is made once.
//!
//! ```text
//!   (mesh, scheme, coordinates, level) ─► Stage       packets, oracle, numbers of vertices
//!   core parameters                    ─► Cost        from the core's graph (and from synthesis)
//!   design                             ─► worst case
//! ```

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::{Arc, Mutex, OnceLock};

use super::cost::Cost;
use super::meshes::Subject;
use super::point::{Design, Point, Scheme};
use super::record::{ErrorLsb, Planned, Record};
use super::synth::{self, Synthesis};
use super::{cc_strip, loop_fd};
use crate::cores;
use crate::error::{Error, Result};
use crate::hdl::Module;
use crate::package;

/// What is made once for several points, and shared by the threads.
type Shared<T> = Arc<OnceLock<Result<Arc<T>>>>;

/// A store of shared things by name.
struct Store<T>(Mutex<BTreeMap<String, Shared<T>>>);

impl<T> Store<T> {
    fn new() -> Self {
        Store(Mutex::new(BTreeMap::new()))
    }

    /// The thing of that name; the first who asks makes it, the others wait for it.
    fn get(&self, name: &str, make: impl FnOnce() -> Result<T>) -> Result<Arc<T>> {
        let cell = {
            // A thread that panicked while it held the lock left the map as it was.
            let mut map = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            map.entry(name.to_string()).or_default().clone()
        };
        cell.get_or_init(|| make().map(Arc::new)).clone()
    }

    fn forget(&self, name: &str) {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).remove(name);
    }
}

enum Stage {
    Loop(loop_fd::Stage),
    Strips(cc_strip::Stage),
}

/// Evaluates points of some meshes.
pub struct Evaluator {
    subjects: BTreeMap<String, Subject>,
    synthesise: bool,
    stages: Store<Stage>,
    cores: Store<(Cost, Option<Synthesis>)>,
    worst: Store<Option<f64>>,
}

impl Evaluator {
    /// With `synthesise`, each core is placed and routed as well.
    pub fn new(subjects: Vec<Subject>, synthesise: bool) -> Evaluator {
        let subjects = subjects.into_iter().map(|subject| (subject.name.hash.clone(), subject)).collect();
        let (stages, cores, worst) = (Store::new(), Store::new(), Store::new());
        Evaluator { subjects, synthesise, stages, cores, worst }
    }

    /// The name of what a point shares with others of its mesh, format and level.
    pub fn stage_name(point: &Point) -> String {
        let Design { scheme, coordinates, level, .. } = point.design;
        format!("{} {scheme} {coordinates} {level}", point.mesh.hash)
    }

    /// Frees what no further point needs.
    pub fn forget(&self, stage: &str) {
        self.stages.forget(stage);
    }

    fn stage(&self, point: &Point) -> Result<Arc<Stage>> {
        let Design { scheme, coordinates, level, .. } = point.design;
        let subject = self
            .subjects
            .get(&point.mesh.hash)
            .ok_or_else(|| Error::input(format!("the mesh {} is not loaded", point.mesh.name)))?;
        self.stages.get(&Self::stage_name(point), || {
            Ok(match scheme {
                Scheme::Loop => Stage::Loop(loop_fd::Stage::new(subject, coordinates, level)?),
                Scheme::CatmullClark => Stage::Strips(cc_strip::Stage::new(subject, coordinates, level)?),
            })
        })
    }

    /// Evaluates one point. The result depends on the point and its mesh alone.
    ///
    /// # Errors
    /// A design that no core has, a mesh that the scheme or the format does not take, a failed synthesis.
    pub fn evaluate(&self, point: &Point) -> Result<Record> {
        let design = &point.design;
        let stage = self.stage(point)?;
        let (tally, bound, uncertainty) = match &*stage {
            Stage::Loop(stage) => (stage.measure(design)?, stage.bound(design)?, stage.uncertainty()),
            Stage::Strips(stage) => (stage.measure(design)?, stage.bound(design)?, stage.uncertainty()),
        };
        let core = Core::of(&stage, design)?;
        if tally.missing() > 0 {
            return Err(Error::input(format!("{} vertices of the fine mesh did not come", tally.missing()))
                .at(&point.mesh.name));
        }
        let worst = match design.scheme {
            Scheme::Loop => self.worst.get(&loop_fd::worst_name(design), || loop_fd::worst(design))?,
            Scheme::CatmullClark => self.worst.get(&design.to_string(), || Ok(cc_strip::worst(design)))?,
        };
        let figures = self.cores.get(&core.name(), || self.figures(core))?;
        let (errors, cracks) = (tally.errors(), tally.cracks());
        Ok(Record {
            point: Planned::from(point),
            bound_lsb: bound,
            error_lsb: ErrorLsb { max: errors.max, rms: errors.rms, worst_case: *worst, uncertainty },
            cracks,
            cost: figures.0,
            synthesis: figures.1.clone(),
            command: core.command(),
        })
    }

    /// The proven bound alone, in units of the output's last place.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub fn bound(&self, point: &Point) -> Result<f64> {
        match &*self.stage(point)? {
            Stage::Loop(stage) => stage.bound(&point.design),
            Stage::Strips(stage) => stage.bound(&point.design),
        }
    }

    /// The core of a point.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub fn core(&self, point: &Point) -> Result<Core> {
        Core::of(&*self.stage(point)?, &point.design)
    }

    fn figures(&self, core: Core) -> Result<(Cost, Option<Synthesis>)> {
        let built = core.build()?;
        let synthesis = match self.synthesise {
            false => None,
            true => Some(synth::measure(&built, &core.command())?),
        };
        Ok((Cost::of(&built)?, synthesis))
    }
}

/// The core of a point: of a design for a mesh.
#[derive(Clone, Copy, Debug)]
pub enum Core {
    LoopFd(cores::loop_fd::Parameters),
    CcStrip(cores::cc_strip::Parameters),
}

impl Core {
    fn of(stage: &Stage, design: &Design) -> Result<Core> {
        match stage {
            Stage::Loop(stage) => Ok(Core::LoopFd(stage.parameters(design)?)),
            Stage::Strips(stage) => Ok(Core::CcStrip(stage.parameters(design)?)),
        }
    }

    /// Different for different cores.
    fn name(self) -> String {
        format!("{self:?}")
    }

    /// The command that generates it.
    pub fn command(self) -> String {
        match self {
            Core::LoopFd(parameters) => package::loop_fd::command(parameters),
            Core::CcStrip(parameters) => package::cc_strip::command(parameters),
        }
    }

    /// # Errors
    /// A core that cannot be built.
    pub fn build(self) -> Result<Rc<Module>> {
        match self {
            Core::LoopFd(parameters) => cores::loop_fd::build(parameters),
            Core::CcStrip(parameters) => cores::cc_strip::build(parameters),
        }
    }
}
