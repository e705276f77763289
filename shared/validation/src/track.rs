//! A robot's trajectory as a function of time.

use plan::Knot;

/// Linear between knots; still before the first and after the last.
#[derive(Clone, Copy)]
pub(crate) struct Track<'a> {
    pub(crate) knots: &'a [Knot],
}

/// The straight motion that holds at some instant; still if both knots are the same.
#[derive(Clone, Copy)]
pub(crate) struct Leg<'a> {
    pub(crate) from: &'a Knot,
    pub(crate) to: &'a Knot,
}

/// Subdivisions of the way between two knots on which travelled ways and heights are measured.
pub(crate) const GRID: usize = 16;

impl<'a> Track<'a> {
    pub(crate) fn end(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.t)
    }

    /// Breaks between legs.
    pub(crate) fn times(&self) -> impl Iterator<Item = f64> + 'a {
        self.knots.iter().map(|knot| knot.t)
    }

    /// The leg at `t`; at a knot, the one that begins there.
    pub(crate) fn leg(&self, t: f64) -> Leg<'a> {
        let next = self.knots.partition_point(|knot| knot.t <= t);
        let from = &self.knots[next.saturating_sub(1)];
        let to = &self.knots[next.min(self.knots.len() - 1)];
        Leg { from, to }
    }

    /// Instants from `from` towards `to` (either way), at knots and at [`GRID`] even steps between them.
    pub(crate) fn grid(&self, from: f64, to: f64) -> impl Iterator<Item = f64> + use<'a> {
        let mut stops: Vec<f64> = self.times().filter(|t| *t > from.min(to) && *t < from.max(to)).collect();
        stops.insert(0, from.min(to));
        stops.push(from.max(to));
        if from > to {
            stops.reverse();
        }
        (1..stops.len()).flat_map(move |i| {
            let (a, b) = (stops[i - 1], stops[i]);
            (1..=GRID).map(move |step| if step == GRID { b } else { a + (b - a) * step as f64 / GRID as f64 })
        })
    }
}

impl Leg<'_> {
    pub(crate) fn is_still(&self) -> bool {
        self.to.t <= self.from.t
    }

    /// Writes the configuration at `t` into `out`.
    pub(crate) fn configuration(&self, t: f64, out: &mut Vec<f64>) {
        let part = if self.is_still() { 0.0 } else { ((t - self.from.t) / (self.to.t - self.from.t)).clamp(0.0, 1.0) };
        out.clear();
        out.extend(self.from.q.iter().zip(&self.to.q).map(|(a, b)| a + (b - a) * part));
    }

    /// Speed of one coordinate, with sign.
    pub(crate) fn rate(&self, coordinate: usize) -> f64 {
        if self.is_still() {
            return 0.0;
        }
        (self.to.q[coordinate] - self.from.q[coordinate]) / (self.to.t - self.from.t)
    }
}
