//! One integration along the bundle, from the plate to the last tip.
//!
//! Unknown at the start is what the plate does not prescribe (forces, torques, the moment on the section) and what joints hand
//! on; the integration gives what is left of the conditions at joints and tips. On the way, labels at which something happens
//! cut the bundle into spans: ends of pieces, joints and tips, loads. Along a span the label of the tube that arrives first is the
//! independent variable, so that a span ends exactly at its event, whatever the inputs are.
//!
//! Where the fields of a tube jump, its tension jumps with them: the Hamiltonian −G + n·t goes on (Weierstrass, Erdmann).

use super::coordinates::Coordinates;
use super::course::Course;
use super::flow::{Flow, LOADS, POSE, Visitor};
use super::number::Number;
use super::prepared::{Prepared, Stop};
use super::section::{TubeState, Unbalanced};
use super::steps::{Span, Steps, march};
use super::vector::{columns, cross, dot};
use super::{Bundle, SAME};

/// What the plate and the joints set the bundle off with.
#[derive(Clone, Debug)]
pub(crate) struct Base<S> {
    /// Per tube.
    pub tubes: Vec<TubeState<S>>,
    /// Internal force at the plate (N) and moment about the origin (N m): world components.
    pub force: [S; 3],
    pub moment: [S; 3],
    /// Tension and torque beyond a joint of every tube that goes on, the first of each joint left out.
    pub handed: Vec<[S; 2]>,
    /// Dead force (N) and moment (N m) on the centre of the last tip besides the loads, world components.
    pub wrench: Option<[[S; 3]; 2]>,
    /// Factor of the loads.
    pub load: S,
    /// Of how many unknowns numbers have slopes.
    pub unknowns: usize,
}

/// What an integration left.
#[derive(Clone, Debug)]
pub(crate) struct Outcome<S> {
    /// Position of the last tip (m), quaternion of the untwisted frame and angle of the material there.
    pub centre: [S; 3],
    pub turn: [S; 4],
    pub angle: S,
    /// Length of the centreline (m).
    pub length: S,
}

/// Why an integration came to no end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lost {
    /// A section balances at no curvature.
    Section,
    /// Steps became too small.
    Steps,
    /// Tubes pass their events in no order.
    Order,
}

impl From<Unbalanced> for Lost {
    fn from(_: Unbalanced) -> Self {
        Self::Section
    }
}

/// How to walk.
#[derive(Clone, Copy)]
pub(crate) struct Walk<'a> {
    pub bundle: &'a Bundle,
    pub command: &'a Prepared,
    /// Is the pose of the section integrated? It has to be wherever there are loads.
    pub posed: bool,
    /// Error allowed in one step, in scaled variables.
    pub tolerance: f64,
    /// Longest step (m).
    pub longest: f64,
    /// Sections further apart than this (m) are interpolated between the ends of a step, for the visitor alone.
    pub spacing: f64,
    /// Where the states at new ends of steps are laid; `None` leaves them where the integration arrives.
    pub course: Option<&'a Course>,
}

impl Walk<'_> {
    /// Integrates from the plate to the last tip with the given steps, which are chosen where they are not known. `visit` sees the
    /// section at the end of every step.
    pub fn run<'b, S: Number>(
        &'b self,
        base: &'b Base<S>,
        steps: &mut Steps,
        visit: Option<Visitor<'b, S>>,
    ) -> Result<Outcome<S>, Lost> {
        steps.begin_again(base.unknowns, self.tolerance, self.command.stops.iter().map(Vec::len));
        let mut runner = Runner::new(*self, base, visit);
        runner.look()?;
        let mut number = 0;
        while !runner.flow.present.is_empty() {
            runner.span(steps, number)?;
            number += 1;
            runner.flow.span = number;
            runner.look()?;
        }
        steps.end(number);
        runner.finish(&mut steps.coordinates)
    }
}

impl Walk<'_> {
    /// The leader's tension at the plate (N) at which the Hamiltonian vanishes there, as it does all along where nothing but tubes and
    /// dead forces act.
    pub fn leader_tension(&self, base: &Base<f64>) -> Option<f64> {
        let mut runner = Runner::new(*self, base, None);
        runner.flow.restore(0, base.force[0]).ok()?;
        Some(runner.flow.values[1])
    }
}

struct Runner<'a, 'b, S: Number> {
    walk: Walk<'a>,
    flow: Flow<'a, S>,
    /// Next stop of every tube.
    next: Vec<usize>,
    handed: std::slice::Iter<'b, [S; 2]>,
    wrench: Option<[[S; 3]; 2]>,
    last: Option<([S; 3], [S; 4], S, S)>,
    /// Labels that no tube but the leading one may pass on a span.
    limits: Vec<f64>,
    visit: Option<Visitor<'b, S>>,
}

impl<'a, 'b, S: Number> Runner<'a, 'b, S> {
    fn new(walk: Walk<'a>, base: &'b Base<S>, visit: Option<Visitor<'b, S>>) -> Self {
        let (bundle, command) = (walk.bundle, walk.command);
        let mut flow = Flow::new(command, walk.posed, base.load);
        let mut next = Vec::with_capacity(base.tubes.len());
        for (tube, state) in base.tubes.iter().enumerate() {
            let label = state.label.value();
            next.push(command.stops[tube].partition_point(|stop| stop.0 <= label));
            if label < bundle.tubes[tube].tip {
                flow.enter(tube, bundle.tubes[tube].piece_at(label), *state);
            }
        }
        if walk.posed {
            let zero = S::constant(0.0);
            flow.values.extend([zero; 3]);
            flow.values.push(S::constant(1.0));
            flow.values.extend([zero; 3]);
            if command.loaded {
                flow.values.extend(base.force);
                flow.values.extend(base.moment);
            }
        }
        for (number, d) in command.distributed.iter().enumerate() {
            let label = base.tubes.first().map_or(0.0, |t| t.label.value());
            if d.from <= label && label < d.to {
                flow.distributed.push(number);
            }
        }
        Self {
            walk,
            flow,
            next,
            handed: base.handed.iter(),
            wrench: base.wrench,
            last: None,
            limits: Vec::new(),
            visit,
        }
    }

    /// Shows the section to the visitor.
    fn look(&mut self) -> Result<(), Lost> {
        self.flow.passed = self.next.iter().sum();
        if let (Some(visit), false) = (&mut self.visit, self.flow.present.is_empty()) {
            self.flow.visit(*visit)?;
        }
        Ok(())
    }

    fn stop(&self, tube: usize) -> Option<(f64, Stop)> {
        self.walk.command.stops[tube].get(self.next[tube]).copied()
    }

    /// The place of the tube whose event is nearest, were rates to stay.
    fn nearest(&mut self) -> Result<usize, Lost> {
        let mut slopes = vec![S::constant(0.0); self.flow.values.len()];
        self.flow.slopes(None, &mut slopes)?;
        let way = |(place, tube): (usize, &usize)| {
            let (label, _) = self.stop(*tube)?;
            Some((place, (label - self.flow.values[4 * place].value()) / slopes[4 * place].value()))
        };
        let ways = self.flow.present.iter().enumerate().filter_map(way);
        ways.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(place, _)| place).ok_or(Lost::Order)
    }

    /// Integrates to the event that comes first, and passes it.
    fn span(&mut self, steps: &mut Steps, number: usize) -> Result<(), Lost> {
        let length = self.walk.bundle.length;
        // The tube that led last time.
        let known = steps.key(number);
        let leads = |tube: &usize| known == Some((*tube, self.next[*tube])) && self.stop(*tube).is_some();
        let mut leading = match self.flow.present.iter().position(leads) {
            Some(place) => place,
            None => self.nearest()?,
        };
        let (start, mark) = (self.flow.values.clone(), steps.coordinates.mark());
        for _ in 0..=self.flow.present.len() {
            let tube = self.flow.present[leading];
            let (to, _) = self.stop(tube).ok_or(Lost::Order)?;
            let key = (tube, self.next[tube]);
            self.limits.clear();
            for (place, &other) in self.flow.present.iter().enumerate() {
                let limit = self.stop(other).filter(|_| place != leading);
                self.limits.push(limit.map_or(f64::INFINITY, |(label, _)| label + SAME * length));
            }
            let span = Span { leading, to, number, key, passed: &self.next, limits: &self.limits };
            match march(&mut self.flow, &span, steps, &self.walk, &mut self.visit)? {
                None => {
                    self.pass(leading, &mut steps.coordinates)?;
                    if !self.flow.present.is_empty() {
                        steps.meet_event(&mut self.flow, &self.walk, number);
                    }
                    return Ok(());
                }
                // Another tube passed its own event before: it leads.
                Some(place) => leading = place,
            }
            self.flow.values.copy_from_slice(&start);
            steps.coordinates.back_to(&mark);
        }
        Err(Lost::Order)
    }

    /// Passes the event of one tube.
    fn pass(&mut self, place: usize, coordinates: &mut Coordinates) -> Result<(), Lost> {
        let tube = self.flow.present[place];
        let (label, stop) = self.stop(tube).ok_or(Lost::Order)?;
        self.next[tube] += 1;
        self.flow.values[4 * place] = S::constant(label);
        match stop {
            Stop::Piece(piece) => {
                let pieces = &self.walk.bundle.tubes[tube].pieces;
                if !pieces[piece].jumps {
                    self.flow.pieces[place] = &pieces[piece + 1];
                    return Ok(());
                }
                let energy = self.flow.energy()?;
                self.flow.pieces[place] = &pieces[piece + 1];
                Ok(self.flow.restore(place, energy)?)
            }
            Stop::Station(station) => self.station(station, coordinates),
            Stop::Load(load) => {
                let energy = self.flow.energy()?;
                let torque = self.flow.apply(&self.walk.command.points[load].1, place);
                let after = energy - torque.force_along;
                self.flow.values[4 * place + 3] = self.flow.values[4 * place + 3] - torque.about;
                Ok(self.flow.restore(place, after)?)
            }
            Stop::Begin(number) | Stop::End(number) => {
                let energy = self.flow.energy()?;
                self.flow.distributed.retain(|&n| n != number);
                if matches!(stop, Stop::Begin(_)) {
                    self.flow.distributed.push(number);
                }
                Ok(self.flow.restore(place, energy)?)
            }
        }
    }

    /// Units of length, force and moment.
    fn units(&self) -> [f64; 3] {
        let (length, force) = (self.walk.bundle.length, self.walk.command.force_scale);
        [length, force, force * length]
    }

    /// Tubes meet in a joint, or one ends.
    fn station(&mut self, number: usize, coordinates: &mut Coordinates) -> Result<(), Lost> {
        let bundle = self.walk.bundle;
        let station = &bundle.stations[number];
        let [length, force, moment] = self.units();
        let energy = self.flow.energy()?;
        let places: Vec<usize> = station
            .iter()
            .filter_map(|&(tube, _)| self.flow.present.iter().position(|&p| p == tube))
            .collect();
        let first = places[0];
        let mut torque = S::constant(0.0);
        for (&place, &(_, label)) in places.iter().zip(station) {
            torque += self.flow.values[4 * place + 3];
            if place != first {
                let angle = self.flow.values[4 * first + 2];
                let give = self.walk.command.lengthening.give * bundle.length / self.walk.command.force_scale;
                let own = self.flow.values[4 * place] - self.flow.values[4 * place + 1] * give;
                coordinates.leave(own - label, length);
                coordinates.leave(self.flow.values[4 * place + 2] - angle, 1.0);
                self.flow.values[4 * place] = S::constant(label);
                self.flow.values[4 * place + 2] = angle;
            }
        }
        let mut energy = energy;
        if self
            .flow
            .present
            .iter()
            .all(|&tube| station.iter().any(|&(t, l)| t == tube && l >= bundle.tubes[t].tip))
        {
            // The last tip carries the loads that act there.
            let mut applied: Vec<_> =
                self.walk.command.tip.iter().map(|load| self.flow.apply(load, first)).collect();
            if let Some([force, moment]) = self.wrench {
                applied.push(self.flow.take_off(force, moment, [S::constant(0.0); 3]));
            }
            for own in applied {
                torque = torque - own.about;
                energy = energy - own.force_along;
            }
            let (centre, turn) = self.flow.pose();
            self.last = Some((centre, turn, self.flow.angle_of_section(first), self.flow.length()));
        }
        let on: Vec<(usize, usize)> = places
            .iter()
            .zip(station)
            .filter(|(_, (tube, label))| *label < bundle.tubes[*tube].tip)
            .map(|(&place, &(tube, _))| (place, tube))
            .collect();
        for &(place, tube) in on.iter().skip(1) {
            let [tension, own] = *self.handed.next().ok_or(Lost::Order)?;
            self.flow.values[4 * place + 1] = tension;
            self.flow.values[4 * place + 3] = own;
            torque = torque - own;
            self.enter_beyond(place, tube);
        }
        if let Some(&(place, tube)) = on.first() {
            self.flow.values[4 * place + 3] = torque;
            self.enter_beyond(place, tube);
        } else {
            coordinates.leave(torque, moment);
        }
        let mut ended: Vec<usize> =
            places.iter().copied().filter(|p| !on.iter().any(|(o, _)| o == p)).collect();
        ended.sort_unstable_by(|a, b| b.cmp(a));
        let kept = on.first().map(|&(place, _)| place - ended.iter().filter(|&&e| e < place).count());
        for place in ended {
            self.flow.remove(place);
        }
        if let Some(place) = kept {
            Ok(self.flow.restore(place, energy)?)
        } else {
            let beyond = if self.flow.present.is_empty() { S::constant(0.0) } else { self.flow.energy()? };
            coordinates.leave(beyond - energy, force);
            Ok(())
        }
    }

    /// A tube goes on beyond a joint: with the piece and the stops that come next.
    fn enter_beyond(&mut self, place: usize, tube: usize) {
        let label = self.flow.values[4 * place].value();
        let bundle = self.walk.bundle;
        self.flow.pieces[place] = bundle.tubes[tube].piece_at(label);
        let stops = &self.walk.command.stops[tube];
        self.next[tube] = self.next[tube].max(stops.partition_point(|stop| stop.0 <= label));
    }

    fn finish(self, coordinates: &mut Coordinates) -> Result<Outcome<S>, Lost> {
        let (centre, turn, angle, length) = self.last.ok_or(Lost::Order)?;
        if self.walk.command.loaded {
            let values = &self.flow.values[1 + POSE..1 + POSE + LOADS];
            let force = [values[0], values[1], values[2]];
            let moment = [values[3], values[4], values[5]];
            let [_, y, z] = columns(turn);
            let [_, unit_force, unit] = self.units();
            if self.walk.command.seeks_force {
                for component in force {
                    coordinates.leave(component, unit_force);
                }
            }
            let about = cross(centre, force);
            let left = [moment[0] - about[0], moment[1] - about[1], moment[2] - about[2]];
            coordinates.leave(dot(left, y), unit);
            coordinates.leave(dot(left, z), unit);
        }
        Ok(Outcome { centre, turn, angle, length })
    }
}
