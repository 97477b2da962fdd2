//! The command line, tried as its users try it.

mod agreement;
mod bench;
mod common;
mod crash_safety;
mod demo;
mod documentation;
mod errors;
mod folders;
mod formats;
mod info;
mod journey;
mod malformed;
mod pages;
mod pieces;
mod play;
mod render;
mod shell;
mod spoiled;
mod troubleshooting;
