//! What participants and logs keep secret, and what a hostile program cannot do.

mod authentic;
mod blind;
mod gates;
mod hostile;
mod sandbox;
