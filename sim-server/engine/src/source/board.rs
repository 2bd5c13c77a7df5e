//! What the robots of one world tell each other before each tick.

use std::cell::RefCell;
use std::rc::Rc;

use rusty_geometry::Twist;

use super::SourceError;

/// How far each robot's run is, and the commands of those with a driver. A tick of one
/// may happen once all are ready for it.
#[derive(Debug)]
struct Board {
    /// By place: the number of ticks that the run is ready for.
    ready: Vec<u64>,
    /// By place and tick: the command of a robot with a driver, as its wheels can follow
    /// it; empty for all others.
    commands: Vec<Vec<Twist>>,
    /// The robot whose run ended before the others', and after how many ticks.
    ended: Option<(String, u64)>,
}

/// A robot's place at the board. Clones look at the same one.
#[derive(Clone, Debug)]
pub(super) struct Seat {
    board: Rc<RefCell<Board>>,
    place: usize,
}

impl Seat {
    /// As many places as there are robots.
    pub(super) fn all(robots: usize) -> Vec<Self> {
        let board =
            Board { ready: vec![0; robots], commands: vec![Vec::new(); robots], ended: None };
        let board = Rc::new(RefCell::new(board));
        (0..robots).map(|place| Self { board: Rc::clone(&board), place }).collect()
    }

    /// This robot is ready for `tick`; `command` is that of its driver, if it has one.
    /// Returns whether all are.
    ///
    /// # Errors
    /// [`SourceError::OtherEnded`] if one never will be.
    pub(super) fn ready(&self, tick: u64, command: Option<Twist>) -> Result<bool, SourceError> {
        let mut board = self.board.borrow_mut();
        if let Some((robot, ticks)) = &board.ended {
            return Err(SourceError::OtherEnded { robot: robot.clone(), ticks: *ticks });
        }
        if board.ready[self.place] == tick {
            board.ready[self.place] = tick + 1;
            board.commands[self.place].extend(command);
        }
        Ok(board.ready.iter().all(|ready| *ready > tick))
    }

    /// The commands of drivers of the others in `tick`, with their places.
    pub(super) fn commands(&self, tick: u64, mut drive: impl FnMut(usize, Twist)) {
        let board = self.board.borrow();
        let others = board.commands.iter().enumerate().filter(|(place, _)| *place != self.place);
        for (place, commands) in others {
            let index = usize::try_from(tick).unwrap_or(usize::MAX);
            commands.get(index).into_iter().for_each(|command| drive(place, *command));
        }
    }

    /// This robot's run has ended after `ticks` although there are more.
    pub(super) fn end(&self, robot: &str, ticks: u64) {
        self.board.borrow_mut().ended.get_or_insert_with(|| (robot.to_owned(), ticks));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: Twist = Twist { v_m_s: 0.5, omega_rad_s: 0.0 };

    #[test]
    fn a_tick_waits_for_all_and_commands_are_kept() {
        let [a, b] = &Seat::all(2)[..] else { panic!() };
        assert!(!a.ready(0, Some(AHEAD)).unwrap());
        assert!(!a.ready(0, Some(Twist::default())).unwrap(), "asked again: said once");
        assert!(b.ready(0, None).unwrap() && a.ready(0, None).unwrap());
        assert!(!b.ready(1, None).unwrap());
        let commands = |seat: &Seat, tick| {
            let mut found = Vec::new();
            seat.commands(tick, |place, command| found.push((place, command)));
            found
        };
        assert_eq!(commands(b, 0), [(0, AHEAD)]);
        assert_eq!((commands(b, 1), commands(a, 0)), (vec![], vec![]));
        a.end("a", 1);
        b.end("b", 5);
        let error = b.ready(1, None).unwrap_err();
        assert!(matches!(error, SourceError::OtherEnded { robot, ticks: 1 } if robot == "a"));
    }
}
