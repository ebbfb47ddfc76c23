//! The state along the bundle and its slopes: Hamilton's equations of the tubes, the pose of the section, and the loads on it.
//!
//! The state vector holds x, T, α, π of every tube that is present, then the centreline length s, and where the pose is wanted its
//! quaternion's w, x, y, z after the position, in the order s, c (3), q (4); under loads the internal force n and the moment μ of
//! the section's loads about the origin, both in world components, follow.

use super::curve::Piece;
use super::number::{Dual, Number};
use super::prepared::{Applied, Prepared, array};
use super::rubbing::Side;
use super::section::{Local, Scratch, Seen, Tube, TubeState, Unbalanced, Weight, balance, rates};
use super::vector::{columns, cross, dot, first_column, sum};

/// Numbers of the pose, and of the loads.
pub(crate) const POSE: usize = 7;
pub(crate) const LOADS: usize = 6;

/// Position of the centreline (m), and the axes of the untwisted frame.
type Pose<S> = ([S; 3], [[S; 3]; 3]);

/// Sees the section at the end of every step.
pub(crate) type Visitor<'a, S> = &'a mut dyn FnMut(&Section<S>);

/// What a visitor sees.
pub(crate) struct Section<'a, S> {
    pub flow: &'a Flow<'a, S>,
    /// ω_y, ω_z in the untwisted frame (1/m).
    pub omega: [S; 2],
    /// Per tube: x' = g/h°, and α'.
    pub rates: &'a [[S; 2]],
}

/// The tubes at a place and the state vector.
pub(crate) struct Flow<'a, S> {
    pub command: &'a Prepared,
    /// Tubes that are there, from outside to inside, and their pieces.
    pub present: Vec<usize>,
    pub pieces: Vec<&'a Piece>,
    pub values: Vec<S>,
    /// Distributed forces that act here, by number.
    pub distributed: Vec<usize>,
    /// Number of the span.
    pub span: usize,
    /// Number of events that its tubes have passed, those below the plate among them.
    pub passed: usize,
    posed: bool,
    /// Factor of the loads.
    load: S,
    /// Where ω was found last.
    omega: [f64; 2],
    scratch: Scratch<'a, S>,
    /// Slopes at the stages of a step, and where the next one is evaluated; kept from one span to the next.
    pub stages: Vec<S>,
    pub trial: Vec<S>,
}

/// What a wrench does to the section that it acts on.
pub(crate) struct SectionLoad<S> {
    /// Its force along the tangent (N).
    pub force_along: S,
    /// Its moment about the axis there (N m).
    pub about: S,
}

impl<'a, S: Number> Flow<'a, S> {
    pub fn new(command: &'a Prepared, posed: bool, load: S) -> Self {
        Self {
            command,
            present: Vec::new(),
            pieces: Vec::new(),
            values: vec![S::constant(0.0)],
            distributed: Vec::new(),
            span: 0,
            passed: 0,
            posed,
            load,
            omega: [0.0; 2],
            scratch: Scratch::default(),
            stages: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// A tube begins here.
    pub fn enter(&mut self, tube: usize, piece: &'a Piece, state: TubeState<S>) {
        let at = 4 * self.present.len();
        self.present.push(tube);
        self.pieces.push(piece);
        let TubeState { label, tension, angle, torque } = state;
        self.values.splice(at..at, [label, tension, angle, torque]);
    }

    /// A tube ends here.
    pub fn remove(&mut self, place: usize) {
        self.present.remove(place);
        self.pieces.remove(place);
        self.values.drain(4 * place..4 * place + 4);
    }

    /// Length of the centreline so far (m).
    pub fn length(&self) -> S {
        self.values[4 * self.present.len()]
    }

    /// Position (m) and quaternion of the section.
    pub fn pose(&self) -> ([S; 3], [S; 4]) {
        if self.posed {
            self.pose_in(&self.values)
        } else {
            ([S::constant(0.0); 3], [1.0, 0.0, 0.0, 0.0].map(S::constant))
        }
    }

    fn pose_in(&self, values: &[S]) -> ([S; 3], [S; 4]) {
        let v = &values[4 * self.present.len() + 1..];
        ([v[0], v[1], v[2]], [v[3], v[4], v[5], v[6]])
    }

    /// Internal force (N) and moment of the loads beyond about the origin (N m).
    pub fn loads(&self) -> ([S; 3], [S; 3]) {
        self.loads_in(&self.values)
    }

    fn loads_in(&self, values: &[S]) -> ([S; 3], [S; 3]) {
        let v = &values[4 * self.present.len() + 1 + POSE..];
        ([v[0], v[1], v[2]], [v[3], v[4], v[5]])
    }

    /// Angle of a tube's section axes against the untwisted frame: ψ = α + φ(x).
    pub fn angle_of_section(&self, place: usize) -> S {
        let label = self.values[4 * place];
        let [value, slope, _] = self.pieces[place].direction(label.value());
        self.values[4 * place + 2] + label.chain(value, slope)
    }

    /// The tubes at given values, and the moment that they balance, in the untwisted frame.
    fn section(&self, values: &[S], scratch: &mut Scratch<'a, S>) -> ([S; 2], Option<Pose<S>>) {
        let command = self.command;
        let frame = (self.posed && command.loaded).then(|| {
            let (centre, turn) = self.pose_in(values);
            (centre, columns(turn))
        });
        let mut moment = [S::constant(0.0); 2];
        if let Some((centre, [_, y, z])) = frame {
            let (force, about) = self.loads_in(values);
            let arm = cross(centre, force);
            let own = [about[0] - arm[0], about[1] - arm[1], about[2] - arm[2]];
            moment = [dot(own, y), dot(own, z)];
        }
        let weight = match (command.gravity, frame) {
            (Some(gravity), Some((centre, [_, y, z]))) => {
                let gravity = gravity.map(|g| self.load * g);
                Some(Weight { height: dot(gravity, centre), across: [dot(gravity, y), dot(gravity, z)] })
            }
            _ => None,
        };
        scratch.tubes.clear();
        scratch.weights.clear();
        scratch.first = None;
        for (place, (&tube, piece)) in self.present.iter().zip(&self.pieces).enumerate() {
            let own = &values[4 * place..4 * place + 4];
            let mut state = TubeState {
                label: own[0].value(),
                tension: own[1].value(),
                angle: own[2].value(),
                torque: own[3].value(),
            };
            // The leader is the first of those that are there.
            if let (0, Some((centre, _)), false) = (tube, &frame, self.distributed.is_empty()) {
                let mut tension = own[1];
                for &number in &self.distributed {
                    let force = array(&command.distributed[number].force).map(|f| self.load * f);
                    tension = tension - dot(force, *centre);
                }
                state.tension = tension.value();
                scratch.first = Some([own[0], tension, own[2], own[3]]);
            }
            scratch.weights.extend(weight.map(|w| [w.height, w.across[0], w.across[1]]));
            let weight =
                weight.map(|w| Weight { height: w.height.value(), across: w.across.map(Number::value) });
            scratch.tubes.push(Tube::new(piece, state, weight, command.lengthening.stretch));
        }
        (moment, frame)
    }

    /// Slopes of the state vector by the label of the tube at place `leading`, or by s.
    pub fn slopes(&mut self, leading: Option<usize>, out: &mut [S]) -> Result<(), Unbalanced> {
        let mut omega = self.omega;
        let values = std::mem::take(&mut self.values);
        let result = self.slopes_at(&values, leading, &mut omega, out);
        self.values = values;
        self.omega = omega;
        result
    }

    /// The same at other values.
    pub fn slopes_at(
        &mut self,
        values: &[S],
        leading: Option<usize>,
        guess: &mut [f64; 2],
        out: &mut [S],
    ) -> Result<(), Unbalanced> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let (moment, frame) = self.section(values, &mut scratch);
        let zero = S::constant(0.0);
        let tail = 4 * scratch.tubes.len();
        let (mut mass, mut arm) = (zero, [zero; 2]);
        let mut leader = zero;
        let found = balance(&mut scratch, values, moment, guess, |place, own: &Seen<S>| {
            own.put_slopes(&mut out[4 * place..4 * place + 4]);
            if self.present[place] == 0 {
                leader = out[4 * place];
            }
            if self.command.gravity.is_some() {
                let (own_mass, own_arm) = (own.mass(), own.arm());
                mass += own_mass;
                arm = [arm[0] + own_mass * own_arm[0], arm[1] + own_mass * own_arm[1]];
            }
        });
        self.scratch = scratch;
        let [wy, wz] = found?;
        self.rub(values, out);
        out[tail] = S::constant(1.0);
        if self.posed {
            let (_, turn) = self.pose_in(values);
            let tangent = frame.map_or_else(|| first_column(&turn), |(_, [x, ..])| x);
            out[tail + 1..tail + 4].copy_from_slice(&tangent);
            let [qw, qx, qy, qz] = turn;
            // q' = ½ q ∘ (0, 0, ω_y, ω_z).
            out[tail + 4] = -(qy * wy + qz * wz) * 0.5;
            out[tail + 5] = (qy * wz - qz * wy) * 0.5;
            out[tail + 6] = (qw * wy - qx * wz) * 0.5;
            out[tail + 7] = (qw * wz + qx * wy) * 0.5;
            if let Some((centre, [_, y, z])) = frame {
                let mut force = [zero; 3];
                let mut moment = [zero; 3];
                if let Some(gravity) = self.command.gravity {
                    let gravity = gravity.map(|g| self.load * g);
                    force = gravity.map(|g| g * mass);
                    let place = [0, 1, 2].map(|i| centre[i] * mass + y[i] * arm[0] + z[i] * arm[1]);
                    moment = cross(place, gravity);
                }
                for &number in &self.distributed {
                    let own = array(&self.command.distributed[number].force).map(|f| leader * self.load * f);
                    force = sum(force, own);
                    moment = sum(moment, cross(centre, own));
                }
                for i in 0..3 {
                    out[tail + 8 + i] = -force[i];
                    out[tail + 11 + i] = -moment[i];
                }
            }
        }
        if let Some(place) = leading {
            let inverse = out[4 * place].inverse();
            for value in out.iter_mut() {
                *value = *value * inverse;
            }
            out[4 * place] = S::constant(1.0);
        }
        Ok(())
    }

    /// Guess for ω at the place.
    pub fn guess(&self) -> [f64; 2] {
        self.omega
    }

    /// Adds the friction of neighbours to the slopes of their tensions and torques.
    fn rub(&self, values: &[S], out: &mut [S]) {
        let Some(rubbing) = &self.command.rubbing else { return };
        for (place, tubes) in self.present.windows(2).enumerate() {
            let Some(pair) = rubbing.pair(tubes[0], tubes[1]) else { continue };
            let side = |place: usize| {
                let at = 4 * place;
                Side { label: values[at], angle: values[at + 2], advance: out[at], twist: out[at + 2] }
            };
            let (outer, inner) = (side(place), side(place + 1));
            let [along, around] = pair.force(self.passed, &outer, &inner);
            let torque = around * pair.radius;
            for (place, own, sign) in [(place, outer, 1.0), (place + 1, inner, -1.0)] {
                let pull = (along - own.twist * torque) / own.advance;
                out[4 * place + 1] = out[4 * place + 1].plus(sign, pull);
                out[4 * place + 3] = out[4 * place + 3].plus(-sign, torque);
            }
        }
    }

    /// ω, and what every tube carries.
    pub fn carried(&mut self) -> Result<([S; 2], Vec<Carried<S>>), Unbalanced> {
        let mut all = Vec::with_capacity(self.present.len());
        let (omega, _) = self.look(&mut |_, own| {
            all.push((own.energy(), own.moment(), own.mass(), own.arm()));
        })?;
        let each = |(place, (energy, moment, mass, arm)): (usize, (S, [S; 2], S, [S; 2]))| Carried {
            axial: energy - (moment[0] * omega[0] + moment[1] * omega[1]),
            moment: [self.values[4 * place + 3], moment[0], moment[1]],
            mass,
            arm,
        };
        Ok((omega, all.into_iter().enumerate().map(each).collect()))
    }

    /// ω at the place, G there (N), and what `each` sees.
    fn look(&mut self, each: &mut dyn FnMut(usize, &Seen<S>)) -> Result<([S; 2], S), Unbalanced> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let (moment, _) = self.section(&self.values, &mut scratch);
        let mut omega = self.omega;
        let mut energy = S::constant(0.0);
        let found = balance(&mut scratch, &self.values, moment, &mut omega, |place, own| {
            energy += own.energy();
            each(place, own);
        });
        self.scratch = scratch;
        let found = found?;
        self.omega = omega;
        Ok((found, energy - (moment[0] * found[0] + moment[1] * found[1])))
    }

    /// The section at the place, for a visitor.
    pub fn visit(&mut self, see: &mut dyn FnMut(&Section<S>)) -> Result<(), Unbalanced> {
        let mut rates = Vec::with_capacity(self.present.len());
        let (omega, _) = self.look(&mut |_, own| rates.push([own.advance(), own.twist()]))?;
        see(&Section { flow: self, omega, rates: &rates });
        Ok(())
    }

    /// G at the place (N).
    pub fn energy(&mut self) -> Result<S, Unbalanced> {
        Ok(self.look(&mut |_, _| {})?.1)
    }

    /// Gives the tension of one tube the value at which G becomes `wanted`.
    pub fn restore(&mut self, place: usize, wanted: S) -> Result<(), Unbalanced> {
        // G grows with T at the rate g/h°, and is concave in it, but not every tension has a section that balances.
        let at = 4 * place + 1;
        let mut balanced = None;
        for _ in 0..RESTORING {
            let tension = self.values[at].value();
            let next = match (self.energy_and_rate(place), balanced) {
                (Ok((energy, rate)), _) => {
                    let missing = wanted.value() - energy;
                    if missing.abs() <= 1e-9 * (self.command.force_scale + tension.abs()) {
                        // The last step brings the slopes.
                        let missing = wanted - self.energy()?;
                        self.values[at].add_scaled(1.0 / rate, &missing);
                        return Ok(());
                    }
                    balanced = Some(tension);
                    tension + missing / rate
                }
                (Err(_), Some(last)) => 0.5 * (last + tension),
                // A tube that others held until now may be pushed by more than it bears alone.
                (Err(_), None) if tension < 0.0 => 0.0,
                (Err(lost), None) => return Err(lost),
            };
            self.values[at] = S::constant(next);
        }
        Err(Unbalanced)
    }

    /// G at the place (N) and its slope by the tension of one tube, without slopes.
    fn energy_and_rate(&mut self, place: usize) -> Result<(f64, f64), Unbalanced> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let (moment, _) = self.section(&self.values, &mut scratch);
        let load = moment.map(Number::value);
        let found = rates(&scratch.tubes, load, &mut self.omega).map(|_| {
            let own = |tube: &Tube| tube.plain(self.omega);
            let energy: f64 = scratch.tubes.iter().map(|tube| own(tube).energy).sum();
            let [y, z] = self.omega;
            (energy - (load[0] * y + load[1] * z), own(&scratch.tubes[place]).advance)
        });
        self.scratch = scratch;
        found
    }

    /// Takes a load off the section of the tube at `place`: beyond, neither force nor moment know of it.
    pub fn apply(&mut self, load: &Applied, place: usize) -> SectionLoad<S> {
        let (centre, turn) = self.pose();
        let [x, y, z] = columns(turn);
        let (sin, cos) = self.angle_of_section(place).sin_cos();
        let axes =
            [x, [0, 1, 2].map(|i| y[i] * cos + z[i] * sin), [0, 1, 2].map(|i| z[i] * cos - y[i] * sin)];
        let (force, moment, arm) = load.at(&centre, &axes);
        self.take_off(force.map(|f| f * self.load), moment.map(|m| m * self.load), arm)
    }

    /// The same for a force (N) and a moment (N m) at a distance (m) from the section's centre, all in world components.
    pub fn take_off(&mut self, force: [S; 3], moment: [S; 3], arm: [S; 3]) -> SectionLoad<S> {
        let (centre, turn) = self.pose();
        let [x, ..] = columns(turn);
        let about_section = sum(moment, cross(arm, force));
        let about_origin = sum(about_section, cross(centre, force));
        let at = 4 * self.present.len() + 1 + POSE;
        for i in 0..3 {
            self.values[at + i] = self.values[at + i] - force[i];
            self.values[at + 3 + i] = self.values[at + 3 + i] - about_origin[i];
        }
        SectionLoad { force_along: dot(force, x), about: dot(about_section, x) }
    }
}

/// What one tube carries across a section, on what lies towards the base.
pub(crate) struct Carried<S> {
    /// Force along the tangent (N): E is of degree one in all rates along the robot, of which that of the centreline is one.
    pub axial: S,
    /// Moment about the centre (N m): about the tangent, and y and z of the untwisted frame.
    pub moment: [S; 3],
    /// Mass per centreline length (kg/m), and the arm of its centroid (m) in y and z.
    pub mass: S,
    pub arm: [S; 2],
}

impl<'a> Flow<'a, f64> {
    /// The same place in numbers with slopes by the length s.
    pub fn along(&self) -> Result<Flow<'a, Dual<2>>, Unbalanced> {
        let mut own = self.at(self.values.clone());
        let mut slopes = vec![0.0; self.values.len()];
        own.slopes(None, &mut slopes)?;
        let numbers = self.values.iter().zip(slopes);
        Ok(self.at(numbers.map(|(value, slope)| Dual::new(*value, |_| slope)).collect()))
    }

    fn at<S: Number>(&self, values: Vec<S>) -> Flow<'a, S> {
        let (present, pieces) = (self.present.clone(), self.pieces.clone());
        let (distributed, span, passed, omega) =
            (self.distributed.clone(), self.span, self.passed, self.omega);
        Flow {
            present,
            pieces,
            values,
            distributed,
            span,
            passed,
            omega,
            ..Flow::new(self.command, self.posed, S::constant(self.load))
        }
    }
}

impl Flow<'_, f64> {
    /// What the tubes contribute at the place, with slopes.
    pub fn locals(&self, omega: [f64; 2]) -> Vec<Local> {
        let mut scratch = Scratch::default();
        self.section(&self.values, &mut scratch);
        scratch.tubes.iter().map(|tube| tube.local(omega)).collect()
    }
}

/// Turns of the search for a tension.
const RESTORING: usize = 30;
