//! The command line, tried as its users try it.

mod agreement;
mod bench;
mod common;
mod compare;
mod crash_safety;
mod demo;
mod documentation;
mod doors;
mod errors;
mod folders;
mod formats;
mod hostile;
mod info;
mod journey;
mod layouts;
mod malformed;
mod measured_fields;
mod pages;
mod pieces;
mod pipes;
mod play;
mod render;
mod shell;
mod spoiled;
mod studio;
mod troubleshooting;
