//! A command made ready for the walk along a bundle: loads by kind, and the labels at which every tube meets something.

use super::Bundle;
use super::number::Number;
use super::rubbing::Rubbing;
use super::vector::sum;
use crate::statics::{DistributedForce, Frame, Loads, Station, Thread, Wrench};
use nalgebra::Vector3;
use std::sync::Arc;

/// What happens at a label of a tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stop {
    /// The piece of this number ends.
    Piece(usize),
    /// A joint or free tip, by number.
    Station(usize),
    /// A load on the leader, by number.
    Load(usize),
    /// A distributed force on the leader begins or ends.
    Begin(usize),
    End(usize),
}

/// How centroid lines lengthen.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Lengthening {
    /// By their tension everywhere?
    pub stretch: bool,
    /// At joints, by this part of the length for a force of EI/L²; see [`GIVE`].
    pub give: f64,
}

/// Inextensible tubes without lever that lie side by side between two joints share their force in no way that is determined. Where there are such
/// tubes, every tube gives way at its joints by this part of the length for a force of EI/L², as little as a thousandth of what tubes really stretch by.
pub(crate) const GIVE: f64 = 1e-7;

/// A concentrated load.
#[derive(Clone, Debug)]
pub(crate) enum Applied {
    Wrench(Wrench),
    Thread(Thread),
}

/// Forces and stops of one command.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// Is anything but the tubes' own forces there?
    pub loaded: bool,
    /// Must the force at the plate be sought? The sum of dead loads is known.
    pub seeks_force: bool,
    pub dead_force: [f64; 3],
    pub points: Vec<(f64, Applied)>,
    pub tip: Vec<Applied>,
    pub distributed: Vec<DistributedForce>,
    pub gravity: Option<[f64; 3]>,
    pub lengthening: Lengthening,
    /// Friction between the tubes.
    pub rubbing: Option<Arc<Rubbing>>,
    /// Per tube: labels (m) in order, and what is there.
    pub stops: Vec<Vec<(f64, Stop)>>,
    /// EI/L² (N).
    pub force_scale: f64,
}

pub(crate) fn array(v: &Vector3<f64>) -> [f64; 3] {
    [v.x, v.y, v.z]
}

impl Prepared {
    pub fn new(bundle: &Bundle, loads: &Loads, lengthening: Lengthening) -> Self {
        let Loads { wrenches, distributed, gravity, threads } = loads;
        let (mut points, mut tip) = (Vec::new(), Vec::new());
        let mut dead_force = Vector3::zeros();
        let mut dead = gravity.is_none() && distributed.is_empty() && threads.is_empty();
        for wrench in wrenches {
            dead &= wrench.frame == Frame::World;
            dead_force += wrench.force;
            match wrench.station {
                Station::Tip => tip.push(Applied::Wrench(*wrench)),
                Station::Label(label) => points.push((label, Applied::Wrench(*wrench))),
            }
        }
        tip.extend(threads.iter().map(|thread| Applied::Thread(*thread)));
        let mut stops: Vec<Vec<(f64, Stop)>> = bundle
            .tubes
            .iter()
            .map(|tube| {
                let inner = tube.pieces[..tube.pieces.len() - 1].iter().enumerate();
                inner.map(|(number, piece)| (piece.to, Stop::Piece(number))).collect()
            })
            .collect();
        for (number, station) in bundle.stations.iter().enumerate() {
            let (tube, label) = station[0];
            stops[tube].push((label, Stop::Station(number)));
        }
        if let Some(leader) = stops.first_mut() {
            leader.extend(points.iter().enumerate().map(|(i, (label, _))| (*label, Stop::Load(i))));
            for (i, d) in distributed.iter().enumerate() {
                leader.extend([(d.from, Stop::Begin(i)), (d.to, Stop::End(i))]);
            }
        }
        for own in &mut stops {
            own.sort_by(|a, b| a.0.total_cmp(&b.0));
            // What stands at the tip of a tube comes before its end.
            own.sort_by(|a, b| {
                a.0.total_cmp(&b.0)
                    .then(matches!(a.1, Stop::Station(_)).cmp(&matches!(b.1, Stop::Station(_))))
            });
        }
        Self {
            loaded: !loads.is_empty(),
            seeks_force: !dead,
            dead_force: array(&dead_force),
            points,
            tip,
            distributed: distributed.clone(),
            gravity: gravity.as_ref().map(array),
            lengthening,
            rubbing: bundle.rubbing.clone(),
            stops,
            force_scale: bundle.bending / (bundle.length * bundle.length),
        }
    }
}

impl Applied {
    /// Force (N), moment about the point of action (N m) and arm from the section's centre (m), world components, on a section at
    /// `centre` with the given axes.
    pub fn at<S: Number>(&self, centre: &[S; 3], axes: &[[S; 3]; 3]) -> ([S; 3], [S; 3], [S; 3]) {
        let turned =
            |v: &Vector3<f64>| [0, 1, 2].map(|i| axes[0][i] * v.x + axes[1][i] * v.y + axes[2][i] * v.z);
        match self {
            Self::Wrench(w) => {
                let arm = turned(&w.point);
                match w.frame {
                    Frame::World => {
                        (array(&w.force).map(S::constant), array(&w.moment).map(S::constant), arm)
                    }
                    Frame::Section => (turned(&w.force), turned(&w.moment), arm),
                }
            }
            Self::Thread(t) => {
                let arm = turned(&t.point);
                let from = sum(*centre, arm);
                let gap = [0, 1, 2].map(|i| -from[i] + t.pulley[i]);
                let distance = (gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]).sqrt();
                let pull = distance.inverse() * t.tension;
                // The thread touches the pulley beside its centre: turned about Z by asin(radius/distance).
                let sine = distance.inverse() * if t.left { t.radius } else { -t.radius };
                let cosine = (-(sine * sine) + 1.0).sqrt();
                let along = gap.map(|g| g * pull);
                let force =
                    [along[0] * cosine - along[1] * sine, along[0] * sine + along[1] * cosine, along[2]];
                (force, [S::constant(0.0); 3], arm)
            }
        }
    }
}
