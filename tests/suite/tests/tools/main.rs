//! Commands that measure, compare and draw.

mod bench;
mod benchmark;
mod calibration;
mod conformance;
mod crews;
mod doctor;
mod handbook_commands;
mod kept_files;
mod manual;
mod player;
mod programs;
mod report;
mod shards;
mod sweep;
mod versus;
