//! MATLAB and NumPy files: every class, order and packing; what we write reads back the
//! same.

mod facts;
mod mat;
mod matlab;
mod npz;
mod numpy;
mod sets;
