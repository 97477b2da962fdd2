//! Readers, writers and what they keep, against hand-made bytes and other tools' files.

mod arrays;
mod assemble;
mod csv;
mod documentation;
mod hdf5;
mod hdf5_foreign;
mod layouts;
mod model_file;
mod selection;
mod uff;
