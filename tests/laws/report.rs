//! What is broken, and by how much.

use super::file::File;

/// Every condition that a method here breaks at the order above its own is off by 4e-7 or more.
const BROKEN: f64 = 1e-8;

pub struct Report<'a> {
    pub file: &'a File,
    pub broken: Vec<String>,
    /// The most that a law is off.
    worst: f64,
}

impl<'a> Report<'a> {
    pub fn new(file: &'a File) -> Self {
        Self { file, broken: Vec::new(), worst: 0.0 }
    }

    pub fn say(&mut self, what: String) {
        self.broken.push(format!("{}: {what}", self.file.path));
    }

    /// Whether a law holds; `off` is how far it is broken.
    pub fn expect(&mut self, off: f64, law: impl Fn() -> String) -> bool {
        self.worst = self.worst.max(off);
        let holds = off <= self.file.tolerance();
        if !holds {
            self.say(format!("{} is off by {off:.1e}", law()));
        }
        holds
    }

    /// The claimed order is not too low: `off` is the most that a condition of the next order is broken.
    pub fn expect_sharp(&mut self, name: &str, order: usize, off: f64) {
        if off <= BROKEN.max(10.0 * self.file.tolerance()) {
            self.say(format!("{name} claims order {order}, yet all conditions of order {} hold", order + 1));
        }
    }

    /// The claimed digits are not too few, which would weaken every proof of the file.
    pub fn expect_all_digits(&mut self) {
        let (digits, worst) = (self.file.digits, self.worst);
        if digits > 0 && worst < 1e-3 * self.file.tolerance() {
            self.say(format!("claims {digits} digits, yet every law holds to {worst:.1e}"));
        }
    }
}
