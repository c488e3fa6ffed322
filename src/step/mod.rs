//! One step of any method: what a state is, how a row is worked out, the one stepper.

pub(crate) mod consistent;
pub(crate) mod coupled;
pub(crate) mod derivative;
pub(crate) mod diagonal;
pub(crate) mod estimate;
pub(crate) mod implicit;
pub(crate) mod iteration;
pub(crate) mod measure;
pub(crate) mod method;
pub(crate) mod nordsieck;
pub(crate) mod norm;
pub(crate) mod order;
pub(crate) mod oscillation;
pub(crate) mod pascal;
pub(crate) mod rosenbrock;
pub(crate) mod rounding;
pub(crate) mod row;
pub(crate) mod scalar;
pub(crate) mod split;
pub(crate) mod state;
pub(crate) mod stepper;
pub(crate) mod system;
