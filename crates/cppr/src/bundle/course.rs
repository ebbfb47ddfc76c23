//! A course of the tubes that is known before, at which the steps of an integration begin: labels and rotations of all tubes,
//! and the pose of the section, along the leader. Forces and torques follow from it as they are integrated along.

use super::flow::Flow;
pub(crate) use super::flow::POSE;
use super::number::Number;

/// Configurations at equally spaced labels of the leader.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    /// Length of the leader (m).
    pub length: f64,
    /// One row each: label (m) and rotation of the material (rad) of every tube, position (m), quaternion of the untwisted frame.
    pub rows: Vec<Vec<f64>>,
}

impl Course {
    /// Gives the tubes of a section, which all have to be there, their places.
    pub fn lay<S: Number>(&self, flow: &mut Flow<S>) {
        let tubes = flow.present.len();
        let row = self.row(flow.values[0].value());
        for place in 0..tubes {
            for (own, which) in [(1, 2 * place), (3, 2 * place + 1)] {
                let at = 4 * place + own - 1;
                flow.values[at] = flow.values[at].moved_to(row[which]);
            }
        }
        let pose = 4 * tubes + 1;
        if flow.values.len() > pose {
            for i in 0..POSE {
                flow.values[pose + i] = flow.values[pose + i].moved_to(row[2 * tubes + i]);
            }
        }
    }

    /// A cubic through the four rows around the label.
    fn row(&self, label: f64) -> Vec<f64> {
        let cells = self.rows.len() - 1;
        let place = (label / self.length).clamp(0.0, 1.0) * cells as f64;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // Between 0 and the number of cells.
        let first = (place as usize).saturating_sub(1).min(cells.saturating_sub(3));
        let t = place - first as f64;
        let weights = [
            -(t - 1.0) * (t - 2.0) * (t - 3.0) / 6.0,
            t * (t - 2.0) * (t - 3.0) / 2.0,
            -t * (t - 1.0) * (t - 3.0) / 2.0,
            t * (t - 1.0) * (t - 2.0) / 6.0,
        ];
        let rows = &self.rows[first..first + 4];
        (0..rows[0].len()).map(|i| rows.iter().zip(weights).map(|(row, w)| w * row[i]).sum()).collect()
    }
}
