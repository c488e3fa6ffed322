//! Normal maps by kutta and by a general image library, on one thread.
