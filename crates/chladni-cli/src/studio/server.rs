//! The server of the studio's page and its questions. One thread answers; others fit and
//! render.

use super::question::{DataQuestion, FileQuestion, FitQuestion, MeasuredQuestion, SceneQuestion};
use super::session::Session;
use super::token::Token;
use crate::limits::{LARGEST_QUESTION, PAUSE, REQUEST_DEADLINE};
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{header, HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::middleware::{from_fn_with_state, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use chladni_frf::Result;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use serde_json::{json, Value};
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use tokio::net::TcpStream;

/// The check of every request: to this address, from its own page, with the token.
pub struct Door {
    /// The address that is listened on.
    pub address: SocketAddr,
    /// The token that must be shown.
    pub token: Token,
}

impl Door {
    /// The address of the page, with the token in it.
    pub fn url(&self) -> String {
        format!("http://{}/?token={}", self.address, self.token)
    }

    /// The page's address carries the token; its questions carry it in a header, which a
    /// page of another site cannot set unasked.
    fn admits(&self, request: &Request) -> bool {
        let shown = match request.uri().path() {
            "/" => request
                .uri()
                .query()
                .and_then(|query| query.strip_prefix("token=")),
            _ => text(request.headers(), header::AUTHORIZATION)
                .and_then(|words| words.strip_prefix("Bearer ")),
        };
        // without a shortcut, so that the time does not tell which of them failed
        self.token.is(shown.unwrap_or_default()) & self.is_from_here(request.headers())
    }

    /// False for pages of other sites, which reach this port by another host name or send
    /// another origin.
    fn is_from_here(&self, headers: &HeaderMap) -> bool {
        let here = [
            self.address.to_string(),
            format!("localhost:{}", self.address.port()),
        ];
        let host =
            text(headers, header::HOST).is_some_and(|host| here.iter().any(|known| known == host));
        host && text(headers, header::ORIGIN)
            .is_none_or(|origin| here.iter().any(|known| origin == format!("http://{known}")))
    }
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

/// Serves `session` until the process ends.
///
/// # Errors
/// A listener that stops working.
pub fn serve(session: Arc<Session>, listener: TcpListener, door: Door) -> std::io::Result<()> {
    let routes = Router::new()
        .route("/", get(page))
        .route("/api/start", post(start))
        .route("/api/fit", post(fit))
        .route("/api/data", post(data))
        .route("/api/progress", post(progress))
        .route("/api/cancel", post(cancel))
        .route("/api/scene", post(scene))
        .route("/api/sweep", post(sweep))
        .route("/api/time", post(in_time))
        .route("/api/measured", post(measured))
        .route("/api/correct", post(correct))
        .route("/api/file", post(file))
        .layer(DefaultBodyLimit::max(LARGEST_QUESTION))
        .layer(from_fn_with_state(Arc::new(door), only_who_may))
        .with_state(session);
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        loop {
            match listener.accept().await {
                Ok((stream, _)) => drop(tokio::spawn(answer(stream, routes.clone()))),
                // too many connections: wait until some are closed
                Err(_) => tokio::time::sleep(PAUSE).await,
            }
        }
    })
}

/// Answers the requests of one connection; a late one closes it.
async fn answer(stream: TcpStream, routes: Router) {
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REQUEST_DEADLINE)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(routes));
    // a connection that was closed early or was too slow gets no answer
    drop(connection.await);
}

/// Refuses requests that the door does not admit, before their content is read.
async fn only_who_may(State(door): State<Arc<Door>>, request: Request, next: Next) -> Response {
    let mut answer = match door.admits(&request) {
        true => next.run(request).await,
        false => (
            StatusCode::FORBIDDEN,
            "the studio answers its own page only: open the address that it printed\n",
        )
            .into_response(),
    };
    answer.headers_mut().extend(discreet());
    answer
}

/// The headers of every answer: no cache, no referrer, no frame on another page, no guessing
/// of types.
fn discreet() -> [(HeaderName, HeaderValue); 4] {
    [
        (header::CACHE_CONTROL, "no-store"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ]
    .map(|(name, value)| (name, HeaderValue::from_static(value)))
}

async fn page(State(session): State<Arc<Session>>) -> Html<String> {
    Html(session.page())
}

async fn start(State(session): State<Arc<Session>>) -> Json<Value> {
    at_work(move || session.start()).await
}

async fn progress(State(session): State<Arc<Session>>) -> Json<Value> {
    Json(session.progress.value())
}

async fn cancel(State(session): State<Arc<Session>>) -> Json<Value> {
    at_work(move || session.cancel()).await
}

async fn fit(
    State(session): State<Arc<Session>>,
    Json(question): Json<FitQuestion>,
) -> Json<Value> {
    at_work(move || session.fit(&question)).await
}

async fn data(
    State(session): State<Arc<Session>>,
    Json(question): Json<DataQuestion>,
) -> Json<Value> {
    at_work(move || session.data(&question)).await
}

async fn scene(
    State(session): State<Arc<Session>>,
    Json(question): Json<SceneQuestion>,
) -> Json<Value> {
    at_work(move || session.render(&question)).await
}

async fn sweep(
    State(session): State<Arc<Session>>,
    Json(question): Json<SceneQuestion>,
) -> Json<Value> {
    at_work(move || session.sweep(&question)).await
}

async fn in_time(
    State(session): State<Arc<Session>>,
    Json(question): Json<SceneQuestion>,
) -> Json<Value> {
    at_work(move || session.in_time(&question)).await
}

async fn measured(
    State(session): State<Arc<Session>>,
    Json(question): Json<MeasuredQuestion>,
) -> Json<Value> {
    at_work(move || session.measured(&question)).await
}

async fn correct(
    State(session): State<Arc<Session>>,
    Json(question): Json<MeasuredQuestion>,
) -> Json<Value> {
    at_work(move || session.correct(&question)).await
}

/// The bytes of a file, which the page offers as a download.
async fn file(State(session): State<Arc<Session>>, Json(question): Json<FileQuestion>) -> Response {
    match tokio::task::spawn_blocking(move || session.file(&question)).await {
        Ok(Ok(bytes)) => {
            ([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response()
        }
        Ok(Err(error)) => (StatusCode::UNPROCESSABLE_ENTITY, error.to_string()).into_response(),
        Err(bug) => (
            StatusCode::INTERNAL_SERVER_ERROR,
            format!("internal error: {bug}"),
        )
            .into_response(),
    }
}

/// Runs `work` on a thread of its own; an error or a panic becomes an answer in words.
async fn at_work(work: impl FnOnce() -> Result<Value> + Send + 'static) -> Json<Value> {
    Json(match tokio::task::spawn_blocking(work).await {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => json!({ "error": error.to_string() }),
        Err(bug) => json!({ "error": format!("internal error: {bug}") }),
    })
}
