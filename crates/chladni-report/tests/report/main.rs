//! The public interface of the report.

mod data;
mod figures;
mod inputs;
mod page;
