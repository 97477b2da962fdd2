//! The methods on the virtual panel, judged on its truth.

mod limits;
mod rendered;
mod served;
mod unusual;
