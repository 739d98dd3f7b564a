//! Short and long forms of tests over tables of cases: `./test` runs a share of the cases,
//! `./test --long` every one of them.

/// Environment variable that `./test --long` sets.
const LONG: &str = "PALPATE_LONG";

/// Whether every case is to be run.
#[must_use]
pub fn long() -> bool {
    std::env::var_os(LONG).is_some()
}

/// Chooses cases of a table at regular intervals, the first one included. A prime interval that
/// divides no side of the table reaches every value of every side.
#[derive(Clone, Debug)]
pub struct Share {
    one_in: usize,
    seen: usize,
}

impl Share {
    /// Takes one case in `one_in`, or all in the long form.
    #[must_use]
    pub fn one_in(one_in: usize) -> Self {
        Self { one_in: if long() { 1 } else { one_in }, seen: 0 }
    }

    /// Whether the next case is run.
    pub fn takes(&mut self) -> bool {
        self.seen += 1;
        (self.seen - 1).is_multiple_of(self.one_in)
    }
}
