//! Shares as a table in words.

use super::{Group, Part, Shares};
use crate::study::digits::rounded;
use std::fmt::{Display, Formatter, Result};

impl Part {
    /// What it is.
    pub fn words(self) -> &'static str {
        match self {
            Part::ContactSearch => "contact search: places, surfaces there, slip",
            Part::NormalLaw => "normal law with patch and damping",
            Part::CreepLaw => "creep law",
            Part::Track => "track: where bodies are along the curve",
            Part::Forces => "multibody: motion of bodies, force elements",
            Part::EquationsOfMotion => "multibody: equations of motion with joints",
            Part::ContactAndEquations => "contact search, constraints, equations of motion",
            Part::JacobianContacts => "contacts, and putting it together",
            Part::JacobianForces => "force elements",
            Part::Factorisation => "factorisations",
            Part::LinearSystems => "solving with them",
            Part::Constraints => "projection onto constraints, breaks of the track, events",
            Part::Integrator => "integrator: sums of stages, carried motion, error norm, step control, continuous output",
            Part::ReadingOutputs => "an evaluation at each output time, and reading them",
            Part::WritingOutputs => "writing them as CSV",
        }
    }
}

impl Group {
    /// What it is.
    pub fn words(self) -> &'static str {
        match self {
            Group::RightHandSides => "right-hand sides",
            Group::Jacobians => "Jacobians",
            Group::LinearSystems => "linear systems",
            Group::Constraints => Part::Constraints.words(),
            Group::Integrator => Part::Integrator.words(),
            Group::Outputs => "outputs",
        }
    }
}

impl Display for Shares {
    fn fmt(&self, out: &mut Formatter) -> Result {
        let setting =
            if self.fixed { format!("step {} ms", rounded(1e3 * self.setting)) } else { format!("tolerance {:.0e}", self.setting) };
        writeln!(out, "Where the time of a run goes: {}, {}, {}, {setting}", self.scene, self.formulation, self.integrator)?;
        writeln!(
            out,
            "{} s with {} outputs every {} ms: {:.2} ms per simulated second, {} times real time ({:.2} ms under the watch)",
            self.stop,
            self.outputs,
            rounded(1e3 * self.step),
            1e3 * self.seconds / self.stop,
            factor(self.stop / self.seconds),
            1e3 * self.watched / self.stop
        )?;
        let work = self.statistics;
        writeln!(
            out,
            "{} steps, {} rejected, {} evaluations of the right-hand side, {} Jacobians, {} factorisations",
            work.steps, work.rejected, work.evaluations, work.linearisations, work.factorisations
        )?;
        writeln!(out, "  of all  without outputs")?;
        let integration = 1.0 - self.of(Group::Outputs);
        for group in Group::ALL {
            let mut line = |share: f64, shown: bool, words: String| match (shown, group) {
                (false, _) => Ok(()),
                (true, Group::Outputs) => writeln!(out, "  {:5.1} %                 {words}", 100.0 * share),
                (true, _) => writeln!(out, "  {:5.1} %       {:5.1} %    {words}", 100.0 * share, 100.0 * share / integration),
            };
            let all = self.of(group);
            line(all, all > 0.0, group.words().into())?;
            let own: Vec<_> = self.shares.iter().filter(|one| one.part.group() == group).collect();
            if own.len() > 1 {
                for one in own {
                    // Too small to be measured is not the same as absent.
                    let known = matches!(one.part, Part::NormalLaw | Part::CreepLaw | Part::Forces);
                    line(one.share, one.share > 0.0 || known, format!("    {}", one.part.words()))?;
                }
            }
        }
        self.doubt.as_ref().map_or(Ok(()), |doubt| writeln!(out, "  {doubt}"))
    }
}

/// Two digits where it matters whether it is more or less than one.
fn factor(value: f64) -> String {
    if value < 9.95 { format!("{value:.2}") } else { format!("{value:.0}") }
}
