//! Events: roots of a function of the solution, found on the dense output.

use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use num_traits::{One, Zero};

/// Which sign changes count, in the order of the run: also where time runs backwards.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Crossing {
    #[default]
    Any,
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
}

/// What happens at a root.
pub(crate) enum Then<'w, Y: State> {
    Record,
    Stop,
    Change(Box<dyn FnMut(RealOf<Y>, &mut Y) + 'w>),
    /// Of y'' = f(t, y): position and velocity.
    ChangeMotion(Box<dyn FnMut(RealOf<Y>, &mut Y, &mut Y) + 'w>),
}

pub(crate) struct Event<'w, Y: State> {
    pub g: Box<dyn FnMut(RealOf<Y>, &Y) -> RealOf<Y> + 'w>,
    pub crossing: Crossing,
    pub then: Then<'w, Y>,
    /// g where the last step ended; none before the first step and after a change of the state.
    pub last: Option<RealOf<Y>>,
    /// g at the root where the event has just changed the state.
    pub root: Option<RealOf<Y>>,
    /// What g misses its root by, where the change left it there: no more than that is as good as zero.
    pub miss: RealOf<Y>,
}

impl<Y: State> Event<'_, Y> {
    /// g near a root that was left behind.
    fn settled(&mut self, t: RealOf<Y>, y: &Y) -> RealOf<Y> {
        let g = (self.g)(t, y);
        if g.modulus() <= self.miss { RealOf::<Y>::zero() } else { g }
    }

    /// Some event changed the state at t to y. A root that lies behind is not found again.
    pub fn restart(&mut self, t: RealOf<Y>, y: &Y) {
        let g = (self.g)(t, y);
        self.miss = if self.root.take() == Some(g) { g.modulus() } else { RealOf::<Y>::zero() };
        self.last = Some(self.settled(t, y));
    }
}

/// A root inside a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root<R> {
    pub event: usize,
    pub t: R,
    /// Where in the step, from 0 to 1.
    pub theta: R,
}

/// Points of a step at which g is looked at: two roots nearer than this share of a step hide each other.
const SAMPLES: usize = 8;

/// More of them after a start at zero, where g may be back soon: a ball that hardly bounces any more.
const NEAR: [f64; 10] = [1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];

/// The roots of one step in the order of time. A root at the end of a step belongs to it, one at its
/// start does not; a g that starts at zero counts from where it has a sign.
pub(crate) fn find_roots<Y: State>(
    events: &mut [Event<'_, Y>],
    at: &impl Fn(RealOf<Y>, &mut Y),
    y0: &Y,
    t: RealOf<Y>,
    h: RealOf<Y>,
    t1: RealOf<Y>,
    y: &mut Y,
) -> Vec<Root<RealOf<Y>>> {
    let zero = RealOf::<Y>::zero();
    let time = |theta: RealOf<Y>| if theta == RealOf::<Y>::one() { t1 } else { t + theta * h };
    let mut roots = vec![];
    for (event, e) in events.iter_mut().enumerate() {
        let (mut theta, mut g) = (zero, e.last.unwrap_or_else(|| (e.g)(t, y0)));
        let near = if g.is_zero() { &NEAR[..] } else { &[] };
        let even = (1..=SAMPLES).map(|k| k as f64 / SAMPLES as f64);
        for (k, next) in near.iter().copied().chain(even).enumerate() {
            let next = RealOf::<Y>::from_f64(next);
            at(next, y);
            let g_next = if k < near.len() { e.settled(time(next), y) } else { (e.g)(time(next), y) };
            let rises = g < zero && g_next >= zero;
            let falls = g > zero && g_next <= zero;
            let counts = match e.crossing {
                Crossing::Any => rises || falls,
                Crossing::Rising => rises,
                Crossing::Falling => falls,
            };
            if counts {
                let mut value = |theta| {
                    at(theta, y);
                    (e.g)(time(theta), y)
                };
                let theta = bracketed_root(&mut value, (theta, g), (next, g_next), t, h);
                roots.push(Root { event, t: time(theta), theta });
            }
            (theta, g) = (next, g_next);
        }
        e.last = Some(g);
    }
    let key = |r: &Root<RealOf<Y>>| r.theta.to_f64();
    roots.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.event.cmp(&b.event)));
    roots
}

/// The root between two signs by the Illinois method (Dowell, Jarratt 1971, BIT 11), bisecting where it
/// is slow. The end returned is the one past the root: there g has its new sign, so a run that goes on
/// from it does not find the same root again.
fn bracketed_root<R: Real>(value: &mut impl FnMut(R) -> R, low: (R, R), high: (R, R), t: R, h: R) -> R {
    let (mut a, mut ga) = low;
    let (mut b, mut gb) = high;
    let half = R::from_f64(0.5);
    let mut last = 0;
    for round in 0..200 {
        // No nearer than the spacing of times there: a ball that hardly bounces rises by little more than
        // the last digits of where it touched.
        if gb.is_zero() || (b - a) * h.modulus() <= (t + b * h).ulp() {
            return b;
        }
        let slope = gb - ga;
        let mut c = b - gb * (b - a) / slope;
        let inside = c > a && c < b;
        if !inside || round % 3 == 2 {
            c = a + (b - a) * half;
        }
        if c <= a || c >= b {
            return b;
        }
        let gc = value(c);
        let same_as_b = (gc > R::zero()) == (gb > R::zero()) || gc.is_zero();
        if same_as_b {
            (b, gb) = (c, gc);
            if last == 1 {
                ga = ga * half;
            }
            last = 1;
        } else {
            (a, ga) = (c, gc);
            if last == -1 {
                gb = gb * half;
            }
            last = -1;
        }
    }
    b
}
