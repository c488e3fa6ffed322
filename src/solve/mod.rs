//! From an initial value problem to a solution: options, the loop, what looks on, what comes back.

pub(crate) mod auto;
mod begin;
mod blame;
mod check;
pub(crate) mod control;
mod dense;
pub(crate) mod event;
pub(crate) mod ivp;
pub(crate) mod leg;
mod matrices;
pub(crate) mod outcome;
mod run;
mod start;
pub(crate) mod steps;
pub(crate) mod stiffness;
pub(crate) mod watch;
