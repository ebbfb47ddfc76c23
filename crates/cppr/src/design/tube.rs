//! One tube as its designer describes it, before it becomes fields along its rest abscissa.
//!
//! All values are SI. The rest abscissa x runs from the baseplate (x = 0) to the tip (x = L); angles
//! are measured about the robot's axis from +Y towards +Z.

use super::{Outline, Profile, Softening, TeethStiffness};

/// Isotropic material of a tube.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Young's modulus E (Pa).
    pub youngs_modulus: f64,
    /// Poisson's ratio ν (-); the shear modulus is G = E / (2 (1 + ν)).
    pub poissons_ratio: f64,
    /// Density μ (kg/m³); zero for a weightless tube.
    pub density: f64,
    /// Greatest strain the material is to bear, tension or compression (-); `None` where the design sets none.
    pub allowable_strain: Option<f64>,
    /// How it softens, where it does: computed for bundles of parts with constant depth.
    pub softening: Option<Softening>,
}

impl Material {
    /// Shear modulus G = E / (2 (1 + ν)) (Pa).
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))
    }

    /// Shear strain whose distortion energy is that of the allowable strain in tension, 2 (1 + ν)/√3 times that (-).
    #[must_use]
    pub fn allowable_shear(&self) -> Option<f64> {
        self.allowable_strain.map(|strain| 2.0 * (1.0 + self.poissons_ratio) / 3.0_f64.sqrt() * strain)
    }
}

/// How the torsional stiffness GJ of a notched tube, about the tube's centre, is found.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Torsion {
    /// G times the Saint-Venant constant of the open section: the default.
    SaintVenant,
    /// G times the polar moment about the tube's centre, G I_X + G A D²: what the paper uses.
    Polar,
    /// A given stiffness GJ(x) (N m²).
    Given(Profile),
}

/// What of a follower enters the robot when it is pushed: its part at x < 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BelowPlate {
    /// The uncut tube: full outline, centroid on the axis.
    Plain,
    /// The pattern goes on: depth and stiffness as at x = 0, direction with the slope it has there.
    Continued,
}

/// A row of equal notches from the baseplate on, with half a tooth before the first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NotchPattern {
    /// Length of a notch along the tube (m).
    pub length: f64,
    /// Length of the tooth between two notches (m).
    pub tooth: f64,
    /// Number of notches.
    pub count: u32,
}

impl NotchPattern {
    /// Length of a cell: a notch and half a tooth on either side (m).
    #[must_use]
    pub fn pitch(&self) -> f64 {
        self.length + self.tooth
    }

    /// Rest abscissae of the middles of the notches (m).
    #[must_use]
    pub fn middles(&self) -> Vec<f64> {
        (0..self.count).map(|i| (f64::from(i) + 0.5) * self.pitch()).collect()
    }
}

/// A tube cut by notches: its stiffness follows from its geometry.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NotchedTube {
    /// Shape of the uncut section.
    pub outline: Outline,
    /// Notch depth γ(x) (m), measured from the outer surface on the side where the notch opens.
    pub depth: Profile,
    /// Direction φ(x) of the centroid (rad); the notch opens at φ + π.
    pub direction: Profile,
    /// Where the notches are. The mechanics spreads them evenly; limits need them one by one.
    pub pattern: Option<NotchPattern>,
    /// What the teeth between the notches do to the stiffness.
    pub teeth: TeethStiffness,
    /// Do teeth that meet carry load? Else they pass through each other, which limits report. Computed for bundles of parts with constant depth.
    pub contact: bool,
    /// Material.
    pub material: Material,
    /// Torsional stiffness.
    pub torsion: Torsion,
    /// The part below the baseplate.
    pub below: BelowPlate,
    /// Factor on the centroid offset D in the kinematics (Remark 17); the inertia is not scaled.
    pub centroid_offset_factor: f64,
}

/// A tube whose stiffness is given directly.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StiffnessTube {
    /// Centroid offset D(x) ≥ 0 (m).
    pub centroid_offset: Profile,
    /// Direction φ(x) of the centroid (rad).
    pub direction: Profile,
    /// Bending stiffness EI_Y(x) (N m²) about the axis along the centroid direction: the stiff one.
    pub bending_y: Profile,
    /// Bending stiffness EI_Z(x) (N m²) about the axis normal to the centroid direction: the soft one.
    pub bending_z: Profile,
    /// Torsional stiffness GJ(x) (N m²) about the tube's centre.
    pub torsion: Profile,
    /// Axial stiffness EA(x) (N); needed only for stretch.
    pub axial: Option<Profile>,
    /// Mass per length m(x) (kg/m).
    pub mass_per_length: Profile,
    /// Factor on the centroid offset D in the kinematics.
    pub centroid_offset_factor: f64,
}

/// A tube as designed.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TubeDesign {
    /// Stiffness from geometry.
    Notched(NotchedTube),
    /// Stiffness given; below the plate the fields go on.
    Stiffness(StiffnessTube),
}

impl StiffnessTube {
    /// The same everywhere: centroid offset (m) and its direction (rad), bending stiffness about the section's axes, the stiff
    /// one first, and torsional stiffness (N m²). No mass, no axial stiffness.
    #[must_use]
    pub fn uniform(
        centroid_offset: f64,
        direction: f64,
        [bending_y, bending_z]: [f64; 2],
        torsion: f64,
    ) -> Self {
        Self {
            centroid_offset: Profile::constant(centroid_offset),
            direction: Profile::constant(direction),
            bending_y: Profile::constant(bending_y),
            bending_z: Profile::constant(bending_z),
            torsion: Profile::constant(torsion),
            axial: None,
            mass_per_length: Profile::constant(0.0),
            centroid_offset_factor: 1.0,
        }
    }
}

impl From<NotchedTube> for TubeDesign {
    fn from(tube: NotchedTube) -> Self {
        Self::Notched(tube)
    }
}

impl From<StiffnessTube> for TubeDesign {
    fn from(tube: StiffnessTube) -> Self {
        Self::Stiffness(tube)
    }
}
