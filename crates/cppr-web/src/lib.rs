//! The session of the live view ([`cppr_viewer::session`]) for a page that solves by itself: the messages that a
//! server takes and gives go to and from JavaScript instead. `build.sh` makes the module, a worker of the page runs it.

use cppr_io::bundle_file;
use cppr_viewer::message::Message;
use cppr_viewer::session::{Request, Session, problem};
use js_sys::{Function, Uint8Array};
use wasm_bindgen::prelude::{JsError, JsValue, wasm_bindgen};

/// One page's session.
#[wasm_bindgen]
pub struct Kernel {
    session: Session,
}

#[wasm_bindgen]
impl Kernel {
    /// Begins with the text of a robot file.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    #[wasm_bindgen(constructor)]
    pub fn new(robot: &str) -> Result<Kernel, JsError> {
        Ok(Self { session: Session::new(bundle_file::parse_either(robot)?, None) })
    }

    /// Answers one message of the page; `say` is called with each answer, a string or a `Uint8Array`.
    pub fn answer(&mut self, request: &str, say: &Function) {
        match serde_json::from_str::<Request>(request) {
            Ok(request) => self.session.answer(request, &mut |message| tell(say, message)),
            Err(error) => tell(say, problem(&format!("the message is not understood: {error}"))),
        };
    }

    /// Solves some poses of the workspace, where one was asked for; true while there is more to do.
    pub fn background(&mut self, say: &Function) -> bool {
        if self.session.has_background_work() {
            self.session.background(&mut |message| tell(say, message));
        }
        self.session.has_background_work()
    }
}

/// False where the page throws: it is gone then.
fn tell(say: &Function, message: Message) -> bool {
    let value: JsValue = match message {
        Message::Text(text) => text.into(),
        Message::Binary(bytes) => Uint8Array::from(bytes.as_slice()).into(),
    };
    say.call1(&JsValue::NULL, &value).is_ok()
}
