//! A stepping method as data: which passes run over the rows, in which order.

/// One pass of the solver over bodies or colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Bodies: forces, free rotation, and the warm start carried by each body.
    Velocities,
    /// Colors: joints, then contacts, with bias and softness; `inner` Gauss-Seidel rounds over the
    /// points of a manifold.
    Solve {
        /// Rounds, 1 to 8.
        inner: u32,
    },
    /// Bodies: positions follow velocities.
    Positions,
    /// Colors: joints, then contacts, without bias: removes the velocity that the bias added.
    Relax,
    /// Islands: what meets within the time of a substep bounces. Stands before every sweep that could
    /// stop it: solve and relax.
    Impacts,
}

/// A named list of passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    name: &'static str,
    summary: &'static str,
    substeps: u32,
    inertia: f32,
    substep: Vec<Pass>,
    finish: Vec<Pass>,
}

impl Method {
    /// Names that [`Self::named`] knows.
    pub const NAMES: [&'static str; 2] = ["soft-step", "soft-step-relax"];

    /// The default: one fused sweep a substep, one relax sweep a step; 8 substeps.
    #[must_use]
    pub fn soft_step() -> Self {
        Self {
            name: "soft-step",
            summary: "8 substeps of impacts and one soft sweep each, one relax sweep at the end",
            substeps: 8,
            inertia: 8.0,
            substep: vec![
                Pass::Velocities,
                Pass::Impacts,
                Pass::Solve { inner: 2 },
                Pass::Positions,
            ],
            finish: vec![Pass::Impacts, Pass::Relax],
        }
    }

    /// The common scheme of today's engines in our rows: 4 substeps, each with a soft and a relax
    /// sweep [Catto24].
    #[must_use]
    pub fn soft_step_relax() -> Self {
        Self {
            name: "soft-step-relax",
            summary: "4 substeps of impacts, a soft and a relax sweep each",
            substeps: 4,
            inertia: 1.0,
            substep: vec![
                Pass::Velocities,
                Pass::Impacts,
                Pass::Solve { inner: 1 },
                Pass::Positions,
                Pass::Impacts,
                Pass::Relax,
            ],
            finish: Vec::new(),
        }
    }

    /// The method of this name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "soft-step" => Some(Self::soft_step()),
            "soft-step-relax" => Some(Self::soft_step_relax()),
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// What it does, in a line.
    #[must_use]
    pub const fn summary(&self) -> &'static str {
        self.summary
    }

    /// Substeps a step unless the world's configuration says otherwise.
    #[must_use]
    pub const fn substeps(&self) -> u32 {
        self.substeps
    }

    /// Greatest factor of load-adaptive inertia unless the world's configuration says otherwise; 1: none.
    #[must_use]
    pub const fn inertia(&self) -> f32 {
        self.inertia
    }

    /// The passes of a substep.
    #[must_use]
    pub fn substep(&self) -> &[Pass] {
        &self.substep
    }

    /// The passes after the last substep.
    #[must_use]
    pub fn finish(&self) -> &[Pass] {
        &self.finish
    }
}
