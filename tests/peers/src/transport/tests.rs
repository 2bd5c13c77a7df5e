//! Every transport carries frames and answers faithfully, however it waits.

use std::collections::BTreeSet;
use std::sync::mpsc;
use std::time::Duration;

use rusty_contract::Phase;

use super::*;

const CLIENTS: usize = 2;
const TICKS: u64 = 200;
/// Long enough for a machine that is busy with other things.
const PATIENCE: Duration = Duration::from_secs(120);

/// Bytes that look like nothing, the same for the same words.
fn fill(bytes: &mut [u8], words: [u64; 2]) {
    let mut state = words[0].wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ words[1];
    for byte in bytes {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        *byte = (state >> 56) as u8;
    }
}

fn write_frame(frame: &mut Frame, tick: u64) {
    fill(bytemuck::bytes_of_mut(frame), [tick, u64::MAX]);
    let phase = if tick < TICKS { Phase::Tick } else { Phase::Done };
    bytemuck::bytes_of_mut(frame)[16..20].copy_from_slice(&(phase as u32).to_le_bytes());
}

/// An answer with every byte in use: kind 2, an estimate.
fn answer_of(place: u32, tick: u64) -> Answer {
    let mut answer = Answer::default();
    fill(bytemuck::bytes_of_mut(&mut answer), [tick, u64::from(place)]);
    bytemuck::bytes_of_mut(&mut answer)[44..48].copy_from_slice(&2u32.to_le_bytes());
    answer.participant = place;
    answer.tick = tick;
    answer
}

/// Answers each frame, and says by how many ticks it was not what it should be.
fn client_of(contender: Contender, wait: Wait, folder: &Path, place: u32) -> u64 {
    let (tell, wrong) = mpsc::channel();
    let mut tick = 0;
    let mut expected = Frame::boxed();
    let answer: AnswerFn = Box::new(move |frame| {
        write_frame(&mut expected, tick);
        let same = bytemuck::bytes_of(frame) == bytemuck::bytes_of(&*expected);
        tell.send(u64::from(!same)).unwrap();
        tick += 1;
        Ok((frame.phase() == Phase::Tick).then(|| answer_of(place, tick - 1)))
    });
    let ready = crate::work::Mind::ready(place);
    client(contender, wait, folder).unwrap().serve(ready, answer).unwrap();
    let all: Vec<u64> = wrong.iter().collect();
    assert_eq!(all.len() as u64, TICKS + 1, "client {place} of {contender}");
    all.iter().sum()
}

fn carry(contender: Contender, wait: Wait) {
    let folder = tempfile::tempdir().unwrap();
    let mut end = server(contender, wait, folder.path()).unwrap();
    let clients: Vec<_> = (0..CLIENTS as u32)
        .map(|place| {
            let folder = folder.path().to_owned();
            std::thread::spawn(move || client_of(contender, wait, &folder, place))
        })
        .collect();
    end.gather(CLIENTS).unwrap();
    for tick in 0..TICKS {
        end.publish(&mut |frame| write_frame(frame, tick)).unwrap();
        let mut received = BTreeSet::new();
        for _ in 0..CLIENTS {
            let answer = end.next_answer().unwrap();
            let expected = answer_of(answer.participant, tick);
            assert_eq!(bytemuck::bytes_of(&answer), bytemuck::bytes_of(&expected), "tick {tick}");
            received.insert(answer.participant);
        }
        assert_eq!(received, (0..CLIENTS as u32).collect(), "tick {tick}");
    }
    end.publish(&mut |frame| write_frame(frame, TICKS)).unwrap();
    for client in clients {
        assert_eq!(client.join().unwrap(), 0, "frames of {contender} changed on the way");
    }
}

/// One that hangs fails, instead of hanging the tests.
fn in_time(contender: Contender) {
    for wait in [Wait::Block, Wait::Poll] {
        let (done, over) = mpsc::channel();
        let carrying = std::thread::spawn(move || {
            carry(contender, wait);
            let _ = done.send(());
        });
        if over.recv_timeout(PATIENCE) == Err(mpsc::RecvTimeoutError::Timeout) {
            panic!("{contender} {wait}: nothing after {PATIENCE:?}");
        }
        carrying.join().unwrap();
    }
}

#[test]
fn unix_sockets_carry_every_byte() {
    in_time(Contender::Uds);
}

#[cfg(feature = "zmq")]
#[test]
fn zmq_carries_every_byte() {
    in_time(Contender::Zmq);
}

#[cfg(feature = "zenoh")]
#[test]
fn zenoh_carries_every_byte() {
    in_time(Contender::Zenoh);
}

#[test]
fn what_is_no_frame_and_no_answer_is_refused() {
    let (frame, short) = (size_of::<Frame>(), size_of::<Answer>() - 1);
    assert!(
        answer_from("x", &vec![0; short]).unwrap_err().to_string().contains(&short.to_string())
    );
    assert!(check_frame("x", frame - 1).unwrap_err().to_string().contains(&frame.to_string()));
    assert!(check_frame("x", frame).is_ok());
    let folder = tempfile::tempdir().unwrap();
    assert!(server(Contender::Ours, Wait::Block, folder.path()).is_err());
}
