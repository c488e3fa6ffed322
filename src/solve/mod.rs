//! From an initial value problem to a solution: options, the loop, what looks on, what comes back.

mod begin;
mod blame;
mod check;
mod collocation;
pub(crate) mod control;
mod dense;
pub(crate) mod event;
pub(crate) mod ivp;
pub(crate) mod outcome;
pub(crate) mod run;
mod start;
pub(crate) mod steps;
pub(crate) mod watch;
