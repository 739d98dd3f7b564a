//! The fast suite: behaviour of the haptic loop and of the patch's guard, through the public
//! interface alone.
//!
//! Mutants of the safety logic are run against it (`tests/mutants`), so it builds without the
//! simulator and ends within seconds. Each test states a rule; a number in it is that of the rule,
//! not a recorded output.
#![allow(clippy::type_complexity, clippy::needless_pass_by_value, reason = "tables of setters read best where they stand")]

mod arming;
mod bench;
mod bounce;
mod ceiling;
mod commissioning;
mod counts;
mod damping;
mod deadline;
mod debt;
mod energy;
mod faults;
mod friction;
mod gate;
mod guard;
mod law;
mod limiter;
mod limits;
mod output;
mod patch;
mod plane;
mod presence;
mod relaxation;
mod relief;
mod runaway;
mod search;
mod settings;
mod stop;
mod tilt;
mod toggle;
mod unread;
