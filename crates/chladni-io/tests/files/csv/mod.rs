//! Text tables: every layout, every refusal with its words, our own round trip, real
//! samples.

mod declared;
mod layouts;
mod reading;
mod refusals;
mod round_trip;
mod samples;
mod units;
