//! The server: three files and one WebSocket below a secret path.

use crate::guard;
use crate::live::{self, Limit};
use crate::session::Session;
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{any, get};
use cppr_io::Scenario;
use cppr_io::bundle_file::Described;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use tokio::net::TcpListener;

/// Largest message of the page (bytes): a robot file as a JSON string.
const LARGEST: usize = 4 * cppr_io::robot_file::LARGEST;
/// What the page may load and talk to: this server, and pictures that it makes itself.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What to serve, and where.
pub struct Options {
    /// The robot that a new page shows.
    pub robot: Described,
    /// What is asked of it at first.
    pub scenario: Option<Scenario>,
    /// Port of the loopback address; 0 for a free one.
    pub port: u16,
    /// Open the page in the browser?
    pub open: bool,
}

struct Shared {
    robot: Described,
    scenario: Option<Scenario>,
    port: u16,
    limit: Limit,
}

/// Serves until Ctrl-C. `ready` is called with the address of the page once it can be opened.
///
/// # Errors
/// Where the port cannot be had, or the system gives no random numbers.
pub fn serve(options: Options, ready: impl FnOnce(&str)) -> io::Result<()> {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let token = guard::token()?;
    runtime.block_on(async {
        // Before anything is said, so that no interrupt is missed.
        let interrupt = tokio::signal::ctrl_c();
        let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, options.port))).await?;
        let port = listener.local_addr()?.port();
        let shared = Arc::new(Shared {
            robot: options.robot,
            scenario: options.scenario,
            port,
            limit: Limit::default(),
        });
        let address = format!("http://127.0.0.1:{port}/{token}/");
        ready(&address);
        if options.open {
            // Without a browser the address that was printed is enough.
            let _ = open::that_detached(&address);
        }
        let serving = axum::serve(listener, router(shared, &token)).into_future();
        tokio::select! {
            result = serving => result,
            result = interrupt => result,
        }
    })
    // Dropping the runtime closes every connection; each solver ends with its own.
}

fn router(shared: Arc<Shared>, token: &str) -> Router {
    let asset =
        |kind: &'static str, text: &'static str| get(async move || ([(header::CONTENT_TYPE, kind)], text));
    let page = Router::new()
        .route("/", asset("text/html; charset=utf-8", include_str!("../dist/index.html")))
        .route("/viewer.js", asset("text/javascript; charset=utf-8", include_str!("../dist/viewer.js")))
        .route("/viewer.css", asset("text/css; charset=utf-8", include_str!("../dist/viewer.css")))
        .route("/live", any(upgrade));
    Router::new()
        .nest(&format!("/{token}/"), page)
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), own_page_only))
        .with_state(shared)
}

async fn own_page_only(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    if !guard::is_own(request.headers(), shared.port) {
        return StatusCode::FORBIDDEN.into_response();
    }
    let mut response = next.run(request).await;
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn upgrade(State(shared): State<Arc<Shared>>, socket: WebSocketUpgrade) -> Response {
    let Some(place) = shared.limit.enter() else {
        return StatusCode::SERVICE_UNAVAILABLE.into_response();
    };
    socket.max_message_size(LARGEST).on_upgrade(async move |socket| {
        let session = Session::new(shared.robot.clone(), shared.scenario.clone());
        live::run(socket, session, place).await;
    })
}
