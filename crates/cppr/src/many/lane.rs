//! What is derived of equilibria that were solved in the lanes of vector registers: of all lanes at once, when the first is asked for. The
//! margin to instability (1 at rest, 0 where it snaps) is that of `reduced`, the use of strain and closure that of `limits`.

use super::batch::{Lanes, WIDTH};
use crate::analysis::limits::{Teeth, Utilisation, greatest};
use crate::real::Real;
use crate::solve::Equilibrium;
use crate::solve::reduced::Reduced;
use crate::solve::system::{Buffers, Point};

/// What has been derived already.
#[derive(Clone, Debug, Default)]
pub(crate) struct Derived {
    /// Marks of the equilibria that it belongs to.
    pub marks: [u64; WIDTH],
    /// With the lanes in which it holds.
    margin: Option<(Lanes, u64)>,
    greatest: Option<(Teeth, Vec<Utilisation>)>,
}

impl Derived {
    /// Nothing yet of the equilibria with these marks.
    pub fn of(marks: [u64; WIDTH]) -> Self {
        Self { marks, ..Self::default() }
    }
}

/// An equilibrium in its lane.
#[derive(Debug)]
pub(crate) struct Lane<'a> {
    pub index: usize,
    pub buffers: &'a mut Buffers<Lanes>,
    pub point: &'a Point<Lanes>,
    pub derived: &'a mut Derived,
}

impl Lane<'_> {
    /// As [`crate::solve::Solver::margin`]; none where the lane has to be looked at alone.
    pub fn margin(&mut self, equilibrium: &Equilibrium) -> Option<f64> {
        let (margin, fit) = *self.derived.margin.get_or_insert_with(|| {
            let reduced = Reduced::new(self.buffers, &equilibrium.system());
            // Without free motions there is no margin.
            let fit = if reduced.free > 0 { reduced.fit } else { 0 };
            (reduced.lowest(), fit)
        });
        (fit >> self.index & 1 == 1).then(|| margin.lane(self.index))
    }

    /// As [`crate::solve::Solver::utilisation`].
    pub fn utilisation(&mut self, equilibrium: &Equilibrium, teeth: Teeth) -> Utilisation {
        let kept = self.derived.greatest.take().filter(|(own, _)| *own == teeth);
        let (_, found) = self.derived.greatest.insert(kept.unwrap_or_else(|| {
            let Equilibrium { robot, layout, .. } = equilibrium;
            (teeth, greatest(robot, self.buffers, layout, &self.point.coordinates, teeth))
        }));
        found[self.index]
    }
}
