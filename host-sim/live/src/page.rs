//! The page: one module draws and, in a worker, computes the physics.

use std::cell::RefCell;
use std::rc::Rc;

use eframe::wasm_bindgen::{self, prelude::*};
use palpate_loop::live::{Choice, Holding};

use crate::app::App;
use crate::link::Link;
use crate::message::{Answer, Request};
use crate::physics::Physics;

/// The page's end of the connection to the worker.
struct Worker {
    worker: web_sys::Worker,
    came: Rc<RefCell<Vec<Answer>>>,
    _listener: Closure<dyn FnMut(web_sys::MessageEvent)>,
}

impl Worker {
    fn of(worker: web_sys::Worker) -> Self {
        let came = Rc::new(RefCell::new(Vec::new()));
        let arrivals = Rc::clone(&came);
        let listener = Closure::<dyn FnMut(web_sys::MessageEvent)>::new(move |event: web_sys::MessageEvent| {
            // page.js shows sentences; this handles only answers in bytes
            if let Ok(bytes) = event.data().dyn_into::<js_sys::Uint8Array>()
                && let Ok(answer) = postcard::from_bytes(&bytes.to_vec())
            {
                arrivals.borrow_mut().push(answer);
            }
        });
        worker.set_onmessage(Some(listener.as_ref().unchecked_ref()));
        Self { worker, came, _listener: listener }
    }
}

impl Link for Worker {
    fn send(&mut self, request: Request) {
        if let Ok(bytes) = postcard::to_allocvec(&request) {
            let _closed = self.worker.post_message(&js_sys::Uint8Array::from(bytes.as_slice()));
        }
    }

    fn poll(&mut self) -> Vec<Answer> {
        self.came.take()
    }
}

fn first() -> (Choice, Holding) {
    (Choice::preset("block"), Holding::default())
}

/// Draws into a canvas; `worker` computes the physics.
///
/// # Errors
/// The browser has no WebGL.
#[wasm_bindgen]
pub async fn draw(canvas: web_sys::HtmlCanvasElement, worker: web_sys::Worker) -> Result<(), JsValue> {
    let link = Worker::of(worker);
    let (choice, holding) = first();
    let runner = eframe::WebRunner::new();
    let app: eframe::AppCreator<'static> = Box::new(|cc| Ok(Box::new(App::new(&cc.egui_ctx, Box::new(link), choice, holding))));
    runner.start(canvas, eframe::WebOptions::default(), app).await?;
    RUNNER.with(|kept| *kept.borrow_mut() = Some(runner));
    Ok(())
}

thread_local! {
    static RUNNER: RefCell<Option<eframe::WebRunner>> = const { RefCell::new(None) };
}

/// Displayed state in numbers, as JSON, for tests and for the console.
#[wasm_bindgen]
#[must_use]
pub fn shown() -> String {
    RUNNER.with(|kept| {
        let runner = kept.borrow();
        let app = runner.as_ref().and_then(eframe::WebRunner::app_mut::<App>);
        app.map_or_else(|| "{}".into(), |app| app.numbers().to_string())
    })
}

/// The bytes of the last recording; empty if there is none.
#[wasm_bindgen]
#[must_use]
pub fn trace() -> Vec<u8> {
    RUNNER.with(|kept| {
        let runner = kept.borrow();
        let app = runner.as_ref().and_then(eframe::WebRunner::app_mut::<App>);
        app.map(|app| app.trace().to_vec()).unwrap_or_default()
    })
}

/// The physics in a worker.
#[wasm_bindgen]
pub struct PagePhysics {
    physics: Physics,
    post: js_sys::Function,
}

#[wasm_bindgen]
impl PagePhysics {
    /// Creates the physics. `post` is called with the bytes of every answer; `now_s` is real time
    /// [s].
    ///
    /// # Errors
    /// The scene does not fit.
    #[wasm_bindgen(constructor)]
    pub fn new(post: js_sys::Function, now_s: f64) -> Result<PagePhysics, JsValue> {
        let (choice, holding) = first();
        let physics = Physics::new(&choice, &holding, now_s).map_err(|e| JsValue::from_str(&e.to_string()))?;
        send(&post, &physics.body());
        Ok(Self { physics, post })
    }

    /// Handles the bytes of a request.
    pub fn take(&mut self, bytes: &[u8], clock: &js_sys::Function) {
        if let Ok(request) = postcard::from_bytes(bytes) {
            let post = &self.post;
            self.physics.take(request, &|| read(clock), &mut |answer| send(post, &answer));
        }
    }

    /// Runs the ticks that are due.
    pub fn advance(&mut self, clock: &js_sys::Function) {
        let post = &self.post;
        self.physics.advance(&|| read(clock), &mut |answer| send(post, &answer));
    }
}

/// Reads real time from a JavaScript function [s].
fn read(clock: &js_sys::Function) -> f64 {
    clock.call0(&JsValue::NULL).ok().and_then(|t| t.as_f64()).unwrap_or_default()
}

fn send(post: &js_sys::Function, answer: &Answer) {
    if let Ok(bytes) = postcard::to_allocvec(answer) {
        let _closed = post.call1(&JsValue::NULL, &js_sys::Uint8Array::from(bytes.as_slice()));
    }
}
