//! Bending stiffness of a cell in closed form, where seconds are too long.
//!
//! Teeth bend near the notch only: over a length δ beyond each notch, as if the notch were longer by δ,
//!
//!   EI_Z = EI_notch (ℓ + t)/(ℓ + δ) ,   δ = c √(ρ̄ h) ,
//!
//! with the outer radius or apothem ρ̄ and the height h of what the notch keeps of the section.

use cppr::design::Outline;

/// c of δ = c √(ρ̄ h), from the cells of `examples/closed_form.rs`.
const LENGTH: f64 = 0.95;

/// EI_Z of a cell over that of the section at its notch (-), sharp corners and a plane cut; teeth no shorter than δ.
#[must_use]
pub fn bending_estimate(outline: &Outline, depth: f64, notch: f64, tooth: f64) -> f64 {
    let radius = match outline {
        Outline::Round { outer_radius, .. } => *outer_radius,
        Outline::Polygon { outer_apothem, .. } => *outer_apothem,
    };
    let more = LENGTH * (radius * outline.kept_height(depth)).sqrt();
    (notch + tooth) / (notch + more.min(tooth))
}
