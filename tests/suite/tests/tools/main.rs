//! Commands that measure, compare and draw.

mod bench;
mod calibration;
mod conformance;
mod doctor;
mod handbook_commands;
mod manual;
mod player;
mod programs;
mod report;
mod shards;
mod sweep;
mod versus;
