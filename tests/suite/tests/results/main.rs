//! Logs, scores, exports and imports: what they hold, and what they never write over.

mod evo;
mod export;
mod figures;
mod files;
mod out_folder;
mod real_robot;
mod recordings;
mod rerun;
mod ros;
mod run_folders;
mod scores;
mod world_files;
