//! Short and long forms of tests over tables of cases: `./test` runs only a part of the cases,
//! `./test --long` runs all of them.

/// Environment variable that `./test --long` sets.
const LONG: &str = "PALPATE_LONG";

/// Whether all cases are run.
pub fn long() -> bool {
    std::env::var_os(LONG).is_some()
}

/// Chooses cases of a table at regular intervals, starting with the first. If the interval is a
/// prime that divides no dimension of the table, every value of every dimension occurs.
#[derive(Clone, Debug)]
pub struct Share {
    one_in: usize,
    seen: usize,
}

impl Share {
    /// Chooses one case in `one_in`, or all cases in the long form.
    pub fn one_in(one_in: usize) -> Self {
        Self { one_in: if long() { 1 } else { one_in }, seen: 0 }
    }

    /// Whether the next case is run; called once per case.
    pub fn takes(&mut self) -> bool {
        self.seen += 1;
        (self.seen - 1).is_multiple_of(self.one_in)
    }
}
