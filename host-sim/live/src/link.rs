//! Connects the drawing to the physics, which runs in a thread, or in a worker of the page.

use crate::message::{Answer, Request};

/// The link to the physics.
pub trait Link {
    /// Sends a request.
    fn send(&mut self, request: Request);

    /// Returns the answers received since the last call.
    fn poll(&mut self) -> Vec<Answer>;
}

#[cfg(not(target_family = "wasm"))]
pub mod thread {
    //! The physics in a thread, which wakes every millisecond.

    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::time::Duration;

    use palpate_loop::live::{Choice, Holding};
    use web_time::Instant;

    use super::Link;
    use crate::message::{Answer, Request};
    use crate::physics::Physics;

    /// The drawing's ends of the channels to and from the thread.
    pub struct Thread {
        requests: Sender<Request>,
        answers: Receiver<Answer>,
    }

    impl Thread {
        /// Starts the physics. A scene that cannot be used is reported as an answer.
        #[must_use]
        pub fn start(choice: Choice, holding: Holding) -> Self {
            let (requests, asked) = channel();
            let (answering, answers) = channel();
            std::thread::spawn(move || run(&choice, &holding, &asked, &answering));
            Self { requests, answers }
        }
    }

    impl Link for Thread {
        fn send(&mut self, request: Request) {
            // a thread that has ended has already reported the reason
            let _ended = self.requests.send(request);
        }

        fn poll(&mut self) -> Vec<Answer> {
            self.answers.try_iter().collect()
        }
    }

    fn run(choice: &Choice, holding: &Holding, asked: &Receiver<Request>, answering: &Sender<Answer>) {
        let begun = Instant::now();
        let clock = || begun.elapsed().as_secs_f64();
        let mut answer = |a: Answer| {
            let _closed = answering.send(a);
        };
        let mut physics = match Physics::new(choice, holding, clock()) {
            Ok(physics) => physics,
            Err(error) => {
                answer(Answer::Refused(error.to_string()));
                match Physics::new(&Choice::preset("block"), &Holding::default(), clock()) {
                    Ok(physics) => physics,
                    Err(_) => return,
                }
            }
        };
        answer(physics.body());
        loop {
            match asked.recv_timeout(Duration::from_micros(700)) {
                Ok(request) => physics.take(request, &clock, &mut answer),
                Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => return,
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
            }
            while let Ok(request) = asked.try_recv() {
                physics.take(request, &clock, &mut answer);
            }
            physics.advance(&clock, &mut answer);
        }
    }
}
