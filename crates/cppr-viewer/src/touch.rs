//! How the tubes press on each other in the pose on the page, and between which poses friction leaves it.

use crate::message::Message;
use crate::session::text;
use cppr::bundle::Friction;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr_io::contact_record;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Sections at which contact is told, per length.
const SECTIONS: f64 = 100.0;
/// Greatest coefficient of friction, as in robot files.
const MOST: f64 = 2.0;

/// What the page asks of the last stable equilibrium.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Touch {
    /// Number of the request, given back with the answer.
    pub id: u32,
    /// Coefficient of friction between the tubes; 0 leaves friction out.
    #[serde(default)]
    pub coefficient: f64,
    /// Length of the guide below the plate in which tubes rub too; 0 leaves it out.
    #[serde(default)]
    pub guide_mm: f64,
}

/// The friction of a robot file, in the units of the page.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Written {
    coefficient: f64,
    guide_mm: f64,
}

impl From<Friction> for Written {
    fn from(own: Friction) -> Self {
        Self { coefficient: own.coefficient, guide_mm: own.guide.unwrap_or(0.0) * 1e3 }
    }
}

impl Touch {
    /// The answer of an equilibrium, or of none where it cannot be integrated.
    pub(crate) fn answer(&self, found: Option<(&BundleSolver<'_>, &BundleEquilibrium)>) -> Message {
        let contact = found.and_then(|(solver, found)| solver.contact(found, found.length / SECTIONS));
        let rubs = 0.0 < self.coefficient && self.coefficient <= MOST;
        let friction = Friction {
            coefficient: self.coefficient,
            guide: (self.guide_mm > 0.0).then_some(self.guide_mm * 1e-3),
        };
        let sides = found.filter(|_| rubs).and_then(|(solver, found)| solver.full_slip(found, &friction));
        let problem = match (&contact, &sides) {
            (None, _) => Some(
                "known for the consistent formulation, where the integration along the robot confirms the pose",
            ),
            (_, None) if rubs => {
                Some("no equilibrium with full slip was found: take less friction, or command less")
            }
            (_, None) if self.coefficient > MOST => Some("beyond a coefficient of 2 tubes jam"),
            _ => None,
        };
        text(&json!({
            "kind": "touch", "id": self.id, "contact": contact.as_ref().map(contact_record::contact),
            "friction": sides.as_ref().map(|sides| contact_record::bounds(&friction, sides)), "problem": problem,
        }))
    }
}
