//! One connection: messages in, a solver in a thread of its own, shapes out.
//!
//! Requests to solve wait in a place for one: a newer one replaces the one that waits. Answers go through
//! a short queue; while it is full the solver waits, and what the page asks meanwhile is merged.

use crate::message::Message as Answer;
use crate::session::{Request, Session, Solve};
use axum::extract::ws::{Message, WebSocket};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use tokio::sync::mpsc;

/// Most connections at a time: tabs of one person.
const MOST: usize = 32;
/// Answers that may wait for the page.
const QUEUE: usize = 4;
/// Requests other than to solve that may wait.
const TASKS: usize = 8;

/// Counts connections.
#[derive(Clone, Default)]
pub struct Limit(Arc<()>);

/// A connection's place, given back when dropped.
pub struct Place(#[allow(dead_code, reason = "held, not read")] Arc<()>);

impl Limit {
    /// A place, where one is free.
    pub fn enter(&self) -> Option<Place> {
        (Arc::strong_count(&self.0) <= MOST).then(|| Place(Arc::clone(&self.0)))
    }
}

/// What waits for the solver.
#[derive(Default)]
struct Waiting {
    solve: Option<Box<Solve>>,
    tasks: VecDeque<Request>,
    closed: bool,
}

/// Between the connection and its solver.
#[derive(Default)]
struct Inbox {
    waiting: Mutex<Waiting>,
    wake: Condvar,
    /// Set while something waits; ends what is done in the background.
    hurry: Arc<AtomicBool>,
}

/// What the solver is to do next.
enum Next {
    Request(Request),
    Background,
    End,
}

impl Inbox {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// False where too much waits already.
    fn put(&self, request: Request) -> bool {
        let mut waiting = self.lock();
        self.hurry.store(true, Ordering::Relaxed);
        match request {
            Request::Solve(solve) => waiting.solve = Some(solve),
            _ if waiting.tasks.len() >= TASKS => return false,
            task => waiting.tasks.push_back(task),
        }
        self.wake.notify_one();
        true
    }

    fn close(&self) {
        self.lock().closed = true;
        self.hurry.store(true, Ordering::Relaxed);
        self.wake.notify_one();
    }

    /// The next request; waits for one unless there is background work. Tasks come first: a solve that
    /// came before a new robot would answer for the old one.
    fn next(&self, background: bool) -> Next {
        let mut waiting = self.lock();
        loop {
            if waiting.closed {
                return Next::End;
            }
            if let Some(task) = waiting.tasks.pop_front() {
                return Next::Request(task);
            }
            if let Some(solve) = waiting.solve.take() {
                return Next::Request(Request::Solve(solve));
            }
            self.hurry.store(false, Ordering::Relaxed);
            if background {
                return Next::Background;
            }
            waiting = self.wake.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Runs a connection to its end.
pub async fn run(mut socket: WebSocket, first: Session, place: Place) {
    let inbox = Arc::new(Inbox { hurry: first.stop(), ..Inbox::default() });
    let (sender, mut answers) = mpsc::channel(QUEUE);
    let own = Arc::clone(&inbox);
    let refused = sender.clone();
    std::thread::spawn(move || work(&own, first, &sender, place));
    loop {
        tokio::select! {
            answer = answers.recv() => {
                let Some(answer) = answer else { break };
                if socket.send(wire(answer)).await.is_err() {
                    break;
                }
            }
            message = socket.recv() => {
                let Some(Ok(message)) = message else { break };
                if let Err(problem) = take(message, &inbox) {
                    // Where the page does not read its answers it need not be told.
                    let _ = refused.try_send(crate::session::problem(&problem));
                }
            }
        }
    }
    inbox.close();
}

fn wire(answer: Answer) -> Message {
    match answer {
        Answer::Text(text) => Message::Text(text.into()),
        Answer::Binary(bytes) => Message::Binary(bytes.into()),
    }
}

/// Puts what the page says where the solver finds it, or says why not.
fn take(message: Message, inbox: &Inbox) -> Result<(), String> {
    match message {
        Message::Text(text) => {
            let request =
                serde_json::from_str(&text).map_err(|e| format!("the message is not understood: {e}"))?;
            if inbox.put(request) {
                Ok(())
            } else {
                Err("too many requests wait; this one was dropped".into())
            }
        }
        Message::Binary(_) => Err("the page sends text, not binary messages".into()),
        // After a closing message the socket ends by itself.
        Message::Ping(_) | Message::Pong(_) | Message::Close(_) => Ok(()),
    }
}

fn work(inbox: &Inbox, mut session: Session, answers: &mpsc::Sender<Answer>, _place: Place) {
    let mut send = |message| answers.blocking_send(message).is_ok();
    let mut going = true;
    while going {
        going = match inbox.next(session.has_background_work()) {
            Next::Request(request) => session.answer(request, &mut send),
            Next::Background => session.background(&mut send),
            Next::End => false,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::{Inbox, Limit, MOST, Next, TASKS};
    use crate::session::{Request, Solve};

    #[test]
    fn the_newest_solve_wins() {
        let inbox = Inbox::default();
        for id in 0..1000 {
            assert!(inbox.put(Request::Solve(Box::new(Solve { id, ..Solve::default() }))));
        }
        assert!(matches!(inbox.next(false), Next::Request(Request::Solve(solve)) if solve.id == 999));
        assert!(matches!(inbox.next(true), Next::Background));
        inbox.close();
        assert!(matches!(inbox.next(false), Next::End));
    }

    #[test]
    fn tasks_do_not_pile_up() {
        let inbox = Inbox::default();
        let task = || Request::Robot(None);
        assert!((0..TASKS).all(|_| inbox.put(task())));
        assert!(!inbox.put(task()));
    }

    #[test]
    fn places_are_given_back() {
        let limit = Limit::default();
        let places: Vec<_> = (0..MOST).filter_map(|_| limit.enter()).collect();
        assert_eq!(places.len(), MOST);
        assert!(limit.enter().is_none());
        drop(places);
        assert!(limit.enter().is_some());
    }
}
